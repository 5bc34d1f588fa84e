//! Signed leaves: the surfaces a tree is made of, in canonical form, so that a surface and its complement are one leaf with
//! a sign and an exact zero is the same zero wherever it is met.

use std::sync::Arc;

use glam::DVec3;

use super::blend::Blend;
use super::closed;
use super::field::Field;
use super::fillet::Fillet;
use super::formula::Formula;
use super::lockstep;
use super::solid::Placement;
use crate::numeric::{Dual, Interval};
use crate::spatial::Aabb;

/// A surface as the zero set of a function, positive on one side, with gradient of length 1 on the surface (formulas and
/// fields excepted: they are what the user wrote).
#[derive(Debug, Clone)]
pub(crate) enum Leaf {
    /// `d - n . p`
    Plane { n: DVec3, d: f64 },
    /// `(r^2 - |p - c|^2) / 2r`
    Sphere { c: DVec3, r: f64 },
    /// `(r^2 - rho^2) / 2r`, `rho` the distance from the axis through `c` with orthonormal frame `u v a`
    Cylinder { c: DVec3, frame: Frame, r: f64 },
    /// `d - k rho - m t` with `k^2 + m^2 = 1`, `t` the height above `c`
    Cone { c: DVec3, frame: Frame, k: f64, m: f64, d: f64 },
    /// `(r^2 - (rho - R)^2 - t^2) / 2r`
    Torus { c: DVec3, frame: Frame, major: f64, minor: f64 },
    /// What the user wrote.
    Formula(Formula),
    /// What the program brought, in its own frame.
    Field(Arc<dyn Field>, Placement),
    /// A smooth union of two subtrees.
    Blend(Arc<Blend>),
    /// What such a union has between two leaves.
    Fillet(Arc<Fillet>),
}

/// A right-handed orthonormal frame; `a` is the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) u: DVec3,
    pub(crate) v: DVec3,
    pub(crate) a: DVec3,
}

impl Frame {
    /// The frame around a unit axis. Exact for the coordinate axes.
    pub(crate) fn about(a: DVec3) -> Self {
        let (x, y, z) = (a.x.abs(), a.y.abs(), a.z.abs());
        let helper = if z >= x && z >= y {
            DVec3::X
        } else if x >= y {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let u = (helper - a * a.dot(helper)).normalize();
        Frame { u, v: a.cross(u), a }
    }
}

/// A zero of a leaf counts as this much inside: the coherent perturbation that gives hidden and coincident faces one sign.
const COHERENT: f64 = f64::MIN_POSITIVE;

/// Relative widening of closed-form ranges: covers the rounding of at most 16 operations.
const RANGE_SLACK: f64 = 16.0 * f64::EPSILON;

/// Range of a linear form `n . (p - c)` over a box.
fn linear(n: DVec3, c: DVec3, b: &[Interval; 3]) -> Interval {
    let term = |k: usize| (b[k] - Interval::point(c[k])).scale(n[k]);
    term(0) + term(1) + term(2)
}

#[inline(always)]
fn plane(n: &DVec3, d: f64, p: DVec3) -> f64 {
    d - (n.x * p.x + n.y * p.y + n.z * p.z)
}

#[inline(always)]
fn sphere(c: &DVec3, r: f64, p: DVec3) -> f64 {
    let q = p - *c;
    (r * r - (q.x * q.x + q.y * q.y + q.z * q.z)) * (0.5 / r)
}

/// Coordinates in a frame at `c`.
#[inline(always)]
fn local(c: &DVec3, f: &Frame, p: DVec3) -> [f64; 3] {
    let q = p - *c;
    [f.u, f.v, f.a].map(|e| e.x * q.x + e.y * q.y + e.z * q.z)
}

#[inline(always)]
fn cylinder(c: &DVec3, frame: &Frame, r: f64, p: DVec3) -> f64 {
    let [a, b, _] = local(c, frame, p);
    (r * r - (a * a + b * b)) * (0.5 / r)
}

#[inline(always)]
fn cone(c: &DVec3, frame: &Frame, [k, m, d]: [f64; 3], p: DVec3) -> f64 {
    let [a, b, t] = local(c, frame, p);
    d - k * (a * a + b * b).sqrt() - m * t
}

#[inline(always)]
fn torus(c: &DVec3, frame: &Frame, [major, minor]: [f64; 2], p: DVec3) -> f64 {
    let [a, b, t] = local(c, frame, p);
    let q = (a * a + b * b).sqrt() - major;
    (minor * minor - (q * q + t * t)) * (0.5 / minor)
}

/// A value with its sign changed or not, never zero.
#[inline(always)]
fn coherent(sign: f64, v: f64) -> f64 {
    if v == 0.0 { sign * COHERENT } else { sign * v }
}

/// Values of a function at many points.
#[inline(always)]
fn each(xs: &[f64], ys: &[f64], zs: &[f64], out: &mut [f64], f: impl Fn(DVec3) -> f64) {
    for i in 0..out.len() {
        out[i] = f(DVec3::new(xs[i], ys[i], zs[i]));
    }
}

fn slack(i: Interval, magnitude: f64) -> Interval {
    let e = RANGE_SLACK * magnitude;
    if e.is_finite() { Interval::new(i.lo - e, i.hi + e) } else { i }
}

impl Leaf {
    /// Whether values may be NaN or infinite.
    pub(crate) fn is_user(&self) -> bool {
        match self {
            Leaf::Fillet(f) => f.sides.iter().any(|s| s.leaf.is_user()),
            _ => matches!(self, Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_)),
        }
    }

