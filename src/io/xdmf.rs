//! XDMF 3 for ParaView, meshio and their kin, written only: one XML file that holds its numbers as text.
//!
//! Numbers in a binary file beside it would not be read reliably: meshio looks for that file in the folder it is called from,
//! and knows neither `Seek` nor `Endian`.

use std::io::Write;

use crate::error::Result;
use crate::mesh::MeshView;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::{each_cell, each_node, fan};
use super::line::WrittenLine;
use super::text::escape;
use super::vtu::attribute;

/// Writes triangles with the number of the face of each, and for each group whether it holds the triangle.
pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let (nodes, cells) = (mesh.node_count(), mesh.cell_count());
    let mut count = 0;
    each_cell(mesh, 0..cells, run, |cell, _| {
        count += cell.len() - 2;
        Ok(())
    })?;
    let mut line = WrittenLine::default();
    put(out, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"part\" GridType=\"Uniform\">")?;
    names(out, mesh.face_names())?;

    put(out, "<Geometry GeometryType=\"XYZ\">")?;
    put(out, &item("Float", 8, &format!("{nodes} 3")))?;
    each_node(mesh, 0..nodes, run, |p| line.reals(p).end(out))?;
    put(out, "</DataItem>\n</Geometry>")?;

    put(out, &format!("<Topology TopologyType=\"Triangle\" NumberOfElements=\"{count}\">"))?;
    put(out, &item("UInt", 4, &format!("{count} 3")))?;
    each_cell(mesh, 0..cells, run, |cell, _| fan(cell).try_for_each(|corners| line.wholes(corners).end(out)))?;
    put(out, "</DataItem>\n</Topology>")?;

    let mut of_cells = |name: &str, value: &dyn Fn(u32) -> u32| -> Result<()> {
        let name = attribute(&escape(name));
        put(out, &format!("<Attribute Name=\"{name}\" AttributeType=\"Scalar\" Center=\"Cell\">"))?;
        put(out, &item("UInt", 4, &count.to_string()))?;
        each_cell(mesh, 0..cells, run, |cell, label| {
            (2..cell.len()).try_for_each(|_| line.whole(value(label)).end(out))
        })?;
        put(out, "</DataItem>\n</Attribute>")
    };
    of_cells("face", &|label| label)?;
    for group in mesh.groups() {
        let mut member = vec![0; mesh.face_names().len()];
        group.faces.iter().for_each(|f| member[*f as usize] = 1);
        of_cells(&format!("group {}", group.name), &|label| member[label as usize])?;
    }
    put(out, "</Grid>\n</Domain>\n</Xdmf>")
}

/// The names of faces by number. A list of this kind is what meshio takes for `field_data`; others pass over it.
fn names(out: &mut dyn Write, names: &[String]) -> Result<()> {
    // With `]]>` the list would end: names have no `>` as it stands.
    put(out, "<Information Name=\"faces\" Value=\"dim, number\"><![CDATA[<main>")?;
    for (number, name) in names.iter().enumerate() {
        put(out, &format!("<map key=\"{}\" dim=\"2\">{number}</map>", attribute(&escape(name))))?;
    }
    put(out, "</main>]]></Information>")
}

/// The head of an array.
fn item(kind: &str, bytes: u8, dimensions: &str) -> String {
    format!("<DataItem DataType=\"{kind}\" Precision=\"{bytes}\" Dimensions=\"{dimensions}\" Format=\"XML\">")
}

fn put(out: &mut dyn Write, text: &str) -> Result<()> {
    writeln!(out, "{text}").map_err(write_failed)
}
