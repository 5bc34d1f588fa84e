//! What is tried for bodies of a boundary representation: triangles of the first triangulation stay where remeshed ones cross, then whole
//! faces do, and at last faces that cross others from the start are left out.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::bodies::{FirstBody, Marks, Untouched, patchwork, split_fans};
use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change, Ladder, LadderState, climb};
use crate::error::{Error, Result};
use crate::mesh::{EditMesh, TriMesh, self_intersections};
use crate::parametric::Parametric;
use crate::parametric::mesh::Place;
use crate::remesh::{RemeshOptions, RemeshTarget, RemeshedMesh, remesh_patchwork};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// How often a body is remeshed with the same faces.
const TRIES: usize = 6;
/// How often triangles around such places stay, before faces do.
const LOCAL: usize = 2;
/// What is changed for bodies, in this order: each attempt makes one change, of all the bodies that need it.
const CHANGES: [Change; 3] = [Change::KeepHere, Change::KeepParts, Change::OtherWay];

/// A body after remeshing.
pub(super) struct Remeshed {
    pub(super) mesh: TriMesh,
    /// Faces that were left as they were first triangulated.
    pub(super) kept: Vec<u32>,
    /// Triangles of others that were.
    pub(super) stayed: usize,
    /// Faces that were left out.
    pub(super) dropped: Vec<u32>,
    /// Why it is as it was first triangulated, where it is.
    pub(super) shortfall: Option<String>,
    /// Whether no triangles intersect others.
    pub(super) sound: bool,
    /// The number of the attempt it is of.
    pub(super) number: usize,
}

impl Remeshed {
    /// With triangles that intersect others.
    fn unsound(mesh: TriMesh, shortfall: Option<String>, number: usize) -> Self {
        let (kept, dropped) = (Vec::new(), Vec::new());
        Self { mesh, kept, stayed: 0, dropped, shortfall, sound: false, number }
    }
}

/// The mesh of an attempt that has triangles which intersect others.
struct Crossing {
    mesh: TriMesh,
    /// How many do.
    count: usize,
    number: usize,
}

/// What every attempt at a body is made with.
#[derive(Clone, Copy)]
pub(super) struct Ways<'a> {
    pub(super) solid: &'a Parametric,
    pub(super) marks: &'a Marks,
    pub(super) options: &'a RemeshOptions,
}

/// A body on its way.
pub(super) struct BodyTrial {
    body: FirstBody,
    /// Faces that stay as they were first triangulated, ascending,
    kept: Vec<u32>,
    /// and triangles of others that do.
    stays: Vec<bool>,
    /// How often it was remeshed with the faces it has.
    tries: usize,
    /// The mesh with the fewest triangles that intersect others.
    best: Option<Crossing>,
    /// Faces that are left out, ascending, and what there is with them.
    dropped: Vec<u32>,
    whole: Option<Remeshed>,
    /// What the next attempt changes,
    wants: Option<Change>,
    /// or what came of it.
    done: Option<Remeshed>,
    /// The number of the last attempt, its triangles, and how many of these intersect others.
    number: usize,
    triangles: usize,
    faults: usize,
}

impl BodyTrial {
    pub(super) fn new(part: TriMesh, places: Vec<Place>, sizes: Vec<f64>, still: &[u32]) -> Self {
        Self {
            stays: vec![false; part.triangles.len()],
            body: FirstBody { part, places, sizes },
            kept: still.to_vec(),
            tries: 0,
            best: None,
            dropped: Vec::new(),
            whole: None,
            wants: Some(Change::First),
            done: None,
            number: 0,
            triangles: 0,
            faults: 0,
        }
    }

