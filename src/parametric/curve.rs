//! Curves in space: lines, conics, and NURBS for everything else (\[KUZ19\] 1-27).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::frame::{Frame, Similarity};
use super::nurbs::NurbsCurve;

/// Squares of distances that differ by less than this share count as equal.
pub(super) const FLAT: f64 = 1e-11;
/// Parts a smooth piece of a curve is looked at in: it turns by about a quarter of a circle at most, each of them by some 11 degrees.
pub(super) const PARTS: usize = 8;
/// Newton steps before a projection is taken as it is.
const NEWTON_STEPS: usize = 30;

/// A curve, parametrized as in ISO 10303-42. Angles are in radians.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// `origin + t * direction`; the direction need not be of unit length.
    Line {
        /// The point at parameter 0.
        origin: DVec3,
        /// From there to the point at parameter 1.
        direction: DVec3,
    },
    /// `a cos t`, `b sin t` in the frame's xy plane; a circle where both are equal.
    Ellipse {
        /// Center and axes.
        frame: Frame,
        /// Radius along x.
        a: f64,
        /// Radius along y.
        b: f64,
    },
    /// `f t^2`, `2 f t` in the frame's xy plane.
    Parabola {
        /// Vertex and axes.
        frame: Frame,
        /// Distance of the focus from the vertex.
        focal: f64,
    },
    /// `a cosh t`, `b sinh t` in the frame's xy plane.
    Hyperbola {
        /// Center and axes.
        frame: Frame,
        /// Half axis along x.
        a: f64,
        /// Half axis along y.
        b: f64,
    },
    /// A rational B-spline.
    Nurbs(NurbsCurve),
}

impl Curve {
    /// A circle around the frame's origin in its xy plane.
    pub fn circle(frame: Frame, radius: f64) -> Self {
        Curve::Ellipse { frame, a: radius, b: radius }
    }

    /// The straight piece from `a` (parameter 0) to `b` (parameter 1).
    pub fn segment(a: DVec3, b: DVec3) -> Self {
        Curve::Line { origin: a, direction: b - a }
    }

    /// Point, first and second derivative.
    pub fn jet(&self, t: f64) -> [DVec3; 3] {
        let flat = |f: &Frame, p: DVec2, d: DVec2, e: DVec2| {
            let v = |q: DVec2| f.axes.x_axis * q.x + f.axes.y_axis * q.y;
            [f.origin + v(p), v(d), v(e)]
        };
        match self {
            Curve::Line { origin, direction } => [*origin + t * *direction, *direction, DVec3::ZERO],
            Curve::Ellipse { frame, a, b } => {
                let (s, c) = t.sin_cos();
                let p = DVec2::new(a * c, b * s);
                flat(frame, p, DVec2::new(-a * s, b * c), -p)
            }
            Curve::Parabola { frame, focal } => {
                let f = *focal;
                flat(
                    frame,
                    DVec2::new(f * t * t, 2.0 * f * t),
                    DVec2::new(2.0 * f * t, 2.0 * f),
                    DVec2::new(2.0 * f, 0.0),
                )
            }
            Curve::Hyperbola { frame, a, b } => {
                let (s, c) = (t.sinh(), t.cosh());
                let p = DVec2::new(a * c, b * s);
                flat(frame, p, DVec2::new(a * s, b * c), p)
            }
            Curve::Nurbs(n) => n.jet(t),
        }
    }

    /// The point at a parameter.
    pub fn at(&self, t: f64) -> DVec3 {
        self.jet(t)[0]
    }

