//! Bounds of a formula's gradient from its end backwards: reverse differentiation in interval arithmetic.
//!
//! Forwards each operation has bounds of its own gradient, and a difference of two that vary alike adds up what would cancel: the
//! slope of `t - atan(t)` comes out as `dt - dt / (1 + t²)`. Backwards it is `(1 - 1 / (1 + t²)) dt`, whose first factor is close.

use std::f64::consts::PI;

use super::super::expr::Binary;
use super::super::slopes::{Slopes, share, slope};
use super::{Formula, Op};
use crate::numeric::Interval;

/// What an operand counts where it may be the one that a minimum or maximum takes.
const SOME: Interval = Interval { lo: 0.0, hi: 1.0 };

/// Whether an operation that depends on more than a coordinate is an operand twice: else backwards is no closer than forwards.
pub(super) fn is_shared(ops: &[Op]) -> bool {
    let mut used = vec![false; ops.len()];
    let mut twice = |a: u32| {
        let known = std::mem::replace(&mut used[a as usize], true);
        known && !matches!(ops[a as usize], Op::Const(_) | Op::Coordinate(_))
    };
    ops.iter().any(|op| match *op {
        Op::Const(_) | Op::Coordinate(_) => false,
        Op::Unary(_, a) | Op::Square(a) => twice(a),
        Op::Turn(_, a, b) | Op::Binary(_, a, b) => [a, b].map(&mut twice).contains(&true),
        Op::Select(a, b, c) | Op::Joined(a, b, c) => [a, b, c].map(&mut twice).contains(&true),
    })
}

/// What is found backwards.
pub(super) struct Backwards {
    /// By how much the value in the box differs from that in the middle.
    pub(super) change: Interval,
    /// Bounds of the gradient, where they are finite.
    pub(super) gradient: Option<[Interval; 3]>,
}

impl Formula {
    /// Bounds by those of all operations over the box and in its middle, from which the box reaches `half` each way; nothing where the
    /// formula may jump. Where an operation is infinitely steep, as a root at zero is, the change of its value is one more variable.
    pub(super) fn backwards(&self, bounds: &[Slopes], middle: &[Interval], half: &[f64; 3]) -> Option<Backwards> {
        let mut gradient = [Interval::ZERO; 3];
        let mut change = Interval::ZERO;
        let mut steep = false;
        let mut weights = vec![Interval::ZERO; bounds.len()];
        *weights.last_mut()? = Interval::ONE;
        for (i, op) in self.ops.iter().enumerate().rev() {
            let weight = weights[i];
            if weight == Interval::ZERO {
                continue;
            }
            let value = |a: u32| bounds[a as usize].value;
            let is_finite = |x: &Interval| x.lo.is_finite() && x.hi.is_finite();
            let mut add = |a: u32, partial: Interval| {
                let sum = &mut weights[a as usize];
                *sum = *sum + weight * partial;
            };
            if let Some(length) = self.length(i) {
                length.partials(value(i as u32), value).for_each(|p| add(p.0, p.1));
                continue;
            }
            let parts: [(u32, Interval); 2] = match *op {
                Op::Const(_) => continue,
                Op::Coordinate(k) => {
                    gradient[k as usize % 3] = weight;
                    continue;
                }
                Op::Square(a) => [(a, value(a).scale(2.0)), (a, Interval::ZERO)],
                Op::Unary(u, a) => [(a, slope(u, value(a), bounds[i].value)?), (a, Interval::ZERO)],
                Op::Turn(u, a, b) => {
                    // One of the two angles does not jump here.
                    let x = if bounds[a as usize].gradient.iter().all(is_finite) { a } else { b };
                    [(x, slope(u, value(x), bounds[i].value)?), (x, Interval::ZERO)]
                }
                Op::Binary(op, a, b) => {
                    let [of_a, of_b] = partials(op, [value(a), value(b)], bounds[i].value)?;
                    [(a, of_a), (b, of_b)]
                }
                Op::Select(c, a, b) | Op::Joined(c, a, b) => {
                    let c = value(c);
                    match op {
                        _ if c.lo >= 0.0 => [(a, Interval::ONE), (b, Interval::ZERO)],
                        _ if c.hi < 0.0 => [(a, Interval::ZERO), (b, Interval::ONE)],
                        Op::Joined(..) => [(a, SOME), (b, SOME)],
                        _ => return None,
                    }
                }
            };
            if parts.iter().all(|p| is_finite(&p.1)) {
                parts.into_iter().filter(|p| p.1 != Interval::ZERO).for_each(|p| add(p.0, p.1));
            } else {
                steep = true;
                change = change + weight * (bounds[i].value - middle[i]);
            }
        }
        for (g, half) in gradient.iter().zip(half) {
            change = change + *g * Interval { lo: -half, hi: *half };
        }
        Some(Backwards { change, gradient: (!steep).then_some(gradient) })
    }
}

/// Bounds of the derivatives by both operands; nothing where the operation may jump.
fn partials(op: Binary, [a, b]: [Interval; 2], value: Interval) -> Option<[Interval; 2]> {
    Some(match op {
        Binary::Add => [Interval::ONE, Interval::ONE],
        Binary::Sub => [Interval::ONE, -Interval::ONE],
        Binary::Mul => [b, a],
        Binary::Div => [Interval::ONE / b, -(value / b)],
        Binary::Pow if b.lo == b.hi => [a.pow(Interval::point(b.lo - 1.0)) * b, Interval::ZERO],
        Binary::Pow => [value * (b / a), value * a.ln()],
        Binary::Min if a.hi < b.lo => [Interval::ONE, Interval::ZERO],
        Binary::Min if b.hi < a.lo => [Interval::ZERO, Interval::ONE],
        Binary::Max if a.lo > b.hi => [Interval::ONE, Interval::ZERO],
        Binary::Max if b.lo > a.hi => [Interval::ZERO, Interval::ONE],
        Binary::Min | Binary::Max => [SOME, SOME],
        Binary::Atan2 if value.lo <= -PI && value.hi >= PI => return None,
        Binary::Atan2 => {
            let q = a.square() + b.square();
            [b / q, -(a / q)]
        }
        Binary::Hypot => [share(a, value), share(b, value)],
        Binary::Mod => {
            let steps = (a / b).floor();
            [(steps.lo == steps.hi).then_some(Interval::ONE)?, -steps]
        }
    })
}
