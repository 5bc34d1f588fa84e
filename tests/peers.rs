//! Our meshes, judged by libigl and pymeshlab, and by volumes and areas known in closed form.
//!
//! The first use makes a virtual environment below `target/peers-env` from `tests/peers/requirements.txt`; that needs
//! Python 3.10 or newer with `venv`, and the package index. What the peers say is then compared with what
//! `rvachev check --json` says of the same file.

mod common;

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use common::{done, environment};
use serde_json::Value;

// ------------------------------------------------------------------------------------------------ the peers' Python

/// A Python with the peers in it, and a folder of libraries they need and the system lacks.
struct Peers {
    python: PathBuf,
    libraries: Option<PathBuf>,
}

/// Fails every test that needs the peers, saying why they are missing, once it is known.
fn peers() -> &'static Peers {
    static PEERS: OnceLock<Result<Peers, String>> = OnceLock::new();
    match PEERS.get_or_init(make_peers) {
        Ok(peers) => peers,
        Err(why) => panic!("the peer checks cannot run: {why}"),
    }
}

fn make_peers() -> Result<Peers, String> {
    let requirements = here("tests/peers/requirements.txt");
    let python = environment("peers-env", &requirements)?;
    let without = Peers { python: python.clone(), libraries: None };
    let Err(why) = done(&mut without.script()) else {
        return Ok(without);
    };
    if !why.contains("libGL.so.1") {
        return Err(why);
    }
    // No OpenGL here, and nothing we ask for calls it: an empty library of that name lets pymeshlab load.
    let libraries = python.parent().ok_or("Python lies in no folder")?.join("lib-gl");
    fs::create_dir_all(&libraries).map_err(|e| e.to_string())?;
    let with = Peers { python, libraries: Some(libraries.clone()) };
    done(
        Command::new("cc")
            .args(["-shared", "-Wl,-soname,libGL.so.1", "-x", "c", "/dev/null", "-o"])
            .arg(libraries.join("libGL.so.1")),
    )
    .and_then(|_| done(&mut with.script()))
    .map_err(|e| format!("pymeshlab needs OpenGL (Debian: apt install libgl1 libopengl0)\n{why}\n{e}"))?;
    Ok(with)
}

impl Peers {
    fn script(&self) -> Command {
        let mut command = Command::new(&self.python);
        command.arg(here("tests/peers/check.py")).env_remove("PYTHONPATH").env_remove("PYTHONHOME");
        if let Some(libraries) = &self.libraries {
            command.env("LD_LIBRARY_PATH", libraries);
        }
        command
    }

    /// The script's answer. Plugins of pymeshlab that do not load say so before it.
    fn ask(&self, arguments: &[&Path], option: Option<&str>) -> Value {
        let out = done(self.script().args(option).args(arguments)).unwrap_or_else(|e| panic!("{e}"));
        let text = String::from_utf8_lossy(&out.stdout);
        let last = text.lines().last().unwrap_or_default();
        serde_json::from_str(last).unwrap_or_else(|e| panic!("{e} in {text}"))
    }
}

// ------------------------------------------------------------------------------------------------------- our meshes

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A file of this test's own; `name` tells tests apart.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn rvachev() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rvachev"))
}

/// Runs the command to exit code 0 or 1. With 1 there is a result that falls short somewhere, which tests judge.
fn good_enough(command: &mut Command) -> Output {
    let out = command.output().unwrap();
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(matches!(out.status.code(), Some(0 | 1)), "{command:?}: {}: {said}", out.status);
    out
}

/// Meshes a part file by the command.
fn mesh_file(part: &Path, name: &str, size: &str) -> PathBuf {
    let mesh = scratch(&format!("{name}.off"));
    let _ = fs::remove_file(&mesh);
    good_enough(rvachev().arg("mesh").arg(part).arg("-o").arg(&mesh).args(["--size", size, "-q"]));
    mesh
}

fn mesh_text(text: &str, name: &str, size: &str) -> PathBuf {
    let part = scratch(&format!("{name}.py"));
    fs::write(&part, text).unwrap();
    mesh_file(&part, name, size)
}

/// What a solid is known to be.
struct Truth {
    euler: i64,
    volume: f64,
    /// Where there is a closed form.
    area: Option<f64>,
    /// How far volume and area of a mesh of the size asked for may be off, as a share.
    within: f64,
}

fn number(v: &Value, path: &str) -> f64 {
    v.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path} in {v}"))
}

