//! The sign companion of a tree as a flat tape: signed leaves joined by min and max.
//!
//! The companion has the sign of the R-function tree, whatever the R-system, and is what culling, inside tests and root
//! bracketing use. Pruning a tape over a box drops every operand that cannot decide the *sign* there: a conjunct that is
//! positive on the whole box, a disjunct that is negative. The pruned tape has the same sign at every point of the box,
//! not the same value, so values of differently pruned tapes are never mixed.

mod prune;

use glam::DVec3;
use multiversion::multiversion;
use rustc_hash::FxHashMap;

use super::leaf::Leaf;
use super::rfunction::RSystem;
use crate::numeric::{Dual, Interval};
use crate::spatial::Aabb;

/// One operation; operands are indices of earlier operations of the same tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    /// Everything (`true`) or nothing.
    All(bool),
    /// A leaf or its complement; `face` is the face this occurrence makes.
    Leaf { leaf: u32, face: u32, negate: bool },
    /// R-conjunction.
    Min(u32, u32),
    /// R-disjunction.
    Max(u32, u32),
}

/// A tree in evaluation order; the last operation is the root.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tape {
    pub(crate) ops: Vec<Op>,
}

/// An occurrence of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Active {
    pub(crate) leaf: u32,
    pub(crate) face: u32,
    pub(crate) negate: bool,
    /// The companion's value.
    pub(crate) value: f64,
}

impl Active {
    /// Value and gradient of the occurrence, sign included.
    pub(crate) fn gradient(&self, leaves: &[Leaf], p: DVec3) -> Dual {
        match leaves.get(self.leaf as usize) {
            Some(leaf) if self.negate => -leaf.gradient(p),
            Some(leaf) => leaf.gradient(p),
            None => Dual::constant(self.value),
        }
    }
}

/// What a box tells about a tape.
pub(crate) enum Pruned {
    /// Negative everywhere on the box.
    Outside,
    /// Positive everywhere on the box.
    Inside,
    /// Nothing could be dropped.
    Same,
    /// A smaller tape with the same sign everywhere on the box.
    Smaller(Tape),
}

/// Registers kept between evaluations.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    registers: Vec<f64>,
    /// The register of each operation.
    place: Vec<u32>,
    free: Vec<u32>,
    faces: Vec<u32>,
    intervals: Vec<Interval>,
    renumber: Vec<u32>,
    /// The first operation of each kind with the same operands.
    numbers: FxHashMap<Op, u32>,
    /// Whether a formula has given NaN or an infinite value since this was last cleared.
    pub(crate) not_finite: bool,
}

/// Coordinates and registers of a block are kept within this many numbers, so that they stay in the first-level cache.
const BLOCK_NUMBERS: usize = 3 << 10;

/// The number of points in a block is a multiple of this.
const STRIDE: usize = 128;

/// Blocks have no more points: a longer one saves nothing.
const LONGEST: usize = 1024;

/// Registers of a batch that keeps all are kept within this many numbers, so that they stay in the second-level cache.
const BATCH_REGISTERS: usize = 1 << 16;

/// The register that stands for the batch's result.
pub(super) const RESULT: u32 = u32::MAX;

/// Value of "everything": far from zero, so that it decides nothing.
pub(super) const EVERYTHING: f64 = f64::MAX;

impl Tape {
    /// The single face of a tape that has only one leaf.
    pub(crate) fn only_face(&self) -> Option<u32> {
        match self.ops[..] {
            [Op::Leaf { face, .. }] => Some(face),
            _ => None,
        }
    }

    /// How many times leaves occur.
    pub(crate) fn leaf_count(&self) -> usize {
        self.ops.iter().filter(|op| matches!(op, Op::Leaf { .. })).count()
    }

    /// Signed values at many points; never zero, NaN only where a formula is NaN.
    pub(crate) fn eval(&self, leaves: &[Leaf], points: [&[f64]; 3], out: &mut [f64], scratch: &mut Scratch) {
        let [xs, ys, zs] = points;
        let Scratch { registers, place, free, not_finite, .. } = scratch;
        let count = self.placed(place, free);
        let lanes = (BLOCK_NUMBERS / (3 + count)).next_multiple_of(STRIDE).min(LONGEST);
        let tape = Placed { ops: &self.ops, place, count };
        let mut start = 0;
        while start < out.len() {
            let end = (start + lanes).min(out.len());
            let p = [&xs[start..end], &ys[start..end], &zs[start..end]];
            *not_finite |= !eval_block(tape, leaves, p, &mut out[start..end], registers);
            start = end;
        }
    }

