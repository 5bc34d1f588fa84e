//! The remesher: split, collapse, flip and relocate on a [`Patchwork`], every node staying on its pieces.
//!
//! The loop is that of M. Botsch and L. Kobbelt, "A remeshing approach to multiresolution modeling" (2004), with every
//! operation guarded by the shape of the triangles it makes, seen along the surface's own normals: a triangle that
//! faces the wrong way has a negative shape, so the same guard untangles what cutting has folded.

use glam::DVec3;

use super::RemeshOptions;
use super::patchwork::{Patchwork, PieceSet};
use super::tips::BorderTip;
use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::edit::{ChangeReader, NONE};
use crate::run::Run;
pub(super) use crate::sizing::{LONG, SHORT};

/// Edges longer than this many times what either end wants leave the surface where it turns.
const STRETCHED: f64 = 1.8;
/// A collapse or split that makes things worse must still leave shapes of at least this.
pub(super) const FAIR: f64 = 0.35;
/// Shapes from here on are good enough not to be guarded: a triangle of this shape has no angle below 24 degrees.
pub(super) const GOOD: f64 = 0.6;

/// No flip makes a triangle of a smaller shape than this, whichever way it faces, if there was none: beside creases normals
/// may mislead.
pub(super) const SLIVER: f64 = 0.004;

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    Face,
    Curve,
    Corner,
}

/// A patchwork under work.
#[derive(Clone)]
pub(super) struct Remesher<'a> {
    pub(super) work: Patchwork,
    pub(super) surface: &'a dyn Pieces,
    /// Edge length each node wants for itself.
    pub(super) own: Vec<f64>,
    /// The same after gradation: what counts.
    pub(super) want: Vec<f64>,
    pub(super) rank: Vec<Rank>,
    /// Where two borders meet in a narrow angle, as far as that counts for sizes.
    pub(super) tips: Vec<BorderTip>,
    /// Whether the nodes next to them are where they shall stay.
    pub(super) tips_spaced: bool,
    /// Whether this is a part of a mesh, whose boundary stays.
    pub(super) alone: bool,
    /// Nodes on cuts within a patch, which stay for now but shall go; none at all if this is empty.
    pub(super) open: Vec<bool>,
    /// Nodes around which edges and triangles are looked at; all if there is none.
    pub(super) focus: Option<Vec<bool>>,
    /// Shapes of triangles at the nodes of which nothing changed since, where they do not depend on neighbors.
    pub(super) shapes: Vec<f64>,
    pub(super) options: &'a RemeshOptions,
    pub(super) run: &'a Run,
}

impl<'a> Remesher<'a> {
    pub(super) fn new(
        work: Patchwork,
        surface: &'a dyn Pieces,
        options: &'a RemeshOptions,
        run: &'a Run,
    ) -> Result<Self> {
        let count = work.mesh.node_capacity();
        let (own, want) = (vec![options.sizing.size; count], vec![options.sizing.size; count]);
        let mut this = Self {
            work,
            surface,
            own,
            want,
            rank: Vec::new(),
            tips: Vec::new(),
            tips_spaced: false,
            alone: false,
            open: Vec::new(),
            focus: None,
            shapes: Vec::new(),
            options,
            run,
        };
        this.rank = (0..count as u32).map(|v| this.rank_of(v)).collect();
        Ok(this)
    }

    /// Has what follows look only at nodes on borders and their neighbors, as they are now, and at nodes made from here on.
    pub(super) fn look_at_borders(&mut self) {
        let m = &self.work.mesh;
        let mut focus = vec![false; m.node_capacity()];
        for v in m.nodes().filter(|&v| self.rank[v as usize] != Rank::Face) {
            focus[v as usize] = true;
            m.neighbors(v).for_each(|x| focus[x as usize] = true);
        }
        self.focus = Some(focus);
        self.work.mesh.set_none_seen(ChangeReader::Focus);
    }

    /// Has what follows look only at some nodes and those up to `rings` edges away, and at nodes made from here on.
    pub(super) fn look_around(&mut self, mut focus: Vec<bool>, rings: usize) {
        let m = &self.work.mesh;
        focus.resize(m.node_capacity(), false);
        for _ in 0..rings {
            let front: Vec<u32> = m.nodes().filter(|&v| focus[v as usize]).collect();
            front.iter().for_each(|&v| m.neighbors(v).for_each(|x| focus[x as usize] = true));
        }
        self.focus = Some(focus);
        self.work.mesh.set_none_seen(ChangeReader::Focus);
    }

    /// Has what follows look at all nodes.
    pub(super) fn look_everywhere(&mut self) {
        self.focus = None;
    }

    /// Whether a node lies on a cut.
    pub(super) fn is_open(&self, v: u32) -> bool {
        self.open.get(v as usize).copied().unwrap_or(false)
    }

