//! The library for C: programs in C, C++ and Fortran, compiled and run. `tests/header.rs` compares its header with the source.
//!
//! Needs a compiler of each: `cc`, `c++`, `gfortran`, or what `CC`, `CXX` and `FC` name; and `pkg-config`. What is missing fails, saying so.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use approx::abs_diff_eq;
use rvachev::implicit::part::parse;
use rvachev::pipeline::{build, save_step};
use serde_json::{Value, json};

#[path = "capi/looks.rs"]
mod looks;
#[path = "capi/told.rs"]
mod told_of;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs to the end; all it printed if it failed.
fn done(command: &mut Command) -> Result<Output, String> {
    let out = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if out.status.success() {
        return Ok(out);
    }
    let said = [&out.stdout[..], &out.stderr[..]].concat();
    Err(format!("{command:?}: {}\n{}", out.status, String::from_utf8_lossy(&said)))
}

/// The folder the library is in, built once.
fn library() -> &'static Path {
    static BUILT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("");
        done(
            Command::new(env!("CARGO"))
                .current_dir(root())
                .args(["build", "--release", "--quiet", "-p", "rvachev-capi", "--target-dir"])
                .arg(&target),
        )?;
        Ok(target.join("release"))
    });
    built.as_deref().unwrap_or_else(|why| panic!("the library for C cannot be built: {why}"))
}

/// A language: how its compiler is named, and how it is installed.
struct Language {
    variable: &'static str,
    usual: &'static str,
    package: &'static str,
    flags: &'static [&'static str],
}

const C: Language = Language {
    variable: "CC",
    usual: "cc",
    package: "gcc",
    flags: &["-std=c99", "-D_POSIX_C_SOURCE=200809L", "-pedantic", "-Wall", "-Wextra", "-Werror"],
};
const CPP: Language = Language {
    variable: "CXX",
    usual: "c++",
    package: "g++",
    flags: &["-std=c++17", "-pedantic", "-Wall", "-Wextra", "-Werror"],
};
const FORTRAN: Language = Language {
    variable: "FC",
    usual: "gfortran",
    package: "gfortran",
    flags: &["-std=f2018", "-Wall", "-Wextra", "-Werror"],
};

impl Language {
    fn compiler(&self) -> Command {
        let name = std::env::var(self.variable).unwrap_or_else(|_| self.usual.into());
        if Command::new(&name).arg("--version").output().is_err() {
            let (package, variable) = (self.package, self.variable);
            panic!(
                "there is no compiler {name:?}: install one (Debian: apt install {package}) or name it by {variable}"
            );
        }
        Command::new(name)
    }

    /// A program made of sources and the library.
    fn program(&self, name: &str, sources: &[&str]) -> PathBuf {
        let library = library();
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi").join(name);
        fs::create_dir_all(&folder).unwrap();
        let program = folder.join(name);
        let mut command = self.compiler();
        // Modules of Fortran are written into the folder compiled in.
        command.current_dir(&folder).args(self.flags).args(["-O1", "-g", "-pthread"]);
        command.arg("-I").arg(root().join("capi/include"));
        command.args(sources.iter().map(|s| root().join(s))).arg("-o").arg(&program);
        command.arg("-L").arg(library).args(["-lrvachev_c", "-lm"]);
        command.arg(format!("-Wl,-rpath,{}", library.display()));
        done(&mut command).unwrap_or_else(|why| panic!("{why}"));
        program
    }
}

/// What a program that must end well prints.
fn said(command: &mut Command) -> String {
    let out = done(command).unwrap_or_else(|why| panic!("{why}"));
    String::from_utf8_lossy(&out.stdout).into_owned()
}

/// The number that follows a word, on the line that starts with another.
fn number(text: &str, line: &str, word: &str) -> f64 {
    let found = text.lines().find(|l| l.starts_with(line)).unwrap_or_else(|| panic!("no line {line:?} in\n{text}"));
    let mut words = found.split_whitespace().skip_while(|w| *w != word);
    words.nth(1).and_then(|w| w.parse().ok()).unwrap_or_else(|| panic!("no {word:?} in {found:?}"))
}

