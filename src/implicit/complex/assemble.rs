//! From the facets of all tetrahedra to one mesh: common nodes, triangles, copies where inside sectors touch.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::cell::{Crossed, Facet, Named, Vertex};
use super::grid::{Octree, Point};

/// What a node is: the grid points of the simplex it lies in, and the leaves that vanish there, both ascending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Key {
    pub(super) points: [u64; 4],
    pub(super) leaves: [u32; 3],
}

impl Key {
    /// The grid points.
    pub(super) fn corners(&self) -> impl Iterator<Item = Point> + '_ {
        self.points.iter().filter(|p| **p != u64::MAX).map(|p| Point(*p))
    }

    /// What tells it from all others on faces of tetrahedra.
    pub(super) fn packed(&self) -> [u64; 4] {
        let [a, b, c, _] = self.points;
        [a, b, c, u64::from(self.leaves[0]) << 32 | u64::from(self.leaves[1])]
    }

    /// The leaves.
    pub(super) fn on(&self) -> Vec<u32> {
        self.leaves.iter().copied().filter(|l| *l != NONE).collect()
    }
}

/// Nodes nearer to a side of a triangle than this share of its longest side lie on it: nodes are known to a few units in the last
/// place of the part's own coordinates.
const ROUNDING: f64 = 1e-9;

/// Nothing there.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle of the boundary.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) nodes: [u32; 3],
    pub(super) leaf: u32,
    /// Whether the leaf's positive side is inside.
    pub(super) plus: bool,
    pub(super) face: u32,
    /// Where its tetrahedron lies along each axis: in the block that is asked for (0), below it (-1) or above.
    pub(super) side: [i8; 3],
}

impl Triangle {
    /// Whether it is of the block that is asked for, and not beside it.
    pub(super) fn is_own(&self) -> bool {
        self.side == [0; 3]
    }
}

/// The boundary within some tetrahedra, with nodes of its own.
#[derive(Default)]
pub(super) struct Skin {
    pub(super) keys: Vec<Key>,
    pub(super) places: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    index: FxHashMap<Key, u32>,
    /// That of the triangles to come.
    pub(super) side: [i8; 3],
}

impl Skin {
    fn node(&mut self, key: Key, place: DVec3) -> u32 {
        let Self { keys, places, index, .. } = self;
        *index.entry(key).or_insert_with(|| {
            keys.push(key);
            places.push(place);
            keys.len() as u32 - 1
        })
    }

    /// Adds the facets of one tetrahedron.
    pub(super) fn add(&mut self, tree: &Octree, corners: &[Point; 4], cut: &Crossed<'_>, facets: &[Facet]) {
        let (points, side) = (corners.map(|p| tree.point(p)), self.side);
        for f in facets {
            let mut rings: Vec<Vec<(u32, DVec3)>> = Vec::new();
            for ring in &f.loops {
                let mut nodes = Vec::with_capacity(ring.len());
                for v in ring {
                    let (key, place) = (key(corners, cut, facets, v), place(corners, &points, cut, v));
                    let n = self.node(key, place);
                    nodes.push((n, self.places[n as usize]));
                }
                rings.push(nodes);
            }
            let ring = bridged(rings);
            let (plus, Named { leaf, face }) = (f.plus, f.named);
            triangulate(ring, &mut |nodes| self.triangles.push(Triangle { nodes, leaf, plus, face, side }));
        }
    }

    /// Adds what another piece has.
    pub(super) fn append(&mut self, other: &Skin) {
        let to: Vec<u32> = other.keys.iter().zip(&other.places).map(|(k, p)| self.node(*k, *p)).collect();
        self.triangles
            .extend(other.triangles.iter().map(|t| Triangle { nodes: t.nodes.map(|n| to[n as usize]), ..*t }));
    }
}

/// The leaf that a point on one lies on by name: that of the facets around it, if these agree.
fn named(cut: &Crossed<'_>, facets: &[Facet], place: u8, v: &Vertex) -> u32 {
    let first = cut.leaves[place as usize];
    let mut around = facets.iter().filter(|f| f.leaf == place && f.loops.iter().any(|l| l.contains(v)));
    let Some(name) = around.next().map(|f| f.named.leaf) else { return first };
    if around.all(|f| f.named.leaf == name) { name } else { first }
}

