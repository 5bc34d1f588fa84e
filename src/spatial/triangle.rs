//! A point and a triangle or a segment: distance, nearest point.

use glam::DVec3;

/// The point of the segment `ab` nearest to `p`; `a` where the segment has no length.
pub fn segment_foot(p: DVec3, [a, b]: [DVec3; 2]) -> DVec3 {
    let d = b - a;
    let squared = d.length_squared();
    if squared > 0.0 { a + d * ((p - a).dot(d) / squared).clamp(0.0, 1.0) } else { a }
}

/// Squared distance from `p` to the triangle `abc`.
pub fn triangle_distance_squared(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let w = triangle_foot(p, corners);
    (p - (corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2])).length_squared()
}

/// Barycentric coordinates of the point of the triangle `abc` nearest to `p`, by the regions of C. Ericson, "Real-Time
/// Collision Detection", 5.1.5. They are exactly 0 where the point lies on a side, exactly 1 at a corner.
pub fn triangle_foot(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    if !(sum > 0.0) {
        let d = [ap, bp, cp].map(|x| x.length_squared());
        return if d[0] <= d[1] && d[0] <= d[2] {
            [1.0, 0.0, 0.0]
        } else if d[1] <= d[2] {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
    }
    let (v, w) = (vb / sum, vc / sum);
    [1.0 - v - w, v, w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_nearest_point_is_found_in_all_seven_regions() {
        let t = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
        let cases = [
            ((0.5, 0.5, 3.0), 9.0),
            ((-1.0, -1.0, 0.0), 2.0),
            ((3.0, -1.0, 0.0), 2.0),
            ((-1.0, 3.0, 0.0), 2.0),
            ((1.0, -2.0, 0.0), 4.0),
            ((-2.0, 1.0, 0.0), 4.0),
            ((2.0, 2.0, 1.0), 3.0),
        ];
        for ((x, y, z), d) in cases {
            assert_abs_diff_eq!(triangle_distance_squared(DVec3::new(x, y, z), t), d, epsilon = 1e-14);
        }
        assert_eq!(triangle_distance_squared(DVec3::X, [DVec3::ZERO; 3]), 1.0);
    }
}
