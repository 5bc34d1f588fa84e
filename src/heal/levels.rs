//! From a complex of triangles that meet in common nodes and edges only to closed manifolds: one for each level of the
//! winding number, and one around each sheet.
//!
//! Where sheets cross, the winding number takes four values around their crossing. The surface that bounds its level k (the
//! points around which the input winds k times or more) turns there from one sheet to the other, so surfaces of different
//! levels touch where they crossed. Each is joined by itself, gets nodes of its own there, and draws back from the others by
//! a small gap. Nothing of the input is lost, and away from crossings nothing moves.

use glam::DVec3;

use super::arrange::{Complex, Uses};
use super::sides::{EdgeSide, Sides, directed, ends, pieces};
use super::winding::{Patches, behind, turn_around};
use crate::error::Result;
use crate::mesh::{TriMesh, intersections_among, self_intersections};
use crate::numeric::Sets;
use crate::run::Run;

/// A triangle of the output: which one of the complex, whether it winds against it, and what it bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Copy {
    pub(super) triangle: u32,
    pub(super) turned: bool,
    pub(super) level: i32,
    /// One side of a sheet.
    pub(super) plate: bool,
}

/// Rounds in which nodes that drew back too far or not far enough are looked at again.
const ROUNDS: usize = 12;

/// How often parts of sheets without room are left out.
const MOST_DROPS: usize = 8;

/// How often edges that stay crowded are halved.
const MOST_SPLITS: usize = 4;

/// Surfaces of the levels of a complex, and how many triangles belong to sheets.
pub(super) struct Levels {
    pub(super) mesh: TriMesh,
    /// Nodes that were parted.
    pub(super) parted: Vec<DVec3>,
    /// Centroids of triangles of sheets, which now have two sides.
    pub(super) plates: Vec<DVec3>,
}

/// Parts the complex into the surfaces of its levels. Nodes of several surfaces draw back by `gap` where there is room.
/// `None` if triangles of solids do not close, or if no gap parts all surfaces.
pub(super) fn levels(complex: &Complex, faces: &[String], gap: f64, run: &Run) -> Result<Option<Levels>> {
    let mut complex = complex.clone();
    for _ in 0..MOST_DROPS {
        let mut whole = subdivide_sheets(&complex);
        let mut tries = 0;
        let (copies, fans) = loop {
            let sides = Sides::of(&whole.triangles);
            let copies = copies(&whole, &sides, run)?;
            let Some(fans) = join(&whole, &sides, &copies) else { return Ok(None) };
            let crowded = crowded_edges(&whole, &copies, &fans);
            if crowded.is_empty() {
                break (copies, fans);
            }
            tries += 1;
            if tries > MOST_SPLITS {
                return Ok(None);
            }
            whole = halve_edges(&whole, &crowded);
        };
        let (mesh, origin) = build(&whole, &copies, &fans, faces);
        let stuck = match part(mesh, &origin, &copies, gap, run)? {
            Ok(Parted { mesh, places: parted }) => {
                let sheets = copies.iter().filter(|c| c.plate && c.turned);
                let plates = sheets.map(|c| center(&whole, c.triangle)).collect();
                return Ok(Some(Levels { mesh, parted, plates }));
            }
            Err(stuck) => stuck,
        };
        // parts of sheets that have no room for two sides are left out
        let mut drop = vec![false; whole.triangles.len()];
        let mut any = false;
        for c in stuck.iter().flatten().map(|c| copies[*c as usize]).filter(|c| c.plate) {
            drop[c.triangle as usize] = true;
            any = true;
        }
        if !any {
            return Ok(None);
        }
        let left = whole.triangles.iter().zip(&whole.uses).zip(&drop).filter(|(_, d)| !**d).map(|((t, u), _)| (*t, *u));
        complex = Complex::new(whole.nodes.clone(), left);
    }
    Ok(None)
}

fn center(complex: &Complex, t: u32) -> DVec3 {
    complex.triangles[t as usize].iter().map(|v| complex.nodes[*v as usize]).sum::<DVec3>() / 3.0
}

/// Net number of solids a triangle bounds from behind.
fn jump(u: &Uses) -> i32 {
    i32::from(u.along) - i32::from(u.against)
}

