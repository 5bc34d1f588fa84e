//! Smooth minima and maxima of formulas with edges: a tree of their pieces, with fillets where these are rounded off.

use std::sync::Arc;

use super::blends::Rounding;
use super::pairs::Pairs;
use super::{Context, Lowerer, Op, Part, extract_tape};
use crate::implicit::expr::Expr;
use crate::implicit::fillet::{Fillet, Profile, Side};
use crate::implicit::formula::Formula;
use crate::implicit::leaf::Leaf;
use crate::implicit::model::box_around;
use crate::implicit::solid::Placement;
use crate::implicit::valued::{How, Smooth, Valued};
use crate::numeric::Interval;
use crate::spatial::Aabb;

/// A smooth minimum with more leaves than this stays one function: where more come near a place, too many of their curves and corners are
/// tried. Two blocks have 676 pairs of faces, edges and corners.
const MOST_LEAVES: usize = 1 << 10;

/// The trees of two operands have no more pairs of operations than this: each box in which near leaves are looked for asks them all. Two
/// blocks have some ten thousand.
const MOST_OPERATIONS: usize = 1 << 16;

/// What is the same for all of a formula.
struct Whole<'a> {
    place: &'a Placement,
    face: u32,
    /// The box that its surface lies in.
    bounds: Aabb,
    /// How many leaves there were before.
    before: usize,
}

/// The sign of a formula, or of its opposite, and which values of that count: where zero alone does, only the sign.
#[derive(Clone, Copy)]
struct Counts {
    negate: bool,
    values: Interval,
}

impl Counts {
    fn is_sign(&self) -> bool {
        self.values == Interval::point(0.0)
    }

    /// The same of what is mirrored, or not.
    fn turned(self, mirrored: bool) -> Self {
        if self.negate == mirrored { self } else { Self { negate: mirrored, values: -self.values } }
    }
}

impl Lowerer {
    /// The tree of a smooth minimum or maximum; `None`, and nothing left of it, where that is too large.
    pub(super) fn smooth(&mut self, smooth: &Smooth, face: u32, c: &Context) -> Option<Part> {
        let (leaves, ops) = (self.leaves.len(), self.ops.len());
        let part = self.smooth_tree(smooth, face, c);
        if part.is_none() {
            self.leaves.truncate(leaves);
            self.leaf_index.values_mut().for_each(|at| at.retain(|&i| (i as usize) < leaves));
            self.ops.truncate(ops);
            self.op_index.retain(|_, i| (*i as usize) < ops);
        }
        part
    }

    fn smooth_tree(&mut self, smooth: &Smooth, face: u32, c: &Context) -> Option<Part> {
        let compiled = smooth.value.map(&|e| Formula::compile(e, &c.place));
        let rest = smooth.rest.as_ref().map(|e| [e.clone(), -e.clone()].map(|e| Formula::compile(&e, &c.place)));
        let added = |cell: &Aabb| {
            let [x, y, z] = cell.intervals();
            rest.as_ref().map_or(Interval::point(0.0), |[f, _]| f.range(x, y, z))
        };
        let scale = c.place.scale;
        let range = |cell: &Aabb| compiled.range(cell, scale) + added(cell);
        let inside = box_around(&|cell: &Aabb| range(cell).hi);
        let outside = || box_around(&|cell: &Aabb| -range(cell).lo);
        let bounds = inside.or_else(outside).unwrap_or(Aabb::ALL);
        let whole = Whole { place: &c.place, face, bounds, before: self.leaves.len() };
        // With a function beside it the value counts where it is the opposite of that: anything, where no box is known.
        let values = if c.negate { added(&bounds) } else { -added(&bounds) };
        let op = self.valued(&smooth.value, Counts { negate: c.negate, values }, &whole)?;
        let op = match &rest {
            Some([plus, minus]) => self.with_rest(op, turned([plus, minus], c.negate), face),
            None => self.by_zeros(op),
        };
        let known = if c.negate { None } else { inside };
        Some(Part { op, bounds: known.unwrap_or(Aabb::ALL) })
    }

