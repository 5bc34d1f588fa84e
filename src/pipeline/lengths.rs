//! A mesh of a solid of R-functions whose edges' lengths, or whose cells, are not small enough: made anew with smaller ones.

use glam::DVec3;

use super::cells::{CellLadder, LOOSE, MOST_TRIANGLES, Start};
use super::ladder::{Attempts, Change, Ladder, LadderState};
use super::leaf::finer;
use super::mesh::{FoundMesh, Meshed, Ready, apart, mesh_by_cells};
use super::options::MeshOptions;
use crate::error::{Error, Result};
use crate::implicit::part::Part;
use crate::quality::Fault;
use crate::run::Run;
use crate::sizing::SizeRequest;

/// Where a mesh fell short for its edges' length: places that are known, perhaps none, with a length to try.
pub(super) type Crowded = Option<Vec<(DVec3, f64)>>;

/// A mesh this share of the size away from the surface, or [`LOOSE`] tolerances where that is more, may lack more than a chord
/// does.
const APART: f64 = 0.2;
/// How often edges are halved at the places that need it.
const HALVINGS: usize = 3;
/// As long as no more than this share of what is wanting before is left.
const LEFT: f64 = 0.5;
/// Where that does not do there are this many times as many edges to a length everywhere, unless that would give more than
/// [`MOST_TRIANGLES`].
const FINER: [f64; 2] = [2.0, 4.0];
/// How often a mesh is made anew for a distance. Chords are of edges: the middle of a triangle is a third farther away on a ball, and
/// edges come out of unequal lengths. Distances grow with the square of edges, so one time does on smooth parts.
const TIMES: usize = 3;
/// What is aimed at then: this share of the distance that would follow from what was measured.
const BELOW: f64 = 0.9;

/// How much a mesh lacks.
fn wanting(made: &Meshed) -> usize {
    let check = made.report.check.as_ref();
    let away = check.and_then(|c| c.deviation).map_or(0, |d| d.inverted + d.across);
    let short: usize = made.report.shortfalls.iter().map(Fault::weight).sum();
    short + away + check.map_or(0, |c| c.self_intersections)
}

/// What the last change is for.
#[derive(Clone, Copy)]
enum Aim {
    /// Nothing else is tried yet.
    First,
    /// Coming nearer to the surface by smaller cells, as where cells saw two bodies in a neck.
    Cells,
    /// Curved walls thinner than chords are high, so many times where they are thin.
    Here(usize),
    /// The same everywhere: by which of [`FINER`].
    Everywhere(usize),
    /// Coming as near to the surface as was asked for, so many times.
    Within(usize),
}

/// Meshes of a part with ever shorter edges where they fall short for that. Cells are taken over from the best one.
pub(super) struct LengthLadder<'a> {
    part: &'a Part,
    ready: Ready,
    options: &'a MeshOptions,
    /// What the next attempt is asked for.
    asked: MeshOptions,
    start: Start,
    aim: Aim,
    /// The smallest cells that any mesh was made with,
    finest: f64,
    /// whether smaller ones everywhere left no fewer triangles at fault,
    is_exhausted: bool,
    /// and the distance that edges are made for.
    distance: f64,
}

impl<'a> LengthLadder<'a> {
    pub(super) fn new(part: &'a Part, ready: Ready, options: &'a MeshOptions) -> Self {
        let (asked, start) = (options.clone(), Start::default());
        let distance = options.tolerance_length().unwrap_or(0.0);
        Self {
            part,
            ready,
            options,
            asked,
            start,
            aim: Aim::First,
            finest: f64::INFINITY,
            is_exhausted: false,
            distance,
        }
    }

    /// The part as it was meshed last.
    pub(super) fn ready(&self) -> &Ready {
        &self.ready
    }

    /// Smaller cells than any before, where the best mesh is far from the surface and each step has halved that.
    fn smaller_cells(&mut self, best: &FoundMesh, improved: bool) -> Option<(Change, &'static str)> {
        let near = (APART * self.ready.size).max(LOOSE * self.options.tolerance_length().unwrap_or(0.0));
        if !improved || self.is_exhausted || apart(&best.meshed) <= near {
            return None;
        }
        self.start = Start::below(self.finest, self.ready.size);
        (self.start.left() >= 2).then_some((Change::SmallerCells, "far from the surface"))
    }

    /// Shorter edges at the places where walls are thin.
    fn shorter_here(&mut self, best: &FoundMesh, times: usize) -> Option<(Change, &'static str)> {
        let places = best.crowded.as_ref().filter(|p| !p.is_empty() && times <= HALVINGS)?;
        self.ready.finer.extend(places);
        (self.aim, self.start) = (Aim::Here(times), best.start.clone());
        Some((Change::ShorterEdgesHere, "walls are thinner than chords are high there"))
    }

