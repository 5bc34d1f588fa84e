//! How long edges shall be, whatever comes in: the one table of defaults.

use super::{SizeRequest, Sizing};

/// Without a wish for it, edges are this long: about 29 along the side of a cube.
pub(crate) const DEFAULT_SIZE: SizeRequest = SizeRequest::Share(0.02);
/// Without a wish for it, neighboring edges on curved parts turn by this many degrees at most: 18 nodes to a circle.
const ANGLE: f64 = 20.0;
/// Without a wish for it, no triangle is to be farther from the surface than this share of the size. Edges as long as the size do that on
/// surfaces whose radius is eight times as large. Curves of two surfaces, which may bend a quarter more than was wanted before they are
/// divided again, then stay within 5 % of the size, by which the recovery of features is measured: with 0.055 crossing rods of
/// `tests/leaf.rs` keep 82 % of theirs.
const TOLERANCE: f64 = 0.035;
/// Edges are made so long that they stay within this share of the tolerance: the middle of a triangle is a third farther away than its
/// sides, and some edges come out a third longer than wanted, which makes 16/9 of the distance.
pub(crate) const CHORD: f64 = 0.45;
/// Without a wish for it, lengths grow by this share of a length: with a third, the eight solids of `tests/gates.rs` have 1 % fewer
/// triangles and 5th percentiles of angles 0.2 degrees lower.
pub(crate) const GRADING: f64 = 0.2;
/// Without a wish for it, curvature makes edges at most this many times shorter than the size.
pub(crate) const LEAST_SHARE: f64 = 4.0;

/// The default tolerance is at least this share of the diagonal: what is small beside the part need not be finer than that. A thousand solids at a
/// 450th of the diagonal get 1.3 million triangles in place of 0.8 million without.
const FINEST: f64 = 1.0 / 5400.0;

/// The tolerance without a wish for it.
pub(crate) fn own_tolerance(size: f64, diagonal: f64) -> f64 {
    (TOLERANCE * size).max(FINEST * diagonal)
}

/// What a user may ask for beside the size; what is not said follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SizingOptions {
    /// Degrees by which neighboring edges turn at most.
    pub(crate) angle: Option<f64>,
    /// How far triangles may be from the surface.
    pub(crate) tolerance: Option<f64>,
    /// How fast lengths grow per length.
    pub(crate) grading: Option<f64>,
}

/// What is wanted of a mesh, with defaults where nothing was said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wish {
    /// Length of edges on flat parts.
    pub(crate) size: f64,
    /// Radians by which neighboring edges turn at most.
    pub(crate) angle: f64,
    /// How far triangles may be from the surface. Infinite where an angle alone was asked for: it is what counts then.
    pub(crate) tolerance: f64,
    /// How fast lengths grow per length.
    pub(crate) grading: f64,
}

impl Wish {
    /// For a part whose box has a diagonal.
    pub(crate) fn new(size: f64, diagonal: f64, asked: SizingOptions) -> Self {
        let own = if asked.angle.is_some() { f64::INFINITY } else { own_tolerance(size, diagonal) };
        Self {
            size,
            angle: asked.angle.unwrap_or(ANGLE).to_radians(),
            tolerance: asked.tolerance.unwrap_or(own),
            grading: asked.grading.unwrap_or(GRADING),
        }
    }

    /// How far edges may be from the surface.
    pub(crate) fn chord(&self) -> f64 {
        CHORD * self.tolerance
    }

    /// What curvature asks for, down to `least`.
    pub(crate) fn sizing(&self, least: f64) -> Sizing {
        let chord = Some(self.chord()).filter(|c| c.is_finite());
        Sizing { size: self.size, nodes_per_radius: Some(1.0 / self.angle), chord, least }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_table_of_the_manual_is_this_one() {
        let SizeRequest::Share(size) = DEFAULT_SIZE else { panic!("the default is a share of the diagonal") };
        let rows = [
            format!("| size | {} % of the diagonal |", 100.0 * size),
            format!("| angle | {ANGLE}° |"),
            format!(
                "| distance from the surface | {TOLERANCE} of the size, at least diagonal / {:.0}; none with `--angle` alone |",
                1.0 / FINEST
            ),
            format!("| distance of edges | {CHORD} of that of triangles |"),
            format!("| growth per length | {GRADING} |"),
            format!("| shortest for bends | size / {LEAST_SHARE} |"),
        ];
        assert!(include_str!("../../docs/sizes.md").contains(&rows.join("\n")), "{rows:#?}");
    }

    #[test]
    fn an_angle_alone_is_all_that_counts() {
        let by_angle = SizingOptions { angle: Some(45.0), ..SizingOptions::default() };
        let [a, b] = [SizingOptions::default(), by_angle].map(|asked| Wish::new(1.0, 50.0, asked).sizing(0.01));
        // Eight sizes to the radius: edges as long as that are as far away as they may be.
        assert!((a.at(0.126) - 1.0).abs() < 0.01 && a.at(0.25) < 0.75, "{} {}", a.at(0.126), a.at(0.25));
        assert_eq!(b.chord, None);
        assert_abs_diff_eq!(b.at(2.0), 0.5 * 45f64.to_radians(), epsilon = 1e-12);
    }
}
