//! What edge lengths a soup's own shape asks for: curvature at a scale, and the distance between features.

use glam::DVec3;

use super::features::chains;
use super::pieces::Discrete;
use crate::mesh::edit::{NONE, next};
use crate::spatial::{Aabb, Bvh};

/// Edges between two features may be this many times as long as these are apart: triangles between them then keep angles
/// above 25 degrees.
const ACROSS: f64 = 2.0;
/// Rounds of averaging normals: enough for noise of the input's own triangles.
const MOST_ROUNDS: usize = 30;

impl Discrete {
    /// The larger magnitude of the principal curvatures at each node, from normals averaged over about `scale` around it: what
    /// is finer than that is noise. Geometric edges part the averages.
    pub fn curvatures(&self, scale: f64) -> Vec<f64> {
        let m = &self.mesh;
        let mut normals = self.corner_normals.clone();
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
            for t in m.triangles() {
                for h in 3 * t..3 * t + 3 {
                    normals[h as usize] += 0.5 * (old[next(h) as usize] + old[next(next(h)) as usize]);
                }
            }
            self.join_sectors(&mut normals);
        }
        let mut out = vec![0.0f64; m.node_capacity()];
        for t in m.triangles() {
            for h in 3 * t..3 * t + 3 {
                let length = m.edge_length(h);
                if length > 0.0 {
                    let k = normals[h as usize].distance(normals[next(h) as usize]) / length;
                    for v in [m.origin(h), m.target(h)] {
                        out[v as usize] = out[v as usize].max(k);
                    }
                }
            }
        }
        out
    }

    /// Sums corner normals over the sectors of each node, which geometric edges part, and makes them units.
    fn join_sectors(&self, normals: &mut [DVec3]) {
        let m = &self.mesh;
        for v in m.nodes() {
            super::pieces::each_sector(m, v, |sector| {
                let sum: DVec3 = sector.iter().map(|&h| normals[h as usize]).sum();
                let unit = sum.normalize_or_zero();
                sector.iter().for_each(|&h| normals[h as usize] = unit);
            });
        }
    }

    /// For each node the edge length that features nearby ask for, not less than `least`; infinite where none does. A feature
    /// asks for twice its distance to others across a common face, and twice its own length.
    pub fn feature_sizes(&self, size: f64, least: f64) -> Vec<f64> {
        let m = &self.mesh;
        let mut out = vec![f64::INFINITY; m.node_capacity()];
        let list = chains(m);
        let mut segments: Vec<([DVec3; 2], u32)> = Vec::new();
        for (c, chain) in list.iter().enumerate() {
            segments.extend(chain.nodes.windows(2).map(|w| ([m.point(w[0]), m.point(w[1])], c as u32)));
        }
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(s.0)).collect());
        let faces = |c: usize| {
            let h = list[c].edges[0];
            let o = m.opposite(h);
            [m.label(h / 3), if o == NONE { NONE } else { m.label(o / 3) }]
        };
        let share = |a: usize, b: usize| {
            let (x, y) = (faces(a), faces(b));
            x.iter().any(|f| *f != NONE && y.contains(f))
        };
        let ends = |c: usize| [list[c].nodes[0], list[c].nodes[list[c].nodes.len() - 1]];
        let beside = |a: usize, b: usize| {
            let (x, y) = (ends(a), ends(b));
            (!list[a].is_closed() || !list[b].is_closed()) && x.iter().any(|v| y.contains(v))
        };
        let distance = |k: u32, p: DVec3| {
            let [a, b] = segments[k as usize].0;
            let d = b - a;
            let t = ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            p.distance_squared(a + t * d)
        };
        for (c, chain) in list.iter().enumerate() {
            let own = if chain.is_closed() { f64::INFINITY } else { ACROSS * chain.length };
            for &v in &chain.nodes {
                let p = m.point(v);
                let far = |k: u32| {
                    let other = segments[k as usize].1 as usize;
                    if other == c || beside(c, other) || !share(c, other) { f64::INFINITY } else { distance(k, p) }
                };
                let near = tree.nearest(p, size / ACROSS, far).map_or(f64::INFINITY, |n| ACROSS * n.1.sqrt());
                let wanted = own.min(near).max(least);
                if wanted < size {
                    out[v as usize] = out[v as usize].min(wanted);
                }
            }
        }
        out
    }
}
