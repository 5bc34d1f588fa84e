//! Patches of one piece that have come together: what lay between them was too narrow for a row of triangles and is gone.

use glam::DVec3;

use super::patchwork::PieceSet;
use super::remesher::Remesher;
use crate::mesh::edit::NONE;

impl Remesher<'_> {
    /// Makes one patch of neighbors on the same side of one piece; their border is none.
    pub(super) fn join_alike(&mut self) {
        // Lines within a piece are borders of another kind.
        if self.work.lines_from != u32::MAX {
            return;
        }
        let m = &self.work.mesh;
        let patches = &self.work.patches;
        let mut first: Vec<u32> = (0..patches.len() as u32).collect();
        let root = |first: &[u32], mut l: u32| {
            while first[l as usize] != l {
                l = first[l as usize];
            }
            l
        };
        let mut borders = Vec::new();
        for h in 0..3 * m.triangle_capacity() as u32 {
            let o = m.opposite(h);
            if o == NONE || !m.is_triangle(h / 3) || !m.is_sharp(h) {
                continue;
            }
            let labels = [h, o].map(|x| m.label(x / 3));
            let [a, b] = labels.map(|l| patches[l as usize]);
            let alike = labels[0] != labels[1] && (a.piece, a.outward, a.face) == (b.piece, b.outward, b.face);
            if alike && a.piece != NONE && !labels.into_iter().any(|l| self.work.stays(l)) {
                let [x, y] = labels.map(|l| root(&first, l));
                first[x.max(y) as usize] = x.min(y);
                borders.push(h);
            }
        }
        if borders.is_empty() {
            return;
        }
        let triangles: Vec<u32> = m.triangles().collect();
        for t in triangles {
            let l = root(&first, self.work.mesh.label(t));
            self.work.mesh.set_surface(t, l, DVec3::ZERO);
        }
        let mut nodes: Vec<u32> =
            borders.iter().flat_map(|&h| [self.work.mesh.origin(h), self.work.mesh.target(h)]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        for &v in &nodes {
            let m = &self.work.mesh;
            if !m.is_pinned(v) {
                let mut around: Vec<u32> =
                    m.outgoing(v).map(|h| self.work.patches[m.label(h / 3) as usize].piece).collect();
                around.sort_unstable();
                around.dedup();
                self.work.sets[v as usize] = PieceSet::of(&around);
            }
            self.mark_around(v);
        }
        self.work.mesh.set_all_changed();
    }
}
