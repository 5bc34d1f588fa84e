//! What is wrong with a boundary representation, told by body and by names of faces.

use std::fmt;

use serde::Serialize;

use super::brep_info::short;
use crate::error::Result;
use crate::numeric::{ROUNDING, SEVEN_DIGITS};
use crate::parametric::audit::{BodyAudit, Flaw, FlawKind, audit};
use crate::parametric::brep::Brep;
use crate::parametric::step::StepModel;
use crate::run::Run;
use crate::spatial::Aabb;

/// Faults of one kind and body the text lists.
pub(super) const LISTED: usize = 8;

/// One thing that is wrong with a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelFault {
    /// What.
    pub kind: FlawKind,
    /// The body's name.
    pub body: String,
    /// Names of the faces it is about.
    pub faces: Vec<String>,
    /// What made the edge, or the face: in a STEP file the number of its record.
    pub source: u64,
    /// Where.
    pub at: [f64; 3],
    /// How far apart, how long or how wide, in the model's unit; none where there is no such number.
    pub length: Option<f64>,
}

/// What was found of one body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodyDiagnosis {
    /// Its name.
    pub name: String,
    /// Whether it is said to be a solid.
    pub solid: bool,
    /// Whether every edge has a face on both sides, and no more than two.
    pub closed: bool,
    /// How many faces it has.
    pub faces: usize,
    /// How many edges.
    pub edges: usize,
    /// Edges with a face on one side only.
    pub open_edges: usize,
    /// Edges where more than two faces meet.
    pub crowded_edges: usize,
    /// The largest distance from a vertex to the end of a curve.
    pub vertex_gap: f64,
    /// The largest distance from an edge's curve to the surface of one of its faces.
    pub curve_gap: f64,
    /// How many faults it has.
    pub faults: usize,
}

/// What is wrong with a boundary representation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BrepDiagnosis {
    /// Whether nothing is.
    pub sound: bool,
    /// Distances up to this count as none, in the model's unit.
    pub tolerance: f64,
    /// Whether the model names this tolerance itself; else it follows from its size.
    pub own_tolerance: bool,
    /// The bodies.
    pub bodies: Vec<BodyDiagnosis>,
    /// What is wrong with them, by body and kind.
    pub faults: Vec<ModelFault>,
    /// What the file has that was not understood, or had to be put right.
    pub notes: Vec<String>,
}

/// Looks at a model read from a STEP file, in millimeters, for what is wrong with it: open edges of solids, edges of more than two
/// faces, faces that are turned, vertices off curves, curves off faces, faces without borders, borders that cross, short edges and
/// slivers. The file's own tolerance decides what is apart.
///
/// *Guarantees*: all edges with too few or too many faces are found; the same result for any number of threads.
/// *Does not guarantee*: distances between the places looked at, eight on each smooth piece of an edge; borders that touch without
/// crossing; solids that are inside out as a whole or pass through each other.
/// *Errors*: [`Error::Input`](crate::Error::Input) where numbers of edges or faces are out of range; cancellation.
pub fn diagnose_step(model: &StepModel, run: &Run) -> Result<BrepDiagnosis> {
    let mut found = diagnose_brep(&model.brep, model.tolerance, run)?;
    found.notes = model.notes.iter().map(ToString::to_string).collect();
    found.sound &= found.notes.is_empty();
    Ok(found)
}

/// The same of any boundary representation, in its own unit. Without a tolerance it is a millionth of the model's size.
///
/// *Guarantees* and *errors*: see [`diagnose_step`].
pub fn diagnose_brep(brep: &Brep, tolerance: Option<f64>, run: &Run) -> Result<BrepDiagnosis> {
    let size = size(brep);
    let own = tolerance.filter(|t| *t >= 0.0 && t.is_finite());
    // No tolerance is smaller: rounding of coordinates is no fault.
    let tolerance = own.unwrap_or(SEVEN_DIGITS * size).max(ROUNDING * size);
    let found = audit(brep, tolerance, run)?;
    let faults: Vec<ModelFault> = found.flaws.iter().map(|f| named(brep, f)).collect();
    let body = |(b, told): (usize, &BodyAudit)| {
        let body = &brep.bodies[b];
        BodyDiagnosis {
            name: body.name.clone(),
            solid: body.solid,
            closed: told.open == 0 && told.crowded == 0,
            faces: body.faces.len(),
            edges: told.edges,
            open_edges: told.open,
            crowded_edges: told.crowded,
            vertex_gap: told.vertex_gap,
            curve_gap: told.curve_gap,
            faults: found.flaws.iter().filter(|f| f.body as usize == b).count(),
        }
    };
    Ok(BrepDiagnosis {
        sound: faults.is_empty(),
        tolerance,
        own_tolerance: own.is_some_and(|t| t == tolerance),
        bodies: found.bodies.iter().enumerate().map(body).collect(),
        faults,
        notes: Vec::new(),
    })
}

