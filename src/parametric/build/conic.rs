//! Arcs of curves of second order as edges: by half axes, and by their general equation in the plane.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::wire::{Piece, Wire, refuse};
use crate::error::Result;
use crate::numeric::{FEW_ROUNDINGS, SEVEN_DIGITS};
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;

/// One edge over a range that may fall, which is run through backwards then.
fn arc(curve: Curve, [from, to]: [f64; 2]) -> Result<Wire> {
    if !(from != to && from.is_finite() && to.is_finite()) {
        return refuse("the arc has no length, or is longer than numbers go");
    }
    Wire::new(vec![Piece { curve, range: [from.min(to), from.max(to)], forward: from < to }])
}

impl Wire {
    /// An arc of the parabola `y^2 = 4 focal x` in the frame's xy plane, from y = `across[0]` to y = `across[1]`.
    /// Errors: a focal length that is not positive; an arc without length.
    pub fn parabola(frame: Frame, focal: f64, across: [f64; 2]) -> Result<Self> {
        if !(focal > 0.0 && focal.is_finite()) {
            return refuse("the focal length of a parabola must be positive");
        }
        arc(Curve::Parabola { frame, focal }, across.map(|y| y / (2.0 * focal)))
    }

    /// An arc of the hyperbola `x^2 / a^2 - y^2 / b^2 = 1` in the frame's xy plane, of its branch with positive x, from
    /// y = `across[0]` to y = `across[1]`. `radii` are a and b. Errors: half axes that are not positive; an arc without length.
    pub fn hyperbola(frame: Frame, radii: [f64; 2], across: [f64; 2]) -> Result<Self> {
        let [a, b] = radii;
        if !(a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite()) {
            return refuse("the half axes of a hyperbola must be positive");
        }
        arc(Curve::Hyperbola { frame, a, b }, across.map(|y| (y / b).asinh()))
    }

    /// An arc of the curve `A x^2 + B x y + C y^2 + D x + E y + F = 0` in the plane z = 0 between two of its points: of an
    /// ellipse counter-clockwise, or all of it where `ends` are left out.
    ///
    /// Errors: an equation of no curve, of lines or of a point; ends that are missing, off the curve, at one place, or on
    /// different branches of a hyperbola.
    pub fn conic(coefficients: [f64; 6], ends: Option<[DVec2; 2]>) -> Result<Self> {
        let curve = curve(coefficients)?;
        let (Some(ends), Some(frame)) = (ends, frame_of(&curve)) else {
            return match curve {
                Curve::Ellipse { frame, a, b } => Self::ellipse(frame, a, b),
                _ => refuse("the curve is not closed: say where the arc starts and ends"),
            };
        };
        let local = ends.map(|p| frame.local(p.extend(0.0)).truncate());
        let (curve, local) = match curve {
            Curve::Hyperbola { .. } if (local[0].x > 0.0) != (local[1].x > 0.0) => {
                return refuse(format!("{} and {} are on different branches of the hyperbola", ends[0], ends[1]));
            }
            // The other branch, seen with both axes turned round.
            Curve::Hyperbola { a, b, .. } if local[0].x < 0.0 => {
                let frame = Frame::new(frame.origin, DVec3::Z, Some(-frame.axes.x_axis));
                (Curve::Hyperbola { frame, a, b }, local.map(|p| -p))
            }
            other => (other, local),
        };
        let t = local.map(|p| match &curve {
            Curve::Hyperbola { b, .. } => (p.y / b).asinh(),
            Curve::Parabola { focal, .. } => p.y / (2.0 * focal),
            Curve::Ellipse { a, b, .. } => (p.y / b).atan2(p.x / a),
            _ => 0.0,
        });
        for (p, t) in ends.iter().zip(t) {
            let off = curve.at(t).distance(p.extend(0.0));
            // An end may be a little off the curve.
            if !(off <= SEVEN_DIGITS * (p.distance(frame.origin.truncate()) + ends[0].distance(ends[1]))) {
                return refuse(format!("{p} is not on the curve: it is {off} off"));
            }
        }
        if !(ends[0].distance(ends[1]) > SEVEN_DIGITS * local[0].length().max(local[1].length())) {
            return refuse("the arc starts and ends at one place");
        }
        let round = matches!(curve, Curve::Ellipse { .. }) && t[1] < t[0];
        arc(curve, [t[0], if round { t[1] + TAU } else { t[1] }])
    }
}

fn frame_of(c: &Curve) -> Option<Frame> {
    match c {
        Curve::Ellipse { frame, .. } | Curve::Parabola { frame, .. } | Curve::Hyperbola { frame, .. } => Some(*frame),
        _ => None,
    }
}

