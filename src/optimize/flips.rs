//! Edge flips: towards the surface's normals, and towards better angles. Neither touches a sharp edge.

use glam::DVec3;

use super::guard::{FACING, area_vector, sharpest_cosine};
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::{EditMesh, edit::NONE};
use crate::numeric::ROUNDING;
use crate::run::Run;

/// Passes over the mesh: each flip strictly improves a bounded measure, and a handful of passes settle all but a few.
const PASSES: usize = 8;

/// Triangles further from the surface's normal than 30 degrees (cosine) span a crease that is not an edge yet; their
/// shape is no matter for [`flip_for_angles`].
const RESOLVED: f64 = 0.866;

/// The two triangles at an edge before and after a flip, in the order [`EditMesh::flip`] writes them.
fn pairs(mesh: &EditMesh, h: u32) -> ([[DVec3; 3]; 2], [[DVec3; 3]; 2]) {
    let o = mesh.opposite(h);
    let [a, b, c, d] = [mesh.origin(h), mesh.target(h), mesh.apex(h), mesh.apex(o)].map(|v| mesh.point(v));
    ([[a, b, c], [b, a, d]], [[a, d, c], [d, b, c]])
}

/// Flips edges while that raises the smaller minimum angle of the two triangles. A flip may not turn a triangle against
/// the surface's normal where [`survey`](super::survey) recorded one, nor more than `bend` degrees away from it unless
/// the old pair was worse; without recorded normals, the new triangles' normals must agree with the old ones'. Returns
/// the number of flips.
pub fn flip_for_angles(mesh: &mut EditMesh, bend: f64, run: &Run) -> Result<usize> {
    let bend = bend.to_radians().cos();
    let mut total = 0;
    let mut dirty: Vec<bool> = vec![true; mesh.triangle_capacity()];
    for _ in 0..PASSES {
        run.check()?;
        let mut flips = 0;
        let mut touched = vec![false; mesh.triangle_capacity()];
        for h in 0..3 * mesh.triangle_capacity() as u32 {
            if !mesh.is_edge(h) || mesh.is_feature(h) || mesh.is_pinned_edge(h) {
                continue;
            }
            let o = mesh.opposite(h);
            if !dirty[(h / 3) as usize] && !dirty[(o / 3) as usize] {
                continue;
            }
            let (old, new) = pairs(mesh, h);
            let worst = |t: [[DVec3; 3]; 2]| sharpest_cosine(t[0]).max(sharpest_cosine(t[1]));
            // A flip must improve its measure, so that rounding cannot make two diagonals take turns for ever.
            if worst(new) >= worst(old) - ROUNDING || !keeps_facing(mesh, h, old, new, bend) {
                continue;
            }
            if mesh.flip(h) {
                flips += 1;
                touched[(h / 3) as usize] = true;
                touched[(o / 3) as usize] = true;
            }
        }
        total += flips;
        if flips == 0 {
            break;
        }
        spread(mesh, &touched, &mut dirty);
    }
    Ok(total)
}

/// Marks the triangles whose edges may choose anew: a flip changes the choice at the edges of both its triangles.
fn spread(mesh: &EditMesh, touched: &[bool], dirty: &mut [bool]) {
    dirty.fill(false);
    for t in (0..touched.len()).filter(|&t| touched[t]) {
        dirty[t] = true;
        for o in (0..3).map(|k| mesh.opposite((3 * t + k) as u32)).filter(|&o| o != NONE) {
            dirty[(o / 3) as usize] = true;
        }
    }
}

