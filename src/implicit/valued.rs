//! Formulas as minima and maxima of smooth ones, with their values and not their signs alone.
//!
//! The function of a smooth maximum never falls when one of its operands rises, so it may be taken piece by piece, as a blend is. Its
//! operands, however, count with their values where they are not zero: that of a distance to a box is the distance to an edge beyond two faces.

use super::beyond::{Displaced, displaced, distance_to_faces};
use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::Terms;
use super::smooth::{Kernel, SmoothPair};
use super::steps::flat;
use super::switched::creased;

/// Switches, pieces and roots of formulas are looked for this deep: it bounds the stack.
pub(super) const DEEPEST: usize = 64;
/// Formulas with more pieces than this stay whole.
const MOST_PIECES: usize = 128;

/// How two values are joined to one that is at least as great as both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum How {
    Max,
    /// `|(r + a, r + b)| - r` where both are above `-r`, else the greater: a distance less `r`, by distances to faces less `r`.
    Distance(f64),
    /// The smooth maximum of a kind and a width.
    Smooth(Kernel, f64),
}

/// A formula's value.
#[derive(Debug, Clone)]
pub(crate) enum Valued<T> {
    /// That of a smooth formula.
    Piece(T),
    /// `how(a, b)`, or `-how(-a, -b)` if mirrored.
    Joined { how: How, mirrored: bool, of: Box<[Valued<T>; 2]> },
}

impl<T> Valued<T> {
    /// The same with other pieces.
    pub(crate) fn map<U>(&self, f: &impl Fn(&T) -> U) -> Valued<U> {
        match self {
            Valued::Piece(e) => Valued::Piece(f(e)),
            Valued::Joined { how, mirrored, of } => {
                let of = Box::new(of.each_ref().map(|v| v.map(f)));
                Valued::Joined { how: *how, mirrored: *mirrored, of }
            }
        }
    }

    /// Whether a smooth minimum or maximum is in it.
    fn is_rounded(&self) -> bool {
        match self {
            Valued::Piece(_) => false,
            Valued::Joined { how, of, .. } => matches!(how, How::Smooth(..)) || of.iter().any(Valued::is_rounded),
        }
    }

    /// Whether something in it has edges where it is joined.
    fn has_edges(&self) -> bool {
        match self {
            Valued::Piece(_) => false,
            Valued::Joined { how, of, .. } => !matches!(how, How::Smooth(..)) || of.iter().any(Valued::has_edges),
        }
    }
}

/// A formula that is a smooth minimum or maximum of what has edges, or a distance with a function beside it.
#[derive(Debug)]
pub struct Smooth {
    pub(crate) value: Valued<Expr>,
    /// What is added to a distance.
    pub(crate) rest: Option<Expr>,
    pub(crate) whole: Expr,
}

/// What is read: `factor * e + rest`.
#[derive(Clone, Copy)]
struct Scaled<'a> {
    e: &'a Expr,
    factor: f64,
    rest: Option<&'a Expr>,
}

impl<'a> Scaled<'a> {
    fn of(self, e: &'a Expr) -> Self {
        Self { e, ..self }
    }

    fn times(self, k: f64) -> Self {
        Self { factor: self.factor * k, ..self }
    }

    fn written(self) -> Expr {
        let term = if self.factor == 1.0 { self.e.clone() } else { self.e.clone() * self.factor };
        match self.rest {
            Some(rest) => term + rest.clone(),
            None => term,
        }
    }
}

/// What a formula is as a smooth minimum or maximum.
pub(super) enum SmoothJoin {
    /// One of formulas with edges, by its pieces.
    Of(Valued<Expr>),
    /// One of more than [`MOST_PIECES`], or [too deep](DEEPEST): any other way to take it apart has as many.
    TooLarge,
    No,
}

/// `factor * e + rest` by its pieces if `e` is a smooth minimum or maximum of formulas with edges.
pub(super) fn smooth_join(e: &Expr, factor: f64, rest: Option<&Expr>, terms: &mut Terms) -> SmoothJoin {
    let Some(found) = SmoothPair::of(e, terms) else { return SmoothJoin::No };
    let mut reader = Reader { terms, pieces: 0, too_large: false };
    match reader.smooth(&found, Scaled { e, factor, rest }, 0) {
        Some(value @ Valued::Joined { .. }) => SmoothJoin::Of(value),
        None if reader.too_large => SmoothJoin::TooLarge,
        _ => SmoothJoin::No,
    }
}

