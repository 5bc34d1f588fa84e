//! Where things are: boxes, a bounding-volume hierarchy.

mod aabb;
mod bvh;
mod triangle;

pub use aabb::Aabb;
pub use bvh::Bvh;
pub use triangle::{triangle_distance_squared, triangle_foot};