    /// Whether a node is to be looked at.
    pub(super) fn sees(&self, v: u32) -> bool {
        self.focus.as_ref().is_none_or(|f| f.get(v as usize).copied().unwrap_or(true))
    }

    pub(super) fn rank_of(&self, v: u32) -> Rank {
        if !self.work.mesh.is_node(v) {
            return Rank::Face;
        }
        if self.work.mesh.outgoing(v).any(|h| self.work.is_kept(h / 3)) {
            return Rank::Corner;
        }
        match self.work.mesh.sharp_neighbors(v).count() {
            _ if self.work.mesh.is_pinned(v) || self.stays(v) => Rank::Corner,
            0 => Rank::Face,
            2 if self.work.sets[v as usize].len() == 2 => Rank::Curve,
            _ => Rank::Corner,
        }
    }

    /// Whether a node is known to other parts of the mesh.
    pub(super) fn stays(&self, v: u32) -> bool {
        (self.alone || self.work.policy.goes_on) && self.work.mesh.is_boundary(v)
    }

    pub(super) fn point(&self, v: u32) -> DVec3 {
        self.work.mesh.point(v)
    }

    /// The triangles that face the wrong way.
    pub(super) fn folded(&self) -> Vec<u32> {
        self.work.mesh.triangles().filter(|&t| self.shape(t) <= 0.0).collect()
    }

    /// The [shape](Patchwork::shape) of a triangle; the surface is not asked again where nothing changed.
    pub(super) fn shape(&self, t: u32) -> f64 {
        let m = &self.work.mesh;
        match self.shapes.get(t as usize) {
            Some(known) if !m.corners(t).into_iter().any(|v| m.is_changed(v, ChangeReader::Facing)) => *known,
            _ => self.work.shape(self.surface, t),
        }
    }

    pub(super) fn wanted(&self, h: u32) -> f64 {
        let m = &self.work.mesh;
        self.want[m.origin(h) as usize].min(self.want[m.target(h) as usize])
    }

    /// Whether an edge between two nodes of a bent patch becomes longer, and far longer than wanted: on the other side of a crevice
    /// triangles may face the right way.
    pub(super) fn stretches(&self, patch: u32, [a, b]: [u32; 2], from: f64, to: f64) -> bool {
        let far = to > from && to > STRETCHED * self.want[a as usize].max(self.want[b as usize]);
        far && self.work.patches[patch as usize].plane.is_none()
    }

    /// The pieces a new node on an edge lies on.
    pub(super) fn edge_set(&self, h: u32) -> PieceSet {
        self.work.edge_set(self.surface, h)
    }

    /// Splits edges that are too long, longest first.
    pub(super) fn split_long(&mut self) -> Result<usize> {
        self.split_longer(LONG, 0.5 * FAIR)
    }

    /// Splits edges longer than `long` wanted lengths, longest first, where shapes do not fall below `fair`, or rise.
    pub(super) fn split_longer(&mut self, long: f64, fair: f64) -> Result<usize> {
        let mut list: Vec<(f64, u32, u32)> = Vec::new();
        let m = &self.work.mesh;
        for h in m.edges().filter(|&h| self.sees(m.origin(h)) && self.sees(m.target(h))) {
            let excess = m.edge_length(h) / (long * self.wanted(h));
            if excess > 1.0 {
                list.push((excess, m.origin(h), m.target(h)));
            }
        }
        list.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
        let mut count = 0;
        for (k, (_, a, b)) in list.into_iter().enumerate() {
            if k % 256 == 0 {
                self.run.check()?;
            }
            if let Some(h) = self.work.mesh.edge_between(a, b) {
                count += usize::from(self.split(h, fair));
            }
        }
        Ok(count)
    }

    /// Puts a node into the middle of an edge, if the surface and the shapes allow.
    pub(super) fn split(&mut self, h: u32, fair: f64) -> bool {
        let set = self.edge_set(h);
        let m = &self.work.mesh;
        let (a, b) = (m.origin(h), m.target(h));
        // A crease or an open border nothing is known of but that it is there.
        if ((m.is_sharp(h) || m.opposite(h) == NONE) && set.len() < 2) || self.work.beside_kept(h) {
            return false;
        }
        let (p, q) = (self.point(a), self.point(b));
        let Some(x) = self.work.settle(self.surface, &set, 0.5 * (p + q), 0.5 * p.distance(q)) else { return false };
        let (mut before, mut after) = (f64::INFINITY, f64::INFINITY);
        for side in [h, m.opposite(h)] {
            if side == NONE {
                continue;
            }
            let (label, c) = (m.label(side / 3), self.point(m.apex(side)));
            let (s, e) = (self.point(m.origin(side)), self.point(m.target(side)));
            before = before.min(self.work.shape_at(self.surface, label, [s, e, c]));
            after = after.min(self.work.shape_at(self.surface, label, [s, x, c]));
            after = after.min(self.work.shape_at(self.surface, label, [x, e, c]));
        }
        if after < before.min(fair) {
            return false;
        }
        let want = 0.5 * (self.want[a as usize] + self.want[b as usize]);
        self.put_on_edge(h, x, set, want);
        true
    }

