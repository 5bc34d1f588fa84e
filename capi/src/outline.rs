//! The borders of plane figures: closed lines of edges, each edge with its border.

use std::ffi::{c_char, c_int};

use rvachev::io::ClosedLine;

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, slot, usage};
use crate::mesh::{RvMesh, lend, many, nth};
use crate::pass::Out;

fn contours(mesh: Option<&RvMesh>) -> Result<&[ClosedLine], Failure> {
    Ok(given(mesh, "mesh")?.outline().map_or(&[][..], |o| &o.contours))
}

fn contour(mesh: Option<&RvMesh>, index: usize) -> Result<&ClosedLine, Failure> {
    let all = contours(mesh)?;
    all.get(index).ok_or_else(|| usage(format!("there is no contour {index}, only {}", all.len())))
}

/// How many closed lines the borders of a plane figure are; 0 for what is no figure.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_contour_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(count, 0, "count")?;
        out.write(contours(mesh)?.len());
        Ok(GOOD)
    })
}

/// The nodes of a closed line, from 0, each once, with the figure on the left.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_contour(
    mesh: Option<&RvMesh>,
    index: usize,
    nodes: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(nodes, count, error, || {
        let line = contour(mesh, index)?;
        Ok((line.nodes.as_ptr(), line.nodes.len()))
    })
}

/// For each node of a closed line the border that the edge from it to the next one is of.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_contour_borders(
    mesh: Option<&RvMesh>,
    index: usize,
    borders: Out<'_, *const u32>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(borders, count, error, || {
        let line = contour(mesh, index)?;
        Ok((line.borders.as_ptr(), line.borders.len()))
    })
}

/// How many borders there are.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_border_count(mesh: Option<&RvMesh>, count: Out<'_, usize>, error: ErrorOut<'_>) -> c_int {
    entry(error, || many(&given(mesh, "mesh")?.borders, count))
}

/// The name of a border, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_border_name(
    mesh: Option<&RvMesh>,
    index: usize,
    name: Out<'_, *const c_char>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || nth(&given(mesh, "mesh")?.borders, index, name, "border"))
}
