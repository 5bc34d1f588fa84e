//! Adding and removing nodes: densification, removal of short edges and of degenerate triangles.

use glam::DVec3;

use super::classify::{Kind, kind_by_edges};
use super::crease::{LOOK, locate, settle};
use super::guard::{FACING, ahead, area_vector, may_move, sharpest_cosine};
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::{EditMesh, edit::NONE};
use crate::run::Run;
use crate::sizing::LONG;

/// Rounds of splitting: each halves the longest edges, so this allows for a factor 1000.
const ROUNDS: usize = 10;
/// A collapse that serves the size alone may not leave an angle below this (degrees) unless it was there before.
const COLLAPSE_ANGLE: f64 = 18.0;
/// A triangle is degenerate when its smallest angle is below this (degrees).
pub const DEGENERATE_ANGLE: f64 = 10.0;

/// What an operator that adds or removes nodes did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Edits {
    /// Nodes added.
    pub splits: usize,
    /// Nodes removed.
    pub collapses: usize,
    /// Edges flipped.
    pub flips: usize,
    /// Wanted edits that the link condition or the guard refused.
    pub refused: usize,
}

impl Edits {
    /// Adds another pass.
    pub fn add(&mut self, other: Edits) {
        self.splits += other.splits;
        self.collapses += other.collapses;
        self.flips += other.flips;
        self.refused += other.refused;
    }
}

