//! Narrow regions of one face: where they are, and what lies across from what.

use glam::{DVec2, DVec3};

use super::{EdgeLines, LONG};
use crate::numeric::{NONE, SEVEN_DIGITS};
use crate::parametric::brep::Brep;
use crate::parametric::chart::Chart;
use crate::parametric::mesh::domain::Cutter;
use crate::parametric::mesh::edges::ways;
use crate::parametric::mesh::loops::{Contour, Corner, Unroller};
use crate::parametric::mesh::metric::mean_metric;
use crate::planar::{self, Refusal, Spot};
use crate::spatial::{Aabb, segment_foot};

/// Regions are looked at in this many places of a side, at most.
const PLACES: f64 = 4000.0;
/// The domain shows lengths as they are in the mean: across, a region may be this much wider in space.
const WIDER: f64 = 1.5;

/// A piece of an edge between two points of a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub(super) edge: u32,
    pub(super) t: [f64; 2],
}

/// One side of a narrow region: points, which may be vertices, and the legs between them.
#[derive(Debug, Clone, Default)]
pub(super) struct RegionSide {
    pub(super) points: Vec<DVec3>,
    pub(super) vertices: Vec<Option<u32>>,
    pub(super) legs: Vec<Leg>,
}

/// A narrow region: its two sides, both from the same end of it, and which points of them lie across from each other.
#[derive(Debug, Clone)]
pub(super) struct NarrowRegion {
    pub(super) sides: [RegionSide; 2],
    /// Indices of points, ascending on both sides.
    pub(super) pairs: Vec<[usize; 2]>,
    /// The pairs between which each side is a piece of one edge.
    pub(super) joints: Vec<[usize; 2]>,
    /// Whether the face goes on at its two ends.
    pub(super) open: [bool; 2],
}

impl RegionSide {
    fn reversed(mut self) -> Self {
        self.points.reverse();
        self.vertices.reverse();
        self.legs.reverse();
        self.legs.iter_mut().for_each(|l| l.t.reverse());
        self
    }

