//! Solids given by their boundaries: meshes and STEP models from files, and what is built from edges, as operands.

use std::path::PathBuf;
use std::sync::Arc;

use ruff_text_size::TextRange;

use super::super::solid::{Boundary, Foreign, Primitive, Solid};
use super::arguments::{Argument, Bound};
use super::interpreter::Interpreter;
use super::value::Value;
use crate::error::Result;
use crate::sizing::SizeRequest;

/// Whether the arguments of `mesh(...)` name a file: a text that is no size, without a keyword or as `path`. With other arguments
/// `mesh` says how the part is meshed.
pub(super) fn is_file(arguments: &[Argument<'_>]) -> bool {
    arguments.first().is_some_and(|a| match (&a.keyword, &a.value) {
        (Some(k), _) => k == "path",
        (None, Value::Str(text)) => text.parse::<SizeRequest>().is_err(),
        _ => false,
    })
}

/// `mesh(path)` and `step(path)`.
pub(super) fn file<'a>(
    it: &Interpreter<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    it.grow(range, 8)?;
    let b = Bound::new(it, name, &["path"], arguments, range)?;
    let path = b.text(it, "path")?;
    if path.is_empty() || path.contains('\0') {
        return Err(it.error(b.range, format!("{name}() needs the path of a file")));
    }
    let path = PathBuf::from(path);
    let source = if name == "step" { Boundary::Step(path) } else { Boundary::Mesh(path) };
    let foreign = Foreign { source, place: it.place(range) };
    Ok(Value::Solid(Primitive::Foreign(Arc::new(foreign)).into()))
}

/// A value as an operand of set operations: a solid, or what is built from edges.
pub(super) fn operand(v: &Value<'_>) -> Option<Solid> {
    match v {
        Value::Built(recipe) => {
            let foreign =
                Foreign { source: Boundary::Built(Box::new((**recipe).clone())), place: recipe.place.clone() };
            Some(Primitive::Foreign(Arc::new(foreign)).into())
        }
        other => other.solid(),
    }
}
