//! Faces between edges: the boundary representation that is meshed.

use glam::DVec3;

use super::curve::Curve;
use super::surface::Surface;

/// A piece of a curve between two vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The curve.
    pub curve: Curve,
    /// The part of it, ascending.
    pub range: [f64; 2],
    /// The vertices at the start and the end of the range; one twice where the edge is closed.
    pub ends: [u32; 2],
    /// What made it, to name it in reports: the number of a record of a file.
    pub source: u64,
}

/// An edge as part of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coedge {
    /// The edge.
    pub edge: u32,
    /// Whether the loop runs along the curve.
    pub forward: bool,
}

/// A part of a surface between loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The surface.
    pub surface: Surface,
    /// Whether Su x Sv points out of the solid.
    pub outward: bool,
    /// The borders; seen from outside the face lies to their left. None where the surface is closed.
    pub loops: Vec<Vec<Coedge>>,
    /// The face's name, unique.
    pub name: String,
    /// What made it, see [`Edge::source`].
    pub source: u64,
    /// Color, where one is given: red, green, blue in 0..=1.
    pub color: Option<[f64; 3]>,
}

/// Faces that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The name.
    pub name: String,
    /// The faces.
    pub faces: Vec<u32>,
    /// Whether the faces are said to enclose a solid.
    pub solid: bool,
}

/// A thing that was not understood, or not as it should be.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The record.
    pub id: u64,
    /// Its line.
    pub line: usize,
    /// What is wrong.
    pub message: String,
    /// Whether something of the model is missing for it.
    pub lost: bool,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{} (line {}): {}", self.id, self.line, self.message)
    }
}

/// A boundary representation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Brep {
    /// The vertices.
    pub vertices: Vec<DVec3>,
    /// The edges.
    pub edges: Vec<Edge>,
    /// The faces.
    pub faces: Vec<Face>,
    /// The bodies.
    pub bodies: Vec<Body>,
}

impl Brep {
    /// How often each edge is used by loops.
    pub fn uses(&self) -> Vec<u32> {
        let mut count = vec![0; self.edges.len()];
        for c in self.faces.iter().flat_map(|f| &f.loops).flatten() {
            count[c.edge as usize] += 1;
        }
        count
    }
}
