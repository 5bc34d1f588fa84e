//! Three leaves with one curve in common, as where a formula switches from one branch to another that has the same value there.
//!
//! Around such a curve there are six sectors, not eight. The leaves' linear interpolants have three lines nearby instead of one
//! curve, and between these a sliver whose sides no point of the true leaves has. What is said of the sliver decides whether
//! strips of a leaf show that bounds nothing. It is said to be what the sectors around it need.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::newton::nearest;
use super::grid::{Point, Tetrahedron};
use super::proof::Asked;

/// A third leaf vanishes where two others do if it is no farther than this share of the part's size from there: what sums of
/// rounded terms leave, a thousand times the rounding of one.
const VANISHES: f64 = 1e-12;
/// Places along the curve at which this is looked at, in halves of the cell from its middle.
const LOOKED: [f64; 5] = [0.0, -0.9, 0.9, -0.4, 0.4];

/// Three leaves with one curve in common, and sides that they do not have there. Those opposite to all three of these do not
/// exist either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Shared {
    pub(super) leaves: [u32; 3],
    pub(super) never: [bool; 3],
}

impl Shared {
    /// Three leaves, if they have a curve in common in a cell or beside it.
    pub(super) fn of(asked: &Asked<'_>, which: [u32; 3]) -> Option<Self> {
        let Asked { leaves: all, cell, scale, .. } = *asked;
        let [a, b, c] = which;
        let half = 0.5 * cell.size().max_element();
        let pair = |p: DVec3| nearest(all, &[a, b], p, 4.0 * half, scale);
        let start = pair(cell.center())?;
        let slopes = which.map(|l| all[l as usize].slope(start));
        let along = slopes[0].cross(slopes[1]).normalize_or_zero();
        for share in LOOKED {
            let q = pair(start + along * (share * half))?;
            let d = all[c as usize].gradient(q);
            if !(d.v.abs() <= VANISHES * scale * d.g.length()) {
                return None;
            }
        }
        // Where the factors with which gradients cancel are all of one sign, no side of all three is.
        let factors = [(1, 2), (2, 0), (0, 1)].map(|(x, y)| slopes[x].cross(slopes[y]).dot(along));
        let never = factors.map(|f| f > 0.0);
        Some(Self { leaves: which, never })
    }

    /// Whether the leaves cannot have these sides.
    fn is_sliver(&self, sides: [bool; 3]) -> bool {
        let opposite = self.never.map(|s| !s);
        sides == self.never || sides == opposite
    }
}

/// Sides of leaves by their numbers.
pub(super) type Sides<'a> = &'a dyn Fn(u32) -> bool;

/// Whether inside is where leaves have these sides, with what slivers need. The last of `shared` is asked first.
pub(super) fn inside(shared: &[Shared], of: &dyn Fn(Sides<'_>) -> bool, sides: Sides<'_>) -> bool {
    let Some((last, others)) = shared.split_last() else { return of(sides) };
    let here = last.leaves.map(sides);
    if !last.is_sliver(here) {
        return inside(others, of, sides);
    }
    // The sectors in turn: across the side of the sliver on leaf 2, and on from there across leaves 0, 2, 1, 0, 2, 1.
    let turned = |flips: [bool; 3]| {
        let flipped = |l: u32| match last.leaves.iter().position(|x| *x == l) {
            Some(k) => sides(l) != flips[k],
            None => sides(l),
        };
        inside(others, of, &flipped)
    };
    let sectors = [
        turned([false, false, true]),
        turned([true, false, true]),
        turned([true, false, false]),
        turned([true, true, false]),
        turned([false, true, false]),
        turned([false, true, true]),
    ];
    const CROSSED: [usize; 6] = [0, 2, 1, 0, 2, 1];
    let mut shows = [false; 3];
    for (k, leaf) in CROSSED.into_iter().enumerate() {
        shows[leaf] |= sectors[k] != sectors[(k + 1) % 6];
    }
    // Sides of the sliver that show, those of leaves that show nowhere else first.
    let across = [sectors[2], sectors[4], sectors[0]];
    let cost = |value: bool| {
        let shown = (0..3).filter(|k| across[*k] != value);
        shown.map(|k| if shows[k] { 1 } else { 10 }).sum::<u32>()
    };
    cost(true) < cost(false)
}

/// Sides beside a leaf that exist, if those given do not on one side of it: those of another place where it bounds the same.
pub(super) fn beside(shared: &[Shared], of: &dyn Fn(Sides<'_>) -> bool, leaf: u32, sides: Sides<'_>) -> Option<u32> {
    for s in shared {
        let Some(own) = s.leaves.iter().position(|l| *l == leaf) else { continue };
        let mut here = s.leaves.map(sides);
        let sliver = s.is_sliver(here) || {
            here[own] = !here[own];
            s.is_sliver(here)
        };
        if !sliver {
            continue;
        }
        for other in s.leaves.into_iter().filter(|l| *l != leaf) {
            let with = |own: bool| of(&|l| if l == leaf { own } else { sides(l) != (l == other) });
            if with(true) != with(false) {
                return Some(other);
            }
        }
    }
    None
}

/// The curves near each point of the grid.
#[derive(Default)]
pub(super) struct Curves {
    at: FxHashMap<Point, Vec<Shared>>,
}

impl Curves {
    /// From the curves in each cell that owns tetrahedra. They count at all corners of these.
    pub(super) fn new(tetrahedra: &[Tetrahedron], of: &FxHashMap<u32, Vec<Shared>>) -> Self {
        let mut at: FxHashMap<Point, Vec<Shared>> = FxHashMap::default();
        for t in tetrahedra {
            for s in of.get(&t.owner).into_iter().flatten() {
                for p in t.corners {
                    let known = at.entry(p).or_default();
                    if !known.iter().any(|k| k.leaves == s.leaves) {
                        known.push(*s);
                    }
                }
            }
        }
        Self { at }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.at.is_empty()
    }

    /// Those near a tetrahedron.
    pub(super) fn near(&self, t: &Tetrahedron) -> Vec<Shared> {
        let mut all: Vec<Shared> = t.corners.iter().filter_map(|p| self.at.get(p)).flatten().copied().collect();
        all.sort_unstable();
        all.dedup_by_key(|s| s.leaves);
        all
    }
}
