//! NURBS written in other ways: more knots, higher degrees, parts and joints of the same curve, conics as NURBS, and surfaces
//! through sections. All by polar forms, which give control points for any knots (L. Piegl, W. Tiller, "The NURBS Book", 5;
//! L. Ramshaw, "Blossoms are polar forms").

use std::f64::consts::PI;

use glam::{DVec2, DVec3, DVec4};

use super::{NurbsCurve, NurbsSurface, SplineEnds, slopes};
use crate::error::{Error, Place, Result};
use crate::numeric::ROUNDING;
use crate::parametric::basis::Knots;
use crate::parametric::curve::Curve;

fn wrong<T>(what: impl Into<String>) -> Result<T> {
    Err(Error::input(Place::Unknown, what.into()))
}

impl NurbsCurve {
    /// Control points times weight, and the weight.
    pub fn weighted(&self) -> &[DVec4] {
        &self.points
    }

    /// A curve from control points that carry their weights. Errors: see [`NurbsCurve::new`].
    pub fn from_weighted(degree: usize, knots: Vec<f64>, points: &[DVec4]) -> Result<Self> {
        let weights: Vec<f64> = points.iter().map(|p| p.w).collect();
        let places: Vec<DVec3> = points.iter().map(|p| p.truncate() / p.w).collect();
        Self::new(degree, knots, &places, Some(&weights))
    }

    /// A cubic spline with continuous curvature through points at the parameters `t`, as a B-spline with single knots
    /// (\[KUZ19\] 23-27).
    pub fn interpolated(t: &[f64], points: &[DVec3], ends: SplineEnds) -> Result<Self> {
        let n = points.len();
        if n < 2 || t.len() != n || t.windows(2).any(|w| !(w[0] < w[1])) {
            return wrong("a spline needs two points at ascending parameters");
        }
        let m = slopes(t, points, ends)?;
        let wide = |p: &[DVec3], w: f64| -> Vec<DVec4> { p.iter().map(|p| p.extend(w)).collect() };
        Self::from_weighted(3, cubic_knots(t), &cubic_controls(t, &wide(points, 1.0), &wide(&m, 0.0)))
    }

