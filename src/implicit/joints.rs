//! Formulas in pieces that go over into each other smoothly, as camber lines and splines do.
//!
//! A piece to itself would be a leaf of its own. Two leaves that touch all along the border between them have their zeros apart by rounding
//! there, and a wall of no width between.

use glam::DVec3;

use super::expr::Expr;
use super::formula::Formula;
use super::solid::Placement;
use super::steps::is_small;

/// Larger formulas are not looked at.
const LARGEST: usize = 1024;
/// Points from which the border is looked for, near and far.
const LOOKS: usize = 96;
/// Steps of Newton's method to it.
const STEPS: usize = 30;
/// So many points on the border show what both pieces do there.
const ENOUGH: usize = 8;
/// Values and gradients on the border agree up to this share of their size: rounding of factors, and of the point.
const ALIKE: f64 = 1e-9;
/// How far beyond the border a value is asked for, as a share of the distance at which the border is looked for: farther than rounding
/// goes, nearer than anything else may end.
const BEYOND: f64 = 1e-3;

/// How two formulas meet where a third one is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Joint {
    /// With the same values and gradients.
    Smooth,
    /// With others; both have values beyond.
    Creased,
    /// One has no value beyond, or it was not seen.
    Unknown,
}

/// Whether `a` and `b` have the same values and gradients where the condition passes zero, as seen at points there.
pub(super) fn is_smooth(condition: &Expr, a: &Expr, b: &Expr) -> bool {
    joint(condition, a, b) == Joint::Smooth
}

/// How `a`, where the condition is positive, and `b` meet, as seen at points.
pub(super) fn joint(condition: &Expr, a: &Expr, b: &Expr) -> Joint {
    if ![condition, a, b].into_iter().all(|e| is_small(e, LARGEST)) {
        return Joint::Unknown;
    }
    let [c, a, b] = [condition, a, b].map(|e| Formula::in_pieces(e, &Placement::IDENTITY));
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut seen, mut creased) = (0, false);
    for _ in 0..LOOKS {
        let size = 10f64.powf(5.0 * unit() - 2.0);
        let mut p = DVec3::from_array([0; 3].map(|_| size * (2.0 * unit() - 1.0)));
        let mut moved = f64::INFINITY;
        for _ in 0..STEPS {
            let d = c.gradient(p);
            let step = d.g * (d.v / d.g.length_squared());
            moved = step.length();
            p -= step;
            if !(moved > 1e-15 * size) {
                break;
            }
        }
        if !(p.is_finite() && moved <= 1e-12 * size && p.length() < 100.0 * size) {
            continue;
        }
        let (u, v) = (a.gradient(p), b.gradient(p));
        if !(u.v.is_finite() && v.v.is_finite() && u.g.is_finite() && v.g.is_finite()) {
            continue;
        }
        // A gradient that vanishes there is rounding.
        let value = u.v.abs().max(v.v.abs());
        let slope = u.g.length().max(v.g.length()) + value / size;
        let alike = (u.v - v.v).abs() <= ALIKE * (value + slope * size) && (u.g - v.g).length() <= ALIKE.sqrt() * slope;
        let across = c.gradient(p).g.normalize_or_zero();
        let is_defined = |f: &Formula, side: f64| {
            let d = f.gradient(p + across * (side * BEYOND * size));
            d.v.is_finite() && d.g.is_finite()
        };
        if !(is_defined(&a, -1.0) && is_defined(&b, 1.0)) && !alike {
            return Joint::Unknown;
        }
        creased |= !alike;
        seen += 1;
    }
    match seen >= ENOUGH {
        false => Joint::Unknown,
        true if creased => Joint::Creased,
        true => Joint::Smooth,
    }
}
