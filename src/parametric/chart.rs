//! A surface with what it takes to find parameters of points: closed forms where there are any, else a net of samples to
//! start from and Newton's method.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec2, DVec3};

use super::curve::{Curve, FLAT};
use super::meridian;
use super::surface::{Pole, Surface};
use crate::geometry::NEWTON_STEPS;
use crate::numeric::{COS_26, SEVEN_DIGITS};
use crate::spatial::{Aabb, Bvh};

/// Cells of the net of samples, at most.
const MOST_CELLS: usize = 40_000;
/// Cells of the net per span of a spline, at most; a spline of few spans gets more by the next constant.
const MOST_PARTS: usize = 4;
/// How many times as long as wide cells may be.
const LONG_CELL: f64 = 2.0;
/// Cells of the net in each direction, at least.
const LEAST_CELLS: usize = 8;
/// The longest of them, as a share of the range of a parameter.
const LONGEST_STEP: f64 = 0.1;
/// How often one is halved that leads away.
const HALVINGS: usize = 12;

/// A surface and how to find one's way on it.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    pub(super) surface: Surface,
    /// Parameters that matter, finite but for surfaces with a closed form.
    pub(super) bounds: [[f64; 2]; 2],
    pub(super) periods: [Option<f64>; 2],
    pub(super) poles: Vec<Pole>,
    /// Whether the curvature of a pole is that of a point a little inside.
    pub(super) inset: bool,
    net: Option<SampleNet>,
}

#[derive(Debug, Clone)]
struct SampleNet {
    points: Vec<DVec3>,
    /// Unit normals Su x Sv, zero where there is none.
    normals: Vec<DVec3>,
    values: [Vec<f64>; 2],
    bvh: Bvh,
    last: Last,
}

/// The cell found last: where the next search starts. It bounds the search and does not change what is found, so it
/// does not matter which thread left it there.
#[derive(Debug, Default)]
struct Last(AtomicU32);

impl Clone for Last {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Chart {
    /// A chart for the part of a surface that lies near the box.
    pub(super) fn new(surface: Surface, around: &Aabb) -> Self {
        let mut bounds = surface.domain();
        let size = around.diagonal();
        match &surface {
            Surface::Extrusion { curve, direction } => {
                bounds[0] = finite(curve, bounds[0], around);
                let profile = Aabb::around(curve.pieces(bounds[0]).into_iter().map(|t| curve.at(t)));
                let l = direction.length_squared();
                let along = |b: &Aabb| {
                    let t = b.corners().map(|c| c.dot(*direction) / l);
                    (t.into_iter().fold(f64::INFINITY, f64::min), t.into_iter().fold(f64::NEG_INFINITY, f64::max))
                };
                let (a, b) = (along(around), along(&profile));
                let margin = 0.1 * size / direction.length();
                bounds[1] = [a.0 - b.1 - margin, a.1 - b.0 + margin];
            }
            Surface::Revolution { curve, .. } => bounds[1] = finite(curve, bounds[1], around),
            _ => {}
        }
        let periods = surface.periods();
        let poles = surface.poles();
        let mut this = Self { surface, bounds, periods, poles, inset: true, net: None };
        if this.surface.foot(this.surface.at(this.middle())).is_none() || matches!(this.surface, Surface::Offset { .. })
        {
            this.net = Some(this.sampled());
        }
        this
    }

    /// The chart of what lies around the points, where a profile of revolution that meets its axis makes several surfaces of one.
    pub(super) fn around_points(mut self, points: &[DVec3]) -> Self {
        let Surface::Revolution { curve, frame } = &self.surface else { return self };
        if let Some(part) = meridian::part(curve, frame, self.bounds[1], points) {
            (self.bounds[1], self.periods[1], self.poles) = (part.range, None, part.poles);
            self.net = Some(self.sampled());
        }
        self
    }

    /// Whether points are looked for in a net of samples.
    pub(super) fn is_sampled(&self) -> bool {
        self.net.is_some()
    }

