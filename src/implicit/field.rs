//! Any function may stand in as a leaf.

use std::fmt;

use glam::DVec3;

use super::walls::Walls;
use crate::numeric::FEW_ROUNDINGS;
use crate::spatial::Aabb;

/// Bounds of a value, the lower one first.
pub type Between = (f64, f64);

/// Bounds that say nothing.
pub const UNBOUNDED: Between = (f64::NEG_INFINITY, f64::INFINITY);

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

    /// Gradient at a point, if the field knows it better than by differences of values; `None` everywhere if it does not.
    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let _ = p;
        None
    }

    /// Values and gradients at many points, all slices of one length: the same, bit by bit, whatever points are asked for together.
    /// To be overridden where one call for both, or for many gradients, is cheaper.
    ///
    /// Without [`gradient`](Self::gradient), central differences with a step of 1e-6 of `1 + |p|`: one call of
    /// [`values`](Self::values) with seven times as many points.
    fn gradients(&self, points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]) {
        if points.first().is_none_or(|p| self.gradient(*p).is_none()) {
            return differences(points, values, gradients, |p, v| self.values(p, v));
        }
        self.values(points, values);
        for (g, p) in gradients.iter_mut().zip(points) {
            *g = self.gradient(*p).unwrap_or(DVec3::NAN);
        }
    }

    /// Names of the faces of its surface, where it knows several; without any it has the one of its solid. Values tell which face a point
    /// is nearest to; meshes do not have them.
    fn faces(&self) -> Vec<String> {
        Vec::new()
    }

    /// Which of the [faces](Self::faces) a point is nearest to.
    fn face_at(&self, p: DVec3) -> u32 {
        let _ = p;
        0
    }

    /// Whether a call for many points is far cheaper than a call for each: points then wait for each other, to be asked for together.
    fn in_batches(&self) -> bool {
        true
    }

    /// By how much values change per length at most, inside the [walls](Self::walls), if that is known: what tells where no surface is.
    fn lipschitz(&self) -> Option<f64> {
        None
    }

    /// The walls beyond which [values](Walls::values) are made up of those inside, if there are such. A solid is to be the
    /// intersection of the field and their box.
    fn walls(&self) -> Option<Walls> {
        None
    }

    /// Bounds `(lo, hi)` of the value over a box: from the [constant](Self::lipschitz) L, `value(center) -+ L * half diagonal`, and more
    /// as far as the box is beyond [walls](Self::walls). Without one nothing is known: correct, but nothing can be skipped, so the cost
    /// grows with the volume.
    fn range(&self, cell: &Aabb) -> Between {
        let mut out = [UNBOUNDED];
        if let Some(steep) = self.lipschitz() {
            let cell = std::slice::from_ref(cell);
            ranges_by_slope(cell, steep, self.walls(), &mut out, |p, v| self.values(p, v));
        }
        out[0]
    }

    /// [`range`](Self::range) over many boxes, `out` as long as `cells`.
    fn ranges(&self, cells: &[Aabb], out: &mut [Between]) {
        if let Some(steep) = self.lipschitz() {
            return ranges_by_slope(cells, steep, self.walls(), out, |p, v| self.values(p, v));
        }
        for (r, cell) in out.iter_mut().zip(cells) {
            *r = self.range(cell);
        }
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

/// What [`Field::gradients`] gives without gradients of the field's own: central differences of a function that is called once.
pub fn differences(
    points: &[DVec3],
    values: &mut [f64],
    gradients: &mut [DVec3],
    function: impl FnOnce(&[DVec3], &mut [f64]),
) {
    let step = |p: DVec3| 1e-6 * (1.0 + p.length());
    if let [p] = *points {
        // Without memory of their own: functions of the program itself are asked point by point.
        let h = step(p);
        let [x, y, z] = DVec3::AXES.map(|e| e * h);
        let mut v = [f64::NAN; 7];
        function(&[p + x, p - x, p + y, p - y, p + z, p - z, p], &mut v);
        values[0] = v[6];
        gradients[0] = DVec3::new(v[0] - v[1], v[2] - v[3], v[4] - v[5]) / (2.0 * h);
        return;
    }
    let mut around = Vec::with_capacity(7 * points.len());
    for p in points {
        let h = step(*p);
        around.extend(DVec3::AXES.iter().flat_map(|e| [*p + *e * h, *p - *e * h]));
        around.push(*p);
    }
    let mut found = vec![f64::NAN; around.len()];
    function(&around, &mut found);
    for (k, (p, v)) in points.iter().zip(found.chunks_exact(7)).enumerate() {
        values[k] = v[6];
        gradients[k] = DVec3::new(v[0] - v[1], v[2] - v[3], v[4] - v[5]) / (2.0 * step(*p));
    }
}

/// Bounds where values change by at most `steep` per length, from the values in the middles of the boxes, which are asked for in one
/// call. Infinite boxes, and those with NaN in the middle, have no bounds.
fn ranges_by_slope(
    cells: &[Aabb],
    steep: f64,
    walls: Option<Walls>,
    out: &mut [Between],
    function: impl FnOnce(&[DVec3], &mut [f64]),
) {
    let inside: Vec<(Aabb, f64)> =
        cells.iter().map(|c| walls.map_or((*c, 0.0), |w| (w.clamped(c), w.beyond(c, steep)))).collect();
    let finite: Vec<usize> = (0..cells.len()).filter(|k| inside[*k].0.is_finite()).collect();
    let middles: Vec<DVec3> = finite.iter().map(|k| inside[*k].0.center()).collect();
    let mut values = vec![f64::NAN; middles.len()];
    function(&middles, &mut values);
    out.fill(UNBOUNDED);
    for (k, middle) in finite.into_iter().zip(values) {
        let (cell, beyond) = inside[k];
        out[k] = range_around(middle, 0.5 * cell.diagonal() * steep + beyond);
    }
}

/// Bounds of what is at most `reach` from a value; none if that is NaN.
pub(super) fn range_around(middle: f64, reach: f64) -> Between {
    // Bounds are widened for rounding.
    let slack = FEW_ROUNDINGS * (middle.abs() + reach);
    let range = (middle - reach - slack, middle + reach + slack);
    if range.0.is_nan() { UNBOUNDED } else { range }
}
