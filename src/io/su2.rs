//! SU2 meshes: triangles as the markers of a boundary, without volume elements.

use std::io::Write;

use crate::error::Result;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::line::Line;
use super::sets::Sets;

/// VTK's number of the triangle, which SU2 uses.
const TRIANGLE: u8 = 5;

pub(super) fn write(out: &mut dyn Write, sets: &Sets, run: &Run) -> Result<()> {
    let mut line = Line::default();
    writeln!(out, "NDIME= 3\nNELEM= 0\nNPOIN= {}", sets.mesh.node_count()).map_err(write_failed)?;
    let mut number = 0;
    each_node(sets.mesh, 0..sets.mesh.node_count(), run, |p| {
        number += 1;
        line.reals(p).whole(number - 1).end(out)
    })?;
    writeln!(out, "NMARK= {}", sets.regions.parts).map_err(write_failed)?;
    for (name, set) in sets.parts() {
        let (triangles, _) = sets.members(set, run)?;
        writeln!(out, "MARKER_TAG= {name}\nMARKER_ELEMS= {}", triangles.len()).map_err(write_failed)?;
        sets.each_triangle(set, run, |_, corners| line.whole(TRIANGLE).wholes(corners).end(out))?;
    }
    Ok(())
}
