//! A simple polygon as a Boolean formula of its edges' half-planes, each used exactly once.
//!
//! Dobkin, Guibas, Hershberger, Snoeyink (1993): a chain of edges is split at a vertex of its convex hull; the two halves
//! are joined by "and" where the polygon is convex at that vertex, by "or" where it is reflex. The formula holds for the
//! chain's edges extended to lines, so nothing but the edges themselves is needed.

use crate::error::{Error, Place, Result};

/// Corners of a polygon: all pairs of edges are looked at, and the formula may be as deep as there are corners.
pub(crate) const MOST_CORNERS: usize = 4_000;

/// A formula over the polygon's edges; edge `i` goes from corner `i` to corner `i + 1`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum EdgeTree {
    Edge(usize),
    And(Box<EdgeTree>, Box<EdgeTree>),
    Or(Box<EdgeTree>, Box<EdgeTree>),
}

fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let p = |v: [f64; 2]| robust::Coord { x: v[0], y: v[1] };
    robust::orient2d(p(a), p(b), p(c))
}

/// The corners counter-clockwise, with repeated points dropped, and the formula of the inside.
///
/// Errors: fewer than three distinct corners or more than [`MOST_CORNERS`], a corner that is not finite, edges that touch or cross.
pub(crate) fn polygon_tree(corners: &[[f64; 2]]) -> Result<(Vec<[f64; 2]>, EdgeTree)> {
    let bad = |text: String| Err(Error::input(Place::Unknown, text));
    if corners.len() > MOST_CORNERS {
        return bad(format!("the polygon has {} corners: the limit is {MOST_CORNERS}", corners.len()));
    }
    let mut p: Vec<[f64; 2]> = corners.to_vec();
    if let Some(i) = p.iter().position(|c| !c[0].is_finite() || !c[1].is_finite()) {
        return bad(format!("corner {i} of the polygon is not finite"));
    }
    p.dedup();
    while p.len() > 1 && p.first() == p.last() {
        p.pop();
    }
    if p.len() < 3 {
        return bad(format!("a polygon needs at least 3 different corners, this one has {}", p.len()));
    }
    let n = p.len();
    for i in 0..n {
        for j in i + 1..n {
            if touch(&p, i, j) {
                return bad(format!("edges {i} and {j} of the polygon touch or cross"));
            }
        }
    }
    let area: f64 = (0..n).map(|i| p[i][0] * p[(i + 1) % n][1] - p[(i + 1) % n][0] * p[i][1]).sum();
    if area == 0.0 {
        return bad("the polygon has no area".into());
    }
    if area < 0.0 {
        p.reverse();
    }
    let key = |i: &usize| p[*i];
    let order = |a: &usize, b: &usize| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal);
    let first = (0..n).min_by(order).unwrap_or(0);
    let last = (0..n).max_by(order).unwrap_or(0);
    // both extremes are corners of the hull, where the polygon is convex
    let tree = EdgeTree::And(Box::new(chain(&p, first, last)), Box::new(chain(&p, last, first)));
    Ok((p, tree))
}

/// Formula of the chain from corner `from` to corner `to`.
fn chain(p: &[[f64; 2]], from: usize, to: usize) -> EdgeTree {
    let n = p.len();
    let inner = |k: usize| (from + k) % n;
    let count = (to + n - from) % n;
    if count == 1 {
        return EdgeTree::Edge(from);
    }
    let (a, b) = (p[from], p[to]);
    let distance =
        |k: &usize| ((b[0] - a[0]) * (p[inner(*k)][1] - a[1]) - (b[1] - a[1]) * (p[inner(*k)][0] - a[0])).abs();
    let split = (1..count).max_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(1);
    let mid = inner(split);
    let convex = cross(p[(mid + n - 1) % n], p[mid], p[(mid + 1) % n]) >= 0.0;
    let (l, r) = (Box::new(chain(p, from, mid)), Box::new(chain(p, mid, to)));
    if convex { EdgeTree::And(l, r) } else { EdgeTree::Or(l, r) }
}

