//! Operands as closed meshes that know the piece of each triangle, and the surfaces behind them.

use std::path::Path;

use glam::DVec3;

use super::super::brep::load_step;
use super::super::budget::covering;
use super::super::built::build_one;
use super::super::cells::{CellLadder, Start};
use super::super::discrete::{SoupOptions, discrete_options, load_mesh};
use super::super::first_faces::{FaceLadder, First};
use super::super::ladder::Attempts;
use super::super::leaf::remesh_options;
use super::super::mesh::Ready;
use super::super::options::MeshOptions;
use super::super::refine::Wishes;
use super::super::report::Report;
use super::super::soup_sizes::{feature_sizes, relaxed, sizing};
use super::tree::BoundarySolid;
use crate::discrete::Discrete;
use crate::error::{Error, Place, Result};
use crate::geometry::Pieces;
use crate::implicit::part::Part;
use crate::implicit::{Boundary, Extracted, Implicit, ImplicitOracle, Placement, Solid};
use crate::mesh::{Group, TriMesh};
use crate::numeric::ROUNDING;
use crate::parametric::mesh::Place as Lies;
use crate::parametric::{Parametric, Similarity};
use crate::quality::{Expectation, Fault, check};
use crate::run::Run;
use crate::sizing::{SizeRequest, Wish};
use crate::spatial::Aabb;

/// A solid given by its boundary, as read.
pub(super) enum Loaded {
    Triangles(TriMesh),
    Faces(Box<Parametric>),
}

impl Loaded {
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Loaded::Triangles(mesh) => mesh.bounds(),
            Loaded::Faces(solid) => solid.bounds(),
        }
    }
}

/// What answers for an operand's surface.
pub(super) enum OperandSurface {
    Triangles(Box<Discrete>),
    Faces(Box<Parametric>),
    Functions(Box<(Ready, Extracted)>),
}

/// An operand ready to be joined with others.
pub(super) struct PreparedOperand {
    pub(super) surface: OperandSurface,
    /// Closed, without self-intersections; labels are indices of `mesh.faces`.
    pub(super) mesh: TriMesh,
    /// The piece of each triangle.
    pub(super) pieces: Vec<u32>,
    /// How many pieces there are.
    pub(super) count: u32,
    /// The largest edge length each node may want.
    pub(super) sizes: Vec<f64>,
    /// Nodes that stay where they are.
    pub(super) pinned: Vec<bool>,
    /// Edge lengths wanted on faces.
    pub(super) face_sizes: Vec<Option<f64>>,
    /// The box that an endless solid is kept in: what lies on its sides bounds nothing.
    pub(super) walled: Option<Aabb>,
}

/// What is asked for the surface of an operand.
pub(super) enum KnownPieces<'a> {
    Known(&'a dyn Pieces),
    Leaves(ImplicitOracle<'a>),
}

impl KnownPieces<'_> {
    pub(super) fn pieces(&self) -> &dyn Pieces {
        match self {
            KnownPieces::Known(pieces) => *pieces,
            KnownPieces::Leaves(oracle) => oracle,
        }
    }
}

impl OperandSurface {
    pub(super) fn asked(&self) -> KnownPieces<'_> {
        match self {
            OperandSurface::Triangles(solid) => KnownPieces::Known(&**solid),
            OperandSurface::Faces(solid) => KnownPieces::Known(&**solid),
            OperandSurface::Functions(made) => KnownPieces::Leaves(ImplicitOracle::new(&made.0.model, &made.1)),
        }
    }
}

/// What every operand is made for.
#[derive(Clone, Copy)]
pub(super) struct OperandGoal<'a> {
    pub(super) part: &'a Part,
    /// Its size is that of `size`.
    pub(super) options: &'a MeshOptions,
    /// The length of edges.
    pub(super) size: f64,
    pub(super) run: &'a Run,
}

