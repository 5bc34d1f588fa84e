//! Borders across from each other along a narrow part of a patch: the nodes of one go between those of the other, so that the
//! row of triangles between them is even.

use glam::DVec3;

use super::curves::BorderChain;
use super::remesher::Remesher;
use crate::geometry::{ALIKE, ALONG, FIRST, Pair, Strips, WIDEST};
use crate::mesh::edit::NONE;
use crate::numeric::COS_60;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// The way along a border is looked at over this many steps to each side.
const BESIDE: f64 = 0.1;
/// A segment that turns by more from end to end than this (sine of half of it), 120 degrees, is no arc.
const MOST_BENT: f64 = 0.87;
/// Segments of more than so many steps are what spacing left.
const SPACED: f64 = 0.5;
/// Places looked at along a border: per step,
const PER_STEP: f64 = 2.0;
/// at least,
const FEWEST_PLACES: f64 = 6.0;
/// and at most.
const MOST_PLACES: f64 = 64.0;
/// Steps between nodes that lie between others are within these shares of an even step.
const EVEN: [f64; 2] = [0.5, 1.7];

/// A border as a line along which steps are counted.
pub(super) struct Track {
    pub(super) points: Vec<DVec3>,
    /// Steps up to each point: lengths over wanted lengths.
    pub(super) steps: Vec<f64>,
    /// Which of the points are nodes.
    pub(super) nodes: Vec<usize>,
    pub(super) closed: bool,
}

/// A part of a border where steps are others than its nodes want.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zone {
    /// Length along the border where it begins.
    pub(super) from: f64,
    /// Length along the border where it ends.
    pub(super) to: f64,
    pub(super) want: f64,
}

impl Track {
    pub(super) fn total(&self) -> f64 {
        self.steps[self.steps.len() - 1]
    }

    /// How many edges it asks for.
    pub(super) fn count(&self) -> usize {
        self.total().round().max(if self.closed { 3.0 } else { 1.0 }) as usize
    }

    /// Steps up to a node.
    pub(super) fn up_to(&self, node: usize) -> f64 {
        self.steps[self.nodes[node]]
    }

    /// The node, other than the first, that some steps come to last.
    fn before(&self, s: f64) -> usize {
        self.nodes.partition_point(|i| self.steps[*i] < s).clamp(1, self.nodes.len() - 1)
    }

    /// The point after some steps.
    pub(super) fn at(&self, s: f64) -> DVec3 {
        let i = self.steps.partition_point(|x| *x < s).clamp(1, self.steps.len() - 1) - 1;
        let t = (s - self.steps[i]) / (self.steps[i + 1] - self.steps[i]).max(f64::MIN_POSITIVE);
        self.points[i].lerp(self.points[i + 1], t.clamp(0.0, 1.0))
    }

    /// How many steps lead to the point nearest to a place.
    fn steps_to(&self, p: DVec3) -> f64 {
        let (mut best, mut at) = (f64::INFINITY, 0.0);
        for (i, w) in self.points.windows(2).enumerate() {
            let q = segment_foot(p, [w[0], w[1]]);
            let d = q.distance_squared(p);
            if d < best {
                let share = w[0].distance(q) / w[0].distance(w[1]).max(f64::MIN_POSITIVE);
                (best, at) = (d, self.steps[i] + share * (self.steps[i + 1] - self.steps[i]));
            }
        }
        at
    }

    /// Even places, in steps: those between the ends, or all around from the start on.
    pub(super) fn even(&self) -> Vec<f64> {
        let count = self.count();
        (usize::from(!self.closed)..count).map(|k| self.total() * k as f64 / count as f64).collect()
    }

    /// Places between those of the border it follows, whose points are `lead`, if they are about even; `inner` where the first
    /// and the last of those lie between others themselves.
    pub(super) fn between(&self, lead: &[DVec3], inner: bool) -> Option<Vec<f64>> {
        let middles = |w: &[DVec3]| self.steps_to(0.5 * (w[0] + w[1]));
        let mut places: Vec<f64> = lead.windows(2).map(middles).collect();
        if inner && !self.closed {
            places.pop();
            places = places.split_off(1.min(places.len()));
        }
        places.sort_by(f64::total_cmp);
        let (total, count) = (self.total(), places.len() as f64);
        let alike = |n: f64| n < ALIKE * total + 1.0 && total < ALIKE * n + 1.0;
        if places.len() < 2 || !alike(count + if inner { 1.0 } else { 0.0 }) {
            return None;
        }
        if self.closed {
            let step = total / count;
            let round = places[0] + total - places[places.len() - 1];
            let gaps = places.windows(2).map(|w| w[1] - w[0]).chain([round]);
            return gaps.into_iter().all(|g| g > EVEN[0] * step && g < EVEN[1] * step).then_some(places);
        }
        let step = total / if inner { count + 1.0 } else { count };
        if !inner {
            let first = (FIRST * step).min(total / 3.0);
            places.iter_mut().for_each(|s| *s = s.clamp(first, total - first));
        }
        let ends = [places[0], total - places[places.len() - 1]];
        let gaps = places.windows(2).map(|w| w[1] - w[0]).chain(ends);
        gaps.into_iter().all(|g| g > EVEN[0] * step && g < EVEN[1] * step).then_some(places)
    }
}

