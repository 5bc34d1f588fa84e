//! Which cells the leaf method is tried with: each size is scouted first, by extraction and cut alone, and only what comes
//! out of that well is remeshed.

use std::collections::VecDeque;

use glam::DVec3;

use super::leaf::exact_options;
use super::mesh::{MeshOptions, Ready, nothing_found};
use crate::error::{Error, Result};
use crate::implicit::{Extracted, ImplicitOracle, Wall, drop_splinters, thin_walls};
use crate::mesh::TriMesh;
use crate::optimize::exact::{CutReport, ExactMesh, Observer, Patchwork, Raw, cut_pieces, remesh_cut};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Cells tried one after the other, as shares of the size: smaller ones where borders were not found with larger ones; and
/// whether tips of sharp edges are blunted.
const CELLS: [(f64, bool); 8] =
    [(1.0, false), (1.0, true), (0.5, false), (0.5, true), (0.25, false), (0.25, true), (0.125, false), (0.125, true)];
/// No attempt is made with cells that would give more triangles than this after one that gave a sound mesh.
const MOST_TRIANGLES: f64 = 1_500_000.0;
/// How many attempts without all edges are remeshed, until one is sound.
const OTHERS: usize = 3;
/// Where this many places are left without an exact edge and smaller cells do not halve them, still smaller ones will not
/// either.
const MANY: usize = 100;
/// A splinter is lost, and a wall too when only extracted, if the mesh does not come nearer to it than this many cells: tips of
/// sharp edges are that long.
const LOST: f64 = 3.0;
/// A wall is missed if the finished mesh does not come nearer to one of its points than this many cells.
const MISSED: f64 = 0.5;
/// Of an extraction at most about this many nodes are looked for in the mesh of the blunted one.
const SAMPLES: usize = 20_000;
/// Cells for a wall's sake are this many times its thickness: enough for one along the grid, and for any.
const BELOW: [f64; 2] = [0.9, 0.5];
/// Nor are cells smaller than this share of the size.
const LEAST_CELL: f64 = 1.0 / 64.0;
/// How many unresolved places a report names.
const NAMED: usize = 5;

/// Those of some things at some place that a mesh does not come near to.
fn far<T: Copy>(mesh: &TriMesh, things: &[T], place: impl Fn(&T) -> DVec3, reach: f64) -> Vec<T> {
    if things.is_empty() {
        return Vec::new();
    }
    let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let away = |thing: &&T| {
        let p = place(thing);
        tree.nearest(p, reach, |t| triangle_distance_squared(p, mesh.corners(t as usize))).is_none()
    };
    things.iter().filter(away).copied().collect()
}

/// The cells to be tried, and with which of them tips of sharp edges are blunted.
struct Trials {
    ahead: VecDeque<(f64, bool)>,
    least: f64,
    /// Places left without an exact edge when last tried, without and with blunting.
    last: [Option<usize>; 2],
}

impl Trials {
    fn new(size: f64) -> Self {
        Self {
            ahead: CELLS.into_iter().map(|(share, blunt)| (share * size, blunt)).collect(),
            least: LEAST_CELL * size,
            last: [None; 2],
        }
    }

    fn next(&mut self) -> Option<(f64, bool)> {
        self.ahead.pop_front()
    }

    /// Notes how many places were left without an exact edge; a kind that no smaller cells help is given up.
    fn note(&mut self, blunt: bool, places: usize) {
        let before = self.last[usize::from(blunt)].replace(places);
        if places >= MANY && before.is_some_and(|n| 2 * places >= n) {
            self.ahead.retain(|t| t.1 != blunt);
        }
    }

    /// Leaves out what is too large for most of some missed walls, but for the other kind of the same `cell`. Where that is
    /// all, cells of the right size follow.
    fn go_below(&mut self, walls: &[Wall], cell: f64) {
        let mut thickness: Vec<f64> = walls.iter().map(|w| w.thickness).collect();
        thickness.sort_by(f64::total_cmp);
        // Tips of faces that run out like knives are thinner than any cells: the ones ahead may still find their edges.
        let within_reach = |t: &&f64| BELOW[0] * **t >= self.least;
        let Some(thickness) = thickness.get(thickness.len() / 2).filter(within_reach) else { return };
        self.ahead.retain(|t| t.0 <= BELOW[0] * thickness || t.0 == cell);
        self.last = [None; 2];
        for goal in BELOW.map(|share| share * thickness) {
            if goal >= self.least && !self.ahead.iter().any(|t| t.0 <= goal) {
                self.ahead.extend([(goal, false), (goal, true)]);
            }
        }
    }
}

/// What one size of cells gave before remeshing.
pub(super) struct Scout {
    pub(super) extracted: Extracted,
    pub(super) cell: f64,
    pub(super) blunt: bool,
    /// Walls thinner than the cells.
    pub(super) walls: Vec<Wall>,
    /// Those of them that were not extracted, tips among them; and whether there are others than tips.
    missed: Vec<Wall>,
    gone: bool,
    /// Points that the mesh must come near to: see [`drop_splinters`], and what blunting may have taken away.
    splinters: Vec<DVec3>,
    unresolved: Vec<DVec3>,
}

impl Scout {
    fn new(
        ready: &Ready,
        (cell, blunt): (f64, bool),
        mut extracted: Extracted,
        run: &Run,
    ) -> Result<(Self, (Patchwork, CutReport))> {
        let splinters = drop_splinters(&mut extracted, &ready.model, cell);
        let walls = thin_walls(&ready.model, &extracted, cell, run)?;
        let missed = far(&extracted.mesh, &walls, |w| w.at, MISSED * cell);
        let gone = !far(&extracted.mesh, &missed, |w| w.at, LOST * cell).is_empty();
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let cut = cut_pieces(&Raw { mesh: &extracted.mesh, cell, kept: &[], blunt }, &oracle, run)?;
        let unresolved = cut.1.unresolved.clone();
        Ok((Self { extracted, cell, blunt, walls, missed, gone, splinters, unresolved }, cut))
    }

