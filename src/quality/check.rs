//! Everything measured of one mesh.

use std::fmt;

use glam::DVec3;
use serde::Serialize;

use super::certificate::{Angles, Certificate, Expectation, MeshFaults, Spots};
use super::deviation::{Deviation, deviation};
use super::features::{FeatureRecovery, SHARP_MESH, recovery};
use super::metrics::{Quality, shapes, summed_up};
use crate::error::Result;
use crate::geometry::{Features, Pieces, SurfaceOracle};
use crate::mesh::{MeshView, TriMesh, self_intersections};
use crate::run::Run;

/// What a mesh is measured against.
#[derive(Clone, Copy)]
pub struct Against<'a> {
    /// The true surface.
    pub oracle: &'a dyn SurfaceOracle,
    /// Its true sharp edges and corners, where they are known.
    pub features: Option<&'a Features>,
    /// Its pieces, where they are known: nodes on edges are then measured exactly.
    pub pieces: Option<&'a dyn Pieces>,
    /// Points of the true surface, to measure the distance from it to the mesh.
    pub points: &'a [DVec3],
}

impl<'a> Against<'a> {
    /// The surface alone.
    pub fn new(oracle: &'a dyn SurfaceOracle) -> Self {
        Self { oracle, features: None, pieces: None, points: &[] }
    }
}

/// One face or group.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSummary {
    /// The name.
    pub name: String,
    /// How many triangles.
    pub triangles: usize,
    /// Their area.
    pub area: f64,
}

/// Everything measured of one mesh. Lengths are in the mesh's unit, angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Nodes in use.
    pub nodes: usize,
    /// Triangles.
    pub triangles: usize,
    /// No open edge, and some triangle.
    pub closed: bool,
    /// No edge of more than two triangles, one fan at every node.
    pub manifold: bool,
    /// Neighbors agree on which side is out.
    pub oriented: bool,
    /// Triangles that intersect another one, by exact predicates; where bodies may touch, another one of their body.
    pub self_intersections: usize,
    /// Triangles that only intersect ones of other bodies, where that was expected.
    pub touching: usize,
    /// Pieces.
    pub components: usize,
    /// Nodes - edges + triangles.
    pub euler: i64,
    /// Handles of a closed surface.
    pub genus: Option<i64>,
    /// Area.
    pub area: f64,
    /// Enclosed volume of a closed, oriented mesh; no other has one.
    pub volume: Option<f64>,
    /// Shape of the triangles.
    pub quality: Quality,
    /// The faces, then the groups.
    pub groups: Vec<GroupSummary>,
    /// Distance and angle to the true surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<Deviation>,
    /// What the mesh is certified for.
    pub certificate: Certificate,
    /// Recovery of sharp edges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub features: Option<FeatureRecovery>,
}

/// Measures a mesh, independently of how it was made, and judges it by what is expected of it.
///
/// A mesh that is not kept in arrays is [copied](TriMesh::of_view) for it.
///
/// Errors: a mesh that is not [valid](TriMesh::validate); cancellation.
pub fn check(mesh: &dyn MeshView, expected: Expectation, against: Option<Against<'_>>, run: &Run) -> Result<Check> {
    mesh.check()?;
    check_tested(&run.install(|| TriMesh::of_view(mesh)), None, expected, against, run)
}

/// Like [`check`], for a mesh that [`self_intersections`] has been asked about already: `intersecting` triangles were found
/// to intersect others.
pub fn check_tested(
    mesh: &TriMesh,
    intersecting: Option<usize>,
    expected: Expectation,
    against: Option<Against<'_>>,
    run: &Run,
) -> Result<Check> {
    mesh.validate()?;
    run.progress("topology", 0.0);
    let defects = mesh.defects();
    let topology = mesh.topology(&defects);
    let (crossings, touching) = match intersecting {
        Some(known) if known == 0 || !expected.touching => (Spots { count: known, ..Spots::default() }, 0),
        _ => crossings(mesh, expected, run)?,
    };
    let mut groups: Vec<GroupSummary> =
        mesh.faces.iter().map(|f| GroupSummary { name: f.clone(), triangles: 0, area: 0.0 }).collect();
    for (t, l) in mesh.labels.iter().enumerate() {
        let g = &mut groups[*l as usize];
        g.triangles += 1;
        g.area += 0.5 * mesh.area_vector(t).length();
    }
    add_groups(&mut groups, mesh);
    let (mut far, mut features) = (None, None);
    if let Some(a) = against {
        far = Some(deviation(mesh, a.oracle, a.points, run)?);
        if let Some(f) = a.features {
            features = Some(recovery(mesh, f, a.pieces, mesh.mean_edge_length(), run)?);
        }
    }
    let shapes = run.install(|| shapes(mesh));
    let mut check = Check {
        nodes: mesh.nodes.len() - defects.unused_nodes.len(),
        triangles: mesh.triangles.len(),
        closed: defects.is_closed() && !mesh.triangles.is_empty(),
        manifold: defects.is_manifold(),
        oriented: defects.is_oriented(),
        self_intersections: crossings.count,
        touching,
        components: topology.components,
        euler: topology.euler,
        genus: topology.genus,
        area: mesh.area(),
        volume: (defects.is_closed() && defects.is_oriented() && !mesh.triangles.is_empty()).then(|| mesh.volume()),
        quality: summed_up(&shapes),
        groups,
        deviation: far,
        certificate: Certificate::default(),
        features,
    };
    let mut angles = Angles::default();
    let sharp = || mesh.sharp_edges(SHARP_MESH).into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    angles.add(mesh, &shapes, 0, sharp);
    let found = MeshFaults { crossing: crossings, ..MeshFaults::of(mesh, &defects) };
    check.certificate = Certificate::of(&check, found, expected).with(angles);
    Ok(check)
}

