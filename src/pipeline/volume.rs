//! Meshing until little of a solid's volume is lost between triangles and surface (\[KUZ19\]).

use std::fmt;

use serde::Serialize;

use super::brep::{STRICTER, mesh_tolerant};
use super::distance::distances;
use super::ladder::{Attempts, Change, Ladder, LadderState, MeshAttempt, climb};
use super::mesh::Meshed;
use super::options::MeshOptions;
use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::parametric::step::StepModel;
use crate::quality::Fault;
use crate::run::Run;
use crate::sizing::SizeRequest;

/// How often a finer mesh is made.
const ROUNDS: usize = 6;
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
pub(super) fn between(solid: &Parametric, mesh: &TriMesh, run: &Run) -> Result<f64> {
    let own = in_faces(solid, mesh)?;
    let away = distances(solid, &own, 0.0, run)?;
    Ok(away.iter().enumerate().map(|(t, d)| 0.5 * own.area_vector(t).length() * d).sum())
}

/// The mesh with the faces of the model as labels, which are found by name.
pub(super) fn in_faces(solid: &Parametric, mesh: &TriMesh) -> Result<TriMesh> {
    let face = |name: &String| solid.brep.faces.iter().position(|f| f.name == *name);
    let faces: Vec<Option<usize>> = mesh.faces.iter().map(face).collect();
    let mut own = mesh.clone();
    for l in &mut own.labels {
        let known = faces.get(*l as usize).copied().flatten();
        *l = known.ok_or_else(|| Error::Failed("a triangle is of no face of the model".into()))? as u32;
    }
    Ok(own)
}

/// Ever smaller distances, until little of the volume is lost.
struct VolumeLadder<'a> {
    model: &'a StepModel,
    solid: Parametric,
    options: &'a MeshOptions,
    asked: f64,
    tolerance: Option<SizeRequest>,
    rounds: usize,
}

impl Ladder for VolumeLadder<'_> {
    /// With what is lost; nothing where it is not closed and has no volume.
    type Made = (MeshAttempt, Option<VolumeLoss>);

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Self::Made>> {
        let how = MeshOptions { tolerance: self.tolerance, volume: None, measure: true, ..self.options.clone() };
        let made = mesh_tolerant(self.model.clone(), &how, attempts, run)?;
        let Meshed { mesh, report, .. } = &made.meshed;
        let volume = mesh.volume();
        let is_closed = report.check.as_ref().is_some_and(|c| c.closed);
        if !(is_closed && volume > 0.0) {
            return Ok(Some((made, None)));
        }
        let between = between(&self.solid, mesh, run)?;
        let lost = VolumeLoss { between, share: between / volume, asked: self.asked };
        Ok(Some((made, Some(lost))))
    }

    fn is_better(&self, new: &Self::Made, best: Option<&Self::Made>) -> bool {
        let share = |made: &Self::Made| made.1.map(|l| l.share);
        best.and_then(share).is_none_or(|b| share(new).is_none_or(|s| s < b))
    }

    fn next(&mut self, seen: &LadderState<'_, Self::Made>) -> Option<(Change, &'static str)> {
        self.rounds += 1;
        // What keeps it open is among its shortfalls already.
        let lost = seen.last.1?;
        let farthest = seen.last.0.meshed.report.distance.map_or(0.0, |d| d.to_surface);
        // Of the finest that may be, the next one would lose as much.
        if lost.share <= self.asked || !seen.improved || farthest <= 0.0 || self.rounds == ROUNDS {
            return None;
        }
        let tolerance = farthest * (STRICTER * self.asked / lost.share).max(FINER);
        self.tolerance = Some(SizeRequest::Length(tolerance));
        Some((Change::ShorterEdges, "more volume is lost than asked for"))
    }
}

/// Meshes a solid, finer and finer, until at most a share of its volume lies between mesh and surface. What has no closed mesh has
/// no volume: that is an error.
pub(super) fn mesh_within_volume(
    model: StepModel,
    asked: f64,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<MeshAttempt> {
    if !(asked > 0.0 && asked < 1.0) {
        return Err(Error::Usage(format!("the share of the volume that may be lost is between 0 and 1, not {asked}")));
    }
    if model.brep.uses().contains(&1) {
        let what = "the model has open edges, so it has no volume of which a share could be lost";
        return Err(Error::input(Place::Unknown, what));
    }
    let solid = Parametric::new(model.brep.clone(), run)?;
    let mut ladder = VolumeLadder { model: &model, solid, options, asked, tolerance: options.tolerance, rounds: 0 };
    let best = climb(&mut ladder, attempts, run)?;
    let (mut made, lost) = best.ok_or_else(|| Error::Failed("no mesh was made".into()))?;
    let report = &mut made.meshed.report;
    report.volume = lost;
    if let Some(VolumeLoss { share, .. }) = lost.filter(|l| l.share > asked) {
        report.shortfalls.push(Fault::VolumeLost { share, limit: asked });
    }
    Ok(made)
}
