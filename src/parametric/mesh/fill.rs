//! Triangles of one face: constrained Delaunay of its contours in the parameter domain, and nodes inside.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, FloatTriangulation, Point2, PositionInTriangulation, Triangulation};

use super::domain::Domain;
use super::flips;
use super::metric::{distortion, mean_metric};
use super::rings::TipRing;
use super::sheets::Sheets;
use crate::parametric::chart::Chart;
use crate::planar::{SegmentMeeting, crossings};
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Cells wider than this many wanted lengths are halved.
const WIDE: f64 = 1.35;
/// No node inside is nearer to a contour than this many wanted lengths.
const CLEAR: f64 = 0.6;
/// Faces never get more nodes than this inside.
const MOST_NODES: usize = 40_000_000;
/// Halving more cells than this for every node that is allowed takes as long as too many nodes do, whatever lies inside.
const CELLS_PER_NODE: usize = 8;
/// An edge inside whose middle is farther from the surface than this share of its length gets a node there: an arc of 90
/// degrees is 0.21 of its chord away.
const BEND: f64 = 0.3;
/// How often that is done.
const BENDS: usize = 8;
/// Where lengths per parameter differ this much over a face Delaunay's triangles of its domain are none in space.
const DISTORTED: f64 = 10.0;
/// Cells are not halved more often than this.
const DEEPEST: u32 = 48;

/// A face's triangles, counter-clockwise in the domain.
#[derive(Debug, Clone, Default)]
pub(super) struct Filled {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The sheet of each, or what its caller makes of it.
    pub(super) pieces: Vec<u32>,
    /// New nodes; numbering goes on from the domain's.
    pub(super) nodes: Vec<DVec3>,
    /// How many of them, the first ones, lie on cuts of the domain.
    pub(super) cuts: u32,
    /// The lengths wanted at them.
    pub(super) sizes: Vec<f64>,
}

/// Why a face has no triangles.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Unfilled {
    /// These edges cross others in the domain: finer ones may not.
    Crossing(Vec<u32>),
    /// Something else.
    Other(String),
}

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

struct Filler<'a> {
    chart: &'a Chart,
    cdt: Cdt,
    /// Parameters to coordinates of the triangulation.
    origin: DVec2,
    scale: DVec2,
    /// The node of every vertex of the triangulation.
    node: Vec<u32>,
    /// Size of the face in space.
    size: f64,
    /// Rings around tips of the face.
    fanned: Vec<TipRing>,
}

/// A domain to be filled.
#[derive(Clone, Copy)]
pub(super) struct DomainFilling<'a> {
    pub(super) chart: &'a Chart,
    pub(super) domain: &'a Domain,
    /// Lines between them get nodes before the rest.
    pub(super) sheets: Option<&'a Sheets>,
    pub(super) rings: &'a [TipRing],
    /// All nodes so far, the domain's own included,
    pub(super) points: &'a dyn Fn(u32) -> DVec3,
    /// and their number.
    pub(super) first: u32,
    /// The length wanted at parameters, at most `longest`.
    pub(super) size_at: &'a dyn Fn(DVec2, DVec3) -> f64,
    pub(super) longest: f64,
    /// Edges between these pairs of nodes are avoided.
    pub(super) doubled: &'a FxHashSet<[u32; 2]>,
    /// Nodes of all faces, and how many there may be.
    pub(super) count: &'a AtomicUsize,
    pub(super) most: usize,
}

/// Where nodes inside may be.
#[derive(Clone, Copy)]
struct InnerRoom<'a> {
    lo: DVec2,
    hi: DVec2,
    /// Which triangles are inside.
    inside: &'a [bool],
    /// Whether a point is far enough from what is there, for a length.
    clear: &'a dyn Fn(DVec3, f64) -> bool,
}