    /// Shorter edges everywhere.
    fn shorter(&mut self, best: &FoundMesh, which: usize) -> Option<(Change, &'static str)> {
        let times = *FINER.get(which)?;
        if best.meshed.mesh.triangles.len() as f64 * times * times > MOST_TRIANGLES {
            return None;
        }
        self.ready.finer.clear();
        (self.aim, self.start) = (Aim::Everywhere(which), best.start.clone());
        self.asked = finer(&self.ready, self.options, times);
        Some((Change::ShorterEdges, "walls are thinner than chords are high"))
    }

    /// Edges for a smaller distance, where the best mesh is farther from the surface than was asked for.
    fn nearer(&mut self, best: &FoundMesh, limit: f64, times: usize) -> Option<(Change, &'static str)> {
        let far = apart(&best.meshed);
        if far <= limit || times > TIMES {
            return None;
        }
        self.distance *= BELOW * limit / far;
        (self.aim, self.start) = (Aim::Within(times), best.start.clone());
        self.asked = MeshOptions { tolerance: Some(SizeRequest::Length(self.distance)), ..self.options.clone() };
        Some((Change::ShorterEdges, "farther from the surface than asked for"))
    }
}

impl Ladder for LengthLadder<'_> {
    type Made = FoundMesh;

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<FoundMesh>> {
        let cells = CellLadder::new(&self.ready, &self.asked, self.start.clone());
        let cells = if self.is_exhausted { cells.exhausted() } else { cells };
        let before = attempts.len();
        let made = mesh_by_cells(self.part, cells, attempts, run);
        self.finest = self.finest.min(attempts.smallest_since(before));
        let mut found = match made {
            Ok(found) => found,
            Err(e) if matches!(self.aim, Aim::First) => return Err(e),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // What there is stands.
            Err(_) => return Ok(None),
        };
        self.is_exhausted |= found.is_exhausted;
        let told = match self.aim {
            Aim::Here(_) => {
                Some(format!("curved walls are thin: edges are shorter at {} places", self.ready.finer.len()))
            }
            Aim::Everywhere(which) => {
                Some(format!("curved walls are thin: made with {} times as many edges to a length", FINER[which]))
            }
            _ => None,
        };
        found.meshed.report.warnings.extend(told);
        Ok(Some(found))
    }

    fn is_better(&self, new: &FoundMesh, best: Option<&FoundMesh>) -> bool {
        let Some(best) = best else { return true };
        let (now, then) = (wanting(&best.meshed), wanting(&new.meshed));
        let (far, near) = (apart(&best.meshed), apart(&new.meshed));
        let is_whole = new.meshed.report.shortfalls.is_empty();
        match self.aim {
            Aim::First => true,
            Aim::Cells => 2.0 * near < far && then <= now,
            Aim::Here(_) => is_whole && then as f64 <= LEFT * now as f64,
            Aim::Everywhere(_) => is_whole && (then == 0 || !best.meshed.report.shortfalls.is_empty()),
            Aim::Within(_) => near < far && then <= now,
        }
    }

    fn next(&mut self, seen: &LadderState<'_, FoundMesh>) -> Option<(Change, &'static str)> {
        let best = seen.best.filter(|_| self.options.method.is_exact())?;
        if matches!(self.aim, Aim::First | Aim::Cells) {
            self.aim = Aim::Cells;
            if let Some(change) = self.smaller_cells(best, seen.improved) {
                return Some(change);
            }
        }
        if let Some(limit) = self.options.tolerance_length() {
            let times = if let Aim::Within(times) = self.aim { times + 1 } else { 1 };
            return if times == 1 || seen.improved { self.nearer(best, limit, times) } else { None };
        }
        match self.aim {
            Aim::First | Aim::Cells | Aim::Here(_) => {
                best.crowded.as_ref()?;
                let times = if let Aim::Here(times) = self.aim { times + 1 } else { 1 };
                let here = if times == 1 || seen.improved { self.shorter_here(best, times) } else { None };
                here.or_else(|| self.shorter(best, 0))
            }
            Aim::Everywhere(which) => {
                let then = wanting(&seen.last.meshed);
                // Where it lacks nothing but this, walls are not what it lacks.
                let other = !seen.improved && best.meshed.report.shortfalls.is_empty() && then >= wanting(&best.meshed);
                if then == 0 || other { None } else { self.shorter(best, which + 1) }
            }
            Aim::Within(_) => None,
        }
    }
}

/// Says so where a mesh stayed farther from the surface than was asked for.
pub(super) fn tell_far(made: &mut Meshed, options: &MeshOptions) {
    let Some(limit) = options.tolerance_length().filter(|_| options.method.is_exact()) else { return };
    let distance = apart(made);
    if distance > limit && !made.report.shortfalls.iter().any(|f| matches!(f, Fault::Far { .. })) {
        made.report.shortfalls.push(Fault::Far { distance, limit, triangles: None });
    }
}
