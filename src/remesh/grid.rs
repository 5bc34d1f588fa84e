//! Points that are looked for by place while more are added.

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

use crate::mesh::edit::NONE;

/// Points in cubic cells. Sizes may differ by place: each power of two above `least` has cells of its own.
pub(super) struct PointGrid {
    least: f64,
    reach: f64,
    levels: Vec<FxHashMap<IVec3, u32>>,
    /// Point, id and what comes next in the same cell.
    items: Vec<(DVec3, u32, u32)>,
}

/// Levels beyond this are one: their points are few.
const LEVELS: usize = 24;

impl PointGrid {
    /// For points of sizes from `least`, looked for as far away as `reach` of their sizes.
    pub(super) fn new(least: f64, reach: f64) -> Self {
        Self { least, reach, levels: Vec::new(), items: Vec::new() }
    }

    fn level(&self, size: f64) -> usize {
        ((size / self.least).max(1.0).log2() as usize).min(LEVELS)
    }

    fn cell(&self, level: usize) -> f64 {
        2.0 * self.reach * self.least * (1u32 << level) as f64
    }

    pub(super) fn insert(&mut self, p: DVec3, size: f64, id: u32) {
        let level = self.level(size);
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, FxHashMap::default);
        }
        let key = (p / self.cell(level)).floor().as_ivec3();
        let k = self.items.len() as u32;
        let first = self.levels[level].insert(key, k).unwrap_or(NONE);
        self.items.push((p, id, first));
    }

    /// Calls `found` for every point within `radius` whose size is like `size` (between a quarter and four times), and for
    /// some beyond.
    pub(super) fn around(&self, p: DVec3, radius: f64, size: f64, mut found: impl FnMut(DVec3, u32)) {
        let own = self.level(size);
        for level in own.saturating_sub(2)..(own + 3).min(self.levels.len()) {
            let cells = &self.levels[level];
            if cells.is_empty() {
                continue;
            }
            let cell = self.cell(level);
            let (lo, hi) = (((p - radius) / cell).floor().as_ivec3(), ((p + radius) / cell).floor().as_ivec3());
            for x in lo.x..=hi.x {
                for y in lo.y..=hi.y {
                    for z in lo.z..=hi.z {
                        let mut at = cells.get(&IVec3::new(x, y, z)).copied().unwrap_or(NONE);
                        while at != NONE {
                            let (q, id, next) = self.items[at as usize];
                            found(q, id);
                            at = next;
                        }
                    }
                }
            }
        }
    }
}
