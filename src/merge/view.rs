//! The merged mesh as a view of its fragments.

use std::ops::Range;

use glam::DVec3;
use multiversion::multiversion;

use crate::error::{Error, Place as Where, Result};
use crate::mesh::{CellRun, Group, MeshView};
use crate::model::{
    BLOCK, BLOCK_CORNERS, Cells, Corners, EdgeFragment, FaceFragment, Fragments, Loop, Mismatch, Model, PLACE_SHIFT,
    Violation,
};
use crate::numeric::NONE;

use super::numbering::{FaceAccess, Numbering};

/// Which fragment keeps a node, and the node's number there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The vertex.
    Vertex(u32),
    /// The edge, and which of its nodes, the first vertex counted.
    Edge(u32, u32),
    /// The face, and which of its fragment's nodes.
    Face(u32, u32),
}

/// Fragments that take the place of others: pairs of an index and what comes there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replacement {
    /// Nodes of vertices.
    pub vertices: Vec<(u32, DVec3)>,
    /// Chains of edges.
    pub edges: Vec<(u32, EdgeFragment)>,
    /// Meshes of faces.
    pub faces: Vec<(u32, FaceFragment)>,
}

/// Node-matched fragments on a model, readable as one mesh through [`MeshView`].
///
/// Random access takes a bounded search among fragments; [`read_nodes`](MeshView::read_nodes) and
/// [`read_cells`](MeshView::read_cells) search once per fragment. [`TriMesh::from_view`](crate::mesh::TriMesh::from_view)
/// copies the mesh to arrays.
#[derive(Debug, Clone)]
pub struct Merged<P = (), C = (), S = ()> {
    pub(super) model: Model<P, C, S>,
    pub(super) fragments: Fragments,
    numbering: Numbering,
}

impl<P, C, S> Merged<P, C, S> {
    /// Merges; the time is proportional to the model, and no fragment is copied.
    ///
    /// To keep the model where the answer may be no, ask [`Model::check`] and [`Fragments::mismatches`] first.
    ///
    /// # Errors
    /// [`Error::Input`] naming the place, for a model with a [`Violation`] that [forbids it](Violation::forbids_merge),
    /// and naming the edge for fragments that are not node-matched; [`Error::Failed`] for more nodes or cells than 32
    /// bits can number.
    pub fn new(model: Model<P, C, S>, fragments: Fragments) -> Result<Self> {
        if let Some(broken) = model.check().iter().find(|v| v.forbids_merge()) {
            return Err(refuse_model(broken));
        }
        if let Some(mismatch) = fragments.mismatches(&model).first() {
            return Err(refuse(mismatch));
        }
        let mut numbering = Numbering::default();
        numbering.renew(&model, &fragments)?;
        Ok(Self { model, fragments, numbering })
    }

    /// The model.
    pub fn model(&self) -> &Model<P, C, S> {
        &self.model
    }

    /// The fragments.
    pub fn fragments(&self) -> &Fragments {
        &self.fragments
    }

    /// Takes the two apart again.
    pub fn into_parts(self) -> (Model<P, C, S>, Fragments) {
        (self.model, self.fragments)
    }

    /// Where a node is kept.
    ///
    /// # Panics
    /// Where there is no such node.
    #[inline]
    pub fn place_of_node(&self, i: usize) -> Place {
        let count = self.numbering.nodes.end();
        assert!(i < count, "node {i} of {count}");
        let [_, edges, _] = self.fragments.counts();
        let k = self.numbering.nodes.find(i);
        let local = (i - self.numbering.nodes.start(k)) as u32;
        match k.checked_sub(1) {
            None => Place::Vertex(i as u32),
            Some(e) if e < edges => Place::Edge(e as u32, local + 1),
            Some(k) => Place::Face((k - edges) as u32, self.numbering.faces[k - edges].border + local),
        }
    }

    /// Which cell of which face's fragment a cell is (\[LAZ\] 4.3, `c2c`).
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn place_of_cell(&self, j: usize) -> (u32, usize) {
        let (f, _) = self.numbering.face_of(j);
        (f as u32, j - self.numbering.cells.start(f))
    }

