//! Cells of one size over a surface's triangles: the nearest one is found without walking down a tree.

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

use super::{Aabb, Bvh, triangle_distance_squared};
use crate::numeric::NONE;

/// Items a cell of even triangles shall hold, about: smaller cells do not get cheaper, they only get more.
const ITEMS: f64 = 1.5;
/// Entries per item at most, on average; slender triangles, of which many cross a cell, get larger cells instead.
const ENTRIES: f64 = 16.0;
/// A cell with more items is searched with the tree: there the triangles are much smaller than elsewhere.
const CROWDED: u32 = 24;
/// Cells beyond this many in a direction are none: numbers of cells fit into 21 bits.
const MOST: f64 = 1e6;
/// Triangles face about the same way where each is nearer to their mean than this (cosine): 44 degrees, so that no two are 90 apart. From there on
/// the foot of a point on one side of an edge lies within the other side, and a walk ends there.
const EVEN: f64 = 0.72;

/// Triangles by place, for points that lie close to them.
#[derive(Debug, Clone)]
pub struct TriangleCells {
    origin: DVec3,
    cell: f64,
    /// Place in `runs` by cell, and the triangle to start from.
    of_cell: FxHashMap<u64, (u32, u32)>,
    runs: Vec<CellTriangles>,
    items: Vec<u32>,
    /// Boxes of slices of triangles, ascending, and the triangle each is of.
    tree: Bvh,
    of_slice: Vec<u32>,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct CellTriangles {
    first: u32,
    count: u32,
}

fn key(c: IVec3) -> u64 {
    (c.x as u64) | (c.y as u64) << 21 | (c.z as u64) << 42
}

/// Calls `f` with boxes around the slices of a triangle, cut across its longest side into parts no longer than `length`: the box of a
/// slender triangle that lies across the axes holds much more than the triangle.
fn slices(t: &[DVec3; 3], length: f64, mut f: impl FnMut(Aabb)) {
    let side = |k: usize| t[(k + 1) % 3].distance_squared(t[k]);
    let k = (0..3).max_by(|a, b| side(*a).total_cmp(&side(*b))).unwrap_or(0);
    let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
    let count = (side(k).sqrt() / length).ceil();
    if !(count > 1.0) {
        return f(Aabb::around(*t));
    }
    let foot = ((c - a).dot(b - a) / side(k)).clamp(0.0, 1.0);
    // The other two sides, by the share of the longest below.
    let over = |s: f64| {
        if s < foot { a.lerp(c, s / foot) } else { c.lerp(b, if foot < 1.0 { (s - foot) / (1.0 - foot) } else { 0.0 }) }
    };
    for i in 0..count as usize {
        let [s, e] = [i as f64 / count, (i as f64 + 1.0) / count];
        let mut slice = Aabb::around([a.lerp(b, s), a.lerp(b, e), over(s), over(e)]);
        if s <= foot && foot <= e {
            slice = slice.union(&Aabb::around([c]));
        }
        f(slice);
    }
}

impl TriangleCells {
    /// Cells over triangles, which are numbered as given. `least` is how large cells must be: about the distance from the
    /// surface up to which points are asked for.
    pub fn new(triangles: &[[DVec3; 3]], least: f64) -> Self {
        let mut boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::around(*t)).collect();
        let all = boxes.iter().fold(Aabb::EMPTY, |b, x| b.union(x));
        let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
        let count = triangles.len().max(1) as f64;
        let mut cell = (ITEMS * area / count).sqrt().max(all.diagonal() / MOST).max(least);
        let are_few = |cell: f64| {
            let mut entries = 0.0;
            triangles.iter().all(|t| {
                slices(t, cell, |b| entries += (b.size() / cell + 1.0).element_product());
                entries <= ENTRIES * count
            })
        };
        while cell > 0.0 && all.is_finite() && !are_few(cell) {
            cell *= 1.5;
        }
        let mut this = Self {
            origin: all.lo,
            cell,
            of_cell: FxHashMap::default(),
            runs: Vec::new(),
            items: Vec::new(),
            tree: Bvh::new(Vec::new()),
            of_slice: (0..triangles.len() as u32).collect(),
        };
        if cell > 0.0 && all.is_finite() {
            let (mut cut, mut of_slice) = (Vec::with_capacity(boxes.len()), Vec::with_capacity(boxes.len()));
            for (i, t) in triangles.iter().enumerate() {
                slices(t, cell, |slice| {
                    cut.push(slice);
                    of_slice.push(i as u32);
                });
            }
            (boxes, this.of_slice) = (cut, of_slice);
            this.fill(triangles, &boxes);
        }
        this.tree = Bvh::new(boxes);
        this
    }

