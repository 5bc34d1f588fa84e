//! Boundary representation: the topology of a part, and the mesh fragments that belong to its entities.
//!
//! A gate fills a [`Model`] (vertices, edges, loops, faces, shells, solids, names, groups) and one fragment per vertex,
//! edge and face ([`Fragments`]). From there on nobody asks where the surface came from. A gate that already has a
//! triangle mesh with its borders calls [`from_mesh()`].
//!
//! Topology knows no coordinates: [`Model`] is generic over what describes a vertex, an edge and a face in space, and
//! may carry nothing at all.
//!
//! *References.* \[LAZ\] V. V. Lazarev, "An efficient algorithm for merging node-matched fragments of surface grids" (in
//! Russian), sections 1 and 3.

mod cells;
mod check;
mod fragment;
mod from_mesh;
mod matching;
mod pool;
mod topology;

#[cfg(test)]
pub(crate) mod tests;

pub use cells::{BorderNodes, Cells, Corners};
pub use check::{Item, Violation};
pub(crate) use fragment::{BLOCK, BLOCK_CORNERS, PLACE_SHIFT};
pub use fragment::{EdgeFragment, FaceFragment, FaceView};
pub use from_mesh::{Cut, from_mesh};
pub use matching::Mismatch;
pub use pool::Fragments;
pub use topology::{Coedge, Edge, Face, Loop, Model, Shell, Solid, Vertex};
