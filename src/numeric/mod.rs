//! Numbers: intervals, root bracketing, small dense algebra, clustering, exact predicates.

pub mod kmeans;
pub mod svd;
