//! What all formats share: growing a mesh while checking it, and refusing one that no file should hold.

use std::ops::Range;

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;

/// The name of the face of triangles that came without one, as [`TriMesh::new`] gives it.
pub(super) const UNNAMED: &str = "surface";

/// A mesh that grows triangle by triangle, with faces found by name.
#[derive(Default)]
pub(super) struct MeshBuilder {
    /// The mesh so far.
    pub(super) mesh: TriMesh,
    by_name: FxHashMap<String, u32>,
    by_place: FxHashMap<[u64; 3], u32>,
}

impl MeshBuilder {
    /// The number of the face of that name, which comes into being when it is first asked for.
    pub(super) fn face(&mut self, name: &str) -> u32 {
        if let Some(&face) = self.by_name.get(name) {
            return face;
        }
        let face = self.mesh.faces.len() as u32;
        self.mesh.faces.push(name.to_owned());
        self.by_name.insert(name.to_owned(), face);
        face
    }

    /// The node at exactly that point, a new one if there is none; `0` and `-0` are the same place.
    pub(super) fn weld(&mut self, p: DVec3) -> u32 {
        let key = p.to_array().map(|x| (x + 0.0).to_bits());
        *self.by_place.entry(key).or_insert_with(|| {
            self.mesh.nodes.push(p);
            (self.mesh.nodes.len() - 1) as u32
        })
    }

    /// Adds a polygon as a fan around its first corner.
    pub(super) fn fan(&mut self, corners: &[u32], face: u32) {
        self.mesh.triangles.extend(fan(corners));
        self.mesh.labels.resize(self.mesh.triangles.len(), face);
    }
}

/// How much to reserve for `claimed` items of at least `smallest` bytes each when only `available` bytes are left: a file
/// that lies about its counts must not make us ask for more memory than it could fill.
pub(super) fn reserve(claimed: usize, smallest: usize, available: usize) -> usize {
    claimed.min(available / smallest)
}

/// Node numbers are `u32`; the last one is left free as a mark.
pub(super) fn check_node_count(count: usize, place: Place) -> Result<()> {
    if count >= u32::MAX as usize {
        return Err(Error::input(
            place,
            format!("{count} nodes are more than the {} this program can hold", u32::MAX - 1),
        ));
    }
    Ok(())
}

/// Refuses what no reader would take back.
pub(super) fn check_mesh(mesh: &dyn MeshView) -> Result<()> {
    let bad = |item: String, message: String| Err(Error::input(Place::Item(item), message));
    let (nodes, faces) = (mesh.node_count(), mesh.face_names().len());
    if mesh.cell_count() == 0 {
        return Err(Error::input(Place::Unknown, "the mesh has no triangle, there is nothing to write"));
    }
    mesh.check()?;
    let mut first = 0;
    mesh.read_nodes(0..nodes, &mut |run| {
        if let Some(v) = run.iter().position(|p| !p.is_finite()) {
            return bad(format!("node {}", first + v), format!("its coordinates {} are not finite", run[v]));
        }
        first += run.len();
        Ok(())
    })?;
    mesh.read_cells(0..mesh.cell_count(), &mut |run| {
        let item = |k: usize| format!("{} {}", if run.cell(k).len() == 3 { "triangle" } else { "cell" }, run.first + k);
        if run.corners().iter().any(|v| *v as usize >= nodes) {
            let outside = |v: &&u32| **v as usize >= nodes;
            let found = run.iter().enumerate().find_map(|(k, cell)| Some((k, *cell.iter().find(outside)?)));
            if let Some((k, v)) = found {
                return bad(item(k), format!("it uses node {v}, but there are {nodes}"));
            }
        }
        if run.label as usize >= faces {
            return bad(item(0), format!("it lies on face {}, but there are {faces}", run.label));
        }
        Ok(())
    })?;
    for group in mesh.groups() {
        if let Some(f) = group.faces.iter().find(|f| **f as usize >= faces) {
            return bad(
                format!("group {}", super::text::quote(&group.name)),
                format!("it holds face {f}, but there are {faces}"),
            );
        }
    }
    Ok(())
}

/// Hands every node of a range to `take`, looking at the cancel flag now and then.
pub(super) fn each_node(
    mesh: &dyn MeshView,
    range: Range<usize>,
    run: &Run,
    mut take: impl FnMut(DVec3) -> Result<()>,
) -> Result<()> {
    mesh.read_nodes(range, &mut |nodes| {
        nodes.chunks(CHECK_EVERY).try_for_each(|part| {
            run.check()?;
            part.iter().try_for_each(|p| take(*p))
        })
    })
}

/// Hands every cell of a range to `take` with its label, looking at the cancel flag now and then.
pub(super) fn each_cell(
    mesh: &dyn MeshView,
    range: Range<usize>,
    run: &Run,
    mut take: impl FnMut(&[u32], u32) -> Result<()>,
) -> Result<()> {
    mesh.read_cells(range, &mut |cells| {
        for (k, cell) in cells.iter().enumerate() {
            if k % CHECK_EVERY == 0 {
                run.check()?;
            }
            take(cell, cells.label)?;
        }
        Ok(())
    })
}

/// The triangles of a fan around the first corner.
pub(super) fn fan(cell: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    cell[1..].windows(2).map(|pair| [cell[0], pair[0], pair[1]])
}
