//! Distance and angle between a mesh and the true surface.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::TriMesh;
use crate::numeric::EIGHT_DIGITS;
use crate::run::{PORTION, Run};
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Points the distance is measured at, spread evenly over the area, beside nodes and centroids: one for so many triangles,
const TRIANGLES: usize = 2;
/// but no fewer and no more than these.
const SAMPLES: [usize; 2] = [10_000, 40_000];

/// The surface is looked for within this many mean edge lengths.
const REACH: f64 = 4.0;

/// A triangle that has no side of the surface this share of its longest edge away is turned over.
const SIDE: f64 = 0.1;

/// That distance is at least this share of the mean edge: a triangle far smaller than others may be nearer to a side behind it, for
/// which no other is fine enough. What is as near to a sharp edge counts as on it.
const NEAR: f64 = 0.02;

/// Distance and angle between a mesh and the true surface, seen from the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// Largest distance of a sample, a node or a centroid.
    pub max: f64,
    /// Root mean square distance over the area.
    pub rms: f64,
    /// `eps_n` of \[LIS14\] eq. 5: area-weighted mean of `1 - (n . m)^2`, `m` the surface's normal at the foot of the centroid.
    pub normal: f64,
    /// Largest distance of points of the surface from the mesh, where such points were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_surface: Option<f64>,
    /// Samples without surface within four mean edge lengths.
    pub unprojected: usize,
    /// Triangles whose normal opposes the surface's (`n . m < 0` beyond rounding), which eq. 5 cannot see. One at a right angle, as on a ledge
    /// beside whose edge the foot lies, does not. Where a wall or a gap is thinner than
    /// chords are high, the surface nearest to a triangle may be the other side's: what faces the way of a side within a tenth of
    /// its longest edge, or a fiftieth of the mean edge, is not turned over.
    pub inverted: usize,
    /// Largest distance of the middle of those from the surface.
    pub inverted_distance: f64,
    /// The middle of the one that is farthest from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inverted_at: Option<[f64; 3]>,
    /// Those others whose normal opposes that of the surface nearest to them: chords there are higher than a wall is thick.
    pub across: usize,
}

/// How some triangles face, beside the surface nearest to them.
#[derive(Default)]
struct Facing {
    /// Area times the squared sine of the angle between the normals.
    turn: f64,
    /// Those that are turned over, and those that are across from their side.
    turned: [usize; 2],
    /// The largest distance of all, and of those that are turned over.
    far: [f64; 2],
    /// Where the last is.
    at: Option<DVec3>,
}

/// Van der Corput's sequence in base `b`: the `i`-th of evenly spread numbers in 0..1.
fn radical_inverse(mut i: usize, b: usize) -> f64 {
    let (mut r, mut f) = (0.0, 1.0 / b as f64);
    while i > 0 {
        r += f * (i % b) as f64;
        i /= b;
        f /= b as f64;
    }
    r
}

