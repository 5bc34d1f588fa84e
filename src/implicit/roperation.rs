//! R-operations written out inside formulas: `f + g - sqrt(f**2 + g**2)` and its kin, recognized by their structure.
//!
//! A sum `p f + q g + r sqrt(a f^2 + c f g + b g^2)` is homogeneous in `(f, g)`, so where it is not negative is a wedge of the
//! plane of `f` and `g`: an intersection or a union of two half-planes through its origin (\[LIS14\]; Rvachev, Theory of
//! R-functions, 1982). For `R_alpha` the two are `f >= 0` and `g >= 0`; weighted sums give other combinations of both.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::expr::{Binary, Expr, ExprNode, Unary};
use crate::numeric::FEW_ROUNDINGS;

/// A formula is a sum of at most this many terms for an R-operation to be sought in it. The work grows with the square.
const MOST_TERMS: usize = 512;

/// The number of the term that is a constant.
const ONE: u32 = u32::MAX;

/// A sum of numbered terms with their factors, by number.
type Sum = Vec<(u32, f64)>;

/// Where a formula is not negative: where both, or one, of two others are not.
pub(super) struct Wedge {
    pub(super) and: bool,
    pub(super) sides: [Expr; 2],
}

/// Numbers for formulas that are written alike, and their sums.
#[derive(Default)]
pub(super) struct Terms {
    numbers: FxHashMap<*const ExprNode, u32>,
    known: FxHashMap<[u64; 4], u32>,
    sums: FxHashMap<u32, Sum>,
    /// A formula for each number; it keeps its node alive, so that addresses stay what they are.
    written: Vec<Expr>,
}

/// `a f^2 + c f g + b g^2`
struct Quadratic {
    f: Expr,
    g: Expr,
    a: f64,
    b: f64,
    c: f64,
}

impl Terms {
    /// The number of a formula. Formulas that differ in the order of sums and products of two alone have one number.
    pub(super) fn number(&mut self, e: &Expr) -> u32 {
        let mut stack = vec![(e, false)];
        while let Some((e, ready)) = stack.pop() {
            let at: *const ExprNode = e.node();
            if self.numbers.contains_key(&at) {
                continue;
            }
            let of = |x: &Expr| self.numbers.get(&std::ptr::from_ref(x.node())).copied().unwrap_or(0);
            let key = match e.node() {
                ExprNode::Const(c) => [0, c.to_bits(), 0, 0],
                ExprNode::Coordinate(k) => [1, u64::from(*k), 0, 0],
                node if !ready => {
                    stack.push((e, true));
                    match node {
                        ExprNode::Unary(_, a) => stack.push((a, false)),
                        ExprNode::Binary(_, a, b) => stack.extend([(b, false), (a, false)]),
                        ExprNode::Select(c, a, b) => stack.extend([(b, false), (a, false), (c, false)]),
                        ExprNode::Const(_) | ExprNode::Coordinate(_) => {}
                    }
                    continue;
                }
                ExprNode::Unary(op, a) => [2, *op as u64, u64::from(of(a)), 0],
                ExprNode::Binary(op, a, b) => {
                    let (mut x, mut y) = (of(a), of(b));
                    let either_way =
                        matches!(op, Binary::Add | Binary::Mul | Binary::Min | Binary::Max | Binary::Hypot);
                    if either_way && x > y {
                        (x, y) = (y, x);
                    }
                    [3, *op as u64, u64::from(x), u64::from(y)]
                }
                ExprNode::Select(c, a, b) => [4, u64::from(of(c)), u64::from(of(a)), u64::from(of(b))],
            };
            let written = &mut self.written;
            let number = *self.known.entry(key).or_insert_with(|| {
                written.push(e.clone());
                (written.len() - 1) as u32
            });
            self.numbers.insert(at, number);
            // Kept alive, too, where another formula of the same number came first.
            if !std::ptr::eq(self.written[number as usize].node(), at) {
                self.written.push(e.clone());
            }
        }
        self.numbers[&std::ptr::from_ref(e.node())]
    }

