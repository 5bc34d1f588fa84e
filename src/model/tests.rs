//! Models and fragments: the rules, the sets of \[LAZ\], cutting meshes along borders.

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::mesh::TriMesh;

/// A torus of `a` by `b` quadrilaterals, each two triangles.
pub(crate) fn torus(a: u32, b: u32) -> TriMesh {
    let turn = |i: u32, n: u32| (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
    let mut nodes = Vec::new();
    for j in 0..b {
        for i in 0..a {
            let ((su, cu), (sv, cv)) = (turn(i, a), turn(j, b));
            nodes.push(DVec3::new((3.0 + cv) * cu, (3.0 + cv) * su, sv));
        }
    }
    let at = |i: u32, j: u32| i % a + j % b * a;
    let mut triangles = Vec::new();
    for j in 0..b {
        for i in 0..a {
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    TriMesh::new(nodes, triangles)
}

fn tetrahedron() -> TriMesh {
    let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    TriMesh::new(nodes, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

fn labeled(mut mesh: TriMesh, label: impl Fn(usize) -> u32) -> TriMesh {
    mesh.labels = (0..mesh.triangles.len()).map(label).collect();
    let faces = mesh.labels.iter().max().map_or(1, |l| l + 1);
    mesh.faces = (0..faces).map(|i| format!("face {i}")).collect();
    mesh
}

/// Checks what every cut promises.
fn sound(cut: &Cut) {
    let broken: Vec<_> = cut.model.check().into_iter().filter(Violation::forbids_merge).collect();
    assert!(broken.is_empty(), "{broken:?}");
    assert_eq!(cut.fragments.mismatches(&cut.model), []);
}

fn loops(cut: &Cut) -> Vec<usize> {
    cut.model.faces.iter().map(|f| f.loops.len()).collect()
}

// ------------------------------------------------------------------------------------------------------------- rules

/// A square and its outside: two faces on four edges.
fn square() -> Model {
    let edges = (0..4).map(|i| Edge { ends: [i, (i + 1) % 4], ..Edge::default() }).collect();
    let forward: Vec<_> = (0..4).map(|edge| Coedge { edge, reversed: false }).collect();
    let back: Vec<_> = (0..4).rev().map(|edge| Coedge { edge, reversed: true }).collect();
    let face = |list| Face { loops: vec![Loop::Edges(list)], ..Face::default() };
    Model {
        vertices: vec![Vertex::default(); 4],
        edges,
        faces: vec![face(forward), face(back)],
        shells: vec![Shell { faces: vec![0, 1] }],
        solids: vec![Solid { name: "part".into(), shells: vec![0] }],
        names: vec!["face".into()],
        ..Model::default()
    }
}

fn coedges(model: &mut Model, face: usize) -> &mut Vec<Coedge> {
    match &mut model.faces[face].loops[0] {
        Loop::Edges(list) => list,
        Loop::Vertex(_) => panic!("not a loop of edges"),
    }
}

#[test]
fn a_good_model_breaks_no_rule() {
    assert_eq!(square().check(), []);
    let nothing: Model = Model::default();
    assert_eq!(nothing.check(), []);
}

#[test]
fn every_rule_broken_alone_is_reported_alone() {
    use Violation::*;
    let at = Item::Loop { face: 0, index: 0 };
    let alone = |change: &dyn Fn(&mut Model), what: &[Violation]| {
        let mut model = square();
        change(&mut model);
        let found = model.check();
        assert_eq!(found, what);
        assert!(found.iter().all(|v| !v.to_string().is_empty()));
    };
    // A face less or a loop changed opens the solid: that is another rule's matter.
    let sheet = |change: &dyn Fn(&mut Model), what: &[Violation]| {
        alone(
            &|m| {
                m.solids.clear();
                change(m);
            },
            what,
        );
    };
    let forward = |edge| Coedge { edge, reversed: false };
    let missing = |of, what| Missing { of, what };
    alone(
        &|m| (m.edges[0].ends[1], m.edges[1].ends[0]) = (9, 9),
        &[missing(Item::Edge(0), Item::Vertex(9)), missing(Item::Edge(1), Item::Vertex(9))],
    );
    sheet(&|m| coedges(m, 0)[2].edge = 7, &[missing(at, Item::Edge(7))]);
    sheet(&|m| m.faces[0].loops[0] = Loop::Vertex(4), &[missing(at, Item::Vertex(4))]);
    alone(&|m| m.faces[1].label = 3, &[missing(Item::Face(1), Item::Name(3))]);
    alone(&|m| m.shells[0].faces.push(2), &[missing(Item::Shell(0), Item::Face(2))]);
    alone(&|m| m.solids[0].shells.push(1), &[missing(Item::Solid(0), Item::Shell(1))]);
    let group = crate::mesh::Group { name: "g".into(), faces: vec![1] };
    alone(&|m| m.groups.push(group.clone()), &[missing(Item::Group(0), Item::Name(1))]);
    sheet(&|m| coedges(m, 0).clear(), &[EmptyLoop { at }]);
    sheet(&|m| coedges(m, 0).truncate(3), &[Gap { at, coedge: 2 }]);
    // around twice
    let twice: Vec<Violation> = (0..4).map(|edge| EdgeRepeated { at, edge }).collect();
    sheet(&|m| coedges(m, 0).extend((0..4).map(forward)), &twice);
    let closed = |m: &mut Model, pole| {
        m.edges.push(Edge { ends: [1, 1], pole, ..Edge::default() });
        coedges(m, 0).insert(1, forward(4));
    };
    sheet(&|m| closed(m, false), &[ClosedEdgeNotAlone { at, edge: 4 }]);
    // at a pole that is how it is, with a seam or without
    sheet(&|m| closed(m, true), &[]);
    alone(&|m| m.edges[0].pole = true, &[Pole { edge: 0 }]);
    let twice = |m: &mut Model| {
        closed(m, true);
        coedges(m, 1).insert(3, Coedge { edge: 4, reversed: true });
    };
    sheet(&twice, &[Pole { edge: 4 }]);
    let two: Vec<Violation> = (0..4).map(|edge| EdgeOverused { edge, forward: 2, reversed: 0 }).collect();
    sheet(&|m| m.faces[1] = m.faces[0].clone(), &two);
    alone(&|m| m.shells.push(Shell { faces: vec![1] }), &[FaceInShells { face: 1, shells: 2 }]);
    sheet(&|m| m.shells.clear(), &[0, 1].map(|face| FaceInShells { face, shells: 0 }));
    alone(&|m| m.solids.push(m.solids[0].clone()), &[ShellInSolids { shell: 0, solids: 2 }]);
    let open: Vec<Violation> = (0..4).map(|edge| OpenSolid { solid: 0, shell: 0, edge }).collect();
    let lid = |m: &mut Model| {
        m.faces.pop();
        m.shells[0].faces.pop();
    };
    alone(&lid, &open);
    alone(&|m| m.solids[0].shells.clear(), &[EmptySolid { solid: 0 }]);
}

#[test]
fn a_seam_is_no_repetition() {
    // the side of a cylinder: up the seam, around the top, down, around the bottom
    let ends = [[0, 1], [1, 1], [0, 0]];
    let c = |edge, reversed| Coedge { edge, reversed };
    let list = vec![c(2, false), c(0, false), c(1, true), c(0, true)];
    let model: Model = Model {
        vertices: vec![Vertex::default(); 2],
        edges: ends.map(|ends| Edge { ends, ..Edge::default() }).to_vec(),
        faces: vec![Face { loops: vec![Loop::Edges(list)], ..Face::default() }],
        shells: vec![Shell { faces: vec![0] }],
        names: vec!["side".into()],
        ..Model::default()
    };
    assert_eq!(model.check(), []);
    assert_eq!(model.open_edges(0), [1, 2]);
}

// -------------------------------------------------------------------------------------------------------------- sets

#[test]
fn the_sets_of_the_papers_figure_2() {
    let border = vec![4, 0, 1, 9, 7, 5, 3];
    let sets = BorderNodes::listed(border.clone(), 10).unwrap();
    let bn: Vec<u32> = (0..7).map(|x| sets.node(x)).collect();
    let inner: Vec<u32> = (7..10).map(|x| sets.node(x)).collect();
    assert_eq!((bn, inner), (border, vec![2, 6, 8]));
    let places: Vec<i64> = (0..10).map(|v| i64::from(sets.place(v))).collect();
    let bnn: Vec<i64> = places.iter().map(|p| if *p < 7 { *p } else { -1 }).collect();
    let inn: Vec<i64> = places.iter().map(|p| if *p < 7 { -1 } else { p - 7 }).collect();
    assert_eq!(bnn, [1, 2, -1, 6, 0, 5, -1, 4, -1, 3]);
    assert_eq!(inn, [-1, -1, 0, -1, -1, -1, 1, -1, 2, -1]);
}

#[test]
fn a_grids_border_is_a_function() {
    for (a, b) in (1..5).flat_map(|a| (1..5).map(move |b| (a, b))) {
        let sets = BorderNodes::Grid([a, b]);
        let count = (a + 1) * (b + 1);
        let on_border = |v: u32| [0, a].contains(&(v % (a + 1))) || [0, b].contains(&(v / (a + 1)));
        let mut steps = Vec::new();
        for place in 0..count {
            let v = sets.node(place);
            assert_eq!(sets.place(v), place, "grid {a} x {b}");
            assert_eq!(on_border(v), (place as usize) < sets.len());
            let next = if place as usize + 1 == sets.len() { 0 } else { place + 1 };
            if on_border(v) {
                steps.push(i64::from(sets.node(next)) - i64::from(v));
            }
        }
        // right, up, left, down: one neighbor after the other
        let row = i64::from(a) + 1;
        let runs = [(1, a), (row, b), (-1, a), (-row, b)];
        let expected: Vec<i64> = runs.iter().flat_map(|(d, n)| std::iter::repeat_n(*d, *n as usize)).collect();
        assert_eq!(steps, expected);
    }
}

#[test]
fn bad_fragments_are_refused() {
    let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let make = |cells: Cells, border, loops: &[Vec<u32>]| FaceFragment::new(nodes.clone(), cells, &border, loops);
    let one = || Cells::Triangles(&[[0, 1, 2]]);
    assert!(make(one(), BorderNodes::First(3), &[vec![1, 2]]).is_ok());
    assert!(make(Cells::Triangles(&[[0, 1, 3]]), BorderNodes::First(3), &[vec![3]]).is_err());
    assert!(make(one(), BorderNodes::First(4), &[vec![4]]).is_err());
    assert!(make(one(), BorderNodes::First(3), &[vec![2]]).is_err());
    assert!(make(one(), BorderNodes::First(3), &[vec![0, 3]]).is_err());
    assert!(make(one(), BorderNodes::First(3), &[vec![u32::MAX, 4]]).is_err());
    assert!(make(Cells::Grid([1, 1]), BorderNodes::Grid([1, 1]), &[vec![4]]).is_err());
    let polygons =
        |ends: &[u32], corners: &[u32]| make(Cells::Polygons { ends, corners }, BorderNodes::First(3), &[vec![3]]);
    assert!(polygons(&[3], &[0, 1, 2]).is_ok());
    assert!(polygons(&[2], &[0, 1]).is_err());
    assert!(polygons(&[3, 1], &[0, 1, 2]).is_err());
    assert!(polygons(&[9], &[0, 1, 2]).is_err());
    assert!(polygons(&[3], &[0, 1, 2, 2]).is_err());
    let lists =
        |nodes: &[u32], places: &[u32]| BorderNodes::Listed { nodes: nodes.into(), places: places.into(), border: 3 };
    assert!(make(one(), lists(&[2, 0, 1], &[1, 2, 0]), &[vec![3]]).is_ok());
    assert!(make(one(), lists(&[2, 0, 1], &[1, 1, 0]), &[vec![3]]).is_err());
    assert!(BorderNodes::listed(vec![0, 0], 3).is_err());
    assert!(BorderNodes::listed(vec![3], 3).is_err());
    assert!(EdgeFragment::new(vec![DVec3::ZERO]).is_err());
}

#[test]
fn what_is_left_of_cells_at_a_pole_goes() {
    // three quadrilaterals side by side whose upper four nodes are one point
    let mut nodes: Vec<DVec3> = (0..4).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    nodes.extend([DVec3::Y; 4]);
    let mut fan = FaceFragment::grid([3, 1], nodes, &[3, 1, 3, 1]).unwrap();
    assert_eq!(fan.collapse_poles(), 0);
    // the nodes above stand from right to left on the border
    assert_eq!(fan.view().cells(), Cells::Triangles(&[[0, 1, 6], [1, 2, 5], [2, 3, 4]]));
    // as triangles: every other one has two corners at the pole
    let mut nodes: Vec<DVec3> = (0..4).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    nodes.extend([DVec3::Y; 4]);
    let halves: Vec<[u32; 3]> = (0..3).flat_map(|i| [[i, i + 1, i + 5], [i, i + 5, i + 4]]).collect();
    let border = BorderNodes::listed(vec![0, 1, 2, 3, 7, 6, 5, 4], 8).unwrap();
    let mut fan = FaceFragment::new(nodes, Cells::Triangles(&halves), &border, &[[3, 1, 3, 1]]).unwrap();
    assert_eq!(fan.collapse_poles(), 3);
    assert_eq!(fan.view().cells().len(), 3);
}

#[test]
fn mismatches_name_the_edge() {
    let mesh = labeled(torus(8, 6), |t| u32::from(t >= 48));
    let good = from_mesh(&mesh, &[], &[]).unwrap();
    assert_eq!(good.model.edges.len(), 2);
    let mut moved = good.clone();
    let mut face = moved.fragments.face(1).to_fragment();
    face.move_nodes(|nodes| nodes[3].x += 1e-12);
    moved.fragments.set_face(1, &face).unwrap();
    let found = moved.fragments.mismatches(&moved.model);
    assert!(matches!(found[..], [Mismatch::Nodes { face: 1, edge: _ }]), "{found:?}");
    let mut cut = good.clone();
    let mut nodes = cut.fragments.edge(0).nodes().to_vec();
    nodes.remove(3);
    cut.fragments.set_edge(0, &EdgeFragment::new(nodes).unwrap()).unwrap();
    let found = cut.fragments.mismatches(&cut.model);
    let is = |m: &Mismatch, f| *m == Mismatch::Segments { face: f, edge: 0, of_face: 8, of_edge: 7 };
    assert!(found.len() == 2 && is(&found[0], 0) && is(&found[1], 1), "{found:?}");
    let mut end = good.clone();
    end.fragments.set_vertex(0, end.fragments.vertices()[0] + DVec3::Z);
    assert!(matches!(end.fragments.mismatches(&end.model)[..], [Mismatch::EdgeEnd { vertex: 0, .. }, ..]));
    let mut few = good;
    few.fragments.pop_face();
    assert!(matches!(few.fragments.mismatches(&few.model)[..], [Mismatch::Counts { .. }]));
}

// ------------------------------------------------------------------------------------------------------------ cutting

#[test]
fn a_closed_surface_without_borders_is_a_face_without_loops() {
    let cut = from_mesh(&torus(8, 6), &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((loops(&cut), cut.model.vertices.len(), cut.model.edges.len()), (vec![0], 0, 0));
    assert_eq!(cut.model.shells, [Shell { faces: vec![0] }]);
    assert_eq!(cut.fragments.face(0).inner().len(), 48);
}

#[test]
fn a_tetrahedron_of_four_faces() {
    let cut = from_mesh(&labeled(tetrahedron(), |t| t as u32), &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((cut.model.vertices.len(), cut.model.edges.len(), loops(&cut)), (4, 6, vec![1; 4]));
    assert_eq!(cut.model.check(), []);
    assert_eq!(cut.model.open_edges(0), [] as [u32; 0]);
}

#[test]
fn closed_borders_and_rings() {
    let cut = from_mesh(&labeled(torus(8, 6), |t| u32::from(t >= 48)), &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((cut.model.vertices.len(), cut.model.edges.len(), loops(&cut)), (2, 2, vec![2, 2]));
    assert!(cut.model.edges.iter().all(Edge::is_closed));
}

#[test]
fn seams_slits_points_and_pinches() {
    let seam: Vec<[u32; 2]> = (0..8).map(|i| [i, (i + 1) % 8]).collect();
    let cross: Vec<[u32; 2]> = (0..6).map(|j| [8 * j, 8 * ((j + 1) % 6)]).collect();
    // a torus cut open along two circles: one loop around, each edge twice, closed edges in two halves
    let cut = from_mesh(&torus(8, 6), &[seam.clone(), cross].concat(), &[]).unwrap();
    sound(&cut);
    assert_eq!((loops(&cut), cut.model.edges.len(), cut.model.vertices.len()), (vec![1], 4, 3));
    assert_eq!(cut.fragments.face(0).border().len(), 2 * (8 + 6));
    // one circle: a tube, which has two loops along the same edge
    let cut = from_mesh(&torus(8, 6), &seam, &[]).unwrap();
    sound(&cut);
    assert_eq!((loops(&cut), cut.model.edges.len()), (vec![2], 1));
    // a slit
    let cut = from_mesh(&torus(8, 6), &seam[..3], &[]).unwrap();
    sound(&cut);
    assert_eq!((loops(&cut), cut.model.edges.len(), cut.model.vertices.len()), (vec![1], 1, 2));
    assert_eq!(cut.fragments.face(0).border().len(), 6);
    // a node to keep
    let cut = from_mesh(&torus(8, 6), &[[3, 40], [5, 99]], &[17]).unwrap();
    sound(&cut);
    assert_eq!(cut.model.faces[0].loops, [Loop::Vertex(0)]);
    assert_eq!(cut.fragments.vertices(), [torus(8, 6).nodes[17]]);
    // two disks that touch in a node
    let pair = TriMesh::new(vec![DVec3::ZERO; 5], vec![[0, 1, 2], [0, 3, 4]]);
    let cut = from_mesh(&pair, &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((cut.model.faces.len(), cut.model.shells.len()), (2, 2));
    assert_eq!(cut.nodes.len(), 5);
}

#[test]
fn surfaces_that_are_no_manifold_are_cut_where_they_are_not() {
    // three triangles on one edge, and a flipped neighbor
    let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Y];
    let book = TriMesh::new(nodes.clone(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    let cut = from_mesh(&book, &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((cut.model.faces.len(), cut.nodes.len()), (3, 5));
    let flipped = TriMesh::new(nodes, vec![[0, 1, 2], [0, 1, 3]]);
    let cut = from_mesh(&flipped, &[], &[]).unwrap();
    sound(&cut);
    assert_eq!((cut.model.faces.len(), cut.nodes.len()), (2, 4));
    let degenerate = TriMesh::new(vec![DVec3::ZERO; 3], vec![[0, 1, 1]]);
    assert!(from_mesh(&degenerate, &[], &[]).is_err());
}

proptest! {
    #[test]
    fn any_soup_of_triangles_is_cut_or_refused(
        triangles in prop::collection::vec([0u32..9, 0u32..9, 0u32..9], 1..40),
        labels in prop::collection::vec(0u32..3, 40),
        borders in prop::collection::vec([0u32..10, 0u32..10], 0..9),
        corners in prop::collection::vec(0u32..10, 0..3),
    ) {
        let good: Vec<[u32; 3]> =
            triangles.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let nodes = (0..9).map(|i| DVec3::new(f64::from(i), f64::from(i * i % 7), 0.0)).collect();
        let mut mesh = TriMesh::new(nodes, good);
        mesh.labels = labels[..mesh.triangles.len()].to_vec();
        mesh.faces = vec!["a".into(), "b".into(), "c".into()];
        let cut = from_mesh(&mesh, &borders, &corners).unwrap();
        sound(&cut);
        // every used node once, every triangle once
        let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let mut nodes = cut.nodes.clone();
        nodes.sort_unstable();
        prop_assert_eq!(nodes, used);
        let mut triangles = cut.triangles.clone();
        triangles.sort_unstable();
        prop_assert_eq!(triangles, (0..mesh.triangles.len() as u32).collect::<Vec<_>>());
    }
}
