//! Marching cubes with the topology of MC33 over the bricks of the octree (\[LIS14\] eq. 3).
//!
//! Two passes over the bricks, both parallel. The first evaluates the sign of every corner and counts nodes and
//! triangles; prefix sums then give every brick its place in the final arrays; the second writes them. A node belongs to
//! the brick that holds its edge's lower end, so its number follows from sign bits alone and no search joins nodes.

use glam::DVec3;
use rayon::prelude::*;

use super::batch::{Batch, RootSearch, SIDE};
use super::mc33;
use super::model::Implicit;
use super::octree::{BRICK, Bricks, Cell};
use super::tape::Tape;
use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::Aabb;

/// How to extract.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtractOptions {
    /// Side length of the cells, in the part's unit.
    pub size: f64,
    /// Nodes lie within this share of the part's diagonal of F = 0, measured along their grid edge (`eps_v` of \[LIS14\] eq. 3).
    pub root_tolerance: f64,
    /// The most bytes the mesh may take; a size that needs more is refused before the work.
    pub memory: u64,
}

impl ExtractOptions {
    /// Cells of the given size, nodes to 1e-12 of the part's diagonal, at most 8 GiB.
    pub fn new(size: f64) -> Self {
        Self { size, root_tolerance: 1e-12, memory: 8 << 30 }
    }
}

/// What extraction gives: the mesh, and the pruned tapes of the cells it runs through.
#[derive(Debug, Clone)]
pub struct Extracted {
    /// The mesh: closed, oriented, 2-manifold, its labels indices into [`Implicit::faces`].
    pub mesh: TriMesh,
    /// Cells the surface was looked for in, for oracles that work near it.
    pub(crate) bricks: Bricks,
    /// Bricks that intervals could not decide and whose corners all have one sign.
    pub(crate) undecided: Vec<Cell>,
}

/// Sign bits of a brick's corners: bit i of row j + 9 k is corner (i, j, k).
type Rows = [u16; SIDE * SIDE];

/// A cell whose triangles do not follow from its corners' signs alone.
#[derive(Debug, Clone, Copy)]
struct Special {
    cell: u16,
    faces: u8,
    tunnel: u8,
    interior: u8,
}

/// What the first pass keeps of a brick.
#[derive(Debug, Clone)]
struct Counted {
    rows: Rows,
    special: Box<[Special]>,
    nodes: u32,
    triangles: u32,
}

/// Numbers of a brick's edges: those with a sign change, axis by axis, row by row.
struct Ranks {
    base: [[u16; BRICK * BRICK]; 3],
    mask: [[u8; BRICK * BRICK]; 3],
    edges: u16,
}

impl Ranks {
    fn new(rows: &Rows) -> Self {
        let mut r = Ranks { base: [[0; 64]; 3], mask: [[0; 64]; 3], edges: 0 };
        for axis in 0..3 {
            for k in 0..BRICK {
                for j in 0..BRICK {
                    let s = rows[j + SIDE * k];
                    let other = match axis {
                        0 => s >> 1,
                        1 => rows[j + 1 + SIDE * k],
                        _ => rows[j + SIDE * (k + 1)],
                    };
                    let m = ((s ^ other) & 0xff) as u8;
                    r.base[axis][j + BRICK * k] = r.edges;
                    r.mask[axis][j + BRICK * k] = m;
                    r.edges += m.count_ones() as u16;
                }
            }
        }
        r
    }

    /// The number of the edge along `axis` at corner `at`; the edge must have a sign change.
    fn of(&self, axis: usize, at: [usize; 3]) -> u32 {
        let row = at[1] + BRICK * at[2];
        let below = self.mask[axis][row] & ((1u16 << at[0]) - 1) as u8;
        u32::from(self.base[axis][row]) + below.count_ones()
    }
}

