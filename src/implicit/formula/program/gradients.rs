//! Gradients of a formula at many points: its program over blocks of points, with each register the values and derivatives there.
//!
//! Each point has the bits that it has alone.

use std::cell::RefCell;

use multiversion::multiversion;

use super::super::super::expr::{Binary, Unary};
use super::gradient::{Slope, Turns, VALUE};
use super::{COORDINATES, Kind, Program, RESULT, Register, Term, Work};
use crate::numeric::vector;

/// Points of a block: so many that a formula's registers stay in the first-level cache.
const LANES: usize = 64;

/// Fewer points are taken one by one.
const ALONE: usize = 8;

/// Numbers at the points of a block.
type Lanes = [f64; LANES];

/// The derivatives by x, y and z at the points of a block, then the values.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Slopes([Lanes; 4]);

impl Slopes {
    /// Of the constant 0.
    const ZERO: Slopes = Slopes([[0.0; LANES]; 4]);

    #[inline(always)]
    fn at(&self, k: usize) -> Slope {
        Slope(self.0.map(|lanes| lanes[k]))
    }
}

/// Registers, and operands that are made for one step.
#[derive(Default)]
struct Room {
    registers: Vec<Slopes>,
    terms: Vec<Slopes>,
}

/// What a step reads: all registers but the one it writes.
#[derive(Clone, Copy)]
struct View<'a> {
    before: &'a [Slopes],
    after: &'a [Slopes],
    /// How many points of the block matter.
    n: usize,
}

impl<'a> View<'a> {
    #[inline(always)]
    fn get(&self, r: Register) -> &'a Slopes {
        let r = r as usize;
        if r < self.before.len() { &self.before[r] } else { &self.after[r - self.before.len() - 1] }
    }

    /// An operand; `room` is where it is made if no register has it.
    #[inline(always)]
    fn term<'b>(&self, t: Term, room: &'b mut Slopes) -> &'b Slopes
    where
        'a: 'b,
    {
        let (a, b) = (self.get(t.a), self.get(t.b));
        match t.kind {
            Kind::Plain => return a,
            Kind::Square => square(a, room),
            Kind::Mul => mul(a, b, room),
            Kind::Add => add(a, b, room),
        }
        room
    }
}

#[inline(always)]
fn fill(out: &mut Lanes, f: impl Fn(usize) -> f64) {
    for k in 0..LANES {
        out[k] = f(k);
    }
}

#[inline(always)]
fn add(Slopes(a): &Slopes, Slopes(b): &Slopes, out: &mut Slopes) {
    for j in 0..4 {
        fill(&mut out.0[j], |k| a[j][k] + b[j][k]);
    }
}

#[inline(always)]
fn sub(Slopes(a): &Slopes, Slopes(b): &Slopes, out: &mut Slopes) {
    for j in 0..4 {
        fill(&mut out.0[j], |k| a[j][k] - b[j][k]);
    }
}

#[inline(always)]
fn mul(Slopes([ax, ay, az, a]): &Slopes, Slopes([bx, by, bz, b]): &Slopes, out: &mut Slopes) {
    let [x, y, z, v] = &mut out.0;
    for k in 0..LANES {
        x[k] = ax[k] * b[k] + bx[k] * a[k];
        y[k] = ay[k] * b[k] + by[k] * a[k];
        z[k] = az[k] * b[k] + bz[k] * a[k];
        v[k] = a[k] * b[k];
    }
}

#[inline(always)]
fn square(Slopes([ax, ay, az, a]): &Slopes, out: &mut Slopes) {
    let [x, y, z, v] = &mut out.0;
    for k in 0..LANES {
        x[k] = 2.0 * (ax[k] * a[k]);
        y[k] = 2.0 * (ay[k] * a[k]);
        z[k] = 2.0 * (az[k] * a[k]);
        v[k] = a[k] * a[k];
    }
}

/// Derivatives by the chain rule, for the derivatives `d` of a function of `a`.
#[inline(always)]
fn chain(Slopes([ax, ay, az, _]): &Slopes, d: &Lanes, out: &mut Slopes) {
    let [x, y, z, _] = &mut out.0;
    for k in 0..LANES {
        let still = (ax[k] == 0.0) & (ay[k] == 0.0) & (az[k] == 0.0);
        let by = |g: f64| if still { 0.0 } else { g * d[k] };
        (x[k], y[k], z[k]) = (by(ax[k]), by(ay[k]), by(az[k]));
    }
}

