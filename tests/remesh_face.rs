//! One face of a finished mesh made anew at another size: it alone changes, and what comes out is as sound as a mesh made whole.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use rvachev::implicit::part::parse;
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{
    MeshOptions, Meshed, Method, SizeRequest, SoupOptions, load_mesh, load_step, mesh_part, mesh_soup, mesh_step,
};
use rvachev::{DVec3, Run};

/// The side of the cube is 2, and its bore runs along z.
const RADIUS: f64 = 0.5;
const PART: &str = "part(box((2, 2, 2)).name(\"cube\") - cylinder(0.5, \"z\").name(\"bore\"))\n\
                    group(\"loaded\", faces(\"cube*\"))\n";
const SIZE: f64 = 0.2;
/// A tube with radii 1 and 2 and of height 1, built from edges.
const RING: &str =
    "revolve_edges(polyline([(1, 0, 0), (2, 0, 0), (2, 0, 1), (1, 0, 1)], closed=True), \"z\").name(\"ring\")";

fn made(text: &str, options: MeshOptions) -> Meshed {
    let options = MeshOptions { size: Some(SizeRequest::Length(SIZE)), ..options };
    mesh_part(&parse(text, &[]).unwrap(), &options, &Run::new()).unwrap()
}

fn remeshed(before: &Meshed, face: &str, size: f64) -> Meshed {
    let mut made = before.clone();
    made.remesh_face(face, size, &Run::new()).unwrap();
    made
}

fn label(mesh: &TriMesh, face: &str) -> u32 {
    mesh.faces.iter().position(|f| f == face).unwrap() as u32
}

/// The corners of the triangles of a face, or of all others, in order and bit by bit.
fn triangles(mesh: &TriMesh, face: &str, of_face: bool) -> Vec<(String, [[u64; 3]; 3])> {
    let own = label(mesh, face);
    let list = (0..mesh.triangles.len()).filter(|t| (mesh.labels[*t] == own) == of_face);
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    list.map(|t| (mesh.faces[mesh.labels[t] as usize].clone(), mesh.corners(t).map(bits))).collect()
}

/// Only `face` differs from what was; the mesh is sound by the report and by a check of its own, and its fragments join again.
fn only(before: &Meshed, after: &Meshed, face: &str) {
    only_of_any(before, after, face);
    let told = after.report.check.as_ref().unwrap();
    assert_eq!((told.euler, told.deviation.unwrap().inverted), (0, 0));
}

/// The same, whatever the mesh is of.
fn only_of_any(before: &Meshed, after: &Meshed, face: &str) {
    assert_eq!(triangles(&before.mesh, face, false), triangles(&after.mesh, face, false), "{face}");
    assert_ne!(triangles(&before.mesh, face, true), triangles(&after.mesh, face, true), "{face}");
    assert_eq!((&before.mesh.faces, &before.mesh.groups), (&after.mesh.faces, &after.mesh.groups));
    let c = rvachev::quality::check(&after.mesh, Default::default(), None, &Run::new()).unwrap();
    assert!(c.certificate.is_sound() && c.closed && c.manifold && c.oriented, "{face}: {:?}", c.certificate);
    let told = after.report.check.as_ref().unwrap();
    assert!(told.certificate.is_sound() && after.report.shortfalls.is_empty(), "{face}: {:?}", after.report.shortfalls);
    assert_eq!((told.nodes, told.triangles), (after.mesh.nodes.len(), after.mesh.triangles.len()));
    let was = before.report.check.as_ref().unwrap();
    assert_eq!((told.euler, told.closed, told.self_intersections), (was.euler, true, 0));
    let was = before.model().unwrap();
    let cut = after.model().unwrap();
    let counts = [was, cut].map(|c| (c.model.vertices.len(), c.model.edges.len(), c.model.faces.len()));
    assert_eq!(counts[0], counts[1], "{face}");
    assert_eq!(TriMesh::from_view(&after.merged().unwrap()), after.mesh, "{face}");
}

