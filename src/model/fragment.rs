//! Mesh fragments: the nodes of a vertex, the chain of an edge, the surface mesh of a face.
//!
//! A face's fragment is complete in itself: nodes on its border are its own copies. Which of them are the same node as
//! those of its edges follows from the order in which they stand along the loops, never from distances. That they do
//! agree is known without looking at them again: each fragment carries a fingerprint of every stretch of its border,
//! taken when the fragment was made or moved, so fragments are compared stretch by stretch, not node by node.
//!
//! *References.* [LAZ] section 3, with the correction that `INN(n_b) = 0`.

use std::fmt;

use glam::DVec3;

use crate::error::{Error, Place, Result};

use super::topology::{Loop, Model};

/// A fingerprint of nodes in a row. Equal rows have equal prints; different ones the same with a chance of 2⁻⁶⁴.
fn print<'a>(nodes: impl Iterator<Item = &'a DVec3>) -> u64 {
    /// Odd and far from regular: the golden ratio's fraction.
    const MIX: u64 = 0x9e37_79b9_7f4a_7c15;
    nodes.flat_map(|p| p.to_array()).fold(0, |print: u64, x| {
        // 0 and -0 are one place
        let h = (print ^ (x + 0.0).to_bits()).wrapping_mul(MIX);
        h ^ h >> 29
    })
}

/// The nodes of an edge from its first vertex to its last, both included.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeFragment {
    nodes: Vec<DVec3>,
    /// Of the nodes in order, and in reverse.
    prints: [u64; 2],
}

impl EdgeFragment {
    /// A chain of at least two nodes. A closed edge names its vertex first and last; a pole is one point many times.
    ///
    /// # Errors
    /// [`Error::Input`] for fewer than two nodes.
    pub fn new(nodes: Vec<DVec3>) -> Result<Self> {
        if nodes.len() < 2 {
            return Err(Error::input(
                Place::Unknown,
                format!("an edge's chain has 2 nodes or more, not {}", nodes.len()),
            ));
        }
        let prints = [print(nodes.iter()), print(nodes.iter().rev())];
        Ok(Self { nodes, prints })
    }

    /// All nodes in the edge's direction.
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// The nodes without the first and the last ([LAZ] 4.1, `ExcludeBounds`); none for an edge of one segment.
    pub fn inner(&self) -> &[DVec3] {
        &self.nodes[1..self.nodes.len() - 1]
    }

    /// How many segments it has, at least one.
    pub fn segments(&self) -> usize {
        self.nodes.len() - 1
    }
}

/// Cells of a face by its fragment's own node numbers, counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Three nodes each.
    Triangles(Vec<[u32; 3]>),
    /// Four nodes each.
    Quads(Vec<[u32; 4]>),
    /// Three or more: cell `j` has `corners[ends[j - 1]..ends[j]]`, the first begins at 0.
    Polygons {
        /// Where each cell's corners end.
        ends: Vec<u32>,
        /// Node numbers.
        corners: Vec<u32>,
    },
    /// A structured block of this many quadrilaterals along its two directions, with nothing stored: node `(i, j)` has
    /// the number `i + j (n₀ + 1)`, cell `(i, j)` the number `i + j n₀`.
    Grid([u32; 2]),
}

/// The corners of one cell.
#[derive(Debug, Clone, Copy)]
pub enum Corners<'a> {
    /// As they are stored.
    Stored(&'a [u32]),
    /// Computed.
    Quad([u32; 4]),
}

impl AsRef<[u32]> for Corners<'_> {
    fn as_ref(&self) -> &[u32] {
        match self {
            Corners::Stored(list) => list,
            Corners::Quad(list) => list,
        }
    }
}

impl Cells {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Cells::Triangles(list) => list.len(),
            Cells::Quads(list) => list.len(),
            Cells::Polygons { ends, .. } => ends.len(),
            Cells::Grid([a, b]) => *a as usize * *b as usize,
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The corners of cell `j`.
    ///
    /// # Panics
    /// Where `j` is not below [`len`](Self::len), as a slice does.
    pub fn corners(&self, j: usize) -> Corners<'_> {
        match self {
            Cells::Triangles(list) => Corners::Stored(&list[j]),
            Cells::Quads(list) => Corners::Stored(&list[j]),
            Cells::Polygons { ends, corners } => {
                let begin = if j == 0 { 0 } else { ends[j - 1] as usize };
                Corners::Stored(&corners[begin..ends[j] as usize])
            }
            Cells::Grid([a, b]) => {
                assert!(j < *a as usize * *b as usize, "cell {j} of a grid of {a} by {b}");
                let a = *a as usize;
                let first = (j % a + j / a * (a + 1)) as u32;
                let above = first + a as u32 + 1;
                Corners::Quad([first, first + 1, above + 1, above])
            }
        }
    }
}

