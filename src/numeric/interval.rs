//! Interval arithmetic with outward rounding: every operation returns an interval that holds the exact result, and the
//! result of the same operation in floating point, for all arguments in the operands.
//!
//! NaN never appears as a bound. Where an operation is undefined on part of its argument the result is
//! [`Interval::ALL`], so that nothing is concluded from it and the place is looked at point by point.

use super::LAST_PLACES;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops;

/// The closed interval `lo..=hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower bound.
    pub lo: f64,
    /// Upper bound.
    pub hi: f64,
}

/// Bounds of library functions (sin, exp, ...) are widened by this many units in the last place: their error is at most
/// one unit in every libm in use, and two units in [`vector`](super::vector).
const LIBM_ULPS: u32 = 4;

fn wide(lo: f64, hi: f64) -> Interval {
    if lo.is_nan() || hi.is_nan() { Interval::ALL } else { Interval { lo: lo.next_down(), hi: hi.next_up() } }
}

fn libm(mut lo: f64, mut hi: f64) -> Interval {
    for _ in 0..LIBM_ULPS {
        lo = lo.next_down();
        hi = hi.next_up();
    }
    if lo.is_nan() || hi.is_nan() { Interval::ALL } else { Interval { lo, hi } }
}

/// Product with the convention `0 * inf = 0`: a bound at infinity stands for arbitrarily large numbers, not for infinity.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Interval {
    /// Everything.
    pub const ALL: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// The number 0.
    pub const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };
    /// The number 1.
    pub const ONE: Interval = Interval { lo: 1.0, hi: 1.0 };

    /// The interval between two bounds; [`ALL`](Self::ALL) if one of them is NaN.
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::ALL } else { Self { lo, hi } }
    }

    /// One number.
    pub fn point(v: f64) -> Self {
        Self::new(v, v)
    }

    /// Whether the number lies in the interval.
    pub fn contains(&self, v: f64) -> bool {
        self.lo <= v && v <= self.hi
    }

    /// Product with a number.
    pub fn scale(self, k: f64) -> Self {
        if k == 0.0 {
            return Self::point(0.0);
        }
        let (a, b) = if k > 0.0 { (self.lo, self.hi) } else { (self.hi, self.lo) };
        let r = wide(times(a, k), times(b, k));
        // A bound that is zero stays.
        Self { lo: if a == 0.0 { 0.0 } else { r.lo }, hi: if b == 0.0 { 0.0 } else { r.hi } }
    }

    /// The square.
    pub fn square(self) -> Self {
        let (a, b) = (self.lo * self.lo, self.hi * self.hi);
        if self.lo >= 0.0 {
            Self { lo: a.next_down().max(0.0), hi: b.next_up() }
        } else if self.hi <= 0.0 {
            Self { lo: b.next_down().max(0.0), hi: a.next_up() }
        } else {
            Self { lo: 0.0, hi: a.max(b).next_up() }
        }
    }

    /// Absolute value.
    pub fn abs(self) -> Self {
        if self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            Self { lo: -self.hi, hi: -self.lo }
        } else {
            Self { lo: 0.0, hi: self.hi.max(-self.lo) }
        }
    }

    /// Square root; everything when a negative number lies inside.
    pub fn sqrt(self) -> Self {
        if self.lo < 0.0 {
            return Self::ALL;
        }
        let r = wide(self.lo.sqrt(), self.hi.sqrt());
        Self { lo: r.lo.max(0.0), hi: r.hi }
    }

    /// Exponential.
    pub fn exp(self) -> Self {
        let r = libm(self.lo.exp(), self.hi.exp());
        Self { lo: r.lo.max(0.0), hi: r.hi }
    }

    /// Natural logarithm; everything when a negative number lies inside. That of zero is minus infinity.
    pub fn ln(self) -> Self {
        if self.lo < 0.0 {
            return Self::ALL;
        }
        libm(self.lo.ln(), self.hi.ln())
    }

    /// Sine.
    pub fn sin(self) -> Self {
        Self::new(self.lo - FRAC_PI_2, self.hi - FRAC_PI_2).widened_for_trig().cos()
    }

    fn widened_for_trig(self) -> Self {
        wide(self.lo, self.hi)
    }

    /// Cosine.
    pub fn cos(self) -> Self {
        /// Beyond this the spacing of floats hides which half period an argument is in.
        const LARGE: f64 = 1e8;
        if !(self.lo > -LARGE && self.hi < LARGE) || self.hi - self.lo >= 2.0 * PI {
            return Self { lo: -1.0, hi: 1.0 };
        }
        let r = libm(self.lo.cos().min(self.hi.cos()), self.lo.cos().max(self.hi.cos()));
        let slack = 1e-8; // far wider than the rounding of k * pi below LARGE; only makes the result larger
        let (first, last) = (((self.lo - slack) / PI).ceil() as i64, ((self.hi + slack) / PI).floor() as i64);
        let (mut lo, mut hi) = (r.lo.max(-1.0), r.hi.min(1.0));
        for k in first..=last {
            if k % 2 == 0 {
                hi = 1.0;
            } else {
                lo = -1.0;
            }
        }
        Self { lo, hi }
    }

    /// Tangent; everything when a pole lies inside.
    pub fn tan(self) -> Self {
        let (s, c) = (self.sin(), self.cos());
        if c.contains(0.0) { Self::ALL } else { s / c }
    }

    /// Less whole turns, from -pi to pi; all of that where a jump may lie inside.
    pub fn wrap(self) -> Self {
        self.turned(0.0)
    }

    /// Less whole turns, from `ahead - pi` to `ahead + pi`; all of that where a jump may lie inside.
    pub fn turned(self, ahead: f64) -> Self {
        /// Wider than the rounding of the number of turns below `LARGE`; only makes the result larger.
        const SLACK: f64 = 1e-8;
        /// Turns beyond which more than that is rounded.
        const LARGE: f64 = 1e7;
        let turns = |x: f64, slack: f64| ((x - ahead) / TAU + slack).round();
        let (first, last) = (turns(self.lo, -SLACK), turns(self.hi, SLACK));
        if first == last && first.abs() < LARGE {
            self - Self::point(TAU * first)
        } else {
            wide((ahead - PI).next_down(), (ahead + PI).next_up())
        }
    }

    /// [`wrap`](Self::wrap) where that is at most `most` both ways, and from there straight back to 0 at half a turn.
    pub fn swing(self, most: f64) -> Self {
        // The slack is more than the rounding of angles, of which the way back makes tens of times as much; only makes the result larger.
        let within = |i: &Self, reach: f64| i.lo >= -reach && i.hi <= reach;
        let back = most / (PI - most);
        let (near, far) = (self.wrap(), (self - Self::point(PI)).wrap());
        if within(&near, most) {
            return near;
        }
        // What it is at its ends, and at turning points between.
        let hull = |i: &Self, at: &dyn Fn(f64) -> f64, turns: [f64; 2]| {
            let between = turns.into_iter().filter(|t| i.lo - LAST_PLACES <= *t && *t <= i.hi + LAST_PLACES);
            let (lo, hi) = [i.lo, i.hi]
                .into_iter()
                .chain(between)
                .map(at)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
            Self { lo: lo - LAST_PLACES, hi: hi + LAST_PLACES }
        };
        let from_near = |w: f64| if w.abs() > most { (PI - w.abs()).copysign(w) * back } else { w };
        let from_far = |v: f64| if v.abs() <= PI - most { -v * back } else { v - PI.copysign(v) };
        if near.hi - near.lo < PI {
            hull(&near, &from_near, [-most, most])
        } else if far.hi - far.lo < PI {
            hull(&far, &from_far, [most - PI, PI - most])
        } else {
            wide(-most, most)
        }
    }

    /// The distance of an angle in radians from whole turns, 0 to pi.
    pub fn fold(self) -> Self {
        let (near, far) = (self.wrap(), (self - Self::point(PI)).wrap());
        let (a, b) = (near.abs(), (Self::point(PI) - far.abs()));
        Self { lo: a.lo.max(b.lo).max(0.0), hi: a.hi.min(b.hi) }
    }

    /// `k` times what is negative, and what is not as it is; `k` is at least 1.
    pub fn steepened(self, k: f64) -> Self {
        let r = wide(self.lo * k, self.hi * k);
        Self { lo: if self.lo < 0.0 { r.lo } else { self.lo }, hi: if self.hi < 0.0 { r.hi } else { self.hi } }
    }

    /// Inverse sine; everything when a number that has none lies inside.
    pub fn asin(self) -> Self {
        if !(self.lo >= -1.0 && self.hi <= 1.0) {
            return Self::ALL;
        }
        libm(self.lo.asin(), self.hi.asin())
    }

    /// Inverse cosine; everything when a number that has none lies inside.
    pub fn acos(self) -> Self {
        if !(self.lo >= -1.0 && self.hi <= 1.0) {
            return Self::ALL;
        }
        let r = libm(self.hi.acos(), self.lo.acos());
        Self { lo: r.lo.max(0.0), hi: r.hi }
    }

    /// Hyperbolic sine.
    pub fn sinh(self) -> Self {
        libm(self.lo.sinh(), self.hi.sinh())
    }

    /// Hyperbolic cosine.
    pub fn cosh(self) -> Self {
        let a = self.abs();
        let r = libm(a.lo.cosh(), a.hi.cosh());
        Self { lo: r.lo.max(1.0), hi: r.hi }
    }

    /// Hyperbolic tangent.
    pub fn tanh(self) -> Self {
        let r = libm(self.lo.tanh(), self.hi.tanh());
        Self { lo: r.lo.max(-1.0), hi: r.hi.min(1.0) }
    }

    /// The largest whole numbers that are not above.
    pub fn floor(self) -> Self {
        Self { lo: self.lo.floor(), hi: self.hi.floor() }
    }

    /// -1, 0 or 1.
    pub fn sign(self) -> Self {
        let of = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        Self { lo: of(self.lo), hi: of(self.hi) }
    }

    /// `self - m floor(self / m)`: as tight as a difference where the quotient passes no whole number, else all between 0 and
    /// `m`. Everything when `m` may be zero.
    pub fn modulo(self, m: Self) -> Self {
        if m.contains(0.0) {
            return Self::ALL;
        }
        let steps = (self / m).floor();
        let all = Self { lo: m.lo.min(0.0), hi: m.hi.max(0.0) };
        if steps.lo != steps.hi || !steps.lo.is_finite() {
            return all;
        }
        let rest = self - m.scale(steps.lo);
        Self { lo: rest.lo.max(all.lo).min(all.hi), hi: rest.hi.min(all.hi).max(all.lo) }
    }

    /// Angle of the point (x, y) with `y` in `self`.
    pub fn atan2(self, x: Self) -> Self {
        if x.lo <= 0.0 && self.contains(0.0) {
            return Self { lo: -PI.next_up(), hi: PI.next_up() };
        }
        let mut lo = f64::INFINITY;
        let mut hi = f64::NEG_INFINITY;
        for y in [self.lo, self.hi] {
            for x in [x.lo, x.hi] {
                let a = y.atan2(x);
                lo = lo.min(a);
                hi = hi.max(a);
            }
        }
        libm(lo, hi)
    }

    /// Pointwise minimum.
    pub fn min(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Pointwise maximum.
    pub fn max(self, other: Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The smallest interval around both.
    pub fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// What lies in both; `self` where rounding leaves nothing.
    pub fn within(self, other: Self) -> Self {
        let both = Self { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) };
        if both.lo <= both.hi { both } else { self }
    }

    /// Integer power.
    pub fn powi(self, n: i32) -> Self {
        if n < 0 {
            return Self::point(1.0) / self.powi(-n);
        }
        if n == 0 {
            return Self::point(1.0);
        }
        if n == 2 {
            return self.square();
        }
        let (a, b) = (self.lo.powi(n), self.hi.powi(n));
        // powi multiplies up to n times, each time half a unit off
        let widen = |lo: f64, hi: f64| {
            let e = f64::from(n + 2) * f64::EPSILON;
            Self::new(lo - lo.abs() * e, hi + hi.abs() * e)
        };
        if n % 2 == 1 || self.lo >= 0.0 {
            widen(a, b)
        } else if self.hi <= 0.0 {
            widen(b, a)
        } else {
            widen(0.0, a.max(b))
        }
    }

    /// Real power `self ** e`; everything when a negative base meets an exponent that is not one integer.
    pub fn pow(self, e: Self) -> Self {
        if e.lo == e.hi && e.lo.fract() == 0.0 && e.lo.abs() <= 64.0 {
            return self.powi(e.lo as i32);
        }
        if self.lo < 0.0 {
            return Self::ALL;
        }
        let mut lo = f64::INFINITY;
        let mut hi = f64::NEG_INFINITY;
        for b in [self.lo, self.hi] {
            for e in [e.lo, e.hi] {
                let v = b.powf(e);
                lo = lo.min(v);
                hi = hi.max(v);
            }
        }
        // b^e is monotonic in each argument on b < 1 and on b > 1; at b = 1 it is 1
        if self.contains(1.0) {
            lo = lo.min(1.0);
            hi = hi.max(1.0);
        }
        let r = libm(lo, hi);
        Self { lo: r.lo.max(0.0), hi: r.hi }
    }

    /// Length of the vector (a, b).
    pub fn hypot(self, other: Self) -> Self {
        let (a, b) = (self.abs(), other.abs());
        let r = libm(a.lo.hypot(b.lo), a.hi.hypot(b.hi));
        Self { lo: r.lo.max(0.0), hi: r.hi }
    }
}

