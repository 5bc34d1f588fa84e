//! From joined triangles to what the remesher needs: nodes on the true curves, patches, and what they may want.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::joint::{OperandPieces, TANGENT};
use super::operand::PreparedOperand;
use crate::error::{Error, Result};
use crate::geometry::Pieces;
use crate::heal::Joined;
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, TriMesh};
use crate::numeric::{ROUNDING, Sets};
use crate::remesh::{Patchwork, PiecePatch, PieceSet, Policy};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Coordinates of flat faces square to an axis that are this share of the size apart are the same: rounding of how planes are known.
const FLUSH: f64 = 1e-11;
/// A normal this near to an axis (one less its component) is square to it.
const SQUARE: f64 = 1e-12;

/// Gives faces of several operands that lie in one plane square to an axis the very same coordinate, so that they coincide exactly.
pub(super) fn align(made: &mut [PreparedOperand], scale: f64) {
    // Axis, coordinate, operand.
    let mut found: Vec<(usize, f64, usize)> = Vec::new();
    let mut nodes: Vec<Vec<(usize, u32)>> = Vec::new();
    for (o, m) in made.iter().enumerate() {
        let asked = m.surface.asked();
        let mut axes: FxHashMap<u32, Option<usize>> = FxHashMap::default();
        let mut own = Vec::new();
        for (t, piece) in m.mesh.triangles.iter().zip(&m.pieces) {
            let axis = *axes.entry(*piece).or_insert_with(|| {
                let (n, _) = asked.pieces().plane(*piece)?;
                (0..3).find(|k| n[*k].abs() > 1.0 - SQUARE)
            });
            let Some(k) = axis else { continue };
            for v in t {
                own.push((k, *v));
                found.push((k, m.mesh.nodes[*v as usize][k], o));
            }
        }
        own.sort_unstable();
        own.dedup();
        nodes.push(own);
    }
    found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut planes: [Vec<(f64, f64)>; 3] = Default::default();
    for same in found.chunk_by(|a, b| a.0 == b.0 && b.1 - a.1 <= FLUSH * scale) {
        // The first operand's coordinate stands for all: the one in the middle of them.
        let Some(first) = same.iter().map(|x| x.2).min() else { continue };
        let of_first: Vec<f64> = same.iter().filter(|x| x.2 == first).map(|x| x.1).collect();
        planes[same[0].0].push((same[0].1, of_first[of_first.len() / 2]));
    }
    for (m, own) in made.iter_mut().zip(nodes) {
        for (k, v) in own {
            let x = &mut m.mesh.nodes[v as usize][k];
            let at = planes[k].partition_point(|p| p.0 <= *x);
            if let Some((_, to)) = at.checked_sub(1).and_then(|i| planes[k].get(i)) {
                *x = *to;
            }
        }
    }
}

/// So many such nodes are no chance: one or two may be where surfaces merely touch or cross.
const CHANCE: usize = 3;
/// Cosine of the angle between triangles that may lie on one surface: 30 degrees.
const FACING: f64 = 0.86;

/// A place where curved or slanting surfaces of two operands coincide. Their triangles would cut each other all over by chance alone.
pub(super) fn coinciding(made: &[PreparedOperand], scale: f64, run: &Run) -> Result<Option<DVec3>> {
    // A node this near to the other operand's surface that has its normal lies on it.
    let near = ROUNDING * scale;
    for a in made {
        for b in made.iter().filter(|b| !std::ptr::eq(*b, a)) {
            let (asked, of_a) = (b.surface.asked(), a.surface.asked());
            let (surface, own) = (asked.pieces(), of_a.pieces());
            let tree = Bvh::new((0..b.mesh.triangles.len()).map(|t| Aabb::around(b.mesh.corners(t))).collect());
            let square = |n: DVec3| n.abs().max_element() > 1.0 - SQUARE;
            let mut seen = vec![false; a.mesh.nodes.len()];
            let mut count = 0;
            for (t, triangle) in a.mesh.triangles.iter().enumerate() {
                if t % 1024 == 0 {
                    run.check()?;
                }
                if own.plane(a.pieces[t]).is_some_and(|k| square(k.0)) {
                    continue;
                }
                let n = a.mesh.normal(t);
                let size = a.mesh.corners(t)[0].distance(a.mesh.corners(t)[1]);
                for v in triangle.iter().map(|v| *v as usize) {
                    if std::mem::replace(&mut seen[v], true) {
                        continue;
                    }
                    let p = a.mesh.nodes[v];
                    let mut hit = false;
                    tree.overlapping(&Aabb::new(p, p).grown(0.25 * size), |u| {
                        let u = u as usize;
                        if hit || n.dot(b.mesh.normal(u)).abs() < FACING {
                            return;
                        }
                        let foot = surface.meet(&[b.pieces[u]], p, near);
                        hit = foot.is_some_and(|q| {
                            let pair = own.direction(a.pieces[t], p).zip(surface.direction(b.pieces[u], q));
                            pair.is_some_and(|(m, n)| m.cross(n).length() <= TANGENT)
                        });
                    });
                    count += usize::from(hit);
                    if count >= CHANCE {
                        return Ok(Some(p));
                    }
                }
            }
        }
    }
    Ok(None)
}

