//! Roots of sums of squares: lengths of vectors.
//!
//! A root has no bound of its slope at zero, but a length does: no component's share in it is beyond -1 and 1.

use super::super::expr::{Binary, Unary};
use super::super::slopes::share;
use super::Op;
use crate::numeric::Interval;

/// Sums are looked through to so many terms: a length has few.
const MOST_TERMS: usize = 16;

/// An operation that is a length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Length {
    /// The operation's number.
    pub(super) root: u32,
    /// Numbers of what is squared, with the roots of the squares' factors.
    of: Vec<(u32, f64)>,
}

impl Length {
    /// Bounds of the derivatives by what is squared, with its number.
    pub(super) fn partials(
        &self,
        value: Interval,
        of: impl Fn(u32) -> Interval,
    ) -> impl Iterator<Item = (u32, Interval)> {
        self.of.iter().map(move |&(s, k)| (s, share(of(s).scale(k), value).scale(k)))
    }
}

/// All lengths among the operations.
pub(super) fn lengths(ops: &[Op]) -> Vec<Length> {
    let of = |(i, op): (usize, &Op)| {
        let sum = match *op {
            Op::Unary(Unary::Sqrt, a) => a,
            Op::Binary(Binary::Pow, a, b) if ops[b as usize] == Op::Const(0.5) => a,
            _ => return None,
        };
        Some(Length { root: i as u32, of: squares(ops, sum)? })
    };
    ops.iter().enumerate().filter_map(of).collect()
}

/// What a sum squares; nothing where it has other terms than squares and positive numbers.
fn squares(ops: &[Op], sum: u32) -> Option<Vec<(u32, f64)>> {
    let number = |a: u32| match ops[a as usize] {
        Op::Const(c) if c > 0.0 => Some(c),
        _ => None,
    };
    let mut squares = Vec::new();
    let mut stack = vec![(sum, 1.0)];
    let mut left = MOST_TERMS;
    while let Some((a, k)) = stack.pop() {
        left = left.checked_sub(1)?;
        match ops[a as usize] {
            Op::Const(c) if c >= 0.0 => {}
            Op::Square(s) => squares.push((s, f64::sqrt(k))),
            Op::Binary(Binary::Add, a, b) => stack.extend([(a, k), (b, k)]),
            Op::Binary(Binary::Mul, a, b) => match (number(a), number(b)) {
                (Some(c), _) => stack.push((b, k * c)),
                (_, Some(c)) => stack.push((a, k * c)),
                _ => return None,
            },
            Op::Binary(Binary::Div, a, b) => stack.push((a, k / number(b)?)),
            _ => return None,
        }
    }
    (!squares.is_empty() && squares.iter().all(|s| s.1.is_finite())).then_some(squares)
}
