//! Where strands of edges come so close that their chords cross, or nearly.

use glam::DVec3;

use super::Unfit;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Strands nearer than this share of how high their chords are may cross.
const CROSS: f64 = 0.25;
/// Sides of one strand so many apart, or fewer, are neighbors.
const BESIDE: usize = 2;
/// How an edge turns is told by points this share of a side away from it, at least,
const APART: f64 = 0.3;
/// and so many points farther, at most.
const LOOK: usize = 6;
/// Steps from one side to the other and back to where they are nearest.
const STEPS: usize = 8;

/// A chain of nodes along an edge, and the leaves that meet there; the first node of a closed one is not repeated.
pub(super) struct Strand {
    pub(super) nodes: Vec<u32>,
    pub(super) closed: bool,
    pub(super) leaves: [u32; 2],
}

struct Side {
    ends: [DVec3; 2],
    /// How far the edge is from its chord about.
    height: f64,
    strand: usize,
    at: usize,
}

/// The middles of sides of strands on one leaf that nearly cross.
pub(super) fn crossing_strands(strands: &[Strand], nodes: &[DVec3]) -> Unfit {
    let sides: Vec<Side> = strands.iter().enumerate().flat_map(|(k, s)| sides(k, s, nodes)).collect();
    let tree = Bvh::new(sides.iter().map(|s| Aabb::around(s.ends).grown(CROSS * s.height)).collect());
    let found = tree.pairs(&|i, j| {
        let [a, b] = [i, j].map(|k| &sides[k as usize]);
        let [s, t] = [a, b].map(|x| &strands[x.strand]);
        if !s.leaves.iter().any(|l| t.leaves.contains(l)) {
            return false;
        }
        let n = s.nodes.len();
        let apart = a.at.abs_diff(b.at);
        if a.strand == b.strand && apart.min(if s.closed { n - apart } else { n }) <= BESIDE {
            return false;
        }
        let shared = a.ends.iter().any(|p| b.ends.contains(p));
        !shared && distance(a.ends, b.ends) < CROSS * (a.height + b.height)
    });
    found.into_iter().flatten().map(|k| sides[k as usize].ends).map(|[a, b]| a.midpoint(b)).collect()
}

fn sides(strand: usize, s: &Strand, nodes: &[DVec3]) -> Vec<Side> {
    let n = s.nodes.len();
    let point = |k: usize| nodes[s.nodes[k % n] as usize];
    let count = if s.closed { n } else { n - 1 };
    let side = |k: usize| {
        let [a, b] = [point(k), point(k + 1)];
        let length = a.distance(b);
        // Points that were merged in the wrong order run back a little: the next ones farther away tell how the edge turns.
        let far = |from: DVec3, p: &DVec3| p.distance(from) >= APART * length;
        let within = |j: usize| s.closed || j < n;
        let before = (1..=LOOK).filter(|d| s.closed || *d <= k).map(|d| point(k + LOOK * n - d)).find(|p| far(a, p));
        let after = (2..LOOK + 2).filter(|d| within(k + d)).map(|d| point(k + d)).find(|p| far(b, p));
        let turns = [before.map(|p| (a - p).angle_between(b - a)), after.map(|p| (b - a).angle_between(p - b))];
        let turn = turns.into_iter().flatten().filter(|t| t.is_finite()).fold(0.0, f64::max);
        Side { ends: [a, b], height: length * turn / 8.0, strand, at: k }
    };
    (0..count).map(side).collect()
}

/// The distance of two line segments, by going from one to the other and back.
fn distance(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let mut p = a[0].midpoint(a[1]);
    let mut q = p;
    for _ in 0..STEPS {
        q = segment_foot(p, b);
        p = segment_foot(q, a);
    }
    p.distance(q)
}
