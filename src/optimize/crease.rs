//! Creases as edges of the mesh: finding them by the jump of the surface's normal, cutting the edges that run across
//! them, and keeping nodes on them.
//!
//! `N1` (8–11) puts nodes on creases but leaves edges that join two faces directly, so a chamfer remains. Here every edge
//! is walked by bisection: where the normal of the foot jumps, the edge runs across a crease, and a node is put there, at
//! the least-squares point of the two tangent planes, which is (9–11) applied to one point and repeated until it rests. A
//! triangle with three such edges holds a corner. Afterwards every crease is a chain of edges.

use glam::DVec3;

use super::flips::flip_for_normals;
use super::guard::{Moves, ahead, area_vector, ask_all, may_move, relocate_all};
use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::curvature::dihedral;
use crate::mesh::{EditMesh, edit::NONE, edit::next, edit::prev};
use crate::numeric::FOUND_TWICE;
use crate::numeric::svd::Qef;
use crate::run::Run;

/// Steps of bisection along an edge: what still jumps over 1/64 of an edge is a crease; a surface that curves this fast is
/// not resolved by the mesh anyway.
const BISECTIONS: usize = 6;
/// First distance of the points that look at the faces beside a crease, as a share of the reach: far enough to be on the
/// right side while the crease is not located yet, near enough to see the crease's own faces only.
pub(super) const LOOK: f64 = 0.05;
/// The same for a corner, whose first guess is the meeting point of tangent planes taken further away.
const LOOK_WIDE: f64 = 0.3;
/// The same at the end, when the crease is located to that accuracy.
const LOOK_LEAST: f64 = 1e-4;
/// Two tangent planes locate a crease when the smaller singular value exceeds this share of the larger: 3.6 degrees
/// between the normals. (10)'s own 0.1 would lose creases below 35 degrees.
const LOCATE_CUTOFF: f64 = 1e-3;
/// Rounds of locating; each squares the error, so more than five are needed only where the look-out is at fault.
const ROUNDS: usize = 8;
/// A crease is located when a round moves it by less than this share of the reach.
const LOCATED: f64 = 1e-9;
/// An edge lies along a crease when the crease passes its middle within this share of its length: the sagitta of an
/// edge that is as long as 1.2 times the crease's radius.
const CHORD: f64 = 0.15;
/// ... and when it runs within 45 degrees of it (cosine): an edge across a crease is no part of it.
const ALONG_CREASE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// How often cuts that would turn a triangle over are tried again after the others.
const CUT_ROUNDS: usize = 3;
/// A node counts as on a crease when the crease passes within this share of the reach.
const ON_CREASE: f64 = 0.05;

/// What the crease operators did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CreaseReport {
    /// Edges that were cut at a crease.
    pub cuts: usize,
    /// Corners that were put into triangles.
    pub corners: usize,
    /// Edges that were flipped because that lowers the normal deviation.
    pub flips: usize,
    /// Nodes that lay beside a crease and were put on it.
    pub snapped: usize,
    /// Places where the normal jumps but no crease was found within reach.
    pub missed: usize,
    /// Edges marked sharp in the end.
    pub sharp: usize,
}

/// The point nearest to `start` where the faces seen from it in the directions `sides` meet, and their normals there:
/// (9–11) repeated, with the dual nodes drawn in as the point settles. `None` when a side has no face within `reach`, the
/// sides show one and the same plane, or the point runs further than `reach`.
pub fn locate(
    oracle: &dyn SurfaceOracle,
    start: DVec3,
    sides: &[DVec3],
    look: f64,
    reach: f64,
) -> Option<(DVec3, usize)> {
    let mut p = start;
    let mut look = look * reach;
    let mut rank = 0;
    for round in 0..ROUNDS {
        let mut planes = Qef::new(p);
        for side in sides {
            let foot = oracle.project(p + look * *side, reach)?;
            planes.add(foot.point, foot.normal, 1.0);
        }
        let found = planes.solve(LOCATE_CUTOFF);
        if found.rank < 2 {
            return None;
        }
        rank = found.rank;
        p += found.step;
        let moved = found.step.length();
        if !p.is_finite() || p.distance(start) > reach {
            return None;
        }
        if moved <= LOCATED * reach && round > 0 {
            break;
        }
        look = look.min((2.0 * moved).max(LOOK_LEAST * reach));
    }
    Some((p, rank))
}

