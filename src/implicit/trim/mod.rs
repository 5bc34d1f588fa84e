//! The surface made face by face: every leaf's own surface is meshed, cut by the others, and what bounds the solid is sewn
//! together along the edges.
//!
//! A leaf's own surface is smooth on the scale of the cells however close another leaf comes to it, so tips of sharp edges
//! and walls far thinner than the cells come out whole, which marching cubes on the solid loses. What is smaller than
//! the cells *on* a surface may still be missed, and two leaves that touch leave signs to rounding: then the parts do not
//! fit together and there is no mesh.

mod arrange;
mod crowds;
mod ends;
mod refine;
mod sew;
mod sheet;
mod strands;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use super::extract::Extracted;
use super::model::Implicit;
use super::newton::leaves_of;
use super::octree::Cell;
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::{Aabb, Bvh};
use arrange::{Part, arrange};
use crowds::{Crowd, touching};
use ends::Ends;
use refine::{pin, refine};
use sew::sew;
use sheet::{Sheet, sheet};
use strands::crossing_strands;

/// A closed mesh of a solid whose every triangle lies on one leaf.
#[derive(Debug, Clone)]
pub struct Trimmed {
    /// The mesh; labels are the leaves. Nodes lie on their leaves to rounding, but for those at points without a normal.
    pub mesh: TriMesh,
    /// For each node the leaves it lies on: one inside a face, two on an edge, more at a corner.
    pub leaves: Vec<Vec<u32>>,
    /// For each triangle its face, by number; empty where the leaf tells it.
    pub faces: Vec<u32>,
}

/// Places where the parts do not fit together.
type Unfit = Vec<DVec3>;

/// Where the parts do not fit together the sheets are made finer, so many times at most,
const FINER: i32 = 4;
/// within this many of the triangles there at that time,
const AROUND: f64 = 2.0;
/// and as long as there are no more than this many times the triangles of the cells;
const MOST: f64 = 2.0;
/// what has this many times more is not tried at all.
const TOO_MANY: f64 = 2.0;

/// Points where more than three leaves meet are the same if they are nearer to each other than this share of a cell.
const PINNED: f64 = 1e-4;
/// Around points where leaves touch there should be room for so many sides of sheets.
const ROOM: f64 = 1.0;
/// Such points are looked for again after those known are nodes, so many times at most.
const PINNINGS: usize = 4;

/// The sheet of a leaf, the cells it is in, and what it contributes.
struct Piece<'a> {
    leaf: u32,
    cells: Vec<&'a Cell>,
    sheet: Sheet,
    part: Option<Result<Part, Unfit>>,
}

