//! Edges revolved around an axis (\[KUZ19\] 32, sections 3.1 and 3.3): full or by an angle, with poles where they touch it.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};

use super::assembly::{Along, Assembly, BodyChain, Side, side_by_foot};
use super::wire::{Piece, Wire, refuse};
use crate::error::Result;
use crate::numeric::FEW_ROUNDINGS;
use crate::parametric::brep::Brep;
use crate::parametric::curve::Curve;
use crate::parametric::frame::{Frame, Similarity};
use crate::parametric::surface::Surface;

/// A line in space with a direction, about which turns are counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// A point on it.
    pub origin: DVec3,
    /// Its direction, of any length.
    pub direction: DVec3,
}

impl Axis {
    fn foot(&self, p: DVec3) -> DVec3 {
        self.origin + self.direction * (p - self.origin).dot(self.direction)
    }

    fn radius(&self, p: DVec3) -> f64 {
        p.distance(self.foot(p))
    }

    /// The turn by an angle.
    pub(super) fn turn(&self, angle: f64) -> Similarity {
        let rotation = DMat3::from_quat(DQuat::from_axis_angle(self.direction, angle));
        Similarity { scale: 1.0, rotation, translation: self.origin - rotation * self.origin }
    }
}

/// Revolves a chain of edges by `degrees`, above 0 and up to 360.
///
/// A chain that touches the axis ends there in a pole; edges on the axis make no face. With `solid`, the chain must be
/// closed, or both its ends must be on the axis; turns below 360 degrees get flat caps. Faces are called `side` (with a
/// number where there are several), `start` and `end`.
///
/// Errors: an axis without direction; an angle out of range; a chain that crosses the axis or touches it between its ends;
/// with `solid`, an open contour (the gap is named) or one that is not flat where it is capped.
pub fn revolve_edges(wire: &Wire, axis: &Axis, degrees: f64, solid: bool) -> Result<Brep> {
    let Some(direction) = axis.direction.try_normalize() else {
        return refuse("the direction of the axis of a revolution has no length");
    };
    let axis = Axis { origin: axis.origin, direction };
    if !(degrees > 0.0 && degrees <= 360.0) {
        return refuse(format!("the angle of a revolution must be above 0 and up to 360 degrees, not {degrees}"));
    }
    let turn = Turn { axis, angle: if degrees == 360.0 { TAU } else { degrees.to_radians() } };
    let mut wire = wire.clone();
    let reach = turn.reach(&wire);
    let touch = wire.tolerance().max(FEW_ROUNDINGS * reach);
    if !(reach > touch) {
        return refuse("all edges are on the axis");
    }
    if solid {
        let on_axis = |p: DVec3| axis.radius(p) <= touch;
        if let Some(gap) = wire.gap() {
            if !(on_axis(gap.from) && on_axis(gap.to)) {
                return refuse(format!(
                    "a solid of revolution needs a closed contour, or one with both ends on the axis; this one has {gap}"
                ));
            }
            let rest = Wire::polyline(&[gap.from, gap.to])?;
            wire = Wire::joined(&[wire, rest])?;
        }
        // Seen against the turn the contour runs counter-clockwise: then its faces look out.
        if turn.area(&wire) < 0.0 {
            wire = wire.reversed();
        }
    }
    turn.check(&wire, touch)?;
    let mut a = Assembly::default();
    let from = a.border(&wire);
    let (end, to) = turn.add(&mut a, &wire, &from, touch, "side")?;
    if solid && turn.angle < TAU {
        a.cap(&[wire], &[from], false, "start")?;
        a.cap(&[end], &[to], true, "end")?;
    }
    Ok(a.body("revolution", solid))
}

/// A turn around an axis with a direction of unit length.
pub(super) struct Turn {
    pub(super) axis: Axis,
    pub(super) angle: f64,
}

impl Turn {
    fn reach(&self, wire: &Wire) -> f64 {
        wire.samples().into_iter().map(|p| self.axis.radius(p)).fold(0.0, f64::max)
    }

    /// Area of a closed contour in radius and height, positive where its faces look out: minus the integral of r dz.
    fn area(&self, wire: &Wire) -> f64 {
        let k = self.axis.direction;
        wire.pieces().iter().map(|p| -p.integral(&|q, d| self.axis.radius(q) * d.dot(k))).sum()
    }

    /// Edges may touch the axis at their ends only.
    fn check(&self, wire: &Wire, touch: f64) -> Result<()> {
        let far = wire.samples().into_iter().max_by(|a, b| self.axis.radius(*a).total_cmp(&self.axis.radius(*b)));
        let Some(far) = far else { return Ok(()) };
        let out = (far - self.axis.foot(far)).normalize_or_zero();
        let side = self.axis.direction.cross(out);
        let flat = wire.samples().iter().all(|p| (*p - self.axis.origin).dot(side).abs() <= 1e3 * touch);
        if let Some(q) = wire.samples().into_iter().find(|q| flat && (*q - self.axis.origin).dot(out) < -1e3 * touch) {
            return refuse(format!("the contour crosses the axis of revolution before {q}"));
        }
        for p in wire.pieces() {
            if on_axis(p, &self.axis, touch) {
                continue;
            }
            let samples = p.samples();
            for q in &samples[1..samples.len() - 1] {
                if self.axis.radius(*q) <= touch {
                    return refuse(format!(
                        "the contour touches the axis of revolution at {q}, inside an edge: split it there"
                    ));
                }
            }
        }
        Ok(())
    }

