//! Plane figures against closed forms: corners, areas, lengths, and what files hold of them.

use std::f64::consts::PI;
use std::fs;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use assert_cmd::Command;
use predicates::str::contains;
use rvachev::io::{Format, WriteOptions, encode, read_bytes};
use rvachev::pipeline::{FigureReport, MeshOptions, Meshed, SizeRequest, mesh_part, parse_part};
use rvachev::{Error, Place, Run};
use std::path::Path;
use tempfile::TempDir;

/// Reads and meshes a part file's text.
fn meshed(text: &str, size: f64) -> Meshed {
    let part = parse_part(Path::new("a.py"), text, &[]).unwrap();
    let how = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let made = mesh_part(&part, &how, &Run::new()).unwrap();
    assert_eq!(made.report.shortfalls, [], "{text}");
    looks_right(&made);
    made
}

fn figure(made: &Meshed) -> &FigureReport {
    made.report.figure.as_ref().unwrap()
}

/// What holds for every figure: it is flat, faces up, its triangles fill its polylines, and these are its open edges.
fn looks_right(made: &Meshed) {
    let (mesh, found) = (&made.mesh, figure(made));
    assert!(mesh.nodes.iter().all(|p| p.z == 0.0));
    assert!((0..mesh.triangles.len()).all(|t| mesh.area_vector(t).z > 0.0));
    assert_relative_eq!(mesh.area(), found.area, epsilon = 0.0, max_relative = 1e-12);
    let outline = made.outline.as_ref().unwrap();
    assert_eq!(outline.contours.len(), found.contours);
    let mut edges: Vec<[u32; 2]> =
        outline.contours.iter().flat_map(|c| c.edges()).map(|([a, b], _)| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    let mut open = mesh.defects().open_edges;
    open.sort_unstable();
    assert_eq!(edges, open);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.manifold && check.oriented && check.self_intersections == 0 && check.certificate.open);
}

/// Asserts that the corners are these points, to 1e-12.
fn corners(made: &Meshed, expected: &[[f64; 2]]) {
    let found = &figure(made).corners;
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for e in expected {
        let near = found.iter().map(|c| (c[0] - e[0]).hypot(c[1] - e[1])).fold(f64::INFINITY, f64::min);
        assert!(near < 1e-12, "{e:?} is {near:e} away from {found:?}");
    }
}

/// Asserts area and perimeter: `round` is the length of what is curved, `least` the smallest radius.
fn measures(made: &Meshed, area: f64, perimeter: f64, round: f64, least: f64) {
    let f = figure(made);
    assert!(f.distance < made.report.size / 50.0, "{}", f.distance);
    let (a, p) = (round * f.distance + 1e-11 * area, round * f.distance / least + 1e-11 * perimeter);
    assert!(abs_diff_eq!(f.area, area, epsilon = a), "area {} is not {area} within {a}", f.area);
    assert!(f.perimeter <= perimeter * (1.0 + 1e-12), "{} {perimeter}", f.perimeter);
    assert!(f.perimeter >= perimeter - p, "perimeter {} is not {perimeter} within {p}", f.perimeter);
}

const PLATE: &str = "
units('mm')
hole = circle(0.5)
plate = rectangle(size=(4, 3), at=(1, 2)).name('plate')
part(region(plate - hole.move((0, 2)).name('left') - hole.move((2.2, 2.1, 0)).name('right')))
group('held', faces('left', 'right'))
";

#[test]
fn a_rectangle_with_round_holes() {
    let made = meshed(PLATE, 0.2);
    corners(&made, &[[-1.0, 0.5], [3.0, 0.5], [3.0, 3.5], [-1.0, 3.5]]);
    measures(&made, 12.0 - 0.5 * PI, 14.0 + 2.0 * PI, 2.0 * PI, 0.5);
    let f = figure(&made);
    assert_eq!((f.contours, f.holes), (3, 2));
    let names: Vec<&str> = f.borders.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax", "left", "right"]);
    for (border, length) in f.borders.iter().zip([3.0, 3.0, 4.0, 4.0]) {
        assert!(abs_diff_eq!(border.length, length, epsilon = 1e-12), "{border:?}");
    }
}

