//! Remeshing what was joined: shorter edges around triangles at fault, and in the end triangles that stay there as they were joined.

use super::super::cells::{KEPT, LEAST_BESIDE, ROOM};
use super::super::history::{Attempt, Tried};
use super::super::ladder::{Attempts, Change, Ladder, Seen};
use super::joint::Joint;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::optimize::exact::{ExactMesh, ExactOptions, Patchwork, remesh_patches, remesh_patchwork};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// How often edges are halved around triangles that cross others or are turned over.
const HALVINGS: usize = 4;
/// They do not get shorter than this share of the size.
const LEAST: f64 = 1.0 / 64.0;
/// Edges this many times as long as a fault's box around it are halved.
const AROUND: f64 = 1.0;

/// What is remeshed, and how.
pub(super) struct Remeshing<'a> {
    pub(super) names: &'a TriMesh,
    pub(super) joint: &'a Joint<'a>,
    pub(super) exact: &'a ExactOptions,
    pub(super) size: f64,
    pub(super) work: Patchwork,
    /// Whether narrow faces and bends of borders are heeded.
    narrow: bool,
    halved: usize,
    /// Where triangles stay as they were joined, and how often such places were added.
    kept: Vec<Aabb>,
    times_kept: usize,
}

impl<'a> Remeshing<'a> {
    pub(super) fn new(
        names: &'a TriMesh,
        joint: &'a Joint<'a>,
        exact: &'a ExactOptions,
        size: f64,
        work: Patchwork,
    ) -> Self {
        Self { names, joint, exact, size, work, narrow: true, halved: 0, kept: Vec::new(), times_kept: 0 }
    }

    /// What is remeshed, with triangles that stay where they are kept: none of them cross, as they were joined exactly.
    fn with_kept(&self) -> Patchwork {
        let mut work = self.work.clone();
        work.freeze_near(&self.kept, LEAST_BESIDE * self.size);
        work
    }

    /// Halves what nodes near some boxes want; whether that changed anything.
    fn halve(&mut self, places: &[Aabb]) -> bool {
        let work = &mut self.work;
        let around = |b: &Aabb| b.grown(AROUND * b.diagonal());
        let tree = Bvh::new(places.iter().map(around).collect());
        // Each node once, however many triangles around it are near.
        let is_near = |t: &u32| tree.meets(&Aabb::around(work.mesh.corner_points(*t)));
        let mut near: Vec<u32> = work.mesh.triangles().filter(is_near).flat_map(|t| work.mesh.corners(t)).collect();
        near.sort_unstable();
        near.dedup();
        let (least, mut any) = (LEAST * self.size, false);
        for v in near {
            let Some(s) = work.sizes.get_mut(v as usize) else { continue };
            let now = s.min(self.size);
            let half = (0.5 * now).max(least);
            any |= half < now;
            *s = half;
        }
        any
    }
}

/// How many triangles of a mesh are at fault.
fn faults(made: &ExactMesh) -> usize {
    made.report.self_intersections + made.report.inverted
}

impl Ladder for Remeshing<'_> {
    /// With the number of the attempt.
    type Made = (ExactMesh, usize);

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Self::Made>> {
        let Self { names, joint, exact, .. } = *self;
        let made = if self.narrow {
            remesh_patches(names, self.with_kept(), joint, exact, run, None)?
        } else {
            remesh_patchwork(self.with_kept(), names, joint, exact, run, None)?
        };
        let attempt = Attempt::new(Tried::Joined, self.size, made.mesh.triangles.len(), faults(&made));
        let number = attempts.add(attempt, run);
        Ok(Some((made, number)))
    }

    fn is_better(&self, new: &Self::Made, best: Option<&Self::Made>) -> bool {
        best.is_none_or(|b| faults(&new.0) < faults(&b.0))
    }

    fn next(&mut self, seen: &Seen<'_, Self::Made>) -> Option<(Change, &'static str)> {
        const WHY: &str = "triangles are at fault";
        let last = &seen.last.0;
        if faults(last) == 0 {
            return None;
        }
        // Where surfaces touch faces narrow without end, and so short edges meet there that their triangles cross.
        if std::mem::take(&mut self.narrow) {
            return Some((Change::OtherWay, WHY));
        }
        // Shorter edges part the chords of walls thinner than these are high. Where they leave as much at fault, surfaces touch.
        let helps = self.halved == 0 || seen.improved;
        self.halved += 1;
        if self.times_kept == 0 && helps && self.halved <= HALVINGS && self.halve(&last.report.faults) {
            return Some((Change::ShorterEdgesHere, WHY));
        }
        self.times_kept += 1;
        let far = self.times_kept as f64 * ROOM;
        self.kept.extend(last.report.faults.iter().map(|b| b.grown(far * b.diagonal())));
        (self.times_kept <= KEPT).then_some((Change::KeepHere, WHY))
    }
}
