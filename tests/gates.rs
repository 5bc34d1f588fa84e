//! The same solid by three gates: as R-functions, as a boundary representation and as fine triangles. The same wish makes about the same
//! mesh of it, whichever way it came in.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use approx::abs_diff_eq;
use rvachev::implicit::part::parse;
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{MeshOptions, Meshed, SizeRequest, SoupOptions, expected_triangles, mesh_part, mesh_soup};
use rvachev::quality::Fault;
use rvachev::{DVec3, Run};

mod shapes;
use shapes::{prism, revolved};

/// Triangles of curved walls are this far from them.
const EXACT: f64 = 1e-6;
/// The same where a surface bends both ways and there would be millions.
const FINE: f64 = 1e-4;

struct Solid {
    name: &'static str,
    functions: &'static str,
    edges: &'static str,
    triangles: TriMesh,
    volume: f64,
}

/// How many sides a circle has that stays within `off` of its polygon.
fn sides(radius: f64, off: f64) -> u32 {
    (PI / (1.0 - off / radius).acos()).ceil() as u32
}

/// Points `[radius, z]` on an arc about `center`, both ends among them.
fn arc(center: [f64; 2], radius: f64, [from, to]: [f64; 2], off: f64) -> Vec<[f64; 2]> {
    let count = (f64::from(sides(radius, off)) * (to - from).abs() / TAU).ceil();
    let at = |k: u32| from + (to - from) * f64::from(k) / count;
    (0..=count as u32).map(|k| [center[0] + radius * at(k).cos(), center[1] + radius * at(k).sin()]).collect()
}

/// The same with both ends on the axis.
fn from_pole_to_pole(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let last = points.len() - 1;
    (points[0][0], points[last][0]) = (0.0, 0.0);
    points
}

/// A bored plate as CAD programs write it: fans of needles from the outer corners to the bore.
fn bored_plate() -> TriMesh {
    let n = sides(0.5, EXACT).div_ceil(8) * 8;
    let rim = |k: u32| {
        let (s, c) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
        [0.5 * c, 0.5 * s]
    };
    // Corner k sees the quarter of the rim from k * 90 to k * 90 + 90 degrees.
    let corners = [[2.0, 1.5], [-2.0, 1.5], [-2.0, -1.5], [2.0, -1.5]];
    let mut nodes = Vec::new();
    for z in [0.0, 0.5] {
        nodes.extend((0..n).map(rim).chain(corners).map(|[x, y]| DVec3::new(x, y, z)));
    }
    let top = n + 4;
    let mut triangles = Vec::new();
    let mut flat = |[a, b, c]: [u32; 3]| triangles.extend([[a + top, b + top, c + top], [a, c, b]]);
    for k in 0..n {
        flat([k, n + 4 * k / n, (k + 1) % n]);
    }
    for i in 0..4u32 {
        flat([(i + 1) % 4 * n / 4, n + i, n + (i + 1) % 4]);
    }
    let mut wall = |a: u32, b: u32| triangles.extend([[a, b, b + top], [a, b + top, a + top]]);
    (0..n).for_each(|k| wall((k + 1) % n, k));
    (0..4u32).for_each(|i| wall(n + i, n + (i + 1) % 4));
    TriMesh::new(nodes, triangles)
}