/// The arc over the chord of segment `i - 1` to `i` of a ring, for a circle that turns as the ring does from one end to the other:
/// without that a hole would get fewer nodes each time it is spaced. What turns to and fro is no arc.
fn arc(points: &[DVec3], i: usize) -> f64 {
    let last = points.len() - 1;
    let along = |k: usize| (points[k] - points[k - 1]).normalize_or_zero();
    let (before, own, after) =
        (along(if i > 1 { i - 1 } else { last }), along(i), along(if i < last { i + 1 } else { 1 }));
    if before.cross(own).dot(own.cross(after)) <= 0.0 {
        return 1.0;
    }
    // Half the angle between the directions at both ends, as a sine.
    let sine = 0.5 * (before + own).normalize_or_zero().distance((own + after).normalize_or_zero());
    if sine > 0.0 && sine < MOST_BENT { sine.asin() / sine } else { 1.0 }
}

impl Remesher<'_> {
    /// A border with the steps along it.
    pub(super) fn track(&self, chain: &BorderChain, zones: &[Zone]) -> Track {
        let places: Vec<DVec3> = chain.nodes.iter().map(|&v| self.point(v)).collect();
        let mut track = Track { points: vec![places[0]], steps: vec![0.0], nodes: vec![0], closed: chain.closed };
        let (mut length, mut sum) = (0.0, 0.0);
        for i in 1..places.len() {
            let (own, wants) =
                (places[i - 1].distance(places[i]), [i - 1, i].map(|i| self.want[chain.nodes[i] as usize]));
            let bounds = zones.iter().flat_map(|z| [z.from, z.to]).map(|s| (s - length) / own);
            let mut from = 0.0;
            for to in bounds.filter(|t| *t > 0.0 && *t < 1.0).chain([1.0]) {
                if !(to > from) {
                    continue;
                }
                let middle = 0.5 * (from + to);
                let at = length + middle * own;
                let zone = zones.iter().find(|z| z.from <= at && at <= z.to);
                let want = zone.map_or(wants[0] * (1.0 - middle) + wants[1] * middle, |z| z.want);
                let step = (to - from) * own / want;
                // A line that is not spaced yet is as long as it is.
                let ring = chain.closed && step > SPACED;
                sum += if ring { step * arc(&places, i) } else { step };
                track.points.push(if to == 1.0 { places[i] } else { places[i - 1].lerp(places[i], to) });
                track.steps.push(sum);
                from = to;
            }
            track.nodes.push(track.points.len() - 1);
            length += own;
        }
        track
    }

    /// Which borders go together.
    pub(super) fn strips(&self, chains: &[BorderChain], tracks: &[Track]) -> Strips {
        let m = &self.work.mesh;
        let patches = |c: &BorderChain| {
            let h = m.edge_between(c.nodes[0], c.nodes[1]).unwrap_or(NONE);
            if h == NONE {
                return [NONE; 2];
            }
            [h, m.opposite(h)].map(|s| if s == NONE { NONE } else { m.label(s / 3) })
        };
        let beside: Vec<[u32; 2]> = chains.iter().map(patches).collect();
        let ends = |c: usize| [chains[c].nodes[0], chains[c].nodes[chains[c].nodes.len() - 1]];
        let may = |a: usize, b: usize| {
            let common = beside[a].iter().any(|l| *l != NONE && beside[b].contains(l));
            let alike = |x: f64, y: f64| x < ALIKE * y + 1.0;
            let (s, t) = (tracks[a].total(), tracks[b].total());
            let meet = ends(a).iter().any(|v| ends(b).contains(v));
            a != b && common && !meet && chains[a].closed == chains[b].closed && alike(s, t) && alike(t, s)
        };
        let mut segments: Vec<([DVec3; 2], u32)> = Vec::new();
        for (c, track) in tracks.iter().enumerate() {
            segments.extend(track.points.windows(2).map(|w| ([w[0], w[1]], c as u32)));
        }
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(s.0)).collect());
        // For each border the one most of it has across from it.
        let partner = |c: usize| -> Option<u32> {
            let track = &tracks[c];
            let total = track.total();
            if !total.is_finite() || track.count() < 2 {
                return None;
            }
            let count = (PER_STEP * total).ceil().clamp(FEWEST_PLACES, MOST_PLACES);
            let mut found: Vec<u32> = Vec::new();
            for k in 0..count as usize {
                let s = total * (k as f64 + 0.5) / count;
                let (p, ahead) = (track.at(s), (track.at(s + BESIDE) - track.at(s - BESIDE)).normalize_or_zero());
                let i = track.before(s);
                let want = [i - 1, i].map(|i| self.want[chains[c].nodes[i] as usize]).into_iter().fold(0.0, f64::max);
                let away = |k: u32| {
                    let (segment, other) = segments[k as usize];
                    if !may(c, other as usize) {
                        return f64::INFINITY;
                    }
                    let way = segment_foot(p, segment) - p;
                    // The way across leaves a border at more than 60 degrees.
                    if way.dot(ahead).abs() > COS_60 * way.length() { f64::INFINITY } else { way.length_squared() }
                };
                let nearest = tree.nearest(p, WIDEST * want, away).filter(|n| n.1.is_finite());
                found.extend(nearest.map(|n| segments[n.0 as usize].1));
            }
            found.sort_unstable();
            let most = found.chunk_by(|a, b| a == b).max_by_key(|g| g.len())?;
            (most.len() as f64 >= ALONG * count).then_some(most[0])
        };
        let partners: Vec<Option<u32>> = (0..chains.len()).map(partner).collect();
        let mut pairs = Vec::new();
        for (a, b) in partners.iter().enumerate() {
            // The other one may have a third across from it.
            if let Some(b) = b.filter(|b| partners[*b as usize].is_some()) {
                let edges = [(a as u32).min(b), (a as u32).max(b)];
                pairs.push(Pair { edges, length: tracks[a].total() });
            }
        }
        Strips::new(chains.len(), pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    fn line(from: DVec3, to: DVec3, steps: usize) -> Track {
        let points = (0..=steps).map(|k| from.lerp(to, k as f64 / steps as f64)).collect();
        Track { points, steps: (0..=steps).map(|k| k as f64).collect(), nodes: (0..=steps).collect(), closed: false }
    }

    #[test]
    fn nodes_of_a_strip_lie_between_those_across() {
        let rail = |y: f64| line(DVec3::new(0.0, y, 0.0), DVec3::new(8.0, y, 0.0), 8);
        let lead: Vec<DVec3> = rail(0.0).points;
        let places = rail(0.5).between(&lead, false).unwrap();
        assert_eq!(places, [0.75, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.25]);
        // A third rail goes between those of the second, and so lies as the first.
        let mut second: Vec<DVec3> = places.iter().map(|s| rail(0.5).at(*s)).collect();
        second.insert(0, rail(0.5).at(0.0));
        second.push(rail(0.5).at(8.0));
        let third = rail(1.0).between(&second, true).unwrap();
        assert_eq!(third.len(), 7);
        assert!(third.iter().zip(1..).all(|(s, k)| (s - f64::from(k)).abs() < 0.13), "{third:?}");
        // What is far longer goes its own way.
        assert!(line(DVec3::ZERO, DVec3::X, 20).between(&lead, false).is_none());
    }

    #[test]
    fn a_coarse_ring_is_as_long_as_its_circle() {
        for n in [3, 4, 6, 24] {
            let at = |k: usize| {
                DVec3::new(
                    (std::f64::consts::TAU * k as f64 / n as f64).cos(),
                    (std::f64::consts::TAU * k as f64 / n as f64).sin(),
                    0.0,
                )
            };
            let points: Vec<DVec3> = (0..=n).map(|k| at(k % n)).collect();
            let length = |i: usize| points[i - 1].distance(points[i]) * arc(&points, i);
            let sum: f64 = (1..=n).map(length).sum();
            assert!(abs_diff_eq!(sum, std::f64::consts::TAU, epsilon = 1e-9), "{n}: {sum}");
        }
        // Turns to and fro do not make a line longer either.
        let zigzag: Vec<DVec3> = (0..9).map(|k| DVec3::new(f64::from(k), f64::from(k % 2), 0.0)).collect();
        assert!((2..8).all(|i| arc(&zigzag, i) == 1.0));
    }

    #[test]
    fn nodes_of_a_ring_lie_between_those_across() {
        let circle = |r: f64, n: usize| {
            let at = |k: usize| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
                r * DVec3::new(c, s, 0.0)
            };
            let steps = (0..=n).map(|k| 12.0 * k as f64 / n as f64).collect();
            Track { points: (0..=n).map(at).collect(), steps, nodes: (0..=n).collect(), closed: true }
        };
        let lead: Vec<DVec3> = circle(1.0, 12).points;
        let outer = circle(1.1, 96);
        let places = outer.between(&lead, false).unwrap();
        assert_eq!(places.len(), 12);
        for (k, s) in places.iter().enumerate() {
            assert!(abs_diff_eq!(*s, k as f64 + 0.5, epsilon = 0.01), "{places:?}");
        }
    }
}
