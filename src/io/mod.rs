//! Files. Grids of numbers: VTI and NPY out. Points: rows of text in, rows of samples out. Meshes: STL, OBJ, PLY, OFF, 3MF, gmsh
//! MSH, Abaqus INP, Nastran BDF, Medit, SU2, VTP and VTU both ways; SVG of plane figures, XDMF, GLB, gmsh GEO, MED and eMesh out.
//! Prisms: VTU, MSH, INP out.
//!
//! What survives a write followed by a read of the same file:
//!
//! | format | coordinates | nodes' order | triangles' order | face names, labels | groups |
//! |---|---|---|---|---|---|
//! | MSH 4.1, 2.2 | bit-exact | kept | kept | kept | kept |
//! | PLY | bit-exact | kept | kept | kept | kept |
//! | OFF | bit-exact | kept | kept | lost | lost |
//! | OBJ | bit-exact | kept | by face | kept, but faces without triangles | lost |
//! | ASCII STL | bit-exact | first use | by face | kept, but faces without triangles | lost |
//! | binary STL | nearest `f32` | first use | kept | lost | lost |
//! | 3MF | bit-exact | by solid | by solid | kept, but faces without triangles | lost |
//! | VTU, VTP | bit-exact | kept | kept | kept, but faces without triangles | kept, but empty ones |
//! | INP | 20 characters | kept | kept | cleaned, but faces without triangles | with `Grouping::All`, but empty ones |
//! | BDF | 16 characters | kept | kept | kept, but faces without triangles | lost |
//! | Medit, SU2 | bit-exact | kept | by face | kept (SU2: cleaned), but faces without triangles | lost |
//! | XDMF | bit-exact | written only | | | |
//! | GLB | nearest `f32` | written only | | | |
//!
//! INP, BDF, Medit, SU2 and VTP files hold what [`Grouping`] asks for, and its parts come back as faces.
//!
//! *Guarantees.* Readers never panic and never allocate by a count a file merely claims; what they return has finite
//! nodes, indices in range and at least one triangle. Writers refuse a mesh that a reader would refuse, and leave either
//! the whole file or none.
//!
//! *Does not guarantee.* Nothing is healed: degenerate triangles, duplicates and holes come through as they are. STL
//! stores no connectivity, so corners with exactly equal coordinates become one node, also where the mesh that was written
//! had two. An OBJ node no triangle uses is not read.
//!
//! Face names that a format could not hold (line breaks, quotation marks, blanks at either end, the empty name) are
//! written with `%` and two hexadecimal digits per byte, the empty name as a lone `%`, and read back as they were.

mod atomic;
mod bdf;
mod bdf_read;
mod build;
mod emesh;
mod geo;
mod glb;
mod grid;
mod inp;
mod inp_read;
mod layout;
mod line;
mod med;
mod medit;
mod medit_read;
mod msh;
mod msh_read;
mod names;
mod numbered;
mod obj;
mod off;
mod outline;
mod ply;
mod points;
mod prisms;
mod regions;
mod sets;
mod sharp;
pub mod step;
mod stl;
mod su2;
mod su2_read;
mod svg;
mod text;
pub(crate) mod threemf;
mod vtk_array;
mod vtk_read;
mod vtp;
mod vtu;
mod xdmf;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

pub use atomic::write_atomic;
pub use grid::{GridFormat, SampledGrid, write_grid};
pub use names::{NamedPart, NamedVolume, NamedWhole, Names, Renamed};
pub use outline::{ClosedLine, Outline};
pub use points::{PointRows, PointSample, no_rows, write_rows};
pub use prisms::{write_hexahedra, write_prisms};
pub use regions::Grouping;

