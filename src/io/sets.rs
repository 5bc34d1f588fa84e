//! Triangles and nodes of the named sets of a file, for formats that know triangles only.

use std::collections::BTreeSet;

use crate::error::Result;
use crate::mesh::MeshView;
use crate::run::Run;

use super::build::{each_cell, fan};
use super::regions::{NamedSet, RegionSets};

/// A mesh with its sets under the names a format allows. Triangles are numbered as in the mesh; cells of more corners are
/// cut into fans.
pub(super) struct NamedSets<'a> {
    pub(super) mesh: &'a dyn MeshView,
    pub(super) regions: &'a RegionSets,
    names: Vec<String>,
    /// Ranges of cells of each face name.
    cells: Vec<Vec<std::ops::Range<usize>>>,
    /// For each cell its first triangle, where not all cells are triangles.
    first: Option<Vec<u32>>,
}

impl<'a> NamedSets<'a> {
    pub(super) fn new(mesh: &'a dyn MeshView, regions: &'a RegionSets, names: Vec<String>) -> Result<Self> {
        let mut first = Vec::with_capacity(mesh.cell_count() + 1);
        let mut next = 0;
        each_cell(mesh, 0..mesh.cell_count(), &Run::new(), |cell, _| {
            first.push(next);
            next += cell.len() as u32 - 2;
            Ok(())
        })?;
        first.push(next);
        let first = (next as usize != mesh.cell_count()).then_some(first);
        Ok(Self { mesh, regions, names, cells: mesh.cells_of_faces(), first })
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.first.as_ref().map_or(self.mesh.cell_count(), |f| f[f.len() - 1] as usize)
    }

    /// Sets with their names, parts first. The number of a set is its place plus one.
    pub(super) fn named(&self) -> impl Iterator<Item = (&str, &NamedSet)> {
        self.names.iter().map(String::as_str).zip(&self.regions.sets)
    }

    /// The sets that share no triangle.
    pub(super) fn parts(&self) -> impl Iterator<Item = (&str, &NamedSet)> {
        self.named().take(self.regions.parts)
    }

    /// Hands every triangle of a set to `take` with its number.
    pub(super) fn each_triangle(
        &self,
        set: &NamedSet,
        run: &Run,
        mut take: impl FnMut(u32, [u32; 3]) -> Result<()>,
    ) -> Result<()> {
        for range in set.faces.iter().flat_map(|f| &self.cells[*f as usize]) {
            let mut cell_number = range.start;
            each_cell(self.mesh, range.clone(), run, |cell, _| {
                let number = self.first.as_ref().map_or(cell_number as u32, |f| f[cell_number]);
                cell_number += 1;
                (number..).zip(fan(cell)).try_for_each(|(n, t)| take(n, t))
            })?;
        }
        Ok(())
    }

    /// Triangles and nodes of a set, ascending.
    pub(super) fn members(&self, set: &NamedSet, run: &Run) -> Result<(Vec<u32>, Vec<u32>)> {
        let (mut triangles, mut nodes) = (Vec::new(), BTreeSet::new());
        self.each_triangle(set, run, |number, corners| {
            triangles.push(number);
            nodes.extend(corners);
            Ok(())
        })?;
        triangles.sort_unstable();
        Ok((triangles, nodes.into_iter().collect()))
    }
}
