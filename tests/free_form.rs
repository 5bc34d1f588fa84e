//! Curves and sheets of free form that part files name: lengths, areas and volumes known in closed form, meshes, STEP, and
//! what is refused.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use approx::assert_abs_diff_eq;
use rvachev::implicit::part::parse;
use rvachev::parametric::Surface;
use rvachev::parametric::basis::Knots;
use rvachev::parametric::brep::Brep;
use rvachev::pipeline::{BrepInfo, MeshOptions, Meshed, brep_info, build, load_step, mesh_part, save_step};
use rvachev::{Error, Run};

fn built(text: &str) -> Brep {
    let part = parse(text, &[]).unwrap_or_else(|e| panic!("{text}{e}"));
    build(&part, &Run::new()).unwrap_or_else(|e| panic!("{text}{e}")).unwrap()
}

fn told(b: Brep) -> BrepInfo {
    brep_info(b.into(), None, &Run::new()).unwrap()
}

#[track_caller]
fn near(found: f64, truth: f64, share: f64) {
    assert_abs_diff_eq!(found, truth, epsilon = share * truth);
}

/// The area of all faces.
fn area(i: &BrepInfo) -> f64 {
    i.faces.iter().filter_map(|f| f.area).sum()
}

fn meshed(text: &str) -> Meshed {
    let made = mesh_part(&parse(text, &[]).unwrap(), &MeshOptions::default(), &Run::new()).unwrap();
    assert!(made.report.shortfalls.is_empty(), "{text}{:?}", made.report.shortfalls);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{text}{:?}", check.certificate.faults);
    made
}

/// Written as STEP and read back, it has the same faces, areas and volumes.
fn there_and_back(b: &Brep) {
    let dir = tempfile::TempDir::new().unwrap();
    let path = dir.path().join("a.step");
    save_step(&path, b, None).unwrap();
    let back = load_step(&path, &Run::new()).unwrap();
    assert!(back.notes.is_empty(), "{:?}", back.notes);
    let (i, j) = (told(b.clone()), told(back.brep));
    assert_eq!(i.faces.len(), j.faces.len());
    near(area(&j), area(&i), 1e-6);
    for (x, y) in i.bodies.iter().zip(&j.bodies) {
        assert_eq!(x.solid, y.solid);
        if let (Some(v), Some(w)) = (x.volume, y.volume) {
            near(w, v, 1e-6);
        }
    }
}

/// A solid by its part file: closed, of the volume given, meshed, and written as STEP.
#[track_caller]
fn solid(text: &str, volume: f64) {
    let b = built(text);
    let i = told(b.clone());
    assert!(i.bodies.len() == 1 && i.bodies[0].solid, "{text}");
    near(i.bodies[0].volume.unwrap_or_else(|| panic!("{text}")), volume, 1e-6);
    there_and_back(&b);
    near(meshed(text).mesh.volume(), volume, 0.02);
}

#[test]
fn curves_have_their_lengths() {
    for (curve, length) in [
        ("parabola(1, 0, 2)", 2f64.sqrt() + 1f64.asinh()),
        ("parabola(1, 2, 0, at=(3, 4), axis=\"x\", x=\"z\")", 2f64.sqrt() + 1f64.asinh()),
        ("conic((1, 0, 1, -2, 0, -3), (3, 0), (1, 2))", PI),
        ("conic((1, 0, 1, -2, 0, -3), (1, 2), (3, 0))", 3.0 * PI),
        ("conic((4, 0, 4, 0, 0, -1))", PI),
        ("polynomial([(1, 0, 0), (0, 3, 0), (4, 0, 0)], 0, 1)", 0.0),
        ("lagrange([(0, 0), (3, 4), (6, 8)])", 10.0),
        ("nurbs([(0, 0), (3, 4), (3, 0)], degree=1)", 9.0),
        ("spline([(0, 0), (3, 4)], ends=\"parabolic\")", 5.0),
    ] {
        // x = 1 + 4 t^2, y = 3 t: a parabola with the focal length 9/16, over y from 0 to 3.
        let s: f64 = 3.0 / (2.0 * 0.5625);
        let length = if length > 0.0 { length } else { 0.5625 * (s * s.hypot(1.0) + s.asinh()) };
        let direction = if curve.contains("axis") { "x" } else { "z" };
        let b = built(&format!("part(extrude_edges({curve}, \"{direction}\", 1, solid=False))\n"));
        near(area(&told(b)), length, 1e-5);
    }
}

