//! Nodes along the borders between patches: as many as the sizes ask for, at even steps of length over size.

use super::remesh::{Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::NONE;

/// A node is moved to a place that wants one from at most this share of a step away.
const CLAIM: f64 = 0.45;
/// Shapes around a border may become as bad as this while its nodes find their places; what follows mends them.
const POOR: f64 = 0.1;
/// The same where a node goes for good: what stays would divide the border too finely.
const SLIM: f64 = 0.02;
/// Passes of moving nodes to their places: one node may be in the way of the next.
const PASSES: usize = 3;

/// A border from corner to corner, or round and back to where it began.
struct Chain {
    nodes: Vec<u32>,
    closed: bool,
}

impl Remesher<'_> {
    /// Puts nodes on all borders at even steps. Returns how many that should go, or move, could not.
    pub(super) fn space_curves(&mut self) -> Result<usize> {
        for _ in 0..PASSES {
            let mut back = 0;
            for chain in self.chains() {
                back += chain.nodes.windows(3).filter(|w| self.straighten(w)).count();
            }
            if back == 0 {
                break;
            }
        }
        let mut left = 0;
        for chain in self.chains() {
            self.run.check()?;
            left += self.space(&chain);
        }
        Ok(left)
    }

    /// Takes a node out at which a border turns back: it was cut in the wrong order there.
    fn straighten(&mut self, w: &[u32]) -> bool {
        if w.iter().any(|&v| !self.work.mesh.is_node(v)) {
            return false;
        }
        let [a, b, c] = [w[0], w[1], w[2]].map(|v| self.point(v));
        let back = (b - a).dot(c - b) < 0.0;
        back && self.remove_along(w[1])
    }

    fn chains(&self) -> Vec<Chain> {
        let m = &self.work.mesh;
        let mut seen = vec![false; 3 * m.triangle_capacity()];
        let mut chains = Vec::new();
        for corners_first in [true, false] {
            for v in m.nodes() {
                if corners_first != (self.rank[v as usize] == Rank::Corner) || self.rank[v as usize] == Rank::Face {
                    continue;
                }
                for h in m.outgoing(v).filter(|&h| m.is_sharp(h)) {
                    if !seen[h as usize] {
                        chains.push(self.follow(h, &mut seen));
                    }
                }
            }
        }
        chains
    }

    fn follow(&self, first: u32, seen: &mut [bool]) -> Chain {
        let m = &self.work.mesh;
        let start = m.origin(first);
        let mut nodes = vec![start];
        let mut h = first;
        loop {
            for side in [h, m.opposite(h)] {
                if side != NONE {
                    seen[side as usize] = true;
                }
            }
            let v = m.target(h);
            nodes.push(v);
            if v == start || self.rank[v as usize] != Rank::Curve {
                break;
            }
            let Some(onward) = m.outgoing(v).find(|&x| m.is_sharp(x) && !seen[x as usize]) else { break };
            h = onward;
        }
        let closed = nodes.len() > 3 && nodes.last() == Some(&start) && self.rank[start as usize] == Rank::Curve;
        Chain { nodes, closed }
    }

    fn space(&mut self, chain: &Chain) -> usize {
        let nodes = &chain.nodes;
        let segments = nodes.len() - 1;
        if self.work.mesh.edge_between(nodes[0], nodes[1]).is_none_or(|h| self.work.beside_kept(h)) {
            return 0;
        }
        let mut steps = vec![0.0; nodes.len()];
        for i in 0..segments {
            let (a, b) = (nodes[i], nodes[i + 1]);
            let mean = 0.5 * (self.want[a as usize] + self.want[b as usize]);
            steps[i + 1] = steps[i] + self.point(a).distance(self.point(b)) / mean;
        }
        let total = steps[segments];
        let count = total.round().max(if chain.closed { 3.0 } else { 1.0 }) as usize;
        if !total.is_finite() || (segments == 1 && count == 1) {
            return 0;
        }
        // What becomes of each node of the chain: ends stay, others are claimed by a place or go.
        let mut claimed = vec![false; nodes.len()];
        (claimed[0], claimed[segments]) = (true, true);
        let mut moves = Vec::new();
        let mut inserts = Vec::new();
        let mut i = 0;
        for k in 1..count {
            let s = total * k as f64 / count as f64;
            while i + 1 < segments && steps[i + 1] < s {
                i += 1;
            }
            let t = (s - steps[i]) / (steps[i + 1] - steps[i]).max(f64::MIN_POSITIVE);
            let place = self.point(nodes[i]).lerp(self.point(nodes[i + 1]), t.clamp(0.0, 1.0));
            let near = if s - steps[i] <= steps[i + 1] - s { [i, i + 1] } else { [i + 1, i] };
            match near.into_iter().find(|&j| !claimed[j] && (steps[j] - s).abs() < CLAIM) {
                Some(j) => {
                    claimed[j] = true;
                    moves.push((nodes[j], place));
                }
                None => inserts.push((i, place)),
            }
        }
        let mut last = (usize::MAX, NONE);
        for (i, place) in inserts {
            let from = if last.0 == i { last.1 } else { nodes[i] };
            let Some(h) = self.work.mesh.edge_between(from, nodes[i + 1]) else { continue };
            if let Some(v) = self.insert_on(h, place) {
                last = (i, v);
            }
        }
        for _ in 0..PASSES {
            moves.retain(|&(v, place)| !self.slide(v, place));
        }
        let left = (1..segments).filter(|&i| !claimed[i]).filter(|&i| !self.remove_along(nodes[i])).count();
        for _ in 0..PASSES {
            moves.retain(|&(v, place)| !self.slide(v, place));
        }
        left + moves.len()
    }

    fn insert_on(&mut self, h: u32, place: glam::DVec3) -> Option<u32> {
        let set = self.edge_set(h);
        let m = &self.work.mesh;
        let (a, b) = (m.origin(h), m.target(h));
        let x = self.work.settle(self.surface, &set, place, m.edge_length(h))?;
        let want = 0.5 * (self.want[a as usize] + self.want[b as usize]);
        Some(self.put_on_edge(h, x, set, want))
    }

    /// Moves a node of a border along it. Returns whether nothing is left to do.
    fn slide(&mut self, v: u32, place: glam::DVec3) -> bool {
        let set = self.work.sets[v as usize];
        if self.rank[v as usize] != Rank::Curve || !self.work.mesh.is_node(v) {
            return true;
        }
        let Some(p) = self.work.settle(self.surface, &set, place, self.want[v as usize]) else { return true };
        let before = self.work.worst_around(self.surface, v, self.point(v));
        let after = self.work.worst_around(self.surface, v, p);
        let may = after >= before.min(POOR);
        if may {
            self.work.mesh.set_point(v, p);
        }
        may
    }

    /// Takes a node out of a border, towards the neighbor on it that leaves the better shapes.
    fn remove_along(&mut self, v: u32) -> bool {
        let m = &self.work.mesh;
        if !m.is_node(v) || self.rank[v as usize] != Rank::Curve {
            return false;
        }
        let before = self.work.worst_around(self.surface, v, self.point(v));
        let best = m
            .outgoing(v)
            .filter(|&h| m.is_sharp(h) && m.can_collapse(h))
            .map(|h| (self.worst_after(h, self.point(m.target(h))), h))
            .max_by(|x, y| x.0.total_cmp(&y.0));
        let Some((_, h)) = best.filter(|b| b.0 >= before.min(SLIM)) else { return false };
        let (to, p) = (self.work.mesh.target(h), self.point(self.work.mesh.target(h)));
        if self.work.mesh.collapse(h, p) {
            self.rank[to as usize] = self.rank[to as usize].max(self.rank_of(to));
            return true;
        }
        false
    }
}