    /// What makes one worse than another: walls that are not there, then places without an exact edge.
    fn badness(&self) -> (bool, usize) {
        (self.gone, self.unresolved.len())
    }

    fn remesh(
        self,
        cut: (Patchwork, CutReport),
        ready: &Ready,
        options: &MeshOptions,
        run: &Run,
        observer: &mut Option<&mut Observer<'_>>,
    ) -> Result<Attempt> {
        let oracle = ImplicitOracle::new(&ready.model, &self.extracted);
        let wanted = exact_options(ready, options);
        let exact = remesh_cut(&self.extracted.mesh, cut, &oracle, &wanted, run, observer.as_deref_mut())?;
        let missed = far(&exact.mesh, &self.walls, |w| w.at, MISSED * self.cell);
        Ok(Attempt { exact, missed, scout: self })
    }
}

/// What one size of cells gave.
pub(super) struct Attempt {
    pub(super) exact: ExactMesh,
    /// Walls that the mesh does not have.
    missed: Vec<Wall>,
    pub(super) scout: Scout,
}

impl Attempt {
    fn badness(&self) -> (usize, bool, usize) {
        (self.faults(), !self.missed.is_empty(), self.scout.unresolved.len())
    }

    fn is_clean(&self) -> bool {
        self.badness() == (0, false, 0) && self.lost().is_none()
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
    pub(super) fn shortfalls(&self) -> Vec<String> {
        let unresolved = &self.exact.report.cut.unresolved;
        let mut list: Vec<String> = Vec::new();
        list.extend(self.missed.iter().min_by(|a, b| a.thickness.total_cmp(&b.thickness)).map(|w| {
            let wall = format!("a wall {:.6} thick near {}", w.thickness, at(w.at));
            format!("{wall} is not in the mesh, nor are {} more points of walls", self.missed.len() - 1)
        }));
        let place = |p: &DVec3| format!("no exact edge found near {}: two faces come too close there", at(*p));
        list.extend(unresolved.iter().take(NAMED).map(place));
        if unresolved.len() > NAMED {
            list.push(format!("and at {} more places", unresolved.len() - NAMED));
        }
        list.extend(self.lost().map(|p| format!("the solid, or a gap, is thinner than the cells near {}", at(p))));
        list
    }
}

pub(super) fn at(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

/// The first attempt that comes out clean; otherwise the best: where exact edges were not found everywhere, that with the
/// fewest places without.
pub(super) fn search(
    ready: &Ready,
    options: &MeshOptions,
    run: &Run,
    observer: &mut Option<&mut Observer<'_>>,
) -> Result<Attempt> {
    let mut best: Option<Attempt> = None;
    // What did not come out well, the best first.
    let mut others: Vec<(Scout, (Patchwork, CutReport))> = Vec::new();
    let mut first_error = None;
    // What was extracted without blunting: the blunted mesh may lack tips of it, not more.
    let mut whole = Vec::new();
    let mut trials = Trials::new(ready.size);
    while let Some((cell, blunt)) = trials.next() {
        let known = others.first().map(|s| &s.0).or(best.as_ref().filter(|b| b.faults() == 0).map(|b| &b.scout));
        // Edges that run out like knives are never found whole; the attempts for their sake end somewhere.
        let triangles = |s: &Scout| s.extracted.mesh.triangles.len() as f64 * (s.cell / cell).powi(2);
        if known.is_some_and(|s| triangles(s) > MOST_TRIANGLES) {
            continue;
        }
        let extracted = match ready.extract_as(cell, blunt, options, run) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // No memory for smaller cells: the first error tells the user.
            Err(e) => {
                first_error.get_or_insert(e);
                continue;
            }
        };
        if extracted.mesh.triangles.is_empty() {
            let walls = thin_walls(&ready.model, &extracted, cell, run)?;
            first_error.get_or_insert(nothing_found(&walls, cell));
            trials.go_below(&walls, cell);
            continue;
        }
        let (mut scout, cut) = Scout::new(ready, (cell, blunt), extracted, run)?;
        if blunt {
            scout.splinters.append(&mut whole);
        } else {
            let nodes = &scout.extracted.mesh.nodes;
            whole = nodes.iter().step_by(nodes.len().div_ceil(SAMPLES).max(1)).copied().collect();
        }
        trials.note(blunt, scout.unresolved.len());
        if !scout.unresolved.is_empty() {
            trials.go_below(&scout.missed, cell);
            others.push((scout, cut));
            others.sort_by_key(|s| s.0.badness());
            others.truncate(OTHERS);
            continue;
        }
        let this = scout.remesh(cut, ready, options, run, observer)?;
        if this.is_clean() {
            return Ok(this);
        }
        trials.go_below(&this.missed, cell);
        if best.as_ref().is_none_or(|b| this.badness() < b.badness()) {
            best = Some(this);
        }
    }
    // A sound one with its walls lacks no more than a splinter, or some edges.
    for (scout, cut) in others {
        if best.as_ref().is_some_and(|b| b.faults() == 0 && b.missed.is_empty()) {
            break;
        }
        let this = scout.remesh(cut, ready, options, run, observer)?;
        if best.as_ref().is_none_or(|b| this.badness() < b.badness()) {
            best = Some(this);
        }
    }
    best.ok_or_else(|| first_error.unwrap_or_else(|| Error::Failed("no attempt was made".into())))
}
