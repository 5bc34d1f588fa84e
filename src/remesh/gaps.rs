//! Sizes that follow what is narrow: gaps between the borders of a face, and the thickness of the solid.

use glam::DVec3;
use rayon::prelude::*;

use super::patchwork::Patchwork;
use super::remesher::{Rank, Remesher};
use crate::error::Result;
use crate::geometry::INTO;
use crate::numeric::COS_26;
use crate::run::Run;
use crate::sizing::Sizing;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// One row of equilateral triangles across a strip has edges of this many times its width.
pub(super) const ROW: f64 = 1.15;
/// Where a strip is narrower than the least size edges are up to this many times as long as a strip is wide: angles of 34 degrees.
const EASE: f64 = 1.5;

/// What a gap asks for at a node on a border.
pub(super) struct BorderGap {
    pub(super) node: u32,
    /// The patch it is a gap of.
    pub(super) patch: u32,
    pub(super) length: f64,
}

/// A piece of a border, as one of its patches sees it.
struct Rim {
    label: u32,
    ends: [u32; 2],
    points: [DVec3; 2],
    /// Into the patch, of unit length.
    inward: DVec3,
}

impl Remesher<'_> {
    fn rims(&self) -> Vec<Rim> {
        let m = &self.work.mesh;
        let sharp = (0..3 * m.triangle_capacity() as u32).filter(|&h| m.is_triangle(h / 3) && m.is_sharp(h));
        let rim = |h: u32| {
            let (ends, label) = ([m.origin(h), m.target(h)], m.label(h / 3));
            let points = ends.map(|v| self.point(v));
            // Triangles that were just cut face anywhere.
            let normal = self.work.normal(self.surface, label, 0.5 * (points[0] + points[1]));
            let inward = normal.cross(points[1] - points[0]).try_normalize()?;
            (!self.work.stays(label)).then_some(Rim { label, ends, points, inward })
        };
        sharp.filter_map(rim).collect()
    }

    /// The edge lengths that make a row of good triangles across the gap to the border across from a node on a border, where that
    /// is less than the size and more than `narrowest`.
    pub(super) fn across_gaps(&self) -> Result<Vec<BorderGap>> {
        let Sizing { size, least, .. } = self.options.sizing;
        let rims = self.rims();
        // Only borders of the same patch lie across from each other: a tree for each.
        let mut of: Vec<Vec<u32>> = vec![Vec::new(); self.work.patches.len()];
        rims.iter().zip(0..).for_each(|(r, k)| of[r.label as usize].push(k));
        let boxes = |list: &Vec<u32>| list.iter().map(|k| Aabb::around(rims[*k as usize].points)).collect();
        let trees: Vec<Bvh> = of.iter().map(|list| Bvh::new(boxes(list))).collect();
        let range = self.options.narrowest.min(least) / EASE..size / ROW;
        self.run.check()?;
        // The width of the gap at a node, and what lies across there.
        let gap = |(rim, end): (&Rim, usize)| {
            let (v, p) = (rim.ends[end], rim.points[end]);
            // Borders lie across from each other where the way between them leaves both about straight.
            let level = if self.rank[v as usize] == Rank::Corner { INTO } else { COS_26 };
            let own = &of[rim.label as usize];
            let there = |k: u32| &rims[own[k as usize] as usize];
            let foot_on = |k: u32| segment_foot(p, there(k).points);
            let across = trees[rim.label as usize].nearest(p, range.end, |k| {
                let other = there(k);
                if other.ends.contains(&v) {
                    return f64::INFINITY;
                }
                let way = foot_on(k) - p;
                let d = way.length();
                let facing = way.dot(rim.inward) > level * d && -way.dot(other.inward) > COS_26 * d;
                if range.contains(&d) && facing { d * d } else { f64::INFINITY }
            });
            let Some((k, squared)) = across else { return Vec::new() };
            let (foot, width) = (foot_on(k), squared.sqrt());
            let (across, length) = (there(k), fitting(width, least.min(size)));
            let mut gaps = vec![BorderGap { node: v, patch: rim.label, length }];
            // A corner may come near between the nodes of what lies across from it.
            if self.rank[v as usize] == Rank::Corner {
                let beside = |i: usize| length + self.options.grading * across.points[i].distance(foot);
                gaps.extend((0..2).map(|i| BorderGap { node: across.ends[i], patch: rim.label, length: beside(i) }));
            }
            gaps
        };
        Ok(self.run.install(|| rims.par_iter().flat_map_iter(|r| [(r, 0), (r, 1)]).flat_map_iter(gap).collect()))
    }
}

/// The edge length that fits what is as wide, or as long, as this.
pub(super) fn fitting(width: f64, least: f64) -> f64 {
    (ROW * width).max((EASE * width).min(least))
}

/// For every node the largest edge length of `share` times the thickness of the solid beneath the triangles around it, as a
/// ray meets the other side; infinite where that is more than `size`, never less than `least`.
pub(super) fn through_solid(work: &Patchwork, share: f64, size: f64, least: f64, run: &Run) -> Result<Vec<f64>> {
    let m = &work.mesh;
    let triangles: Vec<u32> = m.triangles().collect();
    let tree = Bvh::new(triangles.iter().map(|&t| Aabb::around(m.corner_points(t))).collect());
    run.check()?;
    let reach = size / share;
    let thickness = |&t: &u32| {
        let [a, b, c] = m.corner_points(t);
        let (start, Some(down)) = ((a + b + c) / 3.0, (-m.area_vector(t)).try_normalize()) else {
            return f64::INFINITY;
        };
        let mut nearest = f64::INFINITY;
        tree.overlapping(&Aabb::around([start, start + reach * down]), |k| {
            let u = triangles[k as usize];
            // The way out only: what faces this way is another side of the same wall.
            if u != t && m.area_vector(u).dot(down) > 0.0 {
                nearest = hit(start, down, m.corner_points(u)).filter(|d| *d > 0.0).map_or(nearest, |d| d.min(nearest));
            }
        });
        nearest
    };
    let found: Vec<f64> = run.install(|| triangles.par_iter().map(thickness).collect());
    let mut bound = vec![f64::INFINITY; m.node_capacity()];
    for (&t, d) in triangles.iter().zip(found) {
        if d < reach {
            m.corners(t).into_iter().for_each(|v| bound[v as usize] = bound[v as usize].min((share * d).max(least)));
        }
    }
    Ok(bound)
}

/// How far along a ray, in lengths of `d`, it passes through a triangle.
fn hit(o: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let n = (b - a).cross(c - a);
    let t = (a - o).dot(n) / d.dot(n);
    let p = o + t * d;
    let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(x, y)| (y - x).cross(p - x).dot(n) >= 0.0);
    (t.is_finite() && inside).then_some(t)
}
