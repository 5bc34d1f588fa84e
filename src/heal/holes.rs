//! Closing every contour of open edges, each by the gentlest way that does not intersect.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::clean::areas;
use super::contours::{OpenContour, contours, spanned};
use super::fill::{FillingWay, HoleFilling, HoleSurroundings, fill};
use super::report::{Action, Defect, HealReport};
use super::sides::{Sides, directed, key, pieces};
use crate::error::Result;
use crate::mesh::{TriMesh, intersecting_groups};
use crate::run::Run;

/// What is tried on a contour, in this order; the second says whether the filling is refined.
const TRIES: [(FillingWay, bool); 7] = [
    (FillingWay::Ears, true),
    (FillingWay::Bend, true),
    (FillingWay::Area, true),
    (FillingWay::Bend, false),
    (FillingWay::Area, false),
    (FillingWay::Ears, false),
    (FillingWay::Fan, true),
];

/// The face new triangles are put on.
pub(super) const FILLED: &str = "filled";

/// The number of the face for new triangles, which comes into being when it is first asked for.
pub(super) fn filled_face(mesh: &mut TriMesh) -> u32 {
    if let Some(i) = mesh.faces.iter().position(|f| f == FILLED) {
        return i as u32;
    }
    mesh.faces.push(FILLED.into());
    mesh.faces.len() as u32 - 1
}

/// Mean length of the edges at each node.
pub(super) fn sizes(mesh: &TriMesh) -> Vec<f64> {
    let mut sum = vec![(0.0, 0u32); mesh.nodes.len()];
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let l = mesh.nodes[a as usize].distance(mesh.nodes[b as usize]);
            for v in [a, b] {
                sum[v as usize].0 += l;
                sum[v as usize].1 += 1;
            }
        }
    }
    sum.into_iter().map(|(l, n)| if n == 0 { 0.0 } else { l / f64::from(n) }).collect()
}

/// How many contours stayed open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LeftOpen {
    /// As they are longer than what is to be closed.
    pub(super) wanted: usize,
    /// As no filling fits.
    pub(super) refused: usize,
}

fn places(mesh: &TriMesh, c: &OpenContour) -> Vec<DVec3> {
    c.nodes.iter().map(|v| mesh.nodes[*v as usize]).collect()
}

/// Closes contours whatever their fillings intersect, in pieces that are nearly closed: where the contours span less than
/// `share` of the piece's area. What crosses then is cut like any crossing. Returns the places of the contours.
pub(super) fn force_holes(mesh: &mut TriMesh, share: f64) -> Result<Vec<DVec3>> {
    let sides = Sides::of(&mesh.triangles);
    let (piece, count) = pieces(mesh.triangles.len(), &sides, |_| true);
    let area = areas(mesh, &piece, count);
    let mut of_node = vec![0u32; mesh.nodes.len()];
    for (tri, p) in mesh.triangles.iter().zip(&piece) {
        tri.iter().for_each(|v| of_node[*v as usize] = *p);
    }
    let all = contours(mesh);
    let mut span = vec![0.0; count];
    for c in &all {
        span[of_node[c.nodes[0] as usize] as usize] += spanned(mesh, &c.nodes);
    }
    let mut edges: FxHashSet<u64> = sides.edges().map(|e| e[0].key).collect();
    let (size, apex) = (sizes(mesh), FxHashMap::default());
    let face = filled_face(mesh);
    let mut out = Vec::new();
    for c in &all {
        let p = of_node[c.nodes[0] as usize] as usize;
        if span[p] > share * area[p] {
            continue;
        }
        for way in [FillingWay::Area, FillingWay::Ears, FillingWay::Fan] {
            let Some(f) =
                fill(&HoleSurroundings { mesh, edges: &edges, size: &size, apex: &apex }, &c.nodes, way, false)?
            else {
                continue;
            };
            mesh.nodes.extend(f.nodes);
            for t in f.triangles {
                (0..3).for_each(|k| {
                    edges.insert(key(t[k], t[(k + 1) % 3]));
                });
                mesh.triangles.push(t);
                mesh.labels.push(face);
            }
            out.extend(places(mesh, c));
            break;
        }
    }
    Ok(out)
}