    /// The polar form of the piece in a span of knots: at `degree` equal arguments it is the curve.
    fn polar(&self, span: usize, args: &[f64]) -> DVec4 {
        let (p, k) = (self.knots.degree(), self.knots.values());
        let mut d = self.points[span - p..=span].to_vec();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let i = span - p + j;
                let (lo, hi) = (k[i], k[i + p - r + 1]);
                let a = (args[r - 1] - lo) / (hi - lo);
                d[j] = d[j - 1] * (1.0 - a) + d[j] * a;
            }
        }
        d[p]
    }

    /// The same curve on knots that hold its own, at a degree at most one higher.
    fn rewritten(&self, degree: usize, knots: Vec<f64>) -> Result<Self> {
        let n = knots.len().saturating_sub(degree + 1);
        let mut points = Vec::with_capacity(n);
        for i in 0..n {
            let inside = (i.max(degree)..=(i + degree).min(n - 1)).find(|&j| knots[j] < knots[j + 1]);
            let Some(j) = inside else { return wrong("a spline with an empty domain") };
            let span = self.knots.span(0.5 * (knots[j] + knots[j + 1]));
            let args = &knots[i + 1..=i + degree];
            points.push(if degree == self.knots.degree() {
                self.polar(span, args)
            } else {
                let without = |k: usize| [&args[..k], &args[k + 1..]].concat();
                (0..degree).map(|k| self.polar(span, &without(k))).sum::<DVec4>() / degree as f64
            });
        }
        Self::from_weighted(degree, knots, &points)
    }

    /// The same curve with polynomials of a degree one higher.
    pub fn elevated(&self) -> Result<Self> {
        let [a, b] = self.knots.domain();
        let clamped = self.part([a, b])?;
        let old = clamped.knots.values();
        let mut knots = Vec::with_capacity(2 * old.len());
        for (i, k) in old.iter().enumerate() {
            if i == 0 || old[i - 1] < *k {
                knots.push(*k);
            }
            knots.push(*k);
        }
        clamped.rewritten(self.knots.degree() + 1, knots)
    }

    /// The part over a range, as a curve of its own with ends that are control points; the parameter stays. On a closed
    /// curve the range may go on into the next round.
    pub fn part(&self, [a, b]: [f64; 2]) -> Result<Self> {
        let [lo, hi] = self.knots.domain();
        if !(a < b) {
            return wrong("an empty part of a curve");
        }
        if self.closed {
            let round = hi - lo;
            let back = ((a - lo) / round).floor() * round;
            if back != 0.0 {
                let [x, y] = [a - back, b - back];
                return self.part([x, y])?.over([a, b]);
            }
            if b > hi {
                let first = self.part([a, hi])?;
                return first.joined(&self.part([lo, b - round])?);
            }
        }
        let (a, b) = (a.max(lo), b.min(hi));
        let p = self.knots.degree();
        let ends = |v: f64| std::iter::repeat_n(v, p + 1);
        let inner = self.knots.values().iter().copied().filter(|k| *k > a && *k < b);
        self.rewritten(p, ends(a).chain(inner).chain(ends(b)).collect())
    }

    /// Both parts of the curve at a parameter inside its domain.
    pub fn split(&self, t: f64) -> Result<[Self; 2]> {
        let [a, b] = self.knots.domain();
        Ok([self.part([a, t])?, self.part([t, b])?])
    }

    /// The curve with its parameter stretched to another range.
    pub fn over(&self, [a, b]: [f64; 2]) -> Result<Self> {
        let [lo, hi] = self.knots.domain();
        let to = |k: f64| {
            if k == lo {
                a
            } else if k == hi {
                b
            } else {
                a + (b - a) * (k - lo) / (hi - lo)
            }
        };
        let knots = self.knots.values().iter().map(|k| to(*k)).collect();
        Self::from_weighted(self.knots.degree(), knots, &self.points)
    }

    /// The curve the other way round, over the same domain.
    pub fn reversed(&self) -> Result<Self> {
        let [a, b] = self.knots.domain();
        let knots = self.knots.values().iter().rev().map(|k| a + b - k).collect();
        let points: Vec<DVec4> = self.points.iter().rev().copied().collect();
        Self::from_weighted(self.knots.degree(), knots, &points)
    }

    /// This curve and, from its end on, another of the same degree; both must start and end in control points.
    fn joined(&self, next: &Self) -> Result<Self> {
        let p = self.knots.degree();
        let (k, l) = (self.knots.values(), next.knots.values());
        let (end, start) = (self.knots.domain()[1], next.knots.domain()[0]);
        let scale = self.points[self.points.len() - 1].w / next.points[0].w;
        let knots = k[..k.len() - 1].iter().copied().chain(l[p + 1..].iter().map(|x| x - start + end)).collect();
        let points: Vec<DVec4> =
            self.points.iter().copied().chain(next.points[1..].iter().map(|q| *q * scale)).collect();
        Self::from_weighted(p, knots, &points)
    }
}

impl Curve {
    /// A part of the curve as NURBS over 0..=1. Lines, parabolas and splines keep their parameter but for its range;
    /// ellipses and hyperbolas become rational quadratics, with the same points at other parameters.
    pub fn to_nurbs(&self, range: [f64; 2]) -> Result<NurbsCurve> {
        let [a, b] = range;
        match self {
            Curve::Line { .. } => NurbsCurve::bezier(&[self.at(a), self.at(b)], None),
            Curve::Parabola { frame, focal } => {
                let m = frame.point(DVec3::new(focal * a * b, focal * (a + b), 0.0));
                NurbsCurve::bezier(&[self.at(a), m, self.at(b)], None)
            }
            Curve::Hyperbola { frame, a: r, b: q } => {
                let (m, h) = (0.5 * (a + b), 0.5 * (b - a));
                let w = h.cosh();
                let middle = frame.point(DVec3::new(r * m.cosh() / w, q * m.sinh() / w, 0.0));
                NurbsCurve::bezier(&[self.at(a), middle, self.at(b)], Some(&[1.0, w, 1.0]))
            }
            Curve::Ellipse { frame, a: r, b: q } => {
                let parts = ((b - a) / (0.5 * PI) - 1e-9).ceil().max(1.0);
                let step = (b - a) / parts;
                let w = (0.5 * step).cos();
                let at = |t: f64, s: f64| {
                    let p = DVec2::new(r * t.cos(), q * t.sin()) / s;
                    frame.point(p.extend(0.0))
                };
                let count = parts as usize;
                let (mut points, mut weights, mut knots) = (vec![at(a, 1.0)], vec![1.0], vec![0.0; 3]);
                for k in 0..count {
                    let t = a + step * k as f64;
                    points.extend([at(t + 0.5 * step, w), at(t + step, 1.0)]);
                    weights.extend([w, 1.0]);
                    knots.extend([(k + 1) as f64 / parts; 2]);
                }
                knots.push(1.0);
                NurbsCurve::new(2, knots, &points, Some(&weights))
            }
            Curve::Nurbs(n) => n.part(range)?.over([0.0, 1.0]),
        }
    }
}

