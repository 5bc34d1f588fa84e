//! Global numbers of nodes and cells, as prefix sums over fragments.

use crate::error::{Error, Result};
use crate::model::{Fragments, Loop, Model};

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
    /// Lays stretches of these lengths one after the other from `first` on; `None` beyond what a `u32` can number.
    fn lay(&mut self, first: usize, lengths: impl Iterator<Item = usize>) -> Option<()> {
        self.starts.clear();
        let mut end = u32::try_from(first).ok()?;
        self.starts.push(end);
        for length in lengths {
            end = end.checked_add(u32::try_from(length).ok()?)?;
            self.starts.push(end);
        }
        // So many that most entries' numbers fall into two stretches at most.
        let entries = 4 * self.starts.len() as u64;
        let first = u64::from(self.starts[0]);
        self.shift = ((u64::from(end) - first) / entries).checked_ilog2().map_or(0, |l| l + 1);
        self.guide.clear();
        let mut k = 0;
        for i in (first..=u64::from(end)).step_by(1 << self.shift) {
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
        let bucket = (i - self.start(0)) >> self.shift;
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

/// The functions of \[LAZ\] section 4 for one model with its fragments.
#[derive(Debug, Clone, Default)]
pub(super) struct Numbering {
    /// Where the inner nodes of each edge begin, after one node per vertex.
    pub(super) edges: Starts,
    /// Where the inner nodes of each face begin, after those of the edges.
    pub(super) faces: Starts,
    /// Where the cells of each face begin: `s` of 4.3.
    pub(super) cells: Starts,
    /// For each face its border's global numbers: `bounds` of 4.2.
    pub(super) bounds: Unions,
}

impl Numbering {
    /// Numbers node-matched fragments anew; memory is kept.
    pub(super) fn renew<P, C, S>(&mut self, model: &Model<P, C, S>, fragments: &Fragments) -> Result<()> {
        let too_many = |what| Error::Failed(format!("the merged mesh has more {what} than 32 bits can number"));
        // A pole's nodes are all its vertex.
        let chain = |(e, edge): (usize, &crate::model::EdgeFragment)| {
            if model.edges[e].pole { 0 } else { edge.inner().len() }
        };
        let chains = fragments.edges.iter().enumerate().map(chain);
        self.edges.lay(fragments.vertices.len(), chains).ok_or_else(|| too_many("nodes"))?;
        self.faces
            .lay(self.edges.end(), fragments.faces.iter().map(|f| f.inner_count()))
            // the largest number is left free as a mark
            .filter(|()| self.faces.end() < u32::MAX as usize)
            .ok_or_else(|| too_many("nodes"))?;
        self.cells.lay(0, fragments.faces.iter().map(|f| f.cells().len())).ok_or_else(|| too_many("cells"))?;
        self.bounds.clear();
        for face in &model.faces {
            for border in &face.loops {
                match border {
                    Loop::Vertex(v) => self.bounds.join(Progression::ascending(*v, 1)),
                    Loop::Edges(list) => {
                        for c in list {
                            let begin = model.begins(*c);
                            self.bounds.join(Progression::ascending(begin, 1));
                            let e = c.edge as usize;
                            let chain = fragments.edges[e].nodes().len() as u32;
                            let inner = if model.edges[e].pole {
                                Progression { first: begin, len: chain, step: 0 }.exclude_bounds()
                            } else {
                                // as if the chain were numbered in a row, its ends too
                                let first = (self.edges.start(e) as u32).wrapping_sub(1);
                                Progression::ascending(first, chain).exclude_bounds()
                            };
                            self.bounds.join(if c.reversed { inner.reverse() } else { inner });
                        }
                    }
                }
            }
            self.bounds.finish();
        }
        Ok(())
    }
}
