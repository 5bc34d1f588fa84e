//! The gradient of a formula at one point: its program, with each register a value and its derivatives by x, y and z.
//!
//! Values have the bits that batches of values have.

use glam::DVec3;

use super::super::super::expr::{Binary, STEEPENED, SWING, SWUNG_BACK, Unary};
use super::{COORDINATES, Kind, Program, RESULT, Register, Term, Work};
use crate::numeric::{Dual, vector};

/// The derivatives by x, y and z, then the value: as a whole two or one of a processor's vectors.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Slope(pub(super) [f64; 4]);

/// Where a slope has its value.
pub(super) const VALUE: usize = 3;

impl Slope {
    /// Of the constant 0.
    const ZERO: Slope = Slope([0.0; 4]);

    #[inline(always)]
    fn v(self) -> f64 {
        self.0[VALUE]
    }

    #[inline(always)]
    fn constant(v: f64) -> Self {
        Slope([0.0, 0.0, 0.0, v])
    }

    /// The value `v` with derivatives that come from one's own.
    #[inline(always)]
    fn with(self, v: f64, f: impl Fn(f64) -> f64) -> Self {
        let [x, y, z, _] = self.0;
        Slope([f(x), f(y), f(z), v])
    }

    /// The same from two.
    #[inline(always)]
    fn both(self, o: Self, v: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let ([a, b, c, _], [d, e, g, _]) = (self.0, o.0);
        Slope([f(a, d), f(b, e), f(c, g), v])
    }

    #[inline(always)]
    fn is_still(self) -> bool {
        let [x, y, z, _] = self.0;
        (x == 0.0) & (y == 0.0) & (z == 0.0)
    }

    /// Chain rule: value `v` and derivative `d` of a function of this.
    #[inline(always)]
    fn chain(self, v: f64, d: f64) -> Self {
        // an undefined derivative of a function whose argument does not vary is no derivative at all
        if self.is_still() { Slope::constant(v) } else { self.with(v, |g| g * d) }
    }

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Slope([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Slope([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]])
    }

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let (v, w) = (self.v(), o.v());
        self.both(o, v * w, |g, h| g * w + h * v)
    }

    #[inline(always)]
    fn square(self) -> Self {
        // twice a product is the sum of two of it to the last bit
        let v = self.v();
        self.with(v * v, |g| 2.0 * (g * v))
    }
}

impl Term {
    #[inline(always)]
    fn slope(self, r: &impl Fn(Register) -> Slope) -> Slope {
        match self.kind {
            Kind::Plain => r(self.a),
            Kind::Square => r(self.a).square(),
            Kind::Mul => r(self.a).mul(r(self.b)),
            Kind::Add => r(self.a).add(r(self.b)),
        }
    }
}

impl Work {
    #[inline(always)]
    pub(super) fn slope(&self, r: impl Fn(Register) -> Slope, turns: &mut Turns) -> Slope {
        match *self {
            Work::Add(a, b) => a.slope(&r).add(b.slope(&r)),
            Work::Sub(a, b) => a.slope(&r).sub(b.slope(&r)),
            Work::Mul(a, b) => a.slope(&r).mul(b.slope(&r)),
            Work::Sum([a, b, c]) => a.slope(&r).add(b.slope(&r)).add(c.slope(&r)),
            Work::Squared(a) => a.slope(&r).square(),
            Work::Unary(u, a) => unary(u, r(a), turns),
            Work::Binary(o, a, b) => binary(o, r(a), r(b)),
            Work::Power(a, n) => {
                let x = r(a);
                x.chain(vector::powi(x.v(), n), f64::from(n) * Binary::Pow.apply(x.v(), f64::from(n) - 1.0))
            }
            Work::Select(c, a, b) => r(if r(c).v() >= 0.0 { a } else { b }),
        }
    }
}

