//! A part's function on a regular grid.

use std::ffi::c_int;

use rvachev::io::{GridFormat, SampledGrid, write_grid};
use rvachev::pipeline;

use crate::errors::{ErrorOut, GOOD, SHORT, entry, given, release, slot, usage};
use crate::mesh::lend;
use crate::options::{RvOptions, asked};
use crate::part::RvPart;
use crate::pass::{Chars, Out, Room, flat};
use crate::work::work;

/// Samples on a grid. Nothing in it changes, so pointers into it are good until it is freed.
pub struct RvSamples(SampledGrid);

/// Samples a part's function on a regular grid over its box and a margin.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_sample(
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    samples: Out<'_, *mut RvSamples>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(samples, std::ptr::null_mut(), "samples")?;
        let (part, asked) = (given(part, "part")?.part(), asked(options));
        let grid = work(asked.run.as_ref(), asked.threads, |run| {
            Ok(pipeline::sample_grid(&pipeline::function(&part, None, run)?, &asked.for_grid(), run)?)
        })?;
        let status = if grid.not_finite().is_some() { SHORT } else { GOOD };
        out.write(Box::into_raw(Box::new(RvSamples(grid))));
        Ok(status)
    })
}

/// Where the points are: how many along x, y and z, the first one, and the distance of neighbors.
#[unsafe(no_mangle)]
pub extern "C" fn rv_samples_frame(
    samples: Option<&RvSamples>,
    counts: Room<usize>,
    origin: Room<f64>,
    step: Out<'_, f64>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        counts.needed(3, "counts")?;
        origin.needed(3, "origin")?;
        counts.fill(&[0; 3]);
        origin.fill(&[0.0; 3]);
        let step = slot(step, 0.0, "step")?;
        let grid = &given(samples, "samples")?.0;
        counts.fill(&grid.nodes);
        origin.fill(&grid.origin.to_array());
        step.write(grid.step);
        Ok(GOOD)
    })
}

/// The values, x running fastest; `count` of them.
#[unsafe(no_mangle)]
pub extern "C" fn rv_samples_values(
    samples: Option<&RvSamples>,
    values: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(values, count, error, || {
        let values = &given(samples, "samples")?.0.values;
        Ok((values.as_ptr(), values.len()))
    })
}

/// The gradients, three numbers of each point; `count` points, which is 0 where gradients were not asked for.
#[unsafe(no_mangle)]
pub extern "C" fn rv_samples_gradients(
    samples: Option<&RvSamples>,
    xyz: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(xyz, count, error, || {
        let gradients = given(samples, "samples")?.0.gradients.as_deref().unwrap_or_default();
        Ok((flat(gradients).as_ptr(), gradients.len()))
    })
}

/// Writes a file: vti, or npy for values alone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_samples_write(
    samples: Option<&RvSamples>,
    path: Chars,
    options: Option<&RvOptions>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let grid = &given(samples, "samples")?.0;
        let (path, asked) = (path.path("path")?, asked(options));
        if GridFormat::from_path(&path)? == GridFormat::Npy && grid.gradients.is_some() {
            return Err(usage("an .npy file holds values alone; write gradients to a .vti file"));
        }
        work(asked.run.as_ref(), asked.threads, |run| Ok(write_grid(&path, grid, run)?))?;
        Ok(GOOD)
    })
}

/// Frees samples; what was lent of them is gone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_samples_free(samples: Option<Box<RvSamples>>) {
    release(samples);
}
