//! Smooth minima and maxima as they are commonly written, recognized by what they make of two numbers.
//!
//! `h = clamp(0.5 + 0.5*(b - a)/k, 0, 1)` and `b*(1 - h) + a*h - k*h*(1 - h)`, or `min(a, b) - max(k - |a - b|, 0)**2/(4*k)`, or others:
//! whatever the way of writing, it is a function of two formulas, whose difference something in it hangs on, and its values are those of
//! `min(a, b)` less a square, or less a cube.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::expr::{Binary, Expr, ExprNode, operands, with_operands};
use super::formula::Formula;
use super::roperation::Terms;
use super::solid::Placement;
use crate::numeric::LAST_PLACES;

/// The two formulas are looked for among so many subformulas nearest to the root: a block and another fill some hundred before the
/// difference of both is met, seven operations deep.
const NEAREST: usize = 512;
/// A smooth minimum has no more subformulas than this above its two formulas.
const LARGEST: usize = 64;
/// Pairs of numbers for which the values are compared.
const COMPARED: u32 = 48;

/// What a smooth maximum adds to the greater of two numbers that differ by less than its width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kernel {
    /// A quarter of a square, so that it goes over into both numbers without a jump of the slope.
    Square,
    /// A sixth of a cube: without a jump of how it bends.
    Cube,
}

impl Kernel {
    /// What is added, where so much of the width is left beside the difference, both in widths.
    pub(crate) fn added(self, left: f64) -> f64 {
        match self {
            Kernel::Square => 0.25 * left * left,
            Kernel::Cube => left * left * left / 6.0,
        }
    }

    /// The derivative of that: the share of the lesser number in the slope.
    pub(crate) fn share(self, left: f64) -> f64 {
        match self {
            Kernel::Square => 0.5 * left,
            Kernel::Cube => 0.5 * left * left,
        }
    }
}

/// `min(a, b)` or `max(a, b)`, rounded off where the two differ by less than the width.
pub(super) struct SmoothPair {
    pub(super) kernel: Kernel,
    pub(super) sides: [Expr; 2],
    pub(super) width: f64,
    pub(super) is_max: bool,
}

impl SmoothPair {
    /// What a formula is, if it is one of these: however it is written, a sum or a condition is outermost.
    pub(super) fn of(e: &Expr, terms: &mut Terms) -> Option<Self> {
        if !matches!(e.node(), ExprNode::Binary(Binary::Add | Binary::Sub, ..) | ExprNode::Select(..)) {
            return None;
        }
        differences(e).into_iter().find_map(|[a, b]| {
            let shown = in_terms_of(e, [a, b], terms)?;
            [Kernel::Square, Kernel::Cube].into_iter().find_map(|kernel| {
                let (width, is_max) = smooth(&shown, kernel)?;
                Some(Self { kernel, sides: [a.clone(), b.clone()], width, is_max })
            })
        })
    }
}

/// The operands of differences near the root, those nearest first.
fn differences(e: &Expr) -> Vec<[&Expr; 2]> {
    let mut seen = FxHashSet::default();
    let mut row = vec![e];
    let mut found = Vec::new();
    let mut next = 0;
    while next < row.len() {
        let e = row[next];
        next += 1;
        if let ExprNode::Binary(Binary::Sub, a, b) = e.node()
            && a.as_constant().or(b.as_constant()).is_none()
        {
            found.push([a, b]);
        }
        for below in operands(e) {
            if row.len() < NEAREST && seen.insert(std::ptr::from_ref(below.node())) {
                row.push(below);
            }
        }
    }
    found
}

/// A formula with coordinates x and y in the place of two formulas, if it is made of these and numbers alone.
fn in_terms_of(e: &Expr, pair: [&Expr; 2], terms: &mut Terms) -> Option<Expr> {
    let numbers = pair.map(|p| terms.number(p));
    let mut done: FxHashMap<*const ExprNode, Expr> = FxHashMap::default();
    let mut stack = vec![(e, false)];
    let key = |e: &Expr| std::ptr::from_ref(e.node());
    while let Some((e, ready)) = stack.pop() {
        if done.contains_key(&key(e)) {
            continue;
        }
        if done.len() > LARGEST {
            return None;
        }
        let number = terms.number(e);
        let stands = match e.node() {
            _ if number == numbers[0] => Some(Expr::x()),
            _ if number == numbers[1] => Some(Expr::y()),
            ExprNode::Const(_) => Some(e.clone()),
            ExprNode::Coordinate(_) => return None,
            _ => None,
        };
        if let Some(other) = stands {
            done.insert(key(e), other);
            continue;
        }
        if !ready {
            if stack.len() > LARGEST {
                return None;
            }
            stack.push((e, true));
            stack.extend(operands(e).into_iter().map(|x| (x, false)));
            continue;
        }
        let made = with_operands(e, |x| done.get(&key(x)).cloned().unwrap_or_else(|| x.clone()));
        done.insert(key(e), made);
    }
    done.remove(&key(e))
}