    /// The parameters the curve is defined for.
    pub fn domain(&self) -> [f64; 2] {
        match self {
            Curve::Ellipse { .. } => [0.0, TAU],
            Curve::Nurbs(n) => n.knots.domain(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The period, of a curve that repeats itself.
    pub fn period(&self) -> Option<f64> {
        match self {
            Curve::Ellipse { .. } => Some(TAU),
            Curve::Nurbs(n) if n.is_closed() => {
                let [a, b] = n.knots.domain();
                Some(b - a)
            }
            _ => None,
        }
    }

    /// Curvature: the inverse of the radius of the circle that fits best, 0 where the curve stands still.
    pub fn curvature(&self, t: f64) -> f64 {
        let [_, d, e] = self.jet(t);
        let speed = d.length();
        if speed > 0.0 { d.cross(e).length() / speed.powi(3) } else { 0.0 }
    }

    /// Parameters in `range` (ascending, ends included) between which the curve is smooth and turns by no more than about
    /// a quarter of a circle.
    pub fn pieces(&self, range: [f64; 2]) -> Vec<f64> {
        let [a, b] = range;
        let mut out = vec![a];
        match self {
            Curve::Line { .. } => {}
            Curve::Nurbs(n) => {
                let breaks = n.knots.breaks();
                let parts = n.knots.degree().max(1);
                let rounds: &[f64] = if n.is_closed() { &[-1.0, 0.0, 1.0] } else { &[0.0] };
                let round = breaks[breaks.len() - 1] - breaks[0];
                for (r, w) in rounds.iter().flat_map(|r| breaks.windows(2).map(move |w| (r * round, w))) {
                    for k in 0..parts {
                        let t = r + w[0] + (w[1] - w[0]) * k as f64 / parts as f64;
                        if t > a && t < b {
                            out.push(t);
                        }
                    }
                }
            }
            Curve::Ellipse { .. } | Curve::Parabola { .. } | Curve::Hyperbola { .. } => {
                let parts = ((b - a) / (0.25 * TAU)).ceil().clamp(4.0, 64.0);
                out.extend((1..parts as usize).map(|k| a + (b - a) * k as f64 / parts));
            }
        }
        out.push(b);
        out
    }

    /// Length between two parameters, by Gauss's rule with five points on each of the [`pieces`](Self::pieces).
    pub fn length(&self, range: [f64; 2]) -> f64 {
        self.pieces(range).windows(2).map(|w| gauss(w[0], w[1], |t| self.jet(t)[1].length())).sum()
    }

    /// Whether [`project`](Self::project) needs no start: lines and circles.
    pub fn has_closed_foot(&self) -> bool {
        match self {
            Curve::Line { .. } => true,
            Curve::Ellipse { a, b, .. } => a == b,
            _ => false,
        }
    }

    /// The parameter in `range` of the point nearest to `p`. With `near`, the local one there; without, the best of all
    /// that the [`pieces`](Self::pieces) lead to. On a curve that repeats itself the answer is the one inside `range`.
    pub fn project(&self, p: DVec3, range: [f64; 2], near: Option<f64>) -> f64 {
        let [a, b] = range;
        match self {
            Curve::Line { origin, direction } => {
                let t = (p - *origin).dot(*direction) / direction.length_squared();
                return if t.is_finite() { t.clamp(a, b) } else { a };
            }
            Curve::Ellipse { frame, a: r, b: q } if r == q => {
                let local = frame.local(p);
                let t = Frame::angle(DVec2::new(local.x, local.y));
                return into_range(t, TAU, range, |t| self.at(t).distance_squared(p));
            }
            _ => {}
        }
        if let Some(t) = near {
            return self.newton(p, range, t);
        }
        let starts = self.pieces(range);
        let mut seeds: Vec<(f64, f64)> = Vec::new();
        for w in starts.windows(2) {
            for k in 0..4 {
                let t = w[0] + 0.25 * f64::from(k) * (w[1] - w[0]);
                seeds.push((self.at(t).distance_squared(p), t));
            }
        }
        seeds.push((self.at(b).distance_squared(p), b));
        // The nearest samples that have no nearer neighbor.
        let low: Vec<f64> = (0..seeds.len())
            .filter(|&i| (i == 0 || seeds[i - 1].0 >= seeds[i].0) && seeds.get(i + 1).is_none_or(|n| n.0 >= seeds[i].0))
            .map(|i| seeds[i].1)
            .collect();
        let tried = low.into_iter().map(|t| self.newton(p, range, t));
        tried.min_by(|x, y| self.at(*x).distance_squared(p).total_cmp(&self.at(*y).distance_squared(p))).unwrap_or(a)
    }

    fn newton(&self, p: DVec3, [a, b]: [f64; 2], start: f64) -> f64 {
        let mut t = start.clamp(a, b);
        let [mut c, mut d, mut e] = self.jet(t);
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let r = c - p;
            let slope = r.dot(d);
            let full = d.length_squared() + r.dot(e);
            // Far from the foot the second derivative may point the wrong way: then Gauss's step goes downhill.
            let newton = full > 0.1 * d.length_squared();
            let bend = if newton { full } else { d.length_squared() };
            if !(bend > 0.0) {
                break;
            }
            let mut step = -slope / bend;
            let mut moved = false;
            // Whether this is Newton's own step, and the one before was.
            let own = newton && (a..=b).contains(&(t + step));
            for _ in 0..8 {
                let next = (t + step).clamp(a, b);
                let jet = self.jet(next);
                // Near the foot squares of distances no longer tell better from worse; Newton's step does.
                if jet[0].distance_squared(p) <= c.distance_squared(p) * (1.0 + FLAT) {
                    moved = next != t;
                    (t, [c, d, e]) = (next, jet);
                    break;
                }
                step *= 0.5;
            }
            let length = step.abs() * d.length();
            // The error shrinks with its square: the next step would be about so long.
            let next = if own && before.is_finite() { length * (length / before).powi(2) } else { length };
            if !moved || length.min(next) <= 1e-15 * (c.length() + d.length()) {
                break;
            }
            before = if own { length } else { f64::INFINITY };
        }
        t
    }

    /// The curve moved; parameters stay.
    pub fn moved(&self, m: &Similarity) -> Self {
        let s = m.scale;
        match self {
            Curve::Line { origin, direction } => {
                Curve::Line { origin: m.point(*origin), direction: m.vector(*direction) }
            }
            Curve::Ellipse { frame, a, b } => Curve::Ellipse { frame: m.frame(frame), a: s * a, b: s * b },
            Curve::Parabola { frame, focal } => Curve::Parabola { frame: m.frame(frame), focal: s * focal },
            Curve::Hyperbola { frame, a, b } => Curve::Hyperbola { frame: m.frame(frame), a: s * a, b: s * b },
            Curve::Nurbs(n) => Curve::Nurbs(n.map(|p| m.point(p))),
        }
    }
}

/// Brings `t` into `range` by whole periods; where it falls into the gap, to the end that `cost` likes better.
pub(super) fn into_range(t: f64, period: f64, [a, b]: [f64; 2], cost: impl Fn(f64) -> f64) -> f64 {
    let t = a + (t - a).rem_euclid(period);
    if t <= b {
        return t;
    }
    if cost(a) < cost(b) { a } else { b }
}

/// Gauss's rule with five points.
pub(super) fn gauss(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    /// Places from the middle to one end, as shares of half the range: roots of the Legendre polynomial of degree five,
    const X: [f64; 3] = [0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
    /// and their weights, which sum up to 2 over both halves.
    const W: [f64; 3] = [0.568_888_888_888_888_9, 0.478_628_670_499_366_47, 0.236_926_885_056_189_08];
    let (m, r) = (0.5 * (a + b), 0.5 * (b - a));
    r * (W[0] * f(m) + (1..3).map(|k| W[k] * (f(m - r * X[k]) + f(m + r * X[k]))).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn all() -> Vec<(Curve, [f64; 2])> {
        let f = Frame::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 1.0, 0.5), Some(DVec3::X));
        let points = [DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0), DVec3::new(3.0, -1.0, 1.0), DVec3::new(4.0, 0.0, 2.0)];
        vec![
            (Curve::segment(DVec3::X, DVec3::new(3.0, 1.0, 1.0)), [-1.0, 2.0]),
            (Curve::circle(f, 2.0), [0.0, TAU]),
            (Curve::Ellipse { frame: f, a: 3.0, b: 1.0 }, [0.3, 5.0]),
            (Curve::Parabola { frame: f, focal: 0.5 }, [-2.0, 1.0]),
            (Curve::Hyperbola { frame: f, a: 1.0, b: 2.0 }, [-1.0, 1.5]),
            (Curve::Nurbs(NurbsCurve::bezier(&points, Some(&[1.0, 2.0, 0.5, 1.0])).unwrap()), [0.0, 1.0]),
            (Curve::Nurbs(NurbsCurve::cubic(&points, super::super::nurbs::SplineEnds::Natural).unwrap()), [0.0, 5.0]),
        ]
    }

    #[test]
    fn lengths_of_conics_are_right() {
        let c = Curve::circle(Frame::WORLD, 2.0);
        assert_abs_diff_eq!(c.length([0.0, TAU]), 2.0 * TAU, epsilon = 1e-9);
        let e = Curve::Ellipse { frame: Frame::WORLD, a: 2.0, b: 1.0 };
        // 4 a E(e) with E the complete elliptic integral of the second kind.
        assert_abs_diff_eq!(e.length([0.0, TAU]), 9.688_448_220_547_675, epsilon = 1e-4);
        let p = Curve::Parabola { frame: Frame::WORLD, focal: 1.0 };
        let exact = 2f64.sqrt() + 1f64.asinh();
        assert_abs_diff_eq!(p.length([0.0, 1.0]), exact, epsilon = 1e-9);
        assert_abs_diff_eq!(p.curvature(0.0), 0.5, epsilon = 1e-15);
    }

    proptest! {
        #[test]
        fn derivatives_projection_and_motion_hold_on_every_kind(k in 0usize..7, s in 0.01f64..0.99, off in -0.05f64..0.05) {
            let (c, [a, b]) = all().swap_remove(k);
            let t = a + s * (b - a);
            let e = 1e-5 * (b - a);
            let [p, d, dd] = c.jet(t);
            let (lo, hi) = (c.jet(t - e), c.jet(t + e));
            prop_assert!(((hi[0] - lo[0]) / (2.0 * e)).distance(d) < 1e-5 * (1.0 + d.length()));
            prop_assert!(((hi[1] - lo[1]) / (2.0 * e)).distance(dd) < 1e-3 * (1.0 + dd.length()));
            // A point beside the curve comes back to where it left.
            let side = d.any_orthogonal_vector().normalize() * off;
            let back = c.project(p + side, [a, b], None);
            let found = c.at(back).distance(p + side);
            prop_assert!(found <= off.abs() + 1e-9, "{found} {off}");
            let near = c.project(p + side, [a, b], Some(t));
            prop_assert!((c.at(near) - p - side).dot(c.jet(near)[1]).abs() < 1e-7 * (1.0 + d.length()) || near == a || near == b);
            let m = Similarity { scale: 2.0, rotation: Frame::new(DVec3::ZERO, DVec3::ONE, None).axes, translation: DVec3::Y };
            prop_assert!(c.moved(&m).at(t).distance(m.point(p)) < 1e-12);
        }
    }
}
