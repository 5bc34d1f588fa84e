//! Values of Python as text of a part file: primitives, placements and edges are checked and made by the reader of part files,
//! so names, arguments and errors are the same in both.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString, PyTuple};
use rvachev::implicit::part::{Part, parse};
use rvachev::{Error, Place};

use crate::edges::{Built, Edges};
use crate::errors::raise;

/// Lists inside lists, at most.
const DEEPEST: usize = 6;

/// A value as a part file says it.
pub fn literal(v: &Bound<'_, PyAny>) -> PyResult<String> {
    let mut text = String::new();
    write(v, 0, &mut text)?;
    Ok(text)
}

fn write(v: &Bound<'_, PyAny>, depth: usize, out: &mut String) -> PyResult<()> {
    let wrong = || {
        let kind = v.get_type().name().map_or_else(|_| "this".into(), |n| n.to_string());
        PyTypeError::new_err(format!("numbers, strings, tuples and lists of them are understood here, not {kind}"))
    };
    if v.is_none() {
        out.push_str("None");
    } else if let Ok(b) = v.cast::<PyBool>() {
        out.push_str(if b.is_true() { "True" } else { "False" });
    } else if let Ok(s) = v.cast::<PyString>() {
        out.push_str(&quoted(s.to_str()?));
    } else if let Ok(e) = v.cast::<Edges>() {
        out.push_str(&e.get().text);
    } else if let Ok(b) = v.cast::<Built>() {
        out.push_str(&b.get().text);
    } else if let Ok(x) = v.extract::<f64>() {
        if !x.is_finite() {
            return Err(PyValueError::new_err(format!("numbers must be finite, not {x}")));
        }
        // Whole numbers of Python and numpy stay whole.
        let whole = x.abs() < 9e15 && v.call_method0("__index__").is_ok();
        out.push_str(&if whole { format!("{}", x as i64) } else { format!("{x:?}") });
    } else if depth < DEEPEST && v.hasattr("__iter__")? && !v.is_instance_of::<PyDict>() {
        out.push('[');
        for item in v.try_iter()? {
            write(&item?, depth + 1, out)?;
            out.push(',');
        }
        out.push(']');
    } else {
        return Err(wrong());
    }
    Ok(())
}

/// A string in quotes.
pub fn quoted(s: &str) -> String {
    let mut out = String::from("\"");
    for c in s.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A call as a part file says it; arguments that are `None` are left out.
pub fn call(name: &str, args: &Bound<'_, PyTuple>, kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
    let mut parts = args.iter().map(|a| literal(&a)).collect::<PyResult<Vec<String>>>()?;
    for (k, v) in kwargs.into_iter().flat_map(|k| k.iter()).filter(|(_, v)| !v.is_none()) {
        parts.push(format!("{}={}", k.extract::<String>()?, literal(&v)?));
    }
    Ok(format!("{name}({})", parts.join(", ")))
}

/// Reads the text of a part file made here: its lines and columns mean nothing to the caller.
pub fn read(py: Python<'_>, text: &str) -> PyResult<Part> {
    parse(text, &[]).map_err(|e| {
        let e = match e {
            Error::Input { file, message, help, .. } => Error::Input { file, place: Place::Unknown, message, help },
            other => other,
        };
        raise(py, &e)
    })
}
