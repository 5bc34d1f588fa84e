//! Raising small angles: nodes move to where the triangles around them are better on the whole, by what meshes are judged by, the
//! ratio of radii and the smallest angles.

use glam::DVec3;
use rayon::prelude::*;

use super::moves::{CALM, MANY};
use super::remesher::{Rank, Remesher};
use crate::error::Result;
use crate::numeric::COS_30;
use crate::run::PORTION;

/// Triangles with an angle of a cosine above this, 49 degrees, are poor, and pay for it.
const SMALL: f64 = 0.656;
/// How far beyond the places looked at a move may go, in steps to there.
const REACH: f64 = 2.0;
/// A paraboloid's curvature across that is less than this share of that along counts as none.
const FLAT: f64 = 1e-6;
/// How much the steps are made shorter once there is nothing better in reach of longer ones.
const SHRINK: f64 = 0.35;
/// Nothing is sought where less is missing than this much a triangle.
const CONTENT: f64 = 0.003;
/// Steps after which the search ends: around triangles that are turned over less and less may be missing all the way out.
const STEPS: usize = 64;
/// A move must make this share of what is missing good.
const GAIN: f64 = 0.005;

/// How far it is worth going.
struct Effort {
    /// How much the square of what a cosine is beyond the [limit](SMALL) counts beside a ratio of radii.
    weight: f64,
    /// Triangles with a ratio of radii, 2r/R, below this are poor.
    round: f64,
    /// First and last step, as shares of the shortest edge; later passes start with [shorter](SHRINK) ones.
    steps: [f64; 2],
    /// Passes over the nodes of poor triangles.
    passes: usize,
}

/// Within borders that stay as they were spaced, little is as good as it could be at first.
const SPACED: Effort = Effort { weight: 9.0, round: 0.98, steps: [0.12, 0.01], passes: 4 };
/// Where borders were remeshed along with the rest few small angles are left.
const FREE: Effort = Effort { weight: 14.0, round: 0.0, steps: [0.1, 0.03], passes: 2 };

/// Places looked at around a node, at equal angles from each other in the plane its moves lie in.
const AROUND: usize = 6;
/// The directions, unit vectors.
const DIRECTIONS: [[f64; 2]; AROUND] =
    [[1.0, 0.0], [0.5, COS_30], [-0.5, COS_30], [-1.0, 0.0], [-0.5, -COS_30], [0.5, -COS_30]];

/// A triangle at a node by the ends of its side across from there: each by its coordinates in the plane the node moves in, from
/// where that is now, and its squared distance from there; and by the length of that side.
struct OppositeSide {
    ends: [[f64; 3]; 2],
    side: f64,
}

impl OppositeSide {
    fn new(a: DVec3, b: DVec3, start: DVec3, [x, y]: [DVec3; 2]) -> Self {
        let end = |p: DVec3| [(p - start).dot(x), (p - start).dot(y), p.distance_squared(start)];
        Self { ends: [end(a), end(b)], side: a.distance(b) }
    }

    /// What the triangle lacks with its free corner at each place of the plane: of the ratio of its radii, and of its smallest
    /// angle where that is small.
    fn lack<const N: usize>(&self, at: &[[f64; 2]; N], weight: f64) -> [f64; N] {
        let [a, b] = self.ends;
        at.map(|[x, y]| {
            let squared = |[ex, ey, d]: [f64; 3]| (d - 2.0 * (x * ex + y * ey) + (x * x + y * y)).max(0.0);
            lacks([squared(a), squared(b)], self.side, weight)
        })
    }
}

/// The ratio of a triangle's radii, 2r/R, and the cosine of its smallest angle, by two squared lengths of sides and the third
/// side's length.
fn shape([uu, vv]: [f64; 2], w: f64) -> [f64; 2] {
    let (u, v, uv) = (uu.sqrt(), vv.sqrt(), 0.5 * (uu + vv - w * w));
    let (product, sum) = (u * v * w, u + v + w);
    // The cosine of the smallest angle is the largest of the three.
    let cosine = (uv * w).max((uu - uv) * v).max((vv - uv) * u);
    let over = 1.0 / (product * sum);
    if product > 0.0 { [4.0 * (uu * vv - uv * uv) * over, cosine * sum * over] } else { [0.0, 1.0] }
}

/// [`OppositeSide::lack`] of a triangle by the same lengths.
fn lacks(squared: [f64; 2], side: f64, weight: f64) -> f64 {
    let [ratio, cosine] = shape(squared, side);
    let sharp = (cosine - SMALL).max(0.0);
    1.0 - ratio + weight * sharp * sharp
}

