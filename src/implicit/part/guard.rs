//! Refuses texts nested so deeply that a recursive parser could run out of stack, before it sees them.

use super::{limits, place};
use crate::error::{Error, Result};

/// Brackets opened inside string literals, in the whole text: format strings hold expressions of their own.
const OPENED_IN_STRINGS: usize = 5_000;

fn too_much(source: &str, at: usize, what: &str, most: usize) -> Error {
    Error::input(place(source, at, at + 1), format!("{what}: the limit is {most}"))
}

/// Looks at brackets, operators and string literals only.
pub(super) fn check(source: &str) -> Result<()> {
    let b = source.as_bytes();
    if b.len() > limits::SOURCE_BYTES {
        return Err(too_much(source, 0, &format!("the file has {} bytes", b.len()), limits::SOURCE_BYTES));
    }
    // operators since the last comma, one count for each open bracket
    let mut counts = vec![0usize];
    let mut in_strings = 0;
    let mut i = 0;
    while i < b.len() {
        match b[i] {
            b'#' => {
                while i < b.len() && b[i] != b'\n' {
                    i += 1;
                }
                continue;
            }
            q @ (b'"' | b'\'') => {
                let triple = b[i..].starts_with(&[q, q, q]);
                let close: &[u8] = if triple { &[q, q, q] } else { std::slice::from_ref(&b[i]) };
                i += close.len();
                while i < b.len() && !b[i..].starts_with(close) {
                    if b[i] == b'\n' && !triple {
                        break;
                    }
                    if matches!(b[i], b'(' | b'[' | b'{') {
                        in_strings += 1;
                        if in_strings > OPENED_IN_STRINGS {
                            return Err(too_much(source, i, "too many brackets inside strings", OPENED_IN_STRINGS));
                        }
                    }
                    i += if b[i] == b'\\' { 2 } else { 1 };
                }
                i += close.len();
                continue;
            }
            b'(' | b'[' | b'{' => {
                bump(&mut counts, source, i)?;
                counts.push(0);
                if counts.len() > limits::NESTING + 1 {
                    return Err(too_much(source, i, "brackets are nested too deeply", limits::NESTING));
                }
            }
            b')' | b']' | b'}' if counts.len() > 1 => {
                counts.pop();
            }
            b',' | b';' => reset(&mut counts),
            b'\n' if counts.len() == 1 && !(i > 0 && b[i - 1] == b'\\') => reset(&mut counts),
            b'+' | b'-' | b'*' | b'/' | b'%' | b'|' | b'&' | b'^' | b'~' | b'<' | b'>' | b'=' | b'.' | b'@' | b':' => {
                bump(&mut counts, source, i)?;
            }
            c if c.is_ascii_alphabetic() || c == b'_' => {
                let start = i;
                while i < b.len() && (b[i].is_ascii_alphanumeric() || b[i] == b'_') {
                    i += 1;
                }
                if matches!(
                    &b[start..i],
                    b"if"
                        | b"else"
                        | b"and"
                        | b"or"
                        | b"not"
                        | b"lambda"
                        | b"await"
                        | b"in"
                        | b"is"
                        | b"for"
                        | b"yield"
                        | b"from"
                ) {
                    bump(&mut counts, source, start)?;
                }
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    Ok(())
}

fn bump(counts: &mut [usize], source: &str, at: usize) -> Result<()> {
    if let Some(c) = counts.last_mut() {
        *c += 1;
        if *c > limits::CHAIN {
            return Err(too_much(source, at, "too many operators in one expression", limits::CHAIN)
                .with_help("use union([...]), intersection([...]) or sum([...]), or give parts of it a name"));
        }
    }
    Ok(())
}

fn reset(counts: &mut [usize]) {
    if let Some(c) = counts.last_mut() {
        *c = 0;
    }
}
