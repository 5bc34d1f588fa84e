//! Solids: set operations, placements, names, and functions of Python as solids.

use pyo3::exceptions::{PyAttributeError, PyNotImplementedError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rvachev::implicit::expr::Binary;
use rvachev::implicit::{Expr, Solid, SolidNode};

use crate::edges::{Built, Edges};
use crate::errors::{input, raise, warn};
use crate::expr::{PyExpr, array_function, formula};
use crate::field::PyField;
use crate::text::{call, read};

/// A solid: a tree of primitives, formulas and set operations.
///
/// `a | b` is the union, `a & b` the intersection, `a - b` the difference, `~a` the complement. Names of faces are given by
/// `.name()`; the innermost one wins.
#[pyclass(frozen, name = "Solid", module = "rvachev", skip_from_py_object)]
#[derive(Clone)]
pub struct PySolid {
    /// The tree.
    pub solid: Solid,
    /// A formula that is positive inside, where the solid is a comparison.
    pub condition: Option<Expr>,
}

impl From<Solid> for PySolid {
    fn from(solid: Solid) -> Self {
        PySolid { solid, condition: None }
    }
}

impl PySolid {
    /// Where a formula is positive.
    pub fn where_positive(e: Expr) -> Self {
        PySolid { solid: Solid::formula(e.clone()), condition: Some(e) }
    }

    /// Set operations of two; `NotImplemented` where the other is no solid.
    fn joined(
        &self,
        py: Python<'_>,
        other: &Bound<'_, PyAny>,
        join: impl Fn(Solid, Solid) -> Solid,
        op: Option<Binary>,
    ) -> PyResult<Py<PyAny>> {
        let Ok(other) = other.cast::<PySolid>() else {
            if other.cast::<Built>().is_ok() {
                let what = "solids built from edges take no part in set operations";
                return Err(raise(py, &input(what, "Part([a, b]) takes several that stand apart")));
            }
            if other.cast::<PyExpr>().is_ok() {
                return Err(PyTypeError::new_err(
                    "a solid and a formula: make a solid of the formula by solid(f >= 0)",
                ));
            }
            return Ok(py.NotImplemented());
        };
        let other = other.get();
        let condition = match (op, &self.condition, &other.condition) {
            (Some(op), Some(a), Some(b)) => Some(Expr::binary(op, a.clone(), b.clone())),
            _ => None,
        };
        let solid = join(self.solid.clone(), other.solid.clone());
        Ok(Py::new(py, PySolid { solid, condition })?.into_any())
    }

    /// What a method of part files makes of a solid.
    fn then(
        &self,
        py: Python<'_>,
        name: &str,
        args: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let part = read(py, &format!("part(sphere(1).{})", call(name, args, kwargs)?))?;
        let inner = self.solid.clone();
        let solid = match part.solid.as_ref().map(Solid::node) {
            Some(SolidNode::Placed(placement, _)) => inner.placed(*placement),
            Some(SolidNode::Named(name, _)) => inner.name(name),
            Some(SolidNode::Sized(h, _)) => inner.size(*h),
            _ => inner,
        };
        Ok(solid.into())
    }
}

#[pymethods]
impl PySolid {
    fn __or__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        self.joined(py, other, |a, b| a | b, Some(Binary::Max))
    }
    fn __and__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        self.joined(py, other, |a, b| a & b, Some(Binary::Min))
    }
    fn __sub__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        self.joined(py, other, |a, b| a - b, None)
    }
    fn __invert__(&self) -> Self {
        PySolid { solid: !self.solid.clone(), condition: self.condition.clone().map(|e| -e) }
    }
    fn __neg__(&self) -> PyResult<Self> {
        Err(PyTypeError::new_err("-a has no meaning for a solid; the complement is ~a"))
    }
    fn __bool__(&self) -> PyResult<bool> {
        let what = "a solid is neither true nor false; (a <= x) & (x <= b) is where both hold, and | is or";
        Err(PyTypeError::new_err(what))
    }

    /// Names the faces; the innermost name wins.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, name)")]
    fn name(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "name", args, kwargs)
    }
    /// Asks for edges of length h, in the part's unit, on its faces; the innermost one wins.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, h)")]
    fn size(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "size", args, kwargs)
    }
    /// Moved by a vector (dx, dy, dz), in the part's unit.
    #[pyo3(name = "move", signature = (*args, **kwargs), text_signature = "($self, by)")]
    fn moved(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "move", args, kwargs)
    }
    /// Turned by so many degrees about an axis through a point, counter-clockwise seen from where the axis points to.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, degrees, axis='z', at=(0, 0, 0))")]
    fn rotate(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "rotate", args, kwargs)
    }
    /// Scaled about the origin by a positive factor.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, k)")]
    fn scale(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "scale", args, kwargs)
    }
    /// Mirrored in the plane square to an axis through a point.
    #[pyo3(signature = (*args, **kwargs), text_signature = "($self, axis, at=(0, 0, 0))")]
    fn mirror(&self, py: Python<'_>, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        self.then(py, "mirror", args, kwargs)
    }

    #[pyo3(signature = (function, types, args, kwargs))]
    fn __array_function__(
        &self,
        py: Python<'_>,
        function: &Bound<'_, PyAny>,
        types: &Bound<'_, PyAny>,
        args: &Bound<'_, PyTuple>,
        kwargs: &Bound<'_, PyDict>,
    ) -> PyResult<Py<PyAny>> {
        let _ = types;
        array_function(py, function, args, kwargs)
    }

    fn __repr__(&self) -> String {
        "<rvachev.Solid>".into()
    }
}

