//! The syntax of STEP files (ISO 10303-21): records, their names and arguments, and the line each stands on. What the
//! records mean is for the gate that reads them.
//!
//! The reader is tolerant where files in the wild are: any bytes inside strings, blanks and line breaks anywhere, several
//! data sections. Records it cannot read are skipped to the next `;` and listed with their line.

use std::path::Path;
use std::sync::OnceLock;

use rustc_hash::FxHashMap;

use crate::error::{Error, Place, Result};
use crate::run::DEEPEST;

/// One argument of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number, whole or not.
    Number(f64),
    /// A string, decoded as far as plain text goes.
    Text(String),
    /// A word between dots, without them: `T`, `MILLI`.
    Word(String),
    /// A reference to another record, `#12`.
    Ref(u64),
    /// A list.
    List(Vec<Value>),
    /// A value with its type's name, `PARAMETER_VALUE(0.5)`.
    Typed(String, Vec<Value>),
    /// `$`: not given.
    Omitted,
    /// `*`: derived by a subtype.
    Derived,
}

/// One record: `#12 = NAME(...)`, or `#12 = (A(...) B(...))` with several parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// The number after `#`.
    pub id: u64,
    /// 1-based line the record starts on.
    pub line: usize,
    /// The record's parts: name and arguments.
    pub parts: Vec<(String, Vec<Value>)>,
}

impl Record {
    /// The arguments of the part of this name.
    pub fn part(&self, name: &str) -> Option<&[Value]> {
        self.parts.iter().find(|p| p.0 == name).map(|p| p.1.as_slice())
    }

    /// The name of a record with one part; the names of all parts, joined by `+`, of others.
    pub fn name(&self) -> String {
        self.parts.iter().map(|p| p.0.as_str()).collect::<Vec<_>>().join("+")
    }
}

/// The data of a file.
#[derive(Debug, Clone, Default)]
pub struct StepFile {
    /// The records, in the file's order.
    pub records: Vec<Record>,
    /// Lines of records that could not be read, with the reason.
    pub unreadable: Vec<(usize, String)>,
    index: FxHashMap<u64, u32>,
    /// Lines that first refer to records that are not there, found when one is asked for.
    dangling: OnceLock<FxHashMap<u64, usize>>,
}

impl StepFile {
    /// The record `#id`.
    pub fn get(&self, id: u64) -> Option<&Record> {
        self.index.get(&id).map(|i| &self.records[*i as usize])
    }

    /// The line of the first record that refers to one that is not there; 0 if none does.
    pub fn line_that_misses(&self, id: u64) -> usize {
        let find = || {
            let mut lines = FxHashMap::default();
            let mut references = Vec::new();
            for record in &self.records {
                record.parts.iter().for_each(|(_, values)| gather_references(values, &mut references));
                for missed in references.drain(..).filter(|r| !self.index.contains_key(r)) {
                    lines.entry(missed).or_insert(record.line);
                }
            }
            lines
        };
        self.dangling.get_or_init(find).get(&id).copied().unwrap_or(0)
    }

    /// All records that have a part of this name, in the file's order.
    pub fn of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Record> {
        self.records.iter().filter(move |r| r.parts.iter().any(|p| p.0 == name))
    }
}

fn gather_references(values: &[Value], into: &mut Vec<u64>) {
    for value in values {
        match value {
            Value::Ref(id) => into.push(*id),
            Value::List(inner) | Value::Typed(_, inner) => gather_references(inner, into),
            _ => {}
        }
    }
}

/// Reads a file. See [`parse_step`].
pub fn read_step(path: &Path) -> Result<StepFile> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    parse_step(&bytes).map_err(|e| e.in_file(path))
}

/// Reads the data sections of a STEP file.
///
/// *Guarantees*: no panic on any bytes; memory in proportion to the input. Of records with one number the last counts.
/// *Errors*: [`Error::Input`] when there is no data section, or no record in it that can be read.
pub fn parse_step(bytes: &[u8]) -> Result<StepFile> {
    let mut s = Scanner { bytes, at: 0, line: 1 };
    let mut file = StepFile::default();
    let mut sections = 0;
    while s.at < bytes.len() {
        s.blank();
        if s.peek() == Some(b'#') && sections > 0 {
            let (line, start) = (s.line, s.at);
            match s.record() {
                Ok(record) => {
                    file.index.insert(record.id, file.records.len() as u32);
                    file.records.push(record);
                }
                Err(what) => {
                    file.unreadable.push((line, what));
                    if s.at == start {
                        s.skip(1);
                    }
                    s.statement();
                }
            }
            continue;
        }
        if s.word() == "DATA" {
            sections += 1;
        }
        s.statement();
    }
    if sections == 0 {
        return Err(Error::input(Place::Line(1), "no DATA section: not a STEP file (ISO 10303-21)"));
    }
    if file.records.is_empty() {
        return Err(Error::input(Place::Line(1), "the DATA section has no record that can be read"));
    }
    Ok(file)
}

struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

type Parsed<T> = std::result::Result<T, String>;

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn skip(&mut self, n: usize) {
        for _ in 0..n {
            if self.peek() == Some(b'\n') {
                self.line += 1;
            }
            self.at += 1;
        }
    }

    /// Passes over blanks and comments.
    fn blank(&mut self) {
        while let Some(c) = self.peek() {
            if c.is_ascii_whitespace() || c == 0 {
                self.skip(1);
            } else if self.bytes[self.at..].starts_with(b"/*") {
                self.skip(2);
                while self.at < self.bytes.len() && !self.bytes[self.at..].starts_with(b"*/") {
                    self.skip(1);
                }
                self.skip(2.min(self.bytes.len() - self.at.min(self.bytes.len())));
            } else {
                return;
            }
        }
    }

    /// Passes over the rest of a statement, its `;` included; strings may hold more of them.
    fn statement(&mut self) {
        let mut quoted = false;
        while let Some(c) = self.peek() {
            if !quoted && self.bytes[self.at..].starts_with(b"/*") {
                self.blank();
                continue;
            }
            self.skip(1);
            match c {
                b'\'' => quoted = !quoted,
                b';' if !quoted => return,
                _ => {}
            }
        }
    }

    fn word(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_alphanumeric() || c == b'_' || c == b'-' || c == b'!') {
            self.at += 1;
        }
        String::from_utf8_lossy(&self.bytes[start..self.at]).to_ascii_uppercase()
    }

    fn expect(&mut self, c: u8) -> Parsed<()> {
        self.blank();
        if self.peek() == Some(c) {
            self.skip(1);
            Ok(())
        } else {
            Err(format!("`{}` expected", c as char))
        }
    }

    fn reference(&mut self) -> Parsed<u64> {
        self.expect(b'#')?;
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_digit()) {
            self.at += 1;
        }
        let digits = std::str::from_utf8(&self.bytes[start..self.at]).unwrap_or("");
        digits.parse().map_err(|_| "a number expected after `#`".to_string())
    }

    fn record(&mut self) -> Parsed<Record> {
        let line = self.line;
        let id = self.reference()?;
        self.expect(b'=')?;
        self.blank();
        let mut parts = Vec::new();
        if self.peek() == Some(b'(') {
            self.skip(1);
            loop {
                self.blank();
                match self.peek() {
                    Some(b')') => {
                        self.skip(1);
                        break;
                    }
                    Some(_) => parts.push(self.part()?),
                    None => return Err("the file ends inside a record".into()),
                }
            }
        } else {
            parts.push(self.part()?);
        }
        self.expect(b';')?;
        Ok(Record { id, line, parts })
    }

    fn part(&mut self) -> Parsed<(String, Vec<Value>)> {
        let name = self.word();
        if name.is_empty() {
            return Err("the name of an entity expected".into());
        }
        Ok((name, self.list(0)?))
    }

    fn list(&mut self, depth: usize) -> Parsed<Vec<Value>> {
        if depth > DEEPEST {
            return Err("lists are nested too deeply".into());
        }
        self.expect(b'(')?;
        let mut values = Vec::new();
        loop {
            self.blank();
            match self.peek() {
                Some(b')') => {
                    self.skip(1);
                    return Ok(values);
                }
                Some(b',') => self.skip(1),
                Some(_) => values.push(self.value(depth + 1)?),
                None => return Err("the file ends inside a list".into()),
            }
        }
    }

    fn value(&mut self, depth: usize) -> Parsed<Value> {
        match self.peek() {
            Some(b'#') => Ok(Value::Ref(self.reference()?)),
            Some(b'\'') => Ok(Value::Text(self.text()?)),
            Some(b'(') => Ok(Value::List(self.list(depth)?)),
            Some(b'$') => {
                self.skip(1);
                Ok(Value::Omitted)
            }
            Some(b'*') => {
                self.skip(1);
                Ok(Value::Derived)
            }
            Some(b'.') => {
                self.skip(1);
                let word = self.word();
                self.expect(b'.')?;
                Ok(Value::Word(word))
            }
            Some(b'"') => {
                self.skip(1);
                let start = self.at;
                while self.peek().is_some_and(|c| c != b'"') {
                    self.skip(1);
                }
                let text = String::from_utf8_lossy(&self.bytes[start..self.at]).into_owned();
                self.expect(b'"')?;
                Ok(Value::Text(text))
            }
            Some(c) if c.is_ascii_digit() || c == b'-' || c == b'+' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => {
                let name = self.word();
                Ok(Value::Typed(name, self.list(depth)?))
            }
            Some(c) => Err(format!("unexpected byte {c:#04x}")),
            None => Err("the file ends inside a record".into()),
        }
    }

    fn number(&mut self) -> Parsed<Value> {
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_digit() || matches!(c, b'+' | b'-' | b'.' | b'e' | b'E')) {
            self.at += 1;
        }
        let digits = std::str::from_utf8(&self.bytes[start..self.at]).unwrap_or("");
        match digits.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Value::Number(v)),
            _ => Err(format!("{digits:?} is not a number")),
        }
    }

    /// A string; two apostrophes stand for one, control directives are left as they are.
    fn text(&mut self) -> Parsed<String> {
        self.skip(1);
        let mut bytes = Vec::new();
        loop {
            match self.peek() {
                None => return Err("the file ends inside a string".into()),
                Some(b'\'') => {
                    self.skip(1);
                    if self.peek() != Some(b'\'') {
                        return Ok(decoded(&bytes));
                    }
                    bytes.push(b'\'');
                    self.skip(1);
                }
                Some(c) => {
                    if c != b'\n' && c != b'\r' {
                        bytes.push(c);
                    }
                    self.skip(1);
                }
            }
        }
    }
}

