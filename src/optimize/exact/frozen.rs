//! Triangles of a patchwork that stay as they are.

use glam::DVec3;

use super::patchwork::Patchwork;
use crate::mesh::edit::NONE;

impl Patchwork {
    /// Makes patches of their own of triangles that stay as they are. Edges beside these are as long as theirs, but not shorter than
    /// `least`.
    pub fn freeze(&mut self, triangles: &[u32], least: f64) {
        let mesh = &mut self.mesh;
        if self.sizes.is_empty() {
            self.sizes = vec![f64::INFINITY; mesh.node_capacity()];
        }
        let mut patches = self.patches.to_vec();
        let first = patches.len() as u32;
        let mut frozen_as = vec![NONE; patches.len()];
        for &t in triangles {
            let patch = mesh.label(t) as usize;
            if frozen_as[patch] == NONE {
                frozen_as[patch] = patches.len() as u32;
                patches.push(patches[patch]);
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
        self.frozen.extend(first..patches.len() as u32);
        self.patches = patches.into();
        self.thawed = frozen_as;
    }

    /// Whether a triangle stays as it is for now.
    pub(super) fn is_frozen(&self, t: u32) -> bool {
        self.frozen.binary_search(&self.mesh.label(t)).is_ok()
    }

    /// Gives frozen triangles back to the patches they were of.
    pub(super) fn unfreeze(&mut self) {
        let mut of = vec![NONE; self.patches.len()];
        self.thawed.iter().enumerate().filter(|x| *x.1 != NONE).for_each(|(k, f)| of[*f as usize] = k as u32);
        let frozen: Vec<u32> = self.mesh.triangles().filter(|t| self.is_frozen(*t)).collect();
        for t in frozen {
            let patch = of[self.mesh.label(t) as usize];
            if patch != NONE {
                self.mesh.set_surface(t, patch, DVec3::ZERO);
            }
        }
        self.frozen.clear();
        self.mesh.set_all_changed();
    }
}
