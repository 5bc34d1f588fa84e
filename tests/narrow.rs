//! Narrow regions of faces, cut off on both sides of the edges they share: what is left is a solid, nearly the same.

use std::path::Path;

use rvachev::implicit::part::parse;
use rvachev::pipeline::{MeshOptions, Meshed, Rung, SizeRequest, load_part, mesh_part};
use rvachev::{DVec3, Run};

fn options(trim: Option<f64>) -> MeshOptions {
    MeshOptions { trim: trim.map(SizeRequest::Length), ..MeshOptions::default() }
}

/// Meshes a part: sound, nothing short. `trim` as asked for, `None` for what is done without asking.
fn meshed(text: &str, trim: Option<f64>) -> Meshed {
    let made = mesh_part(&parse(text, &[]).unwrap(), &options(trim), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{text}: {:?}", made.report.shortfalls);
    assert!(made.report.check.as_ref().unwrap().certificate.is_sound());
    made
}

fn trimmed(m: &Meshed) -> Vec<&str> {
    m.report.ladder.iter().filter(|s| s.rung == Rung::Trimmed).map(|s| s.face.as_str()).collect()
}

fn trouble(name: &str, trim: f64) -> [Meshed; 2] {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/troubles/{name}.py"));
    let part = load_part(&path, &[]).unwrap();
    [0.0, trim].map(|w| {
        let made = mesh_part(&part, &options(Some(w)), &Run::new()).unwrap();
        assert!(made.report.shortfalls.is_empty(), "{name} {w}: {:?}", made.report.shortfalls);
        made
    })
}

fn smallest_angle(m: &Meshed) -> f64 {
    m.report.check.as_ref().unwrap().quality.min_angle
}

#[test]
fn a_tongue_between_two_edges_is_cut_off_at_both_ends_of_the_solid() {
    let [whole, cut] = trouble("narrow_region", 0.2);
    assert!(trimmed(&whole).is_empty());
    assert_eq!(trimmed(&cut), ["wedge.side7", "wedge.start", "wedge.end"]);
    assert!(3 * cut.mesh.triangles.len() < whole.mesh.triangles.len());
    assert!((cut.mesh.volume() / whole.mesh.volume() - 1.0).abs() < 0.01);
    // No node went farther than half the width from the solid as it was, and away from the tongue all is as it was.
    let tongue = |p: &DVec3| p.x < 8.6 && p.y < 0.4;
    for p in cut.mesh.nodes.iter().filter(|p| !tongue(p)) {
        let upper = p.y > 10.0 - 1e-9 || (p.y - 10.0) * 6.0 - (p.x - 14.0) * 9.92 < 1e-6 || p.x > 14.0;
        assert!((0.0..=20.0).contains(&p.x) && (-1e-9..=10.0 + 1e-9).contains(&p.y) && upper, "{p}");
    }
    assert!(cut.mesh.nodes.iter().all(|p| p.y > -0.1 && p.z > -1e-9 && p.z < 5.0 + 1e-9));
}

#[test]
fn a_splinter_becomes_an_edge() {
    let [whole, cut] = trouble("narrow_face", 0.2);
    assert_eq!(trimmed(&cut), ["block.side2", "block.side4"]);
    let names: Vec<&str> = cut.mesh.faces.iter().map(String::as_str).collect();
    assert_eq!(names, ["block.side1", "block.side3", "block.side5", "block.side6", "block.start", "block.end"]);
    assert!((cut.mesh.volume() / whole.mesh.volume() - 1.0).abs() < 1e-3);
    assert!(2 * cut.mesh.triangles.len() < whole.mesh.triangles.len());
    // Corners of the splinters became one each, in the middle.
    for p in [DVec3::new(9.94, -9.94, 0.0), DVec3::new(9.94, 9.94, 8.0)] {
        assert!(cut.mesh.nodes.iter().any(|q| q.distance(p) < 1e-9), "{p}");
    }
}

/// Bands around an axis, whole or not, with a seam or with ends.
#[test]
fn chamfers_of_turned_parts_become_edges() {
    for (turn, share) in [("", 1.0), (", degrees=120", 1.0 / 3.0)] {
        let profile = "polyline([(0, 0, 0), (5, 0, 0), (5, 0, 5.995), (4.995, 0, 6), (0, 0, 6), (0, 0, 0)])";
        let text = format!("part(revolve_edges({profile}, \"z\"{turn}).name(\"a\"))\nmesh(size=0.35)\n");
        let (whole, cut) = (meshed(&text, Some(0.0)), meshed(&text, None));
        assert_eq!(trimmed(&cut).len(), 1, "{:?}", cut.report.ladder);
        assert_eq!(cut.mesh.faces.len() + 1, whole.mesh.faces.len());
        let exact = std::f64::consts::PI * 150.0 * share;
        assert!((cut.mesh.volume() / exact - 1.0).abs() < 0.02, "{} {exact}", cut.mesh.volume());
        assert!(2 * cut.mesh.triangles.len() < whole.mesh.triangles.len());
    }
}

/// The edges of a thin plate are no slivers: without asking they stay, asked for they go.
#[test]
fn plates_keep_their_edges() {
    let text = "part(extrude_edges(polyline([(0, 0), (9, 0), (9, 9), (0, 9)], closed=True), \"z\", 0.02).name(\"a\"))\nmesh(size=1)\n";
    let plain = meshed(text, None);
    assert!(trimmed(&plain).is_empty());
    assert!((plain.mesh.volume() - 1.62).abs() < 1e-9);
}

/// Where a bore comes near to the side of a plate there would be needles.
#[test]
fn the_neck_beside_a_bore_is_cut_off() {
    let text = "part(extrude_edges([polyline([(-6, -5), (6, -5), (6, 5), (-6, 5)], closed=True), circle(2, at=(0, 2.998, 0))], \"z\", 4).name(\"a\"))\nmesh(size=1)\n";
    let (whole, cut) = (meshed(text, Some(0.0)), meshed(text, None));
    assert_eq!(trimmed(&cut), ["a.start", "a.end"]);
    let angles = [&whole, &cut].map(smallest_angle);
    assert!(2.0 * angles[0] < angles[1], "{angles:?}");
    assert!((cut.mesh.volume() / whole.mesh.volume() - 1.0).abs() < 1e-3);
    assert_eq!(cut.report.check.as_ref().unwrap().genus, Some(1));
}

#[test]
fn the_same_for_any_number_of_threads() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/troubles/narrow_region.py");
    let part = load_part(&path, &[]).unwrap();
    let made = [1, 3].map(|n| {
        let run = Run::new().with_threads(n).unwrap();
        mesh_part(&part, &options(Some(0.2)), &run).unwrap().mesh
    });
    assert_eq!(made[0], made[1]);
}