fn key(corners: &[Point; 4], cut: &Crossed<'_>, facets: &[Facet], v: &Vertex) -> Key {
    let mut points = [u64::MAX; 4];
    let mut n = 0;
    for c in (0..4).filter(|c| v.corners >> c & 1 == 1) {
        points[n] = corners[c].0;
        n += 1;
    }
    points.sort_unstable();
    let mut leaves = [NONE; 3];
    for (k, l) in v.leaves.iter().take(n - 1).enumerate() {
        leaves[k] = cut.leaves[*l as usize];
    }
    if facets.iter().any(|f| f.named.leaf != cut.leaves[f.leaf as usize]) {
        for (k, l) in v.leaves.iter().take(n - 1).enumerate() {
            leaves[k] = named(cut, facets, *l, v);
        }
        leaves.sort_unstable();
    }
    Key { points, leaves }
}

/// Where the linear functions vanish.
fn place(corners: &[Point; 4], points: &[DVec3; 4], cut: &Crossed<'_>, v: &Vertex) -> DVec3 {
    // In one order on all sides.
    let mut which: Vec<usize> = (0..4).filter(|c| v.corners >> c & 1 == 1).collect();
    which.sort_by_key(|c| corners[*c]);
    let row = |k: usize| -> Vec<f64> { which.iter().map(|c| cut.values[v.leaves[k] as usize][*c]).collect() };
    let mut w: Vec<f64> = match which.len() {
        2 => {
            let f = row(0);
            vec![f[1], -f[0]]
        }
        3 => {
            let (f, g) = (row(0), row(1));
            let (f, g) = (DVec3::new(f[0], f[1], f[2]), DVec3::new(g[0], g[1], g[2]));
            f.normalize_or_zero().cross(g.normalize_or_zero()).to_array().to_vec()
        }
        _ => {
            let r = [row(0), row(1), row(2)];
            let minor = |skip: usize| {
                let c: Vec<usize> = (0..4).filter(|k| *k != skip).collect();
                let v = |k: usize| DVec3::new(r[k][c[0]], r[k][c[1]], r[k][c[2]]);
                let d = v(0).dot(v(1).cross(v(2)));
                if skip.is_multiple_of(2) { d } else { -d }
            };
            (0..4).map(minor).collect()
        }
    };
    let sum: f64 = w.iter().sum();
    w.iter_mut().for_each(|x| *x = (*x / sum).clamp(0.0, 1.0));
    let sum: f64 = w.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return which.iter().map(|c| points[*c]).sum::<DVec3>() / which.len() as f64;
    }
    which.iter().zip(&w).map(|(c, x)| points[*c] * (x / sum)).sum()
}

/// One ring of several, joined by edges there and back.
fn bridged(mut rings: Vec<Vec<(u32, DVec3)>>) -> Vec<(u32, DVec3)> {
    let Some(mut ring) = rings.pop() else { return Vec::new() };
    while !rings.is_empty() {
        let mut best = (f64::INFINITY, 0, 0, 0);
        for (r, other) in rings.iter().enumerate() {
            for (i, a) in ring.iter().enumerate() {
                for (k, b) in other.iter().enumerate() {
                    let d = a.1.distance_squared(b.1);
                    if d < best.0 {
                        best = (d, r, i, k);
                    }
                }
            }
        }
        let (_, r, i, k) = best;
        let other = rings.swap_remove(r);
        let mut inner: Vec<_> = other[k..].iter().chain(&other[..=k]).copied().collect();
        inner.push(ring[i]);
        ring.splice(i + 1..i + 1, inner);
    }
    ring
}

