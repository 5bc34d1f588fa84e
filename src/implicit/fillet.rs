//! The fillet between two leaves of a blend.
//!
//! The function of a blend never falls when one of its operands rises, so it may be taken leaf by leaf: the blend of
//! minima and maxima is the same minima and maxima of blends of two leaves. Where these are not the leaves themselves
//! they are fillets. A tree of them has an edge wherever the operands have one, which a blend as one function would hide.

mod cubic;
mod parabola;
mod turning;

use glam::DVec3;

use super::contact::contact;
use super::expr::Binary;
use super::formula::Formula;
use super::leaf::Leaf;
use super::slopes::Slopes;
use super::smooth::Kernel;
use crate::numeric::{Dual, Interval, vector};
use crate::spatial::Aabb;
use parabola::SmoothMax;

/// A fillet ends this share of the radius before the lines where it touches its two surfaces: it is nearer to them than rounding
/// there. So it has none of a surface that it touches everywhere, as where walls of a height of one radius end in a plane.
const ENDS: f64 = 1e-8;

/// The band at its ends in which a fillet is taken for linear is no wider than this share of its span: it is a 128th of that away from the
/// fillet then.
const NARROW: f64 = 0.25;

/// One of the two surfaces of a fillet.
#[derive(Debug, Clone)]
pub(crate) struct Side {
    pub(crate) leaf: Leaf,
    /// Its number among the leaves of the tree.
    pub(crate) number: u32,
    /// Whether the operand is the leaf's complement.
    pub(crate) negate: bool,
}

impl Side {
    fn is(&self, other: &Side) -> bool {
        self.number == other.number && self.negate == other.negate
    }

    fn signed(&self) -> Signed<'_> {
        Signed { leaf: &self.leaf, number: self.number, negate: self.negate }
    }

    fn value(&self, p: DVec3) -> f64 {
        let v = self.leaf.value(p);
        if self.negate { -v } else { v }
    }

    fn smooth(&self, p: DVec3) -> Dual {
        let d = self.leaf.smooth(p);
        if self.negate { -d } else { d }
    }

    fn gradient(&self, p: DVec3) -> Dual {
        let d = self.leaf.gradient(p);
        if self.negate { -d } else { d }
    }

    fn slopes(&self, cell: &Aabb) -> Option<Slopes> {
        let s = self.leaf.slopes(cell)?;
        Some(if self.negate { s.negated() } else { s })
    }

    pub(crate) fn continued(&self, p: DVec3) -> f64 {
        let v = self.leaf.continued(p);
        if self.negate { -v } else { v }
    }

    fn range(&self, cell: &Aabb) -> Interval {
        let r = self.leaf.range(cell);
        if self.negate { -r } else { r }
    }
}

/// How a fillet goes from one of its surfaces to the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Profile {
    /// `|(r + a, r + b)| - r`, with a radius of any sign: where it is not positive this is the distance to what two faces share.
    Circle,
    /// `|(r + a, r + b)| - r` with another length, such as `(u + v + 2 sqrt(u² - uv + v²)) / 3`: the zeros of a smooth maximum of that width.
    Zeros(Kernel),
    /// That smooth maximum itself, for other values than zero: as `max(a, b) + (r - |a - b|)² / (4r)` where `|a - b|` is below `r`.
    SmoothMax(Kernel),
}

impl Profile {
    /// What tells it from others.
    pub(crate) fn number(self) -> f64 {
        match self {
            Profile::Circle => 0.0,
            Profile::Zeros(kernel) => 1.0 + f64::from(kernel as u8),
            Profile::SmoothMax(kernel) => -1.0 - f64::from(kernel as u8),
        }
    }
}

/// A fillet's value, and its partial derivatives by the values of its sides.
struct Joined {
    value: f64,
    by: [f64; 2],
}

