//! Triangle meshes: storage, connectivity and edits, curvature, defects.

mod defects;
#[cfg(test)]
mod defects_tests;
mod intersect;
mod trimesh;

pub use defects::{Defects, Topology};
pub use intersect::self_intersections;
pub use trimesh::{Group, TriMesh};
