//! Hexahedra in place of pairs of prisms: where two triangles of a swept face make a good quadrilateral.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::prisms::{OuterSide, Prisms};
use super::trimesh::TriMesh;
use crate::error::{Error, Place, Result};
use crate::numeric::NONE;

/// Corners of a hexahedron's sides, counterclockwise as seen from outside: bottom, top, walls in the order of the bottom's edges.
const SIDES: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A volume mesh of hexahedra, and of prisms where triangles found no partner, with the names of its boundary.
///
/// The first four corners of a hexahedron run counterclockwise as seen from the other four, and corner 4 is across from corner 0,
/// as VTK, gmsh and Abaqus have them. Prisms are as [`Prisms`] has them. Cells are counted hexahedra first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hexahedra {
    /// Places: those of the prisms.
    pub nodes: Vec<DVec3>,
    /// Corners of each hexahedron, layer by layer.
    pub hexahedra: Vec<[u32; 8]>,
    /// Corners of each prism, layer by layer.
    pub prisms: Vec<[u32; 6]>,
    /// The boundary. Sides of a hexahedron are 0 the bottom, 1 the top, 2 to 5 the walls over its bottom's edges, from corner 0 on.
    pub outer: Vec<OuterSide>,
    /// Names of the boundary.
    pub names: Vec<String>,
}

/// How many triangles are reached in search of a partner. A hundred lie within some five edges: farther away good pairs would
/// be changed for the sake of one, and searches of large faces would take long.
const REACH: usize = 100;

/// What is known of the bottom's triangles, which are those of every layer.
struct Bottom {
    /// The name of each triangle's prisms at the bottom, and at the top.
    ends: Vec<[u32; 2]>,
    /// Edges under an outer wall, each a triangle and the corner the edge begins at.
    walls: FxHashSet<[usize; 2]>,
}

/// Two triangles of the bottom that may be one quadrilateral.
struct TrianglePair {
    /// How far it is from a rectangle, in degrees.
    off: f64,
    triangles: [u32; 2],
    /// Where the shared edge begins in the first triangle, and in the second.
    edges: [usize; 2],
}

impl TrianglePair {
    /// The hexahedron in a layer: around the bottom from the shared edge's first end over the second triangle's third corner to its
    /// second end and back over the first triangle's, then around the top.
    fn cell(&self, layer: &[[u32; 6]]) -> [u32; 8] {
        let [a, b] = self.edges;
        let [first, second] = self.triangles.map(|t| layer[t as usize]);
        let around =
            |up: usize| [first[a + up], second[(b + 2) % 3 + up], first[(a + 1) % 3 + up], first[(a + 2) % 3 + up]];
        let [[p, q, r, s], [t, u, v, w]] = [0, 3].map(around);
        [p, q, r, s, t, u, v, w]
    }

    /// The hexahedron's side that is the wall over an edge of the first triangle or the second, by the corner the edge begins at.
    fn wall(&self, of: usize, corner: usize) -> u8 {
        // Edges behind the shared one: two of the second triangle, then two of the first.
        let behind = (corner + 3 - self.edges[of]) % 3;
        (if of == 0 { behind + 3 } else { behind + 1 }) as u8
    }
}

/// How far two triangles beside each other are from a rectangle, in degrees: by the worst angle of their quadrilateral, or by how far
/// they are folded along the edge they share, from its first corner to its third.
fn off_rectangle(p: [DVec3; 4]) -> f64 {
    let angle = |k: usize| (p[(k + 1) % 4] - p[k]).angle_between(p[(k + 3) % 4] - p[k]).to_degrees();
    let worst = (0..4).map(|k| (angle(k) - 90.0).abs()).fold(0.0, f64::max);
    let [one, other] = [[1, 2], [2, 3]].map(|[j, k]| (p[j] - p[0]).cross(p[k] - p[0]));
    worst.max(one.angle_between(other).to_degrees())
}

/// Whether the three edges at every corner of a hexahedron span a positive volume.
fn is_convex(p: [DVec3; 8]) -> bool {
    (0..8).all(|k| {
        let (base, up) = (k / 4 * 4, (k + 4) % 8);
        let [next, last] = [base + (k + 1) % 4, base + (k + 3) % 4].map(|v| p[v] - p[k]);
        let volume = next.cross(last).dot(p[up] - p[k]);
        // At the top the way to the other corner leads down.
        if k < 4 { volume > 0.0 } else { volume < 0.0 }
    })
}

