//! **rvachev** turns solids into triangle surface meshes an engineer can compute on.
//!
//! A solid written as a tree of R-functions (V. L. Rvachev) goes in, a closed, oriented triangle mesh with named faces
//! comes out, together with a quality report. `ARCHITECTURE.md` describes the rooms; a room imports only rooms listed
//! above it there, which `tests/tidy.rs` enforces.
//!
//! Conventions that hold everywhere: inside is `f > 0`, the outward normal is `-grad f / |grad f|`, triangles wind
//! counter-clockwise seen from outside, lengths are in the part's own unit, angles of the public API are in degrees.

pub mod error;
pub mod run;

pub mod numeric;

pub mod spatial;

pub mod planar;

pub mod mesh;

pub mod geometry;

pub mod model;

pub mod quality;

pub mod io;
pub mod page;
pub mod render;

pub mod discrete;
pub mod implicit;
pub mod parametric;

pub mod heal;

pub mod merge;

pub mod optimize;

pub mod pipeline;

pub use error::{Error, Place, Result};
pub use glam::DVec3;
pub use run::Run;

/// The snippets of the README compile and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
