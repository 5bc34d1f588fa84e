//! Solids made of plane figures: extruded along z, and turned about the z axis.

use rustc_hash::FxHashMap;
use std::sync::Arc;

use super::expr::{Binary, Expr, ExprNode, Unary};
use super::lower::lower;
use super::plane::check_plane;
use super::shapes::clean;
use super::solid::{Placement, Primitive, Solid, SolidNode};
use crate::error::{Error, Place, Result};
use crate::spatial::Aabb;

/// Nodes of a figure's tree, written out, that are turned.
const MOST_NODES: usize = 1_000_000;

/// A coordinate is zero where it is less than this share of the figure's size: what rounding leaves of a placement.
const ROUNDING: f64 = 1e-14;

/// A primitive of the plane, placed there, that is turned about the z axis.
#[derive(Debug, Clone)]
pub struct Turned {
    /// The primitive, which is the same at every z after the placement.
    pub(super) solid: Solid,
    pub(super) placement: Placement,
}

/// A solid without shared parts, and the number of its nodes.
pub(super) struct WrittenOut {
    pub(super) solid: Solid,
    pub(super) nodes: usize,
}

impl Solid {
    /// The plane figure between `z = -height / 2` and `height / 2`, with faces `bottom` and `top`.
    ///
    /// Errors: a height that is not positive; a solid that is not the same at every z, see [`check_plane`].
    pub fn extruded(self, height: f64) -> Result<Solid> {
        check_plane(&self)?;
        if !(height > 0.0 && height.is_finite()) {
            return Err(Error::input(
                Place::Unknown,
                format!("the height of an extrusion must be positive, not {height}"),
            ));
        }
        // The figure tells its box where it stands upright; leaning it may not.
        let around = lower(&self)?.bounds;
        let slab = Solid::from(Primitive::Slab { height, around });
        let slab = match own_name(&self) {
            Some(name) => slab.name(&name),
            None => slab,
        };
        Ok(Solid::intersection([self, slab]))
    }

    /// The plane figure turned about the z axis: its x becomes the radius, its y becomes z. What is at negative x does not count.
    ///
    /// Errors: a solid that is not the same at every z, see [`check_plane`]; a tree of more than a million nodes when written out.
    pub fn revolved(self) -> Result<Solid> {
        self.written_turned().map(|w| w.solid)
    }

