//! Part in, mesh out.

use std::path::Path;
use std::str::FromStr;

use super::report::Report;
use crate::error::{Error, Place, Result};
use crate::implicit::part::{Part, SizeRequest, glob, parse};
use crate::implicit::{ExtractOptions, Extracted, Implicit, ImplicitOracle, extract, features, thin_places};
use crate::mesh::{Group, TriMesh};
use crate::optimize::{Options, improve};
use crate::quality::{Against, Check, check};
use crate::run::Run;

/// The size used when neither the caller nor the part asks for one: about 29 cells along the side of a cube.
const DEFAULT_SIZE: SizeRequest = SizeRequest::Share(0.02);

/// How a mesh is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Marching cubes with the topology of MC33, nothing else.
    MarchingCubes,
    /// Marching cubes, then the operators of \[LIS14\] in the order [`optimize`](crate::optimize) explains.
    #[default]
    Operators,
}

impl Method {
    /// All methods, in the order they are compared in.
    pub const ALL: [Method; 2] = [Method::MarchingCubes, Method::Operators];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::MarchingCubes => "mc",
            Method::Operators => "operators",
        }
    }
}

impl FromStr for Method {
    type Err = Error;
    fn from_str(s: &str) -> Result<Self> {
        let known = Method::ALL.map(Method::name).join(", ");
        Method::ALL
            .into_iter()
            .find(|m| m.name() == s)
            .ok_or_else(|| Error::Usage(format!("unknown method {s}; known: {known}")))
    }
}

/// What [`mesh_part`] is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Cell size, before the part's own wish and the default of 2 % of the diagonal.
    pub size: Option<SizeRequest>,
    /// How.
    pub method: Method,
    /// See [`ExtractOptions::root_tolerance`].
    pub root_tolerance: f64,
    /// See [`ExtractOptions::memory`].
    pub memory: u64,
    /// Densify where fewer than this many nodes fall on a radius of curvature. With neither this nor `chord`, the method's
    /// own default holds.
    pub nodes_per_radius: Option<f64>,
    /// Densify where the mesh is farther than this from the surface, in the part's unit.
    pub chord: Option<f64>,
}

impl Default for MeshOptions {
    fn default() -> Self {
        let extract = ExtractOptions::new(1.0);
        Self {
            size: None,
            method: Method::default(),
            root_tolerance: extract.root_tolerance,
            memory: extract.memory,
            nodes_per_radius: None,
            chord: None,
        }
    }
}

/// A finished mesh.
#[derive(Debug, Clone)]
pub struct Meshed {
    /// The mesh; only faces that have triangles are listed.
    pub mesh: TriMesh,
    /// What is known about it.
    pub report: Report,
}

/// Reads a part file. Errors name the file, line and column.
pub fn load_part(path: &Path, overrides: &[(String, f64)]) -> Result<Part> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        Error::input(Place::Byte(e.utf8_error().valid_up_to() as u64), "a part file must be UTF-8 text").in_file(path)
    })?;
    parse(&text, overrides).map_err(|e| e.in_file(path))
}

/// A part made ready for meshing at one size.
pub(super) struct Ready {
    pub(super) model: Implicit,
    pub(super) size: f64,
}

impl Ready {
    pub(super) fn new(part: &Part, size: Option<SizeRequest>) -> Result<Self> {
        let model = Implicit::new(&part.solid, part.rsystem, part.domain)?;
        let size = match size.or(part.mesh.size).unwrap_or(DEFAULT_SIZE) {
            SizeRequest::Length(h) => h,
            SizeRequest::Share(s) => s * model.bounds().diagonal(),
        };
        Ok(Ready { model, size })
    }

    pub(super) fn extract(&self, options: &MeshOptions, run: &Run) -> Result<Extracted> {
        let e = ExtractOptions { size: self.size, root_tolerance: options.root_tolerance, memory: options.memory };
        let extracted = extract(&self.model, &e, run)?;
        if extracted.mesh.triangles.is_empty() {
            let (place, what) = match thin_places(&self.model, &extracted, self.size, run)?.first() {
                Some(t) => (Place::Point(t.at), format!("the part is thinner than the cells of size {:.6}", self.size)),
                None => (Place::Unknown, "the solid is empty: nothing is inside anywhere".to_string()),
            };
            return Err(Error::input(place, what).with_help("ask for a smaller --size"));
        }
        Ok(extracted)
    }

