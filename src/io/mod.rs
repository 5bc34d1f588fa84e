//! Mesh files: STL, OBJ, PLY, OFF and gmsh MSH both ways, VTU out.
//!
//! What survives a write followed by a read of the same file:
//!
//! | format | coordinates | nodes' order | triangles' order | face names, labels | groups |
//! |---|---|---|---|---|---|
//! | MSH 4.1 | bit-exact | kept | kept | kept | kept |
//! | PLY | bit-exact | kept | kept | kept | kept |
//! | OFF | bit-exact | kept | kept | lost | lost |
//! | OBJ | bit-exact | kept | by face | kept, but faces without triangles | lost |
//! | ASCII STL | bit-exact | first use | by face | kept, but faces without triangles | lost |
//! | binary STL | nearest `f32` | first use | kept | lost | lost |
//! | VTU | bit-exact | written only | | | |
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
mod build;
mod line;
mod msh;
mod msh_read;
mod obj;
mod off;
mod ply;
pub mod step;
mod stl;
mod text;
mod vtu;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

pub use atomic::write_atomic;

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
    /// VTK unstructured grid in XML, extension `vtu`; written only.
    Vtu,
    /// gmsh mesh, extension `msh`; written as 4.1, read as 4.1 and as ASCII 2.2.
    Msh,
}

impl Format {
    /// Every extension known, with its format.
    pub const EXTENSIONS: [(&'static str, Format); 8] = [
        ("stl", Format::StlBinary),
        ("stla", Format::StlAscii),
        ("ast", Format::StlAscii),
        ("obj", Format::Obj),
        ("ply", Format::Ply),
        ("off", Format::Off),
        ("vtu", Format::Vtu),
        ("msh", Format::Msh),
    ];

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
/// [`Error::Usage`] for [`Format::Vtu`], which is written only.
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
        Format::Vtu => Err(Error::Usage("VTU files are written, not read; give STL, OBJ, PLY, OFF or MSH".into())),
    }?;
    if mesh.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "the file holds no triangle"));
    }
    Ok(mesh)
}

/// Writes a mesh in the format of the path's extension; the file appears complete or not at all.
///
/// The mesh is read as it is kept, in arrays or in fragments, and not copied. Cells of more than three corners stay as
/// they are in OBJ, PLY, OFF and VTU files; STL gets fans around their first corners. MSH has a number for triangles and
/// one for quadrilaterals, and none for other cells.
///
/// # Errors
/// Those of [`check_writable`]; [`Error::Input`] for a mesh with no triangle, a node that is not finite, or an index out
/// of range; [`Error::Failed`] for a coordinate beyond the `f32` range of binary STL and for a cell MSH has no number for; [`Error::Io`]; [`Error::Cancelled`].
pub fn write(path: &Path, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let format = Format::from_path(path)?;
    write_atomic(path, |out| encode(out, mesh, format, Encoding::Usual, run))
}

/// Writes a mesh as `format` to any stream; [`write()`] with a choice of encoding.
///
/// STL, OBJ and OFF have one encoding each and ignore `encoding`.
///
/// # Errors
/// As [`write()`], without those about the path.
pub fn encode(out: &mut dyn Write, mesh: &dyn MeshView, format: Format, encoding: Encoding, run: &Run) -> Result<()> {
    build::check_mesh(mesh)?;
    match format {
        Format::StlBinary => stl::write_binary(out, mesh, run),
        Format::StlAscii => stl::write_ascii(out, mesh, run),
        Format::Obj => obj::write(out, mesh, run),
        Format::Ply => ply::write(out, mesh, encoding != Encoding::Text, run),
        Format::Off => off::write(out, mesh, run),
        Format::Vtu => vtu::write(out, mesh, encoding != Encoding::Text, run),
        Format::Msh => msh::write(out, mesh, encoding == Encoding::Binary, run),
    }
}

/// Whether [`write()`] could work on this path, so that a command can refuse before the computation.
///
/// # Errors
/// [`Error::Usage`] for an unknown extension, a missing folder or a path that is a folder; each names it.
pub fn check_writable(path: &Path) -> Result<()> {
    Format::from_path(path)?;
    atomic::check_folder(path)
}
