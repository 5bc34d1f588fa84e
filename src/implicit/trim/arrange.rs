//! A leaf's mesh cut along the zeros of other leaves, and which of the pieces bound the solid.
//!
//! Between nodes leaves count as linear, on every triangle: their zeros are then straight there, and their arrangement
//! is a matter of signs, the same on both sides of an edge.

use std::sync::Arc;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::fillet::{Fillet, touch, value_on};
use super::super::leaf::Leaf;
use super::super::model::Implicit;
use super::super::newton::{condition, leaves_of, nearest};
use super::super::octree::Cell;
use super::super::tape::{Pruned, Scratch, Tape};
use super::Unfit;
use super::ends::{Ends, fillet_and_side};
use super::sheet::Sheet;
use super::{place, positive, share};
use crate::spatial::Aabb;

/// Points are looked for on their leaves within this many cells.
const REACH: f64 = 2.0;
/// Steps on one leaf towards another, and how long they are at most, in cells.
const STEPS: usize = 40;
const STRIDE: f64 = 0.2;
/// Where a brick has more leaves than this, only those count that matter within this many cells around a triangle.
const MANY: usize = 48;
const AROUND: f64 = 1.0;
/// How often an interval is halved that holds a zero: then nothing is left of it.
const HALVED: usize = 54;

/// What a side of a polygon lies on: a side of the triangle, by its number, or the zeros of another leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Line {
    Side(u8),
    Leaf(u32),
}

/// A corner of a polygon, with where it is in its triangle; `along` is its place on a side of the mesh, from the lower node.
#[derive(Debug, Clone, Copy)]
struct Corner {
    id: u32,
    weights: [f64; 3],
    along: Option<(u8, f64)>,
    /// Lines of leaves that it was made on.
    on: [u32; 2],
}

struct Polygon {
    ring: Vec<(usize, Line)>,
    /// Signs of the leaves that cut the triangle.
    signs: Vec<(u32, bool)>,
}

/// What a leaf contributes to the boundary of the solid.
pub(super) struct Part {
    pub(super) leaf: u32,
    pub(super) points: Vec<DVec3>,
    /// Corners in turn, counter-clockwise seen from outside the solid.
    pub(super) polygons: Vec<Vec<u32>>,
    /// Sides of polygons where another leaf takes over, with that leaf: start, end, leaf. In the order of the polygons.
    pub(super) border: Vec<(u32, u32, u32)>,
    /// Leaves each point of the border is on, ascending; empty for other points.
    pub(super) on: Vec<Vec<u32>>,
}

impl Polygon {
    /// Whether a line's positive side has the polygon; `same` are the signs of lines that do not cut the triangle.
    fn has(&self, line: u32, same: &[(u32, bool)]) -> bool {
        self.signs.iter().chain(same).any(|x| *x == (line, true))
    }

    /// Adds a corner to the side on a leaf's line that passes it.
    fn take_in(&mut self, line: u32, x: usize, corners: &[Corner]) {
        let n = self.ring.len();
        if self.ring.iter().any(|c| c.0 == x) {
            return;
        }
        let passes = |k: &usize| {
            let ((v, own), (w, _)) = (self.ring[*k], self.ring[(k + 1) % n]);
            own == Line::Leaf(line) && same_segment(corners, v, w, x)
        };
        if let Some(k) = (0..n).find(passes) {
            self.ring.insert(k + 1, (x, Line::Leaf(line)));
        }
    }

    fn with(mut self, line: u32, sign: bool) -> Self {
        self.signs.push((line, sign));
        self
    }
}

impl Corner {
    /// What is linear in the triangle, by its values at the nodes.
    fn linear(&self, nodes: [u32; 3], values: [f64; 3]) -> f64 {
        match self.along {
            Some((side, s)) => {
                let (a, b) = ends(nodes, side);
                values[a] * (1.0 - s) + values[b] * s
            }
            None => (0..3).map(|k| values[k] * self.weights[k]).sum(),
        }
    }
}

/// What cuts a triangle: a leaf, or a line where fillets end.
struct Cut<'a> {
    line: u32,
    form: Form<'a>,
    /// Pairs of other lines where which cross it does, too.
    through: [[u32; 2]; 2],
}

