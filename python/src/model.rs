//! What is known of CAD models and of triangles, and methods compared, as dicts.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::mesh::TriMesh;
use rvachev::parametric::step::StepModel;
use rvachev::pipeline::{self, PictureOptions, PictureSheet};
use rvachev::{Error, Run};
use serde::Serialize;

use crate::arrays::surface;
use crate::errors::raise;
use crate::mesh::from_json;
use crate::options::Options;
use crate::part::{PyPart, sized};

/// Options of a run alone.
const RUN: [&str; 3] = ["progress", "cancel", "threads"];

/// What a look at a STEP model finds.
fn told<'py, T: Serialize + Send>(
    py: Python<'py>,
    path: PathBuf,
    options: Option<&Bound<'py, PyDict>>,
    look: impl FnOnce(StepModel, &Run) -> rvachev::Result<T> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let o = Options::new(options, &RUN)?;
    let found = o.listeners.work(py, |run| {
        let found = pipeline::load_step(&path, run).and_then(|m| look(m, run));
        found.map_err(|e| e.in_file(&path))
    })?;
    from_json(py, &found)
}

/// step_check(path, **options): what is wrong with the model of a STEP file, before any mesh: a dict as `rvachev check --json` writes it.
/// `sound` is True where nothing is. Lengths are in millimeters. Options: progress, cancel, threads.
/// Errors: `InputError` for a file that is no STEP model.
#[pyfunction]
#[pyo3(signature = (path, **options))]
pub fn step_check<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    told(py, path, options, |model, run| pipeline::diagnose_step(&model, run))
}

/// step_info(path, **options): what is in the model of a STEP file: a dict as `rvachev info --json` writes it, of bodies, faces with
/// their areas and kinds, volumes and centers, in millimeters. Options: progress, cancel, threads.
/// Errors: `InputError` for a file that is no STEP model.
#[pyfunction]
#[pyo3(signature = (path, **options))]
pub fn step_info<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    told(py, path, options, |model, run| pipeline::brep_info(model, Some("mm"), run))
}

/// compare(part, size=None, **options): every stage of every method measured on a part of functions: a dict as `rvachev compare --json`
/// writes it. Options are those of `mesh`, but for volume and without. size: a length in the part's unit, or a share.
///
/// png: a PNG file to write, one picture of all stages beside each other near one place, as `--png` does.
/// color: what its colors tell: "angle" (unless it is said) or "class".
/// Errors: `InputError` for other options, and those of `mesh`.
#[pyfunction]
#[pyo3(signature = (part, size=None, **options))]
pub fn compare<'py>(
    py: Python<'py>,
    part: &Bound<'py, PyPart>,
    size: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (part, Wished { options: o, sheet }) = (part.get().part(), wished(options, size)?);
    let how = o.mesh;
    let found = o.listeners.work(py, |run| {
        let found = pipeline::compare(&part, &how, run)?;
        sheet.iter().try_for_each(|s| s.stages(&found, run))?;
        Ok(found)
    })?;
    from_json(py, &found)
}

/// What is wished for a comparison.
struct Wished {
    options: Options,
    /// Its picture.
    sheet: Option<PictureSheet>,
}

/// Options of a comparison; those of its picture are taken out of the dict.
fn wished(options: Option<&Bound<'_, PyDict>>, size: Option<&Bound<'_, PyAny>>) -> PyResult<Wished> {
    let mut sheet = None;
    if let Some(all) = options {
        let taken = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
            let found = all.get_item(name)?;
            if found.is_some() {
                all.del_item(name)?;
            }
            Ok(found.filter(|v| !v.is_none()))
        };
        let [png, color] = [taken("png")?, taken("color")?];
        let color = match color {
            None => None,
            Some(said) => {
                let mut read = PictureOptions::default();
                read.set("color", &said.extract::<String>()?).map_err(|e| raise(all.py(), &e))?;
                Some(read.coloring)
            }
        };
        sheet = match (png, color) {
            (Some(path), color) => {
                Some(PictureSheet::new(&path.extract::<PathBuf>()?, color).map_err(|e| raise(all.py(), &e))?)
            }
            (None, None) => None,
            (None, Some(_)) => {
                return Err(raise(
                    all.py(),
                    &Error::Usage("a color is for the picture of a comparison: say png".into()),
                ));
            }
        };
    }
    Ok(Wished { options: sized(Options::new(options, &[])?, size)?, sheet })
}

