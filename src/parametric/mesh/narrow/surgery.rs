//! Closing a narrow region: both sides become the same edges.

use std::ops::Range;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::regions::{Leg, NarrowRegion, RegionSide};
use crate::numeric::Sets;
use crate::parametric::brep::{Brep, Coedge, Edge};
use crate::parametric::curve::{Curve, PARTS};
use crate::parametric::nurbs::{NurbsCurve, SplineEnds};

/// Pieces of edges shorter than this many widths, on both sides, become a point.
const SHORT: f64 = 1.5;
/// Points of a line that leave it by less than this share of the width leave it straight.
const STRAIGHT: f64 = 1e-3;
/// Points a new edge goes through, at most.
const MOST: usize = 400;

/// A piece of an edge along a side.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    edge: u32,
    /// Whether the side runs along it.
    forward: bool,
    length: f64,
}

/// A model without a region of one of its faces; an error says why it cannot be closed.
pub(super) fn close(brep: &Brep, face: u32, region: &NarrowRegion, width: f64) -> Result<Brep, String> {
    let mut out = brep.clone();
    let known = out.vertices.len() as u32;
    let mut cuts: FxHashMap<u32, Vec<(f64, u32)>> = FxHashMap::default();
    // Vertices of the joints, new ones where an edge is divided.
    let mut ends: Vec<[u32; 2]> = Vec::with_capacity(region.joints.len());
    for joint in &region.joints {
        ends.push([0, 1].map(|k| {
            let side = &region.sides[k];
            let i = joint[k];
            if let Some(v) = side.vertices[i] {
                return v;
            }
            let (edge, t) = place(side, i);
            let list = cuts.entry(edge).or_default();
            if let Some((_, v)) = list.iter().find(|c| c.0 == t) {
                return *v;
            }
            out.vertices.push(side.points[i]);
            list.push((t, out.vertices.len() as u32 - 1));
            out.vertices.len() as u32 - 1
        }));
    }
    let mut order: Vec<u32> = cuts.keys().copied().collect();
    order.sort_unstable();
    for e in order {
        divide(&mut out, e, &mut cuts);
    }
    let mut sets = Sets::new(out.vertices.len());
    ends.iter().for_each(|[a, b]| {
        sets.join(*a, *b);
    });
    let mut gone: Vec<u32> = Vec::new();
    let mut made: Vec<u32> = Vec::new();
    for w in region.joints.windows(2) {
        let [a, b] = [0, 1].map(|k| piece(&out, brep, &region.sides[k], w[0][k]..w[1][k], &cuts));
        match (a?, b?) {
            (Some(a), Some(b)) if a.edge == b.edge => {}
            (Some(a), Some(b)) if a.length.max(b.length) > SHORT * width => {
                let middle = middle(region, w[0], w[1], a.forward, width)?;
                out.edges[a.edge as usize] =
                    Edge { curve: middle.0, range: middle.1, ..out.edges[a.edge as usize].clone() };
                for c in out.faces.iter_mut().flat_map(|f| &mut f.loops).flatten().filter(|c| c.edge == b.edge) {
                    *c = Coedge { edge: a.edge, forward: (c.forward == b.forward) == a.forward };
                }
                made.push(a.edge);
            }
            (a, b) => {
                for piece in [a, b].into_iter().flatten() {
                    let [p, q] = out.edges[piece.edge as usize].ends;
                    sets.join(p, q);
                    gone.push(piece.edge);
                }
            }
        }
    }
    unite(&mut out, &mut sets, known);
    // Ends of the region that were left became points, too.
    let mut ends: Vec<u32> = out.faces[face as usize].loops.iter().flatten().map(|c| c.edge).collect();
    ends.sort_unstable();
    ends.dedup();
    gone.extend(ends.iter().filter(|e| {
        let e = &out.edges[**e as usize];
        e.ends[0] == e.ends[1] && length(e) <= SHORT * width
    }));
    for f in &mut out.faces {
        f.loops.iter_mut().for_each(|l| l.retain(|c| !gone.contains(&c.edge)));
        for e in &made {
            cancel(&mut f.loops, *e)?;
        }
        f.loops.retain(|l| !l.is_empty());
    }
    check(&out, &made)?;
    Ok(out)
}

/// About how long an edge is.
fn length(e: &Edge) -> f64 {
    let at = |k: usize| e.curve.at(e.range[0] + (e.range[1] - e.range[0]) * k as f64 / PARTS as f64);
    (0..PARTS).map(|k| at(k).distance(at(k + 1))).sum()
}

/// The edge and its parameter at a point of a side.
fn place(side: &RegionSide, i: usize) -> (u32, f64) {
    match side.legs.get(i) {
        Some(l) => (l.edge, l.t[0]),
        None => side.legs.last().map_or((0, 0.0), |l| (l.edge, l.t[1])),
    }
}

