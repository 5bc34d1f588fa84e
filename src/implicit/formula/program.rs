//! A formula for batches: few registers, each a block of points that stays in the first-level cache, and steps of up to five
//! operations whose operands are read once.
//!
//! A step does what its operations do one by one, with a rounding each: values have the same bits in blocks of any length.

mod gradient;
mod gradients;

use std::cell::RefCell;

use multiversion::multiversion;

use super::super::expr::{Binary, Unary};
use super::Op;
use crate::implicit::tape::RESULT;
use crate::numeric::vector;

/// Points of a block.
const BLOCK: usize = 256;

/// Slow functions take a multiple of this many points.
const STRIDE: usize = 32;

/// Fewer points are taken one by one.
const ALONE: usize = 16;

/// Registers of one point that are kept on the stack.
const SMALL: usize = 32;

/// Where a step's result goes, or an operand is: the coordinates, then constants, then what steps make.
type Register = u32;

/// The number of coordinates.
const COORDINATES: u32 = 3;

/// What a term is of its registers. Sums and products of two terms are the same either way round; the lesser kind comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Plain,
    Square,
    Mul,
    Add,
}

/// An operand made where it is needed, of a register or two. Those of one have it twice.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Term {
    kind: Kind,
    a: Register,
    b: Register,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Work {
    Add(Term, Term),
    Sub(Term, Term),
    Mul(Term, Term),
    /// The sum of the first two, which are no sums themselves, and one more.
    Sum([Term; 3]),
    Squared(Term),
    Unary(Unary, Register),
    Binary(Binary, Register, Register),
    Power(Register, i32),
    Select(Register, Register, Register),
}

#[derive(Debug, Clone, PartialEq)]
struct Step {
    work: Work,
    to: Register,
}

/// A formula's operations in the form that batches are evaluated in.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Program {
    constants: Vec<f64>,
    steps: Vec<Step>,
    /// Constants and what steps make.
    registers: usize,
}

impl Term {
    fn plain(a: Register) -> Self {
        Term { kind: Kind::Plain, a, b: a }
    }

    fn square(a: Register) -> Self {
        Term { kind: Kind::Square, a, b: a }
    }

    fn each(self, mut f: impl FnMut(Register) -> Register) -> Term {
        Term { kind: self.kind, a: f(self.a), b: f(self.b) }
    }

    #[inline(always)]
    fn value(self, r: &impl Fn(Register) -> f64) -> f64 {
        let (a, b) = (r(self.a), r(self.b));
        match self.kind {
            Kind::Plain => a,
            Kind::Square => a * a,
            Kind::Mul => a * b,
            Kind::Add => a + b,
        }
    }
}

impl Work {
    /// The same with other registers.
    fn each(self, mut f: impl FnMut(Register) -> Register) -> Work {
        let f = &mut f;
        match self {
            Work::Add(l, r) => Work::Add(l.each(&mut *f), r.each(f)),
            Work::Sub(l, r) => Work::Sub(l.each(&mut *f), r.each(f)),
            Work::Mul(l, r) => Work::Mul(l.each(&mut *f), r.each(f)),
            Work::Sum(t) => Work::Sum(t.map(|t| t.each(&mut *f))),
            Work::Squared(t) => Work::Squared(t.each(f)),
            Work::Unary(u, a) => Work::Unary(u, f(a)),
            Work::Binary(o, a, b) => Work::Binary(o, f(a), f(b)),
            Work::Power(a, n) => Work::Power(f(a), n),
            Work::Select(c, a, b) => Work::Select(f(c), f(a), f(b)),
        }
    }

    fn operands(self) -> Vec<usize> {
        let mut all = Vec::new();
        self.each(|a| {
            all.push(a as usize);
            a
        });
        all
    }

