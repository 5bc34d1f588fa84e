//! Curved walls thinner than chords are high: made anew with shorter edges, where they are thin first.

use glam::DVec3;

use super::attempts::MOST_TRIANGLES;
use super::leaf::finer;
use super::mesh::{MeshOptions, Meshed, Ready, mesh_ready};
use crate::error::{Error, Result};
use crate::implicit::part::Part;
use crate::quality::Fault;
use crate::run::Run;

/// Where a mesh fell short for its edges' length: places that are known, perhaps none, with a length to try.
pub(super) type Crowded = Option<Vec<(DVec3, f64)>>;

/// How often edges are halved at the places that need it.
const HALVINGS: usize = 3;
/// As long as no more than this share of what is wanting before is left.
const LEFT: f64 = 0.5;
/// Where that does not do there are this many times as many edges to a length everywhere, unless that would give more than
/// [`MOST_TRIANGLES`].
const FINER: [f64; 2] = [2.0, 4.0];

/// How much a mesh lacks.
pub(super) fn wanting(made: &Meshed) -> usize {
    let check = made.report.check.as_ref();
    let away = check.and_then(|c| c.deviation).map_or(0, |d| d.inverted + d.across);
    let short: usize = made.report.shortfalls.iter().map(Fault::weight).sum();
    short + away + check.map_or(0, |c| c.self_intersections)
}

/// A mesh with shorter edges than the one made, where that is better; it says so in its report.
pub(super) fn thin_out(
    part: &Part,
    ready: &mut Ready,
    (mut made, mut places): (Meshed, Vec<(DVec3, f64)>),
    options: &MeshOptions,
    run: &Run,
) -> Result<Meshed> {
    let anew = |ready: &Ready, options: &MeshOptions| match mesh_ready(part, ready, options, run) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        // What there is stands.
        other => Ok(other.ok()),
    };
    for _ in 0..HALVINGS {
        if places.is_empty() {
            break;
        }
        ready.finer.extend(&places);
        let Some((mut other, crowded)) = anew(ready, options)? else { break };
        let (now, then) = (wanting(&made), wanting(&other));
        if !other.report.shortfalls.is_empty() || then as f64 > LEFT * now as f64 {
            made.report.instead_of(&other.report, false, "shorter edges at thin walls do not help", run);
            break;
        }
        other.report.warnings.push(format!("curved walls are thin: edges are shorter at {} places", ready.finer.len()));
        other.report.instead_of(&made.report, true, "walls are thinner than chords are high", run);
        made = other;
        match crowded {
            Some(more) => places = more,
            None => return Ok(made),
        }
    }
    ready.finer.clear();
    for times in FINER {
        let triangles = made.mesh.triangles.len() as f64 * times * times;
        if triangles > MOST_TRIANGLES {
            break;
        }
        let Some((mut other, _)) = anew(ready, &finer(ready, options, times))? else { continue };
        let (now, then) = (wanting(&made), wanting(&other));
        // Walls are not what it lacks.
        if made.report.shortfalls.is_empty() && then >= now {
            made.report.instead_of(&other.report, false, "shorter edges do not help", run);
            break;
        }
        if other.report.shortfalls.is_empty() && (then == 0 || !made.report.shortfalls.is_empty()) {
            let what = format!("curved walls are thin: made with {times} times as many edges to a length");
            other.report.warnings.push(what);
            other.report.instead_of(&made.report, true, "walls are thinner than chords are high", run);
            made = other;
        } else {
            made.report.instead_of(&other.report, false, "it falls short with shorter edges too", run);
        }
        if then == 0 {
            break;
        }
    }
    Ok(made)
}