/// Whether a flip keeps both triangles on the right side of the surface.
fn keeps_facing(mesh: &EditMesh, h: u32, old: [[DVec3; 3]; 2], new: [[DVec3; 3]; 2], bend: f64) -> bool {
    let m = [mesh.normal(h / 3), mesh.normal(mesh.opposite(h) / 3)];
    let (o, n) = (old.map(|t| area_vector(t).normalize_or_zero()), new.map(|t| area_vector(t).normalize_or_zero()));
    let least = |x: [DVec3; 2], m: [DVec3; 2]| {
        let mut least = f64::INFINITY;
        for x in x {
            for m in m {
                least = least.min(x.dot(m));
            }
        }
        least
    };
    if m.contains(&DVec3::ZERO) {
        return least(n, o) >= bend;
    }
    let own = o[0].dot(m[0]).min(o[1].dot(m[1]));
    // Two faces meet here, marked or not, or the crease is not resolved: the diagonal is not free.
    if m[0].dot(m[1]) < bend || own < RESOLVED {
        return false;
    }
    least(n, m) >= bend.min(own).max(0.0)
}

/// Flips edges while that lowers the normal deviation of \[LIS14\] (4, 5) summed over the two triangles, the surface being
/// asked anew at the centroids of the new pair. Only edges whose triangles bend by more than `bend` degrees, from each
/// other or from the recorded normals, are looked at. Returns the number of flips.
pub fn flip_for_normals(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    reach: f64,
    bend: f64,
    run: &Run,
) -> Result<usize> {
    let bend = bend.to_radians().cos();
    let cost = |t: [DVec3; 3]| -> Option<(f64, f64, crate::geometry::Foot)> {
        let foot = oracle.project((t[0] + t[1] + t[2]) / 3.0, reach)?;
        let a = area_vector(t);
        let facing = a.normalize_or_zero().dot(foot.normal);
        // The square of (4) alone would call an inverted triangle perfect.
        let deviation = if facing > 0.0 { 1.0 - facing * facing } else { 2.0 - facing };
        Some((a.length() * deviation, facing, foot))
    };
    let mut total = 0;
    let mut dirty = vec![true; mesh.triangle_capacity()];
    for _ in 0..PASSES {
        let mut flips = 0;
        let mut touched = vec![false; mesh.triangle_capacity()];
        for h in 0..3 * mesh.triangle_capacity() as u32 {
            if h % 1024 == 0 {
                run.check()?;
            }
            if !mesh.is_edge(h) || mesh.is_feature(h) || mesh.is_pinned_edge(h) {
                continue;
            }
            let o = mesh.opposite(h);
            if !dirty[(h / 3) as usize] && !dirty[(o / 3) as usize] {
                continue;
            }
            let n = [h / 3, o / 3].map(|t| mesh.area_vector(t).normalize_or_zero());
            let m = [mesh.normal(h / 3), mesh.normal(o / 3)];
            let off = |k: usize| m[k] != DVec3::ZERO && n[k].dot(m[k]) < bend;
            if n[0].dot(n[1]) > bend && !off(0) && !off(1) {
                continue;
            }
            let (old, new) = pairs(mesh, h);
            let (Some(a), Some(b), Some(c), Some(d)) = (cost(old[0]), cost(old[1]), cost(new[0]), cost(new[1])) else {
                continue;
            };
            let limit = 5f64.to_radians().cos().max(sharpest_cosine(old[0])).max(sharpest_cosine(old[1]));
            let shape = sharpest_cosine(new[0]).max(sharpest_cosine(new[1])) <= limit;
            let area: f64 = old.iter().map(|t| area_vector(*t).length()).sum();
            let upright = c.1.min(d.1) >= FACING.min(a.1.min(b.1));
            if shape && upright && c.0 + d.0 < a.0 + b.0 - ROUNDING * area && mesh.flip(h) {
                mesh.set_surface(h / 3, c.2.face, c.2.normal);
                mesh.set_surface(o / 3, d.2.face, d.2.normal);
                touched[(h / 3) as usize] = true;
                touched[(o / 3) as usize] = true;
                flips += 1;
            }
        }
        total += flips;
        if flips == 0 {
            break;
        }
        spread(mesh, &touched, &mut dirty);
    }
    Ok(total)
}
