//! Measures against known values.

use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::Run;
use crate::geometry::{FeatureSample, Features, Foot, SurfaceOracle};
use crate::mesh::TriMesh;

struct Ball;

impl SurfaceOracle for Ball {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let n = p.try_normalize()?;
        ((1.0 - p.length()).abs() <= reach).then_some(Foot { point: n, normal: n, face: 0 })
    }
    fn project_along(&self, _: DVec3, _: DVec3, _: f64) -> Option<Foot> {
        None
    }
    fn curvatures(&self, _: &Foot) -> Option<[f64; 2]> {
        Some([1.0, 1.0])
    }
}

/// An octahedron halved `n` times, its nodes on the unit sphere.
fn ball(n: usize) -> TriMesh {
    let mut nodes: Vec<DVec3> = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z].into();
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..n {
        let mut known = std::collections::BTreeMap::new();
        let mut mid = |a: u32, b: u32| {
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                nodes.push((nodes[a as usize] + nodes[b as usize]).normalize());
                nodes.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (x, y, z) = (mid(a, b), mid(b, c), mid(c, a));
                [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
            })
            .collect();
    }
    TriMesh::new(nodes, triangles)
}

fn cube() -> TriMesh {
    let nodes = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriMesh::new(nodes, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

#[test]
fn shapes_of_known_triangles() {
    let t = |x: f64, y: f64| shape([DVec3::ZERO, DVec3::X, DVec3::new(x, y, 0.0)]);
    let e = t(0.5, 0.75f64.sqrt());
    assert!((e.min_angle - 60.0).abs() < 1e-12 && (e.radius_ratio - 1.0).abs() < 1e-12);
    let r = t(0.0, 1.0);
    assert!((r.min_angle - 45.0).abs() < 1e-12 && (r.max_angle - 90.0).abs() < 1e-12);
    // r = (2 - sqrt 2) / 2, R = sqrt 2 / 2
    assert!((r.radius_ratio - 2.0 * (2.0 - 2f64.sqrt()) / 2f64.sqrt()).abs() < 1e-12);
    let flat = t(0.5, 0.0);
    assert_eq!((flat.min_angle, flat.radius_ratio), (0.0, 0.0));
}

#[test]
fn a_sphere_of_chords_is_as_far_as_chords_are() {
    let m = ball(5);
    let c =
        check(&m, Some(Against { features: Some(&Features::default()), ..Against::new(&Ball) }), &Run::new()).unwrap();
    assert!(c.closed && c.manifold && c.oriented && c.self_intersections == 0);
    assert_eq!((c.euler, c.genus, c.components), (2, Some(0), 1));
    assert!((c.area - 4.0 * PI).abs() < 0.01 && (c.volume - 4.0 / 3.0 * PI).abs() < 0.01);
    let d = c.deviation.unwrap();
    // the farthest point of a chordal triangle is its circumcenter, 1 - sqrt(1 - R^2) below the sphere
    let deepest = (0..m.triangles.len())
        .map(|t| {
            let [a, b, c] = m.corners(t);
            let r = a.distance(b) * b.distance(c) * c.distance(a) / (2.0 * m.area_vector(t).length());
            1.0 - (1.0 - r * r).sqrt()
        })
        .fold(0.0, f64::max);
    assert!(d.max <= deepest * 1.0001 && d.max > 0.9 * deepest, "{} {deepest}", d.max);
    assert!(d.normal < 1e-3 && d.unprojected == 0 && d.inverted == 0);
    assert!(d.rms > 0.3 * d.max && d.rms < d.max);
    let f = c.features.unwrap();
    assert_eq!((f.recall, f.precision, f.length_mesh), (1.0, 1.0, 0.0));
}

#[test]
fn recovery_of_a_cube() {
    let m = cube();
    let mut truth = Features::default();
    for axis in 0..3 {
        for side in 0..4 {
            for i in 0..10 {
                let mut p = [0.0; 3];
                p[axis] = (i as f64 + 0.5) / 10.0;
                p[(axis + 1) % 3] = f64::from(side & 1);
                p[(axis + 2) % 3] = f64::from(side >> 1);
                truth.samples.push(FeatureSample {
                    point: p.into(),
                    tangent: DVec3::AXES[axis],
                    length: 0.1,
                    angle: 90.0,
                    pieces: [0, 1],
                });
            }
        }
    }
    truth.corners = m.nodes.clone();
    let r = recovery(&m, &truth, None, 0.5, &Run::new()).unwrap();
    assert!((r.length_true - 12.0).abs() < 1e-12 && (r.length_mesh - 12.0).abs() < 1e-12);
    assert_eq!((r.recall, r.precision, r.corners_found, r.node_residual_max), (1.0, 1.0, 8, 0.0));
    // half of the truth moved away
    truth.samples.iter_mut().step_by(2).for_each(|s| s.point += DVec3::splat(0.1));
    truth.corners[0].x -= 0.03;
    let r = recovery(&m, &truth, None, 0.5, &Run::new()).unwrap();
    assert!((r.recall - 0.5).abs() < 1e-12 && r.corners_found == 7, "{r:?}");
    assert!(r.precision < 0.9, "{r:?}");
}

#[test]
fn intersecting_and_open_meshes_are_told() {
    let mut m = cube();
    let n = m.nodes.len() as u32;
    let other = cube();
    m.nodes.extend(other.nodes.iter().map(|p| *p + DVec3::splat(0.5)));
    m.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
    m.labels.resize(m.triangles.len(), 0);
    let c = check(&m, None, &Run::new()).unwrap();
    assert!(c.closed && c.self_intersections > 0 && c.components == 2);
    m.triangles.truncate(5);
    m.labels.truncate(5);
    let c = check(&m, None, &Run::new()).unwrap();
    assert!(!c.closed && c.genus.is_none());
    let empty = check(&TriMesh::default(), None, &Run::new()).unwrap();
    assert!(!empty.closed && empty.triangles == 0);
    m.nodes[0].x = f64::NAN;
    assert!(check(&m, None, &Run::new()).is_err());
}
