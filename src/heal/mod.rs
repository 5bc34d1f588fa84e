//! Healing: any triangle mesh to one that is closed, oriented, a manifold and free of self-intersections.
//!
//! Repairs go from gentle to strong, and each rung's result is looked at with exact predicates before the next one:
//!
//! 1. nodes at one place, triangles on a line, duplicates;
//! 2. borders that nearly meet, T-junctions: joined at the smallest of a ladder of tolerances that joins them;
//! 3. fins, orientation;
//! 4. contours of open edges: found by the iteration of \[BOR20\], closed by ear cutting, flips while the area falls, and
//!    refinement to the surrounding size; a filling that would intersect is refused and another way tried;
//! 5. what still intersects: taken out with its surroundings and closed again; drawn back, where a closed surface was pulled
//!    through itself; or cut exactly along its crossings and parted, a gap of 1e-5 of the diagonal wide, into one closed
//!    surface for each level of the winding number, so that nothing is lost; pieces that bound nothing get two sides;
//! 6. where all of this fails, a new surface around everything.
//!
//! *Guarantees*: the same input gives the same bytes for any number of threads; the report says what was done where and
//! whether the result is sound, as measured on the result itself. No node that is away from a defect moves.
//!
//! *Does not guarantee* that the result is sound: see [`HealReport::is_sound`]. Surfaces that were parted may touch in nodes
//! where no gap fits ([`HealReport::touching`]); a format that stores no connectivity welds them there again. Bodies that
//! overlap come out as a surface around all of them and one around what they share: nothing is lost, but the second lies
//! inside the first.
//!
//! \[BOR20\]: O. N. Borisenko et al., "Algorithms of preprocessing singularities in geometric models to generate surface
//! triangular grids in the LOGOS software package preprocessor" (in Russian), 2020.

mod arrange;
mod boolean;
mod clean;
mod contours;
mod exact;
mod fill;
mod fillings;
mod holes;
mod levels;
mod local;
mod onto;
mod planar;
mod report;
mod sides;
mod stitch;
#[cfg(test)]
mod tests;
mod winding;
mod wrap;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::error::{Error, Result};
use crate::geometry::SurfaceOracle;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

pub use arrange::MOST_BODIES;
pub use boolean::{Joined, boolean};
pub use fillings::absorb_fillings;
pub use report::{Action, Defect, HealReport, Repair};

/// Points of the input that are looked for in the result.
pub(crate) const SAMPLES: usize = 20_000;

/// A point of the input is kept if the result passes it within this share of the diagonal.
pub const KEPT_WITHIN: f64 = 1e-4;

/// What to heal.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HealOptions {
    /// Contours of more open edges stay open; `None`: all are closed. A mesh that is to stay open has no inside, so where it
    /// intersects itself is then reported, not repaired.
    pub max_hole: Option<usize>,
}

/// A healed mesh and what was done to it.
#[derive(Debug, Clone)]
pub struct Healed {
    /// The mesh. Triangles that are new lie on a face `filled`.
    pub mesh: TriMesh,
    /// What was found and done.
    pub report: HealReport,
}

/// Heals a mesh; see the module's head.
///
/// # Errors
/// [`Error::Input`] for a mesh that is not [valid](TriMesh::validate); [`Error::Failed`] if nothing is left;
/// [`Error::Cancelled`].
pub fn heal(input: &TriMesh, options: &HealOptions, run: &Run) -> Result<Healed> {
    heal_onto(input, options, None, run)
}

/// Joins borders that lie on each other but for rounding: where such a surface is open it was torn. `None` where nothing is joined.
///
/// # Errors
/// Those of [`heal`].
pub fn join_torn(input: &TriMesh, run: &Run) -> Result<Option<Healed>> {
    input.validate()?;
    let (mut mesh, mut report) = (input.clone(), HealReport::default());
    let diagonal = used_bounds(input).diagonal();
    clean::clean(&mut mesh, &mut report);
    stitch::stitch(&mut mesh, diagonal, stitch::ROUNDED, &mut report, run)?;
    if report.repairs.is_empty() || mesh.triangles.is_empty() {
        return Ok(None);
    }
    clean::orient(&mut mesh, &mut report);
    clean::turn_outward(&mut mesh, &mut report);
    mesh.drop_unused_nodes();
    let pairs = levels::crossings(&mesh, run)?;
    let joined = Tangled { mesh, pairs };
    judge(input, &joined, diagonal, &mut report, run);
    Ok(Some(Healed { mesh: joined.mesh, report }))
}

