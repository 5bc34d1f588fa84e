//! Enumeration of all cases, pairs of cells, random cells against their refinement, random volumes.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::geometry::{Triangle, corner, faces_at, is_free, midpoint};
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

fn edges_of(triangles: &[Triangle]) -> impl Iterator<Item = [u8; 2]> + '_ {
    triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
}

/// Positions of the local nodes; interior nodes at the mean of their neighbors.
fn place(case: CellCase, crossing: impl Fn(u8) -> DVec3) -> Vec<DVec3> {
    let mut at: Vec<DVec3> = (0..12).map(crossing).collect();
    for k in 0..case.interior_nodes {
        let center = INTERIOR_NODE + k;
        let ring: BTreeSet<u8> =
            case.triangles.iter().filter(|t| t.contains(&center)).flatten().copied().filter(|&v| v < 12).collect();
        at.push(ring.iter().map(|&v| at[usize::from(v)]).sum::<DVec3>() / ring.len() as f64);
    }
    at
}

fn orient(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let p = |v: DVec3| Coord3D { x: v.x, y: v.y, z: v.z };
    orient3d(p(a), p(b), p(c), p(d))
}

/// Whether the segment and the triangle cross properly.
fn pierces(p: DVec3, q: DVec3, t: [DVec3; 3]) -> bool {
    let [a, b, c] = t;
    let side = |x| orient(a, b, c, x);
    if side(p) * side(q) >= 0.0 {
        return false;
    }
    let turn = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)];
    turn.iter().all(|&v| v > 0.0) || turn.iter().all(|&v| v < 0.0)
}

/// Pairs of triangles of a cell which cross.
fn crossings(triangles: &[Triangle], at: &[DVec3]) -> usize {
    let points = |t: Triangle| t.map(|v| at[usize::from(v)]);
    let hits = |s: Triangle, t: Triangle| {
        edges_of(&[s])
            .filter(|e| e.iter().all(|v| !t.contains(v)))
            .any(|[u, v]| pierces(at[usize::from(u)], at[usize::from(v)], points(t)))
    };
    let mut n = 0;
    for (i, &s) in triangles.iter().enumerate() {
        n += triangles[..i].iter().filter(|&&t| hits(s, t) || hits(t, s)).count();
    }
    n
}

fn on_edge(e: u8, s: f64) -> DVec3 {
    let [a, b] = EDGES[usize::from(e)].map(corner);
    a + (b - a) * s
}

#[test]
fn no_cell_crosses_itself() {
    let mut dice = Dice(7);
    let mut bad: BTreeMap<(Vec<usize>, u8), [usize; 4]> = BTreeMap::new();
    for (mask, faces, t) in all_cases() {
        let c = case(mask, faces, t);
        let mut lens: Vec<usize> = loops(mask, faces).iter().map(Vec::len).collect();
        lens.sort();
        let b = bad.entry((lens, t)).or_default();
        b[3] += 1;
        b[0] += usize::from(crossings(c.triangles, &place(c, midpoint)) > 0);
        for _ in 0..50 {
            let s: [f64; 12] = std::array::from_fn(|_| dice.unit());
            b[1] += usize::from(crossings(c.triangles, &place(c, |e| on_edge(e, s[usize::from(e)]))) > 0);
        }
        for _ in 0..50 {
            let v = dice.values(mask);
            if joined_faces(mask, &v) == faces && tunnel(mask, faces, &v) == t {
                let root = |e: u8| {
                    let [a, b] = EDGES[usize::from(e)].map(|c| v[usize::from(c)]);
                    if (a > 0.0) == (b > 0.0) { midpoint(e) } else { on_edge(e, a / (a - b)) }
                };
                b[2] += usize::from(crossings(c.triangles, &place(c, root)) > 0);
            }
        }
    }
    for (k, v) in bad {
        println!("{k:?} cases {} mid {} random {} trilinear {}", v[3], v[0], v[1], v[2]);
    }
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
    }
}

