//! Any function may stand in as a leaf.

use std::fmt;

use glam::DVec3;

use crate::spatial::Aabb;

/// A scalar field, positive inside: a leaf an analysis code brings along.
///
/// The zero set is what counts; values near it should be roughly distances (`|gradient|` about 1) for the R-functions to
/// be normalized. Must be deterministic. NaN is reported as an error with the point.
pub trait Field: Send + Sync {
    /// Value at a point.
    fn value(&self, p: DVec3) -> f64;

    /// Values at many points, `out` as long as `points`: the same, bit by bit, as [`value`](Self::value) gives one by one. Where a
    /// call is dear, as into another language, this is the method to override; most points come through it, hundreds at once.
    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        for (v, p) in out.iter_mut().zip(points) {
            *v = self.value(*p);
        }
    }

    /// Gradient at a point; central differences with a step of 1e-6 of `1 + |p|` unless overridden.
    fn gradient(&self, p: DVec3) -> DVec3 {
        let step = 1e-6 * (1.0 + p.length());
        let along = |d: DVec3| (self.value(p + d * step) - self.value(p - d * step)) / (2.0 * step);
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }

    /// Value and gradient at a point. To be overridden where one call for both is cheaper.
    fn value_and_gradient(&self, p: DVec3) -> (f64, DVec3) {
        (self.value(p), self.gradient(p))
    }

    /// Bounds `(lo, hi)` of the value over a box. The default knows nothing: correct, but nothing can be skipped, so the
    /// cost grows with the volume. A Lipschitz constant L gives `value(center) -+ L * half diagonal`.
    fn range(&self, cell: &Aabb) -> (f64, f64) {
        let _ = cell;
        (f64::NEG_INFINITY, f64::INFINITY)
    }
}

impl fmt::Debug for dyn Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Field")
    }
}

impl<F: Fn(DVec3) -> f64 + Send + Sync> Field for F {
    fn value(&self, p: DVec3) -> f64 {
        self(p)
    }
}
