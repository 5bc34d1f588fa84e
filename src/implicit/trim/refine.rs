//! Making a sheet finer at some places.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::leaf::Leaf;
use super::super::newton::nearest;
use super::crowds::Crowd;
use super::sheet::Sheet;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared, triangle_foot};

/// A node moves to where many leaves meet if that point's share of it, in its triangle, is larger than this;
const MOVED: f64 = 0.8;
/// and a side is parted there if the share of the corner across from it is smaller than this.
const ON_SIDE: f64 = 0.1;
/// Sides around where leaves touch are shorter than this share of their distance from there,
const SHORT: f64 = 0.4;
/// halved so many times at most.
const ROUNDS: usize = 10;

/// Halves the sides of all triangles that overlap one of some boxes. Returns whether there were any.
pub(super) fn refine(sheet: &mut Sheet, leaves: &[Leaf], leaf: u32, places: &Bvh, scale: f64) -> bool {
    let near = |sheet: &Sheet, t: [u32; 3]| {
        let mut near = false;
        places.overlapping(&Aabb::around(t.map(|v| sheet.nodes[v as usize])), |_| near = true);
        [near; 3]
    };
    halve(sheet, leaves, leaf, scale, near)
}

/// Halves sides of triangles; new nodes go to the leaf. Neighbors are parted so that sides still fit. Returns whether there
/// were any.
fn halve(
    sheet: &mut Sheet,
    leaves: &[Leaf],
    leaf: u32,
    scale: f64,
    chosen: impl Fn(&Sheet, [u32; 3]) -> [bool; 3],
) -> bool {
    let mut halved: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut nodes: Vec<DVec3> = Vec::new();
    for t in &sheet.triangles {
        let chosen = chosen(sheet, *t);
        for k in (0..3).filter(|k| chosen[*k]) {
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

/// Gives a sheet a node at a point where many leaves meet. Where they touch they may take turns on narrow sectors, and the
/// lines between those turn as fast as they are near: there sides become short beside how far they are from it.
pub(super) fn pin(sheet: &mut Sheet, leaves: &[Leaf], leaf: u32, crowd: &Crowd, scale: f64) {
    let Some(node) = put(sheet, crowd) else { return };
    let long = |sheet: &Sheet, t: [u32; 3], k: usize| {
        let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| sheet.nodes[v as usize]);
        a.distance(b) > SHORT * a.distance(crowd.at).min(b.distance(crowd.at))
    };
    let chosen = |sheet: &Sheet, t: [u32; 3]| match t.iter().position(|v| *v == node) {
        Some(k) => [0, 1, 2].map(|side| side == (k + 1) % 3 && long(sheet, t, side)),
        None => [(0..3).any(|k| long(sheet, t, k)); 3],
    };
    for _ in 0..ROUNDS {
        if !crowd.touching || !halve(sheet, leaves, leaf, scale, chosen) {
            break;
        }
    }
}

/// A node at such a point: one much nearer to it than others moves there, otherwise what it lies on is parted.
fn put(sheet: &mut Sheet, Crowd { at: p, leaves, .. }: &Crowd) -> Option<u32> {
    let p = *p;
    let corners = |t: usize| sheet.triangles[t].map(|v| sheet.nodes[v as usize]);
    let away = |t: usize| triangle_distance_squared(p, corners(t));
    let nearest =
        (0..sheet.triangles.len()).map(|t| (away(t), t)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (_, t) = nearest?;
    let (corners, nodes) = (triangle_foot(p, corners(t)), sheet.triangles[t]);
    let by_share = |a: &usize, b: &usize| corners[*a].total_cmp(&corners[*b]);
    let (most, least) = ((0..3).max_by(by_share)?, (0..3).min_by(by_share)?);
    let is_free = !sheet.pins.contains_key(&nodes[most]);
    let node = if is_free && corners[most] > MOVED {
        sheet.nodes[nodes[most] as usize] = p;
        nodes[most]
    } else {
        sheet.nodes.push(p);
        sheet.nodes.len() as u32 - 1
    };
    sheet.pins.insert(node, leaves.clone());
    if node == nodes[most] {
        return Some(node);
    }
    let on_side = (corners[least] < ON_SIDE).then(|| side(nodes, (least + 1) % 3));
    let parted: Vec<usize> = match on_side {
        Some(ends) => {
            (0..sheet.triangles.len()).filter(|t| (0..3).any(|k| side(sheet.triangles[*t], k) == ends)).collect()
        }
        None => vec![t],
    };
    for t in parted {
        let nodes = sheet.triangles[t];
        let mut made =
            (0..3).filter(|k| Some(side(nodes, *k)) != on_side).map(|k| [nodes[k], nodes[(k + 1) % 3], node]);
        let Some(first) = made.next() else { continue };
        sheet.triangles[t] = first;
        for more in made {
            sheet.triangles.push(more);
            sheet.brick.push(sheet.brick[t]);
        }
    }
    Some(node)
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
