//! gmsh MSH 4.1 and 2.2 out.
//!
//! Every connected piece of a face becomes one discrete surface, every chain of edges between two pieces a discrete curve,
//! and its ends points; a curve's physical name is that of the faces beside it (`bore|body.xmin`), on a plane figure that of the border. Which physical surfaces
//! there are is told by [`Grouping`](super::Grouping). Cells carry their numbers in the mesh plus one, and nodes too, so that a reader finds the
//! mesh's own order again. A section `$Comments`, which gmsh passes over, holds faces and groups for our own reader.
//! Format: gmsh reference manual, "MSH file format", versions 4.1 and 2.2.

use std::collections::BTreeMap;
use std::io::Write;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::MeshView;
use crate::run::Run;
use crate::spatial::Aabb;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::{each_cell, each_node};
use super::layout::{Layout, NodeOwner, SurfaceEntity};
use super::line::WrittenLine;
use super::regions::{NamedSet, RegionSets};
use super::text::escape;

/// gmsh's number of the two-node line.
pub(super) const LINE: i32 = 1;
/// gmsh's number of the three-node triangle.
pub(super) const TRIANGLE: i32 = 2;
/// gmsh's number of the four-node quadrilateral.
pub(super) const QUADRILATERAL: i32 = 3;

/// A row of numbers, as text on one line or as the bytes of its parts.
pub(super) struct ElementRow<'a> {
    pub(super) out: &'a mut dyn Write,
    pub(super) binary: bool,
    pub(super) line: WrittenLine,
}

impl ElementRow<'_> {
    pub(super) fn int(&mut self, x: i32) {
        if self.binary { self.line.bytes(x.to_le_bytes()) } else { _ = self.line.whole(x) }
    }

    pub(super) fn size(&mut self, x: usize) {
        if self.binary { self.line.bytes((x as u64).to_le_bytes()) } else { _ = self.line.whole(x) }
    }

    pub(super) fn real(&mut self, x: f64) {
        if self.binary { self.line.bytes(x.to_le_bytes()) } else { _ = self.line.real(x) }
    }

    pub(super) fn end(&mut self) -> Result<()> {
        if self.binary { self.line.flush(self.out) } else { self.line.end(self.out) }
    }

    pub(super) fn ints(&mut self, list: &[i32]) {
        list.iter().for_each(|x| self.int(*x));
    }

    pub(super) fn bounds(&mut self, b: &Aabb) {
        b.lo.to_array().into_iter().chain(b.hi.to_array()).for_each(|x| self.real(x));
    }

    /// A count, then as many numbers.
    pub(super) fn list(&mut self, list: &[i32]) {
        self.size(list.len());
        self.ints(list);
    }

    /// A line of plain text, in binary files too.
    pub(super) fn text(&mut self, text: &str) -> Result<()> {
        writeln!(self.out, "{text}").map_err(write_failed)
    }

    /// What version 4.1 begins with.
    pub(super) fn head(&mut self) -> Result<()> {
        self.text(&format!("$MeshFormat\n4.1 {} 8", u8::from(self.binary)))?;
        if self.binary {
            // By this number readers tell the byte order.
            self.int(1);
            self.end()?;
        }
        self.close("MeshFormat")
    }

    /// Binary sections end with a line break of their own before the closing word.
    pub(super) fn close(&mut self, section: &str) -> Result<()> {
        let text = if self.binary { format!("\n$End{section}") } else { format!("$End{section}") };
        self.text(&text)
    }
}

/// What tells a curve: the labels beside it, and the rim it is of, if it is of one.
type Beside<'a> = (&'a [u32], Option<u32>);

/// What is written: the mesh, cut up and named.
pub(super) struct Gmsh<'a> {
    pub(super) mesh: &'a dyn MeshView,
    pub(super) layout: &'a Layout,
    pub(super) regions: &'a RegionSets,
}

