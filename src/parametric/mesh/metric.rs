//! Lengths in space per unit of a face's parameters.

use glam::DVec2;

use crate::parametric::chart::Chart;

/// Mean lengths in space per unit of u and of v.
pub(super) fn mean_metric(chart: &Chart, corners: &[DVec2]) -> DVec2 {
    let mut sum = DVec2::ZERO;
    let (lo, hi) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.min(*c), b.max(*c)));
    let inner = (1..6).flat_map(|i| (1..6).map(move |j| DVec2::new(f64::from(i), f64::from(j)) / 6.0));
    for uv in inner.map(|s| lo + s * (hi - lo)) {
        let [_, su, sv, ..] = chart.jet(uv);
        sum += DVec2::new(su.length(), sv.length());
    }
    let mean = sum / 25.0;
    let good = |x: f64| x.is_finite() && x > 0.0;
    if good(mean.x) && good(mean.y) { mean } else { 1.0 / (hi - lo).max(DVec2::splat(f64::MIN_POSITIVE)) }
}

/// How many times as long as elsewhere a unit of u may be, in units of v; borders count where the face goes on beyond them.
pub(super) fn distortion(chart: &Chart, [lo, hi]: [DVec2; 2]) -> f64 {
    /// Share of the range beside a border at which it is asked for: on the border itself, units may vanish.
    const BESIDE: f64 = 1e-3;
    let shares = [0, 1].map(|k| {
        let ends = chart.periods[k].map(|_| [BESIDE, 1.0 - BESIDE]).into_iter().flatten();
        (1..6).map(|i| f64::from(i) / 6.0).chain(ends).collect::<Vec<f64>>()
    });
    let ratio = |s: DVec2| {
        let [_, su, sv, ..] = chart.jet(lo + s * (hi - lo));
        su.length() / sv.length()
    };
    let all = shares[0].iter().flat_map(|u| shares[1].iter().map(move |v| ratio(DVec2::new(*u, *v))));
    let good = all.filter(|r| r.is_finite() && *r > 0.0);
    let (least, most) = good.fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
    most / least
}
