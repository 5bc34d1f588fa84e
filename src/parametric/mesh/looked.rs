//! What was seen of a model when it was meshed: meshing it again with other sizes looks at less of it.

use rayon::prelude::*;

use super::edges::{Sampled, sample};
use super::sizes::NarrowPlaces;
use super::{MeshSizes, Parametric};
use crate::error::Result;
use crate::parametric::chart::Chart;
use crate::run::Run;

/// What was seen of a model the last time, see [`Parametric::mesh_again`]: of one model only. Meshes do not depend on it.
#[derive(Default)]
pub struct Looked {
    pub(super) sampled: Vec<Sampled>,
    pub(super) narrow: NarrowPlaces,
}

impl Looked {
    /// Looks along all edges; tells of each whether it did so at the same places before.
    pub(super) fn at_edges(&mut self, model: &Parametric, sizes: &MeshSizes<'_>, run: &Run) -> Result<Vec<bool>> {
        let edges = &model.brep.edges;
        let mut known: Vec<Option<Sampled>> = std::mem::take(&mut self.sampled).into_iter().map(Some).collect();
        known.resize_with(edges.len(), || None);
        let of = |(i, known): (usize, Option<Sampled>)| {
            let faces = model.faces_of[i].iter();
            let charts: Vec<(u32, &Chart)> = faces.map(|f| (*f, &model.charts[*f as usize])).collect();
            sample(&edges[i], &charts, sizes, known)
        };
        let made: Vec<(Sampled, bool)> = run.install(|| known.into_par_iter().enumerate().map(of).collect());
        let same;
        (self.sampled, same) = made.into_iter().unzip();
        run.check()?;
        Ok(same)
    }
}