/// How many items a loop handles between two looks at the cancel flag: some 0.1 ms of work.
const CHECK_EVERY: usize = 4096;

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Binary STL, extension `stl`. Reading tells the two spellings of STL apart by content.
    StlBinary,
    /// ASCII STL with one solid per face name, extension `stla` or `ast`.
    StlAscii,
    /// Wavefront OBJ with one group per face name, extension `obj`.
    Obj,
    /// Stanford PLY, extension `ply`; written as binary little-endian with double coordinates.
    Ply,
    /// Object File Format, extension `off`.
    Off,
    /// VTK unstructured grid in XML, extension `vtu`.
    Vtu,
    /// gmsh mesh, extension `msh`; written as 4.1 or 2.2, read as 4.1 and as ASCII 2.2.
    Msh,
    /// gmsh script that fills the closed shells of the mesh file beside it, extension `geo`; written only, by [`write()`].
    Geo,
    /// Abaqus and CalculiX input, extension `inp`.
    Inp,
    /// Nastran bulk data, extension `bdf` or `nas`.
    Bdf,
    /// MED of Salome and code_aster, extension `med`; written only.
    Med,
    /// Medit mesh with ridges and corners, extension `mesh`.
    Medit,
    /// SU2 boundary with markers, extension `su2`; of a volume mesh the markers are read.
    Su2,
    /// OpenFOAM list of sharp edges, extension `emesh`; written only.
    EMesh,
    /// VTK polygon data in XML, extension `vtp`.
    Vtp,
    /// Borders of a plane figure, extension `svg`; written only.
    Svg,
    /// 3D Manufacturing Format, extension `3mf`; level sets in it are no mesh, and are read as parts.
    ThreeMf,
    /// Binary glTF 2.0, extension `glb`, with a material for each face; written only.
    Glb,
    /// XDMF 3 in one XML file with its numbers as text, extension `xdmf`; written only.
    Xdmf,
}

impl Format {
    /// Every extension known, with its format.
    pub const EXTENSIONS: [(&'static str, Format); 21] = [
        ("stl", Format::StlBinary),
        ("stla", Format::StlAscii),
        ("ast", Format::StlAscii),
        ("obj", Format::Obj),
        ("ply", Format::Ply),
        ("off", Format::Off),
        ("vtu", Format::Vtu),
        ("msh", Format::Msh),
        ("geo", Format::Geo),
        ("inp", Format::Inp),
        ("bdf", Format::Bdf),
        ("nas", Format::Bdf),
        ("med", Format::Med),
        ("mesh", Format::Medit),
        ("su2", Format::Su2),
        ("emesh", Format::EMesh),
        ("vtp", Format::Vtp),
        ("svg", Format::Svg),
        ("3mf", Format::ThreeMf),
        ("glb", Format::Glb),
        ("xdmf", Format::Xdmf),
    ];

    /// Whether files of this format name sets of triangles, so that a list of [`Names`] belongs beside them.
    pub fn has_sets(self) -> bool {
        matches!(self, Self::Msh | Self::Geo | Self::Inp | Self::Bdf | Self::Med | Self::Medit | Self::Su2 | Self::Vtp)
    }

    /// Whether it matters to files of this format what triangles are named by ([`WriteOptions::groups`]).
    pub fn heeds_groups(self) -> bool {
        self.has_sets() || self == Self::Glb
    }

    /// Whether files of this format are written in the order in which a mesh is read, without a copy of its triangles.
    pub fn is_streamed(self) -> bool {
        matches!(self, Self::StlBinary | Self::StlAscii | Self::Obj | Self::Ply | Self::Off | Self::Vtu | Self::Xdmf)
    }

    /// The format the file's extension stands for, whatever its case.
    ///
    /// # Errors
    /// [`Error::Usage`] listing the known extensions.
    pub fn from_path(path: &Path) -> Result<Format> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let found = extension.as_deref().and_then(|e| Self::EXTENSIONS.iter().find(|known| known.0 == e));
        found.map(|known| known.1).ok_or_else(|| {
            let known: Vec<_> = Self::EXTENSIONS.iter().map(|k| format!(".{}", k.0)).collect();
            let what = match &extension {
                Some(e) => format!("unknown extension .{e}"),
                None => "no extension to tell the format by".into(),
            };
            Error::Usage(format!("{}: {what}; known are {}", path.display(), known.join(", ")))
        })
    }
}

