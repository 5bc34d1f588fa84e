//! The one call that runs a sequence of operators, and what it tells of each.

use std::fmt;

use glam::DVec3;

use super::classify::{Classes, classify_by_curvature, classify_by_edges};
use super::crease::{CreaseReport, cut_creases, mark_sharp, settle_creases};
use super::density::{DEGENERATE_ANGLE, Edits, ShortEdges, collapse_short, densify, relax_worst, remove_degenerate};
use super::dual::snap_to_planes;
use super::flips::{flip_for_angles, flip_for_normals};
use super::grammar::Sequence;
use super::guard::{Moves, ask_all};
use super::normal::{DAMPING, align_normals};
use super::operator::Operator;
use super::sequences::cut_sequence;
use super::size::node_sizes;
use super::smooth::{ALONG, CreaseStep, smooth_all, smooth_edges, smooth_regular};
use super::surface::{NormalDeviation, forget, normal_deviation, project, survey};
use crate::error::{Error, Result};
use crate::geometry::SurfaceOracle;
use crate::mesh::{EditMesh, TriMesh, intersecting_triangles};
use crate::run::Run;
use crate::sizing::{SHORT, Sizing, TINY};

/// A flip for angles may not bend the surface by more than this (degrees) away from the true normals: on a surface
/// with eight nodes per radius two neighboring triangles already differ by this much.
const BEND: f64 = 10.0;
/// Nodes around triangles with a smaller angle than this (degrees) are relaxed one by one. Raising it moves more nodes and
/// slows the stage down without helping the worst: 35 is reached nearly everywhere, 40 is not.
const RELAX_ANGLE: f64 = 35.0;
/// Around a place that came out wrong nodes stay as they were within this many sizes, twice as far at each
const FREEZE: f64 = 1.5;
/// See [`Options::new`].
const NODES_PER_RADIUS: f64 = 9.0;
/// Without a smallest size asked for, curvature makes edges at most this many times shorter than the size.
const LEAST_SHARE: f64 = 16.0;

/// What the improvement aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Wanted edge length; about the cell size of the extraction.
    pub size: f64,
    /// Smallest angle between the normals of two faces, degrees, for which their border is a crease that the mesh must
    /// follow; 0 < angle < 180.
    pub feature_angle: f64,
    /// No edge longer than radius of curvature / this, where given.
    pub nodes_per_radius: Option<f64>,
    /// No edge further from the surface than this, where given.
    pub chord: Option<f64>,
    /// No edge is asked to be shorter than this for the sake of curvature; without it a sixteenth of `size`.
    pub least_size: Option<f64>,
    /// The operators, in order.
    pub sequence: Sequence,
    /// How often, at most, the sequence is run again when triangles of the result intersect or face the wrong way: each time
    /// the surroundings of these places are left as the input has them, in growing circles. 0 for a look at the
    /// operators themselves.
    pub retries: usize,
}

impl Options {
    /// The default sequence for edges of length `size`: creases from 20 degrees; on curved parts nine nodes to the radius,
    /// which keeps the normals there within 2.4 degrees, but no edges shorter than half of `size` for that.
    pub fn new(size: f64) -> Self {
        Self {
            size,
            feature_angle: 20.0,
            nodes_per_radius: Some(NODES_PER_RADIUS),
            chord: None,
            least_size: Some(0.5 * size),
            sequence: cut_sequence(),
            retries: 4,
        }
    }

    fn check(&self) -> Result<()> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let given = [Some(self.size), self.nodes_per_radius, self.chord, self.least_size];
        if !given.into_iter().flatten().all(positive) {
            return Err(Error::Usage("size, nodes per radius, chord and least size must be positive".into()));
        }
        if !(positive(self.feature_angle) && self.feature_angle < 180.0) {
            return Err(Error::Usage("the feature angle must lie between 0 and 180 degrees".into()));
        }
        Ok(())
    }

    fn sizing(&self) -> Sizing {
        Sizing {
            size: self.size,
            nodes_per_radius: self.nodes_per_radius,
            chord: self.chord,
            least: self.least_size.unwrap_or(self.size / LEAST_SHARE),
        }
    }
}

