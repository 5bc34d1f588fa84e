//! Meshes of small models against their geometry.

use std::f64::consts::PI;
use std::path::Path;

use approx::assert_abs_diff_eq;

use super::*;
use crate::geometry::Pieces;
use crate::io::step::read_step;
use crate::mesh::self_intersections;
use crate::parametric::brep::{Body, Coedge, Edge, Face};
use crate::parametric::build::{Extrusion, Loft, Section, Wire, extrude_edges, loft};
use crate::parametric::nurbs::{NurbsCurve, NurbsSurface, SplineEnds};
use crate::parametric::step::interpret;
use crate::parametric::{Curve, Frame, Surface, basis::Knots};

fn file(name: &str) -> Brep {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name);
    interpret(&read_step(&path).unwrap(), &Run::new()).unwrap().brep
}

/// Meshes with edges of about `share` of the diagonal, finer where it curves; all faces must come out, closed, a manifold,
/// oriented outwards, without intersections, their nodes on their surfaces.
fn sound(brep: Brep, share: f64) -> (Parametric, FaceMeshes) {
    let p = Parametric::new(brep, &Run::new()).unwrap();
    let size = share * p.bounds().diagonal();
    let by = move |k: f64| size.min(0.35 / k.max(1e-300)).max(size / 6.0);
    let m = p.mesh(&MeshSizes::new(size, size / 6.0, &by), &Run::new()).unwrap();
    assert!(m.failures.is_empty(), "{:?}", m.failures);
    let mut mesh = m.mesh.clone();
    mesh.drop_unused_nodes();
    let d = mesh.defects();
    assert!(d.is_closed() && d.is_manifold() && d.is_oriented(), "{d:?}");
    assert!(mesh.volume() > 0.0);
    assert!(self_intersections(&mesh, &Run::new()).unwrap().is_empty());
    for (t, l) in m.mesh.triangles.iter().zip(&m.mesh.labels) {
        for v in t {
            let q = m.mesh.nodes[*v as usize];
            assert!(p.foot(*l, q).unwrap().distance(q) < 1e-9 * p.bounds().diagonal());
        }
    }
    (p, m)
}

fn near(found: f64, truth: f64, share: f64) {
    assert_abs_diff_eq!(found, truth, epsilon = share * truth);
}

#[test]
fn faces_that_wind_around_are_cut_and_closed_again() {
    for (name, volume, area, euler) in [
        ("sphere.step", 32.0 * PI / 3.0, 16.0 * PI, 2),
        ("torus.step", 6.0 * PI * PI, 12.0 * PI * PI, 0),
        ("cone_with_apex.step", 16.0 * PI / 3.0, PI * 2.0 * (2.0 + 20f64.sqrt()), 2),
        ("cylinder_without_seam.step", 12.0 * PI * 25.4f64.powi(3), 20.0 * PI * 25.4f64.powi(2), 2),
    ] {
        let (_, m) = sound(file(name), 0.04);
        near(m.mesh.volume(), volume, 0.04);
        near(m.mesh.area(), area, 0.02);
        let mut mesh = m.mesh.clone();
        mesh.drop_unused_nodes();
        assert_eq!(mesh.topology(&mesh.defects()).euler, euler, "{name}");
    }
}

#[test]
fn the_same_for_any_number_of_threads() {
    let one = |n| {
        let run = Run::new().with_threads(n).unwrap();
        let p = Parametric::new(file("cylinder_without_seam.step"), &run).unwrap();
        p.mesh(&MeshSizes::new(6.0, 1.5, &|_| 6.0), &run).unwrap().mesh
    };
    assert_eq!(one(1), one(3));
}

