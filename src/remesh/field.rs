//! The size field: what edge length each node wants.

use glam::DVec3;

use super::gaps::fitting;
use super::policy::Incoming;
use super::remesher::{FAIR, Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::NONE;
use crate::optimize::guard::find_all;
use crate::sizing::Sizing;

/// Edges longer than this many wanted lengths are halved at first.
pub(super) const COARSE: f64 = 3.0;
/// Edges shorter than this many wanted lengths are collapsed at first. With 0.3 packing still loses its way: the lens of
/// `tests/gates.rs` gets 15 % too many triangles at 3 %, with 0.6 it gets as many as by the other gates.
const NARROW: f64 = 0.6;
/// Packed triangles are this many times as many as equilateral ones of the lengths wanted: the mean of the eight solids of
/// `tests/gates.rs`, of which each has between 0.98 and 1.13 times as many.
const DENSER: f64 = 1.04;
/// How often.
const HALVINGS: usize = 20;
/// Short borders are followed down to this share of what gaps are: few edges fit around them.
const SHORTEST: f64 = 0.25;
/// Gaps that ask for less than this share of what is wanted there were not seen before.
const NEWS: f64 = 0.8;
/// An arc of half a circle is half its chord high; a curve that is farther from the middle of an edge than this share of its length,
/// 140 degrees, does not lead from one end to the other.
const ASTRAY: f64 = 0.35;
/// Along a border whose surfaces meet in an angle of which this is the sine, edges run the way their normals give.
const ALONG: f64 = 0.02;
/// Sizes that were halved around a fault may grow at least this fast from there: what is far from it stays as it was.
const STEEP: f64 = 0.5;

/// How many triangles the lengths wanted at the corners of one ask for on its area, of which the double is given.
pub fn asked_triangles(area: f64, wanted: [f64; 3]) -> f64 {
    let density: f64 = wanted.iter().map(|w| w.powi(-2)).sum();
    DENSER * 2.0 / 3.0 / 3f64.sqrt() * density * area
}

impl Remesher<'_> {
    /// What every node wants for itself: the size asked for, its faces' own sizes, and what curvature asks for; where
    /// `narrow`, what gaps between borders do, too.
    pub(super) fn ask_sizes(&mut self, narrow: bool) -> Result<()> {
        if self.work.policy.spaced {
            self.own = std::mem::take(&mut self.work.sizes);
            return self.grade();
        }
        let this = &*self;
        let own =
            find_all(this.run, this.work.mesh.node_capacity(), |v| this.work.mesh.is_node(v).then(|| this.size_at(v)))?;
        self.own = own.into_iter().map(|s| s.unwrap_or(self.options.sizing.size)).collect();
        if narrow {
            // How long edges at tips would be.
            self.grade()?;
            self.tips = self.find_tips();
            let gaps = self.across_gaps()?;
            self.bound_by(&gaps);
        }
        self.grade()
    }

    /// Looks at borders once more, now that they are where they belong: at the gaps between them, how long they are and how they
    /// bend. Returns whether some ask for much less than is wanted there.
    pub(super) fn look_at_borders_again(&mut self) -> Result<bool> {
        let mut gaps = self.across_gaps()?;
        gaps.retain(|g| g.length < NEWS * self.want[g.node as usize]);
        let before = self.own.clone();
        self.bound_by(&gaps);
        self.heed_short_borders();
        self.heed_bends();
        let any = self.own != before;
        if any {
            self.grade()?;
        }
        Ok(any)
    }

    /// Has borders follow their own bends: the curve of two surfaces may bend far more than either.
    pub(super) fn look_at_bends(&mut self) -> Result<()> {
        let before = self.own.clone();
        self.heed_bends();
        if self.own == before { Ok(()) } else { self.grade() }
    }

    /// Borders between corners that are shorter than what is wanted there ask for edges of their length.
    fn heed_short_borders(&mut self) {
        let Sizing { size, least, .. } = self.options.sizing;
        for chain in self.chains() {
            let length: f64 = chain.nodes.windows(2).map(|w| self.point(w[0]).distance(self.point(w[1]))).sum();
            if chain.closed || length > size || length < SHORTEST * self.options.narrowest {
                continue;
            }
            let fit = fitting(length, least.min(size));
            for v in [chain.nodes[0], chain.nodes[chain.nodes.len() - 1]].map(|v| v as usize) {
                if fit < NEWS * self.want[v] {
                    self.own[v] = self.own[v].min(fit);
                }
            }
        }
    }

    /// Where borders bend more than the pieces beside them the length of edges follows.
    fn heed_bends(&mut self) {
        if !self.options.sizing.varies() {
            return;
        }
        for (ends, length, off) in self.bends() {
            let size = self.options.sizing.at(8.0 * off / (length * length));
            for v in ends.map(|v| v as usize) {
                if size < NEWS * self.want[v] {
                    self.own[v] = self.own[v].min(size);
                }
            }
        }
    }

    /// Middles of edges on borders that their curve does not come near, and nodes where a border turns back on its curve.
    pub(super) fn astray(&self) -> Vec<DVec3> {
        let far = self.bends().into_iter().filter(|(_, length, off)| *off > ASTRAY * length);
        let mut places: Vec<DVec3> = far.map(|(ends, ..)| 0.5 * (self.point(ends[0]) + self.point(ends[1]))).collect();
        let turns = self.work.mesh.nodes().filter(|&v| self.rank[v as usize] == Rank::Curve && self.turns_back(v));
        places.extend(turns.map(|v| self.point(v)));
        places
    }

    /// Whether the two edges of a border at a node run opposite ways along the curve of their faces: seen with the same face to
    /// the left, the ways that the surfaces' normals give must agree.
    fn turns_back(&self, v: u32) -> bool {
        let m = &self.work.mesh;
        let sharp = |h: u32| m.is_sharp(h) && m.opposite(h) != NONE;
        let mut at = m.outgoing(v).filter(|&h| sharp(h));
        let (Some(a), Some(b)) = (at.next(), at.next()) else { return false };
        let (on, back) = (a, m.opposite(b));
        let sides = |h: u32| [m.label(h / 3), m.label(m.opposite(h) / 3)];
        if sides(on) != sides(back) || sides(on).into_iter().any(|p| self.work.stays(p)) {
            return false;
        }
        let along = |h: u32| {
            let (p, q) = (self.point(m.origin(h)), self.point(m.target(h)));
            let [l, r] = sides(h).map(|patch| self.work.normal(self.surface, patch, 0.5 * (p + q)));
            (q - p).normalize_or_zero().dot(l.cross(r))
        };
        let (x, y) = (along(on), along(back));
        x.abs().min(y.abs()) > ALONG && x * y < 0.0
    }

    /// The edges on borders: their ends, their lengths, and how far from their middles the curve is.
    fn bends(&self) -> Vec<([u32; 2], f64, f64)> {
        let m = &self.work.mesh;
        let bend = |h: u32| {
            if !m.is_triangle(h / 3) || !m.is_sharp(h) || h < m.opposite(h) || self.work.is_kept(h / 3) {
                return None;
            }
            let (ends, length) = ([m.origin(h), m.target(h)], m.edge_length(h));
            let middle = 0.5 * (self.point(ends[0]) + self.point(ends[1]));
            let on = self.work.settle(self.surface, &self.edge_set(h), middle, length)?;
            Some((ends, length, on.distance(middle)))
        };
        (0..3 * m.triangle_capacity() as u32).filter_map(bend).collect()
    }

    fn size_at(&self, v: u32) -> f64 {
        let sizing = &self.options.sizing;
        let (m, p) = (&self.work.mesh, self.point(v));
        let mut size = sizing.size.min(self.work.sizes.get(v as usize).copied().unwrap_or(f64::INFINITY));
        for r in &self.options.regions {
            size = size.min(r.at(p, self.options.grading));
        }
        size = self.options.finer.at(p, size);
        let mut last = NONE;
        for h in m.outgoing(v) {
            let patch = m.label(h / 3);
            if patch == last {
                continue;
            }
            last = patch;
            let piece = self.work.patches[patch as usize].piece;
            if piece == NONE {
                continue;
            }
            if sizing.varies()
                && let Some(k) = self.surface.curvature(piece, p)
            {
                size = size.min(sizing.at(k));
            }
            if !self.options.face_sizes.is_empty()
                && let Some(face) = self.surface.face_at(piece, m.centroid(h / 3))
                && let Some(Some(s)) = self.options.face_sizes.get(face as usize)
            {
                size = size.min(*s);
            }
        }
        size
    }

    /// Limits the growth of sizes along edges: the largest field below what nodes want with the slope asked for. It is a
    /// minimum, so the order does not matter.
    pub(super) fn grade(&mut self) -> Result<()> {
        let before = std::mem::replace(&mut self.want, self.own.clone());
        if self.want.iter().any(|w| *w != self.options.sizing.size) {
            let front = self.work.mesh.nodes().collect();
            self.spread(front, self.options.grading)?;
        }
        if self.want != before {
            self.work.mesh.set_all_changed();
        }
        Ok(())
    }

    /// About how many triangles there will be: those the area of each asks for by what its nodes want.
    pub(super) fn expected_triangles(&self) -> f64 {
        let m = &self.work.mesh;
        let of = |t: u32| asked_triangles(m.area_vector(t).length(), m.corners(t).map(|v| self.want[v as usize]));
        let kept = m.triangles().filter(|&t| self.work.is_kept(t)).count();
        m.triangles().filter(|&t| !self.work.is_kept(t)).map(of).sum::<f64>() + kept as f64
    }

    /// Lowers sizes until none grows faster than by `slope` from some nodes on.
    fn spread(&mut self, mut front: Vec<u32>, slope: f64) -> Result<()> {
        let m = &self.work.mesh;
        let want = &mut self.want;
        let mut queued = vec![false; want.len()];
        while !front.is_empty() {
            self.run.check()?;
            let mut next = Vec::new();
            for &v in &front {
                queued[v as usize] = false;
                for h in m.outgoing(v) {
                    let x = m.target(h);
                    let limit = want[v as usize] + slope * m.edge_length(h);
                    if limit < want[x as usize] {
                        want[x as usize] = limit;
                        if !queued[x as usize] {
                            queued[x as usize] = true;
                            next.push(x);
                        }
                    }
                }
            }
            front = next;
        }
        Ok(())
    }

    /// Halves edges of many wanted lengths, with flips in between, so that sizes are known everywhere: they grow as they may
    /// from where they are small, and no triangle is so long that what is inserted gets lost on it.
    pub(super) fn even_sizes(&mut self) -> Result<()> {
        if self.work.policy.incoming == Incoming::RawFine {
            self.coarsen()?;
        }
        for _ in 0..HALVINGS {
            if self.flip()? == 0 {
                break;
            }
        }
        for _ in 0..HALVINGS {
            let count = self.want.len();
            if self.split_longer(COARSE, 0.0)? == 0 {
                break;
            }
            // Within a size along a border what both ends want holds in between; elsewhere the growth from them does.
            let size = self.options.sizing.size;
            for v in count as u32..self.want.len() as u32 {
                let p = self.point(v);
                let between = self.rank[v as usize] == Rank::Curve
                    && self.work.along(v).into_iter().all(|x| self.point(x).distance(p) < size);
                if !between {
                    self.own[v as usize] = self.size_at(v);
                }
            }
            self.flip()?;
            self.grade()?;
        }
        Ok(())
    }

    /// Collapses edges much shorter than wanted. CAD programs cover cylinders and disks with needles, of which halving makes a multitude
    /// that is no better; and in a mesh of many triangles to a length packing would find its way slowly.
    fn coarsen(&mut self) -> Result<()> {
        let is_short = |r: &Self, h: u32| r.work.mesh.edge_length(h) < NARROW * r.wanted(h);
        for _ in 0..HALVINGS {
            self.run.check()?;
            let m = &self.work.mesh;
            let mut short: Vec<(f64, [u32; 2])> = m
                .edges()
                .filter(|&h| is_short(self, h))
                .map(|h| (m.edge_length(h), [m.origin(h), m.target(h)]))
                .collect();
            short.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            let mut count = 0;
            for (_, [a, b]) in short {
                let m = &self.work.mesh;
                let edge = if m.is_node(a) && m.is_node(b) { m.edge_between(a, b) } else { None };
                if let Some(h) = edge
                    && is_short(self, h)
                {
                    count += usize::from(self.collapse(h, f64::INFINITY, FAIR));
                }
            }
            if count == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Halves the sizes around some places, down to `least`. Returns whether any could be halved.
    pub(super) fn refine(&mut self, nodes: &[u32], least: f64) -> Result<bool> {
        let mut any = false;
        for &v in nodes {
            if self.rank[v as usize] != Rank::Corner || self.own[v as usize] > least {
                any |= self.own[v as usize] > least;
                self.own[v as usize] = (0.5 * self.want[v as usize]).max(least);
                self.want[v as usize] = self.want[v as usize].min(self.own[v as usize]);
            }
        }
        self.spread(nodes.to_vec(), STEEP.max(self.options.grading))?;
        self.work.mesh.set_all_changed();
        Ok(any)
    }
}
