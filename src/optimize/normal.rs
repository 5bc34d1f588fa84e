//! The operator `N` of \[LIS14\] (4–7): nodes move so that triangles' normals agree with the surface's.

use super::guard::{Moves, ask_all, relocate};
use super::surface::centroid_feet;
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::EditMesh;
use crate::run::Run;

/// The damping λ the default sequences use: undamped Jacobi steps overshoot where neighbors move the same way.
pub const DAMPING: f64 = 0.5;

/// One pass of `N`, \[LIS14\] (6, 7): `p ← p + λ Σ A(t) ((c−p)·m) m / Σ A(t)` over the triangles around p, then back to
/// the surface. m is the surface's normal at the *projected* centroid (the centroid itself lies below a curved surface).
/// Pinned nodes stay.
///
/// *Guarantees*: guarded (see [`guard`](super::guard)); the answer does not depend on the number of threads.
/// *Does not guarantee*: that ε_n falls in one pass; iterate and watch [`normal_deviation`](super::normal_deviation).
pub fn align_normals(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    damping: f64,
    run: &Run,
) -> Result<Moves> {
    let feet = centroid_feet(mesh, oracle, reach, run)?;
    let frozen = &*mesh;
    let targets = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v) || frozen.is_pinned(v) {
            return None;
        }
        let p = frozen.point(v);
        let (mut sum, mut area) = (glam::DVec3::ZERO, 0.0);
        for h in frozen.outgoing(v) {
            let Some(foot) = &feet[(h / 3) as usize] else { continue };
            let a = frozen.area_vector(h / 3).length();
            sum += a * (frozen.centroid(h / 3) - p).dot(foot.normal) * foot.normal;
            area += a;
        }
        if area > 0.0 { oracle.project(p + damping / area * sum, reach).map(|f| f.point) } else { None }
    })?;
    let mut moves = Moves::default();
    for v in 0..mesh.node_capacity() as u32 {
        if !mesh.is_node(v) || mesh.is_pinned(v) {
            continue;
        }
        match targets[v as usize] {
            Some(p) => {
                relocate(mesh, v, p, &mut moves, |_, p| oracle.project(p, reach).map(|f| f.point));
            }
            None => moves.missed += 1,
        }
    }
    Ok(moves)
}
