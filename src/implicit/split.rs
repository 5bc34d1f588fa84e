//! Formulas with creases inside, as set operations of formulas without.
//!
//! `min(a, b) >= 0` is the intersection of `a >= 0` and `b >= 0`; `max` makes a union, `|u| = max(u, -u)`. So the crease of
//! such a formula is an edge between two leaves, like any other. Sums and multiples are looked through, as `min(a, b) + c` is
//! `min(a + c, b + c)`. Where only the sign of a formula counts, R-operations are taken apart as `min` and `max` are
//! (`roperation`), and so are products. What has switches deeper inside is taken apart by the sign of what these hang on
//! (`switched`).

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::beyond::{Sign, sign_of_distance};
use super::expr::{Binary, Expr, ExprNode, Unary, holds};
use super::joints::is_smooth;
use super::jumps::{beside_jump, cases, swinging};
use super::pulled::outermost;
use super::roots::{even_power, is_bare, under_root, without_root, without_root_at_nose};
use super::roperation::{Terms, never_negative};
use super::solid::{Primitive, Solid};
use super::switched::{Cases, creased};
use super::valued::{Smooth, SmoothJoin, displaced_distance, smooth_join};

/// Formulas that would fall into more pieces than this stay whole.
const MOST_PIECES: usize = 256;
/// Switches inside switches are followed this deep.
const DEPTH: usize = 512;
/// Creases of so many switches deep inside one formula are edges; each doubles the number of its pieces.
const MOST_CASES: usize = 6;
/// Subformulas looked at, each as often as it is met: formulas that share much would take forever written out.
const MOST_VISITS: usize = 1 << 16;

/// The solid `e >= 0` as set operations of formulas, if `e` has switches that can be taken apart.
pub(super) fn split(e: &Expr) -> Option<Solid> {
    let switches = Switches::of(e);
    if !switches.within(e) {
        return None;
    }
    let mut splitter = Splitter { switches, ..Splitter::default() };
    let solid = splitter.condition(e, 1.0, &Rest::default(), 0)?;
    splitter.taken_apart.then_some(solid)
}

/// What may be taken apart in a formula.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Holds {
    Neither,
    Root,
    Switch,
}

/// Which subformulas hold a switch, or a root, which may belong to an R-operation.
#[derive(Default)]
struct Switches {
    known: FxHashMap<*const ExprNode, Holds>,
    /// What was looked at lives on, so that addresses stay what they are.
    alive: Vec<Expr>,
}

impl Switches {
    fn of(e: &Expr) -> Self {
        let mut switches = Self::default();
        switches.look_at(e);
        switches
    }

    fn look_at(&mut self, e: &Expr) {
        let Self { known, alive } = self;
        alive.push(e.clone());
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
            let own = match e.node() {
                ExprNode::Unary(Unary::Abs, _)
                | ExprNode::Select(..)
                | ExprNode::Binary(Binary::Min | Binary::Max, ..) => Holds::Switch,
                ExprNode::Unary(Unary::Sqrt, _) | ExprNode::Binary(Binary::Hypot, ..) => Holds::Root,
                ExprNode::Binary(Binary::Pow, _, n) if n.as_constant() == Some(0.5) => Holds::Root,
                _ => Holds::Neither,
            };
            let of = |c: &&Expr| known.get(&std::ptr::from_ref(c.node())).copied().unwrap_or(Holds::Neither);
            let below = children.iter().map(of).max().unwrap_or(Holds::Neither);
            known.insert(key, own.max(below));
        }
    }

    fn held(&self, e: &Expr) -> Holds {
        self.known.get(&std::ptr::from_ref(e.node())).copied().unwrap_or(Holds::Neither)
    }

    fn within(&self, e: &Expr) -> bool {
        self.held(e) != Holds::Neither
    }
}

/// What else is added to a formula under division.
#[derive(Clone, Copy, Default)]
struct Rest<'a> {
    /// What is done with.
    done: Option<&'a Expr>,
    /// Terms with switches that are still to be looked into, with their factors.
    ahead: Option<&'a Ahead<'a>>,
    /// A root that has no value somewhere, which comes last.
    root: Option<Root<'a>>,
    /// Whether this is one side of an absolute value: the other side has its like with the opposite of one term.
    mirrored: bool,
}

