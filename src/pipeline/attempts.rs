//! Which cells the leaf method is tried with: each size is scouted first, by extraction and cut alone, and only what comes
//! out of that well is remeshed.

use std::cmp::Ordering;

use glam::DVec3;

use super::history::{Attempt, Clock, Proof, Tried, add_attempt};
use super::leaf::exact_options;
use super::mesh::{MeshOptions, Ready, nothing_found};
use super::method::Method;
use super::touching::draw_apart;
use crate::error::{Error, Result};
use crate::geometry::Pieces;
use crate::implicit::{
    CellGrid, Extracted, ImplicitOracle, SurfacePoint, Trimmed, arranged, drop_splinters, surface_points, trimmed,
};
use crate::mesh::{TriMesh, self_intersections};
use crate::optimize::exact::{CutReport, ExactMesh, Observer, Patchwork, Raw, cut_pieces, patch_pieces, remesh_cut};
use crate::quality::Fault;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Cells tried one after the other, as shares of the size: smaller ones where the surface is not found with larger ones.
pub(super) const CELLS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// The grid of an arrangement has cells of so many sizes: it is smaller where it must be, and the remesher makes triangles of the
/// size wanted in flat places.
pub(super) const ARRANGED: f64 = 2.0;
/// Where the leaves are shown to be arranged simply in cells so many times twice as large, these do: with one, an arrangement takes no more
/// time than marching cubes and a cut. Another one saves nothing on `data/bracket.py`, and costs `data/thread.py` twice as much.
const COARSER: u8 = 1;
/// How often cells around what came out at fault are halved more than elsewhere, one attempt after the other.
const SMALLER: [u8; 4] = [0, 2, 4, 6];
/// With fewer triangles other ways cost a second or two: they are tried before an arrangement is healed. The rings of
/// `tests/leaf.rs` that cross in points of many faces come out clean by cutting.
const CHEAP: usize = 20_000;
/// An arrangement is healed if at most one triangle in so many is at fault.
const MOST_HEALED: usize = 20;
/// And it ends the search if at most one of so many cells is not proved: what it lacks smaller cells lack, too.
const MOST_UNPROVED: usize = 10;
/// No attempt is made with cells that would give more triangles than this after one that gave a sound mesh.
pub(super) const MOST_TRIANGLES: f64 = 1_500_000.0;
/// How many attempts without all edges are remeshed, until one is sound.
const OTHERS: usize = 3;
/// A splinter is lost, and so is the surface when only extracted, if the mesh does not come nearer to it than this many cells:
/// tips of sharp edges are that long.
const LOST: f64 = 3.0;
/// The surface is missed if the finished mesh does not come nearer to one of its points than this share of the size,
const MISSED: f64 = 0.1;
/// or this many times the tolerance where that is wider.
pub(super) const LOOSE: f64 = 2.0;
/// Of what did not come out well that is left aside which lacks more than this many times the exact edges of what was remeshed.
const FAR_WORSE: usize = 4;

/// Those of some things at some place that a mesh does not come near to.
fn far<T: Copy>(mesh: &TriMesh, things: &[T], place: impl Fn(&T) -> DVec3, reach: f64) -> Vec<T> {
    far_from(mesh, things, place, reach, |_, _| true)
}

/// The same of those triangles whose labels `counts` for the thing. The things are few beside the triangles: the tree is theirs.
fn far_from<T: Copy>(
    mesh: &TriMesh,
    things: &[T],
    place: impl Fn(&T) -> DVec3,
    reach: f64,
    counts: impl Fn(&T, u32) -> bool,
) -> Vec<T> {
    if things.is_empty() {
        return Vec::new();
    }
    let places: Vec<DVec3> = things.iter().map(place).collect();
    let tree = Bvh::new(places.iter().map(|p| Aabb::new(*p, *p).grown(reach)).collect());
    let mut away = vec![true; things.len()];
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        tree.overlapping(&Aabb::around(corners), |k| {
            let k = k as usize;
            away[k] = away[k]
                && !(counts(&things[k], mesh.labels[t])
                    && triangle_distance_squared(places[k], corners) <= reach * reach);
        });
    }
    things.iter().zip(away).filter(|x| x.1).map(|x| *x.0).collect()
}

/// How many triangles intersect others.
fn intersecting(mesh: &TriMesh, run: &Run) -> Result<usize> {
    let mut bad: Vec<u32> = self_intersections(mesh, run)?.into_iter().flatten().collect();
    bad.sort_unstable();
    bad.dedup();
    Ok(bad.len())
}

