//! Soups that tests of the discrete gate share, inside the crate and outside.

use super::{DVec3, TriMesh};

/// A prism over a polygon whose triangulation is a fan around its corner 0.
pub fn prism(outline: &[[f64; 2]], height: f64) -> TriMesh {
    let n = outline.len() as u32;
    let at = |z: f64| outline.iter().map(move |p| DVec3::new(p[0], p[1], z));
    let nodes = at(0.0).chain(at(height)).collect();
    let mut triangles = Vec::new();
    for i in 1..n - 1 {
        triangles.push([0, i + 1, i]);
        triangles.push([n, n + i, n + i + 1]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.push([i, j, n + j]);
        triangles.push([i, n + j, n + i]);
    }
    TriMesh::new(nodes, triangles)
}

/// An L, its fan corner the reflex one.
pub fn l_block(step: f64) -> TriMesh {
    prism(&[[1.0, step], [0.0, step], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]], 1.0)
}
