//! Elementary functions for many numbers at once, at most 2 units in the last place off.
//!
//! They are sums, products and choices of IEEE numbers without a branch, so that compilers make vectors of them, and none is
//! contracted: a number alone and one in a batch give the same bits on every processor. Arguments outside of the range of a
//! function's polynomial go to the standard library one by one.
//!
//! Coefficients interpolate the function that a comment names at the Chebyshev nodes of its interval. They were computed with
//! 60 decimal digits and rounded. Each comment says how far the polynomial is from the function, by the size of its result.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, LOG2_E, PI};

/// Adding it and taking it off again rounds to a whole number, whose two's complement are the lowest bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Half pi in three parts: multiples of the first two below a million are exact.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Logarithm of two in two parts: multiples of the first below two thousand are exact.
const LN_2: [f64; 2] = [0.693_147_180_559_890_3, 5.497_923_018_708_371e-14];

/// What half pi has beyond its double.
const HALF_PI_REST: f64 = 6.123_233_995_736_766e-17;

/// `(sin(r) / r - 1) / z` with `z = r r` up to `(pi/4)^2`; within 2^-66.
const SIN: [f64; 7] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_333_331,
    -0.000_198_412_698_412_650_63,
    2.755_731_921_933_731_2e-6,
    -2.505_210_623_180_283_7e-8,
    1.605_853_151_679_775_8e-10,
    -7.586_691_094_197_958e-13,
];

/// `(cos(r) - 1 + z / 2) / z^2` with `z = r r` up to `(pi/4)^2`; within 2^-60.
const COS: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_739_8,
    2.480_158_729_876_456e-5,
    -2.755_731_727_114_514_4e-7,
    2.087_614_614_655_861e-9,
    -1.138_262_364_747_460_4e-11,
];

/// `(exp(r) - 1 - r) / r^2` for `r` from `-ln(2)/2` to `ln(2)/2`; within 2^-62.
const EXP: [f64; 11] = [
    0.5,
    0.166_666_666_666_666_7,
    0.041_666_666_666_666_67,
    0.008_333_333_333_326_12,
    0.001_388_888_888_888_373_7,
    0.000_198_412_698_748_739_75,
    2.480_158_732_558_584e-5,
    2.755_725_533_255_441e-6,
    2.755_727_359_479_941_3e-7,
    2.510_524_515_390_137e-8,
    2.091_470_706_961_235_5e-9,
];

/// `(log((1 + s) / (1 - s)) / s - 2) / z` with `z = s s` up to 0.0294; within 2^-57.
const LOG: [f64; 7] = [
    0.666_666_666_666_667,
    0.399_999_999_998_994_9,
    0.285_714_286_259_825_5,
    0.222_222_111_336_420_84,
    0.181_828_892_092_665_95,
    0.153_317_188_082_800_7,
    0.146_164_841_983_666_03,
];

/// `(atan(u) / u - 1) / z` with `z = u u` up to `tan(pi/8)^2`; within 2^-62.
const ATAN: [f64; 12] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_998_04,
    -0.142_857_142_856_598_06,
    0.111_111_111_051_534_29,
    -0.090_909_087_534_004_99,
    0.076_922_963_721_299_64,
    -0.066_664_248_336_135_52,
    0.058_789_283_985_172_32,
    -0.052_304_498_567_092_406,
    0.045_515_730_866_641_91,
    -0.034_570_044_186_095_536,
    0.016_285_183_029_865_667,
];

/// Where an eighth of a turn is halved.
const TAN_EIGHTH: f64 = 0.414_213_562_373_095_03;

/// Sines and cosines of larger numbers are the standard library's.
const LARGEST_ANGLE: f64 = 1e6;

/// Exponentials of larger numbers are the standard library's, also below zero.
const LARGEST_POWER: f64 = 700.0;

/// A number that is its own sine.
const OWN_SINE: f64 = 1e-8;

/// Sides of a triangle are squared as they are between these.
const SQUARED: [f64; 2] = [1e-140, 1e150];

/// Numbers whose sums and quotients neither overflow nor lose digits.
const DIVIDED: [f64; 2] = [f64::MIN_POSITIVE, 1e300];

#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let mut sum = c[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum * x + c[k];
    }
    sum
}

/// Sine and cosine of what an angle has beyond the nearest multiple of a quarter turn, and the multiple in the lowest bits.
#[inline(always)]
fn reduced(x: f64) -> (f64, f64, u64) {
    let shifted = x * FRAC_2_PI + ROUNDER;
    let k = shifted - ROUNDER;
    let (a, w) = (x - k * HALF_PI[0], k * HALF_PI[1]);
    let high = a - w;
    let low = ((a - high) - w) - k * HALF_PI[2];
    // the exact sum of both parts, whichever is larger
    let r = high + low;
    let part = r - high;
    let rest = (high - (r - part)) + (low - part);
    let z = r * r;
    let sin = r + (r * (z * polynomial(&SIN, z)) + rest);
    let half = 0.5 * z;
    let near = 1.0 - half;
    let cos = near + (((1.0 - near) - half) + (z * z * polynomial(&COS, z) - r * rest));
    (sin, cos, shifted.to_bits())
}

