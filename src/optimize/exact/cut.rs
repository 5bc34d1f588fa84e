//! Cutting a mesh along the borders of the surface's pieces.
//!
//! Every node of the input lies on one piece. An edge between nodes on different pieces runs across a border: it gets a
//! node where the two pieces meet. A triangle with nodes on three pieces holds a corner: it gets a node where the three
//! meet. Then every triangle lies on one piece and every border is a chain of edges, whatever the geometry: the cut is
//! combinatorial and cannot fail. Geometry enters before, where edges whose pieces do not meet near them (a third piece
//! lies between) are split until they do, and after, when the nodes are put exactly where they belong.

use glam::DVec3;

use super::apexes::put_apexes;
use super::bridges::{Parted, part_bridges};
use super::concurrent::straighten_borders;
use super::joints::Pieced;
use super::patchwork::{Patch, Patchwork, PieceSet};
use crate::error::{Error, Result};
use crate::geometry::Pieces;
use crate::mesh::{EditMesh, TriMesh, edit::NONE};
use crate::optimize::guard::ask_all;
use crate::run::Run;

/// Rounds of mending edges without a crossing.
const ROUNDS: usize = 8;
/// The first of them split such edges, to find the piece between: each halves them.
const SPLITS: usize = 4;
/// From the second round on, where so many edges are split, this share of them at least must show a piece between.
const WORTH: (usize, f64) = (64, 0.05);
/// An edge is not split further below this share of the cell.
const SHORTEST: f64 = 0.05;
/// Pieces are looked for this many edge lengths around the point an edge crosses their border.
const REACH: f64 = 2.0;

/// A node this close to a piece, as a share of the cell, counts as on it.
const ON_BORDER: f64 = 1e-6;
/// The same when splitting has not helped: pieces that run this close to each other are told apart no more.
const NEAR_BORDER: f64 = 0.02;
/// Where the pieces of an edge's ends meet lies aside if it is farther from the edge than this share of its length; at a right
/// angle it never is.
const ASIDE: f64 = 0.51;
/// And pieces touch if their directions differ by no more than this (cosine), 18 degrees.
const TOUCHING: f64 = 0.95;
/// An edge passes a corner that is this share of its length away from where it would cross the border.
const PASSES: f64 = 0.5;

/// Where an edge crosses the border of the pieces of its ends, or why that is not known.
#[derive(Debug, Clone, Copy)]
enum Crossing {
    At(DVec3),
    /// Right at a corner, where a third piece passes.
    Corner(DVec3, PieceSet),
    /// The pieces do not meet here, or what meets here is not on the boundary.
    Nowhere,
}

/// What cutting met.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CutReport {
    /// Edges that got a node on a border.
    pub crossings: usize,
    /// Triangles that got a corner.
    pub corners: usize,
    /// Edges split because a third piece lay between their ends.
    pub splits: usize,
    /// Splitting was given up: edges join the two sides of walls or gaps between which there is no piece, and go on to.
    pub bridged: bool,
    /// Places where pieces border on each other in the mesh but no exact meeting point was found.
    pub unresolved: Vec<DVec3>,
}

/// Labels of triangles until the patches are known: those to be cut, and those that stay as they are.
const CUT: u32 = 0;
const KEPT: u32 = 1;

pub(super) struct Cutter<'a> {
    pub(super) mesh: EditMesh,
    pub(super) piece: Vec<u32>,
    /// Nodes at joints, with the pieces that meet there; `piece` has one of them.
    pub(super) joints: Vec<(u32, PieceSet)>,
    pub(super) surface: &'a dyn Pieces,
    pub(super) cell: f64,
    report: CutReport,
}

/// What is to be cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raw<'a> {
    /// A closed, oriented manifold; its nodes lie on the surface.
    pub mesh: &'a TriMesh,
    /// About the distance of its nodes from each other.
    pub cell: f64,
    /// Triangles that stay as they are, by index: they become patches without a piece. None where the list is empty.
    pub kept: &'a [bool],
}

/// Cuts a mesh along all borders of pieces. Where that leaves borders of pieces that do not meet, the mesh is tried without
/// the triangles that join them.
pub fn cut_pieces(raw: &Raw<'_>, surface: &dyn Pieces, run: &Run) -> Result<(Patchwork, CutReport)> {
    if !(raw.cell.is_finite() && raw.cell > 0.0) {
        return Err(Error::Usage(format!("the cell size must be positive, not {}", raw.cell)));
    }
    let first = cut_as_is(raw, surface, run)?;
    if first.1.unresolved.is_empty() {
        return Ok(first);
    }
    let Some(Parted { mesh, kept }) = part_bridges(raw, surface, run)? else { return Ok(first) };
    let second = cut_as_is(&Raw { mesh: &mesh, kept: &kept, ..*raw }, surface, run)?;
    Ok(if second.1.unresolved.len() < first.1.unresolved.len() { second } else { first })
}

