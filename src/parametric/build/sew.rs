//! Sheets sewn together along their edges, to a solid where nothing stays open; and flat sheets inside contours.

use glam::DVec3;

use super::assembly::{Assembly, BodyChain, region};
use super::wire::{Wire, refuse};
use crate::error::Result;
use crate::numeric::EIGHT_DIGITS;
use crate::parametric::brep::{Body, Brep, Coedge, Edge};
use crate::parametric::mesh::Parametric;
use crate::run::Run;
use crate::spatial::Aabb;

/// Points at which two edges are compared.
const SAMPLES: u32 = 7;

/// A flat sheet inside a contour, with holes inside the others (\[KUZ19\] 30.1); it looks to the side around which the first
/// contour runs counter-clockwise. Errors: a contour that is open (the gap is named), not flat, or outside the first.
pub fn flat_face(wires: &[Wire]) -> Result<Brep> {
    let Some(first) = wires.first() else { return refuse("nothing to make a face of") };
    let wires = region(wires, first.area_vector().normalize_or_zero())?;
    let mut a = Assembly::default();
    let borders: Vec<BodyChain> = wires.iter().map(|w| a.border(w)).collect();
    a.cap(&wires, &borders, true, "face")?;
    Ok(a.body("sheet", false))
}

impl Brep {
    /// The model without the faces that `drop` picks by name: openings to sew other sheets into.
    pub fn without(mut self, drop: impl Fn(&str) -> bool) -> Self {
        let mut number = vec![u32::MAX; self.faces.len()];
        let mut kept = Vec::new();
        for (i, f) in std::mem::take(&mut self.faces).into_iter().enumerate() {
            if !drop(&f.name) {
                number[i] = kept.len() as u32;
                kept.push(f);
            }
        }
        self.faces = kept;
        for b in &mut self.bodies {
            let before = b.faces.len();
            b.faces = b.faces.iter().map(|f| number[*f as usize]).filter(|f| *f != u32::MAX).collect();
            b.solid &= b.faces.len() == before;
        }
        self.bodies.retain(|b| !b.faces.is_empty());
        self
    }
}

/// Joins models where their edges coincide.
///
/// Vertices within `tolerance` (or 1e-7 of the model) become one, and so do edges between the same vertices that are that
/// near all along. Faces are turned to agree with their neighbors. With `solid`, every edge must then have two faces.
///
/// *Guarantees*: every edge is used once in each direction, or once at an open border; a solid's faces look outwards.
/// *Errors*: an edge of more than two faces, faces that no turning makes agree, and with `solid` an open edge, each with
/// its place; what measuring refuses; cancellation.
pub fn sew(models: Vec<Brep>, tolerance: Option<f64>, solid: bool, run: &Run) -> Result<Brep> {
    if models.iter().all(|m| m.faces.is_empty()) {
        return refuse("nothing to sew");
    }
    let mut b = Brep::together(models);
    let bounds = Aabb::around(b.vertices.iter().copied());
    let points = b.edges.iter().flat_map(|e| e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t)));
    // Points this near to each other are one, where no tolerance is given.
    let near = tolerance.unwrap_or(EIGHT_DIGITS * bounds.union(&Aabb::around(points)).diagonal());
    join_vertices(&mut b, near);
    join_edges(&mut b, near);
    let (parts, open) = oriented(&mut b)?;
    if let (true, Some(e)) = (solid, open.first()) {
        let e = &b.edges[*e as usize];
        let [p, q] = e.range.map(|t| e.curve.at(t));
        let more = if open.len() > 1 { format!(", and {} more", open.len() - 1) } else { String::new() };
        return refuse(format!("the sheets do not close: the edge from {p} to {q} has a face on one side only{more}"));
    }
    let used = b.uses();
    let closed = |faces: &[u32]| {
        faces.iter().flat_map(|f| &b.faces[*f as usize].loops).flatten().all(|c| used[c.edge as usize] == 2)
    };
    let several = parts.len() > 1;
    let name = b.bodies.first().map_or_else(|| "sewn".to_string(), |x| x.name.clone());
    let numbered = |i: usize| if several { format!("{name}{}", i + 1) } else { name.clone() };
    b.bodies = parts
        .into_iter()
        .enumerate()
        .map(|(i, faces)| Body { name: numbered(i), solid: closed(&faces), faces })
        .collect();
    // A body whose volume comes out negative is inside out.
    if b.bodies.iter().any(|x| x.solid) {
        let volumes = Parametric::new(b.clone(), run)?.measure(run)?.volumes;
        let inside_out = b.bodies.iter().zip(volumes).filter(|(x, v)| x.solid && *v < 0.0);
        let turned: Vec<u32> = inside_out.flat_map(|(x, _)| x.faces.clone()).collect();
        turned.into_iter().for_each(|f| turn(&mut b, f));
    }
    b.compact();
    Ok(b)
}

