//! Nearest points on leaves, on the curves where two meet, and at the points where three do.

use glam::{DMat3, DVec3};

use super::leaf::Leaf;
use super::tape::Tape;

/// Steps after which an iteration that has not settled is given up: settled ones take 3 to 8.
const MOST_STEPS: usize = 30;

/// A step shorter than this share of the scale changes nothing.
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// Singular values below this share of the largest are dropped: surfaces closer to tangent than this angle (radians) have
/// no curve of intersection that doubles could place.
const RANK: f64 = 1e-4;

/// The point nearest to `p` where all given leaves vanish, found from `p` by projecting `p` again and again onto the
/// intersection of their tangent planes. `None` if that does not settle within `reach`.
pub(crate) fn nearest(leaves: &[Leaf], which: &[u32], p: DVec3, reach: f64, scale: f64) -> Option<DVec3> {
    let mut q = p;
    for step in 0..MOST_STEPS {
        let next = project_once(leaves, which, p, q)?;
        if !next.is_finite() || next.distance(p) > 4.0 * reach {
            return None;
        }
        let moved = next.distance(q);
        q = next;
        if moved <= SETTLED * scale {
            break;
        }
        if step + 1 == MOST_STEPS && moved > 1e-9 * scale {
            return None;
        }
    }
    // two plain Newton steps put the point on the surfaces as well as doubles can
    for _ in 0..2 {
        q = project_once(leaves, which, q, q)?;
    }
    (q.is_finite() && q.distance(p) <= reach).then_some(q)
}

/// The projection of `p` onto the intersection of the leaves' tangent planes at `q`.
fn project_once(leaves: &[Leaf], which: &[u32], p: DVec3, q: DVec3) -> Option<DVec3> {
    let mut d = which.iter().map(|i| leaves[*i as usize].gradient(q));
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
            let det = m.cross(n).length_squared();
            if det < RANK * RANK {
                return None;
            }
            Some(p - (m * (ra - c * rb) + n * (rb - c * ra)) / det)
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
            (j.determinant().abs() > RANK).then(|| p - j.inverse() * r)
        }
    }
}

/// How the inside near a point of leaf `leaf` depends on it: `Some(true)` if the leaf's positive side is inside and the
/// other outside, `Some(false)` the other way round, `None` if the leaf does not bound the solid there.
pub(crate) fn bounds_solid(tape: &Tape, leaves: &[Leaf], leaf: u32, q: DVec3) -> Option<bool> {
    let plus = tape.inside_with(leaves, q, &[(leaf, true)]);
    let minus = tape.inside_with(leaves, q, &[(leaf, false)]);
    (plus != minus).then_some(plus)
}

/// Whether the boundary has an edge at a point of leaves `i` and `j`: the orientations of both, as in [`bounds_solid`].
pub(crate) fn bounds_edge(tape: &Tape, leaves: &[Leaf], i: u32, j: u32, q: DVec3) -> Option<(bool, bool)> {
    let s = |a, b| tape.inside_with(leaves, q, &[(i, a), (j, b)]);
    let t = [[s(false, false), s(false, true)], [s(true, false), s(true, true)]];
    let by_i = [0, 1].into_iter().find(|b| t[0][*b] != t[1][*b])?;
    let by_j = [0, 1].into_iter().find(|a| t[*a][0] != t[*a][1])?;
    Some((t[1][by_i], t[by_j][1]))
}

/// Whether all three leaves matter at a point where all vanish.
pub(crate) fn bounds_corner(tape: &Tape, leaves: &[Leaf], which: [u32; 3], q: DVec3) -> bool {
    let s = |bits: usize| {
        let f = [0, 1, 2].map(|k| (which[k], bits >> k & 1 == 1));
        tape.inside_with(leaves, q, &f)
    };
    (0..3).all(|k| (0..8).any(|bits| s(bits) != s(bits ^ (1 << k))))
}

/// The different leaves of a tape, ascending.
pub(crate) fn leaves_of(tape: &Tape) -> Vec<u32> {
    let mut v: Vec<u32> = tape
        .ops
        .iter()
        .filter_map(|op| if let super::tape::Op::Leaf { leaf, .. } = op { Some(*leaf) } else { None })
        .collect();
    v.sort_unstable();
    v.dedup();
    v
}
