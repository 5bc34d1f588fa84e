//! Formulas compiled to a flat list of operations, evaluated for batches of points, over boxes, and with gradients.

mod adjoint;
mod length;
mod program;
mod written;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use rustc_hash::FxHashMap;

use self::length::{Length, lengths};
use self::program::Program;
use super::branches::branches;
use super::expr::{BEYOND, Binary, Expr, ExprNode, STEEPENED, SWING, Unary};
use super::joints::is_smooth;
use super::slopes::Slopes;
use super::solid::Placement;
use crate::numeric::{Dual, FEW_ROUNDINGS, Interval};
use crate::spatial::Aabb;

/// One operation; operands are indices of earlier operations.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Op {
    Const(f64),
    Coordinate(u8),
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
    Square(u32),
    Select(u32, u32, u32),
    /// The same of operands that go over into each other smoothly: see [`is_smooth`].
    Joined(u32, u32, u32),
    /// Sine, cosine, wrap or swing of the first operand. The second is the same angle, but jumps elsewhere, by whole turns: see [`branches`]. It
    /// serves bounds only.
    Turn(Unary, u32, u32),
}

/// A compiled formula. Positive inside.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Formula {
    ops: Vec<Op>,
    /// Which operations serve bounds only; empty where none does.
    idle: Vec<bool>,
    /// The operations as batches take them.
    program: Program,
    /// Whether [`backwards`](Self::backwards) may give closer bounds of gradients than forwards.
    shared: bool,
    /// The operations that are lengths of vectors, in order.
    lengths: Vec<Length>,
    /// One of the same sign everywhere, with closer bounds: without a divisor that is positive.
    plain: Option<Arc<Formula>>,
}

#[derive(Default)]
struct Builder {
    ops: Vec<Op>,
    known: FxHashMap<[u64; 4], u32>,
}

impl Builder {
    fn push(&mut self, op: Op) -> u32 {
        let key = match op {
            Op::Const(c) => [0, c.to_bits(), 0, 0],
            Op::Coordinate(k) => [1, u64::from(k), 0, 0],
            Op::Unary(u, a) => [2, u as u64, u64::from(a), 0],
            Op::Binary(b, x, y) => [3, b as u64, u64::from(x), u64::from(y)],
            Op::Square(a) => [4, u64::from(a), 0, 0],
            Op::Select(c, a, b) => [5, u64::from(c), u64::from(a), u64::from(b)],
            Op::Turn(u, a, b) => [6, u as u64, u64::from(a), u64::from(b)],
            Op::Joined(c, a, b) => [7, u64::from(c), u64::from(a), u64::from(b)],
        };
        let ops = &mut self.ops;
        *self.known.entry(key).or_insert_with(|| {
            ops.push(op);
            (ops.len() - 1) as u32
        })
    }

    /// Operations of a formula, and the number of the last.
    fn take(&mut self, ops: &[Op]) -> u32 {
        let mut numbers: Vec<u32> = Vec::with_capacity(ops.len());
        for op in ops {
            let of = |a: u32| numbers[a as usize];
            let op = match *op {
                Op::Const(_) | Op::Coordinate(_) => *op,
                Op::Unary(u, a) => Op::Unary(u, of(a)),
                Op::Binary(o, a, b) => Op::Binary(o, of(a), of(b)),
                Op::Square(a) => Op::Square(of(a)),
                Op::Select(c, a, b) => Op::Select(of(c), of(a), of(b)),
                Op::Joined(c, a, b) => Op::Joined(of(c), of(a), of(b)),
                Op::Turn(u, a, b) => Op::Turn(u, of(a), of(b)),
            };
            numbers.push(self.push(op));
        }
        numbers.last().copied().unwrap_or(0)
    }

