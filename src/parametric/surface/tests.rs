//! Formulas of surfaces against differences and closed forms.

use approx::assert_abs_diff_eq;
use proptest::prelude::*;

use super::*;
use crate::parametric::basis::Knots;
use crate::parametric::nurbs::NurbsCurve;

fn frame() -> Frame {
    Frame::new(DVec3::new(1.0, -2.0, 0.5), DVec3::new(0.3, 1.0, 0.5), Some(DVec3::X))
}

fn arc() -> Curve {
    let p = [DVec3::new(1.0, 0.0, 0.0), DVec3::new(2.0, 0.5, 1.0), DVec3::new(1.5, 0.0, 2.0)];
    Curve::Nurbs(NurbsCurve::bezier(&p, Some(&[1.0, 0.7, 1.2])).unwrap())
}

/// One of every kind, with a part of its domain.
fn all() -> Vec<(Surface, [[f64; 2]; 2])> {
    let f = frame();
    let net: Vec<DVec3> =
        (0..16).map(|k| DVec3::new(f64::from(k / 4), f64::from(k % 4), (f64::from(k) * 1.7).sin())).collect();
    let k = || Knots::uniform(3, 4).unwrap();
    let nurbs = Surface::Nurbs(NurbsSurface::new(k(), k(), &net, None).unwrap());
    let other = Curve::segment(DVec3::new(0.0, 3.0, 0.0), DVec3::new(1.0, 3.0, 2.0));
    vec![
        (Surface::Plane { frame: f }, [[-1.0, 2.0], [-1.0, 1.0]]),
        (Surface::Cylinder { frame: f, radius: 2.0 }, [[0.0, TAU], [-1.0, 1.0]]),
        (Surface::Cone { frame: f, radius: 1.0, slope: 0.7 }, [[0.0, TAU], [-1.0, 2.0]]),
        (Surface::Sphere { frame: f, radius: 2.0 }, [[0.0, TAU], [-1.5, 1.5]]),
        (Surface::Torus { frame: f, major: 3.0, minor: 1.0 }, [[0.0, TAU], [0.0, TAU]]),
        (Surface::Torus { frame: f, major: 0.5, minor: 1.0 }, [[0.0, TAU], [-1.5, 1.5]]),
        (Surface::Extrusion { curve: arc(), direction: DVec3::new(0.0, 2.0, 1.0) }, [[0.0, 1.0], [-1.0, 1.0]]),
        (Surface::Revolution { curve: arc(), frame: Frame::WORLD }, [[0.0, TAU], [0.0, 1.0]]),
        (Surface::Ruled { curves: Box::new([arc(), other]), ranges: [[0.0, 1.0], [0.0, 1.0]] }, [[0.0, 1.0]; 2]),
        (nurbs.clone(), [[0.0, 1.0]; 2]),
        (Surface::Offset { base: Box::new(nurbs), distance: 0.1 }, [[0.1, 0.9]; 2]),
    ]
}

proptest! {
    #[test]
    fn derivatives_agree_with_differences_and_motion_with_the_moved(k in 0usize..11, s in 0.02f64..0.98, t in 0.02f64..0.98) {
        let (f, [u, v]) = all().swap_remove(k);
        let (u, v) = (u[0] + s * (u[1] - u[0]), v[0] + t * (v[1] - v[0]));
        let e = 1e-5;
        let [_, su, sv, suu, suv, svv] = f.jet(u, v);
        let (a, b, c, d) = (f.jet(u - e, v), f.jet(u + e, v), f.jet(u, v - e), f.jet(u, v + e));
        let half = 0.5 / e;
        prop_assert!(((b[0] - a[0]) * half).distance(su) < 1e-5 && ((d[0] - c[0]) * half).distance(sv) < 1e-5);
        prop_assert!(((b[1] - a[1]) * half).distance(suu) < 1e-3);
        prop_assert!(((b[2] - a[2]) * half).distance(suv) < 1e-3);
        prop_assert!(((d[2] - c[2]) * half).distance(svv) < 1e-3);
        let m = Similarity { scale: 2.0, rotation: frame().axes, translation: DVec3::Y };
        // Parameters that are lengths grow with the scale.
        let length = |axis: usize| match (&f, axis) {
            (Surface::Plane { .. }, _) | (Surface::Cylinder { .. } | Surface::Cone { .. }, 1) => 2.0,
            _ => 1.0,
        };
        let moved = f.moved(&m).at(DVec2::new(length(0) * u, length(1) * v));
        prop_assert!(moved.distance(m.point(f.at(DVec2::new(u, v)))) < 1e-10);
    }

    #[test]
    fn feet_are_where_the_normal_starts(k in 0usize..6, s in 0.02f64..0.98, t in 0.02f64..0.98, off in -0.3f64..0.3) {
        let (f, [u, v]) = all().swap_remove(k);
        let uv = DVec2::new(u[0] + s * (u[1] - u[0]), v[0] + t * (v[1] - v[0]));
        let n = f.normal(uv).unwrap();
        let foot = f.foot(f.at(uv) + off * n).unwrap();
        prop_assert!(f.at(foot).distance(f.at(uv)) < 1e-9, "{foot} {uv}");
    }
}

