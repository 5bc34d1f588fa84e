//! Surfaces (\[KUZ19\] 28-61): the elementary ones in closed form, swept ones by their curves, NURBS, offsets.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::Curve;
use super::family::{Family, Over, Shift};
use super::frame::{Frame, Similarity};
use super::nurbs::NurbsSurface;
use crate::numeric::{ROUNDING, SEVEN_DIGITS};

/// Step for derivatives that are not known in closed form, as a share of the parameter's range.
const STEP: f64 = 1e-5;

/// A surface, parametrized as in ISO 10303-42. Angles are in radians.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// u along x, v along y of the frame.
    Plane {
        /// Origin and axes.
        frame: Frame,
    },
    /// u around z, v along it.
    Cylinder {
        /// Axis.
        frame: Frame,
        /// Radius.
        radius: f64,
    },
    /// u around z, v along it; the radius is `radius + slope * v`.
    Cone {
        /// Axis.
        frame: Frame,
        /// Radius at v = 0.
        radius: f64,
        /// Growth of the radius along the axis.
        slope: f64,
    },
    /// u around z, v from -pi/2 to pi/2.
    Sphere {
        /// Center and axes.
        frame: Frame,
        /// Radius.
        radius: f64,
    },
    /// u around z, v around the tube. Where the tube is thicker than the ring is wide, only its outer part counts.
    Torus {
        /// Center and axis.
        frame: Frame,
        /// Radius of the tube's center line.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// `curve(u) + v * direction` (\[KUZ19\] 31).
    Extrusion {
        /// The profile.
        curve: Curve,
        /// What is added for v = 1.
        direction: DVec3,
    },
    /// `curve(v)` turned by u around the frame's z axis (\[KUZ19\] 32).
    Revolution {
        /// The profile.
        curve: Curve,
        /// The axis.
        frame: Frame,
    },
    /// Straight lines (v in 0..=1) between points of two curves at the same share u in 0..=1 of their ranges
    /// (\[KUZ19\] 34, 35).
    Ruled {
        /// The curves.
        curves: Box<[Curve; 2]>,
        /// The parts of them.
        ranges: [[f64; 2]; 2],
    },
    /// A rational B-spline.
    Nurbs(NurbsSurface),
    /// A surface over a family of curves.
    Family(Box<Family>),
    /// A profile shifted along a path.
    Shift(Box<Shift>),
    /// A surface at a distance along the normal of another.
    Offset {
        /// The other.
        base: Box<Surface>,
        /// The distance.
        distance: f64,
    },
}

/// A line of the parameter domain that is one point in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pole {
    /// Which parameter is constant on it: 0 for u, 1 for v.
    pub axis: usize,
    /// Its value.
    pub value: f64,
    /// The point.
    pub point: DVec3,
}