/// A solid of revolution of a spline that starts and ends on the axis: poles at both ends, a seam edge between.
fn spindle() -> Brep {
    let points = [DVec3::ZERO, DVec3::new(1.0, 0.0, 0.5), DVec3::new(0.7, 0.0, 2.0), DVec3::new(0.0, 0.0, 3.0)];
    let curve = Curve::Nurbs(NurbsCurve::cubic(&points, SplineEnds::Natural).unwrap());
    let range = curve.domain();
    let edge = Edge { curve: curve.clone(), range, ends: [0, 1], source: 0 };
    let surface = Surface::Revolution { curve, frame: Frame::WORLD };
    // Up and down the seam; the poles are vertices.
    let seam = |forward| Coedge { edge: 0, forward };
    // Su x Sv points inwards for a profile that runs upwards seen from outside: t x d with t = y, d = z is x, outwards.
    let face = Face {
        surface,
        outward: true,
        loops: vec![vec![seam(true), seam(false)]],
        name: "all".into(),
        source: 0,
        color: None,
    };
    let body = Body { name: "spindle".into(), faces: vec![0], solid: true };
    Brep { vertices: vec![points[0], points[3]], edges: vec![edge], faces: vec![face], bodies: vec![body] }
}

#[test]
fn poles_at_both_ends_of_a_seam_are_lines_of_the_domain() {
    let (p, m) = sound(spindle(), 0.05);
    // Pappus: the volume is the integral of pi r^2 dz along the profile.
    let curve = &p.brep.edges[0].curve;
    let [a, b] = p.brep.edges[0].range;
    let n = 20_000;
    let step = (b - a) / f64::from(n);
    let slice = |i: i32| {
        let [c, d, _] = curve.jet(a + (f64::from(i) + 0.5) * step);
        PI * c.x * c.x * d.z * step
    };
    near(m.mesh.volume(), (0..n).map(slice).sum(), 0.02);
    assert_eq!(m.places.iter().filter(|x| matches!(x, Place::Vertex(_))).count(), 2);
}

#[test]
fn nurbs_patches_share_the_nodes_of_their_edges() {
    // A pillow: two bicubic patches over a square, bulging up and down, with four common straight edges.
    let k = || Knots::uniform(3, 4).unwrap();
    let net = |bulge: f64| -> Vec<DVec3> {
        let inner = |i: usize| (1..3).contains(&i);
        let z = |i: usize, j: usize| if inner(i) && inner(j) { bulge } else { 0.0 };
        (0..16).map(|n| DVec3::new((n / 4) as f64 / 3.0, (n % 4) as f64 / 3.0, z(n / 4, n % 4))).collect()
    };
    let patch = |bulge| Surface::Nurbs(NurbsSurface::new(k(), k(), &net(bulge), None).unwrap());
    let vertices = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].to_vec();
    let edges: Vec<Edge> = (0..4)
        .map(|i| {
            let j = (i + 1) % 4;
            Edge {
                curve: Curve::segment(vertices[i], vertices[j]),
                range: [0.0, 1.0],
                ends: [i as u32, j as u32],
                source: 0,
            }
        })
        .collect();
    let around = |forward: bool| {
        let mut l: Vec<Coedge> = (0..4).map(|edge| Coedge { edge, forward }).collect();
        if !forward {
            l.reverse();
        }
        vec![l]
    };
    let face = |bulge: f64, up: bool, name: &str| Face {
        surface: patch(bulge),
        outward: up,
        loops: around(up),
        name: name.into(),
        source: 0,
        color: None,
    };
    let faces = vec![face(0.6, true, "top"), face(-0.6, false, "bottom")];
    let body = Body { name: "pillow".into(), faces: vec![0, 1], solid: true };
    let (p, m) = sound(Brep { vertices, edges, faces, bodies: vec![body] }, 0.05);
    // The Bernstein weights of the four inner points integrate to 1/16 each.
    near(m.mesh.volume(), 2.0 * 0.6 * 4.0 / 16.0, 0.03);
    let q = p.meet(&[0, 1], DVec3::new(0.3, 0.02, 0.01), 0.1).unwrap();
    assert!(q.distance(DVec3::new(0.3, 0.0, 0.0)) < 1e-12);
    assert_eq!(p.corners(), [true; 4]);
}

#[test]
fn a_face_that_cannot_be_meshed_is_named() {
    let mut b = file("cylinder_without_seam.step");
    // The side loses one of its two loops: it winds around alone, without a pole.
    b.faces[0].loops.pop();
    let p = Parametric::new(b, &Run::new()).unwrap();
    let m = p.mesh(&MeshSizes::new(9.0, 3.0, &|_| 9.0), &Run::new()).unwrap();
    assert_eq!(m.failures.iter().map(|f| f.face).collect::<Vec<_>>(), [0]);
    assert!(m.failures[0].reason.contains("no pole") && !m.mesh.triangles.is_empty());
}

