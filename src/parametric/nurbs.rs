//! NURBS curves (\[KUZ19\] 13-18) and surfaces (48, 49, 55, 59; derivatives 50-54), and the splines that are special cases of
//! them: Bézier curves (5, 21, 22), polylines (6), cubic splines (7-12, as NURBS 23-27).

use glam::{DVec3, DVec4};

use super::basis::{ANY, Knots};
use crate::error::{Error, Place, Result};
use crate::numeric::SEVEN_DIGITS;
use crate::spatial::Aabb;

mod edit;
mod net;
mod power;
mod refine;
mod round;
pub use edit::{CurveEdit, Pass, edited};
pub use refine::{EndSlopes, compatible};

/// A rational B-spline curve.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsCurve {
    /// Degree and knots.
    pub knots: Knots,
    /// Control points times weight, and the weight.
    points: Vec<DVec4>,
    rational: bool,
    closed: bool,
}

/// Homogeneous control points; all weights are 1 where none are given.
fn homogeneous(points: &[DVec3], weights: Option<&[f64]>) -> Result<(Vec<DVec4>, bool)> {
    if !points.iter().all(|p| p.is_finite()) {
        return Err(Error::input(Place::Unknown, "control points that are not finite"));
    }
    let Some(weights) = weights else { return Ok((points.iter().map(|p| p.extend(1.0)).collect(), false)) };
    if weights.len() != points.len() || !weights.iter().all(|w| *w > 0.0 && w.is_finite()) {
        return Err(Error::input(Place::Unknown, "weights must be positive, one for each control point"));
    }
    let rational = weights.iter().any(|w| *w != weights[0]);
    Ok((points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w)).collect(), rational))
}

/// Value and derivatives of a quotient a / w from those of a and w.
fn quotient(h: [DVec4; 3]) -> [DVec3; 3] {
    let w = h[0].w;
    let c = h[0].truncate() / w;
    let d = (h[1].truncate() - c * h[1].w) / w;
    let e = (h[2].truncate() - 2.0 * h[1].w * d - h[2].w * c) / w;
    [c, d, e]
}

impl NurbsCurve {
    /// A curve from its control points, and weights where it is rational. Errors: see [`Knots::new`]; weights that are not
    /// positive.
    pub fn new(degree: usize, knots: Vec<f64>, points: &[DVec3], weights: Option<&[f64]>) -> Result<Self> {
        let knots = Knots::new(degree, knots, points.len())?;
        let size = Aabb::around(points.iter().copied()).diagonal();
        let (points, rational) = homogeneous(points, weights)?;
        let mut this = Self { knots, points, rational, closed: false };
        let [a, b] = this.knots.domain();
        // Ends of a curve this near to each other are one point.
        this.closed = this.jet(a)[0].distance(this.jet(b)[0]) <= SEVEN_DIGITS * size;
        Ok(this)
    }

    /// Whether the curve ends where it starts. It then goes on beyond its domain, round after round.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// A (rational) Bézier curve over 0..=1 (\[KUZ19\] 5, 21, 22).
    pub fn bezier(points: &[DVec3], weights: Option<&[f64]>) -> Result<Self> {
        let degree = points.len().saturating_sub(1);
        let ends = |v: f64| std::iter::repeat_n(v, degree + 1);
        Self::new(degree, ends(0.0).chain(ends(1.0)).collect(), points, weights)
    }

    /// Straight pieces through the points, piece `i` over `i..=i + 1` (\[KUZ19\] 6).
    pub fn polyline(points: &[DVec3]) -> Result<Self> {
        let n = points.len().max(1) - 1;
        let knots = [0.0].into_iter().chain((0..=n).map(|i| i as f64)).chain([n as f64]).collect();
        Self::new(1, knots, points, None)
    }

