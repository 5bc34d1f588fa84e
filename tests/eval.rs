//! The part's function: at points of a table and on a grid, against closed forms, and read back by VTK and NumPy.

mod common;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use approx::{abs_diff_eq, assert_abs_diff_eq};
use assert_cmd::Command;
use predicates::str::contains;
use rvachev::SizeRequest;
use rvachev::implicit::part::Part;
use rvachev::implicit::{Field, Implicit, RSystem, Sampling, Solid, Walls, evaluate};
use rvachev::pipeline::{MeshOptions, mesh_part};
use rvachev::run::CancelToken;
use rvachev::spatial::Aabb;
use rvachev::{DVec3, Error, Run};
use serde_json::Value;
use tempfile::TempDir;

/// Inside where x and y are positive, far from all else.
const CORNER: &str = "units(\"mm\")\npart(half_space((-1, 0, 0), (0, 0, 0)).name(\"left\") & half_space((0, -1, 0), (0, 0, 0)).name(\"front\"), \
                      domain=((-1e6, -1e6, -1e6), (1e6, 1e6, 1e6)))\n";

fn rvachev() -> Command {
    Command::cargo_bin("rvachev").unwrap()
}

fn data(name: &str) -> String {
    format!("{}/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

struct Row {
    point: DVec3,
    value: f64,
    gradient: DVec3,
    inside: bool,
    face: String,
    leaf: Option<u32>,
}

fn rows(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("x,y,z,value,gx,gy,gz,inside,face,leaf"));
    let row = |line: &str| {
        let (line, leaf) = line.rsplit_once(',').unwrap();
        let f: Vec<&str> = line.splitn(9, ',').collect();
        let n: Vec<f64> = f[..7].iter().map(|w| w.parse().unwrap()).collect();
        Row {
            point: DVec3::from_slice(&n[..3]),
            value: n[3],
            gradient: DVec3::from_slice(&n[4..]),
            inside: f[7] == "1",
            face: f[8].to_string(),
            leaf: leaf.parse().ok(),
        }
    };
    lines.map(row).collect()
}

/// Evaluates a part given as text at points given as text.
fn eval(dir: &Path, source: &str, points: &str, more: &[&str]) -> Vec<Row> {
    fs::write(dir.join("part.py"), source).unwrap();
    let mut command = rvachev();
    command.current_dir(dir).args(["eval", "part.py", "--points", "-"]).args(more).write_stdin(points);
    let out = command.assert().success().get_output().stdout.clone();
    rows(&String::from_utf8(out).unwrap())
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + b.abs())
}

/// Points spread over a box, the same every time.
fn scattered(count: usize, half: f64) -> Vec<DVec3> {
    let mut state = 7u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * (2.0 * half)).collect()
}

fn table(points: &[DVec3]) -> String {
    points.iter().map(|p| format!("{},{},{}\n", p.x, p.y, p.z)).collect()
}

#[test]
fn a_sphere_is_its_closed_form_and_numbers_round_trip() {
    let dir = TempDir::new().unwrap();
    let points = scattered(500, 3.0);
    let found = eval(dir.path(), "part(sphere(2, (0.5, 0, 0)).name(\"ball\"))", &table(&points), &[]);
    assert_eq!(found.len(), points.len());
    let center = DVec3::new(0.5, 0.0, 0.0);
    for (r, p) in found.iter().zip(&points) {
        assert_eq!(r.point, *p);
        // (r^2 - d^2) / 2r, normalized on the sphere.
        assert!(near(r.value, (4.0 - (*p - center).length_squared()) / 4.0), "{p}: {}", r.value);
        assert!((r.gradient + (*p - center) / 2.0).length() < 1e-14, "{p}: {}", r.gradient);
        assert_eq!(r.inside, (*p - center).length() < 2.0);
        assert_eq!(r.face, "ball");
    }
    assert!(found.iter().any(|r| r.inside) && found.iter().any(|r| !r.inside));
}

