//! Cutting triangles along their intersections, exactly, so that they meet in common nodes and edges only.

use std::cmp::Ordering;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::clean::is_flat;
use super::exact::ExactPoints;
use super::planar;
use crate::error::Result;
use crate::mesh::{TriMesh, self_intersections};
use crate::numeric::predicates::orient3d;
use crate::run::Run;

/// A set of triangles, each there once, with how often each side of it is used.
#[derive(Debug, Clone, Default)]
pub(super) struct Complex {
    pub(super) nodes: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) uses: Vec<Uses>,
}

/// What lies on a triangle of a [`Complex`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Uses {
    /// Triangles of solids that wind like it, and against it.
    pub(super) along: u16,
    pub(super) against: u16,
    /// Whether a sheet, which bounds nothing, lies here.
    pub(super) sheet: bool,
    pub(super) label: u32,
    /// For each of several bodies by itself how many of its triangles wind like this one, less how many wind against it.
    pub(super) jumps: [i8; MOST_BODIES],
}

/// So many bodies can be told apart in one complex: each costs a byte of every triangle.
pub const MOST_BODIES: usize = 16;

impl Complex {
    /// Triangles with the same nodes become one; those that name a node twice go.
    pub(super) fn new(nodes: Vec<DVec3>, triangles: impl IntoIterator<Item = ([u32; 3], Uses)>) -> Self {
        let mut all: Vec<([u32; 3], [u32; 3], u32, Uses)> = Vec::new();
        for (t, u) in triangles {
            if t[0] == t[1] || t[1] == t[2] || t[0] == t[2] {
                continue;
            }
            let mut s = t;
            s.sort_unstable();
            all.push((s, t, all.len() as u32, u));
        }
        all.sort_unstable_by_key(|a| (a.0, a.2));
        let mut out: Vec<(u32, [u32; 3], Uses)> = Vec::new();
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            let first = same[0].1;
            let mut uses = Uses { label: same[0].3.label, ..Uses::default() };
            for (_, t, _, u) in same {
                let (x, y) = if same_way(first, *t) { (u.along, u.against) } else { (u.against, u.along) };
                uses.along = uses.along.saturating_add(x);
                uses.against = uses.against.saturating_add(y);
                uses.sheet |= u.sheet;
                let sign = if same_way(first, *t) { 1 } else { -1 };
                uses.jumps.iter_mut().zip(u.jumps).for_each(|(sum, j)| *sum = sum.saturating_add(sign * j));
            }
            out.push((same[0].2, first, uses));
        }
        out.sort_unstable_by_key(|o| o.0);
        Self { nodes, triangles: out.iter().map(|o| o.1).collect(), uses: out.iter().map(|o| o.2).collect() }
    }

    fn mesh(&self) -> TriMesh {
        TriMesh::new(self.nodes.clone(), self.triangles.clone())
    }
}

/// Whether two triangles with the same nodes wind alike.
pub(super) fn same_way(a: [u32; 3], b: [u32; 3]) -> bool {
    let k = b.iter().position(|v| *v == a[0]).unwrap_or(0);
    b[(k + 1) % 3] == a[1]
}

/// Rounds of cutting and rounding.
const ROUNDS: usize = 10;

/// Cuts until no two triangles meet but in common nodes and edges. Constructed points are rounded to doubles, which may
/// bring new intersections of the size of rounding; they are cut again, with points nearer than a growing share of the
/// diagonal made one. `None` if that does not end.
pub(super) fn arrange(mut complex: Complex, diagonal: f64, run: &Run) -> Result<Option<Complex>> {
    for round in 0..ROUNDS {
        run.check()?;
        let mesh = complex.mesh();
        let pairs = self_intersections(&mesh, run)?;
        if pairs.is_empty() {
            return Ok(Some(complex));
        }
        complex = cut(&complex, &pairs, run)?;
        let reach = if round == 0 { 0.0 } else { diagonal * 1e-15 * 10f64.powi(round as i32) };
        merge_near(&mut complex, reach);
    }
    Ok(None)
}

