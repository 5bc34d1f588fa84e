//! What is done where triangles of an arrangement cross, beyond moving nodes one by one.

use glam::DVec3;

use super::assemble::Triangle;
use super::guises::{Guises, Seeds};
use super::islands::drop_islands;
use super::settle::Nodes;
use crate::error::Result;
use crate::mesh::{TriMesh, self_intersections};
use crate::run::Run;
use crate::spatial::Aabb;

/// A boundary whose nodes are put in place.
#[derive(Clone)]
pub(super) struct Boundary {
    pub(super) places: Vec<DVec3>,
    /// The leaves each node lies on.
    pub(super) on: Vec<Vec<u32>>,
    pub(super) triangles: Vec<Triangle>,
    /// Nodes whose leaves do not vanish nearby.
    pub(super) astray: Vec<u32>,
    /// Where triangles cross, as far as it was [looked for](Self::find_crossings), with the lengths of edges there.
    pub(super) crossed: Vec<(Aabb, f64)>,
}

impl Boundary {
    /// Drops [islands](drop_islands). Whether there were any.
    pub(super) fn drop_islands(&mut self) -> bool {
        drop_islands(&self.places, &self.on, &mut self.triangles)
    }

    /// Looks for pairs of triangles that cross.
    ///
    /// Errors: cancellation.
    pub(super) fn find_crossings(&mut self, run: &Run) -> Result<()> {
        let triangles = self.triangles.iter().map(|t| t.nodes).collect();
        let mesh = TriMesh { nodes: std::mem::take(&mut self.places), triangles, ..TriMesh::default() };
        let pairs = self_intersections(&mesh, run)?;
        self.crossed = pairs.into_iter().map(|pair| mesh.meeting(pair)).collect();
        self.places = mesh.nodes;
        Ok(())
    }
}

impl Guises<'_> {
    /// A boundary of which fewer pairs of triangles cross: without patches that are hidden where surfaces touch, with nodes in
    /// order along curves, and those moved together that were stuck one by one. None where that is none better.
    ///
    /// Errors: cancellation.
    pub(super) fn uncrossed(&self, of: &Boundary, run: &Run) -> Result<Option<Boundary>> {
        let mut made = of.clone();
        self.lift(&mut made, Seeds::Turned);
        let places = std::mem::take(&mut made.places);
        let (reach, leaves, scale) = (self.reach, self.leaves, self.scale);
        let mut nodes = Nodes { places, on: &made.on, reach, leaves, scale, stay: &[], common: None };
        nodes.straighten(self.linear, &made.triangles, run)?;
        nodes.untangle_together(&made.triangles, run)?;
        made.places = nodes.places;
        made.find_crossings(run)?;
        Ok((made.crossed.len() < of.crossed.len()).then_some(made))
    }
}
