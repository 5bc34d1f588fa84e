//! What a mesh is certified for: the verdict on what was measured.

use std::fmt;

use glam::DVec3;
use rustc_hash::FxHashSet;
use serde::Serialize;

use super::check::Check;
use super::fault::{Fault, first};
use super::metrics::TriangleMeasures;
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
    /// Their centroids.
    #[serde(skip)]
    pub unexcused_places: Vec<[f64; 3]>,
}

/// Triangles with small angles.
#[derive(Default)]
pub(super) struct Angles {
    below: usize,
    excused: usize,
    unexcused: Vec<u32>,
    places: Vec<[f64; 3]>,
}

/// How many unexcused triangles a certificate lists.
const LISTED: usize = 100;

impl Angles {
    /// Adds a mesh's triangles; `sharp` is asked only where an angle is small, for all sharp edges of the mesh. `number` is that of
    /// its first triangle.
    pub(super) fn add(
        &mut self,
        mesh: &TriMesh,
        shapes: &[TriangleMeasures],
        number: u32,
        sharp: impl FnOnce() -> FxHashSet<[u32; 2]>,
    ) {
        let small: Vec<usize> = (0..shapes.len()).filter(|&t| !(shapes[t].min_angle >= SMALLEST_ANGLE)).collect();
        if small.is_empty() {
            return;
        }
        self.below += small.len();
        let sharp = sharp();
        for t in small {
            let (p, nodes) = (mesh.corners(t), mesh.triangles[t]);
            let across = |k: usize| p[(k + 1) % 3].distance_squared(p[(k + 2) % 3]);
            // The smallest angle is across from the shortest side.
            let k = (0..3).min_by(|x, y| across(*x).total_cmp(&across(*y))).unwrap_or(0);
            let is_sharp = |j: usize| sharp.contains(&[nodes[k].min(nodes[j]), nodes[k].max(nodes[j])]);
            if is_sharp((k + 1) % 3) && is_sharp((k + 2) % 3) {
                self.excused += 1;
            } else if self.unexcused.len() < LISTED {
                self.unexcused.push(number + t as u32);
                self.places.push(mesh.centroid(t).to_array());
            }
        }
    }
}

/// How many there are of something, and where the first ones are.
#[derive(Default)]
pub(super) struct Spots {
    pub(super) count: usize,
    pub(super) places: Vec<[f64; 3]>,
}

impl Spots {
    pub(super) fn new(count: usize, places: impl Iterator<Item = DVec3>) -> Self {
        Self { count, places: first(places) }
    }
}

/// What may be wrong with a mesh.
#[derive(Default)]
pub(super) struct MeshFaults {
    pub(super) open: Spots,
    pub(super) nonmanifold: Spots,
    pub(super) misoriented: Spots,
    /// Triangles that intersect others; places where they are known.
    pub(super) crossing: Spots,
}

impl MeshFaults {
    pub(super) fn of(mesh: &TriMesh, defects: &Defects) -> Self {
        let middle = |e: &[u32; 2]| 0.5 * (mesh.nodes[e[0] as usize] + mesh.nodes[e[1] as usize]);
        let spots = |edges: &[[u32; 2]]| Spots::new(edges.len(), edges.iter().map(middle));
        let (edges, nodes) = (&defects.nonmanifold_edges, &defects.nonmanifold_nodes);
        let places = edges.iter().map(middle).chain(nodes.iter().map(|v| mesh.nodes[*v as usize]));
        Self {
            open: spots(&defects.open_edges),
            nonmanifold: Spots::new(edges.len() + nodes.len(), places),
            misoriented: spots(&defects.misoriented_edges),
            crossing: Spots::default(),
        }
    }
}

impl Certificate {
    pub(super) fn of(check: &Check, found: MeshFaults, expected: Expectation) -> Self {
        let mut faults = Vec::new();
        if !check.closed && !expected.open {
            faults.push(Fault::Open { edges: found.open.count, places: found.open.places });
        }
        if !check.manifold {
            faults.push(Fault::NonManifold { count: found.nonmanifold.count, places: found.nonmanifold.places });
        }
        if !check.oriented {
            faults.push(Fault::NotOriented { edges: found.misoriented.count, places: found.misoriented.places });
        }
        if let Some(volume) = check.volume.filter(|v| !(*v > 0.0))
            && !expected.open
        {
            faults.push(Fault::Inverted { volume });
        }
        if found.crossing.count > 0 {
            let own_body = expected.touching && check.components > 1;
            let Spots { count, places } = found.crossing;
            faults.push(Fault::Crossing { triangles: count, own_body, places });
        }
        let open = expected.open && !check.closed;
        Self { faults, open, ..Self::default() }
    }

    pub(super) fn with(self, angles: Angles) -> Self {
        let Angles { below, excused, unexcused, places } = angles;
        Self { below_30: below, excused, unexcused, unexcused_places: places, ..self }
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
