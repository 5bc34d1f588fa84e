//! The medial axis of a region, from the Voronoi diagram of points along its contours.
//!
//! *References.* \[BOR20\], trimming of narrow regions, steps 1, 3 and 4. Branches to corners are pruned by how far apart
//! along the contour the two points are that a place of the axis lies between, relative to their distance (the λ of
//! F. Chazal and A. Lieutier, "The λ-medial axis", 2005, measured along the contour).

use std::collections::VecDeque;

use glam::DVec2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::numeric::{FOUND_TWICE, Sets};
use crate::spatial::{Aabb, Bvh};

/// A branch is kept where the way along the contour is this many times longer than the way across: it leads to no corner of
/// more than 2 asin(1 / this) = 47 degrees.
const AROUND: f64 = 2.5;

/// More samples than this are not made.
const MOST: f64 = 2e6;

/// A point of a sampled contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContourSample {
    pub(super) at: DVec2,
    pub(super) contour: u32,
    /// The contour's point it is, if it is one.
    pub(super) point: Option<u32>,
    /// Way along the contour.
    along: f64,
}

impl HasPosition for ContourSample {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.at.x, self.at.y)
    }
}

/// The medial axis as lines: chains of places between its ends and branchings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Places, and how far the contours are from each.
    pub places: Vec<(DVec2, f64)>,
    /// Lines as places one after the other; a closed line names its first place again at the end.
    pub lines: Vec<Vec<u32>>,
}

/// Contours as rows of samples: their points, and where contours lie within `reach` of each other points between them, at most
/// `spacing` apart. `None` beyond two million.
pub(super) fn samples(contours: &[Vec<DVec2>], reach: f64, spacing: f64) -> Option<Vec<Vec<ContourSample>>> {
    let segment = |[c, i]: [usize; 2]| {
        let p = &contours[c];
        [p[i], p[(i + 1) % p.len()]]
    };
    let all: Vec<[usize; 2]> = (0..contours.len()).flat_map(|c| (0..contours[c].len()).map(move |i| [c, i])).collect();
    let around = |ends: [DVec2; 2]| Aabb::around(ends.map(|p| p.extend(0.0)));
    let bvh = Bvh::new(all.iter().map(|s| around(segment(*s))).collect());
    let mut out: Vec<Vec<ContourSample>> = vec![Vec::new(); contours.len()];
    let (mut count, mut along) = (0.0, 0.0);
    for &[c, i] in &all {
        let n = contours[c].len();
        let [a, b] = segment([c, i]);
        // Whether a part that is nearly as short as the reach, or longer, has another segment so near.
        let near = |p: DVec2, q: DVec2| {
            let mut near = false;
            bvh.overlapping(&around([p, q]).grown(reach), |j| {
                let [d, j] = all[j as usize];
                near |= [d, j] != [c, i] && !(d == c && (j == (i + 1) % n || i == (j + 1) % n));
            });
            near
        };
        let length = a.distance(b);
        if i == 0 {
            along = 0.0;
        }
        let mut parts = vec![[0.0, 1.0]];
        while let Some([s, t]) = parts.pop() {
            let (p, q) = (a.lerp(b, s), a.lerp(b, t));
            let way = (t - s) * length;
            let fine = way > spacing && near(p, q);
            if fine && way > 2.0 * reach {
                let m = 0.5 * (s + t);
                parts.extend([[m, t], [s, m]]);
                continue;
            }
            let steps = if fine { (way / spacing).ceil() } else { 1.0 };
            if !(count + steps <= MOST) {
                return None;
            }
            count += steps;
            for x in 0..steps as u32 {
                let s = s + (t - s) * f64::from(x) / steps;
                let point = (s == 0.0).then_some(i as u32);
                out[c].push(ContourSample { at: a.lerp(b, s), contour: c as u32, point, along: along + s * length });
            }
        }
        along += length;
    }
    Some(out)
}

/// The medial axis of the region the contours bound, where parts of the contours lie within `reach` of each other; along it
/// places follow each other at about `spacing`, which should be small against the widths that matter.
///
/// Contours must not [meet](fn@super::crossings). Branches that lead to corners are left out. `None` for contours that need
/// more than two million samples, or coordinates that are not finite.
pub fn medial_axis(contours: &[Vec<DVec2>], reach: f64, spacing: f64) -> Option<Axis> {
    axis_of(&samples(contours, reach, spacing)?, spacing)
}

