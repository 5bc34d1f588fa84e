//! Functions of Python as leaves: called with many points at once, their exceptions kept for the end of the run.

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use rvachev::DVec3;
use rvachev::implicit::{Field, GridField, Solid, Walls, differences};
use rvachev::spatial::Aabb;

use crate::arrays::{floats, table};
use crate::errors::{input, raise};
use crate::solid::PySolid;
use crate::work::watched;

/// A function of Python.
pub struct PyField {
    function: Py<PyAny>,
    /// Whether it takes three arrays of shape (N,) rather than one of shape (N, 3).
    by_coordinates: bool,
    gradient: Option<Py<PyAny>>,
    lipschitz: Option<f64>,
    /// Where it may be called.
    walls: Option<Walls>,
}

impl PyField {
    /// A function of three arrays.
    pub fn of_coordinates(function: Py<PyAny>) -> Self {
        PyField { function, by_coordinates: true, gradient: None, lipschitz: None, walls: None }
    }

    fn values_inside(&self, points: &[DVec3], out: &mut [f64]) {
        if self.ask(&self.function, points, out, 1).is_none() {
            out.fill(f64::NAN);
        }
    }

    /// Calls the function; exceptions stop the run, which raises them.
    fn ask(&self, function: &Py<PyAny>, points: &[DVec3], out: &mut [f64], width: usize) -> Option<()> {
        let watched = watched();
        if watched.as_ref().is_some_and(|w| w.token.is_cancelled()) {
            return None;
        }
        let asked = Python::attach(|py| self.call(py, function, points, (out, width)));
        match (asked, watched) {
            (Ok(()), _) => Some(()),
            (Err(e), Some(w)) => {
                w.fail(e);
                None
            }
            (Err(_), None) => None,
        }
    }

    fn call(
        &self,
        py: Python<'_>,
        function: &Py<PyAny>,
        points: &[DVec3],
        (out, width): (&mut [f64], usize),
    ) -> PyResult<()> {
        let function = function.bind(py);
        let n = points.len();
        let found = if self.by_coordinates {
            let axis = |k: usize| PyArray1::from_iter(py, points.iter().map(|p| p[k]));
            function.call1((axis(0), axis(1), axis(2)))?
        } else {
            let flat = PyArray1::from_iter(py, points.iter().flat_map(|p| p.to_array()));
            function.call1((flat.reshape([n, 3])?,))?
        };
        let found: PyReadonlyArrayDyn<'_, f64> = floats(&found).map_err(|e| {
            let what = format!("a field's function must return numbers in an array of shape {}", shape(n, width));
            let error = PyTypeError::new_err(what);
            error.set_cause(py, Some(e));
            error
        })?;
        let values = found.as_slice()?;
        let fits = match (width, found.shape()) {
            (1, []) => self.by_coordinates || n == 1,
            (1, [m]) => *m == n,
            (_, [m, w]) => *m == n && *w == width,
            _ => false,
        };
        if !fits {
            let got = found.shape().iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            let what = format!("a field's function must return shape {}, not ({got})", shape(n, width));
            return Err(PyValueError::new_err(what));
        }
        if values.len() == out.len() {
            out.copy_from_slice(values);
        } else {
            out.fill(values[0]);
        }
        Ok(())
    }
}

fn shape(n: usize, width: usize) -> String {
    if width == 1 { format!("({n},)") } else { format!("({n}, {width})") }
}

impl Field for PyField {
    fn value(&self, p: DVec3) -> f64 {
        let mut out = [f64::NAN];
        self.values(&[p], &mut out);
        out[0]
    }

    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        self.walls.unwrap_or_default().values(points, out, |p, v| self.values_inside(p, v));
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        self.gradient.as_ref()?;
        let (mut v, mut g) = ([f64::NAN], [DVec3::NAN]);
        self.gradients(&[p], &mut v, &mut g);
        Some(g[0])
    }

    fn gradients(&self, points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]) {
        let Some(gradient) = &self.gradient else {
            return differences(points, values, gradients, |p, v| self.values(p, v));
        };
        let inside = |points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]| {
            self.values_inside(points, values);
            let mut flat = vec![f64::NAN; 3 * points.len()];
            if self.ask(gradient, points, &mut flat, 3).is_none() {
                flat.fill(f64::NAN);
            }
            for (g, v) in gradients.iter_mut().zip(flat.chunks_exact(3)) {
                *g = DVec3::from_slice(v);
            }
        };
        self.walls.unwrap_or_default().gradients(points, values, gradients, inside);
    }

    fn walls(&self) -> Option<Walls> {
        self.walls
    }

    fn lipschitz(&self) -> Option<f64> {
        self.lipschitz
    }
}

