//! Trimming of narrow parts.
//!
//! *References.* \[BOR20\], trimming of narrow regions of faces, in its seven steps; special points are mirrored for exits,
//! and contours whose special points do not pair are refused.

use glam::DVec2;

use super::axis::{Axis, ContourSample, axis_of, samples};
use super::crossings::{SegmentMeeting, crossings};
use crate::numeric::predicates::orient2d;
use crate::spatial::{Aabb, Bvh};

/// Samples lie this many times closer than what is narrow.
const PER_WIDTH: f64 = 4.0;

/// A place on a contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// The contour.
    pub contour: u32,
    /// The point that comes before it, or is it, going along with the region to the left.
    pub point: u32,
    /// How much of the way from there to the next point (that way) it is.
    pub share: f64,
}

/// Two points of contours that became one, where a narrow part was cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merge {
    /// Where the contour comes into the narrow part.
    pub entry: Spot,
    /// Where a contour leaves it.
    pub exit: Spot,
    /// Where both are now: in the middle between their feet on the medial axis.
    pub at: DVec2,
}

/// Contours without what was narrow.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trimmed {
    /// What is left, closed, the region to the left: points of the contours in their order, and those of the merges. Where
    /// nothing was narrow, the contours as they came.
    pub contours: Vec<Vec<DVec2>>,
    /// Where narrow parts were cut off; none where nothing was narrow.
    pub merges: Vec<Merge>,
    /// Contours of which nothing is left.
    pub vanished: Vec<u32>,
    /// The contours that run with the region to their right, ascending: what was narrow of them lies between an entry and the
    /// exit before it, not the one after it.
    pub turned: Vec<u32>,
}

/// Why contours were not trimmed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub enum Refusal {
    /// Contours meet: they bound no region, or one that is pinched.
    Meets(SegmentMeeting),
    /// The place where a contour comes into (or leaves) a narrow part has no partner across the axis.
    Unpaired { at: DVec2, entry: bool },
    /// A width that is not positive, a contour of fewer than three points, coordinates that are not finite, or more than two
    /// million samples.
    Size,
}

/// Cuts off what is narrower than `width` of the region the contours bound.
///
/// Points away from narrow parts stay. Where a part widens again behind a narrow place, both stay and become contours of
/// their own.
///
/// # Errors
/// A [`Refusal`]; then the contours are to be used as they are.
pub fn trim(contours: &[Vec<DVec2>], width: f64) -> Result<Trimmed, Refusal> {
    let good = |c: &Vec<DVec2>| c.len() > 2 && c.iter().all(|p| p.is_finite());
    if !(width > 0.0 && width.is_finite() && contours.iter().all(good)) {
        return Err(Refusal::Size);
    }
    if let Some(m) = crossings(contours).first() {
        return Err(Refusal::Meets(*m));
    }
    let spacing = width / PER_WIDTH;
    let (turned, left) = to_left(contours);
    let rows = samples(&left, 2.0 * width, spacing).ok_or(Refusal::Size)?;
    // steps 1, 3 and 4
    let axis = axis_of(&rows, spacing).ok_or(Refusal::Size)?;
    let unchanged = Trimmed { contours: contours.to_vec(), ..Trimmed::default() };
    // step 2, for the contours at hand
    let on_axis = axis.lines.iter().flatten();
    if !on_axis.clone().any(|v| 2.0 * axis.places[*v as usize].1 < width) {
        return Ok(unchanged);
    }
    let feet = Feet::new(&axis);
    let found: Vec<Vec<Option<AxisFoot>>> =
        rows.iter().map(|row| row.iter().map(|s| feet.of(s.at, 0.5 * width)).collect()).collect();
    // steps 5 and 6
    let (mut entries, mut exits) = (Vec::new(), Vec::new());
    for (c, row) in found.iter().enumerate() {
        for i in 0..row.len() {
            let next = (i + 1) % row.len();
            match (&row[i], &row[next]) {
                (None, Some(foot)) => entries.push(SpecialPoint::new(c, i, foot, rows[c][next].at)),
                (Some(foot), None) => exits.push(SpecialPoint::new(c, next, foot, rows[c][i].at)),
                _ => {}
            }
        }
    }
    let partner = pair(&entries, &exits, &rows)?;
    let mut out = assemble(&rows, &found, &entries, &exits, &partner);
    for spot in out.merges.iter_mut().flat_map(|m| [&mut m.entry, &mut m.exit]) {
        if turned[spot.contour as usize] {
            spot.point = contours[spot.contour as usize].len() as u32 - 1 - spot.point;
        }
    }
    out.turned = (0..contours.len() as u32).filter(|c| turned[*c as usize]).collect();
    Ok(out)
}

