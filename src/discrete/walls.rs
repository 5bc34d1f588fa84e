//! Where the surface passes itself so closely that two meshes of it, each good by itself, would cross.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::pieces::Discrete;
use crate::error::Result;
use crate::mesh::edit::NONE;
use crate::run::Run;
use crate::spatial::{segment_foot, triangle_foot};

/// Chords of both sides may take this share of the distance between them.
const ROOM: f64 = 0.8;
/// Sheets nearer to each other than this share of the edge length on planes are not told apart, unless both are planes.
const TINY: f64 = 0.002;
/// Two places are on different sheets where the way between them along the surface is longer than this many distances; on the
/// two sides of a wedge it is less.
const WAY: f64 = 4.0;
/// What faces the other way does so within 60 degrees (cosine): slivers face anywhere.
const OTHER_WAY: f64 = 0.5;
/// Triangles looked at on that way at most.
const MOST: usize = 256;

/// What walls and gaps ask for.
#[derive(Debug, Clone, PartialEq)]
pub struct Walls {
    /// For each node the edge length that keeps chords on both sides apart; infinite where there is no such wish.
    pub sizes: Vec<f64>,
    /// Triangles of sheets too near to each other to be told apart.
    pub tight: Vec<bool>,
}

/// What is near a node on another sheet.
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
    pub fn walls(&self, wanted: impl Fn(f64) -> f64 + Sync, least: f64, run: &Run) -> Result<Walls> {
        let m = &self.mesh;
        let lengths: Vec<f64> = self.bends.iter().map(|k| wanted(*k)).collect();
        let tiny = TINY * wanted(0.0);
        // Made before threads ask for it.
        self.everything();
        let one = |v: u32| match v % 1024 {
            0 => run.check().map(|()| self.opposite(v, &lengths, least, tiny)),
            _ => Ok(self.opposite(v, &lengths, least, tiny)),
        };
        let found: Vec<Option<Opposite>> =
            run.install(|| (0..m.node_capacity() as u32).into_par_iter().map(one).collect::<Result<_>>())?;
        let mut out =
            Walls { sizes: vec![f64::INFINITY; m.node_capacity()], tight: vec![false; m.triangle_capacity()] };
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

    /// The triangle of another sheet that faces the other way and is too close to a node.
    fn opposite(&self, v: u32, lengths: &[f64], least: f64, tiny: f64) -> Option<Opposite> {
        let m = &self.mesh;
        if !m.is_node(v) {
            return None;
        }
        let (p, length) = (m.point(v), lengths[v as usize]);
        let (surface, line) = (self.sagitta(v, length), self.bow(v, length));
        let (mut up, mut flat) = (DVec3::ZERO, true);
        for h in m.outgoing(v) {
            up += m.area_vector(h / 3).normalize_or_zero();
            flat &= self.is_flat(h / 3);
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
            if m.area_vector(t).normalize_or_zero().dot(up) > -OTHER_WAY || m.corners(t).contains(&v) {
                return f64::INFINITY;
            }
            p.distance_squared(at(t))
        };
        let (k, squared) = self.everything().nearest(p, reach, away).filter(|n| n.1.is_finite())?;
        let (triangle, distance) = (self.order[k as usize], squared.sqrt());
        let across = (at(triangle) - p).normalize_or_zero();
        let other = m.corners(triangle).into_iter().map(|x| self.sagitta(x, lengths[x as usize])).fold(0.0, f64::max);
        let bowed = surface.max(line.dot(across)) + other;
        if (flat && bowed == 0.0 && self.is_flat(triangle)) || self.is_beside(v, triangle, distance) {
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

    /// Whether a triangle is reached from a node without going away from it by more than a few times their distance.
    fn is_beside(&self, v: u32, triangle: u32, distance: f64) -> bool {
        let m = &self.mesh;
        let (p, most) = (m.point(v), (WAY * distance).powi(2));
        let mut list: Vec<u32> = m.outgoing(v).map(|h| h / 3).collect();
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
