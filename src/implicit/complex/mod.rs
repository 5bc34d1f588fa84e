//! The arrangement of a solid's leaves on an adaptive grid, and its boundary.
//!
//! To extract a surface and look for its edges afterwards finds edges that the surface need not have. This goes the other way
//! round: the grid adapts until intervals show that the leaves in each cell are arranged as planes are, or a floor is reached.
//! In each of its tetrahedra the leaves' linear interpolants cut space into cells; what bounds the cells that are inside is the
//! mesh. Nodes then go to where their leaves vanish.
//!
//! *Guarantees*: a closed, oriented manifold before nodes move, whatever the leaves do: solids that touch along edges or in
//! points are parted there. Every triangle lies on one leaf, every border on two, every corner on three. The same bytes for any
//! number of threads. Places that were not proved are listed with the reason.
//! *Does not guarantee*: that no triangles intersect after nodes moved; that borders are where the leaves meet in cells that
//! were not proved. Leaves known only point by point (closures, blends as one function) are seen at corners of cells, not proved.
//!
//! References: Du, Zhou, Carr, Ju, Robust computation of implicit surface networks for piecewise linear functions (ACM TOG
//! 2022); Ju, Du, Zhou, Carr, Ju, Adaptive grid generation for discretizing implicit complexes (ACM TOG 2024). Here the grid is
//! an octree with tetrahedra between centers of neighbors, proofs are by intervals, and nodes are exact.

mod assemble;
mod cell;
mod chains;
mod differences;
mod exact;
mod grid;
mod guises;
mod islands;
mod points;
mod proof;
mod recall;
mod retreat;
mod settle;
mod shared;
#[cfg(test)]
mod tests;
mod twins;
mod uncrossed;

use std::iter::once;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::deciding::Deciding;
use super::leaf::Leaf;
use super::lockstep;
use super::model::Implicit;
use super::newton::leaves_of;
use super::tape::{Op, Tape};
use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::Aabb;
use assemble::{Key, Skin, Triangle, at_ends, divided, is_closed, parted, walls};
use cell::{Boolean, Crossed, Named};
use differences::Differences;
pub(crate) use grid::{GridBlock, cells_along, origin};
use grid::{Octree, Tetrahedron, Wanted};
use guises::{Guises, Seeds};
pub use proof::Unproved;
use proof::{Asked, Judged, judged};
use recall::Recall;
use settle::{Common, Nodes};
use shared::{Curves, Shared, beside, existing, with};
use twins::Twins;
use uncrossed::Boundary;

/// How often cells of the size asked for are halved where the leaves are not shown to be arranged simply: down to a 16th, which shows pins and gaps
/// a 20th of a cell wide, as in `data/small_features.py`.
const DEEPER: u8 = 4;

/// Bytes a cell takes with its share of tetrahedra and mesh, measured on `data/lattice.py`.
const BYTES_PER_CELL: u64 = 4_000;

/// So many largest cells beside a block are arranged with it: all triangles around a node where blocks meet are in them, and such
/// nodes move as they do in the block beside.
const BESIDE: i64 = 1;

/// Groups of tetrahedra that are worked on at a time: enough for threads to share, few enough to join.
const GROUPS: usize = 256;

/// A mesh in which every triangle lies on one leaf.
#[derive(Debug, Clone)]
pub(crate) struct PiecedMesh {
    /// Labels are the leaves. Nodes lie on their leaves to rounding, but for those at points without a normal.
    pub(crate) mesh: TriMesh,
    /// For each node the leaves it lies on: one inside a face, two on an edge, more at a corner.
    pub(crate) leaves: Vec<Vec<u32>>,
    /// For each triangle its face, by number.
    pub(crate) faces: Vec<u32>,
}

/// The boundary of a solid from the arrangement of its leaves.
#[derive(Debug, Clone)]
pub(crate) struct Arranged {
    /// The mesh and the leaves of its nodes.
    pub(crate) made: PiecedMesh,
    /// Whether the solid touches itself along edges or in points.
    pub(crate) touches: bool,
    /// Cells of the grid that hold some of the surface.
    pub(crate) cells: usize,
    /// Those in which the arrangement is not proved.
    pub(crate) unproved: Vec<OpenCell>,
    /// Where its triangles cross, with the lengths of edges there; not looked for where all is proved, and of a block.
    pub(crate) crossed: Vec<(Aabb, f64)>,
    /// Nodes whose leaves do not vanish nearby; they are where the linear interpolants vanish.
    pub(crate) astray: Vec<u32>,
    /// Where the linear interpolants vanish, for each node; empty of a block.
    linear: Vec<DVec3>,
    /// What else is known of its cells, where some are not proved; not of a block.
    known: Option<Arc<Recall>>,
    /// Nodes where a block ends, ascending, and by what they are known to the blocks beside it.
    pub(crate) ends: Vec<(u32, EndKey)>,
}