/// Whether a number is as near another as this share of it.
fn near(found: f64, wanted: f64, share: f64) -> bool {
    (found - wanted).abs() <= share * wanted.abs()
}

/// The volume of the unit ball without a cylinder of radius r through its middle.
fn bored(r: f64) -> f64 {
    4.0 / 3.0 * PI * (1.0 - r * r).powf(1.5)
}

#[test]
fn c_part_becomes_arrays() {
    let program = C.program("mesh_part", &["examples/c/mesh_part.c"]);
    let file = program.with_extension("msh");
    let text = said(Command::new(&program).arg(&file));
    assert!(near(number(&text, "volume", "volume"), 8.0 - 2.0 * PI * 0.25, 2e-3), "{text}");
    assert!(near(number(&text, "volume", "area_held"), 2.0 * PI, 5e-3), "{text}");
    assert!(number(&text, "volume", "off_held") < 1e-9, "{text}");
    assert_eq!(number(&text, "points", "sound"), 1.0, "{text}");
    // A torus with triangles: V - E + F = 0, E = 3/2 F.
    assert_eq!(2.0 * number(&text, "points", "points"), number(&text, "points", "triangles"), "{text}");
    assert_eq!(number(&text, "points", "labels"), number(&text, "points", "triangles"), "{text}");
    assert_eq!(number(&text, "points", "normals"), number(&text, "points", "triangles"), "{text}");
    assert_eq!(number(&text, "points", "faces"), 7.0, "{text}");
    assert!(text.contains("face bore\n") && text.contains("face body.xmin\n"), "{text}");
    assert!(text.contains("report {\"schema\":1"), "{text}");
    let read = rvachev::io::read(&file, &rvachev::Run::new()).unwrap();
    assert_eq!(read.nodes.len() as f64, number(&text, "points", "points"));
    assert!(file.with_extension("names.json").exists());
}

#[test]
fn c_function_and_grid_become_a_solid() {
    let program = C.program("field_c", &["examples/c/field.c"]);
    let text = said(&mut Command::new(&program));
    assert!(near(number(&text, "function", "volume"), bored(0.4), 1e-2), "{text}");
    // Trilinear between points 0.06 apart: off by up to h^2 / 8 times the curvature, inwards.
    assert!(near(number(&text, "grid", "volume"), bored(0.4), 1.5e-2), "{text}");
    assert!(number(&text, "function", "bore") > 50.0 && number(&text, "grid", "bore") > 50.0, "{text}");
}

#[test]
fn cpp_function_becomes_a_solid() {
    let program = CPP.program("field_cpp", &["examples/cpp/field.cpp"]);
    let text = said(&mut Command::new(&program));
    assert!(near(number(&text, "half", "volume"), 2.0 / 3.0 * PI, 1e-2), "{text}");
    assert!(near(number(&text, "half", "flat"), PI, 1e-2), "{text}");
    assert_eq!(number(&text, "half", "sound"), 1.0, "{text}");
    assert_eq!(number(&text, "half", "shortfalls"), 0.0, "{text}");
    assert!(near(number(&text, "values", "inside"), 0.5, 1e-6), "{text}");
    assert!(near(number(&text, "values", "outside"), -0.1, 1e-5), "{text}");
    assert!(near(number(&text, "values", "slope"), -1.0, 1e-6), "{text}");
    assert_eq!(number(&text, "again", "sound"), 1.0, "{text}");
    assert!(number(&text, "again", "triangles") > 100.0, "{text}");
    assert!(text.contains("thrown no value right of 0.1"), "{text}");
    assert!(text.contains("error status 3 line 1 column 10"), "{text}");
}

