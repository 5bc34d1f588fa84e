//! Meshes: arrays on the library's own memory, faces and groups by name, the report, files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyIterator, PyTuple};
use rvachev::implicit::part::glob;
use rvachev::io::{self, Format, Grouping, Names, Renamed, WriteOptions};
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::page::{PageText, page};
use rvachev::pipeline::{self, Healed, Meshed};
use rvachev::{DVec3, Error, Run};

use crate::errors::{input, raise, warn};
use crate::options::{Options, positive};
use crate::pickle::About;
use crate::prisms::{PyPrisms, Sweep};
use crate::work::Listeners;

/// Where a mesh comes from.
enum Source {
    Made(Box<Meshed>),
    Healed(Healed),
    /// Out of a pickle.
    Again(Box<(TriMesh, About)>),
}

/// A notebook shows meshes of so many triangles, some ten megabytes.
const MOST_SHOWN: usize = 300_000;

/// Whether files of gmsh are to be of its old version.
pub fn old_msh(py: Python<'_>, version: &str) -> PyResult<bool> {
    match version {
        "4.1" => Ok(false),
        "2.2" => Ok(true),
        other => Err(raise(py, &Error::Usage(format!("msh_version is \"4.1\" or \"2.2\", not {other:?}")))),
    }
}

/// JSON as dicts and lists.
fn loads<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// A value of the library as JSON.
pub fn to_json(value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string(value).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))
}

/// A mesh of triangles: `points, triangles = mesh`.
///
/// Points are float64 (n, 3) in the part's unit, triangles int64 (m, 3), counter-clockwise seen from outside. Arrays lie on the
/// library's memory and cannot be written to; `.copy()` makes one's own.
#[pyclass(frozen, name = "Mesh", module = "rvachev")]
pub struct PyMesh {
    source: Source,
    /// Node numbers, three for each triangle.
    triangles: Vec<i64>,
    faces: PyOnceLock<Py<PyDict>>,
    groups: PyOnceLock<Py<PyDict>>,
    report: PyOnceLock<Py<PyAny>>,
}

/// A value of the library as dicts and lists.
pub fn from_json<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    loads(py, &to_json(value).map_err(|e| raise(py, &e))?)
}

/// Points as numbers, three for each.
fn flat(points: &[DVec3]) -> &[f64] {
    const { assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>()) };
    // SAFETY: a DVec3 is three f64 in order without padding (repr(C)), as long and aligned as asserted above.
    unsafe { std::slice::from_raw_parts(points.as_ptr().cast(), 3 * points.len()) }
}

impl PyMesh {
    fn new(source: Source) -> Self {
        let mesh = match &source {
            Source::Made(m) => &m.mesh,
            Source::Healed(h) => &h.mesh,
            Source::Again(a) => &a.0,
        };
        let triangles = mesh.triangles.iter().flatten().map(|v| i64::from(*v)).collect();
        let (faces, groups, report) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        PyMesh { source, triangles, faces, groups, report }
    }

    /// What the stages made.
    pub fn made(made: Meshed) -> Self {
        Self::new(Source::Made(Box::new(made)))
    }

    /// What healing made.
    pub fn healed(healed: Healed) -> Self {
        Self::new(Source::Healed(healed))
    }

    /// What was pickled.
    pub fn again(mesh: TriMesh, about: About) -> Self {
        Self::new(Source::Again(Box::new((mesh, about))))
    }

    /// The mesh itself.
    pub fn mesh(&self) -> &TriMesh {
        match &self.source {
            Source::Made(m) => &m.mesh,
            Source::Healed(h) => &h.mesh,
            Source::Again(a) => &a.0,
        }
    }

    fn seams_and_corners(&self) -> (&[[u32; 2]], &[u32]) {
        match &self.source {
            Source::Made(m) => (&m.seams, &m.corners),
            Source::Healed(_) => (&[], &[]),
            Source::Again(a) => (&a.1.seams, &a.1.corners),
        }
    }

    fn short(&self) -> Vec<String> {
        match &self.source {
            Source::Made(m) => m.report.shortfalls.iter().map(ToString::to_string).collect(),
            Source::Healed(h) => h.report.shortfalls.clone(),
            Source::Again(a) => a.1.shortfalls.clone(),
        }
    }

