//! Plane figures extruded and turned about an axis, from part files and from OpenSCAD's trees, against closed forms.

use std::f64::consts::PI;
use std::path::Path;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DMat3;
use proptest::prelude::*;
use rvachev::implicit::part::{Part, parse_csg};
use rvachev::implicit::{Expr, Implicit, Placement, Primitive, RSystem, Solid, check_plane};
use rvachev::pipeline::{MeshOptions, Meshed, SizeRequest, mesh_part, parse_part};
use rvachev::{DVec3, Error, Place, Run};

fn read(text: &str) -> Part {
    parse_part(Path::new("a.py"), text, &[]).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

/// Meshes a part, which must be sound and have this Euler number; its volume must be right to 0.2 %.
#[track_caller]
fn right(part: &Part, volume: f64, euler: i64) -> Meshed {
    let options = MeshOptions { size: Some(SizeRequest::Share(0.008)), ..MeshOptions::default() };
    let m = mesh_part(part, &options, &Run::new()).unwrap();
    let check = m.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{}", check.certificate);
    assert_eq!(m.report.shortfalls, []);
    assert_relative_eq!(m.mesh.volume(), volume, epsilon = 0.0, max_relative = 2e-3);
    let mut edges: Vec<[u32; 2]> = m
        .mesh
        .triangles
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .filter(|e| e[0] < e[1])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let found = m.mesh.nodes.len() as i64 - edges.len() as i64 + m.mesh.triangles.len() as i64;
    assert_eq!(found, euler);
    m
}

#[track_caller]
fn faces(m: &Meshed, expected: &[&str]) {
    let mut used: Vec<&str> = m.mesh.labels.iter().map(|l| &m.mesh.faces[*l as usize][..]).collect();
    used.sort_unstable();
    used.dedup();
    let mut expected = expected.to_vec();
    expected.sort_unstable();
    assert_eq!(used, expected);
}

#[test]
fn a_plate_with_holes_is_extruded() {
    let part = read(
        "plate = rectangle(size=(12, 8)).name('plate')\n\
         bolts = union([circle(0.5, at=(x, y)) for x in (-5, 5) for y in (-3, 3)]).name('bolts')\n\
         part(extrude(plate - bolts - circle(2.2).name('window'), 1.5, at=(1, 2, 3)).name('sheet'))\n",
    );
    // Five holes: the surface of a ball with five handles.
    let m = right(&part, 1.5 * (96.0 - PI * (1.0 + 4.84)), 2 - 2 * 5);
    faces(
        &m,
        &["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax", "bolts", "window", "sheet.bottom", "sheet.top"],
    );
    let b = Implicit::new(part.solid.as_ref().unwrap(), RSystem::R0, None).unwrap().bounds();
    assert_eq!((b.lo, b.hi), (DVec3::new(-5.0, -2.0, 2.25), DVec3::new(7.0, 6.0, 3.75)));
    assert_eq!(m.report.check.as_ref().unwrap().features.as_ref().unwrap().corners_found, 8);
}

#[test]
fn what_is_extruded_may_lean() {
    let part = read("part(extrude(ellipse(2, 1) - rectangle((1, 1)).rotate(30), 2).rotate(37, axis=(1, 2, 3)))");
    right(&part, 2.0 * (2.0 * PI - 1.0), 0);
    // The slab has the box of the figure in it, which no interval tells of what leans.
    let b = Implicit::new(part.solid.as_ref().unwrap(), RSystem::R0, None).unwrap().bounds();
    assert!(b.diagonal() < 13.0, "{}", b.diagonal());
}

#[test]
fn names_of_one_figure_are_those_of_its_caps() {
    let names = |text: &str| {
        let part = read(text);
        let model = Implicit::new(part.solid.as_ref().unwrap(), RSystem::R0, None).unwrap();
        let mut all: Vec<String> = model.faces().iter().map(|f| f.name.clone()).collect();
        all.sort();
        all
    };
    assert_eq!(names("part(extrude(circle(1).name('rod').move((3, 0)), 2))"), ["rod", "rod.bottom", "rod.top"]);
    assert_eq!(
        names("part(extrude(circle(1) | circle(1, at=(1, 0)), 2))"),
        ["cylinder1", "cylinder2", "extrude1.bottom", "extrude1.top"]
    );
    assert_eq!(names("part(extrude(figure=x**2 + y**2 <= 1, height=2).name('a'))"), ["a", "a.bottom", "a.top"]);
    assert_eq!(
        names("part(revolve(rectangle((1, 2), at=(2, 0)).name('r')))"),
        ["r.xmax", "r.xmin", "r.ymax", "r.ymin"]
    );
    // A polygon alone is what it was.
    let polygon = "polygon([(1, 0), (2, 0), (1, 2)])";
    assert_eq!(names(&format!("part(revolve({polygon}))")), ["revolve1.side0", "revolve1.side1", "revolve1.side2"]);
    assert_eq!(names(&format!("part(extrude(polygon={polygon}, height=1))")).len(), 5);
}

/// The volume of what is swept by the side `x >= 0` of a circle whose middle is at `x = at`.
fn apple(r: f64, at: f64) -> f64 {
    // The integral of 4 pi x sqrt(r^2 - (x - at)^2) for x from 0 to at + r.
    let h2 = r * r - at * at;
    let half = 0.5 * (at * h2.sqrt() + r * r * (PI / 2.0 + (at / r).asin()));
    4.0 * PI * (h2.powf(1.5) / 3.0 + at * half)
}

/// Figures that are turned, the volume of the solid by Pappus, and its Euler number.
#[test]
fn figures_are_turned() {
    let pappus = |area: f64, radius: f64| 2.0 * PI * radius * area;
    for (figure, volume, euler) in [
        ("circle(1, at=(3, 1))", pappus(PI, 3.0), 0),
        ("circle(2, at=(0, 1))", 32.0 / 3.0 * PI, 2),
        // Half of a rectangle is beyond the axis.
        ("rectangle((4, 3))", 12.0 * PI, 2),
        ("rectangle((1, 1)).rotate(30).move((3, 0))", pappus(1.0, 3.0), 0),
        ("rectangle((2, 2), at=(3, 0)) - circle(0.5, at=(3, 0))", pappus(4.0 - PI / 4.0, 3.0), 0),
        ("polygon([(2, 0), (4, 0), (3, 2)]).mirror('y')", pappus(2.0, 3.0), 0),
        // Formulas: with a slope on the axis where x is squared, and off it.
        ("region(x**2 / 4 + y**2 <= 1)", 4.0 / 3.0 * PI * 4.0, 2),
        ("ellipse(1, 0.5, at=(3, 0))", pappus(PI / 2.0, 3.0), 0),
        ("ellipse(2, 1)", 4.0 / 3.0 * PI * 4.0, 2),
        ("region(hypot(x, y) <= 1)", 4.0 / 3.0 * PI, 2),
        // Circles that cross the axis aside of it have a dimple or a tip on either end.
        ("circle(2, at=(1, 0))", apple(2.0, 1.0), 2),
        ("circle(2, at=(-1, 0)).name('lemon')", apple(2.0, -1.0), 2),
        // A cone with its apex on the axis, as a triangle that crosses it, and a rectangle on its corner.
        ("polygon([(-1, 0), (1, 0), (0, 2)]).move((0, 1))", 2.0 / 3.0 * PI, 2),
        ("rectangle((2, 2)).rotate(45)", 2.0 / 3.0 * PI * 2f64.sqrt().powi(3), 2),
        // A comb with its back beyond the axis: its two teeth are disks.
        ("polygon([(-2, 0), (1, 0), (1, 1), (-1, 1), (-1, 2), (1, 2), (1, 3), (-2, 3)]).move((0, 0))", 2.0 * PI, 4),
        // A ball with a bore: what is left is as high as the bore is long.
        ("circle(2) & region(x >= 1)", 4.0 / 3.0 * PI * 3f64.powf(1.5), 0),
    ] {
        println!("{figure}");
        right(&read(&format!("part(revolve({figure}))")), volume, euler);
        right(&read(&format!("part(revolve({figure}).scale(3).rotate(20, axis=(1, 1, 0)))")), 27.0 * volume, euler);
    }
}

#[test]
fn figures_keep_their_names_when_they_turn() {
    let m = right(
        &read(
            "ring = rectangle((2, 2), at=(3, 0)).name('ring')\nseat = circle(0.5, at=(4, 0)).name('seat').size(0.1)\n\
             part(revolve(ring - seat))\n",
        ),
        2.0 * PI * (3.0 * 4.0 - (PI / 8.0) * (4.0 - 4.0 * 0.5 / (3.0 * PI))),
        0,
    );
    faces(&m, &["ring.xmin", "ring.xmax", "ring.ymin", "ring.ymax", "seat"]);
}

#[test]
fn nodes_of_what_is_turned_count_as_those_of_the_part() {
    // Each row has twice the circles of the one before, which are one tree but for where they stand.
    let rows: String = (0..16).map(|k| format!("f{} = f{k} | f{k}.move(({}, 0))\n", k + 1, 1 << k)).collect();
    let text = |times: usize| {
        format!("f0 = circle(0.3, at=(1, 0))\n{rows}part(union([revolve(f16) for i in range({times})]))\n")
    };
    assert!(parse_part(Path::new("a.py"), &text(1), &[]).is_ok());
    match parse_part(Path::new("a.py"), &text(30), &[]) {
        Err(Error::Input { place: Place::Text { line: 18, .. }, message, .. }) => {
            assert!(message.contains("nodes"), "{message}");
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
}

#[test]
fn what_cannot_be_raised_is_refused_with_its_place() {
    for (text, column, says) in [
        ("part(extrude(sphere(1), 2))", 14, "depends on z"),
        ("part(revolve(solid(x + z <= 1)))", 14, "depends on z"),
        ("part(extrude('a', 2))", 14, "a plane figure is not made of a string"),
        ("part(extrude(circle(1), 0))", 25, "\"height\" of extrude() must be positive"),
        ("part(extrude(circle(1)))", 6, "extrude() needs \"height\""),
        ("part(revolve(circle(1), 2))", 25, "revolve() takes at most 1 arguments"),
        ("part(revolve(rectangle((1, 1)).rotate(90, axis='x')))", 14, "out of its plane"),
    ] {
        match parse_part(Path::new("a.py"), text, &[]) {
            Err(Error::Input { place: Place::Text { line: 1, column: c, .. }, message, .. }) => {
                assert!(c == column && message.contains(says), "{text}: column {c}: {message}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
}

/// A figure of primitives, placed and joined.
fn figure() -> impl Strategy<Value = Solid> {
    let near = || (-2.0f64..2.0, -2.0f64..2.0).prop_map(|(x, y)| DVec3::new(x, y, 0.0));
    let leaf = prop_oneof![
        (0.2f64..2.0, near()).prop_map(|(r, at)| Solid::cylinder(r, DVec3::Z, at, None)),
        (near(), near()).prop_map(|(a, b)| {
            let tall = DVec3::Z * f64::INFINITY;
            let (lo, hi) = (a.min(b).with_z(0.0), a.max(b) + DVec3::new(0.1, 0.1, 0.0));
            Primitive::Box { lo: lo.with_z(-tall.z), hi: hi.with_z(tall.z) }.into()
        }),
        (0.0f64..6.2, near()).prop_map(|(t, at)| Solid::half_space(DVec3::new(t.cos(), t.sin(), 0.0), at)),
        prop::collection::vec(0.2f64..2.0, 3..8).prop_map(|radii| {
            let n = radii.len() as f64;
            let corner = |(i, r): (usize, &f64)| {
                let (s, c) = ((i as f64 + 0.1) / n * 2.0 * PI).sin_cos();
                [r * c, r * s]
            };
            let polygon = radii.iter().enumerate().map(corner).collect();
            Primitive::Extrude { polygon, height: f64::INFINITY, at: DVec3::ZERO }.into()
        }),
        (0.2f64..2.0, -1.0f64..1.0).prop_map(|(a, b)| {
            let (x, y) = (Expr::x(), Expr::y());
            Solid::formula(Expr::constant(a) - x.clone() * x.clone() * 0.5 + x * b * y.clone() - y.clone() * y)
        }),
    ];
    let placed = (leaf, 0.0f64..6.2, any::<bool>(), 0.5f64..2.0, near()).prop_map(|(s, t, mirror, scale, shift)| {
        let flip = DMat3::from_diagonal(DVec3::new(if mirror { -1.0 } else { 1.0 }, 1.0, 1.0));
        s.placed(Placement { rotation: DMat3::from_rotation_z(t) * flip, scale, shift })
    });
    placed.prop_recursive(3, 8, 3, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone()).prop_map(|(a, b)| a & b),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| a | b),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| a - b),
            inner.clone().prop_map(|a| !a),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// What is extruded has the sign of the figure and the slab, what is turned that of the figure at (radius, z).
    #[test]
    fn raised_figures_have_the_signs_of_the_figure(
        f in figure(),
        height in 0.5f64..3.0,
        points in prop::collection::vec((-3.0f64..3.0, -3.0f64..3.0, -3.0f64..3.0), 40),
    ) {
        prop_assert!(check_plane(&f).is_ok());
        let around = rvachev::spatial::Aabb::new(DVec3::splat(-9.0), DVec3::splat(9.0));
        // A ball in a corner: nothing is empty, which is an error of its own.
        let model = |s: Solid| Implicit::new(&(s | Solid::sphere(0.5, DVec3::splat(8.0))), RSystem::R0, Some(around)).unwrap();
        let flat = model(f.clone());
        let (tall, round) = (model(f.clone().extruded(height).unwrap()), model(f.revolved().unwrap()));
        for (x, y, z) in points {
            let here = |x: f64, y: f64| (flat.inside(DVec3::new(x, y, 0.0)), flat.value(DVec3::new(x, y, 0.0)).abs() > 1e-9);
            let (inside, sure) = here(x, y);
            if sure && (z.abs() - 0.5 * height).abs() > 1e-9 {
                prop_assert_eq!(tall.inside(DVec3::new(x, y, z)), inside && z.abs() < 0.5 * height);
            }
            let (inside, sure) = here(x.hypot(y), z);
            if sure {
                prop_assert_eq!(round.inside(DVec3::new(x, y, z)), inside, "at {} {} {}", x, y, z);
            }
        }
    }
}

fn csg(text: &str) -> Part {
    parse_csg(text).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

#[test]
fn trees_raise_figures() {
    let ring = PI * 5.0 * 5.0 - PI * 2.0 * 2.0;
    for (text, volume, euler) in [
        // As OpenSCAD 2021 writes it.
        (
            "linear_extrude(height = 3, center = true, convexity = 1, scale = [1, 1], $fn = 0, $fa = 12, $fs = 2) {\n\
             difference() { circle($fn = 0, $fa = 12, $fs = 2, r = 5); circle($fn = 0, $fa = 12, $fs = 2, r = 2); } }",
            3.0 * ring,
            0,
        ),
        ("linear_extrude(height = 2) square(size = [2, 3], center = false);", 12.0, 2),
        ("linear_extrude(2) circle($fn = 6, r = 1);", 3.0 * 3f64.sqrt(), 2),
        (
            "linear_extrude(height = 2) polygon(points = [[0, 0], [9, 0], [0, 9], [1, 1], [6, 1], [1, 6], [2, 2], [3, 2], [2, 3]], \
             paths = [[0, 1, 2], [5, 4, 3], [6, 7, 8]], convexity = 1);",
            // Out, in and out again: a torus of Euler number 0, and a block inside of it.
            2.0 * (40.5 - 12.5 + 0.5),
            2,
        ),
        (
            "linear_extrude(height = 1) polygon(points = [[0, 0], [2, 0], [0, 2]], paths = undef, convexity = 1);",
            2.0,
            2,
        ),
        // In the plane: mirrored, scaled, stretched; and all of it stretched.
        (
            "linear_extrude(height = 1) multmatrix([[-2, 0, 0, 5], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]) circle(r = 1);",
            4.0 * PI,
            2,
        ),
        (
            "linear_extrude(height = 1) multmatrix([[2, 1, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) \
             { circle(r = 1); square([1, 0.5], center = true); }",
            2.0 * PI,
            2,
        ),
        (
            "multmatrix([[0, 0, 3, 1], [2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) linear_extrude(height = 1) circle(r = 1);",
            6.0 * PI,
            2,
        ),
        (
            "rotate_extrude(angle = 360, convexity = 2) multmatrix([[1,0,0,3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) circle(r = 1);",
            6.0 * PI * PI,
            0,
        ),
        // The other side of the axis is as good.
        ("rotate_extrude() multmatrix([[1,0,0,-3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) circle(r = 1);", 6.0 * PI * PI, 0),
        (
            "multmatrix([[2,0,0,0],[0,2,0,0],[0,0,3,0],[0,0,0,1]]) rotate_extrude() polygon([[1, 0], [2, 0], [2, 1], [1, 1]]);",
            12.0 * 3.0 * PI,
            0,
        ),
        // A wedge and an octahedron, whose faces are clockwise seen from outside.
        (
            "polyhedron(points = [[0,0,0],[2,0,0],[2,1,0],[0,1,0],[0,0,1],[0,1,1]], \
             faces = [[0,1,2,3],[0,3,5,4],[4,5,2,1],[0,4,1],[3,2,5]], convexity = 1);",
            1.0,
            2,
        ),
        (
            "multmatrix([[1,0.5,0,0],[0,1,0,0],[0,0,2,0],[0,0,0,1]]) polyhedron(points = [[1,0,0],[-1,0,0],[0,1,0],[0,-1,0],[0,0,1],[0,0,-1]], \
             faces = [[0,4,2],[2,4,1],[1,4,3],[3,4,0],[2,5,0],[1,5,2],[3,5,1],[0,5,3]]);",
            8.0 / 3.0,
            2,
        ),
    ] {
        println!("{text}");
        right(&csg(text), volume, euler);
    }
}

#[test]
fn faces_of_trees_are_named_in_order() {
    let m = right(
        &csg(
            "linear_extrude(height = 3) { difference() { square([4, 4]); multmatrix([[1,0,0,2],[0,1,0,2],[0,0,1,0],[0,0,0,1]]) circle(r = 1); } }\n\
              multmatrix([[1,0,0,9],[0,1,0,0],[0,0,1,0],[0,0,0,1]]) linear_extrude(height = 1) circle(r = 1);",
        ),
        3.0 * (16.0 - PI) + PI,
        2,
    );
    faces(
        &m,
        &[
            "square1.xmin",
            "square1.xmax",
            "square1.ymin",
            "square1.ymax",
            "circle1",
            "extrude1.bottom",
            "extrude1.top",
            "circle2",
            "circle2.bottom",
            "circle2.top",
        ],
    );
    let least = m.mesh.nodes.iter().fold(f64::INFINITY, |least, p| least.min(p.z));
    assert_abs_diff_eq!(least, 0.0, epsilon = 1e-12);
}

#[test]
fn what_trees_may_not_raise_is_refused_with_its_place() {
    for (text, column, says) in [
        ("circle(r = 1);", 1, "circle() is a plane figure, where solids should stand"),
        ("linear_extrude(height = 1) cube(1);", 28, "cube() is a solid, where plane figures should stand"),
        ("linear_extrude(height = 1) rotate_extrude() circle(1);", 28, "rotate_extrude() is a solid"),
        ("linear_extrude(height = 1, twist = 90) circle(1);", 36, "with a twist cannot be read"),
        ("linear_extrude(height = 1, scale = [2, 1]) circle(1);", 36, "with a scale other than 1"),
        ("linear_extrude(height = 0) circle(1);", 25, "\"height\" must be positive"),
        ("linear_extrude(height = 1) text(\"a\");", 28, "text() cannot be read"),
        ("linear_extrude(height = 1) square([1, 2, 3]);", 35, "the size of a square is a number or two of them"),
        ("linear_extrude(height = 1) polygon([[0, 0], [1, 1], [1, 0], [0, 1]]);", 36, "touch or cross"),
        (
            "linear_extrude(height = 1) polygon([[0, 0], [1, 0], [0, 1]], [[0, 1, 3]]);",
            62,
            "numbers of points, from 0 to 2",
        ),
        (
            "linear_extrude(1) multmatrix([[1,0,0,0],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]) circle(1);",
            19,
            "out of their plane",
        ),
        ("rotate_extrude(angle = 90) circle(1);", 24, "by 90 degrees cannot be read"),
        ("rotate_extrude($fn = 6) circle(1);", 22, "with 6 flat sides"),
        ("multmatrix([[1,0,0,0],[0,2,0,0],[0,0,1,0],[0,0,0,1]]) rotate_extrude() circle(1);", 55, "cannot be read"),
        ("polyhedron([[0,0,0],[1,0,0],[0,1,0],[0,0,1]], [[0,1,2],[0,3,1],[0,2,3]]);", 47, "four faces"),
        ("polyhedron([[0,0,0],[1,0,0],[0,1,0],[0,0,1]], [[0,1,2],[0,3,1],[0,2,3],[1,2,3]]);", 47, "open"),
        // Counter-clockwise seen from outside.
        ("polyhedron([[0,0,0],[1,0,0],[0,1,0],[0,0,1]], [[0,2,1],[0,1,3],[0,3,2],[1,2,3]]);", 12, "inside out"),
    ] {
        match parse_csg(text) {
            Err(Error::Input { place: Place::Text { line: 1, column: c, .. }, message, .. }) => {
                assert!(c == column && message.contains(says), "{text}: column {c}: {message}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
}