/// The one of a sine and cosine that so many quarter turns make the sine.
#[inline(always)]
fn turned(sin: f64, cos: f64, quarters: u64) -> f64 {
    let v = if quarters & 1 == 0 { sin } else { cos };
    f64::from_bits(v.to_bits() ^ ((quarters & 2) << 62))
}

#[inline(always)]
fn fast_sin(x: f64) -> f64 {
    let (sin, cos, q) = reduced(x);
    if x.abs() < OWN_SINE { x } else { turned(sin, cos, q) }
}

#[inline(always)]
fn fast_cos(x: f64) -> f64 {
    let (sin, cos, q) = reduced(x);
    turned(sin, cos, q.wrapping_add(1))
}

#[inline(always)]
fn is_angle(x: f64) -> bool {
    x.abs() <= LARGEST_ANGLE
}

#[inline(always)]
fn fast_exp(x: f64) -> f64 {
    let shifted = x * LOG2_E + ROUNDER;
    let k = shifted - ROUNDER;
    let r = (x - k * LN_2[0]) - k * LN_2[1];
    let v = 1.0 + (r + r * r * polynomial(&EXP, r));
    f64::from_bits(v.to_bits().wrapping_add(shifted.to_bits() << 52))
}

#[inline(always)]
fn is_power(x: f64) -> bool {
    x.abs() <= LARGEST_POWER
}

#[inline(always)]
fn fast_ln(x: f64) -> f64 {
    let one = 1f64.to_bits();
    /// Bits of the root of one half.
    const LEAST: u64 = 0x3fe6_a09e_667f_3bcd;
    /// Its last bit counts 1: what is put there is a whole number.
    const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
    let bits = x.to_bits();
    let scaled = bits.wrapping_add(one - LEAST) & !((1 << 52) - 1);
    let f = f64::from_bits(bits.wrapping_sub(scaled).wrapping_add(one)) - 1.0;
    let e = f64::from_bits((scaled >> 52) | TWO_TO_52.to_bits()) - (TWO_TO_52 + 1023.0);
    let s = f / (2.0 + f);
    let z = s * s;
    let half = 0.5 * f * f;
    let rest = s * (half + z * polynomial(&LOG, z));
    // log(1 + f) is 2 s + s z P, and 2 s is f - s f, whose last part is f f / 2 - s f f / 2
    e * LN_2[0] - ((half - (rest + e * LN_2[1])) - f)
}

#[inline(always)]
fn has_ln(x: f64) -> bool {
    (f64::MIN_POSITIVE..=f64::MAX).contains(&x)
}

#[inline(always)]
fn fast_atan2(y: f64, x: f64) -> f64 {
    let (a, b) = (y.abs(), x.abs());
    let steep = a > b;
    let (low, high) = if steep { (b, a) } else { (a, b) };
    let beyond = low > TAN_EIGHTH * high;
    let (above, below) = if beyond { (low - high, low + high) } else { (low, high) };
    let u = above / below;
    let z = u * u;
    let v = u + u * (z * polynomial(&ATAN, z));
    let v = if beyond { FRAC_PI_4 + (v + 0.5 * HALF_PI_REST) } else { v };
    let v = if steep { FRAC_PI_2 - (v - HALF_PI_REST) } else { v };
    let v = if x < 0.0 { PI - (v - 2.0 * HALF_PI_REST) } else { v };
    v.copysign(y)
}

#[inline(always)]
fn has_angle(y: f64, x: f64) -> bool {
    let (a, b) = (y.abs(), x.abs());
    let large = if a > b { a } else { b };
    (a <= DIVIDED[1]) & (DIVIDED[0]..=DIVIDED[1]).contains(&large)
}

