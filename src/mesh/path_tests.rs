//! Shortest paths against lengths in closed form.

use std::f64::consts::{PI, TAU};

use approx::{assert_abs_diff_eq, assert_relative_eq, relative_eq};
use glam::DVec3;
use rustc_hash::FxHashMap;

use super::TriMesh;
use super::path::*;
use crate::run::Run;
use crate::spatial::triangle_distance_squared;

fn length(mesh: &TriMesh, a: [f64; 3], b: [f64; 3]) -> f64 {
    let p = shortest_path(mesh, a.into(), b.into(), &Run::new()).unwrap();
    let sum: f64 = p.points.windows(2).map(|w| w[0].distance(w[1])).sum();
    assert_relative_eq!(sum, p.length, epsilon = 0.0, max_relative = 1e-12);
    assert!(p.points[0].distance(a.into()) < 1e-2 && p.points[p.points.len() - 1].distance(b.into()) < 1e-2);
    // Every piece lies on the mesh.
    for w in p.points.windows(2) {
        let m = 0.5 * (w[0] + w[1]);
        let near = (0..mesh.triangles.len()).map(|t| triangle_distance_squared(m, mesh.corners(t)));
        assert!(near.fold(f64::INFINITY, f64::min) < 1e-18);
    }
    p.length
}

/// A grid of `n` by `m` cells, wound where asked, with nodes where `at` puts them.
fn grid(n: u32, m: u32, around: bool, at: &dyn Fn(f64, f64) -> [f64; 3]) -> TriMesh {
    let columns = if around { n } else { n + 1 };
    let mut nodes = Vec::new();
    for j in 0..=m {
        nodes.extend((0..columns).map(|i| DVec3::from(at(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)))));
    }
    let mut triangles = Vec::new();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let v = |i: u32, j: u32| j * columns + i % columns;
        let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    TriMesh::new(nodes, triangles)
}

/// The surface of the unit cube, `n` cells to an edge.
fn cube(n: u32) -> TriMesh {
    let mut all = TriMesh::default();
    let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    for k in 0..6_usize {
        let face = grid(n, n, false, &|s, t| {
            let mut p = [0.0; 3];
            (p[k % 3], p[(k + 1) % 3], p[(k + 2) % 3]) = (if k < 3 { 0.0 } else { 1.0 }, s, t);
            p
        });
        let mut number = |v: u32| {
            let p = face.nodes[v as usize];
            *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                all.nodes.push(p);
                all.nodes.len() as u32 - 1
            })
        };
        let triangles: Vec<[u32; 3]> = face.triangles.iter().map(|t| t.map(&mut number)).collect();
        all.triangles.extend(triangles);
    }
    TriMesh::new(all.nodes, all.triangles)
}

#[test]
fn over_the_edges_of_a_cube_it_is_straight_when_unfolded() {
    for n in [1, 2, 7] {
        let mesh = cube(n);
        let near = |a, b, truth: f64| {
            let l = length(&mesh, a, b);
            assert!(relative_eq!(l, truth, epsilon = 0.0, max_relative = 1e-9), "{n}: {l} {truth}");
        };
        near([0.1, 0.2, 1.0], [0.9, 0.7, 1.0], 0.8_f64.hypot(0.5));
        near([0.5, 0.5, 1.0], [1.0, 0.5, 0.5], 1.0);
        near([0.2, 0.3, 1.0], [1.0, 0.9, 0.4], 1.4_f64.hypot(0.6));
    }
    // Corner to opposite corner: over two faces.
    let l = length(&cube(5), [0.0; 3], [1.0; 3]);
    assert_abs_diff_eq!(l, 5.0_f64.sqrt(), epsilon = 1e-9);
}

#[test]
fn on_a_cylinder_it_is_a_helix_and_on_a_sphere_a_great_circle() {
    let n = 64;
    let tube = grid(n, 9, true, &|s, t| [(TAU * s).cos(), (TAU * s).sin(), 3.0 * t]);
    for k in [5, 13, 24] {
        let angle = TAU * f64::from(k) / f64::from(n);
        let l = length(&tube, [1.0, 0.0, 0.25], [angle.cos(), angle.sin(), 2.5]);
        // The facets unrolled are what it runs on; the helix differs by less than a thousandth.
        let facets = f64::from(k) * 2.0 * (PI / f64::from(n)).sin();
        assert!(relative_eq!(l, facets.hypot(2.25), epsilon = 0.0, max_relative = 1e-9), "{k}: {l}");
        assert_relative_eq!(l, angle.hypot(2.25), epsilon = 0.0, max_relative = 1e-3);
    }
    let ball = grid(80, 40, true, &|s, t| {
        // Small holes at the poles keep triangles there from having no area.
        let (u, v) = (TAU * s, PI * (0.01 + 0.98 * t));
        [u.cos() * v.sin(), u.sin() * v.sin(), -v.cos()]
    });
    for (a, b) in [
        ([1.0, 0.0, 0.0], [0.0, 0.6, 0.8]),
        ([0.8, 0.0, 0.6], [-0.48, 0.64, 0.6]),
        ([0.0, -1.0, 0.0], [0.6, 0.0, -0.8]),
    ] {
        let angle = DVec3::from(a).dot(DVec3::from(b)).acos();
        let l = length(&ball, a, b);
        assert_relative_eq!(l, angle, epsilon = 0.0, max_relative = 0.01);
    }
}

#[test]
fn it_bends_around_reflex_corners_and_ends_at_gaps() {
    // A flat plate with a quarter cut away: the way touches the inner corner.
    let mut plate = grid(8, 8, false, &|s, t| [2.0 * s, 2.0 * t, 0.0]);
    let kept = |t: &[u32; 3]| {
        let m = t.iter().map(|v| plate.nodes[*v as usize]).sum::<DVec3>() / 3.0;
        m.x < 1.0 || m.y < 1.0
    };
    plate.triangles = plate.triangles.iter().copied().filter(kept).collect();
    plate.labels.truncate(plate.triangles.len());
    let l = length(&plate, [0.9, 1.7, 0.0], [1.8, 0.8, 0.0]);
    assert_abs_diff_eq!(l, 0.1_f64.hypot(0.7) + 0.8_f64.hypot(0.2), epsilon = 1e-12);
    // Two plates with one node in common, and two apart.
    let v = DVec3::new;
    let nodes = vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(-1.0, 0.0, 0.0), v(0.0, -1.0, 0.0)];
    let bow = TriMesh::new(nodes, vec![[0, 1, 2], [0, 3, 4]]);
    let l = length(&bow, [0.5, 0.5, 0.0], [-0.5, 0.0, 0.0]);
    assert_abs_diff_eq!(l, 0.5_f64.hypot(0.5) + 0.5, epsilon = 1e-12);
    let run = Run::new();
    let mut apart = bow.clone();
    apart.nodes.push(DVec3::new(-0.1, -0.1, 0.0));
    apart.triangles[1][0] = 5;
    let told = shortest_path(&apart, DVec3::X, -DVec3::X, &run).unwrap_err();
    assert!(told.to_string().contains("do not hang together"), "{told}");
    assert!(shortest_path(&bow, DVec3::NAN, DVec3::X, &run).is_err());
    assert!(shortest_path(&TriMesh::default(), DVec3::X, DVec3::Y, &run).is_err());
    let same = shortest_path(&bow, DVec3::X, DVec3::X, &run).unwrap();
    assert_eq!(same.length, 0.0);
}