/// Directions from a node into the sectors between its feature edges: one per sector, in ring order.
pub(super) fn sectors(mesh: &EditMesh, v: u32) -> Vec<DVec3> {
    let p = mesh.point(v);
    let ring: Vec<u32> = mesh.outgoing(v).collect();
    let Some(first) = ring.iter().position(|&h| mesh.is_feature(h)) else { return Vec::new() };
    let mut out = Vec::new();
    for k in 0..ring.len() {
        let h = ring[(first + k) % ring.len()];
        if mesh.is_feature(h) {
            out.push(DVec3::ZERO);
        }
        // Weighted by area twice over, a sliver's direction counts for nothing.
        if let Some(sum) = out.last_mut() {
            *sum += (mesh.centroid(h / 3) - p).normalize_or_zero() * mesh.area_vector(h / 3).length();
        }
    }
    out.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// The crease point for a node near it, seen along the sectors between its sharp edges.
pub(super) fn settle(mesh: &EditMesh, oracle: &dyn SurfaceOracle, v: u32, p: DVec3, reach: f64) -> Option<DVec3> {
    locate(oracle, p, &sectors(mesh, v), LOOK, reach).map(|(q, _)| q)
}

fn angle_cosine(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

/// An end of a segment, and its foot on the surface.
#[derive(Clone, Copy)]
struct SegmentEnd {
    at: DVec3,
    foot: Foot,
}

/// Where the normal jumps between two feet on the segment, by bisection; `None` when it only bends.
fn jump(
    oracle: &dyn SurfaceOracle,
    from: SegmentEnd,
    to: SegmentEnd,
    cosine: f64,
    reach: f64,
) -> Option<(DVec3, [Foot; 2])> {
    let (SegmentEnd { at: mut a, foot: mut fa }, SegmentEnd { at: mut b, foot: mut fb }) = (from, to);
    for _ in 0..BISECTIONS {
        if fa.normal.dot(fb.normal) > cosine {
            return None;
        }
        let m = 0.5 * (a + b);
        let fm = oracle.project(m, reach)?;
        if fm.normal.dot(fa.normal) >= fm.normal.dot(fb.normal) {
            (a, fa) = (m, fm);
        } else {
            (b, fb) = (m, fm);
        }
    }
    (fa.normal.dot(fb.normal) <= cosine).then(|| (0.5 * (a + b), [fa, fb]))
}

/// The largest spread of normals seen from `v` into the triangles around it, at the given distance; with the two
/// directions that show it.
fn spread(mesh: &EditMesh, oracle: &dyn SurfaceOracle, v: u32, look: f64, reach: f64) -> Option<(f64, Vec<DVec3>)> {
    let p = mesh.point(v);
    let mut seen: Vec<(DVec3, DVec3)> = Vec::new();
    for h in mesh.outgoing(v) {
        let side = (mesh.centroid(h / 3) - p).normalize_or_zero();
        let foot = oracle.project(p + look * side, reach)?;
        seen.push((side, foot.normal));
    }
    let mut least = 1.0;
    for (i, x) in seen.iter().enumerate() {
        for y in &seen[..i] {
            least = f64::min(least, x.1.dot(y.1));
        }
    }
    // One direction per distinct normal.
    let mut sides: Vec<(DVec3, DVec3)> = Vec::new();
    for s in seen {
        if sides.iter().all(|x| x.1.dot(s.1) < 0.5 * (1.0 + least)) {
            sides.push(s);
        }
    }
    Some((least, sides.into_iter().map(|s| s.0).collect()))
}

/// Puts nodes that lie beside a crease on it, cuts every edge that runs across a crease there, puts corners into
/// triangles that hold one, then marks the sharp edges anew ([`mark_sharp`]). `angle` in degrees is the smallest jump of
/// the normal that counts; `reach` is about the local edge length.
///
/// *Guarantees*: the manifold and its Euler number stay.
/// *Does not guarantee*: that new triangles face the right way where the mesh is coarser than the distance between
/// creases; ask [`survey`](super::survey).
pub fn cut_creases(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    angle: f64,
    run: &Run,
) -> Result<CreaseReport> {
    let cosine = angle_cosine(angle);
    let mut report = CreaseReport::default();
    let feet = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if mesh.is_node(v) { oracle.project(mesh.point(v), reach) } else { None }
    })?;
    let turns = |a: u32, b: u32| match (&feet[a as usize], &feet[b as usize]) {
        (Some(x), Some(y)) => x.normal.dot(y.normal) <= cosine,
        _ => false,
    };

    // Nodes on or beside a crease.
    let has_sharp = |mesh: &EditMesh, v: u32| mesh.outgoing(v).any(|h| mesh.is_sharp(h));
    let frozen = &*mesh;
    let beside = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v) || has_sharp(frozen, v) || !frozen.neighbors(v).any(|x| turns(v, x)) {
            return None;
        }
        let (least, sides) = spread(frozen, oracle, v, ON_CREASE * reach, reach)?;
        if least > cosine {
            return None;
        }
        Some(locate(oracle, frozen.point(v), &sides, LOOK, reach).map(|x| x.0))
    })?;
    let mut on_crease: Vec<bool> = (0..mesh.node_capacity() as u32).map(|v| has_sharp(mesh, v)).collect();
    for (v, found) in beside.iter().enumerate() {
        let Some(found) = found else { continue };
        let v = v as u32;
        let away = found.map_or(f64::INFINITY, |p| p.distance(mesh.point(v)));
        if away <= LOOK_LEAST * reach {
            on_crease[v as usize] = true;
        } else if let Some(p) = found
            && away <= 4.0 * ON_CREASE * reach
            && !mesh.is_pinned(v)
            && may_move(mesh, v, *p)
        {
            mesh.set_point(v, *p);
            on_crease[v as usize] = true;
            report.snapped += 1;
        } else {
            // Its edges are cut as if it lay on the one face its foot is on; the short ones are collapsed later.
            report.missed += 1;
        }
    }

    // A triangle whose nodes lie on three faces holds a corner.
    let frozen = &*mesh;
    let corners = ask_all(oracle, run, mesh.triangle_capacity(), |t| {
        if !frozen.is_triangle(t) {
            return None;
        }
        let nodes @ [a, b, c] = frozen.corners(t);
        if !(turns(a, b) && turns(b, c) && turns(c, a))
            || nodes.iter().any(|&v| on_crease[v as usize] || frozen.is_pinned(v))
        {
            return None;
        }
        let center = frozen.centroid(t);
        let mut planes = Qef::new(center);
        for foot in nodes.iter().filter_map(|&v| feet[v as usize]) {
            planes.add(foot.point, foot.normal, 1.0);
        }
        let start = center + planes.solve(LOCATE_CUTOFF).step.clamp_length_max(reach);
        let sides = nodes.map(|v| (frozen.point(v) - start).normalize_or_zero());
        locate(oracle, start, &sides, LOOK_WIDE, reach).filter(|x| x.1 == 3).map(|x| x.0)
    })?;

    // Edges across a crease.
    let frozen = &*mesh;
    let found = ask_all(oracle, run, 3 * mesh.triangle_capacity(), |h| {
        if !frozen.is_edge(h) || frozen.is_sharp(h) || frozen.is_pinned_edge(h) {
            return None;
        }
        let (a, b) = (frozen.origin(h), frozen.target(h));
        if on_crease[a as usize] && on_crease[b as usize] {
            return None;
        }
        let (p, q) = (frozen.point(a), frozen.point(b));
        // From a node on a crease the face that the edge runs over is seen a little way along it.
        let end = |v: u32, from: DVec3, to: DVec3| {
            if on_crease[v as usize] {
                let x = from.lerp(to, 2.0 * ON_CREASE);
                oracle.project(x, reach).map(|foot| SegmentEnd { at: x, foot })
            } else {
                feet[v as usize].map(|foot| SegmentEnd { at: from, foot })
            }
        };
        let (x, y) = (end(a, p, q)?, end(b, q, p)?);
        let (at, [fa, fb]) = jump(oracle, x, y, cosine, reach)?;
        // Beside a corner an edge may pass over the third face. The corner's own edges say all that is to be said.
        let third = fa.normal.dot(x.foot.normal) <= cosine || fb.normal.dot(y.foot.normal) <= cosine;
        let has_corner = |h: u32| h != NONE && corners[(h / 3) as usize].is_some();
        if third && (has_corner(h) || has_corner(frozen.opposite(h))) {
            return None;
        }
        let along = (q - p).normalize_or_zero();
        // The planes of the two feet first: the point then lies near the crease even when the edge passes far below it.
        let mut planes = Qef::new(at);
        planes.add(fa.point, fa.normal, 1.0);
        planes.add(fb.point, fb.normal, 1.0);
        let start = at + planes.solve(LOCATE_CUTOFF).step.clamp_length_max(reach);
        let point = locate(oracle, start, &[-along, along], LOOK, reach).or_else(|| {
            // Seen along the edge both sides may lie on one face; seen along the faces' own tangents they do not.
            let t = fa.normal.cross(fb.normal).normalize_or_zero();
            let side = |m: DVec3, s: f64| {
                let d = m.cross(t).normalize_or_zero();
                if d.dot(s * along) >= 0.0 { d } else { -d }
            };
            locate(oracle, start, &[side(fa.normal, -1.0), side(fb.normal, 1.0)], LOOK, reach)
        });
        // Around a corner only all cuts together make sense.
        let triple = |h: u32| {
            let [a, b, c] = frozen.corners(h / 3);
            turns(a, b) && turns(b, c) && turns(c, a)
        };
        let free = triple(h) || (frozen.opposite(h) != NONE && triple(frozen.opposite(h)));
        Some(point.map(|(point, _)| (a, b, point, free)))
    })?;
    let mut cuts = Vec::new();
    for found in found.into_iter().flatten() {
        match found {
            Some(cut) => cuts.push(cut),
            None => report.missed += 1,
        }
    }

    report.corners = put_corners(mesh, corners, reach);
    // A cut that turns a triangle over may be right once its neighbors are cut.
    for _ in 0..CUT_ROUNDS {
        run.check()?;
        let before = cuts.len();
        let frozen = &*mesh;
        ahead(oracle, run, &cuts, 0, |&(a, b, point, free)| {
            if let Some(h) = frozen.edge_between(a, b).filter(|_| !free) {
                keeps_facing(frozen, oracle, &rim(frozen, h), point, reach);
            }
        })?;
        cuts.retain(|&(a, b, point, free)| {
            let Some(h) = mesh.edge_between(a, b) else { return false };
            if [h, mesh.opposite(h)].into_iter().any(|x| x != NONE && touches(mesh, x / 3, point, FOUND_TWICE * reach))
            {
                return false;
            }
            let fair = free || keeps_facing(mesh, oracle, &rim(mesh, h), point, reach);
            if fair {
                mesh.split_edge(h, point);
                report.cuts += 1;
            }
            !fair
        });
        if cuts.is_empty() || cuts.len() == before {
            break;
        }
    }
    report.missed += cuts.len();
    // Where an edge was left uncut beside a corner the other diagonal joins two crease nodes.
    report.flips = flip_for_normals(mesh, oracle, reach, angle, run)?;
    report.sharp = mark_sharp(mesh, oracle, reach, angle, run)?;
    let closed = close_corners(mesh, oracle, reach, angle, run)?;
    if closed > 0 {
        report.corners += closed;
        report.sharp = mark_sharp(mesh, oracle, reach, angle, run)?;
    }
    Ok(report)
}