/// Where a new node on the edge goes: on the crease if the edge is sharp, else on the surface below its middle.
fn midpoint(mesh: &EditMesh, oracle: &dyn SurfaceOracle, h: u32, reach: f64) -> Option<DVec3> {
    let (p, q) = (mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
    let middle = 0.5 * (p + q);
    let o = mesh.opposite(h);
    if o == NONE {
        return Some(middle);
    }
    if mesh.is_sharp(h) {
        let side = |t: u32| (mesh.centroid(t) - middle).normalize_or_zero();
        return locate(oracle, middle, &[side(h / 3), side(o / 3)], LOOK, reach).map(|x| x.0);
    }
    oracle.project(middle, reach).map(|f| f.point)
}

/// Densification of \[LIS14\]: splits edges longer than [`LONG`] times the wanted size (see [`Sizing`](crate::sizing::Sizing)),
/// longest of each triangle first, until none is left. `field` holds the size wanted at each node and grows with the mesh.
/// New nodes lie on the surface, on the crease where the edge is sharp.
///
/// *Guarantees*: no new triangle faces away from the recorded normals unless its parent did.
pub fn densify(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    field: &mut Vec<f64>,
    reach: f64,
    run: &Run,
) -> Result<Edits> {
    let mut edits = Edits::default();
    for _ in 0..ROUNDS {
        run.check()?;
        let mut list: Vec<(f64, u32)> = Vec::new();
        for h in mesh.edges().filter(|&h| !mesh.is_pinned_edge(h)) {
            let wanted = field[mesh.origin(h) as usize].min(field[mesh.target(h) as usize]);
            let excess = mesh.edge_length(h) / (LONG * wanted);
            if excess > 1.0 {
                list.push((excess, h));
            }
        }
        list.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let before = edits.splits;
        for k in 0..list.len() {
            if k % 256 == 0 {
                run.check()?;
            }
            let frozen = &*mesh;
            let is_long = |h: u32| {
                let wanted = field[frozen.origin(h) as usize].min(field[frozen.target(h) as usize]);
                frozen.edge_length(h) > LONG * wanted
            };
            ahead(oracle, run, &list, k, |x| {
                if is_long(x.1) {
                    midpoint(frozen, oracle, x.1, reach);
                }
            })?;
            let h = list[k].1;
            // An earlier split may have shortened this half-edge or turned it into another.
            let (a, b) = (mesh.origin(h), mesh.target(h));
            let wanted = field[a as usize].min(field[b as usize]);
            if mesh.edge_length(h) <= LONG * wanted {
                continue;
            }
            let Some(p) = midpoint(mesh, oracle, h, reach) else {
                edits.refused += 1;
                continue;
            };
            if !split_is_fair(mesh, h, p) {
                edits.refused += 1;
                continue;
            }
            let v = mesh.split_edge(h, p);
            let size = 0.5 * (field[a as usize] + field[b as usize]);
            field.resize(v as usize + 1, size);
            edits.splits += 1;
        }
        if edits.splits == before {
            break;
        }
    }
    Ok(edits)
}

/// Whether the four triangles of a split face as their parents did.
fn split_is_fair(mesh: &EditMesh, h: u32, p: DVec3) -> bool {
    [h, mesh.opposite(h)].into_iter().filter(|&x| x != NONE).all(|x| {
        let [a, b, c] = [mesh.origin(x), mesh.target(x), mesh.apex(x)].map(|v| mesh.point(v));
        let m = mesh.normal(x / 3);
        let parent = area_vector([a, b, c]).normalize_or_zero();
        let reference = if m == DVec3::ZERO { parent } else { m };
        let floor = FACING.min(parent.dot(reference));
        [[a, p, c], [p, b, c]].iter().all(|t| area_vector(*t).normalize_or_zero().dot(reference) >= floor)
    })
}

/// What a collapse must respect.
#[derive(Debug, Clone, Copy)]
struct CollapseLimits {
    /// No edge at the merged node longer than this.
    longest: f64,
    /// Cosine of the smallest angle that may be left, unless it was worse before.
    angle: f64,
}

/// Where the ends of `h` meet halfway, if they are of one class.
fn middle_if_merged(mesh: &EditMesh, oracle: &dyn SurfaceOracle, h: u32, reach: f64) -> Option<DVec3> {
    let [x, y] = [mesh.origin(h), mesh.target(h)].map(|v| kind_by_edges(mesh, v));
    let regular = x == Kind::Regular;
    let meets = x == y && x != Kind::Corner && (regular || mesh.is_feature(h) && mesh.opposite(h) != NONE);
    if meets { midpoint(mesh, oracle, h, reach) } else { None }
}

/// Tries to merge the ends of `h` in the way their classes allow; the new node lies on the surface or crease.
fn merge(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, h: u32, reach: f64, limits: CollapseLimits) -> bool {
    let o = mesh.opposite(h);
    let (a, b) = (mesh.origin(h), mesh.target(h));
    let kinds = [kind_by_edges(mesh, a), kind_by_edges(mesh, b)];
    // Half-edge to collapse (its origin goes) and where its target ends up.
    let mut tries: Vec<(u32, DVec3)> = Vec::with_capacity(3);
    let (pa, pb) = (mesh.point(a), mesh.point(b));
    match kinds {
        [Kind::Corner, Kind::Corner] => {}
        [x, y] if x == y && (x == Kind::Regular || mesh.is_feature(h)) => {
            tries.extend(middle_if_merged(mesh, oracle, h, reach).map(|p| (h, p)));
            tries.extend([(h, pb), (h, pa)]);
        }
        [Kind::Regular, _] => tries.push((h, pb)),
        [_, Kind::Regular] if o != NONE => tries.push((o, pa)),
        [Kind::Crease, Kind::Corner] if mesh.is_feature(h) => tries.push((h, pb)),
        [Kind::Corner, Kind::Crease] if mesh.is_feature(h) && o != NONE => tries.push((o, pa)),
        _ => {}
    }
    if tries.is_empty() {
        return false;
    }
    let dying = [h / 3, if o == NONE { NONE } else { o / 3 }];
    let mut worst = -1.0f64;
    let mut ring: Vec<(u32, [DVec3; 3], u32)> = Vec::with_capacity(16);
    for (v, other) in [(a, b), (b, a)] {
        for x in mesh.outgoing(v) {
            worst = worst.max(sharpest_cosine(mesh.corner_points(x / 3)));
            if !dying.contains(&(x / 3)) {
                let points = [mesh.point(v), mesh.point(mesh.target(x)), mesh.point(mesh.apex(x))];
                ring.push((x / 3, points, other));
            }
        }
    }
    let limit = worst.max(limits.angle);
    tries.into_iter().any(|(half, p)| {
        let fair = ring.iter().all(|&(t, [v, x, y], _)| {
            let new = [p, x, y];
            let (n, old) = (area_vector(new).normalize_or_zero(), area_vector([v, x, y]).normalize_or_zero());
            let m = mesh.normal(t);
            let faces = if m == DVec3::ZERO {
                n.dot(old) > FACING
            } else {
                n.dot(m) >= FACING.max(0.9 * old.dot(m)).min(0.999) || (old.dot(m) < FACING && n.dot(m) > old.dot(m))
            };
            let long = p.distance(x).max(p.distance(y));
            faces
                && sharpest_cosine(new) <= limit
                && (long <= limits.longest || long <= v.distance(x).max(v.distance(y)))
        });
        fair && mesh.collapse(half, p)
    })
}

/// Which edges are too short: those below a share of the size wanted at their ends.
#[derive(Debug, Clone, Copy)]
pub struct ShortEdges<'a> {
    /// The size wanted at each node.
    pub field: &'a [f64],
    /// The share of it, as [`SHORT`](crate::sizing::SHORT).
    pub share: f64,
}

impl ShortEdges<'_> {
    fn wanted(&self, mesh: &EditMesh, h: u32) -> f64 {
        self.field[mesh.origin(h) as usize].min(self.field[mesh.target(h) as usize])
    }

    fn holds(&self, mesh: &EditMesh, h: u32) -> bool {
        mesh.edge_length(h) < self.share * self.wanted(mesh, h)
    }
}

