//! A compiled formula as lines of `.vm` text.

use std::f64::consts::PI;

use super::{Formula, Op};
use crate::implicit::expr::{Binary, SWUNG_BACK, Unary};
use crate::implicit::written::VmText;

/// Powers up to this are written as products, which more programs know.
const MOST_FACTORS: f64 = 16.0;

impl Formula {
    /// Writes it; the number of the line that is its value.
    pub(in crate::implicit) fn write(&self, text: &mut VmText) -> u32 {
        let mut done: Vec<u32> = Vec::with_capacity(self.ops.len());
        for (i, op) in self.ops.iter().enumerate() {
            let at = |a: u32| done[a as usize];
            done.push(match *op {
                _ if self.is_idle(i) => 0,
                Op::Const(c) => text.constant(c),
                Op::Coordinate(k) => text.coordinate(k as usize),
                Op::Square(a) => text.line("square", &[at(a)]),
                Op::Unary(op, a) | Op::Turn(op, a, _) => unary(text, op, at(a)),
                Op::Binary(Binary::Pow, a, b) => {
                    let exponent = if let Op::Const(c) = self.ops[b as usize] { Some(c) } else { None };
                    power(text, at(a), at(b), exponent)
                }
                Op::Binary(op, a, b) => binary(text, op, at(a), at(b)),
                Op::Select(c, a, b) => {
                    let (c, a, b) = (at(c), at(a), at(b));
                    let zero = text.constant(0.0);
                    let sign = text.line("compare", &[c, zero]);
                    let holds = text.plus(sign, 1.0);
                    let fails = text.line("not", &[holds]);
                    let (a, b) = (text.line("and", &[holds, a]), text.line("and", &[fails, b]));
                    text.line("or", &[a, b])
                }
            });
        }
        done.last().copied().unwrap_or(0)
    }
}

fn unary(text: &mut VmText, op: Unary, a: u32) -> u32 {
    let name = match op {
        Unary::Neg => "neg",
        Unary::Abs => "abs",
        Unary::Sqrt => "sqrt",
        Unary::Exp => "exp",
        Unary::Log => "ln",
        Unary::Sin => "sin",
        Unary::Cos => "cos",
        Unary::Tan => "tan",
        Unary::Asin => "asin",
        Unary::Acos => "acos",
        Unary::Floor => "floor",
        Unary::Sign => {
            let zero = text.constant(0.0);
            return text.line("compare", &[a, zero]);
        }
        Unary::Wrap => {
            let (sin, cos) = (text.line("sin", &[a]), text.line("cos", &[a]));
            return text.line("atan2", &[sin, cos]);
        }
        Unary::Swing => {
            // The larger of back from below and the smaller of ahead and back from above.
            let ahead = unary(text, Unary::Wrap, a);
            let back = text.times(ahead, -SWUNG_BACK);
            let (above, below) = (text.plus(back, PI * SWUNG_BACK), text.plus(back, -PI * SWUNG_BACK));
            let least = text.line("min", &[ahead, above]);
            return text.line("max", &[least, below]);
        }
        Unary::Sinh | Unary::Cosh => {
            let turned = text.line("neg", &[a]);
            let (up, down) = (text.line("exp", &[a]), text.line("exp", &[turned]));
            let both = text.line(if op == Unary::Sinh { "sub" } else { "add" }, &[up, down]);
            return text.times(both, 0.5);
        }
        Unary::Tanh => {
            // 1 - 2 / (e^2a + 1), which does not overflow to what is not a number
            let double = text.times(a, 2.0);
            let grown = text.line("exp", &[double]);
            let under = text.plus(grown, 1.0);
            let inverse = text.line("recip", &[under]);
            let rest = text.times(inverse, -2.0);
            return text.plus(rest, 1.0);
        }
    };
    text.line(name, &[a])
}

fn binary(text: &mut VmText, op: Binary, a: u32, b: u32) -> u32 {
    let name = match op {
        Binary::Add => "add",
        Binary::Sub => "sub",
        Binary::Mul => "mul",
        Binary::Div => "div",
        Binary::Pow => "pow",
        Binary::Min => "min",
        Binary::Max => "max",
        Binary::Atan2 => "atan2",
        Binary::Hypot => {
            let (a, b) = (text.line("square", &[a]), text.line("square", &[b]));
            let sum = text.line("add", &[a, b]);
            return text.line("sqrt", &[sum]);
        }
        // `mod` there is never negative; this has the sign of b.
        Binary::Mod => {
            let share = text.line("div", &[a, b]);
            let whole = text.line("floor", &[share]);
            let taken = text.line("mul", &[b, whole]);
            return text.line("sub", &[a, taken]);
        }
    };
    text.line(name, &[a, b])
}

fn power(text: &mut VmText, a: u32, b: u32, exponent: Option<f64>) -> u32 {
    match exponent {
        Some(0.5) => text.line("sqrt", &[a]),
        Some(n) if n.fract() == 0.0 && n.abs() <= MOST_FACTORS && n != 0.0 => {
            let mut product = a;
            for _ in 1..n.abs() as u32 {
                product = text.line("mul", &[product, a]);
            }
            if n < 0.0 { text.line("recip", &[product]) } else { product }
        }
        _ => text.line("pow", &[a, b]),
    }
}
