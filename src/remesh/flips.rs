//! Flips: which edges help where they are flipped, by shapes, by angles at nodes, and not away from the surface.

use glam::DVec3;
use rayon::prelude::*;

use super::fans::Fan;
use super::field::COARSE;
use super::judge::TriangleShape;
use super::remesher::{FAIR, GOOD, LONG, Remesher, SHORT, SLIVER};
use super::stages::MEND;
use crate::error::Result;
use crate::mesh::edit::{ChangeReader, NONE};
use crate::numeric::COS_60;
use crate::run::PORTION;

/// No flip makes an edge that is longer than this many wanted lengths and longer than all around it.
const FARTHEST: f64 = 2.0 * LONG;
/// Flips that even out angles by less than this do not: others would take them back for the shapes' sake.
const EVENER: f64 = 0.02;
/// Passes over all edges when flipping; later ones see only what earlier ones changed.
const FLIP_PASSES: usize = 6;
/// Flips of edges far longer than wanted leave them this near to the surface, as a share of the wanted length.
const OFF: f64 = 0.05;
/// What turns by less than this share of that is not worth a look.
const FOLD: f64 = 0.02;

impl Remesher<'_> {
    /// Flips edges where that raises the smaller shape, until nothing changes.
    pub(super) fn flip(&mut self) -> Result<usize> {
        self.flip_edges(None)
    }

    /// [`flip`](Self::flip) of a patch that is the only one of its mesh, also where that evens out valences and shapes stay
    /// good.
    pub(super) fn flip_evenly(&mut self) -> Result<usize> {
        self.flip_edges(Some(self.fans()))
    }

    fn flip_edges(&mut self, mut fans: Option<Vec<Fan>>) -> Result<usize> {
        let mut count = 0;
        let reader = if fans.is_some() { ChangeReader::Valences } else { ChangeReader::Shapes };
        // Only edges of triangles that changed are looked at again.
        let mut list = self.unseen(reader);
        self.set_seen(reader);
        let mut listed = vec![false; self.work.mesh.triangle_capacity()];
        for _ in 0..FLIP_PASSES {
            self.run.check()?;
            list.iter().for_each(|&t| listed[t as usize] = true);
            // Most edges stay; which do not is looked at again before each flip.
            let this = &*self;
            let wanted = |h: &u32| {
                let o = this.work.mesh.opposite(*h);
                let other_way = o == NONE || (o < *h && listed[(o / 3) as usize]);
                !other_way && this.should_flip(*h, fans.as_deref())
            };
            let edges: Vec<u32> = self.run.install(|| {
                let sides = list.par_iter().with_min_len(PORTION).flat_map_iter(|t| 3 * t..3 * t + 3);
                sides.filter(wanted).collect()
            });
            list.iter().for_each(|&t| listed[t as usize] = false);
            let mut changed = Vec::new();
            for h in edges {
                let m = &self.work.mesh;
                let o = m.opposite(h);
                // A flip before this one may have brought the boundary here.
                if o == NONE {
                    continue;
                }
                let [a, b, c, d] = [m.origin(h), m.target(h), m.apex(h), m.apex(o)];
                if self.flip_one(h, fans.as_deref()) {
                    changed.extend([h / 3, o / 3]);
                    if let Some(fans) = &mut fans {
                        [a, b].into_iter().for_each(|v| fans[v as usize].count -= 1.0);
                        [c, d].into_iter().for_each(|v| fans[v as usize].count += 1.0);
                    }
                }
            }
            count += changed.len() / 2;
            changed.sort_unstable();
            changed.dedup();
            list = changed;
            if list.is_empty() {
                // Valences count for edges beyond the triangles that change, too.
                if fans.is_none() {
                    self.set_seen(reader);
                }
                break;
            }
        }
        Ok(count)
    }

    /// Flips an edge where that [helps](Self::should_flip).
    pub(super) fn flip_one(&mut self, h: u32, fans: Option<&[Fan]>) -> bool {
        // A node of a border keeps at least one edge into each of its patches by the link condition alone.
        self.should_flip(h, fans) && self.work.mesh.flip(h)
    }

    /// Whether the flip of an edge raises the smaller shape; with the `fans` of all nodes also whether angles
    /// there become more even and shapes stay good.
    fn should_flip(&self, h: u32, fans: Option<&[Fan]>) -> bool {
        let m = &self.work.mesh;
        let o = m.opposite(h);
        if o == NONE || m.is_sharp(h) || self.work.is_kept(h / 3) {
            return false;
        }
        let (a, b, c, d) = (m.origin(h), m.target(h), m.apex(h), m.apex(o));
        let [p, q, r, s] = [a, b, c, d].map(|v| self.point(v));
        let [left, right] = [TriangleShape::new([p, q, r]), TriangleShape::new([q, p, s])];
        // Whichever way the triangles face, if only they face the same way: what promises no gain here is not worth a normal.
        let smooth = left.area.dot(right.area) > 0.0;
        let fans = fans.map(|f| [a, b, c, d].map(|v| f[v as usize]));
        let change = fans.map(|[a, b, c, d]| a.change(-1.0) + b.change(-1.0) + c.change(1.0) + d.change(1.0));
        if smooth && change.is_none_or(|c| c >= -EVENER) && left.is_above(MEND) && right.is_above(MEND) {
            return false;
        }
        // Around thin places, where normals of both sides are near, flips must not carry edges away.
        let across = r.distance_squared(s);
        if across > (FARTHEST * self.wanted(h)).powi(2)
            && [p, q]
                .iter()
                .all(|x| across > x.distance_squared(r).max(x.distance_squared(s)).max(p.distance_squared(q)))
        {
            return false;
        }
        let (above, below) = (TriangleShape::new([p, s, r]), TriangleShape::new([s, q, r]));
        let now = left.plain().min(right.plain());
        let then = above.plain().min(below.plain());
        if then < SLIVER.min(now) {
            return false;
        }
        if smooth && then <= GOOD && now > FAIR && then <= now + 1e-9 {
            return false;
        }
        let label = m.label(h / 3);
        let mut evener = false;
        if let Some(change) = change.filter(|_| then > GOOD) {
            if change > EVENER {
                return false;
            }
            evener = change < -EVENER;
        }
        if smooth && !evener && now > FAIR && then <= now + 1e-9 {
            return false;
        }
        let (middle, up) = (0.25 * (p + q + r + s), left.area + right.area);
        let mut normal = self.work.normal(self.surface, label, middle);
        if normal.dot(up) <= 0.0 {
            normal = self.work.normal_facing(self.surface, label, middle, up, SHORT * self.wanted(h)).unwrap_or(normal);
        }
        let now = left.seen(normal).min(right.seen(normal));
        let then = above.seen(normal).min(below.seen(normal));
        let better = if evener { then > GOOD } else { then > now + 1e-9 };
        // From here on two triangles bend an edge so much that it must not leave the surface, either.
        let bent = left.area.dot(right.area) < COS_60 * left.area.length() * right.area.length();
        better
            && !(bent
                && self.work.policy.is_smooth_by_angles()
                && self.folds(label, [[p, q, r], [q, p, s]], [[p, s, r], [s, q, r]]))
            && !self.leaves_surface(h, [p, q, r, s], up, bent)
    }

    /// Whether triangles are folded more, by the normals at their middles, than those they take the place of.
    fn folds(&self, label: u32, before: [[DVec3; 3]; 2], after: [[DVec3; 3]; 2]) -> bool {
        let folded =
            |t: [[DVec3; 3]; 2]| t.into_iter().filter(|t| self.work.shape_at(self.surface, label, *t) <= 0.0).count();
        let now = folded(after);
        now > 0 && now > folded(before)
    }

    /// Whether the flip of an edge takes triangles away from a bent surface: those of raw triangles may be far longer than a wall is
    /// thick, and an edge along a narrow tip is `bent` so much that normals do not tell its other diagonal, through the tip.
    fn leaves_surface(&self, h: u32, [p, q, r, s]: [DVec3; 4], up: DVec3, bent: bool) -> bool {
        let patch = &self.work.patches[self.work.mesh.label(h / 3) as usize];
        // Around borders alone, flips untangle.
        let long = || self.focus.is_none() && r.distance(s) > COARSE * self.wanted(h);
        let far = bent || (self.work.policy.is_raw() && !self.work.policy.judge.is_by_angles() && long());
        if !far || patch.plane.is_some() || patch.piece == NONE {
            return false;
        }
        let off = OFF * self.wanted(h);
        let across = (q - p).cross(s - r);
        if across.dot(r - p).abs() <= FOLD * off * across.length() {
            return false;
        }
        let away = |x: DVec3| {
            let foot = self.surface.foot_facing(patch.piece, x, up * patch.outward, f64::INFINITY);
            foot.map_or(f64::INFINITY, |f| f.0.distance(x))
        };
        let then = away(0.5 * (r + s));
        then > off && then > away(0.5 * (p + q))
    }
}
