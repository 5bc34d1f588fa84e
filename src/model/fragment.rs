//! Mesh fragments: the chain of an edge, the surface mesh of a face.
//!
//! A face's fragment is complete in itself: nodes on its border are its own copies. Which of them are the same node as
//! those of its edges follows from the order in which they stand along the loops, never from distances. That they do
//! agree is known without looking at them again: each fragment carries a fingerprint of every stretch of its border,
//! taken when the fragment was made or moved, so fragments are compared stretch by stretch, not node by node.
//!
//! *References.* \[LAZ\] section 3, with the correction that `INN(n_b) = 0`.

use glam::DVec3;

use crate::error::{Error, Place, Result};

use super::cells::{BorderNodes, Cells};

/// A fingerprint of nodes in a row. Equal rows have equal prints; different ones the same with a chance of 2⁻⁶⁴.
pub(super) fn print<'a>(nodes: impl Iterator<Item = &'a DVec3>) -> u64 {
    /// Odd and far from regular: the golden ratio's fraction.
    const MIX: u64 = 0x9e37_79b9_7f4a_7c15;
    nodes.flat_map(|p| p.to_array()).fold(1, |print: u64, x| {
        // 0 and -0 are one place
        let h = (print ^ (x + 0.0).to_bits()).wrapping_mul(MIX);
        h ^ h >> 29
    })
}

/// The nodes of an edge from its first vertex to its last, both included.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeFragment {
    pub(super) nodes: Vec<DVec3>,
    /// Of the nodes in order, and in reverse.
    pub(super) prints: [u64; 2],
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

    pub(super) fn inner(&self) -> &[DVec3] {
        &self.nodes[1..self.nodes.len() - 1]
    }

    pub(super) fn ends(&self) -> [DVec3; 2] {
        [self.nodes[0], self.nodes[self.nodes.len() - 1]]
    }
}

/// The border nodes of a face along one coedge, the last one left to the next coedge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoedgeNodes {
    pub(super) nodes: u32,
    pub(super) print: u64,
}

/// Cells are renumbered so many at a time, all corners alike, then those on the border one by one: of triangles and
/// quadrilaterals a fragment keeps, for each block of so many cells, which of the block's corners are on the border, and
/// which border nodes they are, both in one number.
pub(crate) const BLOCK: usize = 512;

/// A block has no more corners than this.
pub(crate) const BLOCK_CORNERS: usize = 4 * BLOCK;

/// How far a border node's number is shifted to make room for the corner's place in its block.
pub(crate) const PLACE_SHIFT: u32 = BLOCK_CORNERS.ilog2();

/// Borders of more nodes are not listed.
const LARGEST_PLACE: u32 = 1 << (32 - PLACE_SHIFT);

/// How the corners of a fragment's cells are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Triangles,
    Quads,
    Polygons,
    Grid([u32; 2]),
}

/// The mesh of a face as it is made, before it goes into [`Fragments`](super::Fragments).
///
/// Nodes are kept in the order border, inner, whatever order they came in: those on the border along the loops, each loop
/// beginning with the first vertex of its first coedge, then the others. Where a loop passes a node twice (along a seam,
/// at a pole) there are two, at the same point.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceFragment {
    pub(super) nodes: Vec<DVec3>,
    pub(super) border: u32,
    pub(super) form: Form,
    pub(super) corners: Vec<u32>,
    pub(super) ends: Vec<u32>,
    /// For whoever renumbers cells: see [`BLOCK`].
    pub(super) border_corners: Vec<u32>,
    pub(super) stretches: Vec<CoedgeNodes>,
    /// Where the stretches of each loop end.
    pub(super) loops: Vec<u32>,
}

/// Numbers of nodes, in as few bits as hold them.
#[derive(Debug, Clone, Copy)]
pub(super) enum NodeNumbers<'a> {
    Wide(&'a [u32]),
    Short(&'a [u16]),
}

impl NodeNumbers<'_> {
    fn to_vec(self) -> Vec<u32> {
        match self {
            NodeNumbers::Wide(list) => list.to_vec(),
            NodeNumbers::Short(list) => list.iter().map(|v| u32::from(*v)).collect(),
        }
    }
}

impl PartialEq for NodeNumbers<'_> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (NodeNumbers::Short(a), NodeNumbers::Short(b)) => a == b,
            (a, b) => a.to_vec() == b.to_vec(),
        }
    }
}

/// The mesh of a face as it is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceView<'a> {
    pub(super) border: &'a [DVec3],
    pub(super) inner: &'a [DVec3],
    pub(super) form: Form,
    pub(super) corners: NodeNumbers<'a>,
    pub(super) ends: &'a [u32],
    pub(super) border_corners: &'a [u32],
    pub(super) stretches: &'a [CoedgeNodes],
    pub(super) loops: &'a [u32],
}

