//! Making the bricks of a round.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::super::cells::{CELLS, COARSER};
use super::super::history::Proof;
use super::super::leaf::remesh_options;
use super::super::mesh::{Meshed, Ready};
use super::file::{BrickPiece, Handed, NONE, NodeId, Store, Which, is_raw, made_in};
use super::history::History;
use super::merge::{MergedBricks, all_there, collected, merged};
use super::plan::BrickPlan;
use crate::error::{Error, Place, Result};
use crate::implicit::{CellGrid, ImplicitOracle, arranged};
use crate::mesh::TriMesh;
use crate::mesh::sides::sides;
use crate::numeric::Sets;
use crate::remesh::{BAND, InPieces, Laid, patch_open_pieces, remesh_open};
use crate::run::Run;

/// Rounds: the bricks of the grid, shifted by half, by a quarter.
pub const ROUNDS: usize = 3;

/// Rounds in which notches of what is handed on are filled: each takes one triangle into a notch.
const NOTCHES: usize = 4;

/// Triangles reach this many cells beyond their brick: a node lies in its tetrahedron, or as far from it as that is large.
const BEYOND: f64 = 4.0;

/// Which of the bricks one worker makes: the `number`th of `of` shares, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// From 1 to `of`.
    pub number: u32,
    /// How many shares there are.
    pub of: u32,
}

impl Share {
    /// All bricks.
    pub const ALL: Self = Share { number: 1, of: 1 };

    /// Its bricks of a round: dealt out one by one, the dearest first.
    fn of_round(self, plan: &BrickPlan, round: usize) -> Vec<u32> {
        let mut all: Vec<u32> = (0..plan.rounds()[round]).collect();
        if round == 0 {
            all.sort_by_key(|i| (std::cmp::Reverse(plan.costs[*i as usize]), *i));
        }
        all.into_iter().skip(self.number as usize - 1).step_by(self.of as usize).collect()
    }
}

/// Some of a surface before a round works on it.
struct Given {
    mesh: TriMesh,
    /// The leaves of each node.
    on: Vec<Vec<u32>>,
    /// The face of each triangle; `mesh.labels` has its leaf.
    faces: Vec<u32>,
    /// What nodes at open edges are called, by their places.
    ends: FxHashMap<[u64; 3], NodeId>,
    proof: Proof,
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

impl Given {
    /// Notes what nodes at open edges are called. Two nodes of different names at one place could not be told apart.
    fn note(&mut self, v: u32, id: NodeId) -> Result<()> {
        let p = self.mesh.nodes[v as usize];
        match self.ends.insert(bits(p), id) {
            Some(other) if other != id => {
                let what = "two nodes where bricks meet are in one place, as a face or an edge passes through points of the grid: \
                            a size that is a little different moves them";
                Err(Error::input(Place::Point(p), what))
            }
            _ => Ok(()),
        }
    }
}

/// Makes the bricks of one share and round that are not there, or of all rounds; the pieces go into the plan's folder. Returns how
/// many were made.
///
/// Errors: a share without end; bricks of an earlier round that are missing; those of arranging and remeshing; cancellation.
pub fn make_bricks(plan: &BrickPlan, folder: &Path, share: Share, round: Option<usize>, run: &Run) -> Result<usize> {
    make(plan, &Store::folder(plan, folder), Rounds { share, only: round, history: &mut History::new(false) }, run)
}

/// All bricks of a plan and their merge, as [`make_bricks`] and [`merge_on_disk`](super::merge_on_disk) make them. The report has
/// the rounds among its stages; `timed` adds how long they took.
///
/// Errors: those of the two.
pub fn mesh_bricks<'a>(plan: &BrickPlan, folder: &'a Path, timed: bool, run: &Run) -> Result<MergedBricks<'a>> {
    let mut history = History::new(timed);
    let store = Store::folder(plan, folder);
    make(plan, &store, Rounds { share: Share::ALL, only: None, history: &mut history }, run)?;
    all_there(plan, &store, ROUNDS)?;
    merged(plan, store, history, run)
}

/// Which bricks are made, and who is told.
struct Rounds<'a> {
    share: Share,
    /// One round; all without.
    only: Option<usize>,
    history: &'a mut History,
}

