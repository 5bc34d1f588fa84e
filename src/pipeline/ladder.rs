//! The ladder that every gate goes up where a mesh falls short: one loop, with a list of what was tried and a bound on what it costs.

use std::fmt;

use serde::Serialize;

use super::history::{Attempt, AttemptStage, Clock};
use super::mesh::Meshed;
use super::report::Report;
use crate::error::Result;
use crate::run::Run;

/// All attempts together make at most so many times the triangles of the largest one: what a part costs follows from its mesh. Of the parts
/// and random trees that come out none takes more than 3.2 times those of the first one (a tree of 50 leaves with fillets).
const MOST_MESHES: usize = 8;
/// Attempts at coarser meshes cost little: the bound is never below that many triangles for the largest one.
const CHEAP: usize = 20_000;

/// What an attempt changed after the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Nothing: it is the first one.
    #[default]
    First,
    /// Cells are smaller around places.
    SmallerCellsHere,
    /// Cells are smaller everywhere.
    SmallerCells,
    /// Edges are shorter around places.
    ShorterEdgesHere,
    /// Edges are shorter everywhere.
    ShorterEdges,
    /// Edges are longer everywhere.
    LongerEdges,
    /// Triangles of the input, or of the first triangulation, stay around places.
    KeepHere,
    /// Whole faces or connected parts stay as they were.
    KeepParts,
    /// Another way is taken.
    OtherWay,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Change::First => "first",
            Change::SmallerCellsHere => "smaller cells here",
            Change::SmallerCells => "smaller cells",
            Change::ShorterEdgesHere => "shorter edges here",
            Change::ShorterEdges => "shorter edges",
            Change::LongerEdges => "longer edges",
            Change::KeepHere => "kept here",
            Change::KeepParts => "kept in parts",
            Change::OtherWay => "another way",
        })
    }
}

/// What is tried for a mesh, one change after the other. A gate says which changes it knows and when they are worth it.
pub(super) trait Ladder {
    /// What an attempt gives.
    type Made;

    /// Makes a mesh as things stand, and adds itself to the attempts. `None` where nothing is left to try.
    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Self::Made>>;

    /// Whether a mesh takes the place of the best one.
    fn is_better(&self, new: &Self::Made, best: Option<&Self::Made>) -> bool;

    /// Prepares the next attempt, with the reason for it; `None` where the best is good enough, or nothing would help.
    fn next(&mut self, seen: &LadderState<'_, Self::Made>) -> Option<(Change, &'static str)>;
}

/// What there is after an attempt.
pub(super) struct LadderState<'a, M> {
    /// The last attempt's mesh.
    pub(super) last: &'a M,
    /// The best one's, which may be the same.
    pub(super) best: Option<&'a M>,
    /// Whether it is the same.
    pub(super) improved: bool,
}

/// Goes up a ladder until there is nothing left to change, or no budget; the best mesh, if there is one.
///
/// Errors: those of attempts.
pub(super) fn climb<L: Ladder>(ladder: &mut L, attempts: &mut Attempts, run: &Run) -> Result<Option<L::Made>> {
    let mut best: Option<L::Made> = None;
    while let Some(made) = ladder.attempt(attempts, run)? {
        let improved = ladder.is_better(&made, best.as_ref());
        let next = if improved {
            best = Some(made);
            best.as_ref().and_then(|b| ladder.next(&LadderState { last: b, best: Some(b), improved }))
        } else {
            ladder.next(&LadderState { last: &made, best: best.as_ref(), improved })
        };
        let Some((change, because)) = next else { break };
        if !attempts.may_go_on() {
            break;
        }
        attempts.change(change, because);
    }
    Ok(best)
}

/// What attempts may cost, and did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Budget {
    /// Triangles that were made in all attempts.
    pub spent: usize,
    /// No attempt is made after that many; nothing before the first one.
    pub most: usize,
    /// Whether that ended the search.
    pub ended: bool,
}

/// What was tried on the way to a mesh.
pub(super) struct Attempts {
    list: Vec<Attempt>,
    clock: Clock,
    change: Change,
    because: &'static str,
    budget: Budget,
    /// The triangles of the largest attempt, from which the budget follows,
    largest: usize,
    /// and those that were made for operands.
    others: usize,
}

impl Attempts {
    pub(super) fn new(timed: bool) -> Self {
        let (list, change) = (Vec::new(), Change::First);
        Self { list, clock: Clock::new(timed), change, because: "", budget: Budget::default(), largest: 0, others: 0 }
    }

    /// Says what the next attempt is made for.
    pub(super) fn change(&mut self, change: Change, because: &'static str) {
        (self.change, self.because) = (change, because);
    }

    /// Adds an attempt, and tells whoever listens: a run that is stopped later tells what it tried. Gives its number.
    pub(super) fn add(&mut self, attempt: Attempt, run: &Run) -> usize {
        let seconds = self.clock.lap();
        let stages = run.stage_seconds().into_iter().map(|s| AttemptStage { name: s.name, seconds: s.seconds });
        let (change, because) = (self.change, self.because);
        let attempt = Attempt { change, because, seconds, stages: stages.collect(), ..attempt };
        run.note("attempt", || attempt.ended());
        self.budget.spent += attempt.triangles;
        self.largest = self.largest.max(attempt.triangles).max(CHEAP);
        self.budget.most = self.others + MOST_MESHES * self.largest;
        self.list.push(attempt);
        self.list.len() - 1
    }

