//! Each kind of defect as a small case, and random damage to closed meshes whose topology is known.

use std::f64::consts::TAU;

use approx::{abs_diff_eq, assert_abs_diff_eq, relative_eq};
use glam::DVec3;
use proptest::prelude::*;

use super::contours::contours;
use super::*;

/// A torus of `n` by `m` quadrilaterals, each halved: Euler characteristic 0.
fn torus(n: u32, m: u32) -> TriMesh {
    let at = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
        DVec3::new((2.0 + v.cos()) * u.cos(), (2.0 + v.cos()) * u.sin(), v.sin())
    };
    let node = |i: u32, j: u32| (i % n) * m + j % m;
    let nodes = (0..n).flat_map(|i| (0..m).map(move |j| at(i, j))).collect();
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    TriMesh::new(nodes, (0..n).flat_map(|i| (0..m).flat_map(move |j| quad(i, j))).collect())
}

/// A box with each face divided into `n` by `n` squares, nodes shared.
fn cuboid(lo: DVec3, hi: DVec3, n: u32) -> TriMesh {
    let mut mesh = TriMesh::new(Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let point = |i: u32, j: u32| {
                let mut p = DVec3::ZERO;
                p[axis] = side;
                p[(axis + 1) % 3] = f64::from(i) / f64::from(n);
                p[(axis + 2) % 3] = f64::from(j) / f64::from(n);
                lo + p * (hi - lo)
            };
            for i in 0..n {
                for j in 0..n {
                    let first = mesh.nodes.len() as u32;
                    mesh.nodes.extend([point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                    let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
                    let two = if side > 0.5 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    mesh.triangles.extend(two);
                    mesh.labels.extend([0, 0]);
                }
            }
        }
    }
    clean::weld(&mut mesh);
    mesh.drop_unused_nodes();
    mesh
}

fn cube(n: u32) -> TriMesh {
    cuboid(DVec3::ZERO, DVec3::ONE, n)
}

fn together(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let n = a.nodes.len() as u32;
    let mut out = a.clone();
    out.nodes.extend(&b.nodes);
    out.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + n)));
    out.labels.extend(&b.labels);
    out
}

fn without(mesh: &TriMesh, gone: impl Fn(usize) -> bool) -> TriMesh {
    let mut out = mesh.clone();
    clean::retain(&mut out, |t| !gone(t));
    out
}

fn healed(mesh: &TriMesh) -> Healed {
    heal(mesh, &HealOptions::default(), &Run::new()).unwrap()
}

/// Heals, and expects a sound result of the given Euler characteristic and number of components.
fn expect(mesh: &TriMesh, euler: i64, components: usize) -> Healed {
    let h = healed(mesh);
    assert!(h.report.is_sound(), "{}", h.report);
    let t = h.mesh.topology(&h.mesh.defects());
    assert_eq!((t.euler, t.components), (euler, components), "{}", h.report);
    h
}

fn found(h: &Healed, defect: Defect, action: Action) -> bool {
    h.report.repairs.iter().any(|r| r.defect == defect && r.action == action)
}

#[test]
fn a_sound_mesh_comes_back_as_it_was() {
    for mesh in [cube(3), torus(12, 8)] {
        let h = healed(&mesh);
        assert_eq!(h.mesh.nodes, mesh.nodes);
        assert_eq!(h.mesh.triangles, mesh.triangles);
        assert!(h.report.repairs.is_empty() && h.report.shortfalls.is_empty(), "{}", h.report);
        assert_eq!(h.report.kept, 1.0);
    }
}

#[test]
fn a_hole_is_closed_to_the_size_around_it() {
    let mesh = cube(8);
    let middle = DVec3::new(0.5, 0.5, 1.0);
    let h = expect(&without(&mesh, |t| mesh.centroid(t).distance(middle) < 0.35), 2, 1);
    assert!(found(&h, Defect::Hole, Action::Filled), "{}", h.report);
    assert!(
        abs_diff_eq!(h.mesh.volume(), 1.0, epsilon = 1e-12),
        "a plane hole is closed in its plane: {}",
        h.mesh.volume()
    );
    let filled = h.mesh.faces.iter().position(|f| f == "filled").unwrap() as u32;
    let of_filling = h.mesh.labels.iter().filter(|l| **l == filled).count();
    assert!((20..200).contains(&of_filling), "{of_filling} triangles");
    // as large as those around it, whose edges are 1/8 and its diagonal
    let lengths: Vec<f64> = (0..h.mesh.triangles.len())
        .filter(|t| h.mesh.labels[*t] == filled)
        .flat_map(|t| {
            let [a, b, c] = h.mesh.corners(t);
            [a.distance(b), b.distance(c), c.distance(a)]
        })
        .collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    assert!((0.1..0.18).contains(&mean) && lengths.iter().all(|l| *l < 0.36), "{mean} {lengths:?}");
}

