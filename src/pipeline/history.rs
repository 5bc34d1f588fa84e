//! What was tried on the way to a mesh, with what came of it, and the stages of the mesh that was kept.

use std::fmt;
use std::time::Instant;

use serde::Serialize;

use super::bodies::NAMED;
use super::ladder::Change;
use super::report::Report;
use crate::implicit::{Arranged, OpenCell, Unproved};
use crate::run::Run;

/// What an attempt did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tried {
    /// The boundary of the leaves' arrangement on an adaptive grid, remeshed.
    Arrange,
    /// Marching cubes with a sequence of operators.
    Operators,
    /// Marching cubes alone.
    MarchingCubes,
    /// Faces of a boundary representation triangulated for the first time.
    Faces,
    /// Bodies of a boundary representation remeshed.
    Bodies,
    /// A soup remeshed.
    Soup,
    /// Operands of set operations joined, and remeshed between their exact borders.
    Joined,
}

/// What intervals showed of the arrangement of a part's leaves.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Proof {
    /// Cells of the grid that hold some of the surface.
    pub cells: usize,
    /// In how many of these the leaves are not shown to be arranged as planes are.
    pub unproved: usize,
    /// The centers of the first ones, with the reason.
    pub places: Vec<UnprovedPlace>,
    /// Nodes that were not put on their surfaces, edges and corners before remeshing, as these do not pass nearby.
    pub astray: usize,
    /// Of a mesh of bricks, those that hold cells not proved, in the order of their numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bricks: Vec<UnprovedBrick>,
}

/// What was not proved in one brick of the first round.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnprovedBrick {
    /// The number of the brick.
    pub brick: u32,
    /// Its cells that hold some of the surface.
    pub cells: usize,
    /// In how many of these the leaves are not shown to be arranged as planes are.
    pub unproved: usize,
    /// The first of these.
    pub first: UnprovedPlace,
}

/// A place where the arrangement of leaves was not proved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnprovedPlace {
    /// Where.
    pub at: [f64; 3],
    /// Why not.
    pub reason: Unproved,
}

impl Proof {
    pub(super) fn of(made: &Arranged) -> Self {
        let Arranged { cells, unproved, astray, .. } = made;
        let place = |c: &OpenCell| UnprovedPlace { at: c.cell.center().to_array(), reason: c.reason };
        let places = unproved.iter().take(NAMED).map(place).collect();
        Self { cells: *cells, unproved: unproved.len(), places, astray: astray.len(), bricks: Vec::new() }
    }

    /// Adds what was shown in a brick.
    pub(super) fn add(&mut self, other: &Self, brick: u32) {
        let named = |first: &UnprovedPlace| UnprovedBrick {
            brick,
            cells: other.cells,
            unproved: other.unproved,
            first: *first,
        };
        self.bricks.extend(other.places.first().map(named));
        self.cells += other.cells;
        self.unproved += other.unproved;
        self.astray += other.astray;
        self.places.extend_from_slice(&other.places);
        self.places.truncate(NAMED);
    }
}

/// One attempt at a mesh, in the order of time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attempt {
    /// What was done.
    pub rung: Tried,
    /// What it changed after the one before it,
    pub change: Change,
    /// and what that was wanting in.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub because: &'static str,
    /// The size of the cells, or the length of edges that was asked for.
    pub size: f64,
    /// How many triangles came of it.
    pub triangles: usize,
    /// How many triangles were at fault: they intersect others or are turned over.
    pub faults: usize,
    /// What was shown of the arrangement it was made from, if it was made from one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proof>,
    /// Whether the mesh is made of it.
    pub kept: bool,
    /// What was wrong with it, or why it was not kept; empty if nothing was.
    pub why: String,
    /// How long it took, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Which of its stages took how long, where that was asked for, in the order they began.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<AttemptStage>,
}

