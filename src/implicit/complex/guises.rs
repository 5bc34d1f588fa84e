//! Patches that only linear interpolants show: where two surfaces run beside each other, closer than the interpolants are to them, a
//! patch of one may show within the other although the true surfaces do not meet there.
//!
//! All of its border has gone astray then, as no point near is on both, or it has come together on the line where they touch. On the
//! other surface its nodes are where that bounds the solid, which is asked of the tree.

use std::collections::BTreeSet;

use glam::DVec3;

use super::super::leaf::Leaf;
use super::super::newton::nearest;
use super::super::tape::Tape;
use super::assemble::{Triangle, sides};
use super::settle::FLAT;
use super::uncrossed::Boundary;

/// A patch that is hidden where surfaces touch has at most so many triangles: a few tetrahedra show it, and a larger one would be seen in
/// smaller cells.
const MOST_HIDDEN: usize = 64;

/// What patches are looked for in.
pub(super) struct Guises<'a> {
    pub(super) leaves: &'a [Leaf],
    pub(super) tape: &'a Tape,
    /// Where linear interpolants have the nodes.
    pub(super) linear: &'a [DVec3],
    /// The sizes of the tetrahedra that nodes were made in.
    pub(super) reach: &'a [f64],
    /// The size of the part.
    pub(super) scale: f64,
}

/// What patches are looked for from.
#[derive(Clone, Copy)]
pub(super) enum Seeds {
    /// Triangles with nodes that have gone astray.
    Astray,
    /// Triangles that have come together or are turned over.
    Turned,
}

/// A patch that is to be another leaf's.
struct Other {
    triangles: Vec<u32>,
    /// A triangle of the other leaf beside it.
    beside: u32,
    /// Nodes with their places on the other leaf.
    moved: Vec<(u32, DVec3)>,
}

impl Guises<'_> {
    /// Gives such patches to the surfaces around them. Nodes that were astray on their borders no longer are.
    pub(super) fn lift(&self, of: &mut Boundary, seeds: Seeds) {
        let Boundary { places, on, triangles, astray, .. } = of;
        let mut lost = vec![false; places.len()];
        astray.iter().for_each(|v| lost[*v as usize] = true);
        let is_seed = |t: &Triangle| match seeds {
            Seeds::Astray => t.nodes.iter().any(|v| lost[*v as usize]),
            Seeds::Turned => self.is_turned(t, places),
        };
        let first: Vec<u32> = (0..triangles.len() as u32).filter(|t| is_seed(&triangles[*t as usize])).collect();
        if first.is_empty() {
            return;
        }
        let mut found = Vec::new();
        for patch in patches(triangles, &first) {
            let Some(around) = around(&patch, triangles) else { continue };
            let of = &triangles[around as usize];
            let moved = match seeds {
                Seeds::Astray => self.astray(&patch, of, &Known { places, on, lost: &lost, triangles }),
                Seeds::Turned => self.hidden(&patch, of, on, triangles),
            };
            found.extend(moved.map(|moved| Other { triangles: patch.triangles, beside: around, moved }));
        }
        for other in found {
            let Triangle { leaf, plus, face, .. } = triangles[other.beside as usize];
            for t in other.triangles {
                let t = &mut triangles[t as usize];
                (t.leaf, t.plus, t.face) = (leaf, plus, face);
            }
            for (v, q) in other.moved {
                (places[v as usize], on[v as usize], lost[v as usize]) = (q, vec![leaf], false);
            }
        }
        astray.retain(|v| lost[*v as usize]);
    }

    /// Whether a triangle is on its edge or turned over, beside where it was.
    fn is_turned(&self, t: &Triangle, places: &[DVec3]) -> bool {
        let area = |at: &[DVec3]| {
            let [a, b, c] = t.nodes.map(|v| at[v as usize]);
            let long = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            ((b - a).cross(c - a), long)
        };
        let ((before, _), (after, long)) = (area(self.linear), area(places));
        after.length() < FLAT * long || before.dot(after) < FLAT * before.length() * after.length()
    }

    /// The nodes of a patch on the leaf around it, if its border has gone astray and that leaf bounds the solid there.
    fn astray(&self, patch: &LeafPatch, of: &Triangle, known: &Known<'_>) -> Option<Vec<(u32, DVec3)>> {
        let Known { places, on, lost, triangles } = *known;
        let own = triangles[patch.triangles[0] as usize].leaf;
        let mut moved = Vec::new();
        for v in nodes_of(patch, triangles) {
            let i = v as usize;
            let is_own = on[i][..] == [own];
            let between = on[i].len() == 2 && on[i].contains(&own) && on[i].contains(&of.leaf) && lost[i];
            if !is_own && !between {
                return None;
            }
            let q = nearest(self.leaves, &[of.leaf], places[i], self.reach[i], self.scale)?;
            if self.tape.active(self.leaves, q).leaf != of.leaf {
                return None;
            }
            moved.push((v, q));
        }
        Some(moved)
    }

    /// The nodes of a patch on the leaf around it, if in the middles of all its triangles, where linear interpolants had them, that leaf
    /// bounds the solid, and its own does not.
    fn hidden(
        &self,
        patch: &LeafPatch,
        of: &Triangle,
        on: &[Vec<u32>],
        triangles: &[Triangle],
    ) -> Option<Vec<(u32, DVec3)>> {
        let own = triangles[patch.triangles[0] as usize].leaf;
        let bounds = |leaf: u32, p: DVec3, reach: f64| {
            let q = nearest(self.leaves, &[leaf], p, reach, self.scale)?;
            Some(self.tape.active(self.leaves, q).leaf == leaf)
        };
        let is_hidden = |t: &u32| {
            let nodes = triangles[*t as usize].nodes.map(|v| v as usize);
            let middle = nodes.iter().map(|i| self.linear[*i]).sum::<DVec3>() / 3.0;
            let reach = nodes.iter().map(|i| self.reach[*i]).fold(0.0, f64::max);
            bounds(of.leaf, middle, reach) == Some(true) && bounds(own, middle, reach) != Some(true)
        };
        let nodes = nodes_of(patch, triangles);
        let of_both = |v: &u32| on[*v as usize].iter().all(|l| *l == own || *l == of.leaf);
        if patch.triangles.len() > MOST_HIDDEN || !nodes.iter().all(of_both) || !patch.triangles.iter().all(is_hidden) {
            return None;
        }
        let there = |v: u32| {
            let i = v as usize;
            Some((v, nearest(self.leaves, &[of.leaf], self.linear[i], self.reach[i], self.scale)?))
        };
        nodes.into_iter().map(there).collect()
    }
}

