//! A solid given by its boundary as a function: the distance to the boundary, positive inside.
//!
//! The nearest of the boundary's triangles tells the side: by its own normal, at edges and corners by that of all triangles around,
//! weighted by their angles (J. A. Bærentzen and H. Aanæs 2005), which is right for every closed surface that does not cross itself.
//! Faces of CAD models are asked themselves where on them a point is nearest.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::brep_oracle::fine_mesh;
use super::operand::{Loaded, sound};
use crate::error::Result;
use crate::geometry::Pieces;
use crate::implicit::{Between, Field};
use crate::mesh::TriMesh;
use crate::parametric::Parametric;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared, triangle_foot};

/// See the head of the file.
pub(super) struct BoundaryDistance {
    /// The faces behind the triangles, where these only stand for them.
    faces: Option<Box<Parametric>>,
    mesh: TriMesh,
    bvh: Bvh,
    at_nodes: Vec<Neighbors>,
    at_edges: FxHashMap<[u32; 2], Neighbors>,
    /// How far the triangles may be from the surface.
    away: f64,
}

/// The triangles around an edge or a node.
#[derive(Clone, Copy, Default)]
struct Neighbors {
    /// The sum of their normals, weighted by their angles.
    normal: DVec3,
    /// Their faces, the first two of them,
    faces: [u32; 2],
    /// and how many these are.
    count: u8,
}

impl Neighbors {
    fn add(&mut self, normal: DVec3, face: u32) {
        self.normal += normal;
        let known = usize::from(self.count.min(2));
        if !self.faces[..known].contains(&face) {
            if known < 2 {
                self.faces[known] = face;
            }
            self.count = self.count.saturating_add(1);
        }
    }
}

/// The point of the triangles nearest to another.
struct OnTriangles {
    point: DVec3,
    around: Neighbors,
    face: u32,
}

/// The point of the boundary nearest to another.
struct OnBoundary {
    point: DVec3,
    /// A vector that points outwards there.
    outward: DVec3,
    face: u32,
}

