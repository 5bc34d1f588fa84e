//! Curvature of a triangle mesh at its nodes: the sets C and G of \[LIS14\] (14, 15), and dihedral angles.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use rayon::prelude::*;

use super::TriMesh;
use super::edit::{EditMesh, NONE};
use crate::error::Result;
use crate::run::Run;

/// What the triangles around a node say about the surface's curvature there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NodeCurvature {
    /// `(|k1|, |k2|)` with |k1| ≥ |k2|, 1 over length, \[LIS14\] (14). Magnitudes, so that reflex creases show as convex
    /// ones do.
    pub principal: [f64; 2],
    /// |2π − Σθ|, or |π − Σθ| on a boundary, radians: the curvature of (15) without its 1/h², which would make corners
    /// of fine meshes count more than those of coarse ones.
    pub defect: f64,
}

/// Angle between the normals of the two triangles at an edge, radians, 0 on a boundary: 0 where the mesh is flat.
pub fn dihedral(mesh: &EditMesh, h: u32) -> f64 {
    let o = mesh.opposite(h);
    if o == NONE { 0.0 } else { mesh.area_vector(h / 3).angle_between_or_zero(mesh.area_vector(o / 3)) }
}

trait AngleOrZero {
    fn angle_between_or_zero(self, other: Self) -> f64;
}

impl AngleOrZero for DVec3 {
    /// The angle by atan2, which is exact near 0 and π and 0 for zero vectors.
    fn angle_between_or_zero(self, other: Self) -> f64 {
        self.cross(other).length().atan2(self.dot(other))
    }
}

