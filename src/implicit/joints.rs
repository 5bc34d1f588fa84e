//! Formulas in pieces that go over into each other smoothly, as camber lines and splines do.
//!
//! A piece to itself would be a leaf of its own. Two leaves that touch all along the border between them have their zeros apart by rounding
//! there, and a wall of no width between.

use glam::DVec3;

use super::expr::Expr;
use super::formula::Formula;
use super::newton::MOST_STEPS;
use super::solid::Placement;
use super::steps::is_small;
use crate::numeric::ROUNDING;

/// Larger formulas are not looked at.
pub(super) const LARGEST: usize = 1024;
/// Points from which the border is looked for, near and far.
const LOOKS: usize = 96;
/// So many points on the border show what both pieces do there.
const ENOUGH: usize = 8;
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
    Border::new(condition, a, b).is_some_and(|mut border| border.joint(Border::point) == Joint::Smooth)
}

/// How two parts of a surface meet: `a` is zero in one of them, where the condition is positive, and `b` in the other. As seen at points.
pub(super) fn joint_of_surface(condition: &Expr, a: &Expr, b: &Expr) -> Joint {
    Border::new(condition, a, b).map_or(Joint::Unknown, |mut border| border.joint(Border::surface_point))
}

/// Two formulas on both sides of where a third one is zero.
struct Border {
    condition: Formula,
    a: Formula,
    b: Formula,
    state: u64,
}

/// A point of the border, found at some distance from the origin.
#[derive(Clone, Copy)]
struct Found {
    p: DVec3,
    size: f64,
}

impl Border {
    fn new(condition: &Expr, a: &Expr, b: &Expr) -> Option<Self> {
        if ![condition, a, b].into_iter().all(|e| is_small(e, LARGEST)) {
            return None;
        }
        let [condition, a, b] = [condition, a, b].map(|e| Formula::in_pieces(e, &Placement::IDENTITY));
        Some(Self { condition, a, b, state: 1 })
    }

    fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 11) as f64 / (1u64 << 53) as f64
    }

    fn joint(&mut self, point: impl Fn(&mut Self) -> Option<Found>) -> Joint {
        let (mut seen, mut creased) = (0, false);
        for _ in 0..LOOKS {
            let Some(found) = point(self) else { continue };
            let Some(alike) = self.is_alike(found) else { continue };
            if !(alike || self.goes_on(found)) {
                return Joint::Unknown;
            }
            creased |= !alike;
            seen += 1;
            if creased && seen >= ENOUGH {
                return Joint::Creased;
            }
        }
        if seen >= ENOUGH { Joint::Smooth } else { Joint::Unknown }
    }

    /// A point where the condition is zero.
    fn point(&mut self) -> Option<Found> {
        let size = 10f64.powf(5.0 * self.unit() - 2.0);
        let mut p = DVec3::from_array([0; 3].map(|_| size * (2.0 * self.unit() - 1.0)));
        let mut moved = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let d = self.condition.gradient(p);
            let step = d.g * (d.v / d.g.length_squared());
            moved = step.length();
            p -= step;
            if !(moved > 1e-15 * size) {
                break;
            }
        }
        (p.is_finite() && moved <= 1e-12 * size && p.length() < 100.0 * size).then_some(Found { p, size })
    }

    /// A point where the condition and the first formula are zero, or in a wall where the two have different signs.
    fn surface_point(&mut self) -> Option<Found> {
        let found = self.point()?;
        let Found { mut p, size } = found;
        if (self.a.gradient(p).v > 0.0) != (self.b.gradient(p).v > 0.0) {
            return Some(found);
        }
        let mut moved = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let (c, a) = (self.condition.gradient(p), self.a.gradient(p));
            // Within the plane of both gradients; nothing where these are parallel.
            let normal = c.g.cross(a.g);
            let step = (a.g.cross(normal) * c.v + normal.cross(c.g) * a.v) / normal.length_squared();
            moved = step.length();
            p -= step.clamp_length_max(size);
            if !(moved > 1e-15 * size) {
                break;
            }
        }
        (p.is_finite() && moved <= 1e-9 * size && p.length() < 100.0 * size).then_some(Found { p, size })
    }

    /// Whether both have the same value and gradient; nothing where one of them has none.
    fn is_alike(&self, Found { p, size }: Found) -> Option<bool> {
        let (u, v) = (self.a.gradient(p), self.b.gradient(p));
        if !(u.v.is_finite() && v.v.is_finite() && u.g.is_finite() && v.g.is_finite()) {
            return None;
        }
        // A gradient that vanishes there is rounding.
        let value = u.v.abs().max(v.v.abs());
        let slope = u.g.length().max(v.g.length()) + value / size;
        // Values and gradients on the border agree up to the rounding of factors, and of the point.
        Some((u.v - v.v).abs() <= ROUNDING * (value + slope * size) && (u.g - v.g).length() <= ROUNDING.sqrt() * slope)
    }

    /// Whether both have values beyond the border.
    fn goes_on(&self, Found { p, size }: Found) -> bool {
        let across = self.condition.gradient(p).g.normalize_or_zero() * (BEYOND * size);
        let is_defined = |f: &Formula, p: DVec3| {
            let d = f.gradient(p);
            d.v.is_finite() && d.g.is_finite()
        };
        is_defined(&self.a, p - across) && is_defined(&self.b, p + across)
    }
}
