//! Tips: where two borders of a patch meet in a narrow angle. The triangle at a tip has the tip's angle whatever its size; behind it
//! rows of triangles grow with the width.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::curves::BorderChain;
use super::gaps::{BorderGap, ROW};
use super::remesher::{Rank, Remesher};
use super::strips::Zone;
use crate::error::Result;
use crate::mesh::edit::{next, prev};
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Borders that meet in a smaller angle than this, radians, end in a tip.
const NARROW: f64 = 0.75;
/// Edges beside a tip are at least this share of those at it: where it is narrower than some 8 degrees angles are bad whatever is done.
const LEAST: f64 = 0.15;
/// Widths are looked at this often in each step.
const FINE: f64 = 4.0;
/// A tip is no longer than this many edges at it.
const LONGEST: f64 = 8.0;

/// Where two borders of a patch meet in a narrow angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct BorderTip {
    node: u32,
    patch: u32,
    /// How long edges there would be without regard to the gap between the borders.
    reach: f64,
}

/// A line, and how long it is up to each of its points.
struct TipLine {
    points: Vec<DVec3>,
    lengths: Vec<f64>,
    wants: Vec<f64>,
}

impl TipLine {
    fn total(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The point after some length, and what length is wanted there.
    fn at(&self, s: f64) -> (DVec3, f64) {
        let i = self.lengths.partition_point(|x| *x < s).clamp(1, self.points.len() - 1);
        let t = (s - self.lengths[i - 1]) / (self.lengths[i] - self.lengths[i - 1]).max(f64::MIN_POSITIVE);
        let t = t.clamp(0.0, 1.0);
        (self.points[i - 1].lerp(self.points[i], t), self.wants[i - 1] * (1.0 - t) + self.wants[i] * t)
    }

    fn distance(&self, p: DVec3) -> f64 {
        let to = |w: &[DVec3]| segment_foot(p, [w[0], w[1]]).distance_squared(p);
        self.points.windows(2).map(to).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Lengths wanted along the line beside another one that leaves the same tip, up to where the gap between them asks for
    /// nothing, or up to `end`.
    fn beside(&self, other: &Self, reach: f64, end: f64) -> Vec<Zone> {
        let mut zones = vec![Zone { from: 0.0, to: reach, want: reach }];
        let mut s = reach;
        while s < end.min(LONGEST * reach) {
            let (p, want) = self.at(s);
            let row = (ROW * other.distance(p)).max(LEAST * reach);
            if row >= want {
                return zones;
            }
            let to = s + row / FINE;
            zones.push(Zone { from: s, to, want: row });
            s = to;
        }
        zones
    }
}

impl Remesher<'_> {
    /// Bounds what nodes want by the gaps between borders, but for tips: the triangle there may be as large as it would be
    /// without the gap it lies in.
    pub(super) fn bound_by(&mut self, gaps: &[BorderGap]) {
        for gap in gaps {
            for tip in self.tips.iter_mut().filter(|t| t.node == gap.node && t.patch != gap.patch) {
                tip.reach = tip.reach.min(gap.length);
            }
        }
        let m = &self.work.mesh;
        let at = |t: &BorderTip| m.point(t.node);
        let tree = Bvh::new(self.tips.iter().map(|t| Aabb::new(at(t), at(t)).grown(t.reach)).collect());
        for gap in gaps {
            let p = m.point(gap.node);
            let mut within = false;
            tree.overlapping(&Aabb::new(p, p), |k| {
                let tip = &self.tips[k as usize];
                within |= tip.patch == gap.patch && at(tip).distance(p) < tip.reach;
            });
            if !within {
                let own = &mut self.own[gap.node as usize];
                *own = own.min(gap.length);
            }
        }
    }

    pub(super) fn find_tips(&self) -> Vec<BorderTip> {
        let corners = self.work.mesh.nodes().filter(|&v| self.rank[v as usize] == Rank::Corner);
        let at = |node: u32| {
            let reach = self.want[node as usize];
            self.narrow_at(node).into_iter().map(move |(patch, _)| BorderTip { node, patch, reach })
        };
        corners.flat_map(at).collect()
    }

    /// Patches that are narrow at a corner, with the next nodes of the two borders there.
    fn narrow_at(&self, v: u32) -> Vec<(u32, [u32; 2])> {
        let m = &self.work.mesh;
        let around: Vec<u32> = m.outgoing(v).collect();
        let Some(first) = around.iter().position(|&h| m.is_sharp(h)) else { return Vec::new() };
        let (p, mut angle, mut start) = (m.point(v), 0.0, around[first]);
        let mut found = Vec::new();
        for k in 0..around.len() {
            let (h, next) = (around[(first + k) % around.len()], around[(first + k + 1) % around.len()]);
            angle += (m.point(m.target(h)) - p).angle_between(m.point(m.apex(h)) - p);
            if m.is_sharp(next) {
                if angle < NARROW && m.label(start / 3) == m.label(h / 3) {
                    found.push((m.label(h / 3), [m.target(start), m.target(next)]));
                }
                (angle, start) = (0.0, next);
            }
        }
        found
    }

    fn line(&self, nodes: impl Iterator<Item = u32>) -> TipLine {
        let nodes: Vec<u32> = nodes.collect();
        let points: Vec<DVec3> = nodes.iter().map(|&v| self.point(v)).collect();
        let mut lengths = vec![0.0; points.len()];
        for i in 1..points.len() {
            lengths[i] = lengths[i - 1] + points[i].distance(points[i - 1]);
        }
        TipLine { points, lengths, wants: nodes.iter().map(|&v| self.want[v as usize]).collect() }
    }

    /// For each border the parts of it beside tips, in the order along it.
    pub(super) fn zones(&self, chains: &[BorderChain]) -> Vec<Vec<Zone>> {
        let mut zones = vec![Vec::new(); chains.len()];
        if self.tips.is_empty() {
            return zones;
        }
        let mut ends: FxHashMap<[u32; 2], (usize, bool)> = FxHashMap::default();
        for (c, chain) in chains.iter().enumerate().filter(|c| !c.1.closed) {
            let n = &chain.nodes;
            ends.insert([n[0], n[1]], (c, false));
            ends.insert([n[n.len() - 1], n[n.len() - 2]], (c, true));
        }
        let out = |(c, back): (usize, bool)| {
            let nodes = &chains[c].nodes;
            if back { self.line(nodes.iter().rev().copied()) } else { self.line(nodes.iter().copied()) }
        };
        for tip in &self.tips {
            for (_, next) in self.narrow_at(tip.node).into_iter().filter(|n| n.0 == tip.patch) {
                let [Some(a), Some(b)] = next.map(|x| ends.get(&[tip.node, x]).copied()) else { continue };
                let lines = [out(a), out(b)];
                if lines.iter().any(|l| l.total() < 2.0 * tip.reach) {
                    continue;
                }
                for ((c, back), own, other) in [(a, &lines[0], &lines[1]), (b, &lines[1], &lines[0])] {
                    let total = own.total();
                    let found = own.beside(other, tip.reach, 0.5 * total);
                    let turned = |z: Zone| Zone { from: total - z.to, to: total - z.from, ..z };
                    zones[c].extend(found.into_iter().map(|z| if back { turned(z) } else { z }));
                }
            }
        }
        zones.iter_mut().for_each(|z| z.sort_by(|a, b| a.from.total_cmp(&b.from)));
        zones
    }

    /// Whether a node of a border is the next one to a tip: the triangle there gets no better by moving it.
    pub(super) fn is_beside_tip(&self, v: u32) -> bool {
        let m = &self.work.mesh;
        let is_tip = |[a, b]: [u32; 2]| {
            // The one leaves the tip, the other comes to it.
            let (tip, ends) = (m.origin(a), [m.target(a), m.origin(b)]);
            let [x, y] = ends.map(|e| m.point(e) - m.point(tip));
            self.rank[tip as usize] == Rank::Corner && m.is_sharp(a) && m.is_sharp(b) && x.angle_between(y) < NARROW
        };
        self.tips_spaced && m.outgoing(v).any(|h| is_tip([next(h), h]) || is_tip([prev(h), next(h)]))
    }

    /// Has nodes beside tips want what the spacing there is.
    pub(super) fn heed_tips(&mut self) -> Result<()> {
        if self.tips.is_empty() {
            return Ok(());
        }
        let chains = self.chains();
        let zones = self.zones(&chains);
        // The numbers of their nodes do not last.
        self.tips.clear();
        self.tips_spaced = true;
        for (chain, zones) in chains.iter().zip(zones) {
            let mut s = 0.0;
            for w in chain.nodes.windows(3) {
                let [before, after] = [w[0], w[2]].map(|v| self.point(v).distance(self.point(w[1])));
                s += before;
                if zones.iter().any(|z| z.want < after.max(before) && z.from <= s && s <= z.to) {
                    let own = &mut self.own[w[1] as usize];
                    *own = own.min(0.5 * (before + after));
                }
            }
        }
        self.grade()
    }
}