impl Work {
    #[inline(always)]
    fn slopes(&self, view: View, [s, t, u]: &mut [Slopes; 3], out: &mut Slopes) {
        match *self {
            Work::Add(a, b) => add(view.term(a, s), view.term(b, t), out),
            Work::Sub(a, b) => sub(view.term(a, s), view.term(b, t), out),
            Work::Mul(a, b) => mul(view.term(a, s), view.term(b, t), out),
            Work::Sum([a, b, c]) => {
                let (Slopes(a), Slopes(b), Slopes(c)) = (view.term(a, s), view.term(b, t), view.term(c, u));
                for j in 0..4 {
                    fill(&mut out.0[j], |k| a[j][k] + b[j][k] + c[j][k]);
                }
            }
            Work::Squared(a) => square(view.term(a, s), out),
            Work::Unary(Unary::Neg, a) => {
                let Slopes(a) = view.get(a);
                for j in 0..4 {
                    fill(&mut out.0[j], |k| -a[j][k]);
                }
            }
            Work::Unary(op, a) => {
                let a = view.get(a);
                if unary(op, &a.0[VALUE], [&mut out.0[VALUE], &mut s.0[0]], view.n) {
                    chain(a, &s.0[0], out);
                } else {
                    self.slopes_alone(view, out);
                }
            }
            Work::Binary(op, a, b) => {
                if !binary(op, view.get(a), view.get(b), out, view.n) {
                    self.slopes_alone(view, out);
                }
            }
            Work::Power(a, n) if Binary::is_whole_power(f64::from(n) - 1.0) => {
                let a = view.get(a);
                let [d, squares, ..] = &mut s.0;
                vector::powi_many(&a.0[VALUE], n, squares, &mut out.0[VALUE][..view.n]);
                vector::powi_many(&a.0[VALUE], n - 1, squares, &mut d[..view.n]);
                d.iter_mut().for_each(|d| *d *= f64::from(n));
                chain(a, d, out);
            }
            Work::Power(..) => self.slopes_alone(view, out),
            Work::Select(c, a, b) => {
                let (c, Slopes(a), Slopes(b)) = (&view.get(c).0[VALUE], view.get(a), view.get(b));
                for j in 0..4 {
                    fill(&mut out.0[j], |k| if c[k] >= 0.0 { a[j][k] } else { b[j][k] });
                }
            }
        }
    }

    /// What is too rare to have loops of its own.
    #[inline(never)]
    fn slopes_alone(&self, view: View, out: &mut Slopes) {
        for k in 0..view.n {
            let made = self.slope(|r| view.get(r).at(k), &mut Turns::default());
            for j in 0..4 {
                out.0[j][k] = made.0[j];
            }
        }
    }
}

/// Values and derivatives of a function, if it has loops of its own.
#[inline(always)]
fn unary(op: Unary, a: &Lanes, [v, d]: [&mut Lanes; 2], n: usize) -> bool {
    match op {
        Unary::Abs => {
            fill(v, |k| a[k].abs());
            fill(d, |k| if a[k] < 0.0 { -1.0 } else { 1.0 });
        }
        Unary::Sqrt => {
            fill(v, |k| a[k].sqrt());
            fill(d, |k| 0.5 / v[k]);
        }
        Unary::Exp => {
            vector::exp_many(a, &mut v[..n]);
            *d = *v;
        }
        Unary::Log => {
            vector::ln_many(a, &mut v[..n]);
            fill(d, |k| 1.0 / a[k]);
        }
        Unary::Sin => {
            vector::sin_many(a, &mut v[..n]);
            vector::cos_many(a, &mut d[..n]);
        }
        Unary::Cos => {
            vector::cos_many(a, &mut v[..n]);
            vector::sin_many(a, &mut d[..n]);
            d.iter_mut().for_each(|d| *d = -*d);
        }
        _ => return false,
    }
    true
}

