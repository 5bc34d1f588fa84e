//! A surface mesh as it is read, however it is kept: in arrays, or as fragments that are merged on the fly.
//!
//! Writers, checks, measures and pictures take a [`MeshView`]; stages take a [`TriMesh`], which [`TriMesh::from_view`] makes of one. Nodes and
//! cells come in runs, in ascending order, so the price of finding where one is kept is paid per run.

use std::borrow::Cow;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Place, Result};

use super::trimesh::{Group, TriMesh};

/// Cells in a row, all on faces of one name.
#[derive(Debug, Clone, Copy)]
pub struct CellRun<'a> {
    /// Number of the first cell.
    pub first: usize,
    /// Index of the name of their face.
    pub label: u32,
    corners: &'a [u32],
    ends: RowEnds<'a>,
}

#[derive(Debug, Clone, Copy)]
enum RowEnds<'a> {
    Every(usize),
    At(&'a [u32]),
}

impl<'a> CellRun<'a> {
    /// Cells of `size` corners each; `corners` are their nodes, one cell after the other.
    pub fn even(first: usize, label: u32, corners: &'a [u32], size: usize) -> Self {
        Self { first, label, corners, ends: RowEnds::Every(size) }
    }

    /// Cells whose corners end at these places of `corners`; the first begins at 0.
    pub fn mixed(first: usize, label: u32, corners: &'a [u32], ends: &'a [u32]) -> Self {
        Self { first, label, corners, ends: RowEnds::At(ends) }
    }

    /// How many cells there are.
    pub fn len(&self) -> usize {
        match self.ends {
            RowEnds::Every(size) => self.corners.len() / size,
            RowEnds::At(ends) => ends.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All corners, one cell after the other.
    pub fn corners(&self) -> &'a [u32] {
        self.corners
    }

    /// The cells as triangles, where all of them are.
    pub fn triangles(&self) -> Option<&'a [[u32; 3]]> {
        match self.ends {
            RowEnds::Every(3) => Some(self.corners.as_chunks().0),
            _ => None,
        }
    }

    /// The corners of cell `first + k`.
    pub fn cell(&self, k: usize) -> &'a [u32] {
        match self.ends {
            RowEnds::Every(size) => &self.corners[k * size..(k + 1) * size],
            RowEnds::At(ends) => {
                let begin = if k == 0 { 0 } else { ends[k - 1] as usize };
                &self.corners[begin..ends[k] as usize]
            }
        }
    }

    /// The corners of each cell.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &'a [u32]> + use<'a> {
        let run = *self;
        (0..run.len()).map(move |k| run.cell(k))
    }
}

/// A surface mesh that can be read. Nodes and cells are numbered from 0; corners are counter-clockwise seen from outside.
pub trait MeshView: Sync {
    /// How many nodes there are.
    fn node_count(&self) -> usize;
    /// How many cells there are.
    fn cell_count(&self) -> usize;
    /// Names of the faces; [`CellRun::label`] points here.
    fn face_names(&self) -> &[String];
    /// Named sets of face names.
    fn groups(&self) -> &[Group];
    /// Node `i`.
    ///
    /// # Panics
    /// Where there is none, as a slice does.
    fn node(&self, i: usize) -> DVec3;
    /// Hands the nodes of `range` to `take` in ascending order, as many at a time as are kept together.
    ///
    /// # Errors
    /// The first one of `take`, which is not called again.
    ///
    /// # Panics
    /// Where the range reaches beyond the nodes.
    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()>;
    /// Hands the cells of `range` to `take` in ascending order, as many at a time as fit.
    ///
    /// # Errors
    /// The first one of `take`, which is not called again.
    ///
    /// # Panics
    /// Where the range reaches beyond the cells.
    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()>;

    /// The mesh itself, where it is kept in arrays.
    fn in_arrays(&self) -> Option<&TriMesh> {
        None
    }

    /// Refuses what cannot be read as the other functions promise.
    ///
    /// # Errors
    /// [`Error::Input`] telling what is wrong. Whether corners and labels exist is not asked here.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// For each face name the ranges of its cells, ascending.
    fn cells_of_faces(&self) -> Vec<Vec<Range<usize>>> {
        let mut ranges: Vec<Vec<Range<usize>>> = vec![Vec::new(); self.face_names().len()];
        let _ = self.read_cells(0..self.cell_count(), &mut |run| {
            if let Some(list) = ranges.get_mut(run.label as usize) {
                extend(list, run.first..run.first + run.len());
            }
            Ok(())
        });
        ranges
    }