/// The diagonal of the box around everything with a place.
fn size(brep: &Brep) -> f64 {
    let points = brep.edges.iter().flat_map(|e| e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t)));
    let size = Aabb::around(brep.vertices.iter().copied().chain(points)).diagonal();
    if size.is_finite() { size } else { 0.0 }
}

fn named(brep: &Brep, f: &Flaw) -> ModelFault {
    let face = |i: &u32| &brep.faces[*i as usize];
    let of_face = || f.faces.first().map_or(0, |i| face(i).source);
    ModelFault {
        kind: f.kind,
        body: brep.bodies[f.body as usize].name.clone(),
        faces: f.faces.iter().map(|i| face(i).name.clone()).collect(),
        source: f.edge.map_or_else(of_face, |e| brep.edges[e as usize].source),
        at: f.at.to_array(),
        length: f.length,
    }
}

impl fmt::Display for ModelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            FlawKind::OpenEdge => "edge with a face on one side only",
            FlawKind::CrowdedEdge => "edge with more than two faces",
            FlawKind::TurnedFace => "both faces run along the edge the same way: one is turned",
            FlawKind::VertexOffCurve => "vertex off its curve",
            FlawKind::CurveOffFace => "curve of an edge off the face",
            FlawKind::NoBorder => "face without a border on a surface that does not close",
            FlawKind::CrossingBorders => "borders of the face cross",
            FlawKind::ShortEdge => "edge too short",
            FlawKind::Sliver => "face too narrow",
        };
        let [x, y, z] = self.at.map(short);
        write!(f, "{what}")?;
        match (self.kind, self.length) {
            (FlawKind::ShortEdge, Some(l)) => write!(f, ", {} long", short(l))?,
            (FlawKind::Sliver, Some(l)) => write!(f, ", {} wide", short(l))?,
            (_, Some(l)) => write!(f, " by {}", short(l))?,
            (_, None) => {}
        }
        write!(f, ", at ({x}, {y}, {z}), #{}, face {}", self.source, self.faces.join(" and "))
    }
}

impl fmt::Display for BrepDiagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whose = if self.own_tolerance { "the model's own" } else { "from its size" };
        writeln!(f, "sound {}, tolerance {} ({whose})", if self.sound { "yes" } else { "NO" }, short(self.tolerance))?;
        let mut rest = &self.faults[..];
        for b in &self.bodies {
            let kind = if b.solid { "solid" } else { "sheet" };
            let closed = if b.closed { "closed" } else { "not closed" };
            write!(f, "body {}: {kind} of {} faces and {} edges, {closed}", b.name, b.faces, b.edges)?;
            if !b.closed {
                write!(f, " ({} open edges, {} with more than two faces)", b.open_edges, b.crowded_edges)?;
            }
            writeln!(f)?;
            writeln!(
                f,
                "  farthest: vertex from curve {}, curve from face {}",
                short(b.vertex_gap),
                short(b.curve_gap)
            )?;
            let (own, others) = rest.split_at(b.faults.min(rest.len()));
            rest = others;
            for alike in own.chunk_by(|x, y| x.kind == y.kind) {
                for fault in alike.iter().take(LISTED) {
                    writeln!(f, "  fault: {fault}")?;
                }
                if alike.len() > LISTED {
                    writeln!(f, "  fault: {} more of this kind", alike.len() - LISTED)?;
                }
            }
        }
        for n in &self.notes {
            writeln!(f, "fault in the file: {n}")?;
        }
        Ok(())
    }
}
