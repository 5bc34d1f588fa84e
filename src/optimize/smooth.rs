//! Smoothing: `R_all` (12, 13), `R_regular` (18) and `R_edge` (19, 20) of \[LIS14\], each followed by projection.

use glam::DVec3;

use super::classify::{Classes, Kind, kind_by_edges};
use super::crease::{feature_neighbors, settle};
use super::guard::{Moves, ask_all, relocate_all};
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::EditMesh;
use crate::run::Run;

/// The constant c of (19) the default sequences use. Jacobi steps with c = 1 make neighbors swap places for ever.
pub const ALONG: f64 = 0.5;

/// Laplacian displacement (13): mean of the neighbors minus the node.
fn laplacian(mesh: &EditMesh, v: u32) -> DVec3 {
    let (mut sum, mut n) = (DVec3::ZERO, 0u32);
    for x in mesh.neighbors(v) {
        sum += mesh.point(x);
        n += 1;
    }
    sum / f64::from(n.max(1)) - mesh.point(v)
}

/// Area-weighted normal of the triangles around a node, taken from the surface where it is known.
pub(super) fn node_normal(mesh: &EditMesh, v: u32) -> DVec3 {
    let normal = |h: u32| {
        let a = mesh.area_vector(h / 3);
        let m = mesh.normal(h / 3);
        if m == DVec3::ZERO { a } else { a.length() * m }
    };
    mesh.outgoing(v).map(normal).sum::<DVec3>().normalize_or_zero()
}

/// What a node counts as when it is smoothed. Marked edges, as `N1` leaves them on creases of the surface, come before classes:
/// curvature is taken from one ring of triangles, and a flip or a new node nearby is enough to call a node on a crease regular.
fn kind_of(mesh: &EditMesh, classes: &Classes, v: u32) -> Kind {
    if mesh.outgoing(v).any(|h| mesh.is_sharp(h)) { kind_by_edges(mesh, v) } else { classes.kind(v) }
}

/// The neighbors along the crease a node is on: the ends of its two marked edges, else what the classes say.
fn along_of(mesh: &EditMesh, classes: &Classes, v: u32) -> Option<[u32; 2]> {
    match feature_neighbors(mesh, v)[..] {
        [a, b] => Some([a, b]),
        _ => classes.along(v),
    }
}

fn smooth_where(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    run: &Run,
    wanted: impl Fn(&EditMesh, u32) -> bool + Sync,
) -> Result<Moves> {
    let frozen = &*mesh;
    let targets = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v) || frozen.is_pinned(v) || frozen.is_boundary(v) || !wanted(frozen, v) {
            return None;
        }
        let step = laplacian(frozen, v);
        let n = node_normal(frozen, v);
        Some(oracle.project(frozen.point(v) + step - step.dot(n) * n, reach).map(|f| f.point))
    })?;
    relocate_all(mesh, oracle, run, targets, |_, _, p| oracle.project(p, reach).map(|f| f.point))
}

/// One pass of `R_all`, \[LIS14\] (12, 13): every node goes by the tangential part of its Laplacian displacement, then back
/// to the surface. Pinned and boundary nodes stay.
///
/// *Guarantees*: guarded (see [`guard`](super::guard)). *Does not guarantee*: features; nodes slide off creases, so use it
/// to prepare a mesh before `N1`, not after.
pub fn smooth_all(mesh: &mut EditMesh, oracle: &dyn SurfaceOracle, reach: f64, run: &Run) -> Result<Moves> {
    smooth_where(mesh, oracle, reach, run, |_, _| true)
}

/// One pass of `R_regular`, \[LIS14\] (18): as [`smooth_all`], but only nodes that are neither on a crease nor a corner.
/// A node at an edge marked sharp is never regular, whatever the classes say.
pub fn smooth_regular(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    classes: &Classes,
    reach: f64,
    run: &Run,
) -> Result<Moves> {
    smooth_where(mesh, oracle, reach, run, |mesh, v| kind_of(mesh, classes, v) == Kind::Regular)
}

/// How far nodes go along which creases.
#[derive(Debug, Clone, Copy)]
pub struct CreaseStep<'a> {
    /// Tells nodes on creases from others, and their neighbors along these.
    pub classes: &'a Classes,
    /// The constant c of (19), as [`ALONG`].
    pub c: f64,
}

/// One pass of `R_edge`, \[LIS14\] (19, 20): a node on a crease goes by `c (u·τ̂) τ̂` with u from the node to the middle of
/// its two neighbors along the crease and τ̂ the unit vector between these (the paper's two cases are this one formula),
/// then back onto the crease.
///
/// Corners, pinned and boundary nodes stay, and so does a node without two neighbors along its crease. Nodes whose
/// edges are marked sharp are put back by locating the crease, others by projection.
pub fn smooth_edges(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    step: CreaseStep<'_>,
    reach: f64,
    run: &Run,
) -> Result<Moves> {
    let CreaseStep { classes, c } = step;
    let back = |mesh: &EditMesh, v: u32, p: DVec3| {
        if mesh.outgoing(v).any(|h| mesh.is_sharp(h)) {
            settle(mesh, oracle, v, p, reach)
        } else {
            oracle.project(p, reach).map(|f| f.point)
        }
    };
    let frozen = &*mesh;
    let targets = ask_all(oracle, run, mesh.node_capacity(), |v| {
        if !frozen.is_node(v)
            || frozen.is_pinned(v)
            || frozen.is_boundary(v)
            || kind_of(frozen, classes, v) != Kind::Crease
        {
            return None;
        }
        let [i, j] = along_of(frozen, classes, v)?;
        let (p, pi, pj) = (frozen.point(v), frozen.point(i), frozen.point(j));
        let tau = (pi - pj).normalize_or_zero();
        let u = 0.5 * (pi + pj) - p;
        Some(back(frozen, v, p + c * u.dot(tau) * tau))
    })?;
    relocate_all(mesh, oracle, run, targets, back)
}
