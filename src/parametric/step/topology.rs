//! Faces, edges and bodies of STEP files, put where an assembly has them.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::values::{Args, Lookup, Read, note};
use crate::numeric::{EIGHT_DIGITS, ROUNDING};
use crate::parametric::brep::{Body, Brep, Coedge, Edge, Face, Note};
use crate::parametric::curve::Curve;
use crate::parametric::frame::Similarity;
use crate::spatial::Aabb;

/// Names of records that are bodies.
pub(super) const BODIES: [&str; 7] = [
    "MANIFOLD_SOLID_BREP",
    "BREP_WITH_VOIDS",
    "FACETED_BREP",
    "SHELL_BASED_SURFACE_MODEL",
    "FACE_BASED_SURFACE_MODEL",
    "CLOSED_SHELL",
    "OPEN_SHELL",
];

/// Units of one context: a length in millimeters, an angle in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    pub(super) length: f64,
    pub(super) angle: f64,
}

/// Builds bodies one after another.
pub(super) struct BodyBuilder<'a> {
    pub(super) look: Lookup<'a>,
    pub(super) brep: Brep,
    pub(super) notes: Vec<Note>,
    pub(super) colors: FxHashMap<u64, [f64; 3]>,
}

/// What is shared within one placed body.
struct SharedParts {
    place: Similarity,
    units: Units,
    vertices: FxHashMap<u64, u32>,
    /// The edge of each record, or `None` for one without length; the sign says whether the curve runs against the record.
    edges: FxHashMap<u64, Option<(u32, bool)>>,
    /// A length below which an edge is a point.
    point: f64,
}

