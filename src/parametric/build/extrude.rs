//! Edges extruded along a direction (\[KUZ19\] 31, sections 3.1 and 3.2), their ends scaled.

use glam::DVec3;

use super::assembly::{Along, Assembly, BodyChain, Side, region, side_by_foot};
use super::wire::{Piece, Wire, refuse};
use crate::error::Result;
use crate::numeric::FEW_ROUNDINGS;
use crate::parametric::brep::Brep;
use crate::parametric::curve::Curve;
use crate::parametric::frame::{Frame, Similarity};
use crate::parametric::nurbs::NurbsSurface;
use crate::parametric::surface::Surface;

/// How edges are extruded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extrusion {
    /// Where to; any length.
    pub direction: DVec3,
    /// How far.
    pub distance: f64,
    /// Size of the far end relative to the near one, above 0.
    pub scale: f64,
    /// What stays in its place when the end is scaled: the middle of the box around the edges, where this is `None`.
    pub center: Option<DVec3>,
    /// Size of the far ends of holes relative to the near ones, each scaled about its own middle: a draft. As the border where
    /// this is `None`.
    pub hole_scale: Option<f64>,
    /// Whether the ends are closed by flat faces, which makes a solid of closed contours.
    pub caps: bool,
}

impl Extrusion {
    /// A solid along a direction, not scaled.
    pub fn new(direction: DVec3, distance: f64) -> Self {
        Self { direction, distance, scale: 1.0, center: None, hole_scale: None, caps: true }
    }
}

/// Extrudes chains of edges. With caps, the first is the outer border and the others are holes; without, each makes a
/// sheet. Faces are called `side` (with a number where there are several), `start` and `end`.
///
/// Errors: a direction without length, a distance or scale that is not positive; with caps, a contour that is open (the gap
/// is named), not flat, or runs along the direction.
pub fn extrude_edges(wires: &[Wire], how: &Extrusion) -> Result<Brep> {
    let Some(direction) = how.direction.try_normalize() else {
        return refuse("the direction of an extrusion has no length");
    };
    if !(how.distance > 0.0 && how.distance.is_finite()) {
        return refuse(format!("the distance of an extrusion must be positive, not {}", how.distance));
    }
    for s in [Some(how.scale), how.hole_scale].into_iter().flatten() {
        if !(s > 0.0 && s.is_finite()) {
            return refuse(format!("the end scale of an extrusion must be positive, not {s}"));
        }
    }
    if wires.is_empty() {
        return refuse("nothing to extrude");
    }
    let wires = if how.caps { region(wires, direction)? } else { wires.to_vec() };
    let all = wires.iter().fold(crate::spatial::Aabb::EMPTY, |b, w| b.union(&w.bounds()));
    let center = how.center.unwrap_or(all.center());
    let touch = Some(wires.iter().map(Wire::tolerance).fold(0.0, f64::max));
    let mut a = Assembly { touch, ..Assembly::default() };
    let shift = direction * how.distance;
    let (mut first, mut last, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for (i, w) in wires.iter().enumerate() {
        let from = a.border(w);
        let name = if i == 0 { "side".to_string() } else { format!("hole{i}.side") };
        let strip = match how.hole_scale.filter(|_| i > 0) {
            Some(scale) => ExtrudedStrip { shift, scale, center: w.bounds().center() },
            None => ExtrudedStrip { shift, scale: how.scale, center },
        };
        let (end, to) = strip.add(&mut a, w, &from, &name)?;
        first.push(from);
        last.push(to);
        ends.push(end);
    }
    if how.caps {
        a.cap(&wires, &first, false, "start")?;
        a.cap(&ends, &last, true, "end")?;
    }
    Ok(a.body("extrusion", how.caps))
}

/// Faces from a chain to its image by a shift and a scale.
pub(super) struct ExtrudedStrip {
    pub(super) shift: DVec3,
    pub(super) scale: f64,
    pub(super) center: DVec3,
}

impl ExtrudedStrip {
    /// Adds the faces and gives the chain at the far end.
    pub(super) fn add(&self, a: &mut Assembly, wire: &Wire, from: &BodyChain, name: &str) -> Result<(Wire, BodyChain)> {
        let s = self.scale;
        let by =
            Similarity { scale: s, translation: self.center + self.shift - s * self.center, ..Similarity::IDENTITY };
        let end = wire.moved(&by);
        let to = a.border(&end);
        let rails: Vec<Along> = (0..from.vertices.len())
            .map(|i| {
                let ends = [from.vertices[i], to.vertices[i]];
                let [p, q] = ends.map(|v| a.brep.vertices[v as usize]);
                a.edge(Curve::segment(p, q), [0.0, 1.0], ends)
            })
            .collect();
        let sides: Result<Vec<Side>> = wire.pieces().iter().map(|p| self.side(p, &by)).collect();
        a.strip(wire, [from, &to], &rails, sides?, name);
        Ok((end, to))
    }

    fn side(&self, p: &Piece, by: &Similarity) -> Result<Side> {
        let middle = p.at(0.5);
        let (along, up) = (p.tangent(0.5), by.point(middle) - middle);
        let out = along.cross(up);
        match &p.curve {
            Curve::Line { .. } => {
                let z = along.cross(by.point(p.at(0.0)) - p.at(0.0));
                // Two directions whose sine is below this are parallel.
                if !(z.length() > FEW_ROUNDINGS * along.length() * self.shift.length()) {
                    return refuse(format!("the edge from {} to {} is extruded along itself", p.at(0.0), p.at(1.0)));
                }
                return Ok(side_by_foot(Surface::Plane { frame: Frame::new(p.at(0.0), z, Some(along)) }, middle, out));
            }
            Curve::Ellipse { frame, a, b } if a == b => {
                let axis = by.point(frame.origin) - frame.origin;
                let height = axis.dot(frame.z());
                if axis.cross(frame.z()).length() <= FEW_ROUNDINGS * axis.length() {
                    let frame = Frame { axes: frame.axes, ..*frame };
                    let grown = (self.scale - 1.0) * a;
                    return Ok(side_by_foot(
                        if grown == 0.0 {
                            Surface::Cylinder { frame, radius: *a }
                        } else {
                            Surface::Cone { frame, radius: *a, slope: grown / height }
                        },
                        middle,
                        out,
                    ));
                }
            }
            _ => {}
        }
        if self.scale == 1.0 {
            let turned = p.forward;
            return Ok(Some((Surface::Extrusion { curve: p.curve.clone(), direction: self.shift }, turned)));
        }
        let near = p.to_nurbs()?;
        let far = near.map(|q| by.point(q));
        Ok(Some((Surface::Nurbs(NurbsSurface::through(&[near, far], &[0.0, 1.0], &[None, None])?), true)))
    }
}