    fn part(&self, from: usize, to: usize) -> Self {
        Self {
            points: self.points[from..=to].to_vec(),
            vertices: self.vertices[from..=to].to_vec(),
            legs: self.legs[from..to].to_vec(),
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.points.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    /// With points in between, nowhere farther apart than a width or a small share of its length.
    fn refined(&self, brep: &Brep, width: f64) -> Self {
        let spacing = width.max(self.length() / PLACES);
        let mut out = Self { points: vec![self.points[0]], vertices: vec![self.vertices[0]], legs: Vec::new() };
        for (i, leg) in self.legs.iter().enumerate() {
            let [p, q] = [self.points[i], self.points[i + 1]];
            let parts = if leg.edge == NONE { 1 } else { (p.distance(q) / spacing).ceil().max(1.0) as usize };
            let at = |k: usize| leg.t[0] + (leg.t[1] - leg.t[0]) * k as f64 / parts as f64;
            for k in 1..=parts {
                let last = k == parts;
                out.points.push(if last { q } else { brep.edges[leg.edge as usize].curve.at(at(k)) });
                out.vertices.push(if last { self.vertices[i + 1] } else { None });
                let to = if last { leg.t[1] } else { at(k) };
                out.legs.push(Leg { edge: leg.edge, t: [at(k - 1), to] });
            }
        }
        out
    }
}

impl NarrowRegion {
    /// A place in the middle, and how wide it is there.
    pub(super) fn place(&self) -> (DVec3, f64) {
        let [a, b] = self.across(self.pairs.len() / 2);
        (0.5 * (a + b), a.distance(b))
    }

    /// The points of a pair: one of them and the nearest beside the other.
    pub(super) fn across(&self, pair: usize) -> [DVec3; 2] {
        let [i, j] = self.pairs[pair];
        let (p, other) = (self.sides[0].points[i], &self.sides[1].points);
        let beside = [j.saturating_sub(1), j, (j + 1).min(other.len() - 1)];
        let feet = [segment_foot(p, [other[beside[0]], other[j]]), segment_foot(p, [other[j], other[beside[2]]])];
        let [a, b] = feet;
        [p, if p.distance_squared(a) <= p.distance_squared(b) { a } else { b }]
    }
}

/// The domain of a face, as polygons whose corners are points of edges.
struct Polygons<'a> {
    brep: &'a Brep,
    lines: &'a EdgeLines,
    polygons: Vec<Vec<Corner>>,
    /// Edges the face has on both sides: the domain is cut along them.
    seams: Vec<u32>,
}

/// The first narrow region of a face that is long enough and `goes`. An error says why one cannot be closed.
pub(super) fn find(
    brep: &Brep,
    face: u32,
    lines: &EdgeLines,
    width: f64,
    goes: &dyn Fn(&NarrowRegion) -> bool,
) -> Result<Option<NarrowRegion>, String> {
    let f = &brep.faces[face as usize];
    let of = |e: u32| lines.chains[e as usize].nodes.iter().map(|v| lines.points[*v as usize]);
    let around = Aabb::around(f.loops.iter().flatten().flat_map(|c| of(c.edge)));
    let chart = Chart::new(f.surface.clone(), &around);
    let near = SEVEN_DIGITS * around.diagonal();
    let unroller = Unroller { brep, chains: &lines.chains, points: &lines.points, chart: &chart, near };
    let contours: Vec<Contour> = f.loops.iter().map(|l| unroller.contour(l, f.outward)).collect();
    let first = lines.points.len() as u32;
    let cutter =
        Cutter { chart: &chart, size: around.diagonal(), first, rings: &[], made: Vec::new(), pole_node: &|_| None };
    // What is wrong with the domain is told where the face is meshed.
    let Ok(domain) = cutter.domain(contours) else { return Ok(None) };
    let corners: Vec<DVec2> = domain.polygons.iter().flatten().map(|c| c.uv).collect();
    if corners.len() < 3 || !corners.iter().all(|c| c.is_finite()) {
        return Ok(None);
    }
    let scale = mean_metric(&chart, &corners);
    let flat: Vec<Vec<DVec2>> =
        domain.polygons.iter().map(|p| p.iter().map(|c| (c.uv - corners[0]) * scale).collect()).collect();
    let trimmed = match planar::trim(&flat, width) {
        Ok(t) => t,
        Err(Refusal::Unpaired { .. }) => return Err("where it becomes narrow does not pair up".into()),
        Err(_) => return Ok(None),
    };
    if !trimmed.turned.is_empty() {
        return Ok(None);
    }
    let mut all: Vec<u32> = f.loops.iter().flatten().map(|c| c.edge).collect();
    all.sort_unstable();
    let seams: Vec<u32> = all.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]).collect();
    let polygons = Polygons { brep, lines, polygons: domain.polygons, seams };
    if trimmed.merges.is_empty() {
        let Some(sides) = polygons.whole(&trimmed.vanished, width) else { return Ok(None) };
        return Ok(joined(sides, [false; 2], width)?.filter(goes));
    }
    let mut branches = false;
    for i in 0..trimmed.merges.len() {
        let Some(j) = polygons.exit_after(&trimmed.merges, i) else { continue };
        let side = |k: usize, l: usize| polygons.between(trimmed.merges[k].entry, trimmed.merges[l].exit, width);
        // A region that ends in the face ends there for good.
        let (sides, open) = if j == i {
            (folded(side(i, i).refined(brep, width)), [true, false])
        } else if polygons.exit_after(&trimmed.merges, j) == Some(i) {
            ([side(i, j), side(j, i).reversed()].map(|s| s.refined(brep, width)), [true, true])
        } else {
            branches = true;
            continue;
        };
        if let Some(region) = joined(sides, open, width)?.filter(goes) {
            return Ok(Some(region));
        }
    }
    if branches { Err("a narrow region of it branches".into()) } else { Ok(None) }
}