impl Prisms {
    /// Makes hexahedra of pairs of prisms beside each other, in all layers alike. The pairs nearest to rectangles come first, and some
    /// are exchanged where this makes more of them. On either end no angle of their quadrilaterals is farther than `off` degrees from a
    /// right one, and no two triangles are folded by more. Two equilateral triangles make a quadrilateral that is 30 degrees off.
    /// What finds no partner stays a prism. Triangles whose ends have different names are no partners.
    ///
    /// *Guarantees*: the nodes, the volume and the names are those of the prisms. A side of a cell has two cells, both with the same
    /// corners there, or is in [`outer`](Hexahedra::outer) once. At each corner of a hexahedron its edges span a positive volume.
    /// *Does not guarantee*: the most hexahedra there could be, or flat sides where the face is bent.
    ///
    /// # Errors
    /// [`Error::Input`] for prisms that are not in layers, or name nodes, prisms, sides or names that are not there.
    ///
    /// ```
    /// use rvachev::mesh::{Prisms, TriMesh};
    /// use rvachev::{DVec3, Result};
    ///
    /// fn main() -> Result<()> {
    ///     let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    ///     let face = TriMesh::new(square, vec![[0, 1, 2], [0, 2, 3]]);
    ///     let mesh = Prisms::swept(&face, "surface", DVec3::new(0.0, 0.0, 3.0), 4)?.hexahedra(45.0)?;
    ///     assert_eq!((mesh.hexahedra.len(), mesh.prisms.len()), (4, 0));
    ///     Ok(())
    /// }
    /// ```
    pub fn hexahedra(&self, off: f64) -> Result<Hexahedra> {
        let Some(bottom) = self.bottom() else {
            let what = "prisms are not in layers, or name nodes, prisms, sides or names that are not there";
            return Err(Error::input(Place::Unknown, what));
        };
        let m = bottom.ends.len();
        let pairs = self.pairs(&bottom, off);
        let mut out = Hexahedra { nodes: self.nodes.clone(), names: self.names.clone(), ..Hexahedra::default() };
        // For each triangle of the bottom its pair and which of the two it is.
        let mut pair_of: Vec<Option<[usize; 2]>> = vec![None; m];
        for (k, pair) in pairs.iter().enumerate() {
            pair.triangles.iter().zip(0..).for_each(|(t, of)| pair_of[*t as usize] = Some([k, of]));
        }
        let single: Vec<usize> = (0..m).filter(|t| pair_of[*t].is_none()).collect();
        for layer in self.cells.chunks_exact(m) {
            out.hexahedra.extend(pairs.iter().map(|p| p.cell(layer)));
            out.prisms.extend(single.iter().map(|t| layer[*t]));
        }
        for o in &self.outer {
            let (layer, t) = (o.cell as usize / m, o.cell as usize % m);
            let Some([k, of]) = pair_of[t] else {
                let place = single.partition_point(|s| *s < t);
                let cell = (out.hexahedra.len() + layer * single.len() + place) as u32;
                out.outer.push(OuterSide { cell, ..*o });
                continue;
            };
            let side = match o.side {
                // The ends of both triangles are one side.
                0 | 1 if of == 1 => continue,
                0 | 1 => o.side,
                wall => pairs[k].wall(of, usize::from(wall) - 2),
            };
            out.outer.push(OuterSide { cell: (layer * pairs.len() + k) as u32, side, label: o.label });
        }
        Ok(out)
    }

    /// The triangles at the bottom, if the prisms stand in layers, each layer's bottom the top of the one below.
    fn bottom(&self) -> Option<Bottom> {
        let (count, m) = (self.cells.len(), self.outer.iter().filter(|o| o.side == 0).count());
        let stacked = |j: usize| self.cells[j][..3] == self.cells[j - m][3..];
        let known = self.cells.iter().flatten().all(|v| (*v as usize) < self.nodes.len());
        if m == 0 || count < m || !count.is_multiple_of(m) || !known || !(m..count).all(stacked) {
            return None;
        }
        let mut bottom = Bottom { ends: vec![[NONE; 2]; m], walls: FxHashSet::default() };
        for o in &self.outer {
            let (cell, side) = (o.cell as usize, usize::from(o.side));
            if cell >= count || side > 4 || o.label as usize >= self.names.len() {
                return None;
            }
            if side > 1 {
                bottom.walls.insert([cell % m, side - 2]);
                continue;
            }
            let end = &mut bottom.ends[cell % m][side];
            let first = [0, count - m][side];
            if !(first..first + m).contains(&cell) || *end != NONE {
                return None;
            }
            *end = o.label;
        }
        Some(bottom)
    }

