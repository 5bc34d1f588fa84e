//! Nastran bulk data in: GRID, CTRIA3 and CQUAD4 in free, small and large fields, with properties as faces.
//!
//! Names of properties are those of our own files and of HyperMesh, which stand in comments, else `PID N`.

use std::collections::BTreeMap;

use glam::DVec3;

use super::bdf::WIDE;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

use super::CHECK_EVERY;
use super::numbered::{Element, Numbered};
use super::text::{Lines, at, ended, quote, unescape};

/// Columns of a small field.
const SMALL: usize = 8;

/// A card with the fields of its lines.
struct Card {
    line: usize,
    /// In capitals, without the `*` of large fields.
    name: String,
    fields: Vec<String>,
}

impl Card {
    fn field(&self, k: usize) -> &str {
        self.fields.get(k).map_or("", String::as_str)
    }

    fn whole(&self, k: usize, what: &str) -> Result<u64> {
        let word = self.field(k);
        word.parse()
            .map_err(|_| at(self.line, format!("{} has {} for {what}, no whole number", self.name, quote(word))))
    }

    fn real(&self, k: usize, what: &str) -> Result<f64> {
        let word = self.field(k);
        if word.is_empty() {
            return Ok(0.0);
        }
        let value = number(word).filter(|x| x.is_finite());
        value.ok_or_else(|| at(self.line, format!("{} has {} for {what}, no finite number", self.name, quote(word))))
    }
}

/// A number, whose exponent may begin with a sign alone or with `D`.
fn number(word: &str) -> Option<f64> {
    let plain = word.replace(['d', 'D', 'E'], "e");
    let sign = plain.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')).map(|(i, _)| i);
    match sign.filter(|i| !plain[..*i].ends_with('e')) {
        Some(i) => format!("{}e{}", &plain[..i], &plain[i..]).parse().ok(),
        None => plain.parse().ok(),
    }
}

/// Appends the fields of a line, without that of the card's name and without the mark of a continuation.
fn fields(line: &str, out: &mut Vec<String>) {
    // Comments behind data begin with `$`.
    let line = line.split('$').next().unwrap_or_default();
    let from = out.len();
    if line.contains(',') {
        let most = if line.split(',').next().unwrap_or_default().contains('*') { 4 } else { 8 };
        let words = line.split(',').skip(1).take(most).map(|w| w.trim().to_owned());
        out.extend(words);
        out.resize(from + most, String::new());
        return;
    }
    let mut columns: Vec<char> = Vec::with_capacity(line.len());
    for c in line.chars() {
        match c {
            '\t' => columns.resize((columns.len() / SMALL + 1) * SMALL, ' '),
            c => columns.push(c),
        }
    }
    let wide = columns.iter().take(SMALL).any(|c| *c == '*');
    let (width, count) = if wide { (WIDE, 4) } else { (SMALL, 8) };
    for k in 0..count {
        let part = columns.iter().skip(SMALL + k * width).take(width);
        out.push(part.collect::<String>().trim().to_owned());
    }
}

/// The name of the card that begins on a line; none on lines that go on with one.
fn name_of(line: &str) -> Option<String> {
    let first = line.chars().next()?;
    if matches!(first, '+' | '*' | ',') || first.is_whitespace() {
        return None;
    }
    let end = line.find(',').unwrap_or(line.len());
    let name: String = line[..end].chars().take_while(|c| *c != '\t').take(SMALL).collect();
    Some(name.trim().trim_end_matches('*').trim_end().to_ascii_uppercase())
}