/// Fills a domain.
pub(super) fn fill(of: &DomainFilling<'_>) -> Result<Filled, Unfilled> {
    let DomainFilling { chart, domain, sheets, points, first, size_at, doubled, .. } = *of;
    let corners: Vec<DVec2> = domain.polygons.iter().flatten().map(|c| c.uv).collect();
    if corners.len() < 3 || !corners.iter().all(|c| c.is_finite()) {
        return Err(Unfilled::Other("the contour has no parameters".into()));
    }
    let (lo, hi) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.min(*c), b.max(*c)));
    let scale = mean_metric(chart, &corners);
    let extent = ((hi - lo) * scale).max_element();
    if !(extent > 0.0) {
        return Err(Unfilled::Other("the contour has no width".into()));
    }
    let size = Aabb::around(domain.polygons.iter().flatten().map(|c| points(c.node))).diagonal();
    let mut f = Filler {
        size,
        chart,
        cdt: Cdt::new(),
        origin: lo,
        scale: scale / extent,
        node: Vec::with_capacity(corners.len()),
        fanned: Vec::new(),
    };
    let odd = f.contours(domain)?;
    let (mut nodes, mut sizes) = (Vec::new(), Vec::new());
    let mut chains = f.fans(of, &mut nodes, &mut sizes);
    let inside = f.inside(&odd);
    let segments: Vec<[DVec3; 2]> = domain
        .polygons
        .iter()
        .flat_map(|p| (0..p.len()).map(move |i| [points(p[i].node), points(p[(i + 1) % p.len()].node)]))
        .collect();
    let border = Bvh::new(segments.iter().map(|s| Aabb::around(*s)).collect());
    let clear = |p: DVec3, h: f64| {
        border.nearest(p, CLEAR * h, |i| p.distance_squared(segment_foot(p, segments[i as usize]))).is_none()
    };
    let mut found = Vec::new();
    if let Some(s) = sheets {
        let room = InnerRoom { lo, hi, inside: &inside, clear: &clear };
        f.along_lines(s, &room, size_at, &mut found, &mut chains);
    }
    let lines = Bvh::new(chains.iter().map(|s| Aabb::around(*s)).collect());
    let clear = |p: DVec3, h: f64| {
        let near = |i: u32| p.distance_squared(segment_foot(p, chains[i as usize]));
        clear(p, h) && lines.nearest(p, CLEAR * h, near).is_none()
    };
    f.scatter(of, &InnerRoom { lo, hi, inside: &inside, clear: &clear }, &mut found)?;
    // Between a ring and its tip there is but the fan.
    found.retain(|x| !f.fanned.iter().any(|r| r.holds(x.0)));
    nodes.reserve(found.len());
    sizes.reserve(found.len());
    for (uv, p, h) in found {
        let size = h;
        let q = f.place(uv);
        let Ok(h) = f.cdt.insert(q) else { continue };
        if h.index() == f.node.len() {
            f.node.push(first + nodes.len() as u32);
            nodes.push(p);
            sizes.push(size);
        }
    }
    for _ in 0..BENDS {
        let more = f.bend(&odd, points, doubled, first, &mut nodes);
        if more.is_empty() {
            break;
        }
        sizes.extend(more.into_iter().zip(&nodes[sizes.len()..]).map(|(uv, p)| size_at(uv, *p)).collect::<Vec<_>>());
    }
    let inside = f.inside(&odd);
    let all = f.cdt.inner_faces().filter(|t| inside[t.fix().index()]);
    let mut all: Vec<[usize; 3]> = all.map(|t| t.vertices().map(|v| v.fix().index())).collect();
    if distortion(chart, [lo, hi]) > DISTORTED {
        f.flip(&mut all, points, first, &nodes);
    }
    let (mut triangles, mut pieces) = (Vec::new(), Vec::new());
    for t in all {
        let corners = t.map(|v| f.node[v]);
        let [a, b, c] = corners;
        if a != b && b != c && c != a {
            triangles.push(corners);
            let middle = t.into_iter().map(|v| f.parameters(v)).sum::<DVec2>() / 3.0;
            pieces.push(sheets.map_or(0, |s| s.sheet(chart, middle) as u32));
        }
    }
    cancel_flaps(&mut triangles, &mut pieces);
    if triangles.is_empty() {
        return Err(Unfilled::Other("the contour encloses nothing".into()));
    }
    Ok(Filled { triangles, pieces, nodes, cuts: 0, sizes })
}