    /// Puts those at something that the mesh is made from before its own, for which the budget is another one.
    pub(super) fn append(&mut self, other: Attempts) {
        self.list.extend(other.list.into_iter().map(|a| a.lacking("an operand")));
        self.budget.spent += other.budget.spent;
        self.others += other.budget.spent;
        self.budget.most = self.others + MOST_MESHES * self.largest;
    }

    /// Whether the budget allows another attempt.
    fn may_go_on(&mut self) -> bool {
        let can = self.budget.spent < self.budget.most;
        self.budget.ended |= !can;
        can
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether any after the first so many had triangles at fault.
    pub(super) fn any_fault_since(&self, first: usize) -> bool {
        self.list.iter().skip(first).any(|a| a.faults > 0)
    }

    /// The smallest cells, or shortest edges, of those after the first so many.
    pub(super) fn smallest_since(&self, first: usize) -> f64 {
        self.list.iter().skip(first).map(|a| a.size).fold(f64::INFINITY, f64::min)
    }

    /// Puts itself into a report; the mesh is made of the attempts of some numbers.
    pub(super) fn tell(self, kept: &[usize], report: &mut Report) {
        let mut list = self.list;
        for (i, a) in list.iter_mut().enumerate() {
            a.kept = kept.contains(&i);
            if !a.kept && a.why.is_empty() {
                a.why = "another one is better".into();
            }
        }
        report.attempts = list;
        report.budget = Some(self.budget);
        if self.budget.ended {
            let most = self.budget.most;
            report.warnings.push(format!("no further attempts: they would make more than {most} triangles"));
        }
    }
}

/// A mesh with the numbers of the attempts it is made of.
pub(super) struct MeshAttempt {
    pub(super) meshed: Meshed,
    pub(super) numbers: Vec<usize>,
}

impl MeshAttempt {
    /// In how many ways it falls short.
    pub(super) fn lacks(&self) -> usize {
        self.meshed.report.shortfalls.len()
    }

    /// The mesh with all attempts in its report.
    pub(super) fn told(mut self, attempts: Attempts) -> Meshed {
        attempts.tell(&self.numbers, &mut self.meshed.report);
        self.meshed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Tried;

    /// Meshes with some numbers of faults and triangles, one after the other.
    struct Given(Vec<[usize; 2]>, usize);

    impl Ladder for Given {
        type Made = [usize; 2];

        fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<[usize; 2]>> {
            let Some(made) = self.0.get(self.1).copied() else { return Ok(None) };
            self.1 += 1;
            attempts.add(Attempt::new(Tried::Arrange, 1.0, made[1], made[0]), run);
            Ok(Some(made))
        }

        fn is_better(&self, new: &[usize; 2], best: Option<&[usize; 2]>) -> bool {
            best.is_none_or(|b| new[0] < b[0])
        }

        fn next(&mut self, seen: &LadderState<'_, [usize; 2]>) -> Option<(Change, &'static str)> {
            (seen.best?[0] > 0).then_some((Change::SmallerCells, "at fault"))
        }
    }

    fn tried(faults: &[[usize; 2]]) -> (Option<[usize; 2]>, Attempts) {
        let (run, mut attempts) = (Run::new(), Attempts::new(false));
        let best = climb(&mut Given(faults.to_vec(), 0), &mut attempts, &run).unwrap();
        (best, attempts)
    }

    #[test]
    fn the_best_is_kept_and_what_is_good_ends_the_climb() {
        let (best, attempts) = tried(&[[5, 10], [7, 20], [0, 30], [0, 40]]);
        assert_eq!((best, attempts.len(), attempts.budget.ended), (Some([0, 30]), 3, false));
        let changes: Vec<Change> = attempts.list.iter().map(|a| a.change).collect();
        assert_eq!(changes, [Change::First, Change::SmallerCells, Change::SmallerCells]);
        let (best, attempts) = tried(&[[5, 10], [3, 20], [4, 30]]);
        assert_eq!((best, attempts.len()), (Some([3, 20]), 3));
    }

    #[test]
    fn no_attempt_is_made_after_the_budget_is_spent() {
        // One more each time than the largest, which is the last: nine make more than eight times its triangles.
        let alike: Vec<[usize; 2]> = (0..12).map(|k| [12 - k, CHEAP + k]).collect();
        let (best, attempts) = tried(&alike);
        assert_eq!((best, attempts.len(), attempts.budget.ended), (Some([4, CHEAP + 8]), 9, true));
        let mut report = Report::of("leaf", 1.0, None);
        attempts.tell(&[8], &mut report);
        assert_eq!(report.attempts.iter().position(|a| a.kept), Some(8));
        assert_eq!(report.warnings.len(), 1);
    }
}
