//! Faces added, removed and replaced in any order: the merged mesh is the one merged from scratch.

use glam::DVec3;
use proptest::prelude::*;

use super::tests::{consistent, two_sides};
use super::{Addition, Detached, Merged, Replacement};
use crate::mesh::{Group, MeshView, TriMesh};
use crate::model::tests::torus;
use crate::model::{
    BorderNodes, Cells, Coedge, Edge, EdgeFragment, Face, FaceFragment, Fragments, Loop, Model, Vertex, from_mesh,
};

/// Everything that is merged, in lists that are edited naively.
struct Lists {
    names: Vec<String>,
    groups: Vec<Group>,
    vertices: Vec<DVec3>,
    edges: Vec<(Edge, EdgeFragment)>,
    faces: Vec<Detached>,
}

impl Lists {
    fn of(view: &Merged) -> Self {
        let (model, fragments) = (view.model(), view.fragments());
        let edges = model.edges.iter().cloned().enumerate().map(|(e, edge)| (edge, fragments.edge(e))).collect();
        let faces = model.faces.iter().cloned().zip(fragments.faces());
        Self {
            names: model.names.clone(),
            groups: model.groups.clone(),
            vertices: fragments.vertices().to_vec(),
            edges,
            faces: faces.map(|(face, mesh)| Detached { face, fragment: mesh.to_fragment() }).collect(),
        }
    }

    fn merged(&self) -> Merged {
        let model = Model {
            names: self.names.clone(),
            groups: self.groups.clone(),
            vertices: vec![Vertex::default(); self.vertices.len()],
            edges: self.edges.iter().map(|e| e.0.clone()).collect(),
            faces: self.faces.iter().map(|f| f.face.clone()).collect(),
            ..Model::default()
        };
        let mut fragments = Fragments::new(self.vertices.clone());
        self.edges.iter().for_each(|e| fragments.push_edge(&e.1).unwrap());
        self.faces.iter().for_each(|f| fragments.push_face(&f.fragment).unwrap());
        Merged::new(model, fragments).unwrap()
    }
}

/// The edited mesh is the one merged from scratch, in every number and however it is read; each face is in one shell.
fn same(view: &Merged, lists: &Lists) {
    let scratch = lists.merged();
    assert_eq!(TriMesh::from_view(view), TriMesh::from_view(&scratch));
    consistent(view);
    for (f, face) in view.fragments().faces().enumerate() {
        for v in 0..face.nodes().count() as u32 {
            assert_eq!(view.local_to_global(f as u32, v), scratch.local_to_global(f as u32, v));
        }
    }
    for i in 0..view.node_count() {
        assert_eq!(view.place_of_node(i), scratch.place_of_node(i));
    }
    assert_eq!(view.fragments().mismatches(view.model()), []);
    let mut of: Vec<u32> = view.model().shells.iter().flat_map(|s| s.faces.clone()).collect();
    of.sort_unstable();
    assert_eq!(of, (0..view.model().faces.len() as u32).collect::<Vec<_>>());
}

/// A face with one more node, in the middle of one of its triangles.
fn with_a_node(Detached { face, fragment }: &Detached, at: usize) -> Option<FaceFragment> {
    let view = fragment.view();
    let corners: Vec<[u32; 3]> =
        (0..view.cells().len()).map(|j| view.cells().corners(j).as_ref().try_into().ok()).collect::<Option<_>>()?;
    let mut nodes: Vec<DVec3> = view.nodes().copied().collect();
    let (k, border) = (at % corners.len(), view.border().len());
    let new = nodes.len() as u32;
    let [a, b, c] = corners[k];
    nodes.push([a, b, c].map(|v| nodes[v as usize]).into_iter().sum::<DVec3>() / 3.0);
    let mut triangles = corners;
    triangles[k] = [a, b, new];
    triangles.extend([[b, c, new], [c, a, new]]);
    let mut counts = view.stretches();
    let of_loop = |l: &Loop| match l {
        // A point has a stretch, too, which nobody asks for.
        Loop::Vertex(_) => counts.next().map_or(Vec::new(), |_| Vec::new()),
        Loop::Edges(list) => counts.by_ref().take(list.len()).collect::<Vec<u32>>(),
    };
    let segments: Vec<Vec<u32>> = face.loops.iter().map(of_loop).collect();
    FaceFragment::new(nodes, Cells::Triangles(&triangles), &BorderNodes::First(border as u32), &segments).ok()
}

/// A triangle of its own, with everything new.
fn lone(view: &Merged, at: f64) -> Addition {
    let [v, e, _] = view.fragments().counts().map(|n| n as u32);
    let p = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| x + DVec3::new(at, at, 9.0));
    let c = |k: u32| Coedge { edge: e + k, reversed: false };
    let edge = |k: usize| {
        let ends = [v + k as u32, v + (k as u32 + 1) % 3];
        (Edge { ends, ..Edge::default() }, EdgeFragment::new(vec![p[k], p[(k + 1) % 3]]).unwrap())
    };
    let mesh = FaceFragment::new(p.to_vec(), Cells::Triangles(&[[0, 1, 2]]), &BorderNodes::First(3), &[[1, 1, 1]]);
    let face = Face {
        label: view.model().names.len() as u32,
        loops: vec![Loop::Edges((0..3).map(c).collect())],
        ..Face::default()
    };
    Addition {
        names: vec![format!("lone at {at}")],
        vertices: p.map(|p| (Vertex::default(), p)).to_vec(),
        edges: (0..3).map(edge).collect(),
        faces: vec![(face, mesh.unwrap())],
    }
}

