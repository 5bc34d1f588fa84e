//! Exact edges and corners from the tree: what the leaf method promises, on parts whose answers are known.

use std::f64::consts::PI;
use std::path::Path;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq, relative_eq};
use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::expr::{Binary, Unary};
use rvachev::implicit::{Expr, Placement, Primitive, Solid, Tpms};
use rvachev::merge::Merged;
use rvachev::mesh::MeshView;
use rvachev::pipeline::{MeshOptions, Meshed, Part, SizeRequest, load_part, mesh_part};
use rvachev::quality::Check;

fn made(solid: Solid, size: f64, change: impl FnOnce(&mut MeshOptions)) -> Meshed {
    let mut options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    change(&mut options);
    mesh_part(&Part::from_solid(solid), &options, &Run::new()).unwrap()
}

/// A mesh by the leaf method with nothing to report but what is measured.
fn exact(solid: Solid, size: f64) -> Check {
    let made = made(solid, size, |_| {});
    assert_eq!((made.report.method, made.report.shortfalls), ("leaf", Vec::new()));
    let c = made.report.check.unwrap();
    assert!(c.certificate.is_sound(), "{:?}", c.certificate);
    let (f, d) = (c.features.unwrap(), c.deviation.unwrap());
    // Around the tip of a cone the triangles' own edges count as sharp.
    assert!(f.recall >= 0.99 && f.precision >= 0.9, "{f:?}");
    assert_eq!(f.corners_found, f.corners_true);
    assert!(f.node_residual_max <= 1e-12, "{f:?}");
    assert!(d.inverted == 0 && d.max < 0.3 * size && d.from_surface.unwrap() < 0.3 * size, "{d:?}");
    c
}

fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> Solid {
    Solid::cuboid(lo.into(), hi.into())
}

/// Rotation and shift of [`turned`].
fn turn() -> (DMat3, DVec3) {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    (DMat3::from_axis_angle(axis, 0.7), DVec3::new(0.01, 0.02, 0.03))
}

fn turned(solid: Solid) -> Solid {
    let (rotation, shift) = turn();
    solid.placed(Placement { rotation, scale: 1.0, shift })
}

fn cube_with_holes() -> Solid {
    cuboid([-1.0; 3], [1.0; 3])
        - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None)
        - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None)
}

#[test]
fn the_cube_with_holes_is_exact_aligned_and_turned() {
    for solid in [cube_with_holes(), turned(cube_with_holes())] {
        for n in [32.0, 64.0] {
            let c = exact(solid.clone(), 2.474 / n);
            assert_eq!((c.euler, c.features.unwrap().corners_true), (-4, 8));
            assert!(c.quality.min_angle >= 30.0 && c.quality.p05_angle > 48.0, "{:?}", c.quality);
            // 8 - 2 * 2 pi r^2 + 16/3 r^3, by Steinmetz; chords cut the holes smaller by the square of the size.
            let volume = 8.0 - 4.0 * PI * 0.16 + 16.0 / 3.0 * 0.064;
            assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 20.0 / (n * n));
        }
    }
}

#[test]
fn jumps_and_seams_of_formulas_are_exact_edges() {
    let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
    let cell = |e: &Expr| Expr::binary(Binary::Mod, e.clone(), Expr::constant(1.0)) - 0.5;
    let abs = |e| Expr::unary(Unary::Abs, e);
    let ring = Expr::binary(Binary::Hypot, cell(&x), cell(&y));
    let turned_cone = Expr::binary(Binary::Hypot, x.clone(), y.clone()) + Expr::unary(Unary::Floor, z.clone());
    // A triangle wave, a plate with holes, a tower of three disks, and two floors: volumes and corners are known.
    for (lo, hi, f, volume, corners) in [
        ([0.0; 3], [3.0, 1.0, 1.0], Expr::constant(0.3) + abs(cell(&x)) * 0.4 - z.clone(), 1.2, 8 + 2 * 5),
        ([0.0; 3], [3.0, 2.0, 0.5], ring - 0.3, 3.0 - 3.0 * PI * 0.09, 8),
        ([-3.0, -3.0, 0.0], [3.0; 3], Expr::constant(2.7) - turned_cone, PI * (7.29 + 2.89 + 0.49), 0),
        ([-1.0; 3], [1.0; 3], Expr::unary(Unary::Sign, y.clone()) * 0.25 - z.clone(), 4.0, 12),
    ] {
        let c = exact(cuboid(lo, hi) & Solid::formula(f), 0.1);
        assert_eq!(c.features.unwrap().corners_true, corners);
        assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 0.005);
    }
}

#[test]
fn faces_with_one_curve_in_common_have_their_edge_there() {
    let waves = "solid(z <= .3 + .4*abs(x % 1 - .5))";
    let steps = "solid(z <= (.2*x if x + .3*y < .4 else .5*x - .3*(.4 - .3*y)))";
    // A wave of ramps whose ends fall on the walls, turned; a plane that goes on as another; a countersink whose rim is that of half
    // a wider bore. Where ramps meet, a divider passes the edge, and on the countersink's rim three faces do.
    for (text, volume, corners) in [
        (format!("part((box(size=(4, 4, 2)) & {waves}).rotate(33, axis=(1, 2, 3)).scale(2))"), 179.2, 22),
        (format!("part((box(size=(2, 2, 2)) & {steps}).rotate(20, axis=(3, 1, 2)))"), 4.117, 10),
        (
            "bore = cylinder(.6) | cylinder(1) & half_space((-1, 0, 0))\n\
             part(box(lo=(-2, -2, -1), hi=(2, 2, 0)) - bore - cone(.4, 1.2, .8, at=(0, 0, -.2)))"
                .to_string(),
            16.0 - PI * (0.5 + 0.18 + 0.176 / 3.0),
            16,
        ),
    ] {
        let part = rvachev::implicit::part::parse(&text, &[]).unwrap();
        for size in [0.1, 0.17] {
            let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
            let report = mesh_part(&part, &options, &Run::new()).unwrap().report;
            assert!(report.shortfalls.is_empty(), "{text}: {:?}", report.shortfalls);
            let c = report.check.unwrap();
            let f = c.features.unwrap();
            assert!(c.certificate.is_sound() && f.recall > 0.99 && f.precision > 0.99, "{text}: {f:?}");
            assert_eq!((f.corners_found, f.corners_true), (corners, corners), "{text}");
            assert!(
                relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 2e-3),
                "{text}: {} {volume}",
                c.volume.unwrap()
            );
        }
    }
}

