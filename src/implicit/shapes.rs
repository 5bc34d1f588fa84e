//! Formulas and small geometry that lowering needs.

use glam::DVec3;

use super::expr::{Binary, Expr, Unary};
use super::solid::Tpms;
use crate::spatial::Aabb;

/// The same line or plane with one orientation: the largest component is positive. Tells whether it was turned round.
pub(super) fn canonical(n: DVec3) -> (DVec3, bool) {
    let m = n.abs();
    let lead = if m.x >= m.y && m.x >= m.z {
        n.x
    } else if m.y >= m.z {
        n.y
    } else {
        n.z
    };
    if lead < 0.0 { (-n + DVec3::ZERO, true) } else { (n + DVec3::ZERO, false) }
}

/// Components that are only rounding become zero, so that turned axis-parallel things are axis-parallel again.
pub(super) fn clean(n: DVec3) -> DVec3 {
    let dropped = DVec3::select(n.abs().cmplt(DVec3::splat(2.0 * f64::EPSILON)), DVec3::ZERO, n);
    for i in 0..3 {
        if (n[i].abs() - 1.0).abs() < 4.0 * f64::EPSILON && dropped.abs().element_sum() == dropped[i].abs() {
            return DVec3::AXES[i] * n[i].signum();
        }
    }
    dropped
}

/// The box around a disk.
pub(super) fn disk_bounds(c: DVec3, a: DVec3, r: f64) -> Aabb {
    let half = (DVec3::ONE - a * a).max(DVec3::ZERO).map(f64::sqrt) * r;
    Aabb::new(c - half, c + half)
}

/// A function by another that is positive, and the function itself.
pub(super) struct Scaled {
    pub(super) value: Expr,
    pub(super) sign: Expr,
}

/// `w / sqrt(w^2 / m^2 + |grad w|^2)` with `w = 1 - sum (x_i / a_i)^2`: Rvachev's normalization, gradient 1 on the surface.
pub(super) fn ellipsoid(radii: DVec3, at: DVec3) -> Scaled {
    let square = |e: Expr| Expr::binary(Binary::Pow, e, Expr::constant(2.0));
    let q: [Expr; 3] = std::array::from_fn(|i| [Expr::x(), Expr::y(), Expr::z()][i].clone() - at[i]);
    let sum = |f: &dyn Fn(usize) -> Expr| f(0) + f(1) + f(2);
    let w = Expr::constant(1.0) - sum(&|i| square(q[i].clone() / radii[i]));
    let slope = sum(&|i| square(q[i].clone() * (2.0 / (radii[i] * radii[i]))));
    let m = radii.min_element();
    Scaled { value: w.clone() / Expr::unary(Unary::Sqrt, square(w.clone() / m) + slope), sign: w }
}

/// g(2 pi (p - at) / period) period / 2 pi
pub(super) fn tpms(kind: Tpms, period: f64, at: DVec3) -> Expr {
    let k = std::f64::consts::TAU / period;
    let angle: [Expr; 3] = std::array::from_fn(|i| ([Expr::x(), Expr::y(), Expr::z()][i].clone() - at[i]) * k);
    let s = |i: usize| Expr::unary(Unary::Sin, angle[i].clone());
    let c = |i: usize| Expr::unary(Unary::Cos, angle[i].clone());
    let g = match kind {
        Tpms::Gyroid => s(0) * c(1) + s(1) * c(2) + s(2) * c(0),
        Tpms::SchwarzP => c(0) + c(1) + c(2),
        Tpms::Diamond => s(0) * s(1) * s(2) + s(0) * c(1) * c(2) + c(0) * s(1) * c(2) + c(0) * c(1) * s(2),
    };
    g * (1.0 / k)
}
