//! Gentlest repairs: nodes at one place, triangles that are none, duplicates, fins, orientation.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::report::{Action, Defect, HealReport};
use super::sides::{EdgeSide, Sides, directed, pieces};
use super::winding::winding;
use crate::mesh::TriMesh;
use crate::numeric::predicates::orient2d;

/// A hanging piece larger than this share of the area is a sheet of its own, not a fin.
const FIN_SHARE: f64 = 0.01;

/// Keeps the triangles for which `keep` says so.
pub(super) fn retain(mesh: &mut TriMesh, keep: impl Fn(usize) -> bool) -> usize {
    let before = mesh.triangles.len();
    let mut to = 0;
    for t in 0..before {
        if keep(t) {
            mesh.triangles[to] = mesh.triangles[t];
            mesh.labels[to] = mesh.labels[t];
            to += 1;
        }
    }
    mesh.triangles.truncate(to);
    mesh.labels.truncate(to);
    before - to
}

/// Exactly without area: the corners lie on a line in all three projections.
pub(super) fn is_flat(p: [DVec3; 3]) -> bool {
    let flat = |f: fn(DVec3) -> glam::DVec2| orient2d(f(p[0]), f(p[1]), f(p[2])) == 0.0;
    flat(|v| v.truncate()) && flat(|v| glam::DVec2::new(v.y, v.z)) && flat(|v| glam::DVec2::new(v.z, v.x))
}

/// Makes nodes at exactly one place one node. Returns the places.
pub(super) fn weld(mesh: &mut TriMesh) -> Vec<DVec3> {
    let mut first: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    let mut merged = Vec::new();
    let to: Vec<u32> = (0..mesh.nodes.len() as u32)
        .map(|v| {
            let p = mesh.nodes[v as usize];
            let to = *first.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(v);
            if to != v {
                merged.push(p);
            }
            to
        })
        .collect();
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = to[*v as usize]);
    merged
}

/// Nodes at one place, triangles on a line, duplicates.
pub(super) fn clean(mesh: &mut TriMesh, report: &mut HealReport) {
    let places = weld(mesh);
    report.add(Defect::CoincidentNodes, Action::Merged, places.len(), &places);
    let flat: Vec<bool> = (0..mesh.triangles.len()).map(|t| is_flat(mesh.corners(t))).collect();
    let places: Vec<DVec3> = (0..flat.len()).filter(|t| flat[*t]).map(|t| mesh.centroid(t)).collect();
    report.add(Defect::DegenerateTriangle, Action::Removed, places.len(), &places);
    retain(mesh, |t| !flat[t]);
    drop_duplicates(mesh, report);
}

/// Of triangles with the same nodes and orientation one is left. Of two that face each other one is left where the
/// surface goes on at each edge as if there were only one; elsewhere they are a wall between bodies.
pub(super) fn drop_duplicates(mesh: &mut TriMesh, report: &mut HealReport) {
    let mut sorted: Vec<([u32; 3], bool, u32)> = (0..mesh.triangles.len())
        .map(|t| {
            let mut s = mesh.triangles[t];
            let [a, b, c] = s;
            s.sort_unstable();
            (s, [[a, b, c], [b, c, a], [c, a, b]].contains(&s), t as u32)
        })
        .collect();
    sorted.sort_unstable();
    let mut keep = vec![true; mesh.triangles.len()];
    for w in sorted.windows(2).filter(|w| w[0].0 == w[1].0 && w[0].1 == w[1].1) {
        keep[w[1].2 as usize] = false;
    }
    let groups: Vec<&[([u32; 3], bool, u32)]> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
    if groups.iter().any(|g| g[0].1 != g[g.len() - 1].1) {
        let unique: Vec<[u32; 3]> = groups.iter().map(|g| mesh.triangles[g[0].2 as usize]).collect();
        let sides = Sides::of(&unique);
        let faced: Vec<bool> = groups.iter().map(|g| g[0].1 != g[g.len() - 1].1).collect();
        // a patch of such pairs is a wall if something else goes on at its border on both sides of it
        let (patch, count) = pieces(unique.len(), &sides, |e| e.iter().all(|s| faced[s.triangle()]));
        let mut wall = vec![false; count];
        for e in sides.edges().filter(|e| e.len() > 2) {
            e.iter().for_each(|s| wall[patch[s.triangle()] as usize] = true);
        }
        for (_, g) in groups.iter().enumerate().filter(|(i, _)| faced[*i] && !wall[patch[*i] as usize]) {
            g[1..].iter().for_each(|m| keep[m.2 as usize] = false);
        }
    }
    let places: Vec<DVec3> = (0..keep.len()).filter(|t| !keep[*t]).map(|t| mesh.centroid(t)).collect();
    report.add(Defect::DuplicateTriangle, Action::Removed, places.len(), &places);
    retain(mesh, |t| keep[t]);
}

/// Area of each piece.
pub(super) fn areas(mesh: &TriMesh, piece: &[u32], count: usize) -> Vec<f64> {
    let mut area = vec![0.0; count];
    for (t, p) in piece.iter().enumerate() {
        area[*p as usize] += 0.5 * mesh.area_vector(t).length();
    }
    area
}

