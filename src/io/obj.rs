//! Wavefront OBJ.
//!
//! `tobj` does the parsing, but it hands every group its own copy of the nodes, knows no line numbers and stumbles over
//! wild texture indices. So a first pass keeps only nodes, polygons and group changes, checks and resolves the indices
//! while it still knows the lines, and lets the number of each node ride along as its vertex color: from that the mesh
//! over all groups is put together again.

use std::io::Write;

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

use super::CHECK_EVERY;
use super::atomic::write_failed;
use super::build::{MeshBuilder, UNNAMED, check_node_count, each_cell, each_node};
use super::line::WrittenLine;
use super::text::{Lines, at, escape, point, quote, unescape};

/// What the first pass leaves.
struct Distilled {
    /// `v`, `o` and `f` lines only; objects are called by their face's number.
    text: String,
    nodes: usize,
    builder: MeshBuilder,
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let Distilled { text, nodes, mut builder } = distill(bytes, run)?;
    let options = tobj::LoadOptions { single_index: false, triangulate: true, ..Default::default() };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials)
        .map_err(|e| Error::input(Place::Unknown, format!("this is no OBJ file: {e}")))?;

    let mut places = vec![DVec3::NAN; nodes];
    for model in &models {
        run.check()?;
        let face = model.name.parse().unwrap_or(0);
        let mesh = &model.mesh;
        let numbers: Vec<u32> = mesh.vertex_color.chunks_exact(3).map(|c| c[0] as u32).collect();
        for (number, p) in numbers.iter().zip(mesh.positions.chunks_exact(3)) {
            places[*number as usize] = DVec3::new(p[0], p[1], p[2]);
        }
        for t in mesh.indices.chunks_exact(3) {
            builder.fan(&[t[0], t[1], t[2]].map(|i| numbers[i as usize]), face);
        }
    }
    builder.mesh.nodes = places;
    builder.mesh.drop_unused_nodes();
    Ok(builder.mesh)
}

fn distill(bytes: &[u8], run: &Run) -> Result<Distilled> {
    let mut lines = Lines::new(bytes);
    let mut builder = MeshBuilder::default();
    let mut nodes = String::with_capacity(bytes.len());
    let mut polygons = String::with_capacity(bytes.len() / 2);
    let mut count = 0usize;
    let mut face = None;
    let mut next_name = UNNAMED.to_owned();
    // The largest index and where it stands: a polygon may come before its nodes.
    let mut largest = (0, 0);
    while let Some((number, line)) = lines.next_filled() {
        if number % CHECK_EVERY == 0 {
            run.check()?;
        }
        let mut line = line.into_owned();
        while line.ends_with('\\') {
            line.pop();
            line.push(' ');
            match lines.next_line() {
                Some((_, more)) => line.push_str(&more),
                None => break,
            }
        }
        let statement = line.split('#').next().unwrap_or_default();
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => {
                let p = point(&mut words, number)?;
                nodes.push_str(&format!("v {:?} {:?} {:?} {count} 0 0\n", p.x, p.y, p.z));
                count += 1;
            }
            Some("g" | "o") => {
                // Names may hold a `#`, so they are taken from the whole line.
                let name = line.trim_start()[1..].trim();
                next_name = if name.is_empty() { UNNAMED.to_owned() } else { unescape(name) };
                face = None;
            }
            Some("f") => {
                if face.is_none() {
                    let new = builder.face(&next_name);
                    polygons.push_str(&format!("o {new}\n"));
                    face = Some(new);
                }
                polygons.push('f');
                let mut corners = 0;
                for word in words {
                    let index = node_index(word, count, number)?;
                    if index > largest.0 {
                        largest = (index, number);
                    }
                    polygons.push_str(&format!(" {index}"));
                    corners += 1;
                }
                polygons.push('\n');
                if corners < 3 {
                    return Err(at(number, format!("the face has {corners} corners, a face has at least 3")));
                }
            }
            _ => {}
        }
    }
    check_node_count(count, Place::Unknown)?;
    if largest.0 > count {
        return Err(at(largest.1, format!("the face uses node {}, but the file has {count}", largest.0)));
    }
    nodes.push_str(&polygons);
    Ok(Distilled { text: nodes, nodes: count, builder })
}

/// The 1-based node index a corner such as `7/2/1` or `-1` means after `count` nodes.
fn node_index(word: &str, count: usize, line: usize) -> Result<usize> {
    let first = word.split('/').next().unwrap_or_default();
    let index: i64 = first.parse().map_err(|_| at(line, format!("{} is no node index", quote(word))))?;
    match index {
        0 => Err(at(line, "node indices begin at 1, not 0")),
        1.. => Ok(index as usize),
        _ => (count as i64)
            .checked_add(index + 1)
            .filter(|i| *i >= 1)
            .map(|i| i as usize)
            .ok_or_else(|| at(line, format!("index {index} reaches back before the first of {count} nodes"))),
    }
}

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
    each_node(mesh, 0..mesh.node_count(), run, |p| line.word("v").reals(p).end(out))?;
    for (face, ranges) in mesh.cells_of_faces().into_iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        writeln!(out, "g {}", escape(&mesh.face_names()[face])).map_err(write_failed)?;
        for range in ranges {
            each_cell(mesh, range, run, |cell, _| {
                line.word("f").wholes(cell.iter().map(|v| u64::from(*v) + 1)).end(out)
            })?;
        }
    }
    Ok(())
}
