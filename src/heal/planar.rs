//! Triangulation of one triangle with points and segments in it, by exact signs.

use std::cmp::Ordering;
use std::collections::VecDeque;

use super::arrange::axis_of;
use super::exact::ExactPoints;
use crate::error::{Error, Result};
use crate::mesh::edit::{next, prev};
use crate::mesh::{EditMesh, TriMesh};

/// Whether `c`, which lies on the line `a b`, lies strictly between them.
pub(super) fn between(points: &ExactPoints, a: u32, b: u32, c: u32, axis: usize) -> bool {
    c != a
        && c != b
        && along(points, [a, b], [a, c], axis) == Ordering::Less
        && along(points, [a, b], [c, b], axis) == Ordering::Less
}

/// Which of two points of the line `a b` comes first on the way from `a` to `b`.
fn along(points: &ExactPoints, [a, b]: [u32; 2], [p, q]: [u32; 2], axis: usize) -> Ordering {
    // in the direction in which the line is longer its points are ordered by that coordinate
    for i in [(axis + 1) % 3, (axis + 2) % 3] {
        let way = points.compare(a, b, i);
        if way != Ordering::Equal {
            let o = points.compare(p, q, i);
            return if way == Ordering::Less { o } else { o.reverse() };
        }
    }
    Ordering::Equal
}

/// Sorts points of the line `a b` from `a` to `b`.
pub(super) fn sort_along(points: &ExactPoints, a: u32, b: u32, axis: usize, on: &mut [u32]) {
    on.sort_by(|p, q| along(points, [a, b], [*p, *q], axis));
}

fn fault(why: &str) -> Error {
    Error::Failed(format!("the triangulation of a cut triangle did not come out: {why}"))
}

/// Triangles that make up `tri`, with all points as nodes and all segments (between points of the triangle) as chains of
/// edges. Where the segments leave a choice, Delaunay's rule in the plane seen along the axis decides, and the smallest
/// number where that does not, so that the same region is triangulated alike whichever triangle it is part of.
pub(super) fn triangulate(
    points: &mut ExactPoints,
    tri: [u32; 3],
    more: &[u32],
    segments: &[[u32; 2]],
) -> Result<Vec<[u32; 3]>> {
    let axis = axis_of(tri.map(|v| points.near[v as usize]));
    let turned = points.orient(tri[0], tri[1], tri[2], axis) == Ordering::Less;
    let corner = if turned { [tri[0], tri[2], tri[1]] } else { tri };
    let mut segments: Vec<[u32; 2]> = segments.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
    segments.sort_unstable();
    segments.dedup();
    let mut all: Vec<u32> = more.to_vec();
    // crossings of segments
    for i in 0..segments.len() {
        for j in i + 1..segments.len() {
            let ([p, q], [c, d]) = (segments[i], segments[j]);
            if p == c || p == d || q == c || q == d || apart(points, segments[i], segments[j]) {
                continue;
            }
            let (s1, s2) = (points.orient(c, d, p, axis), points.orient(c, d, q, axis));
            if s1 == Ordering::Equal || s2 != s1.reverse() {
                continue;
            }
            let (s3, s4) = (points.orient(p, q, c, axis), points.orient(p, q, d, axis));
            if s3 != Ordering::Equal && s4 == s3.reverse() {
                all.push(points.line_line([p, q], [c, d], axis));
            }
        }
    }
    all.sort_unstable();
    all.dedup();
    all.retain(|v| !corner.contains(v));
    let names: Vec<u32> = corner.iter().chain(&all).copied().collect();
    let place = |v: u32| points.near[v as usize];
    let mut edit = EditMesh::new(&TriMesh::new(corner.map(place).to_vec(), vec![[0, 1, 2]]))?;
    for &v in &all {
        insert(points, &mut edit, &names, v, axis)?;
    }
    // segments, cut at the points on them
    let local: rustc_hash::FxHashMap<u32, u32> = names.iter().enumerate().map(|(i, v)| (*v, i as u32)).collect();
    for [a, b] in segments {
        let mut on: Vec<u32> = names
            .iter()
            .copied()
            .filter(|v| {
                *v != a
                    && *v != b
                    && inside_box(points, a, b, *v)
                    && points.orient(a, b, *v, axis) == Ordering::Equal
                    && between(points, a, b, *v, axis)
            })
            .collect();
        sort_along(points, a, b, axis, &mut on);
        let chain: Vec<u32> = std::iter::once(a).chain(on).chain([b]).collect();
        for w in chain.windows(2) {
            let (Some(u), Some(v)) = (local.get(&w[0]), local.get(&w[1])) else {
                return Err(fault("segment end unknown"));
            };
            recover(points, &mut edit, &names, [*u, *v], axis)?;
        }
    }
    delaunay(points, &mut edit, &names, axis);
    let out = edit.triangles().map(|t| edit.corners(t).map(|v| names[v as usize]));
    Ok(out.map(|[a, b, c]| if turned { [a, c, b] } else { [a, b, c] }).collect())
}