/// Takes away small pieces that hang on an edge of other triangles and end in open edges.
pub(super) fn drop_fins(mesh: &mut TriMesh, report: &mut HealReport) {
    let total = mesh.area();
    loop {
        let sides = Sides::of(&mesh.triangles);
        if sides.edges().all(|e| e.len() <= 2) {
            return;
        }
        let (piece, count) = pieces(mesh.triangles.len(), &sides, |e| e.len() == 2);
        let area = areas(mesh, &piece, count);
        let (mut open, mut hangs) = (vec![false; count], vec![false; count]);
        for e in sides.edges() {
            for s in e {
                let p = piece[s.triangle()] as usize;
                open[p] |= e.len() == 1;
                hangs[p] |= e.len() > 2;
            }
        }
        let fin = |p: usize| open[p] && hangs[p] && area[p] < FIN_SHARE * total;
        let Some(first) = (0..count).filter(|p| fin(*p)).min_by(|a, b| area[*a].total_cmp(&area[*b])) else { return };
        let gone: Vec<DVec3> =
            (0..piece.len()).filter(|t| piece[*t] as usize == first).map(|t| mesh.centroid(t)).collect();
        report.add(Defect::Fin, Action::Removed, gone.len(), &gone);
        retain(mesh, |t| piece[t] as usize != first);
    }
}

/// Makes neighbors agree on which side is out: in each piece the larger area keeps its side. Returns whether all could.
pub(super) fn orient(mesh: &mut TriMesh, report: &mut HealReport) -> bool {
    let sides = Sides::of(&mesh.triangles);
    let n = mesh.triangles.len();
    // the neighbor over each side, and whether it must be turned relative to this one
    let mut over: Vec<(u32, bool)> = vec![(u32::MAX, false); 3 * n];
    for e in sides.edges() {
        if let [a, b] = e {
            let turned = directed(&mesh.triangles, a.half) == directed(&mesh.triangles, b.half);
            over[a.half as usize] = (b.half / 3, turned);
            over[b.half as usize] = (a.half / 3, turned);
        }
    }
    let (mut seen, mut turn) = (vec![false; n], vec![false; n]);
    let mut consistent = true;
    let mut places = Vec::new();
    for start in 0..n {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut piece = vec![start];
        let mut at = 0;
        while at < piece.len() {
            let t = piece[at];
            at += 1;
            for k in 0..3 {
                let (u, turned) = over[3 * t + k];
                if u == u32::MAX {
                    continue;
                }
                let u = u as usize;
                if !seen[u] {
                    seen[u] = true;
                    turn[u] = turn[t] ^ turned;
                    piece.push(u);
                } else if turn[u] != turn[t] ^ turned {
                    consistent = false;
                }
            }
        }
        let area = |side: bool| -> f64 {
            piece.iter().filter(|t| turn[**t] == side).map(|t| mesh.area_vector(*t).length()).sum()
        };
        if area(true) > area(false) {
            piece.iter().for_each(|t| turn[*t] = !turn[*t]);
        }
        places.extend(piece.iter().filter(|t| turn[**t]).map(|t| mesh.centroid(*t)));
    }
    report.add(Defect::Orientation, Action::Flipped, places.len(), &places);
    for t in (0..n).filter(|t| turn[*t]) {
        mesh.triangles[t].swap(1, 2);
    }
    consistent
}

/// Turns closed pieces with a negative volume that lie in no other piece: in another one they are cavities.
pub(super) fn turn_outward(mesh: &mut TriMesh, report: &mut HealReport) {
    let sides = Sides::of(&mesh.triangles);
    let (piece, count) = pieces(mesh.triangles.len(), &sides, |_| true);
    let mut closed = vec![true; count];
    for e in sides.edges().filter(|e| !balanced(&mesh.triangles, e)) {
        closed[piece[e[0].triangle()] as usize] = false;
    }
    let o = mesh.nodes.first().copied().unwrap_or_default();
    let (mut volume, mut first) = (vec![0.0; count], vec![DVec3::ZERO; count]);
    for (t, p) in piece.iter().enumerate() {
        let [a, b, c] = mesh.corners(t).map(|x| x - o);
        volume[*p as usize] += a.dot(b.cross(c));
        first[*p as usize] = a + o;
    }
    let mut turn = vec![false; count];
    for p in (0..count).filter(|p| closed[*p] && volume[*p] < 0.0) {
        let mut around = vec![0.0; count];
        for (t, q) in piece.iter().enumerate().filter(|(_, q)| **q as usize != p && closed[**q as usize]) {
            around[*q as usize] += winding(mesh.corners(t).map(|x| x - first[p]));
        }
        turn[p] = around.iter().all(|w| w.abs() < 0.5);
    }
    let turned: Vec<usize> = (0..piece.len()).filter(|t| turn[piece[*t] as usize]).collect();
    let places: Vec<DVec3> = turned.iter().map(|t| mesh.centroid(*t)).collect();
    report.add(Defect::Orientation, Action::Flipped, places.len(), &places);
    turned.iter().for_each(|t| mesh.triangles[*t].swap(1, 2));
}

/// Whether the sides on an edge cancel: as many run one way as the other.
pub(super) fn balanced(triangles: &[[u32; 3]], e: &[EdgeSide]) -> bool {
    let forward = e.iter().filter(|s| {
        let [a, b] = directed(triangles, s.half);
        a < b
    });
    2 * forward.count() == e.len()
}
