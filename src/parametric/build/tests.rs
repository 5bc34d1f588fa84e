//! Built bodies: sound topology, points on their surfaces, meshes with the volumes known in closed form.

use std::f64::consts::{PI, TAU};

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DVec3;

use super::*;
use crate::parametric::brep::Brep;
use crate::parametric::mesh::{MeshSizes, Parametric};
use crate::parametric::nurbs::SplineEnds;
use crate::parametric::{Curve, Frame, Surface};
use crate::run::Run;

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|p| v(p[0], p[1], 0.0)).collect()
}

fn square() -> Wire {
    Wire::polygon(&flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])).unwrap()
}

fn disk(at: DVec3, r: f64) -> Wire {
    Wire::circle(Frame { origin: at, ..Frame::WORLD }, r).unwrap()
}

/// What every built body must be: loops closed; edges on their faces' surfaces; of solids, every edge used once in each
/// direction.
fn consistent(b: &Brep) {
    let p = Parametric::new(b.clone(), &Run::new()).unwrap();
    let size = p.bounds().diagonal();
    for e in &b.edges {
        for k in 0..2 {
            let (p, q) = (e.curve.at(e.range[k]), b.vertices[e.ends[k] as usize]);
            assert!(p.distance(q) < 1e-9 * size, "{p} {q} {:?}", e.curve);
        }
    }
    let mut uses = vec![[0, 0]; b.edges.len()];
    let solid = b.bodies.iter().all(|x| x.solid);
    for (f, face) in b.faces.iter().enumerate() {
        for l in &face.loops {
            let ends = |c: &crate::parametric::brep::Coedge| {
                let [a, b] = b.edges[c.edge as usize].ends;
                if c.forward { [a, b] } else { [b, a] }
            };
            for (i, c) in l.iter().enumerate() {
                assert_eq!(ends(c)[1], ends(&l[(i + 1) % l.len()])[0], "face {f}");
                uses[c.edge as usize][usize::from(c.forward)] += 1;
                let e = &b.edges[c.edge as usize];
                for k in 0..=6 {
                    let q = e.curve.at(e.range[0] + (e.range[1] - e.range[0]) * f64::from(k) / 6.0);
                    let off = p.foot(f as u32, q).unwrap().distance(q);
                    assert!(
                        off < 1e-8 * size,
                        "edge {} is {off} off face {} ({})",
                        c.edge,
                        face.name,
                        face.surface.kind()
                    );
                }
            }
        }
    }
    assert!(!solid || uses.iter().all(|u| *u == [1, 1]), "{uses:?}");
}

/// A solid's volume; its first mesh must be closed, oriented outwards, a manifold of the given Euler number, with nodes on the
/// surfaces.
fn volume(b: &Brep, euler: i64) -> f64 {
    consistent(b);
    let run = Run::new();
    let p = Parametric::new(b.clone(), &run).unwrap();
    let size = 0.05 * p.bounds().diagonal();
    let by = move |k: f64| size.min(0.35 / k.max(1e-300)).max(size / 6.0);
    let m = p.mesh(&MeshSizes::new(size, size / 6.0, &by), &run).unwrap();
    assert!(m.failures.is_empty(), "{:?}", m.failures);
    let mut mesh = m.mesh.clone();
    mesh.drop_unused_nodes();
    let d = mesh.defects();
    assert!(d.is_closed() && d.is_manifold() && d.is_oriented(), "{d:?}");
    assert_eq!(mesh.topology(&d).euler, euler);
    for (t, l) in m.mesh.triangles.iter().zip(&m.mesh.labels) {
        for v in t {
            let q = m.mesh.nodes[*v as usize];
            assert!(p.foot(*l, q).unwrap().distance(q) < 1e-8 * p.bounds().diagonal());
        }
    }
    p.measure(&run).unwrap().volumes[0]
}

#[track_caller]
fn near(found: f64, truth: f64, share: f64) {
    assert_relative_eq!(found, truth, epsilon = 0.0, max_relative = share);
}

