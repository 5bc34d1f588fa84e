//! Acute tips: around one a surface is thinner than the edges wanted there are long, and nodes on it would be across from each
//! other. The last ring of nodes that fits is joined to the tip by one fan of triangles, which stays.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::edges::{Lead, Sampled};
use super::sizes::SizeField;
use super::{MeshSizes, Parametric};
use crate::numeric::SEVEN_DIGITS;
use crate::parametric::chart::Chart;
use crate::parametric::surface::Pole;
use crate::run::Run;

/// Edges of a ring all around a tip.
const PARTS: f64 = 5.0;
/// A tip is acute where normals along a ring around it turn by more than this share of the angle that the ring has at the tip.
/// For cones these are the cosine and the sine of half the angle of opening: cones of up to 126 degrees are acute. Of a ring
/// that a face has a sector of both are the same share, and where the surface is smooth at the pole normals hardly turn.
const ACUTE: f64 = 0.51;
/// Samples around a tip.
const AROUND: usize = 24;
/// The search for the ring begins at this share of the way along the face,
const NEAREST: f64 = 1e-4;
/// goes on by this factor,
const FURTHER: f64 = 1.08;
/// and ends at this share.
const FARTHEST: f64 = 0.6;
/// How far the surface may be from a straight line to the tip, as a share of the ring's edges.
const STRAIGHT: f64 = 0.2;
/// Halvings of a way.
const HALVINGS: usize = 50;

/// Where the last nodes before a tip are.
#[derive(Debug, Clone, Copy)]
pub(super) struct TipRing {
    pub(super) pole: Pole,
    /// The parameter on the ring that is constant there.
    pub(super) at: f64,
    /// Edges of it per unit of the other parameter.
    pub(super) density: f64,
}

/// The rings of every face, and what leads to corners along each edge, as far as the rings at least.
pub(super) struct Ringed {
    pub(super) rings: Vec<Vec<TipRing>>,
    pub(super) leads: Vec<[Lead; 2]>,
}

impl TipRing {
    /// Whether parameters are between the ring and its tip.
    pub(super) fn holds(&self, uv: DVec2) -> bool {
        (uv[self.pole.axis] - self.pole.value) / (self.at - self.pole.value) < 1.0
    }
}

impl Parametric {
    /// The rings around tips, and `leads` that reach to them.
    pub(super) fn ringed(
        &self,
        sampled: &[Sampled],
        mut leads: Vec<[Lead; 2]>,
        field: &SizeField<'_>,
        sizes: &MeshSizes<'_>,
        run: &Run,
    ) -> Ringed {
        let rings = self.rings(sampled, field, sizes, run);
        self.reach_rings(&rings, sampled, &mut leads);
        Ringed { rings, leads }
    }

    /// The rings around the acute tips of every face.
    fn rings(&self, sampled: &[Sampled], field: &SizeField<'_>, sizes: &MeshSizes<'_>, run: &Run) -> Vec<Vec<TipRing>> {
        let of = |f: usize| {
            let chart = &self.charts[f];
            let around: Vec<DVec2> = match chart.poles[..] {
                [] => return Vec::new(),
                _ => {
                    let points =
                        self.brep.faces[f].loops.iter().flatten().flat_map(|c| &sampled[c.edge as usize].points);
                    points.map(|p| chart.project(*p)).collect()
                }
            };
            let wanted = |uv: DVec2, p: DVec3| {
                let own = (sizes.face_size)(f as u32).unwrap_or(f64::INFINITY);
                let bent = (sizes.size_at)(chart.curvature(uv).unwrap_or(0.0));
                field.at(p, own.min(bent))
            };
            chart.poles.iter().filter_map(|pole| ring(chart, *pole, &around, &wanted)).collect()
        };
        run.install(|| (0..self.charts.len()).into_par_iter().map(of).collect())
    }

