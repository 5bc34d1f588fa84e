//! Each operator on parts whose surface is known exactly.

use std::f64::consts::PI;

use approx::assert_abs_diff_eq;
use glam::{DMat3, DVec3};
use proptest::prelude::*;

use super::testing::{TestPart, march, measure};
use super::*;
use crate::error::Error;
use crate::geometry::SurfaceOracle;
use crate::mesh::curvature::dihedral;
use crate::mesh::{EditMesh, TriMesh};
use crate::run::{CancelToken, Run};
use crate::sizing::{LONG, Sizing};

fn extracted(part: &TestPart, n: usize) -> (EditMesh, f64) {
    (EditMesh::new(&march(part, n)).unwrap(), 2.0 * part.half / n as f64)
}

fn on_surface(mesh: &EditMesh, part: &TestPart) -> f64 {
    mesh.nodes().map(|v| part.value(mesh.point(v)).abs()).fold(0.0, f64::max)
}

fn smallest_angle(mesh: &EditMesh) -> f64 {
    let worst = mesh.triangles().map(|t| guard::sharpest_cosine(mesh.corner_points(t))).fold(0.0, f64::max);
    worst.acos().to_degrees()
}

#[test]
fn n_lowers_the_normal_deviation_and_stays_on_the_surface() {
    let part = TestPart::sphere(1.0);
    let (mut m, h) = extracted(&part, 14);
    let run = Run::new();
    smooth_all(&mut m, &part, h, &run).unwrap();
    let before = normal_deviation(&m, &part, h, &run).unwrap();
    let moves = align_normals(&mut m, &part, h, normal::DAMPING, &run).unwrap();
    let after = normal_deviation(&m, &part, h, &run).unwrap();
    assert!(moves.moved > 100 && after.normal < before.normal, "{before:?} {after:?}");
    assert!(on_surface(&m, &part) < 1e-9);
    assert_eq!(after.inverted, 0);
}

#[test]
fn n1_finds_creases_and_turns_no_triangle_over() {
    for turn in [DMat3::IDENTITY, TestPart::generic_turn()] {
        let part = TestPart::cube_with_holes(turn);
        let (mut m, h) = extracted(&part, 40);
        let run = Run::new();
        let normals: Vec<DVec3> = m.triangles().map(|t| m.area_vector(t)).collect();
        let before = measure(&m.to_mesh(), &part, h);
        let moves = snap_to_planes(&mut m, &part, h, 0.0, &run).unwrap();
        let after = measure(&m.to_mesh(), &part, h);
        assert!(moves.moved > 0 && moves.largest <= 2.0 * h);
        assert!(before.recall < 0.3 && after.recall > 0.6, "{before:?} {after:?}");
        assert!(after.normal < 0.5 * before.normal);
        // The guard compares with the triangle before each single move; over a pass none may end up opposite either.
        let turned = m.triangles().filter(|&t| m.area_vector(t).dot(normals[t as usize]) <= 0.0).count();
        assert!(turned * 1000 <= normals.len(), "{turned}");
    }
}

#[test]
fn the_dual_node_lies_on_the_triangles_normal_and_the_surface() {
    let part = TestPart::cube_with_holes(DMat3::IDENTITY);
    let (m, h) = extracted(&part, 20);
    let dual = dual_nodes(&m, &part, h, &Run::new()).unwrap();
    let mut found = 0;
    for t in m.triangles() {
        let Some(foot) = dual[t as usize] else { continue };
        let n = m.area_vector(t).normalize();
        assert!((foot.point - m.centroid(t)).reject_from_normalized(n).length() < 1e-12);
        assert_abs_diff_eq!(part.value(foot.point), 0.0, epsilon = 1e-9);
        found += 1;
    }
    assert!(found * 100 > 95 * m.triangle_count());
}