/// `|(r + a, r + b)| - r` where `a` and `b` are above `-r`: a circle of radius `r` where the two surfaces are planes at a right
/// angle and the leaves are distances. Elsewhere it goes on smoothly to less than one of them at least, where only their union
/// counts; so it passes through each of its surfaces where it ends. It never falls when `a` or `b` rises.
///
/// With another [`Profile`] it is another curve, which touches both surfaces at the same places.
///
/// With a function beside it, `|(r + a, r + b)| - r + f`, it touches the surfaces of `a + f` and `b + f`, where it ends as without.
#[derive(Debug)]
pub(crate) struct Fillet {
    pub(crate) sides: [Side; 2],
    pub(crate) radius: f64,
    pub(crate) profile: Profile,
    /// A length that tells its size: the radius, or how far away it is asked for if it has none.
    pub(crate) span: f64,
    /// This near to the lines where it ends, the difference to the surface that it ends in is linear; 0 for as it is. A linear
    /// interpolant has the sign of the difference of squares in places that depend on the nodes it is of; this is right for all.
    pub(crate) band: f64,
    /// What is added to its function. Its sides are without, but have the numbers of the leaves with it.
    pub(crate) rest: Option<Formula>,
}

impl Fillet {
    /// The value with what is added at a point.
    fn with_rest(&self, joined: f64, p: DVec3) -> f64 {
        self.rest.as_ref().map_or(joined, |f| joined + f.value(p))
    }

    /// Value and gradient with it.
    fn dual_with_rest(&self, joined: Dual, p: DVec3) -> Dual {
        self.rest.as_ref().map_or(joined, |f| joined + f.gradient(p))
    }

    /// Where the surfaces are planes one behind the other, a radius apart or more, it ends all along them, and is positive where the
    /// function of the first one is: the number of that side.
    pub(crate) fn replaced(&self) -> Option<usize> {
        let plane = |s: &Side| match s.leaf {
            Leaf::Plane { n, d } => Some(if s.negate { (-n, -d) } else { (n, d) }),
            _ => None,
        };
        let [Some((n, d)), Some((m, e))] = self.sides.each_ref().map(plane) else { return None };
        (self.radius > 0.0 && n == m && (d - e).abs() >= (1.0 - ENDS) * self.radius).then_some(usize::from(d < e))
    }

    /// The smooth maximum, if it is one.
    fn smooth_max(&self) -> Option<SmoothMax> {
        let Profile::SmoothMax(kernel) = self.profile else { return None };
        Some(SmoothMax { kernel, width: self.radius, band: self.band })
    }

    /// The length of two distances from where it ends.
    #[inline(always)]
    fn length(&self, u: f64, v: f64) -> f64 {
        match self.profile {
            Profile::Zeros(Kernel::Square) => parabola::length(u, v),
            Profile::Zeros(Kernel::Cube) => cubic::length(u, v),
            _ => vector::hypot(u, v),
        }
    }

    /// The partial derivatives of a length, given as that of the two distances.
    #[inline(always)]
    fn shares(&self, u: f64, v: f64, length: f64) -> [f64; 2] {
        match self.profile {
            Profile::Zeros(Kernel::Square) => parabola::shares(u, v),
            Profile::Zeros(Kernel::Cube) => cubic::shares(u, v, length),
            _ => [u, v].map(|x| x / length.max(f64::MIN_POSITIVE)),
        }
    }

    /// How far before the lines where it touches its surfaces it ends.
    fn ends(&self) -> f64 {
        ENDS * self.radius.max(0.0)
    }

    fn join(&self, a: f64, b: f64) -> f64 {
        self.joined([a, b], self.length(self.radius + a, self.radius + b)).value
    }