    /// Value at one point, exact zeros included.
    pub(crate) fn value(&self, p: DVec3) -> f64 {
        match self {
            Leaf::Plane { n, d } => plane(n, *d, p),
            Leaf::Sphere { c, r } => sphere(c, *r, p),
            Leaf::Cylinder { c, frame, r } => cylinder(c, frame, *r, p),
            Leaf::Cone { c, frame, k, m, d } => cone(c, frame, [*k, *m, *d], p),
            Leaf::Torus { c, frame, major, minor } => torus(c, frame, [*major, *minor], p),
            Leaf::Fillet(f) => f.value(p),
            Leaf::Field(f, place) => lockstep::value(f, unplace(place, p)) * place.scale,
            Leaf::Formula(f) => f.value(p),
            Leaf::Blend(f) => {
                let mut out = [0.0];
                f.eval(&[p.x], &[p.y], &[p.z], &mut out);
                out[0]
            }
        }
    }

    /// Value and gradient.
    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        match self {
            Leaf::Formula(f) => f.gradient(p),
            Leaf::Blend(b) => b.gradient(p),
            Leaf::Fillet(f) => f.gradient(p),
            Leaf::Field(f, place) => {
                let (mut v, mut g) = ([f64::NAN], [DVec3::NAN]);
                lockstep::slopes(f, &[unplace(place, p)], &mut v, &mut g);
                Dual::new(v[0] * place.scale, place.turn(g[0]))
            }
            _ => Dual::new(self.value(p), self.slope(p)),
        }
    }

    /// Derivatives by x, y and z at many points, then values, bit by bit those of [`gradient`](Self::gradient).
    pub(crate) fn gradients(&self, p: [&[f64]; 3], out: [&mut [f64]; 4]) {
        if let Leaf::Formula(f) = self {
            return f.gradients(p, out);
        }
        if let Leaf::Field(..) = self {
            let points: Vec<DVec3> = (0..out[0].len()).map(|k| DVec3::new(p[0][k], p[1][k], p[2][k])).collect();
            for (k, d) in self.duals(&points).into_iter().enumerate() {
                (out[0][k], out[1][k], out[2][k], out[3][k]) = (d.g.x, d.g.y, d.g.z, d.v);
            }
            return;
        }
        let [x, y, z, v] = out;
        if closed::slopes(self, p, [&mut *x, &mut *y, &mut *z]) {
            return self.closed(p, v, |v| v);
        }
        for k in 0..v.len() {
            let d = self.gradient(DVec3::new(p[0][k], p[1][k], p[2][k]));
            (x[k], y[k], z[k], v[k]) = (d.g.x, d.g.y, d.g.z, d.v);
        }
    }

    /// [`gradient`](Self::gradient) at many points; a field is asked for all of them at once.
    pub(crate) fn duals(&self, points: &[DVec3]) -> Vec<Dual> {
        let Leaf::Field(f, place) = self else { return points.iter().map(|p| self.gradient(*p)).collect() };
        let own: Vec<DVec3> = points.iter().map(|p| unplace(place, *p)).collect();
        let (mut v, mut g) = (vec![f64::NAN; own.len()], vec![DVec3::NAN; own.len()]);
        lockstep::slopes(f, &own, &mut v, &mut g);
        v.into_iter().zip(g).map(|(v, g)| Dual::new(v * place.scale, place.turn(g))).collect()
    }

    /// Whether some of it is a function of the user's own.
    pub(crate) fn has_field(&self) -> bool {
        match self {
            Leaf::Field(..) => true,
            Leaf::Blend(b) => b.leaves.iter().any(Leaf::has_field),
            Leaf::Fillet(f) => f.sides.iter().any(|s| s.leaf.has_field()),
            _ => false,
        }
    }

    /// Whether questions had better wait for each other, so that fields are asked for many points at once.
    pub(crate) fn waits(&self) -> bool {
        match self {
            Leaf::Field(f, _) => f.in_batches(),
            Leaf::Blend(b) => b.leaves.iter().any(Leaf::waits),
            Leaf::Fillet(f) => f.sides.iter().any(|s| s.leaf.waits()),
            _ => false,
        }
    }

    /// [`gradient`](Self::gradient) of the whole surface that the leaf may be only a part of.
    pub(crate) fn smooth(&self, p: DVec3) -> Dual {
        if let Leaf::Fillet(f) = self { f.smooth(p) } else { self.gradient(p) }
    }

    /// [`value`](Self::value), but where the leaf ends, of the surface that it ends in.
    pub(crate) fn continued(&self, p: DVec3) -> f64 {
        if let Leaf::Fillet(f) = self { f.continued(p) } else { self.value(p) }
    }

    /// Whether the leaf, which is only a part of a surface, has come to no end here.
    pub(crate) fn reaches(&self, p: DVec3) -> bool {
        if let Leaf::Fillet(f) = self { f.is_between(p) } else { true }
    }

    /// Whether a point is on the leaf's surface, or what it [ends in](Self::continued), up to a distance.
    pub(crate) fn vanishes(&self, p: DVec3, within: f64) -> bool {
        self.continued(p).abs() <= within * self.slope(p).length()
    }

    /// Whether a point is on the leaf's own surface, up to a distance.
    pub(crate) fn passes(&self, p: DVec3, within: f64) -> bool {
        self.value(p).abs() <= within * self.slope(p).length()
    }

    /// The gradient of [`smooth`](Self::smooth) alone.
    pub(crate) fn slope(&self, p: DVec3) -> DVec3 {
        closed::slope(self, p).unwrap_or_else(|| self.smooth(p).g)
    }

    /// The nearest point of a surface that has one in closed form; `None` where there are many, as from an axis, and for
    /// surfaces without.
    pub(crate) fn foot(&self, p: DVec3) -> Option<DVec3> {
        let flat = |c: DVec3, f: &Frame| {
            let q = p - c;
            f.u * f.u.dot(q) + f.v * f.v.dot(q)
        };
        let q = match self {
            Leaf::Plane { n, d } => {
                let once = |p: DVec3| p + *n * ((d - n.dot(p)) / n.length_squared());
                // What rounding left the first time goes the second.
                once(once(p))
            }
            Leaf::Sphere { c, r } => c + (p - c) * (r / p.distance(*c)),
            Leaf::Cylinder { c, frame, r } => {
                let radial = flat(*c, frame);
                p + radial * (r / radial.length() - 1.0)
            }
            Leaf::Cone { c, frame, k, m, d } => {
                let radial = flat(*c, frame);
                let rho = radial.length();
                let away = d - k * rho - m * frame.a.dot(p - c);
                // Beyond the apex.
                if !(rho + k * away > 0.0) {
                    return None;
                }
                p + (radial * (k / rho) + frame.a * *m) * away
            }
            Leaf::Torus { c, frame, major, minor } => {
                let radial = flat(*c, frame);
                let rho = radial.length();
                let (x, t) = (rho - major, frame.a.dot(p - c));
                let share = minor / x.hypot(t) - 1.0;
                // Beyond the axis, where a torus meets itself.
                if !(rho + x * share > 0.0) {
                    return None;
                }
                p + (radial * (x / rho) + frame.a * t) * share
            }
            Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_) => return None,
        };
        q.is_finite().then_some(q)
    }

    /// The Hessian, by columns. Differences of the gradient where there is no closed form.
    pub(crate) fn hessian(&self, p: DVec3, scale: f64) -> [DVec3; 3] {
        match self {
            Leaf::Plane { .. } => [DVec3::ZERO; 3],
            Leaf::Sphere { r, .. } => [-DVec3::X / *r, -DVec3::Y / *r, -DVec3::Z / *r],
            Leaf::Cylinder { frame, r, .. } => {
                DVec3::AXES.map(|e| -(frame.u * frame.u.dot(e) + frame.v * frame.v.dot(e)) / *r)
            }
            _ => {
                // the cube root of the rounding unit balances truncation against rounding
                let h = scale * f64::EPSILON.cbrt();
                if let Leaf::Field(..) = self {
                    let around: Vec<DVec3> = DVec3::AXES.iter().flat_map(|e| [p + *e * h, p - *e * h]).collect();
                    let d = self.duals(&around);
                    return std::array::from_fn(|k| (d[2 * k].g - d[2 * k + 1].g) / (2.0 * h));
                }
                DVec3::AXES.map(|e| (self.slope(p + e * h) - self.slope(p - e * h)) / (2.0 * h))
            }
        }
    }

    /// Values at many points.
    #[inline(always)]
    pub(crate) fn eval(&self, xs: &[f64], ys: &[f64], zs: &[f64], out: &mut [f64]) {
        let n = out.len();
        let (xs, ys, zs) = (&xs[..n], &ys[..n], &zs[..n]);
        match self {
            Leaf::Formula(f) => f.eval(xs, ys, zs, out),
            Leaf::Field(f, place) => {
                let points: Vec<DVec3> = (0..n).map(|i| unplace(place, DVec3::new(xs[i], ys[i], zs[i]))).collect();
                lockstep::values(f, &points, out);
                out.iter_mut().for_each(|v| *v *= place.scale);
            }
            Leaf::Blend(b) => b.eval(xs, ys, zs, out),
            Leaf::Fillet(f) => f.eval(xs, ys, zs, out),
            _ => self.closed([xs, ys, zs], out, |v| v),
        }
    }

    /// Values at many points after [`sign`](Self::sign); whether all that [may be infinite](Self::is_user) are finite.
    #[inline(always)]
    pub(crate) fn eval_signed(&self, p: [&[f64]; 3], negate: bool, out: &mut [f64]) -> bool {
        let s = if negate { -1.0 } else { 1.0 };
        match self {
            Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_) => {
                self.eval(p[0], p[1], p[2], out);
                let mut finite = true;
                for v in &mut *out {
                    finite &= v.is_finite();
                    *v = coherent(s, *v);
                }
                finite || !self.is_user()
            }
            _ => {
                self.closed(p, out, |v| coherent(s, v));
                true
            }
        }
    }

    /// What becomes of values at many points, if the leaf has a closed form.
    #[inline(always)]
    fn closed(&self, p: [&[f64]; 3], out: &mut [f64], then: impl Fn(f64) -> f64) {
        let n = out.len();
        let (xs, ys, zs) = (&p[0][..n], &p[1][..n], &p[2][..n]);
        match self {
            Leaf::Plane { n, d } => each(xs, ys, zs, out, |p| then(plane(n, *d, p))),
            Leaf::Sphere { c, r } => each(xs, ys, zs, out, |p| then(sphere(c, *r, p))),
            Leaf::Cylinder { c, frame, r } => each(xs, ys, zs, out, |p| then(cylinder(c, frame, *r, p))),
            Leaf::Cone { c, frame, k, m, d } => each(xs, ys, zs, out, |p| then(cone(c, frame, [*k, *m, *d], p))),
            Leaf::Torus { c, frame, major, minor } => {
                each(xs, ys, zs, out, |p| then(torus(c, frame, [*major, *minor], p)));
            }
            Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_) => {}
        }
    }

    /// What stands for the leaf in cells of about a size, if anything does: its zeros are the same.
    pub(crate) fn in_cells(&self, length: f64) -> Option<Leaf> {
        match self {
            Leaf::Fillet(_) => Some(self.banded(length)),
            Leaf::Formula(f) => f.plain().map(|f| Leaf::Formula(f.clone())),
            _ => None,
        }
    }

    /// What is to be interpolated linearly between points so far apart in place of the leaf; see [`Fillet::band`].
    pub(crate) fn banded(&self, length: f64) -> Leaf {
        if let Leaf::Fillet(f) = self { Leaf::Fillet(Arc::new(f.banded(length))) } else { self.clone() }
    }

    /// Gives exact zeros the coherent sign, then flips the complement's sign.
    #[inline(always)]
    pub(crate) fn sign(values: &mut [f64], negate: bool) {
        let s = if negate { -1.0 } else { 1.0 };
        for v in values {
            *v = coherent(s, *v);
        }
    }

    /// Bounds of the value, and of its computed value, over a box that may be infinite.
    pub(crate) fn range(&self, b: &Aabb) -> Interval {
        let box3 = b.intervals();
        let reach = b.lo.abs().max(b.hi.abs()).max_element();
        let planar = |c: &DVec3, f: &Frame| linear(f.u, *c, &box3).square() + linear(f.v, *c, &box3).square();
        match self {
            Leaf::Plane { n, d } => slack(Interval::point(*d) - linear(*n, DVec3::ZERO, &box3), 2.0 * reach + d.abs()),
            Leaf::Sphere { c, r } => {
                let q: [Interval; 3] = std::array::from_fn(|k| (box3[k] - Interval::point(c[k])).square());
                let size = reach + c.length();
                slack((Interval::point(r * r) - (q[0] + q[1] + q[2])).scale(0.5 / r), size * size / r + r)
            }
            Leaf::Cylinder { c, frame, r } => {
                let size = reach + c.length();
                slack((Interval::point(r * r) - planar(c, frame)).scale(0.5 / r), 4.0 * size * size / r + r)
            }
            Leaf::Cone { c, frame, k, m, d } => {
                let i = Interval::point(*d)
                    - planar(c, frame).max(Interval::point(0.0)).sqrt().scale(*k)
                    - linear(frame.a, *c, &box3).scale(*m);
                slack(i, 4.0 * (reach + c.length()) + d.abs())
            }
            Leaf::Torus { c, frame, major, minor } => {
                let q = (planar(c, frame).max(Interval::point(0.0)).sqrt() - Interval::point(*major)).square();
                let size = reach + c.length() + major;
                let t = linear(frame.a, *c, &box3).square();
                slack((Interval::point(minor * minor) - (q + t)).scale(0.5 / minor), 4.0 * size * size / minor + minor)
            }
            Leaf::Formula(f) => f.range(box3[0], box3[1], box3[2]),
            Leaf::Field(f, place) => {
                let cell = if b.is_finite() { Aabb::around(b.corners().map(|p| unplace(place, p))) } else { Aabb::ALL };
                let (lo, hi) = lockstep::range(f, &cell);
                Interval::new(lo, hi).scale(place.scale)
            }
            Leaf::Blend(f) => f.range(b),
            Leaf::Fillet(f) => f.range(b),
        }
    }

    /// A kind, and numbers that are equal for equal leaves.
    pub(crate) fn key(&self) -> (u8, Vec<f64>) {
        let v = |list: &[DVec3], rest: &[f64]| {
            list.iter().flat_map(|v| v.to_array()).chain(rest.iter().copied()).collect::<Vec<f64>>()
        };
        match self {
            Leaf::Plane { n, d } => (0, v(&[*n], &[*d])),
            Leaf::Sphere { c, r } => (1, v(&[*c], &[*r])),
            Leaf::Cylinder { c, frame, r } => (2, v(&[*c, frame.a], &[*r])),
            Leaf::Cone { c, frame, k, m, d } => (3, v(&[*c, frame.a], &[*k, *m, *d])),
            Leaf::Torus { c, frame, major, minor } => (4, v(&[*c, frame.a], &[*major, *minor])),
            Leaf::Formula(f) => (5, vec![f64::from_bits(f.fingerprint() >> 12)]),
            Leaf::Field(f, p) => (
                6,
                v(
                    &[p.rotation.x_axis, p.rotation.y_axis, p.shift],
                    &[p.scale, Arc::as_ptr(f).cast::<()>() as usize as f64],
                ),
            ),
            Leaf::Blend(b) => (7, vec![Arc::as_ptr(b) as usize as f64]),
            Leaf::Fillet(f) => {
                let side = |k: usize| 2.0 * f64::from(f.sides[k].number) + f64::from(u8::from(f.sides[k].negate));
                let rest = f.rest.as_ref().map_or(0.0, |f| f64::from_bits(f.fingerprint() >> 12));
                (8, vec![side(0), side(1), f.radius, f.profile.number(), rest])
            }
        }
    }

    /// Whether the other leaf is the same surface with the same parameters up to `tolerance` of their size.
    pub(crate) fn same(&self, other: &Leaf, tolerance: f64) -> bool {
        match (self, other) {
            (Leaf::Formula(a), Leaf::Formula(b)) => a == b,
            (Leaf::Field(a, p), Leaf::Field(b, q)) => Arc::ptr_eq(a, b) && p == q,
            (Leaf::Blend(a), Leaf::Blend(b)) => Arc::ptr_eq(a, b),
            (Leaf::Fillet(a), Leaf::Fillet(b)) => self.key() == other.key() && a.rest == b.rest,
            _ => {
                let ((ka, a), (kb, b)) = (self.key(), other.key());
                let size = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                ka == kb && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= tolerance * size)
            }
        }
    }
}

