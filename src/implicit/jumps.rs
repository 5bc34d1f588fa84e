//! Formulas with angles that jump in sight, as set operations of formulas that do not jump where they are asked.
//!
//! Behind its origin `atan2(y, x)` jumps by a turn. A wall is there if the formula shows it: a cam's step, a ramp's end. Above the plane
//! `y = 0` the angle goes on upward beyond the wall, below it downward. So the wall lies in a plane, and its rims are edges between
//! leaves. Elsewhere both forms are the same number bit by bit, and no wall is where one follows the other.

use super::branches::branches;
use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::Terms;
use super::solid::Solid;
use super::steps::rewritten;

/// The tangent of about 31 degrees, beyond a right angle: there one form follows the other, on the way from where surfaces like to end to
/// where the forms part, at 150 degrees.
const SAME: f64 = 0.611;

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
    // Up to 121 degrees to the side one is as good as the other.
    let at = Solid::formula(y.clone()) | Solid::formula(x - y * SAME);
    Some(cases(&at, above, below))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::formula::Formula;
    use crate::implicit::solid::Placement;
    use crate::implicit::{Implicit, RSystem};
    use crate::spatial::Aabb;

    #[test]
    fn solids_beside_jumps_are_the_same() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let un = Expr::unary;
        let turn = Expr::binary(Binary::Atan2, y.clone(), x.clone());
        let radius = Expr::binary(Binary::Hypot, x.clone(), y.clone());
        let saw = |k: f64| {
            let [sin, cos] = [Unary::Sin, Unary::Cos].map(|op| un(op, turn.clone() * k));
            Expr::binary(Binary::Atan2, sin, cos)
        };
        // With how many leaves: two dividers and two forms for each jump in sight.
        let cases = [
            (turn.clone() * 0.1 + 0.5 - radius.clone(), 4),
            (saw(5.0) * 0.05 + 0.6 - radius.clone(), 4),
            (turn.clone() * z.clone() - x.clone() + 0.1, 4),
            (un(Unary::Cos, turn.clone() * 0.5) * 0.7 - radius.clone(), 4),
            (Expr::binary(Binary::Atan2, z.clone(), -x.clone()) + turn.clone() - 0.3, 8),
            // No jump is seen.
            (un(Unary::Cos, turn.clone() * 3.0) * 0.2 + 0.5 - radius.clone(), 1),
            (Expr::binary(Binary::Atan2, y.clone(), Expr::constant(1.0)) - z.clone(), 1),
            (Expr::binary(Binary::Atan2, radius, z.clone()) - 0.8, 1),
        ];
        let domain = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.2));
        for (e, leaves) in cases {
            let model = Implicit::new(&Solid::formula(e.clone()), RSystem::R0, Some(domain)).unwrap();
            // Six are the domain's walls.
            let found = model.leaf_count() - 6;
            assert!(found <= leaves && (found > 1 || leaves == 1), "{found} leaves: {e:?}");
            let whole = Formula::compile(&e, &Placement::IDENTITY);
            let n = 13;
            for i in 0..n * n * n {
                let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 0.999;
                assert_eq!(model.inside(p), whole.gradient(p).v >= 0.0, "{e:?} {p}");
            }
        }
    }

    #[test]
    fn forms_of_an_angle_are_equal_bit_by_bit_but_near_the_wall() {
        let turn = Expr::binary(Binary::Atan2, Expr::y(), Expr::x());
        let [up, down] = [Unary::Upward, Unary::Downward]
            .map(|op| Formula::compile(&(Expr::unary(op, turn.clone()) * 0.3 - Expr::z()), &Placement::IDENTITY));
        assert!(up.kin().is_some() && up.kin() == down.kin() && up.fingerprint() != down.fingerprint());
        for k in 0..360 {
            let (angle, radius) = (f64::from(k - 180) + 0.5, 1.0 + 0.01 * f64::from(k));
            let (sin, cos) = angle.to_radians().sin_cos();
            let p = DVec3::new(radius * cos, radius * sin, 0.25);
            let cell = Aabb::new(p - 0.01, p + 0.01);
            let same = up.value(p).to_bits() == down.value(p).to_bits();
            assert_eq!(same, angle.abs() < 150.0, "{angle}");
            let proved = up.is_same_as_kin(&cell) && down.is_same_as_kin(&cell);
            assert!(same || !proved, "{angle}");
            assert!(proved || angle.abs() > 148.0, "{angle}");
        }
    }
}
