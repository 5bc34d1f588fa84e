//! What is wrong with a boundary representation: edges without or with too many faces, things that lie apart from each other,
//! borders that cross, and what is too small to be meant.
//!
//! Nothing is meshed. Edges are looked at in many places, and feet on surfaces are found as the mesher finds them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::brep::{Brep, Edge, Face};
use super::chart::Chart;
use super::curve::PARTS;
use crate::error::{Error, Place, Result};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Chords do not end at plain shares of their curves: that is where curves meet that are drawn by hand.
const UNEVEN: f64 = 0.137;
/// How often chords that cross are divided before the curves are taken to cross too.
const DEPTH: usize = 4;
/// Crossings this many tolerances from a vertex of both edges are no crossings.
const AT_VERTEX: f64 = 10.0;
/// So many tolerances are too short for an edge and too narrow for a face,
const TOLERANCES: f64 = 10.0;
/// and so is this share of the body.
const SMALL: f64 = 1e-6;

/// The kinds of things that are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FlawKind {
    /// An edge of a solid has a face on one side only.
    OpenEdge,
    /// More than two faces meet in an edge.
    CrowdedEdge,
    /// Both faces run along an edge the same way: one of them has its outside inside.
    TurnedFace,
    /// A vertex is not at the end of an edge's curve.
    VertexOffCurve,
    /// The curve of an edge is not on the surface of one of its faces.
    CurveOffFace,
    /// A face has no border, and its surface does not close by itself.
    NoBorder,
    /// Two edges of a face cross away from their vertices.
    CrossingBorders,
    /// An edge is too short to be meant.
    ShortEdge,
    /// A face is too narrow to be meant.
    Sliver,
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Flaw {
    /// What.
    pub kind: FlawKind,
    /// The number of the body.
    pub body: u32,
    /// Numbers of the faces it is about.
    pub faces: Vec<u32>,
    /// The edge it is about; none for faces as a whole.
    pub edge: Option<u32>,
    /// Where.
    pub at: DVec3,
    /// How far apart, how long or how wide, where that is what is wrong.
    pub length: Option<f64>,
}

/// What was found of one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyAudit {
    /// How many edges it has.
    pub edges: usize,
    /// Edges with a face on one side only.
    pub open: usize,
    /// Edges where more than two faces meet.
    pub crowded: usize,
    /// The largest distance from a vertex to the end of a curve.
    pub vertex_gap: f64,
    /// The largest distance from a curve to a surface, where it was looked at.
    pub curve_gap: f64,
}

/// What was found of all bodies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Audit {
    /// Of each body.
    pub bodies: Vec<BodyAudit>,
    /// All that is wrong, by body and kind.
    pub flaws: Vec<Flaw>,
}

/// A face that uses an edge, and which way it runs along it.
#[derive(Debug, Clone, Copy)]
struct Use {
    face: u32,
    forward: bool,
}

/// Looks at every body for what is wrong. Distances up to `tolerance`, in the model's unit, are not.
///
/// *Guarantees*: the same result for any number of threads; open and crowded edges are all found.
/// *Does not guarantee*: that curves stay near surfaces between the places looked at; that borders which only touch are found; that
/// solids are not inside out as a whole, or do not pass through each other.
/// *Errors*: [`Error::Input`] where numbers of vertices, edges or faces are out of range; cancellation.
pub fn audit(brep: &Brep, tolerance: f64, run: &Run) -> Result<Audit> {
    in_range(brep)?;
    let mut out = Audit::default();
    for (b, body) in brep.bodies.iter().enumerate() {
        run.check()?;
        let mut uses: Vec<Vec<Use>> = vec![Vec::new(); brep.edges.len()];
        for &face in &body.faces {
            for c in brep.faces[face as usize].loops.iter().flatten() {
                uses[c.edge as usize].push(Use { face, forward: c.forward });
            }
        }
        let own: Vec<u32> = (0..brep.edges.len() as u32).filter(|e| !uses[*e as usize].is_empty()).collect();
        let size = Aabb::around(own.iter().flat_map(|e| looked(&brep.edges[*e as usize], 1).map(|x| x.1))).diagonal();
        let look =
            Auditor { brep, body: b as u32, uses: &uses, tolerance, least: (TOLERANCES * tolerance).max(SMALL * size) };
        let mut told = BodyAudit { edges: own.len(), ..BodyAudit::default() };
        for &e in &own {
            look.at_edge(e, body.solid, &mut told, &mut out.flaws);
        }
        let each = |f: &u32| run.check().map(|()| look.at_face(*f));
        let faces: Vec<(f64, Vec<Flaw>)> = run.install(|| body.faces.par_iter().map(each).collect::<Result<_>>())?;
        for (gap, flaws) in faces {
            told.curve_gap = told.curve_gap.max(gap);
            out.flaws.extend(flaws);
        }
        out.bodies.push(told);
    }
    out.flaws.sort_by_key(|f| (f.body, f.kind));
    Ok(out)
}