/// All operands with their numbers in the joint.
pub(super) struct Numbers<'a> {
    pub(super) made: &'a [PreparedOperand],
    /// The first triangle, node, piece and face of each operand.
    triangles: Vec<u32>,
    nodes: Vec<u32>,
    pieces: Vec<u32>,
    /// For each operand's faces those of the whole.
    faces: Vec<Vec<u32>>,
    /// Names of the faces of the whole.
    pub(super) names: Vec<String>,
    /// Edge lengths wanted on them.
    pub(super) face_sizes: Vec<Option<f64>>,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(made: &'a [PreparedOperand]) -> Self {
        let starts = |count: &dyn Fn(&PreparedOperand) -> usize| {
            let mut sum = 0;
            let start = |m: &PreparedOperand| {
                let now = sum;
                sum += count(m);
                now as u32
            };
            made.iter().map(start).collect::<Vec<u32>>()
        };
        let mut names: Vec<String> = Vec::new();
        let mut face_sizes: Vec<Option<f64>> = Vec::new();
        let mut known: FxHashMap<String, u32> = FxHashMap::default();
        let mut faces = Vec::new();
        for m in made {
            let mut number = |(k, name): (usize, &String)| {
                *known.entry(name.clone()).or_insert_with(|| {
                    names.push(name.clone());
                    face_sizes.push(m.face_sizes.get(k).copied().flatten());
                    names.len() as u32 - 1
                })
            };
            faces.push(m.mesh.faces.iter().enumerate().map(&mut number).collect());
        }
        Self {
            made,
            triangles: starts(&|m| m.mesh.triangles.len()),
            nodes: starts(&|m| m.mesh.nodes.len()),
            pieces: starts(&|m| m.count as usize),
            faces,
            names,
            face_sizes,
        }
    }

    /// Where each piece is at home.
    pub(super) fn home(&self) -> Vec<(u32, u32)> {
        self.made.iter().enumerate().flat_map(|(o, m)| (0..m.count).map(move |k| (o as u32, k))).collect()
    }

    /// The operand something belongs to, and its number there.
    fn own(starts: &[u32], k: u32) -> (usize, usize) {
        let o = starts.partition_point(|s| *s <= k).saturating_sub(1);
        (o, (k - starts[o]) as usize)
    }

    /// Piece and face of a triangle.
    pub(super) fn of_triangle(&self, t: u32) -> (u32, u32) {
        let (o, own) = Self::own(&self.triangles, t);
        let label = self.made[o].mesh.labels[own] as usize;
        (self.pieces[o] + self.made[o].pieces[own], self.faces[o][label])
    }

    /// Whether a triangle is a wall that only keeps an endless operand in a box.
    pub(super) fn is_wall(&self, t: u32) -> bool {
        let (o, own) = Self::own(&self.triangles, t);
        let m = &self.made[o];
        let Some(walls) = m.walled else { return false };
        let (near, corners) = (FLUSH * walls.diagonal(), m.mesh.corners(own));
        let on = |k: usize, x: f64| corners.iter().all(|p| (p[k] - x).abs() <= near);
        (0..3).any(|k| on(k, walls.lo[k]) || on(k, walls.hi[k]))
    }
}

/// What is handed to the remesher.
pub(super) struct PreparedWork {
    pub(super) patchwork: Patchwork,
    /// Nodes where surfaces of two operands are tangent.
    pub(super) tangent: Vec<DVec3>,
    /// Nodes that were not put on the curve of their pieces.
    pub(super) astray: Vec<DVec3>,
}

/// The first piece that stands for each: planes of several operands may be one.
fn aliases(joint: &OperandPieces<'_>) -> Vec<u32> {
    let mut planes: Vec<(u32, DVec3, f64)> = Vec::new();
    let mut out = Vec::with_capacity(joint.home.len());
    for k in 0..joint.home.len() as u32 {
        let Some((n, d)) = joint.plane(k) else {
            out.push(k);
            continue;
        };
        let operand = joint.home[k as usize].0;
        let same = |x: &&(u32, DVec3, f64)| {
            let along = x.1.dot(n);
            let other = joint.home[x.0 as usize].0 != operand;
            other && along.abs() > 1.0 - SQUARE && (x.2 - along.signum() * d).abs() <= FLUSH * joint.scale
        };
        match planes.iter().find(same) {
            Some(x) => out.push(x.0),
            None => {
                planes.push((k, n, d));
                out.push(k);
            }
        }
    }
    out
}

