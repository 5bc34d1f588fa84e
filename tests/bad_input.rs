//! What the command answers to input that is no good: a message, a place, a code, and nothing left behind.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use tempfile::TempDir;

/// The part every case about something else is made with.
const GOOD: &str = "part(sphere(1))\n";

/// Runs the command in a folder that holds the given file, expects a code and words on standard error, and no file more.
fn refused(file: &str, bytes: &[u8], args: &[&str], code: i32, says: &[&str]) {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join(file), bytes).unwrap();
    let start = Instant::now();
    let out = Command::cargo_bin("rvachev").unwrap().current_dir(&dir).args(args).output().unwrap();
    let err = String::from_utf8_lossy(&out.stderr);
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    assert_eq!(out.status.code(), Some(code), "{args:?}\n{shown}\n{err}");
    for s in says {
        assert!(err.contains(s), "{args:?}\n{shown}\n{err}\nsays nothing of {s}");
    }
    assert!(out.stdout.is_empty(), "{}", String::from_utf8_lossy(&out.stdout));
    assert!(start.elapsed() < Duration::from_secs(20), "{args:?}\n{shown}\n{:?}", start.elapsed());
    only(dir.path(), file);
}

fn only(dir: &Path, file: &str) {
    let left: Vec<_> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name()).filter(|n| n != file).collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

/// The cylinder whose surface, and nothing else, is a thousand times as wide.
fn wide_cylinder() -> String {
    let text = include_str!("../data/step/cylinder_without_seam.step");
    text.replace("CYLINDRICAL_SURFACE('',#7,2.)", "CYLINDRICAL_SURFACE('',#7,2000.)")
}

#[test]
fn more_triangles_than_the_memory_holds_are_refused_at_every_gate() {
    // A tenth of a GiB holds 214 748 triangles of 500 bytes.
    let limit = ["--memory", "0.1"];
    let says =
        ["triangles are expected", "GiB of memory, more than the 0.100 allowed", "--size", "--memory allows more"];
    let mesh =
        |file: &'static str, size: &'static str| [&["mesh", file, "-o", "a.off", "--size", size][..], &limit].concat();
    let wide = wide_cylinder();
    refused("a.step", wide.as_bytes(), &mesh("a.step", "2%"), 2, &says);
    let sphere = include_bytes!("../data/step/sphere.step");
    refused("a.step", sphere, &mesh("a.step", "0.02%"), 2, &says);
    let tetrahedron = b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    refused(
        "a.off",
        tetrahedron,
        &[&["mesh", "a.off", "-o", "b.off", "--size", "0.002"][..], &limit].concat(),
        2,
        &says,
    );
    // Its area is 1.5 and half the root of 3: so many equilateral triangles of 0.433 times the square of the size.
    let all = (1.5 + 3f64.sqrt() / 2.0) / (0.433 * 0.002 * 0.002);
    let told = format!("about {all:.0} triangles are expected");
    refused(
        "a.off",
        tetrahedron,
        &[&["mesh", "a.off", "-o", "b.off", "--size", "0.002"][..], &limit].concat(),
        2,
        &[&told],
    );
    let joined = b"part(loft([polyline([(0, 0, 0), (1, 0, 0), (0, 1, 0)], closed=True), (0, 0, 1)]) - sphere(0.2))\n";
    refused("a.py", joined, &mesh("a.py", "0.002"), 2, &says);
}

#[test]
fn lengths_whose_squares_are_no_numbers_are_an_error_of_their_entity() {
    let text = include_str!("../data/step/cone_with_apex.step");
    let far = text.replace("CIRCLE('',#7,2.)", "CIRCLE('',#7,2.E+300)");
    let far = far.replace("CONICAL_SURFACE('',#17,2.,", "CONICAL_SURFACE('',#17,2.E+300,");
    let says = ["#", "CIRCLE: argument 3 is not within 1e150"];
    refused("a.step", far.as_bytes(), &["mesh", "a.step", "-o", "a.off"], 3, &says);
    let points = b"OFF\n4 4 0\n0 0 0\n1e300 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    refused("a.off", points, &["mesh", "a.off", "-o", "b.off"], 3, &["1e150 is the most"]);
}

