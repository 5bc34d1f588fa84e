//! Part in, mesh out.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;

use super::boolean::{holds_foreign, mesh_boolean};
use super::built::{build, mesh_built};
use super::cells::{CHEAP, CellLadder, Start, at};
use super::figure::{mesh_figure, no_figure};
use super::groups::{check_groups, finish_names, lost_groups};
use super::heal::{heal_made, same_places, told};
use super::hidden::{creases_seen, hidden_creases};
use super::history::{Attempt, Clock, Tried};
use super::ladder::{Attempts, climb};
use super::leaf::{ByLeaf, by_leaf};
use super::lengths::{Crowded, LengthLadder, tell_far};
use super::method::Method;
use super::options::MeshOptions;
use super::refine::Wishes;
use super::report::Report;
use super::source::MeshOrigin;
use crate::error::{Error, NoBody, Place, Result};
use crate::geometry::{Features, SurfaceOracle};
use crate::implicit::part::Part;
use crate::implicit::{
    CloseOracle, ExtractOptions, Extracted, Implicit, ImplicitOracle, creased, extract, features_within,
    surface_points, thin_places, thin_walls,
};
use crate::io::Outline;
use crate::merge::{Merged, Reordered};
use crate::mesh::TriMesh;
use crate::model::{Cut, from_mesh};
use crate::optimize::{Options, Sequence, improve};
use crate::parametric::brep::Brep;
use crate::quality::{self, Against, Check, Deviation, Expectation, Fault, check_tested, facing_away};
use crate::run::Run;
use crate::sizing::{DEFAULT_SIZE, SizeRequest, Wish};

/// A finished mesh.
#[derive(Debug, Clone)]
pub struct Meshed {
    /// The mesh; only faces that have triangles are listed.
    pub mesh: TriMesh,
    /// Edges (pairs of nodes) at which two leaves make one face. Only the leaf method knows them.
    pub seams: Vec<[u32; 2]>,
    /// Nodes where borders between leaves end or meet, and apexes. Only the leaf method knows them.
    pub corners: Vec<u32>,
    /// The borders of a plane figure, of which the mesh is a triangulation in z = 0.
    pub outline: Option<Outline>,
    /// What is known about it.
    pub report: Report,
    /// What it is a mesh of.
    pub(super) source: MeshOrigin,
}

impl Meshed {
    /// The mesh as a model (vertices, edges, loops, faces with their names, shells) with one fragment of the mesh for each
    /// vertex, edge and face: what every gate hands over, and what [`merge`](crate::merge) joins again.
    ///
    /// By the leaf method a face is where one leaf is active, an edge where two are, a vertex where three are; by the others
    /// faces border on each other where their names change.
    ///
    /// Errors: see [`from_mesh`].
    pub fn model(&self) -> Result<Cut> {
        from_mesh(&self.mesh, &self.seams, &self.corners)
    }

    /// The mesh to be written: read out of the fragments of its [`model`](Self::model) as [`merge`](crate::merge) joins
    /// them, in the numbers `mesh` has.
    ///
    /// Errors: see [`from_mesh`] and [`Merged::new`]; fragments that are not node-matched are refused by name of the edge.
    pub fn merged(&self) -> Result<Reordered> {
        let Cut { model, fragments, nodes, triangles } = self.model()?;
        Reordered::new(Merged::new(model, fragments)?, nodes, &triangles)
    }
}

/// A part made ready for meshing at one size.
pub(super) struct Ready {
    pub(super) model: Arc<Implicit>,
    /// What is asked on the way to a mesh: the model itself, or with stand-ins for what had better be asked in large batches.
    pub(super) asked: Arc<Implicit>,
    pub(super) size: f64,
    /// Places where edges shall be shorter, and how long they may be there.
    pub(super) finer: Vec<(DVec3, f64)>,
}

