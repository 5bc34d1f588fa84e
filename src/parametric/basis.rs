//! B-spline basis functions: knots, spans, values and derivatives (\[KUZ19\] 16, 17, for surfaces 56-58; L. Piegl, W. Tiller,
//! "The NURBS Book", 2.1-2.3). The functions are the normalized ones of (18), which add up to one (60). Put right in (16): the
//! denominator is the length of the span, which is open at its end.

use crate::error::{Error, Place, Result};

/// The highest degree: enough for what systems write, and small enough for arrays on the stack.
pub const MAX_DEGREE: usize = 25;

/// Room for the basis functions of any degree that do not vanish in a span.
pub const ANY: usize = MAX_DEGREE + 1;

/// A degree and its knots, each repeated as often as it counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Knots {
    degree: usize,
    values: Vec<f64>,
}

impl Knots {
    /// Knots for `points` control points. Errors: a degree of 0 or above [`MAX_DEGREE`], knots that fall, are not finite or
    /// not `points + degree + 1` in number, or an empty domain.
    pub fn new(degree: usize, values: Vec<f64>, points: usize) -> Result<Self> {
        let wrong = |what: String| Err(Error::input(Place::Unknown, what));
        if degree == 0 || degree > MAX_DEGREE {
            return wrong(format!("a spline of degree {degree}"));
        }
        if points <= degree || values.len() != points + degree + 1 {
            return wrong(format!("{} knots for {points} control points of degree {degree}", values.len()));
        }
        if !values.iter().all(|k| k.is_finite()) || values.windows(2).any(|w| w[0] > w[1]) {
            return wrong("knots that are not ascending".into());
        }
        let this = Self { degree, values };
        if !(this.domain()[0] < this.domain()[1]) {
            return wrong("a spline with an empty domain".into());
        }
        Ok(this)
    }

    /// Knots of a clamped spline with inner knots at equal distances, over 0..=1.
    pub fn uniform(degree: usize, points: usize) -> Result<Self> {
        let spans = points.saturating_sub(degree).max(1);
        let inner = (1..spans).map(|i| i as f64 / spans as f64);
        let ends = |v: f64| std::iter::repeat_n(v, degree + 1);
        Self::new(degree, ends(0.0).chain(inner).chain(ends(1.0)).collect(), points)
    }

    /// The degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The knots, each as often as it counts.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// How many control points belong to the knots.
    pub fn points(&self) -> usize {
        self.values.len() - self.degree - 1
    }

    /// Where the basis adds up to one.
    pub fn domain(&self) -> [f64; 2] {
        [self.values[self.degree], self.values[self.points()]]
    }

    /// The different knots within the domain, ascending.
    pub fn breaks(&self) -> Vec<f64> {
        let mut all = self.values[self.degree..=self.points()].to_vec();
        all.dedup();
        all
    }

    /// The integral of each basis function over all parameters (\[KUZ19\] 19, 20): that of a spline is the sum of its control points,
    /// each times its own. Of clamped knots, which the domain holds, it is that over the domain.
    pub fn integrals(&self) -> Vec<f64> {
        let m = self.degree + 1;
        self.values.windows(m + 1).map(|k| (k[m] - k[0]) / m as f64).collect()
    }

    /// The span (index of its left knot) that holds `t`, which is clamped to the domain.
    pub fn span(&self, t: f64) -> usize {
        let (p, n) = (self.degree, self.points());
        let after = self.values[p + 1..n].partition_point(|k| *k <= t);
        let mut span = p + after;
        // A knot of full multiplicity at the end leaves empty spans before it.
        while span > p && !(self.values[span] < self.values[span + 1]) {
            span -= 1;
        }
        span
    }

    /// The basis functions that do not vanish at `t`, in its span: the first row of [`basis`](Self::basis).
    pub fn values_at<const N: usize>(&self, t: f64) -> (usize, [f64; N]) {
        let [lo, hi] = self.domain();
        let t = t.clamp(lo, hi);
        let (p, span) = (self.degree, self.span(t));
        let k = &self.values[span + 1 - p..=span + p];
        let mut now = [0.0; N];
        now[0] = 1.0;
        (1..=p).for_each(|q| raise(&mut now, k, p, q, t));
        (span, now)
    }

    /// The basis functions that do not vanish at `t`, in its span, and their first and second derivatives; the first
    /// belongs to control point `span - degree`. `t` is clamped to the domain. `N` is the room for them, more than the
    /// degree.
    pub fn basis<const N: usize>(&self, t: f64) -> (usize, [[f64; N]; 3]) {
        // Loops of a length that is known are unrolled.
        match self.degree {
            1 => self.basis_of::<N>(t, 1),
            2 => self.basis_of::<N>(t, 2),
            3 => self.basis_of::<N>(t, 3),
            p => self.basis_of::<N>(t, p),
        }
    }

