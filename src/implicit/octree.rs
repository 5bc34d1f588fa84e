//! From a box down to bricks of 8 x 8 x 8 cells that may hold some of the surface, each with its pruned tape.

use std::sync::Arc;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::lockstep;
use super::model::Implicit;
use super::tape::{Pruned, Scratch, Tape};
use crate::error::{Error, Result};
use crate::run::{GIB, Run};
use crate::spatial::Aabb;

/// Cells along a brick's side. Chosen so that a row of corners fits a machine word and a brick's values the first-level cache.
pub(crate) const BRICK: usize = 8;

/// Bytes a brick with its share of the mesh takes, measured on flat parts: about 64 surface cells of 2 triangles.
const BYTES_PER_BRICK: u64 = 6_000;

/// A uniform grid of nodes; bricks are counted, cells are not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub(crate) origin: DVec3,
    pub(crate) h: f64,
    /// Bricks along each axis.
    pub(crate) bricks: [u32; 3],
}

impl Grid {
    /// A grid of cells of size `h` around a box. Its planes are shifted against the box's faces by shares of a cell that
    /// no simple ratio of lengths hits, so that faces rarely fall on grid planes; at least one layer of cells is outside.
    pub(crate) fn around(b: &Aabb, h: f64) -> Result<Self> {
        let shift = DVec3::new(1.371, 1.433, 1.292) * h;
        let origin = b.lo - shift;
        let mut bricks = [0; 3];
        for k in 0..3 {
            let cells = ((b.hi[k] - origin[k]) / h).ceil() + 1.0;
            let n = (cells / BRICK as f64).ceil();
            // node numbers stay exactly representable and keys fit into 64 bits
            if !(n >= 1.0 && n < f64::from(1u32 << 20)) {
                return Err(Error::Usage(format!("size {h} is too small for a part {} long", b.size().max_element())));
            }
            bricks[k] = n as u32;
        }
        Ok(Grid { origin, h, bricks })
    }

    /// A coordinate of the node with number `i` along axis `k`: the same bits wherever it is asked for.
    pub(crate) fn coordinate(&self, k: usize, i: usize) -> f64 {
        self.origin[k] + i as f64 * self.h
    }

    pub(crate) fn node(&self, i: [usize; 3]) -> DVec3 {
        DVec3::new(self.coordinate(0, i[0]), self.coordinate(1, i[1]), self.coordinate(2, i[2]))
    }

    /// The box of `side` bricks from brick `at`.
    fn cell(&self, at: [u32; 3], side: u32) -> Aabb {
        let node = |b: u32| b as usize * BRICK;
        Aabb::new(self.node(at.map(node)), self.node(at.map(|b| node(b + side))))
    }

    /// The brick that holds a point, if the grid does.
    pub(crate) fn brick_of(&self, p: DVec3) -> Option<[u32; 3]> {
        let q = (p - self.origin) / (self.h * BRICK as f64);
        let mut at = [0; 3];
        for k in 0..3 {
            if !(q[k] >= 0.0 && q[k] < f64::from(self.bricks[k])) {
                return None;
            }
            at[k] = q[k] as u32;
        }
        Some(at)
    }
}

pub(crate) fn key(at: [u32; 3]) -> u64 {
    u64::from(at[0]) | u64::from(at[1]) << 21 | u64::from(at[2]) << 42
}

/// A brick that interval arithmetic could not decide.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    pub(crate) at: [u32; 3],
    pub(crate) tape: Arc<Tape>,
}

/// All undecided bricks, in Morton order, with a way to find one.
#[derive(Debug, Clone)]
pub(crate) struct Bricks {
    pub(crate) grid: Grid,
    pub(crate) cells: Vec<Cell>,
    index: FxHashMap<u64, u32>,
}

impl Bricks {
    /// The position of a brick in `cells`.
    pub(crate) fn find(&self, at: [u32; 3]) -> Option<usize> {
        self.index.get(&key(at)).map(|i| *i as usize)
    }