/// Places where an arrangement has smaller cells: so often they are halved more than elsewhere.
struct Smaller<'a> {
    places: &'a [Aabb],
    times: u8,
}

/// What cutting an extraction gave.
type Cutting = (Patchwork, CutReport);

/// What one size of cells gave before remeshing.
#[derive(Clone)]
pub(super) struct Scout {
    /// What was extracted, or made of the leaves' own surfaces.
    pub(super) extracted: Extracted,
    pub(super) cell: f64,
    /// What the shortest edges are a share of: the cells where small things are lost between them.
    finest: f64,
    /// Points of the surface where it may have been missed.
    points: Vec<SurfacePoint>,
    /// Whether some of them, other than tips, were not extracted.
    gone: bool,
    /// Points that the mesh must come near to: see [`drop_splinters`].
    splinters: Vec<DVec3>,
    /// Places without an exact edge, once it is cut, and whether [cutting was given up](CutReport::bridged).
    unresolved: Vec<DVec3>,
    bridged: bool,
    /// What was shown of the arrangement it was made from, if it was,
    pub(super) proof: Option<Proof>,
    /// and whether the solid touches itself there.
    touches: bool,
}

impl Scout {
    fn new(ready: &Ready, cell: f64, mut extracted: Extracted, run: &Run) -> Result<Self> {
        let splinters = drop_splinters(&mut extracted, &ready.model, cell);
        run.progress("look", 0.0);
        run.triangles(extracted.mesh.triangles.len());
        let points = surface_points(&ready.model, &extracted, run)?;
        let gone = !far(&extracted.mesh, &points, |x| x.at, LOST * cell).is_empty();
        let (unresolved, proof) = (Vec::new(), None);
        Ok(Self {
            extracted,
            cell,
            finest: cell,
            points,
            gone,
            splinters,
            unresolved,
            bridged: false,
            proof,
            touches: false,
        })
    }

    fn cut(&mut self, ready: &Ready, run: &Run) -> Result<Cutting> {
        run.progress("cut", 0.0);
        run.triangles(self.extracted.mesh.triangles.len());
        let oracle = ImplicitOracle::new(&ready.model, &self.extracted);
        let cut = cut_pieces(&Raw { mesh: &self.extracted.mesh, cell: self.cell, kept: &[] }, &oracle, run)?;
        (self.unresolved, self.bridged) = (cut.1.unresolved.clone(), cut.1.bridged);
        Ok(cut)
    }

    /// The same cells with each leaf's surface made for itself and cut by the others, where that fits together.
    fn trimmed(&self, ready: &Ready, run: &Run) -> Result<Option<(Self, Cutting)>> {
        run.progress("trim", 0.0);
        run.triangles(self.extracted.mesh.triangles.len());
        let Some(made) = trimmed(&ready.model, &self.extracted, run)? else { return Ok(None) };
        Ok(self.made_anew(ready, made))
    }

    /// The same cells with a mesh in which every triangle lies on one leaf, if it is a manifold.
    fn made_anew(&self, ready: &Ready, made: Trimmed) -> Option<(Self, Cutting)> {
        let mut extracted = self.extracted.clone();
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let cut = patch_pieces(&made.mesh, &made.leaves, &made.faces, &oracle, self.cell).ok()?;
        let mesh = made.mesh;
        let known = |t: usize| made.faces.get(t).copied();
        let face = |t: usize| known(t).or_else(|| oracle.face_at(mesh.labels[t], mesh.centroid(t))).unwrap_or(0);
        extracted.mesh.labels = (0..mesh.triangles.len()).map(face).collect();
        (extracted.mesh.nodes, extracted.mesh.triangles) = (mesh.nodes, mesh.triangles);
        Some((Self { extracted, gone: false, unresolved: Vec::new(), bridged: false, ..self.clone() }, cut))
    }

    /// The boundary of the leaves' arrangement in place of what was extracted; see [`arranged`].
    fn arranged(
        &self,
        ready: &Ready,
        options: &MeshOptions,
        smaller: &Smaller<'_>,
        run: &Run,
    ) -> Result<Option<(Self, Cutting)>> {
        let grid = CellGrid {
            size: ARRANGED * self.cell,
            coarser: COARSER,
            places: smaller.places,
            more: smaller.times,
            block: None,
        };
        let made = match arranged(&ready.model, &grid, options.memory, run) {
            Ok(made) => made,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // Too many cells, or too much in one: there are other ways.
            Err(_) => return Ok(None),
        };
        if made.made.mesh.triangles.is_empty() {
            return Ok(None);
        }
        let (proof, touches) = (Proof::of(&made), made.touches);
        let Some((mut scout, cut)) = self.made_anew(ready, made.made) else { return Ok(None) };
        // Curves are followed as with the smallest cells that are tried else.
        scout.finest = CELLS[CELLS.len() - 1] * self.cell;
        (scout.proof, scout.touches) = (Some(proof), touches);
        Ok(Some((scout, cut)))
    }

