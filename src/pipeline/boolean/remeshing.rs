//! Remeshing what was joined, with shorter edges around triangles at fault.

use super::super::history::{Attempt, Tried};
use super::super::ladder::{Attempts, Change, Ladder, LadderState};
use super::joint::OperandPieces;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::pipeline::soup_ladder::HALVINGS;
use crate::remesh::{Patchwork, RemeshOptions, RemeshTarget, RemeshedMesh, remesh_patchwork};
use crate::run::Run;
use crate::spatial::Aabb;

/// They do not get shorter than this share of the size.
const LEAST: f64 = 1.0 / 64.0;
/// Edges this many times as long as a fault's box around it are halved.
const AROUND: f64 = 1.0;

/// What is remeshed, and how.
pub(super) struct Remeshing<'a> {
    names: &'a TriMesh,
    joint: &'a OperandPieces<'a>,
    exact: &'a RemeshOptions,
    size: f64,
    work: Patchwork,
    halved: usize,
}

impl<'a> Remeshing<'a> {
    pub(super) fn new(
        names: &'a TriMesh,
        joint: &'a OperandPieces<'a>,
        exact: &'a RemeshOptions,
        size: f64,
        work: Patchwork,
    ) -> Self {
        Self { names, joint, exact, size, work, halved: 0 }
    }
}

/// How many triangles of a mesh are at fault.
fn faults(made: &RemeshedMesh) -> usize {
    made.report.self_intersections + made.report.inverted
}

impl Ladder for Remeshing<'_> {
    /// With the number of the attempt.
    type Made = (RemeshedMesh, usize);

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Self::Made>> {
        let Self { names, joint, exact, .. } = *self;
        let target = RemeshTarget { surface: joint, names };
        let made = remesh_patchwork(self.work.clone(), target, exact, run, None)?;
        let attempt = Attempt::new(Tried::Joined, self.size, made.mesh.triangles.len(), faults(&made));
        let number = attempts.add(attempt, run);
        Ok(Some((made, number)))
    }

    fn is_better(&self, new: &Self::Made, best: Option<&Self::Made>) -> bool {
        best.is_none_or(|b| faults(&new.0) < faults(&b.0))
    }

    fn next(&mut self, seen: &LadderState<'_, Self::Made>) -> Option<(Change, &'static str)> {
        /// Why another attempt is made, for those who listen.
        const WHY: &str = "triangles are at fault";
        let last = &seen.last.0;
        if faults(last) == 0 {
            return None;
        }
        // Where surfaces touch faces narrow without end, and so short edges meet there that their triangles cross.
        if std::mem::take(&mut self.work.policy.narrow) {
            return Some((Change::OtherWay, WHY));
        }
        self.halved += 1;
        let around: Vec<Aabb> = last.report.faults.iter().map(|b| b.grown(AROUND * b.diagonal())).collect();
        let goes_on = self.halved <= HALVINGS && self.work.halve_near(&around, self.size, LEAST * self.size);
        goes_on.then_some((Change::ShorterEdgesHere, WHY))
    }
}
