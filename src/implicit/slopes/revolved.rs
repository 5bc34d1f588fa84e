//! Bounds of gradients of surfaces of revolution over a box, by the angles that the box takes around the axis.

use glam::DVec3;

use super::super::leaf::Frame;
use super::each;
use crate::numeric::Interval;
use crate::spatial::Aabb;

/// A box as seen from an axis that does not pass it.
pub(super) struct Around {
    /// Unit vectors away from the axis,
    outward: [Interval; 3],
    /// those around it,
    along: [Interval; 3],
    /// and distances from it.
    distance: Interval,
    half: DVec3,
    middle: DVec3,
}

impl Around {
    /// `None` where the axis through `c` passes the box, or may.
    pub(super) fn new(c: DVec3, frame: &Frame, cell: &Aabb) -> Option<Self> {
        let plane = |p: DVec3| [(p - c).dot(frame.u), (p - c).dot(frame.v)];
        let middle = cell.center();
        let [x, y] = plane(middle);
        let rho = x.hypot(y);
        let [x, y] = [x / rho, y / rho];
        let (mut turned, mut far) = (Interval::ZERO, Interval::point(rho));
        let mut nearest = rho;
        for p in cell.corners() {
            let [u, v] = plane(p);
            let (ahead, aside) = (u * x + v * y, v * x - u * y);
            // The box is on one side of a line through the axis if its corners are.
            if !(ahead > 0.0) {
                return None;
            }
            turned = turned.hull(Interval::point((aside / ahead).atan()));
            far = far.hull(Interval::point(u.hypot(v)));
            nearest = nearest.min(ahead);
        }
        // Those of corners are rounded.
        let rounding = 4096.0 * f64::EPSILON;
        let turned = Interval { lo: turned.lo - rounding, hi: turned.hi + rounding };
        let (cos, sin) = (turned.cos(), turned.sin());
        let (out, on) = (frame.u * x + frame.v * y, frame.v * x - frame.u * y);
        // A sum of a sine and a cosine is one cosine.
        let wave = |a: f64, b: f64| {
            let whole = turned + Interval::point(-b.atan2(a));
            (cos.scale(a) + sin.scale(b)).within(whole.cos().scale(a.hypot(b)))
        };
        let slack = rounding * (1.0 + rho);
        Some(Self {
            outward: each(|k| wave(out[k], on[k])),
            along: each(|k| wave(on[k], -out[k])),
            distance: Interval { lo: nearest - slack, hi: far.hi + slack },
            half: 0.5 * cell.size(),
            middle,
        })
    }

    /// Bounds of the unit vectors away from the axis.
    pub(super) fn outward(&self) -> [Interval; 3] {
        self.outward
    }

    /// Bounds of what leads to the points of the box from the nearest ones of a circle around the axis, which `at` gives for the middle:
    /// this by the derivatives, of which no wide terms cancel.
    pub(super) fn away_from_circle(&self, radius: f64, at: impl Fn(DVec3) -> DVec3) -> [Interval; 3] {
        let from = at(self.middle);
        let curved = Interval::point(radius) / self.distance;
        let by = |k: usize, j: usize| {
            let own = Interval::point(f64::from(u8::from(k == j)));
            let both = if k == j { self.along[k].square() } else { self.along[k] * self.along[j] };
            own + -(curved * both)
        };
        let reach = |j: usize| Interval { lo: -self.half[j], hi: self.half[j] };
        each(|k| Interval::point(from[k]) + by(k, 0) * reach(0) + by(k, 1) * reach(1) + by(k, 2) * reach(2))
    }
}
