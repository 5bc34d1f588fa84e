//! Borders that nearly meet: edge to edge, and nodes that lie on edges they are not part of (T-junctions).

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::clean::{drop_duplicates, retain};
use super::report::{Action, Defect, HealReport};
use super::sides::{Sides, directed};
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::{COS_20, Sets};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Tolerances tried one after the other, as shares of the diagonal: what the smallest joins is not looked at again. Above
/// the last, which is how far the input may be left, a gap is a hole, not an inaccuracy.
const LADDER: [f64; 9] = [1e-9, 1e-8, 1e-7, 1e-6, 3e-6, 1e-5, 2.5e-5, 5e-5, 1e-4];

/// Nodes of one place that were rounded on their way are no farther apart than this share of the diagonal: single precision leaves a
/// ten millionth of a coordinate, turning and scaling a few times that.
pub(super) const ROUNDED: f64 = 1e-6;

/// Up to this tolerance contours are joined still if each of their edges has its counterpart: a surface that was torn, with
/// what single precision or another tool left of its nodes. Holes have edges at their ends.
const TORN: f64 = 1e-3;

/// Tolerances tried after that on a mesh that is nothing but scattered corners: on one that has holes as well the border of
/// a hole would be all there is left to join.
const SCATTERED: [f64; 5] = [2e-4, 5e-4, 1e-3, 2e-3, 5e-3];

/// Corners are scattered where this share of all sides is open, more than holes leave.
const MOSTLY_OPEN: f64 = 0.9;

/// An edge is joined only to one that is this much longer than the gap, or more.
const LENGTH_PER_GAP: f64 = 4.0;

/// The same where corners are scattered: each side has its counterpart there, which is nearer than any other.
const LENGTH_PER_SCATTER: f64 = 2.0;

/// Cells that edges are looked up in, as multiples of the gap: of wider ones mostly one or two are needed.
const CELL_PER_GAP: f64 = 4.0;

/// Joins borders step by step, from the smallest tolerance to the largest that open edges are left for: first edges that
/// run side by side, then T-junctions, which a border whose nodes are merely scattered would be taken for. No gap is joined that is wider
/// than the share `most` of the diagonal.
pub(super) fn stitch(mesh: &mut TriMesh, diagonal: f64, most: f64, report: &mut HealReport, run: &Run) -> Result<()> {
    let mut open = Sides::of(&mesh.triangles).open();
    let scattered = open.len() as f64 >= MOSTLY_OPEN * 3.0 * mesh.triangles.len() as f64;
    for junctions in [false, true] {
        for share in LADDER.iter().chain(if junctions { &[][..] } else { &SCATTERED }) {
            run.check()?;
            if open.is_empty() {
                return Ok(());
            }
            if *share > most {
                break;
            }
            let beyond = *share > LADDER[LADDER.len() - 1];
            if beyond && !scattered && *share > TORN {
                break;
            }
            let per_gap = if beyond && scattered { LENGTH_PER_SCATTER } else { LENGTH_PER_GAP };
            let whole = beyond && !scattered;
            let tolerance = share * diagonal;
            for _ in 0..if junctions { 4 } else { 0 } {
                let split = split_junctions(mesh, &open, tolerance);
                if split.is_empty() {
                    break;
                }
                open = Sides::of(&mesh.triangles).open();
                report.add(Defect::TJunction, Action::Split, split.len(), &split);
            }
            // ends that move bring others within reach
            for _ in 0..3 {
                let near = join_edges(mesh, &open, tolerance, per_gap, whole);
                if near.is_empty() {
                    break;
                }
                report.add(Defect::NearBorders, Action::Merged, near.len(), &near);
                drop_duplicates(mesh, report);
                open = Sides::of(&mesh.triangles).open();
            }
        }
    }
    Ok(())
}

fn cell(p: DVec3, width: f64) -> [i64; 3] {
    (p / width).floor().to_array().map(|x| x as i64)
}