    /// The fillet by the values of its sides, and its partial derivatives by them; `whole` is `|(r + a, r + b)|`. What is not asked
    /// for costs nothing.
    #[inline(always)]
    fn joined(&self, [a, b]: [f64; 2], whole: f64) -> Joined {
        let r = self.radius;
        let (u, v) = (r + a, r + b);
        if a.is_nan() || b.is_nan() {
            return Joined { value: f64::NAN, by: [f64::NAN; 2] };
        }
        if let Some(max) = self.smooth_max() {
            return max.joined([a, b]);
        }
        let ends = self.ends();
        let (more, less) = (u.max(v), u.min(v));
        if less.abs() < self.band && more > self.band {
            let long = self.length(more, self.band);
            let of_less = (long - more) / self.band;
            let of_more = 1.0 + less / self.band * (self.shares(more, self.band, long)[0] - 1.0);
            return Joined {
                value: more - r + (less - ends) / self.band * (long - more),
                by: if u >= v { [of_more, of_less] } else { [of_less, of_more] },
            };
        }
        if less > ends {
            return Joined { value: whole - r, by: self.shares(u, v, whole) };
        }
        let (x, y) = (u.max(0.0), v.max(0.0));
        // The root of a square is the number itself, to the last bit.
        let part = if less <= 0.0 { more.max(0.0) } else { whole };
        let (of_part, of_whole) = (self.shares(x, y, part), self.shares(u, v, whole));
        let of_part = if less <= 0.0 { [x, y].map(|x| if x > 0.0 { 1.0 } else { 0.0 }) } else { of_part };
        Joined {
            value: 2.0 * part - whole - r - ends,
            by: [2.0 * of_part[0] - of_whole[0], 2.0 * of_part[1] - of_whole[1]],
        }
    }

    /// Whether the fillet itself, and not its continuation, passes here.
    pub(crate) fn is_between(&self, p: DVec3) -> bool {
        let [a, b] = self.sides.each_ref().map(|s| s.value(p));
        match self.smooth_max() {
            Some(max) => max.is_between(a, b),
            None => self.radius + a.min(b) > self.ends(),
        }
    }

    /// Whether the fillet ends at a place nearer than `reach`, to first order.
    pub(crate) fn ends_near(&self, p: DVec3, reach: f64) -> bool {
        let [a, b] = self.sides.each_ref().map(|s| s.smooth(p));
        if self.smooth_max().is_some() {
            return (self.radius - (a.v - b.v).abs()).abs() <= reach * (a.g - b.g).length();
        }
        let [a, b] = [a, b].map(|d| (self.radius + d.v) / d.g.length());
        a.min(b).abs() <= reach
    }

    pub(crate) fn value(&self, p: DVec3) -> f64 {
        self.with_rest(self.join(self.sides[0].value(p), self.sides[1].value(p)), p)
    }

    pub(crate) fn eval(&self, xs: &[f64], ys: &[f64], zs: &[f64], out: &mut [f64]) {
        /// Points at a time: with four lists of numbers of this length everything stays in the first-level cache.
        const BLOCK: usize = 64;
        let mut second = [0.0; BLOCK];
        let [mut u, mut v, mut whole] = [[0.0; BLOCK]; 3];
        let [s, t] = [0, 1].map(|k| if self.sides[k].negate { -1.0 } else { 1.0 });
        let mut start = 0;
        while start < out.len() {
            let end = (start + BLOCK).min(out.len());
            let n = end - start;
            let (x, y, z) = (&xs[start..end], &ys[start..end], &zs[start..end]);
            let (a, b) = (&mut out[start..end], &mut second[..n]);
            self.sides[0].leaf.eval(x, y, z, a);
            self.sides[1].leaf.eval(x, y, z, b);
            for k in 0..n {
                (u[k], v[k]) = (self.radius + s * a[k], self.radius + t * b[k]);
            }
            if let Profile::Zeros(_) = self.profile {
                (0..n).for_each(|k| whole[k] = self.length(u[k], v[k]));
            } else {
                vector::hypot_many(&u[..n], &v[..n], &mut whole[..n]);
            }
            for k in 0..n {
                a[k] = self.joined([s * a[k], t * b[k]], whole[k]).value;
            }
            if let Some(rest) = &self.rest {
                rest.eval(x, y, z, b);
                (0..n).for_each(|k| a[k] += b[k]);
            }
            start = end;
        }
    }

