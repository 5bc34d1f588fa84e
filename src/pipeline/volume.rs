//! Meshing until little of a solid's volume is lost between triangles and surface (\[KUZ19\]).

use std::fmt;

use serde::Serialize;

use super::brep::mesh_tolerant;
use super::distance::distances;
use super::mesh::{MeshOptions, Meshed};
use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::parametric::step::StepModel;
use crate::quality::Fault;
use crate::run::Run;

/// How often a finer mesh is made.
const ROUNDS: usize = 6;
/// Volumes are as distances are; so much of what would just do is asked for.
const STRICTER: f64 = 0.85;
/// Distances shrink by at most this factor each time.
const FINER: f64 = 0.02;

/// The volume between a mesh and the solid it is of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VolumeLoss {
    /// It is at most so large, inside and outside of the solid counted alike: area times distance, added up over triangles.
    pub between: f64,
    /// The same as a share of the mesh's volume.
    pub share: f64,
    /// The share that was asked for.
    pub asked: f64,
}

impl fmt::Display for VolumeLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "volume between mesh and surface at most {:.4e} ({:.2e} of the volume)", self.between, self.share)
    }
}

/// The volume between triangles and the faces they are of, at most: each triangle's area times its largest distance.
fn between(solid: &Parametric, mesh: &TriMesh, run: &Run) -> Result<f64> {
    let face = |name: &String| solid.brep.faces.iter().position(|f| f.name == *name);
    let faces: Vec<Option<usize>> = mesh.faces.iter().map(face).collect();
    let mut own = mesh.clone();
    for l in &mut own.labels {
        let known = faces.get(*l as usize).copied().flatten();
        *l = known.ok_or_else(|| Error::Failed("a triangle is of no face of the model".into()))? as u32;
    }
    let away = distances(solid, &own, 0.0, run)?;
    Ok(away.iter().enumerate().map(|(t, d)| 0.5 * own.area_vector(t).length() * d).sum())
}

/// Meshes a solid, finer and finer, until at most a share of its volume lies between mesh and surface. What has no closed mesh has
/// no volume: that is an error.
pub(super) fn mesh_within_volume(model: StepModel, asked: f64, options: &MeshOptions, run: &Run) -> Result<Meshed> {
    if !(asked > 0.0 && asked < 1.0) {
        return Err(Error::Usage(format!("the share of the volume that may be lost is between 0 and 1, not {asked}")));
    }
    if model.brep.uses().contains(&1) {
        let what = "the model has open edges, so it has no volume of which a share could be lost";
        return Err(Error::input(Place::Unknown, what));
    }
    let solid = Parametric::new(model.brep.clone(), run)?;
    let mut tolerance = options.tolerance;
    let mut best: Option<(Meshed, VolumeLoss)> = None;
    for _ in 0..ROUNDS {
        let how = MeshOptions { tolerance, volume: None, measure: true, ..options.clone() };
        let made = mesh_tolerant(model.clone(), &how, run)?;
        let volume = made.mesh.volume();
        let is_closed = made.report.check.as_ref().is_some_and(|c| c.closed);
        if !(is_closed && volume > 0.0) {
            // What keeps it open is among its shortfalls already.
            return Ok(made);
        }
        let between = between(&solid, &made.mesh, run)?;
        let share = between / volume;
        let farthest = made.report.distance.map_or(0.0, |d| d.to_surface);
        let lost = VolumeLoss { between, share, asked };
        // Of the finest that may be, the next one would lose as much.
        let is_less = best.as_ref().is_none_or(|b| share < b.1.share);
        if is_less {
            best = Some((made, lost));
        }
        if share <= asked || !is_less || farthest <= 0.0 {
            break;
        }
        tolerance = Some(farthest * (STRICTER * asked / share).max(FINER));
    }
    let (mut made, lost) = best.ok_or_else(|| Error::Failed("no mesh was made".into()))?;
    made.report.volume = Some(lost);
    if lost.share > asked {
        made.report.shortfalls.push(Fault::VolumeLost { share: lost.share, limit: asked });
    }
    Ok(made)
}
