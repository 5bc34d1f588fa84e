//! Switches inside functions that rise, as switches of such functions: `exp(min(a, b))` is `min(exp(a), exp(b))`.

use std::sync::Arc;

use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::never_negative;
use super::valued::DEEPEST;

/// A formula as the lesser, or the greater, of two others.
struct Pulled {
    op: Binary,
    sides: [Expr; 2],
}

impl Pulled {
    fn with(self, falls: bool, f: impl Fn(Expr) -> Expr) -> Self {
        let op = match (falls, self.op) {
            (true, Binary::Min) => Binary::Max,
            (true, _) => Binary::Min,
            (false, op) => op,
        };
        Self { op, sides: self.sides.map(f) }
    }
}

/// Whether a function rises everywhere and has a value for each number.
fn rises(op: Unary) -> bool {
    matches!(op, Unary::Exp | Unary::Sinh | Unary::Tanh)
}

/// The same formula with its first switch outermost, where only functions that rise or fall are around it; `holds` tells which
/// formulas have a switch inside. Logarithms, roots, even powers and `hypot` are passed where both of what they are taken of are never
/// negative.
pub(super) fn outermost(e: &Expr, holds: &dyn Fn(&Expr) -> bool) -> Option<Expr> {
    let Pulled { op, sides: [p, q] } = pulled(e, holds, 0)?;
    Some(Expr::binary(op, p, q))
}

/// What rises for numbers that are not negative, of such.
fn of_sizes(p: Pulled, f: impl Fn(Expr) -> Expr) -> Option<Pulled> {
    p.sides.iter().all(never_negative).then(|| p.with(false, f))
}

fn hypot(a: Expr, b: Expr) -> Expr {
    Expr::binary(Binary::Hypot, a, b)
}

fn pulled(e: &Expr, holds: &dyn Fn(&Expr) -> bool, depth: usize) -> Option<Pulled> {
    if depth > DEEPEST || !holds(e) {
        return None;
    }
    let of = |e: &Expr| pulled(e, holds, depth + 1);
    match e.node() {
        ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => {
            Some(Pulled { op: *op, sides: [a.clone(), b.clone()] })
        }
        ExprNode::Unary(Unary::Abs, a) => Some(Pulled { op: Binary::Max, sides: [a.clone(), -a.clone()] }),
        ExprNode::Unary(Unary::Neg, a) => Some(of(a)?.with(true, |e| -e)),
        ExprNode::Unary(op, a) if rises(*op) => Some(of(a)?.with(false, |e| Expr::unary(*op, e))),
        ExprNode::Unary(Unary::Log, a) => of_sizes(of(a)?, |e| Expr::unary(Unary::Log, e)),
        ExprNode::Unary(Unary::Sqrt, a) => of_sizes(of(a)?, |e| Expr::unary(Unary::Sqrt, e)),
        ExprNode::Binary(Binary::Pow, a, n) if n.as_constant().is_some_and(|n| n > 0.0) => {
            let power = |e: Expr| Expr::binary(Binary::Pow, e, n.clone());
            let is_odd = n.as_constant().is_some_and(|n| n % 2.0 == 1.0);
            let p = of(a)?;
            if is_odd { Some(p.with(false, power)) } else { of_sizes(p, power) }
        }
        ExprNode::Binary(Binary::Mul, a, b) if Arc::ptr_eq(&a.0, &b.0) => of_sizes(of(a)?, |e| e.clone() * e),
        ExprNode::Binary(Binary::Hypot, a, b) => match of(a).and_then(|p| of_sizes(p, |e| hypot(e, b.clone()))) {
            Some(p) => Some(p),
            None => of_sizes(of(b)?, |e| hypot(a.clone(), e)),
        },
        ExprNode::Binary(Binary::Add, a, b) => match of(a) {
            Some(p) => Some(p.with(false, |e| e + b.clone())),
            None => Some(of(b)?.with(false, |e| a.clone() + e)),
        },
        ExprNode::Binary(Binary::Sub, a, b) => match of(a) {
            Some(p) => Some(p.with(false, |e| e - b.clone())),
            None => Some(of(b)?.with(true, |e| a.clone() - e)),
        },
        ExprNode::Binary(op @ (Binary::Mul | Binary::Div), a, b) if let Some(k) = b.as_constant() => {
            (k != 0.0 && k.is_finite()).then_some(())?;
            Some(of(a)?.with(k < 0.0, |e| Expr::binary(*op, e, b.clone())))
        }
        ExprNode::Binary(Binary::Mul, a, b) if let Some(k) = a.as_constant() => {
            (k != 0.0 && k.is_finite()).then_some(())?;
            Some(of(b)?.with(k < 0.0, |e| a.clone() * e))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::solid::Solid;
    use crate::implicit::{Implicit, RSystem};
    use crate::spatial::Aabb;

    #[test]
    fn creases_inside_functions_that_rise_are_edges_between_leaves() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let un = Expr::unary;
        let power = |e: Expr, n: f64| Expr::binary(Binary::Pow, e, Expr::constant(n));
        let abs = |e: &Expr| un(Unary::Abs, e.clone());
        let block = Expr::binary(Binary::Max, abs(&x) - 0.8, abs(&y) - 0.3);
        let near = |e: Expr| un(Unary::Exp, e * -6.0);
        let ball = x.clone() * x.clone() + y.clone() * y.clone() + z.clone() * z.clone() - 0.4;
        let cases = [
            // A smooth minimum of a block and a ball.
            (un(Unary::Log, near(ball.clone()) + near(block.clone())) / 6.0, 4),
            (un(Unary::Exp, abs(&x) * -3.0) - z.clone() - 0.2, 2),
            (un(Unary::Tanh, block.clone() * 3.0) * -2.0 + z.clone(), 4),
            (un(Unary::Sinh, -(Expr::constant(0.4) - abs(&z))) - x.clone(), 2),
            // Cylinders across each other, by sizes.
            (power(Expr::binary(Binary::Max, abs(&x), abs(&y)), 2.0) + z.clone() * z.clone() - 0.4, 2),
            (hypot(Expr::binary(Binary::Max, abs(&x), abs(&z)), y.clone()) - 0.7, 2),
            (un(Unary::Sqrt, Expr::binary(Binary::Max, abs(&x), abs(&y)) + 0.3) - 0.8 + z.clone(), 2),
            (power(Expr::binary(Binary::Min, x.clone(), y.clone()), 3.0) + z.clone(), 2),
            // The logarithm of what may be negative stays whole.
            (un(Unary::Log, abs(&x)) + 0.4, 1),
            // What neither rises nor falls is taken apart by the signs of x, of y, and of what is greater on each side.
            (un(Unary::Cos, block) - 0.9 + z.clone(), 10),
        ];
        let domain = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.2));
        for (e, leaves) in cases {
            let model = Implicit::new(&Solid::formula(e.clone()), RSystem::R0, Some(domain)).unwrap();
            // Six are the domain's walls.
            assert_eq!(model.leaf_count() - 6, leaves, "{e:?}");
            let whole = crate::implicit::formula::Formula::compile(&e, &crate::implicit::Placement::IDENTITY);
            let n = 13;
            for i in 0..n * n * n {
                let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 0.999;
                assert_eq!(model.inside(p), whole.gradient(p).v >= 0.0, "{e:?} {p}");
            }
        }
    }
}
