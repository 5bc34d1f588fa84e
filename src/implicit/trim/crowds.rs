//! Points where leaves meet otherwise than two along an edge and three at a corner.

use glam::DVec3;

use super::super::leaf::Leaf;
use super::super::newton::nearest;
use super::Unfit;
use crate::geometry::common_normal;

/// Leaves at a smaller angle than this (its cosine) to each other may touch nearby.
const CLOSE: f64 = 0.85;
/// Where leaves touch is looked for so many cells around where parts do not fit,
const REACH: f64 = 2.0;
/// from places so many cells apart,
const APART: f64 = 0.5;
/// and from so many at most.
const STARTS: usize = 64;
/// Leaves pass through a point if they are nearer to it than this share of the part's size.
const THROUGH: f64 = 1e-12;
/// Points nearer to each other than this share of a cell are one that was found twice.
const SAME: f64 = 1e-6;

/// A point where more than three leaves meet, or some touch.
#[derive(Debug, Clone)]
pub(super) struct Crowd {
    pub(super) at: DVec3,
    pub(super) leaves: Vec<u32>,
    /// Whether two of them have one normal there.
    pub(super) touching: bool,
}

/// Points near some others at which leaves touch that cross around there.
pub(super) fn touching(leaves: &[Leaf], own: &[u32], near: &Unfit, cell: f64, scale: f64) -> Vec<Crowd> {
    let mut starts: Vec<DVec3> = Vec::new();
    for p in near {
        if starts.len() < STARTS && starts.iter().all(|q| q.distance(*p) > APART * cell) {
            starts.push(*p);
        }
    }
    let normal = |l: u32, p: DVec3| leaves[l as usize].slope(p).try_normalize();
    let distance = |l: u32, p: DVec3| {
        let d = leaves[l as usize].gradient(p);
        d.v.abs() / d.g.length()
    };
    let able: Vec<u32> = own.iter().copied().filter(|l| !matches!(leaves[*l as usize], Leaf::Fillet(_))).collect();
    let is_plane = |l: u32| matches!(leaves[l as usize], Leaf::Plane { .. });
    let mut found: Vec<Crowd> = Vec::new();
    for start in starts {
        let around: Vec<u32> = able.iter().copied().filter(|l| distance(*l, start) < REACH * cell).collect();
        for (k, &i) in around.iter().enumerate() {
            for &j in around[k + 1..].iter().filter(|j| !(is_plane(i) && is_plane(**j))) {
                let (Some(n), Some(o)) = (normal(i, start), normal(j, start)) else { continue };
                if n.dot(o).abs() < CLOSE {
                    continue;
                }
                let onto = |p: DVec3| nearest(leaves, &[i], p, REACH * cell, scale);
                let normals = |p: DVec3| Some([normal(i, p)?, normal(j, p)?]);
                let Some(at) = common_normal(start, [cell, REACH], onto, normals) else { continue };
                if !(distance(j, at) <= THROUGH * scale) || found.iter().any(|c| c.at.distance(at) < SAME * cell) {
                    continue;
                }
                let leaves = able.iter().copied().filter(|l| distance(*l, at) <= THROUGH * scale).collect();
                found.push(Crowd { at, leaves, touching: true });
            }
        }
    }
    found
}
