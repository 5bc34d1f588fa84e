//! A merged mesh that is read piece by piece.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::file::{BrickPiece, NONE, NodeId, Store, Which};
use crate::error::{Error, Place, Result};
use crate::mesh::portion::Portion;
use crate::mesh::{CellRun, Group, MeshView, TriMesh};
use crate::spatial::Aabb;

/// Triangles of pieces that are kept at hand, beyond one piece.
const AT_HAND: usize = 1 << 16;

/// Triangles handed to a reader at a time.
const RUN: usize = 1 << 12;

/// What one piece has of the merged mesh.
pub(super) struct Span {
    pub(super) which: Which,
    /// The first node and the first triangle that come from it.
    pub(super) first: Firsts,
    /// How many nodes come from it; others it shares with earlier pieces.
    pub(super) nodes: usize,
    pub(super) cells: usize,
    pub(super) bounds: Aabb,
}

/// The first node and the first triangle of a piece in the merged mesh.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Firsts {
    pub(super) node: u32,
    pub(super) cell: u32,
}

/// The triangles of a piece that stay. `number` gives the number of a node with a name, a new node's if it has none
/// yet; where it knows no such name there is no portion.
pub(super) fn portion(
    piece: &BrickPiece,
    first: Firsts,
    number: &mut dyn FnMut(NodeId, u32) -> Option<u32>,
) -> Option<Portion> {
    let known: FxHashMap<u32, NodeId> = piece.known.iter().copied().collect();
    let mut p = Portion { first: first.cell, ..Portion::default() };
    let mut local = vec![NONE; piece.nodes.len()];
    let mut fresh = first.node;
    for t in &piece.triangles {
        for &v in t {
            if local[v as usize] != NONE {
                continue;
            }
            local[v as usize] = p.nodes.len() as u32;
            let name = known.get(&v);
            let n = name.map_or(Some(fresh), |id| number(*id, fresh))?;
            fresh += u32::from(n == fresh);
            p.nodes.push(n);
            p.shared.push(name.is_some());
            p.mesh.nodes.push(piece.nodes[v as usize]);
        }
        p.mesh.triangles.push(t.map(|v| local[v as usize]));
    }
    p.mesh.labels.clone_from(&piece.faces);
    Some(p)
}

/// A portion at hand.
pub(super) struct Loaded {
    pub(super) portion: Portion,
    /// The nodes that come from it, ascending.
    own: Vec<u32>,
}

/// The merged mesh of a plan's pieces, of which a few are in memory at a time.
///
/// It is read in order at the cost of reading each piece once. Nodes that pieces share stay in memory.
pub struct PiecewiseMesh<'a> {
    pub(super) store: Store<'a>,
    /// Names of faces, and groups.
    pub(super) names: TriMesh,
    /// The face of each of the plan's faces.
    pub(super) labels: Vec<u32>,
    pub(super) spans: Vec<Span>,
    /// The numbers of shared nodes.
    pub(super) numbers: FxHashMap<NodeId, u32>,
    /// Where they are.
    pub(super) places: FxHashMap<u32, DVec3>,
    /// The last ones that were asked for.
    pub(super) at_hand: Mutex<Vec<HandedOut>>,
    /// Why a node could not be read.
    pub(super) broken: Mutex<Option<Error>>,
}

/// A portion and which span it is of.
pub(super) struct HandedOut {
    span: usize,
    loaded: Arc<Loaded>,
}

