//! What edge length is wanted where: by curvature, by short edges and by narrow places, growing from there at a bounded
//! slope through space, so that edges, faces and their neighbors agree on it.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::MeshSizes;
use super::edges::{Lead, Sampled, place};
use crate::error::Result;
use crate::geometry::{ALIKE, ALONG, INTO, Pair, Strips, WIDEST};
use crate::parametric::brep::Brep;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, Graded, ViewCone};

/// Edges across a narrow place are this many times as long as it is wide: one row of triangles, no needles.
const ACROSS: f64 = 1.1;
/// The same where the nodes of both sides lie between each other: angles of 55 degrees.
const STAGGERED: f64 = 1.4;
/// Edges go together where their ends are at most this many times as far from each other as the strip is wide.
const ENDS: f64 = 1.5;
/// Where that is less than the least length they are at most this many times as long: angles of 27 degrees.
pub(super) const EASE: f64 = 2.0;
/// A chord of this many times the root of width and radius leaves its arc by half the width.
const APART: f64 = 2.0;
/// Short edges, and narrow places along them, are followed down to this share of what other narrow places are.
const DEEPER: f64 = 0.125;
/// Pieces of a border nearer to one that was looked at than this share of the length that fits there find nothing else,
const BESIDE: f64 = 0.2;
/// where the normals of both make an angle whose cosine is above this one: 18 degrees.
const ALIGNED: f64 = 0.95;
/// A narrow place is looked at in this many points of a piece of its border, at most.
const MOST_POINTS: f64 = 64.0;
/// Two places of one loop lie across from each other where the way along the loop is this many times their distance;
/// beside a corner of 37 degrees it is.
const AROUND: f64 = 3.0;

/// The field of wanted lengths.
pub(super) struct SizeField<'a> {
    graded: Graded,
    slope: f64,
    place: &'a (dyn Fn(DVec3) -> f64 + Sync),
}

impl<'a> SizeField<'a> {
    /// The lengths wanted by place alone.
    pub(super) fn everywhere(sizes: &MeshSizes<'a>) -> Self {
        Self { graded: Graded::new(Vec::new(), sizes.grading), slope: sizes.grading, place: sizes.place_size }
    }

    /// The field with more places that ask for a length.
    pub(super) fn with(self, sources: Vec<(DVec3, f64)>) -> Self {
        Self { graded: self.graded.with(sources), ..self }
    }

    /// The length wanted at a place, at most `most`.
    pub(super) fn at(&self, p: DVec3, most: f64) -> f64 {
        self.graded.at(p, most).min(self.place_at(p))
    }

    /// How fast lengths grow per length, at most.
    pub(super) fn slope(&self) -> f64 {
        self.slope
    }

    /// The length wanted at a place whatever lies there.
    pub(super) fn place_at(&self, p: DVec3) -> f64 {
        (self.place)(p)
    }
}

/// A straight piece of a loop.
struct Piece {
    edge: u32,
    ends: [DVec3; 2],
    /// Unit vector in the face, away from the border.
    inward: DVec3,
    looped: u32,
    /// Length along the loop up to its start.
    from: f64,
    /// Way along its edge at both ends.
    way: [f64; 2],
    /// Before and after these ways along its edge narrow places do not count.
    bare: [f64; 2],
    /// The radius of its edge's curvature, and the length of the edge.
    bend: f64,
    length: f64,
}

/// A place on the border of a face that has another part of it across from it.
#[derive(Debug)]
struct Narrow {
    at: DVec3,
    width: f64,
    /// The edge it is on, and the one across.
    edges: [u32; 2],
    /// The radius of the edge's curvature.
    bend: f64,
    /// How deep it is followed.
    deepest: f64,
}

/// The edges of a model, as they were looked at.
#[derive(Clone, Copy)]
pub(super) struct Survey<'a> {
    pub(super) brep: &'a Brep,
    /// The faces of every edge,
    pub(super) faces_of: &'a [Vec<u32>],
    /// what was seen along it,
    pub(super) sampled: &'a [Sampled],
    /// how it begins and ends,
    pub(super) leads: &'a [[Lead; 2]],
    /// and whether that is the same as before.
    pub(super) same: &'a [bool],
}

