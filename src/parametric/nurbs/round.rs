//! Elementary and swept surfaces as NURBS: planes, what turns around an axis, and extrusions (\[KUZ19\] 45, 55; figures 12, 13).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, DVec4};

use super::{NurbsCurve, NurbsSurface};
use crate::error::{Error, Place, Result};
use crate::numeric::ROUNDING;
use crate::parametric::basis::Knots;
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;
use crate::parametric::surface::Surface;

/// The curve turned around the z axis from the angle `a` to `b`: a rational quadratic for each quarter (L. Piegl, W. Tiller, "The
/// NURBS Book", 8.5). Along u it turns, v is the curve's parameter; u runs over 0..=1.
fn turned(profile: &NurbsCurve, [a, b]: [f64; 2]) -> Result<NurbsSurface> {
    // Ranges may be longer than a turn by a little: files and sums of angles have rounding in them.
    let parts = ((b - a) / (0.5 * PI) - ROUNDING).ceil().max(1.0);
    let half = 0.5 * (b - a) / parts;
    let mut points = Vec::new();
    let mut knots = vec![0.0; 3];
    for i in 0..=2 * parts as usize {
        // Every other control point is where the tangents of its neighbors meet.
        let w = if i % 2 == 1 { half.cos() } else { 1.0 };
        let (s, c) = (a + half * i as f64).sin_cos();
        points.extend(
            profile.weighted().iter().map(|p| DVec4::new(p.x * c - p.y * s, p.x * s + p.y * c, p.z * w, p.w * w)),
        );
        if i % 2 == 0 && i > 0 {
            knots.extend([0.5 * i as f64 / parts; 2]);
        }
    }
    knots.push(1.0);
    let u = Knots::new(2, knots, 2 * parts as usize + 1)?;
    NurbsSurface::from_weighted(u, profile.knots.clone(), &points)
}

impl Surface {
    /// The part of the surface over the ranges of `u` and `v` as NURBS over 0..=1 both ways, exact to rounding. Angles are in
    /// radians. Lines of constant u and of constant v stay such lines; along angles the parameter runs at another pace.
    ///
    /// *Guarantees*: every point is a point of the surface, and the ends of the ranges are the borders.
    /// *Does not guarantee*: the least number of control points.
    /// *Errors*: [`Error::Input`] for ranges that are not finite and ascending or longer than a turn of an angle, and for surfaces
    /// without an exact form; families, shifts and ruled surfaces have one as a whole only.
    pub fn part_to_nurbs(&self, u: [f64; 2], v: [f64; 2]) -> Result<NurbsSurface> {
        let wrong = |what: &str| Err(Error::input(Place::Item(self.kind().into()), what));
        if ![u, v].iter().all(|[a, b]| a.is_finite() && b.is_finite() && a < b) {
            return wrong("a part of a surface needs finite ranges that ascend");
        }
        let upright = |origin: DVec3| Frame::new(origin, DVec3::NEG_Y, Some(DVec3::X));
        let straight = |radius: &dyn Fn(f64) -> f64| Curve::segment(at(radius(v[0]), v[0]), at(radius(v[1]), v[1]));
        let (profile, range, frame) = match self {
            Surface::Plane { .. } => {
                let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| self.at(DVec2::new(u[i], v[j])));
                return NurbsSurface::bezier(&corners, 2, None);
            }
            Surface::Extrusion { curve, direction } => {
                let c = curve.to_nurbs(u)?;
                let both = v.map(|v| c.map(|p| p + v * *direction));
                return NurbsSurface::through(&both, &[0.0, 1.0], &[None, None]);
            }
            Surface::Nurbs(n) => {
                let inside = |r: [f64; 2], d: [f64; 2]| r[0] >= d[0] && r[1] <= d[1];
                if !inside(u, n.u.domain()) || !inside(v, n.v.domain()) {
                    return wrong("the part reaches beyond the surface");
                }
                let part = n.part(u, v)?;
                let unit = |k: &Knots| {
                    let [a, b] = k.domain();
                    Knots::new(k.degree(), k.values().iter().map(|t| (t - a) / (b - a)).collect(), k.points())
                };
                return NurbsSurface::from_weighted(unit(&part.u)?, unit(&part.v)?, part.weighted());
            }
            Surface::Cylinder { frame, radius } => (straight(&|_| *radius), [0.0, 1.0], frame),
            Surface::Cone { frame, radius, slope } => (straight(&|v| radius + slope * v), [0.0, 1.0], frame),
            Surface::Sphere { frame, radius } => (Curve::circle(upright(DVec3::ZERO), *radius), v, frame),
            Surface::Torus { frame, major, minor } => (Curve::circle(upright(at(*major, 0.0)), *minor), v, frame),
            Surface::Revolution { curve, frame } => {
                let local = curve.to_nurbs(v)?.map(|p| frame.local(p));
                (Curve::Nurbs(local), [0.0, 1.0], frame)
            }
            other if [u, v] == other.domain() => return other.to_nurbs(),
            _ => return wrong("only as a whole, over its domain, it has an exact form as NURBS"),
        };
        let around = matches!(self, Surface::Torus { .. } | Surface::Sphere { .. });
        if u[1] - u[0] > TAU + ROUNDING || around && v[1] - v[0] > TAU + ROUNDING {
            return wrong("the part is longer than a turn");
        }
        Ok(turned(&profile.to_nurbs(range)?, u)?.map(|p| frame.point(p)))
    }
}