/// Fillings of a hole in a saddle, before refinement.
#[test]
fn ears_are_cut_and_edges_flipped_while_the_area_falls() {
    let n = 16u32;
    let at = |i: u32| {
        let a = TAU * f64::from(i) / f64::from(n);
        DVec3::new(a.cos(), a.sin(), 0.4 * (2.0 * a).cos())
    };
    // a ring of triangles around the hole
    let mut ring = TriMesh::new((0..n).map(at).chain((0..n).map(|i| 1.5 * at(i))).collect(), Vec::new());
    for i in 0..n {
        let j = (i + 1) % n;
        ring.triangles.extend([[i, n + i, n + j], [i, n + j, j]]);
    }
    ring.labels = vec![0; ring.triangles.len()];
    let inner = contours(&ring).into_iter().find(|c| c.nodes.iter().all(|v| *v < n)).unwrap();
    let edges = sides::Sides::of(&ring.triangles).edges().map(|e| e[0].key).collect();
    let (size, apex) = (vec![0.4; ring.nodes.len()], Default::default());
    let around = fill::HoleSurroundings { mesh: &ring, edges: &edges, size: &size, apex: &apex };
    let made = fill::fill(&around, &inner.nodes, fill::FillingWay::Ears, false).unwrap().unwrap();
    assert_eq!((made.nodes.len(), made.triangles.len()), (0, n as usize - 2));
    let area = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| ring.nodes[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = made.triangles.iter().map(|t| area(*t)).sum();
    // no flip gains any more
    for (i, s) in made.triangles.iter().enumerate() {
        for t in &made.triangles[..i] {
            let shared: Vec<u32> = s.iter().copied().filter(|v| t.contains(v)).collect();
            let [a, b] = shared[..] else { continue };
            let other = |t: &[u32; 3]| t.iter().copied().find(|v| *v != a && *v != b).unwrap();
            let (c, d) = (other(s), other(t));
            let (before, after) = (area(*s) + area(*t), area([a, d, c]) + area([b, d, c]));
            assert!(after >= before * (1.0 - 1e-9), "{s:?} {t:?}");
        }
    }
    let least = fill::fill(&around, &inner.nodes, fill::FillingWay::Area, false).unwrap().unwrap();
    let least: f64 = least.triangles.iter().map(|t| area(*t)).sum();
    let fan: f64 = (1..n - 1).map(|i| area([0, i, i + 1])).sum();
    assert!(total < 1.05 * least && total < fan, "{total} {least} {fan}");
}

#[test]
fn a_filling_that_would_intersect_is_refused() {
    // a bar through the hole in a box's top: whatever closes it passes through the bar
    let box_ = cube(8);
    let open = without(&box_, |t| box_.centroid(t).distance(DVec3::new(0.5, 0.5, 1.0)) < 0.35);
    let bar = cuboid(DVec3::new(0.4, 0.4, 0.5), DVec3::new(0.6, 0.6, 1.5), 1);
    let mut mesh = together(&open, &bar);
    let before = mesh.triangles.clone();
    let mut report = HealReport::default();
    let left = holes::close_holes(&mut mesh, usize::MAX, Defect::Hole, &mut report, &Run::new()).unwrap();
    assert_eq!((left.wanted, left.refused), (0, 1));
    assert_eq!(mesh.triangles, before);
    let [only] = &report.repairs[..] else { panic!("{report}") };
    assert_eq!((only.defect, only.action), (Defect::Hole, Action::Left));
    assert!(DVec3::from_array(only.place).distance(DVec3::new(0.5, 0.5, 1.0)) < 0.1);
    // with a bar that ends below the hole the first way that misses it is taken
    let mut mesh = together(&open, &cuboid(DVec3::new(0.4, 0.4, 0.5), DVec3::new(0.6, 0.6, 0.99), 1));
    let left = holes::close_holes(&mut mesh, usize::MAX, Defect::Hole, &mut report, &Run::new()).unwrap();
    assert_eq!((left.wanted, left.refused), (0, 0));
}

#[test]
fn contours_that_share_a_node_are_loops() {
    // two holes, each two triangles of one side of the node
    let mesh = cube(4);
    let corner = DVec3::new(0.5, 0.5, 1.0);
    let v = mesh.nodes.iter().position(|p| *p == corner).unwrap() as u32;
    let hole = |t: usize, side: f64| {
        mesh.triangles[t].contains(&v) && (mesh.centroid(t) - corner).dot(DVec3::new(1.0, 1.0, 0.0)) * side > 0.1
    };
    let open = without(&mesh, |t| hole(t, 1.0) || hole(t, -1.0));
    let found = contours(&open);
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|c| !c.continued && c.nodes.contains(&v)));
    expect(&open, 2, 1);
}

