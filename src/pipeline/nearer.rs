//! Functions meshed as near to their surface as was asked for.

use super::crowded::wanting;
use super::mesh::{MeshOptions, Meshed, Ready, apart, mesh_ready};
use crate::error::{Error, Result};
use crate::implicit::part::Part;
use crate::quality::Fault;
use crate::run::Run;

/// How often a mesh is made anew. Chords are of edges: the middle of a triangle is a third farther away on a ball, and edges come out
/// of unequal lengths. Distances grow with the square of edges, so one time does on smooth parts.
const TIMES: usize = 3;
/// What is aimed at then: this share of the distance that would follow from what was measured.
const BELOW: f64 = 0.9;

/// A mesh within `limit` of the surface in place of one that is farther away, or the nearest there is, with what it lacks.
///
/// Errors: cancellation.
pub(super) fn come_within(
    part: &Part,
    ready: &Ready,
    mut made: Meshed,
    options: &MeshOptions,
    run: &Run,
) -> Result<Meshed> {
    let Some(limit) = options.tolerance.filter(|_| options.method.is_exact()) else { return Ok(made) };
    let mut aim = limit;
    for _ in 0..TIMES {
        let far = apart(&made);
        if far <= limit {
            return Ok(made);
        }
        aim *= BELOW * limit / far;
        let closer = MeshOptions { tolerance: Some(aim), ..options.clone() };
        match mesh_ready(part, ready, &closer, run) {
            Ok((mut other, _)) if apart(&other) < far && wanting(&other) <= wanting(&made) => {
                other.report.instead_of(&made.report, true, "farther from the surface than asked for", run);
                made = other;
            }
            Ok((other, _)) => {
                made.report.instead_of(&other.report, false, "no nearer to the surface with shorter edges", run);
                break;
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // What there is stands.
            Err(_) => break,
        }
    }
    let distance = apart(&made);
    if distance > limit && !made.report.shortfalls.iter().any(|f| matches!(f, Fault::Far { .. })) {
        made.report.shortfalls.push(Fault::Far { distance, limit, triangles: None });
    }
    Ok(made)
}