/// A cell in which the arrangement is not proved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpenCell {
    pub(crate) cell: Aabb,
    pub(crate) reason: Unproved,
}

/// What a node where blocks meet is to all of them: three points of the grid, and two leaves by their numbers.
pub(crate) type EndKey = [u64; 4];

impl Arranged {
    /// Forgets what only another arrangement needs: see [`CellGrid::before`].
    pub(crate) fn forget(&mut self) {
        self.known = None;
    }
}

/// A grid to arrange leaves on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellGrid<'a> {
    /// The side of cells that are larger than all that is to be seen.
    pub(crate) size: f64,
    /// How often larger ones may be halved down to that: where less shows that the leaves are arranged simply they stay large. Of a
    /// block only where no block beside it makes the same cells.
    pub(crate) coarser: u8,
    /// Places where smaller cells may be halved this often more than elsewhere.
    pub(crate) places: &'a [Aabb],
    pub(crate) more: u8,
    /// What is wanted of it, if not all: by cells of that size.
    pub(crate) block: Option<GridBlock>,
    /// An arrangement of the same solid on the same grid but for places: what is known of cells there is not asked for again, and nothing comes
    /// out another way for that.
    pub(crate) before: Option<&'a Arranged>,
}

/// The boundary of a solid on a grid of cells of about a size, smaller where that shows more.
///
/// Of a block of the grid it is what all of the grid would give in its tetrahedra, node by node, but for patches of hidden surfaces: in a
/// block they stay, as none is seen whole. Where it ends nodes come out bit by bit as in the block beside.
///
/// Errors: cells too small for the part, or for `memory` bytes; cancellation.
pub(crate) fn arranged(model: &Implicit, grid: &CellGrid<'_>, memory: u64, run: &Run) -> Result<Arranged> {
    let CellGrid { size: seen, coarser, places, more, block, before } = *grid;
    let before = before.and_then(|b| b.known.as_deref());
    // Blocks are told apart by the cells that all of them have along their ends.
    let (halved, wider) = if block.is_some() { (0, coarser) } else { (coarser, 0) };
    let size = seen * f64::from(1u32 << halved);
    run.install(|| {
        let others = in_cells(&model.leaves, seen);
        let (leaves, scale) = (others.as_deref().unwrap_or(&model.leaves), model.bounds().diagonal());
        let twins = Twins::new(leaves);
        let (twins, differences) = (&twins, &Differences::default());
        let most = (memory / BYTES_PER_CELL) as usize;
        let (bounds, tape, deeper) = (model.bounds(), &model.tape, DEEPER + halved);
        let wanted = Wanted {
            leaves,
            tape,
            bounds,
            size,
            deeper,
            more,
            places,
            most,
            block,
            wider,
            before: before.map(|k| &k.tree),
        };
        run.progress("cells", 0.0);
        let tree = Octree::build(
            &wanted,
            &|t, b| judged(t, &Asked { leaves, twins, differences, cell: *b, scale, seen, briefly: true }).unproved,
            run,
        )?;
        let before = before.filter(|b| b.tree.has_points_of(&tree));
        let deeper = tree.deeper;
        let asked_of = |i: &u32| tree.held(*i) && block.is_none_or(|b| tree.is_beside(*i, &b, deeper, BESIDE + 1));
        let held: Vec<u32> = (0..tree.cubes.len() as u32).filter(asked_of).collect();
        let box_of = |i: &u32| tree.bounds(tree.cubes[*i as usize].at, tree.cubes[*i as usize].level);
        let known = lockstep::each(leaves, &held, |i| {
            let asked = Asked { leaves, twins, differences, cell: box_of(i), scale, seen, briefly: false };
            if let Some(known) = before.and_then(|b| b.judged(&tree, *i)) {
                return Some(known.clone());
            }
            Some(judged(tree.cubes[*i as usize].tape.as_ref()?, &asked))
        });
        let known: Vec<Judged> = known.into_iter().flatten().collect();
        let open = |(i, j): (&u32, &Judged)| Some(OpenCell { cell: box_of(i), reason: j.unproved? });
        let unproved: Vec<OpenCell> = held.iter().zip(&known).filter_map(open).collect();
        let with_curves = held.iter().zip(&known).filter(|x| !x.1.shared.is_empty());
        let with_curves: FxHashMap<u32, Vec<Shared>> = with_curves.map(|(i, j)| (*i, j.shared.clone())).collect();
        let mut tetrahedra = tree.tetrahedra();
        let curves = Curves::new(&tetrahedra, &with_curves);
        if let Some(block) = &block {
            tetrahedra.retain(|t| t.is_in(block, deeper, BESIDE));
        }
        tetrahedra.par_sort_by_key(|t| t.owner);
        let groups: Vec<&[Tetrahedron]> = tetrahedra.chunk_by(|a, b| a.owner == b.owner).collect();
        run.progress("arrange", 0.0);
        let share = Share { groups: &groups, twins, deeper, block };
        let mut all = skin(leaves, &tree, &curves, &share, run)?;
        if !curves.is_empty() && !is_closed(&all.triangles, block.is_some()) {
            // Some sliver goes on where its curve was not seen.
            all = skin(leaves, &tree, &Curves::default(), &share, run)?;
        }
        run.check()?;
        run.progress("settle", 0.0);
        let Skin { mut keys, mut places, mut triangles, .. } = all;
        divided(&mut keys, &mut places, &mut triangles);
        let copies = parted(&places, &mut triangles);
        let on: Vec<Vec<u32>> = copies.iter().map(|c| keys[*c as usize].on()).collect();
        let reach: Vec<f64> = copies.iter().map(|c| extent(&tree, &keys[*c as usize])).collect();
        let places: Vec<DVec3> = copies.iter().map(|c| places[*c as usize]).collect();
        let names: Vec<Key> = copies.iter().map(|c| keys[*c as usize]).collect();
        let stay = if block.is_some() { at_ends(&triangles) } else { Vec::new() };
        let walls = if block.is_some() { walls(&triangles, places.len()) } else { Vec::new() };
        let common = block.is_some().then_some(Common { names: &names, walls: &walls });
        let linear: Vec<DVec3> = if block.is_some() { Vec::new() } else { Vec::clone(&places) };
        let mut nodes = Nodes { places, on: &on, reach: &reach, leaves, scale, stay: &stay, common };
        let astray = nodes.settle();
        let is_kept = block.is_none() && !unproved.is_empty();
        let known = is_kept.then(|| Arc::new(Recall { tree: Arc::new(tree), held: held.clone(), judged: known }));
        let mut made = Boundary { places: nodes.places, on, triangles, astray, crossed: Vec::new() };
        let guises = Guises { leaves, tape, linear: &linear, reach: &reach, scale };
        if block.is_none() {
            guises.lift(&mut made, Seeds::Astray);
        }
        let places = std::mem::take(&mut made.places);
        let mut nodes = Nodes { places, on: &made.on, reach: &reach, leaves, scale, stay: &stay, common };
        nodes.untangle(&made.triangles, run)?;
        made.places = nodes.places;
        let mut dropped = made.drop_islands();
        // Where all is proved it is chords that cross, which shorter edges part.
        if is_kept {
            made.find_crossings(run)?;
            // Where most is not proved surfaces lie on each other all over.
            if !made.crossed.is_empty()
                && 2 * unproved.len() <= held.len()
                && let Some(better) = guises.uncrossed(&made, run)?
            {
                made = better;
                dropped |= made.drop_islands();
            }
        }
        let Boundary { mut places, mut on, mut triangles, mut astray, crossed } = made;
        let mut linear = linear;
        let mut ends = Vec::new();
        if dropped || block.is_some() {
            let kept = own_nodes(&mut triangles, places.len());
            ends = at_ends(&triangles).into_iter().map(|v| (v, names[kept[v as usize] as usize].packed())).collect();
            places = kept.iter().map(|v| places[*v as usize]).collect();
            linear = if linear.is_empty() { linear } else { kept.iter().map(|v| linear[*v as usize]).collect() };
            on = kept.iter().map(|v| std::mem::take(&mut on[*v as usize])).collect();
            astray = astray.iter().filter_map(|v| kept.binary_search(v).ok().map(|k| k as u32)).collect();
        }
        let faces = triangles.iter().map(|t| t.face).collect();
        let mesh = TriMesh {
            nodes: places,
            triangles: triangles.iter().map(|t| t.nodes).collect(),
            labels: triangles.iter().map(|t| t.leaf).collect(),
            // There may be as many blocks as leaves, and nobody asks a block for names.
            faces: (0..leaves.len())
                .map(|l| if block.is_some() { String::new() } else { format!("leaf{l}") })
                .collect(),
            ..TriMesh::default()
        };
        Ok(Arranged {
            made: PiecedMesh { mesh, leaves: on, faces },
            touches: copies.len() > keys.len(),
            cells: held.len(),
            unproved,
            crossed,
            astray,
            linear,
            known,
            ends,
        })
    })
}