impl ops::Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl ops::Add for Interval {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let r = wide(self.lo + o.lo, self.hi + o.hi);
        // What adds up from numbers that are not negative is not.
        if self.lo >= 0.0 && o.lo >= 0.0 { Self { lo: r.lo.max(0.0), hi: r.hi } } else { r }
    }
}

impl ops::Sub for Interval {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        wide(self.lo - o.hi, self.hi - o.lo)
    }
}

impl ops::Mul for Interval {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        // Which bounds meet follows from the signs; where both may have either, two pairs compete.
        let ([a, b], [c, d]) = ([self.lo, self.hi], [o.lo, o.hi]);
        let of = |lo: [f64; 2], hi: [f64; 2]| wide(times(lo[0], lo[1]), times(hi[0], hi[1]));
        // Bounds that are zero stay: a power of a length has to have a base that is not negative.
        let positive = |r: Self| Self { lo: r.lo.max(0.0), ..r };
        let negative = |r: Self| Self { hi: r.hi.min(0.0), ..r };
        match (a >= 0.0, b <= 0.0, c >= 0.0, d <= 0.0) {
            (true, _, true, _) => positive(of([a, c], [b, d])),
            (true, _, _, true) => negative(of([b, c], [a, d])),
            (_, true, true, _) => negative(of([a, d], [b, c])),
            (_, true, _, true) => positive(of([b, d], [a, c])),
            (true, ..) => of([b, c], [b, d]),
            (_, true, ..) => of([a, d], [a, c]),
            (_, _, true, _) => of([a, d], [b, d]),
            (_, _, _, true) => of([b, c], [a, c]),
            _ if (a + b + c + d).is_nan() => Self::ALL,
            _ => wide(times(a, d).min(times(b, c)), times(a, c).max(times(b, d))),
        }
    }
}

