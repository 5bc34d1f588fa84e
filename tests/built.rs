//! Solids built from edges, by part files and by programs: named troubles of [BOR20], sewing, STEP there and back.

use std::path::{Path, PathBuf};

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq, relative_eq};
use rvachev::implicit::part::{Part, parse};
use rvachev::parametric::brep::Brep;
use rvachev::parametric::build::{Extrusion, Wire, extrude_edges, flat_face, sew};
use rvachev::parametric::{Frame, Surface};
use rvachev::pipeline::{
    BrepInfo, MeshOptions, SizeRequest, against_step, brep_info, build, load_part, load_step, mesh_part, save_step,
};
use rvachev::{DVec3, Error, Run};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn info(part: &Part) -> BrepInfo {
    let run = Run::new();
    brep_info(build(part, &run).unwrap().unwrap().into(), part.units.as_deref(), &run).unwrap()
}

/// Meshes a part: sound, nothing short, every face there; its volume within a share of the exact one.
fn sound(name: &str, share: f64) {
    let part = load_part(&data(name), &[]).unwrap();
    let exact = info(&part);
    assert!(exact.sewn && exact.bodies.iter().all(|b| b.solid), "{name}");
    let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{name}: {:?}", made.report.shortfalls);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{name}: {:?}", check.certificate.faults);
    assert_eq!(made.mesh.faces.len(), exact.faces.len(), "{name}");
    let volume: f64 = exact.bodies.iter().map(|b| b.volume.unwrap()).sum();
    assert!(
        abs_diff_eq!(made.mesh.volume(), volume, epsilon = share * volume),
        "{name}: {} {volume}",
        made.mesh.volume()
    );
    assert_eq!(check.components, exact.bodies.len(), "{name}");
}

/// A hole whose rim falls together, contours that cross when they are divided, ones that touch, seams, poles, a surface
/// periodic both ways, curvature at the border, narrow faces, narrow regions, two sides that run together.
#[test]
fn the_named_troubles_mesh() {
    for (name, share) in [
        ("small_hole", 1e-3),
        ("thin_ring", 0.02),
        ("seam", 0.01),
        ("poles", 0.02),
        ("torus", 0.02),
        ("touching_contours", 1e-9),
        ("border_curvature", 0.02),
        ("narrow_face", 1e-9),
        ("narrow_region", 1e-9),
        ("sharp_edge", 0.02),
    ] {
        sound(&format!("troubles/{name}.py"), share);
    }
}

#[test]
fn both_sides_of_a_sharp_edge_are_remeshed() {
    let part = load_part(&data("troubles/sharp_edge.py"), &[]).unwrap();
    let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.ladder.is_empty(), "{:?}", made.report.ladder);
    let quality = made.report.check.unwrap().quality;
    assert!(quality.p05_angle > 47.0 && quality.mean_radius_ratio > 0.979, "{quality:?}");
}

/// Distances are those to the true sphere, and what was asked for holds at every point looked at.
#[test]
fn a_distance_asked_for_is_kept() {
    let text = "part(revolve_edges(arc((0, 0, -1), (1, 0, 0), (0, 0, 1)), \"z\").name(\"ball\"))\nmesh(size=0.5)\n";
    let part = parse(text, &[]).unwrap();
    for tolerance in [0.01, 0.001] {
        let how = MeshOptions { tolerance: Some(SizeRequest::Length(tolerance)), ..MeshOptions::default() };
        let made = mesh_part(&part, &how, &Run::new()).unwrap();
        assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
        let told = made.report.distance.unwrap();
        let m = &made.mesh;
        let deepest = (0..m.triangles.len()).map(|t| 1.0 - m.centroid(t).length()).fold(0.0, f64::max);
        assert!(deepest <= told.to_surface + 1e-9 && told.to_surface <= tolerance, "{deepest} {told:?}");
        assert_eq!((told.asked, told.beyond), (Some(tolerance), 0));
        // As few triangles as about do it: with edges h all over they are h^2/6 away.
        let few = 4.0 * std::f64::consts::PI / (3f64.sqrt() / 4.0 * 6.0 * tolerance);
        assert!((m.triangles.len() as f64) < 3.0 * few + 200.0, "{} {few}", m.triangles.len());
    }
}

