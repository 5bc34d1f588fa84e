//! Chains of curves in space: what faces are extruded, revolved and lofted from.

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::numeric::ROUNDING;
use crate::parametric::curve::Curve;
use crate::parametric::curve::PARTS;
use crate::parametric::frame::{Frame, Similarity};
use crate::parametric::nurbs::{NurbsCurve, SplineEnds};
use crate::spatial::Aabb;

pub(super) fn refuse<T>(what: impl Into<String>) -> Result<T> {
    Err(Error::input(Place::Unknown, what.into()))
}

/// A part of a curve, and the way it is run through.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The curve.
    pub curve: Curve,
    /// The part of it, ascending.
    pub range: [f64; 2],
    /// Whether the chain runs along the curve.
    pub forward: bool,
}

impl Piece {
    /// A straight piece.
    pub fn segment(a: DVec3, b: DVec3) -> Self {
        Self { curve: Curve::segment(a, b), range: [0.0, 1.0], forward: true }
    }

    /// Parameter at a share of the way, 0..=1.
    pub fn parameter(&self, share: f64) -> f64 {
        let [a, b] = self.range;
        let s = if self.forward { share } else { 1.0 - share };
        if s == 1.0 { b } else { a + s * (b - a) }
    }

    /// The point at a share of the way.
    pub fn at(&self, share: f64) -> DVec3 {
        self.curve.at(self.parameter(share))
    }

    /// The derivative in the direction of the chain at a share of the way.
    pub fn tangent(&self, share: f64) -> DVec3 {
        let d = self.curve.jet(self.parameter(share))[1];
        if self.forward { d } else { -d }
    }

    /// The way back.
    pub fn reversed(&self) -> Self {
        Self { forward: !self.forward, ..self.clone() }
    }

    /// The piece moved.
    pub fn moved(&self, m: &Similarity) -> Self {
        Self { curve: self.curve.moved(m), ..self.clone() }
    }

    /// The piece as NURBS over 0..=1, in the direction of the chain.
    pub fn to_nurbs(&self) -> Result<NurbsCurve> {
        let n = self.curve.to_nurbs(self.range)?;
        if self.forward { Ok(n) } else { n.reversed() }
    }

    /// Points along the piece, ends included.
    pub(super) fn samples(&self) -> Vec<DVec3> {
        let ends = self.curve.pieces(self.range);
        let inner =
            ends.windows(2).flat_map(|w| (0..PARTS).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64));
        let mut out: Vec<DVec3> = inner.chain([self.range[1]]).map(|t| self.curve.at(t)).collect();
        if !self.forward {
            out.reverse();
        }
        out
    }

    /// The integral of a function of point and derivative along the piece.
    pub(super) fn integral(&self, f: &dyn Fn(DVec3, DVec3) -> f64) -> f64 {
        let sum: f64 = self
            .curve
            .pieces(self.range)
            .windows(2)
            .map(|w| {
                crate::parametric::curve::gauss(w[0], w[1], |t| {
                    let [p, d, _] = self.curve.jet(t);
                    f(p, d)
                })
            })
            .sum();
        if self.forward { sum } else { -sum }
    }
}

/// Where a chain ends and does not start again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The chain's end.
    pub from: DVec3,
    /// Its start.
    pub to: DVec3,
}

impl std::fmt::Display for Gap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a gap of {} between {} and {}", self.from.distance(self.to), self.from, self.to)
    }
}

/// Pieces of curves that follow each other. The first does not meet the last unless the chain is closed.
#[derive(Debug, Clone, PartialEq)]
pub struct Wire {
    pieces: Vec<Piece>,
    closed: bool,
    tolerance: f64,
    turned: bool,
}

