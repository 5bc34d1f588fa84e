//! What the leaf method gives with one size of cells, and how good that is.

use glam::DVec3;

use super::cells::{CHEAP, LOST, MOST_HEALED, MOST_UNPROVED_OF_MANY, Scout, Start};
use super::history::{Attempt, Tried};
use super::ladder::Attempts;
use super::mesh::Ready;
use super::missed::far;
use crate::implicit::SurfacePoint;
use crate::quality::Fault;
use crate::remesh::{RemeshReport, RemeshedMesh};
use crate::run::Run;
use crate::spatial::Aabb;

/// What has no faults ends the search if at most one of so many cells is not proved: what it lacks smaller cells lack, too.
const MOST_UNPROVED: usize = 10;

/// What one size of cells gave.
pub(super) struct Trial {
    pub(super) exact: RemeshedMesh,
    /// Points of the surface that the mesh does not come near to.
    pub(super) missed: Vec<SurfacePoint>,
    /// Points of faces that it comes near to with other faces only.
    pub(super) flat: Vec<SurfacePoint>,
    pub(super) scout: Scout,
    /// The cells it is of.
    pub(super) start: Start,
    /// Boxes around what is at fault, with the lengths of edges there.
    pub(super) crossed: Vec<(Aabb, f64)>,
    /// Its number among the attempts.
    pub(super) number: usize,
    /// Nodes that were drawn back where the solid touches itself.
    pub(super) drawn: usize,
}

impl Trial {
    pub(super) fn badness(&self) -> (usize, bool, usize) {
        let lacking = self.exact.report.astray.len() + self.flat.len();
        (self.faults(), !self.missed.is_empty(), lacking)
    }

    /// Adds itself to the attempts.
    pub(super) fn told(mut self, attempts: &mut Attempts, run: &Run) -> Self {
        let lacks = [
            (!self.missed.is_empty(), "some of the surface is not in the mesh"),
            (!self.flat.is_empty(), "a face is passed over"),
            (!self.exact.report.astray.is_empty(), "borders go astray"),
            (self.lost().is_some(), "something is thinner than the cells"),
        ];
        let lacks: Vec<&str> = lacks.iter().filter(|l| l.0).map(|l| l.1).collect();
        let attempt = Attempt::new(Tried::Arrange, self.scout.cell, self.exact.mesh.triangles.len(), self.faults());
        let attempt = Attempt { proof: self.scout.proof.clone(), ..attempt };
        self.number = attempts.add(attempt.lacking(lacks.join("; ")), run);
        self
    }

    fn is_clean(&self) -> bool {
        self.badness() == (0, false, 0) && self.lost().is_none()
    }

    /// Whether no other attempt is worth it: nothing is wrong, or all was found, so that smaller cells find no more, and what is at
    /// fault can be healed.
    pub(super) fn ends(&self) -> bool {
        let is_kept = self.start.keeps() && self.faults() == 0 && self.missed.is_empty();
        let found = self.scout.proof.as_ref().is_some_and(|proof| {
            let triangles = self.exact.mesh.triangles.len();
            let few = self.faults() == 0 || (self.can_be_healed() && triangles > CHEAP);
            let most = if triangles > CHEAP { MOST_UNPROVED_OF_MANY } else { MOST_UNPROVED };
            few && most * proof.unproved <= proof.cells
        });
        found || is_kept || self.is_clean()
    }

    /// Whether it is sound, or with few faults. Where most triangles cross, walls are thinner than the bends of
    /// their edges: healing would tear them.
    pub(super) fn can_be_healed(&self) -> bool {
        MOST_HEALED * self.faults() <= self.exact.mesh.triangles.len()
    }

    /// Triangles that intersect others or are turned over. What stayed as it came and was put right has none that were turned over on
    /// the way: what is left faces as the arrangement does.
    pub(super) fn faults(&self) -> usize {
        let RemeshReport { self_intersections, inverted, .. } = self.exact.report;
        self_intersections + if !self.start.keeps() { inverted } else { 0 }
    }

    /// A splinter that the finished mesh does not come near to, if there is one.
    fn lost(&self) -> Option<DVec3> {
        far(&self.exact.mesh, &self.scout.splinters, |p| *p, LOST * self.scout.cell).first().copied()
    }

    /// What the mesh lacks, for the report.
    pub(super) fn shortfalls(&self, ready: &Ready) -> Vec<Fault> {
        let face =
            |x: &SurfacePoint| ready.model.faces().get(x.face as usize).map_or_else(String::new, |f| f.name.clone());
        let mut list: Vec<Fault> = Vec::new();
        list.extend(self.missed.first().map(|x| Fault::SurfaceMissing {
            face: face(x),
            at: x.at.to_array(),
            more: self.missed.len() - 1,
        }));
        list.extend(self.flat.first().map(|x| Fault::FaceMissing { face: face(x), at: x.at.to_array() }));
        list.extend(self.lost().map(|p| Fault::Thin { at: p.to_array() }));
        list
    }
}
