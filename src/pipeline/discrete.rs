//! From a triangle soup to a mesh: what is damaged is healed, a model is found in the triangles, its faces are remeshed.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use super::bodies::NAMED;
use super::budget::{covering, measurable};
use super::faults::{Touching, keep_shells};
use super::heal::told;
use super::history::Clock;
use super::ladder::{Attempts, Change, Ladder, LadderState, MeshAttempt, climb};
use super::load::is_3mf;
use super::mesh::Meshed;
use super::options::MeshOptions;
use super::refine::Wishes;
use super::report::Report;
use super::soup_ladder::{LadderEnd, SoupLadder, SoupTrial};
use super::soup_sizes::{self, feature_sizes, relaxed, sizing};
use super::source::MeshOrigin;
use crate::discrete::{Discrete, DiscreteOptions, Limits, TORN_WIDTH};
use crate::error::{Error, Result};
use crate::heal::{HealOptions, absorb_fillings, heal, join_torn};
use crate::io::threemf::has_levelset;
use crate::io::{self, Format};
use crate::mesh::{TriMesh, self_intersections};
use crate::quality::{Against, Expectation, Fault, check_tested};
use crate::remesh::{RemeshOptions, RemeshedMesh};
use crate::run::Run;
use crate::sizing::{DEFAULT_SIZE, SizeRequest, Wish};

/// Where healing left more than one triangle in this many that touches others, all stay.
const TOUCHED: usize = 200;
/// Where more than one triangle in this many stays from the beginning, all connected parts do on which some stay.
const MUCH: usize = 4;
/// Around such places edges may get as short as this share of what curvature may make them.
const LEAST_BESIDE: f64 = 0.125;
/// Where a mesh whose edges may be farther from the surface than else is at fault, they may still be so many times as far: what would
/// have to be nearer is noise. An armadillo gets three times the triangles with 1.
const STRICT: f64 = 2.5;
/// How often a mesh is made to come to a number of nodes.
const TRIALS: usize = 5;
/// How near to that number is near enough, as a share of it.
const NEAR: f64 = 0.03;
/// Fillings of less area than this many squares of the size are no faces of their own,
const LEAST_FILLING: f64 = 1.0;
/// Geometric edges that end within a face and are shorter than this many sizes are noise to a mesh of that size.
const STUB: f64 = 2.0;
/// The same for edges that end within a face on both sides.
const ISOLATED: f64 = 6.0;

/// What a soup is asked for, beyond [`MeshOptions`].
#[derive(Debug, Clone, PartialEq)]
pub struct SoupOptions {
    /// Edges are features where the triangles' normals differ by more degrees.
    pub feature_angle: f64,
    /// Faces of less area are merged with a neighbor.
    pub min_area: f64,
    /// Edges shorter than this that end within a face are dropped, faces narrower than this merged with a neighbor. Without
    /// a wish edges shorter than the size are dropped, and no faces.
    pub min_length: Option<f64>,
    /// About how many nodes the mesh shall have, instead of a size.
    pub nodes: Option<usize>,
    /// Whether contours of open edges are closed, too. Otherwise an open surface stays open, unless it is damaged.
    pub close: bool,
}

impl Default for SoupOptions {
    fn default() -> Self {
        let d = DiscreteOptions::default();
        Self { feature_angle: d.feature_angle, min_area: 0.0, min_length: None, nodes: None, close: false }
    }
}

/// Whether a path is that of a mesh file that can be read. A 3MF package is one unless it has a level set, for which it is looked at.
pub fn is_mesh(path: &Path) -> bool {
    if is_3mf(path) {
        return std::fs::read(path).is_ok_and(|bytes| !has_levelset(&bytes));
    }
    Format::from_path(path).is_ok()
}

/// Reads a mesh file. Errors name the file.
pub fn load_mesh(path: &Path, run: &Run) -> Result<TriMesh> {
    io::read(path, run)
}

/// A soup that the discrete gate can work on.
pub(super) struct Prepared {
    pub(super) mesh: TriMesh,
    pub(super) healed: Vec<String>,
}