impl Ready {
    pub(super) fn new(part: &Part, size: Option<SizeRequest>) -> Result<Self> {
        no_figure(part, "this")?;
        let Some(solid) = &part.solid else {
            return Err(Error::input(
                Place::Unknown,
                "the part has no solid of R-functions, only ones built from edges",
            ));
        };
        let model = Implicit::new(solid, part.rsystem, part.domain).map_err(|e| part.located(e))?;
        let model = Arc::new(model);
        let size = size.or(part.mesh.size).unwrap_or(DEFAULT_SIZE).length(model.bounds().diagonal());
        let asked = model.with_proxies(size).map_or_else(|| model.clone(), Arc::new);
        Ok(Ready { model, asked, size, finer: Vec::new() })
    }

    /// The surface by marching cubes with the given cells; an error if there is none.
    pub(super) fn extract(&self, size: f64, options: &MeshOptions, run: &Run) -> Result<Extracted> {
        let extracted = self.extract_any(&self.model, size, options, run)?;
        if extracted.mesh.triangles.is_empty() {
            let points = surface_points(&self.model, &extracted, None, run)?;
            return Err(nothing_found(points.first().map(|x| x.at), size));
        }
        Ok(extracted)
    }

    /// The surface of a model by marching cubes with the given cells, which may be none.
    pub(super) fn extract_any(
        &self,
        model: &Implicit,
        size: f64,
        options: &MeshOptions,
        run: &Run,
    ) -> Result<Extracted> {
        let e = ExtractOptions { size, root_tolerance: options.root_tolerance, memory: options.memory };
        extract(model, &e, run)
    }

    /// Refinements for this part.
    pub(super) fn wishes(&self, options: &MeshOptions) -> Result<Wishes> {
        let names = self.model.faces().iter().map(|f| f.name.as_str());
        Wishes::new(&options.refinements, self.model.bounds().diagonal(), names)
    }

    pub(super) fn operator_options(&self, options: &MeshOptions) -> Options {
        let default = Options::new(self.size);
        if options.angle.is_none() && options.tolerance_length().is_none() {
            return Options { least_size: options.least_length().or(default.least_size), ..default };
        }
        let nodes_per_radius = options.angle.map(|a| 1.0 / a.to_radians());
        Options { nodes_per_radius, chord: options.tolerance_length(), least_size: options.least_length(), ..default }
    }

    /// The true sharp edges and corners, sampled finely enough for a mesh's edges.
    fn features(&self, mesh: &TriMesh, run: &Run) -> Result<Features> {
        self.features_at(mesh.mean_edge_length(), run)
    }

    /// The same for edges of one length: what is within a twentieth of it counts as found.
    fn features_at(&self, edge: f64, run: &Run) -> Result<Features> {
        features_within(&self.asked, 0.5 * self.size, 0.02 * edge, run)
    }

    /// Measures a mesh against the part (`intersecting`: see [`check_tested`]), with features sampled finely enough for its edges; `points` lie on the surface.
    pub(super) fn check(
        &self,
        mesh: &TriMesh,
        intersecting: Option<usize>,
        oracle: &ImplicitOracle<'_>,
        points: &[DVec3],
        run: &Run,
    ) -> Result<Check> {
        let close = CloseOracle::new(oracle, mesh, run)?;
        let features = self.features(mesh, run)?;
        let against = Against { oracle: &close, features: Some(&features), pieces: Some(oracle), points };
        check_tested(mesh, intersecting, Expectation::default(), Some(against), run)
    }
}

/// Measures several meshes of one part alike. What counts as found is a share of the cell size: of each mesh's own mean edge it would be
/// less where edges were divided, and sharp edges would seem lost though none of their nodes has moved.
pub(super) struct Yardstick<'a> {
    oracle: &'a ImplicitOracle<'a>,
    points: &'a [DVec3],
    size: f64,
    truth: Features,
}

impl<'a> Yardstick<'a> {
    /// `points` lie on the surface.
    pub(super) fn new(ready: &Ready, oracle: &'a ImplicitOracle<'a>, points: &'a [DVec3], run: &Run) -> Result<Self> {
        Ok(Self { oracle, points, size: ready.size, truth: ready.features_at(ready.size, run)? })
    }

    pub(super) fn check(&self, mesh: &TriMesh, run: &Run) -> Result<Check> {
        let close = CloseOracle::new(self.oracle, mesh, run)?;
        let against = Against { points: self.points, ..Against::new(&close) };
        let mut check = check_tested(mesh, None, Expectation::default(), Some(against), run)?;
        check.features = Some(quality::recovery(mesh, &self.truth, Some(self.oracle), self.size, run)?);
        Ok(check)
    }
}

