//! Where fillets end, on the sheets of other leaves: there the zeros of a fillet touch those of the side that it ends in.
//!
//! Taken on along the sides they end in, fillets are above both sides, and the solid is the same. So where one ends, its zeros and
//! those of the side count as one line, whose part beyond the end belongs to the side.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::fillet::Fillet;
use super::super::leaf::Leaf;
use super::positive;

/// The lines at which fillets end, numbered after the leaves: those of fillets with one radius in one side are the same.
pub(super) struct Ends {
    lines: Vec<[u32; 2]>,
    /// What `lines` counts up to.
    pub(super) count: usize,
}

impl Ends {
    pub(super) fn new(leaves: &[Leaf]) -> Self {
        let mut known: FxHashMap<(u32, bool, u64), u32> = FxHashMap::default();
        let mut count = leaves.len();
        let mut line = |f: &Fillet, k: usize| {
            *known.entry((f.sides[k].number, f.sides[k].negate, f.radius.to_bits())).or_insert_with(|| {
                count += 1;
                count as u32 - 1
            })
        };
        let of = |leaf: &Leaf| if let Leaf::Fillet(f) = leaf { [0, 1].map(|k| line(f, k)) } else { [u32::MAX; 2] };
        let lines = leaves.iter().map(of).collect();
        Self { lines, count }
    }

    /// The line where a fillet ends and goes on along side `k`: its reach from there is [`Fillet::reach`] of the other side.
    pub(super) fn line(&self, fillet: u32, k: usize) -> u32 {
        self.lines[fillet as usize][1 - k]
    }

    /// Of two leaves, one of which is a fillet and the other a side of it: the fillet, its number, and that of the side.
    pub(super) fn fillet_and_side<'a>(leaves: &'a [Leaf], a: u32, b: u32) -> Option<(&'a Fillet, u32, usize)> {
        [(a, b), (b, a)].into_iter().find_map(|(a, b)| {
            let Leaf::Fillet(f) = &leaves[a as usize] else { return None };
            Some((&**f, a, f.sides.iter().position(|s| s.number == b)?))
        })
    }
}

/// A fillet that ends on a triangle of another leaf's sheet.
pub(super) struct End<'a> {
    pub(super) number: u32,
    pub(super) fillet: &'a Fillet,
    /// For each side, at the three nodes: below zero where the fillet has ended and goes on along the other side.
    pub(super) reach: [[f64; 3]; 2],
    /// What the fillet and its continuation are at the nodes.
    pub(super) values: [f64; 3],
}

impl<'a> End<'a> {
    /// `None` for other leaves and for fillets that do not end on the triangle.
    pub(super) fn new(leaf: &'a Leaf, number: u32, nodes: [DVec3; 3]) -> Option<Self> {
        let Leaf::Fillet(fillet) = leaf else { return None };
        let reach = [0, 1].map(|k| nodes.map(|p| fillet.reach(k, p)));
        let values = nodes.map(|p| fillet.continued(p));
        (!reach.as_flattened().iter().all(|v| positive(*v))).then_some(Self { number, fillet, reach, values })
    }

    /// The side that the fillet goes on along at all of some nodes, if it does.
    pub(super) fn gone(&self, nodes: &[usize]) -> Option<usize> {
        (0..2).find(|k| nodes.iter().all(|i| !positive(self.reach[*k][*i]))).map(|k| 1 - k)
    }

    /// Whether the fillet goes on along a side on a part of the triangle.
    pub(super) fn goes_on_along(&self, side: u32) -> Option<usize> {
        (0..2).find(|k| self.fillet.sides[*k].number == side && !self.reach[1 - k].iter().all(|v| positive(*v)))
    }
}
