//! Healing inside the command `mesh`: what is dirty, or comes out open, is set right and named with its place; what cannot be
//! is named too.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use rvachev::parametric::brep::Brep;
use rvachev::parametric::build::{Extrusion, Wire, extrude_edges, flat_face, sew};
use rvachev::pipeline::save_step;
use rvachev::{DVec3, Run};
use serde_json::Value;
use tempfile::TempDir;

fn rvachev(dir: &Path) -> Command {
    let mut command = Command::cargo_bin("rvachev").unwrap();
    command.current_dir(dir);
    command
}

/// What the report lists under a name.
fn listed(dir: &Path, name: &str) -> Vec<String> {
    let report: Value = serde_json::from_slice(&fs::read(dir.join("report.json")).unwrap()).unwrap();
    report[name].as_array().unwrap().iter().map(|w| w.as_str().or(w["message"].as_str()).unwrap().to_string()).collect()
}

fn square(z: f64) -> Wire {
    let p = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
    Wire::polygon(&p).unwrap()
}

/// The sides and the bottom of a box, and a lid at a height above them; sewn where they meet.
fn lidded(gap: f64) -> Brep {
    let sheet = Extrusion { caps: false, ..Extrusion::new(DVec3::Z, 2.0) };
    let side = extrude_edges(&[square(0.0)], &sheet).unwrap();
    let lids = [flat_face(&[square(0.0)]).unwrap(), flat_face(&[square(2.0 + gap).reversed()]).unwrap()];
    sew([vec![side], lids.to_vec()].concat(), Some(1e-6), false, &Run::new()).unwrap()
}

#[test]
fn a_model_with_a_gap_between_its_faces_comes_out_closed() {
    let dir = TempDir::new().unwrap();
    save_step(&dir.path().join("gap.step"), &lidded(1e-4), None).unwrap();
    let args = ["mesh", "gap.step", "-o", "gap.stl", "--size", "0.4", "--report", "report.json"];
    rvachev(dir.path()).args(args).assert().success();
    let told = listed(dir.path(), "warnings");
    let joined: Vec<&String> = told.iter().filter(|w| w.starts_with("healed: near borders: ")).collect();
    assert!(!joined.is_empty() && joined.iter().all(|w| w.contains(", 2.00")), "{told:?}");
    assert!(!told.iter().any(|w| w.contains("it is open there")), "{told:?}");
    rvachev(dir.path()).args(["check", "gap.stl"]).assert().success().stdout(contains("volume 8.00"));
}

#[test]
fn a_gap_too_wide_to_be_one_stays_open_and_is_named() {
    let dir = TempDir::new().unwrap();
    save_step(&dir.path().join("gap.step"), &lidded(0.3), None).unwrap();
    let args = ["mesh", "gap.step", "-o", "gap.stl", "--size", "0.4", "--report", "report.json"];
    rvachev(dir.path()).args(args).assert().stderr(contains("8 edges of the model have a face on one side only"));
    rvachev(dir.path()).args(["check", "gap.stl"]).assert().code(1).stdout(contains("closed NO"));
    assert!(!listed(dir.path(), "warnings").iter().any(|w| w.starts_with("healed")));
}

/// A unit cube in twelve triangles with one of each: a triangle missing on top, one turned, one twice, one without area, a
/// node on an edge.
const DIRTY: &str = "OFF\n9 14 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n0.5 0 0\n\
3 0 2 1\n3 0 3 2\n3 0 8 5\n3 8 1 5\n3 0 5 4\n3 1 2 6\n3 1 5 6\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n3 4 5 6\n\
3 3 4 7\n3 2 2 3\n";

#[test]
fn dirty_triangles_are_healed_first_and_every_defect_is_named_with_its_place() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("dirty.off"), DIRTY).unwrap();
    let args = ["mesh", "dirty.off", "-o", "a.stl", "--size", "0.25", "--close", "--report", "report.json"];
    rvachev(dir.path()).args(args).assert().success();
    let told = listed(dir.path(), "warnings");
    for what in [
        "healed: degenerate triangle: 1 removed, at (",
        "healed: duplicate triangle: 1 removed, at (0.000000, 0.666667, 0.666667)",
        "healed: t junction: 1 split, at (0.500000, 0.000000, 0.000000)",
        "healed: orientation: 1 flipped, at (1.000000, 0.333333, 0.666667)",
        "healed: hole: 3 filled, at (0.333333, 0.666667, 1.000000)",
    ] {
        assert!(told.iter().any(|w| w.starts_with(what)), "{what}: {told:?}");
    }
    rvachev(dir.path()).args(["check", "a.stl"]).assert().success().stdout(contains("volume 1.0"));
}

