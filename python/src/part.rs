//! Parts: a solid with everything needed to mesh it, and what is asked of it.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rvachev::implicit::part::{Part, PartGroup};
use rvachev::implicit::{Sampling, evaluate as evaluate_at};
use rvachev::io::write_atomic;
use rvachev::pipeline::{self, Meshed};
use rvachev::{Error, Place, Run};

use crate::arrays::{surface, table};
use crate::edges::Built;
use crate::errors::{input, raise};
use crate::field::domain;
use crate::mesh::{PyMesh, from_json};
use crate::options::Options;
use crate::pickle::{self, Source};
use crate::solid::PySolid;
use crate::text::{call, literal, quoted, read};
use crate::work::Listeners;

/// The number of a face where none decides.
const NO_FACE: i32 = -1;

/// A part: a solid with a unit, groups of faces, and wishes for its mesh.
///
/// solid: a solid, one built from edges, or a list of such with at most one of R-functions.
/// units: "m", "dm", "cm", "mm", "um", "in" or "ft"; only files are told.
/// domain: ((x0, y0, z0), (x1, y1, z1)), where to cut off what may be infinite.
/// rsystem: "R0", "minmax", ("Ralpha", a) or ("R0m", m).
/// size, size_min: edge lengths, used where `mesh` is not asked for others.
#[pyclass(frozen, name = "Part", module = "rvachev")]
pub struct PyPart {
    part: Mutex<Part>,
    /// The file it was read from.
    source: Option<Source>,
}

impl PyPart {
    /// A part out of a file.
    pub fn read(part: Part, source: Source) -> Self {
        PyPart { part: Mutex::new(part), source: Some(source) }
    }

    /// The file it was read from, if it was, and if no groups were named and no unit was said since: a plan holds the file's text alone.
    pub fn plan_source(&self) -> Option<pipeline::PlanSource> {
        let Source { path, text, define } = self.source.clone()?;
        let (read, now) = (self.source.as_ref()?.part().ok()?, self.part());
        let overrides = define;
        (now.groups.len() == read.groups.len() && now.units == read.units).then_some(pipeline::PlanSource {
            path,
            text,
            overrides,
        })
    }

