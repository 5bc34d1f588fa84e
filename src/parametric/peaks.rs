//! Boxes to rounding: the nodes of a mesh tell where faces and edges reach farthest along the axes, Newton's method how far.

use glam::{DVec2, DVec3};

use super::mesh::{FaceMeshes, Parametric};
use crate::geometry::NEWTON_STEPS;
use crate::spatial::Aabb;

/// Both ways along the axes.
fn ways() -> [DVec3; 6] {
    [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]
}

impl Parametric {
    /// A box around each face that has triangles: around its nodes, the farthest points of its edges, and those of its surface between
    /// nodes.
    pub(super) fn boxes(&self, made: &FaceMeshes) -> Vec<Aabb> {
        let mesh = &made.mesh;
        let mut of: Vec<Vec<u32>> = vec![Vec::new(); self.brep.faces.len()];
        mesh.labels.iter().zip(0..).for_each(|(face, t)| of[*face as usize].push(t));
        let edges: Vec<Aabb> = (0..self.brep.edges.len() as u32).map(|e| self.box_of_edge(e)).collect();
        let mut boxes = Vec::with_capacity(of.len());
        for (face, triangles) in of.iter().enumerate() {
            let nodes: Vec<u32> = triangles.iter().flat_map(|t| mesh.triangles[*t as usize]).collect();
            let place = |v: &u32| mesh.nodes[*v as usize];
            let mut around = Aabb::around(nodes.iter().map(place));
            if !triangles.is_empty() {
                let own = self.brep.faces[face].loops.iter().flatten();
                own.for_each(|c| around = around.union(&edges[c.edge as usize]));
            }
            for way in ways() {
                let farthest = nodes.iter().copied().max_by(|a, b| place(a).dot(way).total_cmp(&place(b).dot(way)));
                let Some(v) = farthest else { continue };
                let fan: Vec<[DVec3; 3]> = triangles
                    .iter()
                    .map(|t| mesh.triangles[*t as usize])
                    .filter(|t| t.contains(&v))
                    .map(|t| t.map(|v| mesh.nodes[v as usize]))
                    .collect();
                let peak = self.peak(face as u32, place(&v), way).filter(|q| is_below(&fan, *q, way));
                peak.iter().for_each(|q| around = around.union(&Aabb::around([*q])));
            }
            boxes.push(around);
        }
        boxes
    }

    /// The point of a face's surface that is farthest along a way, near a point that nearly is.
    fn peak(&self, face: u32, near: DVec3, way: DVec3) -> Option<DVec3> {
        let chart = self.charts.get(face as usize)?;
        let mut uv = chart.project(near);
        for _ in 0..NEWTON_STEPS {
            let [_, su, sv, suu, suv, svv] = chart.jet(uv);
            // In lengths along u and v, so that both count alike.
            let scale = DVec2::new(su.length(), sv.length());
            let slope = DVec2::new(su.dot(way), sv.dot(way)) / scale;
            let [a, b, c] = [
                suu.dot(way) / (scale.x * scale.x),
                suv.dot(way) / (scale.x * scale.y),
                svv.dot(way) / (scale.y * scale.y),
            ];
            let step = ascent(slope, [a, b, c])?;
            uv += step / scale;
        }
        let q = chart.at(uv);
        (q.is_finite() && q.dot(way) >= near.dot(way)).then_some(q)
    }

    /// A box around an edge: Newton's method from its farthest samples.
    fn box_of_edge(&self, edge: u32) -> Aabb {
        let (e, samples) = (&self.brep.edges[edge as usize], &self.samples[edge as usize]);
        let [first, last] = e.range;
        let mut around = Aabb::around(samples.iter().map(|s| s.1));
        for way in ways() {
            let Some(k) = (0..samples.len()).max_by(|a, b| samples[*a].1.dot(way).total_cmp(&samples[*b].1.dot(way)))
            else {
                continue;
            };
            let [lo, hi] = [samples[k.saturating_sub(1)].0, samples[(k + 1).min(samples.len() - 1)].0];
            let [lo, hi] = [lo.min(hi).max(first.min(last)), hi.max(lo).min(first.max(last))];
            let mut t = samples[k].0;
            for _ in 0..NEWTON_STEPS {
                let [_, rise, bend] = e.curve.jet(t);
                let next = t - rise.dot(way) / bend.dot(way);
                if !(bend.dot(way) < 0.0 && next.is_finite()) {
                    break;
                }
                t = next.clamp(lo, hi);
            }
            around = around.union(&Aabb::around([e.curve.at(t)]));
        }
        around
    }
}

/// Newton's step to where a height with this slope and these second derivatives is greatest; `None` where it rises to some side. Along what
/// is level there is none.
fn ascent(slope: DVec2, [a, b, c]: [f64; 3]) -> Option<DVec2> {
    let (middle, half) = (0.5 * (a + c), DVec2::new(0.5 * (a - c), b).length());
    let (low, high) = (middle - half, middle + half);
    // Along the top of a torus nothing falls, but by rounding.
    let level = f64::EPSILON.sqrt() * low.abs();
    if !(low < 0.0 && high <= level) {
        return None;
    }
    // The direction in which it falls most, and the one across.
    let angle = 0.5 * b.atan2(0.5 * (a - c));
    let across = DVec2::from_angle(angle);
    let along = across.perp();
    let steep = -along * (slope.dot(along) / low);
    Some(if high < -level { steep - across * (slope.dot(across) / high) } else { steep })
}

/// Whether a point is over triangles, seen along a way.
fn is_below(fan: &[[DVec3; 3]], q: DVec3, way: DVec3) -> bool {
    fan.iter().any(|t| {
        let side = |k: usize| (t[(k + 1) % 3] - t[k]).cross(q - t[k]).dot(way);
        let longest = (0..3).map(|k| t[k].distance_squared(t[(k + 1) % 3])).fold(0.0, f64::max);
        let sides = [0, 1, 2].map(side);
        let rounding = f64::EPSILON.sqrt() * longest;
        sides.iter().all(|s| *s >= -rounding) || sides.iter().all(|s| *s <= rounding)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_lead_to_the_top_and_stay_on_a_level_one() {
        // -(x - 1)^2 - 3 (y - 2)^2, turned: from the origin one step leads there.
        let way = DVec2::from_angle(0.3);
        let (p, q) = (way * 2.0, way.perp() * 6.0);
        let bend = [
            -(p.x * way.x + q.x * way.perp().x),
            -(p.x * way.y + q.x * way.perp().y),
            -(p.y * way.y + q.y * way.perp().y),
        ];
        let top = DVec2::new(1.0, 2.0);
        let slope = -DVec2::new(bend[0] * top.x + bend[1] * top.y, bend[1] * top.x + bend[2] * top.y);
        assert!(ascent(slope, bend).unwrap().distance(top) < 1e-12);
        // A ridge along x.
        assert_eq!(ascent(DVec2::new(0.0, 2.0), [0.0, 0.0, -2.0]).unwrap(), DVec2::new(0.0, 1.0));
        // A saddle has no top.
        assert!(ascent(DVec2::ZERO, [1.0, 0.0, -1.0]).is_none() && ascent(DVec2::ZERO, [0.0; 3]).is_none());
    }
}
