//! The fragments of a whole model, kept one after the other in a few arrays.
//!
//! Whoever reads them all goes through memory in order; whoever looks for one node or cell adds an offset. Nodes that a
//! fragment shares with others, and so does not number itself, stand apart from its own.

use glam::DVec3;

use crate::error::{Error, Result};

use super::cells::Cells;
use super::fragment::{BLOCK, CoedgeNodes, EdgeFragment, FaceFragment, FaceView, Form, NodeNumbers};

/// A part of an array. Two numbers of 32 bits: there are as many of these as fragments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct ArraySpan {
    start: u32,
    len: u32,
}

impl ArraySpan {
    #[inline]
    fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.start as usize + self.len as usize
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct EdgeRow {
    ends: [DVec3; 2],
    inner: ArraySpan,
    prints: [u64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct FaceRow {
    border: ArraySpan,
    inner: ArraySpan,
    form: Form,
    /// Whether its corners are among the short ones.
    short: bool,
    corners: ArraySpan,
    ends: ArraySpan,
    border_corners: ArraySpan,
    stretches: ArraySpan,
    loops: ArraySpan,
}

/// One fragment for every vertex, edge and face of a [`Model`](super::Model), in the model's order.
///
/// A fragment that is replaced by one of its own size stays where it is; a larger one goes to the end, and what it leaves
/// is taken back once half of the nodes are such leavings. Comparing two compares where things are kept, too.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fragments {
    /// Those of vertices together, the inner ones of chains and faces as they came.
    nodes: Vec<DVec3>,
    /// Faces' copies of the nodes on their borders.
    borders: Vec<DVec3>,
    corners: Vec<u32>,
    /// Of faces whose nodes are so few that 16 bits number them: half as much to read.
    short_corners: Vec<u16>,
    ends: Vec<u32>,
    border_corners: Vec<u32>,
    stretches: Vec<CoedgeNodes>,
    loops: Vec<u32>,
    vertices: ArraySpan,
    edges: Vec<EdgeRow>,
    faces: Vec<FaceRow>,
    /// Nodes and corners nobody uses any more.
    unused: usize,
}

/// Puts a list in the place of another, or at the end where it does not fit there.
fn put<T: Copy>(array: &mut Vec<T>, old: Option<ArraySpan>, list: &[T]) -> Result<ArraySpan> {
    if let Some(span) = old.filter(|s| s.len as usize == list.len()) {
        array[span.range()].copy_from_slice(list);
        return Ok(span);
    }
    let too_many = || Error::Failed("fragments have more nodes or corners than 32 bits can number".into());
    let end = u32::try_from(array.len() + list.len()).map_err(|_| too_many())?;
    array.extend_from_slice(list);
    Ok(ArraySpan { start: end - list.len() as u32, len: list.len() as u32 })
}

/// The corners of a face's cells that are on its border.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BorderCorners<'a> {
    list: &'a [u32],
    blocks: usize,
}

impl<'a> BorderCorners<'a> {
    /// Those of a block.
    #[inline]
    pub(crate) fn of_block(self, block: usize) -> &'a [u32] {
        let begin = if block == 0 { self.blocks } else { self.list[block - 1] as usize };
        &self.list[begin..self.list[block] as usize]
    }
}

impl Fragments {
    /// The nodes of a model's vertices, to which the fragments of edges and faces are added.
    pub fn new(vertices: Vec<DVec3>) -> Self {
        Self { vertices: ArraySpan { start: 0, len: vertices.len() as u32 }, nodes: vertices, ..Self::default() }
    }

    /// Adds the next edge's chain.
    ///
    /// # Errors
    /// [`Error::Failed`] for more nodes than 32 bits can number; then nothing is added.
    pub fn push_edge(&mut self, edge: &EdgeFragment) -> Result<()> {
        let inner = put(&mut self.nodes, None, edge.inner())?;
        self.edges.push(EdgeRow { ends: edge.ends(), inner, prints: edge.prints });
        Ok(())
    }

    /// Adds the next face's mesh.
    ///
    /// # Errors
    /// [`Error::Failed`] for more nodes or corners than 32 bits can number.
    pub fn push_face(&mut self, face: &FaceFragment) -> Result<()> {
        let row = self.put_face(None, face)?;
        self.faces.push(row);
        Ok(())
    }

    fn put_face(&mut self, old: Option<FaceRow>, face: &FaceFragment) -> Result<FaceRow> {
        let short = face.short();
        let kept = |of_short: bool| old.filter(|o| o.short == of_short).map(|o| o.corners);
        Ok(FaceRow {
            border: put(&mut self.borders, old.map(|o| o.border), &face.nodes[..face.border as usize])?,
            inner: put(&mut self.nodes, old.map(|o| o.inner), &face.nodes[face.border as usize..])?,
            form: face.form,
            short: short.is_some(),
            corners: match &short {
                Some(list) => put(&mut self.short_corners, kept(true), list)?,
                None => put(&mut self.corners, kept(false), &face.corners)?,
            },
            ends: put(&mut self.ends, old.map(|o| o.ends), &face.ends)?,
            border_corners: put(&mut self.border_corners, old.map(|o| o.border_corners), &face.border_corners)?,
            stretches: put(&mut self.stretches, old.map(|o| o.stretches), &face.stretches)?,
            loops: put(&mut self.loops, old.map(|o| o.loops), &face.loops)?,
        })
    }

