//! What `--help` says, and which keys reports have: compared with the files of `tests/snapshots`. Whoever reads reports by a program
//! learns of a change there from the diff of these files.
//!
//! `RVACHEV_RENEW_SNAPSHOTS=1 cargo test --release --test snapshots` writes the files anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// The variable that has the files written in place of compared.
const RENEW: &str = "RVACHEV_RENEW_SNAPSHOTS";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Compares texts by their names with the files of a folder, or writes these; files of other names are there no more.
fn compare(folder: &str, found: &BTreeMap<String, String>) {
    let folder = root().join("tests/snapshots").join(folder);
    if std::env::var_os(RENEW).is_some() {
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        found.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
        return;
    }
    let names = |paths: Vec<PathBuf>| -> BTreeSet<String> {
        paths.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect()
    };
    let there = names(fs::read_dir(&folder).into_iter().flatten().map(|f| f.unwrap().path()).collect());
    let mut wrong = Vec::new();
    for name in there.iter().filter(|name| !found.contains_key(*name)) {
        wrong.push(format!("{name}: there is nothing of this name"));
    }
    for (name, text) in found {
        let known = fs::read_to_string(folder.join(name)).unwrap_or_default().replace("\r\n", "\n");
        if known != *text {
            wrong.push(format!("{name}:\n{}", difference(&known, text)));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} does not hold what is so:\n\n{}\n\nWhere that is meant, renew the files and look at their diff:\n    \
         {RENEW}=1 cargo test --release --test snapshots\n",
        folder.display(),
        wrong.join("\n\n")
    );
}

/// Lines that only one of two texts has.
fn difference(known: &str, found: &str) -> String {
    let lines = |text: &str| text.lines().map(String::from).collect::<BTreeSet<_>>();
    let (known_lines, found_lines) = (lines(known), lines(found));
    let gone = known.lines().filter(|l| !found_lines.contains(*l)).map(|l| format!("  - {l}"));
    let new = found.lines().filter(|l| !known_lines.contains(*l)).map(|l| format!("  + {l}"));
    let all: Vec<String> = gone.chain(new).collect();
    if all.is_empty() { "  the order of lines is another".into() } else { all.join("\n") }
}

/// What the command prints, which must end with a code of those given.
fn printed(args: &[&str], codes: &[i32], columns: &str) -> String {
    let out =
        Command::cargo_bin("rvachev").unwrap().current_dir(root()).env("COLUMNS", columns).args(args).output().unwrap();
    let err = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code().is_some_and(|c| codes.contains(&c)), "{args:?}: {:?}\n{err}", out.status);
    String::from_utf8(out.stdout).unwrap()
}

// --------------------------------------------------------------------------------------------------------------- help

/// The commands that the help of the whole lists.
fn commands(help: &str) -> Vec<String> {
    let list = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    // Descriptions that go on are indented farther.
    let names = list.filter(|l| l.starts_with("  ") && !l.starts_with("   "));
    names.filter_map(|l| l.split_whitespace().next()).map(String::from).collect()
}

#[test]
fn help_is_as_it_was() {
    let whole = printed(&["--help"], &[0], "80");
    let commands = commands(&whole);
    assert!(commands.len() > 10 && commands.contains(&"mesh".into()), "{commands:?}");
    let mut found = BTreeMap::from([("rvachev.txt".to_string(), whole)]);
    for name in commands.iter().filter(|c| *c != "help") {
        let text = printed(&[name, "--help"], &[0], "80");
        assert_eq!(printed(&[name, "--help"], &[0], "300"), text, "the help of {name} depends on the terminal's width");
        found.insert(format!("{name}.txt"), text);
    }
    compare("help", &found);
}

// ------------------------------------------------------------------------------------------------------------ reports

/// Keys whose numbers follow from the input alone, however it is meshed.
const KNOWN_NUMBERS: &[&str] = &["schema", "components", "euler", "genus", "self_intersections", "corners_true"];

/// Keys whose texts are names, not words that may be said in another way.
const KNOWN_TEXTS: &[&str] = &["method", "units", "unit", "rung", "name", "rsystem"];

/// What stands at each path of a report: the type, or the values where they are stable. Items of lists share a path.
fn shape(at: &str, key: &str, value: &Value, found: &mut BTreeMap<String, BTreeSet<String>>) {
    let what = match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, value) in map {
                let below = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                shape(&below, key, value, found);
            }
            return;
        }
        Value::Array(list) if !list.is_empty() => {
            list.iter().for_each(|item| shape(&format!("{at}[]"), key, item, found));
            return;
        }
        Value::Object(_) => "{}".into(),
        Value::Array(_) => "[]".into(),
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) if KNOWN_NUMBERS.contains(&key) => n.to_string(),
        Value::Number(_) => "#".into(),
        Value::String(s) if KNOWN_TEXTS.contains(&key) => format!("{s:?}"),
        Value::String(_) => "text".into(),
    };
    found.entry(at.into()).or_default().insert(what);
}

fn shape_of(json: &str) -> String {
    let value: Value = serde_json::from_str(json).unwrap_or_else(|e| panic!("{e}\n{json}"));
    let mut found = BTreeMap::new();
    shape("", "", &value, &mut found);
    found
        .iter()
        .map(|(at, what)| format!("{at}: {}\n", Vec::from_iter(what.iter().map(String::as_str)).join(" | ")))
        .collect()
}

#[test]
fn reports_have_the_keys_they_had() {
    let dir = TempDir::new().unwrap();
    let (report, mesh) = (dir.path().join("report.json"), dir.path().join("mesh.off"));
    let (report_name, mesh_name) = (report.to_str().unwrap(), mesh.to_str().unwrap());
    let mut found = BTreeMap::new();
    for (name, file) in
        [("part", "data/cube_with_holes.py"), ("step", "data/step/torus.step"), ("soup", "data/soups/bored_block.off")]
    {
        let args = ["mesh", file, "-o", mesh_name, "--report", report_name, "--size", "5%", "-q"];
        printed(&args, &[0, 1], "80");
        found.insert(format!("mesh_{name}.txt"), shape_of(&fs::read_to_string(&report).unwrap()));
        found.insert(format!("info_{name}.txt"), shape_of(&printed(&["info", file, "--json"], &[0], "80")));
    }
    // A tetrahedron that lacks a face.
    let open = dir.path().join("open.off");
    fs::write(&open, "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n").unwrap();
    for (name, args) in [
        ("check_mesh", &["check", "data/soups/bored_block.off", "--json"][..]),
        ("check_step", &["check", "data/step/torus.step", "--json"][..]),
        ("heal", &["heal", open.to_str().unwrap(), "-o", mesh_name, "--json", "-q"][..]),
    ] {
        found.insert(format!("{name}.txt"), shape_of(&printed(args, &[0, 1], "80")));
    }
    compare("reports", &found);
}

#[test]
fn shapes_show_keys_types_and_stable_values() {
    let json = r#"{"schema": 1, "a": [{"name": "x", "s": 0.5}, {"name": "y", "t": [1, 2]}], "why": "so", "ok": true, "none": []}"#;
    let shape = "a[].name: \"x\" | \"y\"\na[].s: #\na[].t[]: #\nnone: []\nok: true\nschema: 1\nwhy: text\n";
    assert_eq!(shape_of(json), shape);
    assert_eq!(difference("a\nb\n", "a\nc\n"), "  - b\n  + c");
}
