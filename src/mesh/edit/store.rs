//! The edit mesh as a whole: giving it back, squeezing it, checking it.

use super::{EditMesh, NONE};
use crate::mesh::TriMesh;

impl EditMesh {
    /// The living nodes and triangles, in order, renumbered without gaps.
    pub fn to_mesh(&self) -> TriMesh {
        let mut mesh = TriMesh { faces: self.faces.clone(), groups: self.groups.clone(), ..TriMesh::default() };
        let mut number = vec![NONE; self.points.len()];
        for v in self.nodes() {
            number[v as usize] = mesh.nodes.len() as u32;
            mesh.nodes.push(self.points[v as usize]);
        }
        for t in self.triangles() {
            mesh.triangles.push(self.corners(t).map(|v| number[v as usize]));
            mesh.labels.push(self.labels[t as usize]);
        }
        mesh
    }

    /// Squeezes dead nodes and triangles out, and gives back the room they took; ids change, order does not.
    pub fn compact(&mut self) {
        let mut triangle = vec![NONE; self.labels.len()];
        let mut node = vec![NONE; self.points.len()];
        let (mut nt, mut nv) = (0u32, 0u32);
        for t in self.triangles() {
            triangle[t as usize] = nt;
            nt += 1;
        }
        for v in self.nodes() {
            node[v as usize] = nv;
            nv += 1;
        }
        let half = |h: u32| if h == NONE { NONE } else { 3 * triangle[(h / 3) as usize] + h % 3 };
        for t in 0..triangle.len() {
            let to = triangle[t] as usize;
            if triangle[t] == NONE {
                continue;
            }
            self.labels[to] = self.labels[t];
            self.normals[to] = self.normals[t];
            for k in 0..3 {
                self.corners[3 * to + k] = node[self.corners[3 * t + k] as usize];
                self.sharp[3 * to + k] = self.sharp[3 * t + k];
                self.opposite[3 * to + k] = half(self.opposite[3 * t + k]);
            }
        }
        for v in 0..node.len() {
            if node[v] != NONE {
                let to = node[v] as usize;
                self.points[to] = self.points[v];
                self.pinned[to] = self.pinned[v];
                self.changed[to] = self.changed[v];
                self.out[to] = half(self.out[v]);
            }
        }
        let (nt, nv) = (nt as usize, nv as usize);
        self.labels.truncate(nt);
        self.normals.truncate(nt);
        self.corners.truncate(3 * nt);
        self.sharp.truncate(3 * nt);
        self.opposite.truncate(3 * nt);
        self.points.truncate(nv);
        self.pinned.truncate(nv);
        self.changed.truncate(nv);
        self.out.truncate(nv);
        for list in [&mut self.labels, &mut self.corners, &mut self.opposite, &mut self.out] {
            list.shrink_to_fit();
        }
        for list in [&mut self.normals, &mut self.points] {
            list.shrink_to_fit();
        }
        for list in [&mut self.sharp, &mut self.pinned] {
            list.shrink_to_fit();
        }
        self.changed.shrink_to_fit();
        self.dead_triangles = 0;
    }

    /// Walks the whole structure; the first broken invariant is named. Costs O(n): for tests and debug builds.
    pub fn check(&self) -> Result<(), String> {
        let mut corners_at = vec![0usize; self.points.len()];
        for h in 0..self.corners.len() as u32 {
            if self.corners[h as usize] == NONE {
                continue;
            }
            let (a, b) = (self.origin(h), self.target(h));
            if a == b || b == NONE {
                return Err(format!("half-edge {h} is degenerate"));
            }
            corners_at[a as usize] += 1;
            let o = self.opposite[h as usize];
            if o != NONE {
                if self.opposite[o as usize] != h || self.origin(o) != b || self.target(o) != a {
                    return Err(format!("half-edges {h} and {o} do not match"));
                }
                if self.sharp[h as usize] != self.sharp[o as usize] {
                    return Err(format!("edge {h} is sharp on one side only"));
                }
            }
        }
        for v in 0..self.points.len() as u32 {
            if (self.out[v as usize] == NONE) != (corners_at[v as usize] == 0) {
                return Err(format!(
                    "node {v} has {} corners but entry {}",
                    corners_at[v as usize], self.out[v as usize]
                ));
            }
            if self.out[v as usize] == NONE {
                continue;
            }
            let mut ring = 0;
            for h in self.outgoing(v) {
                ring += 1;
                if self.origin(h) != v || ring > corners_at[v as usize] {
                    return Err(format!("the ring of node {v} is broken"));
                }
            }
            if ring != corners_at[v as usize] {
                return Err(format!("node {v} has {} corners but a ring of {ring}", corners_at[v as usize]));
            }
            let mut around: Vec<u32> = self.neighbors(v).collect();
            let n = around.len();
            around.sort_unstable();
            around.dedup();
            if around.len() != n || n != self.valence(v) {
                return Err(format!("node {v} is joined twice to a neighbor"));
            }
        }
        Ok(())
    }
}
