//! A mesh that knows for every node which pieces of the surface it lies on, and for every triangle which one.

use std::sync::Arc;

use glam::DVec3;

use super::policy::Policy;
use crate::geometry::Pieces;
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, TriMesh};

/// The pieces a node lies on, ascending. More than three at a corner are cut to the first four.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PieceSet {
    items: [u32; 4],
    count: u8,
}

impl PieceSet {
    /// A node inside a face.
    pub fn one(piece: u32) -> Self {
        Self { items: [piece, 0, 0, 0], count: 1 }
    }

    /// The different ones of some pieces.
    pub fn of(pieces: &[u32]) -> Self {
        let mut set = Self::default();
        pieces.iter().for_each(|p| set.add(*p));
        set
    }

    fn add(&mut self, piece: u32) {
        let n = self.count as usize;
        if n < self.items.len() && !self.items[..n].contains(&piece) {
            self.items[n] = piece;
            self.count += 1;
            self.items[..=n].sort_unstable();
        }
    }

    /// All pieces of both.
    pub fn union(&self, other: &Self) -> Self {
        let mut set = *self;
        other.as_slice().iter().for_each(|p| set.add(*p));
        set
    }

    /// Whether a piece is one of them.
    pub fn has(&self, piece: u32) -> bool {
        self.as_slice().contains(&piece)
    }

    /// Whether `other` has all pieces of this one.
    pub fn within(&self, other: &Self) -> bool {
        self.as_slice().iter().all(|p| other.has(*p))
    }

    /// The pieces.
    pub fn as_slice(&self) -> &[u32] {
        &self.items[..self.count as usize]
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether the node lies on no piece that is known.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

/// A connected part of the surface on one piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PiecePatch {
    /// The piece.
    pub piece: u32,
    /// 1 where the piece's own direction points out of the solid, -1 where it points in.
    pub outward: f64,
    /// The piece's plane, where it is one: unit normal (of the piece) and offset.
    pub plane: Option<(DVec3, f64)>,
    /// The face it is of, where that is known; `u32::MAX` where the piece tells it. Faces on one piece have a border that runs
    /// along another, which bounds nothing there.
    pub face: u32,
}

/// A mesh cut along the borders of pieces. Triangle labels are indices into `patches`; edges between patches are sharp.
#[derive(Debug, Clone)]
pub struct Patchwork {
    /// The mesh.
    pub mesh: EditMesh,
    /// The pieces each node lies on.
    pub sets: Vec<PieceSet>,
    /// For each node the largest edge length it may want; empty where there is no such bound.
    pub sizes: Vec<f64>,
    /// What triangle labels stand for.
    pub patches: Arc<[PiecePatch]>,
    /// Pieces from this number on are lines within one piece: creases and open borders. Their nodes lie on that piece and
    /// on the line. `u32::MAX` where there are none.
    pub lines_from: u32,
    /// Patches that stay as they are: ascending labels.
    pub frozen: Vec<u32>,
    /// The patches these are given back to; empty where they never are.
    pub thawed: Vec<u32>,
    /// How it is remeshed.
    pub policy: Policy,
}

impl Patchwork {
    /// A mesh without lines within pieces and without bounds on sizes, whose triangles are about as large as they shall be.
    pub fn new(mesh: EditMesh, sets: Vec<PieceSet>, patches: Arc<[PiecePatch]>) -> Self {
        Self {
            mesh,
            sets,
            sizes: Vec::new(),
            patches,
            lines_from: u32::MAX,
            frozen: Vec::new(),
            thawed: Vec::new(),
            policy: Policy::default(),
        }
    }
}

/// What a mesh is to be exact to.
#[derive(Clone, Copy)]
pub struct RemeshTarget<'a> {
    /// The pieces its nodes lie on.
    pub surface: &'a dyn Pieces,
    /// Lends the names of faces, and the groups.
    pub names: &'a TriMesh,
}

