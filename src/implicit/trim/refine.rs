//! Making a sheet finer at some places.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::leaf::Leaf;
use super::super::newton::nearest;
use super::sheet::Sheet;
use crate::spatial::{Aabb, Bvh};

/// Halves the sides of all triangles that overlap one of some boxes; new nodes go to the leaf. Neighbors are parted so that sides
/// still fit. Returns whether there were any.
pub(super) fn refine(sheet: &mut Sheet, leaves: &[Leaf], leaf: u32, places: &Bvh, scale: f64) -> bool {
    let corners = |t: [u32; 3]| t.map(|v| sheet.nodes[v as usize]);
    let mut halved: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut nodes: Vec<DVec3> = Vec::new();
    for t in &sheet.triangles {
        let mut near = false;
        places.overlapping(&Aabb::around(corners(*t)), |_| near = true);
        if !near {
            continue;
        }
        for k in 0..3 {
            let ends = side(*t, k);
            halved.entry(ends).or_insert_with(|| {
                let [p, q] = ends.map(|v| sheet.nodes[v as usize]);
                let middle = p.midpoint(q);
                nodes.push(nearest(leaves, &[leaf], middle, 0.5 * p.distance(q), scale).unwrap_or(middle));
                (sheet.nodes.len() + nodes.len() - 1) as u32
            });
        }
    }
    if nodes.is_empty() {
        return false;
    }
    sheet.nodes.extend(nodes);
    let mut triangles = Vec::with_capacity(2 * sheet.triangles.len());
    let mut brick = Vec::with_capacity(2 * sheet.triangles.len());
    for (t, b) in sheet.triangles.iter().zip(&sheet.brick) {
        let middle = [0, 1, 2].map(|k| halved.get(&side(*t, k)).copied());
        parted(*t, middle, &mut triangles);
        brick.resize(triangles.len(), *b);
    }
    (sheet.triangles, sheet.brick) = (triangles, brick);
    true
}

/// The ends of a side of a triangle, the lower node first.
fn side(t: [u32; 3], k: usize) -> [u32; 2] {
    let (a, b) = (t[k], t[(k + 1) % 3]);
    [a.min(b), a.max(b)]
}

/// A triangle with nodes in the middle of some sides.
fn parted(t: [u32; 3], middle: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    match middle {
        [Some(x), Some(y), Some(z)] => out.extend([[t[0], x, z], [x, t[1], y], [z, y, t[2]], [x, y, z]]),
        [None, None, None] => out.push(t),
        _ => {
            // Turned until the first side has a node and the last has none.
            let k = (0..3).find(|k| middle[*k].is_some() && middle[(k + 2) % 3].is_none()).unwrap_or(0);
            let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            let Some(x) = middle[k] else { return };
            match middle[(k + 1) % 3] {
                Some(y) => out.extend([[a, x, c], [x, y, c], [x, b, y]]),
                None => out.extend([[a, x, c], [x, b, c]]),
            }
        }
    }
}
