//! A body while it is being built: vertices, edges, strips of faces between two chains, flat caps.

use glam::{DVec2, DVec3};

use super::wire::{Wire, refuse};
use crate::error::Result;
use crate::numeric::EIGHT_DIGITS;
use crate::parametric::brep::{Body, Brep, Coedge, Edge, Face};
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;
use crate::parametric::surface::Surface;

/// An edge in a direction; `None` where it is a point.
pub(super) type Along = Option<Coedge>;

/// A chain put into a body: the edge of each piece, and the vertices between them.
#[derive(Debug, Clone)]
pub(super) struct BodyChain {
    pub(super) edges: Vec<Along>,
    pub(super) vertices: Vec<u32>,
}

impl BodyChain {
    /// The vertex at the start of a piece, or at the end of the last.
    pub(super) fn vertex(&self, i: usize) -> u32 {
        self.vertices[i % self.vertices.len()]
    }
}

/// A surface to be a face of a strip, and whether Su x Sv points out: to the right of the chain, seen from the far side.
pub(super) type Side = Option<(Surface, bool)>;

/// Builds one body.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    pub(super) brep: Brep,
    /// Chains that touch within this share a vertex.
    pub(super) touch: Option<f64>,
}

impl Assembly {
    pub(super) fn vertex(&mut self, p: DVec3) -> u32 {
        let known = self.touch.and_then(|r| self.brep.vertices.iter().position(|q| p.distance(*q) <= r));
        if let Some(i) = known {
            return i as u32;
        }
        self.brep.vertices.push(p);
        self.brep.vertices.len() as u32 - 1
    }

    /// An edge that runs along its curve from the first end to the second.
    pub(super) fn edge(&mut self, curve: Curve, range: [f64; 2], ends: [u32; 2]) -> Along {
        let edge = self.brep.edges.len() as u32;
        self.brep.edges.push(Edge { curve, range, ends, source: u64::from(edge) + 1 });
        Some(Coedge { edge, forward: true })
    }

    /// The edges of a chain between vertices that are there.
    pub(super) fn edges(&mut self, wire: &Wire, vertices: &[u32]) -> Vec<Along> {
        let mut out = Vec::new();
        for (i, p) in wire.pieces().iter().enumerate() {
            let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
            let ends = if p.forward { [a, b] } else { [b, a] };
            let made = self.edge(p.curve.clone(), p.range, ends);
            out.push(made.map(|c| Coedge { forward: p.forward, ..c }));
        }
        out
    }

    /// A chain with vertices and edges of its own.
    pub(super) fn border(&mut self, wire: &Wire) -> BodyChain {
        let vertices: Vec<u32> = wire.corners().into_iter().map(|p| self.vertex(p)).collect();
        BodyChain { edges: self.edges(wire, &vertices), vertices }
    }

    /// Faces between two chains: `rails[i]` leads from vertex `i` of the first to that of the second.
    pub(super) fn strip(
        &mut self,
        wire: &Wire,
        [from, to]: [&BodyChain; 2],
        rails: &[Along],
        sides: Vec<Side>,
        name: &str,
    ) {
        let single = sides.iter().flatten().count() == 1;
        for (i, side) in sides.into_iter().enumerate() {
            let Some((surface, outward)) = side else { continue };
            let back = |c: Along| c.map(|c| Coedge { forward: !c.forward, ..c });
            let round = [from.edges[i], rails[(i + 1) % rails.len()], back(to.edges[i]), back(rails[i])];
            let name = if single { name.to_string() } else { format!("{name}{}", wire.number(i)) };
            self.face(surface, outward, vec![round.into_iter().flatten().collect()], name);
        }
    }

    pub(super) fn face(&mut self, surface: Surface, outward: bool, loops: Vec<Vec<Coedge>>, name: String) {
        let source = self.brep.faces.len() as u64 + 1;
        let loops = loops.into_iter().filter(|l| !l.is_empty()).collect();
        self.brep.faces.push(Face { surface, outward, loops, name, source, color: None });
    }

