//! The leaf method: exact edges and corners from the tree, and what to do where the tree does not give them.

use glam::DVec3;

use super::mesh::{MeshOptions, Method, Ready};
use crate::error::{Error, Result};
use crate::implicit::{Extracted, ImplicitOracle, drop_splinters};
use crate::mesh::TriMesh;
use crate::optimize::exact::{ExactMesh, ExactOptions, Observer, Raw, remesh_pieces};
use crate::optimize::{Sizing, improve};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Cells tried one after the other, as shares of the size: smaller ones where borders were not found with larger ones; and
/// whether tips of sharp edges are blunted.
const CELLS: [(f64, bool); 8] =
    [(1.0, false), (1.0, true), (0.5, false), (0.5, true), (0.25, false), (0.25, true), (0.125, false), (0.125, true)];
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
/// A splinter is lost if the mesh does not come nearer to it than this many cells.
const LOST: f64 = 3.0;
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
pub(super) fn exact_options(ready: &Ready, options: &MeshOptions) -> ExactOptions {
    let angle = options.angle.unwrap_or(ANGLE).to_radians();
    let least = options.least.unwrap_or(ready.size / LEAST_SHARE);
    let wishes = ready.wishes(options);
    let wish = |i: usize| wishes.faces.get(i).copied().flatten();
    let smaller = |a: Option<f64>, b: Option<f64>| a.map_or(b, |a| Some(b.map_or(a, |b| a.min(b))));
    ExactOptions {
        sizing: Sizing { size: ready.size, nodes_per_radius: Some(1.0 / angle), chord: options.tolerance, least },
        face_sizes: ready.model.faces().iter().enumerate().map(|(i, f)| smaller(f.size, wish(i))).collect(),
        regions: wishes.regions,
        grading: options.grading,
    }
}

/// Which triangles come within `reach` of some boxes.
fn near(mesh: &TriMesh, boxes: &[Aabb], reach: f64) -> Vec<bool> {
    let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
    let mut found = vec![false; mesh.triangles.len()];
    boxes.iter().for_each(|b| tree.overlapping(&b.grown(reach), |t| found[t as usize] = true));
    found
}

/// What one size of cells gave.
struct Attempt {
    exact: ExactMesh,
    extracted: Extracted,
    cell: f64,
    blunt: bool,
    /// See [`drop_splinters`].
    splinters: Vec<DVec3>,
}

impl Attempt {
    fn faults(&self) -> usize {
        self.exact.report.self_intersections + self.exact.report.inverted
    }

    fn unresolved(&self) -> &[DVec3] {
        &self.exact.report.cut.unresolved
    }

    /// A splinter that the finished mesh does not come near to, if there is one.
    fn lost(&self) -> Option<DVec3> {
        let mesh = &self.exact.mesh;
        if self.splinters.is_empty() {
            return None;
        }
        let tree = Bvh::new((0..mesh.triangles.len()).map(|t| Aabb::around(mesh.corners(t))).collect());
        let far = |p: &DVec3| {
            let distance = |t: u32| triangle_distance_squared(*p, mesh.corners(t as usize));
            tree.nearest(*p, LOST * self.cell, distance).is_none()
        };
        self.splinters.iter().copied().find(far)
    }

    fn shortfalls(&self) -> Vec<String> {
        let unresolved = self.unresolved();
        let mut list: Vec<String> = unresolved
            .iter()
            .take(NAMED)
            .map(|p| format!("no exact edge found near {}: two faces come too close there", at(*p)))
            .collect();
        if unresolved.len() > NAMED {
            list.push(format!("and at {} more places", unresolved.len() - NAMED));
        }
        list.extend(self.lost().map(|p| format!("the solid, or a gap, is thinner than the cells near {}", at(p))));
        list
    }
}

