//! Patches that only linear interpolants show: where two surfaces run beside each other, closer than the interpolants are to them, a
//! patch of one may show within the other although the true surfaces do not meet there.
//!
//! All of its border has gone astray then: no point near is on both. On the other surface its nodes are where that bounds the solid,
//! which is asked of the tree.

use std::collections::BTreeSet;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::leaf::Leaf;
use super::super::newton::nearest;
use super::super::tape::Tape;
use super::assemble::Triangle;

/// What patches are looked for in.
pub(super) struct Guises<'a> {
    pub(super) leaves: &'a [Leaf],
    pub(super) tape: &'a Tape,
    /// The sizes of the tetrahedra that nodes were made in.
    pub(super) reach: &'a [f64],
    /// The size of the part.
    pub(super) scale: f64,
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
    pub(super) fn lift(
        &self,
        places: &mut [DVec3],
        on: &mut [Vec<u32>],
        triangles: &mut [Triangle],
        astray: &mut Vec<u32>,
    ) {
        if astray.is_empty() {
            return;
        }
        let mut lost = vec![false; places.len()];
        astray.iter().for_each(|v| lost[*v as usize] = true);
        let mut found = Vec::new();
        for patch in patches(triangles, &lost) {
            found.extend(self.judged(patch, places, on, triangles, &lost));
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

    /// The patch as one of the leaf around it, if there is one such leaf, its border has gone astray, and the leaf bounds the solid there.
    fn judged(
        &self,
        patch: LeafPatch,
        places: &[DVec3],
        on: &[Vec<u32>],
        triangles: &[Triangle],
        lost: &[bool],
    ) -> Option<Other> {
        let beside = *patch.beside.first()?;
        let of = &triangles[beside as usize];
        let is_alone = |t: &u32| triangles[*t as usize].leaf == of.leaf && triangles[*t as usize].plus == of.plus;
        let own = triangles[patch.triangles[0] as usize].leaf;
        if !patch.beside.iter().all(is_alone) {
            return None;
        }
        let nodes: BTreeSet<u32> = patch.triangles.iter().flat_map(|t| triangles[*t as usize].nodes).collect();
        let mut moved = Vec::with_capacity(nodes.len());
        for v in nodes {
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
        Some(Other { triangles: patch.triangles, beside, moved })
    }
}

/// Triangles of one leaf that hang together, and those of other leaves beside them.
struct LeafPatch {
    triangles: Vec<u32>,
    beside: Vec<u32>,
}

/// The patches with nodes that have gone astray, but for those without anything beside.
fn patches(triangles: &[Triangle], lost: &[bool]) -> Vec<LeafPatch> {
    let mut at: FxHashMap<[u32; 2], Vec<u32>> = FxHashMap::default();
    for (t, of) in triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [of.nodes[k], of.nodes[(k + 1) % 3]];
            at.entry([a.min(b), a.max(b)]).or_default().push(t as u32);
        }
    }
    let beside = |t: u32| {
        let nodes = triangles[t as usize].nodes;
        let edges = (0..3).map(move |k| [nodes[k].min(nodes[(k + 1) % 3]), nodes[k].max(nodes[(k + 1) % 3])]);
        edges.flat_map(|e| at[&e].iter().copied()).filter(move |u| *u != t)
    };
    let mut seen = vec![false; triangles.len()];
    let mut found = Vec::new();
    for first in 0..triangles.len() as u32 {
        let nodes = triangles[first as usize].nodes;
        if seen[first as usize] || !nodes.iter().any(|v| lost[*v as usize]) {
            continue;
        }
        let leaf = triangles[first as usize].leaf;
        seen[first as usize] = true;
        let (mut patch, mut around) = (vec![first], BTreeSet::new());
        let mut k = 0;
        while k < patch.len() {
            for u in beside(patch[k]) {
                if triangles[u as usize].leaf != leaf {
                    around.insert(u);
                } else if !seen[u as usize] {
                    seen[u as usize] = true;
                    patch.push(u);
                }
            }
            k += 1;
        }
        found.push(LeafPatch { triangles: patch, beside: around.into_iter().collect() });
    }
    found
}
