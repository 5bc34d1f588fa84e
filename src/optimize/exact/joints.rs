//! Joints: points around which some piece is the surface in more than one sector.
//!
//! Two pieces that touch take turns four times where the curves they meet in cross, as on two pipes of equal radius whose
//! axes meet. Three that cross take turns six times where a point is inside if it is inside any two of them, as at the
//! corners of three channels of one width. Cells see that only by luck, so joints are found before the cut, the first by
//! Newton's method on the difference of the pieces' normals, the others as corners, and get a node with a neighbor in each
//! of the sectors.

use std::f64::consts::TAU;

use glam::DVec3;

use super::cut::Cutter;
use super::patchwork::PieceSet;
use crate::geometry::{Pieces, common_normal};
use crate::mesh::EditMesh;
use crate::mesh::edit::{NONE, next};

/// Pieces at a smaller angle than this (its cosine) to each other may touch nearby.
const CLOSE: f64 = 0.85;
/// A joint is looked for up to this many cells away.
const REACH: f64 = 3.0;
/// Starts from where the same pieces were tried, in cells, are not tried again.
const APART: f64 = 1.0;
/// Starts tried for two pieces: along a seam at which they touch everywhere all of them fail.
const TRIES: usize = 64;
/// Joints nearer to each other than this share of the cell are one that was found twice.
const SAME: f64 = 1e-3;
/// Pieces touch where they are nearer to each other than this share of the cell.
const TOUCHING: f64 = 1e-8;
/// The surroundings are looked at this many cells away, in so many directions.
const RADIUS: f64 = 0.5;
const DIRECTIONS: usize = 24;
/// Around joints with more sectors than this
const WIDE: usize = 4;
/// nodes nearer than this many cells go.
const CLEAR: f64 = 0.6;
/// Edges crossed at most on the way into a sector.
const WAY: usize = 6;
/// A node lies ahead if its direction is within 40 degrees of the sector's (the cosine).
const AHEAD: f64 = 0.766;

/// Shares of a turn that add up to this much more or less than one do not fill it.
const WHOLE: f64 = 1e-6;

/// Where pieces take turns.
struct Joint {
    at: DVec3,
    normal: DVec3,
    pieces: PieceSet,
    /// In each of the sectors: the direction of its middle as seen along the normal, and the piece that is the surface there.
    sectors: Vec<(DVec3, u32)>,
}