impl Wire {
    /// A chain from pieces in any order and direction; the first keeps its direction.
    ///
    /// Errors: no piece; a piece without length or with ends that are not finite; a gap between the pieces, which is named.
    pub fn new(pieces: Vec<Piece>) -> Result<Self> {
        if pieces.is_empty() {
            return refuse("a chain of edges without an edge");
        }
        let size = Aabb::around(pieces.iter().flat_map(Piece::samples)).diagonal();
        // Ends nearer to each other are one point: coordinates are what somebody computed.
        let tolerance = ROUNDING * size;
        for (i, p) in pieces.iter().enumerate() {
            if !(p.curve.length(p.range) > tolerance) || !size.is_finite() {
                return refuse(format!("edge {} of the chain has no length", i + 1));
            }
        }
        let same = |a: DVec3, b: DVec3| a.distance(b) <= tolerance;
        let mut rest = pieces;
        let mut chain = vec![rest.remove(0)];
        while !rest.is_empty() {
            let (start, end) = (chain[0].at(0.0), chain[chain.len() - 1].at(1.0));
            if let Some(i) = rest.iter().position(|p| same(p.at(0.0), end) || same(p.at(1.0), end)) {
                let p = rest.remove(i);
                chain.push(if same(p.at(0.0), end) { p } else { p.reversed() });
            } else if let Some(i) = rest.iter().position(|p| same(p.at(0.0), start) || same(p.at(1.0), start)) {
                let p = rest.remove(i);
                chain.insert(0, if same(p.at(1.0), start) { p } else { p.reversed() });
            } else {
                let ends = || rest.iter().flat_map(|p| [p.at(0.0), p.at(1.0)]);
                let gaps = [start, end].into_iter().flat_map(|from| ends().map(move |to| Gap { from, to }));
                let near = gaps.min_by(|a, b| a.from.distance(a.to).total_cmp(&b.from.distance(b.to)));
                return refuse(format!(
                    "the edges do not follow each other: {}",
                    near.map_or_else(String::new, |g| g.to_string())
                ));
            }
        }
        let closed = same(chain[0].at(0.0), chain[chain.len() - 1].at(1.0));
        Ok(Self { pieces: chain, closed, tolerance, turned: false })
    }

    /// Straight edges from point to point. Closed where the last point is the first.
    pub fn polyline(points: &[DVec3]) -> Result<Self> {
        if points.len() < 2 {
            return refuse("a polyline needs two points");
        }
        if let Some(i) = points.windows(2).position(|w| w[0] == w[1]) {
            return refuse(format!("points {} and {} of the polyline coincide", i + 1, i + 2));
        }
        Self::new(points.windows(2).map(|w| Piece::segment(w[0], w[1])).collect())
    }

    /// Straight edges from point to point and back to the first.
    pub fn polygon(points: &[DVec3]) -> Result<Self> {
        let mut all = points.to_vec();
        if points.first() != points.last() {
            all.extend(points.first());
        }
        if all.len() < 4 {
            return refuse("a polygon needs three points");
        }
        Self::polyline(&all)
    }

    /// One cubic spline with continuous curvature through the points, parametrized by chord length.
    pub fn spline(points: &[DVec3], ends: SplineEnds) -> Result<Self> {
        let curve = Curve::Nurbs(NurbsCurve::cubic(points, ends)?);
        let range = curve.domain();
        Self::new(vec![Piece { curve, range, forward: true }])
    }

    /// A whole circle around the frame's origin in its xy plane.
    pub fn circle(frame: Frame, radius: f64) -> Result<Self> {
        Self::ellipse(frame, radius, radius)
    }

    /// A whole ellipse around the frame's origin, with half axes along its x and y.
    pub fn ellipse(frame: Frame, a: f64, b: f64) -> Result<Self> {
        if !(a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite()) {
            return refuse("the radii of a circle or an ellipse must be positive");
        }
        let curve = Curve::Ellipse { frame, a, b };
        let range = curve.domain();
        Self::new(vec![Piece { curve, range, forward: true }])
    }

    /// The arc of a circle from `a` over `through` to `b`. Errors: the points are on a line.
    pub fn arc(a: DVec3, through: DVec3, b: DVec3) -> Result<Self> {
        let (u, v) = (through - a, b - a);
        let n = u.cross(v);
        let l = n.length_squared();
        if !(l > 1e-18 * u.length_squared() * v.length_squared()) {
            return refuse(format!("an arc through points on a line: {a}, {through}, {b}"));
        }
        let center = a + (v.length_squared() * n.cross(u) + u.length_squared() * v.cross(n)) / (2.0 * l);
        let frame = Frame::new(center, n, Some(a - center));
        let local = frame.local(b);
        let end = Frame::angle(local.truncate());
        let curve = Curve::circle(frame, a.distance(center));
        Self::new(vec![Piece { curve, range: [0.0, end], forward: true }])
    }

    /// Any curve over a range.
    pub fn curve(curve: Curve, range: [f64; 2]) -> Result<Self> {
        if !(range[0] < range[1] && range[1].is_finite() && range[0].is_finite()) {
            return refuse("the range of an edge must ascend and be finite");
        }
        Self::new(vec![Piece { curve, range, forward: true }])
    }

    /// A NURBS curve, as several edges where its direction jumps. Errors: knots at which the curve falls apart.
    pub fn nurbs(curve: NurbsCurve) -> Result<Self> {
        curve.knots.clone().whole()?;
        let [a, b] = curve.knots.domain();
        let ends: Vec<f64> = [a].into_iter().chain(curve.bends()).chain([b]).collect();
        let curve = Curve::Nurbs(curve);
        let piece = |w: &[f64]| Piece { curve: curve.clone(), range: [w[0], w[1]], forward: true };
        Self::new(ends.windows(2).map(piece).collect())
    }

