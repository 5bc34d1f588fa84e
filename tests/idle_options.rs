//! Options of the command that a way of meshing does not know are refused by name, and those it knows change the mesh.

use std::fs;
use std::process::{Command, Output};

use tempfile::TempDir;

/// Options, each with a value that changes the mesh of every part below whose way knows it, and one for the block, which is larger.
const OPTIONS: [[&str; 3]; 9] = [
    ["--angle", "6", "6"],
    ["--tol", "1e-3", "1e-2"],
    ["--size-min", "0.2", "2.4"],
    ["--grading", "1.5", "1.5"],
    ["--refine", "sphere=0.6,0,0,0.8:0.04", "sphere=-13,0,0,8:0.5"],
    ["--thickness", "0.4", "0.4"],
    ["--eps", "1e-2", "1e-2"],
    ["--trim", "0.05", "0.5"],
    ["--volume", "1e-4", "1e-4"],
];

/// What is known and may leave this mesh as it is: how far nodes are from the surface matters where marching cubes take part,
/// and nothing here is narrow.
const SILENT: [&str; 2] = ["--eps", "--trim"];

const FUNCTIONS: &str = "part(sphere(1) - cylinder(0.2))\n";
const FIGURE: &str = "part(region(circle(1) - circle(0.2, at=(0.7, 0))))\n";
const BUILT: &str = "part(extrude_edges([circle(0.5), circle(0.1, at=(0.3, 0, 0))], \"z\", 0.6))\n";
const JOINED: &str = "part(mesh(\"block.off\") - mesh(\"block.off\").move((5, 3, 2)))\n";
const WITH_FUNCTIONS: &str = "part(mesh(\"block.off\") - sphere(3, at=(-15, 0, 1)))\n";

/// A way: its name, the part, more options, and which options it knows.
type Way = (&'static str, &'static str, &'static [&'static str], &'static [&'static str]);

const WAYS: [Way; 10] = [
    ("leaf", FUNCTIONS, &[], &["--angle", "--tol", "--size-min", "--grading", "--refine", "--thickness", "--eps"]),
    ("operators", FUNCTIONS, &["--method", "operators"], &["--angle", "--tol", "--size-min", "--eps"]),
    ("paper", FUNCTIONS, &["--method", "paper"], &["--angle", "--tol", "--size-min", "--eps"]),
    ("cut", FUNCTIONS, &["--method", "cut"], &["--angle", "--tol", "--size-min", "--eps"]),
    ("mc", FUNCTIONS, &["--method", "mc"], &["--eps"]),
    ("bricks", FUNCTIONS, &["--bricks", "1x1x1"], &["--angle", "--tol", "--size-min", "--grading"]),
    ("figure", FIGURE, &[], &["--angle", "--tol", "--size-min", "--grading", "--refine", "--eps"]),
    ("built", BUILT, &[], &["--angle", "--tol", "--size-min", "--grading", "--refine", "--trim", "--volume"]),
    ("joined", JOINED, &[], &["--angle", "--tol", "--size-min", "--grading", "--refine"]),
    ("with functions", WITH_FUNCTIONS, &[], &["--angle", "--tol", "--size-min", "--grading", "--refine", "--eps"]),
];

fn rvachev(dir: &TempDir, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rvachev")).current_dir(dir).args(words).output().unwrap()
}

fn folder() -> TempDir {
    let dir = TempDir::new().unwrap();
    let block = format!("{}/data/soups/bored_block.off", env!("CARGO_MANIFEST_DIR"));
    fs::copy(block, dir.path().join("block.off")).unwrap();
    dir
}

/// The mesh that options give, or what is said where it is refused.
fn mesh(dir: &TempDir, part: &str, words: &[&str]) -> Result<Vec<u8>, (Option<i32>, String)> {
    fs::write(dir.path().join("part.py"), part).unwrap();
    let all = [&["mesh", "part.py", "-o", "out.off", "-q", "--force"], words].concat();
    let out = rvachev(dir, &all);
    match fs::read(dir.path().join("out.off")) {
        Ok(bytes) => {
            fs::remove_file(dir.path().join("out.off")).unwrap();
            Ok(bytes)
        }
        Err(_) => Err((out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())),
    }
}

#[test]
fn what_a_way_knows_changes_its_mesh_and_all_else_is_refused_by_name() {
    let dir = folder();
    let mut wrong = Vec::new();
    for (way, part, more, known) in WAYS {
        let is_block = part.contains("block");
        let size = ["--size", if is_block { "3" } else { "0.25" }];
        let plain = mesh(&dir, part, &[&size, more].concat()).unwrap_or_else(|e| panic!("{way}: {e:?}"));
        for [option, small, large] in OPTIONS {
            let value = if is_block { large } else { small };
            let made = mesh(&dir, part, &[&size, more, &[option, value]].concat());
            let refused = matches!(&made, Err((Some(2), said)) if said.contains(&format!("{option} is for ")));
            if refused == known.contains(&option) {
                wrong.push(format!("{way} {option}: refused {refused}, {:?}", made.as_ref().err()));
            }
            if known.contains(&option) && !SILENT.contains(&option) && made.as_ref().is_ok_and(|m| *m == plain) {
                wrong.push(format!("{way} {option}: the same mesh"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn faces_are_meshed_anew_by_ways_that_know_their_surface_and_refused_by_name_by_others() {
    let dir = folder();
    for (way, part, more, _) in WAYS {
        let said = mesh(&dir, part, &[&["--size", "25%", "--remesh", "no such face=0.1"], more].concat()).unwrap_err();
        let expected = if ["leaf", "built"].contains(&way) { "no face is called" } else { "--remesh is for " };
        assert!(said.0 == Some(2) && said.1.contains(expected), "{way}: {said:?}");
    }
}

#[test]
fn what_is_there_by_default_is_not_refused_nor_what_a_method_alone_would_not_know() {
    let dir = folder();
    // Solids built from edges have no method, whichever that is.
    for method in ["leaf", "mc"] {
        let (code, said) = mesh(&dir, BUILT, &["--method", method]).unwrap_err();
        assert!(code == Some(2) && said.contains("--method is for solids of functions"), "{code:?} {said}");
    }
    // Beside a solid of R-functions they take what either takes.
    let both = "part([extrude_edges([circle(0.5)], \"z\", 0.6), sphere(0.3, at=(3, 0, 0))])\n";
    for words in [&["--thickness", "0.5"][..], &["--method", "mc"], &["--trim", "0.01"], &["--memory", "4"]] {
        let made = mesh(&dir, both, &[&["--size", "0.2"], words].concat());
        assert!(made.is_ok(), "{words:?} {made:?}");
    }
    assert!(mesh(&dir, FUNCTIONS, &["--size", "0.25", "--bricks", "1x1x1", "--sequence", "N"]).is_err());
}

#[test]
fn a_number_for_no_part_is_refused_by_check() {
    let dir = folder();
    let step = format!("{}/data/step/sphere.step", env!("CARGO_MANIFEST_DIR"));
    for words in [&["-D", "a=1"][..], &["-D", "a=1", "--against", &step]] {
        let out = rvachev(&dir, &[&["check", "block.off"], words].concat());
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && said.contains("-D overrides numbers of"), "{words:?} {said}");
    }
}
