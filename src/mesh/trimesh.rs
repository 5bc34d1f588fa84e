//! The indexed triangle mesh every stage speaks.

use glam::DVec3;

use crate::spatial::Aabb;

/// A named set of faces, for example a boundary condition's place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The name, as the user wrote it.
    pub name: String,
    /// Indices into [`TriMesh::faces`].
    pub faces: Vec<u32>,
}

/// Nodes, triangles, and the face each triangle lies on.
///
/// Triangles wind counter-clockwise seen from outside. `labels` has one entry per triangle, an index into `faces`.
/// The struct does not force validity (bad geometry is data): see [`defects`](crate::mesh) for the questions to ask.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriMesh {
    /// Node coordinates.
    pub nodes: Vec<DVec3>,
    /// Node indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the index of its face in [`faces`](Self::faces).
    pub labels: Vec<u32>,
    /// Names of the faces.
    pub faces: Vec<String>,
    /// Named sets of faces.
    pub groups: Vec<Group>,
}

impl TriMesh {
    /// A mesh with one unnamed face, `"surface"`.
    pub fn new(nodes: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let labels = vec![0; triangles.len()];
        Self { nodes, triangles, labels, faces: vec!["surface".into()], groups: Vec::new() }
    }

    /// A box around the place where two triangles cross, and the length of edges there: of a long triangle it is a small part.
    pub(crate) fn meeting(&self, pair: [u32; 2]) -> (Aabb, f64) {
        let [a, b] = pair.map(|t| Aabb::around(self.corners(t as usize)));
        (a.intersection(&b), a.size().max_element().min(b.size().max_element()))
    }

    /// The corner points of triangle `t`.
    #[inline]
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[t];
        [self.nodes[a as usize], self.nodes[b as usize], self.nodes[c as usize]]
    }

    /// Twice the area vector of triangle `t`: its direction is the triangle's normal.
    pub fn area_vector(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(c - a)
    }

    /// Unit normal of triangle `t`, zero if it is degenerate.
    pub fn normal(&self, t: usize) -> DVec3 {
        self.area_vector(t).normalize_or_zero()
    }

    /// Centroid of triangle `t`.
    pub fn centroid(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(t);
        (a + b + c) / 3.0
    }

    /// Sum of the triangles' areas.
    pub fn area(&self) -> f64 {
        // The sum of no numbers is -0.
        (0..self.triangles.len()).fold(0.0, |area, t| area + 0.5 * self.area_vector(t).length())
    }

    /// Signed volume by the divergence theorem; meaningful for closed, oriented meshes only.
    pub fn volume(&self) -> f64 {
        let o = self.nodes.first().copied().unwrap_or_default();
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - o);
                a.dot(b.cross(c)) / 6.0
            })
            .fold(0.0, |all, v| all + v)
    }

    /// The box around all nodes.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.nodes.iter().copied())
    }

    /// Mean length of the triangles' edges, 0 for an empty mesh.
    pub fn mean_edge_length(&self) -> f64 {
        let sum: f64 = (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                a.distance(b) + b.distance(c) + c.distance(a)
            })
            .sum();
        if self.triangles.is_empty() { 0.0 } else { sum / (3 * self.triangles.len()) as f64 }
    }

    /// Removes nodes no triangle uses; triangles keep their order. Returns how many nodes went.
    pub fn drop_unused_nodes(&mut self) -> usize {
        let mut used = vec![false; self.nodes.len()];
        for v in self.triangles.iter().flatten() {
            used[*v as usize] = true;
        }
        let mut new = vec![u32::MAX; self.nodes.len()];
        let mut kept = 0;
        for i in 0..self.nodes.len() {
            if used[i] {
                new[i] = kept as u32;
                self.nodes[kept] = self.nodes[i];
                kept += 1;
            }
        }
        let gone = self.nodes.len() - kept;
        self.nodes.truncate(kept);
        for v in self.triangles.iter_mut().flatten() {
            *v = new[*v as usize];
        }
        gone
    }
}
