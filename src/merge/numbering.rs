//! Global numbers of nodes and cells, as prefix sums over fragments.

use crate::error::{Error, Result};
use crate::model::{Cells, Fragments, Loop, Model};

use super::sets::{Place, Progression, Unions};

/// Ascending starts of consecutive stretches, and a guide into them: which stretch a number falls into.
#[derive(Debug, Clone, Default)]
pub(super) struct Starts {
    /// One more than there are stretches; the last is where all end.
    starts: Vec<u32>,
    /// For every `1 << shift` numbers the stretch the first of them falls into.
    guide: Vec<u32>,
    shift: u32,
}

impl Starts {
    /// Lays stretches of these lengths one after the other; `None` beyond what a `u32` can number.
    pub(super) fn lay(&mut self, lengths: impl Iterator<Item = usize>) -> Option<()> {
        self.starts.clear();
        let mut end = 0u32;
        self.starts.push(end);
        for length in lengths {
            end = end.checked_add(u32::try_from(length).ok()?)?;
            self.starts.push(end);
        }
        // So many that most entries' numbers fall into two stretches at most.
        let entries = 4 * self.starts.len() as u64;
        self.shift = (u64::from(end) / entries).checked_ilog2().map_or(0, |l| l + 1);
        self.guide.clear();
        let mut k = 0;
        for i in (0..=u64::from(end)).step_by(1 << self.shift) {
            while k + 1 < self.len() && u64::from(self.starts[k + 1]) <= i {
                k += 1;
            }
            self.guide.push(k as u32);
        }
        self.guide.push(self.len().saturating_sub(1) as u32);
        Some(())
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    #[inline]
    pub(super) fn start(&self, k: usize) -> usize {
        self.starts[k] as usize
    }

    #[inline]
    pub(super) fn end(&self) -> usize {
        self.starts.last().map_or(0, |e| *e as usize)
    }

    /// A stretch near the one that holds `i`, not after it.
    #[inline]
    pub(super) fn guess(&self, i: usize) -> usize {
        self.guide[i >> self.shift] as usize
    }

    /// The stretch that holds `i`, which must be one of their numbers.
    #[inline]
    pub(super) fn find(&self, i: usize) -> usize {
        let bucket = i >> self.shift;
        let mut k = self.guide[bucket] as usize;
        // one step without a branch, which nobody could predict, is enough nearly always
        k += usize::from(self.starts[k + 1] as usize <= i);
        if self.starts[k + 1] as usize <= i {
            let last = self.guide[bucket + 1] as usize;
            k += self.starts[k + 1..=last].partition_point(|s| *s as usize <= i);
        }
        k
    }
}

/// How the cells of a face are found and numbered: half a line of the cache.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(32))]
pub(super) struct FaceAccess {
    /// Where its cells end in the merged mesh.
    pub(super) end: u32,
    /// How many corners each cell has; 0 where they differ or are not stored.
    pub(super) size: u16,
    /// Whether its corners are among those of 16 bits.
    pub(super) short: bool,
    /// What to add to `size` times a cell's number for the place of its corners among those of all fragments, to wrap around.
    corners: u32,
    /// What to add to the number an inner node has in the fragment, to wrap around.
    pub(super) shift: u32,
    /// How many of the fragment's nodes are on its border.
    pub(super) border: u32,
    /// Where the face's union stands in `l2g`.
    pub(super) union: Place,
}

impl FaceAccess {
    /// Where the corners of cell `j` of the merged mesh begin.
    #[inline]
    pub(super) fn corners_of(&self, j: usize) -> usize {
        self.corners.wrapping_add(u32::from(self.size).wrapping_mul(j as u32)) as usize
    }
}

/// The functions of \[LAZ\] section 4 for one model with its fragments.
#[derive(Debug, Clone, Default)]
pub(super) struct Numbering {
    /// Stretches of nodes that are kept together: those of all vertices, the inner ones of each edge, those of each face.
    pub(super) nodes: Starts,
    /// For each stretch what to add to a node's number for its place among those of all fragments, to wrap around.
    pub(super) places: Vec<u32>,
    /// Where the cells of each face begin: `s` of 4.3.
    pub(super) cells: Starts,
    pub(super) faces: Vec<FaceAccess>,
    /// For each face its nodes' global numbers: the union of `bounds`, those of its border, and of its inner nodes (4.2).
    pub(super) l2g: Unions,
}

impl Numbering {
    /// Numbers node-matched fragments anew; memory is kept.
    pub(super) fn renew<P, C, S>(&mut self, model: &Model<P, C, S>, fragments: &Fragments) -> Result<()> {
        let too_many = |what| Error::Failed(format!("the merged mesh has more {what} than 32 bits can number"));
        let [vertices, edges, faces] = fragments.counts();
        // A pole's nodes are all its vertex.
        let chain = |e: usize| if model.edges[e].pole { 0 } else { fragments.edge_span(e)[1] as usize };
        let inner = |f: usize| fragments.face_span(f)[1] as usize;
        self.nodes
            .lay(std::iter::once(vertices).chain((0..edges).map(chain)).chain((0..faces).map(inner)))
            // the largest number is left free as a mark
            .filter(|()| self.nodes.end() < u32::MAX as usize)
            .ok_or_else(|| too_many("nodes"))?;
        self.cells.lay((0..faces).map(|f| fragments.cell_count(f))).ok_or_else(|| too_many("cells"))?;
        self.places.clear();
        self.places.push(fragments.vertex_start());
        for e in 0..edges {
            self.places.push(fragments.edge_span(e)[0].wrapping_sub(self.nodes.start(1 + e) as u32));
        }
        self.faces.clear();
        for f in 0..faces {
            let [first, _, border, corners] = fragments.face_span(f);
            let start = self.nodes.start(1 + edges + f) as u32;
            self.places.push(first.wrapping_sub(start));
            let size = match fragments.face(f).cells() {
                Cells::Triangles(_) | Cells::ShortTriangles(_) => 3,
                Cells::Quads(_) | Cells::ShortQuads(_) => 4,
                Cells::Polygons { .. } | Cells::Grid(_) => 0,
            };
            let (cells, end) = (self.cells.start(f), self.cells.start(f + 1));
            self.faces.push(FaceAccess {
                end: end as u32,
                size,
                short: fragments.is_short(f),
                corners: corners.wrapping_sub(u32::from(size).wrapping_mul(cells as u32)),
                shift: start.wrapping_sub(border),
                border,
                union: Place::default(),
            });
        }
        self.l2g.clear();
        for (f, face) in model.faces.iter().enumerate() {
            for border in &face.loops {
                match border {
                    Loop::Vertex(v) => self.l2g.join(*v, Progression::ascending(0, 0)),
                    Loop::Edges(list) => {
                        for c in list {
                            let begin = model.begins(*c);
                            let e = c.edge as usize;
                            let chain = fragments.edge_span(e)[1] + 2;
                            let inner = if model.edges[e].pole {
                                Progression { first: begin, len: chain, step: 0 }.exclude_bounds()
                            } else {
                                // as if the chain were numbered in a row, its ends too
                                let first = (self.nodes.start(1 + e) as u32).wrapping_sub(1);
                                Progression::ascending(first, chain).exclude_bounds()
                            };
                            self.l2g.join(begin, if c.reversed { inner.reverse() } else { inner });
                        }
                    }
                }
            }
            self.l2g.finish(self.nodes.start(1 + edges + f) as u32);
            self.faces[f].union = self.l2g.place(f);
        }
        Ok(())
    }

    /// The face a cell is on.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub(super) fn face_of(&self, j: usize) -> (usize, &FaceAccess) {
        let count = self.cells.end();
        assert!(j < count, "cell {j} of {count}");
        let mut f = self.cells.guess(j);
        f += usize::from(self.faces[f].end as usize <= j);
        if self.faces[f].end as usize <= j {
            f = self.cells.find(j);
        }
        (f, &self.faces[f])
    }
}