impl ops::Div for Interval {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        if o.contains(0.0) {
            return Self::ALL;
        }
        let r = wide(1.0 / o.hi, 1.0 / o.lo);
        self * if o.lo > 0.0 { Self { lo: r.lo.max(0.0), hi: r.hi } } else { Self { lo: r.lo, hi: r.hi.min(0.0) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_interval() -> impl Strategy<Value = (Interval, f64)> {
        (-20.0f64..20.0, 0.0f64..10.0, 0.0f64..=1.0).prop_map(|(lo, w, t)| {
            let i = Interval::new(lo, lo + w);
            (i, (lo + w * t).clamp(i.lo, i.hi))
        })
    }

    proptest! {
        #[test]
        fn unary_results_hold_every_sample((i, v) in any_interval(), n in -4i32..6) {
            for (r, f) in [
                (i.square(), v * v), (i.abs(), v.abs()), (i.sqrt(), v.sqrt()), (i.exp(), v.exp()), (i.ln(), v.ln()),
                (i.sin(), v.sin()), (i.cos(), v.cos()), (i.wrap(), v - 2.0 * PI * (v / (2.0 * PI)).round()), (i.tan(), v.tan()), (-i, -v), (i.powi(n), v.powi(n)),
                (i.scale(-3.7), v * -3.7), (i.asin(), v.asin()), (i.acos(), v.acos()), (i.sinh(), v.sinh()),
                (i.cosh(), v.cosh()), (i.tanh(), v.tanh()), (i.floor(), v.floor()), (i.sign(), v.signum()),
            ] {
                prop_assert!(f.is_nan() || r.contains(f), "{i:?} {v} -> {r:?} lacks {f}");
            }
        }

        #[test]
        fn binary_results_hold_every_sample((i, v) in any_interval(), (j, w) in any_interval()) {
            for (r, f) in [
                (i + j, v + w), (i - j, v - w), (i * j, v * w), (i / j, v / w), (i.min(j), v.min(w)),
                (i.max(j), v.max(w)), (i.hypot(j), v.hypot(w)), (i.atan2(j), v.atan2(w)), (i.pow(j), v.powf(w)),
                (i.modulo(j), (v - w * (v / w).floor()).clamp(w.min(0.0), w.max(0.0))),
            ] {
                prop_assert!(f.is_nan() || r.contains(f), "{i:?} {j:?} {v} {w} -> {r:?} lacks {f}");
            }
        }
    }

    #[test]
    fn what_swings_back_is_bounded_on_its_way_back() {
        let most = 17.0 * PI / 18.0;
        let swing = |a: f64| {
            let w = a - 2.0 * PI * (a / (2.0 * PI)).round();
            if w.abs() > most { (PI - w.abs()).copysign(w) * 17.0 } else { w }
        };
        for k in 0..2000 {
            let (lo, width) = (0.01 * f64::from(k) - 10.0, 0.003 * f64::from(k % 90));
            let range = Interval::new(lo, lo + width).swing(most);
            let values: Vec<f64> = (0..=100).map(|i| swing(lo + width * f64::from(i) / 100.0)).collect();
            let [least, largest] = [f64::min, f64::max].map(|f| values.iter().copied().reduce(f).unwrap());
            let holds = range.lo <= least + 1e-12 && largest <= range.hi + 1e-12;
            assert!(holds, "{lo} {width}: {range:?} {least} {largest}");
            // Samples miss a turning point by half their distance.
            let near = 17.0 * 0.005 * width + 1e-9;
            assert!(
                least - range.lo <= near && range.hi - largest <= near,
                "{lo} {width}: {range:?} {least} {largest}"
            );
        }
    }

    #[test]
    fn the_logarithm_is_bounded_above_from_zero_on() {
        let r = Interval::new(0.0, 2.0).ln();
        assert!(r.lo == f64::NEG_INFINITY && (r.hi - 2f64.ln()).abs() < 1e-14, "{r:?}");
        assert_eq!(Interval::new(-0.1, 2.0).ln(), Interval::ALL);
    }

    #[test]
    fn bounds_that_are_zero_stay_so_and_powers_of_lengths_are_bounded() {
        let a = Interval::new(-1.0, 6.0).abs();
        let three = Interval::point(3.0);
        for r in [a * three, three * a, a / three, a.scale(0.3), -a.scale(-0.3), a + a, a * a, -(a * -three)] {
            assert!(r.lo == 0.0 && r.pow(Interval::point(2.5)).lo == 0.0, "{r:?}");
        }
        let r = (a / three).pow(Interval::point(2.5));
        assert!(r.contains(2f64.powf(2.5)) && r.hi < 5.66, "{r:?}");
        let far = Interval::new(3.0, f64::INFINITY).abs() / three;
        assert!(far.pow(Interval::point(2.5)).lo > 0.99);
    }

    #[test]
    fn half_infinite_boxes_bound_a_paraboloid() {
        let x = Interval::new(3.0, f64::INFINITY);
        let y = Interval::ALL;
        let r = Interval::point(1.0) - (x.square() + y.square());
        assert!(r.hi < -7.9 && r.lo == f64::NEG_INFINITY);
    }
}