/// Gives an error of a file or of geometry the place in the part file, with what it was about.
pub(super) fn at(placed: &BoundarySolid, e: Error) -> Error {
    match e {
        Error::Cancelled => Error::Cancelled,
        // Something inside a recipe, which knows its own place.
        Error::Input { file: None, place: Place::Text { .. }, .. } => e,
        e => {
            let told = Error::input(placed.solid.place.clone(), e.to_string());
            match e {
                Error::Input { help: Some(help), .. } => told.with_help(help),
                _ => told,
            }
        }
    }
}

/// What faces of a solid are called by, where the part file says nothing: its file without folder and ending. With an empty name they
/// keep their own.
fn name_of(placed: &BoundarySolid) -> Option<String> {
    if let Some(name) = &placed.name {
        return (!name.is_empty()).then(|| name.to_string());
    }
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned());
    match &placed.solid.source {
        Boundary::Mesh(path) | Boundary::Step(path) => stem(path),
        Boundary::Built(recipe) => recipe.name.clone(),
    }
}

/// Reads a solid given by its boundary and puts it in its place. `folder` is the part file's.
///
/// Errors: what cannot be read or is no closed surface, at its place in the part file.
pub(super) fn load(placed: &BoundarySolid, folder: &Path, run: &Run) -> Result<Loaded> {
    let read = || -> Result<Loaded> {
        let brep = match &placed.solid.source {
            Boundary::Mesh(path) => {
                let path = folder.join(path);
                if super::super::brep::is_step(&path) {
                    let what = format!("{} is a STEP file", path.display());
                    return Err(Error::input(Place::Unknown, what).with_help("step(path) reads it"));
                }
                return load_triangles(placed, &load_mesh(&path, run)?, run).map(Loaded::Triangles);
            }
            Boundary::Step(path) => {
                let path = folder.join(path);
                let model = load_step(&path, run)?;
                if let Some(n) = model.notes.iter().find(|n| n.lost) {
                    let what = format!("not all of {} is understood: {n}", path.display());
                    return Err(Error::input(Place::Unknown, what));
                }
                model.brep
            }
            Boundary::Built(recipe) => build_one(recipe, run)?,
        };
        let p = placed.placement;
        let brep = brep.moved(&Similarity { scale: p.scale, rotation: p.rotation, translation: p.shift });
        let brep = match (&placed.solid.source, name_of(placed)) {
            // Recipes put their own names before those of faces.
            (Boundary::Built(r), Some(name)) if r.name.as_ref() == Some(&name) => brep,
            (_, Some(name)) => brep.named(&name),
            (_, None) => brep,
        };
        if brep.uses().contains(&1) {
            return Err(Error::input(Place::Unknown, "it is open: set operations are for solids, not for sheets"));
        }
        Ok(Loaded::Faces(Box::new(Parametric::new(brep, run)?)))
    };
    run.check()?;
    read().map_err(|e| at(placed, e))
}

fn load_triangles(placed: &BoundarySolid, mesh: &TriMesh, run: &Run) -> Result<TriMesh> {
    let mut mesh = mesh.clone();
    mesh.validate()?;
    mesh.drop_unused_nodes();
    place(&mut mesh, &placed.placement);
    if let Some(name) = name_of(placed) {
        let alone = mesh.faces.len() == 1;
        mesh.faces.iter_mut().for_each(|f| *f = if alone { name.clone() } else { format!("{name}.{f}") });
    }
    sound(&mesh, run).map_err(|why| match why {
        Error::Input { .. } => why.with_help("`rvachev heal` closes holes and takes out what intersects"),
        other => other,
    })?;
    Ok(mesh)
}

/// Errors: why a mesh cannot be an operand, with a place.
pub(super) fn sound(mesh: &TriMesh, run: &Run) -> Result<()> {
    let found = check(mesh, Expectation::default(), None, run)?;
    if found.certificate.is_sound() {
        return Ok(());
    }
    let what = format!("set operations are for closed surfaces that do not cross themselves: {}", found.certificate);
    Err(Error::input(Place::Unknown, what))
}

/// Moves, turns, scales or mirrors a mesh; a mirrored one winds the other way round.
fn place(mesh: &mut TriMesh, by: &Placement) {
    if *by == Placement::IDENTITY {
        return;
    }
    mesh.nodes.iter_mut().for_each(|p| *p = by.apply(*p));
    if by.rotation.determinant() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}