enum Form<'a> {
    /// By the values at the nodes.
    Linear([f64; 3]),
    /// A fillet of linear sides, by their values at the nodes, and the lines where it ends in them.
    Fillet { fillet: &'a Fillet, sides: [[f64; 3]; 2], lines: [u32; 2] },
}

impl Cut<'_> {
    fn linear(line: u32, values: [f64; 3]) -> Self {
        Self { line, form: Form::Linear(values), through: [[u32::MAX; 2]; 2] }
    }

    fn value(&self, nodes: [u32; 3], c: &Corner) -> f64 {
        match self.form {
            Form::Linear(values) => c.linear(nodes, values),
            Form::Fillet { fillet, sides, .. } => fillet.between(c.linear(nodes, sides[0]), c.linear(nodes, sides[1])),
        }
    }

    /// Where between two corners, at which its values have different signs, it is zero.
    fn crossing(&self, nodes: [u32; 3], [v, w]: [&Corner; 2]) -> f64 {
        let Form::Fillet { fillet, sides, .. } = self.form else {
            return share(self.value(nodes, v), self.value(nodes, w));
        };
        let [a, b] = sides.map(|s| [v.linear(nodes, s), w.linear(nodes, s)]);
        let at = |t: f64| fillet.between(a[0] * (1.0 - t) + a[1] * t, b[0] * (1.0 - t) + b[1] * t);
        let (mut low, mut high) = (0.0, 1.0);
        let first = positive(at(low));
        for _ in 0..HALVED {
            let middle = 0.5 * (low + high);
            *(if positive(at(middle)) == first { &mut low } else { &mut high }) = middle;
        }
        0.5 * (low + high)
    }

    /// Whether a corner is on the line by the way it was made.
    fn passes(&self, c: &Corner) -> bool {
        c.on[1] != u32::MAX && self.through.iter().any(|l| l.iter().all(|l| c.on.contains(l)))
    }
}

struct Arranger<'a> {
    model: &'a Implicit,
    ends: &'a Ends,
    leaf: u32,
    sheet: &'a Sheet,
    points: Vec<DVec3>,
    /// With their place on the edge.
    crossings: FxHashMap<(u32, u32, u32), (u32, f64)>,
    /// Points on each edge of the mesh, with their place from its lower node, in order.
    on_edge: FxHashMap<(u32, u32), Vec<(f64, u32)>>,
}

/// What of a brick of [many](MANY) leaves matters around the triangle looked at last.
struct Near {
    brick: Option<usize>,
    bounds: Aabb,
    /// The other leaves, and the brick's tape without the rest; nothing where no leaf decides.
    found: Option<(Vec<u32>, Arc<Tape>)>,
    scratch: Scratch,
}

