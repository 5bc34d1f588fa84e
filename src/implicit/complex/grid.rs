//! An adaptive grid of cubes, and the tetrahedra between the centers of neighbors and their common edges.
//!
//! For each minimal edge of an octree and each two different cells that follow each other around it there is a tetrahedron of
//! their centers and the edge. These fill the box and meet face to face, whatever the levels of the cells.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::super::leaf::Leaf;
use super::super::lockstep;
use super::super::tape::{Pruned, Scratch, Tape};
use super::points::Points;
use super::proof::Unproved;
use crate::error::{Error, Result};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Bits of a coordinate of a [`Point`].
const BITS: u32 = 21;
/// The grid's planes are shifted against the box's faces by shares of a cell that no simple ratio of lengths hits, so that
/// faces rarely fall on them; at least one layer of cells is outside.
const SHIFT: DVec3 = DVec3::new(1.371, 1.433, 1.292);
/// Cells beside the box along an axis, on both sides together: more than the shift, and a layer beyond.
const MARGIN: f64 = 4.0;

/// How often cells are halved further where surfaces end in points: see [`Points`]. Spikes of a half angle of 5 degrees are clean from
/// there up to where a fan around their apex takes over.
const FINER: u8 = 6;

/// A tape with more operations than this is cut down to what a block needs before its cells are made: there are tens of cubes larger
/// than a block, and each would be asked about everything. With fewer operations that takes no time to speak of.
const MANY: usize = 1 << 12;

/// No cell.
pub(super) const NONE: u32 = u32::MAX;

/// A cube of the octree; coordinates in the smallest cubes.
#[derive(Debug, Clone)]
pub(super) struct Cube {
    pub(super) at: [u32; 3],
    pub(super) level: u8,
    /// The first of eight children, in the order of their bits x, y, z.
    pub(super) children: u32,
    /// What holds in the cube, if it is not all inside or all outside.
    pub(super) tape: Option<Arc<Tape>>,
    /// The same of the cube grown by its side: it holds in all tetrahedra the cube owns. Cubes larger than the largest cells, but
    /// for those well inside a block, own none; theirs holds only as far as a block reaches.
    pub(super) wide: Option<Arc<Tape>>,
    shown: FirstLook,
}

/// What a first look showed of a cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FirstLook {
    /// There was none.
    Nothing,
    /// That leaves are arranged simply.
    Simple,
    /// That they may not be.
    Open(Unproved),
}

/// A point of the grid, by its coordinates in halves of the smallest cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Point(pub(super) u64);

impl Point {
    fn new(c: [u64; 3]) -> Self {
        Self(c[0] | c[1] << BITS | c[2] << (2 * BITS))
    }

    pub(super) fn coordinates(self) -> [u64; 3] {
        let m = (1 << BITS) - 1;
        [self.0 & m, self.0 >> BITS & m, self.0 >> (2 * BITS)]
    }
}

/// Two cells' centers and an edge of the smaller one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tetrahedron {
    /// The smaller of the two cells.
    pub(super) owner: u32,
    /// Positively oriented.
    pub(super) corners: [Point; 4],
}

/// Some of a grid: its largest cells from `lo` up to `hi`, by number along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct GridBlock {
    pub(crate) lo: [u32; 3],
    pub(crate) hi: [u32; 3],
}

impl GridBlock {
    /// In smallest cubes, grown by `by` largest cells.
    pub(super) fn cubes(&self, deeper: u8, by: i64) -> [[i64; 3]; 2] {
        let scaled = |c: u32, d: i64| (i64::from(c) + d) << deeper;
        [self.lo.map(|c| scaled(c, -by)), self.hi.map(|c| scaled(c, by))]
    }
}

/// How many of the largest cells beside a block are made as if there were no block: cells there have the neighbors they have in
/// the whole grid, as do those of a cell more. Halving for the sake of neighbors goes no farther than the sum of smaller and smaller cells, which is two.
const HALO: i64 = 5;

/// The largest cells along each axis that a grid has which holds a box.
pub(crate) fn cells_along(bounds: &Aabb, size: f64) -> [u32; 3] {
    (bounds.size() / size).to_array().map(|n| (n + MARGIN).ceil() as u32)
}

