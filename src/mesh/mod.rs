//! Triangle meshes: storage, connectivity and edits, curvature, defects, values carried; prisms over the triangles of a face, hexahedra of pairs of them.

mod carry;
mod colors;
pub mod curvature;
mod defects;
#[cfg(test)]
mod defects_tests;
pub mod edit;
mod hexahedra;
mod intersect;
mod path;
#[cfg(test)]
mod path_tests;
pub(crate) mod portion;
mod prisms;
pub(crate) mod sides;
mod trimesh;
pub mod view;

pub use carry::{Carried, carry};
pub(crate) use colors::face_colors;
pub use defects::{Defects, Topology};
pub use edit::EditMesh;
pub use hexahedra::Hexahedra;
pub(crate) use hexahedra::side_of;
pub use intersect::{intersecting_groups, intersecting_triangles, intersections_among, self_intersections};
pub(crate) use intersect::{is_flat, triangles_cross};
pub use path::{MeshPath, shortest_path};
pub use prisms::{OuterSide, Prisms};
pub use trimesh::{Group, TriMesh};
pub use view::{CellRun, MeshView};
