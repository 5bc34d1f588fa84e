//! A soup's model with what the remesher needs to know of it.

use crate::discrete::Discrete;
use crate::geometry::Pieces;
use crate::remesh::{Patchwork, PiecePatch, PieceSet, Policy};

/// The triangles with what the remesher needs; those that stay are patches of their own, beside which edges are as long as
/// theirs, but not shorter than `least`.
pub(super) fn patchwork(solid: &Discrete, sizes: Vec<f64>, kept: &[bool], least: f64) -> Patchwork {
    let mesh = solid.mesh.clone();
    let sets = (0..mesh.node_capacity() as u32).map(|v| PieceSet::of(&solid.pieces_at(v))).collect();
    let faces = solid.face_count() as u32;
    let patches: Vec<PiecePatch> =
        (0..faces).map(|f| PiecePatch { piece: f, outward: 1.0, plane: solid.plane(f), face: u32::MAX }).collect();
    let kept: Vec<u32> = mesh.triangles().filter(|t| kept[*t as usize]).collect();
    let plain = Patchwork::new(mesh, sets, patches.into());
    let mut work = Patchwork { lines_from: faces, sizes, policy: Policy::of_triangles(solid.smooth), ..plain };
    work.freeze(&kept, least);
    work
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DVec3;
    use crate::mesh::TriMesh;
    use crate::pipeline::discrete::discrete_options;
    use crate::pipeline::soup_sizes::sizing;
    use crate::pipeline::{MeshOptions, SoupOptions};
    use crate::remesh::{RemeshOptions, RemeshTarget, remesh_patchwork};
    use crate::run::Run;
    use crate::sizing::GRADING;

    /// A bumpy square of n x n nodes, open.
    fn square(n: u32) -> TriMesh {
        let at = |i: u32, j: u32| {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n - 1));
            DVec3::new(x, y, 0.05 * (5.0 * x).sin() * (4.0 * y).cos())
        };
        let nodes = (0..n * n).map(|k| at(k % n, k / n)).collect();
        let cell = |k: u32| {
            let a = k / (n - 1) * n + k % (n - 1);
            [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]
        };
        TriMesh::new(nodes, (0..(n - 1) * (n - 1)).flat_map(cell).collect())
    }

    #[test]
    fn triangles_that_are_kept_stay_as_they_are_and_the_rest_is_remeshed() {
        let (run, size) = (Run::new(), 0.04);
        let solid = Discrete::new(&square(40), &discrete_options(&SoupOptions::default(), size), &run).unwrap();
        let centers: Vec<DVec3> = (0..solid.mesh.triangle_capacity() as u32).map(|t| solid.mesh.centroid(t)).collect();
        let kept: Vec<bool> = centers.iter().map(|c| c.distance(DVec3::new(0.5, 0.5, 0.0)) < 0.2).collect();
        let work = patchwork(&solid, vec![f64::INFINITY; solid.mesh.node_capacity()], &kept, 0.0);
        let exact = RemeshOptions::new(sizing(size, 1.0, &MeshOptions::default()), GRADING);
        let target = RemeshTarget { surface: &solid, names: &solid.named() };
        let made = remesh_patchwork(work, target, &exact, &run, None).unwrap();
        assert_eq!(made.report.self_intersections, 0);
        let now: std::collections::BTreeSet<[u64; 3]> =
            (0..made.mesh.triangles.len()).map(|t| made.mesh.centroid(t).to_array().map(f64::to_bits)).collect();
        let is_there = |t: usize| now.contains(&centers[t].to_array().map(f64::to_bits));
        let (mut stayed, mut others) = (0, 0);
        for t in 0..kept.len() {
            if kept[t] { stayed += usize::from(is_there(t)) } else { others += usize::from(is_there(t)) }
        }
        assert!(stayed > 300 && stayed == kept.iter().filter(|k| **k).count());
        assert!(others < kept.len() / 20 && made.mesh.triangles.len() < kept.len());
        assert_eq!(made.mesh.labels.iter().max(), Some(&0));
    }
}
