//! Meshes as 3MF: an object for each solid, faces as base materials.

use std::fmt::Write as _;
use std::io::Write;

use super::super::atomic::write_failed;
use super::super::build::{each_cell, each_node, fan};
use super::super::layout::Layout;
use super::super::text::escape;
use super::{Scaled, escaped, packed, unit_of};
use crate::error::Result;
use crate::mesh::MeshView;
use crate::run::Run;

/// The number of the list of materials; objects follow.
const MATERIALS: u32 = 1;

/// Colors of faces in turn, so that neighbors can be told apart in a viewer.
const COLORS: [&str; 8] = ["#4E79A7", "#F28E2B", "#59A14F", "#E15759", "#76B7B2", "#EDC948", "#B07AA1", "#9C755F"];

/// Writes the package of a mesh; `unit` is one that a part file knows.
pub(in crate::io) fn write(
    out: &mut dyn Write,
    mesh: &dyn MeshView,
    layout: &Layout,
    unit: Option<&str>,
    run: &Run,
) -> Result<()> {
    let Scaled { unit, transform } = unit_of(unit)?;
    let mut text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="{unit}" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<resources>
<basematerials id="{MATERIALS}">
"#
    );
    for (name, color) in mesh.face_names().iter().zip(COLORS.iter().cycle()) {
        // Writing to a string does not fail.
        let _ = writeln!(text, r#"<base name="{}" displaycolor="{color}"/>"#, escaped(&escape(name)));
    }
    text.push_str("</basematerials>\n");

    let (objects, names) = objects_of(mesh, layout);
    let mut nodes = Vec::with_capacity(mesh.node_count());
    each_node(mesh, 0..mesh.node_count(), run, |p| {
        nodes.push(p);
        Ok(())
    })?;
    // For each object its triangles with their faces.
    let mut all: Vec<Vec<[u32; 4]>> = vec![Vec::new(); names.len()];
    let mut next = 0;
    each_cell(mesh, 0..mesh.cell_count(), run, |cell, face| {
        all[objects[next] as usize].extend(fan(cell).map(|[a, b, c]| [a, b, c, face]));
        next += 1;
        Ok(())
    })?;
    let mut build = String::new();
    for (k, (triangles, name)) in all.iter().zip(&names).enumerate() {
        run.check()?;
        let id = MATERIALS + 1 + k as u32;
        let first = triangles.first().map_or(0, |t| t[3]);
        let head =
            format!(r#"<object id="{id}" type="model" name="{}" pid="{MATERIALS}" pindex="{first}">"#, escaped(name));
        let _ = writeln!(text, "{head}\n<mesh>\n<vertices>");
        let mut own: Vec<u32> = triangles.iter().flat_map(|t| t[..3].iter().copied()).collect();
        own.sort_unstable();
        own.dedup();
        for p in own.iter().map(|v| nodes[*v as usize]) {
            let _ = writeln!(text, r#"<vertex x="{:?}" y="{:?}" z="{:?}"/>"#, p.x, p.y, p.z);
        }
        text.push_str("</vertices>\n<triangles>\n");
        for [a, b, c, face] in triangles {
            let [a, b, c] = [a, b, c].map(|v| own.partition_point(|o| o < v));
            let _ = writeln!(text, r#"<triangle v1="{a}" v2="{b}" v3="{c}" pid="{MATERIALS}" p1="{face}"/>"#);
        }
        text.push_str("</triangles>\n</mesh>\n</object>\n");
        let _ = writeln!(build, r#"<item objectid="{id}"{transform}/>"#);
    }
    let _ = write!(text, "</resources>\n<build>\n{build}</build>\n</model>\n");
    out.write_all(&packed(&text)?).map_err(write_failed)
}

/// For each cell the object it is in, and the names of objects: a closed solid each, and one for what is open.
fn objects_of(mesh: &dyn MeshView, layout: &Layout) -> (Vec<u32>, Vec<String>) {
    let none = u32::MAX;
    let mut objects = vec![none; mesh.cell_count()];
    let mut names = Vec::new();
    for (s, solid) in layout.solids.iter().enumerate() {
        for surface in solid.shells.iter().flatten() {
            layout.surfaces[*surface as usize].cells.iter().for_each(|c| objects[*c as usize] = s as u32);
        }
        names.push(if layout.solids.len() == 1 { "solid".into() } else { format!("solid {}", s + 1) });
    }
    let rest = names.len() as u32;
    if objects.contains(&none) {
        objects.iter_mut().filter(|o| **o == none).for_each(|o| *o = rest);
        names.push("surface".into());
    }
    (objects, names)
}
