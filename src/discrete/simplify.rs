//! Feature simplification by virtual operations: marks are taken away, the geometry stays (\[GUO\] section 3).

use glam::DVec3;
use serde::Serialize;

use super::features::{Chain, chains, flood};
use crate::error::Result;
use crate::mesh::EditMesh;
use crate::mesh::curvature::dihedral;
use crate::mesh::edit::NONE;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// The way to where two features meet, over their distance there, from which on they are a wedge of less than 20 degrees.
const WEDGE: f64 = 3.0;

/// What counts as small. Zero keeps everything.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Faces of less area are merged with a neighbor.
    pub area: f64,
    /// Faces narrower than this (twice their area over their perimeter) are merged with a neighbor.
    pub width: f64,
    /// Geometric edges shorter than this that bound no face, because they end in it, are unmarked.
    pub length: f64,
    /// The same for those that end in it on both sides.
    pub isolated: f64,
}

/// One thing that was taken away.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Removed {
    /// `face` or `edge`.
    pub what: &'static str,
    /// Area of a face, length of an edge.
    pub size: f64,
    /// A point of it.
    pub at: [f64; 3],
}

/// A face while faces are merged.
#[derive(Clone, Default)]
struct MergedFaces {
    area: f64,
    perimeter: f64,
    /// Length of its border between torn nodes.
    torn: f64,
    at: DVec3,
}

/// Features that hang together with one that ends within a face, as they are where noise or the grid of marching cubes
/// broke them: those of designed parts bound faces. What is small among them is no feature.
pub struct Torn {
    /// Whether each node is on one.
    pub nodes: Vec<bool>,
    /// What counts as small.
    pub limits: Limits,
}

/// The nodes of features that hang together with one that ends within a face.
pub fn torn_nodes(mesh: &EditMesh) -> Vec<bool> {
    let mut torn = vec![false; mesh.node_capacity()];
    let mut stack: Vec<u32> = mesh.nodes().filter(|&v| mesh.sharp_neighbors(v).count() == 1).collect();
    stack.iter().for_each(|&v| torn[v as usize] = true);
    while let Some(v) = stack.pop() {
        for x in mesh.sharp_neighbors(v) {
            if !std::mem::replace(&mut torn[x as usize], true) {
                stack.push(x);
            }
        }
    }
    torn
}

/// Unmarks torn features that run beside others: where noise makes one edge show as two, or as the tip of a wedge, no triangle
/// fits in between. The shorter of two goes, if half of it is nearer to the other than `near`, and than a third of the way to
/// where they meet. Returns how many went.
pub fn drop_crowded(mesh: &mut EditMesh, torn: &Torn, near: f64) -> usize {
    let chains = chains(mesh);
    let mut segments: Vec<([DVec3; 2], u32, DVec3)> = Vec::new();
    let up = |mesh: &EditMesh, h: u32| {
        let o = mesh.opposite(h);
        let other = if o == NONE { DVec3::ZERO } else { mesh.area_vector(o / 3).normalize_or_zero() };
        mesh.area_vector(h / 3).normalize_or_zero() + other
    };
    for (c, chain) in chains.iter().enumerate() {
        for &h in &chain.edges {
            segments.push(([mesh.origin(h), mesh.target(h)].map(|v| mesh.point(v)), c as u32, up(mesh, h)));
        }
    }
    let tree = Bvh::new(segments.iter().map(|s| Aabb::around(s.0)).collect());
    let mut order: Vec<usize> = (0..chains.len()).collect();
    order.sort_by(|&a, &b| chains[a].length.total_cmp(&chains[b].length).then(a.cmp(&b)));
    let mut gone = vec![false; chains.len()];
    for c in order {
        let chain = &chains[c];
        let is_torn = chain.nodes.iter().all(|&v| torn.nodes.get(v as usize).copied().unwrap_or(false));
        if !is_torn || chain.is_closed() || chain.edges.iter().any(|&h| is_fixed(mesh, h)) {
            continue;
        }
        let (mut along, mut beside) = (0.0, 0.0);
        for &h in &chain.edges {
            let [p, q] = [mesh.origin(h), mesh.target(h)].map(|v| mesh.point(v));
            let (length, middle, up) = (p.distance(q), 0.5 * (p + q), up(mesh, h));
            along += length;
            // What remains of the way to the nearer end.
            let to_end = (along - 0.5 * length).min(chain.length - along + 0.5 * length);
            let away = |k: u32| {
                let (segment, other, facing) = segments[k as usize];
                if other as usize == c || gone[other as usize] || facing.dot(up) <= 0.0 {
                    return f64::INFINITY;
                }
                middle.distance_squared(segment_foot(middle, segment))
            };
            if let Some((k, d)) = tree.nearest(middle, near, away).filter(|n| n.1.is_finite()) {
                let other = &chains[segments[k as usize].1 as usize];
                let ends = [other.nodes[0], other.nodes[other.nodes.len() - 1]];
                let meet = [chain.nodes[0], chain.nodes[chain.nodes.len() - 1]].iter().any(|v| ends.contains(v));
                if !meet || WEDGE * d.sqrt() < to_end {
                    beside += length;
                }
            }
        }
        if beside > 0.5 * chain.length {
            gone[c] = true;
        }
    }
    let lost = (0..chains.len()).filter(|&c| gone[c]);
    lost.clone().flat_map(|c| &chains[c].edges).for_each(|&h| mesh.set_sharp(h, false));
    lost.count()
}