    /// Adds the faces from a chain to its turned image, and gives that.
    pub(super) fn add(
        &self,
        a: &mut Assembly,
        wire: &Wire,
        from: &BodyChain,
        touch: f64,
        name: &str,
    ) -> Result<(Wire, BodyChain)> {
        let full = self.angle >= TAU;
        let end = if full { wire.clone() } else { wire.moved(&self.axis.turn(self.angle)) };
        let corners = wire.corners();
        let resting: Vec<bool> = corners.iter().map(|p| self.axis.radius(*p) <= touch).collect();
        let vertices: Vec<u32> = (0..corners.len())
            .map(|i| if full || resting[i] { from.vertices[i] } else { a.vertex(end.corners()[i]) })
            .collect();
        let still: Vec<bool> = wire.pieces().iter().map(|p| on_axis(p, &self.axis, touch)).collect();
        let mut to = BodyChain { edges: from.edges.clone(), vertices };
        if !full {
            for (i, p) in end.pieces().iter().enumerate().filter(|x| !still[x.0]) {
                let (x, y) = (to.vertex(i), to.vertex(i + 1));
                let made = a.edge(p.curve.clone(), p.range, if p.forward { [x, y] } else { [y, x] });
                to.edges[i] = made.map(|c| crate::parametric::brep::Coedge { forward: p.forward, ..c });
            }
        }
        let rails: Vec<Along> = (0..corners.len())
            .map(|i| {
                if resting[i] {
                    return None;
                }
                let center = self.axis.foot(corners[i]);
                let frame = Frame::new(center, self.axis.direction, Some(corners[i] - center));
                let circle = Curve::circle(frame, corners[i].distance(center));
                a.edge(circle, [0.0, self.angle], [from.vertices[i], to.vertices[i]])
            })
            .collect();
        let sides = wire.pieces().iter().zip(&still).map(|(p, s)| if *s { None } else { self.side(p) }).collect();
        a.strip(wire, [from, &to], &rails, sides, name);
        Ok((end, to))
    }

    fn side(&self, p: &Piece) -> Side {
        let Axis { origin, direction: k } = self.axis;
        let middle = p.at(0.5);
        let foot = self.axis.foot(middle);
        let out = p.tangent(0.5).cross(k.cross(middle - foot));
        let reach = middle.distance(foot);
        let frame = |at: DVec3| Frame::new(at, k, Some(middle - foot));
        let general = || {
            let surface =
                Surface::Revolution { curve: p.curve.clone(), frame: Frame::new(origin, k, Some(middle - foot)) };
            // Su x Sv is the turn times the curve's derivative.
            Some((surface, !p.forward))
        };
        let by_foot = |s: Surface| side_by_foot(s, middle, out);
        match &p.curve {
            Curve::Line { direction, .. } => {
                let d = direction.normalize();
                let skew = k.cross(middle - foot).normalize().dot(d).abs() > FEW_ROUNDINGS;
                let rise = d.dot(k);
                let radial = d.dot((middle - foot).normalize());
                if skew {
                    general()
                } else if rise.abs() <= FEW_ROUNDINGS {
                    by_foot(Surface::Plane { frame: frame(foot) })
                } else if radial.abs() <= FEW_ROUNDINGS {
                    by_foot(Surface::Cylinder { frame: frame(foot), radius: reach })
                } else {
                    by_foot(Surface::Cone { frame: frame(foot), radius: reach, slope: radial / rise })
                }
            }
            Curve::Ellipse { frame: f, a, b } if a == b => {
                let center = self.axis.foot(f.origin);
                let major = center.distance(f.origin);
                let upright = f.z().dot(k).abs() <= FEW_ROUNDINGS
                    && (f.origin - origin).dot(f.z()).abs() <= FEW_ROUNDINGS * (a + major);
                if upright && major <= FEW_ROUNDINGS * a {
                    by_foot(Surface::Sphere { frame: frame(center), radius: *a })
                } else if upright && major > *a {
                    by_foot(Surface::Torus { frame: frame(center), major, minor: *a })
                } else {
                    general()
                }
            }
            _ => general(),
        }
    }
}

/// Whether a piece lies on the axis.
fn on_axis(p: &Piece, axis: &Axis, touch: f64) -> bool {
    matches!(p.curve, Curve::Line { .. }) && axis.radius(p.at(0.0)) <= touch && axis.radius(p.at(1.0)) <= touch
}
