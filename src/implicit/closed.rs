//! Gradients of leaves in closed form, at one point and at many.

use glam::DVec3;
use multiversion::multiversion;

use super::leaf::{Frame, Leaf};

#[inline(always)]
fn sphere(c: &DVec3, r: f64, p: DVec3) -> DVec3 {
    -(p - c) / r
}

/// From the axis through `c` to a point.
#[inline(always)]
fn radial(c: &DVec3, frame: &Frame, p: DVec3) -> DVec3 {
    let q = p - c;
    frame.u * frame.u.dot(q) + frame.v * frame.v.dot(q)
}

#[inline(always)]
fn cylinder(c: &DVec3, frame: &Frame, r: f64, p: DVec3) -> DVec3 {
    -radial(c, frame, p) / r
}

#[inline(always)]
fn cone(c: &DVec3, frame: &Frame, [k, m]: [f64; 2], p: DVec3) -> DVec3 {
    -radial(c, frame, p).normalize_or_zero() * k - frame.a * m
}

#[inline(always)]
fn torus(c: &DVec3, frame: &Frame, [major, minor]: [f64; 2], p: DVec3) -> DVec3 {
    let radial = radial(c, frame, p);
    let rho = radial.length();
    -(radial.normalize_or_zero() * (rho - major) + frame.a * frame.a.dot(p - c)) / minor
}

/// The gradient of a leaf, if it has a closed form.
#[inline(always)]
pub(super) fn slope(leaf: &Leaf, p: DVec3) -> Option<DVec3> {
    Some(match leaf {
        Leaf::Plane { n, .. } => -*n,
        Leaf::Sphere { c, r } => sphere(c, *r, p),
        Leaf::Cylinder { c, frame, r } => cylinder(c, frame, *r, p),
        Leaf::Cone { c, frame, k, m, .. } => cone(c, frame, [*k, *m], p),
        Leaf::Torus { c, frame, major, minor } => torus(c, frame, [*major, *minor], p),
        Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_) => return None,
    })
}

#[inline(always)]
fn each([xs, ys, zs]: [&[f64]; 3], [x, y, z]: [&mut [f64]; 3], f: impl Fn(DVec3) -> DVec3) {
    let n = x.len();
    let (xs, ys, zs, y, z) = (&xs[..n], &ys[..n], &zs[..n], &mut y[..n], &mut z[..n]);
    for k in 0..n {
        let g = f(DVec3::new(xs[k], ys[k], zs[k]));
        (x[k], y[k], z[k]) = (g.x, g.y, g.z);
    }
}

/// [`slope`] at many points: derivatives by x, y and z. Whether the leaf has a closed form; else nothing is written.
///
/// Wider vector units give the same bits: only lane-wise IEEE operations are used, and none is contracted.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(super) fn slopes(leaf: &Leaf, p: [&[f64]; 3], out: [&mut [f64]; 3]) -> bool {
    match leaf {
        Leaf::Plane { n, .. } => each(p, out, |_| -*n),
        Leaf::Sphere { c, r } => each(p, out, |p| sphere(c, *r, p)),
        Leaf::Cylinder { c, frame, r } => each(p, out, |p| cylinder(c, frame, *r, p)),
        Leaf::Cone { c, frame, k, m, .. } => each(p, out, |p| cone(c, frame, [*k, *m], p)),
        Leaf::Torus { c, frame, major, minor } => each(p, out, |p| torus(c, frame, [*major, *minor], p)),
        Leaf::Formula(_) | Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_) => return false,
    }
    true
}