    /// Gives each operation a register that nobody needs any more, and the root the result's; the number of registers.
    fn placed(&self, place: &mut Vec<u32>, free: &mut Vec<u32>) -> usize {
        let n = self.ops.len();
        let mut count = 0;
        free.clear();
        place.clear();
        // From the root down an operation's register is wanted where its value is read last, and free above where it is made.
        place.resize(n, RESULT);
        for (i, op) in self.ops.iter().enumerate().rev() {
            if let Op::Min(a, b) | Op::Max(a, b) = *op {
                for a in [a, b] {
                    if place[a as usize] == RESULT {
                        place[a as usize] = free.pop().unwrap_or_else(|| {
                            count += 1;
                            count - 1
                        });
                    }
                }
            }
            if place[i] != RESULT {
                free.push(place[i]);
            }
        }
        count as usize
    }

    /// Faces of the deciding leaves at many points.
    pub(crate) fn faces(&self, leaves: &[Leaf], points: [&[f64]; 3], out: &mut [u32], scratch: &mut Scratch) {
        let [xs, ys, zs] = points;
        if let Some(face) = self.only_face() {
            out.fill(face);
            return;
        }
        let lanes = (BATCH_REGISTERS / self.ops.len()).clamp(4, out.len().max(4));
        let mut values = vec![0.0; lanes.min(out.len())];
        scratch.place.clear();
        scratch.place.extend(0..self.ops.len() as u32 - 1);
        scratch.place.push(RESULT);
        let mut start = 0;
        while start < out.len() {
            let end = (start + lanes).min(out.len());
            let n = end - start;
            let regs = &mut scratch.registers;
            let tape = Placed { ops: &self.ops, place: &scratch.place, count: self.ops.len() - 1 };
            eval_block(tape, leaves, [&xs[start..end], &ys[start..end], &zs[start..end]], &mut values[..n], regs);
            let faces = &mut scratch.faces;
            faces.clear();
            faces.resize(n * self.ops.len(), u32::MAX);
            for (i, op) in self.ops.iter().enumerate() {
                let (before, rest) = faces.split_at_mut(i * n);
                let dst = &mut rest[..n];
                let (a, b, larger) = match *op {
                    Op::All(_) => continue,
                    Op::Leaf { face, .. } => {
                        dst.fill(face);
                        continue;
                    }
                    Op::Min(a, b) => (a as usize * n, b as usize * n, false),
                    Op::Max(a, b) => (a as usize * n, b as usize * n, true),
                };
                for k in 0..n {
                    let take_a = (regs[a + k] < regs[b + k]) != larger;
                    dst[k] = before[if take_a { a } else { b } + k];
                }
            }
            out[start..end].copy_from_slice(&faces[(self.ops.len() - 1) * n..]);
            start = end;
        }
    }

    /// Signed value at one point.
    pub(crate) fn value(&self, leaves: &[Leaf], p: DVec3) -> f64 {
        self.active(leaves, p).value
    }

    /// The occurrence that decides the companion's value at a point.
    pub(crate) fn active(&self, leaves: &[Leaf], p: DVec3) -> Active {
        // Value of each operation, and the operation it comes from.
        let (value, from) = self.each((0.0, 0), |i, op, r: &[(f64, u32)]| match *op {
            Op::All(inside) => (if inside { EVERYTHING } else { -EVERYTHING }, i),
            Op::Leaf { leaf, negate, .. } => {
                let mut value = [leaves[leaf as usize].value(p)];
                Leaf::sign(&mut value, negate);
                (value[0], i)
            }
            Op::Min(a, b) => {
                let (a, b) = (r[a as usize], r[b as usize]);
                if a.0 < b.0 { a } else { b }
            }
            Op::Max(a, b) => {
                let (a, b) = (r[a as usize], r[b as usize]);
                if a.0 < b.0 { b } else { a }
            }
        });
        match self.ops[from as usize] {
            Op::Leaf { leaf, face, negate } => Active { leaf, face, negate, value },
            _ => Active { leaf: u32::MAX, face: u32::MAX, negate: false, value },
        }
    }

    /// Results of all operations, each from those before it; that of the last one. Short tapes are worked on without memory of
    /// their own.
    fn each<T: Copy>(&self, empty: T, mut f: impl FnMut(u32, &Op, &[T]) -> T) -> T {
        /// Operations of a short tape. Cells have a handful; a list of this length on the stack costs nothing.
        const SHORT: usize = 24;
        let (mut few, mut many) = ([empty; SHORT], Vec::new());
        let n = self.ops.len();
        let results = if n <= SHORT {
            &mut few[..n]
        } else {
            many.resize(n, empty);
            &mut many[..]
        };
        for (i, op) in self.ops.iter().enumerate() {
            results[i] = f(i as u32, op, results);
        }
        results[n - 1]
    }