    /// The part as it is at the moment.
    pub fn part(&self) -> Part {
        self.part.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Writes one file.
fn write_part(part: &Part, path: &Path, run: &Run) -> rvachev::Result<()> {
    let bytes = if pipeline::is_vm(path) {
        pipeline::vm_text(part)?.into_bytes()
    } else if pipeline::is_3mf(path) {
        pipeline::levelset_bytes(part, &path.file_stem().unwrap_or_default().to_string_lossy())?
    } else if pipeline::is_step(path) {
        return match pipeline::build(part, run)?.filter(|_| part.solid.is_none()) {
            Some(brep) => pipeline::save_step(path, &brep, part.units.as_deref()),
            None => Err(Error::input(Place::Unknown, "only solids built from edges can be written as STEP")),
        };
    } else {
        let what = format!("parts are written as step, stp, vm and 3mf, not {}", path.display());
        return Err(Error::Usage(what));
    };
    write_atomic(path, |out| out.write_all(&bytes).map_err(|e| Error::io("write", path, e)))
}

/// A mesh, told of and given, or an error where it is not sound.
pub fn given(py: Python<'_>, made: Meshed, force: bool) -> PyResult<PyMesh> {
    let mesh = PyMesh::made(made);
    mesh.tell(py, force)?;
    Ok(mesh)
}

#[pymethods]
impl PyPart {
    #[new]
    #[pyo3(signature = (solid, *, units=None, domain=None, rsystem=None, size=None, size_min=None))]
    fn new(
        py: Python<'_>,
        solid: &Bound<'_, PyAny>,
        units: Option<&str>,
        domain: Option<&Bound<'_, PyAny>>,
        rsystem: Option<&Bound<'_, PyAny>>,
        size: Option<&Bound<'_, PyAny>>,
        size_min: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        // What is not a solid is read as a part file says it.
        let mut text = String::new();
        if let Some(units) = units {
            text.push_str(&format!("units({})\n", quoted(units)));
        }
        let rsystem = rsystem.map(rsystem_text).transpose()?;
        text.push_str(&format!("part(sphere(1){})\n", rsystem.unwrap_or_default()));
        let wishes = PyDict::new(py);
        wishes.set_item("size", size)?;
        wishes.set_item("size_min", size_min)?;
        text.push_str(&call("mesh", &PyTuple::empty(py), Some(&wishes))?);
        let mut part = read(py, &text)?;
        part.domain = domain.map(|d| self::domain(py, d)).transpose()?;
        part.solid = None;
        let items: Vec<Bound<'_, PyAny>> =
            if solid.hasattr("__iter__")? { solid.try_iter()?.collect::<PyResult<_>>()? } else { vec![solid.clone()] };
        for item in &items {
            if let Ok(b) = item.cast::<Built>() {
                part.built.extend(read(py, &format!("part({})", b.get().text))?.built);
            } else if let Ok(s) = item.cast::<PySolid>() {
                if part.solid.replace(s.get().solid.clone()).is_some() {
                    let what = "a part is made of one solid of R-functions at most";
                    return Err(raise(py, &input(what, "union([...]) makes one of several")));
                }
            } else {
                return Err(PyTypeError::new_err(format!(
                    "a part is made of solids, not of {}",
                    item.get_type().name()?
                )));
            }
        }
        if items.is_empty() {
            return Err(raise(py, &input("a part needs a solid", "")));
        }
        Ok(PyPart { part: Mutex::new(part), source: None })
    }

    /// Reads a part file. `define` replaces numbers assigned at its top level.
    #[staticmethod]
    #[pyo3(signature = (path, define=None))]
    fn load(py: Python<'_>, path: PathBuf, define: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let define: Vec<(String, f64)> = match define {
            Some(d) => d.iter().map(|(k, v)| Ok((k.extract()?, v.extract()?))).collect::<PyResult<_>>()?,
            None => Vec::new(),
        };
        let part = pipeline::load_part(&path, &define).map_err(|e| raise(py, &e))?;
        // What is pickled is the text: the file may be gone by then, or another.
        let text = pipeline::part_text(&path).map_err(|e| raise(py, &e))?;
        Ok(PyPart::read(part, Source { path, text, define }))
    }

    /// Names a set of faces: those whose names fit one of the patterns (`*` stands for any characters, `?` for one). A pattern no
    /// face answers to is a warning of the mesh.
    #[pyo3(signature = (name, *faces))]
    fn group(&self, py: Python<'_>, name: String, faces: Vec<String>) -> PyResult<()> {
        let mut part = self.part.lock().unwrap_or_else(PoisonError::into_inner);
        if part.groups.iter().any(|g| g.name == name) {
            return Err(raise(py, &input(format!("there is a group {name:?} already"), "")));
        }
        if faces.is_empty() {
            return Err(raise(py, &input(format!("group {name:?} names no faces"), "group(\"wall\", \"body.*\")")));
        }
        part.groups.push(PartGroup { name, patterns: faces, place: Place::Unknown });
        Ok(())
    }

    /// Writes files, formats by extension: step or stp for solids built from edges; vm (a formula file) or 3mf (a level set) for
    /// one of functions. `InputError` where a format cannot hold the part.
    #[pyo3(signature = (*paths))]
    fn write(&self, py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<()> {
        let part = self.part();
        Listeners::default().work(py, |run| paths.iter().try_for_each(|path| write_part(&part, path, run)))
    }

    /// The unit of length, where one was said.
    #[getter]
    fn units(&self) -> Option<String> {
        self.part().units
    }

    /// Says the unit of length, or with None that there is none. Coordinates stay; only files are told.
    #[setter]
    fn set_units(&self, py: Python<'_>, units: Option<&str>) -> PyResult<()> {
        let units = match units {
            Some(units) => read(py, &format!("units({})\npart(sphere(1))", quoted(units)))?.units,
            None => None,
        };
        self.part.lock().unwrap_or_else(PoisonError::into_inner).units = units;
        Ok(())
    }

    /// Groups, by name: the patterns of names of faces.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for g in self.part().groups {
            out.set_item(g.name, PyTuple::new(py, g.patterns)?)?;
        }
        Ok(out)
    }

