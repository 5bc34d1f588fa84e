//! The field's samples, three cubes with two holes, meshed by every method and measured alike.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use super::compare::class_counts;
use super::load::parse_part;
use super::mesh::{Ready, Yardstick, mesh_part};
use super::method::Method;
use super::options::MeshOptions;
use crate::error::Result;
use crate::implicit::ImplicitOracle;
use crate::implicit::part::Part;
use crate::mesh::TriMesh;
use crate::quality::Check;
use crate::run::Run;
use crate::sizing::SizeRequest;

/// A part that comes with the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// What rows and pictures call it.
    pub name: &'static str,
    /// The part file, from the root of the crate.
    pub file: &'static str,
    /// What is in the file.
    pub text: &'static str,
    /// From where both of its holes are seen: azimuth and elevation, degrees.
    pub view: [f64; 2],
}

impl Sample {
    /// All samples, in the order of their rows: the cube with two holes of \[LIS14\], with the holes through two of its edges, and turned
    /// so that nothing is parallel to the grid.
    pub const ALL: [Sample; 3] = [
        Sample {
            name: "centered",
            file: "data/cube_with_holes.py",
            text: include_str!("../../data/cube_with_holes.py"),
            view: [38.0, 26.0],
        },
        Sample {
            name: "edge",
            file: "data/cube_with_holes_edge.py",
            text: include_str!("../../data/cube_with_holes_edge.py"),
            view: [-60.0, 32.0],
        },
        Sample {
            name: "rotated",
            file: "data/cube_with_holes_rotated.py",
            text: include_str!("../../data/cube_with_holes_rotated.py"),
            view: [38.0, 26.0],
        },
    ];

    /// The part.
    ///
    /// # Errors
    /// None as the samples are: those of any part file.
    pub fn part(&self) -> Result<Part> {
        parse_part(Path::new(self.file), self.text, &[])
    }
}

/// The mesh of one sample by one method.
#[derive(Debug, Clone, Serialize)]
pub struct SampleRow {
    /// The sample's name.
    pub sample: &'static str,
    /// The method's name.
    pub method: &'static str,
    /// The mesh, measured.
    pub check: Check,
    /// How many of its nodes are regular, on creases, corners, by curvature alone; `None` where the mesh is no manifold.
    pub classes: Option<[usize; 3]>,
    /// How long the mesh took, without what is measured here; `None` unless [`MeshOptions::timed`] asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// The mesh itself.
    #[serde(skip)]
    pub mesh: TriMesh,
}

/// Every sample by every method: the rows of a sample stand together, in the order of [`Method::ALL`].
#[derive(Debug, Clone, Serialize)]
pub struct SampleComparison {
    /// Cell size, in the unit of the samples, whose cubes have sides of 2.
    pub size: f64,
    /// One row for each sample and method.
    pub rows: Vec<SampleRow>,
}

/// Meshes every sample by every method, as [`mesh_part`] does, and measures what comes of it.
///
/// All have the same cell size: a share is one of the first sample's diagonal. Sharp edges and corners are found within a twentieth of it.
/// `method` and `measure` of the options are passed over; the
/// sequence takes the place of that of [`Method::Operators`].
///
/// # Errors
/// Those of [`mesh_part`] and [`Error::Cancelled`](crate::Error::Cancelled).
pub fn compare_samples(options: &MeshOptions, run: &Run) -> Result<SampleComparison> {
    options.comparable()?;
    let size = Ready::new(&Sample::ALL[0].part()?, options.size)?.size;
    let mut rows = Vec::new();
    for sample in Sample::ALL {
        let part = sample.part()?;
        let ready = Ready::new(&part, Some(SizeRequest::Length(size)))?;
        let extracted = ready.extract(size, options, run)?;
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let yardstick = Yardstick::new(&ready, &oracle, &extracted.mesh.nodes, run)?;
        for method in Method::ALL {
            let how = MeshOptions {
                size: Some(SizeRequest::Length(size)),
                method,
                sequence: options.sequence.clone().filter(|_| method == Method::Operators),
                measure: false,
                ..options.clone()
            };
            let began = Instant::now();
            let mesh = mesh_part(&part, &how, run)?.mesh;
            let seconds = options.timed.then(|| began.elapsed().as_secs_f64());
            let check = yardstick.check(&mesh, run)?;
            let classes = class_counts(&mesh, run)?;
            rows.push(SampleRow { sample: sample.name, method: method.name(), check, classes, seconds, mesh });
        }
    }
    Ok(SampleComparison { size, rows })
}

impl fmt::Display for SampleComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<9} {:<10} {:>9} {:>6} {:>5} {:>6} {:>6} {:>8} {:>7} {:>6} {:>9} {:>14} {:>8}",
            "sample",
            "method",
            "tri",
            "closed",
            "SI",
            "recall",
            "prec",
            "corners",
            "min",
            "p05",
            "eps_n",
            "crease, corner",
            "seconds"
        )?;
        for r in &self.rows {
            let c = &r.check;
            let sound = if c.closed && c.manifold && c.oriented { "yes" } else { "NO" };
            let corners = |t: &crate::quality::FeatureRecovery| format!("{} / {}", t.corners_found, t.corners_true);
            let features = c.features.as_ref();
            let known = features.filter(|t| t.known);
            let shown = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.3}"));
            writeln!(
                f,
                "{:<9} {:<10} {:>9} {:>6} {:>5} {:>6} {:>6} {:>8} {:>7.3} {:>6.2} {:>9} {:>14} {:>8}",
                r.sample,
                r.method,
                c.triangles,
                sound,
                c.self_intersections,
                shown(known.map(|t| t.recall)),
                shown(known.map(|t| t.precision)),
                features.map_or("-".into(), corners),
                c.quality.min_angle,
                c.quality.p05_angle,
                c.deviation.map_or("-".into(), |d| format!("{:.2e}", d.normal)),
                r.classes.map_or("-".into(), |[_, crease, corner]| format!("{crease}, {corner:>4}")),
                r.seconds.map_or("-".into(), |s| format!("{s:.2}")),
            )?;
        }
        write!(
            f,
            "cell size {:.6}; angles in degrees; eps_n: normal deviation; SI: triangles that intersect others; crease, corner: nodes by their classes\n{}",
            self.size,
            Sample::ALL.map(|s| format!("{}: {}", s.name, s.file)).join("; ")
        )
    }
}
