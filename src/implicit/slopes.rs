//! Bounds of a leaf's gradient over a box: forward differentiation in interval arithmetic.

mod revolved;

use std::f64::consts::PI;

use glam::DVec3;

use super::expr::{BEYOND, Binary, STEEPENED, SWING, SWUNG_BACK, Unary};
use super::leaf::{Frame, Leaf};
use crate::numeric::Interval;
use crate::spatial::Aabb;
use revolved::Around;

/// Bounds of a value and of its three partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slopes {
    pub(crate) value: Interval,
    pub(crate) gradient: [Interval; 3],
}

fn each(f: impl Fn(usize) -> Interval) -> [Interval; 3] {
    std::array::from_fn(f)
}

impl Slopes {
    pub(crate) fn constant(c: f64) -> Self {
        Self { value: Interval::point(c), gradient: [Interval::ZERO; 3] }
    }

    /// A coordinate that has the given bounds.
    pub(crate) fn coordinate(axis: usize, value: Interval) -> Self {
        Self { value, gradient: each(|k| Interval::point(f64::from(u8::from(k == axis)))) }
    }

    /// A function of it with the given value and derivative.
    fn chain(self, value: Interval, slope: Interval) -> Self {
        Self { value, gradient: each(|k| self.gradient[k] * slope) }
    }

    /// Of what jumps somewhere in the box: nothing is known of differences.
    fn jumping(value: Interval) -> Self {
        Self { value, gradient: [Interval::ALL; 3] }
    }

    fn hull(self, other: Self) -> Self {
        Self { value: self.value.hull(other.value), gradient: each(|k| self.gradient[k].hull(other.gradient[k])) }
    }

    pub(crate) fn negated(self) -> Self {
        Self { value: -self.value, gradient: self.gradient.map(|g| -g) }
    }

    pub(crate) fn square(self) -> Self {
        self.chain(self.value.square(), self.value.scale(2.0))
    }

    pub(crate) fn unary(self, op: Unary) -> Self {
        let v = self.value;
        let value = match op {
            Unary::Neg => return self.negated(),
            Unary::Abs if v.lo >= 0.0 => return self,
            Unary::Abs if v.hi <= 0.0 => return self.negated(),
            Unary::Abs => return Self { value: v.abs(), ..self.hull(self.negated()) },
            Unary::Sqrt => v.sqrt(),
            Unary::Exp => v.exp(),
            Unary::Log => v.ln(),
            Unary::Sin => v.sin(),
            Unary::Cos => v.cos(),
            Unary::Tan => v.tan(),
            Unary::Steepened => v.steepened(STEEPENED),
            Unary::Swing => v.swing(SWING),
            Unary::Wrap => v.wrap(),
            Unary::Upward => v.turned(BEYOND),
            Unary::Downward => v.turned(-BEYOND),
            Unary::Fold => v.fold(),
            Unary::Asin => v.asin(),
            Unary::Acos => v.acos(),
            Unary::Sinh => v.sinh(),
            Unary::Cosh => v.cosh(),
            Unary::Tanh => v.tanh(),
            Unary::Floor => return self.stepped(v.floor()),
            Unary::Sign => return self.stepped(v.sign()),
        };
        match slope(op, v, value) {
            Some(slope) => self.chain(value, slope),
            None => Self::jumping(value),
        }
    }

    /// A function that is constant but for jumps, with the given bounds. Where it may jump its slopes have no bounds.
    fn stepped(self, value: Interval) -> Self {
        let jumps = value.lo != value.hi;
        Self {
            value,
            gradient: self.gradient.map(|g| if jumps && g != Interval::ZERO { Interval::ALL } else { Interval::ZERO }),
        }
    }

