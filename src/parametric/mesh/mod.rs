//! Meshing a boundary representation: edges first, once and in space, then each face between them in its parameter
//! domain (\[BOR20\]).
//!
//! The result is node-matched, closed where the faces are, and coarse in its shapes: it is where remeshing starts.

mod bends;
mod domain;
mod edges;
mod extent;
mod fill;
mod flips;
mod inner;
mod ladder;
mod looked;
mod loops;
mod metric;
pub mod narrow;
mod remedy;
mod rings;
mod sheets;
mod sizes;
mod vertices;

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::brep::Brep;
use super::chart::Chart;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::SEVEN_DIGITS;
use crate::run::Run;
use crate::spatial::Aabb;
use domain::Cutter;
use edges::{Borders, DividedEdge, Division, Divisions, Sampled, divide, leads, least_parts, samples_of};
use fill::{DomainFilling, Filled, Unfilled, fill};
use inner::inner_bends;
pub use looked::Looked;
use loops::{Contour, Unroller};
pub use remedy::Remedy;
use rings::{Ringed, TipRing};
use sheets::Sheets;
use sizes::{SizeField, Survey};
use vertices::join_vertices;

/// Edges whose contours cross are divided twice as finely, at most this often (\[BOR20\]).
const HALVINGS: usize = 5;
/// Edges around a tube: lengths grow from its seam, so there may be one less.
const ROUND: f64 = 4.0;
/// Tubes are followed down to edges of this share of the size.
pub(crate) const THINNEST: f64 = 1.0 / 400.0;

/// What edge lengths are wanted.
pub struct MeshSizes<'a> {
    /// The greatest.
    pub size: f64,
    /// Narrow places and short edges ask for no less than this while they are not much shorter.
    pub least: f64,
    /// Those that are ask for what keeps triangles from being needles, and for no less than this.
    pub deepest: f64,
    /// By curvature, at most `size`.
    pub size_at: &'a (dyn Fn(f64) -> f64 + Sync),
    /// By place, at most; must grow no faster than `grading`.
    pub place_size: &'a (dyn Fn(DVec3) -> f64 + Sync),
    /// By face, where one is asked for.
    pub face_size: &'a (dyn Fn(u32) -> Option<f64> + Sync),
    /// How fast lengths may grow per length.
    pub grading: f64,
    /// With more nodes on edges, or inside faces, than this meshing ends at once, see [`FaceMeshes::too_many`].
    pub most: usize,
}

/// The sizes, as a field, the edges they gave, and how many nodes faces have got so far.
struct Plan<'a> {
    sizes: &'a MeshSizes<'a>,
    field: &'a SizeField<'a>,
    /// The rings of every face.
    rings: &'a [Vec<TipRing>],
    borders: &'a Borders,
    count: AtomicUsize,
}

impl<'a> MeshSizes<'a> {
    /// The length that puts enough edges around a tube of some radius: with fewer its triangles would cross.
    fn around(&self, radius: f64) -> f64 {
        (std::f64::consts::TAU / ROUND * radius).max((THINNEST * self.size).min(self.least))
    }

    /// Sizes by curvature between `least` and `size`, none by face, growing by 0.3, and any number of nodes.
    pub fn new(size: f64, least: f64, size_at: &'a (dyn Fn(f64) -> f64 + Sync)) -> Self {
        Self {
            size,
            least,
            deepest: least,
            size_at,
            place_size: &|_| f64::INFINITY,
            face_size: &|_| None,
            grading: 0.3,
            most: usize::MAX,
        }
    }
}

/// Where a node lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// On a vertex.
    Vertex(u32),
    /// On an edge, between its ends.
    Edge(u32),
    /// Inside a face.
    Face(u32),
}

/// How a face was triangulated where the plain way did not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FallbackStep {
    /// Edges around it were divided more finely.
    FinerEdges,
    /// On a plane through its border; nodes are on the surface all the same.
    Plane,
}

