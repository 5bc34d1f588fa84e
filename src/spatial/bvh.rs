//! A bounding-volume hierarchy over boxes.

use glam::DVec3;
use rayon::prelude::*;

use super::Aabb;

/// Items in a leaf: below this, looking at all of them is cheaper than another level.
const LEAF: usize = 4;

/// Levels whose halves are looked at in parallel.
const FORKS: u32 = 8;

/// Below this many levels all groups are halved by number: no way down is then longer than the stacks of the searches.
const EVEN: u32 = 24;

/// Halves of fewer items than this are built one after the other.
const ALONE: usize = 1 << 12;

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// First item of a leaf, or index of the right child (the left one follows its parent).
    start: u32,
    /// Number of items of a leaf, 0 for an inner node.
    count: u32,
}

/// A round cone that is open without end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewCone {
    /// Its tip.
    pub apex: DVec3,
    /// A unit vector along its middle.
    pub axis: DVec3,
    /// The cosine of the angle between the axis and its sides.
    pub cosine: f64,
}

/// A bounding-volume hierarchy. Items are put in the order of a space-filling curve (G. M. Morton, 1966), along which every
/// halving of space is a cut (C. Lauterbach and others, "Fast BVH construction on GPUs", 2009). Deterministic.
#[derive(Debug, Clone)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// The items of all leaves, one after the other, and their boxes.
    items: Vec<u32>,
    boxes: Vec<Aabb>,
}

impl Bvh {
    /// Builds the hierarchy over boxes, on the threads of the current pool; items are numbered as given.
    pub fn new(boxes: Vec<Aabb>) -> Self {
        let around = Aabb::around(boxes.iter().map(Aabb::center));
        let curve = Curve::new(&around);
        let mut codes: Vec<(u64, u32)> = boxes.iter().map(|b| curve.code(b.center())).zip(0..).collect();
        codes.par_sort_unstable();
        let items: Vec<u32> = codes.iter().map(|c| c.1).collect();
        let boxes = in_order(boxes, &items);
        let mut nodes = Vec::with_capacity(2 * boxes.len().div_ceil(LEAF) + 1);
        if !boxes.is_empty() {
            build(&boxes, &codes, 0, 0, &mut nodes);
        }
        Self { nodes, boxes, items }
    }

    /// Positions, in the lists of items and boxes, of what a leaf holds.
    fn held(node: &Node) -> std::ops::Range<usize> {
        node.start as usize..(node.start + node.count) as usize
    }

    /// Calls `f` for every item whose box touches `query`.
    pub fn overlapping(&self, query: &Aabb, mut f: impl FnMut(u32)) {
        self.any(query, |i| {
            f(i);
            false
        });
    }

    /// Whether the box of some item touches `query`.
    pub fn meets(&self, query: &Aabb) -> bool {
        self.any(query, |_| true)
    }

    /// Whether `f` holds of some item whose box touches `query`; the rest is not asked then.
    fn any(&self, query: &Aabb, mut f: impl FnMut(u32) -> bool) -> bool {
        let mut stack = [0u32; 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            if !node.bounds.overlaps(query) {
                continue;
            }
            if node.count > 0 {
                for k in Self::held(node) {
                    if self.boxes[k].overlaps(query) && f(self.items[k]) {
                        return true;
                    }
                }
            } else {
                stack[top] = node.start;
                stack[top + 1] = at as u32 + 1;
                top += 2;
            }
        }
        false
    }

