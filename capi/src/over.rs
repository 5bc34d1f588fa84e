//! What is asked of finished meshes as surfaces: values carried to other points, ways over one, and several joined to one.

use std::ffi::c_int;

use rvachev::DVec3;
use rvachev::mesh::{MeshPath, TriMesh, carry, shortest_path};
use rvachev::pipeline::{SizeRequest, join};
use rvachev::spatial::Aabb;

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, release, slot, usage};
use crate::mesh::{RvMesh, Source, give, lend};
use crate::options::{RvOptions, asked};
use crate::pass::{Items, Out, Room, flat, point};
use crate::work::work;

/// What is to be carried: see the header.
#[repr(C)]
pub struct RvCarry {
    values: Items<f64>,
    width: usize,
    xyz: Items<f64>,
    count: usize,
    carried: Room<f64>,
    distances: Room<f64>,
}

/// A way over a mesh.
pub struct RvPath(MeshPath);

/// Carries values at a mesh's nodes to points.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_carry(mesh: Option<&RvMesh>, what: Option<&RvCarry>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let (mesh, what) = (given(mesh, "mesh")?.mesh(), given(what, "what")?);
        let (width, count) = (what.width, what.count);
        let numbers = |n: usize, name: &str| {
            n.checked_mul(width).ok_or_else(|| usage(format!("{name} cannot have {n} times {width} items")))
        };
        let values = what.values.slice(numbers(mesh.nodes.len(), "values")?, "values")?;
        let size = count.checked_mul(3).ok_or_else(|| usage(format!("xyz cannot have {count} points")))?;
        let points = what.xyz.slice(size, "xyz")?.as_chunks().0;
        let points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(*p)).collect();
        what.carried.needed(numbers(count, "carried")?, "carried")?;
        let (all, distances) = work(None, 0, |run| {
            let (mut all, mut distances) = (vec![0.0; width * count], Vec::new());
            // Three numbers at a time, so nearest triangles are looked for a third as often; once where only distances are wanted.
            for first in (0..width.max(1)).step_by(3) {
                let used = 3.min(width - first.min(width));
                let three = |i: usize| {
                    let at = i * width + first;
                    DVec3::from_array(std::array::from_fn(|k| if k < used { values[at + k] } else { 0.0 }))
                };
                let rows: Vec<DVec3> = (0..mesh.nodes.len()).map(three).collect();
                let made = carry(mesh, &rows, &points, run)?;
                for (i, v) in made.values.iter().enumerate() {
                    all[i * width + first..][..used].copy_from_slice(&v.to_array()[..used]);
                }
                distances = made.distances;
            }
            Ok((all, distances))
        })?;
        what.carried.fill(&all);
        what.distances.fill(&distances);
        Ok(GOOD)
    })
}

/// The shortest way over a mesh.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_path(
    mesh: Option<&RvMesh>,
    from: Items<f64>,
    to: Items<f64>,
    path: Out<'_, *mut RvPath>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(path, std::ptr::null_mut(), "path")?;
        let mesh = given(mesh, "mesh")?.mesh();
        let (from, to) = (point(&from, "from")?, point(&to, "to")?);
        let made = work(None, 0, |run| Ok(shortest_path(mesh, from, to, run)?))?;
        out.write(Box::into_raw(Box::new(RvPath(made))));
        Ok(GOOD)
    })
}

/// Joins meshes to one where their nodes match.
#[unsafe(no_mangle)]
pub extern "C" fn rv_mesh_join(
    meshes: Items<Option<&RvMesh>>,
    count: usize,
    options: Option<&RvOptions>,
    joined: Out<'_, *mut RvMesh>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(joined, std::ptr::null_mut(), "joined")?;
        let all = meshes.slice(count, "meshes")?.iter();
        let all: Vec<TriMesh> = all.map(|m| Ok(given(*m, "a mesh")?.mesh().clone())).collect::<Result<_, Failure>>()?;
        let asked = asked(options);
        let within = match asked.within {
            SizeRequest::Length(length) => length,
            SizeRequest::Share(share) => share * all.iter().fold(Aabb::EMPTY, |b, m| b.union(&m.bounds())).diagonal(),
        };
        let made = work(asked.run.as_ref(), asked.threads, |run| Ok(join(&all, within, run)?))?;
        give(Source::Joined(made), &asked, Some(out))
    })
}

/// The points of a way, `count` of them.
#[unsafe(no_mangle)]
pub extern "C" fn rv_path_points(
    path: Option<&RvPath>,
    xyz: Out<'_, *const f64>,
    count: Out<'_, usize>,
    error: ErrorOut<'_>,
) -> c_int {
    lend(xyz, count, error, || {
        let points = &given(path, "path")?.0.points;
        Ok((flat(points).as_ptr(), points.len()))
    })
}

/// The length of a way.
#[unsafe(no_mangle)]
pub extern "C" fn rv_path_length(path: Option<&RvPath>, length: Out<'_, f64>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(length, 0.0, "length")?;
        out.write(given(path, "path")?.0.length);
        Ok(GOOD)
    })
}

/// Frees a way; what was lent of it is gone.
#[unsafe(no_mangle)]
pub extern "C" fn rv_path_free(path: Option<Box<RvPath>>) {
    release(path);
}
