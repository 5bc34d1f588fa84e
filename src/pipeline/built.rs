//! Solids a part file builds from edges: handed to the parametric gate, meshed beside the part's solid of R-functions, and
//! written as STEP.

use std::path::Path;

use glam::{DMat3, DVec3};

use super::brep::{expected, mesh_step};
use super::groups::{check_groups, finish_names, lost_groups};
use super::mesh::{Meshed, Ready};
use super::options::MeshOptions;
use super::source::MeshOrigin;
use crate::error::{Error, Place, Result};
use crate::implicit::Placement;
use crate::implicit::part::recipe::{Build, EdgeKind, Edges, Recipe, SectionRecipe, Sheet};
use crate::implicit::part::{Part, glob};
use crate::io::write_atomic;
use crate::mesh::{Group, TriMesh};
use crate::parametric::basis::Knots;
use crate::parametric::brep::Brep;
use crate::parametric::build::{
    Across, Axis, Extrusion, Loft, Section, Wire, extrude_edges, flat_face, loft, over_chains, patch, revolve_edges,
    sew, shift_edges, sweep_edges,
};
use crate::parametric::nurbs::{CurveEdit, NurbsCurve, NurbsSurface, Pass, SplineEnds, edited};
use crate::parametric::step::write_step;
use crate::parametric::{Curve, Frame, Parametric, Similarity};
use crate::quality::{Expectation, Fault, check};
use crate::run::Run;

/// The unit of a part that names none.
const UNIT: &str = "mm";
/// How many names a message lists.
const NAMED: usize = 12;

fn similarity(p: &Placement) -> Similarity {
    Similarity { scale: p.scale, rotation: p.rotation, translation: p.shift }
}

fn wire(edges: &Edges) -> Result<Wire> {
    let mut wires = Vec::with_capacity(edges.parts.len());
    for (kind, placement) in &edges.parts {
        let made = match &**kind {
            EdgeKind::Polyline(points) => Wire::polyline(points)?,
            EdgeKind::Spline { points, closed: true, .. } => Wire::spline(points, SplineEnds::Closed)?,
            EdgeKind::Spline { points, ends: Some([a, b]), .. } => Wire::spline(points, SplineEnds::Clamped(*a, *b))?,
            EdgeKind::Spline { points, parabolic: true, .. } => Wire::spline(points, SplineEnds::Parabolic)?,
            EdgeKind::Spline { points, .. } => Wire::spline(points, SplineEnds::Natural)?,
            EdgeKind::Bezier { points, weights } => {
                Wire::curve(Curve::Nurbs(NurbsCurve::bezier(points, weights.as_deref())?), [0.0, 1.0])?
            }
            EdgeKind::Arc([a, b, c]) => Wire::arc(*a, *b, *c)?,
            EdgeKind::Ellipse { at, axis, x, radii } => Wire::ellipse(Frame::new(*at, *axis, *x), radii[0], radii[1])?,
            EdgeKind::Parabola { at, axis, x, focal, across } => {
                Wire::parabola(Frame::new(*at, *axis, *x), *focal, *across)?
            }
            EdgeKind::Hyperbola { at, axis, x, radii, across } => {
                Wire::hyperbola(Frame::new(*at, *axis, *x), *radii, *across)?
            }
            EdgeKind::Conic { coefficients, ends } => Wire::conic(*coefficients, *ends)?,
            EdgeKind::Polynomial { coefficients, range } => Wire::nurbs(NurbsCurve::polynomial(coefficients, *range)?)?,
            EdgeKind::Lagrange { points, parameters } => Wire::nurbs(NurbsCurve::lagrange(parameters, points)?)?,
            EdgeKind::Nurbs { points, degree, knots, weights, through, tangents } => {
                let knots = knots_of(knots.as_ref(), *degree, points.len())?.values().to_vec();
                let through = through.iter().map(|x| CurveEdit { t: x.0, pass: Pass::Point(x.1) });
                let tangents = tangents.iter().map(|x| CurveEdit { t: x.0, pass: Pass::Direction(x.1) });
                let edits: Vec<CurveEdit> = through.chain(tangents).collect();
                Wire::nurbs(edited(&NurbsCurve::new(*degree, knots, points, weights.as_deref())?, &edits)?)?
            }
        };
        wires.push(made.moved(&similarity(placement)));
    }
    Wire::joined(&wires)
}

fn wires(all: &[Edges]) -> Result<Vec<Wire>> {
    all.iter().map(wire).collect()
}

/// Knots as they are given, or at equal distances.
fn knots_of(given: Option<&Vec<f64>>, degree: usize, points: usize) -> Result<Knots> {
    match given {
        Some(k) => Knots::new(degree, k.clone(), points),
        None => Knots::uniform(degree, points),
    }
}