/// The leaves as they are taken in cells of about a size, if that is another for any of them.
fn in_cells(leaves: &[Leaf], size: f64) -> Option<Vec<Leaf>> {
    let others: Vec<Option<Leaf>> = leaves.iter().map(|l| l.in_cells(size)).collect();
    let one = |(other, leaf): (Option<Leaf>, &Leaf)| other.unwrap_or_else(|| leaf.clone());
    others.iter().any(Option::is_some).then(|| others.into_iter().zip(leaves).map(one).collect())
}

/// Drops triangles beside a block. The nodes that are left, ascending, in the order of their new numbers.
fn own_nodes(triangles: &mut Vec<Triangle>, count: usize) -> Vec<u32> {
    triangles.retain(Triangle::is_own);
    let mut used = vec![false; count];
    triangles.iter().flat_map(|t| t.nodes).for_each(|v| used[v as usize] = true);
    let kept: Vec<u32> = (0..count as u32).filter(|v| used[*v as usize]).collect();
    let mut number = vec![0; count];
    kept.iter().zip(0..).for_each(|(v, k)| number[*v as usize] = k);
    triangles.iter_mut().for_each(|t| t.nodes = t.nodes.map(|v| number[v as usize]));
    kept
}

/// What there is to arrange: tetrahedra by their owners, and the block of them that is asked for.
struct Share<'a> {
    groups: &'a [&'a [Tetrahedron]],
    twins: &'a Twins,
    /// How often the largest cells may be halved.
    deeper: u8,
    block: Option<GridBlock>,
}