/// Cuts a sheet. *Errors*: the places where what bounds the solid ends otherwise than at another leaf, or touches itself.
pub(super) fn arrange(
    (model, ends): (&Implicit, &Ends),
    leaf: u32,
    sheet: &Sheet,
    bricks: &[&Cell],
    cell: f64,
) -> Result<Part, Unfit> {
    // A fillet's sheet goes on beyond its ends, along its sides.
    let sides = if let Leaf::Fillet(f) = &model.leaves[leaf as usize] { &f.sides[..] } else { &[] };
    let others_of = |tape: &Tape| {
        let mut own = leaves_of(tape);
        own.extend(sides.iter().map(|s| s.number));
        own.sort_unstable();
        own.dedup();
        own.retain(|l| *l != leaf);
        own
    };
    let others: Vec<Vec<u32>> = bricks.iter().map(|b| others_of(&b.tape)).collect();
    let mut near = Near { brick: None, bounds: Aabb::EMPTY, found: None, scratch: Scratch::default() };
    let mut this = Arranger {
        model,
        ends,
        leaf,
        sheet,
        points: sheet.nodes.clone(),
        crossings: FxHashMap::default(),
        on_edge: FxHashMap::default(),
    };
    // Polygons that bound the solid: with their sides as cut from the triangle, and whether the leaf's positive side is inside.
    let mut kept: Vec<(Vec<Corner>, Vec<Line>, u32)> = Vec::new();
    let mut side = vec![false; ends.count];
    for t in 0..sheet.triangles.len() {
        let brick = sheet.brick[t] as usize;
        let (mut tape, mut list) = (&bricks[brick].tape, &others[brick]);
        if list.len() > MANY {
            let bounds = Aabb::around(sheet.triangles[t].map(|v| sheet.nodes[v as usize]));
            if near.brick != Some(brick) || near.bounds.union(&bounds) != near.bounds {
                near.brick = Some(brick);
                near.bounds = bounds.grown(AROUND * cell);
                let pruned = tape.prune(&model.leaves, &near.bounds, &mut near.scratch);
                near.found = match pruned {
                    Pruned::Smaller(tape) => Some((others_of(&tape), Arc::new(tape))),
                    Pruned::Same => Some((list.clone(), tape.clone())),
                    Pruned::Inside | Pruned::Outside => None,
                };
            }
            let Some(found) = &near.found else { continue };
            (list, tape) = (&found.0, &found.1);
        }
        let Some((corners, polygons, signs)) = this.cut(t, list) else {
            return Err(sheet.triangles[t].map(|v| sheet.nodes[v as usize]).to_vec());
        };
        for polygon in polygons {
            // The brick's tape has no other leaves than those. Between its ends a fillet is below both its sides.
            polygon.signs.iter().chain(&signs).for_each(|(l, s)| side[*l as usize] = *s);
            if sides.iter().any(|s| side[s.number as usize] != s.negate) {
                continue;
            }
            let plus = tape.inside_by(|l| l == leaf || side[l as usize]);
            if plus == tape.inside_by(|l| l != leaf && side[l as usize]) {
                continue;
            }
            let mut ring: Vec<Corner> = polygon.ring.iter().map(|x| corners[x.0]).collect();
            let mut lines: Vec<Line> = polygon.ring.iter().map(|x| x.1).collect();
            if !plus {
                ring.reverse();
                // Side k runs from corner k to the next one.
                lines.reverse();
                lines.rotate_left(1);
            }
            kept.push((ring, lines, t as u32));
        }
    }
    this.finish(kept, cell)
}