    /// All pairs of items whose boxes touch and that pass `keep`, the smaller number first, in ascending order whatever
    /// the number of threads of the current pool.
    pub fn pairs(&self, keep: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<[u32; 2]> {
        let mut found = if self.nodes.is_empty() { Vec::new() } else { self.pairs_within(0, FORKS, keep) };
        found.sort_unstable();
        found
    }

    fn pairs_within(&self, at: u32, forks: u32, keep: &(impl Fn(u32, u32) -> bool + Sync)) -> Vec<[u32; 2]> {
        let node = &self.nodes[at as usize];
        if node.count > 0 {
            let mut found = Vec::new();
            let held = Self::held(node);
            for i in held.clone() {
                (i + 1..held.end).for_each(|j| self.offer(i, j, keep, &mut found));
            }
            return found;
        }
        let (left, right) = (at + 1, node.start);
        let mut across = Vec::new();
        let mut cross = || self.pairs_across(left, right, keep, &mut across);
        let mut found = if forks > 0 {
            let within = || {
                rayon::join(|| self.pairs_within(left, forks - 1, keep), || self.pairs_within(right, forks - 1, keep))
            };
            let ((mut a, b), ()) = rayon::join(within, cross);
            a.extend(b);
            a
        } else {
            cross();
            let mut a = self.pairs_within(left, 0, keep);
            a.extend(self.pairs_within(right, 0, keep));
            a
        };
        found.extend(across);
        found
    }

    fn pairs_across(&self, a: u32, b: u32, keep: &impl Fn(u32, u32) -> bool, found: &mut Vec<[u32; 2]>) {
        let (x, y) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        if !x.bounds.overlaps(&y.bounds) {
            return;
        }
        if x.count > 0 && y.count > 0 {
            for i in Self::held(x).filter(|i| self.boxes[*i].overlaps(&y.bounds)) {
                Self::held(y).for_each(|j| self.offer(i, j, keep, found));
            }
        } else if y.count > 0 || (x.count == 0 && x.bounds.size().length_squared() > y.bounds.size().length_squared()) {
            self.pairs_across(a + 1, b, keep, found);
            self.pairs_across(x.start, b, keep, found);
        } else {
            self.pairs_across(a, b + 1, keep, found);
            self.pairs_across(a, y.start, keep, found);
        }
    }

    fn offer(&self, i: usize, j: usize, keep: &impl Fn(u32, u32) -> bool, found: &mut Vec<[u32; 2]>) {
        if !self.boxes[i].overlaps(&self.boxes[j]) {
            return;
        }
        let (i, j) = (self.items[i].min(self.items[j]), self.items[i].max(self.items[j]));
        if keep(i, j) {
            found.push([i, j]);
        }
    }

    /// The squared distance from `p` to the nearest item, as [`nearest`](Self::nearest) measures it, if that is more than
    /// `known`: who looks for the point that is farthest away need not know how near the others are.
    pub fn farther(&self, p: DVec3, known: f64, distance_squared: impl Fn(u32) -> f64) -> Option<f64> {
        let mut least = f64::INFINITY;
        self.approach(p, f64::INFINITY, Aabb::distance_squared, |i, _| {
            least = least.min(distance_squared(i));
            (least > known).then_some(least)
        });
        (least > known && least.is_finite()).then_some(least)
    }

    /// The item nearest to `p` by `distance_squared`, which must not be less than the squared distance to the item's box,
    /// among those nearer than `limit`; and that squared distance. Ties go to the smaller number.
    pub fn nearest(&self, p: DVec3, limit: f64, distance_squared: impl FnMut(u32) -> f64) -> Option<(u32, f64)> {
        self.nearest_by(p, limit, Aabb::distance_squared, distance_squared)
    }

    /// [`nearest`](Self::nearest) of the items that come near the apex of a cone within it: `distance_squared` must be infinite where
    /// the way to an item's nearest point leads out of the cone.
    pub fn nearest_ahead(
        &self,
        cone: ViewCone,
        limit: f64,
        distance_squared: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let ViewCone { apex: p, axis, cosine } = cone;
        let ahead = |b: &Aabb, p: DVec3| {
            let away = b.distance_squared(p);
            // How far the box reaches along the axis at most.
            let reach = (b.center() - p).dot(axis) + 0.5 * b.size().dot(axis.abs());
            if reach > 0.0 && reach * reach >= cosine * cosine * away { away } else { f64::INFINITY }
        };
        self.nearest_by(p, limit, ahead, distance_squared)
    }

    fn nearest_by(
        &self,
        p: DVec3,
        limit: f64,
        away: impl Fn(&Aabb, DVec3) -> f64,
        mut distance_squared: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        self.approach(p, limit * limit, away, |i, bound| {
            let d = distance_squared(i);
            let better = best.is_none_or(|b| d < b.1 || (d == b.1 && i < b.0));
            if d <= bound && better {
                best = Some((i, d));
                return Some(d);
            }
            Some(bound)
        });
        best
    }

    /// Shows items whose boxes are no farther `away` from `p` than a bound (squared), about the nearest first. Each time the item
    /// and the bound are given, the new bound is told; with none the search ends.
    #[inline(always)]
    fn approach(
        &self,
        p: DVec3,
        mut bound: f64,
        away: impl Fn(&Aabb, DVec3) -> f64,
        mut visit: impl FnMut(u32, f64) -> Option<f64>,
    ) {
        let mut stack = [(0u32, 0.0f64); 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let (mut at, least) = stack[top];
            if least > bound {
                continue;
            }
            // Down to the nearest leaf; what is passed by waits on the stack.
            while self.nodes[at as usize].count == 0 {
                let (near, far) = (at + 1, self.nodes[at as usize].start);
                let d = [near, far].map(|n| away(&self.nodes[n as usize].bounds, p));
                let (near, far) = if d[0] <= d[1] { ((near, d[0]), (far, d[1])) } else { ((far, d[1]), (near, d[0])) };
                if far.1 <= bound {
                    stack[top] = far;
                    top += 1;
                }
                at = near.0;
                if near.1 > bound {
                    break;
                }
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                continue;
            }
            for k in Self::held(node) {
                if away(&self.boxes[k], p) <= bound {
                    match visit(self.items[k], bound) {
                        Some(next) => bound = next,
                        None => return,
                    }
                }
            }
        }
    }
}

/// The boxes in another order, without room for both.
fn in_order(mut boxes: Vec<Aabb>, order: &[u32]) -> Vec<Aabb> {
    let mut placed = vec![false; boxes.len()];
    for start in 0..boxes.len() {
        let (mut at, first) = (start, boxes[start]);
        while !placed[at] {
            placed[at] = true;
            let from = order[at] as usize;
            boxes[at] = if from == start { first } else { boxes[from] };
            at = from;
        }
    }
    boxes
}

/// Adds nodes that were built by themselves.
fn append(nodes: &mut Vec<Node>, others: Vec<Node>) {
    let before = nodes.len() as u32;
    nodes.extend(others.into_iter().map(|n| if n.count > 0 { n } else { Node { start: n.start + before, ..n } }));
}

/// Numbers along a curve through all cells of a cube of 2^21 cells to a side.
struct Curve {
    lo: DVec3,
    per_length: f64,
}

impl Curve {
    fn new(around: &Aabb) -> Self {
        let longest = around.size().max_element();
        Self { lo: around.lo, per_length: if longest > 0.0 { (1u32 << 21) as f64 / longest } else { 0.0 } }
    }

