//! Vertices of faces: a node once for each face, and once for each side of the sharp edges within a face.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::{COS_30, Sets};
use crate::run::Run;

/// Which corners of triangles are one vertex; corner `k` of triangle `t` has the number `3 t + k`.
pub(super) struct VertexNumbers {
    /// For each corner the smallest one that is the same vertex.
    first: Vec<u32>,
    /// Whether every edge is of two triangles that run along it in opposite directions.
    pub(super) closed: bool,
}

/// The vertices and triangles of a face.
pub(super) struct FacePatch {
    /// The number of its name.
    pub(super) face: u32,
    pub(super) positions: Vec<[f32; 3]>,
    /// Of length one.
    pub(super) normals: Vec<[f32; 3]>,
    /// Three vertices for each triangle.
    pub(super) indices: Vec<u32>,
}

/// The corner that follows in its triangle.
fn next(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

impl VertexNumbers {
    pub(super) fn new(mesh: &TriMesh, seams: &[[u32; 2]], run: &Run) -> Result<Self> {
        let node = |corner: u32| mesh.triangles[corner as usize / 3][corner as usize % 3];
        let label = |corner: u32| mesh.labels[corner as usize / 3];
        let turns = |a: u32, b: u32| {
            let [m, n] = [a, b].map(|corner| mesh.area_vector(corner as usize / 3));
            // Edges that turn by more are sharp in pictures, too.
            m.dot(n) < COS_30 * m.length() * n.length()
        };
        let mut sharp: Vec<[u32; 2]> = seams.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
        sharp.sort_unstable();
        let mut sides: Vec<[u32; 3]> = (0..3 * mesh.triangles.len() as u32)
            .map(|corner| {
                let [a, b] = [node(corner), node(next(corner))];
                [a.min(b), a.max(b), corner]
            })
            .collect();
        run.check()?;
        sides.par_sort_unstable();
        run.check()?;
        let mut vertices = Sets::new(sides.len());
        let mut closed = true;
        for edge in sides.chunk_by(|a, b| a[..2] == b[..2]) {
            let &[[low, high, a], [.., b]] = edge else {
                closed = false;
                continue;
            };
            // Along an edge that turns over, normals of both sides would cancel.
            if node(a) != node(next(b)) {
                closed = false;
            } else if label(a) == label(b) && sharp.binary_search(&[low, high]).is_err() && !turns(a, b) {
                vertices.join(a, next(b));
                vertices.join(next(a), b);
            }
        }
        let first = (0..sides.len() as u32).map(|corner| vertices.find(corner)).collect();
        Ok(Self { first, closed })
    }

    /// The faces that have triangles, in their order, with triangles in that of the mesh.
    pub(super) fn patches(&self, mesh: &TriMesh, run: &Run) -> Result<Vec<FacePatch>> {
        let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        order.sort_by_key(|t| mesh.labels[*t as usize]);
        let same = |a: &u32, b: &u32| mesh.labels[*a as usize] == mesh.labels[*b as usize];
        // A vertex is of one face: numbers within faces share a list.
        let mut numbers = vec![u32::MAX; self.first.len()];
        let patch = |triangles: &[u32]| {
            run.check()?;
            Ok(self.patch(mesh, triangles, &mut numbers))
        };
        order.chunk_by(same).map(patch).collect()
    }

    fn patch(&self, mesh: &TriMesh, triangles: &[u32], numbers: &mut [u32]) -> FacePatch {
        let mut patch = FacePatch {
            face: mesh.labels[triangles[0] as usize],
            positions: Vec::new(),
            normals: Vec::new(),
            indices: Vec::with_capacity(3 * triangles.len()),
        };
        let mut sums = Vec::new();
        for t in triangles {
            let area = mesh.area_vector(*t as usize);
            for (k, point) in mesh.corners(*t as usize).into_iter().enumerate() {
                let number = &mut numbers[self.first[3 * *t as usize + k] as usize];
                if *number == u32::MAX {
                    *number = patch.positions.len() as u32;
                    // Adding zero takes the sign off a zero.
                    patch.positions.push(point.as_vec3().to_array().map(|x| x + 0.0));
                    sums.push(DVec3::ZERO);
                }
                sums[*number as usize] += area;
                patch.indices.push(*number);
            }
        }
        // Where triangles have no area any direction will do, as long as it is one.
        patch.normals =
            sums.iter().map(|n| n.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array().map(|x| x + 0.0)).collect();
        patch
    }
}

impl FacePatch {
    /// The least and the greatest coordinates.
    pub(super) fn bounds(&self) -> [[f32; 3]; 2] {
        let along = |k: usize| self.positions.iter().map(move |p| p[k]);
        [
            [0, 1, 2].map(|k| along(k).fold(f32::INFINITY, f32::min)),
            [0, 1, 2].map(|k| along(k).fold(f32::NEG_INFINITY, f32::max)),
        ]
    }
}