/// Makes an operand of a solid given by its boundary.
///
/// Errors: what cannot be meshed, at its place in the part file.
pub(super) fn make_foreign(
    placed: &BoundarySolid,
    loaded: Loaded,
    wanted: &OperandGoal<'_>,
    report: &mut Report,
) -> Result<PreparedOperand> {
    let mut made = match loaded {
        Loaded::Triangles(mesh) => of_triangles(&mesh, wanted, report),
        Loaded::Faces(solid) => of_faces(solid, wanted, report),
    }
    .map_err(|e| match e {
        // Too many triangles for the memory: that is not the file's fault.
        Error::Usage(_) => e,
        e => at(placed, e),
    })?;
    if placed.size.is_some() {
        made.face_sizes.iter_mut().for_each(|s| *s = placed.size);
    }
    Ok(made)
}

fn of_triangles(mesh: &TriMesh, wanted: &OperandGoal<'_>, report: &mut Report) -> Result<PreparedOperand> {
    let OperandGoal { options, size, run, .. } = *wanted;
    let soup = SoupOptions::default();
    covering(mesh.area(), size, run)?;
    let solid = Discrete::new(mesh, &discrete_options(&soup, size), run)?;
    let sizing = relaxed(sizing(size, solid.bounds().diagonal(), options), options, &soup, &solid);
    let sizes =
        feature_sizes(&solid, &sizing, Wish::new(size, solid.bounds().diagonal(), options.asked()).chord(), report);
    let named = solid.named();
    let m = &solid.mesh;
    let ends = m.edges().filter(|&h| m.is_sharp(h) && m.label(h / 3) == m.label(m.opposite(h) / 3)).count();
    if ends > 0 {
        let what = "edges of a mesh that end within a face are kept only as far as its triangles show them";
        report.warnings.push(format!("{what}: {ends} segments"));
    }
    let pinned = m.nodes().map(|v| m.is_pinned(v)).collect();
    let (pieces, count, faces) = (named.labels.clone(), solid.face_count() as u32, named.faces.len());
    Ok(PreparedOperand {
        surface: OperandSurface::Triangles(Box::new(solid)),
        mesh: named,
        pieces,
        count,
        sizes,
        pinned,
        face_sizes: vec![None; faces],
        walled: None,
    })
}

fn of_faces(solid: Box<Parametric>, wanted: &OperandGoal<'_>, report: &mut Report) -> Result<PreparedOperand> {
    let OperandGoal { options, size, run, .. } = *wanted;
    // First triangles are what a set operation starts from, and not remeshed.
    let alone = Report { size, ..report.clone() };
    let wishes = Wishes::default();
    let mut ladder = FaceLadder::new(&solid, options, &wishes, &alone);
    let chord = Wish::new(size, solid.bounds().diagonal(), options.asked()).chord();
    let First { made, report: told, .. } = ladder.within(chord, &[], &mut Attempts::new(false), run)?;
    *report = told;
    let mut mesh = made.mesh;
    if let Some(lacking) = report.shortfalls.iter().find(|f| matches!(f, Fault::NoMesh { .. })) {
        return Err(Error::input(Place::Unknown, lacking.to_string()));
    }
    mesh.groups = super::super::brep::groups(&solid.brep);
    sound(&mesh, run)?;
    let corners = solid.corners();
    let tips = solid.tips();
    // A node this near to a point without a normal is on it.
    let near = ROUNDING * solid.bounds().diagonal();
    let is_tip = |p: DVec3| tips.iter().any(|t| t.1.distance(p) <= near);
    let pinned = made.places.iter().zip(&mesh.nodes).map(|(place, p)| match place {
        Lies::Vertex(x) => corners.get(*x as usize).copied().unwrap_or(true) || is_tip(*p),
        Lies::Edge(_) => false,
        Lies::Face(_) => is_tip(*p),
    });
    let (pinned, faces) = (pinned.collect(), mesh.faces.len());
    Ok(PreparedOperand {
        mesh,
        pieces: made.pieces,
        count: solid.piece_count(),
        sizes: made.sizes,
        pinned,
        face_sizes: vec![None; faces],
        walled: None,
        surface: OperandSurface::Faces(solid),
    })
}

