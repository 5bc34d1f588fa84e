//! TEMPORARY stand-in.
use std::sync::LazyLock;
pub struct CellCase {
    pub triangles: &'static [[u8; 3]],
    pub interior_nodes: u8,
}
pub fn ambiguous_faces(mask: u8) -> u8 {
    let mut r = 0;
    for f in 0..6 {
        let c = face_corners(f);
        let b = c.map(|c| mask >> c & 1);
        if b[0] == b[2] && b[1] == b[3] && b[0] != b[1] {
            r |= 1 << f;
        }
    }
    r
}
fn face_corners(f: usize) -> [usize; 4] {
    let (axis, side) = (f / 2, f % 2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let c = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|d: [usize; 2]| side << axis | d[0] << u | d[1] << v);
    if side == 1 { c } else { [c[0], c[3], c[2], c[1]] } // ccw seen from outside the cell
}
pub fn face_joined(v: [f64; 4]) -> bool {
    let (p, n) = if v[0] > 0.0 { (v[0] * v[2], v[1] * v[3]) } else { (v[1] * v[3], v[0] * v[2]) };
    p > n
}
pub fn interior_ambiguous(_: u8, _: u8) -> bool {
    false
}
pub fn tunnel(_: u8, _: u8, _: &[f64; 8]) -> u8 {
    0
}
fn edge_id(a: usize, b: usize) -> u8 {
    let (l, x) = (a.min(b), a ^ b);
    (match x {
        1 => (l >> 1 & 1) + 2 * (l >> 2),
        2 => 4 + (l & 1) + 2 * (l >> 2),
        _ => 8 + (l & 1) + 2 * (l >> 1 & 1),
    }) as u8
}
static TABLE: LazyLock<Vec<Vec<[u8; 3]>>> =
    LazyLock::new(|| (0..256 * 64).map(|i| build((i / 64) as u8, (i % 64) as u8)).collect());
fn build(mask: u8, faces: u8) -> Vec<[u8; 3]> {
    let mut next = [255u8; 12];
    for f in 0..6 {
        let c = face_corners(f);
        let b = c.map(|c| mask >> c & 1 == 1);
        let e: [u8; 4] = std::array::from_fn(|i| edge_id(c[i], c[(i + 1) % 4]));
        // edge i goes in->out ("leave") or out->in ("enter") walking ccw seen from outside
        let amb = ambiguous_faces(mask) >> f & 1 == 1;
        let joined = faces >> f & 1 == 1;
        for i in 0..4 {
            if b[i] && !b[(i + 1) % 4] {
                // from leaving edge i, connect to an entering edge
                let mut js: Vec<usize> = (1..4).map(|d| (i + d) % 4).filter(|&j| !b[j] && b[(j + 1) % 4]).collect();
                let j = if amb && joined { js.remove(0) } else { js.pop().unwrap() };
                next[e[j] as usize] = e[i];
            }
        }
    }
    let mut out = vec![];
    let mut seen = [false; 12];
    for s in 0..12 {
        if next[s] == 255 || seen[s] {
            continue;
        }
        let mut l = vec![];
        let mut k = s;
        while !seen[k] {
            seen[k] = true;
            l.push(k as u8);
            k = next[k] as usize;
        }
        for i in 1..l.len() - 1 {
            out.push([l[0], l[i], l[i + 1]]);
        }
    }
    out
}
pub fn case(mask: u8, faces: u8, _: u8) -> CellCase {
    CellCase { triangles: &TABLE[mask as usize * 64 + faces as usize], interior_nodes: 0 }
}
