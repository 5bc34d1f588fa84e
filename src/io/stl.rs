//! STL, binary and ASCII.

use std::io::Write;

use glam::{DVec3, Vec3};

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::{MeshBuilder, UNNAMED, check_node_count, each_cell, each_node, fan};
use super::line::WrittenLine;
use super::text::{Lines, at, ended, escape, point, quote, unescape};

/// Bytes of the free header.
const HEADER: usize = 80;
/// Bytes before the first triangle: the header and the count.
const START: usize = HEADER + 4;
/// Bytes of a triangle: normal, three corners, an attribute of 16 bits.
const RECORD: usize = 50;

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let claimed = bytes.get(HEADER..START).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as u64);
    let size_fits = claimed.is_some_and(|n| START as u64 + RECORD as u64 * n == bytes.len() as u64);
    // Text has no zero bytes, the numbers of a binary file practically always have some.
    if !size_fits && !bytes.contains(&0) {
        return read_ascii(bytes, run);
    }
    match claimed {
        Some(claimed) if size_fits => read_binary(bytes, claimed as usize, run),
        Some(claimed) => {
            let body = bytes.len() - START;
            let message = if claimed as usize > body / RECORD {
                format!(
                    "the file is cut off: it promises {claimed} triangles, but ends within triangle {}",
                    body / RECORD + 1
                )
            } else {
                format!(
                    "{} bytes follow the last of the {claimed} triangles the file promises",
                    body - claimed as usize * RECORD
                )
            };
            Err(Error::input(Place::Byte(HEADER as u64), message).with_help(format!(
                "a binary STL of {} triangles has {} bytes, this one has {}",
                claimed,
                START as u64 + RECORD as u64 * claimed,
                bytes.len()
            )))
        }
        None => Err(Error::input(
            Place::Byte(bytes.len() as u64),
            format!("the file is cut off: a binary STL has at least {START} bytes, this one {}", bytes.len()),
        )),
    }
}

fn read_binary(bytes: &[u8], claimed: usize, run: &Run) -> Result<TriMesh> {
    let mut builder = MeshBuilder::default();
    let face = builder.face(UNNAMED);
    builder.mesh.triangles.reserve(claimed);
    for (t, record) in bytes[START..].chunks_exact(RECORD).enumerate() {
        if t % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut corners = [0; 3];
        for (k, corner) in corners.iter_mut().enumerate() {
            let number = |axis: usize| {
                let i = 12 + 12 * k + 4 * axis;
                f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]])
            };
            let p = Vec3::new(number(0), number(1), number(2));
            if !p.is_finite() {
                let byte = START + t * RECORD + 12 + 12 * k;
                let message = format!("corner {} of triangle {} is {p}, not finite", k + 1, t + 1);
                return Err(Error::input(Place::Byte(byte as u64), message));
            }
            *corner = builder.weld(p.as_dvec3());
        }
        builder.fan(&corners, face);
    }
    check_node_count(builder.mesh.nodes.len(), Place::Unknown)?;
    Ok(builder.mesh)
}

/// The rest of the line after its first word.
fn after_keyword(line: &str) -> &str {
    let line = line.trim();
    line.find(char::is_whitespace).map_or("", |i| line[i..].trim())
}

