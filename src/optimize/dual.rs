//! The dual mesh of \[LIS14\] and the operator `N1` (8–11): nodes move to where the tangent planes around them meet, which
//! on a crease or corner is the crease or corner itself.

use super::guard::{Moves, ask_all, relocate};
use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::EditMesh;
use crate::numeric::svd::Qef;
use crate::run::Run;

/// Singular values below this share of the largest are dropped in (10). At 0.1 a crease is seen from 35 degrees between
/// its normals on (tan²(θ/2) > 0.1); lower values make nodes on curved faces run along the surface after rounding.
pub const CUTOFF: f64 = 0.1;

/// The nodes of the dual mesh, D of \[LIS14\]: for each triangle the crossing of the line through its centroid along its
/// normal with the surface, `None` where there is none within `reach`, where the triangle is degenerate or dead.
pub fn dual_nodes(mesh: &EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<Vec<Option<Foot>>> {
    ask_all(oracle, run, mesh.triangle_capacity(), |t| {
        if !mesh.is_triangle(t) {
            return None;
        }
        oracle.project_along(mesh.centroid(t), mesh.area_vector(t).try_normalize()?, reach)
    })
}

/// One pass of `N1`, \[LIS14\] (8–11): every node whose mean squared distance (9) to the tangent planes at the dual nodes
/// around it exceeds `threshold` goes to the minimizer of that distance, singular values below [`CUTOFF`] dropped, no
/// further than `reach`, then back to the surface. Pinned nodes stay.
///
/// *Guarantees*: guarded (see [`guard`](super::guard)); the answer does not depend on the number of threads.
/// *Does not guarantee*: that every crease is resolved: an edge from one face to another still cuts the corner, however
/// well its ends are placed. [`cut_creases`](super::crease::cut_creases) is for that.
pub fn snap_to_planes(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    threshold: f64,
    run: &Run,
) -> Result<Moves> {
    let dual = dual_nodes(mesh, oracle, reach, run)?;
    let frozen = &*mesh;
    let targets = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v) || frozen.is_pinned(v) {
            return None;
        }
        let p = frozen.point(v);
        let mut planes = Qef::new(p);
        for foot in frozen.outgoing(v).filter_map(|h| dual[(h / 3) as usize].as_ref()) {
            planes.add(foot.point, foot.normal, 1.0);
        }
        if planes.error() <= threshold {
            return None;
        }
        let step = planes.solve(CUTOFF).step.clamp_length_max(reach);
        oracle.project(p + step, reach).map(|f| f.point)
    })?;
    let mut moves = Moves::default();
    for (v, target) in targets.into_iter().enumerate() {
        if let Some(p) = target {
            relocate(mesh, v as u32, p, &mut moves, |_, p| oracle.project(p, reach).map(|f| f.point));
        }
    }
    Ok(moves)
}
