//! Points of the surface where an extraction may have missed it: features smaller than the cells, found by intervals.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::apex::apexes;
use super::extract::Extracted;
use super::model::Implicit;
use super::newton::nearest;
use super::octree::{BRICK, Cell, key};
use super::tape::{Op, Pruned, Scratch, Tape};
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::Sets;
use crate::run::Run;
use crate::spatial::Aabb;

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

/// A point of the solid's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    pub(crate) at: DVec3,
    /// Index of the face it is on.
    pub(crate) face: u32,
}

/// Looks for the surface where marching cubes may not have seen it: in bricks whose corners all have one sign, and on
/// faces that, by intervals, may come through a brick and have no triangle there or next to it. One point for each face
/// in each cell that holds one near its middle. Also the nodes of faces of few triangles, and apexes.
///
/// Not found: what is smaller than the cells on a face that has triangles within a brick, and formulas on whose zeros
/// Newton's method does not settle.
pub(crate) fn surface_points(model: &Implicit, extracted: &Extracted, run: &Run) -> Result<Vec<SurfacePoint>> {
    let small = small_patches(&extracted.mesh);
    let seen = Seen::new(extracted, &small);
    run.install(|| {
        let empty = extracted.undecided.par_iter().map(|c| points(model, extracted, c, None, run));
        let crossed = extracted.bricks.cells.par_iter().map(|c| {
            let unseen = seen.unseen(c);
            if unseen.is_empty() { Ok(Vec::new()) } else { points(model, extracted, c, Some(&unseen), run) }
        });
        let found: Vec<Vec<SurfacePoint>> = empty.chain(crossed).collect::<Result<_>>()?;
        let mut found: Vec<SurfacePoint> = found.into_iter().flatten().collect();
        let mesh = &extracted.mesh;
        let nodes = |t: usize| mesh.corners(t).map(|at| SurfacePoint { at, face: mesh.labels[t] });
        found.extend((0..small.len()).filter(|t| small[*t]).flat_map(nodes));
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

/// In which bricks each face has triangles, those of small patches left out.
struct Seen {
    faces: FxHashMap<u64, Vec<u32>>,
}

impl Seen {
    fn new(extracted: &Extracted, small: &[bool]) -> Self {
        let mesh = &extracted.mesh;
        let mut faces: FxHashMap<u64, Vec<u32>> = FxHashMap::default();
        for (t, label) in mesh.labels.iter().enumerate().filter(|x| !small[x.0]) {
            let Some(at) = extracted.bricks.grid.brick_of(mesh.centroid(t)) else { continue };
            let own = faces.entry(key(at)).or_default();
            if !own.contains(label) {
                own.push(*label);
            }
        }
        Self { faces }
    }

    /// Faces of a brick's tape that have no triangle in it or next to it.
    fn unseen(&self, cell: &Cell) -> Vec<u32> {
        let face = |op: &Op| if let Op::Leaf { face, .. } = op { Some(*face) } else { None };
        let mut faces: Vec<u32> = cell.tape.ops.iter().filter_map(face).collect();
        faces.sort_unstable();
        faces.dedup();
        for n in (0..27u32).map(|n| (n + 13) % 27) {
            let shift = [n % 3, n / 3 % 3, n / 9];
            let at = std::array::from_fn(|k| (cell.at[k] + shift[k]).wrapping_sub(1));
            if let Some(own) = self.faces.get(&key(at)) {
                faces.retain(|f| !own.contains(f));
            }
            if faces.is_empty() {
                break;
            }
        }
        faces
    }
}

/// Points of the surface in a brick, on some faces or on all.
fn points(
    model: &Implicit,
    extracted: &Extracted,
    cell: &Cell,
    on: Option<&[u32]>,
    run: &Run,
) -> Result<Vec<SurfacePoint>> {
    run.check()?;
    let grid = &extracted.bricks.grid;
    let lo = grid.node(cell.at.map(|b| b as usize * BRICK));
    let hi = grid.node(cell.at.map(|b| (b as usize + 1) * BRICK));
    let scale = model.bounds().diagonal();
    let mut scratch = Scratch::default();
    let mut found = Vec::new();
    let brick_levels = BRICK.trailing_zeros();
    let mut stack: Vec<(Aabb, Tape, u32)> = vec![(Aabb::new(lo, hi), (*cell.tape).clone(), 0)];
    let mut looked = 0;
    while let Some((b, tape, level)) = stack.pop() {
        looked += 1;
        if looked > MOST_BOXES {
            break;
        }
        let tape = match tape.prune(&model.leaves, &b, &mut scratch) {
            Pruned::Outside | Pruned::Inside => continue,
            Pruned::Same => tape,
            Pruned::Smaller(t) => t,
        };
        let wanted = |op: &Op| match op {
            Op::Leaf { leaf, face, .. } if on.is_none_or(|on| on.contains(face)) => Some((*leaf, *face)),
            _ => None,
        };
        let mut leaves: Vec<(u32, u32)> = tape.ops.iter().filter_map(wanted).collect();
        leaves.sort_unstable();
        leaves.dedup();
        if leaves.is_empty() {
            continue;
        }
        if level >= brick_levels {
            let before = found.len();
            let all: Vec<u32> = leaves.iter().map(|l| l.0).collect();
            let look = Look { model, extracted, b: &b, scale };
            for (k, &(leaf, face)) in leaves.iter().enumerate() {
                let at = look.surface_point(&[leaf]).or_else(|| look.edge_point(leaf, &all[..k]));
                found.extend(at.map(|at| SurfacePoint { at, face }));
            }
            if found.len() > before || level == brick_levels + DEEPER {
                continue;
            }
        }
        let mid = b.center();
        stack.extend(b.corners().map(|c| (Aabb::around([c, mid]), tape.clone(), level + 1)));
    }
    Ok(found)
}

/// A box in which the surface is looked for.
struct Look<'a> {
    model: &'a Implicit,
    extracted: &'a Extracted,
    b: &'a Aabb,
    scale: f64,
}

impl Look<'_> {
    /// The point of some leaves nearest to the middle of the box, if it is in the box and the solid has a boundary there.
    fn surface_point(&self, which: &[u32]) -> Option<DVec3> {
        let leaves = &self.model.leaves;
        let q = nearest(leaves, which, self.b.center(), self.b.diagonal(), self.scale)?;
        if !self.b.grown(BESIDE * self.b.diagonal()).contains(q) {
            return None;
        }
        let mut normals = [DVec3::ZERO; 3];
        for (n, leaf) in normals.iter_mut().zip(which) {
            *n = leaves[*leaf as usize].slope(q).try_normalize()?;
        }
        let inside = |p: DVec3| self.extracted.tape_at(self.model, p).value(leaves, p) > 0.0;
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
        let first = side(0);
        (1..1 << which.len()).any(|bits| side(bits) != first).then_some(q)
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