#[test]
fn a_corner_is_what_each_system_says_it_is() {
    let dir = TempDir::new().unwrap();
    let r_alpha = |alpha: f64, a: f64, b: f64| (a + b - (a * a + b * b - 2.0 * alpha * a * b).sqrt()) / (1.0 + alpha);
    // The walls of the domain lie so far away that they change no value by more than about a millionth.
    for (system, truth) in [
        ("R0", 0.7 - 0.5),
        ("minmax", 0.3),
        ("Ralpha:0.5", r_alpha(0.5, 0.3, 0.4)),
        ("Ralpha:-0.5", r_alpha(-0.5, 0.3, 0.4)),
        ("Ralpha:1", 0.3),
    ] {
        let r = &eval(dir.path(), CORNER, "0.3 0.4 0\n", &["--rsystem", system])[0];
        assert!(abs_diff_eq!(r.value, truth, epsilon = 1e-5), "{system}: {} is not {truth}", r.value);
        assert_eq!((r.inside, r.face.as_str()), (true, "left"), "{system}");
    }
    // The two outside: R0 is the negative length of the smaller part of the sum.
    let found = eval(dir.path(), CORNER, "-0.3 -0.4 0\n-0.3 0.4 0\n0.4 -0.3 0\n", &[]);
    assert_abs_diff_eq!(found[0].value, -0.7 - 0.5, epsilon = 1e-5);
    assert_eq!(found[0].face, "front");
    assert_abs_diff_eq!(found[1].value, 0.1 - 0.5, epsilon = 1e-5);
    assert_eq!(found[1].face, "left");
    assert_abs_diff_eq!(found[2].value, 0.1 - 0.5, epsilon = 1e-5);
    assert_eq!(found[2].face, "front");
    assert!(found.iter().all(|r| !r.inside));
    // The gradient of a + b - sqrt(a^2 + b^2).
    let g = eval(dir.path(), CORNER, "0.3,0.4,0\n", &[])[0].gradient;
    assert!((g - DVec3::new(0.4, 0.2, 0.0)).length() < 1e-5, "{g}");
    // A part says its own system.
    let own = CORNER.replace("domain=", "rsystem=\"minmax\", domain=");
    assert!(near(eval(dir.path(), &own, "0.3,0.4,0\n", &[])[0].value, 0.3));
}

#[test]
fn gradients_are_differences_and_insides_are_signs() {
    let dir = TempDir::new().unwrap();
    let source = fs::read_to_string(data("cube_with_holes.py")).unwrap();
    const H: f64 = 1e-6;
    let centers = scattered(200, 1.5);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let points: Vec<DVec3> = centers
        .iter()
        .flat_map(|p| [*p].into_iter().chain(axes.iter().flat_map(move |e| [*p + *e * H, *p - *e * H])))
        .collect();
    for system in ["R0", "Ralpha:-0.5", "R0m:2"] {
        let found = eval(dir.path(), &source, &table(&points), &["--rsystem", system]);
        for r in found.chunks(7) {
            let slope = DVec3::new(
                (r[1].value - r[2].value) / (2.0 * H),
                (r[3].value - r[4].value) / (2.0 * H),
                (r[5].value - r[6].value) / (2.0 * H),
            );
            let off = (slope - r[0].gradient).length();
            assert!(off < 1e-5 * (1.0 + slope.length()), "{system} {}: {slope} {}", r[0].point, r[0].gradient);
        }
        assert!(found.iter().all(|r| r.inside == (r.value > 0.0)), "{system}");
        assert!(found.iter().filter(|r| r.inside).count() > 100, "{system}");
    }
}

/// How often a field was asked, and for how much.
#[derive(Default)]
struct Asked {
    calls: AtomicUsize,
    values: AtomicUsize,
}

/// A field that counts what it is asked.
struct Counted {
    asked: Arc<Asked>,
    at: fn(DVec3) -> f64,
    steep: Option<f64>,
}

impl Field for Counted {
    fn value(&self, p: DVec3) -> f64 {
        let mut out = [0.0];
        self.values(&[p], &mut out);
        out[0]
    }

    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        self.asked.calls.fetch_add(1, Ordering::Relaxed);
        self.asked.values.fetch_add(points.len(), Ordering::Relaxed);
        out.iter_mut().zip(points).for_each(|(v, p)| *v = (self.at)(*p));
    }

    fn lipschitz(&self) -> Option<f64> {
        self.steep
    }
}

/// Inside a ball of radius 1.
fn ball(p: DVec3) -> f64 {
    1.0 - p.length()
}

/// Calls, points, and triangles of a mesh of the ball, of which nothing is known but that it is in a box.
fn meshed(size: f64, threads: usize) -> (usize, usize, rvachev::mesh::TriMesh) {
    let asked = Arc::new(Asked::default());
    let field = Counted { asked: asked.clone(), at: ball, steep: None };
    let mut part = Part::from_solid(Solid::field(field).name("ball"));
    part.domain = Some(Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5)));
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new().with_threads(threads).unwrap()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    (asked.calls.load(Ordering::Relaxed), asked.values.load(Ordering::Relaxed), made.mesh)
}

