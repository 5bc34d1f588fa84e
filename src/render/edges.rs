//! Which edges are drawn on top of the faces.

use rayon::prelude::*;

use crate::mesh::TriMesh;

/// Why an edge is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DrawnLine {
    /// One triangle only, or more than two.
    Alarm,
    /// The normals on its two sides differ by more than the asked angle.
    Sharp,
    /// Two faces meet smoothly.
    Border,
    /// A clipping plane cuts the surface.
    Cut,
}

/// The edges to draw, ordered by their nodes: `a < b` and what it is.
pub(super) fn lines(mesh: &TriMesh, sharp_degrees: f64) -> Vec<(u32, u32, DrawnLine)> {
    let mut sides: Vec<(u32, u32, u32)> = mesh
        .triangles
        .par_iter()
        .enumerate()
        .flat_map_iter(|(t, c)| (0..3).map(move |i| (c[i].min(c[(i + 1) % 3]), c[i].max(c[(i + 1) % 3]), t as u32)))
        .collect();
    sides.par_sort_unstable();
    let cosine = sharp_degrees.to_radians().cos();
    sides
        .chunk_by(|p, q| (p.0, p.1) == (q.0, q.1))
        .filter(|edge| edge[0].0 != edge[0].1)
        .filter_map(|edge| kind(mesh, edge, cosine).map(|line| (edge[0].0, edge[0].1, line)))
        .collect()
}

fn kind(mesh: &TriMesh, edge: &[(u32, u32, u32)], cosine: f64) -> Option<DrawnLine> {
    let [(a, b, s), (_, _, t)] = edge else { return Some(DrawnLine::Alarm) };
    let forward = |t: u32| {
        let c = mesh.triangles[t as usize];
        (0..3).any(|i| (c[i], c[(i + 1) % 3]) == (*a, *b))
    };
    let (m, n) = (mesh.normal(*s as usize), mesh.normal(*t as usize));
    let turn = if forward(*s) == forward(*t) { -m.dot(n) } else { m.dot(n) };
    let flat = m.length_squared() == 0.0 || n.length_squared() == 0.0;
    if !flat && turn < cosine {
        Some(DrawnLine::Sharp)
    } else {
        (mesh.labels[*s as usize] != mesh.labels[*t as usize]).then_some(DrawnLine::Border)
    }
}