    /// The bits of the three coordinates in turns; those of the first axis are the highest.
    fn code(&self, p: DVec3) -> u64 {
        // Casts end at the bounds, and make zero of what is no number.
        let [x, y, z] = ((p - self.lo) * self.per_length).to_array().map(|c| spread((c as u64).min((1 << 21) - 1)));
        x << 2 | y << 1 | z
    }
}

/// 21 bits with two zeros after each.
fn spread(mut x: u64) -> u64 {
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Where items along the curve are cut in two: between the halves of the smallest block that holds them all; by their number
/// where they are all in one cell, or that has been done too often for a short way down.
fn cut(codes: &[(u64, u32)], depth: u32) -> usize {
    let differ = codes[0].0 ^ codes[codes.len() - 1].0;
    if differ == 0 || depth >= EVEN {
        return codes.len() / 2;
    }
    let bit = 1 << (u64::BITS - 1 - differ.leading_zeros());
    codes.partition_point(|c| c.0 & bit == 0)
}

/// Builds the hierarchy over items in order, those from number `start` on, and returns their bounds.
fn build(boxes: &[Aabb], codes: &[(u64, u32)], start: u32, depth: u32, nodes: &mut Vec<Node>) -> Aabb {
    let at = nodes.len();
    nodes.push(Node { bounds: Aabb::EMPTY, start, count: codes.len() as u32 });
    if codes.len() <= LEAF {
        nodes[at].bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
        return nodes[at].bounds;
    }
    let mid = cut(codes, depth);
    let ((low, high), (under, over)) = (codes.split_at(mid), boxes.split_at(mid));
    let (bounds, right);
    if high.len().min(low.len()) < ALONE {
        let left = build(under, low, start, depth + 1, nodes);
        right = nodes.len() as u32;
        bounds = left.union(&build(over, high, start + mid as u32, depth + 1, nodes));
    } else {
        let half = |boxes: &[Aabb], codes: &[(u64, u32)], start| {
            let mut nodes = Vec::with_capacity(2 * codes.len().div_ceil(LEAF) + 1);
            (build(boxes, codes, start, depth + 1, &mut nodes), nodes)
        };
        let (left, other) = rayon::join(|| half(under, low, start), || half(over, high, start + mid as u32));
        bounds = left.0.union(&other.0);
        append(nodes, left.1);
        right = nodes.len() as u32;
        append(nodes, other.1);
    }
    nodes[at] = Node { bounds, start: right, count: 0 };
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn queries_agree_with_looking_at_everything(
            raw in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), 0.0f64..0.3), 0..80),
            q in prop::array::uniform3(-1.2f64..1.2), half in 0.0f64..0.5,
        ) {
            let boxes: Vec<Aabb> = raw.iter().map(|(c, h)| Aabb::new(DVec3::from_array(*c) - *h, DVec3::from_array(*c) + *h)).collect();
            let bvh = Bvh::new(boxes.clone());
            let q = DVec3::from_array(q);
            let n = boxes.len() as u32;
            let touch = |i: u32, j: u32| boxes[i as usize].overlaps(&boxes[j as usize]);
            let all: Vec<[u32; 2]> = (0..n).flat_map(|i| (i + 1..n).map(move |j| [i, j])).filter(|p| touch(p[0], p[1])).collect();
            prop_assert_eq!(bvh.pairs(&|_, _| true), all);
            let query = Aabb::new(q - half, q + half);
            let mut found = Vec::new();
            bvh.overlapping(&query, |i| found.push(i));
            found.sort_unstable();
            let all: Vec<u32> = (0..n).filter(|i| boxes[*i as usize].overlaps(&query)).collect();
            prop_assert_eq!(found, all);
            let d = |i: u32| boxes[i as usize].distance_squared(q);
            let near = bvh.nearest(q, 0.4, d).map(|n| n.1);
            let best = (0..boxes.len() as u32).map(d).filter(|d| *d <= 0.16).min_by(f64::total_cmp);
            prop_assert_eq!(near, best);
            let best = (0..n).map(d).min_by(f64::total_cmp);
            prop_assert_eq!(bvh.farther(q, 0.01, d), best.filter(|d| *d > 0.01));
            prop_assert_eq!(bvh.farther(q, -1.0, d), best);
        }

        #[test]
        fn no_way_down_is_too_long(base in 1.0f64..1e3) {
            // Ever closer to one end: halving space would leave all but one item on one side, again and again.
            let boxes: Vec<Aabb> = (0..3000).map(|k| DVec3::X * base.powi(-k)).map(|p| Aabb::new(p, p)).collect();
            let bvh = Bvh::new(boxes);
            let mut count = 0;
            bvh.overlapping(&Aabb::new(DVec3::NEG_ONE, DVec3::ONE), |_| count += 1);
            prop_assert_eq!(count, 3000);
        }
    }
}
