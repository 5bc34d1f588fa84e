//! Primitives of the plane turned about the z axis: x is the radius, y becomes z.

use glam::DVec3;

use super::{Context, Lowerer, Op, Part, along, direction, disk_bounds, original_edge, positive};
use crate::error::{Error, Place, Result};
use crate::implicit::leaf::{Frame, Leaf};
use crate::implicit::polygon::polygon_tree;
use crate::implicit::shapes::{canonical, clean};
use crate::implicit::solid::{Placement, Primitive, Solid, SolidNode};
use crate::implicit::turned::{Ring, Turned, formula, snapped};
use crate::spatial::Aabb;

/// The axis a figure turns about, with the scale of its lengths.
struct Axis {
    at: DVec3,
    along: DVec3,
    scale: f64,
}

impl Axis {
    fn of(place: &Placement) -> Self {
        Axis { at: place.shift, along: place.turn(DVec3::Z), scale: place.scale }
    }

    /// The box around what a point (radius, z) sweeps.
    fn swept(&self, p: [f64; 2]) -> Aabb {
        disk_bounds(self.at + self.along * (p[1] * self.scale), self.along, p[0].max(0.0) * self.scale)
    }
}

/// The point of the plane that a primitive's point lies on.
fn flat(p: DVec3) -> [f64; 2] {
    [p.x, p.y]
}

/// Points (radius, z); the radius is zero where rounding leaves less of the placement.
fn placed(plane: &Placement, points: &[DVec3]) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 2]> = points.iter().map(|p| flat(plane.apply(*p))).collect();
    let reach = points.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    points.into_iter().map(|[x, y]| [snapped(x, reach), y]).collect()
}

impl Lowerer {
    /// What is inside a ring, turned. Where the radius is negative there is nothing.
    pub(super) fn revolve(&mut self, solid: &Solid, kind: &'static str, ring: Ring, c: &Context) -> Result<Part> {
        if ring.is_cut() {
            polygon_tree(&ring.points)?;
        }
        let axis = Axis::of(&c.place);
        let mut parts = Vec::new();
        for piece in ring.beside_axis() {
            let (corners, tree) = polygon_tree(&piece.points)?;
            let n = corners.len();
            let mut edges = Vec::with_capacity(n);
            for i in 0..n {
                let (p, q) = (corners[i], corners[(i + 1) % n]);
                let sub = &piece.names[original_edge(&piece.points, p, q)];
                let line = [p, [q[0] - p[0], q[1] - p[1]]];
                edges.push(self.turned_line(&axis, line, c, |l| l.face(solid, kind, sub, c)));
            }
            let op = self.edge_tree(&tree, &edges, c.negate);
            let bounds = corners.iter().map(|p| axis.swept(*p)).fold(Aabb::EMPTY, |b, d| b.union(&d));
            parts.push(Part { op, bounds });
        }
        let bounds = parts.iter().fold(Aabb::EMPTY, |b, p| b.union(&p.bounds));
        Ok(Part { op: self.join(c.negate, parts).op, bounds })
    }