    /// Remeshes it as things stand, and says what is to change or that it is done.
    fn step(&mut self, ways: Ways<'_>, number: usize, run: &Run) -> Result<()> {
        let Ways { solid, marks, options } = ways;
        let part = &self.body.part;
        (self.number, self.triangles, self.faults) = (number, part.triangles.len(), 0);
        let edit = match EditMesh::new(part) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(e) => return self.as_it_was(e.to_string(), ways, run),
        };
        let untouched = Untouched { faces: &self.kept, triangles: &self.stays };
        let work = patchwork(solid, marks, edit, &self.body, untouched);
        let target = RemeshTarget { surface: solid, names: part };
        let quiet = Run::new().with_cancel(run.cancel_token());
        let RemeshedMesh { mesh: out, report: found, .. } = match remesh_patchwork(work, target, options, &quiet, None)
        {
            Err(Error::Input { message, .. }) => return self.as_it_was(message, ways, run),
            other => other?,
        };
        (self.triangles, self.faults) = (out.triangles.len(), found.self_intersections);
        self.tries += 1;
        // The labels are faces from here on.
        if found.self_intersections == 0 {
            let stayed = self.stays.iter().filter(|s| **s).count();
            let (kept, dropped) = (std::mem::take(&mut self.kept), std::mem::take(&mut self.dropped));
            self.settle(Remeshed { mesh: out, kept, stayed, dropped, shortfall: None, sound: true, number });
            return Ok(());
        }
        let bad: Vec<u32> = self_intersections(&out, run)?.into_iter().flatten().collect();
        let around: Vec<Aabb> = bad.iter().map(|t| Aabb::around(out.corners(*t as usize))).collect();
        if self.tries <= LOCAL && stay_around(&mut self.stays, &around, part, self.tries as f64) {
            self.wants = Some(Change::KeepHere);
            return Ok(());
        }
        self.stays.fill(false);
        let before = self.kept.len();
        self.kept.extend(bad.iter().map(|t| out.labels[*t as usize]));
        self.kept.sort_unstable();
        self.kept.dedup();
        if self.best.as_ref().is_none_or(|b| found.self_intersections < b.count) {
            self.best = Some(Crossing { mesh: out, count: found.self_intersections, number });
        }
        if self.kept.len() > before && self.tries < TRIES {
            self.wants = Some(Change::KeepParts);
            return Ok(());
        }
        self.end(ways, run)
    }

    /// Ends with its best mesh, unless fewer triangles of the first triangulation cross.
    fn end(&mut self, ways: Ways<'_>, run: &Run) -> Result<()> {
        let first = self_intersections(&self.body.part, run)?.len();
        match self.best.take().filter(|b| b.count <= first) {
            Some(b) => self.without(Remeshed::unsound(b.mesh, None, b.number), ways, run),
            None => self.as_it_was("remeshing folded it".into(), ways, run),
        }
    }

    /// Ends with the first triangulation.
    fn as_it_was(&mut self, why: String, ways: Ways<'_>, run: &Run) -> Result<()> {
        let mut part = self.body.part.clone();
        part.labels.iter_mut().for_each(|l| *l = ways.solid.face_of(*l));
        self.without(Remeshed::unsound(part, Some(why), self.number), ways, run)
    }

    /// Leaves out faces to blame where the body did not come out sound because it was not to begin with; where it does not do so
    /// without them either they stay.
    fn without(&mut self, out: Remeshed, ways: Ways<'_>, run: &Run) -> Result<()> {
        if let Some(whole) = self.whole.take() {
            self.settle(whole);
            return Ok(());
        }
        let solid = ways.solid;
        let FirstBody { part, places, sizes } = &self.body;
        let dropped = to_blame(solid, part, run)?;
        let left = |l: &u32| dropped.binary_search(&solid.face_of(*l)).is_err();
        if dropped.is_empty() || !part.labels.iter().any(left) {
            self.settle(out);
            return Ok(());
        }
        let mut rest = TriMesh { faces: part.faces.clone(), ..TriMesh::default() };
        let (mut of_rest, mut wants) = (Vec::new(), Vec::new());
        let mut number = vec![u32::MAX; part.nodes.len()];
        for (t, l) in part.triangles.iter().zip(&part.labels).filter(|x| left(x.1)) {
            for v in t.map(|v| v as usize) {
                if number[v] == u32::MAX {
                    number[v] = rest.nodes.len() as u32;
                    rest.nodes.push(part.nodes[v]);
                    of_rest.push(places[v]);
                    wants.push(sizes[v]);
                }
            }
            rest.triangles.push(t.map(|v| number[v as usize]));
            rest.labels.push(*l);
        }
        split_fans(&mut rest, &mut of_rest, &mut wants);
        let Self { number, triangles, faults, .. } = *self;
        let again = Self::new(rest, of_rest, wants, &ways.marks.still);
        let wants = Some(Change::OtherWay);
        *self = Self { dropped, whole: Some(out), wants, number, triangles, faults, ..again };
        Ok(())
    }

    /// Is done, and needs no more memory than what came of it.
    fn settle(&mut self, out: Remeshed) {
        (self.body, self.stays, self.best) = (FirstBody::default(), Vec::new(), None);
        (self.wants, self.done) = (None, Some(out));
    }
}

