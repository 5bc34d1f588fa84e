//! Shape of triangles.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::mesh::{MeshView, TriMesh};

/// Shape of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleMeasures {
    /// Smallest angle, degrees.
    pub min_angle: f64,
    /// Largest angle, degrees.
    pub max_angle: f64,
    /// `2 r / R`, inscribed over circumscribed circle: 1 for the equilateral triangle, 0 for a degenerate one.
    pub radius_ratio: f64,
}

/// Shape of the triangle `a b c`.
pub fn shape([a, b, c]: [DVec3; 3]) -> TriangleMeasures {
    let (u, v, w) = (c - b, a - c, b - a);
    let double = v.cross(w).length();
    let angle = |cosine: f64| double.atan2(cosine).to_degrees();
    let angles = [-v.dot(w), -w.dot(u), -u.dot(v)].map(angle);
    let (x, y, z) = (u.length(), v.length(), w.length());
    let area = 0.5 * double;
    let s = 0.5 * (x + y + z);
    // 2 (area / s) / (x y z / 4 area)
    let ratio = 8.0 * area * area / (s * x * y * z);
    TriangleMeasures {
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

/// Sums up the shape of a mesh's triangles; cells of more than three corners count as fans around their first.
pub fn quality(mesh: &dyn MeshView) -> Quality {
    summed_up(&shapes(&TriMesh::of_view(mesh)))
}

pub(super) fn shapes(mesh: &TriMesh) -> Vec<TriangleMeasures> {
    (0..mesh.triangles.len()).into_par_iter().with_min_len(1024).map(|t| shape(mesh.corners(t))).collect()
}

pub(super) fn summed_up(shapes: &[TriangleMeasures]) -> Quality {
    let n = shapes.len();
    if n == 0 {
        return Quality::default();
    }
    let mut angles: Vec<f64> = shapes.iter().map(|s| s.min_angle).collect();
    let at = 0.05 * (n - 1) as f64;
    let (_, &mut low, above) = angles.select_nth_unstable_by(at.floor() as usize, f64::total_cmp);
    let high = if at.fract() > 0.0 { above.iter().copied().fold(f64::INFINITY, f64::min) } else { low };
    Quality {
        min_angle: shapes.iter().map(|s| s.min_angle).fold(f64::INFINITY, f64::min),
        p05_angle: low + (high - low) * at.fract(),
        max_angle: shapes.iter().map(|s| s.max_angle).fold(0.0, f64::max),
        mean_radius_ratio: shapes.iter().map(|s| s.radius_ratio).sum::<f64>() / n as f64,
        below_20: shapes.iter().filter(|s| s.min_angle < 20.0).count() as f64 / n as f64,
    }
}