    /// Value and gradient of what [`eval`](Self::eval) gives.
    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        let [a, b] = self.sides.each_ref().map(|s| s.gradient(p));
        let Joined { value, by } = self.joined([a.v, b.v], self.length(self.radius + a.v, self.radius + b.v));
        self.dual_with_rest(Dual::new(value, a.g * by[0] + b.g * by[1]), p)
    }

    /// Bounds of what [`gradient`](Self::gradient) gives in a box, if there are bounds of its sides.
    pub(crate) fn slopes(&self, cell: &Aabb) -> Option<Slopes> {
        let [a, b] = self.sides.each_ref().map(|s| s.slopes(cell));
        let (a, b) = (a?, b?);
        if let Some(max) = self.smooth_max() {
            return Some(Slopes { value: self.range(cell), gradient: max.slopes(&a, &b) });
        }
        let [du, dv] = self.by_sides(&a, &b);
        let gradient = std::array::from_fn(|k| a.gradient[k] * du + b.gradient[k] * dv);
        let joined = Slopes { value: self.range_alone(cell), gradient };
        Some(self.rest.as_ref().map_or(joined, |f| joined.binary(Binary::Add, f.slopes(&cell.intervals()))))
    }

    /// Bounds of the partial derivatives by its sides.
    fn by_sides(&self, a: &Slopes, b: &Slopes) -> [Interval; 2] {
        if let Some(max) = self.smooth_max() {
            let first = max.of_first(a.value - b.value);
            return [first, Interval::point(1.0) - first];
        }
        let radius = Interval::point(self.radius);
        let (u, v) = (radius + a.value, radius + b.value);
        if u.lo > 0.0 {
            self.weights(u, v)
        } else if v.lo > 0.0 {
            let [dv, du] = self.weights(v, u);
            [du, dv]
        } else {
            [Interval::new(0.0, 2.0); 2]
        }
    }

    /// Value and gradient of its function between its ends, everywhere: the surface that the fillet is a part of.
    pub(crate) fn smooth(&self, p: DVec3) -> Dual {
        let r = self.radius;
        let [a, b] = self.sides.each_ref().map(|s| s.smooth(p));
        if let Profile::Zeros(kernel) | Profile::SmoothMax(kernel) = self.profile {
            return parabola::smooth(kernel, r, a, b);
        }
        let (u, v) = (r + a.v, r + b.v);
        let length = vector::hypot(u, v);
        let g = if length > 0.0 { (a.g * u + b.g * v) / length } else { DVec3::ZERO };
        self.dual_with_rest(Dual::new(length - r, g), p)
    }

    pub(crate) fn range(&self, cell: &Aabb) -> Interval {
        let alone = self.range_alone(cell);
        let [x, y, z] = cell.intervals();
        self.rest.as_ref().map_or(alone, |f| alone + f.range(x, y, z))
    }

    /// Bounds without what is added.
    fn range_alone(&self, cell: &Aabb) -> Interval {
        let (a, b) = (self.sides[0].range(cell), self.sides[1].range(cell));
        let slack = |v: f64| if v.is_finite() { 8.0 * f64::EPSILON * (v.abs() + self.radius.abs()) } else { 0.0 };
        let (lo, hi) = (self.join(a.lo, b.lo), self.join(a.hi, b.hi));
        let bounds = Interval::new(lo - slack(lo), hi + slack(hi));
        // Where it has ended it may be anything below its surfaces: less lets the tree do without it. A smooth maximum that has ended is as
        // great as one side, which counts where it is the least of several.
        let ended = self.smooth_max().is_none() && self.radius + a.hi.min(b.hi) <= 0.0;
        if ended {
            let below = self.radius.abs();
            Interval::new(bounds.lo.min(a.lo.min(b.lo) - below), bounds.hi.min(a.hi.min(b.hi) - below))
        } else {
            bounds
        }
    }

    /// Bounds of the partial derivatives of [`join`](Self::join) by `u` and `v`, the distances to where it ends, where `u` is positive.
    fn weights(&self, u: Interval, v: Interval) -> [Interval; 2] {
        if self.profile == Profile::Zeros(Kernel::Square) {
            return parabola::weights(u, v, self.band);
        }
        let (near, far) = (v.abs().lo, v.abs().hi.max(self.band));
        // A coordinate over the length rises with it, and falls when the other one rises.
        let share = |lo: f64, other: f64| match self.profile {
            Profile::Zeros(_) => cubic::share(lo, other),
            _ if lo.is_finite() => lo / vector::hypot(lo, other),
            _ => 1.0,
        };
        let along = Interval::new(share(u.lo, far), share(u.hi, near));
        let beyond = Interval::point(2.0) - along;
        let of_u = if v.lo >= 0.0 {
            along
        } else if v.hi <= 0.0 {
            beyond
        } else {
            along.hull(beyond)
        };
        let across = |v: f64, u: f64| if v > 0.0 { share(v, u) } else { 0.0 };
        let in_band = near < self.band;
        // In the band, half the slope at its end or more.
        let least = if in_band { 0.0 } else { across(near, u.hi) };
        [of_u, Interval::new(least, across(far, u.lo))]
    }

    /// The same with a [band](Self::band) for linear interpolants about so long.
    pub(crate) fn banded(&self, length: f64) -> Self {
        let sides = self.sides.each_ref().map(|s| Side { leaf: s.leaf.banded(length), ..*s });
        Self { sides, band: length.min(NARROW * self.span), rest: self.rest.clone(), ..*self }
    }

    /// Like [`eval`](Self::eval), but where the fillet ends its surface goes on along the surface that it ends in.
    pub(crate) fn continued(&self, p: DVec3) -> f64 {
        self.with_rest(self.between(self.sides[0].continued(p), self.sides[1].continued(p)), p)
    }

    /// The same by the values of the sides.
    pub(crate) fn between(&self, a: f64, b: f64) -> f64 {
        if let Some(max) = self.smooth_max() {
            return max.between(a, b);
        }
        let (u, v) = (self.radius + a, self.radius + b);
        if u > 0.0 && v > 0.0 { self.length(u, v) - self.radius } else { a.max(b) }
    }

    /// Of a side: the other one.
    fn opposite(&self, k: usize) -> &Side {
        &self.sides[1 - k]
    }

    /// A function that vanishes with the fillet where the leaves that have the numbers `before` and `after` do, too, and
    /// whose gradient then is not along theirs: a fillet touches its two surfaces, and those with one side in common touch
    /// each other where they end. Its gradient need not have length 1.
    pub(crate) fn beside(&self, leaves: &[Leaf], before: &[u32], after: &[u32], p: DVec3) -> Dual {
        let earlier = || {
            before.iter().filter_map(|i| match leaves.get(*i as usize) {
                Some(Leaf::Fillet(f)) => self.apart_from(f),
                _ => None,
            })
        };
        // Fillets that end in one surface, of two that touch.
        if let Some(apart) = earlier().find(|x| x.less.is_none()) {
            return apart.smooth(p);
        }
        for (k, side) in self.sides.iter().enumerate() {
            if before.iter().chain(after).any(|i| *i == side.number) {
                return Apart { sign: 1.0, radius: self.radius, more: self.opposite(k), less: None }.smooth(p);
            }
        }
        if let Some(apart) = earlier().next() {
            return apart.smooth(p);
        }
        self.smooth(p)
    }

    /// How this fillet and another one with the same radius, which have a side in common, are told apart.
    fn apart_from<'a>(&'a self, other: &'a Fillet) -> Option<Apart<'a>> {
        if self.radius != other.radius || self.profile != other.profile {
            return None;
        }
        let pairs = [(0, 0), (1, 1), (0, 1), (1, 0)];
        let (k, l) = pairs.into_iter().find(|&(k, l)| self.sides[k].is(&other.sides[l]))?;
        let (more, less) = (self.opposite(k), other.opposite(l));
        Some(apart(more.signed(), less.signed()).unwrap_or(Apart { sign: 1.0, radius: 0.0, more, less: Some(less) }))
    }
}

