//! The smooth maximum of two numbers that is commonly used: `max(a, b) + max(k - |a - b|, 0)² / (4k)`, by itself where the bracket is positive.
//! With `³ / (6k²)` in the place of the square it bends without a jump.
//!
//! The zeros of the first one are a parabola, `(a - b)² + 2k(a + b) + k² = 0`. In `u = k + a` and `v = k + b` that is where a length of `(u, v)` is `k`, as a
//! circle is where `|(u, v)|` is. So where zero alone counts it ends where `u` or `v` is zero, which lies along one of its surfaces.

use super::{ENDS, Joined};
use crate::implicit::slopes::Slopes;
use crate::implicit::smooth::Kernel;
use crate::numeric::{Dual, Interval};

/// Where `|a - b|` is below the width it is the smooth maximum. Beyond, it goes on with the same slope to less than the greater number.
/// Everywhere it rises in both, and the partial derivatives are one together.
pub(super) struct SmoothMax {
    pub(super) kernel: Kernel,
    pub(super) width: f64,
    /// See [`super::Fillet::band`].
    pub(super) band: f64,
}

impl SmoothMax {
    pub(super) fn joined(&self, [a, b]: [f64; 2]) -> Joined {
        let k = self.width;
        let (more, left) = (a.max(b), k - (a - b).abs());
        // What is added to the greater number, and the share of the lesser one in it.
        let (added, share) = if left.abs() < self.band {
            let slope = k * self.kernel.added(self.band / k) / self.band;
            ((left - ENDS * k) * slope, slope)
        } else if left > ENDS * k {
            (k * self.kernel.added(left / k), self.kernel.share(left / k))
        } else {
            let beyond = (-left).max(0.0) / k;
            let (lost, share) = if beyond < 1.0 {
                (k * self.kernel.added(beyond), self.kernel.share(beyond))
            } else {
                (k * (self.kernel.added(1.0) + 0.5 * (beyond - 1.0)), 0.5)
            };
            (-lost - ENDS * k, share)
        };
        let of_first = if a >= b { 1.0 - share } else { share };
        Joined { value: more + added, by: [of_first, 1.0 - of_first] }
    }

    pub(super) fn is_between(&self, a: f64, b: f64) -> bool {
        self.width - (a - b).abs() > ENDS * self.width
    }

    /// The smooth maximum itself.
    pub(super) fn between(&self, a: f64, b: f64) -> f64 {
        let left = (self.width - (a - b).abs()).max(0.0);
        a.max(b) + self.width * self.kernel.added(left / self.width)
    }

    /// Bounds of the partial derivative by the first number, where `a - b` has bounds.
    pub(super) fn of_first(&self, d: Interval) -> Interval {
        let k = self.width;
        // Exact, without a band: it falls to nothing at one end and rises to one at the other, and then goes back to a half.
        let at = |d: f64| {
            let share = self.kernel.share(((k - d.abs()) / k).abs().min(1.0));
            if d >= 0.0 { 1.0 - share } else { share }
        };
        let mut all = Interval::point(at(d.lo)).hull(Interval::point(at(d.hi)));
        for (end, value) in [(-k, 0.0), (k, 1.0)] {
            if d.contains(end) {
                all = all.hull(Interval::point(value));
            }
            if self.band > 0.0 && d.lo < end + self.band && d.hi > end - self.band {
                let share = k * self.kernel.added(self.band / k) / self.band;
                all = all.hull(Interval::point(if end > 0.0 { 1.0 - share } else { share }));
            }
        }
        all
    }

    /// Bounds of the three partial derivatives in a box.
    pub(super) fn slopes(&self, a: &Slopes, b: &Slopes) -> [Interval; 3] {
        let first = self.of_first(a.value - b.value);
        let second = Interval::point(1.0) - first;
        std::array::from_fn(|i| {
            let (p, q) = (a.gradient[i], b.gradient[i]);
            // A mean of both is between them, and is the second and a share of the difference, too.
            let (whole, bound) = (p * first + q * second, p.hull(q));
            Interval::new(whole.lo.max(bound.lo), whole.hi.min(bound.hi))
        })
    }
}

/// The polynomial that it is between its ends, everywhere.
pub(super) fn smooth(kernel: Kernel, k: f64, a: Dual, b: Dual) -> Dual {
    let d = a.v - b.v;
    let t = d / k;
    let (added, of_first) = match kernel {
        Kernel::Square => (0.25 * (1.0 + t * t), 0.5 * (1.0 + t)),
        Kernel::Cube => (1.0 / 6.0 + t * t * (0.5 - t.abs() / 6.0), 0.5 + t * (1.0 - 0.5 * t.abs())),
    };
    let value = 0.5 * (a.v + b.v) + k * added;
    Dual::new(value, a.g * of_first + b.g * (1.0 - of_first))
}

fn root(u: f64, v: f64) -> f64 {
    (u * u - u * v + v * v).sqrt()
}

/// The length of `(u, v)` that is `k` on the parabola; `u` itself where `v` is zero, which it touches there. Where both are negative it
/// falls as they rise.
#[inline(always)]
pub(super) fn length(u: f64, v: f64) -> f64 {
    if u <= 0.0 && v <= 0.0 {
        -(u + v) / 3.0
    } else if v == 0.0 {
        u
    } else if u == 0.0 {
        v
    } else {
        (u + v + 2.0 * root(u, v)) / 3.0
    }
}

/// Its partial derivatives.
#[inline(always)]
pub(super) fn shares(u: f64, v: f64) -> [f64; 2] {
    if u <= 0.0 && v <= 0.0 {
        return [-1.0 / 3.0; 2];
    }
    let root = root(u, v).max(f64::MIN_POSITIVE);
    [(1.0 + (2.0 * u - v) / root) / 3.0, (1.0 + (2.0 * v - u) / root) / 3.0]
}