/// Adds a mesh's groups to the summaries of its faces.
pub(super) fn add_groups(groups: &mut Vec<GroupSummary>, mesh: &TriMesh) {
    for g in &mesh.groups {
        let of = || g.faces.iter().filter_map(|i| groups.get(*i as usize));
        // The sum of no numbers is -0.
        let (triangles, area) = (of().map(|g| g.triangles).sum(), of().fold(0.0, |area, g| area + g.area));
        groups.push(GroupSummary { name: g.name.clone(), triangles, area });
    }
}

/// Triangles that intersect others; where bodies may touch only those of one body, and how many more intersect other bodies'.
fn crossings(mesh: &TriMesh, expected: Expectation, run: &Run) -> Result<(Spots, usize)> {
    run.progress("intersections", 0.0);
    let distinct = |pairs: &[[u32; 2]]| {
        let mut hit: Vec<u32> = pairs.as_flattened().to_vec();
        hit.sort_unstable();
        hit.dedup();
        hit
    };
    let mut pairs = self_intersections(mesh, run)?;
    let mut known = distinct(&pairs);
    let all = known.len();
    if expected.touching && all > 0 {
        let body = mesh.bodies();
        pairs.retain(|[t, u]| body[*t as usize] == body[*u as usize]);
        known = distinct(&pairs);
    }
    Ok((Spots::new(known.len(), known.iter().map(|t| mesh.centroid(*t as usize))), all - known.len()))
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let yes = |b: bool| if b { "yes" } else { "NO" };
        let q = &self.quality;
        writeln!(f, "{} nodes, {} triangles, {} component(s)", self.nodes, self.triangles, self.components)?;
        writeln!(
            f,
            "closed {}, manifold {}, oriented {}, {} self-intersecting triangles",
            yes(self.closed),
            yes(self.manifold),
            yes(self.oriented),
            self.self_intersections
        )?;
        write!(f, "Euler characteristic {}", self.euler)?;
        if let Some(g) = self.genus {
            write!(f, ", genus {g}")?;
        }
        write!(f, ", area {:.8}", self.area)?;
        if let Some(volume) = self.volume {
            write!(f, ", volume {volume:.8}")?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "angles: smallest {:.3}, 5th percentile {:.2}, largest {:.2}; mean 2r/R {:.4}; below 20 degrees {:.3} %",
            q.min_angle,
            q.p05_angle,
            q.max_angle,
            q.mean_radius_ratio,
            100.0 * q.below_20
        )?;
        if let Some(d) = &self.deviation {
            write!(f, "distance: largest {:.3e}, rms {:.3e}", d.max, d.rms)?;
            if let Some(back) = d.from_surface {
                write!(f, ", from the surface {back:.3e}")?;
            }
            writeln!(f, "; normal deviation {:.3e}", d.normal)?;
            if d.unprojected + d.inverted > 0 {
                writeln!(f, "  {} samples far from the surface, {} inverted triangles", d.unprojected, d.inverted)?;
            }
        }
        if let Some(t) = self.features.as_ref().filter(|t| !t.known) {
            writeln!(f, "sharp edges: the true ones are not known, mesh {:.4}", t.length_mesh)?;
        } else if let Some(t) = &self.features {
            writeln!(
                f,
                "sharp edges: true length {:.4}, mesh {:.4}; recall {:.3}, precision {:.3}; corners {} of {}",
                t.length_true, t.length_mesh, t.recall, t.precision, t.corners_found, t.corners_true
            )?;
        }
        let c = &self.certificate;
        writeln!(f, "certificate: {c}; {} angles below 30 degrees, {} of them the part's own", c.below_30, c.excused)?;
        let width = self.groups.iter().map(|g| g.name.chars().count()).max().unwrap_or(0);
        for (i, g) in self.groups.iter().enumerate() {
            let end = if i + 1 < self.groups.len() { "\n" } else { "" };
            write!(f, "  {:<width$} {:>8} triangles, area {:.6}{end}", g.name, g.triangles, g.area)?;
        }
        Ok(())
    }
}
