//! How long edges should be at the nodes of a mesh.

use rustc_hash::FxHashSet;

use super::guard::ask_all;
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::EditMesh;
use crate::run::Run;
use crate::sizing::Sizing;

/// How fast the size may grow per length: neighbors' sizes then differ by at most this share, which keeps angles good.
pub const GRADATION: f64 = 0.3;

/// The size wanted at every node, limited so that it grows along edges by at most [`GRADATION`] times their length.
/// Nodes for which the oracle knows no curvature take what their neighbors want.
pub fn node_sizes(
    sizing: &Sizing,
    mesh: &EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    run: &Run,
) -> Result<Vec<f64>> {
    if !sizing.varies() {
        return Ok(vec![sizing.size; mesh.node_capacity()]);
    }
    let own = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !mesh.is_node(v) {
            return None;
        }
        let foot = oracle.project(mesh.point(v), reach)?;
        oracle.curvatures(&foot).map(|k| sizing.at(k[0].abs().max(k[1].abs())))
    })?;
    let mut field: Vec<f64> = own.into_iter().map(|s| s.unwrap_or(sizing.size)).collect();
    // Relaxation to the largest field below `own` with the wanted slope: a minimum, so the order does not matter.
    let mut front: Vec<u32> = mesh.nodes().collect();
    while !front.is_empty() {
        run.check()?;
        let mut changed = FxHashSet::default();
        let mut next = Vec::new();
        for &v in &front {
            for x in mesh.neighbors(v) {
                let limit = field[v as usize] + GRADATION * mesh.point(v).distance(mesh.point(x));
                if limit < field[x as usize] {
                    field[x as usize] = limit;
                    if changed.insert(x) {
                        next.push(x);
                    }
                }
            }
        }
        front = next;
    }
    Ok(field)
}
