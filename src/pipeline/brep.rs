//! From a STEP file to a mesh: faces between edges, remeshed on their surfaces.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::bodies::{Bodies, NAMED, remeshed};
use super::brep_oracle;
use super::budget::measurable;
use super::distance::{Distance, distances, from_edges};
use super::first_faces::{FaceLadder, NARROWEST};
use super::heal::{Action, Healed, heal_made, told as told_of};
use super::history::Clock;
use super::ladder::{Attempts, Change, Ladder, LadderState, MeshAttempt, climb};
use super::mesh::Meshed;
use super::options::MeshOptions;
use super::refine::Wishes;
use super::report::{FaceStep, Report, Rung};
use super::source::MeshOrigin;
use super::volume::mesh_within_volume;
use crate::error::{Error, Result};
use crate::io::step::read_step;
use crate::mesh::{Group, TriMesh};
use crate::parametric::Parametric;
use crate::parametric::brep::Brep;
use crate::parametric::mesh::Remedy;
use crate::parametric::mesh::narrow::{TrimmedModel, WallHandling, trim};
use crate::parametric::step::{StepModel, interpret};
use crate::quality::{Check, Expectation, Fault, check, check_tested};
use crate::run::Run;
use crate::sizing::{CHORD, DEFAULT_SIZE, LEAST_SHARE, Wish};

/// Regions narrower than this share of the size are cut off.
const SLIVER: f64 = 1.0 / 40.0;
/// Where they are the edges of walls and grooves it is this share, and the face must go on at both ends: there is nothing for
/// them but needles, as edges twice their width would be shorter than [`NARROWEST`].
const NEEDLES: f64 = 0.5 * NARROWEST / LEAST_SHARE;

/// Where that does not do it is tried with this share of it. Volumes are as distances are: so much of what would just do is asked for.
pub(super) const STRICTER: f64 = 0.85;
/// How often what is too far from the surface is meshed finer.
const ROUNDS: usize = 4;
/// Where more than this share of the triangles cross others of their body the faces of the model do, and the mesh stays as it
/// is: healing would cut it into other faces, in many times the time of the mesh.
const HEALED: f64 = 0.05;
/// At most by this factor each time.
const FINER: f64 = 0.25;

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
/// Errors: [`Error::Usage`] for a sequence of operators, and where more triangles are expected than [`MeshOptions::memory`] holds;
/// [`Error::Input`] for a model too large to be measured; [`Error::Failed`] when no face can be meshed; cancellation.
pub fn mesh_step(model: StepModel, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    options.for_boundary()?;
    let run = &run.clone().with_memory(options.memory).timed(options.timed);
    let mut attempts = Attempts::new(options.timed);
    let made = match options.volume {
        Some(share) => mesh_within_volume(model, share, options, &mut attempts, run)?,
        None => mesh_tolerant(model, options, &mut attempts, run)?,
    };
    Ok(made.told(attempts))
}

