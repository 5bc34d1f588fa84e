//! A solid written as a list of operations, and that as `.vm` text, negative inside.

use std::fmt::Write;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::leaf::{Frame, Leaf};
use super::model::Implicit;
use super::tape::Op;
use crate::error::{Error, Place, Result};
use crate::spatial::Aabb;

/// How far what tells the bounds of a solid stands off the box around it, as a share of that one's diagonal.
pub(super) const ROOM: f64 = 0.01;

/// The solid's formula: leaves joined by `min` and `max`, and a box around it with some room, so that whoever reads it can tell where it
/// ends. Where the solid is cut off by a domain the formula is, too. Names of faces are lost.
///
/// Errors: an [`Error::Input`] for a solid with a program's function, values on a grid or blends, which have no formula here.
pub fn write_vm(model: &Implicit) -> Result<String> {
    let mut list = Operations::new(Words::Few);
    let mut root = solid(model, &mut list)?;
    let room = around(model);
    for axis in 0..3 {
        let x = list.coordinate(axis);
        let from = list.plus(x, -room.center()[axis]);
        let away = list.line("abs", &[from]);
        let size = list.constant(0.5 * room.size()[axis]);
        let within = list.line("sub", &[size, away]);
        root = list.line("min", &[root, within]);
    }
    list.line("neg", &[root]);
    let mut text = String::new();
    for (i, one) in list.all.iter().enumerate() {
        // Writing to a string does not fail.
        let _ = match one {
            Operation::Constant(bits) => writeln!(text, "_{i:x} const {:?}", f64::from_bits(*bits)),
            Operation::Coordinate(axis) => writeln!(text, "_{i:x} var-{}", ["x", "y", "z"][axis % 3]),
            Operation::Of(word, operands) => {
                let _ = write!(text, "_{i:x} {word}");
                for o in operands {
                    let _ = write!(text, " _{o:x}");
                }
                writeln!(text)
            }
        };
    }
    Ok(text)
}

/// The solid's box with some room around it.
pub(super) fn around(model: &Implicit) -> Aabb {
    let bounds = model.bounds();
    bounds.grown(ROOM * bounds.diagonal())
}

/// Puts the solid's formula, positive inside, into a list; the number of its value.
pub(super) fn solid(model: &Implicit, list: &mut Operations) -> Result<u32> {
    let mut done: Vec<u32> = Vec::with_capacity(model.tape.ops.len());
    for op in &model.tape.ops {
        done.push(match *op {
            Op::All(everything) => list.constant(if everything { 1.0 } else { -1.0 }),
            Op::Leaf { leaf, negate, .. } => {
                let value = list.leaf(&model.leaves[leaf as usize])?;
                if negate { list.line("neg", &[value]) } else { value }
            }
            Op::Min(a, b) => list.line("min", &[done[a as usize], done[b as usize]]),
            Op::Max(a, b) => list.line("max", &[done[a as usize], done[b as usize]]),
        });
    }
    Ok(done.last().copied().unwrap_or(0))
}

/// Which operations a format has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Words {
    /// Those of `.vm` text.
    Few,
    /// Also `select` (of three operands, by whether the first is not negative), `mod` with the sign of the divisor, `sign`,
    /// and hyperbolic functions.
    Many,
}

/// One operation, its operands by their numbers in the list.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    /// A number, by its bits.
    Constant(u64),
    Coordinate(usize),
    Of(&'static str, Vec<u32>),
}

/// Operations in the order they are made in; equal ones are made once.
pub(super) struct Operations {
    pub(super) all: Vec<Operation>,
    pub(super) words: Words,
    known: FxHashMap<Operation, u32>,
}

impl Operations {
    pub(super) fn new(words: Words) -> Self {
        Operations { all: Vec::new(), words, known: FxHashMap::default() }
    }

    fn put(&mut self, what: Operation) -> u32 {
        if let Some(i) = self.known.get(&what) {
            return *i;
        }
        let i = self.all.len() as u32;
        self.all.push(what.clone());
        self.known.insert(what, i);
        i
    }

    pub(super) fn constant(&mut self, value: f64) -> u32 {
        self.put(Operation::Constant(value.to_bits()))
    }

    pub(super) fn coordinate(&mut self, axis: usize) -> u32 {
        self.put(Operation::Coordinate(axis))
    }

    pub(super) fn line(&mut self, operation: &'static str, operands: &[u32]) -> u32 {
        self.put(Operation::Of(operation, operands.to_vec()))
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
            Err(e.with_help("such a file holds primitives, formulas and set operations on them; mesh the part instead"))
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
