//! Refuses texts nested so deeply that a recursive parser could run out of stack, before it sees them.
//!
//! Strings are skipped, but for the expressions inside format strings. A text whose strings or format fields do not
//! close is refused here: what the parser makes of the rest of it is not what this count would be of.

use super::{limits, place};
use crate::error::{Error, Result};

/// Looks at brackets, operators and string literals only.
pub(super) fn check(source: &str) -> Result<()> {
    let mut g = Guard { source, b: source.as_bytes(), i: 0, counts: vec![0], modes: Vec::new(), lambdas: 0 };
    if source.len() > limits::SOURCE_BYTES {
        return Err(g.too_much(0, &format!("the file has {} bytes", source.len()), limits::SOURCE_BYTES));
    }
    while g.i < g.b.len() {
        match g.modes.last() {
            Some(Mode::Text(t)) => g.text(*t)?,
            _ => g.code()?,
        }
    }
    match g.modes.first() {
        Some(Mode::Text(t)) => Err(g.not_closed(t.start)),
        _ => Ok(()),
    }
}

/// The literal part of a format string, or the format behind the colon of one of its fields.
#[derive(Clone, Copy)]
struct Text {
    start: usize,
    quote: u8,
    triple: bool,
    format: bool,
}

enum Mode {
    Text(Text),
    /// A field in braces, with the number of brackets open when it began.
    Field(usize),
}

struct Guard<'a> {
    source: &'a str,
    b: &'a [u8],
    i: usize,
    /// Operators since the last comma, one count for each open bracket.
    counts: Vec<usize>,
    modes: Vec<Mode>,
    /// A parameter list may hold commas, so the counts say nothing about lambdas inside lambdas.
    lambdas: usize,
}

