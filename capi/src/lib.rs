//! The library for C, and for what calls C: opaque handles, status codes, borrowed arrays. `include/rvachev.h` is its description.
//!
//! Arguments are typed so that a pointer that may be NULL is an `Option`; what is left to trust is that pointers point to what
//! the header says, and that handles are freed once.

mod bricks;
mod check;
mod errors;
mod field;
mod grid;
mod mesh;
mod model;
mod options;
mod outline;
mod over;
mod page;
mod part;
mod pass;
mod picture;
mod prisms;
mod samples;
mod shape;
mod solid;
mod soups;
mod surface;
mod text;
mod values;
mod work;
