//! Set operations on meshes, STEP models, bodies built from edges, and solids of R-functions.
//!
//! Every operand comes as closed triangles that know their pieces. The triangles are cut and joined exactly
//! ([`heal::boolean`](crate::heal::boolean)), which settles the topology by signs alone. Nodes where two operands meet then go to the
//! curve of both true surfaces, and the remesher of all gates works on the whole, with the pieces of all operands.

mod joint;
mod operand;
mod remeshing;
mod signed;
mod tree;
mod work;

use super::budget::measurable;
use super::groups::{check_groups, finish_names, lost_groups};
use super::history::Clock;
use super::ladder::{Attempts, climb};
use super::leaf::NARROWEST;
use super::mesh::Meshed;
use super::method::Method;
use super::options::MeshOptions;
use super::refine::Wishes;
use super::report::Report;
use super::source::MeshOrigin;
use super::touching::draw_apart;
use crate::error::{Error, NoBody, Place, Result};
use crate::heal::{MOST_BODIES, boolean};
use crate::implicit::Solid;
use crate::implicit::part::Part;
use crate::mesh::{Group, TriMesh};
use crate::quality::{Expectation, Fault, check};
use crate::remesh::{RemeshOptions, RemeshedMesh};
use crate::run::Run;
use crate::sizing::{DEFAULT_SIZE, LEAST_SHARE, Sizing, Wish};
use crate::spatial::Aabb;
use joint::OperandPieces;
use operand::{
    KnownPieces, OperandGoal, PreparedOperand, at, extent, load, make_foreign, make_functions, named_groups, with_size,
};
use remeshing::Remeshing;
use signed::BoundaryDistance;
use tree::Operand;
pub(super) use tree::{files_of, holds_foreign, is_foreign_alone};
use work::{Numbers, PreparedWork, align, coinciding, misfit, prepare};

/// An endless solid of R-functions is kept in a box that is larger than where it matters by this share of the diagonal on every side. Each
/// percent more is several percent more triangles that are made for nothing.
const BEYOND: f64 = 0.011;
/// By this much more for every operand, so that no two boxes coincide.
const MORE: f64 = 0.0007;
/// What has an end is kept in a box, too, if that is at most this share of the box around it: less is gained by a larger one than its
/// walls may cost.
const WORTH: f64 = 0.8;
/// A node of the cut is at most this many sizes from its place on the true surfaces.
const REACH: f64 = 2.0;

/// The solid of a part as R-functions: a solid given by its boundary becomes the distance to that, one leaf with the faces of the boundary.
///
/// Errors: operands that cannot be read or are not closed, and those in a blend, at their place in the part file; cancellation.
pub(super) fn as_functions(part: &Part, solid: &Solid, run: &Run) -> Result<Solid> {
    let (tree, operands) = tree::read(solid)?;
    let leaf = |o: Operand| -> Result<Solid> {
        let placed = match o {
            Operand::Functions(s) => return Ok(s),
            Operand::Foreign(placed) => placed,
        };
        let signed = BoundaryDistance::new(load(&placed, &part.folder, run)?, run).map_err(|e| at(&placed, e))?;
        let s = Solid::field(signed);
        Ok(placed.size.iter().fold(s, |s, h| s.size(*h)))
    };
    let leaves = operands.into_iter().map(leaf).collect::<Result<Vec<_>>>()?;
    Ok(tree.of(&leaves))
}

