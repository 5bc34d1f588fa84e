//! Pictures of meshes without a window or a graphics card.
//!
//! An orthographic z-buffer rasterizer with supersampling: faces colored by name or triangles by a measure, flat shading
//! with light from beside the camera, triangle edges, and on top sharp edges, face borders and open boundaries. Planes
//! across the axes may cut parts of the mesh away, to show what is inside.
//!
//! *Guarantees.* The same mesh and options give the same bytes for any number of threads. Memory beyond the picture is a
//! few dozen bytes per triangle and one band of samples per thread.
//!
//! *Does not guarantee.* Colors of faces may change between releases. Hidden lines are hidden by depth at a line's own
//! width of tolerance: through walls thinner than that a line may shine.

mod clip;
mod edges;
mod font;
mod options;
mod palette;
mod picture;
mod raster;

#[cfg(test)]
mod tests;

use crate::error::{Error, Place, Result};
use crate::mesh::{MeshView, TriMesh};
use crate::run::Run;

pub use options::{ClipPlane, ColorBy, KeptHalf, MAX_SIDE, RenderOptions, View};
pub use picture::{Picture, sheet};

/// Draws a mesh. One that is not kept in arrays is [copied](TriMesh::of_view) for it, and cells of more than three corners become fans.
///
/// # Errors
/// [`Error::Usage`] for options out of range, and for clipping planes that cut nothing away or leave nothing; [`Error::Input`] for a mesh without triangles, with nodes that are not finite
/// or with indices out of range; [`Error::Cancelled`].
pub fn render(mesh: &dyn MeshView, options: &RenderOptions, run: &Run) -> Result<Picture> {
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
    mesh.check()?;
    let mesh = &*run.install(|| TriMesh::of_view(mesh));
    check(mesh)?;
    if let ColorBy::Distance(d) = &options.color_by
        && d.len() != mesh.nodes.len()
    {
        return Err(Error::Usage(format!("{} distances for {} nodes", d.len(), mesh.nodes.len())));
    }
    if let ColorBy::Class(c) = &options.color_by
        && c.len() != mesh.nodes.len()
    {
        return Err(Error::Usage(format!("{} classes for {} nodes", c.len(), mesh.nodes.len())));
    }
    let clipping = clip::Clipping::new(mesh, &options.clips, axes[2])?;
    run.install(|| {
        let look = palette::TriangleColors::new(mesh, &options.color_by);
        let ground = if options.transparent { None } else { Some(palette::BACKGROUND) };
        let mut picture = Picture::on(options.width, options.height, ground);
        let legend = if options.legend { look.legend(mesh, &clipping, [options.width, options.height]) } else { None };
        let room = options.width - legend.as_ref().map_or(0, |l| l.width);
        let shot = raster::Shot { mesh, options, axes, clipping: &clipping, look: &look };
        let scene = raster::Scene::new(&shot, room, run)?;
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
