//! The true sharp edges and corners of a part, from its leaves: where two active leaves meet, and where three do.

use glam::DVec3;
use rayon::prelude::*;

use super::apex::apexes;
use super::leaf::Leaf;
use super::model::Implicit;
use super::newton::{Meeting, crossing, is_off, leaves_of, nearest, nearest_on_curve};
use super::octree::{BRICK, Bricks};
use super::tape::{Pruned, Scratch, Tape};
use crate::error::Result;
use crate::geometry::{FeatureSample, Features};
use crate::numeric::FOUND_TWICE;
use crate::run::Run;
use crate::spatial::Aabb;

/// Cells with more leaves than this are halved up to [`EXTRA_LEVELS`] times more before pairs and triples are tried.
const MANY_LEAVES: usize = 6;
/// An eighth of a cell's side has few of the leaves of a crowd: what three halvings do not part meets, or is too near to tell apart.
const EXTRA_LEVELS: usize = 3;
/// Cells in which curves bend are halved up to so many times: a circle of a tenth of the cell is followed.
const BENT_LEVELS: usize = 6;
/// Samples leave their edge by no more than this share of the size.
const BENT: f64 = 0.03;

/// So far beside an edge, as a share of the part's size, faces are asked for their normals: they may bend in the edge itself, as the cases of
/// a formula do that go over into each other there. It is far above rounding, and nothing is as small.
const BESIDE: f64 = 1e-7;
/// A face bends in an edge if its normals on both sides of it have a cosine below this.
const UNBENT: f64 = 0.999;

/// Finds the sharp edges and corners of a part by Newton's method in every cell of size `size` where two leaves may meet.
///
/// An edge is sampled once per cell, and once more for each point in which it meets another leaf there. A sample stands for the
/// piece of its tangent inside the cell, between such points. Where that leaves the edge by more than 3 % of `size` the cell is halved,
/// six times at most, so lengths are exact to second order in `size`. Not found: creases inside one formula (`abs`, `min`, `max`), edges shorter
/// than a small share of a cell.
pub fn features(model: &Implicit, size: f64, run: &Run) -> Result<Features> {
    features_within(model, size, BENT * size, run)
}

/// The same with samples that leave their edge by no more than a length.
pub(crate) fn features_within(model: &Implicit, size: f64, within: f64, run: &Run) -> Result<Features> {
    let bricks = Bricks::build(model, size, u64::MAX, run)?;
    let total = bricks.cells.len().max(1);
    let ground = Ground { model, bricks: &bricks, within };
    let per_brick: Result<Vec<Found>> = run.install(|| {
        bricks
            .cells
            .par_iter()
            .enumerate()
            .map_init(Scratch::default, |scratch, (i, cell)| {
                if i % 64 == 0 {
                    run.check()?;
                    run.progress("features", i as f64 / total as f64);
                }
                let lo = bricks.grid.node(cell.at.map(|b| b as usize * BRICK));
                let hi = bricks.grid.node(cell.at.map(|b| (b as usize + 1) * BRICK));
                let levels = BRICK.trailing_zeros() as usize;
                let mut seeker = Seeker { ground: &ground, scratch, found: Found::default() };
                seeker.search(&cell.tape, &Aabb::new(lo, hi), levels);
                Ok(seeker.found)
            })
            .collect()
    });
    let mut all = Features::default();
    for f in per_brick? {
        all.samples.extend(f.samples);
        all.corners.extend(f.corners);
    }
    all.corners.extend(apexes(model).into_iter().map(|a| a.1));
    let mut kept: Vec<DVec3> = Vec::new();
    all.corners.sort_by(|a, b| a.x.total_cmp(&b.x));
    for c in &all.corners {
        let same = |k: &&DVec3| k.distance(*c) < FOUND_TWICE * size;
        if kept.iter().rev().take_while(|k| c.x - k.x < FOUND_TWICE * size).find(same).is_none() {
            kept.push(*c);
        }
    }
    all.corners = kept;
    Ok(all)
}

/// Where features are looked for.
struct Ground<'a> {
    model: &'a Implicit,
    bricks: &'a Bricks,
    /// How far samples may leave their edge.
    within: f64,
}

#[derive(Default)]
struct Found {
    samples: Vec<FeatureSample>,
    corners: Vec<DVec3>,
}

/// Looks into cells, and gathers what is there.
struct Seeker<'a> {
    ground: &'a Ground<'a>,
    scratch: &'a mut Scratch,
    found: Found,
}