    /// For each face name the ranges of the nodes that stand with it: those no earlier name uses; nodes of no cell stand
    /// with the first.
    fn nodes_of_faces(&self) -> Vec<Vec<Range<usize>>> {
        let mut owner = vec![u32::MAX; self.node_count()];
        let _ = self.read_cells(0..self.cell_count(), &mut |run| {
            for v in run.corners() {
                let slot = &mut owner[*v as usize];
                *slot = (*slot).min(run.label);
            }
            Ok(())
        });
        let mut ranges: Vec<Vec<Range<usize>>> = vec![Vec::new(); self.face_names().len()];
        for (v, face) in owner.into_iter().enumerate() {
            if let Some(list) = ranges.get_mut(if face == u32::MAX { 0 } else { face as usize }) {
                extend(list, v..v + 1);
            }
        }
        ranges
    }
}

/// Adds a range to ascending ranges, to the last one where it goes on there.
pub fn extend(ranges: &mut Vec<Range<usize>>, more: Range<usize>) {
    match ranges.last_mut() {
        Some(last) if last.end == more.start => last.end = more.end,
        _ if more.is_empty() => {}
        _ => ranges.push(more),
    }
}

/// Nodes or cells a parallel loop takes at a time: enough that finding the first of them costs nothing.
const CHUNK: usize = 1 << 14;

/// `0..count` in pieces, in order, for parallel loops over [`MeshView::read_nodes`] and [`MeshView::read_cells`].
///
/// Where pieces begin depends on `count` alone, so what is collected from them does not depend on the threads.
pub fn par_ranges(count: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..count.div_ceil(CHUNK)).into_par_iter().map(move |k| k * CHUNK..count.min((k + 1) * CHUNK))
}

impl MeshView for TriMesh {
    fn node_count(&self) -> usize {
        self.nodes.len()
    }

    fn cell_count(&self) -> usize {
        self.triangles.len()
    }

    fn face_names(&self) -> &[String] {
        &self.faces
    }

    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn in_arrays(&self) -> Option<&TriMesh> {
        Some(self)
    }

    fn node(&self, i: usize) -> DVec3 {
        self.nodes[i]
    }

    fn read_nodes(&self, range: Range<usize>, take: &mut dyn FnMut(&[DVec3]) -> Result<()>) -> Result<()> {
        take(&self.nodes[range])
    }

    fn check(&self) -> Result<()> {
        if self.labels.len() == self.triangles.len() {
            return Ok(());
        }
        let message = format!("the mesh has {} labels for {} triangles", self.labels.len(), self.triangles.len());
        Err(Error::input(Place::Unknown, message))
    }

    fn read_cells(&self, range: Range<usize>, take: &mut dyn FnMut(CellRun) -> Result<()>) -> Result<()> {
        let mut first = range.start;
        for labels in self.labels[range].chunk_by(|a, b| a == b) {
            let corners = self.triangles[first..first + labels.len()].as_flattened();
            take(CellRun::even(first, labels[0], corners, 3))?;
            first += labels.len();
        }
        Ok(())
    }
}

impl TriMesh {
    /// A mesh in arrays: as it is where it is kept so, else a [copy](Self::from_view).
    pub fn of_view(view: &dyn MeshView) -> Cow<'_, TriMesh> {
        view.in_arrays().map_or_else(|| Cow::Owned(Self::from_view(view)), Cow::Borrowed)
    }

    /// A copy of a mesh in arrays, on rayon's threads. Cells of more than three corners become fans around their first.
    pub fn from_view(view: &dyn MeshView) -> TriMesh {
        let mut mesh =
            TriMesh { faces: view.face_names().to_vec(), groups: view.groups().to_vec(), ..TriMesh::default() };
        mesh.nodes = vec![DVec3::ZERO; view.node_count()];
        mesh.nodes.par_chunks_mut(CHUNK).enumerate().for_each(|(k, chunk)| {
            let mut done = 0;
            let _ = view.read_nodes(k * CHUNK..k * CHUNK + chunk.len(), &mut |nodes| {
                chunk[done..done + nodes.len()].copy_from_slice(nodes);
                done += nodes.len();
                Ok(())
            });
        });
        mesh.triangles = vec![[0; 3]; view.cell_count()];
        mesh.labels = vec![0; view.cell_count()];
        let only_triangles = mesh
            .triangles
            .par_chunks_mut(CHUNK)
            .zip(mesh.labels.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(k, (triangles, labels))| {
                let (begin, mut whole) = (k * CHUNK, true);
                let _ = view.read_cells(begin..begin + triangles.len(), &mut |run| {
                    let place = run.first - begin..run.first - begin + run.len();
                    match run.triangles() {
                        Some(list) => triangles[place.clone()].copy_from_slice(list),
                        None => whole = false,
                    }
                    labels[place].fill(run.label);
                    Ok(())
                });
                whole
            })
            .reduce(|| true, |a, b| a && b);
        if !only_triangles {
            mesh.triangles.clear();
            mesh.labels.clear();
            let _ = view.read_cells(0..view.cell_count(), &mut |run| {
                for cell in run.iter() {
                    mesh.triangles.extend(cell[1..].windows(2).map(|p| [cell[0], p[0], p[1]]));
                    mesh.labels.resize(mesh.triangles.len(), run.label);
                }
                Ok(())
            });
        }
        mesh
    }
}
