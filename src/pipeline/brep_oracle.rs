//! The true surface of a boundary representation inside its borders: which face is nearest is asked of a fine mesh, where on
//! it of its surface.

use glam::DVec3;

use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::parametric::mesh::MeshSizes;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Edges of the fine mesh, as a share of the model.
const FINE: f64 = 0.02;

/// A model with a mesh to find faces by.
pub(super) struct FaceFinder<'a> {
    solid: &'a Parametric,
    mesh: TriMesh,
    bvh: Bvh,
}

/// A mesh that tells which face of a model is near: closed where the model is, with edges that turn by a fifth.
pub(super) fn fine_mesh(solid: &Parametric, run: &Run) -> Result<TriMesh> {
    let size = FINE * solid.bounds().diagonal();
    let by = move |k: f64| (0.2 / k.max(1e-300)).clamp(0.1 * size, size);
    let mut mesh = solid.mesh(&MeshSizes::new(size, 0.1 * size, &by), run)?.mesh;
    mesh.drop_unused_nodes();
    Ok(mesh)
}

impl<'a> FaceFinder<'a> {
    pub(super) fn new(solid: &'a Parametric, run: &Run) -> Result<Self> {
        let mesh = fine_mesh(solid, run)?;
        let corners = |t: &[u32; 3]| t.map(|v| mesh.nodes[v as usize]);
        let bvh = Bvh::new(mesh.triangles.iter().map(|t| Aabb::around(corners(t))).collect());
        Ok(Self { solid, mesh, bvh })
    }

    /// Points of the true surface.
    pub(super) fn points(&self) -> &[DVec3] {
        &self.mesh.nodes
    }

    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.mesh.triangles[t as usize].map(|v| self.mesh.nodes[v as usize])
    }
}

impl SurfaceOracle for FaceFinder<'_> {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let (t, d) = self.bvh.nearest(p, f64::INFINITY, |t| triangle_distance_squared(p, self.corners(t)))?;
        let face = self.mesh.labels[t as usize];
        let point = self.solid.foot(face, p)?;
        let slack = self.corners(t).iter().map(|q| q.distance(p)).fold(0.0, f64::max);
        // The foot must be near the triangle that led to it: the surface goes on beyond the face.
        let near = triangle_distance_squared(point, self.corners(t)).sqrt() <= d.sqrt().max(0.5 * slack);
        (near && point.distance(p) <= reach)
            .then(|| self.solid.outward_normal(face, point).map(|normal| Foot { point, normal, face }))
            .flatten()
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        self.solid.curvatures(foot)
    }
}
