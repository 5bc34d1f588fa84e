//! Stanford PLY: ASCII and both binary byte orders in, little-endian binary or ASCII out.
//!
//! Each face of a text file carries an `int` property `label`. In a binary file readers may take lists and numbers of one
//! face for those of all faces, so labels stand in comments (`comment labels 0*12 1*4`: twelve faces, then four). Comments of the header name the faces (`comment face 2 top`) and hold the
//! groups (`comment group 0,2 clamped`).

use std::collections::VecDeque;
use std::io::Write;

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::mesh::{Group, MeshView, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::{MeshBuilder, UNNAMED, check_node_count, each_cell, each_node, reserve};
use super::line::WrittenLine;
use super::text::{Lines, at, count, ended, escape, quote, unescape};

/// The number types of PLY.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn from_word(word: &str) -> Option<Kind> {
        Some(match word {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

/// A property: one number, or a list whose length has the first kind.
struct Property {
    name: String,
    list: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Ascii,
    Little,
    Big,
}

struct Header {
    coding: Coding,
    elements: Vec<Element>,
    faces: Vec<(usize, String)>,
    groups: Vec<Group>,
    /// Labels of faces in a row, and how many there are of each.
    runs: Vec<(i64, usize)>,
}

fn read_header(lines: &mut Lines) -> Result<Header> {
    let (number, magic) = lines.expect("`ply`")?;
    if magic.trim() != "ply" {
        return Err(at(number, format!("a PLY file begins with `ply`, not {}", quote(magic.trim()))));
    }
    let mut coding = None;
    let mut header =
        Header { coding: Coding::Ascii, elements: Vec::new(), faces: Vec::new(), groups: Vec::new(), runs: Vec::new() };
    loop {
        let (number, line) = lines.expect("`end_header`")?;
        let mut words = line.split_whitespace();
        match words.next().unwrap_or_default() {
            "format" => {
                coding = Some(match words.next().unwrap_or_default() {
                    "ascii" => Coding::Ascii,
                    "binary_little_endian" => Coding::Little,
                    "binary_big_endian" => Coding::Big,
                    other => return Err(at(number, format!("{} is no PLY format", quote(other)))),
                })
            }
            "comment" => read_comment(line.trim(), &mut header),
            "obj_info" => {}
            "element" => {
                let name = words.next().ok_or_else(|| at(number, "the element has no name"))?.to_owned();
                let count = count(&mut words, number, "the element's count")?;
                header.elements.push(Element { name, count, properties: Vec::new() });
            }
            "property" => {
                let element =
                    header.elements.last_mut().ok_or_else(|| at(number, "a property stands before any element"))?;
                let mut kind = || {
                    let word = words.next().unwrap_or_default();
                    if word == "list" {
                        return Ok(None);
                    }
                    Kind::from_word(word).map(Some).ok_or_else(|| at(number, format!("{} is no type", quote(word))))
                };
                let wrong = || at(number, "a list's length and items need a number type each");
                let (list, kind) = match kind()? {
                    Some(kind) => (None, kind),
                    None => {
                        let length = kind()?.ok_or_else(wrong)?;
                        if matches!(length, Kind::F32 | Kind::F64) {
                            return Err(at(number, "a list's length cannot be a floating-point number"));
                        }
                        (Some(length), kind()?.ok_or_else(wrong)?)
                    }
                };
                let name = words.next().ok_or_else(|| at(number, "the property has no name"))?.to_owned();
                element.properties.push(Property { name, list, kind });
            }
            "end_header" => break,
            other => return Err(at(number, format!("{} has no place in a PLY header", quote(other)))),
        }
    }
    header.coding = coding.ok_or_else(|| at(lines.number(), "the header names no format"))?;
    Ok(header)
}

/// Takes names of faces and groups out of a comment; any other comment is passed over.
fn read_comment(line: &str, header: &mut Header) {
    if let Some(runs) = line.strip_prefix("comment labels ") {
        let read = |word: &str| word.split_once('*').and_then(|(l, n)| Some((l.parse().ok()?, n.parse().ok()?)));
        header.runs.extend(runs.split_whitespace().filter_map(read));
        return;
    }
    let mut words = line.splitn(4, ' ');
    let (_, what, numbers, name) = (words.next(), words.next(), words.next(), words.next());
    match (what, numbers, name) {
        (Some("face"), Some(number), Some(name)) => {
            if let Ok(number) = number.parse() {
                header.faces.push((number, unescape(name)));
            }
        }
        (Some("group"), Some(numbers), Some(name)) => {
            let list: Result<Vec<u32>, _> =
                numbers.split(',').filter(|n| !n.is_empty() && *n != "-").map(str::parse).collect();
            if let Ok(faces) = list {
                header.groups.push(Group { name: unescape(name), faces });
            }
        }
        _ => {}
    }
}

/// Hands out the numbers of the body one after the other, whatever their coding.
struct BodyNumbers<'a> {
    coding: Coding,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Labels of the faces to come, and how many there are of each.
    runs: VecDeque<(i64, usize)>,
}

impl BodyNumbers<'_> {
    /// The label the comments give to the next face.
    fn next_label(&mut self) -> Option<i64> {
        let (label, left) = self.runs.front_mut()?;
        let label = *label;
        *left = left.saturating_sub(1);
        if *left == 0 {
            self.runs.pop_front();
        }
        Some(label)
    }

    fn place(&self) -> Place {
        if self.coding == Coding::Ascii { Place::Line(self.line) } else { Place::Byte(self.at as u64) }
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn error(&self, message: impl Into<String>) -> Error {
        Error::input(self.place(), message)
    }

    fn number(&mut self, kind: Kind) -> Result<f64> {
        if self.coding == Coding::Ascii {
            return self.word();
        }
        let size = kind.size();
        let Some(raw) = self.bytes.get(self.at..self.at + size) else {
            return Err(self.error("the file is cut off here"));
        };
        let mut b = [0; 8];
        b[..size].copy_from_slice(raw);
        if self.coding == Coding::Big {
            b[..size].reverse();
        }
        self.at += size;
        Ok(match kind {
            Kind::I8 => f64::from(b[0] as i8),
            Kind::U8 => f64::from(b[0]),
            Kind::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Kind::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Kind::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Kind::F64 => f64::from_le_bytes(b),
        })
    }

    fn word(&mut self) -> Result<f64> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            let second_half = *b == b'\n' && self.at > 0 && self.bytes[self.at - 1] == b'\r';
            self.line += usize::from(matches!(b, b'\n' | b'\r') && !second_half);
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(ended(self.line, "more numbers"));
        }
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        let word = String::from_utf8_lossy(&rest[..end]);
        word.parse().map_err(|_| self.error(format!("{} is not a number", quote(&word))))
    }

    /// A list's length; each item takes at least a byte, so a longer list is a lie.
    fn length(&mut self, kind: Kind) -> Result<usize> {
        let n = self.number(kind)?;
        if n < 0.0 || n.fract() != 0.0 || n > self.left() as f64 {
            return Err(self.error(format!("a list of {n} items does not fit into the rest of the file")));
        }
        Ok(n as usize)
    }
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut lines = Lines::new(bytes);
    let mut header = read_header(&mut lines)?;
    let at = bytes.len() - lines.rest().len();
    let runs = std::mem::take(&mut header.runs).into();
    let mut body = BodyNumbers { coding: header.coding, bytes, at, line: lines.number() + 1, runs };
    let mut builder = MeshBuilder::default();
    let mut labels = Vec::new();
    let mut polygons = 0;
    for element in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(Error::input(Place::Item(format!("element {}", quote(&element.name))), "it has no properties"));
        }
        match element.name.as_str() {
            "vertex" => read_nodes(&mut body, element, &mut builder.mesh, run)?,
            "face" => {
                polygons += element.count;
                read_faces(&mut body, element, &mut builder, &mut labels, run)?;
            }
            _ => skip(&mut body, element, run)?,
        }
    }
    if polygons > 0 && body.coding != Coding::Ascii && body.left() > 0 {
        return Err(body.error(format!("{} bytes follow the last element the header promises", body.left())));
    }
    name_faces(&mut builder.mesh, labels, header)?;
    Ok(builder.mesh)
}

