//! Shape of triangles.

use glam::DVec3;
use serde::Serialize;

use crate::mesh::TriMesh;

/// Shape of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Smallest angle, degrees.
    pub min_angle: f64,
    /// Largest angle, degrees.
    pub max_angle: f64,
    /// `2 r / R`, inscribed over circumscribed circle: 1 for the equilateral triangle, 0 for a degenerate one.
    pub radius_ratio: f64,
}

/// Shape of the triangle `a b c`.
pub fn shape([a, b, c]: [DVec3; 3]) -> Shape {
    let angle = |o: DVec3, p: DVec3, q: DVec3| {
        let (u, v) = (p - o, q - o);
        u.cross(v).length().atan2(u.dot(v)).to_degrees()
    };
    let angles = [angle(a, b, c), angle(b, c, a), angle(c, a, b)];
    let (x, y, z) = (b.distance(c), c.distance(a), a.distance(b));
    let area = 0.5 * (b - a).cross(c - a).length();
    let s = 0.5 * (x + y + z);
    // 2 (area / s) / (x y z / 4 area)
    let ratio = 8.0 * area * area / (s * x * y * z);
    Shape {
        min_angle: angles.iter().copied().fold(f64::INFINITY, f64::min),
        max_angle: angles.iter().copied().fold(0.0, f64::max),
        radius_ratio: if ratio.is_finite() { ratio } else { 0.0 },
    }
}

/// Shape of a mesh's triangles, summed up. All zero for an empty mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Quality {
    /// Smallest angle of all, degrees.
    pub min_angle: f64,
    /// 5th percentile of the triangles' smallest angles, degrees, interpolated linearly.
    pub p05_angle: f64,
    /// Largest angle of all, degrees.
    pub max_angle: f64,
    /// Mean of `2 r / R`.
    pub mean_radius_ratio: f64,
    /// Share of triangles whose smallest angle is below 20 degrees.
    pub below_20: f64,
}

/// Sums up the shape of a mesh's triangles.
pub fn quality(mesh: &TriMesh) -> Quality {
    let n = mesh.triangles.len();
    if n == 0 {
        return Quality::default();
    }
    let shapes: Vec<Shape> = (0..n).map(|t| shape(mesh.corners(t))).collect();
    let mut angles: Vec<f64> = shapes.iter().map(|s| s.min_angle).collect();
    angles.sort_by(f64::total_cmp);
    let at = 0.05 * (n - 1) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    Quality {
        min_angle: angles[0],
        p05_angle: angles[low] + (angles[high] - angles[low]) * at.fract(),
        max_angle: shapes.iter().map(|s| s.max_angle).fold(0.0, f64::max),
        mean_radius_ratio: shapes.iter().map(|s| s.radius_ratio).sum::<f64>() / n as f64,
        below_20: angles.partition_point(|a| *a < 20.0) as f64 / n as f64,
    }
}
