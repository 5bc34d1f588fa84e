//! Enumeration of all cases, pairs of cells, random cells against their refinement, random volumes.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::geometry::{crosses, edges_of, is_free, on_edge, place};
use super::table::{TABLE, face_segments, loops, regions};
use super::*;

/// xorshift64*, so that failures repeat.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Values with the signs of `mask` and sizes over several decades.
    fn values(&mut self, mask: u8) -> [f64; 8] {
        let power = 1.0 + (3.0 * self.unit()).floor();
        std::array::from_fn(|c| (self.unit().powf(power) + 1e-9) * if mask >> c & 1 == 1 { 1.0 } else { -1.0 })
    }
}

fn mask_of(values: &[f64; 8]) -> u8 {
    (0..8).fold(0, |m, c| m | u8::from(values[c] > 0.0) << c)
}

/// All masks, decisions and tunnels of the table.
fn all_cases() -> Vec<(u8, u8, u8)> {
    let mut all = Vec::new();
    for mask in 0..=255u8 {
        for faces in (0..64u8).filter(|f| f & !ambiguous_faces(mask) == 0) {
            all.extend((0..=TABLE.entry(mask, faces).tunnels.len()).map(|t| (mask, faces, t as u8)));
        }
    }
    all
}

/// Where the trilinear interpolant crosses edge `e`, the middle where it does not.
fn root(values: &[f64; 8], e: u8) -> DVec3 {
    let [a, b] = EDGES[usize::from(e)].map(|c| values[usize::from(c)]);
    on_edge(e, if (a > 0.0) == (b > 0.0) { 0.5 } else { a / (a - b) })
}

/// Decisions no function has: the product of the inside corners cannot both exceed and not exceed that of the outside
/// corners, which is what a pair of joined and a pair of separated opposite faces of a checkerboard say.
fn contradictory(mask: u8, faces: u8) -> bool {
    let pair = |axis: u8| faces >> (2 * axis) & 3;
    ambiguous_faces(mask) == 63 && (0..3).any(|a| pair(a) == 3) && (0..3).any(|a| pair(a) == 0)
}

#[test]
fn no_cell_crosses_itself() {
    let mut dice = Dice(7);
    let (mut drawn, mut crossed) = (0, 0);
    for (mask, faces, t) in all_cases() {
        if contradictory(mask, faces) {
            continue;
        }
        let c = case(mask, faces, t).triangles;
        let check = |at: Vec<DVec3>| assert!(!crosses(c, &at), "mask {mask:08b} faces {faces:06b} tunnel {t}: {at:?}");
        check(place(c, |e| on_edge(e, 0.5)));
        // Any roots at all: the crossing need not be that of the trilinear interpolant.
        for _ in 0..300 {
            let s: [f64; 12] = std::array::from_fn(|_| 0.001 + 0.998 * dice.unit());
            let at = place(c, |e| on_edge(e, s[usize::from(e)]));
            assert!(at.iter().skip(12).all(|p| p.min_element() > 0.0 && p.max_element() < 1.0), "{at:?}");
            crossed += usize::from(crosses(c, &at));
        }
        for v in (0..200).map(|_| dice.values(mask)) {
            if joined_faces(mask, &v) == faces && tunnel(mask, faces, &v) == t {
                drawn += 1;
                check(place(c, |e| root(&v, e)));
            }
        }
    }
    assert!(drawn > 30_000, "only {drawn} cells drawn");
    assert!(crossed < 10, "{crossed} of 200 000 cells with arbitrary roots cross themselves");
}

#[test]
fn triangles_separate_inside_from_outside() {
    for (mask, faces, t) in all_cases() {
        let c = case(mask, faces, t);
        let at = place(c.triangles, |e| on_edge(e, 0.5));
        // Along each cube edge the normals at the crossing point away from the inside end.
        for e in 0..12u8 {
            let [a, b] = EDGES[usize::from(e)];
            if mask >> a & 1 == mask >> b & 1 {
                continue;
            }
            let inward = on_edge(e, f64::from(mask >> b & 1));
            let normal: DVec3 = c
                .triangles
                .iter()
                .filter(|t| t.contains(&e))
                .map(|t| {
                    let [p, q, r] = t.map(|v| at[usize::from(v)]);
                    (q - p).cross(r - p).normalize()
                })
                .sum();
            assert!(
                normal.dot(inward - on_edge(e, 0.5)) < 0.0,
                "mask {mask:08b} faces {faces:06b} tunnel {t} edge {e}"
            );
        }
    }
}

