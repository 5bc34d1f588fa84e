//! Prisms and hexahedra out: VTU, gmsh MSH 4.1 and 2.2, Abaqus and CalculiX INP, each with the boundary by name.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::mesh::{Hexahedra, OuterSide, Prisms, side_of};
use crate::numeric::NONE;
use crate::run::Run;
use crate::spatial::Aabb;

use super::atomic::{write_atomic, write_failed};
use super::inp::{LONGEST_NAME, NUMBER, list};
use super::line::WrittenLine;
use super::msh::{ElementRow, QUADRILATERAL, TRIANGLE};
use super::regions::clean;
use super::text::escape;
use super::vtu::{Arrays, VTK_QUAD, VTK_TRIANGLE};
use super::{CHECK_EVERY, Encoding, Format, WriteOptions, Written};

/// VTK's number of the wedge.
const VTK_WEDGE: u8 = 13;
/// gmsh's number of the prism of six nodes.
const PRISM: i32 = 6;
/// VTK's number of the hexahedron.
const VTK_HEXAHEDRON: u8 = 12;
/// gmsh's number of the hexahedron of eight nodes.
const HEXAHEDRON: i32 = 5;
/// What all cells are called together.
const VOLUME: &str = "volume";

/// Writes prisms in the format of the path's extension: `vtu`, `msh` or `inp`. The file appears complete or not at all.
///
/// Of the options, the encoding and the version of MSH count. Prisms come in their order; MSH and INP call them `volume`.
/// - VTU: cells of type 13, then the boundary's triangles and quadrilaterals. The array `face` has the number of a boundary cell's
///   name, and -1 for prisms; comments tell the names.
/// - MSH: elements of type 6 in a physical volume, and a physical surface for each name.
/// - INP: elements C3D6, and for each name *NSET and *SURFACE. [`Written::renamed`] tells names with other characters than letters,
///   digits and `_`, which become `_`.
///
/// # Errors
/// [`Error::Usage`] for another format or a folder that is missing; [`Error::Input`] for prisms that are none, name nodes, prisms or names
/// there are not, or have a node that is not finite; [`Error::Io`]; [`Error::Cancelled`].
pub fn write_prisms(path: &Path, prisms: &Prisms, options: &WriteOptions, run: &Run) -> Result<Written> {
    let cells = prisms.cells.iter().map(<[u32; 6]>::as_slice).collect();
    write_cells(path, PrismCells::new(&prisms.nodes, cells, &prisms.outer, &prisms.names)?, options, run)
}

/// Writes hexahedra, and the prisms beside them, as [`write_prisms`] does: cells of type 12 in VTU, elements of type 5 in MSH, C3D8 in INP.
///
/// # Errors
/// As [`write_prisms`].
pub fn write_hexahedra(path: &Path, mesh: &Hexahedra, options: &WriteOptions, run: &Run) -> Result<Written> {
    let hexahedra = mesh.hexahedra.iter().map(<[u32; 8]>::as_slice);
    let cells = hexahedra.chain(mesh.prisms.iter().map(<[u32; 6]>::as_slice)).collect();
    write_cells(path, PrismCells::new(&mesh.nodes, cells, &mesh.outer, &mesh.names)?, options, run)
}

fn write_cells(path: &Path, whole: PrismCells, options: &WriteOptions, run: &Run) -> Result<Written> {
    let format = Format::from_path(path)?;
    if !matches!(format, Format::Vtu | Format::Msh | Format::Inp) {
        return Err(Error::Usage(format!("{}: prisms are written as vtu, msh or inp", path.display())));
    }
    let mut written = Written::default();
    write_atomic(path, |out| match format {
        Format::Vtu => whole.vtu(out, options.encoding != Encoding::Text, run),
        Format::Msh if options.old_msh => whole.old_msh(out, run),
        Format::Msh => whole.msh(out, options.encoding == Encoding::Binary, run),
        _ => {
            let names = whole.names.iter().map(String::as_str).chain([VOLUME]);
            let cleaned = clean(names, LONGEST_NAME);
            written.renamed = cleaned.changed;
            whole.inp(out, &cleaned.names, run)
        }
    })?;
    Ok(written)
}

/// Calls `one` for each of some things, and looks at the cancel flag now and then.
fn each<T>(list: impl IntoIterator<Item = T>, run: &Run, mut one: impl FnMut(T) -> Result<()>) -> Result<()> {
    for (k, x) in list.into_iter().enumerate() {
        if k % CHECK_EVERY == 0 {
            run.check()?;
        }
        one(x)?;
    }
    Ok(())
}

