//! Sequences of operators as text: a small grammar, and the sequences the methods are made of.

use std::fmt;
use std::str::FromStr;

use super::operator::Operator;
use crate::error::{Error, Place, Result};

/// The most operators a sequence may have once its repeats are written out: each is a pass over the mesh.
pub const MOST_OPERATORS: usize = 10_000;
/// The deepest that parentheses may stand in each other: reading them takes stack.
pub const DEEPEST: usize = 32;

/// A sequence of operators: names, repeats and groups.
///
/// The grammar is `sequence = step*`, `step = (NAME | "(" sequence ")") ["*" COUNT]`; blanks, line ends and commas part
/// steps, `#` begins a comment that ends with the line. Names are those of [`Operator::name`], upper and lower case
/// as there.
///
/// `Display` writes what `FromStr` reads, with comments and line ends gone.
///
/// ```
/// use rvachev::optimize::{Operator, Sequence};
/// let sequence: Sequence = "R_all*2 (N N1)*3 classify".parse()?;
/// assert_eq!(sequence.operators().len(), 9);
/// assert_eq!(sequence.to_string(), "R_all*2 (N N1)*3 classify");
/// # Ok::<(), rvachev::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sequence {
    steps: Vec<SequenceStep>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct SequenceStep {
    what: What,
    count: usize,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum What {
    One(Operator),
    Group(Vec<SequenceStep>),
}

impl SequenceStep {
    /// How many operators it stands for.
    fn len(&self) -> usize {
        let once = match &self.what {
            What::One(_) => 1,
            What::Group(steps) => total(steps),
        };
        once.saturating_mul(self.count)
    }

    fn write_out(&self, out: &mut Vec<Operator>) {
        for _ in 0..self.count {
            match &self.what {
                What::One(operator) => out.push(*operator),
                What::Group(steps) => steps.iter().for_each(|s| s.write_out(out)),
            }
        }
    }
}

fn total(steps: &[SequenceStep]) -> usize {
    steps.iter().fold(0, |sum, s| sum.saturating_add(s.len()))
}

impl Sequence {
    /// The operators in the order they run, repeats written out.
    pub fn operators(&self) -> Vec<Operator> {
        let mut out = Vec::with_capacity(total(&self.steps));
        self.steps.iter().for_each(|s| s.write_out(&mut out));
        out
    }
}

impl FromIterator<Operator> for Sequence {
    /// One after the other; an operator that comes several times in a row is written with its count.
    fn from_iter<T: IntoIterator<Item = Operator>>(operators: T) -> Self {
        let mut steps: Vec<SequenceStep> = Vec::new();
        for operator in operators {
            match steps.last_mut() {
                Some(SequenceStep { what: What::One(last), count }) if *last == operator => *count += 1,
                _ => steps.push(SequenceStep { what: What::One(operator), count: 1 }),
            }
        }
        Self { steps }
    }
}

impl fmt::Display for Sequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_steps(f, &self.steps)
    }
}

fn write_steps(f: &mut fmt::Formatter<'_>, steps: &[SequenceStep]) -> fmt::Result {
    for (i, SequenceStep { what, count }) in steps.iter().enumerate() {
        if i > 0 {
            f.write_str(" ")?;
        }
        match what {
            What::One(operator) => f.write_str(operator.name())?,
            What::Group(steps) => {
                f.write_str("(")?;
                write_steps(f, steps)?;
                f.write_str(")")?;
            }
        }
        if *count > 1 {
            write!(f, "*{count}")?;
        }
    }
    Ok(())
}

impl FromStr for Sequence {
    type Err = Error;

    /// Errors: [`Error::Input`] at the line and column of the first mistake, with the nearest operator's name as help where a
    /// name is not known; a sequence without an operator, or with more than [`MOST_OPERATORS`].
    fn from_str(text: &str) -> Result<Self> {
        let mut reader = SequenceReader { text, at: 0 };
        let steps = reader.steps(0)?;
        if steps.is_empty() {
            return Err(reader.error(0..0, "a sequence has at least one operator").with_help(names()));
        }
        Ok(Self { steps })
    }
}

