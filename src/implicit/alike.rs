//! Leaves that are one surface though they are written differently: a lattice moved by its period, a twisted bar turned by
//! half a turn, a formula times a number. Their signs must agree exactly, so one of them stands for all.

use glam::DVec3;

use super::leaf::Leaf;
use super::lower::replayed;
use super::sample::BATCH;
use super::tape::{Op, Tape};
use crate::numeric::FEW_ROUNDINGS;
use crate::spatial::Aabb;

/// Ratios of two values of a leaf that differ by less than this may be those of one surface.
const RATIO: f64 = 1e-6;

/// Points in which two such leaves must agree.
const POINTS: usize = 32 * 32 * 32;

/// The tape with one leaf in the place of all that are the same surface inside the box. `None` if no two are.
///
/// Only leaves that are somebody's function are looked at, among themselves and beside the others: those in closed form have
/// been compared by their parameters. Two are the same if one is the other times a number, within rounding, in 32 768 points
/// spread evenly over the box: a difference narrower than 1/32 of it may be overlooked, and another function with the same
/// zeros is not found.
pub(super) fn unified(leaves: &[Leaf], tape: &Tape, bounds: &Aabb) -> Option<Tape> {
    let able = |leaf: &Leaf| !matches!(leaf, Leaf::Fillet(_));
    if !leaves.iter().any(|l| able(l) && l.is_user()) {
        return None;
    }
    let (a, b) = (spread(bounds, 0), spread(bounds, 1));
    let mut seen: Vec<(f64, usize)> = (0..leaves.len())
        .filter(|&i| able(&leaves[i]))
        .map(|i| (leaves[i].value(b) / leaves[i].value(a), i))
        .filter(|(ratio, _)| ratio.is_finite())
        .collect();
    seen.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let mut other: Vec<(u32, bool)> = (0..leaves.len() as u32).map(|i| (i, false)).collect();
    let mut found = false;
    let mut kept: Vec<(f64, usize)> = Vec::new();
    for (ratio, i) in seen {
        kept.retain(|k| ratio - k.0 <= RATIO * ratio.abs().max(1.0));
        let same = |k: usize| (leaves[i].is_user() || leaves[k].is_user()).then(|| times(leaves, k, i, bounds))?;
        match kept.iter().find_map(|&(_, k)| Some((k, same(k)?))) {
            Some((k, factor)) => {
                other[i] = (k as u32, factor < 0.0);
                found = true;
            }
            None => kept.push((ratio, i)),
        }
    }
    found.then(|| {
        replayed(&tape.ops, |op| match op {
            Op::Leaf { leaf, face, negate } => {
                let (leaf, flip) = other[leaf as usize];
                Op::Leaf { leaf, face, negate: negate != flip }
            }
            op => op,
        })
    })
}

/// The number that makes leaf `j` of leaf `i` everywhere in the box, if there is one.
fn times(leaves: &[Leaf], i: usize, j: usize, bounds: &Aabb) -> Option<f64> {
    let (f, g) = (&leaves[i], &leaves[j]);
    let size = bounds.size().length();
    let mut factor = None;
    let mut compared = 0;
    let mut at = [const { Vec::new() }; 3];
    let (mut of, mut og) = ([0.0; BATCH], [0.0; BATCH]);
    for start in (0..POINTS).step_by(BATCH) {
        let points: [DVec3; BATCH] = std::array::from_fn(|k| spread(bounds, start + k));
        for (axis, list) in at.iter_mut().enumerate() {
            list.clear();
            list.extend(points.iter().map(|p| p[axis]));
        }
        f.eval(&at[0], &at[1], &at[2], &mut of);
        g.eval(&at[0], &at[1], &at[2], &mut og);
        if factor.is_none() {
            // the largest value is known best
            let best =
                (0..BATCH).filter(|&k| of[k].is_finite()).max_by(|&x, &y| of[x].abs().total_cmp(&of[y].abs()))?;
            factor = Some(og[best] / of[best]).filter(|c: &f64| c.is_normal());
        }
        let c = factor?;
        for (k, &p) in points.iter().enumerate() {
            if !of[k].is_finite() && !og[k].is_finite() {
                continue;
            }
            let off = (og[k] - c * of[k]).abs();
            // Surfaces are one where they lie this near each other.
            let near = off <= FEW_ROUNDINGS * og[k].abs() || off <= FEW_ROUNDINGS * size * g.slope(p).length();
            if !near {
                return None;
            }
            compared += 1;
        }
    }
    factor.filter(|_| 2 * compared > POINTS)
}

/// Point `k` of a sequence that fills the box evenly: multiples of the powers of the inverse of the root of x^4 = x + 1.
fn spread(bounds: &Aabb, k: usize) -> DVec3 {
    let steps = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3);
    bounds.lo + bounds.size() * (0.5 + steps * (k + 1) as f64).fract()
}
