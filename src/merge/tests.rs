//! Merging: the sets, meshes cut and put together again, every way of reading, refusals.

use approx::assert_abs_diff_eq;
use glam::DVec3;
use proptest::prelude::*;
use rayon::prelude::*;

use super::sets::{Progression, Unions};
use super::*;
use crate::io::{self, Encoding, Format};
use crate::mesh::view::par_ranges;
use crate::mesh::{Group, MeshView, TriMesh};
use crate::model::tests::torus;
use crate::model::{
    BorderNodes, Cells, Coedge, Cut, Edge, EdgeFragment, Face, FaceFragment, Fragments, Loop, Model, Vertex, from_mesh,
};
use crate::quality::{self, Expectation};
use crate::render::{RenderOptions, render};
use crate::run::Run;

fn merged(cut: &Cut) -> Merged {
    Merged::new(cut.model.clone(), cut.fragments.clone()).unwrap()
}

/// The mesh that was cut, out of the merged one by the numbers the cut kept.
fn together(cut: &Cut, view: &dyn MeshView, original: &TriMesh) -> TriMesh {
    let cached = TriMesh::from_view(view);
    let mut whole = TriMesh { faces: cached.faces, groups: cached.groups, ..original.clone() };
    for (v, p) in cut.nodes.iter().zip(cached.nodes) {
        whole.nodes[*v as usize] = p;
    }
    for (i, t) in cut.triangles.iter().enumerate() {
        whole.triangles[*t as usize] = cached.triangles[i].map(|v| cut.nodes[v as usize]);
        whole.labels[*t as usize] = cached.labels[i];
    }
    whole
}

fn fragments(vertices: Vec<DVec3>, edges: &[EdgeFragment], faces: &[FaceFragment]) -> Fragments {
    let mut all = Fragments::new(vertices);
    edges.iter().for_each(|e| all.push_edge(e).unwrap());
    faces.iter().for_each(|f| all.push_face(f).unwrap());
    all
}

/// Reads a view in every way there is; all must tell the same.
pub(super) fn consistent(view: &Merged) {
    let cached = TriMesh::from_view(view);
    let (n, m) = (view.node_count(), view.cell_count());
    assert_eq!((cached.nodes.len(), n), (n, cached.nodes.len()));
    for (i, p) in cached.nodes.iter().enumerate() {
        assert_eq!(view.node(i), *p, "node {i}");
    }
    let corners: Vec<Vec<u32>> = (0..m).map(|j| view.cell(j).collect()).collect();
    for (j, cell) in corners.iter().enumerate() {
        assert_eq!(view.triangle(j).map(|t| t.to_vec()), Some(cell.clone()).filter(|c| c.len() == 3));
    }
    let all: Vec<u32> = (0..m as u32).rev().collect();
    let mut found = Vec::new();
    view.triangles_at(&all, &mut found);
    found.reverse();
    let expected: Vec<[u32; 3]> = (0..m).map(|j| view.triangle(j).unwrap_or([u32::MAX; 3])).collect();
    assert_eq!(found, expected);
    let fans = corners.iter().flat_map(|c| c[1..].windows(2).map(|p| [c[0], p[0], p[1]]));
    assert_eq!(fans.collect::<Vec<_>>(), cached.triangles);
    // parts of every length, from every place
    for step in [1, 7, 100] {
        let (mut nodes, mut cells) = (Vec::new(), Vec::new());
        for i in (0..n).step_by(step) {
            let take = &mut |run: &[DVec3]| {
                nodes.extend_from_slice(run);
                Ok(())
            };
            view.read_nodes(i..n.min(i + step), take).unwrap();
        }
        for j in (0..m).step_by(step) {
            let take = &mut |run: crate::mesh::CellRun| {
                assert_eq!((run.first, run.is_empty()), (cells.len(), false));
                cells.extend(run.iter().map(<[u32]>::to_vec));
                Ok(())
            };
            view.read_cells(j..m.min(j + step), take).unwrap();
        }
        assert_eq!((&nodes, &cells), (&cached.nodes, &corners), "step {step}");
    }
    // every node of a fragment is the node of its number, at the same place
    for (f, face) in view.fragments().faces().enumerate() {
        for (v, p) in face.nodes().enumerate() {
            assert_eq!(view.node(view.local_to_global(f as u32, v as u32) as usize), *p);
        }
    }
    for i in 0..n {
        let there = match view.place_of_node(i) {
            Place::Vertex(v) => v as usize,
            Place::Edge(..) => i,
            Place::Face(f, v) => view.local_to_global(f, v) as usize,
        };
        assert_eq!(there, i);
    }
    let by_cells = |ranges: Vec<Vec<std::ops::Range<usize>>>| -> Vec<Vec<usize>> {
        ranges.into_iter().map(|list| list.into_iter().flatten().collect()).collect()
    };
    if corners.iter().all(|c| c.len() == 3) {
        assert_eq!(by_cells(view.cells_of_faces()), by_cells(cached.cells_of_faces()));
    }
}

