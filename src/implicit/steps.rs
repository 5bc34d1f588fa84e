//! Formulas with steps inside, as set operations of formulas without.
//!
//! `floor(a)` is one number between two whole values of `a`, and `mod(a, m)` is `a - m k` there. Where only a few whole numbers
//! are passed inside the part's bounds, each stretch becomes a formula of its own, and the surfaces on which `a` is whole divide
//! them. So walls at jumps and creases at seams are edges between leaves, like any other.

use std::f64::consts::PI;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::beyond::{DEEPEST, without_nested_lengths};
use super::expr::{Binary, Expr, ExprNode, SWING, Unary, holds, operands, with_operands};
use super::forms::{odd_powers, sheet, with_waves};
use super::formula::Formula;
use super::jumps::swinging;
use super::roots::by_cases;
use super::roperation::Terms;
use super::solid::{Placement, Solid};
use super::split::split;
use super::switched::rounded;
use crate::numeric::{Interval, ROUNDING};
use crate::spatial::Aabb;

/// A step that passes more whole numbers than this stays in its formula.
const MOST_STEPS: f64 = 64.0;
/// Formulas that would fall into more stretches than this stay whole.
const MOST_PIECES: usize = 1024;
/// Subformulas that may be written anew in the course of it: large formulas have fewer stretches.
const MOST_WRITTEN: usize = 1 << 22;

/// Where steps are taken apart.
#[derive(Clone, Copy)]
pub(super) struct Within {
    /// The part lies in this box.
    pub(super) bounds: Aabb,
    /// Whether nothing is inside beyond the box whatever the formulas say: then the outermost stretches may go on there.
    pub(super) closed: bool,
}

/// What must be whole where the node jumps, if it is a step.
fn counted(e: &Expr) -> Option<Expr> {
    match e.node() {
        ExprNode::Unary(Unary::Floor, a) => Some(a.clone()),
        ExprNode::Binary(Binary::Mod, a, m) if m.as_constant() == Some(1.0) => Some(a.clone()),
        ExprNode::Binary(Binary::Mod, a, m) => Some(a.clone() / m.clone()),
        _ => None,
    }
}

/// A step of a formula that has no other step inside, if there is one; the first in the order of evaluation.
fn innermost(e: &Expr) -> Option<&Expr> {
    let mut seen = rustc_hash::FxHashSet::default();
    let mut stack = vec![(e, false)];
    while let Some((e, ready)) = stack.pop() {
        if ready {
            if matches!(e.node(), ExprNode::Unary(Unary::Floor, _) | ExprNode::Binary(Binary::Mod, ..)) {
                return Some(e);
            }
        } else if seen.insert(std::ptr::from_ref(e.node())) {
            stack.push((e, true));
            stack.extend(operands(e).into_iter().rev().map(|x| (x, false)));
        }
    }
    None
}

/// Whether a formula has steps.
pub(super) fn has_steps(e: &Expr) -> bool {
    innermost(e).is_some()
}

/// A formula with other nodes in the place of those that `other` names.
pub(super) fn rewritten(e: &Expr, mut other: impl FnMut(&Expr) -> Option<Expr>) -> Expr {
    let mut done: FxHashMap<*const ExprNode, Expr> = FxHashMap::default();
    let mut stack = vec![(e, false)];
    let key = |e: &Expr| std::ptr::from_ref(e.node());
    while let Some((e, ready)) = stack.pop() {
        if done.contains_key(&key(e)) {
            continue;
        }
        let all = operands(e);
        if !ready {
            stack.push((e, true));
            stack.extend(all.into_iter().map(|x| (x, false)));
            continue;
        }
        let of = |x: &Expr| done.get(&key(x)).cloned().unwrap_or_else(|| x.clone());
        let same = all.iter().all(|x| key(&of(x)) == key(x));
        let made = if same { e.clone() } else { with_operands(e, of) };
        let made = other(&made).unwrap_or(made);
        done.insert(key(e), made);
    }
    done.remove(&key(e)).unwrap_or_else(|| e.clone())
}

/// `sign(a)` as conditions: with a third case where `a` may be zero in more than a surface.
fn without_signs(e: &Expr) -> Expr {
    rewritten(e, |e| match e.node() {
        ExprNode::Unary(Unary::Sign, a) => {
            let [minus, zero, plus] = [-1.0, 0.0, 1.0].map(Expr::constant);
            let above = if flat(a) { Expr::select(-a.clone(), zero, plus) } else { plus };
            Some(Expr::select(a.clone(), above, minus))
        }
        _ => None,
    })
}

