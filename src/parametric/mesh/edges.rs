//! Edges as chains of nodes: each is divided once, in space, and all its faces take over the nodes.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::sizes::{EASE, SizeField};
use super::{MeshSizes, Place};
use crate::geometry::{Like, Strips};
use crate::parametric::brep::{Brep, Edge};
use crate::parametric::chart::Chart;

/// Samples per wanted length when a length is measured.
const SAMPLES: f64 = 4.0;
/// Samples between two neighboring parameters of [`pieces`](crate::parametric::Curve::pieces), at most.
const MOST_SAMPLES: usize = 400;
/// The same, at least.
const LEAST_SAMPLES: usize = 4;
/// A corner is sharp where it is at this share of the way looked at: tangents alone do not tell cusps.
const PROBE: f64 = 0.25;
/// Where a corner is this many times as wide as edges wanted there ask for, the next one fits.
const WIDE_ENOUGH: f64 = 1.25;
/// The first triangle at a cusp is to be so wide for its length: 23 degrees,
const OPEN: f64 = 0.4;
/// or this share of what it may be at most.
const REACHED: f64 = 0.9;
/// How often the way to there is halved.
const HALVINGS: usize = 24;
/// The first edge at a sharp corner is at most this share of its curve.
const LEAD: f64 = 0.3;
/// Places looked at between two samples when an edge is divided, at most.
const MOST_STEPS: f64 = 64.0;

/// An edge divided.
#[derive(Debug, Clone, Default)]
pub(super) struct DividedEdge {
    /// Parameters of the nodes, ascending, both ends of the edge included.
    pub(super) t: Vec<f64>,
    /// The nodes; the first and the last are those of the vertices.
    pub(super) nodes: Vec<u32>,
}

/// All edges divided.
pub(super) struct Borders {
    /// The nodes of vertices and edges,
    pub(super) points: Vec<DVec3>,
    /// where they lie,
    pub(super) places: Vec<Place>,
    /// and the lengths wanted there.
    pub(super) wants: Vec<f64>,
    /// Each edge.
    pub(super) chains: Vec<DividedEdge>,
}

/// What the parts of edges keep to besides the lengths wanted, edge by edge.
#[derive(Clone, Copy)]
pub(super) struct Divisions<'a> {
    /// How many times as many parts they get,
    pub(super) factor: &'a [usize],
    /// how many they get at least,
    pub(super) least: &'a [usize],
    /// and how they begin and end.
    pub(super) leads: &'a [[Lead; 2]],
    /// Those that go together.
    pub(super) strips: &'a Strips,
}

/// An edge looked at in many places.
#[derive(Debug, Clone, Default)]
pub(super) struct Sampled {
    /// Parameters, ascending, both ends of the edge included.
    pub(super) t: Vec<f64>,
    pub(super) points: Vec<DVec3>,
    /// Lengths wanted by the curvature of the edge and its faces.
    pub(super) own: Vec<f64>,
    /// The smallest radius of curvature of its faces.
    pub(super) bend: Vec<f64>,
    /// Normals Su x Sv of each of the edge's faces.
    pub(super) normals: Vec<Vec<DVec3>>,
    /// Curvatures of the edge.
    curvature: Vec<f64>,
    /// Curvatures of each of the edge's faces, where there are any.
    curvatures: Vec<Vec<Option<f64>>>,
}

impl Sampled {
    /// An edge nobody looks at.
    pub(super) fn ends_of(edge: &Edge) -> Self {
        let points = edge.range.iter().map(|t| edge.curve.at(*t)).collect();
        Self { t: edge.range.to_vec(), points, own: vec![f64::INFINITY; 2], ..Self::default() }
    }

    /// The way to each of the points.
    pub(super) fn ways(&self) -> Vec<f64> {
        ways(&self.points)
    }

    pub(super) fn length(&self) -> f64 {
        self.points.windows(2).map(|w| w[0].distance(w[1])).sum()
    }
}

/// The way along a line of points to each of them.
pub(super) fn ways(points: &[DVec3]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = points.windows(2).map(|w| w[0].distance(w[1]));
    [0.0]
        .into_iter()
        .chain(steps.map(|d| {
            sum += d;
            sum
        }))
        .collect()
}

