//! A compiled formula as operations of a file.

use std::f64::consts::PI;

use super::{Formula, Op};
use crate::implicit::expr::{BEYOND, Binary, STEEPENED, SWUNG_BACK, Unary};
use crate::implicit::written::{Operations, Words};

/// Powers up to this are written as products, which more programs know.
const MOST_FACTORS: f64 = 16.0;

impl Formula {
    /// Writes it; the number of the line that is its value.
    pub(in crate::implicit) fn write(&self, list: &mut Operations) -> u32 {
        let mut done: Vec<u32> = Vec::with_capacity(self.ops.len());
        for (i, op) in self.ops.iter().enumerate() {
            let at = |a: u32| done[a as usize];
            done.push(match *op {
                _ if self.is_idle(i) => 0,
                Op::Const(c) => list.constant(c),
                Op::Coordinate(k) => list.coordinate(k as usize),
                Op::Square(a) => list.line("square", &[at(a)]),
                Op::Unary(op, a) | Op::Turn(op, a, _) => unary(list, op, at(a)),
                Op::Binary(Binary::Pow, a, b) => {
                    let exponent = if let Op::Const(c) = self.ops[b as usize] { Some(c) } else { None };
                    power(list, at(a), at(b), exponent)
                }
                Op::Binary(op, a, b) => binary(list, op, at(a), at(b)),
                Op::Select(c, a, b) | Op::Joined(c, a, b) => {
                    let (c, a, b) = (at(c), at(a), at(b));
                    if list.words == Words::Many {
                        done.push(list.line("select", &[c, a, b]));
                        continue;
                    }
                    let zero = list.constant(0.0);
                    let sign = list.line("compare", &[c, zero]);
                    let holds = list.plus(sign, 1.0);
                    let fails = list.line("not", &[holds]);
                    let (a, b) = (list.line("and", &[holds, a]), list.line("and", &[fails, b]));
                    list.line("or", &[a, b])
                }
            });
        }
        done.last().copied().unwrap_or(0)
    }
}

fn unary(list: &mut Operations, op: Unary, a: u32) -> u32 {
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
        Unary::Sign if list.words == Words::Many => "sign",
        Unary::Sinh if list.words == Words::Many => "sinh",
        Unary::Cosh if list.words == Words::Many => "cosh",
        Unary::Tanh if list.words == Words::Many => "tanh",
        Unary::Sign => {
            let zero = list.constant(0.0);
            return list.line("compare", &[a, zero]);
        }
        Unary::Wrap => {
            let (sin, cos) = (list.line("sin", &[a]), list.line("cos", &[a]));
            return list.line("atan2", &[sin, cos]);
        }
        Unary::Upward | Unary::Downward => {
            let by = if op == Unary::Upward { BEYOND } else { -BEYOND };
            let back = list.plus(a, -by);
            let angle = unary(list, Unary::Wrap, back);
            return list.plus(angle, by);
        }
        Unary::Fold => {
            let angle = unary(list, Unary::Wrap, a);
            return list.line("abs", &[angle]);
        }
        Unary::Steepened => {
            let steeper = list.times(a, STEEPENED);
            return list.line("min", &[a, steeper]);
        }
        Unary::Swing => {
            // The larger of back from below and the smaller of ahead and back from above.
            let ahead = unary(list, Unary::Wrap, a);
            let back = list.times(ahead, -SWUNG_BACK);
            let (above, below) = (list.plus(back, PI * SWUNG_BACK), list.plus(back, -PI * SWUNG_BACK));
            let least = list.line("min", &[ahead, above]);
            return list.line("max", &[least, below]);
        }
        Unary::Sinh | Unary::Cosh => {
            let turned = list.line("neg", &[a]);
            let (up, down) = (list.line("exp", &[a]), list.line("exp", &[turned]));
            let both = list.line(if op == Unary::Sinh { "sub" } else { "add" }, &[up, down]);
            return list.times(both, 0.5);
        }
        Unary::Tanh => {
            // 1 - 2 / (e^2a + 1), which does not overflow to what is not a number
            let double = list.times(a, 2.0);
            let grown = list.line("exp", &[double]);
            let under = list.plus(grown, 1.0);
            let inverse = list.line("recip", &[under]);
            let rest = list.times(inverse, -2.0);
            return list.plus(rest, 1.0);
        }
    };
    list.line(name, &[a])
}

fn binary(list: &mut Operations, op: Binary, a: u32, b: u32) -> u32 {
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
            let (a, b) = (list.line("square", &[a]), list.line("square", &[b]));
            let sum = list.line("add", &[a, b]);
            return list.line("sqrt", &[sum]);
        }
        Binary::Mod if list.words == Words::Many => "mod",
        // `mod` there is never negative; this has the sign of b.
        Binary::Mod => {
            let share = list.line("div", &[a, b]);
            let whole = list.line("floor", &[share]);
            let taken = list.line("mul", &[b, whole]);
            return list.line("sub", &[a, taken]);
        }
    };
    list.line(name, &[a, b])
}

fn power(list: &mut Operations, a: u32, b: u32, exponent: Option<f64>) -> u32 {
    match exponent {
        Some(0.5) => list.line("sqrt", &[a]),
        Some(n) if n.fract() == 0.0 && n.abs() <= MOST_FACTORS && n != 0.0 => {
            let mut product = a;
            for _ in 1..n.abs() as u32 {
                product = list.line("mul", &[product, a]);
            }
            if n < 0.0 { list.line("recip", &[product]) } else { product }
        }
        _ => list.line("pow", &[a, b]),
    }
}