#[test]
fn coincident_faces_are_one_face_or_none() {
    let (a, b) = (cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]));
    // Two boxes that share a wall, the same box twice, and a hole exactly as deep as the plate.
    for (solid, volume, corners) in [
        (a.clone() | b.clone(), 2.0, 8),
        (a.clone() | a.clone(), 1.0, 8),
        (a.clone() & a.clone(), 1.0, 8),
        ((a.clone() & b.clone()) | a.clone(), 1.0, 8),
        (a.clone() - cuboid([0.3, 0.3, 0.0], [0.7, 0.7, 1.0]), 0.84, 16),
        (a.clone() | cuboid([0.2, 0.2, 1.0], [0.8, 0.8, 1.5]), 1.18, 16),
    ] {
        for solid in [solid.clone(), turned(solid)] {
            let c = exact(solid, 0.11);
            assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 1e-9);
            assert_eq!(c.features.unwrap().corners_true, corners);
        }
    }
    let nothing = mesh_part(&Part::from_solid(a.clone() - a), &MeshOptions::default(), &Run::new());
    assert!(nothing.unwrap_err().to_string().contains("empty"));
}

#[test]
fn formulas_that_coincide_are_one_face_as_planes_are() {
    let of = |text: &str| {
        let part = rvachev::implicit::part::parse(text, &[]).unwrap();
        let options = MeshOptions { size: Some(SizeRequest::Length(0.09)), ..MeshOptions::default() };
        let report = mesh_part(&part, &options, &Run::new()).unwrap().report;
        assert!(report.shortfalls.is_empty(), "{text}: {:?}", report.shortfalls);
        let c = report.check.unwrap();
        assert!(c.certificate.is_sound() && c.quality.p05_angle > 44.0, "{text} {:?}", c.quality);
        let f = c.features.unwrap();
        assert!(f.recall > 0.99 && f.corners_found == f.corners_true, "{f:?}");
        c
    };
    // Blocks of a lattice side by side, each moved by whole periods, are the block of all.
    let block = |name: &str, x: u8| {
        format!("{name}(1, .25) & box(size=({x}, {x}, 1)).move(({0}, {0}, 0))", f64::from(x - 1) / 2.0)
    };
    for name in ["gyroid", "schwarz_p"] {
        let tiled =
            format!("b = {}\npart(union([b.move((i, j, 0)) for i in range(2) for j in range(2)]))", block(name, 1));
        let (tiled, whole) = (of(&tiled), of(&format!("part({})", block(name, 2))));
        assert_eq!((tiled.components, tiled.euler), (whole.components, whole.euler), "{name}");
        assert!(
            relative_eq!(tiled.volume.unwrap(), whole.volume.unwrap(), epsilon = 0.0, max_relative = 2e-3),
            "{name} {} {}",
            tiled.volume.unwrap(),
            whole.volume.unwrap()
        );
    }
    // A twisted bar turned by half a turn is itself; a formula times a number is the formula.
    let bar = "w = max(abs(x*cos(z)+y*sin(z))-.4, abs(y*cos(z)-x*sin(z))-.3)\nb = solid(w <= 0) & box(size=(2, 2, 1))";
    let alone = of(&format!("{bar}\npart(b)"));
    for more in ["b.rotate(180, axis='z')", "(solid(3*w <= 0) & box(size=(2, 2, 1)))"] {
        let c = of(&format!("{bar}\npart(b | {more})"));
        assert_eq!((c.components, c.euler), (1, 2), "{more}");
        assert!(
            relative_eq!(c.volume.unwrap(), alone.volume.unwrap(), epsilon = 0.0, max_relative = 1e-3),
            "{more} {} {}",
            c.volume.unwrap(),
            alone.volume.unwrap()
        );
    }
    // Nearly the same is not the same: each block keeps its own walls.
    let alone = |thickness: f64| format!("gyroid(1, {thickness}) & box(size=(1, 1, 1))");
    let both = of(&format!("part(({}) | ({}).move((1, 0, 0)))", alone(0.25), alone(0.2)));
    let sum: f64 = [0.25, 0.2].iter().map(|t| of(&format!("part({})", alone(*t))).volume.unwrap()).sum();
    assert_relative_eq!(both.volume.unwrap(), sum, epsilon = 0.0, max_relative = 2e-3);
}

#[test]
fn a_seam_between_tangent_faces_is_no_sharp_edge_but_parts_the_faces() {
    // A half-round bar: the cylinder runs into the flat sides without a crease.
    let bar = cuboid([-1.0, -0.3, -0.5], [1.0, 0.3, 0.0])
        | (Solid::cylinder(0.3, DVec3::X, DVec3::ZERO, Some(2.0)) & Solid::half_space(-DVec3::Z, DVec3::ZERO));
    let made = made(bar, 0.07, |_| {});
    let c = made.report.check.unwrap();
    assert!(c.certificate.is_sound());
    let sharp: f64 = made
        .mesh
        .sharp_edges(30.0)
        .iter()
        .map(|e| made.mesh.nodes[e[0] as usize].distance(made.mesh.nodes[e[1] as usize]))
        .sum();
    let true_length = 2.0 * 2.0 + 2.0 * (0.6 + 2.0 * 0.5 + PI * 0.3);
    assert_abs_diff_eq!(sharp, true_length, epsilon = 0.02 * true_length);
    let area = 2.0 * PI * 0.3;
    let round = c.groups.iter().find(|g| g.name == "cylinder1.side").unwrap();
    assert_abs_diff_eq!(round.area, area, epsilon = 0.02 * area);
}

