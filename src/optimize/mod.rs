//! Mesh improvement.
pub mod classify;
pub mod crease;
pub mod density;
pub mod dual;
#[cfg(test)]
mod explore;
pub mod flips;
pub mod guard;
pub mod normal;
mod sequence;
pub mod size;
pub mod smooth;
pub mod surface;
#[cfg(test)]
mod testing;
pub use sequence::*;
