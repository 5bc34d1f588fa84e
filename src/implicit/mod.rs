//! The implicit gate: solids written as R-function trees.
//!
//! A [`Solid`] is a tree of primitives, formulas and set operations. Lowering makes signed leaves and one tape of it;
//! the octree prunes the tape cell by cell; marching cubes with the topology of MC33 meshes the surface.

mod alike;
mod apex;
mod batch;
mod blend;
mod branches;
mod close;
mod complex;
mod contact;
mod creased;
mod deciding;
pub mod expr;
mod extract;
mod features;
mod field;
mod fillet;
mod forms;
mod formula;
mod grid;
mod joints;
mod jumps;
mod leaf;
mod levelset;
mod lost;
mod lower;
pub mod mc33;
mod model;
mod newton;
mod octree;
mod oracle;
pub mod part;
mod pieces;
mod plane;
mod polygon;
mod rfunction;
mod roots;
mod roperation;
mod sample;
mod shapes;
mod slopes;
pub mod solid;
mod splinters;
mod split;
mod steps;
mod tape;

#[cfg(test)]
mod tests;
mod thin;
mod written;

pub(crate) use close::CloseOracle;
pub use complex::Unproved;
pub(crate) use complex::{Arranged, CellGrid, EndKey, GridBlock, arranged, cells_along, origin};
pub use creased::creased;
pub use expr::Expr;
pub use extract::{ExtractOptions, Extracted, extract};
pub use features::features;
pub(crate) use features::features_within;
pub use field::Field;
pub use grid::GridField;
pub use levelset::write_3mf;
pub(crate) use lost::{SurfacePoint, surface_points};
pub use lower::FaceInfo;
pub use model::Implicit;
pub(crate) use octree::undecided_in;
pub use oracle::ImplicitOracle;
pub use plane::check_plane;
pub use rfunction::RSystem;
pub use sample::{Samples, Sampling, evaluate};
pub use solid::{Boundary, Foreign, Placement, Primitive, Solid, SolidNode, Tpms};
pub(crate) use splinters::drop_splinters;
pub use thin::{ThinPlace, Wall, thin_places, thin_walls};
pub use written::write_vm;
