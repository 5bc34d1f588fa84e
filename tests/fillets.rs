//! Blends of solids with edges: every edge of the two and of the fillet between them is there, at any size.

use std::f64::consts::PI;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::{Placement, Primitive, Solid};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{MeshOptions, Meshed, Part, SizeRequest, mesh_part};
use rvachev::quality::Check;

fn made(solid: Solid, size: f64) -> Meshed {
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    mesh_part(&Part::from_solid(solid), &options, &Run::new()).unwrap()
}

/// A mesh with nothing to report, all edges and corners in it, and triangles to compute on.
fn exact(solid: Solid, size: f64) -> Check {
    let made = made(solid, size);
    let report = made.report;
    assert_eq!((report.shortfalls, report.warnings), (Vec::new(), Vec::new()), "at {size}");
    let c = report.check.unwrap();
    assert!(c.certificate.is_sound(), "{:?}", c.certificate);
    let (f, d) = (c.features.unwrap(), c.deviation.unwrap());
    // Beside the end of an edge that runs out in a tangent it is a matter of degrees whether it is still sharp.
    assert!(f.recall >= 0.98 && f.precision >= 0.95, "{f:?} at {size}");
    assert_eq!(f.corners_found, f.corners_true);
    assert!(f.node_residual_max <= 1e-12, "{f:?}");
    assert!(d.inverted == 0 && d.max < 0.05 * size && d.from_surface.unwrap() < 0.05 * size, "{d:?} at {size}");
    assert!(c.quality.min_angle >= 25.0 && c.quality.p05_angle >= 43.0, "{:?} at {size}", c.quality);
    c
}

/// The same of a solid whose fillets end on sharp edges all along, where a few triangles are less good.
fn exact_at_degenerate_ends(solid: Solid, size: f64) -> Check {
    let report = made(solid, size).report;
    assert_eq!((report.shortfalls, report.warnings), (Vec::new(), Vec::new()), "at {size}");
    let c = report.check.unwrap();
    let f = c.features.unwrap();
    assert!(c.certificate.is_sound() && f.recall >= 0.98 && f.precision >= 0.95, "{f:?} at {size}");
    assert_eq!(f.corners_found, f.corners_true);
    assert!(c.quality.below_20 < 0.0005 && c.quality.p05_angle >= 43.0, "{:?} at {size}", c.quality);
    c
}

fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> Solid {
    Solid::cuboid(lo.into(), hi.into())
}

fn plate() -> Solid {
    cuboid([-1.0, -1.0, -0.2], [1.0, 1.0, 0.2])
}

fn bar(r: f64, axis: DVec3, at: [f64; 3], height: f64) -> Solid {
    Solid::cylinder(r, axis, at.into(), Some(height))
}

fn turned(solid: Solid) -> Solid {
    let rotation = DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), 0.7);
    solid.placed(Placement { rotation, scale: 1.3, shift: DVec3::new(0.01, 0.02, 0.03) })
}

/// The area of a face.
fn area(mesh: &TriMesh, name: &str) -> f64 {
    let face = mesh.faces.iter().position(|f| f == name).unwrap() as u32;
    let own = (0..mesh.triangles.len()).filter(|&t| mesh.labels[t] == face);
    own.map(|t| 0.5 * mesh.area_vector(t).length()).sum()
}

/// The volume of a square post of half the side `w` and a height, with a fillet around its foot: at height u of it the section is a
/// square of half the side w + r - sqrt(r^2 - u^2).
fn on_square(w: f64, r: f64, height: f64) -> f64 {
    let (one, two) = (r * r * (1.0 - 0.25 * PI), r * r * r * (5.0 / 3.0 - 0.5 * PI));
    4.0 * w * w * height + 4.0 * (2.0 * w * one + two)
}

#[test]
fn a_boss_on_a_plate_keeps_its_rims_and_their_names() {
    let (radius, r) = (0.35, 0.12);
    let solid = plate().name("plate").blend(bar(radius, DVec3::Z, [0.0, 0.0, 0.35], 0.7).name("boss"), r);
    // The function of a cylinder is linear in the square of the distance from its axis, and so is the section's area in it.
    let volume = 1.6 + PI * radius * radius * 0.5 + 2.0 * PI * radius * r * r * (1.0 - 0.25 * PI);
    for size in [0.2, 0.1, 0.05] {
        let c = exact(solid.clone(), size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 8));
        assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 0.5 * size * size);
        let c = exact(turned(solid.clone()), 1.3 * size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 8));
    }
    let mesh = made(solid, 0.1).mesh;
    let area = |name: &str| area(&mesh, name);
    assert_abs_diff_eq!(area("boss.top"), PI * radius * radius, epsilon = 4e-3);
    // The fillet begins where the function of the cylinder is -r: at the square of this radius.
    let foot = radius * radius + 2.0 * radius * r;
    assert_abs_diff_eq!(area("plate.zmax"), 4.0 - PI * foot, epsilon = 2e-3);
    assert_abs_diff_eq!(area("boss.side"), 2.0 * PI * radius * (0.5 - r), epsilon = 5e-3);
    assert_abs_diff_eq!(area("plate.zmin"), 4.0, epsilon = 1e-9);
    assert!(area("blend1") > 0.1);
}

