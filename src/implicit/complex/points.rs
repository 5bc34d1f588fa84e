//! Where surfaces end in points, or all but touch in one: tips of cones, spikes, cusps, balls that overlap by a hair.
//!
//! Around a point in which a surface has no normal cells of every size are not proved, but a number of them that does not depend
//! on the size. They are halved further than others: it costs next to nothing, and what is too thin for the smallest cells of the
//! others is no longer than a share of them in the end. Two surfaces that meet in a tiny circle are told apart by cells smaller than
//! that. Where surfaces touch along curves, or run side by side, the cells that are not proved become twice or four times as many
//! with each halving; more of that would show nothing.

use rustc_hash::{FxHashMap, FxHashSet};

use super::grid::Octree;
use super::proof::Unproved;

/// A group has grown if it has more than so many halves as many cells as it began with: five quarters end too early on spikes of
/// 5 degrees, and where surfaces touch along a curve it is four halves.
const GROWN: usize = 3;
/// The same where surfaces touch: they are side by side in twice as many cells with each halving, until these are smaller than the circle in
/// which they meet. Two halvings are looked at; what they do not prove is [undone](Points::in_vain).
const GROWN_BESIDE: usize = 8;
/// Surfaces all but touch in a point if that is fewer cells wide: balls of a hundred cells' diameter are side by side that far. Of 40 large
/// trees two more came out with 8 than with 4, and none more with 16, which takes more cells along curves.
const WIDE: i64 = 8;

/// Cells that are not proved, by the group of touching ones they come from.
#[derive(Debug, Default)]
pub(super) struct Points {
    group: FxHashMap<u32, u32>,
    groups: Vec<Cluster>,
}

#[derive(Debug)]
struct Cluster {
    /// The cells it began with.
    first: Vec<u32>,
    reason: Unproved,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// It is halved further.
    Open,
    /// In smaller cells nothing bends or touches.
    Parted,
    /// There are too many of its smaller cells.
    Grown,
}

impl Cluster {
    fn most_grown(&self) -> usize {
        if self.reason == Unproved::Touching { GROWN_BESIDE } else { GROWN }
    }
}

impl Points {
    /// Whether what is not shown of a cell may be so in a point.
    pub(super) fn may_be(unproved: Unproved) -> bool {
        matches!(unproved, Unproved::Bent | Unproved::Touching)
    }

    /// Groups of cells of one level that touch each other and are not proved for one reason, but for those longer than the largest cells
    /// are, `deeper` levels above: beside a block of the grid they would not be seen as they are. Where surfaces touch groups are no
    /// [wider](WIDE) than a point.
    pub(super) fn new(tree: &Octree, cells: impl Iterator<Item = (u32, Unproved)>, deeper: u8) -> Self {
        let at = |i: u32| {
            let c = &tree.cubes[i as usize];
            c.at.map(|x| i64::from(x >> c.level))
        };
        let cells: Vec<(u32, Unproved)> = cells.collect();
        let by_place: FxHashMap<[i64; 3], (u32, Unproved)> = cells.iter().map(|c| (at(c.0), *c)).collect();
        let mut seen: FxHashSet<u32> = FxHashSet::default();
        let mut points = Self::default();
        for (start, reason) in &cells {
            if !seen.insert(*start) {
                continue;
            }
            let mut group = vec![*start];
            let mut next = 0;
            while let Some(i) = group.get(next) {
                let p = at(*i);
                next += 1;
                for k in 0..27 {
                    let q = [p[0] + k % 3 - 1, p[1] + k / 3 % 3 - 1, p[2] + k / 9 - 1];
                    if let Some((j, _)) = by_place.get(&q).filter(|j| j.1 == *reason && seen.insert(j.0)) {
                        group.push(*j);
                    }
                }
            }
            let most = if *reason == Unproved::Touching { WIDE } else { 1 << deeper };
            let is_short = (0..3).all(|k| {
                let along = || group.iter().map(|i| at(*i)[k]);
                along().max().zip(along().min()).is_some_and(|(hi, lo)| hi - lo < most)
            });
            if is_short {
                let number = points.groups.len() as u32;
                points.group.extend(group.iter().map(|i| (*i, number)));
                points.groups.push(Cluster { first: group, reason: *reason, state: State::Open });
            }
        }
        points
    }

    pub(super) fn holds(&self, cell: u32) -> bool {
        self.group.contains_key(&cell)
    }

    /// Of cells a level deeper those are kept that are not proved, in groups that did not grow.
    pub(super) fn keep(&mut self, cells: impl Iterator<Item = u32>) {
        let kept: FxHashMap<u32, u32> = cells.filter_map(|i| Some((i, *self.group.get(&i)?))).collect();
        let mut count = vec![0; self.groups.len()];
        kept.values().for_each(|g| count[*g as usize] += 1);
        for (g, count) in self.groups.iter_mut().zip(count).filter(|x| x.0.state == State::Open) {
            if count == 0 {
                g.state = State::Parted;
            } else if 2 * count > g.most_grown() * g.first.len() {
                g.state = State::Grown;
            }
        }
        self.group = kept;
        self.group.retain(|_, g| self.groups[*g as usize].state == State::Open);
    }

    /// Cells in which surfaces touch however small cells become: smaller ones show no more there, and triangles would be small for nothing.
    pub(super) fn in_vain(&self) -> impl Iterator<Item = u32> {
        let in_vain = |g: &&Cluster| g.reason == Unproved::Touching && g.state != State::Parted;
        self.groups.iter().filter(in_vain).flat_map(|g| g.first.iter().copied())
    }

    /// Children, eight to a cell, take the places of their parents.
    pub(super) fn go_on(&mut self, parents: &[u32], children: &[u32]) {
        let group = std::mem::take(&mut self.group);
        for (parent, eight) in parents.iter().zip(children.chunks(8)) {
            if let Some(g) = group.get(parent) {
                self.group.extend(eight.iter().map(|c| (*c, *g)));
            }
        }
    }
}
