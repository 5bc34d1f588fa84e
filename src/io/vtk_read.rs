//! VTK's XML files in: polygons of `.vtp`, triangles, quadrilaterals and polygons of `.vtu`.
//!
//! Faces and groups are those of our own files: arrays of cells that are 0 or 1 are sets, and of others the first that meshers write is the
//! face, with its name where field data tell it. Points, lines and volumes are passed over; strips and curved cells are refused.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

use super::CHECK_EVERY;
use super::numbered::{Element, Numbered};
use super::threemf::{Xml, child, children, wrong};
use super::vtk_array::{Arrays, Source, tree};

/// Arrays that tell the face of a cell, as we, gmsh, meshio and VTK call them.
const LABELS: [&str; 12] = [
    "face",
    "gmsh:physical",
    "medit:ref",
    "nastran:ref",
    "su2:tag",
    "CellEntityIds",
    "PhysicalIds",
    "MaterialIDs",
    "gmsh:geometrical",
    "material",
    "region",
    "part",
];

/// Cells of a piece by number, with where their corners end.
struct PieceCells {
    corners: Vec<i64>,
    ends: Vec<i64>,
    /// VTK's types; none where all are polygons.
    types: Option<Vec<i64>>,
    /// How many cells with data stand before them.
    before: usize,
}

/// Sets and numbers of the faces of the cells of a piece.
struct CellMarks {
    /// Tags of sets, with 1 for each cell inside.
    sets: Vec<(i32, Vec<i64>)>,
    /// What faces are numbered by, and their numbers.
    label: Option<(String, Vec<i64>)>,
}

/// Reads a file whose root says `kind`: `PolyData` or `UnstructuredGrid`.
pub(super) fn read(bytes: &[u8], kind: &str, run: &Run) -> Result<TriMesh> {
    let source = Source::new(bytes)?;
    let xml = tree(&source)?;
    let root = xml.root_element();
    let arrays = Arrays::new(&source, root, kind)?;
    let grid = child(root, kind).ok_or_else(|| wrong(root, format!("it has no <{kind}>")))?;
    let names = names_of_faces(&arrays, grid)?;
    let mut raw = Numbered::default();
    for piece in children(grid).filter(|n| n.tag_name().name() == "Piece") {
        run.check()?;
        let first = raw.nodes.len();
        points(&arrays, piece, &mut raw)?;
        let cells = if kind == "PolyData" { polygons(&arrays, piece)? } else { grid_cells(&arrays, piece)? };
        let marks = marks(&arrays, piece, &mut raw, cells.before + cells.ends.len())?;
        let end = raw.nodes.len();
        let mut corners = Vec::new();
        let mut begin = 0;
        for (k, stop) in cells.ends.iter().enumerate() {
            if k % CHECK_EVERY == 0 {
                run.check()?;
            }
            let stop = usize::try_from(*stop).ok().filter(|s| (begin..=cells.corners.len()).contains(s));
            let stop =
                stop.ok_or_else(|| wrong(piece, format!("cell {k} ends before it begins, or behind all corners")))?;
            corners.clear();
            for v in &cells.corners[begin..stop] {
                let node = usize::try_from(*v).ok().and_then(|v| first.checked_add(v)).filter(|v| *v < end);
                let count = end - first;
                let node =
                    node.ok_or_else(|| wrong(piece, format!("cell {k} uses node {v}, but there are {count}")))?;
                corners.push(node as u64);
            }
            begin = stop;
            let kind = cells.types.as_ref().map_or(POLYGON, |types| types[k]);
            if is_face(&mut raw, kind, &mut corners).map_err(|what| wrong(piece, format!("cell {k} {what}")))? {
                let entity = marks.entity(&mut raw, &names, cells.before + k);
                add(&mut raw, entity, &corners);
            }
        }
    }
    raw.finish()
}

/// VTK's number of a polygon.
const POLYGON: i64 = 7;

