//! Mesh files of other programs, joined where their nodes match.

use std::path::PathBuf;

use rustc_hash::FxHashMap;

use super::SizeRequest;
use super::discrete::load_mesh;
use crate::error::{Error, Result};
pub use crate::merge::{JoinReport, Joined, join};
use crate::mesh::TriMesh;
use crate::numeric::SEVEN_DIGITS;
use crate::run::Run;
use crate::spatial::Aabb;

/// Reads mesh files and [joins](join) them, by default within a millionth of the diagonal of all. A face whose name another file
/// has, too, is called after its file: `lid.surface` for `surface` of `lid.stl`. Groups of the same name are one.
///
/// Errors: [`Error::Usage`] for fewer than two files; those of [`load_mesh`] and [`join`], with the file.
pub fn join_files(paths: &[PathBuf], within: Option<SizeRequest>, run: &Run) -> Result<Joined> {
    if paths.len() < 2 {
        return Err(Error::Usage("two mesh files or more are joined".into()));
    }
    let mut meshes = Vec::with_capacity(paths.len());
    for path in paths {
        run.check()?;
        let mesh = load_mesh(path, run)?;
        mesh.validate().map_err(|e| e.in_file(path))?;
        meshes.push(mesh);
    }
    let diagonal = meshes.iter().fold(Aabb::EMPTY, |b, m| b.union(&m.bounds())).diagonal();
    // Nodes this near to each other are one unless another distance is asked for.
    let within = match within.unwrap_or(SizeRequest::Share(SEVEN_DIGITS)) {
        SizeRequest::Length(length) => length,
        SizeRequest::Share(share) => share * diagonal,
    };
    name_by_files(&mut meshes, paths);
    join(&meshes, within, run)
}

/// Gives faces whose name is in several meshes the name of their file in front.
fn name_by_files(meshes: &mut [TriMesh], paths: &[PathBuf]) {
    let mut uses: FxHashMap<String, usize> = FxHashMap::default();
    for mesh in meshes.iter() {
        let mut own: Vec<&String> = mesh.faces.iter().collect();
        own.sort_unstable();
        own.dedup();
        own.into_iter().for_each(|name| *uses.entry(name.clone()).or_default() += 1);
    }
    for (mesh, path) in meshes.iter_mut().zip(paths) {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        for name in mesh.faces.iter_mut().filter(|name| uses.get(*name).is_some_and(|n| *n > 1)) {
            *name = format!("{stem}.{name}");
        }
    }
}
