//! Joints: points where two pieces touch and take turns four times around, as the curves they meet in cross there: on two pipes of equal
//! radius whose axes meet. Linear interpolants have one way past the other; joints are found by Newton's method on the difference of the
//! pieces' normals, and what lies around them is drawn into one node.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::patchwork::PieceSet;
use crate::geometry::{Pieces, common_normal};
use crate::mesh::EditMesh;
use crate::mesh::edit::NONE;
use crate::numeric::FOUND_TWICE;
use crate::numeric::predicates::orient2d;

/// Pieces at a smaller angle than this (its cosine) to each other may touch nearby.
const CLOSE: f64 = 0.85;
/// A joint is looked for up to this many cells away.
const REACH: f64 = 3.0;
/// Starts from where the same pieces were tried, in cells, are not tried again.
const APART: f64 = 1.0;
/// Starts tried for two pieces: along a seam at which they touch everywhere all of them fail.
const TRIES: usize = 64;
/// Pieces touch where they are nearer to each other than this share of the cell.
const TOUCHING: f64 = 1e-8;
/// The surroundings are looked at this many cells away,
const RADIUS: f64 = 0.5;
/// in so many directions, 15 degrees apart.
const DIRECTIONS: usize = 24;
/// So many sectors the two pieces have around a joint, and so many arms the border.
const WIDE: usize = 4;
/// What is drawn into a joint is nearer than this many cells.
const CLEAR: f64 = 0.6;

/// Where two pieces take turns.
struct PieceJoint {
    at: DVec3,
    pieces: PieceSet,
    /// Of both pieces there.
    normal: DVec3,
}

/// Whether two pieces go about the same way at a place.
fn are_close(surface: &dyn Pieces, [i, j]: [u32; 2], x: DVec3) -> bool {
    let (Some(n), Some(o)) = (surface.direction(i, x), surface.direction(j, x)) else { return false };
    n.dot(o).abs() > CLOSE
}

/// Of places with the same pieces, those that lie apart.
fn thinned(mut found: Vec<([u32; 2], DVec3)>, cell: f64) -> Vec<([u32; 2], DVec3)> {
    found.sort_by_key(|f| f.0);
    let mut kept: Vec<([u32; 2], DVec3)> = Vec::new();
    let mut first = 0;
    for (pair, x) in found {
        if kept.last().is_some_and(|k| k.0 != pair) {
            first = kept.len();
        }
        let apart = |k: &([u32; 2], DVec3)| k.1.distance_squared(x) > (APART * cell).powi(2);
        if kept.len() - first < TRIES && kept[first..].iter().all(apart) {
            kept.push((pair, x));
        }
    }
    kept
}

/// A mesh with the pieces of its nodes and triangles, in which each border is where two pieces meet, or touch.
pub(super) struct Pieced<'a> {
    pub(super) mesh: &'a mut EditMesh,
    pub(super) sets: &'a mut [PieceSet],
    pub(super) of_triangle: &'a [u32],
    pub(super) cell: f64,
}

