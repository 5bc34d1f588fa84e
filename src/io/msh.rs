//! gmsh MSH 4.1 out.
//!
//! Every face becomes one discrete surface entity. Its physical tags are its own, then those of the groups that hold it;
//! physical surfaces `1..=F` are the faces, `F+1..=F+G` the groups. Nodes and elements stand in blocks by entity, as gmsh
//! wants them, and carry their numbers in the mesh plus one, so that a reader finds the mesh's own order again. A node
//! shared by faces stands with the first of them. Format: gmsh reference manual, "MSH file format", version 4.1.

use std::io::Write;
use std::ops::Range;

use crate::error::{Error, Result};
use crate::mesh::MeshView;
use crate::mesh::view::extend;
use crate::run::Run;
use crate::spatial::Aabb;

use super::atomic::write_failed;
use super::build::{each_cell, each_node};
use super::line::Line;
use super::text::escape;

/// gmsh's number of the three-node triangle.
pub(super) const TRIANGLE: i32 = 2;
/// gmsh's number of the four-node quadrilateral.
const QUADRILATERAL: i32 = 3;

/// A row of numbers, as text on one line or as the bytes of its parts.
struct Row<'a> {
    out: &'a mut dyn Write,
    binary: bool,
    line: Line,
}

impl Row<'_> {
    fn int(&mut self, x: i32) {
        if self.binary { self.line.bytes(x.to_le_bytes()) } else { _ = self.line.whole(x) }
    }

    fn size(&mut self, x: usize) {
        if self.binary { self.line.bytes((x as u64).to_le_bytes()) } else { _ = self.line.whole(x) }
    }

    fn real(&mut self, x: f64) {
        if self.binary { self.line.bytes(x.to_le_bytes()) } else { _ = self.line.real(x) }
    }

    fn end(&mut self) -> Result<()> {
        if self.binary { self.line.flush(self.out) } else { self.line.end(self.out) }
    }

    /// A line of plain text, in binary files too.
    fn text(&mut self, text: &str) -> Result<()> {
        writeln!(self.out, "{text}").map_err(write_failed)
    }

    /// Binary sections end with a line break of their own before the closing word.
    fn close(&mut self, section: &str) -> Result<()> {
        let text = if self.binary { format!("\n$End{section}") } else { format!("$End{section}") };
        self.text(&text)
    }
}

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, binary: bool, run: &Run) -> Result<()> {
    let faces = mesh.face_names().len();
    let physicals = faces + mesh.groups().len();
    if physicals >= i32::MAX as usize {
        return Err(Error::Failed(format!("gmsh files hold fewer than {} faces and groups", i32::MAX)));
    }
    let blocks = blocks(mesh, run)?;
    let nodes = mesh.nodes_of_faces();
    let mut row = Row { out, binary, line: Line::default() };

    row.text(&format!("$MeshFormat\n4.1 {} 8", u8::from(binary)))?;
    if binary {
        // By this number readers tell the byte order.
        row.int(1);
        row.end()?;
    }
    row.close("MeshFormat")?;

    row.text(&format!("$PhysicalNames\n{physicals}"))?;
    for (i, name) in mesh.face_names().iter().chain(mesh.groups().iter().map(|g| &g.name)).enumerate() {
        row.text(&format!("2 {} \"{}\"", i + 1, escape(name)))?;
    }
    row.text("$EndPhysicalNames")?;

    let mut groups_of_face = vec![Vec::new(); faces];
    for (g, group) in mesh.groups().iter().enumerate() {
        for f in &group.faces {
            let tag = (faces + g + 1) as i32;
            if groups_of_face[*f as usize].last() != Some(&tag) {
                groups_of_face[*f as usize].push(tag);
            }
        }
    }
    row.text("$Entities")?;
    [0, 0, faces, 0].iter().for_each(|n| row.size(*n));
    row.end()?;
    let bounds = bounds(mesh, run)?;
    for (f, bounds) in bounds.into_iter().enumerate() {
        row.int(f as i32 + 1);
        bounds.lo.to_array().into_iter().chain(bounds.hi.to_array()).for_each(|x| row.real(x));
        row.size(1 + groups_of_face[f].len());
        row.int(f as i32 + 1);
        groups_of_face[f].iter().for_each(|tag| row.int(*tag));
        row.size(0);
        row.end()?;
    }
    row.close("Entities")?;

    row.text("$Nodes")?;
    let count = mesh.node_count();
    let filled = nodes.iter().filter(|list| !list.is_empty()).count();
    [filled, count, 1, count].iter().for_each(|n| row.size(*n));
    row.end()?;
    for (f, ranges) in nodes.into_iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        [2, f as i32 + 1, 0].iter().for_each(|x| row.int(*x));
        row.size(ranges.iter().map(|range| range.len()).sum());
        row.end()?;
        for v in ranges.iter().cloned().flatten() {
            row.size(v + 1);
            row.end()?;
        }
        for range in ranges {
            each_node(mesh, range, run, |p| {
                p.to_array().iter().for_each(|x| row.real(*x));
                row.end()
            })?;
        }
    }
    row.close("Nodes")?;

    row.text("$Elements")?;
    let count = mesh.cell_count();
    [blocks.len(), count, 1, count].iter().for_each(|n| row.size(*n));
    row.end()?;
    for Block { face, corners, ranges } in blocks {
        [2, face as i32 + 1, if corners == 3 { TRIANGLE } else { QUADRILATERAL }].iter().for_each(|x| row.int(*x));
        row.size(ranges.iter().map(|range| range.len()).sum());
        row.end()?;
        for range in ranges {
            let mut number = range.start;
            each_cell(mesh, range, run, |cell, _| {
                number += 1;
                row.size(number);
                cell.iter().for_each(|v| row.size(*v as usize + 1));
                row.end()
            })?;
        }
    }
    row.close("Elements")
}

