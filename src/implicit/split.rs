//! Formulas with creases inside, as set operations of formulas without.
//!
//! `min(a, b) >= 0` is the intersection of `a >= 0` and `b >= 0`; `max` makes a union, `|u| = max(u, -u)`. So the crease of
//! such a formula is an edge between two leaves, like any other. Sums and multiples are looked through, as `min(a, b) + c` is
//! `min(a + c, b + c)`; switches deeper inside (below a root, a product) stay in their leaf, and their creases with them.

use rustc_hash::FxHashMap;

use super::expr::{Binary, Expr, ExprNode, Unary};
use super::solid::Solid;

/// Formulas that would fall into more pieces than this stay whole.
const MOST_PIECES: usize = 256;
/// Switches inside switches are followed this deep.
const DEPTH: usize = 64;

/// The solid `e >= 0` as set operations of formulas, if `e` has switches that can be taken apart.
pub(super) fn split(e: &Expr) -> Option<Solid> {
    let switches = Switches::of(e);
    if !switches.within(e) {
        return None;
    }
    let mut splitter = Splitter { switches, pieces: 0, taken_apart: false };
    let solid = splitter.condition(e, 1.0, &Rest::default(), 0)?;
    splitter.taken_apart.then_some(solid)
}

/// Which subformulas hold a switch.
struct Switches(FxHashMap<*const ExprNode, bool>);

impl Switches {
    fn of(e: &Expr) -> Self {
        let mut known = FxHashMap::default();
        // Without recursion: formulas may be millions of nodes deep.
        let mut stack = vec![(e, false)];
        while let Some((e, children_done)) = stack.pop() {
            let key: *const ExprNode = e.node();
            if known.contains_key(&key) {
                continue;
            }
            let children: &[&Expr] = match e.node() {
                ExprNode::Const(_) | ExprNode::Coordinate(_) => &[],
                ExprNode::Unary(_, a) => &[a],
                ExprNode::Binary(_, a, b) => &[a, b],
                ExprNode::Select(a, b, c) => &[a, b, c],
            };
            if !children_done {
                stack.push((e, true));
                stack.extend(children.iter().map(|c| (*c, false)));
                continue;
            }
            let own = matches!(
                e.node(),
                ExprNode::Unary(Unary::Abs, _) | ExprNode::Binary(Binary::Min | Binary::Max, ..) | ExprNode::Select(..)
            );
            let below = children.iter().any(|c| known.get(&std::ptr::from_ref(c.node())).copied().unwrap_or(false));
            known.insert(key, own || below);
        }
        Self(known)
    }

    fn within(&self, e: &Expr) -> bool {
        self.0.get(&std::ptr::from_ref(e.node())).copied().unwrap_or(false)
    }
}

/// What else is added to a formula under division.
#[derive(Clone, Copy, Default)]
struct Rest<'a> {
    /// What is done with.
    done: Option<&'a Expr>,
    /// Terms with switches that are still to be looked into, with their factors.
    ahead: Option<&'a Ahead<'a>>,
}

struct Ahead<'a> {
    term: &'a Expr,
    factor: f64,
    next: Option<&'a Ahead<'a>>,
}

struct Splitter {
    switches: Switches,
    pieces: usize,
    taken_apart: bool,
}

