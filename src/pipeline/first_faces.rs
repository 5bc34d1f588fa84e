//! Faces of a boundary representation triangulated for the first time, with edges as short as curvature and narrow places ask for, and
//! shorter where triangles cross.

use glam::DVec3;

use super::bodies::EQUILATERAL;
use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change, Ladder, LadderState, climb};
use super::options::MeshOptions;
use super::refine::Wishes;
use super::report::{FaceStep, Report, Rung};
use crate::error::{Error, Result};
use crate::mesh::{TriMesh, self_intersections};
use crate::parametric::Parametric;
use crate::parametric::mesh::{FaceMeshes, Looked, MeshSizes, Remedy, THINNEST};
use crate::quality::Fault;
use crate::run::Run;
use crate::sizing::{GRADING, LEAST_SHARE, Sizing, Wish};
use crate::spatial::Graded;

/// Without a wish for more, bends and narrow places make at most this many times the nodes the size alone asks for.
const MOST_DETAIL: f64 = 3.0;
/// So many nodes are never too many.
const MANY: usize = 80_000;
/// So many triangles come of a node.
const NODE_TRIANGLES: usize = 2;
/// Where there are too many the least length grows by this factor.
const LESS: f64 = 1.6;
/// Narrow places and short edges, which cost less, down to this share.
const NARROW: f64 = 0.25;
/// Narrow places and short edges where triangles would be needles otherwise, down to this share.
pub(super) const NARROWEST: f64 = 0.05;
/// Bends narrower than the least length make edges shorter than it down to this share of it.
const DEEP: f64 = 0.5;
/// What leaves its chord by more than this many times what edges shall is followed further, down to [`SAGGING`]: it would be too far away,
/// not only rough.
const SAGITTA: f64 = 1.6;
/// The share of the least length edges have there, at least: an eighth of the length makes chords 64 times as near.
const SAGGING: f64 = 0.125;
/// With more than so many times the triangles the size alone asks for lengths grow faster, as most triangles are then where they
/// grow.
const CROWDED: f64 = 20.0;
/// At most so fast do lengths grow then.
const STEEP: f64 = 0.45;
/// With more than so many times the triangles, bends may leave their chords by more.
const BUSY: f64 = 60.0;
/// Narrow places may be followed then down to this share of [`NARROWEST`].
const DEEPLY: f64 = 0.5;

/// With a distance asked for curvature makes edges at most this many times shorter than the size.
const FINEST: f64 = 256.0;
/// How often lengths are halved where triangles of one body cross each other, as long as that helps.
const HALVINGS: usize = 5;
/// It helps if at most this share of them is left: faces of a model that cross go on crossing.
const LEFT: f64 = 0.7;

/// Faces triangulated for the first time.
pub(super) struct First {
    pub(super) made: FaceMeshes,
    /// The lengths that were followed, and how fast they grow.
    pub(super) sizing: Sizing,
    pub(super) grading: f64,
    /// What is told of it.
    pub(super) report: Report,
    /// The number of its attempt.
    pub(super) number: usize,
    followed: Followed,
    /// Pairs of triangles of one body that cross each other.
    hits: Vec<[u32; 2]>,
}

/// What faces are triangulated by.
pub(super) struct FaceLadder<'a> {
    solid: &'a Parametric,
    options: &'a MeshOptions,
    wishes: &'a Wishes,
    /// What is told before.
    report: &'a Report,
    looked: Looked,
    /// How far chords may be from their curves.
    chord: f64,
    /// Places where edges are shorter,
    finer: Vec<(DVec3, f64)>,
    /// and where they are for triangles that crossed each other.
    crossed: Vec<(DVec3, f64)>,
    /// How many of these helped.
    known: usize,
    held: Option<Followed>,
    halved: usize,
}

impl<'a> FaceLadder<'a> {
    pub(super) fn new(solid: &'a Parametric, options: &'a MeshOptions, wishes: &'a Wishes, report: &'a Report) -> Self {
        Self {
            solid,
            options,
            wishes,
            report,
            looked: Looked::default(),
            chord: Wish::new(report.size, solid.bounds().diagonal(), options.asked()).chord(),
            finer: Vec::new(),
            crossed: Vec::new(),
            known: 0,
            held: None,
            halved: 0,
        }
    }

    /// Triangulates faces so that chords are within a length, with shorter edges at more places; where triangles crossed before they
    /// stay short.
    ///
    /// Errors: [`Error::Failed`] when no face can be meshed; cancellation.
    pub(super) fn within(
        &mut self,
        chord: f64,
        finer: &[(DVec3, f64)],
        attempts: &mut Attempts,
        run: &Run,
    ) -> Result<First> {
        self.chord = chord;
        self.finer.extend_from_slice(finer);
        (self.held, self.halved) = (None, 0);
        climb(self, attempts, run)?.ok_or(Error::Cancelled)
    }
}

