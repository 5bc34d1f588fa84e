//! Islands: closed pieces of the boundary around one edge of the grid.
//!
//! Where a surface bends across another one, their linear interpolants may enclose the middle of an edge that is outside of what both
//! bound, or the other way round. Nodes of such a piece lie where both vanish, but for those on the edge: in place it has no thickness.

use glam::DVec3;

use super::super::splinters::components;
use super::assemble::{Triangle, is_closed};
use crate::spatial::Aabb;

/// No more tetrahedra than so many meet in an edge of the grid, which have two triangles each.
const LARGEST: usize = 64;
/// Islands are thinner than this share of their width; those that were seen are by a ten-thousandth. What planes enclose has four
/// leaves, and no solid that was shown to be as simple is a lens within cells.
const THIN: f64 = 1e-2;

/// Drops islands. Whether there were any.
pub(super) fn drop_islands(places: &[DVec3], on: &[Vec<u32>], triangles: &mut Vec<Triangle>) -> bool {
    let corners: Vec<[u32; 3]> = triangles.iter().map(|t| t.nodes).collect();
    let (order, starts) = components(places.len(), &corners);
    let mut gone = vec![false; triangles.len()];
    for part in starts.windows(2).map(|w| &order[w[0]..w[1]]).filter(|p| p.len() <= LARGEST) {
        let part_of: Vec<Triangle> = part.iter().map(|t| triangles[*t as usize]).collect();
        if is_island(places, on, &part_of) {
            part.iter().for_each(|t| gone[*t as usize] = true);
        }
    }
    let mut t = 0;
    triangles.retain(|_| {
        t += 1;
        !gone[t - 1]
    });
    gone.contains(&true)
}

fn is_island(places: &[DVec3], on: &[Vec<u32>], part: &[Triangle]) -> bool {
    let mut nodes: Vec<u32> = part.iter().flat_map(|t| t.nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let place = |v: u32| places[v as usize];
    let within = nodes.iter().filter(|v| on[**v as usize].len() < 2).count();
    if nodes.is_empty() || 2 * within > nodes.len() || !is_closed(part, false) {
        return false;
    }
    let all = Aabb::around(nodes.iter().map(|v| place(*v)));
    let (mut area, mut volume) = (0.0, 0.0);
    for t in part {
        let [a, b, c] = t.nodes.map(|v| place(v) - all.center());
        area += 0.5 * (b - a).cross(c - a).length();
        volume += a.dot(b.cross(c)) / 6.0;
    }
    // Two cones over one base: a third of its area times what is between their tips.
    6.0 * f64::abs(volume) <= THIN * area * all.diagonal()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pyramids of the given height over one square, base to base.
    fn lens(height: f64, first: u32) -> (Vec<DVec3>, Vec<Vec<u32>>, Vec<Triangle>) {
        let mut places: Vec<DVec3> =
            (0..4).map(|k| f64::from(k).to_radians() * 90.0).map(|a| DVec3::new(a.cos(), a.sin(), 0.0)).collect();
        places.extend([0.5, -0.5].map(|z| DVec3::new(0.0, 0.0, z * height)));
        let on = (0..6).map(|v| if v < 4 { vec![0, 1] } else { vec![v - 4] }).collect();
        let triangle = |nodes: [u32; 3], leaf| Triangle {
            nodes: nodes.map(|v| v + first),
            leaf,
            plus: true,
            face: 0,
            side: [0; 3],
        };
        let around = (0..4).map(|k| (k, (k + 1) % 4));
        let triangles = around.flat_map(|(a, b)| [triangle([a, b, 4], 0), triangle([b, a, 5], 1)]).collect();
        (places, on, triangles)
    }

    #[test]
    fn only_what_has_no_thickness_goes() {
        let (mut places, mut on, mut triangles) = lens(1e-4, 0);
        let (more, ons, others) = lens(0.5, 6);
        places.extend(more);
        on.extend(ons);
        triangles.extend(others);
        assert!(drop_islands(&places, &on, &mut triangles));
        assert_eq!(triangles.len(), 8);
        assert!(triangles.iter().flat_map(|t| t.nodes).all(|v| v >= 6));
        assert!(!drop_islands(&places, &on, &mut triangles));
        // What is open goes on elsewhere.
        let (places, on, mut triangles) = lens(0.0, 0);
        triangles.pop();
        assert!(!drop_islands(&places, &on, &mut triangles));
    }
}
