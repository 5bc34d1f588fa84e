//! Fillings brought to the surface they stand for, where somebody knows it.

use glam::DVec3;

use super::holes::{FILLED, sizes};
use super::report::{Action, Defect, HealReport};
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::{TriMesh, intersections_among};
use crate::run::Run;

/// How far from a filling the surface is looked for, in mean lengths of the edges there: a hole of a few edges across in a
/// surface that is resolved does not bulge more.
const REACH: f64 = 2.0;

/// Rounds in which nodes of triangles that came to intersect others go back.
const ROUNDS: usize = 8;

/// Moves the nodes inside fillings to the surface. Nodes stay where a triangle would turn over or intersect another one,
/// and where no surface is found nearby. Nodes that are not new never move.
pub(super) fn onto(mesh: &mut TriMesh, oracle: &dyn SurfaceOracle, report: &mut HealReport, run: &Run) -> Result<()> {
    let Some(face) = mesh.faces.iter().position(|f| f == FILLED) else { return Ok(()) };
    let new: Vec<u32> = (0..mesh.triangles.len() as u32).filter(|t| mesh.labels[*t as usize] == face as u32).collect();
    let mut free = vec![false; mesh.nodes.len()];
    new.iter().for_each(|t| mesh.triangles[*t as usize].iter().for_each(|v| free[*v as usize] = true));
    for (tri, label) in mesh.triangles.iter().zip(&mesh.labels) {
        if *label != face as u32 {
            tri.iter().for_each(|v| free[*v as usize] = false);
        }
    }
    let mut around: Vec<(u32, u32)> =
        new.iter().flat_map(|t| mesh.triangles[*t as usize].map(|v| (v, *t))).filter(|a| free[a.0 as usize]).collect();
    around.sort_unstable();
    let (home, size) = (mesh.nodes.clone(), sizes(mesh));
    let mut moved: Vec<u32> = Vec::new();
    for corners in around.chunk_by(|a, b| a.0 == b.0) {
        run.check()?;
        let v = corners[0].0 as usize;
        let Some(foot) = oracle.project(mesh.nodes[v], REACH * size[v]) else { continue };
        let normal = |mesh: &TriMesh, t: u32| mesh.area_vector(t as usize);
        let before: Vec<DVec3> = corners.iter().map(|c| normal(mesh, c.1)).collect();
        let old = std::mem::replace(&mut mesh.nodes[v], foot.point);
        if corners.iter().zip(&before).all(|(c, n)| normal(mesh, c.1).dot(*n) > 0.0) {
            moved.push(v as u32);
        } else {
            mesh.nodes[v] = old;
        }
    }
    for round in 0..=ROUNDS {
        let pairs = intersections_among(mesh, &new, run)?;
        if pairs.is_empty() {
            break;
        }
        let mut back = vec![round == ROUNDS; mesh.nodes.len()];
        pairs.iter().flatten().flat_map(|t| mesh.triangles[*t as usize]).for_each(|v| back[v as usize] = true);
        let before = moved.len();
        moved.retain(|v| {
            if back[*v as usize] {
                mesh.nodes[*v as usize] = home[*v as usize];
            }
            !back[*v as usize]
        });
        if moved.len() == before {
            break;
        }
    }
    let places: Vec<DVec3> = moved.iter().map(|v| mesh.nodes[*v as usize]).collect();
    report.add(Defect::Hole, Action::Projected, places.len(), &places);
    Ok(())
}
