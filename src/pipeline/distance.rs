//! How far a mesh and the faces of a boundary representation are from each other, triangle by triangle.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::mesh::sides::sides;
use crate::parametric::Parametric;
use crate::run::{PORTION, Run};
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// The largest distances between a mesh and the model it is of, in the model's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Distance {
    /// From the middle and the sides of triangles to the surfaces of their faces, each taken as a whole.
    pub to_surface: f64,
    /// From points of the model's edges to the mesh.
    pub from_surface: f64,
    /// The model's diagonal.
    pub diagonal: f64,
    /// The distance asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub asked: Option<f64>,
    /// Triangles farther away than that, or than what is aimed at without a wish.
    pub beyond: usize,
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = self.to_surface / self.diagonal;
        let (to, from) = (self.to_surface, self.from_surface);
        write!(
            f,
            "largest distance to the surface {to:.4e} ({share:.2e} of the diagonal), of edges to the mesh {from:.4e}"
        )
    }
}

/// For every triangle the largest distance of its middle and of the middles of its sides to the surface of its face. Those that
/// are neither above `limit` nor the largest of all may come out larger than they are, but not above these two.
///
/// *Errors*: cancellation.
pub(super) fn distances(solid: &Parametric, mesh: &TriMesh, limit: f64, run: &Run) -> Result<Vec<f64>> {
    let count = mesh.triangles.len();
    let across = across(mesh);
    // A side within a face is measured from one of its triangles.
    let other = |t: usize, k: usize| Some(across[3 * t + k] as usize).filter(|o| *o < 3 * count);
    let same = |t: usize, o: usize| mesh.labels[o / 3] == mesh.labels[t];
    let one = |t: usize, most: &mut f64| -> [f64; 4] {
        let label = mesh.labels[t];
        let p = mesh.corners(t);
        let mut away = |p: DVec3| {
            let d = solid.distance_beyond(label, p, most.min(limit));
            *most = most.max(d);
            d
        };
        let mut out = [away((p[0] + p[1] + p[2]) / 3.0), 0.0, 0.0, 0.0];
        for k in 0..3 {
            if other(t, k).is_none_or(|o| 3 * t + k < o || !same(t, o)) {
                out[k + 1] = away(0.5 * (p[k] + p[(k + 1) % 3]));
            }
        }
        out
    };
    let chunks: Result<Vec<Vec<[f64; 4]>>> = run.install(|| {
        (0..count.div_ceil(PORTION))
            .into_par_iter()
            .map(|c| {
                run.check()?;
                let mut most = 0.0;
                Ok((c * PORTION..((c + 1) * PORTION).min(count)).map(|t| one(t, &mut most)).collect())
            })
            .collect()
    });
    let found: Vec<[f64; 4]> = chunks?.concat();
    // What was measured from there counts for both.
    let beside = |t: usize, k: usize| other(t, k).filter(|o| same(t, *o)).map_or(0.0, |o| found[o / 3][o % 3 + 1]);
    let whole = |t: usize| (0..3).map(|k| beside(t, k)).chain(found[t]).fold(0.0, f64::max);
    Ok((0..count).map(whole).collect())
}

/// The side (three times its triangle, and which) across every side of a triangle; `u32::MAX` where there is none.
fn across(mesh: &TriMesh) -> Vec<u32> {
    let mut out = vec![u32::MAX; 3 * mesh.triangles.len()];
    for pair in sides(mesh).chunk_by(|a, b| a.key == b.key).filter(|g| g.len() == 2) {
        (out[pair[0].number as usize], out[pair[1].number as usize]) = (pair[1].number, pair[0].number);
    }
    out
}

/// The largest distance of points of the model's edges to the mesh; edges of faces without triangles are left out.
pub(super) fn from_edges(solid: &Parametric, mesh: &TriMesh) -> f64 {
    let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let mut used = vec![false; solid.brep.faces.len()];
    mesh.labels.iter().for_each(|l| used[*l as usize] = true);
    let farther = |p: DVec3, known: f64| {
        let near = |t: u32| triangle_distance_squared(p, mesh.corners(t as usize));
        tree.farther(p, known, near).unwrap_or(known)
    };
    let points: Vec<DVec3> = solid.edge_points(|f| used[f as usize]);
    // Of points not as far away as others nothing more is asked.
    let farthest = |points: &[DVec3]| points.iter().fold(0.0, |known, p| farther(*p, known));
    points.par_chunks(PORTION).map(farthest).reduce(|| 0.0, f64::max).sqrt()
}
