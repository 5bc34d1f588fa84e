//! Self-intersections, by exact predicates.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::trimesh::TriMesh;
use crate::error::Result;
use crate::numeric::ROUNDING;
use crate::numeric::predicates::{orient2d, orient3d};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Triangles that [intersect](self_intersections) others, ascending.
pub fn intersecting_triangles(mesh: &TriMesh, run: &Run) -> Result<Vec<u32>> {
    let mut bad: Vec<u32> = self_intersections(mesh, run)?.into_iter().flatten().collect();
    bad.sort_unstable();
    bad.dedup();
    Ok(bad)
}

/// Pairs of triangles that meet anywhere but in the nodes and edges they share, ascending.
///
/// Triangles that share an edge intersect if they lie in one plane, folded onto each other; triangles that share a node
/// if the edge opposite to it meets the other triangle; others if they have any point in common. Two nodes at exactly one
/// place, where a surface touches itself in a point, count as a shared one. Triangles without area are passed over. Exact: no
/// tolerance is involved. The mesh must be [valid](TriMesh::validate).
pub fn self_intersections(mesh: &TriMesh, run: &Run) -> Result<Vec<[u32; 2]>> {
    let (boxes, flat) = boxes_and_flat(mesh, 0);
    run.check()?;
    let bvh = run.install(|| Bvh::new(boxes));
    let apart = spread_fans(mesh);
    let meet = |t: u32, u: u32| {
        !share(mesh, t as usize, u as usize, &apart)
            && !flat[t as usize]
            && !flat[u as usize]
            && !run.is_cancelled()
            && intersect(mesh, t as usize, u as usize)
    };
    let found = run.install(|| bvh.pairs(&meet));
    run.check()?;
    Ok(found)
}

/// Boxes of triangles from some number on, and which have no area.
fn boxes_and_flat(mesh: &TriMesh, first: usize) -> (Vec<Aabb>, Vec<bool>) {
    (first..mesh.triangles.len()).map(|t| (Aabb::around(mesh.corners(t)), is_flat(mesh.corners(t)))).unzip()
}

/// Those [self-intersections](self_intersections) that concern at least one of the given triangles, which ascend.
pub fn intersections_among(mesh: &TriMesh, some: &[u32], run: &Run) -> Result<Vec<[u32; 2]>> {
    if some.is_empty() {
        return Ok(Vec::new());
    }
    let boxes: Vec<Aabb> = some.iter().map(|t| Aabb::around(mesh.corners(*t as usize))).collect();
    let mut asked = vec![false; mesh.triangles.len()];
    some.iter().for_each(|t| asked[*t as usize] = true);
    run.check()?;
    // only those asked for stand in the tree: they are few as a rule
    let bvh = Bvh::new(boxes);
    let mut pairs: Vec<[u32; 2]> = run.install(|| {
        let of = |u: u32| {
            let mut out = Vec::new();
            if run.is_cancelled() {
                return out;
            }
            let corners = mesh.corners(u as usize);
            let mut flat = None;
            bvh.overlapping(&Aabb::around(corners), |k| {
                let t = some[k as usize];
                // a pair of two asked triangles is found from the larger one
                let mine = t != u && (t < u || !asked[u as usize]);
                if mine
                    && !*flat.get_or_insert_with(|| is_flat(corners))
                    && !is_flat(mesh.corners(t as usize))
                    && intersect(mesh, t as usize, u as usize)
                {
                    out.push([t.min(u), t.max(u)]);
                }
            });
            out
        };
        (0..mesh.triangles.len() as u32).into_par_iter().flat_map_iter(of).collect()
    });
    run.check()?;
    pairs.sort_unstable();
    Ok(pairs)
}

