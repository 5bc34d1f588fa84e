//! Nearest points on leaves, on the curves where two meet, and at the points where three do.

use glam::{DMat3, DVec3};

use super::contact::contact;
use super::leaf::Leaf;
use super::octree::Bricks;
use super::tape::{Op, Tape};
use crate::numeric::{Dual, ROUNDING};
use crate::spatial::Aabb;

/// Steps after which an iteration that has not settled is given up: settled ones take 3 to 8.
pub(super) const MOST_STEPS: usize = 30;

/// A step shorter than this share of the scale changes nothing.
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// A foot on one surface is settled when a step along the surface is no longer than this share of the distance to it: that distance is
/// then right to ten digits, and the last steps put the foot on the surface whatever it is.
const FOOT: f64 = 1e-5;

/// The nearest point of a curve is settled when a step along the curve is no longer than this share of the distance to it. Unlike with
/// [`FOOT`] the place counts: pieces of edges begin and end where it says.
const FOOT_ON_CURVE: f64 = 1e-10;

/// A Newton step of no more than this share of the one before is followed by ones that together are shorter than itself.
const SETTLES: f64 = 0.1;

/// Newton's method ends on the curve, but not at its nearest point: distances that near to a limit, as a share of it, are asked for exactly.
const UNSURE: f64 = 0.03;

/// Two surfaces at a smaller angle (radians) than this, or three whose normals span less, have no intersection that
/// doubles could place. Where surfaces touch, Newton's method halves the distance to the seam with every step, and with it
/// the angle; once that is so small the surfaces are apart by its square.
const TANGENT: f64 = 1e-6;

/// Surfaces that touch are met where both are nearer than this share of the scale.
const TOUCHING: f64 = 1e-11;

/// The point nearest to `p` where all given leaves vanish, found from `p` by projecting `p` again and again onto the
/// intersection of their tangent planes. Where that does not settle, as at a distance of more than a radius of curvature,
/// the point at which Newton's method from `p` ends. `None` if neither is within `reach`.
pub(crate) fn nearest(leaves: &[Leaf], which: &[u32], p: DVec3, reach: f64, scale: f64) -> Option<DVec3> {
    if let [i] = *which
        && let Some(q) = leaves[i as usize].foot(p)
    {
        return (q.distance_squared(p) <= reach * reach).then_some(q);
    }
    if which.iter().all(|i| matches!(leaves[*i as usize], Leaf::Plane { .. })) {
        // What rounding left the first time goes the second.
        let once = project_once(leaves, which, p, p, scale)?;
        let q = project_once(leaves, which, once, once, scale)?;
        return (q.distance_squared(p) <= reach * reach).then_some(q);
    }
    let near = Near::new(leaves, which, p, reach, scale)?;
    settle::<true>(leaves, which, &near).or_else(|| settle::<false>(leaves, which, &near))
}

/// Where a point is looked for.
struct Near {
    p: DVec3,
    /// Where the first projection leads from there.
    first: DVec3,
    reach: f64,
    scale: f64,
}

impl Near {
    fn new(leaves: &[Leaf], which: &[u32], p: DVec3, reach: f64, scale: f64) -> Option<Self> {
        Some(Self { p, first: project_once(leaves, which, p, p, scale)?, reach, scale })
    }
}

/// Projects onto tangent planes until that changes nothing: `p` each time, or what became of it.
fn settle<const P: bool>(leaves: &[Leaf], which: &[u32], near: &Near) -> Option<DVec3> {
    let Near { p, first, reach, scale } = *near;
    let mut q = p;
    for step in 0..MOST_STEPS {
        let next = if step == 0 { first } else { project_once(leaves, which, if P { p } else { q }, q, scale)? };
        if !next.is_finite() || next.distance(p) > 4.0 * reach {
            return None;
        }
        let moved = next.distance(q);
        q = next;
        let enough = if which.len() == 1 { FOOT * q.distance(p) } else { 0.0 };
        if moved <= enough.max(SETTLED * scale) {
            break;
        }
        if step + 1 == MOST_STEPS && moved > 1e-9 * scale {
            return None;
        }
    }
    // two plain Newton steps put the point on the surfaces as well as doubles can
    for _ in 0..2 {
        let next = project_once(leaves, which, q, q, scale)?;
        let moved = next.distance(q);
        q = next;
        if moved <= SETTLED * scale {
            break;
        }
    }
    (q.is_finite() && q.distance(p) <= reach).then_some(q)
}