impl<'a> FaceView<'a> {
    /// Its copies of the nodes on its border, BN, in the order of the loops: the first of the numbers its cells use.
    #[inline]
    pub fn border(self) -> &'a [DVec3] {
        self.border
    }

    /// The nodes that are not on its border, IN: the numbers that follow.
    #[inline]
    pub fn inner(self) -> &'a [DVec3] {
        self.inner
    }

    /// All its nodes by their numbers.
    pub fn nodes(self) -> impl Iterator<Item = &'a DVec3> {
        self.border.iter().chain(self.inner)
    }

    /// Its cells.
    #[inline]
    pub fn cells(self) -> Cells<'a> {
        cells(self.form, self.corners, self.ends)
    }

    /// How many border nodes each coedge of each loop takes, in the order of the loops; 1 for a loop that is a vertex.
    pub fn stretches(self) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.stretches.iter().map(|s| s.nodes)
    }

    /// A copy of its own.
    pub fn to_fragment(self) -> FaceFragment {
        FaceFragment {
            nodes: [self.border, self.inner].concat(),
            border: self.border.len() as u32,
            form: self.form,
            corners: self.corners.to_vec(),
            ends: self.ends.to_vec(),
            border_corners: self.border_corners.to_vec(),
            stretches: self.stretches.to_vec(),
            loops: self.loops.to_vec(),
        }
    }
}

fn cells<'a>(form: Form, corners: NodeNumbers<'a>, ends: &'a [u32]) -> Cells<'a> {
    match (form, corners) {
        (Form::Triangles, NodeNumbers::Wide(corners)) => Cells::Triangles(corners.as_chunks().0),
        (Form::Quads, NodeNumbers::Wide(corners)) => Cells::Quads(corners.as_chunks().0),
        (Form::Triangles, NodeNumbers::Short(corners)) => Cells::ShortTriangles(corners.as_chunks().0),
        (Form::Quads, NodeNumbers::Short(corners)) => Cells::ShortQuads(corners.as_chunks().0),
        (Form::Polygons, NodeNumbers::Wide(corners)) => Cells::Polygons { ends, corners },
        // never kept short
        (Form::Polygons, NodeNumbers::Short(_)) => Cells::Polygons { ends: &[], corners: &[] },
        (Form::Grid(size), _) => Cells::Grid(size),
    }
}

impl FaceFragment {
    /// A fragment of these nodes and cells, whose corners are numbered like `nodes`.
    ///
    /// `loops` tells for each loop of the face how many *segments* the face has along each of its coedges; an empty list
    /// stands for a loop that is a vertex and takes one border node.
    ///
    /// # Errors
    /// [`Error::Input`] naming the cell or loop, for corners that do not exist, cells of fewer than three, a grid whose
    /// nodes are not as many as its size says, coedges without segments, and a border whose length is not that of the
    /// loops.
    pub fn new(nodes: Vec<DVec3>, cells: Cells, boundary: &BorderNodes, loops: &[impl AsRef<[u32]>]) -> Result<Self> {
        check_cells(cells, nodes.len())?;
        check_boundary(boundary, cells, nodes.len())?;
        let (form, ends) = match cells {
            Cells::Triangles(_) | Cells::ShortTriangles(_) => (Form::Triangles, Vec::new()),
            Cells::Quads(_) | Cells::ShortQuads(_) => (Form::Quads, Vec::new()),
            Cells::Polygons { ends, .. } => (Form::Polygons, ends.to_vec()),
            Cells::Grid(size) => (Form::Grid(size), Vec::new()),
        };
        let corners = cells.stored().map(|v| boundary.place(v)).collect();
        let nodes = match boundary {
            BorderNodes::First(_) => nodes,
            other => (0..nodes.len() as u32).map(|place| nodes[other.node(place) as usize]).collect(),
        };
        let border = boundary.len() as u32;
        let mut fragment = Self {
            nodes,
            border,
            form,
            corners,
            ends,
            border_corners: Vec::new(),
            stretches: Vec::new(),
            loops: Vec::new(),
        };
        let mut needed = 0u64;
        for (l, segments) in loops.iter().enumerate() {
            let segments = segments.as_ref();
            if segments.contains(&0) {
                let place = Place::Item(format!("loop {l}"));
                return Err(Error::input(place, "a coedge has no segment; even a pole has one"));
            }
            let list = if segments.is_empty() { &[1] } else { segments };
            fragment.stretches.extend(list.iter().map(|n| CoedgeNodes { nodes: *n, print: 0 }));
            fragment.loops.push(fragment.stretches.len() as u32);
            needed += list.iter().map(|n| u64::from(*n)).sum::<u64>();
        }
        if needed != u64::from(border) {
            return Err(Error::input(Place::Unknown, format!("{border} border nodes, but the loops have {needed}")));
        }
        take_prints(&fragment.nodes, &fragment.loops, &mut fragment.stretches);
        fragment.find_border_corners();
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
        Self::new(nodes, Cells::Grid(cells), &BorderNodes::Grid(cells), &[segments])
    }

