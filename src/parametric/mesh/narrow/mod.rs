//! Trimming of narrow regions of faces (\[BOR20\], in its seven steps), in the model itself: both borders of a narrow region
//! become one edge, midway between them, that the faces beyond share. So a shared edge is trimmed on both sides alike, and what
//! comes after knows nothing of the region: no length is asked for its sake.
//!
//! Where a region is narrow is found in the parameter domain, by [`crate::planar::trim`]; that it is so in space, too, is
//! asked before anything is changed.

mod regions;
mod surgery;

use glam::DVec3;
use rayon::prelude::*;

use super::edges::DividedEdge;
use crate::error::Result;
use crate::numeric::COS_60;
use crate::parametric::brep::{Brep, Edge, Face};
use crate::parametric::chart::Chart;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, segment_foot};
use regions::NarrowRegion;

/// Narrow regions are this many times as long as narrow, at least: corners of more than 7 degrees are none.
const LONG: f64 = 8.0;
/// Chords of edges leave their arcs by this share of the width at most.
const CHORD: f64 = 1.0 / 16.0;
/// Parts of an edge that are looked at: as few and as many as this.
const PARTS: [usize; 2] = [3, 20_000];
/// Two places of one loop lie across from each other where the way along the loop is this many times the way over.
const AROUND: f64 = 4.0;
/// Regions of one face that are cut off, at most.
const MOST: usize = 64;

/// A narrow region that was cut off.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionCut {
    /// The face's name and what made it.
    pub face: String,
    /// See [`Edge::source`].
    pub source: u64,
    /// A place in the region.
    pub at: DVec3,
    /// How wide it was there.
    pub width: f64,
    /// Whether nothing is left of the face.
    pub whole: bool,
}

/// A model without narrow regions.
#[derive(Debug, Clone, Default)]
pub struct TrimmedModel {
    /// The model.
    pub brep: Brep,
    /// What was cut off.
    pub cuts: Vec<RegionCut>,
    /// Faces with narrow regions that stay, and why.
    pub refused: Vec<(String, String)>,
}

/// What happens to regions between the two sides of a wall or a groove: with them the solid is cut off, or the groove filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WallHandling {
    /// They stay.
    Keep,
    /// They go where the face goes on at both ends: no rims, and no cusps, which end in one triangle anyway.
    Necks,
    /// They go.
    Cut,
}

/// Cuts off regions of faces that are narrower than `width` and long for that.
///
/// *Guarantees*: borders move by at most about half the width; edges have as many faces as before; the same result for any
/// number of threads. *Does not guarantee*: that all narrow regions go, see [`TrimmedModel::refused`].
///
/// *Errors*: cancellation.
pub fn trim(brep: Brep, width: f64, walls: WallHandling, run: &Run) -> Result<TrimmedModel> {
    let mut out = TrimmedModel { brep, ..TrimmedModel::default() };
    if !(width > 0.0 && width.is_finite()) {
        return Ok(out);
    }
    let mut lines = EdgeLines::new(&out.brep, width);
    let bordered: Vec<bool> = out.brep.faces.iter().map(|f| !f.loops.is_empty()).collect();
    let narrow: Vec<bool> = run.install(|| {
        (0..out.brep.faces.len()).into_par_iter().map(|f| lines.may_be_narrow(&out.brep, f as u32, width)).collect()
    });
    for f in (0..narrow.len() as u32).filter(|f| narrow[*f as usize]) {
        for _ in 0..MOST {
            run.check()?;
            let face = &out.brep.faces[f as usize];
            // What another face's region took with it.
            if face.loops.is_empty() {
                break;
            }
            let (name, source) = (face.name.clone(), face.source);
            let goes = |region: &NarrowRegion| match walls {
                WallHandling::Keep => !is_wall(&out.brep, f, region),
                WallHandling::Necks => region.open == [true; 2] || !is_wall(&out.brep, f, region),
                WallHandling::Cut => true,
            };
            let done = regions::find(&out.brep, f, &lines, width, &goes)
                .and_then(|region| region.map(|s| surgery::close(&out.brep, f, &s, width).map(|b| (s, b))).transpose());
            match done {
                Ok(None) => break,
                Ok(Some((region, brep))) => {
                    let (at, wide) = region.place();
                    let whole = brep.faces[f as usize].loops.is_empty();
                    out.cuts.push(RegionCut { face: name, source, at, width: wide, whole });
                    out.brep = brep;
                    lines = EdgeLines::new(&out.brep, width);
                }
                Err(why) => {
                    out.refused.push((name, why));
                    break;
                }
            }
        }
    }
    if !out.cuts.is_empty() {
        let gone: Vec<bool> = out.brep.faces.iter().zip(&bordered).map(|(f, b)| *b && f.loops.is_empty()).collect();
        surgery::sweep(&mut out.brep, &gone);
    }
    Ok(out)
}

