//! Texts the library makes for the caller, as handles; and texts of part files made here.

use std::ffi::{CString, c_char, c_int};
use std::ptr::null;

use rvachev::Error;
use rvachev::implicit::part::{Part, parse};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, release, slot};
use crate::pass::{Out, c_string};

/// A text, such as a report as JSON.
pub struct RvText(CString);

/// A value of the library as JSON.
pub fn json(value: &impl serde::Serialize) -> Result<CString, Failure> {
    let text = serde_json::to_string(value).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))?;
    Ok(c_string(&text))
}

/// A text as a handle for the caller.
pub fn text(s: CString) -> *mut RvText {
    Box::into_raw(Box::new(RvText(s)))
}

/// A string in quotes, as part files have it.
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

/// Reads a part file made around a text of the caller's, which stands on lines of its own after the first: places in it come out
/// as the caller counts them.
pub fn read_within(before: &str, text: &str, after: &str) -> Result<Part, Failure> {
    parse(&format!("{before}\n{text}\n{after}"), &[]).map_err(|e| own_place(e, text.lines().count()).into())
}

fn own_place(e: Error, lines: usize) -> Error {
    use rvachev::Place::{Text, Unknown};
    let Error::Input { file, place, message, help } = e else { return e };
    let place = match place {
        Text { line, column, offset, len } if (2..=lines + 1).contains(&line) => {
            Text { line: line - 1, column, offset, len }
        }
        Text { .. } => Unknown,
        other => other,
    };
    Error::Input { file, place, message, help }
}

/// The text, ended by a zero; it lives as long as the handle.
#[unsafe(no_mangle)]
pub extern "C" fn rv_text_chars(text: Option<&RvText>, chars: Out<'_, *const c_char>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(chars, null(), "chars")?;
        out.write(given(text, "text")?.0.as_ptr());
        Ok(GOOD)
    })
}

/// Frees a text.
#[unsafe(no_mangle)]
pub extern "C" fn rv_text_free(text: Option<Box<RvText>>) {
    release(text);
}

/// The version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn rv_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