    /// The index of the name of the face a cell is on.
    ///
    /// # Panics
    /// Where there is no such cell.
    pub fn label(&self, j: usize) -> u32 {
        self.model.faces[self.numbering.face_of(j).0].label
    }

    /// The number a node of a face's fragment has in the merged mesh (\[LAZ\] 4.2, `l2g`).
    ///
    /// # Panics
    /// Where there is no such face.
    #[inline]
    pub fn local_to_global(&self, face: u32, node: u32) -> u32 {
        self.numbering.l2g.get(face as usize, node)
    }

    /// With a branch, though near borders it is foreseen half of the time only: without one, three nodes are so much to do
    /// that the processor has fewer cells on their way from memory.
    #[inline]
    fn to_global(&self, access: &FaceAccess, node: u32) -> u32 {
        if node < access.border {
            self.numbering.l2g.get_of(access.union, node)
        } else {
            node.wrapping_add(access.shift)
        }
    }

    /// The corners of cell `j` as its fragment keeps them, if they are so many and in 16 bits.
    #[inline]
    fn short<const N: usize>(&self, access: &FaceAccess, j: usize) -> Option<[u32; N]> {
        if !access.short || usize::from(access.size) != N {
            return None;
        }
        let corners = self.fragments.corner_pools().1.get(access.corners_of(j)..)?;
        Some(corners.first_chunk::<N>()?.map(u32::from))
    }