/// Meshes a part that joins solids given by boundaries.
///
/// Guarantees: closed and oriented; nodes where two operands meet lie on both true surfaces to rounding, but for places that the report
/// names; faces keep their names; the same bytes for any number of threads.
///
/// Errors: operands that cannot be read or are not closed, at their place in the part file; options that only R-functions know;
/// operands whose triangles cannot be joined; cancellation.
pub(super) fn mesh_boolean(part: &Part, solid: &Solid, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    refuse(options)?;
    let run = &run.clone().with_memory(options.memory).timed(options.timed);
    let solid = match part.domain {
        Some(d) => Solid::cuboid(d.lo, d.hi).name("domain") & solid.clone(),
        None => solid.clone(),
    };
    let (tree, operands) = tree::read(&solid)?;
    if operands.len() > MOST_BODIES {
        let what = format!("{} operands are joined with boundaries, and {MOST_BODIES} is the most", operands.len());
        return Err(Error::input(Place::Unknown, what));
    }
    run.progress("read", 0.0);
    let mut loaded = Vec::with_capacity(operands.len());
    let mut bounds: Option<Aabb> = part.domain;
    for o in &operands {
        let read = match o {
            Operand::Foreign(placed) => Some(load(placed, &part.folder, run)?),
            Operand::Functions(_) => None,
        };
        for b in read.iter().map(operand::Loaded::bounds) {
            bounds = Some(bounds.map_or(b, |a| a.union(&b)));
        }
        loaded.push(read);
    }
    let Some(bounds) = bounds else { return Err(Error::Failed("no operand has a boundary".into())) };
    measurable(&bounds)?;
    let size = options.size.or(part.mesh.size).unwrap_or(DEFAULT_SIZE).length(bounds.diagonal());
    let mut report = Report::of("joined", size, part.units.clone());
    let mut clock = Clock::new(options.timed);
    let options = &options.resolved(bounds.diagonal());
    let own = with_size(options, size);
    let for_operands = run.for_a_part();
    let wanted = OperandGoal { part, options: &own, size, run: &for_operands };
    let mut boundaries: Vec<Option<PreparedOperand>> = Vec::with_capacity(operands.len());
    for (o, read) in operands.iter().zip(loaded) {
        boundaries.push(match (o, read) {
            (Operand::Foreign(placed), Some(read)) => Some(make_foreign(placed, read, &wanted, &mut report)?),
            _ => None,
        });
    }
    // What has no end is kept in a box around where it matters, of all that has one.
    let known: Vec<Aabb> = operands
        .iter()
        .zip(&boundaries)
        .map(|(o, boundary)| match (o, boundary) {
            (_, Some(made)) => made.mesh.bounds(),
            (Operand::Functions(s), None) => extent(s, part),
            (Operand::Foreign(_), None) => Aabb::ALL,
        })
        .collect();
    let around = known.iter().filter(|b| b.is_finite()).fold(bounds, |a, b| a.union(b));
    let mut attempts = Attempts::new(options.timed);
    let mut made: Vec<PreparedOperand> = Vec::with_capacity(operands.len());
    for (k, (o, boundary)) in operands.iter().zip(boundaries).enumerate() {
        made.push(match (o, boundary) {
            (_, Some(boundary)) => boundary,
            (Operand::Functions(s), None) => {
                let matters = tree.matters(k, &known).intersection(&around);
                let inner = if matters.is_empty() { around } else { matters };
                let within = inner.grown((BEYOND + MORE * k as f64) * inner.diagonal());
                make_functions(s, kept_in(&known[k], &within), &wanted, &mut attempts, &mut report)?
            }
            (Operand::Foreign(placed), None) => return Err(placed.solid.refused("was not read")),
        });
    }
    report.stage("operands", made.iter().map(|m| m.mesh.triangles.len()).sum(), &mut clock, run);
    let scale = made.iter().fold(Aabb::EMPTY, |b, m| b.union(&m.mesh.bounds())).diagonal();
    align(&mut made, scale);
    if let Some(at) = coinciding(&made, scale, run)? {
        let what = "curved or slanting surfaces of two operands coincide here: there is no exact border between them";
        return Err(Error::input(Place::Point(at), what)
            .with_help("make one of them a little larger or smaller; flat faces square to an axis may coincide"));
    }
    run.progress("join", 0.0);
    let meshes: Vec<&TriMesh> = made.iter().map(|m| &m.mesh).collect();
    let endless = || {
        let what = "the solid may be infinite: what the boundaries are joined with has no end";
        let e = Error::input(Place::Solid(NoBody::Endless), what)
            .with_help("give part(..., domain=((x0, y0, z0), (x1, y1, z1)))");
        part.located(e)
    };
    if tree.holds(&vec![false; made.len()]) {
        return Err(endless());
    }
    let joined = boolean(&meshes, &|state| tree.holds(state), run)?.ok_or_else(misfit)?;
    if joined.mesh.triangles.is_empty() {
        let what = "the solid is empty: nothing is inside anywhere";
        return Err(part.located(Error::input(Place::Solid(NoBody::Empty), what)));
    }
    let numbers = Numbers::new(&made);
    if joined.from.iter().any(|t| numbers.is_wall(*t)) {
        return Err(endless());
    }
    check_groups(part, numbers.names.iter().map(String::as_str))?;
    report.stage("join", joined.mesh.triangles.len(), &mut clock, run);
    let asked: Vec<KnownPieces<'_>> = made.iter().map(|m| m.surface.asked()).collect();
    let joint =
        OperandPieces { operands: asked.iter().map(KnownPieces::pieces).collect(), home: numbers.home(), scale };
    let work = prepare(&joined, &numbers, &joint, REACH * size, run)?;
    let PreparedWork { patchwork, tangent, astray } = work;
    let exact = remesh_options(&numbers, bounds.diagonal(), size, options)?;
    let names = TriMesh { faces: numbers.names.clone(), ..TriMesh::default() };
    let mut ladder = Remeshing::new(&names, &joint, &exact, size, patchwork);
    let Some((mut best, number)) = climb(&mut ladder, &mut attempts, run)? else { return Err(Error::Cancelled) };
    attempts.tell(&[number], &mut report);
    if !joined.touching.is_empty() {
        let drawn = draw_apart(&mut best.mesh, scale, run)?;
        if drawn > 0 {
            let what = "the solid touches itself: nodes there are drawn back into it by a billionth of its size";
            report.warnings.push(format!("{what}, {drawn} of them"));
        }
    }
    if !tangent.is_empty() {
        report.shortfalls.push(Fault::tangent(&tangent));
    }
    if !astray.is_empty() {
        report.shortfalls.push(Fault::edges_missing(&astray));
    }
    if best.report.inverted > 0 {
        report.shortfalls.push(Fault::FacingAway { triangles: best.report.inverted, places: Vec::new() });
    }
    let known = numbers.names.iter().map(String::as_str);
    report.stage("mesh", best.mesh.triangles.len(), &mut clock, run);
    name_groups(part, &mut best.mesh, &made, &mut report);
    let mut whole = finished(best, report, &mut clock, run)?;
    whole.report.shortfalls.extend(lost_groups(part, known, &whole.mesh.faces));
    Ok(whole)
}

