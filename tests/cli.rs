//! The command as a user meets it: what it writes, what it says, and the code it ends with.

use std::fs;
use std::path::Path;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
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

/// Of solids of every kind, of a plane figure, which is meshed as a slab, and of one joined of two gates, whose operands are meshed
/// before it is.
#[test]
fn a_dry_run_tells_how_many_triangles_there_will_be_and_writes_nothing() {
    let dir = TempDir::new().unwrap();
    for name in ["bracket.py", "aircraft.py", "plate.py", "bored_ball.py", "soups/bored_block.off"] {
        let told = rvachev().current_dir(&dir).args(["mesh", &data(name), "--dry-run", "-q"]).assert().success();
        let told = String::from_utf8(told.get_output().stdout.clone()).unwrap();
        let about: f64 =
            told.trim().strip_prefix("about ").unwrap().strip_suffix(" triangles").unwrap().parse().unwrap();
        nothing_left(dir.path());
        let report = dir.path().join("r.json");
        let made = ["mesh", &data(name), "-o", "a.stl", "-q", "--report", "r.json"].map(String::from);
        rvachev().current_dir(&dir).args(made).assert().success();
        let known: Value = serde_json::from_slice(&fs::read(&report).unwrap()).unwrap();
        let count = known["check"]["triangles"].as_f64().unwrap();
        assert!(abs_diff_eq!(about, count, epsilon = 0.15 * count), "{name}: {about} {count}");
        [report, dir.path().join("a.stl")].iter().for_each(|f| fs::remove_file(f).unwrap());
    }
    for option in [["-o", "a.stl"], ["--png", "a.png"], ["--report", "a.json"]] {
        let both = ["mesh", &data("bracket.py"), "--dry-run"];
        rvachev().current_dir(&dir).args(both).args(option).assert().code(2);
    }
    rvachev().current_dir(&dir).args(["mesh", "none.py", "--dry-run"]).assert().code(3).stderr(contains("none.py"));
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
    assert_abs_diff_eq!(volume, 6.330_714_6, epsilon = 0.02);
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

/// The six sides of a cube but the last, two triangles each.
const BOX_WITHOUT_LID: &str = "OFF\n8 10 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n\
3 0 2 1\n3 0 3 2\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";

#[test]
fn an_open_soup_is_told_to_be_open_and_has_no_volume() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("box.off"), BOX_WITHOUT_LID).unwrap();
    let args = ["mesh", "box.off", "-o", "out.off", "--size", "0.2", "--report", "r.json"];
    let run = rvachev().current_dir(&dir).args(args).assert().success();
    run.stdout(contains("certificate: sound, open;").and(contains("closed NO")).and(contains("volume").not()));
    let report: Value = serde_json::from_slice(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
    let check = &report["check"];
    assert!(check["volume"].is_null() && check["closed"] == false && check["certificate"]["open"] == true, "{report}");
    assert_eq!(report["shortfalls"].as_array().unwrap().len(), 0, "{report}");
    // Nobody said that it may be.
    rvachev()
        .current_dir(&dir)
        .args(["check", "out.off"])
        .assert()
        .code(1)
        .stdout(contains("not closed: 20 open edges"));
}

#[test]
fn a_mesh_farther_from_the_surface_than_the_size_falls_short() {
    // No cell of this size sees the needle.
    let dir = TempDir::new().unwrap();
    let source = "part(sphere(1) | cylinder(0.004, height=4))\n";
    for extra in [&["--method", "mc"][..], &["--method", "operators"], &["--method", "mc", "-q"]] {
        let run = mesh_source(dir.path(), source, &[&["--size", "0.3"], extra].concat()).code(1);
        run.stderr(contains("apart somewhere, more than the size of 3.0000e-1"));
    }
    // Edges that marching cubes cuts off are within a cell of it.
    mesh_source(dir.path(), "part(box(size=(2, 2, 2)))\n", &["--size", "0.3", "--method", "mc"]).success();
}

