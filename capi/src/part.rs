//! Parts: a solid with everything needed to mesh it, what is asked of it, and files meshed as they are.

use std::ffi::{CStr, c_char, c_int};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use rvachev::implicit::Implicit;
use rvachev::implicit::part::{Part, PartGroup, parse};
use rvachev::io::write_atomic;
use rvachev::pipeline::{self, Meshed};
use rvachev::spatial::Aabb;
use rvachev::{DVec3, Error, Place, Run};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, input, release, slot, usage};
use crate::mesh::{RvMesh, Source, give};
use crate::options::{Asked, RvOptions, asked};
use crate::pass::{Chars, Items, Out};
use crate::solid::{Kind, RvSolid};
use crate::text::{RvText, json, quoted, read_within, text};
use crate::work::work;

struct State {
    part: Part,
    /// The function of the part, made when it is first asked for.
    model: Option<Arc<Implicit>>,
}

/// A part, as a handle.
pub struct RvPart(Mutex<State>);

impl RvPart {
    /// The part as it is at the moment.
    pub fn part(&self) -> Part {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).part.clone()
    }

    fn change(&self, what: impl FnOnce(&mut Part) -> Result<(), Failure>) -> Result<c_int, Failure> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        what(&mut state.part)?;
        state.model = None;
        Ok(GOOD)
    }

    /// The part's function.
    pub fn model(&self) -> Result<Arc<Implicit>, Failure> {
        let (part, known) = {
            let state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            (state.part.clone(), state.model.clone())
        };
        if let Some(known) = known {
            return Ok(known);
        }
        let made = Arc::new(work(None, 0, |run| Ok(pipeline::function(&part, None, run)?))?);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).model = Some(made.clone());
        Ok(made)
    }
}

fn part_out(part: Part, out: &mut std::mem::MaybeUninit<*mut RvPart>) -> Result<c_int, Failure> {
    out.write(Box::into_raw(Box::new(RvPart(Mutex::new(State { part, model: None })))));
    Ok(GOOD)
}

/// Reads a part file's text. Of the options `define` is heeded.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_parse(
    source: Chars,
    options: Option<&RvOptions>,
    part: Out<'_, *mut RvPart>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(part, std::ptr::null_mut(), "part")?;
        part_out(parse(source.text("source")?, &asked(options).define)?, out)
    })
}

/// Reads a part file. Of the options `define` is heeded.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_load(
    path: Chars,
    options: Option<&RvOptions>,
    part: Out<'_, *mut RvPart>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(part, std::ptr::null_mut(), "part")?;
        part_out(pipeline::load_part(&path.path("path")?, &asked(options).define)?, out)
    })
}

/// A part of solids, of which at most one is of R-functions.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_new(
    solids: Items<Option<&RvSolid>>,
    count: usize,
    part: Out<'_, *mut RvPart>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(part, std::ptr::null_mut(), "part")?;
        let all = solids.slice(count, "solids")?;
        let mut made: Option<Part> = None;
        let mut built = Vec::new();
        for s in all {
            match &given(*s, "a solid")?.0 {
                Kind::Functions(_) if made.is_some() => {
                    return Err(input(
                        "a part is made of one solid of R-functions at most",
                        "rv_solid_union makes one of several",
                    ));
                }
                Kind::Functions(solid) => made = Some(Part::from_solid(solid.clone())),
                Kind::Built { recipes, .. } => built.extend(recipes.iter().cloned()),
            }
        }
        if all.is_empty() {
            return Err(input("a part needs a solid", ""));
        }
        let mut made = made.unwrap_or_else(|| Part::from_built(Vec::new()));
        made.built = built;
        part_out(made, out)
    })
}

/// Says the unit of length, which only files are told: "m", "dm", "cm", "mm", "um", "in" or "ft".
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_set_units(part: Option<&RvPart>, units: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let read = read_within("", &format!("units({})", quoted(units.text("units")?)), "part(sphere(1))")?;
        given(part, "part")?.change(|p| {
            p.units = read.units;
            Ok(())
        })
    })
}

