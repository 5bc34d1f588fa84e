//! Crossings against integer arithmetic, axes of known regions, trimming of regions with narrow parts.

use approx::assert_abs_diff_eq;
use glam::DVec2;
use proptest::prelude::*;

use super::*;

fn points(list: &[[f64; 2]]) -> Vec<DVec2> {
    list.iter().map(|p| DVec2::from_array(*p)).collect()
}

/// Signed, counter-clockwise positive.
fn area(contour: &[DVec2]) -> f64 {
    (0..contour.len()).map(|i| contour[i].perp_dot(contour[(i + 1) % contour.len()])).sum::<f64>() / 2.0
}

fn rectangle(lo: [f64; 2], hi: [f64; 2]) -> Vec<DVec2> {
    points(&[lo, [hi[0], lo[1]], hi, [lo[0], hi[1]]])
}

#[test]
fn contours_that_only_follow_do_not_meet() {
    let square = rectangle([0.0, 0.0], [1.0, 1.0]);
    assert_eq!(crossings(&[square.clone(), rectangle([0.2, 0.2], [0.8, 0.8])]), []);
    let meeting = |second: Vec<DVec2>| crossings(&[square.clone(), second]);
    let m = meeting(rectangle([0.5, 0.25], [1.5, 0.75]));
    assert_eq!(m.len(), 2);
    assert!(m.iter().all(|m| m.crosses && m.first == [0, 1]));
    // a corner on a side, and a common stretch
    assert!(meeting(points(&[[1.0, 0.5], [2.0, 0.0], [2.0, 1.0]])).iter().all(|m| !m.crosses && m.first == [0, 1]));
    assert!(meeting(rectangle([1.0, 0.2], [2.0, 0.8])).contains(&SegmentMeeting {
        first: [0, 1],
        second: [1, 3],
        crosses: false
    }));
    // a spike that runs back on itself
    let spike = points(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert!(!crossings(&[spike]).is_empty());
    // a figure of eight
    let eight = points(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(crossings(&[eight]), [SegmentMeeting { first: [0, 0], second: [0, 2], crosses: true }]);
}

proptest! {
    #[test]
    fn crossings_are_those_of_integers(corners in prop::collection::vec((0i64..9, 0i64..9), 4..14)) {
        let contour: Vec<DVec2> = corners.iter().map(|(x, y)| DVec2::new(*x as f64, *y as f64)).collect();
        let n = corners.len();
        let turn = |a: (i64, i64), b: (i64, i64), c: (i64, i64)| {
            ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)).signum()
        };
        let mut expected = Vec::new();
        for i in 0..n {
            for j in i + 2..n {
                if i == 0 && j == n - 1 {
                    continue;
                }
                let (p, q, r, s) = (corners[i], corners[(i + 1) % n], corners[j], corners[(j + 1) % n]);
                if turn(p, q, r) * turn(p, q, s) < 0 && turn(r, s, p) * turn(r, s, q) < 0 {
                    expected.push([i as u32, j as u32]);
                }
            }
        }
        let found: Vec<[u32; 2]> =
            crossings(&[contour]).iter().filter(|m| m.crosses).map(|m| [m.first[1], m.second[1]]).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn the_axis_of_a_rectangle_is_a_line() {
    let axis = medial_axis(&[rectangle([0.0, 0.0], [4.0, 1.0])], 1.1, 0.05).unwrap();
    assert_eq!(axis.lines.len(), 1);
    let xs: Vec<f64> = axis.lines[0].iter().map(|v| axis.places[*v as usize].0.x).collect();
    let (lo, hi) = (xs.iter().copied().fold(9.0, f64::min), xs.iter().copied().fold(0.0, f64::max));
    assert!(lo < 1.0 && hi > 3.0, "{lo} {hi}");
    for v in &axis.lines[0] {
        let (p, r) = axis.places[*v as usize];
        assert!((p.y - 0.5).abs() < 0.05 && (r - 0.5).abs() < 0.03, "{p} {r}");
    }
    // a ring has a closed line between its contours
    let ring = [rectangle([0.0, 0.0], [3.0, 3.0]), rectangle([1.0, 1.0], [2.0, 2.0])];
    let axis = medial_axis(&ring, 1.1, 0.1).unwrap();
    assert!(axis.lines.iter().any(|l| l.len() > 20 && l[0] == l[l.len() - 1]), "{} lines", axis.lines.len());
}

#[test]
fn what_is_wide_stays_as_it_is() {
    let contours = vec![rectangle([0.0, 0.0], [3.0, 3.0]), rectangle([1.0, 1.0], [2.0, 2.0])];
    let t = trim(&contours, 0.5).unwrap();
    assert_eq!((&t.contours, t.merges.len(), t.vanished.len()), (&contours, 0, 0));
}

#[test]
fn a_tail_is_cut_off() {
    let square =
        points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [2.0, 0.5], [2.0, 0.52], [1.0, 0.52], [1.0, 1.0], [0.0, 1.0]]);
    let t = trim(&[square], 0.05).unwrap();
    assert_eq!((t.contours.len(), t.merges.len()), (1, 1));
    assert_abs_diff_eq!(area(&t.contours[0]), 1.0, epsilon = 0.02);
    assert!(t.contours[0].iter().all(|p| p.x < 1.06));
    assert_abs_diff_eq!(t.merges[0].at.y, 0.51, epsilon = 1e-3);
}

