//! Edges swept along a path: straight parts extrude them, arcs revolve them, and along other curves they are carried by the
//! frame that turns least (W. Wang et al., "Computation of rotation minimizing frames", 2008).

use std::f64::consts::TAU;

use glam::{DMat3, DVec3, DVec4};

use super::assembly::{Assembly, BodyChain, Side, region};
use super::extrude::ExtrudedStrip;
use super::loft::rails;
use super::revolve::{Axis, Turn};
use super::wire::{Piece, Wire, refuse};
use crate::error::Result;
use crate::parametric::brep::Brep;
use crate::parametric::curve::Curve;
use crate::parametric::frame::Similarity;
use crate::parametric::nurbs::{NurbsCurve, NurbsSurface};
use crate::parametric::surface::Surface;

/// Edges of a path whose directions differ by less than this (a cosine, 0.01 degrees) go on smoothly.
const SMOOTH: f64 = 0.999_999_98;
/// A swept spline surface is this near, as a share of the profile's size, to where the frame carries the profile.
const NEAR: f64 = 1e-7;
/// Sections on one edge of a path, at most.
const MOST_SECTIONS: usize = 257;
/// Steps of the frame between two sections.
const FRAME_STEPS: usize = 16;

/// Sweeps chains of edges along a path, each staying rigid and keeping its angle to the path. With `solid`, the first chain
/// is the outer border and the others are holes, all flat; without, each makes a sheet. Faces are called `side`, with
/// numbers where the path or a chain has several edges, `start` and `end`.
///
/// *Guarantees*: exact along straight edges and arcs; elsewhere within 1e-7 of the profile's size of the carried profile.
/// *Errors*: a path with a corner (named) or one that closes, unless it is a circle; a profile that reaches over the axis of
/// an arc or the center of the path's curvature; with `solid`, see [`extrude_edges`](super::extrude_edges).
pub fn sweep_edges(wires: &[Wire], path: &Wire, solid: bool) -> Result<Brep> {
    let Some(start) = path.pieces()[0].tangent(0.0).try_normalize() else {
        return refuse("the path of a sweep starts without a direction");
    };
    let around = matches!(path.pieces(), [p] if full_circle(p));
    if path.is_closed() && !around {
        return refuse("the path of a sweep closes: only a circle may");
    }
    for pair in path.pieces().windows(2) {
        let (a, b) = (pair[0].tangent(1.0).normalize_or_zero(), pair[1].tangent(0.0).normalize_or_zero());
        if !(a.dot(b) > SMOOTH) {
            return refuse(format!("the path of the sweep has a corner at {}", pair[1].at(0.0)));
        }
    }
    let wires = if solid { region(wires, start)? } else { wires.to_vec() };
    let mut a = Assembly::default();
    let (mut first, mut last, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for (i, w) in wires.iter().enumerate() {
        let hole = if i == 0 { String::new() } else { format!("hole{i}.") };
        let from = a.border(w);
        first.push(from.clone());
        let (mut at, mut border) = (w.clone(), from);
        for (j, p) in path.pieces().iter().enumerate() {
            let part =
                if path.pieces().len() > 1 { format!("{hole}part{}.side", j + 1) } else { format!("{hole}side") };
            (at, border) = step(&mut a, &at, &border, p, &part)?;
        }
        last.push(border);
        ends.push(at);
    }
    if solid && !around {
        a.cap(&wires, &first, false, "start")?;
        a.cap(&ends, &last, true, "end")?;
    }
    Ok(a.body("sweep", solid))
}

fn full_circle(p: &Piece) -> bool {
    matches!(p.curve, Curve::Ellipse { a, b, .. } if a == b) && p.range[1] - p.range[0] >= TAU
}

/// The faces along one edge of the path.
fn step(a: &mut Assembly, wire: &Wire, from: &BodyChain, p: &Piece, name: &str) -> Result<(Wire, BodyChain)> {
    match &p.curve {
        Curve::Line { .. } => {
            ExtrudedStrip { shift: p.at(1.0) - p.at(0.0), scale: 1.0, center: DVec3::ZERO }.add(a, wire, from, name)
        }
        Curve::Ellipse { frame, a: r, b } if r == b => {
            let direction = if p.forward { frame.z() } else { -frame.z() };
            let turn = Turn { axis: Axis { origin: frame.origin, direction }, angle: p.range[1] - p.range[0] };
            let touch = wire.tolerance();
            let radial = (p.at(0.0) - frame.origin).normalize();
            if let Some(q) = wire.samples().into_iter().find(|q| (*q - frame.origin).dot(radial) <= touch) {
                return refuse(format!("the profile reaches over the axis of an arc of the path at {q}"));
            }
            turn.add(a, wire, from, touch, name)
        }
        _ => carried(a, wire, from, p, name),
    }
}

/// Where a path's frame has carried the profile, and how fast that goes on.
struct Station {
    share: f64,
    by: Similarity,
    /// The path's point there, its derivative by the share, and the angular velocity.
    point: DVec3,
    speed: DVec3,
    spin: DVec3,
}

fn carried(a: &mut Assembly, wire: &Wire, from: &BodyChain, p: &Piece, name: &str) -> Result<(Wire, BodyChain)> {
    let size = wire.bounds().diagonal();
    let curves: Result<Vec<NurbsCurve>> = wire.pieces().iter().map(Piece::to_nurbs).collect();
    let curves = curves?;
    let profile = wire.samples();
    let mut count = 4 * (p.curve.pieces(p.range).len() - 1) + 1;
    let (surfaces, end) = loop {
        // Every other station lies between two sections and tells how far the spline is off.
        let all = stations(p, 2 * count - 1)?;
        for (s, p) in all.iter().flat_map(|s| profile.iter().map(move |p| (s, s.by.point(*p)))) {
            if !((s.speed + s.spin.cross(p - s.point)).dot(s.speed) > 0.0) {
                return refuse(format!(
                    "the profile reaches over the center of the path's curvature at {p}: the sweep folds"
                ));
            }
        }
        let made: Result<Vec<NurbsSurface>> = curves.iter().map(|c| through(c, &all)).collect();
        let made = made?;
        let mut off: f64 = 0.0;
        for (c, s) in curves.iter().zip(&made) {
            for station in all.iter().skip(1).step_by(2) {
                for k in 0..=4 {
                    let u = f64::from(k) / 4.0;
                    off = off.max(s.jet(u, station.share)[0].distance(station.by.point(c.jet(u)[0])));
                }
            }
        }
        if off <= NEAR * size || 2 * count - 1 > MOST_SECTIONS {
            break (made, all[all.len() - 1].by);
        }
        count = 2 * count - 1;
    };
    let end = wire.moved(&end);
    let to = a.border(&end);
    let rails = rails(a, &surfaces, [from, &to])?;
    let sides: Vec<Side> = surfaces.into_iter().map(|s| Some((Surface::Nurbs(s), true))).collect();
    a.strip(wire, [from, &to], &rails, sides, name);
    Ok((end, to))
}

/// The surface through a curve carried to every other station, with the right slopes at both ends.
fn through(c: &NurbsCurve, all: &[Station]) -> Result<NurbsSurface> {
    let used: Vec<&Station> = all.iter().step_by(2).collect();
    let sections: Vec<NurbsCurve> = used.iter().map(|s| c.map(|p| s.by.point(p))).collect();
    let t: Vec<f64> = used.iter().map(|s| s.share).collect();
    let slope = |k: usize| -> Vec<DVec4> {
        let s = used[k];
        let at = |p: DVec3| s.speed + s.spin.cross(p - s.point);
        sections[k].weighted().iter().map(|p| (at(p.truncate() / p.w) * p.w).extend(0.0)).collect()
    };
    NurbsSurface::through(&sections, &t, &[Some(slope(0)), Some(slope(used.len() - 1))])
}

/// Stations at equal shares of the path's parameter.
fn stations(p: &Piece, count: usize) -> Result<Vec<Station>> {
    let length = (p.range[1] - p.range[0]) * if p.forward { 1.0 } else { -1.0 };
    let jet = |share: f64| p.curve.jet(p.parameter(share));
    let tangent = |share: f64| p.tangent(share).try_normalize();
    let start = p.at(0.0);
    let mut rotation = DMat3::IDENTITY;
    let mut out = Vec::with_capacity(count);
    let steps = (count - 1) * FRAME_STEPS;
    for i in 0..=steps {
        let share = i as f64 / steps as f64;
        let Some(t) = tangent(share) else {
            return refuse(format!("the path of the sweep stands still at {}", p.at(share)));
        };
        if i > 0 {
            let before = (i - 1) as f64 / steps as f64;
            let first = mirror(p.at(share) - p.at(before));
            let Some(last) = tangent(before) else { continue };
            rotation = mirror(t - first * last) * first * rotation;
        }
        if i % FRAME_STEPS == 0 {
            let [point, d, e] = jet(share);
            let (speed, bend) = (length * d, length * length * e);
            let spin = speed.cross(bend) / speed.length_squared();
            let by = Similarity { scale: 1.0, rotation, translation: point - rotation * start };
            out.push(Station { share, by, point, speed, spin });
        }
    }
    Ok(out)
}

/// The reflection that turns `v` around.
fn mirror(v: DVec3) -> DMat3 {
    let l = v.length_squared();
    if !(l > 0.0) {
        return DMat3::IDENTITY;
    }
    let k = 2.0 / l;
    DMat3::IDENTITY - DMat3::from_cols(v * (v.x * k), v * (v.y * k), v * (v.z * k))
}
