//! NURBS curves changed to pass through further points and to have tangents given, as \[KUZ19\] edits its curves: by the least change of
//! control points (L. Piegl, W. Tiller, "The NURBS Book", 11.2).

use glam::DVec3;
use nalgebra::DMatrix;

use super::NurbsCurve;
use crate::error::{Error, Place, Result};
use crate::numeric::SEVEN_DIGITS;
use crate::parametric::basis::ANY;

/// What a curve is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pass {
    /// Pass through this point.
    Point(DVec3),
    /// Go in this direction, as fast as it did.
    Direction(DVec3),
}

/// What a curve is to do at a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveEdit {
    /// The parameter, within the curve's domain.
    pub t: f64,
    /// What it is to do there.
    pub pass: Pass,
}

fn wrong<T>(what: String) -> Result<T> {
    Err(Error::input(Place::Unknown, what))
}

/// By how much the point at `t`, and the first derivative there, follow each control point.
fn shares(curve: &NurbsCurve, t: f64) -> [Vec<f64>; 2] {
    let (span, rows) = curve.knots.basis::<ANY>(t);
    let first = span - curve.knots.degree();
    let own = &curve.points[first..=span];
    let sum = |k: usize| own.iter().zip(&rows[k]).map(|(p, b)| b * p.w).sum::<f64>();
    let (w, dw) = (sum(0), sum(1));
    let mut shares = [vec![0.0; curve.points.len()], vec![0.0; curve.points.len()]];
    for (i, p) in own.iter().enumerate() {
        let r = rows[0][i] * p.w / w;
        shares[0][first + i] = r;
        shares[1][first + i] = (rows[1][i] * p.w - r * dw) / w;
    }
    shares
}