    /// A cubic Hermite spline through `points` with the given derivatives at the parameters `t`.
    pub fn hermite(t: &[f64], points: &[DVec3], derivatives: &[DVec3]) -> Result<Self> {
        let n = points.len();
        if n < 2 || t.len() != n || derivatives.len() != n || t.windows(2).any(|w| !(w[0] < w[1])) {
            return Err(Error::input(Place::Unknown, "a spline needs two points at ascending parameters"));
        }
        let mut control = vec![points[0]];
        let mut knots = vec![t[0]; 4];
        for i in 0..n - 1 {
            let third = (t[i + 1] - t[i]) / 3.0;
            control.extend([
                points[i] + derivatives[i] * third,
                points[i + 1] - derivatives[i + 1] * third,
                points[i + 1],
            ]);
            knots.extend([t[i + 1]; 3]);
        }
        knots.push(t[n - 1]);
        Self::new(3, knots, &control, None)
    }

    /// A cubic spline with continuous curvature through the points (\[KUZ19\] 7-12), parametrized by chord length. It is found
    /// by its first derivatives, where the thesis takes second ones: in (11) their term is positive, and in (12) the factor
    /// belongs to both.
    pub fn cubic(points: &[DVec3], ends: SplineEnds) -> Result<Self> {
        let mut points = points.to_vec();
        if matches!(ends, SplineEnds::Closed) && points.first() != points.last() {
            points.push(points[0]);
        }
        let n = points.len();
        if n < 2 {
            return Err(Error::input(Place::Unknown, "a spline needs two points"));
        }
        let mut t = vec![0.0];
        for w in points.windows(2) {
            t.push(t[t.len() - 1] + w[0].distance(w[1]));
        }
        let m = slopes(&t, &points, ends)?;
        Self::hermite(&t, &points, &m)
    }

    /// Control points, without weights.
    pub fn control(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.points.iter().map(|p| p.truncate() / p.w)
    }

    /// Whether weights differ.
    pub fn is_rational(&self) -> bool {
        self.rational
    }

    /// Point, first and second derivative. Outside its domain an open curve ends.
    pub fn jet(&self, t: f64) -> [DVec3; 3] {
        let [a, b] = self.knots.domain();
        let t = if self.closed && !(a..=b).contains(&t) { a + (t - a).rem_euclid(b - a) } else { t };
        match self.knots.degree() {
            0..=3 => self.jet_by::<4>(t),
            4..=8 => self.jet_by::<9>(t),
            _ => self.jet_by::<ANY>(t),
        }
    }

    fn jet_by<const N: usize>(&self, t: f64) -> [DVec3; 3] {
        let (span, rows) = self.knots.basis::<N>(t);
        let p = self.knots.degree();
        let mut h = [DVec4::ZERO; 3];
        for (r, point) in self.points[span - p..=span].iter().enumerate() {
            for k in 0..3 {
                h[k] += rows[k][r] * *point;
            }
        }
        if self.rational { quotient(h) } else { h.map(|v| v.truncate() / h[0].w) }
    }

    /// The curve with every control point replaced.
    pub fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|p| (f(p.truncate() / p.w) * p.w).extend(p.w)).collect();
        Self { points, ..self.clone() }
    }
}

/// What a cubic spline does at its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SplineEnds {
    /// No curvature at the ends.
    Natural,
    /// These derivatives by chord length at the ends.
    Clamped(DVec3, DVec3),
    /// The second derivative is the same all over the first piece, and all over the last: they are parabolas.
    Parabolic,
    /// The end goes on as the start.
    Closed,
}

