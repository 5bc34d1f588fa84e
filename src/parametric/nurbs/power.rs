//! Polynomials as Bézier curves: by their powers (\[KUZ19\] 3), and through points by Lagrange (\[KUZ19\] 4). Also knots that make
//! a curve jump or bend.

use glam::DVec3;

use super::NurbsCurve;
use crate::error::{Error, Place, Result};
use crate::parametric::basis::{Knots, MAX_DEGREE};
use crate::spatial::Aabb;

/// A curve through points may miss them by this share of its size: polynomials of high degree swing too far for more.
const MISS: f64 = 1e-9;
/// Tangents that turn by more than this angle, in radians, bend.
const BEND: f64 = 1e-6;

fn wrong<T>(what: impl Into<String>) -> Result<T> {
    Err(Error::input(Place::Unknown, what.into()))
}

/// Control points over a range of the polynomial `c0 + (t - t0) (c1 + (t - t1) (c2 + ...))`.
fn nested(c: &[DVec3], nodes: &[f64], [a, b]: [f64; 2]) -> Vec<DVec3> {
    let Some((last, rest)) = c.split_last() else { return Vec::new() };
    let mut p = vec![*last];
    for (c, t) in rest.iter().zip(nodes).rev() {
        // A product with a linear factor raises the degree by one.
        let m = p.len() as f64;
        let mut next = vec![*c; p.len() + 1];
        for (i, q) in p.iter().enumerate() {
            let i_ = i as f64;
            next[i] += *q * ((m - i_) / m * (a - t));
            next[i + 1] += *q * ((i_ + 1.0) / m * (b - t));
        }
        p = next;
    }
    p
}

impl NurbsCurve {
    /// The polynomial `c[0] + c[1] t + c[2] t^2 + ...` for t over a range, as a Bézier curve over 0..=1 (\[KUZ19\] 3).
    ///
    /// Errors: fewer than two coefficients or more than 26; a range that does not ascend or numbers that are not finite.
    pub fn polynomial(coefficients: &[DVec3], range: [f64; 2]) -> Result<Self> {
        if coefficients.len() < 2 || coefficients.len() > MAX_DEGREE + 1 {
            return wrong(format!("a polynomial has from 2 to {} coefficients", MAX_DEGREE + 1));
        }
        if !(range[0] < range[1] && (range[1] - range[0]).is_finite()) {
            return wrong("the range of a polynomial must ascend and be finite");
        }
        Self::bezier(&nested(coefficients, &vec![0.0; coefficients.len()], range), None)
    }

    /// The polynomial through points at ascending parameters `t`, as a Bézier curve over 0..=1 (\[KUZ19\] 4, by Newton's
    /// divided differences).
    ///
    /// Errors: fewer than two points or more than 26; neighbors that coincide; parameters that do not ascend; a curve that
    /// swings too far to pass through its points.
    pub fn lagrange(t: &[f64], points: &[DVec3]) -> Result<Self> {
        let n = points.len();
        if !(2..=MAX_DEGREE + 1).contains(&n) {
            return wrong(format!("a polynomial passes through 2 to {} points", MAX_DEGREE + 1));
        }
        if t.len() != n || t.windows(2).any(|w| !(w[0] < w[1])) || !(t[n - 1] - t[0]).is_finite() {
            return wrong("parameters must ascend, one for each point");
        }
        if let Some(i) = points.windows(2).position(|w| w[0] == w[1]) {
            return wrong(format!("points {} and {} of the polynomial coincide", i + 1, i + 2));
        }
        let mut c = points.to_vec();
        for k in 1..n {
            for i in (k..n).rev() {
                c[i] = (c[i] - c[i - 1]) / (t[i] - t[i - k]);
            }
        }
        let made = Self::bezier(&nested(&c, t, [t[0], t[n - 1]]), None)?;
        let size = Aabb::around(points.iter().copied()).diagonal();
        let share = |x: f64| (x - t[0]) / (t[n - 1] - t[0]);
        let miss = t.iter().zip(points).map(|(t, p)| made.jet(share(*t))[0].distance(*p)).fold(0.0, f64::max);
        if !(miss <= MISS * size) {
            return wrong(format!("a polynomial of degree {} swings too far: take a spline", n - 1));
        }
        Ok(made)
    }