    /// One edge reaches from a tip to its ring.
    fn reach_rings(&self, rings: &[Vec<TipRing>], sampled: &[Sampled], leads: &mut [[Lead; 2]]) {
        for (f, ring) in rings.iter().enumerate().flat_map(|(f, list)| list.iter().map(move |r| (f, r))) {
            let (chart, near) = (&self.charts[f], SEVEN_DIGITS * self.boxes[f].diagonal());
            for c in self.brep.faces[f].loops.iter().flatten() {
                let (edge, s) = (&self.brep.edges[c.edge as usize], &sampled[c.edge as usize]);
                for end in 0..2 {
                    if self.brep.vertices[edge.ends[end] as usize].distance(ring.pole.point) > near {
                        continue;
                    }
                    let (ways, last) = (s.ways(), s.points.len() - 1);
                    let from_end = |i: usize| if end == 0 { i } else { last - i };
                    let Some(i) = (1..=last).find(|&i| !ring.holds(chart.project(s.points[from_end(i)]))) else {
                        continue;
                    };
                    let (mut a, mut b) = (s.t[from_end(i - 1)], s.t[from_end(i)]);
                    for _ in 0..HALVINGS {
                        let m = 0.5 * (a + b);
                        if ring.holds(chart.project(edge.curve.at(m))) { a = m } else { b = m }
                    }
                    let before = s.points[from_end(i - 1)];
                    let way = (ways[from_end(i - 1)] - ways[from_end(0)]).abs() + before.distance(edge.curve.at(b));
                    let lead = &mut leads[c.edge as usize][end];
                    if way > lead.way {
                        *lead = Lead { way, width: 0.0 };
                    }
                }
            }
        }
    }
}

fn ring(chart: &Chart, pole: Pole, around: &[DVec2], wanted: &dyn Fn(DVec2, DVec3) -> f64) -> Option<TipRing> {
    let (axis, other) = (pole.axis, 1 - pole.axis);
    let offsets = around.iter().map(|uv| uv[axis] - pole.value);
    let [a, b] = chart.bounds[axis];
    let ends = [a, b].into_iter().filter(|_| around.is_empty()).map(|t| t - pole.value);
    let reach = offsets.chain(ends).filter(|x| x.is_finite()).max_by(|x, y| x.abs().total_cmp(&y.abs()))?;
    let range = match chart.periods[other] {
        Some(p) => [chart.bounds[other][0], chart.bounds[other][0] + p],
        None => chart.bounds[other],
    };
    if !(reach != 0.0 && (range[1] - range[0]).is_finite()) {
        return None;
    }
    let place = |s: f64, k: usize| {
        let mut uv = DVec2::ZERO;
        uv[axis] = pole.value + s;
        uv[other] = range[0] + (range[1] - range[0]) * k as f64 / AROUND as f64;
        uv
    };
    let mut share = NEAREST;
    while share < FARTHEST {
        let s = share * reach;
        let points: Vec<DVec3> = (0..=AROUND).map(|k| chart.at(place(s, k))).collect();
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let h = (0..AROUND).step_by(4).map(|k| wanted(place(s, k), points[k])).fold(f64::INFINITY, f64::min);
        if length >= h {
            let away = points.iter().map(|p| p.distance(pole.point)).fold(f64::INFINITY, f64::min);
            let (turn, angle) = (turn(&|k| chart.normal(place(s, k))), length / away);
            // Of a sector there are as many edges as it is a share of a whole cone.
            let parts = (PARTS * (turn.hypot(angle) / std::f64::consts::TAU).min(1.0)).round().max(1.0);
            if length >= parts * h {
                let bend = |k: usize| {
                    let chord = [pole.point, points[k]];
                    let middle = chart.at(place(0.5 * s, k));
                    middle.distance(crate::spatial::segment_foot(middle, chord))
                };
                let straight = (0..AROUND).step_by(4).all(|k| bend(k) <= STRAIGHT * h);
                let acute = share > NEAREST && turn > ACUTE * angle && straight;
                return acute.then(|| TipRing { pole, at: pole.value + s, density: parts / (range[1] - range[0]) });
            }
        }
        share *= FURTHER;
    }
    None
}

/// By how much normals turn from sample to sample along a ring, on the whole; samples without one are passed over.
fn turn(normal: &dyn Fn(usize) -> Option<DVec3>) -> f64 {
    let normals: Vec<DVec3> = (0..=AROUND).filter_map(normal).collect();
    normals.windows(2).map(|w| w[0].cross(w[1]).length().atan2(w[0].dot(w[1]))).sum()
}
