//! Contours in a plane: where they meet, their medial axis, and trimming of narrow parts.
//!
//! A contour is a closed polygon, its last point followed by the first. Several contours bound a region together, the points
//! with an odd number of contours around them, whatever way the contours run.

mod axis;
mod crossings;
#[cfg(test)]
mod tests;
mod trim;

pub use axis::{Axis, medial_axis};
pub use crossings::{SegmentMeeting, crossings};
pub use trim::{Merge, Refusal, Spot, Trimmed, trim};
