//! Values on a grid of points as a leaf: trilinear between them.

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::implicit::{Field, Solid};
use crate::numeric::FEW_ROUNDINGS;
use crate::spatial::Aabb;

/// The least and the largest value over blocks of cells.
struct CellRanges {
    counts: [usize; 3],
    /// In the order of the values.
    ranges: Vec<[f64; 2]>,
}

impl CellRanges {
    fn at(&self, [i, j, k]: [usize; 3]) -> [f64; 2] {
        self.ranges[i + self.counts[0] * (j + self.counts[1] * k)]
    }

    /// Over a span of blocks, both ends included.
    fn over(&self, lo: [usize; 3], hi: [usize; 3]) -> [f64; 2] {
        let mut all = [f64::INFINITY, f64::NEG_INFINITY];
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                for i in lo[0]..=hi[0] {
                    let [a, b] = self.at([i, j, k]);
                    all = [all[0].min(a), all[1].max(b)];
                }
            }
        }
        all
    }
}

/// A function known by its values on a grid of points, trilinear between them; outside, that of the nearest point inside.
///
/// Its surface is continuous, with faint creases along the walls of the cells. Which regions it cannot pass is known from the
/// values, so no Lipschitz constant is wanted.
pub struct GridField {
    points: [usize; 3],
    bounds: Aabb,
    values: Vec<f64>,
    /// Ranges over cells, then over blocks of twice as many along each axis, up to one block.
    levels: Vec<CellRanges>,
    slack: f64,
}

/// One cell, and where in it a point is.
struct Within {
    cell: [usize; 3],
    share: [f64; 3],
}

impl GridField {
    /// Values at `points[0] * points[1] * points[2]` points from corner to corner of `bounds`, x running fastest; positive inside.
    ///
    /// Errors: input, for fewer than two points along an axis, a number of values that is not that of the points, bounds that are no
    /// box, values that are not finite (the first is named), and values without a change of sign, which have no surface.
    pub fn new(points: [usize; 3], bounds: Aabb, values: Vec<f64>) -> Result<Self> {
        check(points, &bounds, &values)?;
        let slack = FEW_ROUNDINGS * values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut grid = GridField { points, bounds, values, levels: Vec::new(), slack };
        let cells = points.map(|n| n - 1);
        let mut ranges = Vec::with_capacity(cells.iter().product());
        for k in 0..cells[2] {
            for j in 0..cells[1] {
                for i in 0..cells[0] {
                    let corners = grid.corners([i, j, k]);
                    ranges.push(
                        corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |r, v| [r[0].min(*v), r[1].max(*v)]),
                    );
                }
            }
        }
        let mut level = CellRanges { counts: cells, ranges };
        while level.ranges.len() > 1 {
            let blocks = level.counts.map(|n| n.div_ceil(2));
            let mut ranges = Vec::with_capacity(blocks.iter().product());
            for k in 0..blocks[2] {
                for j in 0..blocks[1] {
                    for i in 0..blocks[0] {
                        let lo = [2 * i, 2 * j, 2 * k];
                        let hi = std::array::from_fn(|a| (lo[a] + 1).min(level.counts[a] - 1));
                        ranges.push(level.over(lo, hi));
                    }
                }
            }
            grid.levels.push(std::mem::replace(&mut level, CellRanges { counts: blocks, ranges }));
        }
        grid.levels.push(level);
        Ok(grid)
    }

    /// Where the function is positive, cut off at the bounds: the solid most want, and one that needs no domain.
    pub fn into_solid(self) -> Solid {
        let Aabb { lo, hi } = self.bounds;
        Solid::field(self) & Solid::cuboid(lo, hi)
    }

    /// Values at the corners of a cell, x first.
    fn corners(&self, [i, j, k]: [usize; 3]) -> [f64; 8] {
        let [nx, ny, _] = self.points;
        std::array::from_fn(|c| self.values[i + (c & 1) + nx * (j + (c >> 1 & 1) + ny * (k + (c >> 2)))])
    }

    /// The cell of a point; what is outside counts as the nearest point inside.
    fn within(&self, p: DVec3) -> Within {
        let (mut cell, mut share) = ([0; 3], [0.0; 3]);
        let size = self.bounds.hi - self.bounds.lo;
        for a in 0..3 {
            let last = self.points[a] - 2;
            let at = ((p[a] - self.bounds.lo[a]) / size[a] * (last + 1) as f64).clamp(0.0, (last + 1) as f64);
            cell[a] = (at as usize).min(last);
            share[a] = at - cell[a] as f64;
        }
        Within { cell, share }
    }
}

