//! What an arrangement found out, so that one with smaller cells in places asks only there. It comes out bit by bit as if all were asked anew.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::assemble::{NONE, Skin};
use super::grid::{Octree, Tetrahedron};
use super::proof::Judged;
use super::shared::Curves;

/// What an arrangement found out, in lists as it comes; most are never asked.
#[derive(Debug)]
pub(crate) struct Recall {
    pub(super) tree: Arc<Octree>,
    /// Cells that hold some of the surface, and what was shown of each.
    pub(super) held: Vec<u32>,
    pub(super) judged: Vec<Judged>,
    /// By their owners,
    pub(super) tetrahedra: Vec<Tetrahedron>,
    /// and in the same order what is in them of the boundary.
    pub(super) portions: Vec<SkinPortion>,
    /// Where nodes began, and where they went; nowhere if their leaves do not vanish nearby.
    pub(super) moved: Vec<(NodeStart, Option<DVec3>)>,
    pub(super) index: OnceLock<RecallIndex>,
}

/// Where things are in the lists.
#[derive(Debug)]
pub(super) struct RecallIndex {
    judged: FxHashMap<u32, usize>,
    cells: FxHashMap<u32, CellPlace>,
    moved: FxHashMap<NodeStart, usize>,
}

/// Where a cell's tetrahedra are, and its part of the boundary: in which portion, and at which place there.
#[derive(Debug)]
struct CellPlace {
    tetrahedra: Range<usize>,
    portion: usize,
    place: usize,
}

/// The boundary in the tetrahedra of some cells.
#[derive(Debug, Default)]
pub(super) struct SkinPortion {
    pub(super) skin: Skin,
    pub(super) cells: Vec<CellSkin>,
}

/// What a portion has of one cell.
#[derive(Debug, Clone)]
pub(super) struct CellSkin {
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
    fn index(&self) -> &RecallIndex {
        self.index.get_or_init(|| {
            let places = self.portions.iter().enumerate();
            let places = places.flat_map(|(portion, p)| (0..p.cells.len()).map(move |place| [portion, place]));
            let mut end = 0;
            let owned = self.tetrahedra.chunk_by(|a, b| a.owner == b.owner).map(|of_one| {
                end += of_one.len();
                (of_one[0].owner, end - of_one.len()..end)
            });
            let cells = owned
                .zip(places)
                .map(|((owner, tetrahedra), [portion, place])| (owner, CellPlace { tetrahedra, portion, place }));
            RecallIndex {
                judged: self.held.iter().copied().zip(0..).collect(),
                cells: cells.collect(),
                moved: self.moved.iter().map(|m| m.0).zip(0..).collect(),
            }
        })
    }

    /// What was shown of a cell.
    pub(super) fn judged(&self, tree: &Octree, cell: u32) -> Option<&Judged> {
        Some(&self.judged[*self.index().judged.get(&self.tree.same(tree, cell)?)?])
    }

    /// The boundary in the tetrahedra of a cell, if they are as they were. Where leaves have a curve in common what is beside counts, too: there
    /// it is not known.
    pub(super) fn skin(&self, tree: &Octree, own: &[Tetrahedron], curves: &Curves) -> Option<(&Skin, &CellSkin)> {
        let at = self.index().cells.get(&self.tree.same(tree, own.first()?.owner)?)?;
        let (portion, before) = (&self.portions[at.portion], &self.tetrahedra[at.tetrahedra.clone()]);
        let known = &portion.cells[at.place];
        let is_same = before.len() == own.len() && before.iter().zip(own).all(|(a, b)| a.corners == b.corners);
        let curved = known.curved || own.iter().any(|t| curves.are_near(t));
        (is_same && !curved).then_some((&portion.skin, known))
    }

    /// Where a node went.
    pub(super) fn moved(&self, start: &NodeStart) -> Option<Option<DVec3>> {
        Some(self.moved[*self.index().moved.get(start)?].1)
    }
}
