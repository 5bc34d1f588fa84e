//! STEP files meshed with wishes, and models that cannot be meshed altogether: what is asked for holds, what is missing is
//! named.

use std::path::{Path, PathBuf};

use approx::{abs_diff_eq, assert_abs_diff_eq};
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use rvachev::implicit::part::parse;
use rvachev::parametric::Similarity;
use rvachev::pipeline::{MeshOptions, Rung, SizeRequest, brep_info, build, load_step, mesh_part, mesh_step, save_step};
use rvachev::{DVec3, Run};
use serde_json::Value;
use tempfile::TempDir;

fn step(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name)
}

fn rvachev() -> Command {
    Command::cargo_bin("rvachev").unwrap()
}

/// Three squares of one sheet, each sewn to the next along a side; the third one cuts through the first.
const CROSSED: &str = "floor = flat_face(polyline([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], closed=True)).name(\"floor\")\n\
    wall = flat_face(polyline([(0, 0, 0), (0, 2, 0), (0, 2, 1), (0, 0, 1)], closed=True)).name(\"wall\")\n\
    ramp = flat_face(polyline([(0, 0, 1), (0, 2, 1), (2, 2, -1), (2, 0, -1)], closed=True)).name(\"ramp\")\n\
    part(sew([floor, wall, ramp], solid=False).name(\"bent\"))\nmesh(size=0.5)\n";

/// One of the two faces that cross has no mesh: it is named with its rung, the others are sound, and the exit code says so.
#[test]
fn a_face_that_crosses_others_is_left_out_and_named() {
    let part = parse(CROSSED, &[]).unwrap();
    let made = mesh_part(&part, &MeshOptions::default(), &Run::new()).unwrap();
    let report = &made.report;
    let [lost] = &report.ladder.iter().filter(|s| s.rung == Rung::None).collect::<Vec<_>>()[..] else {
        panic!("{:?}", report.ladder)
    };
    assert!(lost.face == "bent.floor.face" || lost.face == "bent.ramp.face", "{lost:?}");
    assert!(
        report.shortfalls.iter().any(|s| s.to_string().contains(&lost.face) && s.to_string().contains("no mesh")),
        "{:?}",
        report.shortfalls
    );
    assert_eq!(report.check.as_ref().unwrap().self_intersections, 0);
    let with = |name: &str| {
        let f = made.mesh.faces.iter().position(|n| n.contains(name));
        f.is_some_and(|f| made.mesh.labels.contains(&(f as u32)))
    };
    assert!(with("wall") && with("floor") != with("ramp"));

    let dir = TempDir::new().unwrap();
    let brep = build(&part, &Run::new()).unwrap().unwrap();
    save_step(&dir.path().join("bent.step"), &brep, None).unwrap();
    rvachev()
        .current_dir(&dir)
        .args(["mesh", "bent.step", "-o", "bent.off", "--size", "0.5", "--report", "r.json"])
        .assert()
        .code(1)
        .stderr(contains("has no mesh").and(contains(&lost.face)));
    let told: Value = serde_json::from_str(&std::fs::read_to_string(dir.path().join("r.json")).unwrap()).unwrap();
    let rungs = told["ladder"].as_array().unwrap();
    assert!(rungs.iter().any(|s| s["rung"] == "none" && s["face"] == lost.face.as_str()), "{rungs:?}");
    assert!(dir.path().join("bent.off").exists());
}

/// What `--tol` promises holds at points of every triangle, against the true sphere and the true torus.
#[test]
fn a_distance_asked_for_is_kept_on_step_files() {
    let sphere: fn(DVec3) -> f64 = |p| (p.length() - 2.0).abs();
    let torus: fn(DVec3) -> f64 = |p| ((p.truncate().length() - 3.0).hypot(p.z) - 1.0).abs();
    for (name, away) in [("sphere.step", sphere), ("torus.step", torus)] {
        for tolerance in [0.02, 0.003] {
            let how = MeshOptions {
                tolerance: Some(SizeRequest::Length(tolerance)),
                size: Some(SizeRequest::Share(0.2)),
                ..MeshOptions::default()
            };
            let made = mesh_step(load_step(&step(name), &Run::new()).unwrap(), &how, &Run::new()).unwrap();
            assert!(made.report.shortfalls.is_empty(), "{name}: {:?}", made.report.shortfalls);
            assert!(made.report.check.as_ref().unwrap().certificate.is_sound(), "{name}");
            let told = made.report.distance.unwrap();
            let m = &made.mesh;
            let places = (0..m.triangles.len()).flat_map(|t| {
                let [a, b, c] = m.corners(t);
                [m.centroid(t), 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]
            });
            let deepest = places.map(away).fold(0.0, f64::max);
            assert!(deepest <= tolerance, "{name}: {deepest} of {tolerance}");
            assert!(
                abs_diff_eq!(told.to_surface, deepest, epsilon = 1e-9 + 0.01 * tolerance),
                "{name}: {deepest} {told:?}"
            );
            assert_eq!((told.asked, told.beyond), (Some(tolerance), 0), "{name}");
        }
    }
    // The sizes follow the distance, not the other way round.
    let count = |tolerance: f64| {
        let how = MeshOptions {
            tolerance: Some(SizeRequest::Length(tolerance)),
            size: Some(SizeRequest::Share(0.5)),
            ..MeshOptions::default()
        };
        let made = mesh_step(load_step(&step("sphere.step"), &Run::new()).unwrap(), &how, &Run::new()).unwrap();
        made.mesh.triangles.len()
    };
    assert!(count(0.002) > 4 * count(0.02));
}

