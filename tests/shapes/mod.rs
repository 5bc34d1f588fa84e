//! Soups that tests of the discrete gate share, inside the crate and outside.

#![allow(dead_code, reason = "each who shares them uses some")]

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

/// A solid of revolution about z as CAD programs write it: every strip between two points `[radius, z]` of the profile, which goes from
/// axis to axis with the solid to its left, is `sides` needles wide. With `closed` it goes around instead.
pub fn revolved(profile: &[[f64; 2]], sides: u32, closed: bool) -> TriMesh {
    let (mut nodes, mut rings) = (Vec::new(), Vec::new());
    for [r, z] in profile {
        let count = if *r > 0.0 { sides } else { 1 };
        rings.push((nodes.len() as u32, count));
        nodes.extend((0..count).map(|i| {
            let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            DVec3::new(r * c, r * s, *z)
        }));
    }
    let mut triangles = Vec::new();
    for i in 0..rings.len() - usize::from(!closed) {
        let (a, b) = (rings[i], rings[(i + 1) % rings.len()]);
        let at = |ring: (u32, u32), k: u32| ring.0 + k % ring.1;
        for k in 0..sides {
            if a.1 > 1 {
                triangles.push([at(a, k), at(a, k + 1), at(b, k + 1)]);
            }
            if b.1 > 1 {
                triangles.push([at(a, k), at(b, k + 1), at(b, k)]);
            }
        }
    }
    TriMesh::new(nodes, triangles)
}
