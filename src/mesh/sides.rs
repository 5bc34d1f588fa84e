//! The sides of all triangles, gathered by their edges.

use super::trimesh::TriMesh;

/// One side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct TriangleSide {
    /// The undirected edge: the smaller node, then the larger.
    pub(crate) key: u64,
    /// Three times the triangle, and which of its sides: 0 from its first node to its second.
    pub(crate) number: u32,
    /// Whether it runs from the smaller node to the larger.
    pub(crate) forward: bool,
}

impl TriangleSide {
    /// The triangle.
    pub(crate) fn triangle(&self) -> u32 {
        self.number / 3
    }

    /// The edge's nodes, the smaller first.
    pub(crate) fn edge(&self) -> [u32; 2] {
        [(self.key >> 32) as u32, self.key as u32]
    }
}

/// All sides, ascending. They are gathered by their smaller node first, which leaves little to sort.
pub(crate) fn sides(mesh: &TriMesh) -> Vec<TriangleSide> {
    let each = || {
        let ends = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        (0u32..).zip(mesh.triangles.iter().flat_map(ends))
    };
    let mut fill = vec![0usize; mesh.nodes.len() + 1];
    each().for_each(|(_, [a, b])| fill[a.min(b) as usize + 1] += 1);
    for v in 0..mesh.nodes.len() {
        fill[v + 1] += fill[v];
    }
    let mut sides = vec![TriangleSide::default(); 3 * mesh.triangles.len()];
    for (number, [a, b]) in each() {
        let at = &mut fill[a.min(b) as usize];
        sides[*at] = TriangleSide { key: u64::from(a.min(b)) << 32 | u64::from(a.max(b)), number, forward: a < b };
        *at += 1;
    }
    sides.chunk_by_mut(|x, y| x.key >> 32 == y.key >> 32).for_each(<[TriangleSide]>::sort_unstable);
    sides
}
