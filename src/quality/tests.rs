//! Measures against known values.

use std::f64::consts::PI;

use approx::assert_abs_diff_eq;
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
    assert_abs_diff_eq!(e.min_angle, 60.0, epsilon = 1e-12);
    assert_abs_diff_eq!(e.radius_ratio, 1.0, epsilon = 1e-12);
    let r = t(0.0, 1.0);
    assert_abs_diff_eq!(r.min_angle, 45.0, epsilon = 1e-12);
    assert_abs_diff_eq!(r.max_angle, 90.0, epsilon = 1e-12);
    // r = (2 - sqrt 2) / 2, R = sqrt 2 / 2
    assert_abs_diff_eq!(r.radius_ratio, 2.0 * (2.0 - 2f64.sqrt()) / 2f64.sqrt(), epsilon = 1e-12);
    let flat = t(0.5, 0.0);
    assert_eq!((flat.min_angle, flat.radius_ratio), (0.0, 0.0));
}

#[test]
fn a_sphere_of_chords_is_as_far_as_chords_are() {
    let m = ball(5);
    let c = check(
        &m,
        Expectation::default(),
        Some(Against { features: Some(&Features::default()), ..Against::new(&Ball) }),
        &Run::new(),
    )
    .unwrap();
    assert!(c.closed && c.manifold && c.oriented && c.self_intersections == 0);
    assert_eq!((c.euler, c.genus, c.components), (2, Some(0), 1));
    assert_abs_diff_eq!(c.area, 4.0 * PI, epsilon = 0.01);
    assert_abs_diff_eq!(c.volume.unwrap(), 4.0 / 3.0 * PI, epsilon = 0.01);
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
    assert_abs_diff_eq!(r.length_true, 12.0, epsilon = 1e-12);
    assert_abs_diff_eq!(r.length_mesh, 12.0, epsilon = 1e-12);
    assert_eq!((r.recall, r.precision, r.corners_found, r.node_residual_max), (1.0, 1.0, 8, 0.0));
    assert!(r.known);
    // Where no true edge is known, nothing is said of the mesh's; a smooth surface has none, and so has its mesh.
    let r = recovery(&m, &Features::default(), None, 0.5, &Run::new()).unwrap();
    assert!(!r.known && (r.length_mesh - 12.0).abs() < 1e-12, "{r:?}");
    let c = check(&m, Expectation::default(), None, &Run::new()).unwrap();
    let told = Check { features: Some(r), ..c }.to_string();
    assert!(told.contains("sharp edges: the true ones are not known, mesh 12.0000"), "{told}");
    assert!(recovery(&ball(3), &Features::default(), None, 0.1, &Run::new()).unwrap().known);
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
    let c = check(&m, Expectation::default(), None, &Run::new()).unwrap();
    assert!(c.closed && c.self_intersections > 0 && c.components == 2);
    m.triangles.truncate(5);
    m.labels.truncate(5);
    let c = check(&m, Expectation::default(), None, &Run::new()).unwrap();
    assert!(!c.closed && c.genus.is_none());
    let empty = check(&TriMesh::default(), Expectation::default(), None, &Run::new()).unwrap();
    assert!(!empty.closed && empty.triangles == 0);
    m.nodes[0].x = f64::NAN;
    assert!(check(&m, Expectation::default(), None, &Run::new()).is_err());
}

#[test]
fn what_is_expected_is_said_before_judging() {
    let run = Run::new();
    let verdict = |m: &TriMesh, open, touching| check(m, Expectation { open, touching }, None, &run).unwrap();
    let mut sheet = cube();
    sheet.triangles.truncate(10);
    sheet.labels.truncate(10);
    let c = verdict(&sheet, false, false);
    assert!(matches!(&c.certificate.faults[..], [Fault::Open { edges: 4, places }] if places.len() == 4), "{c}");
    assert!(c.volume.is_none() && !c.to_string().contains("volume"), "{c}");
    assert!(c.certificate.to_string().starts_with("the mesh is not closed: 4 open edges, the first near ("), "{c}");
    let c = verdict(&sheet, true, false);
    assert!(c.certificate.is_sound() && !c.closed && c.volume.is_none());
    assert!(c.to_string().contains("certificate: sound, open; "), "{c}");
    assert!(serde_json::to_value(&c).unwrap()["volume"].is_null());
    // what may be open need not be
    let c = verdict(&cube(), true, true);
    assert!(c.certificate.to_string() == "sound" && (c.volume.unwrap() - 1.0).abs() < 1e-12, "{c}");
    let mut turned = cube();
    turned.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let c = verdict(&turned, false, false);
    assert!(matches!(c.certificate.faults[..], [Fault::Inverted { volume }] if (volume + 1.0).abs() < 1e-12), "{c}");
    // two cubes, one corner of each inside the other
    let mut two = cube();
    two.nodes.extend(cube().nodes.iter().map(|p| *p + DVec3::splat(0.5)));
    two.triangles.extend(cube().triangles.iter().map(|t| t.map(|v| v + 8)));
    two.labels.resize(24, 0);
    let (strict, lenient) = (verdict(&two, false, false), verdict(&two, false, true));
    let n = strict.self_intersections;
    assert!(n > 0 && strict.touching == 0 && lenient.self_intersections == 0 && lenient.touching == n);
    assert!(!strict.certificate.is_sound() && lenient.certificate.is_sound());
    assert!(strict.certificate.to_string().starts_with(&format!("{n} triangles intersect others, the first near (")));
}

