//! Exact signs of determinants, by Shewchuk's adaptive predicates (crate `robust`).

use glam::{DVec2, DVec3};

/// Positive if `a b c` turn counter-clockwise, negative if clockwise, zero exactly if they lie on a line.
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let p = |v: DVec2| robust::Coord { x: v.x, y: v.y };
    robust::orient2d(p(a), p(b), p(c))
}

/// Positive if `d` lies below the plane through `a b c` (which turn counter-clockwise seen from above), zero exactly if
/// the four points lie in one plane.
pub fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let p = |v: DVec3| robust::Coord3D { x: v.x, y: v.y, z: v.z };
    robust::orient3d(p(a), p(b), p(c), p(d))
}