impl Surface {
    /// Point and derivatives: S, Su, Sv, Suu, Suv, Svv.
    pub fn jet(&self, u: f64, v: f64) -> [DVec3; 6] {
        /// Derivatives that vanish.
        const O: DVec3 = DVec3::ZERO;
        match self {
            Surface::Plane { frame } => {
                [frame.point(DVec3::new(u, v, 0.0)), frame.axes.x_axis, frame.axes.y_axis, O, O, O]
            }
            Surface::Cylinder { frame, radius } => {
                let (r, t) = frame.turned(u);
                [frame.origin + *radius * r + v * frame.z(), *radius * t, frame.z(), -*radius * r, O, O]
            }
            Surface::Cone { frame, radius, slope } => {
                let (r, t) = frame.turned(u);
                let rho = radius + slope * v;
                [frame.origin + rho * r + v * frame.z(), rho * t, *slope * r + frame.z(), -rho * r, *slope * t, O]
            }
            Surface::Sphere { frame, radius } => {
                let (r, t) = frame.turned(u);
                let (s, c) = v.sin_cos();
                let (x, z) = (*radius * c, *radius * s);
                let out = x * r + z * frame.z();
                [frame.origin + out, x * t, x * frame.z() - z * r, -x * r, -z * t, -out]
            }
            Surface::Torus { frame, major, minor } => {
                let (r, t) = frame.turned(u);
                let (s, c) = v.sin_cos();
                let rho = major + minor * c;
                [
                    frame.origin + rho * r + minor * s * frame.z(),
                    rho * t,
                    *minor * (c * frame.z() - s * r),
                    -rho * r,
                    -minor * s * t,
                    -*minor * (c * r + s * frame.z()),
                ]
            }
            Surface::Extrusion { curve, direction } => {
                let [c, d, e] = curve.jet(u);
                [c + v * *direction, d, *direction, e, O, O]
            }
            Surface::Revolution { curve, frame } => {
                let turn = |p: DVec3| {
                    let (r, t) = frame.turned(u);
                    let l = frame.axes.transpose() * p;
                    (l.x * r + l.y * t + l.z * frame.z(), l.x * t - l.y * r, -(l.x * r + l.y * t))
                };
                let [c, d, e] = curve.jet(v);
                let (p, pu, puu) = turn(c - frame.origin);
                let (q, qu, _) = turn(d);
                [frame.origin + p, pu, q, puu, qu, turn(e).0]
            }
            Surface::Ruled { curves, ranges } => {
                let part = |k: usize| {
                    let [a, b] = ranges[k];
                    let [c, d, e] = curves[k].jet(a + u * (b - a));
                    [c, (b - a) * d, (b - a) * (b - a) * e]
                };
                let (p, q) = (part(0), part(1));
                let mix = |k: usize| p[k].lerp(q[k], v);
                [mix(0), mix(1), q[0] - p[0], mix(2), q[1] - p[1], O]
            }
            Surface::Nurbs(n) => n.jet(u, v),
            Surface::Family(f) => Over::Family(f).jet(u, v),
            Surface::Shift(s) => Over::Shift(s).jet(u, v),
            Surface::Offset { base, distance } => {
                let first = |u: f64, v: f64| offset_jet(base, *distance, u, v);
                let [s, su, sv] = first(u, v);
                let step = |k: usize| {
                    let [a, b] = self.domain()[k];
                    STEP * if (b - a).is_finite() { b - a } else { 1.0 }
                };
                let (h, k) = (step(0), step(1));
                let (a, b) = (first(u - h, v), first(u + h, v));
                let (c, d) = (first(u, v - k), first(u, v + k));
                [s, su, sv, (b[1] - a[1]) / (2.0 * h), (b[2] - a[2]) / (2.0 * h), (d[2] - c[2]) / (2.0 * k)]
            }
        }
    }

    /// The point at a parameter.
    pub fn at(&self, uv: DVec2) -> DVec3 {
        match self {
            Surface::Nurbs(n) => n.at(uv.x, uv.y),
            _ => self.jet(uv.x, uv.y)[0],
        }
    }

    /// Whether it goes round an axis, as tubes do.
    pub(super) fn is_round(&self) -> bool {
        matches!(self, Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Torus { .. })
    }

    /// The smallest radius of curvature anywhere, where that is plain: infinite for a plane.
    pub(super) fn bend_radius(&self) -> Option<f64> {
        match self {
            Surface::Plane { .. } => Some(f64::INFINITY),
            Surface::Cylinder { radius, .. } | Surface::Sphere { radius, .. } => Some(*radius),
            Surface::Torus { major, minor, .. } => Some(minor.min((major - minor).max(0.0))),
            _ => None,
        }
    }