/// A distance to what has edges with a smooth function beside it, as that of a block with waves on it: the faces go on in the distance from
/// them, and what they share in that from it.
pub(super) fn displaced_distance(whole: &Expr, terms: &mut Terms) -> Option<Smooth> {
    let Displaced { faces, factor, others } = displaced(whole, terms)?;
    let beside = |(a, _): &(Expr, f64)| a.as_constant().is_none();
    if !others.iter().any(beside) || others.iter().any(|(a, _)| flat(a)) {
        return None;
    }
    let rest = others.into_iter().map(|(a, k)| a * k).reduce(|a, b| a + b)?;
    let mut reader = Reader { terms, pieces: 0, too_large: false };
    let value = reader.distance(&faces, Scaled { e: whole, factor, rest: None }, 0)?;
    (!value.is_rounded()).then(|| Smooth { value, rest: Some(rest), whole: whole.clone() })
}

struct Reader<'a> {
    terms: &'a mut Terms,
    pieces: usize,
    too_large: bool,
}

impl Reader<'_> {
    fn piece(&mut self, e: Expr) -> Option<Valued<Expr>> {
        self.pieces += 1;
        self.too_large |= self.pieces > MOST_PIECES;
        if self.too_large {
            return None;
        }
        let is_smooth = !flat(&e) || creased(&e, self.terms).is_none();
        is_smooth.then_some(Valued::Piece(e))
    }

    fn smooth(&mut self, found: &SmoothPair, at: Scaled<'_>, depth: usize) -> Option<Valued<Expr>> {
        let how = How::Smooth(found.kernel, found.width * at.factor.abs());
        let pieces = self.pieces;
        let joined = self.joined(how, found.is_max, found.sides.each_ref().map(|side| at.of(side)), depth)?;
        if joined.has_edges() {
            return Some(joined);
        }
        // Nothing is gained by borders where it goes over into both.
        self.pieces = pieces;
        self.piece(at.written())
    }

    /// `how` of two formulas, or its like for minima, of one factor.
    fn joined(&mut self, how: How, is_max: bool, of: [Scaled<'_>; 2], depth: usize) -> Option<Valued<Expr>> {
        let mirrored = is_max != (of[0].factor > 0.0);
        let [a, b] = of;
        let of = Box::new([self.value(a, depth)?, self.value(b, depth)?]);
        Some(Valued::Joined { how, mirrored, of })
    }

    fn value(&mut self, at: Scaled<'_>, depth: usize) -> Option<Valued<Expr>> {
        let deeper = depth + 1;
        self.too_large |= depth > DEEPEST;
        if self.too_large || at.factor == 0.0 || !at.factor.is_finite() {
            return None;
        }
        if !flat(at.e) {
            return self.piece(at.written());
        }
        if let Some(found) = SmoothPair::of(at.e, self.terms) {
            return self.smooth(&found, at, deeper);
        }
        if let Some(faces) = distance_to_faces(at.e, self.terms) {
            return self.distance(&faces, at, deeper);
        }
        match at.e.node() {
            ExprNode::Unary(Unary::Neg, a) => self.value(at.of(a).times(-1.0), deeper),
            ExprNode::Unary(Unary::Abs, a) => {
                let (p, q) = (self.value(at.of(a), deeper)?, self.value(at.of(a).times(-1.0), deeper)?);
                Some(Valued::Joined { how: How::Max, mirrored: at.factor < 0.0, of: Box::new([p, q]) })
            }
            ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => {
                self.joined(How::Max, *op == Binary::Max, [at.of(a), at.of(b)], deeper)
            }
            ExprNode::Binary(op @ (Binary::Add | Binary::Sub), a, b) => {
                let of_second = if *op == Binary::Add { 1.0 } else { -1.0 };
                let second = at.of(b).times(of_second);
                if !flat(b) {
                    let rest = second.written();
                    return self.value(Scaled { rest: Some(&rest), ..at.of(a) }, deeper);
                }
                if !flat(a) {
                    let rest = at.of(a).written();
                    return self.value(Scaled { rest: Some(&rest), ..second }, deeper);
                }
                self.piece(at.written())
            }
            ExprNode::Binary(Binary::Mul, a, b) if let Some(k) = b.as_constant() => {
                self.value(at.of(a).times(k), deeper)
            }
            ExprNode::Binary(Binary::Mul, a, b) if let Some(k) = a.as_constant() => {
                self.value(at.of(b).times(k), deeper)
            }
            ExprNode::Binary(Binary::Div, a, b) if let Some(k) = b.as_constant() => {
                self.value(at.of(a).times(1.0 / k), deeper)
            }
            _ => self.piece(at.written()),
        }
    }

    /// A distance by what it is a distance to, with a number beside it at most.
    fn distance(&mut self, faces: &[Expr], at: Scaled<'_>, depth: usize) -> Option<Valued<Expr>> {
        let number = at.rest.map_or(Some(0.0), Expr::as_constant)?;
        let how = How::Distance(-number * at.factor.signum());
        let mut all = faces.iter().map(|f| self.value(at.of(f), depth));
        let first = all.next()??;
        let mirrored = at.factor < 0.0;
        all.try_fold(first, |done, next| Some(Valued::Joined { how, mirrored, of: Box::new([done, next?]) }))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::formula::Formula;
    use crate::implicit::solid::{Placement, Solid};
    use crate::implicit::{Implicit, RSystem};
    use crate::spatial::Aabb;

    fn max(a: Expr, b: Expr) -> Expr {
        Expr::binary(Binary::Max, a, b)
    }

    fn min(a: Expr, b: Expr) -> Expr {
        Expr::binary(Binary::Min, a, b)
    }

    fn abs(a: Expr) -> Expr {
        Expr::unary(Unary::Abs, a)
    }

    fn smooth_min(a: &Expr, b: &Expr, k: f64) -> Expr {
        let h = max(min((b.clone() - a.clone()) * 0.5 / k + 0.5, Expr::constant(1.0)), Expr::constant(0.0));
        b.clone() * (Expr::constant(1.0) - h.clone()) + a.clone() * h.clone()
            - h.clone() * k * (Expr::constant(1.0) - h)
    }

    fn cubic_min(a: &Expr, b: &Expr, k: f64) -> Expr {
        let h = max(Expr::constant(k) - abs(a.clone() - b.clone()), Expr::constant(0.0)) / k;
        min(a.clone(), b.clone()) - h.clone() * h.clone() * h * (k / 6.0)
    }

    fn smooth_max(a: &Expr, b: &Expr, k: f64) -> Expr {
        let h = max(Expr::constant(k) - abs(a.clone() - b.clone()), Expr::constant(0.0));
        max(a.clone(), b.clone()) + h.clone() * h / (4.0 * k)
    }

    fn ball(at: [f64; 3], r: f64) -> Expr {
        let square = |e: Expr| e.clone() * e;
        let sum = square(Expr::x() - at[0]) + square(Expr::y() - at[1]) + square(Expr::z() - at[2]);
        Expr::unary(Unary::Sqrt, sum) - r
    }

    fn block(half: [f64; 3]) -> Expr {
        let q = [abs(Expr::x()) - half[0], abs(Expr::y()) - half[1], abs(Expr::z()) - half[2]];
        let square = |e: &Expr| {
            let part = max(e.clone(), Expr::constant(0.0));
            part.clone() * part
        };
        let length = Expr::unary(Unary::Sqrt, square(&q[0]) + square(&q[1]) + square(&q[2]));
        let [a, b, c] = q;
        length + min(max(max(a, b), c), Expr::constant(0.0))
    }

    #[test]
    fn smooth_minima_of_what_has_edges_fall_into_the_same_solid() {
        let (a, b) = (block([0.8, 0.7, 0.5]), block([0.4, 0.9, 0.3]));
        let c = ball([0.5, 0.4, 0.45], 0.5);
        let plain = max(max(abs(Expr::x()) - 0.6, abs(Expr::y()) - 0.5), abs(Expr::z()) - 0.7);
        let wave = |e: Expr| Expr::unary(Unary::Sin, e * 7.0);
        let waves = wave(Expr::x()) * wave(Expr::y() + 0.2) * wave(Expr::z()) * 0.06;
        // What is inside where it is negative, and how many leaves there are.
        let cases = [
            ("union", smooth_min(&a, &c, 0.2)),
            ("cubic", cubic_min(&a, &c, 0.2)),
            ("cubic difference", -cubic_min(&-a.clone(), &c, 0.2)),
            ("cubic of three", cubic_min(&smooth_min(&a, &b, 0.15), &c, 0.2)),
            ("of three cubic", smooth_min(&cubic_min(&a, &b, 0.15), &c, 0.2)),
            ("difference", -smooth_min(&-a.clone(), &c, 0.2)),
            ("intersection", smooth_max(&a, &c, 0.25)),
            ("rounded block", smooth_min(&(a.clone() - 0.1), &c, 0.2)),
            ("smaller block", smooth_min(&(a.clone() + 0.1), &c, 0.2)),
            ("two blocks", smooth_min(&a, &b, 0.15)),
            ("of three", smooth_min(&smooth_min(&a, &b, 0.15), &c, 0.2)),
            ("cut from two", smooth_max(&smooth_min(&a, &b, 0.15), &-c.clone(), 0.1)),
            ("maxima", smooth_min(&plain, &c, 0.3) + 0.05),
            ("times", smooth_max(&(plain * -2.0), &(-c.clone()), 0.3) * -1.5),
            ("waves", a.clone() - waves.clone()),
            ("waves and a number", waves.clone() * -1.0 + a.clone() * 2.0 - 0.1),
            ("waves on a hole", waves - b),
            ("mixture", a * 0.6 + c * 0.4),
        ];
        let domain = Aabb::new(DVec3::splat(-1.6), DVec3::splat(1.7));
        for (name, e) in cases {
            let inside = -e.clone();
            let model = Implicit::new(&Solid::formula(inside.clone()), RSystem::R0, Some(domain)).unwrap();
            assert!(model.leaf_count() > 6 + 2, "{name}: {} leaves", model.leaf_count());
            let whole = Formula::compile(&inside, &Placement::IDENTITY);
            let n = 27;
            for i in 0..n * n * n {
                let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 8.21 - 1.537;
                let value = whole.value(p);
                if value.abs() > 1e-7 {
                    assert_eq!(model.inside(p), value >= 0.0, "{name}: {p} {value}");
                }
            }
        }
    }

    #[test]
    fn functions_beside_distances_that_jump_or_end_are_taken_apart_first() {
        let a = block([0.8, 0.7, 0.5]);
        let made = |inside: Expr| Implicit::new(&Solid::formula(inside), RSystem::R0, None).unwrap();
        let leaves = |inside: Expr| made(inside).leaf_count();
        let smooth = leaves(-(a.clone() + Expr::x() * Expr::x() * 0.1 - 0.1));
        // Two forms of the angle, each with all faces and fillets.
        let angle = Expr::binary(Binary::Atan2, Expr::y(), Expr::x());
        assert!(leaves(-(a.clone() - angle * 0.03 - 0.1)) > 2 * (smooth - 6));
        // A root without a value beyond 0.6 ends the solid there.
        let root = Expr::unary(Unary::Sqrt, Expr::constant(0.36) - Expr::x() * Expr::x());
        assert!(made(-(a + root * 0.1)).bounds().hi.x < 0.65);
    }

    #[test]
    fn many_blocks_in_smooth_minima_stay_one_function() {
        // By squares: what is squared is written twice, and each block stands in both.
        let chain =
            (0..24).map(|k| block([0.3 + 0.05 * f64::from(k), 0.25, 0.2])).reduce(|a, b| -smooth_max(&-a, &-b, 0.1));
        let domain = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));
        let model = Implicit::new(&Solid::formula(-chain.unwrap()), RSystem::R0, Some(domain)).unwrap();
        assert_eq!(model.leaf_count(), 6 + 1);
        assert!(model.inside(DVec3::ZERO) && !model.inside(DVec3::splat(1.5)));
    }

    #[test]
    fn smooth_minima_have_bounds() {
        for e in [
            smooth_min(&block([0.8, 0.7, 0.5]), &ball([0.5, 0.4, 0.45], 0.5), 0.2),
            smooth_max(&block([0.8, 0.7, 0.5]), &ball([0.5, 0.4, 0.45], 0.5), 0.2),
        ] {
            for inside in [-e.clone(), Expr::constant(0.0) - e] {
                let model = Implicit::new(&Solid::formula(inside), RSystem::R0, None).unwrap();
                assert!(model.bounds().size().max_element() < 3.0, "{:?}", model.bounds());
            }
        }
    }
}