fn kinds(b: &Brep) -> Vec<&'static str> {
    b.faces.iter().map(|f| f.surface.kind()).collect()
}

#[test]
fn extrusions_have_the_volume_of_their_frustum() {
    for s in [0.01, 0.5, 1.0, 2.0] {
        let how = Extrusion { scale: s, ..Extrusion::new(v(0.0, 0.0, 3.0), 1.5) };
        let share = (1.0 + s + s * s) / 3.0;
        let b = extrude_edges(&[square()], &how).unwrap();
        assert_eq!(kinds(&b), ["plane"; 6]);
        near(volume(&b, 2), 2.0 * 1.5 * share, 1e-12);
        // A disk with a hole: cylinders or cones, and two caps with two loops.
        let ring = [disk(DVec3::ZERO, 2.0), disk(DVec3::ZERO, 1.0)];
        let b = extrude_edges(&ring, &how).unwrap();
        assert_eq!(b.faces[0].surface.kind(), if s == 1.0 { "cylinder" } else { "cone" });
        assert_eq!(b.faces.len(), 4);
        near(volume(&b, 0), 3.0 * PI * 1.5 * share, 4e-6);
        // Off the axis the cone is oblique.
        let how = Extrusion { center: Some(v(5.0, 0.0, 0.0)), direction: v(0.3, 0.0, 1.0), ..how };
        let b = extrude_edges(&[disk(DVec3::ZERO, 2.0)], &how).unwrap();
        near(volume(&b, 2), 4.0 * PI * 1.5 / 1.09f64.sqrt() * share, 4e-6);
    }
}

#[test]
fn closed_splines_are_extruded_with_their_own_area() {
    let points = flat(&[[0.0, 0.0], [2.0, 0.3], [3.0, 2.0], [1.0, 2.5], [-0.5, 1.0]]);
    let w = Wire::spline(&points, SplineEnds::Closed).unwrap();
    let area = w.area_vector().length();
    for (s, kind) in [(1.0, "extrusion"), (0.5, "nurbs")] {
        let b =
            extrude_edges(std::slice::from_ref(&w), &Extrusion { scale: s, ..Extrusion::new(-DVec3::Z, 2.0) }).unwrap();
        assert_eq!(kinds(&b), [kind, "plane", "plane"]);
        near(volume(&b, 2), 2.0 * area * (1.0 + s + s * s) / 3.0, 4e-6);
    }
}

