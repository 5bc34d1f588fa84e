//! Surfaces over curves: Hermite and NURBS surfaces over a family of curves (\[KUZ19\] 38-40, and the second of the two
//! equations 61), fillets (47), and surfaces of shift (33).

use glam::{DVec3, DVec4};

use super::basis::{ANY, Knots};
use super::curve::Curve;
use super::frame::Similarity;
use super::nurbs::{NurbsCurve, NurbsSurface, compatible};
use super::surface::Surface;
use crate::error::{Error, Place, Result};

fn wrong<T>(what: impl Into<String>) -> Result<T> {
    Err(Error::input(Place::Unknown, what.into()))
}

/// How a surface runs from curve to curve.
#[derive(Debug, Clone, PartialEq)]
enum Across {
    /// Cubic pieces through the curves with slopes from their neighbors.
    Hermite { closed: bool },
    /// A rational B-spline with the curves for control points.
    Spline { knots: Knots, weights: Vec<f64> },
    /// Circular arcs from the first curve to the third, with the second where their tangents meet.
    Arc,
}

/// A surface over a family of curves: u, in 0..=1, is the share of every curve's range, v runs across.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    curves: Vec<(Curve, [f64; 2])>,
    across: Across,
}

/// Control points across, each a sum of curves by number with a factor.
type Rows = Vec<Vec<(usize, f64)>>;
/// A number and its first two derivatives.
type Jet = [f64; 3];

/// Length of a vector with its derivatives.
fn length(d: [DVec3; 3]) -> Jet {
    let l = d[0].length();
    let first = d[0].dot(d[1]) / l;
    [l, first, (d[1].dot(d[1]) + d[0].dot(d[2]) - first * first) / l]
}

impl Family {
    fn new(curves: Vec<(Curve, [f64; 2])>, across: Across) -> Result<Self> {
        if curves.len() < 2 || curves.iter().any(|c| !(c.1[0] < c.1[1]) || !(c.1[1] - c.1[0]).is_finite()) {
            return wrong("a surface over curves needs two of them, over finite ascending ranges");
        }
        Ok(Self { curves, across })
    }

    /// A surface through the curves, curve `j` at v = j, with slopes by equations (39) and (40); `closed` goes on from the
    /// last curve to the first.
    pub fn hermite(curves: Vec<(Curve, [f64; 2])>, closed: bool) -> Result<Self> {
        if closed && curves.len() < 3 {
            return wrong("a closed surface over curves needs three of them");
        }
        Self::new(curves, Across::Hermite { closed })
    }

    /// A rational B-spline across, with the curves for control points (the second equation 61). With the degree one below the number
    /// of curves and [`Knots::uniform`] it is a Bézier surface over curves.
    pub fn spline(curves: Vec<(Curve, [f64; 2])>, knots: Knots, weights: &[f64]) -> Result<Self> {
        if knots.points() != curves.len() || weights.len() != curves.len() || !weights.iter().all(|w| *w > 0.0) {
            return wrong("knots and positive weights must fit the number of curves");
        }
        Self::new(curves, Across::Spline { knots, weights: weights.to_vec() })
    }

    /// Arcs of circles between the first curve and the last that touch there the lines to the one between them (equation 47): a fillet,
    /// v in 0..=1. The arc's weight, the cosine of half its angle, is found from the three points, which must be the corners
    /// of an isosceles triangle at every u.
    pub fn fillet(curves: [(Curve, [f64; 2]); 3]) -> Result<Self> {
        Self::new(curves.into(), Across::Arc)
    }