/// The number of a property and its name, where a comment tells them.
fn named(comment: &str) -> Option<(u64, String)> {
    if let Some(rest) = comment.strip_prefix("$ PSHELL and SET1 ") {
        let (number, name) = rest.split_once(": ")?;
        return Some((number.parse().ok()?, unescape(name)));
    }
    let rest = comment.strip_prefix("$HMNAME COMP ")?;
    let (number, name) = rest.split_once('"')?;
    Some((number.trim().parse().ok()?, unescape(name.trim_end().strip_suffix('"')?)))
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let begins = |line: &str, what: &str| line.get(..what.len()).is_some_and(|l| l.eq_ignore_ascii_case(what));
    let mut lines = Lines::new(bytes);
    // Files to include have nothing but cards.
    let mut head = Lines::new(bytes);
    let whole = std::iter::from_fn(|| head.next_filled()).any(|(_, line)| begins(line.trim_start(), "BEGIN BULK"));
    let (mut bulk, mut ended_well) = (!whole, !whole);
    let mut raw = Numbered::default();
    let mut names = BTreeMap::new();
    let mut card: Option<Card> = None;
    let mut looked = 0;
    while let Some((line_number, line)) = lines.next_filled() {
        looked += 1;
        if looked % CHECK_EVERY == 0 {
            run.check()?;
        }
        if line.starts_with('$') {
            if let Some((number, name)) = named(&line) {
                names.entry(number).or_insert(name);
            }
        } else if begins(line.trim_start(), "BEGIN BULK") {
            bulk = true;
        } else if begins(line.trim_start(), "INCLUDE") {
            return Err(at(line_number, "INCLUDE is not read: put the lines of that file in its place"));
        } else if !bulk {
        } else if begins(&line, "ENDDATA") {
            ended_well = true;
            break;
        } else if let Some(name) = name_of(&line) {
            if let Some(done) = card.take() {
                take(&mut raw, &names, &done)?;
            }
            let mut fresh = Card { line: line_number, name, fields: Vec::new() };
            if matters(&fresh.name) {
                fields(&line, &mut fresh.fields);
                card = Some(fresh);
            } else {
                pass(&mut raw, &fresh)?;
            }
        } else if let Some(card) = &mut card {
            fields(&line, &mut card.fields);
        }
    }
    if !ended_well {
        return Err(ended(lines.number(), "`ENDDATA`"));
    }
    if let Some(done) = card {
        take(&mut raw, &names, &done)?;
    }
    if raw.nodes.is_empty() && raw.elements.is_empty() && !raw.volumes {
        return Err(at(lines.number(), "the file holds no GRID and no element"));
    }
    raw.finish()
}

fn matters(name: &str) -> bool {
    matches!(name, "GRID" | "CTRIA3" | "CTRIAR" | "CQUAD4" | "CQUADR")
}

/// Looks at the name of a card that is not read.
fn pass(raw: &mut Numbered, card: &Card) -> Result<()> {
    match &card.name[..] {
        "CTRIA6" | "CQUAD8" | "CQUAD" => Err(at(card.line, format!("{} is not read", card.name))
            .with_help("faces of first order are: CTRIA3 and CQUAD4")),
        "CTETRA" | "CHEXA" | "CPENTA" | "CPYRAM" | "CPYRA" => {
            raw.pass_over(true);
            Ok(())
        }
        name => {
            // Bars, springs and the like.
            raw.partial |= name.starts_with('C') && !name.starts_with("CORD");
            Ok(())
        }
    }
}

fn take(raw: &mut Numbered, names: &BTreeMap<u64, String>, card: &Card) -> Result<()> {
    let own = card.whole(0, "its number")?;
    if card.name == "GRID" {
        if !matches!(card.field(1), "" | "0") {
            let what =
                format!("GRID {own} is in the coordinate system {}: only the basic one is read", quote(card.field(1)));
            return Err(at(card.line, what));
        }
        let p = DVec3::new(card.real(2, "x")?, card.real(3, "y")?, card.real(4, "z")?);
        raw.nodes.push((own, p));
        return Ok(());
    }
    let entity = match card.field(1) {
        "" => raw.entity(&[]),
        _ => {
            let property = card.whole(1, "its property")?;
            let name = || names.get(&property).cloned().unwrap_or_else(|| format!("PID {property}"));
            let set = raw.set(&property.to_string(), name);
            raw.entity(&[set])
        }
    };
    let corners = if card.name.starts_with("CTRIA") { 3 } else { 4 };
    let nodes = (2..2 + corners).map(|k| card.whole(k, "a node")).collect::<Result<Vec<_>>>()?;
    raw.elements.push(Element::new(own, entity, card.line, &nodes));
    Ok(())
}