impl Patchwork {
    /// Outward unit normal of a patch's piece at a point on it.
    pub(super) fn normal(&self, surface: &dyn Pieces, patch: u32, p: DVec3) -> DVec3 {
        let patch = &self.patches[patch as usize];
        if let Some((n, _)) = patch.plane {
            return n * patch.outward;
        }
        surface.direction(patch.piece, p).map_or(DVec3::ZERO, |n| n * patch.outward)
    }

    /// Whether a patch stays as it is: it lies on no piece, or is frozen.
    pub(super) fn stays(&self, patch: u32) -> bool {
        self.patches[patch as usize].piece == NONE || self.frozen.binary_search(&patch).is_ok()
    }

    /// The same of a triangle's patch.
    pub(super) fn is_kept(&self, t: u32) -> bool {
        self.stays(self.mesh.label(t))
    }

    /// The same of either triangle of an edge.
    pub(super) fn beside_kept(&self, h: u32) -> bool {
        let o = self.mesh.opposite(h);
        self.is_kept(h / 3) || (o != NONE && self.is_kept(o / 3))
    }

    /// Puts a point where a node with the given pieces may be; corners have one place only.
    pub(super) fn settle(&self, surface: &dyn Pieces, set: &PieceSet, p: DVec3, reach: f64) -> Option<DVec3> {
        if let [piece] = set.as_slice()
            && let Some((n, d)) = surface.plane(*piece)
        {
            return Some(p - n * (n.dot(p) - d));
        }
        if set.len() <= 2 { surface.meet(set.as_slice(), p, reach) } else { None }
    }

    /// [`settle`](Self::settle) for a place near node `v`, which does not leave its sheet of the surface; with the outward
    /// normal there, where that is known without asking for it.
    pub(super) fn settle_beside(
        &self,
        surface: &dyn Pieces,
        v: u32,
        set: &PieceSet,
        p: DVec3,
        reach: f64,
    ) -> Option<(DVec3, Option<DVec3>)> {
        let m = &self.mesh;
        if let [piece] = set.as_slice()
            && let Some(patch) = m.outgoing(v).next().map(|h| &self.patches[m.label(h / 3) as usize])
            && patch.plane.is_none()
        {
            let up: DVec3 = m.outgoing(v).map(|h| m.area_vector(h / 3)).sum();
            let (q, n) = surface.foot_facing(*piece, p, up * patch.outward, reach)?;
            return Some((q, n.map(|n| n * patch.outward)));
        }
        Some((self.settle(surface, set, p, reach)?, None))
    }

    /// The neighbors of a node along borders.
    pub(super) fn along(&self, v: u32) -> Vec<u32> {
        self.mesh.sharp_neighbors(v).collect()
    }

    /// The pieces a new node on an edge lies on.
    pub(super) fn edge_set(&self, surface: &dyn Pieces, h: u32) -> PieceSet {
        let m = &self.mesh;
        let own = PieceSet::one(self.patches[m.label(h / 3) as usize].piece);
        let o = m.opposite(h);
        if !m.is_sharp(h) {
            return own;
        }
        let between = o != NONE && m.label(h / 3) != m.label(o / 3);
        let other = if between { self.patches[m.label(o / 3) as usize].piece } else { NONE };
        if between && !own.has(other) {
            return own.union(&PieceSet::one(other));
        }
        // A line within the piece, or between two faces on it: the one both ends lie on; of several the one that runs here.
        let (a, b) = (m.origin(h), m.target(h));
        let middle = 0.5 * (m.point(a) + m.point(b));
        let there = self.sets[b as usize].as_slice();
        let lines = self.sets[a as usize]
            .as_slice()
            .iter()
            .filter(|p| (between || **p >= self.lines_from) && !own.has(**p) && there.contains(p));
        let sets = lines.map(|l| own.union(&PieceSet::one(*l)));
        let distance = |s: &PieceSet| {
            surface.meet(s.as_slice(), middle, f64::INFINITY).map_or(f64::INFINITY, |p| p.distance_squared(middle))
        };
        sets.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(own)
    }
}