    /// Warns of what is worth knowing. A mesh that is not sound is an error, unless it is wanted all the same.
    pub fn tell(&self, py: Python<'_>, force: bool) -> PyResult<()> {
        if let Source::Made(m) = &self.source {
            let unsound = m.report.check.as_ref().map(|c| &c.certificate).filter(|c| !c.is_sound());
            if let (Some(c), false) = (unsound, force) {
                let what = format!("the mesh is not sound ({c}); force=True gives it all the same");
                return Err(raise(py, &Error::Failed(what)));
            }
            for text in &m.report.warnings {
                warn(py, "Told", text)?;
            }
        }
        for text in self.short() {
            warn(py, "Shortfall", &text)?;
        }
        Ok(())
    }

    /// Triangles of faces, by face.
    fn by_face(&self) -> Vec<Vec<i64>> {
        let mesh = self.mesh();
        let mut all = vec![Vec::new(); mesh.faces.len()];
        for (t, label) in (0i64..).zip(&mesh.labels) {
            all[*label as usize].push(t);
        }
        all
    }

    /// Faces a name stands for: a group, else faces by name or pattern.
    fn named(&self, name: &str) -> Vec<u32> {
        let mesh = self.mesh();
        match mesh.groups.iter().find(|g| g.name == name) {
            Some(g) => g.faces.clone(),
            None => (0u32..).zip(&mesh.faces).filter(|(_, f)| glob(name, f)).map(|(i, _)| i).collect(),
        }
    }
}

/// An array that lies on memory of `owner`, which it keeps alive; it cannot be written to.
fn locked<'py, T>(array: &Bound<'py, T>) -> PyResult<()>
where
    Bound<'py, T>: std::ops::Deref<Target = Bound<'py, PyAny>>,
{
    let flags = PyDict::new(array.py());
    flags.set_item("write", false)?;
    array.call_method("setflags", (), Some(&flags))?;
    Ok(())
}

fn borrowed<'py, T: numpy::Element>(owner: &Bound<'py, PyMesh>, data: &[T]) -> PyResult<Bound<'py, PyArray2<T>>> {
    let view = ArrayView2::from_shape((data.len() / 3, 3), data).map_err(|e| PyTypeError::new_err(e.to_string()))?;
    // SAFETY: the data are in the frozen mesh, which never changes them and lives as long as the array; nobody writes.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone().into_any()) };
    locked(&array)?;
    Ok(array)
}

