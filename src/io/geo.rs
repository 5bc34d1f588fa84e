//! gmsh script that fills closed shells: it merges a mesh file and says which of its surfaces bound which volume.

use std::io::Write;

use crate::error::{Error, Result};

use super::atomic::write_failed;
use super::layout::Layout;
use super::regions::RegionSets;
use super::text::escape;

/// The script for the mesh file of this name, which stands in the same folder.
///
/// # Errors
/// [`Error::Failed`] where nothing is closed; what is open beside closed shells is a warning of the caller.
pub(super) fn write(out: &mut dyn Write, mesh_file: &str, layout: &Layout, regions: &RegionSets) -> Result<()> {
    if layout.solids.is_empty() {
        let what = "the mesh has no closed shell, so there is no volume to fill; close it first (`rvachev heal`)";
        return Err(Error::Failed(what.into()));
    }
    let mut text = format!("// Fills {0}: gmsh THIS.geo -3\nMerge \"{0}\";\n", mesh_file.replace(['\\', '"'], "_"));
    let list =
        |numbers: &mut dyn Iterator<Item = u32>| numbers.map(|n| (n + 1).to_string()).collect::<Vec<_>>().join(", ");
    let mut next = 0;
    for (s, solid) in layout.solids.iter().enumerate() {
        let first = next;
        for shell in &solid.shells {
            next += 1;
            text += &format!("Surface Loop({next}) = {{{}}};\n", list(&mut shell.iter().copied()));
        }
        text += &format!("Volume({}) = {{{}}};\n", s + 1, list(&mut (first..next)));
    }
    for (k, name) in regions.volumes.iter().enumerate() {
        let solids = (0u32..).zip(&regions.volume_of_solid).filter(|(_, v)| **v as usize == k).map(|(s, _)| s);
        let name = escape(name).replace('\\', "%5C");
        text += &format!("Physical Volume(\"{name}\", {}) = {{{}}};\n", k + 1, list(&mut { solids }));
    }
    out.write_all(text.as_bytes()).map_err(write_failed)
}