fn in_range(brep: &Brep) -> Result<()> {
    let wrong = |what: String| Err(Error::input(Place::Item(what), "it names something the model does not have"));
    for (i, e) in brep.edges.iter().enumerate() {
        if e.ends.iter().any(|v| *v as usize >= brep.vertices.len()) {
            return wrong(format!("edge {i}"));
        }
    }
    for f in &brep.faces {
        if f.loops.iter().flatten().any(|c| c.edge as usize >= brep.edges.len()) {
            return wrong(format!("face {}", f.name));
        }
    }
    for b in &brep.bodies {
        if b.faces.iter().any(|f| *f as usize >= brep.faces.len()) {
            return wrong(format!("body {}", b.name));
        }
    }
    Ok(())
}

/// Parameters and points along an edge, `parts` on each smooth piece, and its end.
fn looked(e: &Edge, parts: usize) -> impl Iterator<Item = (f64, DVec3)> + '_ {
    let pieces = e.curve.pieces(e.range);
    let inner: Vec<f64> = pieces
        .windows(2)
        .flat_map(|w| (0..parts).map(|k| w[0] + (w[1] - w[0]) * k as f64 / parts as f64))
        .chain([e.range[1]])
        .collect();
    inner.into_iter().map(|t| (t, e.curve.at(t)))
}

/// A chord of an edge.
#[derive(Debug, Clone, Copy)]
struct EdgeChord {
    edge: u32,
    range: [f64; 2],
    ends: [DVec3; 2],
}

impl EdgeChord {
    fn bounds(&self) -> Aabb {
        Aabb::around(self.ends).grown(0.5 * self.ends[0].distance(self.ends[1]))
    }
}

/// One body under the lens.
struct Auditor<'a> {
    brep: &'a Brep,
    body: u32,
    /// The faces of each edge.
    uses: &'a [Vec<Use>],
    tolerance: f64,
    /// Shorter and narrower than this is too small.
    least: f64,
}

