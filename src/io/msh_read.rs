//! gmsh MSH in: 4.1 as text or binary, 2.2 as text.
//!
//! Faces and groups of our own files stand in a section `$Comments`. In files of others surface entities with the same list of physical tags are one face, called by the first tag. Every further tag is a
//! group, and so is a first tag that several lists share: then its faces are told apart by their entities' numbers.
//! Triangles and quadrangles are taken, points, lines and volumes passed over; elements of higher order are refused.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::msh::{LINE, QUADRILATERAL, TRIANGLE};
use crate::error::{Error, Place, Result};
use crate::mesh::{Group, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;
use super::build::reserve;
use super::numbered::{Element, Numbered, Own};
use super::text::{Lines, at, count, ended, float, quote, unescape};

/// Node counts of gmsh's linear elements 1..=7 (line, triangle, quadrangle, tetrahedron, hexahedron, prism, pyramid).
const LINEAR: [usize; 7] = [2, 3, 4, 4, 8, 6, 5];
/// gmsh's number of the point element.
const POINT: i32 = 15;

/// How many nodes an element of `kind` has, and of those that are faces only linear ones are let through.
fn node_count(kind: i32, place: Place) -> Result<usize> {
    match kind {
        1..=7 => Ok(LINEAR[kind as usize - 1]),
        POINT => Ok(1),
        _ => Err(Error::input(place, format!("elements of gmsh type {kind} are not read"))
            .with_help("triangles and quadrangles of first order are read; let gmsh write with Mesh.ElementOrder = 1")),
    }
}

/// Numbers as text words or little- or big-endian bytes.
struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// `None` for text, else whether the bytes are big-endian.
    big: Option<bool>,
}

impl<'a> Source<'a> {
    fn place(&self) -> Place {
        if self.big.is_none() { Place::Line(self.line) } else { Place::Byte(self.at as u64) }
    }

    fn error(&self, message: impl Into<String>) -> Error {
        Error::input(self.place(), message)
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn word(&mut self) -> Result<&'a str> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(ended(self.line, "more numbers"));
        }
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        std::str::from_utf8(&rest[..end]).map_err(|_| self.error("a number should stand here"))
    }

    fn raw<const N: usize>(&mut self, big: bool) -> Result<[u8; N]> {
        let slice = self.bytes.get(self.at..self.at + N).ok_or_else(|| self.error("the file is cut off here"))?;
        let mut raw = [0; N];
        raw.copy_from_slice(slice);
        if big {
            raw.reverse();
        }
        self.at += N;
        Ok(raw)
    }

    fn int(&mut self) -> Result<i32> {
        match self.big {
            Some(big) => Ok(i32::from_le_bytes(self.raw(big)?)),
            None => {
                let word = self.word()?;
                word.parse().map_err(|_| self.error(format!("{} is not a whole number", quote(word))))
            }
        }
    }

    fn size(&mut self) -> Result<u64> {
        match self.big {
            Some(big) => Ok(u64::from_le_bytes(self.raw(big)?)),
            None => {
                let word = self.word()?;
                word.parse().map_err(|_| self.error(format!("{} is not a whole number ≥ 0", quote(word))))
            }
        }
    }

    /// A count of items that take at least `smallest` bytes each: more than the rest of the file holds is a lie.
    fn items(&mut self, smallest: usize, what: &str) -> Result<usize> {
        let place = self.place();
        let n = self.size()?;
        if n > (self.left() / smallest) as u64 {
            return Err(Error::input(place, format!("{n} {what} do not fit into the rest of the file")));
        }
        Ok(n as usize)
    }

    fn real(&mut self) -> Result<f64> {
        match self.big {
            Some(big) => Ok(f64::from_le_bytes(self.raw(big)?)),
            None => {
                let word = self.word()?;
                word.parse().map_err(|_| self.error(format!("{} is not a number", quote(word))))
            }
        }
    }

    fn point(&mut self, tag: u64) -> Result<DVec3> {
        let p = DVec3::new(self.real()?, self.real()?, self.real()?);
        if p.is_finite() { Ok(p) } else { Err(self.error(format!("node {tag} is at {p}, which is not finite"))) }
    }
}