/// Looks at an edge and its faces along it; what is known of it already is taken over where it is of the same places, and told.
pub(super) fn sample(
    edge: &Edge,
    charts: &[(u32, &Chart)],
    sizes: &MeshSizes<'_>,
    known: Option<Sampled>,
) -> (Sampled, bool) {
    let t = sampled(edge, sizes);
    let known = known.filter(|k| k.t == t);
    let is_known = known.is_some();
    let mut s = known.unwrap_or_else(|| looked_at(edge, charts, t));
    s.own = s.curvature.iter().map(|c| (sizes.size_at)(*c)).collect();
    s.bend = vec![f64::INFINITY; s.t.len()];
    for ((face, _), row) in charts.iter().zip(&s.curvatures) {
        let wished = (sizes.face_size)(*face).unwrap_or(f64::INFINITY);
        for ((c, h), r) in row.iter().zip(&mut s.own).zip(&mut s.bend) {
            if let Some(c) = c {
                *h = h.min((sizes.size_at)(*c));
                *r = r.min(1.0 / c);
            }
            *h = h.min(wished);
        }
    }
    (s, is_known)
}

/// What does not depend on the sizes wanted.
fn looked_at(edge: &Edge, charts: &[(u32, &Chart)], t: Vec<f64>) -> Sampled {
    let points: Vec<DVec3> = t.iter().map(|t| edge.curve.at(*t)).collect();
    let curvature = t.iter().map(|t| edge.curve.curvature(*t)).collect();
    let (mut normals, mut curvatures) = (Vec::with_capacity(charts.len()), Vec::with_capacity(charts.len()));
    for (_, chart) in charts {
        let mut last: Option<glam::DVec2> = None;
        let mut row = (Vec::with_capacity(points.len()), Vec::with_capacity(points.len()));
        for p in &points {
            let uv = match last {
                Some(uv) => chart.project_near(*p, uv),
                None => chart.project(*p),
            };
            last = Some(uv);
            row.0.push(chart.normal(uv).unwrap_or(DVec3::ZERO));
            row.1.push(chart.curvature(uv));
        }
        normals.push(row.0);
        curvatures.push(row.1);
    }
    Sampled { t, points, normals, curvature, curvatures, ..Sampled::default() }
}

/// Between which of some [ways](Sampled::ways) another lies: the one before, and its share of the way to the next.
pub(super) fn place(ways: &[f64], way: f64) -> (usize, f64) {
    let i = ways.partition_point(|w| *w < way).clamp(1, ways.len() - 1) - 1;
    let step = ways[i + 1] - ways[i];
    (i, if step > 0.0 { ((way - ways[i]) / step).clamp(0.0, 1.0) } else { 0.0 })
}

/// The first edge at a sharp corner: how long it is, and how wide the corner there; zero where the corner is not sharp.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Lead {
    pub(super) way: f64,
    pub(super) width: f64,
}