impl Auditor<'_> {
    fn edge(&self, e: u32) -> &Edge {
        &self.brep.edges[e as usize]
    }

    fn middle(&self, e: u32) -> DVec3 {
        let Edge { curve, range, .. } = self.edge(e);
        curve.at(0.5 * (range[0] + range[1]))
    }

    /// The faces of an edge, and of another, each once.
    fn faces_of(&self, e: u32) -> Vec<u32> {
        let mut all: Vec<u32> = self.uses[e as usize].iter().map(|u| u.face).collect();
        all.dedup();
        all
    }

    fn of_edge(&self, kind: FlawKind, e: u32, at: DVec3, length: Option<f64>) -> Flaw {
        Flaw { kind, body: self.body, faces: self.faces_of(e), edge: Some(e), at, length }
    }

    fn at_edge(&self, e: u32, solid: bool, told: &mut BodyAudit, flaws: &mut Vec<Flaw>) {
        let edge = self.edge(e);
        let uses = &self.uses[e as usize];
        match uses[..] {
            [_] => {
                told.open += 1;
                // A sheet has its borders.
                if solid {
                    flaws.push(self.of_edge(FlawKind::OpenEdge, e, self.middle(e), None));
                }
            }
            [a, b] if a.forward == b.forward => {
                flaws.push(self.of_edge(FlawKind::TurnedFace, e, self.middle(e), None));
            }
            [_, _] => {}
            _ => {
                told.crowded += 1;
                flaws.push(self.of_edge(FlawKind::CrowdedEdge, e, self.middle(e), None));
            }
        }
        let ends = [0, 1].map(|k| (self.brep.vertices[edge.ends[k] as usize], edge.curve.at(edge.range[k])));
        let [a, b] = ends.map(|(v, p)| v.distance(p));
        let (gap, at) = if b > a { (b, ends[1].0) } else { (a, ends[0].0) };
        told.vertex_gap = told.vertex_gap.max(gap);
        if !(gap <= self.tolerance) {
            flaws.push(self.of_edge(FlawKind::VertexOffCurve, e, at, Some(gap)));
        }
        let length = edge.curve.length(edge.range);
        if !(length > self.least) {
            flaws.push(self.of_edge(FlawKind::ShortEdge, e, self.middle(e), Some(length)));
        }
    }

    /// The largest distance from the borders of a face to its surface, and what is wrong with the face.
    fn at_face(&self, f: u32) -> (f64, Vec<Flaw>) {
        let face = &self.brep.faces[f as usize];
        let mut edges: Vec<u32> = face.loops.iter().flatten().map(|c| c.edge).collect();
        edges.sort_unstable();
        edges.dedup();
        let of_face = |kind, at, length| Flaw { kind, body: self.body, faces: vec![f], edge: None, at, length };
        if edges.is_empty() {
            let middle = face.surface.domain().map(|[a, b]| if (b - a).is_finite() { 0.5 * (a + b) } else { 0.0 });
            let (closed, at) = (closes(face), face.surface.at(middle.into()));
            let flaw = (!closed).then(|| of_face(FlawKind::NoBorder, at, None));
            return (0.0, flaw.into_iter().collect());
        }
        let points: Vec<Vec<(f64, DVec3)>> = edges.iter().map(|e| looked(self.edge(*e), PARTS).collect()).collect();
        let every = || points.iter().flatten().map(|x| x.1);
        let chart =
            Chart::new(face.surface.clone(), &Aabb::around(every())).around_points(&every().collect::<Vec<_>>());
        let (mut largest, mut flaws) = (0.0_f64, Vec::new());
        for (e, list) in edges.iter().zip(&points) {
            let far = list.iter().map(|(_, p)| (chart.foot(*p).distance(*p), *p));
            let Some((gap, at)) = far.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            largest = largest.max(gap);
            if !(gap <= self.tolerance) {
                let edge = Some(*e);
                flaws.push(Flaw { edge, ..of_face(FlawKind::CurveOffFace, at, Some(gap)) });
            }
        }
        for (edge, at) in self.crossings(&edges, &chart) {
            flaws.push(Flaw { edge: Some(edge), ..of_face(FlawKind::CrossingBorders, at, None) });
        }
        if let Some((width, at)) = self.width(&edges, &points) {
            flaws.push(of_face(FlawKind::Sliver, at, Some(width)));
        }
        (largest, flaws)
    }

    /// The width of a face that is too narrow, and where it is widest: the largest distance from its border to the nearest other
    /// edge of it.
    fn width(&self, edges: &[u32], points: &[Vec<(f64, DVec3)>]) -> Option<(f64, DVec3)> {
        if edges.len() < 2 {
            return None;
        }
        let boxes: Vec<Aabb> = points
            .iter()
            .map(|l| {
                let sag = l.windows(2).map(|w| w[0].1.distance(w[1].1)).fold(0.0, f64::max);
                Aabb::around(l.iter().map(|x| x.1)).grown(sag)
            })
            .collect();
        let mut widest = None;
        for (i, list) in points.iter().enumerate() {
            for (_, p) in list {
                let others = (0..edges.len()).filter(|j| *j != i);
                let near = others.filter(|j| boxes[*j].distance_squared(*p) <= self.least * self.least);
                let away = |j: usize| {
                    let e = self.edge(edges[j]);
                    e.curve.at(e.curve.project(*p, e.range, None)).distance(*p)
                };
                let way = near.map(away).fold(f64::INFINITY, f64::min);
                if !(way <= self.least) {
                    return None;
                }
                if widest.is_none_or(|(w, _)| way > w) {
                    widest = Some((way, *p));
                }
            }
        }
        widest
    }

    /// Pairs of edges of a face that cross, each by one edge of it and the place.
    fn crossings(&self, edges: &[u32], chart: &Chart) -> Vec<(u32, DVec3)> {
        let mut chords: Vec<EdgeChord> = Vec::new();
        for &edge in edges {
            let Edge { curve, range, .. } = self.edge(edge);
            for w in curve.pieces(*range).windows(2) {
                chords.extend(self.parts(edge, [w[0], w[1]]));
            }
        }
        let tree = Bvh::new(chords.iter().map(EdgeChord::bounds).collect());
        let mut out: Vec<(u32, u32, DVec3)> = Vec::new();
        for [i, j] in tree.pairs(&|i, j| chords[i as usize].edge != chords[j as usize].edge) {
            let (a, b) = (chords[i as usize], chords[j as usize]);
            if out.iter().any(|(e, f, _)| [*e, *f] == [a.edge, b.edge]) {
                continue;
            }
            if let Some(p) = self.meet(&a, &b, chart, 0) {
                out.push((a.edge, b.edge, p));
            }
        }
        out.into_iter().map(|(e, _, p)| (e, p)).collect()
    }

    /// Chords of a part of an edge.
    fn parts(&self, edge: u32, [a, b]: [f64; 2]) -> Vec<EdgeChord> {
        let curve = &self.edge(edge).curve;
        let t: Vec<f64> = (0..=PARTS)
            .map(|k| match k {
                0 => a,
                PARTS => b,
                k => a + (b - a) * (k as f64 + UNEVEN) / PARTS as f64,
            })
            .collect();
        t.windows(2).map(|w| EdgeChord { edge, range: [w[0], w[1]], ends: [curve.at(w[0]), curve.at(w[1])] }).collect()
    }

    fn at_common_vertex(&self, a: u32, b: u32, p: DVec3) -> bool {
        let near = (AT_VERTEX * self.tolerance).max(self.least);
        let ends = |e: u32| self.edge(e).ends.map(|v| self.brep.vertices[v as usize]);
        let at = |e: u32| ends(e).iter().any(|q| q.distance(p) <= near);
        at(a) && at(b)
    }

    /// Where two chords cross as seen along the face's normal, and their halves of halves as well.
    fn meet(&self, a: &EdgeChord, b: &EdgeChord, chart: &Chart, depth: usize) -> Option<DVec3> {
        let p = 0.25 * (a.ends[0] + a.ends[1] + b.ends[0] + b.ends[1]);
        let (x, y) = chart.normal_near(p)?.any_orthonormal_pair();
        let flat = |q: DVec3| DVec2::new((q - p).dot(x), (q - p).dot(y));
        if depth == DEPTH {
            let share = across(a.ends.map(flat), b.ends.map(flat))?;
            let p = a.ends[0].lerp(a.ends[1], share);
            return (!self.at_common_vertex(a.edge, b.edge, p)).then_some(p);
        }
        // Chords differ from their arcs: neighbors of those that cross are looked at too, on the first level.
        if depth > 0 && across(a.ends.map(flat), b.ends.map(flat)).is_none() {
            return None;
        }
        let (left, right) = (self.parts(a.edge, a.range), self.parts(b.edge, b.range));
        let pairs = left.iter().flat_map(|l| right.iter().map(move |r| (l, r)));
        pairs.filter(|(l, r)| l.bounds().overlaps(&r.bounds())).find_map(|(l, r)| self.meet(l, r, chart, depth + 1))
    }
}

