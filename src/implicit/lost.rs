//! Points of the surface where an extraction may have missed it: features smaller than the cells, found by intervals.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::apex::apexes;
use super::extract::Extracted;
use super::leaf::Leaf;
use super::model::Implicit;
use super::newton::{Meeting, nearest};
use super::octree::{BRICK, Cell, key};
use super::tape::{Op, Pruned, Scratch, Tape};
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::{Interval, Sets};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Boxes in which no point is found are halved until they are this share of a cell (as a power of two).
const DEEPER: u32 = 2;
/// Boxes looked at in one brick.
const MOST_BOXES: usize = 20_000;
/// Patches of the extraction with at most this many triangles are small.
const FEW: usize = 24;
/// A leaf is met with this many others.
const MOST_OTHERS: usize = 6;
/// A point this share of a box beside it is in it.
const BESIDE: f64 = 1e-9;
/// On the two sides of a surface, this share of the part's size away from it, are inside and outside: faces that touch to
/// rounding bound nothing.
const APART: f64 = 1e-9;

/// Faces that meet in an angle of a smaller sine go the same way.
const ALIKE: f64 = 1e-4;

/// Sheets and slits thinner than this share of the part are what coordinates that should be equal leave.
const THINNEST: f64 = 1e-7;

/// A point of the solid's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    pub(crate) at: DVec3,
    /// Index of the face it is on.
    pub(crate) face: u32,
}

impl SurfacePoint {
    /// Whether the solid, or what is outside of it, is so thin here that it is a matter of rounding: nothing a [`THINNEST`] of the part away
    /// is on another side than the rest. A sheet along the face that is no thicker than rounding is on the side of what it lies in.
    pub(crate) fn is_in_passing(&self, model: &Implicit) -> bool {
        let scale = model.bounds().diagonal();
        let across = |op: &Op| match op {
            Op::Leaf { leaf, face, .. } if *face == self.face => {
                let leaf = &model.leaves[*leaf as usize];
                leaf.passes(self.at, APART * scale).then(|| leaf.slope(self.at).normalize_or_zero() * APART * scale)
            }
            _ => None,
        };
        let across: Vec<DVec3> = model.tape.ops.iter().filter_map(across).collect();
        let is_inside = |p: DVec3| {
            let here = model.inside(p);
            let is_sheet = |d: &DVec3| model.inside(p + *d) != here && model.inside(p - *d) != here;
            here != across.iter().any(is_sheet)
        };
        let beside = |k: usize| DVec3::new((k % 3) as f64 - 1.0, (k / 3 % 3) as f64 - 1.0, (k / 9) as f64 - 1.0);
        let places = (0..27).filter(|k| *k != 13).map(|k| self.at + THINNEST * scale * beside(k).normalize());
        let inside = places.filter(|p| is_inside(*p)).count();
        inside == 0 || inside == 26
    }

    /// Whether it is on its face and no other face goes the same way there, to rounding: faces that touch, or lie in each other, have their points in
    /// common.
    pub(crate) fn is_alone(&self, model: &Implicit, extracted: &Extracted) -> bool {
        let scale = model.bounds().diagonal();
        // Of each leaf that is there, which way it goes.
        let there = |op: &Op| match op {
            Op::Leaf { leaf, face, .. } => {
                let leaf = &model.leaves[*leaf as usize];
                leaf.passes(self.at, APART * scale).then(|| (*face, leaf.slope(self.at).normalize_or_zero()))
            }
            _ => None,
        };
        let all: Vec<(u32, DVec3)> = extracted.tape_at(model, self.at).ops.iter().filter_map(there).collect();
        let (own, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|x| x.0 == self.face);
        // Nodes of small patches need not be on the face these were taken for.
        !own.is_empty() && !others.iter().any(|o| own.iter().any(|x| x.1.cross(o.1).length() < ALIKE))
    }
}