impl Pieced<'_> {
    /// Puts a node at every point where two pieces touch and their curves cross, for which linear interpolants had one way past the other.
    pub(super) fn pinch(&mut self, surface: &dyn Pieces) {
        let m = &self.mesh;
        let mut found: Vec<([u32; 2], DVec3)> = Vec::new();
        for h in m.edges().filter(|h| m.opposite(*h) != NONE) {
            let [i, j] = [h, m.opposite(h)].map(|h| self.of_triangle[h as usize / 3]);
            let x = m.point(m.origin(h)).midpoint(m.point(m.target(h)));
            let flat = surface.plane(i).is_some() && surface.plane(j).is_some();
            if i != j && !flat && are_close(surface, [i, j], x) {
                found.push(([i.min(j), i.max(j)], x));
            }
        }
        let mut done: Vec<DVec3> = Vec::new();
        for (pair, start) in thinned(found, self.cell) {
            let Some(joint) = touching(surface, pair, start, self.cell) else { continue };
            if done.iter().all(|p| p.distance(joint.at) > FOUND_TWICE * self.cell) {
                done.push(joint.at);
                if self.holds(&joint) {
                    self.pinch_at(&joint);
                }
            }
        }
    }

    /// Whether a node stays where it is: it is an apex or a joint, or others know it where the mesh ends.
    pub(super) fn stays(&self, v: u32) -> bool {
        self.mesh.is_pinned(v) || self.mesh.is_boundary(v)
    }

    /// Where the border at a node goes: half-edges from it between triangles of different pieces.
    fn arms(&self, v: u32) -> usize {
        self.mesh.outgoing(v).filter(|h| self.is_border(*h)).count()
    }

    /// Whether a half-edge is between triangles of different pieces.
    pub(super) fn is_border(&self, h: u32) -> bool {
        let of = |h: u32| self.of_triangle[h as usize / 3];
        self.mesh.opposite(h) != NONE && of(h) != of(self.mesh.opposite(h))
    }

    /// Whether a joint lies in this mesh. Where the mesh ends nearby another one goes on that may find the same joint, and only one may draw
    /// triangles to it: the one that has it in a triangle, as seen along the normal. The ends are the same in both, and so is the side of
    /// them it is on. What neither has is found when both are one mesh; what is a node at an end already is there.
    fn holds(&self, joint: &PieceJoint) -> bool {
        let (m, reach) = (&self.mesh, (REACH * self.cell).powi(2));
        let is_near = |v: u32| m.point(v).distance_squared(joint.at) < reach;
        let ends: Vec<DVec3> = m.nodes().filter(|v| is_near(*v) && m.is_boundary(*v)).map(|v| m.point(v)).collect();
        if ends.is_empty() {
            return true;
        }
        if ends.iter().any(|p| p.distance(joint.at) <= FOUND_TWICE * self.cell) {
            return false;
        }
        let (e, f) = joint.normal.any_orthonormal_pair();
        let seen = |p: DVec3| DVec2::new((p - joint.at).dot(e), (p - joint.at).dot(f));
        let has = |t: u32| {
            let p = m.corner_points(t).map(seen);
            let sides: [f64; 3] = std::array::from_fn(|k| orient2d(p[k], p[(k + 1) % 3], DVec2::ZERO));
            let on_end = |k: usize| sides[k] == 0.0 && m.opposite(3 * t + k as u32) == NONE;
            let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
            inside && !(0..3).any(on_end)
        };
        let around = |t: &u32| m.corners(*t).into_iter().any(is_near);
        let of_them = |t: &u32| joint.pieces.as_slice().contains(&self.of_triangle[*t as usize]);
        m.triangles().filter(|t| of_them(t) && around(t)).any(has)
    }

    /// Draws what lies around a joint into its node, the nearest first, until four arms of the border come out of that.
    fn pinch_at(&mut self, joint: &PieceJoint) {
        let away = |m: &EditMesh, v: u32| m.point(v).distance_squared(joint.at);
        let near: Vec<u32> =
            self.mesh.nodes().filter(|v| self.sets[*v as usize] == joint.pieces && !self.stays(*v)).collect();
        let first = near.into_iter().min_by(|a, b| away(self.mesh, *a).total_cmp(&away(self.mesh, *b)).then(a.cmp(b)));
        let Some(v) = first.filter(|v| away(self.mesh, *v) < (CLEAR * self.cell).powi(2)) else { return };
        let mut stuck: Vec<u32> = Vec::new();
        while self.arms(v) < WIDE {
            let m = &self.mesh;
            let free = |w: &u32| !self.stays(*w) && self.sets[*w as usize].within(&joint.pieces) && !stuck.contains(w);
            let next = m.neighbors(v).filter(free).min_by(|a, b| away(m, *a).total_cmp(&away(m, *b)).then(a.cmp(b)));
            let Some(w) = next.filter(|w| away(m, *w) < (CLEAR * self.cell).powi(2)) else { break };
            let Some(h) = m.outgoing(w).find(|h| m.target(*h) == v) else { break };
            if !self.mesh.merge(h, joint.at) {
                stuck.push(w);
            }
        }
        if self.arms(v) == WIDE {
            self.mesh.set_point(v, joint.at);
            self.mesh.set_pinned(v, true);
        }
    }
}

/// Finds the joint of two pieces that touch from a place near it.
fn touching(surface: &dyn Pieces, [i, j]: [u32; 2], start: DVec3, cell: f64) -> Option<PieceJoint> {
    let onto = |p: DVec3| surface.meet(&[i], p, REACH * cell);
    let normals = |p: DVec3| Some([surface.direction(i, p)?, surface.direction(j, p)?]);
    let p = common_normal(start, [cell, REACH], onto, normals)?;
    if surface.meet(&[j], p, cell)?.distance(p) > TOUCHING * cell {
        return None;
    }
    let normal = surface.direction(i, p)?;
    let (e, f) = normal.any_orthonormal_pair();
    let towards = |k: f64| {
        let (s, c) = (TAU * k / DIRECTIONS as f64).sin_cos();
        c * e + s * f
    };
    let on = |k: u32, q: DVec3| surface.meet(&[k], q, cell).filter(|x| surface.bounds(&[k], *x));
    let mut around: Vec<u32> = Vec::new();
    for k in 0..DIRECTIONS {
        let q = p + RADIUS * cell * towards(k as f64);
        match (on(i, q), on(j, q)) {
            (Some(_), None) => around.push(i),
            (None, Some(_)) => around.push(j),
            // On the curve between them, to rounding.
            (Some(_), Some(_)) => {}
            (None, None) if surface.piece_at(q).is_some_and(|k| k == i || k == j) => {}
            (None, None) => return None,
        }
    }
    let first = (1..around.len()).find(|&k| around[k] != around[k - 1])?;
    around.rotate_left(first);
    let sectors = around.chunk_by(|a, b| a == b).count();
    (sectors == WIDE).then(|| PieceJoint { at: p, pieces: PieceSet::of(&[i, j]), normal })
}
