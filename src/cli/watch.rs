//! `mesh --watch` and `view --serve`: the mesh is made again whenever the files it is made from change.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, SystemTime};

use rvachev::run::CancelToken;
use rvachev::{Error, Result, Run, pipeline};

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

/// The files a mesh is made from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Sources {
    /// Those the command names: the part, and a sequence of operators.
    named: Vec<PathBuf>,
    /// Those the part reads, as it was when it could be read last.
    read: Vec<PathBuf>,
}

/// What is known of them.
#[derive(Debug, Clone, PartialEq, Eq)]
struct WatchedStates {
    named: Stamps,
    read: Stamps,
}

impl Sources {
    fn look(&self) -> WatchedStates {
        WatchedStates { named: look(&self.named), read: look(&self.read) }
    }

    /// Asks the part again which files it reads. One with a mistake in it is taken to read those it did.
    fn ask(&mut self, a: &Mesh) {
        let part = &a.part;
        if pipeline::is_step(&part.part) || pipeline::is_mesh(&part.part) {
            return;
        }
        if let Ok(now) = pipeline::load_part(&part.part, &part.define) {
            self.read = pipeline::files_read(&now);
        }
    }
}

impl WatchedStates {
    /// Whether a mesh may be made of what is there: the part may be about to name others, but those it read are waited for while
    /// they are replaced.
    fn is_whole(&self, before: &WatchedStates) -> bool {
        let here = |now: &Stamps, was: &Stamps| now.iter().zip(was).all(|(n, w)| n.is_some() || w.is_none());
        self.named.iter().all(Option::is_some) && (self.named != before.named || here(&self.read, &before.read))
    }
}

/// Meshes until Ctrl-C.
pub fn watch(a: &Mesh) -> Result<bool> {
    if a.bricks.is_some() {
        return Err(Error::Usage("--watch does not go with --bricks".into()));
    }
    let files = sources(a)?;
    follow(a, files, &unwatched(&a.common)?, |run| mesh_once(a, run))
}

/// The files a mesh is made from. Errors: one of those the command names is not there.
pub(super) fn sources(a: &Mesh) -> Result<Sources> {
    let mut files = vec![a.part.part.clone()];
    let sequence = a.operators.sequence.as_deref().and_then(|s| s.strip_prefix('@'));
    files.extend(sequence.map(PathBuf::from));
    for path in &files {
        std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    }
    Ok(Sources { named: files, read: Vec::new() })
}

/// Calls `make` at once and whenever the files have changed, until Ctrl-C. Mistakes in the files are told and wait to be put right;
/// mistakes in the options end it.
pub(super) fn follow(
    a: &Mesh,
    mut files: Sources,
    base: &Run,
    mut make: impl FnMut(&Run) -> Result<bool>,
) -> Result<bool> {
    let mut first = true;
    loop {
        files.ask(a);
        let seen = files.look();
        match unless_changed(&files, &seen, base, &mut make) {
            Err(Error::Cancelled) => base.check()?,
            Err(e @ Error::Usage(_)) if first => return Err(e),
            Err(e) => explain(&e),
            Ok(_) => {}
        }
        first = false;
        if !a.common.quiet && files.look() == seen {
            note("watching", &[a.part.part.display()]);
        }
        wait_for_change(&files, &seen, base)?;
    }
}

/// Makes the mesh, or stops when the files change: what would come of it is out of date.
fn unless_changed(
    files: &Sources,
    seen: &WatchedStates,
    base: &Run,
    make: impl FnOnce(&Run) -> Result<bool>,
) -> Result<bool> {
    let (token, ended) = (CancelToken::new(), AtomicBool::new(false));
    let run = base.clone().with_cancel(token.clone());
    thread::scope(|s| {
        let looking = s.spawn(|| {
            while !ended.load(Ordering::Acquire) {
                if base.is_cancelled() || files.look() != *seen {
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

/// Returns when the files are others than those seen, there, and no longer being written.
fn wait_for_change(files: &Sources, seen: &WatchedStates, run: &Run) -> Result<()> {
    let mut before = files.look();
    loop {
        thread::sleep(LOOK);
        run.check()?;
        let now = files.look();
        if now == before && now != *seen && now.is_whole(seen) {
            return Ok(());
        }
        before = now;
    }
}