#[test]
fn smoothing_keeps_nodes_on_the_surface_and_improves_angles() {
    let part = TestPart::sphere(1.0);
    let (mut m, h) = extracted(&part, 14);
    let field = vec![h; m.node_capacity()];
    collapse_short(&mut m, &part, ShortEdges { field: &field, share: 0.3 }, h, &Run::new()).unwrap();
    let before = measure(&m.to_mesh(), &part, h);
    for _ in 0..3 {
        let moves = smooth_all(&mut m, &part, h, &Run::new()).unwrap();
        assert_eq!(moves.missed, 0);
    }
    let after = measure(&m.to_mesh(), &part, h);
    // Caps over a straight edge need a flip; all others get fatter.
    assert!(after.below_20 < 0.5 * before.below_20, "{before:?} {after:?}");
    assert!(after.node_error < 1e-12 && after.inverted == 0);
}

#[test]
fn cutting_makes_every_crease_a_chain_of_edges_between_corners() {
    let part = TestPart::cube_with_holes(DMat3::IDENTITY);
    let (mut m, h) = extracted(&part, 32);
    let run = Run::new();
    let report = cut_creases(&mut m, &part, h, 20.0, &run).unwrap();
    m.check().unwrap();
    assert_eq!(report.corners, 8);
    let classes = classify_by_edges(&m);
    let mut length = 0.0;
    for h in m.edges().filter(|&h| m.is_sharp(h)) {
        length += m.edge_length(h);
        for v in [m.origin(h), m.target(h)] {
            assert!(part.crease_distance(m.point(v), 10.0) < 1e-6, "{v}");
        }
    }
    // Twelve edges of the cube and four circles; the creases between the holes fade out and are not counted on.
    let sure = 24.0 + 4.0 * 0.8 * PI;
    assert!(length > 0.99 * sure && length < sure + 5.0, "{length} {sure}");
    let corner = |v: u32| m.point(v).abs().distance(DVec3::ONE) < 1e-9 && classes.kind(v) == Kind::Corner;
    assert_eq!(m.nodes().filter(|&v| corner(v)).count(), 8);
    // Cutting again finds next to nothing more to cut.
    assert!(cut_creases(&mut m, &part, h, 20.0, &run).unwrap().cuts <= 1);
}

#[test]
fn smoothing_along_creases_evens_them_out_and_leaves_corners_alone() {
    let part = TestPart::plain_cube(TestPart::generic_turn());
    let (mut m, h) = extracted(&part, 24);
    let run = Run::new();
    for _ in 0..2 {
        smooth_all(&mut m, &part, h, &run).unwrap();
    }
    cut_creases(&mut m, &part, h, 20.0, &run).unwrap();
    survey(&mut m, &part, h, &run).unwrap();
    let field = vec![h; m.node_capacity()];
    collapse_short(&mut m, &part, ShortEdges { field: &field, share: 0.5 }, h, &run).unwrap();
    let classes = classify_by_edges(&m);
    assert_eq!(classes.counts()[2], 8);
    let spread = |m: &EditMesh| {
        let lengths: Vec<f64> = m.edges().filter(|&h| m.is_sharp(h)).map(|h| m.edge_length(h)).collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (mean * mean * lengths.len() as f64)
    };
    let before = spread(&m);
    let corners: Vec<u32> = m.nodes().filter(|&v| classes.kind(v) == Kind::Corner).collect();
    let places: Vec<DVec3> = corners.iter().map(|&v| m.point(v)).collect();
    for _ in 0..5 {
        smooth_edges(&mut m, &part, CreaseStep { classes: &classes, c: smooth::ALONG }, h, &run).unwrap();
        smooth_regular(&mut m, &part, &classes, h, &run).unwrap();
    }
    assert!(spread(&m) < 0.7 * before, "{} {before}", spread(&m));
    assert!(corners.iter().zip(&places).all(|(&v, p)| m.point(v) == *p));
    for v in m.nodes().filter(|&v| classes.kind(v) == Kind::Crease) {
        assert!(part.crease_distance(m.point(v), 10.0) < 1e-9);
    }
}