    /// A flat face inside chains: the first is its outer border, counter-clockwise around `normal`, which points out where
    /// `forward`, and in where not. Errors: the chains are not flat.
    pub(super) fn cap(&mut self, wires: &[Wire], borders: &[BodyChain], forward: bool, name: &str) -> Result<()> {
        let area = wires[0].area_vector();
        let bounds = wires[0].bounds();
        let size = bounds.diagonal();
        // A cap may be a little off its plane.
        if !(area.length() > EIGHT_DIGITS * size * size) {
            return refuse(format!("the contour around {} encloses no area: it cannot be capped", bounds.center()));
        }
        let normal = area.normalize();
        let origin = wires[0].start();
        for p in wires.iter().flat_map(Wire::samples) {
            let off = (p - origin).dot(normal).abs();
            if off > EIGHT_DIGITS * size {
                return refuse(format!(
                    "the {name} contour is not flat and cannot be capped: {p} is {off} off its plane"
                ));
            }
        }
        let frame = Frame::new(origin, normal, Some(wires[0].pieces()[0].tangent(0.0)));
        let loops = borders.iter().map(|b| {
            let mut l: Vec<Coedge> = b.edges.iter().flatten().copied().collect();
            if !forward {
                l.reverse();
                l.iter_mut().for_each(|c| c.forward = !c.forward);
            }
            l
        });
        self.face(Surface::Plane { frame }, forward, loops.collect(), name.to_string());
        Ok(())
    }

    /// The finished body.
    pub(super) fn body(mut self, name: &str, solid: bool) -> Brep {
        let faces = (0..self.brep.faces.len() as u32).collect();
        // Vertices and edges nothing refers to are left from chains that were points.
        self.brep.bodies.push(Body { name: name.to_string(), faces, solid });
        self.brep.compact();
        self.brep
    }
}

impl Brep {
    /// Drops edges of no face and vertices of no edge.
    pub(super) fn compact(&mut self) {
        let uses = self.uses();
        let mut number = vec![u32::MAX; self.edges.len()];
        let mut kept = Vec::new();
        for (i, e) in std::mem::take(&mut self.edges).into_iter().enumerate() {
            if uses[i] > 0 {
                number[i] = kept.len() as u32;
                kept.push(e);
            }
        }
        self.edges = kept;
        self.faces.iter_mut().for_each(|f| f.loops.iter_mut().flatten().for_each(|c| c.edge = number[c.edge as usize]));
        let mut place = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        for v in self.edges.iter_mut().flat_map(|e| &mut e.ends) {
            if place[*v as usize] == u32::MAX {
                place[*v as usize] = vertices.len() as u32;
                vertices.push(self.vertices[*v as usize]);
            }
            *v = place[*v as usize];
        }
        self.vertices = vertices;
    }
}

/// The surface as a side: whether Su x Sv at its point nearest to `at` looks along `out`. For surfaces with a foot.
pub(super) fn side_by_foot(surface: Surface, at: DVec3, out: DVec3) -> Side {
    let uv = surface.foot(at).unwrap_or(DVec2::ZERO);
    let outward = surface.normal(uv).is_some_and(|n| n.dot(out) > 0.0);
    Some((surface, outward))
}

/// Chains as the borders of one flat region: the first counter-clockwise around `up`, the others, which must lie in it,
/// clockwise. Errors: a chain that is open, or beside the first.
pub(super) fn region(wires: &[Wire], up: DVec3) -> Result<Vec<Wire>> {
    let mut out: Vec<Wire> = Vec::with_capacity(wires.len());
    for (i, w) in wires.iter().enumerate() {
        if let Some(gap) = w.gap() {
            return refuse(format!("a solid needs a closed contour; this one has {gap}"));
        }
        let turn = w.area_vector().dot(up);
        if !(turn.abs() > EIGHT_DIGITS * w.bounds().diagonal().powi(2)) {
            return refuse(format!(
                "the contour around {} lies along its own path: it encloses nothing",
                w.bounds().center()
            ));
        }
        let wanted = i == 0;
        out.push(if (turn > 0.0) == wanted { w.clone() } else { w.reversed() });
    }
    if let Some((outer, holes)) = out.split_first() {
        for h in holes {
            // A hole may touch the border in a point.
            let outside = h.pieces().iter().map(|p| p.at(0.5)).find(|p| !encloses(outer, *p, up));
            if let Some(p) = outside {
                return refuse(format!("the hole at {p} is not inside the first contour"));
            }
        }
    }
    Ok(out)
}

/// Whether a closed chain runs around a point, seen along a direction.
fn encloses(wire: &Wire, p: DVec3, along: DVec3) -> bool {
    let frame = Frame::new(p, along, None);
    let points: Vec<DVec2> = wire.samples().into_iter().map(|q| frame.local(q).truncate()).collect();
    let turn: f64 = (0..points.len())
        .map(|i| {
            let (a, b) = (points[i], points[(i + 1) % points.len()]);
            a.perp_dot(b).atan2(a.dot(b))
        })
        .sum();
    turn.abs() > std::f64::consts::PI
}