    /// The parameters it is defined for.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        let n = self.curves.len();
        let v = match &self.across {
            Across::Hermite { closed } => [0.0, (if *closed { n } else { n - 1 }) as f64],
            Across::Spline { knots, .. } => knots.domain(),
            Across::Arc => [0.0, 1.0],
        };
        [[0.0, 1.0], v]
    }

    /// Weights of the curves at v, and their derivatives by v.
    fn shares(&self, v: f64) -> Vec<Jet> {
        let n = self.curves.len();
        let mut out = vec![[0.0; 3]; n];
        match &self.across {
            Across::Hermite { closed } => {
                let spans = if *closed { n } else { n - 1 };
                let v = if *closed { v.rem_euclid(spans as f64) } else { v.clamp(0.0, spans as f64) };
                let j = (v.floor() as usize).min(spans - 1);
                let w = v - j as f64;
                let (w2, w3) = (w * w, w * w * w);
                let place = [
                    [1.0 - 3.0 * w2 + 2.0 * w3, -6.0 * w + 6.0 * w2, -6.0 + 12.0 * w],
                    [3.0 * w2 - 2.0 * w3, 6.0 * w - 6.0 * w2, 6.0 - 12.0 * w],
                ];
                let slope = [
                    [w - 2.0 * w2 + w3, 1.0 - 4.0 * w + 3.0 * w2, -4.0 + 6.0 * w],
                    [w3 - w2, 3.0 * w2 - 2.0 * w, 6.0 * w - 2.0],
                ];
                for s in 0..2 {
                    let i = (j + s) % n;
                    (0..3).for_each(|k| out[i][k] += place[s][k]);
                    for (i, c) in self.slope(j + s, *closed) {
                        (0..3).for_each(|k| out[i][k] += c * slope[s][k]);
                    }
                }
            }
            Across::Spline { knots, .. } => {
                let (span, rows) = knots.basis::<ANY>(v);
                let p = knots.degree();
                for r in 0..=p {
                    out[span - p + r] = [rows[0][r], rows[1][r], rows[2][r]];
                }
            }
            Across::Arc => {
                let t = 1.0 - v;
                out[0] = [t * t, -2.0 * t, 2.0];
                out[1] = [2.0 * v * t, 2.0 - 4.0 * v, -4.0];
                out[2] = [v * v, 2.0 * v, 2.0];
            }
        }
        out
    }

    /// The slope across at curve `j` as a sum of curves (equations 39 and 40).
    fn slope(&self, j: usize, closed: bool) -> Vec<(usize, f64)> {
        let n = self.curves.len();
        if closed {
            return vec![((j + 1) % n, 0.5), ((j + n - 1) % n, -0.5)];
        }
        match j {
            _ if n == 2 => vec![(1, 1.0), (0, -1.0)],
            0 => vec![(1, 2.0), (0, -1.5), (2, -0.5)],
            j if j == n - 1 => vec![(j, 1.5), (j - 1, -2.0), (j - 2, 0.5)],
            j => vec![(j + 1, 0.5), (j - 1, -0.5)],
        }
    }

    /// Point and derivatives: S, Su, Sv, Suu, Suv, Svv.
    pub fn jet(&self, u: f64, v: f64) -> [DVec3; 6] {
        let curves: Vec<[DVec3; 3]> = self
            .curves
            .iter()
            .map(|(c, [a, b])| {
                let l = b - a;
                let [p, d, e] = c.jet(a + u * l);
                [p, l * d, l * l * e]
            })
            .collect();
        let weights: Vec<Jet> = match &self.across {
            Across::Hermite { .. } => vec![[1.0, 0.0, 0.0]; curves.len()],
            Across::Spline { weights, .. } => weights.iter().map(|w| [*w, 0.0, 0.0]).collect(),
            Across::Arc => {
                let side = |i: usize, j: usize| length([0, 1, 2].map(|k| curves[j][k] - curves[i][k]));
                let (chord, one, two) = (side(0, 2), side(0, 1), side(1, 2));
                let legs = [0, 1, 2].map(|k| one[k] + two[k]);
                let w = chord[0] / legs[0];
                let d = (chord[1] - w * legs[1]) / legs[0];
                let e = (chord[2] - 2.0 * d * legs[1] - w * legs[2]) / legs[0];
                vec![[1.0, 0.0, 0.0], [w, d, e], [1.0, 0.0, 0.0]]
            }
        };
        // Homogeneous: by u 0, 1, 2 times and by v likewise.
        let mut h = [DVec4::ZERO; 6];
        for ((p, w), n) in curves.iter().zip(&weights).zip(self.shares(v)) {
            let wide = [
                (p[0] * w[0]).extend(w[0]),
                (p[1] * w[0] + p[0] * w[1]).extend(w[1]),
                (p[2] * w[0] + 2.0 * p[1] * w[1] + p[0] * w[2]).extend(w[2]),
            ];
            h[0] += n[0] * wide[0];
            h[1] += n[0] * wide[1];
            h[2] += n[1] * wide[0];
            h[3] += n[0] * wide[2];
            h[4] += n[1] * wide[1];
            h[5] += n[2] * wide[0];
        }
        let w = h[0].w;
        let s = h[0].truncate() / w;
        let su = (h[1].truncate() - s * h[1].w) / w;
        let sv = (h[2].truncate() - s * h[2].w) / w;
        let suu = (h[3].truncate() - 2.0 * h[1].w * su - h[3].w * s) / w;
        let suv = (h[4].truncate() - h[1].w * sv - h[2].w * su - h[4].w * s) / w;
        let svv = (h[5].truncate() - 2.0 * h[2].w * sv - h[5].w * s) / w;
        [s, su, sv, suu, suv, svv]
    }

    /// The surface moved.
    pub fn moved(&self, m: &Similarity) -> Self {
        Self { curves: self.curves.iter().map(|(c, r)| (c.moved(m), *r)).collect(), across: self.across.clone() }
    }

    /// Knots across, and control points across as sums of curves. `arc` is the weight of the middle of arcs.
    fn net(&self, arc: f64) -> Result<(Knots, Rows)> {
        let n = self.curves.len();
        Ok(match &self.across {
            Across::Spline { knots, weights } => (knots.clone(), (0..n).map(|i| vec![(i, weights[i])]).collect()),
            Across::Hermite { closed } => {
                let spans = if *closed { n } else { n - 1 };
                let mut rows = vec![vec![(0, 1.0)]];
                let third = |j: usize, s: f64| -> Vec<(usize, f64)> {
                    let slope = self.slope(j, *closed).into_iter().map(|(i, c)| (i, s * c / 3.0));
                    [(j % n, 1.0)].into_iter().chain(slope).collect()
                };
                let mut knots = vec![0.0; 4];
                for j in 0..spans {
                    rows.extend([third(j, 1.0), third(j + 1, -1.0), vec![((j + 1) % n, 1.0)]]);
                    knots.extend([(j + 1) as f64; 3]);
                }
                knots.push(spans as f64);
                (Knots::new(3, knots, rows.len())?, rows)
            }
            Across::Arc => (Knots::uniform(2, 3)?, vec![vec![(0, 1.0)], vec![(1, arc)], vec![(2, 1.0)]]),
        })
    }

    /// The weight of the middle of an arc at u.
    fn arc_weight(&self, u: f64) -> f64 {
        let p: Vec<DVec3> = self.curves.iter().map(|(c, [a, b])| c.at(a + u * (b - a))).collect();
        if p.len() == 3 { p[0].distance(p[2]) / (p[0].distance(p[1]) + p[1].distance(p[2])) } else { 1.0 }
    }

    /// The line u = 0 (`end` 0) or u = 1 (`end` 1), along v: exact, as every curve gives one point to it.
    /// Errors: weights of control points that are not positive.
    pub fn rim(&self, end: usize) -> Result<NurbsCurve> {
        let u = if end == 0 { 0.0 } else { 1.0 };
        let (knots, rows) = self.net(self.arc_weight(u))?;
        let at = |j: usize| self.curves[j].0.at(self.curves[j].1[end.min(1)]).extend(1.0);
        let points: Vec<DVec4> = rows.iter().map(|r| r.iter().map(|(j, c)| at(*j) * *c).sum()).collect();
        NurbsCurve::from_weighted(knots.degree(), knots.values().to_vec(), &points)
    }

    fn to_nurbs(&self) -> Result<NurbsSurface> {
        let curves = side_by_side(&self.curves)?;
        let first = curves[0].weighted();
        let alike = |c: &NurbsCurve| c.weighted().iter().zip(first).all(|(p, q)| (p.w - q.w).abs() <= 1e-12 * q.w);
        if !curves.iter().all(alike) {
            return wrong("no exact NURBS: the curves of the surface have different weights");
        }
        let arc = self.arc_weight(0.5);
        // Of polynomials the weight is constant where it is at twice as many places as their degree says.
        let breaks = curves[0].knots.breaks();
        let parts = 2 * curves[0].knots.degree() + 2;
        let same = breaks.windows(2).all(|w| {
            (0..=parts).all(|k| {
                let u = w[0] + (w[1] - w[0]) * k as f64 / parts as f64;
                (self.arc_weight(u) - arc).abs() <= 1e-12
            })
        });
        if matches!(self.across, Across::Arc) && !same {
            return wrong("no exact NURBS: the weight of a fillet is no polynomial");
        }
        let (knots, rows) = self.net(arc)?;
        let mut points = Vec::new();
        for i in 0..first.len() {
            for row in &rows {
                points.push(row.iter().map(|(j, c)| curves[*j].weighted()[i] * *c).sum::<DVec4>());
            }
        }
        NurbsSurface::from_weighted(curves[0].knots.clone(), knots, &points)
    }
}

