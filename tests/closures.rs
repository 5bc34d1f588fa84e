//! Functions of the user's own, of which nothing is known but their values: their edges come out by default, whichever way they lie.

use glam::{DMat3, DVec3};
use rvachev::Run;
use rvachev::implicit::{Field, Placement, Solid};
use rvachev::pipeline::{MeshOptions, Part, SizeRequest, Tried, against, mesh_part};
use rvachev::spatial::Aabb;

const SIZE: f64 = 0.08;

/// The conjunction of [LIS14], positive where both are.
fn both(f: f64, g: f64) -> f64 {
    f + g - f.hypot(g)
}

fn cube(p: DVec3) -> f64 {
    let [x, y, z] = (p * p).to_array();
    both(both(1.0 - x, 1.0 - y), 1.0 - z)
}

/// Outside a cylinder of radius 0.4 around the axis in which these two coordinates are zero.
fn outside(a: f64, b: f64) -> f64 {
    a * a + b * b - 0.16
}

/// A sample as a function and as a solid, and how many corners it has.
struct Sample {
    name: &'static str,
    f: fn(DVec3) -> f64,
    solid: Solid,
    corners: usize,
}

fn samples() -> [Sample; 3] {
    let bore = |axis, at: [f64; 3]| Solid::cylinder(0.4, axis, at.into(), None);
    let block = || Solid::cuboid(DVec3::NEG_ONE, DVec3::ONE);
    [
        Sample {
            name: "holes",
            f: |p| both(both(cube(p), outside(p.x, p.y)), outside(p.y, p.z)),
            solid: block() - bore(DVec3::Z, [0.0; 3]) - bore(DVec3::X, [0.0; 3]),
            corners: 8,
        },
        Sample {
            name: "edges",
            f: |p| both(both(cube(p), outside(p.y - 0.9, p.z - 0.9)), outside(p.x + 0.9, p.y + 0.9)),
            solid: block() - bore(DVec3::X, [0.0, 0.9, 0.9]) - bore(DVec3::Z, [-0.9, -0.9, 0.0]),
            corners: 12,
        },
        Sample {
            name: "notch",
            f: |p| both(cube(p), (p - DVec3::ONE).length_squared() - 0.64),
            solid: block() - Solid::sphere(0.8, DVec3::ONE),
            corners: 10,
        },
    ]
}

/// Asked point by point from all threads at once.
struct Alone<F>(F);

impl<F: Fn(DVec3) -> f64 + Send + Sync> Field for Alone<F> {
    fn value(&self, p: DVec3) -> f64 {
        (self.0)(p)
    }

    fn in_batches(&self) -> bool {
        false
    }
}

#[test]
fn closures_of_the_samples_keep_their_edges_at_the_first_attempt() {
    let turned = DMat3::from_axis_angle(DVec3::new(0.3, -0.27, -0.89).normalize(), 2.7);
    for Sample { name, f, solid, corners } in samples() {
        for (way, rotation) in [("aligned", DMat3::IDENTITY), ("turned", turned)] {
            let back = rotation.transpose();
            let f = move |p: DVec3| f(back * p);
            // Those that are asked for many points at once take longer, as what they say is kept: one is enough.
            let field = if (name, way) == ("notch", "turned") { Solid::field(f) } else { Solid::field(Alone(f)) };
            let mut part = Part::from_solid(field);
            part.domain = Some(Aabb::new(DVec3::splat(-1.8), DVec3::splat(1.9)));
            let options = MeshOptions { size: Some(SizeRequest::Length(SIZE)), ..MeshOptions::default() };
            let made = mesh_part(&part, &options, &Run::new()).unwrap();
            let [attempt] = &made.report.attempts[..] else { panic!("{name} {way}: {:?}", made.report.attempts) };
            assert!(attempt.rung == Tried::Operators && made.report.shortfalls.is_empty(), "{name} {way}: {attempt:?}");
            // The closure knows no edges: the mesh is measured against the solid that does.
            let known = solid.clone().placed(Placement { rotation, scale: 1.0, shift: DVec3::ZERO });
            let c = against(&made.mesh, &Part::from_solid(known), &Run::new()).unwrap();
            let (f, q) = (c.features.unwrap(), &c.quality);
            assert!(f.recall >= 0.99 && f.precision >= 0.97, "{name} {way}: {f:?}");
            // Where both bores open the same edge of the cube, at its end, one corner is told from the crease in one of the two.
            let missing = usize::from((name, way) == ("edges", "aligned"));
            assert!(f.corners_true == corners && f.corners_found + missing >= corners, "{name} {way}: {f:?}");
            assert!(q.min_angle >= 25.0 && q.p05_angle >= 39.0, "{name} {way}: {q:?}");
            assert!(c.certificate.is_sound() && c.deviation.unwrap().max < 0.1 * SIZE, "{name} {way}");
        }
    }
}