/// Whether a formula has no more nodes than `most`.
pub(super) fn is_small(e: &Expr, most: usize) -> bool {
    let mut seen = rustc_hash::FxHashSet::default();
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        if seen.insert(std::ptr::from_ref(e.node())) {
            if seen.len() > most {
                return false;
            }
            stack.extend(operands(e));
        }
    }
    true
}

/// Whether a formula may be constant somewhere though it is not everywhere.
pub(super) fn flat(e: &Expr) -> bool {
    holds(e, |e| {
        matches!(
            e.node(),
            ExprNode::Select(..)
                | ExprNode::Unary(Unary::Abs | Unary::Sign | Unary::Floor, _)
                | ExprNode::Binary(Binary::Min | Binary::Max | Binary::Mod, ..)
        )
    })
}

/// The solid `e >= 0` as set operations of formulas, if `e` has switches or steps that can be taken apart.
pub(super) fn taken_apart(given: &Expr, place: &Placement, within: Option<&Within>) -> Option<Solid> {
    let e = with_waves(&rounded(&without_nested_lengths(&without_signs(given))));
    let e = by_cases(&sheet(&e).or_else(|| odd_powers(&e)).unwrap_or(e));
    if let Some(within) = within
        && has_steps(&e)
    {
        let mut apart = Apart { place, within, terms: Terms::default(), pieces: 0, written: 0, depth: 0 };
        if let Some(solid) = apart.solid(&e) {
            return Some(solid);
        }
    }
    let is_other = !std::ptr::eq(e.node(), given.node());
    split(&e).or_else(|| is_other.then(|| Solid::formula(e)))
}

struct Apart<'a> {
    place: &'a Placement,
    within: &'a Within,
    terms: Terms,
    pieces: usize,
    /// Subformulas written anew.
    written: usize,
    depth: usize,
}

impl Apart<'_> {
    /// The solid `e >= 0` without steps; `None` if there are too many.
    fn solid(&mut self, e: &Expr) -> Option<Solid> {
        let Some(step) = innermost(e) else {
            self.pieces += 1;
            return (self.pieces <= MOST_PIECES).then(|| split(e).unwrap_or_else(|| Solid::formula(e.clone())));
        };
        let counter = counted(step)?;
        self.depth += 1;
        if self.depth > MOST_STEPS as usize {
            return None;
        }
        let compiled = Formula::compile(&counter, self.place);
        let passed = |within: &Aabb| {
            let [x, y, z] = std::array::from_fn(|k| Interval::new(within.lo[k], within.hi[k]));
            let range = compiled.range(x, y, z).scale(1.0 / self.place.scale);
            // A whole number that is barely passed at the very end of the bounds is not passed: the rounding of bounds.
            let first = (range.lo + ROUNDING).floor();
            [first, ((range.hi - ROUNDING).ceil() - 1.0).max(first)]
        };
        let [first, last] = passed(&self.within.bounds);
        if !(last - first < MOST_STEPS) {
            return None;
        }
        // An angle takes no other values anywhere.
        let is_all = self.within.closed || passed(&Aabb::ALL) == [first, last];
        let (from, to) = if is_all { (first, last) } else { (first - 1.0, last + 1.0) };
        let count = (to - from) as usize + 1;
        let mut all = Vec::with_capacity(count + 2);
        for i in 0..count {
            let stretch = self.with(e, &counter, from + i as f64);
            if self.written > MOST_WRITTEN {
                return None;
            }
            all.push(self.solid(&stretch)?);
        }
        self.depth -= 1;
        if is_all {
            return Some(divided(&counter, from + 1.0, &all));
        }
        // Beyond the bounds the formula is what it was.
        all.insert(0, Solid::formula(e.clone()));
        all.push(Solid::formula(e.clone()));
        Some(divided(&counter, from, &all))
    }

    /// The formula where the counter has this whole part. Where that counts turns around an axis, its angle is written so that it
    /// jumps on the other side of the axis.
    fn with(&mut self, e: &Expr, counter: &Expr, whole: f64) -> Expr {
        let number = self.terms.number(counter);
        let (terms, written) = (&mut self.terms, &mut self.written);
        let counted_out = rewritten(e, |e| {
            *written += 1;
            let same = counted(e).is_some_and(|c| terms.number(&c) == number);
            match e.node() {
                ExprNode::Unary(Unary::Floor, _) if same => Some(Expr::constant(whole)),
                ExprNode::Binary(Binary::Mod, a, _) if same && whole == 0.0 => Some(a.clone()),
                ExprNode::Binary(Binary::Mod, a, m) if same => Some(a.clone() - m.clone() * Expr::constant(whole)),
                _ => None,
            }
        });
        let Some(turned) = Turned::of(counter, 0) else { return counted_out };
        let (angle, ahead) = (terms.number(turned.angle), turned.ahead(whole + 0.5));
        rewritten(&counted_out, |e| {
            *written += 1;
            let is_atan2 = matches!(e.node(), ExprNode::Binary(Binary::Atan2, ..));
            (is_atan2 && terms.number(e) == angle).then(|| ahead.clone())
        })
    }
}

