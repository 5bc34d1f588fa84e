//! Object File Format.

use std::borrow::Cow;
use std::io::Write;

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::{MeshBuilder, UNNAMED, check_node_count, each_cell, each_node, reserve};
use super::line::WrittenLine;
use super::text::{Lines, at, count, point, quote};

/// The next line that holds something besides a comment.
fn next<'a>(lines: &mut Lines<'a>, what: &str) -> Result<(usize, Cow<'a, str>)> {
    loop {
        let (number, line) = lines.expect(what)?;
        let text = line.split('#').next().unwrap_or_default().trim();
        if !text.is_empty() {
            return Ok((number, Cow::Owned(text.to_owned())));
        }
    }
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut lines = Lines::new(bytes);
    let (number, first) = next(&mut lines, "`OFF`")?;
    let mut words = first.split_whitespace();
    let keyword = words.next().unwrap_or_default();
    // Optional letters tell of texture coordinates, colors and normals, which stand behind the coordinates and are skipped.
    let prefix = keyword
        .strip_suffix("OFF")
        .ok_or_else(|| at(number, format!("an OFF file begins with `OFF`, not {}", quote(keyword))))?;
    if !["", "C", "N", "CN", "ST", "STC", "STN", "STCN"].contains(&prefix) {
        return Err(at(number, format!("{} is a kind of OFF this program does not read", quote(keyword)))
            .with_help("three-dimensional text OFF, COFF and NOFF are read"));
    }
    let rest: Vec<&str> = words.collect();
    if rest.first().is_some_and(|w| w.eq_ignore_ascii_case("BINARY")) {
        return Err(at(number, "binary OFF is not read").with_help("convert it to text OFF or to PLY"));
    }
    let (number, counts) = if rest.is_empty() {
        next(&mut lines, "the counts of nodes and faces")?
    } else {
        (number, Cow::Owned(rest.join(" ")))
    };
    let mut words = counts.split_whitespace();
    let node_count = count(&mut words, number, "the count of nodes")?;
    let face_count = count(&mut words, number, "the count of faces")?;
    check_node_count(node_count, Place::Line(number))?;

    let mut builder = MeshBuilder::default();
    let face = builder.face(UNNAMED);
    // The shortest node is `0 0 0` and a line end, the shortest triangle `3 0 0 0` and one.
    builder.mesh.nodes.reserve(reserve(node_count, 6, lines.rest().len()));
    for i in 0..node_count {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let (number, line) = next(&mut lines, &format!("node {i} of {node_count}"))?;
        builder.mesh.nodes.push(point(&mut line.split_whitespace(), number)?);
    }
    builder.mesh.triangles.reserve(reserve(face_count, 8, lines.rest().len()));
    let mut corners = Vec::new();
    for i in 0..face_count {
        if i % CHECK_EVERY == 0 {
            run.check()?;
        }
        let (number, line) = next(&mut lines, &format!("face {i} of {face_count}"))?;
        let mut words = line.split_whitespace();
        let n = count(&mut words, number, "the count of corners")?;
        if n < 3 {
            return Err(at(number, format!("face {i} has {n} corners, a face has at least 3")));
        }
        corners.clear();
        for _ in 0..n {
            let v = count(&mut words, number, "a node number")?;
            if v >= node_count {
                return Err(at(number, format!("face {i} uses node {v}, but nodes end at {}", node_count as i64 - 1)));
            }
            corners.push(v as u32);
        }
        builder.fan(&corners, face);
    }
    if let Some((number, line)) = lines.next_filled()
        && !line.trim_start().starts_with('#')
    {
        let message = format!("{} follows the last face the file promises", quote(line.trim()));
        return Err(Error::input(Place::Line(number), message));
    }
    Ok(builder.mesh)
}

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let (nodes, cells) = (mesh.node_count(), mesh.cell_count());
    writeln!(out, "OFF\n{nodes} {cells} 0").map_err(write_failed)?;
    let mut line = WrittenLine::default();
    each_node(mesh, 0..nodes, run, |p| line.reals(p).end(out))?;
    each_cell(mesh, 0..cells, run, |cell, _| line.whole(cell.len()).wholes(cell.iter().copied()).end(out))
}
