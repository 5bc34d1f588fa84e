//! Where things are: boxes, a bounding-volume hierarchy.

mod aabb;
mod bvh;

pub use aabb::Aabb;
pub use bvh::Bvh;
