//! A function that is known in a box only, carried on beyond its walls.

use glam::DVec3;

use crate::spatial::Aabb;

/// How far beyond a wall a function is carried on, as a share of the width of the box; farther it is constant. The crease that this
/// leaves is beyond what is asked along walls where cells are up to a tenth of the width. Carried farther, values would be far from
/// any inside.
const SHARE: f64 = 0.25;

/// A place along an axis, the weight of the value there, and how far the place moves when the point does.
type Part = (f64, f64, f64);

/// Carries a function on beyond the walls of the box in which it may be asked.
///
/// Beyond a wall at a distance d it is `2 f(0) - f(d)` of what it is on the wall and behind it: value and slope go on, where the
/// nearest value would leave a crease along the wall. Along the axis it changes no faster than inside, and along others at most three
/// times as fast. Meshing asks a little beyond walls, for slopes on them and for edges in them; that solid and box are intersected
/// is up to the caller. From a quarter of the width of the box on it is constant.
#[derive(Clone, Copy, Debug)]
pub struct Walls {
    bounds: Aabb,
}

impl Default for Walls {
    /// No walls: all of space is inside.
    fn default() -> Self {
        Walls { bounds: Aabb::ALL }
    }
}

impl Walls {
    /// Walls of a box that is finite and not empty.
    pub fn new(bounds: Aabb) -> Self {
        Walls { bounds }
    }

    /// The box.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// What a value at `x` is made of, one part inside and two beyond a wall.
    fn along(&self, k: usize, x: f64) -> ([Part; 2], usize) {
        let (lo, hi) = (self.bounds.lo[k], self.bounds.hi[k]);
        let (wall, inward, beyond) = if x < lo {
            (lo, 1.0, lo - x)
        } else if x > hi {
            (hi, -1.0, x - hi)
        } else {
            return ([(x.clamp(lo, hi), if x.is_nan() { f64::NAN } else { 1.0 }, 1.0); 2], 1);
        };
        let most = SHARE * (hi - lo);
        let (d, moves) = if beyond < most { (beyond, 1.0) } else { (most, 0.0) };
        let behind = (wall + inward * d).clamp(lo, hi);
        ([(wall, 2.0, 0.0), (behind, -1.0, -moves)], 2)
    }

    /// Calls `part` with each place that counts, its weight, and by how much the place moves along the axes.
    fn parts(&self, p: DVec3, mut part: impl FnMut(DVec3, f64, DVec3)) {
        let [x, y, z] = [0, 1, 2].map(|k| self.along(k, p[k]));
        for c in &z.0[..z.1] {
            for b in &y.0[..y.1] {
                for a in &x.0[..x.1] {
                    part(DVec3::new(a.0, b.0, c.0), a.1 * b.1 * c.1, DVec3::new(a.2, b.2, c.2));
                }
            }
        }
    }

    fn contain(&self, points: &[DVec3]) -> bool {
        points.iter().all(|p| self.bounds.contains(*p))
    }

    fn places(&self, points: &[DVec3]) -> Vec<DVec3> {
        let mut asked = Vec::with_capacity(points.len());
        for p in points {
            self.parts(*p, |place, _, _| asked.push(place));
        }
        asked
    }

    /// Values at points anywhere, from one call of a function for places in the box; both slices are of one length. Where a point has
    /// NaN so has its place, and the value is NaN.
    pub fn values(&self, points: &[DVec3], out: &mut [f64], function: impl FnOnce(&[DVec3], &mut [f64])) {
        if self.contain(points) {
            return function(points, out);
        }
        let asked = self.places(points);
        let mut found = vec![f64::NAN; asked.len()];
        function(&asked, &mut found);
        let mut next = found.into_iter();
        for (v, p) in out.iter_mut().zip(points) {
            // Minus zero is what adds nothing to zeros of either sign, so that values inside are the function's own.
            *v = -0.0;
            self.parts(*p, |_, weight, _| *v += weight * next.next().unwrap_or(f64::NAN));
        }
    }

    /// Values and gradients at points anywhere, from one call of a function that gives both; slices are of one length.
    pub fn gradients(
        &self,
        points: &[DVec3],
        values: &mut [f64],
        gradients: &mut [DVec3],
        function: impl FnOnce(&[DVec3], &mut [f64], &mut [DVec3]),
    ) {
        if self.contain(points) {
            return function(points, values, gradients);
        }
        let asked = self.places(points);
        let (mut v, mut g) = (vec![f64::NAN; asked.len()], vec![DVec3::NAN; asked.len()]);
        function(&asked, &mut v, &mut g);
        let mut next = v.into_iter().zip(g);
        for (k, p) in points.iter().enumerate() {
            (values[k], gradients[k]) = (-0.0, DVec3::splat(-0.0));
            self.parts(*p, |_, weight, moves| {
                let (v, g) = next.next().unwrap_or((f64::NAN, DVec3::NAN));
                values[k] += weight * v;
                gradients[k] += weight * moves * g;
            });
        }
    }

