//! 3MF in and out: level sets of implicit functions, meshes, and what lib3mf makes of both.
//!
//! The first use makes a virtual environment below `target/threemf-env` from `tests/threemf/requirements.txt`; that needs
//! Python 3.10 or newer and the package index. A missing one fails and says so.

mod common;

use std::f64::consts::PI;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq, relative_eq};
use common::{done, environment};
use rvachev::implicit::part::{Part, parse, parse_3mf};
use rvachev::io::{self, Format, WriteOptions};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{self, MeshOptions, SizeRequest, mesh_part};
use rvachev::{DVec3, Error, Run};
use serde_json::Value;
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn rvachev(dir: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rvachev")).current_dir(dir).args(arguments).output().unwrap()
}

fn good(dir: &TempDir, arguments: &[&str]) -> String {
    let out = rvachev(dir, arguments);
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8_lossy(&out.stdout).into_owned()
}

/// What lib3mf tells of a file, which it writes anew as `again.3mf`.
fn ask(dir: &TempDir, file: &str) -> Value {
    let found = environment("threemf-env", &here("tests/threemf/requirements.txt"));
    let python = found.unwrap_or_else(|why| panic!("the checks with lib3mf cannot run: {why}"));
    let script = here("tests/threemf/read.py");
    let out = done(Command::new(python).current_dir(dir).arg(script).args([file, "again.3mf"]));
    let out = out.unwrap_or_else(|why| panic!("{why}"));
    serde_json::from_slice(&out.stdout).unwrap()
}

// ------------------------------------------------------------------------------------------------ packages by hand

const RELATIONS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