#[test]
fn the_worked_case_of_the_docs() {
    let segments: Vec<[u8; 2]> = (0..6).flat_map(|f| face_segments(1, 0, f)).collect();
    assert_eq!(segments, [[4, 8], [8, 0], [0, 4]]);
    assert_eq!(case(1, 0, 0), CellCase { triangles: &[[0, 4, 8]], interior_nodes: 0 });
    assert_eq!(case(1, 63, 9), case(1, 0, 0), "bits and tunnels which do not exist do not matter");
}

#[test]
fn every_case_is_a_set_of_disks_and_one_annulus_at_most() {
    for (mask, faces, t) in all_cases() {
        let name = format!("mask {mask:08b} faces {faces:06b} tunnel {t}");
        let c = case(mask, faces, t);
        let mut boundary: BTreeSet<[u8; 2]> = (0..6).flat_map(|f| face_segments(mask, faces, f)).collect();
        let edges: Vec<[u8; 2]> = edges_of(c.triangles).collect();
        let set: BTreeSet<[u8; 2]> = edges.iter().copied().collect();
        assert_eq!(set.len(), edges.len(), "{name}: an edge is used twice in one direction");
        for &[a, b] in &set {
            if boundary.remove(&[a, b]) {
                assert!(!set.contains(&[b, a]), "{name}: a face segment is used from both sides");
            } else {
                assert!(set.contains(&[b, a]), "{name}: edge {a}-{b} is open");
                assert!(a >= 12 || b >= 12 || is_free(a, b), "{name}: chord {a}-{b} lies in a face");
            }
        }
        assert!(boundary.is_empty(), "{name}: face segments without triangle");
        let nodes: BTreeSet<u8> = set.iter().flatten().copied().collect();
        assert_eq!(nodes.iter().filter(|&&v| v >= 12).count(), usize::from(c.interior_nodes), "{name}");
        // V - E + F is one for each disk and zero for the annulus; count components by the loops.
        let inner = edges.len() - loops(mask, faces).iter().map(Vec::len).sum::<usize>();
        let euler = (nodes.len() + c.triangles.len()) as isize - (edges.len() - inner / 2) as isize;
        let disks = loops(mask, faces).len() - 2 * usize::from(t > 0);
        assert_eq!(euler, disks as isize, "{name}");
        assert!(c.interior_nodes <= 3, "{name}");
    }
}

#[test]
fn the_table_has_exactly_the_cases_which_occur() {
    let mut dice = Dice(99);
    let mut seen = BTreeSet::new();
    for mask in 0..=255u8 {
        let tunnels = (0..64).any(|f| interior_ambiguous(mask, f));
        let draws = if tunnels { 60_000 } else { 200 * usize::from(ambiguous_faces(mask) != 0) + 1 };
        for v in (0..draws).map(|_| dice.values(mask)) {
            let faces = joined_faces(mask, &v);
            let along = [0, 1, 2].map(|axis| tunnel_along(axis, mask, faces, &v));
            assert!(along == [along[0]; 3], "slices disagree: {along:?} at {v:?}");
            seen.insert((mask, faces, along[0]));
        }
    }
    let expected: BTreeSet<_> = all_cases().into_iter().filter(|&(m, f, _)| !contradictory(m, f)).collect();
    assert_eq!(seen, expected);
}

#[test]
fn the_face_decision_does_not_depend_on_the_order_of_the_corners() {
    let mut dice = Dice(3);
    for round in 0..20_000 {
        let mut v: [f64; 4] = std::array::from_fn(|k| dice.unit() * if k % 2 == 0 { 1.0 } else { -1.0 });
        if round % 3 == 0 {
            // A tie up to rounding, or exactly.
            v[3] = v[0] * v[2] / v[1];
        } else if round % 3 == 1 {
            v = v.map(|x| (4.0 * x).trunc());
        }
        let truth = face_joined(v);
        for shift in 0..4 {
            let turned: [f64; 4] = std::array::from_fn(|k| v[(k + shift) % 4]);
            let mirrored: [f64; 4] = std::array::from_fn(|k| v[(8 + shift - k) % 4]);
            assert_eq!([face_joined(turned), face_joined(mirrored)], [truth; 2], "{v:?}");
        }
    }
    assert!(face_joined([2.0, -1.0, 1.0, -1.0]) && !face_joined([1.0, -1.0, 1.0, -1.0]));
    assert!(!face_joined([1.0, -1.0, 1.0, -1.0 - f64::EPSILON]) && face_joined([1.0, -1.0, 1.0 + f64::EPSILON, -1.0]));
    // Equal as rounded products, 1 - eps^2 against 1.
    assert!(!face_joined([1.0 + f64::EPSILON, -1.0, 1.0 - f64::EPSILON, -1.0]));
}