/// Edges are as short as asked for in a box, a ball and on faces by name, by both gates.
#[test]
fn places_are_refined() {
    let built = "part(extrude_edges(polyline([(-2, -2), (2, -2), (2, 2), (-2, 2)], closed=True), \"z\", 4).name(\"cube\"))\nmesh(size=0.8)\n";
    let tree = "part(box((4, 4, 4), at=(0, 0, 2)).name(\"cube\"))\nmesh(size=0.8)\n";
    for text in [built, tree] {
        let part = parse(text, &[]).unwrap();
        for (wish, inside) in [
            ("box=1,1,3,2,2,4:0.2", DVec3::new(2.0, 2.0, 4.0)),
            ("sphere=-2,-2,0,0.5:0.2", DVec3::new(-2.0, -2.0, 0.0)),
            ("face=cube*:0.2", DVec3::new(2.0, -2.0, 4.0)),
        ] {
            let how = MeshOptions { refinements: vec![wish.parse().unwrap()], ..MeshOptions::default() };
            let made = mesh_part(&part, &how, &Run::new()).unwrap();
            assert!(made.report.shortfalls.is_empty(), "{wish}: {:?}", made.report.shortfalls);
            assert!(!made.report.warnings.iter().any(|w| w.contains("refinement")), "{:?}", made.report.warnings);
            let m = &made.mesh;
            let near = (0..m.triangles.len()).filter(|t| m.centroid(*t).distance(inside) < 0.4);
            let longest = |t: usize| {
                let [a, b, c] = m.corners(t);
                a.distance(b).max(b.distance(c)).max(c.distance(a))
            };
            let lengths: Vec<f64> = near.map(longest).collect();
            assert!(lengths.len() > 5 && lengths.iter().all(|l| *l < 0.42), "{wish}: {lengths:?}");
            let plain = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap().mesh.triangles.len();
            assert!(m.triangles.len() > plain, "{wish}");
        }
    }
}

#[test]
fn the_aircraft_is_one_sewn_solid() {
    let i = info(&load_part(&data("aircraft.py"), &[]).unwrap());
    assert!(i.sewn && i.bodies.len() == 1 && i.bodies[0].solid);
    assert_eq!(i.vertices as i64 - i.edges as i64 + i.faces.len() as i64, 2);
    assert!(i.bodies[0].volume.unwrap() > 250.0 && i.faces.iter().all(|f| f.area.is_some()));
}

/// Leading edges bend inside faces whose borders are nearly straight, and six faces meet at the round poles of nose and tail.
#[test]
fn the_aircraft_has_good_triangles() {
    let part = load_part(&data("aircraft.py"), &[]).unwrap();
    let exact = info(&part);
    let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let check = made.report.check.unwrap();
    let c = &check.certificate;
    assert!(c.is_sound(), "{:?}", c.faults);
    let defects = made.mesh.defects();
    assert!(defects.is_closed() && defects.is_manifold());
    assert_eq!(made.mesh.topology(&defects).euler, 2);
    assert_eq!(made.mesh.faces.len(), exact.faces.len());
    assert_relative_eq!(made.mesh.volume(), exact.bodies[0].volume.unwrap(), max_relative = 3e-3);
    let quality = check.quality;
    assert!(quality.min_angle > 18.5 && quality.p05_angle > 46.0, "{quality:?}");
    // Behind and below, where a wing's window has a corner, two edges of the model make an angle of 19.1 degrees.
    let below = (-55f64).to_radians();
    let corner = DVec3::new(18.0, 1.9 * below.cos(), 1.9 * below.sin());
    let at_corner = |p: &DVec3| DVec3::new(p.x, p.y.abs(), p.z).distance(corner) < 1e-6;
    let all = angles(&made.mesh).into_iter().enumerate();
    let elsewhere = all.filter(|a| !made.mesh.corners(a.0).iter().any(at_corner)).map(|a| a.1);
    let least = elsewhere.fold(180.0, f64::min);
    assert!(least > 22.0, "{least}");
}