#[test]
fn fillets_meet_in_mitres_that_run_out_in_the_plate() {
    let (w, r) = (0.4, 0.15);
    let boss = || cuboid([-w, -w, 0.0], [w, w, 0.9]);
    let tool = bar(0.2, DVec3::Z, [0.0; 3], 4.0);
    let volume = 1.6 + on_square(w, r, 0.7);
    for size in [0.2, 0.157, 0.13, 0.094, 0.078, 0.06, 0.04] {
        let c = exact(plate().blend(boss(), r), size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 20), "at {size}");
        assert!(
            abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 0.2 * size * size),
            "{} {volume} at {size}",
            c.volume.unwrap()
        );
        let c = exact(turned(plate().blend(boss(), r) - tool.clone()), 1.3 * size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (0, 20), "turned, at {size}");
    }
}

#[test]
fn fillets_of_pockets_and_of_blends_are_exact() {
    let pocket = cuboid([-0.5, -0.4, 0.0], [0.5, 0.4, 1.0]).blend(bar(0.3, DVec3::Z, [0.5, 0.0, 0.6], 1.2), 0.1);
    let deep = cuboid([-1.0, -1.0, -0.3], [1.0, 1.0, 0.3]) - pocket;
    let arm = bar(0.4, DVec3::Z, [0.0; 3], 0.6).blend(cuboid([0.0, -0.15, -0.15], [1.6, 0.15, 0.15]), 0.08);
    let lever = arm.blend(bar(0.3, DVec3::Z, [1.6, 0.0, 0.0], 0.4), 0.08)
        - bar(0.2, DVec3::Z, [0.0; 3], 2.0)
        - bar(0.15, DVec3::Z, [1.6, 0.0, 0.0], 2.0);
    let tee = bar(0.4, DVec3::X, [0.0; 3], 3.0).blend(bar(0.3, DVec3::Z, [0.0, 0.0, 0.7], 1.4), 0.1)
        - bar(0.3, DVec3::X, [0.0; 3], 4.0)
        - bar(0.2, DVec3::Z, [0.0, 0.0, 0.8], 1.6);
    for (solid, size, euler) in [(deep, 0.06, 2), (lever, 0.05, -2), (tee, 0.06, -2)] {
        assert_eq!(exact(solid, size).euler, euler);
    }
}

#[test]
fn bosses_blended_one_after_the_other_keep_all_their_edges() {
    // Each blend is one of all before it: pairs of leaves are many, those near each other few.
    let cube = cuboid([-1.0; 3], [1.0; 3]);
    let bosses = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]].map(DVec3::from);
    let cube = bosses.iter().fold(cube, |s, at| s.blend(Solid::cuboid(at - 0.5, at + 0.5), 0.1));
    // Chords of four rings of fillets.
    let volume = 8.0 + 4.0 * on_square(0.5, 0.1, 0.5);
    for size in [0.2, 0.1] {
        let c = exact(cube.clone(), size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 8 + 4 * 12));
        assert!(
            abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 0.8 * size * size),
            "{} {volume} at {size}",
            c.volume.unwrap()
        );
    }
}

#[test]
fn fillets_much_smaller_than_the_size_come_out_at_once() {
    // Down to a 150th of the size. The volume is that of the union but for chords, and what a fillet adds along about four lengths.
    let ball = || Solid::from(Primitive::Sphere { r: 0.98, at: DVec3::ZERO });
    let cube = || cuboid([0.3, 0.4, -0.35], [1.5, 1.6, 0.85]);
    let union = made(ball() | cube(), 0.1).report.check.unwrap().volume.unwrap();
    for radius in [0.1, 0.02, 0.01, 0.003] {
        let report = made(ball().blend(cube(), radius), 0.45).report;
        // The smallest crosses a triangle where it ends in the cube's corner: cells are smaller there once.
        let most = if radius < 0.01 { 2 } else { 1 };
        assert!(report.shortfalls.is_empty() && report.attempts.len() <= most, "{radius}: {:?}", report.attempts);
        let c = report.check.unwrap();
        assert!(c.certificate.is_sound() && c.features.unwrap().recall >= 0.98, "{c:?}");
        let volume = c.volume.unwrap();
        assert!(abs_diff_eq!(volume, union, epsilon = 0.05 + 4.0 * radius * radius), "{volume} {union} at {radius}");
    }
}