    /// Puts a node on an edge, whatever the shapes.
    pub(super) fn put_on_edge(&mut self, h: u32, x: DVec3, set: PieceSet, want: f64) -> u32 {
        let rank = if self.work.mesh.is_sharp(h) { Rank::Curve } else { Rank::Face };
        let v = self.work.mesh.split_edge(h, x);
        self.know(set, want, rank);
        v
    }

    /// Notes what a node is that was just made.
    pub(super) fn know(&mut self, set: PieceSet, want: f64, rank: Rank) {
        self.work.sets.push(set);
        self.own.push(want);
        self.want.push(want);
        self.rank.push(rank);
    }

    /// Collapses edges shorter than `short` wanted lengths, shortest first.
    pub(super) fn collapse_short(&mut self, short: f64) -> Result<usize> {
        let mut count = 0;
        // What was refused is tried again only where something changed since.
        let mut changed = vec![true; self.work.mesh.node_capacity()];
        loop {
            let m = &self.work.mesh;
            let mut list: Vec<(f64, u32, u32)> = Vec::new();
            let due = |h: &u32| {
                let ends = [m.origin(*h), m.target(*h)];
                ends.iter().any(|v| changed[*v as usize]) && ends.iter().all(|v| self.sees(*v))
            };
            for h in m.edges().filter(due) {
                let share = m.edge_length(h) / (short * self.wanted(h));
                if share < 1.0 {
                    list.push((share, m.origin(h), m.target(h)));
                }
            }
            list.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
            let before = count;
            changed.fill(false);
            for (k, (_, a, b)) in list.into_iter().enumerate() {
                if k % 256 == 0 {
                    self.run.check()?;
                }
                if !(self.work.mesh.is_node(a) && self.work.mesh.is_node(b)) {
                    continue;
                }
                let Some(h) = self.work.mesh.edge_between(a, b) else { continue };
                if self.work.mesh.edge_length(h) < short * self.wanted(h) && self.collapse(h, LONG, FAIR) {
                    count += 1;
                    let m = &self.work.mesh;
                    let left = if m.is_node(a) { a } else { b };
                    changed[left as usize] = true;
                    m.neighbors(left).for_each(|x| changed[x as usize] = true);
                }
            }
            if count == before {
                return Ok(count);
            }
        }
    }

    /// Collapses an edge in the direction the nodes' ranks allow, unless shapes that are worse than `fair` suffer or an edge becomes
    /// longer than `longest` wanted lengths.
    pub(super) fn collapse(&mut self, h: u32, longest: f64, fair: f64) -> bool {
        let m = &self.work.mesh;
        let (a, b) = (m.origin(h), m.target(h));
        let (ra, rb) = (self.rank[a as usize], self.rank[b as usize]);
        let o = m.opposite(h);
        if o == NONE && self.edge_set(h).len() < 2 {
            return false;
        }
        let middle = |set: &PieceSet| {
            let (p, q) = (self.point(a), self.point(b));
            self.work.settle(self.surface, set, 0.5 * (p + q), p.distance(q))
        };
        let sharp = m.is_sharp(h);
        let mut tries: Vec<(u32, DVec3)> = Vec::with_capacity(3);
        if ra == rb && ra != Rank::Corner && (ra == Rank::Face || sharp) {
            let set = self.work.sets[a as usize];
            if set == self.work.sets[b as usize] {
                tries.extend(middle(&set).map(|p| (h, p)));
            }
        }
        let may = |from: Rank| match from {
            Rank::Face => true,
            Rank::Curve => sharp,
            Rank::Corner => false,
        };
        if ra <= rb && may(ra) {
            tries.push((h, self.point(b)));
        }
        if rb <= ra && may(rb) && o != NONE {
            tries.push((o, self.point(a)));
        }
        for (side, p) in tries {
            if self.work.mesh.can_collapse(side) && self.collapse_is_fair(side, p, longest, fair) {
                let to = self.work.mesh.target(side);
                if self.work.mesh.collapse(side, p) {
                    self.rank[to as usize] = self.rank[to as usize].max(self.rank_of(to));
                    return true;
                }
            }
        }
        false
    }

    /// Merges nodes that lie at one place: corners and crossings that were found more than once.
    pub(super) fn merge_doubles(&mut self) -> usize {
        let mut count = 0;
        loop {
            let before = count;
            for h in 0..3 * self.work.mesh.triangle_capacity() as u32 {
                let m = &self.work.mesh;
                if m.is_triangle(h / 3) && m.is_edge(h) {
                    count += usize::from(self.merge_double(h));
                }
            }
            if count == before {
                return count;
            }
        }
    }

