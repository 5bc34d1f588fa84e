//! The value of a level set where its function has none.

use rustc_hash::FxHashMap;

use crate::implicit::expr::operands;
use crate::implicit::expr::{Binary, Expr, ExprNode, Unary};
use crate::implicit::roperation::never_negative;

/// A formula that has a value everywhere, and where that is the value of the formula it was made from.
#[derive(Clone)]
struct Whole {
    value: Expr,
    /// Not negative where the formula has a value; nothing where that is everywhere.
    guard: Option<Expr>,
}

/// The formula, and `fallback` where it has no value: below roots, logarithms and powers of negative numbers, and beyond inverse
/// sines and cosines of -1 to 1. Where a divisor is zero is no more than a surface, and stays as it is.
pub(super) fn with_fallback(formula: &Expr, fallback: f64) -> Expr {
    // Shared nodes stay shared, and chains of nodes may be deeper than a stack.
    let mut known: FxHashMap<*const ExprNode, Whole> = FxHashMap::default();
    let mut stack = vec![formula];
    while let Some(top) = stack.last().copied() {
        let before = stack.len();
        let below = operands(top);
        if !known.contains_key(&key(top)) {
            stack.extend(below.iter().filter(|e| !known.contains_key(&key(e))));
        }
        if stack.len() == before {
            stack.pop();
            if !known.contains_key(&key(top)) {
                let parts: Vec<Whole> = below.iter().map(|e| known[&key(e)].clone()).collect();
                known.insert(key(top), whole(top, &parts));
            }
        }
    }
    let Whole { value, guard } = known[&key(formula)].clone();
    match guard {
        Some(guard) => Expr::select(guard, value, Expr::constant(fallback)),
        None => value,
    }
}

fn key(e: &Expr) -> *const ExprNode {
    std::ptr::from_ref(e.node())
}

/// A node of operands that have values everywhere.
fn whole(node: &Expr, parts: &[Whole]) -> Whole {
    let guards = || parts.iter().filter_map(|p| p.guard.clone());
    let value = |k: usize| parts[k].value.clone();
    let at_least = |e: Expr, least: f64| Expr::binary(Binary::Max, e, Expr::constant(least));
    let (value, own) = match node.node() {
        ExprNode::Const(_) | ExprNode::Coordinate(_) => (node.clone(), None),
        ExprNode::Unary(Unary::Sqrt, _) if !never_negative(&value(0)) => {
            (Expr::unary(Unary::Sqrt, at_least(value(0), 0.0)), Some(value(0)))
        }
        ExprNode::Unary(Unary::Log, _) if !never_negative(&value(0)) => {
            (Expr::unary(Unary::Log, at_least(value(0), f64::MIN_POSITIVE)), Some(value(0)))
        }
        ExprNode::Unary(op @ (Unary::Asin | Unary::Acos), _) => {
            let clamped = Expr::binary(Binary::Min, at_least(value(0), -1.0), Expr::constant(1.0));
            (Expr::unary(*op, clamped), Some(Expr::constant(1.0) - Expr::unary(Unary::Abs, value(0))))
        }
        ExprNode::Binary(Binary::Pow, _, exponent)
            if exponent.as_constant().is_none_or(|b| b.fract() != 0.0) && !never_negative(&value(0)) =>
        {
            (Expr::binary(Binary::Pow, at_least(value(0), f64::MIN_POSITIVE), value(1)), Some(value(0)))
        }
        // What has values everywhere is left as it is written: others look for shapes they know in it.
        _ if guards().next().is_none() => (node.clone(), None),
        ExprNode::Unary(op, _) => (Expr::unary(*op, value(0)), None),
        ExprNode::Binary(op, _, _) => (Expr::binary(*op, value(0), value(1)), None),
        ExprNode::Select(..) => {
            // Only the branch that is taken needs a value.
            let branch = |k: usize| parts[k].guard.clone().unwrap_or_else(|| Expr::constant(1.0));
            let taken = Expr::select(value(0), branch(1), branch(2));
            let guards = [parts[0].guard.clone(), Some(taken)];
            return Whole {
                value: Expr::select(value(0), value(1), value(2)),
                guard: least(guards.into_iter().flatten()),
            };
        }
    };
    Whole { value, guard: least(guards().chain(own)) }
}

fn least(guards: impl Iterator<Item = Expr>) -> Option<Expr> {
    guards.reduce(|a, b| Expr::binary(Binary::Min, a, b))
}