#[test]
fn fortran_function_becomes_a_solid() {
    let program = FORTRAN.program("field_fortran", &["capi/fortran/rvachev.f90", "examples/fortran/field.f90"]);
    let text = said(&mut Command::new(&program));
    assert!(near(number(&text, "half", "volume"), bored(0.4) / 2.0, 1e-2), "{text}");
    assert!(near(number(&text, "half", "flat"), PI * (1.0 - 0.16), 1e-2), "{text}");
    assert!(text.contains(" sound T faces 3"), "{text}");
    // Numbers are from 1 to the number of points; nodes of the group are on its plane.
    assert!(number(&text, "nodes", "off") < 1e-12 && text.contains(" lowest 1 highest 0"), "{text}");
    assert_eq!(number(&text, "labels", "labels"), 0.0, "{text}");
    assert!(number(&text, "labels", "edges") > 60.0, "{text}");
    assert!(
        near(number(&text, "values", "first"), 0.5, 1e-9) && near(number(&text, "values", "second"), 0.1, 1e-9),
        "{text}"
    );
    assert!(near(number(&text, "values", "slope"), -1.0, 1e-9), "{text}");
    assert!(number(&text, "again", "checked") > 0.0 && text.contains("sound T\nstopped status 5 code 42"), "{text}");
    assert!(text.contains("bad status 2 a size is"), "{text}");
}

/// The programs of a language in `docs/calling.md`, as files.
fn documented(language: &str, extension: &str) -> PathBuf {
    let text = fs::read_to_string(root().join("docs/calling.md")).unwrap();
    let (_, after) = text.split_once("# From C, C++ and Fortran").unwrap();
    let (_, block) = after.split_once(&format!("```{language}\n")).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join(format!("documented.{extension}"));
    fs::write(&file, block.split_once("```").unwrap().0).unwrap();
    file
}

#[test]
fn documented_programs_run() {
    let c = documented("c", "c");
    let text = said(&mut Command::new(C.program("documented_c", &[c.to_str().unwrap()])));
    assert!(text.trim_end().ends_with(" points") && !text.starts_with('0'), "{text}");
    let cpp = documented("cpp", "cpp");
    let text = said(&mut Command::new(CPP.program("documented_cpp", &[cpp.to_str().unwrap()])));
    assert!(text.contains(" triangles of the cut") && !text.contains(" 0 triangles"), "{text}");
    let fortran = documented("fortran", "f90");
    let sources = ["capi/fortran/rvachev.f90", fortran.to_str().unwrap()];
    let text = said(&mut Command::new(FORTRAN.program("documented_fortran", &sources)));
    let numbers: Vec<usize> = text.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    assert!(numbers.len() == 3 && numbers[0] == numbers[2] && numbers[1] > 20 && numbers[1] < numbers[0], "{text}");
}

/// A cube of edge 2 whose floor and roof have the same triangles, with names of its faces.
fn write_cube(path: &Path) {
    let mut text = String::new();
    for z in [0, 2] {
        text += &format!("v 0 0 {z}\nv 2 0 {z}\nv 2 2 {z}\nv 0 2 {z}\n");
    }
    text += "g floor\nf 1 3 2\nf 1 4 3\ng roof\nf 5 6 7\nf 5 7 8\ng wall\n";
    for (a, b) in [(1, 2), (2, 3), (3, 4), (4, 1)] {
        text += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 4, b + 4, a + 4);
    }
    fs::write(path, text).unwrap();
}

