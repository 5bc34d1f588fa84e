//! From triangles whose truth is known to meshes: soundness, features to rounding, quality, borders, names.

use std::f64::consts::PI;
use std::path::Path;

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use rvachev::discrete::{Discrete, DiscreteOptions};
use rvachev::geometry::SurfaceOracle;
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{MeshOptions, Meshed, SizeRequest, SoupOptions, compare_soup, load_mesh, mesh_soup, soup_info};
use rvachev::{DVec3, Run};

mod shapes;
use shapes::{l_block, prism, revolved};

fn cylinder(sides: u32) -> TriMesh {
    let corner = |i: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
        [c, s]
    };
    prism(&(0..sides).map(corner).collect::<Vec<_>>(), 2.0)
}

fn meshed(mesh: &TriMesh, size: f64, soup: &SoupOptions, threads: usize) -> Meshed {
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    mesh_soup(mesh, &options, soup, &Run::new().with_threads(threads).unwrap()).unwrap()
}

fn has_node(mesh: &TriMesh, p: DVec3) -> bool {
    mesh.nodes.contains(&p)
}

#[test]
fn an_l_keeps_its_corners_edges_and_faces() {
    let input = l_block(0.5);
    let made = meshed(&input, 0.1, &SoupOptions::default(), 0);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound() && made.report.shortfalls.is_empty(), "{:?}", made.report);
    assert_eq!((made.mesh.faces.len(), check.genus), (8, Some(0)));
    assert!(input.nodes.iter().all(|p| has_node(&made.mesh, *p)));
    // Planes and straight edges: nothing is lost to chords.
    assert_abs_diff_eq!(check.volume.unwrap(), input.volume(), epsilon = 1e-12);
    assert_abs_diff_eq!(check.area, input.area(), epsilon = 1e-12);
    assert!(check.quality.min_angle > 30.0 && check.quality.mean_radius_ratio > 0.97, "{:?}", check.quality);
    let wanted = input.area() / (3f64.sqrt() / 4.0 * 0.01);
    assert_abs_diff_eq!(made.mesh.triangles.len() as f64 / wanted, 1.0, epsilon = 0.15);
    let cut = made.model().unwrap();
    assert_eq!([cut.model.vertices.len(), cut.model.edges.len(), cut.model.faces.len()], [12, 18, 8]);
}

#[test]
fn nodes_on_a_rim_lie_on_its_polygon() {
    let input = cylinder(40);
    let made = meshed(&input, 0.2, &SoupOptions::default(), 0);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert_eq!(made.mesh.faces.len(), 3);
    let cut = made.model().unwrap();
    assert_eq!(cut.model.edges.len(), 2);
    let apothem = (std::f64::consts::PI / 40.0).cos();
    let mut rim = 0;
    for p in made.mesh.nodes.iter().filter(|p| p.z == 2.0 && p.truncate().length() > apothem - 1e-9) {
        let side = (p.y.atan2(p.x) / (std::f64::consts::TAU / 40.0)).floor();
        let (s, c) = ((side + 0.5) * std::f64::consts::TAU / 40.0).sin_cos();
        assert!(abs_diff_eq!(p.x * c + p.y * s, apothem, epsilon = 1e-14), "{p}");
        rim += 1;
    }
    assert!(rim > 25, "{rim}");
    let d = made.report.check.unwrap().deviation.unwrap();
    assert!(d.max < 0.05 * 0.2 * 1.5, "{d:?}");
}

/// A flat square with a round hole of so many sides, open: nothing but the rim itself is round.
fn sheet_with_hole(radius: f64, sides: u32) -> TriMesh {
    let corner = |i: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
        DVec3::new(c, s, 0.0)
    };
    let outer = |p: DVec3| p / p.abs().max_element();
    let nodes = (0..sides).map(|i| radius * corner(i)).chain((0..sides).map(|i| outer(corner(i)))).collect();
    let quad = |i: u32| {
        let j = (i + 1) % sides;
        [[i, sides + i, sides + j], [i, sides + j, j]]
    };
    TriMesh::new(nodes, (0..sides).flat_map(quad).collect())
}