/// Bounds of the partial derivatives where `u` is positive, of what goes on beyond `v = 0` and is linear in a band there.
pub(super) fn weights(u: Interval, v: Interval, band: f64) -> [Interval; 2] {
    // In the ratio of both each is monotone; an infinite one counts for all.
    let of = |u: f64, v: f64| match (u.is_finite(), v.is_finite()) {
        (true, true) => shares(u, v),
        (false, true) => [1.0, 0.0],
        (true, false) => [0.0, 1.0],
        (false, false) => [0.0, 0.0],
    };
    let in_band = v.lo < band && v.hi > -band;
    let far = if in_band { v.hi.max(band) } else { v.hi };
    let [mut of_u, mut of_v] = [Interval::point(1.0), Interval::point(0.0)];
    if far > 0.0 {
        let least = if in_band { 0.0 } else { v.lo.max(0.0) };
        let (lower, upper) = (of(u.lo, far), of(u.hi, least));
        of_u = Interval::new(lower[0], upper[0].max(lower[0]));
        of_v = Interval::new(upper[1].min(lower[1]), lower[1]);
        if in_band {
            // Half the slope at its end, and the other one turns by as much.
            of_v = of_v.hull(Interval::point(0.0));
            of_u = of_u.hull(Interval::point(2.0 - lower[0]));
        }
    }
    if v.lo < 0.0 {
        // Twice the one distance less the length.
        of_u = of_u.hull(Interval::new(1.0, 4.0 / 3.0));
        of_v = of_v.hull(Interval::new(0.0, 1.0 / 3.0));
    }
    [of_u, of_v]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::super::super::leaf::Leaf;
    use super::super::{Fillet, Profile, Side};
    use super::*;
    use crate::spatial::Aabb;

    fn fillet(profile: Profile, radius: f64, band: f64) -> Fillet {
        let side = |leaf, number| Side { leaf, number, negate: false };
        let ball = Leaf::Sphere { c: DVec3::new(0.0, 2.0, 0.4), r: 2.0 };
        Fillet {
            sides: [side(Leaf::Plane { n: DVec3::X, d: 0.0 }, 0), side(ball, 1)],
            radius,
            profile,
            span: 0.5,
            band: band * 0.5,
            rest: None,
        }
    }

    proptest! {
        #[test]
        fn bounds_hold_what_is_between_and_beyond_the_ends(
            which in 0usize..5, c in prop::array::uniform3(-1.0f64..1.0), half in 0.001f64..0.5,
            t in prop::array::uniform3(-1.0f64..1.0), band in prop::sample::select(vec![0.0, 0.1, 0.25]),
        ) {
            let (profile, radius) = [
                (Profile::Zeros(Kernel::Square), 0.5),
                (Profile::SmoothMax(Kernel::Square), 0.5),
                (Profile::Zeros(Kernel::Cube), 0.5),
                (Profile::SmoothMax(Kernel::Cube), 0.5),
                (Profile::Circle, -0.1),
            ][which];
            let f = fillet(profile, radius, band);
            let c = DVec3::from_array(c);
            let (cell, p) = (Aabb::new(c - half, c + half), c + DVec3::from_array(t) * half);
            let d = f.gradient(p);
            let range = f.range(&cell);
            prop_assert!(range.contains(f.value(p)) || (!f.is_between(p) && range.lo <= d.v), "{range:?} lacks {}", d.v);
            let s = f.slopes(&cell).unwrap();
            let g = d.g.to_array();
            for k in 0..3 {
                let within = Interval::new(s.gradient[k].lo - 1e-9, s.gradient[k].hi + 1e-9);
                prop_assert!(within.contains(g[k]), "{profile:?} {k}: {within:?} lacks {}", g[k]);
            }
            // Off the lines where it ends, which are a jump of rounding's size.
            let e = 1e-6;
            let differences = DVec3::AXES.map(|a| (f.value(p + a * e) - f.value(p - a * e)) / (2.0 * e));
            let differences = DVec3::from_array(differences);
            let off = f.sides.iter().all(|s| (radius + s.value(p)).abs() > 1e-4);
            if off && !f.ends_near(p, 1e-5) && band == 0.0 {
                prop_assert!(differences.distance(d.g) < 1e-3 * (1.0 + d.g.length()), "{differences} {}", d.g);
            }
        }

        #[test]
        fn zeros_are_where_the_smooth_maximum_is_zero(
            a in -0.6f64..0.2, b in -0.6f64..0.2, kernel in prop::sample::select(vec![Kernel::Square, Kernel::Cube]),
        ) {
            let k = 0.5;
            let left = (k - (a - b).abs()).max(0.0);
            let added = if kernel == Kernel::Square { left.powi(2) / (4.0 * k) } else { left.powi(3) / (6.0 * k * k) };
            let exact = a.max(b) + added;
            prop_assume!(exact.abs() > 1e-9);
            let max = SmoothMax { kernel, width: k, band: 0.0 };
            prop_assert!((max.between(a, b) - exact).abs() < 1e-15);
            let zeros = fillet(Profile::Zeros(kernel), k, 0.0);
            let joined = zeros.joined([a, b], zeros.length(k + a, k + b)).value;
            if left > 0.0 {
                let by_smooth = smooth(kernel, k, Dual::new(a, DVec3::X), Dual::new(b, DVec3::Y)).v;
                prop_assert!((by_smooth - exact).abs() < 1e-14, "{} {}", by_smooth, exact);
            }
            prop_assert_eq!(a.max(b).max(joined) > 0.0, exact > 0.0, "{} {}", joined, exact);
        }
    }
}