    /// Merges the ends of an edge if they lie at one place.
    pub(super) fn merge_double(&mut self, h: u32) -> bool {
        let m = &self.work.mesh;
        let (a, b) = (m.origin(h), m.target(h));
        if m.opposite(h) == NONE || !self.same_place(a, b) {
            return false;
        }
        let side = if self.rank[a as usize] <= self.rank[b as usize] { h } else { m.opposite(h) };
        let (from, to) = (m.origin(side), m.target(side));
        if self.stays(from) {
            return false;
        }
        let p = self.point(to);
        let merged = self.work.mesh.merge(side, p);
        if merged {
            self.work.sets[to as usize] = self.work.sets[to as usize].union(&self.work.sets[from as usize]);
            self.mark_around(to);
        }
        merged
    }

    /// Marks borders and ranks anew around a node.
    pub(super) fn mark_around(&mut self, v: u32) {
        let ring: Vec<u32> = self.work.mesh.outgoing(v).collect();
        for &h in &ring {
            let m = &self.work.mesh;
            let o = m.opposite(h);
            let line = m.is_sharp(h) && self.work.lines_from != u32::MAX && self.edge_set(h).len() == 2;
            let sharp = if o == NONE { !self.work.policy.goes_on } else { m.label(h / 3) != m.label(o / 3) || line };
            self.work.mesh.set_sharp(h, sharp);
        }
        self.rank[v as usize] = self.rank_of(v);
        for h in ring {
            let x = self.work.mesh.target(h);
            self.rank[x as usize] = self.rank_of(x);
        }
    }

    /// Whether two nodes are one that was found twice.
    pub(super) fn same_place(&self, a: u32, b: u32) -> bool {
        // Where faces touch, corners are known to the root of the rounding only; no two of the same faces are that near.
        let sets = [a, b].map(|v| &self.work.sets[v as usize]);
        let corner = sets[0].len() > 2 && sets[0] == sets[1];
        let near = if corner { 1e-3 } else { 1e-6 };
        self.point(a).distance(self.point(b)) < near * self.want[a as usize]
    }

    fn collapse_is_fair(&self, h: u32, p: DVec3, longest: f64, fair: f64) -> bool {
        let m = &self.work.mesh;
        let (a, b) = (m.origin(h), m.target(h));
        let dying = [h / 3, m.opposite(h) / 3];
        let mut after = f64::INFINITY;
        let long = |v: u32, x: u32| {
            let want = self.want[v as usize].min(self.want[x as usize]);
            p.distance(self.point(x)) > longest * want
        };
        let corners = |v: u32, e: u32| [self.point(v), self.point(m.target(e)), self.point(m.apex(e))];
        let shape = |e: u32, corners: [DVec3; 3]| self.work.shape_at(self.surface, m.label(e / 3), corners);
        for v in [a, b] {
            for e in m.outgoing(v).filter(|e| !dying.contains(&(e / 3))) {
                let [q, x, y] = corners(v, e);
                after = after.min(shape(e, [p, x, y]));
                if p != q && p.distance(x) > q.distance(x) && long(b, m.target(e)) {
                    return false;
                }
            }
        }
        let now = || {
            [a, b].into_iter().flat_map(|v| m.outgoing(v).map(move |e| (v, e))).map(|(v, e)| shape(e, corners(v, e)))
        };
        (after >= fair || after > now().fold(f64::INFINITY, f64::min)) && !self.makes_sliver(h, p)
    }

    /// The triangles to be looked at, but for those around which nothing changed since a reader saw all.
    pub(super) fn unseen(&self, reader: ChangeReader) -> Vec<u32> {
        let m = &self.work.mesh;
        let in_focus = reader == ChangeReader::Shapes && self.focus.is_some();
        let changed = |v: u32| m.is_changed(v, reader) && (!in_focus || m.is_changed(v, ChangeReader::Focus));
        let unseen = |t: &u32| {
            let corners = m.corners(*t);
            corners.iter().any(|&v| changed(v)) && corners.iter().any(|&v| self.sees(v))
        };
        m.triangles().filter(unseen).collect()
    }

    /// Notes that a reader has seen all triangles that are to be looked at.
    pub(super) fn set_seen(&mut self, reader: ChangeReader) {
        if reader == ChangeReader::Shapes {
            self.work.mesh.set_all_seen(ChangeReader::Focus);
        }
        for v in 0..self.work.mesh.node_capacity() as u32 {
            // Of a node that is not looked at, some triangles may not have been.
            if self.sees(v) {
                self.work.mesh.set_seen(v, reader);
            }
        }
    }
}
