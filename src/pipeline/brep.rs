//! From a STEP file to a mesh: faces between edges, remeshed on their surfaces.

use std::path::Path;

use glam::DVec3;

use super::bodies::{EQUILATERAL, NAMED, remeshed};
use super::brep_oracle;
use super::distance::{Distance, distances, from_edges};
use super::heal::{Action, Healed, heal_made, told as told_of};
use super::history::{Attempt, Clock, Tried, add_attempt};
use super::mesh::{MeshOptions, Meshed};
use super::refine::Wishes;
use super::report::{FaceStep, Report, Rung};
use super::volume::mesh_within_volume;
use super::wish::{CHORD, DEFAULT_SIZE, GRADING, LEAST_SHARE, Wish};
use crate::error::{Error, Result};
use crate::implicit::part::SizeRequest;
use crate::io::step::read_step;
use crate::mesh::{Group, TriMesh, self_intersections};
use crate::optimize::Sizing;
use crate::optimize::exact::ExactOptions;
use crate::parametric::Parametric;
use crate::parametric::brep::Brep;
use crate::parametric::mesh::narrow::{Trimmed, Walls, trim};
use crate::parametric::mesh::{FaceMeshes, Looked, MeshSizes, Remedy};
use crate::parametric::step::{StepModel, interpret};
use crate::quality::{Check, Expectation, Fault, check, check_tested};
use crate::run::Run;
use crate::spatial::Graded;

/// Without a wish for more, bends and narrow places make at most this many times the nodes the size alone asks for.
const MOST_DETAIL: f64 = 3.0;
/// So many nodes are never too many.
const MANY: usize = 80_000;
/// Where there are too many the least length grows by this factor.
const LESS: f64 = 1.6;
/// Narrow places and short edges, which cost less, down to this share.
const NARROW: f64 = 0.25;
/// And to this one where triangles would be needles otherwise.
const NARROWEST: f64 = 0.05;
/// Bends narrower than the least length make edges shorter than it down to this share of it.
const DEEP: f64 = 0.5;
/// What leaves its chord by more than this many times what edges shall is followed further, down to the next share of the least
/// length: it would be too far away, not only rough.
const SAGITTA: f64 = 1.6;
const SAGGING: f64 = 0.125;
/// With more than so many times the triangles the size alone asks for they grow faster, as most triangles are then where lengths
/// grow,
const CROWDED: f64 = 20.0;
/// and at most so fast.
const STEEP: f64 = 0.45;
/// And with more than so many bends may leave their chords by more,
const BUSY: f64 = 60.0;
/// and narrow places may be followed down to this share of [`NARROWEST`].
const DEEPLY: f64 = 0.5;

/// Regions narrower than this share of the size are cut off.
const SLIVER: f64 = 1.0 / 40.0;
/// Where they are the edges of walls and grooves it is this share, and the face must go on at both ends: there is nothing for
/// them but needles, as edges twice their width would be shorter than [`NARROWEST`].
const NEEDLES: f64 = 0.5 * NARROWEST / LEAST_SHARE;

/// Where that does not do it is tried with this share of it.
const STRICTER: f64 = 0.85;
/// With a distance asked for curvature makes edges at most this many times shorter than the size.
const FINEST: f64 = 256.0;
/// How often what is too far from the surface is meshed finer.
const ROUNDS: usize = 4;
/// How often lengths are halved where triangles of one body cross each other, as long as that leaves at most the next share of
/// them: faces of a model that cross go on crossing.
const HALVINGS: usize = 5;
const LEFT: f64 = 0.7;
/// Where more than this share of the triangles cross others of their body the faces of the model do, and the mesh stays as it
/// is: healing would cut it into other faces, in many times the time of the mesh.
const HEALED: f64 = 0.05;
/// At most by this factor each time.
const FINER: f64 = 0.25;

/// Without a least length narrow places are followed down to this share of the size.
const UNHELD: f64 = 1.0 / 400.0;

/// Whether a path is that of a STEP file.
pub fn is_step(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("step") || e.eq_ignore_ascii_case("stp"))
}

/// Reads a STEP file. Errors name the file.
pub fn load_step(path: &Path, run: &Run) -> Result<StepModel> {
    interpret(&read_step(path)?, run).map_err(|e| e.in_file(path))
}

