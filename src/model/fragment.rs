//! Mesh fragments: the nodes of a vertex, the chain of an edge, the surface mesh of a face.
//!
//! A face's fragment is complete in itself: nodes on its border are its own copies. Which of them are the same node as
//! those of its edges follows from the order in which they stand along the loops, never from distances. That they do
//! agree is known without looking at them again: each fragment carries a fingerprint of every stretch of its border,
//! taken when the fragment was made or moved, so fragments are compared stretch by stretch, not node by node.
//!
//! *References.* \[LAZ\] section 3, with the correction that `INN(n_b) = 0`.

use std::ops::Range;

use glam::DVec3;

use crate::error::{Error, Place, Result};

use super::cells::{Boundary, Cells};

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
    nodes: Vec<DVec3>,
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
    #[inline]
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// The nodes without the first and the last (\[LAZ\] 4.1, `ExcludeBounds`); none for an edge of one segment.
    #[inline]
    pub fn inner(&self) -> &[DVec3] {
        &self.nodes[1..self.nodes.len() - 1]
    }

    /// How many segments it has, at least one.
    pub fn segments(&self) -> usize {
        self.nodes.len() - 1
    }
}

/// The border nodes of a face along one coedge, the last one left to the next coedge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub(super) nodes: u32,
    pub(super) print: u64,
}

/// The mesh of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceFragment {
    nodes: Vec<DVec3>,
    cells: Cells,
    boundary: Boundary,
    pub(super) stretches: Vec<Stretch>,
    /// Where the stretches of each loop end.
    pub(super) loops: Vec<u32>,
    /// See [`border_corners`](FaceFragment::border_corners).
    border_corners: Vec<[u32; 2]>,
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
        let mut fragment =
            Self { nodes, cells, boundary, stretches: Vec::new(), loops: Vec::new(), border_corners: Vec::new() };
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
        Self::new(nodes, Cells::Grid(cells), Boundary::Grid(cells), &[segments])
    }

    /// Its own nodes, copies of those on its border included.
    #[inline]
    pub fn nodes(&self) -> &[DVec3] {
        &self.nodes
    }

    /// Its cells.
    #[inline]
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// Which nodes are on its border.
    #[inline]
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// How many nodes are not on its border, |IN|.
    pub fn inner_count(&self) -> usize {
        self.nodes.len() - self.boundary.len()
    }

    /// The corners of cells that are on the border: where they stand in the list of all corners, ascending, and their
    /// places there ([`Boundary::place`]); none for a grid, whose corners are not listed.
    ///
    /// Whoever renumbers cells treats these one by one and all others alike.
    pub fn border_corners(&self) -> &[[u32; 2]] {
        &self.border_corners
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

    /// Lets `change` move each inner node; those on the border stay.
    pub fn move_inner(&mut self, mut change: impl FnMut(&mut DVec3)) {
        for place in self.boundary.len() as u32..self.nodes.len() as u32 {
            change(&mut self.nodes[self.boundary.node(place) as usize]);
        }
    }

    /// Hands inner nodes `range`, counted without those on the border, to `take`: as many at a time as stand together.
    ///
    /// # Errors
    /// The first one of `take`.
    pub fn read_inner(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        let border = self.boundary.len();
        if let Boundary::First(_) = self.boundary {
            return take(&self.nodes[border + range.start..border + range.end]);
        }
        let node = |i: usize| self.boundary.node((border + i) as u32) as usize;
        let mut i = range.start;
        while i < range.end {
            let first = node(i);
            let together = (i..range.end).take_while(|k| node(*k) == first + (k - i)).count();
            take(&self.nodes[first..first + together])?;
            i += together;
        }
        Ok(())
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
        self.find_border_corners();
        gone
    }

    fn find_border_corners(&mut self) {
        let corners = match &self.cells {
            Cells::Triangles(list) => list.as_flattened(),
            Cells::Quads(list) => list.as_flattened(),
            Cells::Polygons { corners, .. } => corners,
            Cells::Grid(_) => &[],
        };
        let border = self.boundary.len() as u32;
        let places = corners.iter().enumerate().map(|(at, v)| [at as u32, self.boundary.place(*v)]);
        self.border_corners = places.filter(|[_, place]| *place < border).collect();
        self.border_corners.shrink_to_fit();
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

fn check_cells(cells: &Cells, nodes: usize) -> Result<()> {
    let bad = |j: usize, what: String| Err(Error::input(Place::Item(format!("cell {j}")), what));
    let beyond = |list: &[u32]| list.iter().position(|v| *v as usize >= nodes);
    let corners = match cells {
        Cells::Triangles(list) => 3 * list.len(),
        Cells::Quads(list) => 4 * list.len(),
        Cells::Polygons { corners, .. } => corners.len(),
        Cells::Grid(_) => 0,
    };
    if nodes.max(corners) >= u32::MAX as usize {
        let message = format!("{nodes} nodes and {corners} corners are more than a fragment can hold");
        return Err(Error::input(Place::Unknown, message));
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
