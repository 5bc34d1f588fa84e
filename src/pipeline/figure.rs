//! Plane figures: meshed as the top of a slab of their own shape, of which nothing but the top is handed on.
//!
//! Corners, edges and sizes are then those of solids, found and proved in the same ways. The slab is several edges thick, so
//! neither its thickness nor its bottom has a say in how long edges are.

use std::fmt;

use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::groups::{check_groups, lost_groups};
use super::mesh::{Meshed, mesh_part};
use super::method::Method;
use super::options::MeshOptions;
use super::report::{Info, LeafInfo, Report};
use super::source::MeshOrigin;
use crate::error::{Error, Place, Result};
use crate::geometry::SurfaceOracle;
use crate::implicit::part::{Part, glob};
use crate::implicit::{Implicit, ImplicitOracle, Solid, check_plane};
use crate::io::{ClosedLine, Outline};
use crate::mesh::TriMesh;
use crate::numeric::ROUNDING;
use crate::quality::{Expectation, Fault, check};
use crate::run::Run;
use crate::sizing::{DEFAULT_SIZE, SizeRequest};
use crate::spatial::Aabb;

/// The slab is this many sizes thick.
const THICKNESS: f64 = 4.0;

/// Edges of borders are compared with the curves at this many points inside each.
const SAMPLES: usize = 3;

/// The name of the area of a figure in files.
const AREA: &str = "region";

/// What is known of a plane figure. Lengths are in the part's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureReport {
    /// Closed polylines.
    pub contours: usize,
    /// How many of them go around holes.
    pub holes: usize,
    /// Points where two borders, or two curves of one border, meet.
    pub corners: Vec<[f64; 2]>,
    /// The area within the polylines.
    pub area: f64,
    /// Their length.
    pub perimeter: f64,
    /// The largest distance of the polylines from their curves, measured at points.
    pub distance: f64,
    /// Borders by name, with the length of each.
    pub borders: Vec<BorderLength>,
}

/// A border of a figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BorderLength {
    /// Its name.
    pub name: String,
    /// Its length along the polylines.
    pub length: f64,
}

impl fmt::Display for FigureReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "plane figure: {} closed polylines, {} of them holes; {} corners",
            self.contours,
            self.holes,
            self.corners.len()
        )?;
        write!(
            f,
            "area {:.8}, perimeter {:.8}; distance of the polylines from their curves {:.3e}",
            self.area, self.perimeter, self.distance
        )?;
        for b in &self.borders {
            write!(f, "\n  {} length {:.6}", b.name, b.length)?;
        }
        Ok(())
    }
}

/// Refuses a plane figure where solids are asked for.
pub(super) fn no_figure(part: &Part, what: &str) -> Result<()> {
    if part.plane {
        return Err(Error::input(Place::Unknown, format!("the part is a plane figure, and {what} is for solids")));
    }
    Ok(())
}

/// The slab of a figure, and what its top and bottom are called.
struct Slab {
    part: Part,
    top: String,
    bottom: String,
}

impl Slab {
    /// From z = -thickness to 0.
    fn new(part: &Part, thickness: f64) -> Result<Self> {
        let Some(figure) = &part.solid else {
            return Err(Error::input(Place::Unknown, "the part has no plane figure"));
        };
        check_plane(figure)?;
        let (mut top, mut bottom) = ("plane.top".to_string(), "plane.bottom".to_string());
        let build = |top: &str, bottom: &str| {
            let upper = Solid::half_space(DVec3::Z, DVec3::ZERO).name(top);
            let lower = Solid::half_space(-DVec3::Z, -thickness * DVec3::Z).name(bottom);
            Solid::intersection([figure.clone(), upper, lower])
        };
        let domain = part.domain.map(|d| {
            let room = thickness.max(1.0);
            Aabb::new(d.lo.with_z(-2.0 * room), d.hi.with_z(room))
        });
        // The user's names are left alone: where one is the same as these, these change.
        let names = Implicit::new(&build("\u{0}", "\u{0}"), part.rsystem, domain)?;
        while names.faces().iter().any(|f| f.name == top || f.name == bottom) {
            top.push('_');
            bottom.push('_');
        }
        let solid = Some(build(&top, &bottom));
        let part = Part { solid, plane: false, domain, groups: Vec::new(), ..part.clone() };
        Ok(Self { part, top, bottom })
    }

    fn model(&self) -> Result<Implicit> {
        match &self.part.solid {
            Some(solid) => Implicit::new(solid, self.part.rsystem, self.part.domain).map_err(|e| self.part.located(e)),
            None => Err(Error::Failed("the slab of a figure has no solid".into())),
        }
    }
}