    /// A formula as a sum of terms that are no sums themselves.
    fn sum(&mut self, e: &Expr) -> Sum {
        let mut stack = vec![(e.clone(), false)];
        while let Some((e, ready)) = stack.pop() {
            let number = self.number(&e);
            if self.sums.contains_key(&number) {
                continue;
            }
            let parts: Vec<(Expr, f64)> = match e.node() {
                ExprNode::Unary(Unary::Neg, a) => vec![(a.clone(), -1.0)],
                ExprNode::Binary(Binary::Add, a, b) => vec![(a.clone(), 1.0), (b.clone(), 1.0)],
                ExprNode::Binary(Binary::Sub, a, b) => vec![(a.clone(), 1.0), (b.clone(), -1.0)],
                ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
                    (Some(c), _) => vec![(b.clone(), c)],
                    (_, Some(c)) => vec![(a.clone(), c)],
                    _ => Vec::new(),
                },
                ExprNode::Binary(Binary::Div, a, b) => match b.as_constant() {
                    Some(c) if c != 0.0 => vec![(a.clone(), 1.0 / c)],
                    _ => Vec::new(),
                },
                _ => Vec::new(),
            };
            if !parts.is_empty() && !ready {
                stack.push((e, true));
                stack.extend(parts.into_iter().map(|p| (p.0, false)));
                continue;
            }
            let mut sum = match e.as_constant() {
                Some(c) => vec![(ONE, c)],
                None if parts.is_empty() => vec![(number, 1.0)],
                None => Vec::new(),
            };
            for (part, factor) in parts {
                let n = self.number(&part);
                sum = plus(&sum, self.sums.get(&n).map_or(&[][..], |s| s), factor);
            }
            self.sums.insert(number, sum);
        }
        let number = self.number(e);
        self.sums.get(&number).cloned().unwrap_or_default()
    }

    /// Where `e >= 0`, or `e <= 0` if `negative`, if that is a wedge of two formulas.
    pub(super) fn wedge(&mut self, e: &Expr, negative: bool) -> Option<Wedge> {
        let sum = self.sum(e);
        if sum.len() > MOST_TERMS {
            return None;
        }
        // What is outermost was written last.
        for (root, r) in sum.iter().rev().copied() {
            let Some(q) = self.quadratic(root) else { continue };
            let mut rest = sum.clone();
            rest.retain(|t| t.0 != root);
            let (f, g) = (self.sum(&q.f), self.sum(&q.g));
            let Some([p, s]) = combination(&rest, &f, &g) else { continue };
            let sign = if negative { -1.0 } else { 1.0 };
            let homogeneous = Homogeneous { p: sign * p, q: sign * s, r: sign * r, under: [q.a, q.c, q.b] };
            if let Some((and, rows)) = homogeneous.wedge() {
                let side = |[x, y]: [f64; 2]| match (x, y) {
                    (x, 0.0) => times(&q.f, x),
                    (0.0, y) => times(&q.g, y),
                    (x, y) => times(&q.f, x) + times(&q.g, y),
                };
                return Some(Wedge { and, sides: rows.map(side) });
            }
        }
        None
    }

    /// Something, its factor and a number, if the formula is the sum of these two.
    pub(super) fn power_beside_number(&mut self, e: &Expr) -> Option<(Expr, f64, f64)> {
        let [(n, k), (ONE, c)] = self.sum(e)[..] else { return None };
        (n != ONE && k != 0.0).then_some((self.written.get(n as usize)?.clone(), k, c))
    }

    /// What a formula is the sum of, each with its factor; a number is a multiple of 1.
    pub(super) fn addends(&mut self, e: &Expr) -> Vec<(Expr, f64)> {
        let sum = self.sum(e);
        let of = |(n, k): (u32, f64)| (self.written.get(n as usize).cloned().unwrap_or_else(|| Expr::constant(1.0)), k);
        sum.into_iter().map(of).collect()
    }

    /// For `c + r sqrt(u)` with numbers c and r: a formula and the sign it must have for that to be not negative, or not positive
    /// if `negative`. A number in place of the formula tells that it always is, or never.
    pub(super) fn root_beside_number(&mut self, e: &Expr, negative: bool) -> Option<(Expr, f64)> {
        let sum = self.sum(e);
        let (root, r, c) = match sum[..] {
            [(root, r)] if root != ONE => (root, r, 0.0),
            [(root, r), (ONE, c)] => (root, r, c),
            _ => return None,
        };
        let u = match self.written.get(root as usize)?.node() {
            ExprNode::Unary(Unary::Sqrt, u) => u.clone(),
            ExprNode::Binary(Binary::Pow, u, half) if half.as_constant() == Some(0.5) => u.clone(),
            _ => return None,
        };
        let sign = if negative { -1.0 } else { 1.0 };
        let (r, c) = (sign * r, sign * c);
        Some(match (r > 0.0, c >= 0.0) {
            (true, true) => (Expr::constant(1.0), 1.0),
            (false, false) => (Expr::constant(-1.0), 1.0),
            (up, _) => (u - (c / r) * (c / r), if up { 1.0 } else { -1.0 }),
        })
    }

    /// What a root is taken of, if that is a quadratic form of two formulas.
    fn quadratic(&mut self, root: u32) -> Option<Quadratic> {
        if root == ONE {
            return None;
        }
        let e = self.written.get(root as usize)?.clone();
        let under = match e.node() {
            ExprNode::Unary(Unary::Sqrt, a) => a,
            ExprNode::Binary(Binary::Pow, a, half) if half.as_constant() == Some(0.5) => a,
            ExprNode::Binary(Binary::Hypot, f, g) => {
                return Some(Quadratic { f: f.clone(), g: g.clone(), a: 1.0, b: 1.0, c: 0.0 });
            }
            _ => return None,
        };
        let mut squares: Vec<(Expr, Sum, f64)> = Vec::new();
        let mut products = Vec::new();
        for (n, factor) in self.sum(under) {
            if n == ONE || squares.len() + products.len() > 4 {
                return None;
            }
            let e = self.written.get(n as usize)?.clone();
            let (x, y, k) = self.product(&e)?;
            if self.number(&x) == self.number(&y) {
                let sum = self.sum(&x);
                match squares.iter_mut().find_map(|s| Some((ratio(&sum, &s.1)?, &mut s.2))) {
                    Some((times, of)) => *of += factor * k * times * times,
                    None => squares.push((x, sum, factor * k)),
                }
            } else {
                products.push((x, y, factor * k));
            }
        }
        let [(f, fs, a), (g, gs, b)] = <[_; 2]>::try_from(squares).ok()?;
        let mut c = 0.0;
        for (x, y, k) in products {
            let (x, y) = (self.sum(&x), self.sum(&y));
            let way = |x: &Sum, y: &Sum| Some(ratio(x, &fs)? * ratio(y, &gs)?);
            c += k * way(&x, &y).or_else(|| way(&y, &x))?;
        }
        Some(Quadratic { f, g, a, b, c })
    }

    /// A term as a number times two formulas.
    fn product(&self, e: &Expr) -> Option<(Expr, Expr, f64)> {
        let (e, k) = stripped(e);
        let (a, b) = match e.node() {
            ExprNode::Binary(Binary::Mul, a, b) => (a, b),
            ExprNode::Binary(Binary::Pow, a, two) if two.as_constant() == Some(2.0) => (a, a),
            _ => return None,
        };
        let ((a, s), (b, t)) = (stripped(a), stripped(b));
        Some((a.clone(), b.clone(), k * s * t))
    }
}