fn make(plan: &BrickPlan, store: &Store<'_>, rounds: Rounds<'_>, run: &Run) -> Result<usize> {
    let Rounds { share, only: round, history } = rounds;
    if share.number < 1 || share.number > share.of {
        return Err(Error::Usage(format!("there is no share {} of {}", share.number, share.of)));
    }
    let part = plan.part()?;
    let ready = plan.ready(&part)?;
    let maker = Maker { plan, store, ready: &ready, run };
    let mut made = 0;
    for r in (0..ROUNDS).filter(|r| round.is_none_or(|only| only == *r)) {
        let mine = share.of_round(plan, r);
        let done = AtomicUsize::new(0);
        let stay = AtomicUsize::new(0);
        let one = |brick: &u32| -> Result<usize> {
            run.check()?;
            let which = Which { round: r, brick: *brick };
            let there = store.load(which)?;
            let missing = there.is_none();
            let triangles = match there {
                Some(piece) => piece.triangles.len(),
                None => {
                    let piece = maker.piece(which)?;
                    let triangles = piece.triangles.len();
                    store.save(piece, which)?;
                    triangles
                }
            };
            stay.fetch_add(triangles, Ordering::Relaxed);
            let n = done.fetch_add(1, Ordering::Relaxed) + 1;
            run.progress("bricks", (r as f64 + n as f64 / mine.len() as f64) / ROUNDS as f64);
            Ok(usize::from(missing))
        };
        let counts: Vec<Result<usize>> = run.install(|| mine.par_iter().with_max_len(1).map(one).collect());
        made += counts.into_iter().sum::<Result<usize>>()?;
        history.round(r, stay.into_inner(), run);
    }
    Ok(made)
}

/// The piece of one brick of the first round as bytes, for those who carry them to [`merge_pieces`] themselves.
///
/// Errors: a brick that the plan does not have; those of arranging and remeshing; cancellation.
pub fn make_piece(plan: &BrickPlan, brick: u32, run: &Run) -> Result<Vec<u8>> {
    if brick >= plan.rounds()[0] {
        return Err(Error::Usage(format!("the plan has no brick {brick}")));
    }
    let store = Store::memory(plan);
    let ready = last_ready(plan)?;
    let which = Which { round: 0, brick };
    let piece = run.install(|| Maker { plan, store: &store, ready: &ready, run }.piece(which))?;
    Ok(store.bytes(&piece, which))
}

/// The part of the plan that was asked for last, by the plan's digest: a large one takes seconds to read.
static LAST: Mutex<Option<([u8; 32], Arc<Ready>)>> = Mutex::new(None);

/// A plan's part made ready for meshing, kept until another plan's is asked for. Threads that ask for the same one wait for the first.
fn last_ready(plan: &BrickPlan) -> Result<Arc<Ready>> {
    let digest = plan.digest();
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, ready)) = last.as_ref().filter(|(of, _)| *of == digest) {
        return Ok(ready.clone());
    }
    let ready = Arc::new(plan.ready(&plan.part()?)?);
    *last = Some((digest, ready.clone()));
    Ok(ready)
}

/// The mesh of the pieces of all bricks of the first round, each with its brick: the other rounds are made here, in memory.
///
/// Errors: see [`merge_bricks`](super::merge_bricks) and [`make_bricks`].
pub fn merge_pieces<'b>(
    plan: &BrickPlan,
    pieces: impl IntoIterator<Item = (u32, &'b [u8])>,
    run: &Run,
) -> Result<Meshed> {
    let store = Store::memory(plan);
    for (brick, bytes) in pieces {
        let which = Which { round: 0, brick };
        let bad = |what: &str| Error::input(Place::Unknown, format!("{}: {what}", which.name()));
        store.save(store.parse(bytes, which).map_err(bad)?, which)?;
    }
    all_there(plan, &store, 1)?;
    // Who made the first round is not known here: the others alone are no stages of the mesh.
    for r in 1..ROUNDS {
        make(plan, &store, Rounds { share: Share::ALL, only: Some(r), history: &mut History::new(false) }, run)?;
    }
    collected(merged(plan, store, History::new(false), run)?)
}

struct Maker<'a> {
    plan: &'a BrickPlan,
    store: &'a Store<'a>,
    ready: &'a Ready,
    run: &'a Run,
}

