//! What is known of CAD models, and methods compared, as dicts.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::parametric::step::StepModel;
use rvachev::{Run, pipeline};
use serde::Serialize;

use crate::errors::{input, raise};
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
/// writes it. Options are those of `mesh`, but for volume and without.
/// Errors: `InputError` for other options, and those of `mesh`.
#[pyfunction]
#[pyo3(signature = (part, size=None, **options))]
pub fn compare<'py>(
    py: Python<'py>,
    part: &Bound<'py, PyPart>,
    size: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (part, o) = (part.get().part(), sized(Options::new(options, &[])?, size)?);
    let how = o.mesh;
    if how.volume.is_some() || !how.without.is_empty() {
        let what = "methods are compared with neither volume nor without";
        return Err(raise(py, &input(what, "")));
    }
    let found = o.listeners.work(py, |run| pipeline::compare(&part, &how, run))?;
    from_json(py, &found)
}
