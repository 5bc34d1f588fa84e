//! Mesh improvement: the operators of \[LIS14\] and what they need to leave a mesh an engineer can compute on.
//!
//! Every operator is a function over an [`EditMesh`](crate::mesh::EditMesh) and a
//! [`SurfaceOracle`](crate::geometry::SurfaceOracle), the only thing known of the surface, so what serves an R-function
//! part serves a B-rep or a scan. [`improve`] runs a sequence of them.
//!
//! | \[LIS14\] | here |
//! |---|---|
//! | ε_n (4, 5) | [`normal_deviation`], [`survey`] |
//! | N (6, 7) | [`align_normals`] |
//! | dual mesh, N1 (8–11) | [`dual_nodes`], [`snap_to_planes`] |
//! | R_all (12, 13) | [`smooth_all`] |
//! | C, G (14, 15) | [`node_curvature`](crate::mesh::curvature::node_curvature); classes take normals over a disc instead |
//! | P_corner, P_edge, P_regular (16, 17) | [`classify_by_curvature`] |
//! | R_regular (18), R_edge (19, 20) | [`smooth_regular`], [`smooth_edges`] |
//! | densification | [`densify`], [`Sizing`](crate::sizing::Sizing) |
//! | removal of degenerate elements | [`remove_degenerate`], [`collapse_short`] |
//! | projection | [`project`] |
//! | beyond the paper | [`cut_creases`], [`settle_creases`], [`flip_for_normals`], [`flip_for_angles`], [`relax_worst`] |
//!
//! Operators that move nodes ask the oracle for all nodes at once from the unchanged mesh, in parallel, and then move
//! node by node in order of their ids, each move [guarded](guard): the answer does not depend on the number of threads.
//! Reach, where a function asks for it, is how far the oracle may look for the surface: about the edge length.

pub mod classify;
pub mod crease;
pub mod density;
pub mod dual;
pub mod flips;
pub mod grammar;
pub mod guard;
pub mod normal;
mod operator;
mod sequence;
mod sequences;
mod sheets;
pub mod size;
pub mod smooth;
pub mod surface;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use classify::{Classes, Kind, classify_by_curvature, classify_by_edges};
pub use crease::{CreaseReport, cut_creases, locate, mark_sharp, settle_creases};
pub use density::{Edits, ShortEdges, collapse_short, densify, relax_worst, remove_degenerate};
pub use dual::{dual_nodes, snap_to_planes};
pub use flips::{flip_for_angles, flip_for_normals};
pub use grammar::Sequence;
pub use guard::Moves;
pub use normal::align_normals;
pub use operator::Operator;
pub use sequence::{Options, Outcome, SequenceReport, improve, improve_with};
pub use sequences::{cut_sequence, operators_sequence, paper_sequence};
pub use size::node_sizes;
pub use smooth::{CreaseStep, smooth_all, smooth_edges, smooth_regular};
pub use surface::{NormalDeviation, normal_deviation, project, survey};