    /// The value of a part of a formula, or its opposite.
    fn valued(&mut self, value: &Valued<Expr>, counts: Counts, at: &Whole<'_>) -> Option<u32> {
        match value {
            Valued::Piece(e) => match e.as_constant() {
                // A number has no surface that a fillet could end in.
                Some(v) => counts.is_sign().then(|| self.op(Op::All((v >= 0.0) != counts.negate))),
                None => Some(self.leaf(Leaf::Formula(Formula::compile(e, at.place)), at.face, counts.negate)),
            },
            Valued::Joined { how, mirrored, of } => {
                let joined = self.rounded(*how, of, counts.turned(*mirrored), at)?;
                Some(if counts.negate == *mirrored { joined } else { self.dual(joined) })
            }
        }
    }

    /// The same tree by what is zero where its leaves are: smooth maxima by their zeros, and what two faces share, whose zeros are an edge,
    /// by the signs of both.
    fn by_zeros(&mut self, root: u32) -> u32 {
        let tape = extract_tape(&self.ops, root);
        let mut made: Vec<u32> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let new = match *op {
                Op::Leaf { leaf, face, negate } => self.sign(leaf, face, negate),
                Op::Min(x, y) => self.min(made[x as usize], made[y as usize]),
                Op::Max(x, y) => self.max(made[x as usize], made[y as usize]),
                Op::All(_) => self.op(*op),
            };
            made.push(new);
        }
        made.last().copied().unwrap_or(root)
    }

    /// The same tree with a function added to what it is a tree of, given with its opposite.
    fn with_rest(&mut self, root: u32, rest: [&Formula; 2], face: u32) -> u32 {
        let tape = extract_tape(&self.ops, root);
        let mut made: Vec<u32> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let new = match *op {
                Op::Leaf { leaf, negate, .. } => {
                    let leaf = self.leaf_with(leaf, turned(rest, negate), face);
                    self.op(Op::Leaf { leaf, face, negate })
                }
                Op::Min(x, y) => self.min(made[x as usize], made[y as usize]),
                Op::Max(x, y) => self.max(made[x as usize], made[y as usize]),
                Op::All(_) => self.op(*op),
            };
            made.push(new);
        }
        made.last().copied().unwrap_or(root)
    }

    /// The number of a leaf with a function added to it.
    fn leaf_with(&mut self, leaf: u32, rest: [&Formula; 2], face: u32) -> u32 {
        let new = match self.leaves[leaf as usize].clone() {
            Leaf::Fillet(f) => {
                let sides = self.sides_with(&f, rest, face);
                Leaf::Fillet(Arc::new(Fillet { sides, rest: Some(rest[0].clone()), ..*f }))
            }
            Leaf::Formula(f) => Leaf::Formula(f.plus(rest[0])),
            // Distances are made of formulas and fillets alone.
            _ => return leaf,
        };
        let op = self.leaf(new, face, false);
        if let Op::Leaf { leaf, .. } = self.ops[op as usize] { leaf } else { leaf }
    }

    /// The sides of a fillet, and of those that are its sides, with the numbers of the leaves that have the function, too.
    fn sides_with(&mut self, f: &Fillet, rest: [&Formula; 2], face: u32) -> [Side; 2] {
        f.sides.each_ref().map(|s| {
            let rest = turned(rest, s.negate);
            let leaf = match &s.leaf {
                Leaf::Fillet(f) => {
                    let sides = self.sides_with(f, rest, face);
                    Leaf::Fillet(Arc::new(Fillet { sides, rest: None, ..**f }))
                }
                other => other.clone(),
            };
            Side { leaf, number: self.leaf_with(s.number, rest, face), negate: s.negate }
        })
    }

    /// The sign of a leaf. Where not both of two faces are positive what they share may be anything that is no more than the greater.
    fn sign(&mut self, leaf: u32, face: u32, negate: bool) -> u32 {
        let sides = match &self.leaves[leaf as usize] {
            Leaf::Fillet(f) if f.radius <= 0.0 => f.sides.each_ref().map(|s| (s.number, s.negate != negate)),
            _ => {
                let leaf = self.surface(leaf, face);
                return self.op(Op::Leaf { leaf, face, negate });
            }
        };
        // Of three faces one is shared by two already.
        let [a, b] = sides.map(|(number, negate)| self.sign(number, face, negate));
        if negate { self.max(a, b) } else { self.min(a, b) }
    }

    fn both(&mut self, of: &[Valued<Expr>; 2], counts: Counts, at: &Whole<'_>) -> Option<[u32; 2]> {
        let [a, b] = of.each_ref().map(|v| self.valued(v, counts, at));
        Some([a?, b?])
    }

    /// Two parts joined to what is no less than both, with a fillet between each two of their leaves.
    fn rounded(&mut self, how: How, of: &[Valued<Expr>; 2], counts: Counts, at: &Whole<'_>) -> Option<u32> {
        let Interval { lo, hi } = counts.values;
        let k = at.place.scale;
        let (radius, profile, near) = match how {
            How::Distance(r) => (r * k, Profile::Circle, Interval::new(-r * k, hi)),
            How::Smooth(kernel, width) => {
                let profile = if counts.is_sign() { Profile::Zeros(kernel) } else { Profile::SmoothMax(kernel) };
                (width * k, profile, Interval::new(lo - width * k, hi))
            }
            How::Max => (0.0, Profile::Circle, Interval::point(hi)),
        };
        // Nothing is more than both here: what two faces share is less than one of them up to minus the radius.
        if near.lo >= hi {
            let [a, b] = self.both(of, counts, at)?;
            return Some(self.max(a, b));
        }
        let inner = Counts { values: near.hull(counts.values), ..counts };
        let [a, b] = self.both(of, inner, at)?;
        let [p, q] = if counts.is_sign() { self.both(of, counts, at)? } else { [a, b] };
        let all = self.max(p, q);
        let tapes = [a, b].map(|op| extract_tape(&self.ops, op));
        if tapes.iter().any(|t| t.leaf_count() == 0) {
            return Some(all);
        }
        if tapes[0].ops.len() * tapes[1].ops.len() > MOST_OPERATIONS {
            return None;
        }
        let span = if radius > 0.0 { radius } else { hi - near.lo };
        let pairs = Pairs::new(&self.leaves, &tapes, near, &at.bounds);
        if self.leaves.len() - at.before + pairs.count() > MOST_LEAVES {
            return None;
        }
        let rounding = Rounding { radius, profile, span, face: at.face };
        Some(match self.between([a, b], &pairs, &rounding) {
            Some(between) => self.max(all, between),
            None => all,
        })
    }
}