impl Polygons<'_> {
    /// The merge at whose exit the contour leaves the narrow part it enters at the entry of another.
    fn exit_after(&self, merges: &[planar::Merge], i: usize) -> Option<usize> {
        let c = merges[i].entry.contour;
        let n = self.polygons[c as usize].len() as f64;
        let at = |s: &Spot| f64::from(s.point) + s.share;
        let ahead = |j: &usize| (at(&merges[*j].exit) - at(&merges[i].entry)).rem_euclid(n);
        let own = (0..merges.len()).filter(|j| merges[*j].exit.contour == c);
        own.min_by(|a, b| ahead(a).total_cmp(&ahead(b)))
    }

    fn vertex(&self, node: u32) -> Option<u32> {
        ((node as usize) < self.brep.vertices.len()).then_some(node)
    }

    fn point(&self, node: u32) -> DVec3 {
        self.lines.points.get(node as usize).copied().unwrap_or(DVec3::NAN)
    }

    /// The leg from a corner to the next one.
    fn leg(&self, polygon: &[Corner], i: usize) -> Leg {
        let (a, b) = (&polygon[i], &polygon[(i + 1) % polygon.len()]);
        let edge = a.edge;
        if edge == NONE || self.seams.contains(&edge) {
            return Leg { edge: NONE, t: [0.0; 2] };
        }
        let chain = &self.lines.chains[edge as usize];
        let first = self.lines.first[edge as usize];
        // Chains have points of their own: only one of two neighbors can be a vertex.
        let index = |node: u32, other: u32| {
            if self.vertex(node).is_none() {
                Some((node - first) as usize + 1)
            } else if self.vertex(other).is_none() {
                Some(if other == first { 0 } else { chain.t.len() - 1 })
            } else {
                None
            }
        };
        match (index(a.node, b.node), index(b.node, a.node)) {
            (Some(i), Some(j)) => Leg { edge, t: [chain.t[i], chain.t[j]] },
            _ => Leg { edge: NONE, t: [0.0; 2] },
        }
    }

    /// The part of a contour from one place on it to another, or to vertices just beyond them.
    fn between(&self, from: Spot, to: Spot, width: f64) -> RegionSide {
        let p = &self.polygons[from.contour as usize];
        let n = p.len();
        let start = self.snapped(p, &from, width, false);
        let end = self.snapped(p, &to, width, true);
        let at = |(i, share): (usize, f64)| {
            let leg = self.leg(p, i);
            let here = self.point(p[i].node);
            if share == 0.0 || leg.edge == NONE {
                return (here, self.vertex(p[i].node), leg.t[0]);
            }
            let t = leg.t[0] + share * (leg.t[1] - leg.t[0]);
            (self.brep.edges[leg.edge as usize].curve.at(t), None, t)
        };
        let (first, last) = (at(start), at(end));
        let mut out = RegionSide { points: vec![first.0], vertices: vec![first.1], legs: Vec::new() };
        let mut t = first.2;
        let ahead = (end.0 + n - start.0) % n;
        let count = if ahead == 0 && end.1 <= start.1 { n } else { ahead };
        for k in 0..count {
            let i = (start.0 + k) % n;
            let leg = self.leg(p, i);
            out.legs.push(Leg { edge: leg.edge, t: [if k == 0 { t } else { leg.t[0] }, leg.t[1]] });
            let node = p[(i + 1) % n].node;
            out.points.push(self.point(node));
            out.vertices.push(self.vertex(node));
            t = self.leg(p, (i + 1) % n).t[0];
        }
        if end.1 > 0.0 {
            out.legs.push(Leg { edge: self.leg(p, end.0).edge, t: [t, last.2] });
            out.points.push(last.0);
            out.vertices.push(None);
        }
        out
    }

    /// A place as the corner before it and its share of the way to the next one; the vertex next to it, going out of the
    /// narrow part, where that is nearer than `width`.
    fn snapped(&self, p: &[Corner], spot: &Spot, width: f64, onward: bool) -> (usize, f64) {
        let n = p.len();
        let here = (spot.point as usize, spot.share);
        let length = |i: usize| self.point(p[i].node).distance(self.point(p[(i + 1) % n].node));
        let mut left = width;
        let mut i = here.0;
        let mut part = if onward { 1.0 - here.1 } else { here.1 };
        if !onward && part == 0.0 {
            return here;
        }
        for _ in 0..n {
            if self.leg(p, i).edge == NONE {
                break;
            }
            left -= part * length(i);
            if !(left >= 0.0) {
                break;
            }
            let corner = if onward { (i + 1) % n } else { i };
            if self.vertex(p[corner].node).is_some() {
                return (corner, 0.0);
            }
            (i, part) = (if onward { (i + 1) % n } else { (i + n - 1) % n }, 1.0);
        }
        here
    }

    /// A whole contour from a corner around to it again.
    fn around(&self, contour: usize, from: usize) -> RegionSide {
        let spot = |share| Spot { contour: contour as u32, point: from as u32, share };
        self.between(spot(0.0), spot(0.0), 0.0)
    }

    /// The sides of a domain that is narrow all over.
    fn whole(&self, vanished: &[u32], width: f64) -> Option<[RegionSide; 2]> {
        match *vanished {
            [c] if self.polygons.len() == 1 => {
                let p = &self.polygons[c as usize];
                let n = p.len();
                let real = |i: usize| self.leg(p, i % n).edge != NONE;
                // Runs of edges between cuts or poles.
                let starts: Vec<usize> = (0..n).filter(|&i| real(i) && !real(i + n - 1)).collect();
                let run = |s: usize| {
                    let count = (0..n).take_while(|k| real(s + k)).count();
                    let spot = |i: usize| Spot { contour: c, point: (i % n) as u32, share: 0.0 };
                    self.between(spot(s), spot(s + count), 0.0)
                };
                match starts[..] {
                    [] => {
                        let at = |i: usize| self.point(p[i].node);
                        let farthest = |from: usize| {
                            let far = |i: &usize| at(*i).distance_squared(at(from));
                            (0..n).max_by(|a, b| far(a).total_cmp(&far(b)))
                        };
                        let tip = farthest(0)?;
                        Some(folded(self.around(c as usize, tip).refined(self.brep, width)))
                    }
                    [s] => Some(folded(run(s).refined(self.brep, width))),
                    [s, t] => Some([run(s), run(t).reversed()].map(|side| side.refined(self.brep, width))),
                    _ => None,
                }
            }
            [a, b] if self.polygons.len() == 2 => {
                let from = self.point(self.polygons[a as usize][0].node);
                let far = |c: &Corner| self.point(c.node).distance_squared(from);
                let q = &self.polygons[b as usize];
                let near = (0..q.len()).min_by(|i, j| far(&q[*i]).total_cmp(&far(&q[*j])))?;
                let sides = [self.around(a as usize, 0), self.around(b as usize, near).reversed()];
                Some(sides.map(|s| s.refined(self.brep, width)))
            }
            _ => None,
        }
    }
}

