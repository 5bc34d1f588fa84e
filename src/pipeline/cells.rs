//! Which cells the leaf method is tried with: the leaves' arrangement on ever smaller ones, around what comes out at fault first, then
//! everywhere.

use std::sync::Arc;

use glam::DVec3;

use super::crossed::{ROOM, crossed, with_all_along};
use super::history::Proof;
use super::ladder::{Attempts, Change, Ladder, LadderState, climb};
use super::leaf::remesh_options;
use super::mesh::{Ready, nothing_found};
use super::missed::{far, far_from_own, unproved_around};
use super::options::MeshOptions;
use super::touching::draw_apart;
use super::trial::Trial;
use crate::error::{Error, Result};
use crate::implicit::{
    Arranged, CellGrid, Extracted, ImplicitOracle, SurfacePoint, arranged, drop_splinters, surface_points,
};
use crate::mesh::{TriMesh, intersecting_triangles};
use crate::remesh::{InPieces, Observer, Patchwork, RemeshTarget, patch_pieces, remesh_patchwork};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Cells tried one after the other, as shares of the size: smaller ones where the surface is not found with larger ones.
pub(super) const CELLS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// The grid of an arrangement has cells of so many sizes: it is smaller where it must be, and the remesher makes triangles of the
/// size wanted in flat places.
pub(super) const ARRANGED: f64 = 2.0;
/// Where the leaves are shown to be arranged simply in cells so many times twice as large, these do: with one, an arrangement takes no more
/// time than marching cubes and a cut. Another one saves nothing on `data/bracket.py`, and costs `data/thread.py` twice as much.
pub(super) const COARSER: u8 = 1;
/// How often cells around what came out at fault are halved more than elsewhere, one attempt after the other.
const SMALLER: [u8; 4] = [0, 2, 4, 6];
/// With fewer triangles smaller cells cost a second or two: they are tried before an arrangement is healed. Around faults they are tried once
/// in larger meshes, too, as they part surfaces that run side by side.
pub(super) const CHEAP: usize = 20_000;
/// An arrangement is healed if at most one triangle in so many is at fault.
pub(super) const MOST_HEALED: usize = 20;
/// Where smaller cells are not [cheap](CHEAP), what has no faults ends the search if at most one of so many cells is not proved. Such cells are the smallest, so their share in all cells is far above
/// that of the surface in them; large trees with blends have one in five to ten, and smaller cells gave them no better edges.
pub(super) const MOST_UNPROVED_OF_MANY: usize = 4;
/// No attempt is made with cells that would give more triangles than this after one that gave a sound mesh.
pub(super) const MOST_TRIANGLES: f64 = 1_500_000.0;
/// A splinter is lost, and so is the surface when only extracted, if the mesh does not come nearer to it than this many cells:
/// tips of sharp edges are that long.
pub(super) const LOST: f64 = 3.0;
/// The surface is missed if the finished mesh does not come nearer to one of its points than this share of the size,
const MISSED: f64 = 0.1;
/// or this many times the tolerance where that is wider.
pub(super) const LOOSE: f64 = 2.0;
/// Around points that an arrangement lacks cells are smaller within this share of a cell, as wide as the smallest cells elsewhere.
const LACKING: f64 = 0.125;
/// They are not halved again where that many times the cells were not enough: an arrangement takes a quarter of the time of an attempt.
const MOST_GROWN: usize = 2;
/// How often triangles stay around what is at fault.
const KEPT: usize = 4;
/// Beside triangles that stay edges are as long as theirs, but not shorter than this share of the size.
const LEAST_BESIDE: f64 = 0.05;

/// Cells that are tried: which [share](CELLS) of the size, and how much smaller around places that came out at fault.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Start {
    /// Which of [`CELLS`].
    pub(super) share: usize,
    /// Which of [`SMALLER`].
    pub(super) times: usize,
    /// Where they are smaller.
    pub(super) places: Vec<Aabb>,
    /// Where triangles stay as they come from the arrangement.
    kept: Vec<Aabb>,
}

impl Start {
    /// All cells, of the largest share below one that is known.
    pub(super) fn below(cell: f64, size: f64) -> Self {
        let share = CELLS.iter().position(|share| share * size < 0.75 * cell).unwrap_or(CELLS.len());
        Self { share, ..Self::default() }
    }