/// Removes edges that are too `short`, the shortest first, by merging their ends: regular nodes
/// go into crease nodes and corners, never the other way; crease nodes merge along their crease only. Link condition and guard hold: no
/// triangle turns away from the recorded normals, no edge becomes longer than [`LONG`] times the size.
pub fn collapse_short(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    short: ShortEdges<'_>,
    reach: f64,
    run: &Run,
) -> Result<Edits> {
    let mut edits = Edits::default();
    let mut list: Vec<(f64, u32)> = Vec::new();
    for h in mesh.edges() {
        let share = mesh.edge_length(h) / short.wanted(mesh, h);
        if share < short.share {
            list.push((share, h));
        }
    }
    list.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let angle = COLLAPSE_ANGLE.to_radians().cos();
    for k in 0..list.len() {
        if k % 256 == 0 {
            run.check()?;
        }
        let frozen = &*mesh;
        ahead(oracle, run, &list, k, |x| {
            if frozen.is_edge(x.1) && short.holds(frozen, x.1) {
                middle_if_merged(frozen, oracle, x.1, reach);
            }
        })?;
        let h = list[k].1;
        if !mesh.is_edge(h) || !short.holds(mesh, h) {
            continue;
        }
        let limits = CollapseLimits { longest: LONG * short.wanted(mesh, h), angle };
        if merge(mesh, oracle, h, reach, limits) {
            edits.collapses += 1;
        } else {
            edits.refused += 1;
        }
    }
    Ok(edits)
}

/// Removes triangles whose smallest angle is below `angle` degrees: the shortest edge of a needle is collapsed; the
/// longest edge of a cap is flipped, or its apex collapsed into one of the other nodes. Returns what was done; `refused` counts triangles that stayed.
///
/// *Guarantees*: link condition; no triangle turned over; no angle made smaller than the smallest of its surroundings.
/// *Does not guarantee*: that none is left.
pub fn remove_degenerate(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    angle: f64,
    reach: f64,
    run: &Run,
) -> Result<Edits> {
    let mut edits = Edits::default();
    let bad = angle.to_radians().cos();
    let mut list: Vec<(f64, u32)> =
        mesh.triangles().map(|t| (sharpest_cosine(mesh.corner_points(t)), t)).filter(|x| x.0 > bad).collect();
    list.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    for k in 0..list.len() {
        if k % 256 == 0 {
            run.check()?;
        }
        let frozen = &*mesh;
        ahead(oracle, run, &list, k, |x| {
            if frozen.is_triangle(x.1) {
                let length = |h: &u32| frozen.edge_length(*h);
                let shortest = (3 * x.1..3 * x.1 + 3).min_by(|x, y| length(x).total_cmp(&length(y)).then(x.cmp(y)));
                shortest.and_then(|h| middle_if_merged(frozen, oracle, h, reach));
            }
        })?;
        let t = list[k].1;
        if !mesh.is_triangle(t) || sharpest_cosine(mesh.corner_points(t)) <= bad {
            continue;
        }
        let mut sides = [3 * t, 3 * t + 1, 3 * t + 2];
        sides.sort_by(|&x, &y| mesh.edge_length(x).total_cmp(&mesh.edge_length(y)).then(x.cmp(&y)));
        let [short, middle, long] = sides;
        let ends = [mesh.origin(long), mesh.target(long)];
        // A cap's two short sides are nearly as long as its long one together.
        let cap = mesh.edge_length(short) > 0.35 * mesh.edge_length(long);
        let limits = CollapseLimits { longest: 1.5 * reach, angle: bad };
        if cap && flip_is_better(mesh, long) && mesh.flip(long) {
            edits.flips += 1;
        } else if merge(mesh, oracle, short, reach, limits) || merge(mesh, oracle, middle, reach, limits) {
            edits.collapses += 1;
        } else if !cap && mesh.is_triangle(t) && flip_is_better(mesh, long) && ends[0] != ends[1] && mesh.flip(long) {
            edits.flips += 1;
        } else {
            edits.refused += 1;
        }
    }
    Ok(edits)
}

/// Whether the other diagonal has the better worst angle and its triangles face the right way.
fn flip_is_better(mesh: &EditMesh, h: u32) -> bool {
    let o = mesh.opposite(h);
    if o == NONE || mesh.is_sharp(h) || mesh.is_pinned_edge(h) {
        return false;
    }
    let [a, b, c, d] = [mesh.origin(h), mesh.target(h), mesh.apex(h), mesh.apex(o)].map(|v| mesh.point(v));
    let (old, new) = ([[a, b, c], [b, a, d]], [[a, d, c], [d, b, c]]);
    let worst = |t: [[DVec3; 3]; 2]| sharpest_cosine(t[0]).max(sharpest_cosine(t[1]));
    let known = [mesh.normal(h / 3), mesh.normal(o / 3)];
    let sum: DVec3 = old.iter().map(|t| area_vector(*t)).sum();
    let m = known.map(|m| if m == DVec3::ZERO { sum.normalize_or_zero() } else { m });
    let faces = |t: [DVec3; 3]| m.iter().all(|m| area_vector(t).normalize_or_zero().dot(*m) >= 0.9);
    worst(new) < worst(old) && new.into_iter().all(faces)
}