impl Gmsh<'_> {
    /// Physical tags of the surfaces of a face, its part first.
    fn surface_tags(&self, label: u32) -> Vec<i32> {
        let part = self.regions.part_of_face[label as usize] as i32 + 1;
        let further = self.regions.sets.iter().enumerate().skip(self.regions.parts);
        let further = further.filter(|(_, set)| set.faces.contains(&label)).map(|(k, _)| k as i32 + 1);
        [part].into_iter().chain(further).collect()
    }

    /// Names of curves by the labels beside them, and their physical tags.
    fn curve_names(&self) -> BTreeMap<Beside<'_>, (i32, String)> {
        let mut names = BTreeMap::new();
        for curve in &self.layout.curves {
            let fresh = names.len() as i32 + 1;
            names.entry((&curve.labels[..], curve.rim)).or_insert_with(|| {
                if let Some(rim) = curve.rim {
                    return (fresh, self.layout.rims[rim as usize].clone());
                }
                let faces: Vec<&str> = curve.labels.iter().map(|l| &self.mesh.face_names()[*l as usize][..]).collect();
                // A seam lies within one face, the rim of a sheet has one beside it: both are told by one name.
                (fresh, if faces.len() == 1 { format!("{}|", faces[0]) } else { faces.join("|") })
            });
        }
        names
    }

    /// Names for the section of physical names, curves before surfaces.
    fn names(&self, row: &mut ElementRow, sets: &[NamedSet]) -> Result<()> {
        let curves = self.curve_names();
        row.text(&format!("$PhysicalNames\n{}", curves.len() + sets.len()))?;
        let mut curves: Vec<_> = curves.into_values().collect();
        curves.sort_unstable();
        for (tag, name) in curves {
            row.text(&format!("1 {tag} \"{}\"", escape(&name)))?;
        }
        for (k, set) in sets.iter().enumerate() {
            row.text(&format!("2 {} \"{}\"", k + 1, escape(&set.name)))?;
        }
        row.text("$EndPhysicalNames")
    }

    /// All that [`TriMesh`](crate::mesh::TriMesh) knows of faces and groups: names, groups as lists of faces, and for each
    /// surface its face.
    fn comments(&self, row: &mut ElementRow) -> Result<()> {
        row.text("$Comments\nrvachev 1")?;
        for name in self.mesh.face_names() {
            row.text(&format!("face {}", escape(name)))?;
        }
        let numbers = |list: &[u32]| {
            let words: Vec<_> = list.iter().map(u32::to_string).collect();
            if words.is_empty() { "-".into() } else { words.join(",") }
        };
        for group in self.mesh.groups() {
            row.text(&format!("group {} {}", numbers(&group.faces), escape(&group.name)))?;
        }
        for (s, surface) in self.layout.surfaces.iter().enumerate() {
            row.text(&format!("surface {} {}", s + 1, surface.label))?;
        }
        row.text("$EndComments")
    }

    fn check(&self) -> Result<()> {
        if self.regions.sets.len() >= i32::MAX as usize {
            return Err(Error::Failed(format!("gmsh files hold fewer than {} faces and groups", i32::MAX)));
        }
        Ok(())
    }

    /// Version 4.1.
    pub(super) fn write(&self, out: &mut dyn Write, binary: bool, run: &Run) -> Result<()> {
        self.check()?;
        let blocks = blocks(self.mesh, &self.layout.surfaces)?;
        let mut row = ElementRow { out, binary, line: WrittenLine::default() };
        row.head()?;
        self.comments(&mut row)?;
        self.names(&mut row, &self.regions.sets)?;
        self.entities(&mut row)?;
        self.nodes(&mut row, run)?;
        self.elements(&mut row, &blocks, run)
    }

    fn entities(&self, row: &mut ElementRow) -> Result<()> {
        let Layout { points, curves, surfaces, .. } = self.layout;
        row.text("$Entities")?;
        [points.len(), curves.len(), surfaces.len(), 0].iter().for_each(|n| row.size(*n));
        row.end()?;
        for (p, v) in points.iter().enumerate() {
            row.int(p as i32 + 1);
            self.mesh.node(*v as usize).to_array().into_iter().for_each(|x| row.real(x));
            row.size(0);
            row.end()?;
        }
        let names = self.curve_names();
        for (c, curve) in curves.iter().enumerate() {
            row.int(c as i32 + 1);
            row.bounds(&Aabb::around(curve.nodes.iter().map(|v| self.mesh.node(*v as usize))));
            row.list(&[names[&(&curve.labels[..], curve.rim)].0]);
            row.list(&[curve.ends[0] as i32 + 1, -(curve.ends[1] as i32 + 1)]);
            row.end()?;
        }
        for (s, surface) in surfaces.iter().enumerate() {
            row.int(s as i32 + 1);
            row.bounds(&surface.bounds);
            row.list(&self.surface_tags(surface.label));
            let curves: Vec<i32> = surface.curves.iter().map(|c| *c as i32 + 1).collect();
            row.list(&curves);
            row.end()?;
        }
        row.close("Entities")
    }

    fn nodes(&self, row: &mut ElementRow, run: &Run) -> Result<()> {
        let mut blocks: BTreeMap<(i32, i32), Vec<u32>> = BTreeMap::new();
        for (v, owner) in self.layout.owners.iter().enumerate() {
            let key = match owner {
                NodeOwner::Point(p) => (0, *p as i32 + 1),
                NodeOwner::Curve(c) => (1, *c as i32 + 1),
                NodeOwner::Surface(s) => (2, *s as i32 + 1),
            };
            blocks.entry(key).or_default().push(v as u32);
        }
        row.text("$Nodes")?;
        let count = self.mesh.node_count();
        [blocks.len(), count, 1, count].iter().for_each(|n| row.size(*n));
        row.end()?;
        for ((dimension, tag), nodes) in blocks {
            run.check()?;
            row.ints(&[dimension, tag, 0]);
            row.size(nodes.len());
            row.end()?;
            for v in &nodes {
                row.size(*v as usize + 1);
                row.end()?;
            }
            for v in &nodes {
                self.mesh.node(*v as usize).to_array().iter().for_each(|x| row.real(*x));
                row.end()?;
            }
        }
        row.close("Nodes")
    }

    fn elements(&self, row: &mut ElementRow, blocks: &[ElementBlock], run: &Run) -> Result<()> {
        let Layout { curves, .. } = self.layout;
        let lines: usize = curves.iter().map(|c| c.nodes.len() - 1).sum();
        let cells = self.mesh.cell_count();
        row.text("$Elements")?;
        [curves.len() + blocks.len(), lines + cells, 1, lines + cells].iter().for_each(|n| row.size(*n));
        row.end()?;
        let mut number = cells;
        for (c, curve) in curves.iter().enumerate() {
            row.ints(&[1, c as i32 + 1, LINE]);
            row.size(curve.nodes.len() - 1);
            row.end()?;
            for pair in curve.nodes.windows(2) {
                number += 1;
                row.size(number);
                pair.iter().for_each(|v| row.size(*v as usize + 1));
                row.end()?;
            }
        }
        for ElementBlock { surface, corners, cells } in blocks {
            row.ints(&[2, *surface as i32 + 1, if *corners == 3 { TRIANGLE } else { QUADRILATERAL }]);
            row.size(cells.len());
            row.end()?;
            each_listed(self.mesh, cells, run, |number, cell| {
                row.size(number as usize + 1);
                cell.iter().for_each(|v| row.size(*v as usize + 1));
                row.end()
            })?;
        }
        row.close("Elements")
    }

    /// Version 2.2, as text. Its elements have one physical surface each: their part. An element that came once for each of
    /// several would be several elements to whoever reads the file.
    pub(super) fn write_old(&self, out: &mut dyn Write, run: &Run) -> Result<()> {
        self.check()?;
        let blocks = blocks(self.mesh, &self.layout.surfaces)?;
        let mut row = ElementRow { out, binary: false, line: WrittenLine::default() };
        row.text("$MeshFormat\n2.2 0 8\n$EndMeshFormat")?;
        self.comments(&mut row)?;
        self.names(&mut row, &self.regions.sets[..self.regions.parts])?;
        row.text(&format!("$Nodes\n{}", self.mesh.node_count()))?;
        let mut number = 0;
        each_node(self.mesh, 0..self.mesh.node_count(), run, |p: DVec3| {
            number += 1;
            row.line.whole(number).reals(p);
            row.end()
        })?;
        let lines: usize = self.layout.curves.iter().map(|c| c.nodes.len() - 1).sum();
        let cells = self.mesh.cell_count();
        row.text(&format!("$EndNodes\n$Elements\n{}", cells + lines))?;
        let mut next = cells as u64;
        for ElementBlock { surface, corners, cells } in &blocks {
            let kind = if *corners == 3 { TRIANGLE } else { QUADRILATERAL };
            let part = self.regions.part_of_face[self.layout.surfaces[*surface].label as usize] as i32 + 1;
            each_listed(self.mesh, cells, run, |number, cell| {
                row.line.whole(u64::from(number) + 1).wholes([kind, 2, part, *surface as i32 + 1]);
                row.line.wholes(cell.iter().map(|v| u64::from(*v) + 1));
                row.end()
            })?;
        }
        let names = self.curve_names();
        for (c, curve) in self.layout.curves.iter().enumerate() {
            for pair in curve.nodes.windows(2) {
                next += 1;
                row.line.whole(next).wholes([LINE, 2, names[&(&curve.labels[..], curve.rim)].0, c as i32 + 1]);
                row.line.wholes(pair.iter().map(|v| u64::from(*v) + 1));
                row.end()?;
            }
        }
        row.text("$EndElements")
    }
}

