//! MC33

mod geometry;
mod table;
#[cfg(test)]
mod tests;

use table::TABLE;

/// The two corners of each cube edge, lower first.
pub const EDGES: [[u8; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

/// The corners of each cube face `2 * axis + side`, counter-clockwise seen from outside the cube.
pub const FACE_CORNERS: [[u8; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Local number of the first interior node.
pub const INTERIOR_NODE: u8 = 12;

/// The triangles of one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellCase {
    /// Local nodes.
    pub triangles: &'static [[u8; 3]],
    /// Number of interior nodes.
    pub interior_nodes: u8,
}

/// The ambiguous faces of a mask.
pub fn ambiguous_faces(mask: u8) -> u8 {
    let inside = |c: u8| mask >> c & 1;
    FACE_CORNERS.iter().enumerate().fold(0, |set, (f, &[a, b, c, d])| {
        let alternates = inside(a) == inside(c) && inside(b) == inside(d) && inside(a) != inside(b);
        set | u8::from(alternates) << f
    })
}

/// Asymptotic decider.
pub fn face_joined([a, b, c, d]: [f64; 4]) -> bool {
    if a > 0.0 || c > 0.0 || b < 0.0 || d < 0.0 {
        product_exceeds([a, c], [b, d])
    } else {
        product_exceeds([b, d], [a, c])
    }
}

/// Whether `x[0] x[1] > y[0] y[1]`, exactly where nothing over- or underflows.
fn product_exceeds(x: [f64; 2], y: [f64; 2]) -> bool {
    let (p, q) = (x[0] * x[1], y[0] * y[1]);
    if p != q {
        return p > q;
    }
    // Rounding is monotone, so only equal products need their rounding errors, which a fused product gives exactly.
    x[0].mul_add(x[1], -p) > y[0].mul_add(y[1], -q)
}

/// Decisions of all ambiguous faces.
pub fn joined_faces(mask: u8, values: &[f64; 8]) -> u8 {
    let ambiguous = ambiguous_faces(mask);
    FACE_CORNERS.iter().enumerate().fold(0, |set, (f, corners)| {
        let joined = ambiguous >> f & 1 == 1 && face_joined(corners.map(|c| values[usize::from(c)]));
        set | u8::from(joined) << f
    })
}

/// Interior ambiguity.
pub fn interior_ambiguous(mask: u8, faces: u8) -> bool {
    !TABLE.entry(mask, faces).tunnels.is_empty()
}

/// Lower corners of the four edges along `axis`, cyclically.
fn strands(axis: usize) -> [usize; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    [0, u, u | v, v]
}

/// The side face between strands `k` and `k + 1` along `axis`.
fn side_face(axis: usize, k: usize) -> usize {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    [2 * v, 2 * u + 1, 2 * v + 1, 2 * u][k]
}

/// Interior test.
pub fn tunnel(mask: u8, faces: u8, values: &[f64; 8]) -> u8 {
    tunnel_along(2, mask, faces, values)
}

fn tunnel_along(axis: usize, mask: u8, faces: u8, values: &[f64; 8]) -> u8 {
    let entry = TABLE.entry(mask, faces);
    if entry.tunnels.is_empty() {
        return 0;
    }
    let up = 1 << axis;
    let strands = strands(axis);
    let low = strands.map(|s| values[s]);
    let rise: [f64; 4] = std::array::from_fn(|k| values[strands[k] | up] - low[k]);
    // q(t) = q0 + q1 t + q2 t^2
    let q1 = low[0] * rise[2] + rise[0] * low[2] - low[1] * rise[3] - rise[1] * low[3];
    let q2 = rise[0] * rise[2] - rise[1] * rise[3];
    let t = -0.5 * q1 / q2;
    if !(t > 0.0 && t < 1.0) {
        return 0;
    }
    let at: [f64; 4] = std::array::from_fn(|k| low[k] + t * rise[k]);
    // A maximum of q joins the first and third strand, a minimum the other two.
    let d = usize::from(q2 > 0.0);
    let [a, b, c, e] = std::array::from_fn(|k| at[(d + k) % 4]);
    let alternates = (a > 0.0) == (c > 0.0) && (b > 0.0) == (e > 0.0) && (a > 0.0) != (b > 0.0);
    if !alternates || a * c <= b * e {
        return 0;
    }
    let sign = u8::from(a > 0.0);
    let region = |s: usize| if mask >> s & 1 == sign { entry.region[s] } else { entry.region[s | up] };
    let (p, q) = (region(strands[d]), region(strands[d + 2]));
    let pair = [p.min(q), p.max(q)];
    entry.tunnels.iter().position(|r| *r == pair).map_or(0, |k| k as u8 + 1)
}

/// Triangles of a case.
pub fn case(mask: u8, faces: u8, tunnel: u8) -> CellCase {
    let (triangles, interior_nodes) = TABLE.case(mask, faces, tunnel);
    CellCase { triangles, interior_nodes }
}
