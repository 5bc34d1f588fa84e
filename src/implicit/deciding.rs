//! Which leaves of a tree can decide its sign, where the sides of some are known.

use super::tape::{Op, Tape};

/// What is known of an operation's sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    Known(bool),
    Open,
    /// Open, and the root's sign may hang on it.
    Decides,
}

/// Which operations of a tape can decide the sign of its root; kept between questions.
#[derive(Debug, Default)]
pub(crate) struct Deciding {
    signs: Vec<Sign>,
}

impl Deciding {
    /// Asks it of a tape; `positive` tells whether an occurrence of a leaf, negated or not, is positive, where that is known. The
    /// others count as ones that may have either side.
    pub(crate) fn ask(&mut self, tape: &Tape, positive: impl Fn(u32, bool) -> Option<bool>) {
        let signs = &mut self.signs;
        signs.clear();
        for op in &tape.ops {
            let either = |a: u32, b: u32, wins: bool| match (signs[a as usize], signs[b as usize]) {
                (Sign::Known(x), _) | (_, Sign::Known(x)) if x == wins => Sign::Known(wins),
                (Sign::Known(_), Sign::Known(_)) => Sign::Known(!wins),
                _ => Sign::Open,
            };
            let sign = match *op {
                Op::All(inside) => Sign::Known(inside),
                Op::Leaf { leaf, negate, .. } => positive(leaf, negate).map_or(Sign::Open, Sign::Known),
                Op::Min(a, b) => either(a, b, false),
                Op::Max(a, b) => either(a, b, true),
            };
            signs.push(sign);
        }
        let Some(root) = signs.last_mut().filter(|s| **s == Sign::Open) else { return };
        *root = Sign::Decides;
        for i in (0..signs.len()).rev().filter(|i| matches!(tape.ops[*i], Op::Min(..) | Op::Max(..))) {
            if signs[i] == Sign::Decides
                && let Op::Min(a, b) | Op::Max(a, b) = tape.ops[i]
            {
                for k in [a, b].map(|k| k as usize) {
                    if signs[k] == Sign::Open {
                        signs[k] = Sign::Decides;
                    }
                }
            }
        }
    }

    /// Whether the root's sign may hang on an operation.
    pub(crate) fn decides(&self, op: usize) -> bool {
        self.signs[op] == Sign::Decides
    }
}

/// With more leaves than this sides are not tried: there are two to that power of them, eight at a time.
const MOST_TRIED: usize = 8;

