//! What a boundary representation measures: areas, volume, boxes, parameter ranges.
//!
//! Faces are meshed and every triangle bent to its surface and to the curves of its edges by nodes in the middle of its
//! sides, once as a whole and once in quarters, which are divided on until both agree.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::mesh::{FaceMeshes, MeshSizes, Parametric, Place};
use crate::error::Result;
use crate::run::Run;
use crate::spatial::Aabb;

/// Neighboring sides of triangles turn by about this angle, in radians: a start for what is divided on.
const TURN: f64 = 0.2;
/// The longest side, as a share of the model.
const LONGEST: f64 = 0.05;
/// The shortest side curvature asks for, as a share of the model.
const SHORTEST: f64 = 0.0008;
/// A triangle is divided until its quarters' area is within this share of its own; what is left is 16 times smaller yet.
const SETTLED: f64 = 3e-5;
/// It is not divided either for less than this share of the square of the model's size.
const LEAST: f64 = 3e-10;
/// Triangles are divided this many times, at most.
const DEEPEST: usize = 6;
/// Where a face cannot be meshed, the same is tried with edges this many times as long.
const COARSER: [f64; 3] = [1.0, 1.7, 3.0];
/// Gaps in a periodic parameter of more than this share of the period are where a face has none.
const OPEN: f64 = 0.15;

/// Points and weights of a rule of degree 5 for triangles (R. Cowper, 1973).
const RULE: [(f64, f64, f64); 7] = {
    /// Two barycentric coordinates, (6 - √15) / 21, of the points near corners,
    const A: f64 = 0.101_286_507_323_456_34;
    /// and of those near the middles of sides, (6 + √15) / 21,
    const B: f64 = 0.470_142_064_105_115_1;
    /// with their weights: (155 - √15) / 1200
    const WA: f64 = 0.125_939_180_544_827_14;
    /// and (155 + √15) / 1200.
    const WB: f64 = 0.132_394_152_788_506_2;
    [
        (1.0 / 3.0, 1.0 / 3.0, 0.225),
        (A, A, WA),
        (1.0 - 2.0 * A, A, WA),
        (A, 1.0 - 2.0 * A, WA),
        (B, B, WB),
        (1.0 - 2.0 * B, B, WB),
        (B, 1.0 - 2.0 * B, WB),
    ]
};

/// One face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMeasure {
    /// Its area; `None` where it could not be meshed.
    pub area: Option<f64>,
    /// A box around it, to rounding but where the mesh that is measured passes over a peak.
    pub bounds: Aabb,
    /// The parameters it covers, u and v. A face that winds all around has a whole period.
    pub parameters: [[f64; 2]; 2],
}

/// A whole model.
#[derive(Debug, Clone, PartialEq)]
pub struct Measures {
    /// Its faces.
    pub faces: Vec<FaceMeasure>,
    /// Volume by body, signed: positive where faces look outwards. Of a body that is not closed it means nothing.
    pub volumes: Vec<f64>,
    /// Center of mass by body, of bodies whose volume is not zero. Of a body that is not closed it means nothing.
    pub centers: Vec<Option<DVec3>>,
    /// Nodes and triangles of the mesh all this was measured on first.
    pub counts: [usize; 2],
    /// A box around everything.
    pub bounds: Aabb,
}

impl Measures {
    /// The area of all faces that could be measured.
    pub fn area(&self) -> f64 {
        self.faces.iter().filter_map(|f| f.area).fold(0.0, |all, x| all + x)
    }
}