#[test]
fn a_field_of_which_nothing_is_known_is_meshed_in_large_batches() {
    let (calls, points, mesh) = meshed(0.1, 1);
    assert!(points >= 512 * calls, "{calls} calls of {points} points");
    assert!(points <= 300 * mesh.triangles.len() + 1_000_000, "{points} points");
    // Whatever stood in for the field, nodes are on its own surface.
    let off = mesh.nodes.iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off}");
    let volume: f64 =
        mesh.triangles.iter().map(|t| t.map(|v| mesh.nodes[v as usize])).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    assert_abs_diff_eq!(volume, 4.0 / 3.0 * std::f64::consts::PI, epsilon = 0.02);
    assert_eq!(mesh, meshed(0.1, 3).2);
}

/// A cube of half side 1 with bores of radii 0.5 along z and 0.4 along x, as one function.
fn bored_cube(p: DVec3) -> f64 {
    let bores = (p.x.hypot(p.y) - 0.5).min(p.y.hypot(p.z) - 0.4);
    (1.0 - p.abs().max_element()).min(bores)
}

/// Calls and the mesh of the bored cube, with edges a tenth long.
fn bored(threads: usize) -> (usize, rvachev::mesh::TriMesh) {
    let asked = Arc::new(Asked::default());
    let field = Counted { asked: asked.clone(), at: bored_cube, steep: Some(1.0) };
    let mut part = Part::from_solid(Solid::field(field).name("bored"));
    part.domain = Some(Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5)));
    let options = MeshOptions { size: Some(SizeRequest::Length(0.1)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new().with_threads(threads).unwrap()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    (asked.calls.load(Ordering::Relaxed), made.mesh)
}

#[test]
fn creases_inside_a_field_are_found_in_large_batches() {
    let (calls, mesh) = bored(1);
    // One call for each point along the creases would be eight million.
    assert!(calls < 40_000, "{calls}");
    let node = |v: u32| mesh.nodes[v as usize];
    let mut beside: std::collections::HashMap<[u32; 2], Vec<DVec3>> = std::collections::HashMap::new();
    for t in &mesh.triangles {
        let [a, b, c] = t.map(node);
        for k in 0..3 {
            let (v, w) = (t[k], t[(k + 1) % 3]);
            beside.entry([v.min(w), v.max(w)]).or_default().push((b - a).cross(c - a).normalize());
        }
    }
    let sharp: Vec<[DVec3; 2]> = beside.iter().filter(|x| x.1[0].dot(x.1[1]) < 0.8).map(|x| x.0.map(node)).collect();
    let is_found = |p: DVec3| {
        sharp.iter().any(|[a, b]| {
            let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            // Chords of edges a tenth long are a few thousandths from circles of these radii.
            a.lerp(*b, t).distance(p) < 4e-3
        })
    };
    let mut truth: Vec<DVec3> = Vec::new();
    for i in 0..200 {
        let s = (f64::from(i) + 0.5) / 100.0 - 1.0;
        for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            truth.extend([DVec3::new(s, u, v), DVec3::new(u, s, v), DVec3::new(u, v, s)]);
        }
        let (sin, cos) = (std::f64::consts::PI * s).sin_cos();
        for side in [-1.0, 1.0] {
            truth.push(DVec3::new(0.5 * cos, 0.5 * sin, side));
            truth.push(DVec3::new(side, 0.4 * cos, 0.4 * sin));
            // Where the bores meet.
            truth.push(DVec3::new(side * (0.25 - 0.16 * cos * cos).sqrt(), 0.4 * cos, 0.4 * sin));
        }
    }
    let found = truth.iter().filter(|p| is_found(**p)).count();
    assert!(found as f64 >= 0.99 * truth.len() as f64, "{found} of {}", truth.len());
    for k in 0..8 {
        let corner = DVec3::from([0, 1, 2].map(|i| if k >> i & 1 == 0 { -1.0 } else { 1.0 }));
        let off = mesh.nodes.iter().map(|p| p.distance(corner)).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-5, "{corner}: {off}");
    }
    // All nodes are on the surface.
    assert!(mesh.nodes.iter().all(|p| bored_cube(*p).abs() < 1e-8));
    assert_eq!(mesh, bored(3).1);
}