/// Looks for the surface where marching cubes may not have seen it: in bricks whose corners all have one sign, and on
/// faces that, by intervals, may come through a brick and have no triangle there or next to it; on faces of formulas, which
/// may have many pieces, in cells without triangles within a brick too. One point for each face in each cell that holds one
/// near its middle. Also the nodes of faces of few triangles, and apexes. With boxes `within` it is looked for in these only, as
/// elsewhere an arrangement is proved.
///
/// Not found: what is smaller than the cells on a face of a primitive that has triangles within a brick, and formulas on
/// whose zeros Newton's method does not settle.
pub(crate) fn surface_points(
    model: &Implicit,
    extracted: &Extracted,
    within: Option<&[Aabb]>,
    run: &Run,
) -> Result<Vec<SurfacePoint>> {
    // What is known of closures was seen at points, which prove nothing.
    let is_seen_only = |l: &Leaf| l.slopes(&model.bounds()).is_none();
    let within = within.filter(|_| !model.leaves.iter().any(is_seen_only)).map(|boxes| Bvh::new(boxes.to_vec()));
    let sight = Sight { model, extracted, within: within.as_ref(), run };
    let small = small_patches(&extracted.mesh);
    let seen = Seen::new(model, extracted, &small);
    run.install(|| {
        let empty = extracted.undecided.par_iter().map(|c| points(&sight, c, None));
        let crossed = extracted.bricks.cells.par_iter().map(|c| {
            let wanted = seen.wanted(c);
            if wanted.is_empty() { Ok(Vec::new()) } else { points(&sight, c, Some(&wanted)) }
        });
        let found: Vec<Vec<SurfacePoint>> = empty.chain(crossed).collect::<Result<_>>()?;
        let mut found: Vec<SurfacePoint> = found.into_iter().flatten().collect();
        let mesh = &extracted.mesh;
        // Nodes that found no place on their leaves are not points of the surface.
        let scale = model.bounds().diagonal();
        let is_there = |x: &SurfacePoint| {
            extracted.tape_at(model, x.at).ops.iter().any(|op| match op {
                Op::Leaf { leaf, .. } => model.leaves[*leaf as usize].vanishes(x.at, APART * scale),
                _ => false,
            })
        };
        let nodes = |t: usize| mesh.corners(t).map(|at| SurfacePoint { at, face: mesh.labels[t] });
        found.extend((0..small.len()).filter(|t| small[*t]).flat_map(nodes).filter(is_there));
        // Tips get narrower than any cell.
        found.extend(apexes(model).into_iter().filter_map(|(i, at)| {
            let face =
                |op: &Op| if let Op::Leaf { leaf, face, .. } = op { (*leaf == i).then_some(*face) } else { None };
            model.tape.ops.iter().find_map(face).map(|face| SurfacePoint { at, face })
        }));
        Ok(found)
    })
}

/// Which triangles are in patches of one face that have few: remeshing may lose them, and cells may show a face by them that
/// is elsewhere.
fn small_patches(mesh: &TriMesh) -> Vec<bool> {
    let mut sets = Sets::new(mesh.triangles.len());
    // The last two triangles seen at each node, of different faces: at most nodes two faces meet.
    let mut last = vec![[u32::MAX; 2]; mesh.nodes.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let label = mesh.labels[t];
        for v in triangle {
            let own = &mut last[*v as usize];
            match own.iter().position(|o| *o != u32::MAX && mesh.labels[*o as usize] == label) {
                Some(k) => sets.join(own[k], t as u32),
                None => *own = [t as u32, own[0]],
            }
        }
    }
    let (set, count) = sets.numbers();
    let mut size = vec![0; count];
    set.iter().for_each(|s| size[*s as usize] += 1);
    set.iter().map(|s| size[*s as usize] <= FEW).collect()
}

/// Where each face has triangles, those of small patches left out.
struct Seen {
    /// Which faces have some, by brick.
    faces: FxHashMap<u64, Vec<u32>>,
    /// In which cells of a brick a face of formulas has some.
    cells: FxHashMap<u64, Layers>,
    /// Which faces may be in several pieces: those of formulas.
    wavy: Vec<bool>,
}

/// The cells of a brick, a bit each, by layers.
type Layers = [u64; BRICK];