/// The lengths of a face's edges that are not on its border, ascending.
fn inner_edges(mesh: &TriMesh, face: &str) -> Vec<f64> {
    let own = label(mesh, face);
    let mut count: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (t, _) in mesh.triangles.iter().zip(&mesh.labels).filter(|x| *x.1 == own) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *count.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let inner = count.into_iter().filter(|e| e.1 == 2).map(|e| e.0);
    let mut lengths: Vec<f64> = inner.map(|[a, b]| mesh.nodes[a as usize].distance(mesh.nodes[b as usize])).collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}

/// The edges a size asks for on a circle: their middles are off it by 0.45 of the tolerance, which is 0.035 of the size.
fn chord(size: f64, radius: f64) -> f64 {
    let off = 0.45 * 0.035 * size;
    size.min(2.0 * (off * (2.0 * radius - off)).sqrt()).min(20f64.to_radians() * radius)
}

/// The area of a triangle of three equal sides.
fn equilateral(side: f64) -> f64 {
    side * side * 3f64.sqrt() / 4.0
}

fn median(list: &[f64]) -> f64 {
    list[list.len() / 2]
}

fn smallest_angle(mesh: &TriMesh, face: &str) -> f64 {
    let own = label(mesh, face);
    let angles = (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == own).flat_map(|t| {
        let c = mesh.corners(t);
        [0, 1, 2].map(|k| (c[(k + 1) % 3] - c[k]).angle_between(c[(k + 2) % 3] - c[k]).to_degrees())
    });
    angles.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_flat_face_follows_its_size_and_nothing_else_moves() {
    let before = made(PART, MeshOptions::default());
    let face = "cube.xmax";
    // Beside edges four times as long, which stay, some angles are small.
    for (size, least) in [(0.5 * SIZE, 24.0), (0.25 * SIZE, 15.0)] {
        let after = remeshed(&before, face, size);
        only(&before, &after, face);
        let (lengths, angle) = (inner_edges(&after.mesh, face), smallest_angle(&after.mesh, face));
        assert_abs_diff_eq!(median(&lengths), size, epsilon = 0.1 * size);
        assert!(angle > least, "{size}: {angle}");
        // A square of side 2 in equilateral triangles.
        let count = triangles(&after.mesh, face, true).len() as f64 * equilateral(size) / 4.0;
        assert!(abs_diff_eq!(count, 1.0, epsilon = 0.2), "{size}: {count}");
    }
    // Edges grow from those of the border by a fifth of the way, so that the middle, 1 away, is as coarse as asked for.
    let after = remeshed(&before, face, 2.0 * SIZE);
    only(&before, &after, face);
    let (lengths, angle) = (inner_edges(&after.mesh, face), smallest_angle(&after.mesh, face));
    assert!(lengths.last().is_some_and(|l| *l > 1.6 * SIZE && *l < 2.4 * SIZE), "{lengths:?}");
    assert!(4 * lengths.len() < 3 * inner_edges(&before.mesh, face).len() && angle > 35.0, "{} {angle}", lengths.len());
}

#[test]
fn the_nodes_of_a_bore_lie_on_its_cylinder() {
    let before = made(PART, MeshOptions::default());
    for size in [0.5 * SIZE, 0.25 * SIZE, 2.0 * SIZE] {
        let after = remeshed(&before, "bore", size);
        only(&before, &after, "bore");
        let own = label(&after.mesh, "bore");
        let all = after.mesh.triangles.iter().zip(&after.mesh.labels).filter(|x| *x.1 == own).flat_map(|x| x.0);
        let off = all
            .map(|v| after.mesh.nodes[*v as usize].truncate().length() - RADIUS)
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(off <= 1e-9 * size, "{size}: {off}");
        let (lengths, angle) = (inner_edges(&after.mesh, "bore"), smallest_angle(&after.mesh, "bore"));
        let chord = chord(size, RADIUS);
        assert!(abs_diff_eq!(median(&lengths), chord, epsilon = 0.1 * chord), "{size}: {}", median(&lengths));
        assert!(angle > 30.0, "{size}: {angle}");
        // Chords along a circle leave an area of pi h^2 / 6 inside it, and the bore is 2 long. Triangles askew leave less.
        let volume = 8.0 - 2.0 * PI * RADIUS * RADIUS;
        let left = (after.report.check.unwrap().volume.unwrap() - volume) / (PI * chord * chord / 3.0);
        assert!(left > 0.6 && left < 1.0, "{size}: {left}");
    }
}

#[test]
fn a_face_on_two_surfaces_gets_its_seam_anew() {
    // A ridge along y, both sides of which have one name.
    let text = "roof = half_space((1, 0, 1), (0, 0, 1)).name(\"roof\") & half_space((-1, 0, 1), (0, 0, 1)).name(\"roof\")\n\
                part(box((4, 2, 4)).name(\"walls\") & roof)\n";
    let before = made(text, MeshOptions::default());
    let after = remeshed(&before, "roof", 0.5 * SIZE);
    assert_eq!(triangles(&before.mesh, "roof", false), triangles(&after.mesh, "roof", false));
    assert!(after.report.shortfalls.is_empty(), "{:?}", after.report.shortfalls);
    let own = label(&after.mesh, "roof");
    for (t, _) in after.mesh.triangles.iter().zip(&after.mesh.labels).filter(|x| *x.1 == own) {
        let on = |sign: f64| {
            t.iter()
                .all(|v| (sign * after.mesh.nodes[*v as usize].x + after.mesh.nodes[*v as usize].z - 1.0).abs() < 1e-12)
        };
        assert!(on(1.0) || on(-1.0));
    }
    let ridge = |m: &TriMesh| m.nodes.iter().filter(|p| p.x.abs() < 1e-9 && (p.z - 1.0).abs() < 1e-9).count();
    assert!(ridge(&after.mesh) > 3 * ridge(&before.mesh) / 2, "{} {}", ridge(&after.mesh), ridge(&before.mesh));
    assert_eq!(after.seams.len(), ridge(&after.mesh) - 1);
    // A slab of 4 by 1 by 2 below, and a triangle of base 4 and height 2 above.
    let volume = after.report.check.as_ref().unwrap().volume.unwrap();
    assert_abs_diff_eq!(volume, 8.0 + 8.0, epsilon = 1e-9);
    assert_eq!(TriMesh::from_view(&after.merged().unwrap()), after.mesh);
}

#[test]
fn a_face_without_a_border_is_the_whole_mesh() {
    let before = made("part(sphere(1).name(\"ball\"))\n", MeshOptions::default());
    let mut after = before.clone();
    after.remesh_face("ball", 0.1, &Run::new()).unwrap();
    let c = after.report.check.as_ref().unwrap();
    assert!(c.certificate.is_sound() && after.report.shortfalls.is_empty() && c.euler == 2);
    assert!(after.mesh.nodes.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
    let chord = chord(0.1, 1.0);
    let lengths = inner_edges(&after.mesh, "ball");
    assert_abs_diff_eq!(median(&lengths), chord, epsilon = 0.1 * chord);
    let count = after.mesh.triangles.len() as f64 * equilateral(chord) / (4.0 * PI);
    assert_abs_diff_eq!(count, 1.0, epsilon = 0.2);
}

/// The corners of a face's triangles.
fn corners(mesh: &TriMesh, face: &str) -> Vec<DVec3> {
    let own = label(mesh, face);
    (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == own).flat_map(|t| mesh.corners(t)).collect()
}

/// The name of the face all nodes of which fit.
fn named(mesh: &TriMesh, fits: impl Fn(DVec3) -> bool) -> String {
    mesh.faces.iter().find(|f| corners(mesh, f).into_iter().all(&fits)).unwrap().clone()
}

fn area(mesh: &TriMesh, face: &str) -> f64 {
    let own = label(mesh, face);
    let of = (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == own);
    of.map(|t| 0.5 * mesh.area_vector(t).length()).sum()
}

fn of_step(name: &str, size: f64) -> Meshed {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name);
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), measure: true, ..MeshOptions::default() };
    mesh_step(load_step(&path, &Run::new()).unwrap(), &options, &Run::new()).unwrap()
}