impl Seeker<'_> {
    fn search(&mut self, tape: &Tape, cell: &Aabb, levels: usize) {
        if tape.only_face().is_some() || leaves_of(tape).len() < 2 {
            return;
        }
        if levels > 0 {
            self.each_octant(tape, cell, &mut |this, tape, sub| this.search(tape, sub, levels - 1));
        } else {
            self.closer(tape, cell, BENT_LEVELS);
        }
    }

    /// Looks into a cell, or into parts of it where there are many leaves or curves turn.
    fn closer(&mut self, tape: &Tape, cell: &Aabb, levels: usize) {
        let leaves = leaves_of(tape);
        if leaves.len() < 2 {
            return;
        }
        let many = leaves.len() > MANY_LEAVES && levels > BENT_LEVELS - EXTRA_LEVELS;
        if !many {
            let may_halve = levels > 0 && leaves.len() <= MANY_LEAVES;
            if let Some(curves) = self.ground.curves(&leaves, cell, may_halve) {
                in_cell(self.ground, tape, &curves, cell, &mut self.found);
                return;
            }
        }
        self.each_octant(tape, cell, &mut |this, tape, sub| this.closer(tape, sub, levels - 1));
    }

    fn each_octant(&mut self, tape: &Tape, cell: &Aabb, look: &mut dyn FnMut(&mut Self, &Tape, &Aabb)) {
        for sub in cell.octants() {
            match tape.prune(&self.ground.model.leaves, &sub, self.scratch) {
                Pruned::Outside | Pruned::Inside => {}
                Pruned::Same => look(self, tape, &sub),
                Pruned::Smaller(t) => look(self, &t, &sub),
            }
        }
    }
}

/// A curve in which two leaves meet.
struct Curve {
    pair: [u32; 2],
    /// Its point nearest to the middle of a cell.
    near: DVec3,
    /// The tangent there and the piece of it in the cell, if it passes.
    tangent: Option<(DVec3, f64, f64)>,
}

impl Ground<'_> {
    /// The curves of all pairs of leaves that have one near a cell, in order; `None` if they are to be `straight` and one of them goes
    /// away from its tangent in the cell.
    fn curves(&self, which: &[u32], cell: &Aabb, straight: bool) -> Option<Vec<Curve>> {
        let (leaves, scale) = (&self.model.leaves, self.model.bounds().diagonal());
        let (center, reach) = (cell.center(), cell.diagonal());
        let mut found = Vec::new();
        for (n, i) in which.iter().enumerate() {
            for j in &which[n + 1..] {
                let pair = [*i, *j];
                let Some(near) = nearest_on_curve(leaves, pair, center, reach, scale) else { continue };
                let tangent = self.tangent(pair, near).and_then(|t| {
                    let (from, to) = clip(cell, near, t)?;
                    Some((t, from, to))
                });
                let off = |p: DVec3| {
                    let foot = || nearest(leaves, &pair, p, reach, scale);
                    let exactly = || foot().is_none_or(|m| m.distance(p) > self.within);
                    is_off(leaves, pair, p, self.within).unwrap_or_else(exactly)
                };
                if straight && tangent.is_some_and(|(t, from, to)| off(near + t * from) || off(near + t * to)) {
                    return None;
                }
                found.push(Curve { pair, near, tangent });
            }
        }
        Some(found)
    }

    /// The direction of a leaf's gradient at a point of an edge: of a formula, which may bend there, on the side on which it bounds the part.
    fn normal(&self, leaf: u32, at: DVec3, tangent: DVec3) -> DVec3 {
        let (leaves, scale) = (&self.model.leaves, self.model.bounds().diagonal());
        let slope = |p: DVec3| leaves[leaf as usize].slope(p).normalize_or_zero();
        let middle = slope(at);
        if !matches!(leaves[leaf as usize], Leaf::Formula(_)) {
            return middle;
        }
        let beside = middle.cross(tangent) * (BESIDE * scale);
        let seen = [at + beside, at - beside].map(|p| (p, slope(p)));
        if seen[0].1.dot(seen[1].1) > UNBENT {
            return middle;
        }
        let bounds = |p: DVec3| {
            let q = nearest(leaves, &[leaf], p, 2.0 * BESIDE * scale, scale)?;
            (self.model.tape.active(leaves, q).leaf == leaf).then(|| slope(q))
        };
        seen.into_iter().find_map(|(p, _)| bounds(p)).unwrap_or(middle)
    }

    /// The direction in which two leaves meet.
    fn tangent(&self, pair: [u32; 2], q: DVec3) -> Option<DVec3> {
        let [a, b] = pair.map(|l| self.model.leaves[l as usize].slope(q).normalize_or_zero());
        a.cross(b).try_normalize()
    }
}

/// Whether the half-open cell holds the point: neighboring cells never both do.
fn holds(cell: &Aabb, p: DVec3) -> bool {
    cell.lo.cmple(p).all() && p.cmplt(cell.hi).all()
}

