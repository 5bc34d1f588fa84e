//! The merged mesh as a view of its fragments.

use std::hint::select_unpredictable;
use std::ops::Range;

use glam::DVec3;
use multiversion::multiversion;

use crate::error::{Error, Place as Where, Result};
use crate::mesh::{CellRun, Group, MeshView};
use crate::model::{Boundary, Cells, EdgeFragment, FaceFragment, Fragments, Loop, Mismatch, Model, Violation};

use super::numbering::Numbering;

/// Cells translated at a time: their corners stay in the nearest cache until they are used.
const BLOCK: usize = 512;

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
    model: Model<P, C, S>,
    fragments: Fragments,
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
        let count = self.numbering.faces.end();
        assert!(i < count, "node {i} of {count}");
        if i < self.fragments.vertices.len() {
            return Place::Vertex(i as u32);
        }
        let Numbering { edges, faces, .. } = &self.numbering;
        if i < edges.end() {
            let e = edges.find(i);
            return Place::Edge(e as u32, (i - edges.start(e)) as u32 + 1);
        }
        let f = faces.find(i);
        let boundary = self.fragments.faces[f].boundary();
        Place::Face(f as u32, boundary.node((boundary.len() + i - faces.start(f)) as u32))
    }

    /// Which cell of which face's fragment a cell is (\[LAZ\] 4.3, `c2c`).
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn place_of_cell(&self, j: usize) -> (u32, usize) {
        let count = self.numbering.cells.end();
        assert!(j < count, "cell {j} of {count}");
        let f = self.numbering.cells.find(j);
        (f as u32, j - self.numbering.cells.start(f))
    }

    /// The number a node of a face's fragment has in the merged mesh (\[LAZ\] 4.2, `l2g`).
    ///
    /// # Panics
    /// Where there is no such face or node.
    #[inline]
    pub fn local_to_global(&self, face: u32, node: u32) -> u32 {
        let f = face as usize;
        let boundary = self.fragments.faces[f].boundary();
        let (place, border) = (boundary.place(node), boundary.len() as u32);
        let inner = (self.numbering.faces.start(f) as u32).wrapping_add(place).wrapping_sub(border);
        if border == 0 {
            return inner;
        }
        // Both, then the choice: a branch on a node that is still on its way from memory would wait for it.
        let bound = self.numbering.bounds.get(f, place.min(border - 1));
        select_unpredictable(place < border, bound, inner)
    }

    /// The corners of a cell, as numbers of the merged mesh's nodes.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn cell(&self, j: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        let (face, local) = self.place_of_cell(j);
        let corners = self.fragments.faces[face as usize].cells().corners(local);
        let count = corners.as_ref().len();
        (0..count).map(move |k| self.local_to_global(face, corners.as_ref()[k]))
    }

    /// The corners of a cell where it is a triangle; [`cell`](Self::cell) takes any.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    pub fn triangle(&self, j: usize) -> Option<[u32; 3]> {
        let (face, local) = self.place_of_cell(j);
        let f = face as usize;
        let fragment = &self.fragments.faces[f];
        if let (Cells::Triangles(list), Boundary::First(border)) = (fragment.cells(), fragment.boundary()) {
            let corners = list[local];
            // short, so that the processor sees several accesses at a time
            if corners[0].min(corners[1]).min(corners[2]) >= *border {
                let shift = (self.numbering.faces.start(f) as u32).wrapping_sub(*border);
                return Some(corners.map(|v| v.wrapping_add(shift)));
            }
        }
        let corners = fragment.cells().corners(local);
        let [a, b, c] = *corners.as_ref() else { return None };
        Some([a, b, c].map(|v| self.local_to_global(face, v)))
    }

    /// Moves the inner nodes of a face, which cannot part it from its neighbors. Numbers stay as they are.
    ///
    /// # Panics
    /// Where there is no such face.
    pub fn move_inner(&mut self, face: u32, change: impl FnMut(&mut DVec3)) {
        self.fragments.faces[face as usize].move_inner(change);
    }

    /// Puts other fragments in place and returns those that were there.
    ///
    /// Faces are checked one by one; with them the cost is that of a few additions per fragment if the number of inner
    /// nodes or cells changed, and nothing otherwise. New chains or vertices check all fragments by their fingerprints.
    ///
    /// # Errors
    /// As [`new`](Self::new), and for an index that does not exist; then nothing has changed.
    pub fn replace(&mut self, mut with: Replacement) -> Result<Replacement> {
        let [v, e, f] = [self.fragments.vertices.len(), self.fragments.edges.len(), self.fragments.faces.len()];
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
        self.swap(&mut with);
        let counts = |face: &FaceFragment| (face.inner_count(), face.cells().len());
        let faces_only = with.vertices.is_empty() && with.edges.is_empty();
        let mut found = Vec::new();
        if faces_only {
            for (f, _) in &with.faces {
                self.fragments.mismatch_of_face(&self.model, *f, &mut found);
            }
        } else {
            found = self.fragments.mismatches(&self.model);
        }
        let result = match found.first() {
            Some(mismatch) => Err(refuse(mismatch)),
            // repeated indices make the comparison of counts meaningless, a new numbering never is
            None if faces_only && with.faces.len() == 1 => {
                let (f, old) = &with.faces[0];
                if counts(old) == counts(&self.fragments.faces[*f as usize]) { Ok(()) } else { self.renumber() }
            }
            None => self.renumber(),
        };
        match result {
            Ok(()) => Ok(with),
            Err(error) => {
                self.swap(&mut with);
                // as it was, so it can be numbered
                let _ = self.renumber();
                Err(error)
            }
        }
    }

    fn renumber(&mut self) -> Result<()> {
        self.numbering.renew(&self.model, &self.fragments)
    }

    /// Swaps fragments; in reverse order the second time, so that twice is as before whatever repeats.
    fn swap(&mut self, with: &mut Replacement) {
        with.vertices.iter_mut().for_each(|(i, p)| std::mem::swap(&mut self.fragments.vertices[*i as usize], p));
        with.edges.iter_mut().for_each(|(i, e)| std::mem::swap(&mut self.fragments.edges[*i as usize], e));
        with.faces.iter_mut().for_each(|(i, f)| std::mem::swap(&mut self.fragments.faces[*i as usize], f));
        with.vertices.reverse();
        with.edges.reverse();
        with.faces.reverse();
    }

    /// Hands out cells `range` of a face; `bounds` are the face's border numbers.
    fn read_face(
        &self,
        face: usize,
        range: Range<usize>,
        bounds: &[u32],
        corners: &mut Vec<u32>,
        ends: &mut Vec<u32>,
        take: &mut dyn FnMut(CellRun) -> Result<()>,
    ) -> Result<()> {
        let fragment = &self.fragments.faces[face];
        let label = self.model.faces[face].label;
        let first = self.numbering.cells.start(face);
        let base = self.numbering.faces.start(face) as u32;
        let mut to = Translation { fragment, bounds, shift: base.wrapping_sub(bounds.len() as u32), border: None };
        let mut begin = range.start;
        while begin < range.end {
            let end = range.end.min(begin + BLOCK);
            let size = match fragment.cells() {
                Cells::Triangles(list) => {
                    to.translate(list.as_flattened(), 3 * begin..3 * end, corners);
                    3
                }
                Cells::Quads(list) => {
                    to.translate(list.as_flattened(), 4 * begin..4 * end, corners);
                    4
                }
                Cells::Polygons { ends: stored, corners: list } => {
                    let from = if begin == 0 { 0 } else { stored[begin - 1] };
                    ends.clear();
                    ends.extend(stored[begin..end].iter().map(|e| e - from));
                    to.translate(list, from as usize..stored[end - 1] as usize, corners);
                    0
                }
                grid @ Cells::Grid(_) => {
                    corners.clear();
                    for j in begin..end {
                        corners.extend(grid.corners(j).as_ref().iter().map(|v| to.one(*v)));
                    }
                    4
                }
            };
            if size == 0 {
                take(CellRun::mixed(first + begin, label, corners, ends))?;
            } else {
                take(CellRun::even(first + begin, label, corners, size))?;
            }
            begin = end;
        }
        Ok(())
    }
}

