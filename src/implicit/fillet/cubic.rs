//! The zeros of the smooth maximum that adds a cube, `max(a, b) + max(k - |a - b|, 0)³ / (6k²)`.
//!
//! In `u = k + a` and `v = k + b` they are the curve on which a length of `(u, v)` is `k`, as a circle is where `|(u, v)|` is. The curve bends
//! like the boundary of a convex set, so the length is that set's gauge: `L` with `L - (L - d)³ / (6 L²) = m`, where `m` is the larger one of
//! the two and `d` their difference. Signs do not count.

/// `L - m` is a cubic root away from `m / 5` times a cube of the ratio: from there so many steps of Newton's method reach the last place,
/// since the slope lies between 5/6 and 1.
const STEPS: usize = 4;

/// The larger one of two sizes, and the smaller one.
fn ordered(u: f64, v: f64) -> [f64; 2] {
    let (u, v) = (u.abs(), v.abs());
    [u.max(v), u.min(v)]
}

/// The length of `(u, v)`; the size of `u` where `v` is zero.
#[inline(always)]
pub(super) fn length(u: f64, v: f64) -> f64 {
    let [more, less] = ordered(u, v);
    if less == 0.0 || !more.is_finite() {
        return more;
    }
    let apart = more - less;
    let ratio = less / more;
    let mut length = more * (1.0 + 0.2 * ratio * ratio * ratio);
    for _ in 0..STEPS {
        let t = 1.0 - apart / length;
        let slope = 1.0 - t * t * (3.0 - 2.0 * t) / 6.0;
        length -= (length * (1.0 - t * t * t / 6.0) - more) / slope;
    }
    length
}

/// Its partial derivatives.
#[inline(always)]
pub(super) fn shares(u: f64, v: f64, length: f64) -> [f64; 2] {
    let [more, less] = ordered(u, v);
    if !more.is_finite() || more == 0.0 {
        return [0.0; 2];
    }
    let t = 1.0 - (more - less) / length;
    let slope = 1.0 - t * t * (3.0 - 2.0 * t) / 6.0;
    let of_less = 0.5 * t * t / slope;
    let of_more = 1.0 / slope - of_less;
    let [of_u, of_v] = if u.abs() >= v.abs() { [of_more, of_less] } else { [of_less, of_more] };
    [of_u.copysign(u), of_v.copysign(v)]
}

/// The partial derivative by `u` where neither is negative: it rises with `u` and falls as `v` rises.
pub(super) fn share(u: f64, v: f64) -> f64 {
    match (u.is_finite(), v.is_finite()) {
        (false, _) => 1.0,
        (true, false) => 0.0,
        (true, true) => shares(u, v, length(u, v))[0],
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_length_is_one_on_the_zeros_and_has_its_slopes(s in -1.0f64..1.0, k in 0.01f64..100.0) {
            // Points of the zeros by the difference of both.
            let added = (1.0 - s.abs()).powi(3) / 6.0;
            let (u, v) = if s >= 0.0 { (1.0 - added, 1.0 - added - s) } else { (1.0 - added + s, 1.0 - added) };
            prop_assert!((length(k * u, k * v) - k).abs() < 1e-14 * k, "{}", length(k * u, k * v) / k - 1.0);
            let e = 1e-6;
            let differences = [length(u + e, v) - length(u - e, v), length(u, v + e) - length(u, v - e)].map(|d| d / (2.0 * e));
            let exact = shares(u, v, length(u, v));
            for (d, s) in differences.into_iter().zip(exact) {
                prop_assert!((d - s).abs() < 1e-8, "{d} {s}");
            }
        }

        #[test]
        fn shares_rise_with_their_own_and_fall_with_the_other(u in 0.0f64..2.0, v in 0.0f64..2.0, more in 0.0f64..1.0) {
            prop_assert!(share(u + more, v) >= share(u, v) - 1e-12);
            prop_assert!(share(u, v + more) <= share(u, v) + 1e-12);
        }
    }
}