    pub(crate) fn binary(self, op: Binary, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let (ga, gb) = (self.gradient, other.gradient);
        match op {
            Binary::Add => Self { value: a + b, gradient: each(|k| ga[k] + gb[k]) },
            Binary::Sub => Self { value: a - b, gradient: each(|k| ga[k] - gb[k]) },
            Binary::Mul => Self { value: a * b, gradient: each(|k| ga[k] * b + gb[k] * a) },
            Binary::Div => {
                let q = a / b;
                Self { value: q, gradient: each(|k| (ga[k] - gb[k] * q) / b) }
            }
            Binary::Pow if gb == [Interval::ZERO; 3] => {
                let less = b - Interval::point(1.0);
                // An exponent that is one number stays one.
                let less = if b.lo == b.hi { Interval::point(b.lo - 1.0) } else { less };
                self.chain(a.pow(b), a.pow(less) * b)
            }
            Binary::Pow => {
                let v = a.pow(b);
                Self { value: v, gradient: each(|k| (gb[k] * a.ln() + ga[k] * (b / a)) * v) }
            }
            Binary::Min if a.hi < b.lo => self,
            Binary::Min if b.hi < a.lo => other,
            Binary::Min => Self { value: a.min(b), ..self.hull(other) },
            Binary::Max if a.lo > b.hi => self,
            Binary::Max if b.lo > a.hi => other,
            Binary::Max => Self { value: a.max(b), ..self.hull(other) },
            Binary::Atan2 => {
                let v = a.atan2(b);
                if v.lo <= -PI && v.hi >= PI {
                    return Self::jumping(v);
                }
                let q = a.square() + b.square();
                Self { value: v, gradient: each(|k| (ga[k] * b - gb[k] * a) / q) }
            }
            Binary::Hypot => {
                let h = a.hypot(b);
                let (x, y) = (share(a, h), share(b, h));
                Self { value: h, gradient: each(|k| ga[k] * x + gb[k] * y) }
            }
            Binary::Mod => {
                let steps = (a / b).floor();
                let jumps = steps.lo != steps.hi;
                let still = |k: usize| ga[k] == Interval::ZERO && gb[k] == Interval::ZERO;
                let slope = |k: usize| if jumps { Interval::ALL } else { ga[k] - gb[k].scale(steps.lo) };
                Self { value: a.modulo(b), gradient: each(|k| if still(k) { Interval::ZERO } else { slope(k) }) }
            }
        }
    }

    /// `self` where the condition is not negative, else `other`; between them the value may jump.
    pub(crate) fn select(self, condition: Interval, other: Self) -> Self {
        if condition.lo >= 0.0 {
            self
        } else if condition.hi < 0.0 {
            other
        } else {
            Self::jumping(self.value.hull(other.value))
        }
    }

    /// The same, where the value and the gradient do not jump.
    pub(crate) fn joined(self, condition: Interval, other: Self) -> Self {
        if condition.lo >= 0.0 || condition.hi < 0.0 { self.select(condition, other) } else { self.hull(other) }
    }

    /// The same with bounds of the gradient by what it is the length of, and by the derivatives by that.
    pub(crate) fn of_length(self, parts: impl Iterator<Item = (Self, Interval)>) -> Self {
        let sum = parts.fold([Interval::ZERO; 3], |sum, (s, by)| each(|k| sum[k] + s.gradient[k] * by));
        Self { gradient: each(|k| self.gradient[k].within(sum[k])), ..self }
    }

    /// The same with other bounds of the gradient where these are closer.
    fn with_gradient(self, other: [Interval; 3]) -> Self {
        Self { gradient: each(|k| self.gradient[k].within(other[k])), ..self }
    }

    /// Bounds by slopes at the middle of the box, half as wide as `half` and with `middle` as bounds of the value there: closer than
    /// those of the operations on a small box.
    pub(crate) fn closer(self, middle: Interval, half: &[f64; 3]) -> Self {
        let reach = |k: usize| self.gradient[k] * Interval { lo: -half[k], hi: half[k] };
        let v = middle + (reach(0) + reach(1) + reach(2));
        Self { value: self.value.within(v), ..self }
    }
}

/// Bounds of the derivative of a vector's length by one of its components: on the unit sphere, of the component's sign.
pub(super) fn share(component: Interval, length: Interval) -> Interval {
    let part = if length.lo > 0.0 { component / length } else { Interval::ALL };
    let lo = if component.lo >= 0.0 { 0.0 } else { -1.0 };
    let hi = if component.hi <= 0.0 { 0.0 } else { 1.0 };
    part.within(Interval { lo, hi })
}