fn solids() -> Vec<Solid> {
    let round = |profile: &[[f64; 2]]| revolved(profile, sides(1.0, EXACT), false);
    let ball = from_pole_to_pole(arc([0.0, 0.0], 1.0, [-FRAC_PI_2, FRAC_PI_2], FINE));
    let tube = arc([2.0, 0.0], 0.6, [0.0, TAU], FINE);
    // Two balls of radius 2 whose centers are 3 apart.
    let rim = 1.75f64.sqrt();
    let half = (rim / 2.0).acos();
    let mut lens = arc([0.0, 1.5], 2.0, [-FRAC_PI_2, -half], FINE);
    lens.extend(arc([0.0, -1.5], 2.0, [half, FRAC_PI_2], FINE).into_iter().skip(1));
    vec![
        Solid {
            name: "box",
            functions: "part(box(lo=(0, 0, 0), hi=(4, 3, 2)).name(\"a\"))",
            edges: "part(extrude_edges(polyline([(0, 0), (4, 0), (4, 3), (0, 3)], closed=True), \"z\", 2).name(\"a\"))",
            triangles: prism(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]], 2.0),
            volume: 24.0,
        },
        Solid {
            name: "cylinder",
            functions: "part(cylinder(1, height=3).name(\"a\"))",
            edges: "part(extrude_edges([circle(1)], \"z\", 3).name(\"a\"))",
            triangles: round(&[[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.0, 3.0]]),
            volume: 3.0 * PI,
        },
        Solid {
            name: "ball",
            functions: "part(sphere(1).name(\"a\"))",
            edges: "part(revolve_edges(arc((0, 0, -1), (1, 0, 0), (0, 0, 1)), \"z\").name(\"a\"))",
            triangles: revolved(&ball, sides(1.0, FINE), false),
            volume: 4.0 * PI / 3.0,
        },
        Solid {
            name: "torus",
            functions: "part(torus(2, 0.6).name(\"a\"))",
            edges: "part(revolve_edges(circle(0.6, at=(2, 0, 0), axis=\"y\"), \"z\").name(\"a\"))",
            triangles: revolved(&tube[1..], sides(2.6, FINE), true),
            volume: 2.0 * PI * PI * 2.0 * 0.36,
        },
        Solid {
            name: "frustum",
            functions: "part(cone(1.5, 0.5, 2).name(\"a\"))",
            edges: "part(revolve_edges(polyline([(0, 0, 0), (1.5, 0, 0), (0.5, 0, 2), (0, 0, 2)]), \"z\").name(\"a\"))",
            triangles: round(&[[0.0, 0.0], [1.5, 0.0], [0.5, 2.0], [0.0, 2.0]]),
            volume: 2.0 * PI / 3.0 * (2.25 + 0.75 + 0.25),
        },
        Solid {
            name: "bored plate",
            functions: "part((box(lo=(-2, -1.5, 0), hi=(2, 1.5, 0.5)) - cylinder(0.5)).name(\"a\"))",
            edges: "outer = polyline([(-2, -1.5), (2, -1.5), (2, 1.5), (-2, 1.5)], closed=True)\npart(extrude_edges([outer, circle(0.5)], \"z\", 0.5).name(\"a\"))",
            triangles: bored_plate(),
            volume: 0.5 * (12.0 - 0.25 * PI),
        },
        Solid {
            name: "shaft",
            functions: "part((cylinder(1, height=2, at=(0, 0, 1)) | cylinder(0.6, height=3, at=(0, 0, 2.5)) | cylinder(0.8, height=1, at=(0, 0, 4.5))).name(\"a\"))",
            edges: "part(revolve_edges(polyline([(0, 0, 0), (1, 0, 0), (1, 0, 2), (0.6, 0, 2), (0.6, 0, 4), (0.8, 0, 4), (0.8, 0, 5), (0, 0, 5)]), \"z\").name(\"a\"))",
            triangles: round(&[
                [0.0, 0.0],
                [1.0, 0.0],
                [1.0, 2.0],
                [0.6, 2.0],
                [0.6, 4.0],
                [0.8, 4.0],
                [0.8, 5.0],
                [0.0, 5.0],
            ]),
            volume: PI * (2.0 + 0.72 + 0.64),
        },
        Solid {
            name: "lens",
            functions: "part((sphere(2, at=(0, 0, 1.5)) & sphere(2, at=(0, 0, -1.5))).name(\"a\"))",
            edges: "r = sqrt(1.75)\nx, z = 2 * sin(0.3), 1.5 - 2 * cos(0.3)\npart(revolve_edges(chain([arc((0, 0, -0.5), (x, 0, z), (r, 0, 0)), arc((r, 0, 0), (x, 0, -z), (0, 0, 0.5))]), \"z\").name(\"a\"))",
            triangles: revolved(&from_pole_to_pole(lens), sides(rim, FINE), false),
            volume: 2.0 * PI * 0.25 * (2.0 - 0.5 / 3.0),
        },
    ]
}

