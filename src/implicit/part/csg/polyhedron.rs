//! Convex polyhedra of a `.csg` file: what is on the inner side of all planes of their faces.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use super::super::super::solid::Solid;
use super::shapes::{ROOM, SIX_DIGITS};
use super::{AS_TRIANGLES, Call};
use crate::error::Result;
use crate::implicit::part::limits::STEPS;
use crate::spatial::Aabb;

/// A plane with the number of the face it is of.
struct Side {
    face: usize,
    normal: DVec3,
    at: DVec3,
}

/// A convex polyhedron.
pub(super) struct Polyhedron {
    points: Vec<DVec3>,
    sides: Vec<Side>,
}

impl Polyhedron {
    /// The solid after an affine map that can be turned round. Faces that lie in one plane have the name of the first.
    pub(super) fn placed(&self, map: &DAffine3, name: &str) -> Solid {
        let turned = map.matrix3.inverse().transpose();
        let side = |s: &Side| {
            Solid::half_space(turned * s.normal, map.transform_point3(s.at)).name(&format!("{name}.side{}", s.face))
        };
        let mut all: Vec<Solid> = self.sides.iter().map(side).collect();
        // Planes around the whole tell its bounds, and bound nothing.
        let wall = format!("{name}.side{}", self.sides.first().map_or(0, |s| s.face));
        let bounds = Aabb::around(self.points.iter().map(|p| map.transform_point3(*p)));
        let bounds = bounds.grown(ROOM * bounds.diagonal());
        for axis in DVec3::AXES {
            all.push(Solid::half_space(-axis, bounds.lo).name(&wall));
            all.push(Solid::half_space(axis, bounds.hi).name(&wall));
        }
        Solid::intersection(all)
    }
}

impl Call<'_> {
    /// The polyhedron; `None` for other operations.
    pub(super) fn polyhedron(&self) -> Result<Option<Polyhedron>> {
        if self.word.text != "polyhedron" {
            return Ok(None);
        }
        self.only(&["points", "faces", "triangles", "convexity"])?;
        let (points, token) = self.points(3)?;
        let Some(a) = self.argument("faces").or_else(|| self.argument("triangles")) else {
            return Err(self.error("polyhedron() needs faces"));
        };
        let faces = self.indices(a, points.len())?;
        let bad = |what: &str| Err(a.token.error(self.source, what));
        if faces.len() < 4 || faces.iter().any(|f| f.len() < 3) {
            return bad("a polyhedron needs four faces or more, of three points or more each");
        }
        // Faces times points: each pair is looked at.
        if faces.len().saturating_mul(points.len()) > STEPS {
            return bad("the polyhedron is too large to be read");
        }
        // Points that are written twice are one.
        let same: HashMap<[u64; 3], usize> =
            points.iter().enumerate().map(|(i, p)| ((*p + DVec3::ZERO).to_array().map(f64::to_bits), i)).collect();
        let one = |i: usize| same.get(&(points[i] + DVec3::ZERO).to_array().map(f64::to_bits)).copied().unwrap_or(i);
        let mut uses: HashMap<[usize; 2], i32> = HashMap::new();
        for f in &faces {
            for (i, p) in f.iter().enumerate() {
                let (a, b) = (one(*p), one(f[(i + 1) % f.len()]));
                *uses.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        if uses.values().any(|n| *n != 0) {
            return bad("the polyhedron is open, or its faces do not all turn the same way around");
        }
        let used = || faces.iter().flatten().map(|i| points[*i]);
        let size = Aabb::around(used()).diagonal();
        // A point and the plane of others are both off by that.
        let near = 2.0 * SIX_DIGITS * size;
        let mut sides: Vec<Side> = Vec::new();
        for (face, f) in faces.iter().enumerate() {
            let at = f.iter().map(|i| points[*i]).sum::<DVec3>() / f.len() as f64;
            let next = |i: usize| points[f[(i + 1) % f.len()]] - at;
            let area: DVec3 = (0..f.len()).map(|i| (points[f[i]] - at).cross(next(i))).sum();
            // Faces of no area bound nothing.
            let Some(n) = area.try_normalize().filter(|_| area.length() > near * near) else { continue };
            // Clockwise seen from outside: the normal of the winding points inward.
            let reach = used().map(|p| n.dot(at - p)).fold(f64::NEG_INFINITY, f64::max);
            if reach > near {
                let e = token
                    .error(self.source, format!("face {face} shows that the polyhedron is not convex, or inside out"));
                let help = format!("faces are clockwise seen from outside; for one that is not convex, {AS_TRIANGLES}");
                return Err(e.with_help(help));
            }
            let normal = -n;
            if !sides.iter().any(|s| s.normal.dot(normal) > 0.0 && s.normal.cross(normal).length() < SIX_DIGITS) {
                sides.push(Side { face, normal, at });
            }
        }
        if sides.len() < 4 {
            return bad("the polyhedron has no volume");
        }
        Ok(Some(Polyhedron { points: used().collect(), sides }))
    }
}
