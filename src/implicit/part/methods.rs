//! Methods of solids: placement, names, sizes.

use glam::{DMat3, DVec3};
use ruff_python_ast::Identifier;
use ruff_text_size::TextRange;

use super::super::solid::{Placement, Solid};
use super::arguments::{Argument, Bound};
use super::edges;
use super::figures;
use super::interpreter::Interpreter;
use super::value::Value;
use crate::error::Result;

/// All methods.
pub(super) const NAMES: [&str; 7] = ["move", "rotate", "scale", "mirror", "name", "size", "without"];

pub(super) fn call<'a>(
    it: &Interpreter<'a>,
    range: TextRange,
    object: Value<'a>,
    method: &Identifier,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    let (name, name_range) = (method.as_str(), method.range);
    let Some(method) = NAMES.iter().find(|n| **n == name) else {
        return Err(it
            .error(name_range, format!("there is no method {name:?}"))
            .with_help(format!("methods of solids: {}", NAMES.join(", "))));
    };
    let of_edges = matches!(object, Value::Edges(_) | Value::Built(_));
    if *method == "without" && !of_edges {
        return Err(it.error(name_range, ".without() is for what is built from edges: it leaves faces out"));
    }
    if let Some(s) = figures::figure(&object)
        && !(of_edges && matches!(*method, "move" | "rotate" | "scale" | "without"))
    {
        return figures::method(it, range, s, method, arguments);
    }
    if of_edges {
        return edges::method(it, range, &object, method, arguments);
    }
    let Some(s) = object.solid() else {
        return Err(it.error(name_range, format!(".{name}() is a method of solids, not of {}", object.kind())));
    };
    Ok(Value::Solid(placed(it, range, s, method, arguments)?))
}

/// A solid after one of these methods.
pub(super) fn placed<'a>(
    it: &Interpreter<'a>,
    range: TextRange,
    s: Solid,
    method: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Solid> {
    it.grow(range, 1)?;
    let bind = |names| Bound::new(it, method, names, arguments, range);
    let about = |rotation: DMat3, at: DVec3| Placement { rotation, scale: 1.0, shift: at - rotation * at };
    Ok(match method {
        "move" => {
            let b = bind(&["by"])?;
            s.placed(Placement { shift: b.vector(it, "by")?, ..Placement::IDENTITY })
        }
        "rotate" => {
            let b = bind(&["degrees", "axis", "at"])?;
            let axis = b.axis(it, "axis")?;
            s.placed(about(rotation(axis, b.number(it, "degrees")?), b.point(it, "at")?))
        }
        "scale" => {
            let b = bind(&["k"])?;
            s.placed(Placement { scale: b.positive(it, "k")?, ..Placement::IDENTITY })
        }
        "mirror" => {
            let b = bind(&["axis", "at"])?;
            b.need(it, "axis")?;
            let n = b.axis(it, "axis")?.normalize();
            let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            s.placed(about(DMat3::IDENTITY - outer * 2.0, b.point(it, "at")?))
        }
        "name" => s.name(&name_of(it, bind(&["name"])?)?),
        _ => {
            let b = bind(&["h"])?;
            s.size(b.positive(it, "h")?)
        }
    })
}

/// The name a call of `.name()` gives.
pub(super) fn name_of<'a>(it: &Interpreter<'a>, b: Bound<'a>) -> Result<String> {
    let text = b.text(it, "name")?;
    if text.is_empty() || text.chars().any(char::is_control) {
        return Err(it.error(b.range, "a name needs at least one character, and no control characters"));
    }
    Ok(text)
}

/// The rotation about an axis; quarter turns about the coordinate axes are exact.
pub(super) fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    let turn = degrees.rem_euclid(360.0);
    let (s, c) = match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        t => t.to_radians().sin_cos(),
    };
    let a = axis.normalize();
    let k = 1.0 - c;
    DMat3::from_cols(
        DVec3::new(a.x * a.x * k + c, a.y * a.x * k + a.z * s, a.z * a.x * k - a.y * s),
        DVec3::new(a.x * a.y * k - a.z * s, a.y * a.y * k + c, a.z * a.y * k + a.x * s),
        DVec3::new(a.x * a.z * k + a.y * s, a.y * a.z * k - a.x * s, a.z * a.z * k + c),
    )
}