    #[inline(always)]
    fn basis_of<const N: usize>(&self, t: f64, p: usize) -> (usize, [[f64; N]; 3]) {
        let [lo, hi] = self.domain();
        let t = t.clamp(lo, hi);
        let span = self.span(t);
        // The knots around the span: of those more than a degree away none counts.
        let k = &self.values[span + 1 - p..=span + p];
        let mut rows = [[0.0; N]; 3];
        // `now` holds the functions of degree q; those of degree p - 1 and p - 2 are kept for the derivatives.
        let mut now = [0.0; N];
        let (mut one, mut two) = (now, now);
        now[0] = 1.0;
        for q in 1..=p {
            if q + 1 == p {
                two = now;
            }
            if q == p {
                one = now;
            }
            raise(&mut now, k, p, q, t);
        }
        rows[0] = now;
        rows[1] = raised(&one, k, p, p);
        if p >= 2 {
            rows[2] = raised(&raised(&two, k, p, p - 1), k, p, p);
        }
        (span, rows)
    }
}

/// Functions of degree `q - 1` become those of degree `q`.
#[inline(always)]
fn raise<const N: usize>(now: &mut [f64; N], k: &[f64], p: usize, q: usize, t: f64) {
    let mut saved = 0.0;
    for r in 0..q {
        let (right, left) = (k[p + r], k[p + r - q]);
        let share = now[r] / (right - left);
        now[r] = saved + (right - t) * share;
        saved = (t - left) * share;
    }
    now[q] = saved;
}

/// Derivatives of the functions of degree `q` from values (or derivatives) of those of degree `q - 1`, both in the span
/// that begins at knot `p - 1` of `k`: N'_{i,q} = q (N_{i,q-1} / (t_{i+q} - t_i) - N_{i+1,q-1} / (t_{i+q+1} - t_{i+1})).
#[inline(always)]
fn raised<const N: usize>(lower: &[f64; N], k: &[f64], p: usize, q: usize) -> [f64; N] {
    let mut out = [0.0; N];
    let mut before = 0.0;
    for r in 0..q {
        let share = lower[r] / (k[p + r] - k[p + r - q]);
        out[r] = q as f64 * (before - share);
        before = share;
    }
    out[q] = q as f64 * before;
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_basis_adds_up_to_one_and_derivatives_agree_with_differences(
            degree in 1usize..6, steps in prop::collection::vec(0usize..3, 0..6), t in 0.01f64..0.99,
        ) {
            // Inner knots with gaps of 0, 1 or 2; multiplicity up to the degree.
            let mut inner: Vec<f64> = Vec::new();
            let mut at = 1.0;
            for s in steps {
                at += s as f64;
                if inner.iter().filter(|k| **k == at).count() < degree {
                    inner.push(at);
                }
            }
            let end = at + 1.0;
            let n = inner.len() + degree + 1;
            let ends = |v: f64| std::iter::repeat_n(v, degree + 1);
            let knots = Knots::new(degree, ends(0.0).chain(inner).chain(ends(end)).collect(), n).unwrap();
            let t = t * end;
            let (span, rows) = knots.basis::<ANY>(t);
            prop_assert!((rows[0].iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(rows[1].iter().sum::<f64>().abs() < 1e-9);
            let e = 1e-5;
            let (s0, a) = knots.basis::<ANY>(t - e);
            let (s1, b) = knots.basis::<ANY>(t + e);
            if s0 == span && s1 == span {
                for i in 0..=degree {
                    prop_assert!(((b[0][i] - a[0][i]) / (2.0 * e) - rows[1][i]).abs() < 1e-6);
                    prop_assert!(((b[1][i] - a[1][i]) / (2.0 * e) - rows[2][i]).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn senseless_knots_are_refused() {
        for (degree, knots, points) in [
            (0, vec![0.0, 1.0], 1),
            (1, vec![0.0, 0.0, 1.0], 2),
            (1, vec![0.0, 0.0, 0.0, 0.0], 2),
            (1, vec![0.0, 1.0, 0.5, 2.0], 2),
            (1, vec![0.0, 0.0, f64::NAN, 1.0], 2),
            (3, vec![0.0; 6], 2),
            (26, vec![0.0; 60], 33),
        ] {
            assert!(Knots::new(degree, knots, points).is_err());
        }
    }
}
