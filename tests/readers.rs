//! Parts of other programs: formulas as `.vm`, OpenSCAD's trees as `.csg`. Any bytes, for every reader of the library.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use assert_cmd::Command;
use proptest::prelude::*;
use rvachev::implicit::part::{Part, parse_csg, parse_vm};
use rvachev::implicit::{Implicit, RSystem};
use rvachev::io::{self, Encoding, Format, WriteOptions};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{self, MeshOptions, Meshed, SizeRequest};
use rvachev::{DVec3, Error, Run};
use tempfile::TempDir;

#[path = "common/readers.rs"]
mod readers;
use readers::{READERS, Reader};

/// A cube from -1 to 1 with three bores of radius 0.3 that do not meet, along x, y and z.
const CUBE: &str = "\
# a cube with holes
_x var-x
_y var-y
_z var-z
one const 1
half const 0.5
ax abs _x
ay abs _y
az abs _z
m0 max ax ay
m1 max m0 az
cube sub m1 one   # negative inside
r const 0.3
u0 sub _y half
v0 sub _z half
u0s square u0
v0s square v0
w0 add u0s v0s
q0 sqrt w0
h0 sub r q0
u1 add _x half
v1 add _z half
u1s mul u1 u1
v1s mul v1 v1
w1 add u1s v1s
q1 sqrt w1
h1 sub r q1
u2 sub _x half
v2 add _y half
u2s square u2
v2s square v2
w2 add u2s v2s
q2 sqrt w2
h2 sub r q2
h01 max h0 h1
h max h01 h2
out max cube h
";

