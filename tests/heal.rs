//! The command `heal` as a user meets it: what it writes, what it says, and the code it ends with.

use std::fs;

use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;
use tempfile::TempDir;

/// A unit cube; the last two triangles are its top.
const CUBE: &str = "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n3 0 2 1\n3 0 3 2\n3 0 1 5\n3 0 5 4\n\
3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n3 4 5 6\n3 4 6 7\n";

fn open_cube() -> String {
    let lines: Vec<&str> = CUBE.lines().collect();
    lines[..lines.len() - 2].join("\n").replace("8 12 0", "8 10 0") + "\n"
}

fn heal(file: &str, text: &str, args: &[&str]) -> (TempDir, assert_cmd::assert::Assert) {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join(file), text).unwrap();
    let run = Command::cargo_bin("rvachev").unwrap().current_dir(&dir).arg("heal").args(args).assert();
    (dir, run)
}

#[test]
fn a_box_without_a_lid_gets_one() {
    let (dir, run) = heal("box.off", &open_cube(), &["box.off", "-o", "a.stl", "-o", "a.off", "--json"]);
    let out = run.success().get_output().stdout.clone();
    let report: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(report["closed"], true);
    assert_eq!(report["self_intersections"], 0);
    assert_eq!(report["repairs"][0]["defect"], "hole");
    assert_eq!(report["repairs"][0]["action"], "filled");
    assert_eq!(report["repairs"][0]["count"], 4);
    assert_eq!(report["repairs"][0]["place"], serde_json::json!([0.5, 0.5, 1.0]));
    for name in ["a.stl", "a.off"] {
        Command::cargo_bin("rvachev")
            .unwrap()
            .current_dir(&dir)
            .args(["check", name])
            .assert()
            .success()
            .stdout(contains("volume 1.0"));
    }
}

#[test]
fn the_table_says_what_was_done_where() {
    let (_dir, run) = heal("box.off", &open_cube(), &["box.off", "-o", "a.off"]);
    run.success().stdout(contains("closed yes")).stdout(contains("hole: 4 filled, at (0.500000, 0.500000, 1.000000)"));
}

#[test]
fn a_hole_that_is_to_stay_is_a_shortfall() {
    let (dir, run) = heal("box.off", &open_cube(), &["box.off", "-o", "a.off", "--max-hole", "3"]);
    run.code(1).stderr(contains("falls short: the result is not closed"));
    assert!(dir.path().join("a.off").exists());
}

#[test]
fn wrong_usage_is_told_before_anything_is_read() {
    for args in [
        &["box.off"][..],
        &["box.off", "-o", "a.xyz"],
        &["box.off", "-o", "a.off", "--max-hole", "many"],
        &["box.off", "-o", "no/a.off"],
    ] {
        let (dir, run) = heal("box.off", &open_cube(), args);
        run.code(2);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "{args:?}");
    }
}

#[test]
fn bad_input_is_told_with_its_place() {
    let whole = open_cube();
    let cases = [
        ("", "empty"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "7"),
        ("OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "line 4"),
        (&whole[..60], "line 11"),
        ("OFF\n0 0 0\n", "no triangle"),
    ];
    for (text, word) in cases {
        let (dir, run) = heal("box.off", text, &["box.off", "-o", "a.off"]);
        let err = String::from_utf8_lossy(&run.code(3).get_output().stderr.clone()).into_owned();
        assert!(err.contains("box.off") && err.contains(word), "{text:?}: {err}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
    let (_dir, run) = heal("box.off", CUBE, &["missing.off", "-o", "a.off"]);
    run.code(3);
}

#[test]
fn nothing_but_lines_cannot_be_healed() {
    let (_dir, run) = heal("line.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", &["line.off", "-o", "a.off"]);
    run.code(4).stderr(contains("no triangle of the mesh has an area"));
}