#[inline(always)]
fn fast_hypot(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

#[inline(always)]
fn is_squared(a: f64, b: f64) -> bool {
    let (a, b) = (a.abs(), b.abs());
    let large = if a > b { a } else { b };
    (SQUARED[0]..=SQUARED[1]).contains(&large) & (a <= SQUARED[1])
}

macro_rules! of_one {
    ($name:ident, $many:ident, $fast:ident, $within:ident, $exact:expr, $what:literal) => {
        #[doc = $what]
        pub fn $name(x: f64) -> f64 {
            if $within(x) { $fast(x) } else { $exact(x) }
        }

        /// The same for many numbers, bit by bit.
        #[inline(always)]
        pub(crate) fn $many(x: &[f64], out: &mut [f64]) {
            let x = &x[..out.len()];
            let mut within = true;
            for k in 0..out.len() {
                within &= $within(x[k]);
            }
            for k in 0..out.len() {
                out[k] = $fast(x[k]);
            }
            if !within {
                for k in 0..out.len() {
                    out[k] = $name(x[k]);
                }
            }
        }
    };
}

macro_rules! of_two {
    ($name:ident, $many:ident, $fast:ident, $within:ident, $exact:expr, $what:literal) => {
        #[doc = $what]
        #[inline]
        pub fn $name(a: f64, b: f64) -> f64 {
            if $within(a, b) { $fast(a, b) } else { $exact(a, b) }
        }

        /// The same for many pairs, bit by bit.
        #[inline(always)]
        pub(crate) fn $many(a: &[f64], b: &[f64], out: &mut [f64]) {
            let (a, b) = (&a[..out.len()], &b[..out.len()]);
            let mut within = true;
            for k in 0..out.len() {
                within &= $within(a[k], b[k]);
            }
            for k in 0..out.len() {
                out[k] = $fast(a[k], b[k]);
            }
            if !within {
                for k in 0..out.len() {
                    out[k] = $name(a[k], b[k]);
                }
            }
        }
    };
}

of_one!(sin, sin_many, fast_sin, is_angle, f64::sin, "Sine of an angle in radians; NaN of an infinite one.");
of_one!(cos, cos_many, fast_cos, is_angle, f64::cos, "Cosine of an angle in radians; NaN of an infinite one.");
of_one!(exp, exp_many, fast_exp, is_power, f64::exp, "Exponential; infinite where it overflows.");
of_one!(ln, ln_many, fast_ln, has_ln, f64::ln, "Natural logarithm; NaN below 0, and at 0 minus infinity.");
of_two!(atan2, atan2_many, fast_atan2, has_angle, f64::atan2, "Angle of the point (b, a) in radians, from -pi to pi.");
of_two!(hypot, hypot_many, fast_hypot, is_squared, f64::hypot, "Length of the vector (a, b).");

/// [`sin`] and [`cos`] of an angle, bit by bit.
pub fn sin_cos(x: f64) -> (f64, f64) {
    if !is_angle(x) {
        return (x.sin(), x.cos());
    }
    let (s, c, q) = reduced(x);
    (if x.abs() < OWN_SINE { x } else { turned(s, c, q) }, turned(s, c, q.wrapping_add(1)))
}

/// A whole power by squaring: as many roundings as there are products.
#[inline(always)]
pub fn powi(mut x: f64, n: i32) -> f64 {
    let mut rest = n.unsigned_abs();
    let mut product = 1.0;
    loop {
        if rest & 1 == 1 {
            product *= x;
        }
        rest >>= 1;
        if rest == 0 {
            return if n < 0 { 1.0 / product } else { product };
        }
        x *= x;
    }
}

/// The same for many numbers, bit by bit; `squares` is room for as many.
#[inline(always)]
pub(crate) fn powi_many(x: &[f64], n: i32, squares: &mut [f64], out: &mut [f64]) {
    let (x, squares) = (&x[..out.len()], &mut squares[..out.len()]);
    squares.copy_from_slice(x);
    out.fill(1.0);
    let mut rest = n.unsigned_abs();
    loop {
        if rest & 1 == 1 {
            for k in 0..out.len() {
                out[k] *= squares[k];
            }
        }
        rest >>= 1;
        if rest == 0 {
            break;
        }
        for v in squares.iter_mut() {
            *v *= *v;
        }
    }
    if n < 0 {
        for v in out {
            *v = 1.0 / *v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECIAL: [f64; 20] = [
        0.0,
        -0.0,
        5e-324,
        -5e-324,
        1e-310,
        f64::MIN_POSITIVE,
        1e-200,
        -1e-20,
        1e-8,
        1.0,
        -1.0,
        0.5,
        -700.5,
        709.9,
        1e6,
        -1e17,
        1e305,
        f64::MAX,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];

    /// Random numbers from 0 to 1.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        /// Up to a power of two, evenly by its exponent, of either sign.
        fn number(&mut self, most: f64) -> f64 {
            let size = 2f64.powf(most * (2.0 * self.next() - 1.0));
            if self.next() < 0.5 { -size } else { size }
        }
    }

    /// The distance of two numbers in units in the last place of the larger; NaN is as far from NaN as nothing.
    fn ulps(a: f64, b: f64) -> f64 {
        if a.is_nan() && b.is_nan() || a.to_bits() == b.to_bits() {
            return 0.0;
        }
        if a == 0.0 && b == 0.0 || !a.is_finite() || !b.is_finite() {
            return f64::INFINITY;
        }
        let size = a.abs().max(b.abs());
        (a - b).abs() / (size.next_up() - size)
    }

    /// The standard library is at most one unit off; no more than two are allowed to both together.
    #[track_caller]
    fn assert_near(ours: f64, std: f64, at: &dyn std::fmt::Debug) {
        assert!(ulps(ours, std) <= 2.0, "{ours:?} is not {std:?} at {at:?}");
    }

    fn angles(random: &mut Random) -> Vec<f64> {
        let mut all = SPECIAL.to_vec();
        all.push(f64::NAN);
        for _ in 0..200_000 {
            all.extend([random.number(20.0), 10.0 * random.next() - 5.0, random.number(3.0)]);
        }
        for k in 0..200_000 {
            let near = f64::from(k) * FRAC_PI_2 / 2.0;
            all.extend([near, -near, near.next_up(), near.next_down()]);
        }
        all
    }

    #[test]
    fn sines_and_cosines_are_the_library_s_within_two_units() {
        for x in angles(&mut Random(1)) {
            assert_near(sin(x), x.sin(), &x);
            assert_near(cos(x), x.cos(), &x);
            assert!(!(sin(x).abs() > 1.0) && !(cos(x).abs() > 1.0), "{x}");
            let (s, c) = sin_cos(x);
            assert_eq!([s.to_bits(), c.to_bits()], [sin(x).to_bits(), cos(x).to_bits()], "{x}");
        }
    }

    #[test]
    fn exponentials_and_logarithms_are_the_library_s_within_two_units() {
        let mut random = Random(2);
        let mut all = SPECIAL.to_vec();
        all.push(f64::NAN);
        for _ in 0..300_000 {
            all.extend([random.number(1000.0), 1500.0 * random.next() - 750.0, 1.0 + random.number(10.0) * 1e-4]);
            all.extend([0.5 + random.next(), random.number(2.0)]);
        }
        for x in all {
            assert_near(exp(x), x.exp(), &x);
            assert_near(ln(x), x.ln(), &x);
        }
    }

    #[test]
    fn angles_and_lengths_are_the_library_s_within_two_units() {
        let mut random = Random(3);
        let mut all = Vec::new();
        for a in SPECIAL {
            all.extend(SPECIAL.map(|b| (a, b)));
            all.extend([(a, f64::NAN), (f64::NAN, a)]);
        }
        for _ in 0..300_000 {
            all.push((random.number(1000.0), random.number(1000.0)));
            all.push((random.number(3.0), random.number(3.0)));
            all.push((2.0 * random.next() - 1.0, 2.0 * random.next() - 1.0));
            let x = random.number(8.0);
            all.extend([(x, x), (x * TAN_EIGHTH, x), (x, x * TAN_EIGHTH), (x, -x)]);
        }
        for (a, b) in all {
            assert_near(atan2(a, b), a.atan2(b), &(a, b));
            assert_near(hypot(a, b), a.hypot(b), &(a, b));
            assert!(!(atan2(a, b).abs() > PI), "{a} {b}");
        }
    }

    #[test]
    fn many_numbers_at_once_have_the_bits_of_each_alone() {
        let mut random = Random(4);
        let kinds = SPECIAL.len();
        for round in 0..200 {
            // Only some batches have arguments that leave the fast way.
            let mut of = |k: usize| if round % 2 == 0 && k < kinds { SPECIAL[k] } else { random.number(4.0) };
            let (a, b): ([f64; 64], [f64; 64]) = (std::array::from_fn(&mut of), std::array::from_fn(|k| of(63 - k)));
            let mut out = [0.0; 64];
            let same = |out: &[f64; 64], f: &dyn Fn(usize) -> f64| {
                for k in 0..64 {
                    assert!(ulps(out[k], f(k)) == 0.0, "{} {}", a[k], b[k]);
                }
            };
            sin_many(&a, &mut out);
            same(&out, &|k| sin(a[k]));
            cos_many(&a, &mut out);
            same(&out, &|k| cos(a[k]));
            exp_many(&a, &mut out);
            same(&out, &|k| exp(a[k]));
            ln_many(&a, &mut out);
            same(&out, &|k| ln(a[k]));
            atan2_many(&a, &b, &mut out);
            same(&out, &|k| atan2(a[k], b[k]));
            hypot_many(&a, &b, &mut out);
            same(&out, &|k| hypot(a[k], b[k]));
            for n in [-3, 0, 1, 2, 3, 7, 64] {
                powi_many(&a, n, &mut [0.0; 64], &mut out);
                same(&out, &|k| powi(a[k], n));
            }
        }
    }

    #[test]
    fn whole_powers_are_products() {
        for x in [0.3, -1.7, 12.5] {
            assert_eq!(powi(x, 0), 1.0);
            assert_eq!(powi(x, 3), x * (x * x));
            assert_eq!(powi(x, -2), 1.0 / (x * x));
        }
    }
}