/// Where each triangle is, whatever its nodes' numbers.
fn places(view: &Merged) -> Vec<[DVec3; 3]> {
    let mesh = TriMesh::from_view(view);
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

proptest! {
    #[test]
    fn any_edits_give_the_mesh_merged_from_scratch(
        a in 3u32..9, b in 3u32..9, patches in 1u32..7,
        edits in prop::collection::vec((0u32..7, 0usize..1000), 1..24),
    ) {
        let mut mesh = torus(a, b);
        let m = mesh.triangles.len() as u32;
        mesh.labels = (0..m).map(|t| t * patches / m).collect();
        mesh.faces = (0..patches).map(|i| format!("f{i}")).collect();
        mesh.groups = vec![Group { name: "g".into(), faces: vec![0] }];
        let cut = from_mesh(&mesh, &[], &[]).unwrap();
        let mut view = Merged::new(cut.model, cut.fragments).unwrap();
        let mut lists = Lists::of(&view);
        let mut away: Vec<Detached> = Vec::new();
        for (kind, k) in edits {
            let count = lists.faces.len();
            match kind {
                0 | 1 if count > 0 => {
                    let gone = view.remove((k % count) as u32).unwrap();
                    prop_assert_eq!(&gone, &lists.faces.remove(k % count));
                    away.push(gone);
                }
                2 | 3 if !away.is_empty() => {
                    let back = away.swap_remove(k % away.len());
                    let faces = vec![(back.face.clone(), back.fragment.clone())];
                    view.insert(Addition { faces, ..Addition::default() }).unwrap();
                    lists.faces.push(back);
                }
                4 if count > 0 => {
                    let f = k % count;
                    if let Some(mesh) = with_a_node(&lists.faces[f], k) {
                        view.replace(Replacement { faces: vec![(f as u32, mesh.clone())], ..Replacement::default() }).unwrap();
                        lists.faces[f].fragment = mesh;
                    }
                }
                5 => {
                    let new = lone(&view, k as f64);
                    lists.names.extend(new.names.clone());
                    lists.vertices.extend(new.vertices.iter().map(|v| v.1));
                    lists.edges.extend(new.edges.clone());
                    lists.faces.extend(new.faces.iter().cloned().map(|(face, fragment)| Detached { face, fragment }));
                    view.insert(new).unwrap();
                }
                6 => {
                    let before = places(&view);
                    let counts = view.fragments().counts();
                    let went = view.drop_unused().unwrap();
                    prop_assert_eq!(places(&view), before);
                    let now = view.fragments().counts();
                    prop_assert_eq!(counts[0] + counts[1], now[0] + now[1] + went);
                    prop_assert!(view.model().faces_of_edges().iter().all(|f| !f.is_empty()));
                    // What was taken away knows other edges.
                    away.clear();
                    lists = Lists::of(&view);
                }
                _ => {}
            }
            same(&view, &lists);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let (model, fragments) = two_sides();
    let mut view = Merged::new(model, fragments).unwrap();
    let before = (TriMesh::from_view(&view), view.model().clone());
    let mut refused = |change: &dyn Fn(&mut Addition)| {
        let mut what = lone(&view, 5.0);
        change(&mut what);
        let error = view.insert(what).unwrap_err();
        assert_eq!((TriMesh::from_view(&view), view.model().clone()), before);
        assert_eq!((error.exit_code(), view.fragments().counts()), (3, [4, 5, 2]));
        consistent(&view);
        error.to_string()
    };
    assert!(refused(&|a| a.names.clear()).contains("face 2"));
    assert!(refused(&|a| a.edges[1].0.ends[1] = 99).contains("vertex 99"));
    assert!(refused(&|a| a.vertices[0].1.x += 1e-9).starts_with("edge 5"));
    let longer = EdgeFragment::new([5.0, 5.5, 6.0].map(|x| DVec3::new(x, 5.0, 9.0)).to_vec()).unwrap();
    assert!(refused(&|a| a.edges[0].1 = longer.clone()).starts_with("edge 5: face 2 is not node-matched"));
    assert!(refused(&|a| a.faces[0].0.loops.clear()).contains("face 2"));
    assert!(view.remove(2).unwrap_err().to_string().contains("face 2"));
    assert_eq!(TriMesh::from_view(&view), before.0);
}

/// A face that comes leaves all other fragments where they are, as long as nothing is packed.
#[test]
fn faces_that_come_touch_no_others() {
    let mut mesh = torus(40, 30);
    mesh.labels = (0..2400).map(|t| t / 400).collect();
    mesh.faces = (0..6).map(|i| i.to_string()).collect();
    let cut = from_mesh(&mesh, &[], &[]).unwrap();
    let mut view = Merged::new(cut.model, cut.fragments).unwrap();
    let spans = |view: &Merged| (0..6).map(|f| view.fragments().face_span(f)).collect::<Vec<_>>();
    let before = spans(&view);
    view.insert(lone(&view, 1.0)).unwrap();
    assert_eq!(spans(&view), before);
    let gone = view.remove(2).unwrap();
    view.insert(Addition { faces: vec![(gone.face, gone.fragment)], ..Addition::default() }).unwrap();
    let kept: Vec<_> = before.iter().enumerate().filter(|x| x.0 != 2).map(|x| *x.1).collect();
    assert_eq!(spans(&view)[..5], kept);
}