/// Cells of one surface with as many corners each: gmsh keeps one kind of element in a block.
struct ElementBlock {
    surface: usize,
    corners: usize,
    cells: Vec<u32>,
}

fn blocks(mesh: &dyn MeshView, surfaces: &[SurfaceEntity]) -> Result<Vec<ElementBlock>> {
    let mut corners = Vec::with_capacity(mesh.cell_count());
    each_cell(mesh, 0..mesh.cell_count(), &Run::new(), |cell, _| {
        if cell.len() > 4 {
            let message = "gmsh files hold triangles and quadrilaterals; write another format";
            let (number, n) = (corners.len(), cell.len());
            return Err(Error::Failed(format!("cell {number} has {n} corners, but {message}")));
        }
        corners.push(cell.len() as u8);
        Ok(())
    })?;
    let mut blocks = Vec::new();
    for (surface, entity) in surfaces.iter().enumerate() {
        for size in [3, 4] {
            let cells: Vec<u32> =
                entity.cells.iter().copied().filter(|c| usize::from(corners[*c as usize]) == size).collect();
            if !cells.is_empty() {
                blocks.push(ElementBlock { surface, corners: size, cells });
            }
        }
    }
    Ok(blocks)
}

/// Hands the listed cells to `take` with their numbers, in runs where the numbers follow each other.
pub(super) fn each_listed(
    mesh: &dyn MeshView,
    cells: &[u32],
    run: &Run,
    mut take: impl FnMut(u32, &[u32]) -> Result<()>,
) -> Result<()> {
    for stretch in cells.chunk_by(|a, b| a + 1 == *b).flat_map(|s| s.chunks(CHECK_EVERY)) {
        let mut number = stretch[0];
        each_cell(mesh, stretch[0] as usize..stretch[0] as usize + stretch.len(), run, |cell, _| {
            number += 1;
            take(number - 1, cell)
        })?;
    }
    Ok(())
}
