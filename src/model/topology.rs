//! Vertices, edges, loops, faces, shells and solids: who borders on whom.

use crate::mesh::Group;

/// A place where edges end, or a marked place inside a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vertex<P = ()> {
    /// Where it is.
    pub point: P,
}

/// A stretch of curve between two vertices, directed from the first to the second.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Edge<C = ()> {
    /// Indices of the first and the last vertex; equal for a closed edge.
    pub ends: [u32; 2],
    /// Whether the edge has no length: a side of the face's parameter domain that is one point in space. Closed.
    pub pole: bool,
    /// Its curve.
    pub curve: C,
}

impl<C> Edge<C> {
    /// Whether it begins and ends at the same vertex.
    pub fn is_closed(&self) -> bool {
        self.ends[0] == self.ends[1]
    }
}

/// An edge as a loop runs along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coedge {
    /// Index of the edge.
    pub edge: u32,
    /// Whether the loop runs against the edge's own direction.
    pub reversed: bool,
}

/// One border of a face, the face to its left as seen from outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Loop {
    /// Coedges, each beginning where the one before it ends, the first where the last ends.
    ///
    /// A seam (the line along which a periodic surface meets itself) is an edge the loop runs along twice, once in each
    /// direction.
    Edges(Vec<Coedge>),
    /// A single point: the apex of a cone, a node to keep.
    Vertex(u32),
}

impl Loop {
    /// The coedges; none for a loop that is a point.
    pub fn coedges(&self) -> &[Coedge] {
        match self {
            Loop::Edges(list) => list,
            Loop::Vertex(_) => &[],
        }
    }
}

/// A part of a surface bounded by loops.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Face<S = ()> {
    /// Index into [`Model::names`]. Faces may share one: what the user calls a face can fall into several.
    pub label: u32,
    /// Its borders. Where the surface has an outside border it comes first; a closed surface has no loop at all.
    pub loops: Vec<Loop>,
    /// Its surface.
    pub surface: S,
}

/// Faces joined along edges.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Shell {
    /// Indices of the faces.
    pub faces: Vec<u32>,
}

/// A volume bounded by closed shells.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Solid {
    /// The name, as the user wrote it.
    pub name: String,
    /// Indices of the shells, the outer one first, then those of its voids.
    pub shells: Vec<u32>,
}

/// The boundary representation of a part, generic over the geometry of vertices (`P`), edges (`C`) and faces (`S`).
///
/// The lists do not force validity (bad geometry is data): [`check`](Self::check) tells which rules are broken.
#[derive(Debug, Clone, PartialEq)]
pub struct Model<P = (), C = (), S = ()> {
    /// The vertices.
    pub vertices: Vec<Vertex<P>>,
    /// The edges.
    pub edges: Vec<Edge<C>>,
    /// The faces.
    pub faces: Vec<Face<S>>,
    /// The shells.
    pub shells: Vec<Shell>,
    /// The solids.
    pub solids: Vec<Solid>,
    /// Names of faces, as the user sees them; [`Face::label`] points here.
    pub names: Vec<String>,
    /// Named sets of names: indices into [`names`](Self::names).
    pub groups: Vec<Group>,
}

impl<P, C, S> Default for Model<P, C, S> {
    fn default() -> Self {
        Self {
            vertices: Vec::new(),
            edges: Vec::new(),
            faces: Vec::new(),
            shells: Vec::new(),
            solids: Vec::new(),
            names: Vec::new(),
            groups: Vec::new(),
        }
    }
}

impl<P, C, S> Model<P, C, S> {
    /// Index of the vertex a coedge begins at (\[LAZ\] 4.2, `BegVertex`). The coedge's edge must exist.
    pub fn begins(&self, coedge: Coedge) -> u32 {
        self.edges[coedge.edge as usize].ends[usize::from(coedge.reversed)]
    }

    /// Index of the vertex a coedge ends at. The coedge's edge must exist.
    pub fn ends(&self, coedge: Coedge) -> u32 {
        self.edges[coedge.edge as usize].ends[usize::from(!coedge.reversed)]
    }

    /// For each edge the faces that run along it, ascending; a face that does so twice (a seam) is named twice.
    pub fn faces_of_edges(&self) -> Vec<Vec<u32>> {
        let mut faces = vec![Vec::new(); self.edges.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for coedge in face.loops.iter().flat_map(Loop::coedges) {
                if let Some(list) = faces.get_mut(coedge.edge as usize) {
                    list.push(f as u32);
                }
            }
        }
        faces
    }
}