/// Gives sheets nodes off their rims, so that their two sides differ: triangles with nothing but rim get nodes on inner edges
/// between rim nodes and in their middle.
fn subdivide_sheets(complex: &Complex) -> Complex {
    if !complex.uses.iter().any(|u| u.sheet) {
        return complex.clone();
    }
    let sides = Sides::of(&complex.triangles);
    let mut rim = vec![false; complex.nodes.len()];
    let inner = |e: &[EdgeSide]| e.len() == 2 && e.iter().all(|s| complex.uses[s.triangle()].sheet);
    for e in sides.edges().filter(|e| !inner(e)) {
        ends(e[0].key).iter().for_each(|v| rim[*v as usize] = true);
    }
    let mut nodes = complex.nodes.clone();
    let mut middle: rustc_hash::FxHashMap<u64, u32> = rustc_hash::FxHashMap::default();
    for e in sides.edges().filter(|e| inner(e)) {
        let [a, b] = ends(e[0].key);
        if rim[a as usize] && rim[b as usize] {
            middle.insert(e[0].key, nodes.len() as u32);
            nodes.push(0.5 * (complex.nodes[a as usize] + complex.nodes[b as usize]));
        }
    }
    let mut out = Vec::with_capacity(complex.triangles.len());
    for (t, u) in complex.triangles.iter().zip(&complex.uses) {
        let cut = |k: usize| middle.get(&super::sides::key(t[k], t[(k + 1) % 3])).copied();
        let bare = t.iter().all(|v| rim[*v as usize]);
        if !u.sheet || !(bare || (0..3).any(|k| cut(k).is_some())) {
            out.push((*t, *u));
            continue;
        }
        let c = nodes.len() as u32;
        nodes.push(t.iter().map(|v| complex.nodes[*v as usize]).sum::<DVec3>() / 3.0);
        let ring: Vec<u32> = (0..3).flat_map(|k| std::iter::once(t[k]).chain(cut(k))).collect();
        out.extend((0..ring.len()).map(|i| ([ring[i], ring[(i + 1) % ring.len()], c], *u)));
    }
    Complex::new(nodes, out)
}