/// The point [`nearest`] gives for two leaves, in fewer steps where the curve is bent: projections of `p` onto tangent planes go
/// along the curve by shares of what is left, so two of them foretell where they lead.
pub(super) fn nearest_on_curve(leaves: &[Leaf], pair: [u32; 2], p: DVec3, reach: f64, scale: f64) -> Option<DVec3> {
    // What was tried so far need not be tried again: up to the third step these are the steps of `nearest`.
    let slow = |step: usize| match step {
        0 => None,
        1 | 2 => settle::<false>(leaves, &pair, &Near::new(leaves, &pair, p, reach, scale)?),
        _ => nearest(leaves, &pair, p, reach, scale),
    };
    if pair.iter().all(|i| matches!(leaves[*i as usize], Leaf::Plane { .. })) {
        return nearest(leaves, &pair, p, reach, scale);
    }
    let mut q = p;
    // Where the step before led, and the step.
    let mut before: Option<(DVec3, DVec3)> = None;
    for step in 0..MOST_STEPS {
        let Some(next) = project_once(leaves, &pair, p, q, scale) else { return slow(step) };
        if !next.is_finite() || next.distance(p) > 4.0 * reach {
            return slow(step);
        }
        let moved = next - q;
        if moved.length() <= (FOOT_ON_CURVE * next.distance(p)).max(SETTLED * scale) {
            // A plain Newton step puts the point on the surfaces as well as doubles can.
            let q = project_once(leaves, &pair, next, next, scale)?;
            return (q.is_finite() && q.distance(p) <= reach).then_some(q);
        }
        q = next;
        // The first step goes to the curve, not along it.
        if step > 0 {
            if let Some((to, by)) = before {
                let less = moved - by;
                let share = moved.dot(less) / less.length_squared();
                if share.abs() < 1.0 {
                    q = next - (next - to) * share;
                }
            }
            before = Some((next, moved));
        }
    }
    slow(MOST_STEPS)
}

/// The point [`nearest`] gives for three leaves. It depends on `p` only by what of several it is, so there is one way to look for it.
pub(super) fn crossing(leaves: &[Leaf], which: [u32; 3], p: DVec3, reach: f64, scale: f64) -> Option<DVec3> {
    settle::<true>(leaves, &which, &Near::new(leaves, &which, p, reach, scale)?)
}

/// Whether the curve of two leaves is farther than `within` from a point, where two Newton steps tell.
pub(super) fn is_off(leaves: &[Leaf], pair: [u32; 2], p: DVec3, within: f64) -> Option<bool> {
    let once = project_once(leaves, &pair, p, p, 0.0)?;
    let twice = project_once(leaves, &pair, once, once, 0.0)?;
    let (first, second) = (once.distance(p), twice.distance(once));
    let settles = second < SETTLES * first;
    let slack = 2.0 * second + UNSURE * within;
    if settles && first + slack <= within {
        Some(false)
    } else if settles && first - slack > within {
        Some(true)
    } else {
        None
    }
}

/// What is to vanish for leaf number `k` of `which` where all of them do.
pub(super) fn condition(leaves: &[Leaf], which: &[u32], k: usize, q: DVec3) -> Dual {
    match &leaves[which[k] as usize] {
        Leaf::Fillet(f) => f.beside(leaves, &which[..k], &which[k + 1..], q),
        leaf => {
            let touched = which[..k].iter().find_map(|i| contact(&leaves[*i as usize], leaf));
            touched.as_ref().unwrap_or(leaf).gradient(q)
        }
    }
}