    /// The parameters the surface is defined for, u and v; infinite where it has no end.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        /// A parameter without an end.
        const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        match self {
            Surface::Plane { .. } => [ALL, ALL],
            Surface::Cylinder { .. } | Surface::Cone { .. } => [[0.0, TAU], ALL],
            Surface::Sphere { .. } => [[0.0, TAU], [-0.5 * PI, 0.5 * PI]],
            Surface::Torus { major, minor, .. } if major < minor => {
                let end = (-major / minor).acos();
                [[0.0, TAU], [-end, end]]
            }
            Surface::Torus { .. } => [[0.0, TAU]; 2],
            Surface::Extrusion { curve, .. } => [curve.domain(), ALL],
            Surface::Revolution { curve, .. } => [[0.0, TAU], curve.domain()],
            Surface::Ruled { .. } => [[0.0, 1.0]; 2],
            Surface::Nurbs(n) => [n.u.domain(), n.v.domain()],
            Surface::Family(f) => Over::Family(f).domain(),
            Surface::Shift(s) => Over::Shift(s).domain(),
            Surface::Offset { base, .. } => base.domain(),
        }
    }

    /// Where the parameters repeat themselves: by nature, or because opposite borders coincide.
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Surface::Plane { .. } => [None, None],
            Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Sphere { .. } => [Some(TAU), None],
            Surface::Torus { major, minor, .. } => [Some(TAU), (major >= minor).then_some(TAU)],
            Surface::Offset { base, .. } => base.periods(),
            Surface::Revolution { .. } => [Some(TAU), self.closed(1)],
            _ => [self.closed(0), self.closed(1)],
        }
    }

    /// Samples of the border at one end of a parameter.
    fn border(&self, axis: usize, value: f64) -> Option<Vec<DVec3>> {
        let [a, b] = self.domain()[1 - axis];
        let [a, b] = if (b - a).is_finite() { [a, b] } else { [0.0, 1.0] };
        if !value.is_finite() {
            return None;
        }
        let point = |t: f64| if axis == 0 { self.at(DVec2::new(value, t)) } else { self.at(DVec2::new(t, value)) };
        Some((0..=12).map(|k| point(a + (b - a) * f64::from(k) / 12.0)).collect())
    }

    fn closed(&self, axis: usize) -> Option<f64> {
        let [a, b] = self.domain()[axis];
        let (p, q) = (self.border(axis, a)?, self.border(axis, b)?);
        let middle = self.border(axis, 0.5 * (a + b))?;
        let size = crate::spatial::Aabb::around(p.iter().chain(&middle).copied()).diagonal();
        // A boundary of the parameters this near to its opposite is its continuation; a shorter one is a point.
        let same = p.iter().zip(&q).all(|(p, q)| p.distance(*q) <= SEVEN_DIGITS * size);
        // A patch folded to a line is not closed.
        (same && size > 0.0).then_some(b - a)
    }

    /// Lines of the domain that are points in space.
    pub fn poles(&self) -> Vec<Pole> {
        let pole = |axis, value, point| Pole { axis, value, point };
        match self {
            Surface::Cone { frame, radius, slope } if *slope != 0.0 => {
                let v = -radius / slope;
                vec![pole(1, v, frame.origin + v * frame.z())]
            }
            Surface::Plane { .. } | Surface::Cylinder { .. } | Surface::Cone { .. } => Vec::new(),
            Surface::Sphere { frame, radius } => {
                let z = *radius * frame.z();
                vec![pole(1, -0.5 * PI, frame.origin - z), pole(1, 0.5 * PI, frame.origin + z)]
            }
            Surface::Torus { frame, major, minor } if major <= minor => {
                let end = (-major / minor).acos();
                let z = minor * end.sin() * frame.z();
                let mut both = vec![pole(1, -end, frame.origin - z)];
                // A ring without a hole touches itself in one point, on one line of its domain.
                if major < minor {
                    both.push(pole(1, end, frame.origin + z));
                }
                both
            }
            Surface::Torus { .. } => Vec::new(),
            Surface::Offset { base, .. } => base.poles().into_iter().map(|p| self.offset_pole(p)).collect(),
            _ => {
                let mut out = Vec::new();
                for axis in 0..2 {
                    for end in 0..2 {
                        let value = self.domain()[axis][end];
                        let Some(samples) = self.border(axis, value) else { continue };
                        let length: f64 = samples.windows(2).map(|w| w[0].distance(w[1])).sum();
                        if length <= SEVEN_DIGITS * self.extent() {
                            out.push(pole(axis, value, samples[0]));
                        }
                    }
                }
                out
            }
        }
    }

    fn offset_pole(&self, p: Pole) -> Pole {
        let mut uv = DVec2::ZERO;
        for (k, [a, b]) in self.domain().into_iter().enumerate() {
            uv[k] = if (b - a).is_finite() { 0.5 * (a + b) } else { 0.0 };
        }
        uv[p.axis] = p.value;
        Pole { point: self.at(uv), ..p }
    }

    /// A length typical of the surface, from samples of its domain; 1 per unit where that is infinite.
    fn extent(&self) -> f64 {
        let [u, v] = self.domain().map(|[a, b]| if (b - a).is_finite() { [a, b] } else { [0.0, 1.0] });
        let mut around = crate::spatial::Aabb::EMPTY;
        for i in 0..=8 {
            for j in 0..=8 {
                let at = |r: [f64; 2], k: i32| r[0] + (r[1] - r[0]) * f64::from(k) / 8.0;
                around = around.union(&crate::spatial::Aabb::around([self.at(DVec2::new(at(u, i), at(v, j)))]));
            }
        }
        around.diagonal()
    }

    /// Parameters of the point nearest to `p`, where there is a closed form.
    pub fn foot(&self, p: DVec3) -> Option<DVec2> {
        match self {
            Surface::Plane { frame } => {
                let l = frame.local(p);
                Some(DVec2::new(l.x, l.y))
            }
            Surface::Cylinder { frame, .. } => {
                let l = frame.local(p);
                Some(DVec2::new(Frame::angle(l.truncate()), l.z))
            }
            Surface::Cone { frame, radius, slope } => {
                let l = frame.local(p);
                let (u, rho) = (Frame::angle(l.truncate()), l.truncate().length());
                // The cone has two halves; on the far one radii are negative.
                let foot = |rho: f64| {
                    let v = ((rho - radius) * slope + l.z) / (1.0 + slope * slope);
                    (v, (rho - radius - slope * v).hypot(l.z - v))
                };
                let (near, far) = (foot(rho), foot(-rho));
                Some(if near.1 <= far.1 { DVec2::new(u, near.0) } else { DVec2::new((u + PI).rem_euclid(TAU), far.0) })
            }
            Surface::Sphere { frame, .. } => {
                let l = frame.local(p);
                Some(DVec2::new(Frame::angle(l.truncate()), l.z.atan2(l.truncate().length())))
            }
            Surface::Torus { frame, major, minor } => {
                let l = frame.local(p);
                let v = l.z.atan2(l.truncate().length() - major);
                let v = if major >= minor {
                    v.rem_euclid(TAU)
                } else {
                    let end = (-major / minor).acos();
                    v.clamp(-end, end)
                };
                Some(DVec2::new(Frame::angle(l.truncate()), v))
            }
            Surface::Offset { base, .. } => base.foot(p),
            _ => None,
        }
    }

    /// The point nearest to `p` and the unit normal Su x Sv there, without parameters, for surfaces with a closed form and
    /// off their axes; the same as by [`foot`](Self::foot) to rounding, and several times faster.
    pub fn nearest(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let upright = |frame: &Frame| {
            let d = p - frame.origin;
            let z = d.dot(frame.z());
            let out = d - z * frame.z();
            let rho = out.length();
            // Nearer to an axis directions around it are not trusted.
            (rho > ROUNDING * d.length()).then(|| (z, rho, out / rho))
        };
        match self {
            Surface::Plane { frame } => {
                let n = frame.z();
                Some((p - n * n.dot(p - frame.origin), n))
            }
            Surface::Cylinder { frame, radius } => {
                let (z, _, r) = upright(frame)?;
                Some((frame.origin + z * frame.z() + *radius * r, r))
            }
            Surface::Sphere { frame, radius } => {
                let n = (p - frame.origin).try_normalize()?;
                Some((frame.origin + *radius * n, n))
            }
            Surface::Cone { frame, radius, slope } => {
                let (z, rho, r) = upright(frame)?;
                let v = ((rho - radius) * slope + z) / (1.0 + slope * slope);
                let at = radius + slope * v;
                // Near the tip the other half may be nearer.
                let n = (r - *slope * frame.z()) / (1.0 + slope * slope).sqrt();
                (at > 0.5 * rho).then(|| (frame.origin + at * r + v * frame.z(), n))
            }
            Surface::Torus { frame, major, minor } if major > minor => {
                let (z, rho, r) = upright(frame)?;
                let n = ((rho - major) * r + z * frame.z()).try_normalize()?;
                Some((frame.origin + *major * r + *minor * n, n))
            }
            _ => None,
        }
    }

    /// Unit normal Su x Sv, `None` where it vanishes.
    pub fn normal(&self, uv: DVec2) -> Option<DVec3> {
        let [_, su, sv, ..] = self.jet(uv.x, uv.y);
        unit_normal(su, sv)
    }

    /// The larger magnitude of the principal curvatures, `None` at a singular point.
    pub fn curvature(&self, uv: DVec2) -> Option<f64> {
        match self {
            Surface::Plane { .. } => return Some(0.0),
            Surface::Cylinder { radius, .. } | Surface::Sphere { radius, .. } => return Some(1.0 / radius),
            _ => {}
        }
        let [_, su, sv, suu, suv, svv] = self.jet(uv.x, uv.y);
        let n = unit_normal(su, sv)?;
        let (e, f, g) = (su.length_squared(), su.dot(sv), sv.length_squared());
        let (l, m, k) = (n.dot(suu), n.dot(suv), n.dot(svv));
        let det = e * g - f * f;
        let mean = 0.5 * (e * k - 2.0 * f * m + g * l) / det;
        let gauss = (l * k - m * m) / det;
        let root = (mean * mean - gauss).max(0.0).sqrt();
        let largest = mean.abs() + root;
        largest.is_finite().then_some(largest)
    }

    /// The surface moved; parameters along lengths of elementary surfaces change with the scale.
    pub fn moved(&self, m: &Similarity) -> Self {
        let s = m.scale;
        match self {
            Surface::Plane { frame } => Surface::Plane { frame: m.frame(frame) },
            Surface::Cylinder { frame, radius } => Surface::Cylinder { frame: m.frame(frame), radius: s * radius },
            Surface::Cone { frame, radius, slope } => {
                Surface::Cone { frame: m.frame(frame), radius: s * radius, slope: *slope }
            }
            Surface::Sphere { frame, radius } => Surface::Sphere { frame: m.frame(frame), radius: s * radius },
            Surface::Torus { frame, major, minor } => {
                Surface::Torus { frame: m.frame(frame), major: s * major, minor: s * minor }
            }
            Surface::Extrusion { curve, direction } => {
                Surface::Extrusion { curve: curve.moved(m), direction: m.vector(*direction) }
            }
            Surface::Revolution { curve, frame } => {
                Surface::Revolution { curve: curve.moved(m), frame: m.frame(frame) }
            }
            Surface::Ruled { curves, ranges } => {
                Surface::Ruled { curves: Box::new([curves[0].moved(m), curves[1].moved(m)]), ranges: *ranges }
            }
            Surface::Nurbs(n) => Surface::Nurbs(n.map(|p| m.point(p))),
            Surface::Family(f) => Over::Family(f).moved(m),
            Surface::Shift(s) => Over::Shift(s).moved(m),
            Surface::Offset { base, distance } => {
                Surface::Offset { base: Box::new(base.moved(m)), distance: s * distance }
            }
        }
    }

    /// What the surface is called.
    pub fn kind(&self) -> &'static str {
        match self {
            Surface::Plane { .. } => "plane",
            Surface::Cylinder { .. } => "cylinder",
            Surface::Cone { .. } => "cone",
            Surface::Sphere { .. } => "sphere",
            Surface::Torus { .. } => "torus",
            Surface::Extrusion { .. } => "extrusion",
            Surface::Revolution { .. } => "revolution",
            Surface::Ruled { .. } => "ruled",
            Surface::Nurbs(_) => "nurbs",
            Surface::Family(_) => "family",
            Surface::Shift(_) => "shift",
            Surface::Offset { .. } => "offset",
        }
    }
}

/// The unit vector along `su x sv`, unless these are parallel to rounding.
pub(super) fn unit_normal(su: DVec3, sv: DVec3) -> Option<DVec3> {
    let n = su.cross(sv);
    if n.length() > 1e-12 * su.length() * sv.length() { n.try_normalize() } else { None }
}

/// Point and first derivatives of an offset, by the equations of Weingarten.
fn offset_jet(base: &Surface, distance: f64, u: f64, v: f64) -> [DVec3; 3] {
    let [s, su, sv, suu, suv, svv] = base.jet(u, v);
    let n = su.cross(sv);
    let size = n.length();
    if !(size > 0.0) {
        return [s, su, sv];
    }
    let unit = n / size;
    let turn = |d: DVec3| (d - unit * d.dot(unit)) / size;
    let nu = turn(suu.cross(sv) + su.cross(suv));
    let nv = turn(suv.cross(sv) + su.cross(svv));
    [s + distance * unit, su + distance * nu, sv + distance * nv]
}

#[cfg(test)]
mod tests;