#[test]
fn occur() {
    let mut dice = Dice(99);
    let mut seen = BTreeMap::new();
    for mask in (0..=255u8) {
        if (0..64).all(|f| TABLE.entry(mask, f).tunnels.is_empty()) {
            continue;
        }
        for _ in 0..100000 {
            let v = dice.values(mask);
            let faces = joined_faces(mask, &v);
            let t = tunnel_along(2, mask, faces, &v);
            for a in 0..2 {
                assert_eq!(tunnel_along(a, mask, faces, &v), t);
            }
            *seen.entry((mask, faces, t)).or_insert(0) += 1;
        }
    }
    let mut h: BTreeMap<(Vec<usize>, u8, bool), usize> = BTreeMap::new();
    for (m, f, t) in all_cases() {
        let mut lens: Vec<usize> = loops(m, f).iter().map(Vec::len).collect();
        lens.sort();
        if (0..64).all(|f| TABLE.entry(m, f).tunnels.is_empty()) {
            continue;
        }
        *h.entry((lens, t, seen.contains_key(&(m, f, t)))).or_default() += 1;
    }
    for (k, v) in h {
        println!("OCC {k:?} {v}");
    }
}

#[test]
fn explore() {
    let mut dice = Dice(5);
    let mut done = BTreeSet::new();
    for (mask, faces, t) in all_cases() {
        if t == 0 || mask.count_ones() > 4 {
            continue;
        }
        let l = loops(mask, faces);
        let mut key: Vec<usize> = l.iter().map(Vec::len).collect();
        key.sort();
        if !done.insert((key.clone(), mask.count_ones(), t, faces.count_ones())) {
            continue;
        }
        // find loops: those in case
        let c0 = case(mask, faces, 0);
        let mut samples = Vec::new();
        let mut tries = 0;
        while samples.len() < 200 && tries < 4_000_000 {
            tries += 1;
            let v = dice.values(mask);
            if joined_faces(mask, &v) == faces && tunnel(mask, faces, &v) == t {
                samples.push(v);
            }
        }
        let mut pair = None;
        for i in 0..l.len() {
            for j in i + 1..l.len() {
                let c = case(mask, faces, t);
                let e: BTreeSet<[u8; 2]> = edges_of(c.triangles).collect();
                // joined if some triangle has both loops' nodes or shared center
                let touches = |n: &Vec<u8>, m: &Vec<u8>| {
                    c.triangles.iter().any(|t| t.iter().any(|v| n.contains(v)) && t.iter().any(|v| m.contains(v)))
                };
                let _ = &e;
                if touches(&l[i], &l[j]) {
                    pair = Some((i, j));
                }
            }
        }
        let (i, j) = pair.unwrap();
        let rest: Vec<Triangle> =
            (0..l.len()).filter(|k| *k != i && *k != j).flat_map(|k| geometry::disk(&l[k], &mut 0)).collect();
        let mut opts: Vec<(usize, usize, usize, u8, usize)> = Vec::new();
        for (x, (count, tri)) in geometry::options(&l[i], &l[j]).into_iter().enumerate() {
            let all: Vec<Triangle> = tri.iter().chain(&rest).copied().collect();
            let cc = CellCase { triangles: Vec::leak(all), interior_nodes: count };
            let mid = crossings(cc.triangles, &place(cc, midpoint));
            let tri = samples
                .iter()
                .filter(|v| {
                    let root = |e: u8| {
                        let [a, b] = EDGES[usize::from(e)].map(|c| v[usize::from(c)]);
                        if (a > 0.0) == (b > 0.0) { midpoint(e) } else { on_edge(e, a / (a - b)) }
                    };
                    crossings(cc.triangles, &place(cc, root)) > 0
                })
                .count();
            let ran = (0..100)
                .filter(|_| {
                    let s: [f64; 12] = std::array::from_fn(|_| dice.unit());
                    crossings(cc.triangles, &place(cc, |e| on_edge(e, s[usize::from(e)]))) > 0
                })
                .count();
            opts.push((tri, ran, mid, count, x));
        }
        opts.sort();
        let _ = c0;
        println!(
            "{key:?} mask {mask:08b} faces {faces:06b} t{t} samples {} options {} best {:?}",
            samples.len(),
            opts.len(),
            &opts[..6.min(opts.len())]
        );
        for n in 0..3 {
            let mut o: Vec<_> = opts.iter().filter(|o| o.3 == n).collect();
            o.sort();
            println!("   with {n} interior: {} {:?}", o.len(), o.first());
        }
    }
}
