//! Where the bricks of each round are.

use glam::DVec3;

use crate::implicit::GridBlock;
use crate::spatial::Aabb;

/// A grid of cells and how many bricks it is cut into along each axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BrickLayout {
    /// The corner of the first cell.
    pub(super) origin: DVec3,
    /// The side of a cell.
    pub(super) cell: f64,
    /// Cells along each axis.
    pub(super) cells: [u32; 3],
    /// Bricks of the first round along each axis.
    pub(super) bricks: [u32; 3],
}

impl BrickLayout {
    /// How many bricks a round has along each axis: shifted ones are one more where there is a wall at all.
    pub(super) fn along(&self, round: usize) -> [u32; 3] {
        self.bricks.map(|n| if round == 0 || n == 1 { n } else { n + 1 })
    }

    /// How many bricks a round has.
    pub(super) fn count(&self, round: usize) -> u32 {
        self.along(round).iter().product()
    }

    /// The place of a brick along each axis.
    pub(super) fn place(&self, round: usize, index: u32) -> [u32; 3] {
        let n = self.along(round);
        [index % n[0], index / n[0] % n[1], index / n[0] / n[1]]
    }

    /// The wall below a brick along an axis, in quarters of cells. The first and the last brick go on beyond the grid.
    fn wall(&self, round: usize, axis: usize, at: u32) -> i64 {
        let (cells, n) = (u64::from(self.cells[axis]), u64::from(self.bricks[axis]));
        let first = |k: u64| (4 * (cells * k / n)) as i64;
        let k = u64::from(at);
        if at == 0 {
            i64::MIN
        } else if at >= self.along(round)[axis] {
            i64::MAX
        } else if round == 0 {
            first(k)
        } else {
            // Halfway between walls of the first round, then a quarter of the way.
            let (a, b) = (first(k - 1), first(k));
            a + (b - a) / if round == 1 { 2 } else { 4 }
        }
    }

    /// The bounds of a brick along each axis, in quarters of cells.
    fn walls(&self, round: usize, index: u32) -> [[i64; 2]; 3] {
        let at = self.place(round, index);
        std::array::from_fn(|k| [self.wall(round, k, at[k]), self.wall(round, k, at[k] + 1)])
    }

    /// The cells of a brick of the first round.
    pub(super) fn block(&self, index: u32) -> GridBlock {
        let walls = self.walls(0, index);
        let cell = |k: usize, x: i64| x.clamp(0, 4 * i64::from(self.cells[k])) as u32 / 4;
        GridBlock {
            lo: std::array::from_fn(|k| cell(k, walls[k][0])),
            hi: std::array::from_fn(|k| cell(k, walls[k][1])),
        }
    }

    /// A brick as a box; those at the ends have no end there.
    pub(super) fn bounds(&self, round: usize, index: u32) -> Aabb {
        let at = self.place(round, index);
        let corner = |d: u32| DVec3::from_array(std::array::from_fn(|k| self.coordinate(round, k, at[k] + d)));
        Aabb::new(corner(0), corner(1))
    }

    /// Where the wall below a brick is along an axis.
    fn coordinate(&self, round: usize, axis: usize, at: u32) -> f64 {
        match self.wall(round, axis, at) {
            i64::MIN => f64::NEG_INFINITY,
            i64::MAX => f64::INFINITY,
            x => self.origin[axis] + 0.25 * x as f64 * self.cell,
        }
    }

    /// The brick of a round that holds a point.
    pub(super) fn holding(&self, round: usize, p: DVec3) -> u32 {
        let n = self.along(round);
        let at: [u32; 3] = std::array::from_fn(|k| {
            let x = ((p[k] - self.origin[k]) / self.cell * 4.0).floor();
            // The last wall that is not beyond the point.
            (1..n[k]).rev().find(|i| self.wall(round, k, *i) as f64 <= x).unwrap_or(0)
        });
        (at[2] * n[1] + at[1]) * n[0] + at[0]
    }

    /// The bricks of a round that come within some length of a box, ascending.
    pub(super) fn near(&self, round: usize, bounds: &Aabb, reach: f64) -> Vec<u32> {
        let (n, grown) = (self.along(round), bounds.grown(reach));
        // Axis by axis: of many bricks a box meets few.
        let [xs, ys, zs]: [Vec<u32>; 3] = std::array::from_fn(|k| {
            let wall = |i: u32| self.coordinate(round, k, i);
            (0..n[k]).filter(|i| wall(*i) < grown.hi[k] && grown.lo[k] < wall(i + 1)).collect()
        });
        let mut near = Vec::with_capacity(xs.len() * ys.len() * zs.len());
        for z in zs {
            ys.iter().for_each(|y| near.extend(xs.iter().map(|x| (z * n[1] + y) * n[0] + x)));
        }
        near
    }
}
