//! Differences of leaves made of one formula, such as the two sides of a wall: `c - f` and `c + f`, or `f - a` and `f - b`.
//!
//! Bounds of each leaf's gradient do not tell that what varies in one varies in the other. Their sum or difference, written as one formula,
//! does: what they have in common cancels.

use std::sync::{Arc, PoisonError, RwLock};

use rustc_hash::FxHashMap;

use super::super::formula::Formula;
use super::super::leaf::Leaf;
use crate::spatial::Aabb;

/// The sum and the difference of two leaves, if they have enough in common.
type Both = Option<Arc<[Formula; 2]>>;

/// Sums and differences of leaves, as they are asked for.
#[derive(Default)]
pub(super) struct Differences {
    known: RwLock<FxHashMap<[u32; 2], Both>>,
}

impl Differences {
    /// With which sign two formulas with something in common add up to what is shown not to vanish in a box: so they do not meet there.
    pub(super) fn apart(&self, leaves: &[Leaf], pair: [u32; 2], cell: &Aabb) -> Option<f64> {
        let [Leaf::Formula(a), Leaf::Formula(b)] = pair.map(|l| &leaves[l as usize]) else { return None };
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner).get(&pair).cloned();
        let both = known.unwrap_or_else(|| {
            let made = a.sum_and_difference(b).map(Arc::new);
            self.known.write().unwrap_or_else(PoisonError::into_inner).insert(pair, made.clone());
            made
        });
        let bounds = cell.intervals();
        let both = both?;
        let vanishes = |f: &Formula| f.slopes(&bounds).value.contains(0.0);
        both.iter().zip([1.0, -1.0]).find(|(f, _)| !vanishes(f)).map(|(_, sign)| sign)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::Placement;
    use crate::implicit::expr::{Expr, Unary};

    #[test]
    fn sides_of_a_wall_are_apart_however_wide_the_box_is() {
        let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
        let middle = Expr::unary(Unary::Sin, x.clone() * 3.0) * z.clone() + y.clone() * x.clone();
        let of = |e: Expr| Leaf::Formula(Formula::compile(&e, &Placement::IDENTITY));
        let leaves = [
            of(Expr::constant(0.1) - middle.clone()),
            of(middle.clone() + 0.1),
            of(middle.clone() - 0.2),
            // It meets each of them.
            of(middle.clone() * x.clone() + y.clone()),
            // It has nothing in common with them.
            of(x.clone() * x + y * 5.0 - z),
        ];
        let cell = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let differences = Differences::default();
        for i in 0..5u32 {
            for j in i + 1..5 {
                let sign = if i == 0 { 1.0 } else { -1.0 };
                assert_eq!(differences.apart(&leaves, [i, j], &cell), (j < 3).then_some(sign), "{i} {j}");
            }
        }
    }
}