#[test]
fn step_files_of_parts_read_back_and_their_meshes_lie_on_them() {
    let dir = tempfile::TempDir::new().unwrap();
    let run = Run::new();
    let text = "units(\"in\")\n\
        a = revolve_edges(spline([(0, 0, 0), (2, 0, 1), (1, 0, 3), (0, 0, 4)]), \"z\").name(\"vase\")\n\
        b = sweep_edges([circle(0.5), circle(0.3)], arc((0, 0, 0), (0.87867966, 0, 2.12132034), (3, 0, 3)))\n\
        part([a, b.move((0, 5, 0)).name(\"bend\")])\nmesh(size=\"3%\")\n";
    let part = parse(text, &[]).unwrap();
    let brep = build(&part, &run).unwrap().unwrap();
    let path = dir.path().join("both.step");
    save_step(&path, &brep, part.units.as_deref()).unwrap();
    let back = load_step(&path, &run).unwrap();
    assert!(back.notes.is_empty(), "{:?}", back.notes);
    let names = |b: &Brep| b.faces.iter().map(|f| f.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&brep), names(&back.brep));
    let (one, two) = (info(&part), brep_info(back.clone(), Some("mm"), &run).unwrap());
    assert_relative_eq!(two.area / one.area, 25.4 * 25.4, epsilon = 0.0, max_relative = 1e-6);
    assert!(two.to_string().contains("2 bodies (2 solids)") && two.to_string().contains("sewn"));
    let made = mesh_part(&part, &MeshOptions::default(), &run).unwrap();
    let check = against_step(&made.mesh, brep.into(), &run).unwrap();
    let d = check.deviation.unwrap();
    assert_eq!((d.unprojected, d.inverted), (0, 0));
    assert!(d.max < 0.05 && d.normal < 0.01, "{d:?}");
}

#[test]
fn solids_of_both_gates_go_into_one_mesh() {
    let text = "ball = sphere(1, at=(5, 0, 0)).name(\"ball\")\nrod = extrude_edges(circle(1), \"z\", 3).name(\"rod\")\n\
        part([ball, rod])\nmesh(size=0.3)\ngroup(\"round\", faces(\"ball\", \"rod.side\"))\n";
    let part = parse(text, &[]).unwrap();
    let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert_eq!(made.report.check.as_ref().unwrap().components, 2);
    let round = made.mesh.groups.iter().find(|g| g.name == "round").unwrap();
    assert_eq!(
        round.faces.iter().map(|f| made.mesh.faces[*f as usize].as_str()).collect::<Vec<_>>(),
        ["rod.side", "ball"]
    );
    let truth = std::f64::consts::PI * (4.0 / 3.0 + 3.0);
    assert_abs_diff_eq!(made.mesh.volume(), truth, epsilon = 0.03 * truth);
}

#[test]
fn the_mesh_is_the_same_for_any_number_of_threads() {
    let part = load_part(&data("troubles/poles.py"), &[]).unwrap();
    let how = MeshOptions { size: Some(SizeRequest::Share(0.05)), ..MeshOptions::default() };
    let one = |n| mesh_part(&part, &how, &Run::new().with_threads(n).unwrap()).unwrap().mesh;
    assert_eq!(one(1), one(3));
}

fn square(z: f64, side: f64) -> Wire {
    let p = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(side * x, side * y, z));
    Wire::polygon(&p).unwrap()
}

