//! Blends: one smooth leaf for two smooth operands, a tree of leaves and fillets for others.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::super::blend::Blend;
use super::super::fillet::{Fillet, Profile, Side};
use super::super::leaf::Leaf;
use super::super::solid::Solid;
use super::super::tape::{Op, Tape};
use super::pairs::Pairs;
use super::{Context, Lowerer, Part, extract_tape, positive};
use crate::error::{Error, Place, Result};
use crate::numeric::Interval;
use crate::spatial::Aabb;

/// Blends inside blends deeper than this are refused: each level evaluates the one below twice.
const BLEND_DEPTH: usize = 32;

/// A blend of operands with more pairs of leaves near each other than this stays one function, and so do those within it: edges are
/// rounded off then. Where more fillets come near a place, too many of their curves and corners are tried.
const MOST_FILLETS: usize = 1 << 11;

/// A leaf where a tape has it.
#[derive(Clone, Copy)]
struct Occurrence {
    leaf: u32,
    negate: bool,
}

/// Two lowered solids with their leaves, and a box around both.
struct Operands {
    leaves: Vec<Leaf>,
    tapes: [Tape; 2],
    bounds: Aabb,
}

impl Operands {
    /// The pairs of their leaves that fillets of a radius are between.
    fn pairs(&self, radius: f64) -> Pairs {
        Pairs::new(&self.leaves, &self.tapes, Interval::new(-radius, 0.0), &self.bounds.grown(radius))
    }
}

/// What is asked of fillets, and the face they are of.
pub(super) struct Rounding {
    pub(super) radius: f64,
    pub(super) profile: Profile,
    /// See [`Fillet::span`].
    pub(super) span: f64,
    pub(super) face: u32,
}

/// A leaf of one tree, the operation that stands for it, and the places in the other tree of leaves with which it has fillets.
struct Rows<'a> {
    own: Occurrence,
    op: u32,
    with: &'a FxHashSet<u32>,
}

/// The operations that a root is made of, ascending: those that [`extract_tape`] keeps.
fn reachable(ops: &[Op], root: u32) -> Vec<u32> {
    let mut found = vec![false; root as usize + 1];
    found[root as usize] = true;
    for i in (0..=root as usize).rev().filter(|i| matches!(ops[*i], Op::Min(..) | Op::Max(..))) {
        if found[i]
            && let Op::Min(a, b) | Op::Max(a, b) = ops[i]
        {
            (found[a as usize], found[b as usize]) = (true, true);
        }
    }
    (0..=root).filter(|i| found[*i as usize]).collect()
}

impl Lowerer {
    pub(super) fn blend(&mut self, solid: &Solid, a: &Solid, b: &Solid, radius: f64, c: &Context) -> Result<Part> {
        positive("the radius of a blend", radius)?;
        if self.blend_depth >= BLEND_DEPTH {
            return Err(Error::input(Place::Unknown, format!("blends are nested more than {BLEND_DEPTH} deep")));
        }
        let mut inner = self.operands([a, b], c, self.one_function)?;
        let one_pair = inner.tapes.iter().all(|t| t.leaf_count() == 1);
        let scaled = radius * c.place.scale;
        let many = !one_pair && !self.one_function && inner.pairs(scaled).count() > MOST_FILLETS;
        if many {
            inner = self.operands([a, b], c, true)?;
        }
        let Operands { leaves, tapes: [ta, tb], bounds } = inner;
        let radius = scaled;
        // the fillet lies within r of both solids, and the box around both holds it when they meet at any angle
        let reach = bounds.grown(radius);
        let bounds = if c.negate { Aabb::ALL } else { reach };
        let op = if one_pair || many || self.one_function {
            let leaf = Leaf::Blend(Arc::new(Blend { leaves, a: ta, b: tb, radius }));
            let face = self.face(solid, "blend", "", c);
            self.leaf(leaf, face, c.negate)
        } else {
            self.blend_depth += 1;
            let inside = Context { negate: false, ..c.clone() };
            let [a, b] = [self.tree_from(a, inside.clone())?.op, self.tree_from(b, inside)?.op];
            self.blend_depth -= 1;
            let face = self.face(solid, "blend", "", c);
            let rounding = Rounding { radius, profile: Profile::Circle, span: radius, face };
            let all = self.fillets([a, b], &rounding, &reach);
            if c.negate { self.dual(all) } else { all }
        };
        Ok(Part { op, bounds })
    }

    /// The operands of a blend for themselves; with `one_function` blends within them are one leaf each.
    fn operands(&mut self, [a, b]: [&Solid; 2], c: &Context, one_function: bool) -> Result<Operands> {
        let (blend_depth, visited) = (self.blend_depth + 1, self.visited);
        let mut inner = Lowerer { blend_depth, visited, one_function, ..Lowerer::default() };
        let (a, b) = (inner.tree(a, c.place)?, inner.tree(b, c.place)?);
        self.visited = inner.visited;
        let tapes = [a.op, b.op].map(|op| extract_tape(&inner.ops, op));
        Ok(Operands { leaves: inner.leaves, tapes, bounds: a.bounds.union(&b.bounds) })
    }