    /// Whether cells are the same, whatever stays as it comes.
    fn has_cells_of(&self, other: &Self) -> bool {
        (self.share, self.times, &self.places) == (other.share, other.times, &other.places)
    }

    /// Whether triangles stay as they come somewhere.
    pub(super) fn keeps(&self) -> bool {
        !self.kept.is_empty()
    }

    /// How many shares there are from here on.
    pub(super) fn left(&self) -> usize {
        CELLS.len().saturating_sub(self.share)
    }
}

/// Nodes made on stand-ins are put in place within this share of the size: five times as far as these are off.
const IN_PLACE: f64 = 0.01;

/// What one size of cells gave before remeshing.
#[derive(Clone)]
pub(super) struct Scout {
    /// What was extracted, or made of the leaves' own surfaces.
    pub(super) extracted: Extracted,
    pub(super) cell: f64,
    /// What the shortest edges are a share of: the cells where small things are lost between them.
    finest: f64,
    /// Points of the surface where it may have been missed, once these were looked for.
    points: Option<Vec<SurfacePoint>>,
    /// Points that the mesh must come near to: see [`drop_splinters`].
    pub(super) splinters: Vec<DVec3>,
    /// What was shown of the arrangement it was made from, if it was,
    pub(super) proof: Option<Proof>,
    /// and whether the solid touches itself there.
    touches: bool,
}

impl Scout {
    fn new(ready: &Ready, cell: f64, mut extracted: Extracted) -> Self {
        let splinters = drop_splinters(&mut extracted, &ready.asked, cell);
        Self { extracted, cell, finest: cell, points: None, splinters, proof: None, touches: false }
    }

    /// Looks for points of the surface where an arrangement is not proved; elsewhere nothing is missed.
    fn look(&mut self, made: &Arranged, ready: &Ready, run: &Run) -> Result<()> {
        if self.points.is_some() {
            return Ok(());
        }
        run.progress("look", 0.0);
        let within: Vec<Aabb> = made.unproved.iter().map(|u| u.cell).collect();
        self.points = Some(surface_points(&ready.asked, &self.extracted, Some(&within), run)?);
        Ok(())
    }

    /// The boundary of the leaves' arrangement in place of what was extracted, in patches. Triangles stay as they come where `start`
    /// says so.
    fn with(
        &self,
        mut arranged: Arranged,
        ready: &Ready,
        start: &Start,
        run: &Run,
    ) -> Result<Option<(Self, Patchwork)>> {
        arranged.retreat(&start.kept, run)?;
        let (proof, touches) = (Proof::of(&arranged), arranged.touches);
        let mut extracted = self.extracted.clone();
        let oracle = ImplicitOracle::new(&ready.asked, &extracted);
        let made = arranged.made;
        let given = InPieces { mesh: &made.mesh, on: &made.leaves, faces: &made.faces, stays: &start.kept };
        let Ok(mut work) = patch_pieces(&given, &oracle, self.cell) else {
            return Ok(None);
        };
        work.freeze_near(&start.kept, LEAST_BESIDE * ready.size);
        let mesh = made.mesh;
        extracted.mesh.labels = made.faces;
        (extracted.mesh.nodes, extracted.mesh.triangles) = (mesh.nodes, mesh.triangles);
        // Curves are followed as with the smallest cells that are tried else.
        let finest = CELLS[CELLS.len() - 1] * self.cell;
        Ok(Some((Self { extracted, finest, proof: Some(proof), touches, ..self.clone() }, work)))
    }

    fn remesh(
        self,
        work: Patchwork,
        ready: &Ready,
        options: &MeshOptions,
        run: &Run,
        observer: &mut Option<&mut Observer<'_>>,
    ) -> Result<Trial> {
        let wanted = remesh_options(ready, options, self.finest)?;
        let oracle = ImplicitOracle::new(&ready.asked, &self.extracted);
        let target = RemeshTarget { surface: &oracle, names: &self.extracted.mesh };
        let mut exact = remesh_patchwork(work, target, &wanted, run, observer.as_deref_mut())?;
        if !Arc::ptr_eq(&ready.asked, &ready.model) {
            let reach = IN_PLACE * ready.size;
            run.install(|| ready.model.put_in_place(&mut exact.mesh, &exact.pieces, reach));
            exact.report.self_intersections = intersecting_triangles(&exact.mesh, run)?.len();
        }
        let mut drawn = 0;
        if self.touches && exact.report.self_intersections > 0 {
            drawn = draw_apart(&mut exact.mesh, ready.model.bounds().diagonal(), run)?;
            exact.report.self_intersections = intersecting_triangles(&exact.mesh, run)?.len();
        }
        let missed = self.missed(&exact.mesh, ready, options);
        let flat = self.flat(&exact.mesh, ready);
        let crossed = crossed(&exact, run)?;
        Ok(Trial { exact, missed, flat, scout: self, start: Start::default(), crossed, number: 0, drawn })
    }

