//! A part's function at points: values, gradients, and the faces that decide it.

use std::ffi::c_int;

use rvachev::implicit::{Samples, Sampling, evaluate};
use rvachev::{DVec3, Run};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, slot, usage};
use crate::part::RvPart;
use crate::pass::{Items, Out, Room, c_string, flat};
use crate::text::{RvText, text};
use crate::work::{work, work_here};

/// Points the library evaluates on the thread that asks.
const FEW: usize = 256;

/// Where no face decides.
const NO_FACE: i32 = -1;

/// Values, and what else is wanted, of a part's function; three numbers of each point.
fn evaluated(part: &RvPart, points: &[f64], wanted: Sampling) -> Result<Samples, Failure> {
    let model = part.model()?;
    let points: Vec<DVec3> = points.chunks_exact(3).map(DVec3::from_slice).collect();
    // A few points take no threads of their own.
    if points.len() <= FEW {
        work_here(|| Ok(evaluate(&model, &points, wanted, &Run::new())?))
    } else {
        work(None, 0, |run| Ok(evaluate(&model, &points, wanted, run)?))
    }
}

/// The part's function at points: positive inside, about the distance near the surface.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_values(
    part: Option<&RvPart>,
    count: usize,
    xyz: Items<f64>,
    values: Room<f64>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        values.needed(count, "values")?;
        let points = xyz.slice(count.saturating_mul(3), "xyz")?;
        values.fill(&evaluated(given(part, "part")?, points, Sampling::default())?.values);
        Ok(GOOD)
    })
}

/// The gradient of the part's function at points, three numbers of each; it points inwards.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_gradients(
    part: Option<&RvPart>,
    count: usize,
    xyz: Items<f64>,
    gradients: Room<f64>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        gradients.needed(count, "gradients")?;
        let points = xyz.slice(count.saturating_mul(3), "xyz")?;
        let wanted = Sampling { gradients: true, ..Sampling::default() };
        gradients.fill(flat(&evaluated(given(part, "part")?, points, wanted)?.gradients));
        Ok(GOOD)
    })
}

/// The face at points, a number from 0 of each: the one whose leaf decides min / max of all leaves; -1 where none does.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_faces(
    part: Option<&RvPart>,
    count: usize,
    xyz: Items<f64>,
    faces: Room<i32>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        faces.needed(count, "faces")?;
        let points = xyz.slice(count.saturating_mul(3), "xyz")?;
        let wanted = Sampling { faces: true, ..Sampling::default() };
        let found = evaluated(given(part, "part")?, points, wanted)?.faces;
        let numbers = found.iter().map(|f| f.and_then(|f| i32::try_from(f).ok()).unwrap_or(NO_FACE));
        faces.fill(&numbers.collect::<Vec<_>>());
        Ok(GOOD)
    })
}

/// How many faces the part's function has.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_face_count(part: Option<&RvPart>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(count, 0, "count")?;
        out.write(given(part, "part")?.model()?.faces().len());
        Ok(GOOD)
    })
}

/// The name of one of them, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_part_face_name(
    part: Option<&RvPart>,
    index: usize,
    name: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(name, std::ptr::null_mut(), "name")?;
        let model = given(part, "part")?.model()?;
        let count = model.faces().len();
        let face = model.faces().get(index).ok_or_else(|| usage(format!("there is no face {index} of {count}")))?;
        out.write(text(c_string(&face.name)));
        Ok(GOOD)
    })
}
