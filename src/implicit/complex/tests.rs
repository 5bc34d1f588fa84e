//! Arrangements against known truth: all patterns of signs on one tetrahedron with ties, and whole parts.

use std::sync::atomic::{AtomicUsize, Ordering};

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DVec3;

use super::cell::{Crossed, Facet, Named, Vertex};
use super::exact::{MOST, Matrix, positive, sign};
use super::*;
use crate::implicit::tests::Counted;
use crate::implicit::{Expr, Placement, Primitive, RSystem, Solid};
use crate::spatial::Aabb;

/// Boolean functions of up to three sides: meeting, joining, differences, touching sectors.
const BOOLEANS: [fn(&[bool; 3]) -> bool; 6] = [
    |s| s[0] && s[1] && s[2],
    |s| s[0] || s[1] || s[2],
    |s| s[0] && !s[1] || s[2],
    |s| (s[0] || s[1]) && s[2],
    |s| s[0] == s[1],
    |s| (s[0] != s[1]) != s[2],
];

/// The boundary in a tetrahedron; leaves that do not cut it have one side.
fn boundary(values: &[[f64; 4]], inside: fn(&[bool; 3]) -> bool) -> Vec<Facet> {
    let cuts = |v: &[f64; 4]| v.iter().any(|x| (*x >= 0.0) != (v[0] >= 0.0));
    let which: Vec<usize> = (0..values.len()).filter(|k| cuts(&values[*k])).collect();
    let leaves: Vec<u32> = which.iter().map(|k| *k as u32).collect();
    let cutting: Vec<[f64; 4]> = which.iter().map(|k| values[*k]).collect();
    let cut = Crossed { leaves: &leaves, values: &cutting };
    let inside = |sides: &[bool]| {
        let mut all = [true; 3];
        for (k, v) in values.iter().enumerate() {
            all[k] = which.iter().position(|w| *w == k).map_or(v[0] >= 0.0, |at| sides[at]);
        }
        inside(&all)
    };
    let mut facets =
        cut.boundary(&Boolean { inside: &inside, named: &|l, _| Named { leaf: cut.leaves[l as usize], face: 0 } });
    // By the leaves' own numbers.
    for f in &mut facets {
        f.leaf = leaves[f.leaf as usize] as u8;
        for v in f.loops.iter_mut().flatten() {
            v.leaves.iter_mut().filter(|l| **l != u8::MAX).for_each(|l| *l = leaves[*l as usize] as u8);
        }
    }
    facets
}

/// Directed edges of the boundary with the leaf they bound.
fn edges(facets: &[Facet]) -> Vec<(Vertex, Vertex, u8)> {
    let mut all = Vec::new();
    for f in facets {
        for ring in &f.loops {
            all.extend((0..ring.len()).map(|k| (ring[k], ring[(k + 1) % ring.len()], f.leaf)));
        }
    }
    all.sort_unstable();
    all
}

/// Whether the boundary closes up inside, and its edges on the face of corners 0, 1 and 2.
fn on_face(facets: &[Facet], what: &dyn Fn() -> String) -> Vec<(Vertex, Vertex, u8)> {
    let all = edges(facets);
    let common = |a: &Vertex, b: &Vertex| a.corners | b.corners;
    let inner: Vec<_> = all.iter().filter(|e| common(&e.0, &e.1) == 0b1111).collect();
    for e in &inner {
        let there = inner.iter().filter(|x| (x.0, x.1) == (e.0, e.1)).count();
        let back = inner.iter().filter(|x| (x.0, x.1) == (e.1, e.0)).count();
        assert_eq!(there, back, "{e:?} has no partner: {}", what());
    }
    all.into_iter().filter(|e| common(&e.0, &e.1) & 0b1000 == 0).collect()
}

/// All values of one leaf at three corners, and at the fourth.
fn faces() -> impl Iterator<Item = [f64; 3]> + Clone {
    const VALUES: [f64; 3] = [-1.0, 0.0, 2.0];
    (0..27).map(|m| [VALUES[m % 3], VALUES[m / 3 % 3], VALUES[m / 9]])
}

