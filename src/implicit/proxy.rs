//! What stands in for a field while a mesh is made that asks for point after point: its values on a grid, and what is between them.
//!
//! The remesher moves one node after the other, each by what the last one did, so its questions cannot wait for each other. Values
//! on a grid can be asked for in large batches. Cells in which they do not tell what is between them are asked as before.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::field::{Between, Field, range_around};
use super::leaf::Leaf;
use super::lockstep;
use super::model::Implicit;
use super::newton::nearest;
use super::walls::Walls;
use crate::mesh::TriMesh;
use crate::spatial::Aabb;

/// Cells along a side of what is asked for at once: with the values around them and in their middles 1843 points.
const SIDE: usize = 8;

/// Values along a side: cubics need one more on either side of a cell.
const ALONG: usize = SIDE + 3;

/// Where cells do not tell what is between them, ones of half the side are asked, so many times. Edges of triangles are as long as the
/// largest; surfaces that bend tightly for these want the next ones, and what the third do not show is a crease.
const LEVELS: usize = 3;

/// Cells are trusted where what they tell of the middle is right to this share of the change along a cell. Nodes end on the field
/// itself, so that this is how far they move at last.
const TRUSTED: f64 = 2e-3;

/// Blocks kept at a time: 350 MB. Then all are dropped; what is asked for again has the same values.
const MOST: usize = 1 << 15;

/// Values in a block of cells.
struct Block {
    values: Vec<f64>,
    /// Cells that tell what is between their corners, a bit each, by rows along x.
    trusted: [u8; SIDE * SIDE],
}

/// A field that knows another one on a grid. What it must ask that one for waits for what others ask, where there are others.
pub(super) struct Proxy {
    field: Arc<dyn Field>,
    step: f64,
    blocks: Mutex<FxHashMap<[i64; 3], Arc<Block>>>,
    /// The same on a finer grid.
    finer: Option<Box<Proxy>>,
}

/// Weights of four values in a row for the value and the slope at `t` from the second to the third.
fn weights(t: f64) -> [[f64; 4]; 2] {
    let (t2, t3) = (t * t, t * t * t);
    [
        [
            0.5 * (2.0 * t2 - t - t3),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (4.0 * t2 - 3.0 * t3 + t),
            0.5 * (t3 - t2),
        ],
        [
            0.5 * (4.0 * t - 1.0 - 3.0 * t2),
            0.5 * (9.0 * t2 - 10.0 * t),
            0.5 * (8.0 * t - 9.0 * t2 + 1.0),
            0.5 * (3.0 * t2 - 2.0 * t),
        ],
    ]
}

impl Block {
    /// Value, and gradient per cell, in a cell at a share of its sides.
    fn at(&self, cell: [usize; 3], share: [f64; 3]) -> (f64, DVec3) {
        let [wx, wy, wz] = share.map(weights);
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for k in 0..4 {
            for j in 0..4 {
                let first = cell[0] + ALONG * (cell[1] + j + ALONG * (cell[2] + k));
                let (mut v, mut d) = (0.0, 0.0);
                for (i, x) in self.values[first..first + 4].iter().enumerate() {
                    v += wx[0][i] * x;
                    d += wx[1][i] * x;
                }
                value += wy[0][j] * wz[0][k] * v;
                slope.x += wy[0][j] * wz[0][k] * d;
                slope.y += wy[1][j] * wz[0][k] * v;
                slope.z += wy[0][j] * wz[1][k] * v;
            }
        }
        (value, slope)
    }
}

impl Proxy {
    fn new(field: Arc<dyn Field>, step: f64, levels: usize) -> Self {
        let finer = (levels > 1).then(|| Box::new(Self::new(field.clone(), 0.5 * step, levels - 1)));
        Self { field, step, blocks: Mutex::default(), finer }
    }

    /// The values of a block. Nothing is held while the field is asked, as that may do anything: two threads may ask for the same.
    fn block(&self, at: [i64; 3]) -> Arc<Block> {
        if let Some(known) = self.blocks.lock().unwrap_or_else(PoisonError::into_inner).get(&at) {
            return known.clone();
        }
        let made = Arc::new(self.asked(at));
        let mut blocks = self.blocks.lock().unwrap_or_else(PoisonError::into_inner);
        if blocks.len() >= MOST {
            blocks.clear();
        }
        blocks.entry(at).or_insert(made).clone()
    }

    /// Asks the field for the values of a block.
    fn asked(&self, at: [i64; 3]) -> Block {
        let place = |k: usize, i: f64| ((at[k] * SIDE as i64) as f64 + i) * self.step;
        let mut points = Vec::with_capacity(ALONG.pow(3) + SIDE.pow(3));
        for (n, from) in [(ALONG, -1.0), (SIDE, 0.5)] {
            let place = |k: usize, i: usize| place(k, i as f64 + from);
            for k in 0..n {
                for j in 0..n {
                    points.extend((0..n).map(|i| DVec3::new(place(0, i), place(1, j), place(2, k))));
                }
            }
        }
        let mut values = vec![f64::NAN; points.len()];
        self.field.values(&points, &mut values);
        let middles = values.split_off(ALONG.pow(3));
        let mut block = Block { values, trusted: [0; SIDE * SIDE] };
        for (n, truth) in middles.into_iter().enumerate() {
            let cell = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
            let (value, slope) = block.at(cell, [0.5; 3]);
            if (value - truth).abs() <= TRUSTED * slope.length() {
                block.trusted[n / SIDE] |= 1 << cell[0];
            }
        }
        block
    }

