//! A merged mesh read in other numbers than its own.

use std::ops::Range;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::{CellRun, Group, MeshView};
use crate::numeric::NONE;
use crate::run::PORTION;

use super::view::Merged;

/// A merged mesh with the numbers its nodes and cells had before it was cut into fragments.
///
/// Who edits fragments and wants files that differ in what was edited alone reads the mesh like this.
#[derive(Debug, Clone)]
pub struct Reordered<P = (), C = (), S = ()> {
    merged: Merged<P, C, S>,
    /// For each node and cell the number it has in the merged mesh.
    nodes: Vec<u32>,
    cells: Vec<u32>,
    /// For each node of the merged mesh its number here.
    numbers: Vec<u32>,
}

/// The inverse of a permutation; `None` if it is not one of `count` numbers.
fn inverse(of: &[u32], count: usize) -> Option<Vec<u32>> {
    if of.len() != count {
        return None;
    }
    let mut out = vec![NONE; count];
    for (i, to) in of.iter().enumerate() {
        let slot = out.get_mut(*to as usize).filter(|slot| **slot == NONE)?;
        *slot = i as u32;
    }
    Some(out)
}

impl<P, C, S> Reordered<P, C, S>
where
    Merged<P, C, S>: MeshView,
{
    /// Gives node `i` of the merged mesh the number `nodes[i]`, and cell `j` the number `cells[j]`, as
    /// [`Cut`](crate::model::Cut) lists them.
    ///
    /// # Errors
    /// [`Error::Failed`] for lists that do not name every number once.
    pub fn new(merged: Merged<P, C, S>, nodes: Vec<u32>, cells: &[u32]) -> Result<Self> {
        let wrong = |what| Error::Failed(format!("the merged mesh's {what} do not have the numbers they had before"));
        let inner = inverse(&nodes, merged.node_count()).ok_or_else(|| wrong("nodes"))?;
        let cells = inverse(cells, merged.cell_count()).ok_or_else(|| wrong("cells"))?;
        Ok(Self { merged, nodes: inner, cells, numbers: nodes })
    }

    /// The merged mesh with its own numbers.
    pub fn merged(&self) -> &Merged<P, C, S> {
        &self.merged
    }
}

impl<P: Sync, C: Sync, S: Sync> MeshView for Reordered<P, C, S> {
    fn node_count(&self) -> usize {
        self.merged.node_count()
    }

    fn cell_count(&self) -> usize {
        self.merged.cell_count()
    }

    fn face_names(&self) -> &[String] {
        self.merged.face_names()
    }

    fn groups(&self) -> &[Group] {
        self.merged.groups()
    }

    fn node(&self, i: usize) -> DVec3 {
        self.merged.node(self.nodes[i] as usize)
    }

    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        let mut list = Vec::with_capacity(PORTION.min(range.len()));
        for part in self.nodes[range].chunks(PORTION) {
            list.clear();
            list.extend(part.iter().map(|v| self.merged.node(*v as usize)));
            take(&list)?;
        }
        Ok(())
    }

    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()> {
        let (mut corners, mut ends) = (Vec::new(), Vec::new());
        let mut first = range.start;
        let label = |j: u32| self.merged.label(j as usize);
        for run in self.cells[range].chunk_by(|a, b| label(*a) == label(*b)) {
            for part in run.chunks(PORTION) {
                corners.clear();
                ends.clear();
                for j in part {
                    corners.extend(self.merged.cell(*j as usize).map(|v| self.numbers[v as usize]));
                    ends.push(corners.len() as u32);
                }
                // as even as it is: some readers take triangles as they stand
                let size = ends[0] as usize;
                let even = ends.iter().enumerate().all(|(k, end)| *end as usize == size * (k + 1));
                let run = if even {
                    CellRun::even(first, label(run[0]), &corners, size)
                } else {
                    CellRun::mixed(first, label(run[0]), &corners, &ends)
                };
                take(run)?;
                first += part.len();
            }
        }
        Ok(())
    }
}