/// Lines and points of our own files lie on surfaces: they have no nodes of their own.
fn pass_over(raw: &mut Numbered, kind: i32) {
    raw.partial |= raw.own.is_none() || !matches!(kind, LINE | POINT);
}

fn polygon(raw: &mut Numbered, tag: u64, entity: i32, corners: &[u64]) {
    for pair in corners[1..].windows(2) {
        raw.elements.push(Element::new(tag, entity, 0, &[corners[0], pair[0], pair[1]]));
    }
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut lines = Lines::new(bytes);
    let (number, first) = lines.expect("`$MeshFormat`")?;
    if first.trim() != "$MeshFormat" {
        return Err(at(number, format!("a gmsh file begins with `$MeshFormat`, not {}", quote(first.trim()))));
    }
    let (number, format) = lines.expect("the version")?;
    let mut words = format.split_whitespace();
    let version = words.next().unwrap_or_default();
    let binary = count(&mut words, number, "the file type")? != 0;
    let size = count(&mut words, number, "the size of numbers")?;
    if !matches!((version, binary), ("4.1", _) | ("2.2" | "2", false)) || size != 8 {
        let kind = if binary { "binary" } else { "text" };
        let message = format!("gmsh version {version} ({kind}, numbers of {size} bytes) is not read");
        return Err(at(number, message).with_help("4.1 and, as text, 2.2 are; convert with `gmsh -save -format msh41`"));
    }
    let mut big = None;
    if binary {
        let mark = lines.rest().get(..4).ok_or_else(|| ended(number, "the byte order mark"))?;
        big = Some(match mark {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            _ => return Err(at(number + 1, "the byte order mark is not the number 1")),
        });
        let rest = &lines.rest()[4..];
        lines.resume(rest, 0);
    }

    let mut raw = Numbered::default();
    while let Some((number, line)) = lines.next_filled() {
        run.check()?;
        let section = line.trim();
        if section.starts_with("$End") || !section.starts_with('$') {
            if section == "$EndMeshFormat" {
                continue;
            }
            return Err(at(number, format!("{} stands where a section should begin", quote(section))));
        }
        let name = section[1..].to_owned();
        let old = version != "4.1";
        if name == "PhysicalNames" {
            read_names(&mut lines, &mut raw)?;
        } else if name == "Comments" {
            raw.own = read_comments(&mut lines)?.or(raw.own);
            continue;
        } else if matches!(name.as_str(), "Entities" | "Nodes" | "Elements") {
            let start = bytes.len() - lines.rest().len();
            let mut source = Source { bytes, at: start, line: lines.number() + 1, big };
            match (name.as_str(), old) {
                ("Entities", false) => read_entities(&mut source, &mut raw)?,
                ("Nodes", false) => read_nodes(&mut source, &mut raw, run)?,
                ("Elements", false) => read_elements(&mut source, &mut raw, run)?,
                ("Nodes", true) => read_old_nodes(&mut source, &mut raw, run)?,
                ("Elements", true) => read_old_elements(&mut source, &mut raw, run)?,
                _ => return Err(at(number, "this section has no place in version 2.2")),
            }
            let taken = source.line.saturating_sub(lines.number() + 1);
            lines.resume(&bytes[source.at..], taken);
            lines.next_line();
        }
        finish_section(&mut lines, &name)?;
    }
    raw.assemble()
}

/// Goes behind the section's closing line, passing over whatever this reader has no use for.
fn finish_section(lines: &mut Lines, name: &str) -> Result<()> {
    let wanted = format!("$End{name}");
    let known = matches!(name, "PhysicalNames" | "Entities" | "Nodes" | "Elements");
    loop {
        let (number, line) = lines.expect(&format!("`{wanted}`"))?;
        if line.trim() == wanted {
            return Ok(());
        }
        if known {
            return Err(at(number, format!("{} stands where `{wanted}` should", quote(line.trim()))));
        }
    }
}