#[test]
fn a_circle_less_a_circle() {
    let made = meshed("part(region(circle(2) - circle(1.5, at=(1.6, 1.2))))", 0.15);
    // The circles' centers are 2 apart; along that line they meet at a, aside of it by h.
    let (r, s, d): (f64, f64, f64) = (2.0, 1.5, 2.0);
    let a = (d * d + r * r - s * s) / (2.0 * d);
    let h = (r * r - a * a).sqrt();
    corners(&made, &[[0.8 * a - 0.6 * h, 0.6 * a + 0.8 * h], [0.8 * a + 0.6 * h, 0.6 * a - 0.8 * h]]);
    let (big, small) = ((a / r).acos(), ((d - a) / s).acos());
    let lens = r * r * (big - big.sin() * big.cos()) + s * s * (small - small.sin() * small.cos());
    let perimeter = 2.0 * r * (PI - big) + 2.0 * s * small;
    measures(&made, PI * r * r - lens, perimeter, perimeter, s);
    assert_eq!(figure(&made).contours, 1);
}

#[test]
fn a_polygon_is_exact() {
    let text = "part(region(polygon([(0, 0), (3, 0), (3, 1), (1, 1), (1.5, 2.5), (0, 2)]).rotate(0)))";
    let made = meshed(text, 0.25);
    corners(&made, &[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.5, 2.5], [0.0, 2.0]]);
    let sides = 3.0 + 1.0 + 2.0 + 0.5_f64.hypot(1.5) + 1.5_f64.hypot(0.5) + 2.0;
    let f = figure(&made);
    assert_abs_diff_eq!(f.area, 4.5, epsilon = 1e-11);
    assert_abs_diff_eq!(f.perimeter, sides, epsilon = 1e-11);
    assert!(f.distance < 1e-12);
}

#[test]
fn one_formula_keeps_its_corners() {
    let made = meshed("f = 1 - x**2\ng = 0.25 - y**2\npart(region(f + g - sqrt(f**2 + g**2)))", 0.1);
    corners(&made, &[[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]]);
    let f = figure(&made);
    assert_abs_diff_eq!(f.area, 2.0, epsilon = 1e-11);
    assert_abs_diff_eq!(f.perimeter, 6.0, epsilon = 1e-11);
}

#[test]
fn an_annulus_has_two_contours_and_no_corner() {
    let made = meshed("part(region(x**2 + y**2 <= 1) - circle(0.5))", 0.08);
    corners(&made, &[]);
    measures(&made, 0.75 * PI, 3.0 * PI, 3.0 * PI, 0.5);
    let f = figure(&made);
    assert_eq!((f.contours, f.holes), (2, 1));
    let outline = made.outline.as_ref().unwrap();
    for (c, r) in outline.contours.iter().zip([1.0, 0.5]) {
        assert!(c.nodes.iter().all(|v| (made.mesh.nodes[*v as usize].length() - r).abs() < 1e-12));
    }
}

#[test]
fn an_ellipse_turned() {
    let made = meshed("part(region(ellipse(2, 1).rotate(30).move((1, 0))))", 0.15);
    let f = figure(&made);
    assert!(abs_diff_eq!(f.area, 2.0 * PI, epsilon = 10.0 * f.distance), "{f}");
    let (s, c) = 30_f64.to_radians().sin_cos();
    for v in &made.outline.as_ref().unwrap().contours[0].nodes {
        let p = made.mesh.nodes[*v as usize];
        let (x, y) = (p.x - 1.0, p.y);
        let on = ((c * x + s * y) / 2.0).powi(2) + (c * y - s * x).powi(2);
        assert!(abs_diff_eq!(on, 1.0, epsilon = 1e-12), "{p} {on}");
    }
}

/// The slab that a figure is meshed as shows in nothing: edges of a bare square are as long as was asked for.
#[test]
fn sizes_are_those_asked_for() {
    let size = 0.1;
    let made = meshed("part(rectangle(size=(2, 2)))", size);
    for ([a, b], _) in made.outline.as_ref().unwrap().contours.iter().flat_map(|c| c.edges()) {
        let length = made.mesh.nodes[a as usize].distance(made.mesh.nodes[b as usize]);
        assert!((0.7 * size..1.3 * size).contains(&length), "{length}");
    }
    let even = 4.0 / (3_f64.sqrt() / 4.0 * size * size);
    let triangles = made.mesh.triangles.len() as f64;
    assert!((0.8 * even..1.3 * even).contains(&triangles), "{triangles} {even}");
}

/// A domain cuts a figure off that goes on without end.
#[test]
fn a_strip_in_a_domain() {
    let made = meshed("part(region(abs(y) <= 0.5), domain=((-1, -2), (3, 2)))", 0.2);
    corners(&made, &[[-1.0, -0.5], [3.0, -0.5], [3.0, 0.5], [-1.0, 0.5]]);
    assert_abs_diff_eq!(figure(&made).area, 4.0, epsilon = 1e-11);
}

