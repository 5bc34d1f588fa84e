//! Measuring a mesh: shape of its triangles, distance and angle from the true surface, recovery of sharp edges.

mod certificate;
mod check;
mod deviation;
mod fault;
mod features;
mod metrics;
mod portions;
#[cfg(test)]
mod portions_tests;
#[cfg(test)]
mod tests;

pub use certificate::{Certificate, Expectation, SMALLEST_ANGLE};
pub use check::{Against, Check, GroupSummary, check, check_tested};
pub use deviation::{Deviation, deviation, facing_away, node_distances};
pub use fault::Fault;
pub use features::{FeatureRecovery, SHARP_MESH, SHARP_TRUE, recovery};
pub use metrics::{Quality, TriangleMeasures, quality, shape};
pub(crate) use portions::Sums;