/// Text with the directives `\X2\....\X0\` (UTF-16) and `\X\hh` (ISO 8859-1) resolved.
fn decoded(bytes: &[u8]) -> String {
    let raw = String::from_utf8_lossy(bytes);
    let mut out = String::new();
    let mut rest: &str = &raw;
    while let Some(i) = rest.find('\\') {
        out.push_str(&rest[..i]);
        let tail = &rest[i..];
        if let Some(body) = tail.strip_prefix("\\X2\\")
            && let Some(end) = body.find("\\X0\\")
        {
            let units: Vec<u16> = body.as_bytes()[..end]
                .chunks(4)
                .filter_map(|c| u16::from_str_radix(std::str::from_utf8(c).ok()?, 16).ok())
                .collect();
            out.push_str(&String::from_utf16_lossy(&units));
            rest = &body[end + 4..];
        } else if let Some(hex) = tail.strip_prefix("\\X\\").and_then(|b| b.get(..2))
            && let Ok(code) = u8::from_str_radix(hex, 16)
        {
            out.push(code as char);
            rest = &tail[5..];
        } else if let Some(body) = tail.strip_prefix("\\\\") {
            out.push('\\');
            rest = body;
        } else {
            out.push('\\');
            rest = &tail[1..];
        }
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SMALL: &str = "ISO-10303-21;\nHEADER;\nFILE_NAME('a;b','','');\nENDSEC;\nDATA;\n\
        #1 = CARTESIAN_POINT('it''s',(0.,-1.5E-2,+3));\n\
        /* a comment ; */ #2=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));\n\
        #3=TRIMMED_CURVE('',#9,(#1,PARAMETER_VALUE(0.5)),$,.T.);\n#4=BROKEN(((;\n#5=NAME('\\X2\\00E90041\\X0\\\\X\\41');\nENDSEC;\nEND-ISO-10303-21;\n";

    #[test]
    fn every_kind_of_value_is_read_and_broken_records_are_named() {
        let f = parse_step(SMALL.as_bytes()).unwrap();
        assert_eq!(f.records.iter().map(|r| (r.id, r.line)).collect::<Vec<_>>(), [(1, 6), (2, 7), (3, 8), (5, 10)]);
        assert_eq!(f.unreadable.iter().map(|u| u.0).collect::<Vec<_>>(), [9]);
        let xyz = [0.0, -0.015, 3.0].map(Value::Number).to_vec();
        assert_eq!(f.get(1).unwrap().parts[0].1, [Value::Text("it's".into()), Value::List(xyz)]);
        assert_eq!(f.get(2).unwrap().name(), "LENGTH_UNIT+NAMED_UNIT+SI_UNIT");
        assert_eq!(f.get(2).unwrap().part("SI_UNIT").unwrap()[0], Value::Word("MILLI".into()));
        let typed = Value::Typed("PARAMETER_VALUE".into(), vec![Value::Number(0.5)]);
        assert_eq!(f.get(3).unwrap().parts[0].1[2], Value::List(vec![Value::Ref(1), typed]));
        assert_eq!(f.get(5).unwrap().parts[0].1[0], Value::Text("éAA".into()));
        assert_eq!(f.of("SI_UNIT").count(), 1);
    }

    #[test]
    fn what_is_no_step_file_is_refused() {
        for text in ["", "solid x", "ISO-10303-21;DATA;ENDSEC;", "ISO-10303-21;HEADER;#1=A();ENDSEC;"] {
            assert!(matches!(parse_step(text.as_bytes()), Err(Error::Input { .. })), "{text}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(cut in 0usize..400, at in 0usize..400, byte: u8) {
            let mut bytes = SMALL.as_bytes().to_vec();
            let n = bytes.len();
            bytes[at % n] = byte;
            let _ = parse_step(&bytes[..n - cut % n]);
        }
    }
}