/// What is left open on purpose is a shortfall of healing, not a success.
#[test]
fn what_is_not_healed_ends_with_code_one_and_is_named() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("dirty.off"), DIRTY).unwrap();
    let args = ["heal", "dirty.off", "-o", "a.off", "--max-hole", "2"];
    rvachev(dir.path())
        .args(args)
        .assert()
        .code(1)
        .stdout(contains("hole: 3 left, at (0.333333, 0.666667, 1.000000)"))
        .stderr(contains("falls short: the result is not closed"));
}

/// Marching cubes make triangles that intersect where three planes cross in one point: the same command sets that right.
#[test]
fn a_faulty_mesh_of_a_part_is_healed_before_it_is_written() {
    let dir = TempDir::new().unwrap();
    let part = "part(solid(x*y*z >= 0).rotate(18, axis=(1, 0, 1)) & box(size=(2, 2, 2)))\n";
    fs::write(dir.path().join("part.py"), part).unwrap();
    let args = ["mesh", "part.py", "-o", "a.off", "--size", "0.2", "--method", "mc", "--report", "report.json"];
    rvachev(dir.path()).args(args).assert().success();
    let told = listed(dir.path(), "warnings");
    let refilled = |w: &&String| w.starts_with("healed: self intersection: ") && w.contains(" refilled, at (");
    assert!(told.iter().any(|w| refilled(&w)), "{told:?}");
    rvachev(dir.path()).args(["check", "a.off"]).assert().success().stdout(contains("0 self-intersecting triangles"));
}

/// A sheet folded through itself: nothing in the model says which parts of it were meant. The face that would cross is left
/// out and named.
#[test]
fn a_model_that_crosses_itself_is_not_healed_but_named() {
    let dir = TempDir::new().unwrap();
    let strip = |[a, b]: [[f64; 2]; 2]| {
        let p = [(a, -1.0), (b, -1.0), (b, 1.0), (a, 1.0)].map(|([x, z], y)| DVec3::new(x, y, z));
        flat_face(&[Wire::polygon(&p).unwrap()]).unwrap()
    };
    let fold = [[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, -1.0]];
    let strips: Vec<Brep> = fold.windows(2).map(|w| strip([w[0], w[1]])).collect();
    let model = sew(strips, None, false, &Run::new()).unwrap();
    save_step(&dir.path().join("cross.step"), &model, None).unwrap();
    let args = ["mesh", "cross.step", "-o", "a.stl", "--size", "0.4", "--report", "report.json"];
    rvachev(dir.path()).args(args).assert().code(1).stderr(contains("has no mesh: however it is triangulated"));
    assert!(listed(dir.path(), "shortfalls").iter().any(|s| s.starts_with("face face")));
    assert!(listed(dir.path(), "warnings").iter().all(|w| !w.starts_with("healed")));
}

/// Three triangles that cross each other and bound nothing.
const SCRAPS: &str = "OFF\n9 3 0\n0.13 0.85 0.76\n0.26 0.5 0.45\n0.65 0.79 0.09\n0.03 0.84 0.43\n0.76 0 0.45\n\
0.72 0.23 0.95\n0.9 0.03 0.03\n0.54 0.94 0.38\n0.22 0.42 0.03\n3 0 1 2\n3 3 4 5\n3 6 7 8\n";

#[test]
fn what_cannot_be_healed_is_refused_and_no_mesh_is_written() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("scraps.off"), SCRAPS).unwrap();
    let args = ["mesh", "scraps.off", "-o", "a.off", "--size", "0.3", "--report", "report.json", "--png", "a.png"];
    let run = rvachev(dir.path()).args(args).assert().code(4);
    run.stderr(contains("the mesh is not sound and is not written").and(contains("--force writes it")));
    assert!(!dir.path().join("a.off").exists() && !dir.path().join("a.png").exists());
    // the report is, and tells why
    let report: Value = serde_json::from_slice(&fs::read(dir.path().join("report.json")).unwrap()).unwrap();
    assert!(report["check"]["self_intersections"].as_u64() > Some(0), "{report}");
    let told = listed(dir.path(), "shortfalls");
    assert!(told.iter().any(|s| s.contains("healing found no room to part them")), "{told:?}");
    // triangles without any area
    fs::write(dir.path().join("line.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n").unwrap();
    let args = ["mesh", "line.off", "-o", "a.off", "--report", "line.json"];
    rvachev(dir.path()).args(args).assert().code(4).stderr(contains("no triangle of the mesh has an area"));
    assert!(!dir.path().join("a.off").exists() && !dir.path().join("line.json").exists());
}
