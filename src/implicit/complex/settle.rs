//! From linear to exact: nodes go to where their leaves vanish, and triangles that this turns over are set right.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::super::leaf::Leaf;
use super::super::lockstep;
use super::super::newton::nearest;
use super::assemble::{Key, Triangle};
use crate::error::Result;
use crate::numeric::Sets;
use crate::run::Run;

/// A triangle lies badly on its leaf if twice its area, seen along the leaf's normal, is less than this share of the square of
/// its longest side.
pub(super) const FLAT: f64 = 0.02;
/// Rounds in which nodes around such triangles move: one or two do, on all parts measured, where all is proved.
const ROUNDS: usize = 8;
/// Rounds end when fewer than this share of the bad triangles go.
const GOES: f64 = 0.1;

/// Sweeps in which nodes move together, those of a curve or those inside a face: a run of `k` nodes on a curve takes about `k` squared of
/// them, and no curve within a few cells has more than six in a row. Most take two or three.
pub(super) const SWEEPS: usize = 40;

/// Nodes, what they lie on, and how far they may be from it.
pub(super) struct Nodes<'a> {
    pub(super) places: Vec<DVec3>,
    pub(super) on: &'a [Vec<u32>],
    /// The sizes of the tetrahedra they were made in.
    pub(super) reach: &'a [f64],
    pub(super) leaves: &'a [Leaf],
    /// The size of the part.
    pub(super) scale: f64,
    /// Nodes that others know, ascending: they do not move for the sake of triangles.
    pub(super) stay: &'a [u32],
    /// Where a block beside moves some of them, too.
    pub(super) common: Option<Common<'a>>,
}

/// What makes nodes where blocks meet move as in the block beside: these are moved before all others, those of several walls first, so
/// that no chain of bad triangles brings what one block does not know.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    /// What nodes are called: that is the order they move in.
    pub(super) names: &'a [Key],
    /// How many walls they are in.
    pub(super) walls: &'a [u8],
}

/// Triangles, and those around each node.
#[derive(Clone, Copy)]
struct Stars<'a> {
    triangles: &'a [Triangle],
    around: &'a [Vec<u32>],
}

/// The triangles around each node.
fn stars(triangles: &[Triangle], nodes: usize) -> Vec<Vec<u32>> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); nodes];
    for (t, triangle) in (0..).zip(triangles) {
        triangle.nodes.iter().for_each(|v| around[*v as usize].push(t));
    }
    around
}