#[test]
fn the_side_of_a_step_cylinder_stays_on_its_cylinder() {
    // Radius 2 and height 3 inches.
    let (radius, height, size) = (50.8, 76.2, 10.0);
    let before = of_step("cylinder_without_seam.step", size);
    let side = named(&before.mesh, |p| (p.truncate().length() - radius).abs() < 1e-9);
    for share in [0.5, 0.25, 2.0] {
        let after = remeshed(&before, &side, share * size);
        only_of_any(&before, &after, &side);
        let off = corners(&after.mesh, &side).into_iter().map(|p| (p.truncate().length() - radius).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off <= 1e-12 * radius, "{share}: {off}");
        let (lengths, chord) = (inner_edges(&after.mesh, &side), chord(share * size, radius));
        // Longer edges than those of the border have no room to grow.
        assert!(
            share > 1.0 || abs_diff_eq!(median(&lengths), chord, epsilon = 0.12 * chord),
            "{share}: {}",
            median(&lengths)
        );
        assert!(share < 1.0 || median(&lengths) > 1.1 * median(&inner_edges(&before.mesh, &side)));
        assert!(smallest_angle(&after.mesh, &side) > if share < 0.3 { 15.0 } else { 25.0 }, "{share}");
        // Chords along a circle make it shorter by a share of h^2 / 24 r^2, and they are no longer than the longer of both sizes.
        let (most, longest) = (2.0 * PI * radius * height, chord.max(self::chord(size, radius)));
        let left = 1.0 - area(&after.mesh, &side) / most;
        assert!(left > 0.0 && left < (longest / radius).powi(2) / 20.0, "{share}: {left}");
        let [was, now] = [&before, &after].map(|m| m.report.distance.unwrap());
        assert!(share > 1.0 || now.to_surface <= was.to_surface, "{was} {now}");
        // The middle of a chord of a circle is so far off.
        assert!(now.to_surface < 2.0 * longest * longest / (8.0 * radius), "{now}");
    }
}