/// Meshes of many triangles are not made again where no more than one in so many faces away within the tolerance: thin walls are not what
/// they lack, and another mesh costs as much as this one.
const FEW_AWAY: usize = 1000;

/// Operators that leave less of the length of sharp edges than this in the mesh fall short.
const RECALL: f64 = 0.99;

/// Walls are thin as a whole, and not just where two faces part, if more than this share of the triangles is across from another
/// side of theirs.
const THIN: f64 = 1e-3;

/// Meshes a part.
///
/// Guarantees, for a solid of R-functions: a closed, oriented 2-manifold; nodes on the boundary; the same bytes for any number of
/// threads. What falls short of what was asked (a wall thinner than a cell, a self-intersection) is in the report's `shortfalls`.
/// A mesh away from the surface by more than a fifth of the size is made again from smaller cells; only one farther away than the
/// size falls short.
///
/// What the part builds from edges is meshed as [`mesh_step`](super::mesh_step) does, beside the solid of R-functions; sheets stay
/// open.
///
/// A plane figure becomes a flat mesh in z = 0, with its borders in [`Meshed::outline`].
///
/// Errors: see [`extract`]; a part that is empty or thinner than the cells everywhere; see [`build`].
pub fn mesh_part(part: &Part, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    if part.plane {
        options.for_any_solid()?;
        return mesh_figure(part, options, run);
    }
    let mut options = MeshOptions { least: options.least.or(part.mesh.least), ..options.clone() };
    if options.method == Method::Operators && options.sequence.is_none() {
        options.sequence = part_sequence(part)?;
    }
    let (options, run) = (&options, &run.clone().timed(options.timed));
    check_sequence(part, options)?;
    if let Some(brep) = build(part, run)? {
        return mesh_built(part, brep, options, run);
    }
    options.for_any_solid()?;
    if let Some(solid) = part.solid.as_ref().filter(|s| holds_foreign(s)) {
        return mesh_boolean(part, solid, options, run);
    }
    if options.trim.is_some() {
        return Err(Error::Usage("trimming is for CAD models and solids built from edges: the part has none".into()));
    }
    let ready = Ready::new(part, options.size)?;
    let options = &options.resolved(ready.model.bounds().diagonal());
    check_groups(part, ready.model.faces().iter().map(|f| &f.name[..]))?;
    let mut attempts = Attempts::new(options.timed);
    let mut ladder = LengthLadder::new(part, ready, options);
    let climbed = climb(&mut ladder, &mut attempts, run).map_err(|e| part.located(e))?;
    let Some(mut found) = climbed else { return Err(Error::Cancelled) };
    attempts.tell(&[found.number], &mut found.meshed.report);
    let mut made = found.with_features(ladder.ready(), options, run)?;
    tell_far(&mut made, options);
    let faces = ladder.ready().model.faces();
    made.report.shortfalls.extend(lost_groups(part, faces.iter().map(|f| &f.name[..]), &made.mesh.faces));
    Ok(made)
}

/// The sequence a part file asks for, if it does.
///
/// Errors: a mistake in it, at the place of the text in the file.
pub(super) fn part_sequence(part: &Part) -> Result<Option<Sequence>> {
    let Some((text, place)) = &part.mesh.sequence else { return Ok(None) };
    text.parse().map(Some).map_err(|e: Error| match e {
        Error::Input { place: within, message, help, .. } => {
            let e = Error::input(place.clone(), format!("sequence: {within}{message}"));
            help.into_iter().fold(e, Error::with_help)
        }
        other => other,
    })
}

/// A sequence that nothing would run is a mistake.
fn check_sequence(part: &Part, options: &MeshOptions) -> Result<()> {
    let Some(_) = options.sequence else { return Ok(()) };
    if options.method != Method::Operators {
        let name = options.method.name();
        return Err(Error::Usage(format!("a sequence is run by the method operators, not by {name}")));
    }
    if part.solid.is_none() {
        return Err(Error::Usage(
            "a sequence is for solids of R-functions, the part has only ones built from edges".into(),
        ));
    }
    Ok(())
}

