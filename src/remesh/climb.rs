//! Moving one node up to where the worst triangle around it is best.

use glam::DVec3;

use super::judge::{NodeAt, plain_shape};
use super::moves::CALM;
use super::patchwork::PieceSet;
use super::remesher::{Rank, Remesher};
use super::stages::STUCK;

/// Mending makes edges of borders at most this many times longer or shorter than wanted.
const UNEVEN: f64 = 1.1;

/// Edges longer than this many times what any node around wants are no good to anyone: cells are four times the size at most, and nodes are
/// packed for the rest.
const RUN: f64 = 3.0;

/// What shapes may change by where a place in the tangent plane is put onto the surface.
const BENT: f64 = 0.05;

/// The same by angles where triangles face about the same way, and for a curve's tangent: for a way as long as the wanted length,
/// growing with the square of it.
const BOWED: [f64; 2] = [0.3, 1.0];

/// The third corner of the equilateral triangle on an edge, on the left of it seen along `up`.
fn equilateral(a: DVec3, b: DVec3, up: DVec3) -> DVec3 {
    0.5 * (a + b) + 0.5 * 3f64.sqrt() * up.normalize_or_zero().cross(b - a)
}

/// Where a node is after some steps, the worst shape there, its normal, and what shapes may change by beside it.
type Climb = (DVec3, f64, Option<DVec3>, Option<[f64; 2]>);

