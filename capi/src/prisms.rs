//! Volumes swept by a face of a mesh, in layers of prisms or hexahedra; and a face of a mesh made anew.

use std::ffi::{CString, c_char, c_int};
use std::ptr::null;

use rvachev::DVec3;
use rvachev::io::{WriteOptions, check_writable, write_hexahedra, write_prisms};
use rvachev::mesh::{Hexahedra, Prisms};
use rvachev::pipeline::SizeRequest;

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, input, release, slot, usage};
use crate::mesh::{RvMesh, Source, c_strings, give, lend, many, nth};
use crate::options::{RvOptions, asked};
use crate::pass::{Chars, Items, Out, flat, point};
use crate::work::work;

/// What is to be filled with prisms: see the header.
#[repr(C)]
pub struct RvSweep {
    face: Chars,
    to: Chars,
    along: Items<f64>,
    layers: usize,
}

/// The cells of a volume mesh.
enum Cells {
    Prisms(Prisms),
    /// Some of them in pairs.
    Paired(Hexahedra),
}

/// A volume mesh. Nothing in it changes, so pointers into it are good until it is freed.
pub struct RvPrisms {
    cells: Cells,
    volume: f64,
    names: Vec<CString>,
    /// Four corners of each outer side: a triangle has its third one twice.
    sides: Vec<[u32; 4]>,
    labels: Vec<u32>,
}

/// A side by four corners.
fn four(corners: impl Iterator<Item = u32>) -> [u32; 4] {
    let all: Vec<u32> = corners.collect();
    std::array::from_fn(|k| all[k.min(all.len() - 1)])
}

impl RvPrisms {
    fn new(cells: Cells, volume: f64) -> Self {
        let (outer, names, sides) = match &cells {
            Cells::Prisms(p) => (&p.outer, &p.names, p.outer.iter().map(|o| four(p.corners(o))).collect()),
            Cells::Paired(h) => (&h.outer, &h.names, h.outer.iter().map(|o| four(h.corners(o))).collect()),
        };
        let (labels, names) = (outer.iter().map(|o| o.label).collect(), c_strings(names));
        RvPrisms { cells, volume, names, sides, labels }
    }

    fn nodes(&self) -> &[DVec3] {
        match &self.cells {
            Cells::Prisms(p) => &p.nodes,
            Cells::Paired(h) => &h.nodes,
        }
    }

    fn prisms(&self) -> &[[u32; 6]] {
        match &self.cells {
            Cells::Prisms(p) => &p.cells,
            Cells::Paired(h) => &h.prisms,
        }
    }

    fn hexahedra(&self) -> &[[u32; 8]] {
        match &self.cells {
            Cells::Prisms(_) => &[],
            Cells::Paired(h) => &h.hexahedra,
        }
    }
}

/// A mesh with one face made anew at the size of the options; the mesh it comes of stays.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_remesh_face(
    mesh: Option<&RvMesh>,
    face: Chars,
    options: Option<&RvOptions>,
    made: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(made, std::ptr::null_mut(), "made")?;
        let mesh = given(mesh, "mesh")?;
        let (face, asked) = (face.text("face")?, asked(options));
        let size = match asked.mesh.size {
            Some(SizeRequest::Length(h)) => h,
            Some(SizeRequest::Share(s)) => s * mesh.mesh().bounds().diagonal(),
            None => return Err(usage("a face is made anew at a size: the option \"size\" is not said")),
        };
        let Source::Made(made) = &mesh.source else {
            let what =
                "a face is meshed anew on the surface of its solid, which a mesh that was healed or read has not";
            return Err(input(what, "mesh the part again"));
        };
        let mut made = made.clone();
        let run = asked.run.as_ref();
        let made = work(run, asked.threads, |run| Ok(made.remesh_face(face, size, run).map(|()| made)?))?;
        give(Source::Made(made), &asked, Some(out))
    })
}