#[test]
fn cones_keep_their_rims_and_thin_walls_both_sides() {
    let cone = Solid::new(rvachev::implicit::SolidNode::Primitive(Primitive::Cone {
        r0: 0.6,
        r1: 0.2,
        height: 1.0,
        axis: DVec3::new(0.2, 0.3, 1.0),
        at: DVec3::ZERO,
    }));
    let c = exact(cone, 0.08);
    assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 0));
    // The tip of a cone is a corner although only one leaf passes there, unless it is cut off or covered.
    let cone = |r1: f64| Primitive::Cone { r0: 0.6, r1, height: 1.0, axis: DVec3::new(0.2, 0.3, 1.0), at: DVec3::ZERO };
    let c = exact(cone(0.0).into(), 0.08);
    assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 1));
    let tip = DVec3::new(0.2, 0.3, 1.0).normalize() * 0.5;
    let c = exact(Solid::from(cone(0.0)) | Solid::sphere(0.2, tip), 0.08);
    assert_eq!(c.features.unwrap().corners_true, 0);
    // A plate half a cell thick is found with smaller cells.
    let c = exact(cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.06]) | cuboid([-1.0, -1.0, 0.0], [-0.5, 1.0, 1.0]), 0.1);
    assert_abs_diff_eq!(c.volume.unwrap(), 0.06 * 4.0 + 0.5 * 2.0 * 0.94, epsilon = 1e-9);
}

#[test]
fn sizes_follow_faces_curvature_and_chords() {
    let plate =
        || cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.3]) - Solid::cylinder(0.1, DVec3::Z, DVec3::ZERO, None).name("bore");
    let count = |m: &Meshed, face: &str| {
        m.report
            .check
            .as_ref()
            .unwrap()
            .groups
            .iter()
            .filter(|g| g.name.starts_with(face))
            .map(|g| g.triangles)
            .sum::<usize>()
    };
    let around = |m: &Meshed| {
        let rim = |e: &&[u32; 2]| {
            e.iter().all(|v| {
                (m.mesh.nodes[*v as usize].truncate().length() - 0.1).abs() < 1e-9 && m.mesh.nodes[*v as usize].z == 0.0
            })
        };
        m.mesh.sharp_edges(30.0).iter().filter(rim).count()
    };
    let coarse = made(plate(), 0.1, |o| o.angle = Some(60.0));
    let fine = made(plate(), 0.1, |o| (o.angle, o.least) = (Some(10.0), Some(SizeRequest::Length(0.001))));
    assert!(
        (5..12).contains(&around(&coarse)) && (30..50).contains(&around(&fine)),
        "{} {}",
        around(&coarse),
        around(&fine)
    );
    let tight = made(plate(), 0.1, |o| {
        (o.tolerance, o.least) = (Some(SizeRequest::Length(1e-4)), Some(SizeRequest::Length(0.001)))
    });
    let d = tight.report.check.as_ref().unwrap().deviation.unwrap();
    assert!(d.max < 2.5e-4 && d.from_surface.unwrap() < 2.5e-4, "{d:?}");
    let local = made(
        cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.3])
            - Solid::cylinder(0.3, DVec3::Z, DVec3::ZERO, None).name("bore").size(0.03),
        0.1,
        |_| {},
    );
    let plain = made(
        cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.3]) - Solid::cylinder(0.3, DVec3::Z, DVec3::ZERO, None).name("bore"),
        0.1,
        |o| o.angle = Some(20.0),
    );
    assert!(count(&local, "bore") > 6 * count(&plain, "bore"), "{} {}", count(&local, "bore"), count(&plain, "bore"));
    // With no wish at all, edges stay within a 120th of the size of the surface; triangles, within twice that.
    let unasked = made(plate(), 0.1, |_| {});
    let d = unasked.report.check.as_ref().unwrap().deviation.unwrap();
    assert!(d.max < 2.0 * 0.1 / 120.0 && d.from_surface.unwrap() < 2.0 * 0.1 / 120.0, "{d:?}");
    for m in [&coarse, &fine, &tight, &local, &unasked] {
        let c = m.report.check.as_ref().unwrap();
        assert!(c.certificate.is_sound() && c.quality.min_angle > 20.0, "{:?}", c.quality);
    }
}

#[test]
fn creases_inside_one_formula_are_edges() {
    let [x, y, z] = [Expr::x(), Expr::y(), Expr::z()].map(|e| Expr::unary(Unary::Abs, e));
    for (turn, size) in [(false, 0.1), (true, 0.07)] {
        let octahedron = Solid::formula(Expr::constant(1.0) - (x.clone() + y.clone() + z.clone()));
        // Of the turned one no box can be proved.
        let c = exact(if turn { turned(octahedron) & cuboid([-2.0; 3], [2.0; 3]) } else { octahedron }, size);
        assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 6));
        assert_abs_diff_eq!(c.volume.unwrap(), 4.0 / 3.0, epsilon = 1e-9);
    }
}

/// Ribs, notches and right-angled corners at a size that is a fifth of them: what relocation and flips leave is made better.
#[test]
fn small_angles_are_raised_as_far_as_borders_allow() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/bracket.py");
    let options = MeshOptions { size: Some(SizeRequest::Length(0.0773)), ..MeshOptions::default() };
    let made = mesh_part(&load_part(&path, &[]).unwrap(), &options, &Run::new()).unwrap();
    let quality = made.report.check.unwrap().quality;
    assert!(quality.p05_angle >= 47.0 && quality.mean_radius_ratio > 0.982, "{quality:?}");
}

