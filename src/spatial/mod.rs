//! Where things are: boxes, a bounding-volume hierarchy, cells over triangles, a tree of points, lengths that grow from their sources.

mod aabb;
mod bvh;
mod cells;
mod graded;
mod nodes;
mod triangle;

pub use aabb::{Aabb, LARGEST};
pub use bvh::{Bvh, ViewCone};
pub use cells::TriangleCells;
pub use graded::Graded;
pub use nodes::{NearNode, NodeTree};
pub use triangle::{segment_foot, triangle_distance_squared, triangle_foot};