/// Curves as NURBS with the same knots, at whose parameters they have the points of the same share of their ranges.
fn side_by_side(curves: &[(Curve, [f64; 2])]) -> Result<Vec<NurbsCurve>> {
    let stretch = |c: &(Curve, [f64; 2])| match c.0 {
        Curve::Ellipse { .. } => Some((0, c.1[1] - c.1[0])),
        Curve::Hyperbola { .. } => Some((1, c.1[1] - c.1[0])),
        _ => None,
    };
    if curves.iter().any(|c| stretch(c) != stretch(&curves[0])) {
        return wrong("no exact NURBS: conics run at another pace than the other curves");
    }
    let all: Result<Vec<NurbsCurve>> = curves.iter().map(|(c, r)| c.to_nurbs(*r)).collect();
    compatible(&all?)
}

/// A profile shifted along a path without turning: `path(v) + profile(u) - path(start) - offset` (\[KUZ19\] 33).
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// What is shifted, and the part of it.
    pub profile: (Curve, [f64; 2]),
    /// Along what, and the part of it.
    pub path: (Curve, [f64; 2]),
    /// How far the profile is taken back from where it is.
    pub offset: DVec3,
}

impl Shift {
    fn jet(&self, u: f64, v: f64) -> [DVec3; 6] {
        let (c, g) = (self.profile.0.jet(u), self.path.0.jet(v));
        let start = self.path.0.at(self.path.1[0]);
        [g[0] + (c[0] - start - self.offset), c[1], g[1], c[2], DVec3::ZERO, g[2]]
    }

