//! Leaves with a root whose argument changes its sign, as `k sqrt(w) + r`: the surface is as steep as a wall where `w` is zero,
//! and there is nothing beyond.
//!
//! Where `w >= 0` the solid `k sqrt(w) + r >= 0`, with a positive `k`, is where `r >= 0` or `k² w >= r²`. The sign is that of
//! `k² w + r |r|`, too, which goes on smoothly to where `w` is negative. So the nose of an airfoil, `|z| <= sqrt(x) - x`, is a surface
//! like any other.

use rustc_hash::{FxHashMap, FxHashSet};

use super::expr::{Binary, Expr, ExprNode, Unary, operands};
use super::formula::Formula;
use super::joints::LARGEST;
use super::roperation::never_negative;
use super::solid::{Placement, Solid};
use super::steps::{flat, is_small, rewritten};
use super::valued::DEEPEST;

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
    let found = clamped_root(e).filter(|root| !is_hidden(e, root));
    found.and_then(|under| beside_clamp(e, under)).unwrap_or_else(|| cases(e, MOST_CASES))
}

/// `k sqrt(max(w, 0)) + r` as what has the same sign and no root, where `r` is smooth: either of `k² w + r |r|` and `r` is enough for a
/// positive `k`; both of `r |r| - k² w` and `r` are needed for a negative one.
fn beside_clamp(e: &Expr, under: &Expr) -> Option<Expr> {
    let ([w, bound], true) = clamp(under)? else { return None };
    let k = factor_of_root(e, under)?;
    let rest = rewritten(e, |x| (under_root(x) == Some(under)).then(|| Expr::constant(0.0)));
    if bound.as_constant() != Some(0.0) || k == 0.0 || flat(&rest) {
        return None;
    }
    let (steep, square) = (w * (k * k), signed_square(&rest));
    Some(match k > 0.0 {
        true if never_negative(&negated(&rest)) => steep + square,
        true => Expr::binary(Binary::Max, steep + square, rest),
        false => Expr::binary(Binary::Min, square - steep, rest),
    })
}

/// The number that the root is multiplied by in a sum.
fn factor_of_root(e: &Expr, under: &Expr) -> Option<f64> {
    let mut known = FxHashMap::default();
    factor(e, under, &mut known)
}

fn factor(e: &Expr, under: &Expr, known: &mut FxHashMap<*const ExprNode, Option<f64>>) -> Option<f64> {
    if under_root(e) == Some(under) {
        return Some(1.0);
    }
    let key = std::ptr::from_ref(e.node());
    if let Some(k) = known.get(&key) {
        return *k;
    }
    let mut of = |x: &Expr| factor(x, under, known);
    let found = match e.node() {
        _ if clamped_root(e).is_none() => Some(0.0),
        ExprNode::Unary(Unary::Neg, a) => of(a).map(|k| -k),
        ExprNode::Binary(Binary::Add, a, b) => of(a).zip(of(b)).map(|(j, k)| j + k),
        ExprNode::Binary(Binary::Sub, a, b) => of(a).zip(of(b)).map(|(j, k)| j - k),
        ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
            (Some(c), _) => of(b).map(|k| c * k),
            (_, Some(c)) => of(a).map(|k| c * k),
            _ => None,
        },
        ExprNode::Binary(Binary::Div, a, b) => of(a).zip(b.as_constant()).map(|(k, c)| k / c),
        _ => None,
    };
    known.insert(key, found);
    found
}

fn cases(e: &Expr, left: usize) -> Expr {
    let found = if left > 0 { clamped_root(e).filter(|root| !is_hidden(e, root)) } else { None };
    let Some((clamp, [free, bound], is_lower)) = found.and_then(innermost_clamp) else { return e.clone() };
    let with = |other: &Expr| {
        let e = rewritten(e, |x| (*x == clamp).then(|| other.clone()));
        cases(&e, left - 1)
    };
    let beyond = free.clone() - bound.clone();
    Expr::select(if is_lower { beyond } else { -beyond }, with(&free), with(&bound))
}