/// The curves, each over the same domain 0..=1, with one degree and the same knots.
pub fn compatible(curves: &[NurbsCurve]) -> Result<Vec<NurbsCurve>> {
    let degree = curves.iter().map(|c| c.knots.degree()).max().unwrap_or(1);
    let mut all = Vec::with_capacity(curves.len());
    for c in curves {
        let mut c = c.part(c.knots.domain())?.over([0.0, 1.0])?;
        while c.knots.degree() < degree {
            c = c.elevated()?;
        }
        all.push(c);
    }
    // Each knot as often as it comes in the curve that has it most often.
    let mut knots: Vec<(f64, usize)> = Vec::new();
    for c in &all {
        for k in c.knots.breaks() {
            // Knots this near to each other are one.
            if !knots.iter().any(|x| (x.0 - k).abs() <= ROUNDING) {
                knots.push((k, 0));
            }
        }
    }
    knots.sort_by(|a, b| a.0.total_cmp(&b.0));
    for c in &mut all {
        let snapped: Vec<f64> = c
            .knots
            .values()
            .iter()
            .map(|v| knots.iter().map(|k| k.0).min_by(|a, b| (a - v).abs().total_cmp(&(b - v).abs())).unwrap_or(*v))
            .collect();
        for k in &mut knots {
            k.1 = k.1.max(snapped.iter().filter(|v| **v == k.0).count());
        }
        *c = NurbsCurve::from_weighted(degree, snapped, &c.points)?;
    }
    let common: Vec<f64> = knots.iter().flat_map(|k| std::iter::repeat_n(k.0, k.1)).collect();
    all.iter()
        .map(|c| if c.knots.values() == common { Ok(c.clone()) } else { c.rewritten(degree, common.clone()) })
        .collect()
}

fn cubic_knots(t: &[f64]) -> Vec<f64> {
    let n = t.len();
    let ends = |v: f64| std::iter::repeat_n(v, 3);
    ends(t[0]).chain(t.iter().copied()).chain(ends(t[n - 1])).collect()
}

/// Control points on single knots from values and derivatives of a cubic spline with continuous second derivatives.
fn cubic_controls(t: &[f64], p: &[DVec4], m: &[DVec4]) -> Vec<DVec4> {
    let n = t.len();
    let after = |i: usize| p[i] + m[i] * ((t[i + 1] - t[i]) / 3.0);
    let before = |i: usize| p[i] - m[i] * ((t[i] - t[i - 1]) / 3.0);
    let mut out = vec![p[0], after(0)];
    for i in 1..n - 1 {
        // The polar form of the piece before knot i at (t[i - 1], t[i], t[i + 1]).
        let (a, b) = (after(i - 1), before(i));
        out.push(a + (b - a) * ((t[i + 1] - t[i - 1]) / (t[i] - t[i - 1])));
    }
    out.extend([before(n - 1), p[n - 1]]);
    out
}

/// Derivatives across the sections at the two ends of a surface, one for each control point, weighted as these.
pub type EndSlopes = [Option<Vec<DVec4>>; 2];

impl NurbsSurface {
    /// Homogeneous control points, those of one u after another.
    pub fn weighted(&self) -> &[DVec4] {
        &self.points
    }

    /// Whether weights differ.
    pub fn is_rational(&self) -> bool {
        self.rational
    }

    /// A surface from control points that carry their weights. Errors: see [`NurbsSurface::new`].
    pub fn from_weighted(u: Knots, v: Knots, points: &[DVec4]) -> Result<Self> {
        let weights: Vec<f64> = points.iter().map(|p| p.w).collect();
        let places: Vec<DVec3> = points.iter().map(|p| p.truncate() / p.w).collect();
        Self::new(u, v, &places, Some(&weights))
    }

    /// A (rational) Bézier surface over the unit square from `rows` rows of control points (\[KUZ19\] 41, 42, 45): u runs along
    /// the rows' numbers, v within a row.
    pub fn bezier(points: &[DVec3], rows: usize, weights: Option<&[f64]>) -> Result<Self> {
        let columns = points.len().checked_div(rows).unwrap_or(0);
        if rows < 2 || columns < 2 || rows * columns != points.len() {
            return wrong("a Bézier surface needs two rows or more, of two control points or more each");
        }
        Self::new(Knots::uniform(rows - 1, rows)?, Knots::uniform(columns - 1, columns)?, points, weights)
    }

