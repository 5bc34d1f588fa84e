//! Lines, numbers and names of text formats.

use std::borrow::Cow;

use glam::DVec3;

use crate::error::{Error, Place, Result};

/// Lines of a text ended by LF, CR LF or a lone CR, numbered from 1.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `bytes`.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), number: 0 }
    }

    /// The number of the line last returned.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// The bytes after the line last returned.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Goes on at `rest`, a tail of the same text, from which `lines` lines were taken by other means.
    pub(super) fn resume(&mut self, rest: &'a [u8], lines: usize) {
        self.rest = rest;
        self.number += lines;
    }

    /// The next line, without its end. Bytes that are not UTF-8 become replacement characters.
    pub(super) fn next_line(&mut self) -> Option<(usize, Cow<'a, str>)> {
        if self.rest.is_empty() {
            return None;
        }
        let bytes = self.rest;
        let end = bytes.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(bytes.len());
        let skip = match &bytes[end..] {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        self.rest = &bytes[end + skip..];
        self.number += 1;
        Some((self.number, String::from_utf8_lossy(&bytes[..end])))
    }

    /// The next line that is not blank.
    pub(super) fn next_filled(&mut self) -> Option<(usize, Cow<'a, str>)> {
        loop {
            let (number, line) = self.next_line()?;
            if !line.trim().is_empty() {
                return Some((number, line));
            }
        }
    }

    /// The next line that is not blank, or an error telling that the text ended where `what` should stand.
    pub(super) fn expect(&mut self, what: &str) -> Result<(usize, Cow<'a, str>)> {
        self.next_filled().ok_or_else(|| ended(self.number, what))
    }
}

/// The text ended where `what` should have followed.
pub(super) fn ended(line: usize, what: &str) -> Error {
    Error::input(Place::Line(line), format!("the file ends here, where {what} should follow"))
}

/// An error at a line.
pub(super) fn at(line: usize, message: impl Into<String>) -> Error {
    Error::input(Place::Line(line), message)
}

/// A piece of foreign text, short and printable enough to show in a message.
pub(super) fn quote(word: &str) -> String {
    /// Characters that are shown: half a line.
    const SHOWN: usize = 40;
    let mut shown: String = word.chars().take(SHOWN).flat_map(char::escape_debug).collect();
    if word.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    format!("`{shown}`")
}

/// The next word as a number; any `f64`, also one that is not finite.
pub(super) fn float<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize, what: &str) -> Result<f64> {
    let word = words.next().ok_or_else(|| at(line, format!("{what} is missing")))?;
    word.parse().map_err(|_| at(line, format!("{what} is {}, not a number", quote(word))))
}

/// The next word as a non-negative integer.
pub(super) fn count<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize, what: &str) -> Result<usize> {
    let word = words.next().ok_or_else(|| at(line, format!("{what} is missing")))?;
    word.parse().map_err(|_| at(line, format!("{what} is {}, not a whole number ≥ 0", quote(word))))
}

/// The next three words as a point with finite coordinates.
pub(super) fn point<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize) -> Result<DVec3> {
    let mut p = DVec3::ZERO;
    for (axis, what) in ["x coordinate", "y coordinate", "z coordinate"].into_iter().enumerate() {
        p[axis] = float(words, line, what)?;
        if !p[axis].is_finite() {
            return Err(at(line, format!("{what} is {}, not a finite number", p[axis])));
        }
    }
    Ok(p)
}

/// A name as one line of text without quotation marks; [`unescape`] gives it back.
pub(super) fn escape(name: &str) -> Cow<'_, str> {
    if name.is_empty() {
        return "%".into();
    }
    let first = 0;
    let last = name.char_indices().next_back().map_or(0, |(i, _)| i);
    let must = |i: usize, c: char| {
        c.is_control() || matches!(c, '%' | '"') || ((i == first || i == last) && c.is_whitespace())
    };
    if !name.char_indices().any(|(i, c)| must(i, c)) {
        return name.into();
    }
    let mut text = String::with_capacity(name.len() + 8);
    for (i, c) in name.char_indices() {
        if must(i, c) {
            let mut bytes = [0; 4];
            for byte in c.encode_utf8(&mut bytes).bytes() {
                text.push_str(&format!("%{byte:02X}"));
            }
        } else {
            text.push(c);
        }
    }
    text.into()
}

/// Undoes [`escape`]. A `%` that is not followed by two hexadecimal digits stands for itself, as in files of others.
pub(super) fn unescape(text: &str) -> String {
    if text == "%" {
        return String::new();
    }
    let bytes = text.as_bytes();
    let mut name = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let hex = bytes.get(i + 1..i + 3).filter(|h| bytes[i] == b'%' && h.iter().all(u8::is_ascii_hexdigit));
        match hex.and_then(|h| std::str::from_utf8(h).ok()).and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) => {
                name.push(byte);
                i += 3;
            }
            None => {
                name.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8(name).unwrap_or_else(|_| text.to_owned())
}