/// The leaves of a tape that change nothing whatever the sides of the others are: what divides two cases that are one here, as
/// `(a and b) or (not a and b)`. Where a leaf has several names what divides it may tell them apart, so nothing is left out.
pub(crate) fn idle(tape: &Tape, leaves: &[u32]) -> Vec<u32> {
    let count = leaves.len();
    let occurrences = || {
        tape.ops.iter().filter_map(|op| if let Op::Leaf { leaf, face, .. } = *op { Some((leaf, face)) } else { None })
    };
    // A leaf that occurs once among leaves that occur once always decides somewhere.
    if !(2..=MOST_TRIED).contains(&count) || occurrences().count() == count {
        return Vec::new();
    }
    let mut names = vec![None; count];
    for (leaf, face) in occurrences() {
        let Ok(k) = leaves.binary_search(&leaf) else { return Vec::new() };
        if *names[k].get_or_insert(face) != face {
            return Vec::new();
        }
    }
    /// The first three leaves have their eight cases in the bits of a byte, the others one a byte.
    const FIRST: [u8; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];
    let bytes = 1usize << count.saturating_sub(FIRST.len());
    let inside: Vec<u8> = (0..bytes)
        .map(|others| {
            tape.inside_cases(|leaf| match leaves.binary_search(&leaf).unwrap_or(0) {
                k if k < FIRST.len() => FIRST[k],
                k => {
                    if others >> (k - FIRST.len()) & 1 == 1 {
                        u8::MAX
                    } else {
                        0
                    }
                }
            })
        })
        .collect();
    let is_idle = |k: &usize| match FIRST.get(*k) {
        Some(positive) => inside.iter().all(|c| (c & positive) >> (1 << k) == c & !positive),
        None => (0..bytes).all(|i| inside[i] == inside[i ^ 1 << (k - FIRST.len())]),
    };
    (0..count).filter(is_idle).map(|k| leaves[k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cases of a leaf: (at and yes) or (not at and no).
    fn cases(at: u32, yes: &[Op], no: &[Op]) -> Tape {
        let mut ops = vec![Op::Leaf { leaf: at, face: 0, negate: false }];
        ops.extend(yes);
        let first = ops.len() as u32 - 1;
        ops.extend([Op::Min(0, first), Op::Leaf { leaf: at, face: 0, negate: true }]);
        let not = ops.len() as u32 - 1;
        ops.extend(no);
        let second = ops.len() as u32 - 1;
        ops.extend([Op::Min(not, second), Op::Max(first + 1, second + 1)]);
        Tape { ops }
    }

    #[test]
    fn dividers_of_cases_that_are_one_are_idle() {
        let leaf = |leaf, face| Op::Leaf { leaf, face, negate: false };
        for [at, p, q] in [[0, 1, 2], [5, 1, 3], [2, 4, 7]] {
            let idle_of = |tape: &Tape| idle(tape, &crate::implicit::newton::leaves_of(tape));
            assert_eq!(idle_of(&cases(at, &[leaf(p, 0)], &[leaf(p, 0)])), [at]);
            assert!(idle_of(&cases(at, &[leaf(p, 0)], &[leaf(q, 0)])).is_empty());
            // It tells two names apart.
            assert!(idle_of(&cases(at, &[leaf(p, 0)], &[leaf(p, 1)])).is_empty());
        }
        // Among five leaves: ((a and (b or c) and d) or e) twice.
        for at in [1, 6] {
            let many = |from: u32| {
                let [i, k] = [from + 2, from + 4];
                let l = |n| leaf(n, 0);
                [l(2), l(3), Op::Max(from, from + 1), l(4), Op::Min(i, from + 3), l(5), Op::Max(k, from + 5)]
            };
            let tape = cases(at, &many(1), &many(10));
            assert_eq!(idle(&tape, &crate::implicit::newton::leaves_of(&tape)), [at]);
        }
    }

    /// A tape of leaves 0 to 3: ((0 and 1) or 2) and not 3.
    fn tape() -> Tape {
        let leaf = |leaf, negate| Op::Leaf { leaf, face: 0, negate };
        let ops = vec![
            leaf(0, false),
            leaf(1, false),
            Op::Min(0, 1),
            leaf(2, false),
            Op::Max(2, 3),
            leaf(3, true),
            Op::Min(4, 5),
        ];
        Tape { ops }
    }

    #[test]
    fn what_decides_is_what_changes_the_sign_for_some_sides_of_the_others() {
        let tape = tape();
        let leaves = [(0, 0), (1, 1), (3, 2), (5, 3)];
        for code in 0..81u32 {
            // Each leaf: negative, positive, unknown.
            let known = |l: u32| match code / 3u32.pow(l) % 3 {
                0 => Some(false),
                1 => Some(true),
                _ => None,
            };
            let mut deciding = Deciding::default();
            deciding.ask(&tape, |l, negate| known(l).map(|s| s != negate));
            for (op, l) in leaves {
                let sides = |mask: u32| move |x: u32| known(x).unwrap_or(mask >> x & 1 == 1);
                let changes = (0..16u32).any(|m| tape.inside_by(sides(m)) != tape.inside_by(sides(m ^ 1 << l)));
                assert_eq!(deciding.decides(op), changes, "{code} {l}");
            }
        }
    }
}
