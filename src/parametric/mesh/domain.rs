//! The domain of a face: its contours, cut open where they wind around a periodic direction or where there are none.
//!
//! A cut is a line of nodes inside the face that is walked twice, a period apart: both copies are the same nodes, so that
//! the face is closed again in space.

use glam::{DVec2, DVec3};

use super::loops::{Contour, Corner, POLE_COPIES};
use super::rings::TipRing;
use crate::numeric::NONE;
use crate::numeric::predicates::orient2d;
use crate::parametric::chart::Chart;

/// Pairs of corners that are tried as ends of a cut.
const MOST_CUTS: usize = 400;
/// Places that are tried for a cut of a surface that is closed by itself.
const PLACES: usize = 32;

/// A face's domain as polygons that do not wind, and the nodes the cuts brought.
#[derive(Debug, Clone, Default)]
pub(super) struct Domain {
    pub(super) polygons: Vec<Vec<Corner>>,
    /// New nodes; the first has the number of nodes there were.
    pub(super) nodes: Vec<DVec3>,
}

/// A domain whose axes are turned so that the periodic one is x.
#[derive(Clone, Copy)]
struct TurnedDomain<'a> {
    /// The one that was periodic.
    axis: usize,
    period: f64,
    holes: &'a [Contour],
    /// Turns a direction back.
    back: &'a dyn Fn(DVec2) -> DVec2,
}

pub(super) struct Cutter<'a> {
    pub(super) chart: &'a Chart,
    /// Spacing of nodes on cuts.
    pub(super) size: f64,
    /// How many nodes there are already.
    pub(super) first: u32,
    /// Cuts have no nodes between these and their tips.
    pub(super) rings: &'a [TipRing],
    pub(super) made: Vec<DVec3>,
    /// Gives the node of a pole, which may be a vertex.
    pub(super) pole_node: &'a dyn Fn(DVec3) -> Option<u32>,
}

/// Twice the signed area of a polygon.
pub(super) fn area(p: &[Corner]) -> f64 {
    (0..p.len()).map(|i| p[i].uv.perp_dot(p[(i + 1) % p.len()].uv)).sum()
}

/// Whether a point is inside a polygon, by crossings.
fn inside(p: &[Corner], q: DVec2) -> bool {
    let mut odd = false;
    for i in 0..p.len() {
        let (a, b) = (p[i].uv, p[(i + 1) % p.len()].uv);
        if (a.y > q.y) != (b.y > q.y) {
            let s = orient2d(a, b, q);
            odd ^= (s > 0.0) == (b.y > a.y);
        }
    }
    odd
}

fn crosses(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let (s, t) = (orient2d(a, b, c), orient2d(a, b, d));
    let (u, v) = (orient2d(c, d, a), orient2d(c, d, b));
    s * t <= 0.0 && u * v <= 0.0 && !(s == 0.0 && t == 0.0 && apart(a, b, c, d))
}

/// Whether two segments of one line have no point in common.
fn apart(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any()
}