impl Remesher<'_> {
    /// How far from where it was put a node may come to lie on the surface: its edges tell how far it is known there. Farther away there is another
    /// part of the surface, or a place of its leaf that is none of the solid's.
    pub(super) fn reach(&self, v: u32) -> f64 {
        let m = &self.work.mesh;
        let longest = m.outgoing(v).map(|h| m.edge_length(h)).fold(0.0, f64::max);
        self.want[v as usize].min(longest)
    }

    /// Whether shapes around a node that is moved `from` a point would surely not become better than `best` at a place that is still to be put onto the
    /// surface: by the normal or, where that is not known, whichever way triangles face.
    fn is_worse_at(&self, from: DVec3, to: NodeAt, best: f64, bow: Option<[f64; 2]>) -> bool {
        let NodeAt { node: v, point: to, normal } = to;
        let Some([grows, most]) = bow else { return false };
        let floor = best - most.min(grows * from.distance_squared(to) / self.want[v as usize].powi(2));
        if normal.is_some() {
            return self.worst_beside(v, to, normal, floor) < floor;
        }
        let m = &self.work.mesh;
        let plain = |h: u32| plain_shape([to, self.point(m.target(h)), self.point(m.apex(h))]);
        m.outgoing(v).filter(|h| !self.work.is_kept(h / 3)).any(|h| plain(h) < floor)
    }

    /// The worst shape around a node, were it at `p` with a normal that may be known; any of those below `floor`.
    pub(super) fn worst_beside(&self, v: u32, p: DVec3, normal: Option<DVec3>, floor: f64) -> f64 {
        self.work.worst_triangle(self.surface, NodeAt { node: v, point: p, normal }, floor).0
    }

    /// The normal at a node inside a face: whether a move may help is then seen without asking the surface, as the surface is
    /// nearly a plane over the length of a step.
    fn normal_within(&self, v: u32, p: DVec3) -> Option<DVec3> {
        let inside = self.rank[v as usize] == Rank::Face && self.work.sets[v as usize].len() == 1;
        let h = self.work.mesh.outgoing(v).next().filter(|_| inside)?;
        Some(self.work.normal(self.surface, self.work.mesh.label(h / 3), p))
    }

    /// Below which share of the square of a way shapes change by less where a place that far away is put onto the surface, or
    /// its curve, and what they change by at most; nothing of the kind is known for a curve but by angles.
    fn bow(&self, v: u32, alike: bool) -> Option<[f64; 2]> {
        let m = &self.work.mesh;
        let flat = |h: u32| self.work.patches[m.label(h / 3) as usize].plane.is_some();
        match (self.rank[v as usize], self.work.policy.judge.is_by_angles()) {
            (Rank::Face, _) if m.outgoing(v).next().is_some_and(flat) => Some([0.0; 2]),
            (Rank::Face, true) if alike => Some([BOWED[0], BENT]),
            (Rank::Face, _) => Some([f64::INFINITY, BENT]),
            (_, by_angles) => by_angles.then_some([BOWED[1], f64::INFINITY]),
        }
    }

    /// Moves a node towards the place where the worst triangle around it is equilateral, as far as that helps, again and
    /// again. Returns where it is then, the worst shape there, the [normal](Self::normal_within), and the [bow](Self::bow).
    fn climbed_to_apex(&mut self, v: u32, limit: f64, reach: f64, set: &PieceSet) -> Climb {
        /// Moves in a row: the worst triangle may be another after each, and more of them gain little.
        const STEPS: usize = 4;
        let mut p = self.point(v);
        let up = if self.rank[v as usize] == Rank::Face { self.work.worst_now(self.surface, v).1 } else { None };
        let mut normal = up.or_else(|| self.normal_within(v, p));
        let bow = self.bow(v, up.is_some()).filter(|_| self.work.policy.judge.is_by_angles() || normal.is_some());
        let (mut best, mut worst) =
            self.work.worst_triangle(self.surface, NodeAt { node: v, point: p, normal }, f64::NEG_INFINITY);
        for _ in 0..STEPS {
            if best >= limit {
                break;
            }
            let m = &self.work.mesh;
            let apex = equilateral(self.point(m.target(worst)), self.point(m.apex(worst)), m.area_vector(worst / 3));
            let mut improved = false;
            for share in [0.6, 0.25, 0.1] {
                let place = p.lerp(apex, share);
                if self.is_worse_at(p, NodeAt { node: v, point: place, normal }, best, bow) {
                    continue;
                }
                let Some((x, there)) = self.work.settle_beside(self.surface, v, set, place, reach) else { continue };
                let there = there.or_else(|| self.normal_within(v, x));
                let (shape, h) =
                    self.work.worst_triangle(self.surface, NodeAt { node: v, point: x, normal: there }, best);
                if shape > best + 1e-4 && self.stays_even(v, x) && !self.runs_away(v, x, shape) {
                    (best, worst, p, normal, improved) = (shape, h, x, there, true);
                    break;
                }
            }
            if !improved {
                break;
            }
            self.work.mesh.set_point(v, p);
        }
        (p, best, normal, bow)
    }

    /// Whether a move of a node along a border leaves its edges there about as long as they shall be: longer ones would cut
    /// off more of a bend than was asked for.
    pub(super) fn stays_even(&self, v: u32, x: DVec3) -> bool {
        if self.leaves_crevice(v, x) {
            return false;
        }
        if self.rank[v as usize] != Rank::Curve {
            return true;
        }
        let [a, b] = self.work.along(v)[..] else { return false };
        let span = |p: DVec3| {
            let (l, r) = (self.point(a).distance(p), self.point(b).distance(p));
            (l.min(r), l.max(r))
        };
        let (now, then, want) = (span(self.point(v)), span(x), self.want[v as usize]);
        then.0 >= now.0.min(want / UNEVEN) && then.1 <= now.1.max(UNEVEN * want)
    }

    /// Whether a move of a node [stretches](Self::stretches) an edge of raw triangles.
    fn leaves_crevice(&self, v: u32, x: DVec3) -> bool {
        let (m, p) = (&self.work.mesh, self.point(v));
        let stretches = |h: u32| {
            let n = m.target(h);
            let q = self.point(n);
            self.stretches(m.label(h / 3), [v, n], q.distance(p), q.distance(x))
        };
        self.work.policy.is_raw() && m.outgoing(v).any(stretches)
    }

    /// Whether a move of a node that leaves a triangle around it turned over, of a shape below 0, makes the longest edge there longer, and far
    /// longer than any node there wants it: a fan that is folded has better angles the farther away its middle is, so that nothing else
    /// would hold it.
    pub(super) fn runs_away(&self, v: u32, x: DVec3, shape: f64) -> bool {
        if shape > 0.0 {
            return false;
        }
        let (m, p) = (&self.work.mesh, self.point(v));
        let (mut now, mut then, mut want) = (0f64, 0f64, self.want[v as usize]);
        for n in m.outgoing(v).map(|h| m.target(h)) {
            let q = self.point(n);
            (now, then) = (now.max(q.distance_squared(p)), then.max(q.distance_squared(x)));
            want = want.max(self.want[n as usize]);
        }
        then > now && then > (RUN * want).powi(2)
    }

    /// Moves a node to where the worst shape around it is best, or reaches `limit`; where the way to better triangles is not
    /// seen at once, by looking in six directions and halving the step.
    pub(super) fn climb(&mut self, v: u32, limit: f64) -> bool {
        let set = self.work.sets[v as usize];
        let rank = self.rank[v as usize];
        if rank == Rank::Corner || (rank == Rank::Curve && self.is_beside_tip(v)) {
            return false;
        }
        // What borders were spaced for here stays but for bad shapes; those spaced before had no look at what lies beside.
        let limit = if rank == Rank::Curve && !self.work.policy.spaced { limit.min(STUCK) } else { limit };
        let start = self.point(v);
        let reach = self.reach(v);
        let (mut p, mut best, mut normal, bow) = self.climbed_to_apex(v, limit, reach, &set);
        if best >= limit.min(CALM) {
            return p != start && self.stays_unfolded(v, start);
        }
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
            let up = normal.unwrap_or_else(|| self.work.normal(self.surface, patch, p));
            let Some((u, w)) = up.try_normalize().map(DVec3::any_orthonormal_pair) else {
                return p != start && self.stays_unfolded(v, start);
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
                let place = p + step * *d;
                if self.is_worse_at(p, NodeAt { node: v, point: place, normal }, best, bow) {
                    continue;
                }
                let Some((x, there)) = self.work.settle_beside(self.surface, v, &set, place, reach) else { continue };
                let there = there.or_else(|| self.normal_within(v, x));
                let s = self.worst_beside(v, x, there, best);
                if s > best + 1e-4 && self.stays_even(v, x) && !self.runs_away(v, x, s) {
                    (best, p, normal, improved) = (s, x, there, true);
                    if best >= limit {
                        break;
                    }
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
        if p == start {
            return false;
        }
        self.work.mesh.set_point(v, p);
        self.stays_unfolded(v, start)
    }

    /// Takes a node back to where it was if more triangles around it are folded now, by the normals at their middles: where the
    /// surface turns around a narrow edge the normal at the node says little of them. Returns whether it stayed.
    pub(super) fn stays_unfolded(&mut self, v: u32, start: DVec3) -> bool {
        if !self.work.policy.judge.is_by_angles() {
            return true;
        }
        let m = &self.work.mesh;
        let ring: Vec<u32> = m.outgoing(v).map(|h| h / 3).filter(|&t| !self.work.is_kept(t)).collect();
        let alike = |t: &u32| {
            let label = m.label(*t);
            self.common_way(ring.iter().copied().filter(|t| m.label(*t) == label)).is_some()
        };
        let doubtful: Vec<u32> = ring.iter().copied().filter(|t| !alike(t)).collect();
        if doubtful.is_empty() {
            return true;
        }
        let folded = |r: &Self| doubtful.iter().filter(|t| r.work.shape(r.surface, **t) <= 0.0).count();
        let (now, p) = (folded(self), self.point(v));
        if now == 0 {
            return true;
        }
        self.work.mesh.set_point(v, start);
        if folded(self) < now {
            return false;
        }
        self.work.mesh.set_point(v, p);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Patchwork, PiecePatch, RemeshOptions};
    use super::*;
    use crate::geometry::{Foot, Pieces, SurfaceOracle};
    use crate::mesh::{EditMesh, TriMesh};
    use crate::run::Run;
    use crate::sizing::Sizing;

    /// The plane z = 0.
    struct Flat;

    impl SurfaceOracle for Flat {
        fn project(&self, p: DVec3, _reach: f64) -> Option<Foot> {
            Some(Foot { point: DVec3::new(p.x, p.y, 0.0), normal: DVec3::Z, face: 0 })
        }

        fn curvatures(&self, _foot: &Foot) -> Option<[f64; 2]> {
            Some([0.0; 2])
        }
    }

    impl Pieces for Flat {
        fn piece_at(&self, _p: DVec3) -> Option<u32> {
            Some(0)
        }

        fn near(&self, _p: DVec3) -> Vec<u32> {
            vec![0]
        }

        fn meet(&self, _pieces: &[u32], p: DVec3, _reach: f64) -> Option<DVec3> {
            Some(DVec3::new(p.x, p.y, 0.0))
        }

        fn direction(&self, _piece: u32, _p: DVec3) -> Option<DVec3> {
            Some(DVec3::Z)
        }

        fn plane(&self, _piece: u32) -> Option<(DVec3, f64)> {
            Some((DVec3::Z, 0.0))
        }

        fn curvature(&self, _piece: u32, _p: DVec3) -> Option<f64> {
            Some(0.0)
        }

        fn bounds(&self, _pieces: &[u32], _p: DVec3) -> bool {
            true
        }

        fn apexes(&self) -> Vec<(u32, DVec3)> {
            Vec::new()
        }

        fn face_at(&self, _piece: u32, _p: DVec3) -> Option<u32> {
            Some(0)
        }
    }

    /// How far the middle of a fan comes from the middle of its rim, of radius 1, in forty climbs.
    fn climbed(rim: &[[f64; 2]]) -> f64 {
        let n = rim.len() as u32;
        let nodes = std::iter::once(DVec3::ZERO).chain(rim.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0))).collect();
        let triangles: Vec<[u32; 3]> = (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]).collect();
        let labels = vec![0; triangles.len()];
        let mesh = TriMesh { nodes, triangles, labels, faces: vec!["flat".into()], ..TriMesh::default() };
        let patch = PiecePatch { piece: 0, outward: 1.0, plane: Flat.plane(0), face: 0 };
        let sets = vec![PieceSet::one(0); mesh.nodes.len()];
        let work = Patchwork::new(EditMesh::new(&mesh).unwrap(), sets, vec![patch].into());
        let (options, run) = (RemeshOptions::new(Sizing::uniform(1.0), 0.2), Run::new());
        let mut r = Remesher::new(work, &Flat, &options, &run).unwrap();
        for _ in 0..40 {
            r.climb(0, 1.0);
        }
        r.point(0).length()
    }

    #[test]
    fn the_middle_of_a_fan_that_is_turned_over_stays_near_it() {
        let mut rim: Vec<[f64; 2]> =
            (0..6).map(|k| (std::f64::consts::FRAC_PI_3 * f64::from(k)).sin_cos().into()).collect();
        let away = climbed(&rim);
        assert!(away < 3.0, "{away}");
        rim.reverse();
        assert!(climbed(&rim) < 0.01);
    }
}
