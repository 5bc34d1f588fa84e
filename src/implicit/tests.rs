//! What the implicit gate must be right about, against closed forms.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq, relative_eq};
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use rustc_hash::FxHashMap;

use super::expr::{Binary, Unary};
use super::leaf::Leaf;
use super::lower::lower;
use super::tape::{Pruned, Scratch};
use super::*;
use crate::geometry::SurfaceOracle;
use crate::mesh::TriMesh;
use crate::spatial::Aabb;
use crate::{Error, Place, Result, Run};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn cube(half: f64) -> Solid {
    Solid::cuboid(DVec3::splat(-half), DVec3::splat(half))
}

fn cube_with_holes() -> Solid {
    cube(1.0) - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None)
}

fn generic_rotation() -> Placement {
    let r = DMat3::from_axis_angle(v(1.0, 2.0, 3.0).normalize(), 0.7);
    Placement { rotation: r, scale: 1.0, shift: DVec3::ZERO }
}

fn mesh(solid: &Solid, size: f64) -> TriMesh {
    try_mesh(solid, size).unwrap()
}

fn try_mesh(solid: &Solid, size: f64) -> Result<TriMesh> {
    let model = Implicit::new(solid, RSystem::R0, None)?;
    Ok(extract(&model, &ExtractOptions::new(size), &Run::new())?.mesh)
}