/// Whatever the method, mesh and surface may be no farther from each other than the size, either way: marching cubes cuts off
/// what is sharp within a cell, which is less.
pub(super) fn too_far(check: &Check, limit: f64) -> Option<Fault> {
    let d = check.deviation?;
    let distance = d.max.max(d.from_surface.unwrap_or(0.0));
    (distance > limit).then_some(Fault::Far { distance, limit, triangles: None })
}

/// What operators leave out of the creases they are there for, if that was measured.
fn cut_off(check: &Check) -> Option<Fault> {
    let f = check.features.as_ref()?;
    let (recall, corners, of) = (f.recall, f.corners_found, f.corners_true);
    (recall < RECALL || corners < of).then_some(Fault::CreasesCutOff { recall, corners, of })
}

/// How far a mesh and the surface are from each other somewhere.
pub(super) fn apart(made: &Meshed) -> f64 {
    let deviation = made.report.check.as_ref().and_then(|c| c.deviation);
    deviation.map_or(0.0, |d| d.max.max(d.from_surface.unwrap_or(0.0)))
}

/// A mesh with what tells how another one may be better.
pub(super) struct FoundMesh {
    pub(super) meshed: Meshed,
    /// Whether it fell short where triangles cross or face away, as where curved walls are thinner than chords are high: with the
    /// places of those that face away, and half the length of their edges.
    pub(super) crowded: Crowded,
    /// Where in the ladder of cells it comes from.
    pub(super) start: Start,
    /// Whether smaller cells everywhere left no fewer triangles at fault.
    pub(super) is_exhausted: bool,
    /// The number of its attempt.
    pub(super) number: usize,
    extracted: Extracted,
}

impl FoundMesh {
    /// The mesh with its features measured, if that was asked for: of meshes that are dropped nobody needs to know.
    fn with_features(self, ready: &Ready, options: &MeshOptions, run: &Run) -> Result<Meshed> {
        let Self { mut meshed, extracted, .. } = self;
        if !options.measure {
            return Ok(meshed);
        }
        let Some(mut check) = meshed.report.check.take() else { return Ok(meshed) };
        let mut clock = Clock::new(options.timed);
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let truth = ready.features(&meshed.mesh, run)?;
        // Of the size that was asked for, which edges are made for: their mean says how much of the part is finer.
        check.features = Some(quality::recovery(&meshed.mesh, &truth, Some(&oracle), ready.size, run)?);
        let report = &mut meshed.report;
        if report.sequence.is_some() && !options.method.is_exact() {
            report.shortfalls.extend(cut_off(&check));
        }
        report.check = Some(check);
        report.stage("features", meshed.mesh.triangles.len(), &mut clock, run);
        Ok(meshed)
    }
}