/// Part files with their mistake, its place and the words for it.
const PARTS: &[(&str, &[&str])] = &[
    ("part(sphere(1)\n", &["line 2, column 1", "syntax error"]),
    ("a = 1\npart(spher(1))\n", &["line 2, column 6", "nothing is called \"spher\"", "did you mean \"sphere\"?"]),
    ("import os\n", &["line 1, column 1", "are not part of the part language"]),
    ("part(sphere(1))\nwhile True:\n    pass\n", &["line 2, column 1", "loops are not part"]),
    ("units('parsec')\npart(sphere(1))\n", &["line 1, column 1", "unknown unit \"parsec\"", "known: m, dm"]),
    ("part(sphere(-1))\n", &["line 1, column 13", "must be positive, not -1"]),
    ("a = 1/0\npart(sphere(1))\n", &["line 1, column 5", "division by zero"]),
    ("part(solid(x >= asin(2)))\n", &["line 1, column 17", "asin() is not a finite number"]),
    ("part(solid(mod(x, 0) >= 1))\n", &["line 1, column 12", "division by zero"]),
    ("part(solid(x % 0 >= 1))\n", &["line 1, column 12", "division by zero"]),
    ("part(solid(x >= sqrt(-1)))\n", &["line 1, column 17", "sqrt() is not a finite number"]),
    ("mesh(size=0)\npart(sphere(1))\n", &["line 1, column 11", "must be positive, not 0"]),
    ("mesh(size='-2%')\npart(sphere(1))\n", &["line 1, column 11", "a size is a positive length or a share"]),
    ("x = 1\n", &["line 2, column 1", "declares no part"]),
    ("", &["line 1, column 1", "declares no part"]),
    // What is known only of the whole solid stands at the operand at fault, or at the part.
    ("s = sphere(1)\npart(s - s)\n", &["line 2, column 6: the solid is empty"]),
    (
        "part(box((1, 1, 1)) & box((1, 1, 1), at=(9, 0, 0)))\n",
        &["line 1, column 6: the solid is empty", "this and the solid at line 1, column 23 have nothing in common"],
    ),
    (
        "a = sphere(1)\nb = sphere(1, at=(9, 0, 0))\npart(a & b)\n",
        &["line 1, column 5: the solid is empty", "this and the solid at line 2, column 5 have nothing in common"],
    ),
    ("a = sphere(1)\nb = a - sphere(2)\npart(box((9, 9, 9)) & b)\n", &["line 2, column 5: the solid is empty"]),
    (
        "part(sphere(1), domain=((5, 5, 5), (6, 6, 6)))\n",
        &["line 1, column 1: the solid is empty", "the domain holds none of it"],
    ),
    (
        "rod = cylinder(1)\npart(union([sphere(3), rod.move((5, 0, 0)), box((1, 1, 1))]))\n",
        &["line 1, column 7: the solid may be infinite"],
    ),
    ("part(cylinder(1))\n", &["line 1, column 6: the solid may be infinite", "domain=((x0, y0, z0), (x1, y1, z1))"]),
    ("part(~sphere(1))\n", &["line 1, column 6: the solid may be infinite", "domain="]),
    // what is known only of a point has that
    ("part(solid(log(x) + 0.5 >= 0) & box((2, 2, 2)))\n", &["at (", "finite"]),
    ("part(solid(1 / (x - 0.123) >= 0) & box((2, 2, 2)))\n", &["at (", "pole"]),
    ("part(sphere(1) - sphere(0.9999999))\n", &["at (", "thinner than the cells of size 0.1", "--size"]),
];