impl Prepared {
    /// What a mesh of edges of a length is made from: fillings that would be smaller than its triangles belong to faces beside
    /// them.
    pub(super) fn at(&self, size: f64) -> Cow<'_, TriMesh> {
        let mut mesh = Cow::Borrowed(&self.mesh);
        if !self.healed.is_empty() {
            absorb_fillings(mesh.to_mut(), LEAST_FILLING * size * size, TORN_WIDTH * size);
        }
        mesh
    }
}

/// Whether a mesh is an oriented manifold, open or closed, without degenerate triangles, that does not intersect itself.
fn is_sound(mesh: &TriMesh, run: &Run) -> Result<bool> {
    let d = mesh.defects();
    Ok(d.is_manifold()
        && d.is_oriented()
        && d.degenerate_triangles.is_empty()
        && d.duplicate_triangles.is_empty()
        && self_intersections(mesh, run)?.is_empty())
}

/// Heals what needs it: nothing, borders that lie on each other but for rounding, then what can be healed without closing contours, then everything.
pub(super) fn prepare(input: &TriMesh, close: bool, run: &Run) -> Result<Prepared> {
    input.validate()?;
    run.progress("look", 0.0);
    let closed = |m: &TriMesh| m.defects().is_closed();
    let outward = |m: &TriMesh| !closed(m) || m.volume() > 0.0;
    if is_sound(input, run)? && outward(input) && (!close || closed(input)) {
        if !closed(input)
            && let Some(joined) = join_torn(input, run)?
            && is_sound(&joined.mesh, run)?
        {
            return Ok(Prepared { healed: told(&joined.report), mesh: joined.mesh });
        }
        let mut mesh = input.clone();
        mesh.drop_unused_nodes();
        return Ok(Prepared { mesh, healed: Vec::new() });
    }
    if !close
        && let Ok(gentle) = heal(input, &HealOptions { max_hole: Some(0) }, run)
        && is_sound(&gentle.mesh, run)?
    {
        return Ok(Prepared { healed: told(&gentle.report), mesh: gentle.mesh });
    }
    let full = heal(input, &HealOptions::default(), run)?;
    let mut healed = told(&full.report);
    healed.extend(full.report.shortfalls.iter().cloned());
    Ok(Prepared { healed, mesh: full.mesh })
}

pub(super) fn discrete_options(soup: &SoupOptions, size: f64) -> DiscreteOptions {
    let limits = Limits {
        area: soup.min_area,
        width: soup.min_length.unwrap_or(0.0),
        length: soup.min_length.unwrap_or(STUB * size),
        isolated: soup.min_length.unwrap_or(ISOLATED * size),
    };
    DiscreteOptions { feature_angle: soup.feature_angle, limits, scale: size, ..DiscreteOptions::default() }
}

pub(super) fn length(size: Option<SizeRequest>, mesh: &TriMesh) -> f64 {
    size.unwrap_or(DEFAULT_SIZE).length(mesh.bounds().diagonal())
}

/// Meshes a triangle soup.
///
/// Guarantees: nodes on features lie on the input's features, others on its triangles; the same bytes for any number of
/// threads; what was healed or simplified away is in the report's `warnings`. Where remeshing makes the surface intersect
/// itself and the input does not, the input's triangles around are kept, at last all of them, and the report's `shortfalls`
/// say so.
///
/// Errors: what [`heal`] refuses; [`Error::Usage`] for fewer than four nodes or a sequence of operators, and where more triangles are
/// expected than [`MeshOptions::memory`] holds; cancellation.
pub fn mesh_soup(input: &TriMesh, options: &MeshOptions, soup: &SoupOptions, run: &Run) -> Result<Meshed> {
    options.for_any_solid()?;
    options.for_boundary()?;
    input.validate()?;
    measurable(&input.bounds())?;
    let run = &run.clone().with_memory(options.memory).timed(options.timed);
    let options = &options.resolved(input.bounds().diagonal());
    let prepared = prepare(input, soup.close, run)?;
    let mut attempts = Attempts::new(options.timed);
    let Some(nodes) = soup.nodes else {
        let asked = SoupGoal { prepared: &prepared, size: length(options.size, &prepared.mesh), options, soup };
        return Ok(asked.mesh(&mut attempts, run)?.made.told(attempts));
    };
    if nodes < 4 {
        return Err(Error::Usage(format!("a mesh needs at least four nodes, not {nodes}")));
    }
    // A closed surface of even triangles has two to a node.
    let size = (prepared.mesh.area() / (2.0 * nodes as f64) / (3f64.sqrt() / 4.0)).sqrt();
    let mut ladder = NodeLadder { prepared: &prepared, options, soup, nodes, size, trials: 0 };
    let (mut made, off) = climb(&mut ladder, &mut attempts, run)?.ok_or(Error::Cancelled)?;
    if off.abs() >= NEAR {
        let Meshed { mesh, report, .. } = &mut made.meshed;
        report.warnings.push(format!("{} nodes, not {nodes}: features ask for them", mesh.nodes.len()));
    }
    Ok(made.told(attempts))
}

