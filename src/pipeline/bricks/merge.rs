//! Pieces to one mesh.

use std::path::Path;
use std::sync::Mutex;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::groups::{finish_names, lost_groups};
use super::super::history::{Attempt, Proof, Tried};
use super::super::mesh::Meshed;
use super::super::report::Report;
use super::super::source::MeshOrigin;
use super::ROUNDS;
use super::file::{BrickPiece, NONE, NodeId, Store, Which};
use super::history::History;
use super::plan::BrickPlan;
use super::portions::{Firsts, PiecewiseMesh, Span, portion};
use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::mesh::portion::{Joined, Joining};
use crate::pipeline::brep_check::LISTED;
use crate::quality::{Check, SHARP_MESH, Sums};
use crate::run::Run;

/// A mesh of bricks that stays on disk, and what is known about it.
pub struct MergedBricks<'a> {
    /// The mesh, read piece by piece.
    pub mesh: PiecewiseMesh<'a>,
    /// What is known about it; the mesh in it has names and groups, and no triangles.
    pub made: Meshed,
}

/// The mesh of all pieces of a plan, with its certificate.
///
/// Nodes are joined by what they are called. Where pieces do not fit the mesh would be open: that is an error with the place.
///
/// Errors: missing or damaged pieces, by name; pieces that do not match; cancellation.
pub fn merge_bricks(plan: &BrickPlan, folder: &Path, run: &Run) -> Result<Meshed> {
    collected(merge_on_disk(plan, folder, false, run)?)
}

/// Like [`merge_bricks`], in memory for a few pieces and for the nodes that pieces share: the mesh is read from the plan's folder.
///
/// The mesh and the certificate are the same, to the last bit. `timed` adds to the report how long it took.
///
/// Errors: see [`merge_bricks`].
pub fn merge_on_disk<'a>(plan: &BrickPlan, folder: &'a Path, timed: bool, run: &Run) -> Result<MergedBricks<'a>> {
    let history = History::new(timed);
    let store = Store::folder(plan, folder);
    all_there(plan, &store, ROUNDS)?;
    merged(plan, store, history, run)
}

/// The mesh in arrays.
pub(super) fn collected(merged: MergedBricks<'_>) -> Result<Meshed> {
    Ok(Meshed { mesh: merged.mesh.collected()?, ..merged.made })
}

/// The mesh of a store that has all pieces.
pub(super) fn merged<'a>(
    plan: &BrickPlan,
    store: Store<'a>,
    mut history: History,
    run: &Run,
) -> Result<MergedBricks<'a>> {
    let part = plan.part()?;
    let ready = plan.ready(&part)?;
    let faces: Vec<String> = ready.model.faces().iter().map(|f| f.name.clone()).collect();
    let mut numbering = MergedNumbers { used: vec![false; faces.len()], ..MergedNumbers::default() };
    let all: Vec<Which> =
        (0..ROUNDS).flat_map(|round| (0..plan.rounds()[round]).map(move |brick| Which { round, brick })).collect();
    for (k, which) in all.iter().enumerate() {
        run.check()?;
        run.progress("merge", k as f64 / all.len() as f64);
        if let Some(piece) = store.load(*which)? {
            numbering.add(&piece, *which)?;
        }
    }
    let MergedNumbers { numbers, places, spans, joining, proof, used } = numbering;
    let joined = joining.finish(SHARP_MESH);
    if let Some(edge) = joined.whole.open.first() {
        let at = edge.ends[0];
        let round0 = Which { round: 0, brick: plan.blocks().holding(0, at) };
        let what = format!("pieces do not match near {}: the solid may touch itself where bricks meet", round0.name());
        return Err(Error::input(Place::Point(at), what));
    }
    let mut report = Report::of("bricks", plan.options.size, part.units.clone());
    let triangles = joined.whole.triangles;
    let attempt = Attempt { proof: Some(proof), ..Attempt::new(Tried::Arrange, plan.cell(), triangles, 0) };
    history.stage("merge", triangles, run);
    // One triangle stands for all of its face.
    let of_faces: Vec<u32> = (0..faces.len() as u32).filter(|l| used[*l as usize]).collect();
    let mut names = TriMesh { faces, labels: of_faces.clone(), ..TriMesh::default() };
    finish_names(&part, &mut names, &mut report);
    let known = ready.model.faces();
    report.shortfalls.extend(lost_groups(&part, known.iter().map(|f| &f.name[..]), &names.faces));
    let mut labels = vec![NONE; used.len()];
    of_faces.iter().zip(std::mem::take(&mut names.labels)).for_each(|(old, new)| labels[*old as usize] = new);
    let mesh = PiecewiseMesh {
        store,
        names: names.clone(),
        labels,
        spans,
        numbers,
        places,
        at_hand: Mutex::default(),
        broken: Mutex::default(),
    };
    report.judge(measured(&mesh, joined, run)?, 0.0);
    history.stage("check", triangles, run);
    history.tell(attempt, &mut report, run);
    let source = MeshOrigin::Unknown("is made brick by brick");
    let made = Meshed { mesh: names, seams: Vec::new(), corners: Vec::new(), outline: None, report, source };
    Ok(MergedBricks { mesh, made })
}

