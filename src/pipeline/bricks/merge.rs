//! Pieces to one mesh.

use std::path::Path;

use rustc_hash::FxHashMap;

use super::super::history::{Attempt, Clock, Proof, Tried, add_attempt};
use super::super::mesh::{Meshed, finish_names};
use super::super::report::Report;
use super::ROUNDS;
use super::file::{NONE, NodeId, Piece, Store, Which, made_in};
use super::plan::BrickPlan;
use super::rounds::open_nodes;
use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::quality::{Expectation, check};
use crate::run::Run;

/// How many missing bricks an error names.
const NAMED: usize = 8;

/// The mesh of all pieces of a plan, with its certificate.
///
/// Nodes are joined by what they are called. Where pieces do not fit the mesh would be open: that is an error with the place.
///
/// Errors: missing or damaged pieces, by name; pieces that do not match; cancellation.
pub fn merge_bricks(plan: &BrickPlan, folder: &Path, run: &Run) -> Result<Meshed> {
    let store = Store::Folder(folder);
    all_there(plan, &store, ROUNDS)?;
    merged(plan, &store, run)
}

/// The same of a store that has all pieces.
pub(super) fn merged(plan: &BrickPlan, store: &Store<'_>, run: &Run) -> Result<Meshed> {
    let part = plan.part()?;
    let ready = plan.ready(&part)?;
    let mut mesh =
        TriMesh { faces: ready.model.faces().iter().map(|f| f.name.clone()).collect(), ..TriMesh::default() };
    let mut shared: FxHashMap<NodeId, u32> = FxHashMap::default();
    let mut proof = Proof::default();
    for round in 0..ROUNDS {
        for brick in 0..plan.rounds()[round] {
            run.check()?;
            let which = Which { round, brick };
            let Some(piece) = store.load(plan, which)? else { continue };
            add(&mut mesh, &mut shared, &piece, which)?;
            proof.add(&piece.proof);
        }
    }
    drop(shared);
    if let Some(v) = open_nodes(&mesh).first() {
        let at = mesh.nodes[*v as usize];
        let round0 = Which { round: 0, brick: plan.blocks().holding(0, at) };
        let what = format!("pieces do not match near {}: the solid may touch itself where bricks meet", round0.name());
        return Err(Error::input(Place::Point(at), what));
    }
    let mut report = Report::of("bricks", plan.options.size, part.units.clone());
    let attempt = Attempt::new(Tried::Arrange, plan.cell(), mesh.triangles.len(), 0, &mut Clock::new(false)).kept();
    add_attempt(&mut report.attempts, Attempt { proof: Some(proof), ..attempt }, run);
    finish_names(&part, &mut mesh, &mut report);
    report.judge(check(&mesh, Expectation::default(), None, run)?);
    Ok(Meshed { mesh, seams: Vec::new(), corners: Vec::new(), outline: None, report, solid: None })
}

/// Adds the triangles of a piece that were not handed on.
fn add(mesh: &mut TriMesh, shared: &mut FxHashMap<NodeId, u32>, piece: &Piece, which: Which) -> Result<()> {
    let mut known: Vec<Option<NodeId>> = vec![None; piece.nodes.len()];
    for (v, id) in &piece.known {
        known[*v as usize] = Some(*id);
    }
    // Nodes of triangles that are handed on are known to the next round by the piece they were made in.
    for (t, _) in piece.triangles.iter().zip(&piece.handed).filter(|x| *x.1) {
        for v in t {
            known[*v as usize].get_or_insert_with(|| made_in(which.round, which.brick, *v));
        }
    }
    let mut number = vec![NONE; piece.nodes.len()];
    for t in (0..piece.triangles.len()).filter(|t| !piece.handed[*t]) {
        for v in piece.triangles[t] {
            let v = v as usize;
            if number[v] == NONE {
                let mut fresh = || {
                    mesh.nodes.push(piece.nodes[v]);
                    mesh.nodes.len() as u32 - 1
                };
                number[v] = match known[v] {
                    Some(id) => *shared.entry(id).or_insert_with(fresh),
                    None => fresh(),
                };
            }
        }
        mesh.triangles.push(piece.triangles[t].map(|v| number[v as usize]));
        mesh.labels.push(piece.faces[t]);
    }
    if mesh.nodes.len() as u64 >= u64::from(NONE) || mesh.triangles.len() as u64 >= u64::from(NONE) {
        return Err(Error::Failed("more nodes or triangles than one mesh can number".into()));
    }
    Ok(())
}

/// Refuses to merge when pieces of the first so many rounds are missing, and says which.
pub(super) fn all_there(plan: &BrickPlan, store: &Store<'_>, rounds: usize) -> Result<()> {
    let all = (0..rounds).flat_map(|round| (0..plan.rounds()[round]).map(move |brick| Which { round, brick }));
    let missing: Vec<Which> = all.filter(|w| !store.has(*w)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = missing.iter().take(NAMED).map(|w| w.name()).collect();
    let more = if missing.len() > NAMED { format!(" and {} more", missing.len() - NAMED) } else { String::new() };
    let e = Error::input(Place::Unknown, format!("not made: {}{more}", names.join(", ")));
    Err(match store {
        Store::Folder(folder) => {
            e.in_file(*folder).with_help(format!("rvachev brick {} makes what is missing", folder.display()))
        }
        Store::Memory(_) => e,
    })
}