/// How numbers are stored, in the formats that allow both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// What [`write()`] uses: binary for PLY and VTU, text for MSH.
    #[default]
    Usual,
    /// Decimal text: the shortest digits, at most 17, that read back as the same `f64`.
    Text,
    /// Little-endian binary (base64 inside VTU).
    Binary,
}

/// Reads a mesh file.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, [`Error::Io`] when the file cannot be read, [`Error::Input`] naming the file
/// and the place when its content is no mesh (see [`read_bytes`]), [`Error::Cancelled`].
pub fn read(path: &Path, run: &Run) -> Result<TriMesh> {
    let format = Format::from_path(path)?;
    run.check()?;
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    decode(&bytes, format, run).map_err(|e| e.in_file(path))
}

/// Reads a mesh from the bytes of a file; `name` is used in errors only.
///
/// For either STL hint the content decides which spelling it is, since a binary header may begin with `solid`: first
/// whether the length is 84 + 50 times the count, then whether it looks like text.
///
/// # Errors
/// [`Error::Input`] with the line, byte or item for truncated files, counts that disagree with the size, coordinates that
/// are not finite, indices out of range, files without triangles, and anything else that is not the format.
/// [`Error::Usage`] for formats that are written only.
pub fn read_bytes(bytes: &[u8], format_hint: Format, name: &Path) -> Result<TriMesh> {
    decode(bytes, format_hint, &Run::new()).map_err(|e| e.in_file(name))
}

fn decode(bytes: &[u8], format: Format, run: &Run) -> Result<TriMesh> {
    if bytes.is_empty() {
        return Err(Error::input(Place::Unknown, "the file is empty"));
    }
    let mesh = match format {
        Format::StlBinary | Format::StlAscii => stl::read(bytes, run),
        Format::Obj => obj::read(bytes, run),
        Format::Ply => ply::read(bytes, run),
        Format::Off => off::read(bytes, run),
        Format::Msh => msh_read::read(bytes, run),
        Format::ThreeMf => threemf::read(bytes, run),
        Format::Medit => medit_read::read(bytes, run),
        Format::Vtp => vtk_read::read(bytes, "PolyData", run),
        Format::Vtu => vtk_read::read(bytes, "UnstructuredGrid", run),
        Format::Su2 => su2_read::read(bytes, run),
        Format::Inp => inp_read::read(bytes, run),
        Format::Bdf => bdf_read::read(bytes, run),
        _ => {
            let what = "files of this format are written, not read; give STL, OBJ, PLY, OFF, MSH, INP, BDF, Medit, SU2, VTP, VTU or 3MF";
            Err(Error::Usage(what.into()))
        }
    }?;
    if mesh.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "the file holds no triangle"));
    }
    Ok(mesh)
}

/// How a mesh file is written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WriteOptions {
    /// How numbers are stored.
    pub encoding: Encoding,
    /// What triangles are named by.
    pub groups: Grouping,
    /// Write gmsh's older version 2.2 (always text) in place of 4.1.
    pub old_msh: bool,
    /// Sharp edges within faces (pairs of nodes), beside the borders between faces.
    pub seams: Vec<[u32; 2]>,
    /// Nodes at sharp corners, beside those where borders meet.
    pub corners: Vec<u32>,
    /// The borders of a flat mesh in the plane z = 0, by name; what an SVG file holds. MSH, SU2, INP name its edges by them.
    pub outline: Option<Outline>,
    /// The unit of length, as a part file calls it, for the formats that tell it (3MF, GLB).
    pub unit: Option<String>,
}

/// What a writer did that the names of the mesh do not tell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Written {
    /// What the user may not expect.
    pub warnings: Vec<String>,
    /// What the file should hold and does not.
    pub shortfalls: Vec<String>,
    /// Names the format could not hold, with what stands there instead.
    pub renamed: Vec<[String; 2]>,
}

