//! Shortest ways over a triangle mesh: a way along nodes and middles of edges first, then the strip of triangles it runs through,
//! laid out flat, in which a string is pulled tight; where it bends around a node the strip is led past the node's other side.
//!
//! The string is the funnel of D. T. Lee, F. P. Preparata, "Euclidean shortest paths in the presence of rectilinear barriers", 1984.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::TriMesh;
use crate::error::{Error, Place, Result};
use crate::numeric::{FEW_ROUNDINGS, NONE, ROUNDING};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared, triangle_foot};

/// Nodes whose angles lack more than this of a full turn, radians, are tips.
const TIP: f64 = 0.2;
/// So many tips are tried for one way: each costs a search of its own, and with few of them a way around the wrong side of a tip stays.
const MOST_TIPS: usize = 64;
/// So many times as often as there are triangles in the strip it may be led past a node,
const ROUNDS: usize = 20;
/// and this many times more, for strips of few triangles: nodes that do not help are not tried again until one
/// does, so that the bounds only end what rounding keeps alive.
const MORE_ROUNDS: usize = 1000;

/// A way over a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshPath {
    /// Its points; between two of them it runs straight through one triangle.
    pub points: Vec<DVec3>,
    /// Its length, in the mesh's unit.
    pub length: f64,
}

/// The shortest way over a mesh between the points of it that are nearest to two points. It may run anywhere inside triangles.
///
/// *Guarantees*: a way that no change nearby makes shorter, that is a geodesic of the mesh, but for rounding; the same result each
/// time. Where the mesh can be laid flat around the way, as across the edges of a box or around a cylinder, it is exact.
/// *Does not guarantee*: the shortest of all ways. Where several ways pass an obstacle on different sides, and none can be changed
/// into another without growing first, the one that is found may be longer than the best. Around up to 64 tips near it, such as
/// corners of boxes, both sides are tried. It starts from the shortest way
/// along nodes and middles of edges, so it is never longer than that.
/// *Errors*: [`Error::Input`] for points that are not finite, a mesh without triangles or with wrong indices, and two points on
/// pieces that do not hang together; cancellation.
pub fn shortest_path(mesh: &TriMesh, from: DVec3, to: DVec3, run: &Run) -> Result<MeshPath> {
    mesh.validate()?;
    let net = PathNet::new(mesh);
    let (start, end) = (net.foot(from)?, net.foot(to)?);
    let Some(legs) = net.first_way(&start, &end, run)? else {
        let what = "no way over the mesh leads here: the points are on pieces that do not hang together";
        return Err(Error::input(Place::Point(end.point), what));
    };
    let mut path = MeshPath { points: vec![start.point], length: 0.0 };
    for leg in legs {
        path.points.extend(net.straightened(leg, run)?);
    }
    path.points.dedup();
    path.length = path.points.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, |all, x| all + x);
    Ok(path)
}

/// A point of a triangle.
struct OnMesh {
    triangle: u32,
    point: DVec3,
}

/// A part of the way through triangles, each of which has an edge in common with the next.
struct PathLeg {
    start: DVec3,
    end: DVec3,
    strip: Vec<u32>,
}

/// An edge between two triangles of a strip laid out flat, as seen along the way.
#[derive(Clone, Copy)]
struct Portal {
    left: DVec2,
    right: DVec2,
    /// The nodes at its left and right.
    nodes: [u32; 2],
}

/// A string pulled tight in a strip.
struct Tight {
    portals: Vec<Portal>,
    /// Its corners: the place, the portal and the node; the start and the end have none.
    corners: Vec<(DVec2, usize, u32)>,
    length: f64,
}

struct PathNet<'a> {
    mesh: &'a TriMesh,
    /// Edges by their nodes, and of each triangle.
    edges: Vec<[u32; 2]>,
    edges_of: Vec<[u32; 3]>,
    /// Triangles at each edge, and at each node.
    at_edge: Vec<Vec<u32>>,
    at_node: Vec<Vec<u32>>,
}