// -------------------------------------------------------------------------------------------------------------- sets

#[test]
fn the_four_operations() {
    let list = |s: Progression| (0..s.len).map(|i| s.get(i)).collect::<Vec<_>>();
    let s = Progression::ascending(10, 5);
    assert_eq!(list(s.reverse()), [14, 13, 12, 11, 10]);
    assert_eq!(list(s.reverse().reverse()), list(s));
    assert_eq!(list(s.exclude_bounds()), [11, 12, 13]);
    assert_eq!(list(s.reverse().exclude_bounds()), [13, 12, 11]);
    for len in 0..3 {
        assert_eq!(list(Progression::ascending(0, len).exclude_bounds()), [] as [u32; 0]);
        assert_eq!(list(Progression::ascending(0, len).reverse()).len(), len as usize);
    }
    assert_eq!(list(s.select(Progression { first: 3, len: 2, step: -1 })), [13, 12]);
    let mut unions = Unions::default();
    unions.join(3, s);
    unions.join(9, Progression::ascending(0, 0));
    unions.join(7, Progression { first: 7, len: 2, step: 0 });
    let mut lengths = vec![unions.finish(50), unions.finish(60)];
    unions.join(4, s.reverse());
    lengths.push(unions.finish(70));
    for k in 0..20 {
        unions.join(100 * k, Progression { first: 10 * k, len: k % 3, step: if k % 2 == 0 { 1 } else { -1 } });
    }
    lengths.push(unions.finish(9000));
    let elements = |u: usize| (0..lengths[u]).map(|i| unions.get(u, i)).collect::<Vec<_>>();
    assert_eq!(elements(0), [3, 10, 11, 12, 13, 14, 9, 7, 7, 7]);
    assert_eq!((elements(1), elements(2)), (vec![], vec![4, 14, 13, 12, 11, 10]));
    let long: Vec<u32> = (0..20u32)
        .flat_map(|k| [100 * k, 10 * k, 11 * k - k * (1 + k % 2)].into_iter().take(1 + k as usize % 3))
        .collect();
    assert_eq!(elements(3).len(), long.len());
    for (u, rest) in [50, 60, 70, 9000].into_iter().enumerate() {
        let mut list = vec![99];
        unions.list(u, &mut list);
        assert_eq!(list, elements(u));
        assert_eq!([0, 1, 30].map(|i| unions.get(u, lengths[u] + i)), [rest, rest + 1, rest + 30]);
    }
}

// ------------------------------------------------------------------------------------------------- cut and put together

#[test]
fn seams_and_closed_surfaces_come_back() {
    let mesh = torus(12, 9);
    let along: Vec<[u32; 2]> = (0..12).map(|i| [i, (i + 1) % 12]).collect();
    let across: Vec<[u32; 2]> = (0..9).map(|j| [12 * j, 12 * ((j + 1) % 9)]).collect();
    for borders in [vec![], along.clone(), across.clone(), [along, across].concat()] {
        for corners in [vec![], vec![5, 40]] {
            let cut = from_mesh(&mesh, &borders, &corners).unwrap();
            let view = merged(&cut);
            consistent(&view);
            assert_eq!(together(&cut, &view, &mesh), mesh);
        }
    }
}

