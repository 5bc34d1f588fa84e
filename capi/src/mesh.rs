//! Meshes: arrays on the library's own memory, faces and groups by name, the report, files.

use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_int};
use std::path::Path;
use std::ptr::null;
use std::sync::{Mutex, OnceLock, PoisonError};

use rvachev::implicit::part::glob;
use rvachev::io::{self, Format, Names, Outline, Renamed, WriteOptions, Written};
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::pipeline::{Healed, Joined, Meshed};
use rvachev::quality::{Expectation, check};
use rvachev::{Error, Run};

use crate::errors::{ErrorOut, Failure, GOOD, SHORT, entry, given, input, release, slot, usage};
use crate::options::{Asked, RvOptions, asked};
use crate::pass::{Chars, Out, c_string, flat};
use crate::shape::Bends;
use crate::text::json;
use crate::work::work;

/// Where a mesh comes from.
pub enum Source {
    /// The stages.
    Made(Box<Meshed>),
    /// Healing.
    Healed(Healed),
    /// A file, as it is.
    Read(TriMesh),
    /// Other meshes.
    Joined(Joined),
}

/// What a name stands for.
struct Chosen {
    triangles: Vec<u32>,
    nodes: Vec<u32>,
}

/// A mesh. Nothing in it changes once it was asked for, so pointers into it are good until it is freed.
pub struct RvMesh {
    /// What it is.
    pub source: Source,
    /// The unit of length, where one was said.
    pub units: Option<CString>,
    faces: Vec<CString>,
    groups: Vec<CString>,
    /// Names of the borders of a plane figure.
    pub borders: Vec<CString>,
    shortfalls: Vec<CString>,
    /// Warnings; writing files adds to them.
    warnings: Mutex<Vec<CString>>,
    chosen: Mutex<BTreeMap<String, Box<Chosen>>>,
    edges: OnceLock<Vec<u32>>,
    normals: OnceLock<Vec<f64>>,
    /// How it bends at its nodes.
    pub bends: OnceLock<Bends>,
    /// What its nodes are by that.
    pub classes: OnceLock<Vec<u8>>,
    report: OnceLock<CString>,
}

/// Texts for the caller.
pub fn c_strings<T: ToString>(all: &[T]) -> Vec<CString> {
    all.iter().map(|s| c_string(&s.to_string())).collect()
}

impl RvMesh {
    fn new(source: Source) -> Self {
        let (shortfalls, warnings) = match &source {
            Source::Made(m) => (c_strings(&m.report.shortfalls), c_strings(&m.report.warnings)),
            Source::Healed(h) => (c_strings(&h.report.shortfalls), Vec::new()),
            Source::Read(_) => (Vec::new(), Vec::new()),
            Source::Joined(j) => {
                let alone = |i| c_string(&format!("mesh {i} has no node in common with the others"));
                (j.report.alone.iter().map(alone).collect(), Vec::new())
            }
        };
        let units = match &source {
            Source::Made(m) => m.report.units.as_deref().map(c_string),
            Source::Healed(_) | Source::Read(_) | Source::Joined(_) => None,
        };
        let mut made = RvMesh {
            source,
            units,
            faces: Vec::new(),
            groups: Vec::new(),
            borders: Vec::new(),
            shortfalls,
            warnings: Mutex::new(warnings),
            chosen: Mutex::default(),
            edges: OnceLock::new(),
            normals: OnceLock::new(),
            bends: OnceLock::new(),
            classes: OnceLock::new(),
            report: OnceLock::new(),
        };
        made.faces = c_strings(&made.mesh().faces);
        made.borders = made.outline().map_or_else(Vec::new, |o| c_strings(&o.names));
        made.groups = made.mesh().groups.iter().map(|g| c_string(&g.name)).collect();
        made
    }

    /// The mesh itself.
    pub fn mesh(&self) -> &TriMesh {
        match &self.source {
            Source::Made(m) => &m.mesh,
            Source::Healed(h) => &h.mesh,
            Source::Read(m) => m,
            Source::Joined(j) => &j.mesh,
        }
    }

    fn seams_and_corners(&self) -> (&[[u32; 2]], &[u32]) {
        match &self.source {
            Source::Made(m) => (&m.seams, &m.corners),
            _ => (&[], &[]),
        }
    }