/// Between two values.
fn mix(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

impl Field for GridField {
    fn value(&self, p: DVec3) -> f64 {
        if p.is_nan() {
            return f64::NAN;
        }
        let Within { cell, share: [x, y, z] } = self.within(p);
        let v = self.corners(cell);
        let face = |c: usize| mix(mix(v[c], v[c + 1], x), mix(v[c + 2], v[c + 3], x), y);
        mix(face(0), face(4), z)
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        if p.is_nan() {
            return Some(DVec3::NAN);
        }
        let Within { cell, share: [x, y, z] } = self.within(p);
        let v = self.corners(cell);
        let slope = |c: usize, d: usize| v[c + d] - v[c];
        let step = (self.bounds.hi - self.bounds.lo) / DVec3::from_array(self.points.map(|n| (n - 1) as f64));
        let gx = mix(mix(slope(0, 1), slope(2, 1), y), mix(slope(4, 1), slope(6, 1), y), z);
        let gy = mix(mix(slope(0, 2), slope(1, 2), x), mix(slope(4, 2), slope(5, 2), x), z);
        let gz = mix(mix(slope(0, 4), slope(1, 4), x), mix(slope(2, 4), slope(3, 4), x), y);
        Some(DVec3::new(gx, gy, gz) / step)
    }

    fn in_batches(&self) -> bool {
        false
    }

    fn range(&self, cell: &Aabb) -> (f64, f64) {
        let (mut lo, mut hi) = (self.within(cell.lo).cell, self.within(cell.hi).cell);
        // Rounding may put a corner of the box just across the wall of a cell.
        for a in 0..3 {
            lo[a] = lo[a].saturating_sub(1);
            hi[a] = (hi[a] + 1).min(self.points[a] - 2);
        }
        let wide = (0..3).map(|a| hi[a] - lo[a]).max().unwrap_or(0);
        // CellRanges about as large as the box: a few of them cover it, however large it is.
        let level = (wide.max(1).ilog2() as usize).saturating_sub(1).min(self.levels.len() - 1);
        let [a, b] = self.levels[level].over(lo.map(|i| i >> level), hi.map(|i| i >> level));
        (a - self.slack, b + self.slack)
    }
}

/// What [`GridField::new`] refuses.
fn check(points: [usize; 3], bounds: &Aabb, values: &[f64]) -> Result<()> {
    let wrong = |what: String| Err(Error::input(Place::Unknown, what));
    if points.iter().any(|n| *n < 2) {
        return wrong(format!("a grid needs two points along each axis, not {points:?}"));
    }
    let all = points.iter().try_fold(1usize, |all, n| all.checked_mul(*n));
    if all != Some(values.len()) {
        return wrong(format!("a grid of {points:?} points has not {} values", values.len()));
    }
    if !(bounds.is_finite() && bounds.lo.cmplt(bounds.hi).all()) {
        let what = format!("bounds need finite lo < hi in all three coordinates, not {} and {}", bounds.lo, bounds.hi);
        return wrong(what);
    }
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        let at = [i % points[0], i / points[0] % points[1], i / points[0] / points[1]];
        return Err(Error::input(
            Place::Item(format!("value {at:?} of the grid")),
            format!("it is not finite: {}", values[i]),
        ));
    }
    let inside = values.iter().filter(|v| **v > 0.0).count();
    if inside == 0 || inside == values.len() {
        let side = if inside == 0 { "outside" } else { "inside" };
        return Err(Error::input(
            Place::Unknown,
            format!("all values of the grid are {side}: there is no surface between them"),
        )
        .with_help("values are positive inside and negative outside"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{abs_diff_eq, assert_abs_diff_eq};

    /// Numbers between 0 and 1 that are the same each time.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1963u64;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    fn some() -> (GridField, impl FnMut() -> f64) {
        let mut next = numbers();
        let (points, bounds) = ([5, 9, 4], Aabb::new(DVec3::new(-1.0, 2.0, 0.5), DVec3::new(1.0, 3.0, 4.0)));
        let values = (0..180).map(|_| next() - 0.5).collect();
        (GridField::new(points, bounds, values).unwrap(), next)
    }

    #[test]
    fn ranges_hold_all_values_of_a_box_and_are_no_wider_than_all() {
        let (grid, mut next) = some();
        let whole = grid.range(&grid.bounds);
        for _ in 0..300 {
            let mut point =
                || grid.bounds.lo - 0.2 + (grid.bounds.hi - grid.bounds.lo + 0.4) * DVec3::new(next(), next(), next());
            let (p, q) = (point(), point());
            let cell = Aabb::new(p.min(q), p.max(q));
            let (lo, hi) = grid.range(&cell);
            assert!(lo >= whole.0 && hi <= whole.1);
            for _ in 0..30 {
                let v = grid.value(p + (q - p) * DVec3::new(next(), next(), next()));
                assert!(lo <= v && v <= hi, "{v} is not in {lo} .. {hi}");
            }
        }
        // Small boxes see their own cells only.
        let small = grid.range(&Aabb::new(DVec3::new(-0.9, 2.05, 0.6), DVec3::new(-0.89, 2.06, 0.61)));
        assert!(small.1 - small.0 < whole.1 - whole.0);
    }

    #[test]
    fn values_at_points_are_those_given_and_gradients_are_slopes() {
        let (grid, mut next) = some();
        let step = (grid.bounds.hi - grid.bounds.lo) / DVec3::new(4.0, 8.0, 3.0);
        for at in [[0, 0, 0], [4, 8, 3], [2, 5, 1]] {
            let [i, j, k] = at.map(|i: usize| i as f64);
            let v = grid.value(grid.bounds.lo + step * DVec3::new(i, j, k));
            assert_abs_diff_eq!(v, grid.values[at[0] + 5 * (at[1] + 9 * at[2])], epsilon = 1e-12);
        }
        for _ in 0..50 {
            // In the middle half of a cell, where differences stay in it.
            let mut share = || (next() * 3.0).floor() + 0.25 + 0.5 * next();
            let p = grid.bounds.lo + step * DVec3::new(share(), share(), share());
            let g = grid.gradient(p).unwrap();
            for axis in DVec3::AXES {
                let slope = (grid.value(p + axis * 1e-4) - grid.value(p - axis * 1e-4)) / 2e-4;
                assert!(abs_diff_eq!(slope, g.dot(axis), epsilon = 1e-9), "{slope} {g}");
            }
        }
    }

    #[test]
    fn what_is_no_grid_is_an_error() {
        let bounds = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let told = |points, values: Vec<f64>| match GridField::new(points, bounds, values) {
            Ok(_) => String::new(),
            Err(e) => e.to_string(),
        };
        let mut values = vec![1.0; 12];
        values[0] = -1.0;
        assert_eq!(told([2, 3, 2], values.clone()), "");
        assert!(told([2, 3, 3], values.clone()).contains("12 values"));
        assert!(told([12, 1, 1], values.clone()).contains("two points"));
        values[9] = f64::NAN;
        assert!(told([2, 3, 2], values).starts_with("value [1, 1, 1] of the grid: it is not finite"));
        assert!(told([2, 3, 2], vec![1.0; 12]).contains("inside"));
        assert!(told([2, 3, 2], vec![0.0; 12]).contains("outside"));
    }
}