/// The ball where it may be asked in a box only.
struct Walled(Counted, Walls);

impl Field for Walled {
    fn value(&self, p: DVec3) -> f64 {
        let mut out = [0.0];
        self.values(&[p], &mut out);
        out[0]
    }

    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        self.1.values(points, out, |points, out| {
            assert!(points.iter().all(|p| self.1.bounds().contains(*p)));
            self.0.values(points, out);
        });
    }

    fn walls(&self) -> Option<Walls> {
        Some(self.1)
    }
}

#[test]
fn walls_that_cut_a_field_off_are_exact_and_it_is_never_asked_beyond() {
    let asked = Arc::new(Asked::default());
    let bounds = Aabb::new(DVec3::new(-1.5, -1.5, -0.3), DVec3::splat(1.5));
    let field = Solid::field(Walled(Counted { asked: asked.clone(), at: ball, steep: None }, Walls::new(bounds)));
    let part = Part::from_solid(field & Solid::cuboid(bounds.lo, bounds.hi));
    let options = MeshOptions { size: Some(SizeRequest::Length(0.1)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let (calls, points) = (asked.calls.load(Ordering::Relaxed), asked.values.load(Ordering::Relaxed));
    assert!(points >= 512 * calls, "{calls} calls of {points} points");
    let mut on_edge = 0;
    for p in &made.mesh.nodes {
        let (on_ball, on_wall) = ((p.length() - 1.0).abs() < 1e-12, p.z == -0.3);
        assert!(on_ball || on_wall && p.length() < 1.0, "{p}");
        on_edge += usize::from(on_ball && on_wall);
    }
    // The circle is 5.99 long.
    assert!((40..100).contains(&on_edge), "{on_edge}");
}

#[test]
fn fields_are_asked_for_many_values_at_once() {
    let asked = Arc::new(Asked::default());
    let solid = Solid::field(Counted { asked: asked.clone(), at: ball, steep: None }) & Solid::field(|p: DVec3| p.z);
    let domain = Aabb::new(DVec3::splat(-5.0), DVec3::splat(5.0));
    let model = Implicit::new(&solid, RSystem::MinMax, Some(domain)).unwrap();
    let (calls, values) = (asked.calls.load(Ordering::Relaxed), asked.values.load(Ordering::Relaxed));
    let points = scattered(10_000, 2.0);
    let found = evaluate(&model, &points, Sampling { gradients: true, faces: true }, &Run::new()).unwrap();
    // Gradients are differences of seven values, asked for where the ball decides.
    let decided = points.iter().filter(|p| 1.0 - p.length() < p.z).count();
    assert_eq!(asked.values.load(Ordering::Relaxed) - values, points.len() + 7 * decided);
    assert!(asked.calls.load(Ordering::Relaxed) - calls <= points.len() / 100);
    for (i, p) in points.iter().enumerate() {
        assert_eq!(found.values[i], (1.0 - p.length()).min(p.z));
        let gradient = if p.z < 1.0 - p.length() { DVec3::Z } else { -p.normalize() };
        assert!((found.gradients[i] - gradient).length() < 1e-7, "{p}: {}", found.gradients[i]);
        assert_eq!(found.inside[i], p.length() < 1.0 && p.z > 0.0);
    }
    // What is not asked for is not there, and a run that was cancelled gives nothing.
    let few = evaluate(&model, &points[..3], Sampling::default(), &Run::new()).unwrap();
    assert_eq!((few.values[..].len(), few.gradients.len(), few.faces.len()), (3, 0, 0));
    let token = CancelToken::new();
    token.cancel();
    assert!(matches!(
        evaluate(&model, &points, Sampling::default(), &Run::new().with_cancel(token)),
        Err(Error::Cancelled)
    ));
}

/// The distance to a box between two corners, positive inside, and the way there.
fn to_box(p: DVec3, lo: DVec3, hi: DVec3) -> f64 {
    let beyond = (lo - p).max(p - hi);
    let outside = beyond.max(DVec3::ZERO).length();
    if outside > 0.0 { -outside } else { -beyond.max_element() }
}

/// Runs `eval` on a file as it is.
fn eval_file(dir: &Path, file: &str, points: &[DVec3]) -> Vec<Row> {
    let mut command = rvachev();
    command.current_dir(dir).args(["eval", file, "--points", "-"]).write_stdin(table(points));
    rows(&String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap())
}

#[test]
fn the_function_of_a_boundary_is_the_distance_to_it() {
    let dir = TempDir::new().unwrap();
    let (lo, hi) = (DVec3::new(-1.0, -0.5, 0.0), DVec3::new(1.0, 1.5, 0.75));
    let text = "part(box(lo=(-1, -0.5, 0), hi=(1, 1.5, 0.75)).name('b'))\n";
    fs::write(dir.path().join("box.py"), text).unwrap();
    rvachev().current_dir(&dir).args(["mesh", "box.py", "-o", "box.ply", "--size", "0.3"]).assert().success();
    let points = scattered(2000, 2.5);
    let of_mesh = eval_file(dir.path(), "box.ply", &points);
    for row in &of_mesh {
        let truth = to_box(row.point, lo, hi);
        assert!(near(row.value, truth) && row.inside == (truth > 0.0), "{}: {} not {truth}", row.point, row.value);
        assert!(near(row.gradient.length(), 1.0), "{}: {}", row.point, row.gradient);
    }
    let faces: std::collections::BTreeSet<&str> = of_mesh.iter().map(|r| &r.face[..]).collect();
    assert_eq!(faces.into_iter().collect::<Vec<_>>(), ["b.xmax", "b.xmin", "b.ymax", "b.ymin", "b.zmax", "b.zmin"]);

    // Faces of CAD models are asked themselves: a ball of radius 2, given by its equation.
    for row in eval_file(dir.path(), &data("step/sphere.step"), &points) {
        let r = row.point.length();
        if (0.5..1.5).contains(&(r / 2.0)) {
            assert!(near(row.value, 2.0 - r) && row.inside == (r < 2.0), "{}: {}", row.point, row.value);
            assert!((row.gradient + row.point / r).length() < 1e-9, "{}: {}", row.point, row.gradient);
        }
        assert!((row.value - (2.0 - r)).abs() < 0.02, "{}: {}", row.point, row.value);
    }
    // A cylinder has edges: beyond them the distance is to a circle. The file is in inches.
    let (radius, height) = (50.8, 76.2);
    for row in eval_file(dir.path(), &data("step/cylinder_without_seam.step"), &scattered(2000, 120.0)) {
        let (r, z) = (row.point.truncate().length() - radius, (row.point.z - height / 2.0).abs() - height / 2.0);
        let truth = if r > 0.0 || z > 0.0 { -r.max(0.0).hypot(z.max(0.0)) } else { -r.max(z) };
        // Near the axis all of the side is as far.
        let exact = r > 0.0 || z > 0.0 || truth < 30.0;
        let off = (row.value - truth).abs();
        assert!(off < if exact { 1e-9 * radius } else { 0.5 }, "{}: {} not {truth}", row.point, row.value);
        assert_eq!(row.inside, truth > 0.0, "{}", row.point);
    }
}

#[test]
fn boundaries_are_leaves_beside_r_functions() {
    let dir = TempDir::new().unwrap();
    let text =
        format!("part(step({:?}).name('ball') - cylinder(0.5, axis='z').name('bore'))\n", data("step/sphere.step"));
    let points = scattered(500, 3.0);
    let found = eval(dir.path(), &text, &table(&points), &["--rsystem", "minmax"]);
    let mut leaves = std::collections::BTreeMap::new();
    for row in &found {
        let (r, across) = (row.point.length(), row.point.truncate().length());
        // A cylinder's function is (r^2 - d^2) / 2r, and negative as a bore.
        let (ball, bore) = (2.0 - r, across * across - 0.25);
        let truth = ball.min(bore);
        if (1.0..3.0).contains(&r) {
            assert!(near(row.value, truth), "{}: {} not {truth}", row.point, row.value);
            assert_eq!(row.face, if ball < bore { "ball.all" } else { "bore" }, "{}", row.point);
            assert_eq!(*leaves.entry(row.face.clone()).or_insert(row.leaf), row.leaf);
        }
    }
    assert_eq!(leaves.len(), 2);
    assert!(leaves.values().all(Option::is_some), "{leaves:?}");
    // The same numbers stand behind the faces in `info`.
    let out =
        rvachev().current_dir(&dir).args(["info", "part.py", "--json"]).assert().success().get_output().stdout.clone();
    let told: Value = serde_json::from_slice(&out).unwrap();
    for (face, leaf) in leaves {
        let of = told["faces"].as_array().unwrap().iter().find(|f| f["name"] == face.as_str()).unwrap();
        assert_eq!(of["leaves"], serde_json::json!([leaf.unwrap()]), "{face}");
    }
    // What is open has no inside.
    fs::write(dir.path().join("open.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    let mut command = rvachev();
    command.current_dir(&dir).args(["eval", "open.off", "--points", "-"]).write_stdin("0 0 0\n");
    command.assert().code(3).stderr(contains("open edges"));
}

#[test]
fn bad_tables_end_with_3_and_name_the_line() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), "part(sphere(1))").unwrap();
    for (text, line) in [
        ("0,0,0\n1,2\n", "bad.csv: line 2: the row has 2 fields, not 3"),
        ("x,y,z\n0,0,0\n0,zero,0\n", "bad.csv: line 3: y is `zero`"),
        ("0,0,0\n\n0,0,nan\n", "bad.csv: line 3: z is NaN"),
        ("0 0 0\ninf 0 0\n", "bad.csv: line 2: x is inf"),
        ("a,b,c\n", "bad.csv: line 1: x is `a`"),
        ("", "bad.csv: there are no points"),
        ("x,y,z\n\n", "bad.csv: there are no points"),
    ] {
        fs::write(dir.path().join("bad.csv"), text).unwrap();
        let mut command = rvachev();
        command.current_dir(&dir).args(["eval", "part.py", "--points", "bad.csv", "-o", "out.csv"]);
        command.assert().code(3).stderr(contains(line));
        assert!(!dir.path().join("out.csv").exists(), "{text:?}");
    }
    let run = |arguments: &[&str]| rvachev().current_dir(&dir).args(arguments).write_stdin("0,0,0\n").assert();
    run(&["eval", "part.py", "--points", "none.csv"]).code(3).stderr(contains("none.csv"));
    run(&["eval", "none.py", "--points", "-"]).code(3).stderr(contains("none.py"));
    run(&["eval", "part.py", "--points", "-", "--rsystem", "R7"]).code(2).stderr(contains("Ralpha:A"));
    run(&["eval", "part.py", "--points", "-", "-o", "none/out.csv"]).code(2);
    fs::write(dir.path().join("edges.py"), "part(extrude_edges([circle(1)], \"z\", 4))").unwrap();
    run(&["eval", "edges.py", "--points", "-"]).success();
    fs::write(dir.path().join("sheet.py"), "part(extrude_edges([circle(1)], \"z\", 4, solid=False))").unwrap();
    run(&["eval", "sheet.py", "--points", "-"]).code(3).stderr(contains("it is open"));
}

#[test]
fn what_is_not_a_number_falls_short() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), "part(solid(log(x) + 3) & box(lo=(0.5, 0, 0), hi=(1, 1, 1)))").unwrap();
    let run =
        |arguments: &[&str]| rvachev().current_dir(&dir).args(arguments).write_stdin("0.7,0.5,0.5\n-1,0,0\n").assert();
    let out =
        run(&["eval", "part.py", "--points", "-"]).code(1).stderr(contains("at 1 points")).stderr(contains("line 2"));
    let text = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(text.lines().nth(2).unwrap().starts_with("-1.0,0.0,0.0,NaN,"), "{text}");
    run(&["grid", "part.py", "-o", "a.vti", "--cells", "4", "--margin", "2"]).code(1).stderr(contains("falls short"));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("points.csv"), table(&scattered(70_000, 1.3))).unwrap();
    let part = data("cube_with_holes.py");
    let mut texts = Vec::new();
    for threads in ["1", "4"] {
        let run = |arguments: &[&str]| {
            rvachev().current_dir(&dir).args(arguments).args(["--threads", threads]).assert().success();
        };
        run(&["eval", &part, "--points", "points.csv", "-o", "out.csv"]);
        run(&["grid", &part, "-o", "out.vti", "--cells", "40", "--gradient", "--faces"]);
        texts.push([fs::read(dir.path().join("out.csv")).unwrap(), fs::read(dir.path().join("out.vti")).unwrap()]);
    }
    assert_eq!(texts[0][0].iter().filter(|b| **b == b'\n').count(), 70_001);
    assert!(texts[0] == texts[1]);
}