impl Parametric {
    /// Measures everything.
    ///
    /// *Guarantees*: the same numbers for any number of threads.
    /// *Does not guarantee*: more digits of areas and volumes than five or six; parameter ranges are those of nodes.
    /// *Errors*: cancellation.
    pub fn measure(&self, run: &Run) -> Result<Measures> {
        let size = self.bounds().diagonal();
        let mut made = FaceMeshes::default();
        for (i, coarser) in COARSER.into_iter().enumerate() {
            let by = move |k: f64| coarser * (TURN / k.max(1e-300)).clamp(SHORTEST * size, LONGEST * size);
            let next = self.mesh(&MeshSizes::new(coarser * LONGEST * size, coarser * SHORTEST * size, &by), run)?;
            if i == 0 || next.failures.len() < made.failures.len() {
                made = next;
            }
            if made.failures.is_empty() {
                break;
            }
        }
        let mut body = vec![usize::MAX; self.brep.faces.len()];
        for (b, f) in self.brep.bodies.iter().enumerate().flat_map(|(b, x)| x.faces.iter().map(move |f| (b, f))) {
            body[*f as usize] = b;
        }
        let mut out = Measures {
            faces: vec![
                FaceMeasure { area: Some(0.0), bounds: Aabb::EMPTY, parameters: [[0.0; 2]; 2] };
                self.brep.faces.len()
            ],
            volumes: vec![0.0; self.brep.bodies.len()],
            centers: Vec::new(),
            counts: [made.mesh.nodes.len(), made.mesh.triangles.len()],
            bounds: Aabb::EMPTY,
        };
        for (face, around) in out.faces.iter_mut().zip(self.boxes(&made)) {
            face.bounds = around;
        }
        let middle = self.bounds().center();
        let middle = if middle.is_finite() { middle } else { DVec3::ZERO };
        let bent = Bent { solid: self, made: &made, borders: borders(&made), least: LEAST * size * size, middle };
        let mut moments = vec![DVec3::ZERO; self.brep.bodies.len()];
        let mut points: Vec<Vec<DVec3>> = vec![Vec::new(); self.brep.faces.len()];
        let integral = |t: usize| {
            let mut seen = Vec::new();
            let found = bent.integral(t, &mut seen);
            seen.truncate(6);
            run.check().map(|()| (found, seen))
        };
        let list = 0..made.mesh.triangles.len();
        let integrals: Vec<_> = run.install(|| list.into_par_iter().map(integral).collect::<Result<_>>())?;
        for (t, (found, seen)) in integrals.into_iter().enumerate() {
            let label = made.mesh.labels[t] as usize;
            let face = &mut out.faces[label];
            face.area = face.area.map(|a| a + found.area);
            if let (Some(v), Some(m)) = (out.volumes.get_mut(body[label]), moments.get_mut(body[label])) {
                *v += found.volume;
                *m += found.moment;
            }
            points[label].extend(seen);
        }
        let center = |(v, m): (&f64, &DVec3)| Some(middle + *m / *v).filter(|c| c.is_finite());
        out.centers = out.volumes.iter().zip(&moments).map(center).collect();
        for f in &made.failures {
            out.faces[f.face as usize].area = None;
            let edges =
                self.brep.faces[f.face as usize].loops.iter().flatten().map(|c| &self.brep.edges[c.edge as usize]);
            let ends = edges.flat_map(|e| e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t)));
            out.faces[f.face as usize].bounds = Aabb::around(ends);
        }
        for (f, list) in points.iter().enumerate() {
            out.faces[f].parameters = self.covered(f, list);
            out.bounds = out.bounds.union(&out.faces[f].bounds);
        }
        Ok(out)
    }

    /// Unit normal of a face near a point, out of the solid.
    pub fn outward_normal(&self, face: u32, p: DVec3) -> Option<DVec3> {
        let chart = self.charts.get(face as usize)?;
        let n = chart.normal(chart.project(p))?;
        Some(if self.brep.faces[face as usize].outward { n } else { -n })
    }

    /// The ranges of parameters of points of a face.
    fn covered(&self, face: usize, points: &[DVec3]) -> [[f64; 2]; 2] {
        let chart = &self.charts[face];
        let uv: Vec<DVec2> = points.iter().map(|p| chart.wrapped(chart.project(*p))).collect();
        [0, 1].map(|k| {
            let mut t: Vec<f64> = uv.iter().map(|q| q[k]).collect();
            t.sort_by(f64::total_cmp);
            let (Some(&lo), Some(&hi)) = (t.first(), t.last()) else { return [0.0; 2] };
            let Some(period) = chart.periods[k] else { return [lo, hi] };
            // The widest gap on the circle is where the face is not.
            let inner = t.windows(2).map(|w| (w[1] - w[0], w[1], w[0]));
            let around = [(lo + period - hi, lo, hi)];
            let widest = inner.chain(around).max_by(|a, b| a.0.total_cmp(&b.0));
            match widest {
                Some((gap, from, to)) if gap > OPEN * period => [from, if to < from { to + period } else { to }],
                _ => [chart.bounds[k][0], chart.bounds[k][0] + period],
            }
        })
    }
}

/// Sides of triangles that are borders of their faces: not shared with another triangle of the face.
fn borders(made: &FaceMeshes) -> FxHashMap<(u32, [u32; 2]), u32> {
    let mut count: FxHashMap<(u32, [u32; 2]), u32> = FxHashMap::default();
    for (t, l) in made.mesh.triangles.iter().zip(&made.mesh.labels) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *count.entry((*l, [a.min(b), a.max(b)])).or_insert(0) += 1;
        }
    }
    count
}

struct Bent<'a> {
    solid: &'a Parametric,
    made: &'a FaceMeshes,
    borders: FxHashMap<(u32, [u32; 2]), u32>,
    /// Differences of areas that matter to nothing.
    least: f64,
    /// Moments are about this point: far from the model they would cancel.
    middle: DVec3,
}

/// Integrals over a part of the surface.
#[derive(Debug, Clone, Copy, Default)]
struct Integral {
    area: f64,
    /// Between the surface and the origin.
    volume: f64,
    /// Of the volume's coordinates, by half their squares times the normal.
    moment: DVec3,
}

impl Integral {
    /// This, and `share` times another.
    fn plus(self, share: f64, other: Self) -> Self {
        Self {
            area: self.area + share * other.area,
            volume: self.volume + share * other.volume,
            moment: self.moment + share * other.moment,
        }
    }
}

