//! A solid written as a formula in `.vm` text, negative inside.

use std::fmt::Write;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::leaf::{Frame, Leaf};
use super::model::Implicit;
use super::tape::Op;
use crate::error::{Error, Place, Result};

/// How far the box around the formula stands off the solid's, as a share of its diagonal.
const ROOM: f64 = 0.01;

/// The solid's formula: leaves joined by `min` and `max`, and a box around it with some room, so that whoever reads it can tell where it
/// ends. Where the solid is cut off by a domain the formula is, too. Names of faces are lost.
///
/// Errors: an [`Error::Input`] for a solid with a program's function, values on a grid or blends, which have no formula here.
pub fn write_vm(model: &Implicit) -> Result<String> {
    let mut text = VmText::default();
    let mut done: Vec<u32> = Vec::with_capacity(model.tape.ops.len());
    for op in &model.tape.ops {
        done.push(match *op {
            Op::All(everything) => text.constant(if everything { 1.0 } else { -1.0 }),
            Op::Leaf { leaf, negate, .. } => {
                let value = text.leaf(&model.leaves[leaf as usize])?;
                if negate { text.line("neg", &[value]) } else { value }
            }
            Op::Min(a, b) => text.line("min", &[done[a as usize], done[b as usize]]),
            Op::Max(a, b) => text.line("max", &[done[a as usize], done[b as usize]]),
        });
    }
    let mut root = done.last().copied().unwrap_or(0);
    let bounds = model.bounds();
    let room = ROOM * bounds.diagonal();
    let (center, half) = (bounds.center(), 0.5 * bounds.size() + room);
    for axis in 0..3 {
        let x = text.coordinate(axis);
        let from = text.plus(x, -center[axis]);
        let away = text.line("abs", &[from]);
        let size = text.constant(half[axis]);
        let within = text.line("sub", &[size, away]);
        root = text.line("min", &[root, within]);
    }
    text.line("neg", &[root]);
    Ok(text.text)
}

/// Lines written so far; equal ones are written once.
#[derive(Default)]
pub(super) struct VmText {
    text: String,
    known: FxHashMap<String, u32>,
}

impl VmText {
    fn put(&mut self, what: String) -> u32 {
        if let Some(i) = self.known.get(&what) {
            return *i;
        }
        let i = self.known.len() as u32;
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "_{i:x} {what}");
        self.known.insert(what, i);
        i
    }

    pub(super) fn constant(&mut self, value: f64) -> u32 {
        self.put(format!("const {value:?}"))
    }

    pub(super) fn coordinate(&mut self, axis: usize) -> u32 {
        self.put(format!("var-{}", ["x", "y", "z"][axis % 3]))
    }

    pub(super) fn line(&mut self, operation: &str, operands: &[u32]) -> u32 {
        let mut what = operation.to_string();
        for o in operands {
            let _ = write!(what, " _{o:x}");
        }
        self.put(what)
    }

    /// `a + c`
    pub(super) fn plus(&mut self, a: u32, c: f64) -> u32 {
        if c == 0.0 {
            return a;
        }
        let c = self.constant(c);
        self.line("add", &[a, c])
    }

    /// `a * c`
    pub(super) fn times(&mut self, a: u32, c: f64) -> u32 {
        if c == 1.0 {
            return a;
        }
        let c = self.constant(c);
        self.line("mul", &[a, c])
    }

    /// `n . (p - c)`
    fn along(&mut self, n: DVec3, c: DVec3) -> u32 {
        let mut sum = None;
        for axis in (0..3).filter(|k| n[*k] != 0.0) {
            let x = self.coordinate(axis);
            let from = self.plus(x, -c[axis]);
            let term = self.times(from, n[axis]);
            sum = Some(sum.map_or(term, |s| self.line("add", &[s, term])));
        }
        sum.unwrap_or_else(|| self.constant(0.0))
    }

    /// The sum of the squares.
    fn squares(&mut self, all: &[u32]) -> u32 {
        let squares: Vec<u32> = all.iter().map(|a| self.line("square", &[*a])).collect();
        squares.into_iter().reduce(|a, b| self.line("add", &[a, b])).unwrap_or(0)
    }

    /// `(r^2 - square) / 2r`
    fn within(&mut self, square: u32, r: f64) -> u32 {
        let turned = self.line("neg", &[square]);
        let rest = self.plus(turned, r * r);
        self.times(rest, 0.5 / r)
    }

    /// Distance from the axis through a point, and the height above it.
    fn about(&mut self, c: DVec3, frame: &Frame) -> [u32; 2] {
        let [u, v, t] = [frame.u, frame.v, frame.a].map(|n| self.along(n, c));
        let square = self.squares(&[u, v]);
        [self.line("sqrt", &[square]), t]
    }

    fn leaf(&mut self, leaf: &Leaf) -> Result<u32> {
        let refused = |what: &str| {
            let e = Error::input(Place::Unknown, format!("{what} cannot be written as a formula"));
            Err(e.with_help("a .vm file holds primitives, formulas and set operations on them; mesh the part instead"))
        };
        Ok(match leaf {
            Leaf::Plane { n, d } => {
                let height = self.along(-*n, DVec3::ZERO);
                self.plus(height, *d)
            }
            Leaf::Sphere { c, r } => {
                let q = DVec3::AXES.map(|n| self.along(n, *c));
                let square = self.squares(&q);
                self.within(square, *r)
            }
            Leaf::Cylinder { c, frame, r } => {
                let q = [frame.u, frame.v].map(|n| self.along(n, *c));
                let square = self.squares(&q);
                self.within(square, *r)
            }
            Leaf::Cone { c, frame, k, m, d } => {
                let [rho, t] = self.about(*c, frame);
                let [rho, t] = [self.times(rho, -k), self.times(t, -m)];
                let sum = self.line("add", &[rho, t]);
                self.plus(sum, *d)
            }
            Leaf::Torus { c, frame, major, minor } => {
                let [rho, t] = self.about(*c, frame);
                let from = self.plus(rho, -major);
                let square = self.squares(&[from, t]);
                self.within(square, *minor)
            }
            Leaf::Formula(f) => f.write(self),
            Leaf::Field(..) => return refused("a function of a program or a grid of values"),
            Leaf::Blend(_) | Leaf::Fillet(_) => return refused("a blend"),
        })
    }
}
