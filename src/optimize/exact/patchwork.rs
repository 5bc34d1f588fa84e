//! A mesh that knows for every node which pieces of the surface it lies on, and for every triangle which one.

use std::sync::Arc;

use glam::DVec3;

use crate::geometry::Pieces;
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, TriMesh};
use crate::numeric::COS_26;

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

/// How patches are filled with nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filling {
    /// A packing, evened out and mended.
    #[default]
    Mended,
    /// The front of nodes alone, as frontal methods leave it: flips, nothing is moved.
    Front,
    /// Nodes at random that keep apart, and flips.
    Random,
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
    /// Whether what is frozen is put right at last, as far as that makes no triangles cross.
    pub thaws: bool,
    /// Whether borders are divided by `sizes` already, which then are what nodes want.
    pub spaced: bool,
    /// Whether triangles that face about the way of the surface are judged by their own angles alone.
    pub by_angles: bool,
    /// How patches are filled with nodes.
    pub filling: Filling,
    /// Whether triangles may have any size and shape. Long edges are then halved before anything else.
    pub raw: bool,
    /// Whether raw triangles tell how the surface bends within the lengths wanted: they may be collapsed to about these at first.
    pub fine: bool,
    /// Whether the surface goes on beyond open edges, in other meshes that know the nodes there: these stay, and are no border.
    pub goes_on: bool,
    /// Up to so many edges from open edges triangles are made anew by whoever takes the mesh, from these but whatever their angles.
    pub made_anew: usize,
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
            thaws: false,
            spaced: false,
            by_angles: false,
            filling: Filling::default(),
            raw: false,
            fine: false,
            goes_on: false,
            made_anew: 0,
        }
    }
}

/// A triangle that seems to be turned over may lie on another sheet of its piece that is this share of its longest edge away:
/// the other side of a thin wall or of a crease.
const SHEET: f64 = 0.15;
/// A triangle of a smaller shape seems to be.
const TURNED: f64 = 0.05;

/// Up to this angle (cosine) with the surface, 45 degrees, a triangle is judged by its own angles alone: where the surface bends
/// within the length of an edge no place of a node would turn it nearer.
const FACING: f64 = 0.7;

/// What a mesh is to be exact to.
#[derive(Clone, Copy)]
pub struct ExactTarget<'a> {
    /// The pieces its nodes lie on.
    pub surface: &'a dyn Pieces,
    /// Lends the names of faces, and the groups.
    pub names: &'a TriMesh,
}

/// A node, were it at a point.
#[derive(Clone, Copy)]
pub(super) struct NodeAt {
    pub(super) node: u32,
    pub(super) point: DVec3,
    /// The outward normal there, where it is known and the node is of one patch.
    pub(super) normal: Option<DVec3>,
}

/// A triangle by what its shape is made of.
#[derive(Clone, Copy)]
pub(super) struct TriangleShape {
    /// Twice the area vector.
    pub(super) area: DVec3,
    /// The sum of the squared sides.
    squares: f64,
}

impl TriangleShape {
    pub(super) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (u, v, w) = (b - a, c - a, c - b);
        Self { area: u.cross(v), squares: u.length_squared() + v.length_squared() + w.length_squared() }
    }

    fn relative(&self, area: f64) -> f64 {
        if self.squares > 0.0 { 2.0 * 3f64.sqrt() * area / self.squares } else { 0.0 }
    }

    /// The shape seen along `normal`: 1 for an equilateral triangle facing that way, 0 for a degenerate or upright one,
    /// negative for one turned over.
    pub(super) fn seen(&self, normal: DVec3) -> f64 {
        self.relative(self.area.dot(normal))
    }

    /// The shape as its angles make it, as long as it faces about the way of `normal`; from there on smaller and smaller, with
    /// the sign of [`seen`](Self::seen).
    fn facing(&self, normal: DVec3) -> f64 {
        let seen = self.area.dot(normal) / FACING;
        self.relative(if seen > 0.0 { seen.min(self.area.length()) } else { seen })
    }

    /// The shape whichever way the triangle faces.
    pub(super) fn plain(&self) -> f64 {
        self.relative(self.area.length())
    }

    /// Whether [`plain`](Self::plain) is above `limit`.
    pub(super) fn is_above(&self, limit: f64) -> bool {
        12.0 * self.area.length_squared() > (limit * self.squares).powi(2)
    }
}

