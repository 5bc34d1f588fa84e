//! Meshes with exact edges and corners, for surfaces known as [pieces](Pieces): cut the extracted mesh along the borders
//! of the pieces, put every node where its pieces meet, and remesh each patch between its borders.

mod cut;
mod patchwork;
mod remesh;

pub use cut::{CutReport, cut_pieces};
pub use patchwork::{Patch, Patchwork, PieceSet};

use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::run::Run;
use remesh::Remesher;

/// What [`remesh_pieces`] aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactOptions {
    /// Wanted edge length.
    pub size: f64,
    /// Spacing of the nodes of the mesh that is cut.
    pub cell: f64,
}

/// Cuts `mesh` along the borders of pieces and remeshes it.
pub fn remesh_pieces(
    mesh: &TriMesh,
    surface: &dyn Pieces,
    options: &ExactOptions,
    run: &Run,
) -> Result<(TriMesh, CutReport)> {
    let (work, report) = cut_pieces(mesh, surface, options.cell, run)?;
    let mut remesher = Remesher::new(work, surface, options.size, run);
    let start = std::time::Instant::now();
    remesher.run(&mut |name, r| {
        let (n, worst) = r.counts();
        eprintln!("{name:20} {n:7} {worst:8.4} {:.3}", start.elapsed().as_secs_f64());
    })?;
    let mut out = remesher.work.mesh.to_mesh();
    let patches = &remesher.work.patches;
    out.labels = (0..out.triangles.len())
        .map(|t| {
            let piece = patches[out.labels[t] as usize].piece;
            surface.face_at(piece, out.centroid(t)).unwrap_or(0)
        })
        .collect();
    out.faces = mesh.faces.clone();
    out.groups = mesh.groups.clone();
    Ok((out, report))
}