fn read_names(lines: &mut Lines, raw: &mut Numbered) -> Result<()> {
    let (number, line) = lines.expect("the count of names")?;
    let names = count(&mut line.split_whitespace(), number, "the count of names")?;
    for _ in 0..names {
        let (number, line) = lines.expect("a physical name")?;
        let mut words = line.split_whitespace();
        let dimension = count(&mut words, number, "the dimension")?;
        let tag = float(&mut words, number, "the physical tag")? as i32;
        let name = line.find('"').zip(line.rfind('"')).filter(|(a, b)| a < b).map(|(a, b)| &line[a + 1..b]);
        let name = name.ok_or_else(|| at(number, "the name stands in no quotation marks"))?;
        if dimension == 2 {
            raw.names.insert(tag, unescape(name));
        }
    }
    Ok(())
}

/// Reads comments to their end. Those of others, and such that do not fit together, are passed over.
fn read_comments(lines: &mut Lines) -> Result<Option<Own>> {
    let mut own = Own::default();
    let (mut ours, mut first) = (false, true);
    loop {
        let (_, line) = lines.expect("`$EndComments`")?;
        let line = line.trim();
        if line == "$EndComments" {
            break;
        }
        if first {
            (ours, first) = (line == "rvachev 1", false);
            continue;
        }
        if ours {
            ours = own.take(line).is_some();
        }
    }
    let count = own.faces.len() as u32;
    let known = |f: &u32| *f < count;
    let whole = own.face_of_entity.values().all(known) && own.groups.iter().all(|g| g.faces.iter().all(known));
    Ok((ours && whole).then_some(own))
}

impl Own {
    fn take(&mut self, line: &str) -> Option<()> {
        let (word, rest) = line.split_once(' ')?;
        match word {
            "face" => self.faces.push(unescape(rest)),
            "group" => {
                let (numbers, name) = rest.split_once(' ')?;
                let numbers = numbers.split(',').filter(|n| *n != "-").map(|n| n.parse().ok());
                self.groups.push(Group { name: unescape(name), faces: numbers.collect::<Option<_>>()? });
            }
            "surface" => {
                let (entity, face) = rest.split_once(' ')?;
                self.face_of_entity.insert(entity.parse().ok()?, face.parse().ok()?);
            }
            _ => return None,
        }
        Some(())
    }
}

fn read_entities(s: &mut Source, raw: &mut Numbered) -> Result<()> {
    let counts = [s.size()?, s.size()?, s.size()?, s.size()?];
    for (dimension, n) in counts.into_iter().enumerate() {
        for _ in 0..n {
            let tag = s.int()?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                s.real()?;
            }
            let physicals = s.items(2, "physical tags")?;
            let tags = (0..physicals).map(|_| s.int()).collect::<Result<Vec<_>>>()?;
            if dimension > 0 {
                for _ in 0..s.items(2, "bounding entities")? {
                    s.int()?;
                }
            }
            if dimension == 2 {
                raw.surfaces.insert(tag, tags);
            }
        }
    }
    Ok(())
}

fn read_nodes(s: &mut Source, raw: &mut Numbered, run: &Run) -> Result<()> {
    let [blocks, total, _, _] = [s.size()?, s.size()?, s.size()?, s.size()?];
    // A node has a tag and three coordinates, at least one digit and a blank each.
    raw.nodes.reserve(reserve(total as usize, 8, s.left()));
    let mut tags = Vec::new();
    for _ in 0..blocks {
        let [dimension, _, parametric] = [s.int()?, s.int()?, s.int()?];
        let n = s.items(2, "nodes")?;
        tags.clear();
        for _ in 0..n {
            tags.push(s.size()?);
        }
        for (i, tag) in tags.iter().enumerate() {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            let p = s.point(*tag)?;
            raw.nodes.push((*tag, p));
            for _ in 0..if parametric != 0 { dimension } else { 0 } {
                s.real()?;
            }
        }
    }
    if raw.nodes.len() as u64 != total {
        return Err(s.error(format!("{total} nodes were promised, {} came", raw.nodes.len())));
    }
    Ok(())
}