/// `l2g` of one face, its border's numbers listed.
struct Translation<'a> {
    fragment: &'a FaceFragment,
    bounds: &'a [u32],
    /// What an inner node's place and its number differ by.
    shift: u32,
    /// Border corners that are still to come, once the first of them has been looked for.
    border: Option<&'a [[u32; 2]]>,
}

impl Translation<'_> {
    #[inline]
    fn one(&self, node: u32) -> u32 {
        let place = self.fragment.boundary().place(node);
        self.bounds.get(place as usize).copied().unwrap_or(place.wrapping_add(self.shift))
    }

    /// Puts the numbers of `nodes[range]` into `out`; `nodes` are all corners of the fragment, and a range
    /// begins where the one before it ended.
    fn translate(&mut self, nodes: &[u32], range: Range<usize>, out: &mut Vec<u32>) {
        let part = &nodes[range.clone()];
        if !matches!(self.fragment.boundary(), Boundary::First(_)) {
            out.clear();
            out.extend(part.iter().map(|v| self.one(*v)));
            return;
        }
        // as if none were on the border, then those that are
        out.resize(part.len(), 0);
        add(part, self.shift, out);
        let all = self.fragment.border_corners();
        let before = |corner: &[u32; 2]| (corner[0] as usize) < range.start;
        let first = || if range.start == 0 { 0 } else { all.partition_point(before) };
        let border = self.border.unwrap_or_else(|| &all[first()..]);
        let mut done = 0;
        for [corner, place] in border {
            let Some(x) = out.get_mut(*corner as usize - range.start) else { break };
            *x = self.bounds[*place as usize];
            done += 1;
        }
        self.border = Some(&border[done..]);
    }
}

