//! gmsh MSH 4.1 out.
//!
//! Every face becomes one discrete surface entity. Its physical tags are its own, then those of the groups that hold it;
//! physical surfaces `1..=F` are the faces, `F+1..=F+G` the groups. Nodes and elements stand in blocks by entity, as gmsh
//! wants them, and carry their numbers in the mesh plus one, so that a reader finds the mesh's own order again. A node
//! shared by faces stands with the first of them. Format: gmsh reference manual, "MSH file format", version 4.1.

use std::io::Write;

use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::Aabb;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::by_face;
use super::text::escape;

/// gmsh's number of the three-node triangle.
pub(super) const TRIANGLE: i32 = 2;

/// A row of numbers, as text on one line or as the bytes of its parts.
struct Row<'a> {
    out: &'a mut dyn Write,
    binary: bool,
    line: Vec<u8>,
}

impl Row<'_> {
    fn int(&mut self, x: i32) {
        if self.binary { self.line.extend(x.to_le_bytes()) } else { self.line.extend(format!("{x} ").bytes()) }
    }

    fn size(&mut self, x: usize) {
        if self.binary { self.line.extend((x as u64).to_le_bytes()) } else { self.line.extend(format!("{x} ").bytes()) }
    }

    fn real(&mut self, x: f64) {
        if self.binary { self.line.extend(x.to_le_bytes()) } else { self.line.extend(format!("{x:?} ").bytes()) }
    }

    fn end(&mut self) -> Result<()> {
        if !self.binary {
            self.line.pop();
            self.line.push(b'\n');
        }
        self.out.write_all(&self.line).map_err(write_failed)?;
        self.line.clear();
        Ok(())
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

/// For each face the nodes that stand with it: those no earlier face uses. Nodes of no triangle go to the first face.
fn nodes_by_face(mesh: &TriMesh, triangles: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut owner = vec![u32::MAX; mesh.nodes.len()];
    for (face, list) in triangles.iter().enumerate() {
        for v in list.iter().flat_map(|t| mesh.triangles[*t as usize]) {
            let slot = &mut owner[v as usize];
            *slot = (*slot).min(face as u32);
        }
    }
    let mut lists = vec![Vec::new(); mesh.faces.len()];
    for (v, face) in owner.into_iter().enumerate() {
        lists[if face == u32::MAX { 0 } else { face as usize }].push(v as u32);
    }
    lists
}

pub(super) fn write(out: &mut dyn Write, mesh: &TriMesh, binary: bool, run: &Run) -> Result<()> {
    let faces = mesh.faces.len();
    let physicals = faces + mesh.groups.len();
    if physicals >= i32::MAX as usize {
        return Err(Error::Failed(format!("gmsh files hold fewer than {} faces and groups", i32::MAX)));
    }
    let triangles = by_face(mesh);
    let nodes = nodes_by_face(mesh, &triangles);
    let mut row = Row { out, binary, line: Vec::new() };

    row.text(&format!("$MeshFormat\n4.1 {} 8", u8::from(binary)))?;
    if binary {
        // By this number readers tell the byte order.
        row.int(1);
        row.end()?;
    }
    row.close("MeshFormat")?;

    row.text(&format!("$PhysicalNames\n{physicals}"))?;
    for (i, name) in mesh.faces.iter().chain(mesh.groups.iter().map(|g| &g.name)).enumerate() {
        row.text(&format!("2 {} \"{}\"", i + 1, escape(name)))?;
    }
    row.text("$EndPhysicalNames")?;

    let mut groups_of_face = vec![Vec::new(); faces];
    for (g, group) in mesh.groups.iter().enumerate() {
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
    for (f, list) in triangles.iter().enumerate() {
        let corners = list.iter().flat_map(|t| mesh.corners(*t as usize));
        let bounds = if list.is_empty() { Aabb::around([mesh.nodes[0]]) } else { Aabb::around(corners) };
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
    let blocks = nodes.iter().filter(|list| !list.is_empty()).count();
    [blocks, mesh.nodes.len(), 1, mesh.nodes.len()].iter().for_each(|n| row.size(*n));
    row.end()?;
    for (f, list) in nodes.iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        [2, f as i32 + 1, 0].iter().for_each(|x| row.int(*x));
        row.size(list.len());
        row.end()?;
        for v in list {
            row.size(*v as usize + 1);
            row.end()?;
        }
        for (i, v) in list.iter().enumerate() {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            mesh.nodes[*v as usize].to_array().iter().for_each(|x| row.real(*x));
            row.end()?;
        }
    }
    row.close("Nodes")?;

    row.text("$Elements")?;
    let blocks = triangles.iter().filter(|list| !list.is_empty()).count();
    [blocks, mesh.triangles.len(), 1, mesh.triangles.len()].iter().for_each(|n| row.size(*n));
    row.end()?;
    for (f, list) in triangles.iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        [2, f as i32 + 1, TRIANGLE].iter().for_each(|x| row.int(*x));
        row.size(list.len());
        row.end()?;
        for (i, t) in list.iter().enumerate() {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            row.size(*t as usize + 1);
            mesh.triangles[*t as usize].iter().for_each(|v| row.size(*v as usize + 1));
            row.end()?;
        }
    }
    row.close("Elements")
}
