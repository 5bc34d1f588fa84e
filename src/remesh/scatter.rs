//! Nodes at random but not close to each other: what a packing is compared with.
//!
//! Darts are thrown at the triangles and stick where no node is near, as in R. L. Cook, "Stochastic sampling in computer
//! graphics" (1986); after enough of them the sampling is close to a maximal one.

use super::pack::Seed;
use super::remesher::Remesher;
use crate::error::Result;

/// Nodes keep this many wanted lengths apart: a maximal sampling then has about as many as a packing.
const APART: f64 = 0.78;
/// Darts thrown for each node that the area asks for.
const DARTS: f64 = 60.0;

/// Numbers between 0 and 1 without a pattern, the same in every run (the finalizer of splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

impl Remesher<'_> {
    /// Replaces the nodes inside a patch, the only one of this mesh, by a sampling at random.
    pub(super) fn scatter(&mut self) -> Result<()> {
        let Some((mut packing, _, label, asked)) = self.begin_packing() else { return Ok(()) };
        let m = &self.work.mesh;
        let (mut sums, mut triangles) = (Vec::new(), Vec::new());
        let mut sum = 0.0;
        for t in m.triangles() {
            sum += m.area_vector(t).length() / self.want[m.corners(t)[0] as usize].powi(2);
            sums.push(sum);
            triangles.push(t);
        }
        let mut random = Random(u64::from(label));
        // Where they stick is known from the triangles as they are; they go into the mesh afterwards.
        let mut stuck: Vec<(u32, Seed)> = Vec::new();
        for k in 0..(DARTS * asked) as usize {
            if k % 256 == 0 {
                self.run.check()?;
            }
            let x = sum * random.next();
            let t = triangles[sums.partition_point(|s| *s <= x).min(triangles.len() - 1)];
            let (mut u, mut v) = (random.next(), random.next());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let weights = [1.0 - u - v, u, v];
            let [a, b, c] = self.work.mesh.corner_points(t);
            let (p, n) = (a * weights[0] + b * weights[1] + c * weights[2], (b - a).cross(c - a).normalize_or_zero());
            let want = self.want_in(t, weights);
            let mut free = true;
            packing.grid.around(p, APART * want, want, |q, _| free &= q.distance(p) >= APART * want);
            if free {
                packing.grid.insert(p, want, u32::MAX);
                stuck.push((t, Seed { point: p, normal: n, want }));
            }
        }
        stuck.sort_by_key(|s| s.0);
        for (t, seed) in stuck {
            if !self.work.mesh.is_triangle(t) {
                continue;
            }
            let starts = self.work.mesh.corners(t);
            let Some((at, weights)) = starts.into_iter().find_map(|v| self.walk(v, seed.point, seed.normal)) else {
                continue;
            };
            if let Some(v) = self.insert(at, weights, seed, &mut packing) {
                packing.add(v, seed);
            }
        }
        self.drop_unplaced(&packing)
    }
}
