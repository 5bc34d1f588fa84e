//! What all formats share: growing a mesh while checking it, and refusing one that no file should hold.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;

/// The name of the face of triangles that came without one, as [`TriMesh::new`] gives it.
pub(super) const UNNAMED: &str = "surface";

/// A mesh that grows triangle by triangle, with faces found by name.
#[derive(Default)]
pub(super) struct Builder {
    /// The mesh so far.
    pub(super) mesh: TriMesh,
    by_name: FxHashMap<String, u32>,
    by_place: FxHashMap<[u64; 3], u32>,
}

impl Builder {
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
        for pair in corners[1..].windows(2) {
            self.mesh.triangles.push([corners[0], pair[0], pair[1]]);
            self.mesh.labels.push(face);
        }
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
pub(super) fn check_mesh(mesh: &TriMesh) -> Result<()> {
    let bad = |item: String, message: String| Err(Error::input(Place::Item(item), message));
    if mesh.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "the mesh has no triangle, there is nothing to write"));
    }
    if mesh.labels.len() != mesh.triangles.len() {
        return Err(Error::input(
            Place::Unknown,
            format!("the mesh has {} labels for {} triangles", mesh.labels.len(), mesh.triangles.len()),
        ));
    }
    if let Some(v) = mesh.nodes.iter().position(|p| !p.is_finite()) {
        return bad(format!("node {v}"), format!("its coordinates {} are not finite", mesh.nodes[v]));
    }
    for (t, corners) in mesh.triangles.iter().enumerate() {
        if let Some(v) = corners.iter().find(|v| **v as usize >= mesh.nodes.len()) {
            return bad(format!("triangle {t}"), format!("it uses node {v}, but there are {}", mesh.nodes.len()));
        }
        if mesh.labels[t] as usize >= mesh.faces.len() {
            let label = mesh.labels[t];
            return bad(
                format!("triangle {t}"),
                format!("it lies on face {label}, but there are {}", mesh.faces.len()),
            );
        }
    }
    for group in &mesh.groups {
        if let Some(f) = group.faces.iter().find(|f| **f as usize >= mesh.faces.len()) {
            return bad(
                format!("group {}", super::text::quote(&group.name)),
                format!("it holds face {f}, but there are {}", mesh.faces.len()),
            );
        }
    }
    Ok(())
}

/// The triangles of each face, in their order.
pub(super) fn by_face(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); mesh.faces.len()];
    for (t, label) in mesh.labels.iter().enumerate() {
        lists[*label as usize].push(t as u32);
    }
    lists
}