    /// The value of the R-function tree itself.
    pub(crate) fn r_value(&self, leaves: &[Leaf], system: RSystem, p: DVec3) -> f64 {
        let mut r: Vec<f64> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            r.push(match *op {
                Op::All(inside) => {
                    if inside {
                        EVERYTHING.sqrt()
                    } else {
                        -EVERYTHING.sqrt()
                    }
                }
                Op::Leaf { leaf, negate, .. } => {
                    let mut value = [leaves[leaf as usize].value(p)];
                    Leaf::sign(&mut value, negate);
                    value[0]
                }
                Op::Min(a, b) => system.and(r[a as usize], r[b as usize]),
                Op::Max(a, b) => system.or(r[a as usize], r[b as usize]),
            });
        }
        r[r.len() - 1]
    }

    /// Value and gradient of the R-function tree itself. The gradient is exact wherever it exists.
    pub(crate) fn r_gradient(&self, leaves: &[Leaf], system: RSystem, p: DVec3) -> Dual {
        let mut r: Vec<Dual> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            r.push(match *op {
                Op::All(inside) => Dual::constant(if inside { EVERYTHING.sqrt() } else { -EVERYTHING.sqrt() }),
                Op::Leaf { leaf, negate, .. } => {
                    let d = leaves[leaf as usize].gradient(p);
                    if negate { -d } else { d }
                }
                Op::Min(a, b) => {
                    let (a, b) = (r[a as usize], r[b as usize]);
                    let (pa, pb) = system.and_partials(a.v, b.v);
                    Dual::new(system.and(a.v, b.v), a.g * pa + b.g * pb)
                }
                Op::Max(a, b) => {
                    let (a, b) = (r[a as usize], r[b as usize]);
                    let (pa, pb) = system.or_partials(a.v, b.v);
                    Dual::new(system.or(a.v, b.v), a.g * pa + b.g * pb)
                }
            });
        }
        r[r.len() - 1]
    }

    /// Whether a point is inside in up to eight cases, one to a bit, when the signs of some leaves are given for each case and
    /// the others have their own.
    pub(crate) fn inside_with(&self, leaves: &[Leaf], p: DVec3, forced: &[(u32, u8)]) -> u8 {
        self.asked(|leaf| match forced.iter().find(|f| f.0 == leaf) {
            // Where it has come to an end its sign is no matter of sides.
            Some(f) if leaves[leaf as usize].reaches(p) => f.1,
            _ => all_cases(leaves[leaf as usize].value(p) >= 0.0),
        })
    }

    /// [`inside_cases`](Self::inside_cases) where leaves are slow to ask: only those are that others have not made up for. Second
    /// operands come first: in a chain of operations they are the shorter ones.
    fn asked(&self, positive: impl Fn(u32) -> u8) -> u8 {
        /// Operations of a short tape: those of cells near corners have up to twenty leaves, and one less to join them.
        const SHORT: usize = 40;
        /// No case is known yet: results take eight bits.
        const UNKNOWN: u16 = u16::MAX;
        let n = self.ops.len();
        let (mut few, mut many) = ([(UNKNOWN, 0u32); SHORT], Vec::new());
        many.resize(if n <= SHORT { 0 } else { n }, (UNKNOWN, 0));
        let room = if n <= SHORT { &mut few[..n] } else { &mut many[..] };
        room[0].1 = n as u32 - 1;
        let mut waiting = 1;
        while waiting > 0 {
            let i = room[waiting - 1].1;
            let joined =
                |a: u32, b: u32, decides: u8, join: fn(u8, u8) -> u8| match (room[a as usize].0, room[b as usize].0) {
                    (_, UNKNOWN) => Err(b),
                    (_, y) if y as u8 == decides => Ok(decides),
                    (UNKNOWN, _) => Err(a),
                    (x, y) => Ok(join(x as u8, y as u8)),
                };
            let known = match self.ops[i as usize] {
                Op::All(inside) => Ok(all_cases(inside)),
                Op::Leaf { leaf, negate, .. } => Ok(positive(leaf) ^ all_cases(negate)),
                Op::Min(a, b) => joined(a, b, all_cases(false), |x, y| x & y),
                Op::Max(a, b) => joined(a, b, all_cases(true), |x, y| x | y),
            };
            match known {
                Ok(cases) => {
                    room[i as usize].0 = u16::from(cases);
                    waiting -= 1;
                }
                Err(operand) => {
                    room[waiting].1 = operand;
                    waiting += 1;
                }
            }
        }
        room[n - 1].0 as u8
    }

    /// Whether a point is inside that lies on the positive side of the leaves `positive` says.
    pub(crate) fn inside_by(&self, positive: impl Fn(u32) -> bool) -> bool {
        self.inside_cases(|leaf| all_cases(positive(leaf))) != 0
    }

    /// The face that a leaf makes at a point of it beside which other leaves are positive where `positive` says: of a leaf under
    /// several names the first occurrence that alone makes inside of outside, else the first that alone makes outside of inside.
    pub(crate) fn owner(&self, leaf: u32, positive: &dyn Fn(u32) -> bool) -> u32 {
        let of = |op: &Op| match *op {
            Op::Leaf { leaf: l, face, .. } if l == leaf => Some(face),
            _ => None,
        };
        let mut all = self.ops.iter().enumerate().filter_map(|(i, op)| Some((i as u32, of(op)?)));
        let Some((_, first)) = all.next() else { return u32::MAX };
        if all.clone().all(|x| x.1 == first) {
            return first;
        }
        // Inside when one occurrence is on the side `one`, and the others are not.
        let with = |which: u32, one: bool| {
            self.each(false, |i, op, r: &[bool]| match *op {
                Op::All(inside) => inside,
                Op::Leaf { leaf: l, negate, .. } if l == leaf => ((i == which) == one) != negate,
                Op::Leaf { leaf: l, negate, .. } => positive(l) != negate,
                Op::Min(a, b) => r[a as usize] && r[b as usize],
                Op::Max(a, b) => r[a as usize] || r[b as usize],
            })
        };
        let inner = with(u32::MAX, false);
        for (makes, side) in [(true, inner), (false, !inner)] {
            let alone = |x: &(u32, u32)| with(x.0, side) == makes;
            let mut all = self.ops.iter().enumerate().filter_map(|(i, op)| Some((i as u32, of(op)?)));
            if let Some(x) = all.find(alone) {
                return x.1;
            }
        }
        first
    }

    /// Whether what has the signs `positive` says is inside, in eight cases at a time.
    pub(crate) fn inside_cases(&self, positive: impl Fn(u32) -> u8) -> u8 {
        self.each(0, |_, op, r: &[u8]| match *op {
            Op::All(inside) => all_cases(inside),
            Op::Leaf { leaf, negate, .. } => positive(leaf) ^ all_cases(negate),
            Op::Min(a, b) => r[a as usize] & r[b as usize],
            Op::Max(a, b) => r[a as usize] | r[b as usize],
        })
    }

    /// Bounds of the companion over a box.
    pub(crate) fn range(&self, leaves: &[Leaf], cell: &Aabb) -> Interval {
        let mut r = Vec::with_capacity(self.ops.len());
        self.ranges(leaves, cell, &mut r);
        r[r.len() - 1]
    }

    fn ranges(&self, leaves: &[Leaf], cell: &Aabb, r: &mut Vec<Interval>) {
        r.clear();
        for op in &self.ops {
            r.push(match *op {
                Op::All(inside) => Interval::point(if inside { EVERYTHING } else { -EVERYTHING }),
                Op::Leaf { leaf, negate, .. } => {
                    let i = leaves[leaf as usize].range(cell);
                    if negate { -i } else { i }
                }
                Op::Min(a, b) => r[a as usize].min(r[b as usize]),
                Op::Max(a, b) => r[a as usize].max(r[b as usize]),
            });
        }
    }
}

