//! The library's errors as exceptions of `rvachev._errors`.

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rvachev::{Error, Place};

fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("rvachev._errors")?.getattr(name)
}

fn exception(py: Python<'_>, e: &Error) -> PyResult<PyErr> {
    let text = e.to_string();
    let about = PyDict::new(py);
    let name = match e {
        Error::Cancelled => "Cancelled",
        Error::Failed(_) => "Failed",
        Error::Usage(_) => "InputError",
        Error::Input { file, place, help, .. } => {
            about.set_item("file", file.as_ref().map(|f| f.display().to_string()))?;
            about.set_item("help", help)?;
            match place {
                Place::Text { line, column, .. } => {
                    about.set_item("line", line)?;
                    about.set_item("column", column)?;
                }
                Place::Line(line) => about.set_item("line", line)?,
                Place::Point(p) => about.set_item("point", (p.x, p.y, p.z))?,
                Place::Unknown | Place::Byte(_) | Place::Item(_) | Place::Solid(_) => {}
            }
            "InputError"
        }
        Error::Io { path, action, .. } => {
            if *action == "read" {
                about.set_item("file", path.display().to_string())?;
                "InputError"
            } else {
                "Failed"
            }
        }
    };
    Ok(PyErr::from_value(class(py, name)?.call((text,), Some(&about))?))
}

/// An error of the library as an exception.
pub fn raise(py: Python<'_>, e: &Error) -> PyErr {
    exception(py, e).unwrap_or_else(|other| other)
}

/// What a signal or a listener raised: Ctrl-C is a cancelled run, which is a `KeyboardInterrupt` too; the rest comes as it was.
pub fn stopped(py: Python<'_>, e: PyErr) -> PyErr {
    if !e.is_instance_of::<PyKeyboardInterrupt>(py) {
        return e;
    }
    let cancelled = raise(py, &Error::Cancelled);
    cancelled.set_cause(py, Some(e));
    cancelled
}

/// An [`Error::Input`] that names no place, with what would be right.
pub fn input(message: impl Into<String>, help: &str) -> Error {
    let e = Error::input(Place::Unknown, message);
    if help.is_empty() { e } else { e.with_help(help) }
}

/// Tells of something worth knowing: a warning of a category of `rvachev._errors`, shown where the caller called.
pub fn warn(py: Python<'_>, category: &str, text: &str) -> PyResult<()> {
    py.import("warnings")?.call_method1("warn", (text, class(py, category)?))?;
    Ok(())
}
