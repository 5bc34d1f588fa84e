//! How long edges shall be, for all gates: what is asked for, with one table of defaults, what bends make of that, and places with lengths of
//! their own. How lengths grow from there is told by [`Graded`](crate::spatial::Graded).

mod curvature;
mod region;
mod request;
mod wish;

pub use curvature::Sizing;
pub use region::{Region, RegionShape};
pub use request::SizeRequest;
pub(crate) use wish::{CHORD, DEFAULT_SIZE, GRADING, LEAST_SHARE, SizingOptions, Wish, own_tolerance};

/// An edge is too long above this multiple of the wanted size and too short below that one: halves of a too long edge
/// are not too short, and two merged edges not too long (Botsch and Kobbelt 2004).
pub const LONG: f64 = 4.0 / 3.0;
/// See [`LONG`].
pub const SHORT: f64 = 4.0 / 5.0;
/// Edges shorter than this share of the wanted length are what marching cubes leaves where the surface passes close to a corner of the
/// grid, and what cutting leaves; they are removed before anything that looks at normals.
pub const TINY: f64 = 0.3;