/// Closes the contours of at most `longest` edges. A filling that would intersect the mesh or another filling is refused
/// and the next way is tried; what no way closes stays open.
pub(super) fn close_holes(
    mesh: &mut TriMesh,
    longest: usize,
    defect: Defect,
    report: &mut HealReport,
    run: &Run,
) -> Result<LeftOpen> {
    let all = contours(mesh);
    let (todo, long): (Vec<OpenContour>, Vec<OpenContour>) = all.into_iter().partition(|c| c.nodes.len() <= longest);
    for c in &long {
        report.add(defect, Action::Left, c.nodes.len(), &places(mesh, c));
    }
    if todo.is_empty() {
        return Ok(LeftOpen { wanted: long.len(), refused: 0 });
    }
    let mut edges: FxHashSet<u64> = FxHashSet::default();
    let mut apex: FxHashMap<u64, u32> = FxHashMap::default();
    let sides = Sides::of(&mesh.triangles);
    for e in sides.edges() {
        edges.insert(e[0].key);
        if let [s] = e {
            let [a, b] = directed(&mesh.triangles, s.half);
            let x = mesh.triangles[s.triangle()][(s.half as usize + 2) % 3];
            apex.insert(u64::from(a) << 32 | u64::from(b), x);
        }
    }
    let size = sizes(mesh);
    let mut tried = vec![0usize; todo.len()];
    let face = filled_face(mesh);
    let trial = loop {
        run.check()?;
        let mut drawn = edges.clone();
        let mut trial = mesh.clone();
        let mut owner: Vec<u32> = Vec::new();
        for (i, c) in todo.iter().enumerate() {
            let mut made: Option<HoleFilling> = None;
            while tried[i] < TRIES.len() && made.is_none() {
                let (way, refine) = TRIES[tried[i]];
                made =
                    fill(&HoleSurroundings { mesh, edges: &drawn, size: &size, apex: &apex }, &c.nodes, way, refine)?;
                if made.is_none() {
                    tried[i] += 1;
                }
            }
            let Some(f) = made else { continue };
            let (old, base) = (mesh.nodes.len() as u32, trial.nodes.len() as u32);
            trial.nodes.extend(f.nodes);
            for t in f.triangles {
                let t = t.map(|v| if v < old { v } else { v - old + base });
                (0..3).for_each(|k| {
                    drawn.insert(key(t[k], t[(k + 1) % 3]));
                });
                trial.triangles.push(t);
                trial.labels.push(face);
                owner.push(i as u32);
            }
        }
        let (mut bad, pairs) = intersecting_groups(&trial, &owner, run)?;
        bad.resize(todo.len(), false);
        for pair in pairs {
            // Of two fillings the later one gives way first, if it has a way left.
            if let Some(i) = pair.map(|i| i as usize).into_iter().max_by_key(|i| (std::cmp::Reverse(tried[*i]), *i)) {
                bad[i] = true;
            }
        }
        if !bad.iter().any(|b| *b) {
            break trial;
        }
        for (i, bad) in bad.iter().enumerate() {
            tried[i] += usize::from(*bad);
        }
    };
    let mut left = LeftOpen { wanted: long.len(), refused: 0 };
    for (c, tried) in todo.iter().zip(&tried) {
        let action = match TRIES.get(*tried) {
            None => Action::Left,
            Some(_) if c.continued => Action::FilledByContinuation,
            Some((FillingWay::Ears, _)) => Action::Filled,
            Some(_) => Action::FilledOtherwise,
        };
        left.refused += usize::from(action == Action::Left);
        report.add(defect, action, c.nodes.len(), &places(mesh, c));
    }
    *mesh = trial;
    Ok(left)
}