#[test]
fn a_pair_of_chains_between_two_nodes_is_a_contour() {
    // a cube in two halves that touch in two nodes of their border only: the borders between them are pairs of chains
    let mesh = cube(4);
    let upper = |t: usize| mesh.centroid(t).z > 0.5;
    let mut split = mesh.clone();
    let joined = [DVec3::new(0.0, 0.0, 0.5), DVec3::new(1.0, 1.0, 0.5)];
    for v in 0..mesh.nodes.len() as u32 {
        let p = mesh.nodes[v as usize];
        if p.z == 0.5 && !joined.contains(&p) {
            split.nodes.push(p + DVec3::Z * 0.05);
            let new = split.nodes.len() as u32 - 1;
            (0..split.triangles.len()).filter(|t| upper(*t)).for_each(|t| {
                split.triangles[t].iter_mut().filter(|x| **x == v).for_each(|x| *x = new);
            });
        }
    }
    let found = contours(&split);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found.iter().all(|c| c.nodes.len() == 16), "{found:?}");
    expect(&split, 2, 1);
}

/// Three holes that touch each other in a ring of three nodes: around the tube of a torus, whose two sides hang together,
/// and around a piece that is cut out by them.
#[test]
fn pairs_joined_over_triangles_are_no_contours_of_the_papers() {
    let mesh = torus(24, 9);
    let taken: Vec<u32> = [1, 2, 4, 5, 7, 8].to_vec();
    let open = without(&mesh, |t| mesh.triangles[t].iter().any(|v| taken.contains(v)));
    let found_here = contours(&open);
    assert_eq!(found_here.len(), 3, "{found_here:?}");
    assert!(found_here.iter().any(|c| c.continued), "the paper's iteration stops here");
    let h = expect(&open, 0, 1);
    assert!(found(&h, Defect::Hole, Action::FilledByContinuation), "{}", h.report);
    assert_eq!(
        h.report.repairs.iter().map(|r| r.count).sum::<usize>(),
        found_here.iter().map(|c| c.nodes.len()).sum::<usize>()
    );

    let mesh = torus(24, 18);
    let around = |v: u32| {
        let [i, j] = [i64::from(v / 18) - 12, i64::from(v % 18) - 9];
        i.abs().max(j.abs()) == 3 && i != 0 && j != 0
    };
    let open = without(&mesh, |t| mesh.triangles[t].iter().any(|v| around(*v)));
    let found_here = contours(&open);
    assert_eq!(found_here.len(), 4, "{found_here:?}");
    assert!(found_here.iter().all(|c| !c.continued), "no path over triangles joins the sides");
    let h = expect(&open, 0, 1);
    assert!(!found(&h, Defect::Hole, Action::FilledByContinuation), "{}", h.report);
}

#[test]
fn a_long_contour_stays_open_when_asked() {
    let mesh = cube(4);
    let open = without(&mesh, |t| mesh.centroid(t).z > 0.99);
    let h = heal(&open, &HealOptions { max_hole: Some(15) }, &Run::new()).unwrap();
    assert!(!h.report.closed && found(&h, Defect::Hole, Action::Left), "{}", h.report);
    assert_eq!(h.mesh.triangles.len(), open.triangles.len());
    let h = heal(&open, &HealOptions { max_hole: Some(16) }, &Run::new()).unwrap();
    assert!(h.report.is_sound());
}

#[test]
fn scattered_corners_are_joined() {
    let mesh = torus(16, 10);
    let mut soup = TriMesh::new(Vec::new(), Vec::new());
    for t in 0..mesh.triangles.len() {
        for (k, p) in mesh.corners(t).into_iter().enumerate() {
            let i = (3 * t + k) as f64;
            soup.nodes.push(p + 2e-5 * DVec3::new((i * 1.7).sin(), (i * 2.3).sin(), (i * 3.1).sin()));
        }
        let n = soup.nodes.len() as u32;
        soup.triangles.push([n - 3, n - 2, n - 1]);
        soup.labels.push(0);
    }
    let h = expect(&soup, 0, 1);
    assert!(found(&h, Defect::NearBorders, Action::Merged));
    assert_eq!(h.mesh.triangles.len(), mesh.triangles.len());
}

