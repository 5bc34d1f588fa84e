//! What \[GUO\] section 2 finds in the triangles: feature edges, geometric edges, vertices and faces.

use glam::DVec3;
use rustc_hash::FxHashSet;

use crate::error::Result;
use crate::mesh::EditMesh;
use crate::mesh::curvature::dihedral;
use crate::mesh::edit::NONE;
use crate::numeric::{COS_60, Sets};
use crate::run::Run;

/// Gaps between feature edges are bridged by edges of at least this share of the feature angle.
const WEAK: f64 = 0.6;
/// Means whose vectors cancel out to less than this share of their lengths' sum say nothing.
const COHERENT: f64 = 0.7;
/// Where edges that are no features bend by more than this on average the surface is rough: 15 degrees.
const ROUGH: f64 = 0.26;
/// Triangles of an island at most.
const ISLAND: u32 = 4;
/// Triangles looked at on each side of an edge at most.
const MOST_AROUND: usize = 200;

/// A geometric edge: feature edges one after the other, from vertex to vertex or round and back.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Nodes in order; the first is the last where the chain is closed.
    pub nodes: Vec<u32>,
    /// One half-edge of each feature edge, in order.
    pub edges: Vec<u32>,
    /// Sum of the edges' lengths.
    pub length: f64,
}

impl Chain {
    /// Whether it ends where it began.
    pub fn is_closed(&self) -> bool {
        self.nodes.first() == self.nodes.last()
    }
}

/// Marks as sharp the edges whose triangles' normals differ by more than `angle` degrees, those between different labels,
/// and open ones (\[GUO\] 2.1). Marks that are there stay. Returns how many edges are sharp now.
pub fn mark_feature_edges(mesh: &mut EditMesh, angle: f64) -> usize {
    let limit = angle.to_radians();
    let mut count = 0;
    for h in 0..3 * mesh.triangle_capacity() as u32 {
        if !mesh.is_edge(h) {
            continue;
        }
        let o = mesh.opposite(h);
        if o == NONE || mesh.label(h / 3) != mesh.label(o / 3) || dihedral(mesh, h) > limit {
            mesh.set_sharp(h, true);
        }
        count += usize::from(mesh.is_sharp(h));
    }
    count
}

/// Bridges gaps between feature edges that end within a face: from the end on, the sharpest edges are followed that are not much
/// blunter than `angle` and go on without a turn, and marked if they lead to another feature. No gap is longer than `gap` or the
/// feature that ends there: the rim of a tube that is cut aslant is blunt on one side.
/// Returns how many edges were marked.
pub fn bridge_gaps(mesh: &mut EditMesh, angle: f64, gap: f64) -> usize {
    let least = WEAK * angle.to_radians();
    let ends: Vec<u32> = mesh.nodes().filter(|&v| mesh.sharp_neighbors(v).count() == 1).collect();
    let mut count = 0;
    for start in ends {
        let Some(last) = mesh.sharp_neighbors(start).next().filter(|_| mesh.sharp_neighbors(start).count() == 1) else {
            continue;
        };
        let gap = gap.max(length_from(mesh, start, last));
        let (mut v, mut length) = (start, 0.0);
        let mut direction = (mesh.point(v) - mesh.point(last)).normalize_or_zero();
        let mut path = Vec::new();
        let reached = loop {
            let onward = |h: &u32| {
                let d = (mesh.point(mesh.target(*h)) - mesh.point(v)).normalize_or_zero();
                // A bridge does not turn by more than this from edge to edge.
                d.dot(direction) > COS_60 && dihedral(mesh, *h) > least
            };
            let best = mesh
                .outgoing(v)
                .filter(onward)
                .max_by(|a, b| dihedral(mesh, *a).total_cmp(&dihedral(mesh, *b)).then(b.cmp(a)));
            let Some(h) = best else { break false };
            length += mesh.edge_length(h);
            if length > gap {
                break false;
            }
            path.push(h);
            direction = (mesh.point(mesh.target(h)) - mesh.point(v)).normalize_or_zero();
            v = mesh.target(h);
            if v != start && mesh.sharp_neighbors(v).next().is_some() {
                break true;
            }
        };
        if reached {
            count += path.len();
            path.into_iter().for_each(|h| mesh.set_sharp(h, true));
        }
    }
    count
}

