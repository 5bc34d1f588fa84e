//! Room quality.
