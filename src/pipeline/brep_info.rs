//! What is known of a boundary representation before it is meshed: counts, faces with their surfaces, whether it is sewn.

use std::fmt;

use serde::Serialize;

use super::brep_oracle::FaceFinder;
use super::built::build;
use super::report::{Info, info};
use crate::error::Result;
use crate::implicit::part::Part;
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::parametric::step::StepModel;
use crate::quality::{self, Against, Check, Expectation, check as measured};
use crate::run::Run;
use crate::spatial::Aabb;

/// A box, as two corners.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoxInfo {
    /// Smallest coordinates.
    pub lo: [f64; 3],
    /// Largest coordinates.
    pub hi: [f64; 3],
    /// Lengths along x, y and z.
    pub size: [f64; 3],
}

impl From<Aabb> for BoxInfo {
    fn from(b: Aabb) -> Self {
        Self { lo: b.lo.to_array(), hi: b.hi.to_array(), size: b.size().to_array() }
    }
}

/// One face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceReport {
    /// Its name.
    pub name: String,
    /// The name of its body; none where it is part of no body.
    pub body: Option<String>,
    /// The record or the number it comes from.
    pub source: u64,
    /// The kind of its surface.
    pub surface: &'static str,
    /// Its area; none where it could not be meshed.
    pub area: Option<f64>,
    /// A box around it.
    pub bounds: BoxInfo,
    /// Parameters it covers, u and v.
    pub parameters: [[f64; 2]; 2],
    /// Parameters its surface is defined for; null where these are infinite.
    pub domain: [[f64; 2]; 2],
}

/// One body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodyReport {
    /// Its name.
    pub name: String,
    /// How many faces it has.
    pub faces: usize,
    /// Whether it is said to be a solid.
    pub solid: bool,
    /// Whether every edge of it has a face on both sides.
    pub sewn: bool,
    /// Its volume, where it is sewn and could be meshed.
    pub volume: Option<f64>,
    /// Its center of mass, where its volume is known.
    pub center: Option<[f64; 3]>,
}

/// What is known of a boundary representation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BrepInfo {
    /// The unit of length.
    pub units: Option<String>,
    /// Points nearer to each other than this are one, where the file says so.
    pub tolerance: Option<f64>,
    /// How many vertices.
    pub vertices: usize,
    /// How many edges.
    pub edges: usize,
    /// Edges with a face on one side only.
    pub open_edges: usize,
    /// Whether there is none.
    pub sewn: bool,
    /// Nodes of the first mesh areas and volumes are measured on.
    pub mesh_nodes: usize,
    /// Its triangles.
    pub mesh_triangles: usize,
    /// A box around everything.
    pub bounds: BoxInfo,
    /// The area of all faces that could be meshed.
    pub area: f64,
    /// The bodies.
    pub bodies: Vec<BodyReport>,
    /// The faces.
    pub faces: Vec<FaceReport>,
    /// What was not understood, or had to be put right.
    pub notes: Vec<String>,
}

/// Looks at a boundary representation; areas and volumes to five or six digits. Errors: cancellation.
pub fn brep_info(model: StepModel, units: Option<&str>, run: &Run) -> Result<BrepInfo> {
    let StepModel { brep, notes, tolerance } = model;
    let solid = Parametric::new(brep, run)?;
    let m = solid.measure(run)?;
    let brep = &solid.brep;
    let uses = brep.uses();
    let measured = m.volumes.iter().zip(&m.centers);
    let bodies = brep.bodies.iter().zip(measured).map(|(b, (v, center))| {
        let faces = b.faces.iter().map(|f| &brep.faces[*f as usize]);
        let sewn = faces.flat_map(|f| &f.loops).flatten().all(|c| uses[c.edge as usize] > 1);
        let whole = b.faces.iter().all(|f| m.faces[*f as usize].area.is_some());
        BodyReport {
            name: b.name.clone(),
            faces: b.faces.len(),
            solid: b.solid,
            sewn,
            volume: (sewn && whole).then_some(*v),
            center: center.filter(|_| sewn && whole).map(|c| c.to_array()),
        }
    });
    let mut body_of: Vec<Option<&str>> = vec![None; brep.faces.len()];
    for (b, f) in brep.bodies.iter().flat_map(|b| b.faces.iter().map(move |f| (b, f))) {
        body_of[*f as usize] = Some(&b.name);
    }
    let faces = brep.faces.iter().zip(&m.faces).zip(body_of).map(|((f, m), body)| FaceReport {
        name: f.name.clone(),
        body: body.map(str::to_string),
        source: f.source,
        surface: f.surface.kind(),
        area: m.area,
        bounds: m.bounds.into(),
        parameters: m.parameters,
        domain: f.surface.domain(),
    });
    let open = uses.iter().filter(|n| **n == 1).count();
    Ok(BrepInfo {
        units: units.map(str::to_string),
        tolerance,
        vertices: brep.vertices.len(),
        edges: brep.edges.len(),
        open_edges: open,
        sewn: open == 0,
        mesh_nodes: m.counts[0],
        mesh_triangles: m.counts[1],
        bounds: m.bounds.into(),
        area: m.area(),
        bodies: bodies.collect(),
        faces: faces.collect(),
        notes: notes.iter().map(ToString::to_string).collect(),
    })
}

