//! Back from exact to linear, where nodes on their surfaces have triangles cross: the linear interpolants are arranged without.

use super::Arranged;
use crate::error::Result;
use crate::mesh::{TriMesh, self_intersections};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Rounds in which nodes go half of the way back. Seven leave less than a hundredth of it, which is as good as linear; then they go all
/// the way.
const HALVINGS: usize = 7;
/// Nodes beside those come along at most so many rounds more: each of these has one more ring of triangles.
const RINGS: usize = 8;

impl Arranged {
    /// Draws nodes of triangles that cross each other in some boxes back to where the linear interpolants vanish, until none cross there.
    ///
    /// Errors: cancellation.
    pub(crate) fn retreat(&mut self, boxes: &[Aabb], run: &Run) -> Result<()> {
        let (mesh, linear) = (&mut self.made.mesh, &self.linear);
        if boxes.is_empty() || linear.is_empty() {
            return Ok(());
        }
        let tree = Bvh::new(boxes.to_vec());
        let is_in = |t: &usize| tree.meets(&Aabb::around(mesh.corners(*t)));
        let near: Vec<[u32; 3]> = (0..mesh.triangles.len()).filter(is_in).map(|t| mesh.triangles[t]).collect();
        let mut part = TriMesh { nodes: std::mem::take(&mut mesh.nodes), triangles: near, ..TriMesh::default() };
        for round in 0..HALVINGS + RINGS {
            let bad = self_intersections(&part, run)?;
            if bad.is_empty() {
                break;
            }
            let mut nodes: Vec<u32> = bad.iter().flatten().flat_map(|t| part.triangles[*t as usize]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            if round >= HALVINGS {
                let beside = |t: &&[u32; 3]| t.iter().any(|v| nodes.binary_search(v).is_ok());
                let more: Vec<u32> = part.triangles.iter().filter(beside).flatten().copied().collect();
                nodes.extend(more);
            }
            for v in nodes.iter().map(|v| *v as usize) {
                part.nodes[v] = if round < HALVINGS { part.nodes[v].lerp(linear[v], 0.5) } else { linear[v] };
            }
        }
        mesh.nodes = part.nodes;
        Ok(())
    }
}