proptest! {
    #[test]
    fn random_fragments_give_the_identical_mesh(
        a in 3u32..14, b in 3u32..14,
        seeds in prop::collection::vec((0usize..400, 0u32..5), 1..12),
        borders in prop::collection::vec((0usize..400, 0usize..3), 0..20),
        corners in prop::collection::vec(0u32..200, 0..4),
        holes in prop::collection::vec(0usize..400, 0..6),
    ) {
        let mut mesh = torus(a, b);
        for hole in holes {
            if mesh.triangles.len() > 2 {
                mesh.triangles.swap_remove(hole % mesh.triangles.len());
            }
        }
        mesh.drop_unused_nodes();
        let m = mesh.triangles.len();
        // labels by the nearest seed, so that patches are of any shape
        let label = |t: usize| {
            let c = mesh.nodes[mesh.triangles[t][0] as usize];
            let far = |s: &(usize, u32)| c.distance_squared(mesh.nodes[s.0 % mesh.nodes.len()]);
            seeds.iter().min_by(|x, y| far(x).total_cmp(&far(y))).map_or(0, |s| s.1)
        };
        mesh.labels = (0..m).map(label).collect();
        mesh.faces = (0..5).map(|i| format!("f{i}")).collect();
        mesh.groups = vec![Group { name: "g".into(), faces: vec![1, 3] }];
        let borders: Vec<[u32; 2]> = borders
            .into_iter()
            .map(|(t, k)| (mesh.triangles[t % m], k))
            .map(|(t, k)| [t[k], t[(k + 1) % 3]])
            .collect();
        let cut = from_mesh(&mesh, &borders, &corners).unwrap();
        let view = merged(&cut);
        consistent(&view);
        prop_assert_eq!(&together(&cut, &view, &mesh), &mesh);
        // in the numbers it had it is the mesh itself, also in parts
        let again = Reordered::new(view, cut.nodes, &cut.triangles).unwrap();
        prop_assert_eq!(&TriMesh::from_view(&again), &mesh);
        for (format, encoding) in FORMATS {
            let [a, b]: [&dyn MeshView; 2] = [&again, &mesh];
            prop_assert!(written(a, format, encoding).unwrap() == written(b, format, encoding).unwrap());
        }
    }
}

#[test]
fn numbers_that_are_no_order_are_refused() {
    let cut = from_mesh(&torus(4, 3), &[], &[]).unwrap();
    let refused = |nodes: Vec<u32>, cells: &[u32]| Reordered::new(merged(&cut), nodes, cells).is_err();
    assert!(refused(vec![0; 12], &cut.triangles));
    assert!(refused(cut.nodes[1..].to_vec(), &cut.triangles));
    assert!(refused(cut.nodes.clone(), &[&cut.triangles[..23], &[24]].concat()));
    assert!(!refused(cut.nodes.clone(), &cut.triangles));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut mesh = torus(300, 100);
    mesh.labels = (0..60000).map(|t| t / 5000).collect();
    mesh.faces = (0..12).map(|i| i.to_string()).collect();
    let view = merged(&from_mesh(&mesh, &[], &[]).unwrap());
    let one = crate::Run::new().with_threads(1).unwrap().install(|| TriMesh::from_view(&view));
    let many = crate::Run::new().with_threads(3).unwrap().install(|| TriMesh::from_view(&view));
    assert_eq!(one, many);
    let sum = |range| {
        let mut sum = 0u64;
        view.read_cells(range, &mut |run| {
            sum += run.corners().iter().map(|v| u64::from(*v)).sum::<u64>();
            Ok(())
        })
        .unwrap();
        sum
    };
    let whole: u64 = one.triangles.iter().flatten().map(|v| u64::from(*v)).sum();
    assert_eq!(par_ranges(view.cell_count()).map(sum).sum::<u64>(), whole);
}

// ------------------------------------------------------------------------------------------------ blocks, poles, polygons

