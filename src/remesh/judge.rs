//! How triangles are judged while they are remeshed: what their shape is, alone and around a node.

use glam::DVec3;

use super::patchwork::{Patchwork, PiecePatch};
use crate::geometry::Pieces;
use crate::mesh::edit::NONE;
use crate::numeric::COS_26;

/// A triangle that seems to be turned over may lie on another sheet of its piece that is this share of its longest edge away:
/// the other side of a thin wall or of a crease.
const SHEET: f64 = 0.15;
/// A triangle of a smaller shape seems to be.
const TURNED: f64 = 0.05;

/// Up to this angle (cosine) with the surface, 45 degrees, a triangle is judged by its own angles alone: where the surface bends
/// within the length of an edge no place of a node would turn it nearer.
const FACING: f64 = 0.7;

/// What the shape of a triangle is: 1 for an equilateral one that faces the way of the surface, negative for one that is turned over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Judge {
    /// What is seen of it along the normal of the surface.
    #[default]
    Normals,
    /// What its own angles make it, as long as it faces about the way of the surface: for triangles about as near to the surface as
    /// they shall be.
    Angles,
}

impl Judge {
    /// The shape of a triangle where the surface has a normal.
    pub(super) fn shape(self, triangle: [DVec3; 3], normal: DVec3) -> f64 {
        let shape = TriangleShape::new(triangle);
        match self {
            Judge::Normals => shape.seen(normal),
            Judge::Angles => shape.facing(normal),
        }
    }

    /// Whether no shape is above what it is whichever way its triangle faces.
    pub(super) fn is_by_angles(self) -> bool {
        self == Judge::Angles
    }
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
    pub(super) fn facing(&self, normal: DVec3) -> f64 {
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
    /// The [shape](Judge::shape) of a triangle at the given corners, on the given patch; on none all shapes are as good.
    pub(super) fn shape_at(&self, surface: &dyn Pieces, patch: u32, t: [DVec3; 3]) -> f64 {
        if self.patches[patch as usize].piece == NONE {
            return 1.0;
        }
        let middle = (t[0] + t[1] + t[2]) / 3.0;
        let seen = self.policy.judge.shape(t, self.normal(surface, patch, middle));
        if seen > TURNED {
            return seen;
        }
        let (u, v) = (t[1] - t[0], t[2] - t[0]);
        let longest = u.length_squared().max(v.length_squared()).max(u.distance_squared(v)).sqrt();
        self.normal_facing(surface, patch, middle, u.cross(v), longest)
            .map_or(seen, |n| seen.max(self.policy.judge.shape(t, n)))
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

    /// The [shape](Judge::shape) of a triangle as it is.
    pub(super) fn shape(&self, surface: &dyn Pieces, t: u32) -> f64 {
        let plain = self.plain_among_alike(t);
        plain.unwrap_or_else(|| self.shape_at(surface, self.mesh.label(t), self.mesh.corner_points(t)))
    }

    /// Whether the [shape](Self::shape) of a triangle is below a limit.
    pub(super) fn is_below(&self, surface: &dyn Pieces, t: u32, limit: f64) -> bool {
        let known = self.policy.judge.is_by_angles() && self.patches[self.mesh.label(t) as usize].piece != NONE;
        (known && plain_shape(self.mesh.corner_points(t)) < limit) || self.shape(surface, t) < limit
    }

    /// The shape of a triangle judged [by angles](Judge::Angles) whose neighbors face its way: what is turned over ends at a
    /// fold, and there the surface is asked. On rough surfaces, as soups are, whole neighborhoods face a wrong way.
    fn plain_among_alike(&self, t: u32) -> Option<f64> {
        let patch = &self.patches[self.mesh.label(t) as usize];
        let asked = self.policy.is_smooth_by_angles() && patch.piece != NONE && patch.plane.is_none();
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

    /// The worst [shape](Judge::shape) around a node, were it at `p`; the normals are those at the node.
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
        if self.policy.judge.is_by_angles() && known.is_none() && floor > 0.0 {
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
            let shape = if on_line {
                self.shape_at(surface, label, triangle)
            } else {
                self.policy.judge.shape(triangle, normal)
            };
            if worst.1 == NONE || shape < worst.0 {
                worst = (shape, h);
                if shape < floor {
                    break;
                }
            }
        }
        worst
    }
}