/// Which of a face's nodes are on its border: [LAZ]'s sets BN, IN, BNN and INN, as functions wherever there is one.
#[derive(Debug, Clone, PartialEq)]
pub enum Boundary {
    /// The first so many, in the order of the loops.
    First(u32),
    /// The border of a [`Cells::Grid`] of so many cells, one loop from node (0, 0) along the first direction.
    Grid([u32; 2]),
    /// Anywhere: made by [`Boundary::listed`].
    Listed {
        /// Nodes in the order border, inner: BN followed by IN.
        nodes: Vec<u32>,
        /// The inverse: where each node stands in `nodes`.
        places: Vec<u32>,
        /// How many are on the border.
        border: u32,
    },
}

impl Boundary {
    /// Border nodes in the order of the loops, out of `count` nodes; the others are inner ones, in ascending order.
    ///
    /// # Errors
    /// [`Error::Input`] naming a node that does not exist or is named twice.
    pub fn listed(border: Vec<u32>, count: usize) -> Result<Self> {
        let mut places = vec![u32::MAX; count];
        for (x, v) in border.iter().enumerate() {
            match places.get_mut(*v as usize) {
                Some(place) if *place == u32::MAX => *place = x as u32,
                Some(_) => return Err(bad_node(*v, "stands on the border twice")),
                None => return Err(bad_node(*v, "is on the border, but does not exist")),
            }
        }
        let mut nodes = border;
        let border = nodes.len() as u32;
        for v in 0..count {
            if places[v] == u32::MAX {
                places[v] = nodes.len() as u32;
                nodes.push(v as u32);
            }
        }
        Ok(Boundary::Listed { nodes, places, border })
    }

    /// How many nodes are on the border, |BN|.
    pub fn len(&self) -> usize {
        match self {
            Boundary::First(n) | Boundary::Listed { border: n, .. } => *n as usize,
            Boundary::Grid([a, b]) => 2 * (*a as usize + *b as usize),
        }
    }

    /// Whether no node is on the border.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where a node stands when border nodes come first, in the order of the loops, and inner ones after them: BNN for
    /// places below [`len`](Self::len), INN plus that for the others.
    #[inline]
    pub fn place(&self, node: u32) -> u32 {
        match self {
            Boundary::First(_) => node,
            Boundary::Listed { places, .. } => places[node as usize],
            Boundary::Grid([a, b]) => {
                let (i, j) = (node % (a + 1), node / (a + 1));
                if j == 0 {
                    i
                } else if i == *a {
                    a + j
                } else if j == *b {
                    2 * a + b - i
                } else if i == 0 {
                    2 * (a + b) - j
                } else {
                    2 * (a + b) + (i - 1) + (j - 1) * (a - 1)
                }
            }
        }
    }

    /// The node at a place, the inverse of [`place`](Self::place): BN, followed by IN.
    #[inline]
    pub fn node(&self, place: u32) -> u32 {
        match self {
            Boundary::First(_) => place,
            Boundary::Listed { nodes, .. } => nodes[place as usize],
            Boundary::Grid([a, b]) => {
                let row = a + 1;
                if place < *a {
                    place
                } else if place < a + b {
                    a + (place - a) * row
                } else if place < 2 * a + b {
                    2 * a + b - place + b * row
                } else if place < 2 * (a + b) {
                    (2 * (a + b) - place) * row
                } else {
                    let x = place - 2 * (a + b);
                    1 + x % (a - 1) + (1 + x / (a - 1)) * row
                }
            }
        }
    }
}

/// The border nodes of a face along one coedge, the last one left to the next coedge.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    nodes: u32,
    print: u64,
}

/// The mesh of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceFragment {
    nodes: Vec<DVec3>,
    cells: Cells,
    boundary: Boundary,
    stretches: Vec<Stretch>,
    /// Where the stretches of each loop end.
    loops: Vec<u32>,
}

