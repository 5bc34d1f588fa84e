//! Where things are: boxes, a bounding-volume hierarchy, lengths that grow from their sources.

mod aabb;
mod bvh;
mod graded;
mod triangle;

pub use aabb::Aabb;
pub use bvh::Bvh;
pub use graded::Graded;
pub use triangle::{triangle_distance_squared, triangle_foot};