/// Solids among arguments that are solids or hold some.
fn solids(args: &Bound<'_, PyTuple>, name: &str) -> PyResult<Vec<Solid>> {
    let wrong = |v: &Bound<'_, PyAny>| {
        let kind = v.get_type().name().map_or_else(|_| "this".into(), |n| n.to_string());
        PyTypeError::new_err(format!("{name}() takes solids, or lists of them, not {kind}"))
    };
    let mut all = Vec::new();
    for a in args.iter() {
        if let Ok(s) = a.cast::<PySolid>() {
            all.push(s.get().solid.clone());
            continue;
        }
        if !a.hasattr("__iter__")? {
            return Err(wrong(&a));
        }
        for v in a.try_iter()? {
            let v = v?;
            all.push(v.cast::<PySolid>().map_err(|_| wrong(&v))?.get().solid.clone());
        }
    }
    if all.is_empty() {
        return Err(PyValueError::new_err(format!("{name}() needs at least one solid")));
    }
    Ok(all)
}

/// union(*solids): the union of solids, or of those in lists and generators.
#[pyfunction]
#[pyo3(signature = (*solids))]
pub fn union(solids: &Bound<'_, PyTuple>) -> PyResult<PySolid> {
    Ok(Solid::union(self::solids(solids, "union")?).into())
}

/// intersection(*solids): the intersection of solids, or of those in lists and generators.
#[pyfunction]
#[pyo3(signature = (*solids))]
pub fn intersection(solids: &Bound<'_, PyTuple>) -> PyResult<PySolid> {
    Ok(Solid::intersection(self::solids(solids, "intersection")?).into())
}

/// blend(a, b, radius): the union of two solids with a fillet of a radius, in the part's unit, between their faces.
#[pyfunction]
pub fn blend(py: Python<'_>, a: &Bound<'_, PySolid>, b: &Bound<'_, PySolid>, radius: f64) -> PyResult<PySolid> {
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(raise(py, &input(format!("\"radius\" of blend() must be positive, not {radius}"), "")));
    }
    Ok(a.get().solid.clone().blend(b.get().solid.clone(), radius).into())
}