fn sheet(s: &Sheet, run: &Run) -> Result<Brep> {
    match s {
        Sheet::Shift { profile, path, offset } => shift_edges(&wire(profile)?, &wire(path)?, *offset, run),
        Sheet::Hermite { curves, closed } => over_chains(&wires(curves)?, &Across::Hermite { closed: *closed }, run),
        Sheet::Spline { curves, degree, knots, weights } => {
            let how = Across::Spline { degree: *degree, knots: knots.clone(), weights: weights.clone() };
            over_chains(&wires(curves)?, &how, run)
        }
        Sheet::Fillet(three) => over_chains(&wires(&three[..])?, &Across::Fillet, run),
        Sheet::Nurbs(net) => {
            let [u, v] = [0, 1].map(|k| knots_of(net.knots[k].as_ref(), net.degrees[k], net.size[k]));
            patch(NurbsSurface::new(u?, v?, &net.points, net.weights.as_deref())?, run)
        }
    }
}

/// A solid scaled about its center of mass, which is known to five or six digits.
fn about_mass(brep: Brep, scale: f64, run: &Run) -> Result<Brep> {
    let wrong = |what: &str| Err(Error::input(Place::Unknown, what));
    if brep.bodies.iter().any(|b| !b.solid) || brep.uses().contains(&1) {
        return wrong("a sheet has no mass: give \"about\" a point");
    }
    let solid = Parametric::new(brep, run)?;
    let m = solid.measure(run)?;
    let volume: f64 = m.volumes.iter().sum();
    let moment: DVec3 = m.centers.iter().zip(&m.volumes).map(|(c, v)| c.unwrap_or_default() * *v).sum();
    let center = moment / volume;
    if m.faces.iter().any(|f| f.area.is_none()) || !(volume > 0.0) || !center.is_finite() {
        return wrong("the center of mass is not known, as a face could not be measured: give \"about\" a point");
    }
    let translation = center - scale * center;
    Ok(solid.brep.moved(&Similarity { scale, rotation: DMat3::IDENTITY, translation }))
}

/// Builds one. Errors: without a place in the file, but for those of recipes inside it.
pub(super) fn build_one(r: &Recipe, run: &Run) -> Result<Brep> {
    let made = match &r.build {
        Build::Extrude { edges, direction, distance, scale, center, hole_scale, solid } => {
            let how = Extrusion {
                scale: *scale,
                center: *center,
                hole_scale: *hole_scale,
                caps: *solid,
                ..Extrusion::new(*direction, *distance)
            };
            extrude_edges(&wires(edges)?, &how)?
        }
        Build::Revolve { edges, at, axis, degrees, solid } => {
            revolve_edges(&wire(edges)?, &Axis { origin: *at, direction: *axis }, *degrees, *solid)?
        }
        Build::Loft { sections, ruled, round, square, solid } => {
            let sections: Result<Vec<Section>> = sections
                .iter()
                .map(|s| match s {
                    SectionRecipe::Edges(e) => wire(e).map(Section::Wire),
                    SectionRecipe::Point(p) => Ok(Section::Point(*p)),
                })
                .collect();
            loft(&sections?, &Loft { ruled: *ruled, caps: *solid, round: *round, square: *square })?
        }
        Build::Sweep { edges, path, solid } => sweep_edges(&wires(edges)?, &wire(path)?, *solid)?,
        Build::AboutMass { part, scale } => {
            let made = build_all(std::slice::from_ref(&**part), run)?;
            about_mass(Brep::together(made), *scale, run)?
        }
        Build::Sheet(s) => sheet(s, run)?,
        Build::Flat(edges) => flat_face(&wires(edges)?)?,
        Build::Sew { parts, tolerance, solid } => sew(build_all(parts, run)?, *tolerance, *solid, run)?,
    };
    for p in &r.without {
        if !made.faces.iter().any(|f| glob(p, &f.name)) {
            let names: Vec<&str> = made.faces.iter().take(NAMED).map(|f| f.name.as_str()).collect();
            let what = format!("no face is called {p:?}; there are {}", names.join(", "));
            return Err(Error::input(Place::Unknown, what));
        }
    }
    let left = made.without(|name| r.without.iter().any(|p| glob(p, name)));
    let placed = left.moved(&similarity(&r.placement));
    Ok(match &r.name {
        Some(name) => placed.named(name),
        None => placed,
    })
}