#[test]
fn curves_enclose_their_areas() {
    let t = 1.5f64.asinh();
    for (curve, rest, area) in [
        (
            "hyperbola(2, 1, -1.5, 1.5)",
            "(2 * hypot(1, 1.5), 1.5), (2 * hypot(1, 1.5), -1.5)",
            2.0 * (t.cosh() * t.sinh() - t),
        ),
        ("conic((1, 0, 0, 0, -1, 0), (-1, 1), (1, 1))", "(1, 1), (-1, 1)", 4.0 / 3.0),
        ("conic((0, 1, 0, 0, 0, -1), (1, 1), (2, 0.5))", "(2, 0.5), (2, 0), (1, 0), (1, 1)", LN_2),
        ("conic((1, 0, 4, 0, 0, -4), (2, 0), (0, 1))", "(0, 1), (0, 0), (2, 0)", 0.5 * PI),
        ("polynomial([(0, 0), (1, 0), (0, 1)], 0, 1)", "(1, 1), (1, -1), (0, -1), (0, 0)", 4.0 / 3.0),
        ("lagrange([(0, 0), (1, 1), (2, 4), (3, 9)])", "(3, 9), (3, -1), (0, -1), (0, 0)", 12.0),
        ("lagrange([(0, 0), (1, 1), (3, 9)], parameters=[0, 1, 3])", "(3, 9), (3, -1), (0, -1), (0, 0)", 12.0),
        ("nurbs([(1, 0), (1, 1), (0, 1)], weights=[1, 0.5 ** 0.5, 1], degree=2)", "(0, 1), (0, 0), (1, 0)", 0.25 * PI),
        (
            "nurbs([(0, 0), (0, 2), (4, 2), (4, 0)], knots=[0, 0, 0, 1, 2, 2, 2], degree=2)",
            "(4, 0), (0, 0)",
            20.0 / 3.0,
        ),
        ("spline([(-1, 0), (0, 1), (1, 0)], ends=\"parabolic\")", "(1, 0), (-1, 0)", 4.0 / 3.0),
        // A line that is to pass above its middle is a parabola, and one that is to rise and fall at its ends a cubic.
        ("nurbs([(-1, 0), (0, 0), (1, 0)], degree=2, through=[(0.5, (0, 1))])", "(1, 0), (-1, 0)", 4.0 / 3.0),
        (
            "nurbs([(0, 0), (1, 0), (2, 0), (3, 0)], tangents=[(0, (1, 1)), (1, (2, -2))])",
            "(3, 0), (0, 0)",
            9.0 * FRAC_1_SQRT_2 * (0.2 - FRAC_1_SQRT_2 / 30.0),
        ),
    ] {
        let text = format!("part(extrude_edges(chain([{curve}, polyline([{rest}])]), \"z\", 2))\n");
        solid(&text, 2.0 * area);
    }
}

const WALLS: &str = "def wall(a, b, top):\n    return flat_face(chain([top, polyline([(a[0], a[1], top_z(a)), (a[0], a[1], -1), (b[0], b[1], -1), (b[0], b[1], top_z(b))])]))\n";

/// A unit square at z = -1, walls, and a sheet above.
fn roofed(sheet: &str, top: &str, edges: [&str; 4]) -> String {
    let corners = ["(0, 0)", "(1, 0)", "(1, 1)", "(0, 1)"];
    let walls: Vec<String> =
        (0..4).map(|i| format!("wall({}, {}, {})", corners[i], corners[(i + 1) % 4], edges[i])).collect();
    format!(
        "def top_z(p):\n    return {top}\n{WALLS}floor = flat_face(polyline([(0, 0, -1), (1, 0, -1), (1, 1, -1), (0, 1, -1)], closed=True))\n\
         part(sew([floor, {sheet}, {}]))\n",
        walls.join(", ")
    )
}