/// The box to keep an operand of R-functions in, if it is worth it. `known` is a box around the operand, `within` one around where it
/// matters.
fn kept_in(known: &Aabb, within: &Aabb) -> Option<Aabb> {
    if !known.is_finite() {
        return Some(*within);
    }
    let volume = |b: &Aabb| b.size().element_product();
    // Walls stay away from the operand's own sides, or they would all but coincide with its faces.
    let kept = within.intersection(&known.grown(BEYOND * known.diagonal()));
    let is_worth = !kept.is_empty() && volume(&kept.intersection(known)) <= WORTH * volume(known);
    is_worth.then_some(kept)
}

/// Options that only solids of R-functions, or only boundaries, know.
fn refuse(options: &MeshOptions) -> Result<()> {
    let refused = [
        (options.method != Method::Leaf, "is joined with exact edges, by the method leaf alone"),
        (options.sequence.is_some(), "is not made by a sequence of operators"),
        (options.thickness.is_some(), "has no thickness that edges could follow"),
        (options.trim.is_some(), "is not trimmed"),
    ];
    match refused.iter().find(|r| r.0) {
        Some((_, what)) => Err(Error::Usage(format!("a part with a mesh or a CAD model in it {what}"))),
        None => Ok(()),
    }
}

fn remesh_options(numbers: &Numbers<'_>, diagonal: f64, size: f64, options: &MeshOptions) -> Result<RemeshOptions> {
    let wishes = Wishes::new(&options.refinements, diagonal, numbers.names.iter().map(String::as_str))?;
    let wanted = Wish::new(size, diagonal, options.asked());
    let least = options.least_length().unwrap_or(size / LEAST_SHARE);
    // What the surfaces' curvature asks for is known at the nodes of the operands.
    let chord = options.tolerance_length().map(|_| wanted.chord());
    let sizing = Sizing { size, nodes_per_radius: None, chord, least };
    let plain = RemeshOptions::new(sizing, wanted.grading);
    let own = |k: usize| numbers.face_sizes.get(k).copied().flatten();
    let wish = |k: usize| wishes.faces.get(k).copied().flatten();
    let smaller = |a: Option<f64>, b: Option<f64>| a.map_or(b, |a| Some(b.map_or(a, |b| a.min(b))));
    let face_sizes = (0..numbers.names.len()).map(|k| smaller(own(k), wish(k))).collect();
    let narrowest = options.least_length().unwrap_or(size / NARROWEST);
    Ok(RemeshOptions { face_sizes, regions: wishes.regions, narrowest, ..plain })
}

/// Gives the mesh the groups of the part, and those of its operands that have names of their own.
fn name_groups(part: &Part, mesh: &mut TriMesh, made: &[PreparedOperand], report: &mut Report) {
    mesh.groups.clear();
    finish_names(part, mesh, report);
    for (name, faces) in made.iter().flat_map(|m| named_groups(&m.mesh)) {
        let number = |f: &String| mesh.faces.iter().position(|x| x == f).map(|k| k as u32);
        let faces: Vec<u32> = faces.iter().filter_map(number).collect();
        if !faces.is_empty() && !mesh.groups.iter().any(|g| g.name == name) {
            mesh.groups.push(Group { name, faces });
        }
    }
}

/// The finished mesh with its report.
fn finished(best: RemeshedMesh, mut report: Report, clock: &mut Clock, run: &Run) -> Result<Meshed> {
    let RemeshedMesh { mesh, seams, corners, .. } = best;
    run.progress("check", 0.0);
    let measured = check(&mesh, Expectation::default(), None, run)?;
    report.judge(measured, 0.0);
    report.stage("check", mesh.triangles.len(), clock, run);
    let source = MeshOrigin::Unknown("is joined of several solids");
    Ok(Meshed { mesh, seams, corners, outline: None, report, source })
}
