//! Taking out what intersects, with its surroundings, and closing what is left.

use glam::DVec3;

use super::clean::{areas, retain};
use super::holes::close_holes;
use super::report::{Defect, HealReport};
use super::sides::{Sides, pieces};
use crate::error::Result;
use crate::mesh::{TriMesh, self_intersections};
use crate::run::Run;

/// Rounds of taking out and closing; each later one takes out a wider ring.
const ROUNDS: usize = 7;

/// What a piece is cut into stays if it has this share of the piece's area; the largest part always stays.
const LOOSE_SHARE: f64 = 0.1;

/// Takes out triangles that intersect or hang on non-manifold edges and nodes, then what came loose, and closes the holes.
/// Returns the mesh with the places of what went; `None` if that does not end.
pub(super) fn refill(mesh: &TriMesh, run: &Run) -> Result<Option<(TriMesh, Vec<DVec3>)>> {
    let mut m = mesh.clone();
    let mut places = Vec::new();
    for round in 0..ROUNDS {
        run.check()?;
        let d = m.defects();
        let mut bad = vec![false; m.triangles.len()];
        self_intersections(&m, run)?.iter().flatten().for_each(|t| bad[*t as usize] = true);
        let mut node = vec![false; m.nodes.len()];
        for e in d.nonmanifold_edges.iter().chain(&d.misoriented_edges) {
            e.iter().for_each(|v| node[*v as usize] = true);
        }
        d.nonmanifold_nodes.iter().for_each(|v| node[*v as usize] = true);
        if round > 0 {
            // a hole no filling fits into gets wider
            d.open_edges.iter().flatten().for_each(|v| node[*v as usize] = true);
        }
        for (t, tri) in m.triangles.iter().enumerate() {
            bad[t] |= tri.iter().any(|v| node[*v as usize]);
        }
        if !bad.contains(&true) && d.open_edges.is_empty() {
            return Ok(Some((m, places)));
        }
        for _ in 0..round.min(3) {
            grow(&m, &mut bad);
        }
        let sides = Sides::of(&m.triangles);
        let (before, _) = pieces(m.triangles.len(), &sides, |_| true);
        places.extend((0..bad.len()).filter(|t| bad[*t]).map(|t| m.centroid(t)));
        let kept_of: Vec<u32> = before.iter().zip(&bad).filter(|(_, b)| !**b).map(|(p, _)| *p).collect();
        retain(&mut m, |t| !bad[t]);
        if m.triangles.is_empty() {
            return Ok(None);
        }
        drop_loose(&mut m, &kept_of, &mut places);
        let mut unseen = HealReport::default();
        close_holes(&mut m, usize::MAX, Defect::Hole, &mut unseen, run)?;
        m.drop_unused_nodes();
    }
    Ok(None)
}

/// Adds the triangles that share a node with those marked.
fn grow(mesh: &TriMesh, bad: &mut [bool]) {
    let mut node = vec![false; mesh.nodes.len()];
    for (tri, _) in mesh.triangles.iter().zip(bad.iter()).filter(|(_, b)| **b) {
        tri.iter().for_each(|v| node[*v as usize] = true);
    }
    for (tri, b) in mesh.triangles.iter().zip(bad) {
        *b |= tri.iter().any(|v| node[*v as usize]);
    }
}

/// Of what each former piece was cut into, small parts go.
fn drop_loose(mesh: &mut TriMesh, former: &[u32], places: &mut Vec<DVec3>) {
    let sides = Sides::of(&mesh.triangles);
    let (part, count) = pieces(mesh.triangles.len(), &sides, |e| e.len() == 2);
    let area = areas(mesh, &part, count);
    let most = former.iter().max().map_or(0, |m| *m as usize + 1);
    let (mut total, mut best) = (vec![0.0; most], vec![(0.0, u32::MAX); most]);
    let mut seen = vec![false; count];
    for (t, p) in part.iter().enumerate() {
        if !seen[*p as usize] {
            seen[*p as usize] = true;
            let f = former[t] as usize;
            total[f] += area[*p as usize];
            if area[*p as usize] > best[f].0 {
                best[f] = (area[*p as usize], *p);
            }
        }
    }
    let stays: Vec<bool> = part
        .iter()
        .zip(former)
        .map(|(p, f)| best[*f as usize].1 == *p || area[*p as usize] >= LOOSE_SHARE * total[*f as usize])
        .collect();
    places.extend((0..stays.len()).filter(|t| !stays[*t]).map(|t| mesh.centroid(t)));
    retain(mesh, |t| stays[t]);
}
