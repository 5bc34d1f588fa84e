//! Arrays of numpy in and out.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::mesh::TriMesh;
use rvachev::{DVec3, Error, Place};

use crate::errors::raise;
use crate::mesh::PyMesh;

/// Anything as an array of a type in C order; what only a cast that loses makes one is refused.
fn as_array<'py>(v: &Bound<'py, PyAny>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = v.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (v,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let wanted: &str = if dtype == "float64" { "fiu" } else { "iu" };
    let empty = array.getattr("size")?.extract::<usize>()? == 0;
    if !wanted.contains(&kind) && !empty {
        let got = array.getattr("dtype")?.str()?;
        return Err(PyTypeError::new_err(format!("numbers are wanted ({dtype}), not {got}")));
    }
    let how = PyDict::new(py);
    how.set_item("dtype", dtype)?;
    how.set_item("order", "C")?;
    numpy.call_method("asarray", (array,), Some(&how))
}

/// As float64.
pub fn floats<'py>(v: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    // What fields return as a rule: numpy need not be asked, which would take as long as a small call.
    if let Ok(array) = v.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
    {
        return Ok(array.readonly());
    }
    Ok(as_array(v, "float64")?.cast_into::<PyArrayDyn<f64>>()?.readonly())
}

fn shaped(found: &[usize], name: &str) -> PyResult<()> {
    if matches!(found, [_, 3]) {
        return Ok(());
    }
    let got = found.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    Err(PyTypeError::new_err(format!("{name} must have shape (n, 3), not ({got})")))
}

/// Points, shape (n, 3).
pub fn table(v: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<DVec3>> {
    let array = floats(v)?;
    shaped(array.shape(), name)?;
    Ok(array.as_slice()?.chunks_exact(3).map(DVec3::from_slice).collect())
}

/// A mesh given as one, or as points (n, 3) and triangles (m, 3).
pub fn surface(points: &Bound<'_, PyAny>, triangles: Option<&Bound<'_, PyAny>>) -> PyResult<TriMesh> {
    let py = points.py();
    let Some(triangles) = triangles else {
        return match points.cast::<PyMesh>() {
            Ok(m) => Ok(m.get().mesh().clone()),
            Err(_) => Err(PyTypeError::new_err("a mesh is wanted: a Mesh, or points (n, 3) and triangles (m, 3)")),
        };
    };
    let nodes = table(points, "points")?;
    let bad = |place: String, what: String| raise(py, &Error::input(Place::Item(place), what));
    if let Some(i) = nodes.iter().position(|p| !p.is_finite()) {
        return Err(bad(format!("point {i}"), format!("it is not finite: {}", nodes[i])));
    }
    let array = as_array(triangles, "int64")?.cast_into::<numpy::PyArrayDyn<i64>>()?.readonly();
    shaped(array.shape(), "triangles")?;
    let mut list = Vec::with_capacity(array.len() / 3);
    for (t, v) in array.as_slice()?.chunks_exact(3).enumerate() {
        let number = |i: usize| u32::try_from(v[i]).ok().filter(|k| (*k as usize) < nodes.len());
        match (number(0), number(1), number(2)) {
            (Some(a), Some(b), Some(c)) => list.push([a, b, c]),
            _ => return Err(bad(format!("triangle {t}"), format!("{v:?} is not of {} points", nodes.len()))),
        }
    }
    Ok(TriMesh::new(nodes, list))
}
