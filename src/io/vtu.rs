//! VTK unstructured grid in XML, written for ParaView and its kin.

use std::io::Write;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

use super::atomic::write_failed;

/// VTK's number of the triangle cell.
const VTK_TRIANGLE: u8 = 5;

/// Writes data arrays either as text or as base64 with a length of 64 bits before the bytes.
struct Arrays<'a> {
    out: &'a mut dyn Write,
    binary: bool,
    run: &'a Run,
}

impl Arrays<'_> {
    fn array<T: Copy, const N: usize>(
        &mut self,
        attributes: &str,
        values: impl Iterator<Item = T>,
        text: impl Fn(T) -> String,
        bytes: impl Fn(T) -> [u8; N],
    ) -> Result<()> {
        self.run.check()?;
        let format = if self.binary { "binary" } else { "ascii" };
        writeln!(self.out, "<DataArray {attributes} format=\"{format}\">").map_err(write_failed)?;
        if self.binary {
            let mut data = vec![0; 8];
            values.for_each(|v| data.extend(bytes(v)));
            let length = data.len() as u64 - 8;
            data[..8].copy_from_slice(&length.to_le_bytes());
            self.out.write_all(&base64(&data)).map_err(write_failed)?;
        } else {
            for value in values {
                write!(self.out, "{} ", text(value)).map_err(write_failed)?;
            }
        }
        self.line("\n</DataArray>")
    }

    fn line(&mut self, text: &str) -> Result<()> {
        writeln!(self.out, "{text}").map_err(write_failed)
    }
}

fn base64(data: &[u8]) -> Vec<u8> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = Vec::with_capacity(data.len().div_ceil(3) * 4);
    for chunk in data.chunks(3) {
        let bits = chunk.iter().enumerate().fold(0u32, |bits, (i, b)| bits | u32::from(*b) << (16 - 8 * i));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= chunk.len() { digit } else { b'=' });
        }
    }
    text
}

/// A name as the value of an XML attribute; characters XML cannot hold become `_`.
fn attribute(name: &str) -> String {
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

pub(super) fn write(out: &mut dyn Write, mesh: &TriMesh, binary: bool, run: &Run) -> Result<()> {
    let count = mesh.triangles.len();
    let mut a = Arrays { out, binary, run };
    a.line("<?xml version=\"1.0\"?>")?;
    a.line(r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#)?;
    // Which number of the array `face` means which face; two hyphens would end the comment.
    for (i, name) in mesh.faces.iter().enumerate() {
        a.line(&format!("<!-- face {i}: {} -->", attribute(name).replace('-', "‐")))?;
    }
    a.line("<UnstructuredGrid>")?;
    a.line(&format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">", mesh.nodes.len()))?;
    a.line("<Points>")?;
    let coordinates = mesh.nodes.iter().flat_map(|p| p.to_array());
    let three = r#"type="Float64" Name="Points" NumberOfComponents="3""#;
    a.array(three, coordinates, |x: f64| format!("{x:?}"), f64::to_le_bytes)?;
    a.line("</Points>\n<Cells>")?;
    let corners = mesh.triangles.iter().flatten().map(|v| i64::from(*v));
    a.array(r#"type="Int64" Name="connectivity""#, corners, |v| v.to_string(), i64::to_le_bytes)?;
    let ends = (1..=count as i64).map(|i| 3 * i);
    a.array(r#"type="Int64" Name="offsets""#, ends, |v| v.to_string(), i64::to_le_bytes)?;
    let types = std::iter::repeat_n(VTK_TRIANGLE, count);
    a.array(r#"type="UInt8" Name="types""#, types, |v| v.to_string(), u8::to_le_bytes)?;
    a.line("</Cells>\n<CellData Scalars=\"face\">")?;
    let labels = mesh.labels.iter().map(|l| i64::from(*l));
    a.array(r#"type="Int64" Name="face""#, labels, |v| v.to_string(), i64::to_le_bytes)?;
    for group in &mesh.groups {
        let mut member = vec![0u8; mesh.faces.len()];
        group.faces.iter().for_each(|f| member[*f as usize] = 1);
        let head = format!("type=\"UInt8\" Name=\"group {}\"", attribute(&group.name));
        let inside = mesh.labels.iter().map(|l| member[*l as usize]);
        a.array(&head, inside, |v| v.to_string(), u8::to_le_bytes)?;
    }
    a.line("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}