/// The next pair of two sides, or of both ends of one: the nearer of the three ways on.
fn step(a: &[DVec3], [i, j]: [usize; 2], b: &[DVec3], [next_i, next_j]: [usize; 2]) -> [usize; 2] {
    let d = |i: usize, j: usize| a[i].distance_squared(b[j]);
    let (both, first, second) = (d(next_i, next_j), d(next_i, j), d(i, next_j));
    if both <= first && both <= second {
        [next_i, next_j]
    } else if first <= second {
        [next_i, j]
    } else {
        [i, next_j]
    }
}

/// The two sides of a region that ends inside a side, or in a cut of the domain that this side crosses.
fn folded(side: RegionSide) -> [RegionSide; 2] {
    let n = side.points.len();
    if let Some(first) = side.legs.iter().position(|l| l.edge == NONE) {
        let last = side.legs.iter().rposition(|l| l.edge == NONE).unwrap_or(first);
        return [side.part(0, first), side.part(last + 1, n - 1).reversed()];
    }
    let (mut i, mut j) = (0, n - 1);
    while i + 1 < j {
        [i, j] = step(&side.points, [i, j], &side.points, [i + 1, j - 1]);
    }
    let tip = if side.vertices[i].is_none() && side.vertices[j].is_some() { j } else { i };
    [side.part(0, tip), side.part(tip, n - 1).reversed()]
}