/// What has the sign of the difference of two functions whose zeros touch: `sign * (radius + more - less)`.
pub(crate) struct Apart<'a> {
    sign: f64,
    radius: f64,
    more: &'a Side,
    less: Option<&'a Side>,
}

impl Apart<'_> {
    /// With its gradient; the surfaces are those that fillets are a part of.
    fn smooth(&self, p: DVec3) -> Dual {
        let (a, b) = (self.more.smooth(p), self.less.map_or(Dual::new(0.0, DVec3::ZERO), |s| s.smooth(p)));
        Dual::new(self.sign * (self.radius + a.v - b.v), self.sign * (a.g - b.g))
    }

    fn reversed(self) -> Self {
        Self { sign: -self.sign, ..self }
    }

    /// Bounds of value and gradient in a box, and both in its middle.
    pub(crate) fn slopes(&self, cell: &Aabb) -> Option<Slopes> {
        let more = self.more.slopes(cell)?;
        let less = match self.less {
            Some(s) => s.slopes(cell)?,
            None => Slopes::constant(0.0),
        };
        let all = more.binary(Binary::Sub, less).binary(Binary::Add, Slopes::constant(self.radius));
        Some(if self.sign < 0.0 { all.negated() } else { all })
    }

    /// Value and gradient, with fillets as they are evaluated.
    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        let (a, b) = (self.more.gradient(p), self.less.map_or(Dual::new(0.0, DVec3::ZERO), |s| s.gradient(p)));
        Dual::new(self.sign * (self.radius + a.v - b.v), self.sign * (a.g - b.g))
    }
}

