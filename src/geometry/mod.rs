//! The contract between a stage and the surface it works on: oracles, size fields, feature samples. No gate is known here.

mod features;
mod oracle;
mod pieces;
mod strips;
mod touch;

pub use features::{FeatureSample, Features};
pub(crate) use oracle::NEWTON_STEPS;
pub use oracle::{Foot, SurfaceOracle};
pub use pieces::Pieces;
pub(crate) use strips::{ALIKE, ALONG, FIRST, INTO, Like, Pair, Strips, WIDEST};
pub(crate) use touch::common_normal;