/// What VTK and NumPy find in grids: the points' coordinates and all that stands at them, and whether both hold the same.
const READ: &str = r#"
import json, sys
import numpy as np, pyvista
grid = pyvista.read("out.vti")
alone = np.load("out.npy")
nx, ny, nz = grid.dimensions
same = alone.dtype == "<f8" and alone.shape == (nz, ny, nx) and np.array_equal(alone.ravel(), grid["value"])
# Numbers as whole ones with the same bits: reading a decimal may round.
bits = lambda name: np.ascontiguousarray(grid[name]).view(np.int64).tolist()
print(json.dumps({
    "dimensions": grid.dimensions, "bounds": list(grid.bounds), "same": bool(same),
    "points": np.asarray(grid.points).tolist(), "value": bits("value"), "gradient": bits("gradient"), "face": grid["face"].tolist(),
    "names": [str(n) for n in grid.field_data["face_names"]],
}))
"#;

#[test]
fn vtk_reads_at_each_node_what_eval_says_there() {
    let requirements = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/tests/requirements.txt");
    let python = common::environment("python-env", &requirements).unwrap_or_else(|why| panic!("no VTK: {why}"));
    let dir = TempDir::new().unwrap();
    let source = "part(box(lo=(0, 0, 0), hi=(3, 2, 1)).name(\"a, b\") - sphere(0.7, (3, 2, 1)).name(\"bite\"))";
    fs::write(dir.path().join("part.py"), source).unwrap();
    let grid = |more: &[&str]| {
        let mut command = rvachev();
        command.current_dir(&dir).args(["grid", "part.py", "--step", "0.25", "--margin", "0.5"]).args(more);
        command.assert().success().stdout(contains("17 x 13 x 9 points"));
    };
    grid(&["-o", "out.vti", "--gradient", "--faces"]);
    grid(&["-o", "out.npy"]);
    fs::write(dir.path().join("read.py"), READ).unwrap();
    let said = common::done(std::process::Command::new(&python).current_dir(&dir).arg("read.py"));
    let said = String::from_utf8(said.unwrap_or_else(|why| panic!("{why}")).stdout).unwrap();
    let found: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    assert_eq!(found["dimensions"], serde_json::json!([17, 13, 9]));
    assert_eq!(found["bounds"], serde_json::json!([-0.5, 3.5, -0.5, 2.5, -0.5, 1.5]));
    assert_eq!(found["same"], true);
    let list = |v: &Value| v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>();
    let points: Vec<DVec3> = found["points"].as_array().unwrap().iter().map(|p| DVec3::from_slice(&list(p))).collect();
    assert_eq!(points.len(), 17 * 13 * 9);
    let rows = eval(dir.path(), source, &table(&points), &[]);
    let bits = |v: &Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|x| f64::from_bits(x.as_i64().unwrap() as u64)).collect()
    };
    let (values, faces) = (bits(&found["value"]), list(&found["face"]));
    for (i, r) in rows.iter().enumerate() {
        assert_eq!(r.value.to_bits(), values[i].to_bits(), "{}", points[i]);
        assert_eq!(r.gradient, DVec3::from_slice(&bits(&found["gradient"][i])), "{}", points[i]);
        let name = found["names"][faces[i] as usize].as_str().unwrap();
        let told = r.face.trim_matches('"');
        assert_eq!(told, name, "{}", points[i]);
    }
    assert!(rows.iter().any(|r| r.face == "bite") && rows.iter().any(|r| r.face == "\"a, b.zmax\""));
    // A node in the middle of the slab: half way between its walls.
    let middle = rows.iter().position(|r| r.point == DVec3::new(1.5, 1.0, 0.5)).unwrap();
    assert!(rows[middle].inside && values[middle] > 0.0 && values[middle] < 0.5);
}