/// Like [`heal`], for a mesh of a surface somebody knows: new nodes are moved there, as far as nothing turns over or intersects.
///
/// # Errors
/// Those of [`heal`].
pub fn heal_onto(
    input: &TriMesh,
    options: &HealOptions,
    oracle: Option<&dyn SurfaceOracle>,
    run: &Run,
) -> Result<Healed> {
    input.validate()?;
    let mut mesh = input.clone();
    let mut report = HealReport::default();
    let diagonal = used_bounds(input).diagonal();
    run.progress("clean", 0.0);
    clean::clean(&mut mesh, &mut report);
    if mesh.triangles.is_empty() {
        return Err(Error::Failed("no triangle of the mesh has an area".into()));
    }
    run.progress("stitch", 0.0);
    stitch::stitch(&mut mesh, diagonal, f64::INFINITY, &mut report, run)?;
    clean::drop_fins(&mut mesh, &mut report);
    clean::orient(&mut mesh, &mut report);
    run.progress("fill", 0.0);
    let longest = options.max_hole.unwrap_or(usize::MAX);
    let wanted = holes::close_holes(&mut mesh, longest, Defect::Hole, &mut report, run)?.wanted;
    clean::turn_outward(&mut mesh, &mut report);
    let (branching, before) = (branching(&mesh), report.repairs.len());
    let pairs = levels::crossings(&mesh, run)?;
    let mut crossed = Tangled { mesh, pairs };
    if wanted == 0 && !(crossed.pairs.is_empty() && is_closed_manifold(&crossed.mesh)) {
        run.progress("uncross", 0.0);
        crossed = repair(input, crossed, diagonal, &mut report, run)?;
    }
    let Tangled { mut mesh, pairs } = crossed;
    let parted = report.repairs[before..].last().map_or(Action::Left, |r| r.action);
    report.add(Defect::NonManifold, parted, branching.len(), &branching);
    let strays = strays(&mesh);
    report.add(Defect::StrayPiece, Action::Left, strays.len(), &strays);
    if let Some(oracle) = oracle {
        run.progress("project", 0.0);
        onto::onto(&mut mesh, oracle, &mut report, run)?;
    }
    mesh.drop_unused_nodes();
    let crossed = Tangled { mesh, pairs };
    judge(input, &crossed, diagonal, &mut report, run);
    Ok(Healed { mesh: crossed.mesh, report })
}

/// A mesh, and the pairs of its triangles that intersect.
struct Tangled {
    mesh: TriMesh,
    pairs: Vec<[u32; 2]>,
}

/// How far surfaces draw back from each other, as a share of the diagonal: a tenth of what counts as kept, and enough for the
/// single precision of STL files.
const GAP: f64 = 1e-5;

/// A result that keeps less of the input is taken only if there is no other: it is another surface rather than a healed one.
pub(crate) const ENOUGH: f64 = 0.98;

fn is_closed_manifold(mesh: &TriMesh) -> bool {
    let d = mesh.defects();
    d.is_closed() && d.is_manifold() && d.is_oriented()
}

/// Where more than two triangles meet in an edge or more than one fan in a node.
fn branching(mesh: &TriMesh) -> Vec<DVec3> {
    let d = mesh.defects();
    let node = |v: u32| mesh.nodes[v as usize];
    let edges = d.nonmanifold_edges.iter().map(|[a, b]| 0.5 * (node(*a) + node(*b)));
    edges.chain(d.nonmanifold_nodes.iter().map(|v| node(*v))).collect()
}

/// A piece of less than this share of the area, a hundredth as long as the whole, is too small to mean anything.
const STRAY_SHARE: f64 = 1e-4;

/// Centers of pieces too small to mean anything. They may be what somebody drew, so they are only named.
fn strays(mesh: &TriMesh) -> Vec<DVec3> {
    let sides = sides::Sides::of(&mesh.triangles);
    let (piece, count) = sides::pieces(mesh.triangles.len(), &sides, |_| true);
    let area = clean::areas(mesh, &piece, count);
    let total: f64 = area.iter().sum();
    let mut middle = vec![(DVec3::ZERO, 0.0); count];
    for (t, p) in piece.iter().enumerate() {
        let sum = &mut middle[*p as usize];
        *sum = (sum.0 + mesh.centroid(t), sum.1 + 1.0);
    }
    (0..count).filter(|p| area[*p] < STRAY_SHARE * total).map(|p| middle[p].0 / middle[p].1).collect()
}

