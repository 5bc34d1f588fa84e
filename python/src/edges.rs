//! Chains of edges, and solids and sheets built from them: text for the reader of part files.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::text::{call, read};

/// A chain of edges in space, made by `polyline`, `spline`, `arc`, `conic`, `nurbs` and their like, joined by `chain`.
#[pyclass(frozen, module = "rvachev", skip_from_py_object)]
#[derive(Clone)]
pub struct Edges {
    /// What a part file would say.
    pub text: String,
}

/// A solid or sheet built from edges: extruded, revolved, lofted, swept or sewn. It stands apart in a part, and takes no part in
/// set operations.
#[pyclass(frozen, module = "rvachev", skip_from_py_object)]
#[derive(Clone)]
pub struct Built {
    /// What a part file would say.
    pub text: String,
}

type Args<'a, 'py> = &'a Bound<'py, PyTuple>;

impl Edges {
    /// What the text says, if it says edges.
    pub fn new(py: Python<'_>, text: String) -> PyResult<Self> {
        read(py, &format!("edges = {text}\npart(sphere(1))"))?;
        Ok(Edges { text })
    }

    fn then(
        &self,
        py: Python<'_>,
        name: &str,
        args: Args<'_, '_>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        Edges::new(py, format!("{}.{}", self.text, call(name, args, kwargs)?))
    }
}

impl Built {
    /// What the text says, if it says something built.
    pub fn new(py: Python<'_>, text: String) -> PyResult<Self> {
        read(py, &format!("part({text})"))?;
        Ok(Built { text })
    }

    fn then(
        &self,
        py: Python<'_>,
        name: &str,
        args: Args<'_, '_>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        Built::new(py, format!("{}.{}", self.text, call(name, args, kwargs)?))
    }
}

/// The methods both have.
macro_rules! placed {
    ($class:ident { $($more:item)* }) => {
        #[pymethods]
        impl $class {
            /// Moved by a vector (dx, dy, dz), in the part's unit.
            #[pyo3(name = "move", signature = (*args, **kwargs), text_signature = "($self, by)")]
            fn moved(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
                self.then(py, "move", args, kwargs)
            }
            /// Turned by so many degrees about an axis through a point.
            #[pyo3(signature = (*args, **kwargs), text_signature = "($self, degrees, axis='z', at=(0, 0, 0))")]
            fn rotate(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
                self.then(py, "rotate", args, kwargs)
            }
            /// Scaled about the origin, about a point, or solids about="mass": about their centers of mass.
            #[pyo3(signature = (*args, **kwargs), text_signature = "($self, k, about=None)")]
            fn scale(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
                self.then(py, "scale", args, kwargs)
            }
            /// Mirrored in the plane square to an axis through a point.
            #[pyo3(signature = (*args, **kwargs), text_signature = "($self, axis, at=(0, 0, 0))")]
            fn mirror(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
                self.then(py, "mirror", args, kwargs)
            }
            fn __repr__(&self) -> String {
                format!("<rvachev.{}: {}>", stringify!($class), self.text.chars().take(60).collect::<String>())
            }
            $($more)*
        }
    };
}

placed!(Edges {});
placed!(Built {
    /// Names its faces.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, name)")]
    fn name(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "name", args, kwargs)
    }
    /// Leaves out faces whose names fit patterns: what is left is a sheet.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, *faces)")]
    fn without(&self, py: Python<'_>, args: Args<'_, '_>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "without", args, kwargs)
    }
});