/// What is known of nodes and triangles.
struct Known<'a> {
    places: &'a [DVec3],
    on: &'a [Vec<u32>],
    lost: &'a [bool],
    triangles: &'a [Triangle],
}

fn nodes_of(patch: &LeafPatch, triangles: &[Triangle]) -> BTreeSet<u32> {
    patch.triangles.iter().flat_map(|t| triangles[*t as usize].nodes).collect()
}

/// A triangle beside a patch, if all of these are of one leaf.
fn around(patch: &LeafPatch, triangles: &[Triangle]) -> Option<u32> {
    let beside = *patch.beside.first()?;
    let of = &triangles[beside as usize];
    let is_alike = |t: &u32| triangles[*t as usize].leaf == of.leaf && triangles[*t as usize].plus == of.plus;
    patch.beside.iter().all(is_alike).then_some(beside)
}

/// Triangles of one leaf that hang together, and those of other leaves beside them.
struct LeafPatch {
    triangles: Vec<u32>,
    beside: Vec<u32>,
}

/// The patches of some triangles.
fn patches(triangles: &[Triangle], seeds: &[u32]) -> Vec<LeafPatch> {
    let mut beside = vec![[u32::MAX; 3]; triangles.len()];
    for pair in sides(triangles).chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, s), (_, o)] = pair {
            beside[(s / 3) as usize][(s % 3) as usize] = o / 3;
            beside[(o / 3) as usize][(o % 3) as usize] = s / 3;
        }
    }
    let mut seen = vec![false; triangles.len()];
    let mut found = Vec::new();
    for &first in seeds {
        if std::mem::replace(&mut seen[first as usize], true) {
            continue;
        }
        let leaf = triangles[first as usize].leaf;
        let (mut patch, mut around) = (vec![first], BTreeSet::new());
        let mut k = 0;
        while k < patch.len() {
            for u in beside[patch[k] as usize].into_iter().filter(|u| *u != u32::MAX) {
                if triangles[u as usize].leaf != leaf {
                    around.insert(u);
                } else if !std::mem::replace(&mut seen[u as usize], true) {
                    patch.push(u);
                }
            }
            k += 1;
        }
        found.push(LeafPatch { triangles: patch, beside: around.into_iter().collect() });
    }
    found
}