impl Guard<'_> {
    fn too_much(&self, at: usize, what: &str, most: usize) -> Error {
        Error::input(place(self.source, at, at + 1), format!("{what}: the limit is {most}"))
    }

    fn not_closed(&self, at: usize) -> Error {
        Error::input(place(self.source, at, at + 1), "syntax error: this string is not closed")
    }

    fn open(&mut self) -> Result<()> {
        self.bump(self.i)?;
        self.counts.push(0);
        if self.counts.len() > limits::NESTING + 1 {
            return Err(self.too_much(self.i, "brackets are nested too deeply", limits::NESTING));
        }
        self.i += 1;
        Ok(())
    }

    fn bump(&mut self, at: usize) -> Result<()> {
        if let Some(c) = self.counts.last_mut() {
            *c += 1;
            if *c > limits::CHAIN {
                return Err(self
                    .too_much(at, "too many operators in one expression", limits::CHAIN)
                    .with_help("use union([...]), intersection([...]) or sum([...]), or give parts of it a name"));
            }
        }
        Ok(())
    }

    fn reset(&mut self) {
        if let Some(c) = self.counts.last_mut() {
            *c = 0;
        }
    }

    fn is_newline(&self) -> bool {
        matches!(self.b[self.i], b'\n' | b'\r')
    }

    /// Behind a backslash and what it escapes; a line end of two bytes is one.
    fn skip_escape(&mut self) {
        self.i += if self.b[self.i..].starts_with(b"\\\r\n") { 3 } else { 2 };
    }

    fn closes(&self, quote: u8, triple: bool) -> bool {
        let rest = &self.b[self.i..];
        if triple { rest.starts_with(&[quote; 3]) } else { rest[0] == quote }
    }

    fn text(&mut self, t: Text) -> Result<()> {
        match self.b[self.i] {
            _ if self.closes(t.quote, t.triple) => {
                if t.format {
                    return Err(self.not_closed(t.start));
                }
                self.modes.pop();
                self.i += if t.triple { 3 } else { 1 };
            }
            b'\\' if matches!(self.b.get(self.i + 1), Some(b'{' | b'}')) => self.i += 1,
            b'\\' => self.skip_escape(),
            b'{' if !t.format && self.b.get(self.i + 1) == Some(&b'{') => self.i += 2,
            b'{' => {
                self.open()?;
                self.modes.push(Mode::Field(self.counts.len()));
            }
            b'}' if t.format => {
                self.modes.pop();
                self.end_field();
            }
            _ if self.is_newline() && !t.triple => return Err(self.not_closed(t.start)),
            _ => self.i += 1,
        }
        Ok(())
    }

    fn end_field(&mut self) {
        self.modes.pop();
        self.counts.pop();
        self.i += 1;
    }

    fn code(&mut self) -> Result<()> {
        let (b, i) = (self.b, self.i);
        let in_field = matches!(self.modes.last(), Some(Mode::Field(depth)) if *depth == self.counts.len());
        match b[i] {
            b'#' => {
                while self.i < b.len() && !self.is_newline() {
                    self.i += 1;
                }
                return Ok(());
            }
            b'\\' => {
                self.skip_escape();
                return Ok(());
            }
            b'"' | b'\'' => return self.string(false),
            b'(' | b'[' | b'{' => return self.open(),
            b'}' if in_field => {
                self.end_field();
                return Ok(());
            }
            b')' | b']' if in_field => {
                return Err(Error::input(place(self.source, i, i + 1), "syntax error: nothing opens this bracket"));
            }
            b')' | b']' | b'}' if self.counts.len() > 1 => {
                self.counts.pop();
            }
            b':' if in_field => {
                // the quotes that end the string end its formats too
                let around = self.modes.iter().rev().find_map(|m| if let Mode::Text(t) = m { Some(*t) } else { None });
                self.modes.extend(around.map(|t| Mode::Text(Text { format: true, ..t })));
            }
            b',' | b';' => self.reset(),
            b'\n' | b'\r' if self.counts.len() == 1 => self.reset(),
            b'+' | b'-' | b'*' | b'/' | b'%' | b'|' | b'&' | b'^' | b'~' | b'<' | b'>' | b'=' | b'.' | b'@' | b':' => {
                self.bump(i)?;
            }
            c if c.is_ascii_alphabetic() || c == b'_' || !c.is_ascii() => return self.word(),
            _ => {}
        }
        self.i += 1;
        Ok(())
    }

    /// A word, or the prefix of a string.
    fn word(&mut self) -> Result<()> {
        let (b, start) = (self.b, self.i);
        while self.i < b.len() && (b[self.i].is_ascii_alphanumeric() || b[self.i] == b'_' || !b[self.i].is_ascii()) {
            self.i += 1;
        }
        let word = &b[start..self.i];
        let formatted = [&b"f"[..], b"t", b"fr", b"rf", b"tr", b"rt"].iter().any(|p| word.eq_ignore_ascii_case(p));
        if formatted && matches!(b.get(self.i), Some(b'"' | b'\'')) {
            return self.string(true);
        }
        match word {
            b"lambda" => {
                self.lambdas += 1;
                if self.lambdas > limits::NESTING {
                    return Err(self.too_much(start, "too many lambda functions", limits::NESTING));
                }
                self.bump(start)
            }
            b"if" | b"else" | b"and" | b"or" | b"not" | b"await" | b"in" | b"is" | b"for" | b"yield" | b"from" => {
                self.bump(start)
            }
            _ => Ok(()),
        }
    }

    /// Skips a string, or enters a format string.
    fn string(&mut self, format: bool) -> Result<()> {
        let (start, quote) = (self.i, self.b[self.i]);
        let triple = self.b[start..].starts_with(&[quote; 3]);
        let width = if triple { 3 } else { 1 };
        self.i += width;
        if format {
            self.modes.push(Mode::Text(Text { start, quote, triple, format: false }));
            return Ok(());
        }
        while self.i < self.b.len() {
            if self.closes(quote, triple) {
                self.i += width;
                return Ok(());
            }
            match self.b[self.i] {
                b'\\' => self.skip_escape(),
                _ if self.is_newline() && !triple => break,
                _ => self.i += 1,
            }
        }
        Err(self.not_closed(start))
    }
}