fn cut_as_is(raw: &Raw<'_>, surface: &dyn Pieces, run: &Run) -> Result<(Patchwork, CutReport)> {
    let Raw { mesh, cell, kept } = *raw;
    let mut edit = EditMesh::new(mesh)?;
    for t in 0..mesh.triangles.len() as u32 {
        let label = if kept.get(t as usize) == Some(&true) { KEPT } else { CUT };
        edit.set_surface(t, label, DVec3::ZERO);
    }
    let pieces = ask_all(run, edit.node_capacity(), |v| surface.piece_at(edit.point(v)))?;
    let piece: Vec<u32> = pieces.into_iter().map(|p| p.unwrap_or(NONE)).collect();
    let mut cutter = Cutter { mesh: edit, piece, joints: Vec::new(), surface, cell, report: CutReport::default() };
    cutter.put_joints();
    cutter.resolve(run)?;
    cutter.cut(run)
}

impl Cutter<'_> {
    fn differs(&self, a: u32, b: u32) -> bool {
        let (i, j) = (self.piece[a as usize], self.piece[b as usize]);
        let joins = |v: u32, k: u32| self.mesh.is_pinned(v) && self.joints.iter().any(|(w, set)| *w == v && set.has(k));
        i != j && !joins(a, j) && !joins(b, i)
    }

    /// Whether a triangle is to be cut, and does not stay as it is.
    pub(super) fn is_cut(&self, t: u32) -> bool {
        self.mesh.label(t) == CUT
    }

    /// Whether an edge has to get a node where it crosses a border.
    pub(super) fn crosses(&self, h: u32) -> bool {
        let m = &self.mesh;
        let o = m.opposite(h);
        let cut = self.is_cut(h / 3) || (o != NONE && self.is_cut(o / 3));
        cut && self.differs(m.origin(h), m.target(h))
    }

    /// Distance of `p` from a piece, to first order.
    fn away(&self, piece: u32, p: DVec3) -> f64 {
        self.surface.meet(&[piece], p, REACH * self.cell).map_or(self.cell, |q| q.distance(p))
    }

    fn crossing(&self, h: u32) -> Crossing {
        let (a, b) = (self.mesh.origin(h), self.mesh.target(h));
        let (i, j) = (self.piece[a as usize], self.piece[b as usize]);
        if i == NONE || j == NONE {
            return Crossing::Nowhere;
        }
        let (p, q) = (self.mesh.point(a), self.mesh.point(b));
        let (da, db) = (self.away(j, p), self.away(i, q));
        let t = if da + db > 0.0 { da / (da + db) } else { 0.5 };
        let start = p.lerp(q, t);
        let length = p.distance(q).max(SHORTEST * self.cell);
        match self.surface.meet(&[i, j], start, REACH * length) {
            Some(x) if self.surface.bounds(&[i, j], x) => Crossing::At(x),
            Some(x) => self.at_corner(h, [i, j], x),
            None => Crossing::Nowhere,
        }
    }

    /// Whether an edge has another piece than those of its ends at its middle, and where these touch lies aside: they border on
    /// each other there, but not here.
    fn passes_another(&self, h: u32, x: DVec3) -> bool {
        let ends = [self.mesh.origin(h), self.mesh.target(h)];
        let [p, q] = ends.map(|v| self.mesh.point(v));
        let (d, length) = (q - p, p.distance(q));
        let along = (d.dot(x - p) / (length * length)).clamp(0.0, 1.0);
        if !(x.distance(p + along * d) > ASIDE * length) {
            return false;
        }
        // At a sharp edge chords are far from it.
        let [m, n] = ends.map(|v| self.surface.direction(self.piece[v as usize], x).unwrap_or_default());
        if m.dot(n).abs() < TOUCHING {
            return false;
        }
        let middle = self.surface.project(0.5 * (p + q), length).and_then(|f| self.surface.piece_at(f.point));
        middle.is_some_and(|k| ends.iter().all(|v| self.piece[*v as usize] != k))
    }

    /// A corner of the two pieces and a third that the edge passes.
    fn at_corner(&self, h: u32, [i, j]: [u32; 2], x: DVec3) -> Crossing {
        let reach = PASSES * self.mesh.edge_length(h);
        let found = self.surface.near(x).into_iter().filter(|&k| k != i && k != j).find_map(|k| {
            let c = self.surface.meet(&[i, j, k], x, reach)?;
            self.surface.bounds(&[i, j, k], c).then(|| (c, PieceSet::of(&[i, j, k])))
        });
        found.map_or(Crossing::Nowhere, |(c, set)| Crossing::Corner(c, set))
    }

    fn corner(&self, t: u32) -> Crossing {
        let nodes = self.mesh.corners(t);
        let pieces = nodes.map(|v| self.piece[v as usize]);
        if pieces.contains(&NONE) {
            return Crossing::Nowhere;
        }
        let (start, length) = (self.mesh.centroid(t), self.longest(t));
        match self.surface.meet(&pieces, start, REACH * length) {
            Some(x) if self.surface.bounds(&pieces, x) => Crossing::At(x),
            _ => Crossing::Nowhere,
        }
    }

    fn longest(&self, t: u32) -> f64 {
        (3 * t..3 * t + 3).map(|h| self.mesh.edge_length(h)).fold(SHORTEST * self.cell, f64::max)
    }

    pub(super) fn has_three(&self, t: u32) -> bool {
        let [a, b, c] = self.mesh.corners(t);
        self.is_cut(t) && self.differs(a, b) && self.differs(b, c) && self.differs(c, a)
    }

    /// Splits edges and triangles whose pieces do not meet there.
    fn resolve(&mut self, run: &Run) -> Result<()> {
        for round in 0..ROUNDS {
            run.check()?;
            let splitting = round < SPLITS && !self.report.bridged;
            let this = &*self;
            let bad_edges = ask_all(run, 3 * this.mesh.triangle_capacity(), |h| {
                if !(this.mesh.is_edge(h) && this.crosses(h)) || this.mesh.edge_length(h) < SHORTEST * this.cell {
                    return None;
                }
                let found = match this.crossing(h) {
                    Crossing::At(x) => !splitting || !this.passes_another(h, x),
                    Crossing::Corner(..) => true,
                    Crossing::Nowhere => false,
                };
                (!found).then_some(h)
            })?;
            let bad_triangles = ask_all(run, this.mesh.triangle_capacity(), |t| {
                if !this.mesh.is_triangle(t) || !this.has_three(t) {
                    return None;
                }
                let longest = (3 * t..3 * t + 3)
                    .max_by(|a, b| this.mesh.edge_length(*a).total_cmp(&this.mesh.edge_length(*b)))?;
                if this.mesh.edge_length(longest) < SHORTEST * this.cell || matches!(this.corner(t), Crossing::At(_)) {
                    return None;
                }
                Some(longest)
            })?;
            let mut ends: Vec<(u32, u32)> = bad_edges
                .into_iter()
                .chain(bad_triangles)
                .flatten()
                .map(|h| (self.mesh.origin(h), self.mesh.target(h)))
                .map(|(a, b)| (a.min(b), a.max(b)))
                .collect();
            ends.sort_unstable();
            ends.dedup();
            if ends.is_empty() {
                break;
            }
            if self.relabel(&ends, if splitting { ON_BORDER } else { NEAR_BORDER }) > 0 {
                continue;
            }
            if !splitting {
                break;
            }
            let (mut splits, mut between) = (0, 0);
            for (a, b) in ends {
                let Some(h) = self.mesh.edge_between(a, b) else { continue };
                let (p, q) = (self.mesh.point(a), self.mesh.point(b));
                let Some(foot) = self.surface.project(0.5 * (p + q), p.distance(q)) else { continue };
                let (x, piece) = (foot.point, self.surface.piece_at(foot.point).unwrap_or(NONE));
                if x.distance(p).min(x.distance(q)) < 1e-3 * p.distance(q) {
                    continue;
                }
                self.mesh.split_edge(h, x);
                between += usize::from(piece != self.piece[a as usize] && piece != self.piece[b as usize]);
                self.piece.push(piece);
                splits += 1;
            }
            self.report.splits += splits;
            self.report.bridged = round > 0 && splits >= WORTH.0 && (between as f64) < WORTH.1 * splits as f64;
        }
        Ok(())
    }

    /// Nodes that lie on a border may count as on either piece; those at the ends of edges without a crossing are given to
    /// the piece with which fewer of their edges are so. Returns how many changed.
    fn relabel(&mut self, ends: &[(u32, u32)], near: f64) -> usize {
        let mut nodes: Vec<u32> = ends.iter().flat_map(|&(a, b)| [a, b]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut changed = 0;
        for v in nodes.into_iter().filter(|v| self.joints.iter().all(|j| j.0 != *v)).collect::<Vec<_>>() {
            let p = self.mesh.point(v);
            let own = self.piece[v as usize];
            let mut others: Vec<u32> = self.mesh.neighbors(v).map(|x| self.piece[x as usize]).collect();
            others.sort_unstable();
            others.dedup();
            others.retain(|&k| {
                // Where pieces touch they stay near each other far beyond their border.
                let on =
                    |q: DVec3| q.distance(p) <= near * self.cell && (near <= ON_BORDER || self.surface.bounds(&[k], q));
                k != own && k != NONE && self.surface.meet(&[k], p, self.cell).is_some_and(on)
            });
            let mut best = (self.without_crossing(v), own);
            for k in others {
                self.piece[v as usize] = k;
                best = best.min((self.without_crossing(v), k));
            }
            changed += usize::from(best.1 != own);
            self.piece[v as usize] = best.1;
        }
        changed
    }

    /// How many edges of a node run to other pieces without crossing a border.
    fn without_crossing(&self, v: u32) -> usize {
        self.mesh
            .outgoing(v)
            .filter(|&h| self.differs(v, self.mesh.target(h)) && matches!(self.crossing(h), Crossing::Nowhere))
            .count()
    }

    /// The piece a triangle lies on after the cut: that of those of its nodes that lie on one. Beside joints there may be none;
    /// then it is what all of its nodes share, where they share several the one whose plane it is in.
    fn piece_of(&self, t: u32, sets: &[PieceSet]) -> u32 {
        let [a, b, c] = self.mesh.corners(t).map(|v| sets[v as usize]);
        if let Some(one) = [a, b, c].iter().find(|s| s.len() == 1) {
            return one.as_slice()[0];
        }
        let n = self.mesh.area_vector(t).normalize_or_zero();
        let p = self.mesh.centroid(t);
        let along = |k: &u32| self.surface.direction(*k, p).map_or(0.0, |d| d.dot(n).abs());
        let shared = a.as_slice().iter().copied().filter(|k| b.has(*k) && c.has(*k));
        shared.max_by(|x, y| along(x).total_cmp(&along(y)).then(y.cmp(x))).unwrap_or(NONE)
    }

    fn cut(mut self, run: &Run) -> Result<(Patchwork, CutReport)> {
        let this = &self;
        let crossings = ask_all(run, 3 * this.mesh.triangle_capacity(), |h| {
            let crosses = this.mesh.is_edge(h) && this.crosses(h);
            crosses.then(|| (this.mesh.origin(h), this.mesh.target(h), this.crossing(h)))
        })?;
        let corners = ask_all(run, this.mesh.triangle_capacity(), |t| {
            (this.mesh.is_triangle(t) && this.has_three(t)).then(|| (t, this.corner(t)))
        })?;
        let mut sets: Vec<PieceSet> = self.piece.iter().map(|&p| PieceSet::one(p)).collect();
        self.joints.iter().for_each(|(v, set)| sets[*v as usize] = *set);
        for (t, found) in corners.into_iter().flatten() {
            let set = PieceSet::of(&self.mesh.corners(t).map(|v| self.piece[v as usize]));
            let p = match found {
                Crossing::At(p) | Crossing::Corner(p, _) => p,
                Crossing::Nowhere => {
                    let p = self.mesh.centroid(t);
                    self.report.unresolved.push(p);
                    p
                }
            };
            self.mesh.split_triangle(t, p);
            sets.push(set);
            self.report.corners += 1;
        }
        for (a, b, found) in crossings.into_iter().flatten() {
            let Some(h) = self.mesh.edge_between(a, b) else { continue };
            let mut set = PieceSet::of(&[self.piece[a as usize], self.piece[b as usize]]);
            let p = match found {
                Crossing::At(p) => p,
                Crossing::Corner(p, all) => {
                    set = all;
                    p
                }
                Crossing::Nowhere => {
                    let p = 0.5 * (self.mesh.point(a) + self.mesh.point(b));
                    self.report.unresolved.push(p);
                    p
                }
            };
            self.mesh.split_edge(h, p);
            sets.push(set);
            self.report.crossings += 1;
        }
        let mut of_triangle = vec![NONE; self.mesh.triangle_capacity()];
        for t in self.mesh.triangles().filter(|t| self.is_cut(*t)) {
            of_triangle[t as usize] = self.piece_of(t, &sets);
        }
        put_apexes(&mut self.mesh, &mut sets, &mut of_triangle, self.surface, self.cell);
        let patches = patches(&mut self.mesh, &of_triangle, &[], self.surface);
        Ok((Patchwork::new(self.mesh, sets, patches.into()), self.report))
    }
}