#[test]
fn curvature_classes_find_a_cubes_corners_and_nothing_on_a_sphere() {
    let run = Run::new();
    let part = TestPart::plain_cube(DMat3::IDENTITY);
    let (mut m, h) = extracted(&part, 20);
    for _ in 0..2 {
        snap_to_planes(&mut m, &part, h, 0.0, &run).unwrap();
    }
    let classes = classify_by_curvature(&m, 30.0, &run).unwrap();
    let [regular, crease, corner] = classes.counts();
    assert_eq!(corner, 8);
    assert!(crease > 100 && regular > 4 * crease, "{regular} {crease}");
    for v in m.nodes().filter(|&v| classes.kind(v) == Kind::Crease) {
        assert!(m.outgoing(v).any(|h| dihedral(&m, h).to_degrees() > 30.0));
        if let Some([a, b]) = classes.along(v) {
            assert!(a != b && classes.kind(a) != Kind::Regular && classes.kind(b) != Kind::Regular);
        }
    }

    let part = TestPart::sphere(1.0);
    let (mut m, h) = extracted(&part, 20);
    for _ in 0..3 {
        smooth_all(&mut m, &part, h, &run).unwrap();
    }
    let [_, crease, corner] = classify_by_curvature(&m, 30.0, &run).unwrap().counts();
    assert_eq!((crease, corner), (0, 0));
}

#[test]
fn densification_reaches_the_count_and_the_chord_asked_for() {
    let part = TestPart::sphere(1.0);
    let run = Run::new();
    let sizings = [
        Sizing { size: 1.0, nodes_per_radius: Some(10.0), chord: None, least: 0.01 },
        Sizing { size: 1.0, nodes_per_radius: None, chord: Some(2e-3), least: 0.01 },
    ];
    for sizing in sizings {
        let (mut m, h) = extracted(&part, 10);
        survey(&mut m, &part, h, &run).unwrap();
        let mut field = node_sizes(&sizing, &m, &part, h, &run).unwrap();
        let edits = densify(&mut m, &part, &mut field, h, &run).unwrap();
        m.check().unwrap();
        assert!(edits.splits > 100);
        let longest = m.edges().map(|h| m.edge_length(h)).fold(0.0, f64::max);
        assert!(longest <= LONG * sizing.at(1.0) * (1.0 + 1e-12), "{longest}");
        if let Some(chord) = sizing.chord {
            // The sagitta grows with the square of the length, and edges may be LONG times the size.
            let worst = m.edges().map(|h| 1.0 - (0.5 * (m.point(m.origin(h)) + m.point(m.target(h)))).length());
            assert!(worst.fold(0.0, f64::max) <= LONG * LONG * chord * 1.01);
        }
        assert!(on_surface(&m, &part) < 1e-9);
        assert_eq!(normal_deviation(&m, &part, h, &run).unwrap().inverted, 0);
    }
}

#[test]
fn degenerate_triangles_go_and_flips_raise_the_worst_angle() {
    let part = TestPart::sphere(1.0);
    let (mut m, h) = extracted(&part, 16);
    let run = Run::new();
    survey(&mut m, &part, h, &run).unwrap();
    let before = smallest_angle(&m);
    let flips = flip_for_angles(&mut m, 15.0, &run).unwrap();
    m.check().unwrap();
    assert!(flips > 0 && smallest_angle(&m) >= before);
    for _ in 0..2 {
        remove_degenerate(&mut m, &part, 15.0, h, &run).unwrap();
    }
    m.check().unwrap();
    assert!(before < 5.0 && smallest_angle(&m) > 12.0, "{before} {}", smallest_angle(&m));
    assert!(relax_worst(&mut m, &part, 35.0, h, &run).unwrap() > 0);
    assert!(smallest_angle(&m) > 15.0);
    assert_eq!(survey(&mut m, &part, h, &run).unwrap().inverted, 0);
}

