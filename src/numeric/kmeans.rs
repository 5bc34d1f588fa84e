//! Weighted k-means clustering of small vectors, which \[LIS14\] (16) and (17) use to tell nodes of different kinds apart.
//!
//! *Guarantees*: terminates (each round lowers the summed squared distance, and rounds are bounded); of centers equally near
//! the first wins, so nobody is left out; an empty cluster keeps its center. *Does not guarantee*: that the clusters
//! mean anything. k-means splits a sphere's normals as happily as a cube's, so the number of clusters has to be tested.

/// Clusters and who belongs where.
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters<const D: usize> {
    /// Weighted mean of each cluster (or its start, if nobody joined).
    pub centers: Vec<[f64; D]>,
    /// For each point, the number of its center.
    pub of: Vec<usize>,
    /// Rounds until nobody changed sides.
    pub rounds: usize,
}

fn distance_squared<const D: usize>(p: &[f64; D], c: &[f64; D]) -> f64 {
    p.iter().zip(c).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// As many starting centers as asked for, or fewer where points do not suffice: the heaviest point, then always the point with the
/// largest product of weight and squared distance to the nearest center so far. Points with weight 0 start nothing.
pub fn far_apart<const D: usize>(points: &[[f64; D]], weights: &[f64], count: usize) -> Vec<[f64; D]> {
    let mut nearest = vec![1.0; points.len()];
    let mut centers: Vec<[f64; D]> = Vec::with_capacity(count);
    while centers.len() < count {
        let mut best = (0.0, None);
        for (k, (&d, &w)) in nearest.iter().zip(weights).enumerate() {
            // A comparison with NaN is false, so such points never start a cluster.
            if d * w > best.0 {
                best = (d * w, Some(k));
            }
        }
        let Some(k) = best.1 else { break };
        let first = centers.is_empty();
        centers.push(points[k]);
        for (d, p) in nearest.iter_mut().zip(points) {
            let new = distance_squared(p, &points[k]);
            *d = if first { new } else { d.min(new) };
        }
    }
    centers
}

/// Lloyd's k-means from the given starting centers, at least one. Points with a coordinate that is not finite join the first
/// cluster and count in no mean.
pub fn k_means<const D: usize>(points: &[[f64; D]], weights: &[f64], centers: Vec<[f64; D]>) -> Clusters<D> {
    /// Lloyd's rounds on a few coordinates settle within a few dozen; the bound only guards against cycling on ties.
    const ROUNDS: usize = 200;
    let mut out = Clusters { of: vec![0; points.len()], rounds: 0, centers };
    for round in 1..=ROUNDS {
        out.rounds = round;
        let mut changed = false;
        let mut sums = vec![([0.0; D], 0.0); out.centers.len()];
        for ((p, &w), of) in points.iter().zip(weights).zip(&mut out.of) {
            let mut best = (f64::INFINITY, 0);
            for (k, c) in out.centers.iter().enumerate() {
                let d = distance_squared(p, c);
                if d < best.0 {
                    best = (d, k);
                }
            }
            changed |= best.1 != *of;
            *of = best.1;
            if p.iter().all(|x| x.is_finite())
                && let Some((sum, total)) = sums.get_mut(best.1)
            {
                sum.iter_mut().zip(p).for_each(|(s, x)| *s += w * x);
                *total += w;
            }
        }
        for (center, (sum, total)) in out.centers.iter_mut().zip(sums) {
            if total > 0.0 {
                *center = sum.map(|s| s / total);
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
        let weights = vec![1.0; 500];
        let c = k_means(&points, &weights, far_apart(&points, &weights, 2));
        assert_eq!(c.of.iter().filter(|&&x| x == c.of[7]).count(), 8);
        assert!(c.centers.contains(&[0.0]));
    }

    #[test]
    fn a_tie_belongs_to_the_first_and_an_empty_cluster_keeps_its_center() {
        let c = k_means(&[[1.0], [1.0]], &[1.0; 2], vec![[0.0], [2.0]]);
        assert_eq!((c.of, c.centers), (vec![0, 0], vec![[1.0], [2.0]]));
        assert_eq!(k_means::<1>(&[], &[], vec![[2.0], [1.0]]).centers, [[2.0], [1.0]]);
    }

    #[test]
    fn points_without_weight_pull_no_center_and_three_points_start_three() {
        let points = [[0.0, 0.0], [1.0, 0.0], [9.0, 9.0], [0.0, 1.0]];
        let weights = [1.0, 1.0, 0.0, 1.0];
        let starts = far_apart(&points, &weights, 4);
        assert_eq!(starts, [points[0], points[1], points[3]]);
        assert_eq!(k_means(&points, &weights, starts.clone()).centers, starts);
    }

    proptest! {
        #[test]
        fn every_point_is_nearest_to_its_own_center(
            points in prop::collection::vec(prop::array::uniform2(0.0f64..10.0), 2..60),
        ) {
            let weights = vec![1.0; points.len()];
            let c = k_means(&points, &weights, far_apart(&points, &weights, 3));
            for (p, &of) in points.iter().zip(&c.of) {
                let d = |c: [f64; 2]| (p[0] - c[0]).hypot(p[1] - c[1]);
                prop_assert!(c.centers.iter().all(|&other| d(c.centers[of]) <= d(other) + 1e-12));
            }
        }
    }
}