/// `factor * angle + offset`, where the angle is `atan2(y, x)`.
#[derive(Clone, Copy)]
struct Turned<'a> {
    angle: &'a Expr,
    y: &'a Expr,
    x: &'a Expr,
    factor: f64,
    offset: f64,
}

impl<'a> Turned<'a> {
    fn of(e: &'a Expr, depth: usize) -> Option<Self> {
        if depth > DEEPEST {
            return None;
        }
        let of = |e: &'a Expr| Self::of(e, depth + 1);
        let scaled = |t: Self, k: f64| Self { factor: k * t.factor, offset: k * t.offset, ..t };
        let raised = |t: Self, c: f64| Self { offset: t.offset + c, ..t };
        let found = match e.node() {
            ExprNode::Binary(Binary::Atan2, y, x) => Self { angle: e, y, x, factor: 1.0, offset: 0.0 },
            ExprNode::Unary(Unary::Neg, a) => scaled(of(a)?, -1.0),
            ExprNode::Binary(op @ (Binary::Add | Binary::Sub), a, b) => {
                let s = if *op == Binary::Add { 1.0 } else { -1.0 };
                match (a.as_constant(), b.as_constant()) {
                    (_, Some(c)) => raised(of(a)?, s * c),
                    (Some(c), _) => raised(scaled(of(b)?, s), c),
                    _ => return None,
                }
            }
            ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
                (_, Some(k)) => scaled(of(a)?, k),
                (Some(k), _) => scaled(of(b)?, k),
                _ => return None,
            },
            ExprNode::Binary(Binary::Div, a, b) => scaled(of(a)?, 1.0 / b.as_constant()?),
            _ => return None,
        };
        (found.factor != 0.0 && found.factor.is_finite() && found.offset.is_finite()).then_some(found)
    }

    /// The angle at which the whole is a number.
    fn at(&self, number: f64) -> f64 {
        (number - self.offset) / self.factor
    }

    /// How far the point is to the left of the ray at an angle, and how far along it.
    fn beside(&self, angle: f64) -> [Expr; 2] {
        let (sin, cos) = angle.sin_cos();
        let (y, x) = (self.y.clone(), self.x.clone());
        [y.clone() * cos - x.clone() * sin, x * cos + y * sin]
    }

    /// The angle in a form that does not jump as long as the whole differs from a number by a half at most, if that is less than a turn.
    fn ahead(&self, number: f64) -> Expr {
        let middle = self.at(number);
        let [left, along] = self.beside(middle);
        let far = 0.5 / self.factor.abs() > SWING;
        (if far { Expr::binary(Binary::Atan2, left, along) } else { swinging(left, along) }) + middle
    }

    /// Where the whole is at least a number: on the left of a ray, on the left side of the axis' plane or not, so that no divider
    /// jumps. `None` where that is everywhere or nowhere.
    fn beyond(&self, number: f64) -> Option<Solid> {
        let angle = self.at(number);
        if !(angle.abs() < PI) {
            return None;
        }
        let [left, _] = self.beside(angle);
        let (left, upper) = (beyond(&left, 0.0), beyond(self.y, 0.0));
        let above = if angle >= 0.0 { left & upper } else { left | upper };
        Some(if self.factor > 0.0 { above } else { !above })
    }
}

/// The first of some solids below `first`, the next one from there to the next whole number, and so on.
fn divided(counter: &Expr, first: f64, all: &[Solid]) -> Solid {
    if let [one] = all {
        return one.clone();
    }
    let (low, high) = all.split_at(all.len() / 2);
    let at = first + (low.len() - 1) as f64;
    let above = beyond(counter, at);
    (above.clone() & divided(counter, at + 1.0, high)) | (!above & divided(counter, first, low))
}