/// Puts a corner into every triangle on whose three nodes creases end that no edge of it continues, where the faces beyond
/// its edges differ by more than `angle` degrees and meet in a point within `reach`. Returns how many.
fn close_corners(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, angle: f64, run: &Run) -> Result<usize> {
    let cosine = angle_cosine(angle);
    let frozen = &*mesh;
    let corners = ask_all(oracle, run, mesh.triangle_capacity(), |t| {
        if !frozen.is_triangle(t) || (3 * t..3 * t + 3).any(|h| frozen.is_feature(h)) {
            return None;
        }
        if !frozen.corners(t).iter().all(|&v| frozen.outgoing(v).filter(|&h| frozen.is_sharp(h)).count() == 1) {
            return None;
        }
        let center = frozen.centroid(t);
        let mut planes = Qef::new(center);
        let mut sides = [DVec3::ZERO; 3];
        let mut normals = [DVec3::ZERO; 3];
        for k in 0..3 {
            let beyond = frozen.centroid(frozen.opposite(3 * t + k as u32) / 3);
            let foot = oracle.project(beyond, reach)?;
            planes.add(foot.point, foot.normal, 1.0);
            normals[k] = foot.normal;
            sides[k] = foot.point;
        }
        if (0..3).any(|k| normals[k].dot(normals[(k + 1) % 3]) > cosine) {
            return None;
        }
        let start = center + planes.solve(LOCATE_CUTOFF).step.clamp_length_max(reach);
        let sides = sides.map(|s| (s - start).normalize_or_zero());
        locate(oracle, start, &sides, LOOK_WIDE, reach).filter(|x| x.1 == 3).map(|x| x.0)
    })?;
    Ok(put_corners(mesh, corners, reach))
}