/// Derivatives at the points of a cubic spline with continuous second derivatives.
fn slopes(t: &[f64], p: &[DVec3], ends: SplineEnds) -> Result<Vec<DVec3>> {
    let n = p.len();
    let h: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    if h.iter().any(|h| !(*h > 0.0)) {
        return Err(Error::input(Place::Unknown, "two neighboring points of a spline coincide"));
    }
    let chord = |i: usize| (p[i + 1] - p[i]) / h[i];
    // Rows of h_i m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_{i-1} m_{i+1} = 3 (h_i d_{i-1} + h_{i-1} d_i).
    let (mut below, mut mid, mut above, mut right) = (vec![0.0; n], vec![1.0; n], vec![0.0; n], vec![DVec3::ZERO; n]);
    let mut fill = |i: usize, before: usize, after: usize| {
        below[i] = h[after];
        mid[i] = 2.0 * (h[before] + h[after]);
        above[i] = h[before];
        right[i] = 3.0 * (h[after] * chord(before) + h[before] * chord(after));
    };
    (1..n - 1).for_each(|i| fill(i, i - 1, i));
    match ends {
        SplineEnds::Closed => {
            if n < 4 {
                return Err(Error::input(Place::Unknown, "a closed spline needs three points"));
            }
            fill(0, n - 2, 0);
            return Ok(cyclic(&below[..n - 1], &mid[..n - 1], &above[..n - 1], &right[..n - 1]));
        }
        // Between two points that is a straight line, as natural ends make it.
        SplineEnds::Parabolic if n > 2 => {
            (above[0], right[0]) = (1.0, 2.0 * chord(0));
            (below[n - 1], right[n - 1]) = (1.0, 2.0 * chord(n - 2));
        }
        SplineEnds::Natural | SplineEnds::Parabolic => {
            (mid[0], above[0], right[0]) = (2.0, 1.0, 3.0 * chord(0));
            (below[n - 1], mid[n - 1], right[n - 1]) = (1.0, 2.0, 3.0 * chord(n - 2));
        }
        SplineEnds::Clamped(a, b) => (right[0], right[n - 1]) = (a, b),
    }
    Ok(tridiagonal(&below, &mid, &above, &right))
}

fn tridiagonal(below: &[f64], mid: &[f64], above: &[f64], right: &[DVec3]) -> Vec<DVec3> {
    let n = mid.len();
    let (mut c, mut x) = (vec![0.0; n], right.to_vec());
    c[0] = above[0] / mid[0];
    x[0] /= mid[0];
    for i in 1..n {
        let m = mid[i] - below[i] * c[i - 1];
        c[i] = above[i] / m;
        x[i] = (x[i] - below[i] * x[i - 1]) / m;
    }
    for i in (0..n - 1).rev() {
        let next = x[i + 1];
        x[i] -= c[i] * next;
    }
    x
}

/// The same with a wrap-around, by the formula of Sherman and Morrison; the first value is repeated at the end.
fn cyclic(below: &[f64], mid: &[f64], above: &[f64], right: &[DVec3]) -> Vec<DVec3> {
    let n = mid.len();
    let gamma = -mid[0];
    let mut m = mid.to_vec();
    m[0] -= gamma;
    m[n - 1] -= above[n - 1] * below[0] / gamma;
    let x = tridiagonal(below, &m, above, right);
    let mut u = vec![DVec3::ZERO; n];
    u[0].x = gamma;
    u[n - 1].x = above[n - 1];
    let z = tridiagonal(below, &m, above, &u);
    let share = below[0] / gamma;
    let f = (x[0] + share * x[n - 1]) / (1.0 + z[0].x + share * z[n - 1].x);
    let mut out: Vec<DVec3> = x.iter().zip(&z).map(|(x, z)| *x - z.x * f).collect();
    out.push(out[0]);
    out
}

/// A rational B-spline surface.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsSurface {
    /// Degree and knots in u.
    pub u: Knots,
    /// Degree and knots in v.
    pub v: Knots,
    /// Homogeneous control points, those of one u after another.
    points: Vec<DVec4>,
    rational: bool,
}

impl NurbsSurface {
    /// A surface from its control points, `points[i * nv + j]` for knots `i` of u and `j` of v. Errors: see
    /// [`NurbsCurve::new`].
    pub fn new(u: Knots, v: Knots, points: &[DVec3], weights: Option<&[f64]>) -> Result<Self> {
        if points.len() != u.points() * v.points() {
            return Err(Error::input(Place::Unknown, "the control points do not fill the net"));
        }
        let (points, rational) = homogeneous(points, weights)?;
        Ok(Self { u, v, points, rational })
    }

    /// Control point `i`, `j`, without weight.
    pub fn control(&self, i: usize, j: usize) -> DVec3 {
        let p = self.points[i * self.v.points() + j];
        p.truncate() / p.w
    }

    /// Point and derivatives: S, Su, Sv, Suu, Suv, Svv. Outside its domain the surface ends.
    pub fn jet(&self, u: f64, v: f64) -> [DVec3; 6] {
        match self.u.degree().max(self.v.degree()) {
            0..=3 => self.jet_by::<4>(u, v),
            4..=8 => self.jet_by::<9>(u, v),
            _ => self.jet_by::<ANY>(u, v),
        }
    }

