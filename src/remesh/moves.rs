//! Moving nodes: relaxation of all, and mending of the worst triangles one by one.

use glam::DVec3;
use rayon::prelude::*;

use super::judge::plain_shape;
use super::patchwork::PieceSet;
use super::remesher::{FAIR, LONG, Rank, Remesher, SLIVER};
use super::stages::{FLAT, SLIM};
use crate::error::Result;
use crate::mesh::edit::{ChangeReader, NONE};
use crate::run::PORTION;

/// Nodes that would move by less than this share of their size stay.
const STILL: f64 = 0.01;

/// So many nodes are worth being sorted by who may move at the same time.
pub(super) const MANY: usize = 1 << 15;

/// Halvings of a move that is refused.
const BACKTRACKS: usize = 3;

/// A node inside a patch with no more neighbors than this is one too many where they make bad shapes.
const LONELY: usize = 4;

/// Relaxation may make shapes worse down to this: 38 degrees.
pub(super) const CALM: f64 = 0.85;

/// A flip with moves is kept only where it raises the worst shape by this much.
const BETTER: f64 = 0.02;

/// Triangles whose directions differ by less than this (cosine) lie on the surface, or none of them does: 11 degrees.
const EVEN: f64 = 0.98;

impl Remesher<'_> {
    /// Moves every free node: inside faces to the mean of the places where its triangles would be equilateral on the edges
    /// across from it, which favors no size over another; along curves to the middle of the neighbors. Of many nodes those
    /// without an edge between them move at one time, of few each for itself.
    pub(super) fn relax(&mut self) -> Result<()> {
        let mut due = self.due();
        if self.work.mesh.node_capacity() < MANY {
            for v in 0..self.work.mesh.node_capacity() as u32 {
                if v % 256 == 0 {
                    self.run.check()?;
                }
                if due[v as usize]
                    && self.is_free(v)
                    && let Some(p) = self.relaxed(v)
                {
                    self.put(v, p, &mut due);
                }
            }
            return Ok(());
        }
        let free: Vec<u32> = self.work.mesh.nodes().filter(|&v| self.is_free(v)).collect();
        for mut nodes in self.independent(&free) {
            self.run.check()?;
            nodes.retain(|v| due[*v as usize]);
            let this = &*self;
            let places: Vec<Option<DVec3>> =
                self.run.install(|| nodes.par_iter().with_min_len(PORTION).map(|&v| this.relaxed(v)).collect());
            for (&v, place) in nodes.iter().zip(places) {
                if let Some(p) = place {
                    self.put(v, p, &mut due);
                }
            }
        }
        Ok(())
    }

    /// Moves a node; its neighbors are then due to be looked at.
    fn put(&mut self, v: u32, p: DVec3, due: &mut [bool]) {
        self.work.mesh.set_point(v, p);
        self.work.mesh.neighbors(v).for_each(|x| due[x as usize] = true);
    }

    /// The nodes around which something changed since the last relaxation: what others want is known.
    fn due(&mut self) -> Vec<bool> {
        let m = &mut self.work.mesh;
        let mut due = vec![false; m.node_capacity()];
        for t in m.triangles() {
            let corners = m.corners(t);
            if corners.iter().any(|&v| m.is_changed(v, ChangeReader::Places)) {
                corners.into_iter().for_each(|v| due[v as usize] = true);
            }
        }
        if self.focus.is_none() {
            (0..due.len() as u32).for_each(|v| m.set_seen(v, ChangeReader::Places));
        }
        due
    }

    fn is_free(&self, v: u32) -> bool {
        self.work.mesh.is_node(v) && self.rank[v as usize] != Rank::Corner && self.sees(v)
    }

    /// Some nodes in groups none of which holds two neighbors.
    pub(super) fn independent(&self, nodes: &[u32]) -> Vec<Vec<u32>> {
        let m = &self.work.mesh;
        let mut color = vec![u8::MAX; m.node_capacity()];
        let mut groups: Vec<Vec<u32>> = Vec::new();
        for &v in nodes {
            let mut taken = 0u64;
            for x in m.neighbors(v) {
                taken |= 1u64.checked_shl(color[x as usize].into()).unwrap_or(0);
            }
            // Of more colors than these the rest stays.
            let own = taken.trailing_ones();
            if own < u64::BITS {
                color[v as usize] = own as u8;
                groups.resize_with(groups.len().max(own as usize + 1), Vec::new);
                groups[own as usize].push(v);
            }
        }
        groups
    }

    /// Where [`relax`](Self::relax) moves a node, if anywhere.
    fn relaxed(&self, v: u32) -> Option<DVec3> {
        let old = self.point(v);
        let target = if self.rank[v as usize] == Rank::Curve {
            let [a, b] = self.work.along(v)[..] else { return None };
            if self.work.policy.spaced {
                // Spaced without a look at what lies beside; as with nodes inside, no size is favored.
                let along = (self.point(b) - self.point(a)).normalize_or_zero();
                old + along.dot(self.towards_equilateral(v)?.0) * along
            } else {
                if self.is_beside_tip(v) {
                    return None;
                }
                0.5 * (self.point(a) + self.point(b))
            }
        } else {
            // Away from the surface nothing is to be won.
            let (step, up) = self.towards_equilateral(v)?;
            let up = up.normalize_or_zero();
            old + step - step.dot(up) * up
        };
        if target.distance_squared(old) < (STILL * self.want[v as usize]).powi(2) {
            return None;
        }
        self.moved_towards(v, old, target)
    }

    /// The way from a node to the mean of the corners that would make its triangles equilateral, and the sum of their area
    /// vectors.
    fn towards_equilateral(&self, v: u32) -> Option<(DVec3, DVec3)> {
        let (m, old) = (&self.work.mesh, self.point(v));
        let (mut middles, mut across, mut up, mut count) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0);
        for h in m.outgoing(v) {
            let (a, b) = (self.point(m.target(h)), self.point(m.apex(h)));
            let area = (a - old).cross(b - old);
            middles += 0.5 * (a + b);
            across += 0.5 * 3f64.sqrt() * area.normalize_or_zero().cross(b - a);
            up += area;
            count += 1.0;
        }
        (count > 0.0).then(|| ((middles + across) / count - old, up))
    }

    fn moved_towards(&self, v: u32, old: DVec3, target: DVec3) -> Option<DVec3> {
        let set = self.work.sets[v as usize];
        let reach = self.reach(v);
        let mut before = None;
        let mut step = target - old;
        for _ in 0..=BACKTRACKS {
            if let Some((p, normal)) = self.work.settle_beside(self.surface, v, &set, old + step, reach) {
                let after = self.worst_beside(v, p, normal, f64::NEG_INFINITY);
                let worse =
                    after < CALM && after <= *before.get_or_insert_with(|| self.work.worst_now(self.surface, v).0);
                if !worse && !self.runs_away(v, p, after) {
                    return Some(p);
                }
            }
            step *= 0.5;
        }
        None
    }

    /// Triangles whose shape is below `limit`, worst first, are mended one by one: by a flip, by moving a corner, by a
    /// collapse. Only what raises the worst shape around is done. Then, up to `passes` times, the same with those around
    /// them. Returns how many were mended.
    pub(super) fn mend_worst(&mut self, limit: f64, passes: usize) -> Result<usize> {
        self.mend_among(self.seen(), limit, passes)
    }

    /// [`mend_worst`](Self::mend_worst) once, of triangles around which something changed since this was called before.
    pub(super) fn mend_changed(&mut self, limit: f64) -> Result<usize> {
        let m = &self.work.mesh;
        let mut near = vec![false; m.node_capacity()];
        for v in m.nodes().filter(|&v| m.is_changed(v, ChangeReader::Mending)) {
            near[v as usize] = true;
            m.neighbors(v).for_each(|x| near[x as usize] = true);
        }
        let mut among = self.seen();
        among.retain(|&t| self.work.mesh.corners(t).into_iter().any(|v| near[v as usize]));
        self.work.mesh.set_all_seen(ChangeReader::Mending);
        self.mend_among(among, limit, 1)
    }

    fn mend_among(&mut self, mut among: Vec<u32>, limit: f64, passes: usize) -> Result<usize> {
        let mut all = 0;
        // Nodes that found no better place, and around which nothing changed since.
        let mut settled = vec![false; self.work.mesh.node_capacity()];
        for _ in 0..passes {
            let list = self.worse_than(limit, &among);
            let m = &self.work.mesh;
            let around: Vec<u32> = list.iter().flat_map(|&t| m.corners(t)).collect();
            let mut mended = 0;
            let mut touched = Vec::new();
            for (k, &t) in list.iter().enumerate() {
                if k % 64 == 0 {
                    self.run.check()?;
                }
                if self.work.mesh.is_triangle(t) && self.work.is_below(self.surface, t, limit) {
                    let corners = self.work.mesh.corners(t);
                    if self.mend(t, limit, &mut settled) {
                        mended += 1;
                        touched.extend(corners);
                    }
                }
            }
            if mended == 0 {
                break;
            }
            all += mended;
            let m = &self.work.mesh;
            among = around.into_iter().flat_map(|v| m.outgoing(v).map(|h| h / 3)).collect();
            among.sort_unstable();
            among.dedup();
            // What nothing changed around would be tried in vain once more.
            let mut near = vec![false; m.node_capacity()];
            for v in touched {
                near[v as usize] = true;
                m.neighbors(v).for_each(|x| near[x as usize] = true);
            }
            among.retain(|t| m.corners(*t).into_iter().any(|v| near[v as usize]));
        }
        Ok(all)
    }

    /// The triangles to be looked at.
    pub(super) fn seen(&self) -> Vec<u32> {
        let m = &self.work.mesh;
        m.triangles().filter(|&t| m.corners(t).into_iter().any(|v| self.sees(v))).collect()
    }

    /// Takes the nodes of triangles whose shape is below `limit` off the lines within a piece that they lie on, but for open
    /// borders: where such a crease bends more than triangles can, it gives way. Returns how many nodes that were.
    pub(super) fn free_beside(&mut self, limit: f64) -> usize {
        let seen = self.seen();
        let mut slim = self.worse_than(limit, &seen);
        // Between two lines that meet the angle is the part's own.
        slim.retain(|t| (3 * t..3 * t + 3).filter(|&h| self.work.mesh.is_sharp(h)).count() < 2);
        let mut nodes: Vec<u32> = slim.into_iter().flat_map(|t| self.work.mesh.corners(t)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|&v| {
            let (m, set) = (&self.work.mesh, self.work.sets[v as usize]);
            let lines = set.as_slice().iter().filter(|p| **p >= self.work.lines_from).count();
            let kept = m.is_boundary(v) || m.outgoing(v).any(|h| self.work.is_kept(h / 3));
            lines > 0 && set.len() - lines == 1 && !kept
        });
        for &v in &nodes {
            let set = PieceSet::one(self.work.sets[v as usize].as_slice()[0]);
            self.work.sets[v as usize] = set;
            self.work.mesh.set_pinned(v, false);
            self.mark_around(v);
        }
        nodes.len()
    }

    /// Triangles whose shape is below `limit`, worst first.
    pub(super) fn worse_than(&mut self, limit: f64, among: &[u32]) -> Vec<u32> {
        let this = &*self;
        let mut list: Vec<(f64, u32)> = self.run.install(|| {
            let suspects = among.par_iter().with_min_len(PORTION).filter(|&&t| !this.is_surely_better(t, limit));
            suspects.map(|&t| (this.shape(t), t)).collect()
        });
        // Of all triangles of a soup; a few of them are not worth it.
        if self.work.policy.is_raw()
            && self.work.policy.judge.is_by_angles()
            && among.len() == self.work.mesh.triangle_count()
        {
            self.shapes.resize(self.work.mesh.triangle_capacity(), 0.0);
            list.iter().for_each(|(shape, t)| self.shapes[*t as usize] = *shape);
            (0..self.work.mesh.node_capacity() as u32).for_each(|v| self.work.mesh.set_seen(v, ChangeReader::Facing));
        }
        list.retain(|x| x.0 < limit);
        list.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        list.into_iter().map(|x| x.1).collect()
    }

    /// Whether a triangle faces the way of its three neighbors and has a shape to spare: the surface need not be asked then.
    fn is_surely_better(&self, t: u32, limit: f64) -> bool {
        let m = &self.work.mesh;
        if self.work.policy.judge.is_by_angles() || self.work.patches[m.label(t) as usize].plane.is_some() {
            return false;
        }
        EVEN * plain_shape(m.corner_points(t)) >= limit && self.work.neighbors_alike(t, EVEN) == Some(3)
    }

    fn mend(&mut self, t: u32, limit: f64, settled: &mut [bool]) -> bool {
        // Around three triangles' node angles of 30 degrees are the best there are: no move mends that.
        if self.drop_lonely(t, 3, settled) {
            return true;
        }
        for h in 3 * t..3 * t + 3 {
            let m = &self.work.mesh;
            let o = m.opposite(h);
            if o != NONE {
                let nodes = [m.origin(h), m.target(h), m.apex(h), m.apex(o)];
                if self.flip_one(h, None) {
                    nodes.into_iter().for_each(|v| settled[v as usize] = false);
                    return true;
                }
            }
        }
        let mut any = false;
        for v in self.work.mesh.corners(t) {
            if settled[v as usize] {
                continue;
            }
            if !self.climb(v, limit) {
                settled[v as usize] = true;
                continue;
            }
            any = true;
            self.work.mesh.neighbors(v).for_each(|x| settled[x as usize] = false);
            if !self.work.is_below(self.surface, t, limit) {
                return true;
            }
        }
        if any {
            return true;
        }
        if self.drop_lonely(t, LONELY, settled) {
            return true;
        }
        let m = &self.work.mesh;
        let around: Vec<u32> = m.corners(t).into_iter().flat_map(|v| m.neighbors(v)).collect();
        let merged = self.merge_away(t);
        if merged {
            around.into_iter().for_each(|v| settled[v as usize] = false);
        }
        merged
    }

    /// Takes a corner of a triangle out that has no more than `few` neighbors, where that helps.
    fn drop_lonely(&mut self, t: u32, few: usize, settled: &mut [bool]) -> bool {
        for v in self.work.mesh.corners(t) {
            let m = &self.work.mesh;
            if self.rank[v as usize] != Rank::Face || m.outgoing(v).nth(few).is_some() {
                continue;
            }
            let around: Vec<u32> = m.neighbors(v).collect();
            if self.drop_node(v) {
                around.into_iter().for_each(|x| settled[x as usize] = false);
                return true;
            }
        }
        false
    }

    /// Takes a node or an edge of a triangle away where that helps.
    fn merge_away(&mut self, t: u32) -> bool {
        let mut edges = [3 * t, 3 * t + 1, 3 * t + 2];
        edges.sort_by(|x, y| self.work.mesh.edge_length(*x).total_cmp(&self.work.mesh.edge_length(*y)));
        // At a pole two nodes may have come to one place.
        if self.merge_double(edges[0]) {
            return true;
        }
        let own = self.shape(t);
        if self.collapse_if_better(edges[0], own) || self.collapse_if_better(edges[1], own) {
            return true;
        }
        own < FLAT && edges.into_iter().take(2).any(|h| self.zip(h))
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
            let q = self.point(to);
            let known = self.work.sets[from as usize].within(&self.work.sets[to as usize]);
            if !known || self.stays(from) || (self.rank[from as usize] == Rank::Corner && !self.same_place(from, to)) {
                continue;
            }
            let before = [from, to].map(|v| self.work.worst_now(self.surface, v).0);
            let before = before[0].min(before[1]);
            let worse = self.makes_sliver(side, q) || self.worst_after(side, q) <= before;
            if !self.work.mesh.can_merge(side) || worse {
                continue;
            }
            if self.work.mesh.merge(side, q) {
                self.mark_around(to);
                return true;
            }
        }
        false
    }

    /// Triangles whose shape is below `limit`, worst first, are mended by a flip that by itself may make things worse, with
    /// moves of the four nodes after it; undone where that does not help.
    pub(super) fn flip_and_move(&mut self, limit: f64) -> Result<()> {
        let seen = self.seen();
        for t in self.worse_than(limit, &seen) {
            self.run.check()?;
            for side in 0..3 {
                if self.work.mesh.is_triangle(t)
                    && self.work.is_below(self.surface, t, limit)
                    && self.try_flip_and_move(3 * t + side, limit)
                {
                    break;
                }
            }
        }
        Ok(())
    }

    fn try_flip_and_move(&mut self, h: u32, limit: f64) -> bool {
        let m = &self.work.mesh;
        let o = m.opposite(h);
        if o == NONE || m.is_sharp(h) || self.work.is_kept(h / 3) {
            return false;
        }
        let nodes = [m.origin(h), m.target(h), m.apex(h), m.apex(o)];
        let places = nodes.map(|v| self.point(v));
        let [along, across] = [places[0].distance(places[1]), places[2].distance(places[3])];
        if self.work.policy.is_raw() && self.stretches(m.label(h / 3), [nodes[2], nodes[3]], along, across) {
            return false;
        }
        let worst =
            |r: &Self| nodes.map(|v| r.work.worst_now(r.surface, v).0).into_iter().fold(f64::INFINITY, f64::min);
        let plain = |r: &Self| [h / 3, o / 3].map(|t| plain_shape(r.work.mesh.corner_points(t)));
        let slimmer = |r: &Self, then: [f64; 2]| {
            let [now, then] = [plain(r), then].map(|s| s[0].min(s[1]));
            now < SLIVER.min(then)
        };
        let (before, plain_before) = (worst(self), plain(self));
        if !self.work.mesh.flip(h) {
            return false;
        }
        for v in nodes {
            self.climb(v, limit);
        }
        if worst(self) > before + BETTER && !slimmer(self, plain_before) {
            return true;
        }
        for (v, p) in nodes.into_iter().zip(places) {
            self.work.mesh.set_point(v, p);
        }
        if let Some(back) = self.work.mesh.edge_between(nodes[2], nodes[3]) {
            self.work.mesh.flip(back);
        }
        false
    }

    /// Takes out a node inside a patch, where that leaves better shapes.
    fn drop_node(&mut self, v: u32) -> bool {
        let m = &self.work.mesh;
        let fits = |h: &u32| {
            let (to, p) = (m.target(*h), self.point(m.target(*h)));
            let long = |x: u32| p.distance(self.point(x)) > LONG * self.want[to as usize].max(self.want[x as usize]);
            m.can_collapse(*h) && !m.neighbors(v).any(long) && !self.makes_sliver(*h, p)
        };
        let after = |h: u32| (self.worst_after(h, self.point(m.target(h))), h);
        let best = m.outgoing(v).filter(fits).map(after).max_by(|x, y| x.0.total_cmp(&y.0));
        let Some((_, h)) = best.filter(|b| b.0 > self.work.worst_now(self.surface, v).0) else { return false };
        let p = self.point(m.target(h));
        self.work.mesh.collapse(h, p)
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

    /// Whether a triangle gets degenerate, whichever way it faces, once an edge's origin is at `q`: beside creases normals may
    /// mislead.
    pub(super) fn makes_sliver(&self, h: u32, q: DVec3) -> bool {
        let m = &self.work.mesh;
        let dying = [h / 3, m.opposite(h) / 3];
        let p = self.point(m.origin(h));
        m.outgoing(m.origin(h)).filter(|e| !dying.contains(&(e / 3))).any(|e| {
            let [a, b] = [m.target(e), m.apex(e)].map(|v| self.point(v));
            plain_shape([q, a, b]) < SLIVER.min(plain_shape([p, a, b]))
        })
    }

    /// Collapses an edge of a triangle whose shape is `own` where shapes around it are bad.
    fn collapse_if_better(&mut self, h: u32, own: f64) -> bool {
        let m = &self.work.mesh;
        let ends = [m.origin(h), m.target(h)];
        // By angles, triangles that are turned over get a turn of their own.
        let plain = |h: u32| plain_shape(m.corner_points(h / 3)) > FAIR;
        let fair = |v: &u32| {
            if self.work.policy.judge.is_by_angles() {
                m.outgoing(*v).all(plain)
            } else {
                self.work.worst_now(self.surface, *v).0 > FAIR
            }
        };
        if own > SLIM && ends.iter().all(fair) {
            return false;
        }
        self.collapse(h, 1.2 * LONG, own.clamp(FAIR, SLIM))
    }
}