/// Other sizes, for a number of nodes.
struct NodeLadder<'a> {
    prepared: &'a Prepared,
    options: &'a MeshOptions,
    soup: &'a SoupOptions,
    nodes: usize,
    size: f64,
    trials: usize,
}

impl Ladder for NodeLadder<'_> {
    /// With the logarithm of how many times the nodes there are.
    type Made = (MeshAttempt, f64);

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Self::Made>> {
        let asked = SoupGoal { prepared: self.prepared, size: self.size, options: self.options, soup: self.soup };
        let made = asked.mesh(attempts, run)?.made;
        let off = (made.meshed.mesh.nodes.len() as f64 / self.nodes as f64).ln();
        Ok(Some((made, off)))
    }

    fn is_better(&self, new: &Self::Made, best: Option<&Self::Made>) -> bool {
        best.is_none_or(|b| new.1.abs() < b.1.abs())
    }

    fn next(&mut self, seen: &LadderState<'_, Self::Made>) -> Option<(Change, &'static str)> {
        let off = seen.last.1;
        self.trials += 1;
        self.size *= (0.5 * off).exp().clamp(0.4, 2.5);
        let change = if off > 0.0 { Change::LongerEdges } else { Change::ShorterEdges };
        (off.abs() >= NEAR && self.trials < TRIALS).then_some((change, "another number of nodes was asked for"))
    }
}

/// What a soup's mesh is made for.
struct SoupGoal<'a> {
    prepared: &'a Prepared,
    size: f64,
    options: &'a MeshOptions,
    soup: &'a SoupOptions,
}

/// A mesh, and how many of its triangles are turned over or slim within a face.
struct RatedMesh {
    made: MeshAttempt,
    flaws: usize,
}