#[test]
fn apexes_and_closed_faces_of_step_models_are_meshed_anew() {
    for (name, size) in [("cone_with_apex.step", 0.1), ("sphere.step", 0.1), ("torus.step", 0.1)] {
        let whole = of_step(name, 1.0).mesh.bounds().diagonal();
        let before = of_step(name, size * whole);
        let round = before.mesh.faces.iter().max_by_key(|f| triangles(&before.mesh, f, true).len()).unwrap();
        let after = remeshed(&before, round, 0.4 * size * whole);
        only_of_any(&before, &after, round);
        let [was, now] = [&before, &after].map(|m| inner_edges(&m.mesh, round));
        assert!(median(&now) < 0.75 * median(&was), "{name}: {} {}", median(&was), median(&now));
        let [was, now] = [&before, &after].map(|m| m.report.distance.unwrap().to_surface);
        assert!(now < was, "{name}: {was} {now}");
    }
}

#[test]
fn faces_of_a_built_solid_follow_their_sizes() {
    let options = MeshOptions { volume: Some(0.02), measure: true, ..MeshOptions::default() };
    let before = made(&format!("part({RING})\ngroup(\"all\", faces(\"ring*\"))\n"), options);
    let outer = named(&before.mesh, |p| (p.truncate().length() - 2.0).abs() < 1e-9);
    let top = named(&before.mesh, |p| (p.z - 1.0).abs() < 1e-12);
    let after = remeshed(&before, &outer, 0.5 * SIZE);
    only_of_any(&before, &after, &outer);
    let off = corners(&after.mesh, &outer).into_iter().map(|p| (p.truncate().length() - 2.0).abs());
    assert!(off.fold(0.0, f64::max) < 1e-12);
    let want = chord(0.5 * SIZE, 2.0);
    assert_abs_diff_eq!(median(&inner_edges(&after.mesh, &outer)), want, epsilon = 0.12 * want);
    let [was, now] = [&before, &after].map(|m| m.report.volume.unwrap().between);
    assert!(now < 0.9 * was, "{was} {now}");
    // One after the other, and the flat one keeps its area to rounding, as its border stays.
    let both = remeshed(&after, &top, 0.5 * SIZE);
    only_of_any(&after, &both, &top);
    assert!(corners(&both.mesh, &top).into_iter().all(|p| p.z == 1.0));
    assert_abs_diff_eq!(area(&both.mesh, &top), area(&before.mesh, &top), epsilon = 1e-12);
    assert_abs_diff_eq!(median(&inner_edges(&both.mesh, &top)), 0.5 * SIZE, epsilon = 0.06 * SIZE);
}