/// Bounds of an operation's derivative where its operand and its value have bounds; nothing where it may jump.
pub(super) fn slope(op: Unary, v: Interval, value: Interval) -> Option<Interval> {
    let one = Interval::point(1.0);
    Some(match op {
        Unary::Neg => -one,
        Unary::Abs if v.lo >= 0.0 => one,
        Unary::Abs if v.hi <= 0.0 => -one,
        Unary::Abs => Interval { lo: -1.0, hi: 1.0 },
        Unary::Sqrt => Interval::point(0.5) / value,
        Unary::Exp => value,
        Unary::Log => one / v,
        Unary::Sin => v.cos(),
        Unary::Cos => -v.sin(),
        Unary::Tan => one + value.square(),
        Unary::Steepened => {
            let of = |v: f64| if v < 0.0 { STEEPENED } else { 1.0 };
            Interval { lo: of(v.hi), hi: of(v.lo) }
        }
        Unary::Swing => {
            let w = v.wrap();
            let ahead = w.lo >= -SWING && w.hi <= SWING;
            Interval { lo: if ahead { 1.0 } else { -SWUNG_BACK }, hi: 1.0 }
        }
        Unary::Fold => {
            let w = v.wrap();
            let (rises, falls) = (w.lo >= 0.0 && w.hi <= PI, w.hi <= 0.0 && w.lo >= -PI);
            Interval { lo: if rises { 1.0 } else { -1.0 }, hi: if falls { -1.0 } else { 1.0 } }
        }
        // Wide means that it may jump.
        Unary::Wrap if value.lo <= -PI && value.hi >= PI => return None,
        Unary::Upward | Unary::Downward if value.hi - value.lo >= 2.0 * PI => return None,
        Unary::Wrap | Unary::Upward | Unary::Downward => one,
        Unary::Asin => one / (one - v.square()).sqrt(),
        Unary::Acos => -(one / (one - v.square()).sqrt()),
        Unary::Sinh => v.cosh(),
        Unary::Cosh => v.sinh(),
        Unary::Tanh => one - value.square(),
        Unary::Floor | Unary::Sign if value.lo == value.hi => Interval::ZERO,
        Unary::Floor | Unary::Sign => return None,
    })
}

/// The coordinates of a box in a frame at a point, along `u`, `v` and `a`.
fn local(c: DVec3, f: &Frame, b: &[Interval; 3]) -> [Slopes; 3] {
    [f.u, f.v, f.a].map(|e| {
        let term = |k: usize| (b[k] - Interval::point(c[k])).scale(e[k]);
        Slopes { value: term(0) + term(1) + term(2), gradient: each(|k| Interval::point(e[k])) }
    })
}

