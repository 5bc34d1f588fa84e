//! What is trimmed and sewn must be, against closed forms and marching cubes.

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::implicit::leaf::Leaf;
use crate::implicit::{ExtractOptions, Placement, Primitive, RSystem, Solid, extract};

fn trim(solid: &Solid, cell: f64) -> (Implicit, Extracted, Option<Trimmed>) {
    let run = Run::new();
    let model = Implicit::new(solid, RSystem::default(), None).unwrap();
    let extracted = extract(&model, &ExtractOptions::new(cell), &run).unwrap();
    let made = trimmed(&model, &extracted, &run).unwrap();
    (model, extracted, made)
}

/// Closed, a manifold, every node on its leaves, every triangle between nodes of its leaf.
fn check(model: &Implicit, made: &Trimmed) {
    let defects = made.mesh.defects();
    assert!(defects.is_closed() && defects.is_manifold() && defects.is_oriented());
    for (p, on) in made.mesh.nodes.iter().zip(&made.leaves) {
        for leaf in on {
            let d = model.leaves[*leaf as usize].smooth(*p);
            assert!(d.v.abs() <= 1e-12 * d.g.length(), "{p} is {} from leaf {leaf}", d.v / d.g.length());
        }
    }
    for (t, leaf) in made.mesh.triangles.iter().zip(&made.mesh.labels) {
        assert!(t.iter().all(|v| made.leaves[*v as usize].contains(leaf)));
    }
}

#[test]
fn a_lens_is_whole_however_thin() {
    for thickness in [0.2, 0.01, 1e-3, 1e-6] {
        let ball = |z: f64| Solid::sphere(1.0, DVec3::new(0.01, 0.02, z));
        let lens = ball(1.0 - 0.5 * thickness) & ball(-1.0 + 0.5 * thickness);
        let (model, _, made) = trim(&lens, 0.15 * thickness.sqrt());
        let made = made.unwrap();
        check(&model, &made);
        let defects = made.mesh.defects();
        assert_eq!((made.mesh.topology(&defects).components, made.mesh.topology(&defects).euler), (1, 2));
        // Two caps of half the thickness.
        let h = 0.5 * thickness;
        let volume = 2.0 * std::f64::consts::PI * h * h * (1.0 - h / 3.0);
        assert!((made.mesh.volume() / volume - 1.0).abs() < 0.05, "{thickness}: {} {volume}", made.mesh.volume());
        assert!(made.leaves.iter().any(|on| on.len() == 2));
    }
}

#[test]
fn a_foil_on_a_block_has_its_rim() {
    for thickness in [0.1, 1e-3, 1e-6] {
        let box_of = |lo: [f64; 3], hi: [f64; 3]| Solid::cuboid(lo.into(), hi.into());
        let foil = box_of([-1.0, 0.0, 0.0], [1.0, thickness, 1.0]);
        let (model, _, made) = trim(&(box_of([-1.0, -0.5, -0.5], [1.0, 0.5, 0.0]) | foil), 0.13);
        let made = made.unwrap();
        check(&model, &made);
        let volume = 1.0 + 2.0 * thickness;
        assert!((made.mesh.volume() - volume).abs() < 1e-13, "{} {volume}", made.mesh.volume());
        assert_eq!(made.leaves.iter().filter(|on| on.len() > 2).count(), 16);
    }
}

/// A ball bulges through a face by a cap of a few cells: the chord of two of its border nodes was a chord of the hole too.
#[test]
fn a_cap_of_a_few_triangles_keeps_its_chords_apart() {
    let top = Solid::half_space(DVec3::Y, DVec3::Y * (0.613_778_889_089_329_4 * 0.3));
    let cube = Solid::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5)) & top;
    let ball = DVec3::new(-0.289_800_279_887_649, -0.131_874_097_670_554_22, 0.260_468_949_619_380_2);
    let cap = cube | Solid::sphere(0.319_890_784_153_308_07, ball);
    let mut found = 0;
    for cell in [0.05, 0.03, 0.025, 0.0125] {
        let (model, _, made) = trim(&cap, cell);
        let Some(made) = made else { continue };
        found += 1;
        check(&model, &made);
        assert_eq!(made.mesh.topology(&made.mesh.defects()).euler, 2);
    }
    assert!(found > 2);
}

