//! Places far narrower than the size: triangles there are as good as elsewhere, and elsewhere they are as large as before.

use std::f64::consts::PI;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::{Placement, Primitive, Solid, Tpms};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{MeshOptions, Meshed, Part, SizeRequest, mesh_part};
use rvachev::quality::Check;

fn made(solid: Solid, size: f64) -> (TriMesh, Check) {
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let Meshed { mesh, report, .. } = mesh_part(&Part::from_solid(solid), &options, &Run::new()).unwrap();
    assert_eq!((report.method, report.shortfalls), ("leaf", Vec::new()));
    let c = report.check.unwrap();
    assert!(c.certificate.is_sound(), "{:?}", c.certificate);
    (mesh, c)
}

fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> Solid {
    Solid::cuboid(lo.into(), hi.into())
}

fn ball(r: f64, at: [f64; 3]) -> Solid {
    Solid::sphere(r, at.into())
}

fn on(c: &Check, face: &str) -> usize {
    c.groups.iter().filter(|g| g.name == face).map(|g| g.triangles).sum()
}

#[test]
fn strips_down_to_a_fortieth_of_the_size_are_rows_of_good_triangles() {
    for width in [0.012, 0.006, 0.003] {
        // A strip along one edge of a cube's top.
        let step = cuboid([-1.0, -1.0, 0.5], [1.0 - width, 1.0, 0.8]);
        let (_, c) = made(cuboid([-1.0; 3], [1.0, 1.0, 0.5]) | step, 0.1);
        assert!(
            abs_diff_eq!(c.volume.unwrap(), 6.0 + 0.6 * (2.0 - width), epsilon = 1e-12),
            "{width}: {}",
            c.volume.unwrap()
        );
        // Of the narrowest a few triangles at its ends are less good.
        let least = if width < 0.005 { 20.0 } else { 27.0 };
        assert!(c.quality.min_angle > least && c.quality.p05_angle > 42.0, "{width}: {:?}", c.quality);
        // Far from it nothing changes: four triangles where two edges of the size would make one, at most.
        let fine = on(&c, "box1.xmin");
        assert!(fine < 1200, "{width}: {fine}");
    }
}

#[test]
fn corners_that_are_cut_off_and_corners_close_to_an_edge_are_surrounded_by_small_triangles() {
    let cube = || cuboid([-1.0; 3], [1.0; 3]);
    for cut in [0.02, 0.005] {
        let at = DVec3::splat(1.0 - cut / 3.0);
        let (_, c) = made(cube() & Solid::half_space(DVec3::ONE, at), 0.1);
        assert!(
            abs_diff_eq!(c.volume.unwrap(), 8.0 - cut.powi(3) / 6.0, epsilon = 1e-12),
            "{cut}: {}",
            c.volume.unwrap()
        );
        assert!(c.quality.min_angle > 27.0, "{cut}: {:?}", c.quality);
    }
    for gap in [0.02, 0.005] {
        // A square hole that stands on its corner, next to the side of the cube.
        let hole = cuboid([-0.2, -0.2, -2.0], [0.2, 0.2, 2.0]);
        let shift = DVec3::new(1.0 - gap - 0.2 * 2f64.sqrt(), 0.03, 0.0);
        let rotation = DMat3::from_rotation_z(0.25 * PI);
        let (_, c) = made(cube() - hole.placed(Placement { rotation, scale: 1.0, shift }), 0.1);
        assert!(abs_diff_eq!(c.volume.unwrap(), 8.0 - 0.32, epsilon = 1e-12), "{gap}: {}", c.volume.unwrap());
        assert!(c.quality.min_angle > 27.0, "{gap}: {:?}", c.quality);
    }
}

#[test]
fn small_rims_of_flat_faces_are_round() {
    // The faces beside the rim hardly bend: a flat lens as wide as the size is.
    let (r, size) = (0.1, 0.2);
    let flat = (1.0f64 - r * r).sqrt();
    let (_, c) = made(ball(1.0, [0.0; 3]) & Solid::half_space(-DVec3::Z, DVec3::Z * flat), size);
    let disc: f64 = c.groups.iter().filter(|g| !g.name.starts_with("sphere")).map(|g| g.area).sum();
    assert!(disc > 0.97 * PI * r * r && disc < PI * r * r, "{disc}");
}