    /// Parameters inside the domain at which the direction jumps.
    pub fn bends(&self) -> Vec<f64> {
        let [a, b] = self.knots.domain();
        let step = 1e-9 * (b - a);
        let turns = |t: f64| {
            let [p, q] = [t - step, t + step].map(|t| self.jet(t)[1]);
            p.angle_between(q) > BEND
        };
        self.knots.loose().into_iter().filter(|t| turns(*t)).collect()
    }
}

impl Knots {
    /// How often a knot comes.
    fn times(&self, t: f64) -> usize {
        let k = self.values();
        k.partition_point(|x| *x <= t) - k.partition_point(|x| *x < t)
    }

    /// Knots inside the domain at which derivatives may jump: those that come as often as the degree says, or more often.
    pub fn loose(&self) -> Vec<f64> {
        let [a, b] = self.domain();
        self.breaks().into_iter().filter(|t| *t > a && *t < b && self.times(*t) >= self.degree()).collect()
    }

    /// Refuses knots at which a curve falls apart: inside the domain more than `degree` times, at its ends once more.
    pub fn whole(self) -> Result<Self> {
        let [a, b] = self.domain();
        let most = |t: f64| self.degree() + usize::from(t <= a || t >= b);
        match self.values().iter().find(|t| self.times(**t) > most(**t)) {
            Some(t) => wrong(format!(
                "the knot {t} comes {} times, more than a spline of degree {} holds together at",
                self.times(*t),
                self.degree()
            )),
            None => Ok(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn polynomials_are_their_powers_and_pass_through_their_points(raw in proptest::collection::vec([-2.0f64..2.0, -2.0f64..2.0, -2.0f64..2.0], 2..8), a in -2.0f64..1.0, s in 0.0f64..1.0) {
            let c: Vec<DVec3> = raw.iter().map(|p| DVec3::from_array(*p)).collect();
            let b = a + 1.5;
            let t = a + s * (b - a);
            let truth = c.iter().rev().fold(DVec3::ZERO, |sum, c| sum * t + *c);
            let made = NurbsCurve::polynomial(&c, [a, b]).unwrap();
            prop_assert!(made.jet(s)[0].distance(truth) < 1e-9);
            let nodes: Vec<f64> = (0..c.len()).map(|i| a + 1.5 * (i as f64 / (c.len() - 1) as f64)).collect();
            let points: Vec<DVec3> =
                nodes.iter().map(|t| c.iter().rev().fold(DVec3::ZERO, |sum, c| sum * *t + *c)).collect();
            let again = NurbsCurve::lagrange(&nodes, &points).unwrap();
            prop_assert!(again.jet(s)[0].distance(truth) < 1e-8);
        }
    }

    #[test]
    fn curves_that_fall_apart_or_swing_are_refused() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert!(Knots::new(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0], 4).unwrap().whole().is_err());
        let line = NurbsCurve::polyline(&p).unwrap();
        assert!(line.knots.clone().whole().is_ok());
        assert_eq!(line.bends(), [1.0, 2.0]);
        assert!(NurbsCurve::lagrange(&[0.0, 1.0], &[DVec3::X; 2]).is_err());
        assert!(NurbsCurve::lagrange(&[0.0, 0.0], &[DVec3::X, DVec3::Y]).is_err());
        assert!(NurbsCurve::polynomial(&p[..1], [0.0, 1.0]).is_err());
        assert!(NurbsCurve::polynomial(&p, [1.0, 1.0]).is_err());
    }
}