/// Edges on which more than two copies have the same fans at both ends: as at a slit of a single edge.
fn crowded_edges(complex: &Complex, copies: &[Copy], fans: &[u32]) -> Vec<u64> {
    let mut all: Vec<([u32; 2], u64)> = Vec::with_capacity(3 * copies.len());
    for (c, copy) in copies.iter().enumerate() {
        let t = complex.triangles[copy.triangle as usize];
        for k in 0..3 {
            let (f, g) = (fans[3 * c + k], fans[3 * c + (k + 1) % 3]);
            all.push(([f.min(g), f.max(g)], super::sides::key(t[k], t[(k + 1) % 3])));
        }
    }
    all.sort_unstable();
    let mut out: Vec<u64> = all.chunk_by(|a, b| a.0 == b.0).filter(|e| e.len() > 2).map(|e| e[0].1).collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// Puts a node into the middle of each of the edges, in all triangles there.
fn halve_edges(complex: &Complex, edges: &[u64]) -> Complex {
    let mut nodes = complex.nodes.clone();
    let first = nodes.len() as u32;
    for e in edges {
        let [a, b] = ends(*e);
        nodes.push(0.5 * (complex.nodes[a as usize] + complex.nodes[b as usize]));
    }
    let mut out = Vec::with_capacity(complex.triangles.len());
    for (t, u) in complex.triangles.iter().zip(&complex.uses) {
        let cut =
            |k: usize| edges.binary_search(&super::sides::key(t[k], t[(k + 1) % 3])).ok().map(|i| first + i as u32);
        let cuts: Vec<usize> = (0..3).filter(|k| cut(*k).is_some()).collect();
        match cuts[..] {
            [] => out.push((*t, *u)),
            [k] => {
                let m = cut(k).unwrap_or(first);
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                out.extend([([a, m, c], *u), ([m, b, c], *u)]);
            }
            _ => {
                let c = nodes.len() as u32;
                nodes.push(t.iter().map(|v| complex.nodes[*v as usize]).sum::<DVec3>() / 3.0);
                let ring: Vec<u32> = (0..3).flat_map(|k| std::iter::once(t[k]).chain(cut(k))).collect();
                out.extend((0..ring.len()).map(|i| ([ring[i], ring[(i + 1) % ring.len()], c], *u)));
            }
        }
    }
    Complex::new(nodes, out)
}

/// The layers of each triangle from its back to its front.
fn copies(complex: &Complex, sides: &Sides, run: &Run) -> Result<Vec<Copy>> {
    let n = complex.triangles.len();
    // one winding number in front of each patch and one behind it
    let (patch, count) = pieces(n, sides, |e| {
        let [a, b] = e else { return false };
        let (u, v) = (complex.uses[a.triangle()], complex.uses[b.triangle()]);
        let turned = directed(&complex.triangles, a.half) == directed(&complex.triangles, b.half);
        u.sheet == v.sheet
            && if turned {
                (u.along, u.against) == (v.against, v.along) && u.along == u.against
            } else {
                (u.along, u.against) == (v.along, v.against)
            }
    });
    let behind = behind(complex, sides, &Patches { of: &patch, count }, &jump, run)?;
    let mut out = Vec::new();
    for t in 0..n as u32 {
        let u = complex.uses[t as usize];
        let back = behind[t as usize];
        let mut layer = |from: i32, to: i32, plate: bool| {
            // the body lies on the side with the larger number, or for negative ones with the smaller
            let level = from.max(to);
            let (level, body_behind) = if level > 0 { (level, from > to) } else { (level - 1, from < to) };
            out.push(Copy { triangle: t, turned: !body_behind, level, plate });
        };
        let walls = u.along.min(u.against);
        for _ in 0..walls {
            if back >= 1 {
                layer(back, back - 1, false);
                layer(back - 1, back, false);
            } else {
                layer(back, back + 1, true);
                layer(back + 1, back, true);
            }
        }
        let m = jump(&u);
        for i in 0..m.abs() {
            layer(back - i * m.signum(), back - (i + 1) * m.signum(), false);
        }
        if u.sheet && m == 0 && walls == 0 {
            let base = back.max(0);
            layer(base, base + 1, true);
            layer(base + 1, base, true);
        }
    }
    Ok(out)
}

/// Joins the copies around each edge, level by level, around the inside of what they bound. Returns for each corner of each
/// copy (`3 c + k`, corners as the complex numbers them) the number of its fan.
pub(super) fn join(complex: &Complex, sides: &Sides, copies: &[Copy]) -> Option<Vec<u32>> {
    let mut of = vec![(0u32, 0u32); complex.triangles.len()];
    for (c, copy) in copies.iter().enumerate() {
        let slot = &mut of[copy.triangle as usize];
        if slot.1 == 0 {
            slot.0 = c as u32;
        }
        slot.1 += 1;
    }
    let mut fans = Sets::new(3 * copies.len());
    for e in sides.edges() {
        let [u, v] = ends(e[0].key);
        let around = turn_around(complex, u, v, e);
        // (level, whether the body is entered, copy), going around
        let mut steps: Vec<(i32, bool, u32)> = Vec::new();
        for s in &around {
            let t = s.triangle();
            // going around u -> v counter-clockwise, a triangle that runs u -> v is met at its back
            let front_first = directed(&complex.triangles, s.half) != [u, v];
            let (first, count) = of[t];
            let mut layers: Vec<u32> = (first..first + count).collect();
            if front_first {
                layers.reverse();
            }
            for c in layers {
                let copy = copies[c as usize];
                // an unturned copy has its body behind it
                let enters = front_first != copy.turned;
                steps.push((copy.level, enters, c));
            }
        }
        let mut levels: Vec<i32> = steps.iter().map(|s| s.0).collect();
        levels.sort_unstable();
        levels.dedup();
        for level in levels {
            let own: Vec<&(i32, bool, u32)> = steps.iter().filter(|s| s.0 == level).collect();
            if own.len() % 2 == 1 || (0..own.len()).any(|i| own[i].1 == own[(i + 1) % own.len()].1) {
                return None;
            }
            // within a sheet the surface goes on from triangle to triangle, elsewhere it turns around what it bounds
            let goes_on = e.len() == 2 && own.iter().all(|s| copies[s.2 as usize].plate);
            for i in (0..own.len()).filter(|i| own[*i].1 != goes_on) {
                let (a, b) = (own[i].2, own[(i + 1) % own.len()].2);
                for w in [u, v] {
                    fans.join(corner_of(complex, copies, a, w), corner_of(complex, copies, b, w));
                }
            }
        }
    }
    Some(fans.numbers().0)
}

fn corner_of(complex: &Complex, copies: &[Copy], c: u32, v: u32) -> u32 {
    let t = complex.triangles[copies[c as usize].triangle as usize];
    3 * c + t.iter().position(|x| *x == v).unwrap_or(0) as u32
}

/// The mesh of the copies with a node for each fan, and for each node of it the node of the complex.
pub(super) fn build(complex: &Complex, copies: &[Copy], fans: &[u32], faces: &[String]) -> (TriMesh, Vec<u32>) {
    let mut mesh = TriMesh { faces: faces.to_vec(), ..TriMesh::default() };
    let count = fans.iter().max().map_or(0, |m| *m as usize + 1);
    let mut node = vec![0u32; count];
    for (c, copy) in copies.iter().enumerate() {
        let t = complex.triangles[copy.triangle as usize];
        (0..3).for_each(|k| node[fans[3 * c + k] as usize] = t[k]);
        let [x, y, z]: [u32; 3] = std::array::from_fn(|k| fans[3 * c + k]);
        mesh.triangles.push(if copy.turned { [x, z, y] } else { [x, y, z] });
        mesh.labels.push(complex.uses[copy.triangle as usize].label);
    }
    mesh.nodes = node.iter().map(|v| complex.nodes[*v as usize]).collect();
    (mesh, node)
}

/// Steps in which the direction a node draws back in is turned.
const TURNS: usize = 30;

/// What a node that shares its place with others is to do.
#[derive(Debug, Clone, Copy)]
struct Draw {
    way: DVec3,
    /// Gap it draws back by, so far.
    by: f64,
    /// Whether a triangle here lies on another copy of itself, so that the two must be parted.
    must: bool,
}

/// A mesh without intersections.
struct Parted {
    mesh: TriMesh,
    /// Where nodes were parted.
    places: Vec<DVec3>,
}

/// Draws nodes back from others at their place until nothing intersects.
fn part(
    mut mesh: TriMesh,
    origin: &[u32],
    copies: &[Copy],
    gap: f64,
    run: &Run,
) -> Result<Result<Parted, Vec<[u32; 2]>>> {
    let n = mesh.nodes.len();
    let mut order: Vec<u32> = (0..n as u32).collect();
    order.sort_unstable_by_key(|v| (origin[*v as usize], *v));
    // corners of each node's triangles
    let mut first = vec![0u32; n + 1];
    mesh.triangles.iter().flatten().for_each(|v| first[*v as usize + 1] += 1);
    (0..n).for_each(|i| first[i + 1] += first[i]);
    let (mut at, mut slot) = (vec![0u32; 3 * mesh.triangles.len()], first.clone());
    for (t, tri) in mesh.triangles.iter().enumerate() {
        for v in tri {
            at[slot[*v as usize] as usize] = t as u32;
            slot[*v as usize] += 1;
        }
    }
    let around = |v: u32| &at[first[v as usize] as usize..first[v as usize + 1] as usize];
    let mut draws: Vec<Option<Draw>> = vec![None; n];
    let mut parted = Vec::new();
    for same in order.chunk_by(|a, b| origin[*a as usize] == origin[*b as usize]).filter(|s| s.len() > 1) {
        parted.push(mesh.nodes[same[0] as usize]);
        // the one of the lowest level with the most triangles stays; both sides of a sheet move
        let rank = |v: u32| {
            let level = around(v).iter().map(|t| copies[*t as usize].level.abs()).min().unwrap_or(0);
            (level, std::cmp::Reverse(around(v).len()), v)
        };
        let mut ranked: Vec<u32> = same.to_vec();
        ranked.sort_unstable_by_key(|v| rank(*v));
        for (i, &v) in ranked.iter().enumerate() {
            let one_sided = one_side(around(v), copies);
            let stays = i == 0 && one_sided != Some(true);
            if stays {
                continue;
            }
            let way = way(&mesh, v, around(v), one_sided);
            let deep = if one_sided == Some(true) { 1.0 } else { (i as f64).min(4.0) };
            let room = room(&mesh, v, around(v));
            let twin = |t: &u32| {
                let (t, own) = (*t as usize, copies[*t as usize].triangle);
                (t > 0 && copies[t - 1].triangle == own) || copies.get(t + 1).is_some_and(|c| c.triangle == own)
            };
            let must = one_sided.is_some() && around(v).iter().any(twin);
            draws[v as usize] = Some(Draw { way, by: (gap * deep).min(0.3 * room), must });
        }
    }
    let home = mesh.nodes.clone();
    for v in 0..n {
        if let Some(d) = draws[v] {
            mesh.nodes[v] = home[v] + d.by * d.way;
        }
    }
    let mut pairs = crossings(&mesh, run)?;
    for round in 0..ROUNDS {
        if pairs.is_empty() {
            break;
        }
        run.check()?;
        let mut touched: Vec<u32> = pairs.iter().flatten().flat_map(|t| mesh.triangles[*t as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        let mut moved = vec![false; mesh.triangles.len()];
        for v in touched {
            if let Some(d) = &mut draws[v as usize] {
                // where there is no room surfaces touch, as they do without a gap; what lies on itself must not
                d.by *= if round >= 4 && !d.must { 0.0 } else { 0.3 };
                mesh.nodes[v as usize] = home[v as usize] + d.by * d.way;
                around(v).iter().for_each(|t| moved[*t as usize] = true);
            }
        }
        // away from what moved nothing has changed
        let some: Vec<u32> = (0..moved.len() as u32).filter(|t| moved[*t as usize]).collect();
        pairs.retain(|pair| !pair.iter().any(|t| moved[*t as usize]));
        pairs.extend(crossings_among(&mesh, &some, run)?);
        pairs.sort_unstable();
    }
    Ok(if pairs.is_empty() { Ok(Parted { mesh, places: parted }) } else { Err(pairs) })
}

/// Intersections of a mesh in which nodes at one place count as one: surfaces may touch there.
pub(super) fn crossings(mesh: &TriMesh, run: &Run) -> Result<Vec<[u32; 2]>> {
    let mut welded = mesh.clone();
    super::clean::weld(&mut welded);
    self_intersections(&welded, run)
}

/// Those [`crossings`] that concern one of these triangles, which ascend.
fn crossings_among(mesh: &TriMesh, some: &[u32], run: &Run) -> Result<Vec<[u32; 2]>> {
    let mut welded = mesh.clone();
    super::clean::weld(&mut welded);
    intersections_among(&welded, some, run)
}

/// `Some(true)`: nothing but one side of a sheet; `Some(false)`: no sheet; `None`: the rim of a sheet, with both sides.
fn one_side(around: &[u32], copies: &[Copy]) -> Option<bool> {
    let plates = around.iter().filter(|t| copies[**t as usize].plate).count();
    if plates == 0 {
        return Some(false);
    }
    let mut seen: Vec<u32> = around.iter().map(|t| copies[*t as usize].triangle).collect();
    seen.sort_unstable();
    (plates == around.len() && seen.windows(2).all(|w| w[0] != w[1])).then_some(true)
}

/// The direction a node draws back in: into the body its fan bounds; out of it from one side of a sheet; along the sheet at a rim.
fn way(mesh: &TriMesh, v: u32, around: &[u32], one_side: Option<bool>) -> DVec3 {
    let p = mesh.nodes[v as usize];
    let (mut n, mut along, mut sum) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for t in around {
        let tri = mesh.triangles[*t as usize];
        let k = tri.iter().position(|x| *x == v).unwrap_or(0);
        let (a, b) = (mesh.nodes[tri[(k + 1) % 3] as usize] - p, mesh.nodes[tri[(k + 2) % 3] as usize] - p);
        let angle = a.angle_between(b);
        if !(angle > 0.0) {
            continue;
        }
        n += angle * a.cross(b).normalize_or_zero();
        along += angle * (a.normalize_or_zero() + b.normalize_or_zero()).normalize_or_zero();
        sum += angle;
    }
    let side = one_side == Some(true);
    if !side && n.length() <= 0.15 * sum {
        return along.normalize_or_zero();
    }
    // turned until it leads away from the triangle it leads away from least, as far as there is such a direction
    let normals: Vec<DVec3> = around.iter().map(|t| mesh.normal(*t as usize)).collect();
    let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
    let mut d = n.normalize_or_zero();
    for _ in 0..TURNS {
        let Some(worst) = normals.iter().copied().min_by(|a, b| a.dot(d).total_cmp(&b.dot(d))) else { break };
        if worst.dot(d) > best.0 {
            best = (worst.dot(d), d);
        }
        d = (d + 0.3 * worst).normalize_or_zero();
    }
    if side { best.1 } else { -best.1 }
}

/// The smallest height over the node in its triangles.
fn room(mesh: &TriMesh, v: u32, around: &[u32]) -> f64 {
    let p = mesh.nodes[v as usize];
    around
        .iter()
        .map(|t| {
            let tri = mesh.triangles[*t as usize];
            let k = tri.iter().position(|x| *x == v).unwrap_or(0);
            let (a, b) = (mesh.nodes[tri[(k + 1) % 3] as usize], mesh.nodes[tri[(k + 2) % 3] as usize]);
            (a - p).cross(b - p).length() / a.distance(b)
        })
        .filter(|h| *h > 0.0)
        .fold(f64::INFINITY, f64::min)
}