#[test]
fn low_caps_and_shallow_dents_have_their_faces() {
    let area = |c: &Check, face: &str| c.groups.iter().filter(|g| g.name == face).map(|g| g.area).sum::<f64>();
    let near = |is: f64, true_area: f64| assert_abs_diff_eq!(is, true_area, epsilon = 0.05 * true_area);
    // A disc a size wide, a fortieth of it above which the ball would go on.
    let (_, c) = made(ball(1.0, [0.0; 3]) & Solid::half_space(DVec3::Z, DVec3::Z * 0.995), 0.2);
    near(area(&c, "half_space1"), PI * (1.0 - 0.995f64.powi(2)));
    for depth in [0.01, 0.002] {
        let dented = cuboid([-1.0, -0.5, -0.5], [1.0, 0.5, 0.5]) - ball(0.6, [-0.5, 0.1, 1.1 - depth]);
        let (_, c) = made(dented, 0.2);
        near(area(&c, "sphere1"), 2.0 * PI * 0.6 * depth);
        assert!(c.quality.min_angle > 30.0, "{depth}: {:?}", c.quality);
    }
}

#[test]
fn faces_too_small_for_all_cells_are_named() {
    let solid = ball(1.0, [0.0; 3]) & Solid::half_space(DVec3::Z, DVec3::Z * 0.9999999);
    let options = MeshOptions { size: Some(SizeRequest::Length(0.2)), ..MeshOptions::default() };
    let made = mesh_part(&Part::from_solid(solid), &options, &Run::new()).unwrap();
    assert!(
        made.report.shortfalls.iter().any(|s| s.to_string().starts_with("half_space1 is smaller")),
        "{:?}",
        made.report.shortfalls
    );
}

#[test]
fn walls_that_are_thin_in_one_place_get_short_edges_there_alone() {
    // From .002 thick on one side to .058 on the other; chords of the size are .005 high.
    let (mesh, c) = made(ball(1.0, [0.0; 3]) - ball(0.97, [0.028, 0.0, 0.0]), 0.2);
    let volume = 4.0 / 3.0 * PI * (1.0 - 0.97f64.powi(3));
    assert_eq!(c.euler, 4);
    assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 0.02 * volume);
    let d = c.deviation.unwrap();
    assert!(d.inverted + d.across == 0, "{d:?}");
    let edges = |side: f64| {
        let here: Vec<f64> = (0..mesh.triangles.len())
            .filter(|&t| mesh.centroid(t).x * side > 0.8)
            .map(|t| mesh.corners(t)[0].distance(mesh.corners(t)[1]))
            .collect();
        here.iter().sum::<f64>() / here.len() as f64
    };
    assert!(edges(1.0) < 0.7 * edges(-1.0) && edges(-1.0) > 0.1, "{} {}", edges(1.0), edges(-1.0));
}

#[test]
fn what_lies_between_two_parts_of_a_face_may_vanish() {
    // The lattice's surface passes the cylinder's so closely that faces are narrower in between than edges get.
    let lattice =
        Solid::from(Primitive::Tpms { kind: Tpms::SchwarzP, period: 1.2932, thickness: 0.2, at: DVec3::ZERO });
    let (_, c) = made(lattice & Solid::cylinder(0.7, DVec3::Z, DVec3::ZERO, Some(1.4)), 0.075);
    assert!(c.quality.min_angle > 20.0, "{:?}", c.quality);
}

#[test]
fn a_row_of_fins_thinner_than_the_size_is_as_good_as_a_block() {
    // Twelve fins on a plate, flush with it: corners of all of them lie in two lines, a third of the size apart.
    let fins = (0..12).map(|i| 3.0 * f64::from(i)).map(|x| cuboid([x, 0.0, 6.0], [x + 1.0, 80.0, 36.0]));
    let plate = cuboid([0.0; 3], [120.0, 80.0, 6.0]);
    let (_, c) = made(fins.fold(plate, |s, fin| s | fin), 3.0);
    let volume = 120.0 * 80.0 * 6.0 + 12.0 * 80.0 * 30.0;
    assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-13);
    assert!(c.quality.min_angle > 30.0 && c.quality.p05_angle > 45.0, "{:?}", c.quality);
    let f = c.features.unwrap();
    // Eight of the plate and of each fin, without the two that the first fin and the plate make flush.
    assert_eq!((f.corners_found, f.corners_true), (100, 100));
}
