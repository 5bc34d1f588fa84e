//! Formulas with angles that jump in sight, as set operations of formulas that do not jump where they are asked.
//!
//! Behind its origin `atan2(y, x)` jumps by a turn. A wall is there if the formula shows it: a cam's step, a ramp's end. Above the plane
//! `y = 0` the angle goes on upward beyond the wall, below it downward. So the wall lies in a plane, and its rims are edges between
//! leaves. Elsewhere both forms are the same number bit by bit, and no wall is where one follows the other.

use super::branches::branches;
use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::Terms;
use super::solid::Solid;
use super::split::DIVIDED;
use super::steps::rewritten;

/// An angle that swings back smoothly where [`Unary::Swing`] does, on the other side from where it is asked, and jumps nowhere.
pub(super) fn swinging(y: Expr, x: Expr) -> Expr {
    let angle = Expr::binary(Binary::Atan2, y, x);
    match angle.node() {
        ExprNode::Unary(Unary::Wrap, t) => Expr::unary(Unary::Swing, t.clone()),
        _ => Expr::unary(Unary::Swing, angle),
    }
}

/// `yes` where `at`, else `no`: where all are decided alike nothing is left to ask.
pub(super) fn cases(at: &Solid, yes: Solid, no: Solid) -> Solid {
    (at.clone() & yes) | (!at.clone() & no)
}

/// The solid `e >= 0` in two cases of an angle whose jump `e` shows, if there is one.
pub(super) fn beside_jump(e: &Expr) -> Option<Solid> {
    let all = branches(e);
    let angle = all.seen(e)?;
    let (y, x, turning) = match angle.node() {
        ExprNode::Binary(_, y, x) => (y.clone(), x.clone(), angle),
        ExprNode::Unary(_, t) => (Expr::unary(Unary::Sin, t.clone()), Expr::unary(Unary::Cos, t.clone()), t),
        _ => return None,
    };
    let mut terms = Terms::default();
    let number = terms.number(angle);
    let mut with = |op: Unary| {
        let other = Expr::unary(op, turning.clone());
        let is_angle =
            |e: &Expr| matches!(e.node(), ExprNode::Binary(Binary::Atan2, ..) | ExprNode::Unary(Unary::Wrap, _));
        Solid::formula(rewritten(e, |e| (is_angle(e) && terms.number(e) == number).then(|| other.clone())))
    };
    let (above, below) = (with(Unary::Upward), with(Unary::Downward));
    // Behind by no more than 121 degrees the two are the same.
    let at = Solid::formula(y.clone()) | Solid::formula(x - y * DIVIDED);
    Some(cases(&at, above, below))
}
