//! `mesh --watch` and `view --serve`: the mesh is made again whenever the files it is made from change.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, SystemTime};

use rvachev::run::CancelToken;
use rvachev::{Error, Result, Run};

use super::arguments::Mesh;
use super::commands::mesh_once;
use super::console::{explain, note, unwatched};

/// How often files are looked at. A file that stays the same for two looks has been written to its end.
const LOOK: Duration = Duration::from_millis(120);

/// When a file was written and how long it is; nothing where there is none.
type Stamps = Vec<Option<(SystemTime, u64)>>;

fn look(files: &[PathBuf]) -> Stamps {
    let one = |path: &PathBuf| {
        let data = std::fs::metadata(path).ok()?;
        Some((data.modified().ok()?, data.len()))
    };
    files.iter().map(one).collect()
}

/// Meshes until Ctrl-C.
pub fn watch(a: &Mesh) -> Result<bool> {
    if a.bricks.is_some() {
        return Err(Error::Usage("--watch does not go with --bricks".into()));
    }
    let files = sources(a)?;
    follow(a, &files, &unwatched(&a.common)?, |run| mesh_once(a, run))
}

/// The files a mesh is made from. Errors: one that is not there.
pub(super) fn sources(a: &Mesh) -> Result<Vec<PathBuf>> {
    let mut files = vec![a.part.part.clone()];
    let sequence = a.operators.sequence.as_deref().and_then(|s| s.strip_prefix('@'));
    files.extend(sequence.map(PathBuf::from));
    for path in &files {
        std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    }
    Ok(files)
}

/// Calls `make` at once and whenever the files have changed, until Ctrl-C. Mistakes in the files are told and wait to be put right;
/// mistakes in the options end it.
pub(super) fn follow(
    a: &Mesh,
    files: &[PathBuf],
    base: &Run,
    mut make: impl FnMut(&Run) -> Result<bool>,
) -> Result<bool> {
    let mut first = true;
    loop {
        let seen = look(files);
        match unless_changed(files, &seen, base, &mut make) {
            Err(Error::Cancelled) => base.check()?,
            Err(e @ Error::Usage(_)) if first => return Err(e),
            Err(e) => explain(&e),
            Ok(_) => {}
        }
        first = false;
        if !a.common.quiet && look(files) == seen {
            note("watching", &[a.part.part.display()]);
        }
        wait_for_change(files, seen, base)?;
    }
}

/// Makes the mesh, or stops when the files change: what would come of it is out of date.
fn unless_changed(
    files: &[PathBuf],
    seen: &Stamps,
    base: &Run,
    make: impl FnOnce(&Run) -> Result<bool>,
) -> Result<bool> {
    let (token, ended) = (CancelToken::new(), AtomicBool::new(false));
    let run = base.clone().with_cancel(token.clone());
    thread::scope(|s| {
        let looking = s.spawn(|| {
            while !ended.load(Ordering::Acquire) {
                if base.is_cancelled() || look(files) != *seen {
                    return token.cancel();
                }
                thread::park_timeout(LOOK);
            }
        });
        let made = make(&run);
        ended.store(true, Ordering::Release);
        looking.thread().unpark();
        made
    })
}

/// Returns when the files are others than those seen, all there, and no longer being written.
fn wait_for_change(files: &[PathBuf], seen: Stamps, run: &Run) -> Result<()> {
    let mut before = look(files);
    loop {
        thread::sleep(LOOK);
        run.check()?;
        let now = look(files);
        if now == before && now != seen && now.iter().all(Option::is_some) {
            return Ok(());
        }
        before = now;
    }
}