#[test]
fn sheets_are_sewn_and_turned_to_one_solid() {
    let run = Run::new();
    let sheet = Extrusion { caps: false, ..Extrusion::new(DVec3::Z, 2.0) };
    let side = extrude_edges(&[square(0.0, 1.0)], &sheet).unwrap();
    let inner = Wire::circle(Frame { origin: DVec3::new(0.0, 0.0, 2.0), ..Frame::WORLD }, 0.5).unwrap();
    // A blind hole from above, lids in both directions.
    let down = Extrusion { caps: false, ..Extrusion::new(-DVec3::Z, 1.0) };
    let bore = extrude_edges(std::slice::from_ref(&inner), &down).unwrap();
    let low = Wire::circle(Frame { origin: DVec3::Z, ..Frame::WORLD }, 0.5).unwrap();
    let lids = [
        flat_face(&[square(0.0, 1.0)]).unwrap(),
        flat_face(&[square(2.0, 1.0).reversed(), inner]).unwrap(),
        flat_face(&[low]).unwrap(),
    ];
    let all = || [vec![side.clone(), bore.clone()], lids.to_vec()].concat();
    let b = sew(all(), None, true, &run).unwrap();
    assert_eq!((b.bodies.len(), b.faces.len(), b.bodies[0].solid), (1, 8, true));
    assert!(b.uses().iter().all(|n| *n == 2));
    let i = brep_info(b.into(), None, &run).unwrap();
    let truth = 8.0 - 0.25 * std::f64::consts::PI;
    assert!(relative_eq!(i.bodies[0].volume.unwrap(), truth, epsilon = 0.0, max_relative = 1e-7), "{i}");
    // Without its bottom, and with one sheet too many.
    let mut open = all();
    open.remove(2);
    let says = |r: rvachev::Result<Brep>, what: &str| {
        let e = r.unwrap_err().to_string();
        assert!(e.contains(what), "{e}");
    };
    says(sew(open.clone(), None, true, &run), "has a face on one side only, and 3 more");
    assert!(!sew(open, None, false, &run).unwrap().bodies[0].solid);
    let mut more = all();
    more.push(flat_face(&[square(0.0, 1.0)]).unwrap());
    says(sew(more, None, true, &run), "has 3 faces");
    // A solid without a face, closed again by a pyramid's sides: the plane faces stay what they are.
    let opened = extrude_edges(&[square(0.0, 1.0)], &Extrusion::new(DVec3::Z, 2.0)).unwrap().without(|n| n == "end");
    assert!(!opened.bodies[0].solid && opened.faces.iter().all(|f| matches!(f.surface, Surface::Plane { .. })));
    let tip = rvachev::parametric::build::Section::Point(DVec3::new(0.0, 0.0, 5.0));
    let base = rvachev::parametric::build::Section::Wire(square(2.0, 1.0));
    let how = rvachev::parametric::build::Loft { ruled: true, caps: false, ..Default::default() };
    let roof = rvachev::parametric::build::loft(&[base, tip], &how).unwrap();
    let i = brep_info(sew(vec![opened, roof], None, true, &run).unwrap().into(), None, &run).unwrap();
    assert_relative_eq!(i.bodies[0].volume.unwrap(), 12.0, epsilon = 0.0, max_relative = 1e-12);
}

#[test]
fn what_a_part_file_cannot_build_is_told_with_its_place() {
    let line = "edges = polyline([(0, 0), (2, 0), (2, 1)])\n";
    for (text, says) in [
        (
            "part(extrude_edges(edges, \"z\", 1))\n",
            "line 2, column 6: a solid needs a closed contour; this one has a gap of 2.23",
        ),
        ("part(revolve_edges(edges, \"x\", degrees=400))\n", "line 2, column 6: the angle of a revolution"),
        (
            "part(loft([edges, (0, 0, 1)], solid=False).without(\"top\"))\n",
            "no face is called \"top\"; there are side1, side2",
        ),
        ("part([sphere(1), sphere(2)])\n", "one solid of R-functions at most"),
        ("part([edges])\n", "a part is made of solids, not of a chain of edges"),
        ("part(extrude_edges([(0, 0)], \"z\", 1))\n", "must be a list of edges, not of a tuple"),
        ("part(sew([sphere(1)]))\n", "takes what is built from edges"),
        ("part(edges.mirror(\"x\"))\n", ".mirror() is not for a chain of edges"),
        ("part(polyline([(0, 0, 0, 0)]))\n", "point 0 must be two or three finite numbers"),
    ] {
        let made = parse(&format!("{line}{text}"), &[]).and_then(|p| build(&p, &Run::new()));
        let Err(e) = made else { panic!("{text} is built") };
        assert!(matches!(e, Error::Input { .. }) && e.to_string().contains(says), "{text}{e}");
    }
    let sheet = format!("{line}part(extrude_edges(edges, \"z\", 1, solid=False) & sphere(1))\n");
    let e = mesh_part(&parse(&sheet, &[]).unwrap(), &MeshOptions::default(), &Run::new()).err().unwrap();
    assert!(e.to_string().contains("line 2, column 6: it is open"), "{e}");
}