impl Cutter<'_> {
    /// Puts a node at every joint.
    pub(super) fn put_joints(&mut self) {
        for (pair, start) in self.starts() {
            if let Some(joint) = touching(self.surface, pair, start, self.cell) {
                self.put(&joint);
            }
        }
        let corners: Vec<Joint> = (0..self.mesh.triangle_capacity() as u32)
            .filter(|t| self.mesh.is_triangle(*t) && self.has_three(*t))
            .filter_map(|t| {
                let pieces = self.mesh.corners(t).map(|v| self.piece[v as usize]);
                crossing(self.surface, pieces, self.mesh.centroid(t), self.mesh.area_vector(t), self.cell)
            })
            .collect();
        corners.iter().for_each(|joint| self.put(joint));
    }

    fn put(&mut self, joint: &Joint) {
        let near = |v: &u32| self.mesh.point(*v).distance_squared(joint.at);
        if self.joints.iter().any(|(v, _)| near(v) < (SAME * self.cell).powi(2)) {
            return;
        }
        let Some(v) = (if joint.sectors.len() > WIDE { self.insert(joint) } else { self.nearest(joint) }) else {
            return;
        };
        self.mesh.set_pinned(v, true);
        self.joints.push((v, joint.pieces));
        if joint.sectors.len() > WIDE {
            self.clear(v);
        }
        self.fill_sectors(v, joint);
    }

    /// Moves the nearest node to a joint.
    fn nearest(&mut self, joint: &Joint) -> Option<u32> {
        let near = |v: &u32| self.mesh.point(*v).distance_squared(joint.at);
        let own = |v: &u32| joint.pieces.has(self.piece[*v as usize]) && !self.mesh.is_pinned(*v);
        let nearest = self.mesh.nodes().filter(own).min_by(|a, b| near(a).total_cmp(&near(b)).then(a.cmp(b)));
        let v = nearest.filter(|v| near(v) < (2.0 * self.cell).powi(2))?;
        self.mesh.set_point(v, joint.at);
        Some(v)
    }

    /// Divides the triangle that a joint is on as seen along its normal: where sectors are narrow the star of a node that
    /// was moved need not go all around it.
    fn insert(&mut self, joint: &Joint) -> Option<u32> {
        let m = &self.mesh;
        let height = |t: u32| joint.normal.dot(m.centroid(t) - joint.at).abs();
        let around = |t: &u32| {
            let [a, b, c] = m.corner_points(*t).map(|p| p - joint.at);
            let seen = |p: DVec3, q: DVec3| p.cross(q).dot(joint.normal) >= 0.0;
            let near = [a, b, c].iter().all(|p| p.length_squared() < (2.0 * self.cell).powi(2));
            near && self.is_cut(*t) && seen(a, b) && seen(b, c) && seen(c, a)
        };
        let t = m.triangles().filter(around).min_by(|a, b| height(*a).total_cmp(&height(*b)).then(a.cmp(b)))?;
        self.piece.push(joint.sectors[0].1);
        Some(self.mesh.split_triangle(t, joint.at))
    }

    /// Merges nodes near a joint into its node: in narrow sectors cells join what only the joint parts.
    fn clear(&mut self, v: u32) {
        let mut stuck = Vec::new();
        loop {
            let m = &self.mesh;
            let p = m.point(v);
            let free = |w: u32| !m.is_pinned(w) && m.outgoing(w).all(|h| self.is_cut(h / 3));
            let near = m
                .outgoing(v)
                .map(|h| (h, m.target(h)))
                .find(|(_, w)| m.point(*w).distance(p) < CLEAR * self.cell && free(*w) && !stuck.contains(w));
            let Some((h, w)) = near else { break };
            let back = self.mesh.opposite(h);
            if back == NONE || !self.mesh.merge(back, p) {
                stuck.push(w);
            }
        }
    }

    /// Places on edges between nodes of different pieces from which a joint may be found, with the pieces.
    fn starts(&self) -> Vec<([u32; 2], DVec3)> {
        let m = &self.mesh;
        let mut found: Vec<([u32; 2], DVec3)> = Vec::new();
        for h in (0..3 * m.triangle_capacity() as u32).filter(|&h| m.is_edge(h) && self.crosses(h)) {
            let (a, b) = (m.origin(h), m.target(h));
            let (i, j) = (self.piece[a as usize], self.piece[b as usize]);
            if i == NONE || j == NONE || (self.surface.plane(i).is_some() && self.surface.plane(j).is_some()) {
                continue;
            }
            let x = m.point(a).midpoint(m.point(b));
            if are_close(self.surface, [i, j], x) {
                found.push(([i.min(j), i.max(j)], x));
            }
        }
        thinned(found, self.cell)
    }

    /// Sees to it that from a joint's node a way over nodes on the right piece leads into each sector.
    fn fill_sectors(&mut self, v: u32, joint: &Joint) {
        let up: DVec3 = self.mesh.outgoing(v).map(|h| self.mesh.area_vector(h / 3)).sum();
        let n = if up.dot(joint.normal) < 0.0 { -joint.normal } else { joint.normal };
        for &(direction, piece) in &joint.sectors {
            let mut from = v;
            for _ in 0..WAY {
                let m = &self.mesh;
                let away = |w: u32| {
                    let d = m.point(w) - m.point(from);
                    d - n * n.dot(d)
                };
                let ahead = |w: u32| away(w).dot(direction) > AHEAD * away(w).length();
                if m.neighbors(from).any(|w| self.piece[w as usize] == piece && ahead(w)) {
                    break;
                }
                let across = m.outgoing(from).find(|&h| {
                    let (a, b) = (away(m.target(h)), away(m.apex(h)));
                    a.cross(direction).dot(n) >= 0.0 && direction.cross(b).dot(n) > 0.0 && a.cross(b).dot(n) > 0.0
                });
                let Some(h) = across.filter(|&h| m.opposite(next(h)) != NONE) else { break };
                let (a, b) = (away(m.target(h)), away(m.apex(h)));
                let t = a.cross(direction).dot(n) / (a - b).cross(direction).dot(n);
                let x = m.point(m.target(h)).lerp(m.point(m.apex(h)), t.clamp(0.0, 1.0));
                let Some(p) = self.surface.meet(&[piece], x, self.cell) else { break };
                from = self.mesh.split_edge(next(h), p);
                self.piece.push(piece);
            }
        }
    }
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
            if done.iter().all(|p| p.distance(joint.at) > SAME * self.cell) {
                done.push(joint.at);
                self.pinch_at(&joint);
            }
        }
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

    /// Draws what lies around a joint into its node, the nearest first, until four arms of the border come out of that.
    fn pinch_at(&mut self, joint: &Joint) {
        let away = |m: &EditMesh, v: u32| m.point(v).distance_squared(joint.at);
        let near: Vec<u32> = self.mesh.nodes().filter(|v| self.sets[*v as usize] == joint.pieces).collect();
        let first = near.into_iter().min_by(|a, b| away(self.mesh, *a).total_cmp(&away(self.mesh, *b)).then(a.cmp(b)));
        let Some(v) = first.filter(|v| away(self.mesh, *v) < (CLEAR * self.cell).powi(2)) else { return };
        let mut stuck: Vec<u32> = Vec::new();
        while self.arms(v) < WIDE {
            let m = &self.mesh;
            let free = |w: &u32| !m.is_pinned(*w) && self.sets[*w as usize].within(&joint.pieces) && !stuck.contains(w);
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

/// Finds the joint of three pieces or more that cross, at the corner of three of them near a place: nothing where each is
/// the surface in one sector only. `up` is about the outward normal there.
fn crossing(surface: &dyn Pieces, three: [u32; 3], start: DVec3, up: DVec3, cell: f64) -> Option<Joint> {
    if three.contains(&NONE) {
        return None;
    }
    let at = surface.meet(&three, start, REACH * cell)?;
    let through = |k: &u32| surface.meet(&[*k], at, cell).is_some_and(|q| q.distance(at) < TOUCHING * cell);
    let all: Vec<u32> = surface.near(at).into_iter().filter(through).collect();
    let pieces = PieceSet::of(&all);
    if pieces.len() < all.len() || three.iter().any(|k| !pieces.has(*k)) {
        return None;
    }
    let normals: Vec<DVec3> = all
        .iter()
        .map(|k| surface.direction(*k, at).map(|n| if n.dot(up) < 0.0 { -n } else { n }))
        .collect::<Option<_>>()?;
    let mut sectors: Vec<(DVec3, u32)> = Vec::new();
    let mut shares: Vec<[DVec3; 2]> = Vec::new();
    let mut normal = DVec3::ZERO;
    for (k, n) in all.iter().zip(&normals) {
        let rays = rays(*n, &normals)?;
        let is_surface =
            |mid: DVec3| surface.meet(&[*k], at + RADIUS * cell * mid, cell).is_some_and(|q| surface.bounds(&[*k], q));
        let on: Vec<bool> = (0..rays.len()).map(|i| is_surface(between(&rays, i, i + 1, *n))).collect();
        // a piece that is the surface on all sides, or on none, makes no corner with the others
        let first = (0..on.len()).find(|&i| on[i] && !on[(i + on.len() - 1) % on.len()])?;
        let mut i = first;
        while i < first + on.len() {
            let begin = i;
            while on[i % on.len()] {
                shares.push([rays[i % on.len()], rays[(i + 1) % on.len()]]);
                i += 1;
            }
            if begin < i {
                sectors.push((between(&rays, begin, i, *n), *k));
                normal += *n;
            }
            i += 1;
        }
    }
    let normal = normal.try_normalize()?;
    let again = |s: &(DVec3, u32)| sectors.iter().filter(|o| o.1 == s.1).count() > 1;
    // seen along the normal the sectors fill one turn, or they do not lie side by side
    let flat = |d: DVec3| d - normal * normal.dot(d);
    let turn: f64 =
        shares.iter().map(|[a, b]| normal.dot(flat(*a).cross(flat(*b))).atan2(flat(*a).dot(flat(*b)))).sum();
    if !sectors.iter().any(again) || (turn - TAU).abs() > WHOLE {
        return None;
    }
    sectors.iter_mut().for_each(|s| s.0 = flat(s.0).normalize_or_zero());
    Some(Joint { at, normal, pieces, sectors })
}

/// The directions in which planes with these normals cut the one with normal `n`, counter-clockwise around it.
fn rays(n: DVec3, normals: &[DVec3]) -> Option<Vec<DVec3>> {
    let mut rays: Vec<DVec3> = normals
        .iter()
        .filter(|m| **m != n)
        .map(|m| n.cross(*m).try_normalize())
        .collect::<Option<Vec<_>>>()?
        .into_iter()
        .flat_map(|d| [d, -d])
        .collect();
    let (e, f) = n.any_orthonormal_pair();
    rays.sort_by(|a, b| a.dot(f).atan2(a.dot(e)).total_cmp(&b.dot(f).atan2(b.dot(e))));
    Some(rays)
}

/// The middle between two of some rays around `n`, counter-clockwise from the first.
fn between(rays: &[DVec3], first: usize, last: usize, n: DVec3) -> DVec3 {
    let (a, b) = (rays[first % rays.len()], rays[last % rays.len()]);
    let angle = n.dot(a.cross(b)).atan2(a.dot(b)).rem_euclid(TAU);
    let (s, c) = (0.5 * angle).sin_cos();
    c * a + s * n.cross(a)
}

/// Finds the joint of two pieces that touch from a place near it.
fn touching(surface: &dyn Pieces, [i, j]: [u32; 2], start: DVec3, cell: f64) -> Option<Joint> {
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
    let mut around: Vec<(f64, u32)> = Vec::new();
    for k in 0..DIRECTIONS {
        let q = p + RADIUS * cell * towards(k as f64);
        match (on(i, q), on(j, q)) {
            (Some(_), None) => around.push((k as f64, i)),
            (None, Some(_)) => around.push((k as f64, j)),
            // On the curve between them, to rounding.
            (Some(_), Some(_)) => {}
            (None, None) if surface.piece_at(q).is_some_and(|k| k == i || k == j) => {}
            (None, None) => return None,
        }
    }
    let first = (1..around.len()).find(|&k| around[k].1 != around[k - 1].1)?;
    around.rotate_left(first);
    (around.len() - first..around.len()).for_each(|k| around[k].0 += DIRECTIONS as f64);
    let sectors: Vec<(DVec3, u32)> =
        around.chunk_by(|a, b| a.1 == b.1).map(|s| (towards(0.5 * (s[0].0 + s[s.len() - 1].0)), s[0].1)).collect();
    if sectors.len() != 4 {
        return None;
    }
    Some(Joint { at: p, normal, pieces: PieceSet::of(&[i, j]), sectors })
}