fn skip(body: &mut BodyNumbers, element: &Element, run: &Run) -> Result<()> {
    for i in 0..element.count {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        for property in &element.properties {
            skip_property(body, property)?;
        }
    }
    Ok(())
}

fn skip_property(body: &mut BodyNumbers, property: &Property) -> Result<()> {
    let n = property.list.map_or(Ok(1), |kind| body.length(kind))?;
    for _ in 0..n {
        body.number(property.kind)?;
    }
    Ok(())
}

fn read_nodes(body: &mut BodyNumbers, element: &Element, mesh: &mut TriMesh, run: &Run) -> Result<()> {
    check_node_count(element.count.saturating_add(mesh.nodes.len()), body.place())?;
    for axis in ["x", "y", "z"] {
        if !element.properties.iter().any(|p| p.name == axis && p.list.is_none()) {
            let item = Place::Item("element `vertex`".into());
            return Err(Error::input(item, format!("it has no property `{axis}`")));
        }
    }
    mesh.nodes.reserve(reserve(element.count, 3, body.left()));
    for i in 0..element.count {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut p = DVec3::ZERO;
        for property in &element.properties {
            let axis = ["x", "y", "z"].iter().position(|a| *a == property.name && property.list.is_none());
            let Some(axis) = axis else {
                skip_property(body, property)?;
                continue;
            };
            p[axis] = body.number(property.kind)?;
            if !p[axis].is_finite() {
                return Err(body.error(format!("{} of node {i} is {}, not finite", property.name, p[axis])));
            }
        }
        mesh.nodes.push(p);
    }
    Ok(())
}