/// The lower corner of a grid's cells, and so that of cell `[0, 0, 0]`.
pub(crate) fn origin(bounds: &Aabb, size: f64) -> DVec3 {
    bounds.lo - SHIFT * size
}

impl Tetrahedron {
    /// Whether it belongs to a block, grown by so many largest cells: each belongs to one of the blocks that fill the grid.
    pub(super) fn is_in(&self, block: &GridBlock, deeper: u8, by: i64) -> bool {
        self.side(block.cubes(deeper, by)) == [0; 3]
    }

    /// Where it lies along each axis: between these corners in smallest cubes (0), below (-1) or above.
    pub(super) fn side(&self, [lo, hi]: [[i64; 3]; 2]) -> [i8; 3] {
        std::array::from_fn(|k| {
            // Four corners, in halves of cubes.
            let sum: i64 = self.corners.iter().map(|p| p.coordinates()[k] as i64).sum();
            i8::from(sum >= 8 * hi[k]) - i8::from(sum < 8 * lo[k])
        })
    }
}

/// What a grid is wanted for.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub(super) leaves: &'a [Leaf],
    pub(super) tape: &'a Arc<Tape>,
    pub(super) bounds: Aabb,
    pub(super) size: f64,
    /// How often cells may be halved for what is not simple,
    pub(super) deeper: u8,
    /// and how often more in some places.
    pub(super) more: u8,
    pub(super) places: &'a [Aabb],
    /// How many cells there may be.
    pub(super) most: usize,
    /// What is wanted of it, if not all.
    pub(super) block: Option<GridBlock>,
    /// How often cells of a block may be larger where none beside it is the wiser.
    pub(super) wider: u8,
    /// A grid of the same leaves and size, with other places.
    pub(super) before: Option<&'a Arc<Octree>>,
}

/// A cube that is larger than wanted, or was looked at.
struct Seen {
    cell: u32,
    /// Whether it may be halved, wherever it is.
    may: bool,
    shown: FirstLook,
}

impl Seen {
    fn unproved(&self) -> Option<Unproved> {
        match self.shown {
            FirstLook::Open(u) => Some(u),
            FirstLook::Nothing | FirstLook::Simple => None,
        }
    }
}

/// Cubes within cubes.
#[derive(Debug)]
pub(super) struct Octree {
    pub(super) origin: DVec3,
    /// Side of the smallest cube.
    pub(super) unit: f64,
    /// How often the largest cells may be halved, to the smallest cubes.
    pub(super) deeper: u8,
    pub(super) cubes: Vec<Cube>,
    /// The corners of what is made at all, in smallest cubes.
    near: Option<[[i64; 3]; 2]>,
    /// Where cubes up to a level may be left larger than the largest cells elsewhere.
    wide: Option<Wide>,
    /// Whose cubes have what these have, while it is built.
    before: Option<Arc<Octree>>,
}

/// Where in a block cells may be larger than the largest ones that blocks have in common.
#[derive(Debug)]
struct Wide {
    /// In smallest cubes.
    corners: [[i64; 3]; 2],
    /// Of the largest cubes there.
    level: u8,
}

impl Wide {
    /// What of a block is so far from other blocks that none of these makes any of it.
    fn new(block: &GridBlock, all: [u32; 3], deeper: u8, wider: u8) -> Self {
        let [mut lo, mut hi] = block.cubes(deeper, -HALO);
        // Where the grid ends there is no block beyond, but a layer of cells is outside: what is larger would have none beside it.
        let [first, last] = block.cubes(deeper, -1);
        for k in 0..3 {
            lo[k] = if block.lo[k] == 0 { first[k] } else { lo[k] };
            hi[k] = if block.hi[k] >= all[k] { last[k] } else { hi[k] };
        }
        Self { corners: [lo, hi], level: deeper + wider }
    }

    fn holds(&self, c: &Cube) -> bool {
        let [lo, hi] = self.corners;
        c.level <= self.level
            && (0..3).all(|k| i64::from(c.at[k]) >= lo[k] && i64::from(c.at[k]) + (1 << c.level) <= hi[k])
    }
}