/// Asserts that our report, both peers and the truth agree on a mesh.
fn agree(mesh: &Path, truth: &Truth) -> Value {
    let out = good_enough(rvachev().arg("check").arg(mesh).arg("--json"));
    let ours: Value = serde_json::from_slice(&out.stdout).unwrap();
    let theirs = peers().ask(&[mesh], None)[0].take();
    let same = |a: &str, b: &str, absolute: f64, relative: f64| {
        let (x, y) = (number(&ours, a), number(&theirs, b));
        let off = (x - y).abs();
        assert!(off <= absolute + relative * y.abs(), "{}: {a} is {x}, {b} is {y}", mesh.display());
    };

    for flag in ["closed", "manifold", "oriented"] {
        assert_eq!(ours[flag], true, "{}: {flag}", mesh.display());
    }
    for flag in ["/igl/edge_manifold", "/igl/vertex_manifold", "/pymeshlab/is_mesh_two_manifold"] {
        assert_eq!(theirs.pointer(flag), Some(&Value::Bool(true)), "{}: {flag}", mesh.display());
    }
    for none in [
        "/igl/boundary_edges",
        "/igl/intersecting_triangles",
        "/pymeshlab/boundary_edges",
        "/pymeshlab/number_holes",
        "/pymeshlab/non_two_manifold_edges",
        "/pymeshlab/non_two_manifold_vertices",
        "/pymeshlab/unreferenced_vertices",
    ] {
        assert_eq!(number(&theirs, none), 0.0, "{}: {none}", mesh.display());
    }
    assert_eq!(ours["self_intersections"], 0, "{}", mesh.display());
    assert_eq!(ours["euler"], truth.euler, "{}: Euler characteristic", mesh.display());
    same("/nodes", "/pymeshlab/nodes", 0.0, 0.0);
    same("/triangles", "/pymeshlab/triangles", 0.0, 0.0);
    same("/euler", "/igl/euler", 0.0, 0.0);
    same("/components", "/igl/components", 0.0, 0.0);
    same("/components", "/pymeshlab/connected_components_number", 0.0, 0.0);
    same("/genus", "/pymeshlab/genus", 0.0, 0.0);
    // Both in f64, in another order of summation.
    same("/volume", "/igl/volume", 0.0, 1e-10);
    same("/area", "/igl/area", 0.0, 1e-10);
    // pymeshlab sums areas in f32.
    same("/volume", "/pymeshlab/volume", 0.0, 1e-6);
    same("/area", "/pymeshlab/area", 0.0, 1e-5);
    same("/quality/mean_radius_ratio", "/pymeshlab/mean_radius_ratio", 0.0, 1e-5);
    // libigl takes angles from cosines: half the digits near 0 and 180 degrees.
    same("/quality/min_angle", "/igl/min_angle", 1e-4, 0.0);
    same("/quality/max_angle", "/igl/max_angle", 1e-4, 0.0);
    // Percentiles may be interpolated or not.
    same("/quality/p05_angle", "/igl/p05_angle", 0.1, 0.0);
    same("/quality/below_20", "/igl/below_20", 1e-3, 0.0);

    let near = |what: &str, truth: f64, within: f64| {
        let x = number(&ours, what);
        assert!(
            abs_diff_eq!(x, truth, epsilon = within * truth),
            "{}: {what} is {x}, in truth {truth}",
            mesh.display()
        );
    };
    near("/volume", truth.volume, truth.within);
    if let Some(area) = truth.area {
        near("/area", area, truth.within);
    }
    theirs
}

/// The volume of `inside` within the cube [-half, half]^3, by counting the middles of `n`^3 cells.
fn counted(half: f64, n: usize, inside: impl Fn([f64; 3]) -> bool) -> f64 {
    let h = 2.0 * half / n as f64;
    let at = |i: usize| -half + h * (i as f64 + 0.5);
    let mut count = 0u64;
    for i in 0..n {
        for j in 0..n {
            count += (0..n).filter(|&k| inside([at(i), at(j), at(k)])).count() as u64;
        }
    }
    count as f64 * h.powi(3)
}

// ------------------------------------------------------------------------------------------------------------ parts

/// A cube of side 2 with two crossing holes of radius r: the crossing is two equal cylinders', volume 16 r^3 / 3 and
/// area 8 r^2 on each.
fn cube_with_holes() -> Truth {
    let r: f64 = 0.4;
    Truth {
        euler: -4,
        volume: 8.0 - 2.0 * (2.0 * PI * r * r) + 16.0 * r.powi(3) / 3.0,
        area: Some(24.0 - 4.0 * PI * r * r + 2.0 * (2.0 * TAU * r - 8.0 * r * r)),
        within: 2e-3,
    }
}

