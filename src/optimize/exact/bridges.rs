//! Bridges: where two pieces come nearer to each other than the cells without meeting, marching cubes may join them. The
//! triangles between them are taken out, and what they leave open is closed on each piece by itself.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::cut::Raw;
use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::optimize::guard::ask_all;
use crate::run::Run;

/// Pieces that do not meet within so many cells are apart.
const APART: f64 = 4.0;

/// A mesh without its bridges, and which of its triangles are to stay as they are.
pub(super) struct Parted {
    pub(super) mesh: TriMesh,
    pub(super) kept: Vec<bool>,
}

/// Takes out all bridges, or none: `None` where there are none, or where what they leave open does not lie on one piece.
pub(super) fn part_bridges(raw: &Raw<'_>, surface: &dyn Pieces, run: &Run) -> Result<Option<Parted>> {
    let mesh = raw.mesh;
    let piece = ask_all(run, mesh.nodes.len(), |v| surface.piece_at(mesh.nodes[v as usize]))?;
    let apart = ask_all(run, mesh.triangles.len(), |t| {
        let nodes = mesh.triangles[t as usize];
        let on = nodes.map(|v| piece[v as usize]);
        let bridges = (0..3).any(|k| match (on[k], on[(k + 1) % 3]) {
            (Some(i), Some(j)) if i != j => {
                let [p, q] = [nodes[k], nodes[(k + 1) % 3]].map(|v| mesh.nodes[v as usize]);
                surface.meet(&[i, j], p.midpoint(q), APART * raw.cell).is_none()
            }
            _ => false,
        });
        bridges.then_some(())
    })?;
    if apart.iter().all(Option::is_none) {
        return Ok(None);
    }
    // The edges left open, by their first node, in the direction of the triangle that is gone.
    let gone = || mesh.triangles.iter().zip(&apart).filter(|(_, a)| a.is_some()).map(|(t, _)| *t);
    let sides = |t: [u32; 3]| (0..3).map(move |k| [t[k], t[(k + 1) % 3]]);
    let all: FxHashSet<[u32; 2]> = gone().flat_map(sides).collect();
    let mut edges: Vec<[u32; 2]> = gone().flat_map(sides).filter(|[a, b]| !all.contains(&[*b, *a])).collect();
    edges.sort_unstable();
    let Some(loops) = loops(&edges) else { return Ok(None) };
    let mut out = TriMesh { triangles: Vec::new(), labels: Vec::new(), ..mesh.clone() };
    let mut kept = Vec::new();
    for (t, nodes) in mesh.triangles.iter().enumerate().filter(|(t, _)| apart[*t].is_none()) {
        out.triangles.push(*nodes);
        out.labels.push(mesh.labels[t]);
        kept.push(raw.kept.get(t) == Some(&true));
    }
    for ring in loops {
        let Some(own) = piece[ring[0] as usize] else { return Ok(None) };
        if ring.iter().any(|v| piece[*v as usize] != Some(own)) {
            return Ok(None);
        }
        let middle = ring.iter().map(|v| mesh.nodes[*v as usize]).sum::<DVec3>() / ring.len() as f64;
        let Some(p) = surface.meet(&[own], middle, APART * raw.cell) else { return Ok(None) };
        let center = out.nodes.len() as u32;
        out.nodes.push(p);
        for k in 0..ring.len() {
            out.triangles.push([ring[k], ring[(k + 1) % ring.len()], center]);
            out.labels.push(0);
            kept.push(false);
        }
    }
    Ok(Some(Parted { mesh: out, kept }))
}

/// Joins edges, sorted by their first nodes, to loops; `None` where more than one leaves a node.
fn loops(edges: &[[u32; 2]]) -> Option<Vec<Vec<u32>>> {
    if edges.windows(2).any(|w| w[0][0] == w[1][0]) {
        return None;
    }
    let mut used = vec![false; edges.len()];
    let mut all = Vec::new();
    for first in 0..edges.len() {
        let (mut at, mut ring) = (first, Vec::new());
        while !used[at] {
            used[at] = true;
            ring.push(edges[at][0]);
            at = edges.binary_search_by_key(&edges[at][1], |e| e[0]).ok()?;
        }
        if !ring.is_empty() {
            all.push(ring);
        }
    }
    Some(all)
}