fn agree(faces: &[[f64; 3]], fourths: &[f64], inside: fn(&[bool; 3]) -> bool) {
    let n = faces.len();
    let mut known: Option<Vec<(Vertex, Vertex, u8)>> = None;
    for m in 0..fourths.len().pow(n as u32) {
        let fourth = |k: usize| fourths[m / fourths.len().pow(k as u32) % fourths.len()];
        let values: Vec<[f64; 4]> = (0..n).map(|k| [faces[k][0], faces[k][1], faces[k][2], fourth(k)]).collect();
        let seen = on_face(&boundary(&values, inside), &|| format!("{values:?}"));
        match &known {
            Some(known) => assert_eq!(known, &seen, "{values:?}"),
            None => known = Some(seen),
        }
    }
}

#[test]
fn neighbors_see_the_same_on_their_common_face_whatever_lies_beyond() {
    for inside in BOOLEANS {
        for a in faces() {
            agree(&[a], &[-1.0, 0.0, 1.5], inside);
            for b in faces() {
                agree(&[a, b], &[-1.0, 0.0, 1.5], inside);
            }
        }
    }
    // Three leaves: every third pattern with every pattern of the others, two values beyond.
    for inside in BOOLEANS {
        for a in faces() {
            for b in faces().step_by(2) {
                for c in faces().step_by(3) {
                    agree(&[a, b, c], &[-1.0, 1.5], inside);
                }
            }
        }
    }
}

#[test]
fn signs_are_exact_and_ties_are_those_of_shifted_leaves() {
    let mut state = 5u64;
    let mut small = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % 5) as f64 - 2.0
    };
    let (mut ties, mut zeros) = (0, 0);
    for _ in 0..20_000 {
        let n = 2 + (small() as i64 + 2) as usize % 3;
        let mut m: Matrix = [[0.0; MOST]; MOST];
        m.iter_mut().take(n).for_each(|r| r.iter_mut().take(n).for_each(|v| *v = small()));
        // Whole numbers: by elimination over the integers.
        let whole = |m: &Matrix| -> i64 {
            fn det(rows: &[Vec<i64>]) -> i64 {
                let Some(first) = rows.first() else { return 1 };
                (0..first.len())
                    .map(|k| {
                        let rest: Vec<Vec<i64>> = rows[1..]
                            .iter()
                            .map(|r| r.iter().enumerate().filter(|x| x.0 != k).map(|x| *x.1).collect())
                            .collect();
                        first[k] * det(&rest) * if k % 2 == 0 { 1 } else { -1 }
                    })
                    .sum()
            }
            det(&(0..n).map(|r| (0..n).map(|c| m[r][c] as i64).collect()).collect::<Vec<Vec<i64>>>())
        };
        assert_eq!(i64::from(sign(&m, n)), whole(&m).signum());
        let mut tiny = m;
        tiny.iter_mut().for_each(|r| r.iter_mut().for_each(|v| *v *= 1e-170));
        assert_eq!(i64::from(sign(&tiny, n)), whole(&m).signum());
        // The others must have one point in common.
        let mut ones = m;
        ones[0] = [1.0; MOST];
        if whole(&ones) == 0 {
            zeros += 1;
            continue;
        }
        ties += usize::from(whole(&m) == 0);
        // Shifts far smaller than any value, and each far smaller than the one before, as whole numbers.
        let order = [1u32, 0, 3, 2];
        let scale = 10f64.powi(12);
        let mut shifted = m;
        for (k, row) in shifted.iter_mut().enumerate().take(n) {
            let shift = 10f64.powi(9 - 3 * order[k] as i32);
            row.iter_mut().take(n).for_each(|v| *v = *v * scale + shift);
        }
        let value = sign(&shifted, n);
        assert_eq!(positive(&m, n, &order[..n]), value == whole(&ones).signum() as i32, "{m:?} {n}");
    }
    assert!(ties > 500 && zeros > 500, "{ties} ties, {zeros} without a point");
}

fn made(solid: &Solid, size: f64) -> Arranged {
    let model = Implicit::new(solid, RSystem::R0, Some(Aabb::new(DVec3::splat(-3.0), DVec3::splat(3.0)))).unwrap();
    arranged(
        &model,
        &CellGrid { size, coarser: 0, places: &[], more: 0, block: None, before: None },
        1 << 32,
        &Run::new(),
    )
    .unwrap()
}

fn sound(a: &Arranged) {
    let mesh = &a.made.mesh;
    mesh.validate().unwrap();
    let d = mesh.defects();
    assert!(d.is_closed() && d.is_manifold() && d.is_oriented());
    assert_eq!(mesh.nodes.len(), a.made.leaves.len());
}