    /// The chart of a part of the domain, with a net of its own; it has no period along the axis that is cut.
    pub(super) fn part(&self, axis: usize, range: [f64; 2]) -> Self {
        let mut this = Self { net: None, ..self.clone() };
        this.bounds[axis] = range;
        this.periods[axis] = None;
        this.poles.retain(|p| p.axis != axis || (range[0]..=range[1]).contains(&p.value));
        this.net = Some(this.sampled());
        this
    }

    fn middle(&self) -> DVec2 {
        let m = self.bounds.map(|[a, b]| if (b - a).is_finite() { 0.5 * (a + b) } else { 0.0 });
        DVec2::new(m[0], m[1])
    }

    fn sampled(&self) -> SampleNet {
        let mut values = [0, 1].map(|k| self.samples(k));
        // Long cells have boxes that hold much else: they are divided until they are about as wide as long.
        let length = [0, 1].map(|k| self.cell_length(&values, k));
        for k in 0..2 {
            let cells = (values[0].len() - 1) * (values[1].len() - 1);
            let most = (MOST_CELLS / cells.max(1)).max(1);
            let parts = ((length[k] / length[1 - k] / LONG_CELL) as usize).clamp(1, most);
            if parts > 1 {
                let inner = values[k].windows(2);
                let last = values[k][values[k].len() - 1];
                let part = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * i as f64 / parts as f64;
                values[k] = inner.flat_map(|w| (0..parts).map(move |i| part(w, i))).chain([last]).collect();
            }
        }
        while (values[0].len() - 1) * (values[1].len() - 1) > MOST_CELLS {
            let k = usize::from(values[1].len() > values[0].len());
            let last = values[k][values[k].len() - 1];
            values[k] = values[k].iter().copied().step_by(2).collect();
            if values[k][values[k].len() - 1] != last {
                values[k].push(last);
            }
        }
        let (points, normals): (Vec<DVec3>, Vec<DVec3>) = values[0]
            .iter()
            .flat_map(|u| values[1].iter().map(move |v| (*u, *v)))
            .map(|(u, v)| {
                let [s, su, sv, ..] = self.surface.jet(u, v);
                (s, super::surface::unit_normal(su, sv).unwrap_or(DVec3::ZERO))
            })
            .unzip();
        let net = SampleNet { points, normals, bvh: Bvh::new(Vec::new()), values, last: Last::default() };
        let count = (net.values[0].len() - 1) * (net.values[1].len() - 1);
        let both = |cell: usize| [2 * cell, 2 * cell + 1].into_iter().flat_map(|t| net.triangle(t));
        let boxes = (0..count).map(|cell| Aabb::around(both(cell).map(|c| net.points[c]))).collect();
        SampleNet { bvh: Bvh::new(boxes), ..net }
    }

    /// Parameters along the middle line of the net of samples, with the unit normals there, zero where there is none; nothing
    /// without a net.
    pub(super) fn net_row(&self, axis: usize) -> Vec<(f64, DVec3)> {
        let Some(net) = &self.net else { return Vec::new() };
        let (count, middle) = (net.values[1].len(), net.values[1 - axis].len() / 2);
        let index = |k: usize| if axis == 0 { k * count + middle } else { middle * count + k };
        net.values[axis].iter().enumerate().map(|(k, t)| (*t, net.normals[index(k)])).collect()
    }

    /// Mean length of cells along an axis, from a few lines.
    fn cell_length(&self, values: &[Vec<f64>; 2], axis: usize) -> f64 {
        let across = &values[1 - axis];
        let mut sum = 0.0;
        for k in 1..4 {
            let fixed = across[k * (across.len() - 1) / 4];
            let at = |t: f64| self.surface.at(if axis == 0 { DVec2::new(t, fixed) } else { DVec2::new(fixed, t) });
            sum += values[axis].windows(2).map(|w| at(w[0]).distance(at(w[1]))).sum::<f64>();
        }
        (sum / (3 * (values[axis].len() - 1)) as f64).max(f64::MIN_POSITIVE)
    }