    fn moved(&self, m: &Similarity) -> Self {
        let on = |c: &(Curve, [f64; 2])| (c.0.moved(m), c.1);
        Self { profile: on(&self.profile), path: on(&self.path), offset: m.vector(self.offset) }
    }

    fn to_nurbs(&self) -> Result<NurbsSurface> {
        let [c, g] = [&self.profile, &self.path].map(|c| c.0.to_nurbs(c.1));
        let (c, g) = (c?, g?);
        let back = self.path.0.at(self.path.1[0]) + self.offset;
        let mut points = Vec::new();
        for p in c.weighted() {
            for q in g.weighted() {
                let w = p.w * q.w;
                points.push(((p.truncate() / p.w + q.truncate() / q.w - back) * w).extend(w));
            }
        }
        NurbsSurface::from_weighted(c.knots.clone(), g.knots.clone(), &points)
    }
}

/// What of a surface this file holds.
pub(super) enum Over<'a> {
    Family(&'a Family),
    Shift(&'a Shift),
}

impl Over<'_> {
    pub(super) fn jet(&self, u: f64, v: f64) -> [DVec3; 6] {
        match self {
            Over::Family(f) => f.jet(u, v),
            Over::Shift(s) => s.jet(u, v),
        }
    }

    pub(super) fn domain(&self) -> [[f64; 2]; 2] {
        match self {
            Over::Family(f) => f.domain(),
            Over::Shift(s) => [s.profile.1, s.path.1],
        }
    }

    pub(super) fn moved(&self, m: &Similarity) -> Surface {
        match self {
            Over::Family(f) => Surface::Family(Box::new(f.moved(m))),
            Over::Shift(s) => Surface::Shift(Box::new(s.moved(m))),
        }
    }
}

