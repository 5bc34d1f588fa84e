//! How many triangles nodes have, and evening that out: border nodes with one too many or too few have bad ones, wherever
//! nodes are moved.

use std::f64::consts::FRAC_PI_3;

use glam::DVec3;

use super::judge::TriangleShape;
use super::patchwork::PieceSet;
use super::remesher::{LONG, Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::{NONE, next, prev};

/// A node is taken out where that lowers the strain of all around by at least the first, and one is put in, which costs
/// triangles, where it does by the second.
const WORTH: [f64; 2] = [0.01, 0.15];
/// Nodes of borders cannot give way: their strain counts so many times.
const FIXED: f64 = 1.5;
/// Triangles face ways no farther from the mean of all than this (cosine), 30 degrees: where the surface bends more nothing is
/// done.
const ALIKE: f64 = 0.87;
/// A new node lies this near to the middle of those around it, in lengths of the edge: not on another sheet of the surface.
const NEAR: f64 = 0.3;
/// Shapes that are left, before anything is moved: angles of 20 degrees.
const FIT: f64 = 0.5;

/// The triangles of a node.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fan {
    pub(super) count: f64,
    /// What they fill, in angles of an equilateral triangle: all around, or what lies between borders.
    angle: f64,
    weight: f64,
    /// Never fewer than so many.
    least: f64,
}

impl Fan {
    /// A fan of a node inside a face.
    fn inside(count: f64) -> Self {
        Self { count, angle: 6.0, weight: 1.0, least: 3.0 }
    }

    /// The sum of the squares, over so many triangles, of what their mean angle differs from that of an equilateral one. Borders
    /// leave less room than there is around nodes inside, so one triangle too many counts more there.
    fn strain(&self, count: f64) -> f64 {
        if count < self.least { f64::INFINITY } else { self.weight * (self.angle - count).powi(2) / count }
    }

    /// By how much that changes with so many triangles more.
    pub(super) fn change(&self, more: f64) -> f64 {
        self.strain(self.count + more) - self.strain(self.count)
    }
}

/// Whether a triangle has a good shape and faces some way.
fn fits(corners: [DVec3; 3], up: DVec3) -> bool {
    let facet = TriangleShape::new(corners);
    facet.plain() > FIT && facet.area.dot(up) > ALIKE * facet.area.length()
}

