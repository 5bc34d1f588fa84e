//! What is asked of a patchwork around places: triangles that stay as they are, and shorter edges.

use glam::DVec3;

use super::patchwork::Patchwork;
use crate::mesh::edit::NONE;
use crate::spatial::{Aabb, Bvh};

impl Patchwork {
    /// Halves what nodes of triangles that meet some boxes want, down to `least`: each node once, however many of its triangles do. Those
    /// without a bound want `size`. Whether any wants less than before.
    pub fn halve_near(&mut self, places: &[Aabb], size: f64, least: f64) -> bool {
        let mut near: Vec<u32> = self.meeting(places).into_iter().flat_map(|t| self.mesh.corners(t)).collect();
        near.sort_unstable();
        near.dedup();
        let mut any = false;
        for v in near {
            let Some(wanted) = self.sizes.get_mut(v as usize) else { continue };
            let now = wanted.min(size);
            let half = (0.5 * now).max(least);
            any |= half < now;
            *wanted = half;
        }
        any
    }

    /// The triangles that meet some boxes.
    fn meeting(&self, places: &[Aabb]) -> Vec<u32> {
        let near = Bvh::new(places.to_vec());
        let meets = |t: &u32| near.meets(&Aabb::around(self.mesh.corner_points(*t)));
        self.mesh.triangles().filter(meets).collect()
    }

    /// [Freezes](Self::freeze) the triangles that meet some boxes. In the end they thaw, as far as no triangle crosses another then.
    pub fn freeze_near(&mut self, places: &[Aabb], least: f64) {
        let kept = self.meeting(places);
        if !kept.is_empty() {
            self.freeze(&kept, least);
            self.policy.thaws = true;
        }
    }

    /// Makes patches of their own of triangles that stay as they are. Edges beside these are as long as theirs, but not shorter than
    /// `least`.
    pub fn freeze(&mut self, triangles: &[u32], least: f64) {
        let mesh = &mut self.mesh;
        if self.sizes.is_empty() {
            self.sizes = vec![f64::INFINITY; mesh.node_capacity()];
        }
        let mut patches = self.patches.to_vec();
        let mut frozen_as = vec![NONE; patches.len()];
        for &t in triangles {
            let patch = mesh.label(t) as usize;
            if frozen_as[patch] == NONE {
                frozen_as[patch] = patches.len() as u32;
                patches.push(patches[patch]);
                self.thawed.push(patch as u32);
            }
            let normal = mesh.area_vector(t).normalize_or_zero();
            mesh.set_surface(t, frozen_as[patch], normal);
            // Sizes grow from what stays.
            for h in 3 * t..3 * t + 3 {
                for v in [mesh.origin(h), mesh.target(h)] {
                    let size = &mut self.sizes[v as usize];
                    *size = size.min(mesh.edge_length(h).max(least));
                }
            }
        }
        let is_border = |h: u32| mesh.opposite(h) != NONE && mesh.label(h / 3) != mesh.label(mesh.opposite(h) / 3);
        let borders: Vec<u32> = mesh.edges().filter(|h| is_border(*h)).collect();
        borders.into_iter().for_each(|h| mesh.set_sharp(h, true));
        self.frozen.extend(frozen_as.into_iter().filter(|f| *f != NONE));
        self.frozen.sort_unstable();
        self.patches = patches.into();
    }

    /// Whether a triangle stays as it is for now.
    pub(super) fn is_frozen(&self, t: u32) -> bool {
        self.frozen_as(t).is_some()
    }

    /// Which of the frozen patches a triangle is on.
    fn frozen_as(&self, t: u32) -> Option<usize> {
        self.frozen.binary_search(&self.mesh.label(t)).ok()
    }

    /// Gives frozen triangles back to the patches they were of.
    pub(super) fn unfreeze(&mut self) {
        let frozen: Vec<(u32, usize)> = self.mesh.triangles().filter_map(|t| Some((t, self.frozen_as(t)?))).collect();
        for (t, k) in frozen {
            self.mesh.set_surface(t, self.thawed[k], DVec3::ZERO);
        }
        self.thawed.clear();
        self.frozen.clear();
        self.mesh.set_all_changed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{EditMesh, TriMesh};
    use crate::remesh::patchwork::{PiecePatch, PieceSet};

    /// Squares of side 1 in two triangles each, nine along each side.
    fn field() -> Patchwork {
        let at = |i: u32, j: u32| i + 10 * j;
        let nodes: Vec<DVec3> = (0..100).map(|k| DVec3::new(f64::from(k % 10), f64::from(k / 10), 0.0)).collect();
        let squares = (0..81).map(|k| (k % 9, k / 9));
        let halves = |(i, j): (u32, u32)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles: Vec<[u32; 3]> = squares.flat_map(halves).collect();
        let labels = vec![0; triangles.len()];
        let mesh = TriMesh { nodes, triangles, labels, faces: vec!["floor".into()], ..TriMesh::default() };
        let patch = PiecePatch { piece: 0, outward: 1.0, plane: None, face: 0 };
        let mut work = Patchwork::new(EditMesh::new(&mesh).unwrap(), vec![PieceSet::one(0); 100], vec![patch].into());
        work.sizes = vec![f64::INFINITY; 100];
        work
    }

    #[test]
    fn each_node_near_a_place_wants_half_of_what_it_did() {
        let mut work = field();
        // The boxes of the triangles in four squares meet it, and those of no other.
        let place = [Aabb::around([DVec3::new(3.9, 3.9, -0.1), DVec3::new(4.1, 4.1, 0.1)])];
        let wanting = |work: &Patchwork, size: f64| work.sizes.iter().filter(|s| **s == size).count();
        assert!(work.halve_near(&place, 1.0, 0.25));
        assert_eq!((wanting(&work, 0.5), wanting(&work, f64::INFINITY)), (9, 91));
        assert!(work.halve_near(&place, 1.0, 0.25));
        assert_eq!(wanting(&work, 0.25), 9);
        assert!(!work.halve_near(&place, 1.0, 0.25));
        work.freeze_near(&place, 0.1);
        let frozen = |t: &u32| work.is_kept(*t);
        assert_eq!((work.mesh.triangles().filter(frozen).count(), work.policy.thaws), (8, true));
    }
}
