//! Mesh improvement.
pub mod classify;
pub mod crease;
pub mod density;
pub mod dual;
pub mod flips;
pub mod guard;
pub mod normal;
mod sequence;
pub mod size;
pub mod smooth;
pub mod surface;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod explore;
pub use sequence::*;
