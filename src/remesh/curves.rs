//! Nodes along the borders between patches: as many as the sizes ask for, at even steps of length over size.

use glam::DVec3;

use super::remesher::{Rank, Remesher};
use super::strips::{Track, Zone};
use crate::error::Result;
use crate::mesh::edit::NONE;

/// A node is moved to a place that wants one from at most this share of a step away.
const CLAIM: f64 = 0.45;
/// Shapes around a border may become as bad as this while its nodes find their places; what follows mends them.
const POOR: f64 = 0.1;
/// The same where a node goes for good: what stays would divide the border too finely.
const SLIM: f64 = 0.02;
/// Nodes inside patches are in the way of a border within this many wanted lengths of it.
const BESIDE: f64 = 0.5;
/// Passes of moving nodes to their places: one node may be in the way of the next.
const PASSES: usize = 3;

/// A border from corner to corner, or round and back to where it began.
pub(super) struct BorderChain {
    pub(super) nodes: Vec<u32>,
    pub(super) closed: bool,
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
        let mut chains = self.chains();
        let zones = self.zones(&chains);
        let tracks: Vec<Track> = chains.iter().zip(&zones).map(|(c, z)| self.track(c, z)).collect();
        let strips = self.strips(&chains, &tracks);
        let mut made: Vec<Vec<DVec3>> = vec![Vec::new(); chains.len()];
        let mut left = 0;
        for (c, lead, between) in strips.order() {
            self.run.check()?;
            let (c, track) = (c as usize, &tracks[c as usize]);
            let lead = lead.filter(|_| zones[c].is_empty());
            let places = lead.and_then(|l| track.between(&made[l as usize], !between)).unwrap_or_else(|| track.even());
            let points = places.iter().map(|s| track.at(*s));
            made[c] = if track.closed {
                points.chain(places.first().map(|s| track.at(*s))).collect()
            } else {
                let ends = [0, track.points.len() - 1].map(|i| track.points[i]);
                [ends[0]].into_iter().chain(points).chain([ends[1]]).collect()
            };
            left += self.space(&mut chains[c], &places, &zones[c]);
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

    pub(super) fn chains(&self) -> Vec<BorderChain> {
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

    fn follow(&self, first: u32, seen: &mut [bool]) -> BorderChain {
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
        BorderChain { nodes, closed }
    }

    /// Puts the nodes of a border at places counted in steps.
    fn space(&mut self, chain: &mut BorderChain, places: &[f64], zones: &[Zone]) -> usize {
        let segments = chain.nodes.len() - 1;
        if self.work.mesh.edge_between(chain.nodes[0], chain.nodes[1]).is_none_or(|h| self.work.beside_kept(h)) {
            return 0;
        }
        let mut places = places.to_vec();
        let mut start = None;
        if chain.closed {
            start = self.turn_to(chain, &mut places);
        }
        let nodes = &chain.nodes;
        let track = self.track(chain, zones);
        let total = track.total();
        if !total.is_finite() || (segments == 1 && places.is_empty()) {
            return 0;
        }
        // What becomes of each node of the chain: ends stay, others are claimed by a place or go.
        let mut claimed = vec![false; nodes.len()];
        (claimed[0], claimed[segments]) = (true, true);
        let mut moves: Vec<(u32, DVec3)> = start.map(|p| (nodes[0], p)).into_iter().collect();
        let mut inserts = Vec::new();
        let mut i = 0;
        for s in places {
            while i + 1 < segments && track.up_to(i + 1) < s {
                i += 1;
            }
            let place = track.at(s);
            let near = if s - track.up_to(i) <= track.up_to(i + 1) - s { [i, i + 1] } else { [i + 1, i] };
            match near.into_iter().find(|&j| !claimed[j] && (track.up_to(j) - s).abs() < CLAIM) {
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
        let left = (1..segments).filter(|&i| !claimed[i]).filter(|&i| !self.clear_away(nodes[i])).count();
        for _ in 0..PASSES {
            moves.retain(|&(v, place)| !self.slide(v, place));
        }
        left + moves.len()
    }

    /// Has a closed border begin at the node nearest to one of the places, which becomes that node's; the others are counted from
    /// there then. Returns where the node shall be.
    fn turn_to(&self, chain: &mut BorderChain, places: &mut Vec<f64>) -> Option<DVec3> {
        let track = self.track(chain, &[]);
        let (total, last) = (track.total(), chain.nodes.len() - 1);
        let off = |s: f64, p: f64| {
            let d = (p - s).rem_euclid(total);
            if d > 0.5 * total { d - total } else { d }
        };
        let mut best: Option<(f64, usize, usize)> = None;
        for (i, s) in track.steps[..last].iter().enumerate() {
            for (k, p) in places.iter().enumerate() {
                let d = off(*s, *p).abs();
                if best.is_none_or(|b| d < b.0) {
                    best = Some((d, i, k));
                }
            }
        }
        let (_, i, k) = best?;
        let p = track.at(places.remove(k));
        let from = track.steps[i];
        places.iter_mut().for_each(|s| *s = (*s - from).rem_euclid(total));
        places.sort_by(f64::total_cmp);
        chain.nodes.pop();
        chain.nodes.rotate_left(i);
        chain.nodes.push(chain.nodes[0]);
        Some(p)
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

    /// Takes a node out of a border, and where that cannot be nodes inside patches that are in the way: packing will put others.
    fn clear_away(&mut self, v: u32) -> bool {
        if self.remove_along(v) {
            return true;
        }
        let m = &self.work.mesh;
        if !m.is_node(v) || self.rank[v as usize] != Rank::Curve {
            return false;
        }
        let close = |x: u32| self.point(x).distance(self.point(v)) < BESIDE * self.want[v as usize];
        let inner: Vec<u32> = m.neighbors(v).filter(|&x| self.rank[x as usize] == Rank::Face && close(x)).collect();
        let mut gone = false;
        for x in inner {
            let m = &self.work.mesh;
            let Some(h) = m.edge_between(x, v).filter(|&h| m.can_collapse(h)) else { continue };
            let p = self.point(v);
            gone |= self.worst_after(h, p) >= SLIM && self.work.mesh.collapse(h, p);
        }
        gone && self.remove_along(v)
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