/// A turned cube with a bore, and a mirrored one with a conical hole.
const TREE: &str = "\
multmatrix([[0.866025, -0.5, 0, 5], [0.5, 0.866025, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]) {
	difference() {
		cube(size = [10, 10, 10], center = true);
		cylinder($fn = 0, $fa = 12, $fs = 2, h = 20, r1 = 3, r2 = 3, center = true);
	}
}
group() {
	multmatrix([[-1, 0, 0, -20], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {
		color([1, 0, 0, 1]) {
			difference() {
				cube(size = [10, 8, 6], center = false);
				multmatrix([[1, 0, 0, 3], [0, 1, 0, 4], [0, 0, 1, -1], [0, 0, 0, 1]]) {
					cylinder($fn = 0, $fa = 12, $fs = 2, h = 8, r1 = 2, r2 = 1, center = false);
				}
				group();
			}
		}
	}
}
";

/// A frustum's volume.
fn frustum(r1: f64, r2: f64, h: f64) -> f64 {
    PI * h / 3.0 * (r1 * r1 + r1 * r2 + r2 * r2)
}

fn meshed(part: &Part, share: f64) -> Meshed {
    let options = MeshOptions { size: Some(SizeRequest::Share(share)), ..MeshOptions::default() };
    pipeline::mesh_part(part, &options, &Run::default()).unwrap()
}

/// The mesh is sound, all that is sharp is found, and the volume is right to a share of it.
#[track_caller]
fn right(m: &Meshed, volume: f64, share: f64) {
    let check = m.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{}", check.certificate);
    assert!(m.report.shortfalls.is_empty(), "{:?}", m.report.shortfalls);
    let features = check.features.as_ref().unwrap();
    assert!(features.recall > 0.9995, "recall {}", features.recall);
    let found = m.mesh.volume();
    assert_relative_eq!(found, volume, epsilon = 0.0, max_relative = share);
}

fn names(m: &Meshed) -> Vec<&str> {
    m.mesh.faces.iter().map(String::as_str).collect()
}

#[test]
fn a_formula_file_keeps_its_edges() {
    let m = meshed(&parse_vm(CUBE).unwrap(), 0.015);
    right(&m, 8.0 - 3.0 * PI * 0.09 * 2.0, 1e-3);
    let features = m.report.check.as_ref().unwrap().features.as_ref().unwrap();
    assert_eq!((features.corners_true, features.corners_found), (8, 8));
    // Twelve edges and six rims.
    assert_relative_eq!(features.length_true, 24.0 + 6.0 * 2.0 * PI * 0.3, epsilon = 0.0, max_relative = 1e-3);
    assert_eq!(names(&m), ["formula1"]);
}

#[test]
fn a_tree_keeps_round_things_round_and_names_faces() {
    let m = meshed(&parse_csg(TREE).unwrap(), 0.008);
    let volume = 1000.0 - PI * 90.0 + 480.0 - frustum(2.0 - 0.125, 1.25 - 0.125, 6.0);
    right(&m, volume, 1e-3);
    let names = names(&m);
    for name in ["box1.xmin", "box2.zmax", "cylinder1.side", "cone1.side"] {
        assert!(names.contains(&name), "{names:?} lacks {name}");
    }
    // The mirrored one lies on the other side of x = -20.
    let least = m.mesh.nodes.iter().fold(f64::INFINITY, |least, p| least.min(p.x));
    assert_abs_diff_eq!(least, -30.0, epsilon = 1e-9);
}

#[test]
fn a_nut_has_six_sides_and_a_round_bore() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/nut.csg");
    let m = meshed(&pipeline::load_part(&path, &[]).unwrap(), 0.015);
    // A hexagon whose corners are 9 away, with a bore of 5 that a cone of 6 to 5 widens at the top.
    let hexagon = 1.5 * 3f64.sqrt() * 81.0;
    right(&m, 8.0 * (hexagon - 25.0 * PI) - (frustum(5.0, 6.0, 1.0) - 25.0 * PI), 1e-3);
    assert_eq!(m.report.check.as_ref().unwrap().features.as_ref().unwrap().corners_found, 12);
    assert!(names(&m).contains(&"prism1.side5") && names(&m).contains(&"cone1.side"));
}

/// One primitive under a matrix.
fn under(matrix: &str, what: &str) -> Part {
    parse_csg(&format!("multmatrix({matrix}) {{ {what} }}")).unwrap()
}

#[test]
fn matrices_that_shear_and_stretch_keep_volumes() {
    let shear = "[[2, 0.5, 0, 1], [0, 1, 0.25, 0], [0, 0, 1.5, 0], [0, 0, 0, 1]]";
    for (what, volume) in [
        ("cube(size = [1, 2, 3], center = false);", 6.0),
        ("sphere($fn = 0, $fa = 12, $fs = 2, r = 1);", 4.0 / 3.0 * PI),
        ("cylinder(h = 2, r1 = 1, r2 = 1, center = true);", 2.0 * PI),
        ("cylinder(h = 2, r1 = 1, r2 = 0.5, center = true);", frustum(1.0, 0.5, 2.0)),
        // A hexagon of a nut is meant.
        ("cylinder($fn = 6, h = 2, r1 = 1, r2 = 1);", 3.0 * 3f64.sqrt()),
    ] {
        right(&meshed(&under(shear, what), 0.015), 3.0 * volume, 2e-3);
    }
}

#[test]
fn matrices_of_six_digits_are_rotations() {
    let part =
        under("[[0.707107, -0.707107, 0, 0], [0.707107, 0.707107, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]", "sphere(2);");
    let model = Implicit::new(part.solid.as_ref().unwrap(), RSystem::default(), None).unwrap();
    assert_eq!(model.leaf_count(), 1);
    // On the sphere of radius 2, to rounding.
    assert_abs_diff_eq!(model.value(DVec3::new(2.0, 0.0, 0.0)), 0.0, epsilon = 1e-12);
}

/// The sign of a formula file's function at a point: 1 inside.
fn sign(text: &str, p: DVec3) -> f64 {
    let boxed = format!(
        "{text}\nbx var-x\nby var-y\nbz var-z\nba abs bx\nbb abs by\nbc abs bz\nbd max ba bb\nbe max bd bc\nbn const 9\nbf sub be bn\n\
         bout max f bf\n"
    );
    let part = parse_vm(&boxed).unwrap_or_else(|e| panic!("{text}: {e}"));
    let model = Implicit::new(part.solid.as_ref().unwrap(), RSystem::default(), None);
    let model = model.unwrap_or_else(|e| panic!("{text}: {e}"));
    if model.inside(p) { 1.0 } else { -1.0 }
}

/// Every operation against what Rust makes of it, near numbers where it tells.
#[test]
fn operations_mean_what_they_say() {
    let (x, y) = (0.7f64, -1.3f64);
    let cases: &[(&str, f64)] = &[
        ("neg a", -x),
        ("abs b", y.abs()),
        ("square b", y * y),
        ("sqrt a", x.sqrt()),
        ("recip a", 1.0 / x),
        ("sin b", y.sin()),
        ("cos b", y.cos()),
        ("tan a", x.tan()),
        ("atan b", y.atan()),
        ("exp b", y.exp()),
        ("floor b", -2.0),
        ("ceil b", -1.0),
        ("round b", -1.0),
        ("add a b", x + y),
        ("sub a b", x - y),
        ("mul a b", x * y),
        ("div a b", x / y),
        ("min a b", y),
        ("max a b", x),
        ("atan2 a b", x.atan2(y)),
        ("mod b half", 0.2),
        ("pow b three", y.powi(3)),
        ("nth-root b three", y.cbrt()),
        ("compare a b", 1.0),
        ("compare b a", -1.0),
        ("and a b", y),
        ("and zero b", 0.0),
        ("or a b", x),
        ("or zero b", y),
        ("not a", 0.0),
        ("not zero", 1.0),
    ];
    for (operation, value) in cases {
        for (shift, inside) in [(1e-3, -1.0), (-1e-3, 1.0)] {
            let text = format!(
                "x var-x\ny var-y\nz var-z\nhalf const 0.5\nthree const 3\nzero const 0\na add x zero\nb add y zero\n\
                 v {operation}\nw const {:?}\nd sub w v\ns mul half z\ne sub d s\nf neg e",
                value - shift
            );
            // Negative is inside: v + z / 2 < value - shift.
            assert_eq!(sign(&text, DVec3::new(x, y, 0.0)), inside, "{operation} is not {value}");
        }
    }
}

#[test]
fn many_parts_in_one_chain_keep_their_edges() {
    let mut text = String::from("x var-x\ny var-y\nz var-z\nr const 0.3\n");
    let n = 300;
    for i in 0..n {
        let at = [i % 10, i / 10 % 10, i / 100].map(|k| 0.5 * f64::from(k));
        for (axis, c) in ["x", "y", "z"].iter().zip(at) {
            text += &format!("c{axis}{i} const {c}\nd{axis}{i} sub {axis} c{axis}{i}\nq{axis}{i} square d{axis}{i}\n");
        }
        text += &format!("s{i} add qx{i} qy{i}\nt{i} add s{i} qz{i}\nu{i} sqrt t{i}\nv{i} sub u{i} r\n");
        text += &if i == 0 { "m0 min v0 v0\n".into() } else { format!("m{i} min m{} v{i}\n", i - 1) };
    }
    let model =
        |text: &str| Implicit::new(parse_vm(text).unwrap().solid.as_ref().unwrap(), RSystem::default(), None).unwrap();
    let model = model(&text);
    assert_eq!(model.leaf_count(), n as usize);
    assert_eq!(model.faces().len(), 1);
    assert!(model.inside(DVec3::new(0.25, 0.0, 0.0)) && !model.inside(DVec3::splat(0.25)));
}

/// Written and read again a part is the same solid, and its edges are found.
#[test]
fn what_is_written_as_a_formula_reads_back() {
    let again = |part: &Part| parse_vm(&pipeline::vm_text(part).unwrap()).unwrap();
    let volume = 1000.0 - PI * 90.0 + 480.0 - frustum(2.0 - 0.125, 1.25 - 0.125, 6.0);
    right(&meshed(&again(&parse_csg(TREE).unwrap()), 0.008), volume, 1e-3);

    let rich = "f = (x - 0.1)**2 + y**3 / 4 + hypot(x, z) + tanh(x) + sinh(y) * cosh(z) + (x + 2)**-2 + (x + 3)**1.5\n\
                g = (x if y >= 0.2 else z) + floor(2 * x) / 5 + mod(y, 0.7) + sign(z - 0.3) + abs(x - y) + atan2(y, x + 5)\n\
                part((torus(1, 0.4, axis=(1, 2, 3)) | cone(0.5, 0, 2, axis=(1, 0, 1)) | sphere(0.7, at=(1, 1, 0))\n\
                  | cylinder(0.3, axis=(1, 1, 0), height=3)) & solid(f <= 8) & solid(g <= 3) - box((0.5, 0.6, 0.7)))\n";
    let rich = pipeline::parse_part(Path::new("a.py"), rich, &[]).unwrap();
    let model = |p: &Part| Implicit::new(p.solid.as_ref().unwrap(), RSystem::default(), None).unwrap();
    let (before, after) = (model(&rich), model(&again(&rich)));
    let n = 23;
    let mut inside = 0;
    for i in 0..n * n * n {
        let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 1.799;
        assert_eq!(before.inside(p), after.inside(p), "{p}");
        inside += i32::from(before.inside(p));
    }
    assert!(inside > 200, "{inside}");
}

#[test]
fn what_has_no_formula_is_not_written() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("blend.py"), "part(blend(box((1, 1, 1)), box((3, 0.5, 0.5)), 0.2))\n").unwrap();
    fs::write(dir.path().join("built.py"), "part(extrude_edges(circle(1), \"z\", 2))\n").unwrap();
    fs::write(dir.path().join("ball.py"), "part(sphere(1))\n").unwrap();
    for (file, code, says) in
        [("blend.py", 3, "a blend cannot be written"), ("built.py", 3, "built from edges"), ("ball.py", 0, "")]
    {
        let mut run = Command::cargo_bin("rvachev").unwrap();
        let out = run.current_dir(&dir).args(["convert", file, "-o", "out.vm"]).output().unwrap();
        let err = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{file}: {err}");
        assert!(err.contains(says), "{file}: {err}");
        assert_eq!(dir.path().join("out.vm").exists(), code == 0, "{file}");
    }
}

