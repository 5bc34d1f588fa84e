//! Packing a patch with nodes from its border inwards, each at the wanted distance from those before it.
//!
//! The packing of nodes as a front is that of \[GUO\]; here every node of the front completes the ring of its neighbors to
//! sectors of about 60 degrees, so the rows that leave a border stay rows of equilateral triangles until they meet others.
//! Nodes enter the triangulation as it is: an old node nearby is moved, or the triangle under the place is split; old
//! nodes that found no place are collapsed away at the end. So there is a valid mesh at every moment.

use std::f64::consts::{FRAC_PI_3, TAU};

use glam::DVec3;

use super::grid::PointGrid;
use super::judge::NodeAt;
use super::patchwork::PieceSet;
use super::remesher::{Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::{NONE, next};

/// Placed nodes up to this many wanted lengths away are neighbors in a ring.
const RING: f64 = 1.3;
/// No node is placed nearer to another than this many wanted lengths.
const CLOSE: f64 = 0.68;
/// Where a border is in the way a node is placed this many wanted lengths away.
const NARROW: f64 = 0.75;
/// A place that is farther from the node whose ring it completes than this many wanted lengths is none: the surface bends away.
const FAR: f64 = 1.2;
/// A patch gets at most this many times the nodes its area asks for, and some more: a bound for surfaces that mislead.
const MOST: f64 = 4.0;
/// An old node is moved to a place at most this many wanted lengths away.
const CLAIM: f64 = 0.8;
/// While nodes are placed shapes may become as bad as this: flips follow.
const POOR: f64 = 0.08;
/// Triangles a walk to a place may cross: as many as there may be to a length in triangles not thinned out before. It ends a walk that
/// goes in circles where the surface is folded.
const STEPS: usize = 512;
/// A place this near to an edge of its triangle, in barycentric coordinates, is put on the edge.
const ON_EDGE: f64 = 0.08;
/// A walk has arrived where the place is at most this far outside the triangle, in barycentric coordinates.
const BESIDE: f64 = 0.02;
/// Passes of collapsing what is left of the old nodes.
const PASSES: usize = 3;

/// A node of a packing before it has a number.
#[derive(Clone, Copy)]
pub(super) struct Seed {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// The edge length wanted there.
    pub(super) want: f64,
}

/// What is known while a patch is packed.
pub(super) struct Packing {
    pub(super) grid: PointGrid,
    placed: Vec<bool>,
    normals: Vec<DVec3>,
    queue: Vec<u32>,
    /// Scratch: the placed nodes around the one whose ring is completed, and the places of nodes on cuts.
    near: Vec<(DVec3, u32)>,
    rays: Vec<f64>,
    cuts: Vec<DVec3>,
}

impl Remesher<'_> {
    /// A packing of a patch, the only one of this mesh, with the nodes of its border placed; the nodes, the patch, and how
    /// many nodes its area asks for.
    pub(super) fn begin_packing(&self) -> Option<(Packing, Vec<u32>, u32, f64)> {
        let m = &self.work.mesh;
        let nodes: Vec<u32> = m.nodes().collect();
        let &first = nodes.first()?;
        let label = m.outgoing(first).next().map_or(0, |h| m.label(h / 3));
        let least = nodes.iter().map(|&v| self.want[v as usize]).fold(f64::INFINITY, f64::min);
        let mut packing = Packing {
            grid: PointGrid::new(least, FAR + CLOSE),
            placed: vec![false; m.node_capacity()],
            normals: vec![DVec3::ZERO; m.node_capacity()],
            queue: Vec::with_capacity(nodes.len()),
            near: Vec::new(),
            rays: Vec::new(),
            cuts: Vec::new(),
        };
        for &v in nodes.iter().filter(|&&v| self.rank[v as usize] == Rank::Corner) {
            if self.is_open(v) {
                packing.grid.insert(self.point(v), self.want[v as usize], v);
            } else {
                packing.place(self, v, label);
            }
        }
        let area = |t: u32| m.area_vector(t).length() / (3f64.sqrt() * self.want[m.corners(t)[0] as usize].powi(2));
        let asked: f64 = m.triangles().map(area).sum();
        Some((packing, nodes, label, asked))
    }

    /// Replaces the nodes inside a patch, the only one of this mesh, by a packing.
    pub(super) fn pack(&mut self) -> Result<()> {
        let Some((mut packing, nodes, label, asked)) = self.begin_packing() else { return Ok(()) };
        let most = nodes.len() + (MOST * asked) as usize;
        let mut done = 0;
        let mut seeds = nodes.iter();
        loop {
            while let Some(&v) = packing.queue.get(done).filter(|_| packing.queue.len() < most) {
                if done.is_multiple_of(256) {
                    self.run.check()?;
                }
                done += 1;
                self.surround(v, label, &mut packing);
            }
            // Where no front came by a node that is far from all others starts one.
            let far = |v: &u32| {
                let (p, want) = (self.point(*v), self.want[*v as usize]);
                !packing.placed[*v as usize]
                    && self.work.mesh.is_node(*v)
                    && packing.is_free(self, p, want, DVec3::ZERO)
            };
            let Some(&v) = seeds.by_ref().find(|v| far(v)) else { break };
            packing.place(self, v, label);
        }
        self.drop_unplaced(&packing)
    }

    /// Flips, and takes out the nodes that were there before the packing.
    pub(super) fn drop_unplaced(&mut self, packing: &Packing) -> Result<()> {
        for _ in 0..PASSES {
            self.flip()?;
            let left = self.collapse_unplaced(&packing.placed)?;
            if left == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Completes the ring of a placed node.
    fn surround(&mut self, v: u32, label: u32, packing: &mut Packing) {
        let (p, want, n) = (self.point(v), self.want[v as usize], packing.normals[v as usize]);
        if n == DVec3::ZERO {
            return;
        }
        let mut near = std::mem::take(&mut packing.near);
        near.clear();
        let farthest = (FAR + CLOSE) * want;
        packing.cuts.clear();
        packing.grid.around(p, farthest, want, |q, id| {
            if id != v && q.distance_squared(p) < farthest * farthest && packing.normals[id as usize].dot(n) >= 0.0 {
                if packing.placed[id as usize] {
                    near.push((q, id));
                } else {
                    packing.cuts.push(q);
                }
            }
        });
        near.sort_unstable_by_key(|x| x.1);
        let (e, f) = n.any_orthonormal_pair();
        let angle = |q: DVec3| f.dot(q - p).atan2(e.dot(q - p));
        let m = &self.work.mesh;
        // The sector to fill: all around, or from one neighbor on the boundary to the other.
        let (start, whole) = if m.is_boundary(v) {
            let (mut sum, mut last) = (0.0, NONE);
            for h in m.outgoing(v) {
                sum += (self.point(m.target(h)) - p).angle_between(self.point(m.apex(h)) - p);
                last = m.apex(h);
            }
            let first = m.outgoing(v).next().map_or(last, |h| m.target(h));
            let start = angle(self.point(first));
            let plain = (angle(self.point(last)) - start).rem_euclid(TAU);
            // Projected angles know the sector only up to a full turn.
            let turned = if plain < 0.5 * TAU { plain + TAU } else { plain - TAU };
            (start, if (turned - sum).abs() < (plain - sum).abs() { turned } else { plain })
        } else {
            let ring = near.iter().filter(|x| x.0.distance_squared(p) < (RING * want).powi(2));
            (ring.map(|x| angle(x.0)).next().unwrap_or(0.0), TAU)
        };
        let mut rays = std::mem::take(&mut packing.rays);
        rays.clear();
        rays.extend([0.0, whole]);
        rays.extend(
            near.iter()
                .filter(|x| x.0.distance_squared(p) < (RING * want).powi(2))
                .map(|x| (angle(x.0) - start).rem_euclid(TAU))
                .filter(|a| *a > 1e-3 && *a < whole - 1e-3),
        );
        rays.sort_unstable_by(f64::total_cmp);
        for pair in rays.windows(2) {
            let gap = pair[1] - pair[0];
            let sectors = (gap / FRAC_PI_3).round();
            for k in 1..sectors as usize {
                let (s, c) = (start + pair[0] + gap * k as f64 / sectors).sin_cos();
                if let Some((q, id)) = self.try_place(v, c * e + s * f, label, packing, &near) {
                    near.push((q, id));
                }
            }
        }
        (packing.near, packing.rays) = (near, rays);
    }

    /// Places a node at the wanted distance from `v` in some direction, if there is room.
    fn try_place(
        &mut self,
        v: u32,
        direction: DVec3,
        label: u32,
        packing: &mut Packing,
        near: &[(DVec3, u32)],
    ) -> Option<(DVec3, u32)> {
        let (p, own) = (self.point(v), self.want[v as usize]);
        let set = PieceSet::one(self.work.patches[label as usize].piece);
        let place = |r: f64| {
            let n = packing.normals[v as usize] * self.work.patches[label as usize].outward;
            let q = match set.as_slice() {
                [piece] if self.surface.plane(*piece).is_none() => {
                    self.surface.foot_facing(*piece, p + r * direction, n, r)?.0
                }
                _ => self.work.settle(self.surface, &set, p + r * direction, r)?,
            };
            (q.distance_squared(p) <= (FAR * r).powi(2)).then_some(q)
        };
        let crowds = |q: DVec3, want: f64, &(x, id): &(DVec3, u32)| {
            let limit = CLOSE * 0.5 * (want + self.want[id as usize]);
            x.distance_squared(q) < limit * limit
        };
        let room = |q: DVec3, want: f64| near.iter().all(|x| !crowds(q, want, x));
        let mut q = place(own)?;
        let narrow = !room(q, own);
        if narrow {
            // Between two borders a row that is nearer to each of them may do.
            let border = |x: &(DVec3, u32)| self.work.mesh.is_boundary(x.1);
            if !near.iter().any(|x| border(x) && crowds(q, own, x)) {
                return None;
            }
            q = place(NARROW * own)?;
            if !room(q, own) {
                return None;
            }
        }
        let (mut t, mut weights) = self.walk(v, q, packing.normals[v as usize])?;
        let mut want = self.want_in(t, weights);
        if !narrow && (want - own).abs() > 0.05 * own {
            q = place(0.5 * (own + want))?;
            (t, weights) = self.walk(v, q, packing.normals[v as usize])?;
            want = self.want_in(t, weights);
            if !room(q, want) {
                return None;
            }
        }
        // The two sides of a cut do not know of each other.
        let beside_cut = |x: &DVec3| x.distance_squared(q) < (0.5 * CLOSE * own).powi(2);
        if self.work.mesh.corners(t).into_iter().any(|v| self.is_open(v)) || packing.cuts.iter().any(beside_cut) {
            return None;
        }
        let n = self.work.normal(self.surface, label, q);
        let seed = Seed { point: q, normal: n, want };
        let id = self.claim(t, seed, packing).or_else(|| self.insert(t, weights, seed, packing))?;
        packing.add(id, seed);
        Some((q, id))
    }

    pub(super) fn want_in(&self, t: u32, weights: [f64; 3]) -> f64 {
        let c = self.work.mesh.corners(t);
        (0..3).map(|k| weights[k] * self.want[c[k] as usize]).sum()
    }

    /// The triangle a point beside node `v` lies over, found by walking there, and its barycentric coordinates in it.
    pub(super) fn walk(&self, v: u32, q: DVec3, n: DVec3) -> Option<(u32, [f64; 3])> {
        let m = &self.work.mesh;
        let (p, d) = (self.point(v), q - self.point(v));
        let ahead = |h: &u32| {
            let (a, b) = (self.point(m.target(*h)) - p, self.point(m.apex(*h)) - p);
            a.cross(d).dot(n) >= 0.0 && d.cross(b).dot(n) >= 0.0
        };
        let mut t = m.outgoing(v).find(ahead)? / 3;
        let mut came = NONE;
        for _ in 0..STEPS {
            let [a, b, c] = m.corner_points(t);
            let up = (b - a).cross(c - a);
            let area = up.length_squared();
            if !(area > 0.0) {
                return None;
            }
            let w = [(c - b).cross(q - b).dot(up), (a - c).cross(q - c).dot(up), (b - a).cross(q - a).dot(up)];
            // The weight of a corner belongs to the edge that begins after it.
            let outside = (0..3u32).filter(|&k| w[k as usize] < 0.0 && next(3 * t + k) != came);
            let worst = outside.min_by(|&x, &y| w[x as usize].total_cmp(&w[y as usize]));
            let Some(k) = worst else {
                let high = (q - a).dot(up).powi(2) > 0.25 * self.want[v as usize].powi(2) * area;
                let clamped = w.map(|x| (x / area).max(0.0));
                let sum: f64 = clamped.iter().sum();
                // Back over the edge the walk came from: the surface is folded here.
                let beside = w.iter().any(|x| *x < -BESIDE * area);
                return (!high && !beside && sum > 0.0).then(|| (t, clamped.map(|x| x / sum)));
            };
            came = m.opposite(next(3 * t + k));
            if came == NONE {
                return None;
            }
            t = came / 3;
        }
        None
    }

    /// Moves the nearest old node of a triangle to a place.
    fn claim(&mut self, t: u32, seed: Seed, packing: &Packing) -> Option<u32> {
        let Seed { point: q, normal: n, want } = seed;
        let m = &self.work.mesh;
        let old =
            m.corners(t).into_iter().filter(|&v| !packing.placed[v as usize] && self.rank[v as usize] == Rank::Face);
        let near = |v: &u32| self.point(*v).distance_squared(q);
        let v = old.min_by(|a, b| near(a).total_cmp(&near(b)))?;
        if near(&v) > (CLAIM * want).powi(2) {
            return None;
        }
        let worst = |p: DVec3| {
            m.outgoing(v)
                .map(|h| self.work.policy.judge.shape([p, self.point(m.target(h)), self.point(m.apex(h))], n))
                .fold(f64::INFINITY, f64::min)
        };
        if worst(q) < POOR {
            return None;
        }
        self.work.mesh.set_point(v, q);
        Some(v)
    }

    /// Puts a new node into a triangle, or on the edge of it that the place is near, and flips what lies around.
    pub(super) fn insert(&mut self, t: u32, weights: [f64; 3], seed: Seed, packing: &mut Packing) -> Option<u32> {
        let Seed { point: q, normal: n, want } = seed;
        let m = &self.work.mesh;
        let k = (0..3u32).min_by(|&x, &y| weights[x as usize].total_cmp(&weights[y as usize]))?;
        let h = next(3 * t + k);
        let set = PieceSet::one(self.work.patches[m.label(t) as usize].piece);
        let v = if weights[k as usize] < ON_EDGE && m.opposite(h) != NONE {
            self.put_on_edge(h, q, set, want)
        } else {
            let v = self.work.mesh.split_triangle(t, q);
            self.know(set, want, Rank::Face);
            v
        };
        packing.placed.resize(v as usize + 1, false);
        packing.normals.resize(v as usize + 1, n);
        let ring: Vec<u32> = self.work.mesh.outgoing(v).map(next).collect();
        for h in ring {
            self.flip_one(h, None);
        }
        Some(v)
    }

    /// Collapses old nodes into the neighbor that leaves the best shapes. Returns how many are left.
    fn collapse_unplaced(&mut self, placed: &[bool]) -> Result<usize> {
        let mut left = 0;
        for v in 0..placed.len() as u32 {
            if v % 256 == 0 {
                self.run.check()?;
            }
            let m = &self.work.mesh;
            if placed[v as usize] || !m.is_node(v) || self.rank[v as usize] != Rank::Face {
                continue;
            }
            let label = m.outgoing(v).next().map_or(0, |h| m.label(h / 3));
            let n = self.work.normal(self.surface, label, self.point(v));
            let before = {
                let now = NodeAt { node: v, point: self.point(v), normal: Some(n) };
                self.work.worst_triangle(self.surface, now, f64::NEG_INFINITY).0
            };
            let after = |h: u32| {
                let q = self.point(m.target(h));
                let dying = [h / 3, m.opposite(h) / 3];
                // Where no node found a place old ones stay; what was triangulated for its surface has no such places.
                let to = m.target(h);
                let long = |x: u32| {
                    let [from, now] = [self.point(v), q].map(|p| p.distance(self.point(x)));
                    self.stretches(label, [to, x], from, now)
                };
                if !self.work.policy.judge.is_by_angles() && m.neighbors(v).any(long) {
                    return f64::NEG_INFINITY;
                }
                m.outgoing(v)
                    .filter(|e| !dying.contains(&(e / 3)))
                    .map(|e| self.work.policy.judge.shape([q, self.point(m.target(e)), self.point(m.apex(e))], n))
                    .fold(f64::INFINITY, f64::min)
            };
            let mut tries: Vec<(f64, u32)> =
                m.outgoing(v).filter(|&h| m.opposite(h) != NONE).map(|h| (after(h), h)).collect();
            tries.retain(|x| x.0 >= before.min(POOR));
            tries.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
            let gone = tries.into_iter().any(|(_, h)| {
                let q = self.point(self.work.mesh.target(h));
                self.work.mesh.collapse(h, q)
            });
            left += usize::from(!gone);
        }
        Ok(left)
    }
}

impl Packing {
    fn place(&mut self, r: &Remesher<'_>, v: u32, label: u32) {
        let p = r.point(v);
        self.add(v, Seed { point: p, normal: r.work.normal(r.surface, label, p), want: r.want[v as usize] });
    }

    pub(super) fn add(&mut self, v: u32, seed: Seed) {
        self.placed[v as usize] = true;
        self.normals[v as usize] = seed.normal;
        self.grid.insert(seed.point, seed.want, v);
        self.queue.push(v);
    }

    fn is_free(&self, r: &Remesher<'_>, p: DVec3, want: f64, n: DVec3) -> bool {
        let mut free = true;
        self.grid.around(p, want, want, |q, id| {
            let limit = CLOSE * 0.5 * (want + r.want[id as usize]);
            free &= q.distance_squared(p) >= limit * limit || self.normals[id as usize].dot(n) < 0.0;
        });
        free
    }
}
