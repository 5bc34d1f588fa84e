//! Pictures of meshes: pixels, lent, and PNG files.

use std::ffi::c_int;
use std::ptr::{null, null_mut};

use rvachev::pipeline::{self, TrueSurface};
use rvachev::render;

use crate::errors::{ErrorOut, GOOD, entry, given, release, slot, usage};
use crate::mesh::RvMesh;
use crate::options::{RvOptions, asked};
use crate::part::RvPart;
use crate::pass::{Chars, Out};
use crate::work::work;

/// A picture.
pub struct RvPicture {
    picture: render::Picture,
    /// Red, green, blue and opacity of each pixel.
    rgba: Vec<u8>,
}

impl RvPicture {
    fn new(picture: render::Picture) -> Self {
        RvPicture { rgba: picture.rgba(), picture }
    }
}

/// Draws a mesh as `rvachev render` does, for colors that tell distances with the part they are measured from.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_picture(
    mesh: Option<&RvMesh>,
    part: Option<&RvPart>,
    options: Option<&RvOptions>,
    picture: Out<'_, *mut RvPicture>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(picture, null_mut(), "picture")?;
        let (mesh, asked) = (given(mesh, "mesh")?, asked(options));
        let mut how = asked.picture.clone();
        how.against = match (part, &asked.against) {
            (Some(_), Some(_)) => return Err(usage("distances are measured from a part or a file, not from both")),
            (Some(part), None) => Some(TrueSurface::Part(Box::new(part.part()))),
            (None, Some(path)) => Some(TrueSurface::File { path: path.clone(), overrides: asked.define.clone() }),
            (None, None) => None,
        };
        let drawn = work(asked.run.as_ref(), asked.threads, |run| Ok(pipeline::picture(mesh.mesh(), &how, run)?))?;
        out.write(Box::into_raw(Box::new(RvPicture::new(drawn))));
        Ok(GOOD)
    })
}

/// Lends the pixels, four bytes of each, row by row from the top left.
#[unsafe(no_mangle)]
pub extern "C" fn rv_picture_pixels(
    picture: Option<&RvPicture>,
    rgba: Out<'_, *const u8>,
    width: Out<'_, usize>,
    height: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let rgba = slot(rgba, null(), "rgba")?;
        let (width, height) = (slot(width, 0, "width")?, slot(height, 0, "height")?);
        let of = given(picture, "picture")?;
        rgba.write(of.rgba.as_ptr());
        width.write(of.picture.width);
        height.write(of.picture.height);
        Ok(GOOD)
    })
}

/// Writes a PNG file.
#[unsafe(no_mangle)]
pub extern "C" fn rv_picture_write(picture: Option<&RvPicture>, path: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let (of, path) = (given(picture, "picture")?, path.path("path")?);
        pipeline::write_picture(&path, &of.picture)?;
        Ok(GOOD)
    })
}

/// Frees a picture; what was lent of it is gone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_picture_free(picture: Option<Box<RvPicture>>) {
    release(picture);
}
