//! Parts and borders of NURBS surfaces.

use glam::DVec4;

use super::{NurbsCurve, NurbsSurface};
use crate::error::Result;

/// Normals that turn by more than this angle, in radians, make a crease.
const CREASE: f64 = 1e-6;
/// Places along a line of knots at which both sides are looked at.
const SAMPLES: u32 = 9;

impl NurbsSurface {
    /// The same surface with u and v exchanged; its normal looks the other way. Errors: none for a
    /// surface that was made.
    pub fn transposed(&self) -> Result<Self> {
        let (nu, nv) = (self.u.points(), self.v.points());
        let points: Vec<DVec4> = (0..nu * nv).map(|k| self.weighted()[(k % nu) * nv + k / nu]).collect();
        Self::from_weighted(self.v.clone(), self.u.clone(), &points)
    }

    /// The part over a range of v, with borders that are rows of control points.
    fn part_across(&self, range: [f64; 2]) -> Result<Self> {
        let (mut points, mut knots) = (Vec::new(), self.v.clone());
        for row in self.weighted().chunks(self.v.points()) {
            let c = NurbsCurve::from_weighted(self.v.degree(), self.v.values().to_vec(), row)?.part(range)?;
            points.extend_from_slice(c.weighted());
            knots = c.knots;
        }
        Self::from_weighted(self.u.clone(), knots, &points)
    }

    /// The part over ranges of u and v inside the domain, with borders that are rows of control points; the parameters stay.
    /// Errors: empty ranges.
    pub fn part(&self, u: [f64; 2], v: [f64; 2]) -> Result<Self> {
        self.part_across(v)?.transposed()?.part_across(u)?.transposed()
    }

    /// Parameters v inside the domain at which the normal jumps.
    fn creases_across(&self) -> Vec<f64> {
        let ([a, b], [c, d]) = (self.u.domain(), self.v.domain());
        let step = 1e-9 * (d - c);
        let bent = |v: f64| {
            (0..SAMPLES).any(|k| {
                let u = a + (b - a) * (f64::from(k) + 0.5) / f64::from(SAMPLES);
                let [m, n] = [v - step, v + step].map(|v| {
                    let [_, su, sv, ..] = self.jet(u, v);
                    su.cross(sv)
                });
                m.angle_between(n) > CREASE
            })
        };
        self.v.loose().into_iter().filter(|v| bent(*v)).collect()
    }

    /// The smooth parts of the surface, with borders that are rows of control points: cut along the lines where its normal
    /// jumps. One where there are none. Errors: see [`NurbsSurface::new`].
    pub fn smooth_parts(&self) -> Result<Vec<Self>> {
        let mut parts = vec![self.clone()];
        for _ in 0..2 {
            let mut next = Vec::new();
            for p in &parts {
                let [a, b] = p.v.domain();
                let ends: Vec<f64> = [a].into_iter().chain(p.creases_across()).chain([b]).collect();
                for w in ends.windows(2) {
                    next.push(p.part_across([w[0], w[1]])?.transposed()?);
                }
            }
            parts = next;
        }
        Ok(parts)
    }

    /// The borders v = start, u = end, v = end and u = start, each along its rising parameter. Only for knots that end in
    /// control points. Errors: see [`NurbsCurve::new`].
    pub fn rims(&self) -> Result<[NurbsCurve; 4]> {
        let t = self.transposed()?;
        Ok([t.rim(0)?, self.rim(1)?, t.rim(1)?, self.rim(0)?])
    }
}