impl BodyBuilder<'_> {
    /// Adds the body of record `id`, moved by `place` (the units are in it).
    pub(super) fn body(&mut self, id: u64, place: Similarity, units: Units, color: Option<[f64; 3]>, name: &str) {
        let shells = match self.shells(id) {
            Ok(s) => s,
            Err(n) => return self.notes.push(n),
        };
        let color = self.colors.get(&id).copied().or(color);
        let mut placed =
            SharedParts { place, units, vertices: FxHashMap::default(), edges: FxHashMap::default(), point: 0.0 };
        let mut faces = Vec::new();
        let mut solid = false;
        for (shell, flipped) in shells {
            let a = match self.look.args(shell, &["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET"]) {
                Ok(a) => a,
                Err(n) => {
                    self.notes.push(n);
                    continue;
                }
            };
            solid |= a.record.part("CLOSED_SHELL").is_some();
            let list = match a.references(1) {
                Ok(l) => l,
                Err(n) => {
                    self.notes.push(n);
                    continue;
                }
            };
            let color = self.colors.get(&shell).copied().or(color);
            // An edge whose curve is shorter than this is a point: files write degenerate edges this way.
            placed.point = EIGHT_DIGITS * self.extent(&list) * place.scale;
            for f in list {
                match self.face(f, flipped, &mut placed, color) {
                    Ok(face) => {
                        faces.push(self.brep.faces.len() as u32);
                        self.brep.faces.push(face);
                    }
                    Err(n) => {
                        let line = self.look.file.get(f).map_or(0, |r| r.line);
                        let message = format!("the face is left out, because of {n}");
                        self.notes.push(Note { id: f, line, message, lost: true });
                    }
                }
            }
        }
        if !faces.is_empty() {
            self.brep.bodies.push(Body { name: name.to_string(), faces, solid });
        }
    }

    /// The shells of a body, each with whether it is turned inside out.
    fn shells(&self, id: u64) -> Read<Vec<(u64, bool)>> {
        let record = self.look.record(id)?;
        let Some((name, values)) = record.parts.iter().find(|p| BODIES.contains(&p.0.as_str())) else {
            return note(record, format!("{} is no body", record.name()));
        };
        let a = Args { record, values };
        let mut ids = match name.as_str() {
            "CLOSED_SHELL" | "OPEN_SHELL" => vec![id],
            "SHELL_BASED_SURFACE_MODEL" | "FACE_BASED_SURFACE_MODEL" => a.references(1)?,
            _ => vec![a.reference(1)?],
        };
        if name == "BREP_WITH_VOIDS" {
            ids.extend(a.references(2)?);
        }
        ids.into_iter()
            .map(|s| {
                let record = self.look.record(s)?;
                let oriented = record.parts.iter().find(|p| p.0.starts_with("ORIENTED_") && p.0.ends_with("SHELL"));
                match oriented {
                    Some((_, values)) => {
                        let a = Args { record, values };
                        Ok((a.reference(2)?, !a.truth(3)?))
                    }
                    None => Ok((s, false)),
                }
            })
            .collect()
    }

    /// Size of a body by the vertices of its edges, in the file's unit.
    fn extent(&self, faces: &[u64]) -> f64 {
        let mut around = crate::spatial::Aabb::EMPTY;
        let mut stack: Vec<(u64, usize)> = faces.iter().map(|f| (*f, 0)).collect();
        while let Some((id, depth)) = stack.pop() {
            let Some(record) = self.look.file.get(id) else { continue };
            let Some((name, values)) = record.parts.first() else { continue };
            let a = Args { record, values };
            match name.as_str() {
                "ADVANCED_FACE" | "FACE_SURFACE" | "EDGE_LOOP" | "POLY_LOOP" if depth < 8 => {
                    stack.extend(a.references(1).unwrap_or_default().into_iter().map(|i| (i, depth + 1)));
                }
                "FACE_BOUND" | "FACE_OUTER_BOUND" | "VERTEX_POINT" | "VERTEX_LOOP" if depth < 8 => {
                    stack.extend(a.optional(1).map(|i| (i, depth + 1)));
                }
                "ORIENTED_EDGE" if depth < 8 => stack.extend(a.optional(3).map(|i| (i, depth + 1))),
                "EDGE_CURVE" if depth < 8 => {
                    stack.extend([1, 2].iter().filter_map(|k| a.optional(*k)).map(|i| (i, depth + 1)));
                }
                "CARTESIAN_POINT" => {
                    if let Ok(p) = a.triple(1) {
                        around = around.union(&crate::spatial::Aabb::new(p, p));
                    }
                }
                _ => {}
            }
        }
        around.diagonal()
    }

    fn face(&mut self, id: u64, flipped: bool, placed: &mut SharedParts, color: Option<[f64; 3]>) -> Read<Face> {
        let record = self.look.record(id)?;
        if let Some(values) = record.part("ORIENTED_FACE") {
            let a = Args { record, values };
            return self.face(a.reference(2)?, flipped == a.truth(3)?, placed, color);
        }
        let a = self.look.args(id, &["ADVANCED_FACE", "FACE_SURFACE"])?;
        let surface = self.look.surface(a.reference(2)?, placed.units.angle)?.moved(&placed.place);
        let outward = a.truth(3)? != flipped;
        let mut loops = Vec::new();
        for bound in a.references(1)? {
            let b = self.look.args(bound, &["FACE_BOUND", "FACE_OUTER_BOUND"])?;
            let mut edges = self.edge_loop(b.reference(1)?, placed)?;
            if b.truth(2)? == flipped {
                edges.reverse();
                edges.iter_mut().for_each(|c| c.forward = !c.forward);
            }
            if !edges.is_empty() {
                loops.push(edges);
            }
        }
        let text = a.text(0);
        let name = if text.is_empty() || text.eq_ignore_ascii_case("none") { String::new() } else { text.to_string() };
        let color = self.colors.get(&id).copied().or(color);
        Ok(Face { surface, outward, loops, name, source: id, color })
    }

    fn edge_loop(&mut self, id: u64, placed: &mut SharedParts) -> Read<Vec<Coedge>> {
        let a = self.look.args(id, &["EDGE_LOOP", "VERTEX_LOOP", "POLY_LOOP"])?;
        if a.record.part("VERTEX_LOOP").is_some() {
            return Ok(Vec::new());
        }
        if a.record.part("POLY_LOOP").is_some() {
            return self.poly_loop(&a.references(1)?, placed);
        }
        let mut out = Vec::new();
        for o in a.references(1)? {
            let e = self.look.args(o, &["ORIENTED_EDGE"])?;
            let forward = e.truth(4)?;
            if let Some((edge, along)) = self.edge(e.reference(3)?, placed)? {
                out.push(Coedge { edge, forward: forward == along });
            }
        }
        self.chained(out, a)
    }

    /// A loop whose edges follow each other; edges that are the wrong way round are turned.
    fn chained(&mut self, mut list: Vec<Coedge>, a: Args<'_>) -> Read<Vec<Coedge>> {
        let n = list.len();
        let ends = |c: &Coedge| {
            let [a, b] = self.brep.edges[c.edge as usize].ends;
            if c.forward { [a, b] } else { [b, a] }
        };
        // Where Boolean operations end a file may have two vertices at one place.
        let at = |v: u32| self.brep.vertices[v as usize];
        let middle = |c: &Coedge| {
            let e = &self.brep.edges[c.edge as usize];
            e.curve.at(0.5 * (e.range[0] + e.range[1]))
        };
        // Vertices of a face this near to each other are one.
        let near = ROUNDING * Aabb::around(list.iter().flat_map(|c| [at(ends(c)[0]), middle(c)])).diagonal();
        let same = |a: u32, b: u32| a == b || at(a).distance(at(b)) <= near;
        let gaps = |l: &[Coedge]| (0..n).filter(|&i| !same(ends(&l[i])[1], ends(&l[(i + 1) % n])[0])).count();
        if n == 0 || gaps(&list) == 0 {
            return Ok(list);
        }
        // Single edges, then the order as a whole.
        for i in 0..n {
            let mut turned = list.clone();
            turned[i].forward = !turned[i].forward;
            if gaps(&turned) < gaps(&list) {
                list = turned;
            }
        }
        if gaps(&list) > 0 {
            let mut rest = list.clone();
            let mut chain = vec![rest.remove(0)];
            while !rest.is_empty() {
                let end = ends(&chain[chain.len() - 1])[1];
                let next = (0..rest.len()).find(|&i| same(ends(&rest[i])[0], end));
                let turned = (0..rest.len()).find(|&i| same(ends(&rest[i])[1], end));
                let Some(i) = next.or(turned) else { break };
                let mut c = rest.remove(i);
                c.forward ^= next.is_none();
                chain.push(c);
            }
            if !rest.is_empty() || gaps(&chain) > 0 {
                return note(a.record, "the edges of the loop do not follow each other");
            }
            list = chain;
        }
        let message = "edges of the loop were out of order or the wrong way round".into();
        self.notes.push(Note { id: a.record.id, line: a.record.line, message, lost: false });
        Ok(list)
    }

    /// A loop of straight edges between points; edges are shared by their points.
    fn poly_loop(&mut self, points: &[u64], placed: &mut SharedParts) -> Read<Vec<Coedge>> {
        let mut out = Vec::new();
        for (i, &p) in points.iter().enumerate() {
            let q = points[(i + 1) % points.len()];
            let (lo, hi) = (p.min(q), p.max(q));
            let key = (lo << 32 | hi) | 1 << 63;
            let known = placed.edges.get(&key).copied();
            let edge = match known {
                Some(e) => e,
                None => {
                    let ends = [self.point_vertex(lo, placed)?, self.point_vertex(hi, placed)?];
                    let [a, b] = ends.map(|v| self.brep.vertices[v as usize]);
                    let made = if a == b { None } else { Some((self.brep.edges.len() as u32, true)) };
                    if made.is_some() {
                        self.brep.edges.push(Edge { curve: Curve::segment(a, b), range: [0.0, 1.0], ends, source: lo });
                    }
                    placed.edges.insert(key, made);
                    made
                }
            };
            out.extend(edge.map(|(edge, _)| Coedge { edge, forward: p == lo }));
        }
        Ok(out)
    }

    fn point_vertex(&mut self, point: u64, placed: &mut SharedParts) -> Read<u32> {
        if let Some(v) = placed.vertices.get(&point) {
            return Ok(*v);
        }
        let p = placed.place.point(self.look.point(point)?);
        let v = self.brep.vertices.len() as u32;
        self.brep.vertices.push(p);
        placed.vertices.insert(point, v);
        Ok(v)
    }

    fn vertex(&mut self, id: u64, placed: &mut SharedParts) -> Read<u32> {
        if let Some(v) = placed.vertices.get(&id) {
            return Ok(*v);
        }
        let point = self.look.args(id, &["VERTEX_POINT"])?.reference(1)?;
        let v = self.point_vertex(point, placed)?;
        placed.vertices.insert(id, v);
        Ok(v)
    }

    /// The edge of a record, and whether its curve runs from the record's first vertex to the second.
    fn edge(&mut self, id: u64, placed: &mut SharedParts) -> Read<Option<(u32, bool)>> {
        if let Some(e) = placed.edges.get(&id) {
            return Ok(*e);
        }
        let a = self.look.args(id, &["EDGE_CURVE"])?;
        let v = [self.vertex(a.reference(1)?, placed)?, self.vertex(a.reference(2)?, placed)?];
        let mut along = a.truth(4)?;
        let [p, q] = v.map(|v| self.brep.vertices[v as usize]);
        let curve = match self.look.curve(a.reference(3)?) {
            Ok(c) => c.moved(&placed.place),
            // A straight edge stands in for a curve that is not understood, as long as it has ends.
            Err(n) if p.distance(q) > placed.point => {
                self.notes.push(Note { message: format!("{}: a straight edge is used instead", n.message), ..n });
                along = true;
                Curve::segment(p, q)
            }
            Err(n) => return Err(n),
        };
        let (from, to) = if along { (p, q) } else { (q, p) };
        let ends = if along { v } else { [v[1], v[0]] };
        let (range, turned) = range(&curve, from, to, v[0] == v[1]);
        let ends = if turned { [ends[1], ends[0]] } else { ends };
        let along = along != turned;
        if turned {
            let message = "the curve runs from the second vertex to the first, not as same_sense says".into();
            self.notes.push(Note { id, line: a.record.line, message, lost: false });
        }
        let straight = matches!(curve, Curve::Line { .. });
        let length = if straight { p.distance(q) } else { curve.length(range) };
        let made = if !(length > placed.point) && (v[0] == v[1] || p.distance(q) <= placed.point) {
            None
        } else {
            self.brep.edges.push(Edge { curve, range, ends, source: id });
            Some((self.brep.edges.len() as u32 - 1, along))
        };
        placed.edges.insert(id, made);
        Ok(made)
    }
}

