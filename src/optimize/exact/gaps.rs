//! Sizes that follow what is narrow: gaps between the borders of a face, and the thickness of the solid.

use glam::DVec3;
use rayon::prelude::*;

use super::patchwork::Patchwork;
use crate::error::Result;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// One row of equilateral triangles across a strip has edges of this many times its width.
pub(super) const ROW: f64 = 1.15;
/// Borders lie across from each other where the way between them leaves both within about 25 degrees of straight.
const ACROSS: f64 = 0.9;
/// Strips narrower than this share of the least size have bad triangles whatever is done, and so are left alone.
const HOPELESS: f64 = 0.25;

/// A piece of a border, as one of its patches sees it.
struct Rim {
    label: u32,
    ends: [u32; 2],
    points: [DVec3; 2],
    /// Into the patch, of unit length.
    inward: DVec3,
}

fn rims(work: &Patchwork) -> Vec<Rim> {
    let m = &work.mesh;
    let sharp = (0..3 * m.triangle_capacity() as u32).filter(|&h| m.is_triangle(h / 3) && m.is_sharp(h));
    let rim = |h: u32| {
        let (ends, label) = ([m.origin(h), m.target(h)], m.label(h / 3));
        let points = ends.map(|v| m.point(v));
        let inward = m.area_vector(h / 3).cross(points[1] - points[0]).try_normalize()?;
        (!work.stays(label)).then_some(Rim { label, ends, points, inward })
    };
    sharp.filter_map(rim).collect()
}

/// For every node on a border the largest edge length that makes a row of good triangles across the gap to the border
/// across from it; infinite where that is more than `size`, never less than `least`.
pub(super) fn across_gaps(work: &Patchwork, size: f64, least: f64, run: &Run) -> Result<Vec<f64>> {
    let rims = rims(work);
    let tree = Bvh::new(rims.iter().map(|r| Aabb::around(r.points)).collect());
    let range = HOPELESS * least..size / ROW;
    run.check()?;
    let width = |(rim, end): (&Rim, usize)| {
        let p = rim.points[end];
        let mut width = f64::INFINITY;
        tree.overlapping(&Aabb::around([p]).grown(range.end), |k| {
            let other = &rims[k as usize];
            if other.label != rim.label || other.ends.contains(&rim.ends[end]) {
                return;
            }
            let way = segment_foot(p, other.points) - p;
            let d = way.length();
            let facing = way.dot(rim.inward) > ACROSS * d && -way.dot(other.inward) > ACROSS * d;
            if range.contains(&d) && facing {
                width = width.min(d);
            }
        });
        (rim.ends[end], (ROW * width).max(least))
    };
    let found: Vec<(u32, f64)> =
        run.install(|| rims.par_iter().flat_map_iter(|r| [(r, 0), (r, 1)]).map(width).collect());
    let mut bound = vec![f64::INFINITY; work.mesh.node_capacity()];
    found.into_iter().for_each(|(v, s)| bound[v as usize] = bound[v as usize].min(s));
    Ok(bound)
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