#[test]
fn boxes_on_a_grid_have_their_volume_whatever_they_share() {
    let cube = |x: f64, y: f64, z: f64, s: f64| Solid::cuboid(DVec3::new(x, y, z), DVec3::new(x + s, y + s, z + s));
    // Side by side, by an edge, by a corner, and one hollow whose walls are others' walls.
    let cases = [
        (cube(0.0, 0.0, 0.0, 1.0) | cube(1.0, 0.0, 0.0, 1.0), 2.0),
        (cube(0.0, 0.0, 0.0, 1.0) | cube(1.0, 1.0, 0.0, 1.0), 2.0),
        (cube(0.0, 0.0, 0.0, 1.0) | cube(1.0, 1.0, 1.0, 1.0), 2.0),
        (
            cube(0.0, 0.0, 0.0, 1.0) | cube(1.0, 1.0, 0.0, 1.0) | cube(0.0, 1.0, 1.0, 1.0) | cube(1.0, 0.0, 1.0, 1.0),
            4.0,
        ),
        (cube(-1.0, -1.0, -1.0, 3.0) - cube(0.0, 0.0, 0.0, 1.0) - cube(1.0, 1.0, 0.0, 1.0), 25.0),
    ];
    for (solid, volume) in cases {
        for size in [0.11, 0.3, 0.5] {
            let a = made(&solid, size);
            sound(&a);
            let v = a.made.mesh.volume();
            assert_abs_diff_eq!(v, volume, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_part_that_is_proved_has_its_corners_and_says_so() {
    let bore = |a: DVec3, r: f64| Solid::cylinder(r, a, DVec3::ZERO, None);
    let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let a = made(&(cube.clone() - bore(DVec3::X, 0.4) - bore(DVec3::Z, 0.3)), 0.15);
    sound(&a);
    assert!(a.unproved.is_empty() && a.astray.is_empty(), "{:?}", a.unproved);
    assert_eq!(a.made.leaves.iter().filter(|l| l.len() == 3).count(), 8);
    // Bores of one radius cross in curves that touch in two points: these are named, and nothing else.
    let a = made(&(cube - bore(DVec3::X, 0.4) - bore(DVec3::Z, 0.4)), 0.15);
    sound(&a);
    assert!(!a.unproved.is_empty() && a.unproved.iter().all(|u| u.reason == Unproved::Touching));
    let near = |p: &DVec3| p.distance(DVec3::new(0.0, 0.4_f64.copysign(p.y), 0.0)) < 0.05;
    assert!(a.unproved.iter().all(|u| near(&u.cell.center())), "{:?}", a.unproved);
}

#[test]
fn what_is_far_thinner_than_a_cell_is_there() {
    // A pin a tenth of a cell wide and a slit a twentieth of one.
    let pin = Solid::cylinder(0.01, DVec3::X, DVec3::new(0.013, 0.021, 0.008), Some(1.7));
    let slit = Solid::cuboid(DVec3::new(-0.501, -2.0, -2.0), DVec3::new(-0.491, 2.0, 2.0));
    let a = made(&pin, 0.2);
    sound(&a);
    let v = std::f64::consts::PI * 1e-4 * 1.7;
    assert_abs_diff_eq!(a.made.mesh.volume(), v, epsilon = 0.2 * v);
    let a = made(&(Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)) - slit), 0.2);
    sound(&a);
    assert_abs_diff_eq!(a.made.mesh.volume(), 8.0 - 0.04, epsilon = 1e-9);
}

#[test]
fn a_formula_that_bends_back_is_refined_until_it_does_not() {
    // A sphere of a third of a cell, as a formula and beside another.
    let q = |c: f64| {
        let [x, y, z] = [Expr::x() - c, Expr::y(), Expr::z()].map(|e| e.clone() * e);
        Solid::formula(Expr::constant(0.01) - (x + y + z))
    };
    let a = made(&(q(0.5) | q(-0.6)), 0.3);
    sound(&a);
    let topology = a.made.mesh.topology(&a.made.mesh.defects());
    assert_eq!((topology.components, topology.euler), (2, 4));
    assert!(a.unproved.is_empty());
}

#[test]
fn three_leaves_that_share_a_circle_bound_what_any_of_the_six_sectors_around_it_bound() {
    // A cylinder, a plane and a cone through one circle; the signs of the sectors around it, in turn.
    let r = Expr::unary(crate::implicit::expr::Unary::Sqrt, Expr::x() * Expr::x() + Expr::y() * Expr::y());
    let leaves = [
        Solid::formula(r.clone() - 1.0),
        Solid::formula(Expr::z() - 0.1),
        Solid::formula(r + (Expr::z() - 0.1) * 0.7 - 1.0),
    ];
    let turns = [[1, 1, 1], [0, 1, 1], [0, 1, 0], [0, 0, 0], [1, 0, 0], [1, 0, 1]];
    let sector = |k: usize| {
        Solid::intersection((0..3).map(|l| if turns[k][l] == 1 { leaves[l].clone() } else { !leaves[l].clone() }))
    };
    let around =
        Solid::cuboid(DVec3::splat(-1.7), DVec3::splat(1.7)) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None);
    for first in 0..6 {
        for count in 1..6 {
            let some = Solid::union((first..first + count).map(|k| sector(k % 6)));
            let a = made(&(some & around.clone()), 0.21);
            sound(&a);
            assert!(a.unproved.is_empty() && a.astray.is_empty(), "{first} {count} {:?}", a.unproved);
            let m = &a.made.mesh;
            // Of all that is near the circle, only what bounds the sectors shows, and where both bound, their circle does.
            let on_circle = |p: DVec3| (p.x.hypot(p.y) - 1.0).abs() < 1e-9 && (p.z - 0.1).abs() < 1e-9;
            let flat = m.triangles.iter().filter(|t| t.iter().all(|v| on_circle(m.nodes[*v as usize]))).count();
            assert_eq!(flat, 0, "{first} {count}");
            let circle = (0..m.nodes.len()).filter(|v| on_circle(m.nodes[*v])).count();
            assert_eq!(circle == 0, count == 3, "{first} {count}: {circle}");
        }
    }
}

#[test]
fn what_divides_an_angle_from_itself_is_no_matter_where_it_runs_along_a_surface() {
    // Fins of one width all along their arms: their flanks run through the surfaces where the wave's cases part at two degrees.
    let [sin, cos] = [crate::implicit::expr::Unary::Sin, crate::implicit::expr::Unary::Cos];
    let atan2 = |y: Expr, x: Expr| Expr::binary(crate::implicit::expr::Binary::Atan2, y, x);
    let turn = atan2(Expr::y(), Expr::x()) * 8.0;
    let wave = atan2(Expr::unary(sin, turn.clone()), Expr::unary(cos, turn));
    let radius = Expr::binary(crate::implicit::expr::Binary::Hypot, Expr::x(), Expr::y());
    let (wide, short, long, high) = (0.2, 0.8, 2.6, 0.4);
    let arc = Expr::unary(crate::implicit::expr::Unary::Abs, wave) * radius / 8.0;
    let fins = Solid::formula(Expr::constant(0.5 * wide) - arc);
    let ring =
        Solid::cylinder(long, DVec3::Z, DVec3::ZERO, Some(high)) - Solid::cylinder(short, DVec3::Z, DVec3::ZERO, None);
    let a = made(&(fins & ring), 0.21);
    sound(&a);
    assert!(a.unproved.is_empty() && a.astray.is_empty(), "{:?}", a.unproved);
    assert_eq!(a.made.leaves.iter().filter(|l| l.len() == 3).count(), 8 * 8);
    let v = a.made.mesh.volume() / (8.0 * wide * (long - short) * high);
    assert_abs_diff_eq!(v, 1.0, epsilon = 0.02);
}

#[test]
fn balls_that_overlap_by_a_hair_meet_in_their_circle() {
    // Circles of four fifths and of half of the smallest cell that others may have; centers lie askew to the grid.
    for (k, radius) in [0.03_f64, 0.02].into_iter().enumerate() {
        let (r, s) = (1.0_f64, 1.2_f64);
        let lower = (r * r - radius * radius).sqrt();
        let apart = lower + (s * s - radius * radius).sqrt();
        let way = DVec3::new(0.3, 0.4 - 0.1 * k as f64, 2.1).normalize();
        let from = DVec3::new(0.013, -0.021, -1.008);
        let a = made(&(Solid::sphere(r, from) | Solid::sphere(s, from + way * apart)), 0.6);
        sound(&a);
        assert!(a.unproved.is_empty() && a.astray.is_empty(), "{radius}: {:?}", a.unproved);
        let mut nodes = 0;
        for (p, on) in a.made.mesh.nodes.iter().zip(&a.made.leaves) {
            if on.len() == 2 {
                let off = *p - from - way * lower;
                let (along, across) = (off.dot(way), (off - way * off.dot(way)).length());
                assert!(along.abs() < 1e-9 && (across - radius).abs() < 1e-9, "{radius}: {along} {across}");
                nodes += 1;
            }
        }
        assert!(nodes >= 8, "{radius}: {nodes}");
        assert_eq!(a.made.mesh.topology(&a.made.mesh.defects()).euler, 2);
    }
}

/// Triangles by the places of their nodes, and where blocks end.
fn placed(a: &Arranged) -> Vec<[[u64; 3]; 3]> {
    let bits = |v: u32| a.made.mesh.nodes[v as usize].to_array().map(f64::to_bits);
    a.made.mesh.triangles.iter().map(|t| t.map(bits)).collect()
}

#[test]
fn an_ellipsoid_is_no_harder_to_prove_than_its_quadric() {
    // Its function is divided by that of its slope: the quotient's bounds are far wider.
    let radii = DVec3::new(1.0, 0.9, 0.1);
    let (x, y, z) = (Expr::x() / radii.x, Expr::y() / radii.y, Expr::z() / radii.z);
    let quadric = Expr::constant(1.0) - (x.clone() * x + y.clone() * y + z.clone() * z);
    let [one, other] = [Primitive::Ellipsoid { radii, at: DVec3::ZERO }.into(), Solid::formula(quadric)]
        .map(|s: Solid| made(&s, 0.06));
    sound(&one);
    assert!(one.unproved.is_empty() && one.astray.is_empty());
    // Their boxes, and so their grids, are not the same.
    assert!(10 * one.cells < 11 * other.cells, "{} and {}", one.cells, other.cells);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radii.element_product();
    assert_relative_eq!(one.made.mesh.volume(), volume, max_relative = 0.02);
}

#[test]
fn blocks_of_a_grid_give_what_the_whole_grid_gives() {
    // Corners, creases on all kinds of walls, a pin far thinner than the cells.
    let hole = |axis| Solid::cylinder(0.4, axis, DVec3::ZERO, None);
    let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let pin = Solid::cylinder(0.02, DVec3::Z, DVec3::new(0.7, 0.7, 0.0), Some(1.4));
    let solid = (cube - hole(DVec3::X) - hole(DVec3::new(0.3, 0.2, 1.0)) - Solid::sphere(0.6, DVec3::ONE)) | pin;
    let model = Implicit::new(&solid, RSystem::R0, None).unwrap();
    let size = 0.21;
    let cells = cells_along(&model.bounds(), size);
    // One block that is all of the grid: nodes around folded triangles move in the order of their names, as in the others.
    let block = Some(GridBlock { lo: [0; 3], hi: cells });
    let whole = arranged(
        &model,
        &CellGrid { size, coarser: 0, places: &[], more: 0, block, before: None },
        1 << 32,
        &Run::new(),
    )
    .unwrap();
    sound(&whole);
    let mut all: Vec<[[u64; 3]; 3]> = Vec::new();
    let mut known: FxHashMap<EndKey, [u64; 3]> = FxHashMap::default();
    let mut seen: FxHashMap<EndKey, usize> = FxHashMap::default();
    for k in 0..12u32 {
        let n = [2, 3, 2];
        let at = [k % 2, k / 2 % 3, k / 6];
        let bound = |d: u32| std::array::from_fn(|i| cells[i] * (at[i] + d) / n[i]);
        let block = Some(GridBlock { lo: bound(0), hi: bound(1) });
        let some = arranged(
            &model,
            &CellGrid { size, coarser: 0, places: &[], more: 0, block, before: None },
            1 << 32,
            &Run::new(),
        )
        .unwrap();
        all.extend(placed(&some));
        let mut here: Vec<EndKey> = some.ends.iter().map(|e| e.1).collect();
        for (v, key) in &some.ends {
            let bits = some.made.mesh.nodes[*v as usize].to_array().map(f64::to_bits);
            assert_eq!(*known.entry(*key).or_insert(bits), bits);
        }
        here.sort_unstable();
        here.dedup();
        here.into_iter().for_each(|k| *seen.entry(k).or_default() += 1);
    }
    // Nodes where blocks meet are in two of them or more.
    assert!(seen.len() > 100 && seen.values().all(|n| *n > 1));
    // The triangles are the same but for nodes that were moved around folded ones.
    let mut expected = placed(&whole);
    let same = |t: &mut [[u64; 3]; 3]| {
        let first = (0..3).min_by_key(|k| t[*k]).unwrap();
        t.rotate_left(first);
    };
    all.iter_mut().chain(&mut expected).for_each(same);
    all.sort_unstable();
    expected.sort_unstable();
    assert_eq!(all.len(), expected.len());
    let common = all.iter().filter(|t| expected.binary_search(t).is_ok()).count();
    assert!(100 * common >= 97 * all.len(), "{common} of {}", all.len());
}

#[test]
fn a_block_with_larger_cells_inside_ends_as_one_without() {
    let hole = |radius, axis| Solid::cylinder(radius, axis, DVec3::ZERO, None);
    let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let model = Implicit::new(&(cube - hole(0.4, DVec3::X) - hole(0.3, DVec3::Y)), RSystem::R0, None).unwrap();
    let size = 0.08;
    let cells = cells_along(&model.bounds(), size);
    let half = cells[0] / 2;
    for (lo, hi) in [(0, half), (half, cells[0])] {
        let block = Some(GridBlock { lo: [lo, 0, 0], hi: [hi, cells[1], cells[2]] });
        let [fine, coarse] = [0, 1].map(|coarser| {
            let grid = CellGrid { size, coarser, places: &[], more: 0, block, before: None };
            arranged(&model, &grid, 1 << 32, &Run::new()).unwrap()
        });
        let ends = |a: &Arranged| {
            let place = |v: u32| a.made.mesh.nodes[v as usize].to_array().map(f64::to_bits);
            let mut ends: Vec<(EndKey, [u64; 3])> = a.ends.iter().map(|(v, key)| (*key, place(*v))).collect();
            ends.sort_unstable();
            ends
        };
        assert!(fine.ends.len() > 50);
        let [one, other] = [ends(&fine), ends(&coarse)];
        let differ = one.iter().filter(|e| !other.contains(e)).count();
        assert!(one.len() == other.len() && differ == 0, "{differ} of {} and {}", one.len(), other.len());
        let [few, many] = [&coarse, &fine].map(|a| a.made.mesh.triangles.len());
        assert!(10 * few < 9 * many, "{few} of {many}");
        // Planes and the straight lines of cylinders go through both: the bores' chords are all that area differs by.
        assert_relative_eq!(coarse.made.mesh.area(), fine.made.mesh.area(), max_relative = 5e-3);
        assert!(coarse.unproved.is_empty() && coarse.astray.is_empty());
    }
}

#[test]
fn nodes_in_one_line_to_rounding_give_no_triangle_without_area() {
    // A polygon with nodes along its sides, each off by some units in the last place, turned and far from the origin.
    let corners = [[0.0, 0.0], [6.0, 0.0], [8.0, 1.0], [7.0, 4.0], [0.0, 3.0]];
    let (u, v) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 1.0, 0.0));
    let mut seed = 1u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((seed >> 33) as f64 / (1u64 << 31) as f64 - 0.5) * 4e-14
    };
    for parts in [2, 3, 5, 9] {
        for _ in 0..50 {
            let mut ring = Vec::new();
            for (k, a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                for i in 0..parts {
                    let s = f64::from(i) / f64::from(parts);
                    let p = u * (a[0] + s * (b[0] - a[0])) + v * (a[1] + s * (b[1] - a[1]));
                    ring.push((ring.len() as u32, p + 100.0 + DVec3::new(noise(), noise(), noise())));
                }
            }
            let places: Vec<DVec3> = ring.iter().map(|n| n.1).collect();
            let (mut area, mut count) = (0.0, 0);
            assemble::triangulate(ring, &mut |t| {
                let [a, b, c] = t.map(|n| places[n as usize]);
                let doubled = (b - a).cross(c - a).dot(u.cross(v));
                assert!(doubled > 1e-3, "{parts}: {t:?} {doubled}");
                (area, count) = (area + 0.5 * doubled, count + 1);
            });
            assert_eq!(count, places.len() - 2);
            assert_abs_diff_eq!(area, 26.0, epsilon = 1e-9);
        }
    }
}

