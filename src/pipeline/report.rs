//! What a run tells about its result, and what is known of a part before it is meshed.

use std::fmt;

use serde::Serialize;

use super::cells::at;
use super::distance::Distance;
use super::figure::{FigureReport, figure_info};
use super::history::{Attempt, Stage};
use super::ladder::Budget;
use super::method::Method;
use super::sampled::lowered;
use super::volume::VolumeLoss;
use crate::error::{Error, Place, Result};
use crate::implicit::FaceInfo;
use crate::implicit::part::Part;
use crate::parametric::Parametric;
use crate::parametric::mesh::FallbackStep;
use crate::quality::{Check, Fault};
use crate::run::Run;

/// The version of the report as JSON, described in `docs/report.md`. It grows when a field goes or changes its meaning.
pub const SCHEMA: u32 = 1;

/// The report of one mesh.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The version of this layout as JSON: [`SCHEMA`].
    pub schema: u32,
    /// The method's name.
    pub method: &'static str,
    /// The operators that ran after marching cubes, as text that can be run again; of methods with a sequence only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<String>,
    /// Cell size, in the part's unit.
    pub size: f64,
    /// The part's unit, where it names one.
    pub units: Option<String>,
    /// Things worth knowing.
    pub warnings: Vec<String>,
    /// Where the mesh falls short of what was asked; a command exits with 1 if there are any.
    pub shortfalls: Vec<Fault>,
    /// What was tried, in the order of time.
    pub attempts: Vec<Attempt>,
    /// What they may cost together, and did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
    /// The stages of the mesh that was kept.
    pub stages: Vec<Stage>,
    /// Faces of boundary representations that did not come out the plain way, and how they did.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<FaceStep>,
    /// Distances between the mesh and the faces of a boundary representation, where they were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<Distance>,
    /// The volume between the mesh and the solid, where a share of it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeLoss>,
    /// The borders of a plane figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<FigureReport>,
    /// The measured mesh.
    pub check: Option<Check>,
}

/// How a face came by its mesh where the plain way (its parameter domain, then the remesher) did not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rung {
    /// A region of it narrower than wanted was cut off, or all of it was.
    Trimmed,
    /// Edges around it were divided more finely than asked.
    FinerEdges,
    /// Triangulated on a plane through its border, its nodes put on the surface.
    Plane,
    /// Left as it was first triangulated.
    FirstTriangulation,
    /// It has no mesh.
    None,
}

impl From<FallbackStep> for Rung {
    fn from(s: FallbackStep) -> Self {
        match s {
            FallbackStep::FinerEdges => Rung::FinerEdges,
            FallbackStep::Plane => Rung::Plane,
        }
    }
}

/// One face and a rung of the ladder it took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceStep {
    /// The face.
    pub face: String,
    /// The number of the record that made it, in a file.
    pub source: u64,
    /// The rung.
    pub rung: Rung,
    /// Why the one before it did not do.
    pub why: String,
}

impl FaceStep {
    pub(super) fn of(solid: &Parametric, face: u32, rung: Rung, why: String) -> Self {
        let f = &solid.brep.faces[face as usize];
        Self { face: f.name.clone(), source: f.source, rung, why }
    }
}

impl Report {
    pub(super) fn new(method: Method, size: f64, units: Option<String>) -> Self {
        Self::of(method.name(), size, units)
    }

    /// The report of a mesh made in a way of its own.
    pub(super) fn of(method: &'static str, size: f64, units: Option<String>) -> Self {
        Self {
            schema: SCHEMA,
            method,
            sequence: None,
            size,
            units,
            warnings: Vec::new(),
            shortfalls: Vec::new(),
            attempts: Vec::new(),
            budget: None,
            stages: Vec::new(),
            ladder: Vec::new(),
            distance: None,
            volume: None,
            figure: None,
            check: None,
        }
    }

