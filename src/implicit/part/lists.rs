//! Lists that grow in place, and what is in them.

use std::rc::Rc;

use ruff_python_ast::{self as ast, CmpOp, Expr};
use ruff_text_size::{Ranged, TextRange};

use super::interpreter::Interpreter;
use super::limits;
use super::operators;
use super::value::Value;
use crate::error::{Error, Result};

/// Calls a method of the list that a name stands for; `None` where it is something else.
///
/// A list that has a second name would grow under both in Python. Lists are values here, so that is an error rather than another part.
pub(super) fn grown<'a>(it: &mut Interpreter<'a>, c: &'a ast::ExprCall) -> Result<Option<Value<'a>>> {
    let Expr::Attribute(a) = &*c.func else { return Ok(None) };
    let Expr::Name(list) = &*a.value else { return Ok(None) };
    let (name, range) = (list.id.as_str(), c.range());
    let Some(Value::List(known)) = it.variable(name) else { return Ok(None) };
    let length = known.len();
    let method = a.attr.as_str();
    if !matches!(method, "append" | "extend") {
        let e = it.error(a.attr.range, format!("there is no method {method:?} of lists"));
        return Err(e.with_help("methods of lists: append, extend"));
    }
    let mut arguments = it.arguments(c)?.into_iter();
    let (Some(given), None) = (arguments.next().filter(|a| a.keyword.is_none()), arguments.next()) else {
        return Err(it.error(range, format!(".{method}() takes 1 argument")));
    };
    let more = if method == "append" {
        vec![given.value]
    } else {
        let all = operators::spread(it, given.range, given.value)?;
        let no_list = || it.error(given.range, format!("a list is needed here, not {}", all.kind()));
        all.items().ok_or_else(no_list)?.to_vec()
    };
    it.charge(range, more.len())?;
    if length + more.len() > limits::ITEMS {
        it.fits(range, length + more.len())?;
    }
    let Some(Value::List(list)) = it.variable(name) else { return Ok(None) };
    match Rc::get_mut(list) {
        Some(list) => list.extend(more),
        None => return Err(shared(it, name, range)),
    }
    Ok(Some(Value::None))
}

fn shared(it: &Interpreter<'_>, name: &str, range: TextRange) -> Error {
    it.error(range, format!("the list {name} has another name, too, or a loop goes through it"))
        .with_help(format!("make a new list: {name} = {name} + [item]"))
}

/// Whether `item` is in a list, a tuple or a text, for the operators `in` and `not in`.
pub(super) fn held<'a>(
    it: &Interpreter<'a>,
    range: TextRange,
    op: CmpOp,
    item: &Value<'a>,
    all: &Value<'a>,
) -> Result<bool> {
    let is_in = match (item, all, all.items()) {
        (Value::Formula(_) | Value::Solid(_) | Value::Condition(_), ..) => {
            return Err(it.error(range, format!("{} cannot be looked for", item.kind())));
        }
        (_, _, Some(items)) => {
            it.charge(range, items.len())?;
            items.iter().any(|other| is_same(item, other))
        }
        (Value::Str(part), Value::Str(whole), _) => whole.contains(&**part),
        _ => return Err(it.error(range, format!("{} is in a list, not in {}", item.kind(), all.kind()))),
    };
    Ok(is_in == (op == CmpOp::In))
}

/// Whether values are equal, of those that can be: numbers, texts, lists of them.
fn is_same(a: &Value<'_>, b: &Value<'_>) -> bool {
    match (a, b) {
        (Value::Str(a), Value::Str(b)) => a == b,
        (Value::None, Value::None) => true,
        (Value::List(a), Value::List(b)) | (Value::Tuple(a), Value::Tuple(b)) => {
            a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| is_same(a, b))
        }
        _ => a.number().is_some() && a.number() == b.number(),
    }
}
