//! Sharp edges and corners of a mesh, for formats that list them.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::error::Result;
use crate::mesh::MeshView;
use crate::run::Run;

use super::WriteOptions;
use super::build::{each_cell, fan};
use super::layout::Layout;

/// Degrees between the normals beside an edge from which it is sharp: where faces run into each other smoothly triangles
/// of usual size turn by less.
const SHARP: f64 = 25.0;
/// Degrees by which a chain of sharp edges turns at a corner.
const TURN: f64 = 45.0;

/// Edges along curves, and what is sharp among them.
pub(super) struct SharpEdges {
    /// Edges, one curve after the other.
    pub(super) edges: Vec<[u32; 2]>,
    /// For each edge its curve.
    pub(super) curves: Vec<u32>,
    /// Indices of sharp ones.
    pub(super) ridges: Vec<u32>,
    /// Nodes, ascending.
    pub(super) corners: Vec<u32>,
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl SharpEdges {
    pub(super) fn new(mesh: &dyn MeshView, layout: &Layout, options: &WriteOptions, run: &Run) -> Result<Self> {
        let mut out = Self { edges: Vec::new(), curves: Vec::new(), ridges: Vec::new(), corners: Vec::new() };
        for (c, curve) in (0u32..).zip(&layout.curves) {
            out.edges.extend(curve.nodes.windows(2).map(|p| [p[0], p[1]]));
            out.curves.resize(out.edges.len(), c);
        }
        let mut normals: FxHashMap<[u32; 2], Vec<DVec3>> = FxHashMap::default();
        normals.extend(out.edges.iter().map(|[a, b]| (key(*a, *b), Vec::new())));
        each_cell(mesh, 0..mesh.cell_count(), run, |cell, _| {
            for [a, b, c] in fan(cell) {
                let [p, q, r] = [a, b, c].map(|v| mesh.node(v as usize));
                for (i, j) in [(a, b), (b, c), (c, a)] {
                    if let Some(list) = normals.get_mut(&key(i, j)) {
                        list.push((q - p).cross(r - p).normalize_or_zero());
                    }
                }
            }
            Ok(())
        })?;
        let mut seams: Vec<[u32; 2]> = options.seams.iter().map(|[a, b]| key(*a, *b)).collect();
        seams.sort_unstable();
        let level = SHARP.to_radians().cos();
        for (e, [a, b]) in (0u32..).zip(&out.edges) {
            let key = key(*a, *b);
            let flat = matches!(normals[&key][..], [m, n] if m.dot(n) > level);
            if !flat || seams.binary_search(&key).is_ok() {
                out.ridges.push(e);
            }
        }
        out.find_corners(mesh, &options.corners);
        Ok(out)
    }

    /// Nodes where other than two sharp edges end, and where two make a turn.
    fn find_corners(&mut self, mesh: &dyn MeshView, known: &[u32]) {
        let mut ends: Vec<(u32, u32)> = Vec::with_capacity(2 * self.ridges.len());
        for r in &self.ridges {
            let [a, b] = self.edges[*r as usize];
            ends.extend([(a, b), (b, a)]);
        }
        ends.sort_unstable();
        let away = |from: u32, to: u32| (mesh.node(to as usize) - mesh.node(from as usize)).normalize_or_zero();
        let level = TURN.to_radians().cos();
        for at in ends.chunk_by(|a, b| a.0 == b.0) {
            let straight = matches!(*at, [(v, a), (_, b)] if -away(v, a).dot(away(v, b)) > level);
            if !straight {
                self.corners.push(at[0].0);
            }
        }
        self.corners.extend(known);
        self.corners.sort_unstable();
        self.corners.dedup();
    }
}
