//! Our side: R-functions of normalized leaves, meshed by octree and marching cubes.

use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::{ExtractOptions, Implicit, Placement, Primitive, RSystem, Solid, Tpms, extract};

use crate::part::{Part, Shape};

/// Meshes a part with cells as large as N to the side of its cube, on one thread; the number of triangles.
pub fn mesh(part: &Part, n: u32, rsystem: RSystem) -> usize {
    let size = 2.0 * part.half / f64::from(n);
    let run = Run::new().with_threads(1).expect("one thread");
    let model = Implicit::new(&solid(&part.shape), rsystem, None).expect("a bounded solid");
    extract(&model, &ExtractOptions::new(size), &run).expect("a mesh").mesh.triangles.len()
}

fn solid(shape: &Shape) -> Solid {
    match shape {
        Shape::Cuboid(lo, hi) => Solid::cuboid(*lo, *hi),
        Shape::Sphere(center, r) => Solid::sphere(*r, *center),
        Shape::Cylinder(center, axis, r, half) => Solid::cylinder(*r, *axis, *center, half.map(|h| 2.0 * h)),
        Shape::HalfSpace(normal, offset) => Solid::half_space(*normal, *normal * *offset),
        Shape::Gyroid(period, thickness) => {
            Primitive::Tpms { kind: Tpms::Gyroid, period: *period, thickness: *thickness, at: DVec3::ZERO }.into()
        }
        Shape::All(of) => Solid::intersection(of.iter().map(solid)),
        Shape::Any(of) => Solid::union(of.iter().map(solid)),
        Shape::Not(of) => !solid(of),
        Shape::Turned(by, of) => solid(of).placed(turned(*by)),
    }
}

fn turned(rotation: DMat3) -> Placement {
    Placement { rotation, scale: 1.0, shift: DVec3::ZERO }
}