/// A formula without its constant factors, and these.
fn stripped(mut e: &Expr) -> (&Expr, f64) {
    let mut factor = 1.0;
    loop {
        e = match e.node() {
            ExprNode::Unary(Unary::Neg, a) => {
                factor = -factor;
                a
            }
            ExprNode::Binary(Binary::Mul, a, b) => match (a.as_constant(), b.as_constant()) {
                (Some(c), _) => {
                    factor *= c;
                    b
                }
                (_, Some(c)) => {
                    factor *= c;
                    a
                }
                _ => return (e, factor),
            },
            ExprNode::Binary(Binary::Div, a, b) => match b.as_constant() {
                Some(c) if c != 0.0 => {
                    factor /= c;
                    a
                }
                _ => return (e, factor),
            },
            _ => return (e, factor),
        };
    }
}

fn times(e: &Expr, factor: f64) -> Expr {
    if factor == 1.0 { e.clone() } else { e.clone() * factor }
}

/// `a + factor b`
fn plus(a: &[(u32, f64)], b: &[(u32, f64)], factor: f64) -> Sum {
    let mut out = Sum::with_capacity(a.len() + b.len());
    let (mut i, mut k) = (0, 0);
    while i < a.len() || k < b.len() {
        let (x, y) = (a.get(i).map_or((ONE, true), |t| (t.0, false)), b.get(k).map_or((ONE, true), |t| (t.0, false)));
        if x == y {
            let (s, t) = (a[i].1, factor * b[k].1);
            // Coefficients that cancel to this share of what they are made of are zero.
            if (s + t).abs() > FEW_ROUNDINGS * s.abs().max(t.abs()) {
                out.push((a[i].0, s + t));
            }
            (i, k) = (i + 1, k + 1);
        } else if x < y {
            out.push(a[i]);
            i += 1;
        } else {
            out.push((b[k].0, factor * b[k].1));
            k += 1;
        }
    }
    out
}

