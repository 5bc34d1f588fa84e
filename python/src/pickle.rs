//! Meshes, and parts read from files, for pickle: to other processes and back.

use std::path::PathBuf;

use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use rvachev::Place;
use rvachev::implicit::part::{Part, PartGroup};
use rvachev::mesh::{Group, TriMesh};
use rvachev::pipeline;

use crate::arrays::surface;
use crate::errors::raise;
use crate::mesh::PyMesh;
use crate::part::PyPart;

/// What a part was read from.
#[derive(Clone)]
pub struct Source {
    /// Its ending tells what the text is, and errors name it; the text is at hand.
    pub path: PathBuf,
    /// The part file.
    pub text: String,
    /// Numbers replaced at its top level.
    pub define: Vec<(String, f64)>,
}

impl Source {
    /// The part as the file has it.
    pub fn part(&self) -> rvachev::Result<Part> {
        pipeline::parse_part(&self.path, &self.text, &self.define)
    }
}

/// What else than nodes and triangles a mesh has; report and certificate as JSON.
#[derive(Clone, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct About {
    /// Names of faces.
    pub faces: Vec<String>,
    /// Groups: names, and indices of faces.
    pub groups: Vec<(String, Vec<u32>)>,
    /// Edges where two surfaces of one face meet.
    pub seams: Vec<[u32; 2]>,
    /// Points where borders of faces end or meet.
    pub corners: Vec<u32>,
    /// The report.
    pub report: String,
    /// The certificate.
    pub certificate: String,
    /// Where the mesh falls short.
    pub shortfalls: Vec<String>,
}

/// A mesh that was pickled. InputError for numbers that are out of range.
#[pyfunction]
pub fn mesh_again(
    py: Python<'_>,
    points: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    labels: PyReadonlyArray1<'_, u32>,
    about: About,
) -> PyResult<PyMesh> {
    let surface = surface(points, Some(triangles))?;
    let labels = labels.as_slice()?.to_vec();
    let (nodes, faces) = (surface.nodes.len(), about.faces.len());
    let known = |list: &[u32], n: usize| list.iter().all(|i| (*i as usize) < n);
    let sound = labels.len() == surface.triangles.len()
        && known(&labels, faces)
        && known(&about.corners, nodes)
        && known(about.seams.as_flattened(), nodes)
        && about.groups.iter().all(|g| known(&g.1, faces));
    if !sound {
        let what = "the pickled mesh has numbers that are out of range";
        return Err(raise(py, &rvachev::Error::input(Place::Unknown, what)));
    }
    let groups = about.groups.iter().map(|(name, faces)| Group { name: name.clone(), faces: faces.clone() }).collect();
    let mesh = TriMesh { labels, faces: about.faces.clone(), groups, ..surface };
    Ok(PyMesh::again(mesh, about))
}

/// A part that was pickled: its file's text, with the groups it has had since.
#[pyfunction]
pub fn part_again(
    py: Python<'_>,
    path: PathBuf,
    text: String,
    define: Vec<(String, f64)>,
    groups: Vec<(String, Vec<String>)>,
) -> PyResult<PyPart> {
    let source = Source { path, text, define };
    let mut part = source.part().map_err(|e| raise(py, &e))?;
    for (name, patterns) in groups {
        if !part.groups.iter().any(|g| g.name == name) {
            part.groups.push(PartGroup { name, patterns, place: Place::Unknown });
        }
    }
    Ok(PyPart::read(part, source))
}

/// Why a part has no pickle.
pub fn no_file() -> PyErr {
    PyTypeError::new_err(
        "only parts read from files can be pickled: Part.load(\"part.py\"); their meshes can always be",
    )
}