    fn points(&self) -> &[SurfacePoint] {
        self.points.as_deref().unwrap_or_default()
    }

    /// Points of the surface that a mesh does not come near to.
    fn missed(&self, mesh: &TriMesh, ready: &Ready, options: &MeshOptions) -> Vec<SurfacePoint> {
        let reach = (MISSED * ready.size).max(LOOSE * options.tolerance_length().unwrap_or(0.0));
        let mut missed = far(mesh, self.points(), |x| x.at, reach);
        missed.retain(|x| !x.is_in_passing(&ready.asked));
        missed
    }

    /// Points that an arrangement lacks: those of the surface, and those of faces.
    fn lacking(&self, arranged: &Arranged, ready: &Ready, options: &MeshOptions) -> Vec<SurfacePoint> {
        let mesh = TriMesh { labels: arranged.made.faces.clone(), ..arranged.made.mesh.clone() };
        let mut all = self.missed(&mesh, ready, options);
        all.extend(self.flat(&mesh, ready));
        all
    }

    /// Points of faces that a mesh comes near to with other faces only: low caps and shallow dents. Where faces touch or meet,
    /// their points are those of either.
    fn flat(&self, mesh: &TriMesh, ready: &Ready) -> Vec<SurfacePoint> {
        let away = far_from_own(mesh, self.points(), LOST * self.cell);
        away.into_iter().filter(|x| x.is_alone(&ready.asked, &self.extracted)).collect()
    }
}