/// A mesh whose every triangle lies on the piece that is its label, as a patchwork; `on` has the pieces of each node,
/// `faces` the face of each triangle, or nothing.
///
/// *Errors*: [`Error::Input`] for a mesh that is no oriented manifold.
pub fn patch_pieces(
    mesh: &TriMesh,
    on: &[Vec<u32>],
    faces: &[u32],
    surface: &dyn Pieces,
    cell: f64,
) -> Result<(Patchwork, CutReport)> {
    let mut edit = EditMesh::new(mesh)?;
    let mut sets: Vec<PieceSet> = on.iter().map(|pieces| PieceSet::of(pieces)).collect();
    let mut of_triangle = mesh.labels.clone();
    let mut pieced = Pieced { mesh: &mut edit, sets: &mut sets, of_triangle: &of_triangle, cell };
    pieced.join_corners();
    pieced.pinch(surface);
    put_apexes(&mut edit, &mut sets, &mut of_triangle, surface, cell);
    let patches = patches(&mut edit, &of_triangle, faces, surface);
    straighten_borders(&mut edit, &sets);
    Ok((Patchwork::new(edit, sets, patches.into()), CutReport::default()))
}

/// The same of a mesh beyond whose open edges the surface goes on, in others that have the same nodes there. These are no border
/// between pieces, and stay as they are.
///
/// *Errors*: [`Error::Input`] for a mesh that is no oriented manifold.
pub fn patch_open_pieces(
    mesh: &TriMesh,
    on: &[Vec<u32>],
    faces: &[u32],
    surface: &dyn Pieces,
    cell: f64,
) -> Result<Patchwork> {
    let (mut work, _) = patch_pieces(mesh, on, faces, surface, cell)?;
    work.goes_on = true;
    for h in 0..3 * work.mesh.triangle_capacity() as u32 {
        if work.mesh.is_triangle(h / 3) && work.mesh.opposite(h) == NONE {
            work.mesh.set_sharp(h, false);
        }
    }
    Ok(work)
}