/// Triangles and the 5th percentile of angles, after the mesh has shown that it is sound and of this solid.
fn measured(made: &Meshed, solid: &Solid, share: f64) -> [f64; 2] {
    let what = format!("{} at {share}", solid.name);
    assert!(made.report.shortfalls.is_empty(), "{what}: {:?}", made.report.shortfalls);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{what}: {:?}", check.certificate);
    let off = (check.volume.unwrap() / solid.volume - 1.0).abs();
    assert!(off < 0.7 * share, "{what}: {off}");
    assert!(check.quality.min_angle > 30.0, "{what}: {:?}", check.quality);
    [made.mesh.triangles.len() as f64, check.quality.p05_angle]
}

#[test]
fn the_same_wish_makes_the_same_mesh_by_every_gate() {
    let run = Run::new();
    let mut angles = [0.0; 3];
    let (mut count, mut table) = (0.0, String::new());
    for solid in solids() {
        let bounds = solid.triangles.bounds();
        for share in [0.05, 0.03, 0.02] {
            let size = SizeRequest::Length(share * bounds.diagonal());
            let options = MeshOptions { size: Some(size), ..MeshOptions::default() };
            let by = |text: &str| mesh_part(&parse(text, &[]).unwrap(), &options, &run).unwrap();
            let made = [
                by(solid.functions),
                by(solid.edges),
                mesh_soup(&solid.triangles, &options, &SoupOptions::default(), &run).unwrap(),
            ];
            let told = [
                expected_triangles(&run, |run| mesh_part(&parse(solid.functions, &[]).unwrap(), &options, run)),
                expected_triangles(&run, |run| mesh_part(&parse(solid.edges, &[]).unwrap(), &options, run)),
                expected_triangles(&run, |run| mesh_soup(&solid.triangles, &options, &SoupOptions::default(), run)),
            ];
            for (made, told) in made.iter().zip(told) {
                let share = told.unwrap() as f64 / made.mesh.triangles.len() as f64;
                assert!(abs_diff_eq!(share, 1.0, epsilon = 0.15), "{}: told {share} of its triangles", solid.name);
            }
            let [a, b, c] = made.each_ref().map(|m| measured(m, &solid, share));
            table += &format!("{} {share}: {a:?} {b:?} {c:?}\n", solid.name);
            let counts = [a[0], b[0], c[0]];
            let most = counts.iter().copied().fold(0.0, f64::max);
            assert!(most <= 1.1 * counts.iter().copied().fold(most, f64::min), "{table}");
            for (sum, one) in angles.iter_mut().zip([a, b, c]) {
                *sum += one[1];
            }
            count += 1.0;
        }
    }
    let means = angles.map(|a| a / count);
    println!("{table}{means:?}");
    let most = means.iter().copied().fold(0.0, f64::max);
    assert!(means.iter().all(|a| most - a < 1.0), "{means:?}\n{table}");
}

#[test]
fn a_tolerance_asked_for_is_kept_by_functions_or_told() {
    let (run, size) = (Run::new(), Some(SizeRequest::Length(1.0)));
    let solids = [
        "part(sphere(1))",
        "part(torus(1, 0.3))",
        "part(box(size=(2, 2, 1)) - cylinder(0.5))",
        "part(cone(1, 0.2, 1.5))",
    ];
    for text in solids {
        let part = parse(text, &[]).unwrap();
        for tolerance in [0.02, 0.004, 0.0008] {
            let options =
                MeshOptions { size, tolerance: Some(SizeRequest::Length(tolerance)), ..MeshOptions::default() };
            let Meshed { report, .. } = mesh_part(&part, &options, &run).unwrap();
            let d = report.check.unwrap().deviation.unwrap();
            assert!(report.shortfalls.is_empty(), "{text} {tolerance}: {:?}", report.shortfalls);
            assert!(d.max.max(d.from_surface.unwrap()) <= tolerance, "{text} {tolerance}: {d:?}");
        }
    }
    // Edges may not be as short as that takes.
    let part = parse("part(sphere(1) | sphere(1, at=(1, 0, 0)))", &[]).unwrap();
    let options = MeshOptions {
        size,
        tolerance: Some(SizeRequest::Length(1e-5)),
        least: Some(SizeRequest::Length(0.2)),
        ..MeshOptions::default()
    };
    let Meshed { report, .. } = mesh_part(&part, &options, &run).unwrap();
    assert!(report.shortfalls.iter().any(|f| matches!(f, Fault::Far { .. })), "{:?}", report.shortfalls);
}