fn lack_around<const N: usize>(ring: &[OppositeSide], at: &[[f64; 2]; N], weight: f64) -> [f64; N] {
    ring.iter().fold([0.0; N], |mut sums, t| {
        sums.iter_mut().zip(t.lack(at, weight)).for_each(|(sum, lack)| *sum += lack);
        sums
    })
}

/// The bottom of the paraboloid that takes the value `now` in the middle and fits the values at the [places around](DIRECTIONS)
/// best, in steps to there.
fn bottom(now: f64, around: &[f64; AROUND]) -> Option<[f64; 2]> {
    let (mut gx, mut gy, mut sum, mut long, mut oblique) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (f, [x, y]) in around.iter().zip(DIRECTIONS) {
        let f = f - now;
        gx += f * x / 3.0;
        gy += f * y / 3.0;
        sum += f / 3.0;
        long += f * (x * x - y * y) * (2.0 / 3.0);
        oblique += f * x * y * (4.0 / 3.0);
    }
    let (xx, yy) = (sum + long, sum - long);
    let determinant = xx * yy - oblique * oblique;
    if xx > 0.0 && determinant > FLAT * xx * xx {
        Some([(oblique * gy - yy * gx) / determinant, (oblique * gx - xx * gy) / determinant])
    } else {
        (xx > 0.0).then(|| [-gx / xx, 0.0])
    }
}

/// What is missing around a node where it is, the place around where the least is, and how much that is.
struct Search {
    before: f64,
    place: [f64; 2],
    least: f64,
}

/// Looks for the place around a node where the least is missing; on a curve along the first coordinate only. `length` is that of
/// the shortest edge there, `first` the first step as a share of it.
fn search(ring: &[OppositeSide], length: f64, on_curve: bool, effort: &Effort, first: f64) -> Search {
    let width = if on_curve { 0.0 } else { 1.0 };
    let [before] = lack_around(ring, &[[0.0; 2]], effort.weight);
    let (mut place, mut least, mut step) = ([0.0; 2], before, first * length);
    if before < CONTENT * ring.len() as f64 {
        return Search { before, place, least };
    }
    for _ in 0..STEPS {
        if step <= effort.steps[1] * length {
            break;
        }
        let there = |[x, y]: [f64; 2]| [place[0] + step * x, place[1] + width * step * y];
        let (mut next, now) = (place, least);
        let mut offer = |at: [f64; 2], lack: f64| {
            if lack < least {
                (least, next) = (lack, at);
            }
        };
        let around = lack_around(ring, &DIRECTIONS.map(there), effort.weight);
        for (d, lack) in DIRECTIONS.into_iter().zip(around) {
            offer(there(d), lack);
        }
        if let Some([x, y]) = bottom(now, &around) {
            let shorter = (REACH / x.hypot(y)).min(1.0);
            let at = there([x * shorter, y * shorter]);
            offer(at, lack_around(ring, &[at], effort.weight)[0]);
        }
        if (next[0] - place[0]).hypot(next[1] - place[1]) < 0.5 * step {
            step *= SHRINK;
        }
        place = next;
    }
    Search { before, place, least }
}

/// Whether a triangle is worth it.
fn is_poor([a, b, c]: [DVec3; 3], effort: &Effort) -> bool {
    let [ratio, cosine] = shape([a.distance_squared(b), a.distance_squared(c)], b.distance(c));
    cosine > SMALL || ratio < effort.round
}

