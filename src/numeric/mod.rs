//! Numbers: intervals, dual numbers, root bracketing.

mod dual;
mod interval;
pub mod predicates;
mod roots;

pub use dual::Dual;
pub use interval::Interval;
pub use roots::Bracket;