/// Whether a surface closes by itself: each of its parameters repeats or ends in poles.
fn closes(face: &Face) -> bool {
    let (periods, poles) = (face.surface.periods(), face.surface.poles());
    (0..2).all(|k| periods[k].is_some() || poles.iter().filter(|p| p.axis == k).count() == 2)
}

/// Where along the first of two segments in the plane they cross inside both, as a share of it.
fn across([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<f64> {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let (s, t) = (side(c, d, a), side(c, d, b));
    (s * t < 0.0 && side(a, b, c) * side(a, b, d) < 0.0).then(|| s / (s - t))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::parametric::brep::{Body, Coedge};
    use crate::parametric::build::{Extrusion, Wire, extrude_edges};
    use crate::parametric::{Curve, Frame, Surface};

    fn cube() -> Brep {
        let p = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        let square = Wire::polyline(&p.map(|[x, y]| DVec3::new(x, y, 0.0))).unwrap();
        extrude_edges(&[square], &Extrusion { caps: true, ..Extrusion::new(DVec3::Z, 1.0) }).unwrap()
    }

    fn kinds(b: &Brep) -> Vec<FlawKind> {
        audit(b, 1e-6, &Run::new()).unwrap().flaws.iter().map(|f| f.kind).collect()
    }

    #[test]
    fn a_cube_is_sound_and_each_fault_is_found_alone() {
        let good = cube();
        let told = audit(&good, 1e-6, &Run::new()).unwrap();
        assert!(told.flaws.is_empty(), "{:?}", told.flaws);
        assert_eq!((told.bodies[0].edges, told.bodies[0].open), (12, 0));
        assert!(told.bodies[0].vertex_gap < 1e-12 && told.bodies[0].curve_gap < 1e-12);
        // A face less: its four edges are open, and of a sheet they may be.
        let mut open = good.clone();
        open.bodies[0].faces.pop();
        assert_eq!(kinds(&open), [FlawKind::OpenEdge; 4]);
        open.bodies[0].solid = false;
        assert_eq!(kinds(&open), []);
        // A face twice.
        let mut twice = good.clone();
        twice.bodies[0].faces.push(good.bodies[0].faces[0]);
        assert_eq!(kinds(&twice), [FlawKind::CrowdedEdge; 4]);
        // A face the other way round.
        let mut turned = good.clone();
        for l in &mut turned.faces[0].loops {
            l.reverse();
            l.iter_mut().for_each(|c| c.forward = !c.forward);
        }
        assert_eq!(kinds(&turned), [FlawKind::TurnedFace; 4]);
        // A vertex that is moved by a tenth: three edges do not reach it.
        let mut moved = good.clone();
        moved.vertices[0] += DVec3::new(0.0, 0.0, 0.1);
        let flaws = audit(&moved, 1e-6, &Run::new()).unwrap();
        assert_eq!(flaws.flaws.len(), 3);
        assert!(
            flaws.flaws.iter().all(|f| f.kind == FlawKind::VertexOffCurve && (f.length.unwrap() - 0.1).abs() < 1e-12)
        );
        assert!(kinds(&moved).len() == 3 && audit(&moved, 0.11, &Run::new()).unwrap().bodies[0].vertex_gap > 0.09);
        // A surface that is moved by a tenth: its four edges are not on it.
        let mut off = good.clone();
        if let Surface::Plane { frame } = &mut off.faces[5].surface {
            frame.origin += 0.1 * frame.axes.z_axis;
        }
        assert_eq!(kinds(&off), [FlawKind::CurveOffFace; 4]);
        // No border on a plane.
        let mut bare = good.clone();
        bare.faces[5].loops.clear();
        assert!(kinds(&bare).contains(&FlawKind::NoBorder));
        // Numbers beyond the end are told, not followed.
        let mut beyond = good;
        beyond.bodies[0].faces.push(99);
        assert!(audit(&beyond, 1e-6, &Run::new()).is_err());
    }

    /// A sheet in a plane between closed chains of points.
    fn flat(loops: &[&[[f64; 2]]]) -> Brep {
        let mut b = Brep::default();
        let mut face = Face {
            surface: Surface::Plane { frame: Frame::new(DVec3::ZERO, DVec3::Z, None) },
            outward: true,
            loops: Vec::new(),
            name: "flat".into(),
            source: 0,
            color: None,
        };
        for points in loops {
            let (first, n) = (b.vertices.len() as u32, points.len() as u32);
            b.vertices.extend(points.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)));
            let mut border = Vec::new();
            for k in 0..n {
                let ends = [first + k, first + (k + 1) % n];
                let [p, q] = ends.map(|v| b.vertices[v as usize]);
                border.push(Coedge { edge: b.edges.len() as u32, forward: true });
                b.edges.push(Edge { curve: Curve::segment(p, q), range: [0.0, 1.0], ends, source: 0 });
            }
            face.loops.push(border);
        }
        b.faces.push(face);
        b.bodies.push(Body { name: "sheet".into(), faces: vec![0], solid: false });
        b
    }

    #[test]
    fn borders_that_cross_short_edges_and_slivers_are_found() {
        let square: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let inside: &[[f64; 2]] = &[[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        assert_eq!(kinds(&flat(&[square, inside])), []);
        let over: &[[f64; 2]] = &[[3.0, 1.0], [3.0, 2.0], [5.0, 2.0], [5.0, 1.0]];
        let crossed = audit(&flat(&[square, over]), 1e-6, &Run::new()).unwrap();
        assert_eq!(crossed.flaws.len(), 2);
        for f in &crossed.flaws {
            assert_eq!(f.kind, FlawKind::CrossingBorders);
            assert!(
                (f.at.x - 4.0).abs() < 1e-2 && ((f.at.y - 1.0).abs() < 1e-2 || (f.at.y - 2.0).abs() < 1e-2),
                "{f:?}"
            );
        }
        let short: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 1e-7], [4.0, 4.0], [0.0, 4.0]];
        assert_eq!(kinds(&flat(&[short])), [FlawKind::ShortEdge]);
        let thin: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [2.0, 1e-6]];
        assert_eq!(kinds(&flat(&[thin])), [FlawKind::Sliver]);
        // Two circles that nearly touch do not cross, whatever their chords do.
        let round = |r: f64| Edge {
            curve: Curve::circle(Frame::new(DVec3::ZERO, DVec3::Z, None), r),
            range: [0.0, TAU],
            ends: [0, 0],
            source: 0,
        };
        let mut rings = flat(&[square]);
        rings.vertices = vec![DVec3::X, DVec3::new(0.999, 0.0, 0.0)];
        rings.edges = vec![round(1.0), Edge { ends: [1, 1], ..round(0.999) }];
        rings.faces[0].loops = vec![vec![Coedge { edge: 0, forward: true }], vec![Coedge { edge: 1, forward: false }]];
        assert_eq!(kinds(&rings), []);
    }

    #[test]
    fn closed_surfaces_need_no_border() {
        let frame = Frame::new(DVec3::ZERO, DVec3::Z, None);
        for (surface, closed) in [
            (Surface::Sphere { frame, radius: 2.0 }, true),
            (Surface::Torus { frame, major: 3.0, minor: 1.0 }, true),
            (Surface::Cylinder { frame, radius: 1.0 }, false),
            (Surface::Plane { frame }, false),
        ] {
            let mut b = flat(&[&[]]);
            b.faces[0].loops.clear();
            b.faces[0].surface = surface;
            let found = kinds(&b);
            assert_eq!(found.is_empty(), closed, "{found:?}");
        }
    }
}
