//! Measures of a surface, alone or against the part or file whose surface it should be.

use std::ffi::c_int;

use rvachev::pipeline;
use rvachev::quality::{Expectation, check};

use crate::errors::{ErrorOut, GOOD, entry, given, slot};
use crate::options::{RvOptions, asked};
use crate::part::RvPart;
use crate::pass::{Chars, Out};
use crate::surface::RvSurface;
use crate::text::{RvText, json, text};
use crate::work::work;

/// Measures a surface, against a part unless that is NULL: JSON as `check` in the report of a mesh.
#[unsafe(no_mangle)]
pub extern "C" fn rv_check(
    surface: Option<&RvSurface>,
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let (input, asked) = (given(surface, "surface")?.mesh()?, asked(options));
        let part = part.map(RvPart::part);
        let found = work(asked.run.as_ref(), asked.threads, |run| {
            Ok(match &part {
                Some(part) => pipeline::against(&input, part, run)?,
                None => check(&input, Expectation::default(), None, run)?,
            })
        })?;
        out.write(text(json(&found)?));
        Ok(GOOD)
    })
}

/// Measures a surface against a part file or a STEP file.
#[unsafe(no_mangle)]
pub extern "C" fn rv_check_file(
    surface: Option<&RvSurface>,
    path: Chars,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let (input, asked) = (given(surface, "surface")?.mesh()?, asked(options));
        let path = path.path("path")?;
        let found = work(asked.run.as_ref(), asked.threads, |run| {
            let found = if pipeline::is_step(&path) {
                pipeline::load_step(&path, run).and_then(|m| pipeline::against_step(&input, m, run))
            } else {
                pipeline::load_part(&path, &asked.define).and_then(|p| pipeline::against(&input, &p, run))
            };
            found.map_err(|e| e.in_file(&path).into())
        })?;
        out.write(text(json(&found)?));
        Ok(GOOD)
    })
}