    /// Parameters at which the net is sampled.
    fn samples(&self, axis: usize) -> Vec<f64> {
        let [a, b] = self.bounds[axis];
        let spline = |k: &super::basis::Knots| (k.breaks(), (k.degree() + 1).min(MOST_PARTS));
        let (breaks, parts) = match (&self.surface, axis) {
            (Surface::Nurbs(n), 0) => spline(&n.u),
            (Surface::Nurbs(n), _) => spline(&n.v),
            (Surface::Extrusion { curve, .. }, 0) | (Surface::Revolution { curve, .. }, 1) => (curve.pieces([a, b]), 4),
            (Surface::Extrusion { .. }, _) => (vec![a, b], 1),
            (Surface::Offset { base, .. }, _) => {
                let inner = Chart {
                    inset: self.inset,
                    surface: (**base).clone(),
                    bounds: self.bounds,
                    periods: self.periods,
                    poles: Vec::new(),
                    net: None,
                };
                return inner.samples(axis);
            }
            _ => (vec![a, b], 24),
        };
        // Those of the part of the domain that matters.
        let inner = breaks.into_iter().filter(|t| *t > a && *t < b);
        let breaks: Vec<f64> = [a].into_iter().chain(inner).chain([b]).collect();
        let parts = parts.max(LEAST_CELLS.div_ceil(breaks.len().max(2) - 1));
        let mut out: Vec<f64> = breaks
            .windows(2)
            .flat_map(|w| (0..parts).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / parts as f64))
            .collect();
        out.push(b);
        out
    }

    /// Brings parameters into the domain where they repeat.
    pub(super) fn wrapped(&self, mut uv: DVec2) -> DVec2 {
        for k in 0..2 {
            let [a, b] = self.bounds[k];
            if let Some(p) = self.periods[k]
                && !(uv[k] >= a && uv[k] <= b)
            {
                uv[k] = a + (uv[k] - a).rem_euclid(p);
            }
        }
        uv
    }

    /// Point and derivatives; parameters may be any number of periods away.
    pub(super) fn jet(&self, uv: DVec2) -> [DVec3; 6] {
        let uv = self.wrapped(uv);
        self.surface.jet(uv.x, uv.y)
    }

    /// The point; parameters may be any number of periods away.
    pub(super) fn at(&self, uv: DVec2) -> DVec3 {
        self.surface.at(self.wrapped(uv))
    }

    /// Parameters of the nearest point.
    pub(super) fn project(&self, p: DVec3) -> DVec2 {
        let Some(net) = &self.net else { return self.surface.foot(p).unwrap_or_default() };
        self.newton(p, net.nearest(p)).0
    }

    /// The point nearest to `p`.
    pub(super) fn foot(&self, p: DVec3) -> DVec3 {
        match (self.surface.nearest(p), &self.net) {
            (Some((q, _)), _) => q,
            (None, Some(net)) => self.newton(p, net.nearest(p)).1[0],
            (None, None) => self.at(self.project(p)),
        }
    }

    /// The distance of `p` to the surface if that is more than `known`, else any number between the two.
    pub(super) fn distance_beyond(&self, p: DVec3, known: f64) -> f64 {
        match (self.surface.nearest(p), &self.net) {
            (None, Some(net)) => self.newton_until(p, net.nearest(p), known).1[0].distance(p),
            _ => self.foot(p).distance(p),
        }
    }

    /// The point nearest to `p`, and the unit normal Su x Sv near it.
    pub(super) fn foot_and_normal(&self, p: DVec3) -> (DVec3, Option<DVec3>) {
        if let Some((q, n)) = self.surface.nearest(p) {
            return (q, Some(n));
        }
        let Some(net) = &self.net else {
            let q = self.foot(p);
            return (q, self.normal_near(q));
        };
        let (uv, [q, su, sv, ..]) = self.newton(p, net.nearest(p));
        // On a border of the domain there may be a crease, where derivatives are those of the other side.
        let within = |k: usize| self.periods[k].is_some() || (uv[k] > self.bounds[k][0] && uv[k] < self.bounds[k][1]);
        let normal = if within(0) && within(1) { super::surface::unit_normal(su, sv) } else { None };
        (q, normal.or_else(|| self.normal_near(q)))
    }