fn meshed(text: &str) -> rvachev::pipeline::Meshed {
    mesh_part(&parse(text, &[]).unwrap(), &MeshOptions::default(), &Run::new()).unwrap()
}

/// The smallest angle of every triangle, in degrees.
fn angles(m: &rvachev::mesh::TriMesh) -> Vec<f64> {
    let least = |t: usize| {
        let p = m.corners(t);
        let at = |k: usize| (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k]);
        at(0).min(at(1)).min(at(2)).to_degrees()
    };
    (0..m.triangles.len()).map(least).collect()
}

/// Faces whose sides run together in a point, at an angle or touching each other, have a needle there and hardly more.
#[test]
fn sharp_corners_and_cusps_end_in_one_triangle() {
    let wedge = "polyline([(0, 0), (20, 0), (20, 3.5)], closed=True)";
    let cusp = "chain([arc((0, 0, 0), (7.653668647, 1.522409349, 0), (14.142135624, 5.857864376, 0)), polyline([(14.142135624, 5.857864376), (14.142135624, 0), (0, 0)])])";
    for (shape, most) in [(wedge, 2), (cusp, 4)] {
        let text = format!("part(extrude_edges({shape}, \"z\", 5).name(\"it\"))\nmesh(size=1.5)\n");
        let made = meshed(&text);
        assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
        assert!(made.report.check.as_ref().unwrap().certificate.is_sound());
        let small = angles(&made.mesh).into_iter().filter(|a| *a < 20.0).count();
        assert!((1..=most).contains(&small), "{shape}: {small} needles");
    }
}

/// A pipe long against its width, its wall thinner than the bends between edges of the size asked for are high.
#[test]
fn walls_of_thin_pipes_do_not_cross() {
    for wall in [0.5f64, 0.1] {
        let text = format!(
            "part(extrude_edges([circle(1.6), circle({})], \"z\", 60).name(\"pipe\"))\nmesh(size=8)\n",
            1.6 - wall
        );
        let made = meshed(&text);
        assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
        // The thinnest one is sound, too, but not remeshed.
        assert!(made.report.ladder.is_empty() == (wall > 0.2), "{:?}", made.report.ladder);
        assert!(made.report.check.as_ref().unwrap().certificate.is_sound(), "{wall}");
        let volume = std::f64::consts::PI * (1.6f64.powi(2) - (1.6 - wall).powi(2)) * 60.0;
        assert!(
            abs_diff_eq!(made.mesh.volume(), volume, epsilon = 0.35 * volume),
            "{wall}: {} {volume}",
            made.mesh.volume()
        );
    }
}

/// A sheet whose hole touches its rim in one point: both sides of that have a node there, which is no intersection.
#[test]
fn a_surface_may_touch_itself_in_a_point() {
    let text = "part(flat_face([polyline([(0, 0), (4, 0), (4, 4), (0, 4)], closed=True), polyline([(0, 0), (2, 1), (1, 2)], closed=True)]).name(\"sheet\"))\nmesh(size=0.5)\n";
    let made = meshed(text);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let check = made.report.check.unwrap();
    assert_eq!((check.self_intersections, check.manifold), (0, true));
    assert!((made.mesh.triangles.len() as f64) > 100.0);
    assert_abs_diff_eq!(check.area, 16.0 - 1.5, epsilon = 1e-9);
}