/// Which groups of triangles intersect something: the numbers of groups are those of the mesh's last triangles. A group that meets
/// itself or a triangle without a group is told as such, without a look at more of its triangles; of the others all pairs that
/// meet are told.
pub fn intersecting_groups(mesh: &TriMesh, groups: &[u32], run: &Run) -> Result<(Vec<bool>, Vec<[u32; 2]>)> {
    let first = mesh.triangles.len() - groups.len();
    let count = groups.iter().max().map_or(0, |g| *g as usize + 1);
    let (boxes, flat) = boxes_and_flat(mesh, first);
    run.check()?;
    let bvh = run.install(|| Bvh::new(boxes));
    // Whether a flag is raised does not depend on which pair raises it.
    let bad: Vec<AtomicBool> = (0..count).map(|_| AtomicBool::new(false)).collect();
    let is_bad = |g: u32| bad[g as usize].load(Ordering::Relaxed);
    let alone = |u: u32| {
        if run.is_cancelled() {
            return;
        }
        let corners = mesh.corners(u as usize);
        let own = groups.get((u as usize).wrapping_sub(first)).copied();
        if own.is_some_and(is_bad) {
            return;
        }
        let mut degenerate = None;
        bvh.overlapping(&Aabb::around(corners), |k| {
            let (t, g) = (first + k as usize, groups[k as usize]);
            let asked = own.is_none_or(|o| o == g && t < u as usize) && !is_bad(g) && !flat[k as usize];
            if asked && !*degenerate.get_or_insert_with(|| is_flat(corners)) && intersect(mesh, t, u as usize) {
                bad[g as usize].store(true, Ordering::Relaxed);
            }
        });
    };
    run.install(|| (0..mesh.triangles.len() as u32).into_par_iter().for_each(alone));
    run.check()?;
    let apart = |i: u32, j: u32| {
        let (g, h) = (groups[i as usize], groups[j as usize]);
        let fine = |k: u32| !is_bad(groups[k as usize]) && !flat[k as usize];
        g != h && fine(i) && fine(j) && !run.is_cancelled() && intersect(mesh, first + i as usize, first + j as usize)
    };
    let mut between: Vec<[u32; 2]> =
        run.install(|| bvh.pairs(&apart)).into_iter().map(|p| p.map(|k| groups[k as usize])).collect();
    run.check()?;
    between.iter_mut().for_each(|p| p.sort_unstable());
    between.sort_unstable();
    between.dedup();
    Ok((bad.into_iter().map(AtomicBool::into_inner).collect(), between))
}

/// Whether two triangles share a node of which it is known that its triangles meet only in what they share.
fn share(mesh: &TriMesh, t: usize, u: usize, known: &[bool]) -> bool {
    let other = mesh.triangles[u];
    mesh.triangles[t].into_iter().any(|v| known[v as usize] && other.contains(&v))
}

/// The nodes around which the triangles surely meet only in what they share: seen along some direction all face the same
/// way, and they go round once. Rounding cannot make that come true.
fn spread_fans(mesh: &TriMesh) -> Vec<bool> {
    /// Triangles are this far from upright, as a cosine, and from having no area, as a sine: far above rounding.
    const MARGIN: f64 = 1e-3;
    /// Nodes of more triangles than this are left to the pairs.
    const MOST: usize = 24;
    let mut fill = vec![0u32; mesh.nodes.len() + 2];
    mesh.triangles.iter().flatten().for_each(|&v| fill[v as usize + 2] += 1);
    for v in 0..mesh.nodes.len() {
        fill[v + 2] += fill[v + 1];
    }
    let mut links = vec![[0u32; 2]; 3 * mesh.triangles.len()];
    for &[a, b, c] in &mesh.triangles {
        for (v, link) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            let at = &mut fill[v as usize + 1];
            links[*at as usize] = link;
            *at += 1;
        }
    }
    let spread = |v: usize| {
        let link = &links[fill[v] as usize..fill[v + 1] as usize];
        if !(3..=MOST).contains(&link.len()) {
            return false;
        }
        // Every edge from the node is the first of one triangle and the second of another.
        let once = |x: u32| link.iter().filter(|l| l[0] == x).count() == 1;
        if !link.iter().all(|l| once(l[1])) {
            return false;
        }
        let o = mesh.nodes[v];
        let sides = |l: &[u32; 2]| l.map(|x| mesh.nodes[x as usize] - o);
        let up: DVec3 = link.iter().map(sides).map(|[a, b]| a.cross(b)).sum();
        let across = up.any_orthogonal_vector();
        let mut rounds = 0;
        for [a, b] in link.iter().map(sides) {
            let n = a.cross(b);
            let least = MARGIN * MARGIN * n.length_squared() * up.length_squared();
            let fat = n.length_squared() > MARGIN * MARGIN * a.length_squared() * b.length_squared();
            let facing = n.dot(up);
            if !(fat && facing > 0.0 && facing * facing > least) {
                return false;
            }
            // The triangles with the direction across `across` between their sides: one for each time round. Neighbors
            // see the sign of their common side alike.
            rounds += usize::from(a.dot(across) <= 0.0 && b.dot(across) > 0.0);
        }
        rounds == 1
    };
    (0..mesh.nodes.len()).map(spread).collect()
}

/// Exactly without area: the three points lie on a line in all three projections.
pub(crate) fn is_flat(p: [DVec3; 3]) -> bool {
    (0..3).all(|axis| {
        let [a, b, c] = p.map(|v| drop_axis(v, axis));
        orient2d(a, b, c) == 0.0
    })
}

fn drop_axis(v: DVec3, axis: usize) -> DVec2 {
    match axis {
        0 => DVec2::new(v.y, v.z),
        1 => DVec2::new(v.z, v.x),
        _ => DVec2::new(v.x, v.y),
    }
}

