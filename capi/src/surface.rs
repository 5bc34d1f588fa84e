//! Surfaces of triangles in arrays: meshed anew, healed.

use std::ffi::c_int;

use rvachev::mesh::TriMesh;
use rvachev::{DVec3, Error, Place, pipeline};

use crate::errors::{ErrorOut, Failure, entry, given, slot};
use crate::mesh::{RvMesh, Source, give};
use crate::options::{RvOptions, asked};
use crate::pass::{Items, Out};
use crate::work::work;

/// A surface in the caller's arrays.
#[repr(C)]
pub struct RvSurface {
    /// Three numbers of each point.
    points: Items<f64>,
    /// How many points.
    point_count: usize,
    /// Three points of each triangle, from 0.
    triangles: Items<u32>,
    /// How many triangles.
    triangle_count: usize,
}

impl RvSurface {
    /// A mesh of these.
    ///
    /// Errors: usage for arrays that are not there, input for points that are not finite and triangles that name points there are not.
    pub fn mesh(&self) -> Result<TriMesh, Failure> {
        let points = self.points.slice(self.point_count.saturating_mul(3), "surface.points")?;
        let triangles = self.triangles.slice(self.triangle_count.saturating_mul(3), "surface.triangles")?;
        let bad = |place: String, what: String| Failure::Library(Error::input(Place::Item(place), what));
        let nodes: Vec<DVec3> = points.chunks_exact(3).map(DVec3::from_slice).collect();
        if let Some(i) = nodes.iter().position(|p| !p.is_finite()) {
            return Err(bad(format!("point {i}"), format!("it is not finite: {}", nodes[i])));
        }
        let list: Vec<[u32; 3]> = triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        if let Some(t) = list.iter().position(|t| t.iter().any(|v| *v as usize >= nodes.len())) {
            return Err(bad(format!("triangle {t}"), format!("{:?} is not of {} points", list[t], nodes.len())));
        }
        Ok(TriMesh::new(nodes, list))
    }
}

/// Meshes a surface of triangles anew, its faces, edges and corners found.
#[unsafe(no_mangle)]
pub extern "C" fn rv_remesh(
    surface: Option<&RvSurface>,
    options: Option<&RvOptions>,
    mesh: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(mesh, std::ptr::null_mut(), "mesh")?;
        let (input, asked) = (given(surface, "surface")?.mesh()?, asked(options));
        let made = work(asked.run.as_ref(), asked.threads, |run| {
            Ok(pipeline::mesh_soup(&input, &asked.mesh, &asked.soup, run)?)
        })?;
        give(Source::Made(Box::new(made)), &asked, Some(out))
    })
}

/// Sets right what is wrong with a surface: gaps, holes, overlaps, intersections.
#[unsafe(no_mangle)]
pub extern "C" fn rv_heal(
    surface: Option<&RvSurface>,
    options: Option<&RvOptions>,
    mesh: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(mesh, std::ptr::null_mut(), "mesh")?;
        let (input, asked) = (given(surface, "surface")?.mesh()?, asked(options));
        let healed = work(asked.run.as_ref(), asked.threads, |run| Ok(pipeline::heal(&input, &asked.heal, run)?))?;
        give(Source::Healed(healed), &asked, Some(out))
    })
}