/// Meshes a boundary representation; lengths are in millimeters.
///
/// Guarantees: faces that share an edge share its nodes; the same bytes for any number of threads; every face has
/// triangles or is named in the report's `shortfalls`, or in its `ladder` where all of it was narrower than
/// [`MeshOptions::trim`].
///
/// Errors: [`Error::Usage`] for a sequence of operators; [`Error::Failed`] when no face can be meshed; cancellation.
pub fn mesh_step(model: StepModel, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    options.for_boundary()?;
    match options.volume {
        Some(share) => mesh_within_volume(model, share, options, run),
        None => mesh_tolerant(model, options, run),
    }
}

/// The same, whatever volume is lost.
pub(super) fn mesh_tolerant(model: StepModel, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    let StepModel { brep, notes, .. } = model;
    let solid = Parametric::new(brep, run)?.without(&options.without);
    let diagonal = solid.bounds().diagonal();
    let options = &options.resolved(diagonal);
    let length = |s: SizeRequest| match s {
        SizeRequest::Length(h) => h,
        SizeRequest::Share(s) => s * diagonal,
    };
    let size = length(options.size.unwrap_or(DEFAULT_SIZE));
    let mut report = Report::of("faces", size, Some("mm".into()));
    for n in notes.iter().take(NAMED) {
        report.warnings.push(n.to_string());
    }
    if notes.len() > NAMED {
        report.warnings.push(format!("and {} more such notes", notes.len() - NAMED));
    }
    let lost = notes.iter().filter(|n| n.lost);
    report.shortfalls.extend(lost.map(|n| Fault::NotRead { record: n.id, line: n.line, reason: n.message.clone() }));
    let untrimmed = options.without.contains(&Remedy::Trim);
    if untrimmed && options.trim.is_some() {
        return Err(Error::Usage("a width to trim, and no trimming, cannot both be had".into()));
    }
    let asked = if untrimmed { Some(0.0) } else { options.trim.map(length) };
    let within = 0.5 * Wish::new(size, solid.bounds().diagonal(), options).tolerance;
    let steps = match asked {
        Some(width) => vec![(width, Walls::Cut)],
        None => vec![((SLIVER * size).min(within), Walls::Keep), ((NEEDLES * size).min(within), Walls::Necks)],
    };
    let mut trimmed = Trimmed { brep: solid.brep.clone(), ..Trimmed::default() };
    for (width, walls) in steps {
        let next = trim(trimmed.brep, width, walls, run)?;
        trimmed = Trimmed { cuts: [trimmed.cuts, next.cuts].concat(), ..next };
    }
    if trimmed.cuts.is_empty() {
        refused(&mut report, &trimmed, options);
        return meshed(&solid, report, options, run);
    }
    let mut told = report.clone();
    tell(&mut told, &trimmed);
    refused(&mut told, &trimmed, options);
    let made = meshed(&Parametric::new(trimmed.brep, run)?.without(&options.without), told, options, run)?;
    if made.report.shortfalls.len() <= report.shortfalls.len() {
        return Ok(made);
    }
    // What else can be wrong may be wrong because of what was cut off.
    let mut whole = meshed(&solid, report, options, run)?;
    let mut made = made;
    if whole.report.shortfalls.len() < made.report.shortfalls.len() {
        whole.report.instead_of(&made.report, true, "trimmed, it lacks more than as it is", run);
        return Ok(whole);
    }
    made.report.instead_of(&whole.report, false, "as it is, it lacks no less than trimmed", run);
    Ok(made)
}

/// The first triangles of a boundary representation's faces: closed where it is, with edges shorter where triangles of one body cross
/// each other otherwise. They are what a set operation starts from, and not remeshed.
///
/// Errors: those of [`mesh_step`].
pub(super) fn first_triangles(
    solid: &Parametric,
    size: f64,
    options: &MeshOptions,
    report: &mut Report,
    run: &Run,
) -> Result<FaceMeshes> {
    let wish = Wish::new(size, solid.bounds().diagonal(), options);
    let chord = wish.chord();
    let (wishes, mut looked) = (Wishes::default(), Looked::default());
    let mut crossed: Vec<(DVec3, f64)> = Vec::new();
    let mut held = None;
    for round in 0..=HALVINGS {
        let field = Graded::new(crossed.clone(), wish.grading);
        let by_place = |p: DVec3| field.at(p, f64::INFINITY);
        let mut told = report.clone();
        let how = ([size, chord], held);
        let (made, followed) = first_mesh(solid, how, options, &wishes, &by_place, (&mut told, &mut looked), run)?;
        let hits = crossings(&made.mesh, run)?;
        if hits.is_empty() || round == HALVINGS {
            *report = told;
            return Ok(made);
        }
        held = Some(followed);
        crossed.extend(hits.iter().flatten().map(|t| halved(&made.mesh, *t as usize, options)));
    }
    Err(Error::Failed("no mesh was made".into()))
}

