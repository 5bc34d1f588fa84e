//! Medit `.mesh`: triangles whose references are their parts, edges along borders, ridges and corners.

use std::io::Write;

use crate::error::Result;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::line::WrittenLine;
use super::sets::NamedSets;
use super::sharp::SharpEdges;

pub(super) fn write(out: &mut dyn Write, sets: &NamedSets, sharp: &SharpEdges, run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
    writeln!(out, "MeshVersionFormatted 2\n# References of triangles:").map_err(write_failed)?;
    for (k, (name, _)) in sets.parts().enumerate() {
        writeln!(out, "# {} {name}", k + 1).map_err(write_failed)?;
    }
    writeln!(out, "Dimension 3\nVertices\n{}", sets.mesh.node_count()).map_err(write_failed)?;
    each_node(sets.mesh, 0..sets.mesh.node_count(), run, |p| line.reals(p).whole(0).end(out))?;
    writeln!(out, "Triangles\n{}", sets.triangle_count()).map_err(write_failed)?;
    for (k, (_, set)) in sets.parts().enumerate() {
        sets.each_triangle(set, run, |_, corners| line.wholes(corners.map(|v| v + 1)).whole(k + 1).end(out))?;
    }
    if !sharp.edges.is_empty() {
        writeln!(out, "Edges\n{}", sharp.edges.len()).map_err(write_failed)?;
        for (ends, curve) in sharp.edges.iter().zip(&sharp.curves) {
            line.wholes(ends.map(|v| v + 1)).whole(curve + 1).end(out)?;
        }
    }
    for (word, list) in [("Ridges", &sharp.ridges), ("Corners", &sharp.corners)] {
        if !list.is_empty() {
            writeln!(out, "{word}\n{}", list.len()).map_err(write_failed)?;
            list.iter().try_for_each(|v| line.whole(v + 1).end(out))?;
        }
    }
    writeln!(out, "End").map_err(write_failed)
}
