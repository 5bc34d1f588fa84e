//! Formulas as cases of the sign of what a switch inside them hangs on.
//!
//! `|u|`, `min(a, b)` and conditions hang on the sign of one formula: `u`, `a - b`, the condition. On either side of where that is zero
//! the whole formula is another without the switch. Where the two have different slopes there is a crease, however deep the switch.
//! Where they have the same there is none, though single switches have one: in `min(a, b) - max(k - |a - b|, 0)**2 / (4*k)` the crease
//! of `min` is undone by that of `|a - b|`.

use rustc_hash::FxHashSet;

use super::expr::{Binary, Expr, ExprNode, Unary, operands};
use super::joints::{Joint, is_smooth, joint_of_surface};
use super::roperation::Terms;
use super::steps::rewritten;

/// The terms of a sum are looked through this deep for a minimum or a maximum.
const DEEPEST: usize = 16;
/// So many switches of a formula are looked at for a crease: each is asked for at points.
const MOST_SWITCHES: usize = 16;

/// What a switch hangs on the sign of.
struct Switch {
    by: Expr,
    /// Whether it is the second operand that is greater where that is positive.
    turned: bool,
}

impl Switch {
    fn of(e: &Expr) -> Option<Self> {
        let by = |by: &Expr, turned| Some(Self { by: by.clone(), turned });
        match e.node() {
            ExprNode::Unary(Unary::Abs, a) => by(a, false),
            ExprNode::Select(c, ..) => by(c, false),
            ExprNode::Binary(Binary::Min | Binary::Max, a, b) => match (a.as_constant(), b.as_constant()) {
                (Some(0.0), _) => by(b, true),
                (_, Some(0.0)) => by(a, false),
                _ => by(&(a.clone() - b.clone()), false),
            },
            _ => None,
        }
    }
}

/// A formula on both sides of where another is zero.
pub(super) struct Cases {
    pub(super) by: Expr,
    pub(super) above: Expr,
    pub(super) below: Expr,
}

impl Cases {
    fn new(e: &Expr, by: Expr, terms: &mut Terms) -> Self {
        let numbers = both_ways(&by, terms);
        let [above, below] = [true, false].map(|above| on_side(e, numbers, above, terms));
        Self { by, above, below }
    }
}

/// The numbers of a formula and of its opposite.
fn both_ways(e: &Expr, terms: &mut Terms) -> [u32; 2] {
    let back = match e.node() {
        ExprNode::Binary(Binary::Sub, a, b) => b.clone() - a.clone(),
        ExprNode::Unary(Unary::Neg, a) => a.clone(),
        _ => -e.clone(),
    };
    [terms.number(e), terms.number(&back)]
}

/// The formula where what has the first number is positive, or negative. What has the second one is its opposite.
fn on_side(e: &Expr, [forth, back]: [u32; 2], above: bool, terms: &mut Terms) -> Expr {
    rewritten(e, |e| {
        let switch = Switch::of(e)?;
        let positive = match terms.number(&switch.by) {
            n if n == forth => above,
            n if n == back => !above,
            _ => return None,
        };
        Some(match e.node() {
            ExprNode::Select(_, a, b) => if positive { a } else { b }.clone(),
            ExprNode::Binary(op, a, b) => {
                let is_first = (positive != switch.turned) == (*op == Binary::Max);
                if is_first { a } else { b }.clone()
            }
            _ if positive => switch.by,
            _ => -switch.by,
        })
    })
}

/// The same formula with minima and maxima that something else rounds off as cases of one sign.
pub(super) fn rounded(e: &Expr) -> Expr {
    let mut terms = Terms::default();
    rewritten(e, |e| {
        let ExprNode::Binary(Binary::Add | Binary::Sub, p, q) = e.node() else { return None };
        let by = [(p, q), (q, p)].into_iter().find_map(|(p, q)| rounded_off(p, q, &mut terms, 0))?;
        let cases = Cases::new(e, by, &mut terms);
        is_smooth(&cases.by, &cases.above, &cases.below).then(|| Expr::select(cases.by, cases.above, cases.below))
    })
}

/// What a minimum or maximum among the terms of `p` hangs on, if an absolute value in `q` does so, too.
fn rounded_off(p: &Expr, q: &Expr, terms: &mut Terms, depth: usize) -> Option<Expr> {
    if depth > DEEPEST {
        return None;
    }
    match p.node() {
        ExprNode::Binary(Binary::Min | Binary::Max, a, b) => {
            let by = a.clone() - b.clone();
            let numbers = both_ways(&by, terms);
            let is_same = |e: &Expr| {
                let ExprNode::Unary(Unary::Abs, a) = e.node() else { return false };
                numbers.contains(&terms.number(a))
            };
            inner_first(q).into_iter().any(is_same).then_some(by)
        }
        ExprNode::Unary(Unary::Neg, a) => rounded_off(a, q, terms, depth + 1),
        ExprNode::Binary(Binary::Add | Binary::Sub, a, b) => {
            [a, b].into_iter().find_map(|p| rounded_off(p, q, terms, depth + 1))
        }
        ExprNode::Binary(Binary::Mul | Binary::Div, a, k) if k.as_constant().is_some() => {
            rounded_off(a, q, terms, depth + 1)
        }
        ExprNode::Binary(Binary::Mul, k, a) if k.as_constant().is_some() => rounded_off(a, q, terms, depth + 1),
        _ => None,
    }
}

/// The switches of a formula, each after those inside it.
fn inner_first(e: &Expr) -> Vec<&Expr> {
    let mut seen = FxHashSet::default();
    let mut found = Vec::new();
    let mut stack = vec![(e, false)];
    while let Some((e, ready)) = stack.pop() {
        if ready {
            found.push(e);
        } else if seen.insert(std::ptr::from_ref(e.node())) {
            if matches!(
                e.node(),
                ExprNode::Unary(Unary::Abs, _) | ExprNode::Select(..) | ExprNode::Binary(Binary::Min | Binary::Max, ..)
            ) {
                stack.push((e, true));
            }
            stack.extend(operands(e).into_iter().rev().map(|x| (x, false)));
        }
    }
    found
}

/// The cases of a switch that makes a crease of the surface, if there is one. Both have values beyond it.
pub(super) fn creased(e: &Expr, terms: &mut Terms) -> Option<Cases> {
    let mut asked = FxHashSet::default();
    for switch in inner_first(e).into_iter().filter_map(Switch::of) {
        if !asked.insert(terms.number(&switch.by)) {
            continue;
        }
        if asked.len() > MOST_SWITCHES {
            return None;
        }
        let cases = Cases::new(e, switch.by, terms);
        if joint_of_surface(&cases.by, &cases.above, &cases.below) == Joint::Creased {
            return Some(cases);
        }
    }
    None
}
