//! Meshes with exact edges and corners, for surfaces known as [pieces](InPieces): cut the extracted mesh along the borders
//! of the pieces, put every node where its pieces meet, and remesh each patch between its borders.

mod angles;
mod apexes;
mod climb;
mod concurrent;
mod curves;
mod fans;
mod field;
mod flat;
mod flips;
mod frozen;
mod gaps;
mod grid;
mod join;
mod joints;
mod judge;
mod moves;
mod near;
mod open;
mod pack;
mod patches;
mod patchwork;
mod pieced;
mod pointed;
mod policy;
mod remesher;
mod scatter;
mod stages;
mod strips;
mod thaw;
mod tips;

pub use field::asked_triangles;
pub use judge::Judge;
pub use open::{Laid, remesh_open};
pub(crate) use patches::BAND;
pub use patchwork::{Patchwork, PiecePatch, PieceSet, RemeshTarget};
pub use pieced::{InPieces, patch_open_pieces, patch_pieces};
pub use policy::{Filling, Incoming, Policy};
pub use thaw::Off;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::sizing::{Region, Sizing};
use crate::spatial::{Aabb, Graded};
use remesher::Remesher;

/// Sees the mesh after a stage, with the stage's name.
pub type Observer<'a> = dyn FnMut(&str, &TriMesh) + Send + 'a;

/// What [`remesh_patchwork`] aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshOptions {
    /// Wanted edge lengths.
    pub sizing: Sizing,
    /// Wanted edge lengths on single faces, by index of the face.
    pub face_sizes: Vec<Option<f64>>,
    /// Wanted edge lengths in parts of space; with borders that are spaced already there is no need for them.
    pub regions: Vec<Region>,
    /// Wanted edge lengths at places, and how they grow from there.
    pub finer: Graded,
    /// How fast edge lengths may grow per length.
    pub grading: f64,
    /// Gaps between borders and short borders are followed down to this edge length.
    pub narrowest: f64,
    /// No edge is longer than this many times the solid's thickness beneath it, where the [policy](Policy::narrow) looks for narrow places.
    pub thickness: Option<f64>,
    /// Where only few triangles come out farther from the surface than this they are divided.
    pub distance: Option<f64>,
}

impl RemeshOptions {
    /// The same wish everywhere.
    pub fn new(sizing: Sizing, grading: f64) -> Self {
        let narrowest = sizing.least;
        Self {
            sizing,
            face_sizes: Vec::new(),
            regions: Vec::new(),
            finer: Graded::new(Vec::new(), grading),
            grading,
            narrowest,
            thickness: None,
            distance: None,
        }
    }
}

/// What [`remesh_patchwork`] met.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RemeshReport {
    /// Triangles that intersect others.
    pub self_intersections: usize,
    /// Triangles that face away from their piece.
    pub inverted: usize,
    /// The boxes around these triangles.
    pub faults: Vec<Aabb>,
    /// The boxes around triangles with an angle below about 20 degrees of which no node lies on a border; of raw ones only.
    pub slim: Vec<Aabb>,
    /// Middles of edges on borders that the border's curve does not come near: it goes another way, as where cells joined what
    /// lies apart in a neck.
    pub astray: Vec<DVec3>,
    /// How often surroundings of intersecting triangles were refined.
    pub repairs: usize,
    /// Nodes that are not on their surfaces, as triangles would cross if they were.
    pub off: Vec<Off>,
}

/// A mesh with exact borders, and what its topology is beyond the faces' names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RemeshedMesh {
    /// The mesh.
    pub mesh: TriMesh,
    /// Edges of the mesh at which two pieces of one face meet, as pairs of nodes.
    pub seams: Vec<[u32; 2]>,
    /// Nodes where borders end or meet, and apexes.
    pub corners: Vec<u32>,
    /// The piece of each triangle; `u32::MAX` for those on none.
    pub pieces: Vec<u32>,
    /// What was met.
    pub report: RemeshReport,
}

impl RemeshReport {
    /// Whether every border is exact and every triangle sound.
    pub fn is_clean(&self) -> bool {
        self.self_intersections == 0 && self.inverted == 0
    }
}

/// Remeshes a patchwork to the sizes asked for, as its [policy](Policy) says; `observer` sees the mesh after each stage.
///
/// *Guarantees*: a closed, oriented manifold stays one; every node lies on all pieces it belongs to, to rounding; labels are faces.
/// Borders that are open stay as they are.
/// *Does not guarantee*: that no two triangles intersect: the report tells.
/// *Errors*: [`Error::Usage`] for senseless options, [`Error::Cancelled`].
pub fn remesh_patchwork(
    mut work: Patchwork,
    target: RemeshTarget<'_>,
    options: &RemeshOptions,
    run: &Run,
    observer: Option<&mut Observer<'_>>,
) -> Result<RemeshedMesh> {
    check_options(options)?;
    let Sizing { size, least, .. } = options.sizing;
    if let Some(share) = options.thickness.filter(|_| work.policy.narrow) {
        work.sizes = gaps::through_solid(&work, share, size, least.min(size), run)?;
    }
    let r = Remesher::new(work, target.surface, options, run)?;
    Ok(run.install(|| stages::remesh(target.names, r, observer))?.0)
}

fn check_options(options: &RemeshOptions) -> Result<()> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if ![options.sizing.size, options.grading, options.thickness.unwrap_or(1.0)].into_iter().all(positive) {
        return Err(Error::Usage("size, grading and thickness must be positive".into()));
    }
    Ok(())
}
