//! Blunting: the signs at grid nodes changed where solid or gap is thinner than a cell, so that along the tips of sharp
//! edges marching cubes finds one smooth front instead of scattered bits and handles.
//!
//! Behind a smooth surface every node has, along each axis, a neighbor on its own side. A node that has none along some
//! axis lies in a tip less than two cells thick; it goes to the other side, and so on until none is left.

use rayon::prelude::*;

use super::batch::SIDE;
use super::octree::{BRICK, Bricks};

/// Sign bits of a brick's corners: bit i of row j + 9 k is corner (i, j, k).
pub(super) type Rows = [u16; SIDE * SIDE];

/// Rounds of changing signs: each takes one layer of nodes off a tip.
const ROUNDS: usize = 24;

/// Changes signs of corners of bricks that have some of each; `rows[i]` is there for these.
pub(super) fn blunt(bricks: &Bricks, rows: &mut [Option<Box<Rows>>]) {
    // First tips of the solid, then tips of gaps.
    for inside in [true, false] {
        for _ in 0..ROUNDS {
            let this = &*rows;
            let one = |i: usize| {
                let own = this[i].as_ref()?;
                let at = bricks.cells[i].at;
                let below = |axis: usize| {
                    let mut next = at;
                    next[axis] = next[axis].checked_sub(1)?;
                    this[bricks.find(next)?].as_deref()
                };
                let found = tips(own, [below(0), below(1), below(2)], inside);
                found.iter().any(|m| *m != 0).then_some((i, found))
            };
            let found: Vec<(usize, [u8; BRICK * BRICK])> = (0..rows.len()).into_par_iter().filter_map(one).collect();
            if found.is_empty() {
                break;
            }
            for (i, masks) in found {
                change(bricks, rows, bricks.cells[i].at, &masks);
            }
        }
    }
}

/// The corners of a brick, without those at its upper sides, that have no neighbor on their own side along some axis.
/// A brick below that is not there has the sign of the corners it shares.
fn tips(own: &Rows, below: [Option<&Rows>; 3], inside: bool) -> [u8; BRICK * BRICK] {
    let side = |row: u16| if inside { row } else { !row };
    std::array::from_fn(|n| {
        let (j, k) = (n % BRICK, n / BRICK);
        let row = |j: usize, k: usize| side(own[j + SIDE * k]);
        let r = row(j, k);
        let first = below[0].map_or(r & 1, |b| side(b[j + SIDE * k]) >> (BRICK - 1) & 1);
        let x = r << 1 | first | r >> 1;
        let before = |axis: usize, j: usize, k: usize| below[axis].map_or(r, |b| side(b[j + SIDE * k]));
        let y = row(j + 1, k) | if j > 0 { row(j - 1, k) } else { before(1, BRICK - 1, k) };
        let z = row(j, k + 1) | if k > 0 { row(j, k - 1) } else { before(2, j, BRICK - 1) };
        (r & !(x & y & z) & 0xff) as u8
    })
}

/// Changes the signs of some corners of a brick, in all bricks that share them.
fn change(bricks: &Bricks, rows: &mut [Option<Box<Rows>>], at: [u32; 3], masks: &[u8; BRICK * BRICK]) {
    for which in 0..8usize {
        let down: [usize; 3] = std::array::from_fn(|k| which >> k & 1);
        if (0..3).any(|k| at[k] < down[k] as u32) {
            continue;
        }
        let Some(i) = bricks.find(std::array::from_fn(|k| at[k] - down[k] as u32)) else { continue };
        let Some(rows) = rows[i].as_mut() else { continue };
        for (n, mask) in masks.iter().enumerate().filter(|(_, m)| **m != 0) {
            let (j, k) = (n % BRICK, n / BRICK);
            // Only corners at the lower sides are shared with bricks below.
            if (down[1] == 1 && j > 0) || (down[2] == 1 && k > 0) {
                continue;
            }
            let row = &mut rows[j + BRICK * down[1] + SIDE * (k + BRICK * down[2])];
            *row ^= if down[0] == 1 { u16::from(mask & 1) << BRICK } else { u16::from(*mask) };
        }
    }
}