/// How long a feature is from its end to where it ends again or meets others.
fn length_from(mesh: &EditMesh, end: u32, next: u32) -> f64 {
    let (mut last, mut v) = (end, next);
    let mut length = mesh.point(end).distance(mesh.point(next));
    loop {
        let mut onward = mesh.sharp_neighbors(v).filter(|x| *x != last);
        let (Some(x), None) = (onward.next(), onward.next()) else { return length };
        length += mesh.point(v).distance(mesh.point(x));
        (last, v) = (v, x);
        if v == end {
            return length;
        }
    }
}

/// Unmarks feature edges that are none at a larger scale: those beside which the normals, averaged over triangles up to
/// `scale` away on each side, differ by much less than `angle`. Averages do not go across feature edges, so small features
/// with flat sides stay, except where the surface is rough everywhere between them. Edges between labels and open ones stay. Returns how many were unmarked.
pub fn drop_noise(mesh: &mut EditMesh, angle: f64, scale: f64, run: &Run) -> Result<usize> {
    // What is a feature at the scale asked for is no weaker there.
    let limit = WEAK * angle.to_radians();
    let mut gone = Vec::new();
    let mut seen = FxHashSet::default();
    for (k, h) in mesh.edges().filter(|&h| mesh.is_sharp(h)).enumerate() {
        if k % 256 == 0 {
            run.check()?;
        }
        let o = mesh.opposite(h);
        if o == NONE || mesh.label(h / 3) != mesh.label(o / 3) {
            continue;
        }
        let sides = rough_sides(mesh, h, scale, &mut seen);
        let [a, b] = sides.unwrap_or_else(|| [h, o].map(|side| average(mesh, side, scale, &mut seen)));
        if a.cross(b).length().atan2(a.dot(b)) < limit {
            gone.push(h);
        }
    }
    gone.iter().for_each(|&h| mesh.set_sharp(h, false));
    Ok(gone.len())
}

/// Unmarks the borders of islands: one or more faces of at most a few triangles, together smaller than `scale` across, that lie
/// within one other. A step up or down has walls; what differs from everything around without any is noise. Returns how many
/// faces went.
pub fn drop_islands(mesh: &mut EditMesh, scale: f64) -> usize {
    let (face, count) = flood(mesh);
    let mut triangles = vec![0; count];
    mesh.triangles().for_each(|t| triangles[face[t as usize] as usize] += 1);
    let is_small = |f: u32| triangles[f as usize] <= ISLAND;
    let mut sets = Sets::new(count);
    // The other face beside an island, and what is none for a border of another kind or a second neighbor.
    let mut beside = vec![NONE; count];
    let mut none = vec![false; count];
    let mut borders: Vec<(u32, u32)> = Vec::new();
    for t in mesh.triangles().filter(|&t| is_small(face[t as usize])) {
        let own = face[t as usize];
        for h in (3 * t..3 * t + 3).filter(|&h| mesh.is_sharp(h)) {
            let o = mesh.opposite(h);
            if o == NONE || mesh.label(t) != mesh.label(o / 3) {
                none[own as usize] = true;
                continue;
            }
            let other = face[(o / 3) as usize];
            if other != own && is_small(other) {
                sets.join(own, other);
            } else if other != own {
                none[own as usize] |= beside[own as usize] != NONE && beside[own as usize] != other;
                beside[own as usize] = other;
            }
            if other != own {
                borders.push((own, h));
            }
        }
    }
    let mut areas = vec![0.0; count];
    for t in mesh.triangles().filter(|&t| is_small(face[t as usize])) {
        areas[sets.find(face[t as usize]) as usize] += 0.5 * mesh.area_vector(t).length();
    }
    let mut sizes = vec![0; count];
    for f in (0..count as u32).filter(|f| is_small(*f)) {
        let root = sets.find(f) as usize;
        sizes[root] += triangles[f as usize];
        let (one, other) = (beside[root], beside[f as usize]);
        none[root] |= none[f as usize] || (one != NONE && other != NONE && one != other);
        beside[root] = if one == NONE { other } else { one };
    }
    let mut goes = |f: u32| {
        let root = sets.find(f) as usize;
        is_small(f) && sizes[root] <= ISLAND && !none[root] && beside[root] != NONE && areas[root] < scale * scale
    };
    let gone: Vec<bool> = (0..count as u32).map(&mut goes).collect();
    borders.into_iter().filter(|(f, _)| gone[*f as usize]).for_each(|(_, h)| mesh.set_sharp(h, false));
    gone.into_iter().filter(|g| *g).count()
}

