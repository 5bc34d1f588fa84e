//! Triangles too flat to have a normal: their longest edges are flipped away, so that they make no false features.

use crate::error::Result;
use crate::mesh::EditMesh;
use crate::mesh::edit::NONE;
use crate::run::Run;

/// Passes over all triangles: a flip may leave another flat triangle.
const PASSES: usize = 8;

/// Height of a triangle over its longest side, the half-edge of that side.
fn height(mesh: &EditMesh, t: u32) -> (f64, u32) {
    let longest = (3 * t..3 * t + 3)
        .max_by(|a, b| mesh.edge_length(*a).total_cmp(&mesh.edge_length(*b)).then(b.cmp(a)))
        .unwrap_or(3 * t);
    let length = mesh.edge_length(longest);
    (if length > 0.0 { mesh.area_vector(t).length() / length } else { 0.0 }, longest)
}

/// Flips the longest edges of triangles lower than `least` where the lower of the two triangles gets higher by it and the
/// surface moves by less than `least`; then collapses their shortest edges if these are shorter than `least`. Returns how
/// many flips and collapses that took.
///
/// The normal of such a triangle is rounding: `least` should be what the coordinates' precision amounts to.
pub fn mend_needles(mesh: &mut EditMesh, least: f64, run: &Run) -> Result<usize> {
    let mut count = 0;
    for _ in 0..PASSES {
        let before = count;
        for t in 0..mesh.triangle_capacity() as u32 {
            if t % 4096 == 0 {
                run.check()?;
            }
            if !mesh.is_triangle(t) {
                continue;
            }
            let (low, h) = height(mesh, t);
            if low >= least {
                continue;
            }
            let shortest = (3 * t..3 * t + 3)
                .min_by(|a, b| mesh.edge_length(*a).total_cmp(&mesh.edge_length(*b)).then(a.cmp(b)))
                .unwrap_or(h);
            let o = mesh.opposite(h);
            if mesh.edge_length(shortest) < least {
                let p = mesh.point(mesh.target(shortest));
                count += usize::from(mesh.collapse(shortest, p));
            } else if o != NONE && mesh.label(t) == mesh.label(o / 3) {
                // The apex lies on the longest side: flipping replaces two triangles by the halves of one.
                let [a, b, c, d] = [mesh.origin(h), mesh.target(h), mesh.apex(h), mesh.apex(o)].map(|v| mesh.point(v));
                let before = low.min(height(mesh, o / 3).0);
                let lower = |x: glam::DVec3, y: glam::DVec3, z: glam::DVec3| {
                    let longest = x.distance(y).max(y.distance(z)).max(z.distance(x));
                    (y - x).cross(z - x).length() / longest.max(f64::MIN_POSITIVE)
                };
                if lower(a, d, c).min(lower(d, b, c)) > before {
                    count += usize::from(mesh.flip(h));
                }
            }
        }
        if count == before {
            break;
        }
    }
    Ok(count)
}
