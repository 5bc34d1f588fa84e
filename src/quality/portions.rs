//! The measures of a mesh that comes in portions.

use std::collections::BTreeMap;

use glam::DVec3;

use super::certificate::{Angles, Certificate, Expectation, MeshFaults, Spots};
use super::check::{Check, GroupSummary, add_groups};
use super::features::SHARP_MESH;
use super::metrics::{Quality, shapes};
use crate::error::Result;
use crate::mesh::portion::{Joined, PlacedEdge, Portion, intersections_between};
use crate::mesh::{TriMesh, self_intersections};
use crate::run::Run;

/// Adds portions up to the [`Check`] of the whole, number for number that of [`check`](super::check()) if they are added in order.
pub(crate) struct Sums {
    joined: Joined,
    groups: Vec<GroupSummary>,
    /// Volumes are measured from here: the first node.
    origin: Option<DVec3>,
    area: f64,
    volume: f64,
    quality: Quality,
    /// The smallest angles so far, as many as the percentile asks for and some.
    low: Vec<f64>,
    angles: Angles,
    /// Triangles that intersect others, with their centroids.
    crossing: BTreeMap<u32, DVec3>,
}

impl Sums {
    /// Nothing yet of a mesh with these names of faces.
    pub(crate) fn new(joined: Joined, names: &TriMesh) -> Self {
        let group = |f: &String| GroupSummary { name: f.clone(), triangles: 0, area: 0.0 };
        Self {
            joined,
            groups: names.faces.iter().map(group).collect(),
            origin: None,
            area: 0.0,
            volume: 0.0,
            quality: Quality { min_angle: f64::INFINITY, ..Quality::default() },
            low: Vec::new(),
            angles: Angles::default(),
            crossing: BTreeMap::new(),
        }
    }

    /// Where the 5th percentile is among the angles, ascending.
    fn percentile(&self) -> f64 {
        0.05 * self.joined.whole.triangles.saturating_sub(1) as f64
    }

    /// Adds a portion and what intersects inside it.
    pub(crate) fn add(&mut self, p: &Portion, run: &Run) -> Result<()> {
        let mesh = &p.mesh;
        let origin = *self.origin.get_or_insert(mesh.nodes.first().copied().unwrap_or_default());
        for (t, label) in mesh.labels.iter().enumerate() {
            let area = 0.5 * mesh.area_vector(t).length();
            let g = &mut self.groups[*label as usize];
            g.triangles += 1;
            g.area += area;
            self.area += area;
            let [a, b, c] = mesh.corners(t).map(|q| q - origin);
            self.volume += a.dot(b.cross(c)) / 6.0;
        }
        let shapes = run.install(|| shapes(mesh));
        let q = &mut self.quality;
        for s in &shapes {
            q.min_angle = q.min_angle.min(s.min_angle);
            q.max_angle = q.max_angle.max(s.max_angle);
            q.mean_radius_ratio += s.radius_ratio;
            q.below_20 += f64::from(u8::from(s.min_angle < 20.0));
        }
        self.low.extend(shapes.iter().map(|s| s.min_angle));
        let kept = self.percentile() as usize + 2;
        if self.low.len() > kept {
            self.low.select_nth_unstable_by(kept - 1, f64::total_cmp);
            self.low.truncate(kept);
        }
        let shared = &self.joined.sharp;
        let sharp = || {
            let here = p.sharp_edges(SHARP_MESH, false);
            let local = |e: [u32; 2]| here.contains(&p.named(e)) || (p.is_shared(e) && shared.contains(&p.named(e)));
            let ends = mesh.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
            ends.filter(|e| local(*e)).map(|[a, b]| [a.min(b), a.max(b)]).collect()
        };
        self.angles.add(mesh, &shapes, p.first, sharp);
        let hit = self_intersections(mesh, run)?;
        self.note(p, hit.as_flattened());
        Ok(())
    }

    /// Adds what intersects between two portions.
    pub(crate) fn add_between(&mut self, one: &Portion, other: &Portion, run: &Run) -> Result<()> {
        let hit = intersections_between(one, other, run)?;
        self.note(one, &hit.one);
        self.note(other, &hit.other);
        Ok(())
    }

    fn note(&mut self, p: &Portion, triangles: &[u32]) {
        self.crossing.extend(triangles.iter().map(|t| (p.first + t, p.mesh.centroid(*t as usize))));
    }

    fn summed_up(&mut self) -> Quality {
        let n = self.joined.whole.triangles;
        if n == 0 {
            return Quality::default();
        }
        let at = self.percentile();
        let (_, &mut low, above) = self.low.select_nth_unstable_by(at as usize, f64::total_cmp);
        let high = if at.fract() > 0.0 { above.iter().copied().fold(f64::INFINITY, f64::min) } else { low };
        let q = self.quality;
        let n = n as f64;
        let (mean_radius_ratio, below_20) = (q.mean_radius_ratio / n, q.below_20 / n);
        Quality { p05_angle: low + (high - low) * at.fract(), mean_radius_ratio, below_20, ..q }
    }

    /// The check of the whole, which is expected to be closed.
    pub(crate) fn finish(mut self, names: &TriMesh) -> Check {
        let quality = self.summed_up();
        let Self { joined: Joined { whole, .. }, mut groups, crossing, .. } = self;
        add_groups(&mut groups, names);
        let closed = whole.open.is_empty() && whole.triangles > 0;
        let (manifold, oriented, euler) = (whole.is_manifold(), whole.misoriented.is_empty(), whole.euler());
        let good = closed && manifold && oriented;
        let mut check = Check {
            nodes: whole.nodes,
            triangles: whole.triangles,
            closed,
            manifold,
            oriented,
            self_intersections: crossing.len(),
            touching: 0,
            components: whole.components,
            euler,
            genus: good.then_some((2 * whole.components as i64 - euler) / 2),
            area: self.area,
            volume: (closed && oriented).then_some(self.volume),
            quality,
            groups,
            deviation: None,
            certificate: Certificate::default(),
            features: None,
        };
        let spots = |edges: &[PlacedEdge]| Spots::new(edges.len(), edges.iter().map(PlacedEdge::middle));
        let pinched = whole.pinched.iter().map(|v| v.1);
        let places = whole.nonmanifold.iter().map(PlacedEdge::middle).chain(pinched);
        let found = MeshFaults {
            open: spots(&whole.open),
            nonmanifold: Spots::new(whole.nonmanifold.len() + whole.pinched.len(), places),
            misoriented: spots(&whole.misoriented),
            crossing: Spots::new(crossing.len(), crossing.values().copied()),
        };
        check.certificate = Certificate::of(&check, found, Expectation::default()).with(self.angles);
        check
    }
}
