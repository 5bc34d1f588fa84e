//! Creases inside black boxes: closures, and formulas that do not fall into leaves. The leaf method knows nothing of them and
//! cuts them off; the default sequence of operators, which sees only the surface, finds them.

use super::history::{Attempt, Clock, Tried};
use super::leaf::ByLeaf;
use super::mesh::{MeshOptions, Method, Ready};
use crate::error::Result;
use crate::implicit::{ImplicitOracle, creased};
use crate::optimize::improve;
use crate::run::Run;

/// The operators' mesh is taken if it cuts off creases with at most this share of the triangles that cut them off in the leaf
/// method's: of what they recover nothing is left, of bends tighter than the cells about as much as before.
const RECOVERED: f64 = 0.5;

/// The part by the operators, where a mesh of the leaf method cuts creases off and theirs does not.
pub(super) fn hidden_creases(
    ready: &Ready,
    by_leaf: &ByLeaf,
    options: &MeshOptions,
    run: &Run,
) -> Result<Option<ByLeaf>> {
    if by_leaf.proved && !ready.model.has_black_boxes() {
        return Ok(None);
    }
    let oracle = ImplicitOracle::new(&ready.model, &by_leaf.extracted);
    let cut_off = creased(&by_leaf.mesh, &oracle, run).len();
    if cut_off == 0 || !by_leaf.method.is_exact() {
        return Ok(None);
    }
    let mut clock = Clock::new(options.timed);
    let extracted = ready.extract(ready.size, options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let improved = improve(&mut mesh, &oracle, &ready.operator_options(options), run)?;
    let sound = improved.self_intersections + improved.after.inverted == 0;
    let left = creased(&mesh, &oracle, run).len();
    if !sound || left as f64 > RECOVERED * cut_off as f64 {
        return Ok(None);
    }
    let mut attempts = by_leaf.attempts.clone();
    for a in attempts.iter_mut().filter(|a| a.kept) {
        a.kept = false;
        a.why = format!("{cut_off} triangles cut off creases inside a closure or formula");
    }
    attempts.push(Attempt::new(Tried::Operators, ready.size, mesh.triangles.len(), 0, &mut clock).kept());
    let made = ByLeaf::by_other(mesh, extracted, ready.size, Method::Operators, Vec::new());
    Ok(Some(ByLeaf { attempts, ..made }))
}
