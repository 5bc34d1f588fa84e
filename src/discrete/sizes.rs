//! What edge lengths a soup's own shape asks for: curvature at a scale, and the distance between features.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::features::{Chain, chains};
use super::pieces::{Discrete, each_sector};
use crate::mesh::EditMesh;
use crate::mesh::edit::{NONE, next, prev};
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Edges between two features may be this many times as long as these are apart: triangles between them then keep angles
/// above 25 degrees.
const ACROSS: f64 = 2.0;
/// Edges may be this many times as long as a short feature between two corners: triangles upon it then have angles near 40
/// degrees.
const OWN: f64 = 1.5;
/// Parts per size into which feature edges close to others are divided.
const SPACING: f64 = 2.0;
/// How many parts one edge has at most: with a size that small the mesh is refused elsewhere, and a list longer than this fills memory first.
const MOST_PARTS: f64 = 1e5;
/// Places at which the distance of an edge to its line is measured.
const BOW_PLACES: usize = 8;
/// The factor by which edges get shorter until that distance is small enough.
const SHORTER: f64 = 0.9;
/// Edges shorter than this share of what curvature is measured over show too little of it: triangles around are looked at, too.
const FINE: f64 = 0.5;
/// So many of them at most: each node has its own, and a finer mesh would cost the square of its triangles.
const MOST_FINE: usize = 512;
/// Of noise, normals are known to this share of what they differ by around a node.
const KNOWN: f64 = 0.5;
/// Facets that turn by less than this, where they turn, tell how a surface bends: 5 degrees, a quarter of what edges turn by unless told
/// otherwise. Coarser ones, as of scans, may be noise, and tell little about bends within the length of an edge.
const SMOOTH: f64 = std::f64::consts::PI / 36.0;
/// Rounds of averaging normals: enough for noise of the input's own triangles.
const MOST_ROUNDS: usize = 30;

/// The larger magnitude of the principal curvatures at the origin of each half-edge, from corner normals averaged over
/// about `scale`: what is finer than that is noise, unless the triangles are [smooth](is_smooth). Geometric edges part the averages.
pub(super) fn curvatures(m: &EditMesh, corner_normals: &[DVec3], scale: f64, smooth: bool) -> Vec<f64> {
    let mut normals = corner_normals.to_vec();
    let (mut sum, mut count) = (0.0, 0usize);
    for h in m.edges() {
        sum += m.edge_length(h);
        count += 1;
    }
    let mean = if count > 0 { sum / count as f64 } else { 0.0 };
    // Each round averages over about an edge length; the spread grows with the root of their number.
    let rounds = if mean > 0.0 && !smooth { ((scale / mean).powi(2).round() as usize).min(MOST_ROUNDS) } else { 0 };
    for _ in 0..rounds {
        let old = normals.clone();
        for h in m.triangles().flat_map(|t| 3 * t..3 * t + 3) {
            normals[h as usize] += 0.5 * (old[next(h) as usize] + old[prev(h) as usize]);
        }
        for v in m.nodes() {
            each_sector(m, v, |sector| {
                let unit = sector.iter().map(|&h| normals[h as usize]).sum::<DVec3>().normalize_or_zero();
                sector.iter().for_each(|&h| normals[h as usize] = unit);
            });
        }
    }
    // Over less than that normals differ by what is left of the noise: slivers, as marching cubes make them, would bend a lot.
    let shortest = mean.min(scale);
    let mut out = vec![0.0f64; normals.len()];
    for h in m.triangles().flat_map(|t| 3 * t..3 * t + 3) {
        let length = m.edge_length(h);
        if length > 0.0 {
            let k = normals[h as usize].distance(normals[next(h) as usize]) / length.max(shortest);
            for end in [h, next(h)] {
                out[end as usize] = out[end as usize].max(k);
            }
        }
    }
    let mut around = FxHashSet::default();
    for v in m.nodes() {
        each_sector(m, v, |sector| {
            let mut most = sector.iter().map(|&h| out[h as usize]).fold(0.0, f64::max);
            // Where there are no rounds facets may be far shorter than others are on average; noise is not told from them otherwise.
            let fine = if smooth { 1.0 } else { FINE };
            if rounds == 0 && sector.iter().any(|&h| m.edge_length(h) < fine * shortest) {
                most = most.max(bend_beyond(
                    m,
                    &normals,
                    sector,
                    [shortest, if smooth { 0.0 } else { KNOWN }],
                    &mut around,
                ));
            }
            sector.iter().for_each(|&h| out[h as usize] = most);
        });
    }
    out
}