/// Whether nothing is wrong.
fn is_sound(mesh: &TriMesh, run: &Run) -> Result<bool> {
    Ok(is_closed_manifold(mesh) && levels::crossings(mesh, run)?.is_empty())
}

/// Contours are closed whatever the filling intersects where they span less than this share of their piece.
const NEARLY_CLOSED: f64 = 0.2;

/// Repairs what gentle steps left. Each way is taken only if its result is sound; in this order:
///
/// - what intersects is taken out and filled again, if that keeps enough and no closed pieces cross each other;
/// - what was pulled through the rest of a closed surface, and is stretched by it, is drawn back: the topology is right there;
/// - everything is cut along its crossings and parted; nearly closed pieces are closed first;
/// - the same, with all open pieces as sheets;
/// - taken out and filled again, whatever is lost;
/// - a new surface around everything.
///
/// Returns the mesh with those triangles that still intersect.
fn repair(input: &TriMesh, crossed: Tangled, diagonal: f64, report: &mut HealReport, run: &Run) -> Result<Tangled> {
    let Tangled { mesh, pairs } = crossed;
    let sound = |mesh: TriMesh| Ok(Tangled { mesh, pairs: Vec::new() });
    let solids_cross = solids_cross(&mesh, &pairs);
    let mut refilled = None;
    if let Some((m, places)) = local::refill(&mesh, &pairs, run)?
        && is_sound(&m, run)?
    {
        let kept = kept(input, &m, KEPT_WITHIN * diagonal, run);
        if kept >= ENOUGH && !solids_cross {
            report.add(Defect::SelfIntersection, Action::Refilled, places.len(), &places);
            return sound(m);
        }
        refilled = Some((m, places, kept));
    }
    if is_closed_manifold(&mesh)
        && !solids_cross
        && let Some((m, places)) = local::draw_back(&mesh, run)?
    {
        report.add(Defect::SelfIntersection, Action::DrawnBack, places.len(), &places);
        return sound(m);
    }
    let mut best: Option<(TriMesh, HealReport, f64)> = None;
    for force in [true, false] {
        let (mut m, mut r) = (mesh.clone(), report.clone());
        if force {
            let places = holes::force_holes(&mut m, NEARLY_CLOSED)?;
            if places.is_empty() {
                continue;
            }
            r.add(Defect::Hole, Action::FilledOtherwise, places.len(), &places);
        }
        if let Some(m) = uncross(&m, diagonal, &mut r, run)? {
            let kept = kept(input, &m, KEPT_WITHIN * diagonal, run);
            if kept >= ENOUGH {
                *report = r;
                return sound(m);
            }
            if best.as_ref().is_none_or(|b| kept > b.2) {
                best = Some((m, r, kept));
            }
        }
    }
    if let Some((m, places, kept)) = refilled
        && best.as_ref().is_none_or(|b| kept > b.2)
    {
        report.add(Defect::SelfIntersection, Action::Refilled, places.len(), &places);
        return sound(m);
    }
    if let Some((m, r, _)) = best {
        *report = r;
        return sound(m);
    }
    let m = wrap::wrap(&mesh, run)?;
    if is_sound(&m, run)? {
        let all: Vec<DVec3> = mesh.nodes.clone();
        report.add(Defect::SelfIntersection, Action::Rebuilt, mesh.triangles.len(), &all);
        return sound(m);
    }
    Ok(Tangled { mesh, pairs })
}

/// Pieces that share no node, whether each is closed, and the piece of each triangle.
fn closed_pieces(mesh: &TriMesh) -> (Vec<u32>, Vec<bool>) {
    let sides = sides::Sides::of(&mesh.triangles);
    let (piece, count) = sides::pieces(mesh.triangles.len(), &sides, |_| true);
    let mut solid = vec![true; count];
    for e in sides.edges() {
        if !clean::balanced(&mesh.triangles, e) {
            solid[piece[e[0].triangle()] as usize] = false;
        }
    }
    (piece, solid)
}

/// Whether some of the pairs of triangles are of different closed pieces.
fn solids_cross(mesh: &TriMesh, pairs: &[[u32; 2]]) -> bool {
    let (piece, solid) = closed_pieces(mesh);
    let of = |t: u32| piece[t as usize];
    let differ = |a: u32, b: u32| a != b && solid[a as usize] && solid[b as usize];
    pairs.iter().any(|[t, u]| differ(of(*t), of(*u)))
}