/// Says what was cut off.
fn tell(report: &mut Report, trimmed: &Trimmed) {
    for c in &trimmed.cuts {
        let how = if c.whole { "all of it is" } else { "a region is cut off," };
        let why = format!("{how} {:.3e} wide at ({:.6}, {:.6}, {:.6})", c.width, c.at.x, c.at.y, c.at.z);
        report.ladder.push(FaceStep { face: c.face.clone(), source: c.source, rung: Rung::Trimmed, why });
    }
    let mut names: Vec<&str> = trimmed.cuts.iter().map(|c| c.face.as_str()).collect();
    names.dedup();
    let listed = names.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
    let more = if names.len() > NAMED { ", ..." } else { "" };
    report.warnings.push(format!("narrow regions are cut off of {} faces: {listed}{more}", names.len()));
}

/// Says what could not be cut off, to those who asked for it.
fn refused(report: &mut Report, trimmed: &Trimmed, options: &MeshOptions) {
    if options.trim.is_some() {
        let told = trimmed.refused.iter().take(NAMED).map(|(face, why)| format!("face {face} is not trimmed: {why}"));
        report.warnings.extend(told);
    }
}

/// Meshes a boundary representation as it is.
fn meshed(solid: &Parametric, report: Report, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    let groups = groups(&solid.brep);
    let size = report.size;
    let diagonal = solid.bounds().diagonal();
    let wishes = Wishes::new(&options.refinements, diagonal, solid.brep.faces.iter().map(|f| f.name.as_str()))?;
    let wish = Wish::new(size, solid.bounds().diagonal(), options);
    let limit = wish.tolerance;
    let measured = options.measure || options.tolerance.is_some();
    // Places that came out too far from the surface, and the lengths that will do there.
    let mut finer: Vec<(DVec3, f64)> = Vec::new();
    let mut best: Option<((TriMesh, Option<usize>), Report)> = None;
    let mut looked = Looked::default();
    // Places where the first triangles crossed each other, and finer lengths.
    let mut crossed: Vec<(DVec3, f64)> = Vec::new();
    let (mut attempts, mut clock, mut whole): (Vec<Attempt>, _, _) =
        (Vec::new(), Clock::new(options.timed), Clock::new(options.timed));
    let mut kept = 0;
    for round in 0..if options.tolerance.is_some() { ROUNDS } else { 1 } {
        let grading = wish.grading;
        let chord = CHORD * STRICTER.powi(round as i32) * limit;
        let mut first = |crossed: &[(DVec3, f64)], held: Option<Followed>, told: &mut Report| {
            let field = Graded::new([&finer[..], crossed].concat(), grading);
            let by_place = |p: DVec3| {
                let of_regions = wishes.regions.iter().map(|r| r.at(p, grading));
                field.at(p, of_regions.fold(f64::INFINITY, f64::min))
            };
            first_mesh(solid, ([size, chord], held), options, &wishes, &by_place, (told, &mut looked), run)
        };
        let mut told = report.clone();
        let (mut made, mut followed) = first(&crossed, None, &mut told)?;
        // Walls thinner than the bends of their faces are high, within one body: finer triangles pass each other.
        let mut hits = crossings(&made.mesh, run)?;
        let attempt = |made: &FaceMeshes, hits: usize, clock: &mut Clock| {
            Attempt::new(Tried::Faces, size, made.mesh.triangles.len(), hits, clock)
        };
        add_attempt(&mut attempts, attempt(&made, hits.len(), &mut clock), run);
        let mut first_kept = attempts.len() - 1;
        for _ in 0..HALVINGS {
            if hits.is_empty() {
                break;
            }
            run.check()?;
            let known = crossed.len();
            crossed.extend(hits.iter().flatten().map(|t| halved(&made.mesh, *t as usize, options)));
            let mut again_told = report.clone();
            let again = first(&crossed, Some(followed), &mut again_told)?;
            let left = crossings(&again.0.mesh, run)?;
            let halved = attempt(&again.0, left.len(), &mut clock).because("edges halved where triangles cross");
            add_attempt(&mut attempts, halved, run);
            if left.len() as f64 > LEFT * hits.len() as f64 {
                crossed.truncate(known);
                break;
            }
            ((made, followed), told, hits) = (again, again_told, left);
            first_kept = attempts.len() - 1;
        }
        let exact = ExactOptions { distance: Some(limit), ..ExactOptions::new(followed.sizing, followed.grading) };
        let (mesh, crossing) = remeshed(solid, made, &exact, &mut told, run)?;
        let flawed = crossing.unwrap_or(0);
        attempts[first_kept].kept = true;
        add_attempt(&mut attempts, Attempt::new(Tried::Bodies, size, mesh.triangles.len(), flawed, &mut clock), run);
        let number = attempts.len() - 1;
        if !measured {
            kept = number;
            best = Some(((mesh, crossing), told));
            break;
        }
        run.progress("distance", 0.0);
        let away = distances(solid, &mesh, limit, run)?;
        let beyond: Vec<usize> = (0..away.len()).filter(|t| away[*t] > limit).collect();
        let to_surface = away.iter().copied().fold(0.0, f64::max);
        let (from_surface, asked) = (from_edges(solid, &mesh), options.tolerance);
        told.distance = Some(Distance { to_surface, from_surface, diagonal, asked, beyond: beyond.len() });
        finer.extend(beyond.iter().map(|&t| {
            let [a, b, c] = mesh.corners(t);
            let length = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
            let share = (CHORD * limit / away[t]).sqrt().max(FINER);
            (mesh.centroid(t), (share * length).max(options.least.unwrap_or(0.0)))
        }));
        // A finer mesh that falls short of something else is no better.
        if best.as_ref().is_none_or(|b| told.shortfalls.len() <= b.1.shortfalls.len()) {
            best = Some(((mesh, crossing), told));
            kept = number;
        }
        if beyond.is_empty() {
            break;
        }
    }
    let Some(((mut mesh, crossing), mut report)) = best else { return Err(Error::Failed("no mesh was made".into())) };
    if let Some(d) = report.distance.filter(|d| d.beyond > 0 && d.asked.is_some()) {
        report.shortfalls.push(Fault::Far { distance: d.to_surface, limit, triangles: Some(d.beyond) });
    }
    for (i, a) in attempts.iter_mut().enumerate().filter(|(_, a)| a.rung == Tried::Bodies) {
        a.kept = i == kept;
        if i != kept {
            a.why = "farther from the surface, or lacking more".into();
        }
    }
    report.attempts = attempts;
    report.stage("mesh", mesh.triangles.len(), &mut whole, run);
    mesh.groups = groups;
    run.progress("check", 0.0);
    let expected = expected(&solid.brep, &report.shortfalls);
    let mut found = check_tested(&mesh, crossing, expected, None, run)?;
    if let Some(healed) = heal(solid, &mesh, &found, run)? {
        report.warnings.extend(told_of(&healed.report));
        mesh = healed.mesh;
        found = check(&mesh, expected, None, run)?;
    }
    report.stage("check", mesh.triangles.len(), &mut whole, run);
    warn(&solid.brep, &found, &mut report);
    report.judge(found);
    Ok(Meshed { mesh, seams: Vec::new(), corners: Vec::new(), outline: None, report, solid: None })
}