    /// The names of the faces of the part's function, as `evaluate` numbers them: a tuple. `InputError` for parts that have no function.
    #[getter]
    fn face_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let part = self.part();
        let model = Listeners::default().work(py, |run| pipeline::function(&part, None, run))?;
        PyTuple::new(py, model.faces().iter().map(|f| f.name.as_str()))
    }

    /// What is known before meshing: a dict as `rvachev info --json` writes it. Of functions it has surfaces, a box around the part, the
    /// names of its faces and groups; of solids built from edges numbers of vertices and edges, a box, bodies with volumes, faces with
    /// areas, in the part's unit. With both, these are the item "built".
    /// Errors: `InputError` for solids that cannot be built.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let part = self.part();
        let info = Listeners::default().work(py, |run| pipeline::part_info(&part, run))?;
        from_json(py, &info)
    }

    /// Meshes the part.
    ///
    /// size: the length of edges in the part's unit, or a share of the diagonal such as "2%". The package's stubs have all options:
    /// lengths are in that unit or shares, angles in degrees. Errors: `InputError`, `Failed`, `Cancelled`.
    #[pyo3(signature = (size=None, **options))]
    fn mesh(
        &self,
        py: Python<'_>,
        size: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyMesh> {
        let (part, mut o) = (Wanted::Part(Box::new(self.part())), sized(Options::new(options, &[])?, size)?);
        let made = std::mem::take(&mut o.listeners).work(py, |run| part.mesh(&o, run))?;
        given(py, made, o.force)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Source { path, text, define } = self.source.clone().ok_or_else(pickle::no_file)?;
        let groups: Vec<_> = self.part().groups.into_iter().map(|g| (g.name, g.patterns)).collect();
        let how = py.import("rvachev._rvachev")?.getattr("part_again")?;
        let state = (self.part().units,);
        (how, (path.as_os_str(), text, define, groups), state).into_pyobject(py)
    }

    /// What was said after the file was read and is in a pickle.
    fn __setstate__(&self, state: (Option<String>,)) {
        self.part.lock().unwrap_or_else(PoisonError::into_inner).units = state.0;
    }

    fn __repr__(&self) -> String {
        let part = self.part();
        format!("<rvachev.Part: units {}, {} groups>", part.units.as_deref().unwrap_or("none"), part.groups.len())
    }
}

fn rsystem_text(v: &Bound<'_, PyAny>) -> PyResult<String> {
    let Ok(pair) = v.cast::<PyTuple>() else { return Ok(format!(", rsystem={}", literal(v)?)) };
    let items = pair.iter().map(|x| literal(&x)).collect::<PyResult<Vec<_>>>()?;
    Ok(format!(", rsystem=({},)", items.join(", ")))
}

pub fn sized(mut o: Options, size: Option<&Bound<'_, PyAny>>) -> PyResult<Options> {
    if let Some(v) = size {
        o.mesh.size = Some(crate::options::size(v)?);
    }
    Ok(o)
}

/// What can be meshed.
enum Wanted {
    Part(Box<Part>),
    File(PathBuf),
}

impl Wanted {
    fn of(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(part) = source.cast::<PyPart>() {
            return Ok(Wanted::Part(Box::new(part.get().part())));
        }
        if source.cast::<PySolid>().is_ok() || source.cast::<Built>().is_ok() {
            return Ok(Wanted::Part(Box::new(PyPart::new(py, source, None, None, None, None, None)?.part())));
        }
        Ok(Wanted::File(source.extract()?))
    }