/// Unmarks small features until nothing changes; edges between labels and open ones stay. Faces whose borders are
/// [torn](Torn) for the most part have limits of their own. Returns what was removed, in order.
///
/// A small face is merged with one neighbor only, across the border at which the two differ least in direction: its other
/// borders stay, so larger faces on both sides of a narrow one remain two. (\[GUO\] merges it with all of them.)
pub fn simplify(mesh: &mut EditMesh, limits: &Limits, torn: Option<&Torn>, run: &Run) -> Result<Vec<Removed>> {
    let mut removed = Vec::new();
    loop {
        run.check()?;
        let before = removed.len();
        drop_stubs(mesh, limits, &mut removed);
        if limits.area > 0.0 || limits.width > 0.0 || torn.is_some() {
            merge_faces(mesh, limits, torn, &mut removed);
        }
        if removed.len() == before {
            return Ok(removed);
        }
    }
}

/// Whether an edge must stay sharp.
fn is_fixed(mesh: &EditMesh, h: u32) -> bool {
    let o = mesh.opposite(h);
    o == NONE || mesh.label(h / 3) != mesh.label(o / 3)
}

/// Unmarks chains that end inside a face and are shorter than the limits.
fn drop_stubs(mesh: &mut EditMesh, limits: &Limits, removed: &mut Vec<Removed>) {
    if !(limits.length > 0.0 || limits.isolated > 0.0) {
        return;
    }
    loop {
        let before = removed.len();
        for chain in chains(mesh) {
            let ends = [chain.nodes[0], chain.nodes[chain.nodes.len() - 1]];
            let loose = ends.iter().filter(|&&v| mesh.sharp_neighbors(v).count() == 1).count();
            let length = [0.0, limits.length, limits.isolated.max(limits.length)][loose];
            if chain.length < length && !chain.edges.iter().any(|&h| is_fixed(mesh, h)) {
                removed.push(Removed { what: "edge", size: chain.length, at: middle(mesh, &chain).to_array() });
                chain.edges.iter().for_each(|&h| mesh.set_sharp(h, false));
            }
        }
        if removed.len() == before {
            return;
        }
    }
}

fn middle(mesh: &EditMesh, chain: &Chain) -> DVec3 {
    mesh.point(chain.nodes[chain.nodes.len() / 2])
}

/// Merges small faces, smallest first, each with the neighbor it differs least from.
fn merge_faces(mesh: &mut EditMesh, limits: &Limits, torn: Option<&Torn>, removed: &mut Vec<Removed>) {
    let (face, count) = flood(mesh);
    let mut regions = vec![MergedFaces::default(); count];
    // Borders as (face, neighbor, half-edge seen from the face).
    let mut borders: Vec<(u32, u32, u32)> = Vec::new();
    for t in mesh.triangles() {
        let r = &mut regions[face[t as usize] as usize];
        if r.area == 0.0 {
            r.at = mesh.centroid(t);
        }
        r.area += 0.5 * mesh.area_vector(t).length();
        for h in (3 * t..3 * t + 3).filter(|&h| mesh.is_sharp(h)) {
            r.perimeter += mesh.edge_length(h);
            let is_torn = |t: &Torn| [mesh.origin(h), mesh.target(h)].iter().all(|v| t.nodes[*v as usize]);
            if torn.is_some_and(is_torn) {
                r.torn += mesh.edge_length(h);
            }
            let o = mesh.opposite(h);
            if !is_fixed(mesh, h) && face[t as usize] != face[(o / 3) as usize] {
                borders.push((face[t as usize], face[(o / 3) as usize], h));
            }
        }
    }
    borders.sort_unstable();
    let small = |r: &MergedFaces| {
        let limits = torn.filter(|_| 2.0 * r.torn > r.perimeter).map_or(limits, |t| &t.limits);
        r.area < limits.area || (r.perimeter > 0.0 && 2.0 * r.area / r.perimeter < limits.width)
    };
    let mut order: Vec<u32> = (0..count as u32).filter(|&f| small(&regions[f as usize])).collect();
    order.sort_by(|a, b| regions[*a as usize].area.total_cmp(&regions[*b as usize].area).then(a.cmp(b)));
    // A face takes part in one merger per pass.
    let mut busy = vec![false; count];
    for f in order {
        let own = &borders[borders.partition_point(|b| b.0 < f)..borders.partition_point(|b| b.0 <= f)];
        let best = own
            .chunk_by(|x, y| x.1 == y.1)
            .filter(|group| !busy[group[0].1 as usize])
            .map(|group| {
                let (mut bend, mut length) = (0.0, 0.0);
                for &(_, _, h) in group {
                    bend += mesh.edge_length(h) * dihedral(mesh, h);
                    length += mesh.edge_length(h);
                }
                (if length > 0.0 { bend / length } else { 0.0 }, -length, group)
            })
            .min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.total_cmp(&y.1)));
        let Some((_, _, group)) = best.filter(|_| !busy[f as usize]) else { continue };
        (busy[f as usize], busy[group[0].1 as usize]) = (true, true);
        let r = &regions[f as usize];
        removed.push(Removed { what: "face", size: r.area, at: r.at.to_array() });
        group.iter().for_each(|b| mesh.set_sharp(b.2, false));
    }
}