    /// The blend of two trees as one tree, with leaves where the two surfaces show and between each two of them that come near each
    /// other in a box.
    fn fillets(&mut self, [a, b]: [u32; 2], rounding: &Rounding, bounds: &Aabb) -> u32 {
        let tapes = [a, b].map(|op| extract_tape(&self.ops, op));
        let mut all = self.max(a, b);
        if tapes.iter().all(|t| t.leaf_count() > 0) {
            let pairs = Pairs::new(&self.leaves, &tapes, Interval::new(-rounding.radius, 0.0), bounds);
            if let Some(between) = self.between([a, b], &pairs, rounding) {
                all = self.max(all, between);
            }
        }
        all
    }

    /// The complement of a tree.
    pub(super) fn dual(&mut self, root: u32) -> u32 {
        let tape = extract_tape(&self.ops, root);
        let mut made: Vec<u32> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let new = match *op {
                Op::All(inside) => self.op(Op::All(!inside)),
                Op::Leaf { leaf, face, negate } => self.op(Op::Leaf { leaf, face, negate: !negate }),
                Op::Min(x, y) => self.max(made[x as usize], made[y as usize]),
                Op::Max(x, y) => self.min(made[x as usize], made[y as usize]),
            };
            made.push(new);
        }
        made[made.len() - 1]
    }

    /// The first tree with, in place of each of its leaves, the second one with fillets in place of its leaves. Nothing where
    /// that is no more than the two solids themselves.
    pub(super) fn between(&mut self, [a, b]: [u32; 2], pairs: &Pairs, rounding: &Rounding) -> Option<u32> {
        let [first, second] = [a, b].map(|root| reachable(&self.ops, root));
        let mut made: Vec<Option<u32>> = Vec::with_capacity(first.len());
        for (i, op) in first.iter().enumerate() {
            let place = |x: u32| first.binary_search(&x).unwrap_or(0);
            let new = match self.ops[*op as usize] {
                Op::All(_) => None,
                Op::Leaf { leaf, negate, .. } => {
                    let rows = Rows { own: Occurrence { leaf, negate }, op: *op, with: pairs.of(i) };
                    self.along(&second, &rows, rounding)
                }
                Op::Min(x, y) | Op::Max(x, y) => {
                    let and = matches!(self.ops[*op as usize], Op::Min(..));
                    let parts = [x, y].map(|x| (x, made[place(x)]));
                    self.joined(and, parts, b)
                }
            };
            made.push(new);
        }
        made.pop().flatten()
    }

    /// A tree with fillets between one leaf and its own in place of these. Nothing where that is no more than the leaf or the tree.
    fn along(&mut self, tree: &[u32], rows: &Rows<'_>, rounding: &Rounding) -> Option<u32> {
        let mut made: Vec<Option<u32>> = Vec::with_capacity(tree.len());
        for (k, op) in tree.iter().enumerate() {
            let place = |x: u32| tree.binary_search(&x).unwrap_or(0);
            let new = match self.ops[*op as usize] {
                Op::Leaf { leaf, negate, .. } if rows.with.contains(&(k as u32)) => {
                    self.fillet([rows.own, Occurrence { leaf, negate }], rounding)
                }
                Op::All(_) | Op::Leaf { .. } => None,
                Op::Min(x, y) | Op::Max(x, y) => {
                    let and = matches!(self.ops[*op as usize], Op::Min(..));
                    let parts = [x, y].map(|x| (x, made[place(x)]));
                    self.joined(and, parts, rows.op)
                }
            };
            made.push(new);
        }
        made.pop().flatten()
    }

    /// Two parts of a tree joined; what is nothing new is the part itself or `other`.
    fn joined(&mut self, and: bool, parts: [(u32, Option<u32>); 2], other: u32) -> Option<u32> {
        if parts.iter().all(|p| p.1.is_none()) {
            return None;
        }
        let [x, y] = parts.map(|(own, new)| new.unwrap_or_else(|| self.max(own, other)));
        Some(if and { self.min(x, y) } else { self.max(x, y) })
    }

    /// The number of the leaf with the zeros of another: a smooth maximum is asked for other values only by what it is a side of.
    pub(super) fn surface(&mut self, leaf: u32, face: u32) -> u32 {
        let Leaf::Fillet(f) = &self.leaves[leaf as usize] else { return leaf };
        let Profile::SmoothMax(kernel) = f.profile else { return leaf };
        let zeros = Fillet { sides: f.sides.clone(), profile: Profile::Zeros(kernel), rest: None, ..**f };
        let op = self.leaf(Leaf::Fillet(Arc::new(zeros)), face, false);
        if let Op::Leaf { leaf, .. } = self.ops[op as usize] { leaf } else { leaf }
    }

    fn fillet(&mut self, pair: [Occurrence; 2], rounding: &Rounding) -> Option<u32> {
        let sides = pair.map(|o| {
            let number = self.surface(o.leaf, rounding.face);
            Side { leaf: self.leaves[o.leaf as usize].clone(), number, negate: o.negate }
        });
        let Rounding { radius, profile, span, .. } = *rounding;
        let fillet = Fillet { sides, radius, profile, span, band: 0.0, rest: None };
        if fillet.replaced().is_some() {
            return None;
        }
        Some(self.leaf(Leaf::Fillet(Arc::new(fillet)), rounding.face, false))
    }
}
