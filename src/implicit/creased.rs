//! Creases that run inside one formula, of which the tree knows nothing: seen on the finished mesh.

use glam::DVec3;

use super::leaf::Leaf;
use super::lockstep;
use super::oracle::ImplicitOracle;
use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::run::Run;

/// Triangles whose normal is off from their formula's own by more than this cut off a crease: 25 degrees as a cosine. What
/// bends by as much as sizes allow is off by a few degrees.
const OFF: f64 = 0.906;

/// The middles of triangles that cut off what bends too much for them: a crease inside a formula or a blend, or a bend that is
/// tighter than the least size. Leaves of one smooth surface are not looked at.
pub fn creased(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> Vec<DVec3> {
    cutting_off(mesh, oracle, run).into_iter().map(|t| mesh.centroid(t as usize)).collect()
}

/// The triangles with these middles.
pub(crate) fn cutting_off(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> Vec<u32> {
    if !oracle.leaves().iter().any(Leaf::is_user) {
        return Vec::new();
    }
    let cut_off = |t: usize| {
        let (p, n) = (mesh.centroid(t), mesh.normal(t));
        // What only divides a face from itself, as cases of formulas do, has no direction there.
        let leaf = oracle.piece_at(p).filter(|leaf| oracle.bounds(&[*leaf], p))?;
        // Where another face's surface is nearer than its own, it is of the other one's direction that nothing is known.
        let own = oracle.face_at(leaf, p) == Some(mesh.labels[t]);
        let user = own && oracle.leaves().get(leaf as usize)?.is_user();
        (user && n != DVec3::ZERO && oracle.direction(leaf, p)?.dot(n).abs() < OFF).then_some(t as u32)
    };
    let all: Vec<usize> = (0..mesh.triangles.len()).collect();
    let found = run.install(|| lockstep::each(oracle.leaves(), &all, |t| cut_off(*t)));
    found.into_iter().flatten().collect()
}
