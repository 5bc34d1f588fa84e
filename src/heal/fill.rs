//! Closing a contour: ear cutting, flips while the area falls, refinement to the surrounding size.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashSet;

use super::sides::key;
use crate::error::Result;
use crate::mesh::{EditMesh, TriMesh};
use crate::numeric::predicates::orient2d;

/// Longest contour the dynamic program is used for; it costs the cube of this.
const LONGEST_OPTIMAL: usize = 240;

/// Rounds of refinement; each about halves the edges.
const ROUNDS: usize = 12;

/// A filling of more triangles than this, and than the mesh has, is refined no further: its contour is very fine for its width.
const LARGEST: usize = 20_000;

/// How to triangulate a contour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FillingWay {
    /// Ear cutting, as \[BOR20\].
    Ears,
    /// The triangulation with the smallest worst bend, then area: P. Liepa, "Filling holes in meshes" (2003).
    Bend,
    /// The triangulation with the smallest area.
    Area,
    /// A fan around a new node in the middle.
    Fan,
}

/// What a filling must know of the mesh it closes.
pub(super) struct HoleSurroundings<'a> {
    pub(super) mesh: &'a TriMesh,
    /// Edges in use: a filling must not draw them again.
    pub(super) edges: &'a FxHashSet<u64>,
    /// Mean length of the edges at each node.
    pub(super) size: &'a [f64],
    /// For each directed open side, as `start << 32 | end`, the node opposite to it.
    pub(super) apex: &'a rustc_hash::FxHashMap<u64, u32>,
}

/// A filling: nodes that are new, numbered on from those of the mesh, and triangles.
#[derive(Debug, Clone, Default)]
pub(super) struct HoleFilling {
    pub(super) nodes: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Closes the contour, whose nodes follow the open sides. `None` if this way knows no triangulation without drawing an
/// edge that exists already.
pub(super) fn fill(
    around: &HoleSurroundings<'_>,
    contour: &[u32],
    way: FillingWay,
    refine: bool,
) -> Result<Option<HoleFilling>> {
    let ring: Vec<u32> = contour.iter().rev().copied().collect();
    let triangles = match way {
        _ if ring.len() < 3 => None,
        FillingWay::Fan => {
            let n = around.mesh.nodes.len() as u32;
            let middle = ring.iter().map(|v| around.mesh.nodes[*v as usize]).sum::<DVec3>() / ring.len() as f64;
            let triangles = (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()], n]).collect();
            return finish(around, &ring, vec![middle], triangles, refine).map(Some);
        }
        FillingWay::Ears => ears(around, &ring),
        FillingWay::Bend | FillingWay::Area if ring.len() <= LONGEST_OPTIMAL => {
            optimal(around, &ring, way == FillingWay::Bend)
        }
        FillingWay::Bend | FillingWay::Area => None,
    };
    triangles.map(|t| finish(around, &ring, Vec::new(), t, refine)).transpose()
}

/// Unit normal of a ring and two axes across it.
fn frame(p: &[DVec3]) -> (DVec3, DVec3, DVec3) {
    let o = p[0];
    let n: DVec3 = (0..p.len()).map(|i| (p[i] - o).cross(p[(i + 1) % p.len()] - o)).sum();
    let n = n.try_normalize().unwrap_or(DVec3::Z);
    let (u, v) = n.any_orthonormal_pair();
    (n, u, v)
}