    /// Records what was measured, and as shortfalls what no mesh should have. Triangles that face away no farther from the surface than a
    /// tolerance lie where it bends or comes back within that: they are told, and no more.
    pub(super) fn judge(&mut self, check: Check, tolerance: f64) {
        self.shortfalls.extend(check.certificate.faults.iter().cloned());
        // Where marching cubes cuts a sharp edge off, triangles face either way.
        let deviation = check.deviation.filter(|d| d.inverted > 0 && self.method != Method::MarchingCubes.name());
        if let Some(d) = deviation {
            if d.inverted_distance <= tolerance {
                let away = d.inverted_distance;
                let what = "triangles face away from the surface where it bends or comes back within the tolerance";
                let place = d.inverted_at.map_or(String::new(), |p| format!(" near {}", at(p.into())));
                self.warnings.push(format!("{} {what}, at most {away:.2e} from it{place}", d.inverted));
            } else {
                let places = d.inverted_at.into_iter().collect();
                self.shortfalls.push(Fault::FacingAway { triangles: d.inverted, places });
            }
        }
        self.check = Some(check);
    }
}

/// One face a part may have.
#[derive(Debug, Clone, Serialize)]
pub struct LeafInfo {
    /// The face's name.
    pub name: String,
    /// The mesh size asked for on it.
    pub size: Option<f64>,
    /// The numbers of its leaves, as [`eval_points`](super::eval_points) has them; none for those of a plane figure.
    pub leaves: Vec<u32>,
}

/// What is known of a part before meshing.
#[derive(Debug, Clone, Serialize)]
pub struct Info {
    /// How many different surfaces the tree is made of.
    pub leaves: usize,
    /// Leaves and R-operations.
    pub tree_size: usize,
    /// The R-system.
    pub rsystem: String,
    /// The part's unit.
    pub units: Option<String>,
    /// Smallest coordinates of a box around the part.
    pub lo: [f64; 3],
    /// Largest coordinates.
    pub hi: [f64; 3],
    /// The faces' names.
    pub faces: Vec<LeafInfo>,
    /// Names of groups.
    pub groups: Vec<String>,
}

/// Looks at a part's solid, or its plane figure, without meshing it; meshes and CAD models in it count as one leaf each. Errors: there is
/// none; what lowering refuses; what is wrong with these.
pub fn info(part: &Part, run: &Run) -> Result<Info> {
    if part.plane {
        return figure_info(part);
    }
    let Some(solid) = &part.solid else {
        return Err(Error::input(Place::Unknown, "the part has no solid of R-functions"));
    };
    let model = lowered(part, solid, part.rsystem, run)?;
    let b = model.bounds();
    let face = |(f, leaves): (&FaceInfo, Vec<u32>)| LeafInfo { name: f.name.clone(), size: f.size, leaves };
    Ok(Info {
        leaves: model.leaf_count(),
        tree_size: model.tree_size(),
        rsystem: format!("{:?}", model.rsystem()),
        units: part.units.clone(),
        lo: b.lo.to_array(),
        hi: b.hi.to_array(),
        faces: model.faces().iter().zip(model.leaves_by_face()).map(face).collect(),
        groups: part.groups.iter().map(|g| g.name.clone()).collect(),
    })
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.units.as_deref().unwrap_or("units");
        writeln!(f, "{} surfaces in a tree of {}, R-system {}", self.leaves, self.tree_size, self.rsystem)?;
        writeln!(f, "box from {:?} to {:?} {unit}", self.lo, self.hi)?;
        writeln!(f, "{} faces:", self.faces.len())?;
        for face in &self.faces {
            write!(f, "  {}", face.name)?;
            face.size.iter().try_for_each(|h| write!(f, "  size {h}"))?;
            match &face.leaves[..] {
                [] => {}
                [one] => write!(f, "  leaf {one}")?,
                [first, .., last] if (last - first) as usize + 1 == face.leaves.len() => {
                    write!(f, "  leaves {first} to {last}")?;
                }
                all => write!(f, "  leaves {}", all.iter().map(u32::to_string).collect::<Vec<_>>().join(" "))?,
            }
            writeln!(f)?;
        }
        write!(f, "groups: {}", if self.groups.is_empty() { "none".into() } else { self.groups.join(", ") })
    }
}