/// Bodies that are remeshed, each on its own: those that do not touch in any node know nothing of each other.
pub(super) struct BodyLadder<'a> {
    ways: Ways<'a>,
    size: f64,
    bodies: Vec<BodyTrial>,
    /// What the next attempt changes.
    change: Change,
}

impl<'a> BodyLadder<'a> {
    pub(super) fn new(ways: Ways<'a>, size: f64, bodies: Vec<BodyTrial>) -> Self {
        Self { ways, size, bodies, change: Change::First }
    }

    /// Remeshes bodies until all of them are sound, or nothing is left to change.
    pub(super) fn remeshed(mut self, attempts: &mut Attempts, run: &Run) -> Result<Vec<Remeshed>> {
        climb(&mut self, attempts, run)?;
        // The budget may end the climb.
        for body in &mut self.bodies {
            while body.done.is_none() {
                body.end(self.ways, run)?;
            }
        }
        Ok(self.bodies.into_iter().filter_map(|b| b.done).collect())
    }
}

impl Ladder for BodyLadder<'_> {
    /// Every body has a best mesh of its own.
    type Made = ();

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<()>> {
        let (ways, change, number) = (self.ways, self.change, attempts.len());
        let mut round: Vec<&mut BodyTrial> = self.bodies.iter_mut().filter(|b| b.wants == Some(change)).collect();
        let (done, count) = (AtomicUsize::new(0), round.len());
        // Bodies are the shares of the stage; one alone tells its own.
        let within = if count > 1 { run.unwatched() } else { run.clone() };
        let step = |body: &mut &mut BodyTrial| {
            run.check()?;
            body.step(ways, number, &within)?;
            run.progress("remesh", (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
            Ok(())
        };
        run.install(|| round.par_iter_mut().map(step).collect::<Vec<Result<()>>>())
            .into_iter()
            .collect::<Result<()>>()?;
        let triangles = round.iter().map(|b| b.triangles).sum();
        let faults = round.iter().map(|b| b.faults).sum();
        attempts.add(Attempt::new(Tried::Bodies, self.size, triangles, faults), run);
        Ok(Some(()))
    }

    fn is_better(&self, (): &(), _: Option<&()>) -> bool {
        true
    }

    fn next(&mut self, _: &LadderState<'_, ()>) -> Option<(Change, &'static str)> {
        let is_wanted = |c: &Change| self.bodies.iter().any(|b| b.wants == Some(*c));
        self.change = CHANGES.into_iter().find(is_wanted)?;
        let out = self.change == Change::OtherWay;
        Some((self.change, if out { "faces that cross others from the start are left out" } else { "triangles cross" }))
    }
}

/// As few faces as may be without which no triangles of a first triangulation intersect and no edge is there twice, ascending.
fn to_blame(solid: &Parametric, part: &TriMesh, run: &Run) -> Result<Vec<u32>> {
    let face = |t: u32| solid.face_of(part.labels[t as usize]);
    let mut pairs: Vec<[u32; 2]> = self_intersections(part, run)?.into_iter().map(|p| p.map(face)).collect();
    let mut seen: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (t, nodes) in part.triangles.iter().enumerate() {
        for k in 0..3 {
            if let Some(other) = seen.insert([nodes[k], nodes[(k + 1) % 3]], t as u32) {
                pairs.push([face(other), face(t as u32)]);
            }
        }
    }
    let mut out = Vec::new();
    while !pairs.is_empty() {
        let mut count = vec![0usize; solid.brep.faces.len()];
        for [a, b] in &pairs {
            count[*a as usize] += 1;
            count[*b as usize] += usize::from(a != b);
        }
        let Some(worst) = (0..count.len()).rev().max_by_key(|f| count[*f]).map(|f| f as u32) else { break };
        pairs.retain(|p| !p.contains(&worst));
        out.push(worst);
    }
    out.sort_unstable();
    Ok(out)
}

/// Has triangles stay that are nearer to the boxes around bad ones than so many of their longest edges. Returns whether there are more of them now,
/// and not too many.
pub(super) fn stay_around(stays: &mut [bool], bad: &[Aabb], part: &TriMesh, reach: f64) -> bool {
    /// Where more than one triangle in this many would stay it is no matter of places.
    const MOST: usize = 10;
    let tree = Bvh::new(bad.iter().map(|b| b.grown(reach * b.diagonal())).collect());
    let mut more = false;
    for (t, stay) in stays.iter_mut().enumerate().filter(|s| !*s.1) {
        *stay = tree.meets(&Aabb::around(part.corners(t)));
        more |= *stay;
    }
    more && MOST * stays.iter().filter(|s| **s).count() <= stays.len()
}