/// field(function, *, gradient=None, lipschitz=None, bounds=None): where a function of points is positive, as a solid.
///
/// function: called with float64 (N, 3), coordinates in the part's unit, from any thread; gives float64 (N,), positive inside. The
/// same points must give the same values. Near the surface values should be roughly distances.
/// gradient: called with float64 (N, 3), gives (N, 3); differences of the function without.
/// lipschitz: values change by at most this much per length: what tells where no surface is. Without it every cell is asked.
/// bounds: ((x0, y0, z0), (x1, y1, z1)): the function is called inside only, and what reaches the walls is cut off there, along exact
/// edges.
#[pyfunction]
#[pyo3(signature = (function, *, gradient=None, lipschitz=None, bounds=None))]
pub fn field(
    py: Python<'_>,
    function: &Bound<'_, PyAny>,
    gradient: Option<&Bound<'_, PyAny>>,
    lipschitz: Option<f64>,
    bounds: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySolid> {
    for f in std::iter::once(function).chain(gradient) {
        if !f.is_callable() {
            return Err(PyTypeError::new_err(format!("field() takes functions, not {}", f.get_type().name()?)));
        }
    }
    if let Some(l) = lipschitz.filter(|l| !(*l > 0.0 && l.is_finite())) {
        return Err(raise(py, &input(format!("\"lipschitz\" of field() must be positive, not {l}"), "")));
    }
    let bounds = bounds.map(|b| domain(py, b)).transpose()?;
    let field = PyField {
        function: function.clone().unbind(),
        by_coordinates: false,
        gradient: gradient.map(|g| g.clone().unbind()),
        lipschitz,
        walls: bounds.map(Walls::new),
    };
    let solid = Solid::field(field);
    Ok(match bounds {
        Some(b) => (solid & Solid::cuboid(b.lo, b.hi)).into(),
        None => solid.into(),
    })
}

/// Two points as a box.
pub fn domain(py: Python<'_>, v: &Bound<'_, PyAny>) -> PyResult<Aabb> {
    let ends = table(v, "bounds")?;
    match &ends[..] {
        [lo, hi] if lo.is_finite() && hi.is_finite() && lo.cmplt(*hi).all() => Ok(Aabb::new(*lo, *hi)),
        [lo, hi] => {
            let what = format!("bounds need finite lo < hi in all three coordinates, not {lo} and {hi}");
            Err(raise(py, &input(what, "")))
        }
        _ => Err(raise(py, &input("bounds are two points: ((x0, y0, z0), (x1, y1, z1))", ""))),
    }
}

/// grid(values, origin=(0, 0, 0), spacing=1.0): where values on a grid of points, trilinear between them, are positive, as a solid.
///
/// values: float64 (nx, ny, nz), positive inside; values[i, j, k] is at origin + (i, j, k) * spacing. They are copied.
/// spacing: one number, or one for each axis, in the part's unit.
/// What reaches the walls of the grid is cut off there. Python is not called while the mesh is made.
#[pyfunction]
#[pyo3(signature = (values, origin=None, spacing=None))]
pub fn grid(
    py: Python<'_>,
    values: &Bound<'_, PyAny>,
    origin: Option<&Bound<'_, PyAny>>,
    spacing: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySolid> {
    let wrong = |what: String, help: &str| raise(py, &input(what, help));
    let values = floats(values)?;
    let &[nx, ny, nz] = values.shape() else {
        let got = values.shape().iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        return Err(wrong(format!("the values of a grid must have shape (nx, ny, nz), not ({got})"), ""));
    };
    let origin = origin.map_or(Ok(DVec3::ZERO), |v| three(v, "origin"))?;
    let spacing = spacing.map_or(Ok(DVec3::ONE), |v| three(v, "spacing"))?;
    if !(spacing.is_finite() && spacing.cmpgt(DVec3::ZERO).all() && origin.is_finite()) {
        let what = format!("a grid needs a finite origin and a positive spacing, not {origin} and {spacing}");
        return Err(wrong(what, ""));
    }
    let far = origin + spacing * DVec3::new(nx as f64, ny as f64, nz as f64).map(|n| (n - 1.0).max(1.0));
    // The library has x running fastest, numpy z.
    let given = values.as_slice()?;
    let mut sorted = Vec::with_capacity(given.len());
    for k in 0..nz {
        for j in 0..ny {
            sorted.extend((0..nx).map(|i| given[k + nz * (j + ny * i)]));
        }
    }
    let field = GridField::new([nx, ny, nz], Aabb::new(origin, far), sorted).map_err(|e| raise(py, &e))?;
    Ok(field.into_solid().into())
}

/// A number for all three axes, or one for each.
fn three(v: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    let array = floats(v)?;
    match (array.shape(), array.as_slice()?) {
        ([] | [1], [a]) if name == "spacing" => Ok(DVec3::splat(*a)),
        ([3], [a, b, c]) => Ok(DVec3::new(*a, *b, *c)),
        _ => Err(raise(v.py(), &input(format!("\"{name}\" of grid() is a point or vector of three numbers"), ""))),
    }
}