/// Whether a cell of a type is a face; its corners are put in order. An error says what is the matter with it.
fn is_face(raw: &mut Numbered, kind: i64, corners: &mut [u64]) -> std::result::Result<bool, String> {
    let wanted = match kind {
        5 => 3,
        8 | 9 => 4,
        POLYGON => corners.len().max(3),
        6 => return Err("is a strip of triangles, which is not read".into()),
        22 | 23 | 28 | 30 | 34 | 36 | 63 | 64 | 69 | 70 | 76 | 77 => {
            return Err(format!(
                "is of type {kind}, a curved face: only triangles, quadrilaterals and polygons are read"
            ));
        }
        // Points, lines and curves.
        0..=4 | 21 | 35 | 60..=62 | 68 | 75 => {
            raw.pass_over(false);
            return Ok(false);
        }
        _ => {
            raw.pass_over(true);
            return Ok(false);
        }
    };
    if corners.len() != wanted {
        return Err(format!("of type {kind} has {} corners", corners.len()));
    }
    // A pixel goes row by row.
    if kind == 8 {
        corners.swap(2, 3);
    }
    Ok(true)
}

/// Adds a polygon; one of more than four corners as a fan around the first.
fn add(raw: &mut Numbered, entity: i32, corners: &[u64]) {
    let number = raw.elements.len() as u64;
    match corners.len() {
        3 | 4 => raw.elements.push(Element::new(number, entity, 0, corners)),
        _ => {
            let fans = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
            raw.elements.extend((number..).zip(fans).map(|(n, t)| Element::new(n, entity, 0, &t)));
        }
    }
}

fn array_of<'a>(parent: Xml<'a>, name: &str) -> Result<Xml<'a>> {
    let found = data_arrays(parent).find(|n| n.attribute("Name") == Some(name));
    found.ok_or_else(|| wrong(parent, format!("it has no array {name:?}")))
}

fn data_arrays<'a>(parent: Xml<'a>) -> impl Iterator<Item = Xml<'a>> {
    children(parent).filter(|n| n.tag_name().name() == "DataArray")
}

fn section<'a>(piece: Xml<'a>, name: &str) -> Result<Xml<'a>> {
    child(piece, name).ok_or_else(|| wrong(piece, format!("it has no <{name}>")))
}

/// A count that an attribute tells; 0 without it.
fn told(piece: Xml<'_>, name: &str) -> Result<usize> {
    let text = piece.attribute(name).unwrap_or("0").trim();
    text.parse().map_err(|_| wrong(piece, format!("{name}={text:?} is no whole number ≥ 0")))
}

fn points(arrays: &Arrays, piece: Xml<'_>, raw: &mut Numbered) -> Result<()> {
    let count = told(piece, "NumberOfPoints")?;
    let Some(array) = data_arrays(section(piece, "Points")?).next() else {
        return if count == 0 { Ok(()) } else { Err(wrong(piece, "its points have no array")) };
    };
    let numbers = arrays.reals(array)?;
    if count.checked_mul(3) != Some(numbers.len()) {
        return Err(wrong(array, format!("{} numbers are not those of {count} points", numbers.len())));
    }
    for (k, p) in numbers.as_chunks::<3>().0.iter().enumerate() {
        let p = DVec3::from_array(*p);
        if !p.is_finite() {
            return Err(wrong(array, format!("point {k} is at {p}, which is not finite")));
        }
        raw.nodes.push((raw.nodes.len() as u64, p));
    }
    Ok(())
}

fn wholes(arrays: &Arrays, array: Xml<'_>) -> Result<Vec<i64>> {
    arrays.wholes(array)?.ok_or_else(|| wrong(array, "whole numbers should stand here"))
}

/// Corners and their ends in a section, of which there must be `count`.
fn listed(arrays: &Arrays, section: Xml<'_>, count: usize) -> Result<[Vec<i64>; 2]> {
    let offsets = array_of(section, "offsets")?;
    let [corners, ends] = [wholes(arrays, array_of(section, "connectivity")?)?, wholes(arrays, offsets)?];
    if ends.len() != count {
        return Err(wrong(offsets, format!("{} numbers are not the ends of {count} cells", ends.len())));
    }
    Ok([corners, ends])
}

