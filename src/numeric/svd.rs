//! Least-squares points of tangent planes: 3x3 symmetric systems solved by truncated singular value decomposition.
//!
//! The system of \[LIS14\] (9, 10) has rank 1 where the surface is flat and rank 2 along a straight edge, so it cannot be
//! solved as it stands. Directions the planes say nothing about (small singular values) are left unmoved instead.
//!
//! *Guarantees*: the same input gives the same bits; NaN or infinite input gives rank 0 and a zero step.
//! *Does not guarantee*: that the solution lies near the origin of the system; callers clamp.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen};

/// Steps within which the eigenvalues of a 3x3 matrix are found, many times over.
const STEPS: usize = 100;

/// Eigenvalues, largest first, and the matching unit eigenvectors of a symmetric 3x3 matrix given as
/// `[xx, xy, xz, yy, yz, zz]`. For a positive semidefinite matrix these are its singular values and vectors. `None` for
/// NaN or infinite input.
pub fn symmetric_eigen(m: [f64; 6]) -> Option<([f64; 3], [DVec3; 3])> {
    if !m.iter().all(|x| x.is_finite()) {
        return None;
    }
    let [xx, xy, xz, yy, yz, zz] = m;
    let a = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let e = SymmetricEigen::try_new(a, f64::EPSILON, STEPS)?;
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| e.eigenvalues[j].total_cmp(&e.eigenvalues[i]));
    let vector = |i: usize| {
        let v = e.eigenvectors.column(i);
        DVec3::new(v[0], v[1], v[2])
    };
    Some((order.map(|i| e.eigenvalues[i]), order.map(vector)))
}

/// A sum of squared distances to planes, \[LIS14\] (9): collected plane by plane around an origin, then minimized.
#[derive(Debug, Clone, Copy)]
pub struct Qef {
    origin: DVec3,
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

/// The minimizer of a [`Qef`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QefStep {
    /// From the origin to the minimizer nearest to it.
    pub step: DVec3,
    /// How many singular values were kept, 0..=3: 1 on a flat place, 2 on a crease, 3 at a corner.
    pub rank: usize,
}

impl Qef {
    /// No planes yet; steps will count from `origin`, which should be near the answer.
    pub fn new(origin: DVec3) -> Self {
        Self { origin, a: [0.0; 6], b: DVec3::ZERO, c: 0.0, weight: 0.0 }
    }

    /// Adds the plane through `point` with unit `normal`, counted `weight` times.
    pub fn add(&mut self, point: DVec3, normal: DVec3, weight: f64) {
        let d = normal.dot(point - self.origin);
        let [x, y, z] = normal.to_array();
        for (sum, term) in self.a.iter_mut().zip([x * x, x * y, x * z, y * y, y * z, z * z]) {
            *sum += weight * term;
        }
        self.b += weight * d * normal;
        self.c += weight * d * d;
        self.weight += weight;
    }

    /// Mean squared distance from the origin to the planes, (9) with the missing 1/k; 0 without planes.
    pub fn error(&self) -> f64 {
        if self.weight > 0.0 { self.c / self.weight } else { 0.0 }
    }

    /// The minimizer, (10), with singular values below `cutoff` times the largest dropped: of all minimizers the one
    /// nearest to the origin.
    pub fn solve(&self, cutoff: f64) -> QefStep {
        let none = QefStep { step: DVec3::ZERO, rank: 0 };
        let Some((values, vectors)) = symmetric_eigen(self.a).filter(|e| e.0[0] > 0.0 && self.b.is_finite()) else {
            return none;
        };
        let mut out = none;
        for (value, vector) in values.into_iter().zip(vectors) {
            if value > cutoff * values[0] {
                out.step += vector.dot(self.b) / value * vector;
                out.rank += 1;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use approx::{abs_diff_eq, assert_abs_diff_eq};
    use proptest::prelude::*;

    use super::*;

    fn vector() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn eigenvectors_rebuild_the_matrix(m in prop::array::uniform6(-3.0f64..3.0)) {
            let (w, v) = symmetric_eigen(m).unwrap();
            prop_assert!(w[0] >= w[1] && w[1] >= w[2]);
            let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
            for i in 0..3 {
                for j in 0..3 {
                    let sum: f64 = (0..3).map(|k| w[k] * v[k][i] * v[k][j]).sum();
                    prop_assert!(abs_diff_eq!(sum, full[i][j], epsilon = 1e-12));
                    let unit = f64::from(u8::from(i == j));
                    prop_assert!(abs_diff_eq!(v[i].dot(v[j]), unit, epsilon = 1e-13));
                }
            }
        }

        #[test]
        fn three_planes_meet_in_their_corner(corner in vector(), n in prop::array::uniform3(vector())) {
            let n = n.map(|x| x.normalize_or(DVec3::X));
            prop_assume!(n[0].dot(n[1].cross(n[2])).abs() > 0.2);
            let mut q = Qef::new(DVec3::ZERO);
            n.iter().for_each(|&n| q.add(corner, n, 1.0));
            let s = q.solve(1e-6);
            prop_assert_eq!(s.rank, 3);
            prop_assert!(s.step.distance(corner) < 1e-9);
        }
    }

    #[test]
    fn a_crease_moves_across_itself_and_not_along() {
        let mut q = Qef::new(DVec3::new(0.3, 0.2, 5.0));
        q.add(DVec3::new(7.0, 0.0, 1.0), DVec3::Y, 1.0);
        q.add(DVec3::new(0.0, 7.0, 2.0), DVec3::X, 1.0);
        let s = q.solve(0.1);
        assert_eq!(s.rank, 2);
        assert!(s.step.distance(DVec3::new(-0.3, -0.2, 0.0)) < 1e-14);
        assert_abs_diff_eq!(q.error(), 0.5 * (0.09 + 0.04), epsilon = 1e-15);
    }

    #[test]
    fn a_flat_place_has_rank_one_and_garbage_rank_zero() {
        let mut q = Qef::new(DVec3::Z);
        for k in 0..5 {
            q.add(DVec3::new(f64::from(k), 1.0, 0.0), DVec3::Z, 1.0);
        }
        assert_eq!(q.solve(0.1), QefStep { step: -DVec3::Z, rank: 1 });
        q.add(DVec3::NAN, DVec3::X, 1.0);
        assert_eq!(q.solve(0.1).rank, 0);
        assert_eq!(Qef::new(DVec3::ZERO).solve(0.1).rank, 0);
    }
}