    /// The value at one point.
    #[inline]
    fn value(&self, r: impl Fn(Register) -> f64) -> f64 {
        match *self {
            Work::Add(a, b) => a.value(&r) + b.value(&r),
            Work::Sub(a, b) => a.value(&r) - b.value(&r),
            Work::Mul(a, b) => a.value(&r) * b.value(&r),
            Work::Sum([a, b, c]) => a.value(&r) + b.value(&r) + c.value(&r),
            Work::Squared(a) => {
                let v = a.value(&r);
                v * v
            }
            Work::Unary(u, a) => u.apply(r(a)),
            Work::Binary(o, a, b) => o.apply(r(a), r(b)),
            Work::Power(a, n) => vector::powi(r(a), n),
            Work::Select(c, a, b) => r(if r(c) >= 0.0 { a } else { b }),
        }
    }
}

/// Operations that are made into steps; registers are the numbers of operations.
struct Fusing<'a> {
    ops: &'a [Op],
    /// How often each is an operand of what values need.
    uses: Vec<u32>,
}

impl Fusing<'_> {
    /// What stands for an operand: its own operation where nobody else needs that, and squares always.
    fn term(&self, a: u32) -> Term {
        let alone = self.uses[a as usize] == 1;
        match self.ops[a as usize] {
            Op::Square(x) => Term::square(x),
            // An operand that is a square or product is better made where the sum is.
            Op::Binary(Binary::Add, a, b) if alone && [a, b].map(|x| self.factor(x).kind) == [Kind::Plain; 2] => {
                Term { kind: Kind::Add, a, b }
            }
            _ => self.factor(a),
        }
    }

    /// The same, but no sum.
    fn factor(&self, a: u32) -> Term {
        match self.ops[a as usize] {
            Op::Square(x) => Term::square(x),
            Op::Binary(Binary::Mul, x, y) if self.uses[a as usize] == 1 => Term { kind: Kind::Mul, a: x, b: y },
            _ => Term::plain(a),
        }
    }

    fn sum(&self, a: u32, b: u32) -> Work {
        for (inner, other) in [(a, b), (b, a)] {
            if let Op::Binary(Binary::Add, x, y) = self.ops[inner as usize]
                && self.uses[inner as usize] == 1
            {
                let [x, y] = ordered(self.factor(x), self.factor(y));
                return Work::Sum([x, y, self.factor(other)]);
            }
        }
        let [a, b] = ordered(self.term(a), self.term(b));
        Work::Add(a, b)
    }

    /// The step of an operation that has a register of its own; constants and coordinates have none.
    fn work(&self, i: usize) -> Option<Work> {
        Some(match self.ops[i] {
            Op::Const(_) | Op::Coordinate(_) => return None,
            Op::Square(a) => Work::Squared(self.term(a)),
            Op::Unary(u, a) | Op::Turn(u, a, _) => Work::Unary(u, a),
            Op::Binary(Binary::Add, a, b) => self.sum(a, b),
            Op::Binary(Binary::Sub, a, b) => Work::Sub(self.term(a), self.term(b)),
            Op::Binary(Binary::Mul, a, b) => {
                let [a, b] = ordered(self.term(a), self.term(b));
                Work::Mul(a, b)
            }
            Op::Binary(Binary::Pow, a, b) => match self.ops[b as usize] {
                Op::Const(n) if Binary::is_whole_power(n) => Work::Power(a, n as i32),
                _ => Work::Binary(Binary::Pow, a, b),
            },
            Op::Binary(o, a, b) => Work::Binary(o, a, b),
            Op::Select(c, a, b) | Op::Joined(c, a, b) => Work::Select(c, a, b),
        })
    }
}

fn ordered(a: Term, b: Term) -> [Term; 2] {
    if a.kind <= b.kind { [a, b] } else { [b, a] }
}

/// How often each operation is an operand of what values need.
fn uses(ops: &[Op], is_idle: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut uses = vec![0; ops.len()];
    let mut add = |all: &[u32]| all.iter().for_each(|a| uses[*a as usize] += 1);
    for i in (0..ops.len()).filter(|i| !is_idle(*i)) {
        match ops[i] {
            Op::Const(_) | Op::Coordinate(_) => {}
            Op::Unary(_, a) | Op::Turn(_, a, _) | Op::Square(a) => add(&[a]),
            Op::Binary(_, a, b) => add(&[a, b]),
            Op::Select(c, a, b) | Op::Joined(c, a, b) => add(&[c, a, b]),
        }
    }
    uses
}