    /// The same, and how large it is.
    pub(super) fn written_turned(self) -> Result<WrittenOut> {
        check_plane(&self)?;
        enum Work<'a> {
            Visit(&'a Solid, Placement),
            Wrap(&'a Solid, f64),
        }
        let mut work = vec![Work::Visit(&self, Placement::IDENTITY)];
        let mut done: Vec<Solid> = Vec::new();
        let mut visited = 0;
        while let Some(w) = work.pop() {
            match w {
                Work::Visit(s, place) => {
                    visited += 1;
                    if visited > MOST_NODES {
                        let what =
                            format!("the figure that is turned has more than {MOST_NODES} nodes when written out");
                        return Err(Error::input(Place::Unknown, what));
                    }
                    let wrap = Work::Wrap(s, place.scale);
                    match s.node() {
                        SolidNode::Primitive(_) => {
                            let turned = Turned { solid: s.clone(), placement: place };
                            done.push(Primitive::Turned(turned).into());
                        }
                        SolidNode::Placed(p, inner) => work.push(Work::Visit(inner, place.after(p))),
                        SolidNode::And(all) | SolidNode::Or(all) => {
                            work.push(wrap);
                            work.extend(all.iter().rev().map(|s| Work::Visit(s, place)));
                        }
                        SolidNode::Not(inner) | SolidNode::Named(_, inner) | SolidNode::Sized(_, inner) => {
                            work.extend([wrap, Work::Visit(inner, place)]);
                        }
                        SolidNode::Blend(a, b, _) => {
                            work.extend([wrap, Work::Visit(b, place), Work::Visit(a, place)]);
                        }
                    }
                }
                Work::Wrap(s, scale) => {
                    let count = match s.node() {
                        SolidNode::And(all) | SolidNode::Or(all) => all.len(),
                        SolidNode::Blend(..) => 2,
                        _ => 1,
                    };
                    let mut parts = done.split_off(done.len().saturating_sub(count));
                    let node = match (s.node(), parts.len()) {
                        (SolidNode::And(_), _) => SolidNode::And(parts),
                        (SolidNode::Blend(_, _, r), 2) => {
                            let b = parts.swap_remove(1);
                            SolidNode::Blend(parts.swap_remove(0), b, r * scale)
                        }
                        (SolidNode::Not(_), 1) => SolidNode::Not(parts.swap_remove(0)),
                        (SolidNode::Named(n, _), 1) => SolidNode::Named(n.clone(), parts.swap_remove(0)),
                        (SolidNode::Sized(h, _), 1) => SolidNode::Sized(*h, parts.swap_remove(0)),
                        _ => SolidNode::Or(parts),
                    };
                    done.push(Solid::new(node));
                }
            }
        }
        let solid = done.pop().ok_or_else(|| Error::Failed("the figure that is turned has no root".into()))?;
        Ok(WrittenOut { solid, nodes: visited })
    }
}

/// The name that all faces of a solid have which have no other.
fn own_name(solid: &Solid) -> Option<Arc<str>> {
    let mut s = solid;
    let mut name = None;
    loop {
        s = match s.node() {
            SolidNode::Named(n, inner) => {
                name = Some(n.clone());
                inner
            }
            SolidNode::Placed(_, inner) | SolidNode::Sized(_, inner) => inner,
            _ => return name,
        };
    }
}

/// A coordinate, but exactly zero where it is what rounding leaves of lengths such as `size`.
pub(super) fn snapped(v: f64, size: f64) -> f64 {
    if v.abs() <= ROUNDING * size.abs() { 0.0 } else { v }
}

/// A closed line of points (radius, z), with the names of the edges that begin in them.
pub(super) struct Ring {
    pub(super) points: Vec<[f64; 2]>,
    pub(super) names: Vec<String>,
}

/// Where a run of points beside the axis begins or ends on it.
#[derive(Clone, Copy)]
struct End {
    z: f64,
    run: usize,
    last: bool,
}

impl Ring {
    /// That of a polygon, whose edges have numbers.
    pub(super) fn numbered(points: Vec<[f64; 2]>) -> Self {
        let names = (0..points.len()).map(|i| format!("side{i}")).collect();
        Ring { points, names }
    }

    /// Whether some of it is beyond the axis.
    pub(super) fn is_cut(&self) -> bool {
        self.points.iter().any(|p| p[0] < 0.0)
    }

