//! The surface of one leaf by marching cubes, in some bricks.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::batch::{Batch, SIDE};
use super::super::leaf::Leaf;
use super::super::mc33::{EDGES, INTERIOR_NODE, case, interior_position};
use super::super::octree::{BRICK, Cell, Grid};
use super::positive;
use crate::numeric::Bracket;

/// Nodes lie within this share of the part's size of the leaf's zero.
const CLOSE: f64 = 1e-13;

/// A leaf's surface: an open mesh, oriented from the leaf's positive side to the negative one.
pub(super) struct Sheet {
    pub(super) nodes: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each triangle the brick it lies in.
    pub(super) brick: Vec<u32>,
    /// Nodes at points where many leaves meet, with the leaves.
    pub(super) pins: FxHashMap<u32, Vec<u32>>,
}

impl Sheet {
    /// Whether a node is known to be on a leaf.
    pub(super) fn is_pinned(&self, node: u32, leaf: u32) -> bool {
        !self.pins.is_empty() && self.pins.get(&node).is_some_and(|leaves| leaves.contains(&leaf))
    }
}

/// Meshes the zeros of a leaf. Faces of cells with alternating signs are decided alike from both sides.
pub(super) fn sheet(leaf: &Leaf, grid: &Grid, bricks: &[&Cell], scale: f64) -> Sheet {
    let mut out = Sheet { nodes: Vec::new(), triangles: Vec::new(), brick: Vec::new(), pins: FxHashMap::default() };
    let mut number: FxHashMap<(u8, [u32; 3]), u32> = FxHashMap::default();
    let mut batch = Batch::default();
    for (b, cell) in bricks.iter().enumerate() {
        batch.corners(grid, cell.at);
        batch.values.resize(batch.x.len(), 0.0);
        match leaf {
            Leaf::Fillet(_) => {
                let at = |k: usize| DVec3::new(batch.x[k], batch.y[k], batch.z[k]);
                batch.values = (0..batch.x.len()).map(|k| leaf.continued(at(k))).collect();
            }
            _ => leaf.eval(&batch.x, &batch.y, &batch.z, &mut batch.values),
        }
        let first = positive(batch.values[0]);
        if batch.values.iter().all(|v| positive(*v) == first) {
            continue;
        }
        for n in 0..BRICK * BRICK * BRICK {
            let at = [n % BRICK, n / BRICK % BRICK, n / (BRICK * BRICK)];
            let corner = |c: u8| [0, 1, 2].map(|k| at[k] + usize::from(c >> k & 1));
            let value = |c: u8| {
                let [i, j, k] = corner(c);
                batch.values[i + SIDE * (j + SIDE * k)]
            };
            let mask = (0..8u8).fold(0u8, |m, c| m | u8::from(positive(value(c))) << c);
            if mask == 0 || mask == 0xff {
                continue;
            }
            let found = case(mask, 0, 0);
            let mut own = [u32::MAX; 16];
            for &e in found.triangles.iter().flatten().filter(|e| **e < INTERIOR_NODE) {
                if own[e as usize] != u32::MAX {
                    continue;
                }
                let [a, b] = EDGES[e as usize];
                let global = |c: u8| {
                    let q = corner(c);
                    [0, 1, 2].map(|k| cell.at[k] as usize * BRICK + q[k])
                };
                let (p, q) = (global(a), global(b));
                let id = number.entry((e / 4, p.map(|i| i as u32))).or_insert_with(|| {
                    let ends = [grid.node(p), grid.node(q)];
                    out.nodes.push(root(leaf, ends, [value(a), value(b)], CLOSE * scale / grid.h));
                    out.nodes.len() as u32 - 1
                });
                own[e as usize] = *id;
            }
            for v in 0..found.interior_nodes {
                let v = INTERIOR_NODE + v;
                let at = |e: usize| if own[e] == u32::MAX { DVec3::ZERO } else { out.nodes[own[e] as usize] };
                let middle = interior_position(found.triangles, v, &std::array::from_fn(at));
                own[v as usize] = out.nodes.len() as u32;
                out.nodes.push(middle);
            }
            out.triangles.extend(found.triangles.iter().map(|t| t.map(|v| own[v as usize])));
            out.brick.resize(out.triangles.len(), b as u32);
        }
    }
    out
}

/// The zero of a leaf between two points.
fn root(leaf: &Leaf, [p, q]: [DVec3; 2], values: [f64; 2], tolerance: f64) -> DVec3 {
    // The bracket asks for values that are not zero.
    let signed = |v: f64| if v == 0.0 { f64::MIN_POSITIVE } else { v };
    let mut bracket = Bracket::new(signed(values[0]), signed(values[1]), tolerance);
    while !bracket.done() {
        let t = bracket.probe();
        bracket.update(t, signed(leaf.continued(p.lerp(q, t))));
    }
    p.lerp(q, bracket.root())
}