/// Meshes a block of corner values, `n` along each axis, by one cell after the other.
fn mesh(n: [usize; 3], value: impl Fn([usize; 3]) -> f64) -> Vec<[u64; 3]> {
    let mut out = Vec::new();
    for cell in 0..(n[0] - 1) * (n[1] - 1) * (n[2] - 1) {
        let at = [cell % (n[0] - 1), cell / (n[0] - 1) % (n[1] - 1), cell / (n[0] - 1) / (n[1] - 1)];
        let grid = |c: u8| [0, 1, 2].map(|axis| at[axis] + usize::from(c >> axis & 1));
        let v: [f64; 8] = std::array::from_fn(|c| value(grid(c as u8)));
        let mask = mask_of(&v);
        let faces = joined_faces(mask, &v);
        let node = |l: u8| {
            let (place, kind) =
                if l < INTERIOR_NODE { (grid(EDGES[usize::from(l)][0]), u64::from(l / 4)) } else { (at, u64::from(l)) };
            place.iter().fold(0, |key, &p| key * 64 + p as u64) * 32 + kind
        };
        out.extend(case(mask, faces, tunnel(mask, faces, &v)).triangles.iter().map(|t| t.map(node)));
    }
    out
}

#[test]
fn any_two_neighbors_fit() {
    let mut dice = Dice(11);
    for signs in 0..4096u32 {
        for axis in 0..3 {
            let mut n = [2; 3];
            n[axis] = 3;
            let v: [f64; 12] =
                std::array::from_fn(|k| (0.01 + dice.unit()) * if signs >> k & 1 == 1 { 1.0 } else { -1.0 });
            let triangles = mesh(n, |g| v[g[0] + n[0] * (g[1] + n[1] * g[2])]);
            let edges: Vec<[u64; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            let set: BTreeSet<[u64; 2]> = edges.iter().copied().collect();
            assert_eq!(set.len(), edges.len(), "{v:?}");
            for [a, b] in set.iter().filter(|[a, b]| !set.contains(&[*b, *a])) {
                // An open edge must lie in the outside of the block: both nodes on one of its six sides.
                let on = |key: u64| {
                    let (kind, p) = (key % 32, [key >> 17, key >> 11 & 63, key >> 5 & 63]);
                    (0..6u64).filter(move |f| {
                        let k = (f / 2) as usize;
                        kind < 3 && kind as usize != k && p[k] as usize == if f % 2 == 0 { 0 } else { n[k] - 1 }
                    })
                };
                let sides: BTreeSet<u64> = on(*a).collect();
                assert!(on(*b).any(|f| sides.contains(&f)), "open edge between the cells of {v:?}");
            }
        }
    }
}

#[test]
fn random_volumes_are_closed_manifolds() {
    let mut dice = Dice(13);
    for (n, whole) in [(13, false), (13, true), (9, false), (9, true)] {
        let inner: Vec<f64> = (0..n * n * n)
            .map(|_| if whole { (7.0 * dice.unit()).floor() - 3.0 } else { 2.0 * dice.unit() - 1.0 })
            .collect();
        let triangles = mesh([n; 3], |g| {
            if g.iter().any(|&x| x == 0 || x == n - 1) { -0.5 } else { inner[g[0] + n * (g[1] + n * g[2])] }
        });
        assert!(triangles.len() > 1000);
        let mut next: BTreeMap<u64, BTreeMap<u64, u64>> = BTreeMap::new();
        for &[a, b, c] in &triangles {
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                assert!(next.entry(a).or_default().insert(b, c).is_none(), "edge used twice in one direction");
            }
        }
        for link in next.values() {
            let Some((&start, _)) = link.iter().next() else { continue };
            let mut at = start;
            let mut steps = 0;
            loop {
                at = *link.get(&at).expect("open edge");
                steps += 1;
                if at == start {
                    break;
                }
            }
            assert_eq!(steps, link.len(), "two fans meet in one node");
        }
    }
}

/// Components of the inside, of the outside, and the Euler characteristic of the surface between.
type Topology = [isize; 3];

