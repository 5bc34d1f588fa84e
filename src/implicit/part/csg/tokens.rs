//! Words, numbers and marks of a `.csg` file, and the values of arguments.

use super::super::place;
use crate::error::{Error, Result};

/// Lists inside lists.
const NESTING: usize = 8;

/// A token with the range of bytes it stands in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'a> {
    pub(super) at: usize,
    pub(super) text: &'a str,
}

/// The text and how far it is read.
pub(super) struct Tokens<'a> {
    source: &'a str,
    at: usize,
}

/// What an argument may be.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Number(f64),
    Bool(bool),
    List(Vec<Value>),
    /// A string, or a word such as `undef`.
    Word,
}

/// An argument of a call.
#[derive(Debug, Clone)]
pub(super) struct Argument<'a> {
    /// Empty for one without a name.
    pub(super) name: &'a str,
    pub(super) value: Value,
    /// Where the value stands.
    pub(super) token: Token<'a>,
}

impl Token<'_> {
    /// Whether it is a word, as names of operations and arguments are.
    pub(super) fn is_word(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '$')
    }

    /// An error here.
    pub(super) fn error(&self, source: &str, what: impl Into<String>) -> Error {
        Error::input(place(source, self.at, self.at + self.text.len()), what)
    }
}

impl<'a> Tokens<'a> {
    pub(super) fn new(source: &'a str) -> Self {
        Tokens { source, at: source.len() - source.trim_start_matches('\u{feff}').len() }
    }

    /// An error at the end of what is read.
    pub(super) fn ended(&self, wanted: &str) -> Error {
        let end = self.source.trim_end().len();
        Error::input(place(self.source, end, end), format!("the file ends where {wanted} should follow"))
    }

    /// Behind blanks and comments.
    fn skip(&mut self) -> Result<()> {
        loop {
            let rest = &self.source[self.at..];
            let blank = rest.len() - rest.trim_start().len();
            let rest = &rest[blank..];
            self.at += blank;
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                let Some(end) = rest.find("*/") else {
                    return Err(Token { at: self.at, text: &rest[..2] }.error(self.source, "this comment does not end"));
                };
                self.at += end + 2;
            } else {
                return Ok(());
            }
        }
    }

    /// The next token, which is not taken; `None` at the end.
    pub(super) fn peek(&mut self) -> Result<Option<Token<'a>>> {
        self.skip()?;
        let rest = &self.source[self.at..];
        let Some(first) = rest.chars().next() else { return Ok(None) };
        let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
        let length = match first {
            '"' => match end_of_string(rest) {
                Some(end) => end,
                None => {
                    let token = Token { at: self.at, text: &rest[..1] };
                    return Err(token.error(self.source, "this string does not end"));
                }
            },
            '0'..='9' | '.' | '-' | '+' => number_length(rest),
            c if is_name(c) => rest.find(|c| !is_name(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        Ok(Some(Token { at: self.at, text: &rest[..length] }))
    }

    pub(super) fn next(&mut self, wanted: &str) -> Result<Token<'a>> {
        let token = self.peek()?.ok_or_else(|| self.ended(wanted))?;
        self.at += token.text.len();
        Ok(token)
    }

    /// Takes the mark, if it is next.
    pub(super) fn accept(&mut self, mark: &str) -> Result<bool> {
        let found = self.peek()?.is_some_and(|t| t.text == mark);
        self.at += if found { mark.len() } else { 0 };
        Ok(found)
    }

    pub(super) fn expect(&mut self, mark: &str) -> Result<()> {
        let token = self.next(&format!("{mark:?}"))?;
        if token.text == mark {
            return Ok(());
        }
        Err(token.error(self.source, format!("{mark:?} should stand here, not {:?}", token.text)))
    }

    /// What stands between the brackets of a call, both of them too.
    pub(super) fn arguments(&mut self) -> Result<Vec<Argument<'a>>> {
        self.expect("(")?;
        let mut all = Vec::new();
        while !self.accept(")")? {
            if !all.is_empty() {
                self.expect(",")?;
            }
            let token = self.next("an argument")?;
            if token.is_word() && self.accept("=")? {
                let first = self.next("a value")?;
                all.push(Argument { name: token.text, value: self.value(first, 0)?, token: first });
            } else {
                all.push(Argument { name: "", value: self.value(token, 0)?, token });
            }
        }
        Ok(all)
    }

    /// The value that begins with a token.
    fn value(&mut self, first: Token<'a>, depth: usize) -> Result<Value> {
        if first.text == "[" {
            if depth == NESTING {
                return Err(first.error(self.source, format!("lists are nested more than {NESTING} deep")));
            }
            let mut all = Vec::new();
            while !self.accept("]")? {
                if !all.is_empty() {
                    self.expect(",")?;
                }
                let next = self.next("a value")?;
                all.push(self.value(next, depth + 1)?);
            }
            return Ok(Value::List(all));
        }
        if first.text.starts_with('"') {
            return Ok(Value::Word);
        }
        Ok(match first.text {
            "true" => Value::Bool(true),
            "false" => Value::Bool(false),
            text if first.is_word() => match text {
                "undef" | "nan" | "inf" => Value::Word,
                _ => return Err(first.error(self.source, format!("{text:?} is not a value"))),
            },
            text => match text.parse::<f64>() {
                Ok(v) if v.is_finite() => Value::Number(v),
                _ => return Err(first.error(self.source, format!("{text:?} is not a finite number"))),
            },
        })
    }
}

/// How long the string literal is, with both quotes.
fn end_of_string(text: &str) -> Option<usize> {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return Some(i + 1),
            _ => {}
        }
    }
    None
}

/// How long what begins like a number is; signs belong to it at the start and behind an `e`.
fn number_length(text: &str) -> usize {
    let b = text.as_bytes();
    let belongs = |i: usize| match b[i] {
        b'+' | b'-' => i == 0 || matches!(b[i - 1], b'e' | b'E'),
        c => c.is_ascii_alphanumeric() || c == b'.',
    };
    (0..b.len()).find(|i| !belongs(*i)).unwrap_or(b.len())
}
