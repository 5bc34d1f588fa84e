//! Abaqus and CalculiX input: nodes, S3 shells, and for each set *ELSET, *NSET and *SURFACE; *NSET for each border of a plane figure.

use std::collections::BTreeSet;
use std::io::Write;

use crate::error::Result;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::line::WrittenLine;
use super::outline::BorderSet;
use super::sets::NamedSets;

/// Numbers to a line of a set: Abaqus takes no more.
const PER_LINE: usize = 16;
/// Characters of a number that CalculiX reads.
pub(super) const NUMBER: usize = 20;
/// Letters of a name that both codes keep.
pub(super) const LONGEST_NAME: usize = 80;

pub(super) fn write(out: &mut dyn Write, sets: &NamedSets, borders: Option<&[BorderSet]>, run: &Run) -> Result<()> {
    let mut line = WrittenLine::default();
    writeln!(out, "*HEADING\nrvachev: triangles of a surface\n*NODE, NSET=ALL_NODES").map_err(write_failed)?;
    let mut number = 0;
    each_node(sets.mesh, 0..sets.mesh.node_count(), run, |p| {
        number += 1;
        line.commas(|l| _ = l.whole(number).narrow(p, NUMBER));
        line.end(out)
    })?;
    for (k, (name, set)) in sets.named().enumerate() {
        if k < sets.regions.parts {
            writeln!(out, "*ELEMENT, TYPE=S3, ELSET={name}").map_err(write_failed)?;
            sets.each_triangle(set, run, |number, corners| {
                line.commas(|l| _ = l.whole(number + 1).wholes(corners.map(|v| v + 1)));
                line.end(out)
            })?;
        }
    }
    for (k, (name, set)) in sets.named().enumerate() {
        let (triangles, nodes) = sets.members(set, run)?;
        if k >= sets.regions.parts {
            writeln!(out, "*ELSET, ELSET={name}").map_err(write_failed)?;
            list(out, &triangles)?;
        }
        writeln!(out, "*NSET, NSET={name}").map_err(write_failed)?;
        list(out, &nodes)?;
        writeln!(out, "*SURFACE, NAME={name}, TYPE=ELEMENT\n{name}, SPOS").map_err(write_failed)?;
    }
    for border in borders.unwrap_or_default() {
        let nodes: BTreeSet<u32> = border.edges.iter().flatten().copied().collect();
        writeln!(out, "*NSET, NSET={}", border.name).map_err(write_failed)?;
        list(out, &nodes.into_iter().collect::<Vec<_>>())?;
    }
    Ok(())
}

pub(super) fn list(out: &mut dyn Write, numbers: &[u32]) -> Result<()> {
    let mut line = WrittenLine::default();
    for some in numbers.chunks(PER_LINE) {
        line.commas(|l| _ = l.wholes(some.iter().map(|v| v + 1)));
        line.end(out)?;
    }
    Ok(())
}