/// A face without triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// The face.
    pub face: u32,
    /// Why.
    pub reason: String,
}

/// The first mesh of a boundary representation.
#[derive(Debug, Clone, Default)]
pub struct FaceMeshes {
    /// Nodes and triangles; labels are faces.
    pub mesh: TriMesh,
    /// The piece of each triangle: its face, or a sheet of it, see [`Parametric::face_of`].
    pub pieces: Vec<u32>,
    /// Where each node lies.
    pub places: Vec<Place>,
    /// The edge length wanted at each node.
    pub sizes: Vec<f64>,
    /// Faces that did not come out the plain way, and why not.
    pub steps: Vec<(u32, FallbackStep, String)>,
    /// Faces that could not be meshed.
    pub failures: Vec<Failure>,
    /// Whether there would be more nodes than allowed: then faces are missing.
    pub too_many: bool,
    /// Edges that were divided more finely than asked because contours crossed.
    pub halved: usize,
    /// Tips of faces whose triangles are a fan that had better stay.
    pub fans: Vec<(u32, DVec3)>,
}

/// A boundary representation ready to be asked and meshed.
pub struct Parametric {
    /// The model.
    pub brep: Brep,
    pub(super) charts: Vec<Chart>,
    /// Sheets of faces, with the face of each.
    pub(super) sheets: Vec<(u32, Chart)>,
    /// How faces are divided into sheets, and the number of the first one.
    divided: Vec<Option<(Sheets, u32)>>,
    /// Faces of each edge.
    pub(super) faces_of: Vec<Vec<u32>>,
    /// The box around every face's edges.
    pub(super) boxes: Vec<Aabb>,
    /// The box around everything.
    extent: Aabb,
    /// The box around every edge.
    pub(super) edge_boxes: Vec<Aabb>,
    /// Points of every edge and their parameters: where a search for the nearest one starts.
    pub(super) samples: Vec<Vec<(f64, DVec3)>>,
    /// The edges two faces share.
    pub(super) between: FxHashMap<[u32; 2], Vec<u32>>,
    /// What is not done about troubles.
    without: Vec<Remedy>,
}