/// Units by the names part files have for them.
const UNITS: [&CStr; 7] = [c"m", c"dm", c"cm", c"mm", c"um", c"in", c"ft"];

/// The unit of length, NULL where none was said.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_units(part: Option<&RvPart>, units: Out<'_, *const c_char>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(units, std::ptr::null(), "units")?;
        if let Some(said) = given(part, "part")?.part().units {
            let known = UNITS.iter().find(|u| u.to_bytes() == said.as_bytes());
            out.write(known.ok_or_else(|| input(format!("{said:?} is no unit of part files"), ""))?.as_ptr());
        }
        Ok(GOOD)
    })
}

/// Says the system of R-functions as a part file does: "R0", "minmax", "(\"Ralpha\", 0.5)" or "(\"R0m\", 2)".
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_set_rsystem(part: Option<&RvPart>, rsystem: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let said = rsystem.text("rsystem")?.trim();
        let said = if said.starts_with(['(', '"', '\'']) { said.to_string() } else { quoted(said) };
        let read = read_within("part(sphere(1), rsystem=", &said, ")")?;
        given(part, "part")?.change(|p| {
            p.rsystem = read.rsystem;
            Ok(())
        })
    })
}

/// Where to cut off what may be infinite: x0 y0 z0 x1 y1 z1; nowhere for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_set_domain(part: Option<&RvPart>, bounds: Items<f64>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let domain = self::bounds(&bounds)?;
        given(part, "part")?.change(|p| {
            p.domain = domain;
            Ok(())
        })
    })
}

/// Six numbers as a box; none for NULL.
pub fn bounds(of: &Items<f64>) -> Result<Option<Aabb>, Failure> {
    let Some(v) = of.optional(6, "bounds")? else { return Ok(None) };
    let (lo, hi) = (DVec3::from_slice(&v[..3]), DVec3::from_slice(&v[3..]));
    if lo.is_finite() && hi.is_finite() && lo.cmplt(hi).all() {
        return Ok(Some(Aabb::new(lo, hi)));
    }
    Err(input(format!("bounds need finite lo < hi in all three coordinates, not {lo} and {hi}"), ""))
}

/// Adds faces to a group, which is made if need be: those whose names fit a pattern (`*` any characters, `?` one).
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_group(part: Option<&RvPart>, name: Chars, faces: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let part = given(part, "part")?;
        let (name, faces) = (name.text("name")?, faces.text("faces")?.to_string());
        if name.is_empty() || faces.is_empty() {
            return Err(input("a group needs a name and a pattern of names of faces", ""));
        }
        part.change(|p| {
            match p.groups.iter_mut().find(|g| g.name == name) {
                Some(g) => g.patterns.push(faces),
                None => {
                    p.groups.push(PartGroup { name: name.to_string(), patterns: vec![faces], place: Place::Unknown })
                }
            }
            Ok(())
        })
    })
}

/// What is known before meshing, as JSON: surfaces, a box, names of faces and groups; of solids built from edges vertices, edges and areas.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_info(part: Option<&RvPart>, info: Out<'_, *mut RvText>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(info, std::ptr::null_mut(), "info")?;
        let part = given(part, "part")?.part();
        let info = work(None, 0, |run| Ok(pipeline::part_info(&part, run)?))?;
        out.write(text(json(&info)?));
        Ok(GOOD)
    })
}

/// The mesh of a part.
fn mesh_asked(part: &Part, asked: &Asked, run: &Run) -> rvachev::Result<Meshed> {
    pipeline::mesh_part(part, &asked.mesh.for_part(part, asked.method), run)
}