fn intersect(mesh: &TriMesh, t: usize, u: usize) -> bool {
    triangles_cross([mesh.triangles[t], mesh.triangles[u]], [mesh.corners(t), mesh.corners(u)])
}

/// Whether two triangles with area meet anywhere but in what they share: see [`self_intersections`].
pub(crate) fn triangles_cross([a, b]: [[u32; 3]; 2], [p, q]: [[DVec3; 3]; 2]) -> bool {
    let mut pairs = [(0, 0); 3];
    let mut count = 0;
    for i in 0..3 {
        for j in 0..3 {
            if a[i] == b[j] && count < 3 {
                pairs[count] = (i, j);
                count += 1;
            }
        }
    }
    if count == 0 {
        // Sheets that touch in one point have a node there each.
        let same = || (0..9).map(|k| (k / 3, k % 3)).filter(|&(i, j)| p[i] == q[j]);
        if let Some(touch) = same().next().filter(|_| same().count() == 1) {
            (pairs[0], count) = (touch, 1);
        }
    }
    let shared = &pairs[..count];
    if surely_apart(p, q, shared) {
        return false;
    }
    match *shared {
        [] => triangles_meet(p, q),
        [(i, j)] => {
            segment_meets(p[(i + 1) % 3], p[(i + 2) % 3], q) || segment_meets(q[(j + 1) % 3], q[(j + 2) % 3], p)
        }
        [(i, j), (k, l)] => {
            let (apex, other) = (p[3 - i - k], q[3 - j - l]);
            let (v, w) = (p[i], p[k]);
            if orient3d(v, w, apex, other) != 0.0 {
                return false;
            }
            let axis =
                (0..3).find(|x| orient2d(drop_axis(v, *x), drop_axis(w, *x), drop_axis(apex, *x)) != 0.0).unwrap_or(0);
            let [v, w, apex, other] = [v, w, apex, other].map(|p| drop_axis(p, axis));
            (orient2d(v, w, apex) > 0.0) == (orient2d(v, w, other) > 0.0)
        }
        _ => true,
    }
}

/// A quick look that says yes only where rounding cannot matter, so that the exact predicates, at their slowest for
/// triangles in one plane, are left with the rest: is there a plane that parts the triangles but for what they share?
fn surely_apart(p: [DVec3; 3], q: [DVec3; 3], shared: &[(usize, usize)]) -> bool {
    // The share of the terms is far above the rounding of the differences, products and sums below.
    let same = |a: f64, b: f64| (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0);
    match *shared {
        [] => {
            let beside = |t: [DVec3; 3], u: [DVec3; 3]| {
                let (a, b) = (t[1] - t[0], t[2] - t[0]);
                let [x, y, z] = u.map(|v| sure_sign(a, b, v - t[0]));
                same(x, y) && same(y, z)
            };
            if beside(p, q) || beside(q, p) {
                return true;
            }
            let o = p[0];
            let (p, q) = (p.map(|v| v - o), q.map(|v| v - o));
            // Differences carry the rounding of the coordinates themselves.
            let size = p.iter().chain(&q).map(|v| v.abs().max_element()).fold(0.0, f64::max);
            let slack = ROUNDING * size + 1e-15 * o.abs().max_element();
            let parts = |d: DVec3| {
                let (lo, hi) = (p.map(|v| v.dot(d)), q.map(|v| v.dot(d)));
                let gap =
                    lo.into_iter().fold(f64::INFINITY, f64::min) - hi.into_iter().fold(f64::NEG_INFINITY, f64::max);
                gap > 4.0 * slack * d.abs().max_element()
            };
            let d = p[0] + p[1] + p[2] - q[0] - q[1] - q[2];
            if parts(d) {
                return true;
            }
            let away = |t: [DVec3; 3], sign: f64| {
                let n = (t[1] - t[0]).cross(t[2] - t[0]);
                (0..3).any(|k| parts(sign * n.cross(t[(k + 1) % 3] - t[k])))
            };
            away(p, 1.0) || away(q, -1.0)
        }
        [(i, j)] => {
            let o = p[i];
            let (a, b) = (p[(i + 1) % 3] - o, p[(i + 2) % 3] - o);
            let (c, d) = (q[(j + 1) % 3] - o, q[(j + 2) % 3] - o);
            // both others on one side of a triangle: the planes meet in a line that passes it in the node
            if same(sure_sign(a, b, c), sure_sign(a, b, d)) || same(sure_sign(c, d, a), sure_sign(c, d, b)) {
                return true;
            }
            let s = a.normalize_or_zero() + b.normalize_or_zero() - c.normalize_or_zero() - d.normalize_or_zero();
            let least = |v: DVec3| ROUNDING * v.length() * s.length();
            a.dot(s) > least(a) && b.dot(s) > least(b) && -c.dot(s) > least(c) && -d.dot(s) > least(d)
        }
        [(i, j), (k, l)] => {
            let (e, a, b) = (p[k] - p[i], p[3 - i - k] - p[i], q[3 - j - l] - p[i]);
            if sure_sign(e, a, b) != 0.0 {
                return true;
            }
            let (m, n) = (e.cross(a), e.cross(b));
            let fat = |m: DVec3, a: DVec3| m.length() > 1e-6 * e.length() * a.length();
            fat(m, a) && fat(n, b) && m.dot(n) < 0.99 * m.length() * n.length()
        }
        _ => false,
    }
}