/// What is added to the opposite.
fn turned([rest, opposite]: [&Formula; 2], turn: bool) -> [&Formula; 2] {
    if turn { [opposite, rest] } else { [rest, opposite] }
}

impl Valued<Formula> {
    /// Bounds of the value in a box.
    fn range(&self, cell: &Aabb, scale: f64) -> Interval {
        let [x, y, z] = cell.intervals();
        match self {
            Valued::Piece(f) => f.range(x, y, z),
            Valued::Joined { how, mirrored, of } => {
                let turn = |r: Interval| if *mirrored { -r } else { r };
                let [a, b] = of.each_ref().map(|v| turn(v.range(cell, scale)));
                // None is farther above the greater of both than where they are equal, or above that of both distances.
                turn(match how {
                    How::Max => a.max(b),
                    How::Smooth(kernel, width) => {
                        Interval::new(a.max(b).lo, a.max(b).hi + kernel.added(1.0) * width * scale)
                    }
                    How::Distance(r) => {
                        let r = Interval::point(r * scale);
                        let zero = Interval::point(0.0);
                        let length = (r + a).max(zero).hypot((r + b).max(zero)) - r;
                        Interval::new(a.max(b).lo, a.max(b).hi.max(length.hi))
                    }
                })
            }
        }
    }
}
