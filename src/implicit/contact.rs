//! Surfaces in closed form that touch along a curve, as rounded ends, slots and pipe bends have them.

use glam::DVec3;

use super::leaf::{Frame, Leaf};
use crate::numeric::FEW_ROUNDINGS;

fn same(a: f64, b: f64, scale: f64) -> bool {
    // Lengths agree, and directions, up to the rounding of what a user computes.
    (a - b).abs() <= FEW_ROUNDINGS * (scale.abs() + a.abs() + b.abs())
}

/// Its foot on an axis, from the axis' point.
fn along(p: DVec3, c: DVec3, axis: DVec3) -> f64 {
    (p - c).dot(axis)
}

fn plane(at: DVec3, normal: DVec3) -> Option<Leaf> {
    let n = normal.try_normalize()?;
    Some(Leaf::Plane { n, d: n.dot(at) })
}

fn parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= FEW_ROUNDINGS
}

fn orthogonal(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= FEW_ROUNDINGS
}

/// A surface that crosses both of two leaves in the curve along which they touch, if they do that. Where one of them is zero, its zeros
/// there are those of the other.
pub(super) fn contact(a: &Leaf, b: &Leaf) -> Option<Leaf> {
    one_way(a, b).or_else(|| one_way(b, a))
}

fn one_way(a: &Leaf, b: &Leaf) -> Option<Leaf> {
    match (a, b) {
        // A rounded end.
        (Leaf::Sphere { c, r }, Leaf::Cylinder { c: at, frame, r: s }) => {
            let t = along(*c, *at, frame.a);
            let foot = *at + frame.a * t;
            (same(*r, *s, 0.0) && foot.distance(*c) <= FEW_ROUNDINGS * (r + c.length())).then(|| plane(*c, frame.a))?
        }
        (Leaf::Sphere { c, r }, Leaf::Cone { c: at, frame, k, m, d }) => {
            let t = along(*c, *at, frame.a);
            let is_on_axis = (*at + frame.a * t).distance(*c) <= FEW_ROUNDINGS * (r + c.length());
            let touches = same((d - m * t).abs(), r * k.hypot(*m), c.length());
            (is_on_axis && touches)
                .then(|| plane(*c + frame.a * (r * m / k.hypot(*m)).copysign(m * (d - m * t)), frame.a))?
        }
        // The end of a slot.
        (Leaf::Cylinder { c, frame, r }, Leaf::Plane { n, d }) => {
            let touches = same((d - n.dot(*c)).abs(), *r, c.length() + d.abs());
            (orthogonal(*n, frame.a) && touches).then(|| plane(*c, n.cross(frame.a)))?
        }
        (Leaf::Cylinder { c, frame, r }, Leaf::Cylinder { c: at, frame: other, r: s }) => {
            let apart = *at - *c;
            let across = apart - frame.a * apart.dot(frame.a);
            let gap = across.length();
            let scale = c.length() + at.length();
            let touches = same(gap, r + s, scale) || same(gap, (r - s).abs(), scale);
            let is_beside = gap > FEW_ROUNDINGS * (scale + r + s);
            (parallel(frame.a, other.a) && touches && is_beside).then(|| plane(*c, across.cross(frame.a)))?
        }
        (Leaf::Torus { c, frame, major, minor }, _) => torus(*c, frame, [*major, *minor], b),
        _ => None,
    }
}

fn torus(c: DVec3, frame: &Frame, [major, minor]: [f64; 2], b: &Leaf) -> Option<Leaf> {
    let scale = major + minor + c.length();
    match b {
        // A round along a flat.
        Leaf::Plane { n, d } => {
            let touches = same((d - n.dot(c)).abs(), minor, scale);
            (parallel(*n, frame.a) && touches).then(|| Leaf::Cylinder { c, frame: *frame, r: major })
        }
        Leaf::Cylinder { c: at, frame: other, r } if parallel(frame.a, other.a) => {
            let foot = *at + other.a * along(c, *at, other.a);
            let touches = same(*r, major + minor, scale) || same(*r, (major - minor).abs(), scale);
            (touches && foot.distance(c) <= FEW_ROUNDINGS * scale).then(|| plane(c, frame.a))?
        }
        // A bend of a pipe.
        Leaf::Cylinder { c: at, frame: other, r } => {
            let foot = *at + other.a * along(c, *at, other.a);
            let arm = foot - c;
            let is_tangent = orthogonal(other.a, frame.a) && arm.dot(frame.a).abs() <= FEW_ROUNDINGS * scale;
            (same(*r, minor, 0.0) && is_tangent && same(arm.length(), major, scale)).then(|| plane(foot, other.a))?
        }
        Leaf::Sphere { c: at, r } => {
            let arm = *at - c;
            let is_on = arm.dot(frame.a).abs() <= FEW_ROUNDINGS * scale && same(arm.length(), major, scale);
            (same(*r, minor, 0.0) && is_on).then(|| plane(*at, frame.a.cross(arm)))?
        }
        _ => None,
    }
}