/// The side of a cylinder or a sphere as one structured block of `a` cells around and `b` up: edges 0 the seam, 1 above,
/// 2 below.
fn turned(a: u32, b: u32, sphere: bool) -> (Model, Fragments) {
    let point = |i: u32, j: u32| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i % a) / f64::from(a)).sin_cos();
        let (y, x) = (std::f64::consts::PI * (f64::from(j) / f64::from(b) - 0.5)).sin_cos();
        let r = if !sphere {
            1.0
        } else if j == 0 || j == b {
            0.0
        } else {
            x
        };
        DVec3::new(r * c, r * s, y)
    };
    let ends = [[0, 1], [1, 1], [0, 0]];
    let c = |edge, reversed| Coedge { edge, reversed };
    let around = vec![c(2, false), c(0, false), c(1, true), c(0, true)];
    let model = Model {
        vertices: vec![Vertex::default(); 2],
        edges: (0..3).map(|e| Edge { ends: ends[e], pole: sphere && e > 0, ..Edge::default() }).collect(),
        faces: vec![Face { loops: vec![Loop::Edges(around)], ..Face::default() }],
        names: vec!["side".into()],
        ..Model::default()
    };
    let nodes = (0..=b).flat_map(|j| (0..=a).map(move |i| point(i, j))).collect();
    let chain = |list: Vec<DVec3>| EdgeFragment::new(list).unwrap();
    let edges = vec![
        chain((0..=b).map(|j| point(0, j)).collect()),
        chain((0..=a).map(|i| point(i, b)).collect()),
        chain((0..=a).map(|i| point(i, 0)).collect()),
    ];
    let face = FaceFragment::grid([a, b], nodes, &[a, b, a, b]).unwrap();
    (model, fragments(vec![point(0, 0), point(0, b)], &edges, &[face]))
}

#[test]
fn a_cylinders_side_has_a_seam() {
    let (model, fragments) = turned(7, 4, false);
    let view = Merged::new(model, fragments).unwrap();
    assert_eq!((view.node_count(), view.cell_count()), (7 * 5, 28));
    consistent(&view);
    let mesh = TriMesh::from_view(&view);
    let defects = mesh.defects();
    assert_eq!((defects.open_edges.len(), defects.is_manifold(), defects.is_oriented()), (14, true, true));
}

#[test]
fn a_sphere_has_poles_and_is_closed() {
    for (a, b) in [(3, 2), (8, 5)] {
        let (model, mut fragments) = turned(a, b, true);
        let mut face = fragments.face(0).to_fragment();
        assert_eq!(face.collapse_poles(), 0);
        fragments.set_face(0, &face).unwrap();
        let view = Merged::new(model, fragments).unwrap();
        assert_eq!((view.node_count(), view.cell_count()), ((2 + a * (b - 1)) as usize, (a * b) as usize));
        consistent(&view);
        let mesh = TriMesh::from_view(&view);
        let defects = mesh.defects();
        assert_eq!(defects, crate::mesh::Defects::default());
        assert_eq!(mesh.topology(&defects).genus, Some(0));
        assert!(mesh.volume() > 0.0);
    }
}

#[test]
fn merged_meshes_are_checked_and_drawn_as_they_are() {
    let (model, mut fragments) = turned(8, 5, true);
    let mut face = fragments.face(0).to_fragment();
    face.collapse_poles();
    fragments.set_face(0, &face).unwrap();
    let view = Merged::new(model, fragments).unwrap();
    let (mesh, run) = (TriMesh::from_view(&view), Run::new());
    let expected = Expectation::default();
    let by_view = quality::check(&view, expected, None, &run).unwrap();
    assert_eq!(by_view, quality::check(&mesh, expected, None, &run).unwrap());
    assert!(by_view.certificate.is_sound());
    assert_eq!(quality::quality(&view), quality::quality(&mesh));
    let options = RenderOptions { width: 64, height: 64, ..RenderOptions::default() };
    let [a, b] = [&view as &dyn MeshView, &mesh].map(|m| render(m, &options, &run).unwrap().rgb);
    assert!(a == b && a.iter().any(|c| *c < 200));
}

