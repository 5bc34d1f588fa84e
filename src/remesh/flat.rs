//! Strips of no width. Where two pieces touch along a curve and a third one passes there, as the plane does in which a cylinder ends in a
//! ball of its radius, linear interpolants part the two by a strip of the third. All of its nodes come to lie on the curve: it is no part
//! of the surface.

use glam::DVec3;

use super::patchwork::PieceSet;
use crate::geometry::Pieces;
use crate::mesh::EditMesh;
use crate::mesh::edit::NONE;

/// A node lies on a piece when it is nearer to it than this share of a cell.
const ON: f64 = 1e-7;

/// A triangle whose nodes follow each other on a curve is lower than this share of its length.
const THIN: f64 = 1e-3;

fn is_thin([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() <= THIN * longest
}

/// What is known of the triangles.
pub(super) struct TriangleFacts<'a> {
    pub(super) piece: &'a mut [u32],
    /// The face of each, or nothing.
    pub(super) face: &'a mut [u32],
}

/// Whether a node lies on a piece.
fn lies(mesh: &EditMesh, sets: &[PieceSet], surface: &dyn Pieces, [v, piece]: [u32; 2], reach: f64) -> bool {
    let x = mesh.point(v);
    sets[v as usize].has(piece) || surface.meet(&[piece], x, reach).is_some_and(|q| q.distance(x) <= ON * reach)
}

/// Draws nodes of a strip that lie on one piece alone into the curve around them.
fn draw_in(mesh: &mut EditMesh, sets: &[PieceSet], surface: &dyn Pieces, cell: f64) {
    let may = |v: &u32| sets[*v as usize].len() == 1 && !mesh.is_boundary(*v) && !mesh.is_pinned(*v);
    let single: Vec<u32> = mesh.nodes().filter(may).collect();
    for v in single {
        let around: Vec<u32> = mesh.neighbors(v).collect();
        if around.iter().any(|w| sets[*w as usize].len() < 2) {
            continue;
        }
        let all = around.iter().fold(PieceSet::default(), |s, w| s.union(&sets[*w as usize]));
        let own = sets[v as usize].as_slice()[0];
        let on = |p: &&u32| **p != own && around.iter().all(|w| lies(mesh, sets, surface, [*w, **p], cell));
        if all.as_slice().iter().filter(on).count() < 2 {
            continue;
        }
        let away = |w: &u32| mesh.point(*w).distance_squared(mesh.point(v));
        let near = around.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
        let to = |near: u32| mesh.outgoing(v).find(|h| mesh.target(*h) == near);
        if let Some(near) = near
            && let Some(h) = to(near)
        {
            mesh.merge(h, mesh.point(near));
        }
    }
}

/// Gives triangles of strips without width to one of the pieces beside them, and their nodes the pieces that are around them then.
pub(super) fn give_strips_away(
    mesh: &mut EditMesh,
    sets: &mut [PieceSet],
    of: &mut TriangleFacts<'_>,
    surface: &dyn Pieces,
    cell: f64,
) {
    draw_in(mesh, sets, surface, cell);
    let lies = |v: u32, piece: u32| lies(mesh, sets, surface, [v, piece], cell);
    let mut others: Vec<PieceSet> = vec![PieceSet::default(); mesh.triangle_capacity()];
    let mut flat: Vec<u32> = Vec::new();
    for t in mesh.triangles() {
        let corners = mesh.corners(t);
        // Most triangles have a node inside a piece. Others know the nodes where the mesh ends.
        if corners.iter().any(|v| sets[*v as usize].len() < 2 || mesh.is_boundary(*v)) {
            continue;
        }
        let all = corners.iter().fold(PieceSet::default(), |s, v| s.union(&sets[*v as usize]));
        let own = of.piece[t as usize];
        let on = |p: &u32| *p != own && corners.iter().all(|v| lies(*v, *p));
        let others_here: Vec<u32> = all.as_slice().iter().copied().filter(on).collect();
        if others_here.len() >= 2 || others_here.len() == 1 && is_thin(mesh.corner_points(t)) {
            others[t as usize] = PieceSet::of(&others_here);
            flat.push(t);
        }
    }
    let mut touched: Vec<u32> = Vec::new();
    let mut done = vec![false; mesh.triangle_capacity()];
    for first in flat {
        if done[first as usize] {
            continue;
        }
        let own = of.piece[first as usize];
        let mut strip = vec![first];
        let mut beside: Vec<[u32; 2]> = Vec::new();
        done[first as usize] = true;
        let mut k = 0;
        while let Some(&t) = strip.get(k) {
            k += 1;
            for h in 3 * t..3 * t + 3 {
                let o = mesh.opposite(h);
                if o == NONE {
                    continue;
                }
                let u = o / 3;
                let piece = of.piece[u as usize];
                if piece == own && others[u as usize] == others[first as usize] {
                    if !std::mem::replace(&mut done[u as usize], true) {
                        strip.push(u);
                    }
                } else if others[first as usize].has(piece) {
                    beside.push([piece, u]);
                }
            }
        }
        // A strip between two curves has two triangles or more; one alone that is not thin lies at a corner.
        let is_strip = strip.len() > 1 || is_thin(mesh.corner_points(first));
        let Some([piece, neighbor]) = beside.into_iter().min().filter(|_| is_strip) else { continue };
        for t in strip {
            of.piece[t as usize] = piece;
            if !of.face.is_empty() {
                of.face[t as usize] = of.face[neighbor as usize];
            }
            touched.extend(mesh.corners(t));
        }
    }
    touched.sort_unstable();
    touched.dedup();
    for v in touched {
        let around: Vec<u32> = mesh.outgoing(v).map(|h| of.piece[h as usize / 3]).collect();
        sets[v as usize] = PieceSet::of(&around);
    }
}
