//! What of a tape can decide the sign on a box.

use rustc_hash::FxHashMap;

use super::super::leaf::Leaf;
use super::{EVERYTHING, Op, Pruned, Scratch, Tape};
use crate::numeric::{Interval, NONE};
use crate::spatial::Aabb;

/// Operands with more operations than this are not compared: cases of formulas have a handful where little can be decided.
const MOST_COMPARED: usize = 64;

impl Tape {
    /// Drops what cannot decide the sign on the box.
    pub(crate) fn prune(&self, leaves: &[Leaf], cell: &Aabb, scratch: &mut Scratch) -> Pruned {
        let r = &mut scratch.intervals;
        self.ranges(leaves, cell, r);
        // `renumber[i]`: what stands for operation i. An operand that is decided never is needed: if it decided the
        // operation, that would be decided too, and so on up to the root, which is not.
        let n = self.ops.len();
        let alias = &mut scratch.renumber;
        alias.clear();
        alias.resize(2 * n, NONE);
        let (alias, needed) = alias.split_at_mut(n);
        scratch.numbers.clear();
        for (i, op) in self.ops.iter().enumerate() {
            // What is known of operands by their opposites is not yet in the range.
            match *op {
                Op::Min(a, b) => r[i] = r[a as usize].min(r[b as usize]),
                Op::Max(a, b) => r[i] = r[a as usize].max(r[b as usize]),
                _ => {}
            }
            if let Some(inside) = self.by_opposites(i, alias) {
                r[i] = Interval::point(if inside { EVERYTHING } else { -EVERYTHING });
            }
            alias[i] = match *op {
                Op::Min(a, _) if r[a as usize].lo > 0.0 => alias_of(self.ops[i], alias, true),
                Op::Min(a, b) if r[b as usize].lo > 0.0 => alias[a as usize],
                Op::Max(a, _) if r[a as usize].hi < 0.0 => alias_of(self.ops[i], alias, true),
                Op::Max(a, b) if r[b as usize].hi < 0.0 => alias[a as usize],
                _ => self.undivided(i, alias).unwrap_or_else(|| self.first_alike(i, alias, &mut scratch.numbers)),
            };
        }
        if r[n - 1].hi < 0.0 {
            return Pruned::Outside;
        }
        if r[n - 1].lo > 0.0 {
            return Pruned::Inside;
        }
        let top = alias[n - 1] as usize;
        needed[top] = 0;
        let mut count = 0;
        for i in (0..=top).rev() {
            if needed[i] == NONE {
                continue;
            }
            count += 1;
            if let Op::Min(a, b) | Op::Max(a, b) = self.ops[i] {
                needed[alias[a as usize] as usize] = 0;
                needed[alias[b as usize] as usize] = 0;
            }
        }
        if count == n {
            return Pruned::Same;
        }
        let mut ops = Vec::with_capacity(count);
        for i in 0..=top {
            if needed[i] == NONE {
                continue;
            }
            let at = |a: u32, needed: &[u32]| needed[alias[a as usize] as usize];
            ops.push(match self.ops[i] {
                Op::Min(a, b) => Op::Min(at(a, needed), at(b, needed)),
                Op::Max(a, b) => Op::Max(at(a, needed), at(b, needed)),
                other => other,
            });
            needed[i] = ops.len() as u32 - 1;
        }
        Pruned::Smaller(Tape { ops })
    }

    /// The first operation that does the same with the same operands, or what an operation always gives: `x` for `x & (x | y)`, `x & y` for
    /// `x & (x & y)`. Once much is decided copies of one thing are left, as of what every fillet between two solids is bounded by.
    fn first_alike(&self, i: usize, alias: &[u32], numbers: &mut FxHashMap<Op, u32>) -> u32 {
        let known = |op: Op| match op {
            Op::Min(a, b) => Op::Min(alias[a as usize], alias[b as usize]),
            Op::Max(a, b) => Op::Max(alias[a as usize], alias[b as usize]),
            other => other,
        };
        let op = known(self.ops[i]);
        if let Op::Min(x, y) | Op::Max(x, y) = op {
            if x == y {
                return x;
            }
            for (x, y) in [(x, y), (y, x)] {
                match (op, known(self.ops[y as usize])) {
                    (Op::Min(..), Op::Max(p, q)) | (Op::Max(..), Op::Min(p, q)) if x == p || x == q => return x,
                    (Op::Min(..), Op::Min(p, q)) | (Op::Max(..), Op::Max(p, q)) if x == p || x == q => return y,
                    _ => {}
                }
            }
        }
        *numbers.entry(op).or_insert(i as u32)
    }

    /// What is on both sides of a leaf, where an operation only parts one thing by it: X for `(d & X) | (!d & X)`. Formulas by cases
    /// become that where their cases agree. `alias` stands for operations before this one.
    fn undivided(&self, i: usize, alias: &[u32]) -> Option<u32> {
        let (a, b, joins) = match self.ops[i] {
            Op::Max(a, b) => (a, b, true),
            Op::Min(a, b) => (a, b, false),
            _ => return None,
        };
        let parts = |i: u32| match self.ops[alias[i as usize] as usize] {
            Op::Min(x, y) if joins => Some([(x, y), (y, x)]),
            Op::Max(x, y) if !joins => Some([(x, y), (y, x)]),
            _ => None,
        };
        let (here, there) = (parts(a)?, parts(b)?);
        let agree = |p: &(u32, u32), q: &(u32, u32)| self.opposite(p.0, q.0, alias) && self.same(p.1, q.1, alias);
        here.iter().find(|p| there.iter().any(|q| agree(p, q))).map(|p| alias[p.1 as usize])
    }

