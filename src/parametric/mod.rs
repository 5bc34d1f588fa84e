//! Boundary representations: curves, surfaces, faces between edges, read from STEP files and meshed face by face.

pub mod basis;
mod curve;
mod frame;
pub mod nurbs;
mod surface;

pub use curve::Curve;
pub use frame::{Frame, Similarity};
pub use surface::{Pole, Surface};