fn at(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

/// Runs the leaf method on ever smaller cells until it comes out clean. Where no attempt does, the best one is made anew
/// with the surroundings of its faults as they were extracted; falls back to the operators, at last to marching cubes,
/// where that does not help.
pub(super) fn by_leaf(
    ready: &Ready,
    options: &MeshOptions,
    run: &Run,
    mut observer: Option<&mut Observer<'_>>,
) -> Result<ByLeaf> {
    let mut best: Option<Attempt> = None;
    let mut first_error = None;
    // Places left without an exact edge in the attempt before, of each kind; a kind that no smaller cells help is given up.
    let mut last = [None; 2];
    let mut given_up = [false; 2];
    for (share, blunt) in CELLS {
        if given_up[usize::from(blunt)] {
            continue;
        }
        let cell = share * ready.size;
        let mut extracted = match ready.extract_as(cell, blunt, options, run) {
            Ok(e) => e,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            // Nothing was found with these cells, or there is no memory for smaller ones: the first error tells the user.
            Err(e) => {
                first_error.get_or_insert(e);
                continue;
            }
        };
        let splinters = drop_splinters(&mut extracted, &ready.model, cell);
        let oracle = ImplicitOracle::new(&ready.model, &extracted);
        let wanted = exact_options(ready, options);
        let raw = Raw { mesh: &extracted.mesh, cell, kept: &[], blunt };
        let exact = remesh_pieces(&raw, &oracle, &wanted, run, observer.as_deref_mut())?;
        let triangles = extracted.mesh.triangles.len();
        let this = Attempt { exact, extracted, cell, blunt, splinters };
        let lost = this.unresolved().len();
        let clean = lost == 0 && this.faults() == 0 && this.lost().is_none();
        let before = last[usize::from(blunt)].replace(lost);
        given_up[usize::from(blunt)] = lost >= MANY && before.is_some_and(|n: usize| 2 * lost >= n);
        if best.as_ref().is_none_or(|b| (this.faults(), lost) < (b.faults(), b.unresolved().len())) {
            best = Some(this);
        }
        // Edges that run out like knives are never found whole; the attempts for their sake end somewhere.
        let sound = best.as_ref().is_some_and(|b| b.faults() == 0);
        if clean || (sound && 4 * triangles > MOST_TRIANGLES) {
            break;
        }
    }
    let Some(mut best) = best else {
        return Err(first_error.unwrap_or_else(|| Error::Failed("no attempt was made".into())));
    };
    let found = best.exact.report.clone();
    let left = if best.faults() > 0 { leave(ready, options, &mut best, run, observer)? } else { Vec::new() };
    let mut shortfalls = best.shortfalls();
    if best.faults() == 0 {
        shortfalls.extend(left.first().map(|b| {
            let more = left.len() - 1;
            let what = "left as marching cubes made it around";
            format!("{what} {} and {more} more places: exact edges there make triangles intersect", at(b.center()))
        }));
        let Attempt { exact: ExactMesh { mesh, seams, corners, .. }, extracted, cell, .. } = best;
        let (intersecting, method) = (Some(0), Method::Leaf);
        return Ok(ByLeaf { mesh, seams, corners, intersecting, extracted, cell, method, shortfalls });
    }
    let found = [(found.self_intersections, "intersect others"), (found.inverted, "are turned over")];
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

/// Makes an attempt again, and again, with ever more of what lies around its faults left as it was extracted, until there are
/// none. Returns where it was left.
fn leave(
    ready: &Ready,
    options: &MeshOptions,
    attempt: &mut Attempt,
    run: &Run,
    mut observer: Option<&mut Observer<'_>>,
) -> Result<Vec<Aabb>> {
    let mesh = &attempt.extracted.mesh;
    let oracle = ImplicitOracle::new(&ready.model, &attempt.extracted);
    let wanted = exact_options(ready, options);
    let mut left = Vec::new();
    for reach in LEAVE {
        left.extend(attempt.exact.report.faults.iter().copied());
        let kept = near(mesh, &left, reach * attempt.cell);
        let raw = Raw { mesh, cell: attempt.cell, kept: &kept, blunt: attempt.blunt };
        attempt.exact = remesh_pieces(&raw, &oracle, &wanted, run, observer.as_deref_mut())?;
        if attempt.faults() == 0 {
            break;
        }
    }
    Ok(left)
}