#[test]
fn a_flip_for_normals_lays_the_diagonal_along_the_ridge() {
    // Two triangles over the edge y = z = 1 of the cube, their diagonal across it.
    let part = TestPart::plain_cube(DMat3::IDENTITY);
    let p = [(0.0, 1.0, 1.0), (0.1, 0.9, 1.0), (0.2, 1.0, 1.0), (0.1, 1.0, 0.9)].map(|(x, y, z)| DVec3::new(x, y, z));
    let mut m = EditMesh::new(&TriMesh::new(
        p.to_vec(),
        vec![[0, 1, 3], [1, 2, 3]].into_iter().map(|[a, b, c]: [u32; 3]| [a, b, c]).collect(),
    ));
    let m = m.as_mut().unwrap();
    let run = Run::new();
    let before = normal_deviation(m, &part, 0.2, &run).unwrap();
    assert_eq!(flip_for_normals(m, &part, 0.2, 20.0, &run).unwrap(), usize::from(before.normal > 1e-3));
    assert!(m.edge_between(0, 2).is_some() && normal_deviation(m, &part, 0.2, &run).unwrap().normal < 1e-12);
}

#[test]
fn the_default_sequence_serves_every_test_part() {
    let parts = [
        (TestPart::sphere(1.0), 12, 2),
        (TestPart::plain_cube(TestPart::generic_turn()), 24, 2),
        (TestPart::cube_corner_sphere(), 33, 2),
        (TestPart::cube_with_holes(DMat3::IDENTITY), 33, -4),
        (TestPart::cube_with_holes(TestPart::generic_turn()), 40, -4),
    ];
    for (part, n, euler) in parts {
        let mut mesh = march(&part, n);
        let h = 2.0 * part.half / n as f64;
        let mut seen = Vec::new();
        let options = Options::new(h);
        let report = improve_with(&mut mesh, &part, &options, &Run::new(), &mut |name, m| {
            seen.push((name.to_string(), m.triangles.len()));
        })
        .unwrap();
        let m = measure(&mesh, &part, h);
        assert!(m.closed && m.euler == euler && m.inverted == 0, "{m:?}");
        assert_eq!((report.self_intersections, report.retries, report.after.inverted), (0, 0, 0));
        assert_eq!(m.corners_found, m.corners, "{m:?}");
        assert!(m.precision > 0.97 && m.p05_angle > 38.0 && m.min_angle > 0.1 && m.below_20 < 1e-3, "{m:?}");
        assert!(m.corners == 0 || m.recall > 0.97, "{m:?}");
        assert!(m.node_error < 1e-8 && m.normal <= report.before.normal);
        assert_eq!(seen.len(), options.sequence.operators().len());
        assert_eq!(seen.last().unwrap().1, m.triangles);
        // Labels are the faces under the triangles.
        for t in 0..mesh.triangles.len() {
            let foot = part.project(mesh.centroid(t), h).unwrap();
            assert!(mesh.labels[t] == foot.face || part.crease_distance(mesh.centroid(t), 0.0) < 0.1 * h);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let part = TestPart::cube_with_holes(TestPart::generic_turn());
    let made = [1, 3, 8].map(|threads| {
        let mut mesh = march(&part, 24);
        let run = Run::new().with_threads(threads).unwrap();
        let report = improve(&mut mesh, &part, &Options::new(2.0 * part.half / 24.0), &run).unwrap();
        (mesh, report)
    });
    assert!(made[0] == made[1] && made[0] == made[2]);
}

#[test]
fn an_open_mesh_keeps_its_boundary() {
    let part = TestPart::sphere(1.0);
    let mut mesh = march(&part, 16);
    mesh.triangles =
        (0..mesh.triangles.len()).filter(|&t| mesh.centroid(t).z > 0.0).map(|t| mesh.triangles[t]).collect();
    mesh.labels.truncate(mesh.triangles.len());
    mesh.drop_unused_nodes();
    let rim = |m: &TriMesh| {
        let e = EditMesh::new(m).unwrap();
        let (nodes, edges) = (e.nodes().count() as i64, e.edges().count() as i64);
        let open: f64 = e.edges().filter(|&h| e.opposite(h) == crate::mesh::edit::NONE).map(|h| e.edge_length(h)).sum();
        (nodes - edges + m.triangles.len() as i64, open)
    };
    let before = rim(&mesh);
    improve(&mut mesh, &part, &Options::new(2.6 / 16.0), &Run::new()).unwrap();
    let after = rim(&mesh);
    assert_eq!(before.0, after.0);
    assert!(after.1 > 5.0 && after.1 < before.1 * 1.05, "{before:?} {after:?}");
}

#[test]
fn senseless_requests_and_cancelled_runs_leave_the_mesh_alone() {
    let part = TestPart::sphere(1.0);
    let original = march(&part, 8);
    let mut mesh = original.clone();
    let run = Run::new();
    let bad = [
        Options { size: 0.0, ..Options::new(1.0) },
        Options { size: f64::NAN, ..Options::new(1.0) },
        Options { feature_angle: 180.0, ..Options::new(1.0) },
        Options { chord: Some(-1.0), ..Options::new(1.0) },
    ];
    for options in bad {
        assert!(matches!(improve(&mut mesh, &part, &options, &run), Err(Error::Usage(_))));
    }
    let token = CancelToken::new();
    let stopped = Run::new().with_cancel(token.clone());
    let mut stages = 0;
    let result = improve_with(&mut mesh, &part, &Options::new(0.3), &stopped, &mut |_, _| {
        stages += 1;
        token.cancel();
    });
    assert!(matches!(result, Err(Error::Cancelled)));
    assert_eq!((stages, &mesh), (1, &original));
    let mut broken = TriMesh::new(mesh.nodes.clone(), vec![[0, 1, 2], [0, 1, 3]]);
    assert!(matches!(improve(&mut broken, &part, &Options::new(0.3), &run), Err(Error::Input { .. })));
    let mut empty = TriMesh::default();
    assert_eq!(improve(&mut empty, &part, &Options::new(0.3), &run).unwrap().after, NormalDeviation::default());
}

#[test]
fn operators_go_by_their_names() {
    for op in Operator::all() {
        assert_eq!(op.name().parse::<Operator>().unwrap(), op);
        assert_eq!(op.to_string(), op.name());
    }
    let message = "N2".parse::<Operator>().unwrap_err().to_string();
    assert!(message.contains("unknown operator 'N2'") && message.contains("N1, "));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn random_cuts_of_a_cube_stay_closed_and_whole(
        at in prop::array::uniform3(-1.0f64..1.0),
        r in 0.3f64..0.9,
        axis in prop::array::uniform3(-1.0f64..1.0),
        n in 9usize..16,
    ) {
        let part = TestPart::random_cube(DVec3::from_array(at), r, DVec3::from_array(axis).normalize_or(DVec3::X));
        let mut mesh = march(&part, n);
        // The test's own marching cubes does not resolve every ambiguity.
        prop_assume!(!mesh.triangles.is_empty() && EditMesh::new(&mesh).is_ok());
        let census = |m: &TriMesh| {
            let e = EditMesh::new(m).unwrap();
            (e.nodes().count() as i64 - e.edges().count() as i64 + m.triangles.len() as i64, e.edges().all(|h| e.opposite(h) != crate::mesh::edit::NONE))
        };
        let before = census(&mesh);
        let report = improve(&mut mesh, &part, &Options::new(2.0 * part.half / n as f64), &Run::new()).unwrap();
        prop_assert_eq!(census(&mesh), before);
        prop_assert!(mesh.nodes.iter().all(|p| p.is_finite()));
        // A cylinder that grazes the cube's sides makes a few, which are told.
        let mut bad: Vec<u32> =
            crate::mesh::self_intersections(&mesh, &Run::new()).unwrap().into_iter().flatten().collect();
        bad.sort_unstable();
        bad.dedup();
        prop_assert_eq!(report.self_intersections, bad.len());
        prop_assert!(50 * bad.len() <= mesh.triangles.len(), "{} of {}", bad.len(), mesh.triangles.len());
    }
}
