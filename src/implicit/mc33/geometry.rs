//! Polygons and strips between crossings: which chords are allowed, which triangulation is best.

use glam::DVec3;

use super::{EDGES, INTERIOR_NODE};

/// Three local nodes.
pub(super) type Triangle = [u8; 3];

/// The middle of cube edge `e` in the unit cell.
pub(super) fn midpoint(e: u8) -> DVec3 {
    let [a, b] = EDGES[usize::from(e)].map(corner);
    (a + b) * 0.5
}

/// Corner `c` of the unit cell.
pub(super) fn corner(c: u8) -> DVec3 {
    DVec3::new(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2 & 1))
}

/// The two cube faces at edge `e`, as a set of bits.
pub(super) fn faces_at(e: u8) -> u8 {
    let [a, b] = EDGES[usize::from(e)];
    (0..3).filter(|axis| a >> axis & 1 == b >> axis & 1).fold(0, |set, axis| set | 1 << (2 * axis + (a >> axis & 1)))
}

/// Whether the chord between two crossings runs through the inside of the cell.
///
/// A chord within a face could coincide with, or cross, one of the neighboring cell.
pub(super) fn is_free(a: u8, b: u8) -> bool {
    faces_at(a) & faces_at(b) == 0
}

/// Cost of a triangle: `perimeter^2 / area` at the midpoints, 20.8 for an equilateral one, larger for slivers.
fn cost(t: Triangle) -> f64 {
    let [a, b, c] = t.map(midpoint);
    let perimeter = (b - a).length() + (c - b).length() + (a - c).length();
    perimeter * perimeter / (0.5 * (b - a).cross(c - a).length())
}

/// The cheapest triangulation of a loop by free chords, none if there is none.
fn best_disk(nodes: &[u8]) -> Option<Vec<Triangle>> {
    let n = nodes.len();
    // best[i][j]: cost of the polygon i..=j and the node k of the triangle (i, k, j) on its chord.
    let mut best = vec![vec![(0.0, 0); n]; n];
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            best[i][j] = (f64::INFINITY, 0);
            if span < n - 1 && !is_free(nodes[i], nodes[j]) {
                continue;
            }
            for k in i + 1..j {
                let c = best[i][k].0 + best[k][j].0 + cost([nodes[i], nodes[k], nodes[j]]);
                if c < best[i][j].0 {
                    best[i][j] = (c, k);
                }
            }
        }
    }
    if best[0][n - 1].0.is_infinite() {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        if j > i + 1 {
            let k = best[i][j].1;
            triangles.push([nodes[i], nodes[k], nodes[j]]);
            open.extend([(i, k), (k, j)]);
        }
    }
    Some(triangles)
}

/// The cheapest triangulation of a polygon, by a fan around an interior node where free chords do not do.
///
/// `interior_nodes` is the number of interior nodes so far, and counts the one made.
pub(super) fn disk(nodes: &[u8], interior_nodes: &mut u8) -> Vec<Triangle> {
    best_disk(nodes).unwrap_or_else(|| {
        let center = INTERIOR_NODE + *interior_nodes;
        *interior_nodes += 1;
        (0..nodes.len()).map(|k| [nodes[k], nodes[(k + 1) % nodes.len()], center]).collect()
    })
}

/// An annulus between two loops, both directed as boundaries of the surface.
///
/// A strip of triangles between free chords where there is one; else two free chords cut the annulus into two
/// polygons, the pair which needs fewest interior nodes and has the shortest chords.
pub(super) fn annulus(a: &[u8], b: &[u8], interior_nodes: &mut u8) -> Vec<Triangle> {
    let mut best = (f64::INFINITY, Vec::new());
    for start in 0..b.len() {
        // The strip opens and closes with the chord a[0] b[start].
        Strip { a, b, start, triangles: Vec::new(), best: &mut best }.extend(0, 0, 0.0);
    }
    if best.0.is_finite() {
        return best.1;
    }
    let mut best = (u8::MAX, f64::INFINITY, Vec::new());
    let chords: Vec<[usize; 2]> =
        (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| [i, j])).filter(|&[i, j]| is_free(a[i], b[j])).collect();
    for &[i, j] in &chords {
        for &[k, l] in chords.iter().filter(|&&[k, l]| k > i && l != j) {
            let length = [[i, j], [k, l]].map(|[i, j]| midpoint(a[i]).distance(midpoint(b[j]))).iter().sum();
            let mut count = 0;
            let mut triangles = disk(&[arc(a, i, k), arc(b, l, j)].concat(), &mut count);
            triangles.extend(disk(&[arc(a, k, i), arc(b, j, l)].concat(), &mut count));
            if (count, length) < (best.0, best.1) && uses_edges_once(&triangles) {
                best = (count, length, triangles);
            }
        }
    }
    for t in &mut best.2 {
        *t = t.map(|v| if v >= INTERIOR_NODE { v + *interior_nodes } else { v });
    }
    *interior_nodes += best.0;
    best.2
}