/// The mesh of a file of any kind.
fn mesh_of_file(path: &Path, asked: &Asked, run: &Run) -> rvachev::Result<Meshed> {
    let made = if pipeline::is_step(path) {
        pipeline::load_step(path, run).and_then(|m| pipeline::mesh_step(m, &asked.mesh, run))
    } else if pipeline::is_mesh(path) {
        pipeline::load_mesh(path, run).and_then(|m| pipeline::mesh_soup(&m, &asked.mesh, &asked.soup, run))
    } else {
        pipeline::load_part(path, &asked.define).and_then(|p| mesh_asked(&p, asked, run))
    };
    made.map_err(|e| e.in_file(path))
}

/// About how many triangles the mesh of a part will have.
#[unsafe(no_mangle)]
pub extern "C" fn rv_expected_triangles(
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(count, 0, "count")?;
        let (part, asked) = (given(part, "part")?.part(), asked(options));
        out.write(work(asked.run.as_ref(), asked.threads, |run| {
            Ok(pipeline::expected_triangles(run, |run| mesh_asked(&part, &asked, run))?)
        })?);
        Ok(GOOD)
    })
}

/// About how many triangles the mesh of a file will have.
#[unsafe(no_mangle)]
pub extern "C" fn rv_expected_triangles_file(
    path: Chars,
    options: Option<&RvOptions>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(count, 0, "count")?;
        let (path, asked) = (path.path("path")?, asked(options));
        out.write(work(asked.run.as_ref(), asked.threads, |run| {
            Ok(pipeline::expected_triangles(run, |run| mesh_of_file(&path, &asked, run))?)
        })?);
        Ok(GOOD)
    })
}

/// Meshes a part.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_mesh(
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    mesh: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(mesh, std::ptr::null_mut(), "mesh")?;
        let (part, asked) = (given(part, "part")?.part(), asked(options));
        let made = work(asked.run.as_ref(), asked.threads, |run| Ok(mesh_asked(&part, &asked, run)?))?;
        give(Source::Made(Box::new(made)), &asked, Some(out))
    })
}

/// Meshes a file: a part file, a STEP file, or a file of triangles.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_file(
    path: Chars,
    options: Option<&RvOptions>,
    mesh: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(mesh, std::ptr::null_mut(), "mesh")?;
        let (path, asked) = (path.path("path")?, asked(options));
        let made = work(asked.run.as_ref(), asked.threads, |run| Ok(mesh_of_file(&path, &asked, run)?))?;
        give(Source::Made(Box::new(made)), &asked, Some(out))
    })
}

/// Writes solids built from edges as a STEP file.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_write_step(part: Option<&RvPart>, path: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let (part, path) = (given(part, "part")?.part(), path.path("path")?);
        let built = work(None, 0, |run| Ok(pipeline::build(&part, run)?))?;
        let Some(brep) = built.filter(|_| part.solid.is_none()) else {
            return Err(input("only solids built from edges can be written as STEP", ""));
        };
        pipeline::save_step(&path, &brep, part.units.as_deref())?;
        Ok(GOOD)
    })
}

/// Writes a part in the format of the extension: STEP, a formula file, or a 3MF package with a level set.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_write(part: Option<&RvPart>, path: Chars, error: ErrorOut<'_>) -> c_int {
    let Ok(to) = path.path("path") else { return rv_part_write_step(part, path, error) };
    if pipeline::is_step(&to) {
        return rv_part_write_step(part, path, error);
    }
    entry(error, || {
        let part = given(part, "part")?.part();
        let name = to.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = if pipeline::is_vm(&to) {
            work(None, 0, |_| Ok(pipeline::vm_text(&part)?.into_bytes()))?
        } else if pipeline::is_3mf(&to) {
            work(None, 0, |_| Ok(pipeline::levelset_bytes(&part, &name)?))?
        } else {
            return Err(usage(format!("parts are written as step, stp, vm and 3mf, not {}", to.display())));
        };
        write_atomic(&to, |out| out.write_all(&bytes).map_err(|e| Error::io("write", &to, e)))?;
        Ok(GOOD)
    })
}

/// Frees a part. Meshes made of it stay.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_free(part: Option<Box<RvPart>>) {
    release(part);
}