impl BoundaryDistance {
    /// Errors: a model whose mesh is not closed or crosses itself; cancellation.
    pub(super) fn new(loaded: Loaded, run: &Run) -> Result<Self> {
        let (faces, mesh) = match loaded {
            Loaded::Triangles(mesh) => (None, mesh),
            Loaded::Faces(solid) => {
                let mesh = fine_mesh(&solid, run)?;
                sound(&mesh, run)?;
                (Some(solid), mesh)
            }
        };
        let mut at_nodes = vec![Neighbors::default(); mesh.nodes.len()];
        let mut at_edges: FxHashMap<[u32; 2], Neighbors> = FxHashMap::default();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let (normal, face) = (mesh.area_vector(t).normalize_or_zero(), mesh.labels[t]);
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                let [p, q, r] = [a, b, c].map(|v| mesh.nodes[v as usize]);
                at_nodes[a as usize].add(normal * (q - p).angle_between(r - p), face);
                at_edges.entry([a.min(b), a.max(b)]).or_default().add(normal, face);
            }
        }
        let corners = |t: &[u32; 3]| t.map(|v| mesh.nodes[v as usize]);
        let bvh = Bvh::new(mesh.triangles.iter().map(|t| Aabb::around(corners(t))).collect());
        let mut made = Self { faces, mesh, bvh, at_nodes, at_edges, away: 0.0 };
        made.away = 2.0 * made.bulge();
        Ok(made)
    }

    /// How far the faces are from their triangles, at the middles of these.
    fn bulge(&self) -> f64 {
        let Some(solid) = &self.faces else { return 0.0 };
        let of = |t: usize| {
            let middle = self.corners(t).into_iter().sum::<DVec3>() / 3.0;
            solid.foot(self.mesh.labels[t], middle).map_or(0.0, |foot| foot.distance(middle))
        };
        (0..self.mesh.triangles.len()).map(of).fold(f64::EPSILON * self.mesh.bounds().diagonal(), f64::max)
    }

    fn corners(&self, t: usize) -> [DVec3; 3] {
        self.mesh.triangles[t].map(|v| self.mesh.nodes[v as usize])
    }

    /// The nearest point of the triangles, with what is around it. `None` for points that are no numbers.
    fn on_triangles(&self, p: DVec3) -> Option<OnTriangles> {
        let (t, _) = self.bvh.nearest(p, f64::INFINITY, |t| triangle_distance_squared(p, self.corners(t as usize)))?;
        let (t, face) = (t as usize, self.mesh.labels[t as usize]);
        let (corners, weights) = (self.mesh.triangles[t], triangle_foot(p, self.corners(t)));
        let point = self.corners(t).iter().zip(weights).map(|(c, w)| *c * w).sum();
        let on: Vec<u32> = (0..3).filter(|k| weights[*k] > 0.0).map(|k| corners[k]).collect();
        let alone = Neighbors { normal: self.mesh.area_vector(t), faces: [face; 2], count: 1 };
        let around = match on[..] {
            [a] => self.at_nodes[a as usize],
            [a, b] => self.at_edges.get(&[a.min(b), a.max(b)]).copied().unwrap_or(alone),
            _ => alone,
        };
        Some(OnTriangles { point, around, face })
    }

    /// The nearest point of the boundary. `None` for points that are no numbers.
    fn nearest(&self, p: DVec3) -> Option<OnBoundary> {
        let near = self.on_triangles(p)?;
        let behind = self.faces.as_ref().and_then(|solid| self.on_faces(solid, p, &near));
        Some(behind.unwrap_or(OnBoundary { point: near.point, outward: near.around.normal, face: near.face }))
    }

    /// The nearest point of the face behind a triangle, or of the edge between two; corners are nodes, which are in their place.
    fn on_faces(&self, solid: &Parametric, p: DVec3, near: &OnTriangles) -> Option<OnBoundary> {
        let at = |point: DVec3, [a, b]: [u32; 2]| {
            let outward = solid.outward_normal(a, point)? + solid.outward_normal(b, point)?;
            Some(OnBoundary { point, outward, face: near.face })
        };
        let on_edge = |around: &Neighbors| at(solid.meet(&around.faces, p, f64::INFINITY)?, around.faces);
        match near.around.count {
            1 => {
                // The surface goes on beyond the face: a foot must be where the face's triangles are, else its border is nearest.
                let foot = solid.foot(near.face, p)?;
                let under = self.on_triangles(foot)?;
                match under.around.count {
                    1 if under.point.distance(foot) <= self.away => at(foot, [near.face; 2]),
                    2 => on_edge(&under.around),
                    _ => None,
                }
            }
            2 => on_edge(&near.around),
            _ => None,
        }
    }
}

impl Field for BoundaryDistance {
    fn value(&self, p: DVec3) -> f64 {
        let Some(near) = self.nearest(p) else { return f64::NAN };
        let away = p - near.point;
        if away.dot(near.outward) > 0.0 { -away.length() } else { away.length() }
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let near = self.nearest(p)?;
        let away = p - near.point;
        let outside = away.dot(near.outward) > 0.0;
        let inwards = away.try_normalize().map(|d| if outside { -d } else { d });
        Some(inwards.unwrap_or(-near.outward.normalize_or_zero()))
    }

    fn range(&self, cell: &Aabb) -> Between {
        let (middle, reach) = (self.value(cell.center()), 0.5 * cell.diagonal() + 2.0 * self.away);
        (middle - reach, middle + reach)
    }

    fn ranges(&self, cells: &[Aabb], out: &mut [Between]) {
        out.iter_mut().zip(cells).for_each(|(r, cell)| *r = self.range(cell));
    }

    fn faces(&self) -> Vec<String> {
        self.mesh.faces.clone()
    }

    fn face_at(&self, p: DVec3) -> u32 {
        self.nearest(p).map_or(0, |n| n.face)
    }
}
