//! What crosses the border: text and arrays in, places for results, lists of text out.

use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::path::PathBuf;

use rvachev::DVec3;

use crate::errors::{Failure, usage};

/// A place for a result, which may be NULL and need not hold anything yet.
pub type Out<'a, T> = Option<&'a mut MaybeUninit<T>>;

/// A text of the caller's, ended by a zero, which may be NULL.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Chars(*const c_char);

impl Chars {
    /// Whether it is NULL.
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }

    /// The text.
    ///
    /// Errors: usage, for NULL and for what is not UTF-8.
    pub fn text<'a>(self, name: &str) -> Result<&'a str, Failure> {
        if self.0.is_null() {
            return Err(usage(format!("{name} is NULL")));
        }
        // SAFETY: not NULL; the header asks for a text ended by a zero, which is not changed while the call lasts.
        let text = unsafe { CStr::from_ptr(self.0) };
        text.to_str().map_err(|_| usage(format!("{name} is not UTF-8: {}", text.to_string_lossy())))
    }

    /// A path: on Unix any bytes, elsewhere UTF-8.
    pub fn path(self, name: &str) -> Result<PathBuf, Failure> {
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt;
            if !self.0.is_null() {
                // SAFETY: as in `text`.
                let bytes = unsafe { CStr::from_ptr(self.0) }.to_bytes();
                return Ok(PathBuf::from(std::ffi::OsStr::from_bytes(bytes)));
            }
        }
        Ok(PathBuf::from(self.text(name)?))
    }
}

/// An array of the caller's, which may be NULL where it has no items.
#[repr(transparent)]
pub struct Items<T>(*const T);

impl<T> Items<T> {
    /// Whether it is NULL.
    pub fn is_null(&self) -> bool {
        self.0.is_null()
    }

    /// The array.
    ///
    /// Errors: usage, for NULL with items, and for more items than memory can hold.
    pub fn slice<'a>(&self, n: usize, name: &str) -> Result<&'a [T], Failure> {
        if n == 0 {
            return Ok(&[]);
        }
        if self.0.is_null() {
            return Err(usage(format!("{name} is NULL, but {n} items are announced")));
        }
        if n.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
            return Err(usage(format!("{name} cannot have {n} items")));
        }
        if !self.0.is_aligned() {
            return Err(usage(format!("{name} is not aligned as its items are")));
        }
        // SAFETY: not NULL, aligned, of a possible length; the header asks for that many items, not changed while the call lasts.
        Ok(unsafe { std::slice::from_raw_parts(self.0, n) })
    }

    /// The array, or nothing for NULL.
    pub fn optional<'a>(&self, n: usize, name: &str) -> Result<Option<&'a [T]>, Failure> {
        if self.0.is_null() { Ok(None) } else { self.slice(n, name).map(Some) }
    }
}

/// An array the caller lends for results, which may be NULL.
#[repr(transparent)]
pub struct Room<T>(*mut T);

impl<T: Copy> Room<T> {
    /// Errors: usage, for NULL where there are results to come.
    pub fn needed(&self, n: usize, name: &str) -> Result<(), Failure> {
        if n > 0 && self.0.is_null() {
            return Err(usage(format!("{name} is NULL: there is nowhere to put the results")));
        }
        Ok(())
    }

    /// Copies results into it; does nothing where there is no room.
    pub fn fill(&self, from: &[T]) {
        if !self.0.is_null() {
            // SAFETY: not NULL; the header asks for room for that many items.
            unsafe { std::ptr::copy(from.as_ptr(), self.0, from.len()) };
        }
    }
}

/// Points as numbers, three for each.
pub fn flat(points: &[DVec3]) -> &[f64] {
    const { assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>()) };
    // SAFETY: a DVec3 is three f64 in order without padding (repr(C)), as long and aligned as asserted above.
    unsafe { std::slice::from_raw_parts(points.as_ptr().cast(), 3 * points.len()) }
}

/// A text for the caller. A zero inside would end it: the replacement character stands in.
pub fn c_string(s: &str) -> CString {
    CString::new(s).or_else(|_| CString::new(s.replace('\0', "\u{fffd}"))).unwrap_or_default()
}

/// A finite number.
pub fn finite(x: f64, name: &str) -> Result<f64, Failure> {
    if x.is_finite() { Ok(x) } else { Err(crate::errors::input(format!("{name} must be finite, not {x}"), "")) }
}

/// A point, from three numbers.
pub fn point(p: &Items<f64>, name: &str) -> Result<DVec3, Failure> {
    let v = DVec3::from_slice(p.slice(3, name)?);
    v.to_array().iter().try_for_each(|x| finite(*x, name).map(|_| ()))?;
    Ok(v)
}