/// The outer sides of one name.
struct NamedSides<'a> {
    label: usize,
    sides: Vec<&'a OuterSide>,
}

/// Cells with their boundary by name.
struct PrismCells<'a> {
    nodes: &'a [DVec3],
    /// Corners of hexahedra, then of prisms.
    cells: Vec<&'a [u32]>,
    outer: &'a [OuterSide],
    names: &'a [String],
    /// Names that have a side.
    parts: Vec<NamedSides<'a>>,
}

impl<'a> PrismCells<'a> {
    /// Refuses cells that cannot be walked through.
    fn new(nodes: &'a [DVec3], cells: Vec<&'a [u32]>, outer: &'a [OuterSide], names: &'a [String]) -> Result<Self> {
        let bad = |item: String, what: &str| Err(Error::input(Place::Item(item), what));
        if cells.is_empty() {
            return Err(Error::input(Place::Unknown, "there is no cell to write"));
        }
        if let Some(v) = nodes.iter().position(|p| !p.is_finite()) {
            return bad(format!("node {v}"), "its coordinates are not finite");
        }
        if let Some(j) = cells.iter().position(|c| c.iter().any(|v| *v as usize >= nodes.len())) {
            return bad(format!("cell {j}"), "it names a node that is not there");
        }
        let last = |cell: &&[u32]| if cell.len() == 8 { 5 } else { 4 };
        let lost = |o: &OuterSide| {
            cells.get(o.cell as usize).is_none_or(|c| o.side > last(c)) || o.label as usize >= names.len()
        };
        if let Some(k) = outer.iter().position(lost) {
            return bad(format!("outer side {k}"), "it names a cell, a side or a name that is not there");
        }
        let mut parts: Vec<NamedSides> =
            (0..names.len()).map(|label| NamedSides { label, sides: Vec::new() }).collect();
        outer.iter().for_each(|o| parts[o.label as usize].sides.push(o));
        parts.retain(|p| !p.sides.is_empty());
        Ok(Self { nodes, cells, outer, names, parts })
    }

