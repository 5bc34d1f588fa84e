//! Bridges: where two pieces come nearer to each other than the cells without meeting, marching cubes may join them. The
//! triangles between them are taken out, and what they leave open is closed on each side by itself.

use glam::DVec3;
use rustc_hash::FxHashMap;

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

/// Takes out the bridges whose both sides can be closed; `None` where there are none.
pub(super) fn part_bridges(raw: &Raw<'_>, surface: &dyn Pieces, run: &Run) -> Result<Option<Parted>> {
    let mesh = raw.mesh;
    let piece = ask_all(run, mesh.nodes.len(), |v| surface.piece_at(mesh.nodes[v as usize]))?;
    // For each triangle two of its pieces that are apart.
    let apart = ask_all(run, mesh.triangles.len(), |t| {
        let nodes = mesh.triangles[t as usize];
        (0..3).find_map(|k| {
            let (a, b) = (nodes[k] as usize, nodes[(k + 1) % 3] as usize);
            let (i, j) = (piece[a]?, piece[b]?);
            let meet = || surface.meet(&[i, j], mesh.nodes[a].midpoint(mesh.nodes[b]), APART * raw.cell);
            (i != j && meet().is_none_or(|x| !surface.bounds(&[i, j], x))).then_some([i, j])
        })
    })?;
    let bridges = bridges(mesh, &apart);
    let mut gone = vec![false; mesh.triangles.len()];
    let mut caps: Vec<(Vec<u32>, DVec3)> = Vec::new();
    for bridge in bridges {
        let pairs: Vec<[u32; 2]> = bridge.iter().filter_map(|t| apart[*t as usize]).collect();
        let Some(rings) = rings(mesh, &bridge).filter(|r| r.len() > 1) else { continue };
        let close = |ring: Vec<u32>| {
            let mut on: Vec<u32> = ring.iter().map(|v| piece[*v as usize]).collect::<Option<_>>()?;
            on.sort_unstable();
            on.dedup();
            let both = pairs.iter().any(|p| p.iter().all(|k| on.contains(k)));
            let middle = ring.iter().map(|v| mesh.nodes[*v as usize]).sum::<DVec3>() / ring.len() as f64;
            if both || on.len() > 3 {
                return None;
            }
            let p = surface.meet(&on, middle, APART * raw.cell).filter(|p| surface.bounds(&on, *p))?;
            Some((ring, p))
        };
        let closed: Option<Vec<(Vec<u32>, DVec3)>> = rings.into_iter().map(close).collect();
        if let Some(closed) = closed {
            caps.extend(closed);
            bridge.iter().for_each(|t| gone[*t as usize] = true);
        }
    }
    if caps.is_empty() {
        return Ok(None);
    }
    let mut out = TriMesh { triangles: Vec::new(), labels: Vec::new(), ..mesh.clone() };
    let mut kept = Vec::new();
    for t in (0..mesh.triangles.len()).filter(|t| !gone[*t]) {
        out.triangles.push(mesh.triangles[t]);
        out.labels.push(mesh.labels[t]);
        kept.push(raw.kept.get(t) == Some(&true));
    }
    for (ring, p) in caps {
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

/// The triangles with pieces that are apart, grouped by common edges.
fn bridges(mesh: &TriMesh, apart: &[Option<[u32; 2]>]) -> Vec<Vec<u32>> {
    let members: Vec<u32> = (0..apart.len() as u32).filter(|t| apart[*t as usize].is_some()).collect();
    let of_edge: FxHashMap<[u32; 2], u32> = members.iter().flat_map(|&t| sides(mesh, t).map(move |e| (e, t))).collect();
    let mut seen = vec![false; apart.len()];
    let mut all = Vec::new();
    for &first in &members {
        if std::mem::replace(&mut seen[first as usize], true) {
            continue;
        }
        let mut group = vec![first];
        let mut done = 0;
        while let Some(&t) = group.get(done) {
            done += 1;
            for [a, b] in sides(mesh, t) {
                if let Some(&other) = of_edge.get(&[b, a])
                    && !std::mem::replace(&mut seen[other as usize], true)
                {
                    group.push(other);
                }
            }
        }
        all.push(group);
    }
    all
}

fn sides(mesh: &TriMesh, t: u32) -> impl Iterator<Item = [u32; 2]> {
    let n = mesh.triangles[t as usize];
    (0..3).map(move |k| [n[k], n[(k + 1) % 3]])
}

/// The loops around some triangles, in the direction of these; `None` where more than one passes a node.
fn rings(mesh: &TriMesh, triangles: &[u32]) -> Option<Vec<Vec<u32>>> {
    let mut all: Vec<[u32; 2]> = triangles.iter().flat_map(|t| sides(mesh, *t)).collect();
    all.sort_unstable();
    let open: Vec<[u32; 2]> = all.iter().copied().filter(|[a, b]| all.binary_search(&[*b, *a]).is_err()).collect();
    if open.windows(2).any(|w| w[0][0] == w[1][0]) {
        return None;
    }
    let mut used = vec![false; open.len()];
    let mut rings = Vec::new();
    for first in 0..open.len() {
        let (mut at, mut ring) = (first, Vec::new());
        while !std::mem::replace(&mut used[at], true) {
            ring.push(open[at][0]);
            at = open.binary_search_by_key(&open[at][1], |e| e[0]).ok()?;
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    Some(rings)
}