/// `open` are the open sides. Makes one of the ends of those that run against each other within the tolerance and are each other's
/// best; only `whole` contours, if that is asked for, of which no edge is left.
fn join_edges(mesh: &mut TriMesh, open: &[u32], tolerance: f64, per_gap: f64, whole: bool) -> Vec<DVec3> {
    let open: Vec<[u32; 2]> = open.iter().map(|h| directed(&mesh.triangles, *h)).collect();
    if open.len() < 2 {
        return Vec::new();
    }
    let p = |v: u32| mesh.nodes[v as usize];
    let width = CELL_PER_GAP * tolerance;
    // the last edge whose middle is in a cell, and for each edge the one before it there
    let mut grid: FxHashMap<[i64; 3], u32> = FxHashMap::default();
    grid.reserve(open.len());
    let middle = |e: [u32; 2]| 0.5 * (p(e[0]) + p(e[1]));
    let before: Vec<Option<u32>> = open.iter().zip(0..).map(|(e, i)| grid.insert(cell(middle(*e), width), i)).collect();
    // the nearest other edge, those running the opposite way first
    let best: Vec<Option<(bool, f64, u32)>> = open
        .iter()
        .enumerate()
        .map(|(i, &[a, b])| {
            let limit = tolerance.min(p(a).distance(p(b)) / per_gap);
            let mut best: Option<(bool, f64, u32)> = None;
            let mut look = |j: u32| {
                let [c, d] = open[j as usize];
                for (same_way, gap) in [
                    (false, p(a).distance(p(d)).max(p(b).distance(p(c)))),
                    (true, p(a).distance(p(c)).max(p(b).distance(p(d)))),
                ] {
                    let offer = (same_way, gap, j);
                    if gap <= limit && best.is_none_or(|b| offer < b) {
                        best = Some(offer);
                    }
                }
            };
            // middles are no farther from each other than ends
            let m = middle([a, b]);
            let (low, high) = (cell(m - DVec3::splat(tolerance), width), cell(m + DVec3::splat(tolerance), width));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let mut next = grid.get(&[x, y, z]).copied();
                        while let Some(j) = next {
                            if j as usize != i {
                                look(j);
                            }
                            next = before[j as usize];
                        }
                    }
                }
            }
            best
        })
        .collect();
    let counterpart = |i: usize| {
        let (same_way, _, j) = best[i]?;
        best[j as usize].is_some_and(|back| back.2 == i as u32).then_some((j as usize, same_way))
    };
    let mut contour = Sets::new(mesh.nodes.len());
    let mut partial = vec![false; mesh.nodes.len()];
    if whole {
        for (i, &[a, b]) in open.iter().enumerate() {
            contour.join(a, b);
            if let Some((j, _)) = counterpart(i) {
                contour.join(a, open[j][0]);
            }
        }
        let single = (0..open.len()).filter(|i| counterpart(*i).is_none());
        single.for_each(|i| partial[contour.find(open[i][0]) as usize] = true);
    }
    let mut sets = Sets::new(mesh.nodes.len());
    let mut joined = false;
    for (i, &[a, b]) in open.iter().enumerate() {
        let Some((j, same_way)) = counterpart(i).filter(|c| c.0 > i) else { continue };
        if whole && partial[contour.find(a) as usize] {
            continue;
        }
        let [c, d] = open[j];
        let (c, d) = if same_way { (c, d) } else { (d, c) };
        sets.join(a, c);
        sets.join(b, d);
        joined = true;
    }
    if !joined {
        return Vec::new();
    }
    // a set that would make a triangle vanish is dissolved
    let mut dissolved = vec![false; mesh.nodes.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| sets.find(v));
        if a == b || a == c {
            dissolved[a as usize] = true;
        }
        if b == c {
            dissolved[b as usize] = true;
        }
    }
    let mut members: Vec<(u32, u32)> = (0..mesh.nodes.len() as u32)
        .map(|v| (sets.find(v), v))
        .filter(|(root, _)| !dissolved[*root as usize])
        .collect();
    members.sort_unstable();
    let mut to: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    let mut places = Vec::new();
    for set in members.chunk_by(|a, b| a.0 == b.0).filter(|s| s.len() > 1) {
        let mean = set.iter().map(|m| mesh.nodes[m.1 as usize]).sum::<DVec3>() / set.len() as f64;
        let same = set.iter().all(|m| mesh.nodes[m.1 as usize] == mesh.nodes[set[0].1 as usize]);
        if !same {
            mesh.nodes[set[0].0 as usize] = mean;
        }
        places.push(mean);
        set.iter().for_each(|m| to[m.1 as usize] = m.0);
    }
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = to[*v as usize]);
    places
}