    /// Parameters of the nearest point to about the spacing of the net; exact where there is a closed form.
    pub(super) fn project_roughly(&self, p: DVec3) -> DVec2 {
        match &self.net {
            None => self.surface.foot(p).unwrap_or_default(),
            Some(net) => net.nearest(p),
        }
    }

    /// Unit normal Su x Sv near a point: exact where there is a closed form, else between those of the net's corners.
    pub(super) fn normal_near(&self, p: DVec3) -> Option<DVec3> {
        if let Some((_, n)) = self.surface.nearest(p) {
            return Some(n);
        }
        let Some(net) = &self.net else { return self.normal(self.surface.foot(p)?) };
        let (c, w) = net.found(p)?;
        let [a, b, d] = c.map(|k| net.normals[k]);
        // Normals of a cell whose corners have much the same one are taken from these.
        if a.dot(b).min(b.dot(d)).min(d.dot(a)) > COS_26 {
            return (w[0] * a + w[1] * b + w[2] * d).try_normalize();
        }
        self.normal((0..3).map(|k| w[k] * net.uv(c[k])).sum())
    }

    /// Parameters of the nearest point, as near to `last` as periods allow; where there are several feet, the one next to
    /// `last` unless it is much farther away than another.
    pub(super) fn project_near(&self, p: DVec3, last: DVec2) -> DVec2 {
        if self.net.is_none() {
            return self.unrolled(self.project(p), last);
        }
        let (near, [q, ..]) = self.newton(p, self.wrapped(last));
        let (away, slack) = (q.distance(p), 0.01 * self.at(last).distance(p));
        if away <= slack {
            return self.unrolled(near, last);
        }
        let best = self.project(p);
        let uv = if away <= self.at(best).distance(p) + slack { near } else { best };
        self.unrolled(uv, last)
    }

    /// The same point, whole periods away, with parameters as near to `last` as can be.
    pub(super) fn unrolled(&self, mut uv: DVec2, last: DVec2) -> DVec2 {
        for k in 0..2 {
            if let Some(p) = self.periods[k] {
                uv[k] -= ((uv[k] - last[k]) / p).round() * p;
            }
        }
        uv
    }

    /// Newton's method for the foot of `p`: its parameters, and the [jet](Self::jet) there.
    fn newton(&self, p: DVec3, start: DVec2) -> (DVec2, [DVec3; 6]) {
        self.newton_until(p, start, f64::NEG_INFINITY)
    }

