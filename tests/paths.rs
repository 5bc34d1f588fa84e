//! The command that walks over a mesh: exact lengths on a box, for files of every format that can be read, and its own files.

use std::collections::BTreeSet;
use std::fs;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::io::{self, Format, WriteOptions};
use rvachev::pipeline::{MeshOptions, mesh_part};
use serde_json::Value;
use tempfile::TempDir;

const BOX: &str = "part(box((2, 2, 2)))\nmesh(size=0.5)\n";

/// A directory with a box of side 2 around the origin in one format; a file of single precision is as exact as that.
fn boxed(name: &str) -> TempDir {
    let dir = TempDir::new().unwrap();
    let run = Run::new();
    let made = mesh_part(&parse(BOX, &[]).unwrap(), &MeshOptions::default(), &run).unwrap();
    io::write(&dir.path().join(name), &made.mesh, &WriteOptions::default(), &run).unwrap();
    dir
}

fn walk(dir: &TempDir, words: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("rvachev").unwrap().current_dir(dir).arg("path").args(words).assert()
}

fn said(done: assert_cmd::assert::Assert) -> String {
    String::from_utf8(done.success().get_output().stdout.clone()).unwrap()
}

#[test]
fn ways_over_a_box_have_their_lengths_in_every_format_that_is_read() {
    let run = Run::new();
    let mut read = BTreeSet::new();
    for (ending, _) in Format::EXTENSIONS {
        let name = format!("box.{ending}");
        let dir = TempDir::new().unwrap();
        let made = mesh_part(&parse(BOX, &[]).unwrap(), &MeshOptions::default(), &run).unwrap();
        let written = io::write(&dir.path().join(&name), &made.mesh, &WriteOptions::default(), &run);
        if written.is_err() || io::read(&dir.path().join(&name), &run).is_err() {
            continue;
        }
        read.insert(ending);
        // Over one edge between middles of faces, and between opposite corners.
        for (from, to, length) in [("0,0,1", "1,0,0", 2.0), ("-1,-1,-1", "1,1,1", 20f64.sqrt())] {
            let text = said(walk(&dir, &[&name, "--from", from, "--to", to, "-q"]));
            let told: f64 = text.trim().parse().unwrap();
            assert!(abs_diff_eq!(told, length, epsilon = 1e-9), "{name}: {told} {length}");
        }
    }
    for ending in ["stl", "stla", "obj", "ply", "off", "msh", "3mf", "mesh", "inp", "bdf", "nas", "su2", "vtp", "vtu"] {
        assert!(read.contains(ending), "{ending} is not read: {read:?}");
    }
}

#[test]
fn a_way_is_written_as_a_polyline_of_its_length() {
    let dir = boxed("box.off");
    let ends = ["box.off", "--from", "-1,-1,-1", "--to", "1,1,1", "-q"];
    let json: Value =
        serde_json::from_str(&said(walk(&dir, &[&ends[..], &["--json", "-o", "way.csv"]].concat()))).unwrap();
    let points: Vec<[f64; 3]> = serde_json::from_value(json["points"].clone()).unwrap();
    let length: f64 = points.windows(2).map(|w| (0..3).map(|k| (w[1][k] - w[0][k]).powi(2)).sum::<f64>().sqrt()).sum();
    assert_abs_diff_eq!(length, 20f64.sqrt(), epsilon = 1e-9);
    assert_abs_diff_eq!(json["length"].as_f64().unwrap(), length, epsilon = 1e-12);
    assert_eq!((&json["start"], &json["end"]), (&json["points"][0], &json["points"][points.len() - 1]));
    // All of it lies on the box.
    assert!(points.iter().all(|p| (p.iter().map(|x| x.abs()).fold(0.0, f64::max) - 1.0).abs() < 1e-9));
    let rows = fs::read_to_string(dir.path().join("way.csv")).unwrap();
    let row = |l: &str| -> Vec<f64> { l.split(',').map(|x| x.parse().unwrap()).collect() };
    assert_eq!(rows.lines().next(), Some("x,y,z"));
    let read: Vec<Vec<f64>> = rows.lines().skip(1).map(row).collect();
    // Reading JSON may round the last digit.
    let same = |a: &Vec<f64>, b: &[f64; 3]| a.len() == 3 && a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-15);
    assert!(read.len() == points.len() && read.iter().zip(&points).all(|(a, b)| same(a, b)), "{rows}");
    said(walk(&dir, &[&ends[..], &["-o", "way.vtp"]].concat()));
    let vtp = fs::read_to_string(dir.path().join("way.vtp")).unwrap();
    assert!(
        vtp.contains(&format!("NumberOfPoints=\"{}\"", points.len())) && vtp.contains("NumberOfLines=\"1\""),
        "{vtp}"
    );
    let last = &read[read.len() - 1];
    assert!(vtp.contains(&format!("{} {} {}\n", last[0], last[1], last[2])), "{vtp}");
}

#[test]
fn what_is_no_way_is_an_error_and_points_off_the_mesh_are_told() {
    let dir = boxed("box.off");
    walk(&dir, &["box.off", "--from", "0,0,1", "--to", "5,0,0"]).success().stderr(contains("4 away from the mesh"));
    for to in ["1,2", "1,2,x", "1,2,inf", ""] {
        walk(&dir, &["box.off", "--from", "0,0,1", "--to", to]).code(2).stderr(contains("--to"));
    }
    walk(&dir, &["box.off", "--from", "0,0,1", "--to", "1,0,0", "-o", "way.png"]).code(2).stderr(contains(".vtp"));
    walk(&dir, &["none.off", "--from", "0,0,1", "--to", "1,0,0"]).code(3).stderr(contains("none.off"));
    let two = "OFF\n6 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 5\n1 0 5\n0 1 5\n3 0 1 2\n3 3 4 5\n";
    fs::write(dir.path().join("two.off"), two).unwrap();
    let apart = walk(&dir, &["two.off", "--from", "0,0,0", "--to", "0,0,5", "-o", "way.vtp"]);
    apart.code(3).stdout(predicate::str::is_empty()).stderr(contains("do not hang together"));
    assert!(!dir.path().join("way.vtp").exists());
}
