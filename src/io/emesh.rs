//! OpenFOAM `.eMesh`: sharp edges for snappyHexMesh to snap to.

use std::io::Write;

use rustc_hash::FxHashMap;

use crate::error::Result;
use crate::mesh::MeshView;

use super::atomic::write_failed;
use super::line::WrittenLine;
use super::sharp::SharpEdges;

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, sharp: &SharpEdges) -> Result<()> {
    let edges: Vec<[u32; 2]> = sharp.ridges.iter().map(|r| sharp.edges[*r as usize]).collect();
    let mut nodes: Vec<u32> = edges.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let number: FxHashMap<u32, usize> = nodes.iter().enumerate().map(|(i, v)| (*v, i)).collect();
    let head = "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class featureEdgeMesh;\n    object edges;\n}\n";
    let mut line = WrittenLine::default();
    writeln!(out, "{head}\n{}\n(", nodes.len()).map_err(write_failed)?;
    for v in &nodes {
        let [x, y, z] = mesh.node(*v as usize).to_array();
        line.parentheses(|l| _ = l.reals([x, y, z])).end(out)?;
    }
    writeln!(out, ")\n\n{}\n(", edges.len()).map_err(write_failed)?;
    for ends in &edges {
        line.parentheses(|l| _ = l.wholes(ends.map(|v| number[&v]))).end(out)?;
    }
    writeln!(out, ")").map_err(write_failed)
}