/// Whether edges `i < j` share a point they should not.
fn touch(p: &[[f64; 2]], i: usize, j: usize) -> bool {
    let n = p.len();
    let (a, b, c, d) = (p[i], p[(i + 1) % n], p[j], p[(j + 1) % n]);
    if (0..2).any(|k| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k])) {
        return false;
    }
    let within =
        |a: [f64; 2], b: [f64; 2], q: [f64; 2]| (0..2).all(|k| q[k] >= a[k].min(b[k]) && q[k] <= a[k].max(b[k]));
    let neighbors = j == i + 1 || (i == 0 && j == n - 1);
    if neighbors {
        // they share one corner; they must not fold back on each other
        let (shared, e, f) = if j == i + 1 { (b, a, d) } else { (a, b, c) };
        return cross(e, shared, f) == 0.0 && (within(shared, e, f) || within(shared, f, e));
    }
    segments_meet([a, b], [c, d])
}

/// Whether two segments share a point.
pub(crate) fn segments_meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    if (0..2).any(|k| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k])) {
        return false;
    }
    let within =
        |a: [f64; 2], b: [f64; 2], q: [f64; 2]| (0..2).all(|k| q[k] >= a[k].min(b[k]) && q[k] <= a[k].max(b[k]));
    let (s1, s2) = (cross(a, b, c), cross(a, b, d));
    let (s3, s4) = (cross(c, d, a), cross(c, d, b));
    if s1 * s2 < 0.0 && s3 * s4 < 0.0 {
        return true;
    }
    (s1 == 0.0 && within(a, b, c))
        || (s2 == 0.0 && within(a, b, d))
        || (s3 == 0.0 && within(c, d, a))
        || (s4 == 0.0 && within(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn holds(tree: &EdgeTree, p: &[[f64; 2]], q: [f64; 2]) -> bool {
        match tree {
            EdgeTree::Edge(i) => cross(p[*i], p[(i + 1) % p.len()], q) >= 0.0,
            EdgeTree::And(a, b) => holds(a, p, q) && holds(b, p, q),
            EdgeTree::Or(a, b) => holds(a, p, q) || holds(b, p, q),
        }
    }

    fn even_odd(p: &[[f64; 2]], q: [f64; 2]) -> bool {
        let n = p.len();
        (0..n).fold(false, |inside, i| {
            let (a, b) = (p[i], p[(i + 1) % n]);
            let crosses = (a[1] > q[1]) != (b[1] > q[1]) && q[0] < (b[0] - a[0]) * (q[1] - a[1]) / (b[1] - a[1]) + a[0];
            inside != crosses
        })
    }

    proptest! {
        /// Star-shaped polygons, and spirals made of them, against the even-odd rule.
        #[test]
        fn formula_agrees_with_even_odd(
            radii in prop::collection::vec(0.1f64..1.0, 3..24),
            queries in prop::collection::vec((-1.1f64..1.1, -1.1f64..1.1), 60),
            clockwise: bool,
        ) {
            let n = radii.len() as f64;
            let mut corners: Vec<[f64; 2]> = radii.iter().enumerate()
                .map(|(i, r)| { let t = (i as f64 + 0.3) / n * std::f64::consts::TAU; [r * t.cos(), r * t.sin()] }).collect();
            if clockwise { corners.reverse(); }
            if let Ok((p, tree)) = polygon_tree(&corners) {
                for (x, y) in queries {
                    prop_assert_eq!(holds(&tree, &p, [x, y]), even_odd(&p, [x, y]), "at {} {}", x, y);
                }
            }
        }
    }

    #[test]
    fn spiral_agrees_with_even_odd() {
        let mut outer = Vec::new();
        let mut inner = Vec::new();
        for i in 0..40 {
            let t = i as f64 * 0.4;
            outer.push([(1.0 + t) * t.cos(), (1.0 + t) * t.sin()]);
            inner.push([(0.4 + t) * t.cos(), (0.4 + t) * t.sin()]);
        }
        inner.reverse();
        outer.extend(inner);
        let (p, tree) = polygon_tree(&outer).unwrap();
        for i in 0..4000 {
            let q = [((i * 37) % 401) as f64 * 0.1 - 20.0 + 0.013, ((i * 91) % 397) as f64 * 0.1 - 20.0 + 0.017];
            assert_eq!(holds(&tree, &p, q), even_odd(&p, q), "{q:?}");
        }
    }

    #[test]
    fn bad_polygons_are_refused() {
        assert!(polygon_tree(&[[0.0, 0.0], [1.0, 0.0]]).is_err());
        assert!(polygon_tree(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]).is_err());
        assert!(polygon_tree(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]).is_err());
        assert!(polygon_tree(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 0.0]]).is_err());
        assert!(polygon_tree(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).is_err());
    }
}
