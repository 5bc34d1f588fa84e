//! The command as a user meets it: what it writes, what it says, and the code it ends with.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use tempfile::TempDir;

fn rvachev() -> Command {
    Command::cargo_bin("rvachev").unwrap()
}

fn data(name: &str) -> String {
    format!("{}/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Writes a part file and runs `mesh` on it with a coarse size.
fn mesh_source(dir: &Path, source: &str, more: &[&str]) -> assert_cmd::assert::Assert {
    fs::write(dir.join("part.py"), source).unwrap();
    rvachev().current_dir(dir).args(["mesh", "part.py", "-o", "out.off"]).args(more).assert()
}

fn nothing_left(dir: &Path) {
    let left: Vec<_> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name()).filter(|n| n != "part.py").collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

#[test]
fn the_main_job_writes_mesh_picture_and_report() {
    let dir = TempDir::new().unwrap();
    rvachev()
        .current_dir(&dir)
        .args([
            "mesh",
            &data("cube_with_holes.py"),
            "-o",
            "cube.msh",
            "-o",
            "cube.stl",
            "--png",
            "cube.png",
            "--report",
            "r.json",
        ])
        .assert()
        .success();
    let png = fs::read(dir.path().join("cube.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000);
    let report: Value = serde_json::from_slice(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
    assert_eq!(report["check"]["euler"], -4);
    assert_eq!(report["shortfalls"].as_array().unwrap().len(), 0);
    let out = rvachev().current_dir(&dir).args(["check", "cube.msh", "--json"]).output().unwrap();
    assert!(out.status.success());
    let check: Value = serde_json::from_slice(&out.stdout).unwrap();
    for key in [
        "nodes",
        "triangles",
        "closed",
        "manifold",
        "oriented",
        "self_intersections",
        "components",
        "euler",
        "genus",
        "area",
        "volume",
    ] {
        assert!(!check[key].is_null(), "{key}");
    }
    for key in ["min_angle", "p05_angle", "max_angle", "mean_radius_ratio", "below_20"] {
        assert!(check["quality"][key].is_number(), "{key}");
    }
    let names: Vec<&str> = check["groups"].as_array().unwrap().iter().map(|g| g["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"body.xmin") && names.contains(&"bore_x"), "{names:?}");
    // 8 - 2 * 2 pi 0.16 + 16/3 * 0.064
    let volume = check["volume"].as_f64().unwrap();
    assert!((volume - 6.330_714_6).abs() < 0.02, "{volume}");
}

#[test]
fn check_against_the_part_measures_deviation_and_features() {
    let dir = TempDir::new().unwrap();
    let part = data("cube_with_holes.py");
    rvachev().current_dir(&dir).args(["mesh", &part, "-o", "a.msh", "-q"]).assert().success().stdout("");
    let out = rvachev().current_dir(&dir).args(["check", "a.msh", "--against", &part, "--json"]).output().unwrap();
    let check: Value = serde_json::from_slice(&out.stdout).unwrap();
    for key in ["max", "rms", "normal"] {
        assert!(check["deviation"][key].is_number(), "{key}");
    }
    let f = &check["features"];
    assert_eq!((f["corners_true"].as_u64(), f["corners_found"].as_u64()), (Some(8), Some(8)), "{f}");
    assert!(f["recall"].as_f64().unwrap() > 0.9, "{f}");
}

#[test]
fn info_and_render_and_compare_answer() {
    let dir = TempDir::new().unwrap();
    rvachev().args(["info", &data("bracket.py")]).assert().success().stdout(contains("faces"));
    let out = rvachev().args(["info", &data("bracket.py"), "--json"]).output().unwrap();
    let info: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(info["leaves"].as_u64().unwrap() > 20);
    let part = data("cube_corner_sphere.py");
    rvachev()
        .current_dir(&dir)
        .args(["compare", &part, "--size", "4%", "--json", "c.json", "--png", "c.png"])
        .assert()
        .success()
        .stdout(contains("MC33").and(contains("recall")));
    let c: Value = serde_json::from_slice(&fs::read(dir.path().join("c.json")).unwrap()).unwrap();
    assert!(c["rows"].as_array().unwrap().len() > 5);
    rvachev().current_dir(&dir).args(["mesh", &part, "-o", "b.ply", "--size", "4%", "-q"]).assert().success();
    rvachev().current_dir(&dir).args(["render", "b.ply", "-o", "b.png"]).assert().success();
    assert!(fs::read(dir.path().join("b.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn overrides_and_threads_change_what_they_should() {
    let dir = TempDir::new().unwrap();
    let source = "r = 1\npart(sphere(r))\n";
    let mesh = |extra: &[&str]| {
        mesh_source(dir.path(), source, extra).success();
        let bytes = fs::read(dir.path().join("out.off")).unwrap();
        let out = rvachev().current_dir(&dir).args(["check", "out.off", "--json"]).output().unwrap();
        (bytes, serde_json::from_slice::<Value>(&out.stdout).unwrap()["volume"].as_f64().unwrap())
    };
    let (one, volume) = mesh(&["--size", "0.1", "--threads", "1"]);
    assert!((volume / 4.18879 - 1.0).abs() < 0.01, "{volume}");
    assert!(one == mesh(&["--size", "0.1", "--threads", "3"]).0);
    let (_, volume) = mesh(&["--size", "0.2", "-D", "r=2"]);
    assert!((volume / 33.5103 - 1.0).abs() < 0.01, "{volume}");
}

#[test]
fn bad_parts_are_refused_with_their_place() {
    let cases: &[(&str, &str)] = &[
        ("part(sphere(1)\n", "syntax error"),
        ("a = 1\npart(spher(1))\n", "line 2, column 6"),
        ("import os\n", "line 1, column 1"),
        ("part(sphere(1))\nwhile True:\n    pass\n", "line 2"),
        ("units('parsec')\npart(sphere(1))\n", "parsec"),
        ("part(sphere(-1))\n", "line 1"),
        ("a = 1/0\npart(sphere(1))\n", "line 1"),
        ("s = sphere(1)\npart(s - s)\n", "empty"),
        ("part(cylinder(1))\n", "domain"),
        ("part(solid(sqrt(x) - 0.5 >= 0) & box(size=(2, 2, 2)))\n", "finite"),
        ("part(solid(1 / (x - 0.123) >= 0) & box(size=(2, 2, 2)))\n", "pole"),
        ("x = 1\n", "part"),
        ("", "part"),
        ("part(box(size=(2, 2, 1e-4)))\n", "thinner"),
    ];
    for (source, says) in cases {
        let dir = TempDir::new().unwrap();
        mesh_source(dir.path(), source, &["--size", "0.1"]).code(3).stderr(contains(*says).and(contains("part.py")));
        nothing_left(dir.path());
    }
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), b"part(sphere(\xff\xfe))").unwrap();
    rvachev().current_dir(&dir).args(["mesh", "part.py", "-o", "a.off"]).assert().code(3).stderr(contains("UTF-8"));
    rvachev().current_dir(&dir).args(["mesh", "none.py", "-o", "a.off"]).assert().code(3).stderr(contains("none.py"));
}

#[test]
fn thin_walls_give_a_mesh_and_code_1() {
    let dir = TempDir::new().unwrap();
    let source = "part(box(lo=(-1, -1, 0), hi=(1, 1, 0.05)).name('plate') | box(lo=(-1, -1, 0), hi=(-0.5, 1, 1)))\n";
    mesh_source(dir.path(), source, &["--size", "0.1"])
        .code(1)
        .stderr(contains("plate").and(contains("thickness 0.05")));
    assert!(dir.path().join("out.off").exists());
}

#[test]
fn bad_requests_are_usage_errors() {
    let part = data("cube_with_holes.py");
    let cases: &[(&[&str], &str)] = &[
        (&["--size", "0"], "size"),
        (&["--size=-1"], "size"),
        (&["--size", "nan"], "size"),
        (&["--size", "1e-5"], "GiB"),
        (&["--method", "magic"], "mc, operators"),
        (&["-D", "radius"], "NAME=VALUE"),
        (&["-D", "nobody=1"], "nobody"),
        (&["--threads", "x"], "threads"),
        (&["-o", "a.xyz"], "xyz"),
        (&["-o", "no/such/folder/a.off"], "folder"),
        (&["--png", "no/such/folder/a.png"], "folder"),
    ];
    for (args, says) in cases {
        let dir = TempDir::new().unwrap();
        rvachev()
            .current_dir(&dir)
            .args(["mesh", &part, "-o", "out.off"])
            .args(*args)
            .assert()
            .code(2)
            .stderr(contains(*says));
        nothing_left(dir.path());
    }
    rvachev().assert().code(2);
    rvachev().arg("--help").assert().success();
}

#[test]
fn bad_meshes_are_refused_with_their_place() {
    let dir = TempDir::new().unwrap();
    let mut truncated = vec![0u8; 84];
    truncated[80] = 100;
    let cases: &[(&str, &[u8], &str)] = &[
        ("truncated.stl", &truncated, "100"),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "9"),
        ("nan.off", b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "finite"),
        ("index.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "7"),
        ("empty.ply", b"", "ply"),
    ];
    for (name, bytes, says) in cases {
        let path = dir.path().join(name);
        fs::write(&path, bytes).unwrap();
        let says = says.to_lowercase();
        rvachev()
            .arg("check")
            .arg(&path)
            .assert()
            .code(3)
            .stderr(predicate::function(|s: &str| s.to_lowercase().contains(&says) && s.contains(name)));
    }
    // a mesh that can be read but is open is measured, and is not good
    let open = dir.path().join("open.off");
    fs::write(&open, b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    rvachev().arg("check").arg(&open).arg("--json").assert().code(1).stdout(contains("\"closed\": false"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_within_a_second_and_leaves_nothing() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let dir = TempDir::new().unwrap();
    let part = data("gyroid_block.py");
    let mut child = Command::new(env!("CARGO_BIN_EXE_rvachev"))
        .current_dir(&dir)
        .args(["mesh", &part, "-o", "out.msh", "--size", "0.004"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let start = Instant::now();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    // a second is promised; a loaded machine is given some more
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    nothing_left(dir.path());
}