#[test]
fn bad_parts_are_refused_with_their_place() {
    for (source, says) in PARTS {
        let says: Vec<&str> = says.iter().copied().chain(["part.py"]).collect();
        let args = ["mesh", "part.py", "-o", "out.off", "--report", "r.json", "--png", "p.png", "--size", "0.1"];
        refused("part.py", source.as_bytes(), &args, 3, &says);
    }
    let not_text = b"part(sphere(\xff\xfe))";
    refused("part.py", not_text, &["mesh", "part.py", "-o", "a.off"], 3, &["part.py", "byte 12", "UTF-8"]);
    refused("part.py", b"", &["mesh", "none.py", "-o", "a.off"], 3, &["cannot read none.py"]);
    refused("part.py", b"1 +", &["info", "part.py"], 3, &["part.py", "line 1", "syntax error"]);
    refused("part.py", b"1 +", &["compare", "part.py", "--json", "c.json"], 3, &["part.py", "line 1", "syntax error"]);
}

#[test]
fn bad_requests_are_usage_errors() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["--size", "0"], &["--size", "a positive length or a share such as 2%"]),
        (&["--size=-1"], &["--size", "positive"]),
        (&["--size", "nan"], &["--size", "positive"]),
        (&["--size", "1e-5"], &["size 0.00001 needs about", "GiB", "more than the 8.0 GiB allowed"]),
        (&["--size", "1e-3", "--memory", "0.001"], &["needs about", "MiB of memory"]),
        (&["--size", "1e-12"], &["size 0.000000000001 is too small"]),
        (&["--method", "magic"], &["mc, paper, operators, cut, leaf"]),
        (&["-D", "radius"], &["NAME=VALUE"]),
        (&["-D", "nobody=1"], &["nobody", "no number is assigned"]),
        (&["-D", "r=nan"], &["-D r", "finite"]),
        (&["--threads", "x"], &["threads"]),
        (&["-o", "a.xyz"], &["a.xyz", "unknown extension .xyz", ".stl"]),
        (&["-o", "mesh"], &["no extension"]),
        (&["-o", "no/such/folder/a.off"], &["the folder no/such/folder does not exist"]),
        (&["--png", "no/such/folder/a.png"], &["no/such/folder"]),
        (&["--report", "no/such/folder/a.json"], &["no/such/folder"]),
    ];
    for (args, says) in cases {
        let args: Vec<&str> = ["mesh", "part.py", "-o", "out.off"].iter().chain(*args).copied().collect();
        refused("part.py", format!("r = 1\n{GOOD}").as_bytes(), &args, 2, says);
    }
    refused("part.py", b"", &[], 2, &["Usage"]);
}

