//! The primitives of a `.csg` file under any affine map: as primitives where the map keeps shapes, else by planes and formulas.

use glam::{DAffine3, DMat3, DVec3};

use super::super::super::expr::{Binary, Expr, Unary};
use super::super::super::solid::{Placement, Primitive, Solid};
pub(super) use crate::implicit::written::ROOM;
use crate::spatial::Aabb;

/// OpenSCAD writes numbers with six digits: what differs by less, as a matrix from a rotation with a factor, is meant to be the same.
pub(super) const SIX_DIGITS: f64 = 5e-6;

/// A primitive where it was made, before it is placed. Cylinders and their kin stand on `bottom`.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    Cube {
        lo: DVec3,
        hi: DVec3,
    },
    Sphere {
        r: f64,
    },
    Cylinder(Round),
    /// A cylinder or cone of a few flat sides.
    Prism {
        sides: usize,
        round: Round,
    },
}

/// What a cylinder, a cone and the circle around a prism are told by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round {
    pub(super) r1: f64,
    pub(super) r2: f64,
    pub(super) bottom: f64,
    pub(super) height: f64,
}

impl Round {
    fn top(&self) -> f64 {
        self.bottom + self.height
    }
}

impl Shape {
    /// What it is called when it has no name, as part files do.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Shape::Cube { .. } => "box",
            Shape::Sphere { .. } => "sphere",
            Shape::Cylinder(c) if c.r1 == c.r2 => "cylinder",
            Shape::Cylinder(_) => "cone",
            Shape::Prism { .. } => "prism",
        }
    }

    /// The solid after an affine map that can be turned round, with names of faces that begin with `name`.
    pub(super) fn placed(&self, map: &DAffine3, name: &str) -> Solid {
        let primitive = match *self {
            Shape::Cube { lo, hi } => Some(Primitive::Box { lo, hi }),
            Shape::Sphere { r } => Some(Primitive::Sphere { r, at: DVec3::ZERO }),
            Shape::Cylinder(Round { r1, r2, bottom, height }) => {
                let (axis, at) = (DVec3::Z, DVec3::Z * (bottom + 0.5 * height));
                Some(if r1 == r2 {
                    Primitive::Cylinder { r: r1, axis, at, height: Some(height) }
                } else {
                    Primitive::Cone { r0: r1, r1: r2, height, axis, at }
                })
            }
            Shape::Prism { .. } => None,
        };
        match (primitive, similarity(map)) {
            (Some(p), Some(placement)) if placement == Placement::IDENTITY => Solid::from(p).name(name),
            (Some(p), Some(placement)) => Solid::from(p).placed(placement).name(name),
            (_, placement) => {
                let map = placement.map_or(*map, |p| DAffine3 { matrix3: p.rotation * p.scale, translation: p.shift });
                self.written_out(&map, name)
            }
        }
    }

    /// By planes and formulas. Planes of a box around the whole tell its bounds, and bound nothing: interval arithmetic does not
    /// find them where a map mixes coordinates.
    fn written_out(&self, map: &DAffine3, name: &str) -> Solid {
        let mut all: Vec<Solid> = Vec::new();
        let turned = map.matrix3.inverse().transpose();
        let mut plane = |sub: &str, normal: DVec3, at: DVec3| {
            let placed = Solid::half_space(turned * normal, map.transform_point3(at));
            all.push(placed.name(&format!("{name}.{sub}")));
        };
        let inside = || Local::of(map);
        let mut curved = None;
        match *self {
            Shape::Cube { lo, hi } => {
                for (axis, [low, high]) in
                    [["xmin", "xmax"], ["ymin", "ymax"], ["zmin", "zmax"]].into_iter().enumerate()
                {
                    plane(low, -DVec3::AXES[axis], lo);
                    plane(high, DVec3::AXES[axis], hi);
                }
            }
            Shape::Sphere { r } => curved = Some((name.to_string(), inside().ball(r))),
            Shape::Cylinder(round) => {
                caps(&round, &mut plane);
                curved = Some((format!("{name}.side"), inside().side(&round)));
            }
            Shape::Prism { sides, round } => {
                caps(&round, &mut plane);
                let half = std::f64::consts::PI / sides as f64;
                let (low, high) = (round.r1 * half.cos(), round.r2 * half.cos());
                for i in 0..sides {
                    let (sin, cos) = ((2 * i + 1) as f64 * half).sin_cos();
                    let out = DVec3::new(cos, sin, 0.0);
                    let normal = out * round.height + DVec3::Z * (low - high);
                    plane(&format!("side{i}"), normal, out * low + DVec3::Z * round.bottom);
                }
            }
        }
        let wall = match &curved {
            Some((face, _)) => face.clone(),
            None => format!("{name}.{}", if matches!(self, Shape::Cube { .. }) { "xmin" } else { "side0" }),
        };
        all.extend(curved.map(|(face, formula)| Solid::formula(formula).name(&face)));
        let bounds = self.bounds(map);
        let bounds = bounds.grown(ROOM * bounds.diagonal());
        for axis in DVec3::AXES {
            all.push(Solid::half_space(-axis, bounds.lo).name(&wall));
            all.push(Solid::half_space(axis, bounds.hi).name(&wall));
        }
        Solid::intersection(all)
    }

    /// The box around it after a map.
    fn bounds(&self, map: &DAffine3) -> Aabb {
        let m = map.matrix3;
        let row = |i: usize| m.row(i);
        match *self {
            Shape::Cube { lo, hi } => Aabb::around(Aabb::new(lo, hi).corners().map(|p| map.transform_point3(p))),
            Shape::Sphere { r } => {
                let half = DVec3::from_array(std::array::from_fn(|i| r * row(i).length()));
                Aabb::new(map.translation - half, map.translation + half)
            }
            Shape::Cylinder(round) | Shape::Prism { round, .. } => {
                let disk = |r: f64, z: f64| {
                    let center = map.transform_point3(DVec3::Z * z);
                    let half = DVec3::from_array(std::array::from_fn(|i| r * row(i).truncate().length()));
                    Aabb::new(center - half, center + half)
                };
                disk(round.r1, round.bottom).union(&disk(round.r2, round.top()))
            }
        }
    }
}