/// Meshes each leaf's surface in the cells of an extraction, keeps what bounds the solid, and sews it together. Where that does
/// not fit, points where more than three leaves meet become nodes of all their sheets; where it still does not, as where two
/// leaves are nearly tangent, or where strands of edges are closer than chords are high, the sheets are halved a few times.
///
/// `None` where the parts do not fit together. The result is closed and oriented; triangles may still intersect.
pub(crate) fn trimmed(model: &Implicit, extracted: &Extracted, run: &Run) -> crate::error::Result<Option<Trimmed>> {
    run.install(|| {
        let (h, scale) = (extracted.bricks.grid.h, model.bounds().diagonal());
        let ends = Ends::new(&model.leaves);
        let mut pieces = sheets(model, extracted, run)?;
        let count = |pieces: &[Piece<'_>]| pieces.iter().map(|p| p.sheet.triangles.len()).sum::<usize>() as f64;
        let mut most = MOST * count(&pieces);
        let mut sewn = None;
        let (mut times, mut pinnings) = (0, 0);
        let mut pinned: Vec<Crowd> = Vec::new();
        loop {
            pieces.par_iter_mut().filter(|p| p.part.is_none()).try_for_each(|p| {
                run.check()?;
                p.part = Some(arrange((model, &ends), p.leaf, &p.sheet, &p.cells, h));
                Ok(())
            })?;
            let parts: Vec<&Part> = pieces.iter().filter_map(|p| p.part.as_ref()?.as_ref().ok()).collect();
            let mut crowded = Vec::new();
            let mut unfit: Unfit = if parts.len() == pieces.len() {
                match sew(model, &parts, h, times > 0, &pinned, &mut crowded) {
                    Ok((made, strands)) => {
                        let close = crossing_strands(&strands, &made.mesh.nodes);
                        sewn = Some(made);
                        close
                    }
                    Err(unfit) => unfit,
                }
            } else {
                pieces.iter().filter_map(|p| p.part.as_ref()?.as_ref().err()).flatten().copied().collect()
            };
            unfit.retain(|p| p.is_finite());
            if unfit.is_empty() {
                break;
            }
            let reach = h * 0.5f64.powi(times);
            let places = Bvh::new(unfit.iter().map(|p| Aabb::new(*p, *p).grown(AROUND * reach)).collect());
            let is_new = |c: &Crowd| {
                let mut near = false;
                places.overlapping(&Aabb::new(c.at, c.at), |_| near = true);
                near && pinned.iter().all(|q| q.at.distance(c.at) > PINNED * h)
            };
            crowded.retain(is_new);
            let finest = times == FINER || count(&pieces) > most;
            // Leaves that are merely close to touching come apart in finer sheets, and points of a crowd get room there: that is
            // tried first.
            if crowded.is_empty() && times > 0 && pinnings < PINNINGS {
                let own: Vec<u32> = pieces.iter().map(|p| p.leaf).collect();
                crowded = touching(&model.leaves, &own, &unfit, reach, scale);
                crowded.retain(is_new);
                let near = |a: &Crowd, b: &Crowd| a.at.distance(b.at) < ROOM * reach;
                let tight = (1..crowded.len()).any(|k| crowded[..k].iter().any(|c| near(c, &crowded[k])));
                if tight && !finest {
                    crowded.clear();
                }
            }
            if !crowded.is_empty() && pinnings < PINNINGS {
                pinnings += 1;
                let before = count(&pieces);
                for piece in &mut pieces {
                    for crowd in crowded.iter().filter(|c| c.leaves.contains(&piece.leaf)) {
                        pin(&mut piece.sheet, &model.leaves, piece.leaf, crowd, scale);
                        piece.part = None;
                    }
                }
                most += count(&pieces) - before;
                pinned.extend(crowded);
                continue;
            }
            if finest {
                break;
            }
            times += 1;
            for p in &mut pieces {
                if refine(&mut p.sheet, &model.leaves, p.leaf, &places, scale) {
                    p.part = None;
                }
            }
            if count(&pieces) > TOO_MANY * most {
                break;
            }
        }
        Ok(sewn)
    })
}

/// Every leaf's own surface.
fn sheets<'a>(model: &Implicit, extracted: &'a Extracted, run: &Run) -> crate::error::Result<Vec<Piece<'a>>> {
    let grid = &extracted.bricks.grid;
    let cells: Vec<&Cell> = extracted.bricks.cells.iter().chain(&extracted.undecided).collect();
    let mut of_leaf: Vec<Vec<&Cell>> = vec![Vec::new(); model.leaves.len()];
    for cell in cells {
        leaves_of(&cell.tape).into_iter().for_each(|l| of_leaf[l as usize].push(cell));
    }
    let scale = model.bounds().diagonal();
    let own = of_leaf.into_par_iter().enumerate().filter(|x| !x.1.is_empty());
    own.map(|(leaf, cells)| {
        run.check()?;
        let sheet = sheet(&model.leaves[leaf], grid, &cells, scale);
        Ok(Piece { leaf: leaf as u32, cells, sheet, part: None })
    })
    .collect()
}

/// Whether a number counts as on a leaf's positive side.
fn positive(v: f64) -> bool {
    v >= 0.0
}

/// A point between two others by their values, of which one is positive.
fn share(a: f64, b: f64) -> f64 {
    (a / (a - b)).clamp(0.0, 1.0)
}

fn place(nodes: &[DVec3], corners: [u32; 3], weights: [f64; 3]) -> DVec3 {
    (0..3).map(|k| nodes[corners[k] as usize] * weights[k]).sum()
}