/// Removes pairs of triangles that are each other's back: between copies of a pole a node may be joined to nothing but the
/// pole and one more node, and hang there as a flap.
fn cancel_flaps(triangles: &mut Vec<[u32; 3]>, pieces: &mut Vec<u32>) {
    let key = |t: &[u32; 3]| {
        let mut k = *t;
        k.sort_unstable();
        k
    };
    let mut seen: FxHashMap<[u32; 3], usize> = FxHashMap::default();
    let mut dead = vec![false; triangles.len()];
    for i in 0..triangles.len() {
        match seen.remove(&key(&triangles[i])) {
            Some(j) => (dead[i], dead[j]) = (true, true),
            None => {
                seen.insert(key(&triangles[i]), i);
            }
        }
    }
    let mut alive = dead.iter().map(|d| !d);
    triangles.retain(|_| alive.next().unwrap_or(true));
    let mut alive = dead.iter().map(|d| !d);
    pieces.retain(|_| alive.next().unwrap_or(true));
}

impl Filler<'_> {
    /// Turns edges to make triangles Delaunay's in space.
    fn flip(&self, triangles: &mut [[usize; 3]], points: &dyn Fn(u32) -> DVec3, first: u32, nodes: &[DVec3]) {
        let at = |v: u32| if v < first { points(v) } else { nodes[(v - first) as usize] };
        let corner = |v: usize| flips::Corner { uv: self.parameters(v), node: self.node[v], at: at(self.node[v]) };
        let corners: Vec<flips::Corner> = (0..self.node.len()).map(corner).collect();
        let handle = FixedVertexHandle::from_index;
        let fixed = |a: usize, b: usize| self.cdt.exists_constraint(handle(a), handle(b));
        flips::flip(triangles, &corners, &fixed);
    }

    fn place(&self, uv: DVec2) -> Point2<f64> {
        let q = (uv - self.origin) * self.scale;
        // The triangulation takes no numbers that are tiny but not zero.
        let tame = |x: f64| if x.abs() < 1e-30 { 0.0 } else { x };
        Point2::new(tame(q.x), tame(q.y))
    }

    /// Puts in the contours. Returns for every constraint how often contours run along it, modulo 2.
    fn contours(&mut self, domain: &Domain) -> Result<FxHashMap<[usize; 2], bool>, Unfilled> {
        let mut handles: Vec<Vec<FixedVertexHandle>> = Vec::new();
        for p in &domain.polygons {
            let mut row = Vec::with_capacity(p.len());
            for c in p {
                let q = self.place(c.uv);
                let h = self.cdt.insert(q).map_err(|e| Unfilled::Other(format!("{e:?}")))?;
                if h.index() == self.node.len() {
                    self.node.push(c.node);
                } else if self.node[h.index()] != c.node {
                    return Err(Unfilled::Other("two nodes have the same parameters".into()));
                }
                row.push(h);
            }
            handles.push(row);
        }
        let mut odd: FxHashMap<[usize; 2], bool> = FxHashMap::default();
        let mut fit = true;
        for row in &handles {
            for i in 0..row.len() {
                let (a, b) = (row[i], row[(i + 1) % row.len()]);
                if a == b {
                    continue;
                }
                let key = [a.index().min(b.index()), a.index().max(b.index())];
                *odd.entry(key).or_insert(false) ^= true;
                if self.cdt.exists_constraint(a, b) {
                    continue;
                }
                let fits = self.cdt.can_add_constraint(a, b);
                if fits {
                    self.cdt.add_constraint(a, b);
                }
                fit &= fits && self.cdt.exists_constraint(a, b);
            }
        }
        if fit {
            return Ok(odd);
        }
        let mut bad = self.crossed(domain, &handles);
        bad.sort_unstable();
        bad.dedup();
        Err(if bad.is_empty() { Unfilled::Other("cuts cross".into()) } else { Unfilled::Crossing(bad) })
    }

    /// Puts in rings around tips of the domain, joined to the nodes of contours on either side. Returns their edges in space.
    fn fans(&mut self, of: &DomainFilling<'_>, nodes: &mut Vec<DVec3>, sizes: &mut Vec<f64>) -> Vec<[DVec3; 2]> {
        let DomainFilling { domain, rings, points, first, size_at, .. } = *of;
        let mut segments = Vec::new();
        for ring in rings {
            let (axis, other) = (ring.pole.axis, 1 - ring.pole.axis);
            for p in &domain.polygons {
                let n = p.len();
                let on = |i: usize| p[i % n].uv[axis] == ring.pole.value;
                for start in (0..n).filter(|&i| on(i) && !on(i + n - 1)) {
                    let count = (0..n).take_while(|k| on(start + k)).count();
                    let (before, after) = (p[(start + n - 1) % n], p[(start + count) % n]);
                    let [a, b] = [p[start].uv[other], p[(start + count - 1) % n].uv[other]];
                    let parts = (ring.density * (b - a).abs()).round().max(1.0);
                    let mut last = (self.cdt.insert(self.place(before.uv)).ok(), points(before.node));
                    for k in 1..=parts as usize {
                        let mut uv = DVec2::ZERO;
                        (uv[axis], uv[other]) = (ring.at, a + (b - a) * k as f64 / parts);
                        let mut next = (None, points(after.node));
                        if k as f64 == parts {
                            next.0 = self.cdt.insert(self.place(after.uv)).ok();
                        } else if let Ok(h) = self.cdt.insert(self.place(uv)) {
                            if h.index() == self.node.len() {
                                self.node.push(first + nodes.len() as u32);
                                nodes.push(self.chart.at(uv));
                                sizes.push(size_at(uv, self.chart.at(uv)));
                            }
                            next = (Some(h), self.chart.at(uv));
                        }
                        if let (Some(x), Some(y)) = (last.0, next.0)
                            && x != y
                            && self.cdt.can_add_constraint(x, y)
                        {
                            self.cdt.add_constraint(x, y);
                            segments.push([last.1, next.1]);
                        }
                        last = next;
                    }
                    self.fanned.push(*ring);
                }
            }
        }
        segments
    }

    /// Edges whose contours cross others, or themselves, or run through nodes of others.
    fn crossed(&self, domain: &Domain, handles: &[Vec<FixedVertexHandle>]) -> Vec<u32> {
        let at = |h: &FixedVertexHandle| {
            let p = self.cdt.vertex(*h).position();
            DVec2::new(p.x, p.y)
        };
        let flat: Vec<Vec<DVec2>> = handles.iter().map(|row| row.iter().map(at).collect()).collect();
        // Contours may touch in a node they share, and run along each other from one such to the next.
        let ends = |[c, i]: [u32; 2]| {
            let row = &handles[c as usize];
            [row[i as usize], row[(i as usize + 1) % row.len()]]
        };
        let meets = |m: &SegmentMeeting| m.crosses || !ends(m.first).iter().any(|v| ends(m.second).contains(v));
        let edge = |[c, i]: [u32; 2]| domain.polygons[c as usize][i as usize].edge;
        let bad = crossings(&flat).into_iter().filter(meets).flat_map(|m| [edge(m.first), edge(m.second)]);
        bad.filter(|e| *e != u32::MAX).collect()
    }

    /// Which triangles (by index of the face) lie inside: an odd number of contours away from the outside.
    fn inside(&self, odd: &FxHashMap<[usize; 2], bool>) -> Vec<bool> {
        let count = self.cdt.num_all_faces();
        let mut state: Vec<Option<bool>> = vec![None; count];
        let outer = self.cdt.outer_face().fix();
        state[outer.index()] = Some(false);
        let mut queue = VecDeque::new();
        // The outer face is bordered by the hull.
        let mut visit = |e: spade::handles::DirectedEdgeHandle<'_, _, _, _, _>, from: bool, queue: &mut VecDeque<_>| {
            let t = e.rev().face().fix();
            if state[t.index()].is_none() {
                let (a, b) = (e.from().fix().index(), e.to().fix().index());
                let flip = odd.get(&[a.min(b), a.max(b)]).copied().unwrap_or(false);
                state[t.index()] = Some(from ^ flip);
                queue.push_back((t, from ^ flip));
            }
        };
        for e in self.cdt.convex_hull() {
            // The hull is walked with the outer face on the left or on the right; look from the outer one.
            let e = if e.face().is_outer() { e } else { e.rev() };
            visit(e, false, &mut queue);
        }
        while let Some((t, is)) = queue.pop_front() {
            if let Some(t) = self.cdt.face(t).as_inner() {
                for e in t.adjacent_edges() {
                    visit(e, is, &mut queue);
                }
            }
        }
        state.into_iter().map(|s| s.unwrap_or(false)).collect()
    }

    /// Nodes along the lines between sheets, as far apart as wanted, and the pieces of line between them.
    fn along_lines(
        &self,
        sheets: &Sheets,
        room: &InnerRoom<'_>,
        size_at: &dyn Fn(DVec2, DVec3) -> f64,
        found: &mut Vec<(DVec2, DVec3, f64)>,
        chains: &mut Vec<[DVec3; 2]>,
    ) {
        /// Nodes along one line, at most: where lengths vanish steps do not get on.
        const MOST_STEPS: usize = 100_000;
        let InnerRoom { lo, hi, inside, clear } = *room;
        let (axis, other) = (sheets.axis, 1 - sheets.axis);
        let period = self.chart.periods[axis];
        for (value, _) in &sheets.lines {
            let turns = period.map_or(0..=0, |p| {
                (((lo[axis] - value) / p).ceil() as i64)..=(((hi[axis] - value) / p).floor() as i64)
            });
            for turn in turns {
                let t = value + turn as f64 * period.unwrap_or(0.0);
                let place = |s: f64| if axis == 0 { DVec2::new(t, s) } else { DVec2::new(s, t) };
                let (mut s, mut last) = (lo[other], None);
                for _ in 0..MOST_STEPS {
                    if !(s < hi[other]) {
                        break;
                    }
                    let uv = place(s);
                    let [p, su, sv, ..] = self.chart.jet(uv);
                    let h = size_at(uv, p);
                    let fits = self.is_inside(uv, inside) && clear(p, h);
                    if fits {
                        found.push((uv, p, h));
                        chains.extend(last.map(|q| [q, p]));
                    }
                    last = fits.then_some(p);
                    let speed = if axis == 0 { sv.length() } else { su.length() };
                    // Up to the border in small steps, so that the first node is as near as may be.
                    let step = if fits { 1.0 } else { 0.2 } * h / speed.max(f64::MIN_POSITIVE);
                    s += step.min((hi[other] - lo[other]) / 8.0);
                }
            }
        }
    }

    /// Nodes inside: centers of cells that are halved, the longer side first, until they are as wide as wanted.
    fn scatter(
        &self,
        of: &DomainFilling<'_>,
        room: &InnerRoom<'_>,
        found: &mut Vec<(DVec2, DVec3, f64)>,
    ) -> Result<(), Unfilled> {
        let (DomainFilling { longest, size_at, count, .. }, InnerRoom { lo, hi, inside, clear }) = (*of, *room);
        let most = of.most.min(MOST_NODES);
        let at = |u: f64, v: f64| self.chart.at(DVec2::new(u, v));
        // Nine points of a cell: three rows along u. Halves have six of theirs from the whole.
        let three = |a: f64, b: f64| [a, 0.5 * (a + b), b];
        let column = |u: f64, a: DVec2, b: DVec2| three(a.y, b.y).map(|v| at(u, v));
        let whole = three(lo.x, hi.x).map(|u| column(u, lo, hi));
        let mut stack = vec![(lo, hi, 0u32, whole)];
        let mut halved = 0usize;
        while let Some((a, b, depth, grid)) = stack.pop() {
            let m = 0.5 * (a + b);
            let center = grid[1][1];
            // Near poles the middle of a wide cell is short; its borders are not.
            let rim = |p: DVec3, q: DVec3, r: DVec3| p.distance(q) + q.distance(r);
            let along = |k: usize| rim(grid[0][k], grid[1][k], grid[2][k]);
            let across = |k: usize| rim(grid[k][0], grid[k][1], grid[k][2]);
            let wide = [along(1).max(along(0)).max(along(2)), across(1).max(across(0)).max(across(2))];
            // Cells wider than any length asked for need not know theirs.
            let widest = wide[0].max(wide[1]);
            let surely = widest > WIDE * longest && depth < DEEPEST;
            let h = if surely { longest } else { size_at(m, center) };
            if widest > WIDE * h && depth < DEEPEST {
                halved += 1;
                if halved / CELLS_PER_NODE > most {
                    count.fetch_max(most.saturating_add(1), Ordering::Relaxed);
                }
                if count.load(Ordering::Relaxed) > most {
                    return Err(Unfilled::Other(format!("more than {most} nodes are needed")));
                }
                let halves = if wide[0] >= wide[1] {
                    let part =
                        |i: usize, p: DVec2, q: DVec2| (p, q, [grid[i], column(0.5 * (p.x + q.x), p, q), grid[i + 1]]);
                    [part(0, a, DVec2::new(m.x, b.y)), part(1, DVec2::new(m.x, a.y), b)]
                } else {
                    let part = |i: usize, p: DVec2, q: DVec2| {
                        let (u, v) = (three(p.x, q.x), 0.5 * (p.y + q.y));
                        (p, q, [0, 1, 2].map(|k| [grid[k][i], at(u[k], v), grid[k][i + 1]]))
                    };
                    [part(0, a, DVec2::new(b.x, m.y)), part(1, DVec2::new(a.x, m.y), b)]
                };
                for (p, q, grid) in halves.into_iter().rev() {
                    if depth < 6 || self.touches(p, q, inside) {
                        stack.push((p, q, depth + 1, grid));
                    }
                }
                continue;
            }
            if self.is_inside(m, inside) && clear(center, h) {
                found.push((m, center, h));
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    /// Edges inside that leave the surface too far, or that `doubled` says another face has too, get a node in their middle
    /// (in the domain, on the surface). Returns their parameters.
    fn bend(
        &mut self,
        odd: &FxHashMap<[usize; 2], bool>,
        points: &dyn Fn(u32) -> DVec3,
        doubled: &FxHashSet<[u32; 2]>,
        first: u32,
        nodes: &mut Vec<DVec3>,
    ) -> Vec<DVec2> {
        let inside = self.inside(odd);
        let at = |v: u32, nodes: &[DVec3]| if v < first { points(v) } else { nodes[(v - first) as usize] };
        // An arc that leaves its chord so far turns by a right angle: shorter edges need no look at the surface.
        let short = self.chart.surface.bend_radius().unwrap_or(0.0);
        let mut splits = Vec::new();
        // One split changes both triangles: their other edges wait for the next round.
        let mut taken = vec![false; inside.len()];
        for e in self.cdt.undirected_edges() {
            if e.is_constraint_edge() {
                continue;
            }
            let e = e.as_directed();
            if !inside[e.face().fix().index()] && !inside[e.rev().face().fix().index()] {
                continue;
            }
            let sides = [e.face().fix().index(), e.rev().face().fix().index()];
            if sides.iter().any(|t| taken[*t]) {
                continue;
            }
            let [a, b] = e.vertices().map(|v| v.fix().index());
            let [x, y] = [self.node[a], self.node[b]];
            let [p, q] = [at(x, nodes), at(y, nodes)];
            let asked = doubled.contains(&[x.min(y), x.max(y)]);
            if !asked && p.distance_squared(q) < short * short {
                continue;
            }
            let uv = 0.5 * (self.parameters(a) + self.parameters(b));
            let m = self.chart.at(uv);
            let away = m.distance(segment_foot(m, [p, q]));
            let far = away > BEND * p.distance(q) && away > 1e-6 * self.size;
            if far || asked {
                splits.push((uv, m));
                sides.iter().for_each(|t| taken[*t] = true);
            }
        }
        let mut made = Vec::new();
        for (uv, p) in splits {
            let Ok(h) = self.cdt.insert(self.place(uv)) else { continue };
            if h.index() == self.node.len() {
                self.node.push(first + nodes.len() as u32);
                nodes.push(p);
                made.push(uv);
            }
        }
        made
    }

    /// Parameters of a vertex of the triangulation.
    fn parameters(&self, vertex: usize) -> DVec2 {
        let p = self.cdt.vertex(FixedVertexHandle::from_index(vertex)).position();
        self.origin + DVec2::new(p.x, p.y) / self.scale
    }

    fn is_inside(&self, uv: DVec2, inside: &[bool]) -> bool {
        match self.cdt.locate(self.place(uv)) {
            PositionInTriangulation::OnFace(f) => inside[f.index()],
            PositionInTriangulation::OnEdge(e) => {
                let e = self.cdt.directed_edge(e);
                !e.is_constraint_edge() && inside[e.face().fix().index()]
            }
            _ => false,
        }
    }

    /// Whether a cell may hold a part of the inside.
    fn touches(&self, a: DVec2, b: DVec2, inside: &[bool]) -> bool {
        let m = 0.5 * (a + b);
        let probes = [m, a, b, DVec2::new(a.x, b.y), DVec2::new(b.x, a.y)];
        if probes.iter().any(|p| self.is_inside(*p, inside)) {
            return true;
        }
        // No probe is inside: only a contour that passes through the cell could be.
        let (p, q) = (self.place(a), self.place(b));
        let mut any = self.cdt.get_vertices_in_rectangle(p, q);
        any.next().is_some() || self.cdt.get_edges_in_rectangle(p, q).any(|e| e.is_constraint_edge())
    }
}