/// The boundary in all tetrahedra.
fn skin(leaves: &[Leaf], tree: &Octree, curves: &Curves, share: &Share<'_>, run: &Run) -> Result<Skin> {
    let Share { groups, twins, deeper, block } = share;
    let pieces: Result<Vec<Skin>> = groups
        .par_chunks(GROUPS)
        .map(|some| {
            run.check()?;
            let mut piece = Skin::default();
            let values = lockstep::together(some.len(), |i| corner_values(leaves, tree, some[i]));
            some.iter().zip(values).try_for_each(|(g, values)| {
                within(&Around { twins, tree, curves, deeper: *deeper, block: *block }, g, values, &mut piece)
            })?;
            Ok(piece)
        })
        .collect();
    let mut all = Skin::default();
    pieces?.iter().for_each(|p| all.append(p));
    Ok(all)
}

/// The size of the simplex a node was made in.
fn extent(tree: &Octree, key: &Key) -> f64 {
    let corners: Vec<DVec3> = key.corners().map(|p| tree.point(p)).collect();
    let longest = |a: &DVec3| corners.iter().map(|b| a.distance(*b)).fold(0.0, f64::max);
    corners.iter().map(longest).fold(0.0, f64::max)
}

/// What is known in all tetrahedra.
struct Around<'a> {
    twins: &'a Twins,
    tree: &'a Octree,
    curves: &'a Curves,
    deeper: u8,
    block: Option<GridBlock>,
}