    /// Several chains as one. Errors: see [`Wire::new`].
    pub fn joined(wires: &[Wire]) -> Result<Self> {
        Self::new(wires.iter().flat_map(|w| w.pieces.iter().cloned()).collect())
    }

    /// The pieces, in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The number of piece `i`, from 1, before the chain was reversed: what names go by.
    pub(super) fn number(&self, i: usize) -> usize {
        if self.turned { self.pieces.len() - i } else { i + 1 }
    }

    /// Whether the end is the start.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// What keeps the chain from being closed.
    pub fn gap(&self) -> Option<Gap> {
        (!self.closed).then(|| Gap { from: self.end(), to: self.start() })
    }

    /// The first point.
    pub fn start(&self) -> DVec3 {
        self.pieces[0].at(0.0)
    }

    /// The last point.
    pub fn end(&self) -> DVec3 {
        self.pieces[self.pieces.len() - 1].at(1.0)
    }

    /// Points nearer to each other than this count as one.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The points between the pieces; of an open chain also the last one.
    pub fn corners(&self) -> Vec<DVec3> {
        let mut out: Vec<DVec3> = self.pieces.iter().map(|p| p.at(0.0)).collect();
        if !self.closed {
            out.push(self.end());
        }
        out
    }

    /// The chain the other way round.
    pub fn reversed(&self) -> Self {
        let pieces = self.pieces.iter().rev().map(Piece::reversed).collect();
        Self { pieces, turned: !self.turned, ..*self }
    }

    /// The chain moved.
    pub fn moved(&self, m: &Similarity) -> Self {
        let pieces = self.pieces.iter().map(|p| p.moved(m)).collect();
        Self { pieces, tolerance: self.tolerance * m.scale, ..*self }
    }

    /// A box around points of the chain: that of the chain itself, to about a percent of its size.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.pieces.iter().flat_map(Piece::samples))
    }

    /// Half the integral of `r x dr`: of a flat closed chain its area, along the normal around which it runs
    /// counter-clockwise.
    pub fn area_vector(&self) -> DVec3 {
        let o = self.start();
        let part =
            |k: usize| -> f64 { self.pieces.iter().map(|p| p.integral(&|q, d| 0.5 * (q - o).cross(d)[k])).sum() };
        DVec3::new(part(0), part(1), part(2))
    }

    /// Points along the whole chain.
    pub(super) fn samples(&self) -> Vec<DVec3> {
        self.pieces.iter().flat_map(Piece::samples).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn p(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn pieces_are_put_in_order_and_gaps_are_named() {
        let (a, b, c, d) = (p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(0.0, 1.0, 0.0));
        let w = Wire::new(vec![Piece::segment(a, b), Piece::segment(c, d), Piece::segment(c, b), Piece::segment(d, a)])
            .unwrap();
        assert!(w.is_closed() && w.gap().is_none());
        assert_eq!(w.corners(), [a, b, c, d]);
        assert!(w.area_vector().distance(DVec3::Z) < 1e-15);
        assert!(w.reversed().area_vector().distance(-DVec3::Z) < 1e-15);
        let open = Wire::polyline(&[a, b, c]).unwrap();
        assert_eq!(open.gap(), Some(Gap { from: c, to: a }));
        let e = Wire::new(vec![Piece::segment(a, b), Piece::segment(p(1.0, 0.25, 0.0), c)]).unwrap_err().to_string();
        assert!(e.contains("a gap of 0.25 between [1, 0, 0] and [1, 0.25, 0]"), "{e}");
        assert!(Wire::new(Vec::new()).is_err() && Wire::polyline(&[a, a]).is_err());
    }

    #[test]
    fn arcs_run_through_their_points() {
        let (a, m, b) = (p(2.0, 0.0, 1.0), p(0.0, 2.0, 1.0), p(0.0, -2.0, 1.0));
        let w = Wire::arc(a, m, b).unwrap();
        assert!(w.start().distance(a) < 1e-14 && w.end().distance(b) < 1e-14);
        let c = &w.pieces()[0];
        assert_abs_diff_eq!(c.curve.length(c.range), 3.0 * std::f64::consts::PI, epsilon = 1e-9);
        assert!(c.curve.at(c.curve.project(m, c.range, None)).distance(m) < 1e-14);
        assert!(Wire::arc(a, b, a.lerp(b, 0.3)).is_err());
        let circle = Wire::circle(Frame::WORLD, 2.0).unwrap();
        assert!(circle.is_closed());
        assert_abs_diff_eq!(circle.area_vector().z, 4.0 * std::f64::consts::PI, epsilon = 1e-8);
    }
}