    /// The part of a box that is inside; of one that is beyond a wall, its shadow on the wall.
    pub(super) fn clamped(&self, cell: &Aabb) -> Aabb {
        let onto = |p: DVec3| p.clamp(self.bounds.lo, self.bounds.hi);
        Aabb::new(onto(cell.lo), onto(cell.hi))
    }

    /// How far values in a box are from those in its [clamped](Self::clamped) part at most, where values inside change by at most
    /// `steep` per length.
    pub(super) fn beyond(&self, cell: &Aabb, steep: f64) -> f64 {
        let out = (self.bounds.lo - cell.lo).max(cell.hi - self.bounds.hi);
        let out = out.clamp(DVec3::ZERO, SHARE * self.bounds.size());
        let (mut reach, mut factor) = (0.0, steep);
        for d in out.to_array().into_iter().filter(|d| *d > 0.0) {
            reach += factor * d;
            // What is made of values on and behind one wall changes three times as fast along the next.
            factor *= 3.0;
        }
        reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::{Field, differences};

    fn wave(p: DVec3) -> f64 {
        (p.x + 2.0 * p.y).sin() + p.z * p.z * p.x
    }

    /// The function itself: it must be asked in the box only.
    fn asked(walls: Walls) -> impl Fn(&[DVec3], &mut [f64]) {
        move |points, out| {
            for (v, p) in out.iter_mut().zip(points) {
                assert!(walls.bounds().contains(*p) || p.is_nan(), "{p}");
                *v = wave(*p);
            }
        }
    }

    #[test]
    fn value_and_slope_go_on_beyond_walls_and_the_function_is_asked_inside() {
        let walls = Walls::new(Aabb::new(DVec3::new(-1.0, 0.0, 0.5), DVec3::new(1.0, 2.0, 1.5)));
        let away = DVec3::new(1.0, -1.0, 1.0);
        let mut last = f64::INFINITY;
        for d in [0.08, 0.04, 0.02, 0.01] {
            let points = [
                DVec3::new(1.0, 0.7, 1.0) + d * DVec3::X,
                DVec3::new(1.0, 0.0, 1.5) + d * away,
                DVec3::new(0.2, 1.0, 1.2),
            ];
            let mut found = [0.0; 3];
            walls.values(&points, &mut found, asked(walls));
            assert_eq!(found[2].to_bits(), wave(points[2]).to_bits());
            let off = (found[0] - wave(points[0])).abs().max((found[1] - wave(points[1])).abs());
            // Second derivatives along the axes are at most 1, 4 and 2: what is left is of the second order.
            assert!(off < 10.0 * d * d && off < last / 3.0, "{off} at {d}");
            last = off;
        }
    }

    #[test]
    fn ranges_hold_beyond_walls() {
        struct Cone(Walls);
        impl Field for Cone {
            fn value(&self, p: DVec3) -> f64 {
                let mut out = [0.0];
                self.0.values(&[p], &mut out, |p, v| v.iter_mut().zip(p).for_each(|(v, p)| *v = -p.length()));
                out[0]
            }

            fn lipschitz(&self) -> Option<f64> {
                Some(1.0)
            }

            fn walls(&self) -> Option<Walls> {
                Some(self.0)
            }
        }
        let walls = Walls::new(Aabb::new(DVec3::new(-0.9, -0.2, 0.0), DVec3::new(1.0, 2.0, 1.5)));
        let field = Cone(walls);
        for side in [0.05, 0.4, 1.7] {
            for k in 0..1000 {
                let corner = DVec3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64);
                let lo = corner * 0.4 - 1.5;
                let (low, high) = field.range(&Aabb::new(lo, lo + side));
                for n in 0..125 {
                    let at = DVec3::new((n % 5) as f64, (n / 5 % 5) as f64, (n / 25) as f64);
                    let v = field.value(lo + at * (0.25 * side));
                    assert!(low <= v && v <= high, "{lo} {side}: {v} is not within {low} and {high}");
                }
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_values_anywhere() {
        let walls = Walls::new(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)));
        let points = [DVec3::new(1.3, 0.2, -0.4), DVec3::new(-1.2, 1.1, -1.4), DVec3::new(7.0, 0.1, 0.3), DVec3::ZERO];
        let (mut v, mut g, mut w, mut by_hand) = ([0.0; 4], [DVec3::ZERO; 4], [0.0; 4], [DVec3::ZERO; 4]);
        differences(&points, &mut v, &mut g, |p, v| walls.values(p, v, asked(walls)));
        walls.gradients(&points, &mut w, &mut by_hand, |p, v, g| {
            asked(walls)(p, v);
            for (g, p) in g.iter_mut().zip(p) {
                let c = (p.x + 2.0 * p.y).cos();
                *g = DVec3::new(c + p.z * p.z, 2.0 * c, 2.0 * p.z * p.x);
            }
        });
        for k in 0..4 {
            assert_eq!(v[k].to_bits(), w[k].to_bits());
            assert!((g[k] - by_hand[k]).length() < 1e-7, "{} {}", g[k], by_hand[k]);
        }
        let mut nothing = [0.0];
        walls.values(&[DVec3::new(f64::NAN, 0.0, 3.0)], &mut nothing, asked(walls));
        assert!(nothing[0].is_nan());
    }
}