impl Cutter<'_> {
    fn node(&mut self, p: DVec3) -> u32 {
        self.made.push(p);
        self.first + self.made.len() as u32 - 1
    }

    fn pole(&mut self, p: DVec3) -> u32 {
        match (self.pole_node)(p) {
            Some(v) => v,
            None => self.node(p),
        }
    }

    /// Makes polygons of contours. `Err` says what is wrong with them.
    pub(super) fn domain(mut self, contours: Vec<Contour>) -> Result<Domain, String> {
        let (winding, mut plain): (Vec<Contour>, Vec<Contour>) =
            contours.into_iter().filter(|c| !c.corners.is_empty()).partition(|c| c.winding != [0, 0]);
        let mut polygons = Vec::new();
        if !winding.is_empty() {
            polygons.push(self.open(winding, &mut plain)?);
        } else if !plain.iter().any(|c| area(&c.corners) > 0.0) {
            match (self.whole(&plain), plain.len()) {
                (Ok(p), _) => polygons.push(p),
                // The only contour runs the wrong way round.
                (Err(_), 1) => polygons.push(turned(&plain.remove(0).corners)),
                (Err(e), _) => return Err(e),
            }
        } else if self.chart.periods != [None, None] {
            // Outer contours come first: the others are brought into them.
            plain.sort_by(|a, b| area(&b.corners).total_cmp(&area(&a.corners)));
            polygons.push(plain.remove(0).corners);
        }
        for c in plain {
            let moved = if let Some(outer) = polygons.first() { self.brought(c.corners, outer)? } else { c.corners };
            polygons.push(moved);
        }
        Ok(Domain { polygons, nodes: self.made })
    }

    /// A contour moved by whole periods so that it starts inside `outer`.
    fn brought(&self, corners: Vec<Corner>, outer: &[Corner]) -> Result<Vec<Corner>, String> {
        let none = corners.iter().map(|c| (c.uv, inside(outer, c.uv))).filter(|x| x.1).count() * 2;
        let shifts = |k: usize| match self.chart.periods[k] {
            Some(p) => (-3..=3).map(|i| f64::from(i) * p).collect(),
            None => vec![0.0],
        };
        let mut best = (none, DVec2::ZERO);
        for a in shifts(0) {
            for b in shifts(1) {
                let by = DVec2::new(a, b);
                let count = 2 * corners.iter().filter(|c| inside(outer, c.uv + by)).count();
                // Staying is worth a little, for contours that touch the outer one.
                if count > best.0 {
                    best = (count, by);
                }
            }
        }
        if self.chart.periods != [None, None] && best.0 == 0 {
            return Err("a contour lies outside the others".into());
        }
        Ok(corners.into_iter().map(|c| Corner { uv: c.uv + best.1, ..c }).collect())
    }

    /// One polygon from contours that wind around a periodic direction: two of them, or one and a pole.
    fn open(&mut self, mut winding: Vec<Contour>, holes: &mut [Contour]) -> Result<Vec<Corner>, String> {
        let axis = usize::from(winding[0].winding[0] == 0);
        if winding.iter().any(|c| c.winding[1 - axis] != 0 || c.winding[axis].abs() != 1) {
            return Err("a contour winds around the surface more than once, or in two directions".into());
        }
        let period = self.chart.periods[axis].ok_or("a contour winds around a direction that is not periodic")?;
        // Axes turned so that the periodic one is x and the domain keeps its orientation.
        let turn = |v: DVec2| if axis == 0 { v } else { DVec2::new(v.y, -v.x) };
        let back = |v: DVec2| if axis == 0 { v } else { DVec2::new(-v.y, v.x) };
        for c in winding.iter_mut().chain(holes.iter_mut()) {
            c.corners.iter_mut().for_each(|k| k.uv = turn(k.uv));
        }
        let way = |c: &Contour| if axis == 0 { c.winding[0] } else { c.winding[1] };
        let (lower, upper): (Vec<Contour>, Vec<Contour>) = winding.into_iter().partition(|c| way(c) > 0);
        let across = self.chart.periods[1 - axis];
        let turned = TurnedDomain { axis, period, holes, back: &back };
        let polygon = match (&lower[..], &upper[..]) {
            ([a], [b]) => self.bridge(&a.corners, &b.corners, across, &turned),
            ([a], []) => self.up_to_pole(&a.corners, 1.0, &turned),
            ([], [b]) => self.up_to_pole(&b.corners, -1.0, &turned),
            _ => Err(format!("{} contours wind around the surface", lower.len() + upper.len())),
        };
        for c in holes {
            c.corners.iter_mut().for_each(|k| k.uv = back(k.uv));
        }
        let mut polygon = polygon?;
        polygon.iter_mut().for_each(|k| k.uv = back(k.uv));
        Ok(polygon)
    }

    /// Nodes along a straight cut of the domain, without its ends; `back` leads to the surface's own axes.
    fn cut(&mut self, a: DVec2, b: DVec2, back: &dyn Fn(DVec2) -> DVec2) -> Vec<(DVec2, u32)> {
        /// Chords the cut is measured by: its length decides how many nodes it gets, no more.
        const SAMPLES: usize = 32;
        let at = |t: f64| a.lerp(b, t);
        let points: Vec<DVec3> = (0..=SAMPLES).map(|k| self.chart.at(back(at(k as f64 / SAMPLES as f64)))).collect();
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let parts = ((length / self.size).round() as usize).clamp(1, 100_000);
        (1..parts)
            .map(|k| {
                let uv = at(k as f64 / parts as f64);
                let p = self.chart.at(back(uv));
                (uv, self.node(p))
            })
            .collect()
    }

    /// A [cut](Self::cut) that ends at poles: from its start, its end, or both.
    fn cut_to_poles(&mut self, a: DVec2, b: DVec2, back: &dyn Fn(DVec2) -> DVec2) -> Vec<(DVec2, u32)> {
        // Where the cut passes a ring whose tip it ends in.
        let pass = |tip: DVec2, from: DVec2| {
            let (p, q) = (back(tip), back(from));
            let ring = self.rings.iter().find(|r| r.pole.value == p[r.pole.axis])?;
            let k = ring.pole.axis;
            let share = (ring.at - p[k]) / (q[k] - p[k]);
            (share > 0.0 && share < 1.0).then(|| tip.lerp(from, share))
        };
        let (first, last) = (pass(a, b), pass(b, a));
        let (from, to) = (first.unwrap_or(a), last.unwrap_or(b));
        let one = |this: &mut Self, at: Option<DVec2>| at.map(|uv| (uv, this.node(this.chart.at(back(uv)))));
        let mut out: Vec<(DVec2, u32)> = one(self, first).into_iter().collect();
        out.extend(self.cut(from, to, back));
        out.extend(one(self, last));
        out
    }

    fn bridge(
        &mut self,
        a: &[Corner],
        b: &[Corner],
        across: Option<f64>,
        turned: &TurnedDomain<'_>,
    ) -> Result<Vec<Corner>, String> {
        let TurnedDomain { period, holes, back, .. } = *turned;
        let mean = |c: &[Corner]| c.iter().map(|k| k.uv.y).sum::<f64>() / c.len() as f64;
        let lift = across.map_or(0.0, |p| (mean(b) - mean(a)).rem_euclid(p) - (mean(b) - mean(a)));
        let b: Vec<Corner> = b.iter().map(|k| Corner { uv: k.uv + DVec2::new(0.0, lift), ..*k }).collect();
        let metric = self.metric(a[0].uv, back);
        let mut pairs: Vec<(f64, usize, usize, f64)> = Vec::new();
        for (i, p) in a.iter().enumerate() {
            let near = b.iter().enumerate().map(|(j, q)| {
                let shift = ((p.uv.x - q.uv.x) / period).round() * period;
                (((p.uv - q.uv - DVec2::new(shift, 0.0)) * metric).length_squared(), i, j, shift)
            });
            pairs.extend(near.min_by(|x, y| x.0.total_cmp(&y.0)));
        }
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        for &(_, i, j, shift) in pairs.iter().take(MOST_CUTS) {
            let (p, q) = (a[i].uv, b[j].uv + DVec2::new(shift, 0.0));
            let all = [a, &b[..]].into_iter().chain(holes.iter().map(|h| &h.corners[..]));
            if a[i].node == b[j].node || self.hits(p, q, all, period, [a[i].node, b[j].node]) {
                continue;
            }
            let across = self.cut(p, q, back);
            let right = DVec2::new(period, 0.0);
            let mut out = wound(a, i, period, 1.0, DVec2::ZERO);
            out.extend(across.iter().map(|&(uv, node)| Corner { uv: uv + right, node, edge: NONE }));
            out.extend(wound(&b, j, period, -1.0, right + DVec2::new(shift, 0.0)));
            out.extend(across.iter().rev().map(|&(uv, node)| Corner { uv, node, edge: NONE }));
            return Ok(out);
        }
        Err("no cut between the contours was found".into())
    }

    /// Lengths in space per unit of the (turned) parameters, so that distances in the domain mean something.
    fn metric(&self, at: DVec2, back: &dyn Fn(DVec2) -> DVec2) -> DVec2 {
        let [_, su, sv, ..] = self.chart.jet(back(at));
        let d = |x: DVec2| {
            let k = back(x);
            (k.x * su + k.y * sv).length().max(f64::MIN_POSITIVE)
        };
        DVec2::new(d(DVec2::X), d(DVec2::Y))
    }

    /// Whether a cut from `p` to `q` meets any contour but in its ends.
    fn hits<'c>(
        &self,
        p: DVec2,
        q: DVec2,
        all: impl Iterator<Item = &'c [Corner]>,
        period: f64,
        ends: [u32; 2],
    ) -> bool {
        for c in all {
            for k in 0..c.len() {
                let (s, t) = (&c[k], &c[(k + 1) % c.len()]);
                // The last part of a contour that winds leads a period on.
                let turn = ((t.uv.x - s.uv.x) / period).round() * period;
                let to = t.uv - DVec2::new(if k + 1 == c.len() { turn } else { 0.0 }, 0.0);
                for i in -2..=2 {
                    let by = DVec2::new(f64::from(i) * period, 0.0);
                    let (x, y) = (s.uv + by, to + by);
                    let touches =
                        (ends.contains(&s.node) && (x == p || x == q)) || (ends.contains(&t.node) && near(y, p, q));
                    if !touches && crosses(p, q, x, y) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// A polygon from one contour and the pole above (`side` 1) or below (-1) it.
    fn up_to_pole(&mut self, a: &[Corner], side: f64, turned: &TurnedDomain<'_>) -> Result<Vec<Corner>, String> {
        let TurnedDomain { axis, period, holes, back } = *turned;
        // In the turned domain the other parameter's sign is turned too.
        let sign = if axis == 0 { 1.0 } else { -1.0 };
        let heights = self.chart.poles.iter().filter(|p| p.axis == 1 - axis).map(|p| (sign * p.value, p.point));
        let beyond = |h: f64| a.iter().all(|c| side * (h - c.uv.y) > 0.0);
        let Some((height, point)) =
            heights.filter(|h| beyond(h.0)).min_by(|x, y| (side * x.0).total_cmp(&(side * y.0)))
        else {
            return Err("a contour winds around the surface alone, and there is no pole".into());
        };
        let mut order: Vec<usize> = (0..a.len()).collect();
        order.sort_by(|&i, &j| (side * a[j].uv.y).total_cmp(&(side * a[i].uv.y)).then(i.cmp(&j)));
        for i in order {
            let (p, q) = (a[i].uv, DVec2::new(a[i].uv.x, height));
            let all = [a].into_iter().chain(holes.iter().map(|h| &h.corners[..]));
            if self.hits(p, q, all, period, [a[i].node, a[i].node]) {
                continue;
            }
            let up = self.cut_to_poles(p, q, back);
            let node = self.pole(point);
            let by = DVec2::new(side * period, 0.0);
            let mut out = wound(a, i, period, side, DVec2::ZERO);
            out.extend(up.iter().map(|&(uv, node)| Corner { uv: uv + by, node, edge: NONE }));
            for k in 0..=POLE_COPIES {
                let uv = q + by * (1.0 - k as f64 / POLE_COPIES as f64);
                out.push(Corner { uv, node, edge: NONE });
            }
            out.extend(up.iter().rev().map(|&(uv, node)| Corner { uv, node, edge: NONE }));
            return Ok(out);
        }
        Err("no cut to the pole was found".into())
    }

    /// The whole of a surface that is closed by itself, but for holes.
    fn whole(&mut self, holes: &[Contour]) -> Result<Vec<Corner>, String> {
        let [pu, pv] = self.chart.periods;
        match (pu, pv) {
            (Some(p), Some(q)) => self.torus(holes, p, q),
            (Some(p), None) => self.globe(holes, 0, p),
            (None, Some(p)) => self.globe(holes, 1, p),
            (None, None) => Err("the face has no outer contour".into()),
        }
    }

    /// A place along an axis where a line across meets no hole.
    fn free_place(&self, holes: &[Contour], axis: usize, period: f64) -> Result<f64, String> {
        let start = self.chart.bounds[axis][0];
        let turn = |v: DVec2| if axis == 0 { v } else { DVec2::new(v.y, v.x) };
        let free = |x: f64| {
            holes.iter().all(|h| {
                let n = h.corners.len();
                (0..n).all(|k| {
                    let (a, b) = (turn(h.corners[k].uv).x, turn(h.corners[(k + 1) % n].uv).x);
                    (-3..=3).all(|i| {
                        let x = x + f64::from(i) * period;
                        !(a.min(b)..=a.max(b)).contains(&x)
                    })
                })
            })
        };
        // The seam itself first, then places in between.
        (0..PLACES)
            .map(|k| start + period * ((k * 13) % PLACES) as f64 / PLACES as f64)
            .find(|x| free(*x))
            .ok_or_else(|| "no cut between the holes was found".into())
    }

    fn globe(&mut self, holes: &[Contour], axis: usize, period: f64) -> Result<Vec<Corner>, String> {
        let mut poles: Vec<_> = self.chart.poles.iter().filter(|p| p.axis == 1 - axis).copied().collect();
        poles.sort_by(|a, b| a.value.total_cmp(&b.value));
        let [low, high] = poles[..] else { return Err("the face has no outer contour and no two poles".into()) };
        let x = self.free_place(holes, axis, period)?;
        let back = |v: DVec2| if axis == 0 { v } else { DVec2::new(v.y, v.x) };
        let (a, b) = (DVec2::new(x, low.value), DVec2::new(x, high.value));
        let up = self.cut_to_poles(a, b, &back);
        let (s, n) = (self.pole(low.point), self.pole(high.point));
        let right = DVec2::new(period, 0.0);
        let line = |from: DVec2, by: DVec2, node: u32| {
            (0..=POLE_COPIES).map(move |k| Corner { uv: from + by * k as f64 / POLE_COPIES as f64, node, edge: NONE })
        };
        let side = |by: DVec2| up.iter().map(move |&(uv, node)| Corner { uv: uv + by, node, edge: NONE });
        let mut out: Vec<Corner> = line(a, right, s).collect();
        out.extend(side(right));
        out.extend(line(b + right, -right, n));
        out.extend(side(DVec2::ZERO).rev());
        out.iter_mut().for_each(|c| c.uv = back(c.uv));
        // Exchanging the axes turns the contour round.
        if axis == 1 {
            out.reverse();
        }
        Ok(out)
    }

    fn torus(&mut self, holes: &[Contour], p: f64, q: f64) -> Result<Vec<Corner>, String> {
        let (x, y) = (self.free_place(holes, 0, p)?, self.free_place(holes, 1, q)?);
        let o = DVec2::new(x, y);
        let (right, up) = (DVec2::new(p, 0.0), DVec2::new(0.0, q));
        let same = |v: DVec2| v;
        let at = self.chart.at(o);
        let corner = self.node(at);
        let (row, column) = (self.cut(o, o + right, &same), self.cut(o, o + up, &same));
        if row.len() < 2 || column.len() < 2 {
            return Err("the size is too large for a torus".into());
        }
        let one = |uv: DVec2| Corner { uv, node: corner, edge: NONE };
        let line = |l: &[(DVec2, u32)], by: DVec2| -> Vec<Corner> {
            l.iter().map(|&(uv, node)| Corner { uv: uv + by, node, edge: NONE }).collect()
        };
        let mut out = vec![one(o)];
        out.extend(line(&row, DVec2::ZERO));
        out.push(one(o + right));
        out.extend(line(&column, right));
        out.push(one(o + right + up));
        out.extend(line(&row, up).into_iter().rev());
        out.push(one(o + up));
        out.extend(line(&column, DVec2::ZERO).into_iter().rev());
        Ok(out)
    }
}

/// A contour walked the other way.
fn turned(c: &[Corner]) -> Vec<Corner> {
    let n = c.len();
    (0..n).rev().map(|i| Corner { edge: c[(i + n - 1) % n].edge, ..c[i] }).collect()
}

fn near(y: DVec2, p: DVec2, q: DVec2) -> bool {
    let close = |r: DVec2| y.distance(r) <= 1e-9 * (1.0 + r.length());
    close(p) || close(q)
}

/// A winding contour from corner `i` once around to the same corner, which comes twice, moved by `by`.
fn wound(c: &[Corner], i: usize, period: f64, way: f64, by: DVec2) -> Vec<Corner> {
    let n = c.len();
    let mut out: Vec<Corner> = (0..n)
        .map(|k| {
            let j = (i + k) % n;
            let turn = if i + k >= n { way * period } else { 0.0 };
            Corner { uv: c[j].uv + by + DVec2::new(turn, 0.0), ..c[j] }
        })
        .collect();
    out.push(Corner { uv: c[i].uv + by + DVec2::new(way * period, 0.0), node: c[i].node, edge: NONE });
    out
}
