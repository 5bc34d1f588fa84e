//! Several names on one surface, and solids that touch themselves: what no cut of an extraction can tell apart.

use std::f64::consts::PI;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::implicit::{Placement, Solid};
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

fn area(c: &Check, face: &str) -> f64 {
    c.groups.iter().filter(|g| g.name == face).map(|g| g.area).sum()
}

/// A placement of no special direction, and its inverse.
fn place() -> (Placement, impl Fn(DVec3) -> DVec3) {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let (rotation, shift) = (DMat3::from_axis_angle(axis, 0.7), DVec3::new(0.01, 0.02, 0.03));
    (Placement { rotation, shift, scale: 1.0 }, move |p| rotation.transpose() * (p - shift))
}

/// Nodes on triangles of both faces.
fn between(mesh: &TriMesh, [a, b]: [&str; 2]) -> Vec<DVec3> {
    let on = |face: &str| {
        let label = mesh.faces.iter().position(|f| f == face).unwrap() as u32;
        let own = mesh.triangles.iter().zip(&mesh.labels).filter(|t| *t.1 == label);
        own.flat_map(|t| *t.0).collect::<std::collections::BTreeSet<u32>>()
    };
    on(a).intersection(&on(b)).map(|v| mesh.nodes[*v as usize]).collect()
}

#[test]
fn sides_of_two_boxes_in_one_plane_part_at_a_straight_border() {
    let plate = || cuboid([0.0, 0.0, 0.0], [2.0, 1.0, 0.3]).name("plate");
    let wall = || cuboid([0.0, 0.0, 0.0], [0.2, 1.0, 1.5]).name("wall");
    for turned in [false, true] {
        // The first operand has what both have.
        for (solid, plate_area, wall_area, height) in
            [(plate() | wall(), 0.6, 0.24, Some(0.3)), (wall() | plate(), 0.54, 0.3, None)]
        {
            let (placement, back) = place();
            let (mesh, c) = made(if turned { solid.placed(placement) } else { solid }, 0.07);
            for side in ["ymin", "ymax"] {
                assert!(
                    abs_diff_eq!(area(&c, &format!("plate.{side}")), plate_area, epsilon = 1e-12),
                    "{:?}",
                    c.groups
                );
                assert!(abs_diff_eq!(area(&c, &format!("wall.{side}")), wall_area, epsilon = 1e-12), "{:?}", c.groups);
            }
            let border = between(&mesh, ["plate.ymin", "wall.ymin"]);
            assert!(border.len() > 3);
            for p in border {
                let p = if turned { back(p) } else { p };
                match height {
                    Some(z) => assert!(p.y.abs() < 1e-13 && (p.z - z).abs() < 1e-13 && p.x < 0.2 + 1e-13, "{p}"),
                    // The wall goes down through the plate: its side in the plane ends at x = 0.2.
                    None => assert!(p.y.abs() < 1e-13 && (p.x - 0.2).abs() < 1e-13 && p.z < 0.3 + 1e-13, "{p}"),
                }
            }
            assert!(c.quality.min_angle > 30.0, "{:?}", c.quality);
        }
    }
}