    /// What makes one worse than another: parts of the surface that are not there, then places without an exact edge; with
    /// nothing between them, larger cells.
    fn compare(&self, other: &Self) -> Ordering {
        let badness = |s: &Self| (s.gone, s.bridged, s.unresolved.len());
        badness(self).cmp(&badness(other)).then(self.cell.total_cmp(&other.cell))
    }

    fn remesh(
        self,
        cut: Cutting,
        ready: &Ready,
        options: &MeshOptions,
        run: &Run,
        observer: &mut Option<&mut Observer<'_>>,
    ) -> Result<Trial> {
        let oracle = ImplicitOracle::new(&ready.model, &self.extracted);
        let wanted = exact_options(ready, options, self.finest)?;
        let mut exact = remesh_cut(&self.extracted.mesh, cut, &oracle, &wanted, run, observer.as_deref_mut())?;
        let mut drawn = 0;
        if self.touches && exact.report.self_intersections > 0 {
            drawn = draw_apart(&mut exact.mesh, ready.model.bounds().diagonal(), run)?;
            exact.report.self_intersections = intersecting(&exact.mesh, run)?;
        }
        let reach = (MISSED * ready.size).max(LOOSE * options.tolerance.unwrap_or(0.0));
        let missed = far(&exact.mesh, &self.points, |x| x.at, reach);
        let flat = self.flat(&exact.mesh, ready);
        Ok(Trial { exact, missed, flat, scout: self, number: 0, drawn })
    }

    /// Points of faces that a mesh comes near to with other faces only: low caps and shallow dents. Where faces touch or meet,
    /// their points are those of either.
    fn flat(&self, mesh: &TriMesh, ready: &Ready) -> Vec<SurfacePoint> {
        let away = far_from(mesh, &self.points, |x| x.at, LOST * self.cell, |x, label| x.face == label);
        away.into_iter().filter(|x| x.is_alone(&ready.model, &self.extracted)).collect()
    }
}

/// What one size of cells gave.
pub(super) struct Trial {
    pub(super) exact: ExactMesh,
    /// Points of the surface that the mesh does not come near to.
    missed: Vec<SurfacePoint>,
    /// Points of faces that it comes near to with other faces only.
    flat: Vec<SurfacePoint>,
    pub(super) scout: Scout,
    /// Its place in the list of attempts.
    number: usize,
    /// Nodes that were drawn back where the solid touches itself.
    pub(super) drawn: usize,
}

impl Trial {
    fn badness(&self) -> (usize, bool, usize) {
        let lacking = self.scout.unresolved.len() + self.exact.report.astray.len() + self.flat.len();
        (self.faults(), !self.missed.is_empty(), lacking)
    }

    /// Adds itself to the attempts.
    fn told(mut self, tried: Tried, attempts: &mut Vec<Attempt>, clock: &mut Clock, run: &Run) -> Self {
        self.number = attempts.len();
        let attempt = Attempt::new(tried, self.scout.cell, self.exact.mesh.triangles.len(), self.faults(), clock);
        let attempt = Attempt { proof: self.scout.proof.clone(), ..attempt };
        let edges_missing = self.exact.report.cut.unresolved.len();
        let lacks = [
            (!self.missed.is_empty(), "some of the surface is not in the mesh"),
            (!self.flat.is_empty(), "a face is passed over"),
            (!self.exact.report.astray.is_empty(), "borders go astray"),
            (self.lost().is_some(), "something is thinner than the cells"),
        ];
        let lacks: Vec<&str> = lacks.iter().filter(|l| l.0).map(|l| l.1).collect();
        add_attempt(attempts, Attempt { edges_missing, ..attempt }.because(lacks.join("; ")), run);
        self
    }

    /// Ends the search with this one.
    fn searched(self, crossed: bool, mut attempts: Vec<Attempt>) -> Searched {
        attempts[self.number].kept = true;
        Searched { best: self, crossed, attempts }
    }

    fn is_clean(&self) -> bool {
        self.badness() == (0, false, 0) && self.lost().is_none()
    }

