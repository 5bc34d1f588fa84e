//! Defects and intersections of meshes small enough to know by heart.

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::Run;

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn tetra() -> TriMesh {
    TriMesh::new(
        vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    )
}

/// Two meshes side by side; node numbers of the second are shifted.
fn both(a: &TriMesh, b: &TriMesh, shift: DVec3) -> TriMesh {
    let n = a.nodes.len() as u32;
    let mut nodes = a.nodes.clone();
    nodes.extend(b.nodes.iter().map(|p| *p + shift));
    let mut triangles = a.triangles.clone();
    triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + n)));
    TriMesh::new(nodes, triangles)
}

/// Makes node `b` node `a`.
fn glue(m: &mut TriMesh, a: u32, b: u32) {
    m.triangles.iter_mut().flatten().for_each(|v| {
        if *v == b {
            *v = a
        }
    });
    m.drop_unused_nodes();
}

fn grid_torus(n: u32, m: u32) -> TriMesh {
    let mut nodes = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (s, t) = (
                f64::from(i) / f64::from(n) * std::f64::consts::TAU,
                f64::from(j) / f64::from(m) * std::f64::consts::TAU,
            );
            let r = 2.0 + 0.7 * t.cos();
            nodes.push(v(r * s.cos(), r * s.sin(), 0.7 * t.sin()));
        }
    }
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriMesh::new(nodes, triangles)
}

fn hits(m: &TriMesh) -> usize {
    self_intersections(m, &Run::new()).unwrap().len()
}

#[test]
fn good_meshes_have_no_defects() {
    for (m, euler, genus) in [(tetra(), 2, 0), (grid_torus(12, 8), 0, 1)] {
        let d = m.defects();
        assert_eq!(d, Defects::default());
        assert_eq!(m.topology(&d), Topology { components: 1, euler, genus: Some(genus) });
        assert!(m.volume() > 0.0);
        assert_eq!(hits(&m), 0);
    }
    let two = both(&tetra(), &tetra(), v(2.0, 0.0, 0.0));
    assert_eq!(two.topology(&two.defects()), Topology { components: 2, euler: 4, genus: Some(0) });
}

#[test]
fn each_defect_is_found_where_it_is() {
    let mut m = tetra();
    m.triangles.pop();
    m.labels.pop();
    assert_eq!(m.defects().open_edges, [[0, 2], [0, 3], [2, 3]]);
    let mut m = tetra();
    m.triangles[2].swap(0, 1);
    assert_eq!(m.defects().misoriented_edges, [[1, 2], [1, 3], [2, 3]]);
    let mut m = both(&tetra(), &tetra(), v(0.0, 0.0, 0.0));
    m.nodes[5..].iter_mut().for_each(|p| *p = -*p);
    glue(&mut m, 0, 4);
    assert_eq!(m.defects().nonmanifold_nodes, [0]);
    let mut m = both(&tetra(), &tetra(), v(0.0, 0.0, 0.0));
    m.nodes[6] = v(0.0, -1.0, 0.0);
    m.nodes[7] = v(0.0, 0.0, -1.0);
    glue(&mut m, 0, 4);
    glue(&mut m, 1, 4);
    let d = m.defects();
    assert_eq!(d.nonmanifold_edges, [[0, 1]]);
    assert!(d.is_closed() && !d.is_manifold());
    let mut m = tetra();
    m.triangles.push([3, 1, 0]);
    m.labels.push(0);
    m.nodes.push(v(9.0, 9.0, 9.0));
    let d = m.defects();
    assert_eq!((d.duplicate_triangles, d.unused_nodes), (vec![4], vec![4]));
    let m = TriMesh::new(vec![v(0.0, 0.0, 0.0), v(1.0, 1.0, 1.0), v(2.0, 2.0, 2.0)], vec![[0, 1, 2], [0, 1, 1]]);
    assert_eq!(m.defects().degenerate_triangles, [0, 1]);
    // a strip closed with a half twist
    let strip: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
    let nodes = (0..5).map(|i| v(f64::from(i).cos(), f64::from(i).sin(), f64::from(i * i))).collect();
    assert!(!TriMesh::new(nodes, strip).defects().is_oriented());
}

#[test]
fn invalid_meshes_are_refused() {
    let mut m = tetra();
    m.nodes[2].y = f64::NAN;
    assert!(m.validate().unwrap_err().to_string().contains("node 2"));
    let mut m = tetra();
    m.triangles[1][0] = 9;
    assert!(m.validate().unwrap_err().to_string().contains("triangle 1"));
    let mut m = tetra();
    m.labels[3] = 5;
    assert!(m.validate().is_err());
    assert!(tetra().validate().is_ok());
}