/// Splits triangles at the corners found for them and pins the new nodes. Of several triangles that found the same corner
/// the one nearest to it gets it, and none where a pinned node is already. Returns how many corners were put.
fn put_corners(mesh: &mut EditMesh, corners: Vec<Option<DVec3>>, reach: f64) -> usize {
    let same = FOUND_TWICE * reach;
    // Pinned nodes come with distance zero and no triangle, so they win.
    let pinned = mesh.nodes().filter(|&v| mesh.is_pinned(v)).map(|v| (mesh.point(v), 0.0, NONE));
    let found = corners.into_iter().enumerate();
    let found = found.filter_map(|(t, p)| p.map(|p| (p, p.distance(mesh.centroid(t as u32)), t as u32)));
    let mut all: Vec<(DVec3, f64, u32)> = pinned.chain(found).collect();
    all.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.2.cmp(&b.2)));
    let wins = |i: usize| {
        let (p, d, t) = all[i];
        let rival = |&&(q, e, u): &&(DVec3, f64, u32)| {
            q.distance(p) <= same && (e < d || (e == d && u != t && (u == NONE || u < t)))
        };
        let below = all[..i].iter().rev().take_while(|x| p.x - x.0.x <= same);
        let above = all[i + 1..].iter().take_while(|x| x.0.x - p.x <= same);
        below.chain(above).find(rival).is_none()
    };
    let mut chosen: Vec<(u32, DVec3)> =
        (0..all.len()).filter(|&i| all[i].2 != NONE && wins(i)).map(|i| (all[i].2, all[i].0)).collect();
    chosen.sort_by_key(|x| x.0);
    for &(t, point) in &chosen {
        // Projection puts a node exactly on a corner when it comes from the corner's outer side.
        let near = |v: u32| mesh.point(v).distance(point) <= same;
        let there = mesh
            .corners(t)
            .into_iter()
            .find_map(|v| if near(v) { Some(v) } else { mesh.neighbors(v).find(|&x| near(x)) });
        let v = match there {
            Some(v) => v,
            None => mesh.split_triangle(t, point),
        };
        mesh.set_pinned(v, true);
    }
    chosen.len()
}