impl Program {
    /// The program of operations of which the last is the root. `is_idle` says which of them values do not need.
    pub(super) fn new(ops: &[Op], is_idle: impl Fn(usize) -> bool) -> Self {
        let fusing = Fusing { ops, uses: uses(ops, is_idle) };
        // From the root down: what has a register, and the last step that reads it.
        let root = ops.len() - 1;
        let mut last = vec![None; ops.len()];
        let mut works = Vec::new();
        last[root] = Some(root);
        for i in (0..ops.len()).rev().filter(|i| fusing.uses[*i] > 0 || *i == root) {
            let Some(work) = last[i].and_then(|_| fusing.work(i)) else { continue };
            for a in work.operands() {
                last[a].get_or_insert(i);
            }
            works.push((i, work));
        }
        works.reverse();
        let mut program = Program::default();
        let mut place = vec![RESULT; ops.len()];
        for (i, op) in ops.iter().enumerate().filter(|x| last[x.0].is_some()) {
            match *op {
                Op::Const(c) => place[i] = program.constant(c),
                Op::Coordinate(k) => place[i] = u32::from(k) % COORDINATES,
                _ => {}
            }
        }
        if works.is_empty() {
            // A constant or coordinate alone: a product with one leaves every bit as it is.
            let work = Work::Mul(Term::plain(place[root]), Term::plain(program.constant(1.0)));
            program.steps.push(Step { work, to: RESULT });
        }
        let first = program.registers as u32 + COORDINATES;
        let mut free: Vec<Register> = Vec::new();
        for (i, work) in works {
            if i != root {
                place[i] = free.pop().unwrap_or_else(|| program.register());
            }
            // Only after the result has its place: a step never overwrites what it reads.
            for a in work.operands() {
                if last[a] == Some(i) && place[a] >= first {
                    last[a] = None;
                    free.push(place[a]);
                }
            }
            program.steps.push(Step { work: work.each(|a| place[a as usize]), to: place[i] });
        }
        program
    }

    fn register(&mut self) -> Register {
        self.registers += 1;
        self.registers as u32 - 1 + COORDINATES
    }

    fn constant(&mut self, c: f64) -> Register {
        self.constants.push(c);
        self.register()
    }

    /// Values at many points.
    pub(super) fn eval(&self, p: [&[f64]; 3], out: &mut [f64]) {
        if out.len() < ALONE {
            for (k, v) in out.iter_mut().enumerate() {
                *v = self.value([p[0][k], p[1][k], p[2][k]]);
            }
            return;
        }
        thread_local! {
            static ROOM: RefCell<Vec<Block>> = const { RefCell::new(Vec::new()) };
        }
        ROOM.with_borrow_mut(|room| {
            // one more for powers
            if room.len() <= self.registers {
                room.resize(self.registers + 1, Block([0.0; BLOCK]));
            }
            in_blocks(self, p, out, room);
        });
    }

    /// The value at one point.
    pub(super) fn value(&self, p: [f64; 3]) -> f64 {
        match COORDINATES as usize + self.registers {
            ..=SMALL => self.value_in(p, &mut [0.0; SMALL]),
            n => self.value_in(p, &mut vec![0.0; n]),
        }
    }

    /// The same with room for coordinates and registers.
    fn value_in(&self, p: [f64; 3], r: &mut [f64]) -> f64 {
        let first = COORDINATES as usize;
        r[..first].copy_from_slice(&p);
        r[first..first + self.constants.len()].copy_from_slice(&self.constants);
        let mut result = f64::NAN;
        for step in &self.steps {
            let v = step.work.value(|a| r[a as usize]);
            if step.to == RESULT {
                result = v;
            } else {
                r[step.to as usize] = v;
            }
        }
        result
    }

