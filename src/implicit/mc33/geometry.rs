//! Polygons and annuli between crossings: which chords are allowed, which triangulation is best.

use glam::DVec3;

use super::{EDGES, INTERIOR_NODE, interior_position};

/// Three local nodes.
pub(super) type Triangle = [u8; 3];

/// Sets of root positions at which an annulus must not cross itself to be chosen.
///
/// The first few reject nearly all unfit ones; `no_cell_crosses_itself` checks the choice at thousands of others.
const TRIALS: usize = 32;

/// Triangles which refer to interior nodes `first..first + interior_nodes`.
#[derive(Debug, Clone, Default)]
pub(super) struct Patch {
    pub(super) triangles: Vec<Triangle>,
    pub(super) interior_nodes: u8,
}

/// Corner `c` of the unit cell.
pub(super) fn corner(c: u8) -> DVec3 {
    DVec3::new(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2 & 1))
}

/// The point of cube edge `e` at parameter `s`.
pub(super) fn on_edge(e: u8, s: f64) -> DVec3 {
    let [a, b] = EDGES[usize::from(e)].map(corner);
    a.lerp(b, s)
}

fn midpoint(e: u8) -> DVec3 {
    on_edge(e, 0.5)
}

/// The two cube faces at edge `e`, as a set of bits.
fn faces_at(e: u8) -> u8 {
    let [a, b] = EDGES[usize::from(e)];
    (0..3).filter(|axis| a >> axis & 1 == b >> axis & 1).fold(0, |set, axis| set | 1 << (2 * axis + (a >> axis & 1)))
}

/// Whether the chord between two local nodes runs through the inside of the cell.
///
/// A chord within a face could coincide with, or cross, one of the neighboring cell.
pub(super) fn is_free(a: u8, b: u8) -> bool {
    a >= INTERIOR_NODE || b >= INTERIOR_NODE || faces_at(a) & faces_at(b) == 0
}

/// Cost of a triangle: `perimeter^2 / area`, 20.8 for an equilateral one, larger for slivers.
fn cost([a, b, c]: [DVec3; 3]) -> f64 {
    let perimeter = a.distance(b) + b.distance(c) + c.distance(a);
    perimeter * perimeter / (0.5 * (b - a).cross(c - a).length())
}

/// A disk: the cheapest triangulation by free chords, or a fan around the interior node `center` if there is none.
pub(super) fn disk(nodes: &[u8], center: u8) -> Patch {
    match best_disk(nodes) {
        Some(triangles) => Patch { triangles, interior_nodes: 0 },
        None => fan(nodes, center),
    }
}

fn fan(nodes: &[u8], center: u8) -> Patch {
    let n = nodes.len();
    Patch { triangles: (0..n).map(|k| [nodes[k], nodes[(k + 1) % n], center]).collect(), interior_nodes: 1 }
}

/// The cheapest triangulation of a polygon of crossings by free chords, by dynamic programming over its chords.
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
                let c = best[i][k].0 + best[k][j].0 + cost([nodes[i], nodes[k], nodes[j]].map(midpoint));
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

/// An annulus between two loops, both directed as boundaries of the surface, which does not cross itself or `rest`.
///
/// Candidates are, in this order: a strip of free chords; two free chords which cut the annulus into two polygons, each
/// triangulated by free chords or by a fan; a ring of interior nodes. Interior nodes are numbered from `first`.
pub(super) fn annulus(a: &[u8], b: &[u8], rest: &[Triangle], first: u8) -> Patch {
    let mut candidates = two_polygons(a, b, first);
    candidates.extend(best_strip(a, b, midpoint).map(|triangles| Patch { triangles, interior_nodes: 0 }));
    // Bits of positive floats order as the floats do.
    candidates.sort_by_cached_key(|p| (p.interior_nodes, area(&p.triangles).to_bits()));
    let fits = |patch: &Patch| {
        // A node between crossings of one face only would lie in that face.
        let places = place(&patch.triangles, midpoint);
        if places.iter().skip(usize::from(first)).any(|p| p.min_element() <= 0.0 || p.max_element() >= 1.0) {
            return false;
        }
        let all: Vec<Triangle> = patch.triangles.iter().chain(rest).copied().collect();
        (0..TRIALS).all(|k| !crosses(&all, &place(&all, |e| on_edge(e, trial_root(k, e)))))
    };
    let (core, other) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    candidates.into_iter().find(fits).unwrap_or_else(|| ring(core, other, first))
}

/// Root position of edge `e` in trial `k`: the middle first, then more often near the ends than between.
fn trial_root(k: usize, e: u8) -> f64 {
    let step = (f64::from(e) + 2.0).sqrt() * std::f64::consts::PI;
    0.5 - 0.5 * (std::f64::consts::PI * (0.5 + k as f64 * step).fract()).cos()
}

fn area(triangles: &[Triangle]) -> f64 {
    let at = place(triangles, midpoint);
    let twice = |t: &Triangle| {
        let [a, b, c] = t.map(|v| at[usize::from(v)]);
        (b - a).cross(c - a).length()
    };
    triangles.iter().map(twice).sum()
}

