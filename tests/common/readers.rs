//! What must hold of every reader for any bytes: one function for each. The property tests of `tests/readers.rs` and the targets
//! of `fuzz/` call the same ones, so neither knows of something that the other does not.

// A target of `fuzz/` includes this file for one function alone.
#![allow(dead_code)]

use std::path::Path;
use std::sync::OnceLock;

use rvachev::Run;
use rvachev::error::{Error, Result};
use rvachev::implicit::part::{Part, parse, parse_3mf, parse_csg, parse_model, parse_vm};
use rvachev::implicit::{Implicit, RSystem};
use rvachev::io::{self, Format, PointRows};
use rvachev::parametric::step::interpret;
use rvachev::pipeline::{self, BrickPlan, MeshOptions, PlanSource, SizeRequest};

/// Longer inputs are passed over, in bytes: each length a format has room for is in the samples, and an input takes milliseconds.
pub const LONGEST: usize = 1 << 16;

/// Rows of points that are asked for at a time: fewer than a sample has, so that a table is read in more than one block.
const ROWS: usize = 3;

/// A reader of the library, and what must hold of it.
pub struct Reader {
    /// The name of its target in `fuzz/fuzz_targets`, and of its property test.
    pub name: &'static str,
    /// Reads bytes and tells whether they were read, not refused; panics where what must hold does not.
    pub holds: fn(&[u8]) -> bool,
    /// The formats of meshes it reads, if any.
    pub formats: &'static [Format],
}

const fn other(name: &'static str, holds: fn(&[u8]) -> bool) -> Reader {
    Reader { name, holds, formats: &[] }
}

const fn mesh(name: &'static str, holds: fn(&[u8]) -> bool, formats: &'static [Format]) -> Reader {
    Reader { name, holds, formats }
}

/// Every reader there is.
pub const READERS: [Reader; 19] = [
    other("part", part),
    other("vm", vm),
    other("csg", csg),
    other("levelset", levelset),
    other("step", step),
    other("points", points),
    other("plan", plan),
    other("piece", piece),
    mesh("stl", stl, &[Format::StlBinary, Format::StlAscii]),
    mesh("obj", obj, &[Format::Obj]),
    mesh("ply", ply, &[Format::Ply]),
    mesh("off", off, &[Format::Off]),
    mesh("msh", msh, &[Format::Msh]),
    mesh("inp", inp, &[Format::Inp]),
    mesh("bdf", bdf, &[Format::Bdf]),
    mesh("medit", medit, &[Format::Medit]),
    mesh("su2", su2, &[Format::Su2]),
    mesh("vtk", vtk, &[Format::Vtu, Format::Vtp]),
    mesh("threemf", threemf, &[Format::ThreeMf]),
];

/// What was read, unless it was refused, which must be as bad input.
fn read<T>(result: Result<T>) -> Option<T> {
    result.map_err(|e| assert!(matches!(e, Error::Input { .. }), "refused, though not as bad input: {e:?}")).ok()
}

// -------------------------------------------------------------------------------------------------------------- parts

/// The function of a part that was read is asked at the middle of its box. Whether there is a solid is known only of the whole.
fn solid(part: Result<Part>) -> bool {
    let Some(part) = read(part) else { return false };
    let Some(solid) = &part.solid else { return true };
    if let Ok(model) = Implicit::new(solid, RSystem::default(), part.domain) {
        let center = model.bounds().center();
        assert!(center.is_finite(), "the box {:?} is not finite", model.bounds());
        let _ = (model.inside(center), model.value(center), model.gradient(center));
    }
    true
}

fn texts(bytes: &[u8], parse: fn(&str) -> Result<Part>) -> bool {
    bytes.len() <= LONGEST && solid(parse(&String::from_utf8_lossy(bytes)))
}

/// Part files.
pub fn part(bytes: &[u8]) -> bool {
    texts(bytes, |text| parse(text, &[]))
}

/// Formula files.
pub fn vm(bytes: &[u8]) -> bool {
    texts(bytes, parse_vm)
}

/// OpenSCAD's trees.
pub fn csg(bytes: &[u8]) -> bool {
    texts(bytes, parse_csg)
}

