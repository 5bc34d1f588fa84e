//! Formulas in forms that fall into fewer and smoother leaves than those they are written in.

use std::f64::consts::{FRAC_PI_2, PI};

use super::beyond::DEEPEST;
use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::{Terms, never_negative};
use super::steps::{linear, rewritten};
use crate::numeric::FEW_ROUNDINGS;

/// `|mod(a, m) - m/2|` as the absolute value of an angle, which falls into two leaves however many periods there are. Within a root of
/// squares or a square it is folded: that has no jump. Where `a` is linear its periods are planes: steps are better there. The smaller
/// and the larger of `mod(a, m)` and `m - mod(a, m)` are the same wave, and so are `asin(sin(a))` and `acos(cos(a))`.
pub(super) fn with_waves(e: &Expr) -> Expr {
    rewritten(e, |e| match e.node() {
        ExprNode::Unary(Unary::Abs, d) => wave(d),
        ExprNode::Unary(Unary::Acos, c) => match c.node() {
            ExprNode::Unary(Unary::Cos, a) => Some(triangle(a)),
            _ => None,
        },
        ExprNode::Unary(Unary::Asin, s) => match s.node() {
            ExprNode::Unary(Unary::Sin, a) => Some(Expr::constant(FRAC_PI_2) - triangle(&(a.clone() - FRAC_PI_2))),
            _ => None,
        },
        ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => {
            let (p, q) = (Saw::of(a, 0)?, Saw::of(b, 0)?);
            if !(p.of == q.of && p.period == q.period && p.slope == -q.slope) {
                return None;
            }
            let apart = Saw { slope: p.slope, shift: 0.5 * (p.shift - q.shift), ..p.clone() }.size()?;
            let middle = Expr::constant(0.5 * (p.shift + q.shift));
            Some(if *op == Binary::Min { middle - apart } else { middle + apart })
        }
        ExprNode::Binary(Binary::Hypot, a, b) => {
            let (p, q) = (folded(a), folded(b));
            let is_other = p.is_some() || q.is_some();
            let or = |f: Option<Expr>, e: &Expr| f.unwrap_or_else(|| e.clone());
            is_other.then(|| Expr::binary(Binary::Hypot, or(p, a), or(q, b)))
        }
        ExprNode::Binary(Binary::Pow, a, n) if n.as_constant().is_some_and(|n| n % 2.0 == 0.0) => {
            Some(Expr::binary(Binary::Pow, folded(a)?, n.clone()))
        }
        ExprNode::Binary(Binary::Mul, a, b) if a == b => folded(a).map(|f| f.clone() * f),
        _ => None,
    })
}

/// What has the same size, without a jump.
fn folded(d: &Expr) -> Option<Expr> {
    let waved = wave(d);
    let ExprNode::Binary(Binary::Mul, size, k) = waved.as_ref().unwrap_or(d).node() else { return None };
    let ExprNode::Unary(Unary::Abs, turns) = size.node() else { return None };
    let ExprNode::Unary(Unary::Wrap, angle) = turns.node() else { return None };
    k.as_constant().map(|k| Expr::unary(Unary::Fold, angle.clone()) * k)
}

/// The absolute value of `d`, if that is a wave.
fn wave(d: &Expr) -> Option<Expr> {
    Saw::of(d, 0)?.size()
}

/// The distance of an angle from whole turns.
fn triangle(a: &Expr) -> Expr {
    if linear(a, 0).is_some() {
        let turn = Expr::constant(2.0 * PI);
        return Expr::unary(Unary::Abs, Expr::binary(Binary::Mod, a.clone() + PI, turn) - PI);
    }
    Expr::unary(Unary::Abs, Expr::unary(Unary::Wrap, a.clone()))
}

/// What is given as `slope * mod(of, period) + shift`.
#[derive(Clone)]
struct Saw {
    of: Expr,
    period: f64,
    slope: f64,
    shift: f64,
}