impl Maker<'_> {
    fn piece(&self, which: Which) -> Result<BrickPiece> {
        let given = if which.round == 0 { self.arranged(which.brick)? } else { self.gathered(which)? };
        if given.mesh.triangles.is_empty() {
            return Ok(BrickPiece { proof: given.proof, ..BrickPiece::default() });
        }
        self.remeshed(which, given)
    }

    /// What the leaves' arrangement gives in a brick.
    fn arranged(&self, brick: u32) -> Result<Given> {
        let Self { plan, ready, run, .. } = self;
        let grid = CellGrid {
            size: plan.cell(),
            coarser: COARSER,
            places: &[],
            more: 0,
            block: Some(plan.blocks().block(brick)),
            before: None,
        };
        let made = arranged(&ready.model, &grid, plan.options.memory, run)?;
        let proof = Proof::of(&made);
        let (ends, made) = (made.ends, made.made);
        let mut given =
            Given { mesh: made.mesh, on: made.leaves, faces: made.faces, ends: FxHashMap::default(), proof };
        ends.into_iter().try_for_each(|(v, key)| given.note(v, key))?;
        Ok(given)
    }

    /// What the round before handed on that lies in a brick.
    fn gathered(&self, which: Which) -> Result<Given> {
        let Which { round, brick } = which;
        let blocks = self.plan.blocks();
        let bounds = blocks.bounds(round, brick);
        let mut mesh = TriMesh::default();
        let (mut on, mut faces, mut ids): (Vec<Vec<u32>>, Vec<u32>, Vec<NodeId>) = Default::default();
        let mut numbers: FxHashMap<NodeId, u32> = FxHashMap::default();
        for from in blocks.near(round - 1, &bounds, BEYOND * self.plan.cell()) {
            let Handed { nodes, on: leaves, ids: names, triangles, leaves: labels, faces: given, .. } =
                self.store.handed(Which { round: round - 1, brick: from }, brick)?;
            for t in triangles {
                mesh.triangles.push(t.map(|v| {
                    let v = v as usize;
                    *numbers.entry(names[v]).or_insert_with(|| {
                        mesh.nodes.push(nodes[v]);
                        on.push(leaves[v].iter().copied().filter(|l| *l != NONE).collect());
                        ids.push(names[v]);
                        ids.len() as u32 - 1
                    })
                }));
            }
            mesh.labels.extend(labels);
            faces.extend(given);
        }
        mesh.faces = vec![String::new(); self.ready.model.leaves.len()];
        let ends = open_nodes(&mesh);
        let copies = fans_apart(&mut mesh);
        on.extend(copies.iter().map(|v| on[*v as usize].clone()).collect::<Vec<_>>());
        let proof = Proof::default();
        let mut given = Given { mesh, on, faces, ends: FxHashMap::default(), proof };
        ends.into_iter().try_for_each(|v| given.note(v, ids[v as usize]))?;
        Ok(given)
    }

    fn remeshed(&self, which: Which, given: Given) -> Result<BrickPiece> {
        let Self { plan, ready, run, .. } = self;
        let blocks = plan.blocks();
        let bounds = blocks.bounds(which.round, which.brick);
        let model = &ready.model;
        let around = bounds.grown(BEYOND * plan.cell()).intersection(&model.bounds().grown(plan.cell()));
        // Apexes have their node after the first round.
        let nodes: FxHashMap<[u64; 3], ()> = given.mesh.nodes.iter().map(|p| (bits(*p), ())).collect();
        let is_mine = |p: DVec3| {
            if which.round == 0 { blocks.holding(0, p) == which.brick } else { nodes.contains_key(&bits(p)) }
        };
        let oracle = ImplicitOracle::within(model, ready.size, around, &is_mine, run)?;
        let pieces = InPieces { mesh: &given.mesh, on: &given.on, faces: &given.faces, stays: &[] };
        let mut work = patch_open_pieces(&pieces, &oracle, ready.size)?;
        // All of it is made anew: a brick of the first round has no end that is remeshed.
        work.policy.made_anew = if which.round == 0 { BAND } else { 0 };
        if which.round > 0 {
            work.sizes = sizes_at_ends(&given);
        }
        let options = remesh_options(ready, &plan.mesh_options(), CELLS[CELLS.len() - 1] * ready.size)?;
        // A piece has numbers of faces; names come with merging.
        let names = TriMesh { faces: vec![String::new(); model.faces().len()], ..TriMesh::default() };
        let (made, laid) = remesh_open(work, &names, &oracle, &options, run)?;
        let Laid { pieces, on } = laid;
        let mesh = made.mesh;
        let mut known: Vec<(u32, NodeId)> = Vec::new();
        for v in open_nodes(&mesh) {
            let p = mesh.nodes[v as usize];
            let id = given.ends.get(&bits(p)).ok_or_else(|| {
                Error::Failed(format!("{}: a node at a wall moved, near ({}, {}, {})", which.name(), p.x, p.y, p.z))
            })?;
            known.push((v, *id));
        }
        let from: Vec<u32> = known.iter().filter(|k| which.round + 1 < ROUNDS && is_raw(&k.1)).map(|k| k.0).collect();
        let handed = within_edges(&mesh, &from);
        let from = Uncut { mesh, on, leaves: pieces, known: known.into_iter().collect(), which };
        let next = |p: DVec3| blocks.holding(which.round + 1, p);
        Ok(BrickPiece { proof: given.proof, ..from.parted(&handed, &next) })
    }
}

