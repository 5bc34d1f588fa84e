//! Meshes brick by brick, made by any executor of Python's: tasks and pieces go to other processes and back.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use rvachev::pipeline::{self, BrickPlan, PlanSource};

use crate::errors::{input, raise};
use crate::mesh::PyMesh;
use crate::options::Options;
use crate::part::{PyPart, given, sized};
use crate::work::Listeners;

/// A brick to be made: what `mesh_brick` takes. It can be pickled.
#[pyclass(frozen, name = "Task", module = "rvachev")]
pub struct PyTask {
    plan: Arc<BrickPlan>,
    brick: u32,
}

/// A brick that was made: what `merge` takes. It can be pickled.
#[pyclass(frozen, name = "Piece", module = "rvachev")]
pub struct PyPiece {
    plan: Arc<BrickPlan>,
    brick: u32,
    bytes: Vec<u8>,
}

fn again<'py>(py: Python<'py>, name: &str, args: Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyTuple>> {
    (py.import("rvachev._rvachev")?.getattr(name)?, args).into_pyobject(py)
}

#[pymethods]
impl PyTask {
    /// The number of the brick.
    #[getter]
    fn brick(&self) -> u32 {
        self.brick
    }

    /// How many regions of 8 by 8 by 8 cells may hold some of the surface: what it costs, about.
    #[getter]
    fn cost(&self) -> u32 {
        self.plan.costs.get(self.brick as usize).copied().unwrap_or(0)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let plan = self.plan.to_json().map_err(|e| raise(py, &e))?;
        again(py, "task_again", (plan, self.brick).into_pyobject(py)?)
    }

    fn __repr__(&self) -> String {
        format!("<rvachev.Task: brick {} of {}>", self.brick, self.plan.costs.len())
    }
}

#[pymethods]
impl PyPiece {
    /// The number of the brick.
    #[getter]
    fn brick(&self) -> u32 {
        self.brick
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let plan = self.plan.to_json().map_err(|e| raise(py, &e))?;
        again(py, "piece_again", (plan, self.brick, PyBytes::new(py, &self.bytes)).into_pyobject(py)?)
    }

    fn __repr__(&self) -> String {
        format!("<rvachev.Piece: brick {} of {}, {} bytes>", self.brick, self.plan.costs.len(), self.bytes.len())
    }
}

fn parsed(py: Python<'_>, plan: &str) -> PyResult<Arc<BrickPlan>> {
    BrickPlan::parse(plan).map(Arc::new).map_err(|e| raise(py, &e))
}

/// A task that was pickled.
#[pyfunction]
pub fn task_again(py: Python<'_>, plan: &str, brick: u32) -> PyResult<PyTask> {
    Ok(PyTask { plan: parsed(py, plan)?, brick })
}

/// A piece that was pickled.
#[pyfunction]
pub fn piece_again(py: Python<'_>, plan: &str, brick: u32, bytes: Vec<u8>) -> PyResult<PyPiece> {
    Ok(PyPiece { plan: parsed(py, plan)?, brick, bytes })
}

/// plan(part, size=None, *, bricks, **options): the bricks of a mesh, as tasks for `mesh_brick`.
///
/// part: a part file, or a Part read from one: other processes get its text.
/// size: the length of edges in the part's unit, or a share of the diagonal such as "2%". bricks: how many along x, y and z.
#[pyfunction]
#[pyo3(signature = (part, size=None, *, bricks, **options))]
pub fn plan(
    py: Python<'_>,
    part: &Bound<'_, PyAny>,
    size: Option<&Bound<'_, PyAny>>,
    bricks: [u32; 3],
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<PyTask>> {
    let o = sized(Options::new(options, &[])?, size)?;
    let source = if let Ok(part) = part.cast::<PyPart>() {
        part.get().plan_source().ok_or_else(|| {
            raise(py, &input("only parts read from files go to other processes", "rv.plan(\"part.py\", ...)"))
        })?
    } else {
        let path: PathBuf = part.extract()?;
        PlanSource::read(&path, &o.define).map_err(|e| raise(py, &e))?
    };
    let how = o.mesh;
    let plan = Arc::new(o.listeners.work(py, |run| BrickPlan::new(source, &how, bricks, run))?);
    Ok((0..plan.rounds()[0]).map(|brick| PyTask { plan: plan.clone(), brick }).collect())
}

/// mesh_brick(task): makes a brick. It needs nothing of the others.
#[pyfunction]
pub fn mesh_brick(py: Python<'_>, task: &PyTask) -> PyResult<PyPiece> {
    let (plan, brick) = (task.plan.clone(), task.brick);
    let bytes = Listeners::default().work(py, |run| pipeline::make_piece(&plan, brick, run))?;
    Ok(PyPiece { plan, brick, bytes })
}

/// merge(pieces, **options): the mesh of all bricks of a plan.
#[pyfunction]
#[pyo3(signature = (pieces, **options))]
pub fn merge(py: Python<'_>, pieces: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyMesh> {
    let o = Options::new(options, &[])?;
    let items: Vec<Bound<'_, PyPiece>> =
        pieces.try_iter()?.map(|p| Ok(p?.cast_into::<PyPiece>()?)).collect::<PyResult<_>>()?;
    let Some(first) = items.first() else { return Err(PyValueError::new_err("there are no pieces to merge")) };
    let plan = first.get().plan.clone();
    let all: Vec<(u32, &[u8])> = items.iter().map(|p| (p.get().brick, &p.get().bytes[..])).collect();
    let made = o.listeners.work(py, |run| pipeline::merge_pieces(&plan, all, run))?;
    given(py, made, o.force)
}