pub(super) fn axis_of(rows: &[Vec<ContourSample>], spacing: f64) -> Option<Axis> {
    let all: Vec<ContourSample> = rows.iter().flatten().copied().collect();
    if all.iter().any(|s| !s.at.is_finite()) {
        return None;
    }
    let lengths: Vec<f64> =
        rows.iter().map(|r| r.last().zip(r.first()).map_or(0.0, |(l, f)| l.along + l.at.distance(f.at))).collect();
    // step 1: the Voronoi diagram is the dual of this
    let mut tri = ConstrainedDelaunayTriangulation::<ContourSample>::bulk_load_cdt(all.clone(), Vec::new()).ok()?;
    if tri.num_vertices() != all.len() {
        return None;
    }
    let mut first = 0;
    for row in rows {
        for i in 0..row.len() {
            let [a, b] = [first + i, first + (i + 1) % row.len()].map(FixedVertexHandle::from_index);
            if a != b {
                if !tri.can_add_constraint(a, b) {
                    return None;
                }
                tri.add_constraint(a, b);
            }
        }
        first += row.len();
    }
    // inside is what an odd number of contours lies around
    let mut inside: Vec<Option<bool>> = vec![None; tri.num_all_faces()];
    let outer = tri.outer_face().fix();
    inside[outer.index()] = Some(false);
    let mut queue = VecDeque::new();
    for e in tri.convex_hull() {
        let e = if e.face().is_outer() { e } else { e.rev() };
        queue.push_back((e.fix(), false));
    }
    while let Some((edge, from)) = queue.pop_front() {
        let edge = tri.directed_edge(edge);
        let Some(face) = edge.rev().face().as_inner() else { continue };
        let slot = &mut inside[face.fix().index()];
        if slot.is_none() {
            let here = from != edge.is_constraint_edge();
            *slot = Some(here);
            queue.extend(face.adjacent_edges().map(|e| (e.fix(), here)));
        }
    }
    let mut place_of = vec![u32::MAX; tri.num_all_faces()];
    let mut places: Vec<(DVec2, f64)> = Vec::new();
    let mut segments: Vec<[u32; 2]> = Vec::new();
    for e in tri.undirected_edges() {
        let [a, b] = [e.as_directed(), e.as_directed().rev()];
        let (Some(f), Some(g)) = (a.face().as_inner(), b.face().as_inner()) else { continue };
        if e.is_constraint_edge() || inside[f.fix().index()] != Some(true) || inside[g.fix().index()] != Some(true) {
            continue;
        }
        let [p, q] = e.vertices().map(|v| *v.data());
        let way = (p.along - q.along).abs();
        let around = if p.contour == q.contour { way.min(lengths[p.contour as usize] - way) } else { f64::INFINITY };
        if around <= AROUND * p.at.distance(q.at) {
            continue;
        }
        let ends = [f, g].map(|face| {
            let slot = &mut place_of[face.fix().index()];
            if *slot == u32::MAX {
                *slot = places.len() as u32;
                let (c, r2) = face.circumcircle();
                places.push((DVec2::new(c.x, c.y), r2.sqrt()));
            }
            *slot
        });
        segments.push(ends);
    }
    Some(lines(places, segments, FOUND_TWICE * spacing))
}

/// Steps 3 and 4: places at one point become one, segments that are there twice go, and what is left is split into lines
/// where other than two segments meet.
fn lines(places: Vec<(DVec2, f64)>, segments: Vec<[u32; 2]>, same: f64) -> Axis {
    let mut sets = Sets::new(places.len());
    // places that coincide are neighbors in the diagram
    for [a, b] in &segments {
        if places[*a as usize].0.distance(places[*b as usize].0) <= same {
            sets.join(*a, *b);
        }
    }
    let mut edges: Vec<[u32; 2]> = segments
        .iter()
        .map(|[a, b]| {
            let (a, b) = (sets.find(*a), sets.find(*b));
            [a.min(b), a.max(b)]
        })
        .filter(|[a, b]| a != b)
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut at: Vec<(u32, u32)> =
        edges.iter().enumerate().flat_map(|(k, [a, b])| [(*a, k as u32), (*b, k as u32)]).collect();
    at.sort_unstable();
    let around = |v: u32| {
        let from = at.partition_point(|x| x.0 < v);
        at[from..].iter().take_while(move |x| x.0 == v).map(|x| x.1)
    };
    let mut used = vec![false; edges.len()];
    let mut lines = Vec::new();
    let mut trace = |start: u32, edge: u32, used: &mut Vec<bool>| {
        let (mut line, mut edge) = (vec![start], edge);
        loop {
            used[edge as usize] = true;
            let here = line[line.len() - 1];
            let [a, b] = edges[edge as usize];
            let there = if here == a { b } else { a };
            line.push(there);
            if there == start || around(there).count() != 2 {
                break;
            }
            match around(there).find(|e| !used[*e as usize]) {
                Some(next) => edge = next,
                None => break,
            }
        }
        lines.push(line);
    };
    for &(v, edge) in &at {
        if !used[edge as usize] && around(v).count() != 2 {
            trace(v, edge, &mut used);
        }
    }
    // what has no end is closed
    for &(v, edge) in &at {
        if !used[edge as usize] {
            trace(v, edge, &mut used);
        }
    }
    Axis { places, lines }
}