/// What of a tape holds in a box, if that is not all inside or all outside.
fn pruned(tape: &Arc<Tape>, leaves: &[Leaf], cell: &Aabb, scratch: &mut Scratch) -> Option<Arc<Tape>> {
    match tape.prune(leaves, cell, scratch) {
        Pruned::Outside | Pruned::Inside => None,
        Pruned::Same => Some(tape.clone()),
        Pruned::Smaller(t) => Some(Arc::new(t)),
    }
}

impl Octree {
    pub(super) fn point(&self, p: Point) -> DVec3 {
        let c = p.coordinates();
        self.origin + DVec3::new(c[0] as f64, c[1] as f64, c[2] as f64) * (0.5 * self.unit)
    }

    pub(super) fn bounds(&self, at: [u32; 3], level: u8) -> Aabb {
        let corner = |d: u32| self.origin + DVec3::from_array(at.map(|c| f64::from(c + d))) * self.unit;
        Aabb::new(corner(0), corner(1 << level))
    }

    /// Cubes of about `size` around the surface, halved up to `deeper` times where something is not proved, and further where that is
    /// around points.
    ///
    /// Errors: cells too small for the numbers of nodes, or more of them than `most`; cancellation.
    pub(super) fn build(
        wanted: &Wanted<'_>,
        unproved: &(dyn Fn(&Tape, &Aabb) -> Option<Unproved> + Sync),
        run: &Run,
    ) -> Result<Self> {
        let Wanted { leaves, tape, bounds, size, more, places, most, block, wider, .. } = *wanted;
        let at_places = Bvh::new(places.to_vec());
        let longest = bounds.size().max_element() + MARGIN * size;
        let levels = (longest / size).log2().ceil().max(0.0);
        // Cells of this level are the smallest that all of the part may have. Below it there is as much room as numbers have.
        let room = f64::from(BITS - 2) - levels - f64::from(wanted.deeper);
        let floor = more.max(room.clamp(0.0, f64::from(FINER)) as u8);
        let deeper = wanted.deeper + floor;
        if !(levels + f64::from(deeper) < f64::from(BITS - 1)) {
            return Err(Error::Usage(format!("size {size} is too small for a part {longest} long")));
        }
        let level = levels as u8 + deeper;
        let root = Cube {
            at: [0; 3],
            level,
            children: NONE,
            tape: Some(tape.clone()),
            wide: Some(tape.clone()),
            shown: FirstLook::Nothing,
        };
        let unit = size / f64::from(1u32 << deeper);
        let near = block.map(|b| b.cubes(deeper, HALO));
        let wide = block.map(|b| Wide::new(&b, cells_along(&bounds, size), deeper, wider));
        let mut tree =
            Octree { origin: origin(&bounds, size), unit, deeper, cubes: vec![root], near, wide, before: None };
        tree.before = wanted.before.filter(|b| b.has_points_of(&tree)).cloned();
        if tape.ops.len() > MANY
            && let Some(block) = block
        {
            // A largest cell at the end of what is made asks as far as its side beyond.
            let [lo, hi] = block.cubes(deeper, HALO + 1);
            let corner = |c: [i64; 3]| tree.origin + DVec3::from_array(c.map(|c| c as f64)) * unit;
            let reached = Aabb::new(corner(lo), corner(hi)).grown(0.5 * size);
            tree.cubes[0].wide = pruned(tape, leaves, &reached, &mut Scratch::default());
        }
        let mut layer = vec![0u32];
        let mut points = Points::default();
        while !layer.is_empty() {
            run.check()?;
            if tree.cubes.len() > most {
                return Err(Error::Usage(format!("size {size} needs more than {most} cells")));
            }
            let tree_now = &tree;
            let judge = |i: &u32| {
                let c = &tree_now.cubes[*i as usize];
                let tape = c.tape.as_ref()?;
                if c.level > deeper && !tree_now.wide.as_ref().is_some_and(|w| w.holds(c)) {
                    return Some(Seen { cell: *i, may: true, shown: FirstLook::Nothing });
                }
                let own = tree_now.bounds(c.at, c.level);
                let may = c.level > floor || (c.level > floor - more && at_places.meets(&own));
                let look = || unproved(tape, &own).map_or(FirstLook::Simple, FirstLook::Open);
                let shown = || tree_now.shown_before(c).unwrap_or_else(look);
                (may || c.level == floor || points.holds(*i)).then(|| Seen { cell: *i, may, shown: shown() })
            };
            let mut seen: Vec<Seen> = lockstep::each(leaves, &layer, judge).into_iter().flatten().collect();
            seen.iter().for_each(|s| tree.cubes[s.cell as usize].shown = s.shown);
            seen.retain(|s| s.shown != FirstLook::Simple);
            let at_points = || seen.iter().filter_map(|s| Some((s.cell, s.unproved().filter(|u| Points::may_be(*u))?)));
            let level = tree.cubes[layer[0] as usize].level;
            if level == floor {
                points = Points::new(&tree, at_points(), wanted.deeper);
            } else if level < floor {
                points.keep(at_points().map(|s| s.0));
            }
            let halved = |s: &&Seen| s.may || (level > 0 && points.holds(s.cell));
            let split: Vec<u32> = seen.iter().filter(halved).map(|s| s.cell).collect();
            layer = tree.split(leaves, &split);
            points.go_on(&split, &layer);
        }
        // Where smaller cells are asked for they are not for what they prove.
        let asked = |i: &u32| {
            let c = &tree.cubes[*i as usize];
            at_places.meets(&tree.bounds(c.at, c.level))
        };
        let in_vain: Vec<u32> = points.in_vain().filter(|i| !asked(i)).collect();
        tree.make_whole(in_vain.into_iter());
        tree.balance(leaves, run)?;
        tree.before = None;
        Ok(tree)
    }

