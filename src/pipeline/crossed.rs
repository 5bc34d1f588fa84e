//! Where triangles cross, in a mesh and all along a row of places in an arrangement.

use crate::error::Result;
use crate::mesh::self_intersections;
use crate::remesh::RemeshedMesh;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// How far around what is at fault triangles stay, once more each time, as a share of the edges there.
pub(super) const ROOM: f64 = 0.5;
/// Crossings are in a row where so many edges fit between them: with one edge two random trees took a third attempt, with two none.
const IN_A_ROW: f64 = 2.0;

/// Boxes around places where triangles cross, and around those that are folded, with the length of edges there. Of a long triangle that is
/// a small part.
pub(super) fn crossed(made: &RemeshedMesh, run: &Run) -> Result<Vec<(Aabb, f64)>> {
    let RemeshedMesh { mesh, report, .. } = made;
    if report.self_intersections + report.inverted == 0 {
        return Ok(Vec::new());
    }
    let pairs = self_intersections(mesh, run)?.into_iter().map(|pair| mesh.meeting(pair));
    let folded = report.faults.iter().skip(report.self_intersections).map(|b| (*b, b.size().max_element()));
    Ok(pairs.chain(folded).collect())
}

/// Places, and of those where triangles of an arrangement cross, with the lengths of edges there, the ones in a row from one of them. Surfaces
/// run into each other along a line: where it stays as it comes at one end, triangles cross beside that next.
pub(super) fn with_all_along(crossed: &[(Aabb, f64)], mut places: Vec<Aabb>) -> Vec<Aabb> {
    let grown = crossed.iter().map(|(b, l)| (b.grown(ROOM * l), b.grown(IN_A_ROW * l)));
    let (crossed, beside): (Vec<_>, Vec<_>) = grown.unzip();
    let (tree, mut known) = (Bvh::new(beside), vec![false; crossed.len()]);
    let mut next = 0;
    while let Some(place) = places.get(next).copied() {
        tree.overlapping(&place, |k| {
            if !std::mem::replace(&mut known[k as usize], true) {
                places.push(crossed[k as usize]);
            }
        });
        next += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use glam::DVec3;

    #[test]
    fn crossings_in_a_row_stay_together() {
        // Pairs of triangles that cross, 1.5 edges apart from each other, but for the last one.
        let mut mesh = TriMesh::default();
        for x in [0.0, 2.5, 5.0, 12.0] {
            for corners in [
                [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                [[0.2, 0.2, -0.5], [0.4, 0.2, -0.5], [0.3, 0.3, 0.5]],
            ] {
                let first = mesh.nodes.len() as u32;
                mesh.nodes.extend(corners.map(|c| DVec3::from(c) + x * DVec3::X));
                mesh.triangles.push([first, first + 1, first + 2]);
                mesh.labels.push(0);
            }
        }
        let at = |x: f64| Aabb::around([DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 0.1)]);
        let pairs = self_intersections(&mesh, &Run::new()).unwrap();
        let crossed: Vec<_> = pairs.into_iter().map(|pair| mesh.meeting(pair)).collect();
        let kept = with_all_along(&crossed, vec![at(0.0)]);
        assert_eq!(kept.len(), 4);
        assert!(kept.iter().any(|b| b.overlaps(&at(5.0))) && !kept.iter().any(|b| b.overlaps(&at(12.0))));
        let alone = with_all_along(&crossed, vec![at(20.0)]);
        assert_eq!(alone, [at(20.0)]);
    }
}
