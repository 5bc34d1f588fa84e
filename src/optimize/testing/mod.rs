//! Test parts with exact answers, a marching-cubes extraction of them, and measures against the truth. Tests only.

mod march;
mod measure;
mod parts;

pub use march::march;
pub use measure::measure;
pub use parts::TestPart;