#[test]
fn faces_are_made_anew_and_swept_into_prisms() {
    let program = C.program("prisms_c", &["tests/capi/prisms.c"]);
    let folder = program.parent().unwrap();
    let cube = folder.join("cube.obj");
    write_cube(&cube);
    let text = said(Command::new(&program).arg(&cube).arg(folder));
    assert!(text.starts_with("units mm\n"), "{text}");
    assert!(number(&text, "face", "after") > 1.5 * number(&text, "face", "before"), "{text}");
    assert_eq!(number(&text, "face", "others"), number(&text, "face", "same"), "{text}");
    assert!(text.contains("page 1\nwritten vm inside 1 outside 1\nwritten 3mf inside 1 outside 1\n"), "{text}");
    // Four layers over a square of 2 by 2, 3 high: its top, what is across, and four walls.
    assert_eq!(number(&text, "swept", "cells"), 4.0 * number(&text, "swept", "of"), "{text}");
    assert!(near(number(&text, "swept", "volume"), 12.0, 1e-9), "{text}");
    assert!(near(number(&text, "swept", "roof"), 4.0, 1e-9), "{text}");
    assert_eq!(number(&text, "swept", "names"), 6.0, "{text}");
    paired(&text, number(&text, "swept", "cells"), 12.0);
    for (word, truth) in [("a", 1.7), ("b", 1.0), ("c", 3.0), ("d", 1.0), ("near", 0.0), ("far", 2.0)] {
        assert!(abs_diff_eq!(number(&text, "carried", word), truth, epsilon = 1e-8), "{word} in {text}");
    }
    // Half a unit to the edge and half from it, one along.
    assert!(near(number(&text, "way", "length"), 2f64.sqrt(), 1e-8), "{text}");
    assert!(text.contains("ends 1.500000000 0.500000000\n") && text.contains(" top opposite\n"), "{text}");
    assert!(text.contains("\napart 1 mesh 1 has no node in common with the others\n"), "{text}");
    assert!(text.contains("\njoined fewer 1 faces 12 report 1\ntwin 1 1\n"), "{text}");
    assert!(fs::read_to_string(folder.join("block.inp")).unwrap().contains("C3D8"));
    assert_eq!(number(&text, "between", "cells"), 6.0, "{text}");
    assert!(near(number(&text, "between", "volume"), 8.0, 1e-9), "{text}");
    // The unit is in the file that has a place for it.
    let package = fs::read(folder.join("block.3mf")).unwrap();
    let mut file = zip::ZipArchive::new(std::io::Cursor::new(package)).unwrap();
    let model = std::io::read_to_string(file.by_name("3D/3dmodel.model").unwrap()).unwrap();
    assert!(model.contains("unit=\"millimeter\""), "{model:.300}");
    let written = fs::read_to_string(folder.join("block.msh")).unwrap();
    assert!(written.contains("\"volume\"") && written.contains("\"opposite\""), "{written:.300}");

    let text = said(&mut Command::new(CPP.program("prisms_cpp", &["tests/capi/prisms.cpp"])));
    assert!(text.starts_with("units cm ") && text.ends_with("refused 3\n"), "{text}");
    assert!(number(&text, "units", "after") > 1.5 * number(&text, "units", "before"), "{text}");
    assert!(near(number(&text, "units", "volume"), 8.0, 1e-9), "{text}");
    assert!(number(&text, "units", "xmin") > 0.0, "{text}");
    paired(&text, number(&text, "units", "cells"), 8.0);
    assert!(text.contains("carried 0.250000000 way from 1.500000000 to 1.500000000\n"), "{text}");

    let sources = ["capi/fortran/rvachev.f90", "tests/capi/prisms.f90"];
    let text = said(&mut Command::new(FORTRAN.program("prisms_fortran", &sources)));
    assert!(text.starts_with("units in in ") && text.ends_with("refused 3\n"), "{text}");
    assert!(number(&text, "units", "after") > 1.5 * number(&text, "units", "before"), "{text}");
    assert_eq!(number(&text, "cells", "least"), 1.0, "{text}");
    assert_eq!(number(&text, "cells", "above"), 0.0, "{text}");
    assert!(near(number(&text, "cells", "volume"), 8.0, 1e-9), "{text}");
    assert!(near(number(&text, "cells", "lowest"), -2.0, 1e-9), "{text}");
    assert!(text.contains("first b.zmin names 6 sides 0\n") && text.contains("\nfew 2\njoined 2\n"), "{text}");
    paired(&text, number(&text, "cells", "cells"), 8.0);
    assert_eq!(number(&text, "paired", "least"), 1.0, "{text}");
    assert!(near(number(&text, "carried", "carried"), 0.25, 1e-8), "{text}");
    assert!(near(number(&text, "carried", "length"), 2f64.sqrt(), 1e-8), "{text}");
}