#[test]
fn surfaces_beside_each_other_show_no_patches_of_the_hidden_one() {
    // Between parallel faces less than the radius apart the fillet runs parallel to both, here 0.7 % of a cell above the upper one: linear
    // interpolants of the fillet dip below that.
    let (radius, depth) = (0.3, 0.27);
    let upper = Solid::cuboid(DVec3::new(-1.0, -1.0, -1.0), DVec3::new(0.5, 1.0, 0.0)).name("upper");
    let lower = Solid::cuboid(DVec3::new(-0.6, -1.2, -1.0), DVec3::new(1.0, 1.2, -depth)).name("lower");
    let rotation = glam::DMat3::from_rotation_x(0.26);
    let placement = Placement { rotation, ..Placement::IDENTITY };
    let a = made(&upper.blend(lower, radius).placed(placement), 0.2);
    sound(&a);
    // At a height h above the upper face the fillet is where (r - h)^2 + (r - h - depth)^2 is r^2.
    let rest = radius - depth;
    let above = 0.5 * (radius + rest) - (0.5 * radius * radius - 0.25 * depth * depth).sqrt();
    let mut seen = 0;
    for (t, label) in a.made.mesh.triangles.iter().zip(&a.made.mesh.labels) {
        let middle = t.iter().map(|v| a.made.mesh.nodes[*v as usize]).sum::<DVec3>() / 3.0;
        let p = rotation.transpose() * middle;
        if p.z > -0.1 && p.x.abs() < 0.4 && p.y.abs() < 0.9 {
            assert!((p.z - above).abs() < 0.2 * above, "{p} on leaf {label}, not {above}");
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen}");
}

fn plane(n: DVec3) -> Leaf {
    Leaf::Plane { n, d: 0.0 }
}

#[test]
fn nodes_that_passed_each_other_on_their_curve_change_places() {
    // A roof's ridge along x: a row of nodes on either side of it, and nodes on it in any order.
    let leaves = [plane(DVec3::new(0.0, 0.6, 0.8)), plane(DVec3::new(0.0, -0.6, 0.8))];
    let count = 6;
    let x = |k: usize| k as f64 / (count - 1) as f64;
    let side = |y: f64| (0..count).map(move |k| DVec3::new(x(k), y, -0.75 * y.abs()));
    let linear: Vec<DVec3> = side(0.0).chain(side(-0.5)).chain(side(0.5)).collect();
    let on: Vec<Vec<u32>> = (0..3 * count)
        .map(|v| match v / count {
            0 if v == 0 || v == count - 1 => vec![0, 1, 2],
            0 => vec![0, 1],
            side => vec![2 - side as u32],
        })
        .collect();
    let mut triangles = Vec::new();
    for k in 0..count as u32 - 1 {
        let (below, above) = (k + count as u32, k + 2 * count as u32);
        let of = |nodes, leaf| Triangle { nodes, leaf, plus: true, face: leaf, side: [0; 3] };
        triangles.extend([of([k, below, below + 1], 1), of([k, below + 1, k + 1], 1)]);
        triangles.extend([of([k, k + 1, above + 1], 0), of([k, above + 1, above], 0)]);
    }
    for order in [[0, 1, 2, 3, 4, 5], [0, 4, 3, 2, 1, 5], [0, 2, 1, 4, 3, 5], [0, 3, 1, 4, 2, 5]] {
        let mut places = linear.clone();
        order.iter().enumerate().for_each(|(v, k)| places[v] = linear[*k]);
        let reach = vec![1.0; places.len()];
        let mut nodes = Nodes { places, on: &on, reach: &reach, leaves: &leaves, scale: 2.0, stay: &[], common: None };
        nodes.straighten(&linear, &triangles, &Run::new()).unwrap();
        assert!(nodes.places[..count].windows(2).all(|w| w[0].x < w[1].x), "{order:?}: {:?}", &nodes.places[..count]);
        assert!(nodes.places[..count].iter().all(|p| p.y.abs() < 1e-12 && p.z.abs() < 1e-12));
        assert_eq!(nodes.places[count..], linear[count..]);
    }
}

#[test]
fn a_border_that_moves_past_rows_of_nodes_takes_them_along() {
    // A square of a plane, whose border on one side moved past half of its rows.
    let leaves = [plane(DVec3::Z)];
    let n = 9;
    let at = |i: usize, k: usize| DVec3::new(k as f64 / (n - 1) as f64, i as f64 / (n - 1) as f64, 0.0);
    let mut places: Vec<DVec3> = (0..n * n).map(|v| at(v / n, v % n)).collect();
    (0..n).for_each(|i| places[i * n + n - 1].x = 0.45);
    (0..n).for_each(|k| [k, (n - 1) * n + k].into_iter().for_each(|v| places[v].x = 0.45 * at(0, k).x));
    let is_border = |v: usize| [0, n - 1].contains(&(v / n)) || [0, n - 1].contains(&(v % n));
    let on: Vec<Vec<u32>> = (0..n * n).map(|v| if is_border(v) { vec![0, 1, 2] } else { vec![0] }).collect();
    let mut triangles = Vec::new();
    for (i, k) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |k| (i, k))) {
        let [a, b, c, d] = [[0, 0], [0, 1], [1, 1], [1, 0]].map(|[di, dk]| ((i + di) * n + k + dk) as u32);
        let of = |nodes| Triangle { nodes, leaf: 0, plus: true, face: 0, side: [0; 3] };
        triangles.extend([of([a, b, c]), of([a, c, d])]);
    }
    let reach = vec![1.0; places.len()];
    let mut nodes = Nodes { places, on: &on, reach: &reach, leaves: &leaves, scale: 2.0, stay: &[], common: None };
    nodes.untangle_together(&triangles, &Run::new()).unwrap();
    let turned = triangles.iter().filter(|t| {
        let [a, b, c] = t.nodes.map(|v| nodes.places[v as usize]);
        (b - a).cross(c - a).z <= 0.0
    });
    assert_eq!(turned.count(), 0);
}

