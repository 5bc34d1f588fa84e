//! Edges of a face's first triangles turned to make them Delaunay's in space: where lengths per parameter differ much over a
//! face, those of its domain join nodes far from each other.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use crate::numeric::predicates::orient2d;

/// Angles across an edge that make more than two right ones by less than this are not worth a flip.
const SLACK: f64 = 1e-3;
/// Flips per triangle, at most: in space they need not come to an end by themselves.
const MOST: usize = 16;

/// A vertex of the domain: its parameters, its node, and where that is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) uv: DVec2,
    pub(super) node: u32,
    pub(super) at: DVec3,
}

/// Flips edges of triangles of vertices, counter-clockwise in the domain, but for those that are `fixed`; no two edges come to
/// join the same nodes.
pub(super) fn flip(triangles: &mut [[usize; 3]], of: &[Corner], fixed: &dyn Fn(usize, usize) -> bool) {
    let sides = |t: [usize; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut owner: FxHashMap<[usize; 2], usize> = FxHashMap::default();
    let mut joined: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let nodes = |[a, b]: [usize; 2]| {
        let (a, b) = (of[a].node, of[b].node);
        [a.min(b), a.max(b)]
    };
    for (i, t) in triangles.iter().enumerate() {
        for e in sides(*t) {
            owner.insert(e, i);
        }
    }
    // Edges are there once in each direction, but for those of borders.
    for e in triangles.iter().copied().flat_map(sides) {
        if e[0] < e[1] || !owner.contains_key(&[e[1], e[0]]) {
            *joined.entry(nodes(e)).or_default() += 1;
        }
    }
    let mut due: Vec<[usize; 2]> = triangles.iter().copied().flat_map(sides).filter(|e| e[0] < e[1]).collect();
    let angle = |c: usize, [a, b]: [usize; 2]| {
        let (u, v) = (of[a].at - of[c].at, of[b].at - of[c].at);
        u.cross(v).length().atan2(u.dot(v))
    };
    let left = |a: usize, b: usize, c: usize| orient2d(of[a].uv, of[b].uv, of[c].uv) > 0.0;
    let mut rest = MOST * triangles.len();
    while let Some([a, b]) = due.pop() {
        let (Some(&s), Some(&t)) = (owner.get(&[a, b]), owner.get(&[b, a])) else { continue };
        let apex = |t: [usize; 3]| t.into_iter().find(|v| *v != a && *v != b);
        let (Some(c), Some(d)) = (apex(triangles[s]), apex(triangles[t])) else { continue };
        if fixed(a, b) || angle(c, [a, b]) + angle(d, [a, b]) <= std::f64::consts::PI + SLACK {
            continue;
        }
        let (convex, new) = (left(a, d, c) && left(d, b, c), nodes([c, d]));
        if !convex || new[0] == new[1] || joined.get(&new).is_some_and(|n| *n > 0) {
            continue;
        }
        if rest == 0 {
            break;
        }
        rest -= 1;
        (triangles[s], triangles[t]) = ([a, d, c], [d, b, c]);
        owner.remove(&[a, b]);
        owner.remove(&[b, a]);
        for i in [s, t] {
            for e in sides(triangles[i]) {
                owner.insert(e, i);
            }
        }
        *joined.entry(nodes([a, b])).or_default() -= 1;
        *joined.entry(new).or_default() += 1;
        due.extend([[a, d], [d, b], [b, c], [c, a]].map(|[x, y]| [x.min(y), x.max(y)]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn long_domains_of_narrow_tubes_are_joined_across() {
        // A strip a thousandth as wide in space as in the domain: two columns of nodes, and one far above between them.
        let column = |u: f64| (0..20).map(move |k| DVec2::new(u, 0.01 * f64::from(k)));
        let uv: Vec<DVec2> = column(0.0).chain(column(1.0)).chain([DVec2::new(0.5, 1.0)]).collect();
        let corner =
            |(i, uv): (usize, &DVec2)| Corner { uv: *uv, node: i as u32, at: DVec3::new(1e-3 * uv.x, uv.y, 0.0) };
        let of: Vec<Corner> = uv.iter().enumerate().map(corner).collect();
        // Both columns are joined to the far node, as in the domain they are nearer to it than to each other.
        let top = 40;
        let mut triangles: Vec<[usize; 3]> = (0..19).flat_map(|k| [[k + 1, k, top], [20 + k, 21 + k, top]]).collect();
        triangles.push([0, 20, top]);
        let area = |t: &[usize; 3]| (uv[t[1]] - uv[t[0]]).perp_dot(uv[t[2]] - uv[t[0]]);
        let before: f64 = triangles.iter().map(area).sum();
        flip(&mut triangles, &of, &|_, _| false);
        assert!(triangles.iter().all(|t| area(t) > 0.0));
        assert_abs_diff_eq!(triangles.iter().map(area).sum::<f64>(), before, epsilon = 1e-12);
        assert_eq!(triangles.iter().filter(|t| t.contains(&top)).count(), 1);
    }
}