impl Leaf {
    /// Bounds of value and gradient over a box; `None` for what is only known point by point.
    pub(crate) fn slopes(&self, cell: &Aabb) -> Option<Slopes> {
        let b = cell.intervals();
        let scaled = |s: Slopes, k: f64| Slopes { value: s.value.scale(k), gradient: s.gradient.map(|g| g.scale(k)) };
        let constant = Slopes::constant;
        let gradient = match self {
            Leaf::Plane { n, .. } => each(|k| Interval::point(-n[k])),
            Leaf::Sphere { c, r } => each(|k| (Interval::point(c[k]) - b[k]).scale(1.0 / r)),
            Leaf::Cylinder { c, frame, r } => {
                // It is linear in the point.
                let [u, v] = [frame.u, frame.v].map(|e| e.to_array());
                let term = |k: usize, j: usize| (b[j] - Interval::point(c[j])).scale(-(u[k] * u[j] + v[k] * v[j]) / r);
                each(|k| term(k, 0) + term(k, 1) + term(k, 2))
            }
            Leaf::Cone { c, frame, k, m, .. } => {
                let [u, v, t] = local(*c, frame, &b);
                let rho = u.binary(Binary::Hypot, v);
                let rho = match Around::new(*c, frame, cell) {
                    Some(seen) => rho.with_gradient(seen.outward()),
                    None => rho,
                };
                scaled(rho, -k).binary(Binary::Sub, scaled(t, *m)).gradient
            }
            Leaf::Torus { c, frame, major, minor } => {
                let [u, v, t] = local(*c, frame, &b);
                let q = u.binary(Binary::Hypot, v).binary(Binary::Sub, constant(*major));
                let whole = scaled(q.square().binary(Binary::Add, t.square()), -0.5 / minor);
                let from = |p: DVec3| {
                    let flat = (p - *c) - frame.a * (p - *c).dot(frame.a);
                    p - *c - flat.normalize_or_zero() * *major
                };
                match Around::new(*c, frame, cell) {
                    Some(seen) => {
                        let away = seen.away_from_circle(*major, from).map(|g| g.scale(-1.0 / minor));
                        whole.with_gradient(away).gradient
                    }
                    None => whole.gradient,
                }
            }
            Leaf::Formula(f) => return Some(f.slopes(&b)),
            Leaf::Fillet(f) => return f.slopes(cell),
            Leaf::Field(..) | Leaf::Blend(_) => return None,
        };
        Some(Slopes { value: self.range(cell), gradient })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::expr::Expr;
    use crate::implicit::formula::Formula;
    use crate::implicit::lower::lower;
    use crate::implicit::{Placement, Primitive, Solid};

    fn involute(t: &Expr) -> Expr {
        t.clone() - Expr::binary(Binary::Atan2, t.clone(), Expr::constant(1.0))
    }

    /// The length of three numbers as it may be written, the last one with a factor.
    fn lengths([a, b, c]: [Expr; 3]) -> [Expr; 3] {
        let square = |e: &Expr| e.clone() * e.clone();
        let sum = square(&a) + square(&b) + square(&c) * 4.0 / 2.0 + 0.0;
        let root = Expr::binary(Binary::Pow, sum.clone(), Expr::constant(0.5));
        let hypot = Expr::binary(Binary::Hypot, Expr::binary(Binary::Hypot, a, b), c * 2f64.sqrt());
        [Expr::unary(Unary::Sqrt, sum), root, hypot]
    }

    #[test]
    fn lengths_have_slopes_where_they_are_zero() {
        let beyond = |e: Expr| Expr::binary(Binary::Max, Expr::unary(Unary::Abs, e) - 1.0, Expr::constant(0.0));
        let axes = [Expr::x(), Expr::y(), Expr::z()];
        let outside = axes.clone().map(beyond);
        let cell = Aabb::new(DVec3::new(0.5, 0.9, -0.1), DVec3::new(0.9, 1.1, 0.1));
        let around = Aabb::new(DVec3::splat(-0.1), DVec3::splat(0.2));
        for (ends, cell, most) in [(outside, cell, [0.0, 1.0, 0.0]), (axes, around, [1.0, 1.0, 2f64.sqrt()])] {
            for e in lengths(ends) {
                let leaf = Leaf::Formula(Formula::compile(&e, &Placement::IDENTITY));
                let s = leaf.slopes(&cell).unwrap();
                for k in 0..3 {
                    let g = s.gradient[k];
                    assert!(g.lo >= -most[k] - 1e-12 && g.hi <= most[k] + 1e-12, "{e:?}: {g:?}");
                }
                assert!(s.value.hi < 0.5, "{e:?}: {:?}", s.value);
            }
        }
    }

    #[test]
    fn what_varies_alike_cancels_in_bounds_of_gradients() {
        // The slope of t - atan(t) is t² / (1 + t²).
        let leaf = Leaf::Formula(Formula::compile(&involute(&(Expr::x() * 3.0)), &Placement::IDENTITY));
        for x in [0.1, 0.3, 1.0] {
            let slope = |x: f64| 27.0 * x * x / (1.0 + 9.0 * x * x);
            let cell = Aabb::new(DVec3::splat(x), DVec3::splat(1.1 * x));
            let g = leaf.slopes(&cell).unwrap().gradient[0];
            assert!(g.contains(slope(x)) && g.contains(slope(1.1 * x)), "{g:?}");
            assert!(g.hi - g.lo < 1.001 * (slope(1.1 * x) - slope(x)), "{g:?}");
        }
    }

    #[test]
    fn slopes_hold_the_gradients_of_random_leaves_on_random_boxes() {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let (un, bi) = (Expr::unary, Expr::binary);
        let formulas = [
            x.clone() * y.clone() / (z.clone() * z.clone() + 0.3),
            un(Unary::Sin, x.clone() * 3.0) * un(Unary::Cos, y.clone() * 2.0) + un(Unary::Exp, z.clone()),
            un(Unary::Sqrt, x.clone() * x.clone() + 0.1) + un(Unary::Abs, y.clone() - z.clone()),
            bi(Binary::Pow, x.clone() + 2.0, Expr::constant(1.5)) - bi(Binary::Atan2, y.clone(), x.clone() + 2.0),
            bi(Binary::Max, x.clone(), bi(Binary::Min, y.clone(), z.clone() * 2.0)) + un(Unary::Tan, z.clone()),
            Expr::select(x.clone() - y.clone(), x.clone() * z.clone(), bi(Binary::Hypot, y.clone(), z.clone() + 1.0)),
            un(Unary::Tanh, x.clone() * 4.0)
                + un(Unary::Sinh, y.clone() * 2.0) * un(Unary::Cosh, z.clone() - x.clone()),
            un(Unary::Asin, x.clone() * 0.5) - un(Unary::Acos, y.clone() * z.clone() * 0.4),
            bi(Binary::Mod, x.clone() * 2.0 + y.clone(), Expr::constant(0.7)) * z.clone() + un(Unary::Sign, y.clone()),
            un(Unary::Steepened, x.clone() + y.clone()) * z.clone() - un(Unary::Steepened, z.clone()),
            un(Unary::Swing, x.clone() * 4.0 + y.clone()) * z.clone() - un(Unary::Swing, z.clone() * 7.0),
            un(Unary::Upward, x.clone() * 4.0 + y.clone()) * z.clone() - un(Unary::Downward, z.clone() * 7.0),
            un(Unary::Fold, x.clone() * 4.0 + y.clone()) * z.clone() - un(Unary::Fold, z.clone() * 7.0),
            bi(Binary::Mod, z.clone(), x.clone() + 2.5) - un(Unary::Floor, y.clone() * 3.0) * x.clone(),
            un(Unary::Log, bi(Binary::Pow, x.clone() + 2.0, y.clone() + 0.5))
                - bi(Binary::Pow, z.clone(), Expr::constant(3.0)),
            involute(&bi(Binary::Hypot, x.clone(), y.clone())) - z.clone(),
            involute(&un(Unary::Sqrt, bi(Binary::Max, x.clone(), Expr::constant(0.0)))) * involute(&(y * z)) - x,
        ];
        for _ in 0..200 {
            let mut v = |s: f64| DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * s;
            let (at, axis, radii) = (v(2.0), v(1.0).normalize(), v(1.0).abs() + 0.1);
            let solids: [Solid; 5] = [
                Solid::half_space(axis, at),
                Solid::sphere(radii.x, at),
                Solid::cylinder(radii.x, axis, at, None),
                Primitive::Cone { r0: radii.x, r1: radii.y, height: radii.z, axis, at }.into(),
                Primitive::Torus { major: radii.x, minor: radii.y, axis, at }.into(),
            ];
            let mut leaves: Vec<Leaf> = solids.iter().flat_map(|s| lower(s).unwrap().leaves).collect();
            leaves.extend(formulas.iter().map(|e| Leaf::Formula(Formula::compile(e, &Placement::IDENTITY))));
            for leaf in leaves {
                let lo = v(2.0);
                let cell = Aabb::new(lo, lo + v(0.8).abs());
                let bounds = leaf.slopes(&cell).unwrap();
                for _ in 0..30 {
                    let p = cell.lo + (cell.hi - cell.lo) * (v(1.0) + 0.5);
                    let d = leaf.gradient(p);
                    let (value, slack) = (bounds.value, 1e-12 * (1.0 + d.v.abs()));
                    assert!(
                        d.v.is_nan() || (value.lo - slack <= d.v && d.v <= value.hi + slack),
                        "{leaf:?} {cell:?} {p} {} {value:?}",
                        d.v
                    );
                    for k in 0..3 {
                        let i = bounds.gradient[k];
                        let slack = 1e-12 * (1.0 + d.g[k].abs());
                        assert!(
                            d.g[k].is_nan() || (i.lo - slack <= d.g[k] && d.g[k] <= i.hi + slack),
                            "{leaf:?} {cell:?} {p} {k} {} {i:?}",
                            d.g[k]
                        );
                    }
                }
            }
        }
    }
}