    /// The rings around what is inside of it at positive radii. An edge beyond the axis would turn into a surface that may touch the solid
    /// in a point alone.
    pub(super) fn beside_axis(self) -> Vec<Self> {
        if !self.is_cut() {
            return vec![self];
        }
        let n = self.points.len();
        let at = |i: usize| self.points[i % n];
        let on_axis = |i: usize| match [at(i), at(i + 1)] {
            [p, _] if p[0] == 0.0 => p,
            [_, q] if q[0] == 0.0 => q,
            [p, q] => [0.0, p[1] + p[0] / (p[0] - q[0]) * (q[1] - p[1])],
        };
        let mut runs: Vec<Ring> = Vec::new();
        for i in (0..n).filter(|i| at(*i)[0] <= 0.0 && at(i + 1)[0] > 0.0) {
            let inner: Vec<usize> = (i + 1..i + n).take_while(|k| at(*k)[0] > 0.0).collect();
            let mut points = vec![on_axis(i)];
            points.extend(inner.iter().map(|k| at(*k)));
            points.push(on_axis(i + inner.len()));
            let mut names = vec![self.names[i].clone()];
            names.extend(inner.iter().map(|k| self.names[k % n].clone()));
            // Along the axis there is no surface.
            names.push(String::new());
            runs.push(Ring { points, names });
        }
        // Between the first place on the axis and the second it is inside, and so on.
        let mut ends: Vec<End> = Vec::new();
        for (run, ring) in runs.iter().enumerate() {
            let z = [0, ring.points.len() - 1].map(|k| ring.points[k][1]);
            ends.extend([End { z: z[0], run, last: false }, End { z: z[1], run, last: true }]);
        }
        ends.sort_by(|a, b| a.z.total_cmp(&b.z));
        let mut next = vec![0; runs.len()];
        for k in (0..ends.len()).step_by(2) {
            // Two that touch each other on the axis may come in any order.
            if ends[k].last == ends[k + 1].last && k + 2 < ends.len() {
                ends.swap(k + 1, k + 2);
            }
            let (a, b) = if ends[k].last { (ends[k], ends[k + 1]) } else { (ends[k + 1], ends[k]) };
            next[a.run] = b.run;
        }
        let mut is_done = vec![false; runs.len()];
        let mut rings = Vec::new();
        for first in 0..runs.len() {
            let mut ring = Ring { points: Vec::new(), names: Vec::new() };
            let mut run = first;
            while !std::mem::replace(&mut is_done[run], true) {
                ring.points.append(&mut runs[run].points);
                ring.names.append(&mut runs[run].names);
                run = next[run];
            }
            if !ring.points.is_empty() {
                rings.push(ring);
            }
        }
        rings
    }
}

/// The box of a slab with a figure in it.
pub(super) fn slab_bounds(around: &Aabb, half: f64, place: &Placement) -> Option<Aabb> {
    let known = [around.lo.x, around.lo.y, around.hi.x, around.hi.y].iter().all(|v| v.is_finite());
    known.then(|| {
        let b = Aabb::new(around.lo.with_z(-half), around.hi.with_z(half));
        Aabb::around(b.corners().map(|p| place.apply(p)))
    })
}

/// A formula with, where it is a multiple of the radius, the factor.
#[derive(Clone)]
struct Term {
    e: Expr,
    radial: Option<f64>,
}

impl Term {
    fn plain(e: Expr) -> Self {
        Term { e, radial: None }
    }

