//! Local repairs of what intersects: taken out with its surroundings and closed again, or drawn back into its place.

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
/// `pairs` are the intersecting triangles. Returns the mesh with the places of what went; `None` if that does not end.
pub(super) fn refill(mesh: &TriMesh, pairs: &[[u32; 2]], run: &Run) -> Result<Option<(TriMesh, Vec<DVec3>)>> {
    let mut m = mesh.clone();
    let mut places = Vec::new();
    for round in 0..ROUNDS {
        run.check()?;
        let d = m.defects();
        let mut bad = vec![false; m.triangles.len()];
        if round == 0 {
            // later there are none: all of these went, and fillings that intersect are refused
            pairs.iter().flatten().for_each(|t| bad[*t as usize] = true);
        }
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

/// A triangle is stretched if it is this many times larger than the middle one of the mesh.
const STRETCHED: f64 = 4.0;

/// What moves must be this many times larger, on average, than the triangles of the mesh.
const LARGER: f64 = 1.5;

/// Rounds of drawing back; each takes one more ring along.
const DRAWN: usize = 12;

/// A surface of which more than this share would have to move was not just pulled somewhere.
const MOST_MOVED: f64 = 0.3;

/// Draws back a part of a closed surface that was pulled through another: its nodes, those of the stretched triangles around
/// crossings, go where a membrane between the others would hang. The topology stays. Returns the mesh with the places moved
/// from; `None` if what crosses is not stretched or does not come free.
pub(super) fn draw_back(mesh: &TriMesh, run: &Run) -> Result<Option<(TriMesh, Vec<DVec3>)>> {
    let mut m = mesh.clone();
    let area: Vec<f64> = (0..m.triangles.len()).map(|t| m.area_vector(t).length()).collect();
    let mut sorted = area.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let limit = STRETCHED * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let mut free = vec![false; m.nodes.len()];
    let touches = |free: &[bool], t: &[u32; 3]| t.iter().any(|v| free[*v as usize]);
    let mut around: Vec<(u32, u32)> =
        m.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    around.sort_unstable();
    let mut starts = vec![0usize; m.nodes.len() + 1];
    around.iter().for_each(|e| starts[e.0 as usize + 1] += 1);
    (0..m.nodes.len()).for_each(|v| starts[v + 1] += starts[v]);
    for round in 0..DRAWN {
        run.check()?;
        let pairs = self_intersections(&m, run)?;
        if pairs.is_empty() {
            let places = (0..m.nodes.len()).filter(|v| free[*v]).map(|v| mesh.nodes[v]).collect();
            return Ok(Some((m, places)));
        }
        for t in pairs.iter().flatten() {
            m.triangles[*t as usize].iter().for_each(|v| free[*v as usize] = true);
        }
        if round == 0 {
            // all of what is stretched and hangs together with crossings
            loop {
                let more: Vec<usize> = (0..area.len())
                    .filter(|t| {
                        area[*t] > limit
                            && touches(&free, &m.triangles[*t])
                            && !m.triangles[*t].iter().all(|v| free[*v as usize])
                    })
                    .collect();
                if more.is_empty() {
                    break;
                }
                more.iter().for_each(|t| m.triangles[*t].iter().for_each(|v| free[*v as usize] = true));
            }
            let moved: Vec<f64> =
                m.triangles.iter().zip(&area).filter(|(t, _)| touches(&free, t)).map(|(_, a)| *a).collect();
            let mean = |a: &[f64]| a.iter().sum::<f64>() / a.len().max(1) as f64;
            if mean(&moved) < LARGER * mean(&area) {
                return Ok(None);
            }
        } else {
            let ring: Vec<u32> = m.triangles.iter().filter(|t| touches(&free, t)).flatten().copied().collect();
            ring.iter().for_each(|v| free[*v as usize] = true);
        }
        let moving: Vec<usize> = (0..free.len()).filter(|v| free[*v]).collect();
        if moving.len() as f64 > MOST_MOVED * m.nodes.len() as f64 {
            return Ok(None);
        }
        // a membrane of n nodes is at rest after about n sweeps
        for _ in 0..(2 * moving.len()).clamp(50, 1000) {
            for &v in &moving {
                let near = &around[starts[v]..starts[v + 1]];
                if !near.is_empty() {
                    m.nodes[v] = near.iter().map(|e| m.nodes[e.1 as usize]).sum::<DVec3>() / near.len() as f64;
                }
            }
        }
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