    /// How many vertices, edges and faces there are.
    pub fn counts(&self) -> [usize; 3] {
        [self.vertices.len as usize, self.edges.len(), self.faces.len()]
    }

    /// The node of each vertex.
    pub fn vertices(&self) -> &[DVec3] {
        &self.nodes[self.vertices.range()]
    }

    /// The first and the last node of an edge's chain.
    ///
    /// # Panics
    /// Where there is no such edge.
    pub fn edge_ends(&self, edge: usize) -> [DVec3; 2] {
        self.edges[edge].ends
    }

    /// The nodes of an edge's chain without the first and the last (\[LAZ\] 4.1, `ExcludeBounds`), in the edge's direction.
    ///
    /// # Panics
    /// Where there is no such edge.
    pub fn edge_inner(&self, edge: usize) -> &[DVec3] {
        &self.nodes[self.edges[edge].inner.range()]
    }

    /// An edge's chain as a copy of its own.
    ///
    /// # Panics
    /// Where there is no such edge.
    pub fn edge(&self, edge: usize) -> EdgeFragment {
        let [first, last] = self.edge_ends(edge);
        let nodes = [&[first], self.edge_inner(edge), &[last]].concat();
        EdgeFragment { nodes, prints: self.edges[edge].prints }
    }

    pub(super) fn prints(&self, edge: usize) -> [u64; 2] {
        self.edges[edge].prints
    }