/// A box around a solid of R-functions; everything where it may have no end.
pub(super) fn extent(solid: &Solid, part: &Part) -> Aabb {
    Implicit::new(solid, part.rsystem, None).map_or(Aabb::ALL, |model| model.bounds())
}

/// Makes an operand of R-functions; a solid that may have no end is kept in a box, its `domain`.
///
/// Errors: those of [`Implicit::new`]; [`Error::Failed`] where no mesh without intersections is found.
pub(super) fn make_functions(
    solid: &Solid,
    domain: Option<Aabb>,
    wanted: &OperandGoal<'_>,
    attempts: &mut Attempts,
    report: &mut Report,
) -> Result<PreparedOperand> {
    let OperandGoal { part, options, run, .. } = *wanted;
    let alone = Part { solid: Some(solid.clone()), domain, built: Vec::new(), groups: Vec::new(), ..part.clone() };
    let ready = Ready::new(&alone, options.size)?;
    let mut own = Attempts::new(options.timed);
    let found = CellLadder::new(&ready, options, Start::default()).search(&mut own, run)?;
    attempts.append(own);
    let Some(best) = found else {
        return Err(Error::Failed("most triangles of the R-functions' solid cross others".into()));
    };
    report.shortfalls.extend(best.shortfalls(&ready));
    if best.faults() > 0 {
        let near = best.exact.report.faults.first().map_or(DVec3::ZERO, Aabb::center);
        let what = format!("{} triangles of the R-functions' solid cross others near here", best.faults());
        return Err(Error::Failed(format!("({:.6}, {:.6}, {:.6}): {what}", near.x, near.y, near.z)));
    }
    let sizing = remesh_options(&ready, options, best.scout.cell)?.sizing;
    let face_sizes: Vec<Option<f64>> = ready.model.faces().iter().map(|f| f.size).collect();
    let (mesh, mut pieces) = (best.exact.mesh, best.exact.pieces);
    let count = ready.model.leaf_count() as u32;
    let surface = OperandSurface::Functions(Box::new((ready, best.scout.extracted)));
    let (mut sizes, mut pinned) = (vec![f64::INFINITY; mesh.nodes.len()], vec![false; mesh.nodes.len()]);
    let asked = surface.asked();
    let oracle = asked.pieces();
    for (t, piece) in pieces.iter_mut().enumerate() {
        if *piece >= count {
            let what = "a triangle of the R-functions' solid lies on no leaf";
            *piece = oracle.piece_at(mesh.centroid(t)).ok_or_else(|| Error::Failed(what.into()))?;
        }
        for v in mesh.triangles[t].map(|v| v as usize) {
            let bend = oracle.curvature(*piece, mesh.nodes[v]).map_or(f64::INFINITY, |k| sizing.at(k));
            sizes[v] = sizes[v].min(bend);
        }
    }
    let near = ROUNDING * mesh.bounds().diagonal();
    for (_, apex) in oracle.apexes() {
        pinned.iter_mut().zip(&mesh.nodes).for_each(|(pin, p)| *pin |= p.distance(apex) <= near);
    }
    drop(asked);
    Ok(PreparedOperand { surface, mesh, pieces, count, sizes, pinned, face_sizes, walled: domain })
}

/// A size as a length.
pub(super) fn with_size(options: &MeshOptions, size: f64) -> MeshOptions {
    MeshOptions { size: Some(SizeRequest::Length(size)), refinements: Vec::new(), ..options.clone() }
}

/// Groups of an operand by the names of their faces.
pub(super) fn named_groups(mesh: &TriMesh) -> Vec<(String, Vec<String>)> {
    let name = |f: &u32| mesh.faces.get(*f as usize).cloned();
    mesh.groups.iter().map(|g: &Group| (g.name.clone(), g.faces.iter().filter_map(name).collect())).collect()
}
