//! `view --serve`: a page that follows its part while that is edited.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rvachev::mesh::TriMesh;
use rvachev::page::{self, PageText};
use rvachev::{Error, Place, Result, Run};
use serde::Serialize;

use super::arguments::{Mesh, ViewPage};
use super::commands::{Told, ended, made, shown, title};
use super::console::{say, unwatched, visible, watched};
use super::http::{Doorway, HttpContent};
use super::watch;

/// Of a longer line of a source this many characters are shown.
const LONGEST_SOURCE: usize = 300;

/// What went wrong with the newest state of the part, in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Trouble {
    /// File, line, column and message.
    what: String,
    /// The line of the file.
    source: Option<String>,
    help: Option<String>,
}

impl Trouble {
    fn of(e: &Error) -> Self {
        let what = visible(&e.to_string());
        let Error::Input { file, place, help, .. } = e else { return Self { what, source: None, help: None } };
        let line = match place {
            Place::Text { line, .. } | Place::Line(line) => file.as_deref().and_then(|f| line_of(f, *line)),
            _ => None,
        };
        Self { what, source: line.as_deref().map(visible), help: help.as_deref().map(visible) }
    }
}

/// A line of a text file, 1-based.
fn line_of(file: &Path, line: usize) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let found = text.lines().nth(line.checked_sub(1)?)?;
    Some(found.chars().take(LONGEST_SOURCE).collect())
}

/// What the page asks for again and again; `page::followed_page` says what it does with it.
#[derive(Debug, Default, Serialize)]
struct PageState {
    version: u64,
    meshing: bool,
    trouble: Option<Trouble>,
}

/// What is served: the last page that could be made, and what is told of it.
struct Shown {
    page: Arc<str>,
    state: PageState,
}

impl Shown {
    /// What stands at a path behind the token.
    fn at(&self, path: &str) -> Option<HttpContent> {
        match path {
            "" => Some(HttpContent { kind: "text/html; charset=utf-8", body: Arc::clone(&self.page) }),
            "state" => {
                // Nothing in it is taken for markup, wherever it may end up.
                let json = serde_json::to_string(&self.state).ok()?.replace('<', "\\u003c");
                Some(HttpContent { kind: "application/json", body: json.into() })
            }
            _ => None,
        }
    }
}

fn locked(shown: &Mutex<Shown>) -> MutexGuard<'_, Shown> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Serves the page of a part until Ctrl-C. A mistake in the part is told, in the page too, which keeps its last picture.
pub fn serve(a: ViewPage) -> Result<bool> {
    let port = a.port;
    // As options of `mesh` these say that a page is wanted; no file is written.
    let a = a.into_mesh();
    let files = watch::sources(&a)?;
    let base = unwatched(&a.common)?;
    let text = PageText { title: title(&a.part.part), ..PageText::default() };
    let nothing = page::followed_page(&TriMesh::default(), &text, 0, &base)?;
    let shown = Arc::new(Mutex::new(Shown { page: nothing.into(), state: PageState::default() }));
    let doorway = Doorway::new(port)?;
    say(&doorway.address());
    let served = Arc::clone(&shown);
    doorway.open(move |path| locked(&served).at(path))?;
    watch::follow(&a, files, &base, |run| {
        locked(&shown).state.meshing = true;
        let good = show(&a, &shown, run);
        match &good {
            // After a cancellation the next mesh is about to begin, or all ends.
            Ok(_) | Err(Error::Cancelled) => {}
            Err(e) => {
                let trouble = Some(Trouble::of(e));
                let mut now = locked(&shown);
                now.state = PageState { version: now.state.version, meshing: false, trouble };
            }
        }
        good
    })
}

/// Makes the mesh and puts its page in the place of the last one. Whether the mesh is what was asked for.
fn show(a: &Mesh, shown_page: &Mutex<Shown>, base: &Run) -> Result<bool> {
    let run = watched(base.clone(), &a.common, "view", a.verbose);
    let made = made(a, &run)?;
    let told = Told::default();
    let version = locked(shown_page).state.version + 1;
    let html = page::followed_page(&made.mesh, &shown(&made, &a.part.part, &told), version, &run)?;
    drop(run);
    let mut now = locked(shown_page);
    now.page = html.into();
    now.state = PageState { version, ..PageState::default() };
    drop(now);
    Ok(ended(&made, &told, a.common.quiet))
}
