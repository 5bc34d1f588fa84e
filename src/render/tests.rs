//! Pictures of known things.

use glam::DVec3;

use super::*;
use crate::Run;
use crate::mesh::TriMesh;

fn cube() -> TriMesh {
    let nodes = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut m = TriMesh::new(nodes, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect());
    m.faces = (0..6).map(|i| format!("face_{i}")).collect();
    m.labels = (0..12).map(|t| t / 2).collect();
    m
}

fn small() -> RenderOptions {
    RenderOptions { width: 200, height: 160, legend: false, ..RenderOptions::default() }
}

fn share_of(p: &Picture, f: impl Fn([u8; 3]) -> bool) -> f64 {
    let hits =
        (0..p.height).flat_map(|y| (0..p.width).map(move |x| (x, y))).filter(|(x, y)| f(p.pixel(*x, *y))).count();
    hits as f64 / f64::from(p.width * p.height)
}

#[test]
fn a_cube_fills_its_outline_and_shows_three_faces() {
    let p = render(&cube(), &small(), &Run::new()).unwrap();
    let paper = |c: [u8; 3]| c[0] > 232 && c[1] > 232 && c[2] > 232;
    let filled = 1.0 - share_of(&p, paper);
    // the outline of a cube seen from (1, -1.45, 0.85): |x| + |y| + |z| of the unit direction is its area
    let d = small().from.normalize().abs();
    let (right, up) = (DVec3::Z.cross(small().from.normalize()).normalize().abs(), 0.0);
    let _ = up;
    let scale =
        (0.92 * 160.0 / (d.cross(right).length() * 0.0 + projected_height())).min(0.92 * 200.0 / right.element_sum());
    let expected = d.element_sum() * scale * scale / (200.0 * 160.0);
    assert!((filled / expected - 1.0).abs() < 0.05, "{filled} {expected}");
    let dark = share_of(&p, |c| c.iter().all(|v| *v < 90));
    assert!(dark > 0.01 && dark < 0.15, "sharp edges: {dark}");
}

/// Height of the unit cube's outline seen from the default direction.
fn projected_height() -> f64 {
    let back = small().from.normalize();
    let right = DVec3::Z.cross(back).normalize();
    back.cross(right).abs().element_sum()
}

#[test]
fn pictures_do_not_depend_on_threads_and_encode() {
    let one = render(&cube(), &small(), &Run::new().with_threads(1).unwrap()).unwrap();
    let many = render(&cube(), &small(), &Run::new().with_threads(7).unwrap()).unwrap();
    assert!(one == many);
    assert!(one.png_bytes().unwrap().starts_with(b"\x89PNG"));
    let s = sheet(&[("first: MC33".into(), one.clone()), ("second".into(), many)], 4);
    assert_eq!((s.width, s.height), (400, 198));
    assert_eq!(s.pixel(100, 100), one.pixel(100, 62));
}

#[test]
fn odd_meshes_are_drawn_or_refused() {
    let run = Run::new();
    assert!(render(&TriMesh::default(), &small(), &run).is_ok());
    let flat = TriMesh::new(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]);
    assert!(render(&flat, &small(), &run).is_ok());
    let mut open = cube();
    open.triangles.truncate(7);
    open.labels.truncate(7);
    let p = render(&open, &small(), &run).unwrap();
    assert!(share_of(&p, |c| c[0] > 180 && c[1] < 80) > 0.002, "open edges are red");
    let mut nan = cube();
    nan.nodes[0].x = f64::NAN;
    assert!(render(&nan, &small(), &run).is_err());
    assert!(render(&cube(), &RenderOptions { width: 0, ..small() }, &run).is_err());
    let legend = RenderOptions { width: 800, height: 600, legend: true, ..small() };
    assert!(render(&cube(), &legend, &run).is_ok());
}
