//! Healing, for those who may not know the stages, and of what the stages left.

use rustc_hash::FxHashMap;

use crate::error::{Error, Result};
use crate::geometry::SurfaceOracle;
use crate::heal::heal_onto;
pub use crate::heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
use crate::mesh::TriMesh;
use crate::run::Run;

/// A mesh whose healing keeps less than this share of it is not healed but another one.
const LEAST_KEPT: f64 = 0.98;

/// Heals a mesh the stages left open, no manifold, or intersecting itself (`intersecting`: how many triangles do, where that
/// is known). `None` where nothing was wrong, and where healing would not set it right.
pub(super) fn heal_made(
    mesh: &TriMesh,
    intersecting: Option<usize>,
    oracle: &dyn SurfaceOracle,
    run: &Run,
) -> Result<Option<Healed>> {
    let d = mesh.defects();
    if intersecting == Some(0) && d.is_closed() && d.is_manifold() && d.is_oriented() {
        return Ok(None);
    }
    match heal_onto(mesh, &HealOptions::default(), Some(oracle), run) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(_) => Ok(None),
        Ok(h) => {
            let r = &h.report;
            Ok((!r.repairs.is_empty() && r.is_sound() && r.kept >= LEAST_KEPT).then_some(h))
        }
    }
}

/// What a report says of healing, a line for each repair.
pub(super) fn told(report: &HealReport) -> Vec<String> {
    report.to_string().lines().skip(1).map(|l| format!("healed: {}", l.trim())).collect()
}

/// For each node of a mesh the number of the node at the same place in another one.
pub(super) fn same_places(from: &TriMesh, to: &TriMesh) -> Vec<Option<u32>> {
    let place = |p: &glam::DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let at: FxHashMap<[u64; 3], u32> = to.nodes.iter().map(place).zip(0..).collect();
    from.nodes.iter().map(|p| at.get(&place(p)).copied()).collect()
}
