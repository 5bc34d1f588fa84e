//! Tips of cones before they are remeshed: a fan around the apex in place of what cells leave of it.
//!
//! Where a cone is thinner than the smallest cells their triangles span its axis, and cross each other once their nodes lie on the
//! cone. Where it is a few nodes around its triangles are right, but nodes so near to each other go in pairs later, and do not stay
//! a tube. The straight lines from the apex to a ring of nodes lie on the cone, so the fan of a ring is exact whatever its length.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::numeric::COS_60;

/// A ring around an apex is no shorter than this share of a cell. The shortest edges on bends are a 32nd of a cell: four of them.
const SHORTEST: f64 = 0.125;
/// Rings are looked for up to this many cells from the apex: a cone of a half angle of 0.3 degrees is as wide as the shortest ring there.
const FAR: f64 = 4.0;
/// Each ring tried is this many times farther away than the one before.
const STEP: f64 = 1.25;
/// So many times as far as the ring they are looked at.
const BESIDE: f64 = 1.5;

/// A mesh whose triangles lie on one piece each.
pub(super) struct Leafed {
    pub(super) mesh: TriMesh,
    /// The pieces of each node,
    pub(super) on: Vec<Vec<u32>>,
    /// and the face of each triangle, where that is known.
    pub(super) faces: Vec<u32>,
}

/// Puts the fan of a ring around every apex that has a clean one. `None` if there is none.
pub(super) fn fan_tips(
    mesh: &TriMesh,
    on: &[Vec<u32>],
    faces: &[u32],
    surface: &dyn Pieces,
    cell: f64,
) -> Option<Leafed> {
    let apexes = surface.apexes();
    if apexes.is_empty() {
        return None;
    }
    let tips: Vec<Fan> = apexes
        .iter()
        .filter_map(|(piece, apex)| ApexFan { mesh, on, faces, surface, piece: *piece, apex: *apex }.find(cell))
        .collect();
    if tips.is_empty() {
        return None;
    }
    let mut gone = vec![false; mesh.triangles.len()];
    let mut made = Leafed { mesh: mesh.clone(), on: on.to_vec(), faces: faces.to_vec() };
    for Fan { apex, piece, inside, ring } in tips {
        // Two apexes as near as that: the first has it.
        if inside.iter().any(|t| gone[*t as usize]) {
            continue;
        }
        let face = faces.get(inside[0] as usize);
        inside.iter().for_each(|t| gone[*t as usize] = true);
        let tip = made.mesh.nodes.len() as u32;
        made.mesh.nodes.push(apex);
        made.on.push(vec![piece]);
        for [a, b] in ring {
            made.mesh.triangles.push([a, b, tip]);
            made.mesh.labels.push(piece);
            made.faces.extend(face);
        }
    }
    let kept = |t: &usize| !gone.get(*t).copied().unwrap_or(false);
    let order: Vec<usize> = (0..made.mesh.triangles.len()).filter(kept).collect();
    made.mesh.triangles = order.iter().map(|t| made.mesh.triangles[*t]).collect();
    made.mesh.labels = order.iter().map(|t| made.mesh.labels[*t]).collect();
    if !made.faces.is_empty() {
        made.faces = order.iter().map(|t| made.faces[*t]).collect();
    }
    made.compact();
    Some(made)
}

impl Leafed {
    /// Drops nodes without triangles.
    fn compact(&mut self) {
        let mut used = vec![false; self.mesh.nodes.len()];
        self.mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let mut number = vec![0u32; used.len()];
        let kept: Vec<usize> = (0..used.len()).filter(|v| used[*v]).collect();
        kept.iter().zip(0..).for_each(|(v, k)| number[*v] = k);
        self.mesh.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
        self.mesh.nodes = kept.iter().map(|v| self.mesh.nodes[*v]).collect();
        self.on = kept.iter().map(|v| std::mem::take(&mut self.on[*v])).collect();
    }
}

/// What is to be put around an apex.
struct Fan {
    apex: DVec3,
    piece: u32,
    /// The triangles it takes the place of.
    inside: Vec<u32>,
    /// Edges of the ring, as the triangles inside had them.
    ring: Vec<[u32; 2]>,
}

/// An apex, and the mesh it is in.
struct ApexFan<'a> {
    mesh: &'a TriMesh,
    on: &'a [Vec<u32>],
    faces: &'a [u32],
    surface: &'a dyn Pieces,
    piece: u32,
    apex: DVec3,
}

