//! VTK unstructured grid in XML, written for ParaView and its kin.

use std::io::Write;

use crate::error::Result;
use crate::mesh::MeshView;
use crate::numeric::base64::base64;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::{each_cell, each_node};
use super::line::WrittenLine;

/// VTK's number of the triangle cell.
pub(super) const VTK_TRIANGLE: u8 = 5;
/// Of the polygon,
const VTK_POLYGON: u8 = 7;
/// and of the quadrilateral.
pub(super) const VTK_QUAD: u8 = 9;

/// Writes data arrays either as text or as base64 with a length of 64 bits before the bytes.
pub(super) struct Arrays<'a> {
    pub(super) out: &'a mut dyn Write,
    pub(super) binary: bool,
    pub(super) run: &'a Run,
}

impl Arrays<'_> {
    /// An array of `count` values, which `values` hands out one after the other.
    pub(super) fn array<T: Copy, const N: usize>(
        &mut self,
        attributes: &str,
        count: usize,
        values: impl FnOnce(&Run, &mut dyn FnMut(T) -> Result<()>) -> Result<()>,
        text: impl Fn(&mut WrittenLine, T),
        bytes: impl Fn(T) -> [u8; N],
    ) -> Result<()> {
        self.run.check()?;
        let format = if self.binary { "binary" } else { "ascii" };
        writeln!(self.out, "<DataArray {attributes} format=\"{format}\">").map_err(write_failed)?;
        if self.binary {
            let mut base64 = Base64 { out: self.out, data: Vec::new() };
            base64.push(&((count * N) as u64).to_le_bytes())?;
            values(self.run, &mut |value| base64.push(&bytes(value)))?;
            base64.finish()?;
            self.line("")?;
        } else {
            /// Numbers to a line: a bearable length.
            const WORDS: usize = 12;
            let (out, mut line, mut words) = (&mut *self.out, WrittenLine::default(), 0);
            values(self.run, &mut |value| {
                text(&mut line, value);
                words += 1;
                if words % WORDS == 0 { line.end(out) } else { Ok(()) }
            })?;
            if words % WORDS > 0 {
                line.end(out)?;
            }
        }
        self.line("</DataArray>")
    }

    /// Arrays of the whole file, one for each face: its number in the array `face`, and its dimension. meshio has the names of
    /// gmsh's files so; it reads no array of strings.
    pub(super) fn names(&mut self, names: &[String]) -> Result<()> {
        self.line("<FieldData>")?;
        for (number, name) in names.iter().enumerate() {
            let head = format!("type=\"Int64\" Name=\"{}\" NumberOfTuples=\"2\"", attribute(name));
            self.line(&format!("<DataArray {head} format=\"ascii\">\n{number} 2\n</DataArray>"))?;
        }
        self.line("</FieldData>")
    }

    pub(super) fn line(&mut self, text: &str) -> Result<()> {
        writeln!(self.out, "{text}").map_err(write_failed)
    }
}

/// Bytes on their way into base64.
struct Base64<'a> {
    out: &'a mut dyn Write,
    data: Vec<u8>,
}

impl Base64<'_> {
    /// Bytes coded at a time; a multiple of three, so that nothing but the end is padded.
    const AT_A_TIME: usize = 3 << 12;

    fn push(&mut self, bytes: &[u8]) -> Result<()> {
        self.data.extend(bytes);
        if self.data.len() >= Self::AT_A_TIME {
            let whole = self.data.len() / 3 * 3;
            self.out.write_all(base64(&self.data[..whole]).as_bytes()).map_err(write_failed)?;
            self.data.drain(..whole);
        }
        Ok(())
    }

    fn finish(self) -> Result<()> {
        self.out.write_all(base64(&self.data).as_bytes()).map_err(write_failed)
    }
}

/// A name as the value of an XML attribute; characters XML cannot hold become `_`.
pub(super) fn attribute(name: &str) -> String {
    name.chars()
        .map(|c| match c {
            '&' => "&amp;".into(),
            '<' => "&lt;".into(),
            '>' => "&gt;".into(),
            '"' => "&quot;".into(),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => "_".into(),
            c => c.to_string(),
        })
        .collect()
}

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, binary: bool, run: &Run) -> Result<()> {
    let (nodes, count) = (mesh.node_count(), mesh.cell_count());
    let mut corners = 0;
    each_cell(mesh, 0..count, run, |cell, _| {
        corners += cell.len();
        Ok(())
    })?;
    let mut a = Arrays { out, binary, run };
    a.line("<?xml version=\"1.0\"?>")?;
    a.line(r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#)?;
    a.line("<UnstructuredGrid>")?;
    a.names(mesh.face_names())?;
    a.line(&format!("<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{count}\">"))?;
    a.line("<Points>")?;
    let three = r#"type="Float64" Name="Points" NumberOfComponents="3""#;
    let coordinates = |run: &Run, take: &mut dyn FnMut(f64) -> Result<()>| {
        each_node(mesh, 0..nodes, run, |p| p.to_array().into_iter().try_for_each(&mut *take))
    };
    a.array(three, 3 * nodes, coordinates, |line, x: f64| _ = line.real(x), f64::to_le_bytes)?;
    a.line("</Points>\n<Cells>")?;
    let connectivity = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        each_cell(mesh, 0..count, run, |cell, _| cell.iter().try_for_each(|v| take(i64::from(*v))))
    };
    a.array(
        r#"type="Int64" Name="connectivity""#,
        corners,
        connectivity,
        |line, v| _ = line.whole(v),
        i64::to_le_bytes,
    )?;
    let offsets = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        let mut end = 0;
        each_cell(mesh, 0..count, run, |cell, _| {
            end += cell.len() as i64;
            take(end)
        })
    };
    a.array(r#"type="Int64" Name="offsets""#, count, offsets, |line, v| _ = line.whole(v), i64::to_le_bytes)?;
    let types = |run: &Run, take: &mut dyn FnMut(u8) -> Result<()>| {
        each_cell(mesh, 0..count, run, |cell, _| {
            take(match cell.len() {
                3 => VTK_TRIANGLE,
                4 => VTK_QUAD,
                _ => VTK_POLYGON,
            })
        })
    };
    a.array(r#"type="UInt8" Name="types""#, count, types, |line, v| _ = line.whole(v), u8::to_le_bytes)?;
    a.line("</Cells>\n<CellData Scalars=\"face\">")?;
    let labels = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        each_cell(mesh, 0..count, run, |_, label| take(i64::from(label)))
    };
    a.array(r#"type="Int64" Name="face""#, count, labels, |line, v| _ = line.whole(v), i64::to_le_bytes)?;
    for group in mesh.groups() {
        let mut member = vec![0u8; mesh.face_names().len()];
        group.faces.iter().for_each(|f| member[*f as usize] = 1);
        let head = format!("type=\"UInt8\" Name=\"group {}\"", attribute(&group.name));
        let inside = |run: &Run, take: &mut dyn FnMut(u8) -> Result<()>| {
            each_cell(mesh, 0..count, run, |_, label| take(member[label as usize]))
        };
        a.array(&head, count, inside, |line, v| _ = line.whole(v), u8::to_le_bytes)?;
    }
    a.line("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}
