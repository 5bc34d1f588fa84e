//! The leaf method: exact edges and corners from the tree, and what to do where the tree does not give them.

use super::cells::{CellLadder, Scout, Start};
use super::history::{Attempt, Tried};
use super::ladder::{Attempts, Change};
use super::mesh::Ready;
use super::method::Method;
use super::options::MeshOptions;
use super::trial::Trial;
use crate::error::Result;
use crate::implicit::{Extracted, ImplicitOracle};
use crate::mesh::TriMesh;
use crate::optimize::improve;
use crate::quality::Fault;
use crate::remesh::{Off, RemeshOptions, RemeshedMesh};
use crate::run::Run;
use crate::sizing::{LEAST_SHARE, SizeRequest, Wish, own_tolerance};
use crate::spatial::Graded;

/// Narrow gaps and short borders make edges at most this many times shorter than the size, as slivers of faces narrower than that are
/// cut off boundary representations.
pub(super) const NARROWEST: f64 = 40.0;
/// A mesh by the leaf method, or by the best that could be had instead.
pub(super) struct ByLeaf {
    pub(super) mesh: TriMesh,
    /// See [`RemeshedMesh`]; none by the other methods.
    pub(super) seams: Vec<[u32; 2]>,
    pub(super) corners: Vec<u32>,
    /// How many triangles intersect others, where that is known.
    pub(super) intersecting: Option<usize>,
    /// The extraction the mesh was made from: its nodes lie on the surface, its cells prune the tree.
    pub(super) extracted: Extracted,
    pub(super) cell: f64,
    pub(super) method: Method,
    pub(super) shortfalls: Vec<Fault>,
    /// The number of the attempt it is of,
    pub(super) number: usize,
    /// and its cells.
    pub(super) start: Start,
    /// Whether all is shown of the arrangement it is of: its leaves have no creases.
    pub(super) proved: bool,
    /// Whether smaller cells everywhere left no fewer triangles at fault.
    pub(super) is_exhausted: bool,
    /// Nodes that were drawn back where the solid touches itself.
    pub(super) drawn: usize,
    /// Nodes that are not on their surfaces, as triangles would cross if they were.
    pub(super) off: Vec<Off>,
}

impl ByLeaf {
    /// A mesh made without leaves.
    pub(super) fn by_other(
        mesh: TriMesh,
        extracted: Extracted,
        cell: f64,
        method: Method,
        shortfalls: Vec<Fault>,
    ) -> Self {
        let (seams, corners) = (Vec::new(), Vec::new());
        Self {
            mesh,
            seams,
            corners,
            intersecting: None,
            extracted,
            cell,
            method,
            shortfalls,
            number: 0,
            start: Start::default(),
            proved: false,
            is_exhausted: false,
            drawn: 0,
            off: Vec::new(),
        }
    }
}

/// Options for a part whose curved walls are thinner than chords are high: `times` as many chords to a length.
pub(super) fn finer(ready: &Ready, options: &MeshOptions, times: f64) -> MeshOptions {
    let tolerance = own_tolerance(ready.size, ready.model.bounds().diagonal()) / (times * times);
    let least = options.least_length().unwrap_or(ready.size / (LEAST_SHARE * times));
    let [tolerance, least] = [tolerance, least].map(|l| Some(SizeRequest::Length(l)));
    MeshOptions { tolerance, least, ..options.clone() }
}

/// What the remesher aims at.
pub(super) fn remesh_options(ready: &Ready, options: &MeshOptions, cell: f64) -> Result<RemeshOptions> {
    let wish = Wish::new(ready.size, ready.model.bounds().diagonal(), options.asked());
    // Cells are as wide as the size unless something smaller was found.
    let sizing = wish.sizing(options.least_length().unwrap_or(cell / LEAST_SHARE));
    let grading = wish.grading;
    let wishes = ready.wishes(options)?;
    let by_face = |i: usize| wishes.faces.get(i).copied().flatten();
    let smaller = |a: Option<f64>, b: Option<f64>| a.map_or(b, |a| Some(b.map_or(a, |b| a.min(b))));
    Ok(RemeshOptions {
        sizing,
        face_sizes: ready.model.faces().iter().enumerate().map(|(i, f)| smaller(f.size, by_face(i))).collect(),
        regions: wishes.regions,
        finer: Graded::new(ready.finer.clone(), grading),
        grading,
        narrowest: options.least_length().unwrap_or(ready.size / NARROWEST),
        thickness: options.thickness,
        distance: None,
    })
}

/// Runs the leaf method on ever smaller cells until it comes out clean; falls back to the method cut, at last to marching cubes, where
/// most triangles cross however small they are.
pub(super) fn by_leaf(mut cells: CellLadder<'_, '_>, attempts: &mut Attempts, run: &Run) -> Result<ByLeaf> {
    let (ready, options) = (cells.ready, cells.options);
    if let Some(best) = cells.search(attempts, run)? {
        let proved = best.scout.proof.as_ref().is_some_and(|p| p.unproved == 0);
        let mut shortfalls = best.shortfalls(ready);
        let faults = best.faults();
        if faults > 0 {
            shortfalls.push(Fault::mended(faults, &best.exact.report.faults));
        }
        let Trial { exact: RemeshedMesh { mesh, seams, corners, report, .. }, scout, start, number, drawn, .. } = best;
        let Scout { extracted, cell, .. } = scout;
        let intersecting = (faults == 0).then_some(0);
        let method = options.method;
        return Ok(ByLeaf {
            mesh,
            seams,
            corners,
            intersecting,
            extracted,
            cell,
            method,
            shortfalls,
            number,
            start,
            proved,
            is_exhausted: cells.is_exhausted,
            drawn,
            off: report.off,
        });
    }
    let [crossing, inverted] = cells.faults;
    attempts.change(Change::OtherWay, "most triangles cross with all cells");
    let extracted = ready.extract(ready.size, options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let improved = improve(&mut mesh, &oracle, &ready.operator_options(options), run)?;
    let mut method = Method::Cut;
    let flawed = improved.self_intersections + improved.after.inverted;
    let mut number = attempts.add(Attempt::new(Tried::Operators, ready.size, mesh.triangles.len(), flawed), run);
    if flawed > 0 {
        mesh = extracted.mesh.clone();
        method = Method::MarchingCubes;
        attempts.change(Change::OtherWay, "operators left triangles at fault");
        number = attempts.add(Attempt::new(Tried::MarchingCubes, ready.size, mesh.triangles.len(), 0), run);
    }
    let shortfalls = vec![Fault::OtherMethod { crossing, inverted, method: method.name() }];
    let is_exhausted = cells.is_exhausted;
    Ok(ByLeaf { number, is_exhausted, ..ByLeaf::by_other(mesh, extracted, ready.size, method, shortfalls) })
}
