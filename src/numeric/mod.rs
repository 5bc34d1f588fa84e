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
pub(crate) const COS_60: f64 = 0.5;
/// The cosine of 26 degrees: directions nearer to each other go much the same way.
pub(crate) const COS_26: f64 = 0.9;
/// The cosine of 20 degrees: what turns by less goes on.
pub(crate) const COS_20: f64 = 0.94;
/// The cosine of 30 degrees, and the sine of 60.
pub(crate) const COS_30: f64 = 0.866_025_403_784_438_6;
/// What rounding leaves of numbers that were computed in many steps, as a share of their size: a million times the last places of
/// doubles, and far less than anything is made to. With a much smaller number what should be one would be two, with a
/// much larger one details would be lost.
pub(crate) const ROUNDING: f64 = 1e-9;
/// What rounding leaves after a few operations, as a share of the operands: thousands of the last places of doubles.
pub(crate) const FEW_ROUNDINGS: f64 = 1e-12;
/// What a chain of some ten operations leaves of them: hundreds of the last places.
pub(crate) const LAST_PLACES: f64 = 1e-13;
/// What files that give seven digits, and single precision, leave of lengths, as a share of the size.
pub(crate) const SEVEN_DIGITS: f64 = 1e-6;
/// What files that give eight digits leave of them.
pub(crate) const EIGHT_DIGITS: f64 = 1e-7;
/// What is looked for from several places is found several times: results nearer to each other than this share of the cell, the reach
/// or the range it was looked for in are one. Searches settle far more closely; two of them that near could not be kept apart by nodes.
pub(crate) const FOUND_TWICE: f64 = 1e-3;

pub use dual::Dual;
pub use interval::Interval;
pub use roots::Bracket;
pub(crate) use sets::Sets;
