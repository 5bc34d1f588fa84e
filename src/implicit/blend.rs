//! The smooth union of two subtrees as one smooth leaf.

use glam::DVec3;

use super::leaf::Leaf;
use super::tape::{Scratch, Tape};
use crate::numeric::{Dual, Interval};
use crate::spatial::Aabb;

/// `|(max(r + a, 0), max(r + b, 0))| + min(-r, max(a, b))`: the union of `a` and `b` with a fillet that is a circle of
/// radius `r` where the two surfaces are planes at a right angle and the leaves are distances.
#[derive(Debug)]
pub(crate) struct Blend {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) a: Tape,
    pub(crate) b: Tape,
    pub(crate) radius: f64,
}

impl Blend {
    fn join(&self, a: f64, b: f64) -> f64 {
        let r = self.radius;
        (r + a).max(0.0).hypot((r + b).max(0.0)) + a.max(b).min(-r)
    }

    pub(crate) fn eval(&self, xs: &[f64], ys: &[f64], zs: &[f64], out: &mut [f64]) {
        let mut scratch = Scratch::default();
        self.a.eval(&self.leaves, [xs, ys, zs], out, &mut scratch);
        let mut other = vec![0.0; out.len()];
        self.b.eval(&self.leaves, [xs, ys, zs], &mut other, &mut scratch);
        for (a, b) in out.iter_mut().zip(&other) {
            *a = if a.is_nan() || b.is_nan() { f64::NAN } else { self.join(*a, *b) };
        }
    }

    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        let a = self.a.active(&self.leaves, p).gradient(&self.leaves, p);
        let b = self.b.active(&self.leaves, p).gradient(&self.leaves, p);
        let r = self.radius;
        let (u, v) = ((r + a.v).max(0.0), (r + b.v).max(0.0));
        let length = u.hypot(v);
        let mut g = if length > 0.0 { (a.g * u + b.g * v) / length } else { DVec3::ZERO };
        if a.v.max(b.v) < -r {
            g += if a.v > b.v { a.g } else { b.g };
        }
        Dual::new(self.join(a.v, b.v), g)
    }

    pub(crate) fn range(&self, cell: &Aabb) -> Interval {
        let (a, b) = (self.a.range(&self.leaves, cell), self.b.range(&self.leaves, cell));
        let (r, zero) = (Interval::point(self.radius), Interval::point(0.0));
        (r + a).max(zero).hypot((r + b).max(zero)) + a.max(b).min(-r)
    }
}