proptest! {
    #[test]
    fn feet_without_parameters_are_those_with(k in 0usize..5, p in prop::array::uniform3(-4.0f64..4.0)) {
        let (f, p) = (&all()[k].0, DVec3::from_array(p));
        if let Some((q, n)) = f.nearest(p) {
            let uv = f.foot(p).unwrap();
            prop_assert!(f.at(uv).distance(q) < 1e-12, "{} {}", f.at(uv), q);
            prop_assert!(f.normal(uv).unwrap().distance(n) < 1e-9);
        } else {
            // Only the other half of a cone has no answer here.
            let cone = matches!(f, Surface::Cone { .. });
            prop_assert!(cone);
        }
    }
}

#[test]
fn curvatures_are_those_of_the_books() {
    let at = |f: &Surface, u: f64, v: f64| f.curvature(DVec2::new(u, v)).unwrap();
    let list = all();
    assert_eq!(at(&list[0].0, 0.3, 0.2), 0.0);
    assert_abs_diff_eq!(at(&list[1].0, 0.3, 0.2), 0.5, epsilon = 1e-12);
    assert_abs_diff_eq!(at(&list[3].0, 0.3, 0.2), 0.5, epsilon = 1e-12);
    // Outer and inner equator of the torus: both have the tube's curvature as the larger one.
    assert_abs_diff_eq!(at(&list[4].0, 0.3, 0.0), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(at(&list[4].0, 0.3, PI), 1.0, epsilon = 1e-12);
    // A cone of radius rho: cos of its half angle over rho.
    let (rho, half) = (1.0 + 0.7 * 0.5, 0.7f64.atan());
    assert_abs_diff_eq!(at(&list[2].0, 1.0, 0.5), half.cos() / rho, epsilon = 1e-12);
}

#[test]
fn periods_and_poles_are_found() {
    let list = all();
    let periods: Vec<[bool; 2]> = list.iter().map(|f| f.0.periods().map(|p| p.is_some())).collect();
    let (no, u, both) = ([false; 2], [true, false], [true; 2]);
    assert_eq!(periods, [no, u, u, u, both, u, no, u, no, no, no]);
    let poles: Vec<usize> = list.iter().map(|f| f.0.poles().len()).collect();
    assert_eq!(poles, [0, 0, 1, 2, 0, 2, 0, 0, 0, 0, 0]);
    for (f, _) in &list {
        for p in f.poles() {
            for k in 0..4 {
                let mut uv = DVec2::splat(f64::from(k));
                uv[p.axis] = p.value;
                assert!(f.at(uv).distance(p.point) < 1e-12);
            }
        }
    }
    // A profile that starts on the axis, and a closed one.
    let dome = Curve::Nurbs(NurbsCurve::polyline(&[DVec3::Z, DVec3::X + DVec3::Z, DVec3::X]).unwrap());
    let s = Surface::Revolution { curve: dome, frame: Frame::WORLD };
    assert_eq!(s.poles(), [Pole { axis: 1, value: 0.0, point: DVec3::Z }]);
    let ring = Frame::new(3.0 * DVec3::X, DVec3::Y, None);
    let s = Surface::Revolution { curve: Curve::circle(ring, 1.0), frame: Frame::WORLD };
    assert!(s.periods()[1].is_some_and(|p| (p - TAU).abs() < 1e-12) && s.poles().is_empty());
}
