//! Leaves that are one in some places: the two ways in which an angle goes on beyond half a turn.
//!
//! Where both have the same values bit by bit they are one plane of the arrangement, and what tells the ways apart cuts it into a part
//! of each leaf.

use super::super::leaf::Leaf;
use crate::spatial::Aabb;

/// Which leaves may be one somewhere.
pub(super) struct Twins {
    kin: Vec<Option<u64>>,
}

/// A leaf that is another one in a tetrahedron.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twin {
    pub(super) leaf: u32,
    /// The one that stands for both.
    pub(super) first: u32,
}

impl Twins {
    pub(super) fn new(leaves: &[Leaf]) -> Self {
        let kin = |l: &Leaf| if let Leaf::Formula(f) = l { f.kin() } else { None };
        let kin: Vec<Option<u64>> = leaves.iter().map(kin).collect();
        Self { kin: if kin.iter().any(Option::is_some) { kin } else { Vec::new() } }
    }

    fn are(&self, i: u32, j: u32) -> bool {
        let of = |l: u32| self.kin.get(l as usize).copied().flatten();
        of(i).is_some_and(|k| of(j) == Some(k))
    }

    /// Whether two leaves are one in a box.
    pub(super) fn are_one(&self, leaves: &[Leaf], [i, j]: [u32; 2], cell: &Aabb) -> bool {
        let is_same = |l: u32| matches!(&leaves[l as usize], Leaf::Formula(f) if f.is_same_as_kin(cell));
        self.are(i, j) && is_same(i) && is_same(j)
    }

    /// Takes leaves out of those that cut a tetrahedron that have the same values there as one before.
    pub(super) fn taken_out(&self, cutting: &mut Vec<u32>, values: &mut Vec<[f64; 4]>) -> Vec<Twin> {
        let mut found: Vec<Twin> = Vec::new();
        if self.kin.is_empty() {
            return found;
        }
        for (k, leaf) in cutting.iter().enumerate() {
            let first = (0..k).find(|i| values[*i] == values[k] && self.are(cutting[*i], *leaf));
            found.extend(first.map(|i| Twin { leaf: *leaf, first: cutting[i] }));
        }
        let is_out = |l: u32| found.iter().any(|t| t.leaf == l);
        let mut kept = cutting.iter().map(|l| !is_out(*l));
        values.retain(|_| kept.next().unwrap_or(true));
        cutting.retain(|l| !is_out(*l));
        found
    }
}
