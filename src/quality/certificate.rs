//! What a mesh is certified for: the verdict on what was measured.

use std::fmt;

use rustc_hash::FxHashSet;
use serde::Serialize;

use super::check::Check;
use super::fault::{Fault, first};
use super::features::SHARP_MESH;
use super::metrics::Shape;
use crate::mesh::{Defects, TriMesh};

/// Angles below this, degrees, need an excuse.
pub const SMALLEST_ANGLE: f64 = 30.0;

/// What a mesh is expected to be: said before it is judged, as what is meant to be open is not at fault for it.
///
/// The default is a closed surface of which no part touches another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Expectation {
    /// It may be open: that is no fault then, and neither is which side is out.
    pub open: bool,
    /// Bodies may touch and overlap: only triangles that intersect others of their own body are at fault.
    pub touching: bool,
}

/// The verdict on a mesh.
///
/// *Guarantees*, when there are no faults: the mesh is closed, a manifold, consistently oriented with a positive volume, and
/// no two triangles intersect, by exact predicates; less what was [expected](Expectation). Distances are measured at points, not bounded; triangles that face away
/// from the surface are counted in the deviation.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Certificate {
    /// Why the mesh is not sound; empty if it is.
    pub faults: Vec<Fault>,
    /// Whether it is open and was expected to be.
    pub open: bool,
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

/// Triangles that intersect others: how many, and the first ones where they are known.
#[derive(Default)]
pub(super) struct Crossings {
    pub(super) triangles: usize,
    pub(super) known: Vec<u32>,
}

impl Certificate {
    pub(super) fn of(
        mesh: &TriMesh,
        check: &Check,
        defects: &Defects,
        crossings: &Crossings,
        expected: Expectation,
    ) -> Self {
        let middle = |e: &[u32; 2]| 0.5 * (mesh.nodes[e[0] as usize] + mesh.nodes[e[1] as usize]);
        let mut faults = Vec::new();
        if !check.closed && !expected.open {
            let open = &defects.open_edges;
            faults.push(Fault::Open { edges: open.len(), places: first(open.iter().map(middle)) });
        }
        if !check.manifold {
            let (edges, nodes) = (&defects.nonmanifold_edges, &defects.nonmanifold_nodes);
            let places = edges.iter().map(middle).chain(nodes.iter().map(|v| mesh.nodes[*v as usize]));
            faults.push(Fault::NonManifold { count: edges.len() + nodes.len(), places: first(places) });
        }
        if !check.oriented {
            let edges = &defects.misoriented_edges;
            faults.push(Fault::NotOriented { edges: edges.len(), places: first(edges.iter().map(middle)) });
        }
        if let Some(volume) = check.volume.filter(|v| !(*v > 0.0))
            && !expected.open
        {
            faults.push(Fault::Inverted { volume });
        }
        if crossings.triangles > 0 {
            let own_body = expected.touching && check.components > 1;
            let places = first(crossings.known.iter().map(|t| mesh.centroid(*t as usize)));
            faults.push(Fault::Crossing { triangles: crossings.triangles, own_body, places });
        }
        let open = expected.open && !check.closed;
        Self { faults, open, ..Self::default() }
    }

    pub(super) fn with(self, angles: Angles) -> Self {
        Self { below_30: angles.below, excused: angles.excused, unexcused: angles.unexcused, ..self }
    }

    /// Whether nothing was found wrong.
    pub fn is_sound(&self) -> bool {
        self.faults.is_empty()
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_sound() {
            return f.write_str(if self.open { "sound, open" } else { "sound" });
        }
        for (i, fault) in self.faults.iter().enumerate() {
            write!(f, "{}{fault}", if i > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}
