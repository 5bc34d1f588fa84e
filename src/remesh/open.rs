//! Some of a surface that goes on in other meshes: remeshed with its ends as they are, so that all fit together again.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::patches::CHORD_ROUNDS;
use super::patchwork::{Patchwork, PieceSet};
use super::remesher::{Remesher, SLIVER};
use super::stages::{AROUND, LAST, POLISH, finish, polish, remesh};
use super::{RemeshOptions, RemeshedMesh, check_options};
use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::mesh::edit::NONE;
use crate::run::Run;

/// Of the edges up to which triangles are made anew so many are polished all the same: nodes of the last row stay, and those of the row
/// before have had their say in where they are.
const KEPT: usize = 2;

/// What a mesh lies on.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Laid {
    /// The piece of each triangle.
    pub pieces: Vec<u32>,
    /// The pieces of each node, ascending.
    pub on: Vec<Vec<u32>>,
}

/// An edge by the places of its ends: nodes at open edges keep theirs.
type Ends = [[u64; 3]; 2];

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// Remeshes some of a surface, made by [`patch_open_pieces`](super::patch_open_pieces); `names` lends the names of faces.
///
/// Guarantees and errors are those of [`remesh_patchwork`](super::remesh_patchwork); nodes at open edges stay, with these edges, and no
/// edge inside joins two of them that none joined before: another mesh beyond may have such an edge.
pub fn remesh_open(
    work: Patchwork,
    names: &TriMesh,
    surface: &dyn Pieces,
    options: &RemeshOptions,
    run: &Run,
) -> Result<(RemeshedMesh, Laid)> {
    check_options(options)?;
    let r = Remesher::new(work, surface, options, run)?;
    let before: FxHashSet<Ends> = r.inner_chords().into_iter().map(|(_, ends)| ends).collect();
    let (mut made, mut r) = run.install(|| remesh(names, r, None))?;
    if run.install(|| part_and_mend(&mut r, &before))? {
        made.mesh = finish(names, &r);
    }
    let m = &r.work.mesh;
    let laid = Laid {
        pieces: m.triangles().map(|t| r.work.patches[m.label(t) as usize].piece).collect(),
        on: m.nodes().map(|v| r.work.sets[v as usize].as_slice().to_vec()).collect(),
    };
    Ok((made, laid))
}

/// Polishes all but what is made anew, where only what is folded is mended: others begin from it.
pub(super) fn polish_beyond_ends(r: &mut Remesher<'_>) -> Result<()> {
    r.look_beyond_ends();
    polish(r, LAST)?;
    r.look_everywhere();
    if r.work.policy.made_anew > 0 {
        r.mend_worst(SLIVER, POLISH)?;
    }
    Ok(())
}

/// Splits edges that others may have, and mends what that leaves. Whether there were any.
fn part_and_mend(r: &mut Remesher<'_>, before: &FxHashSet<Ends>) -> Result<bool> {
    let count = r.work.mesh.node_capacity();
    let mut first = count;
    for last in [false, true] {
        r.part_open_chords(before);
        let capacity = r.work.mesh.node_capacity();
        if capacity == first {
            break;
        }
        r.look_around((0..capacity).map(|v| v >= first).collect(), AROUND);
        first = capacity;
        if r.work.policy.made_anew > 0 {
            // Whoever makes them anew needs them unfolded only.
            if !last {
                r.mend_worst(SLIVER, POLISH)?;
                first = r.work.mesh.node_capacity();
            }
        } else if last {
            // Flips might make such edges again.
            r.relax()?;
            r.raise_angles()?;
        } else {
            polish(r, LAST)?;
            first = r.work.mesh.node_capacity();
        }
    }
    r.look_everywhere();
    Ok(r.work.mesh.node_capacity() > count)
}

impl Remesher<'_> {
    /// Has what follows leave out the nodes that are [made anew](Patchwork::made_anew), if any are; of a part those along its cuts, too.
    pub(super) fn look_beyond_ends(&mut self) {
        let Some(rings) = self.work.policy.made_anew.checked_sub(KEPT) else { return };
        let m = &self.work.mesh;
        let at_end = |v: u32| if self.alone { self.is_open(v) } else { m.is_node(v) && m.is_boundary(v) };
        let ends = (0..m.node_capacity() as u32).map(at_end).collect();
        self.look_around(ends, rings);
        self.focus.iter_mut().flatten().for_each(|sees| *sees = !*sees);
    }

    fn ends(&self, h: u32) -> Ends {
        let m = &self.work.mesh;
        let mut ends = [m.origin(h), m.target(h)].map(|v| bits(m.point(v)));
        ends.sort_unstable();
        ends
    }

    /// Edges inside that join two nodes at open edges.
    fn inner_chords(&self) -> Vec<(u32, Ends)> {
        let m = &self.work.mesh;
        let joins = |h: &u32| m.opposite(*h) != NONE && m.is_boundary(m.origin(*h)) && m.is_boundary(m.target(*h));
        m.edges().filter(joins).map(|h| (h, self.ends(h))).collect()
    }

    /// Splits edges that would fall together with others once the surface is whole: those between nodes at open edges that were
    /// not there before, and those that copies of one node have in common.
    fn part_open_chords(&mut self, before: &FxHashSet<Ends>) {
        for _ in 0..CHORD_ROUNDS {
            let mut split: Vec<u32> = Vec::new();
            let mut seen: FxHashSet<Ends> = FxHashSet::default();
            let m = &self.work.mesh;
            let at_end = |h: &u32| m.is_boundary(m.origin(*h)) || m.is_boundary(m.target(*h));
            // Open edges first: they stay.
            for open in [true, false] {
                for h in m.edges().filter(|h| (m.opposite(*h) == NONE) == open).filter(at_end) {
                    let ends = self.ends(h);
                    let both = m.is_boundary(m.origin(h)) && m.is_boundary(m.target(h));
                    let is_new = !open && both && !before.contains(&ends);
                    if (!seen.insert(ends) && !open) || is_new || ends[0] == ends[1] {
                        split.push(h);
                    }
                }
            }
            if split.is_empty() {
                return;
            }
            let ends: Vec<[u32; 2]> = split.iter().map(|h| [m.origin(*h), m.target(*h)]).collect();
            for [a, b] in ends {
                let m = &self.work.mesh;
                let Some(h) = m.edge_between(a, b).filter(|&h| m.opposite(h) != NONE) else { continue };
                // Ends may both lie on a crease that the edge does not run along.
                let piece = self.work.patches[m.label(h / 3) as usize].piece;
                let set = if m.is_sharp(h) { self.edge_set(h) } else { PieceSet::one(piece) };
                let middle = 0.5 * (m.point(a) + m.point(b));
                let at = self.work.settle(self.surface, &set, middle, m.edge_length(h)).unwrap_or(middle);
                let want = 0.5 * (self.want[a as usize] + self.want[b as usize]);
                self.put_on_edge(h, at, set, want);
            }
        }
    }
}