/// A plane cuts a torus near the saddle at its hole: two loops, or one with a waist, however narrow beside the cells.
#[test]
fn a_cut_beside_a_saddle_has_the_loops_it_has() {
    for gap in [0.02, 0.004] {
        for (side, euler) in [(-1.0, 2), (1.0, 0)] {
            let at = DVec3::new(0.6 + side * gap, 0.0, 0.0);
            for turn in [0.0, 0.5] {
                let normal = DVec3::X;
                let middle = DVec3::new(0.011, 0.017, 0.023);
                let ring = Solid::from(Primitive::Torus { major: 1.0, minor: 0.4, axis: DVec3::Z, at: middle });
                let cut = Solid::half_space(normal, at + DVec3::X * 0.011);
                let rotation = glam::DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), turn);
                let placement = Placement { rotation, scale: 1.0, shift: DVec3::ZERO };
                let (model, _, made) = trim(&(ring & cut).placed(placement), 0.13);
                let made = made.unwrap_or_else(|| panic!("no mesh: {gap} {side} {turn}"));
                check(&model, &made);
                assert_eq!(made.mesh.topology(&made.mesh.defects()).euler, euler, "{gap} {side} {turn}");
            }
        }
    }
}

/// Pipes of nearly one radius: two loops that nearly touch twice, where the linear cuts of the two leaves may join them
/// differently.
#[test]
fn loops_that_nearly_touch_are_found_alike_by_both_leaves() {
    for (radius, turn) in [0.51, 0.504].into_iter().flat_map(|r| (0..12).map(move |k| (r, 0.13 * f64::from(k)))) {
        let pipe = |r, axis| Solid::cylinder(r, axis, DVec3::ZERO, Some(2.4));
        let rotation = glam::DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), turn);
        let placement = Placement { rotation, scale: 1.0, shift: DVec3::new(0.011, 0.017, 0.023) };
        let (model, _, made) = trim(&(pipe(0.5, DVec3::X) | pipe(radius, DVec3::Y)).placed(placement), 0.13);
        let made = made.unwrap_or_else(|| panic!("no mesh: {radius} {turn}"));
        check(&model, &made);
        let defects = made.mesh.defects();
        assert_eq!((made.mesh.topology(&defects).components, made.mesh.topology(&defects).euler), (1, 2));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn leaves_fit_together_to_what_marching_cubes_finds(
        n in prop::array::uniform3(-1.0..1.0f64), at in prop::array::uniform3(-0.4..0.4f64), r in 0.3..0.8f64, minus: bool,
    ) {
        let n = DVec3::from(n);
        prop_assume!(n.length() > 0.1);
        let cube = Solid::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5)) & Solid::half_space(n.normalize(), n * 0.3);
        let ball = Solid::sphere(r, at.into());
        let solid = if minus { cube - ball } else { cube | ball };
        let run = Run::new();
        // The half-space may leave nothing.
        let Ok(model) = Implicit::new(&solid, RSystem::default(), None) else { return Ok(()) };
        let made = [0.05, 0.025, 0.0125].into_iter().find_map(|cell| {
            let extracted = extract(&model, &ExtractOptions::new(cell), &run).unwrap();
            trimmed(&model, &extracted, &run).unwrap()
        });
        // Marching cubes cuts edges off by a share of its cells.
        let fine = extract(&model, &ExtractOptions::new(0.0125), &run).unwrap().mesh;
        prop_assume!(!fine.triangles.is_empty());
        prop_assert!(made.is_some());
        let made = made.unwrap();
        check(&model, &made);
        let (a, b) = (made.mesh.volume(), fine.volume());
        prop_assert!((a - b).abs() < 0.005 + 0.01 * b, "{a} {b}");
    }
}

#[test]
fn fillets_end_in_the_faces_they_touch() {
    let plate = Solid::cuboid(DVec3::new(-1.0, -1.0, -0.2), DVec3::new(1.0, 1.0, 0.2));
    let post = Solid::cuboid(DVec3::new(-0.31, -0.32, 0.0), DVec3::new(0.33, 0.34, 0.7));
    let (w, d, r) = (0.64, 0.66, 0.12);
    // In planes across the edges a fillet fills r * r * (1 - PI / 4); its ends run on into the mitre at the corners.
    let along = r * r * (1.0 - 0.25 * std::f64::consts::PI);
    let corners = 4.0 * 2.0 * r * r * r * (5.0 / 6.0 - 0.25 * std::f64::consts::PI);
    let volume = 1.6 + 0.5 * w * d + 2.0 * (w + d) * along + corners;
    for turn in [0.0, 0.4] {
        let rotation = glam::DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), turn);
        let placement = Placement { rotation, scale: 1.0, shift: DVec3::new(0.01, 0.02, 0.03) };
        let solid = plate.clone().blend(post.clone(), r).placed(placement);
        for cell in [0.15, 0.04] {
            let (model, _, made) = trim(&solid, cell);
            let made = made.unwrap();
            check(&model, &made);
            assert!((made.mesh.volume() - volume).abs() < 0.5 * cell * cell, "{} {volume}", made.mesh.volume());
            // Four mitres, each from an edge of the post to the plate.
            let fillets =
                |on: &Vec<u32>| on.iter().filter(|l| matches!(model.leaves[**l as usize], Leaf::Fillet(_))).count();
            let ends = made.leaves.iter().filter(|on| on.len() > 2 && fillets(on) == 2).count();
            assert_eq!(ends, 8);
        }
    }
}

