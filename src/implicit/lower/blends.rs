//! Blends: one smooth leaf for two smooth operands, a tree of leaves and fillets for others.

use std::sync::Arc;

use super::super::blend::Blend;
use super::super::fillet::{Fillet, Side};
use super::super::leaf::Leaf;
use super::super::solid::Solid;
use super::super::tape::{Op, Tape};
use super::{Context, Lowerer, Part, extract_tape, positive};
use crate::error::{Error, Place, Result};
use crate::spatial::Aabb;

/// Blends inside blends deeper than this are refused: each level evaluates the one below twice.
const BLEND_DEPTH: usize = 32;

/// A blend of operands with more pairs of leaves than this stays one function, and so do those within it: edges are rounded off
/// then. Where more fillets come near a place, too many of their curves and corners are tried.
const MOST_FILLETS: usize = 1 << 11;

/// A leaf where a tape has it.
#[derive(Clone, Copy)]
struct Occurrence {
    leaf: u32,
    face: u32,
    negate: bool,
}

/// Two lowered solids with their leaves, and a box around both.
struct Operands {
    leaves: Vec<Leaf>,
    tapes: [Tape; 2],
    bounds: Aabb,
}

/// What stands for a leaf in another tape.
type Substitute<'a> = dyn FnMut(&mut Lowerer, Occurrence) -> u32 + 'a;

impl Lowerer {
    pub(super) fn blend(&mut self, solid: &Solid, a: &Solid, b: &Solid, radius: f64, c: &Context) -> Result<Part> {
        positive("the radius of a blend", radius)?;
        if self.blend_depth >= BLEND_DEPTH {
            return Err(Error::input(Place::Unknown, format!("blends are nested more than {BLEND_DEPTH} deep")));
        }
        let mut inner = self.operands([a, b], c, self.one_function)?;
        let pairs = inner.tapes[0].leaf_count().saturating_mul(inner.tapes[1].leaf_count());
        if pairs > MOST_FILLETS && !self.one_function {
            inner = self.operands([a, b], c, true)?;
        }
        let Operands { leaves, tapes: [ta, tb], bounds } = inner;
        let radius = radius * c.place.scale;
        // the fillet lies within r of both solids, and the box around both holds it when they meet at any angle
        let bounds = if c.negate { Aabb::ALL } else { bounds.grown(radius) };
        let op = if pairs == 1 || pairs > MOST_FILLETS || self.one_function {
            let leaf = Leaf::Blend(Arc::new(Blend { leaves, a: ta, b: tb, radius }));
            let face = self.face(solid, "blend", "", c);
            self.leaf(leaf, face, c.negate)
        } else {
            self.blend_depth += 1;
            let inside = Context { negate: false, ..c.clone() };
            let [a, b] = [self.tree_from(a, inside.clone())?.op, self.tree_from(b, inside)?.op];
            self.blend_depth -= 1;
            self.fillets(solid, [a, b], radius, c)
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

    /// The blend of two trees as one tree, with leaves where the two surfaces show and between each two of them.
    fn fillets(&mut self, solid: &Solid, [a, b]: [u32; 2], radius: f64, c: &Context) -> u32 {
        let [ta, tb] = [a, b].map(|op| extract_tape(&self.ops, op));
        let mut all = self.max(a, b);
        if ta.leaf_count() > 0 && tb.leaf_count() > 0 {
            let face = self.face(solid, "blend", "", c);
            let between = self.over(&ta, false, &mut |l, i| {
                l.over(&tb, false, &mut |l, j| {
                    let sides = [i, j].map(|o| Side {
                        leaf: l.leaves[o.leaf as usize].clone(),
                        number: o.leaf,
                        negate: o.negate,
                    });
                    let fillet = Fillet { sides, radius, band: 0.0 };
                    if let Some(k) = fillet.replaced() {
                        let Occurrence { leaf, face, negate } = [i, j][k];
                        return l.op(Op::Leaf { leaf, face, negate });
                    }
                    l.leaf(Leaf::Fillet(Arc::new(fillet)), face, false)
                })
            });
            all = self.max(all, between);
        }
        if c.negate {
            let tape = extract_tape(&self.ops, all);
            all = self.over(&tape, true, &mut |l, o| l.op(Op::Leaf { leaf: o.leaf, face: o.face, negate: !o.negate }));
        }
        all
    }

    /// A tape with something else for each of its leaves, and, on demand, with minima for maxima.
    fn over(&mut self, tape: &Tape, dual: bool, each: &mut Substitute<'_>) -> u32 {
        let mut made: Vec<u32> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let new = match *op {
                Op::All(inside) => self.op(Op::All(inside != dual)),
                Op::Leaf { leaf, face, negate } => each(self, Occurrence { leaf, face, negate }),
                Op::Min(x, y) | Op::Max(x, y) => {
                    let (x, y) = (made[x as usize], made[y as usize]);
                    if matches!(op, Op::Min(..)) != dual { self.min(x, y) } else { self.max(x, y) }
                }
            };
            made.push(new);
        }
        made[made.len() - 1]
    }
}
