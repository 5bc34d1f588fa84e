//! How well a mesh recovers the true sharp edges and corners.

use glam::DVec3;
use serde::Serialize;

use crate::error::Result;
use crate::geometry::{Features, Pieces};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Mesh edges count as sharp above this dihedral deviation, degrees.
pub const SHARP_MESH: f64 = 30.0;

/// True edges must be recovered above this angle between the normals, degrees.
pub const SHARP_TRUE: f64 = 40.0;

/// Recovered means within this share of the length scale.
const WITHIN: f64 = 0.05;

/// Sharp mesh edges are sampled at this share of the length scale.
const STEP: f64 = 1.0 / 6.0;

/// Recovery of sharp edges and corners. Shares are 1 where there is nothing to recover.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FeatureRecovery {
    /// Whether the true edges are known. They are not where the surface names no edge and the mesh has sharp ones, which lie inside one
    /// formula, say. Recall and precision tell nothing then.
    pub known: bool,
    /// Length of the true edges above 40 degrees.
    pub length_true: f64,
    /// Length of the mesh's edges above 30 degrees.
    pub length_mesh: f64,
    /// Share of the true length that has a sharp mesh edge within 5 % of the length scale.
    pub recall: f64,
    /// Share of the sharp mesh length that has a true edge, of any angle, within 5 % of the length scale.
    pub precision: f64,
    /// True corners.
    pub corners_true: usize,
    /// True corners with a node within 5 % of the length scale.
    pub corners_found: usize,
    /// Largest distance of the nodes of recovering mesh edges from a curve within 5 % of the length scale in which the pieces of the
    /// surface meet; from the tangents of the true edge where pieces are not known, which is exact to second order in the samples' length.
    pub node_residual_max: f64,
}

/// Measures the recovery; `h` is the length scale: the size that was asked for, or the mean edge length where that is not known.
pub fn recovery(
    mesh: &TriMesh,
    truth: &Features,
    pieces: Option<&dyn Pieces>,
    h: f64,
    run: &Run,
) -> Result<FeatureRecovery> {
    run.progress("features", 0.0);
    let sharp: Vec<[u32; 2]> = mesh.sharp_edges(SHARP_MESH);
    let ends: Vec<[DVec3; 2]> = sharp.iter().map(|e| e.map(|v| mesh.nodes[v as usize])).collect();
    let mesh_edges = Bvh::new(ends.iter().map(|e| Aabb::around(*e)).collect());
    let near = WITHIN * h;
    let must: Vec<_> = truth.samples.iter().filter(|s| s.angle > SHARP_TRUE).collect();
    // The sum of nothing is -0 otherwise.
    let length_true = must.iter().fold(0.0, |sum, s| sum + s.length);
    run.check()?;
    let mut recovered = 0.0;
    for s in &must {
        let d = |i: u32| s.point.distance_squared(segment_foot(s.point, ends[i as usize]));
        if mesh_edges.nearest(s.point, near, d).is_some() {
            recovered += s.length;
        }
    }
    run.check()?;
    let tangents: Vec<[DVec3; 2]> = truth
        .samples
        .iter()
        // a little longer than the piece itself: neighboring tangents of a curve leave gaps
        .map(|s| [s.point - s.tangent * (0.6 * s.length), s.point + s.tangent * (0.6 * s.length)])
        .collect();
    let true_edges = Bvh::new(tangents.iter().map(|e| Aabb::around(*e)).collect());
    let to_truth = |p: DVec3| {
        let d = |i: u32| p.distance_squared(segment_foot(p, tangents[i as usize]));
        true_edges.nearest(p, near, d)
    };
    let off = |p: DVec3| {
        let (_, d) = to_truth(p)?;
        // Where edges end, and where they run as close to each other as the sides of a foil, it lies on one of several.
        let mut least = f64::INFINITY;
        true_edges.overlapping(&Aabb::new(p, p).grown(near), |i| {
            if p.distance(segment_foot(p, tangents[i as usize])) <= near {
                let exact = pieces.and_then(|s| s.meet(&truth.samples[i as usize].pieces, p, near));
                least = least.min(exact.map_or(d.sqrt(), |q| q.distance(p)));
            }
        });
        Some(least)
    };
    let (mut length_mesh, mut right, mut residual) = (0.0, 0.0, 0.0f64);
    for [a, b] in &ends {
        let length = a.distance(*b);
        length_mesh += length;
        let n = (length / (STEP * h)).ceil().max(1.0) as usize;
        let hits = (0..n).filter(|i| to_truth(a.lerp(*b, (*i as f64 + 0.5) / n as f64)).is_some()).count();
        right += length * hits as f64 / n as f64;
        if hits == n {
            residual = [a, b].iter().filter_map(|p| off(**p)).fold(residual, f64::max);
        }
    }
    run.check()?;
    // There are few corners and many nodes.
    let corners = Bvh::new(truth.corners.iter().map(|c| Aabb::new(*c, *c).grown(near)).collect());
    let mut found = vec![false; truth.corners.len()];
    for p in mesh.nodes.iter().filter(|_| !truth.corners.is_empty()) {
        corners
            .overlapping(&Aabb::new(*p, *p), |c| found[c as usize] |= truth.corners[c as usize].distance(*p) <= near);
    }
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 1.0 };
    Ok(FeatureRecovery {
        known: !truth.samples.is_empty() || !truth.corners.is_empty() || sharp.is_empty(),
        length_true,
        length_mesh,
        recall: share(recovered, length_true),
        precision: share(right, length_mesh),
        corners_true: truth.corners.len(),
        corners_found: found.into_iter().filter(|f| *f).count(),
        node_residual_max: residual,
    })
}
