//! Where things are: boxes, a bounding-volume hierarchy, cells over triangles, lengths that grow from their sources.

mod aabb;
mod bvh;
mod cells;
mod graded;
mod triangle;

pub use aabb::Aabb;
pub use bvh::Bvh;
pub use cells::Cells;
pub use graded::Graded;
pub use triangle::{segment_foot, triangle_distance_squared, triangle_foot};