/// Solids far smaller than the size, of more leaves than one brick of cells can look at everywhere: all of them come out.
#[test]
fn many_solids_smaller_than_the_cells_come_out_whole() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/many_solids.py");
    let part = load_part(&path, &[("count".into(), 100.0)]).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Length(0.42)), ..MeshOptions::default() };
    let check = mesh_part(&part, &options, &Run::new()).unwrap().report.check.unwrap();
    assert_eq!((check.euler, check.self_intersections), (200, 0));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    // A ball is one face, and is worked on in parts.
    let ball = Primitive::Sphere { r: 1.0, at: DVec3::ZERO }.into();
    // What comes out of this one at sharp angles is made of the leaves' own surfaces.
    let sheet = Primitive::Tpms { kind: Tpms::Gyroid, period: 2.0, thickness: 0.4, at: DVec3::ZERO };
    let cut = Solid::from(sheet) & Solid::sphere(1.2, DVec3::ZERO);
    for (solid, size) in [(turned(cube_with_holes()), 0.09), (ball, 0.02), (cut, 0.1)] {
        let part = Part::from_solid(solid);
        let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
        let meshes = [1, 2, 3, 16]
            .map(|threads| mesh_part(&part, &options, &Run::new().with_threads(threads).unwrap()).unwrap().mesh);
        assert!(meshes.iter().all(|m| *m == meshes[0]));
    }
}

#[test]
fn a_large_face_shows_no_trace_of_its_parts() {
    let (ball, size) = (Solid::from(Primitive::Sphere { r: 1.0, at: DVec3::ZERO }), 0.02);
    let c = exact(ball.clone(), size);
    assert_eq!((c.euler, c.features.unwrap().corners_true), (2, 0));
    let q = c.quality;
    assert!(q.min_angle > 35.0 && q.p05_angle > 48.0 && q.mean_radius_ratio > 0.985, "{q:?}");
}

#[test]
fn a_part_is_a_model_with_a_fragment_for_every_face() {
    // A ball cuts a corner off a block with a bore: three of the sides have five edges, and two have a second loop.
    let block = cuboid([-1.0; 3], [1.0; 3]) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None);
    let made = made(block - Primitive::Sphere { r: 0.5, at: DVec3::ONE }.into(), 0.08, |_| {});
    let cut = made.model().unwrap();
    assert_eq!(cut.model.check(), []);
    assert_eq!((cut.model.faces.len(), cut.model.shells.len()), (8, 1));
    let rims = cut.model.edges.iter().filter(|e| e.is_closed()).count();
    assert_eq!((cut.model.edges.len() - rims, rims), (12 + 3, 2));
    assert_eq!(cut.model.vertices.len(), 7 + 3 + 2);
    let mut borders: Vec<(&str, Vec<usize>)> = cut
        .model
        .faces
        .iter()
        .map(|f| {
            let name = cut.model.names[f.label as usize].as_str();
            (name, f.loops.iter().map(|l| l.coedges().len()).collect())
        })
        .collect();
    borders.sort();
    let of = |name: &str| borders.iter().find(|b| b.0.ends_with(name)).unwrap().1.clone();
    assert_eq!([of("xmin"), of("xmax"), of("ymax")], [vec![4], vec![5], vec![5]]);
    assert_eq!(["zmax", "zmin"].map(|name| of(name).into_iter().sum::<usize>()), [6, 5]);
    // Nodes of a face lie on its surface, those of an edge on the surfaces of both its faces.
    let off = |face: u32, p: &DVec3| {
        let name = &cut.model.names[cut.model.faces[face as usize].label as usize];
        let side = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"].iter().position(|s| name.ends_with(s));
        let away = match side {
            Some(k) => p[k / 2].abs() - 1.0,
            None if name.starts_with("cylinder") => p.truncate().length() - 0.4,
            None => p.distance(DVec3::ONE) - 0.5,
        };
        away.abs()
    };
    for (face, f) in (0..).zip(cut.fragments.faces()) {
        assert!(f.nodes().all(|p| off(face, p) < 1e-12));
    }
    for (edge, faces) in cut.model.faces_of_edges().into_iter().enumerate() {
        assert_eq!(faces.len(), 2);
        let nodes = cut.fragments.edge_inner(edge).iter().copied().chain(cut.fragments.edge_ends(edge));
        assert!(nodes.into_iter().all(|p| faces.iter().all(|f| off(*f, &p) < 1e-12)));
    }
    let merged = Merged::new(cut.model, cut.fragments).unwrap();
    assert_eq!((merged.node_count(), merged.cell_count()), (made.mesh.nodes.len(), made.mesh.triangles.len()));
    assert_eq!(merged.node(0), made.mesh.nodes[cut.nodes[0] as usize]);
}

#[test]
fn pipes_of_equal_radius_cross_in_two_joints() {
    // Each bore is two faces that touch in the joints only: with the cube's sides ten faces.
    let straight = cube_with_holes();
    for (solid, (rotation, shift)) in [(straight.clone(), (DMat3::IDENTITY, DVec3::ZERO)), (turned(straight), turn())] {
        let made = made(solid, 0.1, |_| {});
        assert_eq!(made.report.shortfalls, Vec::new());
        let cut = made.model().unwrap();
        assert_eq!(cut.model.check(), []);
        assert_eq!(cut.model.faces.len(), 10);
        for at in [DVec3::Y * 0.4, DVec3::NEG_Y * 0.4] {
            let near = |p: &DVec3| p.distance(rotation * at + shift);
            let joint = made.corners.iter().map(|v| made.mesh.nodes[*v as usize]).map(|p| near(&p)).fold(1.0, f64::min);
            assert!(joint < 1e-9, "{joint}");
        }
    }
}

/// A channel of this width through everything, along an axis and beside the middle by so much in the two others.
fn channel(width: f64, axis: usize, aside: [f64; 2]) -> Solid {
    let mut at = [0.0; 3];
    at[(axis + 1) % 3] = aside[0];
    at[(axis + 2) % 3] = aside[1];
    let side = |sign: f64| std::array::from_fn(|k| if k == axis { sign * 9.0 } else { at[k] + sign * width / 2.0 });
    cuboid(side(-1.0), side(1.0))
}

