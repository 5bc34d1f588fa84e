//! Parts from files, by which ending tells the reader, and back to formula files.

use std::path::{Path, PathBuf};

use super::boolean::files_of;
use super::figure::no_figure;
use crate::error::{Error, Place, Result};
use crate::implicit::part::{Part, parse, parse_csg, parse_model, parse_vm};
use crate::implicit::{Implicit, write_3mf, write_vm};
use crate::io::threemf::model_text;

/// Reads a part file, or by its ending a formula file (`.vm`), a tree of OpenSCAD's (`.csg`) or a package with level sets
/// (`.3mf`). Errors name the file, line and column.
///
/// `overrides` are for part files: for the others, which have no named numbers, they are an [`Error::Usage`].
pub fn load_part(path: &Path, overrides: &[(String, f64)]) -> Result<Part> {
    parse_part(path, &part_text(path)?, overrides)
}

/// The text of a file that [`parse_part`] reads: that of the model in a 3MF package, else the file's own.
pub fn part_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    if is_3mf(path) {
        return model_text(&bytes).map_err(|e| e.in_file(path));
    }
    String::from_utf8(bytes).map_err(|e| {
        let what = match ending(path).as_deref() {
            Some("vm") => "a formula must be UTF-8 text",
            Some("csg") => "a tree of OpenSCAD's must be UTF-8 text",
            _ => "a part file must be UTF-8 text",
        };
        Error::input(Place::Byte(e.utf8_error().valid_up_to() as u64), what).in_file(path)
    })
}

/// Reads the text of a file as [`load_part`] does; the path tells what it is, and is named in errors.
pub fn parse_part(path: &Path, text: &str, overrides: &[(String, f64)]) -> Result<Part> {
    let read: fn(&str) -> Result<Part> = match ending(path).as_deref() {
        Some("vm") => parse_vm,
        Some("csg") => parse_csg,
        Some("3mf") => parse_model,
        _ => {
            let part = parse(text, overrides).map_err(|e| e.in_file(path))?;
            let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
            return Ok(Part { folder, ..part });
        }
    };
    no_overrides(path, overrides)?;
    read(text).map_err(|e| e.in_file(path))
}

fn no_overrides(path: &Path, overrides: &[(String, f64)]) -> Result<()> {
    let Some((name, _)) = overrides.first() else { return Ok(()) };
    let what = format!("-D {name}: {} has no named numbers to override, only part files (.py) have", path.display());
    Err(Error::Usage(what))
}

/// The files that solids of a part are read from when it is meshed, those of `mesh("...")` and `step("...")`: each once, with
/// the part file's folder before relative paths. Whether they are there is not looked at.
pub fn files_read(part: &Part) -> Vec<PathBuf> {
    part.solid.iter().flat_map(files_of).map(|path| part.folder.join(path)).collect()
}

/// What a file's name ends in, in small letters.
fn ending(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase())
}

/// Whether a path is that of a formula file.
pub fn is_vm(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vm"))
}

/// Whether a path is that of a 3MF package.
pub fn is_3mf(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("3mf"))
}

/// The part's solid of R-functions as a 3MF package with a level set: see [`write_3mf`] for what is lost.
///
/// Errors: those of [`vm_text`].
pub fn levelset_bytes(part: &Part, name: &str) -> Result<Vec<u8>> {
    write_3mf(&function_of(part, "a level set")?, name, part.units.as_deref())
}

/// The part's solid of R-functions as the text of a formula file: see [`write_vm`] for what is lost.
///
/// Errors: a part without such a solid, or with others beside it; what [`Implicit::new`] and [`write_vm`] refuse.
pub fn vm_text(part: &Part) -> Result<String> {
    write_vm(&function_of(part, "a formula file")?)
}

fn function_of(part: &Part, file: &str) -> Result<Implicit> {
    no_figure(part, file)?;
    match &part.solid {
        Some(solid) if part.built.is_empty() => {
            Implicit::new(solid, part.rsystem, part.domain).map_err(|e| part.located(e))
        }
        _ => Err(Error::input(Place::Unknown, "a solid built from edges cannot be written as a formula")
            .with_help("convert writes it as STEP")),
    }
}
