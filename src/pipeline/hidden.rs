//! Creases inside black boxes: closures, and formulas that do not fall into leaves. The leaf method knows nothing of them and
//! cuts them off; the default sequence of operators, which sees only the surface, finds them.

use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change};
use super::leaf::ByLeaf;
use super::mesh::Ready;
use super::method::Method;
use super::options::MeshOptions;
use crate::error::{Error, Result};
use crate::implicit::{Extracted, ImplicitOracle, Remembered, creased, cutting_off, with_jumps};
use crate::mesh::TriMesh;
use crate::optimize::improve;
use crate::run::Run;

/// The operators' mesh is taken if it cuts off creases with at most this share of the triangles that cut them off in the leaf
/// method's: of what they recover nothing is left, of bends tighter than the cells about as much as before.
const RECOVERED: f64 = 0.5;
/// Where fewer than this share of the triangles cut creases off, the exact edges of all other leaves are worth more than the creases
/// are. A cube with holes as one closure has 894 of 16 640; a union of some sixty leaves with blends has 2 of 56 632, where fillets
/// end, and operators took ten times as long on it as its exact mesh.
const FEW: f64 = 0.005;

/// The part by the operators before any other attempt, where marching cubes show creases inside functions of the user's own: the leaf
/// method's cells would be smallest along all of these, and prove nothing there. `None` where there are no such creases, or the operators
/// do not recover them.
pub(super) fn creases_seen(
    ready: &Ready,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<Option<ByLeaf>> {
    if !ready.model.has_fields() {
        return Ok(None);
    }
    // Stand-ins are on the way to any mesh, and what they ask is kept.
    let extracted = match ready.extract_any(&ready.asked, ready.size, options, run) {
        Ok(extracted) => extracted,
        Err(Error::Cancelled) => return Err(Error::Cancelled),
        // The leaf method's smaller cells may see more.
        Err(_) => return Ok(None),
    };
    // Slivers of marching cubes face anywhere: areas count.
    let oracle = ImplicitOracle::new(&ready.asked, &extracted);
    let cut_off = share(&extracted.mesh, &oracle, run);
    if !(cut_off > FEW) {
        return Ok(None);
    }
    let extracted = ready.extract(ready.size, options, run)?;
    let (made, flawed) = by_operators(ready, extracted, options, attempts, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &made.extracted);
    let recovered = flawed == 0 && share(&made.mesh, &oracle, run) <= RECOVERED * cut_off;
    if !recovered {
        attempts.change(Change::OtherWay, "operators do not recover all creases inside a closure");
    }
    Ok(recovered.then_some(made))
}

/// The share of a mesh's area in triangles that cut off creases inside faces: where faces meet, marching cubes cut off edges that the
/// tree knows.
fn share(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> f64 {
    let mut face: Vec<Option<u32>> = vec![None; mesh.nodes.len()];
    let mut is_between = vec![false; mesh.nodes.len()];
    for (t, label) in mesh.triangles.iter().zip(&mesh.labels) {
        for v in t.map(|v| v as usize) {
            is_between[v] |= face[v].is_some_and(|f| f != *label);
            face[v] = Some(*label);
        }
    }
    let area = |t: usize| mesh.area_vector(t).length();
    let all: f64 = (0..mesh.triangles.len()).map(area).sum();
    let within = |t: &usize| mesh.triangles[*t].iter().all(|v| !is_between[*v as usize]);
    // What bends too tightly for triangles of one size is no crease.
    let cut_off = with_jumps(mesh, oracle, &cutting_off(mesh, oracle, run), run);
    cut_off.into_iter().map(|t| t as usize).filter(within).map(area).sum::<f64>() / all
}

/// The part by the operators, and how many of its triangles are flawed.
fn by_operators(
    ready: &Ready,
    extracted: Extracted,
    options: &MeshOptions,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<(ByLeaf, usize)> {
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let improved = improve(&mut mesh, &Remembered::new(&oracle), &ready.operator_options(options), run)?;
    let flawed = improved.self_intersections + improved.after.inverted;
    let number = attempts.add(Attempt::new(Tried::Operators, ready.size, mesh.triangles.len(), flawed), run);
    let made = ByLeaf::by_other(mesh, extracted, ready.size, Method::Cut, Vec::new());
    Ok((ByLeaf { number, ..made }, flawed))
}

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
    let (recovered, flawed) = by_operators(ready, extracted, options, attempts, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &recovered.extracted);
    let left = creased(&recovered.mesh, &oracle, run).len();
    if flawed > 0 || left as f64 > RECOVERED * cut_off as f64 {
        return Ok(None);
    }
    Ok(Some(recovered))
}