#[test]
fn three_channels_of_one_width_cross_in_corners_of_six_faces() {
    // Near such a corner a point is inside where it is inside any two of three planes: each plane bounds twice.
    let width = 1.0 / 3.0;
    let crossed = (0..3).fold(cuboid([-0.5; 3], [0.5; 3]), |solid, axis| solid - channel(width, axis, [0.0; 2]));
    for solid in [crossed.clone(), turned(crossed)] {
        for size in [0.05, 0.07] {
            let c = exact(solid.clone(), size);
            assert_eq!((c.euler, c.features.unwrap().corners_true), (-8, 40));
            assert_abs_diff_eq!(c.volume.unwrap(), 20.0 / 27.0, epsilon = 1e-9);
            assert!(c.quality.min_angle >= 30.0, "{:?}", c.quality);
        }
    }
}

#[test]
fn copies_around_an_axis_cross_in_points_of_many_faces() {
    let ring = "revolve(polygon([(.2, -.2), (.5, -.2), (.56, .14), (.25, .14)]))";
    let prism = "extrude(polygon([(-.5, -.3), (.5, -.3), (0, .3)]), 1.6).rotate(90, axis='x')";
    for (text, euler, corners) in [
        // Rims that cross on each other's faces, and the joints of cones.
        (format!("a = {ring}\npart(a.rotate(70, axis='x') | a.rotate(70, axis='y'))"), -4, 24),
        (format!("a = {prism}\npart((a | a.rotate(90, axis='z')).rotate(71, axis=(1, 2, 2)))"), 2, 17),
        (
            "a = cylinder(.1, axis='y', height=.67)\npart(union([a.rotate(51*i, axis='z') for i in range(3)]))".into(),
            2,
            0,
        ),
        (
            "a = cylinder(.2, axis='x', height=2)\npart(union([a.rotate(30*i, axis='z') for i in range(6)]))".into(),
            2,
            0,
        ),
    ] {
        let part = rvachev::implicit::part::parse(&text, &[]).unwrap();
        let options = MeshOptions { size: Some(SizeRequest::Share(0.05)), ..MeshOptions::default() };
        let report = mesh_part(&part, &options, &Run::new()).unwrap().report;
        assert!(report.shortfalls.is_empty(), "{text}: {:?}", report.shortfalls);
        let c = report.check.unwrap();
        assert!(c.certificate.is_sound() && c.euler == euler, "{text} {}", c.euler);
        let (f, d) = (c.features.unwrap(), c.deviation.unwrap());
        // Next to joints edges are hardly sharp.
        assert!(f.recall > 0.95 && f.corners_found == corners && f.corners_true == corners, "{text} {f:?}");
        assert!(d.max < 0.01 && d.from_surface.unwrap() < 0.03, "{text} {d:?}");
    }
}

#[test]
fn the_menger_sponge_is_exact() {
    let mut sponge = cuboid([-1.5; 3], [1.5; 3]);
    for axis in 0..3 {
        sponge = sponge - channel(1.0, axis, [0.0; 2]);
        for (u, v) in (0..9).map(|k| (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0)) {
            sponge = sponge - channel(1.0 / 3.0, axis, [u, v]);
        }
    }
    let c = exact(sponge, 0.15);
    assert_eq!(c.euler, 2 - 2 * 81);
    assert_abs_diff_eq!(c.volume.unwrap(), 27.0 * (20.0f64 / 27.0).powi(2), epsilon = 1e-9);
}

#[test]
fn sharp_wedges_are_exact_to_their_tips() {
    // Two half-spaces at an angle make the edge along z; cells see its tip as scattered bits.
    for degrees in [3.0_f64, 12.0, 20.0, 30.0, 42.0, 60.0] {
        let (s, c) = (0.5 * degrees.to_radians()).sin_cos();
        let wedge = cuboid([-2.0, -1.0, -0.5], [1.0, 1.0, 0.5])
            & Solid::half_space(DVec3::new(-s, c, 0.0), DVec3::ZERO)
            & Solid::half_space(DVec3::new(-s, -c, 0.0), DVec3::ZERO);
        for solid in [wedge.clone(), turned(wedge.clone())] {
            let made = made(solid, 0.07, |_| {});
            let check = made.report.check.as_ref().unwrap();
            assert_eq!(made.report.shortfalls, Vec::new(), "{degrees} degrees");
            assert_eq!((check.components, check.euler), (1, 2), "{degrees} degrees");
            let width = (0.5 * degrees.to_radians()).tan();
            assert!(
                abs_diff_eq!(check.volume.unwrap(), width, epsilon = 1e-9),
                "{degrees} degrees: {} {width}",
                check.volume.unwrap()
            );
        }
    }
}

#[test]
fn only_the_triangle_at_a_tip_has_its_narrow_angle() {
    let mut others = 0;
    for degrees in [18.0_f64, 21.0, 24.0, 27.0, 32.0, 38.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let wedge = cuboid([-2.0, -1.0, -0.5], [1.0, 1.0, 0.5])
            & Solid::half_space(DVec3::new(-s, c, 0.0), DVec3::ZERO)
            & Solid::half_space(DVec3::NEG_Y, DVec3::ZERO);
        for solid in [wedge.clone(), turned(wedge)] {
            for size in [0.05, 0.09, 0.16] {
                let made = made(solid.clone(), size, |_| {});
                assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
                let c = made.report.check.unwrap().certificate;
                assert!(c.excused <= 2, "{degrees} degrees, {size}: {c:?}");
                others += c.below_30 - c.excused;
            }
        }
    }
    // Rows behind the tip as long as wide; with even steps along its borders each of the 36 meshes had two to six others.
    assert!(others <= 9, "{others}");
}