/// How long one stage of an attempt took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AttemptStage {
    /// Its name, as progress is told with: `signs`, `surface`, `cells`, `arrange`, `settle`, `remesh` and others.
    pub name: String,
    /// In seconds, of all times it was gone through.
    pub seconds: f64,
}

/// One stage on the way to the mesh that was kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// How many triangles there were after it.
    pub triangles: usize,
    /// How long it took, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// Measures seconds for those who ask; the others get none, and the same bytes every time.
pub(super) struct Clock(Option<Instant>);

impl Clock {
    pub(super) fn new(timed: bool) -> Self {
        Self(timed.then(Instant::now))
    }

    /// Seconds since the last lap, or the start.
    pub(super) fn lap(&mut self) -> Option<f64> {
        let start = self.0?;
        let now = Instant::now();
        self.0 = Some(now);
        Some(now.duration_since(start).as_secs_f64())
    }
}

impl Attempt {
    /// One that has triangles, of which so many are at fault.
    pub(super) fn new(rung: Tried, size: f64, triangles: usize, faults: usize) -> Self {
        Self {
            rung,
            change: Change::First,
            because: "",
            size,
            triangles,
            faults,
            proof: None,
            kept: false,
            why: String::new(),
            seconds: None,
            stages: Vec::new(),
        }
    }

    pub(super) fn lacking(self, why: impl Into<String>) -> Self {
        Self { why: why.into(), ..self }
    }
}

impl Report {
    pub(super) fn stage(&mut self, name: &'static str, triangles: usize, clock: &mut Clock, run: &Run) {
        let stage = Stage { name, triangles, seconds: clock.lap() };
        run.note("stage", || stage.to_string());
        self.stages.push(stage);
    }
}

fn seconds(f: &mut fmt::Formatter<'_>, seconds: Option<f64>) -> fmt::Result {
    seconds.map_or(Ok(()), |s| write!(f, ", {s:.2} s"))
}

impl Attempt {
    /// What it did, with how many triangles: what tells it from others.
    pub fn named(&self) -> String {
        let name = match self.rung {
            Tried::Arrange => "arrange",
            Tried::Operators => "operators",
            Tried::MarchingCubes => "mc",
            Tried::Faces => "faces",
            Tried::Bodies => "bodies",
            Tried::Soup => "soup",
            Tried::Joined => "joined",
        };
        format!("{name} at size {:.4e}: {} triangles", self.size, self.triangles)
    }

    /// The line about it when it has just ended: nobody knows yet whether it is kept.
    pub fn ended(&self) -> String {
        let figures = Figures(self);
        if self.why.is_empty() { figures.to_string() } else { format!("{figures}: {}", self.why) }
    }
}

/// An attempt without what came of it.
struct Figures<'a>(&'a Attempt);

impl fmt::Display for Figures<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Attempt { faults, proof, seconds: took, stages, .. } = self.0;
        f.write_str(&self.0.named())?;
        if !self.0.because.is_empty() {
            write!(f, " ({}: {})", self.0.change, self.0.because)?;
        }
        if *faults > 0 {
            write!(f, ", {faults} faults")?;
        }
        if let Some(p) = proof {
            write!(f, ", {} of {} cells not proved", p.unproved, p.cells)?;
            if let Some(first) = p.places.first() {
                write!(f, " (the first near {:.4?}: {})", first.at, first.reason)?;
            }
        }
        seconds(f, *took)?;
        let figures = stages.iter().map(|s| (&s.name, format!("{:.2}", s.seconds)));
        let told: Vec<String> = figures.filter(|f| f.1 != "0.00").map(|(name, s)| format!("{name} {s}")).collect();
        if told.is_empty() { Ok(()) } else { write!(f, " ({})", told.join(", ")) }
    }
}

impl fmt::Display for Attempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", Figures(self))?;
        f.write_str(if self.kept { ", kept" } else { ", not kept" })?;
        if self.why.is_empty() { Ok(()) } else { write!(f, ": {}", self.why) }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} triangles", self.name, self.triangles)?;
        seconds(f, self.seconds)
    }
}
