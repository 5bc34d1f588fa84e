//! Volumes in layers of prisms, which a face of a mesh sweeps.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::io::{WriteOptions, check_writable, write_prisms};
use rvachev::mesh::{Prisms, TriMesh};

use crate::arrays::table;
use crate::errors::{input, raise, warn};
use crate::mesh::old_msh;
use crate::work::Listeners;

/// A volume in layers of prisms: what `Mesh.sweep` gives. Arrays are copies.
#[pyclass(frozen, name = "Prisms", module = "rvachev")]
pub struct PyPrisms {
    prisms: Prisms,
}

/// What is to be filled.
pub struct Sweep<'a, 'py> {
    /// The name of the bottom.
    pub face: &'a str,
    /// Along a vector.
    pub along: Option<&'a Bound<'py, PyAny>>,
    /// To another face.
    pub to: Option<&'a str>,
    /// How many layers.
    pub layers: u32,
}

impl PyPrisms {
    /// The prisms over a face of a mesh.
    pub fn of(py: Python<'_>, mesh: &TriMesh, sweep: &Sweep<'_, '_>) -> PyResult<Self> {
        let made = match (sweep.along, sweep.to) {
            (Some(v), None) => {
                let row = v.py().import("numpy")?.call_method1("reshape", (v, (1, -1)))?;
                Prisms::swept(mesh, sweep.face, table(&row, "along")?[0], sweep.layers)
            }
            (None, Some(to)) => Prisms::between(mesh, sweep.face, to, sweep.layers),
            _ => {
                let what = "a face is swept along a vector or to another face: one of the two is to be said";
                return Err(raise(py, &input(what, "sweep(\"body.zmin\", along=(0, 0, 1), layers=4)")));
            }
        };
        Ok(PyPrisms { prisms: made.map_err(|e| raise(py, &e))? })
    }
}

#[pymethods]
impl PyPrisms {
    /// float64 (n, 3): coordinates in the part's unit.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat: Vec<f64> = self.prisms.nodes.iter().flat_map(|p| p.to_array()).collect();
        flat.into_pyarray(py).reshape([self.prisms.nodes.len(), 3])
    }

    /// int64 (m, 6): points of each prism, three of the bottom and those across from them, as gmsh and Abaqus have them.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let flat: Vec<i64> = self.prisms.cells.iter().flatten().map(|v| i64::from(*v)).collect();
        flat.into_pyarray(py).reshape([self.prisms.cells.len(), 6])
    }

    /// int64 (k, 4): points of the sides on the boundary, counter-clockwise seen from outside; a triangle has its third one twice.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let mut flat: Vec<i64> = Vec::with_capacity(4 * self.prisms.outer.len());
        for o in &self.prisms.outer {
            let corners: Vec<i64> = self.prisms.corners(o).map(i64::from).collect();
            flat.extend((0..4).map(|k| corners[k.min(corners.len() - 1)]));
        }
        flat.into_pyarray(py).reshape([self.prisms.outer.len(), 4])
    }

    /// uint32 (k,): the name of each side, an index into `names`.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.prisms.outer.iter().map(|o| o.label).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Names of sides: the face, what is across from it, walls.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.prisms.names.clone()
    }

    /// Sides of each name: name -> int64 (j,), ascending.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut all = vec![Vec::new(); self.prisms.names.len()];
        for (i, o) in (0i64..).zip(&self.prisms.outer) {
            all[o.label as usize].push(i);
        }
        let out = PyDict::new(py);
        for (name, list) in self.prisms.names.iter().zip(all) {
            out.set_item(name, list.into_pyarray(py))?;
        }
        Ok(out)
    }

    /// The volume of all prisms, in the cubed unit of the part.
    #[getter]
    fn volume(&self) -> f64 {
        self.prisms.volume()
    }

    /// Writes files, formats by extension: vtu, msh, inp, with sides by name.
    #[pyo3(signature = (*paths, msh_version="4.1"))]
    fn write(&self, py: Python<'_>, paths: Vec<PathBuf>, msh_version: &str) -> PyResult<()> {
        let options = WriteOptions { old_msh: old_msh(py, msh_version)?, ..WriteOptions::default() };
        let told = Listeners::default().work(py, |run| {
            paths.iter().try_for_each(|p| check_writable(p))?;
            let mut told = Vec::new();
            for path in &paths {
                for [name, now] in write_prisms(path, &self.prisms, &options, run)?.renamed {
                    told.push(format!("{}: the name {name} is written as {now}", path.display()));
                }
            }
            Ok(told)
        })?;
        told.iter().try_for_each(|text| warn(py, "Told", text))
    }

    /// As a meshio.Mesh of cells `wedge`, `triangle` and `quad`, with names as cell sets.
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("prisms_to_meshio", (slf,))
    }

    fn __repr__(&self) -> String {
        format!("<rvachev.Prisms: {} points, {} prisms>", self.prisms.nodes.len(), self.prisms.cells.len())
    }
}