/// The contours, each turned where needed so that the region lies to its left; and which were turned.
fn to_left(contours: &[Vec<DVec2>]) -> (Vec<bool>, Vec<Vec<DVec2>>) {
    let holds = |polygon: &[DVec2], p: DVec2| {
        let sides = (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
        let right_of = |(a, b): &(DVec2, DVec2)| {
            let (lo, hi) = if a.y < b.y { (*a, *b) } else { (*b, *a) };
            lo.y <= p.y && p.y < hi.y && orient2d(lo, hi, p) > 0.0
        };
        sides.filter(right_of).count() % 2 == 1
    };
    let turned: Vec<bool> = contours
        .iter()
        .enumerate()
        .map(|(c, contour)| {
            let around = contours.iter().enumerate().filter(|(d, other)| *d != c && holds(other, contour[0])).count();
            let o = contour[0];
            let area: f64 =
                (0..contour.len()).map(|i| (contour[i] - o).perp_dot(contour[(i + 1) % contour.len()] - o)).sum();
            (area > 0.0) != around.is_multiple_of(2)
        })
        .collect();
    let left = contours.iter().zip(&turned);
    let left = left.map(|(c, turn)| if *turn { c.iter().rev().copied().collect() } else { c.clone() }).collect();
    (turned, left)
}

/// The nearest place of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AxisFoot {
    line: u32,
    at: DVec2,
    along: DVec2,
}

struct Feet<'a> {
    axis: &'a Axis,
    segments: Vec<(u32, [u32; 2])>,
    bvh: Bvh,
}

impl<'a> Feet<'a> {
    fn new(axis: &'a Axis) -> Self {
        let of = |(l, line): (usize, &Vec<u32>)| line.windows(2).map(|w| (l as u32, [w[0], w[1]])).collect::<Vec<_>>();
        let segments: Vec<(u32, [u32; 2])> = axis.lines.iter().enumerate().flat_map(of).collect();
        let around = |(_, ends): &(u32, [u32; 2])| Aabb::around(ends.map(|v| axis.places[v as usize].0.extend(0.0)));
        let bvh = Bvh::new(segments.iter().map(around).collect());
        Self { axis, segments, bvh }
    }

    fn on(&self, segment: u32, p: DVec2) -> DVec2 {
        let [a, b] = self.segments[segment as usize].1.map(|v| self.axis.places[v as usize].0);
        let d = b - a;
        a + ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) * d
    }

    /// The foot of a point that is nearer than `limit`.
    fn of(&self, p: DVec2, limit: f64) -> Option<AxisFoot> {
        let (k, square) = self.bvh.nearest(p.extend(0.0), limit, |k| self.on(k, p).distance_squared(p))?;
        if square >= limit * limit {
            return None;
        }
        let (line, [a, b]) = self.segments[k as usize];
        let along = self.axis.places[b as usize].0 - self.axis.places[a as usize].0;
        Some(AxisFoot { line, at: self.on(k, p), along })
    }
}

/// A special point: the last one before a narrow part, or the first one after it.
#[derive(Debug, Clone, Copy)]
struct SpecialPoint {
    contour: usize,
    sample: usize,
    foot: AxisFoot,
    /// Whether its neighbor in the narrow part lies to the left of the line.
    left: bool,
}

impl SpecialPoint {
    fn new(contour: usize, sample: usize, foot: &AxisFoot, neighbor: DVec2) -> Self {
        let left = foot.along.perp_dot(neighbor - foot.at) > 0.0;
        Self { contour, sample, foot: *foot, left }
    }
}

