//! Angles inside sines and cosines. `atan2` jumps by a turn behind its origin, and its bounds over a box there are useless. A
//! sine does not see whole turns: there the same angle with its jump on the other side has the same sine, and good bounds.

use std::f64::consts::PI;

use rustc_hash::{FxHashMap, FxHashSet};

use super::beyond::DEEPEST;
use super::expr::{Binary, Expr, ExprNode, Unary, operands};
use super::roperation::never_negative;
use crate::numeric::ROUNDING;

fn is_whole(turns: f64) -> bool {
    // A number of turns is whole up to the rounding of factors.
    (turns - turns.round()).abs() < ROUNDING
}

/// Where a formula jumps.
pub(super) struct Branches {
    /// For each sine and cosine whose argument jumps by whole turns, the argument with `atan2(y, x)` in the form
    /// `atan2(-y, -x) + pi`, which jumps elsewhere.
    pub(super) found: FxHashMap<*const ExprNode, Expr>,
    /// By how many turns each subformula jumps; `None` where it does something else at a jump.
    jumps: FxHashMap<*const ExprNode, Option<f64>>,
}

pub(super) fn branches(e: &Expr) -> Branches {
    let mut found = FxHashMap::default();
    let mut jumps: FxHashMap<*const ExprNode, Option<f64>> = FxHashMap::default();
    let mut stack = vec![(e, false)];
    while let Some((e, ready)) = stack.pop() {
        let key: *const ExprNode = e.node();
        if jumps.contains_key(&key) {
            continue;
        }
        if !ready {
            stack.push((e, true));
            stack.extend(operands(e).into_iter().map(|x| (x, false)));
            continue;
        }
        let of = |e: &Expr| jumps.get(&std::ptr::from_ref(e.node())).copied().flatten();
        let smooth = |all: &[&Expr]| all.iter().all(|e| of(e) == Some(0.0)).then_some(0.0);
        let jump = match e.node() {
            ExprNode::Const(_) | ExprNode::Coordinate(_) => Some(0.0),
            ExprNode::Unary(Unary::Neg, a) => of(a).map(|j| -j),
            ExprNode::Unary(
                Unary::Sin | Unary::Cos | Unary::Swing | Unary::Fold | Unary::Upward | Unary::Downward,
                a,
            ) => match of(a) {
                Some(0.0) => Some(0.0),
                Some(j) if is_whole(j) => other(a, &jumps, 0).map(|o| {
                    found.insert(key, o);
                    0.0
                }),
                _ => None,
            },
            ExprNode::Unary(Unary::Wrap, a) => match of(a) {
                Some(0.0) => Some(1.0),
                Some(j) if is_whole(j) => other(a, &jumps, 0).map(|o| {
                    found.insert(key, o);
                    1.0
                }),
                _ => None,
            },
            // Jumps that are no turns.
            ExprNode::Unary(Unary::Floor | Unary::Sign, _) | ExprNode::Binary(Binary::Mod, ..) => None,
            ExprNode::Unary(_, a) => smooth(&[a]),
            ExprNode::Binary(Binary::Add, a, b) => of(a).zip(of(b)).map(|(a, b)| a + b),
            ExprNode::Binary(Binary::Sub, a, b) => of(a).zip(of(b)).map(|(a, b)| a - b),
            ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
                (Some(k), _) => of(b).map(|j| k * j),
                (_, Some(k)) => of(a).map(|j| k * j),
                _ => smooth(&[a, b]),
            },
            ExprNode::Binary(Binary::Div, a, b) => match b.as_constant() {
                Some(k) => of(a).map(|j| j / k),
                None => smooth(&[a, b]),
            },
            ExprNode::Binary(Binary::Atan2, a, b) => {
                let turns = if never_negative(a) || never_negative(b) { 0.0 } else { 1.0 };
                smooth(&[a, b]).map(|_| turns)
            }
            ExprNode::Binary(_, a, b) => smooth(&[a, b]),
            ExprNode::Select(a, b, c) => smooth(&[a, b, c]),
        };
        jumps.insert(key, jump);
    }
    Branches { found, jumps }
}