/// Adds `shift` to each of as many numbers.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn add(from: &[u32], shift: u32, to: &mut [u32]) {
    for (x, v) in to.iter_mut().zip(from) {
        *x = v.wrapping_add(shift);
    }
}

fn refuse_model(broken: &Violation) -> Error {
    Error::input(Where::Unknown, format!("the model cannot carry a mesh: {broken}"))
}

fn refuse(mismatch: &Mismatch) -> Error {
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
    fn node_count(&self) -> usize {
        self.numbering.faces.end()
    }

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
        let Numbering { edges, faces, .. } = &self.numbering;
        if i >= edges.end() && i < faces.end() {
            let f = faces.find(i);
            let fragment = &self.fragments.faces[f];
            if let Boundary::First(border) = fragment.boundary() {
                return fragment.nodes()[*border as usize + i - faces.start(f)];
            }
        }
        match self.place_of_node(i) {
            Place::Vertex(v) => self.fragments.vertices[v as usize],
            Place::Edge(e, k) => self.fragments.edges[e as usize].nodes()[k as usize],
            Place::Face(f, k) => self.fragments.faces[f as usize].nodes()[k as usize],
        }
    }

    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        assert!(range.end <= self.node_count(), "nodes {range:?} of {}", self.node_count());
        if range.is_empty() {
            return Ok(());
        }
        let vertices = &self.fragments.vertices;
        if range.start < vertices.len() {
            take(&vertices[range.start..range.end.min(vertices.len())])?;
        }
        let mut at = range.start.max(vertices.len());
        let Numbering { edges, faces, .. } = &self.numbering;
        for e in if at < edges.end() { edges.find(at)..edges.len() } else { 0..0 } {
            let end = (edges.start(e + 1)).min(range.end);
            if at < end {
                take(&self.fragments.edges[e].inner()[at - edges.start(e)..end - edges.start(e)])?;
                at = end;
            }
        }
        for f in if at < range.end { faces.find(at)..faces.len() } else { 0..0 } {
            let end = (faces.start(f + 1)).min(range.end);
            if at < end {
                self.fragments.faces[f].read_inner(at - faces.start(f)..end - faces.start(f), take)?;
                at = end;
            }
        }
        Ok(())
    }

    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()> {
        assert!(range.end <= self.cell_count(), "cells {range:?} of {}", self.cell_count());
        if range.is_empty() {
            return Ok(());
        }
        let (mut bounds, mut corners, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        let cells = &self.numbering.cells;
        for f in cells.find(range.start)..cells.len() {
            let (start, end) = (cells.start(f), cells.start(f + 1).min(range.end));
            if start >= range.end {
                break;
            }
            let begin = range.start.max(start);
            if begin < end {
                self.numbering.bounds.list(f, &mut bounds);
                self.read_face(f, begin - start..end - start, &bounds, &mut corners, &mut ends, take)?;
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
        let vertices = self.fragments.vertices.len();
        let mut owner = vec![u32::MAX; vertices + self.model.edges.len()];
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
        let Numbering { edges, faces, .. } = &self.numbering;
        for (e, label) in owner[vertices..].iter().enumerate() {
            stand(*label, edges.start(e)..edges.start(e + 1));
        }
        for (f, face) in self.model.faces.iter().enumerate() {
            stand(face.label, faces.start(f)..faces.start(f + 1));
        }
        ranges
    }
}
