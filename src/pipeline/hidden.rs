//! Creases inside black boxes: closures, and formulas that do not fall into leaves. The leaf method knows nothing of them and
//! cuts them off; the default sequence of operators, which sees only the surface, finds them.

use super::history::{Attempt, Clock, Tried, add_attempt, tell_dropped};
use super::leaf::ByLeaf;
use super::mesh::{MeshOptions, Ready};
use super::method::Method;
use crate::error::Result;
use crate::implicit::{ImplicitOracle, creased};
use crate::optimize::improve;
use crate::run::Run;

/// The operators' mesh is taken if it cuts off creases with at most this share of the triangles that cut them off in the leaf
/// method's: of what they recover nothing is left, of bends tighter than the cells about as much as before.
const RECOVERED: f64 = 0.5;
/// Where fewer than this share of the triangles cut creases off, the exact edges of all other leaves are worth more than the creases
/// are. A cube with holes as one closure has 894 of 16 640; a union of some sixty leaves with blends has 2 of 56 632, where fillets
/// end, and operators took ten times as long on it as its exact mesh.
const FEW: f64 = 0.005;

/// The attempts at a mesh that is given up for the creases it cuts off.
fn given_up(made: &ByLeaf, cut_off: usize, run: &Run) -> Vec<Attempt> {
    let why = format!("{cut_off} triangles cut off creases inside a closure or formula");
    tell_dropped(&made.attempts, &why, run);
    let mut attempts = made.attempts.clone();
    for a in attempts.iter_mut().filter(|a| a.kept) {
        a.kept = false;
        a.why = why.clone();
    }
    attempts
}

/// The part by the operators, where a mesh of the leaf method cuts creases off and theirs does not.
pub(super) fn hidden_creases(ready: &Ready, made: &ByLeaf, options: &MeshOptions, run: &Run) -> Result<Option<ByLeaf>> {
    if made.proved && !ready.model.has_black_boxes() {
        return Ok(None);
    }
    let oracle = ImplicitOracle::new(&ready.model, &made.extracted);
    let cut_off = creased(&made.mesh, &oracle, run).len();
    if cut_off as f64 <= FEW * made.mesh.triangles.len() as f64 || !made.method.is_exact() {
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
    let mut attempts = given_up(made, cut_off, run);
    let operators = Attempt::new(Tried::Operators, ready.size, mesh.triangles.len(), 0, &mut clock).kept();
    add_attempt(&mut attempts, operators, run);
    let other = ByLeaf::by_other(mesh, extracted, ready.size, Method::Cut, Vec::new());
    Ok(Some(ByLeaf { attempts, ..other }))
}