/// How far from both ends of each edge the faces it borders are too narrow for the edges wanted there: in corners sharper
/// than triangles shall be, down to cusps.
pub(super) fn leads(brep: &Brep, faces_of: &[Vec<u32>], sampled: &[Sampled], sizes: &MeshSizes<'_>) -> Vec<[Lead; 2]> {
    let mut out = vec![[Lead::default(); 2]; brep.edges.len()];
    let ways: Vec<Vec<f64>> = sampled.iter().map(Sampled::ways).collect();
    // The point some way from an end, and how far away from it.
    let at = |(e, end): (u32, usize), way: f64| {
        let (s, ways) = (&sampled[e as usize], &ways[e as usize]);
        let length = ways[ways.len() - 1];
        let goal = if end == 0 { way } else { length - way };
        let (i, share) = place(ways, goal);
        brep.edges[e as usize].curve.at(s.t[i] + share * (s.t[i + 1] - s.t[i]))
    };
    let most = |(e, end): (u32, usize)| {
        // Not by the bends of faces, which at singular points may be any.
        let (edge, ways) = (&brep.edges[e as usize], &ways[e as usize]);
        let own = (sizes.size_at)(edge.curve.curvature(edge.range[end]));
        (LEAD * ways[ways.len() - 1]).min(own).min((sizes.place_size)(brep.vertices[edge.ends[end] as usize]))
    };
    for (f, face) in brep.faces.iter().enumerate() {
        // Ends of edges by vertex: whether the loop comes from there, and how far along it that is looked at.
        let mut ends: Vec<(u32, bool, (u32, usize))> = Vec::new();
        for c in face.loops.iter().flatten() {
            let vertices = brep.edges[c.edge as usize].ends;
            let (from, to) = (usize::from(!c.forward), usize::from(c.forward));
            ends.push((vertices[from], true, (c.edge, from)));
            ends.push((vertices[to], false, (c.edge, to)));
        }
        ends.sort_unstable();
        for group in ends.chunk_by(|a, b| a.0 == b.0) {
            for &(v, _, leaves) in group.iter().filter(|e| e.1) {
                let Some(side) = faces_of[leaves.0 as usize].iter().position(|g| *g == f as u32) else { continue };
                // Not at the tip itself, where there may be none.
                let normals = &sampled[leaves.0 as usize].normals[side];
                let past = PROBE * most(leaves);
                let ways = &ways[leaves.0 as usize];
                let i = if leaves.1 == 0 {
                    ways.partition_point(|w| *w < past)
                } else {
                    ways.partition_point(|w| *w < ways[ways.len() - 1] - past).saturating_sub(1)
                };
                let normal = normals[i.min(normals.len() - 1)] * if face.outward { 1.0 } else { -1.0 };
                let o = brep.vertices[v as usize];
                let corner = |comes: (u32, usize)| {
                    let reach = most(leaves).min(most(comes));
                    let (a, b) = (at(leaves, PROBE * reach) - o, at(comes, PROBE * reach) - o);
                    (a.cross(b).dot(normal).atan2(a.dot(b)), reach, comes)
                };
                let around = group.iter().filter(|e| !e.1 && e.2.0 != leaves.0).map(|e| corner(e.2));
                let Some((angle, reach, comes)) = around.filter(|c| c.0 > 0.0).min_by(|x, y| x.0.total_cmp(&y.0))
                else {
                    continue;
                };
                let goal = WIDE_ENOUGH * sizes.deepest / EASE;
                let width = |way: f64| at(leaves, way).distance(at(comes, way));
                if 2.0 * EASE * (0.5 * angle).sin() >= 1.0 || width(reach) < goal {
                    continue;
                }
                let first = |mut narrow: f64, wide: &dyn Fn(f64) -> bool| {
                    let mut way = reach;
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (narrow + way);
                        if wide(middle) { way = middle } else { narrow = middle }
                    }
                    way
                };
                let mut way = first(0.0, &|way| width(way) >= goal);
                // Cusps open on the way: their first triangle is to be no needle, as far as there is room for that.
                let open = OPEN.min(REACHED * width(reach) / reach);
                if width(way) < open * way {
                    way = first(way, &|way| width(way) >= open * way);
                }
                for (e, end) in [leaves, comes] {
                    let lead = &mut out[e as usize][end];
                    if way > lead.way {
                        *lead = Lead { way, width: width(way) };
                    }
                }
            }
        }
    }
    out
}

/// What the parts of one edge keep to besides the lengths wanted.
#[derive(Clone, Copy)]
pub(super) struct Division {
    /// How many times as many parts it gets as the lengths ask for,
    pub(super) factor: usize,
    /// and how many it gets at least.
    pub(super) least: usize,
    pub(super) leads: [Lead; 2],
    /// How an edge across from it is divided.
    pub(super) like: Like,
}

