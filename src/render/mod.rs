//! Pictures of meshes, drawn by us: no window, no GPU.

mod font;
mod paint;
mod picture;
mod raster;
mod sheet;
#[cfg(test)]
mod tests;

pub use paint::{ColorBy, RenderOptions, render};
pub use picture::Picture;
pub use sheet::sheet;