#[test]
fn a_node_on_an_edge_splits_it() {
    let mut mesh = cube(2);
    let [a, b, c] = mesh.triangles[0];
    mesh.nodes.push(0.4 * mesh.nodes[a as usize] + 0.6 * mesh.nodes[b as usize]);
    let m = mesh.nodes.len() as u32 - 1;
    mesh.triangles[0] = [a, m, c];
    mesh.triangles.push([m, b, c]);
    mesh.labels.push(0);
    let h = expect(&mesh, 2, 1);
    assert!(found(&h, Defect::TJunction, Action::Split), "{}", h.report);
    assert_abs_diff_eq!(h.mesh.volume(), 1.0, epsilon = 1e-12);
}

#[test]
fn duplicates_and_degenerate_triangles_go() {
    let mut mesh = cube(2);
    let sound = mesh.clone();
    let [a, b, c] = mesh.triangles[5];
    let [d, e, f] = mesh.triangles[17];
    mesh.triangles.extend([[b, c, a], [d, f, e], [a, a, b], [a, b, a]]);
    mesh.labels.extend([0; 4]);
    let h = expect(&mesh, 2, 1);
    assert!(
        found(&h, Defect::DuplicateTriangle, Action::Removed) && found(&h, Defect::DegenerateTriangle, Action::Removed)
    );
    assert_eq!(h.mesh.triangles.len(), sound.triangles.len());
    assert!(abs_diff_eq!(h.mesh.volume(), 1.0, epsilon = 1e-12), "of two that face each other the right one stays");
}

#[test]
fn a_fin_goes() {
    let mut mesh = cube(6);
    let [a, b, _] = mesh.triangles[0];
    mesh.nodes.push(mesh.nodes[a as usize] - DVec3::splat(0.05));
    mesh.triangles.push([a, b, mesh.nodes.len() as u32 - 1]);
    mesh.labels.push(0);
    let h = expect(&mesh, 2, 1);
    assert!(found(&h, Defect::Fin, Action::Removed), "{}", h.report);
}

/// The torus of [`torus`] itself.
struct Torus;

impl SurfaceOracle for Torus {
    fn project(&self, p: DVec3, reach: f64) -> Option<crate::geometry::Foot> {
        let ring = 2.0 * DVec3::new(p.x, p.y, 0.0).normalize();
        let normal = (p - ring).normalize();
        let point = ring + normal;
        (point.distance(p) <= reach).then_some(crate::geometry::Foot { point, normal, face: 0 })
    }

    fn curvatures(&self, _: &crate::geometry::Foot) -> Option<[f64; 2]> {
        None
    }
}

#[test]
fn fillings_come_to_the_surface_where_it_is_known() {
    let mesh = torus(40, 24);
    let hole = without(&mesh, |t| mesh.centroid(t).distance(DVec3::new(3.0, 0.0, 0.0)) < 0.9);
    let plain = healed(&hole);
    let h = heal_onto(&hole, &HealOptions::default(), Some(&Torus), &Run::new()).unwrap();
    assert!(h.report.is_sound() && found(&h, Defect::Hole, Action::Projected), "{}", h.report);
    assert_eq!(h.mesh.triangles, plain.mesh.triangles);
    let off =
        |m: &TriMesh, p: &DVec3| Torus.project(*p, 9.0).map_or(9.0, |f| f.point.distance(*p)) / m.bounds().diagonal();
    let worst = |m: &TriMesh| m.nodes.iter().map(|p| off(m, p)).fold(0.0, f64::max);
    assert!(worst(&plain.mesh) > 1e-3 && worst(&h.mesh) < 1e-12, "{:e} {:e}", worst(&plain.mesh), worst(&h.mesh));
    // nodes that were there have not moved
    assert!(hole.nodes.iter().filter(|p| !h.mesh.nodes.contains(p)).all(|p| !plain.mesh.nodes.contains(p)));
}

