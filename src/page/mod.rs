//! A page that shows a mesh: one HTML file that opens from disk and needs nothing but a browser with WebGL2; and the same without
//! the mesh, as tables.
//!
//! The page is a picture: coordinates are rounded to 2^21 steps along the longest side of the mesh's box. What it tells
//! of the mesh (warnings, shortfalls, certificate, figures) is handed over as text and is not measured again.

mod encode;
mod tables;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::numeric::base64::base64;
use crate::quality::Fault;
use crate::run::Run;

pub use encode::{Pictured, decode};
pub use tables::{PageColumn, PageTable, tables};

/// More triangles than this are not put into a page: browsers refuse texts of that length.
const MOST_TRIANGLES: usize = 1 << 24;

/// The page without what is put into it.
const HTML: &str = include_str!("page.html");
/// How it looks.
const CSS: &str = include_str!("page.css");
/// Draws the mesh.
const SCENE: &str = include_str!("scene.js");
/// Answers to clicks and keys.
const SCRIPT: &str = include_str!("page.js");
/// Has a served page take over what its server made since.
const FOLLOW: &str = include_str!("follow.js");

/// What a line of the page is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PageKind {
    /// Something the mesh falls short of.
    Shortfall,
    /// Something worth knowing.
    Warning,
    /// A place at which something was not proved.
    Unproved,
    /// Something that was repaired.
    Repair,
    /// Something to look at that is no fault.
    Note,
}

/// A line the page tells; with places it leads to them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PageLine {
    /// What it is about.
    pub kind: PageKind,
    /// The words.
    pub text: String,
    /// Places it speaks of, in the mesh's unit. Where there are none the page looks for coordinates in the words.
    pub places: Vec<[f64; 3]>,
}

impl PageLine {
    /// A line without places.
    pub fn new(kind: PageKind, text: impl Into<String>) -> Self {
        Self { kind, text: text.into(), places: Vec::new() }
    }

    /// A line that leads to places.
    pub fn at(kind: PageKind, text: impl Into<String>, places: Vec<[f64; 3]>) -> Self {
        Self { kind, text: text.into(), places }
    }

    /// What a fault says, and where it is.
    pub fn of_fault(fault: &Fault) -> Self {
        Self::at(PageKind::Shortfall, fault.to_string(), fault.places())
    }
}

/// A figure of the mesh and its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PageFact {
    /// What was measured.
    pub name: String,
    /// How much it is, with its unit.
    pub value: String,
}

/// What a page tells of its mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PageText {
    /// The title, such as the part's name.
    pub title: String,
    /// The unit of lengths, where there is one.
    pub units: Option<String>,
    /// The length of edges that was asked for, where it is known.
    pub size: Option<f64>,
    /// Whether the mesh is sound; nothing where that was not looked at.
    pub sound: Option<bool>,
    /// The certificate in words, sentence by sentence.
    pub certificate: Vec<String>,
    /// Shortfalls, warnings and the rest, in the order they are shown in.
    pub lines: Vec<PageLine>,
    /// Figures.
    pub facts: Vec<PageFact>,
}

impl PageText {
    /// Adds a figure.
    pub fn fact(&mut self, name: &str, value: impl Into<String>) {
        self.facts.push(PageFact { name: name.into(), value: value.into() });
    }
}

/// A face as the page lists it.
#[derive(Serialize)]
struct ListedFace<'a> {
    name: &'a str,
    triangles: usize,
    area: f64,
}

/// A group as the page lists it.
#[derive(Serialize)]
struct ListedGroup<'a> {
    name: &'a str,
    faces: &'a [u32],
}

/// All the page is told besides the mesh.
#[derive(Serialize)]
struct Contents<'a> {
    #[serde(flatten)]
    text: &'a PageText,
    #[serde(flatten)]
    layout: encode::StreamLayout,
    faces: Vec<ListedFace<'a>>,
    groups: Vec<ListedGroup<'a>>,
}

/// The page of a mesh, as HTML in UTF-8. The same mesh and text give the same bytes.
///
/// # Errors
/// [`Error::Input`] for a mesh that is not [valid](TriMesh::validate) (corners and labels that do not exist, coordinates
/// that are no numbers), [`Error::Failed`] where there are more than 16 million triangles, cancellation.
pub fn page(mesh: &TriMesh, text: &PageText, run: &Run) -> Result<String> {
    framed(mesh, text, None, run)
}

/// The [`page`] for a server that makes it again: it asks for `state`, beside its own address, several times a second.
///
/// The answer is a JSON object. `version` is the number of the newest page: where it is not the page's own, the page loads itself
/// anew and keeps camera, check boxes and colors. `meshing` tells whether a mesh is being made. `trouble` is null, or holds
/// `what` went wrong, with the line of the `source` and `help` where these are known. All of it is shown as text.
///
/// # Errors
/// Those of [`page`].
pub fn followed_page(mesh: &TriMesh, text: &PageText, version: u64, run: &Run) -> Result<String> {
    framed(mesh, text, Some(version), run)
}

/// A page, and what makes it follow a server where it has a version.
fn framed(mesh: &TriMesh, text: &PageText, version: Option<u64>, run: &Run) -> Result<String> {
    mesh.validate()?;
    if mesh.triangles.len() > MOST_TRIANGLES {
        let (n, most) = (mesh.triangles.len(), MOST_TRIANGLES);
        return Err(Error::Failed(format!("{n} triangles are too many for a page, which holds {most}")));
    }
    run.progress("page", 0.0);
    let mut faces: Vec<ListedFace> =
        mesh.faces.iter().map(|name| ListedFace { name, triangles: 0, area: 0.0 }).collect();
    for (t, label) in mesh.labels.iter().enumerate() {
        let face = &mut faces[*label as usize];
        face.triangles += 1;
        face.area += 0.5 * mesh.area_vector(t).length();
    }
    let groups = mesh.groups.iter().map(|g| ListedGroup { name: &g.name, faces: &g.faces }).collect();
    let (layout, bytes) = encode::encode(mesh, run)?;
    run.progress("page", 0.7);
    let contents = Contents { text, layout, faces, groups };
    let json = serde_json::to_string(&contents).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))?;
    // No text of JSON can end its element, or begin a comment in it, without this character.
    let json = json.replace('<', "\\u003c");
    let data = base64(&bytes);
    let mut out = String::with_capacity(HTML.len() + CSS.len() + SCENE.len() + SCRIPT.len() + json.len() + data.len());
    // A page on its own asks nobody for anything, and its policy does not let it.
    let connect = if version.is_some() { "; connect-src 'self'" } else { "" };
    let follow = version.map_or_else(String::new, |v| format!("const VERSION = {v};\n{FOLLOW}"));
    let mut rest = HTML;
    for (mark, content) in [
        ("/*CONNECT*/", connect),
        ("/*CSS*/", CSS),
        ("/*TOLD*/", json.as_str()),
        ("/*MESH*/", &data),
        ("/*SCENE*/", SCENE),
        ("/*SCRIPT*/", SCRIPT),
        ("/*FOLLOW*/", &follow),
    ] {
        // Marks are looked for in the frame alone, so what is put in cannot look like one.
        let Some((before, after)) = rest.split_once(mark) else {
            return Err(Error::Failed(format!("the page's frame lacks {mark}")));
        };
        out.push_str(before);
        out.push_str(content);
        rest = after;
    }
    out.push_str(rest);
    Ok(out)
}