/// Cuts ears off a ring in a plane.
pub(super) fn triangulate(mut ring: Vec<(u32, DVec3)>, out: &mut dyn FnMut([u32; 3])) {
    let normal: DVec3 =
        (1..ring.len().max(2) - 1).map(|k| (ring[k].1 - ring[0].1).cross(ring[k + 1].1 - ring[0].1)).sum();
    while ring.len() > 3 {
        let n = ring.len();
        let at = |k: usize| ring[k % n].1;
        // The ear that is widest, of those with nothing inside.
        let quality = |k: usize| {
            let (a, b, c) = (at(k + n - 1), at(k), at(k + 1));
            let area = (b - a).cross(c - b).dot(normal);
            let long = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            // Nodes on its sides are in the way, too: an ear cut off there would leave nodes in one line.
            let least = -ROUNDING * long * normal.length();
            let inside = |p: DVec3| {
                let s = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(normal) >= least;
                s(a, b) && s(b, c) && s(c, a)
            };
            let ids = [ring[(k + n - 1) % n].0, ring[k].0, ring[(k + 1) % n].0];
            let blocked = area > 0.0 && (0..n).any(|m| !ids.contains(&ring[m].0) && inside(ring[m].1));
            if blocked { f64::NEG_INFINITY } else { area / long.max(f64::MIN_POSITIVE) }
        };
        let k = (0..n).max_by(|a, b| quality(*a).total_cmp(&quality(*b))).unwrap_or(0);
        out([ring[(k + n - 1) % n].0, ring[k].0, ring[(k + 1) % n].0]);
        ring.remove(k);
    }
    if let [a, b, c] = ring[..] {
        out([a.0, b.0, c.0]);
    }
}

/// Sides of triangles by edge, ascending: the edge's nodes, then three times the triangle and which of its sides.
pub(super) fn sides(triangles: &[Triangle]) -> Vec<([u32; 2], u32)> {
    let mut all: Vec<([u32; 2], u32)> = (0..3 * triangles.len() as u32)
        .into_par_iter()
        .with_min_len(4096)
        .map(|h| {
            let n = &triangles[(h / 3) as usize].nodes;
            let (a, b) = (n[(h % 3) as usize], n[((h + 1) % 3) as usize]);
            ([a.min(b), a.max(b)], h)
        })
        .collect();
    all.par_sort_unstable();
    all
}

/// Whether every edge has as many triangles one way as the other; where there is an end, an edge there has one.
pub(super) fn is_closed(triangles: &[Triangle], ends: bool) -> bool {
    let balanced = |edge: &[([u32; 2], u32)]| {
        2 * edge.iter().filter(|e| forward(triangles, e.1)).count() == edge.len() || (ends && edge.len() == 1)
    };
    sides(triangles).chunk_by(|x, y| x.0 == y.0).all(balanced)
}