    /// Whether no other attempt is worth it: nothing is wrong, or all was found, so that smaller cells find no more, and what is at
    /// fault can be healed.
    fn ends(&self, options: &MeshOptions) -> bool {
        let found = self.scout.proof.as_ref().is_some_and(|proof| {
            let triangles = self.exact.mesh.triangles.len();
            let few = self.faults() == 0 || (self.can_be_healed() && triangles > CHEAP);
            few && MOST_UNPROVED * proof.unproved <= proof.cells
        });
        found || self.is_clean() || options.method == Method::Complex
    }

    /// Whether it is sound, or of an arrangement with few faults. Where most triangles cross, walls are thinner than the bends of
    /// their edges: healing would tear them.
    fn can_be_healed(&self) -> bool {
        let arranged = self.scout.proof.is_some();
        self.faults() == 0 || (arranged && MOST_HEALED * self.faults() <= self.exact.mesh.triangles.len())
    }

    /// Triangles that intersect others or are turned over.
    pub(super) fn faults(&self) -> usize {
        self.exact.report.self_intersections + self.exact.report.inverted
    }

    /// A splinter that the finished mesh does not come near to, if there is one.
    fn lost(&self) -> Option<DVec3> {
        far(&self.exact.mesh, &self.scout.splinters, |p| *p, LOST * self.scout.cell).first().copied()
    }

    /// What the mesh lacks, for the report.
    pub(super) fn shortfalls(&self, ready: &Ready) -> Vec<Fault> {
        let unresolved = &self.exact.report.cut.unresolved;
        let face =
            |x: &SurfacePoint| ready.model.faces().get(x.face as usize).map_or_else(String::new, |f| f.name.clone());
        let mut list: Vec<Fault> = Vec::new();
        list.extend(self.missed.first().map(|x| Fault::SurfaceMissing {
            face: face(x),
            at: x.at.to_array(),
            more: self.missed.len() - 1,
        }));
        list.extend(self.flat.first().map(|x| Fault::FaceMissing { face: face(x), at: x.at.to_array() }));
        if !unresolved.is_empty() {
            list.push(Fault::edges_missing(unresolved));
        }
        list.extend(self.lost().map(|p| Fault::Thin { at: p.to_array() }));
        list
    }
}

pub(super) fn at(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

/// What may be tried.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ladder<'a> {
    /// Cells, as shares of the size, the largest first.
    pub(super) cells: &'a [f64],
    /// Whether the leaves' arrangement is.
    pub(super) arrange: bool,
}

impl Ladder<'_> {
    pub(super) const WHOLE: Self = Ladder { cells: &CELLS, arrange: true };
}

/// What a search gave.
pub(super) struct Searched {
    pub(super) best: Trial,
    /// Whether a mesh with all its edges was given up because its triangles crossed.
    pub(super) crossed: bool,
    /// What was tried.
    pub(super) attempts: Vec<Attempt>,
}

/// The part with what is said of attempts at it as they end.
struct Telling<'a> {
    ready: &'a Ready,
    attempts: &'a mut Vec<Attempt>,
    clock: &'a mut Clock,
}

/// The best by the leaves' arrangement with cells of one size, and smaller ones around what comes out at fault: that is smaller than
/// they are.
fn arrange_at(
    scout: &Scout,
    options: &MeshOptions,
    telling: &mut Telling<'_>,
    run: &Run,
    observer: &mut Option<&mut Observer<'_>>,
) -> Result<Option<Trial>> {
    let ready = telling.ready;
    let mut best: Option<Trial> = None;
    let mut places: Vec<Aabb> = Vec::new();
    let mut fewest = usize::MAX;
    for times in SMALLER {
        let Some((made, cut)) = scout.arranged(ready, options, &Smaller { places: &places, times }, run)? else {
            break;
        };
        let this = made.remesh(cut, ready, options, run, observer)?;
        let this = this.told(Tried::Arrange, telling.attempts, telling.clock, run);
        // Where that made no difference, cells are not what is missing.
        let goes_on = this.faults() > 0 && this.can_be_healed() && this.faults() < fewest;
        fewest = fewest.min(this.faults());
        places.extend(this.exact.report.faults.iter().map(|b| b.grown(b.size().max_element())));
        if best.as_ref().is_none_or(|b| this.badness() < b.badness()) {
            best = Some(this);
        }
        if !goes_on {
            break;
        }
    }
    Ok(best)
}