/// `factor * sqrt(under)`
#[derive(Clone, Copy)]
struct Root<'a> {
    under: &'a Expr,
    factor: f64,
}

struct Ahead<'a> {
    term: &'a Expr,
    factor: f64,
    next: Option<&'a Ahead<'a>>,
}

#[derive(Default)]
struct Splitter {
    switches: Switches,
    terms: Terms,
    /// Which roots have no value somewhere, as far as they were asked.
    bare: FxHashMap<*const ExprNode, bool>,
    /// Which cases go over into each other smoothly.
    smooth: FxHashMap<*const ExprNode, bool>,
    /// What was found to be no smooth minimum of what has edges.
    plain: FxHashSet<u32>,
    /// Pieces that are sums of parts of switches: their number may double with every switch.
    pieces: usize,
    visits: usize,
    taken_apart: bool,
}

impl Splitter {
    /// `factor * e + rest >= 0`; `None` when there are too many pieces.
    fn condition(&mut self, e: &Expr, factor: f64, rest: &Rest, depth: usize) -> Option<Solid> {
        let deeper = depth + 1;
        self.visits += 1;
        if self.visits > MOST_VISITS {
            return None;
        }
        if depth < DEPTH && self.switches.within(e) {
            if rest.is_nothing()
                && let Some(parts) = self.sign(e, factor < 0.0, deeper)
            {
                return parts;
            }
            if let Some(rounded) = self.rounded(e, factor, rest) {
                return Some(rounded);
            }
            if let Some(parts) = self.distance(e, factor, rest, deeper) {
                return parts;
            }
            if let Some(parts) = self.displaced(e, factor, rest) {
                return Some(parts);
            }
            if let Some(a) = root_of_square(e) {
                self.taken_apart = true;
                return self.both_signs(a, factor, rest, deeper);
            }
            if rest.root.is_none()
                && !rest.is_nothing()
                && let Some(under) = under_root(e)
                && self.is_bare(e)
            {
                let root = Some(Root { under, factor });
                return self.ended(&Rest { root, ..*rest }, deeper);
            }
            match e.node() {
                ExprNode::Unary(Unary::Neg, a) => return self.condition(a, -factor, rest, deeper),
                ExprNode::Unary(Unary::Abs, a) if let Some(angle) = self.angle(a, 0) => {
                    return self.unsigned_angle(&angle, factor, rest, deeper);
                }
                ExprNode::Unary(Unary::Abs, a) => {
                    self.taken_apart = true;
                    return self.both_signs(a, factor, rest, deeper);
                }
                ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => {
                    self.taken_apart = true;
                    let (p, q) = (self.condition(a, factor, rest, deeper)?, self.condition(b, factor, rest, deeper)?);
                    return Some(if (*op == Binary::Min) == (factor > 0.0) { p & q } else { p | q });
                }
                _ if let Some(e) = self.pulled(e) => return self.condition(&e, factor, rest, deeper),
                ExprNode::Select(c, a, b) if !self.is_smooth(e, [c, a, b]) => {
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
                    for (a, b) in [(a, b), (b, a)] {
                        if !self.is_smooth_power(e)
                            && let Some(e) = self.scaled(Binary::Mul, a, b)
                        {
                            return self.condition(&e, factor, rest, deeper);
                        }
                    }
                }
                ExprNode::Binary(Binary::Div, a, b) => {
                    if let Some(c) = b.as_constant()
                        && c != 0.0
                        && c.is_finite()
                    {
                        return self.condition(a, factor / c, rest, deeper);
                    }
                    if let Some(e) = self.scaled(Binary::Div, a, b) {
                        return self.condition(&e, factor, rest, deeper);
                    }
                }
                _ => {}
            }
        }
        let whole = plus(rest.done, e, factor);
        let alone = rest.is_nothing();
        if alone { self.leaf(whole, 0) } else { self.ended(&Rest { done: Some(&whole), ..*rest }, deeper) }
    }

    fn scaled(&mut self, op: Binary, e: &Expr, by: &Expr) -> Option<Expr> {
        self.scaled_inside(op, e, by).or_else(|| self.scaled_root(op, e, by))
    }

