//! Numbers on a regular grid: VTK image data, and arrays of NumPy.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use super::atomic::{check_folder, write_atomic, write_failed};
use super::vtu::attribute;
use crate::error::{Error, Result};
use crate::run::Run;

/// Numbers that become bytes between two looks at the cancel flag.
const AT_A_TIME: usize = 1 << 16;

/// Samples of a function in the nodes of a regular grid, x fastest, then y, then z.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledGrid {
    /// The node with the smallest coordinates.
    pub origin: DVec3,
    /// The distance of neighboring nodes, the same along all axes. Node `i j k` is at `origin + step * (i, j, k)`, as rounded.
    pub step: f64,
    /// Nodes along x, y and z.
    pub nodes: [usize; 3],
    /// One value a node.
    pub values: Vec<f64>,
    /// One gradient a node, where asked for.
    pub gradients: Option<Vec<DVec3>>,
    /// One label a node, where asked for: an index into `names`, -1 for none.
    pub faces: Option<Vec<i32>>,
    /// Names of faces.
    pub names: Vec<String>,
}

impl SampledGrid {
    /// Where the node of this number is, computed as VTK does.
    pub fn node(&self, number: usize) -> DVec3 {
        let [nx, ny, _] = self.nodes;
        let at = [number % nx, number / nx % ny, number / nx / ny];
        DVec3::from_array(std::array::from_fn(|k| self.origin[k] + at[k] as f64 * self.step))
    }

    /// How many values are NaN or infinite, and where the first of them is.
    pub fn not_finite(&self) -> Option<(usize, DVec3)> {
        let bad = |i: &usize| {
            !(self.values[*i].is_finite() && self.gradients.as_ref().is_none_or(|list| list[*i].is_finite()))
        };
        let first = (0..self.values.len()).find(bad)?;
        Some(((first..self.values.len()).filter(bad).count(), self.node(first)))
    }
}

/// A file format for grids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridFormat {
    /// VTK image data in XML with raw binary arrays, extension `vti`.
    Vti,
    /// NumPy array of values alone, extension `npy`: float64 of shape (nz, ny, nx).
    Npy,
}

impl GridFormat {
    /// The format an extension stands for.
    ///
    /// Errors: [`Error::Usage`] if it stands for none, or the folder does not exist.
    pub fn from_path(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let format = match extension.as_str() {
            "vti" => GridFormat::Vti,
            "npy" => GridFormat::Npy,
            _ => {
                let what = "grids are written as .vti or .npy";
                return Err(Error::Usage(format!("{what}, not as {}", path.display())));
            }
        };
        check_folder(path)?;
        Ok(format)
    }
}

/// Writes a grid; the extension tells the format. Either the whole file is written or none.
///
/// Errors: see [`GridFormat::from_path`]; [`Error::Io`]; cancellation.
pub fn write_grid(path: &Path, grid: &SampledGrid, run: &Run) -> Result<()> {
    let format = GridFormat::from_path(path)?;
    write_atomic(path, |out| match format {
        GridFormat::Vti => vti(out, grid, run),
        GridFormat::Npy => npy(out, grid, run),
    })
}

fn numbers<T: Copy, const N: usize>(
    out: &mut dyn Write,
    list: &[T],
    bytes: impl Fn(T) -> [u8; N],
    run: &Run,
) -> Result<()> {
    for some in list.chunks(AT_A_TIME) {
        run.check()?;
        let block: Vec<u8> = some.iter().flat_map(|v| bytes(*v)).collect();
        out.write_all(&block).map_err(write_failed)?;
    }
    Ok(())
}

fn vti(out: &mut dyn Write, grid: &SampledGrid, run: &Run) -> Result<()> {
    let count = grid.values.len() as u64;
    let [i, j, k] = grid.nodes.map(|n| n.saturating_sub(1));
    let extent = format!("0 {i} 0 {j} 0 {k}");
    let mut buffer = zmij::Buffer::new();
    let [x, y, z, h] = [grid.origin.x, grid.origin.y, grid.origin.z, grid.step].map(|v| buffer.format(v).to_string());
    let mut head = format!(
        r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<ImageData WholeExtent="{extent}" Origin="{x} {y} {z}" Spacing="{h} {h} {h}">
"#
    );
    if grid.faces.is_some() {
        for (i, name) in grid.names.iter().enumerate() {
            head += &format!("<!-- face {i}: {} -->\n", attribute(name).replace('-', "‐"));
        }
        // Strings are numbers of bytes, each with a zero at its end.
        let codes = grid.names.iter().flat_map(|name| name.bytes().filter(|b| *b != 0).chain([0]));
        let codes: Vec<String> = codes.map(|b| b.to_string()).collect();
        head += &format!(
            "<FieldData>\n<Array type=\"String\" Name=\"face_names\" NumberOfTuples=\"{}\" format=\"ascii\">\n{}\n</Array>\n</FieldData>\n",
            grid.names.len(),
            codes.join(" ")
        );
    }
    let vectors = if grid.gradients.is_some() { " Vectors=\"gradient\"" } else { "" };
    head += &format!("<Piece Extent=\"{extent}\">\n<PointData Scalars=\"value\"{vectors}>\n");
    let mut offset = 0;
    let mut array = |what: &str, size: u64| {
        head += &format!("<DataArray {what} format=\"appended\" offset=\"{offset}\"/>\n");
        offset += 8 + size;
    };
    array(r#"type="Float64" Name="value""#, 8 * count);
    if grid.gradients.is_some() {
        array(r#"type="Float64" Name="gradient" NumberOfComponents="3""#, 24 * count);
    }
    if grid.faces.is_some() {
        array(r#"type="Int32" Name="face""#, 4 * count);
    }
    head += "</PointData>\n<CellData/>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    out.write_all(head.as_bytes()).map_err(write_failed)?;
    let size = |out: &mut dyn Write, n: u64| out.write_all(&n.to_le_bytes()).map_err(write_failed);
    size(out, 8 * count)?;
    numbers(out, &grid.values, f64::to_le_bytes, run)?;
    if let Some(gradients) = &grid.gradients {
        size(out, 24 * count)?;
        let bytes = |g: DVec3| -> [u8; 24] {
            let all = g.to_array().map(f64::to_le_bytes);
            std::array::from_fn(|i| all[i / 8][i % 8])
        };
        numbers(out, gradients, bytes, run)?;
    }
    if let Some(faces) = &grid.faces {
        size(out, 4 * count)?;
        numbers(out, faces, i32::to_le_bytes, run)?;
    }
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n").map_err(write_failed)
}

fn npy(out: &mut dyn Write, grid: &SampledGrid, run: &Run) -> Result<()> {
    let [nx, ny, nz] = grid.nodes;
    let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    // The numbers begin at a multiple of 64, and the header ends with an end of line.
    /// Bytes before the text: the magic number, the version and the length of the text.
    const BEFORE: usize = 10;
    let whole = (BEFORE + text.len() + 1).next_multiple_of(64) - BEFORE;
    text += &" ".repeat(whole - 1 - text.len());
    text.push('\n');
    let length = u16::try_from(text.len()).map_err(|_| Error::Failed("the header of the array is too long".into()))?;
    let head = [&b"\x93NUMPY\x01\x00"[..], &length.to_le_bytes(), text.as_bytes()].concat();
    out.write_all(&head).map_err(write_failed)?;
    numbers(out, &grid.values, f64::to_le_bytes, run)
}