    /// The corners of a cell, as numbers of the merged mesh's nodes.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn cell(&self, j: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        let (f, access) = self.numbering.face_of(j);
        let corners = if let Some(corners) = self.short(access, j) {
            Corners::Triangle(corners)
        } else if let Some(corners) = self.short(access, j) {
            Corners::Quad(corners)
        } else {
            self.fragments.face(f).cells().corners(j - self.numbering.cells.start(f))
        };
        let count = corners.as_ref().len();
        (0..count).map(move |k| self.to_global(access, corners.as_ref()[k]))
    }

    /// The corners of a cell where it is a triangle; [`cell`](Self::cell) takes any.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn triangle(&self, j: usize) -> Option<[u32; 3]> {
        let (f, access) = self.numbering.face_of(j);
        let corners = self.short(access, j).or_else(|| self.any_triangle(f, j))?;
        Some(corners.map(|v| self.to_global(access, v)))
    }

    /// The corners of a triangle as its fragment has them, however it keeps them.
    fn any_triangle(&self, f: usize, j: usize) -> Option<[u32; 3]> {
        let corners = self.fragments.face(f).cells().corners(j - self.numbering.cells.start(f));
        let [a, b, c] = *corners.as_ref() else { return None };
        Some([a, b, c])
    }

    /// Puts the corners of the given cells into `out`, which is emptied first: quicker than
    /// [`triangle`](Self::triangle) one by one, as memory is asked for many cells at a time. Cells that are no triangles
    /// give `u32::MAX` thrice.
    ///
    /// # Panics
    /// Where there is no such cell.
    pub fn triangles_at(&self, cells: &[u32], out: &mut Vec<[u32; 3]>) {
        /// Cells on their way at a time.
        const AHEAD: usize = 128;
        let faces = &self.numbering.faces;
        let mut face = [0u32; AHEAD];
        out.clear();
        out.reserve(cells.len());
        for part in cells.chunks(AHEAD) {
            // each loop short, so that the processor is in many rounds of it at once
            for (f, j) in face.iter_mut().zip(part) {
                *f = self.numbering.face_of(*j as usize).0 as u32;
            }
            let first = out.len();
            out.extend(part.iter().zip(&face).map(|(j, f)| {
                let (f, j) = (*f as usize, *j as usize);
                self.short(&faces[f], j).or_else(|| self.any_triangle(f, j)).unwrap_or([NONE; 3])
            }));
            for (corners, f) in out[first..].iter_mut().zip(&face) {
                if *corners != [NONE; 3] {
                    *corners = corners.map(|v| self.to_global(&faces[*f as usize], v));
                }
            }
        }
    }

    /// Moves the inner nodes of a face, which cannot part it from its neighbors. Numbers stay as they are.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn move_inner(&mut self, face: u32, change: impl FnMut(&mut DVec3)) {
        self.fragments.move_inner(face as usize, change);
    }

    /// Puts other fragments in place and returns those that were there.
    ///
    /// Faces are checked one by one; with them the cost is that of a few additions per fragment if the number of inner
    /// nodes or cells changed, and nothing otherwise. New chains or vertices check all fragments by their fingerprints.
    ///
    /// # Errors
    /// As [`new`](Self::new), and for an index that does not exist; then nothing has changed.
    pub fn replace(&mut self, mut with: Replacement) -> Result<Replacement> {
        let [v, e, f] = self.fragments.counts();
        let beyond = |what: &str, i: u32| Error::input(Where::Item(format!("{what} {i}")), "there is none to replace");
        if let Some((i, _)) = with.vertices.iter().find(|x| x.0 as usize >= v) {
            return Err(beyond("vertex", *i));
        }
        if let Some((i, _)) = with.edges.iter().find(|x| x.0 as usize >= e) {
            return Err(beyond("edge", *i));
        }
        if let Some((i, _)) = with.faces.iter().find(|x| x.0 as usize >= f) {
            return Err(beyond("face", *i));
        }
        // in its place a face keeps everybody's numbers
        let spans = |this: &Self, f: u32| (this.fragments.face_span(f as usize), this.fragments.cell_count(f as usize));
        let before: Vec<_> = with.faces.iter().map(|(f, _)| spans(self, *f)).collect();
        let faces_only = with.vertices.is_empty() && with.edges.is_empty();
        let result = self.swap(&mut with).and_then(|()| {
            let mut found = Vec::new();
            if faces_only {
                for (f, _) in &with.faces {
                    self.fragments.mismatch_of_face(&self.model, *f, &mut found);
                }
            } else {
                found = self.fragments.mismatches(&self.model);
            }
            match found.first() {
                Some(mismatch) => Err(refuse(mismatch)),
                // repeated indices make the comparison meaningless, a new numbering never is
                None if faces_only && with.faces.len() == 1 && spans(self, with.faces[0].0) == before[0] => Ok(()),
                None => self.renumber(),
            }
        });
        match result {
            Ok(()) => Ok(with),
            Err(error) => {
                // as it was, so it fits and can be numbered
                let _ = self.swap(&mut with).and_then(|()| self.renumber());
                Err(error)
            }
        }
    }

    pub(super) fn renumber(&mut self) -> Result<()> {
        self.numbering.renew(&self.model, &self.fragments)
    }

    /// Swaps fragments; in reverse order the second time, so that twice is as before whatever repeats.
    fn swap(&mut self, with: &mut Replacement) -> Result<()> {
        for (i, p) in &mut with.vertices {
            *p = self.fragments.set_vertex(*i as usize, *p);
        }
        for (i, e) in &mut with.edges {
            *e = self.fragments.set_edge(*i as usize, e)?;
        }
        for (i, f) in &mut with.faces {
            *f = self.fragments.set_face(*i as usize, f)?;
        }
        with.vertices.reverse();
        with.edges.reverse();
        with.faces.reverse();
        Ok(())
    }

    /// Hands out cells `range` of a face whose border numbers `room` holds.
    fn read_face(
        &self,
        face: usize,
        range: Range<usize>,
        room: &mut ReadingBuffers,
        take: &mut dyn FnMut(CellRun) -> Result<()>,
    ) -> Result<()> {
        let first = self.numbering.cells.start(face);
        let access = &self.numbering.faces[face];
        let label = self.model.faces[face].label;
        let mut begin = range.start;
        if let Some(border) = self.fragments.border_corners(face) {
            let (size, at) = (usize::from(access.size), access.corners_of(first));
            let (wide, short) = self.fragments.corner_pools();
            let count = access.end as usize - first;
            for b in begin / BLOCK..range.end.div_ceil(BLOCK) {
                let (start, end) = (b * BLOCK, range.end.min((b + 1) * BLOCK));
                let stored = at + size * start..at + size * count.min(start + BLOCK);
                if access.short {
                    add_short(&short[stored], access.shift, &mut room.block.0[..]);
                } else {
                    add(&wide[stored], access.shift, &mut room.block.0[..]);
                }
                put_border(border.of_block(b), &room.bounds, &mut room.block.0);
                let part = &room.block.0[size * (begin - start)..size * (end - start)];
                take(CellRun::even(first + begin, label, part, size))?;
                begin = end;
            }
            return Ok(());
        }
        let cells = self.fragments.face(face).cells();
        let number = |v: &u32| self.to_global(access, *v);
        while begin < range.end {
            let end = range.end.min(begin + BLOCK);
            room.corners.clear();
            room.ends.clear();
            for j in begin..end {
                room.corners.extend(cells.corners(j).as_ref().iter().map(number));
                room.ends.push(room.corners.len() as u32);
            }
            take(match cells {
                Cells::Triangles(_) | Cells::ShortTriangles(_) => CellRun::even(first + begin, label, &room.corners, 3),
                Cells::Quads(_) | Cells::ShortQuads(_) | Cells::Grid(_) => {
                    CellRun::even(first + begin, label, &room.corners, 4)
                }
                Cells::Polygons { .. } => CellRun::mixed(first + begin, label, &room.corners, &room.ends),
            })?;
            begin = end;
        }
        Ok(())
    }
}