impl PiecewiseMesh<'_> {
    /// A copy in arrays.
    ///
    /// # Errors
    /// Pieces that cannot be read.
    pub fn collected(&self) -> Result<TriMesh> {
        let mut mesh = self.names.clone();
        mesh.nodes.reserve_exact(self.node_count());
        mesh.triangles.reserve_exact(self.cell_count());
        mesh.labels.reserve_exact(self.cell_count());
        for s in 0..self.spans.len() {
            let loaded = self.loaded(s)?;
            let p = &loaded.portion;
            mesh.nodes.extend(loaded.own.iter().map(|v| p.mesh.nodes[*v as usize]));
            mesh.triangles.extend(p.mesh.triangles.iter().map(|t| t.map(|v| p.nodes[v as usize])));
            mesh.labels.extend_from_slice(&p.mesh.labels);
        }
        Ok(mesh)
    }

    /// The portion of a span.
    ///
    /// Errors: a piece that is gone, damaged or not the one that was merged.
    pub(super) fn loaded(&self, span: usize) -> Result<Arc<Loaded>> {
        let mut at_hand = self.at_hand.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(k) = at_hand.iter().position(|h| h.span == span) {
            let last = at_hand.len() - 1;
            at_hand[k..].rotate_left(1);
            return Ok(at_hand[last].loaded.clone());
        }
        // Room is made before a piece is read: never more than one is in memory beside what stays at hand.
        let size = |h: &HandedOut| h.loaded.portion.mesh.triangles.len();
        while at_hand.iter().map(size).sum::<usize>() + self.spans[span].cells > AT_HAND && !at_hand.is_empty() {
            at_hand.remove(0);
        }
        let loaded = Arc::new(self.load(&self.spans[span])?);
        at_hand.push(HandedOut { span, loaded: loaded.clone() });
        Ok(loaded)
    }

    fn load(&self, span: &Span) -> Result<Loaded> {
        let changed = || {
            let what = format!("{} changed while it was merged", span.which.name());
            Error::input(Place::Unknown, what).in_file(self.store.name())
        };
        let piece = self.store.load(span.which)?.ok_or_else(changed)?;
        let mut number = |id: NodeId, _| self.numbers.get(&id).copied();
        let mut portion = portion(&piece, span.first, &mut number).ok_or_else(changed)?;
        for l in &mut portion.mesh.labels {
            *l = self.labels.get(*l as usize).copied().filter(|l| *l != NONE).ok_or_else(changed)?;
        }
        let own: Vec<u32> =
            (0..portion.nodes.len() as u32).filter(|v| portion.nodes[*v as usize] >= span.first.node).collect();
        if own.len() != span.nodes || portion.mesh.triangles.len() != span.cells {
            return Err(changed());
        }
        Ok(Loaded { portion, own })
    }

    /// Which span a node comes from.
    fn span_of(&self, node: usize) -> usize {
        self.spans.partition_point(|s| s.first.node as usize <= node).saturating_sub(1)
    }

    fn broken(&self) -> Result<()> {
        self.broken.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// The spans that have some of a range, by the range each has, with what they have of it from their own start on.
    fn parts(&self, range: Range<usize>, of: impl Fn(&Span) -> Range<usize>) -> Vec<Stretch> {
        let part = |span: usize| {
            let all = of(&self.spans[span]);
            let (lo, hi) = (range.start.max(all.start), range.end.min(all.end));
            (lo < hi).then(|| Stretch { span, range: lo - all.start..hi - all.start })
        };
        (0..self.spans.len()).filter_map(part).collect()
    }
}

/// Some of what a span has.
struct Stretch {
    span: usize,
    range: Range<usize>,
}

impl MeshView for PiecewiseMesh<'_> {
    fn node_count(&self) -> usize {
        self.spans.last().map_or(0, |s| s.first.node as usize + s.nodes)
    }

    fn cell_count(&self) -> usize {
        self.spans.last().map_or(0, |s| s.first.cell as usize + s.cells)
    }

    fn face_names(&self) -> &[String] {
        &self.names.faces
    }

    fn groups(&self) -> &[Group] {
        &self.names.groups
    }

    /// Node `i`. One whose piece cannot be read is not a number, and the next reading of nodes or cells fails.
    fn node(&self, i: usize) -> DVec3 {
        let span = self.span_of(i);
        if let Some(p) = self.places.get(&(i as u32)) {
            return *p;
        }
        match self.loaded(span) {
            Ok(l) => {
                let own = i.checked_sub(self.spans[span].first.node as usize).and_then(|k| l.own.get(k));
                own.map_or(DVec3::NAN, |v| l.portion.mesh.nodes[*v as usize])
            }
            Err(e) => {
                *self.broken.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
                DVec3::NAN
            }
        }
    }

    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        let of = |s: &Span| s.first.node as usize..s.first.node as usize + s.nodes;
        let mut nodes: Vec<DVec3> = Vec::with_capacity(RUN);
        for Stretch { span, range } in self.parts(range, of) {
            self.broken()?;
            let loaded = self.loaded(span)?;
            for own in loaded.own[range].chunks(RUN) {
                nodes.clear();
                nodes.extend(own.iter().map(|v| loaded.portion.mesh.nodes[*v as usize]));
                take(&nodes)?;
            }
        }
        self.broken()
    }

    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()> {
        let of = |s: &Span| s.first.cell as usize..s.first.cell as usize + s.cells;
        let mut corners: Vec<u32> = Vec::with_capacity(3 * RUN);
        for Stretch { span, range } in self.parts(range, of) {
            self.broken()?;
            let loaded = self.loaded(span)?;
            let p = &loaded.portion;
            let mut at = range.start;
            for labels in p.mesh.labels[range].chunk_by(|a, b| a == b).flat_map(|l| l.chunks(RUN)) {
                corners.clear();
                let triangles = &p.mesh.triangles[at..at + labels.len()];
                corners.extend(triangles.iter().flatten().map(|v| p.nodes[*v as usize]));
                take(CellRun::even(p.first as usize + at, labels[0], &corners, 3))?;
                at += labels.len();
            }
        }
        self.broken()
    }
}