    /// A surface through sections: u runs along them, v across, section `j` at `v = t[j]`. Two sections are joined by
    /// straight lines, more by cubic splines in homogeneous coordinates, natural where no slope is given.
    ///
    /// Errors: fewer than two sections; ones that are not [`compatible`]; `t` that does not ascend; weights that overshoot
    /// to zero.
    pub fn through(sections: &[NurbsCurve], t: &[f64], slopes_at: &EndSlopes) -> Result<Self> {
        let n = sections.len();
        if n < 2 || t.len() != n || t.windows(2).any(|w| !(w[0] < w[1])) {
            return wrong("a surface needs two sections at ascending parameters");
        }
        if sections.iter().any(|s| s.knots != sections[0].knots) {
            return wrong("sections with different knots");
        }
        let count = sections[0].points.len();
        let straight = n == 2 && slopes_at.iter().all(Option::is_none);
        let mut points = Vec::new();
        for i in 0..count {
            let column: Vec<DVec4> = sections.iter().map(|s| s.points[i]).collect();
            if straight {
                points.extend(column);
                continue;
            }
            let m = wide_slopes(t, &column, slopes_at, i)?;
            points.extend(cubic_controls(t, &column, &m));
        }
        let v = if straight {
            Knots::new(1, vec![t[0], t[0], t[1], t[1]], 2)?
        } else {
            Knots::new(3, cubic_knots(t), n + 2)?
        };
        Self::from_weighted(sections[0].knots.clone(), v, &points)
    }

    /// The line u = const at the start (0) or the end (1) of u. Only for knots that end in control points.
    pub fn rim(&self, end: usize) -> Result<NurbsCurve> {
        let nv = self.v.points();
        let first = if end == 0 { 0 } else { self.points.len() - nv };
        NurbsCurve::from_weighted(self.v.degree(), self.v.values().to_vec(), &self.points[first..first + nv])
    }
}

