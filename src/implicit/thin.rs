//! Walls and gaps thinner than a cell: what marching cubes may lose, named with its place.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use super::extract::Extracted;
use super::lockstep;
use super::model::Implicit;
use super::newton::{bounds_solid, nearest};
use super::octree::{BRICK, Cell};
use super::tape::{Pruned, Scratch, Tape};
use crate::error::Result;
use crate::numeric::COS_60;
use crate::run::Run;
use crate::spatial::Aabb;

/// A wall counts as thin only if it still is at this many cells to the side: the flank of a sharp edge is not a wall.
const ASIDE: f64 = 2.0;

/// Nodes of the mesh that are looked at; more would only find the same walls again.
const MOST_SAMPLES: usize = 20_000;

/// Missed cells that are looked at.
const MOST_CELLS: usize = 200_000;

/// A place where the solid, or the gap between two of its faces, is thinner than the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct ThinPlace {
    /// The face there.
    pub face: String,
    /// A point of the face.
    pub at: DVec3,
    /// Measured thickness.
    pub thickness: f64,
    /// The cell size it is compared with.
    pub size: f64,
}

impl fmt::Display for ThinPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { face, at, thickness, size } = self;
        write!(
            f,
            "thickness {thickness:.6} at ({:.6}, {:.6}, {:.6}) on {face} is below the cell size {size:.6}",
            at.x, at.y, at.z
        )
    }
}

/// A point of a wall's side, the index of the face it is on, and how thick the wall is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Index of the face.
    pub face: u32,
    /// A point of the face.
    pub at: DVec3,
    /// Measured thickness.
    pub thickness: f64,
}

/// The thinnest of some walls thinner than `size`, one a face.
pub fn thin_places(model: &Implicit, walls: &[Wall], size: f64) -> Vec<ThinPlace> {
    let mut walls = walls.to_vec();
    walls.sort_by(|a, b| a.face.cmp(&b.face).then(a.thickness.total_cmp(&b.thickness)));
    walls.dedup_by_key(|w| w.face);
    let place = |w: Wall| {
        let name = model.faces().get(w.face as usize).map_or_else(String::new, |f| f.name.clone());
        ThinPlace { face: name, at: w.at, thickness: w.thickness, size }
    };
    walls.into_iter().map(place).collect()
}

/// Finds walls thinner than `size`: in cells the surface passes through without parting their corners, and below the nodes
/// of the mesh. Not found: needles, and walls narrower than a few cells.
pub fn thin_walls(model: &Implicit, extracted: &Extracted, size: f64, run: &Run) -> Result<Vec<Wall>> {
    let probe = Probe { model, extracted, size };
    run.install(|| -> Result<Vec<Wall>> {
        let mut found: Vec<Wall> = Vec::new();
        for per_cell in extracted.undecided.par_iter().map(|c| probe.missed(c, run)).collect::<Result<Vec<_>>>()? {
            found.extend(per_cell);
        }
        let nodes = &extracted.mesh.nodes;
        let stride = nodes.len().div_ceil(MOST_SAMPLES).max(1);
        let below: Vec<DVec3> = (0..nodes.len() / stride).map(|i| nodes[i * stride]).collect();
        let below: Vec<Option<Wall>> = lockstep::each(&model.leaves, &below, |p| probe.below(*p));
        run.check()?;
        found.extend(below.into_iter().flatten());
        Ok(found)
    })
}

struct Probe<'a> {
    model: &'a Implicit,
    extracted: &'a Extracted,
    size: f64,
}

impl Probe<'_> {
    fn inside(&self, p: DVec3) -> bool {
        self.extracted.tape_at(self.model, p).value(&self.model.leaves, p) > 0.0
    }

    /// Surface point and outward normal nearest to `p` on the leaf that is active there.
    fn foot(&self, p: DVec3) -> Option<(DVec3, DVec3, u32)> {
        let leaves = &self.model.leaves;
        let active = self.extracted.tape_at(self.model, p).active(leaves, p);
        leaves.get(active.leaf as usize)?;
        let q = nearest(leaves, &[active.leaf], p, 2.0 * self.size, self.model.bounds().diagonal())?;
        let inside = bounds_solid(self.extracted.tape_at(self.model, q), leaves, active.leaf, q)?;
        let n = leaves[active.leaf as usize].gradient(q).g.try_normalize()?;
        Some((q, if inside { -n } else { n }, active.face))
    }

    /// Distance from the surface point `q` through the solid to an opposed face, if less than the cell size.
    fn thickness(&self, q: DVec3, n: DVec3) -> Option<f64> {
        let start = 1e-6 * self.size;
        if self.inside(q - n * self.size) || !self.inside(q - n * start) {
            return None;
        }
        let (mut a, mut b) = (start, self.size);
        while b - a > 1e-3 * self.size {
            let m = 0.5 * (a + b);
            if self.inside(q - n * m) { a = m } else { b = m }
        }
        let (_, other, _) = self.foot(q - n * b)?;
        // Two faces form a wall when their normals differ by more than 120 degrees.
        (other.dot(n) < -COS_60).then_some(b)
    }

    /// The wall below a node.
    fn below(&self, p: DVec3) -> Option<Wall> {
        let (q, n, face) = self.foot(p)?;
        let thickness = self.thickness(q, n)?;
        let (u, v) = n.any_orthonormal_pair();
        let (mut there, mut thin) = (0, 0);
        for d in [u, -u, v, -v] {
            if let Some((q, n, f)) = self.foot(q + d * (ASIDE * self.size))
                && f == face
            {
                there += 1;
                thin += usize::from(self.thickness(q, n).is_some());
            }
        }
        (there >= 2 && thin == there).then_some(Wall { face, at: q, thickness })
    }

    /// Walls inside a brick whose corners all have one sign.
    fn missed(&self, cell: &Cell, run: &Run) -> Result<Vec<Wall>> {
        run.check()?;
        let grid = &self.extracted.bricks.grid;
        let lo = grid.node(cell.at.map(|b| b as usize * BRICK));
        let hi = grid.node(cell.at.map(|b| (b as usize + 1) * BRICK));
        let mut scratch = Scratch::default();
        let mut found = Vec::new();
        let mut stack: Vec<(Aabb, Tape, u32)> = vec![(Aabb::new(lo, hi), (*cell.tape).clone(), BRICK.trailing_zeros())];
        let mut looked = 0;
        while let Some((b, tape, level)) = stack.pop() {
            looked += 1;
            if looked > MOST_CELLS {
                break;
            }
            let tape = match tape.prune(&self.model.leaves, &b, &mut scratch) {
                Pruned::Outside | Pruned::Inside => continue,
                Pruned::Same => tape,
                Pruned::Smaller(t) => t,
            };
            if level > 0 {
                let mid = b.center();
                for c in b.corners() {
                    stack.push((Aabb::around([c, mid]), tape.clone(), level - 1));
                }
                continue;
            }
            let Some((q, n, face)) = self.foot(b.center()) else { continue };
            if !b.grown(1e-9 * self.size).contains(q) {
                continue;
            }
            // a surface that merely bulges into the cell parts the two sides of its foot; a wall does not
            if let Some(thickness) = self.thickness(q, n) {
                found.push(Wall { face, at: q, thickness });
            }
        }
        Ok(found)
    }
}