/// Calls `f` with the cell's coordinates and corner mask for every cell whose corners differ.
fn crossed_cells(rows: &Rows, mut f: impl FnMut([usize; 3], u8)) {
    for k in 0..BRICK {
        for j in 0..BRICK {
            let r =
                [rows[j + SIDE * k], rows[j + 1 + SIDE * k], rows[j + SIDE * (k + 1)], rows[j + 1 + SIDE * (k + 1)]];
            let any = r[0] | r[1] | r[2] | r[3];
            let all = r[0] & r[1] & r[2] & r[3];
            let mut crossed = (any | any >> 1) & !(all & all >> 1) & 0xff;
            while crossed != 0 {
                let i = crossed.trailing_zeros() as usize;
                crossed &= crossed - 1;
                let pair = |q: u16| (q >> i & 3) as u8;
                f([i, j, k], pair(r[0]) | pair(r[1]) << 2 | pair(r[2]) << 4 | pair(r[3]) << 6);
            }
        }
    }
}

/// Corner `c` of a cell: bit 0 is x, bit 1 is y, bit 2 is z.
fn corner(cell: [usize; 3], c: usize) -> [usize; 3] {
    [cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2 & 1)]
}

/// Axis and lower corner of edge `e` of a cell, as [`mc33`] numbers them.
fn edge(cell: [usize; 3], e: usize) -> (usize, [usize; 3]) {
    let (a, b) = (e & 1, e >> 1 & 1);
    let axis = e / 4;
    let d = match axis {
        0 => [0, a, b],
        1 => [a, 0, b],
        _ => [a, b, 0],
    };
    (axis, [cell[0] + d[0], cell[1] + d[1], cell[2] + d[2]])
}

/// Extracts the surface.
///
/// Guarantees: the mesh is closed, oriented and 2-manifold; nodes lie on a change of sign of the solid within the root
/// tolerance, but for interior nodes of ambiguous cells whose trilinear topology the solid does not have; the same input
/// gives the same bytes for any number of threads.
///
/// Does not guarantee: that features smaller than a cell are there, good triangles, or sharp edges (see
/// [`optimize`](crate::optimize)).
///
/// Errors: a formula that is NaN or infinite at a grid node, or has a pole on the surface; a size that needs too much
/// memory; a solid that no grid node lies in; cancellation.
pub fn extract(model: &Implicit, options: &ExtractOptions, run: &Run) -> Result<Extracted> {
    if !(options.size > 0.0 && options.size.is_finite()) {
        return Err(Error::Usage(format!("the size must be positive, not {}", options.size)));
    }
    run.install(|| Extractor { model, options, run }.extract())
}

struct Extractor<'a> {
    model: &'a Implicit,
    options: &'a ExtractOptions,
    run: &'a Run,
}

/// Bricks, what was counted in each, and the number of the first node of each.
struct NumberedBricks<'a> {
    bricks: &'a Bricks,
    counted: &'a [Counted],
    first: &'a [u32],
}

/// The parts of the final arrays one brick writes.
struct Target<'m> {
    nodes: &'m mut [DVec3],
    triangles: &'m mut [[u32; 3]],
    first_node: u32,
}

