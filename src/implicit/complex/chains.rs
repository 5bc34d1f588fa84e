//! Curves where two surfaces meet are followed one way: nodes on them that Newton's method brought past each other change places.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::lockstep;
use super::super::newton::nearest;
use super::assemble::{Triangle, sides};
use super::settle::{Nodes, SWEEPS};
use crate::error::Result;
use crate::numeric::{EIGHT_DIGITS, Sets};
use crate::run::Run;

/// An edge between two leaves, as the triangle of the lower one runs along it.
struct Link {
    ends: [u32; 2],
    leaves: [u32; 2],
    /// Whether the leaves' positive sides are inside.
    plus: [bool; 2],
}

/// The edges between leaves, grouped into curves from corner to corner.
struct Links {
    all: Vec<Link>,
    /// The number of each one's curve.
    curve: Vec<u32>,
    /// The two links of nodes within curves.
    of_node: FxHashMap<u32, [u32; 2]>,
}

impl Links {
    fn new(on: &[Vec<u32>], triangles: &[Triangle]) -> Self {
        let all = links(on, triangles);
        let mut of_node: FxHashMap<u32, [u32; 2]> = FxHashMap::default();
        let mut ends: Vec<[u32; 2]> = (0..).zip(&all).flat_map(|(i, l)| l.ends.map(|v| [v, i])).collect();
        ends.sort_unstable();
        let mut sets = Sets::new(all.len());
        for of_one in ends.chunk_by(|a, b| a[0] == b[0]) {
            if let &[[v, i], [_, k]] = of_one
                && on[v as usize].len() == 2
                && all[i as usize].leaves == all[k as usize].leaves
            {
                sets.join(i, k);
                of_node.insert(v, [i, k]);
            }
        }
        let curve = sets.numbers().0;
        Self { all, curve, of_node }
    }

    /// The nodes before and after one within a curve.
    fn beside(&self, v: u32) -> Option<[u32; 2]> {
        let links = self.of_node.get(&v)?;
        Some(links.map(|i| self.all[i as usize].ends.into_iter().find(|u| *u != v).unwrap_or(v)))
    }
}

/// Edges whose triangles are of two leaves, ascending by their nodes.
fn links(on: &[Vec<u32>], triangles: &[Triangle]) -> Vec<Link> {
    let is_border = |ends: [u32; 2]| ends.iter().all(|v| on[*v as usize].len() > 1);
    let link = |pair: &[([u32; 2], u32)]| {
        let &[(ends, s), (_, o)] = pair else { return None };
        let leaf = |side: u32| triangles[(side / 3) as usize].leaf;
        let mut both = [s, o];
        both.sort_by_key(|side| leaf(*side));
        let [one, other] = both.map(|side| &triangles[(side / 3) as usize]);
        let ends = if one.nodes[(both[0] % 3) as usize] == ends[0] { ends } else { [ends[1], ends[0]] };
        let link = Link { ends, leaves: [one.leaf, other.leaf], plus: [one.plus, other.plus] };
        (one.leaf != other.leaf && is_border(ends)).then_some(link)
    };
    sides(triangles).chunk_by(|a, b| a.0 == b.0).filter_map(link).collect()
}

impl Nodes<'_> {
    /// How far a link goes along the curve of its leaves, if its nodes are at some places: a share of its length, with the sign of a curve
    /// that is convex.
    fn goes_along(&self, link: &Link, places: &[DVec3]) -> f64 {
        let [a, b] = link.ends.map(|v| places[v as usize]);
        let out = |k: usize| {
            let n = self.leaves[link.leaves[k] as usize].slope((a + b) / 2.0).normalize_or_zero();
            if link.plus[k] { -n } else { n }
        };
        let way = out(0).cross(out(1));
        // At a smaller angle slopes, rounded as they are, do not tell.
        if way.length() > EIGHT_DIGITS { (b - a).normalize_or_zero().dot(way.normalize()) } else { 0.0 }
    }

    /// Has curves go on where they go back: nodes of edges that do move to the middle of their neighbors on the curve, all at once. Which way
    /// is on is told by where linear interpolants had the nodes. Curves that this does not help stay as they are.
    ///
    /// Errors: cancellation.
    pub(super) fn straighten(&mut self, linear: &[DVec3], triangles: &[Triangle], run: &Run) -> Result<()> {
        let links = Links::new(self.on, triangles);
        let numbers: Vec<usize> = (0..links.all.len()).collect();
        let ways = lockstep::each(self.leaves, &numbers, |i| {
            [linear, &self.places].map(|places| self.goes_along(&links.all[*i], places))
        });
        let count = links.curve.iter().max().map_or(0, |c| *c as usize + 1);
        let (mut on, mut members) = (vec![0.0; count], vec![Vec::new(); count]);
        for (i, way) in ways.iter().enumerate() {
            let curve = links.curve[i] as usize;
            on[curve] += way[0];
            members[curve].push(i as u32);
        }
        for (curve, members) in members.iter().enumerate() {
            if members.iter().any(|i| ways[*i as usize][1] * on[curve] < 0.0) {
                run.check()?;
                self.put_in_order(&links, members, on[curve]);
            }
        }
        Ok(())
    }

    /// Puts nodes of one curve in order, if it can be done; `on` has the sign of edges that go on.
    fn put_in_order(&mut self, links: &Links, members: &[u32], on: f64) {
        let backward = |this: &Self| -> Vec<u32> {
            let goes_back = |i: &u32| this.goes_along(&links.all[*i as usize], &this.places) * on < 0.0;
            members.iter().copied().filter(goes_back).collect()
        };
        let mut nodes: Vec<u32> = members.iter().flat_map(|i| links.all[*i as usize].ends).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let before: Vec<DVec3> = nodes.iter().map(|v| self.places[*v as usize]).collect();
        let mut back = backward(self);
        let first = back.len();
        for _ in 0..SWEEPS {
            let mut moving: Vec<u32> = back.iter().flat_map(|i| links.all[*i as usize].ends).collect();
            moving.sort_unstable();
            moving.dedup();
            for v in moving {
                let Some([a, b]) = links.beside(v) else { continue };
                let middle = (self.places[a as usize] + self.places[b as usize]) / 2.0;
                let v = v as usize;
                if let Some(q) = nearest(self.leaves, &self.on[v], middle, self.reach[v], self.scale) {
                    self.places[v] = q;
                }
            }
            back = backward(self);
            if back.is_empty() {
                break;
            }
        }
        if back.len() >= first {
            nodes.iter().zip(before).for_each(|(v, p)| self.places[*v as usize] = p);
        }
    }
}