    /// The same, which ends as soon as it is at a point no farther away than `enough`.
    fn newton_until(&self, p: DVec3, start: DVec2, enough: f64) -> (DVec2, [DVec3; 6]) {
        let mut uv = start;
        let mut jet = self.jet(uv);
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let [s, su, sv, suu, suv, svv] = jet;
            let r = s - p;
            if r.length() <= enough {
                break;
            }
            let (gu, gv) = (r.dot(su), r.dot(sv));
            let (e, f, g) = (su.length_squared(), su.dot(sv), sv.length_squared());
            let (a, b, c) = (e + r.dot(suu), f + r.dot(suv), g + r.dot(svv));
            let solve = |a: f64, b: f64, c: f64| {
                let det = a * c - b * b;
                (a > 0.0 && det > 1e-12 * a * c.abs()).then(|| DVec2::new(b * gv - c * gu, b * gu - a * gv) / det)
            };
            // Where the Hessian is not positive Gauss's step goes downhill, at poles the gradient does.
            let newton = solve(a, b, c);
            let step = newton.or_else(|| solve(e, f, g));
            let mut step = step.unwrap_or_else(|| {
                DVec2::new(if e > 0.0 { -gu / e } else { 0.0 }, if g > 0.0 { -gv / g } else { 0.0 })
            });
            // Near poles one parameter changes little in space and a step along it may go around more than once.
            let [a, b] = self.bounds.map(|[a, b]| if (b - a).is_finite() { LONGEST_STEP * (b - a) } else { f64::MAX });
            let over = (step.x / a).abs().max((step.y / b).abs());
            if over > 1.0 {
                step /= over;
            }
            let mut moved = false;
            // Whether this is Newton's own step, and the one before was.
            let own = newton.is_some_and(|n| n == step && self.clamped(uv + n) == uv + n);
            for _ in 0..HALVINGS {
                let next = self.clamped(uv + step);
                let there = self.jet(next);
                // Near the foot squares of distances no longer tell better from worse; Newton's step does.
                if there[0].distance_squared(p) <= s.distance_squared(p) * (1.0 + FLAT) {
                    moved = next != uv;
                    step = next - uv;
                    (uv, jet) = (next, there);
                    break;
                }
                step *= 0.5;
            }
            let length = (step.x * su + step.y * sv).length();
            // The error shrinks with its square: the next step would be about so long.
            let next = if own && before.is_finite() { length * (length / before).powi(2) } else { length };
            if !moved || length.min(next) <= 1e-14 * (s.length() + r.length()) {
                break;
            }
            before = if own { length } else { f64::INFINITY };
        }
        (uv, jet)
    }

    fn clamped(&self, mut uv: DVec2) -> DVec2 {
        for k in 0..2 {
            if self.periods[k].is_none() {
                uv[k] = uv[k].clamp(self.bounds[k][0], self.bounds[k][1]);
            }
        }
        uv
    }

    /// Unit normal Su x Sv at parameters; at a pole and other singular points, that of a point a little inside.
    pub(super) fn normal(&self, uv: DVec2) -> Option<DVec3> {
        let uv = self.wrapped(uv);
        self.surface.normal(uv).or_else(|| {
            let m = self.middle();
            [1e-4, 1e-2].into_iter().find_map(|s| self.surface.normal(uv.lerp(m, s)))
        })
    }

    /// The larger principal curvature at parameters. Nearer to a pole than a thousandth of the range it is that of a point
    /// which is that far from it, for each parameter on its own (\[BOR20\]); other borders need no such step.
    pub(super) fn curvature(&self, uv: DVec2) -> Option<f64> {
        /// Share of the range from a pole within which curvature is that of a point farther away.
        const INSIDE: f64 = 1e-3;
        let mut uv = self.wrapped(uv);
        for p in &self.poles {
            let [a, b] = self.bounds[p.axis];
            let range = if (b - a).is_finite() { b - a } else { p.value.abs().max(1.0) };
            let off = uv[p.axis] - p.value;
            if self.inset && off.abs() < INSIDE * range {
                let inward = if off != 0.0 {
                    off.signum()
                } else if p.value >= b {
                    -1.0
                } else {
                    1.0
                };
                uv[p.axis] = p.value + inward * INSIDE * range;
            }
        }
        self.surface.curvature(uv)
    }
}

impl SampleNet {
    fn triangle(&self, t: usize) -> [usize; 3] {
        let nv = self.values[1].len();
        let (i, j) = ((t / 2) / (nv - 1), (t / 2) % (nv - 1));
        let at = |i: usize, j: usize| i * nv + j;
        if t.is_multiple_of(2) {
            [at(i, j), at(i + 1, j), at(i + 1, j + 1)]
        } else {
            [at(i, j), at(i + 1, j + 1), at(i, j + 1)]
        }
    }

    fn uv(&self, corner: usize) -> DVec2 {
        let nv = self.values[1].len();
        DVec2::new(self.values[0][corner / nv], self.values[1][corner % nv])
    }

    /// Parameters of the nearest point of the net's triangles.
    fn nearest(&self, p: DVec3) -> DVec2 {
        let Some((c, w)) = self.found(p) else { return self.uv(0) };
        (0..3).map(|k| w[k] * self.uv(c[k])).sum()
    }

    /// Corners of the nearest triangle, and the weights of its nearest point.
    fn found(&self, p: DVec3) -> Option<([usize; 3], [f64; 3])> {
        let corners = |t: u32| self.triangle(t as usize).map(|c| self.points[c]);
        let of = |t: u32| crate::spatial::triangle_distance_squared(p, corners(t));
        let away = |cell: u32| of(2 * cell).min(of(2 * cell + 1));
        // The cell found last is near, so it leaves little to look at.
        let bound = away(self.last.0.load(Ordering::Relaxed)).sqrt() * (1.0 + 1e-9);
        let found = self.bvh.nearest(p, bound, away).or_else(|| self.bvh.nearest(p, f64::INFINITY, away));
        let (cell, near) = found?;
        self.last.0.store(cell, Ordering::Relaxed);
        let t = 2 * cell + u32::from(of(2 * cell) > near);
        let c = self.triangle(t as usize);
        Some((c, weights(p, corners(t))))
    }
}