impl Saw {
    /// Reads sums with numbers and products with them, around a `mod`, or around what is written `a - floor(a)`.
    fn of(e: &Expr, depth: usize) -> Option<Self> {
        if depth > DEEPEST {
            return None;
        }
        let inner = |e: &Expr| Self::of(e, depth + 1);
        let finite = |c: Option<f64>| c.filter(|c| c.is_finite());
        match e.node() {
            ExprNode::Binary(Binary::Mod, a, m) => {
                let period = finite(m.as_constant()).filter(|m| *m != 0.0)?;
                Some(Self { of: a.clone(), period, slope: 1.0, shift: 0.0 })
            }
            ExprNode::Unary(Unary::Neg, a) => Some(inner(a)?.scaled(-1.0)),
            ExprNode::Binary(Binary::Add, a, b) => match (finite(a.as_constant()), finite(b.as_constant())) {
                (_, Some(c)) => Some(inner(a)?.shifted(c)),
                (Some(c), _) => Some(inner(b)?.shifted(c)),
                _ => None,
            },
            ExprNode::Binary(Binary::Sub, a, b) => match (finite(a.as_constant()), finite(b.as_constant())) {
                (_, Some(c)) => Some(inner(a)?.shifted(-c)),
                (Some(c), _) => Some(inner(b)?.scaled(-1.0).shifted(c)),
                _ => Self::of_floor(a, b),
            },
            ExprNode::Binary(Binary::Mul, a, b) => match (finite(a.as_constant()), finite(b.as_constant())) {
                (_, Some(c)) if c != 0.0 => Some(inner(a)?.scaled(c)),
                (Some(c), _) if c != 0.0 => Some(inner(b)?.scaled(c)),
                _ => None,
            },
            ExprNode::Binary(Binary::Div, a, b) => {
                let c = finite(b.as_constant()).filter(|c| *c != 0.0)?;
                Some(inner(a)?.scaled(1.0 / c))
            }
            _ => None,
        }
    }

    /// `a - m floor((a + c) / m)`, as also `round` has it, is `mod(a + c, m) - c`.
    fn of_floor(a: &Expr, steps: &Expr) -> Option<Self> {
        let (period, counted) = match steps.node() {
            ExprNode::Unary(Unary::Floor, v) => (1.0, v),
            ExprNode::Binary(Binary::Mul, p, q) => {
                let (m, floor) = p.as_constant().map(|m| (m, q)).or(q.as_constant().map(|m| (m, p)))?;
                let ExprNode::Unary(Unary::Floor, v) = floor.node() else { return None };
                (m, v)
            }
            _ => return None,
        };
        let of = match counted.node() {
            _ if period == 1.0 => counted,
            ExprNode::Binary(Binary::Div, n, m) if m.as_constant() == Some(period) => n,
            ExprNode::Binary(Binary::Mul, n, k) if k.as_constant() == Some(1.0 / period) => n,
            _ => return None,
        };
        let c = match of.node() {
            _ if of == a => 0.0,
            ExprNode::Binary(Binary::Add, u, c) if u == a => c.as_constant()?,
            ExprNode::Binary(Binary::Sub, u, c) if u == a => -c.as_constant()?,
            _ => return None,
        };
        (period != 0.0).then(|| Self { of: of.clone(), period, slope: 1.0, shift: -c })
    }

    fn scaled(self, by: f64) -> Self {
        Self { slope: by * self.slope, shift: by * self.shift, ..self }
    }

    fn shifted(self, by: f64) -> Self {
        Self { shift: self.shift + by, ..self }
    }

    /// Its absolute value, if it is as far below zero at the beginning of a period as above at its end.
    fn size(&self) -> Option<Expr> {
        let half = 0.5 * self.slope * self.period;
        if !(half.is_finite() && (self.shift + half).abs() <= FEW_ROUNDINGS * half.abs())
            || linear(&self.of, 0).is_some()
        {
            return None;
        }
        let turns = Expr::unary(Unary::Wrap, self.of.clone() * (2.0 * PI / self.period) - PI);
        Some(Expr::unary(Unary::Abs, turns) * ((half / PI).abs()))
    }
}

/// The sign of `c - k f^n` with an even `n` is that of `(c/k)^(1/n) - |f|`: a sheet about the zeros of `f` has two sides, and
/// neither bends back where the other is near.
pub(super) fn sheet(e: &Expr) -> Option<Expr> {
    let (power, k, c) = Terms::default().power_beside_number(e)?;
    let (f, n) = match power.node() {
        ExprNode::Binary(Binary::Pow, f, n) => (f, n.as_constant()?),
        ExprNode::Binary(Binary::Mul, a, b) if a == b => (a, 2.0),
        _ => return None,
    };
    let even = n > 0.0 && n % 2.0 == 0.0;
    let level = (-c / k).powf(1.0 / n);
    let is_sheet = even && level > 0.0 && level.is_finite();
    if !is_sheet {
        return None;
    }
    let size = Expr::unary(Unary::Abs, f.clone());
    Some(if k < 0.0 { -size + level } else { size - level })
}

/// `times * base^n`, where `times` is never negative.
struct OddPower {
    base: Expr,
    /// Of the base, to tell it by.
    number: u32,
    n: f64,
    times: Option<Expr>,
}

/// A formula's factors with their exponents, where these are whole.
fn factors(e: &Expr, depth: usize, out: &mut Vec<(Expr, f64)>) -> Option<()> {
    match e.node() {
        _ if depth > DEEPEST || out.len() > DEEPEST => return None,
        ExprNode::Binary(Binary::Mul, a, b) => {
            factors(a, depth + 1, out)?;
            factors(b, depth + 1, out)?;
        }
        ExprNode::Binary(Binary::Pow, a, n) => match n.as_constant() {
            Some(n) if n > 0.0 && n.fract() == 0.0 => out.push((a.clone(), n)),
            _ => out.push((e.clone(), 1.0)),
        },
        _ => out.push((e.clone(), 1.0)),
    }
    Some(())
}

