//! The page that shows a mesh.

use std::ffi::c_int;

use rvachev::page::{PageText, page};
use rvachev::pipeline::{shown, shown_healed};

use crate::errors::{ErrorOut, GOOD, entry, given, slot};
use crate::mesh::{RvMesh, Source};
use crate::pass::{Chars, Out, c_string};
use crate::text::{RvText, text};
use crate::work::work;

/// One HTML page that shows the mesh, its faces, certificate and shortfalls.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_page(
    mesh: Option<&RvMesh>,
    title: Chars,
    page: Out<'_, *mut RvText>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(page, std::ptr::null_mut(), "page")?;
        let (mesh, title) = (given(mesh, "mesh")?, title.text("title")?);
        let made = work(None, 0, |run| {
            let told = match &mesh.source {
                Source::Made(m) => shown(m, title),
                Source::Healed(h) => shown_healed(h, title, run)?,
                Source::Read(_) | Source::Joined(_) => PageText { title: title.into(), ..PageText::default() },
            };
            Ok(self::page(mesh.mesh(), &told, run)?)
        })?;
        out.write(text(c_string(&made)));
        Ok(GOOD)
    })
}