/// The sides of the triangles at a node that it is not on.
fn around(mesh: &EditMesh, v: u32) -> Vec<[DVec3; 2]> {
    mesh.outgoing(v).map(|h| [mesh.point(mesh.target(h)), mesh.point(mesh.apex(h))]).collect()
}

/// The sharpest angle of the triangles from a point to sides, as a cosine.
fn worst_around(ring: &[[DVec3; 2]], p: DVec3) -> f64 {
    ring.iter().map(|[b, c]| sharpest_cosine([p, *b, *c])).fold(-1.0, f64::max)
}

/// The shift of a node within the surface, or along its crease, that raises the worst angle of its triangles most; `None` if none does
/// or the node may not move.
fn better_place(mesh: &EditMesh, v: u32) -> Option<DVec3> {
    /// Shifts as shares of the mean length of the edges at the node, each about a third of the one before.
    const SHIFTS: [f64; 3] = [0.3, 0.12, 0.04];
    /// Directions in the plane: every 45 degrees.
    const WAYS: usize = 8;
    let kind = kind_by_edges(mesh, v);
    if kind == Kind::Corner || mesh.is_boundary(v) {
        return None;
    }
    let ring = around(mesh, v);
    let worst = |p: DVec3| worst_around(&ring, p);
    let p = mesh.point(v);
    let scale = ring.iter().map(|[b, _]| b.distance(p)).sum::<f64>() / ring.len() as f64;
    let ways: Vec<DVec3> = if kind == Kind::Crease {
        let ends = super::crease::feature_neighbors(mesh, v);
        let along = (mesh.point(ends[0]) - mesh.point(ends[1])).normalize_or_zero();
        vec![along, -along]
    } else {
        let (x, y) = super::smooth::node_normal(mesh, v).try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
        (0..WAYS)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / WAYS as f64).sin_cos();
                c * x + s * y
            })
            .collect()
    };
    let mut best = (worst(p), p);
    for shift in SHIFTS {
        for way in &ways {
            let q = best.1 + shift * scale * *way;
            let w = worst(q);
            if w < best.0 {
                best = (w, q);
            }
        }
    }
    (best.1 != p).then_some(best.1)
}

/// A place for a node on its crease if it has one, else on the surface.
fn settled(mesh: &EditMesh, oracle: &dyn SurfaceOracle, v: u32, p: DVec3, reach: f64) -> Option<DVec3> {
    match kind_by_edges(mesh, v) {
        Kind::Crease => settle(mesh, oracle, v, p, reach),
        _ => oracle.project(p, reach).map(|f| f.point),
    }
}

/// Raises the smallest angles one node at a time: around every triangle with an angle below `angle` degrees each
/// node tries small shifts within the surface (along its crease, if it is on one) and takes the one that raises the worst
/// angle of its triangles most. Returns how many nodes moved.
pub fn relax_worst(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    angle: f64,
    reach: f64,
    run: &Run,
) -> Result<usize> {
    let bad = angle.to_radians().cos();
    let mut list: Vec<(f64, u32)> =
        mesh.triangles().map(|t| (sharpest_cosine(mesh.corner_points(t)), t)).filter(|x| x.0 > bad).collect();
    list.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    let mut moved = 0;
    for k in 0..list.len() {
        if k % 256 == 0 {
            run.check()?;
        }
        let frozen = &*mesh;
        ahead(oracle, run, &list, k, |x| {
            for v in frozen.corners(x.1) {
                better_place(frozen, v).and_then(|q| settled(frozen, oracle, v, q, reach));
            }
        })?;
        let t = list[k].1;
        if sharpest_cosine(mesh.corner_points(t)) <= bad {
            continue;
        }
        for v in mesh.corners(t) {
            let Some(better) = better_place(mesh, v) else { continue };
            let p = mesh.point(v);
            let ring = around(mesh, v);
            let worst = |p: DVec3| worst_around(&ring, p);
            let q = settled(mesh, oracle, v, better, reach);
            if let Some(q) = q
                && worst(q) < worst(p)
                && may_move(mesh, v, q)
            {
                mesh.set_point(v, q);
                moved += 1;
            }
        }
    }
    Ok(moved)
}