/// Pairs of triangles of one body that cross each other.
fn crossings(mesh: &TriMesh, run: &Run) -> Result<Vec<[u32; 2]>> {
    let mut all = self_intersections(mesh, run)?;
    if !all.is_empty() {
        let body = mesh.bodies();
        all.retain(|[t, u]| body[*t as usize] == body[*u as usize]);
    }
    Ok(all)
}

/// The middle of a triangle and half the length of its edges.
fn halved(mesh: &TriMesh, t: usize, options: &MeshOptions) -> (DVec3, f64) {
    let [a, b, c] = mesh.corners(t);
    let length = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
    (mesh.centroid(t), (0.5 * length).max(options.least.unwrap_or(0.0)))
}

/// What lengths were followed, and how fast they grow.
#[derive(Clone, Copy)]
struct Followed {
    sizing: Sizing,
    grading: f64,
    /// How far bends narrower than the least length may leave their chords.
    sagitta: f64,
}

impl Followed {
    /// The length wanted where the larger principal curvature has some magnitude; `share` gives shares of the least length.
    fn at(&self, curvature: f64, share: &dyn Fn(f64) -> f64) -> f64 {
        let radius = 1.0 / curvature;
        // No edge is longer than the radius of a bend, down to a share of the least length: else triangles face any way.
        let bent = radius.max(share(DEEP));
        // What is narrower than the sagitta is nowhere that far away.
        let deep = Sizing { nodes_per_radius: None, chord: Some(self.sagitta), least: share(SAGGING), ..self.sizing };
        let near = if self.sagitta < radius { deep.at(curvature) } else { f64::INFINITY };
        self.sizing.at(curvature).min(bent).min(near)
    }
}