pub(super) fn at(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

/// The cells that the leaf method is tried with, the largest first: smaller ones around what comes out at fault, then everywhere.
pub(super) struct CellLadder<'a, 'o> {
    pub(super) ready: &'a Ready,
    pub(super) options: &'a MeshOptions,
    observer: Option<&'a mut Observer<'o>>,
    start: Start,
    scout: Option<Scout>,
    /// The last arrangement of the same share, and of which cells it is.
    arranged: Option<(Start, Arranged)>,
    /// The fewest faults with cells of the same share,
    fewest: usize,
    /// and with those of the shares before.
    fewest_before: usize,
    /// Whether smaller cells everywhere left no fewer triangles at fault.
    pub(super) is_exhausted: bool,
    /// Whether cells of this share are smaller where triangles were at fault,
    at_faults: bool,
    /// and where they were when none stayed.
    faulty: Vec<Aabb>,
    /// How often triangles stayed, and how many were at fault the last time.
    times_kept: usize,
    crossing: Option<usize>,
    /// Whether nothing smaller is worth it once smaller cells around places change nothing.
    over: bool,
    /// Triangles of the extraction that gave a mesh without faults, and its cells.
    sound: Option<(usize, f64)>,
    /// The first error: of all that are met it tells the user most.
    error: Option<Error>,
    /// Triangles of the last attempt that intersect others, and that are turned over.
    pub(super) faults: [usize; 2],
}

impl<'a, 'o> CellLadder<'a, 'o> {
    pub(super) fn new(ready: &'a Ready, options: &'a MeshOptions, start: Start) -> Self {
        Self {
            ready,
            options,
            observer: None,
            start,
            scout: None,
            arranged: None,
            fewest: usize::MAX,
            fewest_before: usize::MAX,
            is_exhausted: false,
            at_faults: false,
            faulty: Vec::new(),
            times_kept: 0,
            crossing: None,
            over: false,
            sound: None,
            error: None,
            faults: [0; 2],
        }
    }

    /// With someone who looks at meshes on their way.
    pub(super) fn observed(self, observer: Option<&'a mut Observer<'o>>) -> Self {
        Self { observer, ..self }
    }

    /// For a part of which smaller cells are known to leave no fewer triangles at fault: not tried again.
    pub(super) fn exhausted(self) -> Self {
        Self { fewest_before: 0, ..self }
    }

    /// The first attempt that comes out clean, otherwise the best one; none where most triangles cross with all cells.
    ///
    /// Errors: where there is nothing, or too much for the memory; cancellation.
    pub(super) fn search(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Trial>> {
        let before = attempts.len();
        let best = climb(self, attempts, run)?;
        match self.error.take() {
            Some(e) if attempts.len() == before => Err(e),
            _ => Ok(best),
        }
    }

    fn go_on(&mut self) {
        self.start = Start { share: self.start.share + 1, ..Start::default() };
        self.fewest_before = self.fewest.min(self.fewest_before);
        (self.scout, self.arranged, self.fewest, self.times_kept) = (None, None, usize::MAX, 0);
        self.at_faults = false;
    }

    /// The cells of the best attempt, with triangles that stay around those at fault in the last one. An attempt of larger cells is not gone
    /// back to: it had its turn.
    fn keep(&mut self, best: &Trial, last: &Trial) -> Option<Start> {
        let again = last.start.keeps();
        let now = if again || best.start.share != last.start.share { last } else { best };
        let stuck = again && self.crossing == Some(now.faults());
        // Where all is proved it is chords that cross, of walls thinner than these are high: shorter edges part them.
        let is_proved = now.scout.proof.as_ref().is_some_and(|p| p.unproved == 0);
        if now.faults() == 0 || !now.can_be_healed() || self.times_kept == KEPT || stuck || is_proved {
            return None;
        }
        self.crossing = again.then(|| now.faults());
        self.times_kept += 1;
        let far = self.times_kept as f64 * ROOM;
        let grown = now.crossed.iter().map(|(b, length)| b.grown(far * length));
        let kept = now.start.kept.iter().copied().chain(grown).collect();
        Some(Start { kept, ..now.start.clone() })
    }

    /// The arrangement of the leaves; see [`arranged`]. None where there is none, or where it is as it was.
    fn arrange(&mut self, cell: f64, run: &Run) -> Result<Option<Arranged>> {
        if let Some((of, before)) = self.arranged.as_ref().filter(|_| self.start.keeps())
            && of.has_cells_of(&self.start)
        {
            return Ok(Some(before.clone()));
        }
        let Some(made) = self.arrange_once(cell, &self.start, None, run)? else { return Ok(None) };
        if let Some(scout) = &mut self.scout {
            scout.look(&made, self.ready, run)?;
        }
        let made = self.with_what_lacks(cell, made, run)?;
        let mut made = self.with_what_crosses(cell, made, run)?;
        made.forget();
        // Where all is proved at those places cells are as they were, and the rest would be, too.
        let as_before = self.arranged.as_ref().is_some_and(|b| b.1.made.mesh == made.made.mesh && !self.start.keeps());
        if as_before || made.made.mesh.triangles.is_empty() {
            return Ok(None);
        }
        self.arranged = Some((self.start.clone(), made.clone()));
        Ok(Some(made))
    }

    /// None where there are too many cells, or too much in one: there are other ways.
    fn arrange_once(&self, cell: f64, start: &Start, before: Option<&Arranged>, run: &Run) -> Result<Option<Arranged>> {
        let grid = CellGrid {
            size: ARRANGED * cell,
            coarser: COARSER,
            places: &start.places,
            more: SMALLER[start.times],
            block: None,
            before,
        };
        match arranged(&self.ready.asked, &grid, self.options.memory, run) {
            Ok(made) => Ok(Some(made)),
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Err(_) => Ok(None),
        }
    }

    /// An arrangement with smaller cells around points that it lacks, as long as that shows more of them. Where many cells are not proved
    /// it is no detail that lacks, and all cells have to be smaller.
    fn with_what_lacks(&mut self, cell: f64, mut made: Arranged, run: &Run) -> Result<Arranged> {
        let few = |made: &Arranged| MOST_UNPROVED_OF_MANY * made.unproved.len() <= made.cells;
        let Some(scout) = self.scout.as_ref().filter(|_| !made.unproved.is_empty() && few(&made)) else {
            return Ok(made);
        };
        let mut lacking = scout.lacking(&made, self.ready, self.options);
        let (mut start, mut best) = (self.start.clone(), self.start.clone());
        while !lacking.is_empty() && start.times + 1 < SMALLER.len() && !made.unproved.is_empty() {
            start.times += 1;
            start.places.extend(unproved_around(&made, &lacking, LACKING * cell));
            let Some(finer) = self.arrange_once(cell, &start, Some(&made), run)? else { break };
            let left = scout.lacking(&finer, self.ready, self.options);
            let grows = finer.cells > MOST_GROWN * made.cells;
            if left.len() < lacking.len() {
                (made, lacking, best) = (finer, left, start.clone());
            }
            if grows {
                break;
            }
        }
        self.start = best;
        Ok(made)
    }

    /// An arrangement with smaller cells where its triangles cross, as long as fewer do, if there are more than can be healed, as what is made of
    /// such a one has as many. In large meshes, which have a quarter of its triangles, once wherever some cross: in random trees nearly all
    /// faults of a mesh are there. In small ones another attempt costs little, and half of such places come out right as they are.
    fn with_what_crosses(&mut self, cell: f64, mut made: Arranged, run: &Run) -> Result<Arranged> {
        let is_worth_it = |made: &Arranged, times: usize| {
            let triangles = made.made.mesh.triangles.len();
            let least = if times == 0 && triangles > 4 * CHEAP { 0 } else { triangles / MOST_HEALED };
            made.crossed.len() > least && 2 * made.unproved.len() <= made.cells
        };
        while is_worth_it(&made, self.start.times) && !made.unproved.is_empty() && self.start.times + 1 < SMALLER.len()
        {
            let mut start = Start { times: self.start.times + 1, ..self.start.clone() };
            start.places.extend(made.crossed.iter().map(|(b, length)| b.grown(*length)));
            match self.arrange_once(cell, &start, Some(&made), run)? {
                Some(finer) if finer.crossed.len() < made.crossed.len() => (made, self.start) = (finer, start),
                _ => break,
            }
        }
        Ok(made)
    }

    /// What the cells tell before leaves are arranged; `None` where they are too many, or there is no memory for them.
    fn scout(&mut self, share: f64, run: &Run) -> Result<Option<Scout>> {
        let cell = share * self.ready.size;
        if self.sound.is_some_and(|(triangles, of)| triangles as f64 * (of / cell).powi(2) > MOST_TRIANGLES) {
            self.start.share = CELLS.len();
            return Ok(None);
        }
        let extracted = match self.ready.extract_any(&self.ready.asked, cell, self.options, run) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(e) => {
                self.error.get_or_insert(e);
                return Ok(None);
            }
        };
        let nothing = extracted.mesh.triangles.is_empty();
        let scout = Scout::new(self.ready, cell, extracted);
        if nothing {
            let points = surface_points(&self.ready.asked, &scout.extracted, None, run)?;
            self.error.get_or_insert(nothing_found(points.first().map(|x| x.at), cell));
        }
        Ok(Some(scout))
    }
}

impl Ladder for CellLadder<'_, '_> {
    type Made = Trial;

    fn attempt(&mut self, attempts: &mut Attempts, run: &Run) -> Result<Option<Trial>> {
        while let Some(share) = CELLS.get(self.start.share).copied() {
            if self.scout.is_none() {
                self.scout = self.scout(share, run)?;
            }
            let cell = self.scout.as_ref().map(|s| s.cell);
            let made = match cell {
                Some(cell) => self.arrange(cell, run)?,
                None => None,
            };
            if let Some(made) = made.as_ref().filter(|_| self.start.keeps()) {
                self.start.kept = with_all_along(&made.crossed, std::mem::take(&mut self.start.kept));
            }
            let work = match (made, &self.scout) {
                (Some(made), Some(scout)) => scout.with(made, self.ready, &self.start, run)?,
                _ => None,
            };
            if let Some((made, work)) = work {
                let mut trial = made.remesh(work, self.ready, self.options, run, &mut self.observer)?;
                trial.start = self.start.clone();
                return Ok(Some(trial.told(attempts, run)));
            }
            if self.arranged.is_some() && self.over {
                return Ok(None);
            }
            self.go_on();
            attempts.change(Change::SmallerCells, "there was no arrangement, or none other");
        }
        Ok(None)
    }

    fn is_better(&self, new: &Trial, best: Option<&Trial>) -> bool {
        let Some(best) = best else { return new.ends() || new.can_be_healed() };
        let ends = new.ends() && !best.ends();
        ends || (new.can_be_healed() && new.badness() < best.badness())
    }

    fn next(&mut self, seen: &LadderState<'_, Trial>) -> Option<(Change, &'static str)> {
        let LadderState { last, best, .. } = seen;
        self.faults = [last.exact.report.self_intersections, last.exact.report.inverted];
        self.sound = best.filter(|b| b.faults() == 0).map(|b| (b.scout.extracted.mesh.triangles.len(), b.scout.cell));
        // Where smaller cells around them made no difference, cells are not what is missing.
        let goes_on = last.faults() > 0 && last.can_be_healed() && last.faults() < self.fewest;
        self.fewest = self.fewest.min(last.faults());
        // Surfaces run side by side nearer to each other than any cells part.
        let hopeless = !last.can_be_healed() && last.scout.proof.as_ref().is_some_and(|p| 2 * p.unproved > p.cells);
        self.over = hopeless || best.is_some_and(Trial::ends);
        let (is_cheap, keeps) = (last.exact.mesh.triangles.len() <= CHEAP, last.start.keeps());
        if !keeps {
            self.faulty = last.exact.report.faults.iter().map(|b| b.grown(b.size().max_element())).collect();
        }
        // Where an arrangement crossed itself cells are smaller already: in large meshes only once triangles that stay left some at fault.
        let is_worth_it = !self.at_faults && (keeps || self.start.times == 0);
        if goes_on && (is_worth_it || (is_cheap && !keeps)) {
            let places = self.faulty.clone();
            // Where all is proved around faults cells would stay as they are, and so they would where they are as small as they may be.
            let halved = Bvh::new(self.start.places.clone());
            let open = self.arranged.iter().flat_map(|(_, made)| &made.unproved).filter(|u| !halved.meets(&u.cell));
            let open = Bvh::new(open.map(|u| u.cell).collect());
            let is_open = places.iter().any(|b| open.meets(b));
            let times = if is_open { self.start.times.max(1) } else { self.start.times + 1 };
            if times < SMALLER.len() && (is_cheap || is_open) {
                self.start.times = times;
                self.start.places.extend(places);
                self.start.kept.clear();
                self.at_faults = true;
                return Some((Change::SmallerCellsHere, "triangles are at fault"));
            }
        }
        if let Some(kept) = best.and_then(|b| self.keep(b, last)) {
            self.start = kept;
            return Some((Change::KeepHere, "triangles are at fault"));
        }
        // Where smaller cells everywhere left no fewer triangles at fault, still smaller ones do not.
        self.is_exhausted = self.fewest > 0 && self.fewest >= self.fewest_before;
        if self.over || self.is_exhausted {
            return None;
        }
        self.go_on();
        Some((Change::SmallerCells, "the mesh lacks something"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::{ExtractOptions, Implicit, RSystem, Solid, extract};

    #[test]
    fn nothing_is_joined_where_triangles_stay() {
        // Four planes meet in the tip of a pyramid, each three of them in a corner of its own.
        let tip = DVec3::new(0.013, 0.027, 0.5);
        let sides = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y].map(|n| Solid::half_space(n + DVec3::Z, tip));
        let pyramid = sides.into_iter().fold(Solid::cuboid(DVec3::NEG_ONE, DVec3::ONE), |all, side| all & side);
        let (model, run) = (Implicit::new(&pyramid, RSystem::default(), None).unwrap(), Run::new());
        let grid = CellGrid { size: 0.25, coarser: 0, places: &[], more: 0, block: None, before: None };
        let made = arranged(&model, &grid, 1 << 30, &run).unwrap().made;
        let extracted = extract(&model, &ExtractOptions::new(0.25), &run).unwrap();
        let oracle = ImplicitOracle::new(&model, &extracted);
        let patched = |stays: &[Aabb]| {
            let given = InPieces { mesh: &made.mesh, on: &made.leaves, faces: &made.faces, stays };
            patch_pieces(&given, &oracle, 0.25).unwrap().mesh
        };
        let at_tip =
            |mesh: &crate::mesh::EditMesh| mesh.nodes().filter(|v| mesh.point(*v).distance(tip) < 1e-9).count();
        let (joined, held) = (patched(&[]), patched(&[model.bounds()]));
        assert_eq!((at_tip(&joined), at_tip(&held)), (1, 2));
        let corners: Vec<[DVec3; 3]> = held.triangles().map(|t| held.corner_points(t)).collect();
        let given: Vec<[DVec3; 3]> = (0..made.mesh.triangles.len()).map(|t| made.mesh.corners(t)).collect();
        assert_eq!(corners, given);
        assert!(held.nodes().all(|v| !held.is_pinned(v)));
    }
}