/// Numbers that begin where a line of the cache does: eight of them, written and read at once, never cross one.
#[repr(align(64))]
struct NumberBlock([u32; BLOCK_CORNERS]);

/// What reading needs, kept from face to face.
struct ReadingBuffers {
    /// The face's border numbers, and room for [`USUAL`].
    bounds: Vec<u32>,
    block: Box<NumberBlock>,
    corners: Vec<u32>,
    ends: Vec<u32>,
}

impl ReadingBuffers {
    fn new() -> Self {
        Self {
            bounds: vec![0; USUAL],
            block: Box::new(NumberBlock([0; BLOCK_CORNERS])),
            corners: Vec::new(),
            ends: Vec::new(),
        }
    }
}

/// Puts the numbers of nodes on the border in their places in a block.
// alone it has the processor's registers for itself
#[inline(never)]
fn put_border(border: &[u32], bounds: &[u32], block: &mut [u32; BLOCK_CORNERS]) {
    // the remainder is the place itself, and tells the compiler that it is one
    let place = |x: u32| x as usize % BLOCK_CORNERS;
    match bounds.first_chunk::<USUAL>() {
        Some(usual) if bounds.len() == USUAL => {
            // eight are read before the first is written
            let (eights, rest) = border.as_chunks::<8>();
            for eight in eights {
                let numbers = eight.map(|x| usual[(x >> PLACE_SHIFT) as usize % USUAL]);
                (0..8).for_each(|k| block[place(eight[k])] = numbers[k]);
            }
            rest.iter().for_each(|x| block[place(*x)] = usual[(x >> PLACE_SHIFT) as usize % USUAL]);
        }
        _ => border.iter().for_each(|x| block[place(*x)] = bounds[(x >> PLACE_SHIFT) as usize]),
    }
}

/// Borders of fewer nodes are read without asking whether there is such a node.
const USUAL: usize = 1024;

/// Adds `shift` to each of as many numbers.
// no wider: 64 bytes at a time cross the lines of the cache each time and take twice as long
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add(from: &[u32], shift: u32, to: &mut [u32]) {
    for (x, v) in to.iter_mut().zip(from) {
        *x = v.wrapping_add(shift);
    }
}

/// The same, of short numbers.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add_short(from: &[u16], shift: u32, to: &mut [u32]) {
    for (x, v) in to.iter_mut().zip(from) {
        *x = u32::from(*v).wrapping_add(shift);
    }
}

pub(super) fn refuse_model(broken: &Violation) -> Error {
    Error::input(Where::Unknown, format!("the model cannot carry a mesh: {broken}"))
}

pub(super) fn refuse(mismatch: &Mismatch) -> Error {
    let place = match mismatch {
        Mismatch::EdgeEnd { edge, .. } | Mismatch::Segments { edge, .. } | Mismatch::Nodes { edge, .. } => {
            Where::Item(format!("edge {edge}"))
        }
        Mismatch::Loop { face, .. } => Where::Item(format!("face {face}")),
        Mismatch::LoopVertex { vertex, .. } => Where::Item(format!("vertex {vertex}")),
        Mismatch::Counts { .. } => Where::Unknown,
    };
    Error::input(place, mismatch.to_string())
}