/// 3MF packages with level sets, and the model in one as text: changes of what is compressed hardly reach it.
pub fn levelset(bytes: &[u8]) -> bool {
    bytes.len() <= LONGEST && (solid(parse_3mf(bytes)) || texts(bytes, parse_model))
}

/// STEP files: the syntax, and what the records mean.
pub fn step(bytes: &[u8]) -> bool {
    bytes.len() <= LONGEST
        && read(io::step::parse_step(bytes)).is_some_and(|file| read(interpret(&file, &Run::new())).is_some())
}

// ------------------------------------------------------------------------------------------------------------- tables

/// Tables of points.
pub fn points(bytes: &[u8]) -> bool {
    if bytes.len() > LONGEST {
        return false;
    }
    let mut rows = PointRows::new(bytes, "points.csv");
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    let mut count = 0;
    loop {
        if read(rows.read(ROWS, &mut points, &mut lines)).is_none() {
            return false;
        }
        if points.is_empty() {
            return count > 0;
        }
        count += points.len();
        assert!(points.len() == lines.len() && points.len() <= ROWS);
        assert!(points.iter().all(|p| p.is_finite()));
        assert!(lines.is_sorted());
    }
}

// ------------------------------------------------------------------------------------------------------------- bricks

/// A plan of one brick.
pub fn small_plan() -> &'static BrickPlan {
    static PLAN: OnceLock<BrickPlan> = OnceLock::new();
    PLAN.get_or_init(|| {
        let path = "ball.py".into();
        let source = PlanSource { path, text: "part(sphere(1))\n".into(), overrides: Vec::new() };
        let options = MeshOptions { size: Some(SizeRequest::Length(0.5)), ..MeshOptions::default() };
        BrickPlan::new(source, &options, [1, 1, 1], &Run::new()).expect("a ball can be planned")
    })
}

/// Plans of meshes made brick by brick. One that was read comes back from its own text.
pub fn plan(bytes: &[u8]) -> bool {
    if bytes.len() > LONGEST {
        return false;
    }
    let Some(plan) = read(BrickPlan::parse(&String::from_utf8_lossy(bytes))) else { return false };
    let text = plan.to_json().expect("a plan that was read can be written");
    let again = BrickPlan::parse(&text).expect("a plan that was written can be read");
    assert_eq!(again.digest(), plan.digest());
    true
}

/// Pieces that bricks are made of.
pub fn piece(bytes: &[u8]) -> bool {
    bytes.len() <= LONGEST && read(pipeline::merge_pieces(small_plan(), [(0, bytes)], &Run::new())).is_some()
}

// ------------------------------------------------------------------------------------------------------------- meshes

/// Bytes as a format of meshes: what is read is a mesh that others may use.
fn triangles(bytes: &[u8], format: Format) -> bool {
    if bytes.len() > LONGEST {
        return false;
    }
    let Some(mesh) = read(io::read_bytes(bytes, format, Path::new("mesh"))) else { return false };
    mesh.validate().expect("what is read is a mesh");
    assert!(!mesh.triangles.is_empty());
    assert_eq!(mesh.triangles.len(), mesh.labels.len());
    true
}

/// STL, text and binary.
pub fn stl(bytes: &[u8]) -> bool {
    // Which spelling is hinted at does not matter.
    let read = triangles(bytes, Format::StlBinary);
    assert_eq!(triangles(bytes, Format::StlAscii), read);
    read
}

/// OBJ.
pub fn obj(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Obj)
}

/// PLY.
pub fn ply(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Ply)
}

/// OFF.
pub fn off(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Off)
}

/// gmsh's MSH.
pub fn msh(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Msh)
}

/// Abaqus INP.
pub fn inp(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Inp)
}

/// Nastran BDF.
pub fn bdf(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Bdf)
}

/// Medit.
pub fn medit(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Medit)
}

/// SU2.
pub fn su2(bytes: &[u8]) -> bool {
    triangles(bytes, Format::Su2)
}

/// VTU and VTP, which one reader reads.
pub fn vtk(bytes: &[u8]) -> bool {
    let grid = triangles(bytes, Format::Vtu);
    triangles(bytes, Format::Vtp) || grid
}

/// Meshes in 3MF packages.
pub fn threemf(bytes: &[u8]) -> bool {
    triangles(bytes, Format::ThreeMf)
}