/// The corners of the tetrahedra that one cell owns.
fn corners_of(group: &[Tetrahedron]) -> Vec<grid::Point> {
    let mut points: Vec<grid::Point> = group.iter().flat_map(|t| t.corners).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// The values of all leaves in a cell at these corners, leaf by leaf.
fn corner_values(leaves: &[Leaf], tree: &Octree, group: &[Tetrahedron]) -> Vec<f64> {
    let Some(tape) = &tree.cubes[group[0].owner as usize].wide else { return Vec::new() };
    let mine = leaves_of(tape);
    let at: Vec<DVec3> = corners_of(group).iter().map(|p| tree.point(*p)).collect();
    let along = |k: usize| at.iter().map(|p| p[k]).collect::<Vec<f64>>();
    let (xs, ys, zs) = (along(0), along(1), along(2));
    let mut values = vec![0.0; at.len() * mine.len()];
    for (l, values) in mine.iter().zip(values.chunks_mut(at.len())) {
        leaves[*l as usize].eval(&xs, &ys, &zs, values);
    }
    values
}

/// The boundary in the tetrahedra that one cell owns, from the values at their corners.
fn within(around: &Around<'_>, group: &[Tetrahedron], values: Vec<f64>, out: &mut Skin) -> Result<()> {
    let Around { twins, tree, curves, deeper, block } = around;
    let Some(tape) = &tree.cubes[group[0].owner as usize].wide else { return Ok(()) };
    let tape: &Tape = tape;
    let mine = leaves_of(tape);
    let points = corners_of(group);
    let n = points.len();
    let (mut cutting, mut cut_values, mut fixed) = (Vec::new(), Vec::new(), vec![false; mine.len()]);
    let (mut deciding, mut open) = (Deciding::default(), Vec::new());
    for t in group {
        let corners = t.corners.map(|p| points.binary_search(&p).unwrap_or(0));
        cutting.clear();
        cut_values.clear();
        for (k, l) in mine.iter().enumerate() {
            let v = corners.map(|i| values[k * n + i]);
            // The rule for ties: zero is positive.
            let plus = v.map(|v| v >= 0.0);
            fixed[k] = plus[0];
            if plus != [plus[0]; 4] {
                cutting.push(*l);
                cut_values.push(v);
            }
        }
        if cutting.is_empty() {
            continue;
        }
        let near = curves.near(t, &mine);
        // Leaves whose sides make no difference beside those that do not pass here would cut the others into pieces for nothing.
        if cutting.len() > 1 {
            let is_open = |l: u32| cutting.binary_search(&l).is_ok() || near.iter().any(|s| s.leaves.contains(&l));
            deciding.ask(tape, |l, negate| (!is_open(l)).then(|| fixed[mine.binary_search(&l).unwrap_or(0)] != negate));
            open.clear();
            open.extend(tape.ops.iter().enumerate().filter_map(|(i, op)| match op {
                Op::Leaf { leaf, .. } if deciding.decides(i) => Some(*leaf),
                _ => None,
            }));
            let mut kept = cutting.iter().map(|l| open.contains(l));
            cut_values.retain(|_| kept.next().unwrap_or(true));
            cutting.retain(|l| open.contains(l));
            if cutting.is_empty() {
                continue;
            }
        }
        if cutting.len() > MOST_CUTTING {
            let at = tree.point(t.corners[0]);
            return Err(Error::Failed(format!("more than {MOST_CUTTING} surfaces pass a cell near {at}")));
        }
        let same = twins.taken_out(&mut cutting, &mut cut_values);
        let first = |leaf: u32| same.iter().find(|t| t.leaf == leaf).map_or(leaf, |t| t.first);
        let cut = Crossed { leaves: &cutting, values: &cut_values };
        let positive = |leaf: u32, sides: &[bool]| match cutting.binary_search(&first(leaf)) {
            Ok(k) => sides[k],
            Err(_) => fixed[mine.binary_search(&leaf).unwrap_or(0)],
        };
        let of = |sides: shared::Sides<'_>| tape.inside_by(sides);
        let facets = cut.boundary(&Boolean {
            inside: &|sides| {
                let sides = |l: u32| positive(l, sides);
                let changed = existing(&near, &of, &sides);
                of(&|l| with(&changed, &sides, l))
            },
            named: &|leaf, sides| {
                let leaf = cutting[leaf as usize];
                let other = beside(&near, &of, leaf, &|l| positive(l, sides));
                let sides = |l: u32| positive(l, sides) != (Some(l) == other);
                // Of twins the one that makes the boundary alone.
                let alone = |which: &u32| of(&|l| sides(l) != (l == *which)) != of(&sides);
                let others = same.iter().filter(|t| t.first == leaf).map(|t| t.leaf);
                let leaf = if same.is_empty() { leaf } else { once(leaf).chain(others).find(alone).unwrap_or(leaf) };
                Named { leaf, face: tape.owner(leaf, &sides) }
            },
        });
        out.side = block.map_or([0; 3], |b| t.side(b.cubes(*deeper, 0)));
        out.add(tree, &t.corners, &cut, &facets);
    }
    Ok(())
}

/// Leaves that may cut one tetrahedron: their places in a list are bytes, with room for faces beside them. With twenty there is
/// no more to be told apart.
const MOST_CUTTING: usize = 200;