impl Remesher<'_> {
    /// Moves nodes of poor triangles to where less is missing around them. No shape gets worse than the worst one around
    /// was, or than what relaxation may leave.
    pub(super) fn raise_angles(&mut self) -> Result<()> {
        let effort = if self.work.policy.spaced { &SPACED } else { &FREE };
        let seen = self.seen();
        let this = &*self;
        let m = &this.work.mesh;
        let poor: Vec<u32> = this.run.install(|| {
            let list = seen.par_iter().with_min_len(PORTION);
            list.copied().filter(|&t| !this.work.is_kept(t) && is_poor(m.corner_points(t), effort)).collect()
        });
        let mut nodes: Vec<u32> = poor.into_iter().flat_map(|t| m.corners(t)).collect();
        let mut ring = Vec::new();
        for pass in 0..effort.passes {
            let first = effort.steps[0] * SHRINK.powi(pass.min(1) as i32);
            nodes.sort_unstable();
            nodes.dedup();
            let mut next = Vec::new();
            // Of many nodes those without an edge between them look at one time, of few each for itself.
            let few = self.work.mesh.node_capacity() < MANY;
            for group in if few { vec![nodes] } else { self.independent(&nodes) } {
                self.run.check()?;
                let this = &*self;
                let places: Option<Vec<Option<DVec3>>> = (!few).then(|| {
                    let all = || group.par_iter().with_min_len(PORTION);
                    let found = || all().map_init(Vec::new, |ring, &v| this.raised(v, effort, first, ring)).collect();
                    self.run.install(found)
                });
                for (k, &v) in group.iter().enumerate() {
                    let place = match &places {
                        Some(all) => all[k],
                        None => self.raised(v, effort, first, &mut ring),
                    };
                    let (Some(p), start) = (place, self.point(v)) else { continue };
                    self.work.mesh.set_point(v, p);
                    if self.stays_unfolded(v, start) {
                        next.push(v);
                        next.extend(self.work.mesh.neighbors(v));
                    }
                }
            }
            if next.is_empty() {
                break;
            }
            nodes = next;
        }
        Ok(())
    }

    /// Where less is missing around a node, if there is such a place; `ring` is room to work in.
    fn raised(&self, v: u32, effort: &Effort, first: f64, ring: &mut Vec<OppositeSide>) -> Option<DVec3> {
        let rank = self.rank[v as usize];
        // What borders were spaced for here stays; those spaced before had no look at what lies beside.
        if rank == Rank::Corner || (rank == Rank::Curve && !self.work.policy.spaced) || !self.sees(v) {
            return None;
        }
        let (m, start) = (&self.work.mesh, self.point(v));
        let plane = if rank == Rank::Curve {
            let [a, b] = self.work.along(v)[..] else { return None };
            [(self.point(b) - self.point(a)).normalize_or_zero(), DVec3::ZERO]
        } else {
            let up: DVec3 =
                m.outgoing(v).map(|h| (self.point(m.target(h)) - start).cross(self.point(m.apex(h)) - start)).sum();
            let (x, y) = up.try_normalize().map(DVec3::any_orthonormal_pair)?;
            [x, y]
        };
        ring.clear();
        ring.extend(
            m.outgoing(v).map(|h| OppositeSide::new(self.point(m.target(h)), self.point(m.apex(h)), start, plane)),
        );
        let length = m.outgoing(v).map(|h| start.distance(self.point(m.target(h)))).fold(f64::INFINITY, f64::min);
        let Search { before, place: [along, across], least } = search(ring, length, rank == Rank::Curve, effort, first);
        let enough = (1.0 - GAIN) * before;
        if least > enough {
            return None;
        }
        let (set, reach) = (self.work.sets[v as usize], self.reach(v));
        let place = start + along * plane[0] + across * plane[1];
        let (x, normal) = self.work.settle_beside(self.surface, v, &set, place, reach)?;
        if !self.stays_even(v, x) {
            return None;
        }
        let (m, mut after) = (&self.work.mesh, 0.0);
        for h in m.outgoing(v) {
            let (a, b) = (self.point(m.target(h)), self.point(m.apex(h)));
            after += lacks([a.distance_squared(x), b.distance_squared(x)], a.distance(b), effort.weight);
        }
        if after > enough {
            return None;
        }
        let floor = self.work.worst_now(self.surface, v).0.min(CALM);
        if self.worst_beside(v, x, normal, floor) < floor {
            return None;
        }
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[DVec3]) -> Vec<OppositeSide> {
        let n = corners.len();
        (0..n).map(|i| OppositeSide::new(corners[i], corners[(i + 1) % n], DVec3::ZERO, [DVec3::X, DVec3::Y])).collect()
    }

    #[test]
    fn nodes_find_the_middle_of_their_hexagon() {
        let found = search(&ring(&DIRECTIONS.map(|[x, y]| DVec3::new(x + 0.3, y, 0.0))), 0.7, false, &SPACED, 0.12);
        assert!((found.place[0] - 0.3).hypot(found.place[1]) < 0.02, "{:?}", found.place);
    }

    #[test]
    fn searches_end_however_short_their_steps() {
        // Nearly all on one line, where less is missing all the way out from it, and one corner next to the node.
        let short = 1e-9;
        let line = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(-0.7, -1.5, 0.0), DVec3::new(-0.2, -0.4, 0.0)];
        let found = search(&ring(&[line[0], line[1], line[2], DVec3::X * short]), short, false, &SPACED, 0.12);
        assert!(found.least < found.before && found.place[0].hypot(found.place[1]) < 0.1, "{:?}", found.place);
    }
}