/// A square cut along its diagonal into a triangle of one triangle and a polygon, the second with its border anywhere.
pub(super) fn two_sides() -> (Model, Fragments) {
    let p = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
    let ends = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]];
    let c = |edge, reversed| Coedge { edge, reversed };
    let face = |label, list: Vec<Coedge>| Face { label, loops: vec![Loop::Edges(list)], ..Face::default() };
    let model = Model {
        vertices: vec![Vertex::default(); 4],
        edges: ends.map(|ends| Edge { ends, ..Edge::default() }).to_vec(),
        faces: vec![
            face(0, vec![c(0, false), c(1, false), c(4, true)]),
            face(1, vec![c(4, false), c(2, false), c(3, false)]),
        ],
        names: vec!["right".into(), "left".into()],
        ..Model::default()
    };
    let middle = p[2] / 2.0;
    let straight = |[a, b]: [usize; 2]| EdgeFragment::new(vec![p[a], p[b]]).unwrap();
    let mut edges = [[0, 1], [1, 2], [2, 3], [3, 0]].map(straight).to_vec();
    edges.push(EdgeFragment::new(vec![p[0], middle, p[2]]).unwrap());
    let right = FaceFragment::new(
        vec![p[0], p[1], p[2], middle],
        Cells::Quads(&[[0, 1, 2, 3]]),
        &BorderNodes::First(4),
        &[[1, 1, 2]],
    );
    let inner = DVec3::new(0.25, 0.75, 0.0);
    let left = FaceFragment::new(
        vec![inner, p[3], p[2], middle, p[0]],
        Cells::Polygons { ends: &[3, 8], corners: &[4, 0, 1, 4, 3, 2, 1, 0] },
        &BorderNodes::listed(vec![4, 3, 2, 1], 5).unwrap(),
        &[[2, 1, 1]],
    );
    (model, fragments(p.to_vec(), &edges, &[right.unwrap(), left.unwrap()]))
}

#[test]
fn cells_of_any_number_of_nodes() {
    let (model, fragments) = two_sides();
    let view = Merged::new(model, fragments).unwrap();
    assert_eq!((view.node_count(), view.cell_count()), (6, 3));
    consistent(&view);
    assert_eq!(view.cell(0).collect::<Vec<_>>(), [0, 1, 2, 4]);
    assert_eq!(view.cell(1).collect::<Vec<_>>(), [0, 5, 3]);
    assert_eq!(view.cell(2).collect::<Vec<_>>(), [0, 4, 2, 3, 5]);
    assert_eq!(view.place_of_cell(2), (1, 1));
    assert_eq!(TriMesh::from_view(&view).triangles.len(), 2 + 1 + 3);
}

// ------------------------------------------------------------------------------------------------- editing and refusing

#[test]
fn edits_show_at_once_and_bad_ones_change_nothing() {
    let (model, fragments) = two_sides();
    let mut view = Merged::new(model, fragments).unwrap();
    view.move_inner(1, |p| p.z = 1.0);
    assert_eq!(view.node(5).z, 1.0);
    consistent(&view);
    // another mesh of the same face, then back
    let p = view.fragments().vertices().to_vec();
    let fan = FaceFragment::new(
        vec![p[0], p[1], p[2], p[2] / 2.0, DVec3::new(0.75, 0.25, 0.0)],
        Cells::Triangles(&[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]),
        &BorderNodes::First(4),
        &[[1, 1, 2]],
    )
    .unwrap();
    let before = TriMesh::from_view(&view);
    let old = view.replace(Replacement { faces: vec![(0, fan)], ..Replacement::default() }).unwrap();
    assert_eq!((view.node_count(), view.cell_count()), (7, 6));
    consistent(&view);
    view.replace(old).unwrap();
    assert_eq!(TriMesh::from_view(&view), before);
    // an edge alone parts its faces; nothing must have changed
    let edge = EdgeFragment::new(vec![p[0], p[2] / 4.0, p[2] / 2.0, p[2]]).unwrap();
    let error = view.replace(Replacement { edges: vec![(4, edge)], ..Replacement::default() }).unwrap_err();
    assert!(error.to_string().contains("edge 4"), "{error}");
    assert_eq!(error.exit_code(), 3);
    let beyond = Replacement { vertices: vec![(9, DVec3::ZERO)], ..Replacement::default() };
    assert!(view.replace(beyond).unwrap_err().to_string().contains("vertex 9"));
    assert_eq!(TriMesh::from_view(&view), before);
    consistent(&view);
}