#[test]
fn the_peers_know_good_from_bad() {
    let whole = scratch("whole.off");
    fs::write(&whole, "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n").unwrap();
    let open = scratch("open.off");
    fs::write(&open, "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n").unwrap();
    let crossed = scratch("crossed.off");
    let text = "OFF\n6 2 0\n-1 -1 0\n1 -1 0\n0 1 0\n0 0 -1\n0 0 1\n0 2 1\n3 0 1 2\n3 3 4 5\n";
    fs::write(&crossed, text).unwrap();
    let said = peers().ask(&[&whole, &open, &crossed], None);
    assert_eq!(said[0]["igl"]["euler"], 2);
    assert_abs_diff_eq!(number(&said[0], "/igl/volume"), 1.0 / 6.0, epsilon = 1e-15);
    assert_abs_diff_eq!(number(&said[0], "/pymeshlab/volume"), 1.0 / 6.0, epsilon = 1e-7);
    for (i, edges, crossings) in [(0, 0, 0), (1, 3, 0), (2, 6, 2)] {
        assert_eq!(said[i]["igl"]["boundary_edges"], edges, "{}", said[i]);
        assert_eq!(said[i]["pymeshlab"]["boundary_edges"], edges, "{}", said[i]);
        assert_eq!(said[i]["igl"]["intersecting_triangles"], crossings, "{}", said[i]);
    }
}

#[test]
fn cube_with_holes_agrees_with_peers_and_closed_forms() {
    agree(&mesh_file(&here("data/cube_with_holes.py"), "cube", "0.05"), &cube_with_holes());
}

#[test]
fn a_rotated_cube_is_no_worse() {
    agree(&mesh_file(&here("data/cube_with_holes_rotated.py"), "rotated", "0.05"), &cube_with_holes());
}

#[test]
fn marching_cubes_alone_agrees_with_peers() {
    let mesh = scratch("cube_mc.off");
    let part = here("data/cube_with_holes.py");
    done(rvachev().arg("mesh").arg(part).arg("-o").arg(&mesh).args(["--size", "0.05", "--method", "mc", "-q"]))
        .unwrap_or_else(|e| panic!("{e}"));
    // Edges are cut off, by a share of a cell along their length.
    agree(&mesh, &Truth { within: 2e-2, ..cube_with_holes() });
}

#[test]
fn bracket_agrees_with_peers() {
    let box_ = |p: [f64; 3], lo: [f64; 3], hi: [f64; 3]| (0..3).all(|i| lo[i] <= p[i] && p[i] <= hi[i]);
    let hole = |u: f64, v: f64, r: f64| u.hypot(v) < r;
    let inside = |[x, y, z]: [f64; 3]| {
        let p = [x, y, z];
        let solid = box_(p, [-1.0, -0.6, -0.6], [1.0, 0.6, -0.4])
            || box_(p, [-1.0, -0.6, -0.6], [-0.8, 0.6, 0.6])
            || hole(x - 0.3, y, 0.3) && (-0.5..=-0.17).contains(&z)
            || hole(y, z - 0.2, 0.25) && (-0.9..=-0.6).contains(&x)
            || y.abs() <= 0.06 && x >= -0.9 && z >= -0.5 && x + z <= -0.95;
        let holes = hole(x - 0.3, y, 0.15)
            || hole(y, z - 0.2, 0.12)
            || [0.78, -0.4].iter().any(|a| [0.41, -0.41].iter().any(|b| hole(x - a, y - b, 0.08)))
            || [0.4, -0.4].iter().any(|a| hole(y - a, z - 0.4, 0.07));
        solid && !holes
    };
    let truth = Truth { euler: -14, volume: counted(1.0, 300, inside), area: None, within: 5e-3 };
    agree(&mesh_file(&here("data/bracket.py"), "bracket", "0.04"), &truth);
}

#[test]
fn gyroid_agrees_with_peers() {
    let mesh = mesh_file(&here("data/gyroid_block.py"), "gyroid", "0.04");
    let volume = gyroid_volume();
    // A sheet has no known Euler characteristic here: the peers' word is compared with ours, and ours with itself.
    let euler = peers().ask(&[&mesh], None)[0]["igl"]["euler"].as_i64().unwrap();
    agree(&mesh, &Truth { euler, volume, area: None, within: 1e-2 });
}

