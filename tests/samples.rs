//! `compare --samples`: three cubes with holes by every method, as the library tells it and as the command shows it.

use std::fs;
use std::process::Command;
use std::sync::OnceLock;

use rvachev::pipeline::{Method, Sample};
use serde_json::Value;
use tempfile::TempDir;

/// What the command left: its table, its rows and its picture's width and height.
struct Ran {
    table: String,
    rows: Value,
    picture: [u32; 2],
}

/// The command is run once for all tests, as it takes a while.
fn ran() -> &'static Ran {
    static RAN: OnceLock<Ran> = OnceLock::new();
    RAN.get_or_init(|| {
        let dir = TempDir::new().unwrap();
        let args = ["compare", "--samples", "--size", "0.1", "--json", "s.json", "--png", "s.png"];
        let out = Command::new(env!("CARGO_BIN_EXE_rvachev")).args(args).current_dir(&dir).output().unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let file = |name: &str| fs::read(dir.path().join(name)).unwrap();
        let png = file("s.png");
        let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        Ran {
            table: String::from_utf8(out.stdout).unwrap(),
            rows: serde_json::from_slice(&file("s.json")).unwrap(),
            picture: [side(16), side(20)],
        }
    })
}

/// The rows of one method, by sample.
fn rows_of(method: Method) -> Vec<&'static Value> {
    ran().rows["rows"].as_array().unwrap().iter().filter(|r| r["method"] == method.name()).collect()
}

fn feature(row: &Value, what: &str) -> f64 {
    row["check"]["features"][what].as_f64().unwrap()
}

#[test]
fn rows_go_by_sample_then_by_method() {
    let rows = ran().rows["rows"].as_array().unwrap();
    let told: Vec<[&str; 2]> = rows.iter().map(|r| ["sample", "method"].map(|k| r[k].as_str().unwrap())).collect();
    let wanted: Vec<[&str; 2]> = Sample::ALL.iter().flat_map(|s| Method::ALL.map(|m| [s.name, m.name()])).collect();
    assert_eq!(told, wanted);
    assert_eq!(ran().rows["size"], 0.1);
    let lines: Vec<Vec<&str>> = ran().table.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(lines[0][..4], ["sample", "method", "tri", "closed"]);
    for (line, row) in lines[1..].iter().zip(&wanted) {
        assert_eq!(line[..2], row[..]);
        assert_eq!(line[3], "yes");
        assert!(line.last().unwrap().parse::<f64>().unwrap() >= 0.0, "{line:?}");
    }
    // The table's head, its rows, and two lines that tell what is in it.
    assert_eq!(lines.len(), 1 + wanted.len() + 2);
}

#[test]
fn the_default_finds_all_and_marching_cubes_next_to_nothing() {
    let corners = [8.0, 8.0, 12.0];
    let order = ["centered", "rotated", "edge"];
    let of = |method, sample: &str| rows_of(method).into_iter().find(|r| r["sample"] == sample).unwrap();
    for (sample, corners) in order.into_iter().zip(corners) {
        let leaf = of(Method::default(), sample);
        assert!(feature(leaf, "recall") > 0.9995 && feature(leaf, "precision") > 0.999, "{sample}");
        assert_eq!([feature(leaf, "corners_found"), feature(leaf, "corners_true")], [corners; 2], "{sample}");
        assert_eq!(leaf["check"]["self_intersections"], 0, "{sample}");
        let operators = of(Method::Operators, sample);
        assert!(feature(operators, "recall") >= 0.99, "{sample} {}", feature(operators, "recall"));
        assert_eq!(feature(operators, "corners_found"), corners, "{sample}");
        let mc = of(Method::MarchingCubes, sample);
        assert!(feature(mc, "recall") < 0.5, "{sample} {}", feature(mc, "recall"));
        assert!(feature(mc, "corners_found") < corners, "{sample}");
        // Classes are those of fig. 4: as many corners as there are.
        assert_eq!(operators["classes"][2], corners, "{sample}");
        let angle = |row: &Value| row["check"]["quality"]["min_angle"].as_f64().unwrap();
        assert!(angle(leaf) > angle(operators) && angle(operators) > angle(mc), "{sample}");
    }
}

#[test]
fn the_picture_has_a_row_for_each_sample_and_a_column_for_each_method() {
    // Cells of 560 x 520 with gaps of 12 around them and captions of 18 below.
    let (columns, rows) = (Method::ALL.len() as u32, Sample::ALL.len() as u32);
    assert_eq!(ran().picture, [columns * (560 + 12) + 12, rows * (520 + 12 + 18 + 12) + 12]);
}

#[test]
fn samples_are_the_files_of_the_same_names_and_stand_alone() {
    for sample in Sample::ALL {
        let path = format!("{}/{}", env!("CARGO_MANIFEST_DIR"), sample.file);
        assert_eq!(fs::read_to_string(path).unwrap(), sample.text);
        assert!(sample.part().unwrap().solid.is_some(), "{}", sample.name);
    }
    for args in [
        &["a.py", "--samples"][..],
        &["--samples", "-D", "side=3"],
        &["--samples", "--rsystems"],
        &["--samples", "--color", "class"],
        &["--samples", "--close"],
        &[],
    ] {
        let out = Command::new(env!("CARGO_BIN_EXE_rvachev")).arg("compare").args(args).output().unwrap();
        assert_eq!(out.status.code(), Some(2), "{args:?}");
    }
}