impl Nodes<'_> {
    /// Puts each node where its leaves vanish, if that is near. Those for which it is not stay, and are returned.
    pub(super) fn settle(&mut self) -> Vec<u32> {
        let all: Vec<usize> = (0..self.places.len()).collect();
        let exact = lockstep::each(self.leaves, &all, |&i| {
            nearest(self.leaves, &self.on[i], self.places[i], self.reach[i], self.scale)
        });
        let mut stay = Vec::new();
        for (i, q) in exact.into_iter().enumerate() {
            match q {
                Some(q) => self.places[i] = q,
                None => stay.push(i as u32),
            }
        }
        stay
    }

    /// How well a triangle lies on its leaf, if node `v` were at `p`.
    fn lies(&self, t: &Triangle, v: u32, p: DVec3) -> f64 {
        let [a, b, c] = t.nodes.map(|u| if u == v { p } else { self.places[u as usize] });
        let n = self.leaves[t.leaf as usize].slope((a + b + c) / 3.0).normalize_or_zero();
        let n = if t.plus { -n } else { n };
        let long = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        (b - a).cross(c - a).dot(n) / long.max(f64::MIN_POSITIVE)
    }

    /// Moves nodes around triangles that are turned over or flat, along what they lie on, to the middle of their neighbors there
    /// or part of the way, as long as the worst triangle around them gets better.
    pub(super) fn untangle(&mut self, triangles: &[Triangle], run: &Run) -> Result<()> {
        let around = stars(triangles, self.places.len());
        let stars = Stars { triangles, around: &around };
        let Some(Common { walls, .. }) = self.common else {
            return self.rounds(&stars, |_| true, GOES, run).map(drop);
        };
        for most in (1..=3).rev() {
            // How many go is another share in the block beside, where the same nodes must move as often.
            self.rounds(&stars, |v| walls[v as usize] == most, f64::NEG_INFINITY, run)?;
        }
        self.rounds(&stars, |v| walls[v as usize] == 0, GOES, run).map(drop)
    }

    /// Moves nodes like [`untangle`](Self::untangle), but of no block, then those around triangles that are left together.
    pub(super) fn untangle_together(&mut self, triangles: &[Triangle], run: &Run) -> Result<()> {
        let around = stars(triangles, self.places.len());
        let stars = Stars { triangles, around: &around };
        let bad = self.rounds(&stars, |_| true, GOES, run)?;
        self.smooth(bad, &stars, run)
    }

    /// Moves some of the nodes, until fewer than a share of the bad triangles around them go. Returns those that are left.
    fn rounds(&mut self, stars: &Stars<'_>, moves: impl Fn(u32) -> bool, goes: f64, run: &Run) -> Result<Vec<u32>> {
        let triangles = stars.triangles;
        let touched = |t: &u32| triangles[*t as usize].nodes.iter().any(|v| moves(*v));
        let mut looked: Vec<u32> = (0..triangles.len() as u32).filter(touched).collect();
        let mut before = usize::MAX;
        for _ in 0..ROUNDS {
            run.check()?;
            let is_bad = lockstep::each(self.leaves, &looked, |t| self.is_bad(&triangles[*t as usize]));
            let bad: Vec<u32> = looked.into_iter().zip(is_bad).filter(|x| x.1).map(|x| x.0).collect();
            if bad.is_empty() || bad.len() as f64 > (1.0 - goes) * before as f64 {
                return Ok(bad);
            }
            before = bad.len();
            let mut nodes: Vec<u32> =
                bad.iter().flat_map(|t| triangles[*t as usize].nodes).filter(|v| moves(*v)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            if let Some(common) = self.common {
                nodes.sort_by_key(|v| common.names[*v as usize]);
            }
            nodes.iter().for_each(|v| self.relax(*v, stars));
            looked = nodes.iter().flat_map(|v| stars.around[*v as usize].iter().copied()).collect();
            looked.sort_unstable();
            looked.dedup();
        }
        looked.retain(|t| self.is_bad(&triangles[*t as usize]));
        Ok(looked)
    }

    fn is_bad(&self, t: &Triangle) -> bool {
        self.lies(t, u32::MAX, DVec3::ZERO) < FLAT
    }

    /// Moves nodes inside faces around triangles that are left to the middle of all their neighbors, whatever that does to any one of these:
    /// a border that moved far has left several rows of them on its other side. What this makes no better is taken back.
    fn smooth(&mut self, bad: Vec<u32>, stars: &Stars<'_>, run: &Run) -> Result<()> {
        let Stars { triangles, around } = *stars;
        let mut clusters = Sets::new(bad.len());
        let mut of_node: Vec<[u32; 2]> =
            (0..).zip(&bad).flat_map(|(i, t)| triangles[*t as usize].nodes.map(|v| [v, i])).collect();
        of_node.sort_unstable();
        of_node.windows(2).filter(|w| w[0][0] == w[1][0]).for_each(|w| clusters.join(w[0][1], w[1][1]));
        let (of, count) = clusters.numbers();
        let mut members = vec![Vec::new(); count];
        of.iter().zip(&bad).for_each(|(c, t)| members[*c as usize].push(*t));
        let star = |v: &u32| around[*v as usize].iter().copied();
        for mut bad in members {
            run.check()?;
            let mut before: BTreeMap<u32, DVec3> = BTreeMap::new();
            for _ in 0..SWEEPS {
                let is_free = |v: &u32| self.on[*v as usize].len() == 1;
                let free: BTreeSet<u32> =
                    bad.iter().flat_map(|t| triangles[*t as usize].nodes).filter(is_free).collect();
                for &v in &free {
                    let near: BTreeSet<u32> =
                        star(&v).flat_map(|t| triangles[t as usize].nodes).filter(|u| *u != v).collect();
                    let sum: DVec3 = near.iter().map(|u| self.places[*u as usize]).sum();
                    let (middle, i) = (sum / near.len() as f64, v as usize);
                    if let Some(q) = nearest(self.leaves, &self.on[i], middle, self.reach[i], self.scale) {
                        before.entry(v).or_insert(self.places[i]);
                        self.places[i] = q;
                    }
                }
                let touched: BTreeSet<u32> = before.keys().flat_map(star).collect();
                bad = touched.into_iter().filter(|t| self.is_bad(&triangles[*t as usize])).collect();
                if bad.is_empty() {
                    break;
                }
            }
            let touched: BTreeSet<u32> = before.keys().flat_map(star).collect();
            let bad_now = |this: &Self| touched.iter().filter(|t| this.is_bad(&triangles[**t as usize])).count();
            let after = bad_now(self);
            let moved: Vec<(u32, DVec3)> = before.keys().map(|v| (*v, self.places[*v as usize])).collect();
            before.iter().for_each(|(v, p)| self.places[*v as usize] = *p);
            if after < bad_now(self) {
                moved.iter().for_each(|(v, p)| self.places[*v as usize] = *p);
            }
        }
        Ok(())
    }

    fn relax(&mut self, v: u32, stars: &Stars<'_>) {
        let which = &self.on[v as usize];
        if which.len() > 2 || self.stay.binary_search(&v).is_ok() {
            return;
        }
        let (triangles, around) = (stars.triangles, &stars.around[v as usize]);
        // The middle of the neighbors that lie on all that it lies on.
        let with_all = |u: &u32| *u != v && which.iter().all(|l| self.on[*u as usize].contains(l));
        let mut near: Vec<u32> = around.iter().flat_map(|t| triangles[*t as usize].nodes).filter(with_all).collect();
        if near.is_empty() {
            return;
        }
        if let Some(common) = self.common {
            // Sums are rounded by their order, and that of triangles is another in the block beside.
            near.sort_by_key(|u| common.names[*u as usize]);
        }
        let sum: DVec3 = near.iter().map(|u| self.places[*u as usize]).sum();
        let count = near.len() as f64;
        let worst = |p| around.iter().map(|t| self.lies(&triangles[*t as usize], v, p)).fold(f64::INFINITY, f64::min);
        let from = self.places[v as usize];
        let mut best = (worst(from), from);
        for share in [1.0, 0.5, 0.25] {
            let p = from + (sum / count - from) * share;
            if let Some(q) = nearest(self.leaves, which, p, self.reach[v as usize], self.scale) {
                let w = worst(q);
                if w > best.0 {
                    best = (w, q);
                }
            }
        }
        self.places[v as usize] = best.1;
    }
}