/// The grammar is read line by line by the first word alone, since writers in use add words of their own behind it.
fn read_ascii(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut lines = Lines::new(bytes);
    let mut builder = MeshBuilder::default();
    let mut face = None;
    let mut facet: Option<Vec<u32>> = None;
    while let Some((number, line)) = lines.next_filled() {
        if number % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_lowercase();
        let Some(here) = face else {
            if keyword != "solid" {
                return Err(at(number, format!("{} stands where a `solid` should begin", quote(line.trim())))
                    .with_help("an ASCII STL begins with `solid NAME`; a binary one has 84 + 50 bytes per triangle"));
            }
            let name = after_keyword(&line);
            face = Some(builder.face(&if name.is_empty() { UNNAMED.to_owned() } else { unescape(name) }));
            continue;
        };
        match (keyword.as_str(), &mut facet) {
            ("facet", None) => facet = Some(Vec::with_capacity(3)),
            ("outer" | "endloop", Some(_)) => {}
            ("vertex", Some(corners)) => corners.push(builder.weld(point(&mut words, number)?)),
            ("endfacet", Some(corners)) => {
                if corners.len() != 3 {
                    return Err(at(number, format!("the facet that ends here has {} corners, not 3", corners.len())));
                }
                builder.fan(corners, here);
                facet = None;
            }
            ("endsolid", None) => face = None,
            _ => {
                let inside = if facet.is_some() { "a facet" } else { "a solid" };
                return Err(at(number, format!("{} has no place inside {inside}", quote(line.trim()))));
            }
        }
    }
    if facet.is_some() {
        return Err(ended(lines.number(), "the rest of a facet"));
    }
    if face.is_some() {
        return Err(ended(lines.number(), "`endsolid`"));
    }
    check_node_count(builder.mesh.nodes.len(), Place::Unknown)?;
    Ok(builder.mesh)
}

/// Unit normal that is zero for degenerate triangles, also where the area vector of huge coordinates overflows.
fn normal(corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners;
    let scale = (b - a).abs().max((c - a).abs()).max_element();
    if scale > 0.0 && scale.is_finite() {
        ((b - a) / scale).cross((c - a) / scale).normalize_or_zero()
    } else {
        DVec3::ZERO
    }
}

pub(super) fn write_binary(out: &mut dyn Write, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let mut node = 0;
    each_node(mesh, 0..mesh.node_count(), run, |p| {
        if !p.as_vec3().is_finite() {
            return Err(Error::Failed(format!(
                "binary STL stores coordinates as f32, which cannot hold node {node} at {p}; write another format"
            )));
        }
        node += 1;
        Ok(())
    })?;
    let mut triangles = 0;
    each_cell(mesh, 0..mesh.cell_count(), run, |cell, _| {
        triangles += cell.len() - 2;
        Ok(())
    })?;
    let count = u32::try_from(triangles)
        .map_err(|_| Error::Failed(format!("binary STL holds at most {} triangles, not {triangles}", u32::MAX)))?;
    let mut header = [0u8; START];
    // Not `solid`: careless readers would take the file for ASCII.
    let title = b"binary STL written by rvachev";
    header[..title.len()].copy_from_slice(title);
    header[HEADER..].copy_from_slice(&count.to_le_bytes());
    out.write_all(&header).map_err(write_failed)?;
    each_cell(mesh, 0..mesh.cell_count(), run, |cell, _| {
        for corners in fan(cell) {
            let mut record = [0u8; RECORD];
            let corners = corners.map(|v| mesh.node(v as usize));
            let rows = std::iter::once(normal(corners)).chain(corners);
            for (slot, x) in record.chunks_exact_mut(4).zip(rows.flat_map(|p| p.as_vec3().to_array())) {
                slot.copy_from_slice(&x.to_le_bytes());
            }
            out.write_all(&record).map_err(write_failed)?;
        }
        Ok(())
    })
}

pub(super) fn write_ascii(out: &mut dyn Write, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
    for (face, ranges) in mesh.cells_of_faces().into_iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        let name = escape(&mesh.face_names()[face]);
        writeln!(out, "solid {name}").map_err(write_failed)?;
        for range in ranges {
            each_cell(mesh, range, run, |cell, _| {
                for corners in fan(cell) {
                    let corners = corners.map(|v| mesh.node(v as usize));
                    let n = normal(corners);
                    line.word(" facet normal").reals(n).and().word("  outer loop").and();
                    corners.into_iter().for_each(|p| _ = line.word("   vertex").reals(p).and());
                    line.word("  endloop").and().word(" endfacet").end(out)?;
                }
                Ok(())
            })?;
        }
        writeln!(out, "endsolid {name}").map_err(write_failed)?;
    }
    Ok(())
}