    /// The borders, of a plane figure.
    pub fn outline(&self) -> Option<&Outline> {
        match &self.source {
            Source::Made(m) => m.outline.as_ref(),
            Source::Healed(_) | Source::Read(_) | Source::Joined(_) => None,
        }
    }

    /// Faces a name stands for: a group, else faces by name or pattern.
    fn named(&self, name: &str) -> Result<Vec<u32>, Failure> {
        let mesh = self.mesh();
        if let Some(g) = mesh.groups.iter().find(|g| g.name == name) {
            return Ok(g.faces.clone());
        }
        let found: Vec<u32> = (0u32..).zip(&mesh.faces).filter(|(_, f)| glob(name, f)).map(|(i, _)| i).collect();
        if found.is_empty() {
            let known: Vec<&str> =
                mesh.groups.iter().map(|g| g.name.as_str()).chain(mesh.faces.iter().map(String::as_str)).collect();
            let help = format!("there are: {}", known.into_iter().take(20).collect::<Vec<_>>().join(", "));
            return Err(input(format!("there is no group and no face {name:?}"), &help));
        }
        Ok(found)
    }

    /// Triangles and nodes of a name, found once.
    fn chosen(&self, name: &str) -> Result<*const Chosen, Failure> {
        let mut all = self.chosen.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.get(name) {
            return Ok(&raw const **known);
        }
        let mesh = self.mesh();
        let mut wanted = vec![false; mesh.faces.len()];
        self.named(name)?.iter().for_each(|f| wanted[*f as usize] = true);
        let mut on = vec![false; mesh.nodes.len()];
        let mut triangles = Vec::new();
        for (t, (corners, label)) in (0u32..).zip(mesh.triangles.iter().zip(&mesh.labels)) {
            if wanted[*label as usize] {
                triangles.push(t);
                corners.iter().for_each(|v| on[*v as usize] = true);
            }
        }
        let nodes = (0u32..).zip(on).filter(|(_, on)| *on).map(|(v, _)| v).collect();
        // In a box of its own: what is added later does not move it.
        let made = all.entry(name.to_string()).or_insert(Box::new(Chosen { triangles, nodes }));
        Ok(&raw const **made)
    }

    /// Edges between two faces, where two surfaces of one face meet, and open ones.
    fn feature_edges(&self) -> Vec<u32> {
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
        edges.into_flattened()
    }
}

/// Whether a mesh is sound, as far as it was looked at.
///
/// Errors: it is not, and not wanted all the same.
pub fn sound(made: &Meshed, force: bool) -> Result<bool, Failure> {
    let unsound = made.report.check.as_ref().map(|c| &c.certificate).filter(|c| !c.is_sound());
    if let (Some(c), false) = (unsound, force) {
        let what = format!("the mesh is not sound ({c}); the option force=true gives it all the same");
        return Err(Error::Failed(what).into());
    }
    Ok(unsound.is_none())
}

/// Gives a mesh to the caller: good, or short where it falls short.
///
/// Errors: it is not sound, and not wanted all the same.
pub fn give(source: Source, asked: &Asked, out: Out<'_, *mut RvMesh>) -> Result<c_int, Failure> {
    let short = match &source {
        Source::Made(m) => !sound(m, asked.force)?,
        Source::Healed(_) | Source::Read(_) | Source::Joined(_) => false,
    };
    let mesh = RvMesh::new(source);
    let status = if short || !mesh.shortfalls.is_empty() { SHORT } else { GOOD };
    slot(out, std::ptr::null_mut(), "mesh")?.write(Box::into_raw(Box::new(mesh)));
    Ok(status)
}

/// Writes a file and its list of names.
pub fn write_file(path: &Path, mesh: &dyn MeshView, options: &WriteOptions, run: &Run) -> rvachev::Result<Written> {
    io::check_writable(path)?;
    let mut written = io::write(path, mesh, options, run)?;
    if Format::from_path(path)?.has_sets() {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let renamed = written.renamed.iter().map(|[name, now]| Renamed {
            file: file.clone(),
            name: name.clone(),
            written: now.clone(),
        });
        let names = Names { renamed: renamed.collect(), ..io::names(mesh, options)? };
        let list = path.with_extension("names.json");
        let text =
            serde_json::to_string_pretty(&names).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))?;
        io::write_atomic(&list, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io("write", &list, e)))?;
    }
    let file = path.display();
    written
        .warnings
        .extend(written.renamed.iter().map(|[name, now]| format!("{file}: the name {name} is written as {now}")));
    Ok(written)
}