    /// Values at the points of a block.
    #[inline(always)]
    fn run(&self, points: Points, out: &mut Lanes, room: &mut [Block]) {
        let Some((squares, registers)) = room.split_first_mut() else { return };
        for step in &self.steps {
            let at = if step.to == RESULT { registers.len() } else { (step.to - COORDINATES) as usize };
            let (before, rest) = registers.split_at_mut(at);
            let (to, after) = match rest.split_first_mut() {
                Some((to, after)) => (&mut to.0, after),
                None => (&mut *out, Default::default()),
            };
            step.work.run(&View { points, before, after }, &mut squares.0, to);
        }
    }
}

/// Values at the points of a block.
type Lanes = [f64; BLOCK];

/// Values of a register; a vector of the widest unit lies in one line of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Block(Lanes);

/// Wider vector units give the same bits: only lane-wise IEEE operations are used, and none is contracted.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn in_blocks(program: &Program, p: [&[f64]; 3], out: &mut [f64], room: &mut [Block]) {
    for (c, register) in program.constants.iter().zip(&mut room[1..]) {
        register.0 = [*c; BLOCK];
    }
    let mut padded = [[0.0; BLOCK]; 3];
    let mut values = [0.0; BLOCK];
    let [x, y, z] = p.map(|x| x[..out.len()].as_chunks::<BLOCK>());
    let blocks = x.0.len();
    let (full, rest) = out.as_chunks_mut::<BLOCK>();
    if !rest.is_empty() {
        for (x, padded) in [x.1, y.1, z.1].iter().zip(&mut padded) {
            padded[..rest.len()].copy_from_slice(x);
            padded[rest.len()..].fill(x[rest.len() - 1]);
        }
    }
    let last = padded.each_ref();
    // one place that runs a block, for all steps are inlined there
    for k in 0..blocks + usize::from(!rest.is_empty()) {
        let p = if k < blocks { [&x.0[k], &y.0[k], &z.0[k]] } else { last };
        let n = if k < blocks { BLOCK } else { rest.len().next_multiple_of(STRIDE) };
        program.run(Points { p, n }, full.get_mut(k).unwrap_or(&mut values), room);
    }
    rest.copy_from_slice(&values[..rest.len()]);
}

/// Coordinates of a block's points. Those after the first `n` repeat the last one, and what becomes of them does not matter.
#[derive(Clone, Copy)]
struct Points<'a> {
    p: [&'a Lanes; 3],
    n: usize,
}

/// What a step reads: all registers but the one it writes.
struct View<'a> {
    points: Points<'a>,
    before: &'a [Block],
    after: &'a [Block],
}

impl<'a> View<'a> {
    #[inline(always)]
    fn get(&self, r: Register) -> &'a Lanes {
        if r < COORDINATES {
            return self.points.p[r as usize];
        }
        let r = (r - COORDINATES) as usize;
        let block = if r < self.before.len() { &self.before[r] } else { &self.after[r - self.before.len() - 1] };
        &block.0
    }
}

/// `out[k] = f(k)`
#[inline(always)]
fn fill(out: &mut Lanes, f: impl Fn(usize) -> f64) {
    for k in 0..BLOCK {
        out[k] = f(k);
    }
}

/// How a term comes from its registers; those of one operand have it twice.
trait Made {
    fn of(a: f64, b: f64) -> f64;
}

macro_rules! made {
    ($($kind:ident = |$a:ident, $b:ident| $v:expr;)*) => {
        $(
            struct $kind;

            impl Made for $kind {
                #[inline(always)]
                fn of($a: f64, $b: f64) -> f64 {
                    $v
                }
            }
        )*
    };
}

made! {
    Plain = |a, _b| a;
    Square = |a, _b| a * a;
    Mul = |a, b| a * b;
    Add = |a, b| a + b;
}

/// The values of a term's two registers.
type Pair<'a> = [&'a Lanes; 2];