/// `a / b`, if that is a number.
fn ratio(a: &Sum, b: &Sum) -> Option<f64> {
    let (first, lead) = (a.first()?, b.first()?);
    let k = first.1 / lead.1;
    let same = |(s, t): (&(u32, f64), &(u32, f64))| s.0 == t.0 && (s.1 - k * t.1).abs() <= FEW_ROUNDINGS * s.1.abs();
    (a.len() == b.len() && a.iter().zip(b).all(same)).then_some(k)
}

/// `[p, q]` with `sum = p f + q g`.
fn combination(sum: &Sum, f: &Sum, g: &Sum) -> Option<[f64; 2]> {
    let at = |s: &Sum, n: u32| s.binary_search_by_key(&n, |t| t.0).map_or(0.0, |i| s[i].1);
    // The two terms that tell the two apart best.
    let mut best = (0.0, 0, 0);
    let terms: Vec<u32> = plus(f, g, std::f64::consts::PI).iter().map(|t| t.0).collect();
    for (i, m) in terms.iter().enumerate() {
        for n in &terms[i + 1..] {
            let size = |s: &Sum| at(s, *m).abs().max(at(s, *n).abs());
            let (det, scale) = (at(f, *m) * at(g, *n) - at(f, *n) * at(g, *m), size(f) * size(g));
            if scale > 0.0 && det.abs() / scale > best.0 {
                best = (det.abs() / scale, *m, *n);
            }
            if best.0 >= 0.5 {
                break;
            }
        }
    }
    let (found, m, n) = best;
    if found <= FEW_ROUNDINGS {
        return None;
    }
    let det = at(f, m) * at(g, n) - at(f, n) * at(g, m);
    let p = (at(sum, m) * at(g, n) - at(sum, n) * at(g, m)) / det;
    let q = (at(f, m) * at(sum, n) - at(f, n) * at(sum, m)) / det;
    let round = |v: f64, other: f64| if v.abs() <= FEW_ROUNDINGS * other.abs() { 0.0 } else { v };
    let (p, q) = (round(p, q), round(q, p));
    let small = |n: u32| {
        let parts = [at(sum, n), p * at(f, n), q * at(g, n)];
        let size = parts.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        (parts[0] - parts[1] - parts[2]).abs() <= FEW_ROUNDINGS * size
    };
    let all = sum.iter().chain(f).chain(g).all(|t| small(t.0));
    all.then_some([p, q])
}

/// `p x + q y + r sqrt(under . (x^2, x y, y^2))`
struct Homogeneous {
    p: f64,
    q: f64,
    r: f64,
    under: [f64; 3],
}

