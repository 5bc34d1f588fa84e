//! Where contours meet, by exact predicates.

use glam::DVec2;

use crate::numeric::predicates::orient2d;
use crate::spatial::{Aabb, Bvh};

/// Two segments that have more in common than the point in which one follows the other. Segment `i` of a contour runs from
/// point `i` to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SegmentMeeting {
    /// Contour and segment of the first.
    pub first: [u32; 2],
    /// Contour and segment of the second, which comes later.
    pub second: [u32; 2],
    /// Whether they cross in one point inside both. Otherwise an end of one lies on the other, or they run along each
    /// other.
    pub crosses: bool,
}

/// A straight piece of a contour.
#[derive(Clone, Copy)]
struct ContourSegment {
    /// The contour, and the piece's number in it.
    number: [u32; 2],
    ends: [DVec2; 2],
}

/// All pairs of segments that meet, ascending. Exact: no tolerance is involved. Segments without length count as points;
/// contours that touch in a node are found like those that cross.
pub fn crossings(contours: &[Vec<DVec2>]) -> Vec<SegmentMeeting> {
    let segments: Vec<ContourSegment> = contours
        .iter()
        .enumerate()
        .flat_map(|(c, contour)| {
            let p = contour;
            (0..p.len())
                .map(move |i| ContourSegment { number: [c as u32, i as u32], ends: [p[i], p[(i + 1) % p.len()]] })
        })
        .collect();
    let around = |s: &ContourSegment| Aabb::around(s.ends.map(|p| p.extend(0.0)));
    let follows = |i: u32, j: u32| {
        let ([c, s], [d, t]) = (segments[i as usize].number, segments[j as usize].number);
        let n = contours[c as usize].len() as u32;
        c == d && (t == (s + 1) % n || s == (t + 1) % n)
    };
    let meet = |i: u32, j: u32| meeting(segments[i as usize], segments[j as usize], follows(i, j));
    let bvh = Bvh::new(segments.iter().map(around).collect());
    let pairs = bvh.pairs(&|i, j| meet(i, j).is_some());
    pairs.into_iter().filter_map(|[i, j]| meet(i, j)).collect()
}

fn meeting(a: ContourSegment, b: ContourSegment, follows: bool) -> Option<SegmentMeeting> {
    let found = |crosses| Some(SegmentMeeting { first: a.number, second: b.number, crosses });
    let ([p, q], [r, s]) = (a.ends, b.ends);
    let turns = [orient2d(p, q, r), orient2d(p, q, s), orient2d(r, s, p), orient2d(r, s, q)];
    let apart = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    if follows {
        // one after the other they meet again only where the second runs back along the first
        let (end, tip) = if q == r { (p, s) } else { (q, r) };
        let middle = if q == r { q } else { p };
        let back = turns.iter().all(|t| *t == 0.0) && (end - middle).dot(tip - middle) > 0.0;
        return if back { found(false) } else { None };
    }
    if apart(turns[0], turns[1]) && apart(turns[2], turns[3]) {
        return found(true);
    }
    let on = |a: DVec2, b: DVec2, c: DVec2| a.min(b).cmple(c).all() && c.cmple(a.max(b)).all();
    let touches = (turns[0] == 0.0 && on(p, q, r))
        || (turns[1] == 0.0 && on(p, q, s))
        || (turns[2] == 0.0 && on(r, s, p))
        || (turns[3] == 0.0 && on(r, s, q));
    if touches { found(false) } else { None }
}