impl SoupGoal<'_> {
    fn mesh(&self, attempts: &mut Attempts, run: &Run) -> Result<RatedMesh> {
        let Self { prepared, size, options, soup } = *self;
        let mut report = Report::of("triangles", size, None);
        report.warnings.clone_from(&prepared.healed);
        let mut timer = Clock::new(options.timed);
        // Walls and features are divided before lengths of edges are known: nothing is, where the size alone asks for too much.
        covering(prepared.mesh.area(), size, run)?;
        let mesh = &prepared.at(size);
        let found =
            |scale: f64| match Discrete::new(mesh, &DiscreteOptions { scale, ..discrete_options(soup, size) }, run) {
                Ok(solid) => Ok(solid),
                Err(Error::Cancelled) => Err(Error::Cancelled),
                Err(e) => Err(Error::Failed(format!("not remeshed: {e}"))),
            };
        let mut solid = found(size)?;
        let mut touching = Touching::default();
        if !prepared.healed.is_empty() {
            touching = Touching::of(&solid.named(), run)?;
        }
        // Where healing left hardly any room even nodes that are put on edges may be in the way.
        if !touching.is_empty() {
            solid = found(0.0)?;
            touching = Touching::of(&solid.named(), run)?;
        }
        tell_removed(&solid, &mut report);
        let sizing = relaxed(sizing(size, solid.bounds().diagonal(), options), options, soup, &solid);
        // What is left as it was is not divided.
        let named = solid.named();
        // What touches is known by its triangles.
        if touching.is_empty() {
            solid.divide_walls(|k| sizing.at(k), sizing.least.min(size), run)?;
        }
        let open = !named.defects().is_closed();
        let wishes =
            Wishes::new(&options.refinements, mesh.bounds().diagonal(), named.faces.iter().map(String::as_str))?;
        let (face_sizes, regions) = (wishes.faces, wishes.regions);
        let wish = Wish::new(size, solid.bounds().diagonal(), options.asked());
        let plain = soup_sizes::exact(sizing, options, &solid);
        let exact = RemeshOptions { face_sizes, regions, ..plain };
        let mut sizes = feature_sizes(&solid, &sizing, wish.chord(), &mut report);
        let walls = solid.walls(|k| sizing.at(k), sizing.least.min(size), run)?;
        sizes.iter_mut().zip(walls.sizes).for_each(|(s, wall)| *s = s.min(wall));
        let mut kept = walls.tight;
        touching.keep(&mut kept, &solid);
        // Where healing laid sheets side by side everywhere there is nothing to gain in between.
        if TOUCHED * touching.len() > kept.len() {
            kept.fill(true);
        }
        if !touching.is_empty() || MUCH * kept.iter().filter(|k| **k).count() > kept.len() {
            keep_shells(&mut kept, &solid);
        }
        let least = LEAST_BESIDE * sizing.least.min(size);
        let plain = self::sizing(size, solid.bounds().diagonal(), options);
        let near = sizing.chord <= plain.chord.map(|c| STRICT * c);
        let ladder = SoupLadder::new(&solid, &named, &exact, &touching, size);
        let mut ladder = SoupLadder { sizes, kept, least, near, ..ladder };
        let best = climb(&mut ladder, attempts, run)?;
        let flaws = best.as_ref().map_or(usize::MAX, SoupTrial::flaws);
        let SoupLadder { kept, end, .. } = ladder;
        if matches!(end, LadderEnd::Strict | LadderEnd::StrictIfBetter) {
            attempts.change(Change::ShorterEdges, "edges farther from the surface than else left triangles at fault");
            let options =
                &MeshOptions { tolerance: Some(SizeRequest::Length(STRICT * wish.tolerance)), ..options.clone() };
            let strict = SoupGoal { options, ..*self }.mesh(attempts, run)?;
            if end == LadderEnd::Strict || strict.flaws < flaws {
                return Ok(strict);
            }
        }
        let left = end == LadderEnd::Left;
        if left {
            report.shortfalls.push(Fault::NotRemeshed);
        }
        let numbers = best.iter().map(|b| b.number).collect();
        let made = best.map(|b| b.made);
        let intersecting = made.as_ref().map(|m| m.report.self_intersections);
        let RemeshedMesh { mesh, seams, corners, .. } =
            made.unwrap_or(RemeshedMesh { mesh: named, ..RemeshedMesh::default() });
        if let Some(first) = kept.iter().position(|k| *k).filter(|_| !left) {
            let count = kept.iter().filter(|k| **k).count();
            let at = solid.mesh.centroid(first as u32).to_array();
            report.shortfalls.push(Fault::Kept { triangles: count, at });
        }
        report.stage("mesh", mesh.triangles.len(), &mut timer, run);
        run.progress("check", 0.0);
        let against = options.measure.then(|| Against::new(&solid));
        let expected = Expectation { open, touching: false };
        let measured = check_tested(&mesh, intersecting, expected, against, run)?;
        if open {
            report.warnings.push("the surface is open: its border is kept".into());
        }
        if !touching.is_empty() {
            report.shortfalls.push(Fault::Touching { triangles: touching.len() });
        }
        report.judge(measured, wish.tolerance);
        report.stage("check", mesh.triangles.len(), &mut timer, run);
        let source = MeshOrigin::Triangles(Arc::new(solid));
        let meshed = Meshed { mesh, seams, corners, outline: None, report, source };
        Ok(RatedMesh { made: MeshAttempt { meshed, numbers }, flaws })
    }
}

fn tell_removed(solid: &Discrete, report: &mut Report) {
    for r in solid.removed.iter().take(NAMED) {
        let [x, y, z] = r.at;
        let of = if r.what == "face" { "area" } else { "length" };
        report.warnings.push(format!("not kept: {} of {of} {:.4e} at ({x:.6}, {y:.6}, {z:.6})", r.what, r.size));
    }
    if solid.removed.len() > NAMED {
        report.warnings.push(format!("and {} more features not kept", solid.removed.len() - NAMED));
    }
}