/// Most of the prisms are in pairs, and no volume is lost.
fn paired(text: &str, prisms: f64, volume: f64) {
    let [pairs, left] = ["hexahedra", "prisms"].map(|word| number(text, "paired", word));
    assert!(pairs > left && 2.0 * pairs + left == prisms, "{text}");
    assert!(near(number(text, "paired", "volume"), volume, 1e-9), "{text}");
}

/// What is told before meshing is within a tenth of what is made.
fn expected(text: &str, line: &str) {
    let [about, made] = ["about", "made"].map(|word| number(text, line, word));
    assert!(made > 1000.0 && near(about, made, 0.1), "{text}");
}

#[test]
fn triangles_are_told_before_and_functions_sampled() {
    let step = root().join("data/step/sphere.step");
    let program = C.program("sampled_c", &["tests/capi/sampled.c"]);
    let folder = program.parent().unwrap();
    let text = said(Command::new(&program).arg(&step).arg(folder));
    expected(&text, "ball");
    expected(&text, "step");
    // A thousandth of the diagonal, and the same as a length; middles of triangles are off by little more.
    assert_eq!(number(&text, "tolerance", "share"), number(&text, "tolerance", "length"), "{text}");
    assert!(number(&text, "tolerance", "off") < 1.25 * 2e-3 * 3f64.sqrt(), "{text}");
    // The ball of the STEP file has a radius of 2.
    assert!(near(number(&text, "lost", "volume"), 32.0 / 3.0 * PI, 1e-3), "{text}");
    assert_eq!(number(&text, "sequence", "told"), 1.0, "{text}");
    assert!(near(number(&text, "sequence", "volume"), 4.0 / 3.0 * PI, 3e-2), "{text}");
    assert_eq!(number(&text, "grid", "values"), 41.0 * 41.0 * 41.0, "{text}");
    assert_eq!(number(&text, "grid", "gradients"), 41.0 * 41.0 * 41.0, "{text}");
    assert_eq!(number(&text, "grid", "wrong"), 0.0, "{text}");
    assert_eq!(number(&text, "grid", "apart"), 0.0, "{text}");
    assert!(number(&text, "grid", "turned") < 1e-9, "{text}");
    assert!(near(number(&text, "grid", "volume"), 4.0 / 3.0 * PI, 1e-2), "{text}");
    assert!(near(number(&text, "again", "volume"), 4.0 / 3.0 * PI, 1e-2), "{text}");
    assert!(text.contains("step counts 13 from -1.500000000 by 0.250000000 gradients 0\n"), "{text}");
    assert!(near(number(&text, "contour of plate", "area"), 8.0, 1e-12), "{text}");
    assert!(near(number(&text, "contour of hole", "area"), -PI / 4.0, 1e-2), "{text}");
    assert!(text.contains("contours 2 borders 5 off 0\n"), "{text}");
    let npy = fs::read(folder.join("ball.npy")).unwrap();
    assert_eq!(npy.len() % 64, (13 * 13 * 13 * 8) % 64, "a header of whole blocks, then float64");
    assert!(fs::read_to_string(folder.join("plate.svg")).unwrap().contains("data-name=\"hole\""));
    assert!(fs::metadata(folder.join("ball.vti")).unwrap().len() > 41 * 41 * 41 * 32);

    // Of the integer points 257 lie in the closed ball of radius 4.
    let lattice = |text: &str| {
        expected(text, "ball");
        assert!(near(number(text, "ball", "step"), 6500.0, 0.1), "{text}");
        assert!(text.contains("grid counts 13 ") && text.contains(" from -1.500000000 "), "{text}");
        assert_eq!(number(text, "grid", "inside"), 257.0, "{text}");
        assert_eq!(number(text, "grid", "gradients"), 2197.0, "{text}");
        assert!(near(number(text, "contours", "area"), 8.0, 1e-12), "{text}");
        assert!(near(number(text, "contours", "left"), 2.0, 1e-12), "{text}");
        assert_eq!(number(text, "contours", "contours"), 1.0, "{text}");
    };
    lattice(&said(Command::new(CPP.program("sampled_cpp", &["tests/capi/sampled.cpp"])).arg(&step)));
    let sources = ["capi/fortran/rvachev.f90", "tests/capi/sampled.f90"];
    let text = said(Command::new(FORTRAN.program("sampled_fortran", &sources)).arg(&step));
    lattice(&text);
    assert!(text.contains(" inwards T\nrefused 2\n") && text.contains("none 0\n"), "{text}");
}

