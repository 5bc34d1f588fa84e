//! Triangle meshes: storage, connectivity and edits, curvature, defects.

mod trimesh;

pub use trimesh::{Group, TriMesh};
