//! Where two surfaces touch.

use super::oracle::NEWTON_STEPS;
use glam::DVec3;

/// Step of differences, as a share of the cell.
const DIFFERENCE: f64 = 1e-4;
/// The iteration has settled when it moves by less than this share of the cell.
const SETTLED: f64 = 1e-9;
/// Along a seam at which two surfaces touch everywhere there is no single point: the slope of the difference of their normals
/// has a determinant below this share of its square.
const SEAM: f64 = 1e-3;

/// The point nearest to a place at which two surfaces have one normal line, by Newton's method on the difference of their
/// normals: `onto` is a point of the first near another, `normals` are those of both there. `None` where there is none
/// within `reach` cells, or a whole line of them.
pub(crate) fn common_normal(
    start: DVec3,
    [cell, reach]: [f64; 2],
    onto: impl Fn(DVec3) -> Option<DVec3>,
    normals: impl Fn(DVec3) -> Option<[DVec3; 2]>,
) -> Option<DVec3> {
    let mut p = onto(start)?;
    let [a, b] = normals(p)?;
    let sign = a.dot(b).signum();
    let apart = |p: DVec3| normals(p).map(|[a, b]| a - sign * b);
    for _ in 0..NEWTON_STEPS {
        let n = normals(p)?[0];
        let (e, f) = n.any_orthonormal_pair();
        let r = apart(p)?;
        let d = DIFFERENCE * cell;
        let slope = |t: DVec3| Some((apart(p + d * t)? - apart(p - d * t)?) / (2.0 * d));
        let (se, sf) = (slope(e)?, slope(f)?);
        let (a, b, c, g) = (se.dot(e), sf.dot(e), se.dot(f), sf.dot(f));
        let det = a * g - b * c;
        if !(det.abs() > SEAM * (a * a + b * b + c * c + g * g)) {
            return None;
        }
        let (x, y) = (r.dot(e), r.dot(f));
        let step = (e * (b * y - g * x) + f * (c * x - a * y)) / det;
        p = onto(p + step.clamp_length_max(cell))?;
        if p.distance(start) > reach * cell {
            return None;
        }
        if step.length() < SETTLED * cell {
            return Some(p);
        }
    }
    None
}