/// Where in a brick the surface is looked for.
struct Wanted {
    /// Faces without triangles in the brick or next to it: in all cells.
    unseen: Vec<u32>,
    /// Others of formulas: but for these cells, which have triangles of such faces or are next to some.
    wavy: Vec<u32>,
    near: Layers,
}

impl Wanted {
    fn is_empty(&self) -> bool {
        self.unseen.is_empty() && (self.wavy.is_empty() || self.near.iter().all(|l| *l == u64::MAX))
    }

    /// Whether a face is wanted in a cube of cells, given by its first and its side in cells.
    fn has(&self, face: u32, at: [usize; 3], side: usize) -> bool {
        let row = ((1u64 << side) - 1) << at[0];
        let rows = (at[1]..at[1] + side).fold(0, |r, y| r | row << (BRICK * y));
        self.unseen.contains(&face)
            || self.wavy.contains(&face) && self.near[at[2]..at[2] + side].iter().any(|l| l & rows != rows)
    }
}

impl Seen {
    fn new(model: &Implicit, extracted: &Extracted, small: &[bool]) -> Self {
        let (mesh, grid) = (&extracted.mesh, &extracted.bricks.grid);
        let mut wavy = vec![false; model.faces().len()];
        for op in &model.tape.ops {
            if let Op::Leaf { leaf, face, .. } = op {
                wavy[*face as usize] |= matches!(model.leaves[*leaf as usize], Leaf::Formula(_) | Leaf::Field(..));
            }
        }
        let mut faces: FxHashMap<u64, Vec<u32>> = FxHashMap::default();
        let mut cells: FxHashMap<u64, Layers> = FxHashMap::default();
        for (t, label) in mesh.labels.iter().enumerate().filter(|x| !small[x.0]) {
            let at = mesh.centroid(t);
            let Some(brick) = grid.brick_of(at) else { continue };
            let own = faces.entry(key(brick)).or_default();
            if !own.contains(label) {
                own.push(*label);
            }
            if wavy[*label as usize] {
                let q = (at - grid.node(brick.map(|b| b as usize * BRICK))) / grid.h;
                let [x, y, z] = q.to_array().map(|q| (q.max(0.0) as usize).min(BRICK - 1));
                cells.entry(key(brick)).or_default()[z] |= 1 << (x + BRICK * y);
            }
        }
        Self { faces, cells, wavy }
    }

    /// Where the surface is looked for in a brick that has some.
    fn wanted(&self, cell: &Cell) -> Wanted {
        let face = |op: &Op| if let Op::Leaf { face, .. } = op { Some(*face) } else { None };
        let mut unseen: Vec<u32> = cell.tape.ops.iter().filter_map(face).collect();
        unseen.sort_unstable();
        unseen.dedup();
        let mut wavy: Vec<u32> = unseen.iter().copied().filter(|f| self.wavy[*f as usize]).collect();
        for (_, at) in around(cell.at) {
            if unseen.is_empty() {
                break;
            }
            if let Some(own) = self.faces.get(&key(at)) {
                unseen.retain(|f| !own.contains(f));
            }
        }
        wavy.retain(|f| !unseen.contains(f));
        let near = if wavy.is_empty() { [0; BRICK] } else { self.near(cell) };
        Wanted { unseen, wavy, near }
    }

    /// The cells of a brick that have triangles of faces of formulas, or are next to some.
    fn near(&self, cell: &Cell) -> Layers {
        /// A brick and a cell on either side of it.
        const WIDE: usize = BRICK + 2;
        // Rows of the brick and of one cell around it.
        let mut rows = [[0u16; WIDE]; WIDE];
        for (shift, at) in around(cell.at) {
            let Some(own) = self.cells.get(&key(at)) else { continue };
            let range = |s: i32| {
                if s < 0 {
                    0..1
                } else if s == 0 {
                    1..WIDE - 1
                } else {
                    WIDE - 1..WIDE
                }
            };
            for z in range(shift[2]) {
                for y in range(shift[1]) {
                    let from = |i: usize| (i + BRICK - 1) % BRICK;
                    let row = (own[from(z)] >> (BRICK * from(y)) & 0xff) as u16;
                    rows[z][y] |= match shift[0] {
                        -1 => row >> (BRICK - 1),
                        0 => row << 1,
                        _ => (row & 1) << (WIDE - 1),
                    };
                }
            }
        }
        std::array::from_fn(|z| {
            (0..BRICK).fold(0, |layer, y| {
                let all = rows[z..z + 3].iter().flat_map(|l| &l[y..y + 3]).fold(0, |r, row| r | row);
                layer | u64::from((all | all >> 1 | all >> 2) & 0xff) << (BRICK * y)
            })
        })
    }
}