#[test]
fn holes_stay_round_however_few_edges_they_get() {
    for (radius, size) in [(0.3, 0.5), (0.3, 0.35), (0.2, 0.3), (0.12, 0.3), (0.12, 0.2)] {
        let made = meshed(&sheet_with_hole(radius, 72), size, &SoupOptions::default(), 0);
        assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
        let open = made.mesh.defects().open_edges;
        let at = |v: u32| made.mesh.nodes[v as usize];
        let rim: Vec<[u32; 2]> = open.into_iter().filter(|e| at(e[0]).length() < radius + 1e-9).collect();
        // Chords within 7 % of the size, but no edges shorter than a quarter of it.
        let allowed = (0.07f64 * size).max(0.125 * (0.25 * size).powi(2) / radius);
        let off = rim.iter().map(|e| radius - (0.5 * (at(e[0]) + at(e[1]))).length()).fold(0.0, f64::max);
        assert!(off < 1.5 * allowed && rim.len() > 3, "{radius} {size}: {} {off}", rim.len());
    }
}

/// A round cushion: its sides are half circles of radius 1.
fn cushion(sides: u32, steps: u32) -> TriMesh {
    let mut nodes = vec![DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 0.0, 1.0)];
    for k in 0..=steps {
        let (rise, out) = (std::f64::consts::PI * (f64::from(k) / f64::from(steps) - 0.5)).sin_cos();
        for i in 0..sides {
            let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            nodes.push(DVec3::new((5.0 + out) * c, (5.0 + out) * s, rise));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..sides {
        let (a, b) = (2 + i, 2 + (i + 1) % sides);
        triangles.extend([[0, b, a], [1, a + steps * sides, b + steps * sides]]);
        for k in (0..steps).map(|k| k * sides) {
            triangles.extend([[a + k, b + k, b + k + sides], [a + k, b + k + sides, a + k + sides]]);
        }
    }
    TriMesh::new(nodes, triangles)
}

#[test]
fn a_coarse_size_makes_about_as_many_triangles_as_it_says_even_where_much_bends() {
    let input = cushion(96, 24);
    for size in [1.4, 1.2, 1.0] {
        let made = meshed(&input, size, &SoupOptions::default(), 0);
        let check = made.report.check.as_ref().unwrap();
        assert!(check.certificate.is_sound() && made.report.shortfalls.is_empty(), "{:?}", made.report);
        let wanted = input.area() / (0.25 * 3f64.sqrt() * size * size);
        let times = made.mesh.triangles.len() as f64 / wanted;
        // Edges that stay as near as they may would make 1.35 to 1.41 times as many.
        assert!((0.85..1.25).contains(&times), "{size}: {times}");
        // No farther than three times what is allowed where there is room, and half as much again for what triangles do inside.
        assert!(check.deviation.as_ref().unwrap().max < 1.5 * 0.24 * size, "{:?}", check.deviation);
    }
    // Who asks for a tolerance gets edges of their own for it.
    let options = MeshOptions { size: Some(SizeRequest::Length(2.0)), ..MeshOptions::default() };
    let off = |tolerance: Option<SizeRequest>| {
        let options = MeshOptions { tolerance, ..options.clone() };
        let made = mesh_soup(&input, &options, &SoupOptions::default(), &Run::new()).unwrap();
        made.report.check.unwrap().deviation.unwrap().max
    };
    let [loose, near] = [None, Some(SizeRequest::Length(0.05))].map(off);
    assert!(near < 0.5 * loose, "{near} {loose}");
}

#[test]
fn long_facets_of_a_bore_are_not_flipped_through_the_block() {
    // A bore of 16 facets as long as the block is deep, beside a ball's dent in a corner.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/soups/bored_block.off");
    let input = load_mesh(&path, &Run::new()).unwrap();
    let size = 0.02 * input.bounds().diagonal();
    let made = meshed(&input, size, &SoupOptions::default(), 0);
    let check = made.report.check.as_ref().unwrap();
    // Without a look at the surface nearly all triangles would have to stay as they are.
    assert!(check.certificate.is_sound() && made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert_eq!((check.components, check.genus), (1, Some(1)));
    assert_relative_eq!(check.volume.unwrap(), input.volume(), epsilon = 0.0, max_relative = 1e-3);
    assert!(check.quality.min_angle > 20.0 && check.deviation.as_ref().unwrap().max < 0.24 * size, "{check:?}");
}

#[test]
fn walls_and_disks_of_needles_are_meshed_as_well_as_others() {
    // A stepped shaft, exact to 1e-6: needles a thousand times as long as wide on every wall, disk and ring.
    let profile = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.6, 2.0], [0.6, 4.0], [0.8, 4.0], [0.8, 5.0], [0.0, 5.0]];
    let input = revolved(&profile, 2222, false);
    let size = 0.1;
    let made = meshed(&input, size, &SoupOptions::default(), 0);
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound() && made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert_eq!((made.mesh.faces.len(), check.genus, made.report.attempts.len()), (7, Some(0), 1));
    let wanted = input.area() / (3f64.sqrt() / 4.0 * size * size);
    assert!(
        abs_diff_eq!(made.mesh.triangles.len() as f64 / wanted, 1.0, epsilon = 0.15),
        "{}",
        made.mesh.triangles.len()
    );
    assert!(check.quality.min_angle > 30.0 && check.quality.p05_angle > 45.0, "{:?}", check.quality);
    assert!(check.deviation.as_ref().unwrap().max < 0.08 * size, "{:?}", check.deviation);
    assert_relative_eq!(check.volume.unwrap(), input.volume(), epsilon = 0.0, max_relative = 2e-3);
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let soup = SoupOptions::default();
    for input in [l_block(0.5), cylinder(24)] {
        let one = meshed(&input, 0.1, &soup, 1);
        assert_eq!(one.mesh, meshed(&input, 0.1, &soup, 3).mesh);
    }
}