fn polygons(arrays: &Arrays, piece: Xml<'_>) -> Result<PieceCells> {
    if told(piece, "NumberOfStrips")? > 0 {
        return Err(wrong(piece, "strips of triangles are not read")
            .with_help("VTK's vtkTriangleFilter makes triangles of them"));
    }
    let before = told(piece, "NumberOfVerts")?.saturating_add(told(piece, "NumberOfLines")?);
    let count = told(piece, "NumberOfPolys")?;
    let [corners, ends] = match count {
        0 => [Vec::new(), Vec::new()],
        _ => listed(arrays, section(piece, "Polys")?, count)?,
    };
    Ok(PieceCells { corners, ends, types: None, before })
}

fn grid_cells(arrays: &Arrays, piece: Xml<'_>) -> Result<PieceCells> {
    let count = told(piece, "NumberOfCells")?;
    if count == 0 {
        return Ok(PieceCells { corners: Vec::new(), ends: Vec::new(), types: None, before: 0 });
    }
    let section = section(piece, "Cells")?;
    let [corners, ends] = listed(arrays, section, count)?;
    let array = array_of(section, "types")?;
    let types = wholes(arrays, array)?;
    if types.len() != count {
        return Err(wrong(array, format!("{} numbers are not the types of {count} cells", types.len())));
    }
    Ok(PieceCells { corners, ends, types: Some(types), before: 0 })
}

/// Names of numbered faces: arrays of the whole file with the number and the dimension 2.
fn names_of_faces(arrays: &Arrays, grid: Xml<'_>) -> Result<BTreeMap<i64, String>> {
    let mut names = BTreeMap::new();
    for array in child(grid, "FieldData").into_iter().flat_map(data_arrays) {
        let (Some(name), Some("2")) = (array.attribute("Name"), array.attribute("NumberOfTuples")) else { continue };
        if let Some([number, 2]) = arrays.wholes(array)?.as_deref() {
            names.entry(*number).or_insert_with(|| name.to_owned());
        }
    }
    Ok(names)
}

fn marks(arrays: &Arrays, piece: Xml<'_>, raw: &mut Numbered, cells: usize) -> Result<CellMarks> {
    let mut marks = CellMarks { sets: Vec::new(), label: None };
    let mut rank = LABELS.len();
    for array in child(piece, "CellData").into_iter().flat_map(data_arrays) {
        let name = array.attribute("Name").unwrap_or_default();
        let place = LABELS.iter().position(|l| *l == name);
        // Kinds of ghosts are called by names that begin so.
        let set = place.is_none() && array.attribute("type") == Some("UInt8") && !name.starts_with("vtk");
        if !set && place.is_none_or(|p| p >= rank) || !matches!(array.attribute("NumberOfComponents"), None | Some("1"))
        {
            continue;
        }
        let Some(values) = arrays.wholes(array)? else { continue };
        if values.len() != cells {
            return Err(wrong(array, format!("{} numbers are not those of {cells} cells", values.len())));
        }
        if let Some(place) = place {
            (rank, marks.label) = (place, Some((name.to_owned(), values)));
        } else if values.iter().all(|v| matches!(v, 0 | 1)) {
            let called = name.strip_prefix("group ").unwrap_or(name);
            marks.sets.push((raw.set(&format!("set {name}"), || called.to_owned()), values));
        }
    }
    // Our own `.vtp` files have a set for each part as well.
    if !marks.sets.is_empty() {
        marks.label.take_if(|label| label.0 == "part");
    }
    Ok(marks)
}

impl CellMarks {
    /// The entity of a cell.
    fn entity(&self, raw: &mut Numbered, names: &BTreeMap<i64, String>, cell: usize) -> i32 {
        let mut tags = Vec::new();
        if let Some((array, numbers)) = &self.label {
            let number = numbers[cell];
            let name = || names.get(&number).cloned().unwrap_or_else(|| format!("{array} {number}"));
            tags.push(raw.set(&format!("{array} {number}"), name));
        }
        tags.extend(self.sets.iter().filter(|(_, inside)| inside[cell] == 1).map(|(tag, _)| *tag));
        raw.entity(&tags)
    }
}
