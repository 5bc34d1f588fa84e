//! What an arrangement found out about its cells, so that one with smaller cells in places asks only there.

use std::sync::Arc;

use super::grid::Octree;
use super::proof::Judged;

/// What an arrangement found out. Another one comes out bit by bit as if all were asked anew.
#[derive(Debug)]
pub(crate) struct Recall {
    pub(super) tree: Arc<Octree>,
    /// Cells that hold some of the surface, ascending,
    pub(super) held: Vec<u32>,
    /// and what was shown of each.
    pub(super) judged: Vec<Judged>,
}

impl Recall {
    /// What was shown of a cell of another grid with the same points.
    pub(super) fn judged(&self, tree: &Octree, cell: u32) -> Option<&Judged> {
        let same = self.tree.same(tree, cell)?;
        Some(&self.judged[self.held.binary_search(&same).ok()?])
    }
}