/// Cuts off ears, the sharpest first. An ear turns left seen along the ring's normal, holds no other node of the ring and
/// needs no edge that exists; where none is left the sharpest corner with an allowed edge goes.
fn ears(around: &HoleSurroundings<'_>, ring: &[u32]) -> Option<Vec<[u32; 3]>> {
    let p: Vec<DVec3> = ring.iter().map(|v| around.mesh.nodes[*v as usize]).collect();
    let (_, u, v) = frame(&p);
    let q: Vec<DVec2> = p.iter().map(|x| DVec2::new((*x - p[0]).dot(u), (*x - p[0]).dot(v))).collect();
    let n = ring.len();
    let (mut next, mut prev): (Vec<usize>, Vec<usize>) =
        ((0..n).map(|i| (i + 1) % n).collect(), (0..n).map(|i| (i + n - 1) % n).collect());
    let mut live = vec![true; n];
    let mut drawn: FxHashSet<u64> = FxHashSet::default();
    let angle = |a: usize, b: usize, c: usize| (p[a] - p[b]).angle_between(p[c] - p[b]);
    let is_ear = |i: usize, next: &[usize], prev: &[usize], live: &[bool]| {
        let (a, c) = (prev[i], next[i]);
        if orient2d(q[a], q[i], q[c]) <= 0.0 {
            return false;
        }
        let (lo, hi) = (q[a].min(q[i]).min(q[c]), q[a].max(q[i]).max(q[c]));
        (0..n).all(|j| {
            !live[j]
                || j == a
                || j == i
                || j == c
                || !(lo.cmple(q[j]).all() && q[j].cmple(hi).all())
                || orient2d(q[a], q[i], q[j]) < 0.0
                || orient2d(q[i], q[c], q[j]) < 0.0
                || orient2d(q[c], q[a], q[j]) < 0.0
        })
    };
    let mut ear: Vec<bool> = (0..n).map(|i| is_ear(i, &next, &prev, &live)).collect();
    let mut out = Vec::with_capacity(n - 2);
    for left in (4..=n).rev() {
        let allowed = |i: usize, drawn: &FxHashSet<u64>| {
            let k = key(ring[prev[i]], ring[next[i]]);
            left == 3 || !(around.edges.contains(&k) || drawn.contains(&k))
        };
        let pick = |only_ears: bool| {
            (0..n)
                .filter(|i| live[*i] && (ear[*i] || !only_ears) && allowed(*i, &drawn))
                .min_by(|i, j| angle(prev[*i], *i, next[*i]).total_cmp(&angle(prev[*j], *j, next[*j])))
        };
        let i = pick(true).or_else(|| pick(false))?;
        let (a, c) = (prev[i], next[i]);
        out.push([ring[a], ring[i], ring[c]]);
        drawn.insert(key(ring[a], ring[c]));
        live[i] = false;
        next[a] = c;
        prev[c] = a;
        for j in [a, c] {
            ear[j] = is_ear(j, &next, &prev, &live);
        }
    }
    let i = (0..n).find(|i| live[*i])?;
    out.push([ring[prev[i]], ring[i], ring[next[i]]]);
    Some(out)
}

/// The best triangulation by a dynamic program over pairs of ring nodes; `bend` weighs the largest angle between neighbors
/// (those outside included) before the area.
fn optimal(around: &HoleSurroundings<'_>, ring: &[u32], bend: bool) -> Option<Vec<[u32; 3]>> {
    let n = ring.len();
    let p: Vec<DVec3> = ring.iter().map(|v| around.mesh.nodes[*v as usize]).collect();
    let normal = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a);
    // the outer triangle at ring edge (i, j), which runs j -> i there
    let outer = |i: usize, j: usize| {
        let x = around.apex.get(&(u64::from(ring[j]) << 32 | u64::from(ring[i])))?;
        Some(normal(p[j], p[i], around.mesh.nodes[*x as usize]))
    };
    // what cannot be filled has this weight
    let mut weight = vec![(f64::INFINITY, f64::INFINITY); n * n];
    let mut via = vec![usize::MAX; n * n];
    // the normal of the triangle at a pair of ring nodes, on the pair's inner side
    let mut facing = vec![DVec3::ZERO; n * n];
    let at = |i: usize, j: usize| i * n + j;
    for i in 0..n - 1 {
        weight[at(i, i + 1)] = (-1.0, 0.0);
        facing[at(i, i + 1)] = outer(i, i + 1).unwrap_or(DVec3::ZERO);
    }
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            if span < n - 1 && around.edges.contains(&key(ring[i], ring[j])) {
                continue;
            }
            let last = if span == n - 1 { outer(j, i).unwrap_or(DVec3::ZERO) } else { DVec3::ZERO };
            for k in i + 1..j {
                let (l, r) = (weight[at(i, k)], weight[at(k, j)]);
                if l.0.is_infinite() || r.0.is_infinite() {
                    continue;
                }
                let mut worst = l.0.max(r.0);
                // it gets no better than that
                if worst > weight[at(i, j)].0 {
                    continue;
                }
                let m = normal(p[i], p[k], p[j]);
                if bend {
                    for o in [facing[at(i, k)], facing[at(k, j)], last] {
                        // the negative cosine orders angles as they are; a triangle on a line has none
                        worst = worst.max(-m.dot(o) / (m.length_squared() * o.length_squared()).sqrt());
                    }
                }
                let w = (worst, l.1 + r.1 + m.length());
                if w < weight[at(i, j)] {
                    weight[at(i, j)] = w;
                    via[at(i, j)] = k;
                    facing[at(i, j)] = m;
                }
            }
        }
    }
    if weight[at(0, n - 1)].0.is_infinite() {
        return None;
    }
    let (mut out, mut stack) = (Vec::with_capacity(n - 2), vec![(0, n - 1)]);
    while let Some((i, j)) = stack.pop() {
        if j > i + 1 {
            let k = via[at(i, j)];
            out.push([ring[i], ring[k], ring[j]]);
            stack.extend([(i, k), (k, j)]);
        }
    }
    Some(out)
}