/// A figure's box in the plane, and the faces along its borders, by a slab of thickness 1.
fn looked_at(part: &Part) -> Result<(Aabb, Vec<LeafInfo>, Implicit)> {
    let slab = Slab::new(part, 1.0)?;
    let model = slab.model()?;
    let b = model.bounds();
    let faces = model.faces().iter().filter(|f| f.name != slab.top && f.name != slab.bottom);
    let faces = faces.map(|f| LeafInfo { name: f.name.clone(), size: f.size, leaves: Vec::new() }).collect();
    Ok((Aabb::new(b.lo.with_z(0.0), b.hi.with_z(0.0)), faces, model))
}

/// Looks at a plane figure without meshing it.
pub(super) fn figure_info(part: &Part) -> Result<Info> {
    let (b, faces, model) = looked_at(part)?;
    // The slab has two planes and two operations more.
    Ok(Info {
        leaves: model.leaf_count().saturating_sub(2),
        tree_size: model.tree_size().saturating_sub(4),
        rsystem: format!("{:?}", model.rsystem()),
        units: part.units.clone(),
        lo: b.lo.to_array(),
        hi: b.hi.to_array(),
        faces,
        groups: part.groups.iter().map(|g| g.name.clone()).collect(),
    })
}

/// Meshes a plane figure: triangles in z = 0 that face up, and its borders as closed polylines with exact corners.
///
/// Errors: see [`mesh_part`]; options that are for solids.
pub(super) fn mesh_figure(part: &Part, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    if !options.method.is_exact() || part.mesh.sequence.is_some() || options.sequence.is_some() {
        let name = Method::Leaf.name();
        return Err(Error::Usage(format!("a plane figure is meshed by the method {name}: no other has exact corners")));
    }
    if options.thickness.is_some() {
        return Err(Error::Usage("a plane figure has no thickness that edges could follow".into()));
    }
    let (bounds, faces, _) = looked_at(part)?;
    let options = &options.resolved(bounds.diagonal());
    check_groups(part, faces.iter().map(|f| &f.name[..]))?;
    let size = options.size.or(part.mesh.size).unwrap_or(DEFAULT_SIZE).length(bounds.diagonal());
    let slab = Slab::new(part, THICKNESS * size)?;
    let how = MeshOptions { size: Some(SizeRequest::Length(size)), ..options.clone() };
    let solid = mesh_part(&slab.part, &how, &run.for_a_part())?;
    let top = Top::new(&solid, &slab, bounds.diagonal())?;
    let outline = top.outline(part, &solid.mesh)?;
    let report = Report { shortfalls: Vec::new(), ..solid.report.clone() };
    let source = MeshOrigin::Unknown("is one of a plane figure");
    let mut made = Meshed { mesh: top.mesh, seams: Vec::new(), corners: top.corners, outline: None, report, source };
    // What the walls of the slab came to does not matter; what was not found does.
    let walls = solid.report.check.as_ref().map_or(&[][..], |c| &c.certificate.faults);
    let kept = solid.report.shortfalls.iter().filter(|f| !walls.contains(f) && !matches!(f, Fault::FacingAway { .. }));
    made.report.shortfalls = kept.cloned().collect();
    let turned = (0..made.mesh.triangles.len()).filter(|t| !(made.mesh.area_vector(*t).z > 0.0)).count();
    if turned > 0 {
        made.report.shortfalls.push(Fault::FacingAway { triangles: turned, places: Vec::new() });
    }
    let expected = Expectation { open: true, touching: false };
    made.report.judge(check(&made.mesh, expected, None, run)?, 0.0);
    let lost = lost_groups(part, faces.iter().map(|f| &f.name[..]), &outline.names);
    made.report.shortfalls.extend(lost);
    let model = slab.model()?;
    let oracle = ImplicitOracle::with_cells(&model, size, run)?;
    made.report.figure = Some(measured(&made, &outline, &oracle, size));
    // Nodes where one border ends and another begins are ends of curves in files, corner or not.
    let mut corners = made.corners.clone();
    for c in &outline.contours {
        let n = c.nodes.len();
        corners.extend((0..n).filter(|k| c.borders[*k] != c.borders[(k + n - 1) % n]).map(|k| c.nodes[k]));
    }
    corners.sort_unstable();
    corners.dedup();
    made.corners = corners;
    made.outline = Some(outline);
    Ok(made)
}

/// The top of a slab as a mesh of its own.
struct Top {
    mesh: TriMesh,
    /// For each node of the slab the node of the top.
    new: Vec<u32>,
    /// Nodes at corners.
    corners: Vec<u32>,
    /// The label of the top in the slab.
    label: u32,
}