/// A leaf or its complement.
#[derive(Clone, Copy)]
struct Signed<'a> {
    leaf: &'a Leaf,
    number: u32,
    negate: bool,
}

/// What has the sign of `a - b`, if one is a fillet that ends in the other or both end in a third.
fn apart<'a>(a: Signed<'a>, b: Signed<'a>) -> Option<Apart<'a>> {
    let turned = |a: Apart<'a>, turn: bool| if turn { a.reversed() } else { a };
    // A fillet touches its sides, its complement touches theirs.
    let one_way = |a: Signed<'a>, b: Signed<'a>| {
        let Leaf::Fillet(f) = a.leaf else { return None };
        let k = f.sides.iter().position(|s| s.number == b.number && s.negate == (b.negate != a.negate))?;
        Some(turned(Apart { sign: 1.0, radius: f.radius, more: f.opposite(k), less: None }, a.negate))
    };
    one_way(a, b).or_else(|| one_way(b, a).map(Apart::reversed)).or_else(|| match (a.leaf, b.leaf) {
        (Leaf::Fillet(f), Leaf::Fillet(g)) if a.negate == b.negate => f.apart_from(g).map(|x| turned(x, a.negate)),
        _ => None,
    })
}

/// What vanishes on one of two leaves that touch where the other does, and crosses it there.
pub(crate) enum Between<'a> {
    /// One ends in the other, or both in a third.
    Ends(Apart<'a>),
    /// They touch along a curve.
    Contact(Leaf),
}

impl Between<'_> {
    /// Bounds of value and gradient in a box.
    pub(crate) fn slopes(&self, cell: &Aabb) -> Option<Slopes> {
        match self {
            Between::Ends(apart) => apart.slopes(cell),
            Between::Contact(leaf) => leaf.slopes(cell),
        }
    }

    /// Value and gradient, with fillets as they are evaluated.
    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        match self {
            Between::Ends(apart) => apart.gradient(p),
            Between::Contact(leaf) => leaf.gradient(p),
        }
    }
}

/// What tells the sides of leaf `j` on the surface of leaf `on`, if they touch.
pub(crate) fn touching(leaves: &[Leaf], on: u32, j: u32) -> Option<Between<'_>> {
    let leaf = |number: u32, negate: bool| Signed { leaf: &leaves[number as usize], number, negate };
    let ends = [false, true].into_iter().find_map(|negate| apart(leaf(j, false), leaf(on, negate)));
    let touch = || contact(&leaves[on as usize], &leaves[j as usize]).map(Between::Contact);
    ends.map(Between::Ends).or_else(touch)
}
