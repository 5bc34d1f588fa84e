//! Bends within a smooth face that are so sharp that triangles see an edge: the lines of its domain they run along.

use glam::{DVec2, DVec3};

use crate::numeric::COS_60;
use crate::parametric::chart::Chart;

/// Cosine of the angle between normals at neighbors of the net of samples beyond which a bend is looked for: 40 degrees.
const TURNED: f64 = 0.766;
/// Places that are looked at between them, again and again,
const PLACES: usize = 16;
/// so many times. Each leaves three of the sixteen parts: a 4000th of the way in the end, less than a bend is wide.
const ROUNDS: usize = 5;
/// A bend turns by 60 degrees and more on a way of this share of the length of the line across it;
const WAY: f64 = 1.0 / 1000.0;
/// on both sides the face goes on by this many times as much.
const BEYOND: f64 = 20.0;
/// Lines across a bend that are looked at, as shares of the domain.
const ACROSS: [f64; 3] = [0.5, 0.1, 0.9];

/// Values of a parameter at which a face has a bend all along the line of the other parameter, ascending.
pub(super) fn bends(chart: &Chart, axis: usize) -> Vec<f64> {
    let row = chart.net_row(axis);
    let mut out: Vec<f64> = Vec::new();
    for w in row.windows(2).filter(|w| w[0].1.dot(w[1].1) < TURNED && w[0].1 != DVec3::ZERO && w[1].1 != DVec3::ZERO) {
        let t = sharpest(chart, axis, [w[0].0, w[1].0]);
        if !ACROSS.iter().all(|share| is_bend(chart, axis, t, *share)) {
            continue;
        }
        // One bend may be seen on both sides of a sample.
        match out.last_mut() {
            Some(last) if is_one(chart, axis, [*last, t]) => *last = 0.5 * (*last + t),
            _ => out.push(t),
        }
    }
    out
}

fn at(chart: &Chart, axis: usize, t: f64, share: f64) -> DVec2 {
    let [a, b] = chart.bounds[1 - axis];
    let across = a + (b - a) * share;
    if axis == 0 { DVec2::new(t, across) } else { DVec2::new(across, t) }
}

/// Where the normal turns most for its way between two values.
fn sharpest(chart: &Chart, axis: usize, [mut a, mut b]: [f64; 2]) -> f64 {
    for _ in 0..ROUNDS {
        let value = |k: usize| a + (b - a) * k as f64 / PLACES as f64;
        let look = |k: usize| {
            let uv = at(chart, axis, value(k), ACROSS[0]);
            (chart.surface.at(uv), chart.surface.normal(uv).unwrap_or(DVec3::ZERO))
        };
        let looks: Vec<(DVec3, DVec3)> = (0..=PLACES).map(look).collect();
        let rate = |k: usize| {
            let ((p, m), (q, n)) = (looks[k], looks[k + 1]);
            m.cross(n).length().atan2(m.dot(n)) / p.distance(q).max(f64::MIN_POSITIVE)
        };
        let k = (0..PLACES).max_by(|x, y| rate(*x).total_cmp(&rate(*y))).unwrap_or(0);
        (a, b) = (value(k.saturating_sub(1)), value((k + 2).min(PLACES)));
    }
    0.5 * (a + b)
}

/// The length of a line across between two values.
fn length(chart: &Chart, axis: usize, [from, to]: [f64; 2], share: f64) -> f64 {
    /// Chords the line is measured by.
    const STEPS: usize = 64;
    let place = |k: usize| chart.surface.at(at(chart, axis, from + (to - from) * k as f64 / STEPS as f64, share));
    (0..STEPS).map(|k| place(k).distance(place(k + 1))).sum()
}

/// Whether two values are those of one bend: not farther from each other than it is wide.
fn is_one(chart: &Chart, axis: usize, pair: [f64; 2]) -> bool {
    length(chart, axis, pair, ACROSS[0]) < WAY * length(chart, axis, chart.bounds[axis], ACROSS[0])
}

/// Whether a face turns sharply at a value, on one of the lines across, and goes on at both sides.
fn is_bend(chart: &Chart, axis: usize, t: f64, share: f64) -> bool {
    let [a, b] = chart.bounds[axis];
    let point = |t: f64| chart.surface.at(at(chart, axis, t, share));
    let sides = [[a, t], [t, b]].map(|part| length(chart, axis, part, share));
    let way = WAY * (sides[0] + sides[1]);
    let goes_on = match chart.periods[axis] {
        Some(_) => true,
        None => sides.iter().all(|s| *s > BEYOND * way),
    };
    // Half the way before and half behind.
    let p = point(t);
    let end = |to: f64| {
        let (mut near, mut far) = (t, to);
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            if point(middle).distance(p) < 0.5 * way { near = middle } else { far = middle }
        }
        chart.surface.normal(at(chart, axis, near, share))
    };
    goes_on && matches!((end(a), end(b)), (Some(m), Some(n)) if m.dot(n) < COS_60)
}