#[test]
fn an_open_surface_keeps_its_border() {
    let mut input = l_block(0.5);
    input.triangles.retain(|t| !t.iter().all(|v| *v >= 6));
    input.labels.truncate(input.triangles.len());
    let made = meshed(&input, 0.1, &SoupOptions::default(), 0);
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert!(made.report.warnings.iter().any(|w| w.contains("open")));
    let check = made.report.check.as_ref().unwrap();
    assert!(!check.closed && check.manifold && check.oriented && check.self_intersections == 0);
    let open = made.mesh.defects().open_edges;
    let length: f64 =
        open.iter().map(|[a, b]| made.mesh.nodes[*a as usize].distance(made.mesh.nodes[*b as usize])).sum();
    // The perimeter of the L, in steps of about the size.
    assert_abs_diff_eq!(length, 6.0, epsilon = 1e-12);
    assert!((55..=65).contains(&open.len()), "{}", open.len());
    assert!(check.quality.min_angle > 25.0, "{:?}", check.quality);
    let closed = meshed(&input, 0.1, &SoupOptions { close: true, ..SoupOptions::default() }, 0);
    assert!(closed.report.check.unwrap().closed);
    assert!(closed.report.warnings.iter().any(|w| w.starts_with("healed")));
}

#[test]
fn small_steps_stay_or_go_as_asked() {
    let input = l_block(0.98);
    let kept = meshed(&input, 0.1, &SoupOptions::default(), 0);
    assert_eq!(kept.mesh.faces.len(), 8);
    assert!(input.nodes.iter().all(|p| has_node(&kept.mesh, *p)));
    assert!(kept.report.check.unwrap().quality.min_angle > 20.0);
    let gone = meshed(&input, 0.1, &SoupOptions { min_length: Some(0.05), ..SoupOptions::default() }, 0);
    assert_eq!(gone.mesh.faces.len(), 7);
    assert!(gone.report.warnings.iter().any(|w| w.starts_with("not kept: face")));
    let least = gone.report.check.unwrap().quality.min_angle;
    assert!(least > 20.0, "{least}");
}