#[test]
fn sheets_close_solids_of_known_volume() {
    let line = |a: &str, b: &str| format!("polyline([{a}, {b}])");
    let (south, east) = (line("(0, 0, 0)", "(1, 0, 0)"), line("(1, 0, 0)", "(1, 1, 1)"));
    let (north, west) = (line("(1, 1, 1)", "(0, 1, 0)"), line("(0, 1, 0)", "(0, 0, 0)"));
    // z = x y.
    let bilinear = "bilinear((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1))";
    solid(&roofed(bilinear, "p[0] * p[1]", [&south, &east, &north, &west]), 1.25);
    // z = x^2 + y^2.
    let shift = "shift(polynomial([(0, 0, 0), (1, 0, 0), (0, 0, 1)], 0, 1), polynomial([(0, 0, 0), (0, 1, 0), (0, 0, 1)], 0, 1))";
    let square = [
        "polynomial([(0, 0, 0), (1, 0, 0), (0, 0, 1)], 0, 1)",
        "polynomial([(1, 0, 1), (0, 1, 0), (0, 0, 1)], 0, 1)",
        "polynomial([(0, 1, 1), (1, 0, 0), (0, 0, 1)], 0, 1)",
        "polynomial([(0, 0, 0), (0, 1, 0), (0, 0, 1)], 0, 1)",
    ];
    solid(&roofed(shift, "p[0] ** 2 + p[1] ** 2", square), 5.0 / 3.0);
    // The mean of the control heights.
    let level =
        [line("(0, 0)", "(1, 0)"), line("(1, 0)", "(1, 1)"), line("(1, 1)", "(0, 1)"), line("(0, 1)", "(0, 0)")];
    let level = [&level[0][..], &level[1], &level[2], &level[3]];
    let net = "[[(i / 2, j / 2, 1.8 if i == 1 and j == 1 else 0) for j in range(3)] for i in range(3)]";
    solid(&roofed(&format!("bezier_surface({net})"), "0", level), 1.2);
    // Degree 1: a tent of four bilinear faces with creases between them, each with heights 0, 0, 0 and 1.8 at its corners.
    let halves = [
        "(0, 0), (0.5, 0), (1, 0)",
        "(1, 0), (1, 0.5), (1, 1)",
        "(1, 1), (0.5, 1), (0, 1)",
        "(0, 1), (0, 0.5), (0, 0)",
    ];
    let halves = halves.map(|p| format!("polyline([{p}])"));
    let halves = [&halves[0][..], &halves[1], &halves[2], &halves[3]];
    let text = roofed(&format!("nurbs_surface({net}, degree_u=1, degree_v=1)"), "0", halves);
    assert_eq!(built(&text).faces.len(), 9);
    solid(&text, 1.0 + 1.8 / 4.0);
}

#[test]
fn sheets_over_curves_close_solids_of_known_volume() {
    solid("part(sew([sectorial(circle(2), (0, 0, 4)), flat_face(circle(2))]))\n", 16.0 * PI / 3.0);
    // An eighth of a ball: a pole, and arcs.
    let ball = "w = 0.5 ** 0.5\nc = [(1, 0), (1, 1), (0, 1)]\nv = [1, w, 1]\n\
        net = [[(c[i][0] * c[j][0], c[i][1] * c[j][0], c[j][1]) for j in range(3)] for i in range(3)]\n\
        weights = [[v[i] * v[j] for j in range(3)] for i in range(3)]\n\
        x = flat_face(chain([arc((0, 1, 0), (0, w, w), (0, 0, 1)), polyline([(0, 0, 1), (0, 0, 0), (0, 1, 0)])]))\n\
        y = flat_face(chain([arc((1, 0, 0), (w, 0, w), (0, 0, 1)), polyline([(0, 0, 1), (0, 0, 0), (1, 0, 0)])]))\n\
        z = flat_face(chain([arc((1, 0, 0), (w, w, 0), (0, 1, 0)), polyline([(0, 1, 0), (0, 0, 0), (1, 0, 0)])]))\n";
    solid(&format!("{ball}part(sew([bezier_surface(net, weights), x, y, z]))\n"), PI / 6.0);
    let knots = "knots_u=[0, 0, 0, 2, 2, 2], knots_v=[1, 1, 1, 2, 2, 2]";
    solid(&format!("{ball}part(sew([nurbs_surface(net, {knots}, weights=weights), x, y, z]))\n"), PI / 6.0);
    // z = 2 v - v^2 over x = v.
    let side = |y: &str| {
        format!(
            "flat_face(chain([lagrange([(0, {y}, 0), (1, {y}, 1), (2, {y}, 0)]), polyline([(2, {y}, 0), (0, {y}, 0)])]))"
        )
    };
    let floor = "flat_face(polyline([(0, 0), (2, 0), (2, 1), (0, 1)], closed=True))";
    let rows = "[polyline([(x, 0, h), (x, 1, h)]) for x, h in [(0, 0), (1, 1), (2, 0)]]";
    solid(&format!("part(sew([hermite({rows}), {floor}, {}, {}]))\n", side("0"), side("1")), 4.0 / 3.0);
    // Radii 1, 2, 1 by a quadratic.
    let circles = "[circle(r, at=(0, 0, z)) for r, z in [(1, 0), (2, 1), (1, 2)]]";
    let lids = "flat_face(circle(1)), flat_face(circle(1, at=(0, 0, 2)))";
    solid(&format!("part(sew([spline_surface({circles}, degree=2), {lids}]))\n"), 3.6 * PI);
    // A round corner: what lies between it and its planes.
    let ends: Vec<String> = ["0", "3"]
        .iter()
        .map(|z| format!("flat_face(chain([arc((1, 0, {z}), (1 - 0.5 ** 0.5, 1 - 0.5 ** 0.5, {z}), (0, 1, {z})), polyline([(0, 1, {z}), (0, 0, {z}), (1, 0, {z})])]))"))
        .collect();
    let lines = ["(1, 0, ", "(0, 0, ", "(0, 1, "].map(|p| format!("polyline([{p}0), {p}3)])"));
    let legs = format!("ruled({}, {}), ruled({}, {})", lines[0], lines[1], lines[1], lines[2]);
    let fillet = format!("fillet_surface({}, {}, {})", lines[0], lines[1], lines[2]);
    let text = format!("part(sew([{fillet}, {legs}, {}, {}]))\n", ends[0], ends[1]);
    assert!(matches!(built(&text).faces[0].surface, Surface::Nurbs(_)));
    solid(&text, 3.0 * (1.0 - 0.25 * PI));
}

