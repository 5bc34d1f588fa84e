//! Analytic solids: Boolean trees of half-spaces, cylinders and spheres, with exact nearest-point projection.

use glam::{DMat3, DQuat, DVec3};

use crate::geometry::{Foot, SurfaceOracle};
use crate::numeric::ROUNDING;
use crate::numeric::svd::Qef;

/// A primitive with exact distance, negative outside.
#[derive(Debug, Clone, Copy)]
pub enum TestLeaf {
    Half { normal: DVec3, at: f64 },
    Cylinder { axis: DVec3, at: DVec3, r: f64 },
    Sphere { at: DVec3, r: f64 },
}

impl TestLeaf {
    fn distance(&self, p: DVec3) -> f64 {
        match *self {
            TestLeaf::Half { normal, at } => at - normal.dot(p),
            TestLeaf::Cylinder { axis, at, r } => r - (p - at).reject_from_normalized(axis).length(),
            TestLeaf::Sphere { at, r } => r - p.distance(at),
        }
    }

    /// Unit gradient of the distance.
    fn gradient(&self, p: DVec3) -> DVec3 {
        match *self {
            TestLeaf::Half { normal, .. } => -normal,
            TestLeaf::Cylinder { axis, at, .. } => {
                -(p - at).reject_from_normalized(axis).normalize_or(axis.any_orthonormal_vector())
            }
            TestLeaf::Sphere { at, .. } => -(p - at).normalize_or(DVec3::Z),
        }
    }

    fn curvatures(&self) -> [f64; 2] {
        match *self {
            TestLeaf::Half { .. } => [0.0, 0.0],
            TestLeaf::Cylinder { r, .. } => [1.0 / r, 0.0],
            TestLeaf::Sphere { r, .. } => [1.0 / r, 1.0 / r],
        }
    }
}

/// An intersection of leaves, some of them complemented: all the test parts are of this kind.
#[derive(Debug, Clone)]
pub struct TestPart {
    leaves: Vec<(TestLeaf, f64)>,
    pub half: f64,
}

impl TestPart {
    pub fn sphere(r: f64) -> Self {
        Self { leaves: vec![(TestLeaf::Sphere { at: DVec3::ZERO, r }, 1.0)], half: 1.3 * r }
    }

    fn cube(turn: DMat3) -> Vec<(TestLeaf, f64)> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let halves = axes.iter().flat_map(|&n| [n, -n]);
        halves.map(|n| (TestLeaf::Half { normal: turn * n, at: 1.0 }, 1.0)).collect()
    }

    pub fn plain_cube(turn: DMat3) -> Self {
        Self { leaves: Self::cube(turn), half: 1.9 }
    }

    /// Cube of side 2 with two crossing through-holes of radius 0.4 along x and z.
    pub fn cube_with_holes(turn: DMat3) -> Self {
        let mut leaves = Self::cube(turn);
        for axis in [DVec3::X, DVec3::Z] {
            leaves.push((TestLeaf::Cylinder { axis: turn * axis, at: DVec3::ZERO, r: 0.4 }, -1.0));
        }
        Self { leaves, half: if turn == DMat3::IDENTITY { 1.237 } else { 1.81 } }
    }

    /// Cube with a ball taken from a corner.
    pub fn cube_corner_sphere() -> Self {
        let mut leaves = Self::cube(DMat3::IDENTITY);
        leaves.push((TestLeaf::Sphere { at: DVec3::ONE, r: 0.8 }, -1.0));
        Self { leaves, half: 1.237 }
    }

    /// Cube with a ball and an infinite cylinder taken away.
    pub fn random_cube(at: DVec3, r: f64, axis: DVec3) -> Self {
        let mut leaves = Self::cube(DMat3::IDENTITY);
        leaves.push((TestLeaf::Sphere { at, r }, -1.0));
        leaves.push((TestLeaf::Cylinder { axis, at: -at, r: 0.5 * r }, -1.0));
        Self { leaves, half: 1.237 }
    }

    pub fn generic_turn() -> DMat3 {
        DMat3::from_quat(DQuat::from_xyzw(0.298, -0.274, -0.891, 0.201).normalize())
    }

    /// Signed distance bound, positive inside.
    pub fn value(&self, p: DVec3) -> f64 {
        self.leaves.iter().map(|(l, s)| s * l.distance(p)).fold(f64::INFINITY, f64::min)
    }

    fn solve(&self, p: DVec3, set: &[usize]) -> Option<DVec3> {
        let mut q = p;
        for _ in 0..30 {
            let mut qef = Qef::new(q);
            for &k in set {
                let g = self.leaves[k].0.gradient(q);
                qef.add(q - self.leaves[k].0.distance(q) * g, g, 1.0);
            }
            let step = qef.solve(1e-10);
            // Slide towards the foot of p within the set.
            let mut slide = p - q;
            let normals: Vec<DVec3> = set.iter().map(|&k| self.leaves[k].0.gradient(q)).collect();
            slide = match normals[..] {
                [n] => slide.reject_from_normalized(n),
                [n, m] => slide.project_onto(n.cross(m).try_normalize()?),
                _ => DVec3::ZERO,
            };
            q += step.step + 0.7 * slide;
            if step.step.length() + slide.length() < 1e-13 {
                break;
            }
        }
        (self.value(q).abs() < ROUNDING && set.iter().all(|&k| self.leaves[k].0.distance(q).abs() < ROUNDING))
            .then_some(q)
    }

    fn outward(&self, p: DVec3, k: usize) -> DVec3 {
        -self.leaves[k].1 * self.leaves[k].0.gradient(p)
    }

    /// Distance to the nearest crease whose normals differ by more than `angle` degrees, and to the nearest corner.
    pub fn crease_distance(&self, p: DVec3, angle: f64) -> f64 {
        let n = self.leaves.len();
        let mut best = f64::INFINITY;
        for i in 0..n {
            for j in 0..i {
                if let Some(q) = self.solve(p, &[i, j])
                    && self.outward(q, i).angle_between(self.outward(q, j)).to_degrees() > angle
                {
                    best = best.min(q.distance(p));
                }
            }
        }
        best
    }

    /// Points of the creases sharper than `angle`, about `step` apart, and all corners.
    pub fn creases(&self, step: f64, angle: f64) -> (Vec<DVec3>, Vec<DVec3>) {
        let n = self.leaves.len();
        let (mut curve, mut corners) = (Vec::new(), Vec::<DVec3>::new());
        let count = (2.0 * self.half / step) as i32;
        // Seeds: a grid over the surface neighborhood would be dear; walk lines of the grid near zero instead.
        let at = |k: i32| -self.half + (f64::from(k) + 0.5) * step;
        for i in 0..count {
            for j in 0..count {
                for k in 0..count {
                    let p = DVec3::new(at(i), at(j), at(k));
                    if self.value(p).abs() > step {
                        continue;
                    }
                    let near: Vec<usize> = (0..n).filter(|&l| self.leaves[l].0.distance(p).abs() < step).collect();
                    if near.len() < 2 {
                        continue;
                    }
                    for (x, &a) in near.iter().enumerate() {
                        for (y, &b) in near[..x].iter().enumerate() {
                            if let Some(q) = self.solve(p, &[a, b]) {
                                let sharp = self.outward(q, a).angle_between(self.outward(q, b)).to_degrees() > angle;
                                if sharp && (q - p).abs().max_element() <= 0.5 * step {
                                    curve.push(q);
                                }
                            }
                            for &c in &near[..y] {
                                let Some(q) = self.solve(p, &[a, b, c]) else { continue };
                                let det = self.outward(q, a).dot(self.outward(q, b).cross(self.outward(q, c)));
                                if det.abs() > 0.1 && corners.iter().all(|e| e.distance(q) > 1e-6) {
                                    corners.push(q);
                                }
                            }
                        }
                    }
                }
            }
        }
        (curve, corners)
    }
}

