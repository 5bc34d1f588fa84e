//! Taking a mesh apart into regions, so that each can be worked on alone.

use glam::DVec3;

use super::{EditMesh, NONE, next, prev};

/// Some triangles of a mesh on their own: edges to other regions and sharp edges have become a boundary.
#[derive(Debug, Clone)]
pub struct PartMesh {
    /// The triangles, with the labels they had.
    pub mesh: EditMesh,
    /// The node of the whole mesh each node is. A node that the part touches with several fans is there once for each.
    pub nodes: Vec<u32>,
}

/// The triangles of every region, and where each stands among those of its region.
#[derive(Debug, Clone)]
pub struct Regions {
    of: Vec<u32>,
    starts: Vec<u32>,
    order: Vec<u32>,
    position: Vec<u32>,
}

impl Regions {
    /// Sorts the living triangles of a mesh by their regions, given for every triangle there is room for and below `count`.
    pub fn new(mesh: &EditMesh, of: Vec<u32>, count: usize) -> Self {
        let mut starts = vec![0u32; count + 1];
        mesh.triangles().for_each(|t| starts[of[t as usize] as usize + 1] += 1);
        for k in 0..count {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut order = vec![NONE; starts[count] as usize];
        let mut position = vec![NONE; mesh.triangle_capacity()];
        for t in mesh.triangles() {
            let region = of[t as usize] as usize;
            order[next[region] as usize] = t;
            position[t as usize] = next[region] - starts[region];
            next[region] += 1;
        }
        Self { of, starts, order, position }
    }

    /// How many regions there are.
    pub fn count(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// The triangles of a region, ascending.
    pub fn triangles(&self, region: u32) -> &[u32] {
        &self.order[self.starts[region as usize] as usize..self.starts[region as usize + 1] as usize]
    }
}

impl EditMesh {
    /// The triangles of one region on their own; `regions` must be of this mesh as it is.
    pub fn part(&self, region: u32, regions: &Regions) -> PartMesh {
        let triangles = regions.triangles(region);
        let n = triangles.len();
        let mut mesh = EditMesh {
            points: Vec::with_capacity(n / 2 + 2),
            corners: vec![NONE; 3 * n],
            opposite: vec![NONE; 3 * n],
            sharp: vec![false; 3 * n],
            out: Vec::with_capacity(n / 2 + 2),
            pinned: Vec::with_capacity(n / 2 + 2),
            changed: Vec::with_capacity(n / 2 + 2),
            labels: triangles.iter().map(|&t| self.label(t)).collect(),
            normals: vec![DVec3::ZERO; n],
            faces: Vec::new(),
            groups: Vec::new(),
            dead_triangles: 0,
        };
        for (i, &t) in triangles.iter().enumerate() {
            mesh.normals[i] = self.normals[t as usize];
            for k in 0..3 {
                let o = self.opposite[3 * t as usize + k];
                if o != NONE && regions.of[(o / 3) as usize] == region && !self.sharp[3 * t as usize + k] {
                    mesh.opposite[3 * i + k] = 3 * regions.position[(o / 3) as usize] + o % 3;
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
            let border = mesh.opposite[first as usize] == NONE;
            mesh.changed.push(if border { u8::MAX } else { self.changed[whole as usize] });
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
        PartMesh { mesh, nodes }
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