impl FaceFragment {
    /// A fragment of these nodes and cells.
    ///
    /// `loops` tells for each loop of the face how many *segments* the face has along each of its coedges; an empty list
    /// stands for a loop that is a vertex and takes one border node. Border nodes stand in the order of the loops, each
    /// beginning with the first vertex of its first coedge. Where a loop passes a node twice (along a seam, at a pole)
    /// the fragment has two nodes, at the same point.
    ///
    /// # Errors
    /// [`Error::Input`] naming the cell or loop, for corners that do not exist, cells of fewer than three, a grid whose
    /// nodes are not as many as its size says, coedges without segments, and a border whose length is not that of the
    /// loops.
    pub fn new(nodes: Vec<DVec3>, cells: Cells, boundary: Boundary, loops: &[impl AsRef<[u32]>]) -> Result<Self> {
        check_cells(&cells, nodes.len())?;
        check_boundary(&boundary, &cells, nodes.len())?;
        let mut fragment = Self { nodes, cells, boundary, stretches: Vec::new(), loops: Vec::new() };
        let mut border = 0u64;
        for (l, segments) in loops.iter().enumerate() {
            let segments = segments.as_ref();
            if segments.contains(&0) {
                let place = Place::Item(format!("loop {l}"));
                return Err(Error::input(place, "a coedge has no segment; even a pole has one"));
            }
            let list = if segments.is_empty() { &[1] } else { segments };
            fragment.stretches.extend(list.iter().map(|n| Stretch { nodes: *n, print: 0 }));
            fragment.loops.push(fragment.stretches.len() as u32);
            border += list.iter().map(|n| u64::from(*n)).sum::<u64>();
        }
        if border != fragment.boundary.len() as u64 {
            let there = fragment.boundary.len();
            return Err(Error::input(Place::Unknown, format!("{there} border nodes, but the loops have {border}")));
        }
        fragment.take_prints();
        Ok(fragment)
    }

    /// A structured block of `cells[0]` by `cells[1]` quadrilaterals; `nodes` row by row along the first direction.
    ///
    /// The face's one loop runs from node (0, 0) along the first direction, then along the second, and back;
    /// `segments` tells how many segments each coedge takes of it.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn grid(cells: [u32; 2], nodes: Vec<DVec3>, segments: &[u32]) -> Result<Self> {
        Self::new(nodes, Cells::Grid(cells), Boundary::Grid(cells), &[segments])
    }

    /// Its own nodes, copies of those on its border included.
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// Its cells.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// Which nodes are on its border.
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// How many nodes are not on its border, |IN|.
    pub fn inner_count(&self) -> usize {
        self.nodes.len() - self.boundary.len()
    }

    /// How many border nodes each coedge of each loop takes, in the order of the loops; 1 for a loop that is a vertex.
    pub fn stretches(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.stretches.iter().map(|s| s.nodes)
    }

    /// Lets `change` move the nodes.
    pub fn move_nodes(&mut self, change: impl FnOnce(&mut [DVec3])) {
        change(&mut self.nodes);
        self.take_prints();
    }

    /// Removes what is left of cells around a pole: of border nodes at exactly one point a cell keeps the first, and a
    /// cell of fewer than three corners goes. Returns how many went.
    pub fn collapse_poles(&mut self) -> usize {
        let mut ends = Vec::with_capacity(self.cells.len());
        let mut corners: Vec<u32> = Vec::new();
        let border = self.boundary.len() as u32;
        for j in 0..self.cells.len() {
            let begin = corners.len();
            for v in self.cells.corners(j).as_ref() {
                let same = |w: &u32| {
                    let both = self.boundary.place(*v) < border && self.boundary.place(*w) < border;
                    v == w || (both && self.nodes[*v as usize] == self.nodes[*w as usize])
                };
                if !corners[begin..].iter().any(same) {
                    corners.push(*v);
                }
            }
            if corners.len() < begin + 3 {
                corners.truncate(begin);
            } else {
                ends.push(corners.len() as u32);
            }
        }
        let gone = self.cells.len() - ends.len();
        let whole = |n: usize| corners.len() == n * ends.len();
        self.cells = if whole(3) {
            Cells::Triangles(corners.as_chunks().0.to_vec())
        } else if whole(4) && gone > 0 {
            Cells::Quads(corners.as_chunks().0.to_vec())
        } else if whole(4) {
            return 0;
        } else {
            Cells::Polygons { ends, corners }
        };
        gone
    }

    fn take_prints(&mut self) {
        let at = |place: u32| &self.nodes[self.boundary.node(place) as usize];
        let mut begin = 0;
        let mut first = 0;
        for end in &self.loops {
            let list = &mut self.stretches[first..*end as usize];
            let start = begin;
            let last = list.len() - 1;
            for (k, stretch) in list.iter_mut().enumerate() {
                let next = if k == last { start } else { begin + stretch.nodes };
                stretch.print = print((begin..begin + stretch.nodes).chain([next]).map(at));
                begin += stretch.nodes;
            }
            first = *end as usize;
        }
    }
}