/// By how much facets turn from one to the next within faces, radians: the mean over the turns themselves, so that planes do not
/// count.
fn facet_turn(m: &EditMesh) -> f64 {
    let mut sums = [0.0; 2];
    for h in m.edges().filter(|&h| !m.is_sharp(h) && m.opposite(h) != NONE) {
        let [a, b] = [h, m.opposite(h)].map(|x| m.area_vector(x / 3));
        let turn = a.cross(b).length().atan2(a.dot(b));
        let weight = m.edge_length(h) * turn;
        sums = [sums[0] + weight, sums[1] + weight * turn];
    }
    if sums[0] > 0.0 { sums[1] / sums[0] } else { 0.0 }
}

/// Whether facets are fine enough to tell how the surface bends within the length of an edge.
pub(super) fn is_smooth(m: &EditMesh) -> bool {
    facet_turn(m) <= SMOOTH
}

/// How much normals differ between a sector and what lies `shortest` and more from its node: facets far shorter than that, as
/// of a finely divided wall, differ by little from one to the next. Normals are known to a share of that.
fn bend_beyond(
    m: &EditMesh,
    normals: &[DVec3],
    sector: &[u32],
    [shortest, share]: [f64; 2],
    seen: &mut FxHashSet<u32>,
) -> f64 {
    let (p, normal) = (m.point(m.origin(sector[0])), normals[sector[0] as usize]);
    let mut list: Vec<u32> = sector.iter().map(|&h| h / 3).collect();
    seen.clear();
    seen.extend(&list);
    let turn = |h: u32| normals[next(h) as usize].distance(normal).max(normals[prev(h) as usize].distance(normal));
    let known = share * sector.iter().map(|&h| turn(h)).fold(0.0, f64::max);
    let (mut most, mut at) = (0.0f64, 0);
    while at < list.len().min(MOST_FINE) {
        let t = list[at];
        at += 1;
        let away = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| m.point(m.origin(h)).distance(p));
        for k in 0..3 {
            let h = 3 * t + k as u32;
            most = most.max((normals[h as usize].distance(normal) - known) / away[k].max(shortest));
            let o = m.opposite(h);
            let near = away[k].min(away[(k + 1) % 3]) < shortest;
            if near && o != NONE && !m.is_sharp(h) && seen.insert(o / 3) {
                list.push(o / 3);
            }
        }
    }
    most
}

impl Discrete {
    /// How many times as many triangles the lengths `wanted` at curvatures make as those wanted on planes would.
    pub fn crowding(&self, wanted: impl Fn(f64) -> f64) -> f64 {
        let plain = wanted(0.0).powi(2);
        let sums = self.sheets.iter().map(|s| s.crowding(&wanted)).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        if sums[0] > 0.0 { plain * sums[1] / sums[0] } else { 1.0 }
    }

    /// For each node of a feature the edge length between `least` and `size` whose chord stays within `chord` of it: the face beside a
    /// hole may be a plane, or a cone, and bend less than its border. Infinite where that is `size`.
    pub fn bow_sizes(&self, size: f64, least: f64, chord: f64) -> Vec<f64> {
        let m = &self.mesh;
        let mut out = vec![f64::INFINITY; m.node_capacity()];
        for chain in chains(m) {
            // Creases that end within a face do so where noise, or a scan, blurs them.
            let (h, o) = (chain.edges[0], m.opposite(chain.edges[0]));
            if o != NONE && m.label(h / 3) == m.label(o / 3) {
                continue;
            }
            let bow = Bow::new(m, &chain);
            for (k, &v) in chain.nodes.iter().enumerate() {
                let wanted = bow.longest(k, size, least, chord);
                if wanted < size {
                    out[v as usize] = out[v as usize].min(wanted);
                }
            }
        }
        out
    }

    /// For each node the edge length that features nearby ask for, between `least` and `size`; infinite where none does. A
    /// feature asks for twice its distance to others across a common face, and for half as much again as its own length.
    pub fn feature_sizes(&self, size: f64, least: f64) -> Vec<f64> {
        let near = Proximity::new(&self.mesh, size);
        let mut out = vec![f64::INFINITY; self.mesh.node_capacity()];
        for (c, chain) in near.chains.iter().enumerate() {
            for &v in &chain.nodes {
                let wanted = near.wanted(c, self.mesh.point(v)).max(least);
                if wanted < size {
                    out[v as usize] = out[v as usize].min(wanted);
                }
            }
        }
        out
    }
}

/// A geometric edge as a line by its length.
struct Bow {
    points: Vec<DVec3>,
    lengths: Vec<f64>,
    closed: bool,
}

impl Bow {
    fn new(m: &EditMesh, chain: &Chain) -> Self {
        let points: Vec<DVec3> = chain.nodes.iter().map(|&v| m.point(v)).collect();
        let mut lengths = vec![0.0; points.len()];
        for i in 1..points.len() {
            lengths[i] = lengths[i - 1] + points[i - 1].distance(points[i]);
        }
        Self { points, lengths, closed: chain.is_closed() }
    }