impl Ladder for FaceLadder<'_> {
    type Made = First;

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<First>> {
        run.check()?;
        let mut report = self.report.clone();
        let (made, followed) = self.first_mesh(&mut report, run)?;
        let hits = crossings(&made.mesh, run)?;
        let attempt = Attempt::new(Tried::Faces, report.size, made.mesh.triangles.len(), hits.len());
        let number = attempts.add(attempt, run);
        let Followed { sizing, grading, .. } = followed;
        Ok(Some(First { made, sizing, grading, report, number, followed, hits }))
    }

    fn is_better(&self, new: &First, best: Option<&First>) -> bool {
        best.is_none_or(|b| new.hits.len() as f64 <= LEFT * b.hits.len() as f64)
    }

    fn next(&mut self, seen: &LadderState<'_, First>) -> Option<(Change, &'static str)> {
        if !seen.improved {
            self.crossed.truncate(self.known);
            return None;
        }
        self.known = self.crossed.len();
        if seen.last.hits.is_empty() || self.halved == HALVINGS {
            return None;
        }
        self.halved += 1;
        // Walls thinner than the bends of their faces are high, within one body: finer triangles pass each other.
        let mesh = &seen.last.made.mesh;
        let crossed = seen.last.hits.iter().flatten().map(|t| halved(mesh, *t as usize, self.options));
        self.crossed.extend(crossed);
        self.held = Some(seen.last.followed);
        Some((Change::ShorterEdgesHere, "triangles cross"))
    }
}

/// Pairs of triangles of one body that cross each other.
fn crossings(mesh: &TriMesh, run: &Run) -> Result<Vec<[u32; 2]>> {
    let mut all = self_intersections(mesh, run)?;
    if !all.is_empty() {
        let body = mesh.bodies();
        all.retain(|[t, u]| body[*t as usize] == body[*u as usize]);
    }
    Ok(all)
}

/// The middle of a triangle and half the length of its edges.
fn halved(mesh: &TriMesh, t: usize, options: &MeshOptions) -> (DVec3, f64) {
    let [a, b, c] = mesh.corners(t);
    let length = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
    (mesh.centroid(t), (0.5 * length).max(options.least_length().unwrap_or(0.0)))
}

/// What lengths were followed, and how fast they grow.
#[derive(Clone, Copy)]
struct Followed {
    sizing: Sizing,
    grading: f64,
    /// How far bends narrower than the least length may leave their chords.
    sagitta: f64,
}

impl Followed {
    /// The length wanted where the larger principal curvature has some magnitude; `share` gives shares of the least length.
    fn at(&self, curvature: f64, share: &dyn Fn(f64) -> f64) -> f64 {
        let radius = 1.0 / curvature;
        // No edge is longer than the radius of a bend, down to a share of the least length: else triangles face any way.
        let bent = radius.max(share(DEEP));
        // What is narrower than the sagitta is nowhere that far away.
        let deep = Sizing { nodes_per_radius: None, chord: Some(self.sagitta), least: share(SAGGING), ..self.sizing };
        let near = if self.sagitta < radius { deep.at(curvature) } else { f64::INFINITY };
        self.sizing.at(curvature).min(bent).min(near)
    }
}

/// How many times as many triangles there are as the size alone asks for.
fn detail(made: &FaceMeshes, size: f64) -> f64 {
    let area: f64 = (0..made.mesh.triangles.len()).map(|t| 0.5 * made.mesh.area_vector(t).length()).sum();
    made.mesh.triangles.len() as f64 * EQUILATERAL * size * size / area
}