#[pymethods]
impl PyMesh {
    /// float64 (n, 3): coordinates in the part's unit.
    #[getter]
    fn points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        borrowed(slf, flat(&slf.get().mesh().nodes))
    }

    /// int64 (m, 3): points of each triangle, counter-clockwise seen from outside.
    #[getter]
    fn triangles<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        borrowed(slf, &slf.get().triangles)
    }

    /// uint32 (m,): the face of each triangle, an index into `face_names`.
    #[getter]
    fn labels<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let view = ArrayView1::from(&slf.get().mesh().labels);
        // SAFETY: as in `borrowed`.
        let array = unsafe { PyArray1::borrow_from_array(&view, slf.clone().into_any()) };
        locked(&array)?;
        Ok(array)
    }

    /// Names of the faces that have triangles.
    #[getter]
    fn face_names(&self) -> Vec<String> {
        self.mesh().faces.clone()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let both = [Self::points(slf)?.into_any(), Self::triangles(slf)?.into_any()];
        PyTuple::new(slf.py(), both)?.try_iter()
    }

    /// Triangles of each face: name -> int64 (k,), ascending.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let made = self.faces.get_or_try_init(py, || -> PyResult<Py<PyDict>> {
            let out = PyDict::new(py);
            for (name, list) in self.mesh().faces.iter().zip(self.by_face()) {
                out.set_item(name, list.into_pyarray(py))?;
            }
            Ok(out.unbind())
        })?;
        made.bind(py).copy()
    }

    /// Triangles of each group: name -> int64 (k,), ascending.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let made = self.groups.get_or_try_init(py, || -> PyResult<Py<PyDict>> {
            let (out, by_face) = (PyDict::new(py), self.by_face());
            for g in &self.mesh().groups {
                let mut list: Vec<i64> = g.faces.iter().flat_map(|f| &by_face[*f as usize]).copied().collect();
                list.sort_unstable();
                out.set_item(&g.name, list.into_pyarray(py))?;
            }
            Ok(out.unbind())
        })?;
        made.bind(py).copy()
    }

    /// int64 (k,): points of the triangles of a group, or of faces whose names fit a pattern; ascending, those on borders
    /// included. KeyError where there is none.
    fn nodes<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let mesh = self.mesh();
        let faces = self.named(name);
        if faces.is_empty() && !mesh.groups.iter().any(|g| g.name == name) {
            return Err(PyKeyError::new_err(format!("there is no group and no face {name:?}")));
        }
        let mut wanted = vec![false; mesh.faces.len()];
        faces.iter().for_each(|f| wanted[*f as usize] = true);
        let mut on = vec![false; mesh.nodes.len()];
        for (t, label) in mesh.triangles.iter().zip(&mesh.labels) {
            if wanted[*label as usize] {
                t.iter().for_each(|v| on[*v as usize] = true);
            }
        }
        let list: Vec<i64> = (0i64..).zip(on).filter(|(_, on)| *on).map(|(v, _)| v).collect();
        Ok(list.into_pyarray(py))
    }

    /// int64 (k, 2): edges between two faces, where two surfaces of one face meet, and open ones.
    #[getter]
    fn feature_edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let mesh = self.mesh();
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, label) in mesh.triangles.iter().zip(&mesh.labels) {
            sides.extend((0..3).map(|k| {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                ([a.min(b), a.max(b)], *label)
            }));
        }
        sides.sort_unstable();
        let mut edges: Vec<[u32; 2]> = sides
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|at| !matches!(at, [a, b] if a.1 == b.1))
            .map(|at| at[0].0)
            .collect();
        edges.extend(self.seams_and_corners().0.iter().map(|[a, b]| [*a.min(b), *a.max(b)]));
        edges.sort_unstable();
        edges.dedup();
        let flat: Vec<i64> = edges.iter().flatten().map(|v| i64::from(*v)).collect();
        flat.into_pyarray(py).reshape([edges.len(), 2])
    }

    /// int64 (k,): points where borders of faces end or meet, and apexes. Empty where the method does not know them.
    #[getter]
    fn corners<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let list: Vec<i64> = self.seams_and_corners().1.iter().map(|v| i64::from(*v)).collect();
        list.into_pyarray(py)
    }

    /// float64 (m, 3): outward unit normals of the triangles; zero where one has no area.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let mesh = self.mesh();
        let flat: Vec<f64> = (0..mesh.triangles.len()).flat_map(|t| mesh.normal(t).to_array()).collect();
        flat.into_pyarray(py).reshape([mesh.triangles.len(), 3])
    }

    /// What is known of the mesh, as docs/report.md describes it (for healed meshes: what was repaired).
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let made = self.report.get_or_try_init(py, || -> PyResult<Py<PyAny>> {
            Ok(match &self.source {
                Source::Made(m) => from_json(py, &m.report)?,
                Source::Healed(h) => from_json(py, &h.report)?,
                Source::Again(a) => loads(py, &a.1.report)?,
            }
            .unbind())
        })?;
        Ok(made.bind(py).clone())
    }

    /// What the mesh is certified for: `faults` is empty for a sound one.
    #[getter]
    fn certificate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match &self.source {
            Source::Made(m) => match &m.report.check {
                Some(c) => from_json(py, &c.certificate),
                None => Ok(py.None().into_bound(py)),
            },
            Source::Again(a) => loads(py, &a.1.certificate),
            Source::Healed(h) => {
                let (mesh, options) = (&h.mesh, rvachev::quality::Expectation::default());
                let check = Listeners::default().work(py, |run| rvachev::quality::check(mesh, options, None, run))?;
                from_json(py, &check.certificate)
            }
        }
    }

    /// Where the mesh falls short of what was asked, one sentence each.
    #[getter]
    fn shortfalls(&self) -> Vec<String> {
        self.short()
    }

    /// The unit of the part it was made of, where one was said.
    #[getter]
    fn units(&self) -> Option<String> {
        if let Source::Made(m) = &self.source { m.report.units.clone() } else { None }
    }

    /// Writes files, formats by extension: msh, inp, bdf, vtu, vtp, stl, obj, ply, off, mesh, su2, emesh, geo, 3mf, glb, xdmf. Beside those
    /// that name sets of triangles a list of the names, NAME.names.json.
    #[pyo3(signature = (*paths, groups="all", msh_version="4.1"))]
    fn write(&self, py: Python<'_>, paths: Vec<PathBuf>, groups: &str, msh_version: &str) -> PyResult<()> {
        let groups = match groups {
            "faces" => Grouping::Faces,
            "user" => Grouping::User,
            "all" => Grouping::All,
            other => {
                let what = format!("groups is \"faces\", \"user\" or \"all\", not {other:?}");
                return Err(raise(py, &Error::Usage(what)));
            }
        };
        let old_msh = old_msh(py, msh_version)?;
        let (seams, corners) = self.seams_and_corners();
        let options = WriteOptions {
            groups,
            old_msh,
            seams: seams.to_vec(),
            corners: corners.to_vec(),
            unit: self.units(),
            ..WriteOptions::default()
        };
        let told = Listeners::default().work(py, |run| match &self.source {
            Source::Made(m) => write_files(&paths, &m.merged()?, &options, run),
            Source::Healed(_) | Source::Again(_) => write_files(&paths, self.mesh(), &options, run),
        })?;
        told.iter().try_for_each(|text| warn(py, "Told", text))
    }

    /// As a meshio.Mesh, with the number of the face in cell data `face`, and faces and groups as cell sets.
    fn to_meshio<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("to_meshio", (slf,))
    }

    /// As a trimesh.Trimesh with the same points in the same order; the number of the face is in `face_attributes["face"]`.
    fn to_trimesh<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("to_trimesh", (slf,))
    }

    /// As a pyvista.PolyData, with the number of the face in cell data `face`.
    fn to_pyvista<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("to_pyvista", (slf,))
    }

    /// As a netgen.meshing.Mesh of the surface: boundary conditions, from 1, have the names of faces. GenerateVolumeMesh() fills it.
    fn to_netgen<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("to_netgen", (slf,))
    }

    /// As a model of gmsh, which becomes the current one, with a discrete surface for each face, physical groups for faces and
    /// groups, and volumes to be filled: gmsh.model.mesh.generate(3). Node i has the tag i + 1. Starts gmsh if need be; ending it
    /// is the caller's. Gives the name of the model. Errors: `InputError` for a surface that bounds no solid.
    #[pyo3(signature = (name="rvachev"))]
    fn to_gmsh<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._convert")?.call_method1("to_gmsh", (slf, name))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, me) = (slf.py(), slf.get());
        let mesh = me.mesh();
        let text = |value: Bound<'py, PyAny>| py.import("json")?.call_method1("dumps", (value,))?.extract::<String>();
        let (seams, corners) = me.seams_and_corners();
        let about = About {
            faces: mesh.faces.clone(),
            groups: mesh.groups.iter().map(|g| (g.name.clone(), g.faces.clone())).collect(),
            seams: seams.to_vec(),
            corners: corners.to_vec(),
            report: text(me.report(py)?)?,
            certificate: text(me.certificate(py)?)?,
            shortfalls: me.short(),
        };
        let how = py.import("rvachev._rvachev")?.getattr("mesh_again")?;
        let state = (Self::points(slf)?, Self::triangles(slf)?, Self::labels(slf)?, about);
        (how, state).into_pyobject(py)
    }

    /// The mesh with one face made anew with edges of length `size`, in the part's unit: another `Mesh`, this one stays.
    /// Curvature and the face's border may ask for shorter edges. Points float64 (n, 3) and triangles int64 (m, 3) of other faces
    /// keep their values bit by bit and their order, and so does the face's border; new points and triangles come last. Names and groups
    /// stay, and the report is made anew. Options: progress, cancel, threads, force.
    /// Errors: `InputError` for a name no face has (patterns and groups are none), a size that is not positive or far too small, a mesh
    /// that was healed, pickled or joined of several solids or is a plane figure, and a face that does not lie on one surface
    /// between its borders, as by methods other than `leaf`, or has creases inside in a CAD model; `Failed` where the border cannot be kept, or the mesh is not sound without force.
    #[pyo3(signature = (name, size, **options))]
    fn remesh_face(
        &self,
        py: Python<'_>,
        name: &str,
        size: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let o = Options::new(options, &["progress", "cancel", "threads", "force"])?;
        let size = positive(size, "size")?;
        let Source::Made(made) = &self.source else {
            let what =
                "a face is meshed anew on the surface of its solid, which a mesh that was healed or pickled has not";
            return Err(raise(py, &input(what, "mesh the part again")));
        };
        let mut made = made.clone();
        let mesh = o.listeners.work(py, |run| made.remesh_face(name, size, run).map(|()| Self::made(*made)))?;
        mesh.tell(py, o.force)?;
        Ok(mesh)
    }

    /// Layers of prisms, all equally thick, as `rvachev.Prisms`: what a face sweeps `along` a vector in the part's unit, or the room
    /// between it and the face `to`, which must have the same triangles moved along one vector.
    /// Errors: `InputError` for a name no face has, no layer, both or none of `along` and `to`, faces that do not match, walls between
    /// them that are open or not straight, and prisms that would be flat or turned over.
    #[pyo3(signature = (face, *, along=None, to=None, layers=1))]
    fn sweep(
        &self,
        py: Python<'_>,
        face: &str,
        along: Option<&Bound<'_, PyAny>>,
        to: Option<&str>,
        layers: u32,
    ) -> PyResult<PyPrisms> {
        PyPrisms::of(py, self.mesh(), &Sweep { face, along, to, layers })
    }

    /// One HTML page that shows the mesh in a browser, as `rvachev view` writes it; it needs no network.
    #[pyo3(signature = (title="mesh"))]
    fn to_html(&self, py: Python<'_>, title: &str) -> PyResult<String> {
        Listeners::default().work(py, |run| {
            let text = match &self.source {
                Source::Made(m) => pipeline::shown(m, title),
                Source::Healed(h) => pipeline::shown_healed(h, title, run)?,
                Source::Again(_) => PageText { title: title.into(), ..PageText::default() },
            };
            page(self.mesh(), &text, run)
        })
    }

    /// The page in a frame of a notebook; nothing for meshes that would make the notebook too large.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<Option<String>> {
        if self.mesh().triangles.len() > MOST_SHOWN {
            return Ok(None);
        }
        let page = self.to_html(py, "mesh")?.replace('&', "&amp;").replace('"', "&quot;");
        let style = "width: 100%; height: 600px; border: 0";
        Ok(Some(format!("<iframe sandbox=\"allow-scripts\" style=\"{style}\" srcdoc=\"{page}\"></iframe>")))
    }

    /// The solid inside in tetrahedra, a `rvachev.Filled`, by one of the packages gmsh, tetgen, netgen and pytetwild,
    /// where it is installed. Triangles stay as they are but by pytetwild, and names stay with all.
    /// size: the longest edges inside should have, in the part's unit; without it they grow from those of the surface.
    #[pyo3(signature = (by="gmsh", size=None))]
    fn fill<'py>(slf: &Bound<'py, Self>, by: &str, size: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("rvachev._fill")?.call_method1("fill", (slf, by, size))
    }

    fn __repr__(&self) -> String {
        let m = self.mesh();
        let (n, t, f) = (m.nodes.len(), m.triangles.len(), m.faces.len());
        format!("<rvachev.Mesh: {n} points, {t} triangles, {f} faces>")
    }
}

