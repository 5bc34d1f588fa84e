//! Loops of a face in its parameter domain: unrolled over periods, with poles as lines.

use glam::{DVec2, DVec3};

use super::edges::DividedEdge;
use crate::parametric::brep::{Brep, Coedge, Edge};
use crate::parametric::chart::Chart;
use crate::parametric::surface::Pole;

/// Between two nodes parameters must not change by more than this share of a period; where they do, points between the
/// nodes are looked at.
const STRIDE: f64 = 0.3;
/// How often the part between two nodes is halved for that.
const HALVINGS: usize = 6;
/// Copies of the node of a pole along a whole period. With many of them edges to the pole run past nodes that are nearer to it.
pub(super) const POLE_COPIES: usize = 6;

/// A corner of a contour in the parameter domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    pub(super) uv: DVec2,
    pub(super) node: u32,
    /// The edge from this corner to the next one, `u32::MAX` where there is none (a cut, a pole).
    pub(super) edge: u32,
}

/// A closed contour; the face lies to its left. Where it winds around a periodic direction the last corner is not the
/// first again, but that many periods away.
#[derive(Debug, Clone, Default)]
pub(super) struct Contour {
    pub(super) corners: Vec<Corner>,
    /// How many periods the end is away from the start.
    pub(super) winding: [i32; 2],
}

/// One step of a loop in space: a node, its point, and the curve to the next node.
struct LoopStep<'a> {
    node: u32,
    point: DVec3,
    edge: u32,
    curve: &'a Edge,
    t: [f64; 2],
}

pub(super) struct Unroller<'a> {
    pub(super) brep: &'a Brep,
    pub(super) chains: &'a [DividedEdge],
    pub(super) points: &'a [DVec3],
    pub(super) chart: &'a Chart,
    /// Nodes nearer to a pole than this are on it.
    pub(super) near: f64,
}

