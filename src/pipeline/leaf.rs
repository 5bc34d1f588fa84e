//! The leaf method: exact edges and corners from the tree, and what to do where the tree does not give them.

use super::mesh::{MeshOptions, Method, Ready};
use crate::error::{Error, Result};
use crate::implicit::{Extracted, ImplicitOracle};
use crate::mesh::TriMesh;
use crate::optimize::exact::{ExactMesh, ExactOptions, Observer, remesh_pieces};
use crate::optimize::{Sizing, improve};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Cells tried one after the other, as shares of the size: smaller ones where borders were not found with larger ones.
const CELLS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// No attempt is made with cells that would give more triangles than this after one that gave a sound mesh.
const MOST_TRIANGLES: usize = 1_500_000;
/// Where this many places are left without an exact edge and smaller cells do not halve them, still smaller ones will not
/// either.
const MANY: usize = 100;
/// Without a wish for it, neighboring edges on curved parts turn by this many degrees at most: 18 nodes to a circle.
const ANGLE: f64 = 20.0;
/// Without a wish for it, curvature makes edges at most this many times shorter than the size.
const LEAST_SHARE: f64 = 4.0;
/// How often what lies around triangles with faults is left as it was extracted, in cells around them: farther every time.
const LEAVE: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// How many unresolved places a report names.
const NAMED: usize = 5;

/// A mesh by the leaf method, or by the best that could be had instead.
pub(super) struct ByLeaf {
    pub(super) mesh: TriMesh,
    /// See [`ExactMesh`]; none by the other methods.
    pub(super) seams: Vec<[u32; 2]>,
    pub(super) corners: Vec<u32>,
    /// How many triangles intersect others, where that is known.
    pub(super) intersecting: Option<usize>,
    /// The extraction the mesh was made from: its nodes lie on the surface, its cells prune the tree.
    pub(super) extracted: Extracted,
    pub(super) cell: f64,
    pub(super) method: Method,
    pub(super) shortfalls: Vec<String>,
}

impl ByLeaf {
    /// A mesh made without leaves.
    pub(super) fn by_other(
        mesh: TriMesh,
        extracted: Extracted,
        cell: f64,
        method: Method,
        shortfalls: Vec<String>,
    ) -> Self {
        Self { mesh, seams: Vec::new(), corners: Vec::new(), intersecting: None, extracted, cell, method, shortfalls }
    }
}

/// What the remesher aims at.
pub(super) fn exact_options(ready: &Ready, options: &MeshOptions, cell: f64) -> ExactOptions {
    let angle = options.angle.unwrap_or(ANGLE).to_radians();
    let least = options.least.unwrap_or(ready.size / LEAST_SHARE);
    ExactOptions {
        sizing: Sizing { size: ready.size, nodes_per_radius: Some(1.0 / angle), chord: options.tolerance, least },
        face_sizes: ready.model.faces().iter().map(|f| f.size).collect(),
        grading: options.grading,
        cell,
    }
}

/// Which triangles come within `reach` of some boxes.
fn near(mesh: &TriMesh, boxes: &[Aabb], reach: f64) -> Vec<bool> {
    let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let mut found = vec![false; mesh.triangles.len()];
    boxes.iter().for_each(|b| tree.overlapping(&b.grown(reach), |t| found[t as usize] = true));
    found
}