/// A file's name, its text, and what is said of it.
const REFUSED: &[(&str, &str, &[&str])] = &[
    ("a.vm", "", &["line 1, column 1", "no operation"]),
    ("a.vm", "# only this\n\n", &["no operation"]),
    ("a.vm", "_0 var-x\n_1 cosh _0\n", &["line 2, column 4", "unknown operation \"cosh\"", "\"cos\""]),
    ("a.vm", "_0 var-w\n", &["line 1, column 4", "unknown operation", "var-x, var-y and var-z"]),
    ("a.vm", "_0 var-x\n_1 add _0 _2\n_2 var-y\n", &["line 2, column 11", "\"_2\" is used before"]),
    ("a.vm", "_0 var-x\n_1 add _0\n", &["line 2, column 4", "add takes 2 operands, not 1"]),
    ("a.vm", "_0 var-x\n_1 neg _0 _0\n", &["line 2, column 11", "neg takes 1 operand, not 2"]),
    ("a.vm", "_0 var-x\n_0 var-y\n", &["line 2, column 1", "already the name of line 1"]),
    ("a.vm", "_0 const 1.2.3\n", &["line 1, column 10", "\"1.2.3\" is not a number", "_0 const 1.5"]),
    ("a.vm", "_0 const inf\n", &["line 1, column 10", "finite"]),
    ("a.vm", "_0\n", &["line 1, column 1", "no operation follows"]),
    ("a.vm", "_0 const 1\n_1 const 0\n_2 div _0 _1\n", &["line 3, column 4", "not a finite number"]),
    ("a.vm", "_0 const 1\n_1 neg _0\n", &["line 2, column 4", "does not depend on x, y, z"]),
    ("a.vm", "_0 var-x\n", &["may be infinite", ".vm file"]),
    ("a.csg", "", &["line 1, column 1", "no solid"]),
    ("a.csg", "group();\n", &["no solid"]),
    ("a.csg", "group() {\n  hull() {\n    cube(1);\n  }\n}\n", &["line 2, column 3", "hull() cannot be read", "a.stl"]),
    ("a.csg", "cube(1);\npolyhedron(points = [[0, 0, 0]], faces = []);\n", &["line 2, column 42", "four faces"]),
    ("a.csg", "linear_extrude(height = 1) { offset(r = 1); }", &["line 1, column 30", "offset()", "a.stl"]),
    ("a.csg", "cub(1);\n", &["line 1, column 1", "unknown operation \"cub\"", "is it cube()?"]),
    ("a.csg", "cube(size = [1, 2]);\n", &["line 1, column 13", "size of a cube"]),
    ("a.csg", "cube(size = [1, 2, 0]);\n", &["line 1, column 13", "must be positive"]),
    ("a.csg", "sphere(r = -1);\n", &["line 1, column 12", "must be positive, not -1"]),
    ("a.csg", "cylinder(h = 1, r1 = 0, r2 = 0);\n", &["line 1, column 1", "radius that is not zero"]),
    ("a.csg", "union() {\n  cube(1);\n", &["line 1, column 1", "braces of union are not closed"]),
    ("a.csg", "cube(1);\n}\n", &["line 2, column 1", "nothing is open"]),
    ("a.csg", "cube(1)\n", &["the file ends"]),
    ("a.csg", "cube(1;\n", &["line 1, column 7", "\",\" should stand here"]),
    ("a.csg", "cube(size = wide);\n", &["line 1, column 13", "\"wide\" is not a value"]),
    ("a.csg", "multmatrix([[1, 0], [0, 1]]) { cube(1); }", &["line 1, column 12", "four rows"]),
    ("a.csg", "multmatrix([[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]) cube(1);", &["line 1, column 12", "flat"]),
    ("a.csg", "intersection() { cube(1); group(); }", &["empty"]),
    ("a.csg", "text(\"a", &["line 1, column 6", "string does not end"]),
];