/// Writes a mesh in the format of the path's extension; the file appears complete or not at all.
///
/// The mesh is read as it is kept, in arrays or in fragments; formats with named sets take a copy of the triangles. Cells of more than three corners stay as
/// they are in OBJ, PLY, OFF and VTU files; STL, 3MF, GLB, XDMF, INP, BDF and MED get fans around their first corners. MSH has a number for triangles and
/// one for quadrilaterals, and none for other cells. A script (GEO) gets its mesh beside it, `a.msh` for `a.geo`.
///
/// # Errors
/// Those of [`check_writable`]; [`Error::Input`] for a mesh with no triangle, a node that is not finite, or an index out
/// of range; [`Error::Failed`] for a coordinate beyond the `f32` range of binary STL and GLB, for a cell MSH has no number for, and
/// for a script about a mesh without a closed shell, for an SVG of a mesh without an outline; [`Error::Io`]; [`Error::Cancelled`].
pub fn write(path: &Path, mesh: &dyn MeshView, options: &WriteOptions, run: &Run) -> Result<Written> {
    let format = Format::from_path(path)?;
    if format == Format::Geo {
        return write_script(path, mesh, options, run);
    }
    let mut written = Written::default();
    write_atomic(path, |out| {
        written = encode(out, mesh, format, options, run)?;
        Ok(())
    })?;
    Ok(written)
}

/// The mesh file that goes with a script.
fn mesh_of_script(path: &Path) -> PathBuf {
    path.with_extension("msh")
}

fn write_script(path: &Path, mesh: &dyn MeshView, options: &WriteOptions, run: &Run) -> Result<Written> {
    build::check_mesh(mesh)?;
    let layout = layout::Layout::new(mesh, options)?;
    let regions = regions::RegionSets::new(mesh, options.groups, &layout);
    let beside = mesh_of_script(path);
    let name = beside.file_name().unwrap_or_default().to_string_lossy();
    let mut script = Vec::new();
    geo::write(&mut script, &name, &layout, &regions)?;
    // Only 4.1 says which curves bound a surface.
    let mut written = write(&beside, mesh, &WriteOptions { old_msh: false, ..options.clone() }, run)?;
    write_atomic(path, |out| out.write_all(&script).map_err(atomic::write_failed))?;
    if options.old_msh {
        let what = "is of version 4.1, as 2.2 cannot say which curves bound a surface";
        written.warnings.push(format!("{} beside {} {what}", beside.display(), path.display()));
    }
    match layout.open_shells {
        0 => {}
        1 => written.shortfalls.push("1 shell is open and is not filled".into()),
        n => written.shortfalls.push(format!("{n} shells are open and are not filled")),
    }
    Ok(written)
}

/// Writes a mesh as `format` to any stream; [`write()`] without a file.
///
/// STL, OBJ, OFF, XDMF, GLB, INP, BDF and MED have one encoding each and ignore that of the options.
///
/// # Errors
/// As [`write()`], without those about the path; [`Error::Usage`] for a script, which is about a file beside it.
pub fn encode(
    out: &mut dyn Write,
    mesh: &dyn MeshView,
    format: Format,
    options: &WriteOptions,
    run: &Run,
) -> Result<Written> {
    build::check_mesh(mesh)?;
    let encoding = options.encoding;
    match format {
        Format::StlBinary => stl::write_binary(out, mesh, run),
        Format::StlAscii => stl::write_ascii(out, mesh, run),
        Format::Obj => obj::write(out, mesh, run),
        Format::Ply => ply::write(out, mesh, encoding != Encoding::Text, run),
        Format::Off => off::write(out, mesh, run),
        Format::Vtu => vtu::write(out, mesh, encoding != Encoding::Text, run),
        Format::Xdmf => xdmf::write(out, mesh, run),
        Format::Svg => svg::write(out, mesh, options),
        Format::Glb => glb::write(out, mesh, options, run),
        Format::Geo => Err(Error::Usage("a script is written by its path, as it names the mesh file beside it".into())),
        _ => return encode_sets(out, mesh, format, options, run),
    }?;
    Ok(Written::default())
}

