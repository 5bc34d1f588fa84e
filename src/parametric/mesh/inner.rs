//! Bends inside faces that none of their borders has, such as the leading edge of a wing between its upper and its lower side:
//! edges around them are to be as short as the triangles between them.

use glam::DVec3;
use rayon::prelude::*;

use super::fill::{Filled, Unfilled};
use super::{Parametric, Plan};
use crate::spatial::Graded;

/// A node inside a face tells something where it wants less than this share of what is wanted there for other reasons.
const SHORTER: f64 = 0.9;
/// Bends inside count where a node of an edge would get less than this share of its length for them: with lengths nearer to
/// each other triangles beside the edge still are good.
const NOTICED: f64 = 0.8;

/// Places inside faces whose bends ask for edges shorter than the field has there, with these lengths, where borders would get
/// shorter edges for them; else nothing.
pub(super) fn inner_bends(of: &Parametric, filled: &[Result<Filled, Unfilled>], plan: &Plan<'_>) -> Vec<(DVec3, f64)> {
    let bent = |(f, made): (usize, &Result<Filled, Unfilled>)| {
        // Surfaces with closed forms bend as much at their borders.
        let made = made.as_ref().ok().filter(|_| of.charts[f].is_sampled())?;
        let shorter = |x: &(DVec3, f64)| x.1 < SHORTER * plan.field.at(x.0, plan.sizes.size);
        Some(made.nodes.iter().copied().zip(made.sizes.iter().copied()).filter(shorter).collect())
    };
    let found: Vec<Vec<(DVec3, f64)>> = filled.par_iter().enumerate().filter_map(bent).collect();
    let bends = found.concat();
    let graded = Graded::new(bends.clone(), plan.field.slope());
    let noticed = |(p, h): (&DVec3, &f64)| h.is_finite() && graded.at(*p, *h) < NOTICED * h;
    if plan.borders.points.iter().zip(&plan.borders.wants).any(noticed) { bends } else { Vec::new() }
}