/// Flips and refines in a mesh of the filling alone, then numbers it as the whole mesh does.
fn finish(
    around: &HoleSurroundings<'_>,
    ring: &[u32],
    new: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    refine: bool,
) -> Result<HoleFilling> {
    let first = around.mesh.nodes.len() as u32;
    let r = ring.len() as u32;
    let local: rustc_hash::FxHashMap<u32, u32> = ring.iter().enumerate().map(|(i, v)| (*v, i as u32)).collect();
    let mut nodes: Vec<DVec3> = ring.iter().map(|v| around.mesh.nodes[*v as usize]).collect();
    nodes.extend(new);
    let to_local = |v: u32| if v >= first { v - first + r } else { local[&v] };
    let patch = TriMesh::new(nodes, triangles.iter().map(|t| t.map(to_local)).collect());
    let mut edit = EditMesh::new(&patch)?;
    let free = |c: u32, d: u32| c >= r || d >= r || !around.edges.contains(&key(ring[c as usize], ring[d as usize]));
    shrink(&mut edit, free);
    if refine {
        densify(&mut edit, ring, around, free);
    }
    let patch = edit.to_mesh();
    // the ring's nodes are all in use, so they keep their places
    let to_global = |v: u32| if v < r { ring[v as usize] } else { v - r + first };
    Ok(HoleFilling {
        nodes: patch.nodes[ring.len()..].to_vec(),
        triangles: patch.triangles.iter().map(|t| t.map(to_global)).collect(),
    })
}

/// Flips edges that may be flipped and gain by it, until none does. `gains` gets the ends and the two opposite nodes.
fn flip_while(edit: &mut EditMesh, free: impl Fn(u32, u32) -> bool, gains: impl Fn([DVec3; 4]) -> bool) {
    for _ in 0..ROUNDS {
        let mut changed = false;
        for h in 0..3 * edit.triangle_capacity() as u32 {
            if !edit.is_triangle(h / 3) || !edit.is_edge(h) || !edit.can_flip(h) {
                continue;
            }
            let (c, d) = (edit.apex(h), edit.apex(edit.opposite(h)));
            let points = [edit.origin(h), edit.target(h), c, d].map(|v| edit.point(v));
            if free(c, d) && gains(points) {
                changed |= edit.flip(h);
            }
        }
        if !changed {
            return;
        }
    }
}

/// \[BOR20\]: flips edges while the total area falls.
fn shrink(edit: &mut EditMesh, free: impl Fn(u32, u32) -> bool) {
    let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).length();
    flip_while(edit, free, |[a, b, c, d]| {
        let (before, after) = (area(a, b, c) + area(b, a, d), area(a, d, c) + area(d, b, c));
        // a gain that rounding could have made is none, so the flips end
        after < before * (1.0 - 1e-12)
    });
}

/// Puts nodes into triangles that are large for their surroundings and flips edges toward Delaunay's rule, as P. Liepa.
fn densify(edit: &mut EditMesh, ring: &[u32], around: &HoleSurroundings<'_>, free: impl Fn(u32, u32) -> bool + Copy) {
    let most = LARGEST.max(around.mesh.triangles.len());
    let mut size: Vec<f64> = ring.iter().map(|v| around.size[*v as usize]).collect();
    let mean = size.iter().sum::<f64>() / size.len() as f64;
    size.resize(edit.node_capacity(), mean);
    for _ in 0..ROUNDS {
        let mut changed = false;
        for t in 0..edit.triangle_capacity() as u32 {
            let corners = edit.corners(t);
            let c = edit.centroid(t);
            let s = corners.iter().map(|v| size[*v as usize]).sum::<f64>() / 3.0;
            let far = |v: u32| {
                let d = std::f64::consts::SQRT_2 * c.distance(edit.point(v));
                d > s && d > size[v as usize]
            };
            if corners.iter().all(|v| far(*v)) {
                edit.split_triangle(t, c);
                size.push(s);
                changed = true;
            }
        }
        if !changed || edit.triangle_capacity() > most {
            return;
        }
        relax(edit, free);
    }
}

/// Flips edges whose opposite angles sum to more than a half turn, where the two triangles are nearly in one plane.
fn relax(edit: &mut EditMesh, free: impl Fn(u32, u32) -> bool) {
    let bent = |m: DVec3, n: DVec3| !(m.dot(n) > 0.9 * m.length() * n.length());
    flip_while(edit, free, |[a, b, c, d]| {
        let angles = (a - c).angle_between(b - c) + (a - d).angle_between(b - d);
        let (m, n) = ((b - a).cross(c - a), (a - b).cross(d - b));
        let (m2, n2) = ((d - a).cross(c - a), (b - d).cross(c - d));
        angles > std::f64::consts::PI * (1.0 + 1e-9) && !bent(m2, n2) && !bent(m, m2) && !bent(n, n2)
    });
}
