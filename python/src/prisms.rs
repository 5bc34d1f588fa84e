//! Volumes in layers of prisms, which a face of a mesh sweeps, and of hexahedra in place of pairs of them.

use std::path::{Path, PathBuf};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::DVec3;
use rvachev::Run;
use rvachev::io::{WriteOptions, Written, check_writable, write_hexahedra, write_prisms};
use rvachev::mesh::{Hexahedra, OuterSide, Prisms, TriMesh};

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

/// Points as float64 (n, 3).
fn places<'py>(py: Python<'py>, nodes: &[DVec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = nodes.iter().flat_map(|p| p.to_array()).collect();
    flat.into_pyarray(py).reshape([nodes.len(), 3])
}

/// Corners of cells as int64 (m, N).
fn corners<'py, const N: usize>(py: Python<'py>, cells: &[[u32; N]]) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let flat: Vec<i64> = cells.iter().flatten().map(|v| i64::from(*v)).collect();
    flat.into_pyarray(py).reshape([cells.len(), N])
}

/// A side by four points: a triangle has its third one twice.
fn four(corners: impl Iterator<Item = u32>) -> [u32; 4] {
    let all: Vec<u32> = corners.collect();
    std::array::from_fn(|k| all[k.min(all.len() - 1)])
}

/// The name of each side, an index.
fn labels<'py>(py: Python<'py>, outer: &[OuterSide]) -> Bound<'py, PyArray1<u32>> {
    outer.iter().map(|o| o.label).collect::<Vec<_>>().into_pyarray(py)
}

/// Sides of each name.
fn by_name<'py>(py: Python<'py>, outer: &[OuterSide], names: &[String]) -> PyResult<Bound<'py, PyDict>> {
    let mut all = vec![Vec::new(); names.len()];
    for (i, o) in (0i64..).zip(outer) {
        all[o.label as usize].push(i);
    }
    let out = PyDict::new(py);
    for (name, list) in names.iter().zip(all) {
        out.set_item(name, list.into_pyarray(py))?;
    }
    Ok(out)
}

/// Writes files one after the other, and warns of names they cannot hold.
fn written(
    py: Python<'_>,
    paths: &[PathBuf],
    msh_version: &str,
    write: impl Fn(&Path, &WriteOptions, &Run) -> rvachev::Result<Written> + Sync,
) -> PyResult<()> {
    let options = WriteOptions { old_msh: old_msh(py, msh_version)?, ..WriteOptions::default() };
    let told = Listeners::default().work(py, |run| {
        paths.iter().try_for_each(|p| check_writable(p))?;
        let mut told = Vec::new();
        for path in paths {
            for [name, now] in write(path, &options, run)?.renamed {
                told.push(format!("{}: the name {name} is written as {now}", path.display()));
            }
        }
        Ok(told)
    })?;
    told.iter().try_for_each(|text| warn(py, "Told", text))
}