#[inline(always)]
fn add<L: Made, R: Made>([a, b]: Pair, [c, d]: Pair, out: &mut Lanes) {
    fill(out, |k| L::of(a[k], b[k]) + R::of(c[k], d[k]));
}

#[inline(always)]
fn sub<L: Made, R: Made>([a, b]: Pair, [c, d]: Pair, out: &mut Lanes) {
    fill(out, |k| L::of(a[k], b[k]) - R::of(c[k], d[k]));
}

#[inline(always)]
fn mul<L: Made, R: Made>([a, b]: Pair, [c, d]: Pair, out: &mut Lanes) {
    fill(out, |k| L::of(a[k], b[k]) * R::of(c[k], d[k]));
}

#[inline(always)]
fn sum<L: Made, M: Made, R: Made>([a, b]: Pair, [c, d]: Pair, [e, f]: Pair, out: &mut Lanes) {
    fill(out, |k| L::of(a[k], b[k]) + M::of(c[k], d[k]) + R::of(e[k], f[k]));
}

#[inline(always)]
fn squared<T: Made>([a, b]: Pair, out: &mut Lanes) {
    fill(out, |k| {
        let v = T::of(a[k], b[k]);
        v * v
    });
}

/// Runs what is compiled for the kinds of some terms, or else something for any.
macro_rules! by_kinds {
    ([$($term:expr),*], $run:ident $args:tt, else $other:expr, $(($($kind:ident)*))*) => {
        match ($($term.kind,)*) {
            $(($(Kind::$kind,)*) => $run::<$($kind),*>$args,)*
            #[allow(unreachable_patterns)]
            _ => $other,
        }
    };
}

impl Work {
    #[inline(always)]
    fn run(&self, view: &View, squares: &mut Lanes, out: &mut Lanes) {
        let pair = |t: Term| [view.get(t.a), view.get(t.b)];
        match *self {
            Work::Add(l, r) => by_kinds!([l, r], add(pair(l), pair(r), out), else self.each_alone(view, out),
                (Plain Plain) (Plain Square) (Plain Mul) (Plain Add) (Square Square) (Square Mul) (Square Add) (Mul Mul)
                (Mul Add)),
            Work::Sub(l, r) => by_kinds!([l, r], sub(pair(l), pair(r), out), else self.each_alone(view, out),
                (Plain Plain) (Plain Square) (Plain Mul) (Plain Add) (Square Plain) (Square Square) (Square Mul)
                (Square Add) (Mul Plain) (Mul Square) (Mul Mul) (Mul Add) (Add Plain) (Add Square) (Add Mul) (Add Add)),
            Work::Mul(l, r) => by_kinds!([l, r], mul(pair(l), pair(r), out), else self.each_alone(view, out),
                (Plain Plain) (Plain Square) (Plain Mul) (Plain Add) (Square Square) (Square Mul) (Square Add) (Mul Mul)
                (Mul Add) (Add Add)),
            Work::Sum([l, m, r]) => {
                by_kinds!([l, m, r], sum(pair(l), pair(m), pair(r), out), else self.each_alone(view, out),
                    (Plain Plain Plain) (Plain Plain Square) (Plain Plain Mul) (Plain Square Plain) (Plain Square Square)
                    (Plain Square Mul) (Plain Mul Plain) (Plain Mul Square) (Plain Mul Mul) (Square Square Plain)
                    (Square Square Square) (Square Square Mul) (Square Mul Plain) (Square Mul Square) (Square Mul Mul)
                    (Mul Mul Plain) (Mul Mul Square) (Mul Mul Mul));
            }
            Work::Squared(t) => by_kinds!([t], squared(pair(t), out), else self.each_alone(view, out),
                (Plain) (Square) (Mul) (Add)),
            Work::Unary(u, a) => unary(u, view.get(a), out, view.points.n),
            Work::Binary(o, a, b) => binary(o, [view.get(a), view.get(b)], out, view.points.n),
            Work::Power(a, n) => vector::powi_many(view.get(a), n, squares, &mut out[..view.points.n]),
            Work::Select(c, a, b) => {
                let (c, a, b) = (view.get(c), view.get(a), view.get(b));
                fill(out, |k| if c[k] >= 0.0 { a[k] } else { b[k] });
            }
        }
    }