/// Editing one fragment touches nothing of the others: they stay where they are in memory, and the mesh is as if it had been
/// merged anew.
#[test]
fn an_edit_costs_the_fragment_only() {
    let mut mesh = torus(40, 30);
    mesh.labels = (0..2400).map(|t| t / 400).collect();
    mesh.faces = (0..6).map(|i| i.to_string()).collect();
    let mut view = merged(&from_mesh(&mesh, &[], &[]).unwrap());
    let kept = |view: &Merged| -> Vec<[usize; 3]> {
        let faces = view.fragments().faces();
        let at = |f: crate::model::FaceView| {
            let Cells::ShortTriangles(cells) = f.cells() else { panic!("all have few nodes") };
            [f.border().as_ptr() as usize, f.inner().as_ptr() as usize, cells.as_ptr() as usize]
        };
        faces.map(at).collect()
    };
    let before = kept(&view);
    view.move_inner(2, |p| p.z += 0.01);
    let mut face = view.fragments().face(4).to_fragment();
    let border = face.view().border().len();
    face.move_nodes(|nodes| nodes[border..].iter_mut().for_each(|p| p.z -= 0.01));
    let back = view.replace(Replacement { faces: vec![(4, face)], ..Replacement::default() }).unwrap();
    assert_eq!(kept(&view), before);
    consistent(&view);
    let (model, fragments) = view.clone().into_parts();
    assert_eq!(TriMesh::from_view(&Merged::new(model, fragments).unwrap()), TriMesh::from_view(&view));
    view.replace(back).unwrap();
    assert_eq!(kept(&view), before);
}

#[test]
fn refusals_name_the_edge() {
    let refused = |change: &dyn Fn(&mut Model, &mut Fragments)| {
        let (mut model, mut fragments) = two_sides();
        change(&mut model, &mut fragments);
        Merged::new(model, fragments).unwrap_err().to_string()
    };
    let cut = refused(&|_, f| {
        let straight = EdgeFragment::new(vec![DVec3::ZERO, f.vertices()[2]]).unwrap();
        f.set_edge(4, &straight).unwrap();
    });
    assert_eq!(cut, "edge 4: face 0 is not node-matched along edge 4: 2 segments of the face, 1 of the edge");
    let moved = refused(&|_, f| {
        let mut face = f.face(1).to_fragment();
        face.move_nodes(|nodes| nodes[1].y += 1e-9);
        f.set_face(1, &face).unwrap();
    });
    assert!(moved.starts_with("edge 4: face 1 is not node-matched"), "{moved}");
    assert!(refused(&|m, _| m.edges[2].ends[0] = 77).contains("edge 2 refers to vertex 77"));
    assert!(refused(&|m, _| m.faces[0].loops.clear()).contains("face 0"));
    assert!(refused(&|_, f| assert!(f.pop_face().is_some())).contains("2 faces"));
}

// -------------------------------------------------------------------------------------------------------------- writing

const FORMATS: [(Format, Encoding); 10] = [
    (Format::StlBinary, Encoding::Usual),
    (Format::StlAscii, Encoding::Usual),
    (Format::Obj, Encoding::Usual),
    (Format::Ply, Encoding::Binary),
    (Format::Ply, Encoding::Text),
    (Format::Off, Encoding::Usual),
    (Format::Vtu, Encoding::Binary),
    (Format::Vtu, Encoding::Text),
    (Format::Msh, Encoding::Text),
    (Format::Msh, Encoding::Binary),
];

fn written(view: &dyn MeshView, format: Format, encoding: Encoding) -> crate::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let options = io::WriteOptions { encoding, ..io::WriteOptions::default() };
    io::encode(&mut bytes, view, format, &options, &crate::Run::new())?;
    Ok(bytes)
}

