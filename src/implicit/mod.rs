//! The implicit gate: solids written as R-function trees.
//!
//! A [`Solid`] is a tree of primitives, formulas and set operations. Lowering makes signed leaves and one tape of it;
//! the octree prunes the tape cell by cell; marching cubes with the topology of MC33 meshes the surface.

pub mod expr;
mod field;
pub mod mc33;
mod rfunction;
pub mod solid;

pub use expr::Expr;
pub use field::Field;
pub use rfunction::RSystem;
pub use solid::{Placement, Primitive, Solid, SolidNode, Tpms};