impl Splitter {
    /// `factor * e + rest >= 0`; `None` when there are too many pieces.
    fn condition(&mut self, e: &Expr, factor: f64, rest: &Rest, depth: usize) -> Option<Solid> {
        let deeper = depth + 1;
        if depth < DEPTH && self.switches.within(e) {
            match e.node() {
                ExprNode::Unary(Unary::Neg, a) => return self.condition(a, -factor, rest, deeper),
                ExprNode::Unary(Unary::Abs, a) => {
                    self.taken_apart = true;
                    let (p, q) = (self.condition(a, factor, rest, deeper)?, self.condition(a, -factor, rest, deeper)?);
                    return Some(if factor > 0.0 { p | q } else { p & q });
                }
                ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => {
                    self.taken_apart = true;
                    let (p, q) = (self.condition(a, factor, rest, deeper)?, self.condition(b, factor, rest, deeper)?);
                    return Some(if (*op == Binary::Min) == (factor > 0.0) { p & q } else { p | q });
                }
                ExprNode::Select(c, a, b) => {
                    self.taken_apart = true;
                    let c = self.condition(c, 1.0, &Rest::default(), deeper)?;
                    let (p, q) = (self.condition(a, factor, rest, deeper)?, self.condition(b, factor, rest, deeper)?);
                    return Some((c.clone() & p) | (!c & q));
                }
                ExprNode::Binary(op @ (Binary::Add | Binary::Sub), a, b) => {
                    let sign = if *op == Binary::Add { factor } else { -factor };
                    if !self.switches.within(b) {
                        let done = plus(rest.done, b, sign);
                        return self.condition(a, factor, &Rest { done: Some(&done), ..*rest }, deeper);
                    }
                    if !self.switches.within(a) {
                        let done = plus(rest.done, a, factor);
                        return self.condition(b, sign, &Rest { done: Some(&done), ..*rest }, deeper);
                    }
                    let ahead = Ahead { term: b, factor: sign, next: rest.ahead };
                    return self.condition(a, factor, &Rest { ahead: Some(&ahead), ..*rest }, deeper);
                }
                ExprNode::Binary(Binary::Mul, a, b) => {
                    if let Some((c, e)) = a.as_constant().map(|c| (c, b)).or(b.as_constant().map(|c| (c, a)))
                        && c != 0.0
                        && c.is_finite()
                    {
                        return self.condition(e, factor * c, rest, deeper);
                    }
                }
                ExprNode::Binary(Binary::Div, a, b) => {
                    if let Some(c) = b.as_constant()
                        && c != 0.0
                        && c.is_finite()
                    {
                        return self.condition(a, factor / c, rest, deeper);
                    }
                }
                _ => {}
            }
        }
        let whole = plus(rest.done, e, factor);
        if let Some(Ahead { term, factor, next }) = rest.ahead {
            return self.condition(term, *factor, &Rest { done: Some(&whole), ahead: *next }, deeper);
        }
        self.pieces += 1;
        (self.pieces <= MOST_PIECES).then(|| Solid::formula(whole))
    }
}

/// `factor * e + rest`
fn plus(rest: Option<&Expr>, e: &Expr, factor: f64) -> Expr {
    let term = if factor == 1.0 { e.clone() } else { e.clone() * factor };
    match rest {
        Some(r) => term + r.clone(),
        None => term,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::{Implicit, RSystem};
    use crate::spatial::Aabb;

    fn abs(e: Expr) -> Expr {
        Expr::unary(Unary::Abs, e)
    }

    #[test]
    fn what_is_split_is_the_same_solid() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let max = |a: Expr, b: Expr| Expr::binary(Binary::Max, a, b);
        let cases = [
            (-max(abs(x.clone()), max(abs(y.clone()), abs(z.clone()))) + 0.7, 6),
            ((abs(x.clone()) * -2.0 + 1.0) / 3.0 - y.clone() * y.clone(), 2),
            (Expr::select(x.clone(), y.clone() - 0.2, z.clone() + 0.1), 3),
            (Expr::constant(0.5) - abs(abs(z.clone()) - 0.6), 4),
            (Expr::constant(0.9) - (abs(x.clone()) + abs(y.clone()) + abs(z.clone()) * 2.0), 8),
            (abs(x.clone()) * abs(y.clone()) + max(x.clone(), z.clone()) - (abs(y.clone()) - 0.2), 4),
        ];
        let domain = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.2));
        for (e, leaves) in cases {
            let whole = Implicit::new(&Solid::formula(e.clone()), RSystem::R0, Some(domain)).unwrap();
            let parts = split(&e).unwrap();
            let model = Implicit::new(&parts, RSystem::R0, Some(domain)).unwrap();
            assert_eq!(model.leaf_count(), whole.leaf_count());
            assert!(model.leaf_count() <= leaves + 6, "{}", model.leaf_count());
            let n = 13;
            for i in 0..n * n * n {
                let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 1.0;
                let f = |p: DVec3| {
                    let c = crate::implicit::formula::Formula::compile(&e, &crate::implicit::Placement::IDENTITY);
                    c.gradient(p).v
                };
                assert_eq!(model.inside(p), f(p) >= 0.0, "{e:?} {p}");
            }
        }
        // Nothing to take apart, or nothing that can be.
        assert!(split(&(x.clone() * y.clone() - 1.0)).is_none());
        assert!(split(&(Expr::unary(Unary::Sqrt, abs(x.clone())) - 0.5)).is_none());
        assert!(split(&(abs(x) * abs(y) - 0.5)).is_none());
    }
}