    /// `offset + row . (x, y, z)`
    fn affine(&mut self, row: DVec3, offset: f64) -> u32 {
        let mut sum = None;
        for k in 0..3 {
            let factor = row[k];
            if factor == 0.0 {
                continue;
            }
            let mut term = self.push(Op::Coordinate(k as u8));
            if factor != 1.0 {
                let c = self.push(Op::Const(factor));
                term = self.push(Op::Binary(Binary::Mul, term, c));
            }
            sum = Some(match sum {
                None => term,
                Some(s) => self.push(Op::Binary(Binary::Add, s, term)),
            });
        }
        let c = (offset != 0.0 || sum.is_none()).then(|| self.push(Op::Const(offset)));
        match (sum, c) {
            (Some(s), Some(c)) => self.push(Op::Binary(Binary::Add, s, c)),
            (Some(s), None) => s,
            (None, c) => c.unwrap_or(0),
        }
    }
}

/// The operations that values do not need; nothing if they need all.
fn idle(ops: &[Op]) -> Vec<bool> {
    if !ops.iter().any(|op| matches!(op, Op::Turn(..))) {
        return Vec::new();
    }
    let mut idle = vec![true; ops.len()];
    idle[ops.len() - 1] = false;
    for (i, op) in ops.iter().enumerate().rev() {
        if idle[i] {
            continue;
        }
        match *op {
            Op::Const(_) | Op::Coordinate(_) => {}
            Op::Unary(_, a) | Op::Square(a) | Op::Turn(_, a, _) => idle[a as usize] = false,
            Op::Binary(_, a, b) => [a, b].into_iter().for_each(|x| idle[x as usize] = false),
            Op::Select(a, b, c) | Op::Joined(a, b, c) => {
                [a, b, c].into_iter().for_each(|x| idle[x as usize] = false);
            }
        }
    }
    idle
}

impl Formula {
    /// Compiles `expr`, taken in the frame that `placement` moves, times the placement's scale: lengths stay lengths.
    pub(crate) fn compile(expr: &Expr, placement: &Placement) -> Self {
        Self::put_together(expr, placement, is_smooth)
    }

    /// The same with one that has its sign everywhere, and closer bounds.
    pub(crate) fn with_sign_of(self, plain: Formula) -> Self {
        Self { plain: Some(Arc::new(plain)), ..self }
    }

    pub(crate) fn plain(&self) -> Option<&Formula> {
        self.plain.as_deref()
    }

    /// The same, when nobody asks for bounds: pieces are not asked whether they go over into each other smoothly.
    pub(crate) fn in_pieces(expr: &Expr, placement: &Placement) -> Self {
        Self::put_together(expr, placement, |_, _, _| false)
    }

    fn put_together(expr: &Expr, placement: &Placement, joined: impl Fn(&Expr, &Expr, &Expr) -> bool) -> Self {
        let mut b = Builder::default();
        let inverse = placement.rotation.transpose();
        let axes: [u32; 3] = std::array::from_fn(|k| {
            let row = inverse.row(k) / placement.scale;
            b.affine(row, -row.dot(placement.shift))
        });
        let others = branches(expr).found;
        let mut done: FxHashMap<*const ExprNode, u32> = FxHashMap::default();
        let mut stack = vec![(expr, false)];
        while let Some((e, ready)) = stack.pop() {
            let key = Arc::as_ptr(&e.0);
            if done.contains_key(&key) {
                continue;
            }
            let of = |done: &FxHashMap<*const ExprNode, u32>, e: &Expr| done[&Arc::as_ptr(&e.0)];
            let id = match e.node() {
                ExprNode::Const(c) => b.push(Op::Const(*c)),
                ExprNode::Coordinate(k) => axes[*k as usize % 3],
                ExprNode::Unary(op, a) if ready => match others.get(&key) {
                    Some(other) => b.push(Op::Turn(*op, of(&done, a), of(&done, other))),
                    None => b.push(Op::Unary(*op, of(&done, a))),
                },
                ExprNode::Binary(op, x, y) if ready => {
                    let (i, j) = (of(&done, x), of(&done, y));
                    if (*op == Binary::Mul && i == j) || (*op == Binary::Pow && y.as_constant() == Some(2.0)) {
                        b.push(Op::Square(i))
                    } else {
                        b.push(Op::Binary(*op, i, j))
                    }
                }
                ExprNode::Select(c, x, y) if ready => {
                    let [i, j, k] = [c, x, y].map(|e| of(&done, e));
                    b.push(if joined(c, x, y) { Op::Joined(i, j, k) } else { Op::Select(i, j, k) })
                }
                node => {
                    stack.push((e, true));
                    stack.extend(others.get(&key).map(|other| (other, false)));
                    match node {
                        ExprNode::Unary(_, a) => stack.push((a, false)),
                        ExprNode::Binary(_, x, y) => stack.extend([(y, false), (x, false)]),
                        ExprNode::Select(c, x, y) => stack.extend([(y, false), (x, false), (c, false)]),
                        ExprNode::Const(_) | ExprNode::Coordinate(_) => {}
                    }
                    continue;
                }
            };
            done.insert(key, id);
        }
        let mut root = done[&Arc::as_ptr(&expr.0)];
        if placement.scale != 1.0 {
            let k = b.push(Op::Const(placement.scale));
            root = b.push(Op::Binary(Binary::Mul, root, k));
        }
        b.ops.truncate(root as usize + 1); // the root may be an operand another one came after
        Self::of(b.ops)
    }