#[test]
fn files_are_the_same_from_fragments_and_from_arrays() {
    let mut mesh = torus(20, 15);
    mesh.labels = (0..600).map(|t| (t / 100 * 7) % 4).collect();
    mesh.faces = ["a", "b", "c", "d"].map(String::from).to_vec();
    mesh.groups = vec![Group { name: "g".into(), faces: vec![1, 3] }];
    let view = merged(&from_mesh(&mesh, &[], &[]).unwrap());
    let cached = TriMesh::from_view(&view);
    for (format, encoding) in FORMATS {
        let [a, b]: [&dyn MeshView; 2] = [&view, &cached];
        let [a, b] = [a, b].map(|m| written(m, format, encoding).unwrap());
        assert!(a == b, "{format:?} {encoding:?}");
    }
    let bytes = written(&view, Format::Msh, Encoding::Usual).unwrap();
    assert_eq!(io::read_bytes(&bytes, Format::Msh, std::path::Path::new("x")).unwrap(), cached);
}

#[test]
fn cells_of_any_number_of_nodes_are_written() {
    let (model, fragments) = two_sides();
    let view = Merged::new(model, fragments).unwrap();
    let cached = TriMesh::from_view(&view);
    for (format, encoding) in FORMATS {
        match (written(&view, format, encoding), format) {
            (Err(error), Format::Msh) => assert!(error.to_string().contains("cell 2 has 5 corners"), "{error}"),
            (Ok(bytes), Format::Vtu) => {
                let text = String::from_utf8(bytes).unwrap();
                let types = "Name=\"types\" format=\"ascii\">\n9 5 7\n";
                assert!(encoding == Encoding::Binary || text.contains(types), "{text}");
            }
            (Ok(bytes), _) => {
                let read = io::read_bytes(&bytes, format, std::path::Path::new("x")).unwrap();
                assert_eq!((read.nodes.len(), read.triangles.len()), (6, 6), "{format:?}");
                assert_abs_diff_eq!(read.area(), cached.area(), epsilon = 1e-6);
                assert!(
                    format == Format::StlBinary || format == Format::StlAscii || read.triangles == cached.triangles
                );
            }
            (Err(error), _) => panic!("{format:?}: {error}"),
        }
    }
    let (model, fragments) = turned(5, 4, false);
    let quads = Merged::new(model, fragments).unwrap();
    let text = String::from_utf8(written(&quads, Format::Msh, Encoding::Text).unwrap()).unwrap();
    assert!(text.contains("\n2 1 3 20\n"), "{text}");
}

/// Numbers of more than 16 bits are kept, and read, otherwise than those of small fragments; borders of many nodes too.
#[test]
fn large_fragments_come_back() {
    let mut mesh = torus(1100, 70);
    let across: Vec<[u32; 2]> = (0..70).map(|j| [1100 * j, 1100 * ((j + 1) % 70)]).collect();
    let along: Vec<[u32; 2]> = (0..1100).map(|i| [i, (i + 1) % 1100]).collect();
    // a small fragment beside it: both kinds in one mesh
    mesh.labels = (0..154_000).map(|t| u32::from(t % 2200 < 40 && t < 22_000)).collect();
    mesh.faces = ["large", "small"].map(String::from).to_vec();
    let cut = from_mesh(&mesh, &[across, along].concat(), &[]).unwrap();
    let kinds = |f: crate::model::FaceView| matches!(f.cells(), Cells::ShortTriangles(_));
    let short: Vec<bool> = cut.fragments.faces().map(kinds).collect();
    assert!(short.contains(&true) && short.contains(&false), "{short:?}");
    let view = merged(&cut);
    assert_eq!(together(&cut, &view, &mesh), mesh);
    let (m, arrays) = (view.cell_count(), TriMesh::from_view(&view).triangles);
    assert!((0..m).all(|j| view.triangle(j) == Some(arrays[j]) && view.cell(j).eq(arrays[j])));
    let mut found = Vec::new();
    view.triangles_at(&(0..m as u32).collect::<Vec<_>>(), &mut found);
    assert_eq!(found, arrays);
}
