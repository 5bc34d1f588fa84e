//! How far the surface of a fillet turns in a box.
//!
//! Bounds of a gradient, coordinate by coordinate, forget that a fillet's normal goes from that of one side to that of the other along
//! an arc: both weights are not small at a time. Here the arc is kept. With `u` and `v` the distances to where the fillet ends, its surface
//! is a curve in the plane of `u` and `v`, on which the angle `atan2(v, u)` rises; the box cuts a piece out of it.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::super::slopes::Slopes;
use super::{Fillet, Profile};
use crate::numeric::Interval;
use crate::spatial::Aabb;

/// Rounding of an angle, and the share [`ENDS`](super::ENDS) by which a fillet ends early.
const SLACK: f64 = 1e-6;

/// A lower bound of the derivative along a direction.
fn along(s: &Slopes, d: DVec3) -> f64 {
    let g = s.gradient;
    (g[0].scale(d.x) + g[1].scale(d.y) + g[2].scale(d.z)).lo
}

/// The least angle on the surface where `v` is at least `lo` and `u` at most `hi`, both in radii.
fn least_angle(hi: f64, lo: f64) -> f64 {
    let by_v = if lo >= 0.0 { lo.min(1.0).asin() } else { lo.atan2((2.0 + (1.0 + 3.0 * lo * lo).sqrt()) / 3.0) };
    let by_u = if hi <= 1.0 {
        hi.max(0.0).acos()
    } else {
        // Beyond the end `(2 u - 1)^2 = u^2 + v^2`.
        -(((3.0 * hi - 4.0) * hi + 1.0).sqrt().atan2(hi))
    };
    by_u.max(by_v)
}

/// Angles on the surface of a fillet, from its first end, where `v` is 0, to its second, where `u` is, and beyond.
#[derive(Clone, Copy)]
struct Arc {
    from: f64,
    to: f64,
}

impl Arc {
    /// The least of `a` times the first weight and `b` times the second, for weights of one angle.
    fn least(self, a: f64, b: f64) -> f64 {
        let mut least = f64::INFINITY;
        let (lo, hi) = (self.from.max(0.0), self.to.min(FRAC_PI_2));
        if lo <= hi {
            let at = |t: f64| a * t.cos() + b * t.sin();
            least = if a < 0.0 && b < 0.0 { -a.hypot(b) } else { at(lo).min(at(hi)) };
        }
        // Beyond an end the weight of that side is 2 less the cosine, that of the other one the sine, of the angle from the end.
        let beyond = [(a, b, -self.to, -self.from), (b, a, self.from - FRAC_PI_2, self.to - FRAC_PI_2)];
        for (near, far, first, last) in beyond {
            let first = first.max(0.0);
            if first <= last {
                let at = |t: f64| near * (2.0 - t.cos()) + far * t.sin();
                least = least.min(at(first)).min(at(last));
                let flat = (-far).atan2(near);
                if (first..=last).contains(&flat) {
                    least = least.min(at(flat));
                }
            }
        }
        least
    }
}

/// The same where the smaller distance is in the band, for a band in radii: the larger one is near to a radius there.
fn least_in_band(near: f64, far: f64, band: f64) -> f64 {
    let of_less = |u: f64| (u.hypot(band) - u) / band;
    let off = band * of_less(1.0 - band * band);
    let (low, high) = (1.0 - off, 1.0 + off);
    let turned = 1.0 - low / low.hypot(band);
    let mut least = f64::INFINITY;
    for w in [of_less(low), of_less(high)] {
        for k in [1.0 - turned, 1.0 + turned] {
            least = least.min(near * k + far * w);
        }
    }
    least
}

impl Fillet {
    /// A lower bound of the derivative along a direction on the fillet's surface in a box, if its sides have bounds there; infinite where the
    /// surface does not pass.
    pub(crate) fn least_rise(&self, cell: &Aabb, direction: DVec3) -> Option<f64> {
        let [a, b] = self.sides.each_ref().map(|s| s.slopes(cell));
        let (a, b) = (a?, b?);
        if self.profile != Profile::Circle {
            let [by_a, by_b] = self.by_sides(&a, &b);
            let rises = [along(&a, direction), along(&b, direction)];
            let ends =
                [by_a.lo, by_a.hi].into_iter().flat_map(|s| [by_b.lo, by_b.hi].map(|t| s * rises[0] + t * rises[1]));
            return ends.reduce(f64::min);
        }
        if self.radius <= 0.0 {
            return None;
        }
        let in_radii = |s: &Slopes| (s.value + Interval::point(self.radius)).scale(1.0 / self.radius);
        let (u, v) = (in_radii(&a), in_radii(&b));
        let (rise_a, rise_b) = (along(&a, direction), along(&b, direction));
        let arc = Arc { from: least_angle(u.hi, v.lo) - SLACK, to: FRAC_PI_2 - least_angle(v.hi, u.lo) + SLACK };
        let mut least = arc.least(rise_a, rise_b);
        let band = self.band / self.radius;
        for (near, far, less) in [(rise_a, rise_b, v), (rise_b, rise_a, u)] {
            if band > 0.0 && less.lo <= band && less.hi >= -band {
                least = least.min(least_in_band(near, far, band));
            }
        }
        Some(least)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::super::leaf::Leaf;
    use super::super::{Profile, Side};
    use super::*;

    fn side(leaf: Leaf, number: u32) -> Side {
        Side { leaf, number, negate: false }
    }

    proptest! {
        // Sampled points of the surface in the box never rise less than the bound says.
        #[test]
        fn no_point_of_the_surface_rises_less(
            tilt in -1.5f64..1.5, at in prop::array::uniform2(-1.4f64..1.4), half in 0.02f64..0.6, turn in 0.0f64..6.3,
            r in 0.5f64..1.0, band in prop::sample::select(vec![0.0, 0.1, 0.25]),
        ) {
            let n = DVec3::new(tilt.sin(), tilt.cos(), 0.0);
            let ball = Leaf::Sphere { c: DVec3::new(0.0, 0.0, 4.0) + n * 3.0, r: 5.0 };
            let sides = [side(Leaf::Plane { n: DVec3::X, d: 0.0 }, 0), side(ball, 1)];
            let f = Fillet { sides, radius: r, profile: Profile::Circle, span: r, band: band * r, rest: None };
            let c = DVec3::new(at[0], at[1], 0.1);
            let cell = Aabb::new(c - half, c + half);
            let direction = DVec3::new(turn.cos(), turn.sin(), 0.0);
            let bound = f.least_rise(&cell, direction).unwrap();
            for i in 0..40 {
                for j in 0..5 {
                    let side = |k: i32, n: i32| half * (2.0 * f64::from(k) / f64::from(n - 1) - 1.0);
                    let (y, z) = (c.y + side(i, 40), c.z + side(j, 5));
                    let p = |x: f64| DVec3::new(x, y, z);
                    // Along x, 200 steps: a change of sign is on the surface.
                    for k in 0..200 {
                        let (lo, hi) = (p(c.x + side(k, 201)), p(c.x + side(k + 1, 201)));
                        let (v, w) = (f.value(lo), f.value(hi));
                        if (v < 0.0) != (w < 0.0) {
                            let q = lo.lerp(hi, v / (v - w));
                            let slack = 0.05 * half + 1e-3;
                            prop_assert!(f.gradient(q).g.dot(direction) >= bound - slack, "{q} {bound}");
                        }
                    }
                }
            }
        }
    }
}
