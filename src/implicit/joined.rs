//! R-functions of many pairs of values at once: each pair has the bits that it has alone.

use multiversion::multiversion;

use super::leaf::Leaf;
use super::rfunction::RSystem;

/// An R-conjunction or an R-disjunction.
#[derive(Clone, Copy)]
pub(super) struct Connective {
    pub(super) system: RSystem,
    /// Whether it is the disjunction, which takes the larger value.
    pub(super) larger: bool,
}

impl Connective {
    /// With one of each system, so that loops over pairs are compiled for each.
    #[inline(always)]
    fn each(self, mut run: impl FnMut(Connective)) {
        let Connective { system, larger } = self;
        let mut run = |system| {
            if larger { run(Connective { system, larger: true }) } else { run(Connective { system, larger: false }) }
        };
        match system {
            RSystem::MinMax => run(RSystem::MinMax),
            RSystem::R0 => run(RSystem::R0),
            RSystem::RAlpha(alpha) => run(RSystem::RAlpha(alpha)),
            RSystem::R0m(m) => run(RSystem::R0m(m)),
        }
    }

    #[inline(always)]
    fn value(self, a: f64, b: f64) -> f64 {
        if self.larger { self.system.or(a, b) } else { self.system.and(a, b) }
    }

    #[inline(always)]
    fn partials(self, a: f64, b: f64) -> (f64, f64) {
        if self.larger { self.system.or_partials(a, b) } else { self.system.and_partials(a, b) }
    }
}

/// Values of R-functions. Wider vector units give the same bits: only lane-wise IEEE operations are used, and none is contracted.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(super) fn values(join: Connective, [a, b]: [&[f64]; 2], out: &mut [f64]) {
    let n = out.len();
    let (a, b) = (&a[..n], &b[..n]);
    join.each(|join| {
        for k in 0..n {
            out[k] = join.value(a[k], b[k]);
        }
    });
}

/// What operands count by their derivatives, for what the R-functions count. An R-function that counts nothing hands nothing on, even where
/// it has no derivative.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(super) fn weights(join: Connective, [a, b]: [&[f64]; 2], weights: &[f64], [of_a, of_b]: [&mut [f64]; 2]) {
    let n = weights.len();
    let (a, b, of_a, of_b) = (&a[..n], &b[..n], &mut of_a[..n], &mut of_b[..n]);
    join.each(|join| {
        for k in 0..n {
            let (p, q) = join.partials(a[k], b[k]);
            let by = |p: f64| if weights[k] == 0.0 { 0.0 } else { weights[k] * p };
            (of_a[k], of_b[k]) = (by(p), by(q));
        }
    });
}

/// The sign companion, minimum or maximum: the same choice as everywhere, also where one of them is NaN.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(super) fn signs(larger: bool, [a, b]: [&[f64]; 2], out: &mut [f64]) {
    let n = out.len();
    let (a, b) = (&a[..n], &b[..n]);
    if larger {
        for k in 0..n {
            out[k] = if a[k] > b[k] { a[k] } else { b[k] };
        }
    } else {
        for k in 0..n {
            out[k] = if a[k] < b[k] { a[k] } else { b[k] };
        }
    }
}

/// Signed values of a leaf, never zero.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(super) fn leaf(leaf: &Leaf, negate: bool, p: [&[f64]; 3], out: &mut [f64]) {
    leaf.eval_signed(p, negate, out);
}