/// Runs the leaf method on ever smaller cells until it comes out clean, and falls back to the operators, at last to
/// marching cubes, where no attempt comes out without faults.
pub(super) fn by_leaf(
    ready: &Ready,
    options: &MeshOptions,
    run: &Run,
    mut observer: Option<&mut Observer<'_>>,
) -> Result<ByLeaf> {
    let mut best: Option<(usize, ExactMesh, Extracted, f64)> = None;
    let mut first_error = None;
    // Places left without an exact edge in the attempt before.
    let mut last = None;
    for share in CELLS {
        let cell = share * ready.size;
        let extracted = match ready.extract(cell, options, run) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // Nothing was found with these cells, or there is no memory for smaller ones: the first error tells the user.
            Err(e) => {
                first_error.get_or_insert(e);
                continue;
            }
        };
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let wanted = exact_options(ready, options, cell);
        let exact = remesh_pieces(&extracted.mesh, &oracle, &wanted, &[], run, observer.as_deref_mut())?;
        let report = &exact.report;
        let faults = report.self_intersections + report.inverted;
        let (clean, triangles) = (report.is_clean(), extracted.mesh.triangles.len());
        let lost = report.cut.unresolved.len();
        let found_more = lost < MANY || last.is_none_or(|n: usize| 2 * lost < n);
        last = Some(lost);
        let better = best
            .as_ref()
            .is_none_or(|b| (faults, report.cut.unresolved.len()) < (b.0, b.1.report.cut.unresolved.len()));
        if better {
            best = Some((faults, exact, extracted, cell));
        }
        // Edges that run out like knives are never found whole; the attempts for their sake end somewhere.
        let sound = best.as_ref().is_some_and(|b| b.0 == 0);
        if clean || !found_more || (sound && 4 * triangles > MOST_TRIANGLES) {
            break;
        }
    }
    let Some((mut faults, mut exact, extracted, cell)) = best else {
        return Err(first_error.unwrap_or_else(|| Error::Failed("no attempt was made".into())));
    };
    let mut left = Vec::new();
    if faults > 0 {
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let wanted = exact_options(ready, options, cell);
        for reach in LEAVE {
            left.extend(exact.report.faults.iter().copied());
            let kept = near(&extracted.mesh, &left, reach * cell);
            exact = remesh_pieces(&extracted.mesh, &oracle, &wanted, &kept, run, observer.as_deref_mut())?;
            faults = exact.report.self_intersections + exact.report.inverted;
            if faults == 0 {
                break;
            }
        }
    }
    let ExactMesh { mesh, seams, corners, report } = exact;
    let mut shortfalls: Vec<String> = report
        .cut
        .unresolved
        .iter()
        .take(NAMED)
        .map(|p| {
            format!("no exact edge found near ({:.6}, {:.6}, {:.6}): two faces come too close there", p.x, p.y, p.z)
        })
        .collect();
    if report.cut.unresolved.len() > NAMED {
        shortfalls.push(format!("and at {} more places", report.cut.unresolved.len() - NAMED));
    }
    shortfalls.extend(left.first().filter(|_| faults == 0).map(|b: &Aabb| {
        let p = b.center();
        format!(
            "left as marching cubes made it around ({:.6}, {:.6}, {:.6}) and {} more places: exact edges there made \
             triangles intersect",
            p.x,
            p.y,
            p.z,
            left.len() - 1
        )
    }));
    if faults == 0 {
        let intersecting = Some(report.self_intersections);
        return Ok(ByLeaf { mesh, seams, corners, intersecting, extracted, cell, method: Method::Leaf, shortfalls });
    }
    let found = [(report.self_intersections, "intersect others"), (report.inverted, "are turned over")];
    let found = found.iter().filter(|f| f.0 > 0).map(|(n, what)| format!("{n} {what}"));
    let found: Vec<String> = found.collect();
    let extracted = ready.extract(ready.size, options, run)?;
    let oracle = ImplicitOracle::new(&ready.model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let improved = improve(&mut mesh, &oracle, &ready.operator_options(options), run)?;
    let mut method = Method::Operators;
    if improved.self_intersections + improved.after.inverted > 0 {
        mesh = extracted.mesh.clone();
        method = Method::MarchingCubes;
    }
    shortfalls.push(format!(
        "with exact edges, of the triangles {}: made by {} instead",
        found.join(" and "),
        method.name()
    ));
    Ok(ByLeaf::by_other(mesh, extracted, ready.size, method, shortfalls))
}