    fn corners(&self, outer: &OuterSide) -> impl ExactSizeIterator<Item = u32> + use<'a> {
        side_of(self.cells[outer.cell as usize], outer.side)
    }

    /// The hexahedra, and the prisms.
    fn kinds(&self) -> [&[&'a [u32]]; 2] {
        let (hexahedra, prisms) = self.cells.split_at(self.cells.partition_point(|c| c.len() == 8));
        [hexahedra, prisms]
    }

    fn vtu(&self, out: &mut dyn Write, binary: bool, run: &Run) -> Result<()> {
        let Self { nodes, cells, outer, names, .. } = self;
        let count = cells.len() + outer.len();
        let corners: usize = cells.iter().map(|c| c.len()).chain(outer.iter().map(|o| self.corners(o).len())).sum();
        let mut a = Arrays { out, binary, run };
        a.line("<?xml version=\"1.0\"?>")?;
        a.line(r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#)?;
        a.line("<UnstructuredGrid>")?;
        a.names(names)?;
        a.line(&format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">\n<Points>", nodes.len()))?;
        let three = r#"type="Float64" Name="Points" NumberOfComponents="3""#;
        let places = |run: &Run, take: &mut dyn FnMut(f64) -> Result<()>| {
            each(*nodes, run, |p| p.to_array().into_iter().try_for_each(&mut *take))
        };
        a.array(three, 3 * nodes.len(), places, |line, x: f64| _ = line.real(x), f64::to_le_bytes)?;
        a.line("</Points>\n<Cells>")?;
        let whole = |line: &mut WrittenLine, v: i64| _ = line.whole(v);
        let connectivity = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
            // The first triangle of VTK's wedge looks away from the second.
            each(cells, run, |cell| {
                let order: &[usize] = if cell.len() == 8 { &[0, 1, 2, 3, 4, 5, 6, 7] } else { &[0, 2, 1, 3, 5, 4] };
                order.iter().try_for_each(|k| take(i64::from(cell[*k])))
            })?;
            each(*outer, run, |o| self.corners(o).try_for_each(|v| take(i64::from(v))))
        };
        a.array(r#"type="Int64" Name="connectivity""#, corners, connectivity, whole, i64::to_le_bytes)?;
        let offsets = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
            let mut end = 0;
            let sizes = cells.iter().map(|c| c.len() as i64).chain(outer.iter().map(|o| self.corners(o).len() as i64));
            each(sizes, run, |n| {
                end += n;
                take(end)
            })
        };
        a.array(r#"type="Int64" Name="offsets""#, count, offsets, whole, i64::to_le_bytes)?;
        let solid = |c: &&[u32]| if c.len() == 8 { VTK_HEXAHEDRON } else { VTK_WEDGE };
        let kind = |o: &OuterSide| if self.corners(o).len() == 3 { VTK_TRIANGLE } else { VTK_QUAD };
        let types = |run: &Run, take: &mut dyn FnMut(u8) -> Result<()>| {
            each(cells.iter().map(solid).chain(outer.iter().map(kind)), run, take)
        };
        a.array(r#"type="UInt8" Name="types""#, count, types, |line, v| _ = line.whole(v), u8::to_le_bytes)?;
        a.line("</Cells>\n<CellData Scalars=\"face\">")?;
        let labels = |run: &Run, take: &mut dyn FnMut(i64) -> Result<()>| {
            each(cells.iter().map(|_| -1).chain(outer.iter().map(|o| i64::from(o.label))), run, take)
        };
        a.array(r#"type="Int64" Name="face""#, count, labels, whole, i64::to_le_bytes)?;
        a.line("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
    }

    /// Names for MSH: surfaces by their labels plus one, and the volume.
    fn physical_names(&self, row: &mut ElementRow) -> Result<()> {
        row.text(&format!("$PhysicalNames\n{}", self.parts.len() + 1))?;
        for part in &self.parts {
            row.text(&format!("2 {} \"{}\"", part.label + 1, escape(&self.names[part.label])))?;
        }
        row.text(&format!("3 1 \"{VOLUME}\"\n$EndPhysicalNames"))
    }

    fn msh(&self, out: &mut dyn Write, binary: bool, run: &Run) -> Result<()> {
        let mut row = ElementRow { out, binary, line: WrittenLine::default() };
        row.head()?;
        self.physical_names(&mut row)?;
        self.entities(&mut row)?;
        self.nodes(&mut row, run)?;
        self.elements(&mut row, run)
    }

    /// A surface for each name, and the volume between them.
    fn entities(&self, row: &mut ElementRow) -> Result<()> {
        let tags = self.parts.iter().map(|p| p.label as i32 + 1);
        row.text("$Entities")?;
        [0, 0, self.parts.len(), 1].iter().for_each(|n| row.size(*n));
        row.end()?;
        for part in &self.parts {
            let corners = part.sides.iter().flat_map(|o| self.corners(o));
            let tag = part.label as i32 + 1;
            row.int(tag);
            row.bounds(&Aabb::around(corners.map(|v| self.nodes[v as usize])));
            row.list(&[tag]);
            row.list(&[]);
            row.end()?;
        }
        row.int(1);
        row.bounds(&Aabb::around(self.nodes.iter().copied()));
        row.list(&[1]);
        row.list(&tags.collect::<Vec<_>>());
        row.end()?;
        row.close("Entities")
    }

    /// Nodes stand with the first surface they lie on, those of none with the volume.
    fn nodes(&self, row: &mut ElementRow, run: &Run) -> Result<()> {
        let Self { nodes, outer, .. } = self;
        let mut owners = vec![NONE; nodes.len()];
        for o in *outer {
            self.corners(o).for_each(|v| owners[v as usize] = owners[v as usize].min(o.label));
        }
        let mut blocks: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        owners.iter().enumerate().for_each(|(v, owner)| blocks.entry(*owner).or_default().push(v));
        row.text("$Nodes")?;
        [blocks.len(), nodes.len(), 1, nodes.len()].iter().for_each(|n| row.size(*n));
        row.end()?;
        for (owner, list) in blocks {
            row.ints(&if owner == NONE { [3, 1, 0] } else { [2, owner as i32 + 1, 0] });
            row.size(list.len());
            row.end()?;
            each(&list, run, |v| {
                row.size(v + 1);
                row.end()
            })?;
            each(&list, run, |v| {
                nodes[*v].to_array().iter().for_each(|x| row.real(*x));
                row.end()
            })?;
        }
        row.close("Nodes")
    }

    /// A name's sides of three corners, and of four: gmsh keeps one kind of element in a block.
    fn blocks(&self) -> Vec<SideBlock<'_>> {
        let kinds = [TRIANGLE, QUADRILATERAL];
        let both = self.parts.iter().flat_map(|part| kinds.map(|kind| (part, kind)));
        let blocks = both.map(|(part, kind)| {
            let fits = |o: &&&OuterSide| (self.corners(o).len() == 3) == (kind == TRIANGLE);
            SideBlock { label: part.label, kind, sides: part.sides.iter().filter(fits).copied().collect() }
        });
        blocks.filter(|b| !b.sides.is_empty()).collect()
    }

    fn elements(&self, row: &mut ElementRow, run: &Run) -> Result<()> {
        let Self { cells, outer, .. } = self;
        let (blocks, all) = (self.blocks(), cells.len() + outer.len());
        let solids: Vec<_> = self.kinds().into_iter().zip([HEXAHEDRON, PRISM]).filter(|s| !s.0.is_empty()).collect();
        row.text("$Elements")?;
        [blocks.len() + solids.len(), all, 1, all].iter().for_each(|n| row.size(*n));
        row.end()?;
        let mut number = 0;
        let mut element = |row: &mut ElementRow, corners: &mut dyn Iterator<Item = u32>| {
            number += 1;
            row.size(number);
            corners.for_each(|v| row.size(v as usize + 1));
            row.end()
        };
        for (list, kind) in solids {
            row.ints(&[3, 1, kind]);
            row.size(list.len());
            row.end()?;
            each(list, run, |cell| element(row, &mut cell.iter().copied()))?;
        }
        for block in &blocks {
            row.ints(&[2, block.label as i32 + 1, block.kind]);
            row.size(block.sides.len());
            row.end()?;
            each(&block.sides, run, |o| element(row, &mut self.corners(o)))?;
        }
        row.close("Elements")
    }

    /// Version 2.2, as text.
    fn old_msh(&self, out: &mut dyn Write, run: &Run) -> Result<()> {
        let Self { nodes, cells, outer, .. } = self;
        let mut row = ElementRow { out, binary: false, line: WrittenLine::default() };
        row.text("$MeshFormat\n2.2 0 8\n$EndMeshFormat")?;
        self.physical_names(&mut row)?;
        row.text(&format!("$Nodes\n{}", nodes.len()))?;
        each(nodes.iter().enumerate(), run, |(v, p)| {
            row.line.whole(v + 1).reals(*p);
            row.end()
        })?;
        row.text(&format!("$EndNodes\n$Elements\n{}", cells.len() + outer.len()))?;
        each(cells.iter().enumerate(), run, |(j, cell)| {
            let kind = if cell.len() == 8 { HEXAHEDRON } else { PRISM };
            row.line.whole(j + 1).wholes([kind, 2, 1, 1]).wholes(cell.iter().map(|v| u64::from(*v) + 1));
            row.end()
        })?;
        let mut number = cells.len();
        for block in self.blocks() {
            each(block.sides, run, |o| {
                number += 1;
                let tag = block.label as i32 + 1;
                row.line.whole(number).wholes([block.kind, 2, tag, tag]);
                row.line.wholes(self.corners(o).map(|v| u64::from(v) + 1));
                row.end()
            })?;
        }
        row.text("$EndElements")
    }

    /// `names` are those of the boundary as INP can hold them, then that of the volume.
    fn inp(&self, out: &mut dyn Write, names: &[String], run: &Run) -> Result<()> {
        let nodes = self.nodes;
        let (volume, mut line) = (names.last().map_or(VOLUME, String::as_str), WrittenLine::default());
        writeln!(out, "*HEADING\nrvachev: cells over triangles\n*NODE, NSET=ALL_NODES").map_err(write_failed)?;
        each(nodes.iter().enumerate(), run, |(v, p)| {
            line.commas(|l| _ = l.whole(v + 1).narrow(*p, NUMBER));
            line.end(out)
        })?;
        let mut number = 0;
        for (list, kind) in self.kinds().into_iter().zip(["C3D8", "C3D6"]).filter(|s| !s.0.is_empty()) {
            writeln!(out, "*ELEMENT, TYPE={kind}, ELSET={volume}").map_err(write_failed)?;
            each(list, run, |cell| {
                number += 1;
                line.commas(|l| _ = l.whole(number).wholes(cell.iter().map(|v| u64::from(*v) + 1)));
                line.end(out)
            })?;
        }
        for part in &self.parts {
            let name = &names[part.label];
            let on: BTreeSet<u32> = part.sides.iter().flat_map(|o| self.corners(o)).collect();
            writeln!(out, "*NSET, NSET={name}").map_err(write_failed)?;
            list(out, &on.into_iter().collect::<Vec<_>>())?;
            writeln!(out, "*SURFACE, NAME={name}, TYPE=ELEMENT").map_err(write_failed)?;
            // Sides of both codes: S1 the bottom, S2 the top, from S3 on the walls.
            each(&part.sides, run, |o| {
                line.commas(|l| _ = l.whole(o.cell + 1).word(&format!("S{}", o.side + 1)));
                line.end(out)
            })?;
        }
        Ok(())
    }
}

/// Outer sides of one name with as many corners each.
struct SideBlock<'a> {
    label: usize,
    kind: i32,
    sides: Vec<&'a OuterSide>,
}