fn bad_node(node: u32, what: &str) -> Error {
    Error::input(Place::Item(format!("node {node}")), format!("it {what}"))
}

fn check_cells(cells: &Cells, nodes: usize) -> Result<()> {
    let bad = |j: usize, what: String| Err(Error::input(Place::Item(format!("cell {j}")), what));
    let beyond = |list: &[u32]| list.iter().position(|v| *v as usize >= nodes);
    if nodes >= u32::MAX as usize {
        return Err(Error::input(Place::Unknown, format!("{nodes} nodes are more than a fragment can hold")));
    }
    let (outside, size) = match cells {
        Cells::Triangles(list) => (beyond(list.as_flattened()), 3),
        Cells::Quads(list) => (beyond(list.as_flattened()), 4),
        Cells::Polygons { ends, corners } => {
            let mut begin = 0;
            for (j, end) in ends.iter().enumerate() {
                if (*end as usize) > corners.len() || *end < begin || end - begin < 3 {
                    return bad(j, format!("its corners are {begin} to {end} of {}", corners.len()));
                }
                if let Some(k) = beyond(&corners[begin as usize..*end as usize]) {
                    let v = corners[begin as usize + k];
                    return bad(j, format!("it uses node {v}, but there are {nodes}"));
                }
                begin = *end;
            }
            (None, 1)
        }
        Cells::Grid([a, b]) => {
            let expected = (u64::from(*a) + 1) * (u64::from(*b) + 1);
            if *a == 0 || *b == 0 || expected != nodes as u64 {
                let message = format!("a grid of {a} by {b} cells does not have {nodes} nodes");
                return Err(Error::input(Place::Unknown, message));
            }
            (None, 1)
        }
    };
    match outside {
        Some(k) => bad(k / size, format!("it uses a node that does not exist; there are {nodes}")),
        None => Ok(()),
    }
}

fn check_boundary(boundary: &Boundary, cells: &Cells, nodes: usize) -> Result<()> {
    let fits = match boundary {
        Boundary::First(n) => *n as usize <= nodes,
        Boundary::Grid(size) => *cells == Cells::Grid(*size),
        Boundary::Listed { nodes: list, places, border } => {
            // the fields are public: the two lists need not be inverse to each other
            let inverse = |(x, v): (usize, &u32)| places.get(*v as usize) == Some(&(x as u32));
            list.len() == nodes
                && places.len() == nodes
                && *border as usize <= nodes
                && list.iter().enumerate().all(inverse)
        }
    };
    if fits { Ok(()) } else { Err(Error::input(Place::Unknown, format!("the border does not fit {nodes} nodes"))) }
}

/// One fragment for every vertex, edge and face of a [`Model`], in the model's order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fragments {
    /// The node of each vertex.
    pub vertices: Vec<DVec3>,
    /// The chain of each edge.
    pub edges: Vec<EdgeFragment>,
    /// The mesh of each face.
    pub faces: Vec<FaceFragment>,
}