/// extruded(figure, height): a solid that is the same at every z, from z = -height / 2 to height / 2.
#[pyfunction]
pub fn extruded(py: Python<'_>, figure: &Bound<'_, PySolid>, height: f64) -> PyResult<PySolid> {
    figure.get().solid.clone().extruded(height).map(PySolid::from).map_err(|e| raise(py, &e))
}

/// revolved(figure): a solid that is the same at every z, turned: its x becomes the radius, its y becomes z.
#[pyfunction]
pub fn revolved(py: Python<'_>, figure: &Bound<'_, PySolid>) -> PyResult<PySolid> {
    figure.get().solid.clone().revolved().map(PySolid::from).map_err(|e| raise(py, &e))
}

/// made(kind, function, *args, **kwargs): a solid, a chain of edges or something built, as a part file makes it.
#[pyfunction]
#[pyo3(signature = (kind, function, *args, **kwargs))]
pub fn made(
    py: Python<'_>,
    kind: &str,
    function: &str,
    args: &Bound<'_, PyTuple>,
    kwargs: Option<&Bound<'_, PyDict>>,
) -> PyResult<Py<PyAny>> {
    let text = call(function, args, kwargs)?;
    match kind {
        "edges" => Ok(Py::new(py, Edges::new(py, text)?)?.into_any()),
        "built" => Ok(Py::new(py, Built::new(py, text)?)?.into_any()),
        _ => match read(py, &format!("part({text})"))?.solid {
            Some(solid) => Ok(Py::new(py, PySolid::from(solid))?.into_any()),
            None => Err(PyValueError::new_err(format!("{function}() makes no solid"))),
        },
    }
}

/// solid(f): where a formula or comparison of x, y, z is positive, or a function of x, y, z is.
///
/// A function is called once with formulas for x, y and z. If it gives a formula or comparison the solid is that: edges inside it
/// are exact, and Python is not asked again. If it does not (it tests values, or calls what only takes numbers) the solid is a
/// field: the function is called with three arrays of shape (N,) and returns one, and a warning says so.
#[pyfunction]
pub fn solid(py: Python<'_>, f: &Bound<'_, PyAny>) -> PyResult<PySolid> {
    if let Some(known) = known(f) {
        return Ok(known);
    }
    let constant = || {
        let help = "solid(f >= 0) is where f is not negative";
        raise(py, &input("the condition does not depend on x, y, z", help))
    };
    if formula(f).is_some() {
        return Err(constant());
    }
    if !f.is_callable() {
        let kind = f.get_type().name()?;
        return Err(PyTypeError::new_err(format!("solid() takes a formula, a comparison or a function, not {kind}")));
    }
    let coordinate = |e: Expr| PyExpr { expr: e };
    let why = match f.call1((coordinate(Expr::x()), coordinate(Expr::y()), coordinate(Expr::z()))) {
        Ok(found) => {
            if let Some(known) = known(&found) {
                return Ok(known);
            }
            if formula(&found).is_some() {
                return Err(constant());
            }
            format!("it returns {}", found.get_type().name()?)
        }
        Err(e)
            if e.is_instance_of::<PyTypeError>(py)
                || e.is_instance_of::<PyAttributeError>(py)
                || e.is_instance_of::<PyValueError>(py)
                || e.is_instance_of::<PyNotImplementedError>(py) =>
        {
            e.value(py).to_string()
        }
        Err(e) => return Err(e),
    };
    let text = format!(
        "the function is no formula of x, y, z ({why}): it is called with arrays, and edges inside it are found, not known"
    );
    warn(py, "NotTraced", &text)?;
    Ok(Solid::field(PyField::of_coordinates(f.clone().unbind())).into())
}

/// A formula or comparison, as it is or in an array of one object.
fn known(v: &Bound<'_, PyAny>) -> Option<PySolid> {
    if let Ok(s) = v.cast::<PySolid>() {
        return Some(s.get().clone());
    }
    if let Ok(e) = v.cast::<PyExpr>() {
        return Some(PySolid::where_positive(e.get().expr.clone()));
    }
    None
}