/// The nodes of edges with one triangle, ascending.
pub(super) fn at_ends(triangles: &[Triangle]) -> Vec<u32> {
    let all = sides(triangles);
    let mut nodes: Vec<u32> = all.chunk_by(|x, y| x.0 == y.0).filter(|e| e.len() == 1).flat_map(|e| e[0].0).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// For each node, along how many axes its triangles lie on both sides of where blocks meet.
pub(super) fn walls(triangles: &[Triangle], count: usize) -> Vec<u8> {
    let mut sides: Vec<Option<[i8; 3]>> = vec![None; count];
    let mut on_wall = vec![[false; 3]; count];
    for t in triangles {
        for v in t.nodes.map(|v| v as usize) {
            let first = *sides[v].get_or_insert(t.side);
            (0..3).for_each(|k| on_wall[v][k] |= t.side[k] != first[k]);
        }
    }
    on_wall.iter().map(|w| w.iter().filter(|x| **x).count() as u8).collect()
}

/// Halves edges of more than two triangles: where both ends lie in one part of the inside, its copies could not be told from
/// each other.
pub(super) fn divided(keys: &mut Vec<Key>, places: &mut Vec<DVec3>, triangles: &mut Vec<Triangle>) {
    let crowd = |e: &&[([u32; 2], u32)]| e.len() > 2;
    let all = sides(triangles);
    let mut waiting: FxHashSet<[u32; 2]> = all.chunk_by(|x, y| x.0 == y.0).filter(crowd).map(|e| e[0].0).collect();
    // A triangle may have several such edges: one at a time, and again. Halves have as many triangles, but a middle of their own.
    while !waiting.is_empty() {
        let all = sides(triangles);
        let crowded = all.chunk_by(|x, y| x.0 == y.0).filter(|e| waiting.contains(&e[0].0));
        let crowded: Vec<([u32; 2], Vec<u32>)> = crowded.map(|e| (e[0].0, e.iter().map(|x| x.1).collect())).collect();
        let mut touched: FxHashSet<u32> = FxHashSet::default();
        for ([a, b], sides) in &crowded {
            if sides.iter().any(|h| touched.contains(&(h / 3))) {
                continue;
            }
            waiting.remove(&[*a, *b]);
            let mut leaves = [NONE; 3];
            let common =
                keys[*a as usize].leaves.into_iter().filter(|l| keys[*b as usize].leaves.contains(l) && *l != NONE);
            common.enumerate().for_each(|(k, l)| leaves[k] = l);
            let middle = places.len() as u32;
            keys.push(Key { leaves, ..keys[*a as usize] });
            places.push((places[*a as usize] + places[*b as usize]) * 0.5);
            for h in sides {
                let (t, k) = ((h / 3) as usize, (h % 3) as usize);
                let mut other = triangles[t];
                triangles[t].nodes[(k + 1) % 3] = middle;
                other.nodes[k] = middle;
                triangles.push(other);
                touched.insert(t as u32);
            }
        }
    }
}

/// Copies of nodes where parts of the inside touch along edges or in points: each part gets its own. The node each new node is
/// a copy of, itself for those that were there.
pub(super) fn parted(places: &[DVec3], triangles: &mut [Triangle]) -> Vec<u32> {
    let mut joined: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    let find = |joined: &mut Vec<u32>, mut i: u32| {
        while joined[i as usize] != i {
            joined[i as usize] = joined[joined[i as usize] as usize];
            i = joined[i as usize];
        }
        i
    };
    for edge in sides(triangles).chunk_by(|x, y| x.0 == y.0) {
        for [s, o] in pairs(places, triangles, edge) {
            // The corner at the start of one is that at the end of the other.
            let next = |h: u32| h - h % 3 + (h + 1) % 3;
            for (x, y) in [(s, next(o)), (next(s), o)] {
                let (p, q) = (find(&mut joined, x), find(&mut joined, y));
                joined[p.max(q) as usize] = p.min(q);
            }
        }
    }
    let mut copies: Vec<u32> = (0..places.len() as u32).collect();
    let mut of_root: FxHashMap<u32, u32> = FxHashMap::default();
    let mut taken = vec![false; places.len()];
    for t in 0..triangles.len() {
        for k in 0..3 {
            let r = find(&mut joined, 3 * t as u32 + k as u32);
            let v = triangles[t].nodes[k];
            let id = *of_root.entry(r).or_insert_with(|| {
                if taken[v as usize] {
                    copies.push(v);
                    copies.len() as u32 - 1
                } else {
                    taken[v as usize] = true;
                    v
                }
            });
            triangles[t].nodes[k] = id;
        }
    }
    copies
}

fn forward(triangles: &[Triangle], h: u32) -> bool {
    let n = &triangles[(h / 3) as usize].nodes;
    n[(h % 3) as usize] < n[((h + 1) % 3) as usize]
}

/// Which sides of triangles along an edge go together: those with some of the inside between them.
fn pairs(places: &[DVec3], triangles: &[Triangle], sides: &[([u32; 2], u32)]) -> Vec<[u32; 2]> {
    let [a, b] = sides[0].0;
    if let [(_, s), (_, o)] = *sides {
        return vec![[s, o]];
    }
    let (p, q) = (places[a as usize], places[b as usize]);
    let (u, v) = (q - p).normalize_or(DVec3::X).any_orthonormal_pair();
    let flip = u.cross(v).dot(q - p) < 0.0;
    let mut around: Vec<(f64, u32)> = sides
        .iter()
        .map(|(_, h)| {
            let c = triangles[(h / 3) as usize].nodes[((h + 2) % 3) as usize];
            let d = places[c as usize] - p;
            let angle = d.dot(v).atan2(d.dot(u));
            (if flip { -angle } else { angle }, *h)
        })
        .collect();
    around.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let n = around.len();
    let mut out = Vec::new();
    // Outside is counterclockwise from a triangle that runs along the edge: its partner is the one before it.
    for k in 0..n {
        if forward(triangles, around[k].1) {
            let before = around[(k + n - 1) % n].1;
            if !forward(triangles, before) {
                out.push([around[k].1, before]);
            }
        }
    }
    out
}