#[test]
fn grids_ask_for_memory_first() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), "part(sphere(1))").unwrap();
    let run = |more: &[&str]| rvachev().current_dir(&dir).args(["grid", "part.py"]).args(more).assert();
    run(&["-o", "a.vti", "--step", "1e-5"]).code(2).stderr(contains("GiB"));
    run(&["-o", "a.vti", "--step", "1e-300"]).code(2);
    run(&["-o", "a.vti", "--cells", "100", "--memory", "0.001"])
        .code(2)
        .stderr(contains("more than the 0.001 allowed"));
    run(&["-o", "a.vti", "--cells", "0"]).code(2);
    run(&["-o", "a.vti", "--cells", "4", "--step", "1"]).code(2);
    run(&["-o", "a.vtk"]).code(2).stderr(contains(".vti or .npy"));
    run(&["-o", "a.npy", "--gradient"]).code(2).stderr(contains("values alone"));
    run(&["-o", "none/a.vti"]).code(2);
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
    // The default margin keeps the boundary off the grid's own: a surface drawn from it is closed.
    run(&["-o", "a.npy", "--cells", "10"]).success();
    let bytes = fs::read(dir.path().join("a.npy")).unwrap();
    assert_eq!(bytes.len(), 128 + 8 * 11 * 11 * 11);
    let values: Vec<f64> = bytes[128..].chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    let border = |i: usize| [i % 11, i / 11 % 11, i / 121].iter().any(|k| *k == 0 || *k == 10);
    assert!((0..values.len()).filter(|i| border(*i)).all(|i| values[i] < 0.0));
    assert!(near(values[values.len() / 2], 0.5));
}