/// The curve of an equation, turned to its main axes.
fn curve([a, b, c, d, e, f]: [f64; 6]) -> Result<Curve> {
    let size = a.abs() + b.abs() + c.abs();
    if !(size > 0.0 && [size, d, e, f].iter().all(|x| x.is_finite())) {
        return refuse("a curve of second order needs a finite term in x^2, x y or y^2");
    }
    let lines = || refuse("the equation is of lines or of a point, not of a curve");
    let angle = 0.5 * b.atan2(a - c);
    let x = DVec2::from_angle(angle);
    let y = x.perp();
    let along = |v: DVec2| a * v.x * v.x + b * v.x * v.y + c * v.y * v.y;
    let bend = [along(x), along(y)];
    let slope = DVec2::new(d, e);
    let place = |center: DVec2, x: DVec2| Frame::new(center.extend(0.0), DVec3::Z, Some(x.extend(0.0)));
    // Numbers below this share of the terms they are the difference of are rounding.
    if let Some(k) = (0..2).find(|k| bend[*k].abs() <= FEW_ROUNDINGS * size) {
        let (axis, across, bend) = if k == 0 { (x, y, bend[1]) } else { (y, x, bend[0]) };
        let (gx, gy) = (slope.dot(axis), slope.dot(across));
        if !(gx.abs() > FEW_ROUNDINGS * slope.length()) {
            return lines();
        }
        let off = -gy / (2.0 * bend);
        let vertex = axis * (-(f - gy * gy / (4.0 * bend)) / gx) + across * off;
        let opening = if gx * bend > 0.0 { -axis } else { axis };
        return Ok(Curve::Parabola { frame: place(vertex, opening), focal: 0.25 * (gx / bend).abs() });
    }
    let center = x * (-0.5 * slope.dot(x) / bend[0]) + y * (-0.5 * slope.dot(y) / bend[1]);
    let middle = 0.5 * slope.dot(center);
    let rest = -(f + middle);
    if !(rest.abs() > FEW_ROUNDINGS * (f.abs() + middle.abs())) {
        return lines();
    }
    let squares = bend.map(|k| rest / k);
    let [a, b] = squares.map(|s| s.abs().sqrt());
    match squares.map(|s| s > 0.0) {
        [true, true] => Ok(Curve::Ellipse { frame: place(center, x), a, b }),
        [true, false] => Ok(Curve::Hyperbola { frame: place(center, x), a, b }),
        [false, true] => Ok(Curve::Hyperbola { frame: place(center, y), a: b, b: a }),
        _ => refuse("no point satisfies the equation"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn says(made: Result<Wire>, what: &str) {
        let e = made.unwrap_err().to_string();
        assert!(e.contains(what), "{e}");
    }

    #[test]
    fn arcs_across_branches_and_equations_of_lines_are_refused() {
        let p = DVec2::new;
        let hyperbola = [1.0, 0.0, -1.0, 0.0, 0.0, -1.0];
        let y = 3f64.sqrt();
        assert!(Wire::conic(hyperbola, Some([p(-2.0, -y), p(-2.0, y)])).is_ok());
        says(Wire::conic(hyperbola, Some([p(-2.0, y), p(2.0, y)])), "different branches");
        says(Wire::conic(hyperbola, Some([p(2.0, y), p(2.0, 1.0)])), "is not on the curve");
        says(Wire::conic(hyperbola, Some([p(2.0, y), p(2.0, y)])), "at one place");
        says(Wire::conic(hyperbola, None), "not closed");
        says(Wire::conic([1.0, 0.0, 1.0, 0.0, 0.0, 1.0], None), "no point");
        for lines in [[1.0, 0.0, -1.0, 0.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0, 0.0, -1.0], [1.0, 0.0, 1.0, -2.0, 0.0, 1.0]]
        {
            says(Wire::conic(lines, None), "lines or of a point");
        }
        says(Wire::conic([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], None), "needs a finite term");
        says(Wire::parabola(Frame::WORLD, 1.0, [2.0, 2.0]), "no length");
        says(Wire::hyperbola(Frame::WORLD, [0.0, 1.0], [0.0, 1.0]), "must be positive");
    }

    proptest! {
        #[test]
        fn arcs_satisfy_their_equation(turn in 0.0f64..6.2, kind in 0usize..3, s in -1.0f64..1.0, t in -1.0f64..1.0, q in -3.0f64..3.0) {
            prop_assume!((s - t).abs() > 0.05);
            // A curve in its own axes, turned and moved: its equation by substitution.
            let (a, c, d, f) = [(0.25, 1.0, 0.0, -1.0), (0.25, -1.0, 0.0, -1.0), (0.0, 1.0, -2.0, 0.0)][kind];
            let own = |t: f64| match kind {
                0 => DVec2::new(2.0 * t.cos(), t.sin()),
                1 => DVec2::new(2.0 * t.cosh(), t.sinh()),
                _ => DVec2::new(0.5 * t * t, t),
            };
            let (x, m) = (DVec2::from_angle(turn), DVec2::new(q, 1.0 - q));
            let y = x.perp();
            let quad = [a * x.x * x.x + c * y.x * y.x, 2.0 * (a * x.x * x.y + c * y.x * y.y), a * x.y * x.y + c * y.y * y.y];
            let linear = x * d;
            let moved = [
                linear.x - 2.0 * quad[0] * m.x - quad[1] * m.y,
                linear.y - 2.0 * quad[2] * m.y - quad[1] * m.x,
                f - linear.dot(m) + quad[0] * m.x * m.x + quad[1] * m.x * m.y + quad[2] * m.y * m.y,
            ];
            let k = [quad[0], quad[1], quad[2], moved[0], moved[1], moved[2]];
            let ends = [s, t].map(|t| m + x * own(t).x + y * own(t).y);
            let w = Wire::conic(k, Some(ends)).unwrap();
            prop_assert!(w.start().distance(ends[0].extend(0.0)) < 1e-6 && w.end().distance(ends[1].extend(0.0)) < 1e-6);
            for i in 0..=8 {
                let p = w.pieces()[0].at(f64::from(i) / 8.0);
                let left = k[0] * p.x * p.x + k[1] * p.x * p.y + k[2] * p.y * p.y + k[3] * p.x + k[4] * p.y + k[5];
                prop_assert!(left.abs() < 1e-6, "{left}");
            }
        }
    }
}