#[test]
fn faces_of_an_stl_file_follow_their_sizes_on_its_triangles() {
    let fine = MeshOptions { size: Some(SizeRequest::Length(0.25 * SIZE)), ..MeshOptions::default() };
    let part = mesh_part(&parse(PART, &[]).unwrap(), &fine, &Run::new()).unwrap();
    let dir = tempfile::TempDir::new().unwrap();
    let path = dir.path().join("part.stl");
    rvachev::io::write(&path, &part.mesh, &Default::default(), &Run::new()).unwrap();
    let soup = load_mesh(&path, &Run::new()).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Length(SIZE)), measure: true, ..MeshOptions::default() };
    let before = mesh_soup(&soup, &options, &SoupOptions::default(), &Run::new()).unwrap();
    // Single precision.
    let near = 1e-6;
    let bore = named(&before.mesh, |p| p.truncate().length() < RADIUS + near);
    let flat = named(&before.mesh, |p| (p.x - 1.0).abs() < near);
    for size in [0.5 * SIZE, 0.25 * SIZE] {
        let after = remeshed(&before, &bore, size);
        only(&before, &after, &bore);
        // Between the true cylinder and the chords of the file's triangles, which are at most so far inside.
        let inside = chord(0.25 * SIZE, RADIUS).powi(2) / (8.0 * RADIUS) * 2.0;
        let radii = corners(&after.mesh, &bore).into_iter().map(|p| p.truncate().length());
        assert!(radii.into_iter().all(|r| r < RADIUS + near && r > RADIUS - inside), "{size}");
        let want = chord(size, RADIUS);
        let lengths = inner_edges(&after.mesh, &bore);
        assert_abs_diff_eq!(median(&lengths), want, epsilon = 0.2 * want);
        assert!(smallest_angle(&after.mesh, &bore) > 15.0);
    }
    let after = remeshed(&before, &flat, 0.5 * SIZE);
    only(&before, &after, &flat);
    assert_abs_diff_eq!(area(&after.mesh, &flat), 4.0, epsilon = 1e-5);
    assert_abs_diff_eq!(median(&inner_edges(&after.mesh, &flat)), 0.5 * SIZE, epsilon = 0.06 * SIZE);
}

#[test]
fn a_crease_that_ends_within_a_face_of_triangles_stays_a_crease() {
    // A sheet folded along y = 0, the more the farther x is: it bends by 40 degrees at x = 0.18.
    let (n, fold, size) = (40, 2.0, 0.5 * SIZE);
    let at = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| 2.0 * k as f64 / n as f64 - 1.0);
        DVec3::new(x, y, -fold * x.max(0.0) * y.abs())
    };
    let nodes = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let cell = |k: usize| {
        let a = (k / n * (n + 1) + k % n) as u32;
        let b = a + n as u32 + 1;
        [[a, a + 1, b + 1], [a, b + 1, b]]
    };
    let soup = TriMesh::new(nodes, (0..n * n).flat_map(cell).collect());
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let before = mesh_soup(&soup, &options, &SoupOptions::default(), &Run::new()).unwrap();
    assert_eq!(before.mesh.faces.len(), 1);
    let after = remeshed(&before, &before.mesh.faces[0].clone(), 0.4 * size);
    let told = after.report.check.as_ref().unwrap();
    assert!(told.certificate.is_sound() && told.self_intersections == 0, "{:?}", told.certificate);
    let on = |m: &Meshed| m.mesh.nodes.iter().filter(|p| p.y.abs() < 1e-12 && p.x > 0.5 && p.z.abs() < 1e-12).count();
    assert!(on(&before) > 2 && on(&after) as f64 > 1.5 * on(&before) as f64, "{} {}", on(&before), on(&after));
    for t in 0..after.mesh.triangles.len() {
        let c = after.mesh.corners(t);
        let across = c.iter().any(|p| p.y > 1e-9) && c.iter().any(|p| p.y < -1e-9);
        assert!(!across || after.mesh.centroid(t).x < 0.5, "{:?}", c);
    }
    let open = |m: &Meshed| m.mesh.defects().open_edges.len();
    assert_eq!(open(&before), open(&after));
}

