//! Work on each patch alone, in parallel, its border fixed; large patches in parts.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::patchwork::{Patchwork, PieceSet};
use super::remesher::{Rank, Remesher};
use super::stages::Reached;
use crate::error::Result;
use crate::mesh::edit::{NONE, Regions};
use crate::mesh::{EditMesh, TriMesh};
use crate::spatial::Aabb;

/// A patch after the work.
struct Done {
    mesh: EditMesh,
    /// The node of the whole mesh, for those of the border.
    nodes: Vec<u32>,
    sets: Vec<PieceSet>,
    own: Vec<f64>,
    want: Vec<f64>,
    open: Vec<bool>,
}

/// Patches that ask for more nodes than this are worked on in parts of no more. It is a share that one thread takes, and
/// large beside what lies along the cuts, which is worked on twice.
const LARGE: f64 = 6000.0;

/// Edges around a cut within which patches are worked on again.
pub(crate) const BAND: usize = 4;

/// Rounds of splitting edges that would fall together: a loop of two edges takes two.
pub(super) const CHORD_ROUNDS: usize = 4;

/// An edge of a patch that might fall together with another.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Chord {
    /// Nodes of the whole mesh; those inside patches are numbered beyond.
    ends: [u64; 2],
    /// Whether the edge runs through the patch; those of borders sort first, and stay.
    through: bool,
    part: usize,
    local: [u32; 2],
}

impl Done {
    /// What is left of a part, without the room it took to work on it.
    fn new(mut r: Remesher<'_>, nodes: &[u32]) -> Self {
        let alive: Vec<usize> = r.work.mesh.nodes().map(|v| v as usize).collect();
        r.work.mesh.compact();
        Self {
            nodes: alive.iter().map(|&v| nodes.get(v).copied().unwrap_or(NONE)).collect(),
            sets: alive.iter().map(|&v| r.work.sets[v]).collect(),
            own: alive.iter().map(|&v| r.own[v]).collect(),
            want: alive.iter().map(|&v| r.want[v]).collect(),
            open: alive.iter().map(|&v| r.open.get(v).copied().unwrap_or(false)).collect(),
            mesh: r.work.mesh,
        }
    }

    fn chords(&self, part: usize, found: &mut Vec<Chord>) {
        let m = &self.mesh;
        let mut border: Vec<u32> = m.nodes().filter(|&v| m.is_boundary(v)).map(|v| self.nodes[v as usize]).collect();
        border.sort_unstable();
        let copies: Vec<u32> = border.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]).collect();
        let key = |v: u32| {
            if m.is_boundary(v) { u64::from(self.nodes[v as usize]) } else { (part as u64 + 1) << 32 | u64::from(v) }
        };
        let copied = |v: u32| m.is_boundary(v) && copies.binary_search(&self.nodes[v as usize]).is_ok();
        for h in (0..3 * m.triangle_capacity() as u32).filter(|&h| m.is_triangle(h / 3)) {
            let (a, b) = (m.origin(h), m.target(h));
            let through = m.opposite(h) != NONE;
            let both = m.is_boundary(a) && m.is_boundary(b);
            if !through || (m.is_edge(h) && (both || copied(a) || copied(b))) {
                let (x, y) = (key(a), key(b));
                found.push(Chord { ends: [x.min(y), x.max(y)], through, part, local: [a, b] });
            }
        }
    }
}