/// Cuts triangles along their intersections and parts what crosses; pieces that do not close become sheets of a small
/// thickness. `None` if this does not come out.
fn uncross(mesh: &TriMesh, diagonal: f64, report: &mut HealReport, run: &Run) -> Result<Option<TriMesh>> {
    let (piece, solid) = closed_pieces(mesh);
    let uses = |t: usize| {
        let solid = solid[piece[t] as usize];
        arrange::Uses { along: u16::from(solid), sheet: !solid, label: mesh.labels[t], ..arrange::Uses::default() }
    };
    let triangles = mesh.triangles.iter().enumerate().map(|(t, tri)| (*tri, uses(t)));
    let complex = arrange::Complex::new(mesh.nodes.clone(), triangles);
    let Some(complex) = arrange::arrange(complex, diagonal, run)? else { return Ok(None) };
    let Some(made) = levels::levels(&complex, &mesh.faces, GAP * diagonal, run)? else { return Ok(None) };
    if !is_sound(&made.mesh, run)? {
        return Ok(None);
    }
    report.add(Defect::SelfIntersection, Action::Uncrossed, made.parted.len(), &made.parted);
    report.add(Defect::OpenSheet, Action::Thickened, made.plates.len(), &made.plates);
    let mut out = made.mesh;
    out.groups = mesh.groups.clone();
    Ok(Some(out))
}

fn used_bounds(mesh: &TriMesh) -> Aabb {
    Aabb::around(mesh.triangles.iter().flatten().map(|v| mesh.nodes[*v as usize]))
}

/// Measures the result.
fn judge(input: &TriMesh, crossed: &Tangled, diagonal: f64, report: &mut HealReport, run: &Run) {
    let Tangled { mesh, pairs } = crossed;
    run.progress("measure", 0.0);
    let d = mesh.defects();
    report.closed = d.is_closed() && !mesh.triangles.is_empty();
    report.manifold = d.is_manifold();
    report.oriented = d.is_oriented();
    let mut hit: Vec<u32> = pairs.as_flattened().to_vec();
    hit.sort_unstable();
    hit.dedup();
    report.self_intersections = hit.len();
    report.touching = clean::weld(&mut mesh.clone()).len();
    report.kept = kept(input, mesh, KEPT_WITHIN * diagonal, run);
    for (good, what) in [
        (report.closed, "the result is not closed"),
        (report.manifold, "the result is not a manifold"),
        (report.oriented, "the result is not consistently oriented"),
        (report.self_intersections == 0, "the result intersects itself"),
        (report.touching == 0, "surfaces of the result touch"),
    ] {
        if !good {
            report.shortfalls.push(what.into());
        }
    }
}

/// Share of the input's area within `tolerance` of the mesh, at evenly spread points.
fn kept(input: &TriMesh, mesh: &TriMesh, tolerance: f64, run: &Run) -> f64 {
    let total = input.area();
    if !(total > 0.0) || mesh.triangles.is_empty() {
        return 0.0;
    }
    // triangles that are still there need no search
    let places = |m: &TriMesh, t: usize| {
        let mut p = m.corners(t).map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        p.sort_unstable();
        p
    };
    let same: FxHashSet<[[u64; 3]; 3]> = (0..mesh.triangles.len()).map(|t| places(mesh, t)).collect();
    // one point each `step` of area, the triangles laid end to end
    let step = total / SAMPLES as f64;
    let mut points: Vec<DVec3> = Vec::new();
    let (mut sum, mut next, mut count) = (0.0, 0.5 * step, 0usize);
    for t in 0..input.triangles.len() {
        sum += 0.5 * input.area_vector(t).length();
        if next >= sum {
            continue;
        }
        let gone = !same.contains(&places(input, t));
        let [a, b, c] = input.corners(t);
        while next < sum {
            // the R2 sequence of M. Roberts (2018): even without a seed
            let i = count as f64;
            let (mut u, mut v) =
                ((0.5 + i * 0.754_877_666_246_692_8).fract(), (0.5 + i * 0.569_840_290_998_053_2).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            if gone {
                points.push(a + u * (b - a) + v * (c - a));
            }
            count += 1;
            next += step;
        }
    }
    if points.is_empty() {
        return 1.0;
    }
    let bvh = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let near = |p: &DVec3| {
        let mut found = false;
        bvh.overlapping(&Aabb::new(*p, *p).grown(tolerance), |t| {
            found = found || triangle_distance_squared(*p, mesh.corners(t as usize)) <= tolerance * tolerance;
        });
        found
    };
    let missed = run.install(|| points.par_iter().filter(|p| !near(p)).count());
    1.0 - missed as f64 / count as f64
}