/// A flat face between straight loops, counter-clockwise outside and clockwise inside; every loop has vertices of its own.
fn flat(loops: &[&[(f64, f64)]]) -> Brep {
    let mut brep = Brep::default();
    let mut list = Vec::new();
    for l in loops {
        let first = brep.vertices.len() as u32;
        let n = l.len() as u32;
        brep.vertices.extend(l.iter().map(|p| DVec3::new(p.0, p.1, 0.0)));
        let mut row = Vec::new();
        for k in 0..n {
            let ends = [first + k, first + (k + 1) % n];
            let [a, b] = ends.map(|v| brep.vertices[v as usize]);
            row.push(Coedge { edge: brep.edges.len() as u32, forward: true });
            brep.edges.push(Edge { curve: Curve::segment(a, b), range: [0.0, 1.0], ends, source: 0 });
        }
        list.push(row);
    }
    let surface = Surface::Plane { frame: Frame::WORLD };
    brep.faces.push(Face { surface, outward: true, loops: list, name: "flat".into(), source: 0, color: None });
    brep
}

fn meshed(brep: Brep, size: f64, most: usize) -> FaceMeshes {
    let by_curvature = |_| size;
    let sizes = MeshSizes { most, ..MeshSizes::new(size, size / 4.0, &by_curvature) };
    Parametric::new(brep, &Run::new()).unwrap().mesh(&sizes, &Run::new()).unwrap()
}

#[test]
fn narrow_places_ask_for_their_width_and_slots_beside_a_face_do_not() {
    let longest = |m: &FaceMeshes| {
        let edge = |t: &[u32; 3], k: usize| {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| m.mesh.nodes[v as usize]);
            a.distance(b)
        };
        m.mesh.triangles.iter().flat_map(|t| (0..3).map(move |k| edge(t, k))).fold(0.0, f64::max)
    };
    // A strip half a size wide: edges along it are up to 1.4 times as long as it is wide, as their nodes lie between each other.
    let strip = meshed(flat(&[&[(0.0, 0.0), (10.0, 0.0), (10.0, 0.5), (0.0, 0.5)]]), 1.0, usize::MAX);
    assert!(strip.failures.is_empty() && longest(&strip) < 1.0, "{}", longest(&strip));
    assert!(strip.sizes.iter().all(|h| (0.45..=0.75).contains(h)), "{:?}", strip.sizes);
    let side = |y: f64| {
        let mut x: Vec<f64> = strip.mesh.nodes.iter().filter(|p| p.y == y).map(|p| p.x).collect();
        x.sort_by(f64::total_cmp);
        x
    };
    let (whole, between) = match (side(0.0), side(0.5)) {
        (a, b) if a.len() < b.len() => (a, b),
        (a, b) => (b, a),
    };
    assert_eq!(between.len(), whole.len() + 1);
    assert!(whole.windows(2).zip(&between[1..]).all(|(w, x)| w[0] < *x && *x < w[1]));
    let angle = |t: &[u32; 3], k: usize| {
        let [a, b, c] = [0, 1, 2].map(|i| strip.mesh.nodes[t[(k + i) % 3] as usize]);
        (b - a).angle_between(c - a).to_degrees()
    };
    let least = strip.mesh.triangles.iter().flat_map(|t| (0..3).map(move |k| angle(t, k))).fold(180.0, f64::min);
    assert!(least > 35.0, "{least}");
    // A slot of that width between two wide parts lies outside the face; only its short end asks for less.
    let comb =
        [(0.0, 0.0), (20.5, 0.0), (20.5, 20.0), (10.5, 20.0), (10.5, 5.0), (10.0, 5.0), (10.0, 20.0), (0.0, 20.0)];
    let slot = meshed(flat(&[&comb]), 1.0, usize::MAX);
    let near = |p: &DVec3| p.distance(DVec3::new(10.25, 5.0, 0.0)) < 3.0;
    assert!(slot.failures.is_empty());
    assert!(slot.mesh.nodes.iter().zip(&slot.sizes).all(|(p, h)| near(p) || *h > 0.99));
}