/// Every directed edge once, its reverse once; returns the Euler characteristic.
fn assert_closed(m: &TriMesh) -> i64 {
    let mut count: FxHashMap<(u32, u32), i32> = FxHashMap::default();
    for t in &m.triangles {
        for i in 0..3 {
            *count.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
    }
    for ((a, b), n) in &count {
        assert_eq!((*n, count.get(&(*b, *a))), (1, Some(&1)), "edge {a} {b}");
    }
    m.nodes.len() as i64 - count.len() as i64 / 2 + m.triangles.len() as i64
}

fn some_solids() -> Vec<(&'static str, Solid)> {
    let r = generic_rotation();
    let e = |f: fn(Expr, Expr, Expr) -> Expr| Solid::formula(f(Expr::x(), Expr::y(), Expr::z()));
    vec![
        ("box", cube(0.8)),
        ("sphere", Solid::sphere(0.9, v(0.1, 0.2, 0.0))),
        ("ellipsoid", Primitive::Ellipsoid { radii: v(0.9, 0.5, 0.3), at: DVec3::ZERO }.into()),
        ("cylinder", Solid::cylinder(0.5, v(1.0, 1.0, 0.2), v(0.1, 0.0, 0.0), Some(1.1))),
        ("cone", Primitive::Cone { r0: 0.8, r1: 0.2, height: 1.2, axis: DVec3::Z, at: DVec3::ZERO }.into()),
        ("apex", Primitive::Cone { r0: 0.0, r1: 0.7, height: 1.2, axis: DVec3::Y, at: DVec3::ZERO }.into()),
        ("torus", Primitive::Torus { major: 0.7, minor: 0.25, axis: v(0.0, 1.0, 1.0), at: DVec3::ZERO }.into()),
        (
            "gyroid",
            Solid::from(Primitive::Tpms { kind: Tpms::Gyroid, period: 1.0, thickness: 0.2, at: DVec3::ZERO })
                & cube(0.7),
        ),
        (
            "schwarz",
            Solid::from(Primitive::Tpms { kind: Tpms::SchwarzP, period: 1.0, thickness: 0.2, at: DVec3::ZERO })
                & cube(0.7),
        ),
        (
            "diamond",
            Solid::from(Primitive::Tpms { kind: Tpms::Diamond, period: 1.0, thickness: 0.2, at: DVec3::ZERO })
                & cube(0.7),
        ),
        (
            "extrude",
            Primitive::Extrude {
                polygon: vec![[-0.8, -0.8], [0.8, -0.8], [0.8, -0.2], [0.1, -0.2], [0.1, 0.8], [-0.8, 0.8]],
                height: 1.0,
                at: DVec3::ZERO,
            }
            .into(),
        ),
        (
            "revolve",
            Primitive::Revolve { polygon: vec![[0.0, -0.8], [0.6, -0.8], [0.3, 0.0], [0.7, 0.6], [0.0, 0.6]] }.into(),
        ),
        ("blend", cube(0.4).blend(Solid::sphere(0.4, v(0.0, 0.0, 0.5)), 0.15)),
        ("formula", e(|x, y, z| Expr::constant(0.8) - (x.clone() * x + y.clone() * y * 2.0 + z.clone() * z))),
        ("holes", cube_with_holes()),
        ("rotated", cube_with_holes().placed(Placement { scale: 0.9, shift: v(0.1, -0.2, 0.05), ..r })),
    ]
}

#[test]
fn every_primitive_gives_a_closed_mesh_with_outward_triangles() {
    for (name, s) in some_solids() {
        let m = mesh(&s, 0.045);
        assert_closed(&m);
        let model = Implicit::new(&s, RSystem::R0, None).unwrap();
        assert!(m.volume() > 0.0, "{name}");
        // triangles that cut a sharp edge off may lie at any angle to the surface; all others face outward
        let inward = (0..m.triangles.len())
            .filter(|t| {
                let (c, n) = (m.centroid(*t), m.normal(*t));
                n != DVec3::ZERO && model.inside(c + n * 0.03) && !model.inside(c - n * 0.03)
            })
            .count();
        assert!(inward * 500 <= m.triangles.len(), "{name}: {inward} of {} face inward", m.triangles.len());
    }
}

#[test]
fn volumes_and_topology_match_closed_forms() {
    let holes = 8.0 - 2.0 * 0.16 * PI * 2.0 + 16.0 / 3.0 * 0.064;
    let cases: Vec<(&str, f64, i64)> = vec![
        ("box", 1.6f64.powi(3), 2),
        ("sphere", 4.0 / 3.0 * PI * 0.729, 2),
        ("ellipsoid", 4.0 / 3.0 * PI * 0.9 * 0.5 * 0.3, 2),
        ("cylinder", PI * 0.25 * 1.1, 2),
        ("cone", PI * 1.2 / 3.0 * (0.64 + 0.16 + 0.04), 2),
        ("apex", PI * 1.2 / 3.0 * 0.49, 2),
        ("torus", 2.0 * PI * PI * 0.7 * 0.0625, 0),
        ("extrude", 1.6 * 0.6 + 0.9 * 1.0, 2),
        ("revolve", PI * (0.8 / 3.0 * (0.36 + 0.18 + 0.09) + 0.6 / 3.0 * (0.09 + 0.21 + 0.49)), 2),
        ("formula", 4.0 / 3.0 * PI * 0.8f64.powf(1.5) / 2f64.sqrt(), 2),
        ("holes", holes, -4),
        ("rotated", holes * 0.729, -4),
    ];
    let solids = some_solids();
    for (name, volume, euler) in cases {
        let s = &solids.iter().find(|s| s.0 == name).unwrap().1;
        let m = mesh(s, 0.03);
        assert_eq!(assert_closed(&m), euler, "{name}");
        assert!(
            relative_eq!(m.volume(), volume, epsilon = 0.0, max_relative = 4e-3),
            "{name}: {} for {volume}",
            m.volume()
        );
    }
}

#[test]
fn nodes_lie_on_the_surface_to_the_root_tolerance() {
    for (name, s) in some_solids() {
        let model = Implicit::new(&s, RSystem::R0, None).unwrap();
        let e = extract(&model, &ExtractOptions::new(0.1), &Run::new()).unwrap();
        for p in &e.mesh.nodes {
            let a = e.bricks.tape_at(&model.tape, *p).active(&model.leaves, *p);
            let d = a.gradient(&model.leaves, *p);
            assert!(abs_diff_eq!(d.v, 0.0, epsilon = 1e-10 * d.g.length().max(1.0)), "{name} at {p}: {}", d.v);
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads_and_any_r_system() {
    let s = cube_with_holes().placed(generic_rotation());
    let with = |threads: usize, system| {
        let run = Run::new().with_threads(threads).unwrap();
        extract(&Implicit::new(&s, system, None).unwrap(), &ExtractOptions::new(0.07), &run).unwrap().mesh
    };
    let one = with(1, RSystem::R0);
    for threads in [2, 3, 16] {
        assert!(one == with(threads, RSystem::R0), "{threads} threads");
    }
    // the R-system only has a say in ambiguous cells
    for system in [RSystem::MinMax, RSystem::RAlpha(0.5), RSystem::RAlpha(-0.9), RSystem::R0m(2)] {
        let m = with(2, system);
        assert_eq!(assert_closed(&m), -4, "{system:?}");
        assert_abs_diff_eq!(m.volume(), one.volume(), epsilon = 1e-3);
    }
}

#[test]
fn labels_name_the_face_below_the_triangle() {
    let s = cube(1.0).name("body") - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None).name("bore");
    let m = mesh(&s, 0.08);
    assert_eq!(m.faces, ["body.xmin", "body.xmax", "body.ymin", "body.ymax", "body.zmin", "body.zmax", "bore"]);
    for t in 0..m.triangles.len() {
        let c = m.centroid(t);
        let radius = c.y.hypot(c.z);
        match m.faces[m.labels[t] as usize].as_str() {
            "bore" => assert_abs_diff_eq!(radius, 0.4, epsilon = 0.05),
            name => {
                let axis = "xyz".find(name.as_bytes()[5] as char).unwrap();
                let side = if name.ends_with("max") { 1.0 } else { -1.0 };
                assert!(abs_diff_eq!(c[axis], side, epsilon = 0.05), "{name} at {c}");
            }
        }
    }
}

#[test]
fn coincident_faces_and_hidden_sheets_vanish() {
    // two boxes that share a plane are one box
    let a = Solid::cuboid(v(-1.0, -0.5, -0.5), v(0.0, 0.5, 0.5));
    let b = Solid::cuboid(v(0.0, -0.5, -0.5), v(1.0, 0.5, 0.5));
    let m = mesh(&(a.clone() | b.clone()), 0.083);
    assert_eq!(assert_closed(&m), 2);
    assert_abs_diff_eq!(m.volume(), 2.0, epsilon = 0.03);
    // the same, turned and moved through a chain of placements
    let r = generic_rotation();
    let m = mesh(&(a.clone().placed(r) | b.clone().placed(r)), 0.083);
    assert_eq!(assert_closed(&m), 2);
    // a hole exactly as deep as the plate goes through
    let plate = Solid::cuboid(v(-1.0, -1.0, 0.0), v(1.0, 1.0, 0.5));
    let hole = Solid::cylinder(0.4, DVec3::Z, v(0.0, 0.0, 0.25), Some(0.5));
    let m = mesh(&(plate - hole), 0.083);
    assert_eq!(assert_closed(&m), 0);
    // (A and B) or (A and not B) is A
    let (s, p) = (Solid::sphere(0.8, DVec3::ZERO), Solid::half_space(v(0.3, 0.4, 1.0), v(0.1, 0.0, 0.1)));
    let m = mesh(&((s.clone() & p.clone()) | (s.clone() & !p)), 0.1);
    let whole = mesh(&s, 0.1);
    assert!(m.triangles == whole.triangles && m.nodes.iter().zip(&whole.nodes).all(|(a, b)| a.distance(*b) < 1e-11));
    // a | a is a; a - a is nothing
    assert!(mesh(&(s.clone() | s.clone()), 0.1).nodes == whole.nodes);
    let none = Implicit::new(&(s.clone() - s), RSystem::R0, None);
    match none {
        Err(e) => assert!(e.to_string().contains("empty"), "{e}"),
        Ok(m) => assert!(extract(&m, &ExtractOptions::new(0.1), &Run::new()).unwrap().mesh.triangles.is_empty()),
    }
}

#[test]
fn bounds_are_found_or_asked_for() {
    let e = Expr::constant(1.0) - (Expr::x() * Expr::x() + Expr::y() * Expr::y() + Expr::z() * Expr::z());
    let b = Implicit::new(&Solid::formula(e), RSystem::R0, None).unwrap().bounds();
    assert!(b.contains(DVec3::X) && b.contains(-DVec3::X) && b.diagonal() < 2.3 * 3f64.sqrt(), "{b:?}");
    // Powers that are not whole need a base that is shown not to be negative.
    let power = |e: Expr, k: f64| Expr::binary(Binary::Pow, Expr::unary(Unary::Abs, e) / k, Expr::constant(2.5));
    let superell = Expr::constant(1.0) - power(Expr::x(), 3.0) - power(Expr::y(), 2.0) - power(Expr::z(), 1.0);
    let b = Implicit::new(&Solid::formula(superell), RSystem::R0, None).unwrap().bounds();
    assert!(b.contains(DVec3::X * 3.0) && b.contains(DVec3::Z) && b.diagonal() < 1.2 * 56f64.sqrt(), "{b:?}");
    // A smooth minimum: far away the logarithm is that of zero.
    let ball = |at: f64| (Expr::x() - at) * (Expr::x() - at) + Expr::y() * Expr::y() + Expr::z() * Expr::z() - 1.0;
    let near = |at: f64| Expr::unary(Unary::Exp, ball(at) * -8.0);
    let smooth = Expr::unary(Unary::Log, near(0.5) + near(-0.5)) / 8.0;
    let b = Implicit::new(&Solid::formula(smooth), RSystem::R0, None).unwrap().bounds();
    assert!(b.contains(DVec3::X * 1.5) && b.contains(DVec3::Y) && b.diagonal() < 8.0, "{b:?}");
    // Beside a solid whose formula, in its own frame, hides that it ends.
    let turned = Solid::cuboid(v(-1.0, -2.0, -1.0), DVec3::ONE).placed(generic_rotation());
    let egg: Solid = Primitive::Ellipsoid { radii: v(0.4, 0.6, 0.7), at: DVec3::ZERO }.into();
    let fourth = |e: Expr| (e.clone() * e.clone()) * (e.clone() * e);
    let quartic = Expr::constant(1.0) - fourth(Expr::x()) - fourth(Expr::y()) - fourth(Expr::z());
    for other in [turned, egg] {
        let b = Implicit::new(&(other | Solid::formula(quartic.clone())), RSystem::R0, None).unwrap().bounds();
        assert!(b.contains(DVec3::Z) && b.is_finite(), "{b:?}");
    }
    let s = Solid::cylinder(1.0, DVec3::Z, DVec3::ZERO, None);
    let err = Implicit::new(&s, RSystem::R0, None).unwrap_err().to_string();
    assert!(err.contains("infinite"), "{err}");
    let d = Aabb::new(v(-2.0, -2.0, 0.0), v(2.0, 2.0, 1.0));
    let m = Implicit::new(&s, RSystem::R0, Some(d)).unwrap();
    let m = extract(&m, &ExtractOptions::new(0.1), &Run::new()).unwrap().mesh;
    assert_eq!(assert_closed(&m), 2);
    let used: Vec<&str> = m.labels.iter().map(|l| m.faces[*l as usize].as_str()).collect();
    assert!(used.contains(&"domain.zmin") && used.contains(&"domain.zmax") && !used.contains(&"domain.xmin"));
}

#[test]
fn bad_numbers_are_named_with_their_place() {
    let root = Expr::unary(Unary::Sqrt, Expr::x()) * Expr::x() - 0.5;
    let err = try_mesh(&(Solid::formula(root) & cube(1.0)), 0.1).unwrap_err();
    assert!(matches!(&err, Error::Input { place: Place::Point(p), .. } if p.x < 0.0), "{err}");
    let pole = Expr::constant(1.0) / (Expr::x() - 0.123);
    let err = try_mesh(&(Solid::formula(pole) & cube(1.0)), 0.1).unwrap_err();
    assert!(err.to_string().contains("pole"), "{err}");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(try_mesh(&cube(1.0), bad), Err(Error::Usage(_))), "{bad}");
    }
    let err = try_mesh(&cube(1.0), 1e-5).unwrap_err();
    assert!(err.to_string().contains("GiB"), "{err}");
    assert!(Implicit::new(&Solid::sphere(-1.0, DVec3::ZERO), RSystem::R0, None).is_err());
    assert!(Implicit::new(&cube(1.0), RSystem::RAlpha(-1.0), None).is_err());
}

#[test]
fn a_cancelled_run_stops() {
    let token = crate::run::CancelToken::new();
    token.cancel();
    let model = Implicit::new(&cube(1.0), RSystem::R0, None).unwrap();
    let e = extract(&model, &ExtractOptions::new(0.01), &Run::new().with_cancel(token));
    assert!(matches!(e, Err(Error::Cancelled)));
}

#[test]
fn features_of_the_cube_with_holes() {
    let model = Implicit::new(&cube_with_holes(), RSystem::R0, None).unwrap();
    let f = features(&model, 0.04, &Run::new()).unwrap();
    // 12 edges, 4 circles, 2 ellipses with half axes 0.4 and 0.4 sqrt 2
    let ellipses = 2.0 * 4.0 * 0.4 * 2f64.sqrt() * 1.350_643_881_047_675_5;
    let length = 24.0 + 4.0 * 2.0 * PI * 0.4 + ellipses;
    assert_relative_eq!(f.length(-1.0), length, epsilon = 0.0, max_relative = 3e-3);
    assert_eq!(f.corners.len(), 8);
    for c in &f.corners {
        assert!(c.abs().distance(DVec3::ONE) < 1e-12, "{c}");
    }
}

#[test]
fn the_oracle_finds_faces_edges_and_corners() {
    let model = Implicit::new(&cube_with_holes(), RSystem::R0, None).unwrap();
    let o = ImplicitOracle::with_cells(&model, 0.05, &Run::new()).unwrap();
    let near = |p: DVec3, q: DVec3| {
        let f = o.project(p, 1.0).unwrap();
        assert!(f.point.distance(q) < 1e-9, "{p}: {f:?}, not {q}");
    };
    near(v(1.05, 0.7, 0.7), v(1.0, 0.7, 0.7));
    near(v(1.05, 1.02, 0.7), v(1.0, 1.0, 0.7));
    near(v(1.05, 1.02, 1.03), DVec3::ONE);
    near(v(0.8, 0.0, 0.35), v(0.8, 0.0, 0.4));
    near(v(1.03, 0.0, 0.37), v(1.0, 0.0, 0.4));
    let f = o.project(v(0.8, 0.0, 0.41), 0.1).unwrap();
    assert!((f.normal + DVec3::Z).length() < 1e-12);
    let k = o.curvatures(&f).unwrap();
    assert_abs_diff_eq!(k[0], -2.5, epsilon = 1e-9);
    assert_abs_diff_eq!(k[1], 0.0, epsilon = 1e-9);
    let f = o.project_along(v(0.7, 0.7, 0.95), DVec3::Z, 0.2).unwrap();
    assert_abs_diff_eq!(f.point.z, 1.0, epsilon = 1e-12);
    assert_eq!(f.normal, DVec3::Z);
}

fn any_leaf() -> impl Strategy<Value = usize> {
    0usize..16
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn ranges_hold_every_value_and_gradients_agree_with_differences(
        which in any_leaf(), c in prop::array::uniform3(-1.5f64..1.5), half in 0.001f64..0.8, t in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let low = lower(&some_solids()[which].1).unwrap();
        let center = DVec3::from_array(c);
        let cell = Aabb::new(center - half, center + half);
        let p = center + DVec3::from_array(t) * half;
        for leaf in &low.leaves {
            let r = leaf.range(&cell);
            let f = leaf.value(p);
            // Where a fillet has ended its bounds say less than it is, so that the tree does without it.
            let ended = matches!(leaf, Leaf::Fillet(x) if !x.is_between(p));
            prop_assert!(r.contains(f) || (ended && r.lo <= f), "{leaf:?}: {r:?} lacks {f}");
            let d = leaf.gradient(p);
            prop_assert!((d.v - f).abs() <= 1e-12 * (1.0 + f.abs()));
            let e = 1e-6;
            let differences = DVec3::AXES.map(|a| (leaf.value(p + a * e) - leaf.value(p - a * e)) / (2.0 * e));
            let g = DVec3::from_array(differences);
            // creases of blends and ends of fillets excepted
            if !matches!(leaf, Leaf::Blend(_) | Leaf::Fillet(_)) {
                prop_assert!(g.distance(d.g) <= 1e-4 * (1.0 + g.length()), "{leaf:?} at {p}: {g} {}", d.g);
            }
        }
    }

    #[test]
    fn pruned_tapes_keep_the_sign(
        which in any_leaf(), c in prop::array::uniform3(-1.2f64..1.2), half in 0.01f64..0.6, t in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let low = lower(&some_solids()[which].1).unwrap();
        let center = DVec3::from_array(c);
        let cell = Aabb::new(center - half, center + half);
        let p = center + DVec3::from_array(t) * half;
        let f = low.tape.value(&low.leaves, p);
        match low.tape.prune(&low.leaves, &cell, &mut Scratch::default()) {
            Pruned::Outside => prop_assert!(f < 0.0),
            Pruned::Inside => prop_assert!(f > 0.0),
            Pruned::Same => {}
            Pruned::Smaller(t) => prop_assert_eq!(t.value(&low.leaves, p) > 0.0, f > 0.0),
        }
    }

    #[test]
    fn a_blend_leaf_by_leaf_has_the_sign_of_the_one_function(
        c in prop::array::uniform3(-1.4f64..1.4), radius in 0.02f64..0.5, turn in any::<bool>(), negate in any::<bool>(),
    ) {
        let plate = cube(0.9) & Solid::half_space(DVec3::Z, v(0.0, 0.0, -0.1));
        let tools = Solid::cylinder(0.3, DVec3::Z, v(0.3, 0.2, 0.0), Some(1.0)) | (cube(0.4) - Solid::sphere(0.45, v(-0.3, 0.0, 0.4)));
        let place = |s: Solid| if turn { s.placed(generic_rotation()) } else { s };
        let p = DVec3::from_array(c);
        let value = |s: &Solid| {
            let low = lower(s).unwrap();
            low.tape.value(&low.leaves, p)
        };
        let blend = plate.clone().blend(tools.clone(), radius);
        let (a, b) = (value(&place(plate)), value(&place(tools)));
        let f = (radius + a).max(0.0).hypot((radius + b).max(0.0)) + a.max(b).min(-radius);
        prop_assume!(f.abs() > 1e-9);
        let made = if negate { -value(&place(!blend)) } else { value(&place(blend)) };
        prop_assert_eq!(made > 0.0, f > 0.0, "{} {}", made, f);
    }

    #[test]
    fn r_functions_have_the_sign_of_min_and_max(a in -1e3f64..1e3, b in -1e3f64..1e3, ea in -11i32..11, eb in -11i32..11) {
        let (a, b) = (a * 10f64.powi(ea), b * 10f64.powi(eb));
        prop_assume!(a != 0.0 && b != 0.0);
        for s in [RSystem::MinMax, RSystem::R0, RSystem::RAlpha(0.7), RSystem::RAlpha(-0.9), RSystem::RAlpha(1.0), RSystem::R0m(1), RSystem::R0m(2)] {
            prop_assert_eq!(s.and(a, b) > 0.0, a.min(b) > 0.0, "{:?} and {} {}", s, a, b);
            prop_assert_eq!(s.or(a, b) > 0.0, a.max(b) > 0.0, "{:?} or {} {}", s, a, b);
        }
        prop_assert!((RSystem::RAlpha(1.0).and(a, b) - a.min(b)).abs() <= 1e-12 * a.abs().max(b.abs()));
    }

    #[test]
    fn r_function_partials_agree_with_differences(a in -2.0f64..2.0, b in -2.0f64..2.0) {
        prop_assume!(a.hypot(b) > 0.1 && (a - b).abs() > 0.01);
        let e = 1e-6;
        for s in [RSystem::MinMax, RSystem::R0, RSystem::RAlpha(0.7), RSystem::RAlpha(-0.5), RSystem::R0m(1), RSystem::R0m(2)] {
            for or in [false, true] {
                let f = |a, b| if or { s.or(a, b) } else { s.and(a, b) };
                let (pa, pb) = if or { s.or_partials(a, b) } else { s.and_partials(a, b) };
                let (da, db) = ((f(a + e, b) - f(a - e, b)) / (2.0 * e), (f(a, b + e) - f(a, b - e)) / (2.0 * e));
                prop_assert!((pa - da).abs() < 1e-5 && (pb - db).abs() < 1e-5, "{:?} {} {}: {} {} {} {}", s, a, b, pa, da, pb, db);
            }
        }
    }
}

#[test]
fn thin_walls_are_named_and_sharp_edges_are_not() {
    let thin = |s: &Solid, h: f64| {
        let model = Implicit::new(s, RSystem::R0, None).unwrap();
        let e = extract(&model, &ExtractOptions::new(h), &Run::new()).unwrap();
        thin_places(&model, &thin_walls(&model, &e, h, &Run::new()).unwrap(), h)
    };
    // a plate between grid planes is missed altogether, or met in part
    for z in [0.0, 0.013, 0.027, 0.04] {
        let plate = Solid::cuboid(v(-1.0, -1.0, z), v(1.0, 1.0, z + 0.02)).name("plate");
        let found = thin(&plate, 0.08);
        assert!(found.iter().any(|t| t.face.starts_with("plate.z") && t.thickness < 0.03), "{z}: {found:?}");
    }
    let cone: Solid = Primitive::Cone { r0: 0.8, r1: 0.0, height: 1.2, axis: DVec3::Z, at: DVec3::ZERO }.into();
    let wedge = Solid::cuboid(DVec3::ZERO, DVec3::ONE) & Solid::half_space(v(1.0, 0.0, 2.0), DVec3::X);
    for s in [cube(1.0), cone, wedge, cube_with_holes(), Solid::sphere(0.7, DVec3::ZERO)] {
        assert_eq!(thin(&s, 0.08), []);
    }
}

/// A ball of which nothing is known but its values, and how often these were asked for.
pub(super) struct Counted(pub(super) Arc<AtomicUsize>);

impl Field for Counted {
    fn value(&self, p: DVec3) -> f64 {
        self.0.fetch_add(1, Ordering::Relaxed);
        1.0 - p.length()
    }
}

#[test]
fn functions_without_bounds_are_looked_for_once_in_a_cell() {
    let (asked, h, run) = (Arc::new(AtomicUsize::new(0)), 0.1, Run::new());
    let domain = Aabb::new(DVec3::splat(-1.3), DVec3::splat(1.35));
    let model = Implicit::new(&Solid::field(Counted(asked.clone())), RSystem::R0, Some(domain)).unwrap();
    let e = extract(&model, &ExtractOptions::new(h), &run).unwrap();
    asked.store(0, Ordering::Relaxed);
    let found = lost::surface_points(&model, &e, None, &run).unwrap();
    assert!(found.iter().all(|x| (x.at.length() - 1.0).abs() < 1e-9));
    // Newton's method takes gradients by differences of seven values: 155 values a cell, and 485 if parts of cells are looked at.
    let cells = (2.65f64 / h).powi(3);
    let each = asked.load(Ordering::Relaxed) as f64 / cells;
    assert!(each < 250.0, "{each} in a cell");
}

#[test]
fn deep_chains_are_lowered_and_exploding_trees_are_refused() {
    let mut chain = Solid::sphere(0.5, DVec3::ZERO);
    for i in 0..50_000 {
        chain = chain | Solid::sphere(0.1, v(f64::from(i % 10) * 0.01, 0.0, 0.0));
    }
    let model = Implicit::new(&chain, RSystem::R0, None).unwrap();
    assert_eq!(model.leaf_count(), 11);
    let mut doubled = Solid::sphere(0.5, DVec3::ZERO);
    for _ in 0..40 {
        doubled = doubled.clone() & doubled;
    }
    let err = Implicit::new(&doubled, RSystem::R0, None).unwrap_err().to_string();
    assert!(err.contains("4000000"), "{err}");
}

#[test]
fn bounds_hold_the_solid_where_an_outer_cell_proves_empty() {
    // The outermost cells of a coarse look are empty on a closer one, and the next ones count again.
    let cone =
        Primitive::Cone { r0: 0.2837, r1: 0.1, height: 0.7809, axis: DVec3::Y, at: DVec3::new(0.2265, 0.5, -0.4698) };
    let axis = DVec3::new(0.5966, -0.6568, -0.4612);
    let solid =
        Solid::new(SolidNode::Primitive(cone)) & Solid::cylinder(0.1, axis, DVec3::new(0.2, 0.3, -0.5), Some(0.9));
    let model = Implicit::new(&solid, RSystem::default(), None).unwrap();
    let b = model.bounds();
    for i in 0..200_000u32 {
        let share = |base: u32| {
            let (mut x, mut f, mut n) = (0.0, 1.0, i);
            while n > 0 {
                f /= f64::from(base);
                x += f * f64::from(n % base);
                n /= base;
            }
            x
        };
        let p = DVec3::new(share(2), share(3), share(5)) * 2.0 - 1.0;
        assert!(!model.inside(p) || (b.lo.cmple(p).all() && p.cmple(b.hi).all()), "{p} {b:?}");
    }
}

#[test]
fn close_points_have_the_feet_that_all_leaves_give() {
    let r = generic_rotation();
    for solid in [
        cube_with_holes(),
        cube_with_holes().placed(r),
        Solid::blend(cube(1.0), Solid::sphere(0.9, v(0.9, 0.3, 0.1)), 0.2),
    ] {
        let model = Implicit::new(&solid, RSystem::R0, None).unwrap();
        let mesh = mesh(&solid, 0.1);
        let oracle = ImplicitOracle::with_cells(&model, 0.1, &Run::new()).unwrap();
        let close = CloseOracle::new(&oracle, &mesh, &Run::new()).unwrap();
        let (mut answered, mut lost) = (0, 0);
        for t in 0..mesh.triangles.len() {
            // On both sides of the surface, within the reach of the tapes and beyond it.
            for away in [0.0, 1e-3, -0.01, 0.07, -0.07] {
                let p = mesh.centroid(t) + away * mesh.normal(t);
                let [a, b] = [oracle.project(p, 0.5), close.project(p, 0.5)].map(|f| f.map(|f| f.point.distance(p)));
                let Some(b) = b else {
                    assert_eq!(a, None, "{p}");
                    lost += 1;
                    continue;
                };
                // Where all leaves give none the nearest may still be found among few.
                let Some(a) = a else { continue };
                answered += 1;
                assert!(b <= a + 1e-9 && b >= a - 1e-3 * a.max(1e-6), "{p}: {a} and {b}");
            }
        }
        assert!(answered > 4 * mesh.triangles.len() && lost * 100 < answered, "{answered} {lost}");
    }
}

#[test]
fn sheets_and_slits_of_rounding_are_no_surface() {
    let at = |x: f64| lost::SurfacePoint { at: v(x, 0.1, 0.2), face: 0 };
    let slab = |lo: f64, hi: f64| Solid::cuboid(v(lo, -1.0, -1.0), v(hi, 1.0, 1.0));
    // A slit in a block, and a sheet beside it; the diagonal is about 4.
    for (thickness, is_none) in [(1e-9, true), (1e-4, false)] {
        let solid = (slab(-1.0, 1.0) - slab(0.0, thickness)) | slab(1.5, 1.5 + thickness);
        let model = Implicit::new(&solid, RSystem::R0, None).unwrap();
        for (x, expected) in [(0.0, is_none), (1.5, is_none), (1.0, false), (-1.0, false)] {
            assert_eq!(at(x).is_in_passing(&model), expected, "{x} of {thickness}");
        }
    }
}
