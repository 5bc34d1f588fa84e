//! Tests of the edit mesh: numbering, refusals, and random edit sequences that must keep the manifold.

use approx::assert_abs_diff_eq;
use proptest::prelude::*;

use super::*;

fn octahedron() -> TriMesh {
    let nodes = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let mut triangles = Vec::new();
    for k in 0..4 {
        triangles.push([k, (k + 1) % 4, 4]);
        triangles.push([(k + 1) % 4, k, 5]);
    }
    TriMesh::new(nodes, triangles)
}

/// A flat sheet of `n` by `n` squares, open on all sides.
fn sheet(n: u32) -> TriMesh {
    let at = |i, j| i * (n + 1) + j;
    let mut nodes = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            nodes.push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    for i in 0..n {
        for j in 0..n {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriMesh::new(nodes, triangles)
}

/// Euler number and number of boundary edges.
fn census(m: &EditMesh) -> (i64, usize) {
    let boundary = m.edges().filter(|&h| m.opposite(h) == NONE).count();
    (m.nodes().count() as i64 - m.edges().count() as i64 + m.triangles().count() as i64, boundary)
}

#[test]
fn numbering_is_as_drawn() {
    let m = EditMesh::new(&sheet(1)).unwrap();
    assert_eq!((m.origin(0), m.target(0), m.apex(0)), (0, 2, 3));
    assert_eq!((next(0), next(2), prev(0), prev(5)), (1, 0, 2, 4));
    assert_eq!(m.opposite(2), 3);
    assert_eq!(m.neighbors(0).collect::<Vec<_>>(), [2, 3, 1]);
    assert_eq!(m.neighbors(2).collect::<Vec<_>>(), [3, 0]);
    assert_eq!(m.valence(0), 3);
    assert_eq!(census(&m), (1, 4));
    m.check().unwrap();
}

#[test]
fn split_then_collapse_restores_the_octahedron() {
    let before = octahedron();
    let mut m = EditMesh::new(&before).unwrap();
    m.set_sharp(0, true);
    let v = m.split_edge(0, DVec3::new(0.5, 0.5, 0.0));
    m.check().unwrap();
    assert_eq!((m.triangle_count(), m.valence(v), census(&m)), (10, 4, (2, 0)));
    assert_eq!(m.edges().filter(|&h| m.is_sharp(h)).count(), 2);
    let h = m.edge_between(v, 0).unwrap();
    assert_eq!((m.origin(h), m.target(h)), (v, 0));
    assert!(m.collapse(h, DVec3::X));
    m.check().unwrap();
    assert_eq!(m.edges().filter(|&h| m.is_sharp(h)).count(), 1);
    m.compact();
    m.check().unwrap();
    let after = m.to_mesh();
    assert_eq!(after.nodes, before.nodes);
    assert_abs_diff_eq!(after.volume(), before.volume(), epsilon = 1e-15);
}

#[test]
fn flip_changes_the_diagonal_and_refuses_what_exists() {
    let mut m = EditMesh::new(&sheet(1)).unwrap();
    assert!(m.flip(2));
    m.check().unwrap();
    assert!(m.edge_between(0, 3).is_none() && m.edge_between(1, 2).is_some());
    // On a tetrahedron every diagonal exists.
    let t =
        TriMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    let mut m = EditMesh::new(&t).unwrap();
    assert!((0..12).all(|h| !m.flip(h)));
    assert!((0..12).all(|h| !m.collapse(h, DVec3::ZERO)));
    assert_eq!(m.to_mesh(), t);
}

#[test]
fn a_pinned_node_and_a_doubled_feature_do_not_collapse() {
    let mut m = EditMesh::new(&sheet(4)).unwrap();
    let h = m.edge_between(12, 13).unwrap();
    m.set_pinned(12, true);
    assert!(!m.can_collapse(h));
    m.set_pinned(12, false);
    assert!(m.can_collapse(h));
    m.set_sharp(next(h), true);
    m.set_sharp(prev(h), true);
    assert!(!m.can_collapse(h));
}

#[test]
fn what_is_not_an_oriented_manifold_is_refused_with_its_place() {
    let p = vec![DVec3::ZERO; 5];
    for (triangles, item) in [
        (vec![[0, 1, 9]], "triangle 0: "),
        (vec![[0, 1, 1]], "triangle 0: "),
        (vec![[0, 1, 2], [0, 1, 3]], "triangle 1: "),
        (vec![[0, 1, 2], [0, 3, 4]], "node 0: "),
    ] {
        let error = EditMesh::new(&TriMesh::new(p.clone(), triangles)).unwrap_err().to_string();
        assert!(error.starts_with(item), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn random_edits_keep_the_manifold(
        open in any::<bool>(),
        edits in prop::collection::vec((0u8..4, any::<prop::sample::Index>(), any::<bool>()), 1..120),
    ) {
        let mut m = EditMesh::new(&if open { sheet(3) } else { octahedron() }).unwrap();
        let (euler, _) = census(&m);
        for (kind, index, mark) in edits {
            let alive: Vec<u32> = (0..3 * m.triangle_capacity() as u32).filter(|&h| m.is_triangle(h / 3)).collect();
            let h = *index.get(&alive);
            m.set_sharp(h, mark);
            let nodes = m.nodes().count();
            let triangles = m.triangle_count();
            match kind {
                0 => {
                    m.flip(h);
                    prop_assert_eq!((m.nodes().count(), m.triangle_count()), (nodes, triangles));
                }
                1 => {
                    let p = 0.5 * (m.point(m.origin(h)) + m.point(m.target(h)));
                    let v = m.split_edge(h, p);
                    prop_assert_eq!(m.target(h), v);
                    prop_assert_eq!(m.nodes().count(), nodes + 1);
                }
                2 => {
                    let t = h / 3;
                    let v = m.split_triangle(t, m.centroid(t));
                    prop_assert_eq!(m.valence(v), 3);
                    prop_assert_eq!(m.triangle_count(), triangles + 2);
                }
                _ => {
                    let p = m.point(m.target(h));
                    let gone = m.collapse(h, p);
                    prop_assert_eq!(m.nodes().count(), nodes - usize::from(gone));
                }
            }
            if let Err(e) = m.check() {
                return Err(TestCaseError::fail(e));
            }
            prop_assert_eq!(census(&m).0, euler);
        }
        m.compact();
        prop_assert_eq!(m.check(), Ok(()));
        prop_assert_eq!(census(&m).0, euler);
        // The result reads back as a manifold.
        prop_assert!(EditMesh::new(&m.to_mesh()).is_ok());
    }
}

/// Nodes a reader has not seen.
fn unseen(m: &EditMesh, reader: ChangeReader) -> Vec<u32> {
    (0..m.node_capacity() as u32).filter(|&v| m.is_changed(v, reader)).collect()
}

#[test]
fn changes_are_noted_where_they_are_and_for_each_reader() {
    let mut m = EditMesh::new(&sheet(4)).unwrap();
    let see = |m: &mut EditMesh, r| (0..m.node_capacity() as u32).for_each(|v| m.set_seen(v, r));
    assert_eq!(unseen(&m, ChangeReader::Shapes).len(), 25);
    see(&mut m, ChangeReader::Shapes);
    assert!(unseen(&m, ChangeReader::Shapes).is_empty() && unseen(&m, ChangeReader::Places).len() == 25);
    see(&mut m, ChangeReader::Places);
    // The diagonal of the square between 6, 11, 12 and 7.
    let h = m.edge_between(6, 12).unwrap();
    assert!(m.flip(h));
    assert_eq!(unseen(&m, ChangeReader::Shapes), [6, 7, 11, 12]);
    see(&mut m, ChangeReader::Shapes);
    assert_eq!(unseen(&m, ChangeReader::Places), [6, 7, 11, 12]);
    m.set_point(18, DVec3::new(3.1, 3.0, 0.0));
    assert_eq!(unseen(&m, ChangeReader::Shapes), [18]);
    see(&mut m, ChangeReader::Shapes);
    let new = m.split_edge(m.edge_between(17, 18).unwrap(), DVec3::new(3.0, 2.5, 0.0));
    let mut around: Vec<u32> = m.neighbors(new).chain([new]).collect();
    around.sort_unstable();
    assert_eq!(unseen(&m, ChangeReader::Shapes), around);
    see(&mut m, ChangeReader::Shapes);
    let h = m.edge_between(new, 18).unwrap();
    let h = if m.origin(h) == new { h } else { m.opposite(h) };
    assert!(m.collapse(h, m.point(18)));
    // All around the node that is gone, and the one in its place.
    assert!(around.iter().filter(|v| **v != new).all(|&v| m.is_changed(v, ChangeReader::Shapes)));
    assert!(!m.is_changed(0, ChangeReader::Shapes));
}