/// A ball with a mouth: a slit around a third of it, `depth` deep and about twice `width` wide, its rims round.
fn mouth(width: f64, depth: f64) -> TriMesh {
    let (around, up) = (120u32, 90u32);
    let mut nodes = vec![-DVec3::Z];
    for j in 1..up {
        let s = 2.0 * f64::from(j) / f64::from(up) - 1.0;
        // Denser where the slit is.
        let latitude = std::f64::consts::FRAC_PI_2 * (0.25 * s + 0.75 * s.powi(3));
        for i in 0..around {
            let longitude = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            let share = 1.0 / (1.0 + ((0.5 - longitude.cos()) / 0.035).exp());
            let r = 1.0 - depth * share * (-(latitude / width).powi(4)).exp();
            let (a, b) = (latitude.cos(), latitude.sin());
            nodes.push(r * DVec3::new(a * longitude.cos(), a * longitude.sin(), b));
        }
    }
    let (top, at) = (nodes.len() as u32, |j: u32, i: u32| 1 + (j - 1) * around + i % around);
    nodes.push(DVec3::Z);
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        triangles.push([top, at(up - 1, i), at(up - 1, i + 1)]);
        for j in 1..up - 1 {
            triangles.push([at(j, i), at(j, i + 1), at(j + 1, i + 1)]);
            triangles.push([at(j, i), at(j + 1, i + 1), at(j + 1, i)]);
        }
    }
    TriMesh::new(nodes, triangles)
}

/// Half as wide as the edges on the ball are long: nodes on both sides see each other, and triangles between them face the
/// right way.
#[test]
fn slits_narrower_than_the_size_are_not_bridged() {
    for (width, depth) in [(0.05, 0.3), (0.05, 0.4)] {
        let input = mouth(width, depth);
        let made = meshed(&input, 0.2, &SoupOptions::default(), 0);
        let check = made.report.check.as_ref().unwrap();
        assert!(check.certificate.is_sound(), "{:?}", made.report.shortfalls);
        assert!(
            !made.report.shortfalls.iter().any(|s| s.to_string().contains("stay as they were")),
            "{:?}",
            made.report.shortfalls
        );
        let q = &check.quality;
        assert!(q.p05_angle > 30.0 && q.below_20 < 0.02, "{width} {depth}: {q:?}");
        let longest = (0..made.mesh.triangles.len())
            .flat_map(|t| {
                let [a, b, c] = made.mesh.corners(t);
                [a.distance(b), b.distance(c), c.distance(a)]
            })
            .fold(0.0, f64::max);
        assert!(longest < 0.36, "{longest}");
        // The slit is as deep as it was, about.
        let missed = (input.volume() - made.mesh.volume()) / input.volume();
        assert!(abs_diff_eq!(missed, 0.0, epsilon = 0.03), "{width} {depth}: {missed}");
    }
}

#[test]
fn damage_is_healed_and_told() {
    let mut input = l_block(0.5);
    // One triangle the wrong way round, one twice, one without area.
    input.triangles[3].swap(0, 1);
    let (again, line) = (input.triangles[5], [0, 1, 1]);
    input.triangles.extend([again, line]);
    input.labels = vec![0; input.triangles.len()];
    let made = meshed(&input, 0.1, &SoupOptions::default(), 0);
    assert!(made.report.check.as_ref().unwrap().certificate.is_sound());
    assert!(made.report.warnings.iter().any(|w| w.starts_with("healed")), "{:?}", made.report.warnings);
    assert_eq!(made.mesh.faces.len(), 8);
}