#[test]
fn names_on_cylinders_and_spheres_part_where_others_end_them() {
    let (r, size) = (0.5, 0.08);
    let shank = Solid::cylinder(r, DVec3::Z, DVec3::Z, Some(2.0)).name("shank");
    let crest = Solid::cylinder(r, DVec3::Z, DVec3::Z * 2.0, Some(2.0)).name("crest");
    let (placement, back) = place();
    let (mesh, c) = made((shank | crest).placed(placement), size);
    for p in between(&mesh, ["shank.side", "crest.side"]) {
        assert!((back(p).z - 2.0).abs() < 1e-13 && (back(p).truncate().length() - r).abs() < 1e-13, "{}", back(p));
    }
    // Chords take a little of the areas.
    for (face, height) in [("shank.side", 2.0), ("crest.side", 1.0)] {
        let share = area(&c, face) / (2.0 * PI * r * height);
        assert!(share > 0.99 && share < 1.0, "{face}: {share}");
    }
    let ball = |name: &str| Solid::sphere(1.0, DVec3::ZERO).name(name);
    let half = || Solid::half_space(DVec3::new(0.2, 0.3, 1.0), DVec3::new(0.0, 0.0, 0.4)).name("cut");
    let (mesh, c) = made((ball("low") & half()) | ball("all"), 0.15);
    let normal = DVec3::new(0.2, 0.3, 1.0).normalize();
    let border = between(&mesh, ["low", "all"]);
    assert!(border.len() > 20);
    for p in border {
        assert!((normal.dot(p) - normal.z * 0.4).abs() < 1e-12 && (p.length() - 1.0).abs() < 1e-12, "{p}");
    }
    let cap = 2.0 * PI * (1.0 - normal.z * 0.4);
    assert_relative_eq!(area(&c, "all"), cap, epsilon = 0.0, max_relative = 0.01);
    assert_eq!(area(&c, "cut"), 0.0);
}

#[test]
fn solids_that_touch_along_edges_and_in_points_are_sound() {
    let box_at = |x: f64, y: f64, z: f64| cuboid([x, y, z], [x + 1.0, y + 1.0, z + 1.0]);
    let cases = [
        // Along an edge; along parts of edges; four of eight cubes, which touch along six edges and in their middle.
        vec![box_at(0.0, 0.0, 0.0), box_at(1.0, 1.0, 0.0)],
        vec![box_at(0.0, 0.0, 0.0), box_at(1.0, 1.0, 0.37)],
        vec![box_at(0.0, 0.0, 0.0), box_at(1.0, 1.0, 0.0), box_at(1.0, 0.0, 1.0), box_at(0.0, 1.0, 1.0)],
    ];
    for boxes in cases {
        let n = boxes.len();
        let solid = boxes.into_iter().reduce(|a, b| a | b).unwrap();
        let (_, c) = made(solid, 0.11);
        assert_eq!((c.components, c.euler, c.self_intersections), (n, 2 * n as i64, 0));
        assert_abs_diff_eq!(c.volume.unwrap(), n as f64, epsilon = 1e-7);
        let f = c.features.unwrap();
        assert!(f.recall > 0.99 && f.corners_found == f.corners_true, "{f:?}");
        assert!(f.node_residual_max < 1e-7, "{f:?}");
    }
}

#[test]
fn the_crest_of_a_formula_in_a_cylinder_is_as_near_as_any_surface() {
    // The formula's crest and the cylinder have one surface from z = 2 to 3, by functions that are no multiples of each other.
    let text = "
crest = solid(hypot(x, y) <= min(5, 3 + abs(z))).name(\"crest\") & box(lo=(-6, -6, -8), hi=(6, 6, 3)).name(\"end\")
part(crest | cylinder(5, height=6, at=(0, 0, 5)).name(\"shank\"))
mesh(size=0.5)
";
    let made = mesh_part(&parse(text, &[]).unwrap(), &MeshOptions::default(), &Run::new()).unwrap();
    assert_eq!((made.report.shortfalls, made.report.attempts.len()), (Vec::new(), 1));
    let c = made.report.check.unwrap();
    let (d, f) = (c.deviation.unwrap(), c.features.unwrap());
    assert!(d.max < 0.02 && d.from_surface.unwrap() < 0.02 && d.inverted + d.unprojected == 0, "{d:?}");
    assert!(f.recall == 1.0 && f.precision == 1.0 && c.euler == 2, "{f:?}");
    // Two cylinders of height 6, and two frustums between them.
    let volume = 2.0 * (6.0 * 25.0 * PI + PI / 3.0 * 2.0 * (25.0 + 15.0 + 9.0));
    assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 0.002);
}