    /// A switch times or by what is never negative, as a switch of products.
    fn scaled_inside(&mut self, op: Binary, switch: &Expr, by: &Expr) -> Option<Expr> {
        let both = [switch, by].map(|e| self.switches.held(e) == Holds::Switch);
        // A root among the factors, such as the radius of an arc, is no matter.
        if both != [true, false] || !never_negative(by) {
            return None;
        }
        let scaled = |e: &Expr| Expr::binary(op, e.clone(), by.clone());
        let e = match switch.node() {
            ExprNode::Unary(u @ (Unary::Abs | Unary::Neg), a) => Expr::unary(*u, scaled(a)),
            ExprNode::Binary(o @ (Binary::Min | Binary::Max | Binary::Add | Binary::Sub), a, b) => {
                Expr::binary(*o, scaled(a), scaled(b))
            }
            ExprNode::Binary(o @ (Binary::Mul | Binary::Div), a, k) if k.as_constant().is_some() => {
                Expr::binary(*o, scaled(a), k.clone())
            }
            ExprNode::Binary(Binary::Mul, k, a) if k.as_constant().is_some() => scaled(a) * k.clone(),
            ExprNode::Select(c, a, b) => Expr::select(c.clone(), scaled(a), scaled(b)),
            _ => return None,
        };
        self.switches.look_at(&e);
        Some(e)
    }

    /// A sum with a root that has no value somewhere, times or by another formula, as a sum of products. The factor of the root goes below
    /// it.
    fn scaled_root(&mut self, op: Binary, sum: &Expr, by: &Expr) -> Option<Expr> {
        if self.switches.held(by) == Holds::Root || !self.holds_bare(sum, 0) {
            return None;
        }
        let scaled = |e: &Expr| Expr::binary(op, e.clone(), by.clone());
        let e = match sum.node() {
            _ if let Some(under) = under_root(sum) => {
                let root = Expr::unary(Unary::Sqrt, Expr::binary(op, scaled(under), by.clone()));
                if never_negative(by) { root } else { Expr::select(by.clone(), root.clone(), -root) }
            }
            ExprNode::Unary(Unary::Neg, a) => -scaled(a),
            ExprNode::Binary(o @ (Binary::Add | Binary::Sub), a, b) => Expr::binary(*o, scaled(a), scaled(b)),
            ExprNode::Binary(o, a, k) if k.as_constant().is_some() => Expr::binary(*o, scaled(a), k.clone()),
            ExprNode::Binary(_, k, a) => k.clone() * scaled(a),
            _ => return None,
        };
        self.switches.look_at(&e);
        Some(e)
    }

    /// Whether a term of a sum is a root that has no value somewhere.
    fn holds_bare(&mut self, e: &Expr, depth: usize) -> bool {
        let deeper = depth + 1;
        match e.node() {
            _ if depth > DEPTH || !self.switches.within(e) => false,
            _ if under_root(e).is_some() => self.is_bare(e),
            ExprNode::Unary(Unary::Neg, a) => self.holds_bare(a, deeper),
            ExprNode::Binary(Binary::Add | Binary::Sub, a, b) => {
                self.holds_bare(a, deeper) || self.holds_bare(b, deeper)
            }
            ExprNode::Binary(Binary::Mul | Binary::Div, a, k) if k.as_constant().is_some() => {
                self.holds_bare(a, deeper)
            }
            ExprNode::Binary(Binary::Mul, k, a) if k.as_constant().is_some() => self.holds_bare(a, deeper),
            _ => false,
        }
    }

    /// A function of a switch as a switch of functions. Sums and multiples are looked through without.
    fn pulled(&mut self, e: &Expr) -> Option<Expr> {
        let is_function = match e.node() {
            ExprNode::Unary(..) | ExprNode::Binary(Binary::Pow | Binary::Hypot, ..) => true,
            ExprNode::Binary(Binary::Mul, a, b) => Arc::ptr_eq(&a.0, &b.0),
            _ => false,
        };
        if !is_function || self.is_smooth_power(e) {
            return None;
        }
        let e = outermost(e, &|e| self.switches.held(e) == Holds::Switch)?;
        self.switches.look_at(&e);
        Some(e)
    }

