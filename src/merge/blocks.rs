//! Block-structured volumes: hexahedra in blocks of rows, columns and layers, on the faces of a merged surface.
//!
//! A node of a block belongs to the entity of least dimension it lies on. Those inside a block are the block's own; all
//! others lie on one of its six faces, whose fragments are structured too, and the merged surface numbers them. So this is
//! one more row of prefix sums on top of [`Merged`], in time and memory proportional to the number of blocks.
//!
//! *References.* \[LAZ\], conclusion: "extended to structured volume meshes"; the extension itself is not described there.

use glam::DVec3;

use crate::error::{Error, Place as Where, Result};

use crate::mesh::{Hexahedra, MeshView, OuterSide};
use crate::model::{BorderNodes, Cells};

use super::numbering::Starts;
use super::view::Merged;

/// A structured block: `cells[0]` by `cells[1]` by `cells[2]` hexahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct HexahedraBlock {
    /// How many hexahedra there are along each of the three directions.
    pub cells: [u32; 3],
    /// Node `(i, j, k)` at `i + (n₀ + 1) (j + (n₁ + 1) k)`; right-handed, so that volumes are positive.
    pub nodes: Vec<DVec3>,
    /// Indices of the model's faces it lies between: against and along the first direction, the second, the third.
    pub faces: [u32; 6],
}

/// How a side of a block lies on the grid of its face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BlockSide {
    face: u32,
    /// Whether the side's first direction is the grid's second.
    swap: bool,
    /// Whether each direction of the grid runs against the side's.
    flip: [bool; 2],
}

impl BlockSide {
    /// The face's own number of the node at `(u, v)` of the side; `grid` is the face's size.
    fn place(self, [u, v]: [u32; 2], grid: [u32; 2]) -> u32 {
        let [mut i, mut j] = if self.swap { [v, u] } else { [u, v] };
        if self.flip[0] {
            i = grid[0] - i;
        }
        if self.flip[1] {
            j = grid[1] - j;
        }
        BorderNodes::Grid(grid).place(i + j * (grid[0] + 1))
    }
}

impl HexahedraBlock {
    fn at(&self, [i, j, k]: [u32; 3]) -> usize {
        let [n, m] = [self.cells[0] as usize + 1, self.cells[1] as usize + 1];
        i as usize + n * (j as usize + m * k as usize)
    }

    /// The two directions along side `s`, and the node at `(u, v)` of it.
    fn on_side(&self, s: usize, [u, v]: [u32; 2]) -> [u32; 3] {
        let axis = s / 2;
        let mut at = [0; 3];
        at[axis] = if s.is_multiple_of(2) { 0 } else { self.cells[axis] };
        (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (u, v);
        at
    }

    fn side_size(&self, s: usize) -> [u32; 2] {
        [self.cells[(s / 2 + 1) % 3], self.cells[(s / 2 + 2) % 3]]
    }

    fn inner_count(&self) -> usize {
        self.cells.iter().map(|n| *n as usize - 1).product()
    }
}

/// Node-matched blocks on a merged surface, readable as one mesh of hexahedra.
///
/// Nodes of the surface come first, in its numbers, then those inside blocks, block by block, rows first. Cells keep the
/// order of blocks and, within one, the order of nodes.
#[derive(Debug, Clone)]
pub struct Blocks<P = (), C = (), S = ()> {
    surface: Merged<P, C, S>,
    blocks: Vec<HexahedraBlock>,
    sides: Vec<[BlockSide; 6]>,
    nodes: Starts,
    cells: Starts,
}

impl<P: Sync, C: Sync, S: Sync> Blocks<P, C, S> {
    /// Puts blocks between the faces of a surface. How a block's sides lie on their faces is found by comparing nodes, each
    /// node of the blocks' sides with one of a face; nothing is searched by distance.
    ///
    /// # Errors
    /// [`Error::Input`] naming the block and the face, for a block without cells or with another number of nodes, and where
    /// a face is no grid or its nodes are not those of the side; [`Error::Failed`] for more nodes or cells than 32 bits
    /// can number.
    pub fn new(surface: Merged<P, C, S>, blocks: Vec<HexahedraBlock>) -> Result<Self> {
        let mut sides = Vec::with_capacity(blocks.len());
        for (b, block) in blocks.iter().enumerate() {
            let bad = |what: String| Error::input(Where::Item(format!("block {b}")), what);
            let expected: u64 = block.cells.iter().map(|n| u64::from(*n) + 1).product();
            if block.cells.contains(&0) || expected != block.nodes.len() as u64 {
                let what = format!("{:?} cells do not have {} nodes", block.cells, block.nodes.len());
                return Err(bad(what));
            }
            let side = |s: usize| {
                let face = block.faces[s];
                find_side(&surface, block, s)
                    .ok_or_else(|| bad(format!("it is not node-matched with face {face}, its side {s}")))
            };
            sides.push([side(0)?, side(1)?, side(2)?, side(3)?, side(4)?, side(5)?]);
        }
        let too_many = |what| Error::Failed(format!("the blocks have more {what} than 32 bits can number"));
        let (mut nodes, mut cells) = (Starts::default(), Starts::default());
        let own = blocks.iter().map(HexahedraBlock::inner_count);
        nodes.lay(std::iter::once(surface.node_count()).chain(own)).ok_or_else(|| too_many("nodes"))?;
        let count = |b: &HexahedraBlock| b.cells.iter().map(|n| *n as usize).product();
        cells.lay(blocks.iter().map(count)).ok_or_else(|| too_many("cells"))?;
        Ok(Self { surface, blocks, sides, nodes, cells })
    }

