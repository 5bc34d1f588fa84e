//! What is in a surface of triangles, and methods compared on one, as JSON.

use std::ffi::c_int;

use rvachev::mesh::TriMesh;
use rvachev::{Run, pipeline};
use serde::Serialize;

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, slot};
use crate::options::{Asked, RvOptions, asked};
use crate::pass::{Chars, Out};
use crate::surface::RvSurface;
use crate::text::{RvText, json, text};
use crate::work::work;

/// Where triangles come from.
enum Triangles {
    Given(TriMesh),
    File(std::path::PathBuf),
}

/// All that is the same for what is told of triangles.
fn told<T: Serialize + Send>(
    of: Triangles,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    look: impl Fn(&TriMesh, &Asked, &Run) -> rvachev::Result<T> + Send + Sync,
) -> Result<c_int, Failure> {
    let out = slot(report, std::ptr::null_mut(), "report")?;
    let asked = asked(options);
    let found = work(asked.run.as_ref(), asked.threads, |run| {
        Ok(match &of {
            Triangles::Given(mesh) => look(mesh, &asked, run)?,
            Triangles::File(path) => {
                let found = pipeline::load_mesh(path, run).and_then(|mesh| look(&mesh, &asked, run));
                found.map_err(|e| e.in_file(path))?
            }
        })
    })?;
    out.write(text(json(&found)?));
    Ok(GOOD)
}

fn info(mesh: &TriMesh, asked: &Asked, run: &Run) -> rvachev::Result<pipeline::SoupInfo> {
    pipeline::soup_info(mesh, &asked.mesh, &asked.soup, run)
}

/// Compares methods on triangles, and draws the comparison where that is wanted.
fn compared(of: Triangles, options: Option<&RvOptions>, report: Out<'_, *mut RvText>) -> Result<c_int, Failure> {
    let sheet = asked(options).sheet()?;
    told(of, options, report, |mesh, asked, run| {
        let found = pipeline::compare_soup(mesh, &asked.mesh, &asked.soup, run)?;
        sheet.iter().try_for_each(|s| s.stages(&found, run))?;
        Ok(found)
    })
}

/// Tells which faces, edges and vertices are found in a surface, as `rvachev info --json` does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_triangles_info(
    surface: Option<&RvSurface>,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || told(Triangles::Given(given(surface, "surface")?.mesh()?), options, report, info))
}

/// Tells the same of a file of triangles, whose names of faces are heeded.
#[unsafe(no_mangle)]
pub extern "C" fn rv_triangles_info_file(
    path: Chars,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || told(Triangles::File(path.path("path")?), options, report, info))
}

/// Measures a surface and what methods make of it, as `rvachev compare --json` does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_compare_triangles(
    surface: Option<&RvSurface>,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || compared(Triangles::Given(given(surface, "surface")?.mesh()?), options, report))
}

/// Measures a file of triangles and what methods make of it.
#[unsafe(no_mangle)]
pub extern "C" fn rv_compare_triangles_file(
    path: Chars,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || compared(Triangles::File(path.path("path")?), options, report))
}
