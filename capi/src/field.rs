//! Functions of the caller's as leaves: called with many points at once, their codes kept for the end of the run.

use std::ffi::{c_int, c_void};
use std::sync::{Mutex, PoisonError};

use rvachev::DVec3;
use rvachev::implicit::{Field, Solid, Walls, differences};

use crate::errors::{ErrorOut, entry, given, input, slot, usage};
use crate::part::bounds as box_of;
use crate::pass::{Items, Out, flat};
use crate::solid::{RvSolid, solid_out};
use crate::work::watched;

/// A function of the caller's: `n` points, three numbers of each; gives `n` values, positive inside, and three numbers of a gradient
/// for each point unless there is NULL for them. What it returns, unless it is 0, stops the run. `None` is NULL; it stands in the
/// alias since cbindgen, which the header is compared with, sees no pointer in an `Option` of an alias.
pub type RvFunction =
    Option<extern "C" fn(n: usize, xyz: *const f64, value: *mut f64, gradient: *mut f64, user: *mut c_void) -> c_int>;

/// Told once that a field is not asked any more.
pub type RvRelease = Option<extern "C" fn(user: *mut c_void)>;

/// What a caller says of a field.
#[repr(C)]
pub struct RvField {
    /// The function.
    function: RvFunction,
    /// What it is handed.
    user: *mut c_void,
    /// Called with `user` when nothing holds the field any more; may be NULL.
    release: RvRelease,
    /// Values change by at most this much per length; 0 where that is not known.
    lipschitz: f64,
    /// x0 y0 z0 x1 y1 z1: where the function may be called; NULL for everywhere.
    bounds: Items<f64>,
    /// Whether it gives gradients; differences of values do without.
    has_gradient: c_int,
    /// Whether it may be called by several threads at once.
    concurrent: c_int,
}

/// A field that is a leaf of a solid.
struct Leaf {
    function: extern "C" fn(usize, *const f64, *mut f64, *mut f64, *mut c_void) -> c_int,
    user: *mut c_void,
    release: RvRelease,
    lipschitz: Option<f64>,
    walls: Option<Walls>,
    has_gradient: bool,
    /// Held during calls of functions that must not be called at once.
    turn: Option<Mutex<()>>,
}

// SAFETY: the pointer is only handed to the caller's functions, who said in which way they may be called; by the header, from any thread.
unsafe impl Send for Leaf {}
// SAFETY: as above.
unsafe impl Sync for Leaf {}

impl Drop for Leaf {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            release(self.user);
        }
    }
}

impl Leaf {
    /// Calls the function, with room for gradients or without; its code stops the run.
    fn ask(&self, points: &[DVec3], values: &mut [f64], gradients: Option<&mut [f64]>) -> Option<()> {
        let watched = watched();
        if watched.as_ref().is_some_and(|w| w.token.is_cancelled()) {
            return None;
        }
        let slopes = gradients.map_or(std::ptr::null_mut(), |g| g.as_mut_ptr());
        let code = {
            let _turn = self.turn.as_ref().map(|t| t.lock().unwrap_or_else(PoisonError::into_inner));
            (self.function)(points.len(), flat(points).as_ptr(), values.as_mut_ptr(), slopes, self.user)
        };
        if code == 0 {
            return Some(());
        }
        if let Some(w) = watched {
            w.stop(code, self.user as usize);
        }
        None
    }
}

impl Field for Leaf {
    fn value(&self, p: DVec3) -> f64 {
        let mut out = [f64::NAN];
        self.values(&[p], &mut out);
        out[0]
    }

    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        let inside = |points: &[DVec3], out: &mut [f64]| {
            if !points.is_empty() && self.ask(points, out, None).is_none() {
                out.fill(f64::NAN);
            }
        };
        self.walls.unwrap_or_default().values(points, out, inside);
    }

    fn gradients(&self, points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]) {
        if !self.has_gradient {
            return differences(points, values, gradients, |p, v| self.values(p, v));
        }
        let inside = |points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]| {
            let mut flat = vec![f64::NAN; 3 * points.len()];
            if points.is_empty() || self.ask(points, values, Some(&mut flat)).is_none() {
                values.fill(f64::NAN);
                flat.fill(f64::NAN);
            }
            for (g, v) in gradients.iter_mut().zip(flat.chunks_exact(3)) {
                *g = DVec3::from_slice(v);
            }
        };
        self.walls.unwrap_or_default().gradients(points, values, gradients, inside);
    }

    fn walls(&self) -> Option<Walls> {
        self.walls
    }

    fn lipschitz(&self) -> Option<f64> {
        self.lipschitz
    }
}

/// Where a function of the caller's is positive.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_field(field: Option<&RvField>, solid: Out<'_, *mut RvSolid>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let said = given(field, "field")?;
        let function = said.function.ok_or_else(|| usage("field.function is NULL"))?;
        if !(said.lipschitz >= 0.0 && said.lipschitz.is_finite()) {
            let what = format!("field.lipschitz must be positive, or 0 where it is not known, not {}", said.lipschitz);
            return Err(input(what, ""));
        }
        let bounds = box_of(&said.bounds)?;
        // From here on nothing fails, so `release` is called if and only if the call was good.
        let leaf = Leaf {
            function,
            user: said.user,
            release: said.release,
            lipschitz: Some(said.lipschitz).filter(|l| *l > 0.0),
            walls: bounds.map(Walls::new),
            has_gradient: said.has_gradient != 0,
            turn: (said.concurrent == 0).then(Mutex::default),
        };
        let made = Solid::field(leaf);
        solid_out(if let Some(b) = bounds { made & Solid::cuboid(b.lo, b.hi) } else { made }, out)
    })
}
