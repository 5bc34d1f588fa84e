//! Structured blocks.
