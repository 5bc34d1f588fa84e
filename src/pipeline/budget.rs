//! How many triangles a mesh will have, told before it is made.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::bodies::EQUILATERAL;
use super::mesh::Meshed;
use crate::error::{Error, Place, Result};
use crate::run::{CancelToken, Progress, Run};
use crate::spatial::{Aabb, LARGEST};

/// Refuses a model in a box whose diagonal cannot be measured. What is empty is no matter of size.
pub(super) fn measurable(bounds: &Aabb) -> Result<()> {
    let diagonal = bounds.diagonal();
    if bounds.is_empty() || diagonal <= LARGEST {
        return Ok(());
    }
    let what =
        format!("its box has a diagonal of {diagonal:e}, and {LARGEST:e} is the most: is a number or a unit wrong?");
    Err(Error::input(Place::Unknown, what))
}

/// Refuses a surface of an area that more triangles of a size cover than the memory of the run holds.
///
/// Errors: those of [`Run::expect`], without anything told to a listener.
pub(super) fn covering(area: f64, size: f64, run: &Run) -> Result<()> {
    let count = area / (EQUILATERAL * size * size);
    match run.most_triangles() {
        Some(most) if count > most as f64 => run.expect(count),
        _ => Ok(()),
    }
}

/// Stops a run as soon as it tells what it expects.
struct Listener {
    others: Option<Arc<dyn Progress>>,
    token: CancelToken,
    /// What was told first, plus one; 0 for nothing.
    told: AtomicUsize,
}

impl Progress for Listener {
    fn report(&self, stage: &str, done: f64) {
        if let Some(p) = &self.others {
            p.report(stage, done);
        }
    }

    fn triangles(&self, count: usize) {
        if let Some(p) = &self.others {
            p.triangles(count);
        }
    }

    fn expected(&self, triangles: usize) {
        let _ = self.told.compare_exchange(0, triangles.saturating_add(1), Ordering::Relaxed, Ordering::Relaxed);
        self.token.cancel();
    }
}

/// About how many triangles the mesh that `work` makes will have; `work` is stopped as soon as that is known, which is when lengths of
/// edges are: after a first mesh of STEP files, after the arrangement of functions, after the features of triangles were found.
///
/// Guarantees: nothing is written, and `run` itself is not cancelled. Does not guarantee more than the number that is meant: within a
/// tenth as a rule, more where a part has narrow places that show only later. Where `work` ends before, as by methods that do not
/// tell, its mesh is counted.
///
/// Errors: those of `work`; [`Error::Cancelled`](crate::Error::Cancelled) where `run` is.
///
/// ```
/// use rvachev::Run;
/// use rvachev::implicit::part::parse;
/// use rvachev::pipeline::{MeshOptions, expected_triangles, mesh_part};
///
/// let part = parse("part(sphere(1).name(\"ball\"))\nmesh(size=0.1)", &[])?;
/// let about = expected_triangles(&Run::new(), |run| mesh_part(&part, &MeshOptions::default(), run))?;
/// // The area over that of an equilateral triangle.
/// assert!((about as f64 / (4.0 * std::f64::consts::PI / 0.00433) - 1.0).abs() < 0.1);
/// # Ok::<(), rvachev::Error>(())
/// ```
pub fn expected_triangles(run: &Run, work: impl FnOnce(&Run) -> Result<Meshed>) -> Result<usize> {
    let token = run.cancel_token().child();
    let listener = Arc::new(Listener { others: run.listener(), token: token.clone(), told: AtomicUsize::new(0) });
    let made = work(&run.clone().with_cancel(token).with_progress(listener.clone()));
    run.check()?;
    match (made, listener.told.load(Ordering::Relaxed).checked_sub(1)) {
        (_, Some(told)) => Ok(told),
        (Ok(made), None) => Ok(made.mesh.triangles.len()),
        (Err(e), None) => Err(e),
    }
}
