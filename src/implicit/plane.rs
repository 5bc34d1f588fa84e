//! Whether a solid is a figure of the plane: the same at every z.

use glam::DVec3;
use rustc_hash::FxHashSet;
use std::sync::Arc;

use super::expr::{Expr, ExprNode};
use super::solid::{Primitive, Solid, SolidNode};
use crate::error::{Error, Place, Result};
use crate::numeric::FEW_ROUNDINGS;

/// Whether a solid is the same at every z, as its tree shows: a figure of x and y that goes on along z without end.
///
/// Errors: [`Error::Input`] that names what depends on z, without a place.
pub fn check_plane(solid: &Solid) -> Result<()> {
    let mut seen = FxHashSet::default();
    let mut stack = vec![(solid, DVec3::Z)];
    while let Some((s, z)) = stack.pop() {
        if !seen.insert((Arc::as_ptr(&s.0), z.to_array().map(f64::to_bits))) {
            continue;
        }
        match s.node() {
            SolidNode::Primitive(p) => primitive(p, z)?,
            SolidNode::And(all) | SolidNode::Or(all) => stack.extend(all.iter().map(|s| (s, z))),
            SolidNode::Not(s) | SolidNode::Named(_, s) | SolidNode::Sized(_, s) => stack.push((s, z)),
            SolidNode::Blend(a, b, _) => stack.extend([(a, z), (b, z)]),
            SolidNode::Placed(p, s) => stack.push((s, p.rotation.transpose() * z)),
        }
    }
    Ok(())
}

fn parallel(a: DVec3, b: DVec3) -> bool {
    // Directions are the same up to what rounding leaves of a turn.
    a.normalize_or_zero().cross(b).length() <= FEW_ROUNDINGS
}

/// Whether a primitive is the same all along a direction.
fn primitive(p: &Primitive, z: DVec3) -> Result<()> {
    let (same, what) = match p {
        Primitive::Box { lo, hi } => {
            (lo.z == f64::NEG_INFINITY && hi.z == f64::INFINITY && parallel(DVec3::Z, z), "a box")
        }
        Primitive::Cylinder { axis, height: None, .. } => (parallel(*axis, z), "a cylinder whose axis is not z"),
        Primitive::Cylinder { .. } => (false, "a cylinder with a height"),
        Primitive::HalfSpace { normal, .. } => {
            (normal.normalize_or_zero().dot(z).abs() <= FEW_ROUNDINGS, "a half-space with a normal aside of the plane")
        }
        Primitive::Extrude { height, .. } => (*height == f64::INFINITY && parallel(DVec3::Z, z), "an extrusion"),
        Primitive::Smooth(s) => return primitive(&Primitive::Formula(s.whole.clone()), z),
        Primitive::Formula(e) => {
            let used = coordinates(e);
            ((0..3).all(|k| !used[k] || z[k].abs() <= FEW_ROUNDINGS), "a formula")
        }
        Primitive::Sphere { .. } => (false, "a sphere"),
        Primitive::Ellipsoid { .. } => (false, "an ellipsoid"),
        Primitive::Cone { .. } => (false, "a cone"),
        Primitive::Torus { .. } => (false, "a torus"),
        Primitive::Tpms { .. } => (false, "a periodic surface"),
        Primitive::Slab { .. } => (false, "an extrusion"),
        Primitive::Revolve { .. } | Primitive::Turned(_) => (false, "a solid of revolution"),
        Primitive::Foreign(_) => (false, "a boundary"),
        Primitive::Field(_) => (false, "a function of a program"),
    };
    if same {
        return Ok(());
    }
    Err(Error::input(Place::Unknown, format!("a plane figure is made of x and y alone, but {what} in it depends on z"))
        .with_help("plane figures are circle, ellipse, rectangle, polygon, formulas of x and y, and cylinders along z without a height"))
}

/// Which coordinates a formula has.
fn coordinates(e: &Expr) -> [bool; 3] {
    let mut used = [false; 3];
    let mut seen = FxHashSet::default();
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        if !seen.insert(Arc::as_ptr(&e.0)) {
            continue;
        }
        match e.node() {
            ExprNode::Const(_) => {}
            ExprNode::Coordinate(k) => used[usize::from(*k).min(2)] = true,
            ExprNode::Unary(_, a) => stack.push(a),
            ExprNode::Binary(_, a, b) => stack.extend([a, b]),
            ExprNode::Select(a, b, c) => stack.extend([a, b, c]),
        }
    }
    used
}