impl OddPower {
    /// A term with one factor alone that may be negative, to an odd power above 1, and the sign of the factors that are numbers.
    fn of(term: &Expr, terms: &mut Terms) -> Option<(Self, f64)> {
        let mut all = Vec::new();
        factors(term, 0, &mut all)?;
        let mut by_number: Vec<(u32, Expr, f64)> = Vec::new();
        let mut factor = 1.0;
        for (base, n) in all {
            if let Some(c) = base.as_constant() {
                factor *= c.powf(n);
                continue;
            }
            let number = terms.number(&base);
            match by_number.iter_mut().find(|f| f.0 == number) {
                Some(f) => f.2 += n,
                None => by_number.push((number, base, n)),
            }
        }
        let mut found = None;
        let mut times: Option<Expr> = None;
        for (number, base, n) in by_number {
            if n % 2.0 == 0.0 || never_negative(&base) {
                let power = Expr::binary(Binary::Pow, base, Expr::constant(n));
                times = Some(times.map_or(power.clone(), |t| t * power));
            } else if found.replace((number, base, n)).is_some() {
                return None;
            }
        }
        let (number, base, n) = found.filter(|f| f.2 > 1.0)?;
        Some((Self { base, number, n, times }, factor))
    }
}

/// The sign of `p f^n + q g^n` with an odd `n`, where `p` and `q` are never negative, is that of `p^(1/n) f + q^(1/n) g`. Where `f` and
/// `g` are both zero the powers have no slope, and nothing tells where the surface goes.
pub(super) fn odd_powers(e: &Expr) -> Option<Expr> {
    let mut terms = Terms::default();
    let mut number = 0.0;
    let mut sides: Vec<(OddPower, f64, Expr)> = Vec::new();
    for (term, factor) in terms.addends(e) {
        if let Some(c) = term.as_constant() {
            number += c * factor;
            continue;
        }
        let (power, own) = OddPower::of(&term, &mut terms)?;
        let factor = factor * own;
        let size = power.times.clone().map_or_else(|| Expr::constant(factor.abs()), |t| t * factor.abs());
        match sides.iter_mut().find(|s| s.0.number == power.number) {
            Some(s) if s.0.n == power.n && s.1 == factor.signum() => s.2 = s.2.clone() + size,
            Some(_) => return None,
            None => sides.push((power, factor.signum(), size)),
        }
    }
    let n = sides.first()?.0.n;
    let most = if number == 0.0 { 2 } else { 1 };
    if sides.len() > most || sides.iter().any(|s| s.0.n != n) {
        return None;
    }
    let root = |e: &Expr| match e.as_constant() {
        Some(c) => Expr::constant(c.powf(1.0 / n)),
        None => Expr::binary(Binary::Pow, e.clone(), Expr::constant(1.0 / n)),
    };
    // What is beside one power alone has no part in its sign, unless it is zero.
    if let [(power, ..)] = &sides[..]
        && power.times.is_some()
    {
        return None;
    }
    let mut all = sides.iter().map(|(power, sign, size)| root(size) * power.base.clone() * *sign);
    let first = all.next()?;
    let level = number.abs().powf(1.0 / n).copysign(number);
    let sum = all.fold(first, |a, b| a + b);
    Some(if number == 0.0 { sum } else { sum + level })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn other_forms_have_the_same_values_or_signs() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let (un, bi) = (Expr::unary, Expr::binary);
        let modulo = |a: Expr, m: f64| bi(Binary::Mod, a, Expr::constant(m));
        let turn = bi(Binary::Atan2, y.clone(), x.clone());
        let value = |e: &Expr, p: [f64; 3]| {
            let mut v = [0.0];
            let f = crate::implicit::formula::Formula::compile(e, &crate::implicit::solid::Placement::IDENTITY);
            f.eval(&[p[0]], &[p[1]], &[p[2]], &mut v);
            v[0]
        };
        let places = (0..343).map(|k| [k % 7, k / 7 % 7, k / 49].map(|c| 0.37 * f64::from(c) - 1.13));
        let cubic = x.clone() * y.clone() * z.clone() - x.clone() + 0.2;
        for (e, other) in [
            (un(Unary::Abs, modulo(turn.clone() * 3.0, 1.5) - 0.75), true),
            (un(Unary::Abs, modulo(turn.clone() + z.clone(), -0.8) + 0.4), true),
            (un(Unary::Abs, Expr::constant(-0.5) + modulo(turn.clone(), 1.0)), true),
            (bi(Binary::Hypot, x.clone(), modulo(turn.clone() * 3.0, 1.5) - 0.75), true),
            (bi(Binary::Hypot, un(Unary::Abs, modulo(turn.clone(), 1.0) - 0.5), z.clone()), true),
            (bi(Binary::Pow, modulo(turn.clone() - z.clone(), 0.7) - 0.35, Expr::constant(2.0)), true),
            (bi(Binary::Hypot, x.clone(), modulo(turn.clone(), 1.5) - 0.7), false),
            (bi(Binary::Min, modulo(turn.clone(), 1.5), Expr::constant(1.5) - modulo(turn.clone(), 1.5)), true),
            (bi(Binary::Max, modulo(turn.clone(), 0.6), -modulo(turn.clone(), 0.6) + 0.6), true),
            (bi(Binary::Min, modulo(turn.clone(), 1.5), Expr::constant(1.4) - modulo(turn.clone(), 1.5)), false),
            (un(Unary::Abs, modulo(turn.clone(), 1.0) * 2.0 - 1.0), true),
            (un(Unary::Abs, Expr::constant(0.5) - modulo(turn.clone(), 1.0)), true),
            (un(Unary::Abs, cubic.clone() - cubic.clone().round()), true),
            (un(Unary::Abs, (cubic.clone() - un(Unary::Floor, cubic.clone())) / 3.0 - 1.0 / 6.0), true),
            (un(Unary::Abs, turn.clone() - un(Unary::Floor, turn.clone() / 0.7) * 0.7 - 0.35), true),
            (un(Unary::Asin, un(Unary::Sin, cubic.clone() * 4.0)), true),
            (un(Unary::Acos, un(Unary::Cos, cubic.clone() * 4.0)), true),
            (un(Unary::Asin, un(Unary::Sin, x.clone() * 4.0)), true),
            (un(Unary::Abs, modulo(x.clone(), 1.0) - 0.5), false),
            (un(Unary::Abs, modulo(turn.clone(), 1.0) - 0.3), false),
        ] {
            let made = with_waves(&e);
            assert_eq!(made != e, other, "{e:?}");
            for p in places.clone() {
                assert!(abs_diff_eq!(value(&made, p), value(&e, p), epsilon = 1e-12), "{e:?} {p:?}");
            }
        }
        let power = |n: f64| bi(Binary::Pow, cubic.clone(), Expr::constant(n));
        for (e, other) in [
            (-(power(2.0) / 4.0) + 0.09, true),
            (Expr::constant(0.01) - power(4.0), true),
            (cubic.clone() * cubic.clone() * 2.0 - 0.1, true),
            (Expr::constant(0.01) - power(3.0), false),
            (-power(2.0) - 0.1, false),
            (Expr::constant(0.3) - power(2.0) - x.clone(), false),
        ] {
            let made = sheet(&e);
            assert_eq!(made.is_some(), other, "{e:?}");
            for p in places.clone() {
                let (v, w) = (value(&e, p), made.as_ref().map_or(value(&e, p), |m| value(m, p)));
                assert_eq!(v > 0.0, w > 0.0, "{e:?} {p:?}");
            }
        }
        let to = |e: &Expr, n: f64| bi(Binary::Pow, e.clone(), Expr::constant(n));
        let ball = to(&x, 2.0) + to(&y, 2.0) * 2.25 + to(&z, 2.0) - 1.0;
        let heart = to(&ball, 3.0) - to(&x, 2.0) * to(&z, 3.0) - to(&y, 2.0) * (9.0 / 80.0) * to(&z, 3.0);
        for (e, other) in [
            (-heart, true),
            (Expr::constant(0.4) - to(&cubic, 5.0) * 0.3, true),
            (to(&cubic, 3.0) + z.clone() * z.clone() * z.clone() * -2.0 * to(&x, 2.0), true),
            (to(&cubic, 3.0) - to(&z, 3.0) - to(&x, 3.0), false),
            (to(&cubic, 3.0) - to(&z, 3.0) * y.clone(), false),
            (to(&cubic, 3.0) - to(&z, 5.0), false),
            (to(&cubic, 3.0) - to(&z, 3.0) * to(&x, 2.0) + to(&z, 3.0) * to(&y, 2.0), false),
            (to(&x, 3.0) - x.clone() * to(&y, 2.0) - z.clone(), false),
            (to(&cubic, 4.0) - to(&z, 4.0), false),
        ] {
            let made = odd_powers(&e);
            assert_eq!(made.is_some(), other, "{e:?}");
            for p in places.clone() {
                let (v, w) = (value(&e, p), made.as_ref().map_or(value(&e, p), |m| value(m, p)));
                assert_eq!(v > 0.0, w > 0.0, "{e:?} {p:?}");
            }
        }
    }
}
