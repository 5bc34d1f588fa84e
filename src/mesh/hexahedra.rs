//! Hexahedra in place of pairs of prisms: where two triangles of a swept face make a good quadrilateral.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::prisms::{OuterSide, Prisms};
use crate::error::{Error, Place, Result};

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

/// Two triangles of the bottom that may be one quadrilateral.
struct Pair {
    /// How far its worst angle is from a right one, in degrees.
    off: f64,
    triangles: [u32; 2],
    /// Where the shared edge begins in the first triangle, and in the second.
    edges: [usize; 2],
}

impl Pair {
    /// Corners of the quadrilateral: which of the two triangles, and which of its corners.
    fn corners(&self) -> [[usize; 2]; 4] {
        let [a, b] = self.edges;
        // The edge from its first end over the other triangle's third corner to its second end, and back.
        [[0, a], [1, (b + 2) % 3], [0, (a + 1) % 3], [0, (a + 2) % 3]]
    }

    fn cell(&self, cells: &[[u32; 6]]) -> [u32; 8] {
        let corners = self.corners();
        let at = |k: usize, up: usize| {
            let [of, corner] = corners[k];
            cells[self.triangles[of] as usize][corner + up]
        };
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k| at(k % 4, 3 * (k / 4)))
    }
}

/// How far the worst angle of a quadrilateral is from a right one, in degrees.
fn off_square(p: [DVec3; 4]) -> f64 {
    let angle = |k: usize| (p[(k + 1) % 4] - p[k]).angle_between(p[(k + 3) % 4] - p[k]).to_degrees();
    (0..4).map(|k| (angle(k) - 90.0).abs()).fold(0.0, f64::max)
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
    /// Makes hexahedra of pairs of prisms beside each other, in all layers alike. Pairs whose quadrilaterals are nearest to rectangles come
    /// first, and no quadrilateral has an angle farther than `off` degrees from a right one, on either end. Two equilateral triangles
    /// make one that is 30 degrees off. What finds no partner stays a prism.
    ///
    /// *Guarantees*: the nodes, the volume they fill and the names are those of the prisms; a side of a cell has two cells or is in
    /// [`outer`](Hexahedra::outer) once; at each corner of a hexahedron its edges span a positive volume.
    /// *Does not guarantee*: the most hexahedra there could be, or flat sides where the face is bent.
    ///
    /// # Errors
    /// [`Error::Input`] for prisms that are not in layers, or name nodes or sides that are not there.
    pub fn hexahedra(&self, off: f64) -> Result<Hexahedra> {
        let m = self.outer.iter().filter(|o| o.side == 0).count();
        let whole = m > 0 && !self.cells.is_empty() && self.cells.len().is_multiple_of(m);
        let count = self.nodes.len();
        let lost = self.cells.iter().flatten().any(|v| *v as usize >= count)
            || self.outer.iter().any(|o| o.cell as usize >= self.cells.len() || o.side > 4);
        if !whole || lost {
            let what = "prisms are not in layers, or name nodes or sides that are not there";
            return Err(Error::input(Place::Unknown, what));
        }
        let layers = self.cells.len() / m;
        let pairs = self.pairs(m, layers, off);
        let mut out = Hexahedra { nodes: self.nodes.clone(), names: self.names.clone(), ..Hexahedra::default() };
        // For each triangle of the bottom its pair and which of the two it is, or its place among those that stay.
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
                let cell = (layers * pairs.len() + layer * single.len() + place) as u32;
                out.outer.push(OuterSide { cell, ..*o });
                continue;
            };
            let cell = (layer * pairs.len() + k) as u32;
            let side = match o.side {
                // The ends of both triangles are one side.
                0 | 1 if of == 1 => continue,
                0 | 1 => o.side,
                wall => {
                    let begins = [of, usize::from(wall) - 2];
                    2 + pairs[k].corners().iter().position(|c| same(c, &begins, &pairs[k])).unwrap_or(0) as u8
                }
            };
            out.outer.push(OuterSide { cell, side, label: o.label });
        }
        Ok(out)
    }

    /// The pairs to join, by their first triangles.
    fn pairs(&self, m: usize, layers: usize, off: f64) -> Vec<Pair> {
        let places = |cell: [u32; 8]| cell.map(|v| self.nodes[v as usize]);
        let mut edges: FxHashMap<[u32; 2], [usize; 2]> = FxHashMap::default();
        let mut found: Vec<Pair> = Vec::new();
        for t in 0..m {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| self.cells[t][k]);
                let Some([s, j]) = edges.remove(&[b, a]) else {
                    edges.insert([a, b], [t, k]);
                    continue;
                };
                let mut pair = Pair { off: 0.0, triangles: [s as u32, t as u32], edges: [j, k] };
                let ends = [0, layers - 1].map(|l| places(pair.cell(&self.cells[l * m..(l + 1) * m])));
                let [low, high] = [&ends[0][..4], &ends[1][4..]].map(|p| off_square([p[0], p[1], p[2], p[3]]));
                pair.off = low.max(high);
                let is_good = |l: usize| is_convex(places(pair.cell(&self.cells[l * m..(l + 1) * m])));
                if pair.off <= off && (0..layers).all(is_good) {
                    found.push(pair);
                }
            }
        }
        found.sort_by(|a, b| a.off.total_cmp(&b.off).then(a.triangles.cmp(&b.triangles)));
        let mut taken = vec![false; m];
        found.retain(|p| {
            let free = p.triangles.iter().all(|t| !taken[*t as usize]);
            p.triangles.iter().for_each(|t| taken[*t as usize] |= free);
            free
        });
        found.sort_by_key(|p| p.triangles);
        found
    }
}

/// Whether the corner of a quadrilateral is where an edge of one of its triangles begins. Both triangles have the ends of the edge they
/// share.
fn same(corner: &[usize; 2], begins: &[usize; 2], pair: &Pair) -> bool {
    let [a, b] = pair.edges;
    // The second triangle begins its edge where the first one's ends.
    let of_first = match *begins {
        [1, k] if k == b => [0, (a + 1) % 3],
        [1, k] if k == (b + 1) % 3 => [0, a],
        other => other,
    };
    *corner == of_first
}

impl Hexahedra {
    /// The corners of an outer side, three or four, counterclockwise as seen from outside.
    ///
    /// # Panics
    /// Where there is no such side or cell.
    pub fn corners(&self, outer: &OuterSide) -> Vec<u32> {
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
pub(crate) fn side_of(cell: &[u32], side: u8) -> Vec<u32> {
    let corners: &[usize] = if cell.len() == 8 { &SIDES[usize::from(side)] } else { Prisms::side(side) };
    corners.iter().map(|k| cell[*k]).collect()
}