/// The volume of the gyroid sheet of `data/gyroid_block.py`.
fn gyroid_volume() -> f64 {
    let (period, thickness) = (2.0, 0.3);
    let inside = |p: [f64; 3]| {
        let [x, y, z] = p.map(|q| TAU * q / period);
        let g = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
        g.abs() * period / TAU < thickness / 2.0
    };
    counted(1.0, 200, inside)
}

/// A cuboid of 4 by 3 by 2, without its upper side if it is open.
fn cuboid(name: &str, open: bool) -> PathBuf {
    let file = scratch(name);
    let corner = |k: usize| format!("{} {} {}\n", 4 * (k & 1), 3 * (k >> 1 & 1), 2 * (k >> 2 & 1));
    let sides = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6]];
    let shown = &sides[..if open { 5 } else { 6 }];
    let triangles = shown.iter().map(|[a, b, c, d]| format!("3 {a} {b} {c}\n3 {a} {c} {d}\n"));
    let text = (0..8).map(corner).chain(triangles).collect::<String>();
    fs::write(&file, format!("OFF\n8 {} 0\n{text}", 2 * shown.len())).unwrap();
    file
}

const CUBOID: Truth = Truth { euler: 2, volume: 24.0, area: Some(52.0), within: 1e-9 };

/// Runs a command whose last argument is the mesh it writes.
fn written(name: &str, arguments: &[&std::ffi::OsStr]) -> PathBuf {
    let mesh = scratch(name);
    let _ = fs::remove_file(&mesh);
    done(rvachev().args(arguments).arg("-q").arg("-o").arg(&mesh)).unwrap_or_else(|e| panic!("{e}"));
    mesh
}

#[test]
fn step_models_agree_with_peers() {
    let torus = Truth { euler: 0, volume: TAU * 3.0 * PI, area: Some(TAU * 3.0 * TAU), within: 1e-2 };
    agree(&mesh_file(&here("data/step/torus.step"), "torus_step", "0.2"), &torus);
}

#[test]
fn solids_built_from_edges_agree_with_peers() {
    let square = "polyline([(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 0)], closed=True)";
    agree(&mesh_text(&format!("part(extrude_edges({square}, (0, 0, 1), 2))\n"), "built", "0.3"), &CUBOID);
}

#[test]
fn remeshed_triangles_agree_with_peers() {
    agree(&mesh_file(&cuboid("soup_in.off", false), "soup", "0.3"), &CUBOID);
}

#[test]
fn healed_meshes_agree_with_peers() {
    let open = cuboid("without_lid.off", true);
    agree(&written("healed.off", &["heal".as_ref(), open.as_ref()]), &CUBOID);
}

#[test]
fn operators_agree_with_peers() {
    let part = here("data/cube_with_holes.py");
    let how = ["--size", "0.08", "--method", "operators"].map(AsRef::as_ref);
    let mesh = written("operators.off", &[&["mesh".as_ref(), part.as_ref()], &how[..]].concat());
    agree(&mesh, &Truth { within: 1e-2, ..cube_with_holes() });
}

#[test]
fn merged_bricks_agree_with_peers() {
    let part = here("data/cube_with_holes.py");
    let how = ["--size", "0.08", "--bricks", "2x1x2"].map(AsRef::as_ref);
    let mesh = written("bricks.off", &[&["mesh".as_ref(), part.as_ref()], &how[..]].concat());
    agree(&mesh, &Truth { within: 5e-3, ..cube_with_holes() });
}

#[test]
fn joined_meshes_agree_with_peers() {
    let open = cuboid("joined_box.off", true);
    let lid = scratch("joined_lid.off");
    fs::write(&lid, "OFF\n4 2 0\n0 0 2\n4 0 2\n4 3.000001 2\n0 3 2\n3 0 1 2\n3 0 2 3\n").unwrap();
    agree(&written("joined.off", &["join".as_ref(), open.as_ref(), lid.as_ref()]), &CUBOID);
}

#[test]
fn a_step_model_with_a_bore_of_functions_agrees_with_peers() {
    // What a cylinder through its center leaves of a ball; a ring.
    let (ball, bore): (f64, f64) = (2.0, 0.5);
    let half = (ball * ball - bore * bore).sqrt();
    let truth = Truth {
        euler: 0,
        volume: 4.0 / 3.0 * PI * half.powi(3),
        area: Some(4.0 * PI * (ball + bore) * half),
        within: 5e-3,
    };
    let path = here("data/step/sphere.step");
    agree(&mesh_text(&format!("part(step({path:?}) - cylinder({bore}))\n"), "step_and_function", "0.2"), &truth);
}

