//! A mesh in portions is measured as the whole is, whatever is wrong with it and wherever portions meet.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::{Expectation, Sums, check};
use crate::mesh::TriMesh;
use crate::mesh::portion::{Joining, Portion};
use crate::quality::SHARP_MESH;
use crate::run::Run;
use crate::spatial::Aabb;

/// A torus, `n` by `n`, with two faces; a tall one has needles.
fn torus(n: u32, center: DVec3, height: f64) -> TriMesh {
    let turn = |i: u32| (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
    let mut mesh = TriMesh { faces: vec!["low".into(), "high".into()], ..TriMesh::default() };
    for i in 0..n {
        for j in 0..n {
            let ((su, cu), (sv, cv)) = (turn(i), turn(j));
            let p = DVec3::new((2.0 + cv) * cu, (2.0 + cv) * su, height * sv);
            mesh.nodes.push(center + p);
            let at = |i: u32, j: u32| i % n * n + j % n;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[p, q, r], [p, r, s]]);
            mesh.labels.extend([u32::from(j < n / 2); 2]);
        }
    }
    mesh
}

fn with(mut mesh: TriMesh, other: &TriMesh) -> TriMesh {
    let first = mesh.nodes.len() as u32;
    mesh.nodes.extend(&other.nodes);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    mesh.labels.extend(&other.labels);
    mesh
}

/// Triangles by portions, nodes by their first use.
fn sorted(mesh: &TriMesh, portion: &[usize]) -> TriMesh {
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_key(|t| portion[*t]);
    let mut out = TriMesh { faces: mesh.faces.clone(), groups: mesh.groups.clone(), ..TriMesh::default() };
    let mut number: FxHashMap<u32, u32> = FxHashMap::default();
    for t in order {
        let corners = mesh.triangles[t].map(|v| {
            *number.entry(v).or_insert_with(|| {
                out.nodes.push(mesh.nodes[v as usize]);
                out.nodes.len() as u32 - 1
            })
        });
        out.triangles.push(corners);
        out.labels.push(mesh.labels[t]);
    }
    out
}

/// Runs of triangles, of so many each, as portions.
fn cut(mesh: &TriMesh, sizes: &[usize]) -> Vec<Portion> {
    let mut of_node: Vec<Option<usize>> = vec![None; mesh.nodes.len()];
    let mut shared = vec![false; mesh.nodes.len()];
    let mut first = 0;
    let mut ranges = Vec::new();
    for (k, size) in sizes.iter().enumerate() {
        for v in mesh.triangles[first..first + size].iter().flatten() {
            let v = *v as usize;
            shared[v] |= *of_node[v].get_or_insert(k) != k;
        }
        ranges.push(first..first + size);
        first += size;
    }
    let portion = |range: std::ops::Range<usize>| {
        let mut p = Portion { first: range.start as u32, ..Portion::default() };
        let mut number: FxHashMap<u32, u32> = FxHashMap::default();
        for t in range {
            let corners = mesh.triangles[t].map(|v| {
                *number.entry(v).or_insert_with(|| {
                    p.nodes.push(v);
                    p.shared.push(shared[v as usize]);
                    p.mesh.nodes.push(mesh.nodes[v as usize]);
                    p.nodes.len() as u32 - 1
                })
            });
            p.mesh.triangles.push(corners);
            p.mesh.labels.push(mesh.labels[t]);
        }
        p
    };
    ranges.into_iter().map(portion).collect()
}

/// Compares the measures by eighths of space, by scattered triangles, and by one portion, with those of the whole.
fn same(mesh: &TriMesh, name: &str) {
    let middle = Aabb::around(mesh.nodes.iter().copied()).center();
    let octant = |t: usize| {
        let p = mesh.centroid(t);
        (0..3).map(|k| usize::from(p[k] > middle[k]) << k).sum::<usize>()
    };
    same_by(mesh, &octant, &format!("{name}, by octants"));
    same_by(mesh, &|t| t * 7919 % 5, &format!("{name}, scattered"));
    same_by(mesh, &|_| 0, &format!("{name}, as one"));
}

/// Compares the measures by up to eight portions with those of the whole.
fn same_by(mesh: &TriMesh, of: &dyn Fn(usize) -> usize, name: &str) {
    let portion: Vec<usize> = (0..mesh.triangles.len()).map(of).collect();
    let sizes: Vec<usize> = (0..8).map(|k| portion.iter().filter(|p| **p == k).count()).filter(|n| *n > 0).collect();
    let whole = sorted(mesh, &portion);
    let portions = cut(&whole, &sizes);
    let mut joining = Joining::default();
    portions.iter().for_each(|p| joining.add(p));
    let run = Run::new();
    let mut sums = Sums::new(joining.finish(SHARP_MESH), &whole);
    for (k, p) in portions.iter().enumerate() {
        sums.add(p, &run).unwrap();
        portions[k + 1..].iter().for_each(|q| sums.add_between(p, q, &run).unwrap());
    }
    let truth = check(&whole, Expectation::default(), None, &run).unwrap();
    assert_eq!(sums.finish(&whole), truth, "{name}");
}

#[test]
fn a_mesh_in_portions_is_measured_as_in_one() {
    let plain = torus(24, DVec3::ZERO, 1.0);
    same(&plain, "torus");
    same(&torus(24, DVec3::new(0.3, 7.0, -2.0), 9.0), "needles");
    same(&with(plain.clone(), &torus(12, DVec3::X * 9.0, 1.0)), "two apart");
    let crossing = with(plain.clone(), &torus(20, DVec3::new(1.1, 0.3, 0.2), 1.0));
    assert!(check(&crossing, Expectation::default(), None, &Run::new()).unwrap().self_intersections > 100);
    same(&crossing, "two crossing");
    let mut holed = plain.clone();
    for t in [700, 333, 4] {
        holed.triangles.remove(t);
        holed.labels.remove(t);
    }
    same(&holed, "open");
    let mut turned = plain.clone();
    [3, 50, 611].iter().for_each(|t| turned.triangles[*t as usize].swap(0, 1));
    same(&turned, "misoriented");
    let mut doubled = plain.clone();
    for t in [10, 400, 401] {
        doubled.triangles.push(plain.triangles[t]);
        doubled.labels.push(0);
    }
    same(&doubled, "non-manifold");
    // Two tori that share one node.
    let mut pinched = with(plain.clone(), &torus(24, DVec3::X * 6.0, 1.0));
    let (a, b) = (0, plain.nodes.len() as u32 + 12 * 24);
    pinched.triangles.iter_mut().flatten().filter(|v| **v == b).for_each(|v| *v = a);
    same(&pinched, "pinched");
    let inside_out: Vec<[u32; 3]> = plain.triangles.iter().map(|[a, b, c]| [*b, *a, *c]).collect();
    same(&TriMesh { triangles: inside_out, ..plain }, "inverted");
}