fn join_vertices(b: &mut Brep, near: f64) {
    let mut order: Vec<u32> = (0..b.vertices.len() as u32).collect();
    order.sort_by(|x, y| b.vertices[*x as usize].x.total_cmp(&b.vertices[*y as usize].x));
    let mut one: Vec<u32> = (0..b.vertices.len() as u32).collect();
    for (i, &v) in order.iter().enumerate() {
        let p = b.vertices[v as usize];
        for &w in order[..i].iter().rev() {
            let q = b.vertices[w as usize];
            if p.x - q.x > near {
                break;
            }
            if p.distance(q) <= near {
                one[v as usize] = one[w as usize];
                break;
            }
        }
    }
    b.edges.iter_mut().for_each(|e| e.ends = e.ends.map(|v| one[v as usize]));
}

/// Whether edge `f` runs where `e` does: along it (`true`), or against it.
fn same(e: &Edge, f: &Edge, near: f64) -> Option<bool> {
    let mut ends = [f.ends, e.ends];
    ends.iter_mut().for_each(|x| x.sort_unstable());
    if ends[0] != ends[1] {
        return None;
    }
    let at = |k: u32| e.curve.at(e.range[0] + (e.range[1] - e.range[0]) * f64::from(k) / f64::from(SAMPLES + 1));
    let mut found: Vec<f64> = Vec::new();
    for k in 1..=SAMPLES {
        let p = at(k);
        let t = f.curve.project(p, f.range, None);
        if f.curve.at(t).distance(p) > near {
            return None;
        }
        found.push(t);
    }
    // Of closed edges the parameters may pass the end once.
    let rising = found.windows(2).filter(|w| w[1] > w[0]).count();
    Some(2 * rising > found.len() - 1)
}

fn join_edges(b: &mut Brep, near: f64) {
    let mut at: rustc_hash::FxHashMap<[u32; 2], Vec<u32>> = rustc_hash::FxHashMap::default();
    let mut one: Vec<(u32, bool)> = Vec::with_capacity(b.edges.len());
    for (i, e) in b.edges.iter().enumerate() {
        let mut key = e.ends;
        key.sort_unstable();
        let list = at.entry(key).or_default();
        let known = list.iter().find_map(|k| same(e, &b.edges[*k as usize], near).map(|along| (*k, along)));
        one.push(known.unwrap_or((i as u32, true)));
        if known.is_none() {
            list.push(i as u32);
        }
    }
    for c in b.faces.iter_mut().flat_map(|f| &mut f.loops).flatten() {
        let (edge, along) = one[c.edge as usize];
        *c = Coedge { edge, forward: c.forward == along };
    }
}

/// Shows the other side of a face.
fn turn(b: &mut Brep, face: u32) {
    let f = &mut b.faces[face as usize];
    f.outward = !f.outward;
    for l in &mut f.loops {
        l.reverse();
        l.iter_mut().for_each(|c| c.forward = !c.forward);
    }
}

/// Turns faces until neighbors agree. Gives the connected parts, and the edges with one face.
fn oriented(b: &mut Brep) -> Result<(Vec<Vec<u32>>, Vec<u32>)> {
    let mut of_edge: Vec<Vec<(u32, bool)>> = vec![Vec::new(); b.edges.len()];
    for (i, f) in b.faces.iter().enumerate() {
        for c in f.loops.iter().flatten() {
            of_edge[c.edge as usize].push((i as u32, c.forward));
        }
    }
    let place = |e: usize| -> DVec3 { b.edges[e].curve.at(0.5 * (b.edges[e].range[0] + b.edges[e].range[1])) };
    if let Some(e) = of_edge.iter().position(|l| l.len() > 2) {
        return refuse(format!("the edge at {} has {} faces", place(e), of_edge[e].len()));
    }
    // Whether each face is turned.
    let mut state: Vec<Option<bool>> = vec![None; b.faces.len()];
    let mut parts = Vec::new();
    for start in 0..b.faces.len() {
        if state[start].is_some() {
            continue;
        }
        state[start] = Some(false);
        let (mut stack, mut part) = (vec![start as u32], Vec::new());
        while let Some(f) = stack.pop() {
            part.push(f);
            let own = state[f as usize].unwrap_or(false);
            for c in b.faces[f as usize].loops.iter().flatten() {
                let [x, y] = of_edge[c.edge as usize][..] else { continue };
                let (other, agree) = (if x.0 == f { y.0 } else { x.0 }, x.1 != y.1);
                // Neighbors agree that run through their edge in opposite directions.
                let wanted = if agree { own } else { !own };
                if other == f {
                    continue;
                }
                match state[other as usize] {
                    None => {
                        state[other as usize] = Some(wanted);
                        stack.push(other);
                    }
                    Some(s) if s != wanted => {
                        return refuse(format!("no turning of faces makes them agree at {}", place(c.edge as usize)));
                    }
                    Some(_) => {}
                }
            }
        }
        part.sort_unstable();
        parts.push(part);
    }
    let open = (0..b.edges.len()).filter(|e| of_edge[*e].len() == 1).map(|e| e as u32).collect();
    for (f, s) in state.iter().enumerate() {
        if *s == Some(true) {
            turn(b, f as u32);
        }
    }
    Ok((parts, open))
}
