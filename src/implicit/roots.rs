//! Leaves with a root whose argument changes its sign, as `k sqrt(w) + r`: the surface is as steep as a wall where `w` is zero,
//! and there is nothing beyond.
//!
//! Where `w >= 0` the sign of `k sqrt(w) + r`, with a positive `k`, is that of `k² w + r |r|`. This goes on smoothly to where `w` is
//! negative. So the nose of an airfoil, `|z| <= sqrt(x) - x`, is a surface like any other.

use super::expr::{Binary, Expr, ExprNode, Unary};
use super::formula::Formula;
use super::roperation::never_negative;
use super::solid::{Placement, Solid};
use super::steps::rewritten;

/// Roots of clamped arguments are looked for this deep.
const DEPTH: usize = 64;
/// A formula with more clamps than this below its roots keeps the rest: each is one more case of all of it.
const MOST_CASES: usize = 8;
/// Points at which a root's argument is looked at for a negative value.
const LOOKS: usize = 256;

/// The argument of a square root.
pub(super) fn under_root(e: &Expr) -> Option<&Expr> {
    match e.node() {
        ExprNode::Unary(Unary::Sqrt, a) => Some(a),
        ExprNode::Binary(Binary::Pow, a, half) if half.as_constant() == Some(0.5) => Some(a),
        _ => None,
    }
}

/// The formula by cases of a clamp, as `max(w, 0)`, below a root: `w` and the bound take its place everywhere.
pub(super) fn by_cases(e: &Expr) -> Expr {
    cases(e, MOST_CASES)
}

fn cases(e: &Expr, left: usize) -> Expr {
    let Some((clamp, [free, bound], above)) = (left > 0).then(|| clamp_below_root(e, 0)).flatten() else {
        return e.clone();
    };
    let with = |other: &Expr| {
        let e = rewritten(e, |x| (*x == clamp).then(|| other.clone()));
        cases(&e, left - 1)
    };
    let beyond = free.clone() - bound.clone();
    Expr::select(if above { beyond } else { -beyond }, with(&free), with(&bound))
}

/// A clamp below a root that is added, and so may be what ends the surface; with its operands, and whether it is a lower bound.
fn clamp_below_root(e: &Expr, depth: usize) -> Option<(Expr, [Expr; 2], bool)> {
    if depth > DEPTH {
        return None;
    }
    let deeper = |e: &Expr| clamp_below_root(e, depth + 1);
    if let Some(under) = under_root(e) {
        return if may_vanish(under) { innermost_clamp(under) } else { None };
    }
    match e.node() {
        ExprNode::Unary(Unary::Neg | Unary::Abs, a) => deeper(a),
        ExprNode::Binary(Binary::Add | Binary::Sub | Binary::Min | Binary::Max, a, b) => {
            deeper(a).or_else(|| deeper(b))
        }
        ExprNode::Binary(Binary::Mul, a, b) if a.as_constant().is_some() => deeper(b),
        ExprNode::Binary(Binary::Mul | Binary::Div, a, b) if b.as_constant().is_some() => deeper(a),
        ExprNode::Select(_, a, b) => deeper(a).or_else(|| deeper(b)),
        _ => None,
    }
}

/// A minimum or maximum of a formula and a number: these, and whether it is a maximum.
fn clamp(e: &Expr) -> Option<([Expr; 2], bool)> {
    let ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) = e.node() else { return None };
    let is_lower = *op == Binary::Max;
    match (a.as_constant(), b.as_constant()) {
        (None, Some(_)) => Some(([a.clone(), b.clone()], is_lower)),
        (Some(_), None) => Some(([b.clone(), a.clone()], is_lower)),
        _ => None,
    }
}

fn innermost_clamp(e: &Expr) -> Option<(Expr, [Expr; 2], bool)> {
    let ([free, bound], is_lower) = clamp(e)?;
    innermost_clamp(&free).or_else(|| Some((e.clone(), [free, bound], is_lower)))
}

/// Whether no clamp keeps it away from zero.
fn may_vanish(e: &Expr) -> bool {
    match clamp(e) {
        Some(([free, bound], is_lower)) => {
            let kept = is_lower && bound.as_constant().is_some_and(|c| c > 0.0);
            !kept && may_vanish(&free)
        }
        None => true,
    }
}

/// Whether a root has no value somewhere, as seen at points near and far.
pub(super) fn is_bare(root: &Expr) -> bool {
    let Some(under) = under_root(root).filter(|w| !never_negative(w)) else { return false };
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut points = [[0.0; LOOKS]; 3];
    for i in 0..LOOKS {
        let size = 10f64.powf(7.0 * unit() - 3.0);
        points.iter_mut().for_each(|p| p[i] = size * (2.0 * unit() - 1.0));
    }
    let mut values = [0.0; LOOKS];
    let [x, y, z] = &points;
    Formula::compile(under, &Placement::IDENTITY).eval(x, y, z, &mut values);
    values.iter().any(|v| *v < 0.0)
}

/// `k sqrt(w) + rest >= 0`, without the root.
pub(super) fn without_root(w: &Expr, k: f64, rest: &Expr) -> Solid {
    let (w, k2) = (w.clone(), k * k);
    if k < 0.0 {
        return Solid::formula(w.clone()) & Solid::formula(signed_square(rest) - w * k2);
    }
    // Where the rest is nowhere positive, `k² w` is more than its square.
    if never_negative(&negated(rest)) {
        return Solid::formula(w * k2 + signed_square(rest));
    }
    // Two of these with a nose between them, `k sqrt(w) + c ± u`, meet where `w` is zero, too. They hide it from what is linear between
    // points, whatever `c` does, if they fall the faster beyond.
    let beyond = Expr::unary(Unary::Steepened, w.clone()) * k2 + signed_square(rest);
    Solid::formula(w) & Solid::formula(beyond)
}

fn negated(e: &Expr) -> Expr {
    match e.node() {
        ExprNode::Unary(Unary::Neg, a) => a.clone(),
        ExprNode::Binary(op @ (Binary::Mul | Binary::Div), a, b) => match b.as_constant() {
            Some(c) => Expr::binary(*op, a.clone(), Expr::constant(-c)),
            None => -e.clone(),
        },
        _ => -e.clone(),
    }
}

/// `e |e|`
fn signed_square(e: &Expr) -> Expr {
    let below = negated(e);
    if never_negative(e) {
        square(e)
    } else if never_negative(&below) {
        -square(&below)
    } else {
        e.clone() * Expr::unary(Unary::Abs, e.clone())
    }
}

fn square(e: &Expr) -> Expr {
    let whole = || e.clone() * e.clone();
    match e.node() {
        ExprNode::Unary(Unary::Abs, a) => a.clone() * a.clone(),
        ExprNode::Unary(Unary::Sqrt, a) => a.clone(),
        ExprNode::Binary(Binary::Hypot, a, b) => a.clone() * a.clone() + b.clone() * b.clone(),
        ExprNode::Binary(Binary::Mul, a, b) => match b.as_constant() {
            Some(c) => square(a) * (c * c),
            None => whole(),
        },
        ExprNode::Binary(Binary::Div, a, b) => match b.as_constant() {
            Some(c) => square(a) / (c * c),
            None => whole(),
        },
        _ => whole(),
    }
}