#[inline]
fn unary(op: Unary, x: Slope, turns: &mut Turns) -> Slope {
    let a = x.v();
    let value = || op.apply(a);
    match op {
        Unary::Neg => x.with(-a, |g| -g),
        Unary::Abs => x.chain(a.abs(), if a < 0.0 { -1.0 } else { 1.0 }),
        Unary::Sqrt => x.chain(a.sqrt(), 0.5 / a.sqrt()),
        Unary::Exp => {
            let v = value();
            x.chain(v, v)
        }
        Unary::Log => x.chain(value(), 1.0 / a),
        Unary::Sin => {
            let (sin, cos) = turns.of(a);
            x.chain(sin, cos)
        }
        Unary::Cos => {
            let (sin, cos) = turns.of(a);
            x.chain(cos, -sin)
        }
        Unary::Tan => {
            let v = value();
            x.chain(v, 1.0 + v * v)
        }
        Unary::Wrap | Unary::Upward | Unary::Downward => x.chain(value(), 1.0),
        Unary::Fold => x.chain(value(), 1f64.copysign(Unary::Wrap.apply(a))),
        Unary::Steepened => x.chain(value(), if a < 0.0 { STEEPENED } else { 1.0 }),
        Unary::Swing => {
            let ahead = Unary::Wrap.apply(a).abs() <= SWING;
            x.chain(value(), if ahead { 1.0 } else { -SWUNG_BACK })
        }
        Unary::Asin => x.chain(value(), 1.0 / (1.0 - a * a).sqrt()),
        Unary::Acos => x.chain(value(), -1.0 / (1.0 - a * a).sqrt()),
        Unary::Sinh => x.chain(value(), a.cosh()),
        Unary::Cosh => x.chain(value(), a.sinh()),
        Unary::Tanh => {
            let v = value();
            x.chain(v, 1.0 - v * v)
        }
        Unary::Floor | Unary::Sign => Slope::constant(value()),
    }
}

#[inline]
fn binary(op: Binary, a: Slope, b: Slope) -> Slope {
    let (x, y) = (a.v(), b.v());
    match op {
        Binary::Add => a.add(b),
        Binary::Sub => a.sub(b),
        Binary::Mul => a.mul(b),
        Binary::Div => {
            let v = x / y;
            a.both(b, v, |g, h| (g - h * v) / y)
        }
        Binary::Pow if b.is_still() => a.chain(op.apply(x, y), y * op.apply(x, y - 1.0)),
        Binary::Pow => {
            let (v, by_b, by_a) = (op.apply(x, y), x.ln(), y / x);
            a.both(b, v, |g, h| (h * by_b + g * by_a) * v)
        }
        Binary::Min if x.is_nan() || x < y => a,
        Binary::Max if x.is_nan() || x > y => a,
        Binary::Min | Binary::Max => b,
        Binary::Atan2 => {
            let q = x * x + y * y;
            a.both(b, op.apply(x, y), |g, h| (g * y - h * x) / q)
        }
        Binary::Hypot => {
            let v = op.apply(x, y);
            a.both(b, v, |g, h| (g * x + h * y) / v)
        }
        Binary::Mod => {
            let steps = (x / y).floor();
            a.both(b, op.apply(x, y), |g, h| g - h * steps)
        }
    }
}

impl Program {
    /// Value and gradient at one point.
    pub(in super::super) fn gradient(&self, p: DVec3) -> Dual {
        let [x, y, z, v] = self.slope(p.to_array()).0;
        Dual::new(v, DVec3::new(x, y, z))
    }

    pub(super) fn slope(&self, p: [f64; 3]) -> Slope {
        // Most formulas need little room; clearing more than they use would cost as much as they do.
        match COORDINATES as usize + self.registers {
            ..=12 => self.slope_in(p, &mut [Slope::ZERO; 12]),
            13..=24 => self.slope_in(p, &mut [Slope::ZERO; 24]),
            25..=48 => self.slope_in(p, &mut [Slope::ZERO; 48]),
            n => self.slope_in(p, &mut vec![Slope::ZERO; n]),
        }
    }

    /// The same with room for coordinates and registers.
    fn slope_in(&self, p: [f64; 3], r: &mut [Slope]) -> Slope {
        for k in 0..3 {
            r[k].0[k] = 1.0;
            r[k].0[VALUE] = p[k];
        }
        for (r, c) in r[COORDINATES as usize..].iter_mut().zip(&self.constants) {
            r.0[VALUE] = *c;
        }
        let mut turns = Turns::default();
        let mut result = Slope::constant(f64::NAN);
        for step in &self.steps {
            let made = step.work.slope(|a| r[a as usize], &mut turns);
            if step.to == RESULT {
                result = made;
            } else {
                r[step.to as usize] = made;
            }
        }
        result
    }
}

/// Sines and cosines of the values last asked for: formulas of gyroids and their kin ask for both, again and again.
#[derive(Default)]
pub(super) struct Turns {
    known: [Option<(f64, (f64, f64))>; 3],
    oldest: usize,
}

impl Turns {
    fn of(&mut self, value: f64) -> (f64, f64) {
        if let Some((_, both)) = self.known.iter().flatten().find(|k| k.0.to_bits() == value.to_bits()) {
            return *both;
        }
        let both = vector::sin_cos(value);
        self.known[self.oldest] = Some((value, both));
        self.oldest = (self.oldest + 1) % self.known.len();
        both
    }
}
