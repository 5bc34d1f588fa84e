//! Room optimize.
