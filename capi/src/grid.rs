//! Values on a grid of points as a solid.

use std::ffi::c_int;

use rvachev::implicit::GridField;

use crate::errors::{ErrorOut, entry, slot, usage};
use crate::part::bounds as box_of;
use crate::pass::{Items, Out};
use crate::solid::{RvSolid, solid_out};

/// Where values on a grid of points, trilinear between them, are positive.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_grid(
    counts: Items<usize>,
    bounds: Items<f64>,
    values: Items<f64>,
    solid: Out<'_, *mut RvSolid>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let n = counts.slice(3, "counts")?;
        let all = n.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).ok_or_else(|| usage("too many points"))?;
        let values = values.slice(all, "values")?;
        let Some(bounds) = box_of(&bounds)? else { return Err(usage("bounds is NULL")) };
        let grid = GridField::new([n[0], n[1], n[2]], bounds, values.to_vec())?;
        solid_out(grid.into_solid(), out)
    })
}