    pub(super) fn operator_options(&self, options: &MeshOptions) -> Options {
        let default = Options::new(self.size);
        if options.nodes_per_radius.is_none() && options.chord.is_none() {
            return default;
        }
        Options { nodes_per_radius: options.nodes_per_radius, chord: options.chord, least_size: None, ..default }
    }

    /// Measures a mesh against the part, with features sampled finely enough for its edges.
    pub(super) fn check(&self, mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> Result<Check> {
        let features = features(&self.model, 0.5 * self.size, run)?;
        check(mesh, Some(Against { oracle, features: Some(&features) }), run)
    }
}

/// Meshes a part.
///
/// Guarantees: a closed, oriented 2-manifold; nodes on the boundary; the same bytes for any number of threads. What falls
/// short of what was asked (a wall thinner than a cell, a self-intersection) is in the report's `shortfalls`.
///
/// Errors: see [`extract`]; a part that is empty or thinner than the cells everywhere.
pub fn mesh_part(part: &Part, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    let ready = Ready::new(part, options.size)?;
    let mut extracted = ready.extract(options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let thin = thin_places(&ready.model, &extracted, ready.size, run)?;
    let mut mesh = std::mem::take(&mut extracted.mesh);
    if options.method == Method::Operators {
        improve(&mut mesh, &oracle, &ready.operator_options(options), run)?;
    }
    run.progress("check", 0.0);
    let mut report = Report::new(options.method, ready.size, part.units.clone());
    finish_names(part, &mut mesh, &mut report);
    let check = ready.check(&mesh, &oracle, run)?;
    for t in &thin {
        report.shortfalls.push(t.to_string());
    }
    report.judge(check);
    Ok(Meshed { mesh, report })
}

/// Measures a mesh file's mesh against a part; cells for the oracle follow the mesh's edges.
pub fn against(mesh: &TriMesh, part: &Part, run: &Run) -> Result<Check> {
    let h = mesh.mean_edge_length();
    let ready = Ready::new(part, (h > 0.0).then_some(SizeRequest::Length(h)))?;
    // a mesh may be far coarser or finer than is good for cells
    let diagonal = ready.model.bounds().diagonal();
    let ready = Ready { size: ready.size.clamp(diagonal / 1024.0, diagonal / 32.0), ..ready };
    let oracle = ImplicitOracle::with_cells(&ready.model, ready.size, run)?;
    ready.check(mesh, &oracle, run)
}

/// Drops faces without triangles, makes the part's groups, and warns of names nothing answers to.
pub(super) fn finish_names(part: &Part, mesh: &mut TriMesh, report: &mut Report) {
    let mut used = vec![false; mesh.faces.len()];
    mesh.labels.iter().for_each(|l| used[*l as usize] = true);
    let all = std::mem::take(&mut mesh.faces);
    let mut new = vec![u32::MAX; all.len()];
    for (i, name) in all.iter().enumerate().filter(|(i, _)| used[*i]) {
        new[i] = mesh.faces.len() as u32;
        mesh.faces.push(name.clone());
    }
    mesh.labels.iter_mut().for_each(|l| *l = new[*l as usize]);
    for f in mesh.faces.iter().filter(|f| f.starts_with("domain.")) {
        report.warnings.push(format!("the solid reaches the domain's wall and is capped there: face {f}"));
    }
    for g in &part.groups {
        for p in g.patterns.iter().filter(|p| !all.iter().any(|n| glob(p, n))) {
            report.warnings.push(format!("{}group {:?}: no face is called {p:?}", g.place, g.name));
        }
        let faces: Vec<u32> = (0..mesh.faces.len() as u32)
            .filter(|i| g.patterns.iter().any(|p| glob(p, &mesh.faces[*i as usize])))
            .collect();
        mesh.groups.push(Group { name: g.name.clone(), faces });
    }
}