/// Divides an edge at the parameters of its cuts; those get the number of the piece that begins there.
fn divide(brep: &mut Brep, e: u32, cuts: &mut FxHashMap<u32, Vec<(f64, u32)>>) {
    let Some(list) = cuts.get_mut(&e) else { return };
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole = brep.edges[e as usize].clone();
    let mut pieces = vec![e];
    let mut from = (whole.range[0], whole.ends[0]);
    for (k, to) in list.iter().copied().chain([(whole.range[1], whole.ends[1])]).enumerate() {
        let piece = Edge { range: [from.0, to.0], ends: [from.1, to.1], ..whole.clone() };
        if k == 0 {
            brep.edges[e as usize] = piece;
        } else {
            pieces.push(brep.edges.len() as u32);
            brep.edges.push(piece);
        }
        from = to;
    }
    for l in brep.faces.iter_mut().flat_map(|f| &mut f.loops) {
        *l = l
            .iter()
            .flat_map(|c| {
                let all = if c.edge == e { pieces.clone() } else { vec![c.edge] };
                let forward = c.forward;
                let row: Vec<u32> = if forward { all } else { all.into_iter().rev().collect() };
                row.into_iter().map(move |edge| Coedge { edge, forward })
            })
            .collect();
    }
    for (c, p) in list.iter_mut().zip(&pieces[1..]) {
        c.1 = *p;
    }
}

/// The piece of an edge between two joints of a side, `None` where they are one point.
fn piece(
    brep: &Brep,
    before: &Brep,
    side: &RegionSide,
    joints: Range<usize>,
    cuts: &FxHashMap<u32, Vec<(f64, u32)>>,
) -> Result<Option<Piece>, String> {
    let Range { start: from, end: to } = joints;
    if from == to {
        return Ok(None);
    }
    let legs: &[Leg] = &side.legs[from..to];
    let edge = legs[0].edge;
    if legs.iter().any(|l| l.edge != edge) {
        return Err("a side of a narrow region of it is not one edge".into());
    }
    let (s, t) = (legs[0].t[0], legs[legs.len() - 1].t[1]);
    let start = s.min(t);
    let whole = before.edges[edge as usize].range[0];
    let found = if start <= whole {
        Some(edge)
    } else {
        cuts.get(&edge).and_then(|list| list.iter().find(|c| c.0 == start)).map(|c| c.1)
    };
    let found = found.ok_or("a side of a narrow region of it was lost")?;
    let range = brep.edges[found as usize].range;
    if range != [start, s.max(t)] {
        return Err("a side of a narrow region of it comes twice".into());
    }
    let length = side.points[from..=to].windows(2).map(|w| w[0].distance(w[1])).sum();
    Ok(Some(Piece { edge: found, forward: s < t, length }))
}

/// The curve midway between the sides from one joint to the next, and its range.
fn middle(
    region: &NarrowRegion,
    from: [usize; 2],
    to: [usize; 2],
    forward: bool,
    width: f64,
) -> Result<(Curve, [f64; 2]), String> {
    let inside = |p: &[usize; 2]| (0..2).all(|k| p[k] >= from[k] && p[k] <= to[k]);
    let own: Vec<usize> = (0..region.pairs.len()).filter(|i| inside(&region.pairs[*i])).collect();
    let mean = |[i, j]: [usize; 2]| 0.5 * (region.sides[0].points[i] + region.sides[1].points[j]);
    let stride = own.len().div_ceil(MOST).max(1);
    let mut points = vec![mean(from)];
    for i in own.iter().step_by(stride) {
        let [p, q] = region.across(*i);
        points.push(0.5 * (p + q));
    }
    points.push(mean(to));
    // Feet next to the ends may lie beyond them.
    let (a, b) = (points[0], points[points.len() - 1]);
    let mut way = 0.0;
    let mut kept = vec![a];
    for p in &points[1..points.len() - 1] {
        let step = p.distance(kept[kept.len() - 1]);
        if step > 0.5 * width && p.distance(b) > 0.5 * width {
            way += step;
            kept.push(*p);
        }
    }
    kept.push(b);
    if !forward {
        kept.reverse();
    }
    let (a, b) = (kept[0], kept[kept.len() - 1]);
    let chord = b - a;
    let away = |p: &DVec3| (*p - a).cross(chord).length() / chord.length();
    if !(chord.length() > 0.0) && way <= 0.0 {
        return Err("a narrow region of it has no length".into());
    }
    if chord.length() > 0.0 && kept.iter().all(|p| away(p) <= STRAIGHT * width) {
        return Ok((Curve::segment(a, b), [0.0, 1.0]));
    }
    let curve = NurbsCurve::cubic(&kept, SplineEnds::Natural).map_err(|e| e.to_string())?;
    let curve = Curve::Nurbs(curve);
    let range = curve.domain();
    Ok((curve, range))
}

