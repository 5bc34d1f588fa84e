//! Which leaves of two solids come near each other where a blend rounds off their edge.
//!
//! A fillet between two leaves is positive where one of them is, and nothing new where one of them is more than a radius below zero.
//! So a pair of leaves matters only in boxes in which both have values between these, and in which both can decide what is in their
//! solid: a blend of a plate with thirty pins and a rib is one of the rib with the pins beside it. Where other values of the fillet count
//! than zero, those of its leaves lie in another interval.

use rustc_hash::FxHashSet;

use super::super::deciding::Deciding;
use super::super::leaf::Leaf;
use super::super::tape::{Op, Tape};
use crate::numeric::Interval;
use crate::spatial::Aabb;

/// The box is halved so often at most: to a 64th of its length.
const LEVELS: u32 = 6;
/// Boxes smaller than this many lengths of the interval are not halved: leaves so near to each other have a fillet between them or might.
const SMALL: f64 = 1.0;
/// Boxes looked at, at most; in what is left all pairs count. It bounds the time where both solids run side by side for long.
const MOST_BOXES: usize = 6_000;

/// Pairs of leaves by the places of their operations in the two tapes.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    with: Vec<FxHashSet<u32>>,
}

impl Pairs {
    /// Those that a fillet may be between where both have values in an interval, in a box.
    pub(super) fn new(leaves: &[Leaf], tapes: &[Tape; 2], near: Interval, bounds: &Aabb) -> Self {
        let mut look = Look {
            leaves,
            tapes,
            near,
            boxes: 0,
            found: Self { with: vec![FxHashSet::default(); tapes[0].ops.len()] },
        };
        let of = |t: &Tape| {
            t.ops.iter().enumerate().filter(|o| matches!(o.1, Op::Leaf { .. })).map(|o| o.0 as u32).collect()
        };
        let all: [Vec<u32>; 2] = [of(&tapes[0]), of(&tapes[1])];
        if bounds.size().is_finite() {
            look.within(bounds, &vec![None; leaves.len()], LEVELS);
        } else {
            look.found.insert(&all);
        }
        look.found
    }

    /// The places of leaves in the second tape with which one of the first has fillets.
    pub(super) fn of(&self, first: usize) -> &FxHashSet<u32> {
        &self.with[first]
    }

    pub(super) fn count(&self) -> usize {
        self.with.iter().map(FxHashSet::len).sum()
    }

    fn insert(&mut self, [a, b]: &[Vec<u32>; 2]) {
        a.iter().for_each(|i| self.with[*i as usize].extend(b));
    }

    fn has_all(&self, [a, b]: &[Vec<u32>; 2]) -> bool {
        a.iter().all(|i| b.iter().all(|k| self.with[*i as usize].contains(k)))
    }
}

/// A search for pairs.
struct Look<'a> {
    leaves: &'a [Leaf],
    tapes: &'a [Tape; 2],
    near: Interval,
    boxes: usize,
    found: Pairs,
}

impl Look<'_> {
    /// Finds those in a box; `known` are ranges of leaves that told enough in a larger one.
    fn within(&mut self, cell: &Aabb, known: &[Option<Interval>], levels: u32) {
        self.boxes += 1;
        let mut ranges = known.to_vec();
        let most = self.near.abs().hi;
        let tells = |r: &Interval| r.lo > most || r.hi < -most;
        for op in self.tapes.iter().flat_map(|t| &t.ops) {
            if let Op::Leaf { leaf, .. } = op
                && !ranges[*leaf as usize].as_ref().is_some_and(tells)
            {
                ranges[*leaf as usize] = None;
            }
        }
        for op in self.tapes.iter().flat_map(|t| &t.ops) {
            if let Op::Leaf { leaf, .. } = op {
                ranges[*leaf as usize].get_or_insert_with(|| self.leaves[*leaf as usize].range(cell));
            }
        }
        let mut deciding = Deciding::default();
        let near = self.tapes.each_ref().map(|tape| {
            deciding.ask(tape, |leaf, negate| {
                let r = ranges[leaf as usize]?;
                let (lo, hi) = if negate { (-r.hi, -r.lo) } else { (r.lo, r.hi) };
                if lo > self.near.hi {
                    Some(true)
                } else if hi < self.near.lo {
                    Some(false)
                } else {
                    None
                }
            });
            let is_leaf = |i: &usize| matches!(tape.ops[*i], Op::Leaf { .. }) && deciding.decides(*i);
            (0..tape.ops.len()).filter(is_leaf).map(|i| i as u32).collect::<Vec<u32>>()
        });
        if near.iter().any(Vec::is_empty) || self.found.has_all(&near) {
            return;
        }
        if levels == 0 || cell.size().max_element() < SMALL * (self.near.hi - self.near.lo) || self.boxes > MOST_BOXES {
            self.found.insert(&near);
            return;
        }
        cell.octants().into_iter().for_each(|sub| self.within(&sub, &ranges, levels - 1));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::lower;
    use crate::implicit::Solid;

    /// Numbers in a row, from 0 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn point(&mut self, reach: f64) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next()) * (2.0 * reach) - reach
        }
    }

    fn some(numbers: &mut Numbers, count: usize) -> Solid {
        let mut ball = || Solid::sphere(0.3 + 0.5 * numbers.next(), numbers.point(1.5));
        let mut all = ball();
        for k in 1..count {
            all = match k % 4 {
                0 => all - ball(),
                1 => all & (ball() | Solid::cuboid(DVec3::splat(-1.2), DVec3::splat(1.2))),
                _ => all | ball(),
            };
        }
        all
    }

    #[test]
    fn a_blend_has_the_sign_of_its_formula_whatever_pairs_are_left_out() {
        let mut numbers = Numbers(7);
        let (mut fewer, mut rounded) = (0, 0);
        for round in 0..40 {
            let r = [0.05, 0.2, 0.5][round % 3];
            let [a, b] = [6, 5].map(|count| some(&mut numbers, count));
            let [f, g] = [&a, &b].map(|s| lower(s).unwrap());
            let made = lower(&a.blend(b, r)).unwrap();
            let fillets = made.leaves.iter().filter(|l| matches!(l, crate::implicit::leaf::Leaf::Fillet(_))).count();
            fewer += usize::from(fillets < 60);
            for _ in 0..4000 {
                let p = numbers.point(2.5);
                let [u, v] = [&f, &g].map(|m| m.tape.value(&m.leaves, p));
                let value = (r + u).max(0.0).hypot((r + v).max(0.0)) + u.max(v).min(-r);
                rounded += usize::from(value > 1e-9 && u.max(v) < 0.0);
                if value.abs() > 1e-9 {
                    assert_eq!(made.tape.value(&made.leaves, p) > 0.0, value > 0.0, "{round}: {p} {value} {u} {v}");
                }
            }
        }
        assert!(fewer > 20 && rounded > 50, "{fewer} {rounded}");
    }
}