/// A mesh with cells that are some shares of the size, the largest first.
pub(super) fn mesh_by_cells(
    part: &Part,
    cells: CellLadder<'_, '_>,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<FoundMesh> {
    let (ready, options) = (cells.ready, cells.options);
    let before = attempts.len();
    let mut clock = Clock::new(options.timed);
    let sequence = options.sequence.clone().or_else(|| options.method.sequence());
    let made = if options.method.is_exact() {
        match creases_seen(ready, options, attempts, run)? {
            Some(recovered) => recovered,
            None => {
                let made = by_leaf(cells, attempts, run)?;
                hidden_creases(ready, &made, options, attempts, run)?.unwrap_or(made)
            }
        }
    } else {
        let extracted = ready.extract(ready.size, options, run)?;
        let mut mesh = extracted.mesh.clone();
        let mut tried = Tried::MarchingCubes;
        if let Some(sequence) = sequence.clone() {
            let oracle = ImplicitOracle::new(&ready.model, &extracted);
            improve(&mut mesh, &oracle, &Options { sequence, ..ready.operator_options(options) }, run)?;
            tried = Tried::Operators;
        }
        let number = attempts.add(Attempt::new(tried, ready.size, mesh.triangles.len(), 0), run);
        ByLeaf { number, ..ByLeaf::by_other(mesh, extracted, ready.size, options.method, Vec::new()) }
    };
    let ByLeaf {
        mut mesh,
        mut seams,
        mut corners,
        mut intersecting,
        extracted,
        cell,
        method,
        shortfalls,
        number,
        start,
        is_exhausted,
        drawn,
        off,
        ..
    } = made;
    let mut report = Report::new(method, ready.size, part.units.clone());
    // Where the operators stood in for the leaf method it is their usual sequence that ran.
    report.sequence = sequence.or_else(|| method.sequence()).map(|s| s.to_string());
    report.shortfalls = shortfalls;
    report.stage("mesh", mesh.triangles.len(), &mut clock, run);
    if drawn > 0 {
        let what =
            "the solid touches itself along edges: nodes there are drawn back into it by a billionth of its size";
        report.warnings.push(format!("{what}, {drawn} of them"));
    }
    if let Some(farthest) = off.iter().max_by(|a, b| a.distance.total_cmp(&b.distance)) {
        let (count, place) = (off.len(), at(farthest.at));
        let what = "nodes are not on their surfaces, as triangles would cross if they were";
        report.warnings.push(format!("{count} {what}: at most {:.2e} from them, near {place}", farthest.distance));
    }
    ready.wishes(options)?;
    if !options.method.is_exact() && !options.refinements.is_empty() {
        report.warnings.push("refinements are not heeded by this method".into());
    }
    // What the leaf method calls sound is: a closed manifold by construction, tested for intersections.
    if intersecting != Some(0)
        && let Some(healed) = heal_made(&mesh, intersecting, Some(&ImplicitOracle::new(&ready.model, &extracted)), run)?
    {
        report.warnings.extend(told(&healed.report));
        let now = same_places(&mesh, &healed.mesh);
        let now = |v: u32| now[v as usize];
        seams = seams.iter().filter_map(|[a, b]| Some([now(*a)?, now(*b)?])).collect();
        corners = corners.iter().filter_map(|v| now(*v)).collect();
        (mesh, intersecting) = (healed.mesh, Some(0));
    }
    report.stage("heal", mesh.triangles.len(), &mut clock, run);
    // Sheets closer than a cell may have been torn by the extraction. With every edge in its place they were not.
    if !method.is_exact() || !report.shortfalls.is_empty() {
        let walls = thin_walls(&ready.model, &extracted, cell, run)?;
        let thin = thin_places(&ready.model, &walls, cell).into_iter().map(|p| Fault::ThinWall {
            face: p.face,
            at: p.at.to_array(),
            thickness: p.thickness,
            size: p.size,
        });
        report.shortfalls.extend(thin);
    }
    if options.method.is_exact() {
        if method == Method::Cut && report.shortfalls.is_empty() {
            let what =
                "creases inside a closure or formula: the mesh is by the method cut, which finds edges on the surface";
            report.warnings.push(what.into());
        }
        let bent = creased(&mesh, &ImplicitOracle::new(&ready.model, &extracted), run);
        report.warnings.extend(bent.first().map(|p| {
            let what = "a crease inside a formula or a large blend, or a bend tighter than the least size";
            format!("{} triangles cut off {what}: the first near {}", bent.len(), at(*p))
        }));
    }
    finish_names(part, &mut mesh, &mut report);
    run.progress("check", 0.0);
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut points = Cow::Borrowed(&extracted.mesh.nodes);
    if !options.method.is_exact() {
        // What the cells did not see is not in the extraction.
        points.to_mut().extend(surface_points(&ready.model, &extracted, None, run)?.into_iter().map(|x| x.at));
    }
    let points = &points[..];
    // The leaf method does something about distances.
    let is_measured = options.measure || options.method.is_exact();
    let close = if is_measured { Some(CloseOracle::new(&oracle, &mesh, run)?) } else { None };
    let against = close.as_ref().map(|o| Against { points, ..Against::new(o) });
    let measured = check_tested(&mesh, intersecting, Expectation::default(), against, run)?;
    let many = (THIN * mesh.triangles.len() as f64) as usize;
    let thin = measured.deviation.as_ref().is_some_and(|d| d.inverted > 0 || d.across > many);
    let away = method.is_exact() && thin;
    report.shortfalls.extend(too_far(&measured, ready.size));
    let tolerance = Wish::new(ready.size, ready.model.bounds().diagonal(), options.asked()).tolerance;
    let few = measured.deviation.is_some_and(|d| few_away(&d, tolerance, &mesh));
    let tolerance = if method.is_exact() { tolerance } else { 0.0 };
    report.judge(measured, tolerance);
    report.stage("check", mesh.triangles.len(), &mut clock, run);
    let crossed = attempts.any_fault_since(before);
    // What stayed as it came is as fine as the arrangement there.
    let crowded = if few || start.keeps() {
        None
    } else if away {
        let half = |t: u32| {
            let [a, b, c] = mesh.corners(t as usize);
            (mesh.centroid(t as usize), (a.distance(b) + b.distance(c) + c.distance(a)) / 6.0)
        };
        let near = close.as_ref().map_or(&oracle as &dyn SurfaceOracle, |o| o);
        Some(facing_away(&mesh, near, run)?.into_iter().map(half).collect())
    } else {
        (crossed && !report.shortfalls.is_empty()).then(Vec::new)
    };
    let source = MeshOrigin::Functions(ready.model.clone());
    let meshed = Meshed { mesh, seams, corners, outline: None, report, source };
    Ok(FoundMesh { meshed, crowded, start, is_exhausted, number, extracted })
}

/// Whether so few triangles face away, and so near to the surface, that another mesh is not worth its time.
fn few_away(d: &Deviation, tolerance: f64, mesh: &TriMesh) -> bool {
    let triangles = mesh.triangles.len();
    d.inverted_distance <= tolerance && FEW_AWAY * (d.inverted + d.across) <= triangles && triangles > CHEAP
}

/// Why an extraction found no triangle, given a point of the surface if there is one.
pub(super) fn nothing_found(surface: Option<DVec3>, size: f64) -> Error {
    let (place, what) = match surface {
        Some(at) => (Place::Point(at), format!("the part is thinner than the cells of size {size:.6}")),
        None => (Place::Solid(NoBody::Empty), "the solid is empty: nothing is inside anywhere".into()),
    };
    Error::input(place, what).with_help("ask for a smaller --size")
}

/// Measures a mesh file's mesh against a part; cells for the oracle follow the mesh's edges.
pub fn against(mesh: &TriMesh, part: &Part, run: &Run) -> Result<Check> {
    if let Some(brep) = build_alone(part, run)? {
        return super::against_step(mesh, brep.into(), run);
    }
    let ready = ready_for(mesh, part)?;
    let oracle = ImplicitOracle::with_cells(&ready.model, ready.size, run)?;
    let points = ready.extract(ready.size, &MeshOptions::default(), run)?.mesh.nodes;
    ready.check(mesh, None, &oracle, &points, run)
}

/// The distance of each node of a mesh to a part's surface, as [`node_distances`](quality::node_distances) tells it.
pub fn distances_to(mesh: &TriMesh, part: &Part, run: &Run) -> Result<Vec<f64>> {
    if let Some(brep) = build_alone(part, run)? {
        return super::distances_to_step(mesh, brep.into(), run);
    }
    let ready = ready_for(mesh, part)?;
    quality::node_distances(mesh, &ImplicitOracle::with_cells(&ready.model, ready.size, run)?, run)
}

/// What is built from edges, if the part is of that kind. Errors: a part of both kinds, and those of building.
fn build_alone(part: &Part, run: &Run) -> Result<Option<Brep>> {
    let brep = build(part, run)?;
    if brep.is_some() && part.solid.is_some() {
        let what = "a mesh is measured against solids of one kind: the part has some of R-functions and some of edges";
        return Err(Error::input(Place::Unknown, what));
    }
    Ok(brep)
}

/// A part with cells that follow the edges of a mesh.
fn ready_for(mesh: &TriMesh, part: &Part) -> Result<Ready> {
    let h = mesh.mean_edge_length();
    let ready = Ready::new(part, (h > 0.0).then_some(SizeRequest::Length(h)))?;
    // a mesh may be far coarser or finer than is good for cells
    let diagonal = ready.model.bounds().diagonal();
    Ok(Ready { size: ready.size.clamp(diagonal / 1024.0, diagonal / 32.0), ..ready })
}