    /// What a first look showed of a cube in the grid before.
    fn shown_before(&self, c: &Cube) -> Option<FirstLook> {
        let before = self.before.as_ref()?;
        Some(before.cubes[before.at(c.at, c.level)? as usize].shown).filter(|s| *s != FirstLook::Nothing)
    }

    /// The cube of a level at a place, if there is one.
    fn at(&self, at: [u32; 3], level: u8) -> Option<u32> {
        let i = self.find(at.map(i64::from), level)?;
        let c = &self.cubes[i as usize];
        (c.level == level && c.at == at).then_some(i)
    }

    /// The cube that is one of another grid.
    pub(super) fn same(&self, other: &Octree, cell: u32) -> Option<u32> {
        let c = &other.cubes[cell as usize];
        self.at(c.at, c.level)
    }

    /// Whether cubes and points of another grid are these.
    pub(super) fn has_points_of(&self, other: &Octree) -> bool {
        (self.unit, self.deeper, self.origin) == (other.unit, other.deeper, other.origin)
    }

    /// Takes the children of some cubes away, and theirs.
    fn make_whole(&mut self, which: impl Iterator<Item = u32>) {
        let mut any = false;
        for i in which {
            any |= std::mem::replace(&mut self.cubes[i as usize].children, NONE) != NONE;
        }
        if !any {
            return;
        }
        let mut is_left = vec![false; self.cubes.len()];
        is_left[0] = true;
        // Children come after their parents.
        for i in 0..self.cubes.len() {
            let first = self.cubes[i].children as usize;
            if is_left[i] && first != NONE as usize {
                is_left[first..first + 8].fill(true);
            }
        }
        let mut numbers = vec![NONE; self.cubes.len()];
        (0..self.cubes.len()).filter(|i| is_left[*i]).zip(0..).for_each(|(i, number)| numbers[i] = number);
        let mut left = is_left.into_iter();
        self.cubes.retain(|_| left.next().unwrap_or(true));
        for c in &mut self.cubes {
            if c.children != NONE {
                c.children = numbers[c.children as usize];
            }
        }
    }

    /// Whether a cube is made at all.
    fn is_near(&self, at: [u32; 3], level: u8) -> bool {
        let Some([lo, hi]) = self.near else { return true };
        (0..3).all(|k| i64::from(at[k]) < hi[k] && i64::from(at[k]) + (1 << level) > lo[k])
    }