#[test]
fn systems_are_compared_and_meshes_do_not_depend_on_them() {
    let dir = TempDir::new().unwrap();
    let part = data("cube_with_holes.py");
    let run = |arguments: &[&str]| rvachev().current_dir(&dir).args(arguments).assert();
    run(&["compare", &part, "--rsystems", "--size", "5%", "--json", "c.json"]).success().stdout(contains("Ralpha:0.5"));
    let c: Value = serde_json::from_slice(&fs::read(dir.path().join("c.json")).unwrap()).unwrap();
    let row = |name: &str| c["rows"].as_array().unwrap().iter().find(|r| r["rsystem"] == name).unwrap().clone();
    let number = |v: &Value, path: &str| v.pointer(path).unwrap().as_f64().unwrap();
    // Planes and cylinders are normalized, and all systems but R0m keep that on faces.
    for name in ["minmax", "R0", "Ralpha:-0.5", "Ralpha:0.5"] {
        assert!(number(&row(name), "/boundary/p95") < 1e-9, "{name}");
    }
    assert!(number(&row("R0m:2"), "/boundary/p95") > 0.1);
    // Off the boundary min and max are nearer to a distance than R0, as its values sum up all faces.
    assert!(number(&row("minmax"), "/depths/1/value/mean") < number(&row("R0"), "/depths/1/value/mean"));
    assert_eq!(number(&row("minmax"), "/depths/1/differs"), 0.0);
    assert!(number(&row("R0"), "/depths/1/differs") > 0.1);
    for r in c["rows"].as_array().unwrap() {
        assert_eq!(r["moved_nodes"], 0, "{}", r["rsystem"]);
    }
    // The other methods read no values either: the same bytes.
    let source = fs::read_to_string(&part).unwrap();
    for method in ["leaf", "operators", "cut"] {
        let mut meshes = Vec::new();
        for system in ["\"minmax\"", "(\"R0m\", 2)"] {
            let at = source.rfind("part(").unwrap();
            let close = at + source[at..].find(")\n").unwrap_or(source[at..].rfind(')').unwrap());
            let text = format!("{}, rsystem={system}{}", &source[..close], &source[close..]);
            fs::write(dir.path().join("part.py"), text).unwrap();
            let out = run(&["mesh", "part.py", "-o", "a.off", "--size", "5%", "--method", method, "-q"]);
            assert!(matches!(out.get_output().status.code(), Some(0 | 1)));
            meshes.push(fs::read(dir.path().join("a.off")).unwrap());
        }
        assert!(meshes[0] == meshes[1], "{method}");
    }
    run(&["compare", &data("soups/bored_block.off"), "--rsystems"]).code(3);
}

/// A ring that is thinner than two of the edges it is meshed with.
fn ring(p: DVec3) -> f64 {
    0.3 - (p.x.hypot(p.y) - 1.0).hypot(p.z)
}

#[test]
fn what_bends_too_tightly_for_one_size_of_triangles_is_no_crease() {
    let field = Counted { asked: Arc::default(), at: ring, steep: Some(2.0) };
    let mut part = Part::from_solid(Solid::field(field).name("ring"));
    part.domain = Some(Aabb::new(DVec3::new(-2.0, -2.0, -1.0), DVec3::new(2.0, 2.0, 1.0)));
    let options = MeshOptions { size: Some(SizeRequest::Length(0.39)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert_eq!(made.report.check.unwrap().euler, 0);
    let off = made.mesh.nodes.iter().map(|p| ring(*p).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off}");
}