fn package(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn packed(model: &str) -> Vec<u8> {
    package(&[("_rels/.rels", RELATIONS), ("3D/3dmodel.model", model)])
}

fn model(resources: &str, build: &str) -> String {
    format!(
        r#"<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:v="http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01" xmlns:i="http://schemas.3mf.io/3dmanufacturing/implicit/2023/12">
<resources>{resources}</resources>
<build>{build}</build></model>"#
    )
}

/// An object with a mesh: a box of half a side, or the octahedron in it.
fn mesh_object(id: u32, half: f64, octahedron: bool) -> String {
    let (points, triangles): (Vec<[f64; 3]>, Vec<[usize; 3]>) = if octahedron {
        let points = vec![[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
        let t = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        (points, t)
    } else {
        let points = (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 })).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (points, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
    };
    let vertex = |p: &[f64; 3]| format!(r#"<vertex x="{}" y="{}" z="{}"/>"#, half * p[0], half * p[1], half * p[2]);
    let triangle = |t: &[usize; 3]| format!(r#"<triangle v1="{}" v2="{}" v3="{}"/>"#, t[0], t[1], t[2]);
    let (points, triangles): (String, String) =
        (points.iter().map(vertex).collect(), triangles.iter().map(triangle).collect());
    format!(
        r#"<object id="{id}"><mesh><vertices>{points}</vertices><triangles>{triangles}</triangles></mesh></object>"#
    )
}

/// A node by a short form: its word, its name, then inputs such as `A=s:p.x` (by the kind of reference) and attributes such as
/// `@value=2`, blanks in it as `_`, and outputs such as `>s:result`.
fn node(short: &str) -> String {
    let kind = |k: &str| match k {
        "s" => "scalar",
        "v" => "vector",
        "m" => "matrix",
        _ => "resource",
    };
    let mut words = short.split_whitespace();
    let (word, name) = (words.next().unwrap(), words.next().unwrap());
    let (mut attributes, mut inputs, mut outputs) = (String::new(), String::new(), String::new());
    for w in words {
        if let Some(output) = w.strip_prefix('>') {
            let (k, name) = output.split_once(':').unwrap();
            outputs += &format!(r#"<i:{} identifier="{name}"/>"#, kind(k));
            continue;
        }
        let (key, value) = w.split_once('=').unwrap();
        match key.strip_prefix('@') {
            Some(key) => attributes += &format!(r#" {key}="{}""#, value.replace('_', " ")),
            None => {
                let (k, from) = value.split_once(':').unwrap();
                inputs += &format!(r#"<i:{}ref identifier="{key}" ref="{from}"/>"#, kind(k));
            }
        }
    }
    format!(
        r#"<i:{word} identifier="{name}"{attributes}><i:in>{inputs}</i:in><i:out>{outputs}</i:out></i:{word}>
"#
    )
}

fn function(id: u32, nodes: &str, out: &str) -> String {
    let nodes: String = nodes.split(';').map(str::trim).filter(|n| !n.is_empty()).map(node).collect();
    format!(
        r#"<i:implicitfunction id="{id}"><i:in><i:vector identifier="pos"/></i:in>
{nodes}<i:out><i:scalarref identifier="shape" ref="{out}"/></i:out></i:implicitfunction>"#
    )
}

fn levelset(attributes: &str) -> String {
    format!(
        r#"<object id="9" name="thing"><v:levelset functionid="1" channel="shape" meshid="2" {attributes}/></object>"#
    )
}

const ITEM: &str = r#"<item objectid="9"/>"#;

/// A level set of one function within a box of half a side 2.
fn simple(nodes: &str, out: &str) -> String {
    model(&(function(1, nodes, out) + &mesh_object(2, 2.0, false) + &levelset("")), ITEM)
}

const BALL: &str = "length l A=v:inputs.pos; constant c @value=0.8; subtraction s A=s:l.result B=s:c.value";

fn read(model: &str) -> Part {
    parse_3mf(&packed(model)).unwrap_or_else(|e| panic!("{e}\n{model}"))
}

fn inside(part: &Part, p: DVec3) -> bool {
    pipeline::function(part, None, &Run::new()).unwrap().inside(p)
}

fn volume(part: &Part, size: f64) -> f64 {
    let how = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    mesh_part(part, &how, &Run::new()).unwrap().mesh.volume()
}

/// Points in a box, the same each time.
fn points(count: u32, half: f64) -> impl Iterator<Item = DVec3> {
    let shares = [0.819_172_513_396, 0.671_043_606_703, 0.549_700_477_901];
    (1..=count).map(move |i| DVec3::from_array(shares.map(|s| half * (2.0 * (s * f64::from(i)).fract() - 1.0))))
}

// ------------------------------------------------------------------------------------------------------ round trips

const PARTS: [(&str, f64); 7] = [
    ("part(box((2, 2, 2)))", 8.0),
    ("part(sphere(1.2, at=(0.1, 0.2, 0.3)))", 4.0 / 3.0 * PI * 1.728),
    ("part(box((2, 2, 2)) - cylinder(0.5))", 8.0 - 0.5 * PI),
    ("part(cone(1, 0.5, 1.5).rotate(30, axis=(1, 2, 3)))", 0.5 * PI * 1.75),
    ("part(torus(1, 0.4) | sphere(0.3))", 2.0 * PI * PI * 0.16 + 4.0 / 3.0 * PI * 0.027),
    ("part(solid(1 - x**2 - 4 * y**2 - z**2))", 2.0 / 3.0 * PI),
    ("part(solid(0.5 + 0.25 * tanh(3 * x) - abs(z)) & box((2, 2, 2)))", 4.0),
];

#[test]
fn parts_come_back_with_their_volumes_and_signs() {
    for (source, exact) in PARTS {
        let dir = TempDir::new().unwrap();
        fs::write(dir.path().join("a.py"), source).unwrap();
        good(&dir, &["convert", "a.py", "-o", "a.3mf"]);
        let bytes = fs::read(dir.path().join("a.3mf")).unwrap();
        let (own, back) = (parse(source, &[]).unwrap(), parse_3mf(&bytes).unwrap());
        let models = [&own, &back].map(|p| pipeline::function(p, None, &Run::new()).unwrap());
        for p in points(4000, 1.6) {
            assert_eq!(models[0].inside(p), models[1].inside(p), "{source} at {p}");
        }
        let (ours, theirs) = (volume(&own, 0.1), volume(&back, 0.1));
        assert!(relative_eq!(theirs, exact, epsilon = 0.0, max_relative = 0.01), "{source}: {theirs}, not {exact}");
        assert!(abs_diff_eq!(theirs, ours, epsilon = 0.002 * exact), "{source}: {theirs}, not {ours}");
        // The same bytes again, whether from the same part or by way of the file's own formula.
        good(&dir, &["convert", "a.py", "-o", "b.3mf"]);
        assert_eq!(fs::read(dir.path().join("b.3mf")).unwrap(), bytes, "{source}");
    }
}

#[test]
fn units_come_back() {
    let dir = TempDir::new().unwrap();
    for (unit, back, radius) in [
        ("m", "m", 1.0),
        ("dm", "cm", 10.0),
        ("cm", "cm", 1.0),
        ("mm", "mm", 1.0),
        ("um", "um", 1.0),
        ("in", "in", 1.0),
        ("ft", "ft", 1.0),
    ] {
        fs::write(dir.path().join("a.py"), format!("units({unit:?})\npart(sphere(1))")).unwrap();
        good(&dir, &["convert", "a.py", "-o", "a.3mf"]);
        let part = parse_3mf(&fs::read(dir.path().join("a.3mf")).unwrap()).unwrap();
        assert_eq!(part.units.as_deref(), Some(back));
        assert!(inside(&part, DVec3::X * 0.99 * radius) && !inside(&part, DVec3::X * 1.01 * radius), "{unit}");
    }
}

#[test]
fn what_has_no_formula_is_not_written() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("a.py"), "part(box((1, 1, 1)).blend(sphere(0.6), 0.1))").unwrap();
    let out = rvachev(&dir, &["convert", "a.py", "-o", "a.3mf"]);
    assert_eq!(out.status.code(), Some(3), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(!dir.path().join("a.3mf").exists());
}

// ------------------------------------------------------------------------------------------------------------ nodes

/// Where nodes are computed.
const P: DVec3 = DVec3::new(0.3, 0.7, -0.4);

/// Nodes, the output that is looked at, and its value at the point. `p` has the coordinates, `two` and `v` are 2 and (1, 2, 3).
fn nodes() -> Vec<(&'static str, &'static str, f64)> {
    let (x, y, z) = (P.x, P.y, P.z);
    vec![
        ("constant n @value=2.5", "n.value", 2.5),
        ("constvec n @x=1 @y=2 @z=3; dot d A=v:n.vector B=v:inputs.pos", "d.result", x + 2.0 * y + 3.0 * z),
        (
            "constmat n @matrix=1_2_3_4_0_1_0_0_0_0_1_0_0_0_0_1; matvecmultiplication m A=m:n.matrix B=v:inputs.pos; decomposevector d A=v:m.result",
            "d.x",
            x + 2.0 * y + 3.0 * z + 4.0,
        ),
        ("composevector n x=s:p.y y=s:p.z z=s:p.x; decomposevector d A=v:n.result", "d.y", z),
        ("vectorfromscalar n A=s:p.x; dot d A=v:n.result B=v:v.vector", "d.result", 6.0 * x),
        (
            "composematrix n m00=s:p.x m01=s:p.x m02=s:p.x m03=s:p.y m10=s:two.value m11=s:p.x m12=s:p.x m13=s:p.z m20=s:p.x m21=s:p.x m22=s:p.x m23=s:p.x m30=s:p.x m31=s:p.x m32=s:p.x m33=s:p.x; matvecmultiplication m A=m:n.result B=v:v.vector; decomposevector d A=v:m.result",
            "d.y",
            2.0 + 5.0 * x + z,
        ),
        (
            "matrixfromcolumns n A=v:inputs.pos B=v:v.vector C=v:v.vector D=v:inputs.pos; matvecmultiplication m A=m:n.result B=v:v.vector; decomposevector d A=v:m.result",
            "d.x",
            x + 2.0 + 3.0 + x,
        ),
        (
            "matrixfromrows n A=v:inputs.pos B=v:v.vector C=v:v.vector D=v:inputs.pos; matvecmultiplication m A=m:n.result B=v:v.vector; decomposevector d A=v:m.result",
            "d.x",
            x + 2.0 * y + 3.0 * z,
        ),
        (
            "matrixfromrows n A=v:inputs.pos B=v:v.vector C=v:v.vector D=v:v.vector; transpose t A=m:n.result; matvecmultiplication m A=m:t.result B=v:v.vector; decomposevector d A=v:m.result",
            "d.x",
            x + 2.0 + 3.0 + 1.0,
        ),
        // The inverse takes the product back.
        (
            "constmat n @matrix=2_1_0_4_0_1_5_0_1_0_1_0_0_0_0_1; matvecmultiplication m A=m:n.matrix B=v:inputs.pos; inverse i A=m:n.matrix; matvecmultiplication k A=m:i.result B=v:m.result; decomposevector d A=v:k.result",
            "d.z",
            z,
        ),
        ("addition n A=s:p.x B=s:p.y", "n.result", x + y),
        ("subtraction n A=s:p.x B=s:p.y", "n.result", x - y),
        ("multiplication n A=s:p.x B=s:p.y", "n.result", x * y),
        ("multiplication n A=v:inputs.pos B=v:inputs.pos; decomposevector d A=v:n.result", "d.z", z * z),
        ("division n A=s:p.x B=s:p.y", "n.result", x / y),
        ("cross n A=v:inputs.pos B=v:v.vector; decomposevector d A=v:n.result", "d.x", y * 3.0 - z * 2.0),
        ("cross n A=v:inputs.pos B=v:v.vector; decomposevector d A=v:n.result", "d.y", z - 3.0 * x),
        ("sin n A=s:p.x", "n.result", x.sin()),
        ("cos n A=s:p.x", "n.result", x.cos()),
        ("tan n A=s:p.x", "n.result", x.tan()),
        ("division h A=s:p.x B=s:two.value; arcsin n A=s:h.result", "n.result", (x / 2.0).asin()),
        ("division h A=s:p.x B=s:two.value; arccos n A=s:h.result", "n.result", (x / 2.0).acos()),
        ("arctan n A=s:p.x", "n.result", x.atan()),
        ("addition h A=s:p.x B=s:two.value; arctan2 n A=s:p.y B=s:h.result", "n.result", y.atan2(x + 2.0)),
        ("min n A=s:p.x B=s:p.y", "n.result", x),
        ("max n A=s:p.x B=s:p.y", "n.result", y),
        ("abs n A=s:p.z", "n.result", -z),
        ("abs n A=v:inputs.pos; decomposevector d A=v:n.result", "d.z", -z),
        (
            "addition h A=s:p.z B=s:p.z; constant c @value=0.3; fmod n A=s:h.result B=s:c.value",
            "n.result",
            (2.0 * z) % 0.3,
        ),
        (
            "addition h A=s:p.z B=s:p.z; constant c @value=0.3; mod n A=s:h.result B=s:c.value",
            "n.result",
            (2.0 * z).rem_euclid(0.3),
        ),
        ("addition h A=s:p.x B=s:two.value; pow n A=s:h.result B=s:two.value", "n.result", (x + 2.0).powi(2)),
        ("addition h A=s:p.x B=s:two.value; sqrt n A=s:h.result", "n.result", (x + 2.0).sqrt()),
        ("exp n A=s:p.x", "n.result", x.exp()),
        (
            "addition h A=s:p.x B=s:two.value; addition k A=s:h.result B=s:two.value; log n A=s:k.result",
            "n.result",
            (x + 4.0).ln(),
        ),
        (
            "addition h A=s:p.x B=s:two.value; addition k A=s:h.result B=s:two.value; log2 n A=s:k.result",
            "n.result",
            (x + 4.0).log2(),
        ),
        (
            "addition h A=s:p.x B=s:two.value; addition k A=s:h.result B=s:two.value; log10 n A=s:k.result",
            "n.result",
            (x + 4.0).log10(),
        ),
        ("select n A=s:p.x B=s:p.y C=s:p.z D=s:two.value", "n.result", z),
        ("select n A=s:p.y B=s:p.x C=s:p.z D=s:two.value", "n.result", 2.0),
        ("constant c @value=0.5; clamp n A=s:p.z min=s:p.x max=s:c.value", "n.result", x),
        ("constant c @value=0.5; clamp n A=s:p.y min=s:p.x max=s:c.value", "n.result", 0.5),
        ("cosh n A=s:p.x", "n.result", x.cosh()),
        ("sinh n A=s:p.x", "n.result", x.sinh()),
        ("tanh n A=s:p.x", "n.result", x.tanh()),
        ("round n A=s:p.y", "n.result", 1.0),
        ("ceil n A=s:p.x", "n.result", 1.0),
        ("floor n A=s:p.z", "n.result", -1.0),
        ("sign n A=s:p.z", "n.result", -1.0),
        ("fract n A=s:p.z", "n.result", 1.0 + z),
        ("length n A=v:inputs.pos", "n.result", P.length()),
        // A function of the model: the distance from the ball of radius 0.8.
        (
            "constresourceid r @value=5; functioncall n functionID=r:r.value pos=v:inputs.pos >s:shape",
            "n.shape",
            P.length() - 0.8,
        ),
    ]
}

#[test]
fn every_node_has_its_value() {
    let mut words: Vec<&str> = Vec::new();
    for (nodes, out, value) in nodes() {
        words.extend(nodes.split(';').filter_map(|n| n.split_whitespace().next()));
        // Just below and above the value at the point; what is added is zero there, and keeps constants from being folded.
        for (shift, is_inside) in [(1e-9, true), (-1e-9, false)] {
            let all = format!(
                "decomposevector p A=v:inputs.pos; constant two @value=2; constvec v @x=1 @y=2 @z=3; {nodes}; \
                 constant px @value={}; subtraction zero A=s:p.x B=s:px.value; addition moved A=s:{out} B=s:zero.result; \
                 constant limit @value={:?}; subtraction shape A=s:moved.result B=s:limit.value",
                P.x,
                value + shift
            );
            let resources = function(5, BALL, "s.result")
                + &function(1, &all, "shape.result")
                + &mesh_object(2, 2.0, false)
                + &levelset("");
            assert_eq!(inside(&read(&model(&resources, ITEM)), P), is_inside, "{nodes}: {value}");
        }
    }
    let known = "addition subtraction multiplication division constant constvec constmat composevector vectorfromscalar \
        decomposevector composematrix matrixfromcolumns matrixfromrows dot cross matvecmultiplication transpose inverse sin cos \
        tan arcsin arccos arctan arctan2 min max abs fmod mod pow sqrt exp log log2 log10 select clamp cosh sinh tanh round ceil \
        floor sign fract functioncall length constresourceid";
    for word in known.split_whitespace() {
        assert!(words.contains(&word), "{word}");
    }
}

// -------------------------------------------------------------------------------------------------------- placements

#[test]
fn items_components_and_transforms_place_level_sets() {
    let ball = function(1, BALL, "s.result") + &mesh_object(2, 2.0, false);
    let components = r#"<object id="10"><components><component objectid="9" transform="1 0 0 0 1 0 0 0 1 5 0 0"/><component objectid="9"/></components></object>"#;
    let item = r#"<item objectid="10" transform="2 0 0 0 2 0 0 0 2 0 0 1"/>"#;
    let part = read(&model(&(ball.clone() + &levelset("") + components), item));
    for (p, expected) in [
        (DVec3::new(0.0, 0.0, 1.0 + 1.59), true),
        (DVec3::new(0.0, 0.0, 1.0 + 1.61), false),
        (DVec3::new(10.0 + 1.59, 0.0, 1.0), true),
        (DVec3::new(10.0 + 1.61, 0.0, 1.0), false),
    ] {
        assert_eq!(inside(&part, p), expected, "{p}");
    }
    // The transform of a level set leads from the object to the function: the ball is half as large.
    let part = read(&model(&(ball.clone() + &levelset(r#"transform="2 0 0 0 2 0 0 0 2 0 0 0""#)), ITEM));
    assert!(inside(&part, DVec3::X * 0.39) && !inside(&part, DVec3::X * 0.41));
    // A turned item keeps the volume; so does one that mirrors.
    for turn in ["0.8 0.6 0 -0.6 0.8 0 0 0 1 3 0 0", "-1 0 0 0 1 0 0 0 1 0 0 0"] {
        let part =
            read(&model(&(ball.clone() + &levelset("")), &format!(r#"<item objectid="9" transform="{turn}"/>"#)));
        let exact = 4.0 / 3.0 * PI * 0.512;
        assert!(relative_eq!(volume(&part, 0.1), exact, epsilon = 0.0, max_relative = 0.01), "{turn}");
    }
}

#[test]
fn the_least_feature_is_the_least_edge() {
    let ball = function(1, BALL, "s.result") + &mesh_object(2, 2.0, false);
    let least = |attributes: &str, item: &str| read(&model(&(ball.clone() + &levelset(attributes)), item)).mesh.least;
    assert_eq!(least("", ITEM), None);
    assert_eq!(least(r#"minfeaturesize="0""#, ITEM), None);
    assert_eq!(least(r#"minfeaturesize="0.25""#, ITEM), Some(SizeRequest::Length(0.25)));
    // The size is one of the object: an item that is twice as large doubles it.
    let twice = r#"<item objectid="9" transform="2 0 0 0 2 0 0 0 2 0 0 0"/>"#;
    let found = least(r#"minfeaturesize="0.25""#, twice).unwrap();
    let SizeRequest::Length(found) = found else { panic!("{found:?}") };
    assert_abs_diff_eq!(found, 0.5, epsilon = 1e-12);
}

#[test]
fn a_fallback_value_stands_where_a_function_has_none() {
    // 0.3 - sqrt(0.64 - r * r) is negative in a ball, and has no value beyond r = 0.8.
    let nodes = "length l A=v:inputs.pos; multiplication q A=s:l.result B=s:l.result; constant c @value=0.64; \
         subtraction d A=s:c.value B=s:q.result; sqrt r A=s:d.result; constant h @value=0.3; \
         subtraction s A=s:h.value B=s:r.result";
    let part = |attributes: &str| {
        read(&model(&(function(1, nodes, "s.result") + &mesh_object(2, 2.0, false) + &levelset(attributes)), ITEM))
    };
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let hollow = ball(0.55_f64.sqrt());
    let found = volume(&part(r#"fallbackvalue="1""#), 0.1);
    assert_relative_eq!(found, hollow, epsilon = 0.0, max_relative = 0.01);
    // Below zero is inside: all of the box but a shell.
    let inner = part(r#"fallbackvalue="-1""#);
    for p in points(2000, 1.9) {
        let r = p.length();
        assert_eq!(inside(&inner, p), r > 0.8 || r * r < 0.55, "{p}");
    }
    let outer = part(r#"fallbackvalue="2.5""#);
    for p in points(2000, 1.9) {
        assert_eq!(inside(&outer, p), p.length_squared() < 0.55, "{p}");
    }
    // A function with a value everywhere is what it is without the attribute.
    let plain = |attributes: &str| {
        read(&model(&(function(1, BALL, "s.result") + &mesh_object(2, 2.0, false) + &levelset(attributes)), ITEM))
    };
    assert_eq!(volume(&plain(r#"fallbackvalue="-1""#), 0.2), volume(&plain(""), 0.2));
}

#[test]
fn meshes_cut_level_sets_off() {
    let all = "decomposevector p A=v:inputs.pos; constant c @value=9; subtraction s A=s:p.x B=s:c.value";
    let of = |octahedron: bool, attributes: &str| {
        let resources = function(1, all, "s.result") + &mesh_object(2, 1.0, octahedron) + &levelset(attributes);
        volume(&read(&model(&resources, ITEM)), 0.1)
    };
    assert_abs_diff_eq!(of(false, ""), 8.0, epsilon = 1e-9);
    assert_abs_diff_eq!(of(true, ""), 4.0 / 3.0, epsilon = 1e-9);
    assert_abs_diff_eq!(of(true, r#"meshbboxonly="true""#), 8.0, epsilon = 1e-9);
}

// ------------------------------------------------------------------------------------------------------------ faults

/// What is wrong with a model, and what the message says.
fn faults() -> Vec<(String, &'static str)> {
    let with = |nodes: &str, out: &str| simple(nodes, out);
    let object = |shape: &str| model(&format!(r#"<object id="9">{shape}</object>"#), ITEM);
    let ball = |extra: &str, build: &str| {
        model(&(function(1, BALL, "s.result") + &mesh_object(2, 2.0, false) + &levelset("") + extra), build)
    };
    let ball_of = |attributes: &str| {
        model(&(function(1, BALL, "s.result") + &mesh_object(2, 2.0, false) + &levelset(attributes)), ITEM)
    };
    let called = |id: u32| {
        format!("constresourceid r @value={id}; functioncall n functionID=r:r.value pos=v:inputs.pos >s:shape")
    };
    let components = |id: u32, of: u32| {
        let one = format!(r#"<component objectid="{of}"/>"#).repeat(10);
        format!(r#"<object id="{id}"><components>{one}</components></object>"#)
    };
    let bombs: String = (20..40).map(|i| components(i, i - 1)).collect();
    vec![
        ("<levelset".into(), "XML"),
        ("<levelset/>".into(), "a model should stand here"),
        ("<!DOCTYPE a [<!ENTITY b 'levelset'>]><model/>".into(), "XML"),
        (ball("", ""), "nothing is built"),
        (ball("", r#"<item objectid="77"/>"#), "no resource 77"),
        (ball("", r#"<item objectid="1"/>"#), "not an object"),
        (ball("", r#"<item objectid="9" transform="1 2 3"/>"#), "12 finite numbers"),
        (ball("", r#"<item objectid="9" transform="1 0 0 0 0 0 0 0 1 0 0 0"/>"#), "flat"),
        (ball("", r#"<item objectid="9"/><item objectid="2"/>"#), "object 2 is a mesh"),
        (ball(&components(19, 19), r#"<item objectid="19"/>"#), "circle"),
        (ball(&(components(19, 9) + &bombs), r#"<item objectid="39"/>"#), "the limit"),
        (ball(&levelset(""), ITEM), "two resources have the number 9"),
        (object(""), "is empty"),
        (object("<v:levelset/>"), "functionid"),
        (ball_of(r#"minfeaturesize="-1""#), "no size is less than 0"),
        (ball_of(r#"minfeaturesize="wide""#), "no finite number"),
        (ball_of(r#"fallbackvalue="outside""#), "no finite number"),
        (object(r#"<v:levelset functionid="x" channel="shape" meshid="2"/>"#), "no number"),
        (object(r#"<v:levelset functionid="9" channel="shape" meshid="2"/>"#), "is <object>"),
        (with(BALL, "s.result").replace(r#"channel="shape""#, r#"channel="other""#), "no output \"other\""),
        (with(BALL, "s.result").replace(r#"meshid="2""#, r#"meshid="1""#), "no object with a mesh"),
        (
            with(BALL, "s.result").replace(r#"v1="7""#, r#"v1="70""#).replace(r#"v2="7""#, r#"v2="70""#),
            "but there are 8",
        ),
        (with(BALL, "missing.result"), "no node \"missing\""),
        (with(BALL, "s.other"), "no output of a node"),
        (with(BALL, "inputs.radius"), "without an input"),
        (with("abs a A=s:b.result; abs b A=s:a.result", "b.result"), "circle"),
        (with("abs a A=s:a.result", "a.result"), "circle"),
        (with("length l A=v:inputs.pos; constant l @value=1", "l.result"), "two nodes"),
        (with("constant c @value=inf; length l A=v:inputs.pos; min m A=s:l.result B=s:c.value", "m.result"), "finite"),
        (
            with(
                "constant c @value=0; division d A=s:c.value B=s:c.value; length l A=v:inputs.pos; min m A=s:l.result B=s:d.result",
                "m.result",
            ),
            "finite",
        ),
        (with("constant c @value=1", "c.value"), "empty"),
        (
            with("length l A=v:inputs.pos; addition a A=s:l.result B=v:inputs.pos", "a.result"),
            "does not take a scalar, a vector",
        ),
        (with("length l A=s:inputs.pos", "l.result"), "is a vector"),
        (with("length l", "l.result"), "no input \"A\""),
        (
            with(
                "constmat m @matrix=1_2; matvecmultiplication k A=m:m.matrix B=v:inputs.pos; length l A=v:k.result",
                "l.result",
            ),
            "16",
        ),
        (with("mesh m pos=v:inputs.pos", "m.distance"), "<mesh>"),
        (with("unsignedmesh m pos=v:inputs.pos", "m.distance"), "<unsignedmesh>"),
        (with("lenght l A=v:inputs.pos", "l.result"), "<lenght>"),
        (with(&called(1), "n.shape"), "calls itself"),
        (with(&called(9), "n.shape"), "is <object>"),
        (
            model(
                &(r#"<v:functionfromimage3d id="1" image3did="4"/>"#.to_string()
                    + &mesh_object(2, 2.0, false)
                    + &levelset("")),
                ITEM,
            ),
            "<functionfromimage3d>",
        ),
    ]
}

#[test]
fn faults_are_told_with_their_place() {
    let dir = TempDir::new().unwrap();
    for (model, told) in faults() {
        fs::write(dir.path().join("a.3mf"), packed(&model)).unwrap();
        let out = rvachev(&dir, &["mesh", "a.3mf", "-o", "a.off"]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(3), "{told}: {said}\n{model}");
        let said: String = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(told) && said.contains("line "), "{told}: {said}\n{model}");
    }
    let empty = package(&[]);
    let lost = package(&[("_rels/.rels", "<Relationships/>")]);
    let away = package(&[("_rels/.rels", RELATIONS)]);
    for (bytes, told) in
        [(b"no zip".to_vec(), "no zip"), (empty, "_rels/.rels"), (lost, "no relationship"), (away, "3D/3dmodel.model")]
    {
        fs::write(dir.path().join("a.3mf"), bytes).unwrap();
        let out = rvachev(&dir, &["mesh", "a.3mf", "-o", "a.off"]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(3) && said.contains(told), "{told}: {said}");
    }
}

#[test]
fn calls_that_multiply_are_bounded() {
    // Each function calls the next one ten times.
    let mut resources = String::new();
    for id in 10..40 {
        let mut nodes = format!("constresourceid r @value={}", id + 1);
        for k in 0..10 {
            nodes += &format!("; functioncall n{k} functionID=r:r.value pos=v:inputs.pos >s:shape");
            let before = if k == 0 { "n0.shape".to_string() } else { format!("a{}.result", k - 1) };
            nodes += &format!("; addition a{k} A=s:{before} B=s:n{k}.shape");
        }
        resources += &function(id, &nodes, "a9.result");
    }
    resources += &(function(40, BALL, "s.result") + &mesh_object(2, 2.0, false));
    resources += &levelset("").replace(r#"functionid="1""#, r#"functionid="10""#);
    let e = parse_3mf(&packed(&model(&resources, ITEM))).unwrap_err().to_string();
    assert!(e.contains("the limit"), "{e}");
}

#[test]
fn damaged_packages_never_panic() {
    let bytes = packed(&simple(BALL, "s.result"));
    for n in (0..bytes.len()).step_by(7) {
        let _ = parse_3mf(&bytes[..n]);
        let mut other = bytes.clone();
        other[n] ^= 0x15;
        let _ = parse_3mf(&other);
    }
}

// ------------------------------------------------------------------------------------------------------------ meshes

#[test]
fn meshes_of_a_package_are_a_soup() {
    let dir = TempDir::new().unwrap();
    let items = r#"<item objectid="2"/><item objectid="2" transform="-1 0 0 0 1 0 0 0 1 10 0 0"/>"#;
    fs::write(dir.path().join("a.3mf"), packed(&model(&mesh_object(2, 1.0, false), items))).unwrap();
    good(&dir, &["mesh", "a.3mf", "-o", "b.off", "-q"]);
    let mesh = io::read(&dir.path().join("b.off"), &Run::new()).unwrap();
    assert_abs_diff_eq!(mesh.volume(), 16.0, epsilon = 1e-9);
}

/// A box whose coordinates no short decimal holds, with names that are awkward in XML.
fn awkward() -> TriMesh {
    let p = |i: u32| {
        let bit = |b: u32| if i >> b & 1 == 1 { 1.0 / 3.0 } else { -PI };
        DVec3::new(bit(0), bit(1) * 1e-7, bit(2) * 1e9)
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = TriMesh { nodes: (0..8).map(p).collect(), ..TriMesh::default() };
    for (face, [a, b, c, d]) in quads.into_iter().enumerate() {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.labels.extend([face as u32; 2]);
    }
    mesh.faces = ["a & b", "  äußere Fläche\n", "", "50%25 \"x\"", "<b/>", "it's"].map(String::from).to_vec();
    mesh
}

#[test]
fn meshes_come_back_bit_by_bit_and_damaged_ones_are_refused() {
    let (mesh, run) = (awkward(), Run::new());
    let write = || {
        let mut bytes = Vec::new();
        io::encode(&mut bytes, &mesh, Format::ThreeMf, &WriteOptions::default(), &run).unwrap();
        bytes
    };
    let bytes = write();
    assert_eq!(bytes, write());
    let read = |bytes: &[u8]| io::read_bytes(bytes, Format::ThreeMf, Path::new("x"));
    assert_eq!(read(&bytes).unwrap(), mesh);
    for n in 0..bytes.len() {
        match read(&bytes[..n]) {
            Ok(short) => assert!(short.triangles.len() == 12 && n + 6 > bytes.len(), "cut at {n}"),
            Err(e) => assert!(matches!(e, Error::Input { .. }), "cut at {n}: {e:?}"),
        }
        for flip in [0x01, 0x15, 0x80, 0xff] {
            let mut other = bytes.clone();
            other[n] ^= flip;
            if let Ok(m) = read(&other) {
                assert!(m.triangles.iter().flatten().all(|v| (*v as usize) < m.nodes.len()), "{n}");
            }
        }
    }
}

const TWO: &str = "units(\"cm\")\npart((box((2, 2, 2)).name(\"a<b>\") - cylinder(0.5).name(\"hole\")) | sphere(1, at=(4, 0, 0)).name(\"ball & chain\"))";

#[test]
fn meshes_are_written_with_faces_as_materials() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("a.py"), TWO).unwrap();
    good(&dir, &["mesh", "a.py", "--size", "0.3", "-o", "a.3mf", "-o", "a.ply", "-q"]);
    let read = |name: &str| io::read(&dir.path().join(name), &Run::new()).unwrap();
    let (ours, kept) = (read("a.3mf"), read("a.ply"));
    assert_relative_eq!(ours.volume(), kept.volume(), epsilon = 0.0, max_relative = 1e-12);
    let names = |m: &TriMesh| {
        let mut all = m.faces.clone();
        all.sort();
        all
    };
    assert_eq!(names(&ours), names(&kept));
}

// ------------------------------------------------------------------------------------------------------------ lib3mf

#[test]
fn lib3mf_reads_our_level_sets_and_we_read_its() {
    for (source, _) in PARTS {
        let dir = TempDir::new().unwrap();
        fs::write(dir.path().join("a.py"), format!("units(\"cm\")\n{source}")).unwrap();
        good(&dir, &["convert", "a.py", "-o", "a.3mf"]);
        let told = ask(&dir, "a.3mf");
        assert_eq!((&told["warnings"], &told["items"]), (&serde_json::json!([]), &Value::from(1)), "{told}");
        let expected = serde_json::json!([{"name": "a", "channel": "shape", "box": true, "function": "a"}]);
        assert_eq!(told["levelsets"], expected, "{told}");
        assert_eq!(told["unit"], "CentiMeter");
        let parts = ["a.3mf", "again.3mf"].map(|f| parse_3mf(&fs::read(dir.path().join(f)).unwrap()).unwrap());
        let models = parts.each_ref().map(|p| pipeline::function(p, None, &Run::new()).unwrap());
        for p in points(1000, 1.6) {
            assert_eq!(models[0].inside(p), models[1].inside(p), "{source} at {p}");
        }
    }
}

#[test]
fn lib3mf_reads_our_meshes() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("a.py"), TWO).unwrap();
    good(&dir, &["mesh", "a.py", "--size", "0.3", "-o", "a.3mf", "-q"]);
    let told = ask(&dir, "a.3mf");
    assert_eq!((&told["warnings"], &told["items"]), (&serde_json::json!([]), &Value::from(2)), "{told}");
    assert_eq!(told["unit"], "CentiMeter");
    let meshes = told["meshes"].as_array().unwrap();
    assert!(meshes.len() == 2 && meshes.iter().all(|m| m["closed"] == true), "{told}");
    let mesh = io::read(&dir.path().join("a.3mf"), &Run::new()).unwrap();
    let triangles: u64 = meshes.iter().map(|m| m["triangles"].as_u64().unwrap()).sum();
    assert_eq!(triangles, mesh.triangles.len() as u64);
    let names: Vec<_> = told["materials"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for name in ["a<b>.xmin", "hole", "ball & chain"] {
        assert!(names.contains(&name), "{names:?}");
    }
}
