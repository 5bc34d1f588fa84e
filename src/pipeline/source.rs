//! What a finished mesh is of: the surface its faces lie on, for who meshes one of them anew and measures again.

use std::fmt;
use std::sync::Arc;

use super::brep::expected;
use super::cells::CELLS;
use super::distance::{Distance, distances, from_edges};
use super::leaf::remesh_options;
use super::mesh::Ready;
use super::options::MeshOptions;
use super::report::Report;
use super::soup_sizes::{self, relaxed, sizing};
use super::volume::{VolumeLoss, between, in_faces};
use super::{SoupOptions, leaf};
use crate::discrete::Discrete;
use crate::error::Result;
use crate::implicit::{Implicit, ImplicitOracle};
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::quality::{Against, Check, Expectation, Fault, check};
use crate::remesh::RemeshOptions;
use crate::run::Run;
use crate::sizing::{LEAST_SHARE, SizingOptions, Wish};

/// Cells that tell which surfaces are near are between these shares of the diagonal, however large the edges are.
const CELL: [f64; 2] = [1.0 / 1024.0, 1.0 / 32.0];

/// What a mesh is of. Copies share it.
#[derive(Clone)]
pub(super) enum MeshOrigin {
    /// One solid of R-functions.
    Functions(Arc<Implicit>),
    /// A boundary representation.
    Faces(Arc<Parametric>),
    /// Triangles in which faces were found.
    Triangles(Arc<Discrete>),
    /// Nothing that could be asked: what the mesh is instead, as an end of the sentence "this mesh ...".
    Unknown(&'static str),
}

impl fmt::Debug for MeshOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Functions(_) => "Functions",
            Self::Faces(_) => "Faces",
            Self::Triangles(_) => "Triangles",
            Self::Unknown(what) => what,
        })
    }
}

/// A mesh measured once more, and what else its report tells of how far it is from the surface.
pub(super) struct Measured {
    pub(super) check: Check,
    pub(super) distance: Option<Distance>,
    pub(super) volume: Option<VolumeLoss>,
}

impl Measured {
    fn of(check: Check) -> Self {
        Self { check, distance: None, volume: None }
    }

    /// Shortfalls that come of these distances.
    pub(super) fn faults(&self) -> Vec<Fault> {
        let far = self.distance.and_then(|d| {
            let limit = d.asked.filter(|_| d.beyond > 0)?;
            Some(Fault::Far { distance: d.to_surface, limit, triangles: Some(d.beyond) })
        });
        let lost = self.volume.filter(|l| l.share > l.asked);
        let lost = lost.map(|l| Fault::VolumeLost { share: l.share, limit: l.asked });
        far.into_iter().chain(lost).collect()
    }
}

/// The cells for a solid of R-functions whose edges have a size.
pub(super) fn cell(solid: &Implicit, size: f64) -> f64 {
    let diagonal = solid.bounds().diagonal();
    size.clamp(CELL[0] * diagonal, CELL[1] * diagonal)
}

/// What the remesher aims at on one face of a solid of R-functions: the wishes of the part's file are passed over.
pub(super) fn of_functions(solid: &Arc<Implicit>, size: f64) -> Result<RemeshOptions> {
    let ready = Ready { model: solid.clone(), asked: solid.clone(), size, finer: Vec::new() };
    let options = remesh_options(&ready, &MeshOptions::default(), CELLS[CELLS.len() - 1] * size)?;
    Ok(RemeshOptions { face_sizes: Vec::new(), ..options })
}

/// The same on one of a boundary representation.
pub(super) fn of_faces(solid: &Parametric, size: f64) -> RemeshOptions {
    let wish = Wish::new(size, solid.bounds().diagonal(), SizingOptions::default());
    let options = RemeshOptions::new(wish.sizing(size / LEAST_SHARE), wish.grading);
    RemeshOptions { narrowest: size / leaf::NARROWEST, ..options }
}

/// The same on one that was found in triangles.
pub(super) fn of_triangles(solid: &Discrete, size: f64) -> RemeshOptions {
    let options = MeshOptions::default();
    let plain = sizing(size, solid.bounds().diagonal(), &options);
    soup_sizes::exact(relaxed(plain, &options, &SoupOptions::default(), solid), &options, solid)
}

impl MeshOrigin {
    /// Another mesh of the same, measured as the one before was. `points` are that one's nodes.
    pub(super) fn measured(
        &self,
        mesh: &TriMesh,
        before: &Report,
        points: &[crate::DVec3],
        run: &Run,
    ) -> Result<Measured> {
        let known = before.check.as_ref();
        let deviates = known.is_some_and(|c| c.deviation.is_some());
        match self {
            Self::Functions(model) if deviates => {
                let ready = Ready { model: model.clone(), asked: model.clone(), size: before.size, finer: Vec::new() };
                let oracle = ImplicitOracle::with_cells(&ready.model, cell(model, before.size), run)?;
                // What was on the surface before must still be near the mesh.
                if known.is_some_and(|c| c.features.is_some()) {
                    return ready.check(mesh, None, &oracle, points, run).map(Measured::of);
                }
                let against = Against { points, ..Against::new(&oracle) };
                check(mesh, Expectation::default(), Some(against), run).map(Measured::of)
            }
            Self::Functions(_) | Self::Unknown(_) => check(mesh, Expectation::default(), None, run).map(Measured::of),
            Self::Triangles(solid) => {
                let m = &solid.mesh;
                let open = m.edges().any(|h| m.opposite(h) == crate::mesh::edit::NONE);
                let against = deviates.then(|| Against::new(&**solid));
                check(mesh, Expectation { open, touching: false }, against, run).map(Measured::of)
            }
            Self::Faces(solid) => {
                let check = check(mesh, expected(&solid.brep, &before.shortfalls), None, run)?;
                let distance = before.distance.map(|d| away(solid, mesh, d, before.size, run)).transpose()?;
                let volume = match before.volume {
                    Some(VolumeLoss { asked, .. }) => {
                        let between = between(solid, mesh, run)?;
                        Some(VolumeLoss { between, share: between / mesh.volume(), asked })
                    }
                    None => None,
                };
                Ok(Measured { check, distance, volume })
            }
        }
    }
}

/// The largest distances of a mesh and a boundary representation from each other, in the place of those of another mesh.
fn away(solid: &Parametric, mesh: &TriMesh, before: Distance, size: f64, run: &Run) -> Result<Distance> {
    let own = in_faces(solid, mesh)?;
    let limit = before.asked.unwrap_or(Wish::new(size, before.diagonal, SizingOptions::default()).tolerance);
    let away = distances(solid, &own, limit, run)?;
    Ok(Distance {
        to_surface: away.iter().copied().fold(0.0, f64::max),
        from_surface: from_edges(solid, &own),
        beyond: away.iter().filter(|d| **d > limit).count(),
        ..before
    })
}