impl Remesher<'_> {
    /// The share of triangles with a shape below `limit` among those to be looked at.
    pub(super) fn share_below(&self, limit: f64) -> f64 {
        let m = &self.work.mesh;
        let seen = || m.triangles().filter(|t| m.corners(*t).into_iter().all(|v| self.sees(v)));
        let below = seen().filter(|t| !TriangleShape::new(m.corner_points(*t)).is_above(limit)).count();
        below as f64 / seen().count().max(1) as f64
    }

    /// The triangles of every node, and the angles they fill.
    pub(super) fn fans(&self) -> Vec<Fan> {
        let m = &self.work.mesh;
        let mut fans = vec![Fan::default(); m.node_capacity()];
        for v in m.nodes() {
            let count = m.outgoing(v).count() as f64;
            fans[v as usize] = Fan::inside(count);
            if self.rank[v as usize] != Rank::Face {
                let p = self.point(v);
                let angle = |h: u32| (self.point(m.target(h)) - p).angle_between(self.point(m.apex(h)) - p);
                let angle = m.outgoing(v).map(angle).sum::<f64>() / FRAC_PI_3;
                // Around an apex there is little to fill, but needles are no better.
                let apex = !m.is_boundary(v) && m.sharp_neighbors(v).next().is_none();
                fans[v as usize] = Fan { count, angle, weight: FIXED, least: if apex { count } else { 1.0 } };
            }
        }
        fans
    }

    /// Takes out nodes of a patch, the only one of its mesh, at short edges and puts some in at long ones, where that evens out
    /// angles; of edges that are to be looked at. Returns how many.
    pub(super) fn even_fans(&mut self) -> Result<usize> {
        let mut fans = self.fans();
        let mut count = 0;
        for h in 0..3 * self.work.mesh.triangle_capacity() as u32 {
            if h % 1024 == 0 {
                self.run.check()?;
            }
            let m = &self.work.mesh;
            if !m.is_triangle(h / 3) || !m.is_edge(h) || m.opposite(h) == NONE || m.is_sharp(h) {
                continue;
            }
            if !(self.sees(m.origin(h)) && self.sees(m.target(h))) {
                continue;
            }
            let want = 0.5 * (self.want[m.origin(h) as usize] + self.want[m.target(h) as usize]);
            let short = m.edge_length(h) < want;
            let done = if short { self.take_out(h, &mut fans) } else { self.put_in(h, &mut fans) };
            count += usize::from(done);
        }
        Ok(count)
    }

    /// The mean direction of some triangles, if none of them faces far from it.
    pub(super) fn common_way(&self, triangles: impl Iterator<Item = u32> + Clone) -> Option<DVec3> {
        let m = &self.work.mesh;
        let up = triangles.clone().map(|t| m.area_vector(t)).sum::<DVec3>().try_normalize()?;
        triangles.map(|t| m.area_vector(t)).all(|n| n.dot(up) > ALIKE * n.length()).then_some(up)
    }

    /// Collapses an edge.
    fn take_out(&mut self, h: u32, fans: &mut [Fan]) -> bool {
        let m = &self.work.mesh;
        let sides = [h, m.opposite(h)].map(|side| {
            let [a, b, c, d] = [m.origin(side), m.target(side), m.apex(side), m.apex(m.opposite(side))];
            if self.rank[a as usize] != Rank::Face {
                return (f64::INFINITY, side);
            }
            let [fa, fb, fc, fd] = [a, b, c, d].map(|v| fans[v as usize]);
            (fb.change(fa.count - 4.0) + fc.change(-1.0) + fd.change(-1.0) - (fa.strain(fa.count)), side)
        });
        let (gain, side) = if sides[1].0 < sides[0].0 { sides[1] } else { sides[0] };
        if gain > -WORTH[0] {
            return false;
        }
        let [a, b, c, d] = [m.origin(side), m.target(side), m.apex(side), m.apex(m.opposite(side))];
        let p = if self.rank[b as usize] == Rank::Face {
            let set = self.work.sets[b as usize];
            let (p, q) = (self.point(a), self.point(b));
            let middle = 0.5 * (p + q);
            let settled = self.work.settle_beside(self.surface, a, &set, middle, p.distance(q));
            let Some((p, _)) = settled else { return false };
            p
        } else {
            self.point(b)
        };
        let dying = [side / 3, m.opposite(side) / 3];
        let ring = || [a, b].into_iter().flat_map(|v| m.outgoing(v));
        let Some(up) = self.common_way(ring().map(|e| e / 3)) else { return false };
        let long = |x: u32| p.distance(self.point(x)) > LONG * self.want[b as usize].min(self.want[x as usize]);
        let fits = |e: u32| {
            let (x, y) = (m.target(e), m.apex(e));
            !long(x) && fits([p, self.point(x), self.point(y)], up)
        };
        let all = ring().filter(|e| !dying.contains(&(e / 3))).all(fits);
        if !all || !self.work.mesh.collapse(side, p) {
            return false;
        }
        fans[b as usize].count += fans[a as usize].count - 4.0;
        fans[c as usize].count -= 1.0;
        fans[d as usize].count -= 1.0;
        true
    }

    /// Splits an edge, and flips those around the new node that gain by it.
    fn put_in(&mut self, h: u32, fans: &mut Vec<Fan>) -> bool {
        let m = &self.work.mesh;
        let o = m.opposite(h);
        // The edges around the new node, and the nodes beyond.
        let around = [next(h), prev(h), next(o), prev(o)];
        let ends = around.map(|e| [m.origin(e), m.target(e)]);
        let beyond = around.map(|e| {
            let o = m.opposite(e);
            (o != NONE && !m.is_sharp(e)).then(|| m.apex(o))
        });
        let [a, b, c, d] = [m.origin(h), m.target(h), m.apex(h), m.apex(o)];
        let mut best = (-WORTH[1], 0u32);
        for choice in 1u32..16 {
            let flipped = || (0..4).filter(move |k| choice >> k & 1 == 1);
            if flipped().any(|k| beyond[k].is_none()) {
                continue;
            }
            let mut more: [(u32, f64); 8] = [(NONE, 0.0); 8];
            let mut add = |v: u32, x: f64| {
                if let Some(slot) = more.iter_mut().find(|s| s.0 == v || s.0 == NONE) {
                    *slot = (v, slot.1 + x);
                }
            };
            add(c, 1.0);
            add(d, 1.0);
            let mut count = 4.0;
            for k in flipped() {
                ends[k].into_iter().for_each(|v| add(v, -1.0));
                beyond[k].into_iter().for_each(|v| add(v, 1.0));
                count += 1.0;
            }
            let sum: f64 = more.iter().filter(|s| s.0 != NONE).map(|s| fans[s.0 as usize].change(s.1)).sum();
            let sum = sum + Fan::inside(count).strain(count);
            if sum < best.0 {
                best = (sum, choice);
            }
        }
        let choice = best.1;
        if choice == 0 {
            return false;
        }
        let label = m.label(h / 3);
        let set = PieceSet::one(self.work.patches[label as usize].piece);
        // In the middle of what will be its neighbors.
        let ring = [a, b, c, d].into_iter().chain((0..4).filter(|k| choice >> k & 1 == 1).filter_map(|k| beyond[k]));
        let (sum, count) = ring.fold((DVec3::ZERO, 0.0), |x, v| (x.0 + self.point(v), x.1 + 1.0));
        let reach = NEAR * m.edge_length(h);
        // From an end that lies inside the patch.
        let Some(beside) = [a, b, c, d].into_iter().find(|v| self.rank[*v as usize] == Rank::Face) else {
            return false;
        };
        let Some((x, _)) = self.work.settle_beside(self.surface, beside, &set, sum / count, reach) else {
            return false;
        };
        let beside = (0..4).filter(|k| choice >> k & 1 == 1).map(|k| m.opposite(around[k]) / 3);
        let Some(up) = self.common_way([h / 3, o / 3].into_iter().chain(beside)) else { return false };
        let fits = |r: u32, s: u32| fits([self.point(r), self.point(s), x], up);
        let all = (0..4).all(|k| match beyond[k].filter(|_| choice >> k & 1 == 1) {
            Some(e) => fits(ends[k][0], e) && fits(e, ends[k][1]),
            None => fits(ends[k][0], ends[k][1]),
        });
        if !all {
            return false;
        }
        let want = 0.5 * (self.want[a as usize] + self.want[b as usize]);
        let v = self.put_on_edge(h, x, set, want);
        fans.push(Fan::inside(4.0));
        fans[c as usize].count += 1.0;
        fans[d as usize].count += 1.0;
        for k in (0..4).filter(|k| choice >> k & 1 == 1) {
            let [r, s] = ends[k];
            let Some(e) = self.work.mesh.edge_between(r, s) else { continue };
            if self.work.mesh.flip(e) {
                [r, s].into_iter().for_each(|x| fans[x as usize].count -= 1.0);
                beyond[k].into_iter().chain([v]).for_each(|x| fans[x as usize].count += 1.0);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_are_at_ease_at_sixty_degrees() {
        let border = |count| Fan { count, angle: 3.0, weight: FIXED, least: 1.0 };
        assert_eq!(Fan::inside(6.0).strain(6.0), 0.0);
        assert_eq!(border(3.0).strain(3.0), 0.0);
        for fan in [Fan::inside(6.0), border(3.0)] {
            assert!(fan.change(1.0) > 0.0 && fan.change(-1.0) > 0.0);
        }
        // A straight border gives its fourth triangle up for a pair of five and seven inside.
        let pair = Fan::inside(6.0).change(1.0) + Fan::inside(6.0).change(-1.0);
        assert!(-border(4.0).change(-1.0) > pair);
        assert_eq!(border(1.0).change(-1.0), f64::INFINITY);
    }
}