#[test]
fn scattered_corners_are_joined_beyond_what_a_gap_may_be() {
    let mesh = torus(16, 10);
    let mut soup = TriMesh::new(Vec::new(), Vec::new());
    for t in 0..mesh.triangles.len() {
        for (k, p) in mesh.corners(t).into_iter().enumerate() {
            let i = (3 * t + k) as f64;
            soup.nodes.push(p + 5e-3 * DVec3::new((i * 1.7).sin(), (i * 2.3).sin(), (i * 3.1).sin()));
        }
        let n = soup.nodes.len() as u32;
        soup.triangles.push([n - 3, n - 2, n - 1]);
        soup.labels.push(0);
    }
    let h = expect(&soup, 0, 1);
    assert_eq!(h.mesh.triangles.len(), mesh.triangles.len());
}

/// A torus torn open along `count` edges of its outer equator; one side lies `off` away from the other, up to half of that more
/// or less.
fn torn(count: u32, off: f64) -> (TriMesh, TriMesh) {
    let (n, m) = (48, 24);
    let whole = torus(n, m);
    let mut mesh = whole.clone();
    for i in 1..count {
        let v = i * m;
        let copy = mesh.nodes.len() as u32;
        let away = DVec3::new((1.7 * f64::from(i)).sin(), (2.9 * f64::from(i)).cos(), 0.8).normalize();
        mesh.nodes.push(mesh.nodes[v as usize] + (1.0 + 0.5 * f64::from(i).sin()) * off * away);
        // Those below it.
        for t in 0..mesh.triangles.len() {
            if mesh.triangles[t].contains(&v) && whole.centroid(t).z < 0.0 {
                mesh.triangles[t].iter_mut().filter(|x| **x == v).for_each(|x| *x = copy);
            }
        }
    }
    (whole, mesh)
}

#[test]
fn a_torn_surface_is_joined_farther_than_borders_that_do_not_match() {
    let off = 3.5e-4 * torus(48, 24).bounds().diagonal();
    for count in [3, 20, 47] {
        let (whole, mesh) = torn(count, off);
        let h = expect(&mesh, 0, 1);
        assert_eq!(h.report.repairs.len(), 1, "{}", h.report);
        assert!(found(&h, Defect::NearBorders, Action::Merged), "{}", h.report);
        assert_eq!((h.mesh.nodes.len(), h.mesh.triangles.len()), (whole.nodes.len(), whole.triangles.len()));
        assert!(relative_eq!(h.mesh.area(), whole.area(), epsilon = 0.0, max_relative = 1e-3), "count {count}");
    }
    // With a triangle missing beside the tear it is a hole.
    let (_, mesh) = torn(20, off);
    let beside = (0..mesh.triangles.len()).find(|t| mesh.triangles[*t].contains(&(10 * 24))).unwrap();
    let h = expect(&without(&mesh, |t| t == beside), 0, 1);
    assert!(h.report.repairs.iter().any(|r| r.defect == Defect::Hole), "{}", h.report);
}

#[test]
fn small_and_narrow_fillings_belong_to_the_face_beside_them() {
    let mut whole = cube(8);
    whole.faces = vec!["low".into(), "high".into()];
    whole.labels = (0..whole.triangles.len()).map(|t| u32::from(whole.centroid(t).z > 0.5)).collect();
    let squares = |at: DVec3, half: DVec3| {
        let w = whole.clone();
        without(&whole, move |t| (w.centroid(t) - at).abs().cmplt(half).all())
    };
    let middle = DVec3::new(0.5, 0.5, 1.0);
    // One square, a strip of six, a hole of sixteen: areas of 1/64, 6/64, 16/64.
    for (half, gone) in [(0.07, 0.07), (0.38, 0.07), (0.25, 0.25)]
        .map(|(x, y)| DVec3::new(x, y, 0.01))
        .into_iter()
        .zip([true, true, false])
    {
        let at = if half.y < 0.1 {
            middle - DVec3::new(if half.x < 0.1 { 0.0625 } else { 0.0 }, 0.0625, 0.0)
        } else {
            middle
        };
        let mut mesh = healed(&squares(at, half)).mesh;
        let filled = mesh.faces.iter().position(|f| f == "filled").unwrap() as u32;
        assert!(mesh.labels.contains(&filled), "{half}");
        let count = absorb_fillings(&mut mesh, 0.05, 0.12);
        assert_eq!(count, usize::from(gone), "{half}");
        assert_eq!(mesh.labels.contains(&filled), !gone, "{half}");
        let high: f64 = (0..mesh.triangles.len())
            .filter(|t| mesh.labels[*t] == 1)
            .map(|t| 0.5 * mesh.area_vector(t).length())
            .sum();
        let all = 1.0 + 4.0 * 0.5;
        assert!(abs_diff_eq!(high, if gone { all } else { all - 0.25 }, epsilon = 1e-9), "{half}: {high}");
    }
}