/// The same, whatever volume is lost.
pub(super) fn mesh_tolerant(
    model: StepModel,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<MeshAttempt> {
    let StepModel { brep, notes, .. } = model;
    let solid = Arc::new(Parametric::new(brep, run)?.without(&options.without));
    let diagonal = solid.bounds().diagonal();
    measurable(&solid.bounds())?;
    let options = &options.resolved(diagonal);
    let size = options.size.unwrap_or(DEFAULT_SIZE).length(diagonal);
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
    let asked = if untrimmed { Some(0.0) } else { options.trim.map(|s| s.length(diagonal)) };
    let within = 0.5 * Wish::new(size, solid.bounds().diagonal(), options.asked()).tolerance;
    let steps = match asked {
        Some(width) => vec![(width, WallHandling::Cut)],
        None => {
            vec![((SLIVER * size).min(within), WallHandling::Keep), ((NEEDLES * size).min(within), WallHandling::Necks)]
        }
    };
    let mut trimmed = TrimmedModel { brep: solid.brep.clone(), ..TrimmedModel::default() };
    for (width, walls) in steps {
        let next = trim(trimmed.brep, width, walls, run)?;
        trimmed = TrimmedModel { cuts: [trimmed.cuts, next.cuts].concat(), ..next };
    }
    if trimmed.cuts.is_empty() {
        refused(&mut report, &trimmed, options);
        return meshed(&solid, &report, options, attempts, run);
    }
    let mut told = report.clone();
    tell(&mut told, &trimmed);
    refused(&mut told, &trimmed, options);
    let cut = Arc::new(Parametric::new(trimmed.brep, run)?.without(&options.without));
    let made = meshed(&cut, &told, options, attempts, run)?;
    if made.lacks() <= report.shortfalls.len() {
        return Ok(made);
    }
    // What else can be wrong may be wrong because of what was cut off.
    attempts.change(Change::OtherWay, "trimmed, it falls short");
    let whole = meshed(&solid, &report, options, attempts, run)?;
    Ok(if whole.lacks() < made.lacks() { whole } else { made })
}

/// Says what was cut off.
fn tell(report: &mut Report, trimmed: &TrimmedModel) {
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
fn refused(report: &mut Report, trimmed: &TrimmedModel, options: &MeshOptions) {
    if options.trim.is_some() {
        let told = trimmed.refused.iter().take(NAMED).map(|(face, why)| format!("face {face} is not trimmed: {why}"));
        report.warnings.extend(told);
    }
}

/// A mesh of a boundary representation, with what is told of it.
struct MeshedBrep {
    mesh: TriMesh,
    /// How many triangles cross others, where that is known.
    crossing: Option<usize>,
    report: Report,
    /// The attempts it is of.
    numbers: Vec<usize>,
    /// Places that came out too far from the surface, and the lengths that will do there.
    beyond: Vec<(DVec3, f64)>,
}

/// Meshes with shorter edges where they come out too far from the surface.
struct DistanceLadder<'a> {
    solid: &'a Parametric,
    options: &'a MeshOptions,
    faces: FaceLadder<'a>,
    limit: f64,
    finer: Vec<(DVec3, f64)>,
    round: usize,
}

impl Ladder for DistanceLadder<'_> {
    type Made = MeshedBrep;

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<MeshedBrep>> {
        let Self { solid, options, limit, .. } = *self;
        let chord = CHORD * STRICTER.powi(self.round as i32) * limit;
        let first = self.faces.within(chord, &std::mem::take(&mut self.finer), attempts, run)?;
        let Bodies { mesh, crossing, mut report, numbers } = remeshed(solid, first, limit, attempts, run)?;
        let mut beyond = Vec::new();
        if options.measure || options.tolerance_length().is_some() {
            run.progress("distance", 0.0);
            let away = distances(solid, &mesh, limit, run)?;
            beyond.extend((0..away.len()).filter(|t| away[*t] > limit).map(|t| {
                let [a, b, c] = mesh.corners(t);
                let length = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
                let share = (CHORD * limit / away[t]).sqrt().max(FINER);
                (mesh.centroid(t), (share * length).max(options.least_length().unwrap_or(0.0)))
            }));
            let to_surface = away.iter().copied().fold(0.0, f64::max);
            let (from_surface, asked) = (from_edges(solid, &mesh), options.tolerance_length());
            let diagonal = solid.bounds().diagonal();
            report.distance = Some(Distance { to_surface, from_surface, diagonal, asked, beyond: beyond.len() });
        }
        Ok(Some(MeshedBrep { mesh, crossing, report, numbers, beyond }))
    }

    /// A finer mesh that falls short of something else is no better.
    fn is_better(&self, new: &MeshedBrep, best: Option<&MeshedBrep>) -> bool {
        best.is_none_or(|b| new.report.shortfalls.len() <= b.report.shortfalls.len())
    }

    fn next(&mut self, seen: &LadderState<'_, MeshedBrep>) -> Option<(Change, &'static str)> {
        self.round += 1;
        if seen.last.beyond.is_empty() || self.options.tolerance_length().is_none() || self.round == ROUNDS {
            return None;
        }
        self.finer.clone_from(&seen.last.beyond);
        Some((Change::ShorterEdgesHere, "farther from the surface than asked for"))
    }
}

/// Meshes a boundary representation as it is.
fn meshed(
    solid: &Arc<Parametric>,
    report: &Report,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<MeshAttempt> {
    let groups = groups(&solid.brep);
    let diagonal = solid.bounds().diagonal();
    let wishes = Wishes::new(&options.refinements, diagonal, solid.brep.faces.iter().map(|f| f.name.as_str()))?;
    let limit = Wish::new(report.size, diagonal, options.asked()).tolerance;
    let mut whole = Clock::new(options.timed);
    let faces = FaceLadder::new(solid, options, &wishes, report);
    let mut ladder = DistanceLadder { solid, options, faces, limit, finer: Vec::new(), round: 0 };
    let best = climb(&mut ladder, attempts, run)?.ok_or_else(|| Error::Failed("no mesh was made".into()))?;
    let MeshedBrep { mut mesh, crossing, mut report, numbers, .. } = best;
    if let Some(d) = report.distance.filter(|d| d.beyond > 0 && d.asked.is_some()) {
        report.shortfalls.push(Fault::Far { distance: d.to_surface, limit, triangles: Some(d.beyond) });
    }
    report.stage("mesh", mesh.triangles.len(), &mut whole, run);
    mesh.groups = groups;
    run.progress("check", 0.0);
    let expected = expected(&solid.brep, &report.shortfalls);
    let mut found = check_tested(&mesh, crossing, expected, None, run)?;
    let mut source = MeshOrigin::Faces(solid.clone());
    if let Some(healed) = heal(solid, &mesh, &found, run)? {
        report.warnings.extend(told_of(&healed.report));
        mesh = healed.mesh;
        source = MeshOrigin::Unknown("was healed");
        found = check(&mesh, expected, None, run)?;
    }
    report.stage("check", mesh.triangles.len(), &mut whole, run);
    warn(&solid.brep, &found, &mut report);
    report.judge(found, 0.0);
    let meshed = Meshed { mesh, seams: Vec::new(), corners: Vec::new(), outline: None, report, source };
    Ok(MeshAttempt { meshed, numbers })
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
    Ok(heal_made(mesh, None, Some(&brep_oracle::FaceFinder::new(solid, run)?), run)?.filter(bounds))
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