/// Whether the faces beyond both sides of a region face away from each other, or towards each other.
fn is_wall(brep: &Brep, face: u32, region: &NarrowRegion) -> bool {
    let normal = |side: usize, pair: [usize; 2]| {
        let (side, i) = (&region.sides[side], pair[side]);
        let edge = side.legs[i.min(side.legs.len() - 1)].edge;
        let has = |f: &Face| f.loops.iter().flatten().any(|c| c.edge == edge);
        let beyond = brep.faces.iter().enumerate().find(|(n, f)| *n as u32 != face && has(f))?.1;
        let around = Aabb::around(side.points.iter().copied());
        let n = Chart::new(beyond.surface.clone(), &around).normal_near(side.points[i])?;
        Some(if beyond.outward { n } else { -n })
    };
    let at = |share: usize| region.pairs[(region.pairs.len() - 1) * share / 4];
    [1, 2, 3].into_iter().any(|k| {
        let both = [normal(0, at(k)), normal(1, at(k))];
        matches!(both, [Some(a), Some(b)] if a.dot(b) < -COS_60)
    })
}

/// Edges as lines of points: those of the vertices first, then those of every edge.
struct EdgeLines {
    chains: Vec<DividedEdge>,
    points: Vec<DVec3>,
    /// The number of the first point of every edge that is not a vertex.
    first: Vec<u32>,
}

impl EdgeLines {
    fn new(brep: &Brep, width: f64) -> Self {
        let mut out = Self { chains: Vec::new(), points: brep.vertices.clone(), first: Vec::new() };
        for e in &brep.edges {
            let t = parameters(e, width);
            let first = out.points.len() as u32;
            out.points.extend(t[1..t.len() - 1].iter().map(|t| e.curve.at(*t)));
            let inner = first..out.points.len() as u32;
            let nodes = [e.ends[0]].into_iter().chain(inner).chain([e.ends[1]]).collect();
            out.first.push(first);
            out.chains.push(DividedEdge { t, nodes });
        }
        out
    }

    /// Whether parts of the border of a face that do not follow each other come so near to each other.
    fn may_be_narrow(&self, brep: &Brep, face: u32, width: f64) -> bool {
        // Ends of each piece, the loop it is of, and the way along that up to it.
        let mut pieces: Vec<([DVec3; 2], usize, f64)> = Vec::new();
        let mut rounds = Vec::new();
        for (l, list) in brep.faces[face as usize].loops.iter().enumerate() {
            let mut along = 0.0;
            for c in list {
                let nodes = &self.chains[c.edge as usize].nodes;
                let n = nodes.len() - 1;
                for k in 0..n {
                    let (i, j) = if c.forward { (k, k + 1) } else { (n - k, n - k - 1) };
                    let ends = [i, j].map(|i| self.points[nodes[i] as usize]);
                    pieces.push((ends, l, along));
                    along += ends[0].distance(ends[1]);
                }
            }
            rounds.push(along);
        }
        let tree = Bvh::new(pieces.iter().map(|p| Aabb::around(p.0)).collect());
        pieces.iter().any(|(ends, l, along)| {
            [(ends[0], *along), (ends[1], along + ends[0].distance(ends[1]))].into_iter().any(|(p, way)| {
                let mut found = false;
                tree.overlapping(&Aabb::around([p]).grown(width), |j| {
                    let (other, m, from) = &pieces[j as usize];
                    let foot = segment_foot(p, *other);
                    let across = p.distance(foot);
                    let along = (from + other[0].distance(foot) - way).abs();
                    found |= across < width && (l != m || along.min(rounds[*l] - along) > AROUND * across.max(width));
                });
                found
            })
        })
    }
}

/// Parameters of points of an edge, so near to each other that chords leave arcs by a small share of the width.
fn parameters(e: &Edge, width: f64) -> Vec<f64> {
    let pieces = e.curve.pieces(e.range);
    let mut out = vec![pieces[0]];
    for w in pieces.windows(2) {
        let middle = 0.5 * (w[0] + w[1]);
        let [a, m, b] = [w[0], middle, w[1]].map(|t| e.curve.at(t));
        let length = a.distance(m) + m.distance(b);
        let bend = [w[0], middle, w[1]].map(|t| e.curve.curvature(t)).into_iter().fold(0.0, f64::max);
        // No arc leaves a chord by more than its own length.
        let step = (8.0 * CHORD * width / bend.max(f64::MIN_POSITIVE)).sqrt().max(CHORD * width);
        let parts = ((length / step).ceil().max(1.0) as usize).min(PARTS[1]);
        let parts = if pieces.len() < PARTS[0] + 1 { parts.max(PARTS[0]) } else { parts };
        out.extend((1..=parts).map(|k| w[0] + (w[1] - w[0]) * k as f64 / parts as f64));
    }
    // A region that was closed up to an end is not to be found narrow there again: its sides part beyond the end.
    let last = out.len() - 1;
    let near = |i: usize, j: usize| {
        let (p, q) = (e.curve.at(out[i]), e.curve.at(out[j]));
        let share = width / p.distance(q);
        (share < 0.5).then(|| out[i] + share * (out[j] - out[i]))
    };
    let (after, before) = (near(0, 1), near(last, last - 1));
    out.splice(last..last, before);
    out.splice(1..1, after);
    out
}