    /// A primitive of the plane, turned.
    pub(super) fn turn(&mut self, turned: &Turned, c: &Context) -> Result<Part> {
        let (solid, plane) = (&turned.solid, &turned.placement);
        let axis = Axis::of(&c.place);
        let nothing = |l: &mut Self| Part { op: l.op(Op::All(c.negate)), bounds: Aabb::EMPTY };
        let SolidNode::Primitive(primitive) = solid.node() else {
            return Err(Error::Failed("what is turned is no primitive".into()));
        };
        match primitive {
            Primitive::Formula(e) => {
                let e = formula(e, plane);
                match e.as_constant() {
                    Some(_) => self.primitive(solid, &Primitive::Formula(e), c),
                    None => self.formula(solid, &e, c.clone()),
                }
            }
            Primitive::Cylinder { r, at, .. } => {
                positive("the radius of a circle", *r)?;
                let (center, r) = (plane.apply(*at), r * plane.scale);
                let x = snapped(center.x, r);
                if x + r <= 0.0 {
                    return Ok(nothing(self));
                }
                let f = self.face(solid, "cylinder", "", c);
                let (middle, minor) = (c.place.apply(DVec3::Z * center.y), r * axis.scale);
                if x == 0.0 {
                    let op = self.leaf(Leaf::Sphere { c: middle, r: minor }, f, c.negate);
                    return Ok(Part { op, bounds: Aabb::new(middle - minor, middle + minor) });
                }
                let a = direction(axis.along, "the axis of a torus")?;
                let frame = Frame::about(canonical(a).0);
                let major = x * axis.scale;
                let op = self.leaf(Leaf::Torus { c: middle, frame, major, minor }, f, c.negate);
                Ok(Part { op, bounds: disk_bounds(middle, a, major.max(0.0)).grown(minor) })
            }
            Primitive::Box { lo, hi } => {
                let ends = [*lo, *hi].map(|p| p.with_z(0.0));
                if !(ends.iter().all(|p| p.is_finite()) && lo.x < hi.x && lo.y < hi.y) {
                    return Err(Error::input(Place::Unknown, format!("a rectangle needs lo < hi, not {lo} and {hi}")));
                }
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, k)| DVec3::new(ends[i].x, ends[k].y, 0.0));
                let names = ["ymin", "xmax", "ymax", "xmin"].map(String::from).to_vec();
                self.revolve(solid, "box", Ring { points: placed(plane, &corners), names }, c)
            }
            Primitive::Extrude { polygon, at, .. } => {
                let corners: Vec<DVec3> = polygon.iter().map(|p| *at + DVec3::new(p[0], p[1], 0.0)).collect();
                self.revolve(solid, "extrude", Ring::numbered(placed(plane, &corners)), c)
            }
            Primitive::HalfSpace { normal, at } => {
                let n = direction(plane.turn(*normal), "the normal of a half-space")?;
                let on = flat(plane.apply(*at));
                let op = self.turned_line(&axis, line(n, on), c, |l| l.face(solid, "half_space", "", c));
                let bounds = if clean(n) == DVec3::X { along(axis.swept(on), axis.along) } else { Aabb::ALL };
                Ok(Part { op, bounds })
            }
            _ => Err(Error::input(Place::Unknown, "what is turned about an axis is a plane figure, which this is not")),
        }
    }

    /// What is on the left of a line of the half-plane (radius, z), turned; everything or nothing where it does not pass there.
    /// The line has a point and a direction. `face` is asked for where there is a surface.
    fn turned_line(
        &mut self,
        axis: &Axis,
        [p, d]: [[f64; 2]; 2],
        c: &Context,
        face: impl FnOnce(&mut Self) -> u32,
    ) -> u32 {
        // Upright and not beyond the axis: all radii are on one side.
        if d[0] == 0.0 && p[0] <= 0.0 {
            return self.op(Op::All((d[1] < 0.0) != c.negate));
        }
        let face = face(self);
        self.turned(axis.at, axis.along, [p.map(|v| v * axis.scale), d], face, c.negate)
    }

    /// The side swept by turning a line of the half-plane (radius, height), a point and a direction, about the axis; inside is on
    /// its left.
    pub(super) fn turned(&mut self, c: DVec3, a: DVec3, [p, [dr, dz]]: [[f64; 2]; 2], face: u32, negate: bool) -> u32 {
        let length = dr.hypot(dz);
        let (k, m) = (dz / length, -dr / length);
        if k == 0.0 {
            return self.plane(a * m, c + a * p[1], face, negate);
        }
        if m == 0.0 {
            return self.cylinder(c, a, p[0], face, negate != (k < 0.0));
        }
        let d = k * p[0] + m * p[1];
        let (k, m, d, flip) = if k < 0.0 { (-k, -m, -d, true) } else { (k, m, d, false) };
        let frame = Frame::about(clean(a));
        self.leaf(Leaf::Cone { c, frame, k, m, d }, face, negate != flip)
    }
}

/// A point and the direction of a line with its outward normal on the right.
fn line(normal: DVec3, on: [f64; 2]) -> [[f64; 2]; 2] {
    let n = clean(normal.with_z(0.0).normalize());
    [on, [-n.y, n.x]]
}