fn read_faces(
    body: &mut BodyNumbers,
    element: &Element,
    builder: &mut MeshBuilder,
    labels: &mut Vec<i64>,
    run: &Run,
) -> Result<()> {
    let is_corners = |p: &Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index") && p.list.is_some();
    if !element.properties.iter().any(is_corners) {
        return Err(Error::input(Place::Item("element `face`".into()), "it has no list `vertex_indices`"));
    }
    let nodes = builder.mesh.nodes.len();
    let mut corners = Vec::new();
    for i in 0..element.count {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut label = body.next_label().unwrap_or(0);
        for property in &element.properties {
            if is_corners(property) {
                let n = property.list.map_or(Ok(0), |kind| body.length(kind))?;
                if n < 3 {
                    return Err(body.error(format!("face {i} has {n} corners, a face has at least 3")));
                }
                corners.clear();
                for _ in 0..n {
                    let v = body.number(property.kind)?;
                    if v.fract() != 0.0 || !(0.0..nodes as f64).contains(&v) {
                        return Err(body.error(format!("face {i} uses node {v}, but there are {nodes}")));
                    }
                    corners.push(v as u32);
                }
            } else if property.name == "label" && property.list.is_none() {
                label = body.number(property.kind)? as i64;
            } else {
                skip_property(body, property)?;
            }
        }
        builder.fan(&corners, 0);
        labels.resize(builder.mesh.triangles.len(), label);
    }
    Ok(())
}