#[test]
fn the_command_meshes_faces_anew_that_are_named() {
    let dir = tempfile::TempDir::new().unwrap();
    std::fs::write(dir.path().join("part.py"), PART).unwrap();
    let run = |words: &[&str]| {
        let all = [&["mesh", "part.py", "-o", "out.off", "-q", "--size", "0.2"], words].concat();
        Command::new(env!("CARGO_BIN_EXE_rvachev")).current_dir(&dir).args(all).output().unwrap()
    };
    let out = run(&["--remesh", "cube.xmax=0.1", "--remesh", "bore=0.05"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let written = load_mesh(&dir.path().join("out.off"), &Run::new()).unwrap();
    let twice = remeshed(&remeshed(&made(PART, MeshOptions::default()), "cube.xmax", 0.1), "bore", 0.05);
    assert_eq!(written.triangles.len(), twice.mesh.triangles.len());
    assert_abs_diff_eq!(written.volume(), twice.mesh.volume(), epsilon = 1e-9);
    for (words, what) in [
        (&["--remesh", "bohr=0.1"][..], "the nearest name is \"bore\""),
        (&["--remesh", "bore=1e-9"], "area"),
        (&["--remesh", "bore"], "NAME=SIZE"),
        (&["--remesh", "bore=0.1", "--method", "mc"], "--remesh is for solids of functions by leaf"),
    ] {
        let out = run(words);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && said.contains(what), "{words:?} {said}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let before = made(PART, MeshOptions::default());
    let [one, three] = [1, 3].map(|n| {
        let mut made = before.clone();
        made.remesh_face("bore", 0.07, &Run::new().with_threads(n).unwrap()).unwrap();
        made
    });
    assert_eq!((one.mesh, one.seams, one.corners), (three.mesh, three.seams, three.corners));
}

#[test]
fn what_cannot_be_done_is_said_and_changes_nothing() {
    let before = made(PART, MeshOptions::default());
    let refused = |of: &Meshed, name: &str, size: f64| {
        let mut made = of.clone();
        let error = made.remesh_face(name, size, &Run::new()).unwrap_err();
        assert_eq!((&made.mesh, made.report.stages.len()), (&of.mesh, of.report.stages.len()));
        (error.exit_code(), error.to_string())
    };
    let (code, text) = refused(&before, "bohr", SIZE);
    assert_eq!(code, 2);
    assert!(before.mesh.faces.iter().all(|f| text.contains(f.as_str())), "{text}");
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        let (code, text) = refused(&before, "bore", size);
        assert!(code == 2 && text.contains("bore"), "{text}");
    }
    let cubes = made(PART, MeshOptions { method: Method::MarchingCubes, ..MeshOptions::default() });
    let (code, text) = refused(&cubes, "cube.xmax", SIZE);
    assert!(code == 3 && text.contains("mc"), "{text}");
    assert!(refused(&before, "bohr", SIZE).1.contains("the nearest name is \"bore\""));
    let both = format!("part([{}, sphere(1, at=(9, 0, 0))])\n", RING);
    for (text, what) in [("part(region(circle(1)))\n", "plane figure"), (&both[..], "functions and of solids")] {
        let mesh = made(text, MeshOptions::default());
        let (code, text) = refused(&mesh, &mesh.mesh.faces[0].clone(), 0.1);
        assert!(code == 2 && text.contains(what), "{text}");
    }
    let run = Run::new();
    run.cancel_token().cancel();
    assert!(before.clone().remesh_face("bore", 0.1, &run).is_err());
}
