//! Triangle soups as models: feature edges, geometric edges, vertices and faces are found in the triangles, after \[GUO\].
//!
//! The steps are those of the paper, each a function of its own: [`mark_feature_edges`], [`chains`] and
//! [`mark_vertices`], [`flood`], [`simplify`](fn@simplify). [`Discrete`] runs them and answers as [`Pieces`](crate::geometry::Pieces)
//! for the shared remesher: a face's surface is its triangles, an edge's curve its polyline, so nodes on features lie on
//! the input's features to rounding.
//!
//! *Does not guarantee* that a feature the input's triangles do not show (a fillet coarser than the angle asked for, an
//! edge that marching cubes cut off) is found.
//!
//! \[GUO\]: Guo Y. et al., "B-Rep construction, feature simplification and mesh generation for discrete models" (in
//! Chinese).

mod features;
mod needles;
mod pieces;
mod sheet;
mod simplify;
mod sizes;
#[cfg(test)]
mod tests;
mod walls;

pub use features::{Chain, bridge_gaps, chains, drop_islands, drop_noise, flood, mark_feature_edges, mark_vertices};
pub use needles::mend_needles;
pub(crate) use pieces::TORN_WIDTH;
pub use pieces::{Discrete, DiscreteOptions};
pub use simplify::{Limits, Removed, Torn, drop_crowded, simplify, torn_nodes};
pub use walls::WallSizes;