    /// What there is to read.
    pub fn view(&self) -> FaceView<'_> {
        let (border, inner) = self.nodes.split_at(self.border as usize);
        FaceView {
            border,
            inner,
            form: self.form,
            corners: NodeNumbers::Wide(&self.corners),
            ends: &self.ends,
            border_corners: &self.border_corners,
            stretches: &self.stretches,
            loops: &self.loops,
        }
    }

    /// Lets `change` move the nodes.
    pub fn move_nodes(&mut self, change: impl FnOnce(&mut [DVec3])) {
        change(&mut self.nodes);
        take_prints(&self.nodes, &self.loops, &mut self.stretches);
    }

    /// Removes what is left of cells around a pole: of border nodes at exactly one point a cell keeps the first, and a
    /// cell of fewer than three corners goes. Returns how many went.
    pub fn collapse_poles(&mut self) -> usize {
        let view = self.view();
        let cells = view.cells();
        let mut ends = Vec::with_capacity(cells.len());
        let mut corners: Vec<u32> = Vec::new();
        for j in 0..cells.len() {
            let begin = corners.len();
            for v in cells.corners(j).as_ref() {
                let same = |w: &u32| {
                    let both = (*v).max(*w) < self.border;
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
        let gone = cells.len() - ends.len();
        let whole = |n: usize| corners.len() == n * ends.len();
        self.form = match () {
            () if whole(3) => Form::Triangles,
            () if whole(4) && gone > 0 => Form::Quads,
            () if whole(4) => return 0,
            () => Form::Polygons,
        };
        self.ends = if self.form == Form::Polygons { ends } else { Vec::new() };
        self.corners = corners;
        self.find_border_corners();
        gone
    }

    /// The corners in 16 bits, where cells are even and that is enough for all of them.
    pub(super) fn short(&self) -> Option<Vec<u16>> {
        if self.nodes.len() > 1 << 16 || !matches!(self.form, Form::Triangles | Form::Quads) {
            return None;
        }
        Some(self.corners.iter().map(|v| *v as u16).collect())
    }

    fn find_border_corners(&mut self) {
        self.border_corners.clear();
        let size = match self.form {
            Form::Triangles => 3,
            Form::Quads => 4,
            Form::Polygons | Form::Grid(_) => return,
        };
        let blocks = self.corners.chunks(size * BLOCK);
        if self.border > LARGEST_PLACE {
            return;
        }
        // where the lists of the blocks end, then the lists
        self.border_corners.resize(blocks.len(), 0);
        for (b, block) in blocks.enumerate() {
            let border = block.iter().zip(0..).filter(|(place, _)| **place < self.border);
            self.border_corners.extend(border.map(|(place, k)| place << PLACE_SHIFT | k));
            self.border_corners[b] = self.border_corners.len() as u32;
        }
    }
}

fn take_prints(nodes: &[DVec3], loops: &[u32], stretches: &mut [CoedgeNodes]) {
    let at = |place: u32| &nodes[place as usize];
    let mut begin = 0;
    let mut first = 0;
    for end in loops {
        let list = &mut stretches[first..*end as usize];
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

fn check_cells(cells: Cells, nodes: usize) -> Result<()> {
    let bad = |j: usize, what: String| Err(Error::input(Place::Item(format!("cell {j}")), what));
    let mut corners = cells.stored();
    let count = corners.len();
    if nodes.max(count) >= u32::MAX as usize {
        let message = format!("{nodes} nodes and {count} corners are more than a fragment can hold");
        return Err(Error::input(Place::Unknown, message));
    }
    let size = match cells {
        Cells::Triangles(_) | Cells::ShortTriangles(_) => 3,
        Cells::Quads(_) | Cells::ShortQuads(_) => 4,
        Cells::Polygons { ends, corners } => {
            let beyond = |list: &[u32]| list.iter().position(|v| *v as usize >= nodes);
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
            if begin as usize != corners.len() {
                return bad(ends.len(), format!("{} corners belong to no cell", corners.len() - begin as usize));
            }
            return Ok(());
        }
        Cells::Grid([a, b]) => {
            let expected = (u64::from(a) + 1) * (u64::from(b) + 1);
            if a == 0 || b == 0 || expected != nodes as u64 {
                let message = format!("a grid of {a} by {b} cells does not have {nodes} nodes");
                return Err(Error::input(Place::Unknown, message));
            }
            return Ok(());
        }
    };
    match corners.position(|v| v as usize >= nodes) {
        Some(k) => bad(k / size, format!("it uses a node that does not exist; there are {nodes}")),
        None => Ok(()),
    }
}

fn check_boundary(boundary: &BorderNodes, cells: Cells, nodes: usize) -> Result<()> {
    let fits = match (boundary, cells) {
        (BorderNodes::Grid(size), Cells::Grid(other)) => *size == other,
        // whose nodes must stand as their rows do
        (BorderNodes::Grid(_), _) | (_, Cells::Grid(_)) => false,
        (BorderNodes::First(n), _) => *n as usize <= nodes,
        (BorderNodes::Listed { nodes: list, places, border }, _) => {
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
