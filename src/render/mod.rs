//! Pictures of meshes without a window or a graphics card.
//!
//! An orthographic z-buffer rasterizer with supersampling: faces colored by name or triangles by quality, flat shading
//! with light from beside the camera, triangle edges, and on top sharp edges, face borders and open boundaries.
//!
//! *Guarantees.* The same mesh and options give the same bytes for any number of threads. Memory beyond the picture is a
//! few dozen bytes per triangle and one band of samples per thread.
//!
//! *Does not guarantee.* Colors of faces may change between releases. Hidden lines are hidden by depth at a line's own
//! width of tolerance: through walls thinner than that a line may shine.

mod edges;
mod font;
mod palette;
mod picture;
mod raster;

#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::run::Run;

pub use picture::{Picture, sheet};

/// The largest width and height, in pixels: four bytes per pixel stay below 1 GiB.
const MAX_SIDE: usize = 16_384;

/// Where the mesh is seen from; always orthographic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the mesh towards the camera; any length but 0.
    pub towards: DVec3,
    /// The direction that points up in the picture as far as `towards` allows; z takes its place when both are parallel,
    /// and y when that is parallel as well.
    pub up: DVec3,
    /// The share of the picture kept free on every side, in 0..0.5.
    pub margin: f64,
    /// The ball (center and radius) that fills the picture; `None`: the whole mesh does.
    pub focus: Option<(DVec3, f64)>,
}

impl Default for View {
    /// Three quarters from the front right and above, z up.
    fn default() -> Self {
        Self { towards: DVec3::new(1.0, -1.3, 0.8), up: DVec3::Z, margin: 0.05, focus: None }
    }
}

impl View {
    /// Unit vectors to the right, upwards and towards the camera.
    fn axes(&self) -> Option<[DVec3; 3]> {
        let towards = self.towards.try_normalize()?;
        let up = [self.up, DVec3::Z, DVec3::Y];
        // Closer to parallel than a thousandth, the picture's tilt would hang on rounding.
        let right = up.iter().map(|u| u.normalize_or_zero().cross(towards)).find(|r| r.length() > 1e-3)?.normalize();
        Some([right, towards.cross(right), towards])
    }
}

/// What the colors of triangles tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorBy {
    /// The face: equal names have equal colors, faces that touch have different ones as long as 12 colors suffice.
    #[default]
    Face,
    /// The triangle's smallest angle, from red (0°) to blue (60°).
    Quality,
}

/// How a picture is made.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderOptions {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The point of view.
    pub view: View,
    /// Samples per pixel along each axis, 1..=8.
    pub samples: usize,
    /// What the colors tell.
    pub color_by: ColorBy,
    /// Whether triangle edges are drawn; `None`: when triangles are larger than a few pixels.
    pub wireframe: Option<bool>,
    /// Edges whose triangles' normals differ by more than this many degrees are drawn thick; `None`: no edges on top at
    /// all, neither sharp ones nor borders and boundaries.
    pub sharp_angle: Option<f64>,
    /// Whether a legend stands at the right: names of up to 16 faces, or the scale of quality.
    pub legend: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 1200,
            height: 900,
            view: View::default(),
            samples: 3,
            color_by: ColorBy::Face,
            wireframe: None,
            sharp_angle: Some(30.0),
            legend: true,
        }
    }
}

/// Draws a mesh.
///
/// # Errors
/// [`Error::Usage`] for options out of range; [`Error::Input`] for a mesh without triangles, with nodes that are not finite
/// or with indices out of range; [`Error::Cancelled`].
pub fn render(mesh: &TriMesh, options: &RenderOptions, run: &Run) -> Result<Picture> {
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&options.width) || !sides.contains(&options.height) {
        let size = format!("{} x {}", options.width, options.height);
        return Err(Error::Usage(format!("a picture of {size} pixels: sides are 1 to {MAX_SIDE}")));
    }
    if !(1..=8).contains(&options.samples) || !(0.0..0.5).contains(&options.view.margin) {
        return Err(Error::Usage("samples per axis are 1 to 8, the margin is at least 0 and below 0.5".into()));
    }
    if options.view.focus.is_some_and(|(c, r)| !(c.is_finite() && r > 0.0 && r.is_finite())) {
        return Err(Error::Usage("the ball in focus needs a finite center and a positive radius".into()));
    }
    let axes = options.view.axes().ok_or_else(|| Error::Usage("the view direction must be finite and not 0".into()))?;
    check(mesh)?;
    run.install(|| {
        let look = palette::Look::new(mesh, options.color_by);
        let mut picture = Picture::new(options.width, options.height, palette::BACKGROUND);
        let legend = if options.legend { look.legend(mesh, options.height) } else { None };
        // A legend that would leave less than half of the picture to the mesh is left out.
        let legend = legend.filter(|l| 2 * l.width <= options.width);
        let room = options.width - legend.as_ref().map_or(0, |l| l.width);
        let scene = raster::Scene::new(mesh, options, &axes, room, &look, run)?;
        scene.draw(&mut picture, run)?;
        if let Some(legend) = legend {
            legend.draw(&mut picture, room);
        }
        Ok(picture)
    })
}

fn check(mesh: &TriMesh) -> Result<()> {
    if mesh.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "the mesh has no triangle, there is nothing to draw"));
    }
    if let Some(v) = mesh.nodes.iter().position(|p| !p.is_finite()) {
        return Err(Error::input(Place::Item(format!("node {v}")), "its coordinates are not finite"));
    }
    let bad_corner = |t: usize| mesh.triangles[t].iter().any(|v| *v as usize >= mesh.nodes.len());
    let bad_label = |t: usize| mesh.labels.get(t).is_none_or(|l| *l as usize >= mesh.faces.len());
    match (0..mesh.triangles.len()).find(|t| bad_corner(*t) || bad_label(*t)) {
        Some(t) => Err(Error::input(
            Place::Item(format!("triangle {t}")),
            "it uses a node or lies on a face the mesh does not have",
        )),
        None => Ok(()),
    }
}
