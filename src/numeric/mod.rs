//! Numbers: intervals, dual numbers, root bracketing, least squares of planes, clustering, elementary functions of many numbers, bytes as text.

pub mod base64;
mod dual;
mod interval;
pub mod kmeans;
pub mod predicates;
mod roots;
mod sets;
pub mod svd;
pub mod vector;

/// The number of nothing: where lists hold numbers of nodes, triangles, cells or names, there is none.
pub const NONE: u32 = u32::MAX;
/// The cosine of 60 degrees, half of the way to square: up to there two directions go the same way more than they go aside.
pub const COS_60: f64 = 0.5;
/// The cosine of 30 degrees, and the sine of 60.
pub const COS_30: f64 = 0.866_025_403_784_438_6;

pub use dual::Dual;
pub use interval::Interval;
pub use roots::Bracket;
pub(crate) use sets::Sets;