#[test]
fn mistakes_are_named_with_their_place() {
    for (file, text, says) in REFUSED {
        let dir = TempDir::new().unwrap();
        fs::write(dir.path().join(file), text).unwrap();
        let out = Command::cargo_bin("rvachev").unwrap().current_dir(&dir).args(["info", file]).output().unwrap();
        let err = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(3), "{text}\n{err}");
        for s in *says {
            assert!(err.contains(s), "{text}\n{err}\nsays nothing of {s}");
        }
    }
}

#[test]
fn overrides_are_for_part_files() {
    let e = pipeline::parse_part(Path::new("a.vm"), CUBE, &[("r".into(), 1.0)]).unwrap_err();
    assert_eq!(e.exit_code(), 2);
}

/// As long as the deepest recursion would not survive.
#[test]
fn long_files_are_read_without_recursion() {
    let n = 100_000;
    let mut chain = String::from("x var-x\na0 square x\nc const 0.000001\n");
    (1..=n).for_each(|i| chain += &format!("a{i} add a{} c\n", i - 1));
    let mut both = String::from("x var-x\ny var-y\na0 max x y\n");
    (1..=n)
        .for_each(|i| both += &format!("a{i} {} a{} {}\n", ["min", "max", "neg"][i % 3], i - 1, ["x", "y", ""][i % 3]));
    for text in [chain, both] {
        drop(parse_vm(&text).unwrap());
    }
    for (open, close) in [("group() {", "}"), ("difference() { sphere(1);", "}"), ("color(\"red\") ", "")] {
        let part = parse_csg(&format!("{}cube(1);{}", open.repeat(n), close.repeat(n))).unwrap();
        assert!(Implicit::new(part.solid.as_ref().unwrap(), RSystem::default(), None).is_ok());
    }
    assert_eq!(parse_csg(&"cube(".repeat(n)).unwrap_err().exit_code(), 3);
    assert_eq!(parse_csg(&format!("cube({}", "[".repeat(n))).unwrap_err().exit_code(), 3);
}

