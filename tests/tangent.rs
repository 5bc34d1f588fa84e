//! Surfaces that touch along a curve, as pins with rounded ends, slots and bends of pipes have them: known volumes, cells of the size
//! asked for, and no edges where there are none.

use std::f64::consts::PI;

use approx::relative_eq;
use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::pipeline::{MeshOptions, mesh_part};
use rvachev::quality::Check;

fn made(text: &str) -> Check {
    let m = mesh_part(&parse(text, &[]).unwrap(), &MeshOptions::default(), &Run::new()).unwrap();
    assert_eq!((m.report.method, &m.report.shortfalls), ("leaf", &Vec::new()), "{text}");
    // Cells may be made smaller where a border goes astray, not everywhere.
    assert!(m.report.attempts.len() <= 2, "{text}");
    let c = m.report.check.unwrap();
    assert!(c.certificate.is_sound(), "{text}: {:?}", c.certificate);
    let f = c.features.as_ref().unwrap();
    assert!(f.recall >= 0.99 && f.precision >= 0.97 && f.corners_found == f.corners_true, "{text}: {f:?}");
    c
}

fn near(volume: Option<f64>, truth: f64, text: &str) {
    let volume = volume.unwrap();
    assert!(relative_eq!(volume, truth, epsilon = 0.0, max_relative = 1e-2), "{text}: {volume} {truth}");
}

/// A ball at each end of a cylinder of its radius, along axes and not.
#[test]
fn a_pin_with_round_ends_has_no_edge() {
    for axis in ["(0, 0, 1)", "(1, 2, 3)", "(-0.3, 0.1, 0.9)"] {
        let text = format!(
            "a = {axis}\nn = sqrt(sum(c * c for c in a))\n\
             end = [tuple(s * c / n for c in a) for s in (-2, 2)]\n\
             part((cylinder(1, axis=a, height=4) | union(sphere(1, at=p) for p in end)).name('pin'))\nmesh(size=0.25)\n"
        );
        let c = made(&text);
        near(c.volume, 4.0 * PI + 4.0 / 3.0 * PI, &text);
        assert_eq!(c.euler, 2, "{text}");
        assert!(c.features.unwrap().length_true == 0.0, "{text}");
        assert!(c.quality.min_angle > 25.0, "{text}: {}", c.quality.min_angle);
    }
}

/// The same by formulas of the user's own, of which nothing is known but their values.
#[test]
fn a_pin_by_formulas_is_as_good() {
    let text = "r = 1 - x*x - y*y\n\
                side = solid(r >= 0) & solid(z >= -1) & solid(z <= 1)\n\
                part((side | solid(r - (z - 1)**2 >= 0) | solid(r - (z + 1)**2 >= 0)).name('pin'), \
                domain=((-2, -2, -3), (2, 2, 3)))\nmesh(size=0.2)\n";
    near(made(text).volume, 2.0 * PI + 4.0 / 3.0 * PI, text);
}

/// Half cylinders at both ends of a box, as a solid and as a hole.
#[test]
fn a_slot_is_round_at_its_ends() {
    let slot = |h: f64| {
        format!(
            "box(lo=(-2, -1, {}), hi=(2, 1, {h})) | union(cylinder(1, at=(s, 0, 0), height={}) for s in (-2, 2))",
            -h,
            2.0 * h
        )
    };
    let area = 8.0 + PI;
    let text = format!("part(({}).name('slot'))\nmesh(size=0.25)\n", slot(0.5));
    let c = made(&text);
    near(c.volume, area, &text);
    assert!(c.quality.min_angle > 20.0, "{}", c.quality.min_angle);
    let text = format!("part(box(size=(8, 6, 1)).name('plate') - ({}).name('slot'))\nmesh(size=0.35)\n", slot(1.0));
    let c = made(&text);
    near(c.volume, 48.0 - area, &text);
    assert_eq!(c.euler, 0);
}

/// A quarter of a torus between two cylinders.
#[test]
fn a_bend_goes_over_into_straight_pipe() {
    let text = "def pipe(r):\n    return (torus(3, r, axis='z') & half_space((-1, 0, 0)) & half_space((0, -1, 0)) \
                | cylinder(r, axis='y', at=(3, -1.5, 0), height=3) | cylinder(r, axis='x', at=(-1.5, 3, 0), height=3))\n\
                part(pipe(1).name('outside') - pipe(0.8).name('inside'))\nmesh(size=0.35)\n";
    let c = made(text);
    near(c.volume, PI * 0.36 * (6.0 + 1.5 * PI), text);
    assert_eq!(c.euler, 0);
}

/// A rim by hand: a torus around a disc of its height, and a cone with a ball at its tip that touches it.
#[test]
fn rounds_by_hand_are_smooth() {
    let text = "part((cylinder(2, height=1) | torus(2, 0.5)).name('puck'))\nmesh(size=0.25)\n";
    // Half of the tube, by Pappus.
    let rim = PI * PI * 0.25 * 2.0 + 4.0 / 3.0 * PI * 0.125;
    near(made(text).volume, 4.0 * PI + rim, text);
    let text = "part((cone(1, 0.5, 3, at=(0, 0, 1.5)) | sphere(0.5 * sqrt(1 + 1 / 36), at=(0, 0, 3 + 0.5 / 6))).name('tip'))\n\
                mesh(size=0.2)\n";
    let r: f64 = 0.5 * (1.0 + 1.0f64 / 36.0).sqrt();
    // A frustum, and the ball above the plane in which it ends.
    let h = r + 0.5 / 6.0;
    near(made(text).volume, PI * 3.0 / 3.0 * 1.75 + PI * h * h * (3.0 * r - h) / 3.0, text);
}

/// Heights by a root, whose surface goes over into the wall where the root ends.
#[test]
fn a_dome_goes_over_into_its_wall() {
    for floor in [-1.0, 0.0, 0.5] {
        let text = format!(
            "part(solid(z <= sqrt(4 - x*x - y*y)).name('dome') & solid(z >= {floor}).name('floor'), \
             domain=((-3, -3, -3), (3, 3, 3)))\nmesh(size=0.3)\n"
        );
        let h: f64 = 2.0 - f64::max(floor, 0.0);
        near(made(&text).volume, PI * h * h * (6.0 - h) / 3.0 + 4.0 * PI * f64::max(-floor, 0.0), &text);
    }
}
