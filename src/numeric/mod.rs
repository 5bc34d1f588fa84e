//! Numbers: intervals, root bracketing, small dense algebra, clustering, exact predicates.
