//! The sheets of a surface around a node: k-means of the normals over a disc, the number of clusters tested.
//!
//! One ring of triangles says little: a chamfer or a sliver in it bends as a crease does. Over a disc a few edges wide the
//! normals form one cluster on a smooth face, two along a crease, three or more around a corner, and chamfers are too few
//! to form one. The plane of each cluster tells whether the node lies on its sheet.

use glam::{DMat3, DVec3};

use crate::mesh::EditMesh;
use crate::mesh::curvature::dihedral;
use crate::mesh::edit::{NONE, next};
use crate::numeric::kmeans::{far_apart, k_means};

/// Radius of the disc in edge lengths: it reaches into the second ring of triangles, so that a row of chamfers along a crease is outnumbered.
pub const DISC: f64 = 1.6;
/// A corner must also show in a disc as many times wider: there noise counts less, and a corner is one at every scale.
const WIDER: f64 = 1.35;
/// The most sheets looked for: more faces than this seldom meet in a point, and a corner shows with three of them.
const SHEETS: usize = 4;
/// At half of the length along which two clusters touch the surface must bend by this share of the angle between their centers. A
/// curved face bends everywhere, so an edge of it has a third of the angle between two halves of a disc; a crease has all, and
/// half where a chamfer is in between.
const AT_ONCE: f64 = 0.4;
/// The smallest share of the disc's weight that is a sheet; two triangles of a disc have about a tenth.
const LEAST_SHARE: f64 = 0.12;
/// A node is on a sheet when it is no farther from its plane than this, in edge lengths: chords of a face with two nodes
/// to the radius are as high as that, and nodes off a crease are a quarter of an edge away or more.
const ON: f64 = 0.1;
/// Triangles whose normals are farther from their cluster's than this, radians, do not tell where its sheet is: a chamfer of a
/// right angle is 45 degrees off, a face of two nodes to the radius bends by 29 from edge to edge.
const CORE: f64 = 0.5;
/// Three sheets make a corner when the volume their unit normals span exceeds this. A chamfer along a bent crease
/// stays below, three faces of a box have 1.
const VOLUME: f64 = 0.25;
/// A corner's node is no farther from where the sheets meet than this, in edge lengths: half an edge, else another
/// node of a full mesh would be nearer.
const NEAR: f64 = 0.5;

/// Places where sheets meet that are closer than this, in edge lengths, are one corner seen from several nodes: two corners
/// that close have no edge of the mesh between them.
const APART: f64 = 1.0;

/// What the sheets around a node make of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SheetsAround {
    /// Unit direction of the crease on which the node lies.
    pub crease: Option<DVec3>,
    /// Where three sheets meet nearby.
    pub corner: Option<DVec3>,
    /// The edge length that counts here.
    pub edge: f64,
}

/// One sheet: its unit normal and its distance from the node along it.
struct NodeSheet {
    normal: DVec3,
    offset: f64,
}

/// Mean length of a node's edges.
fn ring_length(mesh: &EditMesh, v: u32) -> f64 {
    let (sum, n) = mesh.neighbors(v).fold((0.0, 0u32), |(s, n), x| (s + mesh.point(x).distance(mesh.point(v)), n + 1));
    sum / f64::from(n.max(1))
}

/// The triangles around a node that connect to it within `radius`, by their centers; the node's own come first.
fn disc(mesh: &EditMesh, v: u32, radius: f64) -> Vec<u32> {
    let p = mesh.point(v);
    let mut out: Vec<u32> = mesh.outgoing(v).map(|h| h / 3).collect();
    let mut done = 0;
    while let Some(&t) = out.get(done) {
        done += 1;
        for h in 3 * t..3 * t + 3 {
            let o = mesh.opposite(h);
            if o != NONE && mesh.centroid(o / 3).distance(p) <= radius && !out.contains(&(o / 3)) {
                out.push(o / 3);
            }
        }
    }
    out
}

/// Looks at the sheets around a node; `angle` in radians is the smallest between two faces with a crease between them.
pub(super) fn around(mesh: &EditMesh, v: u32, angle: f64) -> SheetsAround {
    // Most nodes are regular, and the triangles around them tell: a crease that the node is on passes through them.
    let bent = |h: u32| dihedral(mesh, h) >= angle * AT_ONCE;
    if !mesh.outgoing(v).any(|h| bent(h) || bent(next(h))) {
        return SheetsAround::default();
    }
    let p = mesh.point(v);
    // Nodes crowd along creases, so a node's own edges may be short where those around it are not.
    let edge = mesh.neighbors(v).map(|x| ring_length(mesh, x)).fold(ring_length(mesh, v), f64::max);
    let mut out = SheetsAround { edge, ..SheetsAround::default() };
    let triangles = disc(mesh, v, DISC * edge);
    let sheets = sheets(mesh, p, edge, angle, &triangles);

    let mut widest = angle;
    for (k, a) in sheets.iter().enumerate() {
        for b in &sheets[..k] {
            let between = a.normal.angle_between(b.normal);
            if between >= widest && a.offset.abs().max(b.offset.abs()) <= ON * edge {
                widest = between;
                out.crease = a.normal.cross(b.normal).try_normalize();
            }
        }
    }
    out.corner = meeting(p, edge, &sheets).filter(|_| {
        let wide = self::sheets(mesh, p, edge, angle, &disc(mesh, v, WIDER * DISC * edge));
        meeting(p, edge, &wide).is_some()
    });
    out
}

