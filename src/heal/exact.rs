//! Points known exactly: intersections of lines and planes through nodes, in homogeneous integers.

use std::cmp::Ordering;

use glam::DVec3;
use num_bigint::BigInt;
use num_integer::Integer;
use num_traits::{One, Signed, ToPrimitive, Zero};
use rustc_hash::FxHashMap;

use crate::numeric::predicates::orient2d;

/// A point `(x, y, z) / w` on the integer grid of some [`ExactPoints`], `w > 0`, without common divisor.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Exact([BigInt; 4]);

/// Points by number: first the nodes of a mesh, then what was constructed; equal points have one number.
#[derive(Debug)]
pub(super) struct ExactPoints {
    /// Nearest doubles.
    pub(super) near: Vec<DVec3>,
    exact: Vec<Option<Exact>>,
    numbers: FxHashMap<Exact, u32>,
    nodes: usize,
    /// The grid's step is 2 to this power.
    step: i32,
}

fn sign(x: f64) -> Ordering {
    x.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// The smallest power of two of which all coordinates are multiples.
fn step_of(nodes: &[DVec3]) -> i32 {
    let low = |x: f64| {
        if x == 0.0 {
            return i32::MAX;
        }
        let bits = x.to_bits();
        let raw = ((bits >> 52) & 0x7ff) as i32;
        let mantissa = if raw == 0 { bits & ((1 << 52) - 1) } else { (bits & ((1 << 52) - 1)) | 1 << 52 };
        raw.max(1) - 1075 + mantissa.trailing_zeros() as i32
    };
    nodes.iter().flat_map(|p| p.to_array()).map(low).min().filter(|s| *s != i32::MAX).unwrap_or(0)
}

fn whole(x: f64, step: i32) -> BigInt {
    if x == 0.0 {
        return BigInt::zero();
    }
    let bits = x.to_bits();
    let raw = ((bits >> 52) & 0x7ff) as i32;
    let mantissa = if raw == 0 { bits & ((1 << 52) - 1) } else { (bits & ((1 << 52) - 1)) | 1 << 52 };
    let shift = raw.max(1) - 1075 - step;
    let m =
        if shift >= 0 { BigInt::from(mantissa) << shift as usize } else { BigInt::from(mantissa) >> (-shift) as usize };
    if x < 0.0 { -m } else { m }
}

/// The double nearest to `num / den * 2^step`, but for the last place.
fn double(num: &BigInt, den: &BigInt, step: i32) -> f64 {
    if num.is_zero() {
        return 0.0;
    }
    let shift = 66 - (num.bits() as i64 - den.bits() as i64);
    let q = if shift >= 0 { (num.abs() << shift as usize) / den } else { num.abs() / (den << (-shift) as usize) };
    // in two steps: a single power of two may be beyond the range
    let e = i64::from(step) - shift;
    let half = (e / 2) as i32;
    let x = q.to_f64().unwrap_or(0.0) * 2f64.powi(half) * 2f64.powi((e - i64::from(half)) as i32);
    if num.is_negative() { -x } else { x }
}

impl ExactPoints {
    pub(super) fn new(nodes: &[DVec3]) -> Self {
        Self {
            near: nodes.to_vec(),
            exact: vec![None; nodes.len()],
            numbers: FxHashMap::default(),
            nodes: nodes.len(),
            step: step_of(nodes),
        }
    }

    /// Makes the exact coordinates of point `v` known, and with them its number to constructions.
    pub(super) fn know(&mut self, v: u32) {
        if self.exact[v as usize].is_none() {
            let [x, y, z] = self.near[v as usize].to_array().map(|x| whole(x, self.step));
            let e = Exact([x, y, z, BigInt::one()]);
            self.numbers.entry(e.clone()).or_insert(v);
            self.exact[v as usize] = Some(e);
        }
    }

    /// Exact coordinates; [`know`](Self::know) must have been called for nodes.
    fn get(&self, v: u32) -> &[BigInt; 4] {
        match &self.exact[v as usize] {
            Some(e) => &e.0,
            None => unreachable!("points are made known before they are asked for"),
        }
    }

    fn number(&mut self, [mut x, mut y, mut z, mut w]: [BigInt; 4]) -> u32 {
        let g = x.gcd(&y).gcd(&z).gcd(&w);
        if !g.is_one() {
            (x, y, z, w) = (x / &g, y / &g, z / &g, w / &g);
        }
        if w.is_negative() {
            (x, y, z, w) = (-x, -y, -z, -w);
        }
        let e = Exact([x, y, z, w]);
        if let Some(&v) = self.numbers.get(&e) {
            return v;
        }
        let v = self.near.len() as u32;
        let w = &e.0[3];
        self.near.push(DVec3::new(
            double(&e.0[0], w, self.step),
            double(&e.0[1], w, self.step),
            double(&e.0[2], w, self.step),
        ));
        self.numbers.insert(e.clone(), v);
        self.exact.push(Some(e));
        v
    }

    /// `p + s / (s - t) (q - p)` for values `s` at `p` and `t` at `q` of a function that is linear along the line and given
    /// with the weights of the points.
    fn between(&mut self, p: u32, q: u32, s: &BigInt, t: &BigInt) -> u32 {
        let (a, b) = (self.get(p), self.get(q));
        // homogeneous: value s belongs to a / w_a; the zero is at t' a - s' b with values scaled to the points' weights
        let at: [BigInt; 4] = std::array::from_fn(|i| &a[i] * t - &b[i] * s);
        self.number(at)
    }

    /// Where the line `p q` meets the plane `a b c`, all nodes; it must.
    pub(super) fn line_plane(&mut self, p: u32, q: u32, [a, b, c]: [u32; 3]) -> u32 {
        let side = |x: u32| {
            let d = |u: u32| -> [BigInt; 3] { std::array::from_fn(|i| &self.get(u)[i] - &self.get(x)[i]) };
            let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (d(a), d(b), d(c));
            ax * (&by * &cz - &bz * &cy) + ay * (&bz * &cx - &bx * &cz) + az * (bx * cy - by * cx)
        };
        let (s, t) = (side(p), side(q));
        self.between(p, q, &s, &t)
    }

    /// Where the lines `p q` and `a b` of one plane meet, seen along `axis`; they must.
    pub(super) fn line_line(&mut self, [p, q]: [u32; 2], [a, b]: [u32; 2], axis: usize) -> u32 {
        let (s, t) = (self.turn(a, b, p, axis), self.turn(a, b, q, axis));
        self.between(p, q, &s, &t)
    }

    /// The determinant of three homogeneous points seen along `axis`: its sign is that of [`orient2d`].
    fn turn(&self, a: u32, b: u32, c: u32, axis: usize) -> BigInt {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let [a, b, c] = [a, b, c].map(|v| self.get(v));
        &a[i] * (&b[j] * &c[3] - &b[3] * &c[j]) - &a[j] * (&b[i] * &c[3] - &b[3] * &c[i])
            + &a[3] * (&b[i] * &c[j] - &b[j] * &c[i])
    }

    /// A point seen along an axis.
    pub(super) fn flat(&self, v: u32, axis: usize) -> glam::DVec2 {
        let p = self.near[v as usize].to_array();
        glam::DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3])
    }

    /// Compares one coordinate of two points, exactly.
    pub(super) fn compare(&self, a: u32, b: u32, i: usize) -> Ordering {
        if a == b {
            return Ordering::Equal;
        }
        let (x, y) = (self.near[a as usize][i], self.near[b as usize][i]);
        if (x - y).abs() > 8.0 * f64::EPSILON * x.abs().max(y.abs())
            || (a as usize) < self.nodes && (b as usize) < self.nodes
        {
            return sign(x - y);
        }
        let (p, q) = (self.get(a), self.get(b));
        (&p[i] * &q[3]).cmp(&(&q[i] * &p[3]))
    }

    /// Which way `a b c` turn seen along `axis`, exactly: `Greater` is counter-clockwise.
    pub(super) fn orient(&self, a: u32, b: u32, c: u32, axis: usize) -> Ordering {
        if a == b || b == c || a == c {
            return Ordering::Equal;
        }
        let [p, q, r] = [a, b, c].map(|v| self.flat(v, axis));
        if [a, b, c].iter().all(|v| (*v as usize) < self.nodes) {
            return sign(orient2d(p, q, r));
        }
        let (u, v) = (p - r, q - r);
        let (l, m) = (u.x * v.y, u.y * v.x);
        // coordinates are right to two units in the last place
        let off = 4.0 * f64::EPSILON * p.abs().max(q.abs()).max(r.abs()).max_element();
        let slack = 8.0 * f64::EPSILON * (l.abs() + m.abs())
            + 2.0 * off * (u.abs().element_sum() + v.abs().element_sum() + off);
        if (l - m).abs() > slack {
            return sign(l - m);
        }
        let d = self.turn(a, b, c, axis);
        d.cmp(&BigInt::zero())
    }

    /// Whether `d` lies inside the circle through `a b c`, which turn counter-clockwise seen along `axis`; exactly.
    pub(super) fn in_circle(&self, [a, b, c, d]: [u32; 4], axis: usize) -> Ordering {
        let [p, q, r, s] = [a, b, c, d].map(|v| self.flat(v, axis));
        let x = |v: glam::DVec2| robust::Coord { x: v.x, y: v.y };
        if [a, b, c, d].iter().all(|v| (*v as usize) < self.nodes) {
            return sign(robust::incircle(x(p), x(q), x(r), x(s)));
        }
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        // rows (x w, y w, x^2 + y^2, w^2)
        let row = |v: u32| {
            let e = self.get(v);
            let (x, y, w) = (&e[i], &e[j], &e[3]);
            [x * w, y * w, x * x + y * y, w * w]
        };
        let [p, q, r, s] = [a, b, c, d].map(row);
        let three = |u: &[BigInt; 4], v: &[BigInt; 4], w: &[BigInt; 4]| {
            &u[0] * (&v[1] * &w[2] - &v[2] * &w[1]) - &u[1] * (&v[0] * &w[2] - &v[2] * &w[0])
                + &u[2] * (&v[0] * &w[1] - &v[1] * &w[0])
        };
        let det = &s[3] * three(&p, &q, &r) - &r[3] * three(&p, &q, &s) + &q[3] * three(&p, &r, &s)
            - &p[3] * three(&q, &r, &s);
        det.cmp(&BigInt::zero())
    }
}