    fn fill(&mut self, triangles: &[[DVec3; 3]], boxes: &[Aabb]) {
        let mut entries: Vec<(u32, u32)> = Vec::with_capacity(6 * triangles.len());
        let mut centers = Vec::new();
        let mut last = FxHashMap::default();
        for (slice, &i) in self.of_slice.iter().enumerate() {
            let t = &triangles[i as usize];
            let normal = (t[1] - t[0]).cross(t[2] - t[0]);
            // How far the corners of a cell are from its center, along the normal; and what rounding adds to that.
            let half = 0.5 * self.cell * normal.abs().element_sum() * 1.001;
            let (lo, hi) = (self.cell_at(boxes[slice].lo), self.cell_at(boxes[slice].hi));
            for x in lo.x..=hi.x {
                for y in lo.y..=hi.y {
                    for z in lo.z..=hi.z {
                        let c = IVec3::new(x, y, z);
                        let center = self.origin + self.cell * (c.as_dvec3() + 0.5);
                        if normal.dot(center - t[0]).abs() > half {
                            continue;
                        }
                        let next = self.runs.len() as u32;
                        let run = self.of_cell.entry(key(c)).or_insert((next, NONE)).0;
                        if run == next {
                            self.runs.push(CellTriangles::default());
                            centers.push((key(c), center));
                        }
                        // Slices of one triangle may cross the same cell.
                        if last.insert(run, i) != Some(i) {
                            self.runs[run as usize].count += 1;
                            entries.push((run, i));
                        }
                    }
                }
            }
        }
        let mut first = 0;
        for run in &mut self.runs {
            run.first = first;
            first += std::mem::take(&mut run.count);
        }
        self.items = vec![0; entries.len()];
        for (run, i) in entries {
            let run = &mut self.runs[run as usize];
            self.items[(run.first + run.count) as usize] = i;
            run.count += 1;
        }
        for (run, (key, center)) in self.runs.iter().zip(centers) {
            let own = &self.items[run.first as usize..(run.first + run.count) as usize];
            let normal = |i: u32| {
                let [a, b, c] = triangles[i as usize];
                (b - a).cross(c - a).normalize_or_zero()
            };
            let mean = own.iter().map(|i| normal(*i)).sum::<DVec3>().normalize_or_zero();
            let away = |i: u32| triangle_distance_squared(center, triangles[i as usize]);
            let nearest =
                own.iter().copied().map(|i| (away(i), i)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let even = own.iter().all(|i| normal(*i).dot(mean) > EVEN);
            if let (Some(n), true, Some(cell)) = (nearest, even, self.of_cell.get_mut(&key)) {
                cell.1 = n.1;
            }
        }
    }

    /// A triangle close to a point whose cell all triangles cross facing about the same way, and the length of a cell's side: from
    /// that triangle the nearest one can be walked to.
    pub fn start(&self, p: DVec3) -> Option<(u32, f64)> {
        let c = self.cell_at(p);
        if c.min_element() < 0 {
            return None;
        }
        let start = self.of_cell.get(&key(c))?.1;
        (start != NONE).then_some((start, self.cell))
    }

    fn cell_at(&self, p: DVec3) -> IVec3 {
        // Towards zero: what lies before the first cell by less than one counts as in it.
        ((p - self.origin) / self.cell).as_ivec3()
    }

    /// The triangle nearest to `p` by `distance_squared`, as [`Bvh::nearest`] has it, and that squared distance.
    pub fn nearest(&self, p: DVec3, limit: f64, mut distance_squared: impl FnMut(u32) -> f64) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut bound = limit * limit;
        let own = self.cell_at(p);
        let mut look = |c: IVec3, best: &mut Option<(u32, f64)>, bound: &mut f64| -> bool {
            if c.min_element() < 0 {
                return true;
            }
            let Some(&(run, _)) = self.of_cell.get(&key(c)) else { return true };
            let CellTriangles { first, count } = self.runs[run as usize];
            if count > CROWDED {
                return false;
            }
            for &i in &self.items[first as usize..(first + count) as usize] {
                let d = distance_squared(i);
                if d <= *bound && best.is_none_or(|b| d < b.1 || (d == b.1 && i < b.0)) {
                    *best = Some((i, d));
                    *bound = d;
                }
            }
            true
        };
        let mut crowded = self.runs.is_empty() || !look(own, &mut best, &mut bound);
        let reach = bound.sqrt();
        // Rounding must not leave out the cell next door.
        let margin = reach + 1e-9 * self.cell;
        if !crowded && reach <= self.cell {
            let (lo, hi) = (self.cell_at(p - margin), self.cell_at(p + margin));
            for x in lo.x..=hi.x {
                for y in lo.y..=hi.y {
                    for z in lo.z..=hi.z {
                        let c = IVec3::new(x, y, z);
                        crowded |= c != own && !look(c, &mut best, &mut bound);
                    }
                }
            }
            if !crowded {
                return best;
            }
        }
        let by_slice = |slice: u32| distance_squared(self.of_slice[slice as usize]);
        self.tree.nearest(p, bound.sqrt().min(limit), by_slice).map(|n| (self.of_slice[n.0 as usize], n.1)).or(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::triangle_distance_squared;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_triangle_is_the_nearest_of_all(
            raw in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), prop::array::uniform9(-0.2f64..0.2)), 0..80),
            q in prop::array::uniform3(-1.2f64..1.2), on in any::<prop::sample::Index>(), off in 0.0f64..0.1, limit in 0.01f64..1.0,
        ) {
            let triangles: Vec<[DVec3; 3]> = raw
                .iter()
                .map(|(c, d)| [0, 3, 6].map(|k| DVec3::from_array(*c) + DVec3::from_slice(&d[k..k + 3])))
                .collect();
            let cells = TriangleCells::new(&triangles, 0.0);
            let mut places = vec![DVec3::from_array(q)];
            if !triangles.is_empty() {
                let [a, b, c] = triangles[on.index(triangles.len())];
                places.push((a + b + c) / 3.0 + off);
            }
            for p in places {
                let d = |i: u32| triangle_distance_squared(p, triangles[i as usize]);
                let truth = (0..triangles.len() as u32).map(d).filter(|x| *x <= limit * limit).min_by(f64::total_cmp);
                let found = cells.nearest(p, limit, d);
                prop_assert_eq!(found.map(|n| n.1), truth);
                prop_assert!(found.is_none_or(|n| d(n.0) == n.1));
            }
        }
    }
}