/// Cells of one face with as many corners each: gmsh keeps one kind of element in a block.
struct Block {
    face: usize,
    corners: usize,
    ranges: Vec<Range<usize>>,
}

fn blocks(mesh: &dyn MeshView, run: &Run) -> Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for (face, ranges) in mesh.cells_of_faces().into_iter().enumerate() {
        let mut kinds: [Vec<Range<usize>>; 2] = Default::default();
        for range in ranges {
            let mut number = range.start;
            each_cell(mesh, range, run, |cell, _| {
                let kind = match cell.len() {
                    3 => 0,
                    4 => 1,
                    n => {
                        let message = "gmsh files hold triangles and quadrilaterals; write another format";
                        return Err(Error::Failed(format!("cell {number} has {n} corners, but {message}")));
                    }
                };
                extend(&mut kinds[kind], number..number + 1);
                number += 1;
                Ok(())
            })?;
        }
        let kinds = kinds.into_iter().zip([3, 4]).filter(|(ranges, _)| !ranges.is_empty());
        blocks.extend(kinds.map(|(ranges, corners)| Block { face, corners, ranges }));
    }
    Ok(blocks)
}

/// The box around the cells of each face; around the first node for a face without cells.
fn bounds(mesh: &dyn MeshView, run: &Run) -> Result<Vec<Aabb>> {
    let mut bounds = vec![None; mesh.face_names().len()];
    each_cell(mesh, 0..mesh.cell_count(), run, |cell, label| {
        let around = Aabb::around(cell.iter().map(|v| mesh.node(*v as usize)));
        let slot: &mut Option<Aabb> = &mut bounds[label as usize];
        *slot = Some(slot.map_or(around, |b| b.union(&around)));
        Ok(())
    })?;
    Ok(bounds.into_iter().map(|b| b.unwrap_or_else(|| Aabb::around([mesh.node(0)]))).collect())
}