/// Builds several; errors have the place in the file.
fn build_all(recipes: &[Recipe], run: &Run) -> Result<Vec<Brep>> {
    let several = recipes.len() > 1;
    let mut all = Vec::with_capacity(recipes.len());
    for (i, r) in recipes.iter().enumerate() {
        run.check()?;
        let made = build_one(r, run).map_err(|e| match e {
            Error::Input { place: Place::Unknown, message, help, file } => {
                Error::Input { file, place: r.place.clone(), message, help }
            }
            other => other,
        })?;
        // Faces of several solids without names would be called alike.
        all.push(if several && r.name.is_none() { made.named(&format!("solid{}", i + 1)) } else { made });
    }
    Ok(all)
}

/// Builds what a part file says of solids made from edges; `None` where it says nothing. Lengths are in the part's unit.
///
/// Errors: what cannot be built, with its place in the file; cancellation.
pub fn build(part: &Part, run: &Run) -> Result<Option<Brep>> {
    if part.built.is_empty() {
        return Ok(None);
    }
    Ok(Some(Brep::together(build_all(&part.built, run)?)))
}

/// Meshes a part whose solids are built from edges, beside its solid of R-functions where it has one.
pub(super) fn mesh_built(part: &Part, brep: Brep, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    let mut names: Vec<String> = brep.faces.iter().map(|f| f.name.clone()).collect();
    if part.solid.is_some() {
        names.extend(Ready::new(part, options.size)?.model.faces().iter().map(|f| f.name.clone()));
    }
    check_groups(part, names.iter().map(String::as_str))?;
    if part.solid.is_some() && options.volume.is_some() {
        let what =
            "the part has a solid of R-functions beside those built from edges, whose volume is not known exactly";
        return Err(Error::Usage(what.into()));
    }
    let sized = MeshOptions { size: options.size.or(part.mesh.size), ..options.clone() };
    let open = expected(&brep, &[]).open;
    let mut made = mesh_step(brep.into(), &sized, run)?;
    made.report.units.clone_from(&part.units);
    // Groups by name: faces without triangles are dropped below.
    let named = |mesh: &TriMesh| -> Vec<(String, Vec<String>)> {
        let names = |g: &Group| g.faces.iter().map(|f| mesh.faces[*f as usize].clone()).collect();
        mesh.groups.iter().map(|g| (g.name.clone(), names(g))).collect()
    };
    let bodies = named(&made.mesh);
    made.mesh.groups.clear();
    if part.solid.is_some() {
        let options = &MeshOptions { without: Vec::new(), trim: None, ..options.clone() };
        let rest = Part { built: Vec::new(), groups: Vec::new(), ..part.clone() };
        let other = super::mesh::mesh_part(&rest, options, run)?;
        append(&mut made.mesh, &other.mesh);
        made.source = MeshOrigin::Unknown("is of functions and of solids built from edges");
        made.report.warnings.extend(other.report.warnings);
        made.report.shortfalls.extend(other.report.shortfalls);
        made.report.method = "faces and leaf";
        let open = open || made.report.shortfalls.iter().any(Fault::leaves_open);
        let expected = Expectation { open, touching: false };
        made.report.check = Some(check(&made.mesh, expected, None, run)?);
        let faults = made.report.check.iter().flat_map(|c| &c.certificate.faults).cloned().collect::<Vec<_>>();
        for f in faults {
            if !made.report.shortfalls.contains(&f) {
                made.report.shortfalls.push(f);
            }
        }
    }
    finish_names(part, &mut made.mesh, &mut made.report);
    made.report.shortfalls.extend(lost_groups(part, names.iter().map(String::as_str), &made.mesh.faces));
    for (name, faces) in bodies {
        let faces: Vec<u32> =
            faces.iter().filter_map(|f| made.mesh.faces.iter().position(|x| x == f)).map(|i| i as u32).collect();
        if !faces.is_empty() && !made.mesh.groups.iter().any(|g| g.name == name) {
            made.mesh.groups.push(Group { name, faces });
        }
    }
    Ok(made)
}

/// Puts a mesh beside another; faces of one name become one.
fn append(to: &mut TriMesh, from: &TriMesh) {
    let start = to.nodes.len() as u32;
    let faces: Vec<u32> = from
        .faces
        .iter()
        .map(|name| {
            let known = to.faces.iter().position(|n| n == name);
            known.unwrap_or_else(|| {
                to.faces.push(name.clone());
                to.faces.len() - 1
            }) as u32
        })
        .collect();
    to.nodes.extend(from.nodes.iter().copied());
    to.triangles.extend(from.triangles.iter().map(|t| t.map(|v| v + start)));
    to.labels.extend(from.labels.iter().map(|l| faces[*l as usize]));
}

/// Writes a boundary representation as a STEP file (AP214), in a unit of length: see [`write_step`].
pub fn save_step(path: &Path, brep: &Brep, unit: Option<&str>) -> Result<()> {
    let name = path.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let text = write_step(brep, &name, unit.unwrap_or(UNIT))?;
    write_atomic(path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io("write", path, e)))
}