impl Unroller<'_> {
    /// The contour of a loop. `forward` says whether the loop runs counter-clockwise in the parameter domain as it is.
    pub(super) fn contour(&self, edges: &[Coedge], forward: bool) -> Contour {
        let mut steps = Vec::new();
        for c in edges {
            let chain = &self.chains[c.edge as usize];
            let curve = &self.brep.edges[c.edge as usize];
            let n = chain.t.len() - 1;
            for k in 0..n {
                let (i, j) = if c.forward { (k, k + 1) } else { (n - k, n - k - 1) };
                let node = chain.nodes[i];
                let point = self.points[node as usize];
                steps.push(LoopStep { node, point, edge: c.edge, curve, t: [chain.t[i], chain.t[j]] });
            }
        }
        if !forward {
            // The same steps backwards: each carries the part to the step before it.
            let n = steps.len();
            let turned = (0..n).rev().map(|i| {
                let (s, before) = (&steps[i], &steps[(i + n - 1) % n]);
                let t = [before.t[1], before.t[0]];
                LoopStep { node: s.node, point: s.point, edge: before.edge, curve: before.curve, t }
            });
            steps = turned.collect();
        }
        self.unroll(steps)
    }

    fn pole_at(&self, p: DVec3) -> Option<&Pole> {
        self.chart.poles.iter().find(|q| q.point.distance(p) <= self.near)
    }

    fn unroll(&self, mut steps: Vec<LoopStep<'_>>) -> Contour {
        let poles: Vec<usize> = (0..steps.len()).filter(|&i| self.pole_at(steps[i].point).is_some()).collect();
        if poles.len() == steps.len() {
            return Contour::default();
        }
        if let Some(&first) = poles.first() {
            steps.rotate_left(first);
        }
        let mut out: Vec<Corner> = Vec::new();
        let mut last: Option<DVec2> = None;
        // Poles passed: index of the corner before, and the pole's step.
        let mut passed: Vec<(usize, usize)> = Vec::new();
        for (i, s) in steps.iter().enumerate() {
            if self.pole_at(s.point).is_some() {
                passed.push((out.len(), i));
                last = None;
                continue;
            }
            let uv = match last {
                None => self.chart.project(s.point),
                Some(l) => self.follow(&steps[i - 1], s.point, l, 0),
            };
            last = Some(uv);
            out.push(Corner { uv, node: s.node, edge: s.edge });
        }
        if passed.is_empty() {
            let (first, end) = (out[0].uv, out.len() - 1);
            let back = self.follow(&steps[end], steps[0].point, out[end].uv, 0);
            let winding = [0, 1].map(|k| match self.chart.periods[k] {
                Some(p) => ((back[k] - first[k]) / p).round() as i32,
                None => 0,
            });
            return Contour { corners: out, winding };
        }
        self.through_poles(&steps, out, &passed)
    }

    /// Parameters of `p`, reached from the step before it, which is at `from`.
    fn follow(&self, before: &LoopStep<'_>, p: DVec3, from: DVec2, depth: usize) -> DVec2 {
        self.follow_part(before, before.t, p, from, depth)
    }

    fn follow_part(&self, s: &LoopStep<'_>, t: [f64; 2], p: DVec3, from: DVec2, depth: usize) -> DVec2 {
        let uv = self.chart.project_near(p, from);
        let far = (0..2).any(|k| self.chart.periods[k].is_some_and(|q| (uv[k] - from[k]).abs() > STRIDE * q));
        if !far || depth >= HALVINGS {
            return uv;
        }
        let m = 0.5 * (t[0] + t[1]);
        let middle = self.follow_part(s, [t[0], m], s.curve.curve.at(m), from, depth + 1);
        self.follow_part(s, [m, t[1]], p, middle, depth + 1)
    }

    /// Puts poles between the runs of corners: the runs are moved by periods so that the domain lies to the left of the
    /// pole's line, on which the pole's node is repeated.
    fn through_poles(&self, steps: &[LoopStep<'_>], mut corners: Vec<Corner>, passed: &[(usize, usize)]) -> Contour {
        let count = corners.len();
        let mut lines: Vec<(usize, Vec<Corner>)> = Vec::new();
        let mut shift = DVec2::ZERO;
        for (k, &(at, step)) in passed.iter().enumerate() {
            let s = &steps[step];
            let Some(pole) = self.pole_at(s.point) else { continue };
            let along = 1 - pole.axis;
            // The corner before the pole and the one after it; the loop starts with a pole.
            let before = corners[(at + count - 1) % count].uv;
            let after = corners[at % count].uv;
            let side = if before[pole.axis] < pole.value { 1.0 } else { -1.0 };
            // Counter-clockwise: against u on top and along it below; along v on the right and against it on the left.
            let sense = if pole.axis == 1 { -side } else { side };
            let mut jump = after[along] - before[along];
            if let Some(p) = self.chart.periods[along] {
                let tiny = 1e-9 * p;
                jump = (sense * jump).rem_euclid(p);
                // The same line there and back is a seam: the face lies all around.
                if jump <= tiny || jump >= p - tiny {
                    jump = p;
                }
                jump *= sense;
            }
            if k > 0 {
                // Runs after the first pole's are moved; the first one closes the contour by itself.
                let end = passed.get(k + 1).map_or(count, |n| n.0);
                shift[along] = before[along] + jump - after[along];
                for c in &mut corners[at..end] {
                    c.uv[along] += shift[along];
                }
            }
            let mut line = Vec::new();
            let copies = match self.chart.periods[along] {
                Some(p) => ((POLE_COPIES as f64 * jump.abs() / p).ceil() as usize).max(1),
                None => POLE_COPIES / 2,
            };
            for c in 0..=copies {
                let mut uv = DVec2::ZERO;
                uv[pole.axis] = pole.value;
                uv[along] = before[along] + jump * c as f64 / copies as f64;
                line.push(Corner { uv, node: s.node, edge: if c == copies { s.edge } else { u32::MAX } });
            }
            if k == 0 {
                // The corner before the first pole is the last of all, which may still move: set below.
                lines.push((at, line));
            } else {
                lines.push((at, line));
            }
        }
        // The first pole's line starts at the end of the contour, where that is by now.
        if let Some((_, line)) = lines.first_mut()
            && let Some(pole) = self.pole_at(steps[passed[0].1].point)
        {
            let along = 1 - pole.axis;
            let end = corners[count - 1].uv[along];
            let start = corners[0].uv[along];
            let n = line.len() - 1;
            for (c, corner) in line.iter_mut().enumerate() {
                corner.uv[along] = end + (start - end) * c as f64 / n.max(1) as f64;
            }
        }
        let mut out = Vec::new();
        let mut next = lines.into_iter().peekable();
        for (i, c) in corners.into_iter().enumerate() {
            while let Some((_, line)) = next.next_if(|l| l.0 == i) {
                out.extend(line);
            }
            out.push(c);
        }
        next.for_each(|(_, line)| out.extend(line));
        Contour { corners: out, winding: [0, 0] }
    }
}