#[test]
fn triangles_cut_by_a_gyroid_agree_with_peers() {
    let block = scratch("gyroid_block.off");
    let corner = |k: usize| [0, 1, 2].map(|i| 2 * (k >> i & 1) as i64 - 1);
    let corners = (0..8).map(corner).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect::<String>();
    let sides = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6]];
    let triangles = sides.map(|[a, b, c, d]| format!("3 {a} {b} {c}\n3 {a} {c} {d}\n")).concat();
    fs::write(&block, format!("OFF\n8 12 0\n{corners}{triangles}")).unwrap();
    let mesh = mesh_text(&format!("part(mesh({block:?}) & gyroid(2, 0.3))\n"), "mesh_and_gyroid", "0.08");
    // The same solid of functions alone has these handles, whoever counts them.
    let functions = mesh_file(&here("data/gyroid_block.py"), "gyroid_functions", "0.08");
    let euler = peers().ask(&[&functions], None)[0]["igl"]["euler"].as_i64().unwrap();
    agree(&mesh, &Truth { euler, volume: gyroid_volume(), area: None, within: 1e-2 });
}

#[test]
fn curvature_of_a_sphere_is_one_over_its_radius() {
    let r = 1.5;
    let mesh = mesh_text(&format!("part(sphere({r}))\n"), "sphere", "0.1");
    let truth = Truth { euler: 2, volume: 4.0 / 3.0 * PI * r * r * r, area: Some(4.0 * PI * r * r), within: 3e-3 };
    let theirs = agree(&mesh, &truth);
    for side in ["min", "max"] {
        for k in theirs["curvature"][side].as_array().unwrap() {
            let k = k.as_f64().unwrap();
            assert!(abs_diff_eq!(k * r, 1.0, epsilon = 0.05), "curvature {k} on a sphere of radius {r}");
        }
    }
}

#[test]
fn curvatures_of_a_torus_are_those_of_its_circles() {
    let (major, minor) = (1.0, 0.4);
    let mesh = mesh_text(&format!("part(torus({major}, {minor}))\n"), "torus", "0.04");
    let truth = Truth {
        euler: 0,
        volume: 2.0 * PI * PI * major * minor * minor,
        area: Some(4.0 * PI * PI * major * minor),
        within: 3e-3,
    };
    let theirs = agree(&mesh, &truth);
    let share = |side: &str, i: usize| theirs["curvature"][side][i].as_f64().unwrap();
    // The tube's own circle bends by 1/minor everywhere; the other curvature runs from the inner to the outer equator's.
    for i in 0..5 {
        assert!(abs_diff_eq!(share("max", i) * minor, 1.0, epsilon = 0.1), "{}", theirs["curvature"]);
    }
    let (inner, outer) = (-1.0 / (major - minor), 1.0 / (major + minor));
    assert!(abs_diff_eq!(share("min", 0), inner, epsilon = 0.15 * inner.abs()), "{}", theirs["curvature"]);
    assert!(abs_diff_eq!(share("min", 4), outer, epsilon = 0.15 * outer), "{}", theirs["curvature"]);
}

#[test]
fn halving_the_size_brings_the_mesh_nearer() {
    let part = here("data/cube_with_holes.py");
    let meshes = ["0.2", "0.1", "0.05"].map(|size| mesh_file(&part, &format!("cube_{size}"), size));
    let mut last = f64::INFINITY;
    for (pair, size) in meshes.windows(2).zip([0.2, 0.1]) {
        let d = peers().ask(&[&pair[0], &pair[1]], Some("--distance"));
        let (igl, lab) = (number(&d, "/igl"), number(&d, "/pymeshlab"));
        // libigl measures at nodes only, so it cannot find more than pymeshlab, which samples faces too.
        assert!(igl <= lab * 1.001 + 1e-6, "libigl {igl}, pymeshlab {lab}");
        // Chords of an arc of radius r are off by size^2 / 8 r; sharp edges are on their curves at both sizes.
        assert!(lab < size * size / (8.0 * 0.4) * 3.0, "the meshes of size {size} and half of it are {lab} apart");
        assert!(lab < last, "{lab} after {last}");
        last = lab;
    }
}
