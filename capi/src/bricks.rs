//! Meshes brick by brick, through a folder that several processes share.

use std::ffi::c_int;

use rvachev::io::{Format, WriteOptions, check_writable};
use rvachev::pipeline::{self, BrickPlan, MergedBricks, PlanSource, ROUNDS, Share};

use crate::errors::{ErrorOut, Failure, GOOD, SHORT, entry, slot, usage};
use crate::mesh::{sound, write_file};
use crate::options::{RvOptions, asked};
use crate::pass::{Chars, Items, Out};
use crate::text::{RvText, json, text};
use crate::work::work;

/// Bricks along an axis, at most.
const MOST: u32 = 1024;

/// Which bricks a process makes: see the header.
#[repr(C)]
pub struct RvShare {
    number: u32,
    of: u32,
    round: u32,
}

/// Plans a mesh of bricks into a folder.
#[unsafe(no_mangle)]
pub extern "C" fn rv_bricks_plan(
    path: Chars,
    counts: Items<u32>,
    options: Option<&RvOptions>,
    folder: Chars,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let (path, folder, asked) = (path.path("path")?, folder.path("folder")?, asked(options));
        let counts = counts.slice(3, "counts")?;
        if let Some(n) = counts.iter().find(|n| !(1..=MOST).contains(n)) {
            return Err(usage(format!("there may be 1 to {MOST} bricks along an axis, not {n}")));
        }
        if pipeline::is_step(&path) || pipeline::is_mesh(&path) {
            return Err(usage(format!("bricks are for solids of R-functions, {} is none", path.display())));
        }
        let source = PlanSource::read(&path, &asked.define)?;
        work(asked.run.as_ref(), asked.threads, |run| {
            Ok(BrickPlan::new(source, &asked.mesh, [counts[0], counts[1], counts[2]], run)?.save(&folder)?)
        })?;
        Ok(GOOD)
    })
}

/// A share, and the round of it, from 0; all bricks of all rounds for NULL.
fn share_of(share: Option<&RvShare>) -> Result<(Share, Option<usize>), Failure> {
    let Some(&RvShare { number, of, round }) = share else { return Ok((Share::ALL, None)) };
    if !(1..=of).contains(&number) {
        return Err(usage(format!("there is no share {number} of {of}")));
    }
    if !(1..=ROUNDS as u32).contains(&round) {
        return Err(usage(format!("there are rounds 1 to {ROUNDS}, not {round}")));
    }
    Ok((Share { number, of }, Some(round as usize - 1)))
}

/// Makes a share of the bricks of a plan, those that are not there.
#[unsafe(no_mangle)]
pub extern "C" fn rv_bricks_make(
    folder: Chars,
    share: Option<&RvShare>,
    options: Option<&RvOptions>,
    made: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(made, 0, "made")?;
        let (folder, asked) = (folder.path("folder")?, asked(options));
        let (share, round) = share_of(share)?;
        out.write(work(asked.run.as_ref(), asked.threads, |run| {
            Ok(pipeline::make_bricks(&BrickPlan::load(&folder)?, &folder, share, round, run)?)
        })?);
        Ok(GOOD)
    })
}

/// Merges the bricks of a plan into a file, and tells the report as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn rv_bricks_merge(
    folder: Chars,
    path: Chars,
    options: Option<&RvOptions>,
    report: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(report, std::ptr::null_mut(), "report")?;
        let (folder, path, asked) = (folder.path("folder")?, path.path("path")?, asked(options));
        let format = Format::from_path(&path)?;
        check_writable(&path)?;
        let how = WriteOptions { groups: asked.groups, old_msh: asked.old_msh, ..WriteOptions::default() };
        let (report, short) = work(asked.run.as_ref(), asked.threads, |run| {
            let plan = BrickPlan::load(&folder)?;
            let MergedBricks { mesh, mut made } = pipeline::merge_on_disk(&plan, &folder, false, run)?;
            let is_sound = sound(&made, asked.force)?;
            let written = if format.is_streamed() {
                write_file(&path, &mesh, &how, run)?
            } else {
                write_file(&path, &mesh.collected()?, &how, run)?
            };
            made.report.warnings.extend(written.warnings);
            let short = !is_sound || !made.report.shortfalls.is_empty() || !written.shortfalls.is_empty();
            made.report.warnings.extend(written.shortfalls);
            Ok((json(&made.report)?, short))
        })?;
        out.write(text(report));
        Ok(if short { SHORT } else { GOOD })
    })
}