/// A remeshed piece before it is parted.
struct Uncut {
    mesh: TriMesh,
    /// The leaves of each node.
    on: Vec<Vec<u32>>,
    /// The leaf of each triangle.
    leaves: Vec<u32>,
    /// What nodes at open edges are called.
    known: FxHashMap<u32, NodeId>,
    which: Which,
}

impl Uncut {
    /// What a node is called, as far as its piece knows.
    fn name(&self, v: u32) -> NodeId {
        self.known.get(&v).copied().unwrap_or_else(|| made_in(self.which.round, self.which.brick, v))
    }

    /// Parts the triangles that stay from those handed on, each to the brick of the next round that holds its middle.
    fn parted(&self, handed: &[bool], next: &dyn Fn(DVec3) -> u32) -> BrickPiece {
        let Self { mesh, .. } = self;
        let mut shared = vec![false; mesh.nodes.len()];
        let mut sections: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for t in (0..handed.len()).filter(|t| handed[*t]) {
            mesh.triangles[t].iter().for_each(|v| shared[*v as usize] = true);
            let middle = mesh.corners(t).iter().sum::<DVec3>() / 3.0;
            sections.entry(next(middle)).or_default().push(t);
        }
        let stays: Vec<usize> = (0..handed.len()).filter(|t| !handed[*t]).collect();
        let Few { nodes, triangles } = self.some(&stays);
        let named = |(k, v): (usize, &u32)| {
            (shared[*v as usize] || self.known.contains_key(v)).then(|| (k as u32, self.name(*v)))
        };
        BrickPiece {
            known: nodes.iter().enumerate().filter_map(named).collect(),
            nodes: nodes.iter().map(|v| mesh.nodes[*v as usize]).collect(),
            triangles,
            faces: stays.iter().map(|t| mesh.labels[*t]).collect(),
            handed: sections.iter().map(|(to, list)| self.handed(*to, list)).collect(),
            proof: Proof::default(),
        }
    }

    fn handed(&self, to: u32, list: &[usize]) -> Handed {
        let Few { nodes, triangles } = self.some(list);
        let on = |v: &u32| std::array::from_fn(|k: usize| self.on[*v as usize].get(k).copied().unwrap_or(NONE));
        Handed {
            to,
            on: nodes.iter().map(on).collect(),
            ids: nodes.iter().map(|v| self.name(*v)).collect(),
            nodes: nodes.iter().map(|v| self.mesh.nodes[*v as usize]).collect(),
            triangles,
            leaves: list.iter().map(|t| self.leaves[*t]).collect(),
            faces: list.iter().map(|t| self.mesh.labels[*t]).collect(),
        }
    }

    /// Some of the triangles, with their nodes in the order of their first use.
    fn some(&self, list: &[usize]) -> Few {
        let mut number = vec![NONE; self.mesh.nodes.len()];
        let mut nodes = Vec::new();
        let triangles = list.iter().map(|t| {
            self.mesh.triangles[*t].map(|v| {
                let n = &mut number[v as usize];
                if *n == NONE {
                    *n = nodes.len() as u32;
                    nodes.push(v);
                }
                *n
            })
        });
        let triangles = triangles.collect();
        Few { nodes, triangles }
    }
}

