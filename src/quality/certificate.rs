//! What a mesh is certified for: the verdict on what was measured.

use rustc_hash::FxHashSet;
use serde::Serialize;

use super::check::Check;
use super::features::SHARP_MESH;
use super::metrics::Shape;
use crate::mesh::TriMesh;

/// Angles below this, degrees, need an excuse.
pub const SMALLEST_ANGLE: f64 = 30.0;

/// The verdict on a mesh.
///
/// *Guarantees*, when there are no faults: the mesh is closed, a manifold, consistently oriented with a positive volume, and
/// no two triangles intersect, by exact predicates. Distances are measured at points, not bounded; triangles that face away
/// from the surface are counted in the deviation.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Certificate {
    /// Why the mesh is not sound; empty if it is.
    pub faults: Vec<String>,
    /// Triangles with an angle below 30 degrees.
    pub below_30: usize,
    /// How many of them have that angle between two sharp edges: it is the part's own.
    pub excused: usize,
    /// The first of those that have no such excuse, by number.
    pub unexcused: Vec<u32>,
}

/// Triangles with small angles.
pub(super) struct Angles {
    below: usize,
    excused: usize,
    unexcused: Vec<u32>,
}

/// How many unexcused triangles a certificate lists.
const LISTED: usize = 100;

pub(super) fn angles(mesh: &TriMesh, shapes: &[Shape]) -> Angles {
    let small: Vec<usize> = (0..shapes.len()).filter(|&t| !(shapes[t].min_angle >= SMALLEST_ANGLE)).collect();
    let mut found = Angles { below: small.len(), excused: 0, unexcused: Vec::new() };
    if small.is_empty() {
        return found;
    }
    let sharp: FxHashSet<[u32; 2]> =
        mesh.sharp_edges(SHARP_MESH).into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    for t in small {
        let (p, nodes) = (mesh.corners(t), mesh.triangles[t]);
        let across = |k: usize| p[(k + 1) % 3].distance_squared(p[(k + 2) % 3]);
        // The smallest angle is across from the shortest side.
        let k = (0..3).min_by(|x, y| across(*x).total_cmp(&across(*y))).unwrap_or(0);
        let is_sharp = |j: usize| sharp.contains(&[nodes[k].min(nodes[j]), nodes[k].max(nodes[j])]);
        if is_sharp((k + 1) % 3) && is_sharp((k + 2) % 3) {
            found.excused += 1;
        } else if found.unexcused.len() < LISTED {
            found.unexcused.push(t as u32);
        }
    }
    found
}

impl Certificate {
    pub(super) fn of(check: &Check, angles: Angles) -> Self {
        let mut faults = Vec::new();
        for (good, what) in
            [(check.closed, "closed"), (check.manifold, "a manifold"), (check.oriented, "consistently oriented")]
        {
            if !good {
                faults.push(format!("the mesh is not {what}"));
            }
        }
        if check.closed && check.oriented && !(check.volume > 0.0) {
            faults.push("the mesh encloses no positive volume".into());
        }
        if check.self_intersections > 0 {
            faults.push(format!("{} triangles intersect others", check.self_intersections));
        }
        Self { faults, below_30: angles.below, excused: angles.excused, unexcused: angles.unexcused }
    }

    /// Whether nothing was found wrong.
    pub fn is_sound(&self) -> bool {
        self.faults.is_empty()
    }
}