    /// The formula whose last operation is the root.
    fn of(ops: Vec<Op>) -> Self {
        let idle = idle(&ops);
        let program = Program::new(&ops, |i| idle.get(i).copied().unwrap_or(false));
        Formula { idle, program, shared: adjoint::is_shared(&ops), lengths: lengths(&ops), ops, plain: None }
    }

    /// The sum of two formulas.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut b = Builder::default();
        let (of_self, of_other) = (b.take(&self.ops), b.take(&other.ops));
        b.ops.push(Op::Binary(Binary::Add, of_self, of_other));
        Self::of(b.ops)
    }

    /// The sum of two formulas and their difference, in which operations of both are one; nothing where most of neither are.
    pub(crate) fn sum_and_difference(&self, other: &Self) -> Option<[Self; 2]> {
        let mut b = Builder::default();
        let of_self = b.take(&self.ops);
        let alone = b.ops.len();
        let of_other = b.take(&other.ops);
        // Fewer operations in common cancel little.
        if 2 * (b.ops.len() - alone) > other.ops.len() {
            return None;
        }
        let with = |op| {
            let mut ops = b.ops.clone();
            ops.push(Op::Binary(op, of_self, of_other));
            Self::of(ops)
        };
        Some([with(Binary::Add), with(Binary::Sub)])
    }

    /// A number that is equal for equal formulas.
    pub(crate) fn fingerprint(&self) -> u64 {
        self.hashed(|u| u)
    }

    /// If the formula has angles that go on beyond half a turn, a number that is equal for formulas which are the same elsewhere.
    pub(crate) fn kin(&self) -> Option<u64> {
        let goes_on = |op: &Op| matches!(op, Op::Unary(u, _) | Op::Turn(u, ..) if u.goes_on());
        self.ops.iter().any(goes_on).then(|| self.hashed(|u| if u.goes_on() { Unary::Wrap } else { u }))
    }

    /// Whether no angle goes on beyond half a turn in a box: there it is the same as its kin bit by bit.
    pub(crate) fn is_same_as_kin(&self, cell: &Aabb) -> bool {
        let [x, y, z] = cell.intervals();
        let ranges = self.ranges(x, y, z);
        self.ops.iter().all(|op| match *op {
            Op::Unary(u, a) | Op::Turn(u, a, _) if u.goes_on() => {
                let turn = ranges[a as usize];
                turn.lo > BEYOND - PI && turn.hi < PI - BEYOND
            }
            _ => true,
        })
    }

    fn hashed(&self, of: impl Fn(Unary) -> Unary) -> u64 {
        use std::hash::{BuildHasher, Hash, Hasher};
        let mut h = rustc_hash::FxBuildHasher.build_hasher();
        for op in &self.ops {
            match *op {
                Op::Const(c) => c.to_bits().hash(&mut h),
                Op::Coordinate(k) => (1u8, k).hash(&mut h),
                Op::Unary(u, a) => (2u8, of(u), a).hash(&mut h),
                Op::Binary(o, a, b) => (3u8, o, a, b).hash(&mut h),
                Op::Square(a) => (4u8, a).hash(&mut h),
                Op::Select(c, a, b) => (5u8, c, a, b).hash(&mut h),
                Op::Joined(c, a, b) => (7u8, c, a, b).hash(&mut h),
                Op::Turn(u, a, b) => (6u8, of(u), a, b).hash(&mut h),
            }
        }
        h.finish()
    }

    /// Values at many points.
    pub(crate) fn eval(&self, xs: &[f64], ys: &[f64], zs: &[f64], out: &mut [f64]) {
        self.program.eval([xs, ys, zs], out);
    }

    /// The value at one point.
    pub(crate) fn value(&self, p: DVec3) -> f64 {
        self.program.value(p.to_array())
    }

    /// Value and gradient at one point.
    pub(crate) fn gradient(&self, p: DVec3) -> Dual {
        self.program.gradient(p)
    }

    /// Derivatives by x, y and z at many points, then values.
    pub(crate) fn gradients(&self, p: [&[f64]; 3], out: [&mut [f64]; 4]) {
        self.program.gradients(p, out);
    }

    /// Bounds of the value over a box.
    pub(crate) fn range(&self, x: Interval, y: Interval, z: Interval) -> Interval {
        let r = self.ranges(x, y, z);
        r[r.len() - 1]
    }

    /// Bounds of all operations over a box.
    fn ranges(&self, x: Interval, y: Interval, z: Interval) -> Vec<Interval> {
        let mut r: Vec<Interval> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            let reg = |a: u32| r[a as usize];
            let i = match *op {
                Op::Const(c) => Interval::point(c),
                Op::Coordinate(0) => x,
                Op::Coordinate(1) => y,
                Op::Coordinate(_) => z,
                Op::Square(a) => reg(a).square(),
                Op::Unary(u, a) => {
                    let a = reg(a);
                    match u {
                        Unary::Neg => -a,
                        Unary::Abs => a.abs(),
                        Unary::Sqrt => a.sqrt(),
                        Unary::Exp => a.exp(),
                        Unary::Log => a.ln(),
                        Unary::Sin => a.sin(),
                        Unary::Cos => a.cos(),
                        Unary::Tan => a.tan(),
                        Unary::Wrap => a.wrap(),
                        Unary::Upward => a.turned(BEYOND),
                        Unary::Downward => a.turned(-BEYOND),
                        Unary::Fold => a.fold(),
                        Unary::Steepened => a.steepened(STEEPENED),
                        Unary::Swing => a.swing(SWING),
                        Unary::Asin => a.asin(),
                        Unary::Acos => a.acos(),
                        Unary::Sinh => a.sinh(),
                        Unary::Cosh => a.cosh(),
                        Unary::Tanh => a.tanh(),
                        Unary::Floor => a.floor(),
                        Unary::Sign => a.sign(),
                    }
                }
                Op::Turn(u, a, b) => {
                    let of = |x: Interval| match u {
                        Unary::Sin => x.sin(),
                        Unary::Cos => x.cos(),
                        Unary::Swing => x.swing(SWING),
                        Unary::Fold => x.fold(),
                        Unary::Upward => x.turned(BEYOND),
                        Unary::Downward => x.turned(-BEYOND),
                        _ => x.wrap(),
                    };
                    both(of(reg(a)), of(reg(b)))
                }
                Op::Binary(o, a, b) => {
                    let (a, b) = (reg(a), reg(b));
                    match o {
                        Binary::Add => a + b,
                        Binary::Sub => a - b,
                        Binary::Mul => a * b,
                        Binary::Div => a / b,
                        Binary::Pow => a.pow(b),
                        Binary::Min => a.min(b),
                        Binary::Max => a.max(b),
                        Binary::Atan2 => a.atan2(b),
                        Binary::Hypot => a.hypot(b),
                        Binary::Mod => a.modulo(b),
                    }
                }
                Op::Select(c, a, b) | Op::Joined(c, a, b) => {
                    let (c, a, b) = (reg(c), reg(a), reg(b));
                    if c.lo >= 0.0 {
                        a
                    } else if c.hi < 0.0 {
                        b
                    } else {
                        a.hull(b)
                    }
                }
            };
            r.push(i);
        }
        r
    }
}