#[test]
fn every_method_with_operators_writes_a_mesh_and_tells_its_sequence() {
    let dir = TempDir::new().unwrap();
    let source = "part(box(size=(2, 2, 2)) - cylinder(.5))\n";
    let report = |extra: &[&str]| {
        let all = [&["--size", "0.2", "--report", "r.json", "-q"], extra].concat();
        let code = mesh_source(dir.path(), source, &all).get_output().status.code();
        rvachev().current_dir(&dir).args(["check", "out.off"]).assert().success();
        let r = serde_json::from_slice::<Value>(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
        assert_eq!(code, Some(i32::from(!r["shortfalls"].as_array().unwrap().is_empty())));
        r
    };
    // Smoothing alone keeps no edge.
    assert_eq!(report(&["--sequence", "R_all*3"])["shortfalls"][0]["kind"], "creases_cut_off");
    assert_eq!(report(&["--method", "cut"])["shortfalls"], Value::Array(Vec::new()));
    for (method, has) in [("operators", "classify"), ("paper", "classify"), ("cut", "cut survey")] {
        let r = report(&["--method", method]);
        assert_eq!(r["method"], method);
        assert!(r["sequence"].as_str().unwrap().contains(has), "{r}");
        // What is told can be run again, to the same bytes.
        let bytes = fs::read(dir.path().join("out.off")).unwrap();
        report(&["--sequence", r["sequence"].as_str().unwrap()]);
        assert!(bytes == fs::read(dir.path().join("out.off")).unwrap(), "{method}");
    }
    assert!(report(&["--method", "mc"])["sequence"].is_null());
    let given = "R_all*2 (N N1)*2 survey";
    fs::write(dir.path().join("order.txt"), "R_all*2 # first\n(N N1)*2\nsurvey\n").unwrap();
    for extra in [&["--sequence", given][..], &["--sequence", "@order.txt", "--method", "operators"]] {
        let r = report(extra);
        assert_eq!((r["method"].as_str(), r["sequence"].as_str()), (Some("operators"), Some(given)));
    }
    // A part file's own, unless the command line says otherwise.
    let source = format!("{source}mesh(size=.2, sequence=\"N1*2\")\n");
    for (extra, method, ran) in [
        (&[][..], "operators", Some("N1*2")),
        (&["--sequence", "N1 survey"], "operators", Some("N1 survey")),
        (&["--method", "mc"], "mc", None),
    ] {
        let all = [&["--report", "r.json", "-q", "--force"], extra].concat();
        mesh_source(dir.path(), &source, &all);
        let r: Value = serde_json::from_slice(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
        assert_eq!((r["method"].as_str(), r["sequence"].as_str()), (Some(method), ran));
    }
}

#[test]
fn mistakes_with_sequences_name_their_place_and_write_nothing() {
    let dir = TempDir::new().unwrap();
    let source = "part(sphere(1))\n";
    for (extra, code, said) in [
        (&["--sequence", "N R_al"][..], 2, "--sequence: line 1, column 3: no operator is called \"R_al\""),
        (
            &["--sequence", "N", "--method", "leaf"],
            2,
            "--sequence is for solids of functions by operators; not for part.py",
        ),
        (&["--sequence", "N", "--method", "cut"], 2, "--sequence is for solids of functions by operators"),
        (&["--sequence", "@none.txt"], 3, "none.txt"),
        (&["--method", "operator"], 2, "the nearest is operators"),
    ] {
        mesh_source(dir.path(), source, &[&["--size", "0.3"], extra].concat()).code(code).stderr(contains(said));
        nothing_left(dir.path());
    }
    mesh_source(dir.path(), "part(sphere(1))\nmesh(sequence=\"N N3\")\n", &["--size", "0.3"])
        .code(3)
        .stderr(contains("part.py: line 2, column 15: sequence: line 1, column 3: no operator is called \"N3\""))
        .stderr(contains("nearest name is \"N\"").or(contains("nearest name is \"N1\"")));
    nothing_left(dir.path());
    fs::write(dir.path().join("bad.txt"), "N\n R_all)\n").unwrap();
    mesh_source(dir.path(), source, &["--size", "0.3", "--sequence", "@bad.txt"])
        .code(3)
        .stderr(contains("bad.txt: line 2, column 7: no group is open"));
    fs::write(dir.path().join("box.off"), BOX_WITHOUT_LID).unwrap();
    let args = ["mesh", "box.off", "-o", "out.off", "--sequence", "N"];
    rvachev().current_dir(&dir).args(args).assert().code(2).stderr(contains("solids of functions by operators"));
}

#[test]
fn verbose_tells_of_every_attempt_and_stage() {
    let dir = TempDir::new().unwrap();
    let source = "part(sphere(1) | cylinder(0.0015, height=4))\n";
    let run = mesh_source(dir.path(), source, &["--size", "0.15", "-v", "-q", "--report", "r.json"]).success();
    let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    let report: Value = serde_json::from_slice(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
    let attempts = report["attempts"].as_array().unwrap();
    // The needle is thinner than the first cells show.
    assert!(report["schema"] == 1 && attempts.len() > 1, "{report}");
    assert_eq!(attempts.iter().filter(|a| a["kept"] == true).count(), 1, "{report}");
    assert_eq!(text.lines().filter(|l| l.starts_with("attempt: ")).count(), attempts.len(), "{text}");
    // They are told as they end, in the order of time, before anybody knows which one is kept.
    assert!(text.contains("): some of the surface is not in the mesh") && text.contains("stage: check: "), "{text}");
    let order = ["attempt: ", "stage: mesh: ", "stage: check: ", "kept: "].map(|s| text.find(s).unwrap());
    assert!(order.is_sorted() && text.matches("kept: ").count() == 1, "{text}");
    assert_eq!(attempts.last().unwrap()["triangles"], report["check"]["triangles"]);
    assert!(attempts.iter().all(|a| a["seconds"].as_f64().unwrap() >= 0.0));
    // The other gates.
    fs::write(dir.path().join("box.off"), BOX_WITHOUT_LID).unwrap();
    for (part, said) in [(data("troubles/torus.py"), "attempt: bodies "), ("box.off".into(), "attempt: soup ")] {
        let args = ["mesh", &part, "-o", "other.off", "--size", "20%", "-v", "-q"];
        rvachev().current_dir(&dir).args(args).assert().success().stderr(contains(said).and(contains("kept: ")));
    }
}

#[cfg(unix)]
#[test]
fn a_run_that_is_stopped_has_told_what_it_tried() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let dir = TempDir::new().unwrap();
    // Its first cells do not see the needle, and later ones take their time.
    fs::write(dir.path().join("part.py"), "part(sphere(1) | cylinder(0.004, height=4))\n").unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_rvachev"))
        .current_dir(&dir)
        .args(["mesh", "part.py", "-o", "out.msh", "--size", "0.1", "-v", "-q"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = lines.next().unwrap();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert!(first.starts_with("attempt: "), "{first}");
    assert_eq!(child.wait().unwrap().code(), Some(130), "{:?}", lines.collect::<Vec<_>>());
    nothing_left(dir.path());
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

/// Width, height and pixels of four bytes of a PNG file.
fn pixels(path: &Path) -> (u32, u32, Vec<[u8; 4]>) {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap()));
    decoder.set_transformations(png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (info.width, info.height, bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect())
}

#[test]
fn pictures_are_drawn_as_asked() {
    let dir = TempDir::new().unwrap();
    mesh_source(dir.path(), "part(sphere(1))\n", &["--size", "0.3", "-q"]).success();
    let args = |more: &[&str]| {
        let mut all = vec!["render", "out.off", "-o", "out.png"];
        all.extend(more);
        rvachev().current_dir(&dir).args(all).assert()
    };
    let drawn = |more: &[&str]| {
        args(more).success();
        pixels(&dir.path().join("out.png"))
    };
    // A disk and its cut half fill pi / 4 of the free square.
    let plain = ["--view", "front", "--size", "200x100", "--edges", "none"];
    let (width, height, disk) = drawn(&[&plain[..], &["--transparent"]].concat());
    assert_eq!((width, height), (200, 100));
    let opaque = |pixels: &[[u8; 4]]| pixels.iter().map(|c| f64::from(c[3]) / 255.0).sum::<f64>();
    let full = 90.0 * 90.0 * std::f64::consts::FRAC_PI_4;
    assert_abs_diff_eq!(opaque(&disk), full, epsilon = 0.03 * full);
    assert!(disk.iter().filter(|c| c[3] == 0).count() > 12_000);
    // The half behind the middle is as wide and shows its inside, which is grey.
    let cut = drawn(&[&plain[..], &["--transparent", "--clip", "y=0"]].concat()).2;
    assert_abs_diff_eq!(opaque(&cut), full, epsilon = 0.03 * full);
    let grey = |c: &&[u8; 4]| c[3] == 255 && c[0].abs_diff(c[2]) < 20;
    assert!(cut.iter().filter(grey).count() > 6_000 && disk.iter().filter(grey).count() == 0);
    assert_eq!(drawn(&[&plain[..], &["--color", "angle"]].concat()), drawn(&[&plain[..], &["--quality"]].concat()));
    // All nodes are a tenth away from a smaller ball, whichever file tells of it: the color of the largest distance.
    fs::write(dir.path().join("small.py"), "r = 1\npart(sphere(r))\n").unwrap();
    let far = ["--color", "distance", "--against", "small.py", "-D", "r=0.9"];
    let far = drawn(&[&plain[..], &far[..]].concat()).2;
    let red = |c: &&[u8; 4]| u16::from(c[0]) > 2 * u16::from(c[1].max(c[2]));
    assert!(far.iter().filter(red).count() > 6_000);
    assert!(drawn(&[&plain[..], &["--color", "edge"]].concat()).2.iter().filter(red).count() == 0);
    fs::remove_file(dir.path().join("out.png")).unwrap();
    fs::write(dir.path().join("far.py"), "part(sphere(1, at=(1000, 0, 0)))\n").unwrap();
    args(&["--color", "distance", "--against", "far.py"]).code(3).stderr(contains("same unit"));
    for (bad, said) in [
        (&["--view", "up"][..], "front, back, left, right, top, bottom"),
        (&["--view", "0,100"], "-90 to 90"),
        (&["--clip", "x<1"], "AXIS=POSITION"),
        (&["--clip", "x=2"], "between x = -"),
        (&["--color", "hue"], "face, angle, edge, distance"),
        (&["--edges", "some"], "none, sharp, all"),
        (&["--size", "9x9"], "16 to 16384"),
        (&["--size", "100"], "WIDTHxHEIGHT"),
        (&["--color", "distance"], "--against"),
        (&["--against", "small.py"], "--color distance"),
        (&["--color", "distance", "--against", "a.step", "-D", "r=1"], "STEP"),
        (&["--quality", "--color", "edge"], "--color"),
    ] {
        args(bad).code(2).stderr(contains(said));
        assert!(!dir.path().join("out.png").exists());
    }
}

#[test]
fn saying_nothing_changes_nothing() {
    // Walls so thin that the first mesh is measured and made anew.
    let dir = TempDir::new().unwrap();
    let mesh = |extra: &[&str]| {
        mesh_source(dir.path(), "part(sphere(1) - sphere(.97, at=(.028, 0, 0)))\n", extra).success();
        fs::read(dir.path().join("out.off")).unwrap()
    };
    let told = mesh(&["--size", "0.2", "--report", "a.json"]);
    assert!(fs::read_to_string(dir.path().join("a.json")).unwrap().contains("walls are thin"));
    assert!(told == mesh(&["--size", "0.2", "-q"]));
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
    assert_relative_eq!(volume, 4.18879, epsilon = 0.0, max_relative = 0.01);
    assert!(one == mesh(&["--size", "0.1", "--threads", "3"]).0);
    let (_, volume) = mesh(&["--size", "0.2", "-D", "r=2"]);
    assert_relative_eq!(volume, 33.5103, epsilon = 0.0, max_relative = 0.01);
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

#[test]
fn solids_built_from_edges_are_told_of_converted_and_checked() {
    let dir = TempDir::new().unwrap();
    let part = data("troubles/torus.py");
    let told = |args: &[&str]| {
        let out = rvachev().current_dir(&dir).args(args).output().unwrap();
        assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
        String::from_utf8(out.stdout).unwrap()
    };
    let text = told(&["info", &part]);
    for s in [
        "1 bodies (1 solids), 1 faces",
        "sewn",
        "face ring.side (#1): torus",
        "area 473.741",
        "volume 473.741",
        "u 0 .. 6.28319",
    ] {
        assert!(text.contains(s), "{text}");
    }
    told(&["convert", &part, "-o", "ring.step"]);
    let told_again = told(&["info", "ring.step", "--json"]);
    let info: Value = serde_json::from_str(&told_again).unwrap();
    assert_eq!((info["sewn"].as_bool(), info["faces"][0]["surface"].as_str()), (Some(true), Some("torus")));
    told(&["mesh", "ring.step", "-o", "ring.stl", "--size", "5%", "-q"]);
    let check: Value = serde_json::from_str(&told(&["check", "ring.stl", "--against", "ring.step", "--json"])).unwrap();
    assert_eq!(check["deviation"]["inverted"], 0);
    let ball = data("cube_with_holes.py");
    rvachev()
        .current_dir(&dir)
        .args(["convert", &ball, "-o", "c.step"])
        .assert()
        .code(3)
        .stderr(contains("built from edges"));
    rvachev().current_dir(&dir).args(["convert", &part, "-o", "c.stl"]).assert().code(2).stderr(contains(".step"));
}

#[test]
fn a_script_and_an_older_mesh_beside_it_need_two_names() {
    let dir = TempDir::new().unwrap();
    let part = "part(box(size=(1, 1, 1)))\n";
    fs::write(dir.path().join("part.py"), part).unwrap();
    let mesh = |outputs: [&str; 2]| {
        let mut c = rvachev();
        c.current_dir(&dir).args(["mesh", "part.py", "--msh-version", "2.2", "-o", outputs[0], "-o", outputs[1]]);
        c.assert()
    };
    mesh(["a.msh", "./a.geo"]).code(2).stderr(contains("a.msh cannot be of version 2.2"));
    nothing_left(dir.path());
    mesh(["b.msh", "a.geo"]).success().stderr(contains("warning: a.msh beside a.geo is of version 4.1"));
    let version =
        |file: &str| fs::read_to_string(dir.path().join(file)).unwrap().lines().nth(1).unwrap()[..3].to_owned();
    assert_eq!((version("a.msh"), version("b.msh")), ("4.1".into(), "2.2".into()));
}

#[test]
fn a_group_of_no_face_is_an_error_where_it_stands() {
    let dir = TempDir::new().unwrap();
    let solid = "ball = sphere(1).name(\"ball\")\nhidden = sphere(.5).name(\"hidden\")\npart(ball | hidden)\n";
    mesh_source(dir.path(), &format!("{solid}group(\"loaded\", faces(\"ball\", \"bal\"))\n"), &[])
        .code(3)
        .stderr(contains("part.py: line 4, column 1: group \"loaded\": no face is called \"bal\""))
        .stderr(contains("the nearest name is \"ball\""));
    nothing_left(dir.path());
    // A face that is there without a triangle is another thing.
    mesh_source(dir.path(), &format!("{solid}group(\"loaded\", faces(\"ball\", \"hidden\"))\n"), &["--method", "mc"])
        .success();
}

/// By the gates that have groups: functions, bricks, set operations with meshes, plane figures.
#[test]
fn a_group_without_triangles_falls_short_by_its_name_and_the_mesh_is_written() {
    let dir = TempDir::new().unwrap();
    let boxes = "a = box(size=(1, 1, 1)).name(\"a\")\nb = box(size=(1, 1, 1)).name(\"b\")\n";
    let balls = "ball = sphere(1).name(\"a\")\nhidden = sphere(.5).name(\"b\")\n";
    let groups = "group(\"all\", faces(\"*\"))\ngroup(\"clamp\", faces(\"b*\"))\n";
    fs::copy(data("soups/bored_block.off"), dir.path().join("block.off")).unwrap();
    let figure = "part(region((circle(2).name(\"a\") | circle(1).name(\"b\"))))\n";
    let bricks = ["--bricks", "2x1x1", "--size", "0.03"];
    for (source, more) in [
        (format!("{boxes}part(a | b)\n{groups}"), &[][..]),
        (format!("{balls}part(ball | hidden)\n{groups}"), &["--method", "mc"]),
        (format!("{balls}part(ball | hidden)\n{groups}"), &bricks),
        (format!("part(mesh(\"block.off\").name(\"a\") | sphere(.5, at=(-13, -8, -3)).name(\"b\"))\n{groups}"), &[]),
        (format!("{figure}{groups}"), &[]),
    ] {
        let more: Vec<&str> = more.iter().copied().chain(["--report", "r.json"]).collect();
        mesh_source(dir.path(), &source, &more)
            .code(1)
            .stderr(contains("falls short: group \"clamp\" holds no triangle: its faces b"));
        let report: Value = serde_json::from_slice(&fs::read(dir.path().join("r.json")).unwrap()).unwrap();
        let faults = report["shortfalls"].as_array().unwrap();
        assert_eq!(faults.len(), 1, "{source} {faults:?}");
        assert_eq!(faults[0]["kind"], "empty_group");
        assert_eq!(faults[0]["group"], "clamp");
        assert!(faults[0]["faces"].as_array().unwrap().iter().all(|f| f.as_str().unwrap().starts_with('b')));
        assert!(fs::metadata(dir.path().join("out.off")).unwrap().len() > 1000);
        fs::remove_file(dir.path().join("out.off")).unwrap();
    }
}

#[test]
fn names_in_files_do_not_command_the_terminal() {
    let dir = TempDir::new().unwrap();
    mesh_source(dir.path(), "a = 1\t# \u{1b}[2J\nb = \"\u{1b}]0;\u{7}\" + spher(1)\n", &[])
        .code(3)
        .stderr(contains("\\u001b]0;\\u0007").and(contains("did you mean \"sphere\"?")).and(contains("\u{1b}").not()));
    let mut facets = String::from("solid \u{1b}[31mred\u{202e}\n");
    let [o, x, y, z] = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    for [a, b, c] in [[o, y, x], [o, x, z], [o, z, y], [x, y, z]] {
        facets += &format!("facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n");
    }
    facets += "endsolid\n";
    fs::write(dir.path().join("red.stla"), facets).unwrap();
    for more in [&[][..], &["--json"]] {
        let out = rvachev().current_dir(&dir).args(["info", "red.stla"]).args(more).output().unwrap();
        let said = String::from_utf8([out.stdout, out.stderr].concat()).unwrap();
        assert!(said.contains("\\u001b[31mred") && !said.contains(['\u{1b}', '\u{202e}']), "{said:?}");
    }
}