impl SurfaceOracle for TestPart {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let near: Vec<usize> =
            (0..self.leaves.len()).filter(|&k| self.leaves[k].0.distance(p).abs() <= reach).collect();
        let mut best: Option<(f64, DVec3, usize)> = None;
        let mut offer = |set: &[usize]| {
            if let Some(q) = self.solve(p, set) {
                let d = q.distance(p);
                if d <= reach && best.is_none_or(|b| d < b.0) {
                    best = Some((d, q, set[0]));
                }
            }
        };
        near.iter().for_each(|&k| offer(&[k]));
        if near.len() > 1 {
            for (x, &a) in near.iter().enumerate() {
                for (y, &b) in near[..x].iter().enumerate() {
                    offer(&[a, b]);
                    near[..y].iter().for_each(|&c| offer(&[a, b, c]));
                }
            }
        }
        best.map(|(_, point, k)| Foot { point, normal: self.outward(point, k), face: k as u32 })
    }

    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        let f = |t: f64| self.value(p + t * direction);
        /// Steps to each side in which a change of sign is looked for.
        const STEPS: i32 = 16;
        let at = |k: i32| reach * f64::from(k) / f64::from(STEPS);
        let mut best: Option<f64> = None;
        for side in [1.0, -1.0] {
            for k in 0..STEPS {
                let (mut lo, mut hi) = (side * at(k), side * at(k + 1));
                if best.is_some_and(|b| b.abs() <= lo.abs()) {
                    break;
                }
                let inside = f(lo) >= 0.0;
                if (f(hi) >= 0.0) != inside {
                    for _ in 0..60 {
                        let mid = 0.5 * (lo + hi);
                        if (f(mid) >= 0.0) == inside { lo = mid } else { hi = mid }
                    }
                    if best.is_none_or(|b| lo.abs() < b.abs()) {
                        best = Some(lo);
                    }
                    break;
                }
            }
        }
        let point = p + best? * direction;
        let k = (0..self.leaves.len()).min_by(|&a, &b| {
            let d = |k: usize| self.leaves[k].0.distance(point).abs();
            d(a).total_cmp(&d(b))
        })?;
        Some(Foot { point, normal: self.outward(point, k), face: k as u32 })
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        let (leaf, side) = self.leaves[foot.face as usize];
        Some(leaf.curvatures().map(|k| side * k))
    }
}