fn caps(round: &Round, plane: &mut impl FnMut(&str, DVec3, DVec3)) {
    if round.r1 > 0.0 {
        plane("bottom", -DVec3::Z, DVec3::Z * round.bottom);
    }
    if round.r2 > 0.0 {
        plane("top", DVec3::Z, DVec3::Z * round.top());
    }
}

/// Coordinates before a map as formulas of those after it.
pub(super) struct Local {
    /// The map back.
    back: DMat3,
    q: [Expr; 3],
}

impl Local {
    pub(super) fn of(map: &DAffine3) -> Self {
        let back = map.inverse();
        let q = std::array::from_fn(|k| {
            let row = back.matrix3.row(k);
            let start = Expr::constant(back.translation[k]);
            let terms = [Expr::x(), Expr::y(), Expr::z()].into_iter().zip(row.to_array());
            terms.filter(|(_, c)| *c != 0.0).fold(start, |sum, (x, c)| sum + x * c)
        });
        Local { back: back.matrix3, q }
    }

    /// `w = 1 - (sum of squares) / r^2` over the first few coordinates, normalized after Rvachev: close to a distance at its zeros.
    pub(super) fn quadric(&self, count: usize, r: f64) -> Expr {
        let square = |e: Expr| Expr::binary(Binary::Pow, e, Expr::constant(2.0));
        let k = 1.0 / (r * r);
        let mut w = Expr::constant(1.0);
        for q in &self.q[..count] {
            w = w - square(q.clone()) * k;
        }
        let mut under = square(w.clone() * (self.stretch() / r));
        for axis in 0..3 {
            let mut slope = Expr::constant(0.0);
            for (i, q) in self.q[..count].iter().enumerate() {
                slope = slope + q.clone() * (2.0 * k * self.back.row(i)[axis]);
            }
            under = under + square(slope);
        }
        w / Expr::unary(Unary::Sqrt, under)
    }

    /// How many times as long lengths are before the map, about.
    fn stretch(&self) -> f64 {
        self.back.determinant().abs().cbrt()
    }

    fn ball(&self, r: f64) -> Expr {
        self.quadric(3, r)
    }

    fn side(&self, round: &Round) -> Expr {
        if round.r1 == round.r2 {
            return self.quadric(2, round.r1);
        }
        let [x, y, z] = self.q.clone();
        let slope = (round.r2 - round.r1) / round.height;
        let radius = z * slope + (round.r1 - slope * round.bottom);
        (radius - Expr::binary(Binary::Hypot, x, y)) * (1.0 / self.stretch())
    }
}

/// The map as one that keeps shapes, which may mirror, up to six digits.
pub(super) fn similarity(map: &DAffine3) -> Option<Placement> {
    let scale = map.matrix3.determinant().abs().cbrt();
    let mut rotation = map.matrix3 * (1.0 / scale);
    let off = |m: &DMat3| {
        let rest = m.transpose() * *m - DMat3::IDENTITY;
        rest.to_cols_array().into_iter().fold(0.0, |most: f64, v| most.max(v.abs()))
    };
    // Also when it is not a number.
    if !(off(&rotation) < SIX_DIGITS) {
        return None;
    }
    // The nearest rotation by Newton's method, which has twice as many digits after each step.
    for _ in 0..4 {
        if off(&rotation) > 0.0 {
            rotation = (rotation + rotation.inverse().transpose()) * 0.5;
        }
    }
    let scale = if (scale - 1.0).abs() < SIX_DIGITS { 1.0 } else { scale };
    Some(Placement { rotation, scale, shift: map.translation })
}