    /// What is too rare to have a loop of its own.
    #[inline(never)]
    fn each_alone(&self, view: &View, out: &mut Lanes) {
        fill(out, |k| self.value(|r| view.get(r)[k]));
    }
}

#[inline(always)]
fn unary(op: Unary, a: &Lanes, out: &mut Lanes, n: usize) {
    let some = &mut out[..n];
    match op {
        Unary::Neg => fill(out, |k| -a[k]),
        Unary::Abs => fill(out, |k| a[k].abs()),
        Unary::Sqrt => fill(out, |k| a[k].sqrt()),
        Unary::Exp => vector::exp_many(a, some),
        Unary::Log => vector::ln_many(a, some),
        Unary::Sin => vector::sin_many(a, some),
        Unary::Cos => vector::cos_many(a, some),
        Unary::Floor => fill(out, |k| a[k].floor()),
        Unary::Wrap => fill(out, |k| Unary::Wrap.apply(a[k])),
        Unary::Swing => fill(out, |k| Unary::Swing.apply(a[k])),
        Unary::Upward => fill(out, |k| Unary::Upward.apply(a[k])),
        Unary::Downward => fill(out, |k| Unary::Downward.apply(a[k])),
        Unary::Fold => fill(out, |k| Unary::Fold.apply(a[k])),
        Unary::Steepened => fill(out, |k| Unary::Steepened.apply(a[k])),
        Unary::Tan | Unary::Asin | Unary::Acos | Unary::Sinh | Unary::Cosh | Unary::Tanh | Unary::Sign => {
            some.iter_mut().zip(a).for_each(|(v, a)| *v = op.apply(*a));
        }
    }
}

