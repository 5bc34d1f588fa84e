//! Every stage of every method on one part, measured alike.

use std::fmt;

use glam::DVec3;
use serde::Serialize;

use super::cells::{CellLadder, Start};
use super::groups::{check_groups, finish_names};
use super::ladder::Attempts;
use super::leaf::by_leaf;
use super::mesh::{Ready, Yardstick};
use super::method::Method;
use super::options::MeshOptions;
use super::report::Report;
use crate::error::Result;
use crate::implicit::part::Part;
use crate::implicit::{ImplicitOracle, features};
use crate::mesh::{EditMesh, TriMesh};
use crate::optimize::{Classes, Kind, Options, classify_by_curvature, improve_with};
use crate::quality::{Check, SHARP_TRUE};
use crate::render::View;
use crate::run::Run;

/// The smallest angle between two faces with a crease between them, degrees: what the operators take.
const CREASE: f64 = 20.0;

/// The class of every node by curvature, as pictures take it: 0 regular, 1 on a crease, 2 a corner.
///
/// *Errors*: [`Error::Input`](crate::Error::Input) for a mesh that is no oriented manifold, and [`Error::Cancelled`](crate::Error::Cancelled).
pub fn node_classes(mesh: &TriMesh, run: &Run) -> Result<Vec<u8>> {
    let classes: Classes = classify_by_curvature(&EditMesh::new(mesh)?, CREASE, run)?;
    let class = |v| match classes.kind(v) {
        Kind::Regular => 0,
        Kind::Crease => 1,
        Kind::Corner => 2,
    };
    Ok((0..mesh.nodes.len() as u32).map(class).collect())
}

/// How many nodes are regular, on creases, corners; `None` where the mesh is no oriented manifold.
pub(super) fn class_counts(mesh: &TriMesh, run: &Run) -> Result<Option<[usize; 3]>> {
    match EditMesh::new(mesh) {
        Ok(edit) => Ok(Some(classify_by_curvature(&edit, CREASE, run)?.counts())),
        Err(_) => Ok(None),
    }
}

/// One stage of one method.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// `mc`, `paper` (what \[LIS14\] prints), `operators` (its operators in a better order), `cut` or `leaf` (the default; all its attempts); of a
    /// soup `input`, `poisson`, `frontal` or `triangles`.
    pub method: &'static str,
    /// The stage just finished.
    pub stage: String,
    /// The mesh after it, measured.
    pub check: Check,
    /// How many of its nodes are regular, on creases, corners, by curvature alone; `None` where the mesh is no manifold.
    pub classes: Option<[usize; 3]>,
    /// The mesh itself.
    #[serde(skip)]
    pub mesh: TriMesh,
}

/// The rows of a comparison, in order.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Cell size, in the part's unit.
    pub size: f64,
    /// A place that shows what the stages do: the sharp corner, else the point of a sharp edge, that is foremost in the
    /// default view; `None` on a part without sharp edges.
    #[serde(skip)]
    pub focus: Option<DVec3>,
    /// One row a stage.
    pub rows: Vec<Row>,
}

/// Runs every method on a part and measures the mesh after each stage.
///
/// Sharp edges and corners are found within a twentieth of the cell size, the same for every stage.
///
/// # Errors
/// Those of [`mesh_part`](super::mesh_part), and [`Error::Usage`](crate::Error::Usage) for options that methods are not compared with:
/// `volume` and `without`. So it is of the other comparisons.
pub fn compare(part: &Part, options: &MeshOptions, run: &Run) -> Result<Comparison> {
    options.comparable()?;
    let ready = Ready::new(part, options.size)?;
    let options = &options.resolved(ready.model.bounds().diagonal());
    check_groups(part, ready.model.faces().iter().map(|f| &f.name[..]))?;
    let extracted = ready.extract(ready.size, options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut stages: Vec<(&'static str, String, TriMesh)> = vec![("mc", "MC33".into(), extracted.mesh.clone())];
    let default = ready.operator_options(options);
    for method in Method::ALL {
        let own = options.sequence.clone().filter(|_| method == Method::Operators);
        let Some(sequence) = own.or_else(|| method.sequence()) else { continue };
        let mut mesh = extracted.mesh.clone();
        improve_with(&mut mesh, &oracle, &Options { sequence, ..default.clone() }, run, &mut |stage, mesh| {
            stages.push((method.name(), stage.to_string(), mesh.clone()));
        })?;
    }
    let mut watch = |stage: &str, mesh: &TriMesh| stages.push(("leaf", stage.to_string(), mesh.clone()));
    let cells = CellLadder::new(&ready, options, Start::default()).observed(Some(&mut watch));
    by_leaf(cells, &mut Attempts::new(false), run)?;
    let yardstick = Yardstick::new(&ready, &oracle, &extracted.mesh.nodes, run)?;
    let mut rows = Vec::with_capacity(stages.len());
    for (method, stage, mut mesh) in stages {
        let mut unused = Report::new(options.method, ready.size, None);
        finish_names(part, &mut mesh, &mut unused);
        let check = yardstick.check(&mesh, run)?;
        let classes = class_counts(&mesh, run)?;
        rows.push(Row { method, stage, check, classes, mesh });
    }
    let truth = features(&ready.model, 0.5 * ready.size, run)?;
    // Edges with a smaller angle between their faces are no place to look at.
    let edges = truth.samples.iter().filter(|s| s.angle > SHARP_TRUE).map(|s| s.point);
    let places = if truth.corners.is_empty() { edges.collect() } else { truth.corners.clone() };
    let towards = View::default().towards;
    let focus = places.into_iter().max_by(|a, b| a.dot(towards).total_cmp(&b.dot(towards)));
    Ok(Comparison { size: ready.size, focus, rows })
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<10} {:<22} {:>8} {:>6} {:>6} {:>5} {:>7} {:>6} {:>6} {:>9} {:>9} {:>6} {:>6} {:>9} {:>14}",
            "method",
            "stage",
            "tri",
            "closed",
            "euler",
            "SI",
            "min",
            "p05",
            "2r/R",
            "rms/h",
            "eps_n",
            "recall",
            "prec",
            "corners",
            "crease, corner"
        )?;
        for r in &self.rows {
            let c = &r.check;
            let q = &c.quality;
            write!(
                f,
                "{:<10} {:<22} {:>8} {:>6} {:>6} {:>5} {:>7.3} {:>6.2} {:>6.3}",
                r.method,
                r.stage,
                c.triangles,
                if c.closed && c.manifold && c.oriented { "yes" } else { "NO" },
                c.euler,
                c.self_intersections,
                q.min_angle,
                q.p05_angle,
                q.mean_radius_ratio
            )?;
            if let Some(d) = &c.deviation {
                write!(f, " {:>9.2e} {:>9.2e}", d.rms / self.size, d.normal)?;
            }
            if let Some(t) = &c.features {
                let share = |x: f64| if t.known { format!("{x:.3}") } else { "-".into() };
                let (recall, precision) = (share(t.recall), share(t.precision));
                write!(f, " {recall:>6} {precision:>6} {:>3} / {:<3}", t.corners_found, t.corners_true)?;
            }
            if let Some([_, crease, corner]) = r.classes {
                write!(f, " {crease:>8}, {corner:>4}")?;
            }
            writeln!(f)?;
        }
        write!(
            f,
            "lengths as shares of the cell size {:.6}; angles in degrees; SI: triangles that intersect others; crease, corner: nodes by their classes",
            self.size
        )
    }
}