/// Formats that name sets of triangles.
fn encode_sets(
    out: &mut dyn Write,
    mesh: &dyn MeshView,
    format: Format,
    options: &WriteOptions,
    run: &Run,
) -> Result<Written> {
    let layout = layout::Layout::new(mesh, options)?;
    let regions = regions::RegionSets::new(mesh, options.groups, &layout);
    let mut written = Written { warnings: regions.warnings.clone(), ..Written::default() };
    if format == Format::ThreeMf {
        threemf::write(out, mesh, &layout, options.unit.as_deref(), run)?;
        return Ok(Written::default());
    }
    let overlapping = &regions.sets[regions.parts..];
    let apart = matches!(format, Format::Medit | Format::Su2) || format == Format::Msh && options.old_msh;
    if apart && !overlapping.is_empty() {
        let names: Vec<_> = overlapping.iter().map(|set| &set.name[..]).collect();
        written.warnings.push(format!("sets of this format do not overlap, left out are {}", names.join(", ")));
    }
    if format == Format::Msh {
        let gmsh = msh::Gmsh { mesh, layout: &layout, regions: &regions };
        if options.old_msh {
            gmsh.write_old(out, run)
        } else {
            gmsh.write(out, options.encoding == Encoding::Binary, run)
        }?;
        return Ok(written);
    }
    if format == Format::Vtp {
        vtp::write(out, mesh, &regions, options.encoding != Encoding::Text, run)?;
        return Ok(written);
    }
    if format == Format::EMesh {
        let sharp = sharp::SharpEdges::new(mesh, &layout, options, run)?;
        emesh::write(out, mesh, &sharp)?;
        return Ok(written);
    }
    let cleaned = regions.clean(format);
    written.renamed = cleaned.changed;
    let sets = sets::NamedSets::new(mesh, &regions, cleaned.names)?;
    let rims = options.outline.as_ref().map(|o| o.clean_sets(options.groups));
    match format {
        Format::Inp => inp::write(out, &sets, rims.as_deref(), run),
        Format::Su2 => match &rims {
            Some(rims) => su2::write_flat(out, &sets, rims, run),
            None => su2::write(out, &sets, run),
        },
        Format::Med => {
            written.renamed = med::write(out, &sets, run)?;
            Ok(())
        }
        Format::Medit => medit::write(out, &sets, &sharp::SharpEdges::new(mesh, &layout, options, run)?, run),
        _ => bdf::write(out, &sets, run),
    }?;
    Ok(written)
}

/// The names in files of this mesh, and what they stand for.
///
/// # Errors
/// As [`write()`], without those about the path and the format.
pub fn names(mesh: &dyn MeshView, options: &WriteOptions) -> Result<Names> {
    build::check_mesh(mesh)?;
    let layout = layout::Layout::new(mesh, options)?;
    let regions = regions::RegionSets::new(mesh, options.groups, &layout);
    Ok(Names::new(mesh, options.groups, &layout, &regions))
}

/// Whether [`write()`] could work on this path, so that a command can refuse before the computation.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, a missing folder or a path that is a folder; each names it.
pub fn check_writable(path: &Path) -> Result<()> {
    if Format::from_path(path)? == Format::Geo {
        atomic::check_folder(&mesh_of_script(path))?;
    }
    atomic::check_folder(path)
}

/// Whether [`write()`] could work on all of these paths, none of which writes what another one has written.
///
/// # Errors
/// Those of [`check_writable`]; [`Error::Usage`] for a `.msh` file of version 2.2 that is that of a script too, which needs 4.1.
pub fn check_all_writable(paths: &[PathBuf], options: &WriteOptions) -> Result<()> {
    paths.iter().try_for_each(|path| check_writable(path))?;
    let plain = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for script in paths {
        if !options.old_msh || Format::from_path(script)? != Format::Geo {
            continue;
        }
        let beside = mesh_of_script(script);
        if paths.iter().any(|p| plain(p) == plain(&beside)) {
            let (mesh, script) = (beside.display(), script.display());
            let what =
                format!("{mesh} cannot be of version 2.2, as {script} needs it to be of 4.1: give one another name");
            return Err(Error::Usage(what));
        }
    }
    Ok(())
}
