//! Many points evaluated at once, and roots found for many edges at once.

use glam::DVec3;

use super::model::Implicit;
use super::octree::{BRICK, Grid};
use super::tape::{Scratch, Tape};
use crate::error::{Error, Place, Result};
use crate::numeric::Bracket;

/// Corners along a brick's side.
pub(super) const SIDE: usize = BRICK + 1;

/// Points and values of one evaluation.
#[derive(Default)]
pub(super) struct Batch {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) z: Vec<f64>,
    pub(super) values: Vec<f64>,
    scratch: Scratch,
}

impl Batch {
    pub(super) fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    pub(super) fn push(&mut self, p: DVec3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }

    /// All corners of a brick, x fastest.
    pub(super) fn corners(&mut self, grid: &Grid, at: [u32; 3]) {
        self.clear();
        let axis =
            |k: usize| -> [f64; SIDE] { std::array::from_fn(|i| grid.coordinate(k, at[k] as usize * BRICK + i)) };
        let (x, y, z) = (axis(0), axis(1), axis(2));
        for z in z {
            for y in y {
                self.x.extend_from_slice(&x);
                self.y.extend_from_slice(&[y; SIDE]);
                self.z.extend_from_slice(&[z; SIDE]);
            }
        }
    }

    pub(super) fn eval(&mut self, tape: &Tape, model: &Implicit) -> Result<()> {
        let scratch = &mut self.scratch;
        self.values.resize(self.x.len(), 0.0);
        scratch.not_finite = false;
        tape.eval(&model.leaves, [&self.x, &self.y, &self.z], &mut self.values, scratch);
        if !scratch.not_finite {
            return Ok(());
        }
        for i in 0..self.x.len() {
            let p = DVec3::new(self.x[i], self.y[i], self.z[i]);
            scratch.not_finite = false;
            tape.eval(&model.leaves, [&[p.x], &[p.y], &[p.z]], &mut [0.0], scratch);
            if scratch.not_finite {
                return Err(Error::input(
                    Place::Point(p),
                    "a formula is not a finite number here (NaN, or a division by zero)",
                ));
            }
        }
        Ok(())
    }

    /// The face that decides at each point.
    pub(super) fn faces(&mut self, tape: &Tape, model: &Implicit, out: &mut [u32]) {
        tape.faces(&model.leaves, [&self.x, &self.y, &self.z], out, &mut self.scratch);
    }
}

/// How roots of a function are looked for along edges.
pub(super) struct RootSearch<'a> {
    pub(super) model: &'a Implicit,
    pub(super) tape: &'a Tape,
    /// How near they are found, as a share of the edge.
    pub(super) tolerance: f64,
}

impl RootSearch<'_> {
    /// Finds the change of sign between the two ends of every edge. The signs at the ends must differ.
    pub(super) fn find(&self, ends: &[[DVec3; 2]], out: &mut [DVec3], batch: &mut Batch) -> Result<()> {
        let Self { model, tape, tolerance } = *self;
        batch.clear();
        ends.iter().for_each(|e| batch.push(e[0]));
        ends.iter().for_each(|e| batch.push(e[1]));
        batch.eval(tape, model)?;
        let n = ends.len();
        let mut brackets: Vec<(usize, f64, Bracket)> = Vec::with_capacity(n);
        for i in 0..n {
            let (f0, f1) = (batch.values[i], batch.values[n + i]);
            let b = Bracket::new(f0, f1, tolerance);
            brackets.push((i, f0.abs().max(f1.abs()), b));
        }
        while !brackets.is_empty() {
            batch.clear();
            let probes: Vec<f64> = brackets.iter().map(|(_, _, b)| b.probe()).collect();
            for ((i, _, _), t) in brackets.iter().zip(&probes) {
                batch.push(ends[*i][0].lerp(ends[*i][1], *t));
            }
            batch.eval(tape, model)?;
            for (((_, _, b), t), v) in brackets.iter_mut().zip(&probes).zip(&batch.values) {
                b.update(*t, *v);
            }
            let mut pole = None;
            brackets.retain(|(i, before, b)| {
                if !b.done() {
                    return true;
                }
                out[*i] = ends[*i][0].lerp(ends[*i][1], b.root());
                if b.residual() > 1e3 * before {
                    pole = Some(out[*i]);
                }
                false
            });
            if let Some(p) = pole {
                return Err(Error::input(
                    Place::Point(p),
                    "a formula has a pole (division by zero) where it changes sign",
                ));
            }
        }
        Ok(())
    }
}