/// A brick and those next to it, itself first, with where they are from it.
fn around(brick: [u32; 3]) -> impl Iterator<Item = ([i32; 3], [u32; 3])> {
    (0..27).map(move |n| {
        let n = (n + 13) % 27;
        let shift = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
        (shift, std::array::from_fn(|k| brick[k].wrapping_add_signed(shift[k])))
    })
}

/// Where the surface is looked for.
struct Sight<'a> {
    model: &'a Implicit,
    extracted: &'a Extracted,
    /// Boxes, if not everywhere.
    within: Option<&'a Bvh>,
    run: &'a Run,
}

/// Points of the surface in a brick, where it is wanted or everywhere.
fn points(sight: &Sight<'_>, cell: &Cell, wanted: Option<&Wanted>) -> Result<Vec<SurfacePoint>> {
    let Sight { model, extracted, within, run } = *sight;
    run.check()?;
    let grid = &extracted.bricks.grid;
    let lo = grid.node(cell.at.map(|b| b as usize * BRICK));
    let hi = grid.node(cell.at.map(|b| (b as usize + 1) * BRICK));
    let scale = model.bounds().diagonal();
    let mut scratch = Scratch::default();
    let mut found = Vec::new();
    let brick_levels = BRICK.trailing_zeros();
    // Boxes of one cell or more with their first cell.
    let mut stack: Vec<(Aabb, [usize; 3], Tape, u32)> = vec![(Aabb::new(lo, hi), [0; 3], (*cell.tape).clone(), 0)];
    let mut looked = 0;
    while let Some((b, at, tape, level)) = stack.pop() {
        let side = (BRICK >> level).max(1);
        let on = |face: u32| wanted.is_none_or(|w| w.has(face, at, side));
        let leaf_wanted = |op: &Op| match op {
            Op::Leaf { leaf, face, .. } if on(*face) => Some((*leaf, *face)),
            _ => None,
        };
        let any_leaf = |op: &Op| if let Op::Leaf { leaf, .. } = op { Some(*leaf) } else { None };
        if within.is_some_and(|w| !w.meets(&b)) || !tape.ops.iter().any(|op| leaf_wanted(op).is_some()) {
            continue;
        }
        looked += 1;
        if looked > MOST_BOXES {
            break;
        }
        let tape = match tape.prune(&model.leaves, &b, &mut scratch) {
            Pruned::Outside | Pruned::Inside => continue,
            Pruned::Same => tape,
            Pruned::Smaller(t) => t,
        };
        let mut leaves: Vec<(u32, u32)> = tape.ops.iter().filter_map(leaf_wanted).collect();
        leaves.sort_unstable();
        leaves.dedup();
        if leaves.is_empty() {
            continue;
        }
        if level >= brick_levels {
            let before = found.len();
            // Faces that are not looked for may end one that is.
            let all: Vec<u32> =
                tape.ops.iter().filter_map(any_leaf).filter(|l| !leaves.iter().any(|w| w.0 == *l)).collect();
            let look = Look { model, extracted, b: &b, tape: &tape, scale };
            let mut others = all;
            for &(leaf, face) in &leaves {
                let at = look.surface_point(&[leaf]).or_else(|| look.edge_point(leaf, &others));
                found.extend(at.map(|at| SurfacePoint { at, face }));
                others.push(leaf);
            }
            // Of a function with no bounds smaller boxes tell no more than this one.
            let tells_nothing = |l: &(u32, u32)| model.leaves[l.0 as usize].range(&b) == Interval::ALL;
            if found.len() > before || level == brick_levels + DEEPER || leaves.iter().all(tells_nothing) {
                continue;
            }
        }
        let mid = b.center();
        let half = if level < brick_levels { side / 2 } else { 0 };
        stack.extend(b.corners().map(|c| {
            let first = std::array::from_fn(|k| at[k] + if c[k] > mid[k] { half } else { 0 });
            (Aabb::around([c, mid]), first, tape.clone(), level + 1)
        }));
    }
    Ok(found)
}

