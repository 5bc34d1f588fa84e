//! Solids that touch themselves along edges or in points: a mesh that is a manifold has the place once for each part of the
//! inside, and its triangles would touch there. They are drawn back into the solid, by far less than any size.

use glam::DVec3;

use crate::error::Result;
use crate::mesh::{TriMesh, self_intersections};
use crate::run::Run;
use crate::spatial::triangle_distance_squared;

/// Nodes are drawn back by this share of the part's size: well above the rounding of coordinates, well below what a solver or a
/// printer tells apart.
const BACK: f64 = 1e-9;
/// What is this many times as near touches.
const NEAR: f64 = 8.0;
/// Where a line of contact ends between two nodes the next round draws back the rest.
const ROUNDS: usize = 4;

/// Draws triangles that touch others apart, each into its own side of the solid; how many nodes were moved. `scale` is the part's
/// size. Triangles that really intersect stay as they are.
///
/// Errors: cancellation.
pub(super) fn draw_apart(mesh: &mut TriMesh, scale: f64, run: &Run) -> Result<usize> {
    let near = (NEAR * BACK * scale).powi(2);
    let mut moved = vec![false; mesh.nodes.len()];
    for _ in 0..ROUNDS {
        let pairs = self_intersections(mesh, run)?;
        let mut nodes: Vec<u32> = Vec::new();
        for [t, u] in pairs {
            for (t, u) in [(t, u), (u, t)] {
                let (at, other) = (mesh.triangles[t as usize], mesh.corners(u as usize));
                let own = mesh.corners(t as usize);
                nodes.extend((0..3).filter(|k| triangle_distance_squared(own[*k], other) <= near).map(|k| at[k]));
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|v| !moved[*v as usize]);
        if nodes.is_empty() {
            break;
        }
        let mut outward = vec![DVec3::ZERO; mesh.nodes.len()];
        nodes.iter().for_each(|v| moved[*v as usize] = true);
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for v in corners.iter().filter(|v| nodes.binary_search(v).is_ok()) {
                outward[*v as usize] += mesh.area_vector(t).normalize_or_zero();
            }
        }
        for v in &nodes {
            mesh.nodes[*v as usize] -= outward[*v as usize].normalize_or_zero() * (BACK * scale);
        }
    }
    Ok(moved.into_iter().filter(|m| *m).count())
}