// ---------------------------------------------------------------------------------------------- any bytes, every reader

/// Bytes of which some are replaced, taken out or said twice.
fn changed(bytes: &[u8], edits: &[(usize, u8, u8)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (at, what, byte) in edits {
        let i = at % bytes.len().max(1);
        match what % 5 {
            0 if i < bytes.len() => bytes[i] = *byte,
            1 if i < bytes.len() => drop(bytes.remove(i)),
            2 => bytes.insert(i, *byte),
            3 if i < bytes.len() => bytes[i] = b"0123456789-$.e \n"[usize::from(*byte) % 16],
            _ => bytes.extend_from_within(i..bytes.len().min(i + usize::from(*byte))),
        }
    }
    bytes
}

/// A box with two faces that have names.
fn cuboid() -> TriMesh {
    let node = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) / 3.0;
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mut mesh = TriMesh::new((0..8).map(node).collect(), triangles);
    mesh.faces = ["a face", "another"].map(String::from).to_vec();
    mesh.labels = (0..12).map(|t| u32::from(t > 3)).collect();
    mesh
}

/// What a reader reads: changes of it get farther than bytes at random.
fn seeds(reader: &Reader) -> Vec<Vec<u8>> {
    let file = |name: &str| fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)).unwrap();
    let ball = || pipeline::levelset_bytes(&parse_vm(CUBE).unwrap(), "cube").unwrap();
    match reader.name {
        "part" => ["bracket.py", "lever.py", "formula.py", "thread.py"].map(file).to_vec(),
        "vm" => vec![CUBE.into()],
        "csg" => vec![TREE.into(), file("nut.csg")],
        "levelset" => {
            let folder = TempDir::new().unwrap();
            fs::write(folder.path().join("a.3mf"), ball()).unwrap();
            vec![ball(), pipeline::part_text(&folder.path().join("a.3mf")).unwrap().into()]
        }
        "step" => ["step/cone_with_apex.step", "step/torus.step", "troubles/open_pole.step"].map(file).to_vec(),
        "points" => {
            vec!["# a table\nx [mm];y;z;t\n1;2;3;a\n4;5;6;b\n\n7;8;9;\n1e3;-2;.5;\n".into(), "1 2 3\n4\t5 6\n".into()]
        }
        "plan" => vec![readers::small_plan().to_json().unwrap().into()],
        "piece" => vec![pipeline::make_piece(readers::small_plan(), 0, &Run::new()).unwrap()],
        _ => {
            let mut all = Vec::new();
            for format in reader.formats {
                for (encoding, old_msh) in [(Encoding::Text, false), (Encoding::Binary, false), (Encoding::Text, true)]
                {
                    let options = WriteOptions { encoding, old_msh, ..WriteOptions::default() };
                    let mut bytes = Vec::new();
                    io::encode(&mut bytes, &cuboid(), *format, &options, &Run::new()).unwrap();
                    all.push(bytes);
                }
            }
            all
        }
    }
}