/// The half-edges around the triangles beside one.
fn rim(mesh: &EditMesh, h: u32) -> Vec<u32> {
    [h, mesh.opposite(h)].into_iter().filter(|&x| x != NONE).flat_map(|x| [next(x), prev(x)]).collect()
}

/// Whether a node of the triangle is at the point already.
fn touches(mesh: &EditMesh, t: u32, point: DVec3, same: f64) -> bool {
    mesh.corner_points(t).iter().any(|p| p.distance(point) <= same)
}

/// Whether the triangles between `point` and the half-edges `rim` have no more inverted ones among them than the
/// triangles the half-edges belong to.
fn keeps_facing(mesh: &EditMesh, oracle: &dyn SurfaceOracle, rim: &[u32], point: DVec3, reach: f64) -> bool {
    let inverted = |t: [DVec3; 3]| {
        let foot = oracle.project((t[0] + t[1] + t[2]) / 3.0, reach);
        foot.is_none_or(|f| area_vector(t).dot(f.normal) <= 0.0)
    };
    let new =
        rim.iter().filter(|&&h| inverted([mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)), point])).count();
    if new == 0 {
        return true;
    }
    let mut old: Vec<u32> = rim.iter().map(|&h| h / 3).collect();
    old.dedup();
    new <= old.into_iter().filter(|&t| inverted(mesh.corner_points(t))).count()
}