/// Two sheets that cross are two bodies of an open model: neither is cut along the other.
#[test]
fn open_bodies_that_cross_stay_as_they_are() {
    let text = "floor = flat_face(polyline([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)], closed=True)).name(\"floor\")\n\
        wall = flat_face(polyline([(1, 2, -1), (3, 2, -1), (3, 2, 1), (1, 2, 1)], closed=True)).name(\"wall\")\n\
        part([floor, wall])\nmesh(size=0.5)\n";
    let made = meshed(text);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert!(made.report.warnings.iter().any(|w| w.contains("overlap")), "{:?}", made.report.warnings);
    let check = made.report.check.unwrap();
    assert_eq!((check.components, check.self_intersections), (2, 0));
    assert_abs_diff_eq!(check.area, 20.0, epsilon = 1e-9);
    let of_wall = made.mesh.faces.iter().position(|n| n.contains("wall")).unwrap() as u32;
    for (t, l) in made.mesh.triangles.iter().zip(&made.mesh.labels) {
        let nodes = t.map(|v| made.mesh.nodes[v as usize]);
        let away = |p: &rvachev::DVec3| if *l == of_wall { p.y - 2.0 } else { p.z };
        assert!(nodes.iter().all(|p| away(p).abs() < 1e-12), "{nodes:?}");
    }
}

#[test]
fn cones_mesh_at_any_size() {
    for size in [0.2, 0.3, 0.45, 0.5, 0.6, 0.65, 0.8, 1.0, 1.2] {
        let text = format!(
            "part(revolve_edges(polyline([(0, 0, 0), (3, 0, 0), (0, 0, 6)]), \"z\").name(\"tip\"))\nmesh(size={size})\n"
        );
        let part = parse(&text, &[]).unwrap();
        let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
        assert_eq!(made.report.shortfalls, Vec::new(), "{size}");
        let check = made.report.check.unwrap();
        assert!(check.certificate.is_sound() && check.quality.min_angle > 15.0, "{size}: {:?}", check.quality);
        let exact = std::f64::consts::PI * 18.0;
        assert!(
            abs_diff_eq!(check.volume.unwrap() / exact, 1.0, epsilon = 0.1 * size),
            "{size}: {}",
            check.volume.unwrap()
        );
    }
}

#[test]
fn acute_tips_end_in_one_fan() {
    let tip = DVec3::new(0.0, 0.0, 6.0);
    for (radius, size) in [(0.6, 0.06), (0.6, 0.12), (0.6, 0.3), (1.2, 0.2), (2.2, 0.15), (2.2, 0.4), (5.0, 0.3)] {
        let profile = format!("polyline([(0, 0, 0), ({radius}, 0, 0), (0, 0, 6)])");
        let made = meshed(&format!("part(revolve_edges({profile}, \"z\").name(\"tip\"))\nmesh(size={size})\n"));
        let case = format!("{radius} {size}");
        assert!(made.report.shortfalls.is_empty() && made.report.ladder.is_empty(), "{case}: {:?}", made.report.ladder);
        let at_tip = |t: usize| made.mesh.corners(t).contains(&tip);
        let fan = (0..made.mesh.triangles.len()).filter(|t| at_tip(*t)).count();
        assert!((4..=6).contains(&fan), "{case}: {fan}");
        let slim = angles(&made.mesh).into_iter().enumerate().filter(|a| a.1 < 20.0 && !at_tip(a.0)).count();
        assert_eq!(slim, 0, "{case}");
    }
}

