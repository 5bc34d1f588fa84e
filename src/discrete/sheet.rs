//! Triangles or segments of one piece of the input, and the point of them nearest to a place.

use glam::DVec3;

use crate::mesh::edit::NONE;
use crate::spatial::{Aabb, Bvh, TriangleCells, segment_foot, triangle_foot};

/// Points asked for lie up to about this share of the mesh's edge length off the surface.
const OFF: f64 = 0.2;
/// A walk is believed where it ends at most this share of a cell away.
const TRUSTED: f64 = 0.75;
/// Triangles that are looked at around a corner, each way.
const FAN: usize = 24;

/// A triangle of a face, with what is known at its corners.
#[derive(Clone)]
pub(super) struct FaceTriangle {
    pub(super) corners: [DVec3; 3],
    /// Normals of this face alone.
    pub(super) normals: [DVec3; 3],
    /// The larger magnitude of the principal curvatures.
    pub(super) bends: [f64; 3],
    /// The triangles across the edges that begin at the corners, `NONE` across those of other faces.
    pub(super) beside: [u32; 3],
}

impl FaceTriangle {
    /// Barycentric coordinates of the point nearest to `p`.
    fn foot(&self, p: DVec3) -> [f64; 3] {
        triangle_foot(p, self.corners)
    }

    fn at(&self, w: [f64; 3]) -> DVec3 {
        mix(&self.corners, w)
    }

    fn normal(&self, w: [f64; 3]) -> Option<DVec3> {
        mix(&self.normals, w).try_normalize()
    }

    /// The curvature in between. On a facet that tells how the surface bends it is the radius that grows evenly, as along a cone;
    /// else the curvature itself, which may be noise at any corner.
    fn bend(&self, w: [f64; 3], smooth: bool) -> f64 {
        let mean =
            |of: &dyn Fn(f64) -> f64| (0..3).filter(|k| w[*k] > 0.0).map(|k| w[k] * of(self.bends[k])).sum::<f64>();
        if smooth { 1.0 / mean(&|b| 1.0 / b) } else { mean(&|b| b) }
    }
}

/// The triangles of a face.
pub(super) struct FaceSheet {
    facets: Vec<FaceTriangle>,
    cells: TriangleCells,
    /// Unit normal and offset, where the face is a plane to the precision of its nodes.
    pub(super) plane: Option<(DVec3, f64)>,
    /// Whether the triangles tell how the surface bends.
    smooth: bool,
}

impl FaceSheet {
    /// `scale` is the edge length of meshes whose points are asked for.
    pub(super) fn new(facets: Vec<FaceTriangle>, precision: f64, scale: f64, smooth: bool) -> Self {
        let plane = plane(&facets, precision);
        let cells = TriangleCells::new(&facets.iter().map(|f| f.corners).collect::<Vec<_>>(), OFF * scale);
        Self { facets, cells, plane, smooth }
    }

    /// A triangle none of whose neighbors is nearer to `p`, found by walking there, and the barycentric coordinates of its
    /// nearest point; nothing where a walk may not be trusted.
    fn walk(&self, p: DVec3) -> Option<(&FaceTriangle, [f64; 3])> {
        let (start, cell) = self.cells.start(p)?;
        let at = |t: u32| {
            let f = &self.facets[t as usize];
            let w = f.foot(p);
            (p.distance_squared(f.at(w)), t, w)
        };
        let mut best = at(start);
        // However many: where triangles are slender a cell is many of them wide.
        loop {
            let (_, t, w) = best;
            let beside = self.facets[t as usize].beside;
            let next = match w.map(|x| x == 0.0) {
                [false, false, false] => None,
                [true, false, false] => (beside[1] != NONE).then(|| at(beside[1])),
                [false, true, false] => (beside[2] != NONE).then(|| at(beside[2])),
                [false, false, true] => (beside[0] != NONE).then(|| at(beside[0])),
                [_, true, true] => self.around(t, 0, at),
                [true, _, true] => self.around(t, 1, at),
                [true, true, _] => self.around(t, 2, at),
            };
            match next {
                Some(n) if n.0 < best.0 => best = n,
                _ => break,
            }
        }
        (best.0 <= (TRUSTED * cell).powi(2)).then(|| (&self.facets[best.1 as usize], best.2))
    }