/// Where the edges around that are no features are bent a lot, too: the mean area vectors of all triangles on either side,
/// whatever lies between.
fn rough_sides(mesh: &EditMesh, h: u32, scale: f64, seen: &mut FxHashSet<u32>) -> Option<[DVec3; 2]> {
    let [p, q] = [mesh.origin(h), mesh.target(h)].map(|v| mesh.point(v));
    let middle = 0.5 * (p + q);
    let up = mesh.area_vector(h / 3) + mesh.area_vector(mesh.opposite(h) / 3);
    // Points into the triangle of `h`.
    let inward = up.cross(q - p);
    seen.clear();
    let mut list = vec![h / 3, mesh.opposite(h) / 3];
    seen.extend(&list);
    let mut sides = [DVec3::ZERO; 2];
    let (mut bend, mut length) = (0.0, 0.0);
    let mut at = 0;
    while at < list.len() && at < MOST_AROUND {
        let t = list[at];
        at += 1;
        let away = mesh.centroid(t) - middle;
        if away.length() > scale && at > 2 {
            continue;
        }
        sides[usize::from(away.dot(inward) < 0.0)] += mesh.area_vector(t);
        for e in 3 * t..3 * t + 3 {
            let o = mesh.opposite(e);
            if o == NONE {
                continue;
            }
            if !mesh.is_sharp(e) {
                bend += mesh.edge_length(e) * dihedral(mesh, e);
                length += mesh.edge_length(e);
            }
            if seen.insert(o / 3) {
                list.push(o / 3);
            }
        }
    }
    (at > 2 && bend >= ROUGH * length).then_some(sides)
}

/// The mean area vector of triangles on one side of an edge, nearer ones weighted more; that of the first triangle alone
/// where the side bends so much that a mean says nothing, as the wall of a small hole.
fn average(mesh: &EditMesh, h: u32, scale: f64, seen: &mut FxHashSet<u32>) -> DVec3 {
    let middle = 0.5 * (mesh.point(mesh.origin(h)) + mesh.point(mesh.target(h)));
    seen.clear();
    let mut list = vec![h / 3];
    seen.insert(h / 3);
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    let mut at = 0;
    while at < list.len() && at < MOST_AROUND {
        let t = list[at];
        at += 1;
        let away = mesh.centroid(t).distance(middle);
        if away > scale && t != h / 3 {
            continue;
        }
        let near = (1.0 - away / scale).max(0.01);
        let vector = near * near * mesh.area_vector(t);
        sum += vector;
        total += vector.length();
        for e in 3 * t..3 * t + 3 {
            let o = mesh.opposite(e);
            if o != NONE && !mesh.is_sharp(e) && seen.insert(o / 3) {
                list.push(o / 3);
            }
        }
    }
    if sum.length() < COHERENT * total { mesh.area_vector(h / 3) } else { sum }
}