/// Surfaces without an exact NURBS form are meshed as they are, and refused as STEP; closed ones have seams.
#[test]
fn sheets_that_are_no_nurbs_and_closed_ones_mesh() {
    let edge = |side: f64| {
        let at = |x: f64, angle: f64, r: f64| format!("({x}, {}, {})", r * angle.cos(), side * r * angle.sin());
        format!("polyline([{}, {}])", at(0.0, 0.6, 1.0), at(2.0, 0.9, 1.5))
    };
    let opening = &format!("part(fillet_surface({}, polyline([(0, 0, 0), (2, 0, 0)]), {}))\n", edge(1.0), edge(-1.0));
    let b = built(opening);
    assert!(matches!(b.faces[0].surface, Surface::Family(_)));
    let whole = area(&told(b.clone()));
    let dir = tempfile::TempDir::new().unwrap();
    let e = save_step(&dir.path().join("a.step"), &b, None).unwrap_err().to_string();
    assert!(e.contains("no exact NURBS"), "{e}");
    near(meshed(opening).mesh.area(), whole, 0.02);
    let arcs = "part(hermite([arc((1, 0, 0), (0, 1, 0), (-1, 0, 0)), arc((0.8, 0.6, 1), (0, 1, 1), (-0.8, 0.6, 1)), arc((1, 0, 2), (0, 1, 2), (-1, 0, 2))]))\n";
    let whole = area(&told(built(arcs)));
    near(meshed(arcs).mesh.area(), whole, 0.02);
    let ring = "part(hermite([circle(1, at=(3 * cos(t), 3 * sin(t), 0), axis=(-sin(t), cos(t), 0)) for t in [k * pi / 4 for k in range(8)]], closed=True))\n";
    let i = told(built(ring));
    near(area(&i), 12.0 * PI * PI, 0.02);
    near(meshed(ring).mesh.volume(), 6.0 * PI * PI, 0.05);
}