fn read_elements(s: &mut Source, raw: &mut Numbered, run: &Run) -> Result<()> {
    let [blocks, total, _, _] = [s.size()?, s.size()?, s.size()?, s.size()?];
    raw.elements.reserve(reserve(total as usize, 8, s.left()));
    let mut came = 0;
    for _ in 0..blocks {
        let [_, entity, kind] = [s.int()?, s.int()?, s.int()?];
        let nodes = node_count(kind, s.place())?;
        let n = s.items(2, "elements")?;
        came += n as u64;
        let mut corners = Vec::with_capacity(nodes);
        for i in 0..n {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            let tag = s.size()?;
            corners.clear();
            for _ in 0..nodes {
                corners.push(s.size()?);
            }
            match kind {
                TRIANGLE | QUADRILATERAL => polygon(raw, tag, entity, &corners),
                _ => pass_over(raw, kind),
            }
        }
    }
    if came != total {
        return Err(s.error(format!("{total} elements were promised, {came} came")));
    }
    Ok(())
}

fn read_old_nodes(s: &mut Source, raw: &mut Numbered, run: &Run) -> Result<()> {
    for i in 0..s.items(8, "nodes")? {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let tag = s.size()?;
        let p = s.point(tag)?;
        raw.nodes.push((tag, p));
    }
    Ok(())
}

/// In version 2.2 an element has one physical tag; gmsh repeats elements that have several, under new numbers.
///
/// Elements alike in physical and elementary tag stand for one entity. An element whose corners came before with the same
/// elementary but another physical tag is such a repetition, and gives that tag to the entity of the first.
fn read_old_elements(s: &mut Source, raw: &mut Numbered, run: &Run) -> Result<()> {
    let mut entities: FxHashMap<(i32, i32), i32> = FxHashMap::default();
    let mut first: FxHashMap<(i32, [u64; 4]), (i32, i32)> = FxHashMap::default();
    for i in 0..s.items(6, "elements")? {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let tag = s.size()?;
        let kind = s.int()?;
        let nodes = node_count(kind, s.place())?;
        let tags = s.items(2, "tags")?;
        let tags = (0..tags).map(|_| s.int()).collect::<Result<Vec<_>>>()?;
        let corners = (0..nodes).map(|_| s.size()).collect::<Result<Vec<_>>>()?;
        if !matches!(kind, TRIANGLE | QUADRILATERAL) {
            pass_over(raw, kind);
            continue;
        }
        let physical = tags.first().copied().unwrap_or(0);
        let elementary = tags.get(1).copied().unwrap_or(0);
        let mut key = [0; 4];
        key[..nodes].copy_from_slice(&corners);
        if raw.own.is_some() && elementary > 0 {
            // Surfaces have numbers of their own in our files: what comes again is a repetition.
            let fresh = *first.entry((elementary, key)).or_insert((elementary, physical));
            if fresh.1 == physical {
                polygon(raw, tag, elementary, &corners);
            }
            continue;
        }
        let (home, home_physical) = *first.entry((elementary, key)).or_insert_with(|| {
            let fresh = entities.len() as i32 + 1;
            (*entities.entry((physical, elementary)).or_insert(fresh), physical)
        });
        let list = raw.surfaces.entry(home).or_default();
        if physical != 0 && !list.contains(&physical) {
            list.push(physical);
        }
        if physical == home_physical {
            polygon(raw, tag, home, &corners);
        }
    }
    Ok(())
}