/// Parts of a STEP model are meshed as finely as asked for, by a box, a ball and a face's name; elsewhere little changes.
#[test]
fn places_of_step_files_are_refined() {
    let dir = TempDir::new().unwrap();
    let file = step("torus.step");
    let mesh = |more: &[&str]| {
        rvachev()
            .current_dir(&dir)
            .args([
                "mesh",
                file.to_str().unwrap(),
                "-o",
                "t.off",
                "--size",
                "0.5",
                "--force",
                "-q",
                "--report",
                "r.json",
            ])
            .args(more)
            .assert()
            .success();
        let report: Value = serde_json::from_str(&std::fs::read_to_string(dir.path().join("r.json")).unwrap()).unwrap();
        let read = rvachev::io::read(&dir.path().join("t.off"), &Run::new()).unwrap();
        (read, report)
    };
    let longest = |m: &rvachev::mesh::TriMesh, at: DVec3, within: f64| {
        let near = (0..m.triangles.len()).filter(|t| m.centroid(*t).distance(at) < within);
        let lengths = near.map(|t| {
            let [a, b, c] = m.corners(t);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        });
        lengths.fold(0.0, f64::max)
    };
    let (at, far) = (DVec3::new(4.0, 0.0, 0.0), DVec3::new(-4.0, 0.0, 0.0));
    let (plain, _) = mesh(&[]);
    let bend = longest(&plain, at, 0.5);
    let wish = 0.4 * bend;
    for place in [format!("box=3.5,-1,-1,4.5,1,1:{wish}"), format!("sphere=4,0,0,0.8:{wish}")] {
        let (fine, report) = mesh(&["--refine", &place]);
        assert!(longest(&fine, at, 0.5) < 0.7 * bend, "{place}: {} {bend}", longest(&fine, at, 0.5));
        assert!(longest(&fine, far, 0.5) > 0.8 * longest(&plain, far, 0.5), "{place}");
        assert_eq!(report["check"]["self_intersections"], 0, "{place}");
    }
    let (fine, _) = mesh(&["--refine", &format!("face=*:{wish}")]);
    assert!(longest(&fine, far, 1.0) < 0.7 * bend && longest(&fine, at, 1.0) < 0.7 * bend);
    let wrong = rvachev()
        .current_dir(&dir)
        .args(["mesh", file.to_str().unwrap(), "-o", "t.off", "--refine", "face=nothing:0.2"])
        .assert()
        .code(2);
    let told = String::from_utf8_lossy(&wrong.get_output().stderr).into_owned();
    assert!(told.contains("\"nothing\"") && told.contains("nearest"), "{told}");
}

/// After Boolean operations files may give a closed edge two vertices, both at one place.
#[test]
fn two_vertices_at_one_place_close_an_edge() {
    let part = parse("part(extrude_edges(circle(2), \"z\", 3).name(\"rod\"))\nmesh(size=0.5)\n", &[]).unwrap();
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("rod.step");
    save_step(&path, &build(&part, &Run::new()).unwrap().unwrap(), None).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let closed = text.lines().find_map(|l| {
        let (head, rest) = l.split_once("EDGE_CURVE('',")?;
        let mut parts = rest.splitn(3, ',');
        let (a, b, rest) = (parts.next()?, parts.next()?, parts.next()?);
        (a == b).then(|| (l.to_string(), a.to_string(), format!("{head}EDGE_CURVE('',{a},#900001,{rest}")))
    });
    let (line, vertex, changed) = closed.expect("a closed edge");
    let record = text.lines().find(|l| l.starts_with(&format!("{vertex}="))).expect("its vertex");
    let double = record.replacen(&vertex, "#900001", 1);
    std::fs::write(&path, text.replacen(&line, &format!("{changed}\n{double}"), 1)).unwrap();
    let made = mesh_step(load_step(&path, &Run::new()).unwrap(), &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    let check = made.report.check.unwrap();
    assert!(check.certificate.is_sound());
    assert_abs_diff_eq!(check.volume.unwrap() / (12.0 * std::f64::consts::PI), 1.0, epsilon = 0.02);
}

#[test]
fn boxes_are_exact_however_a_model_is_turned() {
    let run = Run::new();
    let rotation = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.1);
    let axis = rotation * DVec3::Z;
    let across = (DVec3::ONE - axis * axis).map(f64::sqrt);
    // Half sides along x, y and z about the middle; the cylinder's file is in inches.
    let cases: [(&str, DVec3, DVec3); 3] = [
        ("sphere", DVec3::splat(2.0), DVec3::ZERO),
        ("torus", across * 3.0 + 1.0, DVec3::ZERO),
        ("cylinder_without_seam", across * 50.8 + axis.abs() * 38.1, DVec3::Z * 38.1),
    ];
    for (name, half, middle) in cases {
        let model =
            load_step(Path::new(&format!("{}/data/step/{name}.step", env!("CARGO_MANIFEST_DIR"))), &run).unwrap();
        let turned = model.brep.moved(&Similarity { scale: 1.0, rotation, translation: DVec3::ZERO });
        let info = brep_info(turned.into(), None, &run).unwrap();
        let (lo, hi) = (DVec3::from_array(info.bounds.lo), DVec3::from_array(info.bounds.hi));
        let off = (lo - (rotation * middle - half)).abs().max((hi - (rotation * middle + half)).abs());
        assert!(off.max_element() < 1e-9 * half.max_element(), "{name}: {lo} to {hi}, off by {off}");
    }
}
