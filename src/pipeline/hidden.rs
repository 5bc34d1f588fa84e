//! Creases inside black boxes: closures, and formulas that do not fall into leaves. The leaf method knows nothing of them and
//! cuts them off; the default sequence of operators, which sees only the surface, finds them.

use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change};
use super::leaf::ByLeaf;
use super::mesh::Ready;
use super::method::Method;
use super::options::MeshOptions;
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

/// The part by the operators, where a mesh of the leaf method cuts creases off and theirs does not.
pub(super) fn hidden_creases(
    ready: &Ready,
    made: &ByLeaf,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<Option<ByLeaf>> {
    // Where triangles of the arrangement stay it is bends tighter than cells that are cut off.
    if made.start.keeps() || (made.proved && !ready.model.has_black_boxes()) {
        return Ok(None);
    }
    let oracle = ImplicitOracle::new(&ready.model, &made.extracted);
    let cut_off = creased(&made.mesh, &oracle, run).len();
    if cut_off as f64 <= FEW * made.mesh.triangles.len() as f64 || !made.method.is_exact() {
        return Ok(None);
    }
    attempts.change(Change::OtherWay, "triangles cut off creases inside a closure or formula");
    let extracted = ready.extract(ready.size, options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let improved = improve(&mut mesh, &oracle, &ready.operator_options(options), run)?;
    let flawed = improved.self_intersections + improved.after.inverted;
    let left = creased(&mesh, &oracle, run).len();
    let number = attempts.add(Attempt::new(Tried::Operators, ready.size, mesh.triangles.len(), flawed), run);
    if flawed > 0 || left as f64 > RECOVERED * cut_off as f64 {
        return Ok(None);
    }
    Ok(Some(ByLeaf { number, ..ByLeaf::by_other(mesh, extracted, ready.size, Method::Cut, Vec::new()) }))
}
