//! Rvachev's functions: one formula out of a Boolean of formulas (\[LIS14\]; Rvachev, Theory of R-functions, 1982).
//!
//! With `s = a + b`, inside positive, and the complement `-a`:
//!
//! * `R_1`: conjunction `min`, disjunction `max`.
//! * `R_alpha`, `-1 < alpha <= 1`: `(s -+ r) / (1 + alpha)`, `r = sqrt(a^2 + b^2 - 2 alpha a b)`; `R_0` is `alpha = 0`.
//! * `R_0^m`: `(s -+ sqrt(a^2 + b^2)) (a^2 + b^2)^(m/2)`, m times differentiable.
//!
//! The textbook form subtracts nearly equal numbers near a face and gets signs wrong; since
//! `s^2 - r^2 = 2 (1 + alpha) a b` the same value is `2 a b / (s +- r)` where that adds instead. This form is used
//! throughout and its sign is exactly that of min / max.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};

/// A system of R-functions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum RSystem {
    /// min and max.
    MinMax,
    /// `R_0`, the default: analytic except where both arguments vanish.
    #[default]
    R0,
    /// `R_alpha`.
    RAlpha(f64),
    /// `R_0^m`.
    R0m(u32),
}

impl RSystem {
    /// Refuses parameters outside `-1 < alpha <= 1` and `1 <= m <= 8`.
    pub fn checked(self) -> Result<Self> {
        match self {
            RSystem::RAlpha(a) if !(a > -1.0 && a <= 1.0) => {
                Err(Error::Usage(format!("Ralpha needs -1 < alpha <= 1, not {a}")))
            }
            RSystem::R0m(m) if !(1..=8).contains(&m) => Err(Error::Usage(format!("R0m needs 1 <= m <= 8, not {m}"))),
            ok => Ok(ok),
        }
    }

    /// R-conjunction of two values.
    #[inline(always)]
    pub fn and(self, a: f64, b: f64) -> f64 {
        match self {
            RSystem::MinMax => a.min(b),
            RSystem::R0 => r_and(a, b, 0.0),
            RSystem::RAlpha(alpha) => r_and(a, b, alpha),
            RSystem::R0m(m) => r_and(a, b, 0.0) * (a * a + b * b).sqrt().powi(m as i32),
        }
    }

    /// R-disjunction of two values: `-((-a) and (-b))`.
    #[inline(always)]
    pub fn or(self, a: f64, b: f64) -> f64 {
        -self.and(-a, -b)
    }

    /// Partial derivatives of [`and`](Self::and) by `a` and `b`; at `a = b = 0`, where there is none, that of `min`.
    #[inline(always)]
    pub fn and_partials(self, a: f64, b: f64) -> (f64, f64) {
        let pick = if a <= b { (1.0, 0.0) } else { (0.0, 1.0) };
        let smooth = |alpha: f64| {
            let r = radius(a, b, alpha);
            if r == 0.0 {
                return pick;
            }
            ((1.0 - (a - alpha * b) / r) / (1.0 + alpha), (1.0 - (b - alpha * a) / r) / (1.0 + alpha))
        };
        match self {
            RSystem::MinMax => pick,
            RSystem::R0 => smooth(0.0),
            RSystem::RAlpha(alpha) => smooth(alpha),
            RSystem::R0m(m) => {
                let q = (a * a + b * b).sqrt();
                if q == 0.0 {
                    return (0.0, 0.0);
                }
                let (pa, pb) = smooth(0.0);
                let (f, w, m) = (r_and(a, b, 0.0), q.powi(m as i32), f64::from(m));
                let dw = m * w / (q * q);
                (pa * w + f * dw * a, pb * w + f * dw * b)
            }
        }
    }

    /// Partial derivatives of [`or`](Self::or) by `a` and `b`.
    #[inline(always)]
    pub fn or_partials(self, a: f64, b: f64) -> (f64, f64) {
        self.and_partials(-a, -b)
    }
}

/// As it is written on a command line: `minmax`, `R0`, `Ralpha:0.5`, `R0m:2`. Reads back as the same system.
impl fmt::Display for RSystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RSystem::MinMax => f.pad("minmax"),
            RSystem::R0 => f.pad("R0"),
            RSystem::RAlpha(alpha) => f.pad(&format!("Ralpha:{alpha}")),
            RSystem::R0m(m) => f.pad(&format!("R0m:{m}")),
        }
    }
}

impl FromStr for RSystem {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self> {
        let wrong = || Error::Usage(format!("an R-system is R0, minmax, Ralpha:A or R0m:M, not {s:?}"));
        let system = match s.split_once(':') {
            None if s == "R0" => RSystem::R0,
            None if s == "minmax" => RSystem::MinMax,
            Some(("Ralpha", alpha)) => RSystem::RAlpha(alpha.parse().map_err(|_| wrong())?),
            Some(("R0m", m)) => RSystem::R0m(m.parse().map_err(|_| wrong())?),
            _ => return Err(wrong()),
        };
        system.checked()
    }
}

#[inline(always)]
fn radius(a: f64, b: f64, alpha: f64) -> f64 {
    // (a - b)^2 + 2 (1 - alpha) a b has no cancellation for a b >= 0; the other form has none for a b < 0.
    let square = if a * b >= 0.0 {
        (a - b) * (a - b) + 2.0 * (1.0 - alpha) * (a * b)
    } else {
        a * a + b * b - 2.0 * alpha * (a * b)
    };
    square.sqrt()
}

#[inline(always)]
fn r_and(a: f64, b: f64, alpha: f64) -> f64 {
    let s = a + b;
    let r = radius(a, b, alpha);
    if s > 0.0 {
        let (small, large) = if a.abs() < b.abs() { (a, b) } else { (b, a) };
        2.0 * small * (large / (s + r))
    } else {
        (s - r) / (1.0 + alpha)
    }
}
