//! Triangles of a patchwork that stay as they are.

use glam::DVec3;

use super::patchwork::Patchwork;
use crate::mesh::edit::NONE;
use crate::spatial::{Aabb, Bvh};

impl Patchwork {
    /// [Freezes](Self::freeze) the triangles that meet some boxes. In the end they thaw, as far as no triangle crosses another then.
    pub fn freeze_near(&mut self, places: &[Aabb], least: f64) {
        let near = Bvh::new(places.to_vec());
        let stays = |t: &u32| near.meets(&Aabb::around(self.mesh.corner_points(*t)));
        let kept: Vec<u32> = self.mesh.triangles().filter(stays).collect();
        if !kept.is_empty() {
            self.freeze(&kept, least);
            self.thaws = true;
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
