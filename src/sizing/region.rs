//! Places where edges shall be shorter than elsewhere.

use glam::DVec3;

use crate::spatial::Aabb;

/// A part of space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegionShape {
    /// A box along the axes.
    Box(Aabb),
    /// A ball.
    Sphere {
        /// Its center.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
}

/// A part of space and the edge length wanted in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Where.
    pub shape: RegionShape,
    /// The edge length.
    pub size: f64,
}

impl Region {
    /// The greatest edge length at a point: that of the region inside it, growing by `grading` per length outside.
    pub fn at(&self, p: DVec3, grading: f64) -> f64 {
        let away = match self.shape {
            RegionShape::Box(b) => b.distance_squared(p).sqrt(),
            RegionShape::Sphere { center, radius } => (p.distance(center) - radius).max(0.0),
        };
        self.size + grading * away
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn lengths_grow_from_the_border_of_a_region() {
        let ball = Region { shape: RegionShape::Sphere { center: DVec3::X, radius: 1.0 }, size: 0.1 };
        assert_eq!([0.0, 1.5, 4.0].map(|x| ball.at(DVec3::X * x, 0.3)), [0.1, 0.1, 0.1 + 0.3 * 2.0]);
        let b = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let cube = Region { shape: RegionShape::Box(b), size: 0.2 };
        assert_eq!(cube.at(DVec3::splat(0.5), 0.3), 0.2);
        assert_abs_diff_eq!(cube.at(DVec3::new(4.0, 5.0, 0.5), 0.3), 0.2 + 0.3 * 5.0, epsilon = 1e-15);
    }
}