    /// `factor * |e| + rest >= 0`
    fn both_signs(&mut self, e: &Expr, factor: f64, rest: &Rest, depth: usize) -> Option<Solid> {
        let rest = Rest { mirrored: true, ..*rest };
        let (p, q) = (self.condition(e, factor, &rest, depth)?, self.condition(e, -factor, &rest, depth)?);
        Some(if factor > 0.0 { p | q } else { p & q })
    }

    fn is_smooth(&mut self, select: &Expr, [c, a, b]: [&Expr; 3]) -> bool {
        let Self { smooth, switches, .. } = self;
        *smooth.entry(std::ptr::from_ref(select.node())).or_insert_with(|| {
            switches.alive.push(select.clone());
            is_smooth(c, a, b)
        })
    }

    /// Whether this is a size whose slope is none where it is zero: `|u|**n` with n above 1, or `|u|` times an even power of `u`.
    fn is_smooth_power(&mut self, e: &Expr) -> bool {
        let size = |e: &Expr| match e.node() {
            ExprNode::Unary(Unary::Abs, u) => Some(u.clone()),
            _ => None,
        };
        match e.node() {
            ExprNode::Binary(Binary::Pow, a, n) => n.as_constant().is_some_and(|n| n > 1.0) && size(a).is_some(),
            ExprNode::Binary(Binary::Mul, a, b) => [(a, b), (b, a)].into_iter().any(|(a, b)| {
                let of = size(a).zip(even_power(b, |n| n > 0.0));
                of.is_some_and(|(u, v)| self.terms.number(&u) == self.terms.number(v))
            }),
            _ => false,
        }
    }

    fn is_bare(&mut self, root: &Expr) -> bool {
        let Self { bare, switches, .. } = self;
        *bare.entry(std::ptr::from_ref(root.node())).or_insert_with(|| {
            switches.alive.push(root.clone());
            is_bare(root)
        })
    }

    /// A formula by cases of the switches deep inside it that make creases.
    fn leaf(&mut self, e: Expr, cases: usize) -> Option<Solid> {
        self.switches.look_at(&e);
        if cases == MOST_CASES || self.switches.held(&e) != Holds::Switch {
            return Some(Solid::formula(e));
        }
        let Some(Cases { by, above, below }) = creased(&e, &mut self.terms) else { return Some(Solid::formula(e)) };
        self.taken_apart = true;
        self.pieces += 1;
        if self.pieces > MOST_PIECES {
            return None;
        }
        let (p, q) = (self.leaf(above, cases + 1)?, self.leaf(below, cases + 1)?);
        let by = self.leaf(by, cases + 1)?;
        Some((by.clone() & p) | (!by & q))
    }

    /// The condition of what is done with once nothing is ahead.
    fn ended(&mut self, rest: &Rest, depth: usize) -> Option<Solid> {
        if let Some(Ahead { term, factor, next }) = rest.ahead {
            return self.condition(term, *factor, &Rest { ahead: *next, ..*rest }, depth);
        }
        self.pieces += 1;
        let zero = Expr::constant(0.0);
        let done = rest.done.unwrap_or(&zero);
        let Some(Root { under, factor }) = rest.root else {
            return if self.pieces <= MOST_PIECES { self.leaf(done.clone(), 0) } else { None };
        };
        self.taken_apart = true;
        let without = if rest.mirrored { without_root_at_nose } else { without_root };
        (self.pieces <= MOST_PIECES).then(|| without(under, factor, done))
    }
}

/// The tangent of about 36 degrees, between the creases of an angle's absolute value and its middle: no simple share of a turn, as
/// other surfaces like to end there (a thread's root is at 135). The nearer to the creases, the farther leaves go on before they turn back.
const DIVIDED: f64 = 0.727;

/// `times * atan2(y, x)`, where `times` is never negative.
struct Angle {
    y: Expr,
    x: Expr,
    times: Option<Expr>,
}

impl Angle {
    fn by(self, op: Binary, k: &Expr) -> Self {
        let times = match self.times {
            Some(t) => Expr::binary(op, t, k.clone()),
            None => Expr::binary(op, Expr::constant(1.0), k.clone()),
        };
        Self { times: Some(times), ..self }
    }
}