/// A point of the plane a profile lies in.
fn at(radius: f64, height: f64) -> DVec3 {
    DVec3::new(radius, 0.0, height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parametric::nurbs::SplineEnds;

    #[test]
    fn elementary_and_swept_surfaces_become_nurbs_point_by_point() {
        let frame = Frame::new(DVec3::new(1.0, -2.0, 0.5), DVec3::new(1.0, 2.0, 3.0), None);
        let bow = [[1.0, 0.2, 0.0], [2.0, 0.0, 1.0], [1.5, -0.5, 2.0], [3.0, 0.0, 3.0]].map(|p| frame.point(p.into()));
        let curve = Curve::Nurbs(NurbsCurve::cubic(&bow, SplineEnds::Natural).unwrap());
        let bow_range = curve.domain();
        let half = [-0.5 * PI, 0.5 * PI];
        for (surface, u, v) in [
            (Surface::Plane { frame }, [-1.0, 2.0], [0.5, 3.0]),
            (Surface::Cylinder { frame, radius: 2.0 }, [0.0, TAU], [-1.0, 4.0]),
            (Surface::Cylinder { frame, radius: 2.0 }, [0.3, 1.0], [0.0, 1.0]),
            (Surface::Cone { frame, radius: 2.0, slope: -0.5 }, [1.0, 5.0], [0.0, 4.0]),
            (Surface::Sphere { frame, radius: 3.0 }, [0.0, TAU], half),
            (Surface::Torus { frame, major: 3.0, minor: 1.0 }, [0.0, TAU], [0.0, TAU]),
            (Surface::Torus { frame, major: 3.0, minor: 1.0 }, [2.0, 3.0], [4.0, 5.5]),
            (
                Surface::Extrusion { curve: Curve::circle(frame, 2.0), direction: DVec3::new(1.0, 0.0, 2.0) },
                [0.0, 3.0],
                [-1.0, 1.0],
            ),
            (Surface::Revolution { curve, frame }, [0.5, 4.0], bow_range),
        ] {
            let n = surface.part_to_nurbs(u, v).unwrap();
            assert_eq!([n.u.domain(), n.v.domain()], [[0.0, 1.0]; 2]);
            let share = |[a, b]: [f64; 2], t: f64| a + (b - a) * t;
            for i in 0..40 {
                for j in 0..25 {
                    let (s, t) = (f64::from(i) / 39.0, f64::from(j) / 24.0);
                    let p = n.at(s, t);
                    // The point of the surface on the same lines: only along arcs the paces differ.
                    let foot = surface.foot(p).unwrap_or_else(|| foot_of_swept(&surface, p, share(v, t), share(u, s)));
                    let off = surface.at(foot).distance(p);
                    assert!(off < 1e-12, "{} {s} {t}: {off}", surface.kind());
                }
            }
            // Ends, and middles, which arcs of one, two and four quarters have in common with the angle.
            for (s, t) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5), (0.0, 0.5), (0.5, 1.0)] {
                let (p, q) = (n.at(s, t), surface.at(DVec2::new(share(u, s), share(v, t))));
                assert!(p.distance(q) < 1e-12, "{} {s} {t}: {p} {q}", surface.kind());
            }
        }
    }

    /// Parameters of a point of an extrusion of a circle, or of a revolution.
    fn foot_of_swept(surface: &Surface, p: DVec3, v: f64, near: f64) -> DVec2 {
        match surface {
            Surface::Extrusion { curve, direction } => {
                DVec2::new(curve.project(p - v * *direction, curve.domain(), Some(near)), v)
            }
            Surface::Revolution { curve, frame } => {
                let angle = |p: DVec3| Frame::angle(frame.local(p).truncate());
                DVec2::new(angle(p) - angle(curve.at(v)), v)
            }
            _ => DVec2::NAN,
        }
    }

    #[test]
    fn parts_of_nurbs_are_the_same_points_and_bad_ranges_are_refused() {
        let whole =
            Surface::Sphere { frame: Frame::WORLD, radius: 2.0 }.part_to_nurbs([0.0, 2.0], [-1.0, 1.0]).unwrap();
        let part = Surface::Nurbs(whole.clone()).part_to_nurbs([0.2, 0.7], [0.1, 0.6]).unwrap();
        for (s, t) in (0..=10).flat_map(|i| (0..=10).map(move |j| (f64::from(i) / 10.0, f64::from(j) / 10.0))) {
            assert!(part.at(s, t).distance(whole.at(0.2 + 0.5 * s, 0.1 + 0.5 * t)) < 1e-13);
        }
        let tube = Surface::Cylinder { frame: Frame::WORLD, radius: 1.0 };
        for (u, v) in [([0.0, 7.0], [0.0, 1.0]), ([1.0, 1.0], [0.0, 1.0]), ([0.0, 1.0], [0.0, f64::INFINITY])] {
            assert!(tube.part_to_nurbs(u, v).is_err());
        }
        assert!(Surface::Nurbs(whole).part_to_nurbs([0.0, 2.0], [0.0, 1.0]).is_err());
        let ruled = Surface::bilinear(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE);
        assert!(
            ruled.part_to_nurbs([0.0, 1.0], [0.0, 1.0]).is_ok() && ruled.part_to_nurbs([0.0, 0.5], [0.0, 1.0]).is_err()
        );
    }
}
