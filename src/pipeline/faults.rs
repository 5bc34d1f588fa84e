//! Where a remeshed soup intersects itself or is folded, and what is done there: sizes are halved, or triangles of the input stay.

use glam::DVec3;
use rustc_hash::FxHashSet;

use crate::discrete::Discrete;
use crate::error::Result;
use crate::mesh::edit::NONE;
use crate::mesh::{TriMesh, intersecting_triangles, self_intersections};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};

/// Triangles of the input, by their corners, that touch others: they stay, and nobody else is to blame for it.
#[derive(Default)]
pub(super) struct Touching(FxHashSet<[[u64; 3]; 3]>);

fn corner_bits(corners: [DVec3; 3]) -> [[u64; 3]; 3] {
    let mut bits = corners.map(|p| p.to_array().map(f64::to_bits));
    bits.sort_unstable();
    bits
}

impl Touching {
    pub(super) fn of(mesh: &TriMesh, run: &Run) -> Result<Self> {
        let pairs = self_intersections(mesh, run)?;
        Ok(Self(pairs.into_iter().flatten().map(|t| corner_bits(mesh.corners(t as usize))).collect()))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn keep(&self, kept: &mut [bool], solid: &Discrete) {
        if !self.is_empty() {
            for t in solid.mesh.triangles() {
                kept[t as usize] |= self.0.contains(&corner_bits(solid.mesh.corner_points(t)));
            }
        }
    }

    /// The other triangles of a mesh that intersect some, ascending.
    pub(super) fn others(&self, mesh: &TriMesh, run: &Run) -> Result<Vec<u32>> {
        let mut bad = intersecting_triangles(mesh, run)?;
        bad.retain(|t| !self.0.contains(&corner_bits(mesh.corners(*t as usize))));
        Ok(bad)
    }
}

/// Boxes around triangles that intersect others or are folded, with their lengths.
pub(super) struct Places {
    tree: Bvh,
    lengths: Vec<f64>,
}

impl Places {
    /// The boxes are grown by `reach` of these lengths.
    pub(super) fn new(bad: &[u32], folds: &[Aabb], mesh: &TriMesh, reach: f64) -> Self {
        let mut boxes: Vec<(Aabb, f64)> = Vec::with_capacity(bad.len() + folds.len());
        for t in bad {
            let [a, b, c] = mesh.corners(*t as usize);
            boxes.push((Aabb::around([a, b, c]), a.distance(b).max(b.distance(c)).max(c.distance(a))));
        }
        boxes.extend(folds.iter().map(|b| (*b, b.diagonal())));
        let tree = Bvh::new(boxes.iter().map(|(b, l)| b.grown(reach * l)).collect());
        Self { tree, lengths: boxes.into_iter().map(|b| b.1).collect() }
    }

    /// Has edges be half as long there, but not shorter than `least`. Returns whether that changes anything.
    pub(super) fn halve(&self, sizes: &mut [f64], solid: &Discrete, least: f64) -> bool {
        let before = sizes.to_vec();
        for t in solid.mesh.triangles() {
            self.tree.overlapping(&Aabb::around(solid.mesh.corner_points(t)), |k| {
                let half = (0.5 * self.lengths[k as usize]).max(least);
                for v in solid.mesh.corners(t) {
                    sizes[v as usize] = sizes[v as usize].min(half);
                }
            });
        }
        sizes != before
    }

    /// Has the input's triangles stay there. Returns whether there are more of them now.
    pub(super) fn keep(&self, kept: &mut [bool], solid: &Discrete) -> bool {
        let mut more = false;
        for t in solid.mesh.triangles().filter(|t| !kept[*t as usize]).collect::<Vec<_>>() {
            kept[t as usize] = self.tree.meets(&Aabb::around(solid.mesh.corner_points(t)));
            more |= kept[t as usize];
        }
        more
    }
}

/// Has all triangles of connected parts stay of which some do.
pub(super) fn keep_shells(kept: &mut [bool], solid: &Discrete) {
    let mut list: Vec<u32> = (0..kept.len() as u32).filter(|&t| kept[t as usize]).collect();
    while let Some(t) = list.pop() {
        for h in 3 * t..3 * t + 3 {
            let o = solid.mesh.opposite(h);
            if o != NONE && !kept[(o / 3) as usize] {
                kept[(o / 3) as usize] = true;
                list.push(o / 3);
            }
        }
    }
}
