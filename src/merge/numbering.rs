//! Global numbers of nodes and cells, as prefix sums over fragments.

use crate::error::{Error, Result};
use crate::model::{Cells, Fragments, Loop, Model};

use super::sets::{Progression, Unions};

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

/// How the cells of a face are found and numbered.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FaceAccess {
    /// Where its corners stand among those of all fragments.
    pub(super) corners: u32,
    /// How many corners each cell has; 0 where they differ or are not stored.
    pub(super) size: u32,
    /// What to add to the number an inner node has in the fragment, to wrap around.
    pub(super) shift: u32,
    /// How many of the fragment's nodes are on its border.
    pub(super) border: u32,
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
    /// For each face its border's global numbers: `bounds` of 4.2.
    pub(super) bounds: Unions,
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
        self.places.push(0);
        for e in 0..edges {
            self.places.push(fragments.edge_span(e)[0].wrapping_sub(self.nodes.start(1 + e) as u32));
        }
        self.faces.clear();
        for f in 0..faces {
            let [first, _, border, corners] = fragments.face_span(f);
            let start = self.nodes.start(1 + edges + f) as u32;
            self.places.push(first.wrapping_sub(start));
            let size = match fragments.face(f).cells() {
                Cells::Triangles(_) => 3,
                Cells::Quads(_) => 4,
                Cells::Polygons { .. } | Cells::Grid(_) => 0,
            };
            self.faces.push(FaceAccess { corners, size, shift: start.wrapping_sub(border), border });
        }
        self.bounds.clear();
        for face in &model.faces {
            for border in &face.loops {
                match border {
                    Loop::Vertex(v) => self.bounds.join(*v, Progression::ascending(0, 0)),
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
                            self.bounds.join(begin, if c.reversed { inner.reverse() } else { inner });
                        }
                    }
                }
            }
            self.bounds.finish();
        }
        Ok(())
    }
}
