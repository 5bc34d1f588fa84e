//! Triangles or segments of one piece of the input, and the point of them nearest to a place.

use glam::DVec3;

use crate::spatial::{Aabb, Bvh, triangle_foot};

/// The triangles of a face.
pub(super) struct Sheet {
    corners: Vec<[DVec3; 3]>,
    /// Normals at the corners, of this face alone.
    normals: Vec<[DVec3; 3]>,
    /// How fast the normal turns over each triangle, 1 over length.
    bends: Vec<f64>,
    tree: Bvh,
    /// Unit normal and offset, where the face is a plane to the precision of its nodes.
    pub(super) plane: Option<(DVec3, f64)>,
}

impl Sheet {
    pub(super) fn new(corners: Vec<[DVec3; 3]>, normals: Vec<[DVec3; 3]>, precision: f64) -> Self {
        let bends = corners.iter().zip(&normals).map(|(c, n)| bend(c, n)).collect();
        let tree = Bvh::new(corners.iter().map(|c| Aabb::around(*c)).collect());
        let plane = plane(&corners, precision);
        Self { corners, normals, bends, tree, plane }
    }

    /// The triangle nearest to `p` and the barycentric coordinates of the nearest point.
    fn nearest(&self, p: DVec3) -> Option<(usize, [f64; 3])> {
        let distance = |t: u32| {
            let c = &self.corners[t as usize];
            let w = triangle_foot(p, *c);
            p.distance_squared(mix(c, w))
        };
        let t = self.tree.nearest(p, f64::INFINITY, distance)?.0 as usize;
        Some((t, triangle_foot(p, self.corners[t])))
    }

    pub(super) fn foot(&self, p: DVec3) -> Option<DVec3> {
        let (t, w) = self.nearest(p)?;
        Some(mix(&self.corners[t], w))
    }

    /// The nearest point on triangles that face the way of `normal`.
    pub(super) fn foot_facing(&self, p: DVec3, normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        let distance = |t: u32| {
            let c = &self.corners[t as usize];
            if (c[1] - c[0]).cross(c[2] - c[0]).dot(normal) <= 0.0 {
                return f64::INFINITY;
            }
            p.distance_squared(mix(c, triangle_foot(p, *c)))
        };
        let t = self.tree.nearest(p, reach, distance).filter(|n| n.1.is_finite())?.0 as usize;
        let w = triangle_foot(p, self.corners[t]);
        Some((mix(&self.corners[t], w), mix(&self.normals[t], w).try_normalize()))
    }

    pub(super) fn normal(&self, p: DVec3) -> Option<DVec3> {
        if let Some((n, _)) = self.plane {
            return Some(n);
        }
        let (t, w) = self.nearest(p)?;
        mix(&self.normals[t], w).try_normalize()
    }

    pub(super) fn bend(&self, p: DVec3) -> Option<f64> {
        self.nearest(p).map(|(t, _)| self.bends[t])
    }
}

fn mix(c: &[DVec3; 3], w: [f64; 3]) -> DVec3 {
    c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
}

fn bend(c: &[DVec3; 3], n: &[DVec3; 3]) -> f64 {
    (0..3)
        .map(|k| {
            let length = c[k].distance(c[(k + 1) % 3]);
            if length > 0.0 { n[k].distance(n[(k + 1) % 3]) / length } else { 0.0 }
        })
        .fold(0.0, f64::max)
}

/// The plane through all corners to the precision given.
fn plane(corners: &[[DVec3; 3]], precision: f64) -> Option<(DVec3, f64)> {
    let n = corners.iter().map(|[a, b, c]| (b - a).cross(c - a)).sum::<DVec3>().try_normalize()?;
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in corners.iter().flatten() {
        let d = n.dot(*p);
        (lo, hi) = (lo.min(d), hi.max(d));
    }
    (hi - lo <= precision).then_some((n, 0.5 * (lo + hi)))
}

/// The segments of a line.
pub(super) struct Line {
    segments: Vec<[DVec3; 2]>,
    tree: Bvh,
}

impl Line {
    pub(super) fn new(segments: Vec<[DVec3; 2]>) -> Self {
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(*s)).collect());
        Self { segments, tree }
    }

    pub(super) fn foot(&self, p: DVec3) -> Option<DVec3> {
        let at = |k: u32| {
            let [a, b] = self.segments[k as usize];
            let d = b - a;
            let t = (p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE);
            a + d * t.clamp(0.0, 1.0)
        };
        self.tree.nearest(p, f64::INFINITY, |k| p.distance_squared(at(k))).map(|n| at(n.0))
    }
}