#[test]
fn intersections_of_pairs() {
    let pair = |p: [[f64; 3]; 3], q: [[f64; 3]; 3]| {
        let nodes = p.iter().chain(&q).map(|a| DVec3::from_array(*a)).collect();
        hits(&TriMesh::new(nodes, vec![[0, 1, 2], [3, 4, 5]])) == 1
    };
    let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    assert!(pair(t, [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [3.0, 3.0, 1.0]]), "pierced");
    assert!(!pair(t, [[1.0, 1.0, 0.5], [1.0, 1.0, 1.0], [3.0, 3.0, 1.0]]), "above");
    assert!(pair(t, [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [3.0, 3.0, 1.0]]), "touched from above");
    assert!(pair(t, [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]]), "inside, coplanar");
    assert!(pair(t, [[-1.0, -1.0, 0.0], [9.0, -1.0, 0.0], [-1.0, 9.0, 0.0]]), "around, coplanar");
    assert!(!pair(t, [[5.0, 5.0, 0.0], [9.0, 5.0, 0.0], [5.0, 9.0, 0.0]]), "beside, coplanar");
    // Sheets may touch in a node each has for itself, not along an edge, and not beyond the point.
    assert!(!pair(t, [[4.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 1.0, 1.0]]), "same place, other node");
    assert!(pair(t, [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0], [9.0, 1.0, 1.0]]), "an edge at the same place");
    assert!(pair(t, [[4.0, 0.0, 0.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0]]), "same place, and pierced");
    let shared = |extra: [[f64; 3]; 2], second: [u32; 3]| {
        let nodes = t.iter().chain(&extra).map(|a| DVec3::from_array(*a)).collect();
        hits(&TriMesh::new(nodes, vec![[0, 1, 2], second])) == 1
    };
    assert!(!shared([[3.0, 3.0, 1.0], [0.0; 3]], [0, 1, 3]), "hinge");
    assert!(shared([[1.0, 1.0, 0.0], [0.0; 3]], [0, 1, 3]), "folded onto its neighbor");
    assert!(!shared([[1.0, -1.0, 0.0], [0.0; 3]], [1, 0, 3]), "flat neighbor");
    assert!(shared([[3.0, 3.0, -1.0], [1.0, 1.0, 1.0]], [0, 3, 4]), "through from a shared node");
    assert!(!shared([[-1.0, 0.0, -1.0], [-1.0, -1.0, 1.0]], [0, 3, 4]), "away from a shared node");
    assert!(shared([[2.0, 0.0, 0.0], [3.0, 0.0, 3.0]], [0, 3, 4]), "along an edge from a shared node");
}

/// Groups that meet themselves or what is in none are told once, the rest in pairs.
#[test]
fn groups_that_intersect_something() {
    let all = |moves: &[DVec3]| {
        let parts = moves.iter().map(|by| tetra().nodes.into_iter().map(move |p| p + *by));
        let nodes: Vec<DVec3> = parts.flatten().collect();
        let triangles =
            (0..moves.len() as u32).flat_map(|k| tetra().triangles.into_iter().map(move |t| t.map(|v| v + 4 * k)));
        TriMesh::new(nodes, triangles.collect())
    };
    let far = v(9.0, 0.0, 0.0);
    let near = v(0.1, 0.1, 0.1);
    let groups: Vec<u32> = [0, 1, 2, 3, 3].iter().flat_map(|g| [*g; 4]).collect();
    // Of no group; into it; two into each other; one that is two into each other.
    let mesh = all(&[DVec3::ZERO, near, far, far + near, 2.0 * far, 2.0 * far + near]);
    let (bad, pairs) = intersecting_groups(&mesh, &groups, &Run::new()).unwrap();
    assert_eq!((bad, pairs), (vec![true, false, false, true], vec![[1, 2]]));
    let apart = all(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|k| k * far));
    assert_eq!(intersecting_groups(&apart, &groups, &Run::new()).unwrap(), (vec![false; 4], vec![]));
}

proptest! {
    /// Any renumbering of nodes and triangles finds the same pairs; a shift apart finds none.
    #[test]
    fn intersections_do_not_depend_on_order(dx in -1.2f64..1.2, dy in -1.2f64..1.2, dz in -1.2f64..1.2, turn in 0usize..3) {
        let m = both(&tetra(), &tetra(), v(dx, dy, dz));
        let count = hits(&m);
        let mut n = m.clone();
        n.triangles.reverse();
        n.triangles.iter_mut().for_each(|t| t.rotate_left(turn));
        prop_assert_eq!(count, hits(&n));
        // tetrahedra x + y + z <= 1 in the positive octant: their insides meet iff the shifted one reaches into it
        let reach = dx.max(0.0) + dy.max(0.0) + dz.max(0.0) - (dx.min(0.0) + dy.min(0.0) + dz.min(0.0));
        if dx.abs().max(dy.abs()).max(dz.abs()) > 1.0 {
            prop_assert_eq!(count, 0);
        } else if reach > 1e-3 && dx > 0.0 && dy > 0.0 && dz > 0.0 && dx + dy + dz < 1.0 {
            prop_assert!(count > 0);
        }
    }
}