/// [`TriangleShape::plain`] of a triangle.
pub(super) fn plain_shape(corners: [DVec3; 3]) -> f64 {
    TriangleShape::new(corners).plain()
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

    /// The shape of a triangle seen along `normal`; [by angles](Self::by_angles), where borders were spaced for bends
    /// beforehand and triangles are about as near to the surface as they shall be, as its own angles make it.
    pub(super) fn judged(&self, t: [DVec3; 3], normal: DVec3) -> f64 {
        let facet = TriangleShape::new(t);
        if self.by_angles { facet.facing(normal) } else { facet.seen(normal) }
    }

    /// [`judged`](Self::judged) of a triangle at the given corners, on the given patch; on none all shapes are as good.
    pub(super) fn shape_at(&self, surface: &dyn Pieces, patch: u32, t: [DVec3; 3]) -> f64 {
        if self.patches[patch as usize].piece == NONE {
            return 1.0;
        }
        let middle = (t[0] + t[1] + t[2]) / 3.0;
        let seen = self.judged(t, self.normal(surface, patch, middle));
        if seen > TURNED {
            return seen;
        }
        let (u, v) = (t[1] - t[0], t[2] - t[0]);
        let longest = u.length_squared().max(v.length_squared()).max(u.distance_squared(v)).sqrt();
        self.normal_facing(surface, patch, middle, u.cross(v), longest).map_or(seen, |n| seen.max(self.judged(t, n)))
    }

    /// Outward unit normal of a sheet of a patch's piece that faces the way of `up` and is near `p`, beside edges of `length`.
    pub(super) fn normal_facing(
        &self,
        surface: &dyn Pieces,
        patch: u32,
        p: DVec3,
        up: DVec3,
        length: f64,
    ) -> Option<DVec3> {
        let PiecePatch { piece, outward, plane, .. } = self.patches[patch as usize];
        if plane.is_some() {
            return None;
        }
        surface.foot_facing(piece, p, up * outward, SHEET * length)?.1.map(|n| n * outward)
    }

    /// [`judged`](Self::judged) of a triangle as it is.
    pub(super) fn shape(&self, surface: &dyn Pieces, t: u32) -> f64 {
        let plain = self.plain_among_alike(t);
        plain.unwrap_or_else(|| self.shape_at(surface, self.mesh.label(t), self.mesh.corner_points(t)))
    }

    /// Whether the [shape](Self::shape) of a triangle is below a limit.
    pub(super) fn is_below(&self, surface: &dyn Pieces, t: u32, limit: f64) -> bool {
        let known = self.by_angles && self.patches[self.mesh.label(t) as usize].piece != NONE;
        (known && plain_shape(self.mesh.corner_points(t)) < limit) || self.shape(surface, t) < limit
    }

    /// Whether triangles are judged [by angles](Self::by_angles) on a smooth surface: between the nodes of raw triangles its normals
    /// are as rough as these.
    pub(super) fn is_smooth_by_angles(&self) -> bool {
        self.by_angles && !self.raw
    }

    /// The shape of a triangle judged [by angles](Self::by_angles) whose neighbors face its way: what is turned over ends at a
    /// fold, and there the surface is asked. On rough surfaces, as soups are, whole neighborhoods face a wrong way.
    fn plain_among_alike(&self, t: u32) -> Option<f64> {
        let patch = &self.patches[self.mesh.label(t) as usize];
        let asked = self.is_smooth_by_angles() && patch.piece != NONE && patch.plane.is_none();
        // Triangles that face much the same way are far from turned over against each other.
        (asked && self.neighbors_alike(t, COS_26)? > 0).then(|| plain_shape(self.mesh.corner_points(t)))
    }

    /// How many neighbors of its patch a triangle has, if each of them and it face ways whose angle has a cosine of at least
    /// `cosine`.
    pub(super) fn neighbors_alike(&self, t: u32, cosine: f64) -> Option<usize> {
        let m = &self.mesh;
        let up = m.area_vector(t);
        let mut count = 0;
        for o in (3 * t..3 * t + 3).map(|h| m.opposite(h)).filter(|o| *o != NONE && m.label(o / 3) == m.label(t)) {
            let other = m.area_vector(o / 3);
            let along = up.dot(other);
            if !(along > 0.0 && along * along >= cosine * cosine * up.length_squared() * other.length_squared()) {
                return None;
            }
            count += 1;
        }
        Some(count)
    }

    /// The worst [shape](Self::judged) around a node, were it at `p`; the normals are those at the node.
    pub(super) fn worst_around(&self, surface: &dyn Pieces, v: u32, p: DVec3) -> f64 {
        self.worst_triangle(surface, NodeAt { node: v, point: p, normal: None }, f64::NEG_INFINITY).0
    }

    /// The worst shape around a node where it is, and the mean direction of its triangles where these know their shapes without
    /// asking the surface.
    pub(super) fn worst_now(&self, surface: &dyn Pieces, v: u32) -> (f64, Option<DVec3>) {
        let (mut worst, mut up) = (f64::INFINITY, DVec3::ZERO);
        for h in self.mesh.outgoing(v) {
            let Some(shape) = self.plain_among_alike(h / 3) else {
                return (self.worst_around(surface, v, self.mesh.point(v)), None);
            };
            (worst, up) = (worst.min(shape), up + self.mesh.area_vector(h / 3));
        }
        (worst, up.try_normalize())
    }

    /// The worst shape around a node, were it at some place, and the
    /// half-edge that leaves the node in the triangle with that shape. Once a shape is below `floor` the others are not looked
    /// at.
    pub(super) fn worst_triangle(&self, surface: &dyn Pieces, at: NodeAt, floor: f64) -> (f64, u32) {
        let NodeAt { node: v, point: p, normal: known } = at;
        let m = &self.mesh;
        let (mut last, mut normal, mut worst) = (NONE, DVec3::ZERO, (f64::INFINITY, NONE));
        // Both sides of a line within a piece are the piece's, with normals of their own.
        let on_line = self.sets[v as usize].as_slice().last().is_some_and(|piece| *piece >= self.lines_from);
        // No shape is above what it is whichever way its triangle faces: what is known without normals comes first.
        if self.by_angles && known.is_none() && floor > 0.0 {
            let all = m.outgoing(v).filter(|h| self.patches[m.label(h / 3) as usize].piece != NONE);
            let mut plain = all.map(|h| (plain_shape([p, m.point(m.target(h)), m.point(m.apex(h))]), h));
            if let Some(low) = plain.find(|x| x.0 < floor) {
                return low;
            }
        }
        for h in m.outgoing(v) {
            let label = m.label(h / 3);
            if self.patches[label as usize].piece == NONE {
                continue;
            }
            let triangle = [p, m.point(m.target(h)), m.point(m.apex(h))];
            if label != last && !on_line {
                (last, normal) = (label, known.unwrap_or_else(|| self.normal(surface, label, p)));
            }
            let shape = if on_line { self.shape_at(surface, label, triangle) } else { self.judged(triangle, normal) };
            if worst.1 == NONE || shape < worst.0 {
                worst = (shape, h);
                if shape < floor {
                    break;
                }
            }
        }
        worst
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