    /// Value and gradient between the values of the grid, where these tell.
    fn between(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let q = p / self.step;
        // Beyond that numbers are too coarse to count cells.
        if !(q.abs().max_element() < 1e12) {
            return None;
        }
        let low = q.floor();
        let number = low.to_array().map(|x| x as i64);
        let block = self.block(number.map(|i| i.div_euclid(SIDE as i64)));
        let cell = number.map(|i| i.rem_euclid(SIDE as i64) as usize);
        if block.trusted[cell[1] + SIDE * cell[2]] >> cell[0] & 1 == 0 {
            return self.finer.as_ref()?.between(p);
        }
        let (value, slope) = block.at(cell, (q - low).to_array());
        Some((value, slope / self.step))
    }
}

impl Field for Proxy {
    fn value(&self, p: DVec3) -> f64 {
        self.between(p).map_or_else(|| lockstep::value(&self.field, p), |x| x.0)
    }

    fn values(&self, points: &[DVec3], out: &mut [f64]) {
        let mut rest = Vec::new();
        for (k, p) in points.iter().enumerate() {
            match self.between(*p) {
                Some(known) => out[k] = known.0,
                None => rest.push(k),
            }
        }
        if rest.is_empty() {
            return;
        }
        let asked: Vec<DVec3> = rest.iter().map(|k| points[*k]).collect();
        let mut values = vec![f64::NAN; rest.len()];
        lockstep::values(&self.field, &asked, &mut values);
        rest.into_iter().zip(values).for_each(|(k, v)| out[k] = v);
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let (mut v, mut g) = ([f64::NAN], [DVec3::NAN]);
        self.gradients(&[p], &mut v, &mut g);
        Some(g[0])
    }

    fn gradients(&self, points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]) {
        let mut rest = Vec::new();
        for (k, p) in points.iter().enumerate() {
            match self.between(*p) {
                Some(known) => (values[k], gradients[k]) = known,
                None => rest.push(k),
            }
        }
        if rest.is_empty() {
            return;
        }
        let asked: Vec<DVec3> = rest.iter().map(|k| points[*k]).collect();
        let (mut v, mut g) = (vec![f64::NAN; rest.len()], vec![DVec3::NAN; rest.len()]);
        lockstep::slopes(&self.field, &asked, &mut v, &mut g);
        for (n, k) in rest.into_iter().enumerate() {
            (values[k], gradients[k]) = (v[n], g[n]);
        }
    }

    fn in_batches(&self) -> bool {
        false
    }

    fn walls(&self) -> Option<Walls> {
        self.field.walls()
    }

    fn range(&self, cell: &Aabb) -> Between {
        let inside = self.walls().map_or(*cell, |w| w.clamped(cell));
        let width = inside.size().max_element();
        match self.field.lipschitz() {
            // Blocks around the middles of larger boxes would be asked for one value each.
            Some(steep) if width <= SIDE as f64 * self.step => {
                let off = TRUSTED * self.step * steep + self.walls().map_or(0.0, |w| w.beyond(cell, steep));
                range_around(self.value(inside.center()), 0.5 * inside.diagonal() * steep + off)
            }
            _ => lockstep::range(&self.field, cell),
        }
    }
}

impl Implicit {
    /// The same solid with proxies in place of [fields that are asked in batches](Field::in_batches), for a mesh with edges of about
    /// `length`; `None` where it has none of these.
    ///
    /// Surfaces of proxies are a few thousandths of an edge from those of the fields at most; what is made with them must be put in its
    /// place at last.
    pub(crate) fn with_proxies(&self, length: f64) -> Option<Self> {
        let mut made = self.clone();
        let mut known: Vec<(Arc<dyn Field>, Arc<dyn Field>)> = Vec::new();
        let mut any = false;
        for leaf in &mut made.leaves {
            let Leaf::Field(field, place) = leaf else { continue };
            let step = length / place.scale;
            if !(field.in_batches() && step.is_finite() && step > 0.0) {
                continue;
            }
            let proxy = match known.iter().find(|k| Arc::ptr_eq(&k.0, field)) {
                Some((_, proxy)) => proxy.clone(),
                None => Arc::new(Proxy::new(field.clone(), step, LEVELS)),
            };
            known.push((field.clone(), proxy.clone()));
            *field = proxy;
            any = true;
        }
        any.then_some(made)
    }

    /// Puts nodes of a mesh where the leaves of all triangles around them vanish, as far as these are fields that proxies stood in
    /// for; `leaves` are those of its triangles, by number. Nodes that would move by more than `reach`, and those on more than three
    /// leaves, stay.
    pub(crate) fn put_in_place(&self, mesh: &mut TriMesh, leaves: &[u32], reach: f64) {
        let mut on: Vec<Vec<u32>> = vec![Vec::new(); mesh.nodes.len()];
        for (t, leaf) in mesh.triangles.iter().zip(leaves) {
            for v in t {
                if !on[*v as usize].contains(leaf) {
                    on[*v as usize].push(*leaf);
                }
            }
        }
        let waits = |l: &u32| self.leaves.get(*l as usize).is_some_and(Leaf::waits);
        let is_due = |v: &usize| (1..=3).contains(&on[*v].len()) && on[*v].iter().any(waits);
        let known = |v: &usize| on[*v].iter().all(|l| (*l as usize) < self.leaves.len());
        let due: Vec<usize> = (0..mesh.nodes.len()).filter(|v| is_due(v) && known(v)).collect();
        let scale = self.bounds().diagonal();
        let put = lockstep::each(&self.leaves, &due, |v| nearest(&self.leaves, &on[*v], mesh.nodes[*v], reach, scale));
        for (v, q) in due.into_iter().zip(put) {
            mesh.nodes[v] = q.unwrap_or(mesh.nodes[v]);
        }
    }
}