impl Extractor<'_> {
    /// The root tolerance as a share of a grid edge.
    fn tolerance(&self) -> f64 {
        self.options.root_tolerance.max(f64::EPSILON) * self.model.bounds().diagonal() / self.options.size
    }

    fn extract(&self) -> Result<Extracted> {
        let mut bricks = Bricks::build(self.model, self.options.size, self.options.memory, self.run)?;
        let rows = self.signs(&bricks)?;
        let counted = self.count(&bricks, rows)?;
        let undecided: Vec<Cell> =
            bricks.cells.iter().zip(&counted).filter(|(_, c)| c.is_none()).map(|(cell, _)| cell.clone()).collect();
        bricks.retain(|i| counted[i].is_some());
        let counted: Vec<Counted> = counted.into_iter().flatten().collect();
        let mut first = Vec::with_capacity(counted.len());
        let (mut nodes, mut triangles) = (0u64, 0u64);
        for c in &counted {
            first.push(nodes as u32);
            nodes += u64::from(c.nodes);
            triangles += u64::from(c.triangles);
        }
        if nodes > u64::from(u32::MAX) || triangles > u64::from(u32::MAX) {
            return Err(Error::Usage(format!("{triangles} triangles are more than a mesh can number")));
        }
        let mut mesh = TriMesh {
            nodes: vec![DVec3::ZERO; nodes as usize],
            triangles: vec![[0; 3]; triangles as usize],
            labels: vec![0; triangles as usize],
            faces: self.model.faces().iter().map(|f| f.name.clone()).collect(),
            groups: Vec::new(),
        };
        self.run.progress("surface", 0.0);
        self.run.triangles(mesh.triangles.len());
        self.fill(&bricks, &counted, &first, &mut mesh)?;
        self.place_interior_nodes(&bricks, &counted, &first, &mut mesh)?;
        self.label(&bricks, &counted, &mut mesh)?;
        Ok(Extracted { mesh, bricks, undecided })
    }

    /// The signs at the corners of each brick, where it has both.
    fn signs(&self, bricks: &Bricks) -> Result<Vec<Option<Box<Rows>>>> {
        let total = bricks.cells.len().max(1);
        bricks
            .cells
            .par_iter()
            .enumerate()
            .map_init(Batch::default, |batch, (i, cell)| {
                if i % 64 == 0 {
                    self.run.check()?;
                    self.run.progress("signs", i as f64 / total as f64);
                }
                self.signs_of(bricks, cell, batch)
            })
            .collect()
    }

    fn signs_of(&self, bricks: &Bricks, cell: &Cell, batch: &mut Batch) -> Result<Option<Box<Rows>>> {
        batch.corners(&bricks.grid, cell.at);
        batch.eval(&cell.tape, self.model)?;
        let mut rows = [0u16; SIDE * SIDE];
        let (mut any, mut all) = (0, 0x1ff);
        for (row, v) in rows.iter_mut().zip(batch.values.chunks_exact(SIDE)) {
            *row = v.iter().enumerate().fold(0, |r, (i, v)| r | u16::from(*v > 0.0) << i);
            any |= *row;
            all &= *row;
        }
        Ok((any != 0 && all != 0x1ff).then(|| Box::new(rows)))
    }

    fn count(&self, bricks: &Bricks, rows: Vec<Option<Box<Rows>>>) -> Result<Vec<Option<Counted>>> {
        bricks
            .cells
            .par_iter()
            .zip(rows)
            .enumerate()
            .map(|(i, (cell, rows))| {
                if i % 64 == 0 {
                    self.run.check()?;
                }
                Ok(rows.map(|rows| self.count_brick(bricks, cell, *rows)))
            })
            .collect()
    }

    fn count_brick(&self, bricks: &Bricks, cell: &Cell, rows: Rows) -> Counted {
        let (mut triangles, mut interior) = (0, 0u32);
        let mut special = Vec::new();
        crossed_cells(&rows, |at, mask| {
            let mut s =
                Special { cell: (at[0] + BRICK * (at[1] + BRICK * at[2])) as u16, faces: 0, tunnel: 0, interior: 0 };
            let ambiguous = mc33::ambiguous_faces(mask);
            if ambiguous != 0 || mc33::interior_ambiguous(mask, 0) {
                s.faces = self.face_decisions(bricks, cell, at, mask, ambiguous);
                if mc33::interior_ambiguous(mask, s.faces) {
                    let values = std::array::from_fn(|c| self.signed(bricks, cell, corner(at, c), mask >> c & 1 == 1));
                    s.tunnel = mc33::tunnel(mask, s.faces, &values);
                }
            }
            let case = mc33::case(mask, s.faces, s.tunnel);
            triangles += case.triangles.len() as u32;
            interior += u32::from(case.interior_nodes);
            s.interior = case.interior_nodes;
            if s.faces != 0 || s.tunnel != 0 || s.interior != 0 {
                special.push(s);
            }
        });
        let nodes = u32::from(Ranks::new(&rows).edges) + interior;
        Counted { rows, special: special.into(), nodes, triangles }
    }

    /// The asymptotic decider on each ambiguous face. A face belongs to one brick, whose tape gives the values, so that the
    /// cells on both sides decide alike.
    fn face_decisions(&self, bricks: &Bricks, cell: &Cell, at: [usize; 3], mask: u8, ambiguous: u8) -> u8 {
        let mut faces = 0;
        for f in 0..6 {
            if ambiguous >> f & 1 == 0 {
                continue;
            }
            let (axis, side) = (f / 2, f % 2);
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut owner = cell;
            let mut local = at;
            if at[axis] + side == BRICK {
                let mut next = cell.at;
                next[axis] += 1;
                if let Some(i) = bricks.find(next) {
                    owner = &bricks.cells[i];
                    local[axis] = 0;
                }
            } else {
                local[axis] += side;
            }
            let values = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|d: [usize; 2]| {
                let mut node = local;
                node[u] += d[0];
                node[v] += d[1];
                let c = side << axis | d[0] << u | d[1] << v;
                self.signed(bricks, owner, node, mask >> c & 1 == 1)
            });
            faces |= u8::from(mc33::face_joined(values)) << f;
        }
        faces
    }

    /// The R-function's value at a corner, with the sign the corner is known to have.
    fn signed(&self, bricks: &Bricks, cell: &Cell, local: [usize; 3], positive: bool) -> f64 {
        let p = bricks.grid.node(global(cell.at, local));
        let v = cell.tape.r_value(&self.model.leaves, self.model.rsystem(), p).abs().max(f64::MIN_POSITIVE);
        if positive { v } else { -v }
    }

    fn fill(&self, bricks: &Bricks, counted: &[Counted], first: &[u32], mesh: &mut TriMesh) -> Result<()> {
        let mut targets = Vec::with_capacity(counted.len());
        let (mut nodes, mut triangles) = (&mut mesh.nodes[..], &mut mesh.triangles[..]);
        for (c, first_node) in counted.iter().zip(first) {
            let (n, rest) = nodes.split_at_mut(c.nodes as usize);
            nodes = rest;
            let (t, rest) = triangles.split_at_mut(c.triangles as usize);
            triangles = rest;
            targets.push(Target { nodes: n, triangles: t, first_node: *first_node });
        }
        let total = targets.len().max(1);
        let numbered = NumberedBricks { bricks, counted, first };
        targets
            .into_par_iter()
            .enumerate()
            .map_init(Batch::default, |batch, (i, target)| {
                if i % 64 == 0 {
                    self.run.check()?;
                    self.run.progress("surface", i as f64 / total as f64);
                }
                self.fill_brick(&numbered, i, target, batch)
            })
            .collect()
    }

    fn fill_brick(&self, of: &NumberedBricks<'_>, index: usize, target: Target<'_>, batch: &mut Batch) -> Result<()> {
        let NumberedBricks { bricks, counted, first } = *of;
        let (cell, me) = (&bricks.cells[index], &counted[index]);
        // ranks of this brick and of those at its upper sides, made when first asked for
        let mut ranks: [Option<(u32, Ranks)>; 8] = [const { None }; 8];
        let find = |which: usize| -> Option<(u32, Ranks)> {
            let at = std::array::from_fn(|k| cell.at[k] + (which >> k & 1) as u32);
            let i = bricks.find(at)?;
            Some((first[i], Ranks::new(&counted[i].rows)))
        };
        let own = Ranks::new(&me.rows);
        let edges = u32::from(own.edges);
        self.place_nodes(bricks, cell, &own, target.nodes, batch)?;
        ranks[0] = Some((target.first_node, own));
        let mut number = |axis: usize, at: [usize; 3]| -> u32 {
            let which = (0..3).fold(0, |w, k| w | usize::from(at[k] == BRICK) << k);
            let local = at.map(|i| i % BRICK);
            let slot = &mut ranks[which];
            if slot.is_none() {
                *slot = find(which);
            }
            slot.as_ref().map_or(u32::MAX, |(first, r)| first + r.of(axis, local))
        };
        let mut special = me.special.iter().peekable();
        let mut interior = target.first_node + edges;
        let mut out = target.triangles.iter_mut();
        let mut target_is_open = false;
        crossed_cells(&me.rows, |at, mask| {
            let id = (at[0] + BRICK * (at[1] + BRICK * at[2])) as u16;
            let s = special.next_if(|s| s.cell == id).copied();
            let (faces, tunnel) = s.map_or((0, 0), |s| (s.faces, s.tunnel));
            let mut known = [u32::MAX; 12];
            for t in mc33::case(mask, faces, tunnel).triangles {
                let ids = t.map(|e| match e {
                    0..12 => {
                        let slot = &mut known[e as usize];
                        if *slot == u32::MAX {
                            let (axis, at) = edge(at, e as usize);
                            *slot = number(axis, at);
                            target_is_open |= *slot == u32::MAX;
                        }
                        *slot
                    }
                    inner => interior + u32::from(inner - 12),
                });
                if let Some(t) = out.next() {
                    *t = ids;
                }
            }
            interior += s.map_or(0, |s| u32::from(s.interior));
        });
        if target_is_open {
            return Err(Error::Failed("the solid reaches beyond the box that was found around it".into()));
        }
        Ok(())
    }

    fn roots<'b>(&'b self, cell: &'b Cell) -> RootSearch<'b> {
        RootSearch { model: self.model, tape: &cell.tape, tolerance: self.tolerance() }
    }

    /// Puts the brick's nodes where the sign changes along their edges.
    fn place_nodes(
        &self,
        bricks: &Bricks,
        cell: &Cell,
        ranks: &Ranks,
        out: &mut [DVec3],
        batch: &mut Batch,
    ) -> Result<()> {
        let grid = &bricks.grid;
        let mut ends: Vec<[DVec3; 2]> = Vec::with_capacity(out.len());
        for axis in 0..3 {
            for row in 0..BRICK * BRICK {
                let mut mask = ranks.mask[axis][row];
                while mask != 0 {
                    let i = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let a = global(cell.at, [i, row % BRICK, row / BRICK]);
                    let mut b = a;
                    b[axis] += 1;
                    ends.push([grid.node(a), grid.node(b)]);
                }
            }
        }
        out[ends.len()..].fill(DVec3::ZERO); // interior nodes wait for the crossings around them
        self.roots(cell).find(&ends, out, batch)
    }

    /// Puts interior nodes where their cell's triangles want them, then onto the surface where it is met inside the cell on
    /// the way along the R-function's gradient. Where it is not, the node stays: its cell has a topology the solid does
    /// not have. There are few such cells, so this is sequential.
    fn place_interior_nodes(
        &self,
        bricks: &Bricks,
        counted: &[Counted],
        first: &[u32],
        mesh: &mut TriMesh,
    ) -> Result<()> {
        let h = self.options.size;
        let mut batch = Batch::default();
        let mut triangle = 0;
        for ((cell, c), first) in bricks.cells.iter().zip(counted).zip(first) {
            if c.special.iter().all(|s| s.interior == 0) {
                triangle += c.triangles as usize;
                continue;
            }
            let mut special = c.special.iter().peekable();
            let mut node = *first as usize + Ranks::new(&c.rows).edges as usize;
            let mut moves: Vec<(usize, [DVec3; 2])> = Vec::new();
            crossed_cells(&c.rows, |at, mask| {
                let id = (at[0] + BRICK * (at[1] + BRICK * at[2])) as u16;
                let s = special.next_if(|s| s.cell == id).copied();
                let (faces, tunnel) = s.map_or((0, 0), |s| (s.faces, s.tunnel));
                let local = mc33::case(mask, faces, tunnel).triangles;
                let global_ids = &mesh.triangles[triangle..triangle + local.len()];
                triangle += local.len();
                let Some(s) = s.filter(|s| s.interior > 0) else { return };
                let mut crossings = [DVec3::ZERO; 12];
                for (l, g) in local.iter().zip(global_ids) {
                    for k in 0..3 {
                        if l[k] < mc33::INTERIOR_NODE {
                            crossings[l[k] as usize] = mesh.nodes[g[k] as usize];
                        }
                    }
                }
                let lo = bricks.grid.node(global(cell.at, at));
                for k in 0..s.interior {
                    let p = mc33::interior_position(local, mc33::INTERIOR_NODE + k, &crossings);
                    let d = cell.tape.r_gradient(&self.model.leaves, self.model.rsystem(), p);
                    let way = if d.v > 0.0 { -d.g } else { d.g }.normalize_or_zero() * (0.5 * h);
                    let room = Aabb::new(lo, lo + h);
                    moves.push((node, [p, (p + way).clamp(room.lo, room.hi)]));
                    node += 1;
                }
            });
            let ends: Vec<[DVec3; 2]> = moves.iter().map(|m| m.1).collect();
            let side = |p: DVec3| cell.tape.value(&self.model.leaves, p) > 0.0;
            let (crossing, resting): (Vec<usize>, Vec<usize>) =
                (0..ends.len()).partition(|i| side(ends[*i][0]) != side(ends[*i][1]));
            let mut found = vec![DVec3::ZERO; crossing.len()];
            let ends_of: Vec<[DVec3; 2]> = crossing.iter().map(|i| ends[*i]).collect();
            self.roots(cell).find(&ends_of, &mut found, &mut batch)?;
            for (i, p) in crossing.iter().zip(found) {
                mesh.nodes[moves[*i].0] = p;
            }
            for i in resting {
                mesh.nodes[moves[i].0] = ends[i][0];
            }
        }
        Ok(())
    }

    /// Gives every triangle the face of the leaf that decides at its centroid.
    fn label(&self, bricks: &Bricks, counted: &[Counted], mesh: &mut TriMesh) -> Result<()> {
        let TriMesh { nodes, triangles, labels, .. } = mesh;
        let mut work = Vec::with_capacity(counted.len());
        let (mut t, mut l) = (&triangles[..], &mut labels[..]);
        for (cell, c) in bricks.cells.iter().zip(counted) {
            let (a, rest) = t.split_at(c.triangles as usize);
            t = rest;
            let (b, rest) = l.split_at_mut(c.triangles as usize);
            l = rest;
            work.push((cell, a, b));
        }
        work.into_par_iter()
            .map_init(Batch::default, |batch, (cell, triangles, labels)| {
                self.run.check()?;
                if let Some(face) = cell.tape.only_face() {
                    labels.fill(face);
                    return Ok(());
                }
                batch.clear();
                for t in triangles {
                    let [a, b, c] = t.map(|v| nodes[v as usize]);
                    batch.push((a + b + c) / 3.0);
                }
                batch.faces(&cell.tape, self.model, labels);
                Ok(())
            })
            .collect()
    }
}

fn global(brick: [u32; 3], local: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|k| brick[k] as usize * BRICK + local[k])
}

impl Extracted {
    /// The pruned tape valid at a point.
    pub(crate) fn tape_at<'a>(&'a self, model: &'a Implicit, p: DVec3) -> &'a Tape {
        self.bricks.tape_at(&model.tape, p)
    }
}