/// Where three sheets meet near the node at `p`, those that are most independent.
fn meeting(p: DVec3, edge: f64, sheets: &[NodeSheet]) -> Option<DVec3> {
    let (mut largest, mut out) = (VOLUME, None);
    for (k, a) in sheets.iter().enumerate() {
        for (j, b) in sheets[..k].iter().enumerate() {
            for c in &sheets[..j] {
                let rows = DMat3::from_cols(a.normal, b.normal, c.normal).transpose();
                let volume = rows.determinant().abs();
                if volume < largest {
                    continue;
                }
                let step = rows.inverse() * DVec3::new(a.offset, b.offset, c.offset);
                if step.length() <= 2.0 * NEAR * edge {
                    largest = volume;
                    out = Some(p + step);
                }
            }
        }
    }
    out
}

/// The sheets of a disc: as many as k-means finds that pass the test, at least one.
fn sheets(mesh: &EditMesh, p: DVec3, edge: f64, angle: f64, triangles: &[u32]) -> Vec<NodeSheet> {
    let vectors: Vec<DVec3> = triangles.iter().map(|&t| mesh.area_vector(t)).collect();
    let areas: Vec<f64> = vectors.iter().map(|a| a.length()).collect();
    let normals: Vec<[f64; 3]> = vectors.iter().map(|a| a.normalize_or_zero().to_array()).collect();
    // The inner edges of the disc with their triangles, bends and lengths.
    let mut inner = Vec::new();
    for (i, &t) in triangles.iter().enumerate() {
        for h in 3 * t..3 * t + 3 {
            let o = mesh.opposite(h);
            if o != NONE
                && h < o
                && let Some(j) = triangles.iter().position(|&x| x == o / 3)
            {
                inner.push(InnerEdge { sides: [i, j], bend: dihedral(mesh, h), length: mesh.edge_length(h) });
            }
        }
    }
    if inner.iter().all(|e| e.bend < angle * AT_ONCE) {
        return Vec::new();
    }
    for count in (2..=SHEETS).rev() {
        let starts = far_apart(&normals, &areas, count);
        if starts.len() < count {
            continue;
        }
        let clusters = k_means(&normals, &areas, starts);
        if !are_apart(&clusters.centers, &clusters.of, &inner, angle) {
            continue;
        }
        let total: f64 = areas.iter().sum();
        let share = |k: usize| areas.iter().zip(&clusters.of).filter(|x| *x.1 == k).map(|x| x.0).sum::<f64>() / total;
        if (0..count).any(|k| share(k) < LEAST_SHARE) {
            continue;
        }
        let sheet = |k: usize| {
            let mut planes: Vec<(f64, f64)> = Vec::new();
            let mut normal = DVec3::ZERO;
            let mut core = DVec3::from_array(clusters.centers[k]).normalize_or_zero();
            let cosine = CORE.cos();
            for _ in 0..2 {
                let near = |i: &usize| clusters.of[*i] == k && core.dot(DVec3::from_array(normals[*i])) >= cosine;
                core = (0..triangles.len()).filter(near).map(|i| vectors[i]).sum::<DVec3>().normalize_or(core);
            }
            let near = |i: usize| clusters.of[i] == k && core.dot(DVec3::from_array(normals[i])) >= cosine;
            for (i, &t) in triangles.iter().enumerate().filter(|x| near(x.0)) {
                let c = mesh.centroid(t) - p;
                let weight = areas[i] / (c.length_squared() + 0.0625 * edge * edge);
                let n = DVec3::from_array(normals[i]);
                planes.push((n.dot(c), weight));
                normal += weight * n;
            }
            NodeSheet { normal: normal.normalize_or_zero(), offset: weighted_median(planes) }
        };
        return (0..count).map(sheet).collect();
    }
    Vec::new()
}

/// An edge inside a disc.
struct InnerEdge {
    sides: [usize; 2],
    bend: f64,
    length: f64,
}

/// Whether clusters of normals are faces with creases between them: centers farther apart than `angle`, and where two of them
/// touch the surface bends at once.
fn are_apart(centers: &[[f64; 3]], of: &[usize], inner: &[InnerEdge], angle: f64) -> bool {
    for (a, m) in centers.iter().enumerate() {
        for (b, n) in centers.iter().enumerate().take(a) {
            let between = DVec3::from_array(*m).angle_between(DVec3::from_array(*n));
            if between.is_nan() || between < angle {
                return false;
            }
            let touching = inner.iter().filter(|e| {
                let sides = e.sides.map(|s| of[s]);
                sides == [a, b] || sides == [b, a]
            });
            let bends: Vec<(f64, f64)> = touching.map(|e| (e.bend, e.length)).collect();
            if !bends.is_empty() && weighted_median(bends) < angle.max(AT_ONCE * between) {
                return false;
            }
        }
    }
    true
}

/// The value below which half of the weight lies.
fn weighted_median(mut values: Vec<(f64, f64)>) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|x| x.1).sum::<f64>();
    let mut sum = 0.0;
    for (x, w) in values {
        sum += w;
        if sum >= half {
            return x;
        }
    }
    0.0
}

/// Of all nodes near places where sheets meet the best one each: nearest first, and none within an edge of one that
/// has been taken for the same place.
pub(super) fn best_corners(mesh: &EditMesh, seen: &[Option<SheetsAround>]) -> Vec<u32> {
    let mut candidates: Vec<(f64, u32, DVec3, f64)> = Vec::new();
    for (v, a) in seen.iter().enumerate() {
        if let Some(a) = a
            && let Some(at) = a.corner
        {
            let d = at.distance(mesh.point(v as u32)) / a.edge;
            if d <= NEAR {
                candidates.push((d, v as u32, at, a.edge));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut taken: Vec<(u32, DVec3)> = Vec::new();
    for (_, v, at, edge) in candidates {
        if taken.iter().all(|t| t.1.distance(at).min(mesh.point(t.0).distance(mesh.point(v))) > APART * edge) {
            taken.push((v, at));
        }
    }
    taken.into_iter().map(|t| t.0).collect()
}
