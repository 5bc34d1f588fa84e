//! What is tried with faces that cannot be filled in their own domain, and what is told of it.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::edges::Borders;
use super::fill::{Filled, Unfilled};
use super::{FallbackStep, Parametric, Plan};
use crate::parametric::brep::Coedge;
use crate::parametric::chart::Chart;
use crate::parametric::frame::Frame;
use crate::parametric::surface::Surface;

/// Cosine of the angle up to which a surface may turn away from a plane its face is triangulated on.
const FACING: f64 = 0.3;

impl Parametric {
    /// The faces whose edges were divided more finely.
    pub(super) fn finer(&self, factor: &[usize]) -> Vec<(u32, FallbackStep, String)> {
        let halved = |f: &usize| self.brep.faces[*f].loops.iter().flatten().any(|c| factor[c.edge as usize] > 1);
        let why = || "edges crossed others in the parameter domain".to_string();
        (0..self.brep.faces.len()).filter(halved).map(|f| (f as u32, FallbackStep::FinerEdges, why())).collect()
    }

    /// Triangulates faces that failed on a plane through their border.
    pub(super) fn on_planes(
        &self,
        filled: &mut [Result<Filled, Unfilled>],
        plan: &Plan<'_>,
        steps: &mut Vec<(u32, FallbackStep, String)>,
    ) {
        let Borders { points, chains, .. } = plan.borders;
        for (f, made) in filled.iter_mut().enumerate() {
            let Err(why) = made else { continue };
            let Some(plane) = self.border_plane(f as u32, plan.borders) else { continue };
            let around = &self.boxes[f];
            let chart = Chart::new(Surface::Plane { frame: plane }, around);
            if let Ok(mut flat) = self.face_on(f as u32, &chart, None, plan, &FxHashSet::default()) {
                let own = &self.charts[f];
                flat.nodes.iter_mut().for_each(|p| *p = own.foot(*p));
                // A surface that turns away from the plane has no business on it.
                let border = self.brep.faces[f].loops.iter().flatten().flat_map(|c| &chains[c.edge as usize].nodes);
                let up = plane.z();
                let faces = |p: DVec3| own.normal_near(p).is_some_and(|n| n.dot(up) > FACING);
                let all = border.map(|v| points[*v as usize]).chain(flat.nodes.iter().copied());
                if all.into_iter().all(|p| p.is_finite() && faces(p)) {
                    steps.push((f as u32, FallbackStep::Plane, self.told(why)));
                    *made = Ok(flat);
                }
            }
        }
    }

    /// A plane across the longest loop of a face, its normal where the face's outer loop is counter-clockwise about it.
    fn border_plane(&self, f: u32, borders: &Borders) -> Option<Frame> {
        let Borders { points, chains, .. } = borders;
        let face = &self.brep.faces[f as usize];
        let area = |l: &[Coedge]| -> (DVec3, DVec3) {
            let mut nodes: Vec<DVec3> = Vec::new();
            for c in l {
                let chain = &chains[c.edge as usize].nodes;
                let at = |v: &u32| points[*v as usize];
                let n = chain.len() - 1;
                if c.forward {
                    nodes.extend(chain[..n].iter().map(at))
                } else {
                    nodes.extend(chain[1..].iter().rev().map(at))
                }
            }
            let o = nodes.first().copied().unwrap_or_default();
            let k = nodes.len();
            ((0..k).map(|i| (nodes[i] - o).cross(nodes[(i + 1) % k] - o)).sum::<DVec3>(), o)
        };
        let (sum, origin) =
            face.loops.iter().map(|l| area(l)).max_by(|a, b| a.0.length_squared().total_cmp(&b.0.length_squared()))?;
        let z = sum.try_normalize()? * if face.outward { 1.0 } else { -1.0 };
        Some(Frame::new(origin, z, None))
    }

    /// Why a face has no triangles, in words.
    pub(super) fn told(&self, why: &Unfilled) -> String {
        match why {
            Unfilled::Other(what) => what.clone(),
            Unfilled::Crossing(edges) => {
                let id = |e: &u32| format!("#{}", self.brep.edges[*e as usize].source);
                format!("its edges {} cross others", edges.iter().take(4).map(id).collect::<Vec<_>>().join(", "))
            }
        }
    }
}