impl Splitter {
    /// An angle, with factors and divisors that are numbers or never negative: an arc is an angle times a radius.
    fn angle(&self, e: &Expr, depth: usize) -> Option<Angle> {
        let deeper = depth + 1;
        match e.node() {
            _ if depth > DEPTH => None,
            ExprNode::Unary(Unary::Wrap, t) => {
                let [y, x] = [Unary::Sin, Unary::Cos].map(|op| Expr::unary(op, t.clone()));
                Some(Angle { y, x, times: None })
            }
            ExprNode::Binary(Binary::Atan2, y, x) if !self.switches.within(e) => {
                Some(Angle { y: y.clone(), x: x.clone(), times: None })
            }
            ExprNode::Unary(Unary::Neg, a) => self.angle(a, deeper),
            ExprNode::Binary(op @ (Binary::Mul | Binary::Div), a, b) if let Some(k) = b.as_constant() => {
                Some(self.angle(a, deeper)?.by(*op, &Expr::constant(k.abs())))
            }
            ExprNode::Binary(Binary::Mul, a, b) if let Some(k) = a.as_constant() => {
                Some(self.angle(b, deeper)?.by(Binary::Mul, &Expr::constant(k.abs())))
            }
            ExprNode::Binary(Binary::Mul, a, b) if never_negative(b) => Some(self.angle(a, deeper)?.by(Binary::Mul, b)),
            ExprNode::Binary(Binary::Mul, a, b) if never_negative(a) => Some(self.angle(b, deeper)?.by(Binary::Mul, a)),
            ExprNode::Binary(Binary::Div, a, b) if never_negative(b) => Some(self.angle(a, deeper)?.by(Binary::Div, b)),
            _ => None,
        }
    }

    /// `factor * |times * atan2(y, x)| + rest >= 0`. The angle rises on one side and falls on the other. Ahead, where it is below 36 degrees, the
    /// larger of the two counts, with a crease between them; behind, above 144, the smaller does; between there is one alone. Each is a
    /// leaf that goes on smoothly beyond both creases and swings back only in the middle of the other's side, where nobody asks it; a jump
    /// there would be seen by what is linear between points on both sides of it.
    fn unsigned_angle(&mut self, of: &Angle, factor: f64, rest: &Rest, depth: usize) -> Option<Solid> {
        self.taken_apart = true;
        let Angle { y, x, times } = of;
        let scaled = |e: Expr| times.as_ref().map_or(e.clone(), |k| e * k.clone());
        let rising = scaled(swinging(-x.clone(), y.clone()) + FRAC_PI_2);
        let falling = scaled(-swinging(x.clone(), -y.clone()) + FRAC_PI_2);
        let mut place = |e: Expr| self.condition(&e, 1.0, &Rest::default(), depth);
        let (right, left) = (place(x.clone() * DIVIDED + y.clone())?, place(x.clone() * DIVIDED - y.clone())?);
        let (p, q) = (self.condition(&rising, factor, rest, depth)?, self.condition(&falling, factor, rest, depth)?);
        let (larger, smaller) = (p.clone() | q.clone(), p.clone() & q.clone());
        let (near, far) = if factor > 0.0 { (larger, smaller) } else { (smaller, larger) };
        Some(cases(&right, cases(&left, near, p), cases(&left, q, far)))
    }
}

impl Rest<'_> {
    fn is_nothing(&self) -> bool {
        self.done.is_none() && self.ahead.is_none() && self.root.is_none()
    }
}