impl<'a> PathNet<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let mut known: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let (mut edges, mut at_edge) = (Vec::new(), Vec::new());
        let mut at_node = vec![Vec::new(); mesh.nodes.len()];
        let mut edges_of = Vec::with_capacity(mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            edges_of.push([0, 1, 2].map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let key = [a.min(b), a.max(b)];
                let e = *known.entry(key).or_insert_with(|| {
                    edges.push(key);
                    at_edge.push(Vec::new());
                    edges.len() as u32 - 1
                });
                at_edge[e as usize].push(t as u32);
                e
            }));
            corners.iter().for_each(|v| at_node[*v as usize].push(t as u32));
        }
        Self { mesh, edges, edges_of, at_edge, at_node }
    }

    fn node(&self, v: u32) -> DVec3 {
        self.mesh.nodes[v as usize]
    }

    fn foot(&self, p: DVec3) -> Result<OnMesh> {
        if !p.is_finite() {
            return Err(Error::input(Place::Unknown, "a way needs finite points at its start and its end"));
        }
        let all = 0..self.mesh.triangles.len();
        let tree = Bvh::new(all.map(|t| Aabb::around(self.mesh.corners(t))).collect());
        let near = |t: u32| triangle_distance_squared(p, self.mesh.corners(t as usize));
        let Some((triangle, _)) = tree.nearest(p, f64::INFINITY, near) else {
            return Err(Error::input(Place::Point(p), "there is no triangle to walk on"));
        };
        let corners = self.mesh.corners(triangle as usize);
        let w = triangle_foot(p, corners);
        Ok(OnMesh { triangle, point: w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2] })
    }

    /// The place of a stop: a node, or the middle of an edge.
    fn stop(&self, s: u32) -> DVec3 {
        let n = self.mesh.nodes.len();
        match self.edges.get((s as usize).wrapping_sub(n)) {
            Some([a, b]) => 0.5 * (self.node(*a) + self.node(*b)),
            None => self.node(s),
        }
    }

    fn stops_of(&self, t: u32) -> [u32; 6] {
        let (n, [a, b, c]) = (self.mesh.nodes.len() as u32, self.mesh.triangles[t as usize]);
        let [d, e, f] = self.edges_of[t as usize];
        [a, b, c, n + d, n + e, n + f]
    }

    fn triangles_at(&self, s: u32) -> &[u32] {
        let n = self.mesh.nodes.len();
        if (s as usize) < n { &self.at_node[s as usize] } else { &self.at_edge[s as usize - n] }
    }

    /// The shortest way along stops, as strips of triangles (E. W. Dijkstra, 1959); `None` where there is none.
    fn first_way(&self, start: &OnMesh, end: &OnMesh, run: &Run) -> Result<Option<Vec<PathLeg>>> {
        let whole = |strip| PathLeg { start: start.point, end: end.point, strip };
        if start.triangle == end.triangle {
            return Ok(Some(vec![whole(vec![start.triangle])]));
        }
        let count = self.mesh.nodes.len() + self.edges.len();
        let mut way = vec![f64::INFINITY; count];
        // The stop before, and the triangle between the two.
        let mut before = vec![[NONE; 2]; count];
        let mut open = BinaryHeap::new();
        for s in self.stops_of(start.triangle) {
            let d = self.stop(s).distance(start.point);
            if d < way[s as usize] {
                (way[s as usize], before[s as usize]) = (d, [NONE, start.triangle]);
                // Lengths are not negative: their bits ascend as they do.
                open.push(Reverse((d.to_bits(), s)));
            }
        }
        let last = self.stops_of(end.triangle);
        let (mut best, mut best_stop, mut steps) = (f64::INFINITY, NONE, 0_usize);
        while let Some(Reverse((bits, s))) = open.pop() {
            steps += 1;
            if steps.is_multiple_of(4096) {
                run.check()?;
            }
            let d = f64::from_bits(bits);
            if d >= best {
                break;
            }
            if d > way[s as usize] {
                continue;
            }
            let p = self.stop(s);
            if last.contains(&s) && d + p.distance(end.point) < best {
                (best, best_stop) = (d + p.distance(end.point), s);
            }
            for &t in self.triangles_at(s) {
                for next in self.stops_of(t) {
                    let longer = d + self.stop(next).distance(p);
                    if longer < way[next as usize] {
                        (way[next as usize], before[next as usize]) = (longer, [s, t]);
                        open.push(Reverse((longer.to_bits(), next)));
                    }
                }
            }
        }
        if best_stop == NONE {
            return Ok(None);
        }
        // Stops from the end to the start, each with the triangle that leads on from it.
        let (mut list, mut at, mut after) = (Vec::new(), best_stop, end.triangle);
        while at != NONE {
            list.push((at, after));
            [at, after] = before[at as usize];
        }
        let mut legs = vec![whole(vec![start.triangle])];
        for (s, t) in list.into_iter().rev() {
            let leg = legs.len() - 1;
            let tail = legs[leg].strip[legs[leg].strip.len() - 1];
            if t == tail {
                continue;
            }
            if s as usize >= self.mesh.nodes.len() {
                legs[leg].strip.push(t);
            } else if let Some(fan) = self.fan(s, tail, t, &[]) {
                legs[leg].strip.extend(&fan[1..]);
            } else {
                // Two fans with one node in common: the way must lead through it.
                legs[leg].end = self.node(s);
                legs.push(PathLeg { start: self.node(s), ..whole(vec![t]) });
            }
        }
        Ok(Some(legs))
    }

    /// Triangles around a node from one to another, both included, by edges at the node and not through some others. With the two
    /// as all there is to avoid, not straight from one to the other either.
    fn fan(&self, v: u32, from: u32, to: u32, without: &[u32]) -> Option<Vec<u32>> {
        let mut before: FxHashMap<u32, u32> = FxHashMap::from_iter([(from, NONE)]);
        let mut queue = VecDeque::from([from]);
        while let Some(t) = queue.pop_front() {
            if t == to {
                let mut fan = vec![t];
                while let Some(b) = before.get(&fan[fan.len() - 1]).filter(|b| **b != NONE) {
                    fan.push(*b);
                }
                fan.reverse();
                return Some(fan);
            }
            for e in self.edges_of[t as usize] {
                if !self.edges[e as usize].contains(&v) {
                    continue;
                }
                for &next in &self.at_edge[e as usize] {
                    let barred = match without {
                        [a, b] => [t, next] == [*a, *b],
                        _ => without.contains(&next) && next != to,
                    };
                    if !barred && !before.contains_key(&next) {
                        before.insert(next, t);
                        queue.push_back(next);
                    }
                }
            }
        }
        None
    }

    /// Points of a leg after its start, once nothing makes it shorter.
    fn straightened(&self, leg: PathLeg, run: &Run) -> Result<Vec<DVec3>> {
        let (mut leg, mut tight) = self.tightened(leg, run)?;
        // A tip can be passed on both sides without a bend: where there is one, both ways are tried.
        let mut tried: FxHashSet<u32> = FxHashSet::default();
        for _ in 0..MOST_TIPS {
            let nodes = leg.strip.iter().flat_map(|t| self.mesh.triangles[*t as usize]);
            let Some(v) = nodes.into_iter().find(|v| !tried.contains(v) && self.is_tip(*v)) else { break };
            tried.insert(v);
            let Some(strip) = self.past_the_other_side(&leg, v).filter(|s| *s != leg.strip) else { continue };
            let (l, t) = self.tightened(PathLeg { strip, ..leg }, run)?;
            // A way that is shorter by less than this share is not shorter: lengths in the plane have rounding in them.
            if t.length < tight.length * (1.0 - FEW_ROUNDINGS) {
                (leg, tight) = (l, t);
            }
        }
        Ok(self.points(&leg, &tight))
    }

    /// Whether angles around a node add up to much less than a full turn.
    fn is_tip(&self, v: u32) -> bool {
        let angle = |t: &u32| {
            let corners = self.mesh.triangles[*t as usize];
            let k = corners.iter().position(|w| *w == v).unwrap_or(0);
            let [p, q, r] = [0, 1, 2].map(|i| self.node(corners[(k + i) % 3]));
            (q - p).cross(r - p).length().atan2((q - p).dot(r - p))
        };
        TAU - self.at_node[v as usize].iter().map(angle).sum::<f64>() > TIP
    }

    /// A leg that no bend can be taken out of, and the string in it.
    fn tightened(&self, mut leg: PathLeg, run: &Run) -> Result<(PathLeg, Tight)> {
        leg.strip = without_rounds(&leg.strip);
        let mut tight = self.pulled(&leg);
        // Flips that did not help need not be tried again until another did.
        let mut tried: FxHashSet<u32> = FxHashSet::default();
        for _ in 0..ROUNDS * leg.strip.len() + MORE_ROUNDS {
            run.check()?;
            let Some(v) = tight.corners.iter().map(|c| c.2).find(|v| *v != NONE && !tried.contains(v)) else { break };
            let other = self.past_the_other_side(&leg, v).map(|strip| {
                let leg = PathLeg { strip, ..leg };
                let tight = self.pulled(&leg);
                (leg, tight)
            });
            match other {
                Some((l, t)) if t.length < tight.length * (1.0 - FEW_ROUNDINGS) => {
                    (leg, tight) = (l, t);
                    tried.clear();
                }
                _ => {
                    tried.insert(v);
                }
            }
        }
        Ok((leg, tight))
    }

    /// The strip led around a node the other way, where there are triangles on that side.
    fn past_the_other_side(&self, leg: &PathLeg, v: u32) -> Option<Vec<u32>> {
        let has = |t: &u32| self.mesh.triangles[*t as usize].contains(&v);
        let first = leg.strip.iter().position(has)?;
        let count = leg.strip[first..].iter().take_while(|t| has(t)).count();
        let last = first + count - 1;
        let without = if count > 2 { &leg.strip[first..=last] } else { &leg.strip[first..first + count] };
        let fan = self.fan(v, leg.strip[first], leg.strip[last], without)?;
        let all = [&leg.strip[..first], &fan, &leg.strip[last + 1..]].concat();
        Some(without_rounds(&all))
    }

    /// Lays a strip out flat and pulls the string in it.
    fn pulled(&self, leg: &PathLeg) -> Tight {
        let corners = self.mesh.triangles[leg.strip[0] as usize];
        let [a, b, c] = corners.map(|v| self.node(v));
        let (x, y) = (b - a).cross(c - a).normalize_or(DVec3::Z).any_orthonormal_pair();
        // Nodes of the triangle, so that it lies to the left of its sides, and their places.
        let mut here = corners;
        let mut at = [a, b, c].map(|p| DVec2::new((p - a).dot(x), (p - a).dot(y)));
        if (at[1] - at[0]).perp_dot(at[2] - at[0]) < 0.0 {
            at.iter_mut().for_each(|p| p.y = -p.y);
        }
        let start = placed(leg.start, [a, b, c], at);
        let mut portals = Vec::with_capacity(leg.strip.len());
        for t in &leg.strip[1..] {
            let next = self.mesh.triangles[*t as usize];
            let Some(k) = (0..3).find(|k| next.contains(&here[*k]) && next.contains(&here[(k + 1) % 3])) else { break };
            let (i, j) = (k, (k + 1) % 3);
            let (u, v) = (here[i], here[j]);
            portals.push(Portal { left: at[j], right: at[i], nodes: [v, u] });
            let w = next.into_iter().find(|w| *w != u && *w != v).unwrap_or(u);
            let (p, along) = (self.node(u), self.node(v) - self.node(u));
            let length = along.length();
            let off = self.node(w) - p;
            let s = if length > 0.0 { off.dot(along) / length } else { 0.0 };
            let h = (off.length_squared() - s * s).max(0.0).sqrt();
            let x = (at[j] - at[i]).normalize_or(DVec2::X);
            // To the right of the edge, as the triangle before lies to its left.
            let far = at[i] + s * x - h * x.perp();
            (here, at) = ([v, u, w], [at[j], at[i], far]);
        }
        let end = placed(leg.end, here.map(|v| self.node(v)), at);
        let mut corners = funnel(start, &portals, end);
        corners.insert(0, (start, 0, NONE));
        corners.push((end, portals.len(), NONE));
        let length = corners.windows(2).map(|w| w[0].0.distance(w[1].0)).sum();
        Tight { portals, corners, length }
    }

    /// Where the string crosses the edges of the strip, in space, and its end.
    fn points(&self, leg: &PathLeg, tight: &Tight) -> Vec<DVec3> {
        let mut out = Vec::with_capacity(tight.portals.len() + 1);
        let (mut k, mut last) = (0, tight.corners[0].0);
        for (i, portal) in tight.portals.iter().enumerate() {
            // The piece of the string that crosses this edge.
            while k + 2 < tight.corners.len() && tight.corners[k + 1].1 < i {
                k += 1;
            }
            let (p, q) = (tight.corners[k].0, tight.corners[k + 1].0);
            let (d, e) = (q - p, portal.left - portal.right);
            let det = d.perp_dot(e);
            // Where the string runs along an edge it is on it from where it was before.
            // String and edge at an angle of a smaller sine are one line.
            let share = if det.abs() > ROUNDING * d.length() * e.length() {
                d.perp_dot(p - portal.right) / det
            } else {
                (last - portal.right).dot(e) / e.length_squared()
            };
            let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
            last = portal.right.lerp(portal.left, share);
            let [left, right] = portal.nodes.map(|v| self.node(v));
            out.push(right.lerp(left, share));
        }
        out.push(leg.end);
        out
    }
}