impl Surface {
    /// The bilinear surface with the corners `p1` (0, 0), `p2` (1, 0), `p3` (0, 1) and `p4` (1, 1) (\[KUZ19\] 36).
    pub fn bilinear(p1: DVec3, p2: DVec3, p3: DVec3, p4: DVec3) -> Self {
        let curves = Box::new([Curve::segment(p1, p2), Curve::segment(p3, p4)]);
        Surface::Ruled { curves, ranges: [[0.0, 1.0]; 2] }
    }

    /// Straight lines from a curve to a point, which is a pole at v = 1 (\[KUZ19\] 37).
    pub fn sectorial(curve: Curve, range: [f64; 2], point: DVec3) -> Self {
        let still = Curve::Line { origin: point, direction: DVec3::ZERO };
        Surface::Ruled { curves: Box::new([curve, still]), ranges: [range, [0.0, 1.0]] }
    }

    /// The surface as NURBS; the points are the same, at other parameters where conics take part. Only for surfaces of finite
    /// extent. Errors: one that NURBS have no exact form for.
    pub fn to_nurbs(&self) -> Result<NurbsSurface> {
        match self {
            Surface::Nurbs(n) => Ok(n.clone()),
            Surface::Ruled { curves, ranges } => {
                let still = |c: &Curve| matches!(c, Curve::Line { direction, .. } if *direction == DVec3::ZERO);
                let pair = [(curves[0].clone(), ranges[0]), (curves[1].clone(), ranges[1])];
                let both = match [still(&curves[0]), still(&curves[1])] {
                    [false, true] => {
                        let c = pair[0].0.to_nurbs(ranges[0])?;
                        vec![c.clone(), c.map(|_| curves[1].at(0.0))]
                    }
                    [true, false] => {
                        let c = pair[1].0.to_nurbs(ranges[1])?;
                        vec![c.map(|_| curves[0].at(0.0)), c]
                    }
                    _ => side_by_side(&pair)?,
                };
                NurbsSurface::through(&both, &[0.0, 1.0], &[None, None])
            }
            Surface::Family(f) => f.to_nurbs(),
            Surface::Shift(s) => s.to_nurbs(),
            other => wrong(format!("no exact NURBS for a surface of the kind {}", other.kind())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parametric::frame::Frame;
    use crate::parametric::nurbs::SplineEnds;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use glam::DVec2;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    fn spline(k: f64) -> (Curve, [f64; 2]) {
        let p = [v(0.0, k, 0.0), v(1.0, k, 1.0 + 0.3 * k), v(2.0, k, -0.5), v(4.0, k * 1.2, 0.0)];
        let c = Curve::Nurbs(NurbsCurve::cubic(&p, SplineEnds::Natural).unwrap());
        let d = c.domain();
        (c, d)
    }

    fn arc(z: f64, r: f64) -> (Curve, [f64; 2]) {
        (Curve::circle(Frame { origin: v(0.0, 0.0, z), ..Frame::WORLD }, r), [0.2, 2.4])
    }

    /// Edges of a wedge whose opening grows with u; the fillet touches both its planes.
    fn fillet() -> Family {
        let line = |a: DVec3, b: DVec3| (Curve::segment(a, b), [0.0, 1.0]);
        let at = |x: f64, angle: f64, r: f64| v(x, r * f64::cos(angle), r * f64::sin(angle));
        let side = |s: f64| line(at(0.0, s * 0.6, 1.0), at(2.0, s * 0.9, 1.5));
        Family::fillet([side(1.0), line(DVec3::ZERO, v(2.0, 0.0, 0.0)), side(-1.0)]).unwrap()
    }

    fn all() -> Vec<Surface> {
        let family = |f: Family| Surface::Family(Box::new(f));
        let splines = || (0..4).map(|k| spline(f64::from(k))).collect::<Vec<_>>();
        let arcs = || [(0.0, 1.0), (1.0, 1.4), (1.5, 0.8)].map(|(z, r)| arc(z, r)).to_vec();
        let shift = Shift { profile: spline(0.0), path: arc(0.0, 2.0), offset: v(0.1, 0.2, 0.3) };
        vec![
            Surface::bilinear(DVec3::ZERO, DVec3::X, DVec3::Y, v(1.0, 1.0, 1.0)),
            Surface::sectorial(arc(0.0, 1.0).0, [0.2, 2.4], v(0.3, 0.2, 2.0)),
            family(Family::hermite(splines(), false).unwrap()),
            family(Family::hermite(splines(), true).unwrap()),
            family(Family::hermite(arcs(), false).unwrap()),
            family(Family::spline(splines(), Knots::uniform(2, 4).unwrap(), &[1.0, 2.0, 0.5, 1.0]).unwrap()),
            family(Family::spline(arcs(), Knots::uniform(2, 3).unwrap(), &[1.0; 3]).unwrap()),
            Surface::Shift(Box::new(shift)),
            family(fillet()),
        ]
    }

    #[test]
    fn formulas_are_those_of_the_paper() {
        // (36) and (37).
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, v(1.0, 1.0, 1.0)];
        let s = Surface::bilinear(p[0], p[1], p[2], p[3]);
        let (a, b) = (0.3, 0.8);
        let truth = (1.0 - a) * (1.0 - b) * p[0] + a * (1.0 - b) * p[1] + (1.0 - a) * b * p[2] + a * b * p[3];
        assert!(s.at(DVec2::new(a, b)).distance(truth) < 1e-15);
        let s = &all()[1];
        let c = arc(0.0, 1.0);
        let truth = (1.0 - b) * c.0.at(0.2 + a * 2.2) + b * v(0.3, 0.2, 2.0);
        assert!(s.at(DVec2::new(a, b)).distance(truth) < 1e-15);
        assert_eq!(s.poles().len(), 1);
        // (38) to (40): through the curves, slopes by differences, no third derivative at the ends.
        let curves: Vec<_> = (0..4).map(|k| spline(f64::from(k))).collect();
        let at = |j: usize| curves[j].0.at(curves[j].1[0] + a * (curves[j].1[1] - curves[j].1[0]));
        let s = &all()[2];
        for j in 0..4 {
            assert!(s.at(DVec2::new(a, j as f64)).distance(at(j)) < 1e-13);
        }
        assert!(s.jet(a, 1.0)[2].distance(0.5 * (at(2) - at(0))) < 1e-13);
        assert!(s.jet(a, 0.1)[5].distance(s.jet(a, 0.9)[5]) < 1e-12);
        // (61) with equal weights is the B-spline of the curves' points.
        let knots = Knots::uniform(2, 4).unwrap();
        let f = Family::spline(curves.clone(), knots.clone(), &[1.0; 4]).unwrap();
        let control: Vec<DVec3> = (0..4).map(at).collect();
        let c = NurbsCurve::new(2, knots.values().to_vec(), &control, None).unwrap();
        assert!(f.jet(a, b)[0].distance(c.jet(b)[0]) < 1e-13);
        // (33).
        let s = &all()[7];
        let (c, g) = (spline(0.0).0, arc(0.0, 2.0).0);
        let truth = g.at(1.0) + (c.at(0.7) - g.at(0.2) - v(0.1, 0.2, 0.3));
        assert!(s.at(DVec2::new(0.7, 1.0)).distance(truth) < 1e-14);
        // (41), (42): Bernstein polynomials.
        let net: Vec<DVec3> = (0..12).map(|k| v(f64::from(k / 4), f64::from(k % 4), f64::from(k * k % 7))).collect();
        let s = NurbsSurface::bezier(&net, 3, None).unwrap();
        let two = |t: f64| [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
        let three = |t: f64| {
            let r = 1.0 - t;
            [r * r * r, 3.0 * t * r * r, 3.0 * t * t * r, t * t * t]
        };
        let truth: DVec3 = (0..12).map(|k| two(a)[k / 4] * three(b)[k % 4] * net[k]).sum();
        assert!(s.jet(a, b)[0].distance(truth) < 1e-14);
        assert!(NurbsSurface::bezier(&net, 5, None).is_err());
    }

    #[test]
    fn a_fillet_is_a_circular_arc_that_touches_both_legs() {
        let f = fillet();
        for k in 0..=10 {
            let u = f64::from(k) / 10.0;
            let [p0, p1, p2] = [0, 1, 2].map(|i| f.curves[i].0.at(u));
            // The center: where the normals of the legs meet.
            let m = 0.5 * (p0 + p2);
            let half = (p0 - p1).length_squared() / (m - p1).length_squared();
            let center = p1 + (m - p1) * half;
            let r = center.distance(p0);
            for j in 0..=8 {
                assert_relative_eq!(
                    f.jet(u, f64::from(j) / 8.0)[0].distance(center),
                    r,
                    epsilon = 0.0,
                    max_relative = 1e-12
                );
            }
            assert!(f.jet(u, 0.0)[2].cross(p1 - p0).length() < 1e-12);
        }
    }

    #[test]
    fn what_makes_no_surface_is_refused() {
        assert!(Family::hermite(vec![spline(0.0)], false).is_err());
        assert!(Family::hermite(vec![spline(0.0), spline(1.0)], true).is_err());
        assert!(Family::spline(vec![spline(0.0), spline(1.0)], Knots::uniform(1, 3).unwrap(), &[1.0; 3]).is_err());
        let mixed = vec![spline(0.0), arc(0.0, 1.0), spline(2.0)];
        assert!(Surface::Family(Box::new(Family::hermite(mixed, false).unwrap())).to_nurbs().is_err());
        assert!(all()[8].to_nurbs().is_err());
    }

    proptest! {
        #[test]
        fn derivatives_agree_with_differences_and_nurbs_with_both(k in 0usize..9, a in 0.02f64..0.98, b in 0.02f64..0.98) {
            let s = all().swap_remove(k);
            let d = s.domain();
            let (u, w) = (d[0][0] + a * (d[0][1] - d[0][0]), d[1][0] + b * (d[1][1] - d[1][0]));
            let e = 1e-5;
            let jet = s.jet(u, w);
            let (pu, mu) = (s.jet(u + e, w), s.jet(u - e, w));
            let (pv, mv) = (s.jet(u, w + e), s.jet(u, w - e));
            let size = 1.0 + jet.iter().map(|x| x.length()).fold(0.0, f64::max);
            let pairs = [(pu, mu, 0, 1), (pv, mv, 0, 2), (pu, mu, 1, 3), (pv, mv, 1, 4), (pu, mu, 2, 4), (pv, mv, 2, 5)];
            for (p, m, from, to) in pairs {
                let found = (p[from] - m[from]) / (2.0 * e);
                // Splines have jumps in their third derivatives only.
                prop_assert!(found.distance(jet[to]) < 2e-4 * size, "{k} {from} {to} {found} {}", jet[to]);
            }
            if let Ok(n) = s.to_nurbs() {
                let [du, dv] = [n.u.domain(), n.v.domain()];
                let same = matches!(k, 0 | 2 | 3 | 5);
                if same {
                    let p = n.jet(du[0] + a * (du[1] - du[0]), dv[0] + b * (dv[1] - dv[0]))[0];
                    prop_assert!(p.distance(jet[0]) < 1e-11 * size, "{k}");
                } else {
                    // With conics the parameters differ, the rows do not: the point is somewhere on its row.
                    let row = |t: f64| n.jet(du[0] + t * (du[1] - du[0]), dv[0] + b * (dv[1] - dv[0]))[0];
                    if k != 1 && k != 7 {
                        let near = (0..=4000).map(|i| row(f64::from(i) / 4000.0).distance(jet[0])).fold(1e9, f64::min);
                        prop_assert!(near < 1e-2 * size, "{k} {near}");
                    }
                }
            }
            let m = Similarity { scale: 2.0, rotation: Frame::new(DVec3::ZERO, DVec3::ONE, None).axes, translation: DVec3::Y };
            prop_assert!(s.moved(&m).at(DVec2::new(u, w)).distance(m.point(jet[0])) < 1e-12 * size);
        }
    }

    #[test]
    fn a_sector_of_a_circle_is_a_cone_as_nurbs_too() {
        let s = Surface::sectorial(Curve::circle(Frame::WORLD, 2.0), [0.0, 1.5 * PI], v(0.0, 0.0, 4.0));
        let n = s.to_nurbs().unwrap();
        for i in 0..=12 {
            for j in 0..=6 {
                let p = n.jet(f64::from(i) / 12.0, f64::from(j) / 6.0)[0];
                assert_abs_diff_eq!(p.truncate().length(), 2.0 - 0.5 * p.z, epsilon = 1e-13);
            }
        }
    }
}