/// Why fragments do not belong together. Loops and coedges are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Mismatch {
    /// Not one fragment per vertex, edge and face: how many of each the model has, and how many there are.
    Counts { model: [usize; 3], fragments: [usize; 3] },
    /// The edge's chain does not begin or end at the node of its vertex.
    EdgeEnd { edge: u32, vertex: u32 },
    /// The face has another number of loops, or of coedges in this loop, than its fragment.
    Loop { face: u32, index: u32 },
    /// The face has another number of segments along the edge than the edge has.
    Segments { face: u32, edge: u32, of_face: u32, of_edge: u32 },
    /// The nodes of face and edge are as many, but not at the same places.
    Nodes { face: u32, edge: u32 },
    /// The loop that is a vertex is not at the vertex's node.
    LoopVertex { face: u32, vertex: u32 },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Mismatch::Counts { model: [v, e, c], fragments: [a, b, d] } => write!(
                f,
                "the model has {v} vertices, {e} edges and {c} faces, but there are fragments for {a}, {b} and {d}"
            ),
            Mismatch::EdgeEnd { edge, vertex } => {
                write!(f, "edge {edge} does not begin and end at the nodes of its vertices (vertex {vertex})")
            }
            Mismatch::Loop { face, index } => {
                write!(f, "the fragment of face {face} has other coedges than the face in loop {index}")
            }
            Mismatch::Segments { face, edge, of_face, of_edge } => write!(
                f,
                "face {face} is not node-matched along edge {edge}: {of_face} segments of the face, {of_edge} of the edge"
            ),
            Mismatch::Nodes { face, edge } => {
                write!(f, "face {face} is not node-matched along edge {edge}: nodes are at different places")
            }
            Mismatch::LoopVertex { face, vertex } => {
                write!(f, "face {face} is not node-matched at vertex {vertex}: nodes are at different places")
            }
        }
    }
}

impl Fragments {
    /// Everything that keeps the fragments from being node-matched on the model, in the model's order.
    ///
    /// The model must have no [`Violation`](super::Violation) that [forbids merging](super::Violation::forbids_merge).
    /// The time is proportional to the model, whatever the number of nodes.
    pub fn mismatches<P, C, S>(&self, model: &Model<P, C, S>) -> Vec<Mismatch> {
        let counts = [model.vertices.len(), model.edges.len(), model.faces.len()];
        let there = [self.vertices.len(), self.edges.len(), self.faces.len()];
        if counts != there {
            return vec![Mismatch::Counts { model: counts, fragments: there }];
        }
        let mut found = Vec::new();
        for e in 0..model.edges.len() as u32 {
            self.mismatch_of_edge(model, e, &mut found);
        }
        for f in 0..model.faces.len() as u32 {
            self.mismatch_of_face(model, f, &mut found);
        }
        found
    }

    /// [`mismatches`](Self::mismatches) of one edge with its vertices. There must be a fragment for each.
    pub fn mismatch_of_edge<P, C, S>(&self, model: &Model<P, C, S>, edge: u32, found: &mut Vec<Mismatch>) {
        let nodes = &self.edges[edge as usize].nodes;
        for (v, p) in model.edges[edge as usize].ends.into_iter().zip([nodes[0], nodes[nodes.len() - 1]]) {
            if self.vertices[v as usize] != p {
                found.push(Mismatch::EdgeEnd { edge, vertex: v });
                return;
            }
        }
    }

    /// [`mismatches`](Self::mismatches) of one face with its edges. There must be a fragment for each.
    pub fn mismatch_of_face<P, C, S>(&self, model: &Model<P, C, S>, face: u32, found: &mut Vec<Mismatch>) {
        let fragment = &self.faces[face as usize];
        let loops = &model.faces[face as usize].loops;
        if loops.len() != fragment.loops.len() {
            let index = loops.len().min(fragment.loops.len()) as u32;
            found.push(Mismatch::Loop { face, index });
            return;
        }
        let mut first = 0;
        for (index, (border, end)) in loops.iter().zip(&fragment.loops).enumerate() {
            let stretches = &fragment.stretches[first..*end as usize];
            first = *end as usize;
            match border {
                Loop::Vertex(v) => {
                    let p = &self.vertices[*v as usize];
                    // a loop of one node is followed by itself
                    if stretches[0].print != print([p, p].into_iter()) || stretches.len() > 1 || stretches[0].nodes > 1
                    {
                        found.push(Mismatch::LoopVertex { face, vertex: *v });
                    }
                }
                Loop::Edges(list) if list.len() != stretches.len() => {
                    found.push(Mismatch::Loop { face, index: index as u32 });
                }
                Loop::Edges(list) => {
                    for (c, stretch) in list.iter().zip(stretches) {
                        let edge = &self.edges[c.edge as usize];
                        let (of_face, of_edge) = (stretch.nodes, edge.segments() as u32);
                        if of_face != of_edge {
                            found.push(Mismatch::Segments { face, edge: c.edge, of_face, of_edge });
                        } else if stretch.print != edge.prints[usize::from(c.reversed)] {
                            found.push(Mismatch::Nodes { face, edge: c.edge });
                        }
                    }
                }
            }
        }
    }
}
