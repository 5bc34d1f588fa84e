//! Where fillets end. On the sheets of other leaves the zeros of a fillet touch those of the side that it ends in there.

use rustc_hash::FxHashMap;

use super::super::fillet::Fillet;
use super::super::leaf::Leaf;

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

    /// The line where a fillet ends in side `k`: its positive side is where [`Fillet::reach`] of the other side is.
    pub(super) fn line(&self, fillet: u32, k: usize) -> u32 {
        self.lines[fillet as usize][1 - k]
    }
}

/// Of two leaves, one of which is a fillet and the other a side of it: the fillet, its number, and that of the side.
pub(super) fn fillet_and_side(leaves: &[Leaf], a: u32, b: u32) -> Option<(&Fillet, u32, usize)> {
    [(a, b), (b, a)].into_iter().find_map(|(a, b)| {
        let Leaf::Fillet(f) = &leaves[a as usize] else { return None };
        Some((&**f, a, f.sides.iter().position(|s| s.number == b)?))
    })
}