#[inline(always)]
fn binary(op: Binary, [a, b]: Pair, out: &mut Lanes, n: usize) {
    let some = &mut out[..n];
    match op {
        Binary::Div => fill(out, |k| a[k] / b[k]),
        Binary::Min => fill(out, |k| Binary::Min.apply(a[k], b[k])),
        Binary::Max => fill(out, |k| Binary::Max.apply(a[k], b[k])),
        Binary::Atan2 => vector::atan2_many(a, b, some),
        Binary::Hypot => vector::hypot_many(a, b, some),
        Binary::Mod => fill(out, |k| Binary::Mod.apply(a[k], b[k])),
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Pow => {
            some.iter_mut().zip(a.iter().zip(b)).for_each(|(v, (a, b))| *v = op.apply(*a, *b));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::numeric::Dual;

    /// One operation after the other at one point.
    fn plainly(ops: &[Op], p: [f64; 3]) -> f64 {
        let mut r: Vec<f64> = Vec::new();
        for op in ops {
            let at = |a: u32| r[a as usize];
            r.push(match *op {
                Op::Const(c) => c,
                Op::Coordinate(k) => p[k as usize],
                Op::Unary(u, a) | Op::Turn(u, a, _) => u.apply(at(a)),
                Op::Binary(o, a, b) => o.apply(at(a), at(b)),
                Op::Square(a) => at(a) * at(a),
                Op::Select(c, a, b) | Op::Joined(c, a, b) => at(if at(c) >= 0.0 { a } else { b }),
            });
        }
        r[r.len() - 1]
    }

    /// Value and gradient one operation after the other, for those that have no other functions in them.
    fn dual(ops: &[Op], p: [f64; 3]) -> Option<Dual> {
        let mut r: Vec<Dual> = Vec::new();
        for op in ops {
            let at = |a: u32| r[a as usize];
            r.push(match *op {
                Op::Const(c) => Dual::constant(c),
                Op::Coordinate(k) => Dual::new(p[k as usize], DVec3::AXES[k as usize]),
                Op::Unary(Unary::Neg, a) => -at(a),
                Op::Unary(Unary::Sqrt, a) => at(a).chain(at(a).v.sqrt(), 0.5 / at(a).v.sqrt()),
                Op::Unary(Unary::Exp, a) => at(a).chain(vector::exp(at(a).v), vector::exp(at(a).v)),
                Op::Unary(Unary::Sin, a) => at(a).chain(vector::sin(at(a).v), vector::cos(at(a).v)),
                Op::Binary(Binary::Add, a, b) => at(a) + at(b),
                Op::Binary(Binary::Sub, a, b) => at(a) - at(b),
                Op::Binary(Binary::Mul, a, b) => at(a) * at(b),
                Op::Binary(Binary::Div, a, b) => at(a) / at(b),
                Op::Square(a) => at(a) * at(a),
                Op::Select(c, a, b) => at(if at(c).v >= 0.0 { a } else { b }),
                _ => return None,
            });
        }
        r.pop()
    }

    fn same(a: f64, b: f64) -> bool {
        a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
    }

    #[test]
    fn batches_of_any_length_have_the_bits_of_operations_one_by_one() {
        let mut state = 1u64;
        let mut next = |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        let sums = [Binary::Add, Binary::Sub, Binary::Mul];
        let others = [Binary::Div, Binary::Min, Binary::Max, Binary::Atan2, Binary::Hypot, Binary::Mod, Binary::Pow];
        let unary = [Unary::Neg, Unary::Abs, Unary::Sqrt, Unary::Exp, Unary::Log, Unary::Sin, Unary::Cos, Unary::Wrap];
        let mut compared = 0;
        for _ in 0..500 {
            let mut ops = vec![Op::Coordinate(0), Op::Coordinate(1), Op::Coordinate(2), Op::Const(0.7), Op::Const(3.0)];
            for _ in 0..1 + next(30) {
                let count = ops.len();
                let mut any = || (count - 1 - next(count.min(6))) as u32;
                let (a, b, c) = (any(), any(), any());
                ops.push(match next(10) {
                    0 => Op::Unary(unary[next(unary.len())], a),
                    1 => Op::Binary(others[next(others.len())], a, b),
                    2 => Op::Binary(Binary::Pow, a, 4),
                    3 => Op::Select(a, b, c),
                    4 => Op::Square(a),
                    _ => Op::Binary(sums[next(3)], a, b),
                });
            }
            let program = Program::new(&ops, |_| false);
            let mut list = |n: usize| (0..n).map(|_| next(4001) as f64 / 1000.0 - 2.0).collect::<Vec<f64>>();
            for n in [1, 3, 40, BLOCK, 2 * BLOCK + 19] {
                let (x, y, z) = (list(n), list(n), list(n));
                let mut out = vec![0.0; n];
                program.eval([&x, &y, &z], &mut out);
                let mut slopes = [(); 4].map(|()| vec![0.0; n]);
                program.gradients([&x, &y, &z], slopes.each_mut().map(|list| &mut list[..]));
                for k in 0..n {
                    let p = [x[k], y[k], z[k]];
                    let v = plainly(&ops, p);
                    assert!(same(out[k], v), "{ops:?} {} {v}", out[k]);
                    let alone = program.gradient(p.into());
                    let many = [0, 1, 2, 3].map(|j| slopes[j][k]);
                    let [a, b, c] = alone.g.to_array();
                    assert!(many.iter().zip([a, b, c, v]).all(|(x, y)| same(*x, y)), "{ops:?} {many:?} {alone:?}");
                    assert!(same(alone.v, v), "{ops:?} {alone:?} {v}");
                    if let Some(d) = dual(&ops, p) {
                        // a zero may have another sign
                        let agree = |j: usize| d.g[j] == alone.g[j] || d.g[j].is_nan() && alone.g[j].is_nan();
                        assert!((0..3).all(agree), "{ops:?} {alone:?} {d:?}");
                        compared += 1;
                    }
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}
