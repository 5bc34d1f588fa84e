//! Axis-aligned boxes.

use glam::{BVec3, DVec3};

use crate::numeric::Interval;

/// The largest coordinate or length that can be measured, in any unit: squares of larger ones are no numbers.
pub const LARGEST: f64 = 1e150;

/// A closed axis-aligned box; empty when some `lo > hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub lo: DVec3,
    /// Largest coordinates.
    pub hi: DVec3,
}

impl Aabb {
    /// What lies in it along each axis.
    pub(crate) fn intervals(&self) -> [Interval; 3] {
        std::array::from_fn(|k| Interval::new(self.lo[k], self.hi[k]))
    }

    /// The box that holds nothing, the neutral element of [`union`](Self::union).
    pub const EMPTY: Aabb = Aabb { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };
    /// All of space.
    pub const ALL: Aabb = Aabb { lo: DVec3::NEG_INFINITY, hi: DVec3::INFINITY };

    /// Its eight halves along all axes, in the order of their bits x, y, z.
    pub fn octants(&self) -> [Aabb; 8] {
        let mid = self.center();
        std::array::from_fn(|c| {
            let upper = BVec3::new(c & 1 != 0, c & 2 != 0, c & 4 != 0);
            Aabb::new(DVec3::select(upper, mid, self.lo), DVec3::select(upper, self.hi, mid))
        })
    }

    /// The box between two corners.
    pub fn new(lo: DVec3, hi: DVec3) -> Self {
        Self { lo, hi }
    }

    /// The smallest box around the points; [`EMPTY`](Self::EMPTY) for none.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { lo: b.lo.min(p), hi: b.hi.max(p) })
    }

    /// Whether the box holds nothing.
    pub fn is_empty(&self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// Whether all six bounds are finite.
    pub fn is_finite(&self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// The midpoint.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.lo + self.hi)
    }

    /// The three side lengths.
    pub fn size(&self) -> DVec3 {
        self.hi - self.lo
    }

    /// The length of the diagonal, 0 for an empty box.
    pub fn diagonal(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.size().length() }
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// What both share.
    pub fn intersection(&self, other: &Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Whether the closed boxes share a point.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// Whether the closed box holds the point.
    pub fn contains(&self, p: DVec3) -> bool {
        self.lo.cmple(p).all() && p.cmple(self.hi).all()
    }

    /// The box grown by `by` on all six sides.
    pub fn grown(&self, by: f64) -> Self {
        Self { lo: self.lo - by, hi: self.hi + by }
    }

    /// Squared distance from the point to the closed box, 0 inside.
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        (self.lo - p).max(p - self.hi).max(DVec3::ZERO).length_squared()
    }

    /// The eight corners; corner `i` has bit 0 of `i` for x, bit 1 for y, bit 2 for z.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.lo.x } else { self.hi.x },
                if i & 2 == 0 { self.lo.y } else { self.hi.y },
                if i & 4 == 0 { self.lo.z } else { self.hi.z },
            )
        })
    }
}
