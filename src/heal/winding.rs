//! How often bodies wind around the points behind the triangles of a complex.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::arrange::{Complex, Uses};
use super::sides::{EdgeSide, Sides, directed, ends};
use crate::error::Result;
use crate::numeric::predicates::orient3d;
use crate::run::Run;

/// Triangles that have the same bodies in front of them and behind them, as they hang together.
pub(super) struct Patches<'a> {
    /// The patch of each triangle.
    pub(super) of: &'a [u32],
    pub(super) count: usize,
}

/// Solid angle of a triangle seen from the origin over 4 pi, by A. van Oosterom and J. Strackee (1983).
pub(super) fn winding([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let den = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    a.dot(b.cross(c)).atan2(den) / (2.0 * std::f64::consts::PI)
}

/// The winding number of what `jump` counts, the net number of bodies that a triangle bounds from behind, at the points just behind
/// each triangle.
///
/// One triangle of each part of the complex that hangs together is asked by solid angles; exact signs tell the others from it.
pub(super) fn behind(
    complex: &Complex,
    sides: &Sides,
    patches: &Patches<'_>,
    jump: &dyn Fn(&Uses) -> i32,
    run: &Run,
) -> Result<Vec<i32>> {
    let (n, patch, count) = (complex.triangles.len(), patches.of, patches.count);
    let center = |t: u32| complex.triangles[t as usize].iter().map(|v| complex.nodes[*v as usize]).sum::<DVec3>() / 3.0;
    let mut largest = vec![(0.0, u32::MAX); count];
    let corner = |t: u32| complex.triangles[t as usize].map(|v| complex.nodes[v as usize]);
    for t in 0..n as u32 {
        let [a, b, c] = corner(t);
        let area = (b - a).cross(c - a).length();
        let slot = &mut largest[patch[t as usize] as usize];
        if slot.1 == u32::MAX || area > slot.0 {
            *slot = (area, t);
        }
    }
    let bounding: Vec<(u32, i32)> =
        (0..n as u32).map(|t| (t, jump(&complex.uses[t as usize]))).filter(|b| b.1 != 0).collect();
    // Between two triangles that follow each other around an edge the number is one: patches that hang together need one
    // of them to be measured.
    let mut next: Vec<(u32, u32, i32)> = Vec::new();
    for e in sides.edges().filter(|e| e.iter().any(|s| patch[s.triangle()] != patch[e[0].triangle()])) {
        let [u, v] = ends(e[0].key);
        let around = turn_around(complex, u, v, e);
        for (i, s) in around.iter().enumerate() {
            let other = &around[(i + 1) % around.len()];
            // a triangle that runs u -> v is met at its back, left at its front
            let at_back = |s: &EdgeSide| directed(&complex.triangles, s.half) == [u, v];
            let steps = |s: &EdgeSide| jump(&complex.uses[s.triangle()]);
            let left = if at_back(s) { -steps(s) } else { 0 };
            let met = if at_back(other) { 0 } else { -steps(other) };
            let (p, q) = (patch[s.triangle()], patch[other.triangle()]);
            // behind[q] = behind[p] + difference
            next.extend([(p, q, left - met), (q, p, met - left)]);
        }
    }
    next.sort_unstable();
    next.dedup();
    let mut behind: Vec<Option<i32>> = vec![None; count];
    let mut stack = Vec::new();
    for seed in 0..count {
        if behind[seed].is_some() {
            continue;
        }
        run.check()?;
        let t = largest[seed].1;
        let p = center(t);
        let see = |b: &&(u32, i32)| b.0 != t;
        let mean: f64 = run
            .install(|| {
                bounding
                    .par_iter()
                    .filter(see)
                    .map(|(u, m)| f64::from(*m) * winding(corner(*u).map(|x| x - p)))
                    .collect::<Vec<f64>>()
            })
            .iter()
            .sum();
        behind[seed] = Some((mean + 0.5 * f64::from(jump(&complex.uses[t as usize]))).round() as i32);
        stack.push(seed as u32);
        while let Some(p) = stack.pop() {
            let from = next.partition_point(|x| x.0 < p);
            for (_, q, difference) in next[from..].iter().take_while(|x| x.0 == p) {
                if behind[*q as usize].is_none() {
                    behind[*q as usize] = behind[p as usize].map(|b| b + difference);
                    stack.push(*q);
                }
            }
        }
    }
    Ok((0..n).map(|t| behind[patch[t] as usize].unwrap_or(0)).collect())
}

/// The sides on an edge in the order in which they are met going around `u -> v` counter-clockwise.
pub(super) fn turn_around(complex: &Complex, u: u32, v: u32, e: &[EdgeSide]) -> Vec<EdgeSide> {
    let p = |v: u32| complex.nodes[v as usize];
    let apex = |s: &EdgeSide| p(complex.triangles[s.triangle()][(s.half as usize + 2) % 3]);
    let (a, b, zero) = (p(u), p(v), apex(&e[0]));
    let left = |x: DVec3, y: DVec3| -orient3d(a, b, x, y);
    // whether y lies on the same side of the edge as x, given that they are in one plane with it
    let towards = |x: DVec3, y: DVec3| (x - a).cross(b - a).dot((y - a).cross(b - a)) > 0.0;
    // 0: at the start, 1: first half turn, 2: opposite, 3: second half turn
    let half = |x: DVec3| {
        let s = left(zero, x);
        if s > 0.0 {
            1
        } else if s < 0.0 {
            3
        } else if towards(zero, x) {
            0
        } else {
            2
        }
    };
    let mut out = e.to_vec();
    out.sort_by(|s, t| {
        let (x, y) = (apex(s), apex(t));
        half(x).cmp(&half(y)).then_with(|| {
            let o = left(x, y);
            if o > 0.0 {
                Ordering::Less
            } else if o < 0.0 {
                Ordering::Greater
            } else {
                Ordering::Equal
            }
        })
    });
    out
}