/// What lies in both intervals, and a little more: the operands agree to rounding.
fn both(a: Interval, b: Interval) -> Interval {
    // As a share of the operands' size, or of 1 where they are smaller; only makes the result larger.
    let slack = FEW_ROUNDINGS * a.lo.abs().max(a.hi.abs()).min(b.lo.abs().max(b.hi.abs())).max(1.0);
    Interval { lo: a.lo.max(b.lo) - slack, hi: a.hi.min(b.hi) + slack }
}

impl Formula {
    fn is_idle(&self, op: usize) -> bool {
        self.idle.get(op).copied().unwrap_or(false)
    }

    /// The vector whose length an operation is.
    fn length(&self, op: usize) -> Option<&Length> {
        let found = self.lengths.binary_search_by_key(&(op as u32), |l| l.root);
        found.ok().map(|i| &self.lengths[i])
    }

    /// Bounds of value and gradient over a box. Those of the value are of second order in the box's size.
    pub(crate) fn slopes(&self, b: &[Interval; 3]) -> Slopes {
        let center = b.map(|i| 0.5 * i.lo + 0.5 * i.hi);
        let half: [f64; 3] = std::array::from_fn(|k| (b[k].hi - center[k]).max(center[k] - b[k].lo).next_up());
        let [x, y, z] = center.map(Interval::point);
        let middle = self.ranges(x, y, z);
        let mut r: Vec<Slopes> = Vec::with_capacity(self.ops.len());
        for (i, (op, middle)) in self.ops.iter().zip(&middle).enumerate() {
            let reg = |a: u32| r[a as usize];
            let mut bounds = match *op {
                Op::Const(c) => Slopes::constant(c),
                Op::Coordinate(k) => Slopes::coordinate(k as usize % 3, b[k as usize % 3]),
                Op::Square(a) => reg(a).square(),
                Op::Unary(u, a) => reg(a).unary(u),
                Op::Turn(u, a, b) => {
                    let (a, b) = (reg(a).unary(u), reg(b).unary(u));
                    let gradient = std::array::from_fn(|k| both(a.gradient[k], b.gradient[k]));
                    Slopes { value: both(a.value, b.value), gradient }
                }
                Op::Binary(o, x, y) => reg(x).binary(o, reg(y)),
                Op::Select(c, x, y) => reg(x).select(reg(c).value, reg(y)),
                Op::Joined(c, x, y) => reg(x).joined(reg(c).value, reg(y)),
            };
            if let Some(length) = self.length(i) {
                bounds = bounds.of_length(length.partials(bounds.value, |s| reg(s).value).map(|(s, by)| (reg(s), by)));
            }
            r.push(bounds.closer(*middle, &half));
        }
        let mut root = r[r.len() - 1];
        if let Some(back) = self.shared.then(|| self.backwards(&r, &middle, &half)).flatten() {
            root.value = root.value.within(middle[r.len() - 1] + back.change);
            if let Some(g) = back.gradient {
                root.gradient = std::array::from_fn(|k| root.gradient[k].within(g[k]));
            }
        }
        root
    }
}