impl Remesher<'_> {
    /// Does `work` on every patch as a mesh of its own, whose boundary must stay as it is, and joins the results. The
    /// result does not depend on the number of threads.
    pub(super) fn each_patch(&mut self, work: impl Fn(&mut Remesher<'_>) -> Result<()> + Sync) -> Result<()> {
        let regions = Regions::new(&self.work.mesh, self.labels(), self.work.patches.len());
        self.each_region(&regions, 0, false, work)
    }

    /// The same for work that replaces the nodes inside. Large patches are cut into parts, whose nodes on the cuts are
    /// [open](Self::open) at first; then what lies along the cuts is worked on once more.
    pub(super) fn each_part(&mut self, work: impl Fn(&mut Remesher<'_>) -> Result<()> + Sync) -> Result<()> {
        let patches = self.work.patches.len();
        let mut of = self.labels();
        let count = self.cut_large(&mut of);
        let regions = Regions::new(&self.work.mesh, of, count);
        let (run, ended, all) = (self.run, AtomicUsize::new(0), regions.count().max(1) as f64);
        let told = |r: &mut Remesher<'_>| {
            work(r)?;
            let share = (ended.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all;
            let [from, to] = [Reached::Borders, Reached::Packed].map(Reached::share);
            run.progress("remesh", from + share * (to - from));
            Ok(())
        };
        self.each_region(&regions, 0, true, told)?;
        if count == patches {
            return Ok(());
        }
        let m = &self.work.mesh;
        let mut near = std::mem::take(&mut self.open);
        // Others work along the ends.
        m.nodes().filter(|&v| m.is_boundary(v)).for_each(|v| near[v as usize] = false);
        for _ in 1..BAND {
            let front: Vec<u32> = m.nodes().filter(|&v| near[v as usize]).collect();
            front.iter().for_each(|&v| m.neighbors(v).for_each(|x| near[x as usize] = true));
        }
        let mut of = self.labels();
        for t in m.triangles().filter(|&t| m.corners(t).into_iter().any(|v| near[v as usize])) {
            of[t as usize] += patches as u32;
        }
        let regions = Regions::new(m, of, 2 * patches);
        self.each_region(&regions, patches as u32, false, work)
    }

    /// Whether a node lies at an open edge, and on no border between patches.
    fn ends_inside(&self, v: u32) -> bool {
        self.work.policy.goes_on && self.work.mesh.is_boundary(v) && self.work.mesh.sharp_neighbors(v).next().is_none()
    }

    /// The label of every triangle.
    fn labels(&self) -> Vec<u32> {
        let m = &self.work.mesh;
        let mut of = vec![0; m.triangle_capacity()];
        m.triangles().for_each(|t| of[t as usize] = m.label(t));
        of
    }

    /// Gives the triangles of large patches other numbers, part by part, and returns how many numbers there are.
    fn cut_large(&self, of: &mut [u32]) -> usize {
        let m = &self.work.mesh;
        let mut asked = vec![0.0; self.work.patches.len()];
        let nodes = |t: u32| m.area_vector(t).length() / (3f64.sqrt() * self.want[m.corners(t)[0] as usize].powi(2));
        m.triangles().for_each(|t| asked[m.label(t) as usize] += nodes(t));
        let mut count = asked.len();
        for label in (0..asked.len() as u32).filter(|&l| asked[l as usize] > LARGE && !self.work.stays(l)) {
            let middle = |t: u32| m.corner_points(t).into_iter().sum::<DVec3>() / 3.0;
            let triangles = m.triangles().filter(|&t| m.label(t) == label);
            let mut parts = vec![triangles.map(|t| (middle(t), nodes(t), t)).collect::<Vec<_>>()];
            let mut first = true;
            while let Some(mut part) = parts.pop() {
                let sum: f64 = part.iter().map(|x| x.1).sum();
                if sum > LARGE && part.len() > 1 {
                    let size = Aabb::around(part.iter().map(|x| x.0)).size();
                    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
                    part.sort_unstable_by(|a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.2.cmp(&b.2)));
                    let mut before = 0.0;
                    let half = part.iter().position(|x| {
                        before += x.1;
                        before > 0.5 * sum
                    });
                    let other = part.split_off(half.unwrap_or(0).clamp(1, part.len() - 1));
                    parts.extend([other, part]);
                    continue;
                }
                // The first part keeps the patch's own number.
                if !std::mem::take(&mut first) {
                    part.iter().for_each(|x| of[x.2 as usize] = count as u32);
                    count += 1;
                }
            }
        }
        count
    }

    /// Does `work` on the regions from number `from` on, with nodes on cuts [open](Self::open) if so asked.
    fn each_region(
        &mut self,
        regions: &Regions,
        from: u32,
        open: bool,
        work: impl Fn(&mut Remesher<'_>) -> Result<()> + Sync,
    ) -> Result<()> {
        let this = &*self;
        let one = |region: u32| {
            let mut alone = this.alone(region, regions, open);
            let label = regions.triangles(region).first().map(|&t| this.work.mesh.label(t));
            if label.is_some_and(|label| region >= from && !this.work.stays(label)) {
                work(&mut alone.0)?;
            }
            Ok(Done::new(alone.0, &alone.1))
        };
        let done: Vec<Result<Done>> = self.run.install(|| (0..regions.count()).into_par_iter().map(one).collect());
        let mut done: Vec<Done> = done.into_iter().collect::<Result<_>>()?;
        self.part_chords(&mut done);
        self.join(done)
    }

    fn alone(&self, region: u32, regions: &Regions, open: bool) -> (Remesher<'_>, Vec<u32>) {
        let part = self.work.mesh.part(region, regions);
        let pick = |list: &[f64]| part.nodes.iter().map(|&v| list[v as usize]).collect();
        let rank = (0..part.nodes.len() as u32)
            .map(|v| if part.mesh.is_boundary(v) || part.mesh.is_pinned(v) { Rank::Corner } else { Rank::Face })
            .collect();
        // Nodes of borders between patches have a rank of their own.
        let within = |v: u32| self.rank[part.nodes[v as usize] as usize] == Rank::Face;
        // Rows that left a ragged end would be no better than it is, all the way to the next border.
        let ends = |v: u32| self.work.policy.made_anew > 0 && self.ends_inside(part.nodes[v as usize]);
        let cut = |v: u32| part.mesh.is_boundary(v) && (open && within(v) || ends(v));
        let open = (0..part.nodes.len() as u32).map(cut).collect();
        let r = Remesher {
            surface: self.surface,
            own: pick(&self.own),
            want: pick(&self.want),
            rank,
            tips: Vec::new(),
            tips_spaced: false,
            alone: true,
            open,
            focus: None,
            shapes: Vec::new(),
            options: self.options,
            run: self.run,
            work: Patchwork {
                mesh: part.mesh,
                sets: part.nodes.iter().map(|&v| self.work.sets[v as usize]).collect(),
                sizes: Vec::new(),
                patches: self.work.patches.clone(),
                lines_from: self.work.lines_from,
                frozen: Vec::new(),
                thawed: Vec::new(),
                policy: self.work.policy.of_part(),
            },
        };
        (r, part.nodes)
    }

    /// Splits edges that would fall together with others when the patches are joined: those that join two border nodes
    /// through a patch where another patch, or the border, joins the same two, and those at the several copies a patch
    /// has of a node it touches from several sides.
    fn part_chords(&self, parts: &mut [Done]) {
        for _ in 0..CHORD_ROUNDS {
            let mut edges: Vec<Chord> = Vec::new();
            for (k, part) in parts.iter().enumerate() {
                part.chords(k, &mut edges);
            }
            edges.sort_unstable();
            let mut split: Vec<&Chord> =
                edges.windows(2).filter(|w| w[0].ends == w[1].ends && w[1].through).map(|w| &w[1]).collect();
            split.extend(edges.iter().filter(|e| e.ends[0] == e.ends[1]));
            if split.is_empty() {
                return;
            }
            for chord in split {
                self.split_chord(&mut parts[chord.part], chord.local);
            }
        }
    }

    fn split_chord(&self, part: &mut Done, [a, b]: [u32; 2]) {
        let Some(h) = part.mesh.edge_between(a, b).filter(|&h| part.mesh.opposite(h) != NONE) else { return };
        let set = PieceSet::one(self.work.patches[part.mesh.label(h / 3) as usize].piece);
        let middle = 0.5 * (part.mesh.point(a) + part.mesh.point(b));
        let reach = part.mesh.edge_length(h);
        let p = self.work.settle(self.surface, &set, middle, reach).unwrap_or(middle);
        part.mesh.split_edge(h, p);
        part.sets.push(set);
        for list in [&mut part.own, &mut part.want] {
            let mean = 0.5 * (list[a as usize] + list[b as usize]);
            list.push(mean);
        }
    }

    /// Makes one mesh of the parts. Of the mesh before, and of each part once it is read, nothing is kept.
    fn join(&mut self, parts: Vec<Done>) -> Result<()> {
        let mut whole = TriMesh::default();
        let (mut sets, mut own, mut want, mut pinned) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut borders, mut open, mut changes) = (Vec::new(), Vec::new(), Vec::new());
        let mut shared = vec![NONE; self.work.mesh.node_capacity()];
        let mut number = Vec::new();
        for part in parts {
            number.clear();
            number.resize(part.mesh.node_capacity(), NONE);
            for v in part.mesh.nodes() {
                let border = part.mesh.is_boundary(v);
                let known = if border { shared[part.nodes[v as usize] as usize] } else { NONE };
                if known != NONE {
                    number[v as usize] = known;
                    continue;
                }
                let id = whole.nodes.len() as u32;
                number[v as usize] = id;
                if border {
                    shared[part.nodes[v as usize] as usize] = id;
                }
                whole.nodes.push(part.mesh.point(v));
                sets.push(part.sets[v as usize]);
                own.push(part.own[v as usize]);
                want.push(part.want[v as usize]);
                pinned.push(part.mesh.is_pinned(v));
                changes.push(if border { u8::MAX } else { part.mesh.changes(v) });
                open.push(part.open.get(v as usize).copied().unwrap_or(false));
            }
            for h in part.mesh.edges().filter(|&h| part.mesh.opposite(h) == NONE) {
                let ends = [part.mesh.origin(h), part.mesh.target(h)];
                // Both ends of a cut may lie on a border, too.
                let [a, b] = ends.map(|v| part.nodes[v as usize]);
                let m = &self.work.mesh;
                let open = self.work.policy.goes_on;
                let cut = m.edge_between(a, b).is_some_and(|h| (open || m.opposite(h) != NONE) && !m.is_sharp(h));
                if !cut {
                    borders.push(ends.map(|v| number[v as usize]));
                }
            }
            for t in part.mesh.triangles() {
                whole.triangles.push(part.mesh.corners(t).map(|v| number[v as usize]));
                whole.labels.push(part.mesh.label(t));
            }
        }
        self.work.mesh = EditMesh::new(&TriMesh::default())?;
        let mut mesh = EditMesh::new(&whole)?;
        drop(whole);
        for [a, b] in borders {
            if let Some(h) = mesh.edge_between(a, b) {
                mesh.set_sharp(h, true);
            }
        }
        (0..pinned.len()).filter(|&v| pinned[v]).for_each(|v| mesh.set_pinned(v as u32, true));
        changes.into_iter().zip(0..).for_each(|(c, v)| mesh.set_changes(v, c));
        (self.work.mesh, self.work.sets, self.work.sizes) = (mesh, sets, Vec::new());
        (self.own, self.want, self.open) = (own, want, open);
        self.rank = (0..self.want.len() as u32).map(|v| self.rank_of(v)).collect();
        Ok(())
    }
}
