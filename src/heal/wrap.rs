//! The last rung: a closed surface around whatever there is, at a resolution.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::sides::key;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Cells along the longest side of the box.
const CELLS: f64 = 64.0;

/// How far from the input the surface runs, in cells: enough that no gap between grid points opens.
const OFF: f64 = 1.3;

/// The border of what outside cannot reach without coming near the input, by marching tetrahedra on a cubic grid, whose cells
/// are cut into six along a diagonal. Closed, a manifold, oriented, and embedded: each tetrahedron holds a piece of plane,
/// and neighbors agree on it.
pub(super) fn wrap(mesh: &TriMesh, run: &Run) -> Result<TriMesh> {
    let bounds = Aabb::around(mesh.triangles.iter().flatten().map(|v| mesh.nodes[*v as usize]));
    let step = (bounds.size().max_element() / CELLS).max(f64::MIN_POSITIVE);
    let origin = bounds.lo - 3.0 * step;
    let n: [usize; 3] = (bounds.size() / step).to_array().map(|x| x.ceil() as usize + 7);
    let at =
        |i: usize| DVec3::new((i % n[0]) as f64, (i / n[0] % n[1]) as f64, (i / (n[0] * n[1])) as f64) * step + origin;
    let bvh = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let (reach, far) = (OFF * step, 3.0 * OFF * step);
    let total = n[0] * n[1] * n[2];
    // negative near the input
    let mut value: Vec<f64> = run.install(|| {
        (0..total)
            .into_par_iter()
            .map(|i| {
                if run.is_cancelled() {
                    return far;
                }
                let p = at(i);
                let d = bvh.nearest(p, far, |t| triangle_distance_squared(p, mesh.corners(t as usize)));
                d.map_or(far, |d| d.1.sqrt()) - reach
            })
            .collect()
    });
    run.check()?;
    // what outside does not reach is inside
    let strides = [1, n[0], n[0] * n[1]];
    let mut outside = vec![false; total];
    let mut stack = vec![0usize];
    outside[0] = true;
    while let Some(i) = stack.pop() {
        let c = [i % n[0], i / n[0] % n[1], i / strides[2]];
        for axis in 0..3 {
            for (can, j) in [(c[axis] > 0, i.wrapping_sub(strides[axis])), (c[axis] + 1 < n[axis], i + strides[axis])] {
                if can && !outside[j] && value[j] > 0.0 {
                    outside[j] = true;
                    stack.push(j);
                }
            }
        }
    }
    for i in 0..total {
        if !outside[i] && value[i] >= 0.0 {
            value[i] = -reach;
        } else if value[i] == 0.0 {
            value[i] = -f64::MIN_POSITIVE;
        }
    }
    let out = TriMesh { faces: vec!["rebuilt".into()], ..TriMesh::default() };
    let mut marching = Marching { value: &value, at: &at, node_on: FxHashMap::default(), out };
    for z in 0..n[2] - 1 {
        run.check()?;
        for y in 0..n[1] - 1 {
            for x in 0..n[0] - 1 {
                let base = x + y * strides[1] + z * strides[2];
                let all: [usize; 8] =
                    std::array::from_fn(|c| base + (c & 1) + (c >> 1 & 1) * strides[1] + (c >> 2) * strides[2]);
                if all.iter().all(|i| value[*i] < 0.0) || all.iter().all(|i| value[*i] > 0.0) {
                    continue;
                }
                // one tetrahedron for each order of the axes, from corner 0 to corner 7
                for (i, j) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                    let tet = [all[0], all[1 << i], all[1 << i | 1 << j], all[7]];
                    // orders that turn the other way make mirrored tetrahedra
                    let mirrored = (j + 3 - i) % 3 == 2;
                    marching.march(if mirrored { [tet[0], tet[2], tet[1], tet[3]] } else { tet });
                }
            }
        }
    }
    let mut out = marching.out;
    out.labels = vec![0; out.triangles.len()];
    Ok(out)
}

/// Marching tetrahedra under way.
struct Marching<'a, F: Fn(usize) -> DVec3> {
    /// Values at the nodes of the grid, negative inside,
    value: &'a [f64],
    /// and where these are.
    at: &'a F,
    /// The node of the surface on each edge of the grid.
    node_on: FxHashMap<u64, u32>,
    out: TriMesh,
}

impl<F: Fn(usize) -> DVec3> Marching<'_, F> {
    /// The piece of surface in one tetrahedron, its normal to where values are positive.
    fn march(&mut self, tet: [usize; 4]) {
        let Self { value, at, node_on, out } = self;
        let (inside, outer): (Vec<usize>, Vec<usize>) = (0..4).partition(|k| value[tet[*k]] < 0.0);
        let mut node = |a: usize, b: usize| {
            let (i, j) = (tet[a].min(tet[b]), tet[a].max(tet[b]));
            *node_on.entry(key(i as u32, j as u32)).or_insert_with(|| {
                let s = (value[i] / (value[i] - value[j])).clamp(0.02, 0.98);
                out.nodes.push(at(i) + s * (at(j) - at(i)));
                out.nodes.len() as u32 - 1
            })
        };
        // whether (a, b, c, d) is an even permutation of (0, 1, 2, 3)
        let even = |p: [usize; 4]| {
            (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j))).filter(|(i, j)| p[*i] > p[*j]).count() % 2 == 0
        };
        let mut polygon = match (&inside[..], &outer[..]) {
            (&[a], &[b, c, d]) => {
                let mut p = vec![node(a, b), node(a, c), node(a, d)];
                if !even([a, b, c, d]) {
                    p.reverse();
                }
                p
            }
            (&[b, c, d], &[a]) => {
                let mut p = vec![node(a, b), node(a, c), node(a, d)];
                if even([a, b, c, d]) {
                    p.reverse();
                }
                p
            }
            (&[a, b], &[c, d]) => {
                let mut p = vec![node(a, c), node(a, d), node(b, d), node(b, c)];
                if !even([a, b, c, d]) {
                    p.reverse();
                }
                p
            }
            _ => return,
        };
        if polygon.len() == 4 {
            // the smallest first, so that the choice of the diagonal does not depend on the order
            let k = (0..4).min_by_key(|k| polygon[*k]).unwrap_or(0);
            polygon.rotate_left(k);
            out.triangles.push([polygon[0], polygon[2], polygon[3]]);
        }
        out.triangles.push([polygon[0], polygon[1], polygon[2]]);
    }
}