/// compare_rsystems(part, size=None, **options): how near the function of a part is to a distance under each R-system: a dict as
/// `rvachev compare --rsystems --json` writes it. Lengths, and size, are in the part's unit; options are those of
/// `compare`, but for png and color.
/// Errors: `InputError` for other options, and those of `mesh`.
#[pyfunction]
#[pyo3(signature = (part, size=None, **options))]
pub fn compare_rsystems<'py>(
    py: Python<'py>,
    part: &Bound<'py, PyPart>,
    size: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (part, o) = (part.get().part(), sized(Options::new(options, &[])?, size)?);
    let how = o.mesh;
    let found = o.listeners.work(py, |run| pipeline::compare_rsystems(&part, &how, run))?;
    from_json(py, &found)
}

/// compare_samples(size=None, **options): every method measured on three cubes with two holes that come with the package, whose sides
/// are 2 units long: a dict as `rvachev compare --samples --json` writes it. Options are those of `compare`; the picture that png names has
/// a row for each cube and a column for each method.
/// Errors: `InputError` for other options.
#[pyfunction]
#[pyo3(signature = (size=None, **options))]
pub fn compare_samples<'py>(
    py: Python<'py>,
    size: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let Wished { options: o, sheet } = wished(options, size)?;
    let how = o.mesh;
    let found = o.listeners.work(py, |run| {
        let found = pipeline::compare_samples(&how, run)?;
        sheet.iter().try_for_each(|s| s.samples(&found, run))?;
        Ok(found)
    })?;
    from_json(py, &found)
}

/// A surface: arrays, a Mesh, or a file of triangles with its names of faces.
enum Triangles {
    Given(TriMesh),
    File(PathBuf),
}

impl Triangles {
    fn of(points: &Bound<'_, PyAny>, triangles: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        match points.extract::<PathBuf>() {
            Ok(path) if triangles.is_none() => Ok(Triangles::File(path)),
            _ => surface(points, triangles).map(Triangles::Given),
        }
    }

    fn look<T>(&self, run: &Run, look: impl Fn(&TriMesh) -> rvachev::Result<T>) -> rvachev::Result<T> {
        match self {
            Triangles::Given(mesh) => look(mesh),
            Triangles::File(path) => {
                pipeline::load_mesh(path, run).and_then(|mesh| look(&mesh)).map_err(|e| e.in_file(path))
            }
        }
    }
}

/// compare_triangles(points, triangles=None, size=None, **options): a surface of triangles measured beside what `remesh` makes of it and
/// what two simpler methods make: a dict as `rvachev compare --json` writes it.
///
/// points (n, 3), in any unit, and triangles (m, 3), or a Mesh or the path of a file of triangles alone. size: a length in that unit, or a
/// share. Options are those of `remesh`, and png and color of `compare`.
/// Errors: `InputError` for other options, and those of `remesh`.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, size=None, **options))]
pub fn compare_triangles<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
    size: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (of, Wished { options: mut o, sheet }) = (Triangles::of(points, triangles)?, wished(options, size)?);
    let listeners = std::mem::take(&mut o.listeners);
    let found = listeners.work(py, |run| {
        let found = of.look(run, |mesh| pipeline::compare_soup(mesh, &o.mesh, &o.soup, run))?;
        sheet.iter().try_for_each(|s| s.stages(&found, run))?;
        Ok(found)
    })?;
    from_json(py, &found)
}

/// triangles_info(points, triangles=None, **options): what is found in a surface of triangles before it is meshed: a dict as
/// `rvachev info --json` writes it, of faces with their areas, edges with their lengths and vertices with their places, in its unit.
///
/// points (n, 3) and triangles (m, 3), or a Mesh or the path of a file of triangles alone; of a file, names of faces are heeded.
/// Options: size, feature_angle (degrees), min_area, min_length, nodes, close, progress, cancel, threads.
/// Errors: those of `remesh`.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, **options))]
pub fn triangles_info<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let known = ["size", "feature_angle", "min_area", "min_length", "nodes", "close", "progress", "cancel", "threads"];
    let (of, mut o) = (Triangles::of(points, triangles)?, Options::new(options, &known)?);
    let listeners = std::mem::take(&mut o.listeners);
    let found = listeners.work(py, |run| of.look(run, |mesh| pipeline::soup_info(mesh, &o.mesh, &o.soup, run)))?;
    from_json(py, &found)
}
