//! What an arrangement found out, so that one with smaller cells in places asks only there. It comes out bit by bit as if all were asked anew.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::assemble::{NONE, Skin};
use super::grid::{Octree, Tetrahedron};
use super::proof::Judged;
use super::shared::Curves;

/// What an arrangement found out.
#[derive(Debug)]
pub(crate) struct Recall {
    pub(super) tree: Arc<Octree>,
    /// What was shown of cells that hold some of the surface, by their numbers.
    pub(super) judged: FxHashMap<u32, Judged>,
    /// The boundary in portions of all cells,
    pub(super) portions: Vec<SkinPortion>,
    /// and where in them a cell's part of it is.
    groups: FxHashMap<u32, [usize; 2]>,
    /// Where nodes went from where the linear interpolants vanish; nowhere if their leaves do not vanish nearby.
    pub(super) settled: FxHashMap<NodeStart, Option<DVec3>>,
}

/// The boundary in the tetrahedra of some cells.
#[derive(Debug, Default)]
pub(super) struct SkinPortion {
    pub(super) skin: Skin,
    pub(super) groups: Vec<CellSkin>,
}

/// What a portion has of one cell.
#[derive(Debug, Clone)]
pub(super) struct CellSkin {
    pub(super) tetrahedra: Vec<Tetrahedron>,
    pub(super) triangles: Range<usize>,
    /// Of the nodes as they were asked for.
    pub(super) asked: Range<usize>,
    /// Whether several leaves have a curve in common there.
    pub(super) curved: bool,
}

/// Where a node begins: its place, bit by bit, its leaves, and how far it may go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct NodeStart {
    place: [u64; 3],
    leaves: [u32; 3],
    reach: u64,
}

impl NodeStart {
    pub(super) fn new(place: DVec3, on: &[u32], reach: f64) -> Self {
        let leaves = std::array::from_fn(|k| on.get(k).copied().unwrap_or(NONE));
        Self { place: place.to_array().map(f64::to_bits), leaves, reach: reach.to_bits() }
    }
}

impl Recall {
    pub(super) fn new(
        tree: Octree,
        judged: FxHashMap<u32, Judged>,
        portions: Vec<SkinPortion>,
        settled: FxHashMap<NodeStart, Option<DVec3>>,
    ) -> Self {
        let groups = portions.iter().enumerate().flat_map(|(k, p)| {
            let numbered = p.groups.iter().enumerate();
            numbered.filter_map(move |(g, group)| Some((group.tetrahedra.first()?.owner, [k, g])))
        });
        let groups = groups.collect();
        Self { tree: Arc::new(tree), judged, portions, groups, settled }
    }

    /// What was shown of a cell.
    pub(super) fn judged(&self, tree: &Octree, cell: u32) -> Option<&Judged> {
        self.judged.get(&self.tree.same(tree, cell)?)
    }

    /// The boundary in the tetrahedra of a cell, if they are as they were. Where leaves have a curve in common what is beside counts, too: there
    /// it is not known.
    pub(super) fn group(&self, tree: &Octree, group: &[Tetrahedron], curves: &Curves) -> Option<(&Skin, &CellSkin)> {
        let [k, g] = *self.groups.get(&self.tree.same(tree, group.first()?.owner)?)?;
        let portion = &self.portions[k];
        let known = &portion.groups[g];
        let same = |(a, b): (&Tetrahedron, &Tetrahedron)| a.corners == b.corners;
        let is_same = known.tetrahedra.len() == group.len() && known.tetrahedra.iter().zip(group).all(same);
        let curved = known.curved || group.iter().any(|t| curves.are_near(t));
        (is_same && !curved).then_some((&portion.skin, known))
    }
}
