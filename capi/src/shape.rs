//! How a mesh bends at its nodes: curvatures, and what each node is by them; how far nodes are from a part.

use std::ffi::c_int;

use rvachev::mesh::curvature::node_curvatures;
use rvachev::pipeline;

use crate::errors::{ErrorOut, Failure, GOOD, entry, given};
use crate::mesh::{Array, RvMesh, lend};
use crate::options::{RvOptions, asked};
use crate::part::RvPart;
use crate::pass::{Out, Room};
use crate::work::work;

/// Curvatures at the nodes of a mesh.
pub struct Bends {
    /// Two numbers of each node.
    principal: Vec<f64>,
    /// One of each.
    defects: Vec<f64>,
}

/// Found once; pointers to it are good until the mesh is freed.
fn bends(mesh: &RvMesh) -> Result<&Bends, Failure> {
    if let Some(known) = mesh.bends.get() {
        return Ok(known);
    }
    let all = work(None, 0, |run| Ok(node_curvatures(mesh.mesh(), run)?))?;
    let made = Bends {
        principal: all.iter().flat_map(|c| c.principal).collect(),
        defects: all.iter().map(|c| c.defect).collect(),
    };
    Ok(mesh.bends.get_or_init(|| made))
}

/// Principal curvatures at the nodes, 1 over length, the larger one first.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_curvatures(
    mesh: Option<&RvMesh>,
    principal: Array<'_, f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(principal, count, error, || {
        let all = &bends(given(mesh, "mesh")?)?.principal;
        Ok((all.as_ptr(), all.len() / 2))
    })
}

/// Angle defects at the nodes, radians.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_angle_defects(
    mesh: Option<&RvMesh>,
    radians: Array<'_, f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(radians, count, error, || {
        let all = &bends(given(mesh, "mesh")?)?.defects;
        Ok((all.as_ptr(), all.len()))
    })
}

/// What each node is by curvature: 0 regular, 1 on a crease, 2 a corner.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_node_classes(
    mesh: Option<&RvMesh>,
    classes: Array<'_, u8>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(classes, count, error, || {
        let mesh = given(mesh, "mesh")?;
        if mesh.classes.get().is_none() {
            let found = work(None, 0, |run| Ok(pipeline::node_classes(mesh.mesh(), run)?))?;
            let _ = mesh.classes.set(found);
        }
        let all = mesh.classes.get().map_or(&[][..], |all| all);
        Ok((all.as_ptr(), all.len()))
    })
}

/// How far each node is from the surface of a part, into room of the caller's; infinite where it is far away.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_distances(
    mesh: Option<&RvMesh>,
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    distances: Room<f64>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let (mesh, part) = (given(mesh, "mesh")?, given(part, "part")?.part());
        let asked = asked(options);
        distances.needed(mesh.mesh().nodes.len(), "distances")?;
        let found =
            work(asked.run.as_ref(), asked.threads, |run| Ok(pipeline::distances_to(mesh.mesh(), &part, run)?))?;
        distances.fill(&found);
        Ok(GOOD)
    })
}