    /// Gives cubes children; the numbers of these.
    fn split(&mut self, leaves: &[Leaf], which: &[u32]) -> Vec<u32> {
        let made: Vec<[Cube; 8]> = lockstep::each_with(leaves, which, |scratch: &mut Scratch, i| {
            let c = &self.cubes[*i as usize];
            let level = c.level - 1;
            std::array::from_fn(|k| {
                let at = std::array::from_fn(|axis| c.at[axis] + ((k as u32 >> axis & 1) << level));
                let cube = Cube { at, level, children: NONE, tape: None, wide: None, shown: FirstLook::Nothing };
                if !self.is_near(at, level) {
                    return cube;
                }
                if let Some(known) = self.before.as_ref().and_then(|b| Some(&b.cubes[b.at(at, level)? as usize])) {
                    return Cube { tape: known.tape.clone(), wide: known.wide.clone(), ..cube };
                }
                let own = self.bounds(at, level);
                let mut held = |t: &Option<Arc<Tape>>, b: &Aabb| pruned(t.as_ref()?, leaves, b, scratch);
                let tape = held(&c.tape, &own);
                let wide = held(&c.wide, &own.grown(own.hi.x - own.lo.x));
                Cube { tape, wide, ..cube }
            })
        });
        let mut children = Vec::with_capacity(8 * made.len());
        for (i, eight) in which.iter().zip(made) {
            let first = self.cubes.len() as u32;
            self.cubes[*i as usize].children = first;
            children.extend(first..first + 8);
            self.cubes.extend(eight);
        }
        children
    }

    /// The smallest cube, of no lower level than `least`, that holds a unit cube.
    fn find(&self, at: [i64; 3], least: u8) -> Option<u32> {
        let top = &self.cubes[0];
        if at.iter().any(|c| *c < 0 || *c >= 1 << top.level) {
            return None;
        }
        let mut i = 0;
        loop {
            let c = &self.cubes[i as usize];
            if c.children == NONE || c.level <= least {
                return Some(i);
            }
            let bit = c.level - 1;
            let child = (0..3).fold(0, |m, k| m | ((at[k] >> bit & 1) as u32) << k);
            i = c.children + child;
        }
    }

    /// Halves cubes until neighbors across faces differ by one level at most, where either may hold the surface.
    fn balance(&mut self, leaves: &[Leaf], run: &Run) -> Result<()> {
        let mut layer: Vec<u32> =
            (0..self.cubes.len() as u32).filter(|i| self.cubes[*i as usize].children == NONE).collect();
        while !layer.is_empty() {
            run.check()?;
            let tree = &*self;
            let mut coarse: Vec<u32> = layer
                .par_iter()
                .flat_map_iter(|i| {
                    let c = &tree.cubes[*i as usize];
                    let side = 1i64 << c.level;
                    let at = c.at.map(i64::from);
                    (0..6).filter_map(move |f| {
                        let mut n = at;
                        n[f / 2] += if f % 2 == 0 { -1 } else { side };
                        let j = tree.find(n, c.level)?;
                        (c.children == NONE && tree.cubes[j as usize].level > c.level + 1).then_some(j)
                    })
                })
                .collect();
            coarse.sort_unstable();
            coarse.dedup();
            let made = self.split(leaves, &coarse);
            // What was too fine may be so again.
            layer.retain(|i| self.cubes[*i as usize].children == NONE);
            if coarse.is_empty() {
                break;
            }
            layer.extend(made);
        }
        Ok(())
    }

    /// All tetrahedra of which one cell at least may hold some of the surface.
    pub(super) fn tetrahedra(&self) -> Vec<Tetrahedron> {
        let mut out = Vec::new();
        self.cell(0, &mut out);
        out
    }

    /// Whether a cell may hold some of the surface, and is not halved.
    pub(super) fn held(&self, i: u32) -> bool {
        let c = &self.cubes[i as usize];
        c.children == NONE && c.tape.is_some()
    }

    /// Whether a cell is within so many largest cells of a block.
    pub(super) fn is_beside(&self, i: u32, block: &GridBlock, deeper: u8, by: i64) -> bool {
        let [lo, hi] = block.cubes(deeper, by);
        let c = &self.cubes[i as usize];
        (0..3).all(|k| i64::from(c.at[k]) < hi[k] && i64::from(c.at[k]) + (1 << c.level) > lo[k])
    }