impl Splitter {
    /// Where `e >= 0`, or `e <= 0` if `negative`, where the sign follows from those of others though the value does not:
    /// R-operations, products, roots beside a number. `None` if `e` is none of these; see [`condition`](Self::condition) for
    /// the inner one.
    fn sign(&mut self, e: &Expr, negative: bool, depth: usize) -> Option<Option<Solid>> {
        if let Some(w) = self.terms.wedge(e, negative) {
            self.taken_apart = true;
            let [p, q] = w.sides.map(|s| self.shown(&s, 1.0, depth));
            return Some(p.zip(q).map(|(p, q)| if w.and { p & q } else { p | q }));
        }
        let factor = if negative { -1.0 } else { 1.0 };
        if self.switches.held(e) == Holds::Switch
            && let Some((square, sign)) = self.terms.root_beside_number(e, negative)
        {
            self.taken_apart = true;
            return Some(self.shown(&square, sign, depth));
        }
        let (ExprNode::Binary(Binary::Mul, a, b) | ExprNode::Binary(Binary::Div, a, b)) = e.node() else { return None };
        if a.as_constant().or(b.as_constant()).is_some() {
            return None;
        }
        for (factor_of, other) in [(b, a), (a, b)] {
            if never_negative(factor_of) {
                self.taken_apart = true;
                return Some(self.condition(other, factor, &Rest::default(), depth));
            }
        }
        self.taken_apart = true;
        let nothing = Rest::default();
        let both = self.condition(a, factor, &nothing, depth).zip(self.condition(b, 1.0, &nothing, depth));
        let neither = self.condition(a, -factor, &nothing, depth).zip(self.condition(b, -1.0, &nothing, depth));
        Some(both.zip(neither).map(|((p, q), (r, s))| (p & q) | (r & s)))
    }

    /// `factor * e + rest >= 0` for a smooth minimum or maximum of what has edges.
    fn rounded(&mut self, e: &Expr, factor: f64, rest: &Rest) -> Option<Solid> {
        if self.switches.held(e) != Holds::Switch || rest.ahead.is_some() || rest.root.is_some() {
            return None;
        }
        let number = self.terms.number(e);
        if self.plain.contains(&number) {
            return None;
        }
        let whole = plus(rest.done, e, factor);
        match smooth_join(e, factor, rest.done, &mut self.terms) {
            SmoothJoin::Of(value) => {
                self.taken_apart = true;
                Some(Primitive::Smooth(Arc::new(Smooth { value, rest: None, whole })).into())
            }
            SmoothJoin::TooLarge => Some(Solid::formula(whole)),
            SmoothJoin::No => {
                self.plain.insert(number);
                None
            }
        }
    }

    /// `factor * e + rest >= 0` for a distance as it is commonly written, where the rest is a number at most; `None` if it is not.
    fn distance(&mut self, e: &Expr, factor: f64, rest: &Rest, depth: usize) -> Option<Option<Solid>> {
        let is_number = rest.done.is_none_or(|d| d.as_constant().is_some());
        let is_sum = matches!(e.node(), ExprNode::Binary(Binary::Add | Binary::Sub, ..));
        if !is_sum || !is_number || rest.ahead.is_some() || rest.root.is_some() {
            return None;
        }
        let Sign { of, factor } = sign_of_distance(&plus(rest.done, e, factor), &mut self.terms)?;
        self.taken_apart = true;
        Some(self.shown(&of, factor, depth))
    }

    /// `factor * e + rest >= 0` for such a distance with a function beside it.
    fn displaced(&mut self, e: &Expr, factor: f64, rest: &Rest) -> Option<Solid> {
        let is_sum = matches!(e.node(), ExprNode::Binary(Binary::Add | Binary::Sub, ..));
        if !is_sum || rest.ahead.is_some() || rest.root.is_some() {
            return None;
        }
        let whole = plus(rest.done, e, factor);
        let smooth = displaced_distance(&whole, &mut self.terms)?;
        // A root with no value somewhere, and one that is an absolute value, are taken apart as terms of the sum; a jump is a wall first.
        let has_edge = |e: &Expr| root_of_square(e).is_some() || self.is_bare(e);
        if smooth.rest.as_ref().is_some_and(|rest| holds(rest, has_edge)) {
            return None;
        }
        self.taken_apart = true;
        Some(beside_jump(&whole).unwrap_or_else(|| Primitive::Smooth(Arc::new(smooth)).into()))
    }

    /// The condition of a formula that was put together here.
    fn shown(&mut self, e: &Expr, factor: f64, depth: usize) -> Option<Solid> {
        self.switches.look_at(e);
        self.condition(e, factor, &Rest::default(), depth)
    }
}

/// `a`, if the formula is the root of its square.
fn root_of_square(e: &Expr) -> Option<&Expr> {
    even_power(under_root(e)?, |n| n == 2.0)
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
mod tests;
