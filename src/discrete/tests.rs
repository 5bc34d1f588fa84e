//! Faces, edges and vertices of soups whose truth is known.

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use glam::{DMat3, DVec3};
use proptest::prelude::*;

use super::{
    Discrete, DiscreteOptions, Limits, Torn, chains, drop_crowded, drop_islands, drop_noise, flood, mark_feature_edges,
    mend_needles, torn_nodes,
};
use crate::geometry::{Pieces, SurfaceOracle};
use crate::mesh::{EditMesh, Group, TriMesh};
use crate::run::Run;

#[path = "../../tests/shapes/mod.rs"]
mod shapes;
use shapes::{l_block, prism};

fn find(mesh: &TriMesh, options: DiscreteOptions) -> Discrete {
    Discrete::new(mesh, &options, &Run::new()).unwrap()
}

fn cube() -> TriMesh {
    prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 1.0)
}

fn cylinder(sides: u32) -> TriMesh {
    let corner = |i: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
        [c, s]
    };
    prism(&(0..sides).map(corner).collect::<Vec<_>>(), 2.0)
}

/// A number between 0 and 1 that has nothing to do with the one before it.
fn random(k: u32) -> f64 {
    let mut x = (k + 1).wrapping_mul(2_654_435_761);
    x = (x ^ (x >> 15)).wrapping_mul(2_246_822_519);
    x = (x ^ (x >> 13)).wrapping_mul(3_266_489_917);
    f64::from(x ^ (x >> 16)) / f64::from(u32::MAX)
}