/// A shell whose half was moved by what single precision rounds: there are slits between the halves, narrower than the wall by far.
#[test]
fn slits_that_rounding_left_are_no_borders() {
    let profile = |r: f64, up: f64| {
        let at = |i: i32| (PI * f64::from(i) / 24.0).sin_cos();
        let between = (1..24).map(|i| [r * at(i).0, -up * r * at(i).1]);
        std::iter::once([0.0, -up * r]).chain(between).chain([[0.0, up * r]]).collect::<Vec<_>>()
    };
    let [outer, inner] = [(1.0, 1.0), (0.97, -1.0)].map(|(r, up)| revolved(&profile(r, up), 48, false));
    let mut input = outer.clone();
    let shift = input.nodes.len() as u32;
    input.nodes.extend(&inner.nodes);
    input.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| v + shift)));
    let whole = TriMesh::new(input.nodes.clone(), input.triangles.clone());
    assert!(whole.defects().is_closed());
    let count = input.nodes.len() as u32;
    input.nodes.extend_from_within(..);
    input.nodes[count as usize..].iter_mut().for_each(|p| *p *= 1.0 + 6e-8);
    let is_moved = |t: &[u32; 3]| t.iter().map(|v| whole.nodes[*v as usize].y).sum::<f64>() > 0.0;
    let moved = whole.triangles.iter().map(|t| if is_moved(t) { t.map(|v| v + count) } else { *t });
    let torn = TriMesh::new(input.nodes, moved.collect());
    assert!(!torn.defects().is_closed());
    let made = meshed(&torn, 0.25, &SoupOptions::default(), 0);
    let (report, check) = (&made.report, made.report.check.as_ref().unwrap());
    assert!(check.certificate.is_sound() && report.shortfalls.is_empty(), "{report:?}");
    assert_eq!((report.attempts.len(), check.components, check.genus), (1, 2, Some(0)));
    assert!(report.warnings.iter().any(|w| w.starts_with("healed: near borders")), "{:?}", report.warnings);
    assert_relative_eq!(check.volume.unwrap(), whole.volume(), max_relative = 0.1);
    // A slit as wide as a thousandth is one, and stays.
    let mut open = torn.clone();
    open.nodes[count as usize..].iter_mut().for_each(|p| *p += 2e-3 * DVec3::Y);
    let made = meshed(&open, 0.25, &SoupOptions::default(), 0);
    assert!(made.report.warnings.iter().any(|w| w.contains("open")), "{:?}", made.report.warnings);
}

/// A bar of which three edges are rounded: its sides are one face, with a right angle in it that ends nowhere. Beside that angle points of one
/// plane are above the edge of the other, to rounding.
#[test]
fn planes_that_meet_at_a_right_angle_within_a_face_keep_their_normals() {
    let round = |x: f64, y: f64, from: f64| {
        (0..=6).map(move |k| {
            let (s, c) = (from + PI / 12.0 * f64::from(k)).sin_cos();
            [x + 0.3 * c, y + 0.3 * s]
        })
    };
    let rounds = round(0.7, 0.3, -PI / 2.0).chain(round(0.7, 0.7, 0.0)).chain(round(0.3, 0.7, PI / 2.0));
    let corners: Vec<[f64; 2]> = std::iter::once([0.0, 0.0]).chain(rounds).collect();
    let mut outline = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let n = ((a[0] - b[0]).hypot(a[1] - b[1]) / 0.07).ceil() as u32;
        outline.extend((0..n).map(|k| [0, 1].map(|j| a[j] + (b[j] - a[j]) * f64::from(k) / f64::from(n))));
    }
    let input = prism(&outline, 1.0);
    let input = meshed(&input, 0.1, &SoupOptions::default(), 0).mesh;
    let options = DiscreteOptions { scale: 0.09, ..DiscreteOptions::default() };
    let solid =
        Discrete::new(&TriMesh::new(input.nodes.clone(), input.triangles.clone()), &options, &Run::new()).unwrap();
    assert_eq!(solid.face_count(), 3);
    for t in 0..input.triangles.len() {
        let [a, b, c] = input.corners(t);
        for (u, v) in (0..8).flat_map(|i| (0..8 - i).map(move |j| (i, j))) {
            let [u, v] = [u, v].map(|k| (f64::from(k) + 1.0 / 3.0) / 8.0);
            let p = a + u * (b - a) + v * (c - a);
            let foot = solid.project(p, 1.0).unwrap();
            assert!(foot.normal.dot(input.normal(t)) > 0.5, "{p} {} {foot:?}", input.normal(t));
        }
    }
    for size in [0.2, 0.11, 0.07] {
        let made = meshed(&input, size, &SoupOptions::default(), 0);
        assert!(made.report.shortfalls.is_empty(), "{size} {:?}", made.report.shortfalls);
    }
}