    fn total(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The point after a length.
    fn at(&self, s: f64) -> DVec3 {
        let s = if self.closed && self.total() > 0.0 { s.rem_euclid(self.total()) } else { s };
        let i = self.lengths.partition_point(|x| *x < s).clamp(1, self.lengths.len() - 1);
        let step = (self.lengths[i] - self.lengths[i - 1]).max(f64::MIN_POSITIVE);
        self.points[i - 1].lerp(self.points[i], ((s - self.lengths[i - 1]) / step).clamp(0.0, 1.0))
    }

    /// The longest edge around a node that stays within `chord` of the line. It is the line's mean distance to one side that
    /// counts, which for an arc is two thirds of the largest: to and fro, as noise goes, it is none.
    fn longest(&self, node: usize, size: f64, least: f64, chord: f64) -> f64 {
        let total = self.total();
        let mut length = if self.closed { size.min(total / 3.0) } else { size.min(total) };
        while length > least {
            let from = self.lengths[node] - 0.5 * length;
            let from = if self.closed { from } else { from.clamp(0.0, total - length) };
            let ends = [self.at(from), self.at(from + length)];
            let off = |k: usize| {
                let share = (k as f64 + 0.5) / BOW_PLACES as f64;
                self.at(from + share * length) - ends[0].lerp(ends[1], share)
            };
            let mean = (0..BOW_PLACES).map(off).sum::<DVec3>() / BOW_PLACES as f64;
            if 1.5 * mean.length() <= chord {
                break;
            }
            length *= SHORTER;
        }
        // A line that is shorter than that is not to blame.
        if length < size.min(total) || self.closed { length.max(least) } else { size }
    }
}

/// Divides long feature edges that pass others closely, so that sizes can differ along them; labels must be faces.
pub(super) fn divide_features(mesh: &mut EditMesh, size: f64) {
    let near = Proximity::new(mesh, size);
    let mut long = Vec::new();
    for (c, chain) in near.chains.iter().enumerate() {
        for &h in &chain.edges {
            let (p, q) = (mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
            let parts = (SPACING * p.distance(q) / size).ceil().min(MOST_PARTS) as usize;
            if (1..parts).any(|k| near.wanted(c, p.lerp(q, k as f64 / parts as f64)) < size) {
                long.push((h, parts));
            }
        }
    }
    for (h, parts) in long {
        let (p, q) = (mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)));
        // From the far end: the half-edge keeps its origin.
        for k in (1..parts).rev() {
            mesh.split_edge(h, p.lerp(q, k as f64 / parts as f64));
        }
    }
}

/// Geometric edges and how close others pass.
struct Proximity {
    chains: Vec<Chain>,
    /// For each chain the faces on both sides.
    faces: Vec<[u32; 2]>,
    segments: Vec<([DVec3; 2], u32)>,
    tree: Bvh,
    size: f64,
}

impl Proximity {
    fn new(m: &EditMesh, size: f64) -> Self {
        let chains = chains(m);
        let mut segments: Vec<([DVec3; 2], u32)> = Vec::new();
        for (c, chain) in chains.iter().enumerate() {
            segments.extend(chain.nodes.windows(2).map(|w| ([m.point(w[0]), m.point(w[1])], c as u32)));
        }
        let tree = Bvh::new(segments.iter().map(|s| Aabb::around(s.0)).collect());
        let sides = |h: u32| [h, m.opposite(h)].map(|s| if s == NONE { NONE } else { m.label(s / 3) });
        let faces = chains.iter().map(|c| sides(c.edges[0])).collect();
        Self { chains, faces, segments, tree, size }
    }

    fn ends(&self, c: usize) -> [u32; 2] {
        [self.chains[c].nodes[0], self.chains[c].nodes[self.chains[c].nodes.len() - 1]]
    }

    /// Whether the distance between two chains says how narrow a face is: they share one, and do not meet.
    fn are_across(&self, a: usize, b: usize) -> bool {
        let meet = self.ends(a).iter().any(|v| self.ends(b).contains(v));
        a != b && !meet && self.faces[a].iter().any(|f| *f != NONE && self.faces[b].contains(f))
    }

    /// The edge length wanted at a point of a chain.
    fn wanted(&self, c: usize, p: DVec3) -> f64 {
        let far = |k: u32| {
            let (segment, other) = self.segments[k as usize];
            if !self.are_across(c, other as usize) {
                return f64::INFINITY;
            }
            p.distance_squared(segment_foot(p, segment))
        };
        let chain = &self.chains[c];
        let own = if chain.is_closed() { f64::INFINITY } else { OWN * chain.length };
        self.tree.nearest(p, self.size / ACROSS, far).map_or(own, |n| own.min(ACROSS * n.1.sqrt()))
    }
}