impl Arranger<'_> {
    /// The polygons other leaves cut a triangle into, and the signs of the leaves that do not cut it.
    #[allow(clippy::type_complexity)]
    fn cut(&mut self, t: usize, others: &[u32]) -> Option<(Vec<Corner>, Vec<Polygon>, Vec<(u32, bool)>)> {
        let nodes = self.sheet.triangles[t];
        let leaves = &self.model.leaves;
        let at = nodes.map(|v| self.sheet.nodes[v as usize]);
        let values = |j: u32| {
            let value =
                |k: usize| if self.sheet.is_pinned(nodes[k], j) { 0.0 } else { value_on(leaves, self.leaf, j, at[k]) };
            [0, 1, 2].map(value)
        };
        let mut cuts: Vec<Cut> = Vec::new();
        for &j in others {
            if let Some((f, number, k)) = fillet_and_side(leaves, self.leaf, j) {
                cuts.push(Cut::linear(self.ends.line(number, k), at.map(|p| f.reach(1 - k, p))));
                continue;
            }
            match &leaves[j as usize] {
                Leaf::Fillet(f) if !touch(leaves, self.leaf, j) => {
                    let sides = [0, 1].map(|k| at.map(|p| f.sides[k].continued(p)));
                    let lines = [0, 1].map(|k| self.ends.line(j, k));
                    cuts.extend([0, 1].map(|k| Cut::linear(lines[k], sides[1 - k].map(|v| f.radius + v))));
                    // Where it ends in a side it is what the side is.
                    let through = [0, 1].map(|k| [lines[k], f.sides[k].number]);
                    cuts.push(Cut { line: j, form: Form::Fillet { fillet: f, sides, lines }, through });
                }
                Leaf::Fillet(_) => {
                    let mut cut = Cut::linear(j, values(j));
                    if let Leaf::Fillet(_) = leaves[self.leaf as usize] {
                        // Two that end in one surface cross where both do.
                        cut.through = [0, 1].map(|k| [self.leaf, j].map(|f| self.ends.line(f, k)));
                    }
                    cuts.push(cut);
                }
                _ => cuts.push(Cut::linear(j, values(j))),
            }
        }
        // The ends of fillets first: what is beyond them they do not cut.
        cuts.sort_by_key(|c| ((c.line as usize) < leaves.len(), c.line));
        cuts.dedup_by_key(|c| c.line);
        let unit = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let corner = |k: usize| Corner { id: nodes[k], weights: unit(k), along: None, on: [u32::MAX; 2] };
        let mut corners: Vec<Corner> = (0..3).map(corner).collect();
        let whole = vec![(0, Line::Side(0)), (1, Line::Side(1)), (2, Line::Side(2))];
        let mut polygons = vec![Polygon { ring: whole, signs: Vec::new() }];
        let mut same = Vec::new();
        for cut in &cuts {
            if let Form::Linear(values) = cut.form {
                let first = positive(values[0]);
                if values.iter().all(|v| positive(*v) == first) {
                    same.push((cut.line, first));
                    continue;
                }
            }
            let mut made: Vec<(u32, usize)> = Vec::new();
            let mut next = Vec::with_capacity(2 * polygons.len());
            for p in polygons {
                if let Form::Fillet { lines, .. } = cut.form
                    && lines.iter().any(|l| !p.has(*l, &same))
                {
                    next.push(p.with(cut.line, false));
                } else {
                    self.split(t, cut, p, &mut corners, &mut made, &mut next)?;
                }
            }
            polygons = next;
            // What it did not cut has the points on its sides, too.
            if let Form::Fillet { .. } = cut.form {
                for p in &mut polygons {
                    made.iter().for_each(|&(line, x)| p.take_in(line, x, &corners));
                }
            }
        }
        for &j in others {
            let Some((f, number, k)) = fillet_and_side(leaves, self.leaf, j) else { continue };
            let line = self.ends.line(number, k);
            for p in &mut polygons {
                let reaches = p.has(line, &same);
                // A fillet is above a side that it reaches.
                p.signs.push((j, if number == j { reaches } else { reaches == f.sides[k].negate }));
                p.ring.iter_mut().filter(|x| x.1 == Line::Leaf(line)).for_each(|x| x.1 = Line::Leaf(j));
            }
        }
        Some((corners, polygons, same))
    }

    /// Parts a polygon by the sign of a leaf; `made` remembers points made inside the triangle, by the leaf they lie on.
    fn split(
        &mut self,
        t: usize,
        cut: &Cut<'_>,
        polygon: Polygon,
        corners: &mut Vec<Corner>,
        made: &mut Vec<(u32, usize)>,
        out: &mut Vec<Polygon>,
    ) -> Option<()> {
        let nodes = self.sheet.triangles[t];
        let at: Vec<f64> = polygon.ring.iter().map(|(v, _)| cut.value(nodes, &corners[*v])).collect();
        let n = at.len();
        // 0 and 1 by sign; of corners on the line nothing.
        let half: Vec<Option<usize>> =
            (0..n).map(|k| (!cut.passes(&corners[polygon.ring[k].0])).then(|| usize::from(positive(at[k])))).collect();
        let sides: Vec<usize> = half.iter().filter_map(|h| *h).collect();
        let changes = (0..sides.len()).filter(|&k| sides[k] != sides[(k + 1) % sides.len()]).count();
        if changes == 0 {
            out.push(polygon.with(cut.line, sides.first() == Some(&1)));
            return Some(());
        }
        if changes != 2 {
            return None;
        }
        let mut halves = [Vec::new(), Vec::new()];
        let mut last = (0..n).rev().find_map(|k| half[k])?;
        for k in 0..n {
            let (v, line) = polygon.ring[k];
            let (w, next) = (polygon.ring[(k + 1) % n].0, (k + 1) % n);
            let Some(own) = half[k] else {
                let to = (1..n).find_map(|d| half[(k + d) % n])?;
                if to != last {
                    halves[last].push((v, Line::Leaf(cut.line)));
                }
                halves[to].push((v, line));
                last = to;
                continue;
            };
            halves[own].push((v, line));
            last = own;
            if half[next].is_none_or(|h| h == own) {
                continue;
            }
            let s = cut.crossing(nodes, [&corners[v], &corners[w]]);
            let x = match line {
                Line::Side(side) => self.on_side(nodes, side, cut, (v, w, s), corners),
                Line::Leaf(l) => match made.iter().find(|m| m.0 == l && same_segment(corners, v, w, m.1)) {
                    Some(m) => m.1,
                    None => {
                        let (p, q) = (corners[v].weights, corners[w].weights);
                        let weights = std::array::from_fn(|i| p[i] * (1.0 - s) + q[i] * s);
                        let id = self.points.len() as u32;
                        self.points.push(place(&self.sheet.nodes, nodes, weights));
                        corners.push(Corner { id, weights, along: None, on: [cut.line, l] });
                        made.push((l, corners.len() - 1));
                        corners.len() - 1
                    }
                },
            };
            // The side that is left closes along the other leaf; the one that is entered goes on along the old line.
            halves[own].push((x, Line::Leaf(cut.line)));
            halves[1 - own].push((x, line));
        }
        for (k, ring) in halves.into_iter().enumerate() {
            out.push(Polygon { ring, signs: polygon.signs.clone() }.with(cut.line, k == 1));
        }
        Some(())
    }

    /// The point where a line crosses a side of the triangle, between corners `v` and `w` by their values: one for both
    /// triangles at it.
    fn on_side(
        &mut self,
        nodes: [u32; 3],
        side: u8,
        cut: &Cut<'_>,
        (v, w, s): (usize, usize, f64),
        corners: &mut Vec<Corner>,
    ) -> usize {
        let (a, b) = ends(nodes, side);
        let edge = (nodes[a], nodes[b]);
        let (id, s) = *self.crossings.entry((edge.0, edge.1, cut.line)).or_insert_with(|| {
            let s = match cut.form {
                Form::Linear(values) => share(values[a], values[b]),
                Form::Fillet { .. } => {
                    let along = |c: &Corner| c.along.map_or(c.weights[b], |x| x.1);
                    along(&corners[v]) * (1.0 - s) + along(&corners[w]) * s
                }
            };
            let id = self.points.len() as u32;
            let (p, q) = (self.sheet.nodes[edge.0 as usize], self.sheet.nodes[edge.1 as usize]);
            self.points.push(p.lerp(q, s));
            let on = self.on_edge.entry(edge).or_default();
            on.insert(on.partition_point(|x| x.0 <= s), (s, id));
            (id, s)
        });
        if let Some(k) = corners.iter().position(|c| c.id == id) {
            return k;
        }
        let mut weights = [0.0; 3];
        (weights[a], weights[b]) = (1.0 - s, s);
        corners.push(Corner { id, weights, along: Some((side, s)), on: [cut.line, u32::MAX] });
        corners.len() - 1
    }

    /// Points on their leaves, borders, and polygons whose sides have all the points on them.
    fn finish(mut self, kept: Vec<(Vec<Corner>, Vec<Line>, u32)>, cell: f64) -> Result<Part, Unfit> {
        let mut polygons = Vec::with_capacity(kept.len());
        let mut sides: Vec<(u32, u32, Line)> = Vec::new();
        for (ring, lines, t) in kept {
            let nodes = self.sheet.triangles[t as usize];
            let mut full = Vec::with_capacity(ring.len());
            for k in 0..ring.len() {
                let (p, q) = (ring[k], ring[(k + 1) % ring.len()]);
                let begin = full.len();
                full.push(p.id);
                if let Line::Side(side) = lines[k] {
                    let (a, b) = ends(nodes, side);
                    // Leaves that matter in the neighboring brick only have points here too.
                    let along = |c: &Corner| match c.along {
                        Some((_, s)) => s,
                        None => c.weights[b],
                    };
                    let (s0, s1) = (along(&p), along(&q));
                    let between = |x: &&(f64, u32)| x.0 > s0.min(s1) && x.0 < s0.max(s1);
                    let own: &[(f64, u32)] = self.on_edge.get(&(nodes[a], nodes[b])).map_or(&[], |v| v);
                    let strictly = own.iter().filter(between).map(|x| x.1);
                    if s0 <= s1 { full.extend(strictly) } else { full.extend(strictly.rev()) }
                }
                for i in begin..full.len() {
                    let to = if i + 1 < full.len() { full[i + 1] } else { q.id };
                    sides.push((full[i], to, lines[k]));
                }
            }
            polygons.push(full);
        }
        let mut used: FxHashMap<(u32, u32), Line> = FxHashMap::default();
        let mut unfit = Vec::new();
        for (a, b, line) in &sides {
            if used.insert((*a, *b), *line).is_some() {
                unfit.push(self.points[*a as usize]);
            }
        }
        let mut border = Vec::new();
        for (a, b, line) in sides {
            if used.contains_key(&(b, a)) {
                continue;
            }
            match line {
                Line::Leaf(j) if (j as usize) < self.model.leaves.len() => border.push((a, b, j)),
                _ => unfit.push(self.points[a as usize]),
            }
        }
        let mut on: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        let mut starts = vec![false; self.points.len()];
        for (a, b, j) in &border {
            if std::mem::replace(&mut starts[*a as usize], true) {
                unfit.push(self.points[*a as usize]);
            }
            for v in [a, b] {
                let set = &mut on[*v as usize];
                set.extend([self.leaf, *j]);
                set.sort_unstable();
                set.dedup();
            }
        }
        let scale = self.model.bounds().diagonal();
        let mut needed = vec![false; self.points.len()];
        polygons.iter().flatten().for_each(|v| needed[*v as usize] = true);
        for v in (0..self.points.len()).filter(|v| needed[*v]) {
            let which = if on[v].is_empty() { &[self.leaf][..] } else { &on[v][..] };
            let from = self.points[v];
            let found = nearest(&self.model.leaves, which, from, REACH * cell, scale).or_else(|| match *which {
                [_, _] => {
                    let other = which.iter().copied().find(|l| *l != self.leaf)?;
                    walk(self.model, self.leaf, other, from, cell)
                }
                _ => None,
            });
            match found {
                Some(p) => self.points[v] = p,
                // At an apex a leaf has no nearest point.
                None if on[v].is_empty() && from.is_finite() => {}
                None => unfit.push(from),
            }
        }
        if !unfit.is_empty() {
            return Err(unfit);
        }
        Ok(Part { leaf: self.leaf, points: self.points, polygons, border, on })
    }
}

