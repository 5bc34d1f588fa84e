//! VTK polygon data in XML, written for ParaView and its kin.

use std::io::Write;

use crate::error::Result;
use crate::mesh::MeshView;
use crate::run::Run;

use super::build::{each_cell, each_node};
use super::regions::RegionSets;
use super::vtu::{Arrays, attribute};

pub(super) fn write(
    out: &mut dyn Write,
    mesh: &dyn MeshView,
    regions: &RegionSets,
    binary: bool,
    run: &Run,
) -> Result<()> {
    let (nodes, count) = (mesh.node_count(), mesh.cell_count());
    let mut corners = 0;
    each_cell(mesh, 0..count, run, |cell, _| {
        corners += cell.len();
        Ok(())
    })?;
    let mut a = Arrays { out, binary, run };
    a.line("<?xml version=\"1.0\"?>")?;
    a.line(r#"<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#)?;
    // Two hyphens would end the comment.
    for (k, set) in regions.sets[..regions.parts].iter().enumerate() {
        a.line(&format!("<!-- part {}: {} -->", k + 1, attribute(&set.name).replace('-', "‐")))?;
    }
    a.line(&format!("<PolyData>\n<Piece NumberOfPoints=\"{nodes}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{count}\">\n<Points>"))?;
    let three = r#"type="Float64" Name="Points" NumberOfComponents="3""#;
    let coordinates = |run: &Run, take: &mut dyn FnMut(f64) -> Result<()>| {
        each_node(mesh, 0..nodes, run, |p| p.to_array().into_iter().try_for_each(&mut *take))
    };
    a.array(three, 3 * nodes, coordinates, |line, x: f64| _ = line.real(x), f64::to_le_bytes)?;
    a.line("</Points>\n<Polys>")?;
    let connectivity = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        each_cell(mesh, 0..count, run, |cell, _| cell.iter().try_for_each(|v| take(i64::from(*v))))
    };
    let whole = |name: &str| format!("type=\"Int64\" Name=\"{name}\"");
    a.array(&whole("connectivity"), corners, connectivity, |line, v| _ = line.whole(v), i64::to_le_bytes)?;
    let offsets = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        let mut end = 0;
        each_cell(mesh, 0..count, run, |cell, _| {
            end += cell.len() as i64;
            take(end)
        })
    };
    a.array(&whole("offsets"), count, offsets, |line, v| _ = line.whole(v), i64::to_le_bytes)?;
    a.line("</Polys>\n<CellData Scalars=\"part\">")?;
    let parts = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
        each_cell(mesh, 0..count, run, |_, label| take(i64::from(regions.part_of_face[label as usize]) + 1))
    };
    a.array(&whole("part"), count, parts, |line, v| _ = line.whole(v), i64::to_le_bytes)?;
    for set in &regions.sets {
        let head = format!("type=\"UInt8\" Name=\"{}\"", attribute(&set.name));
        let inside = |run: &Run, take: &mut dyn FnMut(u8) -> Result<()>| {
            each_cell(mesh, 0..count, run, |_, label| take(u8::from(set.faces.binary_search(&label).is_ok())))
        };
        a.array(&head, count, inside, |line, v| _ = line.whole(v), u8::to_le_bytes)?;
    }
    a.line("</CellData>\n</Piece>\n</PolyData>\n</VTKFile>")
}