fn two_polygons(a: &[u8], b: &[u8], first: u8) -> Vec<Patch> {
    let chords: Vec<[usize; 2]> =
        (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| [i, j])).filter(|&[i, j]| is_free(a[i], b[j])).collect();
    let mut patches = Vec::new();
    for &[i, j] in &chords {
        for &[k, l] in chords.iter().filter(|&&[k, l]| k > i && l != j) {
            let polygons = [[arc(a, i, k), arc(b, l, j)].concat(), [arc(a, k, i), arc(b, j, l)].concat()];
            for fans in 0..4 {
                let mut patch = Patch::default();
                for (w, nodes) in polygons.iter().enumerate() {
                    let center = first + patch.interior_nodes;
                    let part = if fans >> w & 1 == 1 { fan(nodes, center) } else { disk(nodes, center) };
                    patch.triangles.extend(part.triangles);
                    patch.interior_nodes += part.interior_nodes;
                }
                if uses_edges_once(&patch.triangles) {
                    patches.push(patch);
                }
            }
        }
    }
    patches
}

/// An annulus by way of a ring of interior nodes, one beside each node of the loop `core`.
fn ring(core: &[u8], other: &[u8], first: u8) -> Patch {
    let waist: Vec<DVec3> = core
        .iter()
        .map(|&v| {
            let far = |w: u8| midpoint(v).distance_squared(midpoint(w));
            let least = other.iter().map(|&w| far(w)).fold(f64::INFINITY, f64::min);
            let nearest: Vec<DVec3> = other.iter().filter(|&&w| far(w) <= least).map(|&w| midpoint(w)).collect();
            midpoint(v).midpoint(nearest.iter().sum::<DVec3>() / nearest.len() as f64)
        })
        .collect();
    let at = |v: u8| if v < first { midpoint(v) } else { waist[usize::from(v - first)] };
    let forth: Vec<u8> = (first..).take(core.len()).collect();
    let back: Vec<u8> = forth.iter().rev().copied().collect();
    let triangles =
        [best_strip(core, &back, at), best_strip(&forth, other, at)].into_iter().flatten().flatten().collect();
    Patch { triangles, interior_nodes: core.len() as u8 }
}

/// The part of a loop from index `i` to index `j`, both included.
fn arc(nodes: &[u8], i: usize, j: usize) -> Vec<u8> {
    let n = nodes.len();
    (0..=(j + n - i) % n).map(|d| nodes[(i + d) % n]).collect()
}

/// Whether no directed edge occurs twice; a strip may come back to a chord too early, and two polygons may share a
/// diagonal.
fn uses_edges_once(triangles: &[Triangle]) -> bool {
    let mut edges: Vec<[u8; 2]> = edges_of(triangles).collect();
    edges.sort_unstable();
    edges.windows(2).all(|w| w[0] != w[1])
}

/// The directed edges of all triangles.
pub(super) fn edges_of(triangles: &[Triangle]) -> impl Iterator<Item = [u8; 2]> + '_ {
    triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
}

/// The cheapest strip of triangles between two loops by free chords, both directed as boundaries of the surface.
fn best_strip(a: &[u8], b: &[u8], at: impl Fn(u8) -> DVec3 + Copy) -> Option<Vec<Triangle>> {
    let mut best = (f64::INFINITY, Vec::new());
    for start in 0..b.len() {
        // The strip opens and closes with the chord a[0] b[start].
        Strip { at, a, b, start, triangles: Vec::new(), best: &mut best }.extend(0, 0, 0.0);
    }
    best.0.is_finite().then_some(best.1)
}

/// Depth-first search over strips, which run along `a` and against `b`.
struct Strip<'a, P> {
    at: P,
    a: &'a [u8],
    b: &'a [u8],
    start: usize,
    triangles: Vec<Triangle>,
    best: &'a mut (f64, Vec<Triangle>),
}

impl<P: Fn(u8) -> DVec3 + Copy> Strip<'_, P> {
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
            self.extend(i, j, sum + cost(t.map(self.at)));
            self.triangles.pop();
        }
    }
}

/// Positions of all local nodes, given those of the crossings.
pub(super) fn place(triangles: &[Triangle], crossing: impl Fn(u8) -> DVec3) -> Vec<DVec3> {
    let roots: [DVec3; 12] = std::array::from_fn(|e| crossing(e as u8));
    let end = triangles.iter().flatten().fold(INTERIOR_NODE, |end, &v| end.max(v + 1));
    roots.into_iter().chain((INTERIOR_NODE..end).map(|v| interior_position(triangles, v, &roots))).collect()
}

/// Whether two of the triangles cross; touching does not count.
pub(super) fn crosses(triangles: &[Triangle], at: &[DVec3]) -> bool {
    let point = |v: u8| at[usize::from(v)];
    let hits = |s: Triangle, t: Triangle| {
        edges_of(&[s])
            .filter(|e| e.iter().all(|v| !t.contains(v)))
            .any(|[u, v]| pierces(point(u), point(v), t.map(point)))
    };
    // Most pairs are told apart by the plane of one of them.
    let one_side = |s: Triangle, t: Triangle| {
        let [a, b, c] = t.map(point);
        let side = s.map(|v| volume(a, b, c, point(v)));
        side.iter().all(|&v| v >= 0.0) || side.iter().all(|&v| v <= 0.0)
    };
    let cross = |s, t| !one_side(s, t) && !one_side(t, s) && (hits(s, t) || hits(t, s));
    triangles.iter().enumerate().any(|(i, &s)| triangles[..i].iter().any(|&t| cross(s, t)))
}

/// Six times the signed volume of a tetrahedron.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}

/// Whether a segment passes through the inside of a triangle.
fn pierces(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    if volume(a, b, c, p) * volume(a, b, c, q) >= 0.0 {
        return false;
    }
    let turn = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    turn.iter().all(|&v| v > 0.0) || turn.iter().all(|&v| v < 0.0)
}
