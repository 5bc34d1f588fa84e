//! Boundary representations: curves, surfaces, faces between edges, read from STEP files and meshed face by face.

pub mod audit;
pub mod basis;
pub mod brep;
pub mod build;
mod chart;
mod curve;
pub mod family;
mod frame;
pub mod measure;
mod meridian;
pub mod mesh;
pub mod nurbs;
mod peaks;
mod pieces;
pub mod step;
mod surface;

pub use curve::Curve;
pub use frame::{Frame, Similarity};
pub use mesh::Parametric;
pub use surface::{Pole, Surface};