/// The projection of `p` onto the intersection of the leaves' tangent planes at `q`.
fn project_once(leaves: &[Leaf], which: &[u32], p: DVec3, q: DVec3, scale: f64) -> Option<DVec3> {
    let mut d = (0..which.len()).map(|k| condition(leaves, which, k, q));
    match which.len() {
        1 => {
            let d = d.next()?;
            let g2 = d.g.length_squared();
            (g2 > 0.0).then(|| p - d.g * ((d.v + d.g.dot(p - q)) / g2))
        }
        2 => {
            let (a, b) = (d.next()?, d.next()?);
            let (la, lb) = (a.g.length(), b.g.length());
            if !(la > 0.0 && lb > 0.0) {
                return None;
            }
            let (m, n) = (a.g / la, b.g / lb);
            let (ra, rb) = (a.v / la + m.dot(p - q), b.v / lb + n.dot(p - q));
            let c = m.dot(n);
            // Along the first normal and across it: solving by both normals would lose twice as many digits at small angles.
            let across = n - m * c;
            let s = across.length();
            if s < TANGENT {
                let near = (a.v / la).abs().max((b.v / lb).abs()) <= TOUCHING * scale;
                return near.then_some(q);
            }
            Some(p - m * ra - across * ((rb - c * ra) / (s * s)))
        }
        _ => {
            let mut rows = [DVec3::ZERO; 3];
            let mut r = DVec3::ZERO;
            for (k, d) in d.take(3).enumerate() {
                let l = d.g.length();
                if !(l > 0.0) {
                    return None;
                }
                rows[k] = d.g / l;
                r[k] = d.v / l + rows[k].dot(p - q);
            }
            let j = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
            if j.determinant().abs() > TANGENT {
                return Some(p - j.inverse() * r);
            }
            (r - j * (p - q)).abs().max_element().le(&(TOUCHING * scale)).then_some(q)
        }
    }
}

/// How the inside near a point of leaf `leaf` depends on it: `Some(true)` if the leaf's positive side is inside and the
/// other outside, `Some(false)` the other way round, `None` if the leaf does not bound the solid there.
pub(crate) fn bounds_solid(tape: &Tape, leaves: &[Leaf], leaf: u32, q: DVec3) -> Option<bool> {
    let inside = tape.inside_with(leaves, q, &[(leaf, 0b10)]);
    let [minus, plus] = [0, 1].map(|side| inside >> side & 1 == 1);
    (plus != minus).then_some(plus)
}

/// where their normals make an angle of at most so much: a cosine.
const PARALLEL: f64 = 1.0 - 1e-9;

/// [`bounds_solid`] where surfaces of other leaves lie in this one's, as the crest of a thread may in its shank: all of them change sides
/// at once. `None` where there is no other.
pub(crate) fn bounds_together(tape: &Tape, leaves: &[Leaf], leaf: u32, q: DVec3, scale: f64) -> Option<bool> {
    let n = leaves[leaf as usize].slope(q).try_normalize()?;
    let alike = |other: u32| {
        let one = &leaves[other as usize];
        // Surfaces this near to each other are one to rounding.
        let along = if one.vanishes(q, ROUNDING * scale) { n.dot(one.slope(q).normalize_or_zero()) } else { 0.0 };
        (along.abs() >= PARALLEL).then_some((other, if along > 0.0 { 0b10 } else { 0b01 }))
    };
    let together: Vec<(u32, u8)> = leaves_of(tape).into_iter().filter_map(alike).collect();
    if together.len() < 2 {
        return None;
    }
    let inside = tape.inside_with(leaves, q, &together);
    let [minus, plus] = [0, 1].map(|side| inside >> side & 1 == 1);
    (plus != minus).then_some(plus)
}

/// Whether the boundary has an edge at a point of leaves `i` and `j`: the orientations of both, as in [`bounds_solid`].
pub(crate) fn bounds_edge(tape: &Tape, leaves: &[Leaf], i: u32, j: u32, q: DVec3) -> Option<(bool, bool)> {
    let inside = tape.inside_with(leaves, q, &[(i, 0b1100), (j, 0b1010)]);
    let t = [[0, 1], [2, 3]].map(|row| row.map(|case| inside >> case & 1 == 1));
    let by_i = [0, 1].into_iter().find(|b| t[0][*b] != t[1][*b])?;
    let by_j = [0, 1].into_iter().find(|a| t[*a][0] != t[*a][1])?;
    Some((t[1][by_i], t[by_j][1]))
}

/// Whether all three leaves matter at a point where all vanish.
pub(crate) fn bounds_corner(tape: &Tape, leaves: &[Leaf], which: [u32; 3], q: DVec3) -> bool {
    let inside =
        tape.inside_with(leaves, q, &[(which[0], 0b1010_1010), (which[1], 0b1100_1100), (which[2], 0b1111_0000)]);
    let s = |bits: usize| inside >> bits & 1 == 1;
    (0..3).all(|k| (0..8).any(|bits| s(bits) != s(bits ^ (1 << k))))
}

/// Other leaves that pass a point this near, as a share of the scale, leave its surroundings undecided.
const CROWDED: f64 = 1e-6;

/// Where a point's surroundings are undecided the surface is looked at this far away, as a share of the scale.
const LOOK: f64 = 1e-4;