    /// The surface the blocks lie between.
    pub fn surface(&self) -> &Merged<P, C, S> {
        &self.surface
    }

    /// The blocks.
    pub fn blocks(&self) -> &[HexahedraBlock] {
        &self.blocks
    }

    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.nodes.end()
    }

    /// How many hexahedra there are.
    pub fn cell_count(&self) -> usize {
        self.cells.end()
    }

    /// Node `i`.
    ///
    /// # Panics
    /// Where there is no such node.
    pub fn node(&self, i: usize) -> DVec3 {
        assert!(i < self.node_count(), "node {i} of {}", self.node_count());
        if i < self.surface.node_count() {
            return self.surface.node(i);
        }
        let b = self.nodes.find(i) - 1;
        let (block, local) = (&self.blocks[b], (i - self.nodes.start(b + 1)) as u32);
        let [n, m] = [block.cells[0] - 1, block.cells[1] - 1];
        block.nodes[block.at([1 + local % n, 1 + local / n % m, 1 + local / (n * m)])]
    }

    /// The number a block's node has in the merged mesh: `l2g` of \[LAZ\] one dimension up.
    ///
    /// # Panics
    /// Where there is no such block or node.
    pub fn local_to_global(&self, block: usize, at: [u32; 3]) -> u32 {
        let b = &self.blocks[block];
        assert!((0..3).all(|x| at[x] <= b.cells[x]), "node {at:?} of block {block}, {:?}", b.cells);
        for axis in 0..3 {
            let s = match at[axis] {
                0 => 2 * axis,
                n if n == b.cells[axis] => 2 * axis + 1,
                _ => continue,
            };
            let side = self.sides[block][s];
            let Cells::Grid(grid) = self.surface.fragments().face(side.face as usize).cells() else { continue };
            let place = side.place([at[(axis + 1) % 3], at[(axis + 2) % 3]], grid);
            return self.surface.local_to_global(side.face, place);
        }
        let [n, m] = [b.cells[0] - 1, b.cells[1] - 1];
        self.nodes.start(block + 1) as u32 + (at[0] - 1) + n * ((at[1] - 1) + m * (at[2] - 1))
    }

    /// The corners of a hexahedron: around the side against the third direction, then around the one along it.
    ///
    /// # Panics
    /// Where there is no such cell.
    pub fn cell(&self, j: usize) -> [u32; 8] {
        assert!(j < self.cell_count(), "cell {j} of {}", self.cell_count());
        let b = self.cells.find(j);
        let (local, [n, m, _]) = ((j - self.cells.start(b)) as u32, self.blocks[b].cells);
        let [x, y, z] = [local % n, local / n % m, local / (n * m)];
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
            .map(|[i, j, k]| self.local_to_global(b, [x + i, y + j, z + k]))
    }

    /// The same mesh in arrays, with the names of faces that one block alone lies on: to be [written](crate::io::write_hexahedra), and seen by
    /// its [surface](Hexahedra::surface).
    pub fn hexahedra(&self) -> Hexahedra {
        // The side of a hexahedron on that of its block: against and along the first direction, the second, the third.
        let sides = [5, 3, 2, 4, 0, 1];
        let mut blocks_of = vec![0u32; self.surface.fragments().counts()[2]];
        self.blocks.iter().flat_map(|b| b.faces).for_each(|f| blocks_of[f as usize] += 1);
        let mut outer = Vec::new();
        for (b, block) in self.blocks.iter().enumerate() {
            let [n, m, _] = block.cells;
            for s in (0..6).filter(|s| blocks_of[block.faces[*s] as usize] == 1) {
                let label = self.surface.model().faces[block.faces[s] as usize].label;
                let [across, up] = block.side_size(s);
                for [u, v] in (0..up).flat_map(|v| (0..across).map(move |u| [u, v])) {
                    let mut at = block.on_side(s, [u, v]);
                    at[s / 2] = at[s / 2].min(block.cells[s / 2] - 1);
                    let cell = self.cells.start(b) as u32 + at[0] + n * (at[1] + m * at[2]);
                    outer.push(OuterSide { cell, side: sides[s], label });
                }
            }
        }
        Hexahedra {
            nodes: (0..self.node_count()).map(|i| self.node(i)).collect(),
            hexahedra: (0..self.cell_count()).map(|j| self.cell(j)).collect(),
            prisms: Vec::new(),
            outer,
            names: self.surface.model().names.clone(),
        }
    }
}

/// The way in which side `s` of a block has the nodes of its face.
fn find_side<P, C, S>(surface: &Merged<P, C, S>, block: &HexahedraBlock, s: usize) -> Option<BlockSide> {
    let (face, size) = (block.faces[s], block.side_size(s));
    if face as usize >= surface.fragments().counts()[2] {
        return None;
    }
    let view = surface.fragments().face(face as usize);
    let Cells::Grid(grid) = view.cells() else { return None };
    let node = |place: u32| match view.border().get(place as usize) {
        Some(p) => *p,
        None => view.inner()[place as usize - view.border().len()],
    };
    (0..8).map(|k| BlockSide { face, swap: k & 4 > 0, flip: [k & 1 > 0, k & 2 > 0] }).find(|side| {
        let along = if side.swap { [size[1], size[0]] } else { size };
        let same = |uv: [u32; 2]| block.nodes[block.at(block.on_side(s, uv))] == node(side.place(uv, grid));
        along == grid && (0..=size[1]).all(|v| (0..=size[0]).all(|u| same([u, v])))
    })
}