/// A cube's surface, each side a grid, blown up to a sphere; `wobble` moves nodes outwards at random.
fn ball(n: u32, wobble: f64) -> TriMesh {
    let mut mesh = TriMesh::new(Vec::new(), Vec::new());
    let mut known = std::collections::BTreeMap::new();
    for axis in 0..3 {
        for side in [-1i64, 1] {
            let mut id = |i: u32, j: u32| {
                let at = |k: u32| 2 * i64::from(k) - i64::from(n);
                let mut p = [0i64; 3];
                p[axis] = side * i64::from(n);
                p[(axis + 1) % 3] = at(i);
                p[(axis + 2) % 3] = at(j);
                *known.entry(p).or_insert_with(|| {
                    let r = 1.0 + wobble * random(mesh.nodes.len() as u32);
                    mesh.nodes.push(r * DVec3::from_array(p.map(|x| x as f64)).normalize());
                    mesh.nodes.len() as u32 - 1
                })
            };
            let mut quads = Vec::new();
            for i in 0..n {
                for j in 0..n {
                    quads.push([id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
                }
            }
            for [a, b, c, d] in quads {
                let (x, y) = if side > 0 { ([a, b, c], [a, c, d]) } else { ([a, c, b], [a, d, c]) };
                mesh.triangles.extend([x, y]);
            }
        }
    }
    mesh.labels = vec![0; mesh.triangles.len()];
    mesh
}

fn counts(found: &Discrete) -> [usize; 3] {
    let model = found.model().unwrap().model;
    [model.vertices.len(), model.edges.len(), model.faces.len()]
}

#[test]
fn the_models_of_simple_solids() {
    let default = DiscreteOptions::default();
    assert_eq!(counts(&find(&cube(), default)), [8, 12, 6]);
    assert_eq!(counts(&find(&l_block(0.5), default)), [12, 18, 8]);
    // Each rim is one closed edge with one vertex.
    assert_eq!(counts(&find(&cylinder(24), default)), [2, 2, 3]);
    // Sides that meet at 45 degrees are faces of their own.
    assert_eq!(counts(&find(&cylinder(8), default)), [16, 24, 10]);
    assert_eq!(counts(&find(&cylinder(8), DiscreteOptions { feature_angle: 50.0, ..default })), [2, 2, 3]);
    assert_eq!(counts(&find(&ball(12, 0.0), default)), [0, 0, 1]);
}

#[test]
fn the_relation_graph_of_a_cube() {
    let found = find(&cube(), DiscreteOptions::default());
    let model = found.model().unwrap().model;
    for around in model.faces_of_edges() {
        assert_eq!(around.len(), 2);
        assert_ne!(around[0], around[1]);
    }
    for f in 0..6 {
        let (n, d) = found.plane(f).unwrap();
        assert_eq!(n.abs().max_element(), 1.0);
        assert!(d == 0.0 || d == 1.0 || d == -1.0);
    }
    assert_eq!(model.shells.len(), 1);
}

#[test]
fn an_open_box_has_its_rim_as_edges() {
    let mut mesh = cube();
    mesh.triangles.retain(|t| !t.iter().all(|v| *v >= 4));
    mesh.labels.truncate(mesh.triangles.len());
    let found = find(&mesh, DiscreteOptions::default());
    assert_eq!(counts(&found), [8, 12, 5]);
    // Four lines of the rim, each a piece of its own.
    let lines: Vec<u32> = (4..8).flat_map(|v| found.pieces_at(v)).filter(|p| *p >= 5).collect();
    assert_eq!(lines.iter().max(), Some(&8));
    for line in 5..9 {
        let face = (0..5).find(|f| found.meet(&[*f, line], DVec3::splat(0.5), 9.0).is_some()).unwrap();
        let p = found.meet(&[face, line], DVec3::new(0.4, 0.4, 0.7), 9.0).unwrap();
        assert_eq!(p.z, 1.0);
    }
}

#[test]
fn points_on_edges_are_on_them_exactly() {
    let found = find(&cube(), DiscreteOptions::default());
    let face = |p: DVec3| found.piece_at(p).unwrap();
    let (x, z) = (face(DVec3::new(1.0, 0.5, 0.4)), face(DVec3::new(0.5, 0.4, 1.0)));
    let p = found.meet(&[x.min(z), x.max(z)], DVec3::new(0.9, 0.3, 1.2), 1.0).unwrap();
    assert_eq!(p, DVec3::new(1.0, 0.3, 1.0));
    assert_eq!(found.meet(&[x], DVec3::new(1.1, 0.3, 0.2), 0.01), None);
    let foot = found.project(DVec3::new(1.1, 0.3, 0.2), 1.0).unwrap();
    assert_eq!((foot.point, foot.normal, foot.face), (DVec3::new(1.0, 0.3, 0.2), DVec3::X, x));
    let hit = found.project_along(DVec3::new(0.8, 0.3, 0.2), DVec3::X, 0.5).unwrap();
    assert!((hit.point - DVec3::new(1.0, 0.3, 0.2)).length() < 1e-15);
}

#[test]
fn curvature_of_a_cylinder_is_that_of_its_circle() {
    let found = find(&cylinder(48), DiscreteOptions::default());
    let wall = found.piece_at(DVec3::new(1.0, 0.01, 1.0)).unwrap();
    let k = found.curvature(wall, DVec3::new(1.0, 0.01, 1.0)).unwrap();
    assert_abs_diff_eq!(k, 1.0, epsilon = 0.01);
    let top = found.piece_at(DVec3::new(0.1, 0.1, 2.0)).unwrap();
    assert_eq!(found.curvature(top, DVec3::new(0.1, 0.1, 2.0)), Some(0.0));
}

#[test]
fn curvature_does_not_depend_on_how_finely_a_wall_is_divided() {
    for sides in [12, 48, 200] {
        let found = find(&cylinder(sides), DiscreteOptions { scale: 1.0, ..DiscreteOptions::default() });
        let p = DVec3::new(1.0, 0.001, 0.001);
        let wall = found.piece_at(p).unwrap();
        let k = found.curvature(wall, p).unwrap();
        assert!((0.75..1.1).contains(&k), "{sides} {k}");
    }
}

#[test]
fn rims_ask_for_edges_that_follow_them() {
    // As far from a circle of radius 1 as a chord of length 0.4.
    let found = find(&cylinder(90), DiscreteOptions::default());
    let sizes = found.bow_sizes(1.0, 0.1, 0.02);
    let rim: Vec<f64> = sizes.into_iter().filter(|s| s.is_finite()).collect();
    assert!(rim.len() == 180 && rim.iter().all(|s| (0.34..0.44).contains(s)), "{rim:?}");
    // Straight edges ask for nothing.
    let straight = find(&l_block(0.5), DiscreteOptions::default()).bow_sizes(0.5, 0.1, 0.02);
    assert!(straight.iter().all(|s| s.is_infinite()), "{straight:?}");
}

#[test]
fn bends_crowd_triangles_by_the_area_that_bends() {
    // Edges of half the length where it bends: four times the triangles, on the share of the area that is round.
    let half = |k: f64| if k > 0.1 { 0.5 } else { 1.0 };
    assert_eq!(find(&cube(), DiscreteOptions::default()).crowding(half), 1.0);
    assert_abs_diff_eq!(find(&ball(12, 0.0), DiscreteOptions::default()).crowding(half), 4.0, epsilon = 1e-9);
    let (round, flat) = (4.0, 2.0);
    let wanted = (4.0 * round + flat) / (round + flat);
    assert_abs_diff_eq!(find(&cylinder(48), DiscreteOptions::default()).crowding(half), wanted, epsilon = 0.01);
}

#[test]
fn slivers_do_not_bend_a_sphere() {
    // As marching cubes do: a node of the finest noise very close to another one.
    let mut mesh = ball(24, 0.0);
    let t = mesh.triangles[100];
    let [a, b] = [t[0], t[1]].map(|v| mesh.nodes[v as usize]);
    mesh.nodes[t[0] as usize] = a.lerp(b, 0.99) * (1.0 + 1e-4);
    let found = find(&mesh, DiscreteOptions { scale: 0.5, ..DiscreteOptions::default() });
    let k = found.curvature(0, b).unwrap();
    assert!((0.8..2.0).contains(&k), "{k}");
}

#[test]
fn islands_go_and_faces_with_walls_stay() {
    let mut mesh = EditMesh::new(&ball(8, 0.0)).unwrap();
    (0..3).for_each(|h| mesh.set_sharp(h, true));
    assert_eq!(flood(&mesh).1, 2);
    assert_eq!(drop_islands(&mut mesh, 1e-3), 0);
    assert_eq!((drop_islands(&mut mesh, 1.0), flood(&mesh).1), (1, 1));
    // Two side by side, then five: more than noise.
    for (triangles, gone) in [(vec![0u32, 1], 2), ((0..5).collect(), 0)] {
        let mut mesh = EditMesh::new(&ball(8, 0.0)).unwrap();
        triangles.iter().flat_map(|t| 3 * t..3 * t + 3).for_each(|h| mesh.set_sharp(h, true));
        let before = flood(&mesh).1;
        assert_eq!(before, triangles.len() + 1);
        assert_eq!((drop_islands(&mut mesh, 1.0), flood(&mesh).1), (gone, before - gone));
    }
    let mut mesh = EditMesh::new(&cube()).unwrap();
    mark_feature_edges(&mut mesh, 40.0);
    assert_eq!((drop_islands(&mut mesh, 10.0), flood(&mesh).1), (0, 6));
}

#[test]
fn noise_does_not_shatter_a_ball() {
    let noisy = ball(24, 0.05);
    let mut mesh = EditMesh::new(&noisy).unwrap();
    let sharp = mark_feature_edges(&mut mesh, 40.0);
    assert!(sharp > 100, "{sharp} edges: the noise is too weak to test anything");
    let limits = Limits { length: 0.3, ..Limits::default() };
    let found = find(&noisy, DiscreteOptions { scale: 0.4, limits, ..DiscreteOptions::default() });
    assert_eq!(counts(&found)[2], 1);
    // The same scale does not touch what is a feature.
    let found = find(&cube(), DiscreteOptions { scale: 0.4, limits, ..DiscreteOptions::default() });
    assert_eq!(counts(&found), [8, 12, 6]);
}

#[test]
fn small_features_with_flat_sides_are_no_noise() {
    let options = DiscreteOptions { scale: 0.5, ..DiscreteOptions::default() };
    assert_eq!(counts(&find(&l_block(0.99), options)), [12, 18, 8]);
    // A pin much thinner than the scale.
    let mut pin = cylinder(24);
    pin.nodes.iter_mut().for_each(|p| *p = DVec3::new(0.02 * p.x, 0.02 * p.y, p.z));
    let mut mesh = EditMesh::new(&pin).unwrap();
    mark_feature_edges(&mut mesh, 40.0);
    assert_eq!(drop_noise(&mut mesh, 40.0, 0.5, &Run::new()).unwrap(), 0);
}

#[test]
fn small_faces_are_merged_and_told() {
    // The step is 0.01 high: its riser has an area of 0.01.
    let limits = Limits { area: 0.02, ..Limits::default() };
    let found = find(&l_block(0.99), DiscreteOptions { limits, ..DiscreteOptions::default() });
    assert_eq!(counts(&found)[2], 7);
    assert_eq!(found.removed.len(), 1);
    assert_eq!(found.removed[0].what, "face");
    assert_abs_diff_eq!(found.removed[0].size, 0.01, epsilon = 1e-12);
    assert_abs_diff_eq!(found.removed[0].at[0], 1.0, epsilon = 1e-12);
    // The geometry is what it was.
    assert_abs_diff_eq!(found.named().volume(), l_block(0.99).volume(), epsilon = 1e-14);
    let limits = Limits { width: 0.02, ..Limits::default() };
    assert_eq!(counts(&find(&l_block(0.99), DiscreteOptions { limits, ..DiscreteOptions::default() }))[2], 7);
}

#[test]
fn small_faces_go_where_features_are_torn_and_stay_where_they_are_whole() {
    let mut mesh = EditMesh::new(&ball(8, 0.0)).unwrap();
    (0..3).for_each(|h| mesh.set_sharp(h, true));
    let torn = |m: &EditMesh| Torn { nodes: torn_nodes(m), limits: Limits { area: 1.0, ..Limits::default() } };
    let whole = torn(&mesh);
    assert!(!whole.nodes.contains(&true));
    assert!(super::simplify(&mut mesh, &Limits::default(), Some(&whole), &Run::new()).unwrap().is_empty());
    assert_eq!(flood(&mesh).1, 2);
    // One more edge, from a corner of the face into the other one.
    let out = mesh.outgoing(mesh.origin(0)).find(|&h| !mesh.is_sharp(h)).unwrap();
    mesh.set_sharp(out, true);
    let broken = torn(&mesh);
    assert_eq!(broken.nodes.iter().filter(|t| **t).count(), 4);
    let removed = super::simplify(&mut mesh, &Limits::default(), Some(&broken), &Run::new()).unwrap();
    assert_eq!((removed.len(), removed[0].what, flood(&mesh).1), (1, "face", 1));
    assert_eq!(chains(&mesh).len(), 1);
}

#[test]
fn of_two_torn_features_side_by_side_one_stays() {
    let mut mesh = EditMesh::new(&ball(12, 0.0)).unwrap();
    // Two rows of a grid that run beside each other, an edge apart, and one across them at an end.
    let at = |p: DVec3| mesh.nodes().min_by(|a, b| mesh.point(*a).distance(p).total_cmp(&mesh.point(*b).distance(p)));
    let node = |i: i32, j: i32| at(DVec3::new(f64::from(i), f64::from(j), 6.0).normalize()).unwrap();
    let mut pairs: Vec<[u32; 2]> = (-3..3).flat_map(|i| [[node(i, 0), node(i + 1, 0)]]).collect();
    pairs.extend((-3..2).map(|i| [node(i, 1), node(i + 1, 1)]));
    pairs.push([node(-3, 0), node(-4, 0)]);
    let edges: Vec<u32> = pairs.iter().map(|[a, b]| mesh.edge_between(*a, *b).unwrap()).collect();
    edges.iter().for_each(|&h| mesh.set_sharp(h, true));
    let torn = Torn { nodes: torn_nodes(&mesh), limits: Limits::default() };
    let apart = mesh.point(pairs[0][0]).distance(mesh.point(pairs[6][0]));
    assert_eq!((chains(&mesh).len(), drop_crowded(&mut mesh, &torn, 0.5 * apart)), (2, 0));
    assert_eq!(drop_crowded(&mut mesh, &torn, 1.2 * apart), 1);
    assert_eq!((chains(&mesh).len(), chains(&mesh)[0].edges.len()), (1, 7));
    // Whole features stay however near they are.
    let whole = Torn { nodes: vec![false; mesh.node_capacity()], limits: Limits::default() };
    edges.iter().for_each(|&h| mesh.set_sharp(h, true));
    assert_eq!(drop_crowded(&mut mesh, &whole, 1.2 * apart), 0);
}

#[test]
fn short_edges_that_end_in_a_face_are_dropped() {
    let mesh = ball(8, 0.0);
    let mut edit = EditMesh::new(&mesh).unwrap();
    let h = edit.edges().next().unwrap();
    edit.set_sharp(h, true);
    assert_eq!(chains(&edit).len(), 1);
    let length = edit.edge_length(h);
    let keep = Limits { length: 0.9 * length, ..Limits::default() };
    assert!(super::simplify(&mut edit, &keep, None, &Run::new()).unwrap().is_empty());
    let drop = Limits { length: 1.1 * length, ..Limits::default() };
    assert_eq!(super::simplify(&mut edit, &drop, None, &Run::new()).unwrap().len(), 1);
    assert!(!edit.is_sharp(h) && chains(&edit).is_empty());
}

#[test]
fn labels_are_borders_and_names() {
    let mut mesh = cube();
    mesh.faces = vec!["bottom half".into(), "lid".into(), "unused".into()];
    mesh.labels = mesh.triangles.iter().map(|t| u32::from(t.iter().all(|v| *v >= 4))).collect();
    mesh.groups = vec![Group { name: "all".into(), faces: vec![0, 1] }];
    let found = find(&mesh, DiscreteOptions { feature_angle: 120.0, ..DiscreteOptions::default() });
    let named = found.named();
    // Nothing is sharp at 120 degrees: only the labels part faces.
    assert_eq!(named.faces, ["bottom half", "lid"]);
    assert_eq!(named.groups, [Group { name: "all".into(), faces: vec![0, 1] }]);
    let found = find(&mesh, DiscreteOptions::default());
    let named = found.named();
    assert_eq!(named.faces.iter().filter(|f| f.starts_with("bottom half.")).count(), 5);
    assert!(named.faces.contains(&"lid".to_string()));
    assert_eq!(named.groups[0].name, "bottom half");
    assert_eq!(named.groups[0].faces.len(), 5);
    // No simplification merges across labels.
    let limits = Limits { area: 10.0, ..Limits::default() };
    let found = find(&mesh, DiscreteOptions { limits, ..DiscreteOptions::default() });
    assert_eq!(found.named().faces, ["bottom half", "lid"]);
}

#[test]
fn needles_make_no_features() {
    // A node a rounding off the diagonal of a cube's side: one triangle there has no normal to speak of.
    let mut mesh = cube();
    let k = mesh.triangles.iter().position(|t| t.iter().all(|v| *v >= 4)).unwrap();
    let [a, b, c] = mesh.triangles[k];
    let on = |x: u32, y: u32| mesh.nodes[x as usize].lerp(mesh.nodes[y as usize], 0.5);
    let v = mesh.nodes.len() as u32;
    let longest = if mesh.nodes[a as usize].distance(mesh.nodes[b as usize]) > 1.2 { (a, b, c) } else { (c, a, b) };
    let p = on(longest.0, longest.1) + DVec3::new(1e-9, 0.0, -3e-9);
    mesh.nodes.push(p);
    mesh.triangles[k] = [longest.0, v, longest.2];
    mesh.triangles.extend([[v, longest.1, longest.2], [longest.0, longest.1, v]]);
    mesh.labels = vec![0; mesh.triangles.len()];
    assert_eq!(counts(&find(&mesh, DiscreteOptions::default())), [8, 12, 6]);
    let mut edit = EditMesh::new(&mesh).unwrap();
    assert!(mend_needles(&mut edit, 1e-7, &Run::new()).unwrap() > 0);
    assert_eq!(mend_needles(&mut edit, 1e-7, &Run::new()).unwrap(), 0);
    edit.check().unwrap();
}

#[test]
fn a_narrow_face_asks_for_small_edges() {
    let found = find(&l_block(0.9), DiscreteOptions { scale: 1.0, ..DiscreteOptions::default() });
    let sizes = found.feature_sizes(1.0, 0.01);
    for v in found.mesh.nodes() {
        let p = found.mesh.point(v);
        // Along the riser, 0.1 high at x = 1, edges may be twice as long as it is high; at its short ends 1.5 times.
        if p.x == 1.0 && p.y >= 0.9 {
            let wanted = if p.z == 0.0 || p.z == 1.0 { 0.15 } else { 0.2 };
            assert!(abs_diff_eq!(sizes[v as usize], wanted, epsilon = 1e-9), "{p}: {}", sizes[v as usize]);
        }
    }
}

proptest! {
    /// What is found does not depend on position, orientation, or the order of triangles.
    #[test]
    fn models_do_not_depend_on_the_frame(
        axis in prop::array::uniform3(-1.0f64..1.0), angle in 0.0f64..6.0, by in prop::array::uniform3(-1e3f64..1e3),
        scale in 1e-3f64..1e3, turn in 0usize..40, shape in 0usize..4,
    ) {
        let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::Z);
        let mut mesh = [cube(), l_block(0.5), cylinder(24), ball(6, 0.0)][shape].clone();
        let before = counts(&find(&mesh, DiscreteOptions::default()));
        let m = DMat3::from_axis_angle(axis, angle);
        mesh.nodes.iter_mut().for_each(|p| *p = scale * (m * *p + DVec3::from_array(by)));
        let n = mesh.triangles.len();
        mesh.triangles.rotate_left(turn % n);
        mesh.triangles.iter_mut().for_each(|t| t.rotate_left(turn % 3));
        prop_assert_eq!(counts(&find(&mesh, DiscreteOptions::default())), before);
    }

    /// Faces partition the triangles, and no mark lies within one.
    #[test]
    fn floods_respect_marks(angle in 1.0f64..90.0) {
        let mut mesh = EditMesh::new(&ball(5, 0.2)).unwrap();
        mark_feature_edges(&mut mesh, angle);
        let (face, count) = flood(&mesh);
        for h in mesh.edges() {
            let (a, b) = (face[(h / 3) as usize], face[(mesh.opposite(h) / 3) as usize]);
            prop_assert!((a as usize) < count);
            prop_assert!(mesh.is_sharp(h) || a == b);
        }
    }
}

/// A sphere inside another, their distance `gap`, as a shell.
fn shell(gap: f64) -> TriMesh {
    let (rows, columns) = (12u32, 24u32);
    let mut mesh = TriMesh { faces: vec!["shell".into()], ..TriMesh::default() };
    for (radius, turned) in [(1.0, false), (1.0 - gap, true)] {
        let first = mesh.nodes.len() as u32;
        mesh.nodes.push(DVec3::Z * radius);
        for i in 1..rows {
            let (s, c) = (std::f64::consts::PI * f64::from(i) / f64::from(rows)).sin_cos();
            for j in 0..columns {
                let (y, x) = (std::f64::consts::TAU * f64::from(j) / f64::from(columns)).sin_cos();
                mesh.nodes.push(radius * DVec3::new(s * x, s * y, c));
            }
        }
        mesh.nodes.push(-DVec3::Z * radius);
        let last = mesh.nodes.len() as u32 - 1;
        let at = |i: u32, j: u32| first + 1 + (i - 1) * columns + j % columns;
        let mut add = |a: u32, b: u32, c: u32| {
            mesh.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
            mesh.labels.push(0);
        };
        for j in 0..columns {
            add(first, at(1, j), at(1, j + 1));
            add(last, at(rows - 1, j + 1), at(rows - 1, j));
            for i in 1..rows - 1 {
                add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
                add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
            }
        }
    }
    mesh
}

#[test]
fn thin_curved_walls_ask_for_short_edges_and_thinner_ones_stay() {
    let walls = |gap: f64| {
        let found = Discrete::new(&shell(gap), &DiscreteOptions::default(), &Run::new()).unwrap();
        let walls = found.walls(|_| 0.5, 0.05, &Run::new()).unwrap();
        let wanted: Vec<f64> = found.mesh.nodes().map(|v| walls.sizes[v as usize]).collect();
        (wanted, walls.tight)
    };
    let (wanted, tight) = walls(0.2);
    assert!(wanted.iter().all(|s| s.is_infinite()) && tight.iter().all(|t| !t));
    // Chords of 0.5 are 1/32 off on either side.
    let (wanted, tight) = walls(0.02);
    assert!(wanted.iter().all(|s| *s > 0.1 && *s < 0.5) && tight.iter().all(|t| !t));
    let (_, tight) = walls(0.0005);
    assert!(tight.iter().all(|t| *t));
}

/// A pipe of facets as long as it is, with a wall of thickness `wall`, closed at its ends by rings.
fn pipe(facets: u32, wall: f64, length: f64) -> TriMesh {
    let mut mesh = TriMesh { faces: vec!["pipe".into()], ..TriMesh::default() };
    for (radius, z) in [(1.0, 0.0), (1.0, length), (1.0 - wall, 0.0), (1.0 - wall, length)] {
        for k in 0..facets {
            let (y, x) = (std::f64::consts::TAU * f64::from(k) / f64::from(facets)).sin_cos();
            mesh.nodes.push(DVec3::new(radius * x, radius * y, z));
        }
    }
    for i in 0..facets {
        let j = (i + 1) % facets;
        let at = |ring: u32, k: u32| ring * facets + k;
        for [a, b] in [[0, 1], [3, 2], [1, 3], [2, 0]] {
            mesh.triangles.push([at(a, i), at(a, j), at(b, j)]);
            mesh.triangles.push([at(a, i), at(b, j), at(b, i)]);
        }
    }
    mesh.labels = vec![0; mesh.triangles.len()];
    mesh
}

#[test]
fn walls_of_long_facets_are_seen_between_their_ends() {
    let (run, wanted) = (Run::new(), |k: f64| if k > 0.0 { 0.5 } else { 2.0 });
    let made = |wall: f64| {
        let options = DiscreteOptions { scale: 2.0, ..DiscreteOptions::default() };
        let mut found = Discrete::new(&pipe(32, wall, 20.0), &options, &run).unwrap();
        let before = (found.mesh.nodes().count(), found.named().volume());
        found.divide_walls(wanted, 0.05, &run).unwrap();
        (before, found)
    };
    // Chords of 0.5 are 1/32 off on either side.
    let (before, thick) = made(0.4);
    assert_eq!(thick.mesh.nodes().count(), before.0);
    let (before, thin) = made(0.03);
    let named = thin.named();
    assert!(named.defects().is_closed() && named.defects().is_manifold());
    assert_relative_eq!(named.volume(), before.1, epsilon = 0.0, max_relative = 1e-12);
    let walls = thin.walls(wanted, 0.05, &run).unwrap();
    let asked: Vec<f64> =
        thin.mesh.nodes().filter(|&v| walls.sizes[v as usize] < 0.5).map(|v| thin.mesh.point(v).z).collect();
    // Everywhere along the pipe, and not more of them than a mesh of that size has.
    for k in 0..40 {
        let z = 0.5 * f64::from(k) + 0.25;
        assert!(asked.iter().any(|x| (x - z).abs() < 0.25), "nothing at {z}");
    }
    // Two long edges to a facet on either side, none with more than twice the nodes it needs.
    let size = thin.mesh.nodes().map(|v| walls.sizes[v as usize]).fold(f64::INFINITY, f64::min);
    let most = before.0 as f64 + 4.0 * 32.0 * 2.0 * 20.0 / size;
    assert!((thin.mesh.nodes().count() as f64) < most, "{} nodes, {size}", thin.mesh.nodes().count());
}