#[test]
fn what_is_known_changes_nothing() {
    // Bores of one radius: their curves cross in points.
    let hole = |radius, axis, at| Solid::cylinder(radius, axis, at, None);
    let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let bored = cube - hole(0.4, DVec3::X, DVec3::ZERO) - hole(0.4, DVec3::Y, DVec3::ZERO);
    let ball = Solid::sphere(0.5, DVec3::new(0.9, 0.8, 0.7));
    let solids = [bored.clone(), bored | ball];
    for solid in &solids {
        let model = Implicit::new(solid, RSystem::R0, None).unwrap();
        let run = Run::new();
        let grid = CellGrid { size: 0.25, coarser: 1, places: &[], more: 0, block: None, before: None };
        let first = arranged(&model, &grid, 1 << 32, &run).unwrap();
        assert!(!first.unproved.is_empty());
        // one place in two, so that some of what is not proved stays
        let places: Vec<Aabb> = first.unproved.iter().step_by(2).map(|u| u.cell).collect();
        let [anew, again] = [None, Some(&first)].map(|before| {
            let grid = CellGrid { places: &places, more: 2, before, ..grid };
            arranged(&model, &grid, 1 << 32, &run).unwrap()
        });
        assert!(anew.made.mesh.triangles.len() > first.made.mesh.triangles.len());
        assert_eq!(anew.made.mesh, again.made.mesh);
        assert_eq!((anew.made.leaves, anew.made.faces), (again.made.leaves, again.made.faces));
        assert_eq!((anew.unproved, anew.crossed, anew.astray), (again.unproved, again.crossed, again.astray));
        assert_eq!(anew.linear, again.linear);
    }
}