/// The part of a loop from index `i` to index `j`, both included.
fn arc(nodes: &[u8], i: usize, j: usize) -> Vec<u8> {
    let n = nodes.len();
    (0..=(j + n - i) % n).map(|d| nodes[(i + d) % n]).collect()
}

/// Whether no directed edge occurs twice; a strip may come back to a chord too early, and two polygons may share a
/// diagonal.
fn uses_edges_once(triangles: &[Triangle]) -> bool {
    let mut edges: Vec<[u8; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    edges.windows(2).all(|w| w[0] != w[1])
}

/// Depth-first search over strips.
struct Strip<'a> {
    a: &'a [u8],
    b: &'a [u8],
    start: usize,
    triangles: Vec<Triangle>,
    best: &'a mut (f64, Vec<Triangle>),
}

impl Strip<'_> {
    /// `i` steps along `a` and `j` steps against `b` are done.
    fn extend(&mut self, i: usize, j: usize, sum: f64) {
        let (n, m) = (self.a.len(), self.b.len());
        let at_b = |j: usize| self.b[(self.start + m - j % m) % m];
        let (p, q) = (self.a[i % n], at_b(j));
        if !is_free(p, q) || sum >= self.best.0 {
            return;
        }
        if i == n && j == m {
            if uses_edges_once(&self.triangles) {
                *self.best = (sum, self.triangles.clone());
            }
            return;
        }
        let along = (i < n).then(|| ([p, self.a[(i + 1) % n], q], i + 1, j));
        let against = (j < m).then(|| ([at_b(j + 1), q, p], i, j + 1));
        for (t, i, j) in [along, against].into_iter().flatten() {
            self.triangles.push(t);
            self.extend(i, j, sum + cost(t));
            self.triangles.pop();
        }
    }
}

#[cfg(test)]
pub(super) fn options(a: &[u8], b: &[u8]) -> Vec<(u8, Vec<Triangle>)> {
    let mut out = Vec::new();
    fn go(
        a: &[u8],
        b: &[u8],
        s: usize,
        i: usize,
        j: usize,
        cur: &mut Vec<Triangle>,
        out: &mut Vec<(u8, Vec<Triangle>)>,
    ) {
        let (n, m) = (a.len(), b.len());
        let at_b = |j: usize| b[(s + m - j % m) % m];
        let (p, q) = (a[i % n], at_b(j));
        if !is_free(p, q) {
            return;
        }
        if i == n && j == m {
            if uses_edges_once(cur) {
                out.push((0, cur.clone()));
            }
            return;
        }
        if i < n {
            cur.push([p, a[(i + 1) % n], q]);
            go(a, b, s, i + 1, j, cur, out);
            cur.pop();
        }
        if j < m {
            cur.push([at_b(j + 1), q, p]);
            go(a, b, s, i, j + 1, cur, out);
            cur.pop();
        }
    }
    for s in 0..b.len() {
        go(a, b, s, 0, 0, &mut Vec::new(), &mut out);
    }
    let chords: Vec<[usize; 2]> =
        (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| [i, j])).filter(|&[i, j]| is_free(a[i], b[j])).collect();
    for &[i, j] in &chords {
        for &[k, l] in chords.iter().filter(|&&[k, l]| k > i && l != j) {
            for o in 0..4 {
                let mut count = 0;
                let mut triangles = Vec::new();
                for (w, poly) in
                    [[arc(a, i, k), arc(b, l, j)].concat(), [arc(a, k, i), arc(b, j, l)].concat()].iter().enumerate()
                {
                    if o >> w & 1 == 1 {
                        let center = 12 + count;
                        count += 1;
                        triangles.extend((0..poly.len()).map(|x| [poly[x], poly[(x + 1) % poly.len()], center]));
                    } else if let Some(d) = best_disk(poly) {
                        triangles.extend(d);
                    } else {
                        triangles.clear();
                        break;
                    }
                }
                if !triangles.is_empty() && uses_edges_once(&triangles) && triangles.len() >= a.len() + b.len() {
                    out.push((count, triangles));
                }
            }
        }
    }
    out
}