/// What is known of a part before meshing.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum PartInfo {
    /// Of R-functions, or a plane figure.
    Functions(Info),
    /// Built from edges.
    Built(BrepInfo),
    /// Both.
    Both {
        /// The solid of R-functions.
        #[serde(flatten)]
        functions: Info,
        /// What is built from edges beside it.
        built: BrepInfo,
    },
}

/// Looks at all of a part without meshing it for good: what [`info`] and [`brep_info`] tell.
///
/// # Errors
/// Those of [`info`], and of building solids from edges; cancelled.
pub fn part_info(part: &Part, run: &Run) -> Result<PartInfo> {
    let Some(brep) = build(part, run)? else { return Ok(PartInfo::Functions(info(part, run)?)) };
    let built = brep_info(brep.into(), part.units.as_deref(), run)?;
    if part.solid.is_none() {
        return Ok(PartInfo::Built(built));
    }
    Ok(PartInfo::Both { functions: info(part, run)?, built })
}

/// A number to six digits.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) {
        let digits = (5 - x.abs().max(1e-5).log10().floor() as i32).clamp(0, 9) as usize;
        let s = format!("{x:.digits$}");
        let s = if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.') } else { &s };
        if s == "-0" { "0".into() } else { s.to_string() }
    } else {
        format!("{x:.5e}")
    }
}

fn range([a, b]: [f64; 2]) -> String {
    format!("{} .. {}", short(a), short(b))
}

impl fmt::Display for BoxInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = |p: &[f64; 3]| p.map(short).join(", ");
        write!(f, "({}) to ({})", p(&self.lo), p(&self.hi))
    }
}

impl fmt::Display for BrepInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.units.as_deref().unwrap_or("units");
        let solids = self.bodies.iter().filter(|b| b.solid).count();
        writeln!(
            f,
            "boundary representation: {} bodies ({solids} solids), {} faces, {} edges, {} vertices",
            self.bodies.len(),
            self.faces.len(),
            self.edges,
            self.vertices
        )?;
        match self.open_edges {
            0 => writeln!(f, "sewn: every edge has a face on both sides")?,
            n => writeln!(f, "not sewn: {n} edges have a face on one side only")?,
        }
        if let Some(t) = self.tolerance {
            writeln!(f, "tolerance {} {unit}", short(t))?;
        }
        writeln!(f, "box {} {unit}", self.bounds)?;
        writeln!(f, "size {} {unit}", self.bounds.size.map(short).join(" x "))?;
        writeln!(f, "measured on {} nodes, {} triangles", self.mesh_nodes, self.mesh_triangles)?;
        writeln!(f, "area {} {unit}^2", short(self.area))?;
        for b in &self.bodies {
            let kind = if b.solid { "solid" } else { "sheet" };
            write!(f, "body {}: {kind} of {} faces", b.name, b.faces)?;
            match b.volume {
                Some(v) => write!(f, ", volume {} {unit}^3", short(v))?,
                None if b.sewn => write!(f, ", volume not known")?,
                None => write!(f, ", open")?,
            }
            match b.center {
                Some(c) => writeln!(f, ", center of mass ({})", c.map(short).join(", "))?,
                None => writeln!(f)?,
            }
        }
        for face in &self.faces {
            write!(f, "face {} (#{}): {}", face.name, face.source, face.surface)?;
            match &face.body {
                Some(b) => writeln!(f, ", of body {b}")?,
                None => writeln!(f)?,
            }
            match face.area {
                Some(a) => writeln!(f, "  area {} {unit}^2", short(a))?,
                None => writeln!(f, "  area not known: the face could not be meshed")?,
            }
            writeln!(f, "  box {}", face.bounds)?;
            let [u, v] = face.parameters;
            writeln!(f, "  face    u {}, v {}", range(u), range(v))?;
            let [u, v] = face.domain;
            writeln!(f, "  surface u {}, v {}", range(u), range(v))?;
        }
        for n in &self.notes {
            writeln!(f, "note: {n}")?;
        }
        Ok(())
    }
}

/// Measures a mesh against a boundary representation in the same unit. Errors: cancellation.
pub fn against_step(mesh: &TriMesh, model: StepModel, run: &Run) -> Result<Check> {
    let solid = Parametric::new(model.brep, run)?;
    let oracle = FaceFinder::new(&solid, run)?;
    measured(mesh, Expectation::default(), Some(Against { points: oracle.points(), ..Against::new(&oracle) }), run)
}

/// The distance of each node of a mesh to a boundary representation in the same unit, as
/// [`node_distances`](quality::node_distances) tells it. Errors: cancellation.
pub fn distances_to_step(mesh: &TriMesh, model: StepModel, run: &Run) -> Result<Vec<f64>> {
    let solid = Parametric::new(model.brep, run)?;
    quality::node_distances(mesh, &FaceFinder::new(&solid, run)?, run)
}