/// Points of each subpath of a path's data, which has absolute M, L and Z alone.
fn subpaths(data: &str) -> Vec<Vec<[f64; 2]>> {
    let mut all: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut words = data.split_whitespace();
    while let Some(word) = words.next() {
        if word == "Z" {
            continue;
        }
        if word == "M" {
            all.push(Vec::new());
        } else {
            assert_eq!(word, "L");
        }
        let point = [words.next().unwrap().parse().unwrap(), words.next().unwrap().parse().unwrap()];
        all.last_mut().unwrap().push(point);
    }
    all
}

/// Elements of an XML text with their attributes; asserts that tags are balanced.
fn elements(text: &str) -> Vec<(String, Vec<(String, String)>)> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let mut rest = text.split_once("?>").unwrap().1;
    while let Some(begin) = rest.find('<') {
        let end = begin + rest[begin..].find('>').unwrap();
        let inside = &rest[begin + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        let (inside, alone) = inside.strip_suffix('/').map_or((inside, false), |i| (i, true));
        let (name, mut tail) = inside.split_once(' ').unwrap();
        let mut attributes = Vec::new();
        while let Some((key, more)) = tail.split_once("=\"") {
            let (value, more) = more.split_once('"').unwrap();
            attributes.push((key.trim().to_string(), value.to_string()));
            tail = more;
        }
        if !alone {
            open.push(name.to_string());
        }
        found.push((name.to_string(), attributes));
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest:?}");
    found
}

fn attribute<'a>(element: &'a (String, Vec<(String, String)>), key: &str) -> Option<&'a str> {
    element.1.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
}

fn even_odd(paths: &[Vec<[f64; 2]>], p: [f64; 2]) -> bool {
    let crosses = |a: [f64; 2], b: [f64; 2]| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    let count =
        |path: &Vec<[f64; 2]>| (0..path.len()).filter(|k| crosses(path[*k], path[(k + 1) % path.len()])).count();
    paths.iter().map(count).sum::<usize>() % 2 == 1
}

fn files_options(made: &Meshed) -> WriteOptions {
    WriteOptions { outline: made.outline.clone(), corners: made.corners.clone(), ..WriteOptions::default() }
}

fn encoded(made: &Meshed, format: Format) -> Vec<u8> {
    let mut out = Vec::new();
    encode(&mut out, &made.merged().unwrap(), format, &files_options(made), &Run::new()).unwrap();
    out
}

#[test]
fn svg_holds_the_polylines() {
    let made = meshed(PLATE, 0.2);
    let text = String::from_utf8(encoded(&made, Format::Svg)).unwrap();
    let all = elements(&text);
    assert!(attribute(&all[0], "width").unwrap().ends_with("mm"));
    let region = all.iter().find(|e| attribute(e, "id") == Some("region")).unwrap();
    assert_eq!(attribute(region, "fill-rule"), Some("evenodd"));
    let paths = subpaths(attribute(region, "d").unwrap());
    assert_eq!(paths.len(), 3);
    let f = figure(&made);
    let shoelace = |path: &Vec<[f64; 2]>| {
        let n = path.len();
        0.5 * (0..n).map(|k| path[k][0] * path[(k + 1) % n][1] - path[(k + 1) % n][0] * path[k][1]).sum::<f64>()
    };
    assert_relative_eq!(paths.iter().map(shoelace).sum::<f64>(), f.area, epsilon = 0.0, max_relative = 1e-12);
    // By the even-odd rule the middles of triangles are inside, those of holes and what is around are not.
    for t in 0..made.mesh.triangles.len() {
        let m = made.mesh.centroid(t);
        assert!(even_odd(&paths, [m.x, m.y]), "{m}");
    }
    for outside in [[0.0, 2.0], [2.2, 2.1], [-1.1, 2.0], [1.0, 3.6]] {
        assert!(!even_odd(&paths, outside), "{outside:?}");
    }
    let named = |name| all.iter().filter(|e| attribute(e, "data-name") == Some(name)).collect::<Vec<_>>();
    for name in ["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax", "left", "right"] {
        assert_eq!(named(name).len(), 1, "{name}");
    }
    assert_eq!(attribute(named("left")[0], "data-groups"), Some("held"));
    assert_eq!(subpaths(attribute(named("plate.xmin")[0], "d").unwrap())[0].last(), Some(&[-1.0, 0.5]));
}