/// From space into a field's own frame.
pub(super) fn unplace(place: &Placement, p: DVec3) -> DVec3 {
    place.rotation.transpose() * (p - place.shift) / place.scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::lower::lower;
    use crate::implicit::{Primitive, Solid};
    use approx::abs_diff_eq;

    #[test]
    fn ranges_hold_the_values_of_random_leaves_on_random_boxes() {
        let mut state = 1u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..300 {
            let mut v = |s: f64| DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * s;
            let (at, axis, radii) = (v(2.0), v(1.0).normalize(), v(1.0).abs() + 0.1);
            let solids: [Solid; 5] = [
                Solid::half_space(axis, at),
                Solid::sphere(radii.x, at),
                Solid::cylinder(radii.x, axis, at, None),
                Primitive::Cone { r0: radii.x, r1: radii.y, height: radii.z, axis, at }.into(),
                Primitive::Torus { major: radii.x, minor: radii.y, axis, at }.into(),
            ];
            for solid in solids {
                for leaf in lower(&solid).unwrap().leaves {
                    let lo = v(2.0);
                    let cell = Aabb::new(lo, lo + v(1.0).abs());
                    let range = leaf.range(&cell);
                    for _ in 0..50 {
                        let p = cell.lo + (cell.hi - cell.lo) * (v(1.0) + 0.5);
                        let f = leaf.value(p);
                        assert!(range.lo <= f && f <= range.hi, "{leaf:?} {cell:?} {range:?} {p} {f}");
                        let mut many = [0.0; 3];
                        leaf.eval(&[p.x; 3], &[p.y; 3], &[p.z; 3], &mut many);
                        assert_eq!(many, [f; 3]);
                        let Some(q) = leaf.foot(p) else { continue };
                        let n = leaf.slope(q).normalize();
                        let (way, size) = (q - p, 1.0 + p.length() + radii.max_element());
                        assert!(abs_diff_eq!(leaf.value(q), 0.0, epsilon = 1e-13 * size), "{leaf:?} {p} {q}");
                        assert!((way - n * n.dot(way)).length() < 1e-13 * size, "{leaf:?} {p} {q}");
                        // None of the points around is nearer.
                        let (u, w) = n.any_orthonormal_pair();
                        for d in [u, -u, w, -w] {
                            if let Some(x) = leaf.foot(q + 0.1 * d) {
                                assert!(x.distance(p) > way.length() - 1e-12, "{leaf:?} {p} {q} {x}");
                            }
                        }
                    }
                }
            }
        }
    }
}