/// The same in all of eight cases.
fn all_cases(inside: bool) -> u8 {
    if inside { u8::MAX } else { 0 }
}

/// A tape whose operations have registers.
#[derive(Clone, Copy)]
struct Placed<'a> {
    ops: &'a [Op],
    place: &'a [u32],
    /// How many registers there are.
    count: usize,
}

/// Whether all values of formulas were finite. Wider vector units give the same bits: only lane-wise IEEE operations are used, and none is contracted.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn eval_block(tape: Placed, leaves: &[Leaf], p: [&[f64]; 3], out: &mut [f64], registers: &mut Vec<f64>) -> bool {
    let n = out.len();
    let mut finite = true;
    if registers.len() < n * tape.count {
        registers.resize(n * tape.count, 0.0);
    }
    for (op, place) in tape.ops.iter().zip(tape.place) {
        let at = if *place == RESULT { registers.len() } else { *place as usize * n };
        let (before, rest) = registers.split_at_mut(at);
        let (dst, after) = if *place == RESULT { (&mut *out, rest) } else { rest.split_at_mut(n) };
        let register = |a: u32| {
            let from = tape.place[a as usize] as usize * n;
            if from < at { &before[from..from + n] } else { &after[from - at - n..][..n] }
        };
        match *op {
            Op::All(inside) => dst.fill(if inside { EVERYTHING } else { -EVERYTHING }),
            Op::Leaf { leaf, negate, .. } => {
                finite &= leaves[leaf as usize].eval_signed(p, negate, dst);
            }
            Op::Min(a, b) => {
                let (a, b) = (register(a), register(b));
                for k in 0..n {
                    dst[k] = if a[k] < b[k] { a[k] } else { b[k] };
                }
            }
            Op::Max(a, b) => {
                let (a, b) = (register(a), register(b));
                for k in 0..n {
                    dst[k] = if a[k] > b[k] { a[k] } else { b[k] };
                }
            }
        }
    }
    finite
}