/// A number with the sign of `(a × b) · c`, where `a`, `b`, `c` are rounded differences of coordinates; 0 where rounding
/// could change it. The bound is that of J. R. Shewchuk (1997) for `orient3d`, (7 + 56 ε) ε.
fn sure_sign(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    /// The bound for `orient3d`, 7.77e-16, rounded up: it is a share of the sum of the terms' sizes.
    const BOUND: f64 = 8e-16;
    /// Below this products lose digits.
    const LEAST: f64 = 1e-280;
    let (x, y, z) = (a.abs(), b.abs(), c.abs());
    let most = (x.y * y.z + x.z * y.y) * z.x + (x.z * y.x + x.x * y.z) * z.y + (x.x * y.y + x.y * y.x) * z.z;
    let sign = a.cross(b).dot(c);
    if most > LEAST && sign.abs() > BOUND * most { sign } else { 0.0 }
}

/// Whether two triangles without a common node have a point in common.
fn triangles_meet(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let one_sided = |s: [f64; 3]| s.iter().all(|v| *v > 0.0) || s.iter().all(|v| *v < 0.0);
    if one_sided(q.map(|v| orient3d(p[0], p[1], p[2], v))) || one_sided(p.map(|v| orient3d(q[0], q[1], q[2], v))) {
        return false;
    }
    (0..3).any(|i| segment_meets(p[i], p[(i + 1) % 3], q)) || (0..3).any(|i| segment_meets(q[i], q[(i + 1) % 3], p))
}

/// Whether a closed segment and a closed triangle have a point in common.
fn segment_meets(a: DVec3, b: DVec3, t: [DVec3; 3]) -> bool {
    let (sa, sb) = (orient3d(t[0], t[1], t[2], a), orient3d(t[0], t[1], t[2], b));
    if (sa > 0.0 && sb > 0.0) || (sa < 0.0 && sb < 0.0) {
        return false;
    }
    if sa == 0.0 && sb == 0.0 {
        return coplanar_segment_meets(a, b, t);
    }
    let s: [f64; 3] = std::array::from_fn(|i| orient3d(a, b, t[i], t[(i + 1) % 3]));
    s.iter().all(|v| *v >= 0.0) || s.iter().all(|v| *v <= 0.0)
}

fn coplanar_segment_meets(a: DVec3, b: DVec3, t: [DVec3; 3]) -> bool {
    // any projection in which the triangle keeps its area keeps the picture
    let flat = |axis: &usize| {
        let [p, q, r] = t.map(|v| drop_axis(v, *axis));
        orient2d(p, q, r) != 0.0
    };
    let Some(axis) = (0..3).find(flat) else { return false };
    let t = t.map(|v| drop_axis(v, axis));
    let (a, b) = (drop_axis(a, axis), drop_axis(b, axis));
    let side = orient2d(t[0], t[1], t[2]) > 0.0;
    let holds = |p: DVec2| {
        (0..3).all(|i| {
            let s = orient2d(t[i], t[(i + 1) % 3], p);
            s == 0.0 || (s > 0.0) == side
        })
    };
    holds(a) || holds(b) || (0..3).any(|i| segments_meet(a, b, t[i], t[(i + 1) % 3]))
}

fn segments_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let within = |a: DVec2, b: DVec2, p: DVec2| a.min(b).cmple(p).all() && p.cmple(a.max(b)).all();
    let (s1, s2) = (orient2d(a, b, c), orient2d(a, b, d));
    let (s3, s4) = (orient2d(c, d, a), orient2d(c, d, b));
    let apart = |s: f64, t: f64| (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0);
    (apart(s1, s2) && apart(s3, s4))
        || (s1 == 0.0 && within(a, b, c))
        || (s2 == 0.0 && within(a, b, d))
        || (s3 == 0.0 && within(c, d, a))
        || (s4 == 0.0 && within(c, d, b))
}
