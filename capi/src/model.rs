//! What is known of CAD models, and methods compared, as JSON.

use std::ffi::c_int;
use std::mem::MaybeUninit;

use rvachev::parametric::step::StepModel;
use rvachev::pipeline::MeshOptions;
use rvachev::{Run, pipeline};
use serde::Serialize;

use crate::errors::{ErrorOut, Failure, GOOD, SHORT, entry, given, slot, usage};
use crate::options::{Asked, RvOptions, asked};
use crate::part::RvPart;
use crate::pass::{Chars, Out};
use crate::text::{RvText, json, text};
use crate::work::work;

/// What a look at a STEP model found, given as JSON.
fn told<T: Serialize + Send>(
    path: Chars,
    options: Option<&RvOptions>,
    out: &mut MaybeUninit<*mut RvText>,
    look: impl FnOnce(StepModel, &Run) -> rvachev::Result<T> + Send,
) -> Result<T, Failure> {
    let (path, asked) = (path.path("path")?, asked(options));
    let found = work(asked.run.as_ref(), asked.threads, |run| {
        let found = pipeline::load_step(&path, run).and_then(|m| look(m, run));
        Ok(found.map_err(|e| e.in_file(&path))?)
    })?;
    out.write(text(json(&found)?));
    Ok(found)
}

/// Tells what is wrong with a STEP model, as `rvachev check --json` does. Short where anything is.
#[unsafe(no_mangle)]
pub extern "C" fn rv_step_check(
    path: Chars,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let found = told(path, options, slot(report, std::ptr::null_mut(), "report")?, |m, run| {
            pipeline::diagnose_step(&m, run)
        })?;
        Ok(if found.sound { GOOD } else { SHORT })
    })
}

/// Tells what is in a STEP model, as `rvachev info --json` does. Short where something was not understood or had to be put right.
#[unsafe(no_mangle)]
pub extern "C" fn rv_step_info(
    path: Chars,
    options: Option<&RvOptions>,
    info: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        // STEP files are read in millimeters.
        let found = told(path, options, slot(info, std::ptr::null_mut(), "info")?, |m, run| {
            pipeline::brep_info(m, Some("mm"), run)
        })?;
        Ok(if found.notes.is_empty() { GOOD } else { SHORT })
    })
}

/// What a comparison finds, as JSON.
fn compared<T: Serialize + Send>(
    asked: &Asked,
    compare: impl FnOnce(&MeshOptions, &Run) -> rvachev::Result<T> + Send,
) -> Result<*mut RvText, Failure> {
    let found = work(asked.run.as_ref(), asked.threads, |run| Ok(compare(&asked.mesh, run)?))?;
    Ok(text(json(&found)?))
}

/// Measures every stage of every method on a part, as `rvachev compare --json` does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_compare(
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let (part, asked) = (given(part, "part")?.part(), asked(options));
        let sheet = asked.sheet()?;
        out.write(compared(&asked, |how, run| {
            let found = pipeline::compare(&part, how, run)?;
            sheet.iter().try_for_each(|s| s.stages(&found, run))?;
            Ok(found)
        })?);
        Ok(GOOD)
    })
}

/// Compares R-systems on a part, as `rvachev compare --rsystems --json` does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_compare_rsystems(
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let (part, asked) = (given(part, "part")?.part(), asked(options));
        if asked.sheet()?.is_some() {
            return Err(usage("there is no picture of R-systems"));
        }
        out.write(compared(&asked, |how, run| pipeline::compare_rsystems(&part, how, run))?);
        Ok(GOOD)
    })
}

/// Measures what every method makes of the samples, as `rvachev compare --samples --json` does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_compare_samples(
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let asked = asked(options);
        let sheet = asked.sheet()?;
        out.write(compared(&asked, |how, run| {
            let found = pipeline::compare_samples(how, run)?;
            sheet.iter().try_for_each(|s| s.samples(&found, run))?;
            Ok(found)
        })?);
        Ok(GOOD)
    })
}
