//! How meshes look: pictures, curvatures, classes of nodes, distances from a part.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use rvachev::mesh::curvature::node_curvatures;
use rvachev::pipeline::{self, PictureOptions, TrueSurface};

use crate::arrays::surface;
use crate::errors::raise;
use crate::options::Options;
use crate::part::PyPart;
use crate::work::Listeners;

/// A value of an option as the text the command has for it: numbers are joined by `between`.
fn said(v: &Bound<'_, PyAny>, between: &str) -> PyResult<String> {
    if let Ok(b) = v.cast::<PyBool>() {
        return Ok(if b.is_true() { "true" } else { "false" }.into());
    }
    if v.is_instance_of::<PyString>() || !v.hasattr("__iter__")? {
        return Ok(v.str()?.to_string());
    }
    let parts = v.try_iter()?.map(|x| Ok(x?.str()?.to_string())).collect::<PyResult<Vec<_>>>()?;
    Ok(parts.join(between))
}

/// Takes the options of pictures out of a dict; what is left is for others.
fn picture_options(all: &Bound<'_, PyDict>) -> PyResult<PictureOptions> {
    let mut out = PictureOptions::default();
    for name in PictureOptions::NAMES {
        let Some(v) = all.get_item(name)? else { continue };
        all.del_item(name)?;
        if v.is_none() {
            continue;
        }
        let texts = match name {
            "clip" if !v.is_instance_of::<PyString>() => v.extract::<Vec<String>>()?,
            "pixels" => vec![said(&v, "x")?],
            _ => vec![said(&v, ",")?],
        };
        texts.iter().try_for_each(|t| out.set(name, t)).map_err(|e| raise(all.py(), &e))?;
    }
    Ok(out)
}

/// picture(points, triangles=None, path=None, **options): draws a mesh without a screen, as `rvachev render` does: uint8
/// (height, width, 4), red, green, blue and opacity of each pixel from the top left. With a path a PNG file is written, too.
///
/// points (n, 3) and triangles (m, 3), or a Mesh alone.
/// view: "iso", "front", "back", "left", "right", "top", "bottom", or (azimuth, elevation) in degrees.
/// focus: (x, y, z, radius) of the ball that fills the picture, in the mesh's unit; without it the whole mesh does.
/// clip: "x=0", "z=1.5,above" in the mesh's unit, or a list of such: planes that cut the mesh open.
/// color: "face", "angle", "edge", "class", or "distance" from the surface of `against`, a Part or the path of a part file or STEP file.
/// edges: "none", "sharp" or "all". pixels: (width, height), 1200 by 900 unless it is said. transparent: no background.
/// legend=False: none. Other options: progress, cancel, threads, define.
/// Errors: `InputError` for options out of range, planes that cut nothing away or leave nothing, a mesh without triangles, and, with
/// class, one that is no manifold.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, path=None, **options))]
pub fn picture<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
    path: Option<PathBuf>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let mesh = surface(points, triangles)?;
    let rest = options.map_or_else(|| Ok(PyDict::new(py)), |o| o.copy())?;
    let mut how = picture_options(&rest)?;
    let against = rest.get_item("against")?.filter(|a| !a.is_none());
    if rest.contains("against")? {
        rest.del_item("against")?;
    }
    let o = Options::new(Some(&rest), &["progress", "cancel", "threads", "define"]).map_err(|e| named(py, e))?;
    how.against = match against {
        None => None,
        Some(a) => Some(match a.cast::<PyPart>() {
            Ok(part) => TrueSurface::Part(Box::new(part.get().part())),
            Err(_) => TrueSurface::File { path: a.extract()?, overrides: o.define },
        }),
    };
    path.iter().try_for_each(|p| pipeline::check_picture_name(p)).map_err(|e| raise(py, &e))?;
    let drawn = o.listeners.work(py, |run| {
        let drawn = pipeline::picture(&mesh, &how, run)?;
        if let Some(path) = &path {
            pipeline::write_picture(path, &drawn)?;
        }
        Ok(drawn)
    })?;
    drawn.rgba().into_pyarray(py).reshape([drawn.height, drawn.width, 4])
}

/// An option that is unknown, told with those of pictures as well.
fn named(py: Python<'_>, e: PyErr) -> PyErr {
    if e.is_instance_of::<PyTypeError>(py) {
        let text = format!("{}, {}, against", e.value(py), PictureOptions::NAMES.join(", "));
        return PyTypeError::new_err(text);
    }
    e
}

/// Two principal curvatures of each node, and its angle defect.
type Curvatures<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

/// curvature(points, triangles=None): how a mesh bends at its points.
///
/// points (n, 3) and triangles (m, 3), or a Mesh alone. Gives the principal curvatures, float64 (n, 2), 1 over the mesh's unit, as
/// magnitudes with the larger one first, of the angles between the triangles around a point; and by how much the angles around it differ
/// from a full turn, half of one on an open border, float64 (n,), in radians.
/// Errors: `InputError` for a mesh that is no oriented manifold.
#[pyfunction]
#[pyo3(signature = (points, triangles=None))]
pub fn curvature<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
) -> PyResult<Curvatures<'py>> {
    let mesh = surface(points, triangles)?;
    let all = Listeners::default().work(py, |run| node_curvatures(&mesh, run))?;
    let principal: Vec<f64> = all.iter().flat_map(|c| c.principal).collect();
    let defects: Vec<f64> = all.iter().map(|c| c.defect).collect();
    Ok((principal.into_pyarray(py).reshape([all.len(), 2])?, defects.into_pyarray(py)))
}

/// node_classes(points, triangles=None): what each point of a mesh is by its curvature, uint8 (n,): 0 regular, 1 on a crease, 2 a corner.
///
/// points (n, 3) and triangles (m, 3), or a Mesh alone. Points are compared with each other, so a mesh of a few triangles without smooth
/// places may have no corner.
/// Errors: `InputError` for a mesh that is no oriented manifold.
#[pyfunction]
#[pyo3(signature = (points, triangles=None))]
pub fn node_classes<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let mesh = surface(points, triangles)?;
    let all = Listeners::default().work(py, |run| pipeline::node_classes(&mesh, run))?;
    Ok(all.into_pyarray(py))
}

/// distances(points, triangles=None, *, against): how far each point of a mesh is from the surface of a Part, float64 (n,), in the part's
/// unit; never less than it is, and infinite where it is far from all of it.
///
/// points (n, 3) and triangles (m, 3), or a Mesh alone.
/// Errors: `InputError` for points that are not finite.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, *, against))]
pub fn distances<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
    against: &Bound<'py, PyPart>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (mesh, part) = (surface(points, triangles)?, against.get().part());
    let all = Listeners::default().work(py, |run| pipeline::distances_to(&mesh, &part, run))?;
    Ok(all.into_pyarray(py))
}