    fn radial(factor: f64) -> Self {
        let r = Expr::binary(Binary::Hypot, Expr::x(), Expr::y());
        Term { e: scaled(r, factor), radial: Some(factor) }
    }
}

fn scaled(e: Expr, factor: f64) -> Expr {
    if factor == 1.0 { e } else { e * factor }
}

/// The square of a multiple of the radius, which has a slope on the axis.
fn squared(factor: f64) -> Expr {
    let square = |e: Expr| Expr::binary(Binary::Pow, e, Expr::constant(2.0));
    scaled(square(Expr::x()) + square(Expr::y()), factor * factor)
}

/// A formula of the plane, placed there, turned about the z axis: the radius takes the place of x and z that of y.
pub(super) fn formula(e: &Expr, place: &Placement) -> Expr {
    // Coordinates of the formula are sums of the radius and z.
    let coordinate: [Term; 3] = std::array::from_fn(|k| {
        let column = clean(place.rotation.col(k));
        let start = snapped(-column.dot(place.shift), place.shift.length()) / place.scale;
        let (of_r, of_z) = (column.x / place.scale, column.y / place.scale);
        if of_z == 0.0 && start == 0.0 {
            return if of_r == 0.0 { Term::plain(Expr::constant(0.0)) } else { Term::radial(of_r) };
        }
        let mut sum = scaled(Expr::z(), of_z);
        if of_z == 0.0 {
            sum = Term::radial(of_r).e;
        } else if of_r != 0.0 {
            sum = Term::radial(of_r).e + sum;
        }
        Term::plain(if start == 0.0 { sum } else { sum + start })
    });
    let mut made: FxHashMap<*const ExprNode, Term> = FxHashMap::default();
    let mut stack = vec![(e, false)];
    while let Some((e, ready)) = stack.pop() {
        let key = Arc::as_ptr(&e.0);
        if made.contains_key(&key) {
            continue;
        }
        if !ready {
            stack.push((e, true));
            match e.node() {
                ExprNode::Const(_) | ExprNode::Coordinate(_) => {}
                ExprNode::Unary(_, a) => stack.push((a, false)),
                ExprNode::Binary(_, a, b) => stack.extend([(a, false), (b, false)]),
                ExprNode::Select(a, b, c) => stack.extend([(a, false), (b, false), (c, false)]),
            }
            continue;
        }
        let of = |e: &Expr| made.get(&Arc::as_ptr(&e.0)).cloned().unwrap_or_else(|| Term::plain(e.clone()));
        let term = match e.node() {
            ExprNode::Const(v) => Term::plain(Expr::constant(*v)),
            ExprNode::Coordinate(k) => coordinate[usize::from(*k).min(2)].clone(),
            ExprNode::Unary(op, a) => unary(*op, of(a)),
            ExprNode::Binary(op, a, b) => binary(*op, of(a), of(b)),
            ExprNode::Select(a, b, c) => Term::plain(Expr::select(of(a).e, of(b).e, of(c).e)),
        };
        made.insert(key, term);
    }
    made.remove(&Arc::as_ptr(&e.0)).map_or_else(|| e.clone(), |t| t.e)
}

fn unary(op: Unary, a: Term) -> Term {
    match (op, a.radial) {
        (Unary::Neg, Some(f)) => Term::radial(-f),
        (Unary::Abs, Some(f)) => Term::radial(f.abs()),
        _ => Term::plain(Expr::unary(op, a.e)),
    }
}

fn binary(op: Binary, a: Term, b: Term) -> Term {
    let number = |t: &Term| t.e.as_constant();
    match (op, a.radial, b.radial) {
        (Binary::Add, Some(f), Some(g)) if f + g != 0.0 => return Term::radial(f + g),
        (Binary::Sub, Some(f), Some(g)) if f != g => return Term::radial(f - g),
        (Binary::Mul, Some(f), Some(g)) if f == g => return Term::plain(squared(f)),
        (Binary::Mul, Some(f), Some(g)) => return Term::plain(squared(1.0) * (f * g)),
        _ => {}
    }
    match (op, number(&a), number(&b)) {
        // Sums with nothing, and products with it, are how figures of an ellipse are written.
        (Binary::Add, Some(0.0), _) => return b,
        (Binary::Add | Binary::Sub, _, Some(0.0)) => return a,
        (Binary::Mul, Some(0.0), _) | (Binary::Mul, _, Some(0.0)) => return Term::plain(Expr::constant(0.0)),
        _ => {}
    }
    match (op, a.radial, number(&b)) {
        (Binary::Mul, Some(f), Some(v)) => return Term::radial(f * v),
        (Binary::Div, Some(f), Some(v)) if v != 0.0 && f / v != 0.0 => return Term::radial(f / v),
        (Binary::Pow, Some(f), Some(n)) if n > 0.0 && n % 2.0 == 0.0 => {
            let square = squared(f);
            return Term::plain(if n == 2.0 {
                square
            } else {
                Expr::binary(Binary::Pow, square, Expr::constant(0.5 * n))
            });
        }
        _ => {}
    }
    if let (Binary::Mul, Some(v), Some(f)) = (op, number(&a), b.radial) {
        return Term::radial(f * v);
    }
    // The length of what has the radius in it has a slope on the axis, too.
    let with_radius = match (a.radial, b.radial) {
        (Some(f), _) => Some((f, &b.e)),
        (_, g) => g.map(|g| (g, &a.e)),
    };
    if let (Binary::Hypot, Some((f, other))) = (op, with_radius) {
        let square = Expr::binary(Binary::Pow, other.clone(), Expr::constant(2.0));
        return Term::plain(Expr::unary(Unary::Sqrt, squared(f) + square));
    }
    Term::plain(Expr::binary(op, a.e, b.e))
}