/// What one operator did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// It moved nodes.
    Moves(Moves),
    /// It added or removed nodes or flipped edges.
    Edits(Edits),
    /// It made creases.
    Creases(CreaseReport),
    /// It classified: how many nodes are regular, on creases, corners.
    Classes([usize; 3]),
    /// It measured.
    Deviation(NormalDeviation),
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Moves(m) => write!(f, "{} moved, {} shortened, {} rejected", m.moved, m.shortened, m.rejected),
            Outcome::Edits(e) => {
                write!(f, "{} split, {} collapsed, {} flipped, {} refused", e.splits, e.collapses, e.flips, e.refused)
            }
            Outcome::Creases(c) => {
                write!(f, "{} cut, {} corners, {} snapped, {} sharp edges", c.cuts, c.corners, c.snapped, c.sharp)
            }
            Outcome::Classes([r, e, c]) => write!(f, "{r} regular, {e} on creases, {c} corners"),
            Outcome::Deviation(d) => write!(f, "normal deviation {:.3e}, {} inverted", d.normal, d.inverted),
        }
    }
}

/// What a sequence did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SequenceReport {
    /// Each operator with what it did, in order.
    pub stages: Vec<(Operator, Outcome)>,
    /// Normal deviation before.
    pub before: NormalDeviation,
    /// Normal deviation after.
    pub after: NormalDeviation,
    /// Edges marked sharp in the end.
    pub sharp_edges: usize,
    /// Triangles of the result that intersect another one.
    pub self_intersections: usize,
    /// How often the sequence was run again, with places that had come out wrong left as they were.
    pub retries: usize,
    /// Nodes left where they were for that reason.
    pub frozen: usize,
}

/// Improves a mesh by the operators of `options.sequence`. See [`improve_with`].
pub fn improve(mesh: &mut TriMesh, oracle: &dyn SurfaceOracle, options: &Options, run: &Run) -> Result<SequenceReport> {
    improve_with(mesh, oracle, options, run, &mut |_, _| {})
}

/// Improves a mesh and shows it to `observer`, with the operator's name, after every operator.
///
/// When triangles of the result intersect, or face away from the surface, the sequence runs again from the input with the
/// surroundings of these places left as they are, up to `options.retries` times; the best result is kept, and shown to
/// `observer` under the name `retry` (the runs in between are not shown).
///
/// *Guarantees*: a closed, oriented manifold stays one, with the same Euler number; every move is guarded (see
/// [`guard`](super::guard)); labels of the result are the oracle's faces under the triangles if the sequence ends with
/// `survey`; the result is the same for any number of threads. On error `mesh` is as before.
/// *Does not guarantee*: that no triangle is inverted where the mesh is too coarse for the surface, such as in a wedge
/// thinner than an edge (`after.inverted` tells), nor that no two triangles intersect: where a coarse cylinder
/// grazes a plane a few did, and `self_intersections` tells.
/// *Errors*: [`Error::Usage`] for senseless options, [`Error::Input`] for a mesh that is no oriented manifold,
/// [`Error::Cancelled`].
pub fn improve_with(
    mesh: &mut TriMesh,
    oracle: &dyn SurfaceOracle,
    options: &Options,
    run: &Run,
    observer: &mut dyn FnMut(&str, &TriMesh),
) -> Result<SequenceReport> {
    options.check()?;
    let mut frozen: Vec<(DVec3, f64)> = Vec::new();
    let mut best: Option<((usize, usize), TriMesh, SequenceReport)> = None;
    for attempt in 0..=options.retries {
        let mut unseen = |_: &str, _: &TriMesh| {};
        let watch: &mut dyn FnMut(&str, &TriMesh) = if attempt == 0 { &mut *observer } else { &mut unseen };
        let (made, mut report) = Worker::new(mesh, oracle, options, run)?.run_sequence(mesh, &frozen, watch)?;
        let places = faults(&made, oracle, options.size, run)?;
        report.retries = attempt;
        report.self_intersections = places.intersecting;
        let badness = (places.intersecting, report.after.inverted);
        if best.as_ref().is_none_or(|b| badness < b.0) {
            best = Some((badness, made, report));
        }
        if places.intersecting == 0 && (attempt > 0 || badness.1 == 0) {
            break;
        }
        let radius = options.size * FREEZE * 2f64.powi(attempt as i32);
        frozen.extend(places.points.into_iter().map(|p| (p, radius)));
    }
    if let Some((_, made, report)) = best {
        if report.retries > 0 {
            observer("retry", &made);
        }
        *mesh = made;
        return Ok(report);
    }
    Err(Error::Failed("no operator sequence was run".into()))
}

