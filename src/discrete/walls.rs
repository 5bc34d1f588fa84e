//! Where the surface passes itself so closely that two meshes of it, each good by itself, would cross.

use std::collections::BinaryHeap;
use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::pieces::Discrete;
use crate::error::Result;
use crate::mesh::edit::NONE;
use crate::numeric::COS_60;
use crate::run::Run;
use crate::spatial::{segment_foot, triangle_foot};

/// Chords of both sides may take this share of the distance between them.
const ROOM: f64 = 0.8;
/// Sheets nearer to each other than this share of the edge length on planes are not told apart, unless both are planes.
const TINY: f64 = 0.002;
/// Two places are on different sheets where the way between them along the surface is longer than this many distances; on the
/// two sides of a wedge it is less.
const WAY: f64 = 4.0;
/// Triangles looked at on that way at most.
const MOST: usize = 256;
/// Long edges are divided until they have this many lengths that walls ask for: sizes that grow from both ends are hardly larger
/// in between.
const SPACING: f64 = 1.5;
/// Not into more nodes than this: it bounds memory where walls are thin beyond reason.
const MOST_NODES: usize = 1_000_000;
/// Places inside of an edge from which walls are looked for, at most.
const LOOKS: f64 = 8.0;

/// What walls and gaps ask for.
#[derive(Debug, Clone, PartialEq)]
pub struct WallSizes {
    /// For each node the edge length that keeps chords on both sides apart; infinite where there is no such wish.
    pub sizes: Vec<f64>,
    /// Triangles of sheets too near to each other to be told apart.
    pub tight: Vec<bool>,
}

/// From where another sheet is looked for: a node, or a point inside of an edge.
struct Place {
    at: DVec3,
    /// Triangles around it.
    around: Vec<u32>,
    node: u32,
    /// The edge length there without walls, how far such an edge gets from the surface, and from the line the place is on.
    length: f64,
    surface: f64,
    line: DVec3,
}

/// What is near a place on another sheet.
struct Opposite {
    triangle: u32,
    /// The edge length that is short enough; nothing where the sheets are not told apart.
    size: Option<f64>,
}

impl Discrete {
    /// Walls and gaps of the surface, seen from its nodes: an edge of length h is up to h²k/8 away from a surface of curvature
    /// k, and up to hθ/4 from a line that turns by θ. `wanted` says how long edges get at a curvature, `least` how short.
    ///
    /// *Does not guarantee* that walls are found that no node looks at from up to twice these distances.
    ///
    /// # Errors
    /// Cancellation.
    pub fn walls(&self, wanted: impl Fn(f64) -> f64 + Sync, least: f64, run: &Run) -> Result<WallSizes> {
        let m = &self.mesh;
        let lengths: Vec<f64> = self.bends.iter().map(|k| wanted(*k)).collect();
        let tiny = TINY * wanted(0.0);
        // Made before threads ask for it.
        self.everything();
        let look = |v: u32| self.opposite(&self.node_place(v, &lengths)?, &lengths, least, tiny);
        let one = |v: u32| match v % 1024 {
            0 => run.check().map(|()| look(v)),
            _ => Ok(look(v)),
        };
        let found: Vec<Option<Opposite>> =
            run.install(|| (0..m.node_capacity() as u32).into_par_iter().map(one).collect::<Result<_>>())?;
        let mut out =
            WallSizes { sizes: vec![f64::INFINITY; m.node_capacity()], tight: vec![false; m.triangle_capacity()] };
        for (v, o) in found.into_iter().enumerate() {
            let Some(Opposite { triangle, size }) = o else { continue };
            let Some(size) = size else {
                m.outgoing(v as u32).for_each(|h| out.tight[(h / 3) as usize] = true);
                out.tight[triangle as usize] = true;
                continue;
            };
            for x in m.corners(triangle).into_iter().chain([v as u32]) {
                out.sizes[x as usize] = out.sizes[x as usize].min(size);
            }
        }
        Ok(out)
    }

