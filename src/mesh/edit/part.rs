//! Taking a mesh apart into the patches between its labels, so that each can be worked on alone.

use glam::DVec3;

use super::{EditMesh, NONE, next, prev};

/// Some triangles of a mesh on their own: edges to other labels and sharp edges have become a boundary.
#[derive(Debug, Clone)]
pub struct Part {
    /// The triangles, with the labels they had.
    pub mesh: EditMesh,
    /// The node of the whole mesh each node is. A node that the part touches with several fans is there once for each.
    pub nodes: Vec<u32>,
}

/// The triangles of every label, and where each stands among those of its label.
#[derive(Debug, Clone)]
pub struct ByLabel {
    starts: Vec<u32>,
    order: Vec<u32>,
    position: Vec<u32>,
}

impl ByLabel {
    /// Sorts the living triangles of a mesh whose labels are below `labels`.
    pub fn new(mesh: &EditMesh, labels: usize) -> Self {
        let mut starts = vec![0u32; labels + 1];
        mesh.triangles().for_each(|t| starts[mesh.label(t) as usize + 1] += 1);
        for k in 0..labels {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut order = vec![NONE; starts[labels] as usize];
        let mut position = vec![NONE; mesh.triangle_capacity()];
        for t in mesh.triangles() {
            let label = mesh.label(t) as usize;
            order[next[label] as usize] = t;
            position[t as usize] = next[label] - starts[label];
            next[label] += 1;
        }
        Self { starts, order, position }
    }

    /// The triangles of a label, ascending.
    pub fn triangles(&self, label: u32) -> &[u32] {
        &self.order[self.starts[label as usize] as usize..self.starts[label as usize + 1] as usize]
    }
}

impl EditMesh {
    /// The triangles of one label on their own; `sorted` must be of this mesh as it is.
    pub fn part(&self, label: u32, sorted: &ByLabel) -> Part {
        let triangles = sorted.triangles(label);
        let n = triangles.len();
        let mut mesh = EditMesh {
            points: Vec::with_capacity(n / 2 + 2),
            corners: vec![NONE; 3 * n],
            opposite: vec![NONE; 3 * n],
            sharp: vec![false; 3 * n],
            out: Vec::with_capacity(n / 2 + 2),
            pinned: Vec::with_capacity(n / 2 + 2),
            labels: vec![label; n],
            normals: vec![DVec3::ZERO; n],
            faces: Vec::new(),
            groups: Vec::new(),
            dead_triangles: 0,
        };
        for (i, &t) in triangles.iter().enumerate() {
            mesh.normals[i] = self.normals[t as usize];
            for k in 0..3 {
                let o = self.opposite[3 * t as usize + k];
                if o != NONE && self.label(o / 3) == label && !self.sharp[3 * t as usize + k] {
                    mesh.opposite[3 * i + k] = 3 * sorted.position[(o / 3) as usize] + o % 3;
                }
            }
        }
        let mut nodes = Vec::with_capacity(n / 2 + 2);
        for h in 0..3 * n as u32 {
            if mesh.corners[h as usize] != NONE {
                continue;
            }
            let first = mesh.first_of_fan(h);
            let whole = self.origin(3 * triangles[(h / 3) as usize] + h % 3);
            let own = nodes.len() as u32;
            nodes.push(whole);
            mesh.points.push(self.point(whole));
            mesh.pinned.push(self.is_pinned(whole));
            mesh.out.push(first);
            let mut at = first;
            loop {
                mesh.corners[at as usize] = own;
                at = mesh.opposite[prev(at) as usize];
                if at == NONE || at == first {
                    break;
                }
            }
        }
        Part { mesh, nodes }
    }

    /// The outgoing half-edge that begins the fan of `h`: on a boundary the one without opposite.
    pub(super) fn first_of_fan(&self, h: u32) -> u32 {
        let mut at = h;
        loop {
            let o = self.opposite[at as usize];
            if o == NONE {
                return at;
            }
            at = next(o);
            if at == h {
                return h;
            }
        }
    }
}