#[test]
fn what_cannot_be_built_is_told_with_its_place() {
    for (text, says) in [
        ("parabola(1, 2, 2)", "the arc starts and ends at one place"),
        ("parabola(0, 0, 2)", "\"focal\" of parabola() must be positive"),
        ("hyperbola(1, -1, 0, 2)", "\"b\" of hyperbola() must be positive"),
        ("conic((1, 0, -1, 0, 0, -1), (2, 3 ** 0.5), (-2, 3 ** 0.5))", "different branches"),
        ("conic((1, 0, -1, 0, 0, 0), (1, 1), (2, 2))", "lines or of a point"),
        ("conic((1, 0, 1), (1, 1), (2, 2))", "six numbers"),
        ("conic((1, 0, 1, 0, 0, -1), (1, 0))", "both a start and an end"),
        ("conic((1, 0, 0, 0, -1, 0))", "not closed"),
        ("polynomial([(1, 2)], 0, 1)", "from 2 to 26 coefficients"),
        ("polynomial([(1, 2), (2, 3)], 1, 0)", "must rise"),
        ("lagrange([(1, 2), (1, 2), (3, 4)])", "points 1 and 2 of the polynomial coincide"),
        ("lagrange([(1, 2), (3, 4)], parameters=[1, 1])", "ascending numbers"),
        ("nurbs([(0, 0), (1, 0), (1, 1)], weights=[1, 0, 1])", "weights are positive numbers, one for each of 3"),
        ("nurbs([(0, 0), (1, 0), (1, 1)], knots=[0, 1])", "\"knots\" must be 6 numbers"),
        ("nurbs([(0, 0), (1, 0), (1, 1)], degree=3)", "below the number of control points, 3"),
        ("nurbs([(0, 0), (1, 0), (1, 1)], through=[(2, (0, 1))])", "the curve has no parameter 2"),
        ("nurbs([(0, 0), (1, 0), (1, 1)], tangents=[(0, 1)])", "\"tangents\" must be a list of pairs"),
        ("nurbs([(0, 0), (1, 1)], through=[(0.5, (0, 1))])", "2 control points do not allow"),
        ("nurbs([(0, 0), (1, 0), (2, 1), (3, 0)], degree=1, knots=[0, 0, 1, 1, 2, 2])", "comes 2 times"),
        ("spline([(0, 0), (1, 0), (2, 1)], start=(1, 0, 0), end=(0, 1, 0), ends=\"parabolic\")", "without derivatives"),
    ] {
        refused(&format!("part(extrude_edges({text}, \"z\", 1, solid=False))\n"), says);
    }
    let line = "polyline([(0, 0), (1, 0)])";
    for (text, says) in [
        ("bilinear((0, 0), (1, 0), (0, 0), (1, 1))".into(), "\"p00\" and \"p01\" are one point"),
        ("bilinear((0, 0), (1, 0), (0, 1))".into(), "needs \"p11\""),
        ("bezier_surface([[(0, 0), (1, 0)], [(0, 1)]])".into(), "\"net\" must be two rows"),
        ("bezier_surface([[(0, 0), (1, 0)], [(0, 1), (1, 1)]], [[1, 1], [1, 0]])".into(), "rows of positive numbers"),
        ("bezier_surface([[(0, 0), (1, 0)], [(2, 0), (3, 0)]])".into(), "no area"),
        (format!("shift({line}, {line})"), "no area"),
        (format!("hermite([{line}])"), "2 chains of edges or more"),
        (format!("hermite([{line}, polyline([(0, 1), (1, 1), (2, 1)])])"), "chain 2 has other edges"),
        (format!("spline_surface([{line}, {line}], degree=2)"), "\"degree\" must be a whole number"),
        (
            format!("fillet_surface({line}, polyline([(0, 1), (1, 1)]), polyline([(0, 3), (1, 3)]))"),
            "must be of one length",
        ),
        (format!("sectorial({line}, (2, 0))"), "along one line"),
        ("bilinear((0, 0), (1, 0), (2, 0), (3, 0))".into(), "along one line"),
        (format!("sectorial({line}, 3)"), "\"point\" of sectorial()"),
    ] {
        refused(&format!("part({text})\n"), says);
    }
}

#[track_caller]
fn refused(text: &str, says: &str) {
    let Err(e) = parse(text, &[]).and_then(|p| build(&p, &Run::new())) else { panic!("{text} is built") };
    let told = e.to_string();
    assert!(matches!(e, Error::Input { .. }) && told.contains(says) && told.contains("line 1"), "{text}{told}");
}

/// Against Simpson's rule on many parts of every span, which is exact for cubics and near enough for the others.
#[test]
fn integrals_of_splines_are_sums_of_control_points() {
    const PARTS: usize = 200;
    for (degree, inner) in [(1, vec![0.3, 0.7]), (2, vec![0.5, 0.5]), (3, vec![0.1, 0.4, 0.9]), (5, vec![0.25])] {
        let ends = |v: f64| std::iter::repeat_n(v, degree + 1);
        let points = degree + 1 + inner.len();
        let knots = Knots::new(degree, ends(0.0).chain(inner).chain(ends(1.0)).collect(), points).unwrap();
        let mut sums = vec![0.0; points];
        for w in knots.breaks().windows(2) {
            let h = (w[1] - w[0]) / PARTS as f64;
            let nodes = (0..PARTS).flat_map(|i| [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)].map(|(s, k)| (i as f64 + s, k)));
            for (at, weight) in nodes {
                // Just inside, as functions of degree 1 have kinks at knots, and spans are open at their ends.
                let t = (w[0] + at * h).clamp(w[0], w[1] - 1e-13);
                let (span, values) = knots.values_at::<8>(t);
                for (i, v) in values[..=degree].iter().enumerate() {
                    sums[span - degree + i] += weight / 6.0 * h * v;
                }
            }
        }
        let told = knots.integrals();
        assert_eq!(told.len(), points);
        assert!(told.iter().zip(&sums).all(|(a, b)| (a - b).abs() < 1e-9), "{degree}: {told:?} {sums:?}");
        assert_abs_diff_eq!(told.iter().sum::<f64>(), 1.0, epsilon = 1e-12);
    }
}