#[test]
fn turned_triangles_turn_back() {
    let mut mesh = torus(12, 8);
    for t in [3, 40, 41, 90] {
        mesh.triangles[t].swap(0, 1);
    }
    let h = expect(&mesh, 0, 1);
    assert!(found(&h, Defect::Orientation, Action::Flipped));
    assert!(h.mesh.volume() > 0.0);
}

#[test]
fn a_body_inside_out_is_turned_and_a_cavity_is_not() {
    let mut inside_out = cube(2);
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_abs_diff_eq!(expect(&inside_out, 2, 1).mesh.volume(), 1.0, epsilon = 1e-12);
    let mut cavity = cuboid(DVec3::splat(0.25), DVec3::splat(0.75), 2);
    cavity.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let h = expect(&together(&cube(2), &cavity), 4, 2);
    assert_abs_diff_eq!(h.mesh.volume(), 0.875, epsilon = 1e-12);
}

#[test]
fn crossing_bodies_are_parted_and_nothing_is_lost() {
    let other = cuboid(DVec3::new(0.31, 0.43, 0.57), DVec3::new(1.31, 1.43, 1.57), 2);
    let h = expect(&together(&cube(2), &other), 4, 2);
    assert!(found(&h, Defect::SelfIntersection, Action::Uncrossed), "{}", h.report);
    assert!(h.report.kept > 0.999 && h.report.touching == 0, "{}", h.report);
    assert!(abs_diff_eq!(h.mesh.volume(), 2.0, epsilon = 1e-3), "both levels together: {}", h.mesh.volume());
}

#[test]
fn bodies_with_overlapping_faces_are_parted() {
    // coplanar overlaps on four sides
    let h = healed(&together(&cube(2), &cuboid(DVec3::new(0.37, 0.0, 0.0), DVec3::new(1.37, 1.0, 1.0), 3)));
    assert!(h.report.is_sound() && h.report.kept > 0.999, "{}", h.report);
    // a common wall
    let h = healed(&together(&cube(2), &cuboid(DVec3::X, DVec3::new(2.0, 1.0, 1.0), 2)));
    assert!(h.report.is_sound() && h.report.kept > 0.999, "{}", h.report);
    assert_abs_diff_eq!(h.mesh.volume(), 2.0, epsilon = 1e-3);
    // the same body twice
    let h = healed(&together(&cube(2), &cube(2)));
    assert!(h.report.is_sound() && (h.mesh.volume() - 1.0).abs() < 1e-12, "{}", h.report);
}

#[test]
fn bodies_that_touch_in_an_edge_or_a_node_are_parted() {
    for (lo, components) in [(DVec3::new(1.0, 1.0, 0.0), 2), (DVec3::ONE, 2)] {
        let h = expect(&together(&cube(2), &cuboid(lo, lo + 1.0, 2)), 4, components);
        assert_eq!(h.report.touching, 0, "{}", h.report);
    }
}

#[test]
fn a_sheet_gets_two_sides() {
    let sheet = without(&cube(3), |t| cube(3).centroid(t).z < 0.99);
    let h = expect(&sheet, 2, 1);
    assert!(found(&h, Defect::OpenSheet, Action::Thickened), "{}", h.report);
    assert!(h.mesh.volume() > 0.0 && h.mesh.volume() < 1e-3);
}

#[test]
fn a_part_pulled_through_the_surface_is_drawn_back() {
    let mut mesh = cube(24);
    let c = DVec3::new(0.5, 0.5, 1.0);
    for p in mesh.nodes.iter_mut() {
        *p -= DVec3::new(0.3, 0.2, 1.5) * (-p.distance_squared(c) / 0.01).exp();
    }
    let h = expect(&mesh, 2, 1);
    assert!(!found(&h, Defect::SelfIntersection, Action::Uncrossed), "{}", h.report);
}

