//! The functional merge of \[LAZ\]: fragments on a model, read as one mesh without building it.
//!
//! Nodes two fragments share are found from topology, never by distance, and a whole edge at a time. The merged mesh is a
//! set of functions: the number of a node gives the fragment that keeps it, the number of a cell the numbers of its nodes.
//! So merging takes time and memory per vertex, edge and face, whatever the number of nodes and cells.
//!
//! *Guarantees.* Every node of the fragments has one number, the same in all fragments that share it; nodes of vertices
//! come first, then inner nodes of edges, then inner nodes of faces, each in the model's order; cells keep the order of
//! faces and fragments. Fragments that are not node-matched are refused by name of the edge.
//!
//! *Does not guarantee.* That the model is a closed surface, or that cells are well shaped. Fragments are compared by
//! fingerprints of 64 bits.
//!
//! *References.* \[LAZ\] V. V. Lazarev, "An efficient algorithm for merging node-matched fragments of surface grids" (in
//! Russian), with the prefix sum of 4.3 without its -1, `s(i) <= j < s(i + 1)`, and an edge's inner nodes without its ends.

mod blocks;
mod edit;
mod join;
mod numbering;
mod reordered;
pub mod sets;
mod view;

#[cfg(test)]
mod blocks_tests;
#[cfg(test)]
mod edit_tests;
#[cfg(test)]
mod tests;

pub use blocks::{Blocks, HexahedraBlock};
pub use edit::{Addition, Detached};
pub use join::{JoinReport, Joined, join};
pub use reordered::Reordered;
pub use view::{Merged, Place, Replacement};
