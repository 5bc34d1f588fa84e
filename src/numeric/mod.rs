//! Numbers: intervals, dual numbers, root bracketing, least squares of planes, clustering, elementary functions of many numbers.

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

pub use dual::Dual;
pub use interval::Interval;
pub use roots::Bracket;
pub(crate) use sets::Sets;