impl Bent<'_> {
    /// Integrals over a triangle and over its four quarters, taken to the limit; quarters are halved on where both differ.
    /// Every node on the way goes to `seen`.
    fn integral(&self, t: usize, seen: &mut Vec<DVec3>) -> Integral {
        let (nodes, label) = (self.made.mesh.triangles[t], self.made.mesh.labels[t]);
        let side = |k: usize| {
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            let border = self.borders.get(&(label, [a.min(b), a.max(b)])) == Some(&1);
            if border { self.edges_between(a, b, label) } else { Vec::new() }
        };
        let sides = [side(0), side(1), side(2)];
        let p = nodes.map(|v| self.made.mesh.nodes[v as usize]);
        let six = self.six(p, [&sides[0], &sides[1], &sides[2]], label);
        self.halved(&six, [&sides[0], &sides[1], &sides[2]], label, 0, seen)
    }

    /// Corners, and the middles of the sides 01, 12, 20.
    fn six(&self, p: [DVec3; 3], sides: [&[u32]; 3], label: u32) -> [DVec3; 6] {
        let middle = |k: usize| self.between(p[k], p[(k + 1) % 3], label, sides[k]);
        [p[0], p[1], p[2], middle(0), middle(1), middle(2)]
    }

    fn halved(&self, x: &[DVec3; 6], sides: [&[u32]; 3], label: u32, depth: usize, seen: &mut Vec<DVec3>) -> Integral {
        /// Edges of the model a side between parts lies on.
        const INSIDE: &[u32] = &[];
        let [a, b, c] = sides;
        let whole = integrals(x, self.middle);
        let parts = [
            ([x[0], x[3], x[5]], [a, INSIDE, c]),
            ([x[3], x[1], x[4]], [a, b, INSIDE]),
            ([x[5], x[4], x[2]], [INSIDE, b, c]),
            ([x[3], x[4], x[5]], [INSIDE; 3]),
        ]
        .map(|(p, s)| (self.six(p, s, label), s));
        seen.extend(x);
        let added = |s: Integral, v: Integral| s.plus(1.0, v);
        let sum = parts.iter().map(|p| integrals(&p.0, self.middle)).fold(Integral::default(), added);
        let off = (sum.area - whole.area).abs();
        if off > SETTLED * sum.area && off > self.least && depth < DEEPEST {
            let deeper = parts.iter().map(|(y, s)| self.halved(y, *s, label, depth + 1, seen));
            return deeper.fold(Integral::default(), added);
        }
        sum.plus(1.0 / 15.0, sum).plus(-1.0 / 15.0, whole)
    }

    /// The middle between two points, on the nearest of some edges, or else on the face.
    fn between(&self, p: DVec3, q: DVec3, label: u32, edges: &[u32]) -> DVec3 {
        let m = 0.5 * (p + q);
        let near = |x: &DVec3| x.distance(m) <= 0.5 * p.distance(q);
        let on_edges = edges.iter().map(|e| {
            let e = &self.solid.brep.edges[*e as usize];
            e.curve.at(e.curve.project(m, e.range, None))
        });
        let best = on_edges.min_by(|x, y| x.distance_squared(m).total_cmp(&y.distance_squared(m)));
        best.filter(near).or_else(|| self.solid.foot(label, m).filter(near)).unwrap_or(m)
    }

    /// Edges of a face that may hold two nodes.
    fn edges_between(&self, a: u32, b: u32, label: u32) -> Vec<u32> {
        let places = [a, b].map(|v| self.made.places[v as usize]);
        if let Some(e) = places.iter().find_map(|p| if let Place::Edge(e) = p { Some(*e) } else { None }) {
            return vec![e];
        }
        let [Place::Vertex(x), Place::Vertex(y)] = places else { return Vec::new() };
        let all = self.solid.brep.faces[label as usize].loops.iter().flatten().map(|c| c.edge);
        all.filter(|e| {
            let ends = self.solid.brep.edges[*e as usize].ends;
            ends == [x, y] || ends == [y, x]
        })
        .collect()
    }
}

/// Integrals over a quadratic triangle; moments are about a point.
fn integrals(x: &[DVec3; 6], middle: DVec3) -> Integral {
    let mut out = Integral::default();
    for (r, s, w) in RULE {
        let q = 1.0 - r - s;
        let at = q * (2.0 * q - 1.0) * x[0]
            + r * (2.0 * r - 1.0) * x[1]
            + s * (2.0 * s - 1.0) * x[2]
            + 4.0 * (q * r * x[3] + r * s * x[4] + s * q * x[5]);
        let dr = (4.0 * r - 1.0) * x[1] - (4.0 * q - 1.0) * x[0] + 4.0 * ((q - r) * x[3] + s * x[4] - s * x[5]);
        let ds = (4.0 * s - 1.0) * x[2] - (4.0 * q - 1.0) * x[0] + 4.0 * (r * x[4] - r * x[3] + (q - s) * x[5]);
        let n = dr.cross(ds);
        let off = at - middle;
        out.area += 0.5 * w * n.length();
        out.volume += 0.5 * w * at.dot(n) / 3.0;
        out.moment += 0.25 * w * off * off * n;
    }
    out
}
