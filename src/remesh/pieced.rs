//! The patchwork of a mesh whose triangles lie on one piece each: what the remesher begins with.

use glam::DVec3;

use super::apexes::put_apexes;
use super::concurrent::straighten_borders;
use super::flat::{TriangleFacts, give_strips_away};
use super::joints::Pieced;
use super::patchwork::{Patchwork, PiecePatch, PieceSet};
use super::pointed::fan_tips;
use super::policy::Policy;
use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::{EditMesh, TriMesh, edit::NONE};
use crate::spatial::{Aabb, Bvh};

/// A mesh whose every triangle lies on the piece that is its label.
#[derive(Debug, Clone, Copy)]
pub struct InPieces<'a> {
    /// Its labels are pieces.
    pub mesh: &'a TriMesh,
    /// The pieces of each node.
    pub on: &'a [Vec<u32>],
    /// The face of each triangle, or nothing.
    pub faces: &'a [u32],
    /// Where triangles stay as they are: nothing is joined or straightened there, but apexes have their nodes.
    pub stays: &'a [Aabb],
}

/// A mesh as a patchwork. Corners at one place are joined, strips without width given away, and joints and apexes get nodes.
///
/// *Errors*: [`Error::Input`](crate::Error::Input) for a mesh that is no oriented manifold.
pub fn patch_pieces(given: &InPieces<'_>, surface: &dyn Pieces, cell: f64) -> Result<Patchwork> {
    let InPieces { mesh, on, faces, stays } = *given;
    let fanned = fan_tips(mesh, on, faces, surface, cell);
    let (mesh, on, faces) = fanned.as_ref().map_or((mesh, on, faces), |f| (&f.mesh, &f.on[..], &f.faces[..]));
    let mut edit = EditMesh::new(mesh)?;
    let mut sets: Vec<PieceSet> = on.iter().map(|pieces| PieceSet::of(pieces)).collect();
    let mut of_triangle = mesh.labels.clone();
    let mut faces = faces.to_vec();
    let held = nodes_in(&edit, stays);
    hold(&mut edit, &held, true);
    Pieced { mesh: &mut edit, sets: &mut sets, of_triangle: &of_triangle, cell }.join_corners();
    let mut of = TriangleFacts { piece: &mut of_triangle, face: &mut faces };
    give_strips_away(&mut edit, &mut sets, &mut of, surface, cell);
    Pieced { mesh: &mut edit, sets: &mut sets, of_triangle: &of_triangle, cell }.pinch(surface);
    // An apex that stays has its node all the same.
    hold(&mut edit, &held, false);
    put_apexes(&mut edit, &mut sets, &mut of_triangle, surface, cell);
    let patches = patches(&mut edit, &of_triangle, &faces, surface);
    let held: Vec<u32> = held.into_iter().filter(|v| edit.is_node(*v) && !edit.is_pinned(*v)).collect();
    hold(&mut edit, &held, true);
    straighten_borders(&mut edit, &sets);
    hold(&mut edit, &held, false);
    Ok(Patchwork { policy: Policy::of_functions(), ..Patchwork::new(edit, sets, patches.into()) })
}

/// The nodes of triangles whose boxes meet some boxes.
fn nodes_in(mesh: &EditMesh, boxes: &[Aabb]) -> Vec<u32> {
    if boxes.is_empty() {
        return Vec::new();
    }
    let tree = Bvh::new(boxes.to_vec());
    let is_in = |t: &u32| tree.meets(&Aabb::around(mesh.corner_points(*t)));
    mesh.triangles().filter(is_in).flat_map(|t| mesh.corners(t)).collect()
}

fn hold(mesh: &mut EditMesh, nodes: &[u32], held: bool) {
    nodes.iter().for_each(|v| mesh.set_pinned(*v, held));
}

/// The same of a mesh beyond whose open edges the surface goes on, in others that have the same nodes there. These are no border
/// between pieces, and stay as they are.
///
/// *Errors*: [`Error::Input`](crate::Error::Input) for a mesh that is no oriented manifold.
pub fn patch_open_pieces(given: &InPieces<'_>, surface: &dyn Pieces, cell: f64) -> Result<Patchwork> {
    let mut work = patch_pieces(given, surface, cell)?;
    work.policy.goes_on = true;
    for h in 0..3 * work.mesh.triangle_capacity() as u32 {
        if work.mesh.is_triangle(h / 3) && work.mesh.opposite(h) == NONE {
            work.mesh.set_sharp(h, false);
        }
    }
    Ok(work)
}

/// Connected regions of triangles on one piece and of one face, where there are `faces`; labels of the triangles become their numbers, and edges between regions
/// are marked sharp.
fn patches(mesh: &mut EditMesh, of_triangle: &[u32], faces: &[u32], surface: &dyn Pieces) -> Vec<PiecePatch> {
    let face = |t: u32| faces.get(t as usize).copied().unwrap_or(NONE);
    let apart = |t: u32, u: u32| of_triangle[t as usize] != of_triangle[u as usize] || face(t) != face(u);
    for h in 0..3 * mesh.triangle_capacity() as u32 {
        if mesh.is_edge(h) {
            let o = mesh.opposite(h);
            let border = o == NONE || apart(h / 3, o / 3);
            mesh.set_sharp(h, border);
        }
    }
    let mut number = vec![NONE; mesh.triangle_capacity()];
    let mut patches = Vec::new();
    let mut stack = Vec::new();
    for first in 0..number.len() as u32 {
        if number[first as usize] != NONE || !mesh.is_triangle(first) {
            continue;
        }
        let id = patches.len() as u32;
        let piece = of_triangle[first as usize];
        let mut facing = 0.0;
        number[first as usize] = id;
        stack.push(first);
        while let Some(t) = stack.pop() {
            if let Some(n) = surface.direction(piece, mesh.centroid(t)) {
                facing += mesh.area_vector(t).dot(n);
            }
            mesh.set_surface(t, id, DVec3::ZERO);
            for h in 3 * t..3 * t + 3 {
                let o = mesh.opposite(h);
                if o != NONE && !mesh.is_sharp(h) && number[(o / 3) as usize] == NONE {
                    number[(o / 3) as usize] = id;
                    stack.push(o / 3);
                }
            }
        }
        let plane = if piece == NONE { None } else { surface.plane(piece) };
        patches.push(PiecePatch { piece, outward: if facing >= 0.0 { 1.0 } else { -1.0 }, plane, face: face(first) });
    }
    patches
}
