//! Triangles that stayed as they came are put right at last, one by one. Exact tests let no step make triangles cross.

use glam::DVec3;

use super::remesher::{FAIR, Rank, Remesher};
use super::stages::SLIM;
use crate::error::Result;
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, is_flat, triangles_cross};
use crate::numeric::ROUNDING;
use crate::spatial::{Aabb, Bvh};

/// Steps raise the worst shape around them by at least this much: they end.
const GAIN: f64 = 1e-3;
/// Passes over all that is poor; hardly anything changes after that many.
const PASSES: usize = 10;
/// A tree is made anew once so many triangles are not where it has them. Each step looks at all of these, and with a thousand that takes
/// as long as its share in making a tree of 100 000 triangles.
const MOST_MOVED: usize = 1024;
/// Shares of the way to the middle of its neighbors that a node is moved by.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];

/// A node that is not on its surfaces, as triangles would cross if it were.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    /// Where it is.
    pub at: DVec3,
    /// How far from where it would be.
    pub distance: f64,
}

/// A triangle as a step would leave it.
struct Changed {
    nodes: [u32; 3],
    at: [DVec3; 3],
}

/// Where all triangles are, to see which ones a step would cross.
struct CrossingGuard {
    tree: Bvh,
    of: Vec<u32>,
    /// Triangles that changed since the tree was made.
    moved: Vec<u32>,
    is_moved: Vec<bool>,
}

impl CrossingGuard {
    fn new(m: &EditMesh) -> Self {
        let of: Vec<u32> = m.triangles().collect();
        let tree = Bvh::new(of.iter().map(|t| Aabb::around(m.corner_points(*t))).collect());
        Self { tree, of, moved: Vec::new(), is_moved: vec![false; m.triangle_capacity()] }
    }

    /// Whether triangles would cross each other, or any but those that are `gone` then, or have no area.
    fn crosses(&self, m: &EditMesh, new: &[Changed], gone: &[u32]) -> bool {
        let is_there = |t: u32| m.is_triangle(t) && !gone.contains(&t);
        new.iter().enumerate().any(|(k, c)| {
            let own = Aabb::around(c.at);
            let meets = |t: u32| triangles_cross([c.nodes, m.corners(t)], [c.at, m.corner_points(t)]);
            let mut found = is_flat(c.at);
            self.tree.overlapping(&own, |i| {
                let t = self.of[i as usize];
                found = found || (!self.is_moved[t as usize] && is_there(t) && meets(t));
            });
            let near = |t: &u32| is_there(*t) && Aabb::around(m.corner_points(*t)).overlaps(&own);
            found
                || self.moved.iter().any(|t| near(t) && meets(*t))
                || new[..k].iter().any(|d| triangles_cross([c.nodes, d.nodes], [c.at, d.at]))
        })
    }

    fn note(&mut self, m: &EditMesh, triangles: &[u32]) {
        for &t in triangles {
            if !self.is_moved[t as usize] {
                self.is_moved[t as usize] = true;
                self.moved.push(t);
            }
        }
        if self.moved.len() > MOST_MOVED {
            *self = Self::new(m);
        }
    }
}

/// A step that may put a triangle right.
#[derive(Clone, Copy)]
enum MendingStep {
    /// The origin of a side goes to its target, which goes to a place.
    Collapse(u32, DVec3),
    Flip(u32),
    Move(u32, DVec3),
}

/// What a step would do.
struct StepOutcome {
    new: Vec<Changed>,
    gone: Vec<u32>,
    /// The worst shapes now and then.
    worst: [f64; 2],
}

