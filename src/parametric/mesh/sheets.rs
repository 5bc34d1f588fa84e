//! Faces with creases inside, or bends as sharp as these, or whose two sides run together at one: they are meshed in sheets.
//!
//! A sheet is the part of a face between two lines of its domain. It is a piece of its own with a chart of its own, so what
//! lies near is looked for on the right side of a sharp trailing edge.

use glam::DVec2;

use super::bends::bends;
use crate::numeric::{COS_20, FOUND_TWICE};
use crate::parametric::chart::Chart;
use crate::parametric::surface::Surface;

/// Normals beside a line are taken this share of the parameter's range away from it.
const BESIDE: f64 = 1e-6;
/// Lines across which normals are looked at.
const LOOKS: usize = 9;
/// Places that are looked at for the one farthest from a crease.
const PLACES: usize = 64;
/// A sheet's chart goes on beyond a line that is no crease by this share of its range.
const BEYOND: f64 = 0.05;
/// A chart ends this share of its range before a crease, so that it knows one side only.
const INSET: f64 = 1e-9;

/// The lines that divide a face's domain.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sheets {
    /// The parameter that is constant on the lines.
    pub(super) axis: usize,
    /// Its values, ascending, and whether there is a crease. Where the parameter is periodic the first one is where its
    /// range starts.
    pub(super) lines: Vec<(f64, bool)>,
    /// The range the first and the last sheet end at.
    bounds: [f64; 2],
}

impl Sheets {
    /// How a face shall be divided; `None` where its surface has no crease, and no bend that looks like one.
    pub(super) fn of(chart: &Chart) -> Option<Self> {
        (0..2).filter_map(|axis| Self::along(chart, axis)).max_by_key(|s| s.lines.iter().filter(|l| l.1).count())
    }

    fn along(chart: &Chart, axis: usize) -> Option<Self> {
        if !chart.is_sampled() {
            return None;
        }
        let bounds @ [a, b] = chart.bounds[axis];
        let period = chart.periods[axis];
        let mut lines: Vec<(f64, bool)> = breaks(&chart.surface, axis, bounds)
            .into_iter()
            .filter(|t| *t > a && *t < b && creased(chart, axis, [*t, *t]))
            .map(|t| (t, true))
            .collect();
        let mut seam = period.is_some() && creased(chart, axis, [b, a]);
        for t in bends(chart, axis) {
            let near = |x: f64| (t - x).abs() < FOUND_TWICE * (b - a);
            if period.is_some() && (near(a) || near(b)) {
                seam = true;
            } else if !lines.iter().any(|l| near(l.0)) {
                lines.push((t, true));
            }
        }
        lines.sort_by(|x, y| x.0.total_cmp(&y.0));
        if lines.is_empty() && !seam {
            return None;
        }
        if period.is_some() {
            lines.insert(0, (a, seam));
        }
        if seam && lines.len() == 1 {
            lines.push((farthest(chart, axis, bounds), false));
        }
        Some(Self { axis, lines, bounds })
    }

    /// How many sheets there are.
    pub(super) fn count(&self) -> usize {
        // Without a line at the start of the range there is a sheet before the first one.
        self.lines.len() + usize::from(self.lines[0].0 > self.bounds[0])
    }

    /// The sheet of parameters.
    pub(super) fn sheet(&self, chart: &Chart, uv: DVec2) -> usize {
        let t = chart.wrapped(uv)[self.axis];
        let before = self.lines.iter().filter(|l| l.0 <= t).count();
        if self.lines[0].0 > self.bounds[0] { before } else { before.saturating_sub(1) }
    }

    /// A chart of one sheet.
    pub(super) fn chart(&self, chart: &Chart, sheet: usize) -> Chart {
        let offset = usize::from(self.lines[0].0 > self.bounds[0]);
        let start = (sheet + 1).checked_sub(1 + offset).map(|i| self.lines[i]);
        let end = self.lines.get(sheet + 1 - offset).copied();
        let [a, b] = [start.map_or(self.bounds[0], |l| l.0), end.map_or(self.bounds[1], |l| l.0)];
        let range = b - a;
        // At the ends of the whole range there is nothing beyond, or the seam.
        let beyond = |line: Option<(f64, bool)>, at: f64| match line {
            Some((_, false)) if at > self.bounds[0] => BEYOND * range,
            _ => -INSET * range,
        };
        let part = [a - beyond(start, a), b + beyond(end, b)];
        chart.part(self.axis, [part[0].max(self.bounds[0]), part[1].min(self.bounds[1])])
    }
}

/// Values at which a surface may be less smooth.
fn breaks(surface: &Surface, axis: usize, range: [f64; 2]) -> Vec<f64> {
    match (surface, axis) {
        (Surface::Nurbs(n), 0) => n.u.breaks(),
        (Surface::Nurbs(n), _) => n.v.breaks(),
        (Surface::Extrusion { curve, .. }, 0) | (Surface::Revolution { curve, .. }, 1) => curve.pieces(range),
        _ => Vec::new(),
    }
}

fn line(chart: &Chart, axis: usize, k: usize, of: usize) -> impl Fn(f64) -> DVec2 {
    let [a, b] = chart.bounds[1 - axis];
    let across = a + (b - a) * (k as f64 + 0.5) / of as f64;
    move |t| if axis == 0 { DVec2::new(t, across) } else { DVec2::new(across, t) }
}

/// Whether normals just below one value and just above another differ, anywhere along the line.
fn creased(chart: &Chart, axis: usize, [below, above]: [f64; 2]) -> bool {
    let step = BESIDE * (chart.bounds[axis][1] - chart.bounds[axis][0]);
    (0..LOOKS).any(|k| {
        let at = line(chart, axis, k, LOOKS);
        let normal = |t: f64| chart.surface.normal(at(t));
        matches!((normal(below - step), normal(above + step)), (Some(m), Some(n)) if m.dot(n) < COS_20)
    })
}

/// The value whose line is farthest from that at the start of the range: the other end of a closed profile.
fn farthest(chart: &Chart, axis: usize, [a, b]: [f64; 2]) -> f64 {
    let at = line(chart, axis, 0, 1);
    let start = chart.surface.at(at(a));
    let value = |k: usize| a + (b - a) * k as f64 / PLACES as f64;
    let away = |t: f64| chart.surface.at(at(t)).distance_squared(start);
    (1..PLACES).map(value).max_by(|x, y| away(*x).total_cmp(&away(*y))).unwrap_or(0.5 * (a + b))
}