/// What becomes of two operands, if the operation has loops of its own.
#[inline(always)]
fn binary(op: Binary, Slopes(a): &Slopes, Slopes(b): &Slopes, out: &mut Slopes, n: usize) -> bool {
    let (x, y) = (&a[VALUE], &b[VALUE]);
    let [first @ .., v] = &mut out.0;
    match op {
        Binary::Div => {
            fill(v, |k| x[k] / y[k]);
            for j in 0..3 {
                fill(&mut first[j], |k| (a[j][k] - b[j][k] * v[k]) / y[k]);
            }
        }
        Binary::Min | Binary::Max => {
            let larger = op == Binary::Max;
            for j in 0..4 {
                fill(&mut out.0[j], |k| {
                    let decides = if larger { x[k] > y[k] } else { x[k] < y[k] };
                    if x[k].is_nan() || decides { a[j][k] } else { b[j][k] }
                });
            }
        }
        Binary::Atan2 => {
            vector::atan2_many(x, y, &mut v[..n]);
            for j in 0..3 {
                fill(&mut first[j], |k| (a[j][k] * y[k] - b[j][k] * x[k]) / (x[k] * x[k] + y[k] * y[k]));
            }
        }
        Binary::Hypot => {
            vector::hypot_many(x, y, &mut v[..n]);
            for j in 0..3 {
                fill(&mut first[j], |k| (a[j][k] * x[k] + b[j][k] * y[k]) / v[k]);
            }
        }
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Pow | Binary::Mod => return false,
    }
    true
}

impl Program {
    /// Derivatives by x, y and z at many points, then values.
    pub(in super::super) fn gradients(&self, p: [&[f64]; 3], out: [&mut [f64]; 4]) {
        let n = out[VALUE].len();
        if n < ALONE {
            for k in 0..n {
                let made = self.slope([p[0][k], p[1][k], p[2][k]]);
                for j in 0..4 {
                    out[j][k] = made.0[j];
                }
            }
            return;
        }
        thread_local! {
            static ROOM: RefCell<Room> = RefCell::new(Room::default());
        }
        ROOM.with_borrow_mut(|room| {
            let count = COORDINATES as usize + self.registers;
            if room.registers.len() < count {
                room.registers.resize(count, Slopes::ZERO);
            }
            room.terms.resize(4, Slopes::ZERO);
            in_blocks(self, p, out, room);
        });
    }

    #[inline(always)]
    fn run_slopes(&self, n: usize, registers: &mut [Slopes], terms: &mut [Slopes; 3], result: &mut Slopes) {
        for step in &self.steps {
            let at = if step.to == RESULT { registers.len() } else { step.to as usize };
            let (before, rest) = registers.split_at_mut(at);
            let (to, after) = match rest.split_first_mut() {
                Some((to, after)) => (to, after),
                None => (&mut *result, Default::default()),
            };
            step.work.slopes(View { before, after, n }, terms, to);
        }
    }
}

/// Wider vector units give the same bits: only lane-wise IEEE operations are used, and none is contracted.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn in_blocks(program: &Program, p: [&[f64]; 3], out: [&mut [f64]; 4], room: &mut Room) {
    let Room { registers, terms } = room;
    let Some((result, terms)) = terms.split_first_mut() else { return };
    let Some(terms) = terms.first_chunk_mut::<3>() else { return };
    for (k, r) in registers[..COORDINATES as usize].iter_mut().enumerate() {
        for j in 0..VALUE {
            r.0[j].fill(if j == k { 1.0 } else { 0.0 });
        }
    }
    for (r, c) in registers[COORDINATES as usize..].iter_mut().zip(&program.constants) {
        r.0[..VALUE].as_flattened_mut().fill(0.0);
        r.0[VALUE].fill(*c);
    }
    let total = out[VALUE].len();
    for start in (0..total).step_by(LANES) {
        let n = LANES.min(total - start);
        for (r, x) in registers.iter_mut().zip(p) {
            let x = &x[start..start + n];
            r.0[VALUE][..n].copy_from_slice(x);
            r.0[VALUE][n..].fill(x[n - 1]);
        }
        program.run_slopes(n, registers, terms, result);
        for j in 0..4 {
            out[j][start..start + n].copy_from_slice(&result.0[j][..n]);
        }
    }
}