/// Triangles with numbers of their own, and what these are in the piece.
struct Few {
    nodes: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// The nodes of open edges, ascending.
pub(in crate::pipeline) fn open_nodes(mesh: &TriMesh) -> Vec<u32> {
    let all = sides(mesh);
    let open = all.chunk_by(|x, y| x.key == y.key).filter(|e| e.len() == 1);
    let mut nodes: Vec<u32> = open.flat_map(|e| e[0].edge()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Gives each fan of triangles around a node a node of its own: where some of a surface ends two may touch in a point. Returns
/// which node each new one is a copy of.
pub(in crate::pipeline) fn fans_apart(mesh: &mut TriMesh) -> Vec<u32> {
    let mut fans = Sets::new(3 * mesh.triangles.len());
    let next = |h: u32| h - h % 3 + (h + 1) % 3;
    for e in sides(mesh).chunk_by(|x, y| x.key == y.key) {
        if let [a, b] = e {
            fans.join(a.number, next(b.number));
            fans.join(next(a.number), b.number);
        }
    }
    let mut copies = Vec::new();
    let mut first: Vec<u32> = vec![NONE; mesh.nodes.len()];
    let mut others: FxHashMap<u32, u32> = FxHashMap::default();
    for h in 0..3 * mesh.triangles.len() as u32 {
        let fan = fans.find(h);
        let v = mesh.triangles[(h / 3) as usize][(h % 3) as usize];
        if first[v as usize] == NONE {
            first[v as usize] = fan;
        }
        if first[v as usize] != fan {
            let new = *others.entry(fan).or_insert_with(|| {
                copies.push(v);
                let p = mesh.nodes[v as usize];
                mesh.nodes.push(p);
                mesh.nodes.len() as u32 - 1
            });
            mesh.triangles[(h / 3) as usize][(h % 3) as usize] = new;
        }
    }
    copies
}

/// The largest edge length each node may want: at ends that are remeshed already, what their edges have.
fn sizes_at_ends(given: &Given) -> Vec<f64> {
    let nodes = &given.mesh.nodes;
    let mut sums = vec![(0.0, 0u32); nodes.len()];
    for t in &given.mesh.triangles {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            let length = nodes[a].distance(nodes[b]);
            for v in [a, b] {
                sums[v] = (sums[v].0 + length, sums[v].1 + 1);
            }
        }
    }
    let wanted = |(p, (sum, n)): (&DVec3, (f64, u32))| match given.ends.get(&bits(*p)) {
        Some(id) if !is_raw(id) && n > 0 => sum / f64::from(n),
        _ => f64::INFINITY,
    };
    nodes.iter().zip(sums).map(wanted).collect()
}

/// Which triangles are within [`BAND`] edges of some nodes, and those between them; none if there are no such nodes.
fn within_edges(mesh: &TriMesh, from: &[u32]) -> Vec<bool> {
    if from.is_empty() {
        return vec![false; mesh.triangles.len()];
    }
    let mut near = vec![false; mesh.nodes.len()];
    from.iter().for_each(|v| near[*v as usize] = true);
    for _ in 1..BAND {
        let before = near.clone();
        for t in mesh.triangles.iter().filter(|t| t.iter().any(|v| before[*v as usize])) {
            t.iter().for_each(|v| near[*v as usize] = true);
        }
    }
    let mut within: Vec<bool> = mesh.triangles.iter().map(|t| t.iter().any(|v| near[*v as usize])).collect();
    // Without notches: a triangle between two others goes with them.
    let edges = mesh.inner_edges();
    for _ in 0..NOTCHES {
        let mut beside = vec![0u8; within.len()];
        for (_, [a, b]) in &edges {
            let (a, b) = (*a as usize, *b as usize);
            beside[a] += u8::from(within[b]);
            beside[b] += u8::from(within[a]);
        }
        let more: Vec<usize> = (0..within.len()).filter(|t| !within[*t] && beside[*t] >= 2).collect();
        if more.is_empty() {
            break;
        }
        more.into_iter().for_each(|t| within[t] = true);
    }
    within
}