/// Measures a mesh against the surface. Deterministic: the samples follow a low-discrepancy sequence.
pub fn deviation(mesh: &TriMesh, oracle: &dyn SurfaceOracle, points: &[DVec3], run: &Run) -> Result<Deviation> {
    let reach = REACH * mesh.mean_edge_length();
    let areas: Vec<f64> = (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).collect();
    let mut sums = Vec::with_capacity(areas.len());
    let mut total = 0.0;
    for a in &areas {
        total += a;
        sums.push(total);
    }
    if !(total > 0.0) {
        return Ok(Deviation {
            max: 0.0,
            rms: 0.0,
            normal: 0.0,
            from_surface: None,
            unprojected: 0,
            inverted: 0,
            inverted_distance: 0.0,
            inverted_at: None,
            across: 0,
        });
    }
    let samples = (mesh.triangles.len() / TRIANGLES).clamp(SAMPLES[0], SAMPLES[1]);
    let sample = |i: usize| -> DVec3 {
        let at = (i as f64 + 0.5) / samples as f64 * total;
        let t = sums.partition_point(|s| *s < at).min(areas.len() - 1);
        let (mut u, mut v) = (radical_inverse(i + 1, 2), radical_inverse(i + 1, 3));
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = mesh.corners(t);
        a + (b - a) * u + (c - a) * v
    };
    let near = NEAR * mesh.mean_edge_length();
    let distances = |n: usize, at: &(dyn Fn(usize) -> DVec3 + Sync)| -> Result<Vec<Option<f64>>> {
        let chunks: Result<Vec<Vec<Option<f64>>>> = run.install(|| {
            (0..n.div_ceil(PORTION))
                .into_par_iter()
                .map(|c| {
                    run.check()?;
                    let points: Vec<DVec3> = (c * PORTION..((c + 1) * PORTION).min(n)).map(at).collect();
                    let feet = oracle.project_all(&points, reach);
                    Ok(points.iter().zip(feet).map(|(p, f)| f.map(|f| f.point.distance(*p))).collect())
                })
                .collect()
        });
        Ok(chunks?.concat())
    };
    run.progress("distance", 0.0);
    let sampled = distances(samples, &sample)?;
    run.progress("distance", 0.5);
    let at_nodes = distances(mesh.nodes.len(), &|i| mesh.nodes[i])?;
    let hits: Vec<f64> = sampled.iter().flatten().copied().collect();
    let square: f64 = hits.iter().map(|d| d * d).sum();
    run.progress("normals", 0.0);
    let normals: Result<Vec<Facing>> = run.install(|| {
        (0..areas.len().div_ceil(PORTION))
            .into_par_iter()
            .map(|c| {
                run.check()?;
                let mut all = Facing::default();
                let some = c * PORTION..((c + 1) * PORTION).min(areas.len());
                let some: Vec<usize> = some.filter(|t| areas[*t] > 0.0).collect();
                let middles: Vec<DVec3> = some.iter().map(|t| mesh.centroid(*t)).collect();
                let feet = oracle.project_all(&middles, reach);
                for ((t, p), foot) in some.into_iter().zip(middles).zip(feet) {
                    if let Some(foot) = foot {
                        let away = foot.point.distance(p);
                        all.far[0] = all.far[0].max(away);
                        let dot = mesh.normal(t).dot(foot.normal);
                        all.turn += areas[t] * (1.0 - dot * dot).max(0.0);
                        if opposes(dot) {
                            let side = usize::from(faces_a_side(mesh, t, oracle, [near, reach]));
                            all.turned[side] += 1;
                            if side == 0 && (all.at.is_none() || away > all.far[1]) {
                                (all.far[1], all.at) = (away, Some(p));
                            }
                        }
                    }
                }
                Ok(all)
            })
            .collect()
    });
    let normals = normals?;
    // The first of those that are equally far, for any number of threads.
    let farther = |a: &'_ Facing, b: &'_ Facing| a.at.is_none() || (b.at.is_some() && b.far[1] > a.far[1]);
    let farthest = normals.iter().reduce(|a, b| if farther(a, b) { b } else { a });
    let at_centroids = normals.iter().map(|n| n.far[0]);
    Ok(Deviation {
        from_surface: from_surface(mesh, points, run)?,
        max: hits.iter().chain(at_nodes.iter().flatten()).copied().chain(at_centroids).fold(0.0, f64::max),
        rms: if hits.is_empty() { 0.0 } else { (square / hits.len() as f64).sqrt() },
        normal: normals.iter().map(|n| n.turn).sum::<f64>() / total,
        unprojected: sampled.iter().chain(&at_nodes).filter(|d| d.is_none()).count(),
        inverted: normals.iter().map(|n| n.turned[0]).sum(),
        inverted_distance: normals.iter().map(|n| n.far[1]).fold(0.0, f64::max),
        inverted_at: farthest.and_then(|n| n.at).map(|p| p.to_array()),
        across: normals.iter().map(|n| n.turned[1]).sum(),
    })
}