/// The parameters at which the line `p + t d` enters and leaves the box.
fn clip(cell: &Aabb, p: DVec3, d: DVec3) -> Option<(f64, f64)> {
    let (mut a, mut b) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..3 {
        if d[k] == 0.0 {
            if !(cell.lo[k] <= p[k] && p[k] < cell.hi[k]) {
                return None;
            }
            continue;
        }
        let (s, t) = ((cell.lo[k] - p[k]) / d[k], (cell.hi[k] - p[k]) / d[k]);
        a = a.max(s.min(t));
        b = b.min(s.max(t));
    }
    (a < b).then_some((a, b))
}

fn in_cell(ground: &Ground<'_>, tape: &Tape, curves: &[Curve], cell: &Aabb, found: &mut Found) {
    let which = leaves_of(tape);
    let leaves = &ground.model.leaves;
    let scale = ground.model.bounds().diagonal();
    let meeting = Meeting { tape, holds: *cell, bricks: ground.bricks, whole: &ground.model.tape, leaves, scale };
    let (center, reach) = (cell.center(), cell.diagonal());
    let mut triples: Vec<([u32; 3], DVec3)> = Vec::new();
    for (a, &i) in which.iter().enumerate() {
        for (b, &j) in which.iter().enumerate().skip(a + 1) {
            for &k in &which[b + 1..] {
                triples.extend(crossing(leaves, [i, j, k], center, reach, scale).map(|q| ([i, j, k], q)));
            }
        }
    }
    let corner = |t: &&([u32; 3], DVec3)| holds(cell, t.1) && meeting.corner(t.0, t.1);
    found.corners.extend(triples.iter().filter(corner).map(|t| t.1));
    for curve in curves {
        let ([i, j], q) = (curve.pair, curve.near);
        let Some((t, from, to)) = curve.tangent else { continue };
        // An edge ends where a third leaf crosses it, so each stretch between such points is a sample or none.
        let on = triples.iter().filter(|x| x.0.contains(&i) && x.0.contains(&j)).map(|x| (x.1 - q).dot(t));
        let mut ends: Vec<f64> = on.filter(|s| from < *s && *s < to).chain([from, to]).collect();
        ends.sort_by(f64::total_cmp);
        for (from, to) in ends.iter().zip(&ends[1..]).filter(|e| e.0 < e.1) {
            // the middle of the piece, put back on the curve
            let Some(m) = nearest_on_curve(leaves, [i, j], q + t * (0.5 * (from + to)), reach, scale) else { continue };
            let Some((inside_i, inside_j)) = meeting.edge(i, j, m) else { continue };
            let Some(tangent) = ground.tangent([i, j], m) else { continue };
            let normal = |leaf: u32, inside: bool| {
                let g = ground.normal(leaf, m, tangent);
                if inside { -g } else { g }
            };
            let (a, b) = (normal(i, inside_i), normal(j, inside_j));
            let angle = a.cross(b).length().atan2(a.dot(b)).to_degrees();
            found.samples.push(FeatureSample { point: m, tangent, length: to - from, angle, pieces: [i, j] });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::expr::{Binary, Expr, Unary};
    use crate::implicit::{RSystem, Solid};

    #[test]
    fn cases_that_go_over_into_each_other_have_no_edge() {
        // A block by its distance: a case inside and one outside, each with a crease where they meet.
        let un = Expr::unary;
        let most = |a: Expr, b: Expr| Expr::binary(Binary::Max, a, b);
        let half = [0.8, 0.7, 0.5];
        let [p, q, r] = [(Expr::x(), 0.8), (Expr::y(), 0.7), (Expr::z(), 0.5)].map(|(e, h)| un(Unary::Abs, e) - h);
        let beyond = |e: &Expr| most(e.clone(), Expr::constant(0.0));
        let square = |e: Expr| e.clone() * e;
        let length = un(Unary::Sqrt, square(beyond(&p)) + square(beyond(&q)) + square(beyond(&r)));
        let inside = Expr::binary(Binary::Min, most(most(p, q), r), Expr::constant(0.0));
        let beside = un(Unary::Abs, Expr::x() + Expr::y()) * 0.2 - 0.1;
        let model = Implicit::new(&Solid::formula(-(length + inside + beside)), RSystem::R0, None).unwrap();
        let sharp: Vec<_> = features(&model, 0.1, &Run::new()).unwrap().samples;
        let sharp: Vec<_> = sharp.iter().filter(|s| s.angle > 40.0).collect();
        assert!(sharp.iter().map(|s| s.length).sum::<f64>() > 8.0);
        for s in sharp {
            let mut depth = [0, 1, 2].map(|k| s.point[k].abs() - half[k]);
            depth.sort_by(f64::total_cmp);
            assert!(depth[2] < 1e-6 && depth[2] - depth[1] < 1e-6, "{s:?}");
        }
    }
}