/// Makes the vertices of each set one: where those of them that were there before are, or all of them.
fn unite(brep: &mut Brep, sets: &mut Sets, known: u32) {
    let count = brep.vertices.len();
    // Sum and number of the new vertices of each set, and of those that were there.
    let mut sums = vec![[(DVec3::ZERO, 0u32); 2]; count];
    for v in 0..count as u32 {
        let sum = &mut sums[sets.find(v) as usize][usize::from(v < known)];
        *sum = (sum.0 + brep.vertices[v as usize], sum.1 + 1);
    }
    for v in 0..count {
        let [new, old] = sums[sets.find(v as u32) as usize];
        let (sum, n) = if old.1 > 0 { old } else { new };
        if n > 1 || old.1 + new.1 > 1 {
            brep.vertices[v] = sum / f64::from(n);
        }
    }
    for e in &mut brep.edges {
        e.ends = e.ends.map(|v| sets.find(v));
    }
}

/// Takes an edge out of loops that run along it both ways, and joins or parts them there.
fn cancel(loops: &mut Vec<Vec<Coedge>>, edge: u32) -> Result<(), String> {
    let find = |forward: bool| {
        let is = |c: &Coedge| c.edge == edge && c.forward == forward;
        let mut all = loops
            .iter()
            .enumerate()
            .flat_map(|(l, list)| list.iter().enumerate().filter(move |(_, c)| is(c)).map(move |(i, _)| (l, i)));
        let first = all.next();
        if all.next().is_some() { Err("a face lies on both sides of a narrow region of another") } else { Ok(first) }
    };
    let (Some((l, i)), Some((m, j))) = (find(true)?, find(false)?) else { return Ok(()) };
    let after =
        |list: &[Coedge], i: usize| -> Vec<Coedge> { list[i + 1..].iter().chain(&list[..i]).copied().collect() };
    if l == m {
        // From behind the one to the other, and from behind that to the first again.
        let rest = after(&loops[l], i);
        let k = (j + loops[l].len() - i - 1) % loops[l].len();
        let (one, two) = (rest[..k].to_vec(), rest[k + 1..].to_vec());
        loops[l] = one;
        loops.push(two);
    } else {
        let (mut one, two) = (after(&loops[l], i), after(&loops[m], j));
        one.extend(two);
        loops[l] = one;
        loops[m] = Vec::new();
    }
    Ok(())
}

/// That loops are closed and faces fit together along the new edges.
fn check(brep: &Brep, made: &[u32]) -> Result<(), String> {
    let ends = |c: &Coedge| {
        let [a, b] = brep.edges[c.edge as usize].ends;
        if c.forward { [a, b] } else { [b, a] }
    };
    for l in brep.faces.iter().flat_map(|f| &f.loops) {
        for i in 0..l.len() {
            if ends(&l[i])[1] != ends(&l[(i + 1) % l.len()])[0] {
                return Err("a loop beside a narrow region of it would be open".into());
            }
        }
    }
    for e in made {
        let uses = |forward: bool| {
            let is = |c: &&Coedge| c.edge == *e && c.forward == forward;
            brep.faces.iter().flat_map(|f| &f.loops).flatten().filter(is).count()
        };
        if uses(true) > 1 || uses(false) > 1 {
            return Err("the faces beside a narrow region of it do not fit".into());
        }
    }
    Ok(())
}

/// Takes out faces that are gone, and edges nothing uses.
pub(super) fn sweep(brep: &mut Brep, gone: &[bool]) {
    let mut number = Vec::with_capacity(gone.len());
    let mut next = 0;
    for g in gone {
        number.push((!g).then_some(next));
        next += u32::from(!g);
    }
    let mut left = gone.iter().map(|g| !g);
    brep.faces.retain(|_| left.next().unwrap_or(true));
    for b in &mut brep.bodies {
        b.faces = b.faces.iter().filter_map(|f| number[*f as usize]).collect();
    }
    let uses = brep.uses();
    let mut number = Vec::with_capacity(uses.len());
    let mut next = 0;
    for n in &uses {
        number.push(next);
        next += u32::from(*n > 0);
    }
    let mut left = uses.iter().map(|n| *n > 0);
    brep.edges.retain(|_| left.next().unwrap_or(true));
    for c in brep.faces.iter_mut().flat_map(|f| &mut f.loops).flatten() {
        c.edge = number[c.edge as usize];
    }
}