/// Directions in which it is looked at: faces that end in a corner may be narrow.
const WAYS: u32 = 40;
/// From one to the next it is so many on. It has no divisor in common with [`WAYS`], so that all have their turn, and is about a
/// quarter of them, so that four in a row look all around.
const WAYS_APART: u32 = 11;

/// The surroundings of a point at which leaves meet.
pub(crate) struct Meeting<'a> {
    /// The tape that holds at the point.
    pub(crate) tape: &'a Tape,
    /// It is known to hold in all of this box, which may be empty.
    pub(crate) holds: Aabb,
    /// What holds at other points.
    pub(crate) bricks: &'a Bricks,
    pub(crate) whole: &'a Tape,
    pub(crate) leaves: &'a [Leaf],
    pub(crate) scale: f64,
}

impl Meeting<'_> {
    /// Like [`bounds_edge`], also where more leaves vanish than the two.
    pub(crate) fn edge(&self, i: u32, j: u32, q: DVec3) -> Option<(bool, bool)> {
        if self.is_crowded(&[i, j], q, CROWDED * self.scale) {
            Some((self.seen_nearby(i, q)?, self.seen_nearby(j, q)?))
        } else {
            bounds_edge(self.tape, self.leaves, i, j, q)
        }
    }

    /// Like [`bounds_corner`], also where more leaves vanish than the three.
    pub(crate) fn corner(&self, which: [u32; 3], q: DVec3) -> bool {
        if self.is_crowded(&which, q, CROWDED * self.scale) {
            which.iter().all(|i| self.seen_nearby(*i, q).is_some())
        } else {
            bounds_corner(self.tape, self.leaves, which, q)
        }
    }

    /// Whether leaves other than `which` pass the point nearer than `near`, or a fillet ends there.
    pub(crate) fn is_crowded(&self, which: &[u32], q: DVec3, near: f64) -> bool {
        self.tape.ops.iter().any(|op| {
            let Op::Leaf { leaf, .. } = *op else { return false };
            let passes = || {
                let d = self.leaves[leaf as usize].gradient(q);
                d.v.abs() <= near * d.g.length()
            };
            let ends = || matches!(&self.leaves[leaf as usize], Leaf::Fillet(f) if f.ends_near(q, near));
            (!which.contains(&leaf) && passes()) || ends()
        })
    }

    /// The side of a leaf that is inside, where the leaf bounds the solid somewhere around the point.
    pub(crate) fn seen_nearby(&self, leaf: u32, q: DVec3) -> Option<bool> {
        let n = self.leaves[leaf as usize].slope(q).try_normalize()?;
        let (u, v) = n.any_orthonormal_pair();
        let step = LOOK * self.scale;
        (0..WAYS).find_map(|k| {
            // Far apart at first, and none of them along an axis of `u` and `v`, which the other leaves often are.
            let (s, c) = (0.3 + std::f64::consts::TAU * f64::from(k * WAYS_APART % WAYS) / f64::from(WAYS)).sin_cos();
            let p = nearest(self.leaves, &[leaf], q + step * (c * u + s * v), step, self.scale)?;
            let tape = if self.holds.contains(p) { self.tape } else { self.bricks.tape_at(self.whole, p) };
            bounds_solid(tape, self.leaves, leaf, p)
        })
    }
}

/// The different leaves of a tape, ascending.
pub(crate) fn leaves_of(tape: &Tape) -> Vec<u32> {
    let mut v: Vec<u32> =
        tape.ops.iter().filter_map(|op| if let Op::Leaf { leaf, .. } = op { Some(*leaf) } else { None }).collect();
    v.sort_unstable();
    v.dedup();
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::Solid;
    use crate::implicit::lower::lower;

    #[test]
    fn surfaces_that_touch_meet_on_their_seam() {
        let bar = Solid::half_space(DVec3::Y, DVec3::Y * 0.3) & Solid::cylinder(0.3, DVec3::X, DVec3::ZERO, None);
        let leaves = lower(&bar).unwrap().leaves;
        for start in
            [[-0.967, 0.2987, 0.021], [0.34, 0.2983, 0.026], [0.0, 0.3, -1e-5], [0.0, 0.29, 0.2], [0.5, 0.3, 0.0]]
        {
            let q = nearest(&leaves, &[0, 1], DVec3::from(start), 1.0, 2.0).unwrap();
            assert!((q.y - 0.3).abs() < 1e-11 && q.z.abs() < 1e-6 && (q.x - start[0]).abs() < 1e-6, "{start:?} {q}");
        }
    }
}