/// Where a mesh is at fault.
struct Faults {
    /// Triangles that intersect another one.
    intersecting: usize,
    /// Centroids of these and of inverted triangles.
    points: Vec<DVec3>,
}

fn faults(mesh: &TriMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<Faults> {
    let mut bad = intersecting_triangles(mesh, run)?;
    let intersecting = bad.len();
    let inverted = ask_all(oracle, run, mesh.triangles.len(), |t| {
        let t = t as usize;
        let foot = oracle.project(mesh.centroid(t), reach)?;
        (mesh.area_vector(t).dot(foot.normal) <= 0.0).then_some(t as u32)
    })?;
    bad.extend(inverted.into_iter().flatten());
    Ok(Faults { intersecting, points: bad.into_iter().map(|t| mesh.centroid(t as usize)).collect() })
}

/// The mesh under way and what operators leave for each other.
struct Worker<'a> {
    mesh: EditMesh,
    oracle: &'a dyn SurfaceOracle,
    options: &'a Options,
    run: &'a Run,
    /// From the last classification, until an edit makes it stale.
    classes: Option<Classes>,
    /// Whether creases are edges already: then a triangle lies on one face and has one normal to agree with.
    resolved: bool,
}

impl<'a> Worker<'a> {
    fn new(mesh: &TriMesh, oracle: &'a dyn SurfaceOracle, options: &'a Options, run: &'a Run) -> Result<Self> {
        Ok(Self { mesh: EditMesh::new(mesh)?, oracle, options, run, classes: None, resolved: false })
    }

    /// One run of the sequence over a copy of `mesh`, nodes within the `frozen` balls pinned.
    fn run_sequence(
        mut self,
        mesh: &TriMesh,
        frozen: &[(DVec3, f64)],
        observer: &mut dyn FnMut(&str, &TriMesh),
    ) -> Result<(TriMesh, SequenceReport)> {
        let Self { oracle, options, run, .. } = self;
        let pinned = ask_all(oracle, run, mesh.nodes.len(), |v| {
            let p = mesh.nodes[v as usize];
            frozen.iter().any(|(c, r)| p.distance_squared(*c) <= r * r).then_some(v)
        })?;
        let mut report = SequenceReport::default();
        for v in pinned.into_iter().flatten() {
            self.mesh.set_pinned(v, true);
            report.frozen += 1;
        }
        report.before = normal_deviation(&self.mesh, oracle, options.size, run)?;
        let operators = options.sequence.operators();
        for (k, &operator) in operators.iter().enumerate() {
            run.check()?;
            run.progress("optimize", k as f64 / operators.len() as f64);
            let outcome = self.apply(operator)?;
            debug_assert_eq!(self.mesh.check(), Ok(()));
            report.stages.push((operator, outcome));
            observer(operator.name(), &self.mesh.to_mesh());
        }
        run.progress("optimize", 1.0);
        report.after = match report.stages.last() {
            Some((Operator::Survey, Outcome::Deviation(d))) => *d,
            _ => normal_deviation(&self.mesh, oracle, options.size, run)?,
        };
        report.sharp_edges = self.mesh.edges().filter(|&h| self.mesh.is_sharp(h)).count();
        Ok((self.mesh.to_mesh(), report))
    }