/// Pairs what lies across, if the region is long and narrow. It goes on into the rest of the face where it is `open`.
fn joined(sides: [RegionSide; 2], open: [bool; 2], width: f64) -> Result<Option<NarrowRegion>, String> {
    let [a, b] = &sides;
    if a.points.len() < 2 || b.points.len() < 2 || a.length().min(b.length()) < LONG * width {
        return Ok(None);
    }
    if sides.iter().any(|s| s.legs.iter().any(|l| l.edge == NONE) || s.points.iter().any(|p| !p.is_finite())) {
        return Ok(None);
    }
    let last = [a.points.len() - 1, b.points.len() - 1];
    let mut pairs = vec![[0, 0]];
    let mut at = [0, 0];
    while at != last {
        let next = [0, 1].map(|k| (at[k] + 1).min(last[k]));
        let to = step(&a.points, at, &b.points, next);
        at = if to == at { next } else { to };
        pairs.push(at);
    }
    let mut region = NarrowRegion { sides, pairs, joints: Vec::new(), open };
    for k in 0..region.pairs.len() {
        let [p, q] = region.across(k);
        if p.distance(q) > WIDER * width {
            return Ok(None);
        }
    }
    region.joints = joints(&region, width)?;
    Ok(Some(region))
}

/// Both ends, and every vertex with what lies across from it: a vertex nearer than `width` where there is one.
fn joints(region: &NarrowRegion, width: f64) -> Result<Vec<[usize; 2]>, String> {
    let [a, b] = &region.sides;
    let ways = [ways(&a.points), ways(&b.points)];
    let vertices = |k: usize| {
        let list = &region.sides[k].vertices;
        (0..list.len()).filter(move |i| list[*i].is_some())
    };
    let mut out: Vec<[usize; 2]> = Vec::new();
    for k in 0..2 {
        for i in vertices(k) {
            if out.iter().any(|j| j[k] == i) {
                continue;
            }
            let far = |p: &[usize; 2]| a.points[p[0]].distance_squared(b.points[p[1]]);
            let own = region.pairs.iter().filter(|p| p[k] == i);
            let Some(pair) = own.min_by(|p, q| far(p).total_cmp(&far(q))) else { continue };
            let way = |j: usize| (ways[1 - k][j] - ways[1 - k][pair[1 - k]]).abs();
            let near = vertices(1 - k).filter(|j| way(*j) <= width).min_by(|i, j| way(*i).total_cmp(&way(*j)));
            let other = near.unwrap_or(pair[1 - k]);
            out.push(if k == 0 { [i, other] } else { [other, i] });
        }
    }
    for (end, open) in [region.pairs[0], region.pairs[region.pairs.len() - 1]].into_iter().zip(region.open) {
        // Not where a vertex is just as good.
        let beside = |j: &[usize; 2]| (0..2).all(|k| (ways[k][j[k]] - ways[k][end[k]]).abs() <= width);
        if !open || !out.iter().any(beside) {
            out.push(end);
        }
    }
    out.sort_unstable();
    out.dedup();
    if out.windows(2).any(|w| w[1][1] < w[0][1]) {
        return Err("what lies across a narrow region of it comes in another order".into());
    }
    Ok(out)
}