    /// The nearest of the triangles around a corner.
    fn around(&self, t: u32, k: usize, at: impl Fn(u32) -> (f64, u32, [f64; 3])) -> Option<(f64, u32, [f64; 3])> {
        let p = self.facets[t as usize].corners[k];
        let mut best: Option<(f64, u32, [f64; 3])> = None;
        // One way round, and the other from the border on.
        for back in [false, true] {
            let (mut x, mut corner) = (t, k);
            for _ in 0..FAN {
                let beside = self.facets[x as usize].beside[if back { corner } else { (corner + 2) % 3 }];
                if beside == t {
                    return best;
                }
                let found = self.facets.get(beside as usize).and_then(|f| f.corners.iter().position(|c| *c == p));
                let Some(c) = found else { break };
                (x, corner) = (beside, c);
                let n = at(x);
                if best.is_none_or(|b| n.0 < b.0) {
                    best = Some(n);
                }
            }
        }
        best
    }

    /// The triangle nearest to `p` and the barycentric coordinates of the nearest point.
    fn nearest(&self, p: DVec3) -> Option<(&FaceTriangle, [f64; 3])> {
        if let Some(found) = self.walk(p) {
            return Some(found);
        }
        let distance = |t: u32| {
            let f = &self.facets[t as usize];
            p.distance_squared(f.at(f.foot(p)))
        };
        let f = &self.facets[self.cells.nearest(p, f64::INFINITY, distance)?.0 as usize];
        Some((f, f.foot(p)))
    }

    /// The area, and that divided by the square of the lengths `wanted` where it bends as it does.
    pub(super) fn crowding(&self, wanted: impl Fn(f64) -> f64) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for f in &self.facets {
            let area = 0.5 * (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).length();
            let bend = if self.plane.is_some() { 0.0 } else { f.bends.iter().sum::<f64>() / 3.0 };
            sums[0] += area;
            sums[1] += area / wanted(bend).powi(2);
        }
        sums
    }

    pub(super) fn foot(&self, p: DVec3) -> Option<DVec3> {
        self.nearest(p).map(|(f, w)| f.at(w))
    }

    /// The nearest point on triangles that face the way of `normal`, and the normal there.
    pub(super) fn foot_facing(&self, p: DVec3, normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        let faces =
            |f: &FaceTriangle| (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]).dot(normal) > 0.0;
        if let Some((f, w)) = self.walk(p)
            && faces(f)
        {
            let q = f.at(w);
            return (q.distance_squared(p) <= reach * reach).then(|| (q, f.normal(w)));
        }
        let distance = |t: u32| {
            let f = &self.facets[t as usize];
            if !faces(f) {
                return f64::INFINITY;
            }
            p.distance_squared(f.at(f.foot(p)))
        };
        let t = self.cells.nearest(p, reach, distance).filter(|n| n.1.is_finite())?.0;
        let f = &self.facets[t as usize];
        let w = f.foot(p);
        Some((f.at(w), f.normal(w)))
    }

    pub(super) fn normal(&self, p: DVec3) -> Option<DVec3> {
        match self.plane {
            Some((n, _)) => Some(n),
            None => self.nearest(p).and_then(|(f, w)| f.normal(w)),
        }
    }

    pub(super) fn bend(&self, p: DVec3) -> Option<f64> {
        if self.plane.is_some() {
            return Some(0.0);
        }
        self.nearest(p).map(|(f, w)| f.bend(w, self.smooth))
    }
}

fn mix(c: &[DVec3; 3], w: [f64; 3]) -> DVec3 {
    c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
}

/// The plane through all corners to the precision given.
fn plane(facets: &[FaceTriangle], precision: f64) -> Option<(DVec3, f64)> {
    let n = facets.iter().map(|f| f.corners).map(|[a, b, c]| (b - a).cross(c - a)).sum::<DVec3>().try_normalize()?;
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in facets.iter().flat_map(|f| &f.corners) {
        let d = n.dot(*p);
        (lo, hi) = (lo.min(d), hi.max(d));
    }
    (hi - lo <= precision).then_some((n, 0.5 * (lo + hi)))
}

/// The segments of a line.
pub(super) struct SegmentLine {
    segments: Vec<[DVec3; 2]>,
    tree: Bvh,
}

impl SegmentLine {
    pub(super) fn new(segments: Vec<[DVec3; 2]>) -> Self {
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(*s)).collect());
        Self { segments, tree }
    }

    pub(super) fn foot(&self, p: DVec3) -> Option<DVec3> {
        let at = |k: u32| segment_foot(p, self.segments[k as usize]);
        self.tree.nearest(p, f64::INFINITY, |k| p.distance_squared(at(k))).map(|n| at(n.0))
    }
}