/// A prism along the y axis with a ridge, turned about the z axis.
fn roof(degrees: f64) -> Solid {
    let polygon = vec![[-0.5, -0.3], [0.5, -0.3], [0.0, 0.3]];
    let prism: Solid = Primitive::Extrude { polygon, height: 1.6, at: DVec3::ZERO }.into();
    prism.placed(turn(DVec3::X, 90.0)).placed(turn(DVec3::Z, degrees))
}

fn turn(axis: DVec3, degrees: f64) -> Placement {
    Placement { rotation: glam::DMat3::from_axis_angle(axis, degrees.to_radians()), ..Placement::IDENTITY }
}

#[test]
fn ridges_of_one_height_cross_in_one_point() {
    // Four planes through one point, of each of which two sectors bound the solid. The cores share a pyramid.
    let volume = 2.0 * 0.5 * 0.6 * 1.6 - 0.6 / 3.0;
    for k in 1..=6 {
        let skew = turn(DVec3::new(1.0, 2.0, 0.5 * f64::from(k)).normalize(), 17.0 * f64::from(k) + 3.0);
        let (model, _, made) = trim(&(roof(0.0) | roof(90.0)).placed(skew), 0.12);
        let made = made.unwrap();
        check(&model, &made);
        assert!((made.mesh.volume() - volume).abs() < 1e-12, "{k}: {} {volume}", made.mesh.volume());
        assert_eq!(made.leaves.iter().filter(|on| on.len() == 4).count(), 1, "{k}");
    }
}

#[test]
fn any_number_of_pipes_cross_in_one_point() {
    // All of them touch above and below it, and take turns there.
    let (r, half) = (0.1, 0.335);
    for n in 2..=6 {
        let axes: Vec<DVec3> = (0..n)
            .map(|k| (std::f64::consts::PI * (f64::from(k) + 0.1) / f64::from(n)).sin_cos())
            .map(|(s, c)| DVec3::new(c, s, 0.0))
            .collect();
        let pipe = |a: &DVec3| Solid::cylinder(r, *a, DVec3::ZERO, Some(2.0 * half));
        let solid = axes.iter().map(pipe).reduce(|a, b| a | b).unwrap();
        let (model, _, made) = trim(&solid, 0.04);
        let made = made.unwrap();
        check(&model, &made);
        let defects = made.mesh.defects();
        assert_eq!((made.mesh.topology(&defects).components, made.mesh.topology(&defects).euler), (1, 2), "{n}");
        for z in [-r, r] {
            let top = made.mesh.nodes.iter().position(|p| p.distance(DVec3::Z * z) < 1e-9).unwrap();
            assert_eq!(made.leaves[top].len(), n as usize);
        }
        // By counting points of a grid.
        let steps = 120;
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps) - 0.5;
        let mut count = 0;
        for (i, j, k) in (0..steps * steps * steps).map(|i| (i % steps, i / steps % steps, i / (steps * steps))) {
            let p = DVec3::new(at(i), at(j), 0.25 * at(k));
            let within = |a: &DVec3| p.dot(*a).abs() < half && p.distance_squared(*a * p.dot(*a)) < r * r;
            count += u32::from(axes.iter().any(within));
        }
        let inner = f64::from(count) / f64::from(steps).powi(3) * 0.25;
        let cut = made.mesh.nodes.iter().all(|p| p.truncate().abs().max_element() <= 0.5 && p.z.abs() <= 0.125);
        assert!(cut && (made.mesh.volume() / inner - 1.0).abs() < 0.03, "{n}: {} {inner}", made.mesh.volume());
    }
}
