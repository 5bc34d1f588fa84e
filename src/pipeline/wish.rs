//! How long edges shall be, whatever comes in: the one table of defaults.

use super::mesh::MeshOptions;
use crate::implicit::part::SizeRequest;
use crate::optimize::Sizing;

/// Without a wish for it, edges are this long: some fifty to a diagonal show a part's shape, in a second or so.
pub(super) const DEFAULT_SIZE: SizeRequest = SizeRequest::Share(0.02);
/// Without a wish for it, neighboring edges on curved parts turn by this many degrees at most: 18 nodes to a circle.
pub(super) const ANGLE: f64 = 20.0;
/// Without a wish for it, no triangle is to be farther from the surface than this share of the size. Edges as long as the size do that on
/// surfaces whose radius is four times as large.
pub(super) const TOLERANCE: f64 = 0.07;
/// Edges are made so long that they stay within this share of the tolerance: the middle of a triangle is a third farther away than its
/// sides, and some edges come out a third longer than wanted, which makes 16/9 of the distance.
pub(super) const CHORD: f64 = 0.45;
/// Without a wish for it, lengths grow by this share of a length: at a third the 5th percentile of angles is a degree lower.
pub(super) const GRADING: f64 = 0.2;
/// Without a wish for it, curvature makes edges at most this many times shorter than the size.
pub(super) const LEAST_SHARE: f64 = 4.0;

/// What is wanted of a mesh, with defaults where nothing was said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wish {
    /// Length of edges on flat parts.
    pub(super) size: f64,
    /// Radians by which neighboring edges turn at most.
    pub(super) angle: f64,
    /// How far triangles may be from the surface. Infinite where an angle alone was asked for: it is what counts then.
    pub(super) tolerance: f64,
    /// How fast lengths grow per length.
    pub(super) grading: f64,
}

impl Wish {
    pub(super) fn new(size: f64, options: &MeshOptions) -> Self {
        let own = if options.angle.is_some() { f64::INFINITY } else { TOLERANCE * size };
        Self {
            size,
            angle: options.angle.unwrap_or(ANGLE).to_radians(),
            tolerance: options.tolerance.unwrap_or(own),
            grading: options.grading.unwrap_or(GRADING),
        }
    }

    /// How far edges may be from the surface.
    pub(super) fn chord(&self) -> f64 {
        CHORD * self.tolerance
    }

    /// What curvature asks for, down to `least`.
    pub(super) fn sizing(&self, least: f64) -> Sizing {
        let chord = Some(self.chord()).filter(|c| c.is_finite());
        Sizing { size: self.size, nodes_per_radius: Some(1.0 / self.angle), chord, least }
    }
}