#[test]
fn faults_tell_what_they_hold() {
    let at = [1.0, 0.5, -2.0];
    let edges = |n: usize| Fault::edges_missing(&vec![DVec3::from(at); n]);
    let face = || "face1".to_string();
    for (fault, kind, message) in [
        (Fault::Open { edges: 0, places: Vec::new() }, "open", "the mesh is not closed"),
        (
            Fault::NonManifold { count: 2, places: vec![at] },
            "non_manifold",
            "the mesh is not a manifold: 2 edges and nodes, the first near (1.000000, 0.500000, -2.000000)",
        ),
        (
            Fault::Crossing { triangles: 3, own_body: true, places: Vec::new() },
            "crossing",
            "3 triangles intersect others of their body",
        ),
        (
            Fault::Far { distance: 0.25, limit: 0.125, triangles: None },
            "far",
            "mesh and surface are 2.5000e-1 apart somewhere, more than the size of 1.2500e-1",
        ),
        (
            Fault::Far { distance: 0.25, limit: 0.125, triangles: Some(7) },
            "far",
            "7 triangles are farther from the surface than asked for: the farthest by 2.5000e-1",
        ),
        (
            Fault::VolumeLost { share: 0.25, limit: 0.125 },
            "volume_lost",
            "up to 2.5000e-1 of the volume lies between mesh and surface, more than 1.2500e-1",
        ),
        (
            edges(1),
            "edges_missing",
            "no exact edge found near (1.000000, 0.500000, -2.000000): two faces come too close there",
        ),
        (
            Fault::NoMesh { face: face(), source: 4, surface: Some("plane"), reason: "it is narrow".into() },
            "no_mesh",
            "face face1 (#4, plane) has no mesh: it is narrow",
        ),
        (
            Fault::OtherMethod { crossing: 2, inverted: 1, method: "mc" },
            "other_method",
            "with exact edges, of the triangles 2 intersect others and 1 are turned over: made by mc instead",
        ),
        (Fault::NotRemeshed, "not_remeshed", "left as it was: remeshing made it intersect itself"),
    ] {
        let json = serde_json::to_value(&fault).unwrap();
        assert_eq!((json["kind"].as_str(), json["message"].as_str()), (Some(kind), Some(message)));
        assert_eq!(fault.to_string(), message);
    }
    let json = serde_json::to_value(Fault::FaceMissing { face: face(), at }).unwrap();
    assert_eq!(
        (json["face"].as_str(), json["at"][2].as_f64(), json.as_object().unwrap().len()),
        (Some("face1"), Some(-2.0), 4)
    );
    // one is one to those who compare, many are no more than can be listed
    assert_eq!([1, 3, 6, 600].map(|n| edges(n).weight()), [1, 3, 6, 6]);
    assert!(edges(9).to_string().ends_with("two faces come too close there, and at 4 more places"));
}

/// The sum of no numbers is -0, which would be printed with its sign.
#[test]
fn what_is_empty_has_an_area_and_a_length_without_a_sign() {
    let mut mesh = cube();
    mesh.groups.push(crate::mesh::Group { name: "none".into(), faces: Vec::new() });
    let made = check(&mesh, Expectation::default(), None, &Run::new()).unwrap();
    let none = made.groups.iter().find(|g| g.name == "none").unwrap();
    assert_eq!((none.triangles, none.area.to_bits()), (0, 0.0f64.to_bits()));
    assert!(made.to_string().contains("area 0.000000") && !made.to_string().contains("-0.0"), "{made}");
    assert_eq!(TriMesh::default().area().to_bits(), 0.0f64.to_bits());
    assert_eq!(Features::default().length(30.0).to_bits(), 0.0f64.to_bits());
}