    fn is_leaf(&self, i: u32) -> bool {
        self.cubes[i as usize].children == NONE
    }

    /// The child of a cube, or the cube itself if it has none.
    fn child(&self, i: u32, bits: u32) -> u32 {
        let c = self.cubes[i as usize].children;
        if c == NONE { i } else { c + bits }
    }

    fn cell(&self, i: u32, out: &mut Vec<Tetrahedron>) {
        if self.is_leaf(i) {
            return;
        }
        for k in 0..8 {
            self.cell(self.child(i, k), out);
        }
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            for k in 0..4 {
                let bits = (k & 1) << b | (k >> 1) << c;
                self.face(axis, [self.child(i, bits), self.child(i, bits | 1 << axis)], out);
            }
            for half in 0..2 {
                let around = std::array::from_fn(|k| {
                    let k = k as u32;
                    self.child(i, half << axis | (k & 1) << b | (k >> 1) << c)
                });
                self.edge(axis, around, out);
            }
        }
    }

    fn face(&self, axis: usize, pair: [u32; 2], out: &mut Vec<Tetrahedron>) {
        if pair.iter().all(|i| self.is_leaf(*i)) {
            return;
        }
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for k in 0..4u32 {
            let bits = (k & 1) << b | (k >> 1) << c;
            self.face(axis, [self.child(pair[0], bits | 1 << axis), self.child(pair[1], bits)], out);
        }
        for (along, other) in [(b, c), (c, b)] {
            for half in 0..2u32 {
                let mut around = [0; 4];
                for side in 0..2u32 {
                    for far in 0..2u32 {
                        let bits = half << along | far << other | (1 - side) << axis;
                        let first = (along + 1) % 3;
                        let slot = if axis == first { side | far << 1 } else { far | side << 1 };
                        around[slot as usize] = self.child(pair[side as usize], bits);
                    }
                }
                self.edge(along, around, out);
            }
        }
    }

    /// Four cubes around an edge along an axis, by the bits of the two axes that follow it.
    fn edge(&self, axis: usize, around: [u32; 4], out: &mut Vec<Tetrahedron>) {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        if !around.iter().all(|i| self.is_leaf(*i)) {
            for half in 0..2u32 {
                let inner = std::array::from_fn(|k| {
                    let k = k as u32;
                    self.child(around[k as usize], half << axis | (1 - (k & 1)) << b | (1 - (k >> 1)) << c)
                });
                self.edge(axis, inner, out);
            }
            return;
        }
        if around.iter().all(|i| self.cubes[*i as usize].tape.is_none()) {
            return;
        }
        let k = (0..4).min_by_key(|k| self.cubes[around[*k] as usize].level).unwrap_or(0);
        let small = &self.cubes[around[k] as usize];
        let side = 1u64 << small.level;
        let mut end = small.at.map(|x| 2 * u64::from(x));
        end[b] += if k & 1 == 0 { 2 * side } else { 0 };
        end[c] += if k >> 1 == 0 { 2 * side } else { 0 };
        let mut other = end;
        other[axis] += 2 * side;
        for (x, y) in [(0, 1), (1, 3), (3, 2), (2, 0)] {
            let (i, j) = (around[x], around[y]);
            let (p, q) = (&self.cubes[i as usize], &self.cubes[j as usize]);
            if i == j || (p.tape.is_none() && q.tape.is_none()) {
                continue;
            }
            let center = |c: &Cube| c.at.map(|x| 2 * u64::from(x) + (1 << c.level));
            let mut corners = [center(p), center(q), end, other];
            if volume(&corners) < 0 {
                corners.swap(2, 3);
            }
            // By place, not by number: in a block of the grid it is the same.
            let owner = if (q.level, q.at) < (p.level, p.at) { j } else { i };
            out.push(Tetrahedron { owner, corners: corners.map(Point::new) });
        }
    }
}

fn volume(p: &[[u64; 3]; 4]) -> i128 {
    let d = |k: usize| std::array::from_fn::<i128, 3, _>(|i| i128::from(p[k][i]) - i128::from(p[0][i]));
    let (a, b, c) = (d(1), d(2), d(3));
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}