/// Every kind of defect, one at a time at a known place: found, dealt with, and named there.
#[test]
fn every_defect_is_named_with_its_place() {
    use Defect::*;
    let mesh = cube(8);
    let at = DVec3::new(0.5, 0.5, 1.0);
    let near = |d: f64| (0..mesh.triangles.len()).filter(|t| mesh.centroid(*t).distance(at) < d).collect::<Vec<_>>();
    let (t, some) = (near(0.1)[0], near(0.16));
    let [a, b, c] = mesh.triangles[t];
    let point = |v: u32| mesh.nodes[v as usize];
    let small = |lo: DVec3, size: f64| cuboid(lo, lo + size, 1);
    let with = |change: &dyn Fn(&mut TriMesh)| {
        let mut out = mesh.clone();
        change(&mut out);
        out.labels = vec![0; out.triangles.len()];
        out
    };
    let corner = |m: &mut TriMesh, p: DVec3| {
        m.nodes.push(p);
        m.nodes.len() as u32 - 1
    };
    let cases: [(Defect, TriMesh); 11] = [
        (
            CoincidentNodes,
            with(&|m| {
                let copy = corner(m, point(a));
                m.triangles[t][0] = copy;
            }),
        ),
        (DegenerateTriangle, with(&|m| m.triangles.push([a, b, a]))),
        (DuplicateTriangle, with(&|m| m.triangles.push([b, c, a]))),
        (
            NearBorders,
            with(&|m| {
                let copy = corner(m, point(a) + 1e-7);
                m.triangles[t][0] = copy;
            }),
        ),
        (
            TJunction,
            with(&|m| {
                let middle = corner(m, 0.5 * (point(a) + point(b)));
                m.triangles[t] = [a, middle, c];
                m.triangles.push([middle, b, c]);
            }),
        ),
        (Orientation, with(&|m| m.triangles[t].swap(0, 1))),
        (
            Fin,
            with(&|m| {
                let tip = corner(m, mesh.centroid(t) + 0.05 * DVec3::Z);
                m.triangles.push([a, b, tip]);
            }),
        ),
        (Hole, without(&mesh, |t| some.contains(&t))),
        (NonManifold, together(&mesh, &small(at, 0.2))),
        (SelfIntersection, together(&mesh, &small(at - 0.1, 0.2))),
        (StrayPiece, together(&mesh, &small(at + 0.05, 0.01))),
    ];
    for (defect, bad) in cases {
        let h = healed(&bad);
        assert!(h.report.is_sound(), "{defect:?}: {}", h.report);
        let told = h.report.repairs.iter().find(|r| r.defect == defect);
        let told = told.unwrap_or_else(|| panic!("{defect:?} is not named: {}", h.report));
        let off = DVec3::from_array(told.place).distance(at);
        assert!(off < 0.25 && told.extent < 0.4 && told.count > 0, "{defect:?} at {off}: {}", h.report);
        assert!(told.action != Action::Left || defect == StrayPiece, "{}", h.report);
    }
}

#[test]
fn the_last_rung_is_closed_whatever_there_is() {
    let sheet = without(&torus(12, 8), |t| t % 3 == 0);
    let w = wrap::wrap(&sheet, &Run::new()).unwrap();
    assert!(is_sound(&w, &Run::new()).unwrap() && w.volume() > 0.0);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mesh = together(&torus(14, 9), &cuboid(DVec3::new(1.1, -0.2, -0.3), DVec3::new(4.0, 0.7, 0.6), 3));
    let with = |n: usize| heal(&mesh, &HealOptions::default(), &Run::new().with_threads(n).unwrap()).unwrap();
    let (one, three) = (with(1), with(3));
    assert_eq!(one.mesh, three.mesh);
    assert_eq!(one.report, three.report);
    assert!(one.report.is_sound(), "{}", one.report);
}