impl<P: Sync, C: Sync, S: Sync> MeshView for Merged<P, C, S> {
    #[inline]
    fn node_count(&self) -> usize {
        self.numbering.nodes.end()
    }

    #[inline]
    fn cell_count(&self) -> usize {
        self.numbering.cells.end()
    }

    fn face_names(&self) -> &[String] {
        &self.model.names
    }

    fn groups(&self) -> &[Group] {
        &self.model.groups
    }

    #[inline]
    fn node(&self, i: usize) -> DVec3 {
        let Numbering { nodes, places, .. } = &self.numbering;
        let count = nodes.end();
        assert!(i < count, "node {i} of {count}");
        self.fragments.pool()[(i as u32).wrapping_add(places[nodes.find(i)]) as usize]
    }

    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        let Numbering { nodes, places, .. } = &self.numbering;
        assert!(range.start <= range.end && range.end <= nodes.end(), "nodes {range:?} of {}", nodes.end());
        let pool = self.fragments.pool();
        let mut at = range.start;
        let mut k = if range.is_empty() { 0 } else { nodes.find(at) };
        while at < range.end {
            // stretches that stand one after the other are one
            while nodes.start(k + 1) < range.end && places[k + 1] == places[k] {
                k += 1;
            }
            let end = nodes.start(k + 1).min(range.end);
            if at < end {
                let begin = (at as u32).wrapping_add(places[k]) as usize;
                take(&pool[begin..begin + end - at])?;
                at = end;
            }
            k += 1;
        }
        Ok(())
    }

    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()> {
        let cells = &self.numbering.cells;
        assert!(range.start <= range.end && range.end <= cells.end(), "cells {range:?} of {}", cells.end());
        if range.is_empty() {
            return Ok(());
        }
        let mut room = ReadingBuffers::new();
        for f in cells.find(range.start)..cells.len() {
            let (start, end) = (cells.start(f), cells.start(f + 1).min(range.end));
            if start >= range.end {
                break;
            }
            let begin = range.start.max(start);
            if begin < end {
                self.numbering.l2g.fill(f, &mut room.bounds);
                self.read_face(f, begin - start..end - start, &mut room, take)?;
            }
        }
        Ok(())
    }

    fn cells_of_faces(&self) -> Vec<Vec<Range<usize>>> {
        let mut ranges = vec![Vec::new(); self.model.names.len()];
        let cells = &self.numbering.cells;
        for (f, face) in self.model.faces.iter().enumerate() {
            crate::mesh::view::extend(&mut ranges[face.label as usize], cells.start(f)..cells.start(f + 1));
        }
        ranges
    }

    /// From the model: a fragment's inner nodes stand with its face, those of edges and vertices with the first face on
    /// them, used by a cell or not.
    fn nodes_of_faces(&self) -> Vec<Vec<Range<usize>>> {
        let [vertices, edges, _] = self.fragments.counts();
        let mut owner = vec![u32::MAX; vertices + edges];
        for face in &self.model.faces {
            let mut own = |i: usize| owner[i] = owner[i].min(face.label);
            for border in &face.loops {
                if let Loop::Vertex(v) = border {
                    own(*v as usize);
                }
                for c in border.coedges() {
                    own(self.model.begins(*c) as usize);
                    own(vertices + c.edge as usize);
                }
            }
        }
        let mut ranges = vec![Vec::new(); self.model.names.len()];
        let mut stand = |label: u32, range: Range<usize>| {
            if let Some(list) = ranges.get_mut(if label == u32::MAX { 0 } else { label as usize }) {
                crate::mesh::view::extend(list, range);
            }
        };
        for v in 0..vertices {
            stand(owner[v], v..v + 1);
        }
        let stretch = |k: usize| self.numbering.nodes.start(1 + k)..self.numbering.nodes.start(2 + k);
        for (e, label) in owner[vertices..].iter().enumerate() {
            stand(*label, stretch(e));
        }
        for (f, face) in self.model.faces.iter().enumerate() {
            stand(face.label, stretch(edges + f));
        }
        ranges
    }
}