impl Remesher<'_> {
    /// Puts right what stayed as it was. Nodes go back to their surfaces, short edges are collapsed, edges flipped and nodes moved as
    /// long as that raises the worst shape around and makes no triangles cross.
    ///
    /// Returns nodes that could not go back. Errors: cancellation.
    pub(super) fn thaw(&mut self) -> Result<Vec<Off>> {
        let mut zone = vec![false; self.work.mesh.triangle_capacity()];
        let kept: Vec<u32> = self.work.mesh.triangles().filter(|t| self.work.is_frozen(*t)).collect();
        kept.iter().for_each(|t| zone[*t as usize] = true);
        self.work.unfreeze();
        let mut nodes: Vec<u32> = kept.iter().flat_map(|t| self.work.mesh.corners(*t)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.iter().for_each(|v| self.mark_around(*v));
        // What is farther from its place than this is not on its surface.
        let rounding = ROUNDING * Aabb::around(self.work.mesh.nodes().map(|v| self.point(v))).diagonal();
        let mut guard = CrossingGuard::new(&self.work.mesh);
        for _ in 0..PASSES {
            self.run.check()?;
            let mut steps = 0;
            for (v, q, _) in self.off(&nodes, rounding) {
                let is_done = self.returns(v, q, &mut guard, &mut zone) || self.gives_way(v, &mut guard, &mut zone);
                steps += usize::from(is_done);
            }
            let m = &self.work.mesh;
            let shape = |t: u32| self.work.shape_at(self.surface, m.label(t), m.corner_points(t));
            let mut poor: Vec<(f64, u32)> =
                m.triangles().filter(|t| zone[*t as usize]).map(|t| (shape(t), t)).filter(|x| x.0 < SLIM).collect();
            poor.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (_, t) in poor {
                steps += usize::from(self.work.mesh.is_triangle(t) && self.put_right(t, &mut guard, &mut zone));
            }
            if steps == 0 {
                break;
            }
            guard = CrossingGuard::new(&self.work.mesh);
        }
        let told = |(v, _, distance): (u32, DVec3, f64)| Off { at: self.point(v), distance };
        Ok(self.off(&nodes, rounding).into_iter().map(told).collect())
    }

    /// Nodes that are not where their pieces meet, with that place and how far it is.
    fn off(&self, nodes: &[u32], rounding: f64) -> Vec<(u32, DVec3, f64)> {
        let of = |v: &u32| {
            let q = self.place(*v)?;
            Some((*v, q, q.distance(self.point(*v)))).filter(|o| o.2 > rounding)
        };
        nodes.iter().filter(|v| self.work.mesh.is_node(**v)).filter_map(of).collect()
    }

    /// Where a node's pieces meet near it.
    fn place(&self, v: u32) -> Option<DVec3> {
        let (set, p, reach) = (self.work.sets[v as usize], self.point(v), self.want[v as usize]);
        match set.len() {
            3 => self.surface.meet(set.as_slice(), p, reach),
            _ => self.work.settle(self.surface, &set, p, reach),
        }
    }

    /// Puts a node back on its surfaces; whether that could be.
    fn returns(&mut self, v: u32, q: DVec3, guard: &mut CrossingGuard, zone: &mut [bool]) -> bool {
        let step = MendingStep::Move(v, q);
        let fine =
            |o: &StepOutcome| o.worst[1] >= o.worst[0].min(FAIR) && !guard.crosses(&self.work.mesh, &o.new, &o.gone);
        let outcome = if self.work.mesh.is_pinned(v) { None } else { self.outcome(step).filter(fine) };
        outcome.is_some_and(|o| self.take(step, &o, guard, zone))
    }

    /// Draws a node that cannot go back into one of its neighbors; whether that could be. Where two surfaces run into each other it is
    /// their many small triangles that would cross, and with fewer nodes nothing does.
    fn gives_way(&mut self, v: u32, guard: &mut CrossingGuard, zone: &mut [bool]) -> bool {
        let m = &self.work.mesh;
        if !m.is_node(v) || m.is_pinned(v) {
            return false;
        }
        let into = |h: u32| MendingStep::Collapse(h, self.point(m.target(h)));
        let fair = |o: &StepOutcome| o.worst[1] > 0.0 && o.worst[1] >= o.worst[0].min(FAIR);
        let ways = m.outgoing(v).filter(|h| self.may_collapse(*h)).map(into);
        let all = ways.filter_map(|s| Some((s, self.outcome(s).filter(fair)?))).collect();
        self.take_best(all, guard, zone)
    }

    /// Takes the step of the best shape of those after which nothing crosses; whether there is one.
    fn take_best(
        &mut self,
        mut all: Vec<(MendingStep, StepOutcome)>,
        guard: &mut CrossingGuard,
        zone: &mut [bool],
    ) -> bool {
        all.sort_by(|a, b| b.1.worst[1].total_cmp(&a.1.worst[1]));
        let fits = |x: &&(MendingStep, StepOutcome)| !guard.crosses(&self.work.mesh, &x.1.new, &x.1.gone);
        let Some(k) = all.iter().position(|x| fits(&x)) else { return false };
        let (step, outcome) = &all[k];
        self.take(*step, outcome, guard, zone)
    }

    /// Whether the origin of a side may go to its target.
    fn may_collapse(&self, h: u32) -> bool {
        let m = &self.work.mesh;
        let [from, to] = [m.origin(h), m.target(h)].map(|v| self.rank[v as usize]);
        m.opposite(h) != NONE && from <= to && (from == Rank::Face || (from == Rank::Curve && m.is_sharp(h)))
    }

    /// Takes the step that raises the worst shape around a triangle the most; whether there is one.
    fn put_right(&mut self, t: u32, guard: &mut CrossingGuard, zone: &mut [bool]) -> bool {
        let steps: Vec<MendingStep> = (3 * t..3 * t + 3).flat_map(|h| self.steps(h)).collect();
        let gains = |o: &StepOutcome| o.worst[1] > o.worst[0] + GAIN;
        let all = steps.into_iter().filter_map(|s| Some((s, self.outcome(s).filter(gains)?))).collect();
        self.take_best(all, guard, zone)
    }

    /// Steps at a side of a triangle and its origin.
    fn steps(&self, h: u32) -> Vec<MendingStep> {
        let m = &self.work.mesh;
        let a = m.origin(h);
        let sides = [h, m.opposite(h)].into_iter().filter(|s| *s != NONE && self.may_collapse(*s));
        let mut out = vec![MendingStep::Flip(h)];
        out.extend(sides.map(|s| MendingStep::Collapse(s, self.point(m.target(s)))));
        let near: Vec<DVec3> = match self.rank[a as usize] {
            Rank::Face => m.neighbors(a).map(|v| self.point(v)).collect(),
            Rank::Curve => m.sharp_neighbors(a).map(|v| self.point(v)).collect(),
            Rank::Corner => return out,
        };
        let (p, middle) = (self.point(a), near.iter().sum::<DVec3>() / near.len() as f64);
        let set = self.work.sets[a as usize];
        let place = |share: f64| self.work.settle(self.surface, &set, p.lerp(middle, share), self.want[a as usize]);
        out.extend(SHARES.into_iter().filter_map(place).map(|q| MendingStep::Move(a, q)));
        out
    }

    /// What a step would do, where the mesh allows it.
    fn outcome(&self, step: MendingStep) -> Option<StepOutcome> {
        let m = &self.work.mesh;
        let shape = |t: u32, at: [DVec3; 3]| self.work.shape_at(self.surface, m.label(t), at);
        let (mut new, mut then) = (Vec::new(), f64::INFINITY);
        let mut add = |t: u32, nodes: [u32; 3], at: [DVec3; 3]| {
            then = f64::min(then, shape(t, at));
            new.push(Changed { nodes, at });
        };
        let gone: Vec<u32> = match step {
            MendingStep::Flip(h) => {
                let o = m.opposite(h);
                if o == NONE || m.is_sharp(h) || !m.can_flip(h) {
                    return None;
                }
                let nodes = [m.origin(h), m.target(h), m.apex(h), m.apex(o)];
                let [a, b, c, d] = nodes;
                let [p, q, r, s] = nodes.map(|v| self.point(v));
                add(h / 3, [a, d, c], [p, s, r]);
                add(o / 3, [d, b, c], [s, q, r]);
                vec![h / 3, o / 3]
            }
            MendingStep::Move(v, p) => {
                for e in m.outgoing(v) {
                    let (x, y) = (m.target(e), m.apex(e));
                    add(e / 3, [v, x, y], [p, self.point(x), self.point(y)]);
                }
                m.outgoing(v).map(|e| e / 3).collect()
            }
            MendingStep::Collapse(h, p) => {
                if !m.can_collapse(h) {
                    return None;
                }
                let (a, b) = (m.origin(h), m.target(h));
                let dying = [h / 3, m.opposite(h) / 3];
                let around = || m.outgoing(a).chain(m.outgoing(b));
                for e in around().filter(|e| !dying.contains(&(e / 3))) {
                    let (x, y) = (m.target(e), m.apex(e));
                    add(e / 3, [b, x, y], [p, self.point(x), self.point(y)]);
                }
                around().map(|e| e / 3).collect()
            }
        };
        let now = gone.iter().map(|t| shape(*t, m.corner_points(*t))).fold(f64::INFINITY, f64::min);
        Some(StepOutcome { new, gone, worst: [now, then] })
    }

    fn take(&mut self, step: MendingStep, outcome: &StepOutcome, guard: &mut CrossingGuard, zone: &mut [bool]) -> bool {
        let taken = match step {
            MendingStep::Flip(h) => self.work.mesh.flip(h),
            MendingStep::Move(v, p) => {
                self.work.mesh.set_point(v, p);
                true
            }
            MendingStep::Collapse(h, p) => {
                let to = self.work.mesh.target(h);
                let collapsed = self.work.mesh.collapse(h, p);
                if collapsed {
                    self.mark_around(to);
                }
                collapsed
            }
        };
        if taken {
            let left: Vec<u32> = outcome.gone.iter().copied().filter(|t| self.work.mesh.is_triangle(*t)).collect();
            left.iter().for_each(|t| zone[*t as usize] = true);
            guard.note(&self.work.mesh, &left);
        }
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pieces;
    use crate::implicit::{ExtractOptions, Implicit, ImplicitOracle, RSystem, Solid, extract};
    use crate::mesh::{TriMesh, self_intersections};
    use crate::remesh::RemeshOptions;
    use crate::remesh::patchwork::{Patchwork, PiecePatch, PieceSet};
    use crate::run::Run;
    use crate::sizing::Sizing;

    /// The top of a cylinder in eight triangles, the node in their middle below it at the height of a chord. Something stands where it
    /// should be: there it cannot go, but where it is it is not needed.
    #[test]
    fn nodes_that_cannot_go_back_give_way() {
        let run = Run::new();
        let solid =
            Solid::cylinder(1.0, DVec3::X, DVec3::ZERO, None) & Solid::cuboid(DVec3::splat(-2.0), DVec3::splat(2.0));
        let model = Implicit::new(&solid, RSystem::default(), None).unwrap();
        let extracted = extract(&model, &ExtractOptions::new(0.25), &run).unwrap();
        let oracle = ImplicitOracle::new(&model, &extracted);
        let on = |x: f64, t: f64| DVec3::new(x, t.sin(), t.cos());
        let ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
        let mut nodes = vec![DVec3::new(0.0, 0.0, 0.4f64.cos())];
        nodes.extend(ring.map(|(i, k)| on(0.3 * f64::from(i), 0.4 * f64::from(k))));
        let mut triangles: Vec<[u32; 3]> = (0..8).map(|k| [0, 1 + k, 1 + (k + 1) % 8]).collect();
        nodes.extend([[-0.02, 0.0, 0.95], [0.02, 0.0, 0.95], [0.0, 0.01, 1.05]].map(DVec3::from));
        triangles.push([9, 10, 11]);
        let labels = vec![0, 0, 0, 0, 0, 0, 0, 0, 1];
        let mesh =
            TriMesh { nodes, triangles, labels, faces: vec!["top".into(), "thing".into()], ..TriMesh::default() };
        let side = oracle.piece_at(on(0.1, 0.1)).unwrap();
        let outward = oracle.direction(side, DVec3::Z).unwrap().z.signum();
        let top = PiecePatch { piece: side, outward, plane: None, face: 0 };
        let thing = PiecePatch { piece: NONE, outward: 1.0, plane: None, face: 1 };
        let mut sets = vec![PieceSet::one(side); 9];
        sets.extend([PieceSet::of(&[]); 3]);
        let mut work = Patchwork::new(EditMesh::new(&mesh).unwrap(), sets, vec![top, thing].into());
        work.freeze(&[0, 1, 2, 3, 4, 5, 6, 7], 0.1);
        let (options, run) = (RemeshOptions::new(Sizing::uniform(0.3), 0.2), Run::new());
        let mut r = Remesher::new(work, &oracle, &options, &run).unwrap();
        assert_eq!(r.thaw().unwrap(), []);
        let made = r.work.mesh.to_mesh();
        assert_eq!((made.nodes.len(), made.triangles.len()), (11, 7));
        assert!(self_intersections(&made, &run).unwrap().is_empty());
        assert!(made.nodes[..8].iter().all(|p| (p.y.hypot(p.z) - 1.0).abs() < 1e-12));
    }
}
