//! What is asked of finished meshes as surfaces: values carried to other points, ways over one, and several joined to one.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use rvachev::DVec3;
use rvachev::mesh::{TriMesh, carry as carried, shortest_path as shortest};
use rvachev::pipeline::{self, Joined, SizeRequest};
use rvachev::spatial::Aabb;

use crate::arrays::{floats, table};
use crate::errors::raise;
use crate::mesh::{PyMesh, to_json};
use crate::options::size;
use crate::pickle::About;
use crate::work::Listeners;

/// Three numbers as a point.
fn place(v: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    let row = v.py().import("numpy")?.call_method1("reshape", (v, (1, -1)))?;
    Ok(table(&row, name)?[0])
}

/// Values, and how far their points are from the mesh.
type Carried<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArray1<f64>>);

/// carry(mesh, values, to): values at a mesh's points carried to other points, such as those of a finer mesh.
///
/// values: (n,) or (n, ...), for each of the mesh's n points. to: points (k, 3), or a Mesh, whose points are meant.
/// Gives the values, float64 (k,) or (k, ...), and the distances (k,) of the points from the mesh, in its unit. A point has the
/// value at the nearest point of the mesh, linear within each triangle; no point is refused for being far away.
/// Errors: `InputError` for another number of values than points, a mesh without triangles, a point that is not finite.
#[pyfunction]
#[pyo3(signature = (mesh, values, to))]
pub fn carry<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, PyMesh>,
    values: &Bound<'py, PyAny>,
    to: &Bound<'py, PyAny>,
) -> PyResult<Carried<'py>> {
    let points = match to.cast::<PyMesh>() {
        Ok(other) => other.get().mesh().nodes.clone(),
        Err(_) => table(to, "to")?,
    };
    let values = floats(values)?;
    let Some((n, rest)) = values.shape().split_first() else {
        return Err(PyTypeError::new_err("values are an array of one for each point of the mesh, not a number"));
    };
    let (n, width, flat, from) = (*n, rest.iter().product::<usize>(), values.as_slice()?, mesh.get().mesh());
    let (all, distances) = Listeners::default().work(py, |run| {
        let mut all = vec![0.0; width * points.len()];
        let mut distances = Vec::new();
        // Three numbers at a time, so the nearest triangles are looked for a third as often. Without any, distances still are.
        for first in (0..width.max(1)).step_by(3) {
            let count = 3.min(width - first.min(width));
            let three = |i: usize| {
                DVec3::from_array(std::array::from_fn(|k| if k < count { flat[i * width + first + k] } else { 0.0 }))
            };
            let rows: Vec<DVec3> = (0..n).map(three).collect();
            let made = carried(from, &rows, &points, run)?;
            for (row, v) in made.values.iter().enumerate() {
                all[row * width + first..][..count].copy_from_slice(&v.to_array()[..count]);
            }
            distances = made.distances;
        }
        Ok((all, distances))
    })?;
    let shape: Vec<usize> = [points.len()].iter().chain(rest).copied().collect();
    Ok((all.into_pyarray(py).reshape(shape)?, distances.into_pyarray(py)))
}

/// shortest_path(mesh, start, end): the shortest way over a mesh between the points of it that are nearest to two points.
///
/// Gives its points, float64 (k, 3), and its length, in the mesh's unit; between two of them it runs straight through one triangle.
/// No change nearby makes it shorter. Where ways on several sides of an obstacle are about as long, it may be none of the shortest.
/// Errors: `InputError` for points that are not finite, and for pieces that do not hang together.
#[pyfunction]
#[pyo3(signature = (mesh, start, end))]
pub fn shortest_path<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, PyMesh>,
    start: &Bound<'py, PyAny>,
    end: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, f64)> {
    let (start, end, mesh) = (place(start, "start")?, place(end, "end")?, mesh.get().mesh());
    let way = Listeners::default().work(py, |run| shortest(mesh, start, end, run))?;
    let flat: Vec<f64> = way.points.iter().flat_map(|p| p.to_array()).collect();
    Ok((flat.into_pyarray(py).reshape([way.points.len(), 3])?, way.length))
}

/// join(meshes, within=None): meshes joined to one where their nodes match.
///
/// meshes: an iterable of Mesh. within: a length in their unit, or a share of the diagonal of all, 0.0001% unless it is said; 0 for the same
/// coordinates alone. A node of one mesh and the nearest node of another are one where they are no farther apart. Joined nodes stand
/// where the mesh that comes first has them, triangles keep their order; faces, and groups, of the same name are one. `report` counts
/// edges that are open, that have more than two triangles, and that are of meshes which are inside out. A mesh without a node in
/// common is a `Shortfall`.
/// Errors: `InputError` for no meshes and a length that is negative.
#[pyfunction]
#[pyo3(signature = (meshes, within=None))]
pub fn join(py: Python<'_>, meshes: &Bound<'_, PyAny>, within: Option<&Bound<'_, PyAny>>) -> PyResult<PyMesh> {
    let mut all: Vec<TriMesh> = Vec::new();
    for item in meshes.try_iter()? {
        all.push(item?.cast::<PyMesh>()?.get().mesh().clone());
    }
    let diagonal = all.iter().fold(Aabb::EMPTY, |b, m| b.union(&m.bounds())).diagonal();
    let within = match within {
        Some(v) if v.extract::<f64>().is_ok_and(|x| x == 0.0) => 0.0,
        Some(v) => match size(v)? {
            SizeRequest::Length(length) => length,
            SizeRequest::Share(share) => share * diagonal,
        },
        // Some ten times what single precision leaves of a coordinate, as for the command.
        None => 1e-6 * diagonal,
    };
    let Joined { mesh, report } = Listeners::default().work(py, |run| pipeline::join(&all, within, run))?;
    let alone = |i: &usize| format!("mesh {i} has no node in common with the others");
    let about = About {
        faces: mesh.faces.clone(),
        groups: mesh.groups.iter().map(|g| (g.name.clone(), g.faces.clone())).collect(),
        seams: Vec::new(),
        corners: Vec::new(),
        shortfalls: report.alone.iter().map(alone).collect(),
        report: to_json(&report).map_err(|e| raise(py, &e))?,
        certificate: "null".into(),
    };
    let joined = PyMesh::again(mesh, about);
    joined.tell(py, false)?;
    Ok(joined)
}