/// The width of a function of x and y that is their smooth minimum, or maximum, of a kind, and whether it is the maximum.
fn smooth(of: &Expr, kernel: Kernel) -> Option<(f64, bool)> {
    let compiled = Formula::compile(of, &Placement::IDENTITY);
    let value = |a: f64, b: f64| compiled.value(DVec3::new(a, b, 0.0));
    let middle = value(0.0, 0.0);
    let (width, sign) = (middle.abs() / kernel.added(1.0), middle.signum());
    if !(width > 0.0 && width.is_finite()) {
        return None;
    }
    let agrees = |i: u32| {
        // Evenly spread: the difference from -1.6 to 1.6 widths, the sum to some widths.
        let part = |share: f64| (f64::from(i) * share).fract() - 0.5;
        let (d, s) = (3.2 * width * part(0.618_033_988_749_894_9), 8.0 * width * part(0.414_213_562_373_095_1));
        let (a, b) = (s + 0.5 * d, s - 0.5 * d);
        let left = (width - d.abs()).max(0.0);
        let expected = sign * ((sign * a).max(sign * b) + width * kernel.added(left / width));
        // Values agree up to the rounding of some ten operations.
        (value(a, b) - expected).abs() <= LAST_PLACES * (a.abs() + b.abs() + width)
    };
    (0..COMPARED).all(agrees).then_some((width, sign > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::expr::Unary;

    #[test]
    fn smooth_minima_are_recognized_however_they_are_written() {
        let (a, b) = (Expr::x() * Expr::y() - 0.3, Expr::binary(Binary::Hypot, Expr::y(), Expr::z()) - 1.0);
        let constant = Expr::constant;
        let min = |a: Expr, b: Expr| Expr::binary(Binary::Min, a, b);
        let max = |a: Expr, b: Expr| Expr::binary(Binary::Max, a, b);
        let abs = |a: Expr| Expr::unary(Unary::Abs, a);
        let clamp = |a: Expr| max(min(a, constant(1.0)), constant(0.0));
        let by_clamp = |a: &Expr, b: &Expr, k: f64| {
            let h = clamp((b.clone() - a.clone()) * 0.5 / k + 0.5);
            b.clone() + (a.clone() - b.clone()) * h.clone() - h.clone() * (constant(1.0) - h) * k
        };
        let by_square = |a: &Expr, b: &Expr, k: f64| {
            let h = max(constant(k) - abs(a.clone() - b.clone()), constant(0.0)) / k;
            min(a.clone(), b.clone()) - h.clone() * h * (0.25 * k)
        };
        let by_power = |a: &Expr, b: &Expr, k: f64| {
            let h = max(constant(k) - abs(a.clone() - b.clone()), constant(0.0));
            max(a.clone(), b.clone()) + Expr::binary(Binary::Pow, h, constant(2.0)) / (4.0 * k)
        };
        let cubic = |a: &Expr, b: &Expr, k: f64| {
            let h = max(constant(k) - abs(a.clone() - b.clone()), constant(0.0)) / k;
            min(a.clone(), b.clone()) - Expr::binary(Binary::Pow, h, constant(3.0)) * (k / 6.0)
        };
        let quartic = |a: &Expr, b: &Expr, k: f64| {
            let h = max(constant(k) - abs(a.clone() - b.clone()), constant(0.0)) / k;
            min(a.clone(), b.clone()) - Expr::binary(Binary::Pow, h, constant(4.0)) * (k / 16.0)
        };
        let mut terms = Terms::default();
        for k in [0.2, 3.0] {
            for (e, expected) in [
                (by_clamp(&a, &b, k), Some(false)),
                (by_square(&a, &b, k), Some(false)),
                (by_power(&a, &b, k), Some(true)),
                (by_clamp(&by_square(&a, &b, 0.1), &b, k), Some(false)),
                (-by_clamp(&a, &b, k), None),
                (cubic(&a, &b, k), Some(false)),
                (quartic(&a, &b, k), None),
                (by_clamp(&a, &b, k) + 0.1, None),
                (min(a.clone(), b.clone()), None),
                (a.clone() - b.clone(), None),
            ] {
                let found = SmoothPair::of(&e, &mut terms);
                assert_eq!(found.as_ref().map(|f| f.is_max), expected, "{e:?}");
                if let Some(found) = found {
                    assert!((found.width - k).abs() < 1e-12 * k, "{} {k}", found.width);
                }
            }
        }
    }
}