/// Makes nodes within `reach` of each other one, at the place of the first of them.
pub(super) fn merge_near(complex: &mut Complex, reach: f64) {
    let mut to: Vec<u32> = (0..complex.nodes.len() as u32).collect();
    let mut grid: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
    let width = if reach > 0.0 { 2.0 * reach } else { 0.0 };
    for v in 0..complex.nodes.len() as u32 {
        let p = complex.nodes[v as usize];
        if width == 0.0 {
            let same = grid.entry(p.to_array().map(|x| (x + 0.0).to_bits() as i64)).or_default();
            to[v as usize] = *same.first().unwrap_or(&v);
            if same.is_empty() {
                same.push(v);
            }
            continue;
        }
        let cell = (p / width).floor().to_array().map(|x| x as i64);
        let near = (0..27)
            .filter_map(|n| grid.get(&[cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1]))
            .flatten()
            .filter(|u| complex.nodes[**u as usize].distance(p) <= reach)
            .min();
        match near {
            Some(u) => to[v as usize] = *u,
            None => grid.entry(cell).or_default().push(v),
        }
    }
    let renamed: Vec<([u32; 3], Uses)> =
        complex.triangles.iter().zip(&complex.uses).map(|(t, u)| (t.map(|v| to[v as usize]), *u)).collect();
    // what rounding laid on a line goes: the edges along it are cut at its corners in the next round
    let place = |v: u32| complex.nodes[v as usize];
    let renamed: Vec<([u32; 3], Uses)> = renamed.into_iter().filter(|(t, _)| !is_flat(t.map(place))).collect();
    *complex = Complex::new(std::mem::take(&mut complex.nodes), renamed);
}

/// What a triangle is cut by.
#[derive(Debug, Clone, Default)]
struct Cuts {
    points: Vec<u32>,
    segments: Vec<[u32; 2]>,
}

fn cut(complex: &Complex, pairs: &[[u32; 2]], run: &Run) -> Result<Complex> {
    let mut points = ExactPoints::new(&complex.nodes);
    let mut cuts: FxHashMap<u32, Cuts> = FxHashMap::default();
    for [t, u] in pairs {
        for v in [t, u].into_iter().flat_map(|t| complex.triangles[*t as usize]) {
            points.know(v);
        }
    }
    for (i, [t, u]) in pairs.iter().enumerate() {
        if i % 256 == 0 {
            run.check()?;
        }
        let (a, b) = (complex.triangles[*t as usize], complex.triangles[*u as usize]);
        contact(&mut points, a, b, |first, points, segment| {
            let c = cuts.entry(if first { *t } else { *u }).or_default();
            c.points.extend(points);
            c.segments.extend(segment);
        });
    }
    let mut out = Vec::with_capacity(complex.triangles.len());
    for t in 0..complex.triangles.len() {
        if t % 256 == 0 {
            run.check()?;
        }
        let (tri, uses) = (complex.triangles[t], complex.uses[t]);
        match cuts.get(&(t as u32)) {
            Some(c) => out
                .extend(planar::triangulate(&mut points, tri, &c.points, &c.segments)?.into_iter().map(|t| (t, uses))),
            None => out.push((tri, uses)),
        }
    }
    Ok(Complex::new(points.near, out))
}

/// The axis to look at a triangle along: the first across which it is not narrow.
pub(super) fn axis_of(p: [DVec3; 3]) -> usize {
    let n = (p[1] - p[0]).cross(p[2] - p[0]).abs();
    let flat = |axis: usize| {
        let f = |v: DVec3| glam::DVec2::new(v[(axis + 1) % 3], v[(axis + 2) % 3]);
        crate::numeric::predicates::orient2d(f(p[0]), f(p[1]), f(p[2])) == 0.0
    };
    // half the largest component, so that rounding does not decide between planes in one direction
    (0..3).find(|i| n[*i] >= 0.5 * n.max_element() && !flat(*i)).or_else(|| (0..3).find(|i| !flat(*i))).unwrap_or(0)
}

