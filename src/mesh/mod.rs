//! Triangle meshes: storage, connectivity and edits, curvature, defects.

pub mod curvature;
pub mod edit;
mod trimesh;

pub use edit::EditMesh;
pub use trimesh::{Group, TriMesh};
