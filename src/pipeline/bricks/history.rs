//! What a mesh of bricks went through: its rounds, the merge and the check, as stages of one attempt.

use super::super::history::{Attempt, Clock, Stage};
use super::super::ladder::Attempts;
use super::super::report::Report;
use super::ROUNDS;
use crate::run::Run;

/// What the stages of the rounds are called.
const NAMES: [&str; ROUNDS] = ["round 1", "round 2", "round 3"];

/// The one attempt there is, with its stages.
pub(super) struct History {
    attempts: Attempts,
    clock: Clock,
    stages: Vec<Stage>,
    /// Triangles that stay, of all rounds that have ended.
    stay: usize,
}

impl History {
    /// One that begins; with seconds, if these are asked for.
    pub(super) fn new(timed: bool) -> Self {
        Self { attempts: Attempts::new(timed), clock: Clock::new(timed), stages: Vec::new(), stay: 0 }
    }

    /// A round has ended, with so many triangles of its own that stay.
    pub(super) fn round(&mut self, number: usize, triangles: usize, run: &Run) {
        self.stay += triangles;
        if let Some(name) = NAMES.get(number) {
            self.stage(name, self.stay, run);
        }
    }

    /// A stage has ended, with so many triangles.
    pub(super) fn stage(&mut self, name: &'static str, triangles: usize, run: &Run) {
        let stage = Stage { name, triangles, seconds: self.clock.lap() };
        run.note("stage", || stage.to_string());
        self.stages.push(stage);
    }

    /// Puts itself into a report.
    pub(super) fn tell(mut self, attempt: Attempt, report: &mut Report, run: &Run) {
        let number = self.attempts.add(attempt, run);
        self.attempts.tell(&[number], report);
        report.stages = self.stages;
    }
}