/// The narrow places of every face and pairs of its edges, and what they were looked for with besides the edges.
#[derive(Debug, Default)]
pub(super) struct NarrowPlaces {
    faces: Vec<(Vec<Narrow>, Vec<Pair>)>,
    leads: Vec<[Lead; 2]>,
    /// The size, the least and the deepest.
    lengths: [f64; 3],
}

impl NarrowPlaces {
    /// Looks for them where these are not those of the same edges, leads and sizes.
    fn look(&mut self, survey: Survey<'_>, sizes: &MeshSizes<'_>, run: &Run) -> Result<()> {
        let Survey { brep, leads, same, .. } = survey;
        let known = std::mem::take(self);
        let lengths = [sizes.size, sizes.least, sizes.deepest];
        let comparable = known.leads.len() == leads.len() && known.lengths[..2] == lengths[..2];
        let deepest = known.lengths[2].max(sizes.deepest);
        let may_hold = |f: usize, places: &[Narrow]| {
            let mut edges = brep.faces[f].loops.iter().flatten().map(|c| c.edge as usize);
            // How deep they are followed is nothing to wide ones.
            let wide = |n: &Narrow| EASE * n.width >= deepest;
            edges.all(|e| same[e] && known.leads[e] == leads[e])
                && (known.lengths == lengths || places.iter().all(wide))
        };
        let mut found = known.faces;
        found.resize_with(brep.faces.len(), Default::default);
        let of = |(f, found): (usize, (Vec<Narrow>, Vec<Pair>))| {
            if run.is_cancelled() || (comparable && may_hold(f, &found.0)) {
                return found;
            }
            narrow_places(survey, f as u32, sizes)
        };
        let faces = run.install(|| found.into_par_iter().enumerate().map(of).collect());
        run.check()?;
        *self = Self { faces, leads: leads.to_vec(), lengths };
        Ok(())
    }
}

/// The field of wanted lengths of a whole model, and its edges that go together. The narrow places are those that were found
/// last.
pub(super) fn field<'a>(
    survey: Survey<'_>,
    narrow: &mut NarrowPlaces,
    sizes: &MeshSizes<'a>,
    run: &Run,
) -> Result<(SizeField<'a>, Strips)> {
    let Survey { brep, faces_of, sampled, leads, .. } = survey;
    let mut sources: Vec<(DVec3, f64)> = Vec::new();
    for s in sampled {
        for (p, h) in s.points.iter().zip(&s.own) {
            if *h < sizes.size {
                sources.push((*p, *h));
            }
        }
    }
    // Where sharp corners begin to be wide enough, the next edges are as long as they may be there.
    for (s, lead) in sampled.iter().zip(leads) {
        let ways = s.ways();
        let length = ways[ways.len() - 1];
        for (goal, lead) in [(lead[0].way, lead[0]), (length - lead[1].way, lead[1])] {
            if goal > 0.0 && goal < length {
                let (i, share) = place(&ways, goal);
                let h = fitting(lead.width, ACROSS, f64::INFINITY, sizes.deepest, sizes);
                sources.push((s.points[i].lerp(s.points[i + 1], share), h));
            }
        }
    }
    let uses = brep.uses();
    for (i, (s, e)) in sampled.iter().zip(&brep.edges).enumerate() {
        if uses[i] == 2 && faces_of[i].len() == 1 {
            // A seam: nothing in space, but it runs along a tube, around which there shall be enough edges.
            let surface = &brep.faces[faces_of[i][0] as usize].surface;
            let round = surface.is_round();
            let fit = |r: &f64| {
                if round {
                    sizes.around(*r)
                } else {
                    fitting(std::f64::consts::TAU / 3.0 * r, 1.0, 0.0, sizes.deepest, sizes)
                }
            };
            // Where it runs into a tip a few triangles close that, however near.
            let floor = if surface.poles().is_empty() { 0.0 } else { sizes.least };
            let around = s.bend.iter().map(|r| fit(r).max(floor));
            sources.extend(s.points.iter().copied().zip(around).filter(|x| x.1 < sizes.size));
            continue;
        }
        let length = s.length();
        let h = if e.ends[0] == e.ends[1] { length / 3.0 } else { length };
        if h < sizes.size {
            let h = fitting_edge(h, sizes);
            sources.extend([0, s.points.len() / 2, s.points.len() - 1].map(|i| (s.points[i], h)));
        }
    }
    run.check()?;
    narrow.look(survey, sizes, run)?;
    let pairs: Vec<Pair> = narrow.faces.iter().flat_map(|f| f.1.iter().copied()).collect();
    let strips = Strips::new(brep.edges.len(), pairs);
    let fit = |n: &Narrow| {
        let across = if strips.holds(n.edges) { STAGGERED } else { ACROSS };
        (n.at, fitting(n.width, across, n.bend, n.deepest, sizes))
    };
    sources.extend(narrow.faces.iter().flat_map(|f| &f.0).map(fit).filter(|x| x.1 < sizes.size));
    let graded = Graded::new(sources, sizes.grading);
    Ok((SizeField { graded, slope: sizes.grading, place: sizes.place_size }, strips))
}