/// Barycentric weights of about the nearest point of a triangle.
fn weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (u, v, w) = (b - a, c - a, p - a);
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let det = uu * vv - uv * uv;
    // A side of the net shorter than this share of another is a pole.
    let flat = uu.min(vv).min(b.distance_squared(c)) <= SEVEN_DIGITS * SEVEN_DIGITS * uu.max(vv);
    if flat || !(det > 1e-14 * uu * vv) {
        // A triangle without area: along its longest side, taken from a.
        let (side, d) = if uu >= vv { (0, u) } else { (1, v) };
        let t = if d.length_squared() > 0.0 { (w.dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
        return if side == 0 { [1.0 - t, t, 0.0] } else { [1.0 - t, 0.0, t] };
    }
    let (x, y) = ((vv * w.dot(u) - uv * w.dot(v)) / det, (uu * w.dot(v) - uv * w.dot(u)) / det);
    let k = [(1.0 - x - y).max(0.0), x.max(0.0), y.max(0.0)];
    let sum = k[0] + k[1] + k[2];
    k.map(|k| k / sum)
}

/// A finite part of a curve's domain that holds all of it that can lie in the box.
fn finite(curve: &Curve, [a, b]: [f64; 2], around: &Aabb) -> [f64; 2] {
    if (b - a).is_finite() {
        return [a, b];
    }
    let reach = |o: DVec3| o.distance(around.center()) + around.diagonal();
    let t = match curve {
        Curve::Line { origin, direction } => reach(*origin) / direction.length(),
        Curve::Parabola { frame, focal } => (reach(frame.origin) / focal).sqrt(),
        Curve::Hyperbola { frame, a, .. } => (reach(frame.origin) / a).max(1.0).acosh(),
        _ => 1.0,
    };
    [-t, t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parametric::frame::Frame;
    use crate::parametric::nurbs::{NurbsCurve, SplineEnds};
    use proptest::prelude::*;

    fn vase() -> Surface {
        let p = [
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(2.0, 0.0, 1.0),
            DVec3::new(0.8, 0.0, 2.0),
            DVec3::new(1.2, 0.0, 3.0),
        ];
        let curve = Curve::Nurbs(NurbsCurve::cubic(&p, SplineEnds::Natural).unwrap());
        Surface::Revolution { curve, frame: Frame::WORLD }
    }

    proptest! {
        #[test]
        fn points_off_the_surface_come_back(s in 0.02f64..0.98, t in 0.02f64..0.98, off in -0.1f64..0.1) {
            let around = Aabb::new(DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 3.0));
            let chart = Chart::new(vase(), &around);
            let uv = DVec2::new(s * std::f64::consts::TAU, t * chart.bounds[1][1]);
            let p = chart.at(uv) + off * chart.normal(uv).unwrap();
            prop_assert!(chart.at(chart.project(p)).distance(chart.at(uv)) < 1e-9);
            let last = uv + DVec2::new(12.6, 0.05);
            let near = chart.project_near(p, last);
            // Among several feet the one next to the start may be a little farther away.
            let slack = 0.02 * chart.at(last).distance(p);
            prop_assert!(chart.at(near).distance(p) <= off.abs() + slack + 1e-9 && (near.x - last.x).abs() < 3.2);
            prop_assert!(chart.at(chart.project_roughly(p)).distance(p) < 0.3);
            // Normals between those of the net's corners are a few degrees away from the exact ones.
            prop_assert!(chart.normal_near(p).unwrap().dot(chart.normal(uv).unwrap()) > 0.98);
            prop_assert!(chart.foot(p).distance(chart.at(uv)) < 1e-9);
        }
    }
}
