//! Cells of a face's fragment, and which of its nodes are on its border.
//!
//! *References.* \[LAZ\] section 3, with the correction that `INN(n_b) = 0`.

use crate::error::{Error, Place, Result};

/// Cells of a face by its fragment's own node numbers, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cells<'a> {
    /// Three nodes each.
    Triangles(&'a [[u32; 3]]),
    /// Four nodes each.
    Quads(&'a [[u32; 4]]),
    /// Three nodes each, in numbers of 16 bits: how [`Fragments`](super::Fragments) keep the triangles of faces with at
    /// most 65 536 nodes, as half the memory is read in half the time.
    ShortTriangles(&'a [[u16; 3]]),
    /// Four nodes each, likewise.
    ShortQuads(&'a [[u16; 4]]),
    /// Three or more: cell `j` has `corners[ends[j - 1]..ends[j]]`, the first begins at 0.
    Polygons {
        /// Where each cell's corners end.
        ends: &'a [u32],
        /// Node numbers.
        corners: &'a [u32],
    },
    /// A structured block of this many quadrilaterals along its two directions, with nothing stored: cell `(i, j)` has
    /// the number `i + j n₀` and the nodes `(i, j)` to `(i + 1, j + 1)`, whose places [`BorderNodes::Grid`] computes.
    Grid([u32; 2]),
}

/// The corners of one cell.
#[derive(Debug, Clone, Copy)]
pub enum Corners<'a> {
    /// As they are stored.
    Stored(&'a [u32]),
    /// Read from shorter numbers.
    Triangle([u32; 3]),
    /// The same, or computed.
    Quad([u32; 4]),
}

impl AsRef<[u32]> for Corners<'_> {
    #[inline]
    fn as_ref(&self) -> &[u32] {
        match self {
            Corners::Stored(list) => list,
            Corners::Triangle(list) => list,
            Corners::Quad(list) => list,
        }
    }
}

impl<'a> Cells<'a> {
    /// How many there are.
    pub fn len(self) -> usize {
        match self {
            Cells::Triangles(list) => list.len(),
            Cells::Quads(list) => list.len(),
            Cells::ShortTriangles(list) => list.len(),
            Cells::ShortQuads(list) => list.len(),
            Cells::Polygons { ends, .. } => ends.len(),
            Cells::Grid([a, b]) => a as usize * b as usize,
        }
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// All corners, one cell after the other; none for a grid, whose corners are computed.
    pub fn stored(self) -> impl ExactSizeIterator<Item = u32> + 'a {
        let (wide, short): (&[u32], &[u16]) = match self {
            Cells::Triangles(list) => (list.as_flattened(), &[]),
            Cells::Quads(list) => (list.as_flattened(), &[]),
            Cells::ShortTriangles(list) => (&[], list.as_flattened()),
            Cells::ShortQuads(list) => (&[], list.as_flattened()),
            Cells::Polygons { corners, .. } => (corners, &[]),
            Cells::Grid(_) => (&[], &[]),
        };
        (0..wide.len() + short.len()).map(move |k| wide.get(k).copied().unwrap_or_else(|| u32::from(short[k])))
    }

    /// The corners of cell `j`.
    ///
    /// # Panics
    /// Where `j` is not below [`len`](Self::len), as a slice does.
    #[inline]
    pub fn corners(self, j: usize) -> Corners<'a> {
        match self {
            Cells::Triangles(list) => Corners::Stored(&list[j]),
            Cells::Quads(list) => Corners::Stored(&list[j]),
            Cells::ShortTriangles(list) => Corners::Triangle(list[j].map(u32::from)),
            Cells::ShortQuads(list) => Corners::Quad(list[j].map(u32::from)),
            Cells::Polygons { ends, corners } => {
                let begin = if j == 0 { 0 } else { ends[j - 1] as usize };
                Corners::Stored(&corners[begin..ends[j] as usize])
            }
            Cells::Grid([a, b]) => {
                assert!(j < a as usize * b as usize, "cell {j} of a grid of {a} by {b}");
                let row = a as usize;
                let first = (j % row + j / row * (row + 1)) as u32;
                let above = first + a + 1;
                Corners::Quad([first, first + 1, above + 1, above].map(|v| BorderNodes::Grid([a, b]).place(v)))
            }
        }
    }
}

/// Which of the nodes a face is made of are on its border: \[LAZ\]'s sets BN, IN, BNN and INN, as functions wherever
/// there is one. A fragment keeps them in the order border, inner, so its own sets always are.
#[derive(Debug, Clone, PartialEq)]
pub enum BorderNodes {
    /// The first so many, in the order of the loops.
    First(u32),
    /// The border of a [`Cells::Grid`] of so many cells, one loop from node (0, 0) along the first direction.
    Grid([u32; 2]),
    /// Anywhere: made by [`BorderNodes::listed`].
    Listed {
        /// Nodes in the order border, inner: BN followed by IN.
        nodes: Vec<u32>,
        /// The inverse: where each node stands in `nodes`.
        places: Vec<u32>,
        /// How many are on the border.
        border: u32,
    },
}

impl BorderNodes {
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
        Ok(BorderNodes::Listed { nodes, places, border })
    }

    /// How many nodes are on the border, |BN|.
    #[inline]
    pub fn len(&self) -> usize {
        match self {
            BorderNodes::First(n) | BorderNodes::Listed { border: n, .. } => *n as usize,
            BorderNodes::Grid([a, b]) => 2 * (*a as usize + *b as usize),
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
            BorderNodes::First(_) => node,
            BorderNodes::Listed { places, .. } => places[node as usize],
            BorderNodes::Grid([a, b]) => {
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
            BorderNodes::First(_) => place,
            BorderNodes::Listed { nodes, .. } => nodes[place as usize],
            BorderNodes::Grid([a, b]) => {
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

fn bad_node(node: u32, what: &str) -> Error {
    Error::input(Place::Item(format!("node {node}")), format!("it {what}"))
}