/// A place for a lent array.
pub type Array<'a, T> = Out<'a, *const T>;

/// All that a call does which lends an array: pointer and number of items.
pub fn lend<T>(
    array: Array<'_, T>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
    what: impl FnOnce() -> Result<(*const T, usize), Failure>,
) -> c_int {
    entry(error, || {
        let (array, count) = (slot(array, null(), "the array")?, slot(count, 0, "count")?);
        let (start, n) = what()?;
        array.write(start);
        count.write(n);
        Ok(GOOD)
    })
}

/// The nodes: x, y, z of each, `count` nodes.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_points(
    mesh: Option<&RvMesh>,
    xyz: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(xyz, count, error, || {
        let nodes = &given(mesh, "mesh")?.mesh().nodes;
        Ok((flat(nodes).as_ptr(), nodes.len()))
    })
}

/// The triangles: three nodes of each, from 0, counter-clockwise from outside; `count` triangles.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_triangles(
    mesh: Option<&RvMesh>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let triangles = &given(mesh, "mesh")?.mesh().triangles;
        Ok((triangles.as_flattened().as_ptr(), triangles.len()))
    })
}

/// The face of each triangle, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_labels(
    mesh: Option<&RvMesh>,
    faces: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(faces, count, error, || {
        let labels = &given(mesh, "mesh")?.mesh().labels;
        Ok((labels.as_ptr(), labels.len()))
    })
}

/// Outward unit normals of the triangles, three numbers of each; zero where one has no area.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_normals(
    mesh: Option<&RvMesh>,
    xyz: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(xyz, count, error, || {
        let m = given(mesh, "mesh")?;
        let all = m
            .normals
            .get_or_init(|| (0..m.mesh().triangles.len()).flat_map(|t| m.mesh().normal(t).to_array()).collect());
        Ok((all.as_ptr(), all.len() / 3))
    })
}

/// Edges between two faces, where two surfaces of one face meet, and open ones: two nodes of each, `count` edges.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_feature_edges(
    mesh: Option<&RvMesh>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let m = given(mesh, "mesh")?;
        let all = m.edges.get_or_init(|| m.feature_edges());
        Ok((all.as_ptr(), all.len() / 2))
    })
}

/// Nodes where borders of faces end or meet, and apexes. None where the method does not know them.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_corners(
    mesh: Option<&RvMesh>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let corners = given(mesh, "mesh")?.seams_and_corners().1;
        Ok((corners.as_ptr(), corners.len()))
    })
}

/// Triangles of a group, of a face, or of faces whose names fit a pattern; ascending.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_triangles_of(
    mesh: Option<&RvMesh>,
    name: Chars,
    triangles: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(triangles, count, error, || {
        let chosen = given(mesh, "mesh")?.chosen(name.text("name")?)?;
        // SAFETY: it is in a box of the mesh that is dropped with the mesh only.
        let list = unsafe { &(*chosen).triangles };
        Ok((list.as_ptr(), list.len()))
    })
}

/// Nodes of these triangles, those on borders included; ascending.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_nodes_of(
    mesh: Option<&RvMesh>,
    name: Chars,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let chosen = given(mesh, "mesh")?.chosen(name.text("name")?)?;
        // SAFETY: as in `rv_mesh_triangles_of`.
        let list = unsafe { &(*chosen).nodes };
        Ok((list.as_ptr(), list.len()))
    })
}

/// One text of a list: usage where there are not so many.
pub fn nth(list: &[CString], index: usize, out: Out<'_, *const c_char>, what: &str) -> Result<c_int, Failure> {
    let out = slot(out, null(), "the text")?;
    let found = list.get(index).ok_or_else(|| usage(format!("there is no {what} {index}, only {}", list.len())))?;
    out.write(found.as_ptr());
    Ok(GOOD)
}

/// How many texts a list has.
pub fn many(list: &[CString], count: Out<'_, usize>) -> Result<c_int, Failure> {
    slot(count, 0, "count")?.write(list.len());
    Ok(GOOD)
}

/// How many faces there are.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_face_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || many(&given(mesh, "mesh")?.faces, count))
}

/// The name of a face, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_face_name(
    mesh: Option<&RvMesh>,
    index: usize,
    name: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || nth(&given(mesh, "mesh")?.faces, index, name, "face"))
}