/// A box in which the surface is looked for.
struct Look<'a> {
    model: &'a Implicit,
    extracted: &'a Extracted,
    b: &'a Aabb,
    /// What holds in it.
    tape: &'a Tape,
    scale: f64,
}

impl Look<'_> {
    /// What holds at a point in the box, or beside it.
    fn tape_at(&self, p: DVec3) -> &Tape {
        if self.b.contains(p) { self.tape } else { self.extracted.tape_at(self.model, p) }
    }

    /// The point of some leaves nearest to the middle of the box, if it is in the box and the solid has a boundary there that
    /// is the first one's.
    fn surface_point(&self, which: &[u32]) -> Option<DVec3> {
        let leaves = &self.model.leaves;
        let q = nearest(leaves, which, self.b.center(), self.b.diagonal(), self.scale)?;
        if !self.b.grown(BESIDE * self.b.diagonal()).contains(q) {
            return None;
        }
        // Leaves that go the same way have no point in common but by chance, and beyond its end a fillet is the surface it ends in.
        if !leaves[which[0] as usize].passes(q, APART * self.scale)
            || which.iter().any(|i| !leaves[*i as usize].vanishes(q, APART * self.scale))
        {
            return None;
        }
        let tape = self.tape_at(q);
        let (bricks, whole) = (&self.extracted.bricks, &self.model.tape);
        let holds = if self.b.contains(q) { *self.b } else { Aabb::EMPTY };
        let meeting = Meeting { tape, holds, bricks, whole, leaves, scale: self.scale };
        if meeting.is_crowded(which, q, 4.0 * APART * self.scale) {
            // Sides of some do not tell those of the others that pass here.
            return meeting.seen_nearby(which[0], q).map(|_| q);
        }
        let mut normals = [DVec3::ZERO; 3];
        for (n, leaf) in normals.iter_mut().zip(which) {
            *n = leaves[*leaf as usize].slope(q).try_normalize()?;
        }
        let inside = |p: DVec3| self.tape_at(p).inside_with(leaves, p, &[]) != 0;
        // On all combinations of sides.
        let sides = match which.len() {
            1 => DMat3::from_cols(normals[0], DVec3::ZERO, DVec3::ZERO),
            2 => {
                let third = normals[0].cross(normals[1]).try_normalize()?;
                DMat3::from_cols(normals[0], normals[1], third).transpose().inverse()
            }
            _ => DMat3::from_cols(normals[0], normals[1], normals[2]).transpose().inverse(),
        };
        let side = |bits: usize| {
            let sign = |k: usize| if k >= which.len() { 0.0 } else { f64::from((bits >> k & 1) as u8) * 2.0 - 1.0 };
            inside(q + sides * DVec3::new(sign(0), sign(1), sign(2)) * (APART * self.scale))
        };
        // The first leaf's own side must count, at least on some sides of the others.
        (0..1 << which.len()).step_by(2).any(|bits| side(bits) != side(bits + 1)).then_some(q)
    }

    /// A point where a leaf meets one or two of some others.
    fn edge_point(&self, leaf: u32, others: &[u32]) -> Option<DVec3> {
        let others = &others[..others.len().min(MOST_OTHERS)];
        let pair = others.iter().find_map(|o| self.surface_point(&[leaf, *o]));
        pair.or_else(|| {
            let triples = others.iter().enumerate().flat_map(|(k, a)| others[..k].iter().map(move |b| [leaf, *a, *b]));
            triples.into_iter().find_map(|which| self.surface_point(&which))
        })
    }
}