fn reader(name: &str) -> &'static Reader {
    READERS.iter().find(|r| r.name == name).unwrap()
}

/// A property test for each reader, which is the mirror of its target in `fuzz/fuzz_targets`.
macro_rules! hold {
    ($($name:ident)*) => {
        /// Readers that have a property test.
        const MIRRORED: &[&str] = &[$(stringify!($name)),*];

        $(mod $name {
            use super::*;

            proptest! {
                #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

                #[test]
                fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
                    readers::$name(&bytes);
                }

                #[test]
                fn no_change_makes_it_panic(
                    pick in any::<prop::sample::Index>(),
                    edits in proptest::collection::vec((any::<usize>(), any::<u8>(), any::<u8>()), 1..6),
                ) {
                    static SEEDS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
                    let seeds = SEEDS.get_or_init(|| seeds(reader(stringify!($name))));
                    readers::$name(&changed(pick.get::<Vec<u8>>(seeds), &edits));
                }
            }
        })*
    };
}

hold! { part vm csg levelset step points plan piece stl obj ply off msh inp bdf medit su2 vtk threemf }

#[test]
fn seeds_are_read_and_other_things_are_not() {
    for reader in &READERS {
        let seeds = seeds(reader);
        let read = seeds.iter().filter(|seed| (reader.holds)(seed)).count();
        assert_eq!(read, seeds.len(), "{}", reader.name);
        assert!(!(reader.holds)(b"\0\0no file\n"), "{}", reader.name);
    }
}