impl Branches {
    /// An angle whose jump the formula shows: `atan2` of what does not jump, or an angle less whole turns.
    pub(super) fn seen<'a>(&self, e: &'a Expr) -> Option<&'a Expr> {
        let jump = |e: &Expr| self.jumps.get(&std::ptr::from_ref(e.node())).copied().flatten();
        let mut looked_at = FxHashSet::default();
        let mut stack = vec![e];
        while let Some(e) = stack.pop() {
            if jump(e) == Some(0.0) || !looked_at.insert(std::ptr::from_ref(e.node())) {
                continue;
            }
            let is_angle = match e.node() {
                ExprNode::Binary(Binary::Atan2, y, x) => [y, x].iter().all(|e| jump(e) == Some(0.0)),
                ExprNode::Unary(Unary::Wrap, t) => jump(t).is_some_and(is_whole),
                _ => false,
            };
            if is_angle {
                return Some(e);
            }
            stack.extend(operands(e));
        }
        None
    }
}

/// A sum of angles with each `atan2` in its other form.
fn other(e: &Expr, jumps: &FxHashMap<*const ExprNode, Option<f64>>, depth: usize) -> Option<Expr> {
    if depth > DEEPEST {
        return None;
    }
    let of = |e: &Expr| other(e, jumps, depth + 1);
    if jumps.get(&std::ptr::from_ref(e.node())).copied().flatten() == Some(0.0) {
        return Some(e.clone());
    }
    Some(match e.node() {
        ExprNode::Unary(Unary::Wrap, a) => Expr::unary(Unary::Wrap, a.clone() - PI) + PI,
        ExprNode::Unary(op, a) => Expr::unary(*op, of(a)?),
        ExprNode::Binary(Binary::Atan2, y, x) => Expr::binary(Binary::Atan2, -y.clone(), -x.clone()) + PI,
        ExprNode::Binary(op, a, b) => Expr::binary(*op, of(a)?, of(b)?),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::formula::Formula;
    use crate::implicit::solid::Placement;
    use crate::numeric::Interval;

    #[test]
    fn sines_of_angles_have_good_bounds_on_both_sides_of_a_jump() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let turn = Expr::binary(Binary::Atan2, y, x);
        let sin = |e: Expr| Expr::unary(Unary::Sin, e);
        // Whole turns are not seen; half ones are.
        for (e, good) in [
            (sin(turn.clone() * 5.0 + z.clone()), true),
            (sin((z.clone() / 1.5 - turn.clone() / (2.0 * PI)) * (2.0 * PI)), true),
            (Expr::unary(Unary::Cos, -turn.clone() + sin(turn.clone() * 2.0)), true),
            (sin(turn.clone() * 0.5 + z.clone()), false),
            (turn.clone() + z.clone(), false),
        ] {
            let f = Formula::compile(&e, &Placement::IDENTITY);
            for at in [[-1.0, 0.0, 0.3], [1.0, 0.0, 0.3], [-0.4, 0.7, 0.0], [0.2, -0.9, 0.1]] {
                let around = |c: f64| Interval::new(c - 0.01, c + 0.01);
                let b = at.map(around);
                let (range, slopes) = (f.range(b[0], b[1], b[2]), f.slopes(&b));
                let crosses = at[0] < 0.0 && at[1] == 0.0;
                assert_eq!(range.hi - range.lo < 0.3, good || !crosses, "{e:?} {at:?} {range:?}");
                for k in 0..125 {
                    let p: [f64; 3] =
                        std::array::from_fn(|i| at[i] + 0.005 * f64::from(k / 5i32.pow(i as u32) % 5 - 2));
                    let mut v = [0.0];
                    f.eval(&[p[0]], &[p[1]], &[p[2]], &mut v);
                    let g = f.gradient(p.into());
                    assert!(range.lo <= v[0] && v[0] <= range.hi && (g.v - v[0]).abs() < 1e-14, "{e:?} {p:?}");
                    let held = (0..3).all(|i| slopes.gradient[i].contains(g.g[i]));
                    assert!(held && slopes.value.contains(v[0]), "{e:?} {p:?}");
                }
            }
        }
    }
}
