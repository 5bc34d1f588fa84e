//! Moving nodes: relaxation of all, and mending of the worst triangles one by one.

use glam::DVec3;

use super::remesh::{FAIR, GOOD, LONG, Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::NONE;

/// Halvings of a move that is refused.
const BACKTRACKS: usize = 3;

/// A triangle of a smaller shape than this is flat: its height is below 3 % of its length.
const FLAT: f64 = 0.05;

impl Remesher<'_> {
    /// Moves every free node towards the centroid of its surroundings: over faces weighted by area, along curves to the
    /// middle of the neighbors.
    pub(super) fn relax(&mut self) -> Result<usize> {
        let mut moved = 0;
        for v in 0..self.work.mesh.node_capacity() as u32 {
            if v % 256 == 0 {
                self.run.check()?;
            }
            if !self.work.mesh.is_node(v) || self.rank[v as usize] == Rank::Corner || !self.sees(v) {
                continue;
            }
            let old = self.point(v);
            let target = if self.rank[v as usize] == Rank::Curve {
                match self.work.along(v)[..] {
                    [a, b] => 0.5 * (self.point(a) + self.point(b)),
                    _ => continue,
                }
            } else {
                let m = &self.work.mesh;
                let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
                for h in m.outgoing(v) {
                    let w = m.area_vector(h / 3).length();
                    sum += w * m.centroid(h / 3);
                    weight += w;
                }
                if !(weight > 0.0) {
                    continue;
                }
                sum / weight
            };
            moved += usize::from(self.move_towards(v, old, target));
        }
        Ok(moved)
    }

    fn move_towards(&mut self, v: u32, old: DVec3, target: DVec3) -> bool {
        let set = self.work.sets[v as usize];
        let reach = self.want[v as usize];
        let mut before = None;
        let mut step = target - old;
        for _ in 0..=BACKTRACKS {
            if let Some((p, normal)) = self.work.settle_beside(self.surface, v, &set, old + step, reach) {
                let after = self.work.worst_with(self.surface, v, p, normal);
                let worse = after < GOOD
                    && after <= *before.get_or_insert_with(|| self.work.worst_around(self.surface, v, old));
                if !worse {
                    self.work.mesh.set_point(v, p);
                    return true;
                }
            }
            step *= 0.5;
        }
        false
    }

    /// Triangles whose shape is below `limit`, worst first, are mended one by one: by a flip, by moving a corner, by a
    /// collapse. Only what raises the worst shape around is done.
    pub(super) fn mend_worst(&mut self, limit: f64) -> Result<usize> {
        let m = &self.work.mesh;
        let seen = |t: &u32| m.corners(*t).into_iter().any(|v| self.sees(v));
        let mut list: Vec<(f64, u32)> =
            m.triangles().filter(seen).map(|t| (self.work.shape(self.surface, t), t)).filter(|x| x.0 < limit).collect();
        list.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut mended = 0;
        for (k, (_, t)) in list.into_iter().enumerate() {
            if k % 64 == 0 {
                self.run.check()?;
            }
            if !self.work.mesh.is_triangle(t) || self.work.shape(self.surface, t) >= limit {
                continue;
            }
            mended += usize::from(self.mend(t, limit));
        }
        Ok(mended)
    }

    fn mend(&mut self, t: u32, limit: f64) -> bool {
        if (3 * t..3 * t + 3).any(|h| self.flip_one(h, false)) {
            return true;
        }
        let mut any = false;
        for v in self.work.mesh.corners(t) {
            any |= self.climb(v, limit);
            if self.work.shape(self.surface, t) >= limit {
                return true;
            }
        }
        if any {
            return true;
        }
        let mut edges = [3 * t, 3 * t + 1, 3 * t + 2];
        edges.sort_by(|x, y| self.work.mesh.edge_length(*x).total_cmp(&self.work.mesh.edge_length(*y)));
        if self.collapse_if_better(edges[0]) || self.collapse_if_better(edges[1]) {
            return true;
        }
        self.work.shape(self.surface, t) < FLAT && edges.into_iter().take(2).any(|h| self.zip(h))
    }

    /// Collapses an edge of a triangle without area even where borders fall together by that: what lies between them has
    /// no width, and came from a border that was crossed more than once.
    fn zip(&mut self, h: u32) -> bool {
        let m = &self.work.mesh;
        let o = m.opposite(h);
        if o == NONE {
            return false;
        }
        for side in [h, o] {
            let (from, to) = (self.work.mesh.origin(side), self.work.mesh.target(side));
            let (p, q) = (self.point(from), self.point(to));
            let known = self.work.sets[from as usize].within(&self.work.sets[to as usize]);
            if !known || (self.rank[from as usize] == Rank::Corner && !self.same_place(from, to)) {
                continue;
            }
            let before = self.worst(from, p).min(self.worst(to, q));
            if !self.work.mesh.can_merge(side) || self.worst_after(side, q) <= before {
                continue;
            }
            if self.work.mesh.merge(side, q) {
                self.mark_around(to);
                return true;
            }
        }
        false
    }

    fn worst(&self, v: u32, p: DVec3) -> f64 {
        self.work.worst_around(self.surface, v, p)
    }

    /// The worst shape around both ends of an edge once its origin is where its target is, without what dies.
    pub(super) fn worst_after(&self, h: u32, q: DVec3) -> f64 {
        let m = &self.work.mesh;
        let dying = [h / 3, m.opposite(h) / 3];
        let mut worst = f64::INFINITY;
        for v in [m.origin(h), m.target(h)] {
            for e in m.outgoing(v).filter(|e| !dying.contains(&(e / 3))) {
                let t = [q, self.point(m.target(e)), self.point(m.apex(e))];
                worst = worst.min(self.work.shape_at(self.surface, m.label(e / 3), t));
            }
        }
        worst
    }

    fn collapse_if_better(&mut self, h: u32) -> bool {
        let m = &self.work.mesh;
        let ends = [m.origin(h), m.target(h)];
        let before = ends.map(|v| self.work.worst_around(self.surface, v, self.point(v)));
        if before[0].min(before[1]) > FAIR {
            return false;
        }
        self.collapse(h, 1.2 * LONG)
    }

    /// Moves a node to where the worst shape around it is best, or reaches `limit`, by looking in six directions and halving
    /// the step.
    fn climb(&mut self, v: u32, limit: f64) -> bool {
        let set = self.work.sets[v as usize];
        let rank = self.rank[v as usize];
        if rank == Rank::Corner {
            return false;
        }
        let mut best = self.work.worst_around(self.surface, v, self.point(v));
        let (mut p, start) = (self.point(v), self.point(v));
        let reach = self.want[v as usize];
        let directions: Vec<DVec3> = if rank == Rank::Curve {
            match self.work.along(v)[..] {
                [a, b] => {
                    let d = (self.point(b) - self.point(a)).normalize_or_zero();
                    vec![d, -d]
                }
                _ => return false,
            }
        } else {
            let patch = self.work.mesh.outgoing(v).next().map_or(0, |h| self.work.mesh.label(h / 3));
            let Some((u, w)) =
                self.work.normal(self.surface, patch, p).try_normalize().map(DVec3::any_orthonormal_pair)
            else {
                return false;
            };
            (0..6)
                .map(|k| {
                    let (s, c) = (std::f64::consts::FRAC_PI_3 * f64::from(k)).sin_cos();
                    c * u + s * w
                })
                .collect()
        };
        let mut step = 0.25 * reach;
        for _ in 0..5 {
            if best >= limit {
                break;
            }
            let mut improved = false;
            for d in &directions {
                let place = self.work.settle_beside(self.surface, v, &set, p + step * *d, reach);
                let Some((x, normal)) = place else { continue };
                let s = self.work.worst_with(self.surface, v, x, normal);
                if s > best + 1e-4 {
                    (best, p, improved) = (s, x, true);
                    if best >= limit {
                        break;
                    }
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
        if p != start {
            self.work.mesh.set_point(v, p);
        }
        p != start
    }
}