#[test]
fn profiles_may_meet_their_axis_between_their_ends() {
    // Radius of the arc, how far its center is from the axis, and the heights between which it runs.
    for (r, c, [low, high]) in [(5.0, -4.0, [-3.0, 3.0]), (5.0, 4.0, [-3.0, 3.0]), (17.0, -15.0, [0.0, 8.0])] {
        let rho = |z: f64| c + f64::sqrt(r * r - z * z);
        let middle = 0.5 * (low + high);
        let points =
            if c < 0.0 { [low, middle, high].map(|z| (rho(z), z)) } else { [(0.0, low), (c + r, 0.0), (0.0, high)] };
        let [a, b, d] = points.map(|(x, z)| format!("({x}, 0, {z})"));
        let arc = format!("arc({a}, {b}, {d})");
        let profile = if low == 0.0 { format!("chain([polyline([(0, 0, 0), {a}]), {arc}])") } else { arc };
        // Under the equator of the fat one there is nothing, its poles lie in dents.
        let exact = match c < 0.0 {
            true => {
                let n = 20_000;
                let step = (high - low) / f64::from(n);
                (0..n).map(|k| rho(low + (f64::from(k) + 0.5) * step).max(0.0).powi(2)).sum::<f64>() * step
            }
            false => {
                let n = 20_000;
                let step = 2.0 * r / f64::from(n);
                let ring = |z: f64| {
                    let half = f64::sqrt(r * r - z * z);
                    (c + half).powi(2) - if z.abs() > 3.0 { (c - half).powi(2) } else { 0.0 }
                };
                (0..n).map(|k| ring(-r + (f64::from(k) + 0.5) * step)).sum::<f64>() * step
            }
        } * std::f64::consts::PI;
        let made = meshed(&format!("part(revolve_edges({profile}, \"z\").name(\"body\"))\nmesh(size=0.3)\n"));
        let check = made.report.check.as_ref().unwrap();
        assert!(made.report.shortfalls.is_empty() && check.certificate.is_sound(), "{c}: {:?}", made.report.shortfalls);
        assert!(
            abs_diff_eq!(check.volume.unwrap(), exact, epsilon = 0.02 * exact),
            "{c}: {} {exact}",
            check.volume.unwrap()
        );
        assert!(check.quality.min_angle > 20.0, "{c}: {:?}", check.quality);
    }
}

/// A ring whose hole is a thousandth as wide as the ring: around it lengths per parameter are a thousandth of those elsewhere.
#[test]
fn rings_that_nearly_close_their_hole_mesh() {
    for (tube, size) in [(4.99, 0.5), (4.999, 0.4), (4.999, 0.8)] {
        let made = meshed(&format!(
            "part(revolve_edges(circle({tube}, (5, 0, 0), \"y\"), \"z\").name(\"ring\"))\nmesh(size={size})\n"
        ));
        let case = format!("{tube} {size}");
        assert!(made.report.shortfalls.is_empty() && made.report.ladder.is_empty(), "{case}: {:?}", made.report.ladder);
        let check = made.report.check.as_ref().unwrap();
        assert!(check.certificate.is_sound(), "{case}: {:?}", check.certificate.faults);
        let exact = 2.0 * std::f64::consts::PI.powi(2) * 5.0 * tube * tube;
        assert!(
            abs_diff_eq!(check.volume.unwrap(), exact, epsilon = 0.02 * exact),
            "{case}: {}",
            check.volume.unwrap()
        );
        assert!(check.quality.below_20 < 1e-3, "{case}: {:?}", check.quality);
    }
}

/// An outline that crosses itself does so however finely it is divided: its caps are refused, the walls meshed as if nothing
/// were wrong, and nothing is put over the holes.
#[test]
fn outlines_that_cross_themselves_are_named_and_not_refined() {
    let made = meshed(
        "part(extrude_edges(spline([(0, 0), (10, 4), (10, -4)], closed=True), \"z\", 5).name(\"fine\"))\nmesh(size=1)\n",
    );
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let most = 3 * made.mesh.triangles.len();
    let made = meshed(
        "part(extrude_edges(spline([(0, 0), (10, 4), (10, -4), (0, 1)], closed=True), \"z\", 5).name(\"it\"))\nmesh(size=1)\n",
    );
    let short = &made.report.shortfalls;
    assert_eq!(
        short.iter().map(ToString::to_string).filter(|s| s.contains("plane") && s.contains("cross")).count(),
        2,
        "{short:?}"
    );
    assert!(made.mesh.triangles.len() < most, "{}", made.mesh.triangles.len());
    assert!(made.mesh.nodes.iter().all(|p| (-1e-9..5.0 + 1e-9).contains(&p.z)));
}