impl Parametric {
    /// Looks at all surfaces: samples those without closed forms.
    pub fn new(mut brep: Brep, run: &Run) -> Result<Self> {
        join_vertices(&mut brep);
        let mut faces_of = vec![Vec::new(); brep.edges.len()];
        for (i, f) in brep.faces.iter().enumerate() {
            for c in f.loops.iter().flatten() {
                let list: &mut Vec<u32> = &mut faces_of[c.edge as usize];
                if list.last() != Some(&(i as u32)) {
                    list.push(i as u32);
                }
            }
        }
        let edge_boxes: Vec<Aabb> = brep
            .edges
            .iter()
            .map(|e| {
                let around = Aabb::around(e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t)));
                e.ends.iter().fold(around, |b, v| b.union(&Aabb::around([brep.vertices[*v as usize]])))
            })
            .collect();
        let boxes: Vec<Aabb> = brep
            .faces
            .iter()
            .map(|f| {
                let b = f.loops.iter().flatten().fold(Aabb::EMPTY, |b, c| b.union(&edge_boxes[c.edge as usize]));
                if b.is_empty() { extent::whole(&f.surface) } else { b }
            })
            .collect();
        let charts: Vec<Chart> = run.install(|| {
            (0..brep.faces.len())
                .into_par_iter()
                .map(|i| {
                    let edges = brep.faces[i].loops.iter().flatten().map(|c| &brep.edges[c.edge as usize]);
                    let points: Vec<DVec3> =
                        edges.flat_map(|e| e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t))).collect();
                    Chart::new(brep.faces[i].surface.clone(), &boxes[i]).around_points(&points)
                })
                .collect()
        });
        run.check()?;
        let mut sheets = Vec::new();
        let mut divided = Vec::with_capacity(charts.len());
        for (f, chart) in charts.iter().enumerate() {
            divided.push(Sheets::of(chart).map(|s| (s, sheets.len() as u32)));
            if let Some(Some((s, _))) = divided.last() {
                sheets.extend((0..s.count()).map(|k| (f as u32, s.chart(chart, k))));
            }
        }
        let samples = brep.edges.iter().map(samples_of).collect();
        let mut between: FxHashMap<[u32; 2], Vec<u32>> = FxHashMap::default();
        for (e, faces) in faces_of.iter().enumerate() {
            if let [a, b] = faces[..] {
                between.entry([a.min(b), a.max(b)]).or_default().push(e as u32);
            }
        }
        let extent = Aabb::EMPTY;
        let mut this = Self {
            brep,
            charts,
            sheets,
            divided,
            faces_of,
            boxes,
            extent,
            edge_boxes,
            samples,
            between,
            without: Vec::new(),
        };
        this.extent = this.extent(run)?;
        Ok(this)
    }

    /// The box around the model, to about a hundredth of its size where faces bulge beyond their edges.
    pub fn bounds(&self) -> Aabb {
        self.extent
    }

    /// Meshes all faces.
    ///
    /// *Guarantees*: faces that share an edge share its nodes; the same result for any number of threads.
    /// *Does not guarantee*: that all faces come out, see [`FaceMeshes::failures`]; that triangles do not intersect.
    /// *Errors*: cancellation.
    pub fn mesh(&self, sizes: &MeshSizes<'_>, run: &Run) -> Result<FaceMeshes> {
        self.mesh_again(sizes, &mut Looked::default(), run)
    }

    /// The same, faster after the model was meshed with other sizes: `looked` is what was seen of it then, and now.
    pub fn mesh_again(&self, sizes: &MeshSizes<'_>, looked: &mut Looked, run: &Run) -> Result<FaceMeshes> {
        let least = least_parts(&self.brep);
        let same = looked.at_edges(self, sizes, run)?;
        let Looked { sampled, narrow } = looked;
        let of_corners = leads(&self.brep, &self.faces_of, sampled, sizes);
        let survey = Survey { brep: &self.brep, faces_of: &self.faces_of, sampled, leads: &of_corners, same: &same };
        let (mut field, strips) = sizes::field(survey, narrow, sizes, run)?;
        let Ringed { mut rings, mut leads } = self.ringed(sampled, of_corners.clone(), &field, sizes, run);
        let mut looked_inside = false;
        let mut factor = vec![1usize; self.brep.edges.len()];
        let halvings = if self.without.contains(&Remedy::Halving) { 0 } else { HALVINGS };
        let mut round = 0;
        loop {
            run.progress("faces", round as f64 / (HALVINGS + 1) as f64);
            let divisions = Divisions { factor: &factor, least: &least, leads: &leads, strips: &strips };
            let borders = self.borders(sampled, &field, divisions);
            let plan = Plan { sizes, field: &field, rings: &rings, borders: &borders, count: AtomicUsize::new(0) };
            if borders.points.len() - self.brep.vertices.len() > sizes.most {
                return Ok(FaceMeshes { too_many: true, ..FaceMeshes::default() });
            }
            let filled: Vec<Result<Filled, Unfilled>> = run.install(|| {
                (0..self.brep.faces.len())
                    .into_par_iter()
                    .map(|f| {
                        if run.is_cancelled() {
                            return Err(Unfilled::Other("cancelled".into()));
                        }
                        self.face(f as u32, &plan, &FxHashSet::default())
                    })
                    .collect()
            });
            run.check()?;
            if plan.count.load(Ordering::Relaxed) > sizes.most {
                return Ok(FaceMeshes { too_many: true, ..FaceMeshes::default() });
            }
            let mut crossing: Vec<u32> = filled
                .iter()
                .filter_map(|f| if let Err(Unfilled::Crossing(e)) = f { Some(e) } else { None })
                .flatten()
                .copied()
                .collect();
            crossing.sort_unstable();
            crossing.dedup();
            // Straight edges do not come nearer to themselves by more nodes.
            let straight = |e: &u32| matches!(self.brep.edges[*e as usize].curve, super::curve::Curve::Line { .. });
            if !crossing.iter().all(straight) {
                crossing.retain(|e| !straight(e));
            }
            if !crossing.is_empty() && round < halvings {
                crossing.iter().for_each(|e| factor[*e as usize] *= 2);
                round += 1;
                continue;
            }
            // What crosses at any length does so in the model.
            let crossing: Vec<u32> = crossing.into_iter().filter(|e| factor[*e as usize] > 1).collect();
            if !crossing.is_empty() && round == HALVINGS {
                crossing.iter().for_each(|e| factor[*e as usize] = 1);
                round += 1;
                continue;
            }
            if !looked_inside {
                looked_inside = true;
                let bends = run.install(|| inner_bends(self, &filled, &plan));
                if !bends.is_empty() {
                    field = field.with(bends);
                    Ringed { rings, leads } = self.ringed(sampled, of_corners.clone(), &field, sizes, run);
                    (factor, round) = (vec![1; self.brep.edges.len()], 0);
                    continue;
                }
            }
            let mut filled = self.undoubled(filled, &plan, run)?;
            let mut steps = self.finer(&factor);
            if !self.without.contains(&Remedy::Plane) {
                self.on_planes(&mut filled, &plan, &mut steps);
            }
            let fans = rings.iter().enumerate().flat_map(|(f, l)| l.iter().map(move |r| (f as u32, r.pole.point)));
            let fans = fans.collect();
            let halved = factor.iter().filter(|f| **f > 1).count();
            return Ok(FaceMeshes { steps, fans, ..self.joined(borders, filled, halved) });
        }
    }

    /// Two faces may join the same two nodes of their borders across themselves: such edges are split in all faces that have
    /// them.
    fn undoubled(
        &self,
        mut filled: Vec<Result<Filled, Unfilled>>,
        plan: &Plan<'_>,
        run: &Run,
    ) -> Result<Vec<Result<Filled, Unfilled>>> {
        /// A face that is filled anew may double an edge of another one: each round settles those of the last.
        const ROUNDS: usize = 8;
        plan.count.store(0, Ordering::Relaxed);
        let first = plan.borders.points.len() as u32;
        // Pairs of nodes of borders, which several faces may have, and others by face.
        let mut doubled: FxHashMap<u32, FxHashSet<[u32; 2]>> = FxHashMap::default();
        for _ in 0..ROUNDS {
            run.check()?;
            // Directed edges; a sound one comes once in each direction. Nodes of one face have numbers of its own.
            let key = |f: usize, [a, b]: [u32; 2]| {
                let own = if a < first && b < first { u32::MAX } else { f as u32 };
                (own, [a, b])
            };
            let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
            let mut seen: FxHashMap<(u32, [u32; 2]), Vec<u32>> = FxHashMap::default();
            for (f, made) in filled.iter().enumerate() {
                let Ok(made) = made else { continue };
                for e in made.triangles.iter().flat_map(sides) {
                    // Edges between two nodes inside a face are those of a planar triangulation.
                    if e[0] < first + made.cuts && e[1] < first + made.cuts {
                        seen.entry(key(f, e)).or_default().push(f as u32);
                    }
                }
            }
            let mut again: Vec<u32> = Vec::new();
            for (f, made) in filled.iter().enumerate() {
                let Ok(made) = made else { continue };
                for e in made.triangles.iter().flat_map(sides) {
                    if let Some(faces) = seen.get(&key(f, e)).filter(|f| f.len() > 1) {
                        let back = seen.get(&key(f, [e[1], e[0]])).into_iter().flatten();
                        for g in faces.iter().chain(back) {
                            doubled.entry(*g).or_default().insert([e[0].min(e[1]), e[0].max(e[1])]);
                            again.push(*g);
                        }
                    }
                }
            }
            if again.is_empty() {
                break;
            }
            again.sort_unstable();
            again.dedup();
            for f in again {
                let own = doubled.get(&f).cloned().unwrap_or_default();
                filled[f as usize] = self.face(f, plan, &own);
            }
        }
        Ok(filled)
    }

    /// Nodes of vertices and edges, where they lie, and the lengths wanted there.
    fn borders(&self, sampled: &[Sampled], field: &SizeField<'_>, divisions: Divisions<'_>) -> Borders {
        let Divisions { factor, least, leads, strips } = divisions;
        let mut points = self.brep.vertices.clone();
        let mut places: Vec<Place> = (0..points.len() as u32).map(Place::Vertex).collect();
        let mut wants = vec![f64::INFINITY; points.len()];
        let mut chains = Vec::with_capacity(self.brep.edges.len());
        let divided = strips.divided(|e, like| {
            let i = e as usize;
            let division = Division { factor: factor[i], least: least[i], leads: leads[i], like };
            divide(&self.brep.edges[i], &sampled[i], field, division)
        });
        for ((i, e), t) in self.brep.edges.iter().enumerate().zip(divided) {
            let s = &sampled[i];
            let mut nodes = vec![e.ends[0]];
            let mut at = 0;
            for t in &t[1..t.len() - 1] {
                nodes.push(points.len() as u32);
                let p = e.curve.at(*t);
                points.push(p);
                places.push(Place::Edge(i as u32));
                while at + 2 < s.t.len() && s.t[at + 1] < *t {
                    at += 1;
                }
                wants.push(field.at(p, s.own[at].min(s.own[at + 1])));
            }
            nodes.push(e.ends[1]);
            for (v, own) in e.ends.iter().zip([s.own[0], s.own[s.own.len() - 1]]) {
                wants[*v as usize] = wants[*v as usize].min(field.at(points[*v as usize], own));
            }
            chains.push(DividedEdge { t, nodes });
        }
        Borders { points, places, wants, chains }
    }

    fn face(&self, f: u32, plan: &Plan<'_>, doubled: &FxHashSet<[u32; 2]>) -> Result<Filled, Unfilled> {
        self.face_on(f, &self.charts[f as usize], self.divided[f as usize].as_ref(), plan, doubled)
    }

    /// Fills a face in the domain of a chart, which need not be its own.
    fn face_on(
        &self,
        f: u32,
        chart: &Chart,
        sheets: Option<&(Sheets, u32)>,
        plan: &Plan<'_>,
        doubled: &FxHashSet<[u32; 2]>,
    ) -> Result<Filled, Unfilled> {
        let Plan { sizes, field, rings, borders, count } = plan;
        let Borders { points, chains, .. } = borders;
        let face = &self.brep.faces[f as usize];
        // A node this near to a pole is on it.
        let near = SEVEN_DIGITS * self.boxes[f as usize].diagonal();
        let unroller = Unroller { brep: &self.brep, chains, points, chart, near };
        let contours: Vec<Contour> = face.loops.iter().map(|l| unroller.contour(l, face.outward)).collect();
        let own = (sizes.face_size)(f);
        // Also where there is no seam around which the field could be fine.
        let tube = self.is_tube(f, &contours);
        let floor = if chart.poles.is_empty() { 0.0 } else { sizes.least };
        let around = |k: f64| if tube { sizes.around(1.0 / k).max(floor) } else { f64::INFINITY };
        let bent = |k: f64| (sizes.size_at)(k).min(around(k));
        let size_at = |uv: DVec2, p: DVec3| {
            let h = bent(chart.curvature(uv).unwrap_or(0.0));
            field.at(p, own.map_or(h, |s| s.min(h)))
        };
        let vertices: Vec<u32> =
            face.loops.iter().flatten().flat_map(|c| self.brep.edges[c.edge as usize].ends).collect();
        let pole_node = |p: DVec3| vertices.iter().copied().find(|v| points[*v as usize].distance(p) <= near);
        let first = points.len() as u32;
        // Cuts are spaced for the curvature in the middle of the contours.
        let cut = bent(self.middle_curvature(f));
        let cut = own.map_or(cut, |s| s.min(cut));
        let rings = if std::ptr::eq(chart, &self.charts[f as usize]) { &rings[f as usize][..] } else { &[] };
        let cutter = Cutter { chart, size: cut, first, rings, made: Vec::new(), pole_node: &pole_node };
        let domain = cutter.domain(contours).map_err(Unfilled::Other)?;
        let all = |v: u32| if v < first { points[v as usize] } else { domain.nodes[(v - first) as usize] };
        let next = first + domain.nodes.len() as u32;
        let mut filled = fill(&DomainFilling {
            chart,
            domain: &domain,
            sheets: sheets.map(|s| &s.0),
            rings,
            points: &all,
            first: next,
            size_at: &size_at,
            longest: sizes.size,
            doubled,
            count,
            most: sizes.most,
        })?;
        // Sheets are numbered beyond the faces.
        let number = |s: &u32| sheets.map_or(f, |d| self.brep.faces.len() as u32 + d.1 + s);
        let pieces = filled.pieces.iter().map(number).collect();
        if !face.outward {
            filled.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let cuts = domain.nodes.len() as u32;
        let mut nodes = domain.nodes;
        let mut wants: Vec<f64> = nodes.iter().map(|p| size_at(chart.project(*p), *p)).collect();
        nodes.append(&mut filled.nodes);
        wants.append(&mut filled.sizes);
        Ok(Filled { triangles: filled.triangles, pieces, nodes, cuts, sizes: wants })
    }

    /// Whether a face runs all around a cylinder, a cone or a torus.
    fn is_tube(&self, f: u32, contours: &[Contour]) -> bool {
        let loops = &self.brep.faces[f as usize].loops;
        let twice = |e: u32| loops.iter().flatten().filter(|c| c.edge == e).count() > 1;
        let around = || loops.is_empty() || contours.iter().any(|c| c.winding != [0, 0]);
        self.brep.faces[f as usize].surface.is_round() && (around() || loops.iter().flatten().any(|c| twice(c.edge)))
    }

    /// Curvature where the middle of a face is nearest.
    fn middle_curvature(&self, f: u32) -> f64 {
        let chart = &self.charts[f as usize];
        chart.curvature(chart.project(self.boxes[f as usize].center())).unwrap_or(0.0)
    }

    fn joined(&self, borders: Borders, filled: Vec<Result<Filled, Unfilled>>, halved: usize) -> FaceMeshes {
        let Borders { points, places, wants: sizes, .. } = borders;
        let mut out = FaceMeshes { places, sizes, halved, ..FaceMeshes::default() };
        let first = points.len() as u32;
        out.mesh.nodes = points;
        out.mesh.faces = self.brep.faces.iter().map(|f| f.name.clone()).collect();
        for (f, made) in filled.into_iter().enumerate() {
            let face = f as u32;
            match made {
                Ok(made) => {
                    let start = out.mesh.nodes.len() as u32;
                    let number = |v: u32| if v < first { v } else { v - first + start };
                    out.mesh.triangles.extend(made.triangles.iter().map(|t| t.map(number)));
                    out.mesh.labels.resize(out.mesh.triangles.len(), face);
                    out.pieces.extend(made.pieces);
                    out.places.extend(std::iter::repeat_n(Place::Face(face), made.nodes.len()));
                    out.mesh.nodes.extend(made.nodes);
                    out.sizes.extend(made.sizes);
                }
                Err(why) => {
                    let reason = self.told(&why);
                    out.failures.push(Failure { face, reason });
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests;
