//! Errors: status codes, and a handle with the message, the help and the place.

use std::ffi::{CString, c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null;

use rvachev::{Error, Place};

use crate::pass::{Out, c_string};

/// Good.
pub const GOOD: c_int = 0;
/// Made, but it falls short of what was asked.
pub const SHORT: c_int = 1;
/// A field's function stopped the run.
pub const STOPPED: c_int = 5;

/// Why a call came to nothing.
pub enum Failure {
    /// The library says so.
    Library(Error),
    /// A field's function returned this code; its `user` pointer, as a number.
    Stopped {
        /// What it returned.
        code: c_int,
        /// Whose function it was.
        user: usize,
    },
}

impl From<Error> for Failure {
    fn from(e: Error) -> Self {
        Failure::Library(e)
    }
}

/// A request that makes no sense.
pub fn usage(message: impl Into<String>) -> Failure {
    Error::Usage(message.into()).into()
}

/// An input that cannot be used, with what would be right.
pub fn input(message: impl Into<String>, help: &str) -> Failure {
    let e = Error::input(Place::Unknown, message);
    if help.is_empty() { e.into() } else { e.with_help(help).into() }
}

/// What is known of a failure.
pub struct RvError {
    status: c_int,
    message: CString,
    help: Option<CString>,
    file: Option<CString>,
    line: usize,
    column: usize,
    user_code: c_int,
    user: usize,
}

impl RvError {
    fn new(failure: &Failure) -> Self {
        let plain = |status: c_int, message: &str| RvError {
            status,
            message: c_string(message),
            help: None,
            file: None,
            line: 0,
            column: 0,
            user_code: 0,
            user: 0,
        };
        match failure {
            Failure::Stopped { code, user } => {
                let message = format!("a field's function stopped the run with code {code}");
                RvError { user_code: *code, user: *user, ..plain(STOPPED, &message) }
            }
            Failure::Library(e) => {
                let mut made = plain(e.exit_code().into(), &e.to_string());
                match e {
                    Error::Input { file, place, help, .. } => {
                        made.file = file.as_ref().map(|f| c_string(&f.display().to_string()));
                        made.help = help.as_ref().map(|h| c_string(h));
                        (made.line, made.column) = match place {
                            Place::Text { line, column, .. } => (*line, *column),
                            Place::Line(line) => (*line, 0),
                            _ => (0, 0),
                        };
                    }
                    Error::Io { path, .. } => made.file = Some(c_string(&path.display().to_string())),
                    _ => {}
                }
                made
            }
        }
    }
}

/// Where a call tells of its failure.
pub type ErrorOut<'a> = Out<'a, *mut RvError>;

/// What every call goes through: no panic leaves it, and its failure is told.
pub fn entry(error: ErrorOut<'_>, body: impl FnOnce() -> Result<c_int, Failure>) -> c_int {
    let done = catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<&str>().map(|s| s.to_string());
        let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Err(Error::Failed(format!("the library failed where it should not, please report this: {said}")).into())
    });
    let (status, told) = match done {
        Ok(status) => (status, std::ptr::null_mut()),
        Err(failure) => {
            let told = RvError::new(&failure);
            (told.status, if error.is_some() { Box::into_raw(Box::new(told)) } else { std::ptr::null_mut() })
        }
    };
    if let Some(slot) = error {
        slot.write(told);
    }
    status
}

/// Frees a handle; nothing for NULL.
pub fn release<T>(handle: Option<Box<T>>) {
    // What a field's owner does on release is not ours to trust.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

/// Writes an empty value first, so that no call leaves an output as it found it; then gives the place.
pub fn slot<'a, T: Copy>(out: Out<'a, T>, empty: T, name: &str) -> Result<&'a mut MaybeUninit<T>, Failure> {
    match out {
        Some(slot) => {
            slot.write(empty);
            Ok(slot)
        }
        None => Err(usage(format!("{name} is NULL: there is nowhere to put the result"))),
    }
}

/// A handle that must be there.
pub fn given<'a, T>(handle: Option<&'a T>, name: &str) -> Result<&'a T, Failure> {
    handle.ok_or_else(|| usage(format!("{name} is NULL")))
}

fn chars(s: Option<&CString>) -> *const c_char {
    s.map_or(null(), |s| s.as_ptr())
}

/// The status the failed call returned; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_status(error: Option<&RvError>) -> c_int {
    error.map_or(GOOD, |e| e.status)
}

/// What went wrong, in one sentence; "" for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_message(error: Option<&RvError>) -> *const c_char {
    error.map_or(c"".as_ptr(), |e| e.message.as_ptr())
}

/// What would be right, where that is known, or NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_help(error: Option<&RvError>) -> *const c_char {
    chars(error.and_then(|e| e.help.as_ref()))
}

/// The file, where there is one, or NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_file(error: Option<&RvError>) -> *const c_char {
    chars(error.and_then(|e| e.file.as_ref()))
}

/// The line, from 1; 0 where none is known.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_line(error: Option<&RvError>) -> usize {
    error.map_or(0, |e| e.line)
}

/// The column in characters, from 1; 0 where none is known.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_column(error: Option<&RvError>) -> usize {
    error.map_or(0, |e| e.column)
}

/// What the field's function returned that stopped the run; 0 where none did.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_user_code(error: Option<&RvError>) -> c_int {
    error.map_or(0, |e| e.user_code)
}

/// The `user` pointer of the field whose function stopped the run, or NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_user(error: Option<&RvError>) -> *mut c_void {
    error.map_or(std::ptr::null_mut(), |e| e.user as *mut c_void)
}

/// Frees an error.
#[unsafe(no_mangle)]
pub extern "C" fn rv_error_free(error: Option<Box<RvError>>) {
    release(error);
}
