//! Bracketing a change of sign on 0..=1 by the ITP method (Oliveira and Takahashi, 2020): as fast as a secant method on
//! smooth functions, never slower than bisection by more than one step.

/// A bracket that shrinks. Ask for [`probe`](Self::probe), evaluate there, tell the value to [`update`](Self::update).
///
/// Guarantee: after at most `ceil(log2(1 / tolerance)) + 2` updates the bracket is no wider than `tolerance`, whatever
/// the function, as long as its values are never zero or NaN (use signs of a perturbed function).
#[derive(Debug, Clone, Copy)]
pub struct Bracket {
    a: f64,
    b: f64,
    fa: f64,
    fb: f64,
    tolerance: f64,
    budget: i32,
}

impl Bracket {
    /// Starts with the values at 0 and 1, which must have different signs. `tolerance` is a share of the whole.
    pub fn new(f0: f64, f1: f64, tolerance: f64) -> Self {
        let tolerance = tolerance.max(4.0 * f64::EPSILON);
        Self { a: 0.0, b: 1.0, fa: f0, fb: f1, tolerance, budget: (1.0 / tolerance).log2().ceil() as i32 + 1 }
    }

    /// Whether the bracket is as narrow as asked.
    pub fn done(&self) -> bool {
        self.b - self.a <= self.tolerance
    }

    /// The middle of the bracket.
    pub fn root(&self) -> f64 {
        0.5 * (self.a + self.b)
    }

    /// The larger magnitude of the values at the two ends: small at a root, large at a pole.
    pub fn residual(&self) -> f64 {
        self.fa.abs().max(self.fb.abs())
    }

    /// Where to evaluate next.
    pub fn probe(&self) -> f64 {
        let (a, b) = (self.a, self.b);
        let width = b - a;
        let half = 0.5 * (a + b);
        let secant = a + width * (self.fa / (self.fa - self.fb));
        if !secant.is_finite() {
            return half;
        }
        // truncation: pull the secant toward the middle by a little that vanishes quadratically
        let sigma = (half - secant).signum();
        let delta = (0.2 * width * width).max(0.25 * self.tolerance);
        let truncated = if delta <= (half - secant).abs() { secant + sigma * delta } else { half };
        // projection: stay within what bisection could still repair
        let r = (0.5 * self.tolerance * (self.budget as f64).exp2() - 0.5 * width).max(0.0);
        let x = if (truncated - half).abs() <= r { truncated } else { half - sigma * r };
        if x > a && x < b { x } else { half }
    }

    /// Tells the value at [`probe`](Self::probe).
    pub fn update(&mut self, x: f64, f: f64) {
        self.budget -= 1;
        if (f > 0.0) == (self.fa > 0.0) {
            self.a = x;
            self.fa = f;
        } else {
            self.b = x;
            self.fb = f;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(f: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut b = Bracket::new(f(0.0), f(1.0), 1e-12);
        let mut n = 0;
        while !b.done() {
            let x = b.probe();
            b.update(x, f(x));
            n += 1;
        }
        (b.root(), n)
    }

    #[test]
    fn finds_roots_of_easy_and_hard_functions_within_the_bisection_budget() {
        for r in [1e-9, 0.001, 0.25, 0.5, 0.7182, 0.999, 1.0 - 1e-9] {
            let (x, n) = solve(|x| x - r);
            assert!((x - r).abs() <= 1e-12 && n <= 12, "line {r}: {x} in {n}");
            let (x, n) = solve(|x| x * x - r * r);
            let most = if r < 0.1 { 43 } else { 14 };
            assert!((x - r).abs() <= 1e-12 && n <= most, "parabola {r}: {x} in {n}");
            let (x, n) = solve(|x| if x < r { -1e-300 } else { 1e300 });
            assert!((x - r).abs() <= 1e-12 && n <= 43, "step {r}: {x} in {n}");
            let (x, n) = solve(|x| (x - r).powi(9) + f64::MIN_POSITIVE);
            assert!((x - r).abs() <= 1e-2 && n <= 43, "flat {r}: {x} in {n}");
        }
    }
}
