//! An oracle that knows what it was asked once.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::lockstep;
use crate::geometry::{Foot, SurfaceOracle};

/// Threads wait for each other less with so many tables.
const TABLES: usize = 64;

/// Feet kept in a table: 100 MB in all. Then they are dropped; what is asked for again has the same foot.
const MOST: usize = 1 << 14;

/// Points and reaches, bit by bit.
type Key = [u64; 4];

/// Feet by point and reach, of an oracle whose feet are dear, as those of a function in another language are. What is asked for in
/// large batches ahead is known when it is asked for one by one.
pub(crate) struct Remembered<'a> {
    oracle: &'a dyn SurfaceOracle,
    feet: Vec<Mutex<FxHashMap<Key, Option<Foot>>>>,
}

impl<'a> Remembered<'a> {
    /// Knows nothing yet.
    pub(crate) fn new(oracle: &'a dyn SurfaceOracle) -> Self {
        Self { oracle, feet: (0..TABLES).map(|_| Mutex::default()).collect() }
    }

    fn table(&self, key: &Key) -> &Mutex<FxHashMap<Key, Option<Foot>>> {
        // The upper bits of a product depend on all bits of its factors.
        let mixed = key.iter().fold(0u64, |m, k| (m.rotate_left(5) ^ k).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        &self.feet[(mixed >> 32) as usize % TABLES]
    }
}

impl SurfaceOracle for Remembered<'_> {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let key = [p.x, p.y, p.z, reach].map(f64::to_bits);
        let table = self.table(&key);
        if let Some(known) = table.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return *known;
        }
        let foot = self.oracle.project(p, reach);
        // What a question found for want of an answer is none.
        if !lockstep::is_missing() {
            let mut feet = table.lock().unwrap_or_else(PoisonError::into_inner);
            if feet.len() >= MOST {
                feet.clear();
            }
            feet.insert(key, foot);
        }
        foot
    }

    fn in_turn(&self, count: usize, question: &mut dyn FnMut(usize)) {
        self.oracle.in_turn(count, question);
    }

    fn remembers(&self) -> bool {
        true
    }

    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        self.oracle.project_along(p, direction, reach)
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        self.oracle.curvatures(foot)
    }
}