    /// What `d | !d` and `d & !d` are: what is divided is decided on both sides alike.
    fn by_opposites(&self, i: usize, alias: &[u32]) -> Option<bool> {
        match self.ops[i] {
            Op::Max(a, b) => self.opposite(a, b, alias).then_some(true),
            Op::Min(a, b) => self.opposite(a, b, alias).then_some(false),
            _ => None,
        }
    }

    /// Whether one operation is the complement of the other by their operands, as far as few of them tell.
    fn opposite(&self, a: u32, b: u32, alias: &[u32]) -> bool {
        self.alike(a, b, &Compared { alias, opposite: true }, &mut { MOST_COMPARED })
    }

    /// Whether two operations are one by their operands, as far as few of them tell.
    fn same(&self, a: u32, b: u32, alias: &[u32]) -> bool {
        self.alike(a, b, &Compared { alias, opposite: false }, &mut { MOST_COMPARED })
    }

    fn alike(&self, a: u32, b: u32, how: &Compared<'_>, left: &mut usize) -> bool {
        if *left == 0 {
            return false;
        }
        *left -= 1;
        let (a, b) = (how.alias[a as usize], how.alias[b as usize]);
        if a == b {
            return !how.opposite;
        }
        match (self.ops[a as usize], self.ops[b as usize]) {
            (Op::Min(a, c), Op::Min(b, d)) | (Op::Max(a, c), Op::Max(b, d)) if !how.opposite => {
                self.alike(a, b, how, left) && self.alike(c, d, how, left)
            }
            (Op::Min(a, c), Op::Max(b, d)) | (Op::Max(a, c), Op::Min(b, d)) if how.opposite => {
                self.alike(a, b, how, left) && self.alike(c, d, how, left)
            }
            (Op::Leaf { leaf: a, negate: p, .. }, Op::Leaf { leaf: b, negate: q, .. }) if how.opposite => {
                a == b && p != q
            }
            (Op::All(a), Op::All(b)) if how.opposite => a != b,
            (p @ (Op::Leaf { .. } | Op::All(_)), q) => p == q && !how.opposite,
            _ => false,
        }
    }
}

/// How operations are compared.
struct Compared<'a> {
    /// What stands for each.
    alias: &'a [u32],
    /// Whether one is to be the complement of the other.
    opposite: bool,
}

/// What stands for the second (or first) operand of an operation.
fn alias_of(op: Op, alias: &[u32], second: bool) -> u32 {
    match op {
        Op::Min(a, b) | Op::Max(a, b) => alias[if second { b } else { a } as usize],
        _ => u32::MAX,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::lower::lower;
    use crate::implicit::solid::Solid;

    #[test]
    fn copies_of_one_thing_are_one() {
        let (a, b) = (Solid::half_space(DVec3::X, DVec3::ZERO), Solid::half_space(DVec3::Y, DVec3::Y * 0.1));
        // All of the box is below these planes.
        let all = |at: f64| Solid::half_space(DVec3::Z, DVec3::Z * at);
        let both = || a.clone() & b.clone();
        let copies = (both() | (both() & all(8.0))) & (a.clone() | (both() & all(9.0))) & (both() & all(7.0));
        let low = lower(&copies).unwrap();
        let cell = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let Pruned::Smaller(tape) = low.tape.prune(&low.leaves, &cell, &mut Scratch::default()) else { panic!() };
        assert_eq!((tape.leaf_count(), tape.ops.len()), (2, 3), "{tape:?}");
        for p in [DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, -0.5, 0.0), DVec3::new(-0.5, 0.5, 0.0)] {
            assert_eq!(tape.value(&low.leaves, p) > 0.0, low.tape.value(&low.leaves, p) > 0.0);
        }
    }

    #[test]
    fn what_both_sides_of_a_divider_agree_on_is_decided() {
        let below = |axis: DVec3, at: f64| Solid::half_space(axis, axis * at);
        let (d, e) = (below(DVec3::X, 0.0), below(DVec3::Y, 0.1));
        // Planes far above the box, so that all of it is inside, and far below.
        let (all, more) = (below(DVec3::Z, 8.0), below(DVec3::Z, 9.0));
        let (none, less) = (below(DVec3::Z, -8.0), below(DVec3::Z, -9.0));
        let cases = |at: &Solid, yes: &Solid, no: &Solid| (at.clone() & yes.clone()) | (!at.clone() & no.clone());
        let cell = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let pruned = |solid: &Solid| {
            let low = lower(solid).unwrap();
            low.tape.prune(&low.leaves, &cell, &mut Scratch::default())
        };
        for at in [&d, &!d.clone(), &(d.clone() & e.clone()), &(d.clone() | !e.clone())] {
            assert!(matches!(pruned(&cases(at, &all, &more)), Pruned::Inside), "{at:?}");
            assert!(matches!(pruned(&cases(at, &none, &less)), Pruned::Outside), "{at:?}");
            let within = cases(&e, &cases(at, &all, &more), &all);
            assert!(matches!(pruned(&within), Pruned::Inside), "{at:?}");
            // Where they differ the divider is the surface.
            let Pruned::Smaller(tape) = pruned(&cases(at, &all, &none)) else { panic!("{at:?}") };
            assert!(tape.ops.iter().any(|op| matches!(op, Op::Leaf { .. })), "{at:?}");
        }
    }
}