/// Labels are the face numbers of the comments if those number all faces from 0; else each label in use is a face.
fn name_faces(mesh: &mut TriMesh, labels: Vec<i64>, header: Header) -> Result<()> {
    let named = header.faces.len();
    let in_order = header.faces.iter().enumerate().all(|(i, face)| face.0 == i);
    if named > 0 && in_order && labels.iter().all(|l| (0..named as i64).contains(l)) {
        mesh.labels = labels.into_iter().map(|l| l as u32).collect();
        mesh.faces = header.faces.into_iter().map(|f| f.1).collect();
        mesh.groups = header.groups;
        for group in &mesh.groups {
            if let Some(f) = group.faces.iter().find(|f| **f as usize >= named) {
                let item = Place::Item(format!("group {}", quote(&group.name)));
                return Err(Error::input(item, format!("it holds face {f}, but there are {named}")));
            }
        }
        return Ok(());
    }
    let mut distinct = labels.clone();
    distinct.sort_unstable();
    distinct.dedup();
    let name = |label: &i64| if distinct.len() == 1 { UNNAMED.into() } else { format!("label {label}") };
    mesh.faces = distinct.iter().map(name).collect();
    mesh.labels = labels.iter().map(|l| distinct.partition_point(|d| d < l) as u32).collect();
    Ok(())
}

/// Labels of all cells as comments, the same ones in a row counted.
fn label_runs(mesh: &dyn MeshView, run: &Run) -> Result<String> {
    /// Runs to a line.
    const AT_A_TIME: usize = 16;
    let mut runs: Vec<(u32, usize)> = Vec::new();
    each_cell(mesh, 0..mesh.cell_count(), run, |_, label| {
        match runs.last_mut() {
            Some((last, n)) if *last == label => *n += 1,
            _ => runs.push((label, 1)),
        }
        Ok(())
    })?;
    let words = |some: &[(u32, usize)]| some.iter().map(|(l, n)| format!(" {l}*{n}")).collect::<String>();
    Ok(runs.chunks(AT_A_TIME).map(|some| format!("comment labels{}\n", words(some))).collect())
}

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, binary: bool, run: &Run) -> Result<()> {
    let format = if binary { "binary_little_endian" } else { "ascii" };
    let mut head = format!("ply\nformat {format} 1.0\n");
    for (i, name) in mesh.face_names().iter().enumerate() {
        head.push_str(&format!("comment face {i} {}\n", escape(name)));
    }
    for group in mesh.groups() {
        let list: Vec<_> = group.faces.iter().map(u32::to_string).collect();
        let list = if list.is_empty() { "-".into() } else { list.join(",") };
        head.push_str(&format!("comment group {list} {}\n", escape(&group.name)));
    }
    let (nodes, cells) = (mesh.node_count(), mesh.cell_count());
    if binary {
        head.push_str(&label_runs(mesh, run)?);
    }
    head.push_str(&format!("element vertex {nodes}\n"));
    ["x", "y", "z"].iter().for_each(|axis| head.push_str(&format!("property double {axis}\n")));
    head.push_str(&format!("element face {cells}\n"));
    head.push_str("property list uchar int vertex_indices\n");
    head.push_str(if binary { "end_header\n" } else { "property int label\nend_header\n" });
    out.write_all(head.as_bytes()).map_err(write_failed)?;
    if nodes > i32::MAX as usize {
        return Err(Error::Failed("PLY files number nodes by 32-bit integers, this mesh has more".into()));
    }
    let mut line = WrittenLine::default();
    each_node(mesh, 0..nodes, run, |p| {
        if binary {
            p.to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes())).map_err(write_failed)
        } else {
            line.reals(p).end(out)
        }
    })?;
    let mut record = Vec::new();
    each_cell(mesh, 0..cells, run, |cell, label| {
        let size = u8::try_from(cell.len())
            .map_err(|_| Error::Failed(format!("PLY cells have at most 255 corners, not {}", cell.len())))?;
        if binary {
            record.clear();
            record.push(size);
            cell.iter().for_each(|x| record.extend(x.to_le_bytes()));
            return out.write_all(&record).map_err(write_failed);
        }
        line.whole(size).wholes(cell.iter().copied().chain([label])).end(out)
    })
}
