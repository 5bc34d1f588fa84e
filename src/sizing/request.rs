//! A size as a user asks for it.

use std::str::FromStr;

use crate::error::{Error, Result};

/// A mesh size as a user asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeRequest {
    /// A length in the part's unit.
    Length(f64),
    /// A share of the bounding box's diagonal; `0.02` is 2 %.
    Share(f64),
}

impl SizeRequest {
    /// The length for a part whose bounding box has a diagonal.
    pub fn length(self, diagonal: f64) -> f64 {
        match self {
            Self::Length(h) => h,
            Self::Share(s) => s * diagonal,
        }
    }
}

impl FromStr for SizeRequest {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self> {
        let bad = || Error::Usage(format!("a size is a positive length or a share such as 2%, not {s:?}"));
        let (number, share) = match s.trim().strip_suffix('%') {
            Some(n) => (n, true),
            None => (s, false),
        };
        let v: f64 = number.trim().parse().map_err(|_| bad())?;
        if !(v > 0.0 && v.is_finite()) {
            return Err(bad());
        }
        Ok(if share { SizeRequest::Share(v / 100.0) } else { SizeRequest::Length(v) })
    }
}