/// The place in the plane of a point of a triangle.
fn placed(p: DVec3, corners: [DVec3; 3], at: [DVec2; 3]) -> DVec2 {
    let w = triangle_foot(p, corners);
    w[0] * at[0] + w[1] * at[1] + w[2] * at[2]
}

/// A strip without what leads back to a triangle it has been in.
fn without_rounds(strip: &[u32]) -> Vec<u32> {
    let mut out: Vec<u32> = Vec::with_capacity(strip.len());
    let mut place: FxHashMap<u32, usize> = FxHashMap::default();
    for t in strip {
        if let Some(&i) = place.get(t) {
            out.drain(i + 1..).for_each(|t| {
                place.remove(&t);
            });
        } else {
            place.insert(*t, out.len());
            out.push(*t);
        }
    }
    out
}

/// The corners of the shortest way through portals, each with its portal and node.
fn funnel(start: DVec2, portals: &[Portal], end: DVec2) -> Vec<(DVec2, usize, u32)> {
    let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    let goal = Portal { left: end, right: end, nodes: [NONE; 2] };
    let mut out: Vec<(DVec2, usize, u32)> = Vec::new();
    // The tip of the funnel, and its two sides with the portals and nodes they end at.
    let mut apex = start;
    let (mut left, mut right) = ((start, 0, NONE), (start, 0, NONE));
    let mut i = 0;
    while i <= portals.len() {
        let p = portals.get(i).unwrap_or(&goal);
        let mut turned = None;
        if side(apex, right.0, p.right) >= 0.0 {
            if apex == right.0 || side(apex, left.0, p.right) < 0.0 {
                right = (p.right, i, p.nodes[1]);
            } else {
                turned = Some(left);
            }
        }
        if turned.is_none() && side(apex, left.0, p.left) <= 0.0 {
            if apex == left.0 || side(apex, right.0, p.left) > 0.0 {
                left = (p.left, i, p.nodes[0]);
            } else {
                turned = Some(right);
            }
        }
        i += 1;
        if let Some(corner) = turned {
            // At the goal both sides meet: what is left is straight.
            if corner.2 == NONE {
                break;
            }
            if out.last().is_none_or(|c| c.2 != corner.2) {
                out.push(corner);
            }
            apex = corner.0;
            (left, right) = ((apex, corner.1, corner.2), (apex, corner.1, corner.2));
            i = corner.1 + 1;
        }
    }
    out
}