    /// The point alone: what [`jet`](Self::jet) says first.
    pub fn at(&self, u: f64, v: f64) -> DVec3 {
        match self.u.degree().max(self.v.degree()) {
            0..=3 => self.at_by::<4>(u, v),
            4..=8 => self.at_by::<9>(u, v),
            _ => self.at_by::<ANY>(u, v),
        }
    }

    fn at_by<const N: usize>(&self, u: f64, v: f64) -> DVec3 {
        let ((su, a), (sv, b)) = (self.u.values_at::<N>(u), self.v.values_at::<N>(v));
        let (p, q, nv) = (self.u.degree(), self.v.degree(), self.v.points());
        let mut h = DVec4::ZERO;
        for r in 0..=p {
            let row = &self.points[(su - p + r) * nv + sv - q..][..=q];
            h += a[r] * row.iter().zip(&b).map(|(point, b)| *b * *point).sum::<DVec4>();
        }
        h.truncate() / h.w
    }

    fn jet_by<const N: usize>(&self, u: f64, v: f64) -> [DVec3; 6] {
        let ((su, a), (sv, b)) = (self.u.basis::<N>(u), self.v.basis::<N>(v));
        let (p, q, nv) = (self.u.degree(), self.v.degree(), self.v.points());
        let mut h = [DVec4::ZERO; 6];
        for r in 0..=p {
            let row = &self.points[(su - p + r) * nv + sv - q..][..=q];
            let mut s = [DVec4::ZERO; 3];
            for (c, point) in row.iter().enumerate() {
                for k in 0..3 {
                    s[k] += b[k][c] * *point;
                }
            }
            h[0] += a[0][r] * s[0];
            h[1] += a[1][r] * s[0];
            h[2] += a[0][r] * s[1];
            h[3] += a[2][r] * s[0];
            h[4] += a[1][r] * s[1];
            h[5] += a[0][r] * s[2];
        }
        if !self.rational {
            return h.map(|x| x.truncate() / h[0].w);
        }
        let [s, su, suu] = quotient([h[0], h[1], h[3]]);
        let [_, sv, svv] = quotient([h[0], h[2], h[5]]);
        let suv = (h[4].truncate() - h[1].w * sv - h[2].w * su - h[4].w * s) / h[0].w;
        [s, su, sv, suu, suv, svv]
    }