#[test]
fn cells_that_are_known_are_not_asked_again() {
    // Where bores cross a ball's function is not asked, and around that cells are as they were.
    let asked = Arc::new(AtomicUsize::new(0));
    let hole = |axis| Solid::cylinder(0.4, axis, DVec3::ZERO, None);
    let solid = Solid::field(Counted(asked.clone())) - hole(DVec3::X) - hole(DVec3::Y);
    let domain = Aabb::new(DVec3::splat(-1.3), DVec3::splat(1.35));
    let model = Implicit::new(&solid, RSystem::R0, Some(domain)).unwrap();
    let run = Run::new();
    let grid = CellGrid { size: 0.25, coarser: 1, places: &[], more: 0, block: None, before: None };
    let first = arranged(&model, &grid, 1 << 32, &run).unwrap();
    let places: Vec<Aabb> = first.unproved.iter().map(|u| u.cell).collect();
    let [(anew, count), (again, fewer)] = [None, Some(&first)].map(|before| {
        asked.store(0, Ordering::Relaxed);
        let grid = CellGrid { places: &places, more: 2, before, ..grid };
        (arranged(&model, &grid, 1 << 32, &run).unwrap(), asked.load(Ordering::Relaxed))
    });
    assert!(anew.made.mesh.triangles.len() > first.made.mesh.triangles.len());
    assert_eq!(anew.made.mesh, again.made.mesh);
    // Facets and nodes are made anew.
    assert!(5 * fewer < 4 * count, "{fewer} of {count}");
}