/// Connected regions of triangles on one piece and of one face, where there are `faces`; labels of the triangles become their numbers, and edges between regions
/// are marked sharp.
fn patches(mesh: &mut EditMesh, of_triangle: &[u32], faces: &[u32], surface: &dyn Pieces) -> Vec<Patch> {
    let face = |t: u32| faces.get(t as usize).copied().unwrap_or(NONE);
    let apart = |t: u32, u: u32| of_triangle[t as usize] != of_triangle[u as usize] || face(t) != face(u);
    for h in 0..3 * mesh.triangle_capacity() as u32 {
        if mesh.is_edge(h) {
            let o = mesh.opposite(h);
            let border = o == NONE || apart(h / 3, o / 3);
            mesh.set_sharp(h, border);
        }
    }
    let mut number = vec![NONE; mesh.triangle_capacity()];
    let mut patches = Vec::new();
    let mut stack = Vec::new();
    for first in 0..number.len() as u32 {
        if number[first as usize] != NONE || !mesh.is_triangle(first) {
            continue;
        }
        let id = patches.len() as u32;
        let piece = of_triangle[first as usize];
        let mut facing = 0.0;
        number[first as usize] = id;
        stack.push(first);
        while let Some(t) = stack.pop() {
            if let Some(n) = surface.direction(piece, mesh.centroid(t)) {
                facing += mesh.area_vector(t).dot(n);
            }
            mesh.set_surface(t, id, DVec3::ZERO);
            for h in 3 * t..3 * t + 3 {
                let o = mesh.opposite(h);
                if o != NONE && !mesh.is_sharp(h) && number[(o / 3) as usize] == NONE {
                    number[(o / 3) as usize] = id;
                    stack.push(o / 3);
                }
            }
        }
        let plane = if piece == NONE { None } else { surface.plane(piece) };
        patches.push(Patch { piece, outward: if facing >= 0.0 { 1.0 } else { -1.0 }, plane, face: face(first) });
    }
    patches
}