#[test]
fn two_smooth_solids_blend_into_one_smooth_face() {
    let ball = |z: f64| Solid::from(Primitive::Sphere { r: 1.0, at: DVec3::Z * z });
    let smooth = made(ball(0.0).blend(ball(1.2), 0.3), 0.08);
    assert_eq!((smooth.report.warnings, smooth.report.shortfalls), (Vec::new(), Vec::new()));
    assert_eq!(smooth.mesh.faces, ["blend1"]);
}

#[test]
fn walls_that_end_where_a_fillet_begins_are_one_surface() {
    // The faces of the wall are one radius from those of the plate: a fillet touches the latter everywhere, and has none of them.
    let solid = plate().blend(cuboid([-0.9, -0.9, 0.0], [0.9, 0.9, 0.7]), 0.1);
    let c = exact_at_degenerate_ends(solid.clone(), 0.1);
    assert_eq!(c.euler, 2);
    assert_abs_diff_eq!(c.volume.unwrap(), 1.6 + on_square(0.9, 0.1, 0.5), epsilon = 2e-3);
    let mesh = made(solid, 0.1).mesh;
    for name in ["box1.xmin", "box1.xmax", "box1.ymin", "box1.ymax"] {
        assert!(abs_diff_eq!(area(&mesh, name), 0.8, epsilon = 1e-9), "{name}: {}", area(&mesh, name));
    }
}

#[test]
fn solids_without_end_blend_too() {
    // A wall and a rod that both go on for ever, cut by a box.
    let wall = Solid::half_space(DVec3::Z, DVec3::ZERO);
    let rod = Solid::cylinder(0.3, DVec3::Z, DVec3::ZERO, None) & Solid::half_space(DVec3::Z, DVec3::Z * 0.6);
    let c = exact(wall.blend(rod, 0.1) & cuboid([-1.0, -1.0, -0.5], [1.0, 1.0, 1.0]), 0.08);
    let volume = 2.0 + PI * 0.09 * 0.6 + 2.0 * PI * 0.3 * 0.01 * (1.0 - 0.25 * PI);
    assert_eq!(c.euler, 2);
    assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 2e-3);
}

#[test]
fn sharp_rims_elsewhere_are_as_sharp_beside_fillets() {
    let (radius, r, h) = (0.35, 0.12, 0.02);
    let boss = plate().blend(bar(radius, DVec3::Z, [0.0, 0.0, 0.35], 0.7), r);
    // Two caps of height h, which meet at 23 degrees; near the tip nothing is as thick as the cells.
    let ball = |z: f64| Solid::sphere(1.0, DVec3::new(0.1, 0.2, z));
    let lens = ball(2.0 - h) & ball(h);
    let volume = 1.6
        + PI * radius * radius * 0.5
        + 2.0 * PI * radius * r * r * (1.0 - 0.25 * PI)
        + 2.0 * PI * h * h * (1.0 - h / 3.0);
    for size in [0.15, 0.1] {
        let made = made(boss.clone() | lens.clone(), size);
        assert_eq!(made.report.shortfalls, Vec::new(), "at {size}");
        let c = made.report.check.unwrap();
        assert!(c.certificate.is_sound(), "{:?}", c.certificate);
        let (f, d) = (c.features.unwrap(), c.deviation.unwrap());
        assert!(f.recall >= 0.95 && f.node_residual_max <= 1e-12, "{f:?} at {size}");
        assert!(d.inverted == 0 && d.from_surface.unwrap() < 0.05 * size, "{d:?} at {size}");
        assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 0.5 * size * size);
        assert_eq!(c.euler, 4);
    }
}

#[test]
fn a_fillet_that_ends_in_a_slanted_face_needs_one_attempt() {
    // Near the line where the fillet ends in the block's upper face, interpolants of the fillet dip below that face, here and there.
    let block = cuboid([-1.0, 0.0, -1.0], [1.0, 1.75, 1.5]).name("block");
    let (half, at) = (DVec3::new(0.91, 0.37, 0.46), DVec3::new(0.47, 1.4, -0.19));
    let rotation = DMat3::from_rotation_x(17f64.to_radians());
    let bar = Solid::cuboid(at - half, at + half).placed(Placement { rotation, ..Placement::IDENTITY });
    for size in [0.2, 0.3, 0.4, 0.55, 0.6] {
        let report = made(block.clone().blend(bar.clone(), 0.1), size).report;
        assert_eq!((report.shortfalls, report.warnings), (Vec::new(), Vec::new()), "at {size}");
        assert_eq!(report.attempts.len(), 1, "at {size}: {:?}", report.attempts);
        assert!(report.check.unwrap().certificate.is_sound(), "at {size}");
    }
}