/// For each entry its exit: across the same line, the nearest by their feet on it, nearest pairs first.
fn pair(entries: &[SpecialPoint], exits: &[SpecialPoint], rows: &[Vec<ContourSample>]) -> Result<Vec<usize>, Refusal> {
    let mut offers: Vec<(f64, usize, usize)> = Vec::new();
    for (i, e) in entries.iter().enumerate() {
        for (j, x) in exits.iter().enumerate() {
            if e.foot.line == x.foot.line && e.left != x.left {
                offers.push((e.foot.at.distance(x.foot.at), i, j));
            }
        }
    }
    offers.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut of_entry, mut taken) = (vec![usize::MAX; entries.len()], vec![false; exits.len()]);
    for (_, i, j) in offers {
        if of_entry[i] == usize::MAX && !taken[j] {
            (of_entry[i], taken[j]) = (j, true);
        }
    }
    let at = |s: &SpecialPoint| rows[s.contour][s.sample].at;
    if let Some(i) = of_entry.iter().position(|j| *j == usize::MAX) {
        return Err(Refusal::Unpaired { at: at(&entries[i]), entry: true });
    }
    if let Some(j) = taken.iter().position(|t| !t) {
        return Err(Refusal::Unpaired { at: at(&exits[j]), entry: false });
    }
    Ok(of_entry)
}

/// Step 7: what lies between an exit and the next entry stays, and goes on behind the entry at its partner.
fn assemble(
    rows: &[Vec<ContourSample>],
    found: &[Vec<Option<AxisFoot>>],
    entries: &[SpecialPoint],
    exits: &[SpecialPoint],
    partner: &[usize],
) -> Trimmed {
    let mut out = Trimmed::default();
    let spot = |s: &SpecialPoint| {
        let row = &rows[s.contour];
        let back = (0..row.len()).take_while(|k| row[(s.sample + row.len() - k) % row.len()].point.is_none()).count();
        let on = (1..=row.len()).take_while(|k| row[(s.sample + k) % row.len()].point.is_none()).count() + 1;
        let from = &row[(s.sample + row.len() - back) % row.len()];
        let [past, length] = [s.sample, s.sample + on].map(|i| row[i % row.len()].at.distance(from.at));
        let share = if back == 0 { 0.0 } else { (past / length).clamp(0.0, 1.0) };
        Spot { contour: s.contour as u32, point: from.point.unwrap_or(0), share }
    };
    let middle = |i: usize| 0.5 * (entries[i].foot.at + exits[partner[i]].foot.at);
    for (i, e) in entries.iter().enumerate() {
        out.merges.push(Merge { entry: spot(e), exit: spot(&exits[partner[i]]), at: middle(i) });
    }
    let entry_after = |x: &SpecialPoint| {
        let n = rows[x.contour].len();
        let steps = |e: &SpecialPoint| (e.sample + n - x.sample) % n;
        let own = entries.iter().enumerate().filter(|(_, e)| e.contour == x.contour);
        own.min_by_key(|(_, e)| steps(e)).map(|(i, e)| (i, steps(e)))
    };
    let mut done = vec![false; exits.len()];
    for start in 0..exits.len() {
        let (mut contour, mut j) = (Vec::new(), start);
        while !std::mem::replace(&mut done[j], true) {
            let x = &exits[j];
            let Some((i, steps)) = entry_after(x) else { break };
            let row = &rows[x.contour];
            // the special points themselves have moved to the middles
            contour.extend(
                (1..steps).map(|k| &row[(x.sample + k) % row.len()]).filter(|s| s.point.is_some()).map(|s| s.at),
            );
            contour.push(middle(i));
            j = partner[i];
        }
        if contour.len() > 2 {
            out.contours.push(contour);
        }
    }
    for (c, row) in found.iter().enumerate() {
        if row.iter().all(Option::is_some) {
            out.vanished.push(c as u32);
        } else if row.iter().all(Option::is_none) {
            out.contours.push(rows[c].iter().filter(|s| s.point.is_some()).map(|s| s.at).collect());
        }
    }
    out
}