/// The operands whose zeros may be those of the whole.
fn shown(e: &Expr) -> Vec<&Expr> {
    match e.node() {
        ExprNode::Unary(Unary::Neg | Unary::Abs, a) => vec![a],
        ExprNode::Binary(Binary::Add | Binary::Sub | Binary::Min | Binary::Max, a, b) => vec![a, b],
        ExprNode::Binary(Binary::Mul, a, b) => vec![a, b],
        ExprNode::Binary(Binary::Div, a, _) => vec![a],
        ExprNode::Select(_, a, b) => vec![a, b],
        _ => Vec::new(),
    }
}

/// What is below a root that is added, and so may be what ends the surface, if there is a clamp.
fn clamped_root(e: &Expr) -> Option<&Expr> {
    let mut seen = FxHashSet::default();
    let mut stack = vec![(e, 0)];
    while let Some((e, depth)) = stack.pop() {
        if depth > DEEPEST || !seen.insert(std::ptr::from_ref(e.node())) {
            continue;
        }
        match under_root(e) {
            Some(under) if clamp(under).is_some() && may_vanish(under) => return Some(under),
            Some(_) => {}
            None => stack.extend(shown(e).into_iter().rev().map(|x| (x, depth + 1))),
        }
    }
    None
}

/// Whether the root is also where it cannot be taken away: what is below it must have a root everywhere then.
fn is_hidden(e: &Expr, under: &Expr) -> bool {
    let mut seen = FxHashSet::default();
    let mut stack = vec![(e, false)];
    while let Some((e, hidden)) = stack.pop() {
        if !seen.insert((std::ptr::from_ref(e.node()), hidden)) {
            continue;
        }
        if under_root(e) == Some(under) {
            if hidden {
                return true;
            }
            continue;
        }
        let open = if hidden { Vec::new() } else { shown(e) };
        let is_open = |x: &Expr| open.iter().any(|y| std::ptr::eq(x.node(), y.node()));
        stack.extend(operands(e).into_iter().map(|x| (x, !is_open(x))));
    }
    false
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

/// The innermost clamp of clamps within each other.
fn innermost_clamp(e: &Expr) -> Option<(Expr, [Expr; 2], bool)> {
    let mut found = None;
    let mut e = e.clone();
    while let Some(([free, bound], is_lower)) = clamp(&e) {
        found = Some((e, [free.clone(), bound], is_lower));
        e = free;
    }
    found
}

/// Whether no clamp keeps it away from zero.
fn may_vanish(e: &Expr) -> bool {
    let mut e = e.clone();
    while let Some(([free, bound], is_lower)) = clamp(&e) {
        if is_lower && bound.as_constant().is_some_and(|c| c > 0.0) {
            return false;
        }
        e = free;
    }
    true
}

/// Whether a root has no value somewhere, as seen at points near and far.
pub(super) fn is_bare(root: &Expr) -> bool {
    let Some(under) = under_root(root).filter(|w| !never_negative(w) && is_small(w, LARGEST)) else { return false };
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

/// `k sqrt(w) + rest >= 0`, without the root: where `w` is zero the solid may have a wall, which `k² w = rest²` touches.
pub(super) fn without_root(w: &Expr, k: f64, rest: &Expr) -> Solid {
    let steep = Solid::formula(w.clone() * (k * k) - square(rest));
    // Where the rest is nowhere positive, `k² w` is more than its square.
    if k > 0.0 && never_negative(&negated(rest)) {
        return steep;
    }
    let both = Solid::formula(w.clone()) & Solid::formula(rest.clone());
    if k > 0.0 { both | steep } else { both & !steep }
}

/// The same of one side of an absolute value, whose other side begins where `w` is zero, too: `k sqrt(w) + c + u` and
/// `k sqrt(w) + c - u` have a nose between them.
pub(super) fn without_root_at_nose(w: &Expr, k: f64, rest: &Expr) -> Solid {
    if k > 0.0 && never_negative(&negated(rest)) {
        return without_root(w, k, rest);
    }
    // The two hide where `w` is zero from what is linear between points, whatever `c` does, if they fall the faster beyond.
    let steep = Expr::unary(Unary::Steepened, w.clone()) * (k * k);
    let beyond = if k > 0.0 { steep + signed_square(rest) } else { signed_square(rest) - steep };
    Solid::formula(w.clone()) & Solid::formula(beyond)
}

fn negated(e: &Expr) -> Expr {
    match e.node() {
        ExprNode::Binary(Binary::Sub, a, b) if a.as_constant() == Some(0.0) => b.clone(),
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
    let constant = |x: &Expr| x.as_constant().map(|c| c * c);
    match e.node() {
        ExprNode::Binary(Binary::Mul, a, b) if let Some(c) = constant(b) => plain_square(a) * c,
        ExprNode::Binary(Binary::Div, a, b) if let Some(c) = constant(b) => plain_square(a) / c,
        _ => plain_square(e),
    }
}

fn plain_square(e: &Expr) -> Expr {
    match e.node() {
        ExprNode::Unary(Unary::Abs, a) => a.clone() * a.clone(),
        ExprNode::Unary(Unary::Sqrt, a) => a.clone(),
        ExprNode::Binary(Binary::Hypot, a, b) => a.clone() * a.clone() + b.clone() * b.clone(),
        _ => e.clone() * e.clone(),
    }
}

/// `a`, if the formula is an even power of it with an exponent that will do.
pub(super) fn even_power(e: &Expr, will_do: impl Fn(f64) -> bool) -> Option<&Expr> {
    match e.node() {
        ExprNode::Binary(Binary::Pow, a, n) if n.as_constant().is_some_and(|n| n % 2.0 == 0.0 && will_do(n)) => Some(a),
        ExprNode::Binary(Binary::Mul, a, b) if std::sync::Arc::ptr_eq(&a.0, &b.0) && will_do(2.0) => Some(a),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::model::Implicit;
    use super::super::rfunction::RSystem;
    use super::*;
    use crate::spatial::Aabb;

    fn truth(e: &Expr, p: DVec3) -> f64 {
        Formula::in_pieces(e, &Placement::IDENTITY).gradient(p).v
    }

    #[test]
    fn signs_are_those_of_the_roots() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let sqrt = |e: Expr| Expr::unary(Unary::Sqrt, e);
        let clamped = |e: Expr| Expr::binary(Binary::Max, e, Expr::constant(0.0));
        let below_one = |e: Expr| Expr::binary(Binary::Min, e, Expr::constant(1.0));
        let size = |e: Expr| Expr::unary(Unary::Abs, e);
        let hypot = Expr::binary(Binary::Hypot, y.clone(), z.clone());
        let chord = below_one(clamped(x.clone()));
        let formulas = [
            sqrt(x.clone()) * 0.7 - hypot.clone(),
            sqrt(clamped(x.clone())) * 0.7 - hypot,
            sqrt(clamped(x.clone())) * 0.7 - size(z.clone() - x.clone() * y.clone()) - x.clone() * 0.3,
            sqrt(x.clone() * y.clone() + 1.0) * 0.7 + z.clone() * 2.0 - y.clone(),
            z.clone() - sqrt(clamped(x.clone() * x.clone() - y.clone())) * 0.5,
            y.clone() - sqrt(x.clone() - z.clone()) / 3.0,
            sqrt(chord.clone()) * 0.5 - chord.clone() * chord * 0.3 - size(z.clone()),
            size(y.clone()) - sqrt(clamped(z.clone())),
            // The root is in an angle, too.
            sqrt(clamped(x.clone())) - Expr::binary(Binary::Atan2, sqrt(clamped(x)), Expr::constant(1.0)) - z * 0.3,
        ];
        let bounds = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));
        let mut state = 5u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for (n, e) in formulas.iter().enumerate() {
            let model = Implicit::new(&Solid::formula(e.clone()), RSystem::default(), Some(bounds)).unwrap();
            for _ in 0..2000 {
                let p = DVec3::new(unit(), unit(), unit()) * 4.0 - 2.0;
                let truth = truth(e, p);
                // A root that has no value is outside.
                assert_eq!(model.inside(p), truth > 0.0, "formula {n} at {p}: {truth}");
            }
        }
    }
}
