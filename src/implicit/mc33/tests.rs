//! Enumeration of all cases, pairs of cells, random cells against their refinement, random volumes.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::geometry::{crosses, edges_of, is_free, on_edge, place};
use super::table::{TABLE, face_segments, loops};
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
        let mut bd = |s: &dyn Fn(u8) -> DVec3| usize::from(crosses(c.triangles, &place(c.triangles, s)));
        b[0] += bd(&|e| on_edge(e, 0.5));
        for _ in 0..200 {
            let s: [f64; 12] = std::array::from_fn(|_| dice.unit());
            b[1] += bd(&|e| on_edge(e, s[usize::from(e)]));
        }
        for _ in 0..500 {
            let v = dice.values(mask);
            if joined_faces(mask, &v) == faces && tunnel(mask, faces, &v) == t {
                b[2] += bd(&|e| root(&v, e));
            }
        }
    }
    for (k, v) in bad { println!("{k:?} cases {} mid {} random {} trilinear {}", v[3], v[0], v[1], v[2]); }
    let t0 = std::time::Instant::now();
    let _ = table::Table::build();
    println!("build {:?}", t0.elapsed());
    let mut h = BTreeMap::new();
    for (m, f, t) in all_cases() { if t > 0 { let c = case(m, f, t); *h.entry((loops(m, f).iter().map(|l| l.len()).collect::<BTreeSet<_>>(), c.interior_nodes, c.triangles.len())).or_insert(0) += 1; } }
    println!("{h:?}");
}

#[test]
fn every_case_is_a_set_of_disks_and_one_annulus_at_most() {
    for (mask, faces, t) in all_cases() {
        let name = format!("mask {mask:08b} faces {faces:06b} tunnel {t}");
        let c = case(mask, faces, t);
        let mut boundary: BTreeSet<[u8; 2]> =
            (0..6).flat_map(|f| face_segments(mask, faces, f)).collect();
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
        if (0..64).all(|f| TABLE.entry(mask, f).tunnels.is_empty()) { continue; }
        for _ in 0..100000 {
            let v = dice.values(mask);
            let faces = joined_faces(mask, &v);
            let t = tunnel_along(2, mask, faces, &v);
            for a in 0..2 { assert_eq!(tunnel_along(a, mask, faces, &v), t); }
            *seen.entry((mask, faces, t)).or_insert(0) += 1;
        }
    }
    let mut h: BTreeMap<(Vec<usize>, u8, bool), usize> = BTreeMap::new();
    for (m, f, t) in all_cases() { 
        let mut lens: Vec<usize> = loops(m, f).iter().map(Vec::len).collect();
        lens.sort();
        if (0..64).all(|f| TABLE.entry(m, f).tunnels.is_empty()) { continue; }
        *h.entry((lens, t, seen.contains_key(&(m,f,t)))).or_default() += 1; }
    for (k, v) in h { println!("OCC {k:?} {v}"); }
}

