//! What edge lengths a soup's own shape asks for: curvature at a scale, and the distance between features.

use glam::DVec3;

use super::features::{Chain, chains};
use super::pieces::{Discrete, each_sector};
use crate::mesh::EditMesh;
use crate::mesh::edit::{NONE, next, prev};
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Edges between two features may be this many times as long as these are apart: triangles between them then keep angles
/// above 25 degrees.
const ACROSS: f64 = 2.0;
/// Edges may be this many times as long as a short feature between two corners: triangles upon it then have angles near 40
/// degrees.
const OWN: f64 = 1.5;
/// Parts per size into which feature edges close to others are divided, and how many at most.
const SPACING: f64 = 2.0;
const MOST_PARTS: f64 = 1e5;
/// Rounds of averaging normals: enough for noise of the input's own triangles.
const MOST_ROUNDS: usize = 30;

/// The larger magnitude of the principal curvatures at the origin of each half-edge, from corner normals averaged over
/// about `scale`: what is finer than that is noise. Geometric edges part the averages.
pub(super) fn curvatures(m: &EditMesh, corner_normals: &[DVec3], scale: f64) -> Vec<f64> {
    let mut normals = corner_normals.to_vec();
    let (mut sum, mut count) = (0.0, 0usize);
    for h in m.edges() {
        sum += m.edge_length(h);
        count += 1;
    }
    let mean = if count > 0 { sum / count as f64 } else { 0.0 };
    // Each round averages over about an edge length; the spread grows with the root of their number.
    let rounds = if mean > 0.0 { ((scale / mean).powi(2).round() as usize).min(MOST_ROUNDS) } else { 0 };
    for _ in 0..rounds {
        let old = normals.clone();
        for h in m.triangles().flat_map(|t| 3 * t..3 * t + 3) {
            normals[h as usize] += 0.5 * (old[next(h) as usize] + old[prev(h) as usize]);
        }
        for v in m.nodes() {
            each_sector(m, v, |sector| {
                let unit = sector.iter().map(|&h| normals[h as usize]).sum::<DVec3>().normalize_or_zero();
                sector.iter().for_each(|&h| normals[h as usize] = unit);
            });
        }
    }
    // Over less than that normals differ by what is left of the noise: slivers, as marching cubes make them, would bend a lot.
    let shortest = mean.min(scale);
    let mut out = vec![0.0f64; normals.len()];
    for h in m.triangles().flat_map(|t| 3 * t..3 * t + 3) {
        let length = m.edge_length(h);
        if length > 0.0 {
            let k = normals[h as usize].distance(normals[next(h) as usize]) / length.max(shortest);
            for end in [h, next(h)] {
                out[end as usize] = out[end as usize].max(k);
            }
        }
    }
    for v in m.nodes() {
        each_sector(m, v, |sector| {
            let most = sector.iter().map(|&h| out[h as usize]).fold(0.0, f64::max);
            sector.iter().for_each(|&h| out[h as usize] = most);
        });
    }
    out
}

impl Discrete {
    /// How many times as many triangles the lengths `wanted` at curvatures make as those wanted on planes would.
    pub fn crowding(&self, wanted: impl Fn(f64) -> f64) -> f64 {
        let plain = wanted(0.0).powi(2);
        let sums = self.sheets.iter().map(|s| s.crowding(&wanted)).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        if sums[0] > 0.0 { plain * sums[1] / sums[0] } else { 1.0 }
    }

    /// For each node the edge length that features nearby ask for, between `least` and `size`; infinite where none does. A
    /// feature asks for twice its distance to others across a common face, and for half as much again as its own length.
    pub fn feature_sizes(&self, size: f64, least: f64) -> Vec<f64> {
        let near = Proximity::new(&self.mesh, size);
        let mut out = vec![f64::INFINITY; self.mesh.node_capacity()];
        for (c, chain) in near.chains.iter().enumerate() {
            for &v in &chain.nodes {
                let wanted = near.wanted(c, self.mesh.point(v)).max(least);
                if wanted < size {
                    out[v as usize] = out[v as usize].min(wanted);
                }
            }
        }
        out
    }
}

/// Divides long feature edges that pass others closely, so that sizes can differ along them; labels must be faces.
pub(super) fn divide_features(mesh: &mut EditMesh, size: f64) {
    let near = Proximity::new(mesh, size);
    let mut long = Vec::new();
    for (c, chain) in near.chains.iter().enumerate() {
        for &h in &chain.edges {
            let (p, q) = (mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
            let parts = (SPACING * p.distance(q) / size).ceil().min(MOST_PARTS) as usize;
            if (1..parts).any(|k| near.wanted(c, p.lerp(q, k as f64 / parts as f64)) < size) {
                long.push((h, parts));
            }
        }
    }
    for (h, parts) in long {
        let (p, q) = (mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
        // From the far end: the half-edge keeps its origin.
        for k in (1..parts).rev() {
            mesh.split_edge(h, p.lerp(q, k as f64 / parts as f64));
        }
    }
}

/// Geometric edges and how close others pass.
struct Proximity {
    chains: Vec<Chain>,
    /// For each chain the faces on both sides.
    faces: Vec<[u32; 2]>,
    segments: Vec<([DVec3; 2], u32)>,
    tree: Bvh,
    size: f64,
}

impl Proximity {
    fn new(m: &EditMesh, size: f64) -> Self {
        let chains = chains(m);
        let mut segments: Vec<([DVec3; 2], u32)> = Vec::new();
        for (c, chain) in chains.iter().enumerate() {
            segments.extend(chain.nodes.windows(2).map(|w| ([m.point(w[0]), m.point(w[1])], c as u32)));
        }
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(s.0)).collect());
        let sides = |h: u32| [h, m.opposite(h)].map(|s| if s == NONE { NONE } else { m.label(s / 3) });
        let faces = chains.iter().map(|c| sides(c.edges[0])).collect();
        Self { chains, faces, segments, tree, size }
    }

    fn ends(&self, c: usize) -> [u32; 2] {
        [self.chains[c].nodes[0], self.chains[c].nodes[self.chains[c].nodes.len() - 1]]
    }

    /// Whether the distance between two chains says how narrow a face is: they share one, and do not meet.
    fn are_across(&self, a: usize, b: usize) -> bool {
        let meet = self.ends(a).iter().any(|v| self.ends(b).contains(v));
        a != b && !meet && self.faces[a].iter().any(|f| *f != NONE && self.faces[b].contains(f))
    }

    /// The edge length wanted at a point of a chain.
    fn wanted(&self, c: usize, p: DVec3) -> f64 {
        let far = |k: u32| {
            let (segment, other) = self.segments[k as usize];
            if !self.are_across(c, other as usize) {
                return f64::INFINITY;
            }
            p.distance_squared(segment_foot(p, segment))
        };
        let chain = &self.chains[c];
        let own = if chain.is_closed() { f64::INFINITY } else { OWN * chain.length };
        self.tree.nearest(p, self.size / ACROSS, far).map_or(own, |n| own.min(ACROSS * n.1.sqrt()))
    }
}
