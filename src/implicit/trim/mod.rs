//! The surface made face by face: every leaf's own surface is meshed, cut by the others, and what bounds the solid is sewn
//! together along the edges.
//!
//! A leaf's own surface is smooth on the scale of the cells however close another leaf comes to it, so tips of sharp edges
//! and walls far thinner than the cells come out whole, which marching cubes on the solid loses. What is smaller than
//! the cells *on* a surface may still be missed, and two leaves that touch leave signs to rounding: then the parts do not
//! fit together and there is no mesh.

mod arrange;
mod ends;
mod sew;
mod sheet;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use super::extract::Extracted;
use super::model::Implicit;
use super::newton::leaves_of;
use super::octree::Cell;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

/// A closed mesh of a solid whose every triangle lies on one leaf.
#[derive(Debug, Clone)]
pub struct Trimmed {
    /// The mesh; labels are the leaves. Nodes lie on their leaves to rounding, but for those at points without a normal.
    pub mesh: TriMesh,
    /// For each node the leaves it lies on: one inside a face, two on an edge, more at a corner.
    pub leaves: Vec<Vec<u32>>,
}

/// Meshes each leaf's surface in the cells of an extraction, keeps what bounds the solid, and sews it together.
///
/// `None` where the parts do not fit together. The result is closed and oriented; it is not checked for triangles that
/// intersect.
pub(crate) fn trimmed(model: &Implicit, extracted: &Extracted, run: &Run) -> Result<Option<Trimmed>> {
    run.install(|| {
        let parts = parts(model, extracted, run)?;
        Ok(parts.and_then(|parts| sew::sew(model, &parts, extracted.bricks.grid.h)))
    })
}

/// What each leaf contributes.
fn parts(model: &Implicit, extracted: &Extracted, run: &Run) -> Result<Option<Vec<arrange::Part>>> {
    let grid = &extracted.bricks.grid;
    let cells: Vec<&Cell> = extracted.bricks.cells.iter().chain(&extracted.undecided).collect();
    let mut of_leaf: Vec<Vec<u32>> = vec![Vec::new(); model.leaves.len()];
    for (i, cell) in cells.iter().enumerate() {
        leaves_of(&cell.tape).into_iter().for_each(|l| of_leaf[l as usize].push(i as u32));
    }
    let scale = model.bounds().diagonal();
    let ends = ends::Ends::new(&model.leaves);
    let parts: Result<Vec<Option<arrange::Part>>> = of_leaf
        .par_iter()
        .enumerate()
        .filter(|(_, own)| !own.is_empty())
        .map(|(leaf, own)| {
            run.check()?;
            let own: Vec<&Cell> = own.iter().map(|i| cells[*i as usize]).collect();
            let sheet = sheet::sheet(&model.leaves[leaf], grid, &own, scale);
            Ok(arrange::arrange((model, &ends), leaf as u32, &sheet, &own, grid.h))
        })
        .collect();
    Ok(parts?.into_iter().collect())
}

/// Whether a number counts as on a leaf's positive side.
fn positive(v: f64) -> bool {
    v >= 0.0
}

/// A point between two others by their values, of which one is positive.
fn share(a: f64, b: f64) -> f64 {
    (a / (a - b)).clamp(0.0, 1.0)
}

fn place(nodes: &[DVec3], corners: [u32; 3], weights: [f64; 3]) -> DVec3 {
    (0..3).map(|k| nodes[corners[k] as usize] * weights[k]).sum()
}