/// Puts joined triangles on the true surfaces and divides them into patches. `reach` is how far a node may be from where it belongs.
pub(super) fn prepare(
    joined: &Joined,
    numbers: &Numbers<'_>,
    joint: &OperandPieces<'_>,
    reach: f64,
    run: &Run,
) -> Result<PreparedWork> {
    let alias = aliases(joint);
    let count = joined.mesh.nodes.len();
    let of: Vec<(u32, u32)> = joined
        .from
        .iter()
        .map(|t| numbers.of_triangle(*t))
        .map(|(piece, face)| (alias.get(piece as usize).copied().unwrap_or(piece), face))
        .collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (t, (piece, _)) in joined.mesh.triangles.iter().zip(&of) {
        for v in t {
            let list = &mut around[*v as usize];
            if !list.contains(piece) {
                list.push(*piece);
            }
        }
    }
    around.iter_mut().for_each(|l| l.sort_unstable());
    let mixed = |l: &[u32]| l.iter().any(|p| joint.home[*p as usize].0 != joint.home[l[0] as usize].0);
    // Where it is now, where it belongs, and whether surfaces are tangent there.
    let settle = |v: usize| -> (Option<DVec3>, bool) {
        let (p, pieces) = (joined.mesh.nodes[v], &around[v]);
        if pieces.is_empty() || (joined.node[v] != NONE && !mixed(pieces)) {
            return (Some(p), false);
        }
        let tangent = pieces.iter().enumerate().any(|(i, a)| {
            pieces[i + 1..].iter().any(|b| {
                let apart = joint.home[*a as usize].0 != joint.home[*b as usize].0;
                apart && joint.angle([*a, *b], p).is_none_or(|s| s <= TANGENT)
            })
        });
        (joint.meet(pieces, p, reach), tangent)
    };
    run.check()?;
    let settled: Vec<(Option<DVec3>, bool)> = run.install(|| (0..count).into_par_iter().map(settle).collect());
    let mut mesh = joined.mesh.clone();
    let (mut tangent, mut astray) = (Vec::new(), Vec::new());
    for (v, (place, touches)) in settled.into_iter().enumerate() {
        let p = mesh.nodes[v];
        if touches {
            tangent.push(p);
        }
        match place {
            Some(q) => mesh.nodes[v] = q,
            None => astray.push(p),
        }
    }
    let (labels, patches) = patches(&mesh, &of, joint);
    let mut edit = EditMesh::new(&mesh)?;
    for (t, l) in labels.iter().enumerate() {
        let normal = edit.area_vector(t as u32).normalize_or_zero();
        edit.set_surface(t as u32, *l, normal);
    }
    let borders: Vec<u32> = edit
        .edges()
        .filter(|&h| edit.opposite(h) != NONE && edit.label(h / 3) != edit.label(edit.opposite(h) / 3))
        .collect();
    for h in borders {
        edit.set_sharp(h, true);
        // Two names in one plane: no second surface tells where their border runs, so it stays.
        let piece = |t: u32| patches[edit.label(t) as usize].piece;
        if piece(h / 3) == piece(edit.opposite(h) / 3) {
            for v in [edit.origin(h), edit.target(h)] {
                edit.set_pinned(v, true);
            }
        }
    }
    let mut sizes = vec![f64::INFINITY; count];
    for (v, k) in joined.node.iter().enumerate().filter(|x| *x.1 != NONE) {
        let (o, own) = Numbers::own(&numbers.nodes, *k);
        sizes[v] = numbers.made[o].sizes.get(own).copied().unwrap_or(f64::INFINITY);
        if numbers.made[o].pinned.get(own).copied().unwrap_or(false) {
            edit.set_pinned(v as u32, true);
        }
    }
    let sets = around.iter().map(|l| PieceSet::of(l)).collect();
    let policy = Policy { narrow: true, ..Policy::of_triangles(false) };
    let patchwork = Patchwork { sizes, policy, ..Patchwork::new(edit, sets, patches.into()) };
    Ok(PreparedWork { patchwork, tangent, astray })
}

/// The patch of each triangle, and the patches: parts that hang together on one piece of one face face the way most of them does.
fn patches(mesh: &TriMesh, of: &[(u32, u32)], joint: &OperandPieces<'_>) -> (Vec<u32>, Vec<PiecePatch>) {
    let mut sets = Sets::new(of.len());
    for (_, [t, u]) in mesh.inner_edges() {
        if of[t as usize] == of[u as usize] {
            sets.join(t, u);
        }
    }
    let (part, count) = sets.numbers();
    let mut along = vec![0.0; count];
    for (t, k) in part.iter().enumerate() {
        let n = joint.direction(of[t].0, mesh.centroid(t)).unwrap_or(DVec3::ZERO);
        along[*k as usize] += n.dot(mesh.area_vector(t));
    }
    let mut patches: Vec<PiecePatch> = Vec::new();
    let mut number: FxHashMap<(u32, u32, bool), u32> = FxHashMap::default();
    let labels = part.iter().enumerate().map(|(t, k)| {
        let ((piece, face), out) = (of[t], along[*k as usize] >= 0.0);
        *number.entry((piece, face, out)).or_insert_with(|| {
            let outward = if out { 1.0 } else { -1.0 };
            patches.push(PiecePatch { piece, outward, plane: joint.plane(piece), face });
            patches.len() as u32 - 1
        })
    });
    let labels = labels.collect();
    (labels, patches)
}

/// The error for joined triangles that do not fit together.
pub(super) fn misfit() -> Error {
    Error::Failed("the set operations' triangles do not fit together: rounding keeps them from being cut".into())
}
