//! Where a level set is cut off: the box around a mesh, or the mesh itself where it is convex.

use glam::{DAffine3, DVec3};

use super::super::super::solid::{Primitive, Solid};
use crate::error::Result;
use crate::io::threemf::{Model, Placed, child, corners_of, number, wrong};
use crate::numeric::SEVEN_DIGITS;
use crate::spatial::Aabb;

/// Planes of a convex mesh: more would make a part of that many leaves.
const MOST_PLANES: usize = 1000;

/// The solid that a level set is cut off by, where it is placed.
pub(super) fn within(model: &Model<'_>, placed: &Placed<'_>) -> Result<Solid> {
    let shape = placed.shape;
    let id = number(shape, "meshid")?;
    let object = model.resource(id, shape)?;
    let Some(mesh) = child(object, "mesh") else {
        return Err(wrong(shape, format!("meshid is {id}, which is no object with a mesh")));
    };
    let corners = corners_of(mesh)?;
    let used: Vec<DVec3> = corners.triangles.iter().flatten().map(|v| corners.nodes[*v as usize]).collect();
    let bounds = Aabb::around(used.iter().copied());
    if used.is_empty() || !(bounds.size().min_element() > 0.0) {
        return Err(wrong(mesh, format!("the mesh of object {id} bounds nothing")));
    }
    let whole = boxed(&bounds, &placed.map);
    if matches!(shape.attribute("meshbboxonly"), Some("true" | "1")) {
        return Ok(whole);
    }
    // Corners may stand this far off planes through others.
    let slack = SEVEN_DIGITS * bounds.diagonal();
    let mut planes: Vec<[DVec3; 2]> = Vec::new();
    for t in &corners.triangles {
        let [a, b, c] = t.map(|v| corners.nodes[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let known = |p: &[DVec3; 2]| p[0].distance(normal) < SEVEN_DIGITS && p[0].dot(a - p[1]).abs() < slack;
        if normal == DVec3::ZERO || planes.iter().any(known) {
            continue;
        }
        let convex = corners.nodes.len() <= 100_000 && used.iter().all(|p| normal.dot(*p - a) <= slack);
        if !convex || planes.len() >= MOST_PLANES {
            let what = if convex { "has too many sides" } else { "is not convex, or its triangles look inward" };
            let e = wrong(shape, format!("the mesh of object {id}, which cuts the level set off, {what}"));
            return Err(e.with_help("with meshbboxonly=\"true\" the box around it does so"));
        }
        planes.push([normal, a]);
    }
    let along = |n: DVec3| n.abs().max_element() > 1.0 - 1e-12;
    if planes.len() == 6 && planes.iter().all(|p| along(p[0])) {
        return Ok(whole);
    }
    let turned = placed.map.matrix3.inverse().transpose();
    let half = |p: &[DVec3; 2]| Solid::half_space(turned * p[0], placed.map.transform_point3(p[1]));
    Ok(Solid::intersection(planes.iter().map(half)) & boxed_around(&used, &placed.map))
}

/// A box under a map, by its planes.
fn boxed(bounds: &Aabb, map: &DAffine3) -> Solid {
    let placed = Aabb::around(bounds.corners().map(|p| map.transform_point3(p)));
    let straight = |row: DVec3| row.to_array().iter().filter(|c| **c != 0.0).count() == 1;
    let m = map.matrix3;
    if (0..3).all(|i| straight(m.row(i))) {
        return Solid::from(Primitive::Box { lo: placed.lo, hi: placed.hi });
    }
    let turned = m.inverse().transpose();
    let sides = DVec3::AXES.into_iter().flat_map(|n| {
        [
            Solid::half_space(-(turned * n), map.transform_point3(bounds.lo)),
            Solid::half_space(turned * n, map.transform_point3(bounds.hi)),
        ]
    });
    // Planes that are not along the axes do not tell the bounds by themselves.
    Solid::intersection(sides) & boxed_around(&bounds.corners(), map)
}

/// The box around points under a map, with some room, so that it bounds nothing itself.
fn boxed_around(points: &[DVec3], map: &DAffine3) -> Solid {
    let placed = Aabb::around(points.iter().map(|p| map.transform_point3(*p)));
    let room = placed.grown(0.01 * placed.diagonal());
    Solid::from(Primitive::Box { lo: room.lo, hi: room.hi })
}