    /// Divides long edges of bent faces where what they pass is near and asks for shorter ones: [`walls`](Self::walls) sees it
    /// from nodes only, and a pipe of long facets has none but at its ends. The surface stays as it is.
    ///
    /// # Errors
    /// Cancellation.
    pub fn divide_walls(&mut self, wanted: impl Fn(f64) -> f64 + Sync, least: f64, run: &Run) -> Result<()> {
        let lengths: Vec<f64> = self.bends.iter().map(|k| wanted(*k)).collect();
        let tiny = TINY * wanted(0.0);
        let this = &*self;
        let m = &this.mesh;
        let base = |h: u32| lengths[m.origin(h) as usize].min(lengths[m.target(h) as usize]);
        let long: Vec<u32> = m.edges().filter(|&h| m.edge_length(h) > base(h) && this.is_divisible(h)).collect();
        if long.is_empty() {
            return Ok(());
        }
        this.everything();
        let shortest = |h: u32| {
            let looks = (m.edge_length(h) / base(h)).ceil().min(LOOKS);
            let seen = (0..looks as usize).filter_map(|k| {
                let place = this.edge_place(h, (k as f64 + 0.5) / looks, base(h));
                this.opposite(&place, &lengths, least, tiny)?.size
            });
            seen.fold(f64::INFINITY, f64::min)
        };
        let one =
            |(k, &h): (usize, &u32)| if k % 256 == 0 { run.check().map(|()| shortest(h)) } else { Ok(shortest(h)) };
        let sizes: Vec<f64> = run.install(|| long.par_iter().enumerate().map(one).collect::<Result<_>>())?;
        let asked: Vec<([u32; 2], f64)> =
            long.iter().zip(sizes).filter(|a| a.1.is_finite()).map(|(&h, s)| ([m.origin(h), m.target(h)], s)).collect();
        if !asked.is_empty() {
            self.divide(asked, run)?;
        }
        Ok(())
    }

    /// Whether an edge can be divided: creases and open borders know their nodes, and between planes there is nothing to ask.
    fn is_divisible(&self, h: u32) -> bool {
        let o = self.mesh.opposite(h);
        if o == NONE {
            return false;
        }
        let one_face = self.mesh.label(h / 3) == self.mesh.label(o / 3);
        if self.mesh.is_sharp(h) { !one_face } else { !self.is_flat(h / 3) }
    }

    /// Halves edges down to the lengths asked for, the longest first. Others stay, however long: bisected needles are needles, and
    /// there is no end of them.
    fn divide(&mut self, asked: Vec<([u32; 2], f64)>, run: &Run) -> Result<()> {
        let mut heap: BinaryHeap<_> = asked.into_iter().filter_map(|(e, s)| self.too_long(e, s)).collect();
        let before = self.mesh.node_capacity();
        while let Some((_, [a, b], bits)) = heap.pop() {
            let made = self.mesh.node_capacity() - before;
            if made > MOST_NODES {
                break;
            }
            if made.is_multiple_of(1024) {
                run.check()?;
            }
            let Some(h) = self.mesh.edge_between(a, b) else { continue };
            let x = self.mesh.split_edge(h, 0.5 * (self.mesh.point(a) + self.mesh.point(b)));
            self.bends.resize(self.mesh.node_capacity(), 0.0);
            self.bends[x as usize] = self.bends[a as usize].max(self.bends[b as usize]);
            let s = f64::from_bits(bits);
            heap.extend([a, b].into_iter().filter_map(|y| self.too_long([x, y], s)));
        }
        self.order = self.mesh.triangles().collect();
        self.everything = OnceLock::new();
        Ok(())
    }

    /// An edge by its length, where that is too long beside `size`: bits of positive numbers are in their order.
    fn too_long(&self, [a, b]: [u32; 2], size: f64) -> Option<(u64, [u32; 2], u64)> {
        let length = self.mesh.point(a).distance(self.mesh.point(b));
        (length > SPACING * size).then(|| (length.to_bits(), [a, b], size.to_bits()))
    }

    fn node_place(&self, v: u32, lengths: &[f64]) -> Option<Place> {
        let m = &self.mesh;
        let length = *lengths.get(v as usize).filter(|_| m.is_node(v))?;
        let around = m.outgoing(v).map(|h| h / 3).collect();
        let (surface, line) = (self.sagitta(v, length), self.bow(v, length));
        Some(Place { at: m.point(v), around, node: v, length, surface, line })
    }