/// Where a formula is at least a number.
fn beyond(e: &Expr, number: f64) -> Solid {
    if let Some(place) = Turned::of(e, 0).and_then(|t| t.beyond(number)) {
        return place;
    }
    match linear(e, 0) {
        Some((normal, offset)) if normal != DVec3::ZERO => {
            Solid::half_space(-normal, normal * ((number - offset) / normal.length_squared()))
        }
        _ => Solid::formula(e.clone() - number),
    }
}

/// Gradient and offset of a linear formula.
pub(super) fn linear(e: &Expr, depth: usize) -> Option<(DVec3, f64)> {
    if depth > DEEPEST {
        return None;
    }
    let of = |e: &Expr| linear(e, depth + 1);
    Some(match e.node() {
        ExprNode::Const(c) => (DVec3::ZERO, *c),
        ExprNode::Coordinate(k) => (DVec3::AXES[*k as usize % 3], 0.0),
        ExprNode::Unary(Unary::Neg, a) => of(a).map(|(g, c)| (-g, -c))?,
        ExprNode::Binary(op @ (Binary::Add | Binary::Sub), a, b) => {
            let (((g, c), (h, d)), s) = (of(a).zip(of(b))?, if *op == Binary::Add { 1.0 } else { -1.0 });
            (g + h * s, c + d * s)
        }
        ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
            (Some(k), _) => of(b).map(|(g, c)| (g * k, c * k))?,
            (_, Some(k)) => of(a).map(|(g, c)| (g * k, c * k))?,
            _ => return None,
        },
        ExprNode::Binary(Binary::Div, a, b) => {
            let k = b.as_constant()?;
            of(a).map(|(g, c)| (g / k, c / k))?
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::{Implicit, RSystem};

    #[test]
    fn what_is_taken_apart_is_the_same_solid() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let (un, bi) = (Expr::unary, Expr::binary);
        let modulo = |a: &Expr, m: f64| bi(Binary::Mod, a.clone(), Expr::constant(m));
        let floor = |a: Expr| un(Unary::Floor, a);
        let hypot = |a: &Expr, b: &Expr| bi(Binary::Hypot, a.clone(), b.clone());
        let turn = bi(Binary::Atan2, y.clone(), x.clone());
        let walls = 6;
        // With how many leaves: dividers and stretches.
        let cases = [
            (modulo(&x, 1.0) * 0.3 - z.clone(), 3 + 4),
            (un(Unary::Abs, modulo(&x, 0.5) - 0.25) - z.clone() * z.clone() - 0.1, 5 + 2 * 6),
            (bi(Binary::Hypot, modulo(&x, 1.0) - 0.5, modulo(&y, 1.0) - 0.5) - 0.3, 3 + 3 + 16),
            (floor(x.clone() * 2.0 + y.clone()) * 0.1 - z.clone(), 7 + 8),
            (modulo(&x, -0.7) + z.clone() + 0.1, 3 + 4),
            (x.clone().fmod(Expr::constant(0.4)) - z.clone(), 24),
            (y.clone().round() + x.clone().ceil() * 0.2 + z.clone().trunc() - 0.7, 12),
            (un(Unary::Sign, y.clone()) * 0.3 - z.clone(), 3),
            (un(Unary::Sign, floor(x.clone())) - y.clone(), 8),
            (un(Unary::Sign, bi(Binary::Max, x.clone(), Expr::constant(0.0))) - z.clone() - 0.5, 5),
            // Around an axis: eight petals, a thread.
            (
                hypot(&x, &y) * -1.0 + un(Unary::Abs, modulo(&(turn.clone() * (4.0 / PI)), 1.0) - 0.5) * 0.4 + 0.7,
                12 + 16,
            ),
            (modulo(&(turn * (-3.0 / PI) + 0.3), 2.0) - z.clone(), 9),
            // Too many stretches: whole.
            (modulo(&x, 0.001) - z.clone(), 1),
        ];
        let domain = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.2));
        for (e, leaves) in cases {
            let model = Implicit::new(&Solid::formula(e.clone()), RSystem::R0, Some(domain)).unwrap();
            let found = model.leaf_count();
            assert!(found <= leaves + walls && (found > 1 + walls || leaves == 1), "{found} leaves: {e:?}");
            let whole = Formula::compile(&e, &Placement::IDENTITY);
            let n = 13;
            for i in 0..n * n * n {
                let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 0.999;
                assert_eq!(model.inside(p), whole.gradient(p).v >= 0.0, "{e:?} {p}");
            }
        }
    }
}
