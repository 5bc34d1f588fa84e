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

#[cfg(test)]
mod tests {
    use super::*;

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
