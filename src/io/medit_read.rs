//! Medit `.mesh` in: triangles and quadrilaterals, with their references as faces.
//!
//! Names of references are those of our own files, which stand in comments, else `ref N`; 0 is no reference. Points, edges, normals and the
//! like are passed over, and so are volumes.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

use super::CHECK_EVERY;
use super::build::reserve;
use super::numbered::{Element, Numbered};
use super::text::{at, count, ended, point, quote, unescape};

/// Words of a text without its comments, which begin with `#`, but for the names in those of our own files.
struct TextWords<'a> {
    rest: &'a [u8],
    line: usize,
    /// Names by reference.
    names: BTreeMap<i64, String>,
    /// Whether the last comment was one of ours.
    ours: bool,
}

impl<'a> TextWords<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            match self.rest {
                [] => return None,
                [b'#', ..] => self.comment(),
                [b, ..] if b.is_ascii_whitespace() => {
                    self.line += usize::from(*b == b'\n');
                    self.rest = &self.rest[1..];
                }
                _ => break,
            }
        }
        let end = self.rest.iter().position(|b| b.is_ascii_whitespace() || *b == b'#').unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        self.ours = false;
        // What is no text is no number either, and is quoted nowhere.
        Some(std::str::from_utf8(word).unwrap_or("\u{fffd}"))
    }

    fn comment(&mut self) {
        let end = self.rest.iter().position(|b| *b == b'\n').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        let text = String::from_utf8_lossy(line);
        let text = text.trim_start_matches('#').trim();
        let named = text.split_once(' ').and_then(|(n, name)| Some((n.parse().ok()?, unescape(name))));
        match named {
            Some((reference, name)) if self.ours => _ = self.names.insert(reference, name),
            _ => self.ours = text == "References of triangles:",
        }
    }

    fn expect(&mut self, what: &str) -> Result<&'a str> {
        self.next().ok_or_else(|| ended(self.line, what))
    }

    fn count(&mut self, what: &str) -> Result<usize> {
        let word = self.expect(what)?;
        count(&mut Some(word).into_iter(), self.line, what)
    }

    /// How many items of at least `smallest` bytes follow.
    fn items(&mut self, smallest: usize, what: &str) -> Result<usize> {
        let n = self.count(&format!("the count of {what}"))?;
        if n > reserve(n, smallest, self.rest.len()) {
            return Err(at(self.line, format!("{n} {what} do not fit into the rest of the file")));
        }
        Ok(n)
    }
}

/// What a keyword announces.
enum KeywordSection {
    /// A number that stands for itself.
    Setting,
    Vertices,
    /// Faces of so many corners.
    Faces(usize),
    /// Volumes, which have so many numbers each.
    Volumes(usize),
    /// Anything else of so many numbers each.
    Other(usize),
}