/// Nodes and triangles on their way to numbers in one mesh.
#[derive(Default)]
struct MergedNumbers {
    numbers: FxHashMap<NodeId, u32>,
    places: FxHashMap<u32, DVec3>,
    spans: Vec<Span>,
    joining: Joining,
    proof: Proof,
    /// Which faces have triangles.
    used: Vec<bool>,
}

impl MergedNumbers {
    fn add(&mut self, piece: &BrickPiece, which: Which) -> Result<()> {
        self.proof.add(&piece.proof, which.brick);
        let (node, cell) =
            self.spans.last().map_or((0, 0), |s| (s.first.node as usize + s.nodes, s.first.cell as usize + s.cells));
        if node + piece.nodes.len() >= NONE as usize || cell + piece.triangles.len() >= NONE as usize {
            return Err(Error::Failed("more nodes or triangles than one mesh can number".into()));
        }
        let first = Firsts { node: node as u32, cell: cell as u32 };
        let mut number = |id: NodeId, fresh: u32| Some(*self.numbers.entry(id).or_insert(fresh));
        let Some(p) = portion(piece, first, &mut number) else { return Ok(()) };
        let bad = |what: String| Error::input(Place::Unknown, format!("{}: {what}", which.name()));
        if let Some(at) = p.mesh.nodes.iter().find(|p| !p.is_finite()) {
            return Err(bad(format!("a node's coordinates are not finite: {at}")));
        }
        for l in &p.mesh.labels {
            *self.used.get_mut(*l as usize).ok_or_else(|| bad(format!("there is no face {l}")))? = true;
        }
        for v in (0..p.nodes.len()).filter(|v| p.shared[*v]) {
            self.places.entry(p.nodes[v]).or_insert(p.mesh.nodes[v]);
        }
        let nodes = p.nodes.iter().filter(|n| **n >= first.node).count();
        self.joining.add(&p);
        self.spans.push(Span { which, first, nodes, cells: p.mesh.triangles.len(), bounds: p.mesh.bounds() });
        Ok(())
    }
}

/// Measures the mesh portion by portion, and each with those that come near it.
fn measured(mesh: &PiecewiseMesh<'_>, joined: Joined, run: &Run) -> Result<Check> {
    let mut sums = Sums::new(joined, &mesh.names);
    let filled: Vec<usize> = (0..mesh.spans.len()).filter(|s| mesh.spans[*s].cells > 0).collect();
    for (k, s) in filled.iter().enumerate() {
        run.check()?;
        run.progress("intersections", k as f64 / filled.len() as f64);
        let one = mesh.loaded(*s)?;
        sums.add(&one.portion, run)?;
        for other in filled[k + 1..].iter().filter(|o| mesh.spans[**o].bounds.overlaps(&mesh.spans[*s].bounds)) {
            sums.add_between(&one.portion, &mesh.loaded(*other)?.portion, run)?;
        }
    }
    Ok(sums.finish(&mesh.names))
}

/// Refuses to merge when pieces of the first so many rounds are missing, and says which; or when one is not of this plan by its
/// index, before any is read.
pub(super) fn all_there(plan: &BrickPlan, store: &Store<'_>, rounds: usize) -> Result<()> {
    let mut missing: Vec<Which> = Vec::new();
    for which in (0..rounds).flat_map(|round| (0..plan.rounds()[round]).map(move |brick| Which { round, brick })) {
        if !store.has(which)? {
            missing.push(which);
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = missing.iter().take(LISTED).map(|w| w.name()).collect();
    let more = if missing.len() > LISTED { format!(" and {} more", missing.len() - LISTED) } else { String::new() };
    let e = Error::input(Place::Unknown, format!("not made: {}{more}", names.join(", ")));
    Err(match store.place() {
        Some(folder) => {
            e.in_file(folder).with_help(format!("rvachev brick {} makes what is missing", folder.display()))
        }
        None => e,
    })
}