/// How many times as many triangles there are as the size alone asks for.
fn detail(made: &FaceMeshes, size: f64) -> f64 {
    let area: f64 = (0..made.mesh.triangles.len()).map(|t| 0.5 * made.mesh.area_vector(t).length()).sum();
    made.mesh.triangles.len() as f64 * EQUILATERAL * size * size / area
}

/// Faces between edges, triangulated for the first time, and the sizes that were followed: those that are `held`, or as fine
/// as keeps the number of triangles within bounds.
fn first_mesh(
    solid: &Parametric,
    ([size, chord], held): ([f64; 2], Option<Followed>),
    options: &MeshOptions,
    wishes: &Wishes,
    by_place: &(dyn Fn(DVec3) -> f64 + Sync),
    (report, looked): (&mut Report, &mut Looked),
    run: &Run,
) -> Result<(FaceMeshes, Followed)> {
    let wish = Wish::new(size, solid.bounds().diagonal(), options);
    let small = if options.tolerance.is_some() { FINEST } else { LEAST_SHARE };
    let mut followed = held.unwrap_or(Followed {
        sizing: Sizing { chord: Some(chord), ..wish.sizing(options.least.unwrap_or(size / small)) },
        grading: wish.grading,
        sagitta: SAGITTA * chord,
    });
    let free = options.least.is_none() && options.angle.is_none() && options.tolerance.is_none();
    // Who asks for a least length gets it.
    let share = |sizing: &Sizing, s: f64| if options.least.is_some() || sizing.least >= size { 1.0 } else { s };
    let of_least = |sizing: &Sizing, s: f64| share(sizing, s) * sizing.least;
    let by_face = |f: u32| wishes.faces.get(f as usize).copied().flatten();
    let mut first = |followed: &Followed, most: usize, narrowest: f64| {
        let Followed { sizing, grading, .. } = followed;
        let by_curvature = |k: f64| followed.at(k, &|s| of_least(sizing, s));
        // A distance asked for is no wish for narrow places.
        let narrow = sizing.least.max(options.least.map_or(size / LEAST_SHARE, |l| l.min(size)));
        // For study narrow places may be followed however deep, up to what memory holds.
        let held = !options.without.contains(&Remedy::LeastLength);
        let (least, deepest) = if held {
            (share(sizing, NARROW) * narrow, share(sizing, narrowest) * narrow)
        } else {
            (UNHELD * size, UNHELD * size)
        };
        let sizes = MeshSizes {
            size,
            least,
            deepest,
            size_at: &by_curvature,
            place_size: by_place,
            face_size: &by_face,
            grading: *grading,
            most,
        };
        solid.mesh_again(&sizes, looked, run)
    };
    let bounded = free && held.is_none();
    let mut made = first(&followed, if bounded { MANY } else { usize::MAX }, NARROWEST)?;
    if bounded && !made.too_many && options.grading.is_none() {
        let times = detail(&made, size);
        if times > CROWDED {
            followed.grading = (GRADING * (times / CROWDED).sqrt()).min(STEEP);
            followed.sagitta *= (times / BUSY).max(1.0).powi(2);
            // There is room then for narrow places, unless they are all there is.
            let most = made.mesh.triangles.len();
            let deep = if times > BUSY { Some(first(&followed, most, DEEPLY * NARROWEST)?) } else { None };
            let small = |m: &FaceMeshes| !m.too_many && m.mesh.triangles.len() <= most;
            made = deep.filter(small).map_or_else(|| first(&followed, usize::MAX, NARROWEST), Ok)?;
        }
    }
    if made.too_many {
        let plain = Followed { sizing: Sizing { least: size, ..followed.sizing }, ..followed };
        let plain = first(&plain, usize::MAX, NARROWEST)?;
        let most = MANY.max((MOST_DETAIL * plain.mesh.nodes.len() as f64) as usize);
        while made.too_many {
            let least = &mut followed.sizing.least;
            *least = (LESS * *least).min(size);
            let most = if *least < size { most } else { usize::MAX };
            made = first(&followed, most, NARROWEST)?;
        }
    }
    let least = followed.sizing.least;
    if free && least > size / LEAST_SHARE {
        let why = "there would be too many triangles";
        report.warnings.push(format!("bends and narrow places are not followed below {least:.6}: {why}"));
    }
    for (face, rung, why) in &made.steps {
        report.ladder.push(FaceStep::of(solid, *face, (*rung).into(), why.clone()));
    }
    for f in &made.failures {
        let face = &solid.brep.faces[f.face as usize];
        let kind = face.surface.kind();
        let (name, source, reason) = (face.name.clone(), face.source, f.reason.clone());
        report.shortfalls.push(Fault::NoMesh { face: name, source, surface: Some(kind), reason });
        report.ladder.push(FaceStep::of(solid, f.face, Rung::None, f.reason.clone()));
    }
    if made.mesh.triangles.is_empty() {
        let why: Vec<String> = report.shortfalls.iter().map(ToString::to_string).collect();
        return Err(Error::Failed(format!("no face could be meshed: {}", why.join("; "))));
    }
    Ok((made, followed))
}