    /// The pairs to join, by their first triangles.
    fn pairs(&self, bottom: &Bottom, off: f64) -> Vec<TrianglePair> {
        let Bottom { ends, walls } = bottom;
        let m = ends.len();
        let mut edges: FxHashMap<[u32; 2], [usize; 2]> = FxHashMap::default();
        let mut found: Vec<TrianglePair> = Vec::new();
        for t in 0..m {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| self.cells[t][k]);
                let Some([s, j]) = edges.remove(&[b, a]) else {
                    edges.insert([a, b], [t, k]);
                    continue;
                };
                if ends[s] != ends[t] || walls.contains(&[s, j]) || walls.contains(&[t, k]) {
                    continue;
                }
                let mut pair = TrianglePair { off: 0.0, triangles: [s as u32, t as u32], edges: [j, k] };
                let layers = self.cells.chunks_exact(m).map(|l| pair.cell(l).map(|v| self.nodes[v as usize]));
                let cells: Vec<[DVec3; 8]> = layers.collect();
                let ([p, q, r, s, ..], [.., t, u, v, w]) = (cells[0], cells[cells.len() - 1]);
                pair.off = off_rectangle([p, q, r, s]).max(off_rectangle([t, u, v, w]));
                if pair.off <= off && cells.into_iter().all(is_convex) {
                    found.push(pair);
                }
            }
        }
        found.sort_by(|a, b| a.off.total_cmp(&b.off).then(a.triangles.cmp(&b.triangles)));
        let chosen = choose(&found, m);
        let mut number = 0..;
        found.retain(|p| chosen[p.triangles[0] as usize] == number.next());
        found.sort_by_key(|p| p.triangles);
        found
    }
}

/// The pair of each triangle, out of pairs the best of which come first.
fn choose(pairs: &[TrianglePair], triangles: usize) -> Vec<Option<usize>> {
    let mut of = vec![None; triangles];
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); triangles];
    for (k, pair) in pairs.iter().enumerate() {
        let both = pair.triangles.map(|t| t as usize);
        both.iter().for_each(|t| around[*t].push(k));
        if both.iter().all(|t| of[*t].is_none()) {
            both.iter().for_each(|t| of[*t] = Some(k));
        }
    }
    for start in 0..triangles {
        if of[start].is_none() {
            exchange(pairs, &around, &mut of, start);
        }
    }
    of
}

/// Finds a partner for a triangle, and other partners for those who lose theirs by it: along a way of pairs that might be and pairs
/// that are, in turns, to another triangle without a partner. The shortest way is taken.
fn exchange(pairs: &[TrianglePair], around: &[Vec<usize>], of: &mut [Option<usize>], start: usize) {
    let other = |k: usize, t: usize| {
        let [a, b] = pairs[k].triangles.map(|t| t as usize);
        if a == t { b } else { a }
    };
    // By which pair a triangle is reached.
    let mut by: FxHashMap<usize, usize> = FxHashMap::default();
    let (mut reached, mut at) = (vec![start], 0);
    while at < reached.len() && reached.len() <= REACH {
        let from = reached[at];
        at += 1;
        for k in &around[from] {
            let mut to = other(*k, from);
            if to == start || by.contains_key(&to) {
                continue;
            }
            by.insert(to, *k);
            if let Some(own) = of[to] {
                let partner = other(own, to);
                by.insert(partner, own);
                reached.push(partner);
                continue;
            }
            loop {
                let new = by[&to];
                let from = other(new, to);
                of[to] = Some(new);
                let Some(old) = of[from].replace(new) else {
                    return;
                };
                to = other(old, from);
            }
        }
    }
}

impl Hexahedra {
    /// The boundary as triangles, to be checked and looked at: a quadrilateral is cut from its first corner. Nodes keep their numbers where
    /// all of them are on it; else they are numbered anew in their order.
    pub fn surface(&self) -> TriMesh {
        let mut triangles = Vec::with_capacity(2 * self.outer.len());
        let mut labels = Vec::with_capacity(2 * self.outer.len());
        for o in &self.outer {
            let corners: Vec<u32> = self.corners(o).collect();
            for pair in corners[1..].windows(2) {
                triangles.push([corners[0], pair[0], pair[1]]);
                labels.push(o.label);
            }
        }
        let mut number = vec![NONE; self.nodes.len()];
        triangles.iter().flatten().for_each(|v| number[*v as usize] = 0);
        let mut nodes = Vec::new();
        for (v, n) in number.iter_mut().enumerate().filter(|x| *x.1 != NONE) {
            *n = nodes.len() as u32;
            nodes.push(self.nodes[v]);
        }
        triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
        TriMesh { nodes, triangles, labels, faces: self.names.clone(), ..TriMesh::default() }
    }

    /// The corners of an outer side, three or four, counterclockwise as seen from outside.
    ///
    /// # Panics
    /// Where there is no such side or cell.
    pub fn corners(&self, outer: &OuterSide) -> impl ExactSizeIterator<Item = u32> + use<'_> {
        let (cell, count) = (outer.cell as usize, self.hexahedra.len());
        match self.hexahedra.get(cell) {
            Some(hexahedron) => side_of(hexahedron, outer.side),
            None => side_of(&self.prisms[cell - count], outer.side),
        }
    }
}

/// The corners of a side of a prism or a hexahedron, which has six corners or eight.
///
/// # Panics
/// Where there is no such side.
pub(crate) fn side_of(cell: &[u32], side: u8) -> impl ExactSizeIterator<Item = u32> + use<'_> {
    let corners: &[usize] = if cell.len() == 8 { &SIDES[usize::from(side)] } else { Prisms::side(side) };
    corners.iter().map(|k| cell[*k])
}
