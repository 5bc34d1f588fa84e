//! SU2 meshes: triangles as the markers of a boundary, without volume elements; plane figures as elements, with borders as markers.

use std::io::Write;

use super::vtu::VTK_TRIANGLE;
use crate::error::Result;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::line::WrittenLine;
use super::outline::BorderSet;
use super::sets::NamedSets;

/// VTK's number of the line.
const LINE: u8 = 3;

pub(super) fn write(out: &mut dyn Write, sets: &NamedSets, run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
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
        sets.each_triangle(set, run, |_, corners| line.whole(VTK_TRIANGLE).wholes(corners).end(out))?;
    }
    Ok(())
}

/// A plane figure: a mesh of two dimensions.
pub(super) fn write_flat(out: &mut dyn Write, sets: &NamedSets, borders: &[BorderSet], run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
    writeln!(out, "NDIME= 2\nNELEM= {}", sets.triangle_count()).map_err(write_failed)?;
    for (_, set) in sets.parts() {
        sets.each_triangle(set, run, |number, corners| {
            line.whole(VTK_TRIANGLE).wholes(corners).whole(number).end(out)
        })?;
    }
    writeln!(out, "NPOIN= {}", sets.mesh.node_count()).map_err(write_failed)?;
    let mut number = 0;
    each_node(sets.mesh, 0..sets.mesh.node_count(), run, |p| {
        number += 1;
        line.real(p.x).real(p.y).whole(number - 1).end(out)
    })?;
    writeln!(out, "NMARK= {}", borders.len()).map_err(write_failed)?;
    for border in borders {
        writeln!(out, "MARKER_TAG= {}\nMARKER_ELEMS= {}", border.name, border.edges.len()).map_err(write_failed)?;
        border.edges.iter().try_for_each(|edge| line.whole(LINE).wholes(*edge).end(out))?;
    }
    Ok(())
}
