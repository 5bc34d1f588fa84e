//! Work on each patch alone, in parallel, its border fixed.

use rayon::prelude::*;

use super::patchwork::{Patchwork, PieceSet};
use super::remesh::{Rank, Remesher};
use crate::error::Result;
use crate::mesh::edit::{ByLabel, NONE};
use crate::mesh::{EditMesh, TriMesh};

/// A patch after the work.
struct Done {
    mesh: EditMesh,
    /// The node of the whole mesh, for those that were there before.
    nodes: Vec<u32>,
    sets: Vec<PieceSet>,
    own: Vec<f64>,
    want: Vec<f64>,
}

impl Remesher<'_> {
    /// Does `work` on every patch as a mesh of its own, whose boundary must stay as it is, and joins the results. The
    /// result does not depend on the number of threads.
    pub(super) fn each_patch(&mut self, work: impl Fn(&mut Remesher<'_>) -> Result<()> + Sync) -> Result<()> {
        let sorted = ByLabel::new(&self.work.mesh, self.work.patches.len());
        let this = &*self;
        let one = |label: u32| {
            let mut alone = this.alone(label, &sorted);
            work(&mut alone.0)?;
            let (r, nodes) = alone;
            Ok(Done { mesh: r.work.mesh, nodes, sets: r.work.sets, own: r.own, want: r.want })
        };
        let count = self.work.patches.len() as u32;
        let done: Vec<Result<Done>> = self.run.install(|| (0..count).into_par_iter().map(one).collect());
        let done: Vec<Done> = done.into_iter().collect::<Result<_>>()?;
        self.join(&done)
    }

    fn alone(&self, label: u32, sorted: &ByLabel) -> (Remesher<'_>, Vec<u32>) {
        let part = self.work.mesh.part(label, sorted);
        let pick = |list: &[f64]| part.nodes.iter().map(|&v| list[v as usize]).collect();
        let rank = (0..part.nodes.len() as u32)
            .map(|v| if part.mesh.is_boundary(v) || part.mesh.is_pinned(v) { Rank::Corner } else { Rank::Face })
            .collect();
        let r = Remesher {
            surface: self.surface,
            own: pick(&self.own),
            want: pick(&self.want),
            rank,
            options: self.options,
            run: self.run,
            work: Patchwork {
                mesh: part.mesh,
                sets: part.nodes.iter().map(|&v| self.work.sets[v as usize]).collect(),
                patches: self.work.patches.clone(),
            },
        };
        (r, part.nodes)
    }

    fn join(&mut self, parts: &[Done]) -> Result<()> {
        let mut whole = TriMesh::default();
        let (mut sets, mut own, mut want, mut pinned) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut shared = vec![NONE; self.work.mesh.node_capacity()];
        let mut number = Vec::new();
        for part in parts {
            number.clear();
            number.resize(part.mesh.node_capacity(), NONE);
            for v in part.mesh.nodes() {
                let border = part.mesh.is_boundary(v);
                let known = if border { shared[part.nodes[v as usize] as usize] } else { NONE };
                if known != NONE {
                    number[v as usize] = known;
                    continue;
                }
                let id = whole.nodes.len() as u32;
                number[v as usize] = id;
                if border {
                    shared[part.nodes[v as usize] as usize] = id;
                }
                whole.nodes.push(part.mesh.point(v));
                sets.push(part.sets[v as usize]);
                own.push(part.own[v as usize]);
                want.push(part.want[v as usize]);
                pinned.push(part.mesh.is_pinned(v));
            }
            for t in part.mesh.triangles() {
                whole.triangles.push(part.mesh.corners(t).map(|v| number[v as usize]));
                whole.labels.push(part.mesh.label(t));
            }
        }
        let mut mesh = EditMesh::new(&whole)?;
        for h in 0..3 * mesh.triangle_capacity() as u32 {
            let o = mesh.opposite(h);
            if o != NONE && mesh.label(h / 3) != mesh.label(o / 3) {
                mesh.set_sharp(h, true);
            }
        }
        (0..pinned.len()).filter(|&v| pinned[v]).for_each(|v| mesh.set_pinned(v as u32, true));
        self.work = Patchwork { mesh, sets, patches: self.work.patches.clone() };
        (self.own, self.want) = (own, want);
        self.rank = (0..self.want.len() as u32).map(|v| self.rank_of(v)).collect();
        Ok(())
    }
}