    /// The surface with every control point replaced.
    pub fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|p| (f(p.truncate() / p.w) * p.w).extend(p.w)).collect();
        Self { points, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    fn points(raw: &[[f64; 3]]) -> Vec<DVec3> {
        raw.iter().map(|p| DVec3::from_array(*p)).collect()
    }

    /// A quarter of the unit circle.
    fn quarter() -> NurbsCurve {
        let w = [1.0, 0.5f64.sqrt(), 1.0];
        NurbsCurve::bezier(&[DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y], Some(&w)).unwrap()
    }

    #[test]
    fn a_rational_quadratic_is_a_circle_with_its_curvature() {
        let c = quarter();
        for i in 0..=10 {
            let [p, d, e] = c.jet(f64::from(i) / 10.0);
            assert_abs_diff_eq!(p.length(), 1.0, epsilon = 1e-14);
            assert_abs_diff_eq!(p.dot(d), 0.0, epsilon = 1e-14);
            assert_relative_eq!(d.cross(e).length(), d.length().powi(3), epsilon = 0.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn the_tensor_of_two_quarters_is_an_eighth_of_a_sphere() {
        let c: Vec<DVec3> = quarter().control().collect();
        let w = [1.0, 0.5f64.sqrt(), 1.0];
        let (mut net, mut weights) = (Vec::new(), Vec::new());
        for i in 0..3 {
            for j in 0..3 {
                net.push(DVec3::new(c[i].x * c[j].x, c[i].y * c[j].x, c[j].y));
                weights.push(w[i] * w[j]);
            }
        }
        let k = || Knots::uniform(2, 3).unwrap();
        let s = NurbsSurface::new(k(), k(), &net, Some(&weights)).unwrap();
        for i in 0..10 {
            for j in 0..10 {
                let (u, v) = (0.1 * f64::from(i) + 0.02, 0.1 * f64::from(j) + 0.02);
                let [p, su, sv, ..] = s.jet(u, v);
                assert_abs_diff_eq!(p.length(), 1.0, epsilon = 1e-14);
                assert_abs_diff_eq!(p.dot(su), 0.0, epsilon = 1e-13);
                assert_abs_diff_eq!(p.dot(sv), 0.0, epsilon = 1e-13);
            }
        }
    }

    #[test]
    fn cubic_splines_reproduce_cubics_and_are_smooth() {
        let raw = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [4.0, -1.0, 0.0], [6.0, 1.0, 0.0], [7.0, 0.0, 0.0]];
        for ends in
            [SplineEnds::Natural, SplineEnds::Clamped(DVec3::X, DVec3::Y), SplineEnds::Closed, SplineEnds::Parabolic]
        {
            let c = NurbsCurve::cubic(&points(&raw), ends).unwrap();
            let breaks = c.knots.breaks();
            for (t, p) in breaks.iter().zip(points(&raw)) {
                assert!(c.jet(*t)[0].distance(p) < 1e-13);
            }
            let e = 1e-9;
            for t in &breaks[1..breaks.len() - 1] {
                let (a, b) = (c.jet(t - e), c.jet(t + e));
                assert!(a[1].distance(b[1]) < 1e-7 && a[2].distance(b[2]) < 1e-6);
            }
            let (a, b) = (c.jet(breaks[0]), c.jet(breaks[breaks.len() - 1]));
            match ends {
                SplineEnds::Natural => assert!(a[2].length() + b[2].length() < 1e-12),
                SplineEnds::Clamped(x, y) => assert!(a[1].distance(x) + b[1].distance(y) < 1e-12),
                SplineEnds::Parabolic => {
                    let [p, q] = [breaks[0] + e, breaks[1] - e].map(|t| c.jet(t)[2]);
                    assert!(p.distance(q) < 1e-6);
                }
                SplineEnds::Closed => assert!(a[1].distance(b[1]) + a[2].distance(b[2]) < 1e-11),
            }
        }
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        assert!(NurbsCurve::bezier(&[DVec3::X], None).is_err());
        assert!(NurbsCurve::bezier(&[DVec3::X, DVec3::NAN], None).is_err());
        assert!(NurbsCurve::bezier(&[DVec3::X, DVec3::Y], Some(&[1.0, 0.0])).is_err());
        assert!(NurbsCurve::polyline(&[]).is_err());
        assert!(NurbsCurve::cubic(&[DVec3::X, DVec3::X], SplineEnds::Natural).is_err());
    }

    proptest! {
        #[test]
        fn derivatives_of_surfaces_agree_with_differences(
            net in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 20),
            weights in prop::collection::vec(0.3f64..2.0, 20), u in 0.05f64..0.45, v in 0.05f64..0.95,
        ) {
            let (ku, kv) = (Knots::uniform(3, 5).unwrap(), Knots::uniform(3, 4).unwrap());
            let s = NurbsSurface::new(ku, kv, &points(&net), Some(&weights)).unwrap();
            let e = 1e-5;
            let [_, su, sv, suu, suv, svv] = s.jet(u, v);
            let du = (s.jet(u + e, v)[0] - s.jet(u - e, v)[0]) / (2.0 * e);
            let dv = (s.jet(u, v + e)[0] - s.jet(u, v - e)[0]) / (2.0 * e);
            prop_assert!(du.distance(su) < 1e-5 && dv.distance(sv) < 1e-5);
            let duu = (s.jet(u + e, v)[1] - s.jet(u - e, v)[1]) / (2.0 * e);
            let duv = (s.jet(u, v + e)[1] - s.jet(u, v - e)[1]) / (2.0 * e);
            let dvv = (s.jet(u, v + e)[2] - s.jet(u, v - e)[2]) / (2.0 * e);
            prop_assert!(duu.distance(suu) < 1e-3 && duv.distance(suv) < 1e-3 && dvv.distance(svv) < 1e-3);
        }
    }
}
