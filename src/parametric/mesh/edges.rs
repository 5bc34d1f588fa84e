//! Edges as chains of nodes: each is divided once, in space, and all its faces take over the nodes.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::parametric::brep::{Brep, Edge};
use crate::parametric::chart::Chart;

/// Samples per wanted length when a length is measured.
const SAMPLES: f64 = 4.0;
/// Samples between two neighboring parameters of [`pieces`](crate::parametric::Curve::pieces), at most.
const MOST_SAMPLES: usize = 400;

/// An edge divided.
#[derive(Debug, Clone, Default)]
pub(super) struct Chain {
    /// Parameters of the nodes, ascending, both ends of the edge included.
    pub(super) t: Vec<f64>,
    /// The nodes; the first and the last are those of the vertices.
    pub(super) nodes: Vec<u32>,
}

/// What edge length is wanted along edges.
pub(super) struct Wish<'a> {
    /// By curvature.
    pub(super) size_at: &'a dyn Fn(f64) -> f64,
    /// Growth of sizes per length.
    pub(super) grading: f64,
    /// Sizes asked for on single faces.
    pub(super) face_size: &'a dyn Fn(u32) -> Option<f64>,
}

/// How many parts each edge gets, and where: parameters of its nodes. `factor` multiplies the number of parts of single
/// edges.
pub(super) fn divide(edge: &Edge, charts: &[(u32, &Chart)], wish: &Wish<'_>, factor: usize, least: usize) -> Vec<f64> {
    let samples = sampled(edge, wish);
    let points: Vec<DVec3> = samples.iter().map(|t| edge.curve.at(*t)).collect();
    let mut h: Vec<f64> = Vec::with_capacity(samples.len());
    let mut last: Vec<Option<glam::DVec2>> = vec![None; charts.len()];
    for (t, p) in samples.iter().zip(&points) {
        let mut size = (wish.size_at)(edge.curve.curvature(*t));
        for (k, (face, chart)) in charts.iter().enumerate() {
            let uv = match last[k] {
                Some(uv) => chart.project_near(*p, uv),
                None => chart.project(*p),
            };
            last[k] = Some(uv);
            if let Some(c) = chart.curvature(uv) {
                size = size.min((wish.size_at)(c));
            }
            if let Some(s) = (wish.face_size)(*face) {
                size = size.min(s);
            }
        }
        h.push(size);
    }
    let step: Vec<f64> = points.windows(2).map(|w| w[0].distance(w[1])).collect();
    for i in 1..h.len() {
        h[i] = h[i].min(h[i - 1] + wish.grading * step[i - 1]);
    }
    for i in (0..h.len() - 1).rev() {
        h[i] = h[i].min(h[i + 1] + wish.grading * step[i]);
    }
    let mut sum = vec![0.0];
    for i in 0..step.len() {
        sum.push(sum[i] + step[i] / (0.5 * (h[i] + h[i + 1])));
    }
    let total = sum[sum.len() - 1];
    let parts = (total.round().clamp(1.0, 1e7) as usize).max(least) * factor;
    let mut t = vec![edge.range[0]];
    let mut i = 0;
    for k in 1..parts {
        let goal = total * k as f64 / parts as f64;
        while i + 1 < step.len() && sum[i + 1] < goal {
            i += 1;
        }
        let share = if sum[i + 1] > sum[i] { (goal - sum[i]) / (sum[i + 1] - sum[i]) } else { 0.5 };
        t.push(samples[i] + share.clamp(0.0, 1.0) * (samples[i + 1] - samples[i]));
    }
    t.push(edge.range[1]);
    t
}

fn sampled(edge: &Edge, wish: &Wish<'_>) -> Vec<f64> {
    let pieces = edge.curve.pieces(edge.range);
    let mut out = vec![pieces[0]];
    for w in pieces.windows(2) {
        let middle = 0.5 * (w[0] + w[1]);
        let [a, m, b] = [w[0], middle, w[1]].map(|t| edge.curve.jet(t));
        let length = a[0].distance(m[0]) + m[0].distance(b[0]);
        let size = (wish.size_at)(edge.curve.curvature(middle));
        let parts = ((SAMPLES * length / size).ceil().min(MOST_SAMPLES as f64) as usize).max(2);
        out.extend((1..=parts).map(|k| w[0] + (w[1] - w[0]) * k as f64 / parts as f64));
    }
    out
}

/// The least number of parts that keeps loops from collapsing: three for a closed edge, two for each of several edges
/// between the same vertices, and enough for every loop to have three nodes.
pub(super) fn least_parts(brep: &Brep) -> Vec<usize> {
    let mut least = vec![1; brep.edges.len()];
    let mut between: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (i, e) in brep.edges.iter().enumerate() {
        let [a, b] = e.ends;
        if a == b {
            least[i] = 3;
            continue;
        }
        let key = [a.min(b), a.max(b)];
        if let Some(&first) = between.get(&key) {
            least[first as usize] = 2;
            least[i] = 2;
        } else {
            between.insert(key, i as u32);
        }
    }
    for l in brep.faces.iter().flat_map(|f| &f.loops) {
        if l.len() == 2 && l[0].edge != l[1].edge {
            for c in l {
                least[c.edge as usize] = least[c.edge as usize].max(2);
            }
        }
    }
    least
}