/// How many groups there are.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_group_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || many(&given(mesh, "mesh")?.groups, count))
}

/// The name of a group, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_group_name(
    mesh: Option<&RvMesh>,
    index: usize,
    name: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || nth(&given(mesh, "mesh")?.groups, index, name, "group"))
}

/// How many shortfalls there are: where the mesh falls short of what was asked.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_shortfall_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || many(&given(mesh, "mesh")?.shortfalls, count))
}

/// A shortfall, from 0, in one sentence.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_shortfall(
    mesh: Option<&RvMesh>,
    index: usize,
    text: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || nth(&given(mesh, "mesh")?.shortfalls, index, text, "shortfall"))
}

/// How many warnings there are; writing files may add some.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_warning_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let mesh = given(mesh, "mesh")?;
        many(&mesh.warnings.lock().unwrap_or_else(PoisonError::into_inner), count)
    })
}

/// A warning, from 0, in one sentence.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_warning(
    mesh: Option<&RvMesh>,
    index: usize,
    text: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let mesh = given(mesh, "mesh")?;
        nth(&mesh.warnings.lock().unwrap_or_else(PoisonError::into_inner), index, text, "warning")
    })
}

/// The report as JSON (docs/report.md); what was repaired, for a healed mesh; "null" for one that was read.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_report(mesh: Option<&RvMesh>, text: Out<'_, *const c_char>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(text, null(), "the text")?;
        let m = given(mesh, "mesh")?;
        if m.report.get().is_none() {
            let made = match &m.source {
                Source::Made(made) => json(&made.report)?,
                Source::Healed(h) => json(&h.report)?,
                Source::Read(_) => c_string("null"),
                Source::Joined(j) => json(&j.report)?,
            };
            let _ = m.report.set(made);
        }
        out.write(m.report.get().map_or(null(), |r| r.as_ptr()));
        Ok(GOOD)
    })
}

/// Whether the mesh is certified: closed (or meant to be open), a manifold, oriented, free of self-intersections.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_is_sound(mesh: Option<&RvMesh>, sound: Out<'_, c_int>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(sound, 0, "sound")?;
        let m = given(mesh, "mesh")?;
        let known = match &m.source {
            Source::Made(made) => made.report.check.as_ref().map(|c| c.certificate.is_sound()),
            _ => None,
        };
        let sound = match known {
            Some(known) => known,
            None => {
                work(None, 0, |run| Ok(check(m.mesh(), Expectation::default(), None, run)?.certificate.is_sound()))?
            }
        };
        out.write(sound.into());
        Ok(GOOD)
    })
}

/// Writes a file, its format by the extension, and beside formats with named sets a list NAME.names.json.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_write(
    mesh: Option<&RvMesh>,
    path: Chars,
    options: Option<&RvOptions>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let m = given(mesh, "mesh")?;
        let path = path.path("path")?;
        let asked = asked(options);
        let (seams, corners) = m.seams_and_corners();
        let how = WriteOptions {
            groups: asked.groups,
            old_msh: asked.old_msh,
            seams: seams.to_vec(),
            corners: corners.to_vec(),
            outline: m.outline().cloned(),
            unit: m.units.as_ref().map(|u| u.to_string_lossy().into_owned()),
            ..WriteOptions::default()
        };
        let written = work(asked.run.as_ref(), asked.threads, |run| {
            Ok(match &m.source {
                Source::Made(made) => write_file(&path, &made.merged()?, &how, run)?,
                _ => write_file(&path, m.mesh(), &how, run)?,
            })
        })?;
        let mut warnings = m.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        for told in written.warnings.iter().chain(&written.shortfalls) {
            let told = c_string(told);
            if !warnings.contains(&told) {
                warnings.push(told);
            }
        }
        Ok(if written.shortfalls.is_empty() { GOOD } else { SHORT })
    })
}

/// Reads a file of triangles as it is.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_read(
    path: Chars,
    options: Option<&RvOptions>,
    mesh: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(mesh, std::ptr::null_mut(), "mesh")?;
        let (path, asked) = (path.path("path")?, asked(options));
        let read = work(asked.run.as_ref(), asked.threads, |run| Ok(io::read(&path, run)?))?;
        give(Source::Read(read), &asked, Some(out))
    })
}

/// Frees a mesh; what was lent of it is gone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_free(mesh: Option<Box<RvMesh>>) {
    release(mesh);
}