    /// The mesh of a face.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn face(&self, face: usize) -> FaceView<'_> {
        let row = &self.faces[face];
        FaceView {
            border: &self.borders[row.border.range()],
            inner: &self.nodes[row.inner.range()],
            form: row.form,
            corners: if row.short {
                NodeNumbers::Short(&self.short_corners[row.corners.range()])
            } else {
                NodeNumbers::Wide(&self.corners[row.corners.range()])
            },
            ends: &self.ends[row.ends.range()],
            border_corners: &self.border_corners[row.border_corners.range()],
            stretches: &self.stretches[row.stretches.range()],
            loops: &self.loops[row.loops.range()],
        }
    }

    /// The meshes of all faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceView<'_>> {
        (0..self.faces.len()).map(|f| self.face(f))
    }

    /// Replaces the node of a vertex and hands back the old one.
    ///
    /// # Panics
    /// Where there is no such vertex.
    pub fn set_vertex(&mut self, vertex: usize, node: DVec3) -> DVec3 {
        std::mem::replace(&mut self.nodes[self.vertices.range()][vertex], node)
    }

    /// Replaces an edge's chain and hands back the old one.
    ///
    /// # Errors
    /// As [`push_edge`](Self::push_edge); then nothing has changed.
    ///
    /// # Panics
    /// Where there is no such edge.
    pub fn set_edge(&mut self, edge: usize, with: &EdgeFragment) -> Result<EdgeFragment> {
        let (row, old) = (self.edges[edge], self.edge(edge));
        let inner = put(&mut self.nodes, Some(row.inner), with.inner())?;
        self.edges[edge] = EdgeRow { ends: with.ends(), inner, prints: with.prints };
        self.leave(if inner == row.inner { 0 } else { row.inner.len as usize });
        Ok(old)
    }

    /// Replaces a face's mesh and hands back the old one. Whether the new one is node-matched is not asked here.
    ///
    /// # Errors
    /// As [`push_face`](Self::push_face); then nothing has changed.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn set_face(&mut self, face: usize, with: &FaceFragment) -> Result<FaceFragment> {
        let old = self.face(face).to_fragment();
        let row = self.faces[face];
        match self.put_face(Some(row), with) {
            Ok(new) => {
                self.faces[face] = new;
                let left = |a: ArraySpan, b: ArraySpan| if a == b { 0 } else { a.len as usize };
                let corners =
                    if row.short == new.short { left(row.corners, new.corners) } else { row.corners.len as usize };
                self.leave(left(row.inner, new.inner) + corners);
                Ok(old)
            }
            Err(error) => {
                // what fits has been written over
                self.faces[face] = self.put_face(Some(row), &old)?;
                Err(error)
            }
        }
    }

    /// Lets `change` move a face's inner nodes.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn move_inner(&mut self, face: usize, change: impl FnMut(&mut DVec3)) {
        self.nodes[self.faces[face].inner.range()].iter_mut().for_each(change);
    }

    /// Adds nodes of vertices after those there are, all of which move: the cost follows from the number of vertices.
    ///
    /// # Errors
    /// [`Error::Failed`] for more nodes than 32 bits can number; then nothing is added.
    pub fn push_vertices(&mut self, nodes: &[DVec3]) -> Result<()> {
        if nodes.is_empty() {
            return Ok(());
        }
        let (old, all) = (self.vertices, [self.vertices(), nodes].concat());
        self.vertices = put(&mut self.nodes, None, &all)?;
        self.leave(old.len as usize);
        Ok(())
    }

    /// Takes a face away; those after it move up by one.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn remove_face(&mut self, face: usize) -> FaceFragment {
        let old = self.face(face).to_fragment();
        let row = self.faces.remove(face);
        self.leave(row.inner.len as usize + row.corners.len as usize);
        old
    }

    /// Takes the last face away.
    pub fn pop_face(&mut self) -> Option<FaceFragment> {
        let last = self.faces.len().checked_sub(1)?;
        Some(self.remove_face(last))
    }

    /// Keeps the vertices and edges that are marked; the others go, and those after them move up. What has no mark goes.
    pub(crate) fn keep(&mut self, vertices: &[bool], edges: &[bool]) {
        let marked = |marks: &[bool], i: usize| marks.get(i).copied().unwrap_or(false);
        let nodes = self.vertices().iter().enumerate();
        let kept: Vec<DVec3> = nodes.filter(|(v, _)| marked(vertices, *v)).map(|x| *x.1).collect();
        let mut left = self.vertices.len as usize - kept.len();
        self.vertices.len = kept.len() as u32;
        self.nodes[self.vertices.range()].copy_from_slice(&kept);
        let mut e = 0;
        self.edges.retain(|row| {
            let stays = marked(edges, e);
            e += 1;
            left += if stays { 0 } else { row.inner.len as usize };
            stays
        });
        self.leave(left);
    }

    /// Counts what nobody uses, and packs when that is half of all.
    fn leave(&mut self, count: usize) {
        self.unused += count;
        if 2 * self.unused <= self.nodes.len() + self.corners.len() + self.short_corners.len() {
            return;
        }
        let mut packed = Fragments::new(self.vertices().to_vec());
        let all = (|| {
            (0..self.edges.len()).try_for_each(|e| packed.push_edge(&self.edge(e)))?;
            self.faces().try_for_each(|face| packed.push_face(&face.to_fragment()))
        })();
        // packed is smaller, so it fits
        if all.is_ok() {
            *self = packed;
        }
    }

    // ------------------------------------------------------------------------------------- for those who read by offsets

    /// All nodes but those on the borders of faces, those nobody uses any more included.
    #[inline]
    pub(crate) fn pool(&self) -> &[DVec3] {
        &self.nodes
    }

    /// All stored corners in 32 and in 16 bits, those nobody uses any more included.
    #[inline]
    pub(crate) fn corner_pools(&self) -> (&[u32], &[u16]) {
        (&self.corners, &self.short_corners)
    }

    /// Whether a face's corners are in the pool of 16 bits.
    pub(crate) fn is_short(&self, face: usize) -> bool {
        self.faces[face].short
    }

    /// Where an edge's first inner node stands in the [`pool`](Self::pool), and how many there are.
    pub(crate) fn edge_span(&self, edge: usize) -> [u32; 2] {
        let span = self.edges[edge].inner;
        [span.start, span.len]
    }

    /// Where a face's inner nodes stand in the [`pool`](Self::pool), how many they are, how many are on the border; where
    /// its cells' corners stand in their [pool](Self::corner_pools).
    pub(crate) fn face_span(&self, face: usize) -> [u32; 4] {
        let row = &self.faces[face];
        [row.inner.start, row.inner.len, row.border.len, row.corners.start]
    }

    /// Which corners of a face's cells are on the border, block by block; `None` where that is not listed. See
    /// [`BLOCK`](super::fragment::BLOCK).
    #[inline]
    pub(crate) fn border_corners(&self, face: usize) -> Option<BorderCorners<'_>> {
        let row = &self.faces[face];
        let size = match row.form {
            Form::Triangles => 3,
            Form::Quads => 4,
            Form::Polygons | Form::Grid(_) => return None,
        };
        let list = &self.border_corners[row.border_corners.range()];
        let blocks = (row.corners.len as usize).div_ceil(size * BLOCK);
        (list.len() >= blocks).then_some(BorderCorners { list, blocks })
    }

    /// Where the nodes of vertices stand in the [`pool`](Self::pool).
    pub(crate) fn vertex_start(&self) -> u32 {
        self.vertices.start
    }

    /// How many cells a face has.
    pub(crate) fn cell_count(&self, face: usize) -> usize {
        let row = &self.faces[face];
        match row.form {
            Form::Triangles => row.corners.len as usize / 3,
            Form::Quads => row.corners.len as usize / 4,
            Form::Polygons => row.ends.len as usize,
            Form::Grid(size) => Cells::Grid(size).len(),
        }
    }
}
