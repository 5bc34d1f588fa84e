//! Two-means clustering of small vectors, as \[LIS14\] (16) and (17) use it to find corners and creases.
//!
//! *Guarantees*: terminates (each round lowers the summed squared distance, and rounds are bounded); ties belong to the
//! low cluster, so nobody is left out; an empty cluster keeps its center. *Does not guarantee*: that two clusters mean
//! anything. Two-means splits a sphere's curvatures as happily as a cube's: look at [`TwoMeans::contrast`].

/// Two clusters and who belongs where.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoMeans<const D: usize> {
    /// Mean of the high cluster (or its start, if nobody joined).
    pub high: [f64; D],
    /// Mean of the low cluster (or its start).
    pub low: [f64; D],
    /// For each point, whether it belongs to the high cluster.
    pub is_high: Vec<bool>,
    /// Rounds until nobody changed sides.
    pub rounds: usize,
}

impl<const D: usize> TwoMeans<D> {
    /// How many times longer the high center is than the low one; infinite when the low one is zero and the high one
    /// is not, 1 when both are zero.
    pub fn contrast(&self) -> f64 {
        let norm = |c: &[f64; D]| c.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (high, low) = (norm(&self.high), norm(&self.low));
        if high == 0.0 { 1.0 } else { high / low }
    }
}

/// Lloyd's two-means from the given starting centers. Points with a coordinate that is not finite join the low cluster
/// and count in no mean.
pub fn two_means<const D: usize>(points: &[[f64; D]], high: [f64; D], low: [f64; D]) -> TwoMeans<D> {
    // Lloyd's rounds on one or two coordinates settle within a few dozen; the bound only guards against cycling on ties.
    const ROUNDS: usize = 200;
    let distance = |p: &[f64; D], c: &[f64; D]| p.iter().zip(c).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
    let mut out = TwoMeans { high, low, is_high: vec![false; points.len()], rounds: 0 };
    for round in 1..=ROUNDS {
        out.rounds = round;
        let mut changed = false;
        let mut sums = [([0.0; D], 0usize), ([0.0; D], 0usize)];
        for (p, is_high) in points.iter().zip(&mut out.is_high) {
            // A comparison with NaN is false, which is the low cluster.
            let now = distance(p, &out.high) < distance(p, &out.low);
            changed |= now != *is_high;
            *is_high = now;
            if p.iter().all(|x| x.is_finite()) {
                let (sum, count) = &mut sums[usize::from(now)];
                sum.iter_mut().zip(p).for_each(|(s, x)| *s += x);
                *count += 1;
            }
        }
        for (center, (sum, count)) in [&mut out.low, &mut out.high].into_iter().zip(sums) {
            if count > 0 {
                *center = sum.map(|s| s / count as f64);
            }
        }
        if !changed && round > 1 {
            break;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn finds_the_eight_corners_of_a_cube_among_many_flat_nodes() {
        let mut points = vec![[0.0]; 500];
        for k in 0..8 {
            points[k * 60 + 7] = [std::f64::consts::FRAC_PI_2];
        }
        let c = two_means(&points, [std::f64::consts::FRAC_PI_2], [0.0]);
        assert_eq!(c.is_high.iter().filter(|&&x| x).count(), 8);
        assert_eq!(c.contrast(), f64::INFINITY);
    }

    #[test]
    fn a_tie_belongs_to_the_low_cluster_and_an_empty_cluster_keeps_its_center() {
        let c = two_means(&[[1.0], [1.0]], [2.0], [0.0]);
        assert_eq!(c.is_high, [false, false]);
        assert_eq!((c.high, c.low), ([2.0], [1.0]));
        let c = two_means::<1>(&[], [2.0], [1.0]);
        assert_eq!((c.high, c.low, c.contrast()), ([2.0], [1.0], 2.0));
    }

    proptest! {
        #[test]
        fn every_point_is_nearest_to_its_own_center(
            points in prop::collection::vec(prop::array::uniform2(0.0f64..10.0), 2..60),
        ) {
            let c = two_means(&points, [10.0, 0.0], [0.0, 0.0]);
            for (p, &is_high) in points.iter().zip(&c.is_high) {
                let d = |c: [f64; 2]| (p[0] - c[0]).hypot(p[1] - c[1]);
                let (own, other) = if is_high { (d(c.high), d(c.low)) } else { (d(c.low), d(c.high)) };
                prop_assert!(own <= other + 1e-12);
            }
        }
    }
}