/// A cylinder cut at 55 degrees: along an eighth of its upper rim wall and cap make less than the feature angle.
#[test]
fn a_rim_that_is_blunt_on_one_side_is_whole() {
    let mut input = cylinder(64);
    let slope = 55f64.to_radians().tan();
    input.nodes[64..].iter_mut().for_each(|p| p.z += slope * p.x);
    for size in [0.1, 0.2, 0.8] {
        let made = meshed(&input, size, &SoupOptions::default(), 0);
        let check = made.report.check.as_ref().unwrap();
        assert!(check.certificate.is_sound() && made.report.shortfalls.is_empty(), "{size} {:?}", made.report);
        assert_eq!(made.mesh.faces.len(), 3, "{size}");
        assert_eq!(made.model().unwrap().model.edges.len(), 2, "{size}");
        // The rim is an ellipse; what lies farthest is on it.
        let top = made.mesh.nodes.iter().map(|p| p.z).fold(0.0, f64::max);
        assert_abs_diff_eq!(top, 2.0 + slope, epsilon = 0.02);
    }
}

#[test]
fn info_tells_the_model() {
    let info = soup_info(&cylinder(24), &MeshOptions::default(), &SoupOptions::default(), &Run::new()).unwrap();
    assert!(info.closed && info.healed.is_empty());
    assert_eq!((info.edges, info.faces.len(), info.shells), (2, 3, 1));
    assert_eq!(info.faces.iter().filter(|f| f.plane).count(), 2);
    let wall = info.faces.iter().find(|f| !f.plane).unwrap();
    assert_eq!(wall.neighbors.len(), 2);
    // The wall has both rims as loops, and each rim is a closed edge as long as the polygon of 24 sides.
    assert_eq!(wall.loops.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1]);
    for (e, rim) in info.graph.iter().enumerate() {
        assert_eq!(rim.ends[0], rim.ends[1]);
        assert!(rim.faces.contains(&wall.name) && rim.faces.len() == 2);
        assert_abs_diff_eq!(rim.length, 48.0 * (PI / 24.0).sin(), epsilon = 1e-9);
        assert!(info.faces.iter().filter(|f| f.loops.contains(&vec![e as u32])).count() == 2);
    }
    assert!(info.to_string().contains("3 faces"));
}

#[test]
fn a_number_of_nodes_is_met() {
    let input = l_block(0.5);
    for nodes in [300, 2000] {
        let soup = SoupOptions { nodes: Some(nodes), ..SoupOptions::default() };
        let made = mesh_soup(&input, &MeshOptions::default(), &soup, &Run::new()).unwrap();
        assert!(made.report.shortfalls.is_empty());
        assert!(
            abs_diff_eq!(made.mesh.nodes.len() as f64 / nodes as f64, 1.0, epsilon = 0.05),
            "{}",
            made.mesh.nodes.len()
        );
    }
    let few = SoupOptions { nodes: Some(3), ..SoupOptions::default() };
    assert!(mesh_soup(&input, &MeshOptions::default(), &few, &Run::new()).is_err());
}

#[test]
fn baselines_are_sound_and_random_nodes_make_worse_triangles() {
    let input = cylinder(48);
    let options = MeshOptions { size: Some(SizeRequest::Length(0.15)), ..MeshOptions::default() };
    let c = compare_soup(&input, &options, &SoupOptions::default(), &Run::new()).unwrap();
    assert_eq!(c.rows.iter().map(|r| r.method).collect::<Vec<_>>(), ["input", "poisson", "frontal", "triangles"]);
    assert!(c.rows.iter().all(|r| r.check.certificate.is_sound()));
    let [poisson, frontal, ours] = [1, 2, 3].map(|k| &c.rows[k].check);
    let ratios = [poisson, frontal, ours].map(|c| c.quality.mean_radius_ratio);
    assert!(ratios[1] > ratios[0] && ratios[2] > ratios[0], "{ratios:?}");
    // As many triangles, or the comparison says nothing.
    assert_abs_diff_eq!(poisson.triangles as f64 / ours.triangles as f64, 1.0, epsilon = 0.25);
}