#[test]
fn nothing_is_left_of_lines() {
    let line = TriMesh::new(vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], vec![[0, 1, 2]]);
    assert_eq!(heal(&line, &HealOptions::default(), &Run::new()).unwrap_err().exit_code(), 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Stars of nodes are disks, also where they overlap or touch in a way that leaves the rest in one piece.
    #[test]
    fn random_holes_are_closed_to_the_right_topology(picks in prop::collection::vec((0u32..14, 0u32..10), 1..6)) {
        let mesh = torus(28, 20);
        let centers: Vec<u32> = picks.iter().map(|(i, j)| 2 * i * 20 + 2 * j).collect();
        let open = without(&mesh, |t| mesh.triangles[t].iter().any(|v| centers.contains(v)));
        // each center is taken out with its star; stars of neighbors at distance two share nodes
        let connected = { let d = open.defects(); open.topology(&d).components == 1 };
        prop_assume!(connected);
        let h = healed(&open);
        prop_assert!(h.report.is_sound(), "{}", h.report);
        let t = h.mesh.topology(&h.mesh.defects());
        prop_assert_eq!((t.euler, t.components), (0, 1));
    }

    #[test]
    fn random_damage_is_undone(
        flips in prop::collection::vec(0usize..560, 0..20),
        twice in prop::collection::vec((0usize..560, any::<bool>()), 0..20),
        hole in 0u32..280,
    ) {
        let mesh = torus(28, 10);
        let mut bad = mesh.clone();
        for t in flips {
            bad.triangles[t].swap(1, 2);
        }
        for (t, turned) in twice {
            let [a, b, c] = mesh.triangles[t];
            bad.triangles.push(if turned { [a, c, b] } else { [c, a, b] });
            bad.labels.push(0);
        }
        let bad = without(&bad, |t| bad.triangles[t].contains(&hole));
        let h = healed(&bad);
        prop_assert!(h.report.is_sound(), "{}", h.report);
        let t = h.mesh.topology(&h.mesh.defects());
        prop_assert_eq!((t.euler, t.components), (0, 1));
        prop_assert!(h.mesh.volume() > 0.0);
    }

    /// A hole, a T-junction, a fin, a turned triangle and a body that crosses the surface, all around one node: triangles
    /// farther away are there as they were.
    #[test]
    fn nothing_away_from_a_defect_moves(
        center in 0u32..560, kinds in prop::array::uniform5(any::<bool>()), size in 0.1f64..0.5,
        shift in prop::array::uniform3(-0.2f64..0.2),
    ) {
        let mesh = torus(28, 20);
        let at = mesh.nodes[center as usize];
        let near = |d: f64| (0..mesh.triangles.len()).filter(|t| mesh.centroid(*t).distance(at) < d).collect::<Vec<_>>();
        let star: Vec<usize> = (0..mesh.triangles.len()).filter(|t| mesh.triangles[*t].contains(&center)).collect();
        let mut bad = mesh.clone();
        if kinds[0] {
            let [a, b, c] = mesh.triangles[star[0]];
            bad.nodes.push(0.5 * (mesh.nodes[a as usize] + mesh.nodes[b as usize]));
            let m = bad.nodes.len() as u32 - 1;
            bad.triangles[star[0]] = [a, m, c];
            bad.triangles.push([m, b, c]);
            bad.labels.push(0);
        }
        if kinds[1] {
            let [a, b, _] = mesh.triangles[star[1]];
            bad.nodes.push(at + 0.1 * DVec3::Z);
            bad.triangles.push([a, b, bad.nodes.len() as u32 - 1]);
            bad.labels.push(0);
        }
        if kinds[2] {
            bad.triangles[star[2]].swap(0, 1);
        }
        if kinds[3] {
            bad = without(&bad, |t| t == star[3] || t == star[4]);
        }
        if kinds[4] {
            let lo = at + DVec3::from_array(shift) - 0.5 * size;
            bad = together(&bad, &cuboid(lo, lo + size, 1));
        }
        let h = healed(&bad);
        prop_assert!(h.report.is_sound(), "{}", h.report);
        let of = |m: &TriMesh, t: usize| {
            let mut p = m.corners(t).map(|p| p.to_array().map(f64::to_bits));
            p.sort_unstable();
            p
        };
        let there: std::collections::BTreeSet<_> = (0..h.mesh.triangles.len()).map(|t| of(&h.mesh, t)).collect();
        let close = near(1.3);
        let lost = (0..mesh.triangles.len()).filter(|t| !close.contains(t) && !there.contains(&of(&mesh, *t))).count();
        prop_assert_eq!(lost, 0, "{}", h.report);
    }

    #[test]
    fn random_soups_become_sound(corners in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 9..30)) {
        let n = corners.len() / 3;
        let nodes = corners[..3 * n].iter().map(|p| DVec3::from_array(*p)).collect();
        let mesh = TriMesh::new(nodes, (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let h = healed(&mesh);
        prop_assert!(h.report.is_sound(), "{}", h.report);
        prop_assert!(h.report.kept > 0.98, "{}", h.report);
    }

    #[test]
    fn random_crossing_boxes_become_sound(
        a in prop::array::uniform3(0i32..6), b in prop::array::uniform3(1i32..6), sub in 1u32..3,
    ) {
        // corners on a small grid: all kinds of coplanar and touching overlaps
        let lo = DVec3::from_array(a.map(f64::from)) / 4.0;
        let hi = lo + DVec3::from_array(b.map(f64::from)) / 4.0;
        let h = healed(&together(&cube(2), &cuboid(lo, hi, sub)));
        prop_assert!(h.report.is_sound(), "{}", h.report);
        prop_assert!(h.report.kept > 0.98, "{}", h.report);
    }
}
