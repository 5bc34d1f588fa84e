//! Dividing the triangles that came out too far from the surface, where they are few.

use glam::DVec3;
use rayon::prelude::*;

use super::remesher::{FAIR, Remesher};
use super::stages::{AROUND, LAST, MEND, POLISH, STUCK};
use crate::error::Result;
use crate::mesh::curvature::dihedral;
use crate::mesh::edit::NONE;
use crate::run::PORTION;

/// Where more than this share of the triangles are too far away it is a matter of sizes.
const FEW: f64 = 0.01;
/// How often.
const ROUNDS: usize = 3;
/// A triangle bent less than this many times the distance over its longest side is nearer: on a cylinder it is 3.5.
const BENT: f64 = 1.2;
/// The side of a triangle is divided at which it is farthest from the surface, or the longest if its middle is farther than all
/// of them by this factor.
const INNER: f64 = 1.3;
/// A new node may be this many times as far from the middle of its edge as the triangle was from the surface.
const STRAY: f64 = 2.0;
/// New edges shall be this share of those that were too long.
const SHORTER: f64 = 0.7;

/// How far a triangle is from the surface, and the ends of its side that is to be divided.
pub(super) type TooFar = (f64, u32, u32);

impl Remesher<'_> {
    /// Divides triangles whose middle or sides' middles are farther from their surface than `limit`, those of a
    /// [list](Self::beyond) first: a new node in the middle of the longest or farthest side, and flips and moves around it.
    /// Returns how many were divided.
    pub(super) fn come_near(&mut self, limit: f64, mut list: Vec<TooFar>) -> Result<usize> {
        let mut count = 0;
        for _ in 0..ROUNDS {
            self.run.check()?;
            if list.is_empty() {
                break;
            }
            let mut focus = vec![false; self.work.mesh.node_capacity()];
            let before = count;
            for (away, a, b) in list {
                let Some(h) = self.work.mesh.edge_between(a, b) else { continue };
                let length = self.work.mesh.edge_length(h);
                let middle = 0.5 * (self.point(a) + self.point(b));
                let there = self.work.settle(self.surface, &self.edge_set(h), middle, STRAY * away);
                if there.is_none_or(|p| p.distance(middle) > STRAY * away) || !self.split(h, 0.5 * FAIR) {
                    continue;
                }
                count += 1;
                focus.resize(self.work.mesh.node_capacity(), false);
                let v = self.work.mesh.node_capacity() - 1;
                for x in [v, a as usize, b as usize] {
                    focus[x] = true;
                    self.own[x] = self.own[x].min(SHORTER * length);
                    self.want[x] = self.want[x].min(SHORTER * length);
                }
            }
            if count == before {
                break;
            }
            self.look_around(focus, AROUND);
            for _ in 0..LAST {
                self.flip()?;
                self.relax()?;
            }
            self.mend_worst(MEND, POLISH)?;
            self.flip_and_move(STUCK)?;
            list = self.beyond(limit);
        }
        self.look_everywhere();
        Ok(count)
    }

    /// Edges to be divided for the sake of triangles farther from the surface than `limit`, the farthest first, of each triangle
    /// one; none where they are many.
    pub(super) fn beyond(&self, limit: f64) -> Vec<TooFar> {
        let this = self;
        let m = &self.work.mesh;
        let seen = self.seen();
        let one = |t: u32| {
            let patch = &this.work.patches[m.label(t) as usize];
            if patch.piece == NONE || patch.plane.is_some() || this.work.is_kept(t) || !this.is_bent(t, limit) {
                return None;
            }
            let p = m.corner_points(t);
            let longest = (0..3).max_by(|a, b| side(p, *a).total_cmp(&side(p, *b))).unwrap_or(0);
            let reach = side(p, longest);
            let away = |q: DVec3| this.surface.meet(&[patch.piece], q, reach).map_or(0.0, |foot| foot.distance(q));
            let sides = [0, 1, 2].map(|k| away(0.5 * (p[k] + p[(k + 1) % 3])));
            let inner = away((p[0] + p[1] + p[2]) / 3.0);
            let farthest = (0..3).max_by(|a, b| sides[*a].total_cmp(&sides[*b])).unwrap_or(0);
            let k = if inner > INNER * sides[farthest] { longest } else { farthest };
            let most = inner.max(sides[farthest]);
            let c = m.corners(t);
            (most > limit).then(|| (most, c[k], c[(k + 1) % 3]))
        };
        let mut list: Vec<TooFar> =
            self.run.install(|| seen.par_iter().with_min_len(PORTION).filter_map(|t| one(*t)).collect());
        if list.len() as f64 > FEW * m.triangle_count() as f64 {
            return Vec::new();
        }
        list.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
        list
    }

    /// Whether a triangle and those beside it are bent so much that it may be farther than `limit` from the surface. At borders
    /// nothing is known of the other side.
    fn is_bent(&self, t: u32, limit: f64) -> bool {
        let m = &self.work.mesh;
        let p = m.corner_points(t);
        let longest = (0..3).map(|k| side(p, k)).fold(0.0, f64::max);
        (3 * t..3 * t + 3).any(|h| m.is_sharp(h) || m.opposite(h) == NONE || dihedral(m, h) * longest > BENT * limit)
    }
}

fn side(p: [DVec3; 3], k: usize) -> f64 {
    p[k].distance(p[(k + 1) % 3])
}
