//! What lies under the triangles: labels, reference normals, the normal deviation (4, 5), and projection of nodes.

use glam::DVec3;

use super::guard::{Moves, ask_all, relocate};
use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::EditMesh;
use crate::run::Run;

/// How far the triangles' normals are from the surface's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NormalDeviation {
    /// ε_n, \[LIS14\] (5): area-weighted mean of 1 − (n·m)², m at the projected centroid.
    pub normal: f64,
    /// Triangles with n·m ≤ 0, which the square in (4) would hide.
    pub inverted: usize,
    /// Triangles whose centroid has no foot within reach; they count in nothing else.
    pub missed: usize,
}

/// The feet of all triangles' centroids.
pub(super) fn centroid_feet(
    mesh: &EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    run: &Run,
) -> Result<Vec<Option<Foot>>> {
    ask_all(oracle, run, mesh.triangle_capacity(), |t| {
        if mesh.is_triangle(t) { oracle.project(mesh.centroid(t), reach) } else { None }
    })
}

fn deviation(mesh: &EditMesh, feet: &[Option<Foot>]) -> NormalDeviation {
    let mut out = NormalDeviation::default();
    let (mut sum, mut area) = (0.0, 0.0);
    for t in mesh.triangles() {
        let Some(foot) = &feet[t as usize] else {
            out.missed += 1;
            continue;
        };
        let a = mesh.area_vector(t);
        let facing = a.normalize_or_zero().dot(foot.normal);
        sum += a.length() * (1.0 - facing * facing);
        area += a.length();
        out.inverted += usize::from(facing <= 0.0);
    }
    if area > 0.0 {
        out.normal = sum / area;
    }
    out
}

/// The normal deviation ε_n of \[LIS14\] (4, 5), with ∇F taken at the *projected* centroid, and the count of inverted
/// triangles. Looks for feet at most `reach` away. Changes nothing.
pub fn normal_deviation(mesh: &EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<NormalDeviation> {
    Ok(deviation(mesh, &centroid_feet(mesh, oracle, reach, run)?))
}

/// Asks the oracle what lies under every triangle and records face label and normal there: labels come out right, and
/// the guard of later moves knows which way a triangle should face. Triangles without foot keep their label and lose
/// their normal.
pub fn survey(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<NormalDeviation> {
    let feet = centroid_feet(mesh, oracle, reach, run)?;
    let out = deviation(mesh, &feet);
    for (t, foot) in feet.iter().enumerate() {
        if !mesh.is_triangle(t as u32) {
            continue;
        }
        match foot {
            Some(foot) => mesh.set_surface(t as u32, foot.face, foot.normal),
            None => mesh.set_surface(t as u32, mesh.label(t as u32), DVec3::ZERO),
        }
    }
    Ok(out)
}

/// Forgets the normals [`survey`] recorded; the guard then compares a triangle with its old self only.
pub fn forget(mesh: &mut EditMesh) {
    let all: Vec<u32> = mesh.triangles().collect();
    for t in all {
        mesh.set_surface(t, mesh.label(t), DVec3::ZERO);
    }
}

/// Moves every node that is not pinned to its foot on the surface, guarded. *Does not guarantee* that nodes on a crease
/// stay on it beyond what the oracle's foot says: see [`settle_creases`](super::crease::settle_creases).
pub fn project(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<Moves> {
    let feet = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if mesh.is_node(v) && !mesh.is_pinned(v) { oracle.project(mesh.point(v), reach) } else { None }
    })?;
    let mut moves = Moves::default();
    for v in 0..mesh.node_capacity() as u32 {
        if !mesh.is_node(v) || mesh.is_pinned(v) {
            continue;
        }
        match &feet[v as usize] {
            Some(foot) => {
                if foot.point != mesh.point(v) {
                    relocate(mesh, v, foot.point, &mut moves, |_, p| oracle.project(p, reach).map(|f| f.point));
                }
            }
            None => moves.missed += 1,
        }
    }
    Ok(moves)
}