#[test]
fn contours_that_touch_in_a_vertex_are_joined() {
    // The hole's corner lies on a corner of the border; both have vertices of their own there.
    let m = meshed(
        flat(&[&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)], &[(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]]),
        0.5,
        9999,
    );
    assert!(m.failures.is_empty(), "{:?}", m.failures);
    near(m.mesh.area(), 16.0 - 1.5, 1e-9);
}

#[test]
fn meshing_ends_where_there_would_be_too_many_nodes() {
    let square = || flat(&[&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]]);
    assert!(meshed(square(), 0.1, 100).too_many);
    let m = meshed(square(), 0.1, 10_000);
    assert!(!m.too_many && m.mesh.triangles.len() > 2000);
}

/// A sheet folded about a round bend of radius 0.1 in its middle; its sides along the bend are straight and 1.4 away from it.
fn folded() -> Brep {
    let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let leg = |z: f64| (1..=7).map(move |k| at(0.2 * f64::from(k), z));
    let bend = (1..8).map(|k| (f64::from(k) / 8.0 + 0.5) * PI).map(|a| at(0.1 * a.cos(), 0.1 * a.sin()));
    let points: Vec<DVec3> =
        leg(0.1).rev().chain([at(0.0, 0.1)]).chain(bend).chain([at(0.0, -0.1)]).chain(leg(-0.1)).collect();
    let profile = Wire::spline(&points, SplineEnds::Natural).unwrap();
    extrude_edges(&[profile], &Extrusion { caps: false, ..Extrusion::new(DVec3::Y, 6.0) }).unwrap()
}

#[test]
fn borders_are_graded_to_bends_inside_faces() {
    let p = Parametric::new(folded(), &Run::new()).unwrap();
    let by = |k: f64| (0.35 / k.max(1e-300)).clamp(0.035, 1.0);
    let m = p.mesh(&MeshSizes { grading: 0.2, ..MeshSizes::new(1.0, 0.035, &by) }, &Run::new()).unwrap();
    assert!(m.failures.is_empty());
    // In the middle of a side the bend is nearer than any other border: 0.035 there, and a fifth of the way more.
    let side = |v: &DVec3| (v.x - 1.4).abs() < 1e-9 && (v.z - 0.1).abs() < 1e-9;
    let mut y: Vec<f64> = m.mesh.nodes.iter().filter(|v| side(v)).map(|v| v.y).collect();
    y.sort_by(f64::total_cmp);
    y.dedup();
    let longest = y.windows(2).map(|w| w[1] - w[0]).fold(0.0f64, f64::max);
    assert!((0.25..0.4).contains(&longest), "{longest}");
}

/// A loft of six arcs of a circle about the axis, with a point on the axis before them.
fn pointed(height: f64, round: bool) -> Brep {
    let arcs = |z: f64, r: f64| {
        let at = |k: f64| DVec3::new(r * (k * PI / 6.0).cos(), r * (k * PI / 6.0).sin(), z);
        let arc = |k: u32| Wire::arc(at(f64::from(2 * k)), at(f64::from(2 * k + 1)), at(f64::from(2 * k + 2))).unwrap();
        Section::Wire(Wire::joined(&(0..6).map(arc).collect::<Vec<_>>()).unwrap())
    };
    let how = Loft { ruled: !round, caps: false, round: [round, false], ..Loft::default() };
    loft(&[Section::Point(DVec3::ZERO), arcs(height, 1.0), arcs(2.0 * height, if round { 1.4 } else { 2.0 })], &how)
        .unwrap()
}

#[test]
fn tips_of_several_faces_are_fans_where_they_are_acute_alone() {
    let by = |_: f64| 0.1;
    let mesh = |brep: Brep| {
        let m = Parametric::new(brep, &Run::new()).unwrap().mesh(&MeshSizes::new(0.1, 0.1, &by), &Run::new()).unwrap();
        assert!(m.failures.is_empty());
        let tip = m.mesh.nodes.iter().position(|v| v.length() < 1e-9).unwrap() as u32;
        let around = m.mesh.triangles.iter().filter(|t| t.contains(&tip)).count();
        (m.fans.len(), around)
    };
    // Each of six faces has a sixth of the tip: one triangle of the fan.
    assert_eq!(mesh(pointed(4.0, false)), (6, 6));
    // Where all six are smooth together there is none.
    assert_eq!(mesh(pointed(0.5, true)).0, 0);
}