/// The part of a curve between two points, ascending, and whether it runs against the order of the points.
fn range(curve: &Curve, from: DVec3, to: DVec3, loops: bool) -> ([f64; 2], bool) {
    let all = curve.domain();
    let find = |p: DVec3| curve.project(p, finite(curve, from, to), None);
    let Some(period) = curve.period() else {
        if loops && all[0].is_finite() {
            return (all, false);
        }
        let (a, b) = (find(from), find(to));
        return if a <= b { ([a, b], false) } else { ([b, a], true) };
    };
    let (a, b) = (find(from), find(to));
    if loops {
        return ([a, a + period], false);
    }
    // The ends of a closed curve are one point: which is meant follows from the order.
    let near = 1e-9 * period;
    let a = if all[1] - a <= near { all[0] } else { a };
    let b = if b - all[0] <= near { all[1] } else { b };
    (if a < b { [a, b] } else { [a, b + period] }, false)
}

/// A finite range that holds what lies near two points.
fn finite(curve: &Curve, p: DVec3, q: DVec3) -> [f64; 2] {
    let [a, b] = curve.domain();
    if a.is_finite() {
        return [a, b];
    }
    match curve {
        Curve::Parabola { frame, focal } => {
            let t = |p: DVec3| frame.local(p).y / (2.0 * focal);
            [t(p).min(t(q)) - 1.0, t(p).max(t(q)) + 1.0]
        }
        Curve::Hyperbola { frame, b, .. } => {
            let t = |p: DVec3| (frame.local(p).y / b).asinh();
            [t(p).min(t(q)) - 1.0, t(p).max(t(q)) + 1.0]
        }
        _ => [a, b],
    }
}