/// The edge length that fits a place of some width between borders of some radius of curvature, `across` times as long as it is
/// wide where that is not too short. Places so narrow that there will be needles, as edges shorter than `deepest` would be
/// wanted, get few of them: edges as long as they may be without crossing those of the other side.
fn fitting(width: f64, across: f64, bend: f64, deepest: f64, sizes: &MeshSizes<'_>) -> f64 {
    if EASE * width < deepest {
        (APART * (width * bend).sqrt()).max(sizes.least)
    } else {
        (across * width).max((EASE * width).min(sizes.least))
    }
}

/// The edge length that fits a short edge. It wants few short edges around it, unlike a place that is narrow for long, and so
/// may be much shorter.
fn fitting_edge(length: f64, sizes: &MeshSizes<'_>) -> f64 {
    if EASE * length < DEEPER * sizes.deepest { sizes.least } else { length.max((EASE * length).min(sizes.least)) }
}

/// Places on the border of a face that have another part of it across from them, about as near as the length wanted there, and
/// pairs of its edges that lie across from each other all along.
fn narrow_places(survey: Survey<'_>, number: u32, sizes: &MeshSizes<'_>) -> (Vec<Narrow>, Vec<Pair>) {
    let Survey { brep, faces_of, sampled, leads, .. } = survey;
    let face = &brep.faces[number as usize];
    let uses = |edge: u32| face.loops.iter().flatten().filter(|c| c.edge == edge).count();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut rounds: Vec<f64> = Vec::new();
    for (l, list) in face.loops.iter().enumerate() {
        let mut along = 0.0;
        for c in list {
            let s = &sampled[c.edge as usize];
            let Some(side) = faces_of[c.edge as usize].iter().position(|f| *f == number) else { continue };
            let seam = uses(c.edge) > 1;
            let n = s.points.len() - 1;
            let (ways, lead) = (s.ways(), leads[c.edge as usize]);
            for k in 0..n {
                let (i, j) = if c.forward { (k, k + 1) } else { (n - k, n - k - 1) };
                let (a, b) = (s.points[i], s.points[j]);
                let normal = if face.outward { s.normals[side][i] } else { -s.normals[side][i] };
                let inward = normal.cross(b - a).normalize_or_zero();
                if !seam && inward != DVec3::ZERO {
                    // Sharp corners are left to one triangle.
                    let bare = [lead[0].way, ways[n] - lead[1].way];
                    pieces.push(Piece {
                        edge: c.edge,
                        ends: [a, b],
                        inward,
                        looped: l as u32,
                        from: along,
                        way: [ways[i], ways[j]],
                        bare,
                        bend: 1.0 / brep.edges[c.edge as usize].curve.curvature(0.5 * (s.t[i] + s.t[j])),
                        length: ways[n],
                    });
                }
                along += a.distance(b);
            }
        }
        rounds.push(along);
    }
    if pieces.len() < 3 {
        return (Vec::new(), Vec::new());
    }
    let tree = Bvh::new(pieces.iter().map(|p| Aabb::around(p.ends)).collect());
    let mut out: Vec<Narrow> = Vec::new();
    // How much of an edge has another one across from it, and how far away that is at most.
    let mut seen: FxHashMap<[u32; 2], [f64; 2]> = FxHashMap::default();
    // What is narrow along a short edge only may be followed deeper, as it costs less; where it is narrower still somewhere there
    // will be needles all the same.
    let mut tapers = false;
    // The last piece that was looked at, up to which way from there that will do, and what it found.
    let mut last: Option<(&Piece, f64, Option<[u32; 2]>)> = None;
    for p in &pieces {
        let deepest = (p.length / sizes.size).clamp(DEEPER, 1.0) * sizes.deepest;
        let length = p.ends[0].distance(p.ends[1]);
        let width = |t: f64| {
            let way = p.way[0] + (p.way[1] - p.way[0]) * t;
            if way < p.bare[0] || way > p.bare[1] {
                return None;
            }
            let at = p.ends[0].lerp(p.ends[1], t);
            let across = |i: u32| opposite(p, at, t * length, &pieces[i as usize], &rounds);
            let cone = ViewCone { apex: at, axis: p.inward, cosine: INTO };
            let found = tree.nearest_ahead(cone, WIDEST * sizes.size, across);
            let edges = |i: u32| [p.edge, pieces[i as usize].edge];
            found.map(|(i, d)| Narrow { at, width: d.sqrt(), edges: edges(i), bend: p.bend, deepest })
        };
        if let Some((q, reach, edges)) = last
            && q.edge == p.edge
            && (p.way[0] - q.way[0]).abs() < reach
            && p.inward.dot(q.inward) > ALIGNED
        {
            edges.into_iter().for_each(|e| seen.entry(e).or_default()[0] += length);
            continue;
        }
        let Some(middle) = [0.5, 0.95, 0.05].into_iter().find_map(width) else {
            last = Some((p, BESIDE * sizes.size, None));
            continue;
        };
        let sum = seen.entry(middle.edges).or_default();
        *sum = [sum[0] + length, sum[1].max(middle.width)];
        // The field grows on both sides of a source: there must be one at about every length.
        let fit = [sizes.deepest, deepest].map(|d| fitting(middle.width, ACROSS, p.bend, d, sizes));
        let fit = fit[0].min(fit[1]);
        last = Some((p, BESIDE * fit.min(sizes.size), Some(middle.edges)));
        let points = (length / fit).ceil().min(MOST_POINTS);
        let more = (0..points as usize).map(|k| (k as f64 + 0.5) / points).filter(|_| points > 1.0);
        for place in [middle].into_iter().chain(more.filter_map(width)) {
            tapers |= EASE * place.width < deepest;
            out.push(place);
        }
    }
    if tapers {
        out.iter_mut().for_each(|n| n.deepest = sizes.deepest);
    }
    let mut keys: Vec<[u32; 2]> = out.iter().map(|n| n.edges).filter(|[a, b]| a < b).collect();
    keys.sort_unstable();
    keys.dedup();
    let pair = |[a, b]: [u32; 2]| {
        let lengths = [a, b].map(|e| sampled[e as usize].length());
        let across = [seen.get(&[a, b])?, seen.get(&[b, a])?];
        let all_along = (0..2).all(|i| across[i][0] >= ALONG * lengths[i]);
        let alike = lengths[0] <= ALIKE * lengths[1] && lengths[1] <= ALIKE * lengths[0];
        let reach = ENDS * across[0][1].max(across[1][1]);
        let [[p, q], [r, s]] = [a, b].map(|e| brep.edges[e as usize].ends.map(|v| brep.vertices[v as usize]));
        let near = |x: [DVec3; 2]| x[0].distance(x[1]) <= reach;
        let face_to_face = (near([p, r]) && near([q, s])) || (near([p, s]) && near([q, r]));
        (all_along && alike && face_to_face).then_some(Pair { edges: [a, b], length: lengths[0] })
    };
    (out, keys.into_iter().filter_map(pair).collect())
}

/// The squared distance of a point on one piece of a border to another piece, infinite where that is not across from it.
fn opposite(p: &Piece, at: DVec3, along: f64, q: &Piece, rounds: &[f64]) -> f64 {
    let d = q.ends[1] - q.ends[0];
    let t = ((at - q.ends[0]).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    let way = q.ends[0] + t * d - at;
    let length = way.length();
    if !(way.dot(p.inward) > INTO * length && -way.dot(q.inward) > INTO * length) {
        return f64::INFINITY;
    }
    if q.looped == p.looped {
        let apart = (q.from + t * d.length() - p.from - along).abs();
        let round = rounds[p.looped as usize];
        if apart.min(round - apart) < AROUND * length {
            return f64::INFINITY;
        }
    }
    length * length
}