/// Where two leaves meet, found by walking on the first towards the second: where they are nearly tangent the nearest such
/// point may be one where other sheets of them meet, and Newton's method miss both.
fn walk(model: &Implicit, on: u32, to: u32, from: DVec3, cell: f64) -> Option<DVec3> {
    let (leaves, scale) = (&model.leaves, model.bounds().diagonal());
    let mut p = nearest(leaves, &[on], from, REACH * cell, scale)?;
    for _ in 0..STEPS {
        let (m, d) = (leaves[on as usize].slope(p).try_normalize()?, condition(leaves, &[on, to], 1, p));
        let slope = d.g - m * m.dot(d.g);
        let step = slope * (-d.v / slope.length_squared());
        if step.length() < STRIDE * cell {
            return nearest(leaves, &[on, to], p, cell, scale);
        }
        p = nearest(leaves, &[on], p + step.clamp_length_max(STRIDE * cell), cell, scale)?;
        if !(p.distance(from) <= REACH * cell) {
            return None;
        }
    }
    None
}

/// The ends of a triangle's side, by number in the triangle: the lower node first.
fn ends(nodes: [u32; 3], side: u8) -> (usize, usize) {
    let (a, b) = (side as usize, (side as usize + 1) % 3);
    if nodes[a] < nodes[b] { (a, b) } else { (b, a) }
}

/// Whether a point made on a leaf's line lies between two others on it.
fn same_segment(corners: &[Corner], v: usize, w: usize, x: usize) -> bool {
    let (p, q, r) = (corners[v].weights, corners[w].weights, corners[x].weights);
    let dot: f64 = (0..3).map(|k| (p[k] - r[k]) * (q[k] - r[k])).sum();
    dot <= 0.0
}