/// A cube with two bores that cross, and its volume, by Steinmetz.
const CUBE: &str = "part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n";

/// The status and the JSON on the line that starts with a word.
fn told(text: &str, word: &str) -> (u8, Value) {
    let line = text.lines().find_map(|l| l.strip_prefix(word)).unwrap_or_else(|| panic!("no {word:?} in\n{text}"));
    let (status, json) = line.trim_start().split_once(' ').unwrap();
    (status.parse().unwrap(), serde_json::from_str(json).unwrap_or_else(|e| panic!("{word}: {e} in {json}")))
}

#[test]
fn models_are_told_of_and_bricks_made() {
    let bored = 8.0 - 4.0 * PI * 0.16 + 16.0 / 3.0 * 0.064;
    let ball = root().join("data/step/sphere.step");
    let run = rvachev::Run::new();
    let of = |program: PathBuf| {
        let folder = program.parent().unwrap().to_path_buf();
        let _ = fs::remove_dir_all(folder.join("plan"));
        let [bar, cube] = ["bar.step", "cube.py"].map(|n| folder.join(n));
        fs::write(&cube, CUBE).unwrap();
        let text = "part(extrude_edges([polyline([(0, 0), (4, 0), (4, 2), (0, 2)], closed=True)], 'z', 6).name('bar'))";
        let brep = build(&parse(text, &[]).unwrap(), &run).unwrap().unwrap();
        save_step(&bar, &brep, Some("mm")).unwrap();
        // The first face is taken out of its shell.
        let text = fs::read_to_string(&bar).unwrap();
        let list = text.find("CLOSED_SHELL(").unwrap();
        let list = list + text[list..].find("(#").unwrap() + 1;
        let comma = list + text[list..].find(',').unwrap();
        fs::write(&bar, format!("{}{}", &text[..list], &text[comma + 1..])).unwrap();
        let text = said(Command::new(&program).args([&ball, &bar, &cube, &folder]));

        let (status, check) = told(&text, "bar_check");
        assert_eq!((status, &check["sound"], &check["bodies"][0]["open_edges"]), (1, &json!(false), &json!(4)));
        assert!(check["faults"].as_array().unwrap().iter().all(|f| f["kind"] == "open_edge"), "{check}");
        let (status, info) = told(&text, "ball_info");
        assert_eq!((status, &info["units"], &info["sewn"]), (0, &json!("mm"), &json!(true)));
        assert!(near(info["bodies"][0]["volume"].as_f64().unwrap(), 32.0 / 3.0 * PI, 1e-5), "{info}");
        assert!(near(info["area"].as_f64().unwrap(), 16.0 * PI, 1e-5), "{info}");
        let (_, compared) = told(&text, "compared");
        let rows = compared["rows"].as_array().unwrap();
        let leaf = rows.iter().rfind(|r| r["method"] == "leaf").unwrap();
        assert!(near(leaf["check"]["volume"].as_f64().unwrap(), bored, 5e-3), "{leaf}");
        assert!(rows.len() > 4 && rows[0]["method"] == "mc", "{compared}");

        assert!(number(&text, "bricks", "made") >= 2.0 && number(&text, "bricks", "again") == 0.0, "{text}");
        let (status, report) = told(&text, "merged");
        assert_eq!((status, &report["shortfalls"]), (0, &json!([])));
        assert!(near(report["check"]["volume"].as_f64().unwrap(), bored, 1e-3), "{report}");
        let read = rvachev::io::read(&folder.join("cube.stl"), &run).unwrap();
        assert_eq!(json!(read.triangles.len()), report["check"]["triangles"]);
        text
    };
    let text = of(C.program("models_c", &["tests/capi/models.c"]));
    let (status, check) = told(&text, "ball_check");
    assert_eq!((status, &check["sound"], &check["faults"]), (0, &json!(true), &json!([])));
    assert_eq!(told(&text, "bar_info").1["sewn"], json!(false));
    of(CPP.program("models_cpp", &["tests/capi/models.cpp"]));
    of(FORTRAN.program("models_fortran", &["capi/fortran/rvachev.f90", "tests/capi/models.f90"]));
}