/// How many parts an edge gets, and where: parameters of its nodes. One edge reaches over each of the [`leads`] at its ends. Edges with neither are as an edge across from them is, and
/// tell how many parts they have.
pub(super) fn divide(edge: &Edge, s: &Sampled, field: &SizeField<'_>, division: Division) -> (Vec<f64>, Option<usize>) {
    let Division { factor, least, leads, like } = division;
    // The field may fall and rise between two samples: as many places in between as edges may lie there.
    let (mut places, mut sum, mut along) = (vec![s.t[0]], vec![0.0], vec![0.0]);
    let mut last = field.at(s.points[0], s.own[0]);
    for i in 0..s.points.len() - 1 {
        let (p, q) = (s.points[i], s.points[i + 1]);
        let own = s.own[i].min(s.own[i + 1]);
        let next = field.at(q, s.own[i + 1]);
        let (least, d) = (last.min(next), p.distance(q));
        // As slowly as the field grows it may not be short enough in the middle to matter.
        let least =
            if least - 0.5 * field.slope() * d >= 2.0 * d { least } else { least.min(field.at(0.5 * (p + q), own)) };
        let steps = (2.0 * d / least).ceil().clamp(1.0, MOST_STEPS) as usize;
        for k in 1..=steps {
            let share = k as f64 / steps as f64;
            let h = if k == steps {
                next
            } else {
                field.at(p.lerp(q, share), s.own[i] + (s.own[i + 1] - s.own[i]) * share)
            };
            places.push(s.t[i] + (s.t[i + 1] - s.t[i]) * share);
            sum.push(sum[sum.len() - 1] + p.distance(q) / steps as f64 / (0.5 * (last + h)));
            along.push(along[along.len() - 1] + p.distance(q) / steps as f64);
            last = h;
        }
    }
    let (total, length) = (sum[sum.len() - 1], along[along.len() - 1]);
    let mut i = 0;
    let mut at = |goal: f64, of: &[f64]| {
        while i > 0 && of[i] > goal {
            i -= 1;
        }
        while i + 2 < of.len() && of[i + 1] < goal {
            i += 1;
        }
        let share = if of[i + 1] > of[i] { ((goal - of[i]) / (of[i + 1] - of[i])).clamp(0.0, 1.0) } else { 0.5 };
        (places[i] + share * (places[i + 1] - places[i]), sum[i] + share * (sum[i + 1] - sum[i]))
    };
    let last = s.points.len() - 1;
    let lead = |end: usize| {
        let k = if end == 0 { 0 } else { last };
        let way = leads[end].way;
        if factor == 1 && way > field.at(s.points[k], s.own[k]) { way } else { 0.0 }
    };
    let leads = [lead(0), lead(1)];
    let (begin, end) = (at(leads[0], &along).1, at(length - leads[1], &along).1);
    let rest = if leads == [0.0; 2] { total } else { end - begin };
    let ends = leads.iter().filter(|l| **l > 0.0).count();
    let plain = factor == 1 && ends == 0;
    let like = if plain { like } else { Like::default() };
    let parts = like.parts(rest.round().clamp(1.0, 1e7) as usize, least.saturating_sub(ends)) * factor;
    let mut t = vec![edge.range[0]];
    if leads[0] > 0.0 {
        t.push(at(leads[0], &along).0);
    }
    let begin = if leads[0] > 0.0 { begin } else { 0.0 };
    t.extend(like.places(parts).into_iter().map(|k| at(begin + rest * k / parts as f64, &sum).0));
    if leads[1] > 0.0 {
        t.push(at(length - leads[1], &along).0);
    }
    t.push(edge.range[1]);
    (t, plain.then_some(parts))
}

fn sampled(edge: &Edge, sizes: &MeshSizes<'_>) -> Vec<f64> {
    let pieces = edge.curve.pieces(edge.range);
    let mut out = vec![pieces[0]];
    for w in pieces.windows(2) {
        let middle = 0.5 * (w[0] + w[1]);
        let [a, m, b] = [w[0], middle, w[1]].map(|t| edge.curve.jet(t));
        let length = a[0].distance(m[0]) + m[0].distance(b[0]);
        let size = (sizes.size_at)(edge.curve.curvature(middle));
        let parts = ((SAMPLES * length / size).ceil().min(MOST_SAMPLES as f64) as usize).max(LEAST_SAMPLES);
        out.extend((1..=parts).map(|k| w[0] + (w[1] - w[0]) * k as f64 / parts as f64));
    }
    out
}

/// The least number of parts that keeps loops from collapsing: three for a closed edge, two for each of several edges
/// between the same vertices, and enough for every loop to have three nodes.
pub(super) fn least_parts(brep: &Brep) -> Vec<usize> {
    let mut least = vec![1; brep.edges.len()];
    let mut between: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (i, e) in brep.edges.iter().enumerate() {
        let [a, b] = e.ends;
        if a == b {
            least[i] = 3;
            continue;
        }
        let key = [a.min(b), a.max(b)];
        if let Some(&first) = between.get(&key) {
            least[first as usize] = 2;
            least[i] = 2;
        } else {
            between.insert(key, i as u32);
        }
    }
    for l in brep.faces.iter().flat_map(|f| &f.loops) {
        if l.len() == 2 && l[0].edge != l[1].edge {
            for c in l {
                least[c.edge as usize] = least[c.edge as usize].max(2);
            }
        }
    }
    least
}

/// Points along an edge, several on each of its smooth pieces; none where the curve knows its feet in closed form.
pub(super) fn samples_of(e: &Edge) -> Vec<(f64, DVec3)> {
    if e.curve.has_closed_foot() {
        return Vec::new();
    }
    let pieces = e.curve.pieces(e.range);
    let inner = pieces
        .windows(2)
        .flat_map(|w| (0..LEAST_SAMPLES).map(|k| w[0] + (w[1] - w[0]) * k as f64 / LEAST_SAMPLES as f64));
    inner.chain([e.range[1]]).map(|t| (t, e.curve.at(t))).collect()
}