#[pymethods]
impl PyPrisms {
    /// float64 (n, 3): coordinates in the part's unit.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        places(py, &self.prisms.nodes)
    }

    /// int64 (m, 6): points of each prism, three of the bottom and those across from them, as gmsh and Abaqus have them.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        corners(py, &self.prisms.cells)
    }

    /// int64 (k, 4): points of the sides on the boundary, counter-clockwise seen from outside; a triangle has its third one twice.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let sides: Vec<[u32; 4]> = self.prisms.outer.iter().map(|o| four(self.prisms.corners(o))).collect();
        corners(py, &sides)
    }

    /// uint32 (k,): the name of each side, an index into `names`.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        labels(py, &self.prisms.outer)
    }

    /// Names of sides: the face, what is across from it, walls.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.prisms.names.clone()
    }

    /// Sides of each name: name -> int64 (j,), ascending.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, &self.prisms.outer, &self.prisms.names)
    }

    /// The volume of all prisms, in the cubed unit of the part.
    #[getter]
    fn volume(&self) -> f64 {
        self.prisms.volume()
    }

    /// Hexahedra in place of pairs of prisms beside each other, in all layers alike, as `rvachev.Hexahedra`.
    ///
    /// No angle of their quadrilaterals at the bottom and the top is farther than `off` degrees from a right one, and no two triangles
    /// are folded by more: two equilateral ones are 30 degrees off. Prisms without a partner stay. Points, volume and names stay, too.
    /// Errors: `InputError` for `off` that is not a positive number.
    #[pyo3(signature = (off=45.0))]
    fn hexahedra(&self, py: Python<'_>, off: f64) -> PyResult<PyHexahedra> {
        if !(off > 0.0 && off.is_finite()) {
            return Err(raise(py, &input(format!("off must be a positive number of degrees, not {off}"), "")));
        }
        let mesh = Listeners::default().work(py, |_| self.prisms.hexahedra(off))?;
        Ok(PyHexahedra { mesh, volume: self.prisms.volume() })
    }

    /// Writes files, formats by extension: vtu, msh, inp, with sides by name.
    #[pyo3(signature = (*paths, msh_version="4.1"))]
    fn write(&self, py: Python<'_>, paths: Vec<PathBuf>, msh_version: &str) -> PyResult<()> {
        written(py, &paths, msh_version, |path, options, run| write_prisms(path, &self.prisms, options, run))
    }

    /// As a meshio.Mesh of cells `wedge`, `triangle` and `quad`, with names as cell sets.
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let cells = [("wedge", slf.get().cells(slf.py())?)];
        slf.py().import("rvachev._convert")?.call_method1("cells_to_meshio", (slf, cells))
    }

    fn __repr__(&self) -> String {
        format!("<rvachev.Prisms: {} points, {} prisms>", self.prisms.nodes.len(), self.prisms.cells.len())
    }
}

/// A volume in layers of hexahedra, and of prisms where triangles found no partner: what `Prisms.hexahedra` gives. Arrays are copies.
#[pyclass(frozen, name = "Hexahedra", module = "rvachev")]
pub struct PyHexahedra {
    mesh: Hexahedra,
    /// That of the prisms they are made of.
    volume: f64,
}

#[pymethods]
impl PyHexahedra {
    /// float64 (n, 3): coordinates in the part's unit; those of the prisms.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        places(py, &self.mesh.nodes)
    }

    /// int64 (m, 8): points of each hexahedron, four of the bottom and those across from them, as VTK, gmsh and Abaqus have them.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        corners(py, &self.mesh.hexahedra)
    }

    /// int64 (l, 6): points of the prisms beside them, as `Prisms.cells`.
    #[getter]
    fn prisms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        corners(py, &self.mesh.prisms)
    }

    /// int64 (k, 4): points of the sides on the boundary, counter-clockwise seen from outside; a triangle has its third one twice.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let sides: Vec<[u32; 4]> = self.mesh.outer.iter().map(|o| four(self.mesh.corners(o))).collect();
        corners(py, &sides)
    }

    /// uint32 (k,): the name of each side, an index into `names`.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        labels(py, &self.mesh.outer)
    }

    /// Names of sides: those of the prisms.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.mesh.names.clone()
    }

    /// Sides of each name: name -> int64 (j,), ascending.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, &self.mesh.outer, &self.mesh.names)
    }

    /// The volume of all cells, in the cubed unit of the part.
    #[getter]
    fn volume(&self) -> f64 {
        self.volume
    }

    /// Writes files, formats by extension: vtu, msh, inp, with sides by name.
    #[pyo3(signature = (*paths, msh_version="4.1"))]
    fn write(&self, py: Python<'_>, paths: Vec<PathBuf>, msh_version: &str) -> PyResult<()> {
        written(py, &paths, msh_version, |path, options, run| write_hexahedra(path, &self.mesh, options, run))
    }

    /// As a meshio.Mesh of cells `hexahedron`, `wedge`, `triangle` and `quad`, with names as cell sets.
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, me) = (slf.py(), slf.get());
        let cells = (("hexahedron", me.cells(py)?), ("wedge", me.prisms(py)?));
        py.import("rvachev._convert")?.call_method1("cells_to_meshio", (slf, cells))
    }

    fn __repr__(&self) -> String {
        let Hexahedra { nodes, hexahedra, prisms, .. } = &self.mesh;
        format!("<rvachev.Hexahedra: {} points, {} hexahedra, {} prisms>", nodes.len(), hexahedra.len(), prisms.len())
    }
}
