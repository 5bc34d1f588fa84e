//! The surface as seen from points close to it, as those of a mesh are.

use std::sync::Arc;

use glam::DVec3;

use super::lockstep;
use super::oracle::ImplicitOracle;
use super::tape::{Pruned, Scratch, Tape};
use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::TriMesh;
use crate::numeric::NONE;
use crate::run::Run;
use crate::spatial::Aabb;

/// Feet are looked for within this share of the mean edge before anywhere: chords are lower where triangles follow the surface.
const CLOSE: f64 = 0.25;

/// Cells beyond so many times the mesh's triangles are not halved: intervals that decide nothing would fill the box with cells.
const MOST: usize = 4;

/// Cells with no more leaves than this are not halved: asking so few costs no more than finding a smaller cell, and most of the cells
/// along edges have two.
const FEW: usize = 3;

/// What is below is a cell's tape, not the next eight cells.
const TAPE: u32 = 1 << 31;

/// An oracle with an octree of tapes, each valid in its cell and around it as far as feet are looked for.
///
/// A foot found there is the nearest one, whatever lies farther away. Where there is none the oracle it is made from answers.
pub(crate) struct CloseOracle<'a> {
    oracle: &'a ImplicitOracle<'a>,
    bounds: Aabb,
    reach: f64,
    top: u32,
    inner: Vec<[u32; 8]>,
    tapes: Vec<Arc<Tape>>,
}

/// A cell still to be halved.
struct Open {
    cell: Aabb,
    tape: Arc<Tape>,
    /// Where it hangs, if not at the top.
    parent: Option<(usize, usize)>,
}

impl<'a> CloseOracle<'a> {
    /// For the points of a mesh: cells with more than a few leaves are halved until they are no wider than its mean edge.
    ///
    /// Errors: cancellation.
    pub(crate) fn new(oracle: &'a ImplicitOracle<'a>, mesh: &TriMesh, run: &Run) -> Result<Self> {
        let edge = mesh.mean_edge_length();
        let bounds = mesh.bounds();
        let bounds = Aabb::new(bounds.lo, bounds.lo + bounds.size().max_element());
        let (tapes, reach) = (Vec::new(), CLOSE * edge);
        let mut made = Self { oracle, bounds, reach, top: NONE, inner: Vec::new(), tapes };
        let whole = Arc::new(oracle.model().tape.as_ref().clone());
        let mut open = vec![Open { cell: bounds, tape: whole, parent: None }];
        let mut width = bounds.size().x;
        while !open.is_empty() {
            run.check()?;
            let last = !(width > edge) || open.len() > MOST * mesh.triangles.len();
            open = made.level(open, last, run);
            width *= 0.5;
        }
        Ok(made)
    }

    /// Puts cells in their places, halved unless they are the `last` or have few leaves; what is to be halved next.
    fn level(&mut self, open: Vec<Open>, last: bool, run: &Run) -> Vec<Open> {
        let leaves = &self.oracle.model().leaves;
        let halved: Vec<Vec<(usize, Aabb, Arc<Tape>)>> = run.install(|| {
            lockstep::each_with(leaves, &open, |scratch: &mut Scratch, o| {
                if last || o.tape.leaf_count() <= FEW || run.is_cancelled() {
                    return Vec::new();
                }
                let around = |c: &Aabb| c.grown(self.reach);
                let child = |(k, sub): (usize, Aabb)| match o.tape.prune(leaves, &around(&sub), scratch) {
                    Pruned::Outside | Pruned::Inside => None,
                    Pruned::Same => Some((k, sub, o.tape.clone())),
                    Pruned::Smaller(t) => Some((k, sub, Arc::new(t))),
                };
                o.cell.octants().into_iter().enumerate().filter_map(child).collect()
            })
        });
        let mut next = Vec::new();
        for (o, parts) in open.into_iter().zip(halved) {
            let here = if last || o.tape.leaf_count() <= FEW {
                self.tapes.push(o.tape);
                TAPE | (self.tapes.len() - 1) as u32
            } else {
                let at = self.inner.len();
                self.inner.push([NONE; 8]);
                next.extend(parts.into_iter().map(|(k, cell, tape)| Open { cell, tape, parent: Some((at, k)) }));
                at as u32
            };
            match o.parent {
                Some((at, k)) => self.inner[at][k] = here,
                None => self.top = here,
            }
        }
        next
    }

    /// The tape that is valid as far around a point as feet are looked for.
    fn tape(&self, p: DVec3) -> Option<&Tape> {
        if !self.bounds.contains(p) {
            return None;
        }
        let (mut lo, mut hi, mut here) = (self.bounds.lo, self.bounds.hi, self.top);
        while here != NONE && here & TAPE == 0 {
            // The same middle as that of `Aabb::octants`.
            let upper = p.cmpge(0.5 * (lo + hi));
            let mid = 0.5 * (lo + hi);
            lo = DVec3::select(upper, mid, lo);
            hi = DVec3::select(upper, hi, mid);
            here = self.inner[here as usize][upper.bitmask() as usize];
        }
        (here != NONE).then(|| &*self.tapes[(here & !TAPE) as usize])
    }
}

impl SurfaceOracle for CloseOracle<'_> {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let close = self.tape(p).and_then(|tape| self.oracle.project_by(tape, p, self.reach.min(reach)));
        close.or_else(|| self.oracle.project(p, reach))
    }

    fn project_all(&self, points: &[DVec3], reach: f64) -> Vec<Option<Foot>> {
        lockstep::together(points.len(), |i| self.project(points[i], reach))
    }

    fn in_turn(&self, count: usize, question: &mut dyn FnMut(usize)) {
        lockstep::together(count, question);
    }

    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        self.oracle.project_along(p, direction, reach)
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        self.oracle.curvatures(foot)
    }
}