fn section(word: &str) -> Option<KeywordSection> {
    Some(match word {
        "Dimension" => KeywordSection::Setting,
        "Vertices" => KeywordSection::Vertices,
        "Triangles" => KeywordSection::Faces(3),
        "Quadrilaterals" => KeywordSection::Faces(4),
        "Tetrahedra" => KeywordSection::Volumes(5),
        "Pyramids" => KeywordSection::Volumes(6),
        "Prisms" | "Wedges" | "Pentahedra" => KeywordSection::Volumes(7),
        "Hexahedra" | "Hexaedra" => KeywordSection::Volumes(9),
        "Corners"
        | "Ridges"
        | "RequiredVertices"
        | "RequiredEdges"
        | "RequiredTriangles"
        | "RequiredQuadrilaterals"
        | "RequiredTetrahedra"
        | "ParallelVertices"
        | "ParallelEdges"
        | "ParallelTriangles" => KeywordSection::Other(1),
        "NormalAtVertices" | "TangentAtVertices" => KeywordSection::Other(2),
        "Edges" | "NormalAtTriangleVertices" | "NormalAtQuadrilateralVertices" | "TangentAtEdges" => {
            KeywordSection::Other(3)
        }
        _ => return None,
    })
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut words = TextWords { rest: bytes, line: 1, names: BTreeMap::new(), ours: false };
    let first = words.expect("`MeshVersionFormatted`")?;
    if first != "MeshVersionFormatted" {
        let what = format!("a Medit file begins with `MeshVersionFormatted`, not {}", quote(first));
        return Err(at(words.line, what));
    }
    words.count("the version")?;
    let mut raw = Numbered::default();
    let mut axes = 3;
    loop {
        run.check()?;
        let word = words.expect("`End`")?;
        if word == "End" {
            return raw.finish();
        }
        let line = words.line;
        match section(word) {
            Some(KeywordSection::Setting) => {
                axes = words.count("the dimension")?;
                if !matches!(axes, 2 | 3) {
                    return Err(at(words.line, format!("the dimension is {axes}, and must be 2 or 3")));
                }
            }
            Some(KeywordSection::Vertices) => vertices(&mut words, &mut raw, axes, run)?,
            Some(KeywordSection::Faces(corners)) => faces(&mut words, &mut raw, corners, run)?,
            Some(KeywordSection::Volumes(numbers)) => {
                let n = pass(&mut words, word, numbers)?;
                raw.partial |= n > 0;
                raw.volumes |= n > 0;
            }
            Some(KeywordSection::Other(numbers)) => _ = pass(&mut words, word, numbers)?,
            // Normals and tangents have as many numbers as there are axes.
            None if matches!(word, "Normals" | "Tangents") => _ = pass(&mut words, word, axes)?,
            None => {
                let help = "vertices, triangles and quadrilaterals of first order are read; edges, marks and volumes are passed over";
                return Err(at(line, format!("{} is no section that is read", quote(word))).with_help(help));
            }
        }
    }
}

fn vertices(words: &mut TextWords, raw: &mut Numbered, axes: usize, run: &Run) -> Result<()> {
    // Coordinates and a reference have a digit and a blank each; the last blank may be the end of the file.
    let n = words.items(2 * axes + 1, "vertices")?;
    raw.nodes.reserve(n);
    for i in 0..n {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut coordinates = ["0"; 3];
        for c in &mut coordinates[..axes] {
            *c = words.expect(&format!("vertex {} of {n}", i + 1))?;
        }
        let p: DVec3 = point(&mut coordinates.into_iter(), words.line)?;
        words.expect(&format!("the reference of vertex {}", i + 1))?;
        raw.nodes.push((raw.nodes.len() as u64 + 1, p));
    }
    Ok(())
}

fn faces(words: &mut TextWords, raw: &mut Numbered, corners: usize, run: &Run) -> Result<()> {
    let what = if corners == 3 { "triangle" } else { "quadrilateral" };
    let n = words.items(2 * corners + 1, &format!("{what}s"))?;
    raw.elements.reserve(n);
    let mut last = None;
    for i in 0..n {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut four = [0; 4];
        for v in &mut four[..corners] {
            *v = words.count(&format!("a node of {what} {} of {n}", i + 1))? as u64;
        }
        let line = words.line;
        let word = words.expect(&format!("the reference of {what} {}", i + 1))?;
        let reference: i64 =
            word.parse().map_err(|_| at(words.line, format!("the reference is {}, no whole number", quote(word))))?;
        // Neighbors in the file mostly have the same one.
        let entity = match last {
            Some((known, entity)) if known == reference => entity,
            _ if reference == 0 => raw.entity(&[]),
            _ => {
                let name = || words.names.get(&reference).cloned().unwrap_or_else(|| format!("ref {reference}"));
                let set = raw.set(&reference.to_string(), name);
                raw.entity(&[set])
            }
        };
        last = Some((reference, entity));
        raw.elements.push(Element::new(raw.elements.len() as u64 + 1, entity, line, &four[..corners]));
    }
    Ok(())
}

/// Passes over a section; returns how many items it has.
fn pass(words: &mut TextWords, what: &str, numbers: usize) -> Result<usize> {
    let n = words.items(2 * numbers - 1, what)?;
    for i in 0..n {
        for _ in 0..numbers {
            let word = words.expect(&format!("item {} of {n} of {what}", i + 1))?;
            if word.parse::<f64>().is_err() {
                return Err(at(words.line, format!("{} is no number of {what}", quote(word))));
            }
        }
    }
    Ok(n)
}