/// The first attempt that comes out clean; otherwise the best: where exact edges were not found everywhere, that with the
/// fewest places without.
pub(super) fn search(
    ready: &Ready,
    options: &MeshOptions,
    ladder: &Ladder<'_>,
    run: &Run,
    observer: &mut Option<&mut Observer<'_>>,
) -> Result<Searched> {
    let mut best: Option<Trial> = None;
    let mut crossed = false;
    // What did not come out well, the best first, cut or still to be.
    let mut others: Vec<(Scout, Option<Cutting>)> = Vec::new();
    let mut first_error = None;
    let arrange = ladder.arrange;
    let cuts = false;
    let (mut attempts, mut clock) = (Vec::new(), Clock::new(options.timed));
    for share in ladder.cells {
        let cell = share * ready.size;
        let known = others.first().map(|s| &s.0).or(best.as_ref().filter(|b| b.faults() == 0).map(|b| &b.scout));
        let triangles = |s: &Scout| s.extracted.mesh.triangles.len() as f64 * (s.cell / cell).powi(2);
        if known.is_some_and(|s| triangles(s) > MOST_TRIANGLES) {
            break;
        }
        let extracted = match ready.extract_any(cell, options, run) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // No memory for smaller cells: the first error tells the user.
            Err(e) => {
                first_error.get_or_insert(e);
                continue;
            }
        };
        let nothing = extracted.mesh.triangles.is_empty();
        let mut scout = Scout::new(ready, cell, extracted, run)?;
        if nothing {
            first_error.get_or_insert(nothing_found(scout.points.first().map(|x| x.at), cell));
        }
        let mut cut = None;
        let mut first = None;
        let mut seconds = Vec::new();
        if arrange {
            let mut telling = Telling { ready, attempts: &mut attempts, clock: &mut clock };
            if let Some(this) = arrange_at(&scout, options, &mut telling, run, observer)? {
                if this.ends(options) {
                    return Ok(this.searched(crossed, attempts));
                }
                crossed |= this.faults() > 0;
                seconds.extend(Some(this).filter(Trial::can_be_healed));
            }
        }
        if cuts && !scout.gone && !nothing {
            // Of the surface as extracted first: it comes out well where nothing is sharper or thinner than the cells.
            cut = Some(scout.cut(ready, run)?);
            if let Some(cut) = cut.take_if(|_| scout.unresolved.is_empty()) {
                let this = scout.clone().remesh(cut, ready, options, run, observer)?;
                let this = this.told(Tried::Cut, &mut attempts, &mut clock, run);
                if this.is_clean() {
                    return Ok(this.searched(crossed, attempts));
                }
                first = Some(this);
            }
        }
        if cuts && first.is_none() && !nothing {
            let (triangles, edges_missing) = (scout.extracted.mesh.triangles.len(), scout.unresolved.len());
            let attempt = Attempt::new(Tried::Cut, cell, triangles, 0, &mut clock);
            let why = if scout.gone { "cells miss some of the surface" } else { "edges are missing: not remeshed" };
            add_attempt(&mut attempts, Attempt { edges_missing, ..attempt }.because(why), run);
        }
        if cuts && let Some((made, cut)) = scout.trimmed(ready, run)? {
            let this = made.remesh(cut, ready, options, run, observer)?;
            let this = this.told(Tried::Trim, &mut attempts, &mut clock, run);
            if this.ends(options) {
                return Ok(this.searched(crossed, attempts));
            }
            crossed |= this.faults() > 0;
            // Faults of a trimmed one cannot be left as extracted.
            seconds.extend(Some(this).filter(Trial::can_be_healed));
        }
        if first.is_none() && !nothing {
            others.push((scout, cut));
            others.sort_by(|a, b| a.0.compare(&b.0));
            others.truncate(OTHERS);
        }
        for this in first.into_iter().chain(seconds) {
            if best.as_ref().is_none_or(|b| this.badness() < b.badness()) {
                best = Some(this);
            }
        }
    }
    // A sound one with its walls lacks no more than a splinter, or some edges.
    for (mut scout, cut) in others {
        if best.as_ref().is_some_and(|b| b.faults() == 0 && b.missed.is_empty()) {
            break;
        }
        let cut = cut.map_or_else(|| scout.cut(ready, run), Ok)?;
        let lacks = |s: &Scout| s.unresolved.len();
        if best.as_ref().is_some_and(|b| !b.scout.gone && lacks(&scout) > FAR_WORSE * lacks(&b.scout).max(1)) {
            continue;
        }
        let this = scout.remesh(cut, ready, options, run, observer)?;
        let this = this.told(Tried::Cut, &mut attempts, &mut clock, run);
        if best.as_ref().is_none_or(|b| this.badness() < b.badness()) {
            best = Some(this);
        }
    }
    let best = best.ok_or_else(|| first_error.unwrap_or_else(|| Error::Failed("no attempt was made".into())))?;
    Ok(best.searched(crossed, attempts))
}