#[test]
fn tips_thinner_than_the_cells_come_to_their_points() {
    // Half angles of 13 and of 5 degrees: at these sizes cells see the tips end two to six cells below their points.
    for (radius, sizes) in [(0.7, [0.65, 0.4, 0.26, 0.13]), (0.26, [0.3, 0.2, 0.15, 0.1])] {
        let points = [[-1.0, -1.0], [1.0, -1.0], [0.13, 1.21]].map(|[x, y]| DVec3::new(x, y, 3.0));
        let spike = |tip: &DVec3| {
            let cone = Primitive::Cone { r0: radius, r1: 0.0, height: 3.0, axis: DVec3::Z, at: *tip - 1.5 * DVec3::Z };
            Solid::from(cone)
        };
        let plate = cuboid([-2.0, -2.0, -0.5], [2.0, 2.0, 0.0]);
        let solid = points.iter().fold(plate, |s, tip| s | spike(tip));
        for size in sizes {
            let made = made(solid.clone(), size, |_| {});
            assert!(made.report.shortfalls.is_empty(), "{size}: {:?}", made.report.shortfalls);
            assert_eq!(made.report.attempts.len(), 1, "{size}");
            let c = made.report.check.unwrap();
            assert!(c.certificate.is_sound() && c.euler == 2);
            assert!(
                points.iter().all(|tip| made.mesh.nodes.iter().any(|p| p.distance(*tip) < 1e-12)),
                "{radius} {size}"
            );
            let f = c.features.unwrap();
            assert_eq!((f.corners_found, f.corners_true), (11, 11));
            let d = c.deviation.unwrap();
            assert!(d.inverted == 0 && d.max < 0.1 * size && d.from_surface.unwrap() < 0.1 * size, "{size}: {d:?}");
            let volume = 8.0 + points.len() as f64 * PI * radius * radius;
            assert!(
                relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 0.01),
                "{size}: {} of {volume}",
                c.volume.unwrap()
            );
        }
    }
}

#[test]
fn necks_that_cells_tear_are_found_by_their_distance() {
    // Goursat's surface of genus 5; with cells of the size one of its twelve necks is seen as two bodies.
    let text = "f = x**4 - 5*x**2 + y**4 - 5*y**2 + z**4 - 5*z**2 + 11.8\n\
                part(solid(f <= 0), domain=((-3, -3, -3), (3, 3, 3)))";
    let part = rvachev::implicit::part::parse(text, &[]).unwrap();
    for size in [0.6, 0.52, 0.45, 0.4] {
        let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
        let report = mesh_part(&part, &options, &Run::new()).unwrap().report;
        assert!(report.shortfalls.is_empty() && report.warnings.is_empty(), "{report:?}");
        let c = report.check.unwrap();
        assert_eq!((c.components, c.euler), (1, -8), "{size}");
        let d = c.deviation.unwrap();
        assert!(d.max < 0.05 * size && d.from_surface.unwrap() < 0.05 * size, "{size}: {d:?}");
    }
}

/// A part bounded by a formula of period 1.5, called `f` in its text.
fn periodic(formula: &str, text: &str, share: f64) -> Check {
    let text = format!("k = 2*pi/1.5\nX = k*(x+0.1)\nY = k*(y+0.07)\nZ = k*(z-0.05)\nf = {formula}\npart({text})");
    let part = rvachev::implicit::part::parse(&text, &[]).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Share(share)), ..MeshOptions::default() };
    let report = mesh_part(&part, &options, &Run::new()).unwrap().report;
    assert!(report.shortfalls.is_empty(), "{text} {share}: {:?}", report.shortfalls);
    let c = report.check.unwrap();
    assert!(c.closed && c.manifold && c.oriented);
    c
}

#[test]
fn islands_of_a_formula_smaller_than_the_cells_are_found_beside_its_other_pieces() {
    // Six places where necks of the network, cut off by the box, come in again: no corner of any cell lies in them.
    for share in [0.05, 0.04, 0.025] {
        let c = periodic("cos(X)+cos(Y)+cos(Z)", "box(size=(2, 2, 2)) & solid(f >= 0)", share);
        assert_eq!((c.components, c.euler, c.self_intersections), (7, 14, 0), "{share}");
    }
}

#[test]
fn sheets_that_graze_faces_meet_them_in_exact_edges() {
    // Sheets of minimal surfaces, thinner than the cells, nearly tangent to a face here and there: there the borders that two
    // leaves find of each other run differently until the leaves are made finer.
    let gyroid = "sin(X)*cos(Y)+sin(Y)*cos(Z)+sin(Z)*cos(X)";
    let frd = "4*cos(X)*cos(Y)*cos(Z)-(cos(2*X)*cos(2*Y)+cos(2*Y)*cos(2*Z)+cos(2*Z)*cos(2*X))";
    for (formula, body, euler) in [
        (gyroid, "cylinder(1.1, height=2)", -34),
        (gyroid, "sphere(1.2)", -30),
        (gyroid, "box(size=(2, 2, 2))", -38),
        (frd, "sphere(1.2)", -158),
    ] {
        for share in [0.05, 0.025] {
            let c = periodic(formula, &format!("{body} & solid(f <= 0.4) & solid(f >= -0.4)"), share);
            assert_eq!((c.components, c.euler, c.self_intersections), (1, euler, 0), "{body} {share}");
            let d = c.deviation.unwrap();
            assert!(d.max < 0.02 && d.from_surface.unwrap() < 0.02, "{body} {share}: {d:?}");
        }
    }
}

#[test]
fn walls_far_thinner_than_the_size_are_meshed_whole() {
    // A block with a fin on top: sheets of 1/3 to 1/10 000 of the size, which no cells see.
    for (thickness, turn) in [(0.03, true), (0.012, true), (0.008, false), (1e-3, true), (1e-5, false)] {
        let fin = cuboid([-1.0, 0.0, 0.0], [1.0, thickness, 1.0]);
        let solid = cuboid([-1.0, -0.5, -0.5], [1.0, 0.5, 0.0]) | fin;
        let c = exact(if turn { turned(solid) } else { solid }, 0.1);
        assert_eq!((c.euler, c.components), (2, 1));
        // The measure takes corners for one that are as close as the foil makes them.
        assert_eq!(c.features.unwrap().corners_true, if thickness < 1e-4 { 12 } else { 16 });
        let volume = 1.0 + 2.0 * thickness;
        assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 1e-12);
    }
}