/// Heals a mesh that is not sound. Where the model itself is open, no hole is filled: a sheet is to stay one; but faces that
/// nearly meet are joined, if that closes the mesh. Bodies that overlap stay as they are.
fn heal(solid: &Parametric, mesh: &TriMesh, found: &Check, run: &Run) -> Result<Option<Healed>> {
    if found.certificate.is_sound() && found.closed {
        return Ok(None);
    }
    if found.touching > 0 || found.self_intersections as f64 > HEALED * mesh.triangles.len() as f64 {
        return Ok(None);
    }
    if solid.brep.uses().contains(&1) {
        return heal_made(mesh, None, None, run);
    }
    // Walls around nothing are not what the model's faces bound.
    let bounds = |h: &Healed| h.report.repairs.iter().all(|r| r.action != Action::Thickened);
    Ok(heal_made(mesh, None, Some(&brep_oracle::Trimmed::new(solid, run)?), run)?.filter(bounds))
}

/// How many edges of a model have a face on one side only.
fn open_edges(brep: &Brep) -> usize {
    brep.uses().iter().filter(|n| **n == 1).count()
}

/// What the mesh of a model may be, given what is known to be lacking: a model with open edges, or one without the mesh of a
/// face, has no closed mesh, and whether bodies overlap is the model's affair.
pub(super) fn expected(brep: &Brep, lacking: &[Fault]) -> Expectation {
    Expectation { open: open_edges(brep) > 0 || lacking.iter().any(Fault::leaves_open), touching: true }
}

/// Tells what was expected of the mesh and came true.
fn warn(brep: &Brep, found: &Check, report: &mut Report) {
    let open = open_edges(brep);
    if open > 0 && !found.closed {
        report.warnings.push(format!("{open} edges of the model have a face on one side only: it is open there"));
    }
    if found.touching > 0 {
        let between = found.touching;
        report.warnings.push(format!("bodies overlap or touch: {between} triangles intersect ones of other bodies"));
    }
}

/// One group for every body where there are several, one for every color.
pub(super) fn groups(brep: &Brep) -> Vec<Group> {
    let mut out = Vec::new();
    if brep.bodies.len() > 1 {
        out.extend(brep.bodies.iter().map(|b| Group { name: b.name.clone(), faces: b.faces.clone() }));
    }
    let mut colors: Vec<(String, Vec<u32>)> = Vec::new();
    for (i, f) in brep.faces.iter().enumerate() {
        let Some(c) = f.color else { continue };
        let [r, g, b] = c.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8);
        let name = format!("color #{r:02x}{g:02x}{b:02x}");
        match colors.iter_mut().find(|c| c.0 == name) {
            Some(c) => c.1.push(i as u32),
            None => colors.push((name, vec![i as u32])),
        }
    }
    out.extend(colors.into_iter().map(|(name, faces)| Group { name, faces }));
    out
}