/// Pins the geometric vertices: nodes at which other than two feature edges meet, and those at which an edge turns by more
/// than `turn` degrees (\[GUO\] 2.2). Nodes that were pinned are freed unless they are vertices.
pub fn mark_vertices(mesh: &mut EditMesh, turn: f64) {
    let limit = turn.to_radians();
    for v in 0..mesh.node_capacity() as u32 {
        if !mesh.is_node(v) {
            continue;
        }
        let mut ends = mesh.sharp_neighbors(v);
        let vertex = match (ends.next(), ends.next(), ends.next()) {
            (None, ..) => false,
            (Some(a), Some(b), None) => {
                let p = mesh.point(v);
                // Zero vectors make no angle, and no vertex.
                (p - mesh.point(a)).angle_between(mesh.point(b) - p) > limit
            }
            _ => true,
        };
        drop(ends);
        mesh.set_pinned(v, vertex);
    }
}

/// The geometric edges: feature edges chained from vertex to vertex, where a vertex is a pinned node or one at which other
/// than two feature edges meet; closed ones without a vertex begin at their node of least number (\[GUO\] 2.2).
pub fn chains(mesh: &EditMesh) -> Vec<Chain> {
    let ends: Vec<bool> = (0..mesh.node_capacity() as u32)
        .map(|v| mesh.is_node(v) && (mesh.is_pinned(v) || !matches!(mesh.sharp_neighbors(v).count(), 0 | 2)))
        .collect();
    let mut seen = vec![false; 3 * mesh.triangle_capacity()];
    let mut out = Vec::new();
    for vertices_first in [true, false] {
        for v in mesh.nodes().filter(|&v| ends[v as usize] == vertices_first) {
            let starts: Vec<u32> = mesh.sharp_neighbors(v).collect();
            for x in starts {
                if let Some(h) = mesh.edge_between(v, x).filter(|&h| !seen[h as usize]) {
                    out.push(follow(mesh, v, h, &ends, &mut seen));
                }
            }
        }
    }
    out
}

fn follow(mesh: &EditMesh, start: u32, first: u32, ends: &[bool], seen: &mut [bool]) -> Chain {
    let mut chain = Chain { nodes: vec![start], edges: Vec::new(), length: 0.0 };
    let (mut v, mut h) = (start, first);
    loop {
        for side in [h, mesh.opposite(h)] {
            if side != NONE {
                seen[side as usize] = true;
            }
        }
        v = if mesh.origin(h) == v { mesh.target(h) } else { mesh.origin(h) };
        chain.nodes.push(v);
        chain.edges.push(h);
        chain.length += mesh.edge_length(h);
        if v == start || ends[v as usize] {
            return chain;
        }
        let onward = mesh.sharp_neighbors(v).filter_map(|x| mesh.edge_between(v, x)).find(|&x| !seen[x as usize]);
        match onward {
            Some(x) => h = x,
            None => return chain,
        }
    }
}

/// The geometric faces by flooding: for each triangle the number of its face, `NONE` for dead ones, and how many faces there
/// are; faces are numbered by their first triangles (\[GUO\] 2.3).
pub fn flood(mesh: &EditMesh) -> (Vec<u32>, usize) {
    let mut face = vec![NONE; mesh.triangle_capacity()];
    let mut count = 0;
    let mut stack = Vec::new();
    for t in 0..mesh.triangle_capacity() as u32 {
        if !mesh.is_triangle(t) || face[t as usize] != NONE {
            continue;
        }
        face[t as usize] = count;
        stack.push(t);
        while let Some(t) = stack.pop() {
            for h in 3 * t..3 * t + 3 {
                let o = mesh.opposite(h);
                if o != NONE && !mesh.is_sharp(h) && face[(o / 3) as usize] == NONE {
                    face[(o / 3) as usize] = count;
                    stack.push(o / 3);
                }
            }
        }
        count += 1;
    }
    (face, count as usize)
}