/// Finds where two triangles meet and hands it out: `(is it for the first, points, segment between two of them)`.
fn contact(points: &mut ExactPoints, a: [u32; 3], b: [u32; 3], mut found: impl FnMut(bool, &[u32], Option<[u32; 2]>)) {
    let at = |points: &ExactPoints, v: u32| points.near[v as usize];
    let side = |points: &ExactPoints, t: [u32; 3], v: u32| {
        if t.contains(&v) { 0.0 } else { orient3d(at(points, t[0]), at(points, t[1]), at(points, t[2]), at(points, v)) }
    };
    let (sa, sb) = (a.map(|v| side(points, b, v)), b.map(|v| side(points, a, v)));
    let (pa, pb) = (a.map(|v| at(points, v)), b.map(|v| at(points, v)));
    if sa == [0.0; 3] || sb == [0.0; 3] {
        let axis = axis_of(pa);
        for (first, t, u) in [(true, a, b), (false, b, a)] {
            for k in 0..3 {
                let edge = [u[k], u[(k + 1) % 3]];
                let on = clip(points, edge, t, axis);
                for w in on.windows(2) {
                    found(first, w, Some([w[0], w[1]]));
                }
                if let [one] = on[..] {
                    found(first, &[one], None);
                }
            }
        }
        return;
    }
    let mut on: Vec<u32> = Vec::new();
    for (t, u, s, pt, pu) in [(a, b, sa, pa, pb), (b, a, sb, pb, pa)] {
        let axis = axis_of(pu);
        for k in 0..3 {
            let (k2, p, q) = ((k + 1) % 3, t[k], t[(k + 1) % 3]);
            if s[k] == 0.0 && holds(points, u, p, axis) {
                on.push(p);
            }
            if s[k] * s[k2] < 0.0 || (s[k] > 0.0 && s[k2] < 0.0) || (s[k] < 0.0 && s[k2] > 0.0) {
                let turns: [f64; 3] = std::array::from_fn(|i| orient3d(pt[k], pt[k2], pu[i], pu[(i + 1) % 3]));
                if turns.iter().all(|x| *x >= 0.0) || turns.iter().all(|x| *x <= 0.0) {
                    on.push(points.line_plane(p, q, u));
                }
            }
        }
    }
    on.sort_unstable();
    on.dedup();
    let segment = if let [p, q] = on[..] { Some([p, q]) } else { None };
    found(true, &on, segment);
    found(false, &on, segment);
}

/// Whether the closed triangle holds the point, all in one plane seen along `axis`.
fn holds(points: &ExactPoints, t: [u32; 3], p: u32, axis: usize) -> bool {
    let s: [Ordering; 3] = std::array::from_fn(|i| points.orient(t[i], t[(i + 1) % 3], p, axis));
    !(s.contains(&Ordering::Less) && s.contains(&Ordering::Greater))
}

/// Points of a segment in a closed triangle of the same plane that matter, in their order along it: ends inside, crossings
/// with the sides, corners on it.
fn clip(points: &mut ExactPoints, [p, q]: [u32; 2], t: [u32; 3], axis: usize) -> Vec<u32> {
    let mut on: Vec<u32> = [p, q].into_iter().filter(|v| holds(points, t, *v, axis)).collect();
    for k in 0..3 {
        let (c, d) = (t[k], t[(k + 1) % 3]);
        let (s1, s2) = (points.orient(c, d, p, axis), points.orient(c, d, q, axis));
        let (s3, s4) = (points.orient(p, q, c, axis), points.orient(p, q, d, axis));
        let apart = |s: Ordering, t: Ordering| s != Ordering::Equal && t == s.reverse();
        if apart(s1, s2) && apart(s3, s4) {
            on.push(points.line_line([p, q], [c, d], axis));
        }
        if s3 == Ordering::Equal && planar::between(points, p, q, c, axis) {
            on.push(c);
        }
    }
    on.sort_unstable();
    on.dedup();
    planar::sort_along(points, p, q, axis, &mut on);
    on
}