#[test]
fn misuse_is_told_and_runs_are_watched() {
    let program = C.program("misuse", &["tests/capi/misuse.c"]);
    let text = said(Command::new(&program).arg(root().join("data/lattice.py")));
    assert!(text.ends_with("done\n"), "{text}");
    assert!(number(&text, "cancelled", "after") < 1.0, "{text}");
    if cfg!(target_os = "linux") {
        assert!(number(&text, "leak", "grown") < 2048.0, "{text}");
    }
}

/// It looks at what the program above cannot see.
#[test]
#[ignore = "needs valgrind and minutes: --include-ignored"]
fn valgrind_finds_nothing() {
    let program = C.program("misuse_valgrind", &["tests/capi/misuse.c"]);
    let text = said(
        Command::new("valgrind")
            .args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=definite"])
            .arg("--errors-for-leak-kinds=definite")
            .arg(&program)
            .arg("quick"),
    );
    assert!(text.contains("quick done"), "{text}");
}

#[test]
fn bindings_have_the_version_of_the_library() {
    for member in ["capi", "python"] {
        let text = fs::read_to_string(root().join(member).join("Cargo.toml")).unwrap();
        let own = text.lines().find_map(|l| l.strip_prefix("version = ")).unwrap();
        assert_eq!(own.trim_matches('"'), env!("CARGO_PKG_VERSION"), "{member}");
    }
}

#[test]
fn installed_library_is_found_by_pkg_config() {
    let target = library().parent().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi/installed");
    let _ = fs::remove_dir_all(&folder);
    said(Command::new(root().join("capi/install")).arg(&folder).env("CARGO_TARGET_DIR", target));
    let told = |arguments: &[&str]| {
        let mut command = Command::new("pkg-config");
        command.args(arguments).arg("rvachev").env("PKG_CONFIG_PATH", folder.join("lib/pkgconfig"));
        let text = said(&mut command);
        text.split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(told(&["--modversion"]), [env!("CARGO_PKG_VERSION")]);
    let source = documented("c", "c");
    // With nothing but what pkg-config tells: once with the shared library, once with the static one.
    let built = |name: &str, flags: &[String]| {
        let program = folder.join(name);
        done(C.compiler().args(C.flags).arg(&source).arg("-o").arg(&program).args(flags))
            .unwrap_or_else(|e| panic!("{e}"));
        said(
            Command::new(&program)
                .env("LD_LIBRARY_PATH", folder.join("lib"))
                .env("DYLD_LIBRARY_PATH", folder.join("lib")),
        )
    };
    let shared = built("shared", &told(&["--cflags", "--libs"]));
    assert!(shared.trim_end().ends_with(" points"), "{shared}");
    for file in ["librvachev_c.so", "librvachev_c.dylib"] {
        let _ = fs::remove_file(folder.join("lib").join(file));
    }
    assert_eq!(built("alone", &told(&["--static", "--cflags", "--libs"])), shared);
}