/// Marks the edges at whose middle the surface's normal jumps by more than `angle` degrees from one triangle's side to the
/// other's, unmarks all others; returns how many are sharp. Nodes keep their places.
pub fn mark_sharp(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, angle: f64, run: &Run) -> Result<usize> {
    let cosine = angle_cosine(angle);
    let hint = 0.5 * angle.to_radians();
    let frozen = &*mesh;
    let marks = ask_all(oracle, run, 3 * mesh.triangle_capacity(), |h| {
        if !frozen.is_edge(h) || frozen.opposite(h) == NONE || dihedral(frozen, h) < hint {
            return None;
        }
        // A jump shows under the triangles first; only then are the edge's own surroundings looked at.
        let sides = [h / 3, frozen.opposite(h) / 3];
        let [x, y] = sides.map(|t| oracle.project(frozen.centroid(t), reach));
        if x?.normal.dot(y?.normal) > cosine {
            return None;
        }
        let (p, q) = (frozen.point(frozen.origin(h)), frozen.point(frozen.target(h)));
        let middle = 0.5 * (p + q);
        let [x, y] = sides.map(|t| {
            let inward = (frozen.centroid(t) - middle).normalize_or_zero();
            oracle.project(middle + 2.0 * LOOK * reach.min(p.distance(q)) * inward, reach)
        });
        let (x, y) = (x?, y?);
        if x.normal.dot(y.normal) > cosine {
            return None;
        }
        let mut planes = Qef::new(middle);
        planes.add(x.point, x.normal, 1.0);
        planes.add(y.point, y.normal, 1.0);
        let near = planes.solve(LOCATE_CUTOFF).step.length() <= CHORD * p.distance(q);
        let along = x.normal.cross(y.normal).normalize_or_zero().dot((q - p).normalize_or_zero()).abs() >= ALONG_CREASE;
        (near && along).then_some(())
    })?;
    let mut count = 0;
    for (h, mark) in marks.into_iter().enumerate() {
        if mesh.is_edge(h as u32) {
            mesh.set_sharp(h as u32, mark.is_some());
            count += usize::from(mark.is_some());
        }
    }
    Ok(count)
}

/// Puts every node with exactly two sharp edges, and every corner, exactly on its crease or corner, guarded. Pinned and
/// boundary nodes stay.
pub fn settle_creases(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<Moves> {
    let frozen = &*mesh;
    let targets = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v) || frozen.is_pinned(v) || frozen.is_boundary(v) {
            return None;
        }
        let sharp = frozen.outgoing(v).filter(|&h| frozen.is_sharp(h)).count();
        let p = frozen.point(v);
        if sharp < 2 { None } else { Some(settle(frozen, oracle, v, p, reach)).filter(|q| *q != Some(p)) }
    })?;
    relocate_all(mesh, oracle, run, targets, |m, v, p| settle(m, oracle, v, p, reach))
}

/// The neighbors of a node along its feature edges.
pub(super) fn feature_neighbors(mesh: &EditMesh, v: u32) -> Vec<u32> {
    let mut out = Vec::new();
    for h in mesh.outgoing(v) {
        if mesh.is_feature(h) {
            out.push(mesh.target(h));
        }
        if mesh.opposite(prev(h)) == NONE {
            out.push(mesh.apex(h));
        }
    }
    out
}