fn apart(points: &ExactPoints, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
    let p = |v: u32| points.near[v as usize];
    let (lo, hi) = (p(a).min(p(b)), p(a).max(p(b)));
    let slack = 4.0 * f64::EPSILON * hi.abs().max(lo.abs()).max_element();
    !((lo - slack).cmple(p(c).max(p(d))).all() && p(c).min(p(d)).cmple(hi + slack).all())
}

fn inside_box(points: &ExactPoints, a: u32, b: u32, v: u32) -> bool {
    !apart(points, [a, b], [v, v])
}

/// Puts a point where it belongs: into a triangle or onto an edge.
fn insert(points: &ExactPoints, edit: &mut EditMesh, names: &[u32], v: u32, axis: usize) -> Result<()> {
    for t in 0..edit.triangle_capacity() as u32 {
        let c = edit.corners(t).map(|i| names[i as usize]);
        let s: [Ordering; 3] = std::array::from_fn(|k| points.orient(c[k], c[(k + 1) % 3], v, axis));
        if s.contains(&Ordering::Less) {
            continue;
        }
        let zero: Vec<usize> = (0..3).filter(|k| s[*k] == Ordering::Equal).collect();
        match zero[..] {
            [] => edit.split_triangle(t, points.near[v as usize]),
            [k] => edit.split_edge(3 * t + k as u32, points.near[v as usize]),
            _ => return Err(fault("point on a corner")),
        };
        return Ok(());
    }
    Err(fault("point outside"))
}

/// Makes `u v` an edge by flipping those that cross it, and marks it: S. W. Sloan, "A fast algorithm for generating
/// constrained Delaunay triangulations" (1993).
fn recover(points: &ExactPoints, edit: &mut EditMesh, names: &[u32], [u, v]: [u32; 2], axis: usize) -> Result<()> {
    let o = |a: u32, b: u32, c: u32| points.orient(names[a as usize], names[b as usize], names[c as usize], axis);
    let opposed = |s: Ordering, t: Ordering| s != Ordering::Equal && t == s.reverse();
    let crossing = |a: u32, b: u32| {
        a != u && a != v && b != u && b != v && opposed(o(u, v, a), o(u, v, b)) && opposed(o(a, b, u), o(a, b, v))
    };
    if edit.edge_between(u, v).is_none() {
        let ends = |edit: &EditMesh, h: u32| [edit.origin(h), edit.target(h)];
        let mut queue: VecDeque<[u32; 2]> =
            edit.edges().map(|h| ends(edit, h)).filter(|[a, b]| crossing(*a, *b)).collect();
        let mut idle = 0;
        while let Some([a, b]) = queue.pop_front() {
            let Some(h) = edit.edge_between(a, b) else { continue };
            if edit.opposite(h) == u32::MAX {
                return Err(fault("a segment leaves the triangle"));
            }
            let [a, b] = ends(edit, h);
            let (c, d) = (edit.apex(h), edit.apex(edit.opposite(h)));
            let convex = o(a, d, c) == Ordering::Greater && o(d, b, c) == Ordering::Greater;
            if convex && edit.flip(h) {
                idle = 0;
                if crossing(c, d) {
                    queue.push_back([c, d]);
                }
            } else {
                queue.push_back([a, b]);
                idle += 1;
                if idle > queue.len() {
                    return Err(fault("crossing edges cannot be flipped"));
                }
            }
        }
    }
    let Some(h) = edit.edge_between(u, v) else { return Err(fault("a segment is missing")) };
    edit.set_sharp(h, true);
    Ok(())
}

/// Flips unmarked edges until Delaunay's rule holds.
fn delaunay(points: &ExactPoints, edit: &mut EditMesh, names: &[u32], axis: usize) {
    let mut stack: Vec<u32> = edit.edges().collect();
    let mut steps = 64 * (edit.triangle_capacity() + 4) * (edit.triangle_capacity() + 4);
    while let Some(h) = stack.pop() {
        if steps == 0 {
            return;
        }
        steps -= 1;
        if edit.opposite(h) == u32::MAX || edit.is_sharp(h) {
            continue;
        }
        let g = edit.opposite(h);
        let n = |v: u32| names[v as usize];
        let (a, b, c, d) = (n(edit.origin(h)), n(edit.target(h)), n(edit.apex(h)), n(edit.apex(g)));
        if points.orient(a, d, c, axis) != Ordering::Greater || points.orient(d, b, c, axis) != Ordering::Greater {
            continue;
        }
        let better = match points.in_circle([a, b, c, d], axis) {
            Ordering::Greater => true,
            Ordering::Less => false,
            Ordering::Equal => c.min(d) < a.min(b),
        };
        if better && edit.flip(h) {
            // the two triangles keep their ids: all their sides are looked at again
            for t in [h / 3, g / 3] {
                stack.extend([3 * t, next(3 * t), prev(3 * t)]);
            }
        }
    }
}