/// Curvatures at a node, from the curvature tensor of its edges: each edge bends the surface by its dihedral angle across
/// itself, so Σ β |e| (ê ⊗ ê) / (2·area) has the principal curvatures as eigenvalues, each on the *other* direction
/// (D. Cohen-Steiner, J.-M. Morvan, "Restricted Delaunay triangulations and normal cycle", 2003). The area is a third of
/// the triangles around the node. Zero for a dead node.
pub fn node_curvature(mesh: &EditMesh, v: u32) -> NodeCurvature {
    let p = mesh.point(v);
    let (mut angles, mut area, mut normal) = (0.0, 0.0, DVec3::ZERO);
    for h in mesh.outgoing(v) {
        let (a, b) = (mesh.point(mesh.target(h)) - p, mesh.point(mesh.apex(h)) - p);
        angles += a.angle_between_or_zero(b);
        let vector = mesh.area_vector(h / 3);
        area += vector.length() / 6.0;
        normal += vector;
    }
    if area <= 0.0 {
        return NodeCurvature::default();
    }
    let n = normal.normalize_or(DVec3::Z);
    let (x, y) = n.any_orthonormal_pair();
    // The tensor in the tangent plane: [xx, xy, yy].
    let mut tensor = [0.0; 3];
    for h in mesh.outgoing(v) {
        let o = mesh.opposite(h);
        if o == NONE {
            continue;
        }
        let e = mesh.point(mesh.target(h)) - p;
        let (nh, no) = (mesh.area_vector(h / 3), mesh.area_vector(o / 3));
        // Positive where the surface is convex.
        let bend = dihedral(mesh, h) * no.cross(nh).dot(e).signum();
        let (u, w) = (e.dot(x), e.dot(y));
        let scale = bend / e.length().max(f64::MIN_POSITIVE);
        // Half of the edge lies in this node's cell.
        tensor[0] += 0.5 * scale * u * u;
        tensor[1] += 0.5 * scale * u * w;
        tensor[2] += 0.5 * scale * w * w;
    }
    let [xx, xy, yy] = tensor.map(|t| t / area);
    let (mean, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (a, b) = ((mean + radius).abs(), (mean - radius).abs());
    let full = if mesh.is_boundary(v) { PI } else { TAU };
    NodeCurvature { principal: [a.max(b), a.min(b)], defect: (full - angles).abs() }
}

/// Curvatures at all nodes of a mesh, in their order; zero at a node without triangles.
///
/// Guarantees: the same for any number of threads.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) for a mesh that is no oriented manifold; [`Error::Cancelled`](crate::Error::Cancelled).
pub fn node_curvatures(mesh: &TriMesh, run: &Run) -> Result<Vec<NodeCurvature>> {
    run.check()?;
    let edit = EditMesh::new(mesh)?;
    let all = 0..mesh.nodes.len() as u32;
    Ok(run.install(|| all.into_par_iter().map(|v| node_curvature(&edit, v)).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn cube() -> EditMesh {
        let mut nodes = Vec::new();
        for k in 0..8 {
            nodes.push(DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)));
        }
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        EditMesh::new(&TriMesh::new(nodes, triangles)).unwrap()
    }

    /// A UV sphere or, with `stretch`, a prism-like tube.
    fn sphere(r: f64, n: u32) -> EditMesh {
        let mut nodes = vec![DVec3::Z * r];
        for i in 1..n {
            for j in 0..2 * n {
                let (t, p) = (PI * f64::from(i) / f64::from(n), PI * f64::from(j) / f64::from(n));
                nodes.push(r * DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()));
            }
        }
        nodes.push(DVec3::NEG_Z * r);
        let last = nodes.len() as u32 - 1;
        let at = |i: u32, j: u32| 1 + (i - 1) * 2 * n + j % (2 * n);
        let mut triangles = Vec::new();
        for j in 0..2 * n {
            triangles.push([0, at(1, j), at(1, j + 1)]);
            triangles.push([last, at(n - 1, j + 1), at(n - 1, j)]);
            for i in 1..n - 1 {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        EditMesh::new(&TriMesh::new(nodes, triangles)).unwrap()
    }

    #[test]
    fn defects_of_a_cube_are_quarter_turns_and_sum_to_four_pi() {
        let m = cube();
        let sum: f64 = m.nodes().map(|v| node_curvature(&m, v).defect).sum();
        assert_abs_diff_eq!(sum, 2.0 * TAU, epsilon = 1e-12);
        assert!(m.nodes().all(|v| (node_curvature(&m, v).defect - 0.5 * PI).abs() < 1e-12));
        let bends = m.edges().filter(|&h| (dihedral(&m, h) - 0.5 * PI).abs() < 1e-12).count();
        assert_eq!((bends, m.edges().count()), (12, 18));
    }

    #[test]
    fn a_sphere_bends_by_its_radius_both_ways_and_outside_in_too() {
        for r in [0.5, 2.0] {
            let m = sphere(r, 24);
            // Away from the poles the cells are regular.
            let equator = m.nodes().filter(|&v| m.point(v).z.abs() < 0.3 * r);
            for v in equator {
                let [k1, k2] = node_curvature(&m, v).principal;
                assert_abs_diff_eq!(k1 * r, 1.0, epsilon = 0.1);
                assert_abs_diff_eq!(k2 * r, 1.0, epsilon = 0.1);
            }
            let sum: f64 = m.nodes().map(|v| node_curvature(&m, v).defect).sum();
            assert_abs_diff_eq!(sum, 2.0 * TAU, epsilon = 1e-9);
        }
    }

    #[test]
    fn all_nodes_have_theirs_in_order_and_a_lone_one_has_none() {
        let m = sphere(2.0, 12);
        let mut flat = m.to_mesh();
        flat.nodes.push(DVec3::splat(9.0));
        let all = node_curvatures(&flat, &Run::new()).unwrap();
        assert_eq!(all.len(), flat.nodes.len());
        assert_eq!(all.last(), Some(&NodeCurvature::default()));
        assert!(m.nodes().all(|v| all[v as usize] == node_curvature(&m, v)));
        flat.triangles.push(flat.triangles[0]);
        flat.labels.push(0);
        assert!(matches!(node_curvatures(&flat, &Run::new()), Err(crate::Error::Input { .. })));
    }

    #[test]
    fn convex_and_reflex_creases_bend_alike_across_and_not_along() {
        let n = 6u32;
        for up in [1.0, -1.0] {
            let mut nodes = Vec::new();
            for i in 0..=2 * n {
                for j in 0..=2 * n {
                    let x = f64::from(i) - f64::from(n);
                    nodes.push(DVec3::new(x, f64::from(j), -up * x.abs()));
                }
            }
            let at = |i: u32, j: u32| i * (2 * n + 1) + j;
            let cells = (0..2 * n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
            let triangles = cells
                .flat_map(|(i, j)| {
                    [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
                })
                .collect();
            let m = EditMesh::new(&TriMesh::new(nodes, triangles)).unwrap();
            let on = node_curvature(&m, at(n, n));
            assert!(on.principal[0] > 0.5 && on.principal[1] < 1e-12 && on.defect < 1e-12, "{on:?}");
            let off = node_curvature(&m, at(2, n));
            assert!(off.principal[0] < 1e-12 && off.defect < 1e-12);
        }
    }
}