/// Puts border nodes into the open edges they lie on, one edge of each triangle at a time.
fn split_junctions(mesh: &mut TriMesh, open: &[u32], tolerance: f64) -> Vec<DVec3> {
    if open.is_empty() {
        return Vec::new();
    }
    let ends: Vec<[u32; 2]> = open.iter().map(|h| directed(&mesh.triangles, *h)).collect();
    let mut nodes: Vec<u32> = ends.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    // border directions at each border node
    let mut at: Vec<(u32, u32)> = ends.iter().flat_map(|[a, b]| [(*a, *b), (*b, *a)]).collect();
    at.sort_unstable();
    let p = |v: u32| mesh.nodes[v as usize];
    let bvh = Bvh::new(nodes.iter().map(|v| Aabb::around([p(*v)])).collect());
    let mut places = Vec::new();
    let mut gone = vec![false; mesh.triangles.len()];
    let mut new: Vec<([u32; 3], u32)> = Vec::new();
    for (h, &[a, b]) in open.iter().zip(&ends) {
        let t = (*h / 3) as usize;
        if gone[t] {
            continue;
        }
        let tri = mesh.triangles[t];
        let Some(&x) = tri.iter().find(|v| **v != a && **v != b) else { continue };
        let (along, length) = (p(b) - p(a), p(a).distance(p(b)));
        let limit = tolerance.min(length / LENGTH_PER_GAP);
        let mut on: Vec<(f64, u32)> = Vec::new();
        bvh.overlapping(&Aabb::around([p(a), p(b)]).grown(limit), |i| {
            let c = nodes[i as usize];
            if tri.contains(&c) {
                return;
            }
            let s = (p(c) - p(a)).dot(along) / (length * length);
            let off = p(c).distance(p(a) + s * along);
            if !(off <= limit && s > 0.0 && s < 1.0 && s * length > 2.0 * off && (1.0 - s) * length > 2.0 * off) {
                return;
            }
            let from = at.partition_point(|e| e.0 < c);
            let borders = at[from..].iter().take_while(|e| e.0 == c);
            let follows = borders.filter(|e| !tri.contains(&e.1) || e.1 == a || e.1 == b).any(|e| {
                let d = p(e.1) - p(c);
                // An edge goes on along the border of a node that is put into it.
                d.dot(along).abs() > COS_20 * d.length() * length
            });
            if follows {
                on.push((s, c));
            }
        });
        if on.is_empty() {
            continue;
        }
        on.sort_unstable_by(|l, r| l.0.total_cmp(&r.0).then(l.1.cmp(&r.1)));
        let chain: Vec<u32> = std::iter::once(a).chain(on.iter().map(|o| o.1)).chain([b]).collect();
        let n = mesh.area_vector(t);
        let fits = |w: &[u32]| {
            let m = (p(w[1]) - p(w[0])).cross(p(x) - p(w[0]));
            w[0] != w[1] && m.dot(n) > 0.0
        };
        if !chain.windows(2).all(fits) {
            continue;
        }
        places.extend(on.iter().map(|o| p(o.1)));
        gone[t] = true;
        new.extend(chain.windows(2).map(|w| ([w[0], w[1], x], mesh.labels[t])));
    }
    if places.is_empty() {
        return places;
    }
    retain(mesh, |t| !gone[t]);
    for (t, label) in new {
        mesh.triangles.push(t);
        mesh.labels.push(label);
    }
    places
}