/// Slopes of a spline in homogeneous coordinates with a slope given at none, one or both ends.
fn wide_slopes(t: &[f64], p: &[DVec4], given: &EndSlopes, i: usize) -> Result<Vec<DVec4>> {
    let n = p.len();
    let at = |k: usize| given[k].as_ref().map(|s| s[i]);
    let solve = |part: &dyn Fn(DVec4) -> DVec3| -> Result<Vec<DVec3>> {
        let q: Vec<DVec3> = p.iter().map(|p| part(*p)).collect();
        let clamped = |a: DVec3, b: DVec3| slopes(t, &q, SplineEnds::Clamped(a, b));
        match (at(0).map(part), at(1).map(part)) {
            (None, None) => slopes(t, &q, SplineEnds::Natural),
            (Some(a), Some(b)) => clamped(a, b),
            // Natural at one end: the second derivative there is linear in the slope, so two trials tell.
            (a, b) => {
                let free = if a.is_none() { 0 } else { n - 1 };
                let trial = |s: DVec3| clamped(a.unwrap_or(s), b.unwrap_or(s));
                let bend = |m: &[DVec3]| {
                    let (j, k) = if free == 0 { (0, 1) } else { (n - 1, n - 2) };
                    let h = t[k] - t[j];
                    (q[k] - q[j]) * (3.0 / h) - 2.0 * m[j] - m[k]
                };
                let (zero, one) = (bend(&trial(DVec3::ZERO)?), bend(&trial(DVec3::ONE)?));
                trial(zero / (zero - one))
            }
        }
    };
    let (places, weights) = (solve(&|p| p.truncate())?, solve(&|p| DVec3::new(p.w, 0.0, 0.0))?);
    Ok(places.iter().zip(&weights).map(|(p, w)| p.extend(w.x)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parametric::frame::Frame;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn wave() -> Vec<DVec3> {
        [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [4.0, -1.0, 0.0], [6.0, 1.0, 1.0], [7.0, 0.0, 0.0]]
            .map(DVec3::from_array)
            .to_vec()
    }

    fn rational() -> NurbsCurve {
        let p = wave();
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0];
        NurbsCurve::new(3, knots, &p, Some(&[1.0, 2.0, 0.5, 1.0, 1.5])).unwrap()
    }

    #[test]
    fn a_spline_on_single_knots_is_the_spline_by_its_pieces() {
        let p = wave();
        for ends in [SplineEnds::Natural, SplineEnds::Clamped(DVec3::X, DVec3::Y)] {
            let c = NurbsCurve::cubic(&p, ends).unwrap();
            let s = NurbsCurve::interpolated(&c.knots.breaks(), &p, ends).unwrap();
            assert_eq!(s.weighted().len(), p.len() + 2);
            let [a, b] = c.knots.domain();
            for k in 0..=40 {
                let t = a + (b - a) * f64::from(k) / 40.0;
                assert!((0..3).all(|d| c.jet(t)[d].distance(s.jet(t)[d]) < 1e-11));
            }
        }
    }

    #[test]
    fn conics_become_nurbs_point_by_point() {
        let frame = Frame::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), None);
        let curves = [
            (Curve::circle(frame, 2.0), [0.5, 0.5 + 2.0 * PI]),
            (Curve::Ellipse { frame, a: 1.0, b: 3.0 }, [-0.2, 1.1]),
            (Curve::Parabola { frame, focal: 0.7 }, [-1.0, 2.0]),
            (Curve::Hyperbola { frame, a: 1.0, b: 2.0 }, [-1.0, 1.5]),
            (Curve::segment(DVec3::X, DVec3::Y), [0.0, 1.0]),
        ];
        for (c, range) in curves {
            let n = Curve::Nurbs(c.to_nurbs(range).unwrap());
            assert_relative_eq!(n.length([0.0, 1.0]), c.length(range), epsilon = 0.0, max_relative = 1e-4);
            for k in 0..=30 {
                let p = n.at(f64::from(k) / 30.0);
                assert!(c.at(c.project(p, range, None)).distance(p) < 1e-12);
            }
        }
    }

    #[test]
    fn parts_of_closed_curves_go_on_into_the_next_round() {
        let c = NurbsCurve::cubic(&wave(), SplineEnds::Closed).unwrap();
        let [a, b] = c.knots.domain();
        let range = [a + 0.7 * (b - a), a + 1.4 * (b - a)];
        let part = c.part(range).unwrap();
        for k in 0..=20 {
            let t = range[0] + (range[1] - range[0]) * f64::from(k) / 20.0;
            assert!(part.jet(t)[0].distance(c.jet(t)[0]) < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn rewriting_changes_no_point(a in 0.0f64..0.45, b in 0.55f64..1.0, s in 0.0f64..1.0) {
            let c = rational();
            let t = a + s * (b - a);
            let part = c.part([a, b]).unwrap();
            prop_assert!(part.jet(t)[0].distance(c.jet(t)[0]) < 1e-12);
            prop_assert!(c.elevated().unwrap().jet(t)[0].distance(c.jet(t)[0]) < 1e-12);
            prop_assert!(c.reversed().unwrap().jet(1.0 - t)[0].distance(c.jet(t)[0]) < 1e-12);
            let [first, second] = c.split(t.clamp(0.01, 0.99)).unwrap();
            prop_assert!(first.weighted().len() + second.weighted().len() >= 8);
            let line = NurbsCurve::bezier(&[DVec3::X, DVec3::Y], None).unwrap();
            let both = compatible(&[c.clone(), line.clone(), part.clone()]).unwrap();
            prop_assert!(both.iter().all(|x| x.knots == both[0].knots));
            prop_assert!(both[0].jet(t)[0].distance(c.jet(t)[0]) < 1e-12);
            prop_assert!(both[1].jet(t)[0].distance(line.jet(t)[0]) < 1e-12);
            prop_assert!(both[2].jet(s)[0].distance(part.jet(a + s * (b - a))[0]) < 1e-8);
        }

        #[test]
        fn surfaces_pass_through_their_sections(s in 0.0f64..1.0, one in any::<bool>(), two in any::<bool>()) {
            let base = rational();
            let sections: Vec<NurbsCurve> =
                (0..4).map(|k| base.map(|p| p * (1.0 + 0.3 * f64::from(k % 2)) + DVec3::Z * f64::from(k))).collect();
            let t = [0.0, 0.2, 0.7, 1.0];
            let slope = || sections[0].weighted().iter().map(|p| (DVec3::Z * 3.0 * p.w).extend(0.0)).collect::<Vec<_>>();
            let f = NurbsSurface::through(&sections, &t, &[one.then(slope), two.then(slope)]).unwrap();
            for (c, v) in sections.iter().zip(t) {
                prop_assert!(f.jet(s, v)[0].distance(c.jet(s)[0]) < 1e-11);
            }
            for (given, v) in [(one, 0.0), (two, 1.0)] {
                let [_, _, sv, _, _, svv] = f.jet(s, v);
                let off = if given { sv.distance(DVec3::Z * 3.0) } else { svv.length() };
                prop_assert!(off < 1e-9);
            }
            prop_assert!(f.rim(0).unwrap().jet(0.3)[0].distance(f.jet(0.0, 0.3)[0]) < 1e-12);
        }
    }
}
