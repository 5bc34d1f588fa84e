//! A mesh brick by brick: a plan, pieces that are pure functions of the plan, and their merge.
//!
//! All bricks share one grid, on which the leaves are [arranged](crate::implicit): what a brick of it gives is what the whole
//! grid gives there, and nodes where bricks meet come out the same on both sides, bit by bit. Round by round what lies away from
//! the walls between bricks is remeshed with the nodes at the walls where they are. The triangles beside them are handed on to
//! the next round, whose bricks are shifted by half, so that walls of one round are inside the bricks of the next; a third round
//! does what is left where walls of both cross. Merging joins nodes by what they are called, never by where they are.
//!
//! *Guarantees*: equal bytes for equal plans, by any number of workers in any order; nothing that does not match is merged.
//! *Does not guarantee*: that no triangles intersect (merging tells), nor the mesh that one piece would give.
//! Sources: \[LAZ\] for merging by descriptors alone.

mod blocks;
mod bytes;
mod file;
mod history;
mod merge;
mod plan;
mod portions;
mod rounds;

pub use merge::{MergedBricks, merge_bricks, merge_on_disk};
pub use plan::{BrickPlan, PlanOptions, PlanSource};
pub use portions::PiecewiseMesh;
pub use rounds::{ROUNDS, Share, make_bricks, make_piece, merge_pieces, mesh_bricks};
pub(super) use rounds::{fans_apart, open_nodes};
