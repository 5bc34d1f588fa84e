//! Corners at one place are one node, where more than three pieces meet in a point and each three of them made one; and borders that go
//! back on themselves are put straight.

use super::patchwork::PieceSet;
use crate::mesh::EditMesh;

/// Nodes that lie on pieces to rounding are at one place when they are nearer than this share of a cell: a cell is a thousandth of a
/// part or more, and Newton's method ends within 1e-15 of the part's size.
const SAME: f64 = 1e-9;

/// Makes one node of neighbors at one place, on the pieces of both, where the mesh stays a manifold.
pub(super) fn join_corners(mesh: &mut EditMesh, sets: &mut [PieceSet], cell: f64) {
    let short: Vec<u32> = mesh.edges().filter(|h| mesh.edge_length(*h) <= SAME * cell).collect();
    for h in short {
        if !mesh.is_edge(h) {
            continue;
        }
        let (a, b) = (mesh.origin(h) as usize, mesh.target(h) as usize);
        let all = sets[a].union(&sets[b]);
        if sets[a].len() > 2 && sets[b].len() > 2 && mesh.merge(h, mesh.point(b as u32)) {
            sets[b] = all;
        }
    }
}

/// A border that goes back on itself turns by more than this, as a cosine: 160 degrees. True borders do that in cusps only, which are
/// corners.
const BACK: f64 = -0.94;

/// Takes out nodes at which a border goes back on itself: where pieces touch, nodes a cell apart may come out in another order along
/// the curve on which they touch.
pub(super) fn straighten_borders(mesh: &mut EditMesh, sets: &[PieceSet]) {
    let mut queue: Vec<u32> = mesh.nodes().filter(|v| sets[*v as usize].len() == 2).collect();
    while let Some(v) = queue.pop() {
        if !mesh.is_node(v) || mesh.is_pinned(v) || sets[v as usize].len() != 2 {
            continue;
        }
        let mut along = mesh.sharp_neighbors(v);
        let (Some(a), Some(b), None) = (along.next(), along.next(), along.next()) else { continue };
        let [to_a, to_b] = [a, b].map(|x| mesh.point(x) - mesh.point(v));
        if !(-to_a.dot(to_b) < BACK * to_a.length() * to_b.length()) {
            continue;
        }
        let near = if to_a.length_squared() <= to_b.length_squared() { a } else { b };
        drop(along);
        let Some(h) = mesh.outgoing(v).find(|h| mesh.target(*h) == near) else { continue };
        if mesh.collapse(h, mesh.point(near)) {
            queue.extend([a, b]);
        }
    }
}