#[test]
fn open_contours_make_sheets_and_are_refused_as_solids() {
    let line = Wire::polyline(&[v(0.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(4.0, 2.0, 0.0)]).unwrap();
    let sheet = Extrusion { caps: false, ..Extrusion::new(DVec3::Z, 1.0) };
    let b = extrude_edges(std::slice::from_ref(&line), &sheet).unwrap();
    consistent(&b);
    assert_eq!((b.faces.len(), b.edges.len(), b.vertices.len(), b.bodies[0].solid), (2, 7, 6, false));
    let e = extrude_edges(std::slice::from_ref(&line), &Extrusion::new(DVec3::Z, 1.0)).unwrap_err().to_string();
    assert!(e.contains("a gap of 4.12") && e.contains("[4, 2, 0]") && e.contains("[0, 1, 0]"), "{e}");
    let axis = Axis { origin: DVec3::ZERO, direction: DVec3::Y };
    let e = revolve_edges(&line, &axis, 360.0, true).unwrap_err().to_string();
    assert!(e.contains("a gap of"), "{e}");
}

#[test]
fn what_cannot_be_built_is_refused_with_its_place() {
    let z = Extrusion::new(DVec3::Z, 1.0);
    let says = |r: crate::Result<Brep>, what: &str| {
        let e = r.unwrap_err().to_string();
        assert!(e.contains(what), "{e}");
    };
    says(extrude_edges(&[square()], &Extrusion::new(DVec3::ZERO, 1.0)), "direction");
    says(extrude_edges(&[square()], &Extrusion { scale: 0.0, ..z }), "scale");
    says(extrude_edges(&[square()], &Extrusion { distance: f64::NAN, ..z }), "distance");
    says(extrude_edges(&[square()], &Extrusion { direction: DVec3::X, ..z }), "encloses nothing");
    says(extrude_edges(&[square(), disk(v(9.0, 0.0, 0.0), 0.1)], &z), "not inside");
    let bent = Wire::polygon(&[DVec3::ZERO, DVec3::X, v(1.0, 1.0, 0.2), DVec3::Y]).unwrap();
    says(extrude_edges(&[bent], &z), "not flat");
    let y = Axis { origin: v(1.0, 0.0, 0.0), direction: DVec3::Y };
    says(revolve_edges(&square(), &y, 360.0, true), "crosses the axis");
    says(revolve_edges(&square(), &y, 0.0, true), "angle");
    says(revolve_edges(&disk(v(2.0, 0.0, 0.0), 1.0), &y, 360.0, true), "touches the axis");
    says(loft(&[Section::Wire(square())], &Loft::default()), "two sections");
    says(loft(&[Section::Point(DVec3::X), Section::Point(DVec3::Y)], &Loft::default()), "not a point");
    says(loft(&[Section::Wire(square()), Section::Wire(disk(DVec3::Z, 1.0))], &Loft::default()), "others have 4");
    let corner = Wire::polyline(&[DVec3::ZERO, DVec3::Z, v(1.0, 0.0, 1.0)]).unwrap();
    says(sweep_edges(&[square()], &corner, true), "corner at [0, 0, 1]");
    let bend = Wire::spline(&[DVec3::ZERO, v(0.0, 0.0, 1.0), v(1.0, 0.0, 2.0)], SplineEnds::Natural).unwrap();
    says(sweep_edges(&[disk(DVec3::ZERO, 5.0)], &bend, true), "the sweep folds");
}

#[test]
fn revolutions_follow_pappus() {
    // The square 1..3 x 0..1 around y, full and by parts: Pappus with the centroid at 2.
    let w = Wire::polygon(&flat(&[[1.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0]])).unwrap();
    let y = Axis { origin: DVec3::ZERO, direction: v(0.0, 2.0, 0.0) };
    for (degrees, euler) in [(360.0, 0), (250.0, 2), (30.0, 2)] {
        for wire in [w.clone(), w.reversed()] {
            let b = revolve_edges(&wire, &y, degrees, true).unwrap();
            // Faces are numbered as the edges they come from.
            let bottom = b.faces.iter().find(|f| f.name == "side1").unwrap();
            assert!(matches!(bottom.surface, Surface::Plane { .. }));
            near(volume(&b, euler), f64::to_radians(degrees) * 2.0 * 2.0, 4e-6);
            assert_eq!(b.faces.len(), if degrees == 360.0 { 4 } else { 6 });
        }
    }
    let b = revolve_edges(&w, &y, 360.0, true).unwrap();
    assert_eq!(kinds(&b), ["cylinder", "plane", "cylinder", "plane"]);
    // A disk becomes a torus, an off-center ellipse a general surface.
    let b = revolve_edges(&disk(v(3.0, 0.0, 0.0), 1.0), &y, 360.0, true).unwrap();
    assert_eq!(kinds(&b), ["torus"]);
    near(volume(&b, 0), TAU * 3.0 * PI, 4e-6);
    let e = Wire::ellipse(Frame { origin: v(3.0, 1.0, 0.0), ..Frame::WORLD }, 1.0, 0.5).unwrap();
    let b = revolve_edges(&e, &y, 360.0, true).unwrap();
    assert_eq!(kinds(&b), ["revolution"]);
    near(volume(&b, 0), TAU * 3.0 * PI * 0.5, 4e-6);
}

#[test]
fn where_the_contour_touches_the_axis_there_is_a_pole() {
    let z = Axis { origin: DVec3::ZERO, direction: DVec3::Z };
    // A half circle: a sphere, whole and as an orange's slice.
    let half = Wire::arc(v(0.0, 0.0, -2.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0)).unwrap();
    for degrees in [360.0, 70.0] {
        let b = revolve_edges(&half, &z, degrees, true).unwrap();
        assert_eq!(kinds(&b)[0], "sphere");
        assert_eq!(b.vertices.len(), 2);
        near(volume(&b, 2), 32.0 * PI / 3.0 * degrees / 360.0, 4e-6);
    }
    // A triangle on the axis: a cone with its apex.
    let w = Wire::polygon(&[DVec3::ZERO, v(2.0, 0.0, 0.0), v(0.0, 0.0, 3.0)]).unwrap();
    for degrees in [360.0, 90.0] {
        let b = revolve_edges(&w, &z, degrees, true).unwrap();
        near(volume(&b, 2), 4.0 * PI * degrees / 360.0, 4e-6);
    }
    // A spline from pole to pole, around a slanted axis.
    let axis = Axis { origin: v(1.0, 1.0, 0.0), direction: v(3.0, 1.0, 2.0) };
    let frame = Frame::new(axis.origin, axis.direction, None);
    let at = |r: f64, h: f64| frame.point(v(r, 0.0, h));
    let w = Wire::spline(&[at(0.0, 0.0), at(1.0, 0.5), at(0.7, 2.0), at(0.0, 3.0)], SplineEnds::Natural).unwrap();
    let b = revolve_edges(&w, &axis, 360.0, true).unwrap();
    let k = frame.z();
    let turn = |p: DVec3| (p - axis.origin - k * (p - axis.origin).dot(k)).length_squared();
    let truth: f64 = w.pieces().iter().map(|p| p.integral(&|q, d| PI * turn(q) * d.dot(k))).sum();
    near(volume(&b, 2), truth.abs(), 4e-6);
}

#[test]
fn models_reach_as_far_as_their_faces_bulge() {
    let z = Axis { origin: DVec3::ZERO, direction: DVec3::Z };
    // A ball with a flat of radius 0.2 on top: its edges are hardly larger than the flat.
    let top = (4.0f64 - 0.04).sqrt();
    let ball = Wire::arc(v(0.0, 0.0, -2.0), v(2.0, 0.0, 0.0), v(0.2, 0.0, top)).unwrap();
    let lid = Wire::polyline(&[v(0.2, 0.0, top), v(0.0, 0.0, top)]).unwrap();
    let b = revolve_edges(&Wire::joined(&[ball, lid]).unwrap(), &z, 360.0, true).unwrap();
    // A quarter of a barrel.
    let arc = Wire::arc(v(1.0, 0.0, -1.0), v(1.5, 0.0, 0.0), v(1.0, 0.0, 1.0)).unwrap();
    let quarter = revolve_edges(&arc, &z, 90.0, false).unwrap();
    for (b, lo, hi) in [(b, v(-2.0, -2.0, -2.0), v(2.0, 2.0, top)), (quarter, v(0.0, 0.0, -1.0), v(1.5, 1.5, 1.0))] {
        let found = Parametric::new(b, &Run::new()).unwrap().bounds();
        let size = hi.distance(lo);
        let off = (found.lo - lo).abs().max((found.hi - hi).abs()).max_element();
        assert!(off < 0.01 * size, "{found:?} {lo} {hi}");
    }
}

#[test]
fn lofts_pass_through_their_sections_and_end_in_points() {
    // Equal circles: a cylinder, whether smooth or ruled. Three of them, the loft has them all.
    let round = |z: f64, r: f64| Section::Wire(disk(v(0.0, 0.0, z), r));
    for ruled in [false, true] {
        let b = loft(&[round(0.0, 1.0), round(1.0, 1.0), round(3.0, 1.0)], &Loft { ruled, ..Loft::default() }).unwrap();
        assert_eq!(b.faces.len(), if ruled { 4 } else { 3 });
        near(volume(&b, 2), 3.0 * PI, 4e-6);
    }
    // Turned the other way round and downwards.
    let mut list = [round(0.0, 1.0), round(1.0, 1.0), round(3.0, 1.0)];
    list.reverse();
    if let Section::Wire(w) = &list[1] {
        list[1] = Section::Wire(w.reversed());
    }
    assert!(loft(&list, &Loft::default()).is_ok());
    // Pyramid and cone.
    let tip = Section::Point(v(1.0, 0.5, 3.0));
    let b = loft(&[Section::Wire(square()), tip.clone()], &Loft { ruled: true, ..Loft::default() }).unwrap();
    assert_eq!(kinds(&b), ["plane"; 5]);
    near(volume(&b, 2), 2.0, 1e-12);
    let b = loft(&[round(0.0, 1.0), Section::Point(v(0.0, 0.0, 3.0))], &Loft::default()).unwrap();
    near(volume(&b, 2), PI, 4e-6);
    // Points at both ends, round: no corner at the poles, and much like an ellipsoid.
    let r = |z: f64| 2.0 * (1.0f64 - z * z / 9.0).max(0.0).sqrt();
    let zs = [-2.6, -1.5, 0.0, 1.5, 2.6];
    let mut s = vec![Section::Point(v(0.0, 0.0, -3.0))];
    s.extend(zs.map(|z| round(z, r(z))));
    s.push(Section::Point(v(0.0, 0.0, 3.0)));
    let b = loft(&s, &Loft { round: [true, true], ..Loft::default() }).unwrap();
    near(volume(&b, 2), 4.0 / 3.0 * PI * 12.0, 0.01);
    let Surface::Nurbs(n) = &b.faces[0].surface else { panic!() };
    assert_abs_diff_eq!(n.jet(0.3, 0.0)[2].normalize().z, 0.0, epsilon = 1e-12);
}

#[test]
fn sections_of_different_curves_are_joined() {
    // A square of four edges to a circle of four arcs.
    let c = |k: i32| v((f64::from(k) * PI / 2.0).cos(), (f64::from(k) * PI / 2.0).sin(), 2.0);
    let m = |k: i32| v((f64::from(k) * PI / 2.0 + 0.8).cos(), (f64::from(k) * PI / 2.0 + 0.8).sin(), 2.0);
    let arcs: Vec<Wire> = (0..4).map(|k| Wire::arc(c(k), m(k), c(k + 1)).unwrap()).collect();
    let corners: Vec<DVec3> = (0..4).map(|k| c(k) * v(2.0, 2.0, 0.0)).collect();
    let s = [Section::Wire(Wire::polygon(&corners).unwrap()), Section::Wire(Wire::joined(&arcs).unwrap())];
    let b = loft(&s, &Loft::default()).unwrap();
    let found = volume(&b, 2);
    // Between the prisms of both ends.
    assert!(found > 2.0 * PI && found < 16.0, "{found}");
    let sheet = ruled(
        &Wire::polyline(&[DVec3::ZERO, DVec3::X]).unwrap(),
        &Wire::polyline(&[DVec3::Y, v(1.0, 1.0, 1.0)]).unwrap(),
    );
    let sheet = sheet.unwrap();
    consistent(&sheet);
    assert_eq!((sheet.faces.len(), sheet.faces[0].surface.kind()), (1, "nurbs"));
}

#[test]
fn sweeps_keep_the_profile_along_lines_arcs_and_splines() {
    // Straight, a quarter of a circle, straight: a pipe bend with a bore.
    let path = Wire::joined(&[
        Wire::polyline(&[DVec3::ZERO, v(0.0, 0.0, 2.0)]).unwrap(),
        Wire::arc(v(0.0, 0.0, 2.0), v(3.0 - 3.0 * 0.5f64.sqrt(), 0.0, 2.0 + 3.0 * 0.5f64.sqrt()), v(3.0, 0.0, 5.0))
            .unwrap(),
        Wire::polyline(&[v(3.0, 0.0, 5.0), v(5.0, 0.0, 5.0)]).unwrap(),
    ])
    .unwrap();
    let b = sweep_edges(&[disk(DVec3::ZERO, 1.0), disk(DVec3::ZERO, 0.5)], &path, true).unwrap();
    assert_eq!(kinds(&b), ["cylinder", "torus", "cylinder", "cylinder", "torus", "cylinder", "plane", "plane"]);
    near(volume(&b, 0), 0.75 * PI * (4.0 + 1.5 * PI), 4e-6);
    // Along a spline in space the volume is area times length, as the centroid is on the path.
    let path = Wire::spline(&[DVec3::ZERO, v(1.0, 0.0, 4.0), v(4.0, 3.0, 6.0), v(9.0, 3.0, 8.0)], SplineEnds::Natural)
        .unwrap();
    let t = path.pieces()[0].tangent(0.0);
    let profile = Wire::circle(Frame::new(DVec3::ZERO, t, None), 0.4).unwrap();
    let b = sweep_edges(&[profile], &path, true).unwrap();
    let p = &path.pieces()[0];
    near(volume(&b, 2), PI * 0.16 * p.curve.length(p.range), 4e-6);
    // Around a circle.
    let ring = Wire::circle(Frame::WORLD, 3.0).unwrap();
    let profile = Wire::circle(Frame::new(v(3.0, 0.0, 0.0), DVec3::Y, None), 1.0).unwrap();
    near(volume(&sweep_edges(&[profile], &ring, true).unwrap(), 0), TAU * 3.0 * PI, 4e-6);
}

#[test]
fn the_thesis_examples_are_built() {
    let segment = Wire::polyline(&[DVec3::ZERO, DVec3::X]).unwrap();
    let polyline =
        Wire::polyline(&[v(0.0, 1.0, 0.0), v(2.0, 0.0, 0.0), v(4.0, 2.0, 0.0), v(4.0, -1.0, 0.0), v(6.0, 1.0, 0.0)])
            .unwrap();
    let points = [v(0.0, 0.0, 0.0), v(2.0, 2.0, 0.0), v(4.0, -1.0, 0.0), v(6.0, 1.0, 0.0), v(7.0, 0.0, 0.0)];
    let spline = Wire::spline(&points, SplineEnds::Natural).unwrap();
    let run = Run::new();
    for s in [0.01, 1.0, 2.0] {
        for (w, d) in [(&segment, DVec3::Y), (&polyline, DVec3::Z), (&spline, DVec3::Z)] {
            let how = Extrusion { scale: s, caps: false, ..Extrusion::new(d, 1.0) };
            let b = extrude_edges(std::slice::from_ref(w), &how).unwrap();
            consistent(&b);
            let m = Parametric::new(b, &run).unwrap().measure(&run).unwrap();
            let length: f64 = w.pieces().iter().map(|p| p.curve.length(p.range)).sum();
            if s == 1.0 {
                near(m.area(), length, 1e-5);
            }
            if std::ptr::eq(w, &segment) {
                near(m.area(), 0.5 * (1.0 + s), 1e-9);
            }
        }
    }
    for (w, axis) in [(&segment, DVec3::Z), (&segment, v(3.0, 1.0, 2.0)), (&polyline, DVec3::Y)] {
        let b = revolve_edges(w, &Axis { origin: DVec3::ZERO, direction: axis }, 360.0, false).unwrap();
        consistent(&b);
        let m = Parametric::new(b, &run).unwrap().measure(&run).unwrap();
        // Guldin: length times the way of its middle, edge by edge.
        let k = axis.normalize();
        let truth: f64 =
            w.pieces().iter().map(|p| p.integral(&|q, d| TAU * (q - k * q.dot(k)).length() * d.length())).sum();
        near(m.area(), truth, 1e-5);
    }
    assert!(matches!(spline.pieces()[0].curve, Curve::Nurbs(_)));
}