    fn edge_place(&self, h: u32, share: f64, length: f64) -> Place {
        let m = &self.mesh;
        let [a, b] = [m.origin(h), m.target(h)];
        let around = [h, m.opposite(h)].into_iter().filter(|x| *x != NONE).map(|x| x / 3).collect();
        let surface = self.sagitta(a, length).max(self.sagitta(b, length));
        Place { at: m.point(a).lerp(m.point(b), share), around, node: NONE, length, surface, line: DVec3::ZERO }
    }

    /// How far an edge of length `h` at a node gets from the surface.
    fn sagitta(&self, v: u32, h: f64) -> f64 {
        0.125 * h * h * self.bends[v as usize]
    }

    /// How far an edge of length `h` gets from the line a node is on, as a vector.
    fn bow(&self, v: u32, h: f64) -> DVec3 {
        let m = &self.mesh;
        let mut ends = m.sharp_neighbors(v);
        let (Some(a), Some(b), None) = (ends.next(), ends.next(), ends.next()) else { return DVec3::ZERO };
        if m.is_pinned(v) {
            return DVec3::ZERO;
        }
        let (into, on) = (m.point(v) - m.point(a), m.point(b) - m.point(v));
        let mean = 0.5 * (into.length() + on.length());
        let bend = on.normalize_or_zero() - into.normalize_or_zero();
        bend * h * (0.125 * h / mean.max(f64::MIN_POSITIVE)).min(0.25)
    }

    /// The triangle of another sheet that faces the other way and is too close to a place.
    fn opposite(&self, place: &Place, lengths: &[f64], least: f64, tiny: f64) -> Option<Opposite> {
        let m = &self.mesh;
        let &Place { at: p, length, surface, line, .. } = place;
        let (mut up, mut flat) = (DVec3::ZERO, true);
        for &t in &place.around {
            up += m.area_vector(t).normalize_or_zero();
            flat &= self.is_flat(t);
        }
        let up = up.normalize_or_zero();
        let reach = (2.0 * surface.max(line.length()) / ROOM).max(tiny);
        let at = |t: u32| {
            let c = m.corner_points(t);
            let w = triangle_foot(p, c);
            c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
        };
        let away = |k: u32| {
            let t = self.order[k as usize];
            // What faces the other way does so within 60 degrees: slivers face anywhere.
            if m.area_vector(t).normalize_or_zero().dot(up) > -COS_60 || m.corners(t).contains(&place.node) {
                return f64::INFINITY;
            }
            p.distance_squared(at(t))
        };
        let (k, squared) = self.everything().nearest(p, reach, away).filter(|n| n.1.is_finite())?;
        let (triangle, distance) = (self.order[k as usize], squared.sqrt());
        let across = (at(triangle) - p).normalize_or_zero();
        let other = m.corners(triangle).into_iter().map(|x| self.sagitta(x, lengths[x as usize])).fold(0.0, f64::max);
        let bowed = surface.max(line.dot(across)) + other;
        if (flat && bowed == 0.0 && self.is_flat(triangle)) || self.is_beside(place, triangle, distance) {
            return None;
        }
        let room = ROOM * distance;
        if distance < tiny {
            return Some(Opposite { triangle, size: None });
        }
        (bowed > room).then(|| Opposite { triangle, size: Some((length * (room / bowed).sqrt()).max(least)) })
    }

    fn is_flat(&self, t: u32) -> bool {
        self.sheets[self.mesh.label(t) as usize].plane.is_some()
    }

    /// Whether a triangle is reached from a place without going away from it by more than a few times their distance.
    fn is_beside(&self, place: &Place, triangle: u32, distance: f64) -> bool {
        let m = &self.mesh;
        let (p, most) = (place.at, (WAY * distance).powi(2));
        let mut list = place.around.clone();
        let mut seen: FxHashSet<u32> = list.iter().copied().collect();
        let mut at = 0;
        while at < list.len().min(MOST) {
            let t = list[at];
            at += 1;
            for h in 3 * t..3 * t + 3 {
                let o = m.opposite(h);
                let edge = [m.origin(h), m.target(h)].map(|x| m.point(x));
                if o == NONE || segment_foot(p, edge).distance_squared(p) > most || !seen.insert(o / 3) {
                    continue;
                }
                if o / 3 == triangle {
                    return true;
                }
                list.push(o / 3);
            }
        }
        false
    }
}
