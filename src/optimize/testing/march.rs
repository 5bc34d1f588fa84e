//! A small marching cubes on a uniform grid: nodes exactly on the surface, slivers and chamfered creases as usual.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::TestPart;
use crate::mesh::TriMesh;

/// Corner offsets of the faces of a cell, counter-clockwise seen from outside.
const FACES: [[[usize; 3]; 4]; 6] = [
    [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]],
    [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]],
    [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
    [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]],
    [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]],
    [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
];

/// Extracts the part's boundary with `n` cells per side.
pub fn march(part: &TestPart, n: usize) -> TriMesh {
    let h = 2.0 * part.half / n as f64;
    let at = |v: [usize; 3]| DVec3::splat(-part.half) + h * DVec3::from_array(v.map(|k| k as f64));
    let id = |v: [usize; 3]| (v[0] * (n + 1) + v[1]) * (n + 1) + v[2];
    let mut inside = vec![false; (n + 1) * (n + 1) * (n + 1)];
    for i in 0..=n {
        for j in 0..=n {
            for k in 0..=n {
                inside[id([i, j, k])] = part.value(at([i, j, k])) > 0.0;
            }
        }
    }
    let mut nodes = Vec::new();
    let mut on_edge = FxHashMap::default();
    let mut node = |a: [usize; 3], b: [usize; 3]| {
        let key = if id(a) < id(b) { (id(a), id(b)) } else { (id(b), id(a)) };
        *on_edge.entry(key).or_insert_with(|| {
            let (mut p, mut q) = if inside[id(a)] { (at(a), at(b)) } else { (at(b), at(a)) };
            for _ in 0..50 {
                let m = 0.5 * (p + q);
                if part.value(m) > 0.0 { p = m } else { q = m }
            }
            nodes.push(0.5 * (p + q));
            nodes.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let corner = |o: [usize; 3]| [i + o[0], j + o[1], k + o[2]];
                let mut follow: Vec<(u32, u32)> = Vec::new();
                for face in FACES {
                    let ring = face.map(corner);
                    for s in 0..4 {
                        // Cut off each run of inside corners: enter where outside turns inside, leave where it ends.
                        if !inside[id(ring[s])] && inside[id(ring[(s + 1) % 4])] {
                            let mut e = (s + 1) % 4;
                            while inside[id(ring[(e + 1) % 4])] {
                                e = (e + 1) % 4;
                            }
                            let enter = node(ring[s], ring[(s + 1) % 4]);
                            follow.push((node(ring[e], ring[(e + 1) % 4]), enter));
                        }
                    }
                }
                while let Some((start, mut to)) = follow.pop() {
                    let mut ring = vec![start];
                    while to != start {
                        ring.push(to);
                        let Some(next) = follow.iter().position(|f| f.0 == to) else { break };
                        to = follow.swap_remove(next).1;
                    }
                    for w in 1..ring.len() - 1 {
                        triangles.push([ring[0], ring[w + 1], ring[w]]);
                    }
                }
            }
        }
    }
    TriMesh::new(nodes, triangles)
}