#[test]
fn msh_names_curves_and_reads_back() {
    let made = meshed(PLATE, 0.2);
    for old_msh in [false, true] {
        let options = WriteOptions { old_msh, ..files_options(&made) };
        let mut out = Vec::new();
        encode(&mut out, &made.merged().unwrap(), Format::Msh, &options, &Run::new()).unwrap();
        let text = String::from_utf8(out).unwrap();
        for name in ["1 1 \"", "\"plate.xmin\"", "\"plate.ymax\"", "\"held\"", "2 1 \"region\""] {
            assert!(text.contains(name), "{name}");
        }
        assert!(!text.contains("\"left\"") && !text.contains("region|"));
        let back = read_bytes(text.as_bytes(), Format::Msh, Path::new("a.msh")).unwrap();
        assert_eq!((back.nodes, back.triangles), (made.mesh.nodes.clone(), made.mesh.triangles.clone()));
    }
}

#[test]
fn su2_is_of_two_dimensions() {
    let made = meshed(PLATE, 0.2);
    let text = String::from_utf8(encoded(&made, Format::Su2)).unwrap();
    assert!(text.starts_with(&format!("NDIME= 2\nNELEM= {}\n", made.mesh.triangles.len())));
    let mut marked = 0;
    for line in text.lines().filter_map(|l| l.strip_prefix("MARKER_ELEMS= ")) {
        marked += line.parse::<usize>().unwrap();
    }
    assert_eq!(marked, made.outline.as_ref().unwrap().contours.iter().map(|c| c.nodes.len()).sum::<usize>());
    assert!(text.contains("MARKER_TAG= held\n") && text.contains("MARKER_TAG= plate_xmin\n"));
}

/// What depends on z is an error where it is said.
#[test]
fn figures_are_of_x_and_y_alone() {
    for (text, line, column, what) in [
        ("part(region(x + y + z))", 1, 13, "a formula"),
        ("a = circle(2)\npart(region(a - sphere(1)))", 2, 13, "a sphere"),
        ("part(region(box(size=(1, 1, 1))))", 1, 13, "a box"),
        ("part(region(cylinder(1, axis='x')))", 1, 13, "axis is not z"),
        ("part(region(circle(1)).rotate(90, 'x'))", 1, 6, "out of its plane"),
        ("part(region(3))", 1, 13, "not made of a number"),
        ("part([region(circle(1)), circle(2)])", 1, 6, "not of a plane figure"),
    ] {
        match parse_part(Path::new("a.py"), text, &[]) {
            Err(Error::Input { place: Place::Text { line: l, column: c, .. }, message, .. }) => {
                assert!(message.contains(what), "{text}: {message}");
                assert_eq!((l, c), (line, column), "{text}: {message}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    // Turned back into the plane a cylinder is as good as any.
    let made = meshed("part(region(cylinder(1, axis='x').rotate(90, 'y')))", 0.2);
    assert_abs_diff_eq!(figure(&made).area, PI, epsilon = 0.05);
}

fn rvachev(dir: &TempDir, arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("rvachev").unwrap().current_dir(dir).args(arguments).assert()
}

#[test]
fn the_command_writes_figures_and_refuses_what_is_for_solids() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("a.py"), PLATE).unwrap();
    fs::write(dir.path().join("b.py"), "part(box(size=(1, 1, 1)))").unwrap();
    let all = ["mesh", "a.py", "--size", "0.3", "-o", "a.svg", "-o", "a.vtu", "-o", "a.msh", "--png", "a.png"];
    rvachev(&dir, &all).success().stdout(contains("3 closed polylines, 2 of them holes; 4 corners"));
    let png = fs::read(dir.path().join("a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    rvachev(&dir, &["render", "a.msh", "-o", "b.png"]).success();
    rvachev(&dir, &["info", "a.py"]).success().stdout(contains("box from [-1.0, 0.5, 0.0] to [3.0, 3.5, 0.0]"));
    rvachev(&dir, &["mesh", "b.py", "-o", "b.svg"]).code(2).stderr(contains("SVG"));
    rvachev(&dir, &["mesh", "a.py", "-o", "b.off", "--method", "cut"]).code(2);
    for arguments in
        [&["compare", "a.py"][..], &["convert", "a.py", "-o", "a.vm"], &["check", "a.msh", "--against", "a.py"]]
    {
        rvachev(&dir, arguments).code(3).stderr(contains("plane figure"));
    }
    // Opened by itself a flat mesh is an open one.
    rvachev(&dir, &["check", "a.msh"]).code(1);
    assert!(!dir.path().join("b.svg").exists() && !dir.path().join("b.off").exists());
}
