//! What is tried for a soup: shorter edges where its mesh crosses itself or is folded, then triangles of the input stay there.

use super::faults::{Places, Touching, keep_shells};
use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change, Ladder, LadderState};
use super::soup_patches::patchwork;
use crate::discrete::Discrete;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::remesh::{RemeshOptions, RemeshTarget, RemeshedMesh, remesh_patchwork};
use crate::run::Run;

/// A mesh farther from the surface is not taken if it is folded or more than one triangle in this many is slim within a face.
const SLIM: usize = 500;
/// How often edges are halved around places where the result intersects itself, or is turned over.
pub(super) const HALVINGS: usize = 4;
/// Up to this attempt triangles of the input are kept around them instead, farther around with each.
const ATTEMPTS: usize = 7;
/// The attempt that keeps all connected parts with such places as they are.
const LAST: usize = ATTEMPTS + 1;
/// How often they are halved around folds and slim triangles alone.
const FOLDED: usize = 2;
/// Where more than one triangle in this many intersects others it is no matter of sizes. Thin parts of coarse meshes may well be a
/// tenth of all.
const FEW: usize = 3;

/// A remeshed soup.
pub(super) struct SoupTrial {
    pub(super) made: RemeshedMesh,
    /// Triangles that cross others for which healing is not to blame.
    bad: Vec<u32>,
    /// The number of its attempt.
    pub(super) number: usize,
}

impl SoupTrial {
    /// How many of its triangles are turned over, or slim within a face.
    pub(super) fn flaws(&self) -> usize {
        self.made.report.inverted + self.made.report.slim.len()
    }

    /// Whether it is too poor for one that may be farther from the surface than else.
    fn is_poor(&self) -> bool {
        self.made.report.inverted > 0 || SLIM * self.made.report.slim.len() > self.made.mesh.triangles.len()
    }
}

/// Why a soup's ladder ended.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum LadderEnd {
    /// With its best.
    Best,
    /// Edges may be farther from the surface than else, and that made it cross itself,
    Strict,
    /// or left it poor.
    StrictIfBetter,
    /// It crosses itself whatever is kept.
    Left,
}

/// A soup with what is wanted of its edges.
pub(super) struct SoupLadder<'a> {
    pub(super) solid: &'a Discrete,
    pub(super) named: &'a TriMesh,
    pub(super) exact: &'a RemeshOptions,
    pub(super) touching: &'a Touching,
    /// How long edges at nodes are to be,
    pub(super) sizes: Vec<f64>,
    /// and how short they may get around places that are kept.
    pub(super) least: f64,
    /// Triangles that stay.
    pub(super) kept: Vec<bool>,
    /// Whether edges are as near to the surface as they ever are.
    pub(super) near: bool,
    pub(super) size: f64,
    /// How far up it is.
    pub(super) level: usize,
    pub(super) end: LadderEnd,
}

impl<'a> SoupLadder<'a> {
    /// Of triangles that all may move, with no wish for edges but the size.
    pub(super) fn new(
        solid: &'a Discrete,
        named: &'a TriMesh,
        exact: &'a RemeshOptions,
        touching: &'a Touching,
        size: f64,
    ) -> Self {
        let level = if touching.is_empty() { 0 } else { ATTEMPTS };
        Self {
            solid,
            named,
            exact,
            touching,
            sizes: Vec::new(),
            least: 0.0,
            kept: Vec::new(),
            near: true,
            size,
            level,
            end: LadderEnd::Best,
        }
    }

    /// Changes what one level asks for around places at fault; whether that is a change.
    fn change(&mut self, last: &SoupTrial) -> Option<Change> {
        // Nothing is kept for the sake of folds.
        let mut folds = Vec::new();
        let report = &last.made.report;
        if self.level < HALVINGS {
            folds.extend_from_slice(&report.faults[report.self_intersections..]);
            folds.extend_from_slice(&report.slim);
        }
        let reach = if self.level < HALVINGS { 0.5 } else { (self.level + 1 - HALVINGS) as f64 };
        let places = Places::new(&last.bad, &folds, &last.made.mesh, reach);
        self.level += 1;
        if self.level <= HALVINGS {
            let is_shorter = places.halve(&mut self.sizes, self.solid, self.least);
            return is_shorter.then_some(Change::ShorterEdgesHere);
        }
        let more = places.keep(&mut self.kept, self.solid);
        if self.level == LAST {
            keep_shells(&mut self.kept, self.solid);
            return Some(Change::KeepParts);
        }
        more.then_some(Change::KeepHere)
    }
}

impl Ladder for SoupLadder<'_> {
    type Made = SoupTrial;

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<SoupTrial>> {
        if self.kept.iter().all(|k| *k) {
            return Ok(None);
        }
        let work = patchwork(self.solid, self.sizes.clone(), &self.kept, self.least);
        let target = RemeshTarget { surface: self.solid, names: self.named };
        let made = remesh_patchwork(work, target, self.exact, run, None)?;
        let bad = match made.report.self_intersections {
            0 => Vec::new(),
            _ => self.touching.others(&made.mesh, run)?,
        };
        let flawed = bad.len() + made.report.inverted;
        let attempt = Attempt::new(Tried::Soup, self.size, made.mesh.triangles.len(), flawed);
        let number = attempts.add(attempt, run);
        Ok(Some(SoupTrial { made, bad, number }))
    }

    /// Only what does not cross itself counts, though it may be folded.
    fn is_better(&self, new: &SoupTrial, best: Option<&SoupTrial>) -> bool {
        new.bad.is_empty() && best.is_none_or(|b| new.flaws() < b.flaws())
    }

    fn next(&mut self, seen: &LadderState<'_, SoupTrial>) -> Option<(Change, &'static str)> {
        let last = seen.last;
        let crosses = !last.bad.is_empty();
        if FEW * last.bad.len() > last.made.mesh.triangles.len() {
            self.level = self.level.max(HALVINGS);
        }
        // Nearer to the surface there may be no need for more.
        if crosses && !self.near {
            self.end = LadderEnd::Strict;
            return None;
        }
        if crosses && seen.best.is_some() {
            return None;
        }
        while self.level <= LAST {
            if !crosses && (self.level >= FOLDED || !last.is_poor()) {
                if last.is_poor() && !self.near {
                    self.end = LadderEnd::StrictIfBetter;
                }
                return None;
            }
            if let Some(change) = self.change(last).filter(|_| self.level <= LAST) {
                return Some((change, if crosses { "triangles cross" } else { "triangles are folded or slim" }));
            }
        }
        self.end = LadderEnd::Left;
        None
    }
}
