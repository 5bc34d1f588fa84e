//! Surfaces of revolution whose profile meets its axis between its ends: the parts between are surfaces of their own, with a
//! pole at each end, and a face lies on one of them.

use glam::{DVec2, DVec3};

use super::curve::{Curve, PARTS};
use super::frame::Frame;
use super::surface::Pole;
use crate::numeric::{EIGHT_DIGITS, SEVEN_DIGITS};

/// Halvings of the range a crossing lies in.
const HALVINGS: usize = 60;

/// The profile's range between two meetings with the axis, and what is there.
pub(super) struct MeridianPart {
    pub(super) range: [f64; 2],
    pub(super) poles: Vec<Pole>,
}

/// The part of a profile on which the points of a face lie, if the profile meets its axis between its ends.
pub(super) fn part(curve: &Curve, frame: &Frame, range: [f64; 2], points: &[DVec3]) -> Option<MeridianPart> {
    let pieces = curve.pieces(range);
    let inner = pieces.windows(2).flat_map(|w| (0..PARTS).map(|k| w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64));
    let t: Vec<f64> = inner.chain([range[1]]).collect();
    let local = |t: f64| frame.local(curve.at(t));
    let away: Vec<DVec2> = t.iter().map(|t| local(*t).truncate()).collect();
    let farthest = away.iter().copied().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let (size, out) = (farthest.length(), farthest.try_normalize()?);
    let side = |t: f64| local(t).truncate().dot(out);
    // A profile this near to its axis meets it.
    let meets = |t: f64| local(t).truncate().length() <= EIGHT_DIGITS * size;
    // Shorter ranges are left over from an end on the axis.
    let slack = SEVEN_DIGITS * (range[1] - range[0]);
    let mut at: Vec<f64> = Vec::new();
    for w in t.windows(2) {
        let (mut a, mut b) = (w[0], w[1]);
        let below = side(a) < 0.0;
        if below == (side(b) < 0.0) {
            continue;
        }
        for _ in 0..HALVINGS {
            let m = 0.5 * (a + b);
            if (side(m) < 0.0) == below { a = m } else { b = m }
        }
        let m = 0.5 * (a + b);
        if meets(m) && m - range[0] > slack && range[1] - m > slack && at.last().is_none_or(|l| m - l > slack) {
            at.push(m);
        }
    }
    let closed = curve.at(range[0]).distance(curve.at(range[1])) <= EIGHT_DIGITS * size;
    let (first, last) = (*at.first()?, *at.last()?);
    let mut ranges: Vec<[f64; 2]> = at.windows(2).map(|w| [w[0], w[1]]).collect();
    // A closed profile goes on over its ends, but for one that closes on the axis.
    if closed && curve.period().is_some() && !meets(range[0]) {
        ranges.push([last, first + range[1] - range[0]]);
    } else {
        ranges.extend([[range[0], first], [last, range[1]]]);
    }
    // In the half plane of radius and height.
    let flat = |p: DVec3| DVec2::new(p.truncate().length(), p.z);
    let points: Vec<DVec2> = points.iter().map(|p| flat(frame.local(*p))).collect();
    let misses = |[a, b]: &[f64; 2]| -> f64 {
        let pieces = curve.pieces([*a, *b]);
        let parts = PARTS.max(64 / pieces.len());
        let line: Vec<DVec2> = pieces
            .windows(2)
            .flat_map(|w| (0..=parts).map(|k| flat(local(w[0] + (w[1] - w[0]) * k as f64 / parts as f64))))
            .collect();
        let miss = |p: &DVec2| line.windows(2).map(|w| foot(*p, w).distance_squared(*p)).fold(f64::INFINITY, f64::min);
        points.iter().map(miss).sum()
    };
    let range = ranges.into_iter().map(|r| (misses(&r), r)).min_by(|a, b| a.0.total_cmp(&b.0))?.1;
    let on_axis = |t: f64| frame.point(DVec3::new(0.0, 0.0, local(t).z));
    let poles = range.into_iter().filter(|t| meets(*t)).map(|t| Pole { axis: 1, value: t, point: on_axis(t) });
    Some(MeridianPart { range, poles: poles.collect() })
}

/// The point of a segment nearest to `p`.
fn foot(p: DVec2, ends: &[DVec2]) -> DVec2 {
    let d = ends[1] - ends[0];
    let l = d.length_squared();
    ends[0] + d * if l > 0.0 { ((p - ends[0]).dot(d) / l).clamp(0.0, 1.0) } else { 0.0 }
}