    fn apply(&mut self, operator: Operator) -> Result<Outcome> {
        let (oracle, run, reach, angle) = (self.oracle, self.run, self.options.size, self.options.feature_angle);
        let moves_freely = matches!(operator, Operator::SmoothAll | Operator::AlignNormals | Operator::SnapToPlanes);
        if moves_freely && !self.resolved {
            // A chamfer triangle lies on no face; holding it to one would keep its nodes off the crease.
            forget(&mut self.mesh);
        }
        let flips = |n: usize| Outcome::Edits(Edits { flips: n, ..Edits::default() });
        let mesh = &mut self.mesh;
        let outcome = match operator {
            Operator::Project => Outcome::Moves(project(mesh, oracle, reach, run)?),
            Operator::SmoothAll => Outcome::Moves(smooth_all(mesh, oracle, reach, run)?),
            Operator::AlignNormals => Outcome::Moves(align_normals(mesh, oracle, reach, DAMPING, run)?),
            Operator::SnapToPlanes => {
                let moves = snap_to_planes(mesh, oracle, reach, 0.0, run)?;
                // What it made of creases is marked, or smoothing by classes would tear nodes out of them again.
                mark_sharp(mesh, oracle, reach, angle, run)?;
                Outcome::Moves(moves)
            }
            Operator::ClassifyByCurvature => {
                let classes = classify_by_curvature(mesh, angle, run)?;
                let counts = classes.counts();
                self.classes = Some(classes);
                Outcome::Classes(counts)
            }
            Operator::ClassifyByEdges => {
                let classes = classify_by_edges(mesh);
                let counts = classes.counts();
                self.classes = Some(classes);
                Outcome::Classes(counts)
            }
            Operator::SmoothRegular => {
                let classes = self.classes()?;
                let moves = smooth_regular(&mut self.mesh, oracle, &classes, reach, run)?;
                self.classes = Some(classes);
                Outcome::Moves(moves)
            }
            Operator::SmoothEdges => {
                let classes = self.classes()?;
                let moves =
                    smooth_edges(&mut self.mesh, oracle, CreaseStep { classes: &classes, c: ALONG }, reach, run)?;
                self.classes = Some(classes);
                Outcome::Moves(moves)
            }
            Operator::Densify => {
                let mut field = node_sizes(&self.options.sizing(), mesh, oracle, reach, run)?;
                Outcome::Edits(densify(mesh, oracle, &mut field, reach, run)?)
            }
            Operator::CollapseTiny | Operator::CollapseShort => {
                let field = node_sizes(&self.options.sizing(), mesh, oracle, reach, run)?;
                let share = if operator == Operator::CollapseTiny { TINY } else { SHORT };
                Outcome::Edits(collapse_short(mesh, oracle, ShortEdges { field: &field, share }, reach, run)?)
            }
            Operator::RemoveDegenerate => {
                Outcome::Edits(remove_degenerate(mesh, oracle, 2.0 * DEGENERATE_ANGLE, reach, run)?)
            }
            Operator::FlipForAngles => flips(flip_for_angles(mesh, BEND, run)?),
            Operator::FlipForNormals => {
                let n = flip_for_normals(mesh, oracle, reach, angle, run)?;
                // An edge flipped onto a crease is part of it from here on: unmarked, `degenerate` would flip or join it away again.
                mark_sharp(mesh, oracle, reach, angle, run)?;
                flips(n)
            }
            Operator::CutCreases => {
                self.resolved = true;
                Outcome::Creases(cut_creases(mesh, oracle, reach, angle, run)?)
            }
            Operator::SettleCreases => Outcome::Moves(settle_creases(mesh, oracle, reach, run)?),
            Operator::RelaxWorst => {
                let moved = relax_worst(mesh, oracle, RELAX_ANGLE, reach, run)?;
                Outcome::Moves(Moves { moved, ..Moves::default() })
            }
            Operator::Survey => Outcome::Deviation(survey(mesh, oracle, reach, run)?),
        };
        if matches!(outcome, Outcome::Edits(_) | Outcome::Creases(_)) {
            self.classes = None;
        }
        Ok(outcome)
    }

    /// The classes at hand, or by sharp edges where some are marked, else by curvature.
    fn classes(&mut self) -> Result<Classes> {
        match self.classes.take() {
            Some(classes) => Ok(classes),
            None if self.resolved => Ok(classify_by_edges(&self.mesh)),
            None => classify_by_curvature(&self.mesh, self.options.feature_angle, self.run),
        }
    }
}