/// Fills what a face sweeps, or what is between two faces, with prisms.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_sweep(
    mesh: Option<&RvMesh>,
    sweep: Option<&RvSweep>,
    prisms: Out<'_, *mut RvPrisms>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(prisms, std::ptr::null_mut(), "prisms")?;
        let (mesh, sweep) = (given(mesh, "mesh")?.mesh(), given(sweep, "sweep")?);
        let face = sweep.face.text("face")?;
        let layers = u32::try_from(sweep.layers).map_err(|_| usage(format!("{} layers are too many", sweep.layers)))?;
        let made = match (sweep.to.is_null(), sweep.along.is_null()) {
            (false, true) => Prisms::between(mesh, face, sweep.to.text("to")?, layers)?,
            (true, false) => Prisms::swept(mesh, face, point(&sweep.along, "along")?, layers)?,
            _ => return Err(usage("a face is swept to another one or along a vector: one of the two is to be said")),
        };
        let volume = made.volume();
        out.write(Box::into_raw(Box::new(RvPrisms::new(Cells::Prisms(made), volume))));
        Ok(GOOD)
    })
}

/// Hexahedra in place of pairs of prisms; the prisms stay.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_pair(
    prisms: Option<&RvPrisms>,
    off: f64,
    paired: Out<'_, *mut RvPrisms>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(paired, std::ptr::null_mut(), "paired")?;
        let from = given(prisms, "prisms")?;
        if !(off > 0.0 && off.is_finite()) {
            return Err(usage(format!("off must be a positive number of degrees, not {off}")));
        }
        let Cells::Prisms(all) = &from.cells else {
            return Err(usage("these prisms are those that found no partner: pair the ones they come of"));
        };
        let made = RvPrisms::new(Cells::Paired(all.hexahedra(off)?), from.volume);
        out.write(Box::into_raw(Box::new(made)));
        Ok(GOOD)
    })
}

/// Eight nodes of each hexahedron, `count` hexahedra.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_hexahedra(
    prisms: Option<&RvPrisms>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let cells = given(prisms, "prisms")?.hexahedra();
        Ok((cells.as_flattened().as_ptr(), cells.len()))
    })
}

/// The nodes: x, y, z of each, `count` nodes.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_points(
    prisms: Option<&RvPrisms>,
    xyz: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(xyz, count, error, || {
        let nodes = given(prisms, "prisms")?.nodes();
        Ok((flat(nodes).as_ptr(), nodes.len()))
    })
}

/// Six nodes of each prism, `count` prisms.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_cells(
    prisms: Option<&RvPrisms>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let cells = given(prisms, "prisms")?.prisms();
        Ok((cells.as_flattened().as_ptr(), cells.len()))
    })
}

/// Four nodes of each side of the boundary, `count` sides.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_sides(
    prisms: Option<&RvPrisms>,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let sides = &given(prisms, "prisms")?.sides;
        Ok((sides.as_flattened().as_ptr(), sides.len()))
    })
}

/// The name of each side, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_labels(
    prisms: Option<&RvPrisms>,
    names: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(names, count, error, || {
        let labels = &given(prisms, "prisms")?.labels;
        Ok((labels.as_ptr(), labels.len()))
    })
}

/// How many names there are.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_name_count(prisms: Option<&RvPrisms>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || many(&given(prisms, "prisms")?.names, count))
}

/// A name, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_name(
    prisms: Option<&RvPrisms>,
    index: usize,
    name: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || nth(&given(prisms, "prisms")?.names, index, name, "name"))
}

/// The volume of all prisms.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_volume(prisms: Option<&RvPrisms>, volume: Out<'_, f64>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(volume, 0.0, "volume")?;
        out.write(given(prisms, "prisms")?.volume);
        Ok(GOOD)
    })
}

/// Writes a file: vtu, msh or inp.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_write(
    prisms: Option<&RvPrisms>,
    path: Chars,
    options: Option<&RvOptions>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let cells = &given(prisms, "prisms")?.cells;
        let (path, asked) = (path.path("path")?, asked(options));
        let how = WriteOptions { old_msh: asked.old_msh, ..WriteOptions::default() };
        work(asked.run.as_ref(), asked.threads, |run| {
            check_writable(&path)?;
            match cells {
                Cells::Prisms(p) => write_prisms(&path, p, &how, run)?,
                Cells::Paired(h) => write_hexahedra(&path, h, &how, run)?,
            };
            Ok::<_, Failure>(GOOD)
        })
    })
}

/// The unit of length a mesh was made in: "mm" and the like; NULL where none was said.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_units(mesh: Option<&RvMesh>, units: Out<'_, *const c_char>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(units, null(), "units")?;
        out.write(given(mesh, "mesh")?.units.as_ref().map_or(null(), |u| u.as_ptr()));
        Ok(GOOD)
    })
}

/// Frees prisms; what was lent of them is gone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_prisms_free(prisms: Option<Box<RvPrisms>>) {
    release(prisms);
}