    fn mesh(&self, o: &Options, run: &Run) -> rvachev::Result<Meshed> {
        let path = match self {
            Wanted::Part(part) => return pipeline::mesh_part(part, &o.mesh.for_part(part, o.method), run),
            Wanted::File(path) => path,
        };
        let made = if pipeline::is_step(path) {
            pipeline::mesh_step(pipeline::load_step(path, run)?, &o.mesh, run)
        } else if pipeline::is_mesh(path) {
            pipeline::mesh_soup(&pipeline::load_mesh(path, run)?, &o.mesh, &o.soup, run)
        } else {
            let part = pipeline::load_part(path, &o.define)?;
            pipeline::mesh_part(&part, &o.mesh.for_part(&part, o.method), run)
        };
        made.map_err(|e| e.in_file(path))
    }
}

/// mesh(source, size=None, **options): meshes a Part, or a file: a part file, a STEP file, or a file of triangles.
///
/// size: the length of edges in the part's unit, or a share of the diagonal such as "2%".
/// Options: those of `Part.mesh`, and for triangles feature_angle (degrees), min_area, min_length, nodes, close.
/// Errors: `InputError`, `Failed`, `Cancelled`.
#[pyfunction]
#[pyo3(signature = (source, size=None, **options))]
pub fn mesh(
    py: Python<'_>,
    source: &Bound<'_, PyAny>,
    size: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMesh> {
    let wanted = Wanted::of(py, source)?;
    let mut o = sized(Options::new(options, &[])?, size)?;
    let made = std::mem::take(&mut o.listeners).work(py, |run| wanted.mesh(&o, run))?;
    given(py, made, o.force)
}

/// expected_triangles(source, size=None, **options): about how many triangles `mesh` with these arguments gives, an int.
///
/// size: the length of edges in the part's unit, or a share of the diagonal such as "2%".
/// It is told as soon as lengths of edges are known, and no mesh is made. Within a tenth as a rule, and more than that where a part has
/// narrow places that show only later. Errors: those of `mesh`, but for a mesh that is not sound or falls short.
#[pyfunction]
#[pyo3(signature = (source, size=None, **options))]
pub fn expected_triangles(
    py: Python<'_>,
    source: &Bound<'_, PyAny>,
    size: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<usize> {
    let wanted = Wanted::of(py, source)?;
    let mut o = sized(Options::new(options, &[])?, size)?;
    let listeners = std::mem::take(&mut o.listeners);
    listeners.work(py, |run| pipeline::expected_triangles(run, |run| wanted.mesh(&o, run)))
}

/// remesh(points, triangles=None, size=None, **options): meshes a surface of triangles anew, its faces, edges and corners found.
///
/// points (n, 3), in any unit, and triangles (m, 3), or a Mesh alone.
/// size: the length of edges in that unit, or a share of the diagonal such as "2%". Options: those of `mesh`.
/// Errors: `InputError` for arrays that are no surface; `Failed`, `Cancelled`.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, size=None, **options))]
pub fn remesh(
    py: Python<'_>,
    points: &Bound<'_, PyAny>,
    triangles: Option<&Bound<'_, PyAny>>,
    size: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMesh> {
    let mut o = sized(Options::new(options, &[])?, size)?;
    let input = surface(points, triangles)?;
    let listeners = std::mem::take(&mut o.listeners);
    let made = listeners.work(py, |run| pipeline::mesh_soup(&input, &o.mesh, &o.soup, run))?;
    given(py, made, o.force)
}

/// heal(points, triangles=None, **options): sets right what is wrong with a mesh: gaps, holes, overlaps, intersections.
///
/// points (n, 3), in any unit, and triangles (m, 3), or a Mesh alone. The result's `report` tells what was repaired.
/// Options: max_hole (how many edges around a hole that is closed), progress, cancel, threads, force.
/// Errors: `InputError` for arrays that are no surface; `Failed` for a mesh that is not sound, without force.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, **options))]
pub fn heal(
    py: Python<'_>,
    points: &Bound<'_, PyAny>,
    triangles: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMesh> {
    let o = Options::new(options, &["max_hole", "progress", "cancel", "threads", "force"])?;
    let input = surface(points, triangles)?;
    let how = o.heal;
    let healed = o.listeners.work(py, |run| pipeline::heal(&input, &how, run))?;
    let mesh = PyMesh::healed(healed);
    mesh.tell(py, o.force)?;
    Ok(mesh)
}

/// check(points, triangles=None, against=None, **options): measures a mesh; a dict as `mesh.report["check"]`.
///
/// points (n, 3), in any unit, and triangles (m, 3), or a Mesh alone; lengths of the result are in that unit, angles in degrees.
/// against: a Part, or the path of a part file or STEP file whose surface it should be.
#[pyfunction]
#[pyo3(signature = (points, triangles=None, against=None, **options))]
pub fn check<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    triangles: Option<&Bound<'py, PyAny>>,
    against: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let o = Options::new(options, &["progress", "cancel", "threads", "define"])?;
    let input = surface(points, triangles)?;
    let check = match against {
        None => o
            .listeners
            .work(py, |run| rvachev::quality::check(&input, rvachev::quality::Expectation::default(), None, run))?,
        Some(a) if a.cast::<PyPart>().is_ok() => {
            let part = a.cast::<PyPart>()?.get().part();
            o.listeners.work(py, |run| pipeline::against(&input, &part, run))?
        }
        Some(a) => {
            let (path, define): (PathBuf, _) = (a.extract()?, o.define);
            o.listeners.work(py, |run| {
                let found = if pipeline::is_step(&path) {
                    pipeline::against_step(&input, pipeline::load_step(&path, run)?, run)
                } else {
                    pipeline::against(&input, &pipeline::load_part(&path, &define)?, run)
                };
                found.map_err(|e| e.in_file(&path))
            })?
        }
    };
    from_json(py, &check)
}

/// The function of a part, or of a solid alone.
fn function_of(py: Python<'_>, part: &Bound<'_, PyAny>) -> PyResult<Part> {
    Ok(match part.cast::<PyPart>() {
        Ok(p) => p.get().part(),
        Err(_) => PyPart::new(py, part, None, None, None, None, None)?.part(),
    })
}

/// evaluate(part, points, gradient=False, faces=False): the part's function at points (N, 3): float64 (N,), positive inside, about the
/// distance near the surface, in the part's unit.
///
/// gradient=True gives its gradient, too, (N, 3), which points inwards. faces=True gives the face at each point, too, int32 (N,): an index
/// into `Part.face_names` of the face whose leaf decides min / max of all leaves, on the boundary the one the point is on; -1 where none
/// decides, without meaning where the value is NaN. With either the result is a tuple: values, then gradients, then faces.
/// Errors: `InputError` for parts that have no function.
#[pyfunction]
#[pyo3(signature = (part, points, gradient=false, faces=false))]
pub fn evaluate<'py>(
    py: Python<'py>,
    part: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
    gradient: bool,
    faces: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let part = function_of(py, part)?;
    let points = table(points, "points")?;
    let wanted = Sampling { gradients: gradient, faces };
    let found = Listeners::default()
        .work(py, |run| evaluate_at(&pipeline::function(&part, None, run)?, &points, wanted, run))?;
    let v = found.values.into_pyarray(py).into_any();
    if !gradient && !faces {
        return Ok(v);
    }
    let mut all = vec![v];
    if gradient {
        let g: Vec<f64> = found.gradients.iter().flat_map(|g| g.to_array()).collect();
        all.push(g.into_pyarray(py).reshape([points.len(), 3])?.into_any());
    }
    if faces {
        let numbers = found.faces.iter().map(|f| f.and_then(|f| i32::try_from(f).ok()).unwrap_or(NO_FACE));
        all.push(numbers.collect::<Vec<_>>().into_pyarray(py).into_any());
    }
    Ok(PyTuple::new(py, all)?.into_any())
}