#[test]
fn faces_that_run_together_meet_in_exact_edges() {
    // The sides of a sheet come out of a ball at any angle, down to a few degrees.
    for (period, thickness, radius) in [(2.0, 0.4, 1.7), (2.5, 0.8, 3.1), (3.0, 0.5, 2.7)] {
        let sheet = Solid::from(Primitive::Tpms { kind: Tpms::Gyroid, period, thickness, at: DVec3::ZERO });
        let c = exact(sheet & Solid::sphere(radius, DVec3::ZERO), 0.06 * radius);
        assert!(c.quality.min_angle > 25.0 && c.quality.p05_angle > 45.0, "{:?}", c.quality);
    }
}

#[test]
fn curved_walls_thinner_than_chords_are_high_get_shorter_edges() {
    // Chords are 1/1200 high at first: closed shells, and one open at its rim.
    let ball = |r| Solid::sphere(r, DVec3::ZERO);
    for (thickness, half, euler) in [(2e-3, false, 4), (2e-3, true, 2), (5e-4, true, 2)] {
        let shell = ball(1.0) - ball(1.0 - thickness);
        let solid = if half { shell & Solid::half_space(-DVec3::Z, DVec3::ZERO) } else { shell };
        let made = made(solid, 0.1, |_| {});
        assert_eq!(made.report.shortfalls, Vec::new(), "{thickness}");
        let c = made.report.check.unwrap();
        assert!(c.certificate.is_sound() && c.euler == euler, "{thickness}: {:?}", c.certificate);
        let volume = 4.0 / 3.0 * PI * (1.0 - (1.0 - thickness).powi(3)) * if half { 0.5 } else { 1.0 };
        assert!(
            relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 0.01),
            "{thickness}: {} {volume}",
            c.volume.unwrap()
        );
    }
}

#[test]
fn what_no_cells_find_is_named_with_its_place() {
    // No triangles of a sensible size keep the two sides of a curved shell apart that is 1/10 000 of the size thick.
    let ball = |r| Solid::sphere(r, DVec3::ZERO);
    let shell = (ball(0.5) - ball(0.49999)) & Solid::half_space(-DVec3::Z, DVec3::ZERO);
    let made = made(cuboid([-0.6, -0.6, -0.6], [0.6, 0.6, -0.4]) | shell, 0.1, |_| {});
    assert!(
        made.report
            .shortfalls
            .iter()
            .map(ToString::to_string)
            .any(|s| s.contains("is not in the mesh") || s.contains("on sphere")),
        "{:?}",
        made.report.shortfalls
    );
}

#[test]
fn features_smaller_than_the_cells_are_meshed_or_named() {
    // Cells are .1 wide at first, and at least .0125.
    let cube = || cuboid([-1.0; 3], [1.0; 3]);
    let at = |z: f64| DVec3::new(0.3, 0.2, z);
    let rod = |r: f64, z: f64, long: f64| Solid::cylinder(r, DVec3::Z, at(z), Some(long));
    let slit = |t: f64| cuboid([-2.0, -2.0, 0.31], [2.0, 2.0, 0.31 + t]);
    for (r, meshed) in [(0.03, true), (0.01, true), (0.002, false)] {
        let tube = PI * r * r;
        let ball = 4.0 / 3.0 * tube * r;
        let cases = [
            ("ball", cube() | Solid::sphere(r, at(1.7)), 4, 8.0 + ball, meshed),
            ("void", cube() - Solid::sphere(r, at(0.7)), 4, 8.0 - ball, meshed),
            ("wire", cube() | rod(r, 0.5, 2.5), 2, 8.0 + 0.75 * tube, meshed),
            ("hole", cube() - rod(r, 0.0, 4.0), 0, 8.0 - 2.0 * tube, meshed),
            // Planes are found however near others are.
            ("pin", cube() | cuboid([0.3, 0.2, 1.0], [0.3 + r, 0.2 + r, 1.5]), 2, 8.0 + 0.5 * r * r, true),
            ("slit", cube() - slit(r), 4, 8.0 - 4.0 * r, true),
        ];
        for (name, solid, euler, volume, meshed) in cases {
            let made = made(solid, 0.1, |_| {});
            let (c, told) = (made.report.check.unwrap(), made.report.shortfalls);
            assert!(c.certificate.is_sound(), "{name} {r}");
            if meshed {
                assert_eq!(told, Vec::new(), "{name} {r}");
                assert_eq!(c.euler, euler, "{name} {r}");
                // Edges are no shorter than a quarter of the cells, so thin rods are prisms of few sides.
                let flat = ["slit", "pin"].contains(&name);
                let most = if flat { 1e-12 } else { 0.3 * (volume - 8.0).abs() };
                assert!(
                    abs_diff_eq!(c.volume.unwrap(), volume, epsilon = most),
                    "{name} {r}: {} {volume}",
                    c.volume.unwrap()
                );
            } else if told.is_empty() {
                assert_eq!(c.euler, euler, "{name} {r}");
            } else {
                assert!(told.iter().any(|s| s.to_string().contains("is not in the mesh")), "{name} {r}: {told:?}");
            }
        }
    }
}

#[test]
fn bumps_of_half_the_size_are_meshed() {
    // Most of a ball on a face: marching cubes cuts the smaller ones off, or shows them by triangles in the face.
    for r in [0.03, 0.045, 0.06] {
        let c = exact(cuboid([-1.0; 3], [1.0; 3]) | Solid::sphere(r, DVec3::new(0.3, 0.2, 1.0 + 0.5 * r)), 0.1);
        let bump = 27.0 / 32.0 * 4.0 / 3.0 * PI * r.powi(3);
        assert!(
            c.euler == 2 && (c.volume.unwrap() - 8.0 - bump).abs() < 0.1 * bump,
            "{r}: {} {bump}",
            c.volume.unwrap() - 8.0
        );
    }
}