/// Of the trilinear interpolant, sampled `n + 1` times along each axis and taken as linear in the six tetrahedra of
/// each small cube (chains from low to high corner).
fn sampled(values: &[f64; 8], n: usize) -> Topology {
    let m = n + 1;
    let inside: Vec<bool> = (0..m * m * m)
        .map(|i| {
            let p = [i % m, i / m % m, i / m / m].map(|k| k as f64 / n as f64);
            let mut v = *values;
            for axis in (0..3).rev() {
                for c in 0..1 << axis {
                    v[c] += p[axis] * (v[c | 1 << axis] - v[c]);
                }
            }
            v[0] > 0.0
        })
        .collect();
    let step = |d: usize| (d & 1) + m * (d >> 1 & 1) + m * m * (d >> 2 & 1);
    let mut parent: Vec<usize> = (0..inside.len()).collect();
    fn find(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut counts = [0, 0];
    let mut euler = 0;
    for i in 0..inside.len() {
        counts[usize::from(!inside[i])] += 1;
        let at = [i % m, i / m % m, i / m / m];
        let beyond = (0..3).fold(0, |set, k| set | usize::from(at[k] == n) << k);
        // Chains of steps, bit by bit disjoint: edges, triangles and tetrahedra whose lowest corner is this one.
        for d in (1..8).filter(|d| d & beyond == 0) {
            let j = i + step(d);
            if inside[i] == inside[j] {
                let (p, q) = (find(&mut parent, i), find(&mut parent, j));
                if p != q {
                    parent[p] = q;
                    counts[usize::from(!inside[i])] -= 1;
                }
            } else {
                euler += 1;
            }
            for e in (1..8).filter(|e| e & (d | beyond) == 0) {
                let k = j + step(e);
                let cut = inside[j] != inside[i] || inside[k] != inside[i];
                euler -= isize::from(cut);
                let f = 7 & !(d | e);
                if f != 0 && f & beyond == 0 {
                    euler += isize::from(cut || inside[k + step(f)] != inside[i]);
                }
            }
        }
    }
    [counts[0], counts[1], euler]
}

/// Of our triangulation: the regions a tunnel joins become one.
fn triangulated(mask: u8, faces: u8, t: u8) -> Topology {
    let region = regions(mask, faces);
    let mut counts = [0u8, 1].map(|out| {
        (0..8).filter(|&c| region[usize::from(c)] == c && (mask >> c & 1 == 1) == (out == 0)).count() as isize
    });
    let c = case(mask, faces, t).triangles;
    if t > 0 {
        let [p, _] = TABLE.entry(mask, faces).tunnels[usize::from(t) - 1];
        counts[usize::from(mask >> p & 1 == 0)] -= 1;
    }
    let undirected: BTreeSet<[u8; 2]> = edges_of(c).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    let nodes: BTreeSet<u8> = c.iter().flatten().copied().collect();
    [counts[0], counts[1], (nodes.len() + c.len()) as isize - undirected.len() as isize]
}

/// Distance from a tie: the smallest relative difference of the products compared by face and interior tests.
fn margin(mask: u8, values: &[f64; 8]) -> f64 {
    let gap = |p: f64, q: f64| (p - q).abs() / p.abs().max(q.abs());
    let at = |c: u8| values[usize::from(c)];
    let mut least = f64::INFINITY;
    for (f, &[a, b, c, d]) in FACE_CORNERS.iter().enumerate() {
        if ambiguous_faces(mask) >> f & 1 == 1 {
            least = least.min(gap(at(a) * at(c), at(b) * at(d)));
        }
    }
    for axis in 0..3 {
        if let Some(s) = extreme_slice(axis, values) {
            least = least.min(gap(s[0] * s[2], s[1] * s[3]));
        }
    }
    least
}

#[test]
fn cells_have_the_topology_of_the_trilinear_interpolant() {
    let mut dice = Dice(17);
    let mut drawn: BTreeMap<(u8, u8, u8), usize> = BTreeMap::new();
    let (mut total, mut near_ties, mut refined) = (0, 0, 0);
    for mask in 0..=255u8 {
        let tunnels = (0..64).any(|f| interior_ambiguous(mask, f));
        let (draws, quota) = if tunnels { (40_000, 30) } else { (40, 40) };
        for _ in 0..draws {
            let v: [f64; 8] =
                std::array::from_fn(|c| (0.02 + dice.unit()) * if mask >> c & 1 == 1 { 1.0 } else { -1.0 });
            let faces = joined_faces(mask, &v);
            let t = tunnel(mask, faces, &v);
            let count = drawn.entry((mask, faces, t)).or_default();
            if *count == quota {
                continue;
            }
            if margin(mask, &v) < 0.05 {
                near_ties += 1;
                continue;
            }
            *count += 1;
            total += 1;
            let ours = triangulated(mask, faces, t);
            let fits = [12, 24, 48, 96].into_iter().position(|n| sampled(&v, n) == ours);
            refined += usize::from(fits != Some(0));
            assert!(fits.is_some(), "mask {mask:08b} faces {faces:06b} tunnel {t}: {ours:?} at {v:?}");
        }
    }
    assert!(total >= 20_000 && refined < 100, "{total} cells, {refined} refined, {near_ties} near ties left out");
    let tunnels = drawn.iter().filter(|((_, _, t), n)| *t > 0 && **n > 0).count();
    assert_eq!(tunnels, all_cases().iter().filter(|c| c.2 > 0).count());
}