/// read_triangles(path, **options): a file of triangles as it is: points, float64 (n, 3), in the file's unit, and triangles, int64 (m, 3).
///
/// Options: progress, cancel, threads. Errors: `InputError` for a file that holds no triangles.
#[pyfunction]
#[pyo3(signature = (path, **options))]
pub fn read_triangles<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let o = Options::new(options, &["progress", "cancel", "threads"])?;
    let mesh = o.listeners.work(py, |run| io::read(&path, run))?;
    let points = flat(&mesh.nodes).to_vec().into_pyarray(py).reshape([mesh.nodes.len(), 3])?;
    let triangles: Vec<i64> = mesh.triangles.iter().flatten().map(|v| i64::from(*v)).collect();
    let triangles = triangles.into_pyarray(py).reshape([mesh.triangles.len(), 3])?;
    PyTuple::new(py, [points.into_any(), triangles.into_any()])
}

/// Writes the files and lists of names; gives what is worth knowing.
fn write_files(
    paths: &[PathBuf],
    mesh: &dyn MeshView,
    options: &WriteOptions,
    run: &Run,
) -> rvachev::Result<Vec<String>> {
    paths.iter().try_for_each(|p| io::check_writable(p))?;
    let mut told: Vec<String> = Vec::new();
    let mut lists: BTreeMap<PathBuf, Vec<Renamed>> = BTreeMap::new();
    for path in paths {
        let written = io::write(path, mesh, options, run)?;
        if Format::from_path(path)?.has_sets() {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let list = lists.entry(path.with_extension("names.json")).or_default();
            for [name, now] in &written.renamed {
                list.push(Renamed { file: file.clone(), name: name.clone(), written: now.clone() });
            }
        }
        for [name, now] in &written.renamed {
            told.push(format!("{}: the name {name} is written as {now}", path.display()));
        }
        told.extend(written.warnings);
    }
    for (path, renamed) in lists {
        let names = Names { renamed, ..io::names(mesh, options)? };
        let text =
            serde_json::to_string_pretty(&names).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))?;
        io::write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io("write", &path, e)))?;
    }
    told.sort();
    told.dedup();
    Ok(told)
}