#[test]
fn sizes_follow_gaps_between_borders_and_asked_the_thickness_of_walls() {
    let plate = || cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.05]);
    let strip = made(plate(), 0.1, |_| {}).report.check.unwrap();
    assert!(strip.certificate.is_sound() && strip.quality.min_angle > 34.0, "{:?}", strip.quality);
    // Edges of 1.15 widths on the four sides: rows of about 35 nodes each, above and below.
    let on =
        |c: &Check, end: &str| c.groups.iter().filter(|g| g.name.ends_with(end)).map(|g| g.triangles).sum::<usize>();
    assert!((64..80).contains(&on(&strip, "xmin")), "{}", on(&strip, "xmin"));
    let wall = made(plate(), 0.1, |o| o.thickness = Some(1.0)).report.check.unwrap();
    let expected = 4.0 / (3f64.sqrt() / 4.0 * 0.05 * 0.05);
    let top = on(&wall, "zmax") as f64;
    assert!(wall.certificate.is_sound() && (0.8 * expected..1.3 * expected).contains(&top), "{top} {expected}");
    // A cube is as thick as it is wide: nothing changes.
    let cube = |ratio| made(cuboid([-1.0; 3], [1.0; 3]), 0.2, |o| o.thickness = ratio).mesh;
    assert_eq!(cube(None), cube(Some(0.5)));
}

/// The cube with two holes as one formula, as \[LIS14\] writes it: conjunctions by `f + g - sqrt(f^2 + g^2)` all the way.
fn one_formula(and: impl Fn(Expr, Expr) -> Expr) -> Solid {
    let [x2, y2, z2] = [Expr::x(), Expr::y(), Expr::z()].map(|e| e.clone() * e);
    let plate = |e: &Expr| Expr::constant(1.0) - e.clone();
    let outside = |a: &Expr, b: &Expr| a.clone() + b.clone() - 0.16;
    let cube = and(and(plate(&x2), plate(&y2)), plate(&z2));
    Solid::formula(and(and(cube, outside(&x2, &y2)), outside(&y2, &z2)))
}

#[test]
fn r_operations_inside_one_formula_give_its_edges() {
    let sqrt = |e| Expr::unary(Unary::Sqrt, e);
    let square = |e: &Expr| e.clone() * e.clone();
    let r0 = |f: Expr, g: Expr| f.clone() + g.clone() - sqrt(square(&f) + square(&g));
    let ralpha = |f: Expr, g: Expr| {
        let under = square(&f) + square(&g) - f.clone() * g.clone() * 0.8;
        (f + g - sqrt(under)) / 1.4
    };
    let r0m = |f: Expr, g: Expr| {
        let sum = square(&f) + square(&g);
        (f + g - sqrt(sum.clone())) * Expr::binary(rvachev::implicit::expr::Binary::Pow, sum, 0.5.into())
    };
    let volume = exact(cube_with_holes(), 0.1).volume.unwrap();
    for solid in [one_formula(r0), one_formula(ralpha), one_formula(r0m)] {
        let c = exact(solid, 0.1);
        assert_eq!((c.genus, c.features.unwrap().corners_true), (Some(3), 8));
        assert_abs_diff_eq!(c.volume.unwrap(), volume, epsilon = 1e-2);
    }
}

#[test]
fn creases_of_a_closure_are_recovered_by_default() {
    let closure = |p: DVec3| {
        let and = |f: f64, g: f64| f + g - f.hypot(g);
        let [x, y, z] = (p * p).to_array();
        and(and(and(and(1.0 - x, 1.0 - y), 1.0 - z), x + y - 0.16), y + z - 0.16)
    };
    let size = 0.08;
    let mut part = Part::from_solid(Solid::field(closure));
    part.domain = Some(rvachev::spatial::Aabb::new(DVec3::splat(-1.3), DVec3::splat(1.4)));
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new()).unwrap();
    assert_eq!(made.report.method, "cut", "{:?}", made.report.warnings);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    // The closure knows no edges: the mesh is measured against the solid that does.
    let known = Part::from_solid(cube_with_holes());
    let c = rvachev::pipeline::against(&made.mesh, &known, &Run::new()).unwrap();
    let f = c.features.unwrap();
    assert!(f.recall >= 0.99 && f.precision >= 0.97 && f.corners_found == 8, "{f:?}");
    assert!(c.certificate.is_sound() && c.deviation.unwrap().max < 0.2 * size);
}

#[test]
fn the_arrangement_alone_makes_the_samples_exact() {
    use rvachev::pipeline::Tried;
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    for name in [
        "cube_with_holes",
        "cube_with_holes_rotated",
        "bracket",
        "lattice",
        "formula",
        "gyroid_block",
        "small_features",
    ] {
        let part = load_part(&data.join(name).with_extension("py"), &[]).unwrap();
        let options = MeshOptions::default();
        let made = mesh_part(&part, &options, &Run::new()).unwrap();
        assert_eq!(made.report.shortfalls.len(), 0, "{name}: {:?}", made.report.shortfalls);
        let [attempt] = &made.report.attempts[..] else { panic!("{name}: {:?}", made.report.attempts) };
        let proof = attempt.proof.as_ref().unwrap();
        assert!(attempt.rung == Tried::Arrange && attempt.kept && proof.astray == 0, "{name}: {attempt:?}");
        assert!(proof.unproved * 10 < proof.cells, "{name}: {proof:?}");
        let f = made.report.check.unwrap().features.unwrap();
        assert!(f.recall > 0.99 && f.corners_found == f.corners_true, "{name}: {f:?}");
    }
}