#[test]
fn what_a_neck_joins_falls_apart() {
    let dumbbell = points(&[
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.5],
        [2.0, 0.5],
        [2.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [2.0, 1.0],
        [2.0, 0.52],
        [1.0, 0.52],
        [1.0, 1.0],
        [0.0, 1.0],
    ]);
    let t = trim(&[dumbbell], 0.05).unwrap();
    assert_eq!((t.contours.len(), t.merges.len()), (2, 2));
    assert!(t.contours.iter().all(|c| (area(c) - 1.0).abs() < 0.03));
}

#[test]
fn a_narrow_place_between_contours_joins_them() {
    // a hole close to one side of a plate
    for turned in 0..4 {
        let mut contours = vec![rectangle([0.0, 0.0], [3.0, 3.0]), rectangle([1.0, 0.02], [2.0, 1.0])];
        (0..2).filter(|c| turned >> c & 1 > 0).for_each(|c| contours[c].reverse());
        let t = trim(&contours, 0.05).unwrap();
        assert_eq!((t.contours.len(), t.merges.len()), (1, 2));
        assert_abs_diff_eq!(area(&t.contours[0]), 9.0 - 1.0, epsilon = 0.05);
        assert_eq!(crossings(&t.contours), []);
        assert_eq!(t.turned, (0..2).filter(|c| turned >> c & 1 == (1 + c) % 2).collect::<Vec<u32>>());
        // both places are between the hole and the side below it
        for m in &t.merges {
            for s in [m.entry, m.exit] {
                let contour = &contours[s.contour as usize];
                let (n, i) = (contour.len(), s.point as usize);
                let next = if t.turned.contains(&s.contour) { (i + n - 1) % n } else { (i + 1) % n };
                let p = contour[i].lerp(contour[next], s.share);
                assert!(p.distance(m.at) < 0.05, "{p} {}", m.at);
            }
        }
    }
}

#[test]
fn nothing_is_left_of_a_splinter() {
    let t = trim(&[rectangle([0.0, 0.0], [2.0, 0.01])], 0.05).unwrap();
    assert_eq!((t.contours.len(), t.vanished), (0, vec![0]));
}

#[test]
fn contours_that_bound_nothing_are_refused() {
    let eight = points(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    assert!(matches!(trim(&[eight], 0.1), Err(Refusal::Meets(_))));
    assert_eq!(trim(&[rectangle([0.0, 0.0], [1.0, 1.0])], 0.0), Err(Refusal::Size));
    assert_eq!(trim(&[rectangle([0.0, 0.0], [1e9, 1e9])], f64::NAN), Err(Refusal::Size));
    assert_eq!(trim(&[], 1.0).map(|t| t.contours.len()), Ok(0));
    assert!(trim(&[points(&[[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]])], 0.1).is_err());
    assert!(trim(&[points(&[[0.0, 0.0], [1.0, 0.0]])], 0.1).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A square with a tail somewhere, turned anyhow: cut off exactly when it is narrow.
    #[test]
    fn tails_are_cut_off_when_they_are_narrow(at in 0.2f64..0.7, w in 0.01f64..0.1, angle in 0.0f64..6.3, long in 0.3f64..2.0) {
        let width = 0.05;
        prop_assume!((w - width).abs() > 0.02);
        let turn = DVec2::from_angle(angle);
        let contour: Vec<DVec2> = points(&[
            [0.0, 0.0], [1.0, 0.0], [1.0, at], [1.0 + long, at], [1.0 + long, at + w], [1.0, at + w], [1.0, 1.0], [0.0, 1.0],
        ]).iter().map(|p| turn.rotate(*p)).collect();
        let t = trim(std::slice::from_ref(&contour), width).unwrap();
        prop_assert_eq!(t.contours.len(), 1);
        let left = area(&t.contours[0]);
        if w > width {
            prop_assert_eq!(&t.contours[0], &contour);
        } else {
            prop_assert!((left - 1.0).abs() < 0.02, "{} of {}", left, area(&contour));
            // what was away from the tail has not moved
            prop_assert!([0, 1, 6, 7].iter().all(|i| t.contours[0].contains(&contour[*i])));
        }
    }
}