impl Homogeneous {
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.p * x
            + self.q * y
            + self.r * (self.under[0] * x * x + self.under[1] * x * y + self.under[2] * y * y).sqrt()
    }

    /// Where it is not negative: whether both or one of two half-planes, and the rows `[x, y]` of these.
    fn wedge(&self) -> Option<(bool, [[f64; 2]; 2])> {
        let [a, c, b] = self.under;
        // The root must be there everywhere, and not be the absolute value of one combination.
        if !(a > 0.0 && b > 0.0 && 4.0 * a * b - c * c > FEW_ROUNDINGS * (a * b + c * c)) {
            return None;
        }
        let cancel = |x: f64, y: f64| if (x - y).abs() <= FEW_ROUNDINGS * x.abs().max(y.abs()) { 0.0 } else { x - y };
        let r2 = self.r * self.r;
        let square = cancel(self.p * self.p, r2 * a);
        let (mixed, other) = (2.0 * self.p * self.q - r2 * c, cancel(self.q * self.q, r2 * b));
        // Lines through the origin on which the square of the sum is the square of the root.
        let root = (mixed * mixed - 4.0 * square * other).sqrt();
        if !(root > FEW_ROUNDINGS * mixed.abs()) {
            return None;
        }
        let half = -0.5 * (mixed + root.copysign(mixed));
        let lines = [[half, square], [other, half]];
        let size = self.p.abs() + self.q.abs() + self.r.abs() * (a + b).sqrt();
        let mut rays: Vec<[f64; 2]> = Vec::new();
        for [x, y] in lines {
            let n = x.hypot(y);
            if !(n > 0.0) {
                return None;
            }
            for s in [1.0 / n, -1.0 / n] {
                // Squaring adds the rays on which the sum is minus the root: there the value is twice the root.
                let ray = [s * x, s * y];
                if self.at(ray).abs() <= 1e-9 * size {
                    rays.push(ray);
                }
            }
        }
        let [u, v] = <[_; 2]>::try_from(rays).ok()?;
        let cross = u[0] * v[1] - u[1] * v[0];
        if cross.abs() <= FEW_ROUNDINGS {
            return None;
        }
        let between = self.at([u[0] + v[0], u[1] + v[1]]);
        let beyond = self.at([-u[0] - v[0], -u[1] - v[1]]);
        if between == 0.0 || (between > 0.0) == (beyond > 0.0) {
            return None;
        }
        // A half-plane bounded by a ray holds the other ray if inside is between them, and does not otherwise.
        let side = |ray: [f64; 2], toward: [f64; 2]| {
            let row = [-ray[1], ray[0]];
            let largest = row[0].abs().max(row[1].abs());
            let sign = (row[0] * toward[0] + row[1] * toward[1]).signum() * between.signum();
            row.map(|v| if v == 0.0 { 0.0 } else { sign * v / largest })
        };
        Some((between > 0.0, [side(u, v), side(v, u)]))
    }
}

/// Whether a formula is nowhere negative, as far as its structure tells.
pub(super) fn never_negative(e: &Expr) -> bool {
    // Few steps: what is deeper is not known.
    fn at(e: &Expr, depth: usize) -> bool {
        if depth == 0 {
            return false;
        }
        let below = |e: &Expr| at(e, depth - 1);
        let even = |n: f64| n > 0.0 && n % 2.0 == 0.0;
        match e.node() {
            ExprNode::Const(c) => *c >= 0.0,
            ExprNode::Unary(Unary::Abs | Unary::Sqrt | Unary::Exp | Unary::Cosh | Unary::Acos, _)
            | ExprNode::Binary(Binary::Hypot, ..) => true,
            ExprNode::Binary(Binary::Mod, _, b) => b.as_constant().is_some_and(|b| b > 0.0),
            ExprNode::Binary(Binary::Pow, a, n) => n.as_constant().is_some_and(even) || below(a),
            ExprNode::Binary(Binary::Mul, a, b) if Arc::ptr_eq(&a.0, &b.0) => true,
            // Graphs of nodes have coordinates of their own at each place.
            ExprNode::Binary(Binary::Mul, a, b) if matches!((a.node(), b.node()), (ExprNode::Coordinate(p), ExprNode::Coordinate(q)) if p == q) => {
                true
            }
            ExprNode::Binary(Binary::Add | Binary::Mul | Binary::Div | Binary::Min, a, b) => below(a) && below(b),
            ExprNode::Binary(Binary::Max, a, b) => below(a) || below(b),
            _ => false,
        }
    }
    at(e, 12)
}