    /// Descends from the whole grid to bricks. Refuses when the mesh would not fit into `memory` bytes.
    pub(crate) fn build(model: &Implicit, h: f64, memory: u64, run: &Run) -> Result<Self> {
        Self::build_within(model, &model.bounds(), h, memory, run)
    }

    /// The same of a grid around a box.
    pub(crate) fn build_within(model: &Implicit, bounds: &Aabb, h: f64, memory: u64, run: &Run) -> Result<Self> {
        let grid = Grid::around(bounds, h)?;
        let longest = grid.bricks.iter().copied().max().unwrap_or(1);
        let levels = longest.next_power_of_two().trailing_zeros();
        let mut cells = vec![Cell { at: [0; 3], tape: model.tape.clone() }];
        for level in (0..=levels).rev() {
            run.check()?;
            run.progress("cells", f64::from(levels - level) / f64::from(levels + 1));
            // the surface crosses at least a quarter of the cells intervals cannot decide, on all parts measured
            let expected = (cells.len() as u64).saturating_mul(BYTES_PER_BRICK) << (2 * level).min(60);
            if cells.len() > 256 && expected / 4 > memory {
                return Err(Error::Usage(format!(
                    "size {h} needs about {} of memory, more than the {} allowed",
                    bytes(expected / 4),
                    bytes(memory)
                )));
            }
            let side = 1u32 << level;
            let whole = level == levels;
            let next: Vec<Vec<Cell>> = lockstep::each_with(&model.leaves, &cells, |scratch: &mut Scratch, cell| {
                let mut out = Vec::new();
                if run.is_cancelled() {
                    return out;
                }
                for child in 0..if whole { 1 } else { 8u32 } {
                    let at: [u32; 3] = std::array::from_fn(|k| cell.at[k] + (child >> k & 1) * side);
                    if (0..3).any(|k| at[k] >= grid.bricks[k]) {
                        continue;
                    }
                    match cell.tape.prune(&model.leaves, &grid.cell(at, side), scratch) {
                        Pruned::Outside | Pruned::Inside => {}
                        Pruned::Same => out.push(Cell { at, tape: cell.tape.clone() }),
                        Pruned::Smaller(t) => out.push(Cell { at, tape: Arc::new(t) }),
                    }
                }
                out
            });
            cells = Vec::with_capacity(next.iter().map(Vec::len).sum());
            next.into_iter().for_each(|c| cells.extend(c));
        }
        run.check()?;
        let mut bricks = Bricks { grid, cells, index: FxHashMap::default() };
        bricks.reindex();
        Ok(bricks)
    }

    /// Keeps the bricks `keep` says, by position.
    pub(crate) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let mut i = 0;
        self.cells.retain(|_| {
            i += 1;
            keep(i - 1)
        });
        self.cells.shrink_to_fit();
        self.reindex();
    }

    /// Adds bricks that are not there.
    pub(crate) fn add(&mut self, cells: &[Cell]) {
        self.cells.extend_from_slice(cells);
        self.reindex();
    }

    fn reindex(&mut self) {
        self.index = self.cells.iter().enumerate().map(|(i, c)| (key(c.at), i as u32)).collect();
    }

    /// The tape that is valid at a point: its brick's, else the whole one.
    pub(crate) fn tape_at<'a>(&'a self, whole: &'a Tape, p: DVec3) -> &'a Tape {
        match self.grid.brick_of(p).and_then(|at| self.find(at)) {
            Some(i) => &self.cells[i].tape,
            None => whole,
        }
    }
}

/// The centers of those of a grid's bricks, of cells of size `h`, that may hold some of the surface.
pub(crate) fn undecided_in(model: &Implicit, h: f64, memory: u64, run: &Run) -> Result<Vec<DVec3>> {
    let bricks = Bricks::build(model, h, memory, run)?;
    Ok(bricks.cells.iter().map(|c| bricks.grid.cell(c.at, 1).center()).collect())
}

fn bytes(n: u64) -> String {
    if n >= 1 << 30 {
        format!("{:.1} GiB", n as f64 / GIB)
    } else {
        format!("{:.1} MiB", n as f64 / (1u64 << 20) as f64)
    }
}
