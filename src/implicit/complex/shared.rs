//! Leaves with one curve in common, as where a formula switches from one branch to another that has the same value there.
//!
//! Around a curve of n leaves there are 2 n sectors, not a sector for each choice of sides. The leaves' linear interpolants have
//! lines nearby instead of one curve, and between these slivers whose sides no point of the true leaves has. What is said of
//! slivers decides whether strips of a leaf show that bounds nothing. They are said to be what the sectors around them need.

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

/// A point of the curve that three leaves have in common in a cell or beside it, if they have one.
pub(super) fn common(asked: &Asked<'_>, [a, b, c]: [u32; 3]) -> Option<DVec3> {
    let Asked { leaves, cell, scale, .. } = *asked;
    let half = 0.5 * cell.size().max_element();
    let pair = |p: DVec3| nearest(leaves, &[a, b], p, 4.0 * half, scale);
    let start = pair(cell.center())?;
    let along = leaves[a as usize].slope(start).cross(leaves[b as usize].slope(start)).normalize_or_zero();
    for share in LOOKED {
        let q = pair(start + along * (share * half))?;
        let d = leaves[c as usize].gradient(q);
        if !(d.v.abs() <= VANISHES * scale * d.g.length()) {
            return None;
        }
    }
    Some(start)
}

/// Leaves with one curve in common.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Shared {
    /// Ascending.
    pub(super) leaves: Vec<u32>,
    /// The sectors in turn, by their sides on each leaf; the leaf between one and the next.
    sectors: Vec<(Vec<bool>, usize)>,
}

impl Shared {
    /// Leaves that cross each other in a curve through a point.
    pub(super) fn new(asked: &Asked<'_>, mut leaves: Vec<u32>, at: DVec3) -> Self {
        leaves.sort_unstable();
        let slopes: Vec<DVec3> =
            leaves.iter().map(|l| asked.leaves[*l as usize].slope(at).normalize_or_zero()).collect();
        let along = slopes[0].cross(slopes[1]).normalize_or_zero();
        let (u, v) = along.any_orthonormal_pair();
        // A leaf's zero set leaves the curve at right angles to its slope, both ways.
        let mut rays: Vec<(f64, usize, f64)> = Vec::new();
        for (k, s) in slopes.iter().enumerate() {
            for way in [1.0, -1.0] {
                rays.push(((way * s.dot(v)).atan2(way * s.dot(u)), k, way));
            }
        }
        rays.sort_by(|x, y| x.0.total_cmp(&y.0));
        // From one ray to the next the side of its leaf changes: turned by a right angle, rays start at the slope.
        let mut sides: Vec<bool> = vec![false; leaves.len()];
        rays.iter().for_each(|r| sides[r.1] = r.2 < 0.0);
        let sectors = rays
            .iter()
            .map(|r| {
                let before = sides.clone();
                sides[r.1] = !sides[r.1];
                (before, r.1)
            })
            .collect();
        Self { leaves, sectors }
    }

    /// Sides of leaves that exist in place of those that do not: of the leaves that show around the curve they are the same.
    fn real(&self, of: &dyn Fn(Sides<'_>) -> bool, sides: Sides<'_>) -> Option<&[bool]> {
        let here: Vec<bool> = self.leaves.iter().map(|l| sides(*l)).collect();
        if self.sectors.iter().any(|s| s.0 == here) {
            return None;
        }
        let n = self.sectors.len();
        let value = |k: usize| {
            of(&|l| self.leaves.iter().position(|x| *x == l).map_or_else(|| sides(l), |x| self.sectors[k].0[x]))
        };
        let values: Vec<bool> = (0..n).map(value).collect();
        let mut shows = vec![false; self.leaves.len()];
        for k in 0..n {
            shows[self.sectors[k].1] |= values[k] != values[(k + 1) % n];
        }
        // Where many show, slivers may be of none of their sectors: then the one with most sides right.
        let wrong = |k: &usize| -> (usize, usize) {
            let differs = |x: &usize| self.sectors[*k].0[*x] != here[*x];
            let all = 0..here.len();
            (all.clone().filter(|x| shows[*x]).filter(differs).count(), all.filter(differs).count())
        };
        (0..n).min_by_key(wrong).map(|k| &self.sectors[k].0[..])
    }
}

/// Sides of leaves by their numbers.
pub(super) type Sides<'a> = &'a dyn Fn(u32) -> bool;

/// Sides in place of given ones that exist around each of the curves, where `of` says what is inside.
pub(super) fn existing(shared: &[Shared], of: &dyn Fn(Sides<'_>) -> bool, sides: Sides<'_>) -> Vec<(u32, bool)> {
    let mut changed: Vec<(u32, bool)> = Vec::new();
    for s in shared {
        let found = s.real(of, &|l| with(&changed, sides, l)).map(<[bool]>::to_vec);
        for (l, side) in s.leaves.iter().zip(found.into_iter().flatten()) {
            changed.retain(|c| c.0 != *l);
            changed.push((*l, side));
        }
    }
    changed
}

/// The side of a leaf, changed or not.
pub(super) fn with(changed: &[(u32, bool)], sides: Sides<'_>, leaf: u32) -> bool {
    changed.iter().find(|c| c.0 == leaf).map_or_else(|| sides(leaf), |c| c.1)
}

/// Another leaf on whose other side a leaf bounds what is inside, if it does not where it is asked beside one of the curves.
pub(super) fn beside(shared: &[Shared], of: &dyn Fn(Sides<'_>) -> bool, leaf: u32, sides: Sides<'_>) -> Option<u32> {
    let bounds = |other: Option<u32>| {
        let on = |own: bool| of(&|l| if l == leaf { own } else { sides(l) != (Some(l) == other) });
        on(true) != on(false)
    };
    let near = shared.iter().filter(|s| s.leaves.contains(&leaf));
    let mut others = near.flat_map(|s| s.leaves.iter().copied()).filter(|l| *l != leaf).peekable();
    others.peek()?;
    if bounds(None) { None } else { others.find(|l| bounds(Some(*l))) }
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
                        known.push(s.clone());
                    }
                }
            }
        }
        Self { at }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.at.is_empty()
    }

    /// Those near a tetrahedron whose leaves are all known there.
    pub(super) fn near(&self, t: &Tetrahedron, known: &[u32]) -> Vec<Shared> {
        let all = t.corners.iter().filter_map(|p| self.at.get(p)).flatten();
        let mut all: Vec<Shared> =
            all.filter(|s| s.leaves.iter().all(|l| known.binary_search(l).is_ok())).cloned().collect();
        all.sort_unstable();
        all.dedup_by(|a, b| a.leaves == b.leaves);
        all
    }
}