#[test]
fn bad_meshes_are_refused_with_their_place() {
    let mut cut = vec![0u8; 84];
    cut[80] = 100;
    let mut nan = vec![0u8; 84 + 50];
    nan[80] = 1;
    nan[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let cases: &[(&str, &[u8], &[&str])] = &[
        ("cut.stl", &cut, &["byte 80", "cut off: it promises 100 triangles"]),
        ("short.stl", &cut[..50], &["byte 50", "cut off"]),
        ("nan.stl", &nan, &["byte 96", "not finite"]),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", &["line 4", "uses node 9, but the file has 3"]),
        ("zero.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", &["line 4", "begin at 1, not 0"]),
        ("nan.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["line 1", "finite"]),
        ("nan.off", b"OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", &["line 3", "finite"]),
        ("index.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", &["line 6", "uses node 7"]),
        ("bare.obj", b"v 0 0 0\n", &["holds no triangle"]),
        ("empty.stl", b"", &["the file is empty"]),
        ("empty.obj", b"", &["the file is empty"]),
        ("empty.ply", b"", &["the file is empty"]),
        ("empty.off", b"", &["the file is empty"]),
        ("empty.msh", b"", &["the file is empty"]),
        ("index.inp", b"*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=S3\n1, 1, 2, 3\n", &["line 4", "uses node 2"]),
        ("index.bdf", b"GRID,1,,0.,0.,0.\nCTRIA3,1,1,1,2,3\n", &["line 2", "uses node 2"]),
        ("short.mesh", b"MeshVersionFormatted 2\nVertices\n4000000000\n0 0 0 0\n", &["line 3", "do not fit"]),
        ("short.su2", b"NDIME= 3\nNPOIN= 4000000000\n0 0 0\n", &["line 3", "the file ends here"]),
        ("cut.vtp", b"<VTKFile type=\"PolyData\">", &["line 1", "no XML"]),
        ("other.vtu", b"<VTKFile type=\"PolyData\"/>", &["line 1", "UnstructuredGrid"]),
    ];
    for (name, bytes, says) in cases {
        let says: Vec<&str> = says.iter().copied().chain([*name]).collect();
        refused(name, bytes, &["check", name], 3, &says);
        refused(name, bytes, &["render", name, "-o", "out.png"], 3, &says);
    }
    refused("a.off", b"", &["check", "none.off"], 3, &["cannot read none.off"]);
    refused("a.xyz", b"", &["check", "a.xyz"], 2, &["unknown extension .xyz"]);
}

/// What can be made but falls short of what was asked is made, named and told by the code.
#[test]
fn what_falls_short_gives_a_result_and_code_1() {
    let dir = TempDir::new().unwrap();
    let run = |args: &[&str]| Command::cargo_bin("rvachev").unwrap().current_dir(&dir).args(args).assert();
    let source = "part(box(lo=(-1, -1, 0), hi=(1, 1, 0.05)).name('plate') | box(lo=(-1, -1, 0), hi=(-0.5, 1, 1)))\n";
    fs::write(dir.path().join("part.py"), source).unwrap();
    run(&["mesh", "part.py", "-o", "out.off", "--size", "0.1", "--method", "mc"]).code(1).stderr(
        contains("plate")
            .and(contains("thickness 0.05"))
            .and(contains("below the cell size 0.1"))
            .and(contains("at (")),
    );
    assert!(dir.path().join("out.off").exists());
    // by exact edges both sides of the wall are in the mesh
    run(&["mesh", "part.py", "-o", "out.off", "--size", "0.1"]).code(0).stderr(contains("thickness").not());
    // a mesh that can be read but is open
    fs::write(dir.path().join("open.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    run(&["check", "open.off", "--json"]).code(1).stdout(contains("\"closed\": false"));
}

#[test]
fn an_old_file_stays_as_it_was() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), "part(sphere(0))\n").unwrap();
    fs::write(dir.path().join("out.off"), "precious").unwrap();
    let args = ["mesh", "part.py", "-o", "out.off"];
    Command::cargo_bin("rvachev").unwrap().current_dir(&dir).args(args).assert().code(3);
    assert_eq!(fs::read_to_string(dir.path().join("out.off")).unwrap(), "precious");
}

/// Runs the command on a part file with so many KiB of address space.
#[cfg(target_os = "linux")]
fn within(kib: usize, part: &str, args: &str) -> std::process::Output {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("part.py"), part).unwrap();
    let command = assert_cmd::cargo::cargo_bin("rvachev");
    let line = format!("ulimit -v {kib}; exec {} mesh part.py -o part.off --threads 1 {args}", command.display());
    Command::new("sh").args(["-c", &line]).current_dir(&dir).output().unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn a_stack_that_cannot_be_had_is_an_error() {
    let out = within(500_000, "part(box((1, 1, 1)))\n", "--size 0.5");
    let err = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(4) && err.contains("cannot start a thread to read the part file"), "{err}");
}

#[test]
#[cfg(target_os = "linux")]
fn memory_that_cannot_be_had_ends_the_command_in_one_line() {
    let out = within(1_500_000, "part(sphere(1))\n", "--size 0.002 --memory 64");
    let err = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(4), "{err}");
    assert_eq!(err.lines().filter(|l| l.starts_with("error: out of memory: ")).count(), 1, "{err}");
    assert!(!err.contains("RUST_BACKTRACE"), "{err}");
}