impl ApexFan<'_> {
    /// The smallest ring that will do.
    fn find(&self, cell: f64) -> Option<Fan> {
        let away = |v: u32| self.mesh.nodes[v as usize].distance(self.apex);
        let reach = FAR * cell;
        let near: Vec<(u32, f64)> = (0..self.mesh.triangles.len() as u32)
            .filter(|t| self.mesh.labels[*t as usize] == self.piece)
            .filter_map(|t| {
                let d = self.mesh.triangles[t as usize].map(away).into_iter().fold(f64::INFINITY, f64::min);
                (d < BESIDE * reach).then_some((t, d))
            })
            .collect();
        // The ring is no nearer than half its length over pi.
        let mut radius = SHORTEST * cell / std::f64::consts::TAU;
        while radius < reach {
            if let Some(fan) = self.ring(&near, radius, SHORTEST * cell) {
                return Some(fan);
            }
            radius *= STEP;
        }
        None
    }

    /// The ring around what is within a distance of the apex.
    fn ring(&self, near: &[(u32, f64)], radius: f64, shortest: f64) -> Option<Fan> {
        let inside: Vec<u32> = near.iter().filter(|t| t.1 < radius).map(|t| t.0).collect();
        let triangle = |t: u32| self.mesh.triangles[t as usize];
        let mut edges: FxHashSet<[u32; 2]> = FxHashSet::default();
        for t in &inside {
            let n = triangle(*t);
            (0..3).for_each(|k| {
                edges.insert([n[k], n[(k + 1) % 3]]);
            });
        }
        let mut rim: Vec<[u32; 2]> = edges.iter().copied().filter(|[a, b]| !edges.contains(&[*b, *a])).collect();
        rim.sort_unstable();
        let after: FxHashMap<u32, u32> = rim.iter().map(|[a, b]| (*a, *b)).collect();
        let start = rim.first()?[0];
        let (mut ring, mut v) = (Vec::new(), start);
        loop {
            let w = *after.get(&v)?;
            ring.push([v, w]);
            v = w;
            if v == start {
                break;
            }
            if ring.len() > rim.len() {
                return None;
            }
        }
        // One loop, once around.
        if ring.len() != rim.len() || after.len() != rim.len() {
            return None;
        }
        let p = |v: u32| self.mesh.nodes[v as usize];
        if ring.iter().map(|[a, b]| p(*a).distance(p(*b))).sum::<f64>() < shortest {
            return None;
        }
        let own = |t: u32| triangle(t).into_iter().all(|v| self.on[v as usize] == [self.piece]);
        let face = self.faces.get(inside[0] as usize);
        if !inside.iter().all(|t| own(*t) && self.faces.get(*t as usize) == face) {
            return None;
        }
        let side = self.side(near, radius);
        let beside = near.iter().filter(|t| t.1 >= radius && t.1 < BESIDE * radius);
        let good = beside.map(|t| triangle(t.0).map(p)).all(|c| self.faces_well(c, side))
            && ring.iter().all(|[a, b]| self.faces_well([p(*a), p(*b), self.apex], side));
        (good && self.turns_once(&ring)).then_some(Fan { apex: self.apex, piece: self.piece, inside, ring })
    }

    /// On which side of the piece the triangles beside a ring are.
    fn side(&self, near: &[(u32, f64)], radius: f64) -> f64 {
        let beside = near.iter().filter(|t| t.1 >= radius && t.1 < BESIDE * radius);
        beside.map(|t| self.facing(self.mesh.corners(t.0 as usize))).sum::<f64>().signum()
    }

    /// Twice the area of a triangle, as seen along the normal of the piece there.
    fn facing(&self, [a, b, c]: [DVec3; 3]) -> f64 {
        let n = self.surface.direction(self.piece, (a + b + c) / 3.0);
        n.map_or(0.0, |n| (b - a).cross(c - a).dot(n))
    }

    fn faces_well(&self, c: [DVec3; 3], side: f64) -> bool {
        // Triangles of a fan and beside it turn from their piece by less.
        side * self.facing(c) > COS_60 * (c[1] - c[0]).cross(c[2] - c[0]).length()
    }

    /// Whether a ring goes around its axis once: all of its triangles face the same way, so that it does not turn back.
    fn turns_once(&self, ring: &[[u32; 2]]) -> bool {
        let p = |v: u32| self.mesh.nodes[v as usize] - self.apex;
        let axis = ring.iter().map(|[a, b]| p(*a).cross(p(*b))).sum::<DVec3>().normalize_or_zero();
        let flat = |v: u32| p(v) - axis * p(v).dot(axis);
        let angle = |[a, b]: &[u32; 2]| flat(*a).cross(flat(*b)).dot(axis).atan2(flat(*a).dot(flat(*b)));
        let turns = ring.iter().map(angle).sum::<f64>() / std::f64::consts::TAU;
        ring.iter().all(|e| angle(e) > 0.0) && (turns - 1.0).abs() < 0.1
    }
}