/// For each node a distance to a point of the surface near it; infinite where none is found within the mesh's diagonal.
///
/// It is never smaller than the distance to the surface, and the same where the oracle's foot is the nearest point. Where
/// the foot is missing or farther than half an edge, feet of points beside the node count as well: where leaves touch an
/// oracle may fail at the very point and answer beside it.
///
/// Errors: cancellation.
pub fn node_distances(mesh: &TriMesh, oracle: &dyn SurfaceOracle, run: &Run) -> Result<Vec<f64>> {
    /// How far from the node towards the middle of a triangle its neighbor points lie.
    const BESIDE: [f64; 4] = [0.25, 4e-3, 6e-5, 1e-6];
    let reach = mesh.bounds().diagonal();
    let from = |p: DVec3, foot: Option<Foot>| foot.map_or(f64::INFINITY, |f| f.point.distance(p));
    let near = |q: DVec3, p: DVec3| from(p, oracle.project(q, reach));
    run.progress("distance", 0.0);
    let chunks: Result<Vec<Vec<f64>>> = run.install(|| {
        let chunks = mesh.nodes.par_chunks(PORTION);
        let away = |nodes: &[DVec3]| {
            run.check()?;
            let feet = oracle.project_all(nodes, reach);
            Ok(nodes.iter().zip(feet).map(|(p, foot)| from(*p, foot)).collect())
        };
        chunks.map(away).collect()
    });
    let mut found = chunks?.concat();
    let far = 0.5 * mesh.mean_edge_length();
    let mut doubtful: Vec<(u32, u32)> = Vec::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        doubtful.extend(corners.iter().filter(|v| !(found[**v as usize] <= far)).map(|v| (*v, t as u32)));
    }
    run.progress("distance", 0.5);
    let better: Result<Vec<f64>> = run.install(|| {
        let one = |(v, t): &(u32, u32)| {
            run.check()?;
            let (p, middle) = (mesh.nodes[*v as usize], mesh.centroid(*t as usize));
            Ok(BESIDE.iter().map(|s| near(p + *s * (middle - p), p)).fold(f64::INFINITY, f64::min))
        };
        doubtful.par_iter().map(one).collect()
    });
    for ((v, _), d) in doubtful.iter().zip(better?) {
        let best = &mut found[*v as usize];
        *best = best.min(d);
    }
    Ok(found)
}

/// Triangles whose normal opposes that of the surface nearest to them, ascending: [inverted](Deviation::inverted) and
/// [across](Deviation::across).
pub fn facing_away(mesh: &TriMesh, oracle: &dyn SurfaceOracle, run: &Run) -> Result<Vec<u32>> {
    let reach = REACH * mesh.mean_edge_length();
    let is_turned = |t: usize, foot: Option<Foot>| foot.is_some_and(|foot| opposes(mesh.normal(t).dot(foot.normal)));
    let chunks: Result<Vec<Vec<u32>>> = run.install(|| {
        (0..mesh.triangles.len().div_ceil(PORTION))
            .into_par_iter()
            .map(|c| {
                run.check()?;
                let list = c * PORTION..((c + 1) * PORTION).min(mesh.triangles.len());
                let list: Vec<usize> = list.filter(|t| mesh.normal(*t).length_squared() > 0.0).collect();
                let middles: Vec<DVec3> = list.iter().map(|t| mesh.centroid(*t)).collect();
                let feet = oracle.project_all(&middles, reach);
                Ok(list.into_iter().zip(feet).filter(|x| is_turned(x.0, x.1)).map(|x| x.0 as u32).collect())
            })
            .collect()
    });
    Ok(chunks?.concat())
}

/// Whether normals with this inner product oppose each other: up to rounding those at a right angle do not.
fn opposes(dot: f64) -> bool {
    dot < -EIGHT_DIGITS
}

/// Whether, as seen from a bit before or behind a triangle, at least `near`, the surface faces its way.
fn faces_a_side(mesh: &TriMesh, t: usize, oracle: &dyn SurfaceOracle, [near, reach]: [f64; 2]) -> bool {
    let ([a, b, c], p) = (mesh.corners(t), mesh.centroid(t));
    let (n, side) = (mesh.normal(t), (SIDE * a.distance(b).max(b.distance(c)).max(c.distance(a))).max(near));
    [side, -side].into_iter().any(|s| {
        let foot = oracle.project(p + s * n, reach);
        foot.is_some_and(|f| f.normal.dot(n) > 0.0 && f.point.distance(p) <= side)
    })
}

/// The largest distance of `points` from the mesh.
fn from_surface(mesh: &TriMesh, points: &[DVec3], run: &Run) -> Result<Option<f64>> {
    if points.is_empty() {
        return Ok(None);
    }
    run.progress("distance", 0.75);
    let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let far: Result<Vec<f64>> = run.install(|| {
        points
            .par_chunks(PORTION)
            .map(|chunk| {
                run.check()?;
                let farthest = |known: f64, p: &DVec3| {
                    let d = |t: u32| triangle_distance_squared(*p, mesh.corners(t as usize));
                    tree.farther(*p, known, d).unwrap_or(known)
                };
                Ok(chunk.iter().fold(0.0, farthest))
            })
            .collect()
    });
    Ok(Some(far?.into_iter().fold(0.0, f64::max).sqrt()))
}