/// Walls with lobes whose tips bend within a thousandth of the outline: triangles as for an edge there, near to the surface.
#[test]
fn bends_too_sharp_for_triangles_are_meshed_as_edges() {
    for (lobes, inner, outer, turn) in [(5, 3.0, 6.7, 0.0f64), (4, 2.6, 6.7, 0.2)] {
        let point = |k: usize| {
            let r = if k.is_multiple_of(2) { outer } else { inner };
            let (s, c) = (std::f64::consts::PI * k as f64 / f64::from(lobes) + turn).sin_cos();
            format!("({:.3}, {:.3})", r * c, r * s)
        };
        let points: Vec<String> = (0..2 * lobes as usize).map(point).collect();
        let outline = format!("extrude_edges(spline([{}], closed=True), \"z\", 12).name(\"it\")", points.join(", "));
        let mut volume = 0.0;
        for (share, size) in [("1%", 0.01), ("3%", 0.03), ("8%", 0.08)] {
            let made = meshed(&format!("part({outline})\nmesh(size=\"{share}\")\n"));
            let report = &made.report;
            assert!(report.shortfalls.is_empty() && report.ladder.is_empty(), "{share}: {:?}", report.ladder);
            let check = report.check.as_ref().unwrap();
            assert!(check.certificate.is_sound() && check.euler == 2);
            assert!(check.quality.min_angle > 12.0 && check.quality.p05_angle > 40.0, "{share}: {:?}", check.quality);
            let distance = report.distance.unwrap();
            assert!(distance.to_surface < 0.08 * size * distance.diagonal, "{share}: {distance}");
            if volume > 0.0 {
                assert!(
                    abs_diff_eq!(check.volume.unwrap(), volume, epsilon = 0.02 * volume),
                    "{share}: {} {volume}",
                    check.volume.unwrap()
                );
            }
            volume = check.volume.unwrap();
        }
    }
}

/// A pyramid whose tip is cut off far below the size, by a square whose sides have a vertex in their middle: at those vertices
/// no border is as long as its neighbors.
#[test]
fn edges_too_short_to_be_followed_have_few_triangles_around_them() {
    let w = 5e-6;
    let text = format!(
        "w = {w}
base = [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)]
top = [(-w, -w, 10), (w, -w, 10), (w, w, 10), (-w, w, 10)]
mid = [(0, -w, 10), (w, 0, 10), (0, w, 10), (-w, 0, 10)]
def side(i, j):
    return flat_face(polyline([base[i], base[j], top[j], mid[i], top[i]], closed=True))
lid = polyline([top[0], mid[0], top[1], mid[1], top[2], mid[2], top[3], mid[3]], closed=True)
floor = polyline([base[0], base[3], base[2], base[1]], closed=True)
part(sew([side(0, 1), side(1, 2), side(2, 3), side(3, 0), flat_face(lid), flat_face(floor)]).name(\"it\"))
mesh(size=1)
"
    );
    let made = meshed(&text);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound());
    // A frustum of a pyramid.
    let truth = 10.0 / 3.0 * (100.0 + 10.0 * 2.0 * w + 4.0 * w * w);
    assert_relative_eq!(check.volume.unwrap(), truth, epsilon = 0.0, max_relative = 1e-12);
    // Needles at the tip alone: one for each side of the eight short edges.
    let angles = angles(&made.mesh);
    let poor = (0..angles.len()).filter(|t| angles[*t] < 20.0);
    let far = poor.clone().filter(|t| made.mesh.corners(*t).iter().all(|p| p.z < 9.5)).count();
    assert!(poor.count() <= 16 && far == 0, "{far} of them far from the tip");
}