impl Top {
    fn new(solid: &Meshed, slab: &Slab, diagonal: f64) -> Result<Self> {
        let from = &solid.mesh;
        let label = from.faces.iter().position(|f| *f == slab.top).unwrap_or(usize::MAX) as u32;
        let mut mesh = TriMesh { faces: vec![AREA.into()], ..TriMesh::default() };
        let mut new = vec![u32::MAX; from.nodes.len()];
        for t in (0..from.triangles.len()).filter(|t| from.labels[*t] == label) {
            let corners = from.triangles[t].map(|v| {
                let known = &mut new[v as usize];
                if *known == u32::MAX {
                    *known = mesh.nodes.len() as u32;
                    mesh.nodes.push(from.nodes[v as usize]);
                }
                *known
            });
            mesh.triangles.push(corners);
            mesh.labels.push(0);
        }
        if mesh.triangles.is_empty() {
            return Err(Error::Failed("the figure has no triangle: ask for a smaller --size".into()));
        }
        // The top is flat up to this: its nodes are put on z = 0.
        if let Some(p) = mesh.nodes.iter().find(|p| !(p.z.abs() <= ROUNDING * diagonal)) {
            let what = format!("the borders of the figure were not found: its mesh is not flat at ({}, {})", p.x, p.y);
            return Err(Error::Failed(format!("{what}; ask for a smaller --size")));
        }
        mesh.nodes.iter_mut().for_each(|p| p.z = 0.0);
        let corners = solid.corners.iter().map(|v| new[*v as usize]).filter(|v| *v != u32::MAX).collect();
        Ok(Self { mesh, new, corners, label })
    }

    /// The borders: open edges of the top, each with the face of the slab beside it.
    fn outline(&self, part: &Part, solid: &TriMesh) -> Result<Outline> {
        let mut beside: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for (t, label) in solid.triangles.iter().zip(&solid.labels).filter(|(_, l)| **l != self.label) {
            for k in 0..3 {
                let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| self.new[v as usize]);
                if a != u32::MAX && b != u32::MAX {
                    beside.insert([b, a], *label);
                }
            }
        }
        // From each node the edges of the border, in the order of triangles.
        let mut from: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.mesh.nodes.len()];
        for t in &self.mesh.triangles {
            for k in 0..3 {
                let edge = [t[k], t[(k + 1) % 3]];
                if let Some(label) = beside.get(&edge) {
                    from[edge[0] as usize].push((edge[1], *label));
                }
            }
        }
        let mut border_of: Vec<u32> = vec![u32::MAX; solid.faces.len()];
        let mut outline = Outline { units: part.units.clone(), ..Outline::default() };
        for start in 0..from.len() {
            while !from[start].is_empty() {
                let mut contour = ClosedLine::default();
                let mut v = start;
                loop {
                    if from[v].is_empty() {
                        let p = self.mesh.nodes[v];
                        return Err(Error::Failed(format!("a border of the figure ends at ({}, {})", p.x, p.y)));
                    }
                    let (next, label) = from[v].remove(0);
                    contour.nodes.push(v as u32);
                    contour.borders.push(label);
                    v = next as usize;
                    if v == start {
                        break;
                    }
                }
                outline.contours.push(contour);
            }
        }
        // Borders in the order of the part's faces.
        let mut used = vec![false; solid.faces.len()];
        outline.contours.iter().flat_map(|c| &c.borders).for_each(|l| used[*l as usize] = true);
        for (label, name) in solid.faces.iter().enumerate().filter(|(l, _)| used[*l]) {
            border_of[label] = outline.names.len() as u32;
            outline.names.push(name.clone());
            let groups = part.groups.iter().filter(|g| g.patterns.iter().any(|p| glob(p, name)));
            outline.groups.push(groups.map(|g| g.name.clone()).collect());
        }
        outline.contours.iter_mut().flat_map(|c| &mut c.borders).for_each(|l| *l = border_of[*l as usize]);
        Ok(outline)
    }
}

/// Measures the borders. Distances are measured halfway down the slab, where nothing but its walls is near.
fn measured(made: &Meshed, outline: &Outline, oracle: &ImplicitOracle<'_>, size: f64) -> FigureReport {
    let at = |v: u32| made.mesh.nodes[v as usize];
    let mut out = FigureReport {
        contours: outline.contours.len(),
        holes: 0,
        corners: made.corners.iter().map(|v| [at(*v).x, at(*v).y]).collect(),
        area: 0.0,
        perimeter: 0.0,
        distance: 0.0,
        borders: outline.names.iter().map(|name| BorderLength { name: name.clone(), length: 0.0 }).collect(),
    };
    let down = -0.5 * THICKNESS * size * DVec3::Z;
    for c in &outline.contours {
        let origin = at(c.nodes[0]);
        let mut area = 0.0;
        for ([a, b], border) in c.edges() {
            let (p, q) = (at(a), at(b));
            area += 0.5 * (p - origin).cross(q - origin).z;
            let length = p.distance(q);
            out.perimeter += length;
            out.borders[border as usize].length += length;
            for k in 1..=SAMPLES {
                let m = p.lerp(q, k as f64 / (SAMPLES + 1) as f64) + down;
                if let Some(foot) = oracle.project(m, length) {
                    out.distance = out.distance.max(foot.point.distance(m));
                }
            }
        }
        out.holes += usize::from(area < 0.0);
        out.area += area;
    }
    out
}