impl FaceLadder<'_> {
    /// Faces between edges, triangulated for the first time, and the sizes that were followed: those that are `held`, or as fine
    /// as keeps the number of triangles within bounds.
    fn first_mesh(&mut self, report: &mut Report, run: &Run) -> Result<(FaceMeshes, Followed)> {
        let Self { solid, options, wishes, chord, held, .. } = *self;
        let size = report.size;
        let wish = Wish::new(size, solid.bounds().diagonal(), options.asked());
        let field = Graded::new([&self.finer[..], &self.crossed].concat(), wish.grading);
        let by_place = |p: DVec3| {
            let of_regions = wishes.regions.iter().map(|r| r.at(p, wish.grading));
            field.at(p, of_regions.fold(f64::INFINITY, f64::min))
        };
        let looked = &mut self.looked;
        let small = if options.tolerance_length().is_some() { FINEST } else { LEAST_SHARE };
        let mut followed = held.unwrap_or(Followed {
            sizing: Sizing { chord: Some(chord), ..wish.sizing(options.least_length().unwrap_or(size / small)) },
            grading: wish.grading,
            sagitta: SAGITTA * chord,
        });
        let free = options.least_length().is_none() && options.angle.is_none() && options.tolerance_length().is_none();
        // Who asks for a least length gets it.
        let share =
            |sizing: &Sizing, s: f64| if options.least_length().is_some() || sizing.least >= size { 1.0 } else { s };
        let of_least = |sizing: &Sizing, s: f64| share(sizing, s) * sizing.least;
        // What the memory holds bounds what nothing else does.
        let affordable = run.most_triangles().map_or(usize::MAX, |m| (m / NODE_TRIANGLES).max(MANY));
        let by_face = |f: u32| wishes.faces.get(f as usize).copied().flatten();
        let mut first = |followed: &Followed, most: usize, narrowest: f64| {
            let Followed { sizing, grading, .. } = followed;
            let (most, bound) = if most > affordable { (affordable, true) } else { (most, false) };
            let by_curvature = |k: f64| followed.at(k, &|s| of_least(sizing, s));
            // A distance asked for is no wish for narrow places.
            let narrow = sizing.least.max(options.least_length().map_or(size / LEAST_SHARE, |l| l.min(size)));
            // For study narrow places may be followed however deep, up to what memory holds.
            let held = !options.without.contains(&Remedy::LeastLength);
            let (least, deepest) = if held {
                (share(sizing, NARROW) * narrow, share(sizing, narrowest) * narrow)
            } else {
                // Without a least length narrow places are followed as far down as tubes are.
                (THINNEST * size, THINNEST * size)
            };
            let sizes = MeshSizes {
                size,
                least,
                deepest,
                size_at: &by_curvature,
                place_size: &by_place,
                face_size: &by_face,
                grading: *grading,
                most,
            };
            let made = solid.mesh_again(&sizes, looked, run)?;
            if made.too_many && bound {
                return Err(run.too_many((NODE_TRIANGLES * most) as f64, "more than"));
            }
            Ok(made)
        };
        let bounded = free && held.is_none();
        let mut made = first(&followed, if bounded { MANY } else { usize::MAX }, NARROWEST)?;
        if bounded && !made.too_many && options.grading.is_none() {
            let times = detail(&made, size);
            if times > CROWDED {
                followed.grading = (GRADING * (times / CROWDED).sqrt()).min(STEEP);
                followed.sagitta *= (times / BUSY).max(1.0).powi(2);
                // There is room then for narrow places, unless they are all there is.
                let most = made.mesh.triangles.len();
                let deep = if times > BUSY { Some(first(&followed, most, DEEPLY * NARROWEST)?) } else { None };
                let small = |m: &FaceMeshes| !m.too_many && m.mesh.triangles.len() <= most;
                made = deep.filter(small).map_or_else(|| first(&followed, usize::MAX, NARROWEST), Ok)?;
            }
        }
        if made.too_many {
            let plain = Followed { sizing: Sizing { least: size, ..followed.sizing }, ..followed };
            let plain = first(&plain, usize::MAX, NARROWEST)?;
            let most = MANY.max((MOST_DETAIL * plain.mesh.nodes.len() as f64) as usize).min(affordable);
            while made.too_many {
                let least = &mut followed.sizing.least;
                *least = (LESS * *least).min(size);
                let most = if *least < size { most } else { usize::MAX };
                made = first(&followed, most, NARROWEST)?;
            }
        }
        let least = followed.sizing.least;
        if free && least > size / LEAST_SHARE {
            let why = "there would be too many triangles";
            report.warnings.push(format!("bends and narrow places are not followed below {least:.6}: {why}"));
        }
        for (face, rung, why) in &made.steps {
            report.ladder.push(FaceStep::of(solid, *face, (*rung).into(), why.clone()));
        }
        for f in &made.failures {
            let face = &solid.brep.faces[f.face as usize];
            let kind = face.surface.kind();
            let (name, source, reason) = (face.name.clone(), face.source, f.reason.clone());
            report.shortfalls.push(Fault::NoMesh { face: name, source, surface: Some(kind), reason });
            report.ladder.push(FaceStep::of(solid, f.face, Rung::None, f.reason.clone()));
        }
        if made.mesh.triangles.is_empty() {
            let why: Vec<String> = report.shortfalls.iter().map(ToString::to_string).collect();
            return Err(Error::Failed(format!("no face could be meshed: {}", why.join("; "))));
        }
        Ok((made, followed))
    }
}
