//! Files that appear complete or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, Result};

/// Buffer between the encoders' small writes and the system: large enough that the calls do not show in profiles.
const BUFFER: usize = 1 << 18;

/// Removes the temporary file unless it was renamed to its final name.
struct Temporary {
    path: PathBuf,
    kept: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.kept {
            // Nothing more can be done about a temporary file that refuses to go.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The folder a file goes to, `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses a path whose folder is missing or that is a folder itself.
pub(super) fn check_folder(path: &Path) -> Result<()> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Error::Usage(format!(
            "cannot write {}: the folder {} does not exist",
            path.display(),
            folder.display()
        )));
    }
    if path.is_dir() {
        return Err(Error::Usage(format!("cannot write {}: it is a folder", path.display())));
    }
    Ok(())
}

/// Lets `fill` write to a temporary file in the folder of `path` and renames it to `path` when all went well.
///
/// Whatever happens before the rename, an existing file at `path` stays as it was and no other file is left behind.
///
/// # Errors
/// [`Error::Usage`] naming the folder if it is missing; [`Error::Io`]; whatever `fill` returns.
pub fn write_atomic(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    check_folder(path)?;
    let broken = |e: io::Error| Error::io("write", path, e);
    let (mut temporary, file) = create_beside(path)?;
    let mut out = BufWriter::with_capacity(BUFFER, file);
    fill(&mut out).map_err(|e| match e {
        Error::Io { path: unnamed, action, source } if unnamed.as_os_str().is_empty() => {
            Error::io(action, path, source)
        }
        other => other,
    })?;
    let file = out.into_inner().map_err(|e| broken(e.into_error()))?;
    file.sync_all().map_err(broken)?;
    drop(file);
    fs::rename(&temporary.path, path).map_err(broken)?;
    temporary.kept = true;
    Ok(())
}

/// A fresh file beside `path`: a rename is atomic only within one file system.
fn create_beside(path: &Path) -> Result<(Temporary, File)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| Error::Usage(format!("{} is no file name", path.display())))?;
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let mut unique = std::ffi::OsString::from(".");
        unique.push(name);
        unique.push(format!(".{}-{number}.part", std::process::id()));
        let candidate = folder_of(path).join(unique);
        match OpenOptions::new().write(true).create_new(true).open(&candidate) {
            Ok(file) => return Ok((Temporary { path: candidate, kept: false }, file)),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => continue,
            Err(e) => return Err(Error::io("create", path, e)),
        }
    }
}

/// A failed write whose file is not known here; [`write_atomic`] fills it in.
pub(super) fn write_failed(e: io::Error) -> Error {
    Error::io("write", PathBuf::new(), e)
}