/// The names of READERS, of the targets of `fuzz/` wherever they stand, and of the property tests are the same.
#[test]
fn every_reader_has_a_target_and_a_property_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let names: BTreeSet<&str> = READERS.iter().map(|r| r.name).collect();
    assert_eq!(names.len(), READERS.len());
    assert_eq!(BTreeSet::from_iter(MIRRORED.iter().copied()), names, "property tests");
    let text = |name: &str| fs::read_to_string(root.join(name)).unwrap();
    let targets = fs::read_dir(root.join("fuzz/fuzz_targets")).unwrap().map(|f| f.unwrap().path());
    let stems: BTreeSet<String> = targets.map(|f| f.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    assert!(stems.iter().map(String::as_str).eq(names.iter().copied()), "files of targets: {stems:?}");
    let (manifest, told) = (text("fuzz/Cargo.toml"), text("fuzz/README.md"));
    for name in names {
        let calls = text(&format!("fuzz/fuzz_targets/{name}.rs"));
        assert!(calls.contains(&format!("    readers::{name}(bytes);\n")), "the target {name} calls another reader");
        assert!(manifest.contains(&format!("name = \"{name}\"\npath = \"fuzz_targets/{name}.rs\"\n")), "{name}");
        let row = told.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
        assert!(row.is_some_and(|r| r.contains(&format!("`{name}::`"))), "fuzz/README.md has no row for {name}");
    }
}

/// Nothing that the library reads is without a reader in READERS.
#[test]
fn every_format_that_is_read_has_a_reader() {
    for (ending, format) in Format::EXTENSIONS {
        let written_only = matches!(io::read_bytes(b"x", format, Path::new("a")), Err(Error::Usage(_)));
        let count = READERS.iter().filter(|r| r.formats.contains(&format)).count();
        assert_eq!(count, usize::from(!written_only), ".{ending}");
    }
    // Others begin with a function that parses; `parse_part` only calls the one for the ending.
    let asked = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/common/readers.rs")).unwrap();
    let mut files = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut found = BTreeSet::new();
    while let Some(path) = files.pop() {
        if path.is_dir() {
            files.extend(fs::read_dir(&path).unwrap().map(|f| f.unwrap().path()));
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            for rest in
                text.split("pub fn ").skip(1).filter(|rest| rest.starts_with("parse") || rest.starts_with("interpret"))
            {
                found.insert(rest.split(['(', '<']).next().unwrap().to_string());
            }
        }
    }
    assert!(found.remove("parse_part") && found.len() >= 7, "{found:?}");
    for name in found {
        assert!(asked.contains(&format!("{name}(")) || asked.contains(&format!(", {name})")), "no reader asks {name}");
    }
}
