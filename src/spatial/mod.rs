//! Where things are: boxes, a bounding-volume hierarchy, nearest points.

mod aabb;

pub use aabb::Aabb;
