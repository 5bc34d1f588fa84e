//! The part file: a declarative subset of Python that describes a solid.
//!
//! Parsed by `ruff_python_parser`, interpreted by us: assignments, loops over lists, conditions, arithmetic, comparisons,
//! tuples, lists, comprehensions, calls, methods, and functions. Everything else is refused with its place. Evaluation is
//! bounded by [`limits`].

mod arguments;
mod builtins;
mod csg;
mod curves;
mod edges;
mod figures;
mod foreign;
mod functions;
mod guard;
mod interpreter;
mod lists;
mod methods;
mod modules;
mod operators;
mod origins;
pub mod recipe;
mod refused;
mod sheets;
mod statements;
#[cfg(test)]
mod tests;
mod threemf;
mod value;
mod vm;

use std::path::PathBuf;
use std::sync::Arc;

use super::rfunction::RSystem;
use super::solid::Solid;
use crate::error::{Error, Place, Result};
use crate::sizing::SizeRequest;
use crate::spatial::Aabb;

pub use csg::parse_csg;
pub use threemf::{parse_3mf, parse_model};
pub use vm::parse_vm;

/// Bounds on what a part file may ask for. Errors name the bound that was met.
pub mod limits {
    /// Bytes of a part file.
    pub const SOURCE_BYTES: usize = 4 << 20;
    /// Brackets inside brackets.
    pub const NESTING: usize = 100;
    /// Operators in one expression outside of brackets.
    pub const CHAIN: usize = 2_000;
    /// Expressions inside expressions, through all calls.
    pub const DEPTH: usize = 250_000;
    /// Function calls inside function calls.
    pub const CALLS: usize = 64;
    /// Expressions evaluated and items made.
    pub const STEPS: usize = 20_000_000;
    /// Items of a list, a tuple or a range.
    pub const ITEMS: usize = 1_000_000;
    /// Nodes of formulas and solids made.
    pub const NODES: usize = 2_000_000;
    /// Characters of a string.
    pub const TEXT: usize = 10_000;
}

/// Stack of the thread that parses and evaluates: enough for the deepest tree the limits let through.
const STACK: usize = 768 << 20;

/// What the part file says about meshing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshDefaults {
    /// The cell size.
    pub size: Option<SizeRequest>,
    /// Curvature makes no edges shorter than this.
    pub least: Option<SizeRequest>,
    /// The operators that make the mesh, as text, and where the file says so.
    pub sequence: Option<(String, Place)>,
}

/// A named set of faces.
#[derive(Debug, Clone, PartialEq)]
pub struct PartGroup {
    /// The group's name.
    pub name: String,
    /// Patterns of face names, see [`glob`].
    pub patterns: Vec<String>,
    /// Where the part file says so.
    pub place: Place,
}

/// A part: a solid with everything needed to mesh it.
#[derive(Debug, Clone)]
pub struct Part {
    /// The solid of R-functions, where there is one.
    pub solid: Option<Solid>,
    /// Solids and sheets to be built from edges, which stand apart from it.
    pub built: Vec<recipe::Recipe>,
    /// Whether the solid of R-functions is a figure of the plane z = 0, which goes on along z without end.
    pub plane: bool,
    /// The system of R-functions.
    pub rsystem: RSystem,
    /// Where to cut the solid off.
    pub domain: Option<Aabb>,
    /// The unit of length.
    pub units: Option<String>,
    /// Named sets of faces.
    pub groups: Vec<PartGroup>,
    /// Wishes for the mesh.
    pub mesh: MeshDefaults,
    /// Where relative paths of files start: the part file's folder. Empty for the working directory.
    pub folder: PathBuf,
    /// Where a part file makes which solid; `None` for what comes from elsewhere.
    pub(crate) origins: Option<Arc<origins::Origins>>,
}

impl Part {
    /// A part with nothing said but the solid.
    pub fn from_solid(solid: Solid) -> Self {
        Part { solid: Some(solid), ..Part::from_built(Vec::new()) }
    }

    /// A part with nothing said but what it builds from edges.
    pub fn from_built(built: Vec<recipe::Recipe>) -> Self {
        Part {
            solid: None,
            built,
            plane: false,
            rsystem: RSystem::default(),
            domain: None,
            units: None,
            groups: Vec::new(),
            mesh: MeshDefaults::default(),
            folder: PathBuf::new(),
            origins: None,
        }
    }
}

/// Reads a part file's text. `overrides` replace the values of numbers assigned at top level.
///
/// Errors: [`Error::Input`] with line and column for anything wrong in the text; [`Error::Usage`] for an override of a
/// name that is not a top-level number, or by a number that is not finite. The last override of a name wins.
pub fn parse(source: &str, overrides: &[(String, f64)]) -> Result<Part> {
    if let Some((name, v)) = overrides.iter().find(|(_, v)| !v.is_finite()) {
        return Err(Error::Usage(format!("-D {name}: the number must be finite, not {v}")));
    }
    guard::check(source)?;
    // deep but legal expressions recurse in the parser and when its tree is dropped
    std::thread::scope(|scope| {
        let worker =
            std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || interpreter::run(source, overrides));
        match worker.map(|w| w.join()) {
            Ok(Ok(result)) => result,
            Ok(Err(_)) => Err(Error::input(Place::Unknown, "the part file could not be read: the reader failed")),
            Err(e) => Err(Error::Failed(format!("cannot start a thread to read the part file: {e}"))),
        }
    })
}

/// Whether a face name fits a pattern: `*` stands for any characters, `?` for one.
pub fn glob(pattern: &str, name: &str) -> bool {
    let (p, n): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut i, mut j) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while j < n.len() {
        if i < p.len() && p[i] == '*' {
            star = Some((i, j));
            i += 1;
        } else if i < p.len() && (p[i] == '?' || p[i] == n[j]) {
            i += 1;
            j += 1;
        } else if let Some((si, sj)) = star {
            star = Some((si, sj + 1));
            i = si + 1;
            j = sj + 1;
        } else {
            return false;
        }
    }
    p[i..].iter().all(|c| *c == '*')
}

/// The place of a byte range of a text.
fn place(source: &str, start: usize, end: usize) -> Place {
    let start = start.min(source.len());
    let before = &source.as_bytes()[..start];
    let line = 1 + before.iter().filter(|b| **b == b'\n').count();
    let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let column = 1 + String::from_utf8_lossy(&before[line_start..]).chars().count();
    Place::Text { line, column, offset: start, len: end.saturating_sub(start) }
}