fn names() -> String {
    let names: Vec<&str> = Operator::all().map(Operator::name).collect();
    format!("there are {}", names.join(", "))
}

/// What a text has left to read.
struct SequenceReader<'a> {
    text: &'a str,
    at: usize,
}

impl SequenceReader<'_> {
    fn error(&self, range: std::ops::Range<usize>, message: impl Into<String>) -> Error {
        let before = self.text.get(..range.start).unwrap_or(self.text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or_default().chars().count();
        let place = Place::Text { line, column, offset: range.start, len: range.len() };
        Error::input(place, message)
    }

    fn rest(&self) -> &str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// What stands next, past blanks and comments.
    fn peek(&mut self) -> Option<char> {
        loop {
            let c = self.rest().chars().next()?;
            if c == '#' {
                self.at += self.rest().find('\n').unwrap_or(self.rest().len());
            } else if c.is_whitespace() || c == ',' {
                self.at += c.len_utf8();
            } else {
                return Some(c);
            }
        }
    }

    /// A run of characters that are none of the grammar's own.
    fn word(&mut self) -> (std::ops::Range<usize>, String) {
        let rest = self.rest();
        let end = rest.find(|c: char| c.is_whitespace() || "()*#,".contains(c)).unwrap_or(rest.len());
        let (range, word) = (self.at..self.at + end, rest[..end].to_string());
        self.at = range.end;
        (range, word)
    }

    /// Steps up to the end, or up to the parenthesis that closes a group.
    fn steps(&mut self, depth: usize) -> Result<Vec<SequenceStep>> {
        let mut steps = Vec::new();
        while let Some(c) = self.peek() {
            let from = self.at;
            let what = match c {
                '(' => self.group(depth)?,
                ')' if depth > 0 => break,
                ')' => return Err(self.error(from..from + 1, "no group is open here that ')' could close")),
                '*' => return Err(self.error(from..from + 1, "'*' follows what it repeats, as in N*10")),
                _ => What::One(self.operator()?),
            };
            let count = self.count()?;
            steps.push(SequenceStep { what, count });
            if total(&steps) > MOST_OPERATORS {
                let what = format!("a sequence has at most {MOST_OPERATORS} operators, repeats written out");
                return Err(self.error(from..self.at, what));
            }
        }
        Ok(steps)
    }

    fn group(&mut self, depth: usize) -> Result<What> {
        let from = self.at;
        if depth == DEEPEST {
            return Err(self.error(from..from + 1, format!("groups stand at most {DEEPEST} deep in each other")));
        }
        self.at += 1;
        let steps = self.steps(depth + 1)?;
        if self.peek() != Some(')') {
            return Err(self.error(from..from + 1, "this group is not closed: ')' is missing"));
        }
        self.at += 1;
        if steps.is_empty() {
            return Err(self.error(from..self.at, "a group has at least one operator").with_help(names()));
        }
        Ok(What::Group(steps))
    }

    fn operator(&mut self) -> Result<Operator> {
        let (range, word) = self.word();
        Operator::all().find(|o| o.name() == word).ok_or_else(|| {
            let e = self.error(range, format!("no operator is called {word:?}"));
            match Operator::nearest(&word) {
                Some(near) => e.with_help(format!("the nearest name is {:?}; {}", near.name(), names())),
                None => e.with_help(names()),
            }
        })
    }

    /// How often what was just read is repeated.
    fn count(&mut self) -> Result<usize> {
        if self.peek() != Some('*') {
            return Ok(1);
        }
        let star = self.at;
        self.at += 1;
        self.peek();
        let (range, word) = self.word();
        let range = if range.is_empty() { star..star + 1 } else { range };
        let count = word.parse().ok().filter(|n| (1..=MOST_OPERATORS).contains(n));
        let what = || format!("'*' is followed by a whole number from 1 to {MOST_OPERATORS}, not by {word:?}");
        count.ok_or_else(|| self.error(range, what()))
    }
}