/// The curve with what is asked for, by the least sum of squares of changes of its control points. Its knots, weights and ends stay,
/// but for ends for which a point is asked; a closed curve stays closed.
///
/// Errors: a parameter outside the domain; a direction of no length, or at a cusp; more than the control points allow.
pub fn edited(curve: &NurbsCurve, edits: &[CurveEdit]) -> Result<NurbsCurve> {
    if edits.is_empty() {
        return Ok(curve.clone());
    }
    let [a, b] = curve.knots.domain();
    let mut asked: Vec<(Vec<f64>, DVec3)> = Vec::new();
    let mut moved = [false; 2];
    for CurveEdit { t, pass } in edits {
        if !(a..=b).contains(t) {
            return wrong(format!("the curve has no parameter {t}: its own run from {a} to {b}"));
        }
        let [at, slope, _] = curve.jet(*t);
        let [shares, changes] = shares(curve, *t);
        match *pass {
            Pass::Point(p) => {
                moved = [moved[0] || *t == a, moved[1] || *t == b];
                asked.push((shares, p - at));
            }
            Pass::Direction(d) => match (d.try_normalize(), slope.length()) {
                (Some(d), speed) if speed > 0.0 => asked.push((changes, speed * d - slope)),
                (None, _) => return wrong(format!("the direction at parameter {t} has no length")),
                _ => return wrong(format!("the curve has no direction at parameter {t} that could be another")),
            },
        }
    }
    if curve.closed && moved[0] != moved[1] {
        // The other end goes along.
        let (from, to) = if moved[0] { (a, b) } else { (b, a) };
        let same = |x: &&CurveEdit| x.t == from && matches!(x.pass, Pass::Point(_));
        if let Some(CurveEdit { pass: Pass::Point(p), .. }) = edits.iter().find(same) {
            asked.push((shares(curve, to)[0].clone(), *p - curve.jet(to)[0]));
        }
    } else {
        for t in [a, b].into_iter().zip(moved).filter(|x| !x.1).map(|x| x.0) {
            asked.push((shares(curve, t)[0].clone(), DVec3::ZERO));
        }
    }
    let rows = DMatrix::from_fn(asked.len(), curve.points.len(), |i, j| asked[i].0[j]);
    let wanted = DMatrix::from_fn(asked.len(), 3, |i, k| asked[i].1[k]);
    let squares = &rows * rows.transpose();
    let change = squares.lu().solve(&wanted).map(|x| rows.transpose() * x);
    let size = curve.control().fold(0.0, |s: f64, p| s.max(p.abs().max_element()));
    let size = asked.iter().fold(size, |s, x| s.max(x.1.abs().max_element()));
    match change {
        Some(change) if (&rows * &change - &wanted).amax() <= SEVEN_DIGITS * size => {
            let mut edited = curve.clone();
            for (i, p) in edited.points.iter_mut().enumerate() {
                let by = DVec3::new(change[(i, 0)], change[(i, 1)], change[(i, 2)]);
                *p += (by * p.w).extend(0.0);
            }
            edited.closed = edited.jet(a)[0].distance(edited.jet(b)[0]) <= SEVEN_DIGITS * size;
            Ok(edited)
        }
        _ => wrong(format!("{} control points do not allow all that is asked of the curve", curve.points.len())),
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    /// A cubic of eight control points, rational if asked.
    fn curve(rational: bool) -> NurbsCurve {
        let points: Vec<DVec3> = (0..8).map(f64::from).map(|i| DVec3::new(i, (1.3 * i).sin(), 0.2 * i * i)).collect();
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.5, 4.0, 5.0, 5.0, 5.0, 5.0];
        let weights: Vec<f64> = (0..8).map(|i| 1.0 + 0.3 * f64::from(i % 3)).collect();
        NurbsCurve::new(3, knots, &points, rational.then_some(&weights[..])).unwrap()
    }

    fn near(p: DVec3, q: DVec3) {
        assert_abs_diff_eq!(p.distance(q), 0.0, epsilon = 1e-12);
    }

    #[test]
    fn curves_pass_through_further_points_in_further_directions() {
        let (p, d) = (DVec3::new(3.0, 2.0, 1.0), DVec3::new(1.0, 1.0, 0.0));
        for rational in [false, true] {
            let before = curve(rational);
            let edits = [
                CurveEdit { t: 1.7, pass: Pass::Point(p) },
                CurveEdit { t: 3.0, pass: Pass::Direction(d) },
                CurveEdit { t: 0.0, pass: Pass::Direction(DVec3::Z) },
                CurveEdit { t: 5.0, pass: Pass::Point(DVec3::ZERO) },
            ];
            let after = edited(&before, &edits).unwrap();
            near(after.jet(1.7)[0], p);
            near(after.jet(3.0)[1], d.normalize() * before.jet(3.0)[1].length());
            near(after.jet(0.0)[0], before.jet(0.0)[0]);
            near(after.jet(0.0)[1], DVec3::Z * before.jet(0.0)[1].length());
            near(after.jet(5.0)[0], DVec3::ZERO);
            assert_eq!(after.knots, before.knots);
            assert!(after.weighted().iter().zip(before.weighted()).all(|(a, b)| a.w == b.w));
        }
    }

    #[test]
    fn control_points_change_as_little_as_they_may() {
        // For one point within, ends kept: each by its share, over the sum of squares of shares (Piegl, Tiller 11.4).
        let (before, by) = (curve(true), DVec3::new(0.1, -0.4, 0.3));
        let t = 2.2;
        let edit = CurveEdit { t, pass: Pass::Point(before.jet(t)[0] + by) };
        let after = edited(&before, &[edit]).unwrap();
        let [shares, _] = shares(&before, t);
        assert_abs_diff_eq!(shares.iter().sum::<f64>(), 1.0, epsilon = 1e-14);
        let squares: f64 = shares[1..7].iter().map(|s| s * s).sum();
        for (i, (p, q)) in before.control().zip(after.control()).enumerate() {
            let share = if (1..7).contains(&i) { shares[i] / squares } else { 0.0 };
            near(q - p, share * by);
        }
    }

    #[test]
    fn closed_curves_stay_closed_and_what_cannot_be_is_refused() {
        let points = [[1.0, 0.0], [1.0, 2.0], [-1.0, 2.0], [-1.0, -2.0], [1.0, -2.0], [1.0, 0.0]];
        let points = points.map(|[x, y]| DVec3::new(x, y, 0.0));
        let closed = NurbsCurve::new(2, vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0], &points, None).unwrap();
        let at = |t: f64, p: DVec3| CurveEdit { t, pass: Pass::Point(p) };
        let moved = edited(&closed, &[at(0.0, DVec3::X * 2.0), at(2.0, DVec3::NEG_X)]).unwrap();
        near(moved.jet(0.0)[0], DVec3::X * 2.0);
        near(moved.jet(4.0)[0], DVec3::X * 2.0);
        near(moved.jet(2.0)[0], DVec3::NEG_X);
        let line = NurbsCurve::polyline(&[DVec3::ZERO, DVec3::X]).unwrap();
        for edits in [
            vec![at(0.5, DVec3::Y)],
            vec![at(7.0, DVec3::Y)],
            vec![at(0.0, DVec3::Y), at(0.0, DVec3::Z)],
            vec![CurveEdit { t: 0.5, pass: Pass::Direction(DVec3::ZERO) }],
        ] {
            assert!(edited(&line, &edits).is_err(), "{edits:?}");
        }
        assert_eq!(edited(&closed, &[]).unwrap(), closed);
    }
}
